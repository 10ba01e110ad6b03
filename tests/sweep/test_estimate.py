import sys
import time

import pytest

import grazing as gz
from grazing import sweep
from tests.sweep.plans import plan


def test_sizes_are_those_of_the_sweep(tmp_path):
    some = plan(50, 4, together=8)
    found = sweep.estimate(some, 16, threads=2)
    run = sweep.run(some, tmp_path / "a.zarr", chunk=16)
    assert (found.cells, found.chunks, found.shape, found.chunk) == (run.cells, run.chunks, run.shape, run.chunk)
    assert found.bytes == 200 * (3 * 4 * 8 + 4 + 4 + 3 * 4)
    assert found.memory == 2 * 3 * 16 * some.size_of_cell
    assert found.timed > 0
    assert "= 200 cells in 13 chunks" in str(found) or found.chunks != 13


def test_time_is_measured_on_real_cells():
    pause = 0.002
    begun = time.process_time()
    found = sweep.estimate(plan(10_000, together=50, pause=pause), threads=1)
    assert time.process_time() - begun < 3.0
    assert found.seconds >= 10_000 * pause
    assert found.seconds < 10_000 * pause * 5
    assert sweep.estimate(plan(10_000, together=50, pause=pause), threads=2).seconds < 0.8 * found.seconds


def test_a_cell_that_takes_too_long_gives_a_bound(monkeypatch):
    monkeypatch.setattr(sys.modules["grazing.sweep.estimate"], "PATIENCE", 0.05)
    some = plan(10)

    def endless(cells, arrays):
        while True:
            time.sleep(0.01)
            yield

    object.__setattr__(some, "compute", endless)
    object.__setattr__(some, "work", 1)
    found = sweep.estimate(some, threads=1)
    assert found.timed == 0 and 0.5 <= found.seconds < 5.0
    assert "more than" in str(found)


def test_what_a_first_use_loads_is_not_the_time_of_a_cell(monkeypatch):
    """On a busy machine it was taken for one that does not end: hours were foreseen for seconds."""
    monkeypatch.setattr(sys.modules["grazing.sweep.estimate"], "PATIENCE", 0.05)
    some, waits = plan(1000, together=10), [0.06]
    compute = some.compute

    def loading(cells, arrays):
        time.sleep(waits.pop() if waits else 0.0)
        yield
        yield from compute(cells, arrays)

    object.__setattr__(some, "compute", loading)
    found = sweep.estimate(some, threads=1)
    assert found.timed and found.seconds < 10.0


def test_it_writes_nothing_and_refuses_what_run_refuses(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    sweep.estimate(plan(1))
    assert list(tmp_path.iterdir()) == []
    with pytest.raises(gz.InputError, match=r"chunk = 0"):
        sweep.estimate(plan(), 0)
    with pytest.raises(gz.InputError, match=r"threads = 0"):
        sweep.estimate(plan(), threads=0)
