"""Files written whole or not at all."""

from __future__ import annotations

import os
import re
import stat
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from uuid import uuid4

from grazing.outcome import InputError
from grazing.paths import path_of

#: What is left of a file whose writer was killed.
PARTIAL = re.compile(r"\.[0-9a-f]{32}\.partial")
#: Seconds after which it is.
OLD = 3600.0
_EFFECTIVE = os.access in os.supports_effective_ids


@contextmanager
def whole_file(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Give another name beside a file, and that file's own once what is written there is complete and on the disk.

    What is written has the rights of any new file. A link that has the name is replaced; what it leads to stays.

    Raises
    ------
    InputError
        If it cannot be written; what was there stays.
    """
    target = path_of(path)
    if os.path.isdir(target):
        raise InputError(f"{target} is a folder; give the name of a file")
    if is_device(target):
        raise InputError(f"{target} is a device, which a file would replace; give the name of a file")
    part = target.with_name(f".{uuid4().hex}.partial")
    try:
        if os.path.isfile(target) and not os.access(target, os.W_OK, effective_ids=_EFFECTIVE):
            raise InputError(f"{target} is protected against writing; give another name")
        yield part
        with open(part, "rb+") as written:  # else a power cut can leave the name to nothing
            os.fsync(written.fileno())
        os.replace(part, target)
    except OSError as error:
        raise InputError(f"{target} cannot be written: {error.strerror or error}; choose another folder") from error
    finally:
        with suppress(OSError):
            part.unlink(missing_ok=True)


def is_device(path: str | os.PathLike[str]) -> bool:
    """Say whether a name is that of a device, such as /dev/null, which the user root could replace."""
    try:
        mode = os.lstat(path).st_mode
    except OSError:
        return False
    return stat.S_ISCHR(mode) or stat.S_ISBLK(mode)


def put(file: Path, content: bytes, mode: int) -> None:
    """Write a file whole or not at all, with these rights: several processes may be writing the same.

    Raises
    ------
    OSError
        If it cannot be written.
    """
    part = file.with_name(f".{uuid4().hex}.partial")
    try:
        with open(os.open(part, os.O_WRONLY | os.O_CREAT | os.O_EXCL | getattr(os, "O_BINARY", 0), mode), "wb") as new:
            new.write(content)
        part.chmod(mode)
        part.replace(file)
    finally:
        part.unlink(missing_ok=True)


def left_in(folder: Path) -> list[Path]:
    """Return the files in a folder that their writers have left half made."""
    found = []
    for file in folder.glob(".*.partial"):
        with suppress(OSError):  # it has just got its name
            if PARTIAL.fullmatch(file.name) and is_left(file):
                found.append(file)
    return found


def is_left(half: Path) -> bool:
    """Say whether nobody writes something half made any more: it has not changed for an hour.

    By the clock of the disk, since machines differ in theirs; what is from the future was left by a wrong clock.
    """
    with tempfile.TemporaryFile(dir=half.parent) as probe:
        now = os.fstat(probe.fileno()).st_mtime
    return abs(now - half.lstat().st_mtime) > OLD
