"""What ends a piece of a map: a border between letters, a graze, a jump, or a change of name alone."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from grazing.orbits.corrector import corrected, unscaled
from grazing.orbits.equations import Ending
from grazing.orbits.one_sided import EPS

if TYPE_CHECKING:
    from grazing.orbits.map_equations import MapEquations, Stepped

Floats = NDArray[np.float64]

#: Distances from a solution, in sizes of the box and of the range, at which another letter, or a steep slope is sought.
NEAR = 4.0 ** np.arange(-80.0, -11.0)
STEEP = 4.0 ** np.arange(-14.0, -5.0)
#: Bracket, in units of the range, where a steep slope is met that no letter tells from what lies beside it.
UNKNOWN = 1e-5
#: Times a point's distance from the border over its speed that it may take to get there: twice on a parabola.
LATE = 4.0
#: Power of the distance with which values change at a steep slope, at most; a kink and a smooth map have 1 or more.
POWER = 0.9
#: Part of its size by which a value may jump, and a slope turn, where a map is smooth.
JUMP, TURN = 1e-12, 1e-6
#: How far beyond the last solution, in units of the last step, a jump is looked for.
APART = 64.0
#: Times as far back as before a point of the path is looked at beside its last one; how far back at most, for no smooth
#: map is steeper there by as much; and by how much a derivative has then grown that is told from rounding.
FURTHER, FARTHEST, GROWN = 4.0, 1e-6, 1.1
#: Part of a direction over which it is told how a period changes along it.
SLIGHT = 1e-7
#: Distances beyond the end at which the orbit is looked for with its new letters, in scaled unknowns.
BEYOND = 4.0 ** np.arange(-24.0, -10.0)


def ending(equations: MapEquations, x: Floats, p: Floats, dx: Floats, dp: Floats, gap: float) -> Ending:
    """Say what is met from the last solution of a piece.

    A graze where the map is infinitely steep on either side; nothing but another word where it is continuous and has
    one slope; else a border collision where a point gets another letter, and the end of the piece where the map jumps
    or has a kink without saying so.
    """
    touched = flips(equations, x, p)
    steep = steep_at(equations, x, p)
    error = unsure(equations, x, p, dx, dp, touched)
    if steep >= 0:
        error = max(error, LATE * left_over(equations, x, p, dx, dp, gap))
        return Ending("gr", steep, error if touched else max(error, UNKNOWN))
    beyond = smooth_beyond(equations, x, p, dx, dp, gap)
    if beyond is not None:
        return Ending("", -1, error, *beyond)
    if touched:
        return Ending("bcb", touched[0][0], error)
    return Ending("ep" if torn(equations, x, p, dx, dp, gap) else "", -1, error + APART * gap)


def ways(equations: MapEquations, x: Floats) -> Floats:
    """Return the directions (ways, N, dim) in which each point is moved: along each coordinate, up and down."""
    N, d = equations.N, equations.P.dimension
    one = np.concatenate([np.eye(d), -np.eye(d)]) * equations.size
    return np.repeat(one[:, None], N, axis=1)


def flips(equations: MapEquations, x: Floats, p: Floats) -> list[tuple[int, int, float]]:
    """Return the points next to a border between letters, the nearest first, with the coordinate and the distance."""
    N, d = equations.N, equations.P.dimension
    moved = x.reshape(N, d) + NEAR[:, None, None, None] * ways(equations, x)
    row = equations.rows(p[None])
    letters = equations.ran(row, moved.reshape(-1, d).T[None])[1][0].reshape(len(NEAR), 2 * d, N)
    found = []
    for j in range(N):
        other = letters[:, :, j] != equations.letters[j]
        found += [(int(np.argmax(other[:, way])), j, way % d) for way in range(2 * d) if other[:, way].any()]
    for j, sign in ((j, sign) for j in range(len(p)) for sign in (1.0, -1.0)):  # a border that the parameter moves
        dp = sign * np.eye(len(p))[j] * equations.spans
        for k, t in enumerate(NEAR):
            if not equations.in_range(p + t * dp):
                break
            seen = equations.visited(x, p + t * dp)[1]
            if seen != equations.letters:
                found += [(k, i, -1) for i in range(N) if seen[i] != equations.letters[i]]
                break
    return [(j, way, float(NEAR[k])) for k, j, way in sorted(found)]


def steep_at(equations: MapEquations, x: Floats, p: Floats) -> int:
    """Return a point next to which the map is infinitely steep on one side, -1 for none."""
    N, d = equations.N, equations.P.dimension
    way = ways(equations, x)
    t = np.concatenate([STEEP, 2.0 * STEEP])
    moved = x.reshape(N, d) + t[:, None, None, None] * way
    images, letters = equations.ran(equations.rows(p[None]), moved.reshape(-1, d).T[None])
    values = images[0].T.reshape(2, len(STEEP), 2 * d, N, d) / equations.size
    names = letters[0].reshape(2, len(STEEP), 2 * d, N)
    with np.errstate(all="ignore"):
        change = np.abs(values[1] - values[0]).max(axis=-1)
        noise = 1e3 * EPS * np.abs(values).max(axis=(0, -1))
        good = (names[0] == names[1]) & (change > noise)
        power = np.log(change[1:] / change[:-1]) / np.log(STEEP[1:] / STEEP[:-1])[:, None, None]
        both = good[1:] & good[:-1] & (names[0][1:] == names[0][:-1])
    for j in range(N):
        for i in range(2 * d):
            seen = power[:, i, j][both[:, i, j]]
            if len(seen) >= 4 and (seen[:4] < POWER).all():
                return j
    return -1


def unsure(
    equations: MapEquations, x: Floats, p: Floats, dx: Floats, dp: Floats, touched: list[tuple[int, int, float]]
) -> float:
    """Return by how much the end may be off in the scaled parameter.

    That is what rounding and the defects move it by while the point at the border stays there, and the way that this
    point still has to go.
    """
    images, J, _error, _letters = equations.stepped(x, p)
    N, d = equations.N, equations.P.dimension
    points = x.reshape(N, d)
    after = np.roll(points, -1, axis=0)
    slack = np.abs(images - after) + EPS * (np.abs(images) + np.abs(after))
    slack += EPS * np.einsum("jik,jk->ji", np.abs(J), np.abs(points))
    size = equations.scale
    wide = np.column_stack([equations.defects(x, p)[1] * size, equations.slopes(x, p)[:, -1] * equations.spans[-1]])
    rate = float(np.abs(dp[-1]) / equations.spans[-1])
    found = [np.inf] if touched else [0.0]
    for j, i, away in touched:
        if j != touched[0][0]:
            continue
        if i < 0:  # a border that the parameter moves
            found.append(away)
            continue
        place = j * d + i
        going = abs(float(dx[place])) / size[place]
        try:
            held = np.linalg.inv(np.delete(wide, place, axis=1))[-1]
        except np.linalg.LinAlgError:
            continue
        if going > 0.0:
            found.append(float(np.abs(held) @ np.roll(slack, 1, axis=0).ravel()) + LATE * away * rate / going)
    return float(min(found) + EPS * np.abs(p[-1]) / equations.spans[-1])


def left_over(equations: MapEquations, x: Floats, p: Floats, dx: Floats, dp: Floats, gap: float) -> float:
    """Return how far off an impact of no speed is, in the scaled parameter; 0 where derivatives do not grow.

    They grow as one over the distance, and rounding hides such an impact long before its speed is 0. The distance
    follows from derivatives here and farther back.
    """
    grown = steepness(equations, x, p)
    here, way = (np.concatenate([a / equations.scale, b / equations.spans]) for a, b in ((x, p), (dx, dp)))
    back, most = FURTHER * gap, 0.0
    while back < FARTHEST:
        found = corrected(equations, here - back * way, way)
        if found is not None:
            times = grown / steepness(equations, *unscaled(equations, found[0]))
            if times > GROWN:
                most = max(most, abs(float(found[0][-1] - here[-1])) / (times - 1.0))
        back *= FURTHER
    return most


def steepness(equations: MapEquations, x: Floats, p: Floats) -> float:
    """Return the largest derivative of the map at the points of an orbit, in units of the box."""
    return float(np.abs(equations.stepped(x, p).J * equations.size / equations.size[:, None]).max())


def smooth_beyond(
    equations: MapEquations, x: Floats, p: Floats, dx: Floats, dp: Floats, gap: float
) -> tuple[tuple[MapEquations, Floats, Floats], Floats] | None:
    """Return the equations and a point next to their solution beyond the end, if the map is smooth there.

    And what unknowns lose that come round just there: the map jumps by as much, and is smooth all the same. Nearest to
    the end rounding mixes letters of both sides; beyond it they stay.
    """
    letters = equations.letters
    for t in BEYOND[np.flatnonzero(BEYOND >= gap)]:
        y, q = x + t * dx, p + t * dp
        if not equations.in_range(q):
            return None
        around = equations.rounds(q)
        times = np.floor(y / around)
        around[times == 0.0] = 0.0
        turned = times * around
        nearer, letters = letters, equations.visited(y - turned, q)[1]
        if letters == nearer != equations.letters:
            break
    else:
        return None
    new = equations.like(letters)
    before, here, _l = equations.along(x, p, dx, dp)
    slow, fast = (np.where(times == 0.0, 0.0, equations.rounds(p + s * dp)) for s in (0.0, SLIGHT))
    longer = times * (fast - slow) / SLIGHT
    after, there, _l = new.along(y - turned, q, dx - longer, dp)
    missing, slower = (np.roll(one.reshape(new.N, -1), -1, axis=0) for one in (turned, longer))
    k = len(here) // 2
    size = equations.size
    with np.errstate(invalid="ignore"):
        low, high = before.below / size, (after.above + slower) / size
        off = np.abs(there[k] + missing - here[k] - t * before.below) / size
        loud = np.abs(here[k]) / size + np.abs(x.reshape(new.N, -1)) / size * (1.0 + np.abs(low))
        turn = np.abs(high - low)
        most = 1.0 + np.maximum(np.abs(low), np.abs(high))
        smooth = (off <= JUMP + 64.0 * EPS * loud).all() and (turn <= TURN * most).all()
        # along the border the slopes are one, whatever they are across it
        smooth = smooth and not kinked(equations.stepped(x, p), new.stepped(y - turned, q))
    return ((new, y - turned, q), turned) if smooth else None


def kinked(before: Stepped, after: Stepped) -> bool:
    """Whether derivatives of steps differ, by more than both their errors."""
    turn, error = np.abs(after.J - before.J), after.error + before.error
    return bool((turn > TURN * (1.0 + np.abs(before.J)) + error).any())


def torn(equations: MapEquations, x: Floats, p: Floats, dx: Floats, dp: Floats, gap: float) -> bool:
    """Whether the map jumps or has a kink between the last solution and what lies just beyond."""
    before, here, _l = equations.along(x, p, dx, dp)
    t = APART * gap
    if not equations.in_range(p + t * dp):
        return False
    after, there, _l = equations.along(x + t * dx, p + t * dp, dx, dp)
    k = len(here) // 2
    size = equations.size
    with np.errstate(invalid="ignore"):
        off = np.abs(there[k] - here[k] - t * before.below) / size
        loud = np.abs(here[k]) / size + np.abs(x.reshape(equations.N, -1)) / size * (1.0 + np.abs(before.below / size))
        turn = np.abs(after.above - before.below) / size
        most = 1.0 + np.maximum(np.abs(after.above), np.abs(before.below)) / size
        return bool((off > JUMP + 64.0 * EPS * loud + 2.0 * t * most).any() or (turn > TURN * most).any())
