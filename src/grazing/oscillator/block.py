"""The block: many orbits of the oscillator advanced together, period by period.

All orbits pass the certificate in one loop; those it does not settle are gathered, the cell of their next impact is
found, and all impacts are solved together on the Taylor series of their cells. What is not proven here, bounds of
rounding included, goes to the scalar routine: near grazes, slow impacts, chatter, sticking, contacts at the strobe.
Loops are branch-free, over arrays that lie one behind the other in one workspace, so that they vectorise. An orbit's
numbers depend on its own column and start alone, neither on its neighbours nor on the size of a block.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from math import sqrt
from typing import Any

from grazing.kernel.primitives import at, inlined
from grazing.oscillator.cells import (
    ALPHA,
    CELL,
    CELLS,
    CERTIFICATE,
    COUNT,
    END,
    F0,
    FIRST,
    FORCE,
    GO_ON,
    GROWTH,
    HIGH_END,
    K2,
    LEVER,
    LOW_END,
    MARGIN,
    MAX_CELLS,
    MAX_CERTIFICATE,
    OMEGA2,
    RATIO,
    SLOWEST,
    TIME_LEFT,
)  # fmt: skip
from grazing.oscillator.taylor import bends, expand, rough, value

#: Orbits of a block, and the room of an array in the workspace: loops may run over by a vector or two.
LANES = 512
WIDTH = LANES + 64

# Arrays over the orbits of a block: the pair (c1, c2), the margin, what comes first in the period, the narrowest miss,
# the slowest impact, and the state where the scalar routine is needed.
C1, C2, LIMIT, EVENT, NEAR, SLOW, U, V = (i * WIDTH for i in range(8))
# Arrays over the impacts at hand: pair, margin, and what comes next after the impact,
X1, X2, DOUBT, NEXT = (i * WIDTH for i in range(8, 12))
# the cell: Y, Y', b1, b1', b2, b2', where its series begins and ends, time left in the window, place to go on from,
YM, VM, B1, D1, B2, D2, SINCE, UNTIL, ROOM, ONE_ON = (i * WIDTH for i in range(12, 22))
# constants of the column, and which it is,
A, K, F, W2, M, FAR, GAP, SLOWEST_ALLOWED, WORSE, COLUMN = (i * WIDTH for i in range(22, 32))
# results: time, velocity before and after, slope of the law, acceleration, 1 where proven;
WHEN, BEFORE, AFTER, STEEP, PULL, PROVEN = (i * WIDTH for i in range(32, 38))
# harmonics of the force at the middle of the series, two arrays each.
WAVES = 38 * WIDTH

NAN = float("nan")
#: No event in the rest of the period.
NOTHING = 1e9


def workspace_size(harmonics: int) -> int:
    """Return how many numbers the workspace of a block has."""
    return WAVES + 2 * harmonics * WIDTH


def certify(w: Any, start: int, end: int, t: Any, q: int) -> None:
    """Ask the certificate about orbits start to end, all of column q: EVENT gets the place of the first row that fails.

    NOTHING is proof that there is no impact in the period. Runs over the end.
    """
    start = max(start, 0)
    m0, m1, m2 = t[q, MARGIN], t[q, MARGIN + 1], t[q, MARGIN + 2]
    count = int(t[q, COUNT])
    for base in range(start, end, 16):
        for j in range(count - 4, -1, -4):
            i = CERTIFICATE + j
            p0, q0, r0 = t[q, i], t[q, i + MAX_CERTIFICATE], t[q, i + 2 * MAX_CERTIFICATE]
            p1, q1, r1 = t[q, i + 1], t[q, i + 1 + MAX_CERTIFICATE], t[q, i + 1 + 2 * MAX_CERTIFICATE]
            p2, q2, r2 = t[q, i + 2], t[q, i + 2 + MAX_CERTIFICATE], t[q, i + 2 + 2 * MAX_CERTIFICATE]
            p3, q3, r3 = t[q, i + 3], t[q, i + 3 + MAX_CERTIFICATE], t[q, i + 3 + 2 * MAX_CERTIFICATE]
            i += 3 * MAX_CERTIFICATE
            o0, o1, o2, o3 = t[q, i], t[q, i + 1], t[q, i + 2], t[q, i + 3]
            for k in range(16):
                i = base + k
                x, y = w[at(C1 + i)], w[at(C2 + i)]
                d = m0 + (m1 * abs(x) + m2 * abs(y)) if j + 4 == count else w[at(LIMIT + i)]
                event = NOTHING if j + 4 == count else w[at(EVENT + i)]
                event = o3 if not p3 * x + (q3 * y + r3) >= d else event
                event = o2 if not p2 * x + (q2 * y + r2) >= d else event
                event = o1 if not p1 * x + (q1 * y + r1) >= d else event
                event = o0 if not p0 * x + (q0 * y + r0) >= d else event
                w[at(EVENT + i)] = event
                if j + 4 == count:
                    w[at(LIMIT + i)] = d


def certify_rest(w: Any, count: int, t: Any) -> None:
    """Ask the certificate about the rest of the period after an impact: NEXT is the place of the first failing row."""
    start = 0
    while start < count:
        column = w[at(COLUMN + start)]
        end = start + 1
        while end < count and w[at(COLUMN + end)] == column:
            end += 1
        q = int(column)
        last = int(t[q, COUNT])
        for base in range(start, end, 16):
            for j in range(last - 4, -1, -4):
                i = CERTIFICATE + j
                p0, q0, r0 = t[q, i], t[q, i + MAX_CERTIFICATE], t[q, i + 2 * MAX_CERTIFICATE]
                p1, q1, r1 = t[q, i + 1], t[q, i + 1 + MAX_CERTIFICATE], t[q, i + 1 + 2 * MAX_CERTIFICATE]
                p2, q2, r2 = t[q, i + 2], t[q, i + 2 + MAX_CERTIFICATE], t[q, i + 2 + 2 * MAX_CERTIFICATE]
                p3, q3, r3 = t[q, i + 3], t[q, i + 3 + MAX_CERTIFICATE], t[q, i + 3 + 2 * MAX_CERTIFICATE]
                i += 3 * MAX_CERTIFICATE
                o0, o1, o2, o3 = t[q, i], t[q, i + 1], t[q, i + 2], t[q, i + 3]
                for k in range(16):
                    i = base + k
                    x, y, d, since = w[at(X1 + i)], w[at(X2 + i)], w[at(DOUBT + i)], w[at(ONE_ON + i)]
                    event = NOTHING if j + 4 == last else w[at(NEXT + i)]
                    event = o3 if (not p3 * x + (q3 * y + r3) >= d) & (o3 >= since) else event
                    event = o2 if (not p2 * x + (q2 * y + r2) >= d) & (o2 >= since) else event
                    event = o1 if (not p1 * x + (q1 * y + r1) >= d) & (o1 >= since) else event
                    event = o0 if (not p0 * x + (q0 * y + r0) >= d) & (o0 >= since) else event
                    w[at(NEXT + i)] = event
        start = end


def next_event(t: Any, q: int, x: float, y: float, margin: float, since: int) -> int:
    """Return the place of the first row, from place ``since`` on, that the pair (x, y) fails; NOTHING for none."""
    for j in range(int(t[q, COUNT])):
        i = CERTIFICATE + j
        place = t[q, i + 3 * MAX_CERTIFICATE]
        z = t[q, i] * x + (t[q, i + MAX_CERTIFICATE] * y + t[q, i + 2 * MAX_CERTIFICATE])
        if place >= since and not z >= margin:
            return int(place)
    return int(NOTHING)


@inlined
def cell_of(t: Any, q: int, event: int, x: float, y: float, margin: float, since: int, harmonics: int) -> int:
    """Return the cell to look into for an event: the chord's own, or the first, from ``since`` on, that ends below."""
    last = (event - 1) >> 1
    first = int(t[q, at(CELLS + last * (CELL + 2 * harmonics) + FIRST)])
    cell = last if event % 2 == 1 else max(since, first)
    while cell < last and ends_above(t[q, at(END + cell)], t[q, at(END + cell + MAX_CELLS)],
                                     t[q, at(END + cell + 2 * MAX_CELLS)], x, y, margin):  # fmt: skip
        cell += 1
    return cell


@inlined
def ends_above(p: float, q: float, r: float, x: float, y: float, margin: float) -> bool:
    """Return whether the pair (x, y) passes a row."""
    return p * x + (q * y + r) >= margin


@inlined
def gathered(w: Any, to: int, t: Any, q: int, cell: int, harmonics: int) -> None:
    """Copy a cell of column q to place ``to`` of the impacts at hand."""
    i = CELLS + cell * (CELL + 2 * harmonics)
    w[at(YM + to)], w[at(VM + to)] = t[q, at(i)], t[q, at(i + 1)]
    w[at(B1 + to)], w[at(D1 + to)] = t[q, at(i + 2)], t[q, at(i + 3)]
    w[at(B2 + to)], w[at(D2 + to)] = t[q, at(i + 4)], t[q, at(i + 5)]
    w[at(SINCE + to)], w[at(UNTIL + to)] = t[q, at(i + LOW_END)], t[q, at(i + HIGH_END)]
    w[at(ROOM + to)], w[at(ONE_ON + to)] = t[q, at(i + TIME_LEFT)], t[q, at(i + GO_ON)]
    for h in range(2 * harmonics):
        w[at(WAVES + h * WIDTH + to)] = t[q, at(i + CELL + h)]
    w[at(COLUMN + to)] = float(q)


def spread_constants(w: Any, count: int, t: Any) -> None:
    """Give each place the constants of its column; a run of equal columns may write over what follows it."""
    start = 0
    while start < count:
        column = w[at(COLUMN + start)]
        end = start + 1
        while end < count and w[at(COLUMN + end)] == column:
            end += 1
        q = int(column)
        a, k2, f0, omega2, force = t[q, ALPHA], t[q, K2], t[q, F0], t[q, OMEGA2], t[q, FORCE]
        gap, slowest, growth, lever = 1.0 - t[q, RATIO], t[q, SLOWEST], t[q, GROWTH], t[q, LEVER]
        for base in range(start, end, 32):
            for k in range(32):
                i = base + k
                w[at(A + i)] = a
                w[at(K + i)] = k2
                w[at(F + i)] = f0
                w[at(W2 + i)] = omega2
                w[at(M + i)] = force
                w[at(FAR + i)] = lever
                w[at(GAP + i)] = gap
                w[at(SLOWEST_ALLOWED + i)] = slowest
                w[at(WORSE + i)] = growth
        start = end


@inlined
def descending(y: float, v: float, a: float) -> float:
    """Return where y + v s + a s^2 falls through zero, or the lowest point where it does not."""
    inside = v * v - 4.0 * a * y
    return 2.0 * y / (sqrt(inside if inside > 0.0 else 0.0) - v)


@inlined
def clamped(s: float, low: float, high: float) -> float:
    """Return s, or the end it lies beyond."""
    s = s if s > low else low
    return s if s < high else high


@inlined
def derivatives(w: Any, i: int, harmonics: int) -> Any:
    """Return the derivatives 0 to 11 of the force at the middle of the cell at place i."""
    f0, f1 = w[at(F + i)], 0.0
    f2, f3, f4, f5, f6, f7, f8, f9, f10, f11 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for h in range(harmonics):
        n = -(h + 1.0) * (h + 1.0) * w[at(W2 + i)]
        g, d = w[at(WAVES + 2 * h * WIDTH + i)], w[at(WAVES + (2 * h + 1) * WIDTH + i)]
        f0, f1 = f0 + g, f1 + d
        g, d = g * n, d * n
        f2, f3 = f2 + g, f3 + d
        g, d = g * n, d * n
        f4, f5 = f4 + g, f5 + d
        g, d = g * n, d * n
        f6, f7 = f6 + g, f7 + d
        g, d = g * n, d * n
        f8, f9 = f8 + g, f9 + d
        f10, f11 = f10 + g * n, f11 + d * n
    return f0, f1, f2, f3, f4, f5, f6, f7, f8, f9, f10, f11


@inlined
def series_at(w: Any, i: int, harmonics: int) -> Any:
    """Return the Taylor coefficients of the flight at place i."""
    x, y = w[at(X1 + i)], w[at(X2 + i)]
    position = w[at(YM + i)] + (x * w[at(B1 + i)] + y * w[at(B2 + i)])
    velocity = w[at(VM + i)] + (x * w[at(D1 + i)] + y * w[at(D2 + i)])
    return expand(position, velocity, w[at(A + i)], w[at(K + i)], derivatives(w, i, harmonics))


@lru_cache(maxsize=64)
def guess_of(harmonics: int) -> Callable[[Any, int], None]:
    """Return the first part of the solver of impacts; in two loops, because short ones overlap in the processor."""

    def guess(w: Any, count: int) -> None:
        """Find the impact at place i to about eight digits: Newton's method on the first seven coefficients."""
        for base in range(0, count, 8):
            for k in range(8):
                i = base + k
                a = series_at(w, i, harmonics)
                low, high = w[at(SINCE + i)], w[at(UNTIL + i)]
                s = clamped(descending(a[0], a[1], a[2]), low, high)
                y, v = rough(a, s)
                inverse = 1.0 / v
                s = clamped(s - y * inverse, low, high)
                y, v = rough(a, s)
                w[at(WHEN + i)] = s - y * (inverse * (2.0 - v * inverse))

    return guess


@lru_cache(maxsize=64)
def solve_of(harmonics: int) -> Callable[[Any, int], None]:
    """Return the second part of the solver of impacts."""

    def solve(w: Any, count: int) -> None:
        """Find the impact at place i, where the series falls through zero, by one step of third order from the guess.

        A cell holds at most one such point (the lemma), so a point where the series falls through zero, inside the
        cell and fast enough for rounding, is the impact.
        """
        for base in range(0, count, 8):
            for k in range(8):
                i = base + k
                a = series_at(w, i, harmonics)
                low, high, s = w[at(SINCE + i)], w[at(UNTIL + i)], w[at(WHEN + i)]
                y, v = value(a, s)
                acceleration, jerk = bends(a, s)
                inverse = 1.0 / v
                step = -y * inverse
                bent = acceleration * step * inverse
                step = step * (1.0 - 0.5 * bent)
                v = v + step * (acceleration + 0.5 * step * jerk)
                s = s + step
                w[at(WHEN + i)] = s
                w[at(PULL + i)] = acceleration
                sure = (
                    (s > low)
                    & (s < high * (1.0 - 1e-7))
                    & (v < -w[at(SLOWEST_ALLOWED + i)])
                    & (abs(bent) < 1e-5)
                    & (abs(step) < 1e-5 * high)
                )
                w[at(BEFORE + i)] = v if sure else -1.0  # no law is asked about nonsense
                w[at(PROVEN + i)] = 1.0 if sure else 0.0

    return solve


def kick(w: Any, count: int) -> None:
    """Turn the flight at place i into the one after its impact, unless that needs the scalar routine."""
    for base in range(0, count, 8):
        for k in range(8):
            i = base + k
            v, u, alpha = w[at(BEFORE + i)], w[at(AFTER + i)], w[at(A + i)]
            s = w[at(WHEN + i)]
            room = w[at(ROOM + i)]
            # F where the ball leaves is its acceleration plus alpha v; chatter only completes if this much room is left
            press = -(w[at(PULL + i)] + alpha * v)
            ends = (room > 0.0) & (3.9 * u <= (room - s) * press * w[at(GAP + i)])
            flies = (w[at(PROVEN + i)] > 0.0) & (u >= 0.0) & (u < 1e300) & (not ends)
            free = expand(0.0, 1.0, alpha, w[at(K + i)], (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0))
            y, d = value(free, -s)
            change = u - v
            b1, d1, b2, d2 = w[at(B1 + i)], w[at(D1 + i)], w[at(B2 + i)], w[at(D2 + i)]
            scale = change / (b1 * d2 - b2 * d1)
            x, y1 = w[at(X1 + i)], w[at(X2 + i)]
            w[at(X1 + i)] = x + (d2 * y - b2 * d) * scale if flies else x
            w[at(X2 + i)] = y1 + (b1 * d - d1 * y) * scale if flies else y1
            # what an impact makes of the errors before it, see next_launch in contact.py
            worse, steep = w[at(WORSE + i)], 1.0 + w[at(STEEP + i)]
            carried = worse * u + (w[at(FAR + i)] * w[at(M + i)] + change) * steep
            w[at(DOUBT + i)] = w[at(DOUBT + i)] * (worse * steep - carried / v)
            w[at(PROVEN + i)] = 1.0 if flies else 0.0


@lru_cache(maxsize=64)
def dip_of(harmonics: int) -> Callable[[Any, int], None]:
    """Return the judge of dips for a number of harmonics."""

    def dip(w: Any, count: int) -> None:
        """Find the lowest point of the flight in a cell: its height goes to AFTER, 1 to PROVEN if it is clear.

        y/phi is convex in the cell, so with y'(s) = 0 at a height y(s) the flight is nowhere in the cell below
        0.4 y(s); at an end that is lowest it is not below y(s) at all.
        """
        for base in range(0, count, 8):
            for k in range(8):
                i = base + k
                a = series_at(w, i, harmonics)
                low, high = w[at(SINCE + i)], w[at(UNTIL + i)]
                s = clamped(-0.5 * a[1] / a[2] if a[2] > 0.0 else 0.0, low, high)
                _y, v = rough(a, s)
                acceleration, _jerk = bends(a, s)
                s = clamped(s - v / acceleration, low, high)
                _y, v = value(a, s)
                acceleration, _jerk = bends(a, s)
                step = clamped(s - v / acceleration, low, high) - s
                y, v = value(a, s + step)
                # what is left of v after the last step lowers y by less than this
                y = y - abs(v * step) - v * v / acceleration if (s + step > low) & (s + step < high) else y
                settled = (acceleration > 0.0) & (abs(step) < 1e-4 * high)
                w[at(WHEN + i)] = s + step
                w[at(AFTER + i)] = y
                w[at(PULL + i)] = 1.0 if (s + step > low) & (s + step < high) else 0.0  # a lowest point, not an end
                w[at(PROVEN + i)] = 1.0 if settled & (0.4 * y > w[at(DOUBT + i)]) else 0.0

    return dip


@lru_cache(maxsize=256)
def strike_of(law: Callable[..., float], unpack: Callable[..., Any], fields: int) -> Callable[..., None]:
    """Return ``strike(work, start, end, rows)``: the reset law for all impacts at hand, column by column.

    AFTER gets the velocity, STEEP the slope. A law that jumps, or bends, within the error of the velocity makes AFTER
    NaN: that is left to the scalar routine.
    """

    def strike(w: Any, start: int, end: int, rows: Any) -> None:
        i = start
        while i < end:
            column = w[at(COLUMN + i)]
            last = i + 1
            while last < end and w[at(COLUMN + last)] == column:
                last += 1
            p = unpack(rows, fields * int(column))
            for j in range(i, last):
                v = w[at(BEFORE + j)]
                # 1/64 of the margin, which is 4096 roundings wide, is error enough; see the budget in docs/proof.md
                rough_rate = (w[at(WORSE + j)] - 1.0) / w[at(FAR + j)] + w[at(A + j)]
                error = w[at(DOUBT + j)] * (rough_rate - w[at(M + j)] / v) * 0.015625
                h = min(max(1e-8 * -v, error), -v)
                u, less, more = law(v, p), law(v - h, p), law(v + h, p)
                w[at(STEEP + j)] = abs(less - more) / h
                w[at(AFTER + j)] = u if abs(less + more - 2.0 * u) <= 1e-10 * (u - v) else NAN
            i = last

    return strike
