"""Names of files: what can be one, and a file that is looked at and read through the same open handle."""

from __future__ import annotations

import errno
import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, BinaryIO

from grazing.outcome import InputError, shown


def path_of(given: Any) -> Path:
    r"""Return the path that somebody gave.

    Raises
    ------
    InputError
        For what cannot be the name of a file on any system.

    Examples
    --------
    >>> path_of("a\0.nc")
    Traceback (most recent call last):
    ...
    grazing.outcome.InputError: 'a\x00.nc' is no name of a file; give a path
    """
    try:
        found = Path(given)
        if "\0" not in os.fsdecode(os.fsencode(found)):
            return found
    except (TypeError, ValueError):  # no text, or letters that no system writes
        pass
    raise InputError(f"{shown(given)} is no name of a file; give a path")


def remedy(error: OSError) -> str:
    """Return what helps where the system makes no file of a name."""
    return "give a shorter name" if error.errno == errno.ENAMETOOLONG else "choose another folder"


@contextmanager
def opened(path: str | os.PathLike[str]) -> Iterator[BinaryIO]:
    """Give an open file, which is a regular one whatever has its name a moment later; nothing waits for a pipe.

    Raises
    ------
    InputError
        If there is no such file, it is a folder, a pipe or a device, or it cannot be read.
    """
    source = path_of(path)
    try:
        with open(source, "rb", opener=_at_once) as file:
            if not stat.S_ISREG(os.fstat(file.fileno()).st_mode):
                raise InputError(f"{source} is a device or a pipe; give a file")
            yield file
    except FileNotFoundError:
        raise InputError(f"there is no file {source}") from None
    except OSError as error:  # links in a circle, for one
        raise InputError(f"{source} cannot be read: {error.strerror or error}") from None


def _at_once(path: str, flags: int) -> int:
    """Open a file; nothing waits for a pipe, not even for one that has just taken the place of a file."""
    return os.open(path, flags | getattr(os, "O_NONBLOCK", 0))
