"""Files of a store: read without surprises, written whole or not at all."""

from __future__ import annotations

import errno
import hashlib
import os
import re
import shutil
import stat
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from uuid import uuid4

#: Length and SHA-256 of a file.
Print = tuple[int, str]
#: The name of a file before it is complete.
PARTIAL = re.compile(r"(?P<name>.+)\.[0-9a-f]{32}\.partial")
#: What documents of any form raise when they are read as those of a store.
MISFIT = (ValueError, TypeError, KeyError, AttributeError, IndexError, RecursionError, OverflowError)
#: How often a folder is removed in which names go away in the meantime.
TRIES = 100
#: Bytes of a file of metadata beyond which it is none: JSON takes twenty times as much in memory.
LONGEST = 2**24
_READ = os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0) | getattr(os, "O_CLOEXEC", 0)
_HANDLES = os.open in os.supports_dir_fd
_FOLDER = os.O_RDONLY | getattr(os, "O_DIRECTORY", 0) | getattr(os, "O_CLOEXEC", 0)
_APPEND = os.O_WRONLY | os.O_APPEND | os.O_CREAT | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_NOFOLLOW", 0)
_NEW = os.O_WRONLY | os.O_CREAT | os.O_EXCL | getattr(os, "O_BINARY", 0) | getattr(os, "O_CLOEXEC", 0)


def is_name(text: object) -> bool:
    """Whether a text can be the name of an array: of one folder below the store, which no terminal takes for more."""
    return isinstance(text, str) and text.isprintable() and bool(text) and not (text[0] == "." or {*text} & {*"/\\ "})


def print_of(content: bytes) -> Print:
    """Return length and SHA-256."""
    return len(content), hashlib.sha256(content).hexdigest()


def read_file(path: str | os.PathLike[str], longest: int = LONGEST) -> bytes:
    """Return the bytes of a file; a pipe, a device or a folder is none, and nothing waits for it.

    Raises
    ------
    OSError
        If it cannot be read.
    ValueError
        If it is no file, or longer than it can be.
    """
    handle = os.open(path, _READ)
    try:
        known = os.fstat(handle)
        if not stat.S_ISREG(known.st_mode):
            raise ValueError("it is not a file")
        if known.st_size > longest:
            raise ValueError(f"it has {known.st_size} bytes, more than it can have")
        parts, left = [], known.st_size
        while left and (part := os.read(handle, left)):
            parts.append(part)
            left -= len(part)
        return b"".join(parts)
    finally:
        os.close(handle)


def write_file(root: Path, key: str, content: bytes, fsync: bool = False) -> None:
    """Write a file below a folder under another name, and give it its own when it is complete.

    Folders between are made, the uppermost is not: a store that was removed is not made again. None of them may be a
    link, behind which something else would be written.

    Raises
    ------
    OSError
        If it cannot be written.
    """
    made: list[Path] = []
    with _opened(root, key, made) as (where, name):
        partial = f"{name}.{uuid4().hex}.partial"
        try:
            handle = os.open(partial, _NEW, 0o666, dir_fd=where)
            try:
                left = memoryview(content)
                while left:
                    left = left[os.write(handle, left) :]
                if fsync:
                    os.fsync(handle)
            finally:
                os.close(handle)
            os.replace(partial, name, src_dir_fd=where, dst_dir_fd=where)
        except BaseException:
            with suppress(OSError):
                os.unlink(partial, dir_fd=where)
            raise
    if fsync:
        for folder in [(root / key).parent, *made]:
            fsync_folder(folder)


def append_line(root: Path, key: str, line: str) -> None:
    """Append a line to a file below a folder, behind no link; nothing waits for a pipe that nobody reads.

    Raises
    ------
    OSError
        If it cannot be written.
    """
    content = f"{line}\n".encode()
    with _opened(root, key, []) as (where, name):
        handle = os.open(name, _APPEND, 0o666, dir_fd=where)
        try:
            known = os.fstat(handle)
            if stat.S_ISREG(known.st_mode) and known.st_nlink == 1:
                os.write(handle, content)
                return
        finally:
            os.close(handle)
    # a second name of somebody's file, as in a copy made of hard links: that one stays as it is
    write_file(root, key, (read_file(root / key) if stat.S_ISREG(known.st_mode) else b"") + content)


def is_own(root: Path, key: str) -> bool:
    """Whether a folder is there below ``root``, and is no link, nor lies behind one."""
    here = root
    for part in key.split("/"):
        here = here / part
        if os.path.islink(here) or not os.path.isdir(here):
            return False
    return True


def is_plain(root: Path, key: str) -> bool:
    """Whether a file is there, in folders below ``root`` of which none is a link; nor is it one itself."""
    here = root
    for part in key.split("/")[:-1]:
        here = here / part
        if os.path.islink(here):
            return False
    return not os.path.islink(root / key) and os.path.isfile(root / key)


def clear_way(root: Path, key: str) -> None:
    """Remove what stands where a file and its folders belong: links, pipes, files for folders, folders for files."""
    _clear_folders(root, key)
    remove_file(root, key)


def _clear_folders(root: Path, key: str) -> None:
    parts = key.split("/")
    for i in range(1, len(parts)):
        with suppress(FileNotFoundError), _opened(root, "/".join(parts[:i])) as (where, name):
            if not stat.S_ISDIR(os.lstat(name, dir_fd=where).st_mode):
                os.unlink(name, dir_fd=where)


@dataclass(frozen=True)
class Place:
    """An open folder, in which files are found by name whatever link takes its own name in the meantime.

    Without a ``handle``, where the system has none for folders, names are whole paths.
    """

    path: Path
    handle: int | None

    def called(self, name: str) -> str:
        """Return what the system calls a file here."""
        return name if self.handle is not None else str(self.path / name)

    def names(self, ending: str) -> list[str]:
        """Return the names that end so."""
        return sorted(
            name for name in os.listdir(self.path if self.handle is None else self.handle) if name.endswith(ending)
        )

    def open(self, name: str, flags: int) -> int:
        """Open a file, behind no link; nothing waits for a pipe."""
        flags |= getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0)
        return os.open(self.called(name), flags, 0o666, dir_fd=self.handle)

    def look(self, name: str) -> os.stat_result | None:
        """Return what is known of a file, or of a link itself; None if there is none."""
        try:
            return os.lstat(self.called(name), dir_fd=self.handle)
        except FileNotFoundError:
            return None

    def remove(self, name: str) -> None:
        """Remove whatever has a name; nothing behind a link. Another process may be removing it, or what is in it."""
        for _again in range(TRIES):
            known = self.look(name)
            with suppress(FileNotFoundError):
                if known is not None and stat.S_ISDIR(known.st_mode):
                    shutil.rmtree(self.called(name), dir_fd=self.handle)
                elif known is not None:
                    os.unlink(self.called(name), dir_fd=self.handle)
                return


@contextmanager
def place(root: Path, key: str, make: bool = False) -> Iterator[Place]:
    """Give an open folder below a folder, which lies behind no link.

    Parameters
    ----------
    root : path
        Is not made: a store that was removed is not made again.
    key : str
    make : bool
        Make it if it is missing, and remove what a hand has put in its place.

    Raises
    ------
    OSError
        If it is missing, is no folder of its own, or cannot be made.
    """
    if make:
        _clear_folders(root, f"{key}/file")
    with _opened(root, f"{key}/file", [] if make else None) as (handle, _name):
        yield Place(root / key, handle)


def remove_file(root: Path, key: str) -> None:
    """Remove what has a name below a folder, in folders of its own: nothing that lies behind a link.

    Raises
    ------
    OSError
        If it cannot be removed, or if there is a link in the way.
    """
    with suppress(FileNotFoundError), _opened(root, key) as (where, name):
        Place((root / key).parent, where).remove(name)


@contextmanager
def _opened(root: Path, key: str, made: list[Path] | None = None) -> Iterator[tuple[int | None, str]]:
    """Give the open folder of a file and its name there; folders are made if ``made`` is a list, which gets them.

    What is done there is done in this very folder, whatever link somebody puts into its place in the meantime. A
    system without such handles gives None and the whole path.
    """
    *folders, name = key.split("/")
    if not _HANDLES:  # pragma: no cover  (Windows, where links need rights)
        here = root
        for part in folders:
            if made is not None and not here.joinpath(part).exists():
                made.append(here)
                here.joinpath(part).mkdir(exist_ok=True)
            here = here / part
            if not stat.S_ISDIR(os.lstat(here).st_mode):
                raise _not_own(here)
        yield None, str(here / name)
        return
    here, handle = root, os.open(root, _FOLDER)
    try:
        for part in folders:
            if made is not None:
                with suppress(FileExistsError):  # it is there, or another task was faster
                    os.mkdir(part, dir_fd=handle)
                    made.append(here)
            here = here / part
            try:
                inner = os.open(part, _FOLDER | os.O_NOFOLLOW, dir_fd=handle)
            except OSError as error:
                if error.errno in (errno.ELOOP, errno.ENOTDIR, errno.EMLINK):
                    raise _not_own(here) from None
                raise
            outer, handle = handle, inner  # before it is closed: Ctrl-C may come between, and closes no number twice
            os.close(outer)
        yield handle, name
    finally:
        os.close(handle)


def _not_own(folder: Path) -> NotADirectoryError:
    return NotADirectoryError(20, f"{folder} is not a folder of its own; sweep.verify(repair=True) removes it")


def fsync_folder(folder: Path) -> None:
    """Force the names in a folder to the disk, where the system can."""
    with suppress(OSError):
        handle = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)
