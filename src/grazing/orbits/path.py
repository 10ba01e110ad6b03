"""A path: solutions of equations followed in one parameter by pseudo-arclength, with what happens on the way located.

From a point and the tangent there the next point is predicted and corrected in the plane across the tangent, see
:mod:`grazing.orbits.corrector`. Where test functions change their signs between two points, see
:mod:`grazing.orbits.events`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from grazing.orbits.corrector import STEPS, Point, advanced, at_value, linearised, point_at, tangent_of, unscaled
from grazing.orbits.equations import Ending, Equations
from grazing.orbits.even_equations import EVEN
from grazing.orbits.events import HALVES, Event, between
from grazing.orbits.one_sided import EPS

Floats = NDArray[np.float64]

#: Cosine of the largest angle between neighbouring tangents.
STRAIGHT = 0.97
#: Shortest step, and the first one, in units of the scaled coordinates.
SHORTEST, FIRST = 1e-9, 1e-3
#: Steps shorter than this, in scaled unknowns, end the search for the end of a piece.
FINEST = 2e-16
#: Cosine of the largest angle between the tangent's unknowns and the way to the mirror image that it leads to.
TOWARDS = 0.5
#: Steps, taken or not, for each point of a path that is allowed, and the fewest of a path, after which it is given up.
TRIES, FEWEST = 20, 2000
#: Part of the way to the end of a piece, as the tangent tells it, that is taken at once.
SHORT = 0.999
#: Where there is a solution beyond what seemed to be the end, the search goes on with steps so much longer.
FARTHER = 256.0
#: Widest bracket of an end that has converged, in units of the range of the parameter.
NARROW = 1e-12
#: Largest defect on the way from one point to the next, in units of its length, beyond which the map has jumped.
ASTRAY = 0.05


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


def joined(backward: Path, forward: Path) -> Path:
    """Return one path of two that leave the same point in opposite directions."""
    back = [point._replace(tangent=-point.tangent) for point in backward.points[:0:-1]]
    last = len(backward.points) - 1
    events = [(last - i, event) for i, event in reversed(backward.events)]
    events += [(last + i, event) for i, event in forward.events]
    beyond = backward.beyond + forward.beyond
    return Path(forward.equations, back + forward.points, events, forward.ended, backward.ended, beyond)


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
        image = reflected(equations, here, h) if there is None else None
        if image is not None:
            there, h = image, float(np.linalg.norm(image.z - here.z))
        if equations.pieced and over(equations, here, there, h):
            there, met, left = last(equations, here, h, left)
            h, steps = min(h, FIRST), STEPS
            if met is None and there is here:
                path.ended = "lost"
                return path
        if there is None or (met is None and image is None and float(there.tangent @ here.tangent) < STRAIGHT):
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
        events = between(equations, here, there)
        if events is None and h > SHORTEST:
            h = max(0.4 * h, SHORTEST)
            continue
        for event in events or []:
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


def reflected(equations: Equations, here: Point, h: float) -> Point | None:
    """Return the mirror image of a point that is nearly its own one, if the path leads there and a step h does not.

    In between the path crosses the orbits that are their own mirror images. Its equations are singular there, and
    Newton's method fails next to it in a narrow range, in which the parameter's rounding is a long way.
    """
    x, p = unscaled(equations, here.z)
    for image in equations.reflections(x, p):
        z = np.concatenate([image / equations.scale, here.z[len(x) :]])
        chord = z - here.z
        length = float(np.linalg.norm(chord))
        towards = float(here.tangent @ chord)  # the parameter is the same, however narrow its range
        if h <= length <= EVEN and towards >= TOWARDS * length * np.linalg.norm(here.tangent[: len(x)]):
            return Point(z, tangent_of(linearised(equations, z)[1], chord / length), equations.tests(image, p))
    return None


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
    t = np.arange(1.0, equations.looks)[:, None] / equations.looks
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
        t = low + (high - low) * np.arange(1.0, equations.looks + 1.0) / equations.looks
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
