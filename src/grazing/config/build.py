"""What a configuration asks for: the plan of a study, and its result."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

from grazing.catalogue import studies
from grazing.catalogue.study import Study
from grazing.config.check import Recipe, checked
from grazing.config.maps import has_beside, map_of, model_of, parameter_defaults
from grazing.config.own import refuse_unnamed
from grazing.config.parameters import described
from grazing.config.schema import ALONE
from grazing.config.values import DEFAULT, extremes, values_of
from grazing.late import named
from grazing.maps.map import Map
from grazing.orbits.boundaries import boundaries
from grazing.outcome import InputError
from grazing.parameter import named_by
from grazing.studies.labels import own_version, versions
from grazing.studies.plan import Plan, Progress, run_plan

if TYPE_CHECKING:
    import xarray as xr

#: The attribute of a result that keeps the recipe it was made from, as JSON.
RECIPE = "grazing_recipe"


def map_in(recipe: Recipe) -> Map:
    """Return the map of a recipe; a parameter that varies and has no default is at the first of its values."""
    given, known = dict(recipe["parameters"]), parameter_defaults(recipe)
    for name, default in known.items():
        if default is None and name not in given:
            [written] = (written for one, written in recipe["vary"].items() if name in named_by(one, known))
            given[name] = float(values_of(written)[0])
    return map_of({**recipe, "parameters": given})


def plan_of(config: Mapping[str, Any], *, code: str | None = None) -> Plan:
    """Return the plan of the study that a configuration asks for.

    Parameters
    ----------
    config : mapping
        As a TOML file has it, or the recipe that a result or a store keeps.
    code : {"trust"}, optional
        Run the file of your own that ``map`` or ``model`` names; without it such a configuration is refused.

    Returns
    -------
    Plan
        With the recipe, from which it can be made again.

    Raises
    ------
    InputError
        With all errors of the configuration; or for a study without a plan, which is computed as a whole.

    Examples
    --------
    >>> from grazing.config import plan_of
    >>> config = {"study": "diagram", "map": "gap", "parameters": {"lam": 0.5, "l": 0.1}, "vary": {"mu": "0:0.1:5"}}
    >>> plan = plan_of(config)
    >>> plan.cells, plan.recipe["settings"]["starts"]
    (5, 100)
    """
    recipe = checked(config, code=code)
    refuse_unnamed(recipe)
    study = studies()[recipe["study"]]
    if not study.plan:
        others = ", ".join(name for name, known in studies().items() if known.plan)
        raise InputError(f"{study.name} is computed as a whole and has no cells to sweep; allowed are {others}")
    plan: Plan = study.plan(map_in(recipe), *varied(study, recipe), **recipe["settings"])
    if study.kept:  # found by a trial, whose last digits another machine need not repeat
        found = {name: list(plan.config[name]) for name in study.kept}
        recipe = {**recipe, "settings": {**recipe["settings"], **found}}
    return replace(plan, recipe=kept(recipe))


def varied(study: Study, recipe: Recipe) -> tuple[Any, ...]:
    """Return what varies as arguments: one parameter by its name and values or bounds, several as a mapping."""
    if study.form == "bounds":
        [(name, written)] = recipe["vary"].items()
        return name, None if written == DEFAULT else tuple(extremes(written))
    grid = {name: values_of(written) for name, written in recipe["vary"].items()}
    return (grid or None,) if study.most > 1 else next(iter(grid.items()), ())


def boundaries_of(config: Mapping[str, Any], *, code: str | None = None) -> xr.Dataset | None:
    """Return the exact boundary curves that a configuration wants on its chart; None if it wants none.

    Parameters
    ----------
    config : mapping
        As a TOML file has it.
    code : {"trust"}, optional
        See :func:`plan_of`.

    Raises
    ------
    OutsideForm
        For a map without such a theory.

    Examples
    --------
    >>> from grazing.config import boundaries_of
    >>> config = {"study": "chart", "map": "gap", "parameters": {"lam": 0.9}, "curves": "3:4"}
    >>> boundaries_of({**config, "vary": {"l": "0:1:9", "mu": "0:0.4:9"}}).label.values.tolist()
    ['3 pd', '3 bc', '4 pd', '4 bc']
    """
    recipe = checked(config, code=code)
    periods = [one for one in recipe.get("curves") or () if isinstance(one, int)]
    if not periods:
        return None
    refuse_unnamed(recipe)
    sides = [(name, values_of(written)) for name, written in recipe["vary"].items()]
    for name, values in sides:
        if values.min() == values.max():
            raise InputError(f"curves need a plane, but {name} is always {values[0]:g}; give it a range, or no curves")
    return boundaries(map_in(recipe), *sides, N=periods)


def model_near(recipe: Recipe, name: str = "", ends: tuple[float, ...] | None = None) -> Any:
    """Return the model of a recipe; a parameter that varies and has no value is in the middle of its range."""
    given, defaults = dict(recipe["parameters"]), parameter_defaults(recipe)
    absent = [one for one in named_by(name, defaults) if one not in given and defaults[one] is None]
    if absent:
        known = described(name)  # without bounds all of its values are searched, whichever it has
        given |= dict.fromkeys(absent, 0.5 * sum(ends or (known.low, known.high)))
    return model_of({**recipe, "parameters": given})


def signed(result: xr.Dataset) -> xr.Dataset:
    """Return a result that says what made it."""
    versions_of = json.dumps(versions(), sort_keys=True)
    result.attrs |= {"source": f"grazing {own_version()}", "grazing_versions": versions_of}
    return result


def kept(recipe: Recipe) -> Recipe:
    """Return a recipe as results and stores keep it: what varies in pairs, whose order survives sorted keys.

    Units are those of one look at a result, which has its own.
    """
    rest = {key: value for key, value in recipe.items() if key != "units"}
    return {**rest, "vary": [list(item) for item in recipe["vary"].items()]}


def result_of(
    config: Mapping[str, Any],
    *,
    threads: int | None = None,
    progress: Progress | None = None,
    code: str | None = None,
) -> xr.Dataset:
    """Return the result of what a configuration asks for, computed in memory.

    Parameters
    ----------
    config : mapping
        As a TOML file has it.
    threads : int, optional
        None for one per processor; the result does not depend on it.
    progress : callable, optional
        ``progress(done, total)``.
    code : {"trust"}, optional
        See :func:`plan_of`.

    Returns
    -------
    xarray.Dataset
        What the function of the study returns; its attribute ``grazing_recipe`` keeps the configuration.

    Examples
    --------
    >>> from grazing.config import result_of
    >>> config = {"study": "cobweb", "map": "gap", "parameters": {"lam": 0.5, "mu": 0.1, "l": 0.1}}
    >>> dict(result_of({**config, "settings": {"state": [0.0], "steps": 3}}).sizes)
    {'n': 4, 'step': 3, 'place': 1202}
    """
    return made_of(config, threads, progress, code).result


class Made(NamedTuple):
    """What was computed: of which map or model, what the study's function returned, and that as a labelled result."""

    of: Any
    found: Any
    result: xr.Dataset


def made_of(
    config: Mapping[str, Any], threads: int | None = None, progress: Progress | None = None, code: str | None = None
) -> Made:
    """Compute what a configuration asks for, see :func:`result_of`.

    Examples
    --------
    >>> from grazing.config.build import made_of
    >>> config = {"study": "orbit", "map": "gap", "parameters": {"lam": 0.8, "mu": 0.5, "l": 1.0}}
    >>> [orbit.word for orbit in made_of({**config, "settings": {"period": "1:3"}}).found]
    ['LR', 'LLR']
    """
    recipe = checked(config, code=code)
    refuse_unnamed(recipe)
    study = studies()[recipe["study"]]
    if study.plan:
        plan = plan_of(recipe)
        of, found = plan.P, run_plan(plan, threads, progress)
    else:
        arguments = varied(study, recipe) if study.most else ()
        of = model_near(recipe, *arguments) if study.of == "model" else map_in(recipe)
        order = recipe["order"] if has_beside(recipe) and recipe["order"] != ALONE else None
        also: dict[str, Any] = {"threads": threads, "progress": progress, "order": order}
        if study.has("span"):  # it may stand behind other arguments
            also["span"], arguments = arguments[-1], arguments[:-1]
        more = {name: value for name, value in also.items() if study.has(name)}
        found = named(study.compute)(of, *arguments, **more, **recipe["settings"])
    result = found if not study.table else named(study.table)(found)
    result = result if study.plan else signed(result)
    result.attrs[RECIPE] = json.dumps(kept(recipe), sort_keys=True)
    return Made(of, found, result)
