"""Lists of some of many numbers, made and given back, and records turned into rows.

``work`` and ``table`` are what :func:`grazing.kernel.primitives.numbers` returns. Two have a wide
form in :mod:`grazing.kernel.wide.vectors`.
"""

from __future__ import annotations

from typing import Any

from grazing.kernel.primitives import inlined

#: Added to a number it rounds it to a whole one, whose bits are then the last ones.
WHOLE, WHOLE_BITS = 6755399441055744.0, 0x4338000000000000


@inlined
def transposed(work: Any, to: int, step: int, table: Any, where: int, plus: int) -> None:
    """Copy eight records of four numbers from a table to rows of ``work``: number h of record k to place k of row h.

    The four rows begin at ``to`` and lie ``step`` apart. ``work[where + k] - WHOLE + plus`` is where record k begins in
    the table.
    """
    for k in range(8):
        record = int(work[where + k] - WHOLE) + plus
        for h in range(4):
            work[to + h * step + k] = table[record + h]


@inlined
def listed(work: Any, to: int, flags: int, first: float) -> int:
    """Write the numbers of those of eight places to a list where a flag is above 0, and return how many there are.

    The number of place k is ``first + k``. What is written is eight numbers long; those behind the list mean nothing.
    """
    n = 0
    for k in range(8):
        work[to + n] = first + k
        n += 1 if work[flags + k] > 0.0 else 0
    return n


@inlined
def spread(work: Any, start: int, end: int, to: int, step: int, table: Any, at: int, count: int) -> None:
    """Write number h of a table to all places from ``start`` to ``end`` of row h: the rows lie ``step`` apart."""
    for i in range(start, end):
        for h in range(count):
            work[to + h * step + i] = table[at + h]


@inlined
def appended(
    work: Any, start: int, end: int, free: int, sources: tuple[int, ...], targets: tuple[int, ...], place: int
) -> int:
    """Append those that are not free to lists; return how long the lists are then.

    Of the places from ``start`` to ``end`` those count where ``work[free + i]`` is negative. Their numbers
    ``work[source + i]`` go to ``work[target + place]``.
    """
    for i in range(start, end):
        if work[free + i] < 0.0:
            for k in range(len(sources)):
                work[targets[k] + place] = work[sources[k] + i]
            place += 1
    return place


@inlined
def handed_back(
    work: Any, start: int, end: int, free: int, sources: tuple[int, ...], targets: tuple[int, ...], lower: int,
    lowest: int, place: int,
) -> None:  # fmt: skip
    """Give those that are not free their numbers back from lists.

    The other way of :func:`appended`: ``work[source + place]`` goes to ``work[target + i]``, and so on; and
    ``work[lower + place]`` to ``work[lowest + i]`` where it is lower.
    """
    for i in range(start, end):
        if work[free + i] < 0.0:
            for k in range(len(sources)):
                work[targets[k] + i] = work[sources[k] + place]
            work[lowest + i] = min(work[lowest + i], work[lower + place])
            place += 1


@inlined
def combined(
    out: Any, to: int, count: int, work: Any, x: int, y: int, table: Any, at: int, plus: float
) -> None:  # fmt: skip
    """Write ``plus + (a + (b x + c y))`` for so many pairs to ``out``; a, b, c stand at ``at`` in a table."""
    a, b, c = table[at], table[at + 1], table[at + 2]
    for i in range(count):
        out[to + i] = plus + (a + (b * work[x + i] + c * work[y + i]))


@inlined
def made_whole(out: Any, to: int, count: int, work: Any, start: int) -> None:
    """Write so many whole numbers to ``out``, which holds integers."""
    for i in range(count):
        out[to + i] = int(work[start + i])


@inlined
def repeated(out: Any, to: int, count: int, start: int) -> None:
    """Write so many numbers of ``out`` once more, to another place."""
    for i in range(count):
        out[to + i] = out[start + i]
