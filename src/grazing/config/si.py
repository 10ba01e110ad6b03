"""The table ``[si]`` of a configuration: mass, damper, spring and stop, in place of the parameters of the model."""

from __future__ import annotations

from collections.abc import Mapping
from math import pi
from typing import Any

from grazing.config import values
from grazing.oscillator.si import SI, SIDES, si_numbers
from grazing.outcome import InputError, shown
from grazing.parameter import unknown

#: The law of a stop, where nothing else is named.
LAW = "newton"
#: What the table may hold beside numbers with units.
WORDS = ("side", "moves")
SCHEMA = {
    "anyOf": [
        {"type": "string"},
        {
            "type": "object",
            "properties": {
                **{name: {"type": ["number", "string"], "description": known.meaning} for name, known in SI.items()},
                "force": {"type": ["number", "string", "array"], "description": "amplitude of the force, N"},
                "base": {
                    "type": ["number", "string", "array"],
                    "description": "amplitude of the base, m, which a sweep keeps",
                },
                "acceleration": {
                    "type": ["number", "string", "array"],
                    "description": "amplitude of the acceleration of the base, m/s^2, which a sweep keeps",
                },
                "side": {"enum": list(SIDES), "description": "where the stop is"},
                "moves": {"type": "string", "description": "what the base carries: both, spring or stop"},
            },
            "additionalProperties": False,
        },
    ]
}


def from_table(raw: Mapping[str, Any]) -> dict[str, Any]:
    """Return a configuration in which the table ``[si]`` has become parameters, a mass and a law.

    Parameters
    ----------
    raw : mapping
        ``si`` is a table as :meth:`grazing.Oscillator.from_si` takes it, or text: ``m=0.8,c=2.4,gap=1.2 mm``. With it
        ``frequency``, in Hz, may vary in place of ``omega``.

    Raises
    ------
    InputError
        For an unknown name, a number that is wrong, or parameters that the table gives too.
    """
    found = {name: value for name, value in raw.items() if name != "si"}
    table = _table(raw["si"])
    vary = found["vary"] if isinstance(found.get("vary"), Mapping) else {}  # what is none is said by the schema
    if "frequency" in vary:
        if "omega" in vary:
            raise InputError("frequency and omega both vary; give one of them")
        found["vary"] = {"omega" if name == "frequency" else name: item for name, item in vary.items()}
        found["vary"]["omega"] = _turned(vary["frequency"])
    open_frequency = not {"omega", "frequency"}.isdisjoint(vary) and not {"frequency", "omega"} & {*table}
    usual: dict[str, Any] = {"side": "above", "moves": "both", "frequency": None}
    usual |= dict.fromkeys(("force", "base", "acceleration", "load"), 0.0)
    missing = [name for name in ("m", "c", "k", "gap") if name not in table]
    if missing:
        raise InputError(f"{', '.join(missing)} missing; give m, c, k and gap, with units or in kg, N s/m, N/m and m")
    made = si_numbers(**{**usual, "omega": 1.0 if open_frequency else None, **table})
    cos, sin = (made.cos, made.sin) if made.base is None else (made.base.cos, made.base.sin)
    parameters = {
        "alpha": made.alpha, "k": made.k, "omega": made.omega, "d": made.offset, "cos": list(cos),
        "sin": list(sin) if any(sin) else [], "sigma": made.sigma,
    }  # fmt: skip
    if open_frequency:
        del parameters["omega"]
    given = found.get("parameters", {})
    both = sorted({*parameters, "mass", "base", "stop"} & {*given, *found}) if isinstance(given, Mapping) else []
    if both:
        raise InputError(f"the table gives {', '.join(both)}, too; give it there alone")
    found["parameters"] = {**parameters, **given} if isinstance(given, Mapping) else given
    found["mass"], found["stop"] = made.mass, table.get("side", usual["side"])
    if made.base is not None:
        found["base"] = made.base.alone.text
    found.setdefault("law", LAW)
    return found


def _table(given: Any) -> dict[str, Any]:
    """Return the entries of the table; numbers that a shell wrote as text are numbers."""
    if isinstance(given, str):
        parts = [part.partition("=") for part in given.split(",")]
        if not all(equals for _name, equals, _value in parts):
            raise InputError(f"si = {shown(given)}; give NAME=VALUE, commas between several: m=0.8,c=2.4,gap=1.2 mm")
        given = {name.strip(): _number(value.strip()) for name, _equals, value in parts}
    if not isinstance(given, Mapping):
        raise InputError(f"si = {shown(given)}; give a table, such as {{ m = 0.8, c = 2.4, k = 3200.0, ... }}")
    known = [*SI, "force", "base", "acceleration", *WORDS]
    for name in given:
        if name not in known:
            raise unknown(name, known, "si")
    return dict(given)


def _number(text: str) -> Any:
    try:
        return float(text)
    except ValueError:
        return text


def _turned(written: Any) -> Any:
    """Return a range or bounds of a frequency, in Hz, as those of omega, in rad/s."""
    if isinstance(written, str) and ":" in written:
        low, high, *rest = written.split(":")
        ends = [repr(2.0 * pi * values.number(end, "frequency")) for end in (low, high)]
        return ":".join([*ends, *rest])
    return [2.0 * pi * value for value in values.numbers(written, "frequency")]
