"""Converters of the command line: whole numbers (1.5 is none, and is not rounded to one), and text as it is."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any


def whole_number(_kind: Any, tokens: Sequence[Any]) -> int:
    """Convert what was written; a :class:`ValueError` becomes the message of the command line."""
    written: str = tokens[0].value
    try:
        return int(written)
    except ValueError:
        raise ValueError(f"{written!r} is no whole number.") from None


def all_as_written(_kind: Any, tokens: Sequence[Any]) -> list[str]:
    """Return all that was written, of an option that may be repeated."""
    return [str(token.value) for token in tokens]


def as_written(_kind: Any, tokens: Sequence[Any]) -> str:
    """Return what was written: the type of an option says what completion offers, not what is allowed."""
    return str(tokens[0].value)
