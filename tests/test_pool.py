"""Tasks on threads: each once, scattered; an exception or Ctrl-C stops all within a tile."""

import _thread
import os
import signal
import threading
import time
import warnings

import pytest

from grazing import pool
from grazing.outcome import InputError
from grazing.pool import run_tasks
from grazing_checker import balls

#: Seconds after which an endless task gives up, so that a pool that does not stop fails and does not hang.
PATIENCE = 20.0


def noting(done, i, tiles=1):
    def task():
        for _ in range(tiles):
            done.append(i)
            yield

    return task


@pytest.mark.parametrize("threads", [1, 2, 5, None])
@pytest.mark.parametrize(("tasks", "tiles"), [(1, 1), (2, 3), (40, 1), (40, 0)])
def test_every_task_is_run_once_and_to_its_end(threads, tasks, tiles):
    done, said = [], []
    run_tasks([noting(done, i, tiles) for i in range(tasks)], threads, lambda *now: said.append(now))
    assert sorted(done) == sorted(list(range(tasks)) * tiles)
    assert said[-1] == (tasks, tasks)
    assert {total for _, total in said} == {tasks}
    assert [n for n, _ in said] == sorted({n for n, _ in said})


def test_the_order_is_scattered_and_always_the_same():
    orders = []
    for _ in range(2):
        done = []
        run_tasks([noting(done, i) for i in range(100)], 1)
        orders.append(done)
    assert orders[0] == orders[1]
    steps = [abs(b - a) for a, b in zip(orders[0], orders[0][1:], strict=False)]
    assert sum(steps) / len(steps) > 20.0  # 33 for a random order, 1 for none
    halves = [sum(i < 50 for i in orders[0][:50]), sum(i < 50 for i in orders[0][50:])]
    assert min(halves) > 15


@pytest.mark.parametrize("threads", [1, 2])
def test_nothing_to_do_is_done(threads):
    said = []
    run_tasks([], threads, lambda done, total: said.append((done, total)))
    assert said == []


def test_threads_work_side_by_side():
    """Two tasks wait for each other: one thread alone would wait for ever."""
    meeting, met = threading.Barrier(2), []

    def task():
        met.append(meeting.wait(PATIENCE))
        yield

    run_tasks([task, task], 2)
    assert sorted(met) == [0, 1]


class Endless:
    """Tasks of a millisecond a tile without end; counts those that had to give up."""

    def __init__(self):
        self.started = threading.Event()
        self.gave_up = 0

    def __call__(self):
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            self.started.set()
            time.sleep(1e-3)
            yield
        self.gave_up += 1


@pytest.mark.parametrize("threads", [1, 2])
def test_an_exception_stops_the_work(threads):
    endless, done = Endless(), []

    def wrong():
        if threads > 1:
            assert endless.started.wait(PATIENCE)
        raise ZeroDivisionError("in the second tile")
        yield

    others = [noting(done, i) for i in range(200)]
    with pytest.raises(ZeroDivisionError, match="in the second tile"):
        run_tasks([wrong, endless] if threads > 1 else [wrong, *others], threads)
    assert endless.gave_up == 0
    assert len(done) < 200


@pytest.mark.parametrize("threads", [1, 2])
def test_an_exception_in_progress_stops_the_work(threads):
    endless, done = Endless(), []
    others = [noting(done, i) for i in range(200)]

    def progress(*_):
        raise KeyboardInterrupt

    tasks = [endless, others[0]] if threads > 1 else others
    with pytest.raises(KeyboardInterrupt):
        run_tasks(tasks, threads, progress)
    assert endless.gave_up == 0
    assert len(done) == 1


@pytest.mark.parametrize("threads", [1, 2])
def test_progress_is_told_of_a_long_task_before_it_is_done(threads, monkeypatch):
    """One cell that takes minutes was silent until its end."""
    monkeypatch.setattr(pool, "STILL", 0.0)
    told, heard = [], threading.Event()

    def long():
        for _tile in range(1000):
            yield
            if heard.wait(0.01):
                return

    def progress(*done):
        told.append(done)
        heard.set()

    run_tasks([long] * threads, threads, progress)
    assert told[0] == (0, threads) and told[-1] == (threads, threads)


@pytest.mark.parametrize("threads", [1, 2])
def test_ctrl_c_stops_the_work_within_a_tile(threads):
    endless = Endless()

    def interrupt():
        endless.started.wait(PATIENCE)
        _thread.interrupt_main(signal.SIGINT)

    watch = threading.Thread(target=interrupt)
    watch.start()
    begin = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        run_tasks([endless, endless, endless], threads)
    watch.join()
    assert endless.gave_up == 0
    assert time.monotonic() - begin < 0.5 * PATIENCE


def test_no_thread_is_left_behind():
    with pytest.raises(KeyboardInterrupt):
        run_tasks([Endless(), noting([], 0)], 2, lambda *_: (_ for _ in ()).throw(KeyboardInterrupt))
    assert not [thread.name for thread in threading.enumerate() if thread.name.startswith("grazing")]


@pytest.mark.parametrize("threads", [0, -1, 1.5, True, "2", float("nan")])
def test_threads_must_be_a_whole_number(threads):
    with pytest.raises(InputError, match=rf"threads = {threads!r}; allowed is a whole number >= 1"):
        run_tasks([noting([], 0)], threads)


def test_a_progress_that_cannot_be_called_is_named():
    with pytest.raises(InputError, match=r"progress is range\(0, 3\); give a function of two numbers"):
        run_tasks([noting([], 0)], 1, range(3))


def test_no_number_of_threads_is_one_per_processor(monkeypatch):
    monkeypatch.setattr(os, "cpu_count", lambda: 3)
    meeting, met = threading.Barrier(3), []

    def task():
        met.append(meeting.wait(PATIENCE))
        yield

    run_tasks([task] * 3)
    assert sorted(met) == [0, 1, 2]


@pytest.mark.skipif(not hasattr(os, "fork"), reason="processes")
@pytest.mark.parametrize("lock", [pool.LOCK, balls.LOCK], ids=["finder", "checker"])
def test_a_fork_does_not_wait_for_the_precision_that_another_thread_works_with(lock):
    taken, over = threading.Event(), threading.Event()

    def work():
        with lock:
            taken.set()
            over.wait()

    thread = threading.Thread(target=work)
    thread.start()
    taken.wait()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of a fork where there are threads
        pid = os.fork()
    if not pid:
        os._exit(not lock.acquire(timeout=0.2))
    assert os.waitpid(pid, 0)[1] == 0
    over.set()
    thread.join()
