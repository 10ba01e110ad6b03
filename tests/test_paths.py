"""Paths of every kind, to all that reads or writes: a sentence, never what some library makes of them."""

import io
import os
import stat
import tempfile
import threading
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest

import grazing as gz
from grazing import paths, sweep
from grazing.config import load_config
from grazing.explorer.server import copy_to
from grazing.paper.files import folder
from grazing.paths import opened
from grazing_checker import envelope
from tests.sweep.test_disks import as_nobody
from tests.writers import WRITERS

PLAN = gz.plans.density(gz.gap_map(lam=0.5, mu=0.1, l=0.1), "mu", np.linspace(0.0, 0.3, 2), starts=2)
READERS = {
    ".nc": gz.load, ".png": gz.plot.provenance, ".json": gz.check_certificate, ".toml": load_config,
}  # fmt: skip
STORES = {
    "run": lambda path: sweep.run(PLAN, path), "resume": lambda path: sweep.resume(path, PLAN), "status": sweep.status,
    "open": sweep.open_store, "verify": lambda path: sweep.verify(path, repair=True), "unlock": sweep.unlock,
}  # fmt: skip
USERS = (
    [(write, ending) for ending, write in WRITERS.items()]
    + [(read, ending) for ending, read in READERS.items()]
    + [(use, ".zarr") for use in STORES.values()]
    + [(copy_to, ""), (folder, "")]
)
NOT_NAMES = [3, None, b"bytes", ["l"], float("nan"), {}, True]
NAMES = ["a\0b", "\ud800", "n" * 300, "/" + "a/" * 3000 + "b", "loop/a", "file/a", "pipe/a", "missing/a/b", "a\n/b"]


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    os.symlink("loop", "loop")
    Path("file").write_text("")
    os.mkfifo("pipe")
    return tmp_path


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="POSIX links and pipes")
@pytest.mark.parametrize(("use", "ending"), USERS)
def test_what_no_file_can_be_called_is_a_sentence(here, use, ending):
    may_be_made = use in (copy_to, folder)
    for name in [*NOT_NAMES, *NAMES]:
        if may_be_made and name in NAMES[-2:]:
            continue
        with pytest.raises((gz.GrazingError, ValueError)) as said:
            use(name + ending if isinstance(name, str) else name)
        assert isinstance(said.value, gz.GrazingError) or type(said.value).__name__ == "Rejected", said.value
    assert {path.name for path in here.iterdir()} == {"loop", "file", "pipe"}


@pytest.mark.skipif(os.name != "posix", reason="names of 255 bytes")
@pytest.mark.parametrize(
    ("write", "ending"), [*((write, ending) for ending, write in WRITERS.items()), (STORES["run"], ".zarr")]
)
def test_a_name_that_is_too_long_is_no_fault_of_the_folder(tmp_path, write, ending):
    with pytest.raises(gz.InputError, match="too long; give a shorter name"):
        write(tmp_path / f"{'n' * 256}{ending}")
    assert not [*tmp_path.iterdir()]


def test_folders_that_cannot_be_entered():
    with tempfile.TemporaryDirectory() as name:
        place = Path(name)
        (place / "closed" / "in").mkdir(parents=True)
        (place / "closed").chmod(0)
        place.chmod(0o755)
        try:
            with as_nobody():
                for use, ending in USERS:
                    for way in ("closed", "closed/in"):
                        with pytest.raises((gz.GrazingError, ValueError), match=r"ermission denied|is no "):
                            use(place / way / f"a{ending}")
        finally:
            (place / "closed").chmod(0o700)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="POSIX pipes")
@pytest.mark.parametrize(("ending", "read"), READERS.items())
def test_a_file_that_becomes_a_pipe_behind_a_look_is_not_waited_for(tmp_path, monkeypatch, ending, read):
    path, look = tmp_path / f"a{ending}", os.stat
    WRITERS.get(ending, lambda path: path.write_text("study = 1"))(path)

    def swapping(name, **options):
        found = look(name, **options)
        if not isinstance(name, int) and Path(os.fsdecode(name)) == path and stat.S_ISREG(found.st_mode):
            path.unlink()
            os.mkfifo(path)
        return found

    def reading():
        with suppress(gz.GrazingError, ValueError):
            read(path)
        ended.set()

    ended = threading.Event()
    monkeypatch.setattr(os, "stat", swapping)
    threading.Thread(target=reading, daemon=True).start()
    if not ended.wait(20.0):
        os.close(os.open(path, os.O_RDWR))  # lets it go
        pytest.fail("it waits for the pipe")


@pytest.mark.parametrize(("ending", "read"), READERS.items())
def test_a_file_that_has_nothing_to_say_yet_is_not_read_as_one(tmp_path, monkeypatch, ending, read):
    """Such as the log of the kernel, which looks like a file and gives None: an unexpected error."""

    class Quiet(io.FileIO):
        def readinto(self, _room):
            return None

    path = tmp_path / f"a{ending}"
    path.write_text("a")

    def reading(path, *_mode, **_more):
        return io.BufferedReader(Quiet(path))

    for module in (paths, envelope):
        monkeypatch.setattr(module, "open", reading, raising=False)
    with pytest.raises((gz.InputError, envelope.Rejected)):
        read(path)


def test_what_is_open_is_what_was_looked_at(tmp_path):
    (tmp_path / "a").write_text("first")
    with opened(tmp_path / "a") as file:
        (tmp_path / "b").write_text("second")
        os.replace(tmp_path / "b", tmp_path / "a")
        assert file.read() == b"first"
    with pytest.raises(gz.InputError, match="Input/output"), opened(tmp_path / "a"):
        raise OSError(5, "Input/output error")
    with pytest.raises(gz.InputError, match=r"cannot be read: Is a directory"), opened(tmp_path):
        pass
