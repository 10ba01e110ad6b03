"""Operations on eight numbers at a time that a compiler does not find by itself: their two forms side by side.

``work`` and ``table`` are what :func:`grazing.kernel.primitives.numbers` returns.
"""

from __future__ import annotations

import os
from typing import Any

from grazing.kernel.primitives import compiled_form


def transposed(work: Any, to: int, step: int, table: Any, where: int, plus: int) -> None:
    """Copy eight records of four numbers from a table to rows of ``work``: number h of record k to place k of row h.

    The four rows begin at ``to`` and lie ``step`` apart. ``work[where + k] + plus`` is where record k begins in the
    table. Compiled code reads and writes whole vectors.
    """
    for k in range(8):
        record = int(work[where + k]) + plus
        for h in range(4):
            work[to + h * step + k] = table[record + h]


def filled(work: Any, i: int, value: float) -> None:
    """Write a number to eight neighbours; compiled code writes one vector."""
    work[i : i + 8] = value


def appended(
    work: Any, i: int, least: int, limit: int, sources: tuple[int, ...], targets: tuple[int, ...], place: int
) -> int:
    """Append those of eight neighbours that fall short to lists; return how long the lists are then.

    Of the eight places from ``i`` on those count where ``work[least + i] >= work[limit + i]`` does not hold. Their
    numbers ``work[source + i]`` go to ``work[target + place]``. Compiled code may write over eight places of a list.
    """
    for k in range(i, i + 8):
        if not work[least + k] >= work[limit + k]:
            for source, target in zip(sources, targets, strict=True):
                work[target + place] = work[source + k]
            place += 1
    return place


def handed_back(
    work: Any, i: int, least: int, limit: int, sources: tuple[int, ...], targets: tuple[int, ...], lower: int,
    lowest: int, place: int,
) -> int:  # fmt: skip
    """Give those of eight neighbours that fall short their numbers back from lists; return where the lists go on.

    The other way of :func:`appended`: ``work[source + place]`` goes to ``work[target + i]``, and so on; and
    ``work[lower + place]`` to ``work[lowest + i]`` where it is lower. Compiled code may read over eight places of a
    list.
    """
    for k in range(i, i + 8):
        if not work[least + k] >= work[limit + k]:
            for source, target in zip(sources, targets, strict=True):
                work[target + k] = work[source + place]
            work[lowest + k] = min(work[lowest + k], work[lower + place])
            place += 1
    return place


def failing(table: Any, at: int, step: int, count: int, x: float, y: float, limit: float) -> int:
    """Return which of up to 62 rows a pair fails: bit n is set where not p x + (q y + r) >= limit for row n.

    Row n has p at ``at + n`` in the table, and q and r ``step`` and ``2 * step`` further on. Compiled code reads up to
    seven rows too many.
    """
    bits = 0
    for n in range(count):
        p, q, r = table[at + n], table[at + step + n], table[at + 2 * step + n]
        if not p * x + (q * y + r) >= limit:
            bits |= 1 << n
    return bits


def passing(table: Any, at: int, step: int, count: int, x: float, y: float, limit: float) -> bool:
    """Return whether a pair passes all rows, as in :func:`failing`; any number of them.

    Compiled code looks at up to seven rows more: there must be some that every pair passes.
    """
    for n in range(count):
        p, q, r = table[at + n], table[at + step + n], table[at + 2 * step + n]
        if not p * x + (q * y + r) >= limit:
            return False
    return True


def first_failed(
    work: Any, x: int, y: int, limit: int, found: int, table: Any, at: int, step: int, count: int, upright: int
) -> None:
    """Find the first row that each of eight pairs fails, as in :func:`failing`.

    The pairs are ``work[x + k], work[y + k]``, their limits ``work[limit + k]``. ``work[found + k]`` gets the number
    that stands ``3 * step`` after the p of that row, 0 if there is none. ``upright`` promises p = 1 in all rows.
    """
    for k in range(8):
        bits = failing(table, at, step, count, work[x + k], work[y + k], work[limit + k])
        work[found + k] = table[at + 3 * step + first_bit(bits)] if bits else 0.0


def first_bit(bits: int) -> int:
    """Return the place of the lowest bit that is set; of any, if none is."""
    return (bits & -bits).bit_length() - 1


def _register() -> None:
    """Write down the compiled form of each; importing numba here is the reason to be lazy."""
    from llvmlite import ir
    from numba.core import cgutils, types

    number, whole, short = ir.DoubleType(), ir.IntType(64), ir.IntType(32)

    def features(ctx: Any) -> str:
        """Return what the processor that is compiled for can do."""
        return str(ctx.codegen().magic_tuple()[2])

    class Row:
        """Vectors of ``width`` numbers in a row of memory."""

        def __init__(self, builder: Any, data: Any, width: int) -> None:
            self.builder, self.data, self.kind = builder, data, ir.VectorType(number, width)

        def place(self, index: Any) -> Any:
            return self.builder.bitcast(self.builder.gep(self.data, [index]), self.kind.as_pointer())

        def load(self, index: Any) -> Any:
            found = self.builder.load(self.place(index))
            found.align = 8
            return found

        def store(self, value: Any, index: Any) -> None:
            self.builder.store(value, self.place(index)).align = 8

    def same_in_all(builder: Any, value: Any, width: int) -> Any:
        """Return a vector of equal numbers."""
        first = builder.insert_element(ir.Constant(ir.VectorType(number, width), ir.Undefined), value, short(0))
        return builder.shuffle_vector(first, first, ir.Constant(ir.VectorType(short, width), [0] * width))

    def bits_of(builder: Any, mask: Any) -> Any:
        """Return a vector of truths as the bits of a number."""
        return builder.zext(builder.bitcast(mask, ir.IntType(mask.type.count)), whole)

    @compiled_form(transposed)
    def transposing(_context: Any, work: Any, to: Any, step: Any, table: Any, where: Any, plus: Any) -> Any:
        def code(ctx: Any, builder: Any, signature: Any, args: Any) -> Any:
            work = args[0]
            out, source = Row(builder, work, 4), Row(builder, args[3], 4)
            starts = builder.fptosi(Row(builder, work, 8).load(args[4]), ir.VectorType(whole, 8))
            for half in (0, 4):
                lanes = [builder.extract_element(starts, short(half + k)) for k in range(4)]
                rows = [source.load(builder.add(lane, args[5])) for lane in lanes]
                for size in (1, 2):  # blocks of this size change places across the diagonal
                    for k in (0, 3 - size):
                        pair = rows[k], rows[k + size]
                        for h, first in ((k, 0), (k + size, size)):
                            order = [first + j % size + j // size % 2 * 4 + j // (2 * size) * 2 for j in range(4)]
                            kind = ir.Constant(ir.VectorType(short, 4), order)
                            rows[h] = builder.shuffle_vector(*pair, kind)
                for h, row in enumerate(rows):
                    out.store(row, builder.add(args[1], builder.add(builder.mul(args[2], whole(h)), whole(half))))
            return ctx.get_dummy_value()

        return types.void(work, types.int64, types.int64, table, types.int64, types.int64), code

    @compiled_form(filled)
    def filling(_context: Any, work: Any, i: Any, value: Any) -> Any:
        def code(ctx: Any, builder: Any, signature: Any, args: Any) -> Any:
            row = Row(builder, args[0], 8)
            row.store(same_in_all(builder, args[2], 8), args[1])
            return ctx.get_dummy_value()

        return types.void(work, types.int64, types.float64), code

    def height_of(builder: Any, rows: Any, place: Any, step: Any, x: Any, y: Any) -> Any:
        """Return what a pair has in the rows from a place on."""
        p, q, r = (rows.load(builder.add(place, builder.mul(step, whole(k)))) for k in range(3))
        return builder.fadd(builder.fmul(p, x), builder.fadd(builder.fmul(q, y), r))

    @compiled_form(failing)
    def asking(_c: Any, table: Any, at: Any, step: Any, count: Any, x: Any, y: Any, limit: Any) -> Any:
        def code(ctx: Any, builder: Any, signature: Any, args: Any) -> Any:
            width = 8 if "+avx512f" in features(ctx) else 4
            rows = Row(builder, args[0], width)
            x, y, limit = (same_in_all(builder, value, width) for value in args[4:7])
            found = cgutils.alloca_once_value(builder, whole(0))
            with cgutils.for_range_slice(builder, whole(0), args[3], whole(width)) as (n, _count):
                height = height_of(builder, rows, builder.add(args[1], n), args[2], x, y)
                bits = bits_of(builder, builder.fcmp_unordered("ult", height, limit))
                builder.store(builder.or_(builder.load(found), builder.shl(bits, n)), found)
            none_beyond = builder.sub(builder.shl(whole(1), args[3]), whole(1))
            return builder.and_(builder.load(found), none_beyond)

        numbers = (types.float64,) * 3
        return types.int64(table, types.int64, types.int64, types.int64, *numbers), code

    @compiled_form(passing)
    def judging(_c: Any, table: Any, at: Any, step: Any, count: Any, x: Any, y: Any, limit: Any) -> Any:
        def code(ctx: Any, builder: Any, signature: Any, args: Any) -> Any:
            width = 8 if "+avx512f" in features(ctx) else 4
            rows = Row(builder, args[0], width)
            x, y, limit = (same_in_all(builder, value, width) for value in args[4:7])
            none = ir.Constant(ir.VectorType(ir.IntType(1), width), [0] * width)
            failed = cgutils.alloca_once_value(builder, none)
            with cgutils.for_range_slice(builder, whole(0), args[3], whole(width)) as (n, _count):
                height = height_of(builder, rows, builder.add(args[1], n), args[2], x, y)
                fails = builder.fcmp_unordered("ult", height, limit)
                builder.store(builder.or_(builder.load(failed), fails), failed)
            return builder.icmp_signed("==", bits_of(builder, builder.load(failed)), whole(0))

        numbers = (types.float64,) * 3
        return types.boolean(table, types.int64, types.int64, types.int64, *numbers), code

    @compiled_form(first_failed)
    def searching(
        _c: Any, work: Any, x: Any, y: Any, limit: Any, found: Any, table: Any, at: Any, step: Any, count: Any,
        upright: Any,
    ) -> Any:  # fmt: skip
        def code(ctx: Any, builder: Any, signature: Any, args: Any) -> Any:
            width = 8 if "+avx512f" in features(ctx) else 4
            lanes = Row(builder, args[0], width)
            table, last = args[5], builder.sub(args[8], whole(1))

            def search(upright: bool) -> None:
                places = [whole(k) for k in range(0, 8, width)]
                x, y, limit = ([lanes.load(builder.add(row, place)) for place in places] for row in args[1:4])
                if upright:
                    limit = [builder.fsub(*both) for both in zip(limit, x, strict=True)]
                found = [cgutils.alloca_once_value(builder, ir.Constant(lanes.kind, [0.0] * width)) for _ in places]
                with cgutils.for_range_slice(builder, last, whole(-1), whole(-1), inc=False) as (n, _count):
                    row = builder.add(args[6], n)
                    p, q, r, place = (
                        same_in_all(
                            builder,
                            builder.load(builder.gep(table, [builder.add(row, builder.mul(args[7], whole(h)))])),
                            width,
                        )
                        for h in range(4)
                    )
                    for k in range(len(places)):
                        height = builder.fadd(builder.fmul(q, y[k]), r)
                        if not upright:
                            height = builder.fadd(builder.fmul(p, x[k]), height)
                        passed = builder.fcmp_ordered(">=", height, limit[k])
                        builder.store(builder.select(passed, builder.load(found[k]), place), found[k])
                for k in range(len(places)):
                    lanes.store(builder.load(found[k]), builder.add(args[4], places[k]))

            with builder.if_else(builder.icmp_signed("!=", args[9], whole(0))) as (then, otherwise):
                with then:
                    search(True)
                with otherwise:
                    search(False)
            return ctx.get_dummy_value()

        n = types.int64
        return types.void(work, n, n, n, n, table, n, n, n, n), code

    @compiled_form(first_bit)
    def counting(_context: Any, bits: Any) -> Any:
        def code(_ctx: Any, builder: Any, _signature: Any, args: Any) -> Any:
            return builder.cttz(args[0], ir.Constant(ir.IntType(1), 0))

        return types.int64(types.int64), code

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

    def parts(ctx: Any, builder: Any, work: Any) -> Any:
        """Return rows of numbers as vectors as wide as the processor's, and how many make eight numbers."""
        able = features(ctx)
        width = 8 if "+avx512f" in able else 4 if "+avx2" in able else 1
        return Row(builder, work, width), range(0, 8, width)

    def short_ones(builder: Any, rows: Any, here: Any, least: Any, limit: Any) -> Any:
        """Return which places of a vector fall short, as truths and as bits."""
        mask = builder.fcmp_unordered("ult", *(rows.load(builder.add(row, here)) for row in (least, limit)))
        return mask, bits_of(builder, mask)

    def moved(builder: Any, value: Any, kept: Any, mask: Any, bits: Any, lists_to_places: bool) -> Any:
        """Return numbers moved to the front of a vector, or from there to the chosen places."""
        if mask.type.count == 8:
            return by_instruction(builder, "expand" if lists_to_places else "compress", value, kept, mask)
        if mask.type.count == 4:
            return by_permutation(builder, value, order_of(builder, bits, lists_to_places))
        return value

    @compiled_form(appended)
    def appending(_c: Any, work: Any, i: Any, least: Any, limit: Any, sources: Any, targets: Any, place: Any) -> Any:
        def code(ctx: Any, builder: Any, signature: Any, args: Any) -> Any:
            rows, firsts = parts(ctx, builder, args[0])
            end = args[6]
            for first in firsts:
                here = builder.add(args[1], whole(first))
                mask, bits = short_ones(builder, rows, here, args[2], args[3])
                for n in range(signature.args[4].count):
                    source, target = (builder.extract_value(both, n) for both in args[4:6])
                    value = rows.load(builder.add(source, here))
                    rows.store(moved(builder, value, value, mask, bits, False), builder.add(target, end))
                end = builder.add(end, builder.ctpop(bits))
            return end

        return types.int64(work, types.int64, types.int64, types.int64, sources, targets, types.int64), code

    @compiled_form(handed_back)
    def returning(
        _c: Any, work: Any, i: Any, least: Any, limit: Any, sources: Any, targets: Any, lower: Any, lowest: Any,
        place: Any,
    ) -> Any:  # fmt: skip
        def code(ctx: Any, builder: Any, signature: Any, args: Any) -> Any:
            rows, firsts = parts(ctx, builder, args[0])
            end = args[8]
            for first in firsts:
                here = builder.add(args[1], whole(first))
                mask, bits = short_ones(builder, rows, here, args[2], args[3])
                tuples = range(signature.args[4].count)
                pairs = [tuple(builder.extract_value(both, n) for both in args[4:6]) for n in tuples]
                for source, target in (*pairs, (args[6], args[7])):
                    goal = builder.add(target, here)
                    kept, value = rows.load(goal), rows.load(builder.add(source, end))
                    if rows.kind.count == 4:  # or the store below becomes a masked one, which is slow
                        kept = builder.asm(ir.FunctionType(rows.kind, [rows.kind]), "", "=x,0", [kept], False)
                    value = moved(builder, value, kept, mask, bits, True)
                    if source is args[6]:
                        value = builder.select(builder.fcmp_ordered("<", value, kept), value, kept)
                    rows.store(builder.select(mask, value, kept), goal)
                end = builder.add(end, builder.ctpop(bits))
            return end

        n = types.int64
        return types.int64(work, n, n, n, sources, targets, n, n, n), code


if os.environ.get("NUMBA_DISABLE_JIT", "0") in ("", "0"):
    _register()
