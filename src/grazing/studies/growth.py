"""How fast nearby orbits part: sums of logarithms of the stretching along an orbit, impacts included.

The frame of d deviations is carried along by the map's derivative, which holds the saltation at every impact, and made
orthonormal again after every step (Benettin, Galgani, Giorgilli and Strelcyn, Meccanica 15 (1980) 9-20). Where the
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
from grazing.kernel.lanes import column, put, unpacker
from grazing.kernel.primitives import inlined
from grazing.maps.map import Map
from grazing.studies.cycles import FOUND, finder, log_radius

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: The Newton step, relative to the greatest coordinate, with which a cycle counts as reached.
SMALL = 1e-12
#: Sides are multiplied up between these.
LEAST, MOST = 1e-200, 1e200


@inlined
def carried(J: Any, frame: Any, image: Any) -> None:
    """Write J frame to ``image``; J is a flat tuple, row by row.

    Where J is zero every orbit nearby falls on this one, and stays: what was, or would be, undefined about its
    neighbours no longer matters.
    """
    d = frame.shape[0]
    fallen, falling = True, True
    for i in range(d):
        for j in range(d):
            fallen, falling = fallen and frame[i, j] == 0.0, falling and J[i * d + j] == 0.0
    for i in range(d):
        for j in range(d):
            total = 0.0
            for k in range(d):
                total += J[i * d + k] * frame[k, j]
            image[i, j] = 0.0 if fallen or falling else total


@inlined
def orthonormal(image: Any, frame: Any, sums: Any, sides: Any) -> None:
    """Write the orthonormal frame of the columns of ``image``; add the logarithms of its sides to ``sums``.

    Sides are multiplied up in ``sides`` first, because logarithms take long; :func:`summed` adds what is left there.
    Modified Gram-Schmidt, each column twice: as good as Householder's way in so few dimensions.
    """
    d = frame.shape[0]
    for j in range(d):
        before = 0.0
        for i in range(d):
            before += image[i, j] * image[i, j]
        for _twice in range(2):
            for k in range(j):
                overlap = 0.0
                for i in range(d):
                    overlap += frame[i, k] * image[i, j]
                for i in range(d):
                    image[i, j] -= overlap * frame[i, k]
        size = 0.0
        for i in range(d):
            size += image[i, j] * image[i, j]
        if not size < inf:
            size = nan
        elif not size > 1e-30 * before:  # what is left after the overlaps is rounding: the columns are dependent
            size = 0.0
        length = sqrt(size)
        sides[j] *= length
        if not LEAST < sides[j] < MOST:
            sums[j] += log(sides[j]) if sides[j] > 0.0 else (nan if sides[j] != sides[j] else -inf)
            sides[j] = 1.0
        for i in range(d):
            frame[i, j] = image[i, j] / length if length > 0.0 else 0.0


@inlined
def summed(sums: Any, sides: Any) -> None:
    """Add the logarithms of what was multiplied up, and begin again."""
    for j in range(sums.shape[0]):
        sums[j] += log(sides[j])
        sides[j] = 1.0


@lru_cache(maxsize=256)
def stretcher(
    tangent: Callable[..., Any], prepare: Callable[..., Any] | None, kind: type, dimension: int
) -> Callable[..., None]:
    """Compile the sums for one map.

    Returns
    -------
    callable
        ``run(rows, lanes, steps, frames, sums, sides, areas, letters, outcomes)``: lanes (columns, dim, n) are advanced
        by ``steps`` with their frames (columns, n, dim, dim); logarithms are added to sums (columns, n, dim), what is
        not yet there is multiplied up in sides (columns, n, dim), logarithms of determinants are added to areas
        (columns, n), letters to letters (columns, n), and outcomes (columns, n) are folded.
    """
    unpack, zero = unpacker(kind), (0.0,) * dimension
    constants = prepare if prepare is not None else _same

    def run(
        rows: Any, lanes: Any, steps: int, frames: Any, sums: Any, sides: Any, areas: Any, letters: Any, outcomes: Any
    ) -> None:
        image = np.empty((dimension, dimension))
        for q in range(lanes.shape[0]):
            c = constants(unpack(rows[q]))
            for j in range(lanes.shape[2]):
                for _ in range(steps):
                    state, letter, outcome, J = tangent(column(lanes[q], j, zero), c)
                    put(lanes[q], j, state)
                    letters[q, j] += letter
                    outcomes[q, j] |= outcome
                    areas[q, j] += J[dimension * dimension]
                    carried(J, frames[q, j], image)
                    orthonormal(image, frames[q, j], sums[q, j], sides[q, j])

    return compiled(run, "strict")


@lru_cache(maxsize=256)
def reacher(tangent: Callable[..., Any], dimension: int) -> Callable[..., None]:
    """Return ``reach(state, seen, N, c, x, M)``: go from a state (dim,) near a cycle of N points to the cycle.

    ``seen`` (keep,) are the latest letters there. x (dim, 1) becomes the point that Newton's method reaches, or the
    state itself where it reaches none; M is room for a matrix.
    """
    find = finder(tangent, dimension)

    def reach(state: Any, seen: Any, N: int, c: Any, x: Any, M: Any) -> None:
        point, tolerance = np.empty((1, dimension, 1)), np.empty((dimension, 1))
        last = np.empty((seen.shape[0], 1), np.int64)
        for k in range(seen.shape[0]):
            last[k, 0] = seen[k]
        size = SMALL
        for i in range(dimension):
            point[0, i, 0] = state[i]
            size = max(size, abs(state[i]))
        for i in range(dimension):
            tolerance[i, 0] = SMALL * size
        if find(point, last, 0, N, c, tolerance, x, M) != FOUND:
            for i in range(dimension):
                x[i, 0] = state[i]

    return reach


@lru_cache(maxsize=256)
def turner(
    tangent: Callable[..., Any], prepare: Callable[..., Any] | None, kind: type, dimension: int
) -> Callable[..., None]:
    """Compile the derivative of several steps from single points, for one map.

    Returns
    -------
    callable
        ``run(rows, states, seen, steps, turns, logs, letters)``: states[i] (dim,), on or near a cycle of steps[i]
        points at the parameters rows[i], whose latest letters are seen[i] (keep,), is led to the cycle by Newton's
        method where that succeeds; turns[i] (dim, dim) becomes the derivative of one period from there, logs[i] the
        logarithm of its determinant, and letters[i] the sum of the letters.
    """
    unpack, zero, reach = unpacker(kind), (0.0,) * dimension, reacher(tangent, dimension)
    constants = prepare if prepare is not None else _same

    def run(rows: Any, states: Any, seen: Any, steps: Any, turns: Any, logs: Any, letters: Any) -> None:
        x, sums, sides = np.empty((dimension, 1)), np.empty(dimension), np.ones(dimension)
        M, frame, image = (
            np.empty((dimension, dimension)),
            np.empty((dimension, dimension)),
            np.empty((dimension, dimension)),
        )
        for n in range(states.shape[0]):
            c = constants(unpack(rows[n]))
            letters[n], area = 0, 0.0
            reach(states[n], seen[n], steps[n], c, x, M)
            for i in range(dimension):
                states[n, i] = x[i, 0]
            for i in range(dimension):
                x[i, 0], sums[i] = states[n, i], 0.0
                for j in range(dimension):
                    M[i, j] = frame[i, j] = 1.0 if i == j else 0.0
            for _ in range(steps[n]):
                state, letter, _outcome, J = tangent(column(x, 0, zero), c)
                put(x, 0, state)
                letters[n] += letter
                area += J[dimension * dimension]
                carried(J, M, image)
                for i in range(dimension):
                    for j in range(dimension):
                        M[i, j] = image[i, j]
                carried(J, frame, image)
                orthonormal(image, frame, sums, sides)
            summed(sums, sides)
            logs[n] = area
            for i in range(dimension):
                logs[n] += sums[i] if area != area else 0.0
                for j in range(dimension):
                    turns[n, i, j] = M[i, j]

    return compiled(run, "strict")


def turned(P: Map, rows: Floats, states: Floats, seen: Ints, periods: Ints) -> tuple[Floats, Floats, Floats, Ints]:
    """Return points on the cycles of orbits, with the derivatives of one period from there, see :func:`turner`."""
    n, d = states.shape
    turns, logs, letters = np.empty((n, d, d)), np.empty(n), np.empty(n, np.int64)
    points, latest = np.array(states, order="C"), np.ascontiguousarray(seen)
    derived, who = P.derivative(rows), f"the step of {P.name}"
    entry = turner(derived.tangent, derived.prepare, derived.kind, d)
    call(entry, derived.rows, points, latest, periods, turns, logs, letters, who=who)
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
    """Compile the largest exponent from single points, for one map.

    Returns
    -------
    callable
        ``run(rows, states, seen, steps, cyclic, exponents)``: from states[i] at the parameters rows[i], exponents[i]
        becomes the largest exponent per step of steps[i] steps; where cyclic[i], these are a whole period, and the
        exponent is that of its multipliers, on the cycle if it can be reached; seen[i] (keep,) are the latest letters.
    """
    unpack, zero, reach = unpacker(kind), (0.0,) * dimension, reacher(tangent, dimension)
    constants = prepare if prepare is not None else _same

    def run(rows: Any, states: Any, seen: Any, steps: Any, cyclic: Any, exponents: Any) -> None:
        x, sums, sides = np.empty((dimension, 1)), np.empty(dimension), np.ones(dimension)
        frame, image = np.empty((dimension, dimension)), np.empty((dimension, dimension))
        for n in range(states.shape[0]):
            c = constants(unpack(rows[n]))
            for i in range(dimension):
                x[i, 0] = states[n, i]
            if cyclic[n]:
                reach(states[n], seen[n], steps[n], c, x, image)
            for i in range(dimension):
                sums[i] = 0.0
                for j in range(dimension):
                    frame[i, j] = 1.0 if i == j else 0.0
            for _ in range(steps[n]):
                state, _letter, _outcome, J = tangent(column(x, 0, zero), c)
                put(x, 0, state)
                carried(J, frame, image)
                if cyclic[n]:
                    for i in range(dimension):
                        for j in range(dimension):
                            frame[i, j] = image[i, j]
                else:
                    orthonormal(image, frame, sums, sides)
            summed(sums, sides)
            exponents[n] = (log_radius(frame) if cyclic[n] else sums[0]) / max(steps[n], 1)
            if not exponents[n] < inf:
                exponents[n] = nan

    return compiled(run, "strict")


def _same(p: Any) -> Any:
    return p
