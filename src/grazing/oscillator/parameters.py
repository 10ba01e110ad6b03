"""What is known of the parameters and the coordinates of the oscillator: meanings, ranges, units."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from math import inf

from grazing.oscillator.reset import KNOWN
from grazing.parameter import Parameter

PARAMETERS = {
    parameter.name: parameter
    for parameter in (
        Parameter("alpha", r"\alpha", "linear damping coefficient", units="1/s"),
        Parameter("k", "k", "natural frequency; the stiffness is k^2", 0.0, units="rad/s"),
        Parameter("stiffness", r"\kappa", "stiffness, negative for a force away from u = 0", units="1/s^2"),
        Parameter("omega", r"\omega", "frequency of the forcing", 0.0, inf, "low", "rad/s"),
        Parameter("t0", "t_0", "time shift of the forcing", units="s"),
        Parameter("offset", "d", "constant part of the forcing", units="N/kg"),
        Parameter("d", "d", "constant part of the forcing", units="N/kg"),
        Parameter("sigma", r"\sigma", "position of the wall", units="m"),
        Parameter("phase", r"\varphi", "time of the stroboscopic section, from t = 0", units="s"),
        *KNOWN.values(),
    )
}

#: Coordinates of sections, and what else is read from a motion.
COORDINATES = {
    known.name: known
    for known in (
        Parameter("t", "t", "time", units="s"),
        Parameter("u", "u", "position", units="m"),
        Parameter("v", "v", "velocity", units="m/s"),
        Parameter("tau", r"\tau", "phase of the impact", units="s"),
        Parameter("v_minus", "v^-", "velocity before", units="m/s"),
        Parameter("v_plus", "v^+", "velocity after", units="m/s"),
    )
}
MASS = Parameter("mass", "m", "mass in kg", 0.0, inf, "low", "kg")

#: What is known of any other name.
LAWS_OWN = "parameter of the reset law"


@lru_cache(maxsize=256)
def describe_parameter(name: str) -> Parameter:
    """Return what is known of a parameter of the oscillator or of a reset law; units are those of :func:`from_si`."""
    if name in PARAMETERS:
        return PARAMETERS[name]
    for kind, word in (("cos", "cosine"), ("sin", "sine")):
        if name.startswith(kind) and name[3:].isdigit():
            j = int(name[3:])
            meaning = f"{word} amplitude of harmonic {j} of the forcing"
            return Parameter(name, rf"{kind[0]}_{{{j}}}", meaning, units="N/kg")
    return Parameter(name, rf"\mathrm{{{name}}}", LAWS_OWN, units="")


def parameter_units(name: str) -> str:
    """Return the units of a parameter, with the name of a wall in front or not; amplitudes of a wall are lengths."""
    front, _dot, last = name.rpartition(".")
    return "m" if front and last[:3] in ("cos", "sin") else describe_parameter(last).units


def damped(parameter: Parameter) -> Parameter:
    """Return a parameter with the range that it has where a steady response is to attract: no negative damping."""
    return replace(parameter, low=0.0) if parameter.name == "alpha" else parameter


def means_model(name: str) -> bool:
    """Return whether a name means something of the oscillator, whatever its forcing: no law may give it another."""
    return name not in KNOWN and describe_parameter(name).meaning != LAWS_OWN
