"""Run chunks on any executor of :mod:`concurrent.futures`: indices go out, workers write their own chunks."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import (
    FIRST_COMPLETED,
    BrokenExecutor,
    CancelledError,
    Executor,
    Future,
    ThreadPoolExecutor,
    wait,
)
from functools import partial

from grazing.outcome import GrazingError, in_one_line
from grazing.studies.plan import Plan, Progress
from grazing.sweep.store import Store
from grazing.sweep.task import compute_chunk, finish_chunk, own_of, send_plan

#: Chunks handed out at a time: enough for any cluster, few enough to call back.
WINDOW = 2000


def run_on_executor(
    plan: Plan,
    store: Store,
    numbers: Sequence[int],
    executor: Executor,
    progress: Progress | None,
    other_code: bool = False,
) -> None:
    """Compute chunks on an executor.

    An exception, or Ctrl-C, calls back what has not begun; what is running ends by itself.

    Raises
    ------
    GrazingError
        If workers or the executor are lost for good; the store can be resumed.
    """
    if isinstance(executor, ThreadPoolExecutor):  # threads of this process have the plan at hand
        task = partial(finish_chunk, plan, store)
    else:
        task = partial(compute_chunk, *send_plan(plan, store, other_code), own=own_of(plan))
    waiting = iter(numbers)
    pending: set[Future[int | GrazingError]] = set()
    finished = 0
    try:
        while True:
            for number in waiting:
                pending.add(_submitted(executor, task, number, store))
                if len(pending) >= WINDOW:
                    break
            if not pending:
                return
            done, pending = wait(pending, return_when=FIRST_COMPLETED)
            for one in done:
                if isinstance(said := one.result(), GrazingError):
                    raise said
            finished += len(done)
            if progress is not None:
                progress(finished, len(numbers))
    except (BrokenExecutor, CancelledError) as error:
        raise _lost(store, error) from error
    except GrazingError:
        raise
    except Exception as error:
        if type(error).__module__.partition(".")[0] == "distributed":
            raise _lost(store, error) from error
        raise
    finally:
        for one in pending:
            one.cancel()


def _submitted(executor: Executor, task: Callable[[int], int], number: int, store: Store) -> Future[int | GrazingError]:
    """Hand a chunk to an executor; one that was shut down, as behind its ``with``, takes none."""
    try:
        return executor.submit(chunk_or_error, task, number)
    except GrazingError:
        raise
    except RuntimeError as error:
        raise _lost(store, error) from error


def chunk_or_error(task: Callable[[int], int], number: int) -> int | GrazingError:
    """Compute a chunk on a worker; return its number, or the error that says what is wrong.

    It is returned, since a cluster prints what a task raises, whole and once a worker, before it hands it on.
    """
    try:
        return task(number)
    except GrazingError as error:
        return error


def _lost(store: Store, error: BaseException) -> GrazingError:
    return GrazingError(
        f"the executor gave up ({type(error).__name__}: {in_one_line(error)}). What is done is kept in {store.path}; "
        f"resume it"
    )
