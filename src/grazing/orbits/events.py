"""What happens between two neighbouring points of a path: zeros of test functions, solved for on planes in between."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from grazing import late
from grazing.orbits.corrector import Point, point_at, unscaled
from grazing.orbits.equations import Equations, Test

Floats = NDArray[np.float64]

#: Part of its size at which a test function counts as zero.
VANISHED = 1e-6
#: Place of a period doubling at which an orbit becomes one of half its period, and of a branch point at which it
#: becomes its own mirror image.
HALVES, MIRRORS = -2, -3
#: Events that are no farther apart, in scaled coordinates, happen at one place.
AT_ONCE = 1e-9
#: The chord between two points is so much shorter than the way to what Newton's method finds where it goes elsewhere;
#: and so often it is then tried from half as far away.
ELSEWHERE, NEARER = 2.0, 6
#: An orbit and its mirror image that differ by less, in scaled unknowns, are one: symmetric.
ALIKE = 1e-7


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


def between(equations: Equations, a: Point, b: Point) -> list[Event] | None:
    """Return what happens between two neighbouring points, in order along the path.

    None if b is its own mirror image and a is not: the path crosses that branch in one point, and b is on the other.
    """
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
            return [led_to(equations, along * length, (a, b), one[1])]
    images = [equations.images(*unscaled(equations, q.z)) for q in (a, b)]
    for m, beside in images[0].items():
        other = images[1].get(m, beside)
        sizes = [float(np.abs(one).max()) for one in (beside, other)]
        if sizes[1] <= ALIKE < sizes[0]:
            return None
        if max(sizes) <= ALIKE:
            continue
        if min(sizes) > ALIKE and float(beside @ other) < 0.0:

            def lopsided(q: Point, m: int = m, beside: Floats = beside) -> float:
                return float(beside @ equations.images(*unscaled(equations, q.z))[m])

            one = located(equations, a, along, length, "bp", MIRRORS, lopsided)
            if one is not None:
                found.append((one[0], led_to(equations, along * length, (a, b), one[1])))
                folds = False  # there the branch turns round into its mirror image
        break  # it is not even made of so many parts, so not of more
    if folds:
        found.append(located(equations, a, along, length, "lp", -1, lambda q: float(q.tangent[-1])))
    for i, (before, after) in enumerate(zip(a.tests, b.tests, strict=False)):
        if (before.value > 0.0) == (after.value > 0.0) or before[::2] != after[::2]:
            continue
        if max(abs(before.value), abs(after.value)) < min(before.error, after.error):
            continue  # nobody knows its signs: it may be zero all along
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

    def at(s: float, tries: int = NEARER) -> float:
        near = min(seen, key=lambda other: abs(other - s))
        if near != s:
            base = seen[near][0]
            ahead = (s - near) / max(float(base.tangent @ along), 0.1)
            point = point_at(equations, plane_point(a, along, s, base.z + ahead * base.tangent), along, base.z)
            if point is None or np.linalg.norm(point.z - a.z) > ELSEWHERE * length:
                if tries == 0:
                    raise ArithmeticError
                at(0.5 * (near + s), tries - 1)
                return at(s, tries - 1)
            seen[s] = point, height(point)
        return seen[s][1]

    good = False
    try:
        if np.sign(at(0.0)) * np.sign(at(length)) <= 0.0:  # products of small numbers may underflow
            late.optimize.brentq(at, 0.0, length, xtol=1e-17, rtol=8.9e-16, maxiter=100)
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
    if type == "bp":  # there the derivative does not tell one branch from the other
        point = point._replace(tangent=along)
    return s, Event(type, point, where, min(low, value), max(high, value), good)


def led_to(equations: Equations, chord: Floats, ends: tuple[Point, Point], event: Event) -> Event:
    """Return an event where a path crosses a branch of shorter or symmetric orbits, bracketed by where its ends lead.

    That branch lies across the chord as a whole: any point of it may be found in place of the one that is crossed.
    """
    span, length = float(equations.spans[-1]), float(chord @ chord)
    values = [event.low, event.high]
    for q, way in zip(ends, (length, -length), strict=True):
        forward = float(q.tangent @ chord)
        if forward != 0.0:  # the path bends back: its tangent leads past the point
            values += [float(q.z[-1]) * span, float(q.z[-1] + way / forward * q.tangent[-1]) * span]
    return event._replace(low=min(values), high=max(values))


def plane_point(a: Point, along: Floats, s: float, guess: Floats) -> Floats:
    """Return the guess moved into the plane across ``along`` at a distance s from a."""
    return np.asarray(guess + along * (s - float((guess - a.z) @ along)))
