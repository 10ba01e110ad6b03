"""Files that are whole or not there: written beside their place under another name, then renamed."""

from __future__ import annotations

import tempfile
from pathlib import Path

from grazing.outcome import InputError
from grazing.paths import path_of
from grazing.writing import remove_left, whole_file


def write(path: Path, data: bytes | str) -> Path:
    """Write a file whole: an interruption leaves what was there before.

    Parameters
    ----------
    path : Path
    data : bytes or str
        Text is written as UTF-8.

    Returns
    -------
    Path

    Raises
    ------
    InputError
        If the folder cannot be written to.
    """
    content = data.encode("utf-8") if isinstance(data, str) else data
    with whole_file(path) as part:
        part.write_bytes(content)
    return path


def folder(path: str | Path) -> Path:
    """Return a folder that files can be written to, made if need be; remove what an interruption left there.

    Raises
    ------
    InputError
        If it is a file, or cannot be made or written to.
    """
    place = path_of(path)
    try:
        place.mkdir(parents=True, exist_ok=True)
        remove_left(place)
        with tempfile.TemporaryFile(dir=place):
            pass
    except OSError as error:
        raise refused(place, error) from None
    return place


def refused(path: Path, error: OSError) -> InputError:
    """Return the error for a place that cannot be written to."""
    reason = error.strerror or type(error).__name__
    return InputError(
        f"cannot write to {str(path)!r}: {reason}; a folder that can be made and written to is allowed; choose "
        f"another one"
    )
