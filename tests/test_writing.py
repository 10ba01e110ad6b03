"""Every file is written whole or not at all, by one writer."""

import contextlib
import os
import resource
import signal
import socket
import stat
from pathlib import Path

import pytest

import grazing as gz
from grazing.writing import whole_file
from tests.sweep.test_disks import as_nobody
from tests.writers import WRITERS

pytestmark = pytest.mark.parametrize(("ending", "write"), WRITERS.items())
posix = pytest.mark.skipif(os.name != "posix", reason="rights of POSIX")


@posix
def test_the_longest_name_that_a_folder_takes(tmp_path, ending, write):
    for name in ("x" * (255 - len(ending)), "é" * ((255 - len(ending)) // 2), "\udcff"):
        write(tmp_path / f"{name}{ending}")
        assert [path.name for path in tmp_path.iterdir()] == [f"{name}{ending}"]
        (tmp_path / f"{name}{ending}").unlink()


@posix
@pytest.mark.parametrize("mask", [0o077, 0o027, 0o002])
def test_a_file_has_the_rights_of_any_new_file(tmp_path, ending, write, mask):
    before = os.umask(mask)
    try:
        write(tmp_path / f"a{ending}")
    finally:
        os.umask(before)
    assert stat.S_IMODE((tmp_path / f"a{ending}").stat().st_mode) == 0o666 & ~mask


@pytest.mark.parametrize("call", ["fsync", "replace"])
@pytest.mark.parametrize("error", [KeyboardInterrupt, OSError(28, "No space left on device")], ids=["Ctrl-C", "full"])
def test_an_end_in_between_leaves_the_old_file_and_nothing_else(tmp_path, monkeypatch, ending, write, call, error):
    def ends(*_args, **_options):
        assert len(list(tmp_path.iterdir())) == 2
        raise error

    path = tmp_path / f"a{ending}"
    path.write_bytes(b"old")
    with monkeypatch.context() as patch, pytest.raises((KeyboardInterrupt, gz.InputError)):
        patch.setattr(os, call, ends)
        write(path)
    assert path.read_bytes() == b"old" and [file.name for file in tmp_path.iterdir()] == [path.name]


@posix
def test_a_limit_on_the_size_of_files(tmp_path, ending, write):
    """Wherever the writing ends, between any two pieces: the old file, and one sentence."""
    path = tmp_path / f"a{ending}"
    write(path)
    size, old = path.stat().st_size, path.read_bytes()
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    before = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    try:
        for share in (0.0, 0.01, 0.5, 0.99):
            resource.setrlimit(resource.RLIMIT_FSIZE, (int(share * size), hard))
            with pytest.raises(gz.InputError, match=r"cannot be written: .*(File too large|rite)"):
                write(path)
            assert path.read_bytes() == old and [file.name for file in tmp_path.iterdir()] == [path.name]
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
        signal.signal(signal.SIGXFSZ, before)


@posix
def test_what_its_owner_protects_stays(tmp_path, ending, write):
    path = Path(f"/tmp/{os.getpid()}-{tmp_path.name}{ending}")  # where everybody may write
    try:
        with as_nobody():
            write(path)
            old = path.read_bytes()
            path.chmod(0o444)
            with pytest.raises(gz.InputError, match="is protected against writing; give another name"):
                write(path)
        assert path.read_bytes() == old
    finally:
        path.unlink(missing_ok=True)


@posix
def test_a_link_is_replaced_and_what_it_leads_to_stays(tmp_path, ending, write):
    (tmp_path / "precious").write_text("precious")
    path = tmp_path / f"a{ending}"
    path.symlink_to(tmp_path / "precious")
    write(path)
    assert not path.is_symlink() and (tmp_path / "precious").read_text() == "precious"


@posix
def test_a_device_is_not_replaced(tmp_path, ending, write):
    # as the user root a command that wrote to /dev/null put a file in its place, for everybody
    device = tmp_path / f"null{ending}"
    try:
        os.mknod(device, stat.S_IFCHR | 0o666, os.makedev(1, 3))
    except PermissionError:
        pytest.skip("only the user root makes devices, and only where that is allowed")
    with pytest.raises(gz.InputError, match="is a device, which a file would replace"):
        write(device)
    assert stat.S_ISCHR(device.stat().st_mode) and [path.name for path in tmp_path.iterdir()] == [device.name]


@posix
@pytest.mark.parametrize("linked", [False, True])
def test_a_pipe_or_a_socket_is_not_replaced(tmp_path, ending, write, linked):
    """Whoever read from the pipe waited for ever."""
    pipe, socket_, link = tmp_path / f"pipe{ending}", tmp_path / f"s{ending}", tmp_path / f"link{ending}"
    os.mkfifo(pipe)
    with socket.socket(socket.AF_UNIX) as bound, contextlib.chdir(tmp_path):  # their names are short
        bound.bind(socket_.name)
    for path, said in ((pipe, "pipe"), (socket_, "socket")):
        link.symlink_to(path)
        with pytest.raises(gz.InputError, match=f"is a {said}, which a file would replace"):
            write(link if linked else path)
        link.unlink()
    assert stat.S_ISFIFO(pipe.stat().st_mode) and len(list(tmp_path.iterdir())) == 2


@posix
def test_what_a_killed_writer_left_is_removed_by_the_next(tmp_path, ending, write):
    """It stayed for ever, wherever a result is saved; that of a writer who is still at work stays."""
    read, at_work = os.pipe()
    children = []
    for name in ("killed", "at work"):
        if not (child := os.fork()):
            with whole_file(tmp_path / name) as part:
                part.write_text(name)
                os.write(at_work, b".")
                signal.pause()
        os.read(read, 1)
        children.append(child)
    os.kill(children[0], signal.SIGKILL)
    os.waitpid(children[0], 0)
    write(tmp_path / f"a{ending}")
    left = [path.read_text() for path in tmp_path.glob(".*.partial")]
    os.kill(children[1], signal.SIGKILL)
    os.waitpid(children[1], 0)
    assert left == ["at work"] and (tmp_path / f"a{ending}").stat().st_size
