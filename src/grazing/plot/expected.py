"""What a figure is drawn from: the right result, or a message that says what was given and what is needed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from grazing.measured import of_table
from grazing.outcome import InputError, listed, shown

#: Variables of a result that a message names.
SHOWN = 6


def expect(
    result: Any, study: str, variables: Mapping[str, tuple[str, ...]], figure: str | None = None
) -> tuple[str, ...]:
    """Return the dimensions of the first variable, or refuse what is not the result of a study.

    Parameters
    ----------
    result : xarray.Dataset
    study : str
        Name of the study that returns it.
    variables : mapping of str to tuple of str
        Variables that are drawn, each with its dimensions. Dimensions of any name stand between ``<`` and ``>``.
    figure : str, optional
        Name of the function that draws it. Default: that of the study.

    Returns
    -------
    tuple of str
        Dimensions of the first of the variables.

    Raises
    ------
    InputError
        For anything else.
    """
    from grazing.late import xarray as xr

    drawn = f"plot.{study if figure is None else figure}"
    layout = ", ".join(f"{name} on ({', '.join(dims)})" for name, dims in variables.items())
    needed = f"allowed is the xarray.Dataset that grazing.{study} returns, with {layout}"
    if not isinstance(result, xr.Dataset):
        raise InputError(f"{drawn} cannot draw a {type(result).__name__}; {needed}")
    for name, dims in variables.items():
        if name not in result:
            if of_table(result):
                raise InputError(
                    f"{drawn} finds no {name}: the result is of a ball on a table; gz.plot.table(table, flown) draws "
                    "its trajectory, gz.plot.basins where its launches lead"
                )
            found = listed(map(str, result.data_vars), SHOWN) or "no variables"
            raise InputError(f"{drawn} finds no {name} in a result with {found}; {needed}")
        own = tuple(str(dim) for dim in result[name].dims)
        fits = len(own) == len(dims) and all(
            want.startswith("<") or is_ == want for is_, want in zip(own, dims, strict=True)
        )
        if not fits:
            raise InputError(f"{drawn} finds {name} on ({', '.join(own)}); {needed}")
    if 0 in result.sizes.values():
        empty = [
            str(dim) for dim, size in result.sizes.items() if size == 0 and dim in result[next(iter(variables))].dims
        ]
        if empty:
            raise InputError(f"{drawn} finds nothing along {', '.join(empty)}: the result is empty; draw another one")
    return tuple(str(dim) for dim in result[next(iter(variables))].dims)


def choice(value: Any, name: str, allowed: Sequence[str]) -> str:
    """Return a value if it is one of those allowed."""
    if not isinstance(value, str) or value not in allowed:
        raise InputError(f"{name} is {shown(value)}; allowed are {', '.join(map(repr, allowed))}")
    return str(value)
