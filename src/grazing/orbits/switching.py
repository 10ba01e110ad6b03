"""Where other branches begin: at a period doubling, a branch point, and at a graze that changes the word."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from grazing import late
from grazing.late import named
from grazing.orbits.corrector import Point, closed, corrected, linearised, tangent_of, weighed
from grazing.orbits.equations import Equations, Test
from grazing.orbits.events import Event
from grazing.orbits.signature import equations_of
from grazing.orbits.special import Special
from grazing.outcome import InputError

Floats = NDArray[np.float64]

#: How far along its direction another branch is looked for, in scaled unknowns, one after the other.
AWAY = (1e-4, 1e-3, 1e-2)
#: Test functions that say whether an orbit is one of the flow.
OF_THE_FLOW = ("gr", "v0", "law", "st", "bcb")
#: Test functions of the flow below this are 0: heights, speeds and forces in units of their size.
ZERO = 1e-10
#: Two turns that differ by less, in scaled unknowns, are one turn twice.
REPEATED = 1e-5
#: How far from where it is looked for a test function may vanish, in units of the range of the parameter.
NEAR = 1e-4
#: Last step of a secant, in units of the range of the parameter: the next one would be of the size of rounding.
VANISHED = 1e-9
#: A test function that begins at its zero is put on the side that the path goes to.
BARELY = 1e-300


class Seed(NamedTuple):
    """Where a piece of a branch begins: on both sides of a point or on one, and from which special point.

    ``leaves`` is the point of another branch that it leaves, if that is not the point itself, and ``type`` what
    happens there.
    """

    equations: Equations
    point: Point
    both: bool = False
    origin: int = -1
    leaves: Point | None = None
    type: str = "seed"


def seeded(equations: Equations, x: Floats, p: Floats, along: Floats | None = None) -> Point:
    """Return the point of a path at a known solution; its tangent points along a direction, else to larger p."""
    z = np.concatenate([x / equations.scale, p / equations.spans])
    if along is None:
        along = np.zeros(len(z))
        along[-1] = 1.0
    _F, wide = linearised(equations, z)
    return Point(z, tangent_of(wide, along), equations.tests(x, p))


def seeded_at_fold(equations: Equations, x: Floats, p: Floats) -> Point | None:
    """Return the point of a path at a fold, where Newton's method at a fixed parameter fails; None if it is none."""
    z = np.concatenate([x / equations.scale, p / equations.spans])
    _F, wide = linearised(equations, z)
    if not np.isfinite(wide).all():
        return None
    along = np.asarray(np.linalg.svd(wide)[2][-1])
    found = corrected(equations, z, along)
    if found is None or np.linalg.norm(found[0] - z) > 1e-3:
        return None
    n = len(equations.scale)
    return seeded(equations, found[0][:n] * equations.scale, found[0][n:] * equations.spans, along)


def once(equations: Equations, x: Floats, p: Floats, width: float) -> tuple[Equations, Floats, Floats, bool]:
    """Return where an orbit that goes round twice is one of half its period: its period doubling, to rounding.

    It is within the width of a bracket.
    """
    half, x = equations.halving(x, p)
    return half, *vanishing(half, closed, 0, x, p, width)


def evened(
    equations: Equations, x: Floats, p: Floats, width: float
) -> tuple[Floats, Floats, tuple[float, float] | None]:  # fmt: skip
    """Return where symmetric orbits have a multiplier 1, to rounding, from one that is nearly symmetric.

    It is within the width of a bracket, in which the equations of all impacts may not have led to it. The solution, the
    parameter and a bracket of it, between whose ends the test function changes its sign; or None.
    """
    x, p, good = vanishing(equations, closed_evenly, 1, x, p, width)
    value, reach = float(p[0]), 1e-15 * (abs(float(p[0])) + float(equations.spans[0]))
    while good and reach < 1e-9 * float(equations.spans[0]):
        ends = value - reach, value + reach
        found = [closed_evenly(equations, x, np.array([end])) for end in ends]
        sides = [
            equations.tests(y, np.array([end]))[1].value for y, end in zip(found, ends, strict=True) if y is not None
        ]
        if len(sides) == 2 and sides[0] * sides[1] < 0.0:
            return x, p, ends
        reach *= 4.0
    return x, p, None


def nearly_even(equations: Equations, x: Floats, p: Floats) -> bool:
    """Whether an orbit is its own mirror image, or nearly so."""
    return equations.even(x, p) is not None


def closed_evenly(equations: Equations, x: Floats, p: Floats) -> Floats | None:
    """Return the solution nearby that is its own mirror image; None where Newton's method does not converge.

    Where symmetry breaks the derivative is singular, but not among symmetric solutions.
    """
    even = equations.even(x, p)
    if even is None:
        return None
    part, before = even.part(x, p), np.inf
    for _ in range(30):
        F, J = even.defects(part, p)
        if not np.isfinite(J).all():
            return None
        F, J = weighed(F, J * even.scale)
        move = np.linalg.lstsq(J, F)[0]
        size, part = float(np.abs(move).max()), part - move * even.scale
        if size <= 1e-15 or (size <= 1e-9 and size >= 0.25 * before):
            return even.whole(part, p)
        before = size
    return None


def vanishing(
    equations: Equations, solve: Callable[..., Floats | None], test: int, x: Floats, p: Floats, width: float
) -> tuple[Floats, Floats, bool]:
    """Return the solution and parameter nearby at which a test function, by its number, is zero; and whether it is.

    Nearby is within the width of a bracket, or :data:`NEAR`.
    """

    def height(share: float) -> float:
        q = share * equations.spans
        found = solve(equations, x, q)
        return float("nan") if found is None else equations.tests(found, q)[test].value

    begin = float(p[0] / equations.spans[0])
    with np.errstate(invalid="ignore"):
        found = late.optimize.root_scalar(height, x0=begin, x1=begin + 1e-6, xtol=VANISHED, method="secant")
    good = found.converged and abs(found.root - begin) < max(NEAR, width / float(equations.spans[0]))
    p = found.root * equations.spans if good else p
    solved = solve(equations, x, p)
    return x if solved is None else solved, p, bool(good and solved is not None)


def switched(special: Special, name: str, bounds: tuple[float, float]) -> list[Seed]:
    """Return where the other branch leaves a period doubling or a branch point.

    There the derivative has a second null vector. At a period doubling the equations of two turns have it, of opposite
    sign in the two turns and with no change of the parameter; at a branch point it is taken across the branch. The
    other branch is looked for a little way along it.
    """
    low, high = bounds
    if special.type not in ("pd", "bp"):
        raise InputError(
            f"{special!r} is a {special.meaning.split(':')[0]}; another branch begins at pd and bp only, and "
            "gz.continuation passes grazes by itself"
        )
    if not low <= special.value <= high:
        raise InputError(f"{special!r} lies outside of [{low:g}, {high:g}]; widen the range of {name}")
    spans = np.array([high - low])
    equations, x = equations_of(special.orbit, (name,), spans)
    if special.type == "pd":
        equations, x = equations.doubling(x, np.array([special.value]))
    z = np.concatenate([x / equations.scale, np.array([special.value]) / spans])
    _F, wide = linearised(equations, z)
    one, other = np.linalg.svd(wide)[2][-2:]
    if special.type == "pd":
        across = other[-1] * one - one[-1] * other
    else:
        ahead = special.direction if special.direction is not None else one
        across = (ahead @ one) * other - (ahead @ other) * one
    across = across / np.linalg.norm(across)
    seeds = []
    for direction in (across,) if special.type == "pd" else (across, -across):
        for away in AWAY:
            found = corrected(equations, z + away * direction, direction)
            if found is not None and np.linalg.norm(found[0] - z) < 3.0 * away:
                n = len(equations.scale)
                there, p = found[0][:n] * equations.scale, found[0][n:] * equations.spans
                at = Point(z, direction, equations.tests(x, np.array([special.value])))
                seeds.append(Seed(equations, seeded(equations, there, p, direction), leaves=at, type=special.type))
                break
    if not seeds:
        raise InputError(f"no other branch was found within {AWAY[0]:g} to {AWAY[-1]:g} of {special!r}")
    return seeds


def allowed(equations: Equations, x: Floats, p: Floats) -> bool:
    """Whether a solution is an orbit of the map, or just not."""
    return all(test.value >= -ZERO for test in equations.tests(x, p) if test.type in OF_THE_FLOW)


def on_the_edge(equations: Equations, event: Event) -> bool:
    """Whether nothing but the event itself keeps the orbit from being one of the map.

    At a graze of the steady response every period of a longer orbit touches the wall: zeros count as none.
    """
    # a point may have several borders: those that it is not at count
    others = (
        test for test in event.point.tests
        if (test.type, test.where) != (event.type, event.where) or (event.converged and test.value < -ZERO)
    )  # fmt: skip
    return all(test.value >= -ZERO for test in others if test.type in OF_THE_FLOW)


def partners(equations: Equations, event: Event, x: Floats, p: Floats) -> list[Seed]:
    """Return the branches that begin at a graze or a border collision where the map is continuous.

    Nothing begins where the bumper kicks a ball that only touches it, or the gap map has a gap; nor at a graze of an
    orbit that is virtual for another reason.
    """
    if not event.converged or not on_the_edge(equations, event):
        return []
    seed: Seed | None = named(equations.others)(equations, event, x, p)
    return [] if seed is None else [seed]


def flipped(equations: Equations, event: Event, x: Floats, p: Floats) -> Seed | None:
    """Return the branch of a map by pieces whose point at the border has the other letter, where it is continuous."""
    found = equations.across(x, p, event.where)
    if found is None or not found.close:
        return None
    return begins(found.equations, found.x, p, "bcb", event.where)


def begins(equations: Equations, x: Floats, p: Floats, type: str, where: int) -> Seed | None:
    """Return the seed at a solution where one test function is zero, going to where it is positive."""
    solved = closed(equations, x, p)
    if solved is not None and np.abs((solved - x) / equations.scale).max() < 1e-5:
        x = solved
    if equations.broken(x, p) or not np.isfinite(equations.defects(x, p)[1]).all():
        return None
    point = seeded(equations, x, p)
    place = [i for i, test in enumerate(point.tests) if (test.type, test.where) == (type, where)]
    if not place:
        return None
    i = min(place, key=lambda one: abs(point.tests[one].value))
    n, h = len(equations.scale), 1e-6
    sides = []
    for sign in (1.0, -1.0):
        z = point.z + sign * h * point.tangent
        sides.append(equations.tests(z[:n] * equations.scale, z[n:] * equations.spans))
    ahead, tangent = (sides[0], point.tangent) if sides[0][i].value > sides[1][i].value else (sides[1], -point.tangent)
    tests: list[Test] = list(point.tests)
    kinds = ("bcb",) if type == "bcb" else ("gr", "v0")
    for j, test in enumerate(tests):  # points that collide, and periods that graze, at once
        if test.type in kinds and abs(test.value) < ZERO:
            tests[j] = test._replace(value=float(np.copysign(BARELY, ahead[j].value)))
    tests[i] = tests[i]._replace(value=BARELY)
    return Seed(equations, Point(point.z, tangent, tuple(tests)), type=kinds[0])


def turns(equations: Equations, x: Floats, p: Floats) -> int:
    """Return how many times a solution goes round the same shorter orbit; 1 for an orbit of its full period."""
    for k in range(equations.N, 1, -1):
        if equations.N % k == 0 and (apart := equations.later(x, p, k)) is not None:
            if np.abs(apart).max() < REPEATED:
                return k
    return 1
