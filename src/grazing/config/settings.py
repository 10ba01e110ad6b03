"""The studies that can be asked for, and their settings: defaults are those of the functions."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from typing import Annotated, Any

from pydantic import BeforeValidator, Field, WithJsonSchema, create_model

from grazing.config import values
from grazing.config.parameters import Table
from grazing.outcome import InputError, shown


@dataclass(frozen=True)
class Study:
    """A study: the function that does it, how many parameters or coordinates it varies, and what it says of itself.

    ``form`` is how what varies is written: *values* (start:stop:count or a list) or *bounds* (low:high). ``of`` is
    what the function takes: a *map*, or the *model* itself.
    """

    function: str
    module: str
    least: int
    most: int
    varies: str
    says: str
    form: str = "values"
    of: str = "map"


ONE, COORDINATE = "parameter", "coordinate"
STUDIES = {
    "diagram": Study(
        "orbit_diagram", "studies.orbit_diagram", 1, 1, ONE, "where orbits settle as one parameter varies"
    ),
    "density": Study("density", "studies.density", 1, 1, ONE, "how often orbits visit each part of a range"),
    "chart": Study("chart", "studies.chart", 2, 2, ONE, "periods and words as two parameters vary"),
    "basins": Study("basins", "studies.basins", 0, 2, COORDINATE, "which attractor each initial state reaches"),
    "lyapunov": Study("lyapunov", "studies.lyapunov", 0, 1, ONE, "Lyapunov exponents"),
    "coexistence": Study("coexistence", "studies.coexistence", 1, 1, ONE, "all attractors and their shares"),
    "trajectory": Study(
        "trajectory", "oscillator.trajectory", 0, 0, ONE, "one orbit in time, with every impact", of="model"
    ),
    "history": Study("history", "signals.record", 0, 0, ONE, "position or velocity of one orbit over time", of="model"),
    "sample": Study("sampled", "signals.record", 0, 0, ONE, "one orbit at equal times, as it is recorded", of="model"),
    "spectrum": Study("spectrum_of", "signals.record", 0, 0, ONE, "amplitudes of one orbit by frequency", of="model"),
    "cobweb": Study("cobweb", "studies.cobweb", 0, 0, ONE, "one orbit of a one-dimensional map, step by step"),
    "graph": Study("graph", "studies.graph", 1, 1, COORDINATE, "one step of the map along a line of states"),
    "orbit": Study("periodic_orbits", "orbits.periodic", 0, 0, ONE, "periodic orbits, stable and unstable"),
    "branch": Study(
        "branches", "compare.word_branches", 1, 1, ONE, "periodic orbits followed in a parameter", form="bounds"
    ),
    "windows": Study(
        "window_table", "config.orbits", 1, 1, ONE, "where stable one-impact orbits exist", form="bounds", of="model"
    ),
    "bifurcations": Study(
        "bifurcation_diagram", "compare.bifurcation_diagram", 1, 1, ONE, "a scan and the branches through it"
    ),
    "response": Study(
        "response", "compare.response", 1, 1, ONE, "what instruments read going up, going down and from random starts"
    ),
}
#: Studies of one orbit, which begins at a state that is given; those in continuous time first.
FLOWN = ("trajectory", "history", "sample", "spectrum")
SINGLE = (*FLOWN, "cobweb")
#: Studies that are computed as a whole: they have no cells to sweep.
WHOLE = (*SINGLE, "graph", "orbit", "branch", "windows", "bifurcations", "response")


def _setting(check: Callable[[Any, str], Any], schema: Mapping[str, Any], says: str) -> Callable[[str, Any], Any]:
    """Return what makes the field of a setting from its name and its default."""

    def field(name: str, default: Any) -> Any:
        def checked(value: Any) -> Any:
            return None if value is None else check(value, name)

        kind = Annotated[Any, BeforeValidator(checked), WithJsonSchema(dict(schema))]
        return kind, Field(default=default, description=says)

    return field


def _whole(low: int, says: str) -> Callable[[str, Any], Any]:
    return _setting(lambda value, name: values.count(value, name, low), {"type": "integer", "minimum": low}, says)


def _choice(choices: tuple[str, ...], says: str) -> Callable[[str, Any], Any]:
    def check(value: Any, name: str) -> str:
        if value not in choices:
            raise InputError(f"{name} = {shown(value)}; allowed are {', '.join(choices)}")
        return str(value)

    return _setting(check, {"enum": list(choices)}, says)


def _text(value: Any, name: str) -> str:
    if not isinstance(value, str) or not value:
        raise InputError(f"{name} = {shown(value)}; give a name")
    return value


def _switch(says: str) -> Callable[[str, Any], Any]:
    def check(value: Any, name: str) -> bool:
        if isinstance(value, str) and value.lower() in ("true", "false"):
            return value.lower() == "true"
        if not isinstance(value, bool):
            raise InputError(f"{name} = {shown(value)}; allowed are true and false")
        return value

    return _setting(check, {"type": "boolean"}, says)


PAIR = {"type": "array", "items": {"type": "number"}, "minItems": 2, "maxItems": 2}
STATE = {"type": "array", "items": {"type": "number"}}
WHOLES = {"type": "array", "items": {"type": "integer", "minimum": 1}}

SETTINGS: dict[str, Callable[[str, Any], Any]] = {
    "starts": _setting(
        values.states,
        {"anyOf": [{"type": "integer", "minimum": 1}, {"type": "array", "items": STATE}]},
        "number of random starts, or the starts themselves: 0.1,0;0.2,0",
    ),
    "transient": _whole(0, "steps that are thrown away"),
    "keep": _whole(1, "steps that are kept; periods up to half of them can be seen"),
    "seed": _setting(
        lambda value, name: values.count(value, name, 0, 2**64 - 1),
        {"type": "integer", "minimum": 0},
        "seed of the random starts",
    ),
    "sweep": _choice(("up", "down"), "start each value where the one before it ended, upwards or downwards"),
    "bins": _whole(1, "pixels along the coordinate"),
    "coordinate": _setting(_text, {"type": "string"}, "coordinate that is counted; the first one if not given"),
    "range": _setting(values.pair, PAIR, "low:high of the coordinate; found from the orbits if not given"),
    "steps": _whole(1, "steps along which exponents are averaged; of a cobweb, those that are drawn"),
    "exponent_steps": _whole(1, "steps along which the exponent of each attractor is averaged, at most 1000000"),
    "fixed": _setting(
        values.by_name,
        {"type": "object", "additionalProperties": {"type": "number"}},
        "coordinates that do not vary: v=0, commas between several",
    ),
    "preimages": _whole(0, "how many preimages of the grazing curve are found"),
    "box": _setting(
        values.pairs,
        {"type": "array", "items": PAIR},
        "where random starts are drawn: low:high for each coordinate, commas between",
    ),
    "arithmetic": _choice(("fast", "strict"), "strict for the same bits on every machine"),
    "state": _setting(values.numbers, STATE, "initial state, commas between the coordinates"),
    "start": _setting(values.number, {"type": "number"}, "time of the initial state"),
    "until": _setting(values.number, {"type": "number"}, "time of the end"),
    "samples": _whole(2, "points per period of the forcing"),
    "since": _setting(values.number, {"type": "number"}, "time before which nothing is recorded; start if not given"),
    "rate": _setting(
        values.number, {"type": "number"}, "samples per unit of time, in Hz of a rig; 128 a period if not given"
    ),
    "of": _choice(("u", "v"), "position or velocity"),
    "window": _setting(_text, {"type": "string"}, "window of the spectrum, such as hann, boxcar or flattop"),
    "period": _setting(values.wholes, WHOLES, "least periods, in steps of the map: 3, 2,3 or 1:6"),
    "word": _setting(_text, {"type": "string"}, "word of the orbits, such as 001, or LLR for the gap map"),
    "virtual": _switch("include virtual orbits, which the map does not have"),
    "at": _setting(
        values.numbers, STATE, "values of the parameter at which orbits are looked for; 9 within the range if not given"
    ),
    "locus": _setting(
        values.bounds_by_name,
        {"type": "object", "additionalProperties": PAIR, "maxProperties": 1},
        "second parameter, NAME=LOW:HIGH, in which the special points are followed",
    ),
    "step": _setting(values.number, {"type": "number"}, "longest step along a branch, in units of the range"),
    "limit": _whole(2, "most points of one piece of a branch"),
    "points": _whole(2, "most points of all branches together"),
    "N": _setting(values.wholes, WHOLES, "periods of the forcing between impacts, 1 to 1000: 3, 2,3 or 2:7"),
    "sensitivity": _switch("add the derivatives of all edges in every parameter"),
}
#: Settings that say something else in one study.
_SEARCH = _whole(1, "random starts of the search for orbits")
OWN = {
    ("orbit", "starts"): _SEARCH,
    ("branch", "starts"): _SEARCH,
    ("windows", "samples"): _whole(2, "cells of the first grid"),
    ("bifurcations", "period"): _whole(1, "longest period of an attractor that is followed"),
    ("response", "period"): _whole(1, "longest period of an attractor that is followed"),
}
#: Arguments of the functions that are no settings: what is studied, and what the numbers do not depend on.
ARGUMENTS = {"P", "model", "name", "values", "bounds", "span", "params", "grid", "order", "threads", "progress"}


def function_of(study: str) -> Callable[..., Any]:
    """Return the function that does a study."""
    known = STUDIES[study]
    return getattr(import_module(f"grazing.{known.module}"), known.function)  # type: ignore[no-any-return]


@cache
def settings_of(study: str) -> type[Table]:
    """Return the table of a study's settings: those arguments of its function that decide the numbers."""
    fields: dict[str, Any] = {}
    for name, item in inspect.signature(function_of(study)).parameters.items():
        if name in SETTINGS:
            default = ... if item.default is inspect.Parameter.empty else item.default
            fields[name] = OWN.get((study, name), SETTINGS[name])(name, default)
    return create_model(
        f"{study.capitalize()}Settings", __base__=Table, __doc__=f"How the {study} is computed.", **fields
    )


def text_of(name: str, value: Any) -> str:
    """Return the value of a setting, parameter or range as a command line writes it; the checks read it back.

    Examples
    --------
    >>> text_of("box", [[0.0, 1.0], [-2.0, 2.0]]), text_of("starts", [[0.1, 0.0], [0.2, 0.0]])
    ('0.0:1.0,-2.0:2.0', '0.1,0.0;0.2,0.0')
    """
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, Mapping):
        form = "range" if name == "locus" else ""
        return ",".join(f"{key}={text_of(form, item)}" for key, item in value.items())
    if not isinstance(value, (list, tuple)):
        return str(value)
    if name == "box":
        return ",".join(text_of("range", item) for item in value)
    if name == "starts":
        return ";".join(text_of("", item) for item in value) + (";" if len(value) == 1 else "")
    return (":" if name == "range" else ",").join(repr(item) for item in value)
