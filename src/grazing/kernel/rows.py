"""Rows (p, q, r) asked of pairs (x, y): where is p x + (q y + r) less than a limit? Both forms of each question.

``work`` and ``table`` are what :func:`grazing.kernel.primitives.numbers` returns. Row n of a list has p at ``at + n``
in the table, and q and r ``step`` and ``2 * step`` further on. Of pairs, ``x`` and ``y`` say where their numbers begin
in ``work``. Compiled code may look at up to seven rows and pairs too many, and write as many places over the end.
"""

from __future__ import annotations

import os
from typing import Any

from grazing.kernel.primitives import compiled_form


def failing(table: Any, at: int, step: int, count: int, x: float, y: float, limit: float) -> int:
    """Return which of up to 62 rows a pair fails: bit n is set where not p x + (q y + r) >= limit for row n."""
    bits = 0
    for n in range(count):
        p, q, r = table[at + n], table[at + step + n], table[at + 2 * step + n]
        if not p * x + (q * y + r) >= limit:
            bits |= 1 << n
    return bits


def passing(table: Any, at: int, step: int, count: int, x: float, y: float, limit: float) -> bool:
    """Return whether a pair passes all rows; behind them must stand seven more that every pair passes."""
    for n in range(count):
        p, q, r = table[at + n], table[at + step + n], table[at + 2 * step + n]
        if not p * x + (q * y + r) >= limit:
            return False
    return True


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
        work[limit + i] = least if least < high else float("nan")
        bits = failing(table, at, step, count, u, v, work[limit + i])
        work[found + i] = table[at + 3 * step + first_bit(bits)] if bits else 0.0


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
        work[need + i] = (least if least < high else float("nan")) - table[aside] * u


def first_bit(bits: int) -> int:
    """Return the place of the lowest bit that is set; of any, if none is."""
    return (bits & -bits).bit_length() - 1


def _register() -> None:
    """Write down the compiled form of each; importing numba here is the reason to be lazy."""
    from llvmlite import ir
    from numba.core import cgutils, types

    from grazing.kernel.simd import (
        Held,
        Memory,
        bits_of,
        constant,
        counted,
        equal,
        in_groups,
        whole,
        width_for,
    )  # fmt: skip

    n = types.int64

    def further(builder: Any, place: Any, step: Any, count: int) -> Any:
        """Return a place so many steps further on."""
        return builder.add(place, builder.mul(step, whole(count)))

    def failures(context: Any, builder: Any, args: Any) -> Any:
        """Return the mask of the rows from the n-th on that a pair fails, as a function of n."""
        table, at, step, _count, x, y, limit = args
        rows = Memory(builder, table, width_for(context))
        x, y, limit = (equal(builder, value, rows.kind.count) for value in (x, y, limit))

        def fails(n: Any) -> Any:
            p, q, r = (rows.load(further(builder, builder.add(at, n), step, k)) for k in range(3))
            return (p * x + (q * y + r)).below(limit)

        return fails, rows.kind.count

    @compiled_form(failing)
    def asking(_c: Any, table: Any, at: Any, step: Any, count: Any, x: Any, y: Any, limit: Any) -> Any:
        def code(context: Any, builder: Any, _signature: Any, args: Any) -> Any:
            fails, width = failures(context, builder, args)
            found = cgutils.alloca_once_value(builder, whole(0))
            with counted(builder, whole(0), args[3], width) as row:
                bits = builder.shl(bits_of(builder, fails(row)), row)
                builder.store(builder.or_(builder.load(found), bits), found)
            none_beyond = builder.sub(builder.shl(whole(1), args[3]), whole(1))
            return builder.and_(builder.load(found), none_beyond)

        return types.int64(table, n, n, n, *(types.float64,) * 3), code

    @compiled_form(passing)
    def judging(_c: Any, table: Any, at: Any, step: Any, count: Any, x: Any, y: Any, limit: Any) -> Any:
        def code(context: Any, builder: Any, _signature: Any, args: Any) -> Any:
            fails, width = failures(context, builder, args)
            none = ir.Constant(ir.VectorType(ir.IntType(1), width), [0] * width)
            failed = cgutils.alloca_once_value(builder, none)
            with counted(builder, whole(0), args[3], width) as row:
                builder.store(builder.or_(builder.load(failed), fails(row)), failed)
            return builder.icmp_signed("==", bits_of(builder, builder.load(failed)), whole(0))

        return types.boolean(table, n, n, n, *(types.float64,) * 3), code

    def either(builder: Any, upright: Any, body: Any) -> None:
        """Write a body for tables that are upright, and one for others."""
        with builder.if_else(builder.icmp_signed("!=", upright, whole(0))) as (then, otherwise):
            with then:
                body(True)
            with otherwise:
                body(False)

    def limits(builder: Any, numbers: Any, margin: Any, high: Any) -> Any:
        """Return the limit of a pair as a function of it."""
        m0, m1, m2 = (numbers.everywhere(builder.add(margin, whole(k))) for k in range(3))
        width = numbers.kind.count
        high, nothing = equal(builder, high, width), constant(builder, float("nan"), width)

        def limit(u: Any, v: Any) -> Any:
            found = m0 + (m1 * abs(u) + m2 * abs(v))
            return found.where(builder.fcmp_ordered("<", found.value, high.value), nothing)

        return limit

    @compiled_form(first_failed)
    def searching(
        _c: Any, work: Any, start: Any, end: Any, x: Any, y: Any, limit: Any, found: Any, table: Any, margin: Any,
        high: Any, at: Any, step: Any, count: Any, upright: Any,
    ) -> Any:  # fmt: skip
        def code(context: Any, builder: Any, _signature: Any, args: Any) -> Any:
            work, start, end, x, y, limit, found, table, margin, high, at, step, count, upright = args
            width = width_for(context)
            lanes, rows = Memory(builder, work, width), Memory(builder, table, width)
            limit_of = limits(builder, rows, margin, high)
            last = builder.and_(builder.sub(count, whole(1)), whole(-4))  # of the groups of four rows

            def search(upright: bool) -> None:
                def body(places: list[Any]) -> None:
                    xs, ys = ([lanes.load(builder.add(row, i)) for i in places] for row in (x, y))
                    limits = [limit_of(u, v) for u, v in zip(xs, ys, strict=True)]
                    for i, least in zip(places, limits, strict=True):
                        lanes.store(least, builder.add(limit, i))
                    if upright:
                        limits = [least - u for least, u in zip(limits, xs, strict=True)]
                    first = [Held(constant(builder, 0.0, width)) for _ in places]
                    with cgutils.for_range_slice(builder, last, whole(-1), whole(-4), inc=False) as (row, _count):
                        for k in (3, 2, 1, 0):
                            here = builder.add(at, builder.add(row, whole(k)))
                            p, q, r, place = (rows.everywhere(further(builder, here, step, h)) for h in range(4))
                            for u, v, least, held in zip(xs, ys, limits, first, strict=True):
                                height = q * v + r if upright else p * u + (q * v + r)
                                passed = builder.fcmp_ordered(">=", height.value, least.value)
                                held.set(held.get().where(passed, place))
                    for i, held in zip(places, first, strict=True):
                        lanes.store(held.get(), builder.add(found, i))

                in_groups(builder, start, end, width, 8 // width, body)

            either(builder, upright, search)
            return context.get_dummy_value()

        return types.void(work, n, n, n, n, n, n, table, n, types.float64, n, n, n, n), code

    @compiled_form(all_passed)
    def testing(
        _c: Any, work: Any, start: Any, end: Any, x: Any, y: Any, need: Any, free: Any, table: Any, at: Any, step: Any,
        count: Any, upright: Any,
    ) -> Any:  # fmt: skip
        def code(context: Any, builder: Any, _signature: Any, args: Any) -> Any:
            work, start, end, x, y, need, free, table, at, step, count, upright = args
            width = width_for(context)
            lanes, rows = Memory(builder, work, width), Memory(builder, table, width)
            yes, no = constant(builder, 1.0, width), constant(builder, -1.0, width)

            def test(upright: bool) -> None:
                def body(places: list[Any]) -> None:
                    xs, ys, needs = ([lanes.load(builder.add(row, i)) for i in places] for row in (x, y, need))
                    lows = [Held(constant(builder, float("inf"), width)) for _ in places]
                    with counted(builder, whole(0), count, 4) as row:
                        for k in range(4):
                            here = builder.add(at, builder.add(row, whole(k)))
                            p, q, r = (rows.everywhere(further(builder, here, step, h)) for h in range(3))
                            for u, v, low in zip(xs, ys, lows, strict=True):
                                height = q * v + r if upright else p * u + (q * v + r)
                                low.set(height.lower(low.get()))
                    for i, low, least in zip(places, lows, needs, strict=True):
                        passed = builder.fcmp_ordered(">=", low.get().value, least.value)
                        lanes.store(yes.where(passed, no), builder.add(free, i))

                in_groups(builder, start, end, width, 3, body)

            either(builder, upright, test)
            return context.get_dummy_value()

        return types.void(work, n, n, n, n, n, n, table, n, n, n, n), code

    @compiled_form(carried)
    def carrying(
        _c: Any, work: Any, start: Any, end: Any, x: Any, y: Any, need: Any, table: Any, to: Any, margin: Any,
        high: Any, aside: Any,
    ) -> Any:  # fmt: skip
        def code(context: Any, builder: Any, _signature: Any, args: Any) -> Any:
            work, start, end, x, y, need, table, to, margin, high, aside = args
            width = width_for(context)
            lanes, numbers = Memory(builder, work, width), Memory(builder, table, width)
            s0, a00, a01, s1, a10, a11 = (numbers.everywhere(builder.add(to, whole(k))) for k in range(6))
            limit, weight = limits(builder, numbers, margin, high), numbers.everywhere(aside)
            with counted(builder, start, end, width) as i:
                u, v = (lanes.load(builder.add(row, i)) for row in (x, y))
                u, v = a00 * u + (a01 * v + s0), a10 * u + (a11 * v + s1)
                for lane, row in ((u, x), (v, y), (limit(u, v) - weight * u, need)):
                    lanes.store(lane, builder.add(row, i))
            return context.get_dummy_value()

        return types.void(work, n, n, n, n, n, table, n, n, types.float64, n), code

    @compiled_form(first_bit)
    def counting(_context: Any, bits: Any) -> Any:
        def code(_ctx: Any, builder: Any, _signature: Any, args: Any) -> Any:
            return builder.cttz(args[0], ir.Constant(ir.IntType(1), 0))

        return types.int64(types.int64), code


if os.environ.get("NUMBA_DISABLE_JIT", "0") in ("", "0"):
    _register()
