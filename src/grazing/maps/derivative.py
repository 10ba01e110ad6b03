"""The derivative of a step as the studies need it: by differences, or a map's own with what else is known of it."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any

from grazing.kernel.primitives import replaced

NAN = float("nan")

#: Cube root of the rounding error: it balances rounding against curvature, and leaves about ten digits.
STEP = 6e-6


@lru_cache(maxsize=256)
def differences_of(step: Callable[..., Any], dimension: int) -> Callable[..., Any]:
    """Return ``tangent(state, c) -> (state, letter, outcome, J)``, J row by row, from central differences of a step.

    Parameters
    ----------
    step : callable
        ``step(state, c) -> (state, letter, outcome)``.
    dimension : int
    """
    zero = (0.0,) * (dimension * dimension)

    def tangent(state: Any, c: Any) -> Any:
        new, letter, outcome = step(state, c)
        J = zero
        for j in range(dimension):
            h = STEP * max(1.0, abs(state[j]))
            high, low = state[j] + h, state[j] - h
            after, _letter, _outcome = step(replaced(state, j, high), c)
            before, _letter, _outcome = step(replaced(state, j, low), c)
            for i in range(dimension):
                J = replaced(J, i * dimension + j, (after[i] - before[i]) / (high - low))
        return new, letter, outcome, J

    return tangent


@lru_cache(maxsize=256)
def extended(tangent: Callable[..., Any]) -> Callable[..., Any]:
    """Return a tangent whose J is followed by NaN: the logarithm of |det J| is not known apart from J."""

    def derived(state: Any, c: Any) -> Any:
        new, letter, outcome, J = tangent(state, c)
        return new, letter, outcome, (*J, NAN)

    return derived
