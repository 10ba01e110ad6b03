"""The walls of a certificate: which they are, where each is at a time, and the ball's motion as each sees it.

A wall at z(t), below the ball (sign 1) or above it (sign -1), sees the distance x = sign (u - z). From u'' + alpha u'
+ k^2 u = f(t) follows x'' + alpha x' + k^2 x = sign (f - z'' - alpha z' - k^2 z): an oscillator over a wall at rest,
with another force. With z = sigma + sum over j of c_j cos(W (t + t0)) + s_j sin(W (t + t0)), W = j omega, what is
taken from f has the constant part k^2 sigma and the amplitudes

    (k^2 - W^2) c_j + alpha W s_j  of the cosine,    (k^2 - W^2) s_j - alpha W c_j  of the sine.

The velocity before an impact at a wall is x' < 0, that after it x' >= 0: relative to the wall, and away from it.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from fractions import Fraction
from itertools import zip_longest
from typing import Any, NamedTuple

from grazing_checker.balls import Ball, number
from grazing_checker.flight import Motion
from grazing_checker.law import check_law
from grazing_checker.reading import demand, keys, whole

SIDES = {"below": 1, "above": -1}
#: What a wall may be called; C and S mean something else in words of orbits.
NAME = re.compile(r"[ABD-RT-Z]")
#: Most impacts and periods that a certificate may speak of, and most harmonics.
LARGEST, HARMONICS = 10_000, 1000
Texts = dict[str, dict[str, Any]]


class Wall(NamedTuple):
    """A wall: its name, its side, the groups of parameters of its place and its law, and the law with its size."""

    name: str
    sign: int
    place: str
    law: str
    after: Any
    nodes: int


class Frame(NamedTuple):
    """A wall at given parameters: its side, the motion as it sees it, its place and that by the unknown parameter."""

    sign: int
    motion: Motion
    sigma: Ball
    cos: list[Ball]
    sin: list[Ball]
    slopes: Mapping[str, Ball]

    def at(self, t: Ball) -> tuple[Ball, Ball]:
        """Return where the wall is at time t, and how fast it moves."""
        place, rate = self.sigma, number(0)
        for j, (c, s) in enumerate(zip(self.cos, self.sin, strict=True), start=1):
            W = j * self.motion.omega
            sine, cosine = (W * (t + self.motion.t0)).sin_cos()
            place, rate = place + c * cosine + s * sine, rate + W * (s * cosine - c * sine)
        return place, rate

    def at_slope(self, t: Ball) -> tuple[Ball, Ball]:
        """Return the derivatives of place and speed at time t by the unknown parameter."""
        m, nothing = self.motion, number(0)
        place, rate = self.slopes.get("sigma", nothing), nothing
        for j, (c, s) in enumerate(zip(self.cos, self.sin, strict=True), start=1):
            W, faster = j * m.omega, j * m.slope("omega")
            dc, ds = self.slopes.get(f"cos{j}", nothing), self.slopes.get(f"sin{j}", nothing)
            sine, cosine = (W * (t + m.t0)).sin_cos()
            ahead = faster * (t + m.t0) + W * m.slope("t0")
            swing, turn = c * cosine + s * sine, s * cosine - c * sine
            place += dc * cosine + ds * sine + turn * ahead
            rate += faster * turn + W * (ds * cosine - dc * sine - swing * ahead)
        return place, rate

    def slope_seen_by(self, other: Frame, t: Ball) -> tuple[Ball, Ball]:
        """Return the derivative by the unknown parameter of what another sees, if nothing changes for this one."""
        if other is self:
            return number(0), number(0)
        (one, fast), (two, late) = self.at_slope(t), other.at_slope(t)
        return other.sign * (one - two), other.sign * (fast - late)

    def seen_by(self, other: Frame, t: Ball, x: Ball, v: Ball) -> tuple[Ball, Ball]:
        """Return distance and velocity, as this wall sees them at time t, as another sees them."""
        if other is self:
            return x, v
        (one, fast), (two, late) = self.at(t), other.at(t)
        turn = self.sign * other.sign
        return other.sign * (one - two) + turn * x, other.sign * (fast - late) + turn * v


def read(data: Mapping[str, Any]) -> tuple[list[Wall], Texts, list[int]]:
    """Return the walls of a certificate, the texts of all parameters by groups, and the walls of its impacts.

    A certificate without ``walls`` is one of a single wall, below the ball and at rest.
    """
    if "walls" not in data:
        n = whole(data["impacts"], 0, "impacts")
        demand(n <= LARGEST, "the orbit has too many impacts or periods")
        nodes = check_law(data["law"])
        model = _amplitudes(data["model"], ("alpha", "k", "omega", "t0", "offset", "sigma"), "the model", "offset_name")
        demand(data["model"]["offset_name"] in ("offset", "d"), "the constant force has a strange name")
        return (
            [Wall("", 1, "model", "law", data["law"]["after"], nodes)],
            {"model": model, "law": dict(data["law"]["parameters"])},
            [0] * n,
        )
    spring = "stiffness" if isinstance(data["model"], Mapping) and "stiffness" in data["model"] else "k"
    texts: Texts = {"model": _amplitudes(data["model"], ("alpha", spring, "omega", "t0", "offset"), "the model")}
    demand(isinstance(data["walls"], list) and len(data["walls"]) in (1, 2), "there are neither one nor two walls")
    walls = [_wall(one, texts) for one in data["walls"]]
    demand(len({one.name for one in walls}) == len(walls), "two walls have one name")
    demand([one.sign for one in walls] in ([1], [-1], [1, -1]), "the walls are not the lower one and the upper one")
    hits, names = data["impacts"], [one.name for one in walls]
    demand(isinstance(hits, list) and len(hits) <= LARGEST, "the impacts are no list, or too many")
    demand(all(isinstance(name, str) and name in names for name in hits), "an impact is at a wall that does not exist")
    return walls, texts, [names.index(name) for name in hits]


def _wall(one: Any, texts: Texts) -> Wall:
    """Return a wall, and add its parameters to the texts."""
    keys(one, ("name", "side", "sigma", "cos", "sin", "law"), "a wall")
    name, side = one["name"], one["side"]
    demand(isinstance(name, str) and NAME.fullmatch(name), "a wall has a name that is none")
    demand(isinstance(side, str) and side in SIDES, "a wall is neither below nor above the ball")
    nodes = check_law(one["law"])
    place = _amplitudes({key: one[key] for key in ("sigma", "cos", "sin")}, ("sigma",), "a wall", least=0)
    texts |= {name: place, f"law of {name}": dict(one["law"]["parameters"])}
    return Wall(name, SIDES[side], name, f"law of {name}", one["law"]["after"], nodes)


def _amplitudes(part: Any, scalars: tuple[str, ...], where: str, *words: str, least: int = 1) -> dict[str, Any]:
    """Return the texts of numbers and amplitudes by their names; None for one that is unknown."""
    keys(part, (*scalars, "cos", "sin", *words), where)
    cos, sin = part["cos"], part["sin"]
    demand(isinstance(cos, list) and isinstance(sin, list), "cos and sin are no lists")
    demand(least <= len(cos) == len(sin) <= HARMONICS, "cos and sin do not match")
    texts = {name: part[name] for name in scalars}
    for j, (c, s) in enumerate(zip(cos, sin, strict=True), start=1):
        texts |= {f"cos{j}": c, f"sin{j}": s}
    return texts


def amplitudes(p: Mapping[str, Ball]) -> tuple[list[Ball], list[Ball]]:
    """Return the cosines and the sines among parameters."""
    js = range(1, sum(name.startswith("cos") for name in p) + 1)
    return [p[f"cos{j}"] for j in js], [p[f"sin{j}"] for j in js]


def frame(
    wall: Wall, p: Mapping[str, Ball], q: Mapping[str, Ball], dp: Mapping[str, Ball], dq: Mapping[str, Ball]
) -> Frame:  # fmt: skip
    """Return a wall at parameters p of the model and q of its place; see above for what it sees.

    ``dp`` and ``dq`` are their derivatives by an unknown parameter: 1 where it is one of them, else left out.
    """
    alpha, omega, nothing, sign = p["alpha"], p["omega"], number(0), wall.sign
    k2 = p["stiffness"] if "stiffness" in p else p["k"] * p["k"]
    slopes = {name: dp.get(name, nothing) for name in ("alpha", "omega", "t0")}
    slopes["k2"] = dp.get("stiffness", nothing) if "stiffness" in p else 2 * p["k"] * dp.get("k", nothing)
    slopes |= {"offset": sign * dp.get("offset", nothing), "sigma": sign * dq.get("sigma", nothing)}
    own = amplitudes(q) if q is not p else ([], [])
    cos, sin = [], []
    for j, (a, b, c, s) in enumerate(zip_longest(*amplitudes(p), *own, fillvalue=nothing), start=1):
        W, faster = j * omega, j * slopes["omega"]
        lift, drag = k2 - W * W, alpha * W
        cos.append(sign * (a - (lift * c + drag * s)))
        sin.append(sign * (b - (lift * s - drag * c)))
        lifts, drags = slopes["k2"] - 2 * W * faster, slopes["alpha"] * W + alpha * faster
        dc, ds = (dq.get(f"{kind}{j}", nothing) if q is not p else nothing for kind in ("cos", "sin"))
        da, db = dp.get(f"cos{j}", nothing), dp.get(f"sin{j}", nothing)
        slopes[f"cos{j}"] = sign * (da - (lifts * c + lift * dc + drags * s + drag * ds))
        slopes[f"sin{j}"] = sign * (db - (lifts * s + lift * ds - drags * c - drag * dc))
    offset, sigma = sign * p["offset"], sign * q["sigma"]
    seen = Motion(alpha, k2, omega, p["t0"], offset, sigma, cos=cos, sin=sin, slopes=slopes)
    return Frame(sign, seen, q["sigma"], *own, dq)


def mirrored(data: Mapping[str, Any]) -> bool:
    """Return whether a model is its own mirror image half a period later, exactly.

    With 2 m the sum of the walls' positions, (u, t) -> (2 m - u, t + T/2) takes motions to motions if f(t) + f(t +
    T/2) = 2 m k^2, z_B(t + T/2) = 2 m - z_A(t), and both walls have one law. An even harmonic has its sign half a
    period later, an odd one the opposite: f has no even ones, those of the walls are opposite, and odd ones are the
    same.
    """
    model, walls = data["model"], data.get("walls", ())
    if len(walls) != 2 or walls[0]["law"] != walls[1]["law"]:
        return False

    def value(text: str) -> Fraction:
        return Fraction(float.fromhex(text))

    stiffness = value(model["stiffness"]) if "stiffness" in model else value(model["k"]) ** 2
    if 2 * value(model["offset"]) != stiffness * (value(walls[0]["sigma"]) + value(walls[1]["sigma"])):
        return False
    if any(value(text) for name in ("cos", "sin") for text in model[name][1::2]):
        return False
    pairs = [pair for name in ("cos", "sin") for pair in _pairs(walls[0][name], walls[1][name])]
    return all(value(two) == (-value(one) if j % 2 == 0 else value(one)) for j, one, two in pairs)


def _pairs(one: list[str], two: list[str]) -> list[tuple[int, str, str]]:
    """Return the amplitudes of two walls by the number of the harmonic; those left out are 0."""
    rows = zip_longest(one, two, fillvalue=(0.0).hex())
    return [(j, a, b) for j, (a, b) in enumerate(rows, start=1)]
