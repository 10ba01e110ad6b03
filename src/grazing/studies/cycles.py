"""Cycles beside an orbit that has not settled: Newton's method, multipliers, and whether the orbit approaches.

An orbit approaches a cycle if its distance falls in the norm in which the linearised map contracts every turn:
``|x|^2 = sum_k |A^k x|^2`` with A the derivative of one turn divided by (1 + its spectral radius)/2.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from math import exp, inf, log, nan, sqrt
from typing import Any

import numpy as np

from grazing.kernel.compile import compiled
from grazing.kernel.lanes import column, put, unpacker
from grazing.studies.recurrence import UNDECIDED, measured, same_letters, settling, to_be_tried

#: Newton steps after which a cycle counts as not found.
STEPS = 12
#: Share of the linear rate of contraction that an approaching orbit must show at least.
RATE = 0.1
#: Squarings of a matrix: 2^40 turns leave its spectral radius to rounding.
SQUARINGS = 40
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


def solved(a: Any, b: Any) -> bool:
    """Solve a x = b by elimination with pivots; x replaces b, and a is destroyed. False for a singular matrix."""
    d = a.shape[0]
    for k in range(d):
        pivot = k
        for i in range(k + 1, d):
            if abs(a[i, k]) > abs(a[pivot, k]):
                pivot = i
        if not abs(a[pivot, k]) > 0.0:
            return False
        for j in range(d):
            a[k, j], a[pivot, j] = a[pivot, j], a[k, j]
        b[k], b[pivot] = b[pivot], b[k]
        for i in range(k + 1, d):
            factor = a[i, k] / a[k, k]
            for j in range(k, d):
                a[i, j] -= factor * a[k, j]
            b[i] -= factor * b[k]
    for k in range(d - 1, -1, -1):
        for j in range(k + 1, d):
            b[k] -= a[k, j] * b[j]
        b[k] /= a[k, k]
    return True


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


def falling(x: Any, j: int, N: int, z: Any, M: Any, tolerance: Any) -> bool:
    """Say whether orbit j approaches the cycle through z (dim, 1) with derivative M.

    Its distance, in the norm above, falls in every two turns (near -1 a quadratic term makes one of the two sides
    larger), and over all at no less than a tenth of the linear rate; within the tolerance it counts as arrived.
    """
    keep, d, _n = x.shape
    radius = exp(log_radius(M))
    if not radius < 1.0:
        return False
    Q = np.empty((d, d))
    contracting_norm(M, 0.5 * (1.0 + radius), Q)
    trace, worst = 0.0, 0.0
    for i in range(d):
        trace, worst = trace + Q[i, i], max(worst, tolerance[i, j])
    floor = sqrt(trace) * worst
    turns = (keep - 1) // N
    distance = np.empty(turns + 1)
    for t in range(turns + 1):
        total = 0.0
        k = keep - 1 - t * N
        for i in range(d):
            for m in range(d):
                total += (x[k, i, j] - z[i, 0]) * Q[i, m] * (x[k, m, j] - z[m, 0])
        distance[t] = sqrt(max(total, 0.0))
        if t >= 2 and not (distance[t - 2] < distance[t] or distance[t - 2] <= floor):
            return False
    turns = turns // 2 * 2
    return bool(distance[0] <= max(distance[turns] * (1.0 - RATE * (1.0 - radius)) ** turns, floor))


@lru_cache(maxsize=256)
def finder(tangent: Callable[..., Any], dimension: int) -> Callable[..., int]:
    """Return ``find(x, s, j, N, c, tolerance, z, M) -> NONE, FOUND or NO_TANGENT``.

    Newton's method from the last of the points x (keep, dim, n) of orbit j, for a cycle of N points with the last N of
    the letters s (keep, n). Writes the cycle's point to z (dim, 1) and the derivative of N steps from there to M.
    """
    zero = (0.0,) * dimension

    def turn(z: Any, N: int, c: Any, end: Any, M: Any, seen: Any, points: Any) -> bool:
        """Go N steps from z: the last point, the derivative and the letters; False if something is not finite."""
        B = np.empty((dimension, dimension))
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

    def find(x: Any, s: Any, j: int, N: int, c: Any, tolerance: Any, z: Any, M: Any) -> int:
        end, A, move = np.empty((dimension, 1)), np.empty((dimension, dimension)), np.empty(dimension)
        seen, points = np.empty(N, np.int64), np.empty((N, dimension))
        for i in range(dimension):
            z[i, 0] = x[x.shape[0] - 1, i, j]
        for step in range(STEPS):
            if not turn(z, N, c, end, M, seen, points):
                return NO_TANGENT if step == 0 else NONE
            for i in range(dimension):
                move[i] = end[i, 0] - z[i, 0]
                for m in range(dimension):
                    A[i, m] = (1.0 if i == m else 0.0) - M[i, m]
            if not solved(A, move):
                return NONE
            small = True
            for i in range(dimension):
                z[i, 0] += move[i]
                small = small and abs(move[i]) <= tolerance[i, j]
            if small:
                break
            if step == STEPS - 1:
                return NONE
        if not turn(z, N, c, end, M, seen, points):
            return NONE
        for n in range(N):
            if seen[n] != s[s.shape[0] - N + n, j]:
                return NONE
        for n in range(1, N):  # a shorter cycle passed N/n times is no cycle of N points
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
    """Compile the second part of the classification for one map.

    Returns
    -------
    callable
        ``run(rows, points, letters, rtol, which, period)``: for each (column, start, row) in ``which`` (n, 3) a cycle
        with fewer points than the period by recurrence is sought, and the period replaced where the orbit approaches.
    """
    unpack, find = unpacker(kind), finder(tangent, dimension)
    constants = prepare if prepare is not None else _same

    def run(rows: Any, points: Any, letters: Any, rtol: float, which: Any, period: Any) -> None:
        keep, n = points.shape[1], points.shape[3]
        extent, tolerance, finite = np.empty((dimension, n)), np.empty((dimension, n)), np.empty(n, np.int64)
        z, M = np.empty((dimension, 1)), np.empty((dimension, dimension))
        before = -1
        for k in range(which.shape[0]):
            q, j = which[k, 0], which[k, 1]
            x, s = points[q], letters[q]
            if q != before:
                measured(x, rtol, extent, tolerance, finite)
            before = q
            c = constants(unpack(rows[which[k, 2]]))
            candidate = max(period[q, j], 0)
            for N in range(1, keep // 3 + 1):
                if to_be_tried(candidate, N, keep) and same_letters(s, j, N) and settling(x, j, extent, tolerance, N):
                    found = find(x, s, j, N, c, tolerance, z, M)
                    if found == NO_TANGENT:
                        period[q, j] = max(period[q, j], UNDECIDED)
                    elif found == FOUND and falling(x, j, N, z, M, tolerance):
                        period[q, j] = N
                        break

    return compiled(run, "strict")


def _same(p: Any) -> Any:
    return p
