"""Figures of results: the function that a study has, and what is drawn beside its result."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from importlib import import_module
from typing import Any

from grazing.catalogue import studies
from grazing.cli import progress
from grazing.cli.stored import curve_in
from grazing.config import boundaries_of
from grazing.outcome import InputError, shown


def figure(result: Any, **style: Any) -> Mapping[str, Any]:
    """Draw a result with the function that its study has.

    Raises
    ------
    InputError
        For a result of no study that has a figure.
    """
    study = study_of(result.attrs)
    if study not in drawn():
        raise InputError(
            f"there is no figure of {shown(study) if study else 'a result that does not say its study'}; "
            f"allowed are {', '.join(drawn())}"
        )
    whole: Callable[..., Mapping[str, Any]] = getattr(module_of(study), "whole", drawing(study))
    return whole(result, **style)


def module_of(name: str) -> Any:
    """Return the module of a figure; where that of a result is more than its axes, it has a function ``whole``."""
    return import_module(f"grazing.plot.{name}")


def drawing(name: str) -> Callable[..., Mapping[str, Any]]:
    """Return the function that draws a figure on axes."""
    return getattr(module_of(name), name)  # type: ignore[no-any-return]


def drawn() -> list[str]:
    """Return the names of the functions that draw results of studies."""
    return list(dict.fromkeys(study.drawn_by for study in studies().values() if study.drawn_by))


def study_of(attrs: Mapping[str, Any]) -> str:
    """Return the function of the figure that a result has."""
    title = str(attrs.get("title", ""))
    for known in studies().values():
        if known.titled and title.startswith(known.titled):
            return known.drawn_by
    of = "grazing_config" if "grazing_config" in attrs else "grazing_recipe"
    try:
        said = json.loads(attrs.get(of, "{}"))
        if not isinstance(said, dict):
            raise ValueError("it is no table")
    except (ValueError, TypeError, RecursionError) as error:
        raise InputError(f"the result is damaged: {of} cannot be read ({error}); compute it again") from error
    study = str(said.get("study", title.partition(" ")[0] if of == "grazing_recipe" else ""))
    for known in studies().values():
        if study in (known.name, known.function):
            return known.drawn_by or known.name
    return study if "study" in said else ""


def style_of(recipe: Mapping[str, Any], quiet: bool) -> dict[str, Any]:
    """Return what a figure shows beside its result, as arguments: boundary curves of a chart, one coordinate."""
    if not recipe.get("curves"):
        return {"coordinate": recipe["coordinate"]} if recipe.get("coordinate") else {}
    stored = [curve_in(one) for one in recipe["curves"] if isinstance(one, str)]
    with progress.said("following the boundary curves", quiet or len(stored) == len(recipe["curves"])):
        exact = boundaries_of(recipe)
    return {"curves": [*([] if exact is None else [exact]), *stored]}
