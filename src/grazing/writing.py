"""Files written whole or not at all."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from uuid import uuid4

from grazing.outcome import InputError


@contextmanager
def whole_file(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Give another name beside a file, and that file's own once what is written there is complete.

    Raises
    ------
    InputError
        If it cannot be written; what was there stays.
    """
    target = Path(path)
    part = target.with_name(f".{uuid4().hex}.partial")
    try:
        if target.is_dir():
            raise InputError(f"{target} is a folder; give the name of a file")
        yield part
        part.replace(target)
    except OSError as error:
        raise InputError(f"{target} cannot be written: {error.strerror or error}; choose another folder") from error
    finally:
        with suppress(OSError):
            part.unlink(missing_ok=True)
