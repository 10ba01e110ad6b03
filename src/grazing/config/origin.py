"""The recipe of a result or a figure: the one it keeps, or one made from the configuration that it records."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grazing.catalogue import studies
from grazing.config.build import RECIPE, map_in
from grazing.config.check import Recipe, checked
from grazing.config.parameters import AMPLITUDES, GAP, LAWS, OF_LAWS, law_names
from grazing.config.schema import MAPS
from grazing.config.settings import settings_of
from grazing.config.values import extremes, values_of, written_as
from grazing.oscillator.si import base_of
from grazing.outcome import GrazingError, InputError, shown
from grazing.parameter import named_by
from grazing.studies.labels import fingerprint
from grazing.units import ASKED

#: What a model and a configuration call differently.
SAME = {"offset": "d"}
#: Maps by the names that they give themselves.
BY_NAME = {"stroboscopic map": "stroboscopic", "impact map": "impact", "gap map": "gap"}


def recipe_of(attrs: Mapping[str, Any], coordinates: Mapping[str, NDArray[np.float64]] | None = None) -> Recipe:
    """Return the recipe of a result.

    Parameters
    ----------
    attrs : mapping
        The attributes of a result, or the provenance of a figure.
    coordinates : mapping of str to ndarray, optional
        The values along the axes of the result, where they are at hand.

    Returns
    -------
    dict
        For :func:`plan_of`, :func:`result_of` and :func:`command_of`.

    Raises
    ------
    InputError
        If the result does not say enough: a map of one's own that only Python knows, values that are not evenly
        spaced and not at hand. The message says which.

    Examples
    --------
    >>> import grazing as gz, numpy as np
    >>> from grazing.config import command_of, recipe_of
    >>> G = gz.gap_map(lam=0.5, mu=0.1, l=0.2)
    >>> diagram = gz.orbit_diagram(G, "mu", np.linspace(0, 0.1, 5), starts=3)
    >>> print(command_of(recipe_of(diagram.attrs)))
    grazing diagram mu=0:0.1:5 --map gap --lam 0.5 --l 0.2 --starts 3
    """
    if not isinstance(attrs, Mapping) or hasattr(attrs, "attrs"):  # a dataset is a mapping of its variables
        raise InputError(f"attributes are {shown(attrs)}; give those of a result, result.attrs")
    if RECIPE in attrs:
        return checked(_decoded(attrs[RECIPE]) | _looked_at(attrs))
    if "grazing_config" not in attrs:
        raise InputError("it does not say how it was made")
    config = _decoded(attrs["grazing_config"])
    title = str(attrs.get("title", ""))
    known = [one for one in studies().values() if one.titled and title.startswith(one.titled)]
    if any(one.function != config.get("study") for one in known):
        raise InputError("an earlier version made it in Python, and did not say how far its branches were followed")
    try:
        return _recipe_in(config, coordinates or {}, title, attrs)
    except GrazingError:
        raise
    except (ValueError, TypeError, LookupError, AttributeError, ArithmeticError) as error:  # it can say anything
        raise InputError("its configuration is damaged") from error


def _recipe_in(
    config: Mapping[str, Any], coordinates: Mapping[str, NDArray[np.float64]], title: str, attrs: Mapping[str, Any]
) -> Recipe:
    study = next((name for name, known in studies().items() if known.function == config.get("study")), None)
    if study is None:
        raise InputError(f"its study {config.get('study')!r} is not one that a command can do")
    walls = _walls(config)  # which say themselves where they are
    recipe = {
        "study": study,
        **_map(config),
        **({"order": config["order"]} if "order" in config else {}),
        **{key: attrs[key] for key in ("mass", "stop") if key in attrs and not (key == "stop" and walls)},
        "vary": _ranges(config, coordinates, title),
        "settings": _settings(study, config),
        **_looked_at(attrs),
    }
    if "base" in attrs:
        base = base_of(attrs["base"])
        recipe["base"] = base.alone.text
        recipe["parameters"] |= {"cos": list(base.cos), "sin": list(base.sin) if any(base.sin) else []}
    try:
        return _own_box(checked(recipe), config)
    except GrazingError as error:
        raise InputError(f"its configuration is not one that a command can say ({error})") from error


def _looked_at(attrs: Mapping[str, Any]) -> Recipe:
    """Return the units that a result was converted to: they are no part of what was computed."""
    return {"units": attrs[ASKED]} if attrs.get(ASKED) else {}


def _decoded(value: Any) -> dict[str, Any]:
    try:
        found = json.loads(value) if isinstance(value, str) else value
    except (ValueError, RecursionError):
        found = None
    if not isinstance(found, dict):
        raise InputError("its configuration is damaged")
    return found


def _map(config: Mapping[str, Any]) -> Recipe:
    """Return map, law and parameters from the name of a map and its flat parameters."""
    name, params = str(config["map"]), dict(config["params"])
    kind, _, order = name.partition(", ")
    if kind == "discontinuity map":
        found: Recipe = {"map": "discontinuity", "order": order.removesuffix(" order")}
    elif name in BY_NAME:
        found = {"map": BY_NAME[name]}
    else:
        raise InputError(f"its map, {name}, is known to Python alone; allowed are {', '.join(MAPS)} and file.py:name")
    if found["map"] == "gap":
        return {**found, "parameters": {name: params[name] for name in GAP if name in params}}
    if "law" in config:
        raise InputError("its reset law is known to Python alone")
    named = {*params, *_axes(config)}
    walls = _walls(config)
    waves = _waves(params, named, "", 0 if walls else 1)
    if not walls:
        flight = {SAME.get(key, key): value for key, value in params.items()}
        return {**found, "law": _law(named), "parameters": {**flight, **waves}}
    for wall in walls:
        waves |= {key: item for key, item in _waves(params, named, f"{wall}.", 0).items() if item}
    if shared := named & {*OF_LAWS} - {"r"}:  # every law has r
        raise InputError(f"it does not say of which walls {', '.join(sorted(shared))} is")
    laws = {wall: _law({name.removeprefix(f"{wall}.") for name in named}) for wall in walls}
    return {**found, "walls": laws, "parameters": {**params, **waves}}


def _walls(config: Mapping[str, Any]) -> list[str]:
    """Return the names of two walls from below, as a configuration has them; none of a single wall."""
    known = dict(config["params"]) | {name: item["first"] for name, item in _axes(config).items()}
    places = {name.removesuffix(".sigma"): place for name, place in known.items() if name.endswith(".sigma")}
    return sorted(places, key=lambda wall: places[wall])


def _waves(params: dict[str, Any], named: set[str], front: str, least: int) -> dict[str, list[float]]:
    """Take the amplitudes of the forcing, or of a wall's motion, out of flat parameters; return them as lists."""
    amplitudes = [f"{front}{key}" for key in AMPLITUDES]
    own = (name[len(front) + 3 :] for name in named if name[: len(front) + 3] in amplitudes)
    m = max([least, *(int(number) for number in own if number.isdigit())])
    if m > len(named) + 1:  # each harmonic has a number of its own
        raise InputError("its configuration is damaged")
    waves = {key: [params.pop(f"{key}{j}", 0.0) for j in range(1, m + 1)] for key in amplitudes}
    sines = waves[amplitudes[1]]
    while sines and sines[-1] == 0.0:  # the cosines say how many harmonics there are
        sines.pop()
    return waves


def _law(named: set[str]) -> str:
    """Return the reset law of a wall with these parameters."""
    has = named & {*OF_LAWS}
    law = next((law for law in LAWS if set(law_names(law)) == has), None)
    if law is None:
        raise InputError("its reset law is known to Python alone")
    return law


def _axes(config: Mapping[str, Any]) -> dict[str, Any]:
    """Return what varies, each with its description: first, last, count, sha256."""
    if "parameter" in config:
        return {config["parameter"]: config["values"]}
    for key in ("parameters", "grid"):
        found = config.get(key)
        if (
            isinstance(found, dict)
            and found
            and all(isinstance(item, dict) and "sha256" in item for item in found.values())
        ):
            return dict(found)
    return {}


def _ranges(config: Mapping[str, Any], coordinates: Mapping[str, NDArray[np.float64]], title: str) -> Recipe:
    """Return what varies, in order: that of the result's dimensions; a figure has its title, JSON sorts its keys."""
    found: Recipe = {}
    axes = _axes(config)
    order = list(coordinates) if {*axes} <= {*coordinates} else title.split()
    for name, described in sorted(axes.items(), key=lambda item: order.index(item[0]) if item[0] in order else 0):
        for text in (f"{described['first']!r}:{described['last']!r}:{described['count']}{log}" for log in ("", ":log")):
            try:
                if fingerprint(values_of(text)) == described["sha256"]:
                    found[name] = _short(text)
                    break
            except InputError:
                continue
        else:
            if name not in coordinates:
                raise InputError(
                    f"its values of {name} are not evenly spaced and were not kept; save the result as .nc too"
                )
            values = np.asarray(coordinates[name], np.float64)
            if fingerprint(values) != described["sha256"]:
                raise InputError(f"its values of {name} were converted to other units; save the result in SI units too")
            found[name] = written_as(values)
    return found if _walls(config) else {SAME.get(name, name): written for name, written in found.items()}


def _short(text: str) -> str:
    """Return a range with whole numbers written as such."""
    return ":".join(part.removesuffix(".0") for part in text.split(":"))


def _own_box(recipe: Recipe, config: Mapping[str, Any]) -> Recipe:
    """Leave out a box of random starts that is the map's own, once or at every value; refuse one that is not clear."""
    starts = config.get("starts")
    moves = starts.get("box") if isinstance(starts, dict) else None
    box = recipe["settings"].get("box")
    if box is None and not isinstance(moves, dict):
        return recipe
    P = map_in(recipe)
    sides = {name: values_of(written) for name, written in recipe["vary"].items() if named_by(name, P.params)}
    first, last = (P.replace(**{name: float(values[at]) for name, values in sides.items()}).box for at in (0, -1))
    if isinstance(moves, dict):
        if moves["moves"] != [[list(pair) for pair in own] for own in (first, last)]:
            raise InputError(
                "its starts were drawn in boxes of its model that move with what varies, and the model that a command "
                "makes has others; in Python, give box"
            )
        return recipe
    ends = [P.replace(**{name: end}).box for name in sides for end in extremes(recipe["vary"][name])]
    if any(own != P.box for own in (first, last, *ends)):
        raise InputError("it does not say whether its starts were drawn in boxes that move with what varies")
    if [list(pair) for pair in P.box] == box:
        return {**recipe, "settings": {key: item for key, item in recipe["settings"].items() if key != "box"}}
    return recipe


def _settings(study: str, config: Mapping[str, Any]) -> Recipe:
    """Return the settings that a configuration records; random starts are recorded with their seed and box."""
    names = settings_of(study).model_fields
    found = {name: config[name] for name in names if config.get(name) is not None}
    starts = config.get("starts")
    if isinstance(starts, dict):
        if "random" not in starts:
            raise InputError("its starts were given and only their fingerprint was kept")
        found |= {"starts": starts["random"], "seed": starts["seed"]}
        box = starts.get("box")
        if box is not None and not isinstance(box, dict):  # one that moves is the map's own
            found["box"] = box
    return found
