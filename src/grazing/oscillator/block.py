"""The block: many orbits of the oscillator advanced together, period by period.

All orbits pass the certificate in one loop. Of those it does not settle the cells of the next impacts are found, and
all impacts are solved together on the Taylor series of their cells. What is not proven here, bounds of rounding
included, goes to the scalar routine: near grazes, slow impacts, chatter, sticking, contacts at the strobe. Loops are
branch-free, over the arrays of one workspace, so that they vectorise. An orbit's numbers depend on its own column and
start alone, neither on its neighbours nor on the size of a block.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from math import sqrt
from typing import Any

from grazing.kernel.primitives import at, inlined, transposed
from grazing.oscillator.cells import (
    ALPHA,
    CELLS,
    cell_size,
)  # fmt: skip
from grazing.oscillator.taylor import bends, expand, rough, value
from grazing.oscillator.workspace import (
    AFTER,
    B1,
    B2,
    BACK,
    BEFORE,
    COLUMN,
    D1,
    D2,
    DOUBT,
    EVENT,
    FAR,
    FLIES,
    GAP,
    HIGH,
    INSIDE,
    NAN,
    ONE_ON,
    PROVEN,
    PULL,
    RECORD,
    ROOM,
    SINCE,
    SLOWEST_ALLOWED,
    STEEP,
    TABLE,
    UNTIL,
    VM,
    W2,
    WAVES,
    WHEN,
    WIDER,
    WIDTH,
    WORSE,
    X1,
    X2,
    YM,
    Z1,
    Z2,
    A,
    F,
    K,
    M,
)  # fmt: skip


@inlined
def placed(w: Any, to: int, q: float, x: float, y: float, doubt: float, since: float, back: float, when: float) -> None:
    """Put a flight whose next impact is to be found from place ``since`` on to the impacts at hand."""
    w[at(COLUMN + to)] = q
    w[at(X1 + to)], w[at(X2 + to)], w[at(DOUBT + to)] = x, y, doubt
    w[at(ONE_ON + to)], w[at(BACK + to)], w[at(WHEN + to)] = since, back, when


@inlined
def look_up(w: Any, t: Any, places: int, harmonics: int) -> None:
    """Give each place the constants of its column and the cell of its event.

    The cell of the impact just before is looked into from there on. Nothing is ever found for an event at the strobe:
    that is not for the block to decide.
    """
    size, room = cell_size(harmonics), t.shape[1]
    for base in range(0, places, 32):
        for k in range(32):
            i = base + k
            cell, table = float(int(0.5 * (w[at(EVENT + i)] - 1.0))), w[at(COLUMN + i)] * room
            w[at(INSIDE + i)], w[at(TABLE + i)] = cell, table
            w[at(RECORD + i)] = table + (CELLS + cell * size)
    for base in range(0, places, 8):
        transposed(w, A + base, WIDTH, t, TABLE + base, ALPHA)
        for h in range(0, size, 8):
            transposed(w, YM + h * WIDTH + base, WIDTH, t, RECORD + base, h)
    for base in range(0, places, 64):
        for k in range(64):
            i = base + k
            low = w[at(WHEN + i)] if w[at(INSIDE + i)] == w[at(BACK + i)] else -w[at(UNTIL + i)]
            w[at(SINCE + i)] = low if w[at(EVENT + i)] > 0.0 else HIGH


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

    @inlined
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

    @inlined
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


@inlined
def kick(w: Any, count: int) -> None:
    """Find the flights after the impacts at hand; FLIES gets 0 where that is not to be done here."""
    for base in range(0, count, 8):
        for k in range(8):
            i = base + k
            v, u, alpha = w[at(BEFORE + i)], w[at(AFTER + i)], w[at(A + i)]
            s, room = w[at(WHEN + i)], w[at(ROOM + i)]
            # F where the ball leaves is its acceleration plus alpha v; chatter only completes if this much room is left
            press = -(w[at(PULL + i)] + alpha * v)
            ends = (room > 0.0) & (3.9 * u <= (room - s) * press * w[at(GAP + i)])
            free = expand(0.0, 1.0, alpha, w[at(K + i)], (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0))
            y, d = value(free, -s)
            change = u - v
            b1, d1, b2, d2 = w[at(B1 + i)], w[at(D1 + i)], w[at(B2 + i)], w[at(D2 + i)]
            scale = change / (b1 * d2 - b2 * d1)
            z1 = w[at(X1 + i)] + (d2 * y - b2 * d) * scale
            z2 = w[at(X2 + i)] + (b1 * d - d1 * y) * scale
            w[at(Z1 + i)], w[at(Z2 + i)] = z1, z2
            flies = (w[at(PROVEN + i)] > 0.0) & (u >= 0.0) & (abs(z1) < HIGH) & (abs(z2) < HIGH) & (not ends)
            w[at(FLIES + i)] = 1.0 if flies else 0.0
            # what an impact makes of the errors before it, see next_launch in contact.py
            worse, steep = w[at(WORSE + i)], 1.0 + w[at(STEEP + i)]
            carried = worse * u + (w[at(FAR + i)] * w[at(M + i)] + change) * steep
            w[at(WIDER + i)] = w[at(DOUBT + i)] * (worse * steep - carried / v)


@lru_cache(maxsize=64)
def dip_of(harmonics: int) -> Callable[[Any, int], None]:
    """Return the judge of dips for a number of harmonics."""

    @inlined
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
