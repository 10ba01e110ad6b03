import threading
import time

import pytest

import grazing as gz
from grazing import memory
from grazing.memory import physical_memory, refuse_too_large
from grazing.studies.cells import run_cells


@pytest.mark.parametrize("threads", [1, 3, None])
def test_every_cell_runs_once(threads):
    seen = []
    run_cells(seen.append, 57, threads)
    assert sorted(seen) == list(range(57))
    if threads == 1:
        assert seen != sorted(seen)  # scattered


def test_progress_ends_at_the_total_and_never_falls():
    said = []
    run_cells(lambda i: time.sleep(0.01), 40, 2, lambda done, total: said.append((done, total)))
    assert said[-1] == (40, 40)
    assert said == sorted(said)
    assert len(said) > 1


@pytest.mark.parametrize("raised", [ValueError, KeyboardInterrupt])
def test_an_exception_stops_the_work(raised):
    started = []

    def work(i):
        started.append(i)
        if len(started) == 3:
            raise raised("stop")
        time.sleep(0.005)

    with pytest.raises(raised, match="stop"):
        run_cells(work, 10_000, 2)
    assert len(started) < 1_000


def test_interrupt_in_the_calling_thread_stops_the_work():
    started = []

    def work(i):
        started.append(i)
        time.sleep(0.01)

    def interrupted(done, total):
        raise KeyboardInterrupt

    before = threading.active_count()
    with pytest.raises(KeyboardInterrupt):
        run_cells(work, 10_000, 2, interrupted)
    assert len(started) < 200
    assert threading.active_count() == before


def test_memory(monkeypatch):
    monkeypatch.setattr(memory, "physical_memory", lambda: 8_000_000_000)
    refuse_too_large(4_000_000_000, "reduce keep (50)")
    said = r"would take 4.5 GB, more than half of the memory \(8 GB\); reduce keep \(50\)"
    with pytest.raises(gz.InputError, match=said):
        refuse_too_large(4_500_000_000, "reduce keep (50)")
    monkeypatch.setattr(memory, "physical_memory", lambda: None)
    refuse_too_large(10**18, "keep (50)")


def test_this_machine_has_memory():
    memory = physical_memory()
    assert memory is None or memory > 10**8


def test_error_text():
    with pytest.raises(gz.InputError, match="threads = 0; allowed is a whole number >= 1"):
        run_cells(print, 1, 0)
