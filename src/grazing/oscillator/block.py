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

from grazing.kernel.primitives import behind, inlined, numbers_at
from grazing.kernel.turns import abreast, eights
from grazing.kernel.vectors import WHOLE, handed_back, transposed
from grazing.oscillator.cells import CELLS, FORCE, LAW, RATE, cell_size
from grazing.oscillator.taylor import bends, coarse, expand, impulse, rough, value
from grazing.oscillator.workspace import HIGH, NAN, SOME, WHOSE, WIDTH, W

INFINITY = float("inf")
#: The least share of a speed that an impact and the force leave. The flight after it is the one before and a change:
#: where that one was much faster, its digits would be lost.
LEAST_LEFT = 1e-3


@inlined
def placed(
    w: Any, to: int, q: int, x: float, y: float, doubt: float, event: float, back: float, when: float, orbit: int,
    met: float,
) -> None:  # fmt: skip
    """Put a flight that has an event ahead to the impacts at hand."""
    w[W.COLUMN + to], w[W.ORBIT + to], w[W.MET + to] = float(q), float(orbit), met
    w[W.X1 + to], w[W.X2 + to], w[W.DOUBT + to] = x, y, doubt
    w[W.EVENT + to], w[W.BACK + to], w[W.WHEN + to] = event, back, when


@inlined
def look_up(w: Any, tables: Any, room: int, places: int, harmonics: int) -> None:
    """Give each place the cell of its event.

    The cell of the impact just before is looked into from there on. Nothing is ever found for an event at the strobe:
    that is not for the block to decide.
    """
    size = cell_size(harmonics)
    for base in range(0, places, 32):
        for k in range(32):
            i = base + k
            cell = max(0.0, (0.5 * w[W.EVENT + i] - 0.75 + WHOLE) - WHOLE)  # (place - 1) // 2
            w[W.INSIDE + i] = cell
            w[W.RECORD + i] = w[W.COLUMN + i] * float(room) + (CELLS + cell * size) + WHOLE
    for base in range(0, places, 8):
        for h in range(0, size, 4):
            transposed(w, W.YM + h * WIDTH + base, WIDTH, tables, W.RECORD + base, h)
    for base in range(0, places, 64):
        for k in range(64):
            i = base + k
            when, until = w[W.WHEN + i], w[W.UNTIL + i]
            low = when if w[W.INSIDE + i] == w[W.BACK + i] else -until
            w[W.SINCE + i] = low if w[W.EVENT + i] > 0.0 else HIGH


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
    g, d = w[W.WAVES + i], w[W.WAVES + WIDTH + i]
    n = -w[W.W2 + i]
    f0, f1, f2, f3 = w[W.F + i] + g, d, g * n, d * n
    f4, f5 = f2 * n, f3 * n
    f6, f7 = f4 * n, f5 * n
    f8, f9 = f6 * n, f7 * n
    f10, f11 = f8 * n, f9 * n
    for h in range(1, harmonics):
        n = -(h + 1.0) * (h + 1.0) * w[W.W2 + i]
        g, d = w[W.WAVES + 2 * h * WIDTH + i], w[W.WAVES + (2 * h + 1) * WIDTH + i]
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
    x, y = w[W.X1 + i], w[W.X2 + i]
    position = w[W.YM + i] + (x * w[W.B1 + i] + y * w[W.B2 + i])
    velocity = w[W.VM + i] + (x * w[W.D1 + i] + y * w[W.D2 + i])
    return expand(position, velocity, w[W.A + i], w[W.K + i], derivatives(w, i, harmonics))


@inlined
def unfolded(w: Any, i: int) -> Any:
    """Return the derivatives of the flight at place i, as the solver left them."""
    return (
        w[W.Y0 + i], w[W.Y1 + i], w[W.Y2 + i], w[W.Y3 + i], w[W.Y4 + i], w[W.Y5 + i], w[W.Y6 + i],
        w[W.Y7 + i], w[W.Y8 + i], w[W.Y9 + i], w[W.Y10 + i], w[W.Y11 + i], w[W.Y12 + i],
        w[W.Y13 + i],
    )  # fmt: skip


@lru_cache(maxsize=64)
def solve_of(harmonics: int) -> Callable[[Any, int], None]:
    """Return the solver of impacts for a number of harmonics.

    Some impacts pass through one short loop after the other: what one loop waits for, the next has long had. In a
    single loop each impact is a long chain of operations, of which the processor overlaps too few.
    """

    @inlined
    def unfold(w: Any, start: int, end: int) -> None:
        """Find the derivatives of the flights in the middles of their cells."""
        for base in range(start, end, 8):
            for k in range(8):
                i, y = base + k, series_at(w, base + k, harmonics)
                w[W.Y0 + i], w[W.Y1 + i], w[W.Y2 + i], w[W.Y3 + i] = y[0], y[1], y[2], y[3]
                w[W.Y4 + i], w[W.Y5 + i], w[W.Y6 + i], w[W.Y7 + i] = y[4], y[5], y[6], y[7]
                w[W.Y8 + i], w[W.Y9 + i], w[W.Y10 + i] = y[8], y[9], y[10]
                w[W.Y11 + i], w[W.Y12 + i], w[W.Y13 + i] = y[11], y[12], y[13]
                w[W.WHEN + i] = clamped(descending(y[0], y[1], y[2]), w[W.SINCE + i], w[W.UNTIL + i])

    @inlined
    def improve(w: Any, start: int, end: int) -> None:
        """Take a step of Newton's method on the first five derivatives, to about four digits."""
        for base in range(start, end, 8):
            for k in range(8):
                i = base + eights(k)
                s = w[W.WHEN + i]
                y, v = coarse(unfolded(w, i), s)
                inverse = 1.0 / v
                w[W.INVERSE + i] = inverse
                w[W.WHEN + i] = clamped(s - y * inverse, w[W.SINCE + i], w[W.UNTIL + i])

    @inlined
    def improve_again(w: Any, start: int, end: int) -> None:
        """Take another one, to about eight digits; the inverse of the velocity needs no division any more."""
        for base in range(start, end, 8):
            for k in range(8):
                i = base + eights(k)
                s, inverse = w[W.WHEN + i], w[W.INVERSE + i]
                y, v = rough(unfolded(w, i), s)
                inverse = inverse * (2.0 - v * inverse)
                w[W.INVERSE + i] = inverse
                w[W.WHEN + i] = s - y * inverse

    @inlined
    def arrive(w: Any, start: int, end: int) -> None:
        """Find position, velocity, acceleration and jerk there; the first two go to AFTER and BEFORE."""
        for base in range(start, end, 8):
            for k in range(8):
                i, y = base + k, unfolded(w, base + k)
                s = w[W.WHEN + i]
                w[W.AFTER + i], w[W.BEFORE + i] = value(y, s)
                w[W.PULL + i], w[W.STEEP + i] = bends(y, s)

    @inlined
    def accept(w: Any, start: int, end: int) -> None:
        """Find the impacts, where the series fall through zero, by one step of third order.

        A cell holds at most one such point (the lemma), so a point where the series falls through zero, inside the
        cell and fast enough for rounding, is the impact.
        """
        for base in range(start, end, 8):
            for k in range(8):
                i = base + eights(k)
                y, v, acceleration, jerk = w[W.AFTER + i], w[W.BEFORE + i], w[W.PULL + i], w[W.STEEP + i]
                s, inverse = w[W.WHEN + i], w[W.INVERSE + i]
                low, high = w[W.SINCE + i], w[W.UNTIL + i]
                inverse = inverse * (2.0 - v * inverse)
                wrong = 1.0 - v * inverse
                inverse = inverse + inverse * wrong
                step = -y * inverse
                bent = acceleration * step * inverse
                step = step * (1.0 - 0.5 * bent)
                v = v + step * (acceleration + 0.5 * step * jerk)
                s = s + step
                w[W.WHEN + i] = s
                sure = (
                    (s > low)
                    & (s < high * (1.0 - 1e-7))
                    & (v < -w[W.SLOWEST_ALLOWED + i])
                    & (abs(bent) < 1e-5)
                    & (abs(step) < 1e-5 * high)
                    & (abs(wrong) < 1e-5)
                )
                w[W.BEFORE + i] = v if sure else -1.0  # no law is asked about nonsense
                w[W.INVERSE + i] = inverse * 1.0001 if sure else -1.0  # of a v that the step changed by 1e-5 at most
                w[W.PROVEN + i] = 1.0 if sure else 0.0

    @inlined
    def solve(w: Any, count: int) -> None:
        for start in range(0, count, SOME):
            end = min(start + SOME, count)
            unfold(w, start, end)
            improve(w, start, end)
            improve_again(w, start, end)
            arrive(w, start, end)
            accept(w, start, end)

    return solve


@inlined
def kick(w: Any, count: int) -> None:
    """Find the flights after the impacts at hand; WIDER gets no finite number where that is not to be done here."""
    for base in range(0, count, 8):
        for k in range(8):
            i = base + eights(k)
            v, u, alpha = w[W.BEFORE + i], w[W.AFTER + i], w[W.A + i]
            s, room = w[W.WHEN + i], w[W.ROOM + i]
            # F where the ball leaves is its acceleration plus alpha v; chatter only completes if this much room is left
            press = -(w[W.PULL + i] + alpha * v)
            ends = (room > 0.0) & (3.9 * u <= (room - s) * press * w[W.GAP + i])
            y, d = impulse(s, alpha, 0.25 * (alpha * alpha) - w[W.K + i])
            change = u - v
            scale = change * w[W.UNMIX + i]
            z1 = w[W.X1 + i] + (w[W.D2 + i] * y - w[W.B2 + i] * d) * scale
            z2 = w[W.X2 + i] + (w[W.B1 + i] * d - w[W.D1 + i] * y) * scale
            w[W.Z1 + i], w[W.Z2 + i] = z1, z2
            flies = (w[W.PROVEN + i] > 0.0) & (u >= 0.0) & (abs(z1) < HIGH) & (abs(z2) < HIGH) & (not ends)
            flies = flies & (LEAST_LEFT * -v < u + w[W.PUSH + i])
            # what an impact makes of the errors before it, see next_launch in contact.py
            worse, steep = w[W.WORSE + i], 1.0 + w[W.STEEP + i]
            carried = worse * u + (w[W.PUSH + i] + change) * steep
            inverse = w[W.INVERSE + i] if flies else -INFINITY  # a NaN would make the compiler skip what leads to it
            w[W.WIDER + i] = w[W.DOUBT + i] * (worse * steep - carried * inverse)
            w[W.SPEED + i] = -v if flies else INFINITY


@inlined
def hand_back(w: Any, runs: Any, count: int, stride: int, left: int) -> None:
    """Give the orbits their pairs after one impact each, but for those in REST."""
    for n in range(count):
        first = runs[WHOSE + n] * stride
        handed_back(w, first, first + stride, W.FREE, (W.Z1, W.Z2), (W.C1, W.C2), W.SPEED, W.SLOW, runs[n])
    for n in range(left):
        k = int(w[W.REST + n])
        i = int(w[W.ORBIT + k])
        w[W.C1 + i], w[W.C2 + i] = w[W.X1 + k], w[W.X2 + k]


@inlined
def hand_on(w: Any, count: int, left: int) -> None:
    """Give the orbits that hit again and then fly free their pairs; those in REST keep what the period began with."""
    n = 0
    for k in range(count):
        i = int(w[W.ORBIT + k])
        w[W.SLOW + i] = min(w[W.SLOW + i], w[W.SPEED + k])
        if n < left and int(w[W.REST + n]) == k:
            n += 1
        else:
            w[W.C1 + i], w[W.C2 + i], w[W.HITS + i] = w[W.Z1 + k], w[W.Z2 + k], w[W.MET + k] + 1.0


@inlined
def is_chord(event: float) -> bool:
    """Return whether the place of an event is that of a chord, not of an end."""
    return int(event) % 2 == 1


@inlined
def set_apart(w: Any, left: int) -> int:
    """Put flights of REST that may pass the wall without an impact side by side; return how many there are."""
    dips = 0
    for n in range(left):
        k = int(w[W.REST + n])
        if not w[W.WIDER + k] < HIGH and is_chord(w[W.EVENT + k]):
            w[W.CLEARANCE + dips] = w[W.DOUBT + k]
            w[W.SINCE + dips], w[W.UNTIL + dips] = w[W.SINCE + k], w[W.UNTIL + k]
            for y in range(W.Y0, W.Y13 + 1, WIDTH):
                w[y + dips] = w[y + k]
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
            low, high = w[W.SINCE + i], w[W.UNTIL + i]
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
            w[W.AFTER + i] = y
            w[W.PULL + i] = 1.0 if (s + step > low) & (s + step < high) else 0.0  # a lowest point, not an end
            w[W.PROVEN + i] = 1.0 if settled & (0.4 * y > w[W.CLEARANCE + i]) else 0.0


@lru_cache(maxsize=256)
def strike_of(law: Callable[..., float], unpack: Callable[..., Any]) -> Callable[..., None]:
    """Return ``strike(work, tables, room, runs, count)``: the reset law for impacts at hand, run by run.

    AFTER gets the velocity, STEEP the slope. A law that jumps, or bends, within the error of the velocity, or whose
    velocity points into the wall, makes AFTER NaN: that is left to the scalar routine.
    """

    def strike(w: Any, tables: Any, room: int, runs: Any, count: int) -> None:
        for n in range(count):
            t = behind(tables, runs[WHOSE + n] * room)
            p, rate, force = unpack(numbers_at(t[LAW])), t[RATE], t[FORCE]
            for base in range(runs[n], runs[n + 1], 4):  # what runs over the end is for the next column
                for k in range(4):
                    j = base + abreast(k)
                    v = w[W.BEFORE + j]
                    # 1/64 of the margin, which is 4096 roundings wide, is error enough; see the budget in docs/proof.md
                    error = w[W.DOUBT + j] * (rate - force * w[W.INVERSE + j]) * 0.015625
                    h = min(max(1e-8 * -v, error), -v)
                    u, less, more = law(v, p), law(v - h, p), law(v + h, p)
                    w[W.STEEP + j] = abs(less - more) / h
                    straight = abs(less + more - 2.0 * u) <= 1e-10 * (u - v)
                    w[W.AFTER + j] = u if straight & (u >= 0.0) else NAN

    return strike
