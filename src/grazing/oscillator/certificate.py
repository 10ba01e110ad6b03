"""Questions to the certificate: four rows and many orbits at a time, or one orbit and many rows.

Who flies free, and where do the others hit? A row (p, q, r) is asked whether p c1 + q c2 + r >= margin. Where p = 1 in
all rows of a table (*upright*: free flights that never change sign) c1 goes to the other side, which saves a product a
row. Loops may run over their end, where nothing is kept yet.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any

from grazing.kernel.primitives import behind, inlined
from grazing.kernel.vectors import appended, failing, filled, first_bit, first_failed, passing
from grazing.oscillator.cells import (
    CERTIFICATE,
    COUNT,
    MARGIN,
    MAX_ROWS,
    ONWARD,
    ROW_COUNT,
    ROWS,
    TABLED,
    UPRIGHT,
    row_from,
)  # fmt: skip
from grazing.oscillator.workspace import (
    BACK,
    C1,
    C2,
    COLUMN,
    DOUBT,
    EVENT,
    HIGH,
    HITS,
    LEAST,
    LIMIT,
    MET,
    NAN,
    NEED,
    NUMBER,
    ORBIT,
    REST,
    THEN,
    WIDER,
    X1,
    X2,
    Z1,
    Z2,
)  # fmt: skip

#: Where the numbers of the certificate's rows begin.
P, Q, R = CERTIFICATE, CERTIFICATE + MAX_ROWS, CERTIFICATE + 2 * MAX_ROWS


@inlined
def four(t: Any, i: int) -> tuple[float, float, float, float]:
    """Return four numbers of a table."""
    return t[i], t[i + 1], t[i + 2], t[i + 3]


@inlined
def lower(a: float, b: float) -> float:
    """Return the smaller one; b where a is not a number."""
    return a if a < b else b


@inlined
def onward(w: Any, tables: Any, room: int, columns: int, stride: int) -> None:
    """Take all pairs over to the next period; LIMIT gets their margins, NaN where a row could overflow.

    NEED gets what the least row must reach: the margin, less c1 where that is in no row.
    """
    for q in range(columns):
        t = behind(tables, q * room)
        s0, a00, a01 = t[ONWARD], t[ONWARD + 1], t[ONWARD + 2]
        s1, a10, a11 = t[ONWARD + 3], t[ONWARD + 4], t[ONWARD + 5]
        m0, m1, m2 = t[MARGIN], t[MARGIN + 1], t[MARGIN + 2]
        aside = t[UPRIGHT]
        for base in range(q * stride, (q + 1) * stride, 16):
            for k in range(16):
                i = base + k
                x, y = w[C1 + i], w[C2 + i]
                x, y = a00 * x + (a01 * y + s0), a10 * x + (a11 * y + s1)
                w[C1 + i], w[C2 + i] = x, y
                margin = m0 + (m1 * abs(x) + m2 * abs(y))
                margin = margin if margin < HIGH else NAN
                w[LIMIT + i], w[NEED + i] = margin, margin - aside * x


@lru_cache(maxsize=2)
def certify_of(upright: bool) -> Callable[..., None]:
    """Return the question whether a period has no impact."""

    @inlined
    def begin(w: Any, t: Any, start: int, end: int) -> None:
        """Set LEAST to the least of the first eight rows."""
        p, c, r = four(t, P), four(t, Q), four(t, R)
        p4, c4, r4 = four(t, P + 4), four(t, Q + 4), four(t, R + 4)
        for base in range(start, end, 16):
            for k in range(16):
                i = base + k
                x, y = w[C1 + i], w[C2 + i]
                z0 = c[0] * y + r[0] if upright else p[0] * x + (c[0] * y + r[0])
                z1 = c[1] * y + r[1] if upright else p[1] * x + (c[1] * y + r[1])
                z2 = c[2] * y + r[2] if upright else p[2] * x + (c[2] * y + r[2])
                z3 = c[3] * y + r[3] if upright else p[3] * x + (c[3] * y + r[3])
                z4 = c4[0] * y + r4[0] if upright else p4[0] * x + (c4[0] * y + r4[0])
                z5 = c4[1] * y + r4[1] if upright else p4[1] * x + (c4[1] * y + r4[1])
                z6 = c4[2] * y + r4[2] if upright else p4[2] * x + (c4[2] * y + r4[2])
                z7 = c4[3] * y + r4[3] if upright else p4[3] * x + (c4[3] * y + r4[3])
                z0, z1, z2, z3 = lower(z0, z1), lower(z2, z3), lower(z4, z5), lower(z6, z7)
                w[LEAST + i] = lower(lower(z0, z1), lower(z2, z3))

    @inlined
    def go_on(w: Any, t: Any, j: int, start: int, end: int) -> None:
        """Lower LEAST to the four rows from row j on."""
        p, c, r = four(t, P + j), four(t, Q + j), four(t, R + j)
        for base in range(start, end, 16):
            for k in range(16):
                i = base + k
                x, y, least = w[C1 + i], w[C2 + i], w[LEAST + i]
                z0 = c[0] * y + r[0] if upright else p[0] * x + (c[0] * y + r[0])
                z1 = c[1] * y + r[1] if upright else p[1] * x + (c[1] * y + r[1])
                z2 = c[2] * y + r[2] if upright else p[2] * x + (c[2] * y + r[2])
                z3 = c[3] * y + r[3] if upright else p[3] * x + (c[3] * y + r[3])
                w[LEAST + i] = lower(lower(least, lower(z0, z1)), lower(z2, z3))

    @inlined
    def certify(w: Any, t: Any, start: int, end: int) -> None:
        """Ask the certificate about the orbits start to end of a column: LEAST gets the least row.

        LEAST >= NEED is proof that there is no impact in the period. Numbers that are no numbers may drop out of the
        least, but never with a NEED that is one, see :func:`onward`.
        """
        begin(w, t, start, end)
        for j in range(8, int(t[COUNT]), 4):
            go_on(w, t, j, start, end)

    return certify


certify_upright, certify_any = certify_of(True), certify_of(False)


@inlined
def certify(w: Any, tables: Any, room: int, columns: int, stride: int) -> None:
    """Ask the certificate about all orbits."""
    for q in range(columns):
        t = behind(tables, q * room)
        if t[UPRIGHT] > 0.0:
            certify_upright(w, t, q * stride, (q + 1) * stride)
        else:
            certify_any(w, t, q * stride, (q + 1) * stride)


@inlined
def locate(w: Any, tables: Any, room: int, runs: Any, count: int) -> None:
    """Find the first rows that the pairs at hand fail: EVENT gets their places, 0 where there is none.

    Results of a run may be written over by the next.
    """
    for n in range(count):
        t = behind(tables, int(w[COLUMN + runs[n]]) * room)
        rows, upright = int(t[ROW_COUNT]), int(t[UPRIGHT])
        for base in range(runs[n], runs[n + 1], 8):
            first_failed(w, X1 + base, X2 + base, DOUBT + base, EVENT + base, t, ROWS, MAX_ROWS, rows, upright)


@inlined
def first_failing(t: Any, start: int, end: int, x: float, y: float, limit: float) -> int:
    """Return the first of the rows from ``start`` on that a pair fails, ``end`` where there is none."""
    for row in range(start, end, 32):
        bits = failing(t, row, MAX_ROWS, min(end - row, 32), x, y, limit)
        if bits != 0:
            return row + first_bit(bits)
    return end


@inlined
def next_event(t: Any, since: float, x: float, y: float, limit: float) -> float:
    """Return the place of the first row that a pair fails from place ``since`` on; 0 where there is none."""
    end = ROWS + int(t[ROW_COUNT])
    row = first_failing(t, row_from(t, ROWS, since), end, x, y, limit)
    return t[row + 3 * MAX_ROWS] if row < end else 0.0


@inlined
def certify_rest(w: Any, tables: Any, room: int, runs: Any, count: int) -> int:
    """Ask the certificate about the rest of the period after each impact; list those that do not fly free in REST."""
    left = 0
    for n in range(count):
        t = behind(tables, int(w[COLUMN + runs[n]]) * room)
        rows = int(t[COUNT])
        for i in range(runs[n], runs[n + 1]):
            since, margin = int(w[THEN + i]), w[WIDER + i]
            passes = passing(t, P + since, MAX_ROWS, rows - since, w[Z1 + i], w[Z2 + i], margin)
            w[REST + left] = float(i)
            left += 0 if passes & (margin < HIGH) else 1
    return left


@inlined
def candidates(w: Any, tables: Any, room: int, columns: int, stride: int, starts: int, runs: Any) -> tuple[int, int]:
    """Put the orbits that the certificate did not settle to the impacts at hand; return how many, and their runs."""
    places, count = 0, 0
    for q in range(columns):
        first, t = q * stride, behind(tables, q * room)
        end = first + starts if t[TABLED] > 0.0 else first
        for i in range(end, first + stride):  # nobody is there
            w[LEAST + i], w[NEED + i] = 0.0, 0.0
        runs[count] = places
        for base in range(first, end, 8):
            places = appended(w, base, LEAST, NEED, (C1, C2, LIMIT, NUMBER), (X1, X2, DOUBT, ORBIT), places)
        for base in range(runs[count], places, 8):
            filled(w, COLUMN + base, float(q))
        count += 1 if places > runs[count] else 0
    runs[count] = places
    for base in range(0, places, 64):
        for k in range(64):
            i = base + k
            w[BACK + i], w[MET + i] = -1.0, 0.0
    return places, count


@inlined
def count_hits(w: Any, end: int) -> None:
    """Say of all orbits that they hit once, or, where the certificate settles it, not at all."""
    for base in range(0, end, 64):
        for k in range(64):
            i = base + k
            w[HITS + i] = 0.0 if w[LEAST + i] >= w[NEED + i] else 1.0


@inlined
def runs_of(w: Any, places: int, runs: Any) -> int:
    """Find the runs of equal columns among the impacts at hand: where each begins; return their number."""
    count, last = 0, -1.0
    for k in range(places):
        runs[count] = k
        count += 1 if w[COLUMN + k] != last else 0
        last = w[COLUMN + k]
    runs[count] = places
    return count
