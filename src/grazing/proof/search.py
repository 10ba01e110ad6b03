"""Where a bifurcation lies, by numbers: a zero of a test function along a curve of orbits. A proof comes after."""

from __future__ import annotations

from abc import ABC, abstractmethod
from math import inf
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from grazing.orbits.contacts import sizes_of
from grazing.proof.clearance import started
from grazing.proof.equations import Equations, Flight
from grazing.proof.flow import Blurred, TooLong
from grazing.proof.krawczyk import Closing, NoConvergence, newton
from grazing.proof.reasons import NotProven

if TYPE_CHECKING:
    from flint import arb

    Point = list[arb]

Floats = NDArray[np.float64]

#: Most steps of the secant method, and steps with a shorter and shorter way to go.
SECANTS, TRIES = 80, 12
#: Bits of the first, rough search.
ROUGH = 96
#: Halvings of a step to where its velocity is extreme.
SPLITS = 60
#: Longest step of the search in the coordinate that is varied, in units of its size.
STRIDE = 0.05
#: So near to the wall, in sizes of the motion, a dip touches it, and an impact so slow does.
TOUCH = 1e-9
#: How far Newton's method may go from the tangent, as part of the step and in scales of the coordinates: farther off
#: lies another branch. How far from the orbit given.
ASTRAY, FAR, NEAR = 0.2, 0.05, 0.01


class Dip(NamedTuple):
    """A local minimum of a flight above a wall: which they are, how long after the start, how high, how fast."""

    flight: int
    wall: int
    time: arb
    height: arb
    speed: arb


class Along(ABC):
    """Finds a zero of a test function along a curve of orbits, by numbers without proof.

    ``pinned`` is the coordinate that is varied: the parameter, or towards a fold the one that changes most.
    """

    def __init__(self, equations: Closing, kind: str, start: Point) -> None:
        self.equations, self.kind = equations, kind
        self.pinned = equations.size
        if kind == "lp":  # the parameter turns round at a fold: there no orbit is alone at its value
            self.pinned = self._steepest(start)
        self.start = self.solved(start)
        if self._apart(start, self.start) > NEAR:
            raise NotProven("Newton's method went from the orbit given to another one; give one of a smaller residual")

    def solved(self, x: Point) -> Point:
        """Return the orbit at the pinned coordinate of a guess."""
        try:
            return newton(self.equations, x, self.pinned)
        except NoConvergence:
            raise NotProven(
                "Newton's method does not find the orbit near the one given; give one nearer to the bifurcation"
            ) from None

    def _tangent(self, x: Point) -> Floats:
        """Return the direction of the curve at an orbit."""
        rows = self.equations.jacobian(self.equations.flights(x, True))
        matrix = np.array([[float(a) for a in row] for row in rows])
        try:
            return np.asarray(np.linalg.svd(matrix)[2][-1])
        except np.linalg.LinAlgError:
            raise NotProven("the equations of the orbit have no derivative there; give another orbit") from None

    def _steepest(self, x: Point) -> int:
        """Return the coordinate that changes most along the curve, in its natural size."""
        sizes = [*map(float, self.equations.scales(x, self.equations.flights(x))), self.equations.unit(x)]
        return int(np.argmax(np.abs(self._tangent(x)) / sizes))

    @abstractmethod
    def test(self, x: Point) -> arb:
        """Return the test function at an orbit."""

    def zero(self) -> Point:
        """Return the orbit at which the test function is 0: roughly, then to working precision."""
        from flint import ctx

        full, x = ctx.prec, self.start
        for bits, step in ((ROUGH, 1e-5), (full, 2.0 ** -(ROUGH // 3))):
            with ctx.workprec(bits):
                x = self._secant(x, step)
        return self.solved(x)

    def _secant(self, x: Point, stride: float) -> Point:
        """Return the zero along the curve by the secant method, each orbit found from the tangent at the last one."""
        from flint import arb, ctx

        x = self.solved(x)
        value, last = self.test(x), x
        step = arb(stride * self.unit(x))
        for _ in range(SECANTS):
            new = self._advanced(last, step)
            old, value = value, self.test(new)
            before, last = last, new
            rise = (value - old).mid()
            if rise.is_zero():
                return last if value.is_zero() else self._lost()
            if self.kind == "lp":
                self.pinned = self._steepest(last)
            c = self.pinned
            moved, unit = (last[c] - before[c]).mid(), self.unit(last)
            step = (-value * moved / rise).mid()
            if float(abs(step)) <= 2.0 ** -(2 * ctx.prec // 5) * unit:
                return self._guess(last, self._tangent(last), step)
            longest = max(STRIDE * unit, 2 * float(abs(moved)))
            if not float(abs(step)) < longest:
                step = arb(longest if step > 0 else -longest)
        return self._lost()

    def unit(self, x: Point) -> float:
        """Return the size of the coordinate that is varied."""
        return float(abs(x[self.pinned])) or 1.0

    def _lost(self) -> Point:
        raise NotProven(
            f"no {self.kind} was found from this orbit: the search along the parameter did not converge; "
            "give an orbit nearer to it"
        )

    def _guess(self, x: Point, tangent: Floats, step: arb) -> Point:
        """Return a guess of the orbit a step further, along the tangent."""
        from flint import arb

        ahead = tangent[self.pinned]
        if ahead == 0.0:
            raise NotProven("the branch turns back where it was to go on; give an orbit nearer to the bifurcation")
        return [(a + step * arb(b / ahead)).mid() for a, b in zip(x, tangent.tolist(), strict=True)]

    def _advanced(self, x: Point, step: arb) -> Point:
        """Return the orbit a step further along its branch, or less far if there is none near the tangent."""
        tangent = self._tangent(x)
        for _ in range(TRIES):
            guess = self._guess(x, tangent, step)
            try:
                new = newton(self.equations, guess, self.pinned)
                if self._apart(guess, new) <= min(ASTRAY * self._way(x, guess), FAR):
                    return new
            except Blurred:
                raise
            except (NoConvergence, TooLong):
                pass
            step = (step / 4).mid()
        raise NotProven("the orbit cannot be followed towards the bifurcation; give one nearer to it")

    def _way(self, x: Point, guess: Point) -> float:
        """Return the length of a step: of the orbit, or of what is varied where the orbit hardly changes with it."""
        return max(self._apart(x, guess), min(STRIDE, float(abs(guess[self.pinned] - x[self.pinned])) / self.unit(x)))

    def _apart(self, one: Point, two: Point) -> float:
        """Return how far two orbits are from each other: the largest difference, in scales of the coordinates.

        Where a scale is 0, as of flights that have shrunk to nothing, they are beyond all measure apart.
        """
        sizes = map(float, self.equations.scales(two, self.equations.flights(two)))
        return max(float(abs(a - b)) / size if size else inf for a, b, size in zip(one, two, sizes, strict=False))


class Search(Along):
    """Finds a bifurcation of an orbit of the oscillator."""

    equations: Equations

    def __init__(self, equations: Equations, kind: str, start: Point) -> None:
        self.dip: Dip | None = None
        super().__init__(equations, kind, start)

    def test(self, x: Point) -> arb:
        """Return the test function at an orbit."""
        flights = self.equations.flights(x)
        flow = self.equations.flow(x)
        if self.kind == "gr":
            dips = [dip for i in range(len(flights)) for dip in dips_of(self.equations, flights, i, x)]
            if not dips:
                raise NotProven("the orbit has no dip between its impacts that could touch a wall")
            was = self.dip
            if was is None:  # the one that touches; else the lowest, beyond a graze the one that has touched
                near = TOUCH * sizes_of(self.equations.model)[0]
                touching = [dip for dip in dips if float(abs(dip.height)) < near]
                self.dip = min(touching or dips, key=lambda dip: float(dip.height))
            else:
                here = [dip for dip in dips if (dip.flight, dip.wall) == (was.flight, was.wall)]
                if not here:
                    raise NotProven("the dip that was to touch a wall vanishes; give an orbit nearer to the graze")
                self.dip = min(here, key=lambda dip: abs(float(dip.time - was.time)))
            return self.dip.height
        trace, det = self.equations.trace_and_det(flights, flow)
        return {"pd": 1 + trace + det, "lp": 1 - trace + det, "ns": det - 1}[self.kind].mid()

    def unit(self, x: Point) -> float:
        """Return the size of the coordinate that is varied; of a time that is 0 by chance that of the motion."""
        size = float(abs(x[self.pinned]))
        if self.pinned < self.equations.n:
            size = max(size, 1.0 / float(self.equations.flow(x).scale))
        return size or 1.0


def dips_of(equations: Equations, flights: list[Flight], i: int, x: Point) -> list[Dip]:
    """Return the local minima of one flight above every wall, by numbers."""
    return [dip for wall in equations.walls for dip in _dips_above(equations, flights[i], i, x, wall)]


def _dips_above(equations: Equations, f: Flight, i: int, x: Point, wall: int) -> list[Dip]:
    flow = equations.flow(x, wall=wall)
    z = started(equations, f, x, flow, wall)
    count = flow.count(f.L)
    h = (f.L / count).mid()
    step = flow.step(h)
    found = []
    for k in range(count):
        after = step * z
        for low, long, before in _pieces(flow, z, after, h):
            if low[1, 0] < 0 and flow.shifted(low, long)[1, 0] > 0:
                found.append(_lowest(flow, low, long, (i, wall), k * h + before))
        z = after
    return found


def _pieces(flow: Any, z: Any, after: Any, h: arb) -> list[tuple[Any, arb, arb]]:
    """Return a step in pieces on which the velocity rises or falls: state at the start, length, time before.

    A dip just after an impact, or just before one, lies between two velocities of the same sign.
    """
    from flint import arb

    first, last = ((flow.system * one)[1, 0] for one in (z, after))
    if not (first * last < 0):
        return [(z, h, arb(0))]
    low, high = arb(0), h
    for _ in range(SPLITS):
        middle = ((low + high) / 2).mid()
        state = flow.shifted(z, middle)
        low, high = (middle, high) if (flow.system * state)[1, 0] * first > 0 else (low, middle)
    return [(z, middle, arb(0)), (state, (h - middle).mid(), middle)]


def _lowest(flow: Any, z: Any, h: arb, at: tuple[int, int], before: arb) -> Dip:
    """Return the minimum within a step in which the velocity passes from below 0 to above, by bisection and Newton."""
    from flint import arb, ctx

    lo, hi, s = arb(0), h, h / 2
    for _ in range(2 * ctx.prec):
        state = flow.shifted(z, s)
        v, a = (state[1, 0] * flow.scale).mid(), ((flow.system * state)[1, 0] * flow.scale).mid()
        lo, hi = (s, hi) if v < 0 else (lo, s)
        new = (s - v / a).mid() if a > 0 else lo
        if not (lo < new and new < hi):
            new = ((lo + hi) / 2).mid()
        done = abs(new - s) < h * arb(2) ** (16 - ctx.prec // 2)
        s = new
        if done:
            break
    state = flow.shifted(z, s)
    return Dip(*at, (before + s).mid(), state[0, 0].mid(), (state[1, 0] * flow.scale).mid())
