"""How fast nearby orbits part: sums of logarithms of the stretching along an orbit, impacts included.

The frame of d deviations is carried along by the map's derivative, which holds the saltation at every impact, and made
orthonormal again after every step (Benettin, Galgani, Giorgilli and Strelcyn, Meccanica 15 (1980) 9-20). Each
coordinate is measured by the side of the map's box: what is orthonormal, and a mean over finitely many steps, would
else depend on the units of length and time. Where the
derivative is exactly zero, through completed chatter or sticking, everything nearby falls on one orbit: minus
infinity. Where it is undefined, at a graze, so are the sums: not a number.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from math import inf, log, nan, sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grazing.kernel.compile import call, compiled
from grazing.kernel.lanes import BLOCK, column, put, unpacker
from grazing.kernel.primitives import built, inlined
from grazing.maps.map import Map
from grazing.studies.cycles import FOUND, finder, log_radius, room_for

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: The Newton step, relative to the greatest coordinate in units of the box, with which a cycle counts as reached.
SMALL = 1e-12
#: Sides are multiplied up between these.
LEAST, MOST = 1e-200, 1e200


@inlined
def carried(d: int, J: Any, unit: Any, frame: Any, image: Any, j: int) -> None:
    """Write J frame to ``image``, both (d, d, n), for orbit j of n; J is a flat tuple, row by row.

    Frames are in the units (d,) of the coordinates, J is not.
    Where J is zero every orbit nearby falls on this one, and stays: what was, or would be, undefined about its
    neighbours no longer matters.
    """
    fallen, falling = True, True
    for i in range(d):
        for k in range(d):
            fallen, falling = fallen and frame[i, k, j] == 0.0, falling and J[i * d + k] == 0.0
    for i in range(d):
        for k in range(d):
            total = 0.0
            for m in range(d):
                total += J[i * d + m] * (unit[m] / unit[i]) * frame[m, k, j]
            image[i, k, j] = 0.0 if fallen or falling else total


@inlined
def orthonormal(d: int, image: Any, frame: Any, sides: Any, j: int) -> None:
    """Write the orthonormal frame of the columns of ``image``, for orbit j; multiply its sides up in ``sides`` (d, n).

    Modified Gram-Schmidt, each column twice: as good as Householder's way in so few dimensions.
    """
    for n in range(d):
        before = 0.0
        for i in range(d):
            before += image[i, n, j] * image[i, n, j]
        for _twice in range(2):
            for k in range(n):
                overlap = 0.0
                for i in range(d):
                    overlap += frame[i, k, j] * image[i, n, j]
                for i in range(d):
                    image[i, n, j] -= overlap * frame[i, k, j]
        size = 0.0
        for i in range(d):
            size += image[i, n, j] * image[i, n, j]
        # what is left of a column after the overlaps may be rounding: the columns are dependent
        size = nan if not size < inf else (size if size > 1e-30 * before else 0.0)
        length = sqrt(size)
        sides[n, j] *= length
        for i in range(d):
            frame[i, n, j] = image[i, n, j] / length if length > 0.0 else 0.0


@inlined
def logarithm(side: float) -> float:
    """Return log(side), minus infinity for 0."""
    return log(side) if side > 0.0 else (nan if side != side else -inf)


@inlined
def summed(sums: Any, sides: Any, j: int) -> None:
    """Add the logarithms of what was multiplied up for orbit j to ``sums`` (dim, n), and begin again."""
    for i in range(sums.shape[0]):
        sums[i, j] += logarithm(sides[i, j])
        sides[i, j] = 1.0


@inlined
def relieved(sums: Any, sides: Any, width: int) -> None:
    """Add logarithms only where what was multiplied up leaves its range, because they take long."""
    far = 0
    for i in range(sums.shape[0]):
        for j in range(width):
            far += 0 if LEAST < sides[i, j] < MOST else 1
    for i in range(sums.shape[0] if far > 0 else 0):
        for j in range(width):
            if not LEAST < sides[i, j] < MOST:
                sums[i, j] += logarithm(sides[i, j])
                sides[i, j] = 1.0


@lru_cache(maxsize=256)
def stretcher(
    tangent: Callable[..., Any], prepare: Callable[..., Any] | None, kind: type, dimension: int
) -> Callable[..., None]:
    """Compile the sums for one map.

    Returns
    -------
    callable
        ``run(rows, unit, lanes, steps, frames, sums, sides, areas, letters, outcomes, marks, spans)``: lanes (columns,
        dim, n) are advanced by ``steps`` with their frames (columns, n, dim, dim), in units (dim,); logarithms are
        added to sums (columns, n, dim), what is not yet there is multiplied up in sides (columns, n, dim), logarithms
        of determinants are added to areas (columns, n), letters to letters (columns, n), and outcomes (columns, n) are
        folded. Marks (columns, dim, n) are states to which an orbit may come back, to the last bit; spans (columns, n,
        2) the steps since, and after how many the next one is marked, twice as many each time (Brent, BIT 20 (1980)
        176-184): 0 once it has come back.
    """
    unpack, zero = unpacker(kind), (0.0,) * dimension
    constants = prepare if prepare is not None else _same

    def run(
        rows: Any, unit: Any, lanes: Any, steps: int, frames: Any, sums: Any, sides: Any, areas: Any, letters: Any,
        outcomes: Any, marks: Any, spans: Any,
    ) -> None:  # fmt: skip
        square = dimension, dimension, 1
        frame, image = np.empty(square), np.empty(square)
        total, side = np.empty((dimension, 1)), np.empty((dimension, 1))
        for q in range(lanes.shape[0]):
            c = constants(unpack(rows[q]))
            for j in range(lanes.shape[2]):
                for i in range(dimension):
                    total[i, 0], side[i, 0] = sums[q, j, i], sides[q, j, i]
                    for k in range(dimension):
                        frame[i, k, 0] = frames[q, j, i, k]
                for _ in range(steps):
                    state, letter, outcome, J = tangent(column(lanes[q], j, zero), c)
                    put(lanes[q], j, state)
                    letters[q, j] += letter
                    outcomes[q, j] |= outcome
                    areas[q, j] += J[dimension * dimension]
                    carried(dimension, J, unit, frame, image, 0)
                    orthonormal(dimension, image, frame, side, 0)
                    relieved(total, side, 1)
                    back = True
                    for i in range(dimension):
                        back = back and lanes[q, i, j] == marks[q, i, j]
                    spans[q, j, 0] += 1
                    if back:
                        spans[q, j, 1] = 0
                    elif spans[q, j, 0] == spans[q, j, 1]:
                        spans[q, j, 0], spans[q, j, 1] = 0, 2 * spans[q, j, 1]
                        for i in range(dimension):
                            marks[q, i, j] = lanes[q, i, j]
                for i in range(dimension):
                    sums[q, j, i], sides[q, j, i] = total[i, 0], side[i, 0]
                    for k in range(dimension):
                        frames[q, j, i, k] = frame[i, k, 0]

    return compiled(run, "strict")


@lru_cache(maxsize=256)
def reacher(tangent: Callable[..., Any], dimension: int) -> Callable[..., bool]:
    """Return ``reach(points, letters, j, N, c, unit, tolerance, x, M, room)``: go from an orbit near a cycle to it.

    The cycle has N points and the last N of the letters (keep, n) of orbit j, whose last point is that of points
    (keep, dim, n). x (dim, 1) becomes the point that Newton's method reaches, and M (dim, dim) the derivative of a
    turn from there; without one x becomes the last point, and the answer is False. ``unit`` (dim,) measures the
    coordinates, ``tolerance`` (dim, n) and ``room`` are for the search, see :func:`grazing.studies.cycles.finder`.
    """
    find = finder(tangent, dimension)

    def reach(
        points: Any, letters: Any, j: int, N: int, c: Any, unit: Any, tolerance: Any, x: Any, M: Any, room: Any
    ) -> bool:  # fmt: skip
        size, last = SMALL, points.shape[0] - 1
        for i in range(dimension):
            tolerance[i, j] = max(unit[i], abs(points[last, i, j]))
            size = max(size, abs(points[last, i, j]) / tolerance[i, j])
        for i in range(dimension):
            tolerance[i, j] *= SMALL * size
        if find(points, letters, j, N, c, tolerance, x, M, room) == FOUND:
            return True
        for i in range(dimension):
            x[i, 0] = points[last, i, j]
        return False

    return reach


@lru_cache(maxsize=256)
def turner(
    tangent: Callable[..., Any], prepare: Callable[..., Any] | None, kind: type, dimension: int
) -> Callable[..., None]:
    """Compile the derivative of several steps from single points, for one map.

    Returns
    -------
    callable
        ``run(rows, unit, states, seen, steps, turns, logs, letters)``: states[i] (dim,), on or near a cycle of steps[i]
        points at the parameters rows[i], whose latest letters are seen[i] (keep,), is led to the cycle by Newton's
        method where that succeeds; turns[i] (dim, dim) becomes the derivative of one period from there, logs[i] the
        logarithm of its determinant, and letters[i] the sum of the letters.
    """
    unpack, zero, reach = unpacker(kind), (0.0,) * dimension, reacher(tangent, dimension)
    constants = prepare if prepare is not None else _same

    def run(rows: Any, unit: Any, states: Any, seen: Any, steps: Any, turns: Any, logs: Any, letters: Any) -> None:
        square, plain = (dimension, dimension, 1), np.ones(dimension)
        x, tolerance = np.empty((dimension, 1)), np.empty((dimension, 1))
        sums, sides = np.empty((dimension, 1)), np.ones((dimension, 1))
        M, frame, image = np.empty(square), np.empty(square), np.empty(square)
        keep = seen.shape[1]
        turn, room = np.empty((dimension, dimension)), room_for(keep, dimension)
        for n in range(states.shape[0]):
            c = constants(unpack(rows[n]))
            letters[n], area = 0, 0.0
            near, latest = states[n].copy().reshape((1, dimension, 1)), seen[n].copy().reshape((keep, 1))
            reach(near, latest, 0, steps[n], c, unit, tolerance, x, turn, room)
            for i in range(dimension):
                states[n, i], sums[i, 0] = x[i, 0], 0.0
                for j in range(dimension):
                    M[i, j, 0] = frame[i, j, 0] = 1.0 if i == j else 0.0
            for _ in range(steps[n]):
                state, letter, _outcome, J = tangent(column(x, 0, zero), c)
                put(x, 0, state)
                letters[n] += letter
                area += J[dimension * dimension]
                carried(dimension, J, plain, M, image, 0)
                for i in range(dimension):
                    for j in range(dimension):
                        M[i, j, 0] = image[i, j, 0]
                carried(dimension, J, unit, frame, image, 0)
                orthonormal(dimension, image, frame, sides, 0)
                relieved(sums, sides, 1)
            summed(sums, sides, 0)
            logs[n] = area
            for i in range(dimension):
                logs[n] += sums[i, 0] if area != area else 0.0
                for j in range(dimension):
                    turns[n, i, j] = M[i, j, 0]

    return compiled(run, "strict")


def sides_of(P: Map) -> Floats:
    """Return the side of a map's box along each coordinate: its own unit."""
    return np.array([high - low for low, high in P.box])


def turned(P: Map, rows: Floats, states: Floats, seen: Ints, periods: Ints) -> tuple[Floats, Floats, Floats, Ints]:
    """Return points on the cycles of orbits, with the derivatives of one period from there, see :func:`turner`."""
    n, d = states.shape
    turns, logs, letters = np.empty((n, d, d)), np.empty(n), np.empty(n, np.int64)
    points, latest = np.array(states, order="C"), np.ascontiguousarray(seen)
    derived, who = P.derivative(rows), f"the step of {P.name}"
    entry = turner(derived.tangent, derived.prepare, derived.kind, d)
    call(entry, derived.rows, sides_of(P), points, latest, periods, turns, logs, letters, who=who)
    return points, turns, logs, letters


def on_cycles(P: Map, rows: Floats, states: Floats, seen: Ints) -> Floats:
    """Return the points of cycles that Newton's method reaches from states; a state itself where it reaches none.

    Parameters
    ----------
    P : Map
    rows : ndarray, shape (n, parameters)
    states : ndarray, shape (n, dim)
    seen : ndarray of int, shape (n, N)
        Letters of the N steps of a period from each state.
    """
    return turned(P, rows, states, seen, np.full(len(states), seen.shape[1], np.int64))[0]


@lru_cache(maxsize=256)
def grower(
    tangent: Callable[..., Any], prepare: Callable[..., Any] | None, kind: type, dimension: int
) -> Callable[..., None]:
    """Compile the largest exponent of orbits from their last points, for one map.

    Returns
    -------
    callable
        ``run(rows, unit, points, letters, which, period, steps, exponents)``: for each (column, rank, start) in
        ``which`` (n, 3), exponents[column, rank] becomes the largest exponent per step of that orbit: with
        period[column, rank] above 0 that of the multipliers, on the cycle if it can be reached, else that of ``steps``
        further steps. Points and letters are those of :class:`grazing.maps.columns.Columns`, rows (columns,
        parameters), units (dim,).
    """
    unpack, zero, reach = unpacker(kind), (0.0,) * dimension, reacher(tangent, dimension)
    constants, packed = (prepare, False) if prepare is not None else (_same, True)
    fields = len(kind._fields)  # type: ignore[attr-defined]
    blank = (0.0,) * fields

    def own(c: Any, x: Any, j: int) -> Any:
        return built(kind, column(x, j, blank, dimension))

    at_lane = own if packed else _shared
    together = BLOCK if packed else 1

    def run(
        rows: Any, unit: Any, points: Any, letters: Any, which: Any, period: Any, steps: int, exponents: Any
    ) -> None:  # fmt: skip
        keep, square, plain = points.shape[1], (dimension, dimension, BLOCK), np.ones(dimension)
        x, tolerance = np.empty((dimension + fields, BLOCK)), np.empty((dimension, points.shape[3]))
        frame, image = np.empty(square), np.empty(square)
        sums, sides = np.empty((dimension, BLOCK)), np.empty((dimension, BLOCK))
        z, M, room = np.empty((dimension, 1)), np.empty((dimension, dimension)), room_for(keep, dimension)
        free, many = np.empty(which.shape[0], np.int64), 0
        for n in range(which.shape[0]):
            q, rank, j = which[n, 0], which[n, 1], which[n, 2]
            N = period[q, rank]
            if N < 1:
                free[many] = n
                many += 1
                continue
            c = constants(unpack(rows[q]))
            if not reach(points[q], letters[q], j, N, c, unit, tolerance, z, M, room):
                for i in range(dimension):
                    for k in range(dimension):
                        frame[i, k, 0] = 1.0 if i == k else 0.0
                for _ in range(N):
                    state, _letter, _outcome, J = tangent(column(z, 0, zero), c)
                    put(z, 0, state)
                    carried(dimension, J, plain, frame, image, 0)
                    for i in range(dimension):
                        for k in range(dimension):
                            M[i, k] = frame[i, k, 0] = image[i, k, 0]
            growth = log_radius(M) / N
            exponents[q, rank] = growth if growth < inf else nan
        for top in range(0, many, together):  # side by side where a step is a formula, as in grazing.kernel.lanes
            width = min(together, many - top)
            c = constants(unpack(rows[which[free[top], 0]]))
            for j in range(width):
                q, lane = which[free[top + j], 0], which[free[top + j], 2]
                for k in range(fields if packed else 0):
                    x[dimension + k, j] = rows[q, k]
                for i in range(dimension):
                    x[i, j], sums[i, j], sides[i, j] = points[q, keep - 1, i, lane], 0.0, 1.0
                    for k in range(dimension):
                        frame[i, k, j] = 1.0 if i == k else 0.0
            for _ in range(steps):
                for j in range(width):
                    state, _letter, _outcome, J = tangent(column(x, j, zero), at_lane(c, x, j))
                    put(x, j, state)
                    carried(dimension, J, unit, frame, image, j)
                    orthonormal(dimension, image, frame, sides, j)
                relieved(sums, sides, width)
            for j in range(width):
                summed(sums, sides, j)
                growth = sums[0, j] / max(steps, 1)
                exponents[which[free[top + j], 0], which[free[top + j], 1]] = growth if growth < inf else nan

    return compiled(run, "strict")


def _shared(c: Any, _x: Any, _j: int) -> Any:
    return c


def _same(p: Any) -> Any:
    return p
