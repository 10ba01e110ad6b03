"""Run the cells of a study on threads, and refuse a result that does not fit into memory before it is begun."""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import FIRST_EXCEPTION, ThreadPoolExecutor, wait
from typing import Any

import numpy as np

from grazing.outcome import InputError
from grazing.parameter import whole
from grazing.studies.starts import mixed

Progress = Callable[[int, int], Any]


def run_cells(
    work: Callable[[int], Any], count: int, threads: int | None = None, progress: Progress | None = None
) -> None:
    """Call ``work(i)`` once for every i < count, in a scattered order, on threads.

    Compiled kernels let go of Python's lock, so that threads share the machine. An exception, or Ctrl-C, stops the
    work after the cells that are running.

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
    workers = (os.cpu_count() or 1) if threads is None else whole(threads, "threads", 1)
    order = np.argsort(mixed(np.arange(count, dtype=np.uint64)))  # neighbours cost alike: scattered, threads stay busy
    pool = ThreadPoolExecutor(max_workers=min(workers, count), thread_name_prefix="grazing")
    try:
        pending = {pool.submit(work, int(i)) for i in order}
        while pending:
            finished, pending = wait(pending, timeout=0.1, return_when=FIRST_EXCEPTION)
            for cell in finished:
                cell.result()
            if progress is not None and finished:
                progress(count - len(pending), count)
    finally:
        pool.shutdown(cancel_futures=True)


def physical_memory() -> int | None:
    """Return the memory of this machine in bytes; None where the system does not say."""
    try:
        return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    except (AttributeError, OSError, ValueError):
        return None


def refuse_too_large(size: int, reduce: str) -> None:
    """Raise InputError if a result of so many bytes would take more than half of the memory.

    Parameters
    ----------
    size : int
        Bytes.
    reduce : str
        What the user can reduce, with the present numbers.
    """
    memory = physical_memory()
    if memory is not None and size > memory / 2:
        raise InputError(
            f"the result would take {size / 1e9:.3g} GB, more than half of the memory ({memory / 1e9:.3g} GB); "
            f"reduce {reduce}"
        )
