"""The one loop that drives a step: many orbits (lanes) side by side, so that they share vector registers."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numpy as np

from grazing.kernel.compile import compiled
from grazing.kernel.primitives import built, replaced

#: Lanes advanced together; large enough to hide the latency of a square root, small enough to stay in cache.
BLOCK = 64


def column(lanes: Any, j: int, zero: tuple[float, ...]) -> tuple[float, ...]:
    """Return lane j of an array of shape (dimension, lanes) as a tuple as long as ``zero``."""
    state = zero
    for i in range(len(zero)):
        state = replaced(state, i, lanes[i, j])
    return state


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
    """Compile the loop around a step.

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
    arithmetic : {"strict", "fast"}
        See :func:`grazing.kernel.compile.compiled`.

    Returns
    -------
    callable
        ``run(row, lanes, transient, points, letters, outcomes)``: lanes (dimension, n) hold the starts and then the
        last states; points (keep, dimension, n), letters (keep, n) and outcomes (records, n) are filled. With
        records = 1 outcomes are folded over all iterates, with records = keep they are kept apart.
    """
    unpack = unpacker(kind)
    zero = (0.0,) * dimension
    constants = prepare if prepare is not None else _same

    def run(row: Any, lanes: Any, transient: int, points: Any, letters: Any, outcomes: Any) -> None:
        c = constants(unpack(row))
        n = lanes.shape[1]
        keep = points.shape[0]
        last = outcomes.shape[0] - 1
        x = np.empty((len(zero), BLOCK))  # a block of its own: contiguous, so the loops below vectorise
        folded = np.empty(BLOCK, np.int64)
        for start in range(0, n, BLOCK):
            width = min(BLOCK, n - start)
            for j in range(width):
                put(x, j, column(lanes, start + j, zero))
                folded[j] = 0
            for _ in range(transient):
                for j in range(width):
                    state, _letter, outcome = step(column(x, j, zero), c)
                    put(x, j, state)
                    folded[j] |= outcome
            for j in range(width):
                outcomes[0, start + j] |= folded[j]
            for i in range(keep):
                record = min(i, last)
                for j in range(width):
                    state, letter, outcome = step(column(x, j, zero), c)
                    put(x, j, state)
                    letters[i, start + j] = letter
                    outcomes[record, start + j] |= outcome
                for k in range(len(zero)):
                    for j in range(width):
                        points[i, k, start + j] = x[k, j]
            for j in range(width):
                put(lanes, start + j, column(x, j, zero))

    return compiled(run, arithmetic)


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
