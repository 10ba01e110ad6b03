"""Results that files and stores keep, and what they vary."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

from grazing.outcome import InputError, printable


def loaded(file: str | Path) -> Any:
    """Return a stored result: a NetCDF file, or a store of a sweep."""
    if os.path.isdir(file):
        from grazing.cli import progress
        from grazing.sweep import open_store

        with progress.said(f"reading {printable(str(file), newlines=False)}"):  # a large one takes many seconds
            return open_store(file)
    from grazing.io import load

    return load(file)


def curve_in(file: str) -> Any:
    """Return a stored branch or locus that --curves names."""
    if not os.path.exists(file):
        raise Missing(
            f"--curves = {os.path.relpath(file)}; there is no such file, and periods are written 2,3,5 or 2:7"
        )
    return loaded(file)


class Missing(InputError):
    """A file with curves that is not there."""


def axes_of(result: Any) -> dict[str, Any]:
    """Return the values along the axes of a result, in the order of its first variable."""
    dims = next((item.dims for item in result.data_vars.values()), ())
    return {str(name): result[name].values for name in dims if name in result.coords}
