"""The one loop that drives a step: many orbits (lanes) side by side, so that they share vector registers."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grazing.kernel.compile import compiled
from grazing.kernel.primitives import advanced_at, at, built, inlined, numbers, replaced

#: Lanes advanced together; large enough to hide the latency of a square root, small enough to stay in cache.
BLOCK = 64


def aligned(count: int) -> NDArray[np.float64]:
    """Return zeros from an address on that 64 divides: then no vector lies across two lines of the cache."""
    room = np.zeros(count + 8)
    skip = -(room.ctypes.data // 8) % 8
    return room[skip : skip + count]


@inlined
def column(lanes: Any, j: int, zero: tuple[float, ...], first: int = 0) -> tuple[float, ...]:
    """Return lane j of an array of shape (rows, lanes), from row ``first`` on, as a tuple as long as ``zero``."""
    state = zero
    for i in range(len(zero)):
        state = replaced(state, i, lanes[first + i, j])
    return state


@inlined
def put(lanes: Any, j: int, state: tuple[float, ...]) -> None:
    """Write a state into lane j of an array of shape (dimension, lanes)."""
    for i in range(len(state)):
        lanes[i, j] = state[i]


def unpacker(kind: type) -> Callable[..., Any]:
    """Return ``unpack(row, start=0)``, which turns numbers from ``start`` on into a named tuple of type ``kind``."""
    zero = (0.0,) * len(kind._fields)  # type: ignore[attr-defined]

    def unpack(row: Any, start: int = 0) -> Any:
        values = zero
        for i in range(len(zero)):
            values = replaced(values, i, row[start + i])
        return built(kind, values)

    return unpack


@lru_cache(maxsize=256)
def runner(
    step: Callable[..., Any], prepare: Callable[..., Any] | None, kind: type, dimension: int, arithmetic: str
) -> Callable[..., None]:
    """Compile the loop around a step, see :func:`loop_of`."""
    return compiled(loop_of(step, prepare, kind, dimension), arithmetic)


@lru_cache(maxsize=256)
def loop_of(
    step: Callable[..., Any], prepare: Callable[..., Any] | None, kind: type, dimension: int
) -> Callable[..., None]:
    """Return the loop around a step.

    Parameters
    ----------
    step : callable
        ``step(state, c) -> (state, letter, outcome)``.
    prepare : callable or None
        ``prepare(p) -> c``; None for c = p.
    kind : type
        The named tuple of the parameters.
    dimension : int
        Length of a state.

    Returns
    -------
    callable
        ``run(rows, lanes, transient, points, letters, outcomes)``: rows (columns, fields) hold parameter values, lanes
        (columns, dimension, n) the starts and then the last states; points (columns, keep, dimension, n), letters
        (columns, keep, n) and outcomes (columns, records, n) are filled. With records = 1 outcomes are folded over all
        iterates, with records = keep they are kept apart. Where the parameters are used as they are, a block holds
        lanes of several columns, so that few starts a column are no slower than many.
    """
    unpack, packed = unpacker(kind), prepare is None

    def constants(_step: float, row: Any) -> Any:
        return prepare(unpack(row)) if prepare is not None else 0.0

    drive = driver(advancer(step, kind, dimension, packed), constants, dimension, packed)

    def run(rows: Any, lanes: Any, transient: int, points: Any, letters: Any, outcomes: Any) -> None:
        drive(0.0, rows, lanes, transient, points, letters, outcomes)

    return run


@lru_cache(maxsize=16)
def abreast_loop(step_all: Callable[..., None], dimension: int) -> Callable[..., None]:
    """Return the loop around a step that is taken by all orbits of a column at once, as :func:`loop_of` describes it.

    Parameters
    ----------
    step_all : callable
        ``step_all(row, lanes, letters, outcomes)``: takes the states of lanes (dimension, n) one step further at a row
        of parameters, and fills letters and outcomes (n,).
    dimension : int
    """

    def run(rows: Any, lanes: Any, transient: int, points: Any, letters: Any, outcomes: Any) -> None:
        columns, n, keep, last = lanes.shape[0], lanes.shape[2], points.shape[1], outcomes.shape[1] - 1
        letter, outcome = np.empty(n, np.int64), np.empty(n, np.int64)
        for q in range(columns):
            for step in range(transient + keep):
                step_all(rows[q], lanes[q], letter, outcome)
                i = max(step - transient, 0)
                for j in range(n):
                    outcomes[q, i if last > 0 else 0, j] |= outcome[j]
                    if step >= transient:
                        letters[q, i, j] = letter[j]
                        for k in range(dimension):
                            points[q, i, k, j] = lanes[q, k, j]

    return run


@lru_cache(maxsize=16)
def runner_at(dimension: int, arithmetic: str) -> Callable[..., None]:
    """Compile the loop around a block that is advanced by an address, for every packed step of a dimension.

    Returns
    -------
    callable
        ``run(step, rows, ...)`` as in :func:`loop_of`; ``step`` is where an :func:`advancer` lies.
    """
    return compiled(driver(advanced_at, _place, dimension, packed=True), arithmetic)


def _place(step: float, _row: Any) -> float:
    return step


@lru_cache(maxsize=256)
def advancer(step: Callable[..., Any], kind: type, dimension: int, packed: bool) -> Callable[..., None]:
    """Return ``advance(c, x, said, width, steps)``, which takes a block of lanes some steps further.

    x are the numbers of (dimension + fields, BLOCK), states above parameters, and said those of (2, BLOCK), letters
    above outcomes; the last letters are left there, outcomes are added. A packed step gets the parameters of its lane,
    any other c.
    """
    zero, blank = (0.0,) * dimension, (0.0,) * len(kind._fields)  # type: ignore[attr-defined]

    @inlined
    def own(_c: Any, x: Any, j: int) -> Any:
        return built(kind, entry(x, j, blank, dimension))

    at_lane = own if packed else _shared

    def advance(c: Any, x: Any, said: Any, width: int, steps: int) -> None:
        for _ in range(steps):
            for j in range(width):
                state, letter, outcome = step(entry(x, j, zero), at_lane(c, x, j))
                for i in range(dimension):
                    x[i * BLOCK + j] = state[i]
                said[j] = letter
                said[BLOCK + j] |= outcome

    return advance


@inlined
def entry(x: Any, j: int, zero: tuple[float, ...], first: int = 0) -> tuple[float, ...]:
    """Return the numbers of lane j of a block, from row ``first`` on, as a tuple as long as ``zero``."""
    state = zero
    for i in range(len(zero)):
        state = replaced(state, i, x[(first + i) * BLOCK + j])
    return state


@lru_cache(maxsize=256)
def driver(
    advance: Callable[..., None], constants: Callable[..., Any], dimension: int, packed: bool
) -> Callable[..., None]:
    """Return the loop that fills blocks, has them advanced, and keeps what it is asked to, see :func:`loop_of`.

    Parameters
    ----------
    advance : callable
        See :func:`advancer`.
    constants : callable
        ``constants(step, row) -> c``.
    dimension : int
    packed : bool
        Whether a block holds lanes of several columns.

    Returns
    -------
    callable
        ``run(step, rows, lanes, transient, points, letters, outcomes)``; ``step`` is for ``constants``.
    """

    @inlined
    def kept(x: Any, said: Any, which: Any, lane: Any, width: int, i: int, points: Any, letters: Any) -> None:
        """Write states and letters of a block to place i, column by column: eight neighbours are one vector."""
        j = 0
        while j < width:
            q, first = which[j], lane[j]
            wide = min(points.shape[3] - first, width - j)
            for h in range(0, wide - 7, 8):
                for k in range(dimension):
                    for g in range(8):
                        points[at(q), at(i), k, at(first + h + g)] = x[k, at(j + h + g)]
                for g in range(8):
                    letters[at(q), at(i), at(first + h + g)] = said[0, at(j + h + g)]
            for h in range(wide // 8 * 8, wide):
                for k in range(dimension):
                    points[at(q), at(i), k, at(first + h)] = x[k, at(j + h)]
                letters[at(q), at(i), at(first + h)] = said[0, at(j + h)]
            j += wide

    def run(step: float, rows: Any, lanes: Any, transient: int, points: Any, letters: Any, outcomes: Any) -> None:
        columns, n, fields = lanes.shape[0], lanes.shape[2], rows.shape[1]
        keep = points.shape[1]
        last = outcomes.shape[1] - 1
        # a block of its own, states above parameters: in one piece, so the loops below vectorise without a question
        x = np.empty((dimension + fields, BLOCK))
        said = np.empty((2, BLOCK), np.int64)  # letters above outcomes
        which, lane = np.empty(BLOCK, np.int64), np.empty(BLOCK, np.int64)
        size = columns * n if packed else n
        for top in range(0, columns * n, size):
            c = constants(step, rows[top // n])
            for start in range(top, top + size, BLOCK):
                width = min(BLOCK, top + size - start)
                q, i = start // n, start % n
                for j in range(width):
                    which[j], lane[j] = q, i
                    for k in range(dimension):
                        x[k, j] = lanes[at(q), k, at(i)]
                    for k in range(fields):
                        x[dimension + k, j] = rows[at(q), k]
                    said[1, j] = 0
                    i += 1
                    if i == n:
                        q, i = q + 1, 0
                advance(c, numbers(x), numbers(said), width, transient)
                noted(said, which, lane, width, 0, outcomes)
                for i in range(keep):
                    advance(c, numbers(x), numbers(said), width, 1)
                    kept(x, said, which, lane, width, i, points, letters)
                    if last > 0:
                        noted(said, which, lane, width, i, outcomes)
                noted(said, which, lane, width, last, outcomes)
                for j in range(width):
                    for k in range(dimension):
                        lanes[at(which[j]), k, at(lane[j])] = x[k, j]

    return run


@inlined
def noted(said: Any, which: Any, lane: Any, width: int, record: int, outcomes: Any) -> None:
    """Add the outcomes of a block to a record, and begin anew."""
    for j in range(width):
        outcomes[at(which[j]), at(record), at(lane[j])] |= said[1, j]
        said[1, j] = 0


def _shared(c: Any, x: Any, j: int) -> Any:
    return c
