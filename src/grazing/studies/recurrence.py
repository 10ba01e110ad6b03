"""After how many steps an orbit recurs, and what its letters are: the part of the classification that most need.

Written for all orbits of many columns at once, for points in any number of dimensions, and independent of the map.
"""

from __future__ import annotations

from functools import lru_cache
from math import inf
from typing import Any

import numpy as np

from grazing.kernel.compile import compiled
from grazing.kernel.lanes import BLOCK as LANES
from grazing.kernel.primitives import at, inlined
from grazing.orbits.word import least_start, wrapped
from grazing.outcome import FATAL

UNDECIDED, APERIODIC, ENDED = 0, -1, -2

#: The absolute part of the tolerance, in units of the orbit's greatest coordinate, each measured by its own unit.
FLOOR = 1e-13
#: It is no less than this in units of the coordinate, so that an orbit at 0 has one.
LEAST = 2.0**-900
#: An orbit nearly recurs within this share of its extent; others are not worth a search for a cycle.
NEAR = 0.1
#: A tolerance of so many extents, or more: the extent may be rounding, which goes round a cycle that attracts slowly.
ROUNDED = 1e-4
#: Points that are compared before it is asked whether any orbit is left.
ROWS = 8
#: Letters of which a number holds one bit each.
BITS = 62
#: Distances after N steps must fall by more than rounding.
BETTER = 1.0 - 1e-10
# Two primes just below 2^31 with bases: a word is known by its two hashes, which products of 62 bits can hold.
P1, B1, P2, B2 = 2147483647, 1000003, 2147483629, 998244353


def gathered(points: Any, letters: Any, first: int, x: Any, s: Any) -> Any:
    """Copy LANES orbits, counted through all columns from ``first`` on, to x (keep, dim, LANES) and s (keep, LANES).

    Returns how many there were; they are followed by copies of the last one.
    """
    columns, keep, dimension, n = points.shape
    width, j = min(LANES, columns * n - first), 0
    while j < width:
        q, start = (first + j) // n, (first + j) % n
        wide = min(n - start, width - j)
        for k in range(keep):
            for i in range(dimension):
                for h in range(wide):
                    x[at(k), at(i), at(j + h)] = points[at(q), at(k), at(i), at(start + h)]
            for h in range(wide):
                s[at(k), at(j + h)] = letters[at(q), at(k), at(start + h)]
        j += wide
    for k in range(keep if width < LANES else 0):
        for j in range(width, LANES):
            for i in range(dimension):
                x[k, i, j] = x[k, i, width - 1]
            s[k, j] = s[k, width - 1]
    return width


def measured(x: Any, rtol: float, unit: Any, extent: Any, tolerance: Any, finite: Any) -> None:
    """Fill in, for LANES orbits, the extent and the tolerance along each coordinate (dim, LANES).

    Parameters
    ----------
    x : ndarray, shape (keep, dim, LANES)
    rtol : float
    unit : ndarray, shape (dim,)
        Of the coordinates.
    extent, tolerance : ndarray, shape (dim, LANES)
    finite : ndarray, shape (LANES,)
        1 where all points are numbers, else 0.
    """
    keep, dimension, _lanes = x.shape
    ends = np.empty((3, LANES))  # low, high, and the greatest coordinate so far
    for j in range(LANES):
        ends[2, j], finite[j] = 0.0, 1
    for i in range(dimension):
        for j in range(LANES):
            ends[0, j], ends[1, j] = inf, -inf
        for k in range(keep):
            for j in range(LANES):
                value = x[k, i, j]
                ends[0, j] = value if value < ends[0, j] else ends[0, j]
                ends[1, j] = value if value > ends[1, j] else ends[1, j]
                finite[j] = finite[j] if abs(value) < inf else 0
        for j in range(LANES):
            extent[i, j] = ends[1, j] - ends[0, j]
            ends[2, j] = max(ends[2, j], max(ends[1, j], -ends[0, j]) / unit[i])
    for i in range(dimension):
        for j in range(LANES):
            floor = FLOOR * (ends[2, j] * unit[i])
            tolerance[i, j] = rtol * extent[i, j] + max(floor, LEAST * unit[i])
            extent[i, j] = max(extent[i, j], 10.0 * max(floor, LEAST * unit[i]))


@inlined
def close(x: Any, s: Any, start: int, end: int, N: int, tolerance: Any, good: Any) -> int:
    """Keep in ``good`` the orbits whose points and letters from start to end are those N steps earlier; count them."""
    for k in range(start, end):
        for i in range(x.shape[1]):
            for j in range(LANES):
                good[j] = good[j] if abs(x[k, i, j] - x[k - N, i, j]) <= tolerance[i, j] else 0
        for j in range(LANES):
            good[j] = good[j] if s[k, j] == s[k - N, j] else 0
    left = 0
    for j in range(LANES):
        left += good[j]
    return left


@inlined
def back_at(x: Any, k: int, N: int, tolerance: Any, waiting: Any, good: Any) -> int:
    """Put into ``good`` the waiting orbits whose first coordinate at point k is that N steps earlier; count them."""
    left = 0
    for j in range(LANES):
        good[j] = waiting[j] if abs(x[k, 0, j] - x[k - N, 0, j]) <= tolerance[0, j] else 0
        left += good[j]
    return left


def least_lags(x: Any, s: Any, tolerance: Any, waiting: Any, good: Any, lag: Any) -> None:
    """Find for LANES orbits the least N <= keep/2 after which they recur throughout, 0 for none.

    Only for those that are 1 in ``waiting``; it becomes 0 where an N is found.
    """
    keep = x.shape[0]
    undecided = 0
    for j in range(LANES):
        lag[j] = 0
        undecided += waiting[j]
    N = 1
    while N <= keep // 2 and undecided > 0:
        end, left = keep, back_at(x, keep - 1, N, tolerance, waiting, good)  # most lags fail at once,
        if left > 0:  # and multiples of a period only where the orbit was still on its way: at the beginning
            left = close(x, s, N, min(N + ROWS, keep), N, tolerance, good)
        while end > N and left > 0:
            start = max(end - ROWS, N)
            left = close(x, s, start, end, N, tolerance, good)
            end = start
        if left > 0:
            for j in range(LANES):
                lag[j] = N if good[j] else lag[j]
                waiting[j] -= good[j]
        undecided -= left
        N += 1


def spoken(s: Any, last: Any) -> None:
    """Put the last bits of the latest letters of LANES orbits into one number each, the newest letter's bit last."""
    for j in range(LANES):
        last[j] = 0
    for k in range(max(s.shape[0] - BITS, 0), s.shape[0]):
        for j in range(LANES):
            last[j] = 2 * last[j] + (s[k, j] & 1)


@inlined
def may_repeat(last: int, count: int, N: int) -> Any:
    """Return whether so many letters, of which ``last`` holds a bit each, may be those N steps earlier."""
    return (last ^ (last >> N)) & ((1 << max(count - N, 0)) - 1) == 0


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
    for i in range(x.shape[1]):
        most = 0.0
        for k in range(start, end):
            most = max(most, abs(x[at(k), at(i), at(j)] - x[at(k - N), at(i), at(j)]))
        worst = max(worst, most / extent[i, j])  # rounding keeps the order: one division does for all
    return worst


@inlined
def nearly_back(x: Any, j: int, extent: Any, N: int) -> Any:
    """Return whether the last N points of orbit j are near all those N steps earlier, or all those 2N earlier.

    Where they are not, :func:`settling` says no after far more work; only N = 1 it asks nothing of.
    """
    keep, dimension, _n = x.shape
    once, twice, k = True, True, keep - 1
    while (once or twice) and k >= keep - N:
        for i in range(dimension):
            once = once and abs(x[k, i, j] - x[k - N, i, j]) / extent[i, j] <= NEAR
            twice = twice and abs(x[k, i, j] - x[k - 2 * N, i, j]) / extent[i, j] <= NEAR
        k -= 1
    return once or twice


def settling(x: Any, j: int, extent: Any, tolerance: Any, N: int) -> bool:
    """Say whether orbit j recurs better and better after N steps, or arrived, and nearly so after N or 2N."""
    keep, dimension, _n = x.shape
    arrived, least = 0.0, 1.0
    for i in range(dimension):
        share = tolerance[i, j] / extent[i, j]
        arrived, least = max(arrived, share), min(least, share)
    if N == 1 and least >= ROUNDED:
        return True
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


@inlined
def next_cycle(x: Any, s: Any, j: int, extent: Any, tolerance: Any, candidate: int, last: int, N: int) -> int:
    """Return the least number of points, not below N, of a cycle that must be asked about orbit j; 0 for none.

    ``last`` is what :func:`spoken` says of the orbit.
    """
    keep = x.shape[0]
    count = min(keep, BITS)
    for n in range(N, min(keep // 3, candidate // 2 if candidate > 0 else keep // 5) + 1):
        if may_repeat(last, count, n) and to_be_tried(candidate, n, keep) and (n == 1 or nearly_back(x, j, extent, n)):
            if same_letters(s, j, n) and settling(x, j, extent, tolerance, n):
                return n
    return 0


def recurrence(
    points: Any, letters: Any, outcomes: Any, rtol: float, unit: Any, period: Any, doubtful: Any, extents: Any,
    tolerances: Any,
) -> None:  # fmt: skip
    """Give each orbit the period by recurrence alone.

    ``unit`` (dim,) measures the coordinates. ``doubtful`` becomes the least number of points of a cycle nearby that
    must be asked, 0 for none; ``extents`` and ``tolerances`` (columns, dim, n) those of :func:`measured`.
    """
    columns, keep, dimension, n = points.shape
    x, s = np.empty((keep, dimension, LANES)), np.empty((keep, LANES), np.int64)
    extent, tolerance = np.empty((dimension, LANES)), np.empty((dimension, LANES))
    finite, waiting = np.empty(LANES, np.int64), np.empty(LANES, np.int64)
    good, lag, last = np.empty(LANES, np.int64), np.empty(LANES, np.int64), np.empty(LANES, np.int64)
    q, lane = 0, 0
    for first in range(0, columns * n, LANES):
        width = gathered(points, letters, first, x, s)
        measured(x, rtol, unit, extent, tolerance, finite)
        for j in range(LANES):
            waiting[j] = finite[j]
        least_lags(x, s, tolerance, waiting, good, lag)
        spoken(s, last)
        for j in range(width):
            doubtful[q, lane] = 0
            for i in range(dimension):
                extents[q, i, lane], tolerances[q, i, lane] = extent[i, j], tolerance[i, j]
            if outcomes[q, 0, lane] & FATAL or not finite[j]:
                period[q, lane] = ENDED
            elif keep < 2:
                period[q, lane] = UNDECIDED
            else:
                period[q, lane] = lag[j] if lag[j] > 0 else APERIODIC
                if lag[j] != 1:
                    doubtful[q, lane] = next_cycle(x, s, j, extent, tolerance, lag[j], last[j], 1)
            lane += 1
            if lane == n:
                q, lane = q + 1, 0


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


@inlined
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
            first = keep - N
            for n in range(first, keep):
                s[n] = letters[q, n, j]
            p = root_length(s, first, N)
            start = least_start(s, first, p)
            one, two = p, p
            for n in range(p):
                letter = s[first + wrapped(start + n, p)] + 3  # none is below -2
                one = (one * B1 + letter) % P1
                two = (two * B2 + letter) % P2
            key[q, j], begin[q, j], length[q, j] = one * 2147483648 + two, first + start, p


def numbered(key: Any, code: Any, first: Any) -> int:
    """Give each key (columns, starts) a number, in the order in which they appear; return how many different there are.

    ``first`` becomes, by number, the place of the first orbit with that key, counted through all columns. Key 0 has
    the number 0, and the place -1, whether any orbit has it or not.
    """
    columns, starts = key.shape
    size = 64
    while size < 2 * columns * starts:
        size *= 2
    slots, known, count = np.full(size, -1, np.int64), np.zeros(columns * starts + 1, np.int64), 1
    slots[0], first[0] = 0, -1
    for q in range(columns):
        for j in range(starts):
            slot = key[q, j] & (size - 1)
            while slots[slot] >= 0 and known[slots[slot]] != key[q, j]:
                slot = (slot + 1) & (size - 1)
            if slots[slot] < 0:
                slots[slot], known[count], first[count] = count, key[q, j], q * starts + j
                count += 1
            code[q, j] = slots[slot]
    return count


@lru_cache(maxsize=1)
def compiled_recurrence() -> Any:
    """Return :func:`recurrence`, compiled."""
    return compiled(recurrence, "strict")


@lru_cache(maxsize=1)
def compiled_spelling() -> Any:
    """Return :func:`spelled`, compiled."""
    return compiled(spelled, "strict")


@lru_cache(maxsize=1)
def compiled_numbering() -> Any:
    """Return :func:`numbered`, compiled."""
    return compiled(numbered, "strict")
