"""``grazing plot``: draw a stored result."""

from __future__ import annotations

import json as text
import warnings
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from grazing.catalogue import studies
from grazing.cli import output
from grazing.cli.figures import drawing, drawn, study_of, style_of
from grazing.cli.own import OwnMap, OwnModel, named_here
from grazing.cli.stored import Missing, axes_of, curve_in, loaded
from grazing.outcome import GrazingError, InputError, in_one_line, printable

#: What drawing raises when variables are missing, of another type or form, or hold texts that are no labels.
MISFIT = (ValueError, TypeError, LookupError, AttributeError, ArithmeticError, StopIteration, RecursionError)


def plot(
    file: Annotated[Path, Parameter(name="RESULT", help="What a study saved: a file .nc or a store .zarr.")],
    /,
    *,
    out: Annotated[
        list[Path] | None,
        Parameter(name=("--out", "-o"), help="Figure to write, png, pdf or svg; may be repeated.", metavar="FILE"),
    ] = None,
    style: Annotated[
        list[str] | None,
        Parameter(
            help="Argument of the figure's function, such as by=exponent for a chart; may be repeated.",
            metavar="NAME=VALUE",
        ),
    ] = None,
    curves: Annotated[
        list[Path] | None,
        Parameter(
            help="Drawn on a chart in place of the curves that it was made with: the exact boundary curves of periods, "
            "2,3,5 or 2:7, or a stored branch or locus; may be repeated.",
            metavar="LIST|FILE",
        ),
    ] = None,
    units: Annotated[str | None, Parameter(help=output.UNITS, metavar="LIST")] = None,
    map: OwnMap = None,
    model: OwnModel = None,
    json: Annotated[bool, Parameter(help="Print a summary as one JSON object.", show_default=False)] = False,
) -> int:
    """Draw any stored result.

    The figure is that of its study: 'grazing plot chart.zarr -o chart.pdf --style by=exponent'.
    """
    if not out:
        raise InputError("nothing to write; give -o and a figure's name, such as -o figure.pdf")
    files, chosen = output.targets(out, output.FIGURES), output.checked_units(units)
    result = loaded(file)
    if "grazing_incomplete" in result.attrs:
        warnings.warn(f"{file} is not complete: {result.attrs['grazing_incomplete']}", stacklevel=2)
    arguments = styled(style or [], study_of(result.attrs))
    result, arguments = with_drawn(result, arguments, [str(one) for one in curves or ()] or None, file, map, model)
    result = output.converted(result, chosen)
    try:
        written = [name for path in files for name in output.write(result, path, **arguments)]
    except MISFIT as error:  # a file may say anything; what we computed ourselves is drawn elsewhere
        if isinstance(error, GrazingError):
            raise
        study = study_of(result.attrs)
        raise InputError(
            f"{file} does not hold what the figure of {study} shows ({type(error).__name__}: {in_one_line(error)}); "
            f"it was changed, or saved by another version: compute it again"
        ) from error
    title = printable(str(result.attrs.get("title", "")), newlines=False)
    print(text.dumps({"title": title, "files": written}) if json else f"{title}\nwritten: {output.named(written)}")
    return 0


def with_drawn(
    result: Any,
    arguments: dict[str, Any],
    curves: list[str] | None,
    file: Path,
    map: str | None = None,
    model: str | None = None,
) -> tuple[Any, dict[str, Any]]:
    """Return a result that says what its figure shows beside it, and all arguments of the figure.

    That are the boundary curves on a chart, and the coordinate that a graph shows.

    Parameters
    ----------
    result : xarray.Dataset
    arguments : dict
        Of the figure, as they were given.
    curves : list of str or None
        Periods and files; None for those that its recipe names, if any.
    file : Path
        Where the result is from, for the message.
    map, model : str, optional
        Code of the user that this call names; curves are computed from it.
    """
    from grazing.config import checked, recipe_of
    from grazing.config.build import RECIPE, kept
    from grazing.config.own import NotNamed
    from grazing.config.values import curves as checked_curves

    figure = study_of(result.attrs)
    keys = [key for known in studies().values() if known.drawn_by == figure for key in known.beside]
    if map is not None or model is not None:  # said here, where no other error is taken for it
        named_here(recipe_of(result.attrs, axes_of(result)), map, model, file)
    if curves is not None and "curves" not in keys:
        raise InputError(f"--curves: {file} is no chart; leave it out")
    given = {"curves": curves, **arguments}
    changed = {key: given[key] for key in keys if given.get(key) is not None}
    if not changed and not any(f'"{key}": ' in str(result.attrs.get(RECIPE, "")) for key in keys):
        return result, arguments
    try:
        recipe = recipe_of(result.attrs, axes_of(result))
        recipe |= named_here(recipe, map, model, file)
    except GrazingError as error:
        if curves is None:
            return result, arguments
        files = [one for one in checked_curves(curves, "curves") if isinstance(one, str)]
        if len(files) < len(curves):
            raise InputError(f"--curves: {file} does not say which map it is of: {error}") from None
        return result, {**arguments, "curves": [curve_in(one) for one in files]}
    if changed:
        recipe = checked({**recipe, **changed})
        result = result.assign_attrs({RECIPE: text.dumps(kept(recipe), sort_keys=True)})
    try:
        return result, {**arguments, **style_of(recipe, quiet=False)}
    except (NotNamed, Missing) as error:
        if curves is not None:
            raise
        warnings.warn(f"the curves are left out: {error}", stacklevel=2)
        return result, arguments


def styled(given: list[str], study: str) -> dict[str, Any]:
    """Return arguments for the function of a figure, refusing those that it does not have."""
    import inspect

    from grazing.config.problems import unknown_key

    function = drawing(study) if study in drawn() else None
    if not given or function is None:
        return {}
    known = {
        name: item
        for name, item in inspect.signature(function).parameters.items()
        if item.default is not item.empty and name != "ax"
    }
    found: dict[str, Any] = {}
    for item in given:
        name, equals, value = item.partition("=")
        if not equals:
            raise InputError(f"--style {item}; give NAME=VALUE, such as {next(iter(known), 'ax')}=...")
        if name not in known:
            raise InputError(f"--style {item}: {unknown_key(name, known, 'unknown argument')}")
        switch = str(known[name].annotation).startswith("bool")  # which may be left to the figure: None
        found[name] = _typed(value, True if switch else known[name].default, item)
    return found


def _typed(value: str, default: Any, item: str) -> Any:
    """Return a text as the type of the default that it replaces."""
    if isinstance(default, bool):
        if value.lower() not in ("true", "false", "yes", "no", "1", "0"):
            raise InputError(f"--style {item}: allowed are true and false")
        return value.lower() in ("true", "yes", "1")
    for kind in (int, float):
        if default is None or isinstance(default, (int, float)):
            try:
                return kind(value)
            except ValueError:
                continue
    if isinstance(default, (int, float)):
        raise InputError(f"--style {item}: give a number")
    return value
