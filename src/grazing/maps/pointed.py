"""Steps by address: kernels that get a step so, or its derivative, are compiled once for every map of one's own."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache, partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from grazing.kernel.compile import address, call, compiled
from grazing.kernel.lanes import advancer, runner_at, unpacker
from grazing.kernel.primitives import behind, derived_at, found_at, numbers, replaced, room_of, written
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
def tangent_address(
    tangent: Callable[..., Any], prepare: Callable[..., Any] | None, kind: type, dimension: int, who: str
) -> float:
    """Compile the derivative of a step, in strict arithmetic; return where its code lies."""
    unpack, zero, fields = unpacker(kind), (0.0,) * dimension, len(kind._fields)  # type: ignore[attr-defined]

    def prepared(row: Any) -> Any:
        return found_at(behind(row, fields), prepare, unpack(row))  # type: ignore[arg-type]

    constants = unpack if prepare is None else prepared

    def derive(before: Any, row: Any, found: Any, said: Any) -> None:
        state = zero
        for i in range(dimension):
            state = replaced(state, i, before[i])
        new, letter, outcome, J = tangent(state, constants(row))
        for i in range(dimension):
            found[i] = new[i]
        for i in range(len(J)):
            found[dimension + i] = J[i]
        said[0], said[1] = letter, outcome

    return address(derive, "derivative", "strict", who)


@lru_cache(maxsize=256)
def preparer(prepare: Callable[..., Any], kind: type) -> Callable[..., int]:
    """Compile ``run(table, kept) -> room``: write behind the parameters of each row what a step gets of them, prepared.

    ``room`` is how many numbers it takes; unless ``kept`` nothing is written.
    """
    unpack, fields = unpacker(kind), len(kind._fields)  # type: ignore[attr-defined]

    def run(table: Any, kept: bool) -> int:
        room = 0
        for q in range(table.shape[0]):
            c = prepare(unpack(table[q]))
            room = room_of(c)
            if kept:
                written(behind(numbers(table), q * table.shape[1] + fields), c)
        return room

    return compiled(run)


def prepared_rows(prepare: Callable[..., Any], kind: type, rows: Floats, who: str) -> Floats:
    """Return rows of parameters with what a step gets of them behind: prepared once for all steps."""
    run, fields = preparer(prepare, kind), rows.shape[1]
    table = np.empty((len(rows), fields + call(run, rows[:1], False, who=who)))
    table[:, :fields] = rows
    call(run, table, True, who=who)
    return table


def pointed_derivative(given: Derived, dimension: int, who: str) -> Derived:
    """Return the derivative of a step for kernels that know no more of it than its address.

    Parameters
    ----------
    given : Derived
        As it would be compiled into them; ``rows`` in one piece.
    dimension : int
    who : str
        Who is to blame if it does not compile.
    """
    tangent, prepare, kind, rows, source, *_loops = given
    code = tangent_address(tangent, prepare, kind, dimension, who)
    if prepare is not None:
        rows = prepared_rows(prepare, kind, rows, who)
    where = rows.ctypes.data + rows.strides[0] * np.arange(len(rows), dtype=np.float64)
    places = np.column_stack([np.full(len(rows), code), where])
    return Derived(pointed_tangent(dimension), None, Place, np.ascontiguousarray(places), (rows, source))
