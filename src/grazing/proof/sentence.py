"""The sentence of a certificate, made from its data: what is claimed, neither more nor less.

Text only: the finder writes the sentence with it, the checker compares it after it has verified the data.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

#: What a certificate about the oscillator rests on.
TRUSTED_BASE = (
    "Arb, the ball arithmetic of FLINT, through python-flint",
    "Python and the source of this package's checker",
    "the model as written in the statement, with its parameters the exact doubles given",
    "the theorems of Brouwer and Banach, as used by Krawczyk's test, and the intermediate value theorem",
)
STABILITY = {
    "stable": "it is asymptotically stable: both multipliers are inside the unit circle",
    "unstable": "it is unstable: a multiplier is outside the unit circle",
    "undecided": "nothing is claimed of its stability",
}
EVENTS = {
    "pd": "a multiplier passes through -1 (period doubling)",
    "lp": "a multiplier passes through +1 (fold)",
    "ns": "a pair of complex multipliers passes through the unit circle (Neimark-Sacker)",
    "gr": "a dip touches the wall (graze), which is above it at one end of the curve and below it at the other",
}


def model_text(data: Mapping[str, Any], without: str = "") -> str:
    """Return the model in words; the parameter ``without`` is left out."""
    model, law = data["model"], data["law"]
    constant = model["offset_name"]
    flat = {name: model[name] for name in ("alpha", "k", "omega", "t0")}
    flat |= {constant: model["offset"], "sigma": model["sigma"]}
    for j, (c, s) in enumerate(zip(model["cos"], model["sin"], strict=True), start=1):
        flat |= {f"cos{j}": c, f"sin{j}": s}
    said = [f"{name} = {float.fromhex(x)!r}" for name, x in flat.items() if name != without]
    inside = [f"{name} = {float.fromhex(x)!r}" for name, x in law["params"].items() if name != without]
    code = f" of code {law['code']}" if law["code"] else ""
    return (
        f"the oscillator u'' + alpha u' + k^2 u = {constant} + sum over j of cos_j cos(j omega (t + t0)) + "
        f"sin_j sin(j omega (t + t0)), u > sigma, with {', '.join(said)} and the reset law {law['name']}{code} "
        f"with {', '.join(inside) or 'no parameters'}"
    )


def parameter_name(data: Mapping[str, Any]) -> str:
    """Return the user's name of the parameter that is unknown."""
    name = data["parameter"]
    return str(data["model"]["offset_name"] if name == "offset" else name)


def signature(n: int, N: int) -> str:
    """Return impacts and periods in words."""
    return f"with {n or 'no'} {'impact' if n == 1 else 'impacts'} in {N} {'period' if N == 1 else 'periods'}"


def orbit_text(data: Mapping[str, Any]) -> str:
    """Return the kind of orbit in words."""
    return f"{signature(data['impacts'], data['periods'])} of the forcing"


def coordinates(n: int) -> list[str]:
    """Return the names of the coordinates of an orbit."""
    if n == 0:
        return ["u - sigma at t = 0", "u' at t = 0"]
    return [f"t_{i + 1}" for i in range(n)] + [f"w_{i + 1}" for i in range(n)]


def box_text(n: int, box: list[list[str]]) -> str:
    """Return a box in words."""
    return ", ".join(f"{name} in [{lo}, {hi}]" for name, (lo, hi) in zip(coordinates(n), box, strict=True))


def orbit_sentence(data: Mapping[str, Any]) -> str:
    """Return the sentence of a certificate of a periodic orbit."""
    claims, n = data["claims"], data["impacts"]
    names = "" if n == 0 else "; t_i are the times of its impacts and w_i the velocities after them"
    least = f", of least period {data['periods']} T," if claims["least_period"] else ""
    met = "stays off the wall" if n == 0 else "meets the wall at no other time, and at each impact with a velocity < 0"
    return (
        f"For {model_text(data)}, all parameters taken as these exact doubles, there is a periodic orbit "
        f"{orbit_text(data)}{least} that {met}, with {box_text(n, claims['box'])}{names}; no other solution of the "
        f"equations of such an orbit is within ({', '.join(claims['apart'])}) of it in these coordinates; "
        f"{STABILITY[claims['stability']]}."
    )


def value_sentence(data: Mapping[str, Any]) -> str:
    """Return the sentence of a certificate of a bifurcation value."""
    claims, n, name = data["claims"], data["impacts"], parameter_name(data)
    low, high = claims["value"]
    ends = [STABILITY[one].partition(":")[0] for one in claims["ends"]]
    grazes = data["type"] == "gr"
    beside = "" if grazes else f"; of the orbit at the first end of the curve: {ends[0]}, at the second: {ends[1]}"
    return (
        f"For {model_text(data, name)}, all parameters taken as these exact doubles, there is a value of {name} in "
        f"[{low}, {high}] at which, for a periodic orbit {orbit_text(data)} with {box_text(n, claims['box'])}, "
        f"{EVENTS[data['type']]}; such orbits are a curve through that box, are alone in it and stay off the wall "
        f"between their impacts{' but for that dip' if grazes else ''}{beside}."
    )
