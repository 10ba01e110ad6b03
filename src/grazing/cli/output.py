"""Where results go: the ending of a file's name chooses what is written."""

from __future__ import annotations

import errno
import os
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from grazing.measured import downwards
from grazing.outcome import InputError, printable

FIGURES = (".png", ".pdf", ".svg")
STORE, SOUND, FILM = ".zarr", ".wav", ".gif"
DATA = (".nc", ".csv", ".parquet")
ENDINGS = (*FIGURES, *DATA, STORE)
#: What the endings mean.
MEANT = (
    (FIGURES, "png, pdf, svg (figure)"),
    (DATA, "nc (result, NetCDF), csv or parquet (tables)"),
    ((STORE,), "zarr (result, computed chunk by chunk and resumable)"),
    ((SOUND,), "wav (the velocity as sound)"),
    ((FILM,), "gif (of a ball on a table, a film)"),
)


def help_of(endings: Sequence[str]) -> str:
    """Return the help of the option that names files with some of the endings."""
    formats = ", ".join(means for some, means in MEANT if {*some} <= {*endings})
    return f"File to write; may be repeated. Its ending chooses the format: {formats}."


def targets(out: Sequence[str | Path] | None, allowed: Sequence[str] = ENDINGS, option: str = "-o") -> list[Path]:
    """Return the files to write, checked before anything is computed.

    Raises
    ------
    InputError
        For an ending that is not allowed, a folder that is missing, a folder in the place of a file, or two stores.
    """
    paths = [Path(file) for file in dict.fromkeys(out or ())]
    for path in paths:
        if path.suffix not in allowed or not path.stem:
            endings = ", ".join(ending.lstrip(".") for ending in allowed)
            raise InputError(f"{option} {path}: the ending chooses the format; allowed are {endings}, in small letters")
        if not os.path.isdir(path.parent):
            raise InputError(f"{option} {path}: there is no folder {path.parent}; make it first")
        if _is_too_long(path):
            raise InputError(f"{option} {path}: the name is too long for a file; give a shorter name")
        if os.path.isdir(path) and path.suffix != STORE:
            raise InputError(f"{option} {path}: that is a folder; give the name of a file")
        if not os.access(path if os.path.exists(path) and path.suffix != STORE else path.parent, os.W_OK):
            raise InputError(f"{option} {path} cannot be written: permission denied; choose another folder")
    stores = [str(path) for path in paths if path.suffix == STORE]
    if len(stores) > 1:
        raise InputError(f"-o {' -o '.join(stores)}: one store at a time")
    return paths


def _is_too_long(path: Path) -> bool:
    try:
        os.lstat(path)
    except OSError as error:
        return error.errno == errno.ENAMETOOLONG
    return False


UNITS = "Units of what is printed, drawn and written, for a model in SI units: mm,Hz,N s."


def checked_units(units: str | None) -> tuple[str, ...]:
    """Return units that a text names, commas between them, or raise InputError for those that no result has."""
    if units is None:
        return ()
    from grazing.units import checked_units as checked

    try:
        return checked(units, "units")
    except InputError as error:
        raise InputError(f"--units: {error}") from None


def converted(result: Any, units: Sequence[str]) -> Any:
    """Return a result in other units, as it is without any."""
    if not units:
        return result
    from grazing.units import in_units

    return in_units(result, *units)


def converted_as_far(result: Any, units: Sequence[str]) -> Any:
    """Return a result that was just computed in those of the units that match; a warning names the others."""
    for unit in units:
        try:
            result = converted(result, [unit])
        except InputError as error:
            warnings.warn(f"--units: {error}", stacklevel=2)
    return result


def units_of(result: Any) -> dict[str, list[str]]:
    """Return the units of a result, each with the names of what has it."""
    found: dict[str, list[str]] = {}
    for name, variable in result.variables.items():
        unit = str(variable.attrs.get("units", "1"))
        if unit != "1":
            found.setdefault(unit, []).append(str(name))
    return found


def described(result: Any) -> dict[str, Any]:
    """Return title, sizes and units of a result, and of a rig with its stop above what counts downwards."""
    down = downwards(result)
    return {
        "title": str(result.attrs.get("title", "")),
        "sizes": {str(name): size for name, size in result.sizes.items()},
        "units": units_of(result),
        **({"down": down} if down else {}),
    }


def write(result: Any, path: Path, **style: Any) -> list[str]:
    """Write a result to a file; return the names of all files that this made."""
    kind = path.suffix
    if kind in FIGURES:
        from grazing import plot
        from grazing.cli.figures import figure

        drawn = figure(result, **style)
        return [str(plot.save(drawn, path, result.attrs.get("title", ""), plot.provenance_of(result)))]
    if kind in (".csv", ".parquet"):
        from grazing.export import to_csv, to_parquet

        return [str(file) for file in (to_csv if kind == ".csv" else to_parquet)(result, path)]
    if kind == FILM:
        from grazing.measured import of_table
        from grazing.plot.animation import animate
        from grazing.plot.trajectory import table_in

        if not of_table(result):
            raise InputError(f"-o {path}: films are of a ball on a table; give --table, or another ending")
        return [str(animate(table_in(result), result, path))]
    if kind == SOUND:
        from grazing.signals.sound import audible, to_wav

        return [str(to_wav(result, path, audible(result)))]
    from grazing.io import save

    return [str(save(result, path))]


def named(files: Sequence[str]) -> str:
    """Return the names of files as a terminal may have them, in one line: a name may hold any letter."""
    return ", ".join(printable(file, newlines=False) for file in files)
