"""Lists of some of many numbers, made and given back, and records turned into rows: both forms of each.

``work`` and ``table`` are what :func:`grazing.kernel.primitives.numbers` returns. Compiled code moves whole vectors: it
may read and write up to seven places over an end.
"""

from __future__ import annotations

import os
from typing import Any

from grazing.kernel.primitives import compiled_form

#: Added to a number it rounds it to a whole one, whose bits are then the last ones.
WHOLE, WHOLE_BITS = 6755399441055744.0, 0x4338000000000000


def transposed(work: Any, to: int, step: int, table: Any, where: int, plus: int) -> None:
    """Copy eight records of four numbers from a table to rows of ``work``: number h of record k to place k of row h.

    The four rows begin at ``to`` and lie ``step`` apart. ``work[where + k] - WHOLE + plus`` is where record k begins in
    the table.
    """
    for k in range(8):
        record = int(work[where + k] - WHOLE) + plus
        for h in range(4):
            work[to + h * step + k] = table[record + h]


def filled(work: Any, start: int, end: int, value: float) -> None:
    """Write a number to all places from ``start`` to ``end``."""
    for i in range(start, end):
        work[i] = value


def spread(work: Any, start: int, end: int, to: int, step: int, table: Any, at: int, count: int) -> None:
    """Write number h of a table to all places from ``start`` to ``end`` of row h: the rows lie ``step`` apart."""
    for i in range(start, end):
        for h in range(count):
            work[to + h * step + i] = table[at + h]


def appended(
    work: Any, start: int, end: int, free: int, sources: tuple[int, ...], targets: tuple[int, ...], place: int
) -> int:
    """Append those that are not free to lists; return how long the lists are then.

    Of the places from ``start`` to ``end`` those count where ``work[free + i]`` is negative. Their numbers
    ``work[source + i]`` go to ``work[target + place]``. Where compiled code looks over the end, all must be free.
    """
    for i in range(start, end):
        if work[free + i] < 0.0:
            for source, target in zip(sources, targets, strict=True):
                work[target + place] = work[source + i]
            place += 1
    return place


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
            for source, target in zip(sources, targets, strict=True):
                work[target + i] = work[source + place]
            work[lowest + i] = min(work[lowest + i], work[lower + place])
            place += 1


def combined(
    out: Any, to: int, count: int, work: Any, x: int, y: int, table: Any, at: int, plus: float
) -> None:  # fmt: skip
    """Write ``plus + (a + (b x + c y))`` for so many pairs to ``out``; a, b, c stand at ``at`` in a table."""
    a, b, c = table[at], table[at + 1], table[at + 2]
    for i in range(count):
        out[to + i] = plus + (a + (b * work[x + i] + c * work[y + i]))


def made_whole(out: Any, to: int, count: int, work: Any, start: int) -> None:
    """Write so many whole numbers to ``out``, which holds integers."""
    for i in range(count):
        out[to + i] = int(work[start + i])


def repeated(out: Any, to: int, count: int, start: int) -> None:
    """Write so many numbers of ``out`` once more, to another place."""
    for i in range(count):
        out[to + i] = out[start + i]


def _register() -> None:
    """Write down the compiled form of each; importing numba here is the reason to be lazy."""
    from llvmlite import ir
    from numba.core import cgutils, types

    from grazing.kernel.simd import (
        Lanes,
        Memory,
        bits_of,
        constant,
        counted,
        equal,
        features,
        in_all,
        short,
        whole,
        width_for,
    )  # fmt: skip

    n = types.int64

    @compiled_form(transposed)
    def transposing(_context: Any, work: Any, to: Any, step: Any, table: Any, where: Any, plus: Any) -> Any:
        def code(context: Any, builder: Any, signature: Any, args: Any) -> Any:
            out, source = Memory(builder, args[0], 4), Memory(builder, args[3], 4)
            bits = builder.bitcast(args[0], whole.as_pointer())
            for half in (0, 4):
                lanes = [builder.load(builder.gep(bits, [builder.add(args[4], whole(half + k))])) for k in range(4)]
                less = builder.sub(args[5], whole(WHOLE_BITS))
                rows = [source.load(builder.add(lane, less)).value for lane in lanes]
                for size in (1, 2):  # blocks of this size change places across the diagonal
                    for k in (0, 3 - size):
                        pair = rows[k], rows[k + size]
                        for h, first in ((k, 0), (k + size, size)):
                            order = [first + j % size + j // size % 2 * 4 + j // (2 * size) * 2 for j in range(4)]
                            kind = ir.Constant(ir.VectorType(short, 4), order)
                            rows[h] = builder.shuffle_vector(*pair, kind)
                for h, row in enumerate(rows):
                    place = builder.add(builder.mul(args[2], whole(h)), whole(half))
                    out.store(Lanes(builder, row), builder.add(args[1], place))
            return context.get_dummy_value()

        return types.void(work, n, n, table, n, n), code

    @compiled_form(filled)
    def filling(_context: Any, work: Any, start: Any, end: Any, value: Any) -> Any:
        def code(context: Any, builder: Any, _signature: Any, args: Any) -> Any:
            work, start, end, value = args
            width = width_for(context)
            with counted(builder, start, end, width) as i:
                Memory(builder, work, width).store(equal(builder, value, width), i)
            return context.get_dummy_value()

        return types.void(work, n, n, types.float64), code

    @compiled_form(spread)
    def spreading(_c: Any, work: Any, start: Any, end: Any, to: Any, step: Any, table: Any, at: Any, count: Any) -> Any:
        def code(context: Any, builder: Any, _signature: Any, args: Any) -> Any:
            work, start, end, to, step, table, at, count = args
            width = width_for(context)
            lanes, numbers = Memory(builder, work, width), Memory(builder, table, width)
            with counted(builder, start, end, width) as i, counted(builder, whole(0), count, 1) as h:
                place = builder.add(builder.add(to, i), builder.mul(h, step))
                lanes.store(numbers.everywhere(builder.add(at, h)), place)
            return context.get_dummy_value()

        return types.void(work, n, n, n, n, table, n, n), code

    def by_instruction(builder: Any, name: str, values: Any, others: Any, mask: Any) -> Any:
        """Move the chosen of eight numbers to the front (compress), or the first to the chosen places (expand)."""
        kind = ir.FunctionType(values.type, [values.type, values.type, mask.type])
        function = cgutils.get_or_insert_function(builder.module, kind, f"llvm.x86.avx512.mask.{name}.v8f64")
        return builder.call(function, [values, others, mask])

    def by_permutation(builder: Any, values: Any, order: Any) -> Any:
        """Put four numbers in an order, given as that of their eight halves."""
        halves, orders = ir.VectorType(ir.FloatType(), 8), ir.VectorType(short, 8)
        kind = ir.FunctionType(halves, [halves, orders])
        function = cgutils.get_or_insert_function(builder.module, kind, "llvm.x86.avx2.permps")
        return builder.bitcast(builder.call(function, [builder.bitcast(values, halves), order]), values.type)

    def order_of(builder: Any, bits: Any, lists_to_places: bool) -> Any:
        """Return the order in which four numbers are moved, for those that are chosen."""
        orders = []
        for chosen in range(16):
            places = [k for k in range(4) if chosen >> k & 1]
            if lists_to_places:
                lanes = [places.index(k) if k in places else 0 for k in range(4)]
            else:
                lanes = (places + [0] * 4)[:4]
            orders.append([half for lane in lanes for half in (2 * lane, 2 * lane + 1)])
        kind = ir.ArrayType(ir.ArrayType(short, 8), 16)
        name = f"orders_{int(lists_to_places)}"
        table = builder.module.globals.get(name) or cgutils.global_constant(builder, name, ir.Constant(kind, orders))
        place = builder.gep(table, [whole(0), bits, whole(0)])
        found = builder.load(builder.bitcast(place, ir.VectorType(short, 8).as_pointer()))
        found.align = 4
        return found

    def memory(context: Any, builder: Any, work: Any) -> Any:
        """Return the numbers as vectors as wide as those that the processor can permute."""
        able = features(context)
        return Memory(builder, work, 8 if "+avx512f" in able else 4 if "+avx2" in able else 1)

    def bound(builder: Any, rows: Any, place: Any) -> Any:
        """Return which places of a vector are not free, as truths and as bits."""
        found = rows.load(place).value
        mask = builder.fcmp_ordered("<", found, ir.Constant(rows.kind, [0.0] * rows.kind.count))
        return mask, bits_of(builder, mask)

    def moved(builder: Any, value: Any, kept: Any, mask: Any, bits: Any, lists_to_places: bool) -> Any:
        """Return numbers moved to the front of a vector, or from there to the chosen places."""
        if mask.type.count == 8:
            name = "expand" if lists_to_places else "compress"
            return Lanes(builder, by_instruction(builder, name, value.value, kept.value, mask))
        if mask.type.count == 4:
            return Lanes(builder, by_permutation(builder, value.value, order_of(builder, bits, lists_to_places)))
        return value

    @compiled_form(appended)
    def appending(_c: Any, work: Any, start: Any, end: Any, free: Any, sources: Any, targets: Any, place: Any) -> Any:
        def code(context: Any, builder: Any, signature: Any, args: Any) -> Any:
            work, start, end, free, sources, targets, place = args
            rows, length = memory(context, builder, work), cgutils.alloca_once_value(builder, place)
            with counted(builder, start, end, rows.kind.count) as i:
                mask, bits = bound(builder, rows, builder.add(free, i))
                here = builder.load(length)
                for k in range(signature.args[4].count):
                    source, target = (builder.extract_value(both, k) for both in (sources, targets))
                    value = rows.load(builder.add(source, i))
                    rows.store(moved(builder, value, value, mask, bits, False), builder.add(target, here))
                builder.store(builder.add(here, builder.ctpop(bits)), length)
            return builder.load(length)

        return types.int64(work, n, n, n, sources, targets, n), code

    @compiled_form(handed_back)
    def returning(
        _c: Any, work: Any, start: Any, end: Any, free: Any, sources: Any, targets: Any, lower: Any, lowest: Any,
        place: Any,
    ) -> Any:  # fmt: skip
        def code(context: Any, builder: Any, signature: Any, args: Any) -> Any:
            work, start, end, free, sources, targets, lower, lowest, place = args
            rows, length = memory(context, builder, work), cgutils.alloca_once_value(builder, place)
            with counted(builder, start, end, rows.kind.count) as i:
                mask, bits = bound(builder, rows, builder.add(free, i))
                here = builder.load(length)
                pairs = [
                    tuple(builder.extract_value(both, k) for both in (sources, targets))
                    for k in range(signature.args[4].count)
                ]
                for source, target in (*pairs, (lower, lowest)):
                    goal = builder.add(target, i)
                    kept, value = rows.load(goal), rows.load(builder.add(source, here))
                    if rows.kind.count == 4:  # or the store below becomes a masked one, which is slow
                        kind = ir.FunctionType(rows.kind, [rows.kind])
                        kept = Lanes(builder, builder.asm(kind, "", "=x,0", [kept.value], False))
                    value = moved(builder, value, kept, mask, bits, True)
                    value = value.lower(kept) if source is lower else value
                    rows.store(value.where(mask, kept), goal)
                builder.store(builder.add(here, builder.ctpop(bits)), length)
            return context.get_dummy_value()

        return types.void(work, n, n, n, sources, targets, n, n, n), code

    @compiled_form(combined)
    def combining(
        _c: Any, out: Any, to: Any, count: Any, work: Any, x: Any, y: Any, table: Any, at: Any, plus: Any
    ) -> Any:
        def code(context: Any, builder: Any, _signature: Any, args: Any) -> Any:
            out, to, count, work, x, y, table, at, plus = args

            def body(i: Any, width: int) -> None:
                pairs, numbers = Memory(builder, work, width), Memory(builder, table, width)
                a, b, c = (numbers.everywhere(builder.add(at, whole(k))) for k in range(3))
                u, v = (pairs.load(builder.add(row, i)) for row in (x, y))
                value = equal(builder, plus, width) + (a + (b * u + c * v))
                Memory(builder, out, width).store(value, builder.add(to, i))

            in_all(builder, count, width_for(context), body)
            return context.get_dummy_value()

        return types.void(out, n, n, work, n, n, table, n, types.float64), code

    @compiled_form(made_whole)
    def wholes(_c: Any, out: Any, to: Any, count: Any, work: Any, start: Any) -> Any:
        def code(context: Any, builder: Any, _signature: Any, args: Any) -> Any:
            out, to, count, work, start = args

            def body(i: Any, width: int) -> None:
                value = Memory(builder, work, width).load(builder.add(start, i)) + constant(builder, WHOLE, width)
                kind = ir.VectorType(whole, width)
                bits = builder.sub(builder.bitcast(value.value, kind), ir.Constant(kind, [WHOLE_BITS] * width))
                place = builder.bitcast(builder.gep(out, [builder.add(to, i)]), kind.as_pointer())
                builder.store(bits, place).align = 8

            in_all(builder, count, width_for(context), body)
            return context.get_dummy_value()

        return types.void(out, n, n, work, n), code

    @compiled_form(repeated)
    def repeating(_c: Any, out: Any, to: Any, count: Any, start: Any) -> Any:
        def code(context: Any, builder: Any, _signature: Any, args: Any) -> Any:
            out, to, count, start = args
            address = builder.bitcast(out, ir.DoubleType().as_pointer())  # whatever the eight bytes are

            def body(i: Any, width: int) -> None:
                memory = Memory(builder, address, width)
                memory.store(memory.load(builder.add(start, i)), builder.add(to, i))

            in_all(builder, count, width_for(context), body)
            return context.get_dummy_value()

        return types.void(out, n, n, n), code


if os.environ.get("NUMBA_DISABLE_JIT", "0") in ("", "0"):
    _register()
