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
    from numba.core import types
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
