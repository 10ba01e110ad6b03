"""The compiled forms of the questions to rows.

They may look at up to seven pairs too many, and write as many places over the end.
"""

from __future__ import annotations

from typing import Any

from numba import types

from grazing.kernel.primitives import compiled_form
from grazing.kernel.private import cgutils
from grazing.kernel.rows import all_passed, first_failed
from grazing.kernel.wide.simd import Held, Memory, constant, counted, equal, in_groups, whole, width_for

n = types.int64


def further(builder: Any, place: Any, step: Any, count: int) -> Any:
    """Return a place so many steps further on."""
    return builder.add(place, builder.mul(step, whole(count)))


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
def _searching(
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
def _testing(
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
