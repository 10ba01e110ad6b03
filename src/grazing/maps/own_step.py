"""A step of one's own, in the form that kernels take: (state, letter, outcome), and an end for orbits that run away."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from grazing.kernel.primitives import replaced
from grazing.outcome import DIVERGED, FATAL, UserCodeError, shown, told

if TYPE_CHECKING:
    from grazing.maps.map import Map

NAN = float("nan")
INFINITY = float("inf")


def normalised(P: Map) -> Callable[..., Any]:
    """Wrap a step so that it returns (state, letter, outcome) whatever form the user chose; try it once first."""
    step, escape, dimension = P.step, P.escape, P.dimension
    kind, row = P.packed()
    p = kind(*row.tolist())
    middle = tuple(0.5 * (low + high) for low, high in P.box)
    try:
        result = step(middle, P.prepare(p) if P.prepare is not None else p)
    except Exception as error:
        raise UserCodeError(
            f"the step of {P.name} raised {told(error, P.step)} (state {middle}, parameters {dict(P.params)})"
        ) from error
    form = _form(result, dimension)
    if form == 0:
        raise UserCodeError(
            f"the step of {P.name} returned {shown(result)}; allowed are a tuple of {dimension} number(s), "
            "or (state, letter), or (state, letter, outcome)"
        )
    if form == 1:

        def bare(state: Any, c: Any) -> Any:
            return step(state, c), 0, 0

        return ending(bare, escape)
    if form == 2:

        def lettered(state: Any, c: Any) -> Any:
            new, letter = step(state, c)
            return new, letter, 0

        return ending(lettered, escape)
    return ending(step, escape)


def ending(step: Callable[..., Any], escape: float) -> Callable[..., Any]:
    """Wrap a step so that an orbit ends, in NaN, beyond ``escape`` or with a fatal outcome."""

    def ending(state: Any, c: Any) -> Any:
        new, letter, outcome = step(state, c)
        ended = outcome & FATAL
        for x in new:
            if not ended and (abs(x) > escape or not abs(x) < INFINITY):
                outcome = outcome | DIVERGED
        if outcome & FATAL:
            for i in range(len(new)):
                new = replaced(new, i, NAN)
        return new, letter, outcome

    return ending


def _form(result: object, dimension: int) -> int:
    """Return which form a step's result has: 1 state, 2 with letter, 3 with letter and outcome, 0 none of them."""

    def is_state(value: object) -> bool:
        return (
            isinstance(value, tuple)
            and len(value) == dimension
            and all(isinstance(x, (int, float, np.floating)) and not isinstance(x, bool) for x in value)
        )

    if is_state(result):
        return 1
    if isinstance(result, tuple) and len(result) in (2, 3) and is_state(result[0]):
        if all(isinstance(x, (int, np.integer)) and not isinstance(x, bool) for x in result[1:]):
            return len(result)
    return 0
