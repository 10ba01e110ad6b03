"""A Dask cluster as an executor: on this machine, at an address, or through the queue of a computing centre."""

from __future__ import annotations

import logging
import signal
from collections.abc import Callable, Iterator
from concurrent.futures import Executor
from contextlib import ExitStack, contextmanager
from importlib import import_module
from multiprocessing import resource_tracker
from typing import Any

from grazing.interrupt import causes, held_back
from grazing.outcome import InputError, in_one_line, shown
from grazing.parameter import whole

#: Deaths of workers that one chunk may see. Dask gives up after 3, but a preempted worker is no fault of the chunk.
PATIENCE = 1000
#: How long a process of this machine may be away before another takes its place; Dask's 15 s are made for queues.
AWAY = "5s"
#: A client of ours alone: one that is Dask's default stays so if it finds no scheduler, and nothing is saved any more.
OWN = {"set_as_default": False}
#: What the processes of a local cluster begin with. Ctrl-C reaches them as well, and is for the one that they work for;
#: they speak of their memory only, as all else that they say reaches that one, or is of how a cluster ends.
ALONE = """import logging, signal
signal.signal(signal.SIGINT, signal.SIG_IGN)
logging.getLogger("distributed").setLevel(logging.CRITICAL)
logging.getLogger("distributed.worker.memory").setLevel(logging.WARNING)
"""
#: What tells, at length, how the parts of a cluster end one after another.
LOGS = ("asyncio", "distributed", "tornado", "tornado.application")
QUEUES = {
    "htcondor": "HTCondorCluster",
    "lsf": "LSFCluster",
    "moab": "MoabCluster",
    "oar": "OARCluster",
    "pbs": "PBSCluster",
    "sge": "SGECluster",
    "slurm": "SLURMCluster",
}


@contextmanager
def cluster(kind: str = "local", workers: int | None = None, **options: Any) -> Iterator[Executor]:
    """Start a Dask cluster, or join one, as an executor for :func:`run`.

    Parameters
    ----------
    kind : str
        ``"local"``: processes of this machine; an address such as ``"tcp://host:8786"``: a scheduler that runs
        already; or a queue: ``"slurm"``, ``"pbs"``, ``"sge"``, ``"lsf"``, ``"htcondor"``, ``"oar"``, ``"moab"``.
    workers : int, optional
        Processes, or jobs in the queue. None for what Dask thinks right; a queue needs a number. Dask replaces what
        is lost, such as jobs at the end of their time, so that there are as many as long as the block lasts.
    **options
        To ``distributed.LocalCluster``, ``distributed.Client`` or the cluster of dask-jobqueue: ``cores``, ``memory``,
        ``walltime``, ``queue`` and so on.

    Yields
    ------
    concurrent.futures.Executor
        The cluster ends with the block, except one that was joined.

    Raises
    ------
    InputError
        For another kind, what Dask refuses, or packages that are missing.
    """
    if workers is not None:
        workers = whole(workers, "workers", 1)
    if "n_workers" in options:  # of none a sweep would wait for ever
        raise InputError("n_workers is none of the options here; give workers")
    joined = isinstance(kind, str) and "://" in kind
    if not isinstance(kind, str) or not (kind == "local" or joined or kind in QUEUES):
        raise InputError(
            f"kind is {shown(kind)}; allowed are 'local', an address such as 'tcp://host:8786', {_quoted()}"
        )
    if kind in QUEUES and workers is None:
        raise InputError(f"workers is missing; say how many jobs to put into the queue of {kind}")
    dask, distributed = _imported("dask"), _imported("distributed")
    with dask.config.set({"distributed.scheduler.allowed-failures": PATIENCE}):
        if joined:
            with _made(distributed.Client, kind, **OWN | options) as client:
                client.run_on_scheduler(_patient())
                yield client.get_executor()
            return
        local = {"distributed.deploy.lost-worker-timeout": AWAY} if kind == "local" else {}
        with dask.config.set(local), ExitStack() as stack:
            with held_back(), _unreached():  # what is interrupted while it starts says so many times, and is not closed
                for name in LOGS:
                    stack.callback(logging.getLogger(name).setLevel, logging.getLogger(name).level)
                started = stack.enter_context(_started(kind, workers, options))
                client = stack.enter_context(distributed.Client(started, **OWN))
                for name in LOGS:
                    stack.callback(logging.getLogger(name).setLevel, logging.CRITICAL + 1)
            yield client.get_executor()


@contextmanager
def _unreached() -> Iterator[None]:
    """Let no Ctrl-C reach the threads and processes that are started here, nor those that they start."""
    if not hasattr(signal, "pthread_sigmask"):  # pragma: no cover  (Windows: a process says so once it has begun)
        yield
        return
    resource_tracker.ensure_running()  # or the thread that starts it later is reached again
    before = signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT])
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _started(kind: str, workers: int | None, options: dict[str, Any]) -> Any:
    """Start a cluster that keeps its size.

    One that is only scaled shrinks: a worker that dies while it starts, or is away too long, is never replaced, and
    once none is left a sweep would wait for ever.
    """
    if kind == "local":
        ours: dict[str, Any] = {"dashboard_address": None}
        if options.get("processes", "worker_class" not in options):  # a class may work in this process
            ours["preload"] = ALONE
        here = _made(_imported("distributed").LocalCluster, n_workers=workers, **ours | options)
        here.adapt(minimum=len(here.worker_spec), maximum=len(here.worker_spec))
        return here
    queue = _made(getattr(_imported("dask_jobqueue"), QUEUES[kind]), **options)
    queue.adapt(minimum_jobs=workers, maximum_jobs=workers)
    return queue


def _made(make: Callable[..., Any], *given: Any, **options: Any) -> Any:
    """Make a cluster, or a client; what Dask refuses was asked for."""
    try:
        return make(*given, **options)
    except (TypeError, ValueError, RuntimeError) as error:  # the last where a part of it does not start
        said = in_one_line(causes(error)[-1] if error.__cause__ else error)
        raise InputError(f"the cluster cannot be had: {said}; mend its address or its options") from error


def _patient() -> Any:
    """Return a function that travels whole: the scheduler need not have this package."""
    patience = PATIENCE

    def make_patient(dask_scheduler: Any) -> None:
        dask_scheduler.allowed_failures = max(dask_scheduler.allowed_failures, patience)

    return make_patient


def _quoted() -> str:
    return ", ".join(repr(name) for name in QUEUES)


def _imported(name: str) -> Any:
    """Return a package that only clusters need."""
    ours = signal.getsignal(signal.SIGINT)
    try:
        with held_back():
            return import_module(name)
    except ImportError as error:
        raise InputError(
            f"a cluster needs packages that are not installed ({error}); pip install 'grazing[cluster]'"
        ) from error
    finally:
        if ours is not None and signal.getsignal(signal.SIGINT) is not ours:  # dask-jobqueue lets Ctrl-C exit
            signal.signal(signal.SIGINT, ours)
