"""Run a map at many parameter values from many starts: the door through which every study enters."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from grazing.kernel.compile import call
from grazing.kernel.lanes import runner
from grazing.kernel.pool import Progress, Task, run_tasks
from grazing.outcome import DIVERGED, FATAL

#: Steps of a tile, over all its orbits.
TILE = 1_000_000

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


class Columns(NamedTuple):
    """Orbits of a map at many parameter values, the columns.

    ``points`` (columns, keep, dim, starts), ``letters`` (columns, keep, starts), ``outcomes`` (columns, records,
    starts).
    How near each orbit came to being another one, (columns, starts): ``near_miss``, the height of the lowest point at
    which it did not touch the wall; ``slowest``, the speed of its slowest impact; ``undecided``, how many of its steps
    hold a decision that could not be made for certain. Infinity and 0 for maps that have no such decisions.
    """

    points: Floats
    letters: Ints
    outcomes: Ints
    near_miss: Floats
    slowest: Floats
    undecided: Ints


def empty_columns(columns: int, dimension: int, starts: int, keep: int, records: int) -> Columns:
    """Return results to be filled."""
    return Columns(
        np.empty((columns, keep, dimension, starts)),
        np.zeros((columns, keep, starts), np.int64),
        np.zeros((columns, records, starts), np.int64),
        np.full((columns, starts), np.inf),
        np.full((columns, starts), np.inf),
        np.zeros((columns, starts), np.int64),
    )


def size_of_columns(columns: int, dimension: int, starts: int, keep: int, records: int) -> int:
    """Return the bytes that results take."""
    return 8 * columns * starts * (keep * (dimension + 1) + records + dimension + 3)


def run_columns(
    tasks: list[Task], lanes: Floats, found: Columns, threads: int | None, progress: Progress | None
) -> None:
    """Run the tasks that fill ``found``; orbits that left the numbers without a word are marked diverged."""
    run_tasks(tasks, threads, progress)
    ended = (np.bitwise_or.reduce(found.outcomes, axis=1) & FATAL) != 0
    lost = ~np.isfinite(lanes).all(axis=1) & ~ended
    found.outcomes[:, -1][lost] |= DIVERGED


def step_tasks(
    step: Callable[..., Any],
    prepare: Callable[..., Any] | None,
    kind: type,
    rows: Floats,
    lanes: Floats,
    transient: int,
    found: Columns,
    arithmetic: str,
    who: str,
) -> list[Task]:
    """Return tasks that drive a step through the columns, tile by tile.

    Parameters
    ----------
    step, prepare, kind, arithmetic
        See :func:`grazing.kernel.lanes.runner`.
    rows : ndarray, shape (columns, parameters)
    lanes : ndarray, shape (columns, dim, starts)
        The starts; overwritten with the last states.
    transient : int
    found : Columns
        To be filled.
    who : str
        Who is to blame if the step does not compile.
    """
    entry = runner(step, prepare, kind, lanes.shape[1], arithmetic)
    stride = max(1, TILE // lanes.shape[2])
    keep, records = found.points.shape[1], found.outcomes.shape[1]

    def column(q: int) -> Iterator[None]:
        for n in range(0, transient, stride):
            nothing = found.points[q, :0], found.letters[q, :0], found.outcomes[q, :1]
            call(entry, rows[q], lanes[q], min(stride, transient - n), *nothing, who=who)
            yield
        for n in range(0, max(keep, 1), stride):
            part = slice(n, min(n + stride, keep))
            outcomes = found.outcomes[q, part] if records > 1 else found.outcomes[q]
            call(entry, rows[q], lanes[q], 0, found.points[q, part], found.letters[q, part], outcomes, who=who)
            yield

    def some(first: int, last: int) -> Iterator[None]:
        for q in range(first, last):
            yield from column(q)

    together = max(1, TILE // (4 * lanes.shape[2] * (transient + keep + 1)))  # a task must be worth its handling
    return [partial(some, q, min(q + together, len(rows))) for q in range(0, len(rows), together)]
