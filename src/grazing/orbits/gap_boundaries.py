"""Where the windows of the gap map's maximal orbits end, in the plane of two of its parameters.

Each edge (Proposition 3.1) gives one of lam, mu and l in closed form once the others are known: mu, or the gap l
where mu is given. So a boundary is the graph of a function of the third, cut where it leaves the rectangle or the
window closes.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from grazing.parameter import Parameter, unknown
from grazing.theory import mu_bc, mu_pd

Floats = NDArray[np.float64]

#: What the curves are, in words.
GAP_KINDS = {
    "pd": "period doubling of the maximal orbit, equation for mu_PD",
    "bc": "border collision of the maximal orbit, equation for mu_BC",
}
GAP = {
    "lam": Parameter("lam", r"\lambda", "slope of the gap map for x < 0", 0.0, 1.0),
    "mu": Parameter("mu", r"\mu", "distance from the graze"),
    "l": Parameter("l", "l", "size of the gap", 0.0),
}
#: Neighbouring points on a curve of the gap map are less than this part of the chart apart.
STEP = 0.01


class Range(NamedTuple):
    """One side of a chart: the name of the parameter and its values from low to high."""

    name: str
    low: float
    high: float


class Curve(NamedTuple):
    """One boundary: period, kind and the points (n, 2) in the order (x, y)."""

    N: int
    kind: str
    points: Floats


def check_sides(x: Range, y: Range, about: dict[str, Parameter], of: str) -> None:
    """Raise InputError for a parameter that does not exist, or a value out of its range."""
    for side in (x, y):
        if side.name not in about:
            raise unknown(side.name, about, of)
        about[side.name].check(side.low)
        about[side.name].check(side.high)


def gap_curves(params: dict[str, float], x: Range, y: Range, periods: list[int]) -> list[Curve]:
    """Return the edges of the windows of the gap map in a rectangle."""
    check_sides(x, y, GAP, "the gap map")
    sides = {x.name: x, y.name: y}
    free = "lam" if "lam" in sides else "l"
    other = y.name if free == x.name else x.name
    found: list[Curve] = []
    for n in periods:
        for kind in ("pd", "bc"):
            if n == 1 and kind == "bc":  # that edge is infinite
                continue
            several = _traced(_explicit(kind, n, params, free, other), sides[free], sides[other])
            found += [Curve(n, kind, points if free == x.name else points[:, ::-1]) for points in several]
    return found


def _explicit(kind: str, n: int, params: dict[str, float], free: str, other: str) -> Callable[[Floats], Floats]:
    """Return an edge as a function of one parameter; NaN where the window is empty or a value is not allowed."""

    def value(at: Floats) -> Floats:
        lam, mu, l = (at if name == free else np.full_like(at, params[name]) for name in ("lam", "mu", "l"))
        allowed = (lam > 0.0) & (lam < 1.0)
        lam = np.where(allowed, lam, 0.5)
        if other == "l":
            l = _gap_at(kind, n, lam, mu)
        allowed &= l >= 0.0
        l = np.where(allowed, l, 1.0)
        pd, bc = mu_pd(n, lam, l), mu_bc(n, lam, l)
        edge = l if other == "l" else (pd if kind == "pd" else bc)
        return np.where(allowed & (pd <= bc), edge, np.nan)

    return value


def _gap_at(kind: str, n: int, lam: Floats, mu: Floats) -> Floats:
    """Return the gap l at which an edge lies at mu, NaN for none: mu_PD is linear in l, and so is (2.6) in it."""
    if kind == "pd":
        least = mu_pd(n, lam, 0.0)
        l = (mu - least) / (mu_pd(n, lam, 1.0) - least)
    else:  # K_(N-1) m^2 - lam^(N-2) m - lam^(N-2) l = 0 with m^2 = mu, where m^2 = mu_BC for l = 0 has no last term
        m, least = np.sqrt(np.maximum(mu, 0.0)), np.sqrt(mu_bc(n, lam, 0.0))
        l = m * (m - least) / least
    return np.where((mu > 0.0) & (l >= 0.0), l, np.nan)


def _traced(f: Callable[[Floats], Floats], free: Range, other: Range) -> list[Floats]:
    """Return the graph of a function inside a rectangle, as pieces with short steps, cut where it leaves."""
    lengths = free.high - free.low, other.high - other.low
    middle = 0.5 * (other.low + other.high)

    def at(t: float) -> float:
        return float(f(np.array([t]))[0])

    def inside(t: float) -> bool:
        return other.low <= at(t) <= other.high

    grid = np.linspace(free.low, free.high, 401)
    heights = f(grid)
    found: list[Floats] = []
    piece: list[float] = []
    for i, (a, b) in enumerate(pairwise(grid.tolist())):
        here, there = (bool(other.low <= height <= other.high) for height in heights[i : i + 2])
        if here and not piece:
            piece = [a]
        if not here and not there and (heights[i] - middle) * (heights[i + 1] - middle) < 0.0:
            # through the rectangle in one step
            rises = bool(heights[i + 1] > middle)
            t = _switch(lambda t, rises=rises: (at(t) < middle) == rises, a, b)  # type: ignore[misc]
            if inside(t):
                found.append(_smooth(at, [_switch(inside, a, t), t, _switch(inside, t, b)], lengths))
        elif here != there:
            edge = _switch(inside, a, b)
            piece = [*piece, edge] if here else [edge, b]
        elif here:
            piece.append(b)
        if piece and not there:
            found.append(_smooth(at, piece, lengths))
            piece = []
    if piece:
        found.append(_smooth(at, piece, lengths))
    return found


def _switch(inside: Callable[[float], bool], a: float, b: float) -> float:
    """Return the last point inside between one inside and one outside, by halving to the last bit."""
    within, without = (a, b) if inside(a) else (b, a)
    while True:
        middle = 0.5 * (within + without)
        if middle in (within, without):
            return within
        if inside(middle):
            within = middle
        else:
            without = middle


def _smooth(f: Callable[[float], float], at: list[float], lengths: tuple[float, float]) -> Floats:
    """Return the graph of a function with the steps halved that are long compared to the rectangle."""
    todo = [(t, f(t)) for t in reversed(at)]
    done = [todo.pop()]
    while todo:
        (a, low), (b, high) = done[-1], todo[-1]
        step = max(abs(b - a) / lengths[0], abs(high - low) / lengths[1])
        middle = 0.5 * (a + b)
        if step > STEP and middle not in (a, b) and len(done) < 20_000:
            todo.append((middle, f(middle)))
        else:
            done.append(todo.pop())
    return np.array(done)
