"""Questions to the certificate, eight rows and many orbits at a time.

Who flies free, and where do the others hit? A row (p, q, r) is asked whether p c1 + q c2 + r >= margin. Where p = 1 in
all rows of a table (*upright*: free flights that never change sign) c1 can wait to the end, which saves a product per
row. Loops may run over their end, where nothing is kept yet.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any

from grazing.kernel.primitives import appended, at, filled, inlined
from grazing.oscillator.cells import (
    CERTIFICATE,
    COUNT,
    MARGIN,
    ONWARD,
    ROW_COUNT,
    ROWS,
    UPRIGHT,
)  # fmt: skip
from grazing.oscillator.workspace import (
    BACK,
    C1,
    C2,
    COLUMN,
    DOUBT,
    EVENT,
    HIGH,
    LEAST,
    LIMIT,
    LOW,
    MET,
    NAN,
    NUMBER,
    ONE_ON,
    ORBIT,
    SLOW,
    SLOWEST_YET,
    X1,
    X2,
    Z1,
    Z2,
)  # fmt: skip


@inlined
def eight(t: Any, q: int, i: int) -> tuple[float, float, float, float, float, float, float, float]:
    """Return eight numbers of table q."""
    return (
        t[at(q), at(i)], t[at(q), at(i + 1)], t[at(q), at(i + 2)], t[at(q), at(i + 3)], t[at(q), at(i + 4)],
        t[at(q), at(i + 5)], t[at(q), at(i + 6)], t[at(q), at(i + 7)],
    )  # fmt: skip


@inlined
def lower(a: float, b: float) -> float:
    """Return the smaller one; b where a is not a number."""
    return a if a < b else b


@inlined
def onward(w: Any, t: Any, columns: int, stride: int) -> None:
    """Take all pairs over to the next period; LIMIT gets their margins, NaN where a row could overflow."""
    for q in range(columns):
        s0, a00, a01 = t[at(q), ONWARD], t[at(q), ONWARD + 1], t[at(q), ONWARD + 2]
        s1, a10, a11 = t[at(q), ONWARD + 3], t[at(q), ONWARD + 4], t[at(q), ONWARD + 5]
        m0, m1, m2 = t[at(q), MARGIN], t[at(q), MARGIN + 1], t[at(q), MARGIN + 2]
        for base in range(q * stride, (q + 1) * stride, 16):
            for k in range(16):
                i = base + k
                x, y = w[at(C1 + i)], w[at(C2 + i)]
                x, y = a00 * x + (a01 * y + s0), a10 * x + (a11 * y + s1)
                w[at(C1 + i)], w[at(C2 + i)] = x, y
                margin = m0 + (m1 * abs(x) + m2 * abs(y))
                w[at(LIMIT + i)] = margin if margin < HIGH else NAN


@lru_cache(maxsize=2)
def certify_of(upright: bool) -> Callable[..., None]:
    """Return the question whether a period has no impact."""

    @inlined
    def certify(w: Any, t: Any, q: int, start: int, end: int) -> None:
        """Ask the certificate about the orbits start to end of column q: LEAST gets the least row.

        LEAST >= LIMIT is proof that there is no impact in the period. Numbers that are no numbers may drop out of the
        least, but never with a LIMIT that is one, see :func:`onward`.
        """
        last = CERTIFICATE + 4 * int(t[at(q), COUNT]) - 32
        for j in range(CERTIFICATE, last + 1, 32):
            p, c, r = eight(t, q, j), eight(t, q, j + 8), eight(t, q, j + 16)
            for base in range(start, end, 16):
                for k in range(16):
                    i = base + k
                    x, y = w[at(C1 + i)], w[at(C2 + i)]
                    least = HIGH if j == CERTIFICATE else w[at(LEAST + i)]
                    z0 = c[0] * y + r[0] if upright else p[0] * x + (c[0] * y + r[0])
                    z1 = c[1] * y + r[1] if upright else p[1] * x + (c[1] * y + r[1])
                    z2 = c[2] * y + r[2] if upright else p[2] * x + (c[2] * y + r[2])
                    z3 = c[3] * y + r[3] if upright else p[3] * x + (c[3] * y + r[3])
                    z4 = c[4] * y + r[4] if upright else p[4] * x + (c[4] * y + r[4])
                    z5 = c[5] * y + r[5] if upright else p[5] * x + (c[5] * y + r[5])
                    z6 = c[6] * y + r[6] if upright else p[6] * x + (c[6] * y + r[6])
                    z7 = c[7] * y + r[7] if upright else p[7] * x + (c[7] * y + r[7])
                    z0, z1, z2, z3 = lower(z0, z1), lower(z2, z3), lower(z4, z5), lower(z6, z7)
                    least = lower(lower(least, lower(z0, z1)), lower(z2, z3))
                    w[at(LEAST + i)] = x + least if upright and j == last else least

    return certify


@lru_cache(maxsize=2)
def certify_rest_of(upright: bool) -> Callable[..., None]:
    """Return the question whether the rest of a period has no impact."""

    @inlined
    def certify_rest(w: Any, t: Any, q: int, start: int, end: int) -> None:
        """Ask the certificate about the flights after impacts, from ONE_ON on: LOW gets the least row."""
        last = CERTIFICATE + 4 * int(t[at(q), COUNT]) - 32
        for j in range(CERTIFICATE, last + 1, 32):
            p, c, r, o = eight(t, q, j), eight(t, q, j + 8), eight(t, q, j + 16), eight(t, q, j + 24)
            for base in range(start, end, 8):
                for k in range(8):
                    i = base + k
                    x, y, since = w[at(Z1 + i)], w[at(Z2 + i)], w[at(ONE_ON + i)]
                    least = HIGH if j == CERTIFICATE else w[at(LOW + i)]
                    z0 = c[0] * y + r[0] if upright else p[0] * x + (c[0] * y + r[0])
                    z1 = c[1] * y + r[1] if upright else p[1] * x + (c[1] * y + r[1])
                    z2 = c[2] * y + r[2] if upright else p[2] * x + (c[2] * y + r[2])
                    z3 = c[3] * y + r[3] if upright else p[3] * x + (c[3] * y + r[3])
                    z4 = c[4] * y + r[4] if upright else p[4] * x + (c[4] * y + r[4])
                    z5 = c[5] * y + r[5] if upright else p[5] * x + (c[5] * y + r[5])
                    z6 = c[6] * y + r[6] if upright else p[6] * x + (c[6] * y + r[6])
                    z7 = c[7] * y + r[7] if upright else p[7] * x + (c[7] * y + r[7])
                    least = lower(z0, least) if o[0] >= since else least
                    least = lower(z1, least) if o[1] >= since else least
                    least = lower(z2, least) if o[2] >= since else least
                    least = lower(z3, least) if o[3] >= since else least
                    least = lower(z4, least) if o[4] >= since else least
                    least = lower(z5, least) if o[5] >= since else least
                    least = lower(z6, least) if o[6] >= since else least
                    least = lower(z7, least) if o[7] >= since else least
                    w[at(LOW + i)] = x + least if upright and j == last else least

    return certify_rest


@lru_cache(maxsize=2)
def locate_of(upright: bool) -> Callable[..., None]:
    """Return the search for the next event."""

    @inlined
    def locate(w: Any, t: Any, q: int, start: int, end: int) -> None:
        """Find the first row that a pair fails, from place ONE_ON on: EVENT gets its place, 0 if there is none."""
        last = ROWS + 4 * int(t[at(q), ROW_COUNT]) - 32
        for j in range(last, ROWS - 1, -32):
            p, c, r, o = eight(t, q, j), eight(t, q, j + 8), eight(t, q, j + 16), eight(t, q, j + 24)
            for base in range(start, end, 8):
                for k in range(8):
                    i = base + k
                    x, y, since = w[at(X1 + i)], w[at(X2 + i)], w[at(ONE_ON + i)]
                    limit = w[at(DOUBT + i)] - x if upright else w[at(DOUBT + i)]
                    event = 0.0 if j == last else w[at(EVENT + i)]
                    z = c[7] * y + r[7] if upright else p[7] * x + (c[7] * y + r[7])
                    event = o[7] if (not z >= limit) & (o[7] >= since) else event
                    z = c[6] * y + r[6] if upright else p[6] * x + (c[6] * y + r[6])
                    event = o[6] if (not z >= limit) & (o[6] >= since) else event
                    z = c[5] * y + r[5] if upright else p[5] * x + (c[5] * y + r[5])
                    event = o[5] if (not z >= limit) & (o[5] >= since) else event
                    z = c[4] * y + r[4] if upright else p[4] * x + (c[4] * y + r[4])
                    event = o[4] if (not z >= limit) & (o[4] >= since) else event
                    z = c[3] * y + r[3] if upright else p[3] * x + (c[3] * y + r[3])
                    event = o[3] if (not z >= limit) & (o[3] >= since) else event
                    z = c[2] * y + r[2] if upright else p[2] * x + (c[2] * y + r[2])
                    event = o[2] if (not z >= limit) & (o[2] >= since) else event
                    z = c[1] * y + r[1] if upright else p[1] * x + (c[1] * y + r[1])
                    event = o[1] if (not z >= limit) & (o[1] >= since) else event
                    z = c[0] * y + r[0] if upright else p[0] * x + (c[0] * y + r[0])
                    event = o[0] if (not z >= limit) & (o[0] >= since) else event
                    w[at(EVENT + i)] = event

    return locate


certify_upright, certify_any = certify_of(True), certify_of(False)
certify_rest_upright, certify_rest_any = certify_rest_of(True), certify_rest_of(False)
locate_upright, locate_any = locate_of(True), locate_of(False)


@inlined
def certify(w: Any, t: Any, columns: int, stride: int) -> None:
    """Ask the certificate about all orbits."""
    for q in range(columns):
        if t[at(q), UPRIGHT] > 0.0:
            certify_upright(w, t, q, q * stride, (q + 1) * stride)
        else:
            certify_any(w, t, q, q * stride, (q + 1) * stride)


@inlined
def certify_rest(w: Any, t: Any, runs: Any, count: int) -> None:
    """Ask the certificate about all flights after impacts; results of a run may be written over by the next."""
    for n in range(count):
        q = int(w[at(COLUMN + runs[at(n)])])
        if t[at(q), UPRIGHT] > 0.0:
            certify_rest_upright(w, t, q, runs[at(n)], runs[at(n + 1)])
        else:
            certify_rest_any(w, t, q, runs[at(n)], runs[at(n + 1)])


@inlined
def locate(w: Any, t: Any, runs: Any, count: int) -> None:
    """Find the next events of all impacts at hand."""
    for n in range(count):
        q = int(w[at(COLUMN + runs[at(n)])])
        if t[at(q), UPRIGHT] > 0.0:
            locate_upright(w, t, q, runs[at(n)], runs[at(n + 1)])
        else:
            locate_any(w, t, q, runs[at(n)], runs[at(n + 1)])


@inlined
def candidates(w: Any, columns: int, stride: int, starts: int, tabled: Any, runs: Any) -> tuple[int, int]:
    """Put the orbits that the certificate did not settle to the impacts at hand; return how many, and their runs."""
    places, count = 0, 0
    for q in range(columns):
        first, end = q * stride, q * stride + starts if tabled[q] else q * stride
        for i in range(end, first + stride):  # nobody is there
            w[at(LEAST + i)], w[at(LIMIT + i)] = 0.0, 0.0
        runs[at(count)] = places
        for base in range(first, end, 8):
            places = appended(
                w, base, LEAST, LIMIT, (C1, C2, LIMIT, NUMBER, SLOW), (X1, X2, DOUBT, ORBIT, SLOWEST_YET), places
            )
        for base in range(runs[at(count)], places, 8):
            filled(w, COLUMN + base, float(q))
        count += 1 if places > runs[at(count)] else 0
    runs[at(count)] = places
    for base in range(0, places, 64):
        for k in range(64):
            i = base + k
            w[at(ONE_ON + i)], w[at(BACK + i)], w[at(MET + i)] = 0.0, -1.0, 0.0
    return places, count


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
