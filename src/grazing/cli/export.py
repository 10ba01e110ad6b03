"""``grazing export``: write a stored result in another format."""

from __future__ import annotations

import json as text
import warnings
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from grazing.cli import output
from grazing.cli.stored import loaded
from grazing.outcome import InputError, printable, shown


def export(
    file: Annotated[Path, Parameter(name="RESULT", help="What a study saved: a file .nc or a store .zarr.")],
    out: Annotated[Path, Parameter(name="FILE", help="File to write: nc (NetCDF), csv or parquet (tables).")],
    /,
    *,
    variables: Annotated[
        str | None,
        Parameter(
            help="Variables to write, commas between them, with their coordinates; all by default.", metavar="LIST"
        ),
    ] = None,
    units: Annotated[str | None, Parameter(help=output.UNITS, metavar="LIST")] = None,
    json: Annotated[bool, Parameter(help="Print a summary as one JSON object.", show_default=False)] = False,
) -> int:
    """Write a stored result as tables or in one file.

    A table says nothing of where it comes from; a file .nc does: 'grazing export chart.zarr chart.csv'.
    """
    (target,) = output.targets([out], output.DATA)
    result = loaded(file)
    if "grazing_incomplete" in result.attrs:
        warnings.warn(f"{file} is not complete: {result.attrs['grazing_incomplete']}", stacklevel=2)
    if variables is not None:
        result = result[chosen(variables, [str(name) for name in result.data_vars])]
    written = output.write(output.converted(result, output.checked_units(units)), target)
    title = printable(str(result.attrs.get("title", "")), newlines=False)
    print(text.dumps({"title": title, "files": written}) if json else f"{title}\nwritten: {output.named(written)}")
    return 0


def chosen(text: str, known: list[str]) -> list[str]:
    """Return the variables that a text names, or raise InputError."""
    from grazing.config.problems import unknown_key

    names = [name.strip() for name in text.split(",")]
    for name in names:
        if name not in known:
            raise InputError(f"--variables: {unknown_key(name, known, f'unknown variable {shown(name)}')}")
    return names
