"""Run the cells of a study on threads."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

from grazing.kernel.pool import Progress as Progress
from grazing.kernel.pool import run_tasks


def run_cells(
    work: Callable[[int], Any], count: int, threads: int | None = None, progress: Progress | None = None
) -> None:
    """Call ``work(i)`` once for every i < count, in a scattered order, on threads.

    Parameters
    ----------
    work : callable
        Writes what it computes; must depend on nothing but i.
    count : int
        Number of cells.
    threads : int, optional
        None for one per processor.
    progress : callable, optional
        ``progress(done, count)``, called from the calling thread.

    Raises
    ------
    InputError
        For threads that are not a whole number >= 1.
    """

    def task(i: int) -> Iterator[None]:
        work(i)
        yield

    run_tasks([partial(task, i) for i in range(count)], threads, progress)
