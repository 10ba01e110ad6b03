import os
import pickle
import sys
from concurrent.futures import BrokenExecutor, Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from multiprocessing import get_context
from threading import Barrier

import pytest

import grazing as gz
from grazing import sweep
from grazing.config import plan_of
from grazing.outcome import GrazingError
from grazing.sweep import task
from tests.sweep.plans import files, own_map, plan


class Elsewhere(Executor):
    """Workers that know only what is sent to them: everything is pickled, and nothing is kept of this process."""

    def __init__(self, fail_at=None, error=None):
        self.sent, self.futures, self.fail_at, self.error = [], [], fail_at, error

    def submit(self, function, *args):
        sent = pickle.dumps((function, args))
        self.sent.append(len(sent))
        future = Future()
        self.futures.append(future)
        if len(self.sent) == self.fail_at:
            future.set_exception(self.error)
            return future
        if len(self.sent) == 1:
            task._plans.clear()
        function, args = pickle.loads(sent)
        try:
            future.set_result(function(*args))
        except Exception as error:
            future.set_exception(error)
        return future


@pytest.fixture
def expected(tmp_path):
    sweep.run(plan(), tmp_path / "expected.zarr", chunk=1)
    return files(tmp_path / "expected.zarr")


def test_what_a_killed_worker_left_is_gone_when_another_has_written_its_chunk(tmp_path, expected):
    class Killed(ThreadPoolExecutor):
        """One of its workers ends within a file; what it had to do is given to another."""

        def submit(self, function, *arguments):
            left = tmp_path / "a.zarr" / "mean" / "c" / f"3.{'0123456789abcdef' * 2}.partial"
            left.parent.mkdir(exist_ok=True)
            left.write_bytes(b"half")
            return super().submit(function, *arguments)

    with Killed(1) as executor:
        assert sweep.run(plan(), tmp_path / "a.zarr", chunk=1, executor=executor).complete
    assert files(tmp_path / "a.zarr") == expected


def test_workers_get_numbers_and_write_their_own_chunks(tmp_path, expected):
    pytest.importorskip("cloudpickle")
    executor = Elsewhere()
    seen = []
    found = sweep.run(plan(), tmp_path / "a.zarr", chunk=1, executor=executor, progress=lambda *two: seen.append(two))
    assert found.complete and seen[-1] == (7, 7)
    assert files(tmp_path / "a.zarr") == expected
    assert len(executor.sent) == 7 and max(executor.sent) < 1000
    assert len(list((tmp_path / "a.zarr" / ".grazing").glob("plan-*.pickle"))) == 1


def test_a_recipe_travels_instead_of_the_plan(tmp_path, monkeypatch):
    made = []

    def plan_of(recipe):
        made.append(recipe)
        return plan(recipe=recipe)

    monkeypatch.setattr("grazing.config.plan_of", plan_of, raising=False)
    assert sweep.run(plan(recipe={"n": 7}), tmp_path / "a.zarr", chunk=1, executor=Elsewhere()).complete
    assert made == [{"n": 7}]  # once on the worker
    assert not list((tmp_path / "a.zarr" / ".grazing").glob("plan-*"))


def test_few_chunks_are_out_at_a_time(tmp_path, monkeypatch, expected):
    monkeypatch.setattr("grazing.sweep.executors.WINDOW", 2)
    with ThreadPoolExecutor(1) as pool:
        submit, out = pool.submit, []

        def watched(*args):
            out.append(pool._work_queue.qsize())
            return submit(*args)

        monkeypatch.setattr(pool, "submit", watched)
        assert sweep.run(plan(), tmp_path / "a.zarr", chunk=1, executor=pool).complete
    assert len(out) == 7 and max(out) <= 2
    assert files(tmp_path / "a.zarr") == expected


def test_threads_of_this_process_need_no_copy(tmp_path, expected):
    some = plan()
    object.__setattr__(some.compute, "unpicklable", sys._getframe())
    with ThreadPoolExecutor(3) as pool:
        assert sweep.run(some, tmp_path / "a.zarr", chunk=1, executor=pool).complete
        assert files(tmp_path / "a.zarr") == expected
        assert sweep.run(some, tmp_path / "a.zarr", executor=pool).complete  # nothing to do


def test_processes(tmp_path, expected):
    pytest.importorskip("cloudpickle")
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        assert sweep.run(plan(), tmp_path / "a.zarr", chunk=1, executor=pool).complete
    assert files(tmp_path / "a.zarr") == expected


def test_what_a_step_raises_on_workers_is_said_once(tmp_path):
    """A cluster prints what its tasks raise, whole and once a worker: pages before the one line that says it."""
    pytest.importorskip("cloudpickle")

    def step(state, p):
        (x,) = state
        if p.a > 0.12:
            raise ValueError("too far")
        return (0.9 * x,)

    some = plan(P=gz.Map(step, params={"a": 0.1}), name="a")
    executor = Elsewhere()
    with pytest.raises(gz.GrazingError, match=r"too far, in line \d+ of .*test_executors.py: raise ValueError") as said:
        sweep.run(some, tmp_path / "a.zarr", chunk=1, executor=executor)
    assert said.type is gz.UserCodeError and str(said.value).count("too far") == 2  # what it says, and its line
    assert executor.futures and all(future.exception() is None for future in executor.futures)
    assert 0 < sweep.status(tmp_path / "a.zarr").chunks_done < 7


def test_a_plan_that_cannot_be_sent(tmp_path):
    pytest.importorskip("cloudpickle")
    some = plan()
    some.compute.frame = sys._getframe()
    with pytest.raises(gz.InputError, match=r"the plan cannot be sent to workers: .*Run it on threads or by shards"):
        sweep.run(some, tmp_path / "a.zarr", executor=Elsewhere())
    assert sweep.run(some, tmp_path / "a.zarr").complete


def test_a_step_of_one_s_own_travels(tmp_path):
    pytest.importorskip("cloudpickle")
    some = plan(P=own_map(), name="a")
    assert sweep.run(some, tmp_path / "a.zarr", chunk=1, executor=Elsewhere()).complete
    assert sweep.verify(tmp_path / "a.zarr", 1.0, plan=some).ok


def test_without_the_package_only_a_recipe_travels(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "cloudpickle", None)
    with pytest.raises(
        gz.InputError, match=r"a plan without a recipe needs a package .*pip install 'grazing\[cluster\]'"
    ):
        sweep.run(plan(), tmp_path / "a.zarr", executor=Elsewhere())


def test_workers_with_other_code_are_refused(tmp_path, monkeypatch):
    monkeypatch.setattr("grazing.config.plan_of", lambda recipe: plan(recipe=recipe, seed=1), raising=False)
    with pytest.raises(gz.GrazingError, match=r"has another plan than the run: .*seed is 0 there and 1 here"):
        sweep.run(plan(recipe={}), tmp_path / "a.zarr", executor=Elsewhere())
    monkeypatch.setattr("grazing.config.plan_of", lambda recipe: plan(recipe=recipe, P=another()), raising=False)
    with pytest.raises(gz.GrazingError, match=r"has other code than the run: code is .*Use the same Python"):
        sweep.run(plan(recipe={}), tmp_path / "a.zarr", executor=Elsewhere())
    assert sweep.status(tmp_path / "a.zarr").chunks_done == 0


def another():
    def step(state, p):
        (x,) = state
        return (x * p.lam + p.mu - p.l,), 0, 0

    box, params = ((-1.0, 1.0),), {"lam": 0.5, "mu": 0.1, "l": 0.1}
    return gz.Map(step, params=params, coordinates=("x",), box=box, name="gap map")


def test_a_worker_that_does_not_see_the_disk(tmp_path, monkeypatch):
    sweep.run(plan(), tmp_path / "a.zarr", chunk=1, shard=(1, 2))
    found = task.open_existing(tmp_path / "a.zarr")
    with pytest.raises(gz.GrazingError, match=r"worker .*there is no sweep in .*on a disk that all workers share"):
        task.compute_chunk(str(tmp_path / "b.zarr"), found.token, "", "", False, False, 0)
    with pytest.raises(gz.GrazingError, match=r"is not the store that the run began with"):
        task.compute_chunk(str(tmp_path / "a.zarr"), "other", "", "", False, False, 0)
    with pytest.raises(gz.GrazingError, match=r"finds no plan in .*No such file"):
        task.compute_chunk(str(tmp_path / "a.zarr"), found.token, "0" * 64, "", False, False, 0)


def test_a_pickle_that_the_run_did_not_write_is_not_opened(tmp_path):
    sweep.run(plan(), tmp_path / "a.zarr", chunk=1, shard=(1, 2))
    found = task.open_existing(tmp_path / "a.zarr")
    (found.aside / f"plan-{'0' * 64}.pickle").write_bytes(pickle.dumps(pytest.fail))
    with pytest.raises(gz.GrazingError, match=r"is not the one that the run put there"):
        task.compute_chunk(str(tmp_path / "a.zarr"), found.token, "0" * 64, "", False, False, 0)


@pytest.mark.parametrize("error", [BrokenExecutor("a process in the pool died"), ZeroDivisionError("mine")])
def test_executors_that_fail(tmp_path, expected, error):
    pytest.importorskip("cloudpickle")
    store = tmp_path / "a.zarr"
    wanted = gz.GrazingError if isinstance(error, BrokenExecutor) else ZeroDivisionError
    with pytest.raises(wanted, match=r"What is done is kept in .*resume it|mine"):
        sweep.run(plan(), store, chunk=1, executor=Elsewhere(fail_at=4, error=error))
    found = sweep.status(store)
    assert 0 < found.chunks_done < 7 and not found.running
    assert sweep.run(plan(), store).complete
    assert files(store) == expected


@pytest.mark.parametrize("kind", [ThreadPoolExecutor, ProcessPoolExecutor])
def test_an_executor_that_was_shut_down(tmp_path, expected, kind):
    """It raised a bare RuntimeError, of which nobody said that the store goes on."""
    with kind(1) as executor:
        pass
    with pytest.raises(GrazingError, match=r"gave up \(RuntimeError: cannot schedule .* resume it"):
        sweep.run(plan(), tmp_path / "a.zarr", chunk=1, executor=executor)
    sweep.run(plan(), tmp_path / "a.zarr", chunk=1)
    assert files(tmp_path / "a.zarr") == expected


def test_options_that_exclude_each_other(tmp_path):
    for options in ({"shard": (1, 2)}, {"threads": 2}):
        with pytest.raises(gz.InputError, match=r"and executor are both given"):
            sweep.run(plan(), tmp_path / "a.zarr", executor=Elsewhere(), **options)


def test_workers_run_the_code_that_the_run_named_and_none_that_the_store_names(tmp_path):
    marker, code = tmp_path / "ran", tmp_path / "mine.py"
    code.write_text(
        f"open({str(marker)!r}, 'a').close()\n"
        "import grazing as gz\n"
        "def step(state, p):\n    (x,) = state\n    return (p.a * x * (1.0 - x),)\n"
        "P = gz.Map(step, params={'a': 3.2}, coordinates=('x',), box=((0.1, 0.9),), name='logistic map')\n"
    )
    config = {"study": "density", "map": f"{code}:P", "vary": {"a": "3:3.4:4"}, "settings": {"starts": 2, "bins": 4}}
    some = plan_of(config, code="trust")
    store = tmp_path / "a.zarr"
    sweep.run(some, store, chunk=2, shard=(1, 2))
    marker.unlink()
    found, sha = task.open_existing(store), some.document["grazing_code_sha256"]
    task._plans.clear()  # as in another process
    with pytest.raises(gz.InputError, match="is code that a file names"):
        task.compute_chunk(str(store), found.token, "", sha, False, False, 1)
    for call in (sweep.resume, sweep.verify):
        with pytest.raises(gz.InputError, match=f"name it in this call: --map {code}:P; in Python code='trust'"):
            call(store)
    assert not marker.exists()
    assert task.own_of(some) == {"map": f"{code}:P"}
    assert sweep.run(some, store, executor=Elsewhere()).complete
    assert sweep.verify(store, 1.0, code="trust").ok and sweep.resume(store, code="trust").complete


def test_threads_serve_any_number_of_runs_at_once(tmp_path):
    """Workers keep a few plans: one that other runs had driven out was looked for in a recipe that there is not."""
    count = task.KEPT + 3
    begun = Barrier(count)

    def run(i):
        some = plan(n=8)
        begun.wait()
        return sweep.run(some, tmp_path / f"{i}.zarr", chunk=1, executor=pool).complete

    with ThreadPoolExecutor(2) as pool, ThreadPoolExecutor(count) as runs:
        assert all(runs.map(run, range(count)))


class Kept(Elsewhere):
    """Workers that go on from run to run; a chunk of the first is lost."""

    kept = None

    def __init__(self):
        super().__init__(3, BrokenExecutor("a process in the pool died"))

    def again(self):
        """Go on, with what workers have kept, and nothing that this process has."""
        self.kept, self.fail_at = dict(task._plans), None

    def submit(self, function, *args):
        if self.kept is not None:
            task._plans.clear()
            task._plans.update(self.kept)
            self.kept = None
        return super().submit(function, *args)


def test_workers_that_go_on_do_what_the_next_run_says(tmp_path, monkeypatch):
    """They went on with what an earlier run had asked: its step, though another was allowed, and without fsync."""
    code, store = tmp_path / "mine.py", tmp_path / "a.zarr"
    settings = {"starts": 2, "bins": 4, "range": [0.0, 1.0]}
    config = {"study": "density", "map": f"{code}:P", "vary": {"a": "3:3.4:4"}, "settings": settings}

    def written(top):
        code.write_text(
            "import grazing as gz\n"
            f"def step(state, p):\n    (x,) = state\n    return (p.a * x * ({top} - x),)\n"
            "P = gz.Map(step, params={'a': 3.2}, coordinates=('x',), box=((0.1, 0.9),), name='logistic map')\n"
        )
        return plan_of(config, code="trust")

    workers = Kept()
    with pytest.raises(gz.GrazingError, match="resume it"):
        sweep.run(written("1.0"), store, chunk=1, executor=workers)
    other = written("1.1")
    workers.again()
    synced = []
    monkeypatch.setattr(os, "fsync", synced.append)
    assert sweep.run(other, store, executor=workers, other_code=True, fsync=True).complete
    found = task.open_existing(store)
    makers = [found.record(number).made_by["code"] for number in range(4)]
    assert makers[2] == other.document["grazing_code_sha256"] and makers[0] == makers[1] == makers[3] != makers[2]
    assert len(synced) > len(found.files_of(2))


def test_workers_of_other_code_are_refused_though_an_earlier_run_allowed_them(tmp_path, monkeypatch):
    monkeypatch.setattr("grazing.config.plan_of", lambda recipe: plan(recipe=recipe, P=another()), raising=False)
    workers = Kept()
    with pytest.raises(gz.GrazingError, match="resume it"):
        sweep.run(plan(recipe={}), tmp_path / "a.zarr", chunk=1, executor=workers, other_code=True)
    workers.again()
    with pytest.raises(gz.GrazingError, match=r"has other code than the run: code is .*Use the same Python"):
        sweep.run(plan(recipe={}), tmp_path / "a.zarr", executor=workers)
    assert sweep.status(tmp_path / "a.zarr").chunks_done == 6
