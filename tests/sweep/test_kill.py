import os
import random
import shutil
import signal
import time

import pytest

from grazing import sweep
from tests.sweep.nursery import nursery
from tests.sweep.plans import files, plan

pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="processes are forked, to be killed by signals")

SWEEP = {"n": 24, "together": 2, "pause": 0.002}


@pytest.fixture(scope="module")
def start():
    with nursery() as start:
        yield start


@pytest.fixture(scope="module")
def whole(tmp_path_factory, start):
    """The files of an undisturbed run, and how long it takes."""
    folder = tmp_path_factory.mktemp("whole")
    assert start(folder / "warm.zarr", SWEEP, chunk=2).wait() == 0
    begun = time.perf_counter()
    assert start(folder / "whole.zarr", SWEEP, chunk=2).wait() == 0
    return files(folder / "whole.zarr"), time.perf_counter() - begun


def kill_and_resume(folder, start, whole, moment, **options):
    expected, duration = whole
    store = folder / "a.zarr"
    victim = start(store, SWEEP, chunk=2, **options)
    time.sleep(moment * duration)
    victim.signal(signal.SIGKILL)
    assert victim.wait() in (0, -signal.SIGKILL)
    before = sweep.status(store).chunks_done if store.exists() else 0
    found = sweep.run(plan(**SWEEP), store, chunk=2)
    assert found.complete and not found.running
    assert files(store) == expected
    assert [file.name for file in folder.iterdir()] == ["a.zarr"]
    shutil.rmtree(store)
    return before


@pytest.mark.parametrize("seed", range(5))
def test_killed_at_any_moment_it_is_resumed_to_the_same_bytes(tmp_path, start, whole, seed):
    kill_and_resume(tmp_path, start, whole, random.Random(seed).uniform(0.1, 1.0))


@pytest.mark.long
def test_killed_a_hundred_times(tmp_path, start, whole):
    moments = random.Random(0)
    found = [kill_and_resume(tmp_path, start, whole, moments.uniform(0.0, 1.1)) for _ in range(100)]
    assert len(set(found)) > 6  # the moments were spread


@pytest.mark.long
def test_killed_again_and_again_on_one_store(tmp_path, start, whole):
    expected, duration = whole
    store, moments = tmp_path / "a.zarr", random.Random(1)
    for kill in range(100):  # noqa: B007
        victim = start(store, SWEEP, chunk=2)
        time.sleep(moments.uniform(0.0, 0.35) * duration)
        victim.signal(signal.SIGKILL)
        if victim.wait() == 0:
            break
    assert kill > 3
    sweep.run(plan(**SWEEP), store)
    assert files(store) == expected


def test_shards_start_together_on_nothing_and_one_is_killed(tmp_path, start, whole):
    expected, duration = whole
    store = tmp_path / "a.zarr"
    shards = [start(store, SWEEP, chunk=2, shard=(i, 3)) for i in (1, 2, 3)]
    time.sleep(duration * 0.3)
    shards[1].signal(signal.SIGKILL)
    codes = [shard.wait() for shard in shards]
    assert codes[0] == codes[2] == 0 and codes[1] in (0, -signal.SIGKILL)
    assert sweep.run(plan(**SWEEP), store, shard=(2, 3)).complete
    assert files(store) == expected
    assert [file.name for file in tmp_path.iterdir()] == ["a.zarr"]


def test_ctrl_c_stops_and_loses_nothing(tmp_path, start, whole):
    expected, _duration = whole
    store = tmp_path / "a.zarr"
    victim = start(store, SWEEP | {"pause": 0.1}, chunk=2)
    while len(list(store.glob("done/c/*"))) < 2:
        time.sleep(0.01)
    victim.signal(signal.SIGINT)
    assert victim.wait() == 130
    found = sweep.status(store)
    assert 0 < found.chunks_done < found.chunks and not found.running
    seen = []
    assert sweep.run(plan(**SWEEP), store, progress=lambda done, total: seen.append((done, total))).complete
    assert seen[0][0] > 2 * found.chunks_done and seen[-1] == (24, 24)
    assert files(store) == expected


def test_a_second_process_is_refused_by_name(tmp_path, start):
    store = tmp_path / "a.zarr"
    first = start(store, SWEEP | {"pause": 0.5}, chunk=2)
    while not (store / ".grazing" / "locks" / "all.lock").exists():
        time.sleep(0.01)
    said = f"is being worked on by a run of the whole sweep \\(process {first.pid} on "
    with pytest.raises(ValueError, match=said):
        sweep.run(plan(**SWEEP), store)
    with pytest.raises(ValueError, match=said):
        sweep.run(plan(**SWEEP), store, shard=(1, 2))
    (running,) = sweep.status(store).running
    assert running.pid == first.pid
    first.signal(signal.SIGKILL)
    first.wait()
    assert not sweep.status(store).running
    assert sweep.run(plan(**SWEEP), store).complete
