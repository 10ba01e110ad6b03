"""Run tasks on threads: scattered, because neighbours cost alike, and stopped within one tile of work."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_EXCEPTION, ThreadPoolExecutor, wait
from threading import Event, RLock
from time import monotonic
from typing import Any

import numpy as np

from grazing.kernel.random import mixed
from grazing.outcome import InputError, shown
from grazing.parameter import whole

#: Working precision of balls belongs to the process, not to the thread: who sets it holds this for so long.
LOCK = RLock()
if hasattr(os, "register_at_fork"):  # a fork has none of the other threads, and waits for none
    os.register_at_fork(after_in_child=LOCK._at_fork_reinit)  # type: ignore[attr-defined]

#: Seconds after which progress is told once more though no task has finished.
STILL = 1.0
Progress = Callable[[int, int], Any]
#: A task does its work tile by tile, each well under 0.2 s, and yields after every tile.
Task = Callable[[], Iterator[None]]


def workers_of(threads: int | None) -> int:
    """Return the number of threads that is meant; None is one per processor."""
    return (os.cpu_count() or 1) if threads is None else whole(threads, "threads", 1)


def checked_progress(progress: Any) -> Any:
    """Return what is called as work goes on, or raise InputError."""
    if progress is not None and not callable(progress):
        raise InputError(f"progress is {shown(progress)}; give a function of two numbers, progress(done, total)")
    return progress


def run_tasks(tasks: Sequence[Task], threads: int | None = None, progress: Progress | None = None) -> None:
    """Run every task once, in a scattered order, on threads.

    Compiled kernels let go of Python's lock, so that threads share the machine. An exception, or Ctrl-C, stops the
    work after the tiles that are running.

    Parameters
    ----------
    tasks : sequence of callable
        Each must depend on no other.
    threads : int, optional
        None for one per processor.
    progress : callable, optional
        ``progress(done, total)``, called from the calling thread as tasks finish, and about once a second meanwhile.

    Raises
    ------
    InputError
        For threads that are not a whole number >= 1, or a progress that cannot be called.
    """
    workers, progress = workers_of(threads), checked_progress(progress)
    last = monotonic()

    def told(done: int, news: bool) -> None:
        nonlocal last
        if progress is not None and (news or monotonic() - last > STILL):
            last = monotonic()
            progress(done, len(tasks))

    order = np.argsort(mixed(np.arange(len(tasks), dtype=np.uint64))) if len(tasks) > 1 else range(len(tasks))
    if workers == 1 or len(tasks) <= 1:
        for done, i in enumerate(order):
            for _tile in tasks[i]():
                told(done, False)
            told(done + 1, True)
        return
    stop = Event()

    def work(task: Task) -> None:
        for _tile in task():
            if stop.is_set():
                return

    pool = ThreadPoolExecutor(max_workers=min(workers, len(tasks)), thread_name_prefix="grazing")
    try:
        pending = {pool.submit(work, tasks[i]) for i in order}
        while pending:
            finished, pending = wait(pending, timeout=0.1, return_when=FIRST_EXCEPTION)
            for one in finished:
                one.result()
            told(len(tasks) - len(pending), bool(finished))
    finally:
        stop.set()
        pool.shutdown(cancel_futures=True)
