"""Files that are whole or not there: written beside their place under another name, then renamed."""

from __future__ import annotations

import os
import re
import tempfile
from pathlib import Path

from grazing.outcome import InputError

#: What an interruption leaves of a file of the report.
_PART = re.compile(r"\.(index\.html|claims\.json|figure-[0-9.]+\.[a-z]+)\.[a-z0-9_]{8}\.part")


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
    part: Path | None = None
    try:
        handle, name = tempfile.mkstemp(prefix=f".{path.name}.", suffix=".part", dir=path.parent)
        part = Path(name)
        with os.fdopen(handle, "wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        part.chmod(0o644)
        part.replace(path)
    except OSError as error:
        raise refused(path, error) from None
    finally:
        if part is not None:
            part.unlink(missing_ok=True)
    return path


def folder(path: str | Path) -> Path:
    """Return a folder that files can be written to, made if need be; remove what an interruption left there.

    Raises
    ------
    InputError
        If it is a file, or cannot be made or written to.
    """
    place = Path(path)
    try:
        place.mkdir(parents=True, exist_ok=True)
        for part in place.glob(".*.part"):
            if _PART.fullmatch(part.name):  # other programs name theirs so, too
                part.unlink(missing_ok=True)
        with tempfile.NamedTemporaryFile(dir=place, suffix=".part", prefix="."):
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
