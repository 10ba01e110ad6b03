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
    CELL_COUNT,
    CELLS,
    CERTIFICATE,
    CERTIFICATE_COUNT,
    CHORD,
    END,
    F0,
    FORCE,
    GROWTH,
    K2,
    MARGIN,
    MAX_CELLS,
    MAX_CERTIFICATE,
    OMEGA2,
    RATIO,
    RISE,
    SLOWEST,
)  # fmt: skip
from grazing.oscillator.taylor import bends, expand, rough, value

#: Orbits of a block, and the room of an array in the workspace: loops may run over by a vector or two.
LANES = 512
WIDTH = LANES + 64

# Arrays over the orbits of a block: the pair (c1, c2), the least row of the certificate, that less the margin, the
# narrowest miss, the slowest impact.
C1, C2, LOW, SPARE, NEAR, SLOW = (i * WIDTH for i in range(6))
# Arrays over the orbits that the certificate did not settle: pair, margin, time of the last impact in its cell, what
# comes first.
T1, T2, TD, TW, EVENT = (i * WIDTH for i in range(6, 11))
# Arrays over the impacts at hand: pair, margin,
X1, X2, DOUBT = (i * WIDTH for i in range(11, 14))
# the cell: Y, Y', b1, b1', b2, b2', half length, time left in the window, earliest time allowed,
YM, VM, B1, D1, B2, D2, HALF, ROOM, SINCE = (i * WIDTH for i in range(14, 23))
# constants of the column, and which it is,
A, K, F, W2, M, GAP, SLOWEST_ALLOWED, WORSE, COLUMN = (i * WIDTH for i in range(23, 32))
# results: time, velocity before and after, slope of the law, acceleration, 1 where proven, place
# from which the rest of the period is asked about, 1 where that is free;
WHEN, BEFORE, AFTER, STEEP, PULL, PROVEN, NEXT, FREE = (i * WIDTH for i in range(32, 40))
# harmonics of the force at the middle of the cell, two arrays each.
WAVES = 40 * WIDTH

NAN = float("nan")
#: No event in the period, as a whole number and as a float.
NONE = 1 << 30
NOTHING = float(NONE)


def workspace_size(harmonics: int) -> int:
    """Return how many numbers the workspace of a block has."""
    return WAVES + 2 * harmonics * WIDTH


def certify(w: Any, start: int, end: int, t: Any, q: int) -> None:
    """Evaluate the certificate of column q for orbits start to end: LOW, and SPARE > 0 where it holds."""
    start = max(start, 0)
    m0, m1, m2 = t[q, MARGIN], t[q, MARGIN + 1], t[q, MARGIN + 2]
    count = int(t[q, CERTIFICATE_COUNT])
    for base in range(start, end, 16):
        for j in range(0, count, 8):
            i = CERTIFICATE + j
            p0, q0, r0 = t[q, i], t[q, i + MAX_CERTIFICATE], t[q, i + 2 * MAX_CERTIFICATE]
            p1, q1, r1 = t[q, i + 1], t[q, i + 1 + MAX_CERTIFICATE], t[q, i + 1 + 2 * MAX_CERTIFICATE]
            p2, q2, r2 = t[q, i + 2], t[q, i + 2 + MAX_CERTIFICATE], t[q, i + 2 + 2 * MAX_CERTIFICATE]
            p3, q3, r3 = t[q, i + 3], t[q, i + 3 + MAX_CERTIFICATE], t[q, i + 3 + 2 * MAX_CERTIFICATE]
            p4, q4, r4 = t[q, i + 4], t[q, i + 4 + MAX_CERTIFICATE], t[q, i + 4 + 2 * MAX_CERTIFICATE]
            p5, q5, r5 = t[q, i + 5], t[q, i + 5 + MAX_CERTIFICATE], t[q, i + 5 + 2 * MAX_CERTIFICATE]
            p6, q6, r6 = t[q, i + 6], t[q, i + 6 + MAX_CERTIFICATE], t[q, i + 6 + 2 * MAX_CERTIFICATE]
            p7, q7, r7 = t[q, i + 7], t[q, i + 7 + MAX_CERTIFICATE], t[q, i + 7 + 2 * MAX_CERTIFICATE]
            for k in range(16):
                i = base + k
                x, y = w[at(C1 + i)], w[at(C2 + i)]
                z0 = lesser(p0 * x + (q0 * y + r0), p1 * x + (q1 * y + r1))
                z2 = lesser(p2 * x + (q2 * y + r2), p3 * x + (q3 * y + r3))
                z4 = lesser(p4 * x + (q4 * y + r4), p5 * x + (q5 * y + r5))
                z6 = lesser(p6 * x + (q6 * y + r6), p7 * x + (q7 * y + r7))
                z0 = lesser(lesser(z0, z2), lesser(z4, z6))
                if j > 0:
                    z0 = lesser(z0, w[at(LOW + i)])
                w[at(LOW + i)] = z0
                w[at(SPARE + i)] = z0 - (m0 + (m1 * abs(x) + m2 * abs(y)))


@inlined
def lesser(x: float, y: float) -> float:
    """Return the lesser of two numbers, as one instruction."""
    return x if x < y else y


@inlined
def first_event(t: Any, q: int, x: float, y: float, margin: float, since: int) -> int:
    """Return what comes first in the rest of the period, from place ``since`` on; NONE if nothing does.

    2 i + 2: the ball is below the wall at the end of cell i. 2 i + 1: it may touch the wall within cell i.
    """
    first = NONE
    for base in range(0, int(t[q, CELL_COUNT]), 16):
        for k in range(16):
            i = base + k
            chord = t[q, at(CHORD + i)] * x + (
                t[q, at(CHORD + MAX_CELLS + i)] * y + t[q, at(CHORD + 2 * MAX_CELLS + i)]
            )
            rise = t[q, at(RISE + i)] * x + (t[q, at(RISE + MAX_CELLS + i)] * y + t[q, at(RISE + 2 * MAX_CELLS + i)])
            end = t[q, at(END + i)] * x + (t[q, at(END + MAX_CELLS + i)] * y + t[q, at(END + 2 * MAX_CELLS + i)])
            place = 2 * i + 1 if (not chord >= margin) & (not rise < 0.0) & (2 * i + 1 >= since) else NONE
            place = min(place, 2 * i + 2 if (not end >= margin) & (2 * i + 2 >= since) else NONE)
            first = min(first, place)
    return first


def first_events(w: Any, start: int, end: int, t: Any, q: int) -> None:
    """Do what :func:`first_event` does for orbits start to end, all of column q, from the start of the period on.

    EVENT gets the place, 0 where the ball is not surely above the wall at the strobe. Runs over the end.
    """
    start = max(start, 0)
    p, r, s = t[q, CERTIFICATE], t[q, CERTIFICATE + MAX_CERTIFICATE], t[q, CERTIFICATE + 2 * MAX_CERTIFICATE]
    for base in range(start, end, 8):
        for j in range(int(t[q, CELL_COUNT]) - 4, -1, -4):
            i = CHORD + j
            cp0, cp1, cp2, cp3 = t[q, i], t[q, i + 1], t[q, i + 2], t[q, i + 3]
            i += MAX_CELLS
            cq0, cq1, cq2, cq3 = t[q, i], t[q, i + 1], t[q, i + 2], t[q, i + 3]
            i += MAX_CELLS
            cr0, cr1, cr2, cr3 = t[q, i], t[q, i + 1], t[q, i + 2], t[q, i + 3]
            i += MAX_CELLS
            rp0, rp1, rp2, rp3 = t[q, i], t[q, i + 1], t[q, i + 2], t[q, i + 3]
            i += MAX_CELLS
            rq0, rq1, rq2, rq3 = t[q, i], t[q, i + 1], t[q, i + 2], t[q, i + 3]
            i += MAX_CELLS
            rr0, rr1, rr2, rr3 = t[q, i], t[q, i + 1], t[q, i + 2], t[q, i + 3]
            i += MAX_CELLS
            ep0, ep1, ep2, ep3 = t[q, i], t[q, i + 1], t[q, i + 2], t[q, i + 3]
            i += MAX_CELLS
            eq0, eq1, eq2, eq3 = t[q, i], t[q, i + 1], t[q, i + 2], t[q, i + 3]
            i += MAX_CELLS
            er0, er1, er2, er3 = t[q, i], t[q, i + 1], t[q, i + 2], t[q, i + 3]
            place, last = 2.0 * j, j + 4 >= int(t[q, CELL_COUNT])
            for k in range(8):
                i = base + k
                x, y, d = w[at(T1 + i)], w[at(T2 + i)], w[at(TD + i)]
                event = NOTHING if last else w[at(EVENT + i)]
                event = place + 8.0 if not ep3 * x + (eq3 * y + er3) >= d else event
                touch = (not cp3 * x + (cq3 * y + cr3) >= d) & (not rp3 * x + (rq3 * y + rr3) < 0.0)
                event = place + 7.0 if touch else event
                event = place + 6.0 if not ep2 * x + (eq2 * y + er2) >= d else event
                touch = (not cp2 * x + (cq2 * y + cr2) >= d) & (not rp2 * x + (rq2 * y + rr2) < 0.0)
                event = place + 5.0 if touch else event
                event = place + 4.0 if not ep1 * x + (eq1 * y + er1) >= d else event
                touch = (not cp1 * x + (cq1 * y + cr1) >= d) & (not rp1 * x + (rq1 * y + rr1) < 0.0)
                event = place + 3.0 if touch else event
                event = place + 2.0 if not ep0 * x + (eq0 * y + er0) >= d else event
                touch = (not cp0 * x + (cq0 * y + cr0) >= d) & (not rp0 * x + (rq0 * y + rr0) < 0.0)
                event = place + 1.0 if touch else event
                if j == 0:
                    event = 0.0 if not p * x + (r * y + s) >= d else event
                w[at(EVENT + i)] = event


def certify_rest(w: Any, count: int, t: Any) -> None:
    """Ask the certificate about the rest of the period of the orbits that just had an impact: FREE is 1 where it holds."""
    start = 0
    while start < count:
        column = w[at(COLUMN + start)]
        end = start + 1
        while end < count and w[at(COLUMN + end)] == column:
            end += 1
        q = int(column)
        for base in range(start, end, 8):
            for j in range(0, int(t[q, CERTIFICATE_COUNT]), 8):
                i = CERTIFICATE + j
                p0, q0, r0 = t[q, i], t[q, i + MAX_CERTIFICATE], t[q, i + 2 * MAX_CERTIFICATE]
                p1, q1, r1 = t[q, i + 1], t[q, i + 1 + MAX_CERTIFICATE], t[q, i + 1 + 2 * MAX_CERTIFICATE]
                p2, q2, r2 = t[q, i + 2], t[q, i + 2 + MAX_CERTIFICATE], t[q, i + 2 + 2 * MAX_CERTIFICATE]
                p3, q3, r3 = t[q, i + 3], t[q, i + 3 + MAX_CERTIFICATE], t[q, i + 3 + 2 * MAX_CERTIFICATE]
                p4, q4, r4 = t[q, i + 4], t[q, i + 4 + MAX_CERTIFICATE], t[q, i + 4 + 2 * MAX_CERTIFICATE]
                p5, q5, r5 = t[q, i + 5], t[q, i + 5 + MAX_CERTIFICATE], t[q, i + 5 + 2 * MAX_CERTIFICATE]
                p6, q6, r6 = t[q, i + 6], t[q, i + 6 + MAX_CERTIFICATE], t[q, i + 6 + 2 * MAX_CERTIFICATE]
                p7, q7, r7 = t[q, i + 7], t[q, i + 7 + MAX_CERTIFICATE], t[q, i + 7 + 2 * MAX_CERTIFICATE]
                o0 = t[q, i + 3 * MAX_CERTIFICATE]
                o1 = t[q, i + 1 + 3 * MAX_CERTIFICATE]
                o2 = t[q, i + 2 + 3 * MAX_CERTIFICATE]
                o3 = t[q, i + 3 + 3 * MAX_CERTIFICATE]
                o4 = t[q, i + 4 + 3 * MAX_CERTIFICATE]
                o5 = t[q, i + 5 + 3 * MAX_CERTIFICATE]
                o6 = t[q, i + 6 + 3 * MAX_CERTIFICATE]
                o7 = t[q, i + 7 + 3 * MAX_CERTIFICATE]
                for k in range(8):
                    i = base + k
                    x, y, d, since = w[at(X1 + i)], w[at(X2 + i)], w[at(DOUBT + i)], w[at(NEXT + i)]
                    free = 1.0 if j == 0 else w[at(FREE + i)]
                    free = 0.0 if (not p0 * x + (q0 * y + r0) >= d) & (o0 >= since) else free
                    free = 0.0 if (not p1 * x + (q1 * y + r1) >= d) & (o1 >= since) else free
                    free = 0.0 if (not p2 * x + (q2 * y + r2) >= d) & (o2 >= since) else free
                    free = 0.0 if (not p3 * x + (q3 * y + r3) >= d) & (o3 >= since) else free
                    free = 0.0 if (not p4 * x + (q4 * y + r4) >= d) & (o4 >= since) else free
                    free = 0.0 if (not p5 * x + (q5 * y + r5) >= d) & (o5 >= since) else free
                    free = 0.0 if (not p6 * x + (q6 * y + r6) >= d) & (o6 >= since) else free
                    free = 0.0 if (not p7 * x + (q7 * y + r7) >= d) & (o7 >= since) else free
                    w[at(FREE + i)] = free
        start = end


@inlined
def gathered(w: Any, to: int, t: Any, q: int, cell: int, harmonics: int) -> None:
    """Copy a cell of column q to place ``to`` of the impacts at hand."""
    i = CELLS + cell * (CELL + 2 * harmonics)
    w[at(YM + to)], w[at(VM + to)] = t[q, at(i)], t[q, at(i + 1)]
    w[at(B1 + to)], w[at(D1 + to)] = t[q, at(i + 2)], t[q, at(i + 3)]
    w[at(B2 + to)], w[at(D2 + to)] = t[q, at(i + 4)], t[q, at(i + 5)]
    w[at(HALF + to)], w[at(ROOM + to)] = t[q, at(i + 6)], t[q, at(i + 7)]
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
        gap, slowest, growth = 1.0 - t[q, RATIO], t[q, SLOWEST], t[q, GROWTH]
        for base in range(start, end, 32):
            for k in range(32):
                i = base + k
                w[at(A + i)] = a
                w[at(K + i)] = k2
                w[at(F + i)] = f0
                w[at(W2 + i)] = omega2
                w[at(M + i)] = force
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
    """Return the derivatives 0 to 10 of the force at the middle of the cell at place i."""
    f0, f1 = w[at(F + i)], 0.0
    f2, f3, f4, f5, f6, f7, f8, f9, f10 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
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
        f10 = f10 + g * n
    return f0, f1, f2, f3, f4, f5, f6, f7, f8, f9, f10


@inlined
def series_at(w: Any, i: int, harmonics: int) -> Any:
    """Return the Taylor coefficients of the flight at place i."""
    x, y = w[at(X1 + i)], w[at(X2 + i)]
    position = w[at(YM + i)] + (x * w[at(B1 + i)] + y * w[at(B2 + i)])
    velocity = w[at(VM + i)] + (x * w[at(D1 + i)] + y * w[at(D2 + i)])
    return expand(position, velocity, w[at(A + i)], w[at(K + i)], derivatives(w, i, harmonics))


@lru_cache(maxsize=64)
def solve_of(harmonics: int) -> Callable[[Any, int], None]:
    """Return the solver of impacts for a number of harmonics."""

    def solve(w: Any, count: int) -> None:
        """Find the impact at place i: where the series falls through zero.

        A cell holds at most one such point (the lemma), so a point where the series falls through zero, inside the cell
        and fast enough for rounding, is the impact. Newton on the first seven coefficients, then one step of third order
        on all of them.
        """
        for base in range(0, count, 8):
            for k in range(8):
                i = base + k
                a = series_at(w, i, harmonics)
                low, high = w[at(SINCE + i)], w[at(HALF + i)]
                s = clamped(descending(a[0], a[1], a[2]), low, high)
                y, v = rough(a, s)
                inverse = 1.0 / v
                s = clamped(s - y * inverse, low, high)
                y, v = rough(a, s)
                inverse = inverse * (2.0 - v * inverse)
                s = s - y * inverse
                y, v = value(a, s)
                acceleration, jerk = bends(a, s)
                inverse = inverse * (2.0 - v * inverse)
                inverse = inverse * (2.0 - v * inverse)
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
            # F where the ball leaves is its acceleration plus alpha v; chatter can only complete if this much room is left
            press = -(w[at(PULL + i)] + alpha * v)
            ends = (room > 0.0) & (3.9 * u <= (room - s) * press * w[at(GAP + i)])
            flies = (w[at(PROVEN + i)] > 0.0) & (u >= 0.0) & (u < 1e300) & (not ends)
            free = expand(0.0, 1.0, alpha, w[at(K + i)], (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0))
            y, d = value(free, -s)
            change = u - v
            b1, d1, b2, d2 = w[at(B1 + i)], w[at(D1 + i)], w[at(B2 + i)], w[at(D2 + i)]
            scale = change / (b1 * d2 - b2 * d1)
            x, y1 = w[at(X1 + i)], w[at(X2 + i)]
            w[at(X1 + i)] = x + (d2 * y - b2 * d) * scale if flies else x
            w[at(X2 + i)] = y1 + (b1 * d - d1 * y) * scale if flies else y1
            # what an impact makes of the errors before it, see next_launch in contact.py
            worse = (1.0 + w[at(STEEP + i)]) * (1.0 - (u + w[at(M + i)]) / v)
            w[at(DOUBT + i)] = w[at(DOUBT + i)] * (w[at(WORSE + i)] * worse)
            w[at(PROVEN + i)] = 1.0 if flies else 0.0


@lru_cache(maxsize=64)
def dip_of(harmonics: int) -> Callable[[Any, int], None]:
    """Return the judge of dips for a number of harmonics."""

    def dip(w: Any, count: int) -> None:
        """Find the lowest point of the flight in the cell at place i: its height goes to AFTER, 1 to PROVEN if it is clear.

        y/phi is convex in the cell, so with y'(s) = 0 at a height y(s) the flight is nowhere in the cell below 0.4 y(s);
        at an end that is lowest it is not below y(s) at all.
        """
        for base in range(0, count, 8):
            for k in range(8):
                i = base + k
                a = series_at(w, i, harmonics)
                high = w[at(HALF + i)]
                s = clamped(-0.5 * a[1] / a[2] if a[2] > 0.0 else 0.0, -high, high)
                _y, v = rough(a, s)
                acceleration, _jerk = bends(a, s)
                s = clamped(s - v / acceleration, -high, high)
                _y, v = value(a, s)
                acceleration, _jerk = bends(a, s)
                step = clamped(s - v / acceleration, -high, high) - s
                y, v = value(a, s + step)
                # what is left of v after the last step lowers y by less than this
                y = y - abs(v * step) - v * v / acceleration if abs(s + step) < high else y
                settled = (acceleration > 0.0) & (abs(step) < 1e-4 * high)
                w[at(WHEN + i)] = s + step
                w[at(AFTER + i)] = y
                w[at(PROVEN + i)] = 1.0 if settled & (0.4 * y > w[at(DOUBT + i)]) else 0.0

    return dip


@lru_cache(maxsize=256)
def strike_of(law: Callable[..., float], unpack: Callable[[Any], Any], fields: int) -> Callable[..., None]:
    """Return ``strike(work, start, end, rows)``: the reset law for all impacts at hand, column by column.

    AFTER gets the velocity, STEEP the slope. A law that jumps beside the velocity makes AFTER NaN, as only the scalar
    routine knows how certain that velocity is.
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
                h = 1e-6 * max(abs(v), 1e-6)
                u, less, more = law(v, p), law(v - h, p), law(min(v + h, 0.0), p)
                w[at(STEEP + j)] = abs(less - more) / h
                w[at(AFTER + j)] = u if abs(less - more) <= 1e-3 * (u - v) else NAN
            i = last

    return strike
