"""The few operations that plain Python can say but a compiler cannot guess: their two forms side by side."""

from __future__ import annotations

import ctypes
import math
from collections.abc import Callable
from typing import Any, TypeVar

Kernel = TypeVar("Kernel", bound=Callable[..., Any])


def inlined(function: Kernel) -> Kernel:
    """Mark a small kernel to be compiled into its caller, whose loop then vectorises."""
    function.inlined = True  # type: ignore[attr-defined]
    return function


def unit(function: Kernel) -> Kernel:
    """Mark a large kernel to be compiled once: others call its machine code, and do not become longer by it."""
    function.unit = True  # type: ignore[attr-defined]
    return function


def replaced(items: tuple[float, ...], index: int, value: float) -> tuple[float, ...]:
    """Return the tuple with one item replaced; compiled code keeps it in registers."""
    return (*items[:index], value, *items[index + 1 :])


def picked(condition: bool, yes: float, no: float) -> float:
    """Return one of two numbers; compiled code has both at hand, and takes no branch for one of them.

    A compiler makes a branch of ``yes if condition else no`` where one of them is read from memory, and of that branch
    vectors that are read and written by a mask, which takes many times as long.
    """
    return yes if condition else no


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


def advanced_at(function: float, x: Any, said: Any, width: int, steps: int) -> None:
    """Call a compiled ``f(x, said, width, steps)`` by its address: a block of orbits, some steps further.

    ``x`` and ``said`` are addresses, of numbers and of integers, see :func:`grazing.kernel.lanes.advancer`.
    """
    pointed[int(function)](x, said, width, steps)


def derived_at(function: float, state: tuple[float, ...], row: float, blank: tuple[float, ...]) -> Any:
    """Call a compiled ``f(state, row, found, said)`` by its address; return what it finds, as long as ``blank``.

    All four are addresses, of numbers and of two integers; so a step of any map is called.
    """
    found, said = list(blank), [0, 0]
    pointed[int(function)](state, numbers_at(row), found, said)
    return tuple(found), tuple(said)


#: Plain Python has no addresses of functions: there a function goes by its place in this list.
pointed: list[Callable[..., Any]] = []


def numbers_at(row: float) -> Any:
    """Return the numbers at an address, for reading."""
    return (ctypes.c_double * 1_000).from_address(int(row))


def room_of(value: Any) -> int:
    """Return how many numbers have the room that compiled code needs to write a value down; none in plain Python."""
    return 0


def written(place: Any, value: Any) -> None:
    """Write a value of any type down at the address of a number, for :func:`found_at` of code for the same machine."""


def found_at(place: Any, function: Callable[..., Any], p: Any) -> Any:
    """Return ``function(p)``, which was :func:`written` down at a place: compiled code reads it there."""
    return function(p)


def built(kind: Any, items: tuple[float, ...]) -> Any:
    """Build a named tuple of type ``kind`` from a plain tuple of its fields."""
    return kind(*items)


#: What stands for each primitive in compiled code, once it is asked for: see :func:`grazing.kernel.wide.forms`.
noted: dict[Callable[..., Any], Any] = {}


def compiled_form(primitive: Callable[..., Any]) -> Callable[[Callable[..., Any]], Any]:
    """Say what a primitive is in compiled code: ``define(context, *types) -> (signature, code)``, as numba wants it."""

    def register(define: Callable[..., Any]) -> Any:
        from numba.extending import intrinsic

        noted[primitive] = intrinsic(define)
        return noted[primitive]

    return register


def signatures() -> dict[str, Any]:
    """Return the types of functions that are called by address, see :func:`grazing.kernel.compile.address`."""
    from numba import types

    number, count, numbers = types.float64, types.int64, types.CPointer(types.float64)
    integers = types.CPointer(count)
    return {
        "value": number(number, numbers),
        "sweep": types.none(numbers, numbers, count, integers, count),
        "block": types.none(numbers, integers, count, count),
        "derivative": types.none(numbers, numbers, numbers, integers),
    }


def register() -> None:
    """Write down the compiled form of each primitive; numba is imported for it."""
    import operator

    from llvmlite import ir
    from numba import types
    from numba.extending import overload

    def by_name(p: Any, name: Any) -> Any:
        """Return a parameter by its name, p["A.V"]."""
        if not (isinstance(p, types.BaseNamedTuple) and isinstance(name, types.StringLiteral)):
            return None
        field = name.literal_value.replace(".", "_")
        if field not in p.fields:
            return None
        index = p.fields.index(field)

        def at_index(p: Any, name: Any) -> Any:
            return p[index]

        return at_index

    overload(operator.getitem, prefer_literal=True)(by_name)

    @compiled_form(replaced)
    def with_item(_context: Any, items: Any, index: Any, value: Any) -> Any:
        def code(_ctx: Any, builder: Any, _signature: Any, args: Any) -> Any:
            with builder.goto_entry_block():
                slot = builder.alloca(args[0].type)
            builder.store(args[0], slot)
            builder.store(args[2], builder.gep(slot, [args[1].type(0), args[1]], inbounds=True))
            return builder.load(slot)

        return items(items, index, items.dtype), code

    @compiled_form(picked)
    def selected(_context: Any, condition: Any, yes: Any, no: Any) -> Any:
        def code(_ctx: Any, builder: Any, _signature: Any, args: Any) -> Any:
            kept = [ir.Instruction(builder.block, each.type, "freeze", [each]) for each in args[1:]]
            for each in kept:
                builder._insert(each)
            return builder.select(args[0], *kept)

        return types.float64(types.boolean, types.float64, types.float64), code

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

    def at_address(context: Any, builder: Any, where: Any, signature: Any, args: Any) -> Any:
        """Call a compiled function by its address; what it raises, the caller raises too."""
        way = context.call_conv
        function = code_at(builder, where, way.get_function_type(signature.return_type, signature.args).as_pointer())
        status, found = way.call_function(builder, function, signature.return_type, signature.args, args)
        with builder.if_then(status.is_error, likely=False):
            way.return_status_propagate(builder, status)
        return found

    pointer = ir.DoubleType().as_pointer()
    takes = signatures()

    @compiled_form(called)
    def call_one(_context: Any, function: Any, v: Any, row: Any) -> Any:
        def code(ctx: Any, builder: Any, _signature: Any, args: Any) -> Any:
            return at_address(ctx, builder, args[0], takes["value"], [args[1], code_at(builder, args[2], pointer)])

        return types.float64(types.float64, types.float64, types.float64), code

    @compiled_form(called_for_all)
    def call_all(_context: Any, function: Any, work: Any, tables: Any, room: Any, runs: Any, many: Any) -> Any:
        def code(ctx: Any, builder: Any, _signature: Any, args: Any) -> Any:
            at_address(ctx, builder, args[0], takes["sweep"], args[1:])
            return ctx.get_dummy_value()

        return types.void(types.float64, work, tables, types.int64, runs, types.int64), code

    @compiled_form(advanced_at)
    def call_block(_context: Any, function: Any, x: Any, said: Any, width: Any, steps: Any) -> Any:
        def code(ctx: Any, builder: Any, _signature: Any, args: Any) -> Any:
            at_address(ctx, builder, args[0], takes["block"], args[1:])
            return ctx.get_dummy_value()

        return types.void(types.float64, x, said, types.int64, types.int64), code

    @compiled_form(derived_at)
    def call_step(_context: Any, function: Any, state: Any, row: Any, blank: Any) -> Any:
        pair = types.UniTuple(types.int64, 2)

        def code(ctx: Any, builder: Any, signature: Any, args: Any) -> Any:
            number, count = ir.DoubleType(), ir.IntType(64)
            kinds = ir.ArrayType(number, state.count), ir.ArrayType(number, blank.count), ir.ArrayType(count, 2)
            with builder.goto_entry_block():
                before, found, said = (builder.alloca(kind) for kind in kinds)
            builder.store(args[1], before)
            heads = [builder.bitcast(each, pointer) for each in (before, found)]
            given = heads[0], code_at(builder, args[2], pointer), heads[1], builder.bitcast(said, count.as_pointer())
            at_address(ctx, builder, args[0], takes["derivative"], given)
            return ctx.make_tuple(builder, signature.return_type, [builder.load(found), builder.load(said)])

        return types.Tuple((blank, pair))(types.float64, state, types.float64, blank), code

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

    @compiled_form(room_of)
    def counted(_context: Any, value: Any) -> Any:
        def code(ctx: Any, _builder: Any, _signature: Any, _args: Any) -> Any:
            return ir.Constant(ir.IntType(64), -(-ctx.get_abi_sizeof(ctx.get_value_type(value)) // 8))

        return types.int64(value), code

    @compiled_form(written)
    def write(_context: Any, place: Any, value: Any) -> Any:
        def code(ctx: Any, builder: Any, _signature: Any, args: Any) -> Any:
            builder.store(args[1], builder.bitcast(args[0], args[1].type.as_pointer()))
            return ctx.get_dummy_value()

        return types.void(place, value), code

    @compiled_form(found_at)
    def read(context: Any, place: Any, function: Any, p: Any) -> Any:
        kind = function.get_call_type(context, (p,), {}).return_type

        def code(ctx: Any, builder: Any, _signature: Any, args: Any) -> Any:
            return builder.load(builder.bitcast(args[0], ctx.get_value_type(kind).as_pointer()))

        return kind(place, function, p), code

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
