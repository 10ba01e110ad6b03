"""Questions to the certificate: who flies free, and where the others hit.

A row (p, q, r) is asked whether p c1 + q c2 + r >= margin. Where p = 1 in all rows of a table (*upright*: free flights
that never change sign) c1 goes to the other side, which saves a product a row. Loops may run over their end, where
nothing is kept yet.
"""

from __future__ import annotations

from typing import Any

from grazing.kernel.primitives import behind, inlined, unit
from grazing.kernel.rows import all_passed, carried, failing, first_bit, first_failed, passing
from grazing.kernel.vectors import appended, spread
from grazing.oscillator.cells import (
    ALPHA,
    CERTIFICATE,
    CONSTANTS,
    COUNT,
    LAST,
    LISTED,
    MARGIN,
    MAX_ROWS,
    ONWARD,
    ROW_COUNT,
    ROWS,
    TABLED,
    UPRIGHT,
    row_from,
)  # fmt: skip
from grazing.oscillator.workspace import AWAKE, HIGH, WHOSE, WIDTH, W


@inlined
def onward(w: Any, tables: Any, room: int, runs: Any, awake: int, stride: int) -> None:
    """Take all pairs over to the next period.

    NEED gets what all rows must reach: the margin, less c1 where that is in no row; NaN where a row could overflow.
    """
    for n in range(awake):
        q = runs[AWAKE + n]
        t = behind(tables, q * room)
        carried(w, q * stride, (q + 1) * stride, W.C1, W.C2, W.NEED, t, ONWARD, MARGIN, HIGH, UPRIGHT)


@unit
def certify(w: Any, tables: Any, room: int, runs: Any, awake: int, stride: int, starts: int) -> None:
    """Ask the certificate about all orbits: FREE gets 1 where there is provably no impact in the period, else -1.

    It gets 1 as well where there is no orbit, and in columns that have no table.
    """
    for n in range(awake):
        q = runs[AWAKE + n]
        t, first = behind(tables, q * room), q * stride
        rows, upright = int(t[COUNT]), int(t[UPRIGHT])
        all_passed(w, first, first + stride, W.C1, W.C2, W.NEED, W.FREE, t, CERTIFICATE, MAX_ROWS, rows, upright)
        for i in range(first + starts if t[TABLED] > 0.0 else first, first + stride):
            w[W.FREE + i] = 1.0


@inlined
def locate(w: Any, tables: Any, room: int, runs: Any, count: int) -> None:
    """Find the margins of the pairs at hand, and the first rows that they fail; and :func:`describe` them.

    DOUBT gets the margins, EVENT the places of the rows, 0 where there is none. Results of a run may be
    written over by the next.
    """
    for n in range(count):
        t = behind(tables, runs[WHOSE + n] * room)
        rows, upright = int(t[ROW_COUNT]), int(t[UPRIGHT])
        first_failed(
            w, runs[n], runs[n + 1], W.X1, W.X2, W.DOUBT, W.EVENT, t, MARGIN, HIGH, ROWS, MAX_ROWS, rows, upright
        )
        spread(w, runs[n], runs[n + 1], W.A, WIDTH, t, ALPHA, CONSTANTS)


@inlined
def describe(w: Any, tables: Any, room: int, runs: Any, count: int) -> None:
    """Write the constants of its column to each place."""
    for n in range(count):
        t = behind(tables, runs[WHOSE + n] * room)
        spread(w, runs[n], runs[n + 1], W.A, WIDTH, t, ALPHA, CONSTANTS)  # what runs over the end is for the next run


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
    end, row = ROWS + int(t[ROW_COUNT]), ROWS
    if since > 0.0:
        row = row_from(t, int(t[LISTED + min((int(since) - 1) // 2, int(t[LAST]))]), since)
    row = first_failing(t, row, end, x, y, limit)
    return t[row + 3 * MAX_ROWS] if row < end else 0.0


@inlined
def certify_rest(w: Any, tables: Any, room: int, runs: Any, count: int) -> int:
    """Ask the certificate about the rest of the period after each impact; list those that do not fly free in REST."""
    left = 0
    for n in range(count):
        t = behind(tables, runs[WHOSE + n] * room)
        rows = int(t[COUNT])
        for i in range(runs[n], runs[n + 1]):
            since, margin = int(w[W.THEN + i]), w[W.WIDER + i]
            passes = passing(t, CERTIFICATE + since, MAX_ROWS, rows - since, w[W.Z1 + i], w[W.Z2 + i], margin)
            w[W.REST + left] = float(i)
            left += 0 if passes & (margin < HIGH) else 1
    return left


@inlined
def candidates(w: Any, runs: Any, awake: int, stride: int) -> tuple[int, int]:
    """Put the orbits that the certificate did not settle to the impacts at hand; return how many, and their runs."""
    places, count = 0, 0
    for n in range(awake):
        q = runs[AWAKE + n]
        runs[count], runs[WHOSE + count] = places, q
        places = appended(
            w, q * stride, (q + 1) * stride, W.FREE, (W.C1, W.C2, W.NUMBER), (W.X1, W.X2, W.ORBIT), places
        )
        count += 1 if places > runs[count] else 0
    runs[count] = places
    for base in range(0, places, 64):
        for k in range(64):
            i = base + k
            w[W.BACK + i], w[W.MET + i] = -1.0, 0.0
    return places, count


@inlined
def count_hits(w: Any, runs: Any, awake: int, columns: int, stride: int) -> None:
    """Say of all orbits that they hit once, or, where the certificate settles it, not at all.

    The columns of the second wall, beyond ``columns``, say 2: so a letter spells an impact with it.
    """
    for n in range(awake):
        first = runs[AWAKE + n] * stride
        once = 1.0 if runs[AWAKE + n] < columns else 2.0
        for i in range(first, first + stride):
            w[W.HITS + i] = 0.0 if w[W.FREE + i] > 0.0 else once


@inlined
def runs_of(w: Any, places: int, runs: Any) -> int:
    """Find the runs of equal columns among the impacts at hand: where each begins, and which; return their number."""
    count, last = 0, -1.0
    for k in range(places):
        runs[count], runs[WHOSE + count] = k, int(w[W.COLUMN + k])
        count += 1 if w[W.COLUMN + k] != last else 0
        last = w[W.COLUMN + k]
    runs[count] = places
    return count
