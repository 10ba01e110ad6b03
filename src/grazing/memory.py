"""Refuse a result that does not fit into memory before it is begun."""

from __future__ import annotations

import os

from grazing.outcome import InputError

try:
    import resource
except ImportError:  # pragma: no cover  (Windows has no such limits)
    resource = None  # type: ignore[assignment]


def physical_memory() -> int | None:
    """Return the memory of this machine in bytes; None where the system does not say."""
    try:
        return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    except (AttributeError, OSError, ValueError):
        return None


def address_space() -> int | None:
    """Return how many bytes this process may ask for, as ``ulimit -v`` says; None for no such limit."""
    limit = -1 if resource is None else resource.getrlimit(resource.RLIMIT_AS)[0]
    return None if resource is None or limit == resource.RLIM_INFINITY else limit


def refuse_too_large(size: float, advice: str, what: str = "the result") -> None:
    """Raise InputError if something of so many bytes would take more than half of the memory.

    To be called before the first of these bytes is asked for.

    Parameters
    ----------
    size : int
        Bytes.
    advice : str
        What the user can reduce, with the present numbers, and what stores less.
    what : str
        What takes so much.
    """
    memory = min((each for each in (physical_memory(), address_space()) if each is not None), default=None)
    if memory is not None and size > memory / 2:
        raise InputError(
            f"{what} would take {size / 1e9:.3g} GB, more than half of the memory ({memory / 1e9:.3g} GB); {advice}"
        )
