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

from grazing.kernel.primitives import at, inlined
from grazing.kernel.vectors import filled, handed_back, transposed
from grazing.oscillator.cells import CELLS, CONSTANTS, cell_size
from grazing.oscillator.taylor import bends, expand, impulse, rough, value
from grazing.oscillator.workspace import (
    AFTER,
    B1,
    B2,
    BACK,
    BEFORE,
    C1,
    C2,
    CLEARANCE,
    COLUMN,
    D1,
    D2,
    DOUBT,
    EVENT,
    FAR,
    GAP,
    HIGH,
    HITS,
    INSIDE,
    INVERSE,
    LEAST,
    MET,
    NAN,
    NEED,
    ORBIT,
    PROVEN,
    PULL,
    Q2,
    RATE,
    RECORD,
    REST,
    ROOM,
    SINCE,
    SLOW,
    SLOWEST_ALLOWED,
    SOME,
    SPEED,
    STEEP,
    UNMIX,
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
    Y0,
    Y1,
    Y2,
    Y3,
    Y4,
    Y5,
    Y6,
    Y7,
    Y8,
    Y9,
    Y10,
    Y11,
    Y12,
    Y13,
    YM,
    Z1,
    Z2,
    A,
    F,
    K,
    M,
)  # fmt: skip

INFINITY = float("inf")
#: Added and taken off again, it rounds a number to a whole one.
WHOLE = 6755399441055744.0


@inlined
def placed(
    w: Any, to: int, q: int, x: float, y: float, doubt: float, event: float, back: float, when: float, orbit: int,
    met: float,
) -> None:  # fmt: skip
    """Put a flight that has an event ahead to the impacts at hand."""
    w[at(COLUMN + to)], w[at(ORBIT + to)], w[at(MET + to)] = float(q), float(orbit), met
    w[at(X1 + to)], w[at(X2 + to)], w[at(DOUBT + to)] = x, y, doubt
    w[at(EVENT + to)], w[at(BACK + to)], w[at(WHEN + to)] = event, back, when


@inlined
def look_up(w: Any, t: Any, runs: Any, count: int, harmonics: int) -> None:
    """Give each place the constants of its column and the cell of its event.

    The cell of the impact just before is looked into from there on. Nothing is ever found for an event at the strobe:
    that is not for the block to decide.
    """
    size, room, places = cell_size(harmonics), float(t.shape[1]), runs[at(count)]
    for base in range(0, places, 32):
        for k in range(32):
            i = base + k
            cell = max(0.0, (0.5 * w[at(EVENT + i)] - 0.75 + WHOLE) - WHOLE)  # (place - 1) // 2
            w[at(INSIDE + i)] = cell
            w[at(RECORD + i)] = w[at(COLUMN + i)] * room + (CELLS + cell * size)
    for n in range(count):
        q = int(w[at(COLUMN + runs[at(n)])])
        for h in range(CONSTANTS):
            constant = t[at(q), at(h)]
            for base in range(runs[at(n)], runs[at(n + 1)], 8):  # what runs over the end is for the next run
                filled(w, A + h * WIDTH + base, constant)
    for base in range(0, places, 8):
        for h in range(0, size, 4):
            transposed(w, YM + h * WIDTH + base, WIDTH, t, RECORD + base, h)
    for base in range(0, places, 64):
        for k in range(64):
            i = base + k
            when, until = w[at(WHEN + i)], w[at(UNTIL + i)]
            low = when if w[at(INSIDE + i)] == w[at(BACK + i)] else -until
            w[at(SINCE + i)] = low if w[at(EVENT + i)] > 0.0 else HIGH


@inlined
def descending(y: float, v: float, a: float) -> float:
    """Return where y + v s + a s^2/2 falls through zero, or the lowest point where it does not."""
    inside = v * v - 2.0 * a * y
    return 2.0 * y / (sqrt(inside if inside > 0.0 else 0.0) - v)


@inlined
def clamped(s: float, low: float, high: float) -> float:
    """Return s, or the end it lies beyond."""
    s = s if s > low else low
    return s if s < high else high


@inlined
def derivatives(w: Any, i: int, harmonics: int) -> Any:
    """Return the derivatives 0 to 11 of the force at the middle of the cell at place i."""
    g, d = w[at(WAVES + i)], w[at(WAVES + WIDTH + i)]
    n = -w[at(W2 + i)]
    f0, f1, f2, f3 = w[at(F + i)] + g, d, g * n, d * n
    f4, f5 = f2 * n, f3 * n
    f6, f7 = f4 * n, f5 * n
    f8, f9 = f6 * n, f7 * n
    f10, f11 = f8 * n, f9 * n
    for h in range(1, harmonics):
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
    """Return the derivatives of the flight at place i, in the middle of its cell."""
    x, y = w[at(X1 + i)], w[at(X2 + i)]
    position = w[at(YM + i)] + (x * w[at(B1 + i)] + y * w[at(B2 + i)])
    velocity = w[at(VM + i)] + (x * w[at(D1 + i)] + y * w[at(D2 + i)])
    return expand(position, velocity, w[at(A + i)], w[at(K + i)], derivatives(w, i, harmonics))


@inlined
def unfolded(w: Any, i: int) -> Any:
    """Return the derivatives of the flight at place i, as the solver left them."""
    return (
        w[at(Y0 + i)], w[at(Y1 + i)], w[at(Y2 + i)], w[at(Y3 + i)], w[at(Y4 + i)], w[at(Y5 + i)], w[at(Y6 + i)],
        w[at(Y7 + i)], w[at(Y8 + i)], w[at(Y9 + i)], w[at(Y10 + i)], w[at(Y11 + i)], w[at(Y12 + i)],
        w[at(Y13 + i)],
    )  # fmt: skip


@lru_cache(maxsize=64)
def solve_of(harmonics: int) -> Callable[[Any, int], None]:
    """Return the solver of impacts for a number of harmonics.

    Some impacts pass through one short loop after the other: what one loop waits for, the next has long had. In a
    single loop each impact is a long chain of operations, of which the processor overlaps too few.
    """

    @inlined
    def unfold(w: Any, base: int) -> None:
        """Find the derivatives of the flights in the middles of their cells."""
        for k in range(SOME):
            i, y = base + k, series_at(w, base + k, harmonics)
            w[at(Y0 + i)], w[at(Y1 + i)], w[at(Y2 + i)], w[at(Y3 + i)] = y[0], y[1], y[2], y[3]
            w[at(Y4 + i)], w[at(Y5 + i)], w[at(Y6 + i)], w[at(Y7 + i)] = y[4], y[5], y[6], y[7]
            w[at(Y8 + i)], w[at(Y9 + i)], w[at(Y10 + i)] = y[8], y[9], y[10]
            w[at(Y11 + i)], w[at(Y12 + i)], w[at(Y13 + i)] = y[11], y[12], y[13]

    @inlined
    def begin(w: Any, base: int) -> None:
        """Guess the impacts from position, velocity and acceleration."""
        for k in range(SOME):
            i, y = base + k, unfolded(w, base + k)
            w[at(WHEN + i)] = clamped(descending(y[0], y[1], y[2]), w[at(SINCE + i)], w[at(UNTIL + i)])

    @inlined
    def improve(w: Any, base: int) -> None:
        """Take a step of Newton's method on the first seven derivatives."""
        for k in range(SOME):
            i = base + k
            s = w[at(WHEN + i)]
            y, v = rough(unfolded(w, i), s)
            inverse = 1.0 / v
            w[at(INVERSE + i)] = inverse
            w[at(WHEN + i)] = clamped(s - y * inverse, w[at(SINCE + i)], w[at(UNTIL + i)])

    @inlined
    def improve_again(w: Any, base: int) -> None:
        """Take another one, to about eight digits; the inverse of the velocity needs no division any more."""
        for k in range(SOME):
            i = base + k
            s, inverse = w[at(WHEN + i)], w[at(INVERSE + i)]
            y, v = rough(unfolded(w, i), s)
            inverse = inverse * (2.0 - v * inverse)
            w[at(INVERSE + i)] = inverse
            w[at(WHEN + i)] = s - y * inverse

    @inlined
    def arrive(w: Any, base: int) -> None:
        """Find position, velocity, acceleration and jerk there; the first two go to AFTER and BEFORE."""
        for k in range(SOME):
            i, y = base + k, unfolded(w, base + k)
            s = w[at(WHEN + i)]
            w[at(AFTER + i)], w[at(BEFORE + i)] = value(y, s)
            w[at(PULL + i)], w[at(STEEP + i)] = bends(y, s)

    @inlined
    def accept(w: Any, base: int) -> None:
        """Find the impacts, where the series fall through zero, by one step of third order.

        A cell holds at most one such point (the lemma), so a point where the series falls through zero, inside the
        cell and fast enough for rounding, is the impact.
        """
        for k in range(SOME):
            i = base + k
            y, v, acceleration, jerk = w[at(AFTER + i)], w[at(BEFORE + i)], w[at(PULL + i)], w[at(STEEP + i)]
            s, inverse = w[at(WHEN + i)], w[at(INVERSE + i)]
            low, high = w[at(SINCE + i)], w[at(UNTIL + i)]
            inverse = inverse * (2.0 - v * inverse)
            wrong = 1.0 - v * inverse
            inverse = inverse + inverse * wrong
            step = -y * inverse
            bent = acceleration * step * inverse
            step = step * (1.0 - 0.5 * bent)
            v = v + step * (acceleration + 0.5 * step * jerk)
            s = s + step
            w[at(WHEN + i)] = s
            sure = (
                (s > low)
                & (s < high * (1.0 - 1e-7))
                & (v < -w[at(SLOWEST_ALLOWED + i)])
                & (abs(bent) < 1e-5)
                & (abs(step) < 1e-5 * high)
                & (abs(wrong) < 1e-5)
            )
            w[at(BEFORE + i)] = v if sure else -1.0  # no law is asked about nonsense
            w[at(INVERSE + i)] = inverse * 1.0001 if sure else -1.0  # of a v that the step changed by 1e-5 at most
            w[at(PROVEN + i)] = 1.0 if sure else 0.0

    @inlined
    def solve(w: Any, count: int) -> None:
        for base in range(0, count, SOME):
            unfold(w, base)
            begin(w, base)
            improve(w, base)
            improve_again(w, base)
            arrive(w, base)
            accept(w, base)

    return solve


@inlined
def kick(w: Any, count: int) -> None:
    """Find the flights after the impacts at hand; WIDER gets NaN where that is not to be done here."""
    for base in range(0, count, 8):
        for k in range(8):
            i = base + k
            v, u, alpha = w[at(BEFORE + i)], w[at(AFTER + i)], w[at(A + i)]
            s, room = w[at(WHEN + i)], w[at(ROOM + i)]
            # F where the ball leaves is its acceleration plus alpha v; chatter only completes if this much room is left
            press = -(w[at(PULL + i)] + alpha * v)
            ends = (room > 0.0) & (3.9 * u <= (room - s) * press * w[at(GAP + i)])
            y, d = impulse(s, alpha, w[at(Q2 + i)])
            change = u - v
            scale = change * w[at(UNMIX + i)]
            z1 = w[at(X1 + i)] + (w[at(D2 + i)] * y - w[at(B2 + i)] * d) * scale
            z2 = w[at(X2 + i)] + (w[at(B1 + i)] * d - w[at(D1 + i)] * y) * scale
            w[at(Z1 + i)], w[at(Z2 + i)] = z1, z2
            flies = (w[at(PROVEN + i)] > 0.0) & (u >= 0.0) & (abs(z1) < HIGH) & (abs(z2) < HIGH) & (not ends)
            # what an impact makes of the errors before it, see next_launch in contact.py
            worse, steep = w[at(WORSE + i)], 1.0 + w[at(STEEP + i)]
            carried = worse * u + (w[at(FAR + i)] * w[at(M + i)] + change) * steep
            wider = w[at(DOUBT + i)] * (worse * steep - carried * w[at(INVERSE + i)])
            w[at(WIDER + i)] = wider if flies else NAN
            w[at(SPEED + i)] = -v if flies else INFINITY


@inlined
def hand_back(w: Any, end: int, left: int) -> None:
    """Give the orbits their pairs after one impact each, but for those in REST."""
    place = 0
    for base in range(0, end, 8):
        place = handed_back(w, base, LEAST, NEED, (Z1, Z2), (C1, C2), SPEED, SLOW, place)
    for n in range(left):
        k = int(w[at(REST + n)])
        i = int(w[at(ORBIT + k)])
        w[at(C1 + i)], w[at(C2 + i)] = w[at(X1 + k)], w[at(X2 + k)]


@inlined
def hand_on(w: Any, count: int, left: int) -> None:
    """Give the orbits that hit again and then fly free their pairs; those in REST keep what the period began with."""
    n = 0
    for k in range(count):
        i = int(w[at(ORBIT + k)])
        w[at(SLOW + i)] = min(w[at(SLOW + i)], w[at(SPEED + k)])
        if n < left and int(w[at(REST + n)]) == k:
            n += 1
        else:
            w[at(C1 + i)], w[at(C2 + i)], w[at(HITS + i)] = w[at(Z1 + k)], w[at(Z2 + k)], w[at(MET + k)] + 1.0


@inlined
def is_chord(event: float) -> bool:
    """Return whether the place of an event is that of a chord, not of an end."""
    return int(event) % 2 == 1


@inlined
def set_apart(w: Any, left: int) -> int:
    """Put flights of REST that may pass the wall without an impact side by side; return how many there are."""
    dips = 0
    for n in range(left):
        k = int(w[at(REST + n)])
        if not w[at(WIDER + k)] < HIGH and is_chord(w[at(EVENT + k)]):
            w[at(CLEARANCE + dips)] = w[at(DOUBT + k)]
            w[at(SINCE + dips)], w[at(UNTIL + dips)] = w[at(SINCE + k)], w[at(UNTIL + k)]
            for y in range(Y0, Y13 + 1, WIDTH):
                w[at(y + dips)] = w[at(y + k)]
            dips += 1
    return dips


@inlined
def dip(w: Any, count: int) -> None:
    """Find the lowest points of the flights set apart: their heights go to AFTER, 1 to PROVEN if they are clear.

    y/phi is convex in the cell, so with y'(s) = 0 at a height y(s) the flight is nowhere in the cell below 0.4 y(s);
    at an end that is lowest it is not below y(s) at all.
    """
    for base in range(0, count, 8):
        for k in range(8):
            i = base + k
            a = unfolded(w, i)
            low, high = w[at(SINCE + i)], w[at(UNTIL + i)]
            s = clamped(-a[1] / a[2] if a[2] > 0.0 else 0.0, low, high)
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
            w[at(AFTER + i)] = y
            w[at(PULL + i)] = 1.0 if (s + step > low) & (s + step < high) else 0.0  # a lowest point, not an end
            w[at(PROVEN + i)] = 1.0 if settled & (0.4 * y > w[at(CLEARANCE + i)]) else 0.0


@lru_cache(maxsize=256)
def strike_of(law: Callable[..., float], unpack: Callable[..., Any]) -> Callable[..., None]:
    """Return ``strike(work, start, end, row)``: the reset law for impacts at hand of one column.

    AFTER gets the velocity, STEEP the slope. A law that jumps, or bends, within the error of the velocity makes AFTER
    NaN: that is left to the scalar routine.
    """

    def strike(w: Any, start: int, end: int, row: Any) -> None:
        p = unpack(row)
        for base in range(start, end, 8):  # what runs over the end is for the next column
            for k in range(8):
                j = base + k
                v = w[at(BEFORE + j)]
                # 1/64 of the margin, which is 4096 roundings wide, is error enough; see the budget in docs/proof.md
                error = w[at(DOUBT + j)] * (w[at(RATE + j)] - w[at(M + j)] * w[at(INVERSE + j)]) * 0.015625
                h = min(max(1e-8 * -v, error), -v)
                u, less, more = law(v, p), law(v - h, p), law(v + h, p)
                w[at(STEEP + j)] = abs(less - more) / h
                w[at(AFTER + j)] = u if abs(less + more - 2.0 * u) <= 1e-10 * (u - v) else NAN

    return strike
