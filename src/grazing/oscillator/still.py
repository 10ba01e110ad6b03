"""Columns that repeat themselves: their orbits need not be flown any more.

What is done with a pair in a period depends on the pair and the column alone. So an orbit that comes back to its pair,
bit by bit, comes back to it again and again, with the same impacts, near misses and slow impacts between. Near an
attractor of period one that is so after some dozens of periods: rounding leaves one pair, or two between which it goes
to and fro; an orbit of period two ends so, too. A pair that flies free fades away, which takes long; it counts as come
back as soon as it no longer shows in the state. A column in which all pairs have come back stands still for as many
cycles as fit into what is left of the run.
"""

from __future__ import annotations

from typing import Any

from grazing.kernel.primitives import behind, inlined, unit
from grazing.oscillator.cells import CYCLE, HOLDING, K2, LOOKED_AT, ONWARD, STATE, WAKE
from grazing.oscillator.workspace import AWAKE, W

#: Cycles of at most so many periods are looked for, from one period in so many on.
LONGEST, SELDOM = 2, 8
#: What is added to a number does not show in it if it is smaller by this; half of 1.1e-16 would do.
UNSEEN = 1e-17


@inlined
def remember(w: Any, tables: Any, room: int, runs: Any, awake: int, stride: int) -> None:
    """Keep the pairs with which a period begins."""
    for n in range(awake):
        q = runs[AWAKE + n]
        t, first = behind(tables, q * room), q * stride
        t[LOOKED_AT] = 1.0
        for i in range(first, first + stride):
            w[W.OLD1 + i], w[W.OLD2 + i] = w[W.C1 + i], w[W.C2 + i]


@inlined
def come_back(w: Any, t: Any, start: int, end: int) -> bool:
    """Return whether all pairs are those that were kept, or fly free and have shown in no state since.

    The energy k^2 y^2 + v^2 of a free flight never grows: if it was too small to show then, it is so in all periods.
    """
    steady = (t[ONWARD] == 0.0) & (t[ONWARD + 3] == 0.0)  # else what a pair is added to changes
    u, v, u1, u2, v1, v2 = t[STATE], t[STATE + 3], t[STATE + 1], t[STATE + 2], t[STATE + 4], t[STATE + 5]
    unseen = UNSEEN * UNSEEN * min(t[K2] * (u * u), v * v) if steady else 0.0
    for i in range(start, end):
        x, y = w[W.OLD1 + i], w[W.OLD2 + i]
        height, speed = u1 * x + u2 * y, v1 * x + v2 * y
        fades = (w[W.FREE + i] > 0.0) & (t[K2] * (height * height) + speed * speed < unseen)
        if not fades and not (w[W.C1 + i] == x and w[W.C2 + i] == y):
            return False
    return True


@unit
def find_cycles(
    w: Any, tables: Any, room: int, runs: Any, awake: int, stride: int, starts: int, length: int
) -> int:  # fmt: skip
    """Note in which columns all orbits have come back after ``length`` periods; return in how many.

    Not where the scalar routine flew one of them: what it says of a period is said in each.
    """
    found = 0
    for n in range(awake):
        q = runs[AWAKE + n]
        t, first = behind(tables, q * room), q * stride
        if t[HOLDING] > 0.0:
            t[LOOKED_AT] = 0.0
        if t[LOOKED_AT] > 0.0 and t[CYCLE] == 0.0 and come_back(w, t, first, first + starts):
            t[CYCLE] = float(length)
            found += 1
    return found


@inlined
def stand_still(tables: Any, room: int, columns: int, runs: Any, n: int, transient: int, total: int) -> tuple[int, int]:
    """List the columns that are flown in period n; return how many, and in which period to ask again.

    What is passed over and what is kept are two stretches of the run. Of the kept one a whole cycle is flown first, so
    that it can be written again and again.
    """
    awake, again = 0, total
    for q in range(columns):
        t = behind(tables, q * room)
        cycle, left = int(t[CYCLE]), (transient if n < transient else total) - n
        if cycle > 0 and float(n) >= t[WAKE] and left >= cycle and (n < transient or n >= transient + cycle):
            t[WAKE] = float(n + left // cycle * cycle)
        if float(n) < t[WAKE]:
            again = min(again, int(t[WAKE]))
        else:
            runs[AWAKE + awake] = q
            awake += 1
            again = n + 1 if cycle > 0 else again
    return awake, again
