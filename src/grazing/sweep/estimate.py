"""What a sweep will take, before it is begun: bytes, memory, and time from a few of its cells."""

from __future__ import annotations

import os
from dataclasses import dataclass
from math import prod
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from grazing.kernel.compile import compiler_time
from grazing.kernel.random import mixed
from grazing.parameter import whole
from grazing.studies.plan import Plan, empty_arrays
from grazing.sweep.grid import Chunk, checked_plan, grid_of, seconds_per_step
from grazing.sweep.run import COPIES

#: Seconds that timing goes on, those of the compiler left out.
PATIENCE = 1.0
#: Bytes of a cell beyond which it is not tried: a dry run takes little of anything.
TRIED = 2**28


@dataclass(frozen=True)
class Estimate:
    """What a sweep will take.

    Parameters
    ----------
    title : str
    shape, chunk : dict of str to int
        Cells along each axis, in all and in a chunk.
    chunks, cells : int
    bytes : int
        Of the result, not compressed.
    memory : int
        Bytes in use at a time, on all threads.
    threads : int
    timed : int
        Cells that were timed; 0 if not one was finished in time.
    seconds : float
        On all threads. A lower bound if no cell was finished and it is not rough.
    rough : bool
        Whether a cell is too large to be tried out, and the time is a rule of thumb from the number of steps.
    """

    title: str
    shape: dict[str, int]
    chunk: dict[str, int]
    chunks: int
    cells: int
    bytes: int
    memory: int
    threads: int
    timed: int
    seconds: float
    rough: bool = False

    def __str__(self) -> str:
        sizes = " x ".join(f"{size} {name}" for name, size in self.shape.items()) or "1 cell"
        word, of = ("about" if self.timed else "more than"), f"{self.timed} cells"
        if self.rough:
            word, of = "roughly", "the number of steps: a cell is too large to be tried out"
        time = f"{word} {_duration(self.seconds)}"
        chunks = "1 chunk" if self.chunks == 1 else f"{self.chunks} chunks"
        return (
            f"{self.title}: {sizes} = {self.cells} cells in {chunks}\n"
            f"{self.bytes / 1e6:.3g} MB before compression, {self.memory / 1e6:.3g} MB of memory at a time\n"
            f"{time} on {self.threads} threads, from {of}"
        )


def estimate(plan: Plan, chunk: Chunk = None, *, threads: int | None = None) -> Estimate:
    """Say what a sweep will take; nothing is written.

    Parameters
    ----------
    plan : Plan
    chunk : int or mapping of str to int, optional
        See :func:`run`.
    threads : int, optional
        None for one per processor.

    Returns
    -------
    Estimate
        Times from cells all over the plan, computed for about a second; a first use compiles before that, which does
        not count.

    Raises
    ------
    InputError
        For a chunk or threads that are not allowed, or a plan whose cells depend on each other.

    Examples
    --------
    >>> import numpy as np, grazing as gz
    >>> from grazing import sweep
    >>> G = gz.gap_map(lam=0.8, mu=0.1, l=0.2)
    >>> plan = gz.plans.density(G, "mu", np.linspace(0.0, 0.3, 8), starts=3)
    >>> found = sweep.estimate(plan, chunk=2)
    >>> found.chunks, found.bytes > 60_000, found.seconds < 10.0
    (4, True, True)
    """
    grid = grid_of(checked_plan(plan), chunk)
    workers = (os.cpu_count() or 1) if threads is None else whole(threads, "threads", 1)
    rough = plan.size_of_cell + plan.working > TRIED
    timed, seconds = (0, 0.0) if rough else _seconds_per_cell(plan)
    if not timed and plan.work * seconds_per_step(plan) > seconds:
        rough, seconds = True, plan.work * seconds_per_step(plan)
    busy, size = min(workers, max(grid.count, 1)), prod(grid.chunk)
    return Estimate(
        plan.title,
        dict(zip(plan.axes, grid.shape, strict=True)),
        dict(zip(plan.axes, grid.chunk, strict=True)),
        grid.count,
        plan.cells,
        plan.cells * _stored_size(plan),
        busy * (size * plan.size_of_cell * COPIES + min(size, max(1, plan.together)) * plan.working),
        workers,
        timed,
        seconds * plan.cells / busy,
        rough,
    )


def _duration(seconds: float) -> str:
    """Return a time in the unit that suits it."""
    for unit, size in (("days", 86400.0), ("h", 3600.0), ("min", 60.0)):
        if seconds >= 2.0 * size:
            return f"{seconds / size:.1f} {unit}"
    return f"{seconds:.2g} s" if seconds < 10.0 else f"{seconds:.0f} s"


def _stored_size(plan: Plan) -> int:
    """Return the bytes that a cell takes in the store."""
    sizes = {name: variable.longest if variable.kind == "text" else variable.dtype.itemsize
             for name, variable in plan.variables.items()}  # fmt: skip
    return sum(prod(plan.shape_of(name)) * size for name, size in sizes.items())


def _seconds_per_cell(plan: Plan) -> tuple[int, float]:
    """Time cells, more and more together as a chunk would compute them; return how many, and the time of one."""
    order: NDArray[np.int64] = np.argsort(mixed(np.arange(min(plan.cells, 1 << 20), dtype=np.uint64)))
    if not len(order):
        return 0, 0.0
    order = order * (plan.cells // len(order))  # all over a plan of very many cells
    finished, seconds = _time(plan, order[:1], PATIENCE)
    if not finished:  # it may have loaded packages and kernels, which takes seconds on a busy machine
        finished, seconds = _time(plan, order[:1], PATIENCE)
    if not finished:
        return 0, seconds
    count, best, left = 1, (1, seconds), PATIENCE
    while left > 0.0:
        finished, seconds = _time(plan, order[:count], left)
        if not finished:
            break
        best, left = (count, seconds / count), left - seconds
        if count >= min(plan.together, len(order)):
            break
        count = min(4 * count, plan.together, len(order))
    return best


def _time(plan: Plan, cells: NDArray[np.int64], patience: float) -> tuple[bool, float]:
    """Compute cells for a limited time, that of the compiler left out; return whether that was enough."""
    arrays = empty_arrays(plan, len(cells))
    with compiler_time() as compiling:
        begun = perf_counter()
        for _tile in plan.compute(np.sort(cells), arrays):
            if perf_counter() - begun - compiling() > patience:
                return False, perf_counter() - begun - compiling()
        return True, perf_counter() - begun - compiling()
