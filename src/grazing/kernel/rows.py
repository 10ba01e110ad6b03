"""Rows (p, q, r) asked of pairs (x, y): where p x + (q y + r) is less than a limit.

``work`` and ``table`` are what :func:`grazing.kernel.primitives.numbers` returns. Row n of a list has p at ``at + n``
in the table, and q and r ``step`` and ``2 * step`` further on. Of pairs, ``x`` and ``y`` say where their numbers begin
in ``work``. Two have a wide form in :mod:`grazing.kernel.wide.rows`: it may look at up to seven pairs too many, and
write as many places over the end.
"""

from __future__ import annotations

from typing import Any

from grazing.kernel.primitives import exponent_of, inlined

NAN = float("nan")


@inlined
def failing(table: Any, at: int, step: int, count: int, x: float, y: float, limit: float) -> int:
    """Return which of up to 62 rows a pair fails: bit n is set where not p x + (q y + r) >= limit for row n."""
    bits = 0
    for n in range(count):
        p, q, r = table[at + n], table[at + step + n], table[at + 2 * step + n]
        if not p * x + (q * y + r) >= limit:
            bits |= 1 << n
    return bits


@inlined
def passing(table: Any, at: int, step: int, count: int, x: float, y: float, limit: float) -> bool:
    """Return whether a pair passes all rows: each is asked, so that they are asked side by side."""
    passes = True
    for n in range(count):
        p, q, r = table[at + n], table[at + step + n], table[at + 2 * step + n]
        passes &= p * x + (q * y + r) >= limit
    return passes


@inlined
def first_failed(
    work: Any, start: int, end: int, x: int, y: int, limit: int, found: int, table: Any, margin: int, high: float,
    at: int, step: int, count: int, upright: int,
) -> None:  # fmt: skip
    """Find the limits of the pairs from ``start`` to ``end``, and the first row that each of them fails.

    Where (m0, m1, m2) stand at ``margin``, ``work[limit + i]`` gets m0 + (m1 |x| + m2 |y|), not a number if that is not
    below ``high``. ``work[found + i]`` gets the number that stands ``3 * step`` after the p of the row, 0 if there is
    none. ``upright`` promises p = 1 in all rows; behind them must stand three more that every pair passes.
    """
    for i in range(start, end):
        u, v = work[x + i], work[y + i]
        least = table[margin] + (table[margin + 1] * abs(u) + table[margin + 2] * abs(v))
        least = least if least < high else NAN
        work[limit + i], work[found + i] = least, 0.0
        least = least - u if upright else least
        for n in range(at, at + count):
            height = table[n + step] * v + table[n + 2 * step]
            height = height if upright else table[n] * u + height
            if not height >= least:
                work[found + i] = table[n + 3 * step]
                break


@inlined
def all_passed(
    work: Any, start: int, end: int, x: int, y: int, need: int, free: int, table: Any, at: int, step: int, count: int,
    upright: int,
) -> None:  # fmt: skip
    """Ask the pairs from ``start`` to ``end`` all rows: ``work[free + i]`` gets 1 for those that pass, else -1.

    What a pair needs is ``work[need + i]``: of p x + (q y + r), or, if ``upright``, of q y + r. There are a multiple of
    four rows. A row that is not a number may count as passed, but not if what is needed is none, either.
    """
    for i in range(start, end):
        u, v, passes = 0.0 if upright else work[x + i], work[y + i], work[need + i] == work[need + i]
        for n in range(at, at + count):
            passes &= not table[n] * u + (table[n + step] * v + table[n + 2 * step]) < work[need + i]
        work[free + i] = 1.0 if passes else -1.0


@inlined
def carried(
    work: Any, start: int, end: int, x: int, y: int, need: int, table: Any, to: int, margin: int, high: float,
    aside: int,
) -> None:  # fmt: skip
    """Take the pairs from ``start`` to ``end`` through a map, and find what they need.

    At ``to`` stands the map, row by row: x goes to a x + (b y + s), and y so, too. ``work[need + i]`` gets the limit
    of :func:`first_failed` less ``table[aside]`` times x.
    """
    s0, a00, a01, s1, a10, a11 = table[to], table[to + 1], table[to + 2], table[to + 3], table[to + 4], table[to + 5]
    for i in range(start, end):
        u, v = work[x + i], work[y + i]
        u, v = a00 * u + (a01 * v + s0), a10 * u + (a11 * v + s1)
        work[x + i], work[y + i] = u, v
        least = table[margin] + (table[margin + 1] * abs(u) + table[margin + 2] * abs(v))
        work[need + i] = (least if least < high else NAN) - table[aside] * u


@inlined
def first_bit(bits: int) -> int:
    """Return the place of the lowest bit that is set; of any, if none is."""
    return int(exponent_of(float(bits & -bits)))
