"""Packages that are imported where they are first needed, each as a whole: an interrupt waits until it is there."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from grazing.interrupt import held_back

if TYPE_CHECKING:
    import xarray as xarray
    from scipy import optimize as optimize
    from scipy import signal as signal

#: What each is called where it comes from: a part of SciPy is a fifth of what a first command waits for.
PACKAGES = {"optimize": "scipy.optimize", "signal": "scipy.signal", "xarray": "xarray"}


def __getattr__(name: str) -> Any:
    if name not in PACKAGES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    with held_back():
        module = import_module(PACKAGES[name])
        if name == "xarray":
            module.DataArray([0.0], {"x": [0.0]}, ["x"])  # for which it imports others, such as Dask
        globals()[name] = module
    return module
