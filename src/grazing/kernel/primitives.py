"""The few operations that plain Python can say but a compiler cannot guess: their two forms side by side."""

from __future__ import annotations

import math
import os
from typing import Any


def replaced(items: tuple[float, ...], index: int, value: float) -> tuple[float, ...]:
    """Return the tuple with one item replaced; compiled code keeps it in registers."""
    return (*items[:index], value, *items[index + 1 :])


def power_of_two(exponent: float) -> float:
    """Return 2**exponent for an integral exponent in [-1022, 1023]."""
    return math.ldexp(1.0, int(exponent))


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

    @overload(replaced, strict=False)  # type: ignore[untyped-decorator]
    def _replaced(items: Any, index: Any, value: Any) -> Any:
        return lambda items, index, value: tuple_setitem(items, index, value)

    @overload(power_of_two, strict=False)  # type: ignore[untyped-decorator]
    def _power_of_two(exponent: Any) -> Any:
        return lambda exponent: shifted_exponent(exponent)

    @intrinsic  # type: ignore[untyped-decorator]
    def named(_context: Any, kind: Any, items: Any) -> Any:
        result = types.NamedUniTuple(items.dtype, items.count, kind.instance_class)

        def code(_ctx: Any, _builder: Any, _signature: Any, args: Any) -> Any:
            return args[1]

        return result(kind, items), code

    @overload(built, strict=False)  # type: ignore[untyped-decorator]
    def _built(kind: Any, items: Any) -> Any:
        return lambda kind, items: named(kind, items)


if os.environ.get("NUMBA_DISABLE_JIT", "0") in ("", "0"):
    _register()
