"""Cycles beside an orbit that has not settled: Newton's method, multipliers, and whether the orbit approaches.

An orbit approaches a cycle if its distance falls in the norm in which the linearised map contracts every turn:
``|x|^2 = sum_k |A^k x|^2`` with A the derivative of one turn divided by (1 + its spectral radius)/2.

Where some multipliers are 1 and all others lie inside the unit circle, as of a ball without a spring that touches no
wall, cycles may be a continuum. With R = lim M^n, the projector onto what M keeps, I - M + R is regular, and Newton's
method with it goes along the other directions alone: to the cycle that the orbit itself approaches. It does so at the
rate of M - R.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from math import exp, inf, log, nan, sqrt
from typing import Any

import numpy as np

from grazing.kernel.compile import compiled
from grazing.kernel.lanes import column, put, unpacker
from grazing.maps.linear import solved
from grazing.studies.recurrence import UNDECIDED, next_cycle

#: Newton steps after which a cycle counts as not found.
STEPS = 12
#: A search ends after cycles of so many times the kept points in all, as it may beside a multiplier of 1: with up to a
#: thousand kept points none is that long.
BUDGET = 20
#: A cycle contracts if its multipliers are this far inside the unit circle: they are known to ten digits at best, and
#: nearer to 1 than that what drifts by equal steps for ever "approaches" a cycle beyond all numbers.
INSIDE = 1e-9
#: Share of the linear rate of contraction that an approaching orbit must show at least.
RATE = 0.1
#: Squarings of a matrix: 2^40 turns leave its spectral radius to rounding.
SQUARINGS = 40
#: A power of a matrix is a projector if its square differs from it by no more than this share; beyond this size it
#: grows for ever.
SAME, ENDLESS = 1e-9, 1e100
# What a search ends with.
NONE, FOUND, NO_TANGENT = 0, 1, 2


def multiplied(a: Any, b: Any, out: Any) -> None:
    """Write the product a b of two matrices to ``out``."""
    d = a.shape[0]
    for i in range(d):
        for j in range(d):
            total = 0.0
            for k in range(d):
                total += a[i, k] * b[k, j]
            out[i, j] = total


def log_radius(M: Any) -> float:
    """Return the logarithm of a matrix's spectral radius, -inf for a nilpotent one: |M^n|^(1/n) for n = 2^40."""
    d = M.shape[0]
    for i in range(d):
        for j in range(d):
            if not abs(M[i, j]) < inf:
                return nan
    if d == 1:
        return log(abs(M[0, 0])) if M[0, 0] != 0.0 else -inf
    a, b = M.copy(), np.empty((d, d))
    total, turns = 0.0, 1.0
    for _ in range(SQUARINGS):
        size = 0.0
        for i in range(d):
            for j in range(d):
                size = max(size, abs(a[i, j]))
        if not size > 0.0:
            return -inf
        total += log(size) / turns
        for i in range(d):
            for j in range(d):
                a[i, j] /= size
        multiplied(a, a, b)
        a, b = b, a
        turns *= 2.0
    return total


def contracting_norm(M: Any, rate: float, Q: Any) -> None:
    """Write to Q the form sum_k (A^k)^T A^k, A = M/rate, by doubling: Q + A^T Q A for twice as many turns."""
    d = M.shape[0]
    A, B, C = M / rate, np.empty((d, d)), np.empty((d, d))
    for i in range(d):
        for j in range(d):
            Q[i, j] = 1.0 if i == j else 0.0
    for _ in range(SQUARINGS):
        multiplied(Q, A, B)
        change = 0.0
        for i in range(d):
            for j in range(d):
                total = 0.0
                for k in range(d):
                    total += A[k, i] * B[k, j]
                C[i, j] = total
                change = max(change, abs(total))
        for i in range(d):
            for j in range(d):
                Q[i, j] += C[i, j]
        if change <= 1e-17:
            return
        multiplied(A, A, B)
        A, B = B, A


def equal_after(A: Any, B: Any, out: Any) -> bool:
    """Write A B to ``out``; say whether it is B, to a share of the sums of its terms, which no unit changes."""
    d, equal = A.shape[0], True
    for i in range(d):
        for j in range(d):
            total, size = 0.0, 0.0
            for k in range(d):
                total += A[i, k] * B[k, j]
                size += abs(A[i, k] * B[k, j])
            out[i, j] = total
            equal = equal and abs(total - B[i, j]) <= SAME * size
    return equal


def keeps(M: Any, R: Any) -> bool:
    """Write to R the limit of the powers of M, by squaring; say whether there is one, and whether it is not 0."""
    d = M.shape[0]
    square = np.empty((d, d))
    for i in range(d):
        for j in range(d):
            R[i, j] = M[i, j]
    for _ in range(SQUARINGS):
        settled, trace, bounded = equal_after(R, R, square), 0.0, True
        for i in range(d):
            trace += R[i, i]
            for j in range(d):
                R[i, j] = square[i, j]
                bounded = bounded and abs(square[i, j]) < ENDLESS
        if not bounded:
            return False
        if settled:
            return trace > 0.5 and equal_after(M, R, square)  # a multiplier -1 is none that M keeps
    return False


def falling(x: Any, j: int, N: int, z: Any, M: Any, tolerance: Any) -> bool:
    """Say whether orbit j approaches the cycle through z (dim, 1) with derivative M, of a continuum the one it does.

    Its distance, in the norm above with coordinates in units of the tolerance, falls in every two turns (near -1 a
    quadratic term makes one of the two sides larger), and over all at no less than a tenth of the linear rate; within
    the tolerance it counts as arrived. Of one point that is rounding alone: so much in each turn holds it farther off.
    """
    keep, d, _n = x.shape
    away, Q = M.copy(), np.empty((d, d))
    radius = exp(log_radius(away))
    if not radius < 1.0 - INSIDE and keeps(M, Q):
        for i in range(d):
            for k in range(d):
                away[i, k] -= Q[i, k]
        radius = exp(log_radius(away))
    if not radius < 1.0 - INSIDE:
        return False
    A = np.empty((d, d))
    for i in range(d):
        for m in range(d):
            A[i, m] = away[i, m] * (tolerance[m, j] / tolerance[i, j])
    rate, trace = 0.5 * (1.0 + radius), 0.0
    contracting_norm(A, rate, Q)
    for i in range(d):
        trace += Q[i, i]
    floor = sqrt(trace) / (1.0 - rate if N == 1 else 1.0)
    turns = (keep - 1) // N
    distance = np.empty(turns + 1)
    for t in range(turns + 1):
        total = 0.0
        k = keep - 1 - t * N
        for i in range(d):
            for m in range(d):
                one, other = (x[k, i, j] - z[i, 0]) / tolerance[i, j], (x[k, m, j] - z[m, 0]) / tolerance[m, j]
                total += one * Q[i, m] * other
        distance[t] = sqrt(max(total, 0.0))
        if t >= 2 and not (distance[t - 2] < distance[t] or distance[t - 2] <= floor):
            return False
    turns = turns // 2 * 2
    return bool(distance[0] <= max(distance[turns] * (1.0 - RATE * (1.0 - radius)) ** turns, floor))


def room_for(most: int, dimension: int) -> Any:
    """Return arrays to search cycles of up to so many points in: taken once, because taking memory takes long."""
    square = dimension, dimension
    end, move, seen = np.empty((dimension, 1)), np.empty(dimension), np.empty(most, np.int64)
    return end, move, np.empty(square), np.empty(square), seen, np.empty((most, dimension))


@lru_cache(maxsize=256)
def finder(tangent: Callable[..., Any], dimension: int) -> Callable[..., int]:
    """Return ``find(x, s, j, N, c, tolerance, z, M, room) -> NONE, FOUND or NO_TANGENT``.

    Newton's method from the last of the points x (keep, dim, n) of orbit j, for a cycle of N points with the last N of
    the letters s (keep, n). Writes the cycle's point to z (dim, 1) and the derivative of N steps from there to M;
    ``room`` is what :func:`room_for` returns.
    """
    zero = (0.0,) * dimension

    def turn(z: Any, N: int, c: Any, M: Any, room: Any) -> bool:
        """Go N steps from z: the last point, the derivative and the letters; False if something is not finite."""
        end, _move, _A, B, seen, points = room
        for i in range(dimension):
            end[i, 0] = z[i, 0]
            for j in range(dimension):
                M[i, j] = 1.0 if i == j else 0.0
        for n in range(N):
            state, letter, _outcome, J = tangent(column(end, 0, zero), c)
            seen[n] = letter
            put(end, 0, state)
            for i in range(dimension):
                points[n, i] = end[i, 0]
                for j in range(dimension):
                    total = 0.0
                    for k in range(dimension):
                        total += J[i * dimension + k] * M[k, j]
                    B[i, j] = total
            for i in range(dimension):
                for j in range(dimension):
                    M[i, j] = B[i, j]
        for i in range(dimension):
            if not abs(end[i, 0]) < inf:
                return False
            for j in range(dimension):
                if not abs(M[i, j]) < inf:
                    return False
        return True

    def find(x: Any, s: Any, j: int, N: int, c: Any, tolerance: Any, z: Any, M: Any, room: Any) -> int:
        end, move, A, B, seen, points = room
        for i in range(dimension):
            z[i, 0] = x[x.shape[0] - 1, i, j]
        moved = True
        for step in range(STEPS):
            if not turn(z, N, c, M, room):
                return NO_TANGENT if step == 0 else NONE
            kept = keeps(M, B)
            for i in range(dimension):
                move[i] = end[i, 0] - z[i, 0]
                for m in range(dimension):
                    A[i, m] = (1.0 if i == m else 0.0) - M[i, m] + (B[i, m] if kept else 0.0)
            if not solved(A, move, tolerance[:, j]):
                return NONE
            small, moved = True, False
            for i in range(dimension):
                moved = moved or z[i, 0] + move[i] != z[i, 0]
                z[i, 0] += move[i]
                small = small and abs(move[i]) <= tolerance[i, j]
            if small:
                break
            if step == STEPS - 1:
                return NONE
        if moved and not turn(z, N, c, M, room):
            return NONE
        for n in range(N):
            if seen[n] != s[s.shape[0] - N + n, j]:
                return NONE
        for n in range(1, N // 2 + 1):  # a shorter cycle passed N/n times is no cycle of N points
            if N % n == 0:
                same = True
                for i in range(dimension):
                    same = same and abs(points[n - 1, i] - z[i, 0]) <= tolerance[i, j]
                if same:
                    return NONE
        return FOUND

    return find


@lru_cache(maxsize=256)
def settler(
    tangent: Callable[..., Any], prepare: Callable[..., Any] | None, kind: type, dimension: int
) -> Callable[..., None]:
    """Compile the second part of the classification for one map, see :func:`settling`."""
    return compiled(settling(tangent, prepare, kind, dimension), "strict")


@lru_cache(maxsize=256)
def settling(
    tangent: Callable[..., Any], prepare: Callable[..., Any] | None, kind: type, dimension: int
) -> Callable[..., None]:
    """Return the second part of the classification for one map.

    Returns
    -------
    callable
        ``run(rows, points, letters, extents, tolerances, which, period)``: for each (column, start, row, N) in
        ``which`` (n, 4) a cycle of N points or more, yet fewer than the period by recurrence, is sought, and the period
        replaced where the orbit approaches it, or undecided where the search takes too long. The other arguments are
        those of :func:`grazing.studies.recurrence.recurrence`.
    """
    unpack, find = unpacker(kind), finder(tangent, dimension)
    constants = prepare if prepare is not None else _same

    def run(rows: Any, points: Any, letters: Any, extents: Any, tolerances: Any, which: Any, period: Any) -> None:
        keep = points.shape[1]
        x, s = np.empty((keep, dimension, 1)), np.empty((keep, 1), np.int64)
        extent, tolerance = np.empty((dimension, 1)), np.empty((dimension, 1))
        z, M, room = np.empty((dimension, 1)), np.empty((dimension, dimension)), room_for(keep, dimension)
        for k in range(which.shape[0]):
            q, j, N = which[k, 0], which[k, 1], which[k, 3]
            for i in range(dimension):
                extent[i, 0], tolerance[i, 0] = extents[q, i, j], tolerances[q, i, j]
            for n in range(keep):
                s[n, 0] = letters[q, n, j]
                for i in range(dimension):
                    x[n, i, 0] = points[q, n, i, j]
            c = constants(unpack(rows[which[k, 2]]))
            candidate, tried = max(period[q, j], 0), 0
            while N > 0:
                tried += N
                if tried > BUDGET * keep:
                    period[q, j] = max(period[q, j], UNDECIDED)
                    break
                found = find(x, s, 0, N, c, tolerance, z, M, room)
                if found == NO_TANGENT:
                    period[q, j] = max(period[q, j], UNDECIDED)
                elif found == FOUND and falling(x, 0, N, z, M, tolerance):
                    period[q, j] = N
                    break
                N = next_cycle(x, s, 0, extent, tolerance, candidate, 0, N + 1)

    return run


def _same(p: Any) -> Any:
    return p
