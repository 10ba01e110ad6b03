"""After how many steps an orbit recurs, and what its letters are: the part of the classification that most need.

Written for all orbits of many columns at once, for points in any number of dimensions, and independent of the map.
"""

from __future__ import annotations

from functools import lru_cache
from math import inf
from typing import Any

import numpy as np

from grazing.kernel.compile import compiled
from grazing.kernel.primitives import inlined
from grazing.outcome import FATAL

UNDECIDED, APERIODIC, ENDED = 0, -1, -2

#: The absolute part of the tolerance, in units of the orbit's greatest coordinate.
FLOOR = 1e-13
#: An orbit nearly recurs within this share of its extent; others are not worth a search for a cycle.
NEAR = 0.1
#: Distances after N steps must fall by more than rounding.
BETTER = 1.0 - 1e-10
# Two primes just below 2^31 with bases: a word is known by its two hashes, which products of 62 bits can hold.
P1, B1, P2, B2 = 2147483647, 1000003, 2147483629, 998244353


def measured(x: Any, rtol: float, extent: Any, tolerance: Any, finite: Any) -> None:
    """Fill in, for all orbits of a column, the extent and the tolerance along each coordinate (dim, n).

    Parameters
    ----------
    x : ndarray, shape (keep, dim, n)
    rtol : float
    extent, tolerance : ndarray, shape (dim, n)
    finite : ndarray, shape (n,)
        1 where all points are numbers, else 0.
    """
    keep, dimension, n = x.shape
    low, high = np.empty(n), np.empty(n)
    size = np.zeros(n)
    for j in range(n):
        finite[j] = 1
    for i in range(dimension):
        for j in range(n):
            low[j], high[j] = inf, -inf
        for k in range(keep):
            for j in range(n):
                value = x[k, i, j]
                low[j] = value if value < low[j] else low[j]
                high[j] = value if value > high[j] else high[j]
                finite[j] = finite[j] if abs(value) < inf else 0
        for j in range(n):
            extent[i, j] = high[j] - low[j]
            size[j] = max(size[j], max(high[j], -low[j]))
    for i in range(dimension):
        for j in range(n):
            tolerance[i, j] = rtol * extent[i, j] + FLOOR * size[j]
            extent[i, j] = max(extent[i, j], 10.0 * FLOOR * size[j] + 1e-300)


@inlined
def close(x: Any, s: Any, k: int, N: int, tolerance: Any, good: Any) -> int:
    """Keep in ``good`` the orbits whose point and letter k are those N steps earlier; return how many they are."""
    _keep, dimension, n = x.shape
    for i in range(dimension):
        for j in range(n):
            good[j] = good[j] if abs(x[k, i, j] - x[k - N, i, j]) <= tolerance[i, j] else 0
    left = 0
    for j in range(n):
        good[j] = good[j] if s[k, j] == s[k - N, j] else 0
        left += good[j]
    return left


def least_lags(x: Any, s: Any, tolerance: Any, finite: Any, good: Any, lag: Any) -> None:
    """Find for all orbits of a column the least N <= keep/2 after which they recur throughout, 0 for none."""
    keep, _dimension, n = x.shape
    undecided = 0
    for j in range(n):
        lag[j] = 0
        undecided += finite[j]
    N = 1
    while N <= keep // 2 and undecided > 0:
        left = 0
        for j in range(n):
            good[j] = finite[j] if lag[j] == 0 else 0
            left += good[j]
        k = keep - 1
        while k >= N and left > 0:
            left = close(x, s, k, N, tolerance, good)
            k -= 1
        if left > 0:
            for j in range(n):
                lag[j] = N if good[j] else lag[j]
        undecided -= left
        N += 1


@inlined
def same_letters(s: Any, j: int, N: int) -> Any:
    """Return whether the letters of orbit j repeat after N steps."""
    k = N
    while k < s.shape[0] and s[k, j] == s[k - N, j]:
        k += 1
    return k == s.shape[0]


def farthest(x: Any, j: int, extent: Any, start: int, end: int, N: int) -> float:
    """Return the greatest distance, in extents, between points of orbit j N steps apart, from start to end."""
    worst = 0.0
    for k in range(start, end):
        for i in range(x.shape[1]):
            worst = max(worst, abs(x[k, i, j] - x[k - N, i, j]) / extent[i, j])
    return worst


def settling(x: Any, j: int, extent: Any, tolerance: Any, N: int) -> bool:
    """Say whether orbit j recurs better and better after N steps, or arrived, and nearly so after N or 2N."""
    keep, dimension, _n = x.shape
    arrived = 0.0
    for i in range(dimension):
        arrived = max(arrived, tolerance[i, j] / extent[i, j])
    count = keep - N
    groups = min(4, count // N)
    before, start = inf, N
    for g in range(groups):
        end = start + count // groups + (1 if g < count % groups else 0)
        worst = farthest(x, j, extent, start, end, N)
        if g > 0 and not (worst < before * BETTER or worst <= arrived):
            return False
        before, start = worst, end
    if N == 1 and dimension > 1:  # a spiral into a fixed point: its extent is itself the distance that shrinks
        return True
    return min(before, farthest(x, j, extent, keep - N, keep, 2 * N)) <= NEAR


@inlined
def to_be_tried(candidate: int, N: int, keep: int) -> bool:
    """Say whether a cycle of N points may stand beside an orbit that recurs after ``candidate`` steps, 0 for none."""
    return (candidate > N and candidate % N == 0) or (candidate == 0 and 5 * N <= keep)


def recurrence(points: Any, letters: Any, outcomes: Any, rtol: float, period: Any, doubtful: Any) -> None:
    """Give each orbit the period by recurrence alone, and mark those of which a cycle nearby must be asked."""
    columns, keep, dimension, n = points.shape
    extent, tolerance, finite = np.empty((dimension, n)), np.empty((dimension, n)), np.empty(n, np.int64)
    good, lag = np.empty(n, np.int64), np.empty(n, np.int64)
    for q in range(columns):
        x, s = points[q], letters[q]
        measured(x, rtol, extent, tolerance, finite)
        least_lags(x, s, tolerance, finite, good, lag)
        for j in range(n):
            doubtful[q, j] = 0
            if outcomes[q, 0, j] & FATAL or not finite[j]:
                period[q, j] = ENDED
                continue
            if keep < 2:
                period[q, j] = UNDECIDED
                continue
            candidate = lag[j]
            period[q, j] = candidate if candidate > 0 else APERIODIC
            if candidate != 1:
                for N in range(1, keep // 3 + 1):
                    if (
                        to_be_tried(candidate, N, keep)
                        and same_letters(s, j, N)
                        and settling(x, j, extent, tolerance, N)
                    ):
                        doubtful[q, j] = 1
                        break


def root_length(s: Any, first: int, N: int) -> int:
    """Return the length of the shortest word of which the N letters from ``first`` on are a repetition."""
    for p in range(1, N // 2 + 1):
        if N % p == 0:
            n = first + p
            while n < first + N and s[n] == s[n - p]:
                n += 1
            if n == first + N:
                return p
    return N


def least_start(s: Any, first: int, n: int) -> int:
    """Return where, in the cycle of n letters from ``first`` on, the least rotation begins; counted from ``first``."""
    i, j, k = 0, 1, 0  # two rotations that agree in k letters; the larger one and all between them drop out
    while i < n and j < n and k < n:
        a, b = s[first + (i + k) % n], s[first + (j + k) % n]
        if a == b:
            k += 1
            continue
        if a > b:
            i += k + 1
        else:
            j += k + 1
        if i == j:
            j += 1
        k = 0
    return min(i, j)


def spelled(letters: Any, period: Any, key: Any, begin: Any, length: Any) -> None:
    """Say where each orbit's word begins among its letters, how long it is, and a key that only equal words share."""
    columns, keep, starts = letters.shape
    s = np.empty(keep, np.int64)
    for q in range(columns):
        for j in range(starts):
            N = period[q, j]
            key[q, j], begin[q, j], length[q, j] = 0, 0, 0
            if N < 1:
                continue
            for n in range(keep):
                s[n] = letters[q, n, j]
            first = keep - N
            p = root_length(s, first, N)
            start = least_start(s, first, p)
            one, two = p, p
            for n in range(p):
                letter = s[first + (start + n) % p] + 3  # none is below -2
                one = (one * B1 + letter) % P1
                two = (two * B2 + letter) % P2
            key[q, j], begin[q, j], length[q, j] = one * 2147483648 + two, first + start, p


@lru_cache(maxsize=1)
def compiled_recurrence() -> Any:
    """Return :func:`recurrence`, compiled."""
    return compiled(recurrence, "strict")


@lru_cache(maxsize=1)
def compiled_spelling() -> Any:
    """Return :func:`spelled`, compiled."""
    return compiled(spelled, "strict")
