"""Run a map at many parameter values from many starts: the door through which every study enters."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from grazing.copies import by_value
from grazing.kernel.compile import call
from grazing.outcome import DIVERGED, FATAL, InputError, listed, shown
from grazing.parameter import in_order
from grazing.pool import Progress, Task, run_tasks

#: Oscillators are flown in pieces that end at multiples of so many periods from their start, whatever else is cut, so
#: that the bits depend neither on pieces nor on company.
CUT = 256
#: Steps of the first tile, over all its orbits; tiles then grow, up to the longest time between two looks at Ctrl-C.
TILE = 1_000_000
LONGEST = 0.2

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@by_value
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


def checked_columns(rows: ArrayLike, lanes: Floats, P: Any) -> Floats:
    """Return the values of the parameters of a map, and refuse lanes that do not fit."""
    wanted = f"{P.name} needs (columns, {len(P.params)}): {listed(P.params)}; and (columns, {P.dimension}, n): "
    try:
        table = np.array(in_order(rows), np.float64, ndmin=2)
    except Exception:  # of whatever object was given
        raise InputError(f"rows are {shown(rows)}; {wanted}{listed(P.coordinates)}") from None
    floats = isinstance(lanes, np.ndarray) and lanes.dtype.kind == "f" and not np.ma.is_masked(lanes)
    if not floats or not lanes.flags.writeable:
        raise InputError(f"lanes are {shown(lanes)}; give an array of floats that can be written to")
    fits = lanes.ndim == 3 and lanes.shape[:2] == (len(table), P.dimension)
    if table.ndim != 2 or table.shape[1] != max(len(P.params), 1) or not fits:
        raise InputError(f"rows have shape {table.shape} and lanes {lanes.shape}; {wanted}{listed(P.coordinates)}")
    return table


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
    stay_ended(found)


def stay_ended(found: Columns) -> None:
    """Let orbits that ended keep their outcome in the steps that follow, of which their steps know nothing."""
    fatal = found.outcomes & FATAL
    if fatal.shape[1] > 1 and fatal.any():
        found.outcomes[...] |= np.bitwise_or.accumulate(fatal, axis=1)


def step_tasks(
    loop: Callable[..., Any],
    rows: Floats,
    lanes: Floats,
    transient: int,
    found: Columns,
    who: str,
    source: Floats | None = None,
) -> list[Task]:
    """Return tasks that drive a step through the columns, tile by tile.

    Parameters
    ----------
    loop : callable
        Of :func:`grazing.kernel.lanes.runner`.
    rows : ndarray, shape (columns, parameters)
    lanes : ndarray, shape (columns, dim, starts)
        The starts; overwritten with the last states.
    transient : int
    found : Columns
        To be filled.
    who : str
        Who is to blame if the step does not compile.
    source : ndarray, optional
        What rows point to: it must live as long as the tasks.
    """
    starts, keep, records = lanes.shape[2], found.points.shape[1], found.outcomes.shape[1]
    total = transient + keep

    def some(first: int, last: int, _held: Floats | None = source) -> Iterator[None]:
        n, stride, q = 0, max(1, TILE // (starts * (last - first))), slice(first, last)
        while n < total:
            end = min(n + stride, total)
            part = slice(max(n - transient, 0), max(end - transient, 0))
            outcomes = found.outcomes[q, part] if records > 1 and end > transient else found.outcomes[q, :1]
            before = perf_counter()
            kept = found.points[q, part], found.letters[q, part], outcomes
            call(loop, rows[q], lanes[q], max(0, min(end, transient) - n), *kept, who=who)
            if perf_counter() - before < 0.25 * LONGEST:  # long tiles cost less; the bits do not depend on them
                stride *= 2
            n = end
            yield

    # a task must be worth its handling; one that holds several columns is a single tile, whose arrays lie in one piece
    together = max(1, TILE // (starts * (total + 1)))
    return [partial(some, q, min(q + together, len(rows))) for q in range(0, len(rows), together)]
