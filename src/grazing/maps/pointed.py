"""Steps by address: kernels that get a step so, or its derivative, are compiled once for every map of one's own."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache, partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from grazing.kernel.compile import address
from grazing.kernel.lanes import advancer, runner_at, unpacker
from grazing.kernel.primitives import derived_at, replaced
from grazing.maps.derivative import Derived

Floats = NDArray[np.float64]


@lru_cache(maxsize=256)
def pointed_loop(
    step: Callable[..., Any], kind: type, dimension: int, arithmetic: str, who: str
) -> Callable[..., None]:
    """Return the loop around a step, as :func:`grazing.kernel.lanes.runner` does; only the step is compiled for it."""
    advance = advancer(step, kind, dimension, packed=True)

    def block(x: Any, said: Any, width: int, steps: int) -> None:
        advance(0.0, x, said, width, steps)

    return partial(runner_at(dimension, arithmetic), address(block, "block", arithmetic, who))


class Place(NamedTuple):
    """What a kernel needs of a map: the address of the derivative of its step, and where its parameters lie."""

    step: float
    row: float


@lru_cache(maxsize=16)
def pointed_tangent(dimension: int) -> Callable[..., Any]:
    """Return ``tangent(state, place) -> (state, letter, outcome, J)``, which calls what lies at a place.

    J is as :class:`grazing.maps.derivative.Derived` says.
    """
    blank, zero = (0.0,) * (dimension + dimension * dimension + 1), (0.0,) * dimension
    slopes = blank[dimension:]

    def tangent(state: Any, place: Any) -> Any:
        found, (letter, outcome) = derived_at(place.step, state, place.row, blank)
        new, J = zero, slopes
        for i in range(dimension):
            new = replaced(new, i, found[i])
        for i in range(len(slopes)):
            J = replaced(J, i, found[dimension + i])
        return new, letter, outcome, J

    return tangent


@lru_cache(maxsize=256)
def tangent_address(tangent: Callable[..., Any], kind: type, dimension: int, who: str) -> float:
    """Compile the derivative of a step, in strict arithmetic; return where its code lies."""
    unpack, zero = unpacker(kind), (0.0,) * dimension

    def derive(before: Any, row: Any, found: Any, said: Any) -> None:
        state = zero
        for i in range(dimension):
            state = replaced(state, i, before[i])
        new, letter, outcome, J = tangent(state, unpack(row))
        for i in range(dimension):
            found[i] = new[i]
        for i in range(len(J)):
            found[dimension + i] = J[i]
        said[0], said[1] = letter, outcome

    return address(derive, "derivative", "strict", who)


def pointed_derivative(tangent: Callable[..., Any], kind: type, dimension: int, rows: Floats, who: str) -> Derived:
    """Return the derivative of a step at rows of parameters, for kernels that know no more of it than its address.

    Parameters
    ----------
    tangent : callable
        ``tangent(state, p) -> (state, letter, outcome, J)``, J as :class:`grazing.maps.derivative.Derived` says.
    kind : type
        The named tuple of the parameters p.
    dimension : int
    rows : ndarray, shape (columns, parameters)
        In one piece; must live as long as the result is used.
    who : str
        Who is to blame if it does not compile.
    """
    code = tangent_address(tangent, kind, dimension, who)
    where = rows.ctypes.data + rows.strides[0] * np.arange(len(rows), dtype=np.float64)
    places = np.column_stack([np.full(len(rows), code), where])
    return Derived(pointed_tangent(dimension), None, Place, np.ascontiguousarray(places), rows)
