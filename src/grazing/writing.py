"""Files written whole or not at all."""

from __future__ import annotations

import os
import re
import socket
import stat
import tempfile
import time
import zlib
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from functools import partial
from pathlib import Path
from uuid import uuid4

from grazing.interrupt import held_back
from grazing.outcome import InputError
from grazing.paths import path_of, remedy

try:
    import fcntl
except ImportError:  # pragma: no cover  (Windows: the age decides)
    fcntl = None  # type: ignore[assignment]

#: The name of a file before it is complete: of which machine, and which one.
PARTIAL = re.compile(r"\.(?P<machine>[0-9a-f]{8})[0-9a-f]{24}\.partial")
#: Seconds after which what has not changed was left, where no lock tells.
OLD = 3600.0
#: Seconds for which another process may give files their names before we give up.
TURN = 30.0
_NEW = os.O_RDWR | os.O_CREAT | os.O_EXCL
_FOUND = os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_NOFOLLOW", 0)
_FOLDER = os.O_RDONLY | getattr(os, "O_DIRECTORY", 0)  # a pipe in place of one would be waited for
#: Whether a file is asked for with the rights that this process has now.
EFFECTIVE = os.access in os.supports_effective_ids


@contextmanager
def whole_file(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Give another name beside a file, and that file's own once what is written there is complete and on the disk.

    What is written has the rights of any new file. A link that has the name is replaced; what it leads to stays. What
    killed processes left half written in the folder is removed.

    Raises
    ------
    InputError
        If it cannot be written; what was there stays.
    """
    with whole_files([path]) as (part,):
        yield part


@contextmanager
def whole_files(paths: Sequence[str | os.PathLike[str]]) -> Iterator[list[Path]]:
    """Do what :func:`whole_file` does for files of one folder that belong together: all get their names, or none.

    Who writes the same files at the same time gives them before or after, not in between. Only a kill, or a power cut,
    between the first name and the last leaves some of each, until they are written again.

    Raises
    ------
    InputError
        If one cannot be written; what was there stays.
    """
    targets = [path_of(path) for path in paths]
    for target in targets:
        if os.path.isdir(target):
            raise InputError(f"{target} is a folder; give the name of a file")
        if kind := other_than_file(target):
            raise InputError(f"{target} is a {kind}, which a file would replace; give the name of a file")
    try:
        for target in targets:
            with suppress(FileNotFoundError):
                os.lstat(target)  # a name that is too long is said before anything is written
            if os.path.isfile(target) and not os.access(target, os.W_OK, effective_ids=EFFECTIVE):
                raise InputError(f"{target} is protected against writing; give another name")
        remove_left(targets[0].parent)
        with ExitStack() as stack:
            parts = [stack.enter_context(_part(target, 0o666)) for target in targets]
            yield parts
            for part in parts:
                with open(part, "rb+") as written:  # else a power cut can leave the name to nothing
                    os.fsync(written.fileno())
            _named(parts, targets)
    except OSError as error:
        names = ", ".join(map(str, targets))
        raise InputError(f"{names} cannot be written: {error.strerror or error}; {remedy(error)}") from error


def _named(parts: list[Path], targets: list[Path]) -> None:
    """Give files that are complete their names: several to all of them or to none."""
    if len(targets) == 1:
        os.replace(parts[0], targets[0])
        return
    with _in_turn(targets[0].parent, TURN), held_back(), ExitStack() as done, ExitStack() as undo:
        backs: list[Callable[[], object]] = []
        for target in targets:  # of all first: who is killed here leaves those before
            old = target.with_name(f".{_machine()}{uuid4().hex[8:]}.partial")
            done.callback(_unlink, old)
            try:
                os.link(target, old, follow_symlinks=False)
                backs.append(partial(os.replace, old, target))
            except FileNotFoundError:
                backs.append(partial(_unlink, target))
            except OSError:  # another user's, or a disk without links: it cannot be had back
                backs.append(lambda: None)
        for part, target, back in zip(parts, targets, backs, strict=True):
            os.replace(part, target)
            undo.callback(back)
        undo.pop_all()


def _unlink(file: Path) -> None:
    with suppress(OSError):
        file.unlink(missing_ok=True)


class _Taken(InputError):
    """Another process gives files their names."""


@contextmanager
def _in_turn(folder: Path, wait: float) -> Iterator[None]:
    """Let no other process give names in a folder meanwhile, where the system can tell."""
    if fcntl is None:  # pragma: no cover
        yield
        return
    try:
        handle = os.open(folder, _FOLDER)
    except PermissionError:  # a folder that is written to and not read
        yield
        return
    try:
        end = time.monotonic() + wait
        while _lock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB) is False:
            if time.monotonic() > end:
                raise _Taken(f"{folder} has been locked by another process for {wait:g} s; end it, or wait")
            time.sleep(0.01)
        yield
    finally:
        _lock(handle, fcntl.LOCK_UN)  # a process that was forked meanwhile has the handle too
        os.close(handle)


def other_than_file(path: str | os.PathLike[str]) -> str:
    """Return what has a name, or what a link leads to, if it is neither a file nor a folder nor nothing."""
    try:
        kind = stat.S_IFMT(os.stat(path).st_mode)
    except OSError:
        return ""
    return {stat.S_IFCHR: "device", stat.S_IFBLK: "device", stat.S_IFIFO: "pipe", stat.S_IFSOCK: "socket"}.get(kind, "")


def put(file: Path, content: bytes, mode: int) -> None:
    """Write a file whole or not at all, with these rights: several processes may be writing the same.

    Raises
    ------
    OSError
        If it cannot be written.
    """
    with _part(file, mode) as part:
        part.chmod(mode)
        part.write_bytes(content)
        part.replace(file)


def remove_left(folder: Path) -> None:
    """Remove the files in a folder that their writers have left half made, as far as they can be removed.

    None while files get their names there: those before them, which nobody locks, would be had back from such files.
    """
    with suppress(OSError, _Taken), _in_turn(folder, wait=0.0):
        for name in os.listdir(folder):
            if found := PARTIAL.fullmatch(name):
                with suppress(OSError):  # it has just got its name, or is another user's
                    _remove_if_left(folder / name, found["machine"])


@contextmanager
def _part(file: Path, mode: int) -> Iterator[Path]:
    """Give the name of a new file beside another one: locked while it is there, and gone afterwards."""
    made: list[tuple[str, int | None]] = []
    try:
        with held_back():
            made.append(_new(file, mode))
        yield Path(made[0][0])
    finally:
        for part, handle in made:
            try:
                os.unlink(part)  # at once: an interrupt comes between two calls of Python's own functions
            except OSError:
                pass
            finally:
                if handle is not None:
                    os.close(handle)


def _new(file: Path, mode: int) -> tuple[str, int | None]:
    """Make a new file beside another one, and lock it; what is open gets no other name where there are no locks."""
    while True:
        part = str(file.with_name(f".{_machine()}{uuid4().hex[8:]}.partial"))
        handle = os.open(part, _NEW, mode)
        if fcntl is None:  # pragma: no cover
            os.close(handle)
            return part, None
        _lock(handle, fcntl.LOCK_EX)
        if os.fstat(handle).st_nlink:
            return part, handle
        os.close(handle)  # another process was faster than the lock, and has removed it


def _remove_if_left(half: Path, machine: str) -> None:
    """Remove what is half made, if nobody makes it any more: the lock of its writer ends with it, on one machine."""
    if half.is_symlink():  # had a name that was given to a file; it has no lock, and who gives names has the folder's
        if machine == _machine() or is_left(half):
            half.unlink()
        return
    handle = os.open(half, _FOUND)
    try:
        free = None if fcntl is None else _lock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        if (free and machine == _machine()) or (free is not False and is_left(half)):
            half.unlink()
    finally:
        os.close(handle)


def is_left(half: Path) -> bool:
    """Say whether nobody writes something half made any more: it has not changed for an hour.

    By the clock of the disk, since machines differ in theirs; what is from the future was left by a wrong clock.
    """
    with tempfile.TemporaryFile(dir=half.parent) as probe:
        now = os.fstat(probe.fileno()).st_mtime
    return abs(now - half.lstat().st_mtime) > OLD


def _lock(handle: int, how: int) -> bool | None:
    """Lock a file: True if we have it now, False if another has it, None where the system cannot tell."""
    try:
        fcntl.flock(handle, how)
    except BlockingIOError:
        return False
    except OSError:  # a file system without locks
        return None
    return True


def _machine() -> str:
    """Return what tells this machine from others that write to the same disk."""
    return f"{zlib.crc32(socket.gethostname().encode()):08x}"
