"""The settings of studies: defaults are those of their functions."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from functools import cache
from typing import Any

from pydantic import Field, create_model

from grazing.catalogue import studies
from grazing.config import values
from grazing.config.parameters import Table, optional
from grazing.late import named
from grazing.outcome import InputError, shown


def _setting(check: Callable[[Any, str], Any], schema: Mapping[str, Any], says: str) -> Callable[[str, Any], Any]:
    """Return what makes the field of a setting from its name and its default."""

    def field(name: str, default: Any) -> Any:
        return optional(lambda value: check(value, name), schema), Field(default=default, description=says)

    return field


def _whole(low: int, says: str) -> Callable[[str, Any], Any]:
    return _setting(lambda value, name: values.count(value, name, low), {"type": "integer", "minimum": low}, says)


def _number(says: str) -> Callable[[str, Any], Any]:
    return _setting(values.number, {"type": "number"}, says)


def _choice(choices: tuple[str, ...], says: str) -> Callable[[str, Any], Any]:
    def check(value: Any, name: str) -> str:
        if value not in choices:
            raise InputError(f"{name} = {shown(value)}; allowed are {', '.join(choices)}")
        return str(value)

    return _setting(check, {"enum": list(choices)}, says)


def _text(says: str) -> Callable[[str, Any], Any]:
    def check(value: Any, name: str) -> str:
        if not isinstance(value, str) or not value:
            raise InputError(f"{name} = {shown(value)}; give a text")
        return value

    return _setting(check, {"type": "string"}, says)


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
    "coordinate": _text("coordinate that is counted; the first one if not given"),
    "range": _setting(values.pair, PAIR, "low:high of the coordinate; found from the orbits if not given"),
    "within": _setting(
        values.pairs,
        {"type": "array", "items": PAIR, "minItems": 2, "maxItems": 2},
        "what is shown: low:high across, then up; found from the orbits if not given",
    ),
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
    "start": _number("time of the initial state"),
    "until": _number("time of the end"),
    "samples": _whole(2, "points per period of the forcing"),
    "since": _number("time before which all is left out; start if not given"),
    "rate": _number("samples per unit of time, in Hz of a rig; 128 a period if not given"),
    "of": _choice(("u", "v"), "position or velocity"),
    "window": _text("window of the spectrum, such as hann, boxcar or flattop"),
    "period": _setting(values.wholes, WHOLES, "least periods, in steps of the map: 3, 2,3 or 1:6"),
    "word": _text("word of the orbits, such as 001, or LLR for the gap map"),
    "virtual": _switch("include virtual orbits, which the map does not have"),
    "at": _setting(
        values.numbers, STATE, "values of the parameter at which orbits are looked for; 9 within the range if not given"
    ),
    "locus": _setting(
        values.bounds_by_name,
        {"type": "object", "additionalProperties": PAIR, "maxProperties": 1},
        "second parameter, NAME=LOW:HIGH, in which the special points are followed",
    ),
    "step": _number("longest step along a branch, in units of the range"),
    "limit": _whole(2, "most points of one piece of a branch"),
    "points": _whole(2, "most points of all branches together"),
    "N": _setting(
        values.wholes,
        WHOLES,
        "periods of the forcing between impacts, 1 to 1000: 3, 2,3 or 2:7",
    ),
    "sensitivity": _switch("add the derivatives of all edges in every parameter"),
}
#: Kinds of settings that a study can have of its own, see :attr:`grazing.catalogue.study.Study.options`.
KINDS: dict[str, Callable[..., Callable[[str, Any], Any]]] = {
    "whole": _whole,
    "number": _number,
    "choice": _choice,
    "text": _text,
    "switch": _switch,
}
#: Arguments of the functions that are no settings: what is studied, what the numbers do not depend on, and what is
#: asked of tables alone, which no file makes.
STUDIED = {"P", "model", "name", "values", "bounds", "span", "params", "grid", "order", "energy"}
ARGUMENTS = STUDIED | {"threads", "progress"}


@cache
def settings_of(study: str) -> type[Table]:
    """Return the table of a study's settings: those arguments of its function that decide the numbers."""
    known = studies()[study]
    settings = SETTINGS | {name: KINDS[kind](*said) for name, (kind, *said) in known.options.items()}
    fields: dict[str, Any] = {}
    for name, item in inspect.signature(named(known.compute)).parameters.items():
        if name in settings:
            default = ... if item.default is inspect.Parameter.empty else item.default
            fields[name] = settings[name](name, default)
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
    if name in ("box", "within"):
        return ",".join(text_of("range", item) for item in value)
    if name == "starts":
        return ";".join(text_of("", item) for item in value) + (";" if len(value) == 1 else "")
    return (":" if name == "range" else ",").join(repr(item) for item in value)
