"""What is kept of compiled kernels: a damaged file costs a compilation, and one that others could write is not read."""

import os
import pickle
import random
import shutil
import sys
import tempfile
import warnings
from pathlib import Path
from types import ModuleType

import pytest
from numba.core import config, environment

from grazing.kernel import compile as compiling
from grazing.kernel import disk
from grazing.kernel.compile import compiled
from tests.kernel.kept import SOURCE, fresh
from tests.sweep.test_disks import as_nobody


@pytest.fixture
def kept(folder):
    """The one file of a kernel that was compiled and found again."""
    assert fresh()(3.0) == 7.0
    again = fresh()
    assert again(3.0) == 7.0 and sum(again.stats.cache_hits.values()) == 1
    (file,) = folder.iterdir()
    return file


def heals(file):
    """The number is right, one line says that the file is not used, and the next process finds a whole one."""
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        assert fresh()(3.0) == 7.0
    assert len(said) == 1 and "\n" not in str(said[0].message)
    assert "cannot be used" in str(said[0].message) and "it is compiled again" in str(said[0].message)
    again = fresh()
    assert again(3.0) == 7.0 and sum(again.stats.cache_hits.values()) == 1
    assert [each.name for each in file.parent.iterdir()] == [file.name]
    return str(said[0].message)


def test_any_damage_costs_a_compilation_and_no_more(kept):
    """Cut anywhere, filled with zeros, longer, any one bit flipped: a flipped bit of machine code would run."""
    whole, chance = kept.read_bytes(), random.Random(1)
    lengths = {0, 1, len(disk.MAGIC), len(disk.MAGIC) + 31, len(whole) // 2, len(whole) - 1}
    damaged = [whole[:length] for length in lengths] + [bytes(len(whole)), whole + b"\0", b"\x80\x04", whole[1:]]
    for _ in range(12):
        place, bit = chance.randrange(len(whole)), chance.randrange(8)
        damaged.append(whole[:place] + bytes([whole[place] ^ 1 << bit]) + whole[place + 1 :])
    for content in damaged:
        kept.write_bytes(content)
        assert "it is damaged" in heals(kept)


def test_code_that_the_compiler_was_told_to_make_otherwise_is_never_taken_for_its_own(kept, monkeypatch):
    """A process with NUMBA_OPT=0 left its code, slow and of other last digits, to all others; no sweep named it."""

    def hits():
        entry = fresh()
        assert entry(3.0) == 7.0
        return sum(entry.stats.cache_hits.values())

    where = {compiling.processor.__wrapped__()}
    for name, value in (("OPT", type(config.OPT)(0)), ("BOUNDSCHECK", 1), ("SLP_VECTORIZE", 1)):
        with monkeypatch.context() as told:
            told.setattr(config, name, value)
            assert (hits(), hits()) == (0, 1)
            where.add(compiling.processor.__wrapped__())
    assert hits() == 1
    with monkeypatch.context() as told:
        told.setenv("NUMBA_DISABLE_JIT", "1")
        where.add(compiling.processor.__wrapped__())
    assert len(where) == 5


def test_what_killed_processes_have_left_half_written_is_removed(kept):
    """It stayed for ever, a megabyte each time."""
    half, fresh_half, other = (
        kept.with_name(f".{i * 32}{rest}") for i, rest in (("a", ".partial"), ("b", ".partial"), ("c", ""))
    )
    for file in (half, fresh_half, other):
        file.write_bytes(b"half")
    os.utime(half, (1e9, 1e9))
    os.utime(other, (1e9, 1e9))
    kept.unlink()
    assert fresh()(3.0) == 7.0
    assert {each.name for each in kept.parent.iterdir()} == {kept.name, fresh_half.name, other.name}


@pytest.mark.skipif(not hasattr(os, "fork"), reason="processes")
def test_processes_that_keep_the_same_kernel_at_once_never_read_half_of_it(tmp_path):
    """Two write it in turn, as those that compile it at the same time, while this one reads it: all of it or none."""
    files, whole = disk.KernelFiles(tmp_path, "k"), {i: bytes([i]) * 10**6 for i in range(2)}
    files.save("key", whole[0])  # numba is imported before the fork
    writers = []
    for content in whole.values():
        writers.append(os.fork())
        if not writers[-1]:
            for _ in range(200):
                files.save("key", content)
            os._exit(0)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            assert all(files.load("key") in whole.values() for _ in range(200))
    finally:
        assert [os.waitpid(each, 0)[1] for each in writers] == [0, 0]
    assert [each.name for each in tmp_path.iterdir()] == [files.called("key")]


def test_a_file_that_nobody_wrote_to_its_end_is_not_read(kept):
    """It was read into memory, a hole of any size."""
    os.truncate(kept, disk.LARGEST + 1)
    assert "it is larger than 67108864 bytes" in heals(kept)


class Marker:
    """What runs when it is unpickled."""

    def __init__(self, file):
        self.file = file

    def __reduce__(self):
        return open, (str(self.file), "w")


def test_a_pickle_that_we_did_not_write_is_not_opened(kept, tmp_path):
    kept.write_bytes(pickle.dumps(Marker(tmp_path / "ran")))
    assert "it is damaged" in heals(kept)
    assert not (tmp_path / "ran").exists()


def test_the_file_of_another_python_is_not_taken_for_one_of_this(kept, monkeypatch):
    """The bytecode of short kernels is that of 3.11 and 3.12; their machine code calls into one of these."""
    monkeypatch.setattr("grazing.kernel.cache.EXTENSION_SUFFIXES", [".cpython-312-x86_64-linux-gnu.so"])
    assert fresh()(3.0) == 7.0
    assert kept.exists() and len(list(kept.parent.iterdir())) == 2


def test_the_file_of_another_kernel_is_not_taken_for_this_one(kept):
    assert fresh(5.0)(3.0) == 16.0
    (other,) = (file for file in kept.parent.iterdir() if file != kept)
    shutil.move(other, kept)
    assert "it is damaged" in heals(kept)


@pytest.mark.parametrize("kind", ["folder", "full folder", "link", "pipe", "broken link"])
def test_something_else_in_the_place_of_the_file(kept, kind, tmp_path):
    whole = kept.read_bytes()
    kept.unlink()
    if "folder" in kind:
        kept.mkdir()
    if kind == "full folder":
        (kept / "mine").write_text("")
        with pytest.warns(RuntimeWarning) as said:
            assert fresh()(3.0) == 7.0
        assert ["cannot be used" in str(one.message) for one in said] == [True, False]
        assert "could not be kept" in str(said[1].message)
        return
    if kind == "pipe":
        os.mkfifo(kept)  # to open it as a file would wait for ever
    if "link" in kind:
        (tmp_path / "elsewhere").write_bytes(whole)
        kept.symlink_to(tmp_path / ("elsewhere" if kind == "link" else "nowhere"))
    heals(kept)


@pytest.mark.parametrize("mode", [0o620, 0o602, 0o666])
def test_a_file_that_others_could_write_is_not_read(kept, mode):
    kept.chmod(mode)
    assert "others can write to it" in heals(kept)
    assert not kept.stat().st_mode & 0o077


def test_a_file_of_another_user_is_not_read(kept, monkeypatch):
    monkeypatch.setattr(disk, "_ours", lambda found: False)
    with pytest.warns(RuntimeWarning, match=r"it belongs to user \d+\); it is compiled again"):
        assert fresh()(3.0) == 7.0
    if os.getuid() == 0:  # a real one
        monkeypatch.undo()
        files = disk.KernelFiles(kept.parent, "theirs")
        file = kept.parent / files.called("key")
        file.write_bytes(b"")
        os.chown(file, 12345, 12345)
        with pytest.warns(RuntimeWarning, match="it belongs to user 12345"):
            assert disk.KernelFiles(kept.parent, "theirs").load("key") is None


@pytest.mark.parametrize("mode", [0o770, 0o707, 0o777, 0o1777])
def test_a_chosen_folder_that_others_could_write_is_not_used(folder, mode, tmp_path, monkeypatch):
    monkeypatch.setattr(disk.tempfile, "tempdir", str(tmp_path))
    folder.chmod(mode)
    with pytest.warns(
        RuntimeWarning, match=r"kept \(others can write to it: chmod go-w\); they go to .*grazing-"
    ) as said:
        assert fresh()(3.0) == 7.0
    assert len(said) == 1 and not list(folder.iterdir())
    assert list(tmp_path.glob("grazing-*/*.nbc"))


def test_a_folder_below_one_that_others_could_write_is_not_used(tmp_path, monkeypatch):
    (tmp_path / "open" / "kept").mkdir(parents=True)
    (tmp_path / "open" / "kept").chmod(0o700)
    (tmp_path / "open").chmod(0o777)
    assert disk.others_can_write(tmp_path / "open" / "kept") == f"others can write to {tmp_path / 'open'}"
    (tmp_path / "open").chmod(0o1777)  # as /tmp: they can write there, and not touch what is ours
    assert disk.others_can_write(tmp_path / "open" / "kept") == ""


def test_a_folder_of_another_user_is_not_used(folder, tmp_path, monkeypatch):
    monkeypatch.setattr(disk.tempfile, "tempdir", str(tmp_path))
    if os.getuid() == 0:
        os.chown(folder, 12345, 12345)
    else:
        monkeypatch.setattr(disk, "_ours", lambda found: found.st_ino != folder.stat().st_ino)
    with pytest.warns(RuntimeWarning, match=r"it belongs to user \d+\); they go to"):
        assert disk.cache_folder().parent == tmp_path


def test_a_new_folder_is_closed_to_others(tmp_path, monkeypatch):
    monkeypatch.setenv("GRAZING_CACHE", str(tmp_path / "a" / "b"))
    disk.folders.cache_clear()
    before = os.umask(0o002)
    try:
        assert disk.cache_folder() == tmp_path / "a" / "b"
    finally:
        os.umask(before)
        disk.folders.cache_clear()
    assert (tmp_path / "a" / "b").stat().st_mode & 0o777 == 0o700


def test_a_relative_folder_stays_where_it_was_when_the_process_goes_elsewhere(tmp_path, monkeypatch):
    """Else kernels would be read from whatever folder has that name in the next place."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("GRAZING_CACHE", "kept")
    disk.folders.cache_clear()
    found = disk.cache_folder()
    monkeypatch.setenv("GRAZING_CACHE", "")
    monkeypatch.setenv("XDG_CACHE_HOME", "relative")
    monkeypatch.setattr(os.path, "expanduser", lambda path: path)  # a user without a home
    monkeypatch.setattr(disk.tempfile, "tempdir", str(tmp_path))
    disk.folders.cache_clear()
    with pytest.warns(RuntimeWarning, match="this user has no home"):
        fallback = disk.cache_folder()
    disk.folders.cache_clear()
    assert found == tmp_path / "kept" and fallback.parent == tmp_path
    assert {path.name for path in tmp_path.iterdir()} == {"kept", fallback.name}


@pytest.mark.parametrize("fallback", [False, True])
def test_a_link_that_leads_elsewhere_later_is_not_followed(fallback, tmp_path, monkeypatch):
    """Whoever can write where the link is chose the folder into which a process writes."""
    link, places = tmp_path / "link", [tmp_path / "here", tmp_path / "elsewhere"]
    for place in places:
        place.mkdir(mode=0o700)
    link.symlink_to(places[0])
    monkeypatch.setenv("GRAZING_CACHE", str(link))
    monkeypatch.setattr(disk.tempfile, "tempdir", str(link))
    disk.folders.cache_clear()
    found = disk._private_folder() if fallback else disk.cache_folder()
    disk.folders.cache_clear()
    link.unlink()
    link.symlink_to(places[1])
    disk.KernelFiles(found, "k").save("key", 1)
    assert [len(list(place.rglob("*.nbc"))) for place in places] == [1, 0]


def test_a_linked_fallback_is_not_used(tmp_path, monkeypatch):
    monkeypatch.setattr(disk.tempfile, "tempdir", str(tmp_path))
    (tmp_path / "elsewhere").mkdir(mode=0o700)
    (tmp_path / f"grazing-{os.getuid()}").symlink_to(tmp_path / "elsewhere")
    assert disk._private_folder() not in (tmp_path / f"grazing-{os.getuid()}", tmp_path / "elsewhere")


@pytest.mark.parametrize("relative", [False, True])
def test_where_nothing_can_be_kept_kernels_are_compiled(relative, tmp_path, monkeypatch):
    """Without a temporary folder, or in a folder that is gone, the first kernel ended with an error of the system."""

    def none(*_given, **_names):
        raise FileNotFoundError(2, "No usable temporary directory found")

    (tmp_path / "file").touch()
    monkeypatch.setenv("GRAZING_CACHE", "kept" if relative else str(tmp_path / "file"))
    monkeypatch.setattr(disk.tempfile, "gettempdir", none)
    monkeypatch.setattr(disk.tempfile, "mkdtemp", none)
    if relative:
        monkeypatch.setattr(disk.os, "getcwd", none)
    disk.folders.cache_clear()
    try:
        with pytest.warns(RuntimeWarning, match="cannot be kept in .*: every process makes its own") as said:
            again = fresh(2.5), fresh(2.5)
            assert [entry(3.0) for entry in again] == [8.5, 8.5]
        assert len(said) == 1 and not sum(again[1].stats.cache_hits.values())
    finally:
        disk.folders.cache_clear()


def test_a_folder_that_can_only_be_read_is_read(kept, tmp_path, monkeypatch):
    """As in a container: every process compiled anew, or into a temporary folder, what was there."""

    def refused(**_given):
        raise OSError(30, "Read-only file system")

    monkeypatch.setattr(disk.tempfile, "tempdir", str(tmp_path))
    monkeypatch.setattr(disk.tempfile, "TemporaryFile", refused)
    disk.folders.cache_clear()
    with pytest.warns(RuntimeWarning) as said:
        found = [fresh(), fresh(5.0), fresh(5.0)]
        assert [entry(3.0) for entry in found] == [7.0, 16.0, 16.0]
    (line,) = (str(one.message) for one in said)
    assert "kept (Read-only file system); those in it are used, new ones go to" in line
    assert [sum(entry.stats.cache_hits.values()) for entry in found] == [1, 0, 1]
    assert [file.name for file in kept.parent.iterdir()] == [kept.name]
    os.chmod(kept, 0o622)  # not by anybody's hand
    with pytest.warns(RuntimeWarning, match=r"others can write to it\); it is compiled again"):
        assert fresh()(3.0) == 7.0


@pytest.mark.skipif(os.name != "posix", reason="rights of POSIX")
def test_a_folder_that_cannot_be_entered_is_not_said_to_be_read(monkeypatch):
    """The warning said that the kernels in it were used."""
    with tempfile.TemporaryDirectory() as name:  # one that others may enter
        shut, other = Path(name, "shut"), Path(name, "other")
        for folder, mode in ((Path(name), 0o755), (shut, 0o600), (other, 0o1777)):
            folder.mkdir(exist_ok=True)
            folder.chmod(mode)
        monkeypatch.setenv("GRAZING_CACHE", str(shut))
        monkeypatch.setattr(disk.tempfile, "tempdir", str(other))
        disk.folders.cache_clear()
        with as_nobody(), pytest.warns(RuntimeWarning, match=r"shut \(Permission denied\); they go to .*other"):
            fallback, read = disk.folders()
        assert read is None and fallback.parent == other
        disk.folders.cache_clear()


def test_nothing_else_reads_pickles_of_kernels():
    """The index of numba, a pickle beside every kernel that was read before anything was checked, is gone."""
    assert "IndexDataCacheFile" not in Path(compiling.__file__).read_text()


def test_equal_code_of_a_module_that_is_gone_is_found(folder, monkeypatch):
    """A kernel of a notebook or of a file of one's own is kept for whoever has the same one."""
    for name in ("notebook_of_yesterday", "notebook_of_today"):
        monkeypatch.setitem(sys.modules, name, ModuleType(name))
        names = {"__name__": name}
        exec(SOURCE.format(factor=3.0), names)
        entry = compiled(names["outer"])
        assert entry(2.0) == 7.0
        assert sum(entry.stats.cache_hits.values()) == (1 if name.endswith("today") else 0)
        monkeypatch.delitem(sys.modules, name)
        environment.Environment._memo.clear()  # as in another process
