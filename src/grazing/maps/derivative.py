"""The derivative of a step as the studies need it: by differences, or a map's own with what else is known of it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache
from math import frexp, ldexp, sqrt
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from grazing.copies import by_value
from grazing.kernel.compile import compiled
from grazing.kernel.lanes import column, put, unpacker
from grazing.kernel.primitives import inlined, replaced

NAN = float("nan")
Floats = NDArray[np.float64]

#: Cube root of the rounding error: it balances rounding against curvature, and leaves about ten digits.
STEP = 6e-6
#: A state near 0 is told from its neighbours in units of 1 in a box from 1 to so many times as wide.
WIDE = 1000.0
#: What the two sides of a state differ by, relative to the greater, where there may be a kink between them; and where
#: there is a jump, in units of the image: more than a square root does over such a step.
KINK, JUMP = 1e-3, 4.0


@by_value
class Derived(NamedTuple):
    """The derivative of a map's step in the form in which it is compiled.

    ``tangent(state, c) -> (state, letter, outcome, J)``, J row by row and then the logarithm of |det J|, NaN where it
    is not known apart from J; ``prepare`` and ``kind`` turn a row of ``rows`` into c.
    ``source`` is what these may point to: it must live as long as they are used. ``step`` is the step alone
    where more is to be left out for it than what a compiler leaves out by itself; ``loop`` the compiled loop around it,
    as :func:`grazing.kernel.lanes.loop_of` describes it, where orbits side by side are quicker than one by one.
    """

    tangent: Callable[..., Any]
    prepare: Callable[..., Any] | None
    kind: type
    rows: Floats
    source: Any
    step: Callable[..., Any] | None = None
    loop: Callable[..., None] | None = None


def units_of(box: Sequence[tuple[float, float]]) -> tuple[float, ...]:
    """Return the size below which a coordinate counts as near 0: 1, but no wider than the box nor lost in it.

    Powers of two, so that boxes of about the same size share their compiled code.
    """
    found = []
    for low, high in box:
        size = min(max(1.0, (high - low) / WIDE), high - low)
        found.append(size if size == 1.0 else ldexp(1.0, frexp(size)[1] - 1))
    return tuple(found)


@inlined
def difference(ahead: float, behind: float, same_ahead: bool, same_behind: bool, unit: float) -> float:
    """Return by how much an image differs over two steps, of what it does over one of them, ahead and behind.

    Where a border lies between, twice that of the side on which the state itself is: the one with the letter of the
    state, or, if both or none have, the one without the jump.
    """
    greater, apart = max(abs(ahead), abs(behind)), abs(ahead - behind)
    if apart > KINK * greater and same_ahead != same_behind:
        return 2.0 * (ahead if same_ahead else behind)
    if apart > JUMP * sqrt(STEP) * unit and same_ahead == same_behind:
        return 2.0 * (ahead if abs(ahead) < abs(behind) else behind)
    return ahead + behind


@lru_cache(maxsize=256)
def differences_of(step: Callable[..., Any], dimension: int, units: tuple[float, ...]) -> Callable[..., Any]:
    """Return ``tangent(state, c) -> (state, letter, outcome, J)``, J row by row, from central differences of a step.

    Parameters
    ----------
    step : callable
        ``step(state, c) -> (state, letter, outcome)``.
    dimension : int
    units : tuple of float
        Of :func:`units_of`.
    """
    zero = (0.0,) * (dimension * dimension)

    def tangent(state: Any, c: Any) -> Any:
        new, letter, outcome = step(state, c)
        J = zero
        for j in range(dimension):
            h = STEP * max(units[j], abs(state[j]))
            high, low = state[j] + h, state[j] - h
            after, next_letter, _outcome = step(replaced(state, j, high), c)
            before, last_letter, _outcome = step(replaced(state, j, low), c)
            for i in range(dimension):
                over = difference(
                    after[i] - new[i], new[i] - before[i], next_letter == letter, last_letter == letter,
                    max(units[i], abs(new[i])),
                )  # fmt: skip
                J = replaced(J, i * dimension + j, over / (high - low))
        return new, letter, outcome, J

    return tangent


@lru_cache(maxsize=256)
def extended(tangent: Callable[..., Any]) -> Callable[..., Any]:
    """Return a tangent whose J is followed by NaN: the logarithm of |det J| is not known apart from J."""

    def derived(state: Any, c: Any) -> Any:
        new, letter, outcome, J = tangent(state, c)
        return new, letter, outcome, (*J, NAN)

    return derived


@lru_cache(maxsize=256)
def stepping(tangent: Callable[..., Any]) -> Callable[..., Any]:
    """Return the step of a tangent, or of whatever else says more behind it."""

    def step(state: Any, c: Any) -> Any:
        found = tangent(state, c)
        return found[0], found[1], found[2]

    return step


@lru_cache(maxsize=256)
def deriving(period: Callable[..., Any]) -> Callable[..., Any]:
    """Return ``derived(state, c) -> (state, letter, outcome, J)`` of what says more behind these."""

    def derived(state: Any, c: Any) -> Any:
        found = period(state, c)
        return found[0], found[1], found[2], found[3]

    return derived


@lru_cache(maxsize=256)
def plainly(derived: Callable[..., Any]) -> Callable[..., Any]:
    """Return the tangent of a map of two coordinates, without the logarithm of |det J| behind J."""

    def tangent(state: Any, c: Any) -> Any:
        found = derived(state, c)
        J = found[3]
        return found[0], found[1], found[2], (J[0], J[1], J[2], J[3])

    return tangent


@lru_cache(maxsize=256)
def tangent_runner(
    tangent: Callable[..., Any], prepare: Callable[..., Any] | None, kind: type, dimension: int
) -> Callable[..., int]:
    """Compile one application of ``tangent(state, c) -> (state, letter, outcome, J)``.

    Returns
    -------
    callable
        ``run(row, lanes, matrix) -> outcome``; matrix (dimension, dimension) is filled with J.
    """
    unpack = unpacker(kind)
    zero = (0.0,) * dimension
    constants = prepare if prepare is not None else _same

    def run(row: Any, lanes: Any, matrix: Any) -> int:
        state, _letter, outcome, slopes = tangent(column(lanes, 0, zero), constants(unpack(row)))
        put(lanes, 0, state)
        for i in range(len(zero)):
            for j in range(len(zero)):
                matrix[i, j] = slopes[i * len(zero) + j]
        return int(outcome)

    return compiled(run, "strict")


def _same(p: Any) -> Any:
    return p
