"""The sentences of certificates of the oscillator, made from their data: what is claimed, neither more nor less.

Text only: the checker writes the sentence after it has verified the data; the finder writes it with the same words.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import gcd
from typing import Any

from grazing_checker.law import law_text

STABILITY = {
    "stable": "it is asymptotically stable: both multipliers are inside the unit circle",
    "unstable": "it is unstable: a multiplier is outside the unit circle",
    "undecided": "nothing is claimed of its stability",
}
EVENTS = {
    "pd": "a multiplier is -1 (as at a period doubling), and 1 + trace + det has opposite signs at the ends of the "
    "curve",
    "lp": "a multiplier is +1 (as at a fold), and 1 - trace + det has opposite signs at the ends of the curve",
    "ns": "a pair of complex multipliers is on the unit circle (as at a Neimark-Sacker bifurcation), and 1 - det has "
    "opposite signs at the ends of the curve",
    "gr": "a dip touches the wall (graze), which is above it at one end of the curve and below it at the other",
}
#: A decimal stands for the double nearest to it, in the law too.
EXACTLY = "all parameters and the numbers in the law taken as these exact doubles,"


def model_text(data: Mapping[str, Any]) -> str:
    """Return the model in words; a parameter without a value is left out."""
    model, law = data["model"], data["law"]
    constant = model["offset_name"]
    flat = {name: model[name] for name in ("alpha", "k", "omega", "t0")}
    flat |= {constant: model["offset"], "sigma": model["sigma"]}
    for j, (c, s) in enumerate(zip(model["cos"], model["sin"], strict=True), start=1):
        flat |= {f"cos_{j}": c, f"sin_{j}": s}
    said = [f"{name} = {float.fromhex(x)!r}" for name, x in flat.items() if x is not None]
    inside = [f"p.{name} = {float.fromhex(x)!r}" for name, x in law["parameters"].items() if x is not None]
    return (
        f"the oscillator u'' + alpha u' + k^2 u = {constant} + sum over j of cos_j cos(j omega (t + t0)) + "
        f"sin_j sin(j omega (t + t0)), u > sigma, with {', '.join(said)} and T = 2 pi/omega, where an impact with "
        f"u' = v < 0 makes u' = {law_text(law['after'])}{' with ' if inside else ''}{', '.join(inside)}"
    )


def walled_text(data: Mapping[str, Any]) -> str:
    """Return a model with walls of its own in words."""
    model = data["model"]
    spring = "stiffness" if "stiffness" in model else "k"
    flat = {name: model[name] for name in ("alpha", spring, "omega", "t0", "offset")} | _amplitudes(model)
    pull = {"k": "k^2"}.get(spring, spring)
    return (
        f"the oscillator u'' + alpha u' + {pull} u = offset + {_series()}, with {_values(flat)} and T = 2 pi/omega, "
        f"{', and '.join(_wall_text(one) for one in data['walls'])}"
    )


def _series(front: str = "") -> str:
    return f"sum over j of {front}cos_j cos(j omega (t + t0)) + {front}sin_j sin(j omega (t + t0))"


def _values(numbers: Mapping[str, str | None]) -> str:
    return ", ".join(f"{name} = {float.fromhex(x)!r}" for name, x in numbers.items() if x is not None)


def _amplitudes(part: Mapping[str, Any]) -> dict[str, Any]:
    front = f"{part['name']}." if "name" in part else ""
    found: dict[str, Any] = {}
    for j, (c, s) in enumerate(zip(part["cos"], part["sin"], strict=True), start=1):
        found |= {f"{front}cos_{j}": c, f"{front}sin_{j}": s}
    return found


def _wall_text(wall: Mapping[str, Any]) -> str:
    """Return a wall in words: where it is, and what an impact does to the velocity relative to it, away from it."""
    below, name = wall["side"] == "below", wall["name"]
    law, front = wall["law"], f"{name}."
    place = f"{front}sigma{f' + {_series(front)}' if wall['cos'] else ''}"
    speed = f"u' - z_{name}'" if below else f"z_{name}' - u'"
    known = _values({f"{front}sigma": wall["sigma"]} | _amplitudes(wall))
    inside = _values({f"p.{key}": x for key, x in law["parameters"].items()})
    return (
        f'u {">" if below else "<"} z_{name} at the wall "{name}", z_{name} = {place}{known and f" with {known}"}, '
        f"where an impact with {speed} = v < 0 makes {speed} = {law_text(law['after'])}{inside and f' with {inside}'}"
    )


def parameter_text(data: Mapping[str, Any]) -> str:
    """Return the name of the parameter that is unknown, as the sentence calls it."""
    of, name = str(data["parameter"]["of"]), data["parameter"]["name"]
    if of == "law":
        return f"p.{name}"
    if of.startswith("law of "):
        return f'p.{name} of the wall "{of[7:]}"'
    if name == "offset":
        return str(data["model"].get("offset_name", name))
    indexed = f"{name[:3]}_{name[3:]}" if name[:3] in ("cos", "sin") else str(name)
    return indexed if of == "model" else f"{of}.{indexed}"


def signature(n: int, N: int) -> str:
    """Return impacts and periods in words."""
    return f"with {n or 'no'} {'impact' if n == 1 else 'impacts'} in {N} {'period' if N == 1 else 'periods'}"


def coordinates(n: int, first: Mapping[str, Any] | None = None) -> list[str]:
    """Return the names of the coordinates of an orbit; without impacts those that the first wall sees."""
    if n == 0 and first is not None:
        pairs = [(f"u{d}", f"z_{first['name']}{d}") for d in ("", "'")]
        return [f"{a} - {b} at t = 0" if first["side"] == "below" else f"{b} - {a} at t = 0" for a, b in pairs]
    if n == 0:
        return ["u - sigma at t = 0", "u' at t = 0"]
    return [f"t_{i + 1}" for i in range(n)] + [f"w_{i + 1}" for i in range(n)]


def box_text(n: int, box: list[list[str]], first: Mapping[str, Any] | None = None) -> str:
    """Return a box in words."""
    return ", ".join(f"{name} in [{lo}, {hi}]" for name, (lo, hi) in zip(coordinates(n, first), box, strict=True))


def active_harmonics(model: Mapping[str, Any]) -> int:
    """Return the greatest common divisor of the harmonics with an amplitude, 0 if there are none.

    The forcing has then the least period T/g: a trigonometric polynomial of period T q/m in lowest terms needs m to
    divide every harmonic that it has.
    """
    rows = zip(model["cos"], model["sin"], strict=True)
    return gcd(*(j for j, row in enumerate(rows, start=1) if any(float.fromhex(x) for x in row)))


def least_text(data: Mapping[str, Any]) -> str:
    """Return the least period in words, where it is claimed."""
    if not data["claims"]["least_period"]:
        return ""
    if data["impacts"]:
        return f", of least period {data['periods']} T,"
    g = active_harmonics(data["model"])
    return f", of least period {'T' if g == 1 else f'T/{g}'},"


def orbit_sentence(data: Mapping[str, Any]) -> str:
    """Return the sentence of a certificate of a periodic orbit."""
    claims, walls = data["claims"], data.get("walls", ())
    n = len(data["impacts"]) if walls else data["impacts"]
    met, names, image = _meetings(data, n) if walls else _impacts(n)
    box = box_text(n, claims["box"], walls[0] if walls else None)
    return (
        f"For {walled_text(data) if walls else model_text(data)}, {EXACTLY} there is a periodic orbit "
        f"{signature(n, data['periods'])} T{least_text(data)} that {met}, with {box}{names}{image}; no "
        f"other solution of the equations of such an orbit is within ({', '.join(claims['apart'])}) of it in these "
        f"coordinates; {STABILITY[claims['stability']]}."
    )


def _impacts(n: int) -> tuple[str, str, str]:
    """Return in words how an orbit meets its one wall, what the names of its coordinates mean, and no symmetry."""
    if n == 0:
        return "stays off the wall", "", ""
    names = "; t_i are the times of its impacts and w_i the velocities after them"
    return "meets the wall at no other time, and at each impact with a velocity < 0", names, ""


#: What the coordinates of an orbit with walls of its own mean.
MEANING = "t_i are the times of its impacts and w_i what the laws make of v at them"


def _meetings(data: Mapping[str, Any], n: int) -> tuple[str, str, str]:
    """Return in words how an orbit meets its walls, what its coordinates mean, and its symmetry if that is claimed."""
    middle = " + ".join(f"{one['name']}.sigma" for one in data["walls"])
    image = f"; it is its own mirror image, u(t + {data['periods']} T/2) = {middle} - u(t)"
    image = image if data["claims"]["symmetric"] else ""
    if n == 0:
        return f"stays off {_named(data['walls'])}", "", image
    order = ", ".join(map(_quoted, data["impacts"]))
    met = f"meets the walls {order}, in this order, and none at another time, each with v < 0"
    return met, f"; {MEANING}", image


def value_sentence(data: Mapping[str, Any]) -> str:
    """Return the sentence of a certificate of a bifurcation value."""
    claims, walls, name = data["claims"], data.get("walls", ()), parameter_text(data)
    n = len(data["impacts"]) if walls else data["impacts"]
    low, high = claims["value"]
    ends = [STABILITY[one].partition(":")[0] for one in claims["ends"]]
    grazes, first = data["type"] == "gr", walls[0] if walls else None
    pinned = dict(enumerate([*coordinates(n, first), name])).get(data["pinned"])
    but = " but for that dip, in which they are continued as if there were no wall" if grazes else ""
    beside = "" if grazes else f"; of the orbit at the first end of the curve: {ends[0]}, at the second: {ends[1]}"
    event, off, at = EVENTS[data["type"]], "the wall", ""
    if walls:
        event = event.replace("touches the wall", f'touches the wall "{data["dip"]["wall"]}"') if grazes else event
        event = event.replace("above it", "off it").replace("below it", "beyond it")
        off, at = _named(walls), f" {_order(data)}," if n else ""
    box = f"{box_text(n, claims['box'], first)}{f' ({MEANING})' if walls and n else ''}"
    return (
        f"For {walled_text(data) if walls else model_text(data)}, {EXACTLY} there is a value of {name} in "
        f"[{low}, {high}] at which, for a periodic orbit {signature(n, data['periods'])} T{at} with "
        f"{box}, {event}; the curve is one of such orbits in that box, "
        f"along which {pinned} grows, and they stay off {off}{' between their impacts' if n else ''}{but}{beside}."
    )


def _named(walls: Sequence[Mapping[str, Any]]) -> str:
    return f"the wall{'s' if len(walls) > 1 else ''} {' and '.join(_quoted(one['name']) for one in walls)}"


def _order(data: Mapping[str, Any]) -> str:
    return f"at the walls {', '.join(map(_quoted, data['impacts']))}, in this order"


def _quoted(name: str) -> str:
    return f'"{name}"'
