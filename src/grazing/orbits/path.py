"""A path: solutions of equations followed in one parameter by pseudo-arclength, with what happens on the way located.

The unknowns x and the parameter p, each divided by its scale, are the coordinates of a point z. From a point and the
tangent there the next point is predicted and corrected in the plane across the tangent (Keller), so that a fold, where
p turns round, is a point like any other. A test function that changes its sign between two points is solved for with
the same corrector, on planes in between.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from grazing.orbits.equations import Ending, Equations, Test
from grazing.orbits.one_sided import EPS

Floats = NDArray[np.float64]

#: Newton steps of the corrector, and the last one's length that counts as arrived.
STEPS, SMALL = 10, 1e-13
#: Cosine of the largest angle between neighbouring tangents.
STRAIGHT = 0.97
#: Shortest step, and the first one, in units of the scaled coordinates.
SHORTEST, FIRST = 1e-9, 1e-3
#: Newton steps cut short at the end of a piece, one after the other, after which there is no solution on it.
CUT = 3
#: Defect, in scaled unknowns and beside rounding, up to which a point on a piece of a map is a solution.
CLOSED = 1e-13
#: Steps shorter than this, in scaled unknowns, end the search for the end of a piece.
FINEST = 2e-16
#: Steps, taken or not, for each point of a path that is allowed, and the fewest of a path, after which it is given up.
TRIES, FEWEST = 20, 2000
#: Part of the way to the end of a piece, as the tangent tells it, that is taken at once.
SHORT = 0.999
#: Where there is a solution beyond what seemed to be the end, the search goes on with steps so much longer.
FARTHER = 256.0
#: Widest bracket of an end that has converged, in units of the range of the parameter.
NARROW = 1e-12
#: Part of its size at which a test function counts as zero.
VANISHED = 1e-6
#: Largest defect on the way from one point to the next, in units of its length, beyond which the map has jumped.
ASTRAY = 0.05
#: How often the way between two neighbouring points is looked at.
LOOKS = 16
#: Place of a period doubling at which an orbit becomes one of half its period, and of a branch point at which it
#: becomes its own mirror image.
HALVES, MIRRORS = -2, -3
#: Events that are no farther apart, in scaled coordinates, happen at one place.
AT_ONCE = 1e-9
#: An orbit and its mirror image that differ by less, in scaled unknowns, are one: symmetric.
ALIKE = 1e-7


class Point(NamedTuple):
    """A solution z = (x, p) in scaled coordinates, the unit tangent there, and the test functions."""

    z: Floats
    tangent: Floats
    tests: tuple[Test, ...]


class Event(NamedTuple):
    """Where a test function is zero: its type, the point, which impact or flight it is about, and how it was found.

    ``low`` and ``high`` bracket the parameter; ``converged`` says that the test function is zero there to rounding,
    and has not jumped.
    """

    type: str
    point: Point
    where: int
    low: float
    high: float
    converged: bool


@dataclass(eq=False)
class Path:
    """Points in order, those at events among them (index, event), and why the path begins and ends.

    ``beyond`` has where it ends only because the word changes: the equations there, the first and the last point.
    """

    equations: Equations
    points: list[Point] = field(default_factory=list)
    events: list[tuple[int, Event]] = field(default_factory=list)
    ended: str = ""
    began: str = ""
    beyond: list[tuple[Equations, Point, Point]] = field(default_factory=list)

    def unscaled(self, z: Floats) -> tuple[Floats, Floats]:
        """Return x and p of a point in scaled coordinates."""
        return unscaled(self.equations, z)

    def value(self, point: Point) -> float:
        """Return the parameter at a point."""
        return float(point.z[-1] * self.equations.spans[-1])


def unscaled(equations: Equations, z: Floats) -> tuple[Floats, Floats]:
    """Return x and p of a point in scaled coordinates."""
    n = len(equations.scale)
    return z[:n] * equations.scale, z[n:] * equations.spans


def joined(backward: Path, forward: Path) -> Path:
    """Return one path of two that leave the same point in opposite directions."""
    back = [point._replace(tangent=-point.tangent) for point in backward.points[:0:-1]]
    last = len(backward.points) - 1
    events = [(last - i, event) for i, event in reversed(backward.events)]
    events += [(last + i, event) for i, event in forward.events]
    beyond = backward.beyond + forward.beyond
    return Path(forward.equations, back + forward.points, events, forward.ended, backward.ended, beyond)


def closed(equations: Equations, x: Floats, p: Floats) -> Floats | None:
    """Solve the equations at fixed parameters by Newton's method; None where it does not converge."""
    x, before, cut = np.array(x, np.float64), np.inf, 0
    for _ in range(30):
        F, J = equations.defects(x, p)
        if not (np.isfinite(F).all() and np.isfinite(J).all()):
            return None
        F, J = weighed(F, J * equations.scale)
        try:
            move = np.linalg.solve(J, F) * equations.scale
        except np.linalg.LinAlgError:
            return None
        size = float(np.abs(move / equations.scale).max()) if len(move) else 0.0
        if equations.pieced:
            share = equations.reach(x, p, np.asarray(-move, np.float64), np.zeros(len(p)))
            if share < 1.0:
                cut += 1
                if share == 0.0 or cut > CUT:
                    return None
                x, before = x - share * move, np.inf
                continue
            cut = 0
        x = x - move
        if size <= 1e-15 or (size <= 1e-9 and size >= 0.25 * before):
            return x
        if not size < 1e3:
            return None
        before = size
    return None


def linearised(equations: Equations, z: Floats) -> tuple[Floats, Floats]:
    """Return the defects and their derivative (n, n + 1) in scaled coordinates, see :func:`weighed`."""
    x, p = unscaled(equations, z)
    F, J, slopes = equations.expanded(x, p)
    wide = np.empty((len(F), len(z)))
    wide[:, : len(x)], wide[:, len(x) :] = J * equations.scale, slopes * equations.spans
    return weighed(F, wide)


def weighed(F: Floats, wide: Floats) -> tuple[Floats, Floats]:
    """Return equations with derivatives in scaled coordinates, each divided by the size of its derivatives.

    Positions and velocities then weigh alike, and elimination meets the same pivots in any unit. Sizes are rounded to
    powers of two, by which nothing else is rounded.
    """
    size = np.abs(wide).max(axis=1)
    size = np.ldexp(1.0, np.frexp(np.where(size > 0.0, size, 1.0))[1])
    return F / size, wide / size[:, None]


def tangent_of(wide: Floats, along: Floats) -> Floats:
    """Return the unit null vector of a derivative (n, n + 1) that points along a given vector."""
    right = np.zeros(len(along))
    right[-1] = 1.0
    t = solved_or_least(np.vstack([wide, along]), right)
    t = np.ldexp(t, -int(np.frexp(np.abs(t).max())[1]))  # its length may be beyond all numbers
    t = t / np.linalg.norm(t)
    return np.asarray(t if t @ along >= 0.0 else -t)


def solved_or_least(A: Floats, b: Floats) -> Floats:
    """Solve A x = b; where A is singular, as where two branches cross, the shortest x with the least defect."""
    try:
        return np.asarray(np.linalg.solve(A, b))
    except np.linalg.LinAlgError:
        return np.asarray(np.linalg.lstsq(A, b)[0])


def corrected(
    equations: Equations, z: Floats, across: Floats, known: Floats | None = None
) -> tuple[Floats, Floats, int] | None:
    """Solve the equations in the plane through z across a vector: the point, the derivative there, steps; or None.

    Equations of one piece of a map are solved from within: steps are cut short where they would leave it, the first one
    from a ``known`` point.
    """
    plane, before, cut, step = z.copy(), np.inf, 0, 0
    z = z.copy()
    if equations.pieced and known is not None:
        z = known + within(equations, known, z - known) * (z - known)
    while step < STEPS:
        step += 1
        F, wide = linearised(equations, z)
        if not (np.isfinite(F).all() and np.isfinite(wide).all()):
            return None
        move = solved_or_least(np.vstack([wide, across]), np.append(F, across @ (z - plane)))
        size = float(np.abs(move).max())
        if not size < 1e3:
            return None
        if equations.pieced:
            share = within(equations, z, -move)
            if share < 1.0:
                cut, step = cut + 1, step - 1
                if share == 0.0 or cut > CUT:
                    return None
                z, before = z - share * move, np.inf
                continue
            cut = 0
        z = z - move
        if size <= SMALL or (size <= 1e-9 and size >= 0.25 * before):
            if closes(equations, z):
                return z, wide, step
        if size > 2.0 * before and step > 2:
            return None
        before = size
    return None


def within(equations: Equations, z: Floats, move: Floats) -> float:
    """Return the part of a step in scaled coordinates after which equations of one piece hold still."""
    return equations.reach(*unscaled(equations, z), *unscaled(equations, move))


def closes(equations: Equations, z: Floats) -> bool:
    """Whether what Newton's method found on a piece of a map is a solution, not a place where the map jumps."""
    if not equations.pieced:
        return True
    x, p = unscaled(equations, z)
    F, J = equations.defects(x, p)
    rounding = 8.0 * EPS * (np.abs(J) @ np.abs(x))
    return bool((np.abs(F) <= CLOSED * equations.scale * (1.0 + np.abs(z[: len(F)])) + rounding).all())


def point_at(equations: Equations, z: Floats, along: Floats, known: Floats | None = None) -> Point | None:
    """Return the point of the path in the plane through z across ``along``."""
    found = corrected(equations, z, along, known)
    if found is None:
        return None
    z, wide, _steps = found
    return Point(z, tangent_of(wide, along), equations.tests(*unscaled(equations, z)))


def follow(
    equations: Equations,
    first: Point,
    bounds: tuple[float, float],
    *,
    step: float = 0.03,
    limit: int = 2000,
    stop: Callable[[Event], bool] | None = None,
) -> Path:
    """Follow a path from a point in the direction of its tangent until the parameter leaves its bounds.

    Parameters
    ----------
    equations : Equations
        With one parameter, or with several of which the last is the one that bounds are about.
    first : Point
    bounds : (low, high)
        Of the parameter; the last point lies on one of them.
    step : float
        Longest step in scaled coordinates.
    limit : int
        Most points.
    stop : callable, optional
        ``stop(event) -> bool`` ends the path at an event.

    Returns
    -------
    Path
        ``ended`` says why: *bounds*, *closed* (back at the first point), *limit*, *stopped*, *lost* (the corrector
        fails at the shortest step), or what :meth:`Equations.broken` says.
    """
    path = Path(equations, [first])
    span = float(equations.spans[-1])
    low, high = bounds[0] / span, bounds[1] / span
    h, here, left = min(FIRST, step), first, max(TRIES * limit, FEWEST)
    while len(path.points) < limit and left > 0:
        there, steps = advanced(equations, here, h)
        met, left = None, left - 1
        if there is None:  # beyond the end of the range there may be no equations
            ahead = here.z + h * here.tangent
            if not low <= ahead[-1] <= high and here.z[-1] not in (low, high):
                end = Point(ahead, here.tangent, ())
                there = at_value(equations, here, end, min(max(float(ahead[-1]), low), high))
                there = there if there is not None and np.linalg.norm(there.z - here.z) <= 2.0 * h else None
        if equations.pieced and over(equations, here, there, h):
            there, met, left = last(equations, here, h, left)
            h, steps = min(h, FIRST), STEPS
            if met is None and there is here:
                path.ended = "lost"
                return path
        if there is None or (met is None and float(there.tangent @ here.tangent) < STRAIGHT):
            if h <= SHORTEST:
                if there is None:
                    path.ended = "lost"
                    return path
            else:
                h = max(0.4 * h, SHORTEST)
                continue
        if met is not None and not low - NARROW <= there.z[-1] <= high + NARROW:
            met = None  # it ends beyond the range
        inside = met is not None or low <= there.z[-1] <= high
        leaves = not inside or (there.z[-1] in (low, high) and here.z[-1] != there.z[-1])
        if not inside:
            edge = at_value(equations, here, there, min(max(float(there.z[-1]), low), high))
            if edge is None or np.linalg.norm(edge.z - here.z) > 2.0 * h:  # Newton's method went elsewhere
                if h <= SHORTEST:
                    path.ended = "lost"
                    return path
                h = max(0.4 * h, SHORTEST)
                continue
            there = edge
            if np.array_equal(there.z, here.z):
                path.ended = "bounds"
                return path
        back = returned(equations, first, there, 0.6 * h) if len(path.points) > 3 and not leaves else None
        there = back or there
        broken = equations.broken(*unscaled(equations, there.z))
        for event in between(equations, here, there):
            path.points.append(event.point)
            path.events.append((len(path.points) - 1, event))
            if stop is not None and stop(event):
                path.ended = "stopped"
                return path
            if event.type == "pd" and event.where == HALVES:
                path.ended = "pd"
                return path
        path.points.append(there)
        if met is None and leaves and equations.pieced:  # a piece may end just there
            met = last(equations, there, NARROW, left)[1]
        if met is not None:
            return ended(path, path.points[-1], met)
        if broken or leaves:
            path.ended = broken or "bounds"
            return path
        if back is not None:
            path.ended = "closed"
            return path
        here = there
        h = min(step, h * (1.6 if steps <= 3 else (1.2 if steps <= 4 else 0.8)))
    path.ended = "limit"
    return path


def on_piece(equations: Equations, z: Floats) -> NDArray[np.bool_]:
    """Whether several points (k, n + 1) in scaled coordinates lie where the equations hold."""
    n = len(equations.scale)
    return equations.holds(z[:, :n] * equations.scale, z[:, n:] * equations.spans)


def over(equations: Equations, here: Point, there: Point | None, h: float) -> bool:
    """Whether a piece of a map seems to end within a step."""
    if there is not None:
        return strays(equations, here, there)
    return h <= SHORTEST or not on_piece(equations, (here.z + h * here.tangent)[None])[0]


def strays(equations: Equations, a: Point, b: Point) -> bool:
    """Whether the path leaves its piece of the map between two neighbouring points, as far as looks can tell."""
    t = np.arange(1.0, LOOKS)[:, None] / LOOKS
    length = float(np.linalg.norm(b.z - a.z))
    bow = t * (1.0 - t) * ((1.0 - t) * (length * a.tangent - b.z + a.z) + t * (b.z - a.z - length * b.tangent))
    z, n = a.z + t * (b.z - a.z) + bow, len(equations.scale)
    return not equations.holds(z[:, :n] * equations.scale, z[:, n:] * equations.spans, ASTRAY * length).all()


def last(equations: Equations, here: Point, h: float, tries: int) -> tuple[Point, tuple[Ending, float] | None, int]:
    """Return the last point on a piece of a map that a step reaches, found by halving, and what ends it and how near.

    None in place of the end if the path goes on beyond the step after all, or nothing is found that ends it in so many
    tries. The third result are those that are left.
    """
    finest = max(FINEST, EPS * float(np.abs(here.z).max()))
    most, gone, taken = 2.0 * h, 0.0, 1
    while gone <= most:
        while h >= finest and gone <= most and tries > 0:
            tries -= 1
            edge = straight(equations, here, h) if taken else h
            length = SHORT * edge if edge < h else 0.5 * h
            there, _steps = advanced(equations, here, length)
            if there is None or (length > SHORTEST and strays(equations, here, there)):
                h, taken = length, 0
            else:
                gone, here, taken = gone + length, there, taken + 1
                h = 2.0 * (1.0 - SHORT) * edge if edge < h else (h if taken < 3 else FARTHER * h)
        if tries <= 0:
            return here, None, 0
        gap = 16.0 * finest
        there, _steps = advanced(equations, here, gap)
        if there is None:
            break
        here, gone, h, taken = there, gone + gap, FARTHER * gap, 1
    else:
        return here, None, tries
    n = len(equations.scale)
    direction = here.tangent[:n] * equations.scale, here.tangent[n:] * equations.spans
    found = equations.ending(*unscaled(equations, here.z), *direction, gap)
    return here, None if not found.type and found.beyond is None else (found, gap), tries


def straight(equations: Equations, here: Point, h: float) -> float:
    """Return how far the tangent lies where the equations hold, to a part of itself; h if all the way."""
    low, high = 0.0, h
    while high - low > 0.25 * (1.0 - SHORT) * high:
        t = low + (high - low) * np.arange(1.0, LOOKS + 1.0) / LOOKS
        good = on_piece(equations, here.z + t[:, None] * here.tangent)
        if good.all():
            return high
        i = int(np.argmin(good))
        low, high = float(t[i - 1]) if i > 0 else low, float(t[i])
        if low == 0.0 and high < FINEST:
            break
    return high


def ended(path: Path, point: Point, end: tuple[Ending, float]) -> Path:
    """Return a path whose last point is where a piece of the map ends: with an event, or with what goes on there."""
    found, gap = end
    equations, path.ended = path.equations, found.type
    if found.beyond is not None:
        new, x, p = found.beyond
        old, q = unscaled(equations, point.z)
        point = point._replace(z=np.concatenate([(old - found.turned) / new.scale, q / new.spans]))
        z = np.concatenate([x / new.scale, p / new.spans])
        beyond = point_at(new, z, point.tangent)
        if beyond is not None and np.linalg.norm(beyond.z - point.z) < SHORTEST:
            path.ended = "relabelled"
            path.beyond.append((new, beyond, point))
        else:
            path.ended = "lost"
        return path
    span = float(equations.spans[-1])
    value = float(point.z[-1]) * span
    ends = value, value + float(point.tangent[-1]) * gap * span
    slack = (found.error + gap) * span
    low, high = min(ends) - slack, max(ends) + slack
    good = bool(high - low <= NARROW * span + 4.0 * EPS * abs(value))
    path.events.append((len(path.points) - 1, Event(found.type, point, found.where, low, high, good)))
    return path


def returned(equations: Equations, first: Point, there: Point, near: float) -> Point | None:
    """Return the first point, begun at another impact or period, if the path is back at it."""
    if abs(there.z[-1] - first.z[-1]) > near:
        return None
    x, p = unscaled(equations, first.z)
    y, order = equations.turned_to(x, p, unscaled(equations, there.z)[0])
    z = np.append(y / equations.scale, first.z[len(x) :])
    tangent = np.append(first.tangent[: len(x)][order], first.tangent[len(x) :])
    if np.linalg.norm(there.z - z) >= near or there.tangent @ tangent <= 0.9:
        return None
    return Point(z, tangent, equations.tests(y, p))


def advanced(equations: Equations, here: Point, h: float) -> tuple[Point | None, int]:
    """Return the point one step further, and the Newton steps that took."""
    found = corrected(equations, here.z + h * here.tangent, here.tangent, here.z)
    if found is None:
        return None, STEPS
    z, wide, steps = found
    if np.linalg.norm(z - here.z) > 2.0 * h:
        return None, STEPS
    return Point(z, tangent_of(wide, here.tangent), equations.tests(*unscaled(equations, z))), steps


def at_value(equations: Equations, a: Point, b: Point, value: float, index: int = -1) -> Point | None:
    """Return the point between two at which a scaled coordinate has a value, by Newton's method at that value.

    The coordinate is the parameter, if no other ``index`` is given.
    """
    share = (value - a.z[index]) / (b.z[index] - a.z[index])
    z = a.z + share * (b.z - a.z)
    z[index] = value
    across = np.zeros(len(z))
    across[index] = 1.0
    found = corrected(equations, z, across, a.z)
    if found is None:
        return None
    z, wide, _steps = found
    z[index] = value
    return Point(z, tangent_of(wide, a.tangent), equations.tests(*unscaled(equations, z)))


def between(equations: Equations, a: Point, b: Point) -> list[Event]:
    """Return what happens between two neighbouring points, in order along the path."""
    chord = b.z - a.z
    length = float(np.linalg.norm(chord))
    if length == 0.0:
        return []
    along = chord / length
    found: list[tuple[float, Event] | None] = []
    halves = [equations.halved(*unscaled(equations, q.z)) for q in (a, b)]
    folds = a.tangent[-1] * b.tangent[-1] < 0.0
    if halves[0] is not None and halves[1] is not None and float(halves[0] @ halves[1]) < 0.0:
        across = halves[0]

        def uneven(q: Point) -> float:
            apart = equations.halved(*unscaled(equations, q.z))
            assert apart is not None
            return float(across @ apart)

        one = located(equations, a, along, length, "pd", HALVES, uneven)
        if one is not None:
            return [one[1]]
    images = [equations.mirrored(*unscaled(equations, q.z)) for q in (a, b)]
    if images[0] is not None and images[1] is not None and float(images[0] @ images[1]) < 0.0:
        if min(np.abs(one).max() for one in images if one is not None) > ALIKE:
            beside = images[0]

            def lopsided(q: Point) -> float:
                apart = equations.mirrored(*unscaled(equations, q.z))
                assert apart is not None
                return float(beside @ apart)

            found.append(located(equations, a, along, length, "bp", MIRRORS, lopsided))
            folds = folds and found[-1] is None  # there the branch turns round into its mirror image
    if folds:
        found.append(located(equations, a, along, length, "lp", -1, lambda q: float(q.tangent[-1])))
    for i, (before, after) in enumerate(zip(a.tests, b.tests, strict=False)):
        if (before.value > 0.0) == (after.value > 0.0) or before[::2] != after[::2]:
            continue
        type = before.type
        if type == "lp":  # its test function is zero at a fold, and where two branches cross
            if folds:
                continue
            type = "bp"
        one = located(equations, a, along, length, type, before.where, partial(height_of, i))
        found.append(one if one is not None and told(one, before, after, i) else None)
    return ordered([one for one in found if one is not None])


def ordered(found: list[tuple[float, Event]]) -> list[Event]:
    """Return events in order along the path; what is at one place but for rounding in the order of test functions."""
    along = sorted(range(len(found)), key=lambda i: found[i][0])
    groups: list[list[int]] = []
    for i in along:
        if groups and found[i][0] - found[groups[-1][-1]][0] <= AT_ONCE:
            groups[-1].append(i)
        else:
            groups.append([i])
    return [found[i][1] for group in groups for i in sorted(group)]


def told(found: tuple[float, Event], before: Test, after: Test, i: int) -> bool:
    """Whether an event is more than the error of its test function.

    Differences across a kink of a map lead from one slope to another as if there were slopes between.
    """
    error = found[1].point.tests[i].error or max(before.error, after.error)
    return error == 0.0 or error <= VANISHED * min(1.0, max(abs(before.value), abs(after.value)))


def height_of(i: int, point: Point) -> float:
    """Return one test function at a point."""
    if i >= len(point.tests):  # an impact has come or gone: the tests are others there
        raise ArithmeticError
    return point.tests[i].value


def located(
    equations: Equations,
    a: Point,
    along: Floats,
    length: float,
    type: str,
    where: int,
    height: Callable[[Point], float],
) -> tuple[float, Event] | None:
    """Return how far along the chord from a, and the event there: the zero of a function of points.

    None where the function jumps over zero, as the lowest dip does where two dips merge, or has a pole.
    """
    seen: dict[float, tuple[Point, float]] = {0.0: (a, height(a))}

    def at(s: float) -> float:
        near = min(seen, key=lambda other: abs(other - s))
        if near != s:
            base = seen[near][0]
            ahead = (s - near) / max(float(base.tangent @ along), 0.1)
            point = point_at(equations, plane_point(a, along, s, base.z + ahead * base.tangent), along, base.z)
            if point is None:
                raise ArithmeticError
            seen[s] = point, height(point)
        return seen[s][1]

    good = False
    try:
        if np.sign(at(0.0)) * np.sign(at(length)) <= 0.0:  # products of small numbers may underflow
            brentq(at, 0.0, length, xtol=1e-17, rtol=8.9e-16, maxiter=100)
            good = True
    except (ArithmeticError, RuntimeError):
        pass
    if equations.pieced and not good and where != HALVES:
        return None
    s = min(seen, key=lambda other: abs(seen[other][1]))
    if good:  # at a pole the smallest value lies elsewhere
        changes = [
            (t - r, min(r, t, key=lambda other: abs(seen[other][1])))
            for r, t in pairwise(sorted(seen)) if (seen[r][1] > 0.0) != (seen[t][1] > 0.0)
        ]  # fmt: skip
        good, s = bool(changes), min(changes)[1] if changes else s
    point, rest = seen[s]
    positive = seen[0.0][1] > 0.0
    sides = [
        max((t for t in seen if t <= s and (seen[t][1] > 0.0) == positive), default=0.0),
        min((t for t in seen if t >= s and (seen[t][1] > 0.0) != positive), default=length if length in seen else s),
    ]
    low, high = sorted(float(seen[t][0].z[-1]) * float(equations.spans[-1]) for t in sides)
    value = float(point.z[-1]) * float(equations.spans[-1])
    most = max(abs(seen[0.0][1]), abs(seen[length][1])) if good else 0.0
    if good and abs(rest) > VANISHED * most:
        return None
    if equations.pieced and good and any(one.type == type and one.error >= most for one in point.tests):
        return None  # differences reach across the end of a piece
    if (
        equations.pieced and where != HALVES and not abs(rest) <= VANISHED
    ):  # next to an infinite slope all else is small
        return None
    return s, Event(type, point, where, min(low, value), max(high, value), good)


def plane_point(a: Point, along: Floats, s: float, guess: Floats) -> Floats:
    """Return the guess moved into the plane across ``along`` at a distance s from a."""
    return np.asarray(guess + along * (s - float((guess - a.z) @ along)))
