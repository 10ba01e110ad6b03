import os
import signal
import sys
import threading
import time
from contextlib import suppress

import pytest

import grazing as gz
from grazing import sweep
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


def test_a_queue_gets_its_jobs(monkeypatch):
    pytest.importorskip("distributed")
    jobqueue = pytest.importorskip("dask_jobqueue")
    asked = {}

    class Queue:
        def __init__(self, **options):
            asked.update(options)

        def scale(self, jobs):
            asked["jobs"] = jobs
            raise ZeroDivisionError

    monkeypatch.setattr(jobqueue, "SLURMCluster", Queue)
    with pytest.raises(ZeroDivisionError), sweep.cluster("slurm", 5, cores=8, memory="4GB", queue="long"):
        pass
    assert asked == {"cores": 8, "memory": "4GB", "queue": "long", "jobs": 5}


@pytest.mark.long
@pytest.mark.filterwarnings("default")
def test_dask_workers_are_killed_and_the_bytes_stay(tmp_path):
    pytest.importorskip("distributed")
    some = plan(400, together=2, pause=0.01)
    sweep.run(plan(400), tmp_path / "expected.zarr", chunk=4)
    with sweep.cluster("local", 2, threads_per_worker=1) as executor:
        client = executor._client

        store, killed = tmp_path / "a.zarr", []

        def kill():
            for count in range(3, 75, 8):
                while len(list(store.glob("done/c/?*"))) < count:
                    time.sleep(0.02)
                with suppress(OSError):  # a worker that died just now
                    pid = next(iter(client.run(os.getpid).values()))
                    os.kill(pid, signal.SIGKILL)
                    killed.append(pid)

        killer = threading.Thread(target=kill, daemon=True)
        killer.start()
        found = sweep.run(some, store, chunk=4, executor=executor)
        killer.join()
        assert found.complete and len(set(killed)) > 3
        assert files(store) == files(tmp_path / "expected.zarr")
        assert client.run_on_scheduler(lambda dask_scheduler: dask_scheduler.allowed_failures) == 1000

        with sweep.cluster(client.scheduler.address) as joined:
            assert sweep.run(some, tmp_path / "b.zarr", chunk=40, executor=joined).complete
        assert client.run(os.getpid)  # the cluster that was joined goes on
