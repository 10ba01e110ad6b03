"""The table ``[si]`` of a configuration: mass, damper, spring and stop, in place of the parameters of the model."""

from __future__ import annotations

from collections.abc import Mapping
from math import pi
from typing import Any

from grazing.config import values
from grazing.oscillator.si import AMPLITUDES, SI, SIDES, faults_of, si_numbers
from grazing.outcome import InputError, shown
from grazing.parameter import unknown

#: The law of a stop, where nothing else is named.
LAW = "newton"
#: What the table may hold beside numbers with units.
WORDS = ("side", "moves")
#: What it must hold, and what stands for entries that are wrong while the rest is checked.
NEEDED = ("m", "c", "k", "gap")
SOUND = {"m": 1.0, "c": 0.0, "k": 1.0, "gap": 0.0, "omega": 1.0, "frequency": 1.0}
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


def from_table(raw: Mapping[str, Any]) -> tuple[dict[str, Any], list[str]]:
    """Return a configuration in which the table ``[si]`` has become parameters, a mass and a law.

    Parameters
    ----------
    raw : mapping
        ``si`` is a table as :meth:`grazing.Oscillator.from_si` takes it, or text: ``m=0.8,c=2.4,gap=1.2 mm``. With it
        ``frequency``, in Hz, may vary in place of ``omega``.

    Returns
    -------
    dict
    list of str
        All that is wrong: unknown names, numbers that are wrong or missing, parameters that the table gives too. In
        their place stands something sound, so that the rest can be checked.
    """
    found = {name: value for name, value in raw.items() if name != "si"}
    table, faults = _table(raw["si"])
    vary = found["vary"] if isinstance(found.get("vary"), Mapping) else {}  # what is none is said by the schema
    if "frequency" in vary:
        found["vary"] = {"omega" if name == "frequency" else name: item for name, item in vary.items()}
        if "omega" in vary:
            faults.append("frequency and omega both vary; give one of them")
        try:
            found["vary"]["omega"] = _turned(vary["frequency"])
        except InputError as error:
            faults.append(str(error))
            found["vary"]["omega"] = ":".join("122"[: str(vary["frequency"]).count(":") + 1]) or [1.0, 2.0]
    given_frequency = {"frequency", "omega"} & {*table}
    open_frequency = not {"omega", "frequency"}.isdisjoint(vary) and not given_frequency
    wrong = faults_of(table)
    faults += wrong.values()
    usual: dict[str, Any] = {"side": "above", "moves": "both", "frequency": None}
    usual |= dict.fromkeys((*AMPLITUDES, "load"), 0.0)
    missing = [name for name in NEEDED if name not in table]
    if missing and table:
        faults.append(f"{', '.join(missing)} missing; give m, c, k and gap, with units or in kg, N s/m, N/m and m")
    table |= {name: SOUND.get(name, usual.get(name)) for name in (*missing, *wrong)}
    try:
        made = si_numbers(**{**usual, "omega": 1.0 if open_frequency else None, **table})
    except InputError as error:
        faults.append(str(error))
        made = si_numbers(**{**usual, **SOUND, "frequency": None})
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
        faults.append(f"the table gives {', '.join(both)}, too; give it there alone")
    found["parameters"] = {**given, **parameters} if isinstance(given, Mapping) else given
    found["mass"], found["stop"] = made.mass, table.get("side", usual["side"])
    if made.base is not None:
        found["base"] = made.base.alone.text
    found.setdefault("law", LAW)
    return found, faults


def _table(given: Any) -> tuple[dict[str, Any], list[str]]:
    """Return the entries of the table, and what is wrong with it; numbers that a shell wrote as text are numbers."""
    if isinstance(given, str):
        parts = [part.partition("=") for part in given.split(",")]
        if not all(equals for _name, equals, _value in parts):
            return {}, [f"si = {shown(given)}; give NAME=VALUE, commas between several: m=0.8,c=2.4,gap=1.2 mm"]
        given = {name.strip(): _number(value.strip()) for name, _equals, value in parts}
    if not isinstance(given, Mapping) or not given:
        return {}, [f"si = {shown(given)}; give a table, such as {{ m = 0.8, c = 2.4, k = 3200.0, ... }}"]
    known = [*SI, *AMPLITUDES, *WORDS]
    faults = [str(unknown(name, known, "si")) for name in given if name not in known]
    return {name: value for name, value in given.items() if name in known}, faults


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
