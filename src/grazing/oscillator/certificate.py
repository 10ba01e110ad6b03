"""Questions to the certificate: four rows and many orbits at a time, or one orbit and many rows.

Who flies free, and where do the others hit? A row (p, q, r) is asked whether p c1 + q c2 + r >= margin. Where p = 1 in
all rows of a table (*upright*: free flights that never change sign) c1 goes to the other side, which saves a product a
row. Loops may run over their end, where nothing is kept yet.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any

from grazing.kernel.primitives import at, inlined
from grazing.kernel.vectors import appended, failing, filled, first_bit, first_failed, passing
from grazing.oscillator.cells import (
    CERTIFICATE,
    COUNT,
    MARGIN,
    MAX_ROWS,
    ONWARD,
    ROW_COUNT,
    ROWS,
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


@inlined
def four(t: Any, q: int, i: int) -> tuple[float, float, float, float]:
    """Return four numbers of table q."""
    return t[at(q), at(i)], t[at(q), at(i + 1)], t[at(q), at(i + 2)], t[at(q), at(i + 3)]


@inlined
def lower(a: float, b: float) -> float:
    """Return the smaller one; b where a is not a number."""
    return a if a < b else b


@inlined
def onward(w: Any, t: Any, columns: int, stride: int) -> None:
    """Take all pairs over to the next period; LIMIT gets their margins, NaN where a row could overflow.

    NEED gets what the least row must reach: the margin, less c1 where that is in no row.
    """
    for q in range(columns):
        s0, a00, a01 = t[at(q), ONWARD], t[at(q), ONWARD + 1], t[at(q), ONWARD + 2]
        s1, a10, a11 = t[at(q), ONWARD + 3], t[at(q), ONWARD + 4], t[at(q), ONWARD + 5]
        m0, m1, m2 = t[at(q), MARGIN], t[at(q), MARGIN + 1], t[at(q), MARGIN + 2]
        aside = t[at(q), UPRIGHT]
        for base in range(q * stride, (q + 1) * stride, 16):
            for k in range(16):
                i = base + k
                x, y = w[at(C1 + i)], w[at(C2 + i)]
                x, y = a00 * x + (a01 * y + s0), a10 * x + (a11 * y + s1)
                w[at(C1 + i)], w[at(C2 + i)] = x, y
                margin = m0 + (m1 * abs(x) + m2 * abs(y))
                margin = margin if margin < HIGH else NAN
                w[at(LIMIT + i)], w[at(NEED + i)] = margin, margin - aside * x


@lru_cache(maxsize=2)
def certify_of(upright: bool) -> Callable[..., None]:
    """Return the question whether a period has no impact."""

    @inlined
    def begin(w: Any, t: Any, q: int, start: int, end: int) -> None:
        """Set LEAST to the least of the first eight rows."""
        j, k8 = CERTIFICATE, CERTIFICATE + 4
        p, c, r = four(t, q, j), four(t, q, j + MAX_ROWS), four(t, q, j + 2 * MAX_ROWS)
        p8, c8, r8 = four(t, q, k8), four(t, q, k8 + MAX_ROWS), four(t, q, k8 + 2 * MAX_ROWS)
        for base in range(start, end, 16):
            for k in range(16):
                i = base + k
                x, y = w[at(C1 + i)], w[at(C2 + i)]
                z0 = c[0] * y + r[0] if upright else p[0] * x + (c[0] * y + r[0])
                z1 = c[1] * y + r[1] if upright else p[1] * x + (c[1] * y + r[1])
                z2 = c[2] * y + r[2] if upright else p[2] * x + (c[2] * y + r[2])
                z3 = c[3] * y + r[3] if upright else p[3] * x + (c[3] * y + r[3])
                z4 = c8[0] * y + r8[0] if upright else p8[0] * x + (c8[0] * y + r8[0])
                z5 = c8[1] * y + r8[1] if upright else p8[1] * x + (c8[1] * y + r8[1])
                z6 = c8[2] * y + r8[2] if upright else p8[2] * x + (c8[2] * y + r8[2])
                z7 = c8[3] * y + r8[3] if upright else p8[3] * x + (c8[3] * y + r8[3])
                z0, z1, z2, z3 = lower(z0, z1), lower(z2, z3), lower(z4, z5), lower(z6, z7)
                w[at(LEAST + i)] = lower(lower(z0, z1), lower(z2, z3))

    @inlined
    def go_on(w: Any, t: Any, q: int, j: int, start: int, end: int) -> None:
        """Lower LEAST to the four rows from j on."""
        p, c, r = four(t, q, j), four(t, q, j + MAX_ROWS), four(t, q, j + 2 * MAX_ROWS)
        for base in range(start, end, 16):
            for k in range(16):
                i = base + k
                x, y, least = w[at(C1 + i)], w[at(C2 + i)], w[at(LEAST + i)]
                z0 = c[0] * y + r[0] if upright else p[0] * x + (c[0] * y + r[0])
                z1 = c[1] * y + r[1] if upright else p[1] * x + (c[1] * y + r[1])
                z2 = c[2] * y + r[2] if upright else p[2] * x + (c[2] * y + r[2])
                z3 = c[3] * y + r[3] if upright else p[3] * x + (c[3] * y + r[3])
                w[at(LEAST + i)] = lower(lower(least, lower(z0, z1)), lower(z2, z3))

    @inlined
    def certify(w: Any, t: Any, q: int, start: int, end: int) -> None:
        """Ask the certificate about the orbits start to end of column q: LEAST gets the least row.

        LEAST >= NEED is proof that there is no impact in the period. Numbers that are no numbers may drop out of the
        least, but never with a NEED that is one, see :func:`onward`.
        """
        begin(w, t, q, start, end)
        for j in range(CERTIFICATE + 8, CERTIFICATE + int(t[at(q), COUNT]), 4):
            go_on(w, t, q, j, start, end)

    return certify


certify_upright, certify_any = certify_of(True), certify_of(False)


@inlined
def certify(w: Any, t: Any, columns: int, stride: int) -> None:
    """Ask the certificate about all orbits."""
    for q in range(columns):
        if t[at(q), UPRIGHT] > 0.0:
            certify_upright(w, t, q, q * stride, (q + 1) * stride)
        else:
            certify_any(w, t, q, q * stride, (q + 1) * stride)


@inlined
def locate(w: Any, t: Any, runs: Any, count: int) -> None:
    """Find the first rows that the pairs at hand fail: EVENT gets their places, 0 where there is none.

    Results of a run may be written over by the next.
    """
    for n in range(count):
        q = int(w[at(COLUMN + runs[at(n)])])
        rows, upright, first = int(t[at(q), ROW_COUNT]), int(t[at(q), UPRIGHT]), q * t.shape[1] + ROWS
        for base in range(runs[at(n)], runs[at(n + 1)], 8):
            first_failed(w, X1 + base, X2 + base, DOUBT + base, EVENT + base, t, first, MAX_ROWS, rows, upright)


@inlined
def first_failing(t: Any, q: int, start: int, end: int, x: float, y: float, limit: float) -> int:
    """Return the first of the rows from ``start`` on that a pair fails, ``end`` where there is none."""
    for row in range(start, end, 32):
        bits = failing(t, q * t.shape[1] + row, MAX_ROWS, min(end - row, 32), x, y, limit)
        if bits != 0:
            return row + first_bit(bits)
    return end


@inlined
def next_event(t: Any, q: int, since: float, x: float, y: float, limit: float) -> float:
    """Return the place of the first row that a pair fails from place ``since`` on; 0 where there is none."""
    end = ROWS + int(t[at(q), ROW_COUNT])
    row = first_failing(t, q, row_from(t, q, ROWS, since), end, x, y, limit)
    return t[at(q), at(row + 3 * MAX_ROWS)] if row < end else 0.0


@inlined
def certify_rest(w: Any, t: Any, runs: Any, count: int) -> int:
    """Ask the certificate about the rest of the period after each impact; list those that do not fly free in REST."""
    left = 0
    for n in range(count):
        q = int(w[at(COLUMN + runs[at(n)])])
        rows, first = int(t[at(q), COUNT]), q * t.shape[1] + CERTIFICATE
        for i in range(runs[at(n)], runs[at(n + 1)]):
            since, margin = int(w[at(THEN + i)]), w[at(WIDER + i)]
            passes = passing(t, first + since, MAX_ROWS, rows - since, w[at(Z1 + i)], w[at(Z2 + i)], margin)
            w[at(REST + left)] = float(i)
            left += 0 if passes & (margin < HIGH) else 1
    return left


@inlined
def candidates(w: Any, columns: int, stride: int, starts: int, tabled: Any, runs: Any) -> tuple[int, int]:
    """Put the orbits that the certificate did not settle to the impacts at hand; return how many, and their runs."""
    places, count = 0, 0
    for q in range(columns):
        first, end = q * stride, q * stride + starts if tabled[q] else q * stride
        for i in range(end, first + stride):  # nobody is there
            w[at(LEAST + i)], w[at(NEED + i)] = 0.0, 0.0
        runs[at(count)] = places
        for base in range(first, end, 8):
            places = appended(w, base, LEAST, NEED, (C1, C2, LIMIT, NUMBER), (X1, X2, DOUBT, ORBIT), places)
        for base in range(runs[at(count)], places, 8):
            filled(w, COLUMN + base, float(q))
        count += 1 if places > runs[at(count)] else 0
    runs[at(count)] = places
    for base in range(0, places, 64):
        for k in range(64):
            i = base + k
            w[at(BACK + i)], w[at(MET + i)] = -1.0, 0.0
    return places, count


@inlined
def count_hits(w: Any, end: int) -> None:
    """Say of all orbits that they hit once, or, where the certificate settles it, not at all."""
    for base in range(0, end, 64):
        for k in range(64):
            i = base + k
            w[at(HITS + i)] = 0.0 if w[at(LEAST + i)] >= w[at(NEED + i)] else 1.0


@inlined
def runs_of(w: Any, places: int, runs: Any) -> int:
    """Find the runs of equal columns among the impacts at hand: where each begins; return their number."""
    count, last = 0, -1.0
    for k in range(places):
        runs[at(count)] = k
        count += 1 if w[at(COLUMN + k)] != last else 0
        last = w[at(COLUMN + k)]
    runs[count] = places
    return count
