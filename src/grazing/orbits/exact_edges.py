"""Edges of windows in many digits: what doubles cannot tell apart, next to each other or next to a fold.

A point of a curve of impact phases is (phi, value) with G(phi, value) = 0, see :mod:`grazing.orbits.closure`. At an
edge a test function is 0 as well, at a fold dG/dphi. That is two equations in two unknowns, regular at a fold, too:
Newton's method finds their solution from what doubles know. It works with the midpoints of balls: values are right far
beyond a double, but no theorem.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from grazing.orbits.closure import FIRED, PASSIVE, TESTS, WHOLE, impact_time, lowest_dip
from grazing.orbits.survey import Family
from grazing.oscillator.constants import constants_of
from grazing.pool import LOCK

if TYPE_CHECKING:
    from flint import arb

#: Bits of all numbers; of the steps for differences; to which Newton's method has to settle.
BITS, STEP, SETTLED = 512, 150, 130
#: Farther from where doubles saw it, in shares of the parameter, it is another edge.
LOST = 1e-6
Point = tuple["arb", "arb"]


class Closed:
    """One flight of N periods from the wall back to it, at a phase and a parameter value of many digits."""

    def __init__(self, family: Family, phi: arb, value: arb) -> None:
        from flint import arb, arb_mat

        names = family.kind._fields  # type: ignore[attr-defined]
        row = [arb(float(x)) for x in family.row]
        row[family.position] = value
        p: dict[str, arb] = dict(zip(names, row, strict=True))
        self.family, self.phi, self.p = family, phi, p
        self.alpha, self.k2 = p["alpha"], p["k"] ** 2
        self.L = 2 * arb.pi() * family.N / p["omega"]
        self.r, self.V = p["r"], (0 * p["V"] if family.law == PASSIVE else p["V"])
        self.level = p["offset"] - self.k2 * p["sigma"]
        self.E = (arb_mat([[0, 1], [-self.k2, -self.alpha]]) * self.L).exp()
        y, v = self.pushed(self.L)
        self.back = 1 + self.r * self.E[1, 1]
        self.G = self.E[0, 1] * (self.V - self.r * v) + self.back * y
        w = (self.back * (self.V - self.r * v) - self.E[0, 1] * y) / (self.back**2 + self.E[0, 1] ** 2)
        self.v = self.E[1, 1] * w + v
        self.w = self.V - self.r * self.v

    def waves(self) -> list[tuple[arb, arb, arb]]:
        """Return the frequency of each harmonic with its force (a, b) at the impact: a acts, a' = W b, b' = -W a."""
        found = []
        for j in range(1, self.family.harmonics + 1):
            c, s, (sine, cosine) = self.p[f"cos{j}"], self.p[f"sin{j}"], (j * self.phi).sin_cos()
            found.append((j * self.p["omega"], c * cosine + s * sine, s * cosine - c * sine))
        return found

    def pushed(self, s: arb, turned: bool = False) -> Point:
        """Return where the force takes a ball from rest in time s; ``turned``: the derivative in the phase."""
        from flint import arb_mat

        still = arb_mat([[0, 1, 0], [-self.k2, -self.alpha, 1], [0, 0, 0]])
        state = (still * s).exp() * arb_mat([[0], [0], [0 * s if turned else self.level]])
        y, v = state[0, 0], state[1, 0]
        for j, (W, a, b) in enumerate(self.waves(), start=1):
            start = arb_mat([[0], [0], [j * b], [-j * a]] if turned else [[0], [0], [a], [b]])
            swing = arb_mat([[0, 1, 0, 0], [-self.k2, -self.alpha, 1, 0], [0, 0, 0, W], [0, 0, -W, 0]])
            state = (swing * s).exp() * start
            y, v = y + state[0, 0], v + state[1, 0]
        return y, v

    def test(self, kind: str) -> arb:
        """Return a test function, see :func:`grazing.orbits.closure.impact_state`; for *lp* dG/dphi."""
        from flint import arb

        if kind == "lp":
            y, v = self.pushed(self.L, turned=True)
            return self.back * y - self.E[0, 1] * self.r * v
        if kind == "v0":
            return -self.v
        if kind == "law":
            beyond = -self.v - self.p["trigger"]
            return {WHOLE: arb(1), FIRED: beyond, PASSIVE: -beyond}[self.family.law]
        F = self.level + sum((a for _W, a, _b in self.waves()), 0 * self.phi)
        if kind == "st":
            return F if self.r == 0 and self.V == 0 else arb(1)
        if kind == "gr":
            return self.clearance()
        lift, fall = F - self.alpha * self.w, F - self.alpha * self.v
        trace = self.E[0, 0] * self.w + self.E[0, 1] * (lift + self.r * fall) - self.r * self.v * self.E[1, 1]
        det = -self.r * self.w * (-self.alpha * self.L).exp()
        return -(self.v + trace + det) if kind == "pd" else det - self.v

    def clearance(self) -> arb:
        """Return the height of the lowest dip, found in doubles and then followed down."""
        from flint import arb, arb_mat

        c: Any = constants_of(self.family.harmonics)(self.family.kind(*(float(x) for x in self.p.values())))
        tau, w = impact_time(float(self.phi), c), max(float(self.w), 0.0)
        _low, _dip, count, when, _deepest = lowest_dip(tau, 0.0, w, self.family.N * c.T, False, c)
        if count == 0:
            return arb(1)
        s, free = arb(when), arb_mat([[0, 1], [-self.k2, -self.alpha]])
        for _ in range(12):
            E = (free * s).exp()
            y, v = self.pushed(s)
            y, v = y + E[0, 1] * self.w, v + E[1, 1] * self.w
            turned = [(W * s).sin_cos() for W, _a, _b in self.waves()]
            F = self.level
            for (_W, a, b), (sine, cosine) in zip(self.waves(), turned, strict=True):
                F += a * cosine + b * sine
            rise = F - self.alpha * v - self.k2 * y
            if not rise > 0 or abs(v) < arb(2) ** -SETTLED * abs(rise):
                break
            s = (s - v / rise).mid()
        return y.mid()


def exact_edge(family: Family, kind: str, phi: float | arb, value: float | arb) -> Point | None:
    """Return the point (phi, value) near a guess at which G and a test function are 0; None if Newton finds none."""
    from flint import arb

    x, scale, h = [arb(phi), arb(value)], (arb(1), arb(family_scale(family, float(value)))), arb(2) ** -STEP

    def heights(x: list[arb]) -> tuple[arb, arb]:
        closed = Closed(family, x[0], x[1])
        return closed.G, closed.test(kind)

    for _ in range(40):
        f = heights(x)
        slopes = []
        for i in range(2):
            moved = list(x)
            moved[i] = (x[i] + h * scale[i]).mid()
            g = heights(moved)
            slopes.append([((b - a) / h).mid() for a, b in zip(f, g, strict=True)])
        det = slopes[0][0] * slopes[1][1] - slopes[1][0] * slopes[0][1]
        if det.mid() == 0:
            return None
        step = (
            (f[0] * slopes[1][1] - f[1] * slopes[1][0]) / det,
            (f[1] * slopes[0][0] - f[0] * slopes[0][1]) / det,
        )
        size = max(abs(float(s)) for s in step)
        if not size < 1e3:
            return None
        x = [(a - s * unit).mid() for a, s, unit in zip(x, step, scale, strict=True)]
        if size < 2.0**-SETTLED:
            return x[0], x[1]
    return None


def family_scale(family: Family, value: float) -> float:
    """Return a size for steps of the parameter."""
    return max(abs(value), abs(float(family.row[family.position])), 1e-3 * family.unit)


def signs_at(family: Family, point: Point) -> dict[str, bool]:
    """Return which test functions are positive at a point."""
    closed = Closed(family, *point)
    return {kind: bool(closed.test(kind) > 0) for kind in TESTS if kind != "lp"}


def exactly(work: Callable[[], Any]) -> Any:
    """Do some work with many bits; precision belongs to the process."""
    from flint import ctx

    with LOCK, ctx.workprec(BITS):
        return work()


def ordered(family: Family, guesses: list[tuple[str, float, float]]) -> list[tuple[int, float]] | None:
    """Return the order of several edges, each given as (type, phase, value), with their values; None if one is lost."""

    def work() -> list[tuple[int, float]] | None:
        values = []
        for guess in guesses:
            point = exact_edge(family, *guess)
            if point is None or abs(float(point[1]) - guess[2]) > LOST * family_scale(family, guess[2]):
                return None
            values.append(point[1])
        return sorted(((i, float(value)) for i, value in enumerate(values)), key=lambda edge: values[edge[0]])

    found: list[tuple[int, float]] | None = exactly(work)
    return found


def before_fold(
    family: Family, phase: float, tests: NDArray[np.float64], fold: float, guess: float
) -> list[tuple[float, str]] | None:
    """Return what a curve of impact phases meets between its last point and its fold.

    Parameters
    ----------
    family : Family
    phase, tests
        Of the last point that doubles know, in the order of :data:`grazing.orbits.closure.TESTS`.
    fold, guess : float
        The parameter value of the fold and the phase there, as doubles know them.

    Returns
    -------
    list of (value, type), or None
        Zeros of test functions in the order in which they are met; None where the fold is not found.
    """

    def work() -> list[tuple[float, str]] | None:
        end = exact_edge(family, "lp", guess, fold)
        if end is None or abs(float(end[1]) - fold) > LOST * family_scale(family, fold):
            return None
        there = signs_at(family, end)
        met = []
        for kind, test in zip(TESTS, tests, strict=True):
            if kind == "lp" or there[kind] == (test > 0.0):
                continue
            point = exact_edge(family, kind, *end)
            if (
                point is not None
                and abs(point[0] - phase) < abs(end[0] - phase)
                and abs(point[0] - end[0]) < abs(end[0] - phase)
            ):
                met.append((abs(point[0] - phase).mid(), float(point[1]), kind))
        return [(value, kind) for _away, value, kind in sorted(met, key=lambda edge: edge[0])]

    found: list[tuple[float, str]] | None = exactly(work)
    return found
