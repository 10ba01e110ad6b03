"""Save a result to one NetCDF file and load it back, exactly as it was.

The format is NetCDF 3 with 64-bit offsets, which SciPy writes and every NetCDF reader understands. It knows neither
64-bit integers nor complex numbers nor the order of the variables; one attribute of the file, ``grazing_file``,
says what they were, so that :func:`load` gives back the very types, order and attributes that :func:`save` got.
"""

from __future__ import annotations

import io
import json
import os
import warnings
from collections.abc import Hashable
from datetime import UTC, datetime
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from grazing.memory import refuse_too_large
from grazing.outcome import InputError, in_one_line, shown
from grazing.paths import opened, path_of
from grazing.writing import whole_file

if TYPE_CHECKING:
    import xarray as xr

FORMAT = 1
RECORD = "grazing_file"
CREATED = "date_created"
#: Attributes that say how a file is written: those of a result under these names would be taken for them.
_OF_THE_FILE = {RECORD, CREATED, "coordinates", "dtype", "_Encoding"}
#: Bytes of one variable beyond which NetCDF 3 cannot address it.
LARGEST = 2**32 - 4
#: Bytes of a letter while texts, each as long as the longest, are written: as text, as bytes and in the file.
LETTER = 6
#: Variables of a file, and bytes of its record, beyond which it is no result.
MOST, LONGEST = 10_000, 2**24
#: Pieces in which a file is read at most: a result has some ten for each variable and attribute.
PIECES = 10**6
#: Dimension that holds the real and the imaginary part of a complex variable.
PARTS = "real_imaginary"
#: Types that NetCDF 3 stores as they are, and what the others are stored as; int64 goes where its numbers fit.
_STORED = {"float64": "float64", "float32": "float32", "int8": "int8", "int16": "int16", "int32": "int32"}
_STORED |= {"bool": "int8", "uint8": "int16", "uint16": "int32", "uint32": "float64"}


def save(result: xr.Dataset, path: str | os.PathLike[str]) -> Path:
    """Write a result to a NetCDF file, whole or not at all.

    Numbers are copied once for that, so that it takes their room again, and no more.

    Parameters
    ----------
    result : xarray.Dataset
        From any study, or any other dataset of numbers and text.
    path : path-like
        Must end in ``.nc``; a file that is there is replaced once the new one is complete.

    Returns
    -------
    pathlib.Path
        The file.

    Raises
    ------
    InputError
        For another ending, a folder that is missing or not writable, or a dataset with something that the file
        cannot hold; nothing is written then.

    Examples
    --------
    >>> import tempfile, pathlib, xarray as xr
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = save(xr.Dataset({"word": ("start", ["LLR", ""])}), pathlib.Path(folder) / "words.nc")
    ...     load(path).word.values.tolist()
    ['LLR', '']
    """
    from grazing.late import xarray as xr

    target = _target(path)
    if not isinstance(result, xr.Dataset):
        raise InputError(f"cannot save {type(result).__name__}; give the xarray.Dataset that a study returns")
    stored = _encoded(result)
    stored.attrs[CREATED] = datetime.now(UTC).isoformat(timespec="seconds")
    with whole_file(target) as part:
        try:
            _write(stored, part)
        except (ValueError, NotImplementedError) as error:  # such as a name that NetCDF keeps for itself: int, real
            raise InputError(f"{target} cannot be written: {error}; rename it or make it text") from error
    return target


class _Bytes(np.ndarray):
    """Numbers that are written as they stand: their bytes are no copy, which would take the room of all of them."""

    def tobytes(self, order: Any = "C") -> memoryview:  # type: ignore[override]
        return np.asarray(self).reshape(-1).view(np.uint8).data


def _write(stored: xr.Dataset, part: Path) -> None:
    """Write a dataset to a file."""
    from grazing.late import ScipyDataStore

    store = ScipyDataStore(str(part), "w", "NETCDF3_64BIT")
    try:
        stored.dump_to_store(store)
        for variable in store.ds.variables.values():
            vars(variable)["data"] = variable.data.view(_Bytes)  # an attribute that is set is one of the file
    finally:
        store.close()


def load(path: str | os.PathLike[str]) -> xr.Dataset:
    """Read a result that :func:`save` wrote, or the store of a sweep.

    Parameters
    ----------
    path : path-like
        A file, or the folder of a store, see :func:`grazing.sweep.open_store`.

    Returns
    -------
    xarray.Dataset
        What was saved, in memory; the file can be moved or deleted. When it was saved is in
        ``encoding["date_created"]``.

    Raises
    ------
    InputError
        For a file that is missing, damaged or not written by :func:`save`.
    """
    source = path_of(path)
    if os.path.isdir(source):
        from grazing.sweep import open_store

        try:
            return open_store(source)
        except InputError as error:
            if any(os.path.lexists(source / name) for name in ("zarr.json", "manifest")):
                raise
            raise InputError(
                f"{source} is a folder: give the store of a sweep, or a file that gz.save wrote; {error}"
            ) from error
    with opened(source) as file:
        head = file.read(4) or b""  # one that has nothing to say yet gives None
        if head[:3] != b"CDF":
            raise _foreign(source, readable=head == b"\x89HDF")
        refuse_too_large(os.fstat(file.fileno()).st_size, f"{source} cannot be opened here")
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # what a damaged file makes NumPy say is said below in one sentence
                return _read(_Once(file), source)
        except (InputError, OSError, ImportError, MemoryError):  # the last three are no fault of what the file says
            raise
        except Exception as error:  # a damaged file can fail anywhere in the reader
            raise InputError(f"{source} is damaged and cannot be read: {in_one_line(error)}") from error


class _Once(io.BufferedReader):
    """A file that gives each of its bytes once, in so many pieces: no file takes more memory, or time, than it has.

    A map of the file into memory would end the process where another one cuts the file off.
    """

    def __init__(self, file: BinaryIO) -> None:
        super().__init__(file.raw)  # type: ignore[attr-defined]
        self.seek(0)
        self._left, self._pieces = os.fstat(file.fileno()).st_size, PIECES

    def read(self, size: int | None = -1, /) -> bytes:
        """Return the next bytes."""
        found = super().read(self._left if size is None or size < 0 else min(size, self._left))
        self._left, self._pieces = self._left - len(found), self._pieces - 1
        if (size and not found) or not self._pieces:
            raise ValueError("it names more than it holds")
        return found


def _read(file: _Once, source: Path) -> xr.Dataset:
    from grazing.late import ScipyDataStore
    from grazing.late import xarray as xr

    store = ScipyDataStore(file)
    if len(store.ds.variables) > MOST:  # they and JSON take many times their bytes to be opened
        raise ValueError(f"it has more than {MOST} variables")
    if len(getattr(store.ds, RECORD, b"")) > LONGEST:
        raise ValueError(f"its record has more than {LONGEST} bytes")
    # Attributes such as scale_factor are those of the result: they change no number.
    with xr.open_dataset(store, decode_times=False, mask_and_scale=False) as stored:
        if RECORD not in stored.attrs:
            raise _foreign(source)
        record = _record(stored, source)
        refuse_too_large(_size(stored, record), f"{source} cannot be opened here")
        return _decoded(stored.load(), record)


def _foreign(source: Path, readable: bool = True) -> InputError:
    advice = "open it with xarray.open_dataset instead" if readable else "give a .nc file that it wrote, or a store"
    return InputError(f"{source} was not written by gz.save; {advice}")


def _record(stored: xr.Dataset, source: Path) -> dict[str, Any]:
    """Return what the record of a file says, checked as far as memory depends on it."""
    record: dict[str, Any] = json.loads(stored.attrs[RECORD])
    if record["format"] != FORMAT:
        raise InputError(f"{source} has format {shown(record['format'])}, this version reads {FORMAT}; update grazing")
    if record["variables"].keys() != {str(name) for name in stored.variables}:
        raise ValueError("its record is of other variables")
    return record


def _size(stored: xr.Dataset, record: dict[str, Any]) -> int:
    """Return the bytes that a file takes in memory; it can name the same bytes, or wide types, many times over."""
    types = {name: _type(kept["dtype"], "biufcUO") for name, kept in record["variables"].items()}
    sizes = {name: (item.size, item.dtype.itemsize) for name, item in stored.variables.items()}
    return sum(count * (2 * stands + types[str(name)].itemsize) for name, (count, stands) in sizes.items())


def _type(name: Any, kinds: str) -> np.dtype[Any]:
    """Return the type that a record names, if it is of a kind that is written."""
    if not isinstance(name, str) or np.dtype(name).kind not in kinds:
        raise ValueError(f"its record names a type {shown(name)}")
    return np.dtype(name)


def _target(path: str | os.PathLike[str]) -> Path:
    target = path_of(path)
    if target.suffix != ".nc":
        raise InputError(f"{target} ends in {target.suffix or 'nothing'!r}; allowed is '.nc' (NetCDF)")
    if not os.path.isdir(target.parent):
        raise InputError(f"there is no folder {target.parent}; make it first")
    return target


# ---- what NetCDF 3 cannot say


def _encoded(result: xr.Dataset) -> xr.Dataset:
    """Return a dataset of types that NetCDF 3 has, with the record of what they were."""
    from grazing.late import xarray as xr

    record: dict[str, Any] = {"format": FORMAT, "attrs": {}, "variables": {}}
    attrs = _encoded_attrs(result.attrs, "the dataset", record["attrs"])
    names = [*result.data_vars, *result.coords]
    if len(names) > MOST:
        raise InputError(f"the result has {len(names)} variables; a file holds at most {MOST}: save parts")
    variables: dict[Hashable, Any] = {}
    room = 0
    for name in names:
        if not isinstance(name, str) or not name:
            raise InputError(f"variable {name!r} has no text for a name; rename it")
        variable = result.variables[name]
        kept: dict[str, Any] = {"dtype": variable.dtype.str, "coordinate": name in result.coords, "attrs": {}}
        dims, data = tuple(variable.dims), np.asarray(variable.values)
        if not all(isinstance(dim, str) for dim in dims):
            raise InputError(f"a dimension of variable {name!r} has no text for a name; rename it")
        if 0 in data.shape[1:]:  # which reads as a dimension without an end
            raise InputError(f"variable {name!r} is empty along a dimension that is not its first; drop it")
        if data.dtype.kind == "c":
            dims, data = (*dims, PARTS), np.stack([data.real, data.imag], axis=-1)
        elif data.dtype.kind == "O" and all(isinstance(item, str) for item in data.flat):
            longest = max(map(len, data.flat), default=0)
            room += LETTER * longest * data.size
            refuse_too_large(room, f"save parts of {name!r}, whose longest text has {longest} letters", "the file")
            data = data.astype(np.str_)
        if data.dtype.kind != "U":
            data = _fitting(data, f"variable {name!r}")
        if data.size * data.dtype.itemsize > LARGEST:
            raise InputError(
                f"variable {name!r} has {data.nbytes / 1e9:.3g} GB; a NetCDF file holds 4.29 GB a variable: save parts"
            )
        attributes = _encoded_attrs(variable.attrs, f"variable {name!r}", kept["attrs"])
        variables[name] = (dims, data, attributes)
        record["variables"][name] = kept
    stored = xr.Dataset({name: variables[name] for name in result.data_vars})
    stored = stored.assign_coords({name: variables[name] for name in result.coords})
    stored.attrs = attrs | {RECORD: json.dumps(record)}
    for variable in stored.variables.values():
        if variable.dtype.kind == "f":
            variable.encoding["_FillValue"] = None
    return stored


def _fitting(data: NDArray[Any], where: str) -> NDArray[Any]:
    """Return numbers as a type that NetCDF 3 has and that holds every one of them."""
    kind = data.dtype.name
    if kind in _STORED:
        return data.astype(_STORED[kind], copy=False)
    if data.dtype.kind not in "iu":
        raise InputError(f"{where} is of type {kind}; a file holds numbers and text, and JSON for anything else")
    if not data.size or (data.min() >= -(2**31) and data.max() < 2**31):
        return data.astype(np.int32, copy=False)
    if data.min() >= -(2**53) and data.max() <= 2**53:
        return data.astype(np.float64, copy=False)
    raise InputError(f"{where} has whole numbers beyond 2^53, which the file cannot hold; save them as text")


def _encoded_attrs(attrs: dict[Hashable, Any], where: str, record: dict[str, str]) -> dict[str, Any]:
    """Return attributes that NetCDF 3 has; the record says which of them were what."""
    stored: dict[str, Any] = {}
    for name, value in attrs.items():
        of = f"attribute {name!r} of {where}"
        if not isinstance(name, str):
            raise InputError(f"{of} has no text for a name; rename it")
        if name in _OF_THE_FILE or name in _of_scipy():
            raise InputError(f"{of} has a name that a NetCDF file keeps for itself; rename it")
        if isinstance(value, str):
            if value.endswith("\0"):
                raise InputError(f"{of} ends in a zero byte, which the file fills up with; cut it off")
            stored[name] = value
            continue
        try:
            array = np.asarray(value)
        except ValueError:  # lists of different lengths
            array = np.asarray(None)
        if isinstance(value, (bool, dict)) or array.dtype.kind not in "iuf" or array.ndim > 1 or not array.size:
            raise InputError(f"{of} is {value!r}; give text (JSON for a structure), a number or an array of numbers")
        stored[name] = _fitting(array, of)
        plain = "python" if isinstance(value, (int, float, list)) and not isinstance(value, np.generic) else ""
        record[name] = f"{plain} {array.ndim} {array.dtype.name}"
    return stored


@cache
def _of_scipy() -> set[str]:
    """Return what SciPy's files and variables have themselves: it takes an attribute of that name for that."""
    from grazing.late import netcdf_file

    with netcdf_file(io.BytesIO(), "w") as file:
        return {*dir(file), *dir(file.createVariable("x", "i", ()))}


def _decoded_attrs(attrs: dict[Any, Any], record: dict[str, str]) -> dict[str, Any]:
    found = {}
    for name, value in attrs.items():
        if name not in record:
            found[name] = value
            continue
        plain, ndim, kind = record[name].split(" ")
        array = _as(np.asarray(value), _type(kind, "biuf"))
        array = np.atleast_1d(array) if ndim == "1" else array.reshape(())
        found[name] = array.tolist() if plain else (array if ndim == "1" else array[()])
    return found


def _as(values: NDArray[Any], kind: np.dtype[Any]) -> NDArray[Any]:
    """Return values in the type that a record names, which is refused where it cannot hold every one of them."""
    texts = "OSU"
    if (values.dtype.kind in texts) == (kind.kind in texts):
        with np.errstate(all="ignore"):
            found = values.astype(kind, copy=False)
            if found is values or _same(found, values).all():
                return found
    raise ValueError(f"its record names a type {kind.name}, which does not hold what stands there")


def _same(found: NDArray[Any], values: NDArray[Any]) -> NDArray[np.bool_]:
    """Return where two arrays have the same number or text, NaN or not."""
    same: NDArray[np.bool_] = found == values
    if found.dtype.kind in "fc" and values.dtype.kind in "fc":
        same |= (found != found) & (values != values)
    return same


def _decoded(stored: xr.Dataset, record: dict[str, Any]) -> xr.Dataset:
    from grazing.late import xarray as xr

    data: dict[str, Any] = {}
    for name, kept in record["variables"].items():
        variable = stored.variables[name]
        dims, values = tuple(variable.dims), variable.values
        if np.dtype(kept["dtype"]).kind == "c":
            if dims[-1:] != (PARTS,) or values.shape[-1] != 2:
                raise ValueError(f"variable {name!r} has not the parts of complex numbers")
            dims, values = dims[:-1], np.ascontiguousarray(values, np.float64).view(np.complex128)[..., 0]
        data[name] = (dims, _as(values, np.dtype(kept["dtype"])), _decoded_attrs(variable.attrs, kept["attrs"]))
    coordinates = {name for name, kept in record["variables"].items() if kept["coordinate"]}
    attrs = dict(stored.attrs)
    created = attrs.pop(CREATED, "")
    del attrs[RECORD]
    result = xr.Dataset(
        {name: item for name, item in data.items() if name not in coordinates},
        {name: item for name, item in data.items() if name in coordinates},
        _decoded_attrs(attrs, record["attrs"]),
    )
    result.encoding = {CREATED: created}
    return result
