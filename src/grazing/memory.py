"""Refuse a result that does not fit into memory before it is begun."""

from __future__ import annotations

import os

from grazing.outcome import InputError


def physical_memory() -> int | None:
    """Return the memory of this machine in bytes; None where the system does not say."""
    try:
        return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    except (AttributeError, OSError, ValueError):
        return None


def refuse_too_large(size: int, advice: str) -> None:
    """Raise InputError if a result of so many bytes would take more than half of the memory.

    Parameters
    ----------
    size : int
        Bytes.
    advice : str
        What the user can reduce, with the present numbers, and what stores less.
    """
    memory = physical_memory()
    if memory is not None and size > memory / 2:
        raise InputError(
            f"the result would take {size / 1e9:.3g} GB, more than half of the memory ({memory / 1e9:.3g} GB); {advice}"
        )
