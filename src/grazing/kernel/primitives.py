"""The few operations that plain Python can say but a compiler cannot guess: their two forms side by side."""

from __future__ import annotations

import ctypes
import math
import os
from collections.abc import Callable
from typing import Any, TypeVar

Kernel = TypeVar("Kernel", bound=Callable[..., Any])


def inlined(function: Kernel) -> Kernel:
    """Mark a small kernel to be compiled into its caller, whose loop then vectorises."""
    function.inlined = True  # type: ignore[attr-defined]
    return function


def replaced(items: tuple[float, ...], index: int, value: float) -> tuple[float, ...]:
    """Return the tuple with one item replaced; compiled code keeps it in registers."""
    return (*items[:index], value, *items[index + 1 :])


def power_of_two(exponent: float) -> float:
    """Return 2**exponent for an integral exponent in [-1022, 1023]."""
    return math.ldexp(1.0, int(exponent))


def exponent_of(x: float) -> float:
    """Return the n for which 2**n <= x < 2**(n + 1), for x in [2**-1022, 2**1024)."""
    return math.frexp(x)[1] - 1.0


def at(index: int) -> int:
    """Return an index that is never negative: compiled code then need not ask whether to count from the end."""
    return index


def called(function: float, v: float, row: float) -> float:
    """Call a compiled ``f(v, row)`` by its address; ``row`` is the address of numbers.

    Addresses travel as floats, which hold them exactly (they are below 2^53), in tables of parameters.
    """
    return pointed[int(function)](v, numbers_at(row))  # type: ignore[no-any-return]


def called_for_all(function: float, work: Any, start: int, end: int, row: float) -> None:
    """Call a compiled ``f(work, start, end, row)`` by its address."""
    pointed[int(function)](work, start, end, numbers_at(row))


def transposed(work: Any, to: int, step: int, table: Any, where: int, plus: int) -> None:
    """Copy eight records of eight numbers from a table to rows of ``work``: number h of record k to place k of row h.

    The eight rows begin at ``to`` and lie ``step`` apart. ``work[where + k] + plus`` is where record k begins in the
    table, counted through all its rows. Compiled code reads and writes whole vectors.
    """
    numbers = table.reshape(-1)
    for k in range(8):
        record = int(work[where + k]) + plus
        for h in range(8):
            work[to + h * step + k] = numbers[record + h]


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


def filled(work: Any, i: int, value: float) -> None:
    """Write a number to eight neighbours; compiled code writes one vector."""
    work[i : i + 8] = value


def handed_back(
    work: Any, i: int, least: int, limit: int, sources: tuple[int, ...], targets: tuple[int, ...], place: int
) -> int:
    """Give those of eight neighbours that fall short their numbers back from lists; return where the lists go on.

    The other way of :func:`appended`: ``work[source + place]`` goes to ``work[target + i]``, and so on. Compiled code
    may read over eight places of a list.
    """
    for k in range(i, i + 8):
        if not work[least + k] >= work[limit + k]:
            for source, target in zip(sources, targets, strict=True):
                work[target + k] = work[source + place]
            place += 1
    return place


#: Plain Python has no addresses of functions: there a function goes by its place in this list.
pointed: list[Callable[..., Any]] = []


def numbers_at(row: float) -> Any:
    """Return the numbers at an address, for reading."""
    return (ctypes.c_double * 1_000).from_address(int(row))


def built(kind: Any, items: tuple[float, ...]) -> Any:
    """Build a named tuple of type ``kind`` from a plain tuple of its fields."""
    return kind(*items)


def _register() -> None:
    """Tell the compiler the second form of each primitive; importing numba here is the reason to be lazy."""
    from llvmlite import ir
    from numba.core import cgutils, types
    from numba.cpython.unsafe.tuple import tuple_setitem
    from numba.extending import intrinsic, overload

    @intrinsic  # type: ignore[untyped-decorator]
    def shifted_exponent(_context: Any, exponent: Any) -> Any:
        def code(_ctx: Any, builder: Any, _signature: Any, args: Any) -> Any:
            biased = builder.add(builder.fptosi(args[0], ir.IntType(64)), ir.Constant(ir.IntType(64), 1023))
            return builder.bitcast(builder.shl(biased, ir.Constant(ir.IntType(64), 52)), ir.DoubleType())

        return types.float64(exponent), code

    @intrinsic  # type: ignore[untyped-decorator]
    def biased_exponent(_context: Any, x: Any) -> Any:
        def code(_ctx: Any, builder: Any, _signature: Any, args: Any) -> Any:
            bits = builder.lshr(builder.bitcast(args[0], ir.IntType(64)), ir.Constant(ir.IntType(64), 52))
            return builder.sitofp(builder.sub(bits, ir.Constant(ir.IntType(64), 1023)), ir.DoubleType())

        return types.float64(types.float64), code

    @overload(replaced, strict=False)  # type: ignore[untyped-decorator]
    def _replaced(items: Any, index: Any, value: Any) -> Any:
        return lambda items, index, value: tuple_setitem(items, index, value)

    @overload(power_of_two, strict=False)  # type: ignore[untyped-decorator]
    def _power_of_two(exponent: Any) -> Any:
        return lambda exponent: shifted_exponent(exponent)

    @overload(exponent_of, strict=False)  # type: ignore[untyped-decorator]
    def _exponent_of(x: Any) -> Any:
        return lambda x: biased_exponent(x)

    def code_at(builder: Any, address: Any, kind: Any) -> Any:
        return builder.inttoptr(builder.fptosi(address, ir.IntType(64)), kind)

    number, numbers, count = ir.DoubleType(), ir.DoubleType().as_pointer(), ir.IntType(64)

    @intrinsic  # type: ignore[untyped-decorator]
    def call_one(_context: Any, function: Any, v: Any, row: Any) -> Any:
        def code(_ctx: Any, builder: Any, _signature: Any, args: Any) -> Any:
            kind = ir.FunctionType(number, [number, numbers]).as_pointer()
            return builder.call(code_at(builder, args[0], kind), [args[1], code_at(builder, args[2], numbers)])

        return types.float64(types.float64, types.float64, types.float64), code

    @intrinsic  # type: ignore[untyped-decorator]
    def call_all(_context: Any, function: Any, work: Any, start: Any, end: Any, row: Any) -> Any:
        def code(ctx: Any, builder: Any, signature: Any, args: Any) -> Any:
            kind = ir.FunctionType(ir.VoidType(), [numbers, count, count, numbers]).as_pointer()
            data = ctx.make_array(signature.args[1])(ctx, builder, args[1]).data
            where = code_at(builder, args[4], numbers)
            builder.call(code_at(builder, args[0], kind), [data, args[2], args[3], where])
            return ctx.get_dummy_value()

        return types.void(types.float64, work, types.int64, types.int64, types.float64), code

    @intrinsic  # type: ignore[untyped-decorator]
    def transposing(_context: Any, work: Any, to: Any, step: Any, table: Any, where: Any, plus: Any) -> Any:
        vector, places = ir.VectorType(number, 8), ir.VectorType(count, 8)

        def code(ctx: Any, builder: Any, signature: Any, args: Any) -> Any:
            out = ctx.make_array(signature.args[0])(ctx, builder, args[0]).data
            source = ctx.make_array(signature.args[3])(ctx, builder, args[3]).data

            def place(pointer: Any, index: Any) -> Any:
                return builder.bitcast(builder.gep(pointer, [index]), vector.as_pointer())

            def loaded(pointer: Any, index: Any) -> Any:
                found = builder.load(place(pointer, index))
                found.align = 8
                return found

            starts = builder.fptosi(loaded(out, args[4]), places)
            lanes = [builder.extract_element(starts, ir.Constant(ir.IntType(32), k)) for k in range(8)]
            rows = [loaded(source, builder.add(lane, args[5])) for lane in lanes]
            for size in (1, 2, 4):  # blocks of this size change places across the diagonal
                for k in range(8):
                    if k & size == 0:
                        a, b = rows[k], rows[k + size]
                        upper = [j + 8 - size if j & size else j for j in range(8)]
                        lower = [j + 8 if j & size else j + size for j in range(8)]
                        kinds = [ir.Constant(ir.VectorType(ir.IntType(32), 8), mask) for mask in (upper, lower)]
                        rows[k], rows[k + size] = (builder.shuffle_vector(a, b, kind) for kind in kinds)
            for h, row in enumerate(rows):
                at_row = builder.add(args[1], builder.mul(args[2], count(h)))
                builder.store(row, place(out, at_row)).align = 8
            return ctx.get_dummy_value()

        return types.void(work, types.int64, types.int64, table, types.int64, types.int64), code

    def gathered(builder: Any, name: str, values: Any, others: Any, mask: Any) -> Any:
        """Move the chosen numbers of a vector to its front (compress), or its first to the chosen places (expand)."""
        bits = ir.VectorType(ir.IntType(1), 8)
        kind = ir.FunctionType(values.type, [values.type, values.type, bits])
        function = cgutils.get_or_insert_function(builder.module, kind, f"llvm.x86.avx512.mask.{name}.v8f64")
        return builder.call(function, [values, others, mask])

    def moving(lists_to_places: bool) -> Any:
        """Return the code of :func:`handed_back`, or of :func:`appended`."""
        vector = ir.VectorType(number, 8)

        def code(ctx: Any, builder: Any, signature: Any, args: Any) -> Any:
            data = ctx.make_array(signature.args[0])(ctx, builder, args[0]).data
            vectors = "+avx512f" in ctx.codegen().magic_tuple()[2]

            def place_of(row: Any, index: Any) -> Any:
                return builder.gep(data, [builder.add(row, index)])

            def eight(row: Any, index: Any) -> Any:
                return builder.bitcast(place_of(row, index), vector.as_pointer())

            def loaded(row: Any, index: Any) -> Any:
                found = builder.load(eight(row, index))
                found.align = 8
                return found

            mask = builder.fcmp_unordered("ult", loaded(args[2], args[1]), loaded(args[3], args[1]))
            sources = [builder.extract_value(args[4], n) for n in range(signature.args[4].count)]
            targets = [builder.extract_value(args[5], n) for n in range(signature.args[5].count)]
            end = args[6]
            if vectors:
                for source, target in zip(sources, targets, strict=True):
                    if lists_to_places:
                        value = gathered(builder, "expand", loaded(source, end), loaded(target, args[1]), mask)
                    else:
                        value = gathered(builder, "compress", loaded(source, args[1]), loaded(source, args[1]), mask)
                    builder.store(value, eight(target, args[1] if lists_to_places else end)).align = 8
                bits = builder.zext(builder.bitcast(mask, ir.IntType(8)), count)
                return builder.add(end, builder.ctpop(bits))
            for k in range(8):
                here, chosen = (
                    builder.add(args[1], count(k)),
                    builder.extract_element(mask, ir.Constant(ir.IntType(32), k)),
                )
                for source, target in zip(sources, targets, strict=True):
                    if lists_to_places:
                        old, new = (builder.load(place_of(*at)) for at in ((target, here), (source, end)))
                        builder.store(builder.select(chosen, new, old), place_of(target, here))
                    else:
                        builder.store(builder.load(place_of(source, here)), place_of(target, end))
                end = builder.add(end, builder.zext(chosen, count))
            return end

        return code

    @intrinsic  # type: ignore[untyped-decorator]
    def appending(_c: Any, work: Any, i: Any, least: Any, limit: Any, sources: Any, targets: Any, place: Any) -> Any:
        return types.int64(work, types.int64, types.int64, types.int64, sources, targets, types.int64), moving(False)

    @intrinsic  # type: ignore[untyped-decorator]
    def returning(_c: Any, work: Any, i: Any, least: Any, limit: Any, sources: Any, targets: Any, place: Any) -> Any:
        return types.int64(work, types.int64, types.int64, types.int64, sources, targets, types.int64), moving(True)

    @overload(appended, strict=False)  # type: ignore[untyped-decorator]
    def _appended(work: Any, i: Any, least: Any, limit: Any, sources: Any, targets: Any, place: Any) -> Any:
        return lambda work, i, least, limit, sources, targets, place: appending(
            work, i, least, limit, sources, targets, place
        )

    @intrinsic  # type: ignore[untyped-decorator]
    def filling(_context: Any, work: Any, i: Any, value: Any) -> Any:
        vector = ir.VectorType(number, 8)

        def code(ctx: Any, builder: Any, signature: Any, args: Any) -> Any:
            data = ctx.make_array(signature.args[0])(ctx, builder, args[0]).data
            first = builder.insert_element(ir.Constant(vector, ir.Undefined), args[2], ir.Constant(ir.IntType(32), 0))
            same = ir.Constant(ir.VectorType(ir.IntType(32), 8), [0] * 8)
            place = builder.bitcast(builder.gep(data, [args[1]]), vector.as_pointer())
            builder.store(builder.shuffle_vector(first, first, same), place).align = 8
            return ctx.get_dummy_value()

        return types.void(work, types.int64, types.float64), code

    @overload(filled, strict=False)  # type: ignore[untyped-decorator]
    def _filled(work: Any, i: Any, value: Any) -> Any:
        return lambda work, i, value: filling(work, i, value)

    @overload(handed_back, strict=False)  # type: ignore[untyped-decorator]
    def _handed_back(work: Any, i: Any, least: Any, limit: Any, sources: Any, targets: Any, place: Any) -> Any:
        return lambda work, i, least, limit, sources, targets, place: returning(
            work, i, least, limit, sources, targets, place
        )

    @overload(transposed, strict=False)  # type: ignore[untyped-decorator]
    def _transposed(work: Any, to: Any, step: Any, table: Any, where: Any, plus: Any) -> Any:
        return lambda work, to, step, table, where, plus: transposing(work, to, step, table, where, plus)

    @overload(called, strict=False)  # type: ignore[untyped-decorator]
    def _called(function: Any, v: Any, row: Any) -> Any:
        return lambda function, v, row: call_one(function, v, row)

    @overload(called_for_all, strict=False)  # type: ignore[untyped-decorator]
    def _called_for_all(function: Any, work: Any, start: Any, end: Any, row: Any) -> Any:
        return lambda function, work, start, end, row: call_all(function, work, start, end, row)

    @intrinsic  # type: ignore[untyped-decorator]
    def named(_context: Any, kind: Any, items: Any) -> Any:
        result = types.NamedUniTuple(items.dtype, items.count, kind.instance_class)

        def code(_ctx: Any, _builder: Any, _signature: Any, args: Any) -> Any:
            return args[1]

        return result(kind, items), code

    @intrinsic  # type: ignore[untyped-decorator]
    def unsigned(_context: Any, index: Any) -> Any:
        def code(_ctx: Any, _builder: Any, _signature: Any, args: Any) -> Any:
            return args[0]

        return types.uint64(types.int64), code

    @overload(at, strict=False)  # type: ignore[untyped-decorator]
    def _at(index: Any) -> Any:
        return lambda index: unsigned(index)

    @overload(built, strict=False)  # type: ignore[untyped-decorator]
    def _built(kind: Any, items: Any) -> Any:
        return lambda kind, items: named(kind, items)


if os.environ.get("NUMBA_DISABLE_JIT", "0") in ("", "0"):
    _register()
