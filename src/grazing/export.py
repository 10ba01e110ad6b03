"""Write a result as tidy tables, CSV or Parquet: one row an observation, one column a variable, for any program."""

from __future__ import annotations

import csv
import os
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from grazing.measured import downwards
from grazing.outcome import InputError, in_one_line, shown
from grazing.paths import path_of
from grazing.writing import whole_files

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

#: Columns of a table, some rows at a time.
Pieces = Iterator[list[NDArray[Any]]]
#: How the meaning of a flag begins that says that a row only fills up its table.
FILLER = "no_further_"
#: Letters of a dimension in the name of a file.
LONGEST = 100
#: Names along a dimension that get a column each.
NAMES = 100
#: Rows that are put together at a time.
ROWS = 200_000


def to_csv(result: xr.Dataset, path: str | os.PathLike[str]) -> list[Path]:
    """Write a result as comma-separated values, whole or not at all.

    Variables on the same dimensions, or on some of them, share a table; that of the first variable, which is what was
    scanned or measured, gets the name given, another one ``name-dimension.csv``. A dimension of names, such as those of
    the coordinates, makes a column for each. Numbers are written so that they are read back with the same bits, NaN as
    nothing, infinity as inf. Heads have the units of a rig; where its stop is above, u is -x, and they say *positive
    down*. Rows that only fill up, where a cell of a chart has no further attractor, are left out.
    Words may consist of digits: tell the reader that they are text, as ``pandas.read_csv(file, dtype={"word": str})``.
    A table says nothing of where it comes from: save the result as ``.nc`` too.
    Several tables get their names at once, but for a process that is killed, or a power cut, in that very moment.

    Parameters
    ----------
    result : xarray.Dataset
        From any study.
    path : path-like
        Must end in ``.csv``.

    Returns
    -------
    list of pathlib.Path
        The files, the one asked for first.

    Raises
    ------
    InputError
        For another ending, or a folder that is missing or not writable.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> import grazing as gz
    >>> from grazing.export import to_csv
    >>> diagram = gz.orbit_diagram(gz.gap_map(lam=0.5, mu=0.1, l=0.1), "mu", [0.07], starts=1, keep=6)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     (file,) = to_csv(diagram[["x", "letter", "period", "word"]], pathlib.Path(folder) / "orbits.csv")
    ...     file.read_text().splitlines()[0]
    'mu,start,n,x,letter,period,word'
    """
    return _tables_written(result, path, ".csv", _csv)


def to_parquet(result: xr.Dataset, path: str | os.PathLike[str]) -> list[Path]:
    """Write a result as Parquet files, whole or not at all.

    The tables are those of :func:`to_csv`, with a type for each column, NaN and all bits. Needs pyarrow:
    ``pip install 'grazing[parquet]'``.

    Parameters
    ----------
    result : xarray.Dataset
        From any study.
    path : path-like
        Must end in ``.parquet``.

    Returns
    -------
    list of pathlib.Path
        The files, the one asked for first.

    Raises
    ------
    InputError
        For another ending, a folder that is missing or not writable, or without pyarrow.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> import grazing as gz
    >>> diagram = gz.orbit_diagram(gz.gap_map(lam=0.5, mu=0.1, l=0.1), "mu", [0.07], starts=1, keep=6)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     [file.name for file in gz.to_parquet(diagram, pathlib.Path(folder) / "orbits.parquet")]
    ['orbits.parquet']
    """
    return _tables_written(result, path, ".parquet", _parquet)


def to_dataframe(result: xr.Dataset, dimension: str | None = None) -> pd.DataFrame:
    """Return a table of a result: one row an observation, as in the files of :func:`to_csv`.

    A trajectory has one row an instant, and with ``dimension="impact"`` one row an impact; xarray's own
    ``to_dataframe`` makes one for every instant *and* impact.

    Parameters
    ----------
    result : xarray.Dataset
        From any study.
    dimension : str, optional
        Of the table, such as "impact" or "attractor"; None for that of the first variable.

    Returns
    -------
    pandas.DataFrame
        The dimensions are columns too; the rows are numbered. Rows that only fill up are left out.

    Raises
    ------
    InputError
        For a dimension that the result lacks.

    Examples
    --------
    >>> import grazing as gz
    >>> motion = gz.trajectory(gz.pinball(d=0.12, V=0.4), (0.1, 0.0), until=20.0)
    >>> list(gz.to_dataframe(motion)), len(gz.to_dataframe(motion)) == motion.sizes["t"]
    (['t', 'u', 'v', 'wall', 'trust'], True)
    >>> gz.to_dataframe(motion, "impact").v_minus.round(3).tolist()
    [-0.192, -0.032, -0.061]
    """
    from grazing.late import pandas as pd

    flat = _spread_names(_checked(result))
    parts = tables(flat)
    wanted = [part for part in parts if dimension is None or (isinstance(dimension, str) and dimension in part[0])]
    if not wanted:
        known = ", ".join(repr(dim) for dim in dict.fromkeys(dim for dims, _names in parts for dim in dims))
        raise InputError(f"dimension is {shown(dimension)}; allowed are {known}")
    dims, names = wanted[0]
    columns = zip(*_pieces(flat, dims, names), strict=True)
    return pd.DataFrame({name: np.concatenate(part) for name, part in zip([*dims, *names], columns, strict=True)})


def _checked(result: Any) -> xr.Dataset:
    if not hasattr(result, "data_vars"):
        raise InputError(f"result is a {type(result).__name__}; give an xarray.Dataset, as the studies return")
    for name in [*result.variables, *result.dims]:
        if not isinstance(name, str):
            raise InputError(f"{shown(name)} is no text for a name; rename it")
        if name in result.variables and name in result.dims and result[name].dims != (name,):
            raise InputError(f"variable {name!r} has the name of a dimension and is not along it; rename it")
    checked: xr.Dataset = result
    return checked


def _tables_written(
    result: xr.Dataset, path: str | os.PathLike[str], ending: str, write: Callable[[Path, list[str], Pieces], None]
) -> list[Path]:
    """Write each table of a result to a file of its own, piece by piece."""
    target = path_of(path)
    if target.suffix != ending:
        raise InputError(f"{target} ends in {target.suffix or 'nothing'!r}; allowed is {ending!r}")
    flat = _spread_names(_checked(result))
    parts = tables(flat)
    files = [target, *(target.with_name(f"{target.stem}-{_part(dims)}{ending}") for dims, _names in parts[1:])]
    if len({*files}) < len(files):
        raise InputError(
            f"tables of dimensions {', '.join(str(dims) for dims, _names in parts)} would share a file; rename some"
        )
    with whole_files(files) as halves:  # all are written before any gets its name: those of two results do not mix
        for (dims, names), file, part in zip(parts, files, halves, strict=True):
            try:
                write(part, [_titled(flat, name) for name in (*dims, *names)], _pieces(flat, dims, names))
            except (
                ValueError,
                TypeError,
                NotImplementedError,
            ) as error:  # complex numbers, letters that no system writes
                if isinstance(error, InputError):
                    raise
                raise InputError(f"{file} cannot hold the result: {in_one_line(error)}; save it as .nc") from error
    return files


def _titled(result: xr.Dataset, name: str) -> str:
    """Return the head of a column: its name, with its units where it has some, and where it counts downwards."""
    units = str(result[name].attrs.get("units", "1")) if name in result.variables else "1"
    down = " positive down" if name in downwards(result) else ""
    return name if units == "1" else f"{name} ({units}{down})"


def _part(dims: tuple[str, ...]) -> str:
    """Return what the name of a table says of its dimensions."""
    for dim in dims:
        if not dim.isprintable() or {*dim} & {*"/\\"} or len(dim) > LONGEST:
            raise InputError(f"dimension {shown(dim)} cannot be a part of a file's name; rename it")
    return "-".join(dims or ("values",))


def _spread_names(result: xr.Dataset) -> xr.Dataset:
    """Return a result with a variable ``point_u`` for each name along a dimension of names, such as coordinates."""
    for dim in [str(dim) for dim in result.sizes if dim in result.coords and _are_names(result[dim])]:
        spread: dict[str, Any] = {}  # in the places of those that they are made of
        for name in map(str, result.data_vars):
            if dim not in result[name].dims:
                spread[name] = result[name]
                continue
            units = str(result[name].attrs.get("units", "1")).split(", ")  # of each, where they differ
            if len(units) != result.sizes[dim]:
                units = [", ".join(units)] * result.sizes[dim]
            for i, label in enumerate(result[dim].values):
                column = f"{name}_{label}"
                if column in result.variables:
                    raise InputError(f"two columns would be called {shown(column)}; rename that variable")
                spread[column] = result[name].isel({dim: i}, drop=True).assign_attrs(units=units[i])
        result = result.drop_vars([*result.data_vars, dim]).assign(spread)
    return result


def _are_names(labels: Any) -> bool:
    """Whether a dimension is one of names, a column each; what is something else has a column of texts."""
    return labels.dtype.kind in "OU" and labels.size <= NAMES and len({*map(str, labels.values)}) == labels.size


def tables(result: xr.Dataset) -> list[tuple[tuple[str, ...], list[str]]]:
    """Return the tables of a result: dimensions, and the variables on them or on some of them.

    That of the first variable comes first, of the others the largest.
    """
    names = [str(name) for name in [*result.coords, *result.data_vars] if name not in result.dims]
    of = {name: tuple(str(dim) for dim in result[name].dims) for name in names}
    groups: list[tuple[str, ...]] = []
    for dims in sorted(dict.fromkeys(of.values()), key=len, reverse=True):  # a set has no order that stays
        if not any(set(dims) <= set(group) for group in groups):
            groups.append(dims)
    groups = groups or [tuple(str(dim) for dim in result.dims)]

    def rows(dims: tuple[str, ...]) -> int:
        return int(np.prod([result.sizes[dim] for dim in dims], dtype=np.float64))

    groups.sort(key=rows, reverse=True)
    home = {name: next(group for group in groups if set(dims) <= set(group)) for name, dims in of.items()}
    first = [home[str(name)] for name in [*result.data_vars][:1]]
    groups.sort(key=lambda group: group not in first)
    return [(group, [name for name in names if home[name] == group]) for group in groups]


def _csv(file: Path, header: list[str], pieces: Pieces) -> None:
    with file.open("w", encoding="utf-8", newline="") as opened:
        rows = csv.writer(opened, lineterminator="\n")
        rows.writerow(header)
        for columns in pieces:
            rows.writerows(zip(*map(_cells, columns), strict=True))


def _parquet(file: Path, header: list[str], pieces: Pieces) -> None:
    try:
        from grazing.late import parquet, pyarrow
    except ImportError:
        raise InputError("a Parquet file needs pyarrow: pip install 'grazing[parquet]'") from None
    writer = None
    try:
        for columns in pieces:
            plain = [column.astype(str).astype(object) if column.dtype.kind in "OUS" else column for column in columns]
            table = pyarrow.table([pyarrow.array(each.astype(each.dtype.newbyteorder("="))) for each in plain], header)
            if writer is None:
                writer = parquet.ParquetWriter(file, table.schema)
            writer.write_table(table)
    finally:
        if writer is not None:
            writer.close()


def _pieces(result: xr.Dataset, dims: tuple[str, ...], names: list[str]) -> Pieces:
    """Yield the columns of a table, so many rows at a time, and at least once: pieces along the first dimension."""
    length = result.sizes[dims[0]] if dims else 1
    inner = max(1, int(np.prod([result.sizes[dim] for dim in dims[1:]], dtype=np.float64)))
    step = max(1, ROWS // inner)
    for first in range(0, max(length, 1), step):
        part = result.isel({dims[0]: slice(first, first + step)}) if dims else result
        sizes = tuple(part.sizes[dim] for dim in dims)
        columns = []
        for i, dim in enumerate(dims):
            along = part[dim].values if dim in part.coords else np.arange(sizes[i]) + (first if i == 0 else 0)
            shape = [1] * len(dims)
            shape[i] = sizes[i]
            columns.append(np.ravel(np.broadcast_to(along.reshape(shape), sizes)))
        columns += [np.ravel(_spread(part[name], dims, sizes)) for name in names]
        filling = [(name, flags) for name in names if (flags := _filling(part[name]))]
        ends = [np.isin(_spread(part[name], dims, sizes), flags) for name, flags in filling]
        said = np.ravel(~np.logical_and.reduce(ends)) if ends else slice(None)
        yield [column[said] for column in columns]


def _filling(variable: Any) -> list[Any]:
    """Return the flags of a variable that say that there is nothing more."""
    meanings = str(variable.attrs.get("flag_meanings", "")).split()
    values = np.atleast_1d(variable.attrs.get("flag_values", ())).tolist()
    return [value for value, meaning in zip(values, meanings, strict=False) if meaning.startswith(FILLER)]


def _spread(variable: Any, dims: tuple[str, ...], sizes: tuple[int, ...]) -> NDArray[Any]:
    """Return a variable on all dimensions of its table."""
    own = [dim for dim in dims if dim in variable.dims]
    values = variable.transpose(*own).values
    shape = [size if dim in own else 1 for dim, size in zip(dims, sizes, strict=True)]
    return np.broadcast_to(np.asarray(values).reshape(shape), sizes)


def _cells(values: NDArray[Any]) -> list[Any]:
    """Return what stands in the cells of a column; nothing for NaN, which every program takes for a missing number."""
    plain: list[Any] = values.tolist()
    if values.dtype.kind == "f":
        for i in np.flatnonzero(np.isnan(values)).tolist():
            plain[i] = ""
    return plain
