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


def numbers(array: Any) -> Any:
    """Return the numbers of an array one after the other; compiled code gets their address.

    An address knows neither how many numbers there are nor whose they are: reading costs one instruction, and half as
    long to compile. The array must be kept by who calls.
    """
    return array.reshape(-1)


def behind(items: Any, count: int) -> Any:
    """Return the numbers from place ``count`` on, which others may look at before."""
    return items[count:]


def called(function: float, v: float, row: float) -> float:
    """Call a compiled ``f(v, row)`` by its address; ``row`` is the address of numbers.

    Addresses travel as floats, which hold them exactly (they are below 2^53), in tables of parameters.
    """
    return pointed[int(function)](v, numbers_at(row))  # type: ignore[no-any-return]


def called_for_all(function: float, work: Any, tables: Any, room: int, runs: Any, count: int) -> None:
    """Call a compiled ``f(work, tables, room, runs, count)`` by its address: once for many numbers, and many rows."""
    pointed[int(function)](work, tables, room, runs, count)


#: Plain Python has no addresses of functions: there a function goes by its place in this list.
pointed: list[Callable[..., Any]] = []


def numbers_at(row: float) -> Any:
    """Return the numbers at an address, for reading."""
    return (ctypes.c_double * 1_000).from_address(int(row))


def built(kind: Any, items: tuple[float, ...]) -> Any:
    """Build a named tuple of type ``kind`` from a plain tuple of its fields."""
    return kind(*items)


#: What stands for each primitive in compiled code.
forms: dict[Callable[..., Any], Any] = {}


def compiled_form(primitive: Callable[..., Any]) -> Callable[[Callable[..., Any]], Any]:
    """Say what a primitive is in compiled code: ``define(context, *types) -> (signature, code)``, as numba wants it."""

    def register(define: Callable[..., Any]) -> Any:
        from numba.extending import intrinsic

        forms[primitive] = intrinsic(define)
        return forms[primitive]

    return register


def _register() -> None:
    """Write down the compiled form of each primitive; importing numba here is the reason to be lazy."""
    from llvmlite import ir
    from numba.core import types
    from numba.cpython.unsafe.tuple import tuple_setitem

    forms[replaced] = tuple_setitem

    @compiled_form(power_of_two)
    def shifted_exponent(_context: Any, exponent: Any) -> Any:
        def code(_ctx: Any, builder: Any, _signature: Any, args: Any) -> Any:
            biased = builder.add(builder.fptosi(args[0], ir.IntType(64)), ir.Constant(ir.IntType(64), 1023))
            return builder.bitcast(builder.shl(biased, ir.Constant(ir.IntType(64), 52)), ir.DoubleType())

        return types.float64(exponent), code

    @compiled_form(exponent_of)
    def biased_exponent(_context: Any, x: Any) -> Any:
        def code(_ctx: Any, builder: Any, _signature: Any, args: Any) -> Any:
            bits = builder.lshr(builder.bitcast(args[0], ir.IntType(64)), ir.Constant(ir.IntType(64), 52))
            return builder.sitofp(builder.sub(bits, ir.Constant(ir.IntType(64), 1023)), ir.DoubleType())

        return types.float64(types.float64), code

    def code_at(builder: Any, address: Any, kind: Any) -> Any:
        return builder.inttoptr(builder.fptosi(address, ir.IntType(64)), kind)

    number, pointer, count = ir.DoubleType(), ir.DoubleType().as_pointer(), ir.IntType(64)

    @compiled_form(called)
    def call_one(_context: Any, function: Any, v: Any, row: Any) -> Any:
        def code(_ctx: Any, builder: Any, _signature: Any, args: Any) -> Any:
            kind = ir.FunctionType(number, [number, pointer]).as_pointer()
            return builder.call(code_at(builder, args[0], kind), [args[1], code_at(builder, args[2], pointer)])

        return types.float64(types.float64, types.float64, types.float64), code

    @compiled_form(called_for_all)
    def call_all(_context: Any, function: Any, work: Any, tables: Any, room: Any, runs: Any, many: Any) -> Any:
        def code(ctx: Any, builder: Any, _signature: Any, args: Any) -> Any:
            kind = ir.FunctionType(ir.VoidType(), [pointer, pointer, count, count.as_pointer(), count]).as_pointer()
            builder.call(code_at(builder, args[0], kind), args[1:])
            return ctx.get_dummy_value()

        return types.void(types.float64, work, tables, types.int64, runs, types.int64), code

    @compiled_form(numbers_at)
    def pointer_to(_context: Any, row: Any) -> Any:
        def code(_ctx: Any, builder: Any, _signature: Any, args: Any) -> Any:
            return code_at(builder, args[0], pointer)

        return types.CPointer(types.float64)(types.float64), code

    @compiled_form(numbers)
    def address(_context: Any, array: Any) -> Any:
        def code(ctx: Any, builder: Any, signature: Any, args: Any) -> Any:
            return ctx.make_array(signature.args[0])(ctx, builder, args[0]).data

        return types.CPointer(array.dtype)(array), code

    @compiled_form(behind)
    def further(_context: Any, items: Any, count: Any) -> Any:
        def code(_ctx: Any, builder: Any, _signature: Any, args: Any) -> Any:
            return builder.gep(args[0], [args[1]])

        return items(items, types.int64), code

    @compiled_form(built)
    def named(_context: Any, kind: Any, items: Any) -> Any:
        result = types.NamedUniTuple(items.dtype, items.count, kind.instance_class)

        def code(_ctx: Any, _builder: Any, _signature: Any, args: Any) -> Any:
            return args[1]

        return result(kind, items), code

    @compiled_form(at)
    def unsigned(_context: Any, index: Any) -> Any:
        def code(_ctx: Any, _builder: Any, _signature: Any, args: Any) -> Any:
            return args[0]

        return types.uint64(types.int64), code


if os.environ.get("NUMBA_DISABLE_JIT", "0") in ("", "0"):
    _register()
