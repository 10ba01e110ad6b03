"""Options of figures, checked in one place before anything is drawn: each name means the same in every function."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import wraps
from inspect import Signature, signature
from types import MappingProxyType
from typing import Any, TypeVar

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.colors import Colormap, is_color_like

from grazing.outcome import InputError, in_one_line, shown
from grazing.parameter import Parameter, whole

Function = TypeVar("Function", bound=Callable[..., Any])

#: Real numbers that options are, each by its name.
NUMBERS: Mapping[str, Parameter] = MappingProxyType({
    one.name: one
    for one in (
        Parameter("width", "w", "millimetres; 1200 are the longer side of A0", 1.0, 1200.0),
        Parameter("height", "h", "millimetres; 1200 are the longer side of A0", 1.0, 1200.0),
        Parameter("sigma", r"\sigma", "position of the wall"),
        Parameter("shade", "s", "share of the colour that a window is shaded with", 0.0, 1.0),
        Parameter("narrowest", "n", "share of the axis", 0.0, 1.0),
        Parameter("numbered", "n", "share of the axis", 0.0, 1.0),
        Parameter("size", "s", "diameter of a point, in points of print", 0.0, 1000.0, open="low"),
        Parameter("positive", r"\lambda", "least exponent that is called positive", 0.0),
        Parameter("until", "f", "last frequency or order in sight", 0.0, open="low"),
    )
})  # fmt: skip
#: Whole numbers, each with the least one.
WHOLE: Mapping[str, int] = MappingProxyType({"longest": 1, "graze": -1, "rows": 1, "columns": 1, "N": -(2**31)})
#: Panels of a figure along one side at most: each takes about as long as a figure.
PANELS = 20


def option(name: str, value: Any, kind: str) -> Any:
    """Return the value of an option as it is drawn, or raise InputError; ``kind`` is what its annotation says."""
    if value is None and kind.endswith("| None"):
        return None
    kind = kind.removesuffix(" | None")
    if kind == "Axes" and not isinstance(value, Axes):
        raise InputError(f"{name} is {shown(value)}; allowed are axes of matplotlib, such as those of gz.plot.panels()")
    if kind == "bool" and not isinstance(value, (bool, np.bool_)):
        raise InputError(f"{name} is {shown(value)}; allowed are True and False")
    if name == "colour" and not is_color_like(value):
        raise InputError(f"{name} is {shown(value)}; allowed is a colour of matplotlib, such as '#0064a4' or 'black'")
    if name == "cmap" and not isinstance(value, Colormap) and (not isinstance(value, str) or value not in colormaps):
        raise InputError(f"{name} is {shown(value)}; allowed is a colormap of matplotlib, such as 'viridis'")
    if kind == "float":
        return NUMBERS[name].check(value)
    if kind == "int":
        return whole(value, name, WHOLE[name], PANELS if name in ("rows", "columns") else 2**31)
    return value


def bound(call: Signature, args: tuple[Any, ...], more: dict[str, Any]) -> tuple[tuple[Any, ...], dict[str, Any]]:
    """Return the arguments of a call with its options checked."""
    given = call.bind(*args, **more)
    for name, value in given.arguments.items():
        one = call.parameters[name]
        if one.kind not in (one.VAR_KEYWORD, one.VAR_POSITIONAL):
            given.arguments[name] = option(name, value, str(one.annotation))
    return given.args, given.kwargs


def checked(function: Function) -> Function:
    """Let a function of figures check its options before it runs."""
    call = signature(function)

    @wraps(function)
    def begun(*args: Any, **more: Any) -> Any:
        args, more = bound(call, args, more)
        return function(*args, **more)

    return begun  # type: ignore[return-value]


@contextmanager
def passed_on(what: str) -> Iterator[None]:
    """Raise InputError where matplotlib or NumPy refuses what is passed on to it."""
    try:
        yield
    except (TypeError, ValueError, AttributeError) as error:
        raise InputError(f"{what}: {in_one_line(error)}") from None
