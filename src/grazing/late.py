"""What is imported where it is first needed; packages each as a whole: an interrupt waits until it is there."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from grazing.interrupt import held_back

if TYPE_CHECKING:
    import pandas as pandas
    import pyarrow as pyarrow
    import xarray as xarray
    import zarr as zarr
    from pyarrow import parquet as parquet
    from scipy import optimize as optimize
    from scipy import signal as signal
    from scipy.io import netcdf_file as netcdf_file
    from scipy.io import wavfile as wavfile
    from xarray.backends import ScipyDataStore as ScipyDataStore

#: What each is called where it comes from: a part of SciPy is a fifth of what a first command waits for.
PACKAGES = {
    "ScipyDataStore": "xarray.backends:ScipyDataStore",
    "netcdf_file": "scipy.io:netcdf_file",
    "optimize": "scipy.optimize",
    "pandas": "pandas",
    "parquet": "pyarrow.parquet",
    "pyarrow": "pyarrow",
    "signal": "scipy.signal",
    "wavfile": "scipy.io.wavfile",
    "xarray": "xarray",
    "zarr": "zarr",
}


def named(place: str) -> Any:
    """Return what a text names as ``module:name``: of a layer above, or of a module that takes time to import."""
    module, _, name = place.partition(":")
    return getattr(import_module(module), name)


def __getattr__(name: str) -> Any:
    if name not in PACKAGES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    with held_back():
        module, _, part = PACKAGES[name].partition(":")
        found: Any = import_module(module)
        if name == "xarray":
            found.DataArray([0.0], {"x": [0.0]}, ["x"])  # for which it imports others, such as Dask
        if name == "ScipyDataStore":
            found.list_engines()  # whose modules xarray imports when it opens the first file
        found = getattr(found, part) if part else found
        globals()[name] = found
    return found
