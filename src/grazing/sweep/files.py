"""Files of a store: read without surprises, written whole or not at all."""

from __future__ import annotations

import hashlib
import os
import re
import shutil
import stat
from contextlib import suppress
from pathlib import Path
from uuid import uuid4

#: Length and SHA-256 of a file.
Print = tuple[int, str]
#: The name of a file before it is complete.
PARTIAL = re.compile(r"(?P<name>.+)\.[0-9a-f]{32}\.partial")
#: What documents of any form raise when they are read as those of a store.
MISFIT = (ValueError, TypeError, KeyError, AttributeError, IndexError, RecursionError, OverflowError)
#: Bytes of a file of metadata beyond which it is none.
LONGEST = 2**27
_READ = os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0) | getattr(os, "O_CLOEXEC", 0)
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
    path = root / key
    made = _make_folders(root, key)
    partial = path.with_name(f"{path.name}.{uuid4().hex}.partial")
    handle = os.open(partial, _NEW, 0o666)
    try:
        try:
            left = memoryview(content)
            while left:
                left = left[os.write(handle, left) :]
            if fsync:
                os.fsync(handle)
        finally:
            os.close(handle)
        os.replace(partial, path)
    except BaseException:
        with suppress(OSError):
            partial.unlink()
        raise
    if fsync:
        for folder in [path.parent, *made]:
            fsync_folder(folder)


def append_line(root: Path, key: str, line: str) -> None:
    """Append a line to a file below a folder, behind no link; nothing waits for a pipe that nobody reads.

    Raises
    ------
    OSError
        If it cannot be written.
    """
    _make_folders(root, key)
    more = getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_NOFOLLOW", 0)
    handle = os.open(root / key, os.O_WRONLY | os.O_APPEND | os.O_CREAT | more, 0o666)
    try:
        os.write(handle, f"{line}\n".encode())
    finally:
        os.close(handle)


def is_own(root: Path, key: str) -> bool:
    """Whether a folder is there below ``root``, and is no link, nor lies behind one."""
    here = root
    for part in key.split("/"):
        here = here / part
        if here.is_symlink() or not here.is_dir():
            return False
    return True


def is_plain(root: Path, key: str) -> bool:
    """Whether a file is there, in folders below ``root`` of which none is a link; nor is it one itself."""
    here = root
    for part in key.split("/")[:-1]:
        here = here / part
        if here.is_symlink():
            return False
    return not (root / key).is_symlink() and (root / key).is_file()


def clear_way(root: Path, key: str) -> None:
    """Remove what stands where a file and its folders belong: links, pipes, files for folders, folders for files."""
    here = root
    for part in key.split("/")[:-1]:
        here = here / part
        with suppress(FileNotFoundError):
            if not stat.S_ISDIR(os.lstat(here).st_mode):
                here.unlink()
    remove(root / key)


def remove_file(root: Path, key: str) -> None:
    """Remove what has a name below a folder, in folders of its own: nothing that lies behind a link.

    Raises
    ------
    OSError
        If it cannot be removed, or if there is a link in the way.
    """
    here = root
    for part in key.split("/")[:-1]:
        here = here / part
        try:
            if not stat.S_ISDIR(os.lstat(here).st_mode):
                raise _not_own(here)
        except FileNotFoundError:
            return
    remove(root / key)


def remove(path: Path) -> None:
    """Remove whatever has a name; nothing behind a link."""
    try:
        if stat.S_ISDIR(os.lstat(path).st_mode):
            shutil.rmtree(path)
        else:
            path.unlink()
    except (FileNotFoundError, NotADirectoryError):
        return


def _make_folders(root: Path, key: str) -> list[Path]:
    """Make the folders between; return those in which one was made."""
    made, here = [], root
    for part in key.split("/")[:-1]:
        above, here = here, here / part
        try:
            if not stat.S_ISDIR(os.lstat(here).st_mode):
                raise _not_own(here)
        except FileNotFoundError:
            with suppress(FileExistsError):  # another task was faster
                os.mkdir(here)
            made.append(above)
    return made


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
