"""Run a sweep: compute the missing chunks of a store, on threads, as a shard, or on an executor."""

from __future__ import annotations

import os
import socket
import sys
from concurrent.futures import Executor
from datetime import UTC, datetime
from functools import partial
from math import prod
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grazing.memory import refuse_too_large
from grazing.outcome import InputError
from grazing.parameter import in_order, whole
from grazing.pool import checked_progress, run_tasks
from grazing.studies.labels import versions
from grazing.studies.plan import Plan, Progress
from grazing.sweep.executors import run_on_executor
from grazing.sweep.grid import Chunk, checked_plan, grid_of
from grazing.sweep.lock import locked
from grazing.sweep.manifest import SEAL
from grazing.sweep.mend import said
from grazing.sweep.opened import exists, open_existing
from grazing.sweep.same import refuse_another
from grazing.sweep.status import Status, status_of
from grazing.sweep.store import Store, folder_of
from grazing.sweep.task import chunk_task, note_run, plan_from_recipe
from grazing.sweep.template import create, tidy

Shard = tuple[int, int] | None
#: Copies of a chunk in memory while it is computed: its numbers, what is written, and that compressed.
COPIES = 3


def run(
    plan: Plan,
    store: str | os.PathLike[str],
    *,
    chunk: Chunk = None,
    shard: Shard = None,
    executor: Executor | None = None,
    threads: int | None = None,
    progress: Progress | None = None,
    other_code: bool = False,
    fsync: bool = False,
) -> Status:
    """Compute a plan into a store, chunk by chunk; what is there already is kept.

    Whatever ends it, Ctrl-C, kill -9 or a full disk, the chunks that are done are safe, and the same call, or
    :func:`resume`, goes on. The store has the same bytes in the end, whatever it went through, except below its
    folder ``.grazing`` with locks and times.

    Parameters
    ----------
    plan : Plan
        From :mod:`grazing.plans` or :func:`grazing.config.plan_of`.
    store : path-like
        A folder, which is made. One that holds this very sweep is completed; anything else there is refused.
    chunk : int or mapping of str to int, optional
        Cells in a chunk, or along some axes. None for chunks of a few seconds.
    shard : (int, int), optional
        Compute share i of n, i = 1 .. n. Shards may run at the same time, on any machines that share the disk.
    executor : concurrent.futures.Executor, optional
        Such as from :func:`cluster`. None for threads of this process.
    threads : int, optional
        None for one per processor; the result does not depend on it.
    progress : callable, optional
        ``progress(done, total)``, called now and then with a number of cells, earlier ones included.
    other_code : bool
        Go on although the step, this package or one that it computes with is not the one that the store was begun
        with; the result then says which cells were made by what.
    fsync : bool
        Force every chunk to the disk before it counts as done, so that a power cut loses no more than a crash.

    Returns
    -------
    Status

    Raises
    ------
    InputError
        For a plan whose cells depend on each other; a folder that holds something else, another sweep (what differs
        is named), or that cannot be written; a store that somebody else works on.
    GrazingError
        If the disk fills up or the workers are lost; the store can be resumed.

    Examples
    --------
    >>> import tempfile, numpy as np, grazing as gz
    >>> from grazing import sweep
    >>> G = gz.gap_map(lam=0.8, mu=0.1, l=0.2)
    >>> plan = gz.plans.density(G, "mu", np.linspace(0.0, 0.3, 8), starts=3)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     half = sweep.run(plan, f"{folder}/a.zarr", chunk=2, shard=(1, 2))
    ...     both = sweep.run(plan, f"{folder}/a.zarr")
    >>> half.chunks_done, both.chunks_done, both.complete
    (2, 4, True)
    """
    path = folder_of(store)
    checked_progress(progress)
    plan, shard = checked_plan(plan), _checked(shard, executor, threads)
    grid = grid_of(plan, chunk)
    tidy(path)
    if not exists(path):
        create(path, plan, grid, fsync)
    found = open_existing(path, fsync)
    if found.template is None:
        raise InputError(
            f"{path} was begun by version 0.1, which wrote no manifest: it can be read, but nothing says that its "
            f"chunks are what was written, so it is not gone on with; give another folder"
        )
    refuse_another(found, plan, chunk, other_code)
    if len(_missing(found, shard)) or _to_be_sealed(found):
        _complete(found, plan, shard, executor, threads, progress, other_code)
        found = open_existing(path)  # its seal was written
    return status_of(found)


def resume(
    store: str | os.PathLike[str],
    plan: Plan | None = None,
    *,
    shard: Shard = None,
    executor: Executor | None = None,
    threads: int | None = None,
    progress: Progress | None = None,
    other_code: bool = False,
    fsync: bool = False,
    code: str | None = None,
) -> Status:
    """Go on with a sweep.

    Parameters
    ----------
    store : path-like
    plan : Plan, optional
        Needed if the store keeps no recipe to make it from: that of a map or a law of one's own.
    shard, executor, threads, progress, other_code, fsync
        See :func:`run`.
    code : {"trust"}, optional
        Run the file of your own that the recipe names. Without it, and without a plan, such a store is refused.

    Returns
    -------
    Status

    Raises
    ------
    InputError
        If there is no sweep, or the plan is missing or another one.

    Examples
    --------
    >>> import tempfile, numpy as np, grazing as gz
    >>> from grazing import sweep
    >>> G = gz.gap_map(lam=0.8, mu=0.1, l=0.2)
    >>> plan = gz.plans.density(G, "mu", np.linspace(0.0, 0.3, 8), starts=3)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     half = sweep.run(plan, f"{folder}/a.zarr", chunk=2, shard=(1, 2))
    ...     sweep.resume(f"{folder}/a.zarr", plan).complete
    True
    """
    found = open_existing(folder_of(store))
    plan = plan_from_recipe(found, code) if plan is None else plan
    options: dict[str, Any] = {"shard": shard, "executor": executor, "threads": threads, "progress": progress}
    return run(plan, found.path, other_code=other_code, fsync=fsync, **options)


def _checked(shard: Any, executor: Any, threads: Any) -> Shard:
    if executor is not None and not isinstance(executor, Executor):
        raise InputError(f"executor is {executor!r}; give a concurrent.futures.Executor, such as from sweep.cluster")
    if executor is not None and threads is not None:
        raise InputError("threads and executor are both given; the executor decides how many workers there are")
    if shard is None:
        return None
    if executor is not None:
        raise InputError("shard and executor are both given; a shard needs no executor, an executor needs no shards")
    try:
        i, n = in_order(shard)
    except (TypeError, ValueError):
        raise InputError(f"shard is {shard!r}; give (i, n), share i of n") from None
    n = whole(n, "shard[1]", 1)
    i = whole(i, "shard[0]", 1)
    if i > n:
        raise InputError(f"shard is {i}/{n}; allowed are 1/{n} to {n}/{n}")
    return i, n


def _share(store: Store, shard: Shard) -> NDArray[np.int64]:
    """Return the chunks that are ours."""
    first, step = (0, 1) if shard is None else (shard[0] - 1, shard[1])
    return np.arange(first, store.grid.count, step)


def _missing(store: Store, shard: Shard) -> NDArray[np.int64]:
    """Return the chunks that are ours and not done, or not whole."""
    share = _share(store, shard)
    return share[[not store.is_whole(int(number)) for number in share]] if len(share) else share


def _to_be_sealed(store: Store) -> bool:
    """Whether a run ended after its last chunk and before the seal."""
    return not os.path.lexists(store.path / SEAL) and bool(store.done().all())


def _complete(
    store: Store,
    plan: Plan,
    shard: Shard,
    executor: Executor | None,
    threads: int | None,
    progress: Progress | None,
    other_code: bool,
) -> None:
    """Compute the missing chunks of our share, alone on it."""
    workers = (os.cpu_count() or 1) if threads is None else whole(threads, "threads", 1)
    if executor is None:
        cells = prod(store.grid.chunk)
        size = cells * plan.size_of_cell * COPIES + min(cells, max(1, plan.together)) * plan.working
        refuse_too_large(workers * size, f"use smaller chunks {store.grid.chunk}, or fewer threads ({workers})")
    with locked(store.locks, shard):
        numbers = [int(number) for number in _missing(store, shard)]
        if numbers:
            store.unseal()
        # everywhere if we are alone: also what another left, whose lock was removed, beside a chunk that is done
        with said(store.path):
            store.remove_partials(None if shard is None else numbers)
        note_run(store, _line(shard, executor))
        total, left = (sum(store.grid.size(int(i)) for i in some) for some in (_share(store, shard), numbers))

        def finished(done: int, count: int) -> None:
            if progress is not None:  # chunks are alike: their number stands for their cells
                progress(total - round(left * (count - done) / count), total)

        if executor is not None:
            run_on_executor(plan, store, numbers, executor, finished, other_code)
            with said(store.path):
                store.remove_partials(numbers)  # of workers that were killed, whose chunks others have written
        else:
            run_tasks([partial(chunk_task, plan, store, number) for number in numbers], workers, finished)
        store.seal_if_complete()


def _line(shard: Shard, executor: Executor | None) -> dict[str, Any]:
    """Return what the history says of a run."""
    return {
        "time": datetime.now(UTC).isoformat(timespec="seconds"),
        "host": socket.gethostname(),
        "pid": os.getpid(),
        "shard": None if shard is None else f"{shard[0]}/{shard[1]}",
        "executor": type(executor).__name__ if executor is not None else None,
        "command": sys.argv,
        "versions": versions(),
    }
