import os
import random
import signal
import subprocess
import sys
import threading
from contextlib import suppress
from importlib.util import find_spec

import pytest

import grazing as gz
from grazing import sweep
from grazing.sweep.cluster import _imported
from tests.sweep.plans import files, plan


@pytest.mark.parametrize(
    ("kind", "workers", "said"),
    [
        (
            "kubernetes",
            2,
            "kind is 'kubernetes'; allowed are 'local', an address such as 'tcp://host:8786', 'htcondor'",
        ),
        ("slurm", None, "workers is missing; say how many jobs to put into the queue of slurm"),
        ("local", 0, "workers = 0; allowed is a whole number >= 1"),
    ],
)
def test_what_is_not_allowed(kind, workers, said):
    with pytest.raises(gz.InputError, match=said), sweep.cluster(kind, workers):
        pass


@pytest.mark.parametrize(("kind", "package"), [("local", "dask"), ("tcp://host:1", "distributed")])
def test_missing_packages_are_said_once(monkeypatch, kind, package):
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(
        gz.InputError, match=r"needs packages that are not installed .*pip install 'grazing\[cluster\]'"
    ):
        with sweep.cluster(kind, 1):
            pass


@pytest.mark.parametrize(
    ("kind", "options", "said"),
    [
        ("http://host:1", {}, "unknown address scheme 'http'"),
        ("tcp://", {}, "missing port number"),
        ("tcp://127.0.0.1:1", {"nope": 1}, "nexpected keyword"),
        ("local", {"processes": False, "nope": 1}, "nexpected keyword"),
        ("local", {"nope": 1}, "nexpected keyword"),
        ("local", {"interface": "nope"}, "had: 'nope' is not a valid network interface"),
        ("local", {"n_workers": 0}, "n_workers is none of the options here; give workers"),
    ],
)
def test_what_dask_refuses_is_said_and_changes_no_setting_of_it(kind, options, said):
    dask, _distributed = pytest.importorskip("dask"), pytest.importorskip("distributed")
    before = dask.config.get("scheduler", None)
    with pytest.raises(gz.InputError, match=said), sweep.cluster(kind, 1, **options):
        pass
    assert dask.config.get("scheduler", None) == before


def test_a_scheduler_that_does_not_answer_changes_no_setting():
    dask, _distributed = pytest.importorskip("dask"), pytest.importorskip("distributed")
    with pytest.raises(OSError, match="Timed out"), sweep.cluster("tcp://127.0.0.1:1", timeout=1):
        pass
    assert dask.config.get("scheduler", None) is None  # or nothing is saved any more: xarray asks for it


def test_a_queue_gets_its_jobs(monkeypatch):
    pytest.importorskip("distributed")
    if find_spec("dask_jobqueue") is None:
        pytest.skip("no dask-jobqueue")
    before = signal.getsignal(signal.SIGINT)
    jobqueue = _imported("dask_jobqueue")
    assert signal.getsignal(signal.SIGINT) is before  # Ctrl-C is no sys.exit() from then on
    asked = {}

    class Queue:
        def __init__(self, **options):
            asked.update(options)

        def adapt(self, **jobs):
            asked.update(jobs)
            raise ZeroDivisionError

    monkeypatch.setattr(jobqueue, "SLURMCluster", Queue)
    with pytest.raises(ZeroDivisionError), sweep.cluster("slurm", 5, cores=8, memory="4GB", queue="long"):
        pass
    assert asked == {"cores": 8, "memory": "4GB", "queue": "long", "minimum_jobs": 5, "maximum_jobs": 5}


SWEEP = {"n": 400, "together": 2, "pause": 0.008}


@pytest.fixture(scope="module")
def expected(tmp_path_factory):
    """The files of an undisturbed run."""
    folder = tmp_path_factory.mktemp("expected")
    sweep.run(plan(n=SWEEP["n"]), folder / "a.zarr", chunk=4)
    return files(folder / "a.zarr")


def kill_workers(cluster, store, moments, count, killed, over):
    """Kill so many workers of a cluster, spread over a sweep: mostly those that are up, now and then one that starts.

    Their numbers come from the nannies in this process: to ask the workers would need one that answers.
    """
    chunks = SWEEP["n"] // 4
    for wanted in sorted(moments.choices(range(chunks), k=count)):
        late, before = moments.random() < 0.8, len(killed)
        while len(list(store.glob("done/c/?*"))) < wanted and not over.wait(0.01):
            pass
        over.wait(moments.uniform(0.0, 0.05))
        while len(killed) == before and not over.wait(0.01):
            processes = [nanny.process for nanny in list(cluster.workers.values())]
            alive = {each.pid for each in processes if each and (each.status.name == "running" or not late)}
            victims = sorted(alive - {None, *killed})
            if victims:
                with suppress(ProcessLookupError):  # one that died just now
                    os.kill(pid := moments.choice(victims), signal.SIGKILL)
                    killed.append(pid)


def killed_at_random_moments(executor, store, expected, seed, count):
    """Kill so many workers during a sweep, which ends with the expected bytes; return them."""
    killed, over = [], threading.Event()
    killer = threading.Thread(
        target=kill_workers,
        args=(executor._client.cluster, store, random.Random(seed), count, killed, over),
        daemon=True,
    )
    killer.start()
    try:
        assert sweep.run(plan(**SWEEP), store, chunk=4, executor=executor).complete
    finally:
        over.set()
        killer.join()
    assert files(store) == expected
    return killed


@pytest.mark.filterwarnings("default")
def test_dask_workers_are_killed_and_the_bytes_stay(tmp_path, expected):
    pytest.importorskip("distributed")
    with sweep.cluster("local", 2, threads_per_worker=1) as executor:
        assert len(killed_at_random_moments(executor, tmp_path / "a.zarr", expected, seed=0, count=3)) == 3


@pytest.mark.long
@pytest.mark.filterwarnings("default")
def test_a_hundred_dask_workers_are_killed_and_the_bytes_stay(tmp_path, expected):
    pytest.importorskip("distributed")
    with sweep.cluster("local", 2, threads_per_worker=1) as executor:
        killed = []
        for i in range(10):
            killed += killed_at_random_moments(executor, tmp_path / f"{i}.zarr", expected, seed=i, count=11)
        assert len(set(killed)) >= 100  # the last ones of a sweep may come too late
        executor._client.wait_for_workers(2, timeout=60)  # what was killed is replaced


@pytest.mark.filterwarnings("default")
def test_the_cluster_that_was_joined_goes_on(tmp_path, expected):
    distributed = pytest.importorskip("distributed")
    with (
        distributed.LocalCluster(
            1, processes=False, protocol="tcp", threads_per_worker=1, dashboard_address=None
        ) as here,
        distributed.Client(here) as client,
    ):
        with sweep.cluster(client.scheduler.address) as joined:
            assert sweep.run(plan(n=SWEEP["n"]), tmp_path / "a.zarr", chunk=40, executor=joined).complete
        assert client.run_on_scheduler(lambda dask_scheduler: dask_scheduler.allowed_failures) == 1000
        assert client.run(os.getpid)


INTERRUPTED = """
import os, signal, sys, threading
import dask, distributed
from grazing import sweep
from tests.sweep.plans import plan

def stop(done=3, of=0):
    if done > 2:
        os.killpg(0, signal.SIGINT)

def fail(done, of):
    raise KeyboardInterrupt

signal.signal(signal.SIGINT, signal.default_int_handler)
after, progress = {"starts": (0.5, None), "runs": (None, stop), "fails": (None, fail)}[sys.argv[2]]
if after is not None:
    threading.Timer(after, stop).start()
try:
    with sweep.cluster("local", 1, threads_per_worker=1) as executor:
        sweep.run(plan(n=400, pause=0.1), sys.argv[1], chunk=4, executor=executor, progress=progress)
except KeyboardInterrupt:
    print("interrupted")
"""


@pytest.mark.skipif(not hasattr(os, "killpg"), reason="POSIX groups of processes")
@pytest.mark.parametrize("when", ["starts", "runs", "fails"])
def test_ctrl_c_which_all_processes_of_a_terminal_get_is_said_once(tmp_path, when):
    """Each process of a cluster said it, and Dask how each of its parts ended."""
    pytest.importorskip("distributed")
    command = [sys.executable, "-c", INTERRUPTED, tmp_path / "a.zarr", when]
    ended = subprocess.run(command, capture_output=True, text=True, start_new_session=True, timeout=600)
    assert (ended.stdout, ended.stderr) == ("interrupted\n", "")


def test_a_cluster_of_workers_in_this_process_leaves_it_its_interrupts():
    distributed, before = pytest.importorskip("distributed"), signal.getsignal(signal.SIGINT)
    with sweep.cluster("local", 1, threads_per_worker=1, worker_class=distributed.Worker) as executor:
        assert executor.submit(abs, -3).result(timeout=60) == 3
        assert signal.getsignal(signal.SIGINT) is before
