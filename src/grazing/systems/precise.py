"""A user's kernels in many digits: the same source, its floats and functions of ``math`` those of ball arithmetic."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import BuiltinFunctionType, CellType, FunctionType, SimpleNamespace
from typing import Any

from flint import arb, ctx

from grazing.kernel.content import named
from grazing.pool import LOCK

#: Bits of precision: differences of the fourth order over 2**-50 are good to 60 digits.
BITS = 512
STEP = 2.0**-50


def _of(method: str) -> Callable[..., Any]:
    return lambda x, *others: getattr(arb(x), method)(*others)


def _whole(power: Any) -> Any:
    return int(power) if isinstance(power, float) and power.is_integer() else power


#: What stands for a function of ``math``.
BALLS: dict[str, Any] = {
    name: _of(name)
    for name in ("sin", "cos", "tan", "exp", "log", "sqrt", "sinh", "cosh", "tanh", "asin", "acos", "atan", "expm1",
                 "log1p", "floor", "ceil")
} | {
    "fabs": abs,
    "pow": lambda x, y: arb(x) ** _whole(y),
    "atan2": lambda y, x: arb.atan2(arb(y), arb(x)),
    "hypot": lambda x, y: (arb(x) * x + arb(y) * y).sqrt(),
}  # fmt: skip


@contextmanager
def digits() -> Iterator[None]:
    """Let ball arithmetic have many digits for a while; no other thread has fewer or more in that time."""
    with LOCK, ctx.workprec(BITS):
        yield


def in_balls(function: Callable[..., Any]) -> Callable[..., Any]:
    """Return a copy of a kernel that works with balls; what it cannot do there it raises when it is called."""
    return _seen(function, {})  # type: ignore[no-any-return]


def _seen(value: Any, known: dict[Any, Any]) -> Any:
    if value is math:
        return SimpleNamespace(**{**vars(math), **BALLS})
    if isinstance(value, BuiltinFunctionType) and value in vars(math).values():
        return BALLS.get(str(value.__name__), value)
    if not isinstance(value, FunctionType):
        return value
    if value not in known:
        names: dict[str, Any] = {"__builtins__": value.__globals__.get("__builtins__")}
        cells = tuple(CellType(_seen(cell.cell_contents, known)) for cell in value.__closure__ or ())
        copy = FunctionType(value.__code__, names, value.__name__, value.__defaults__, cells)
        copy.__kwdefaults__ = value.__kwdefaults__
        known[value] = copy
        names.update({name: _seen(item, known) for name, item in named(value).items()})
    return known[value]


def balls(values: Any) -> tuple[Any, ...]:
    """Return doubles as exact balls; a named tuple stays one."""
    exact = [arb(x) for x in values]
    return type(values)(*exact) if hasattr(values, "_fields") else tuple(exact)


def middle(ball: Any) -> float:
    """Return the middle of a ball, or of a number, as a double; NaN for one that is nowhere."""
    if not isinstance(ball, arb):
        return float(ball)
    return float(ball.mid()) if ball.is_finite() else math.nan
