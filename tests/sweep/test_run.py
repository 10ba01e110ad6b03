import json
import os
import time
from itertools import count
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import grazing as gz
from grazing import sweep
from grazing.io import load, save
from grazing.studies.plan import Plan, run_plan
from grazing.sweep.template import _host
from tests.sweep.plans import Orbits, files, finish, logistic, own_map, plan


@pytest.mark.parametrize(
    ("sizes", "chunk"),
    [((7,), 3), ((7,), 1), ((7,), 7), ((7,), 100), ((1,), None), ((5, 3), {"mu": 2, "l": 2}), ((5, 3), 4), ((3, 4), 8)],
)
@pytest.mark.parametrize("together", [1, 2, 100])
def test_a_sweep_is_what_the_study_returns(tmp_path, sizes, chunk, together):
    some = plan(*sizes, together=together)
    found = sweep.run(some, tmp_path / "a.zarr", chunk=chunk)
    assert found.complete and found.cells == found.cells_done == some.cells
    xr.testing.assert_identical(sweep.open_store(tmp_path / "a.zarr"), run_plan(some))


def test_a_plan_of_one_cell_without_axes(tmp_path):
    one = Plan(
        P=plan().P, title="one", config={}, axes={}, variables=plan().variables, sizes=plan().sizes,
        compute=Orbits(plan().P, (), (), 4, 0.0), together=1, work=1,
    )  # fmt: skip
    found = sweep.run(one, tmp_path / "a.zarr")
    assert found.chunks == found.cells == 1 and found.complete
    xr.testing.assert_identical(sweep.open_store(tmp_path / "a.zarr"), run_plan(one))
    assert sweep.verify(tmp_path / "a.zarr", plan=one).ok
    (tmp_path / "a.zarr" / "done" / "c").unlink()
    (tmp_path / "a.zarr" / "done" / f"c.{'0' * 32}.partial").touch()
    assert sweep.run(one, tmp_path / "a.zarr").complete
    assert not list(tmp_path.rglob("*.partial"))


def test_bytes_depend_on_neither_threads_nor_shards_nor_order(tmp_path):
    some = plan(5, 3)
    sweep.run(some, tmp_path / "a.zarr", chunk=2, threads=1)
    sweep.run(some, tmp_path / "b.zarr", chunk=2, threads=3)
    for i in (3, 1, 2):
        found = sweep.run(some, tmp_path / "c.zarr", chunk=2, shard=(i, 3))
    assert found.complete
    assert files(tmp_path / "a.zarr") == files(tmp_path / "b.zarr") == files(tmp_path / "c.zarr")


def test_shards_compute_their_own(tmp_path):
    found = sweep.run(plan(7), tmp_path / "a.zarr", chunk=2, shard=(2, 3))
    assert (found.chunks, found.chunks_done, found.cells_done) == (4, 1, 2)
    assert [file.name for file in (tmp_path / "a.zarr" / "done" / "c").iterdir()] == ["1"]
    assert sweep.run(plan(7), tmp_path / "a.zarr", shard=(5, 9)).chunks_done == 1  # more shards than chunks


@pytest.mark.parametrize("look", ["exists", "is_dir", "iterdir"])
def test_another_process_makes_the_store_between_two_looks(tmp_path, monkeypatch, look):
    store, made = tmp_path / "a.zarr", tmp_path / "made.zarr"
    sweep.run(plan(n=4), made, chunk=2)
    if look != "exists":
        store.mkdir()  # an empty folder: a store may take its name
    original = getattr(Path, look)

    def after_the_rename(self, *args, **options):
        if self == store and os.path.lexists(made):
            os.rename(made, store)
        return original(self, *args, **options)

    monkeypatch.setattr(Path, look, after_the_rename)
    assert sweep.run(plan(n=4), store, chunk=2).complete
    assert not made.exists()


def test_missing_chunks_alone_are_computed_again(tmp_path):
    store = tmp_path / "a.zarr"
    sweep.run(plan(7), store, chunk=2)
    before = files(store)
    (store / "done" / "c" / "2").unlink()
    (store / "points" / "c" / "2" / "0" / "0").write_bytes(b"rubbish")
    (store / "done" / "c" / "0").write_bytes(b"")  # as after a power cut
    (store / "period" / "c" / "2").unlink()
    seen = []
    some = plan(7)
    compute = some.compute

    def watched(cells, arrays):
        seen.extend(cells)
        yield from compute(cells, arrays)

    object.__setattr__(some, "compute", watched)
    assert sweep.run(some, store).complete
    assert sorted(seen) == [0, 1, 4, 5]
    assert files(store) == before


def test_done_can_be_taken_back_through_zarr(tmp_path):
    import zarr

    sweep.run(plan(7), tmp_path / "a.zarr", chunk=2)
    zarr.open_array(str(tmp_path / "a.zarr" / "done"), mode="r+")[1] = 0
    assert sweep.status(tmp_path / "a.zarr").chunks_done == 3


def test_what_a_killed_writer_left_is_removed(tmp_path, monkeypatch):
    store = tmp_path / "a.zarr"
    sweep.run(plan(7), store, chunk=2, shard=(1, 2))
    ours, other = (store / "points" / "c" / str(i) / "0" / f"0.{'ab' * 16}.partial" for i in (1, 0))
    for file in (ours, other):
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_bytes(b"half")
    (store / "done" / "c" / f"3.{'cd' * 16}.partial").write_bytes(b"")
    half = tmp_path / f".a.zarr-{_host()}-{2**22 + 1}-{'0' * 12}.partial"
    half.mkdir()
    at_work, *left = (tmp_path / f".a.zarr-elsewhere-1-{i:012}.partial" for i in range(3))
    for each, late in (at_work, 60.0), (left[0], -1e4), (left[1], 1e9):  # the last by a clock that is wrong
        each.mkdir()
        os.utime(each, (time.time() + late,) * 2)
    monkeypatch.setattr("time.time", lambda: 1e10)  # of this machine; that of the disk counts
    sweep.run(plan(7), store, shard=(2, 2))
    assert at_work.exists()
    at_work.rmdir()
    assert not ours.exists() and other.exists()  # chunk 0 belongs to the other shard, and is done
    assert [file.name for file in tmp_path.iterdir()] == ["a.zarr"]
    assert len(list(store.rglob("*.partial"))) == 1


def test_chunks_of_nothing_but_zeros_have_files(tmp_path):
    some = plan(4)

    def zeros(cells, arrays):
        yield

    object.__setattr__(some, "compute", zeros)
    sweep.run(some, tmp_path / "a.zarr", chunk=1)
    assert len(list((tmp_path / "a.zarr" / "period" / "c").iterdir())) == 4
    assert sweep.verify(tmp_path / "a.zarr", 1.0, plan=some).ok


# ---- refusals


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({"keep": 5}, "keep is 4 there and 5 here"),
        ({"seed": 3}, "seed is 0 there and 3 here"),
        ({"n": 8}, r"values\[0\] is \[0.05.*there and \[0.05"),
        ({"m": 2}, "m is null there and 2 here"),
        (
            {"P": gz.gap_map(lam=0.6, mu=0.1, l=0.1), "keep": 6},
            r"keep is 4 there and 6 here; params.lam is 0.5 there and",
        ),
        (
            {"P": own_map(), "name": "a"},
            "letters is 'L' here only; map is 'gap map' there and 'logistic' here; params.a",
        ),
    ],
)
def test_another_sweep_is_refused_by_what_differs(tmp_path, changed, said):
    store = tmp_path / "a.zarr"
    sweep.run(plan(), store, shard=(1, 2), chunk=2)
    before = files(store)
    with pytest.raises(gz.InputError, match=rf"a.zarr holds another sweep: {said}"):
        sweep.run(plan(**changed), store)
    assert files(store) == before
    assert sweep.run(plan(), store).complete


def test_other_code_is_refused_unless_allowed(tmp_path):
    def logistic(state, p):
        (x,) = state
        return (p.a * (x - x * x),)

    def of(step):
        P = gz.Map(step, params={"a": 3.2}, coordinates=("x",), box=((0.0, 1.0),), letters="L", name="logistic")
        return plan(P=P, name="a")

    store = tmp_path / "a.zarr"
    first = plan(P=own_map(), name="a")
    sweep.run(first, store, shard=(1, 2), chunk=2)
    with pytest.raises(gz.InputError, match=r"was begun by other code: code is '.*other_code=True"):
        sweep.run(of(logistic), store)
    assert sweep.run(of(logistic), store, other_code=True).complete
    assert not sweep.verify(store, 1.0, plan=first).ok  # it has noticed the mixture
    found = sweep.open_store(store)
    assert found.made_by.values.tolist() == [0, 0, 1, 1, 0, 0, 1]
    assert found.made_by.attrs["flag_meanings"] == "missing begun_by other_1"
    said = "2 of 4 chunks by the code that the sweep was begun with; 2 by other code (code is '"
    assert found.attrs["grazing_mixture"].startswith(said) and f"mixture: {said}" in str(sweep.status(store))
    assert load(save(found, tmp_path / "a.nc")).identical(found)


@pytest.mark.parametrize(
    ("before", "after", "said"),
    [
        ({"tangent": lambda x, p: (x, 0, 0, (1.0,))}, {"tangent": lambda x, p: (x, 0, 0, (2.0,))}, "code is '"),
        ({}, {"prepare": lambda p: p}, "code is '"),
        ({"escape": 9.0}, {"escape": 0.5}, "escape is 9.0 there and 0.5 here"),
        ({"letters": "L"}, {"letters": "R"}, "letters is 'L' there and 'R' here"),
    ],
)
def test_all_that_a_map_of_ones_own_consists_of_is_looked_at(tmp_path, before, after, said):
    """The step alone was: a sweep went on, in silence, with another derivative, other values or other letters."""

    def of(parts):
        return plan(P=gz.Map(logistic, params={"a": 3.2}, box=((0.0, 1.0),), **parts), name="a")

    sweep.run(of(before), tmp_path / "a.zarr", shard=(1, 2), chunk=2)
    with pytest.raises(gz.InputError, match=f"a.zarr (holds another sweep|was begun by other code): {said}"):
        sweep.run(of(after), tmp_path / "a.zarr")


def test_another_version_is_refused_by_name(tmp_path, monkeypatch):
    sweep.run(plan(), tmp_path / "a.zarr")
    monkeypatch.setattr(gz, "__version__", "9.9")
    said = r"was begun by other code: grazing is '.*' there and '9.9' here. Go on with"
    with pytest.raises(gz.InputError, match=said):
        sweep.run(plan(), tmp_path / "a.zarr")


def test_the_chunks_of_a_store_stay(tmp_path):
    store = tmp_path / "a.zarr"
    sweep.run(plan(5, 3), store, chunk={"mu": 2}, shard=(1, 2))
    with pytest.raises(gz.InputError, match=r"was begun with chunks of \{mu: 2, l: 3\}, which stay; leave chunk out"):
        sweep.run(plan(5, 3), store, chunk=1)
    assert sweep.run(plan(5, 3), store, chunk={"mu": 2}).complete


def test_cells_that_depend_on_each_other_are_refused(tmp_path):
    with pytest.raises(gz.InputError, match=r"'test orbits of gap map' cannot be swept in chunks: each of its cells"):
        sweep.run(plan(sequential=True), tmp_path / "a.zarr")
    with pytest.raises(gz.InputError, match=r"cannot be swept in chunks"):
        sweep.estimate(plan(sequential=True))
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"shard": (0, 3)}, r"shard\[0\] = 0; allowed is a whole number >= 1"),
        ({"shard": (4, 3)}, "shard is 4/3; allowed are 1/3 to 3/3"),
        ({"shard": (1, 0)}, r"shard\[1\] = 0"),
        ({"shard": "1/3"}, r"shard\[|shard is"),
        ({"shard": 3}, r"shard is 3; give \(i, n\)"),
        ({"threads": 0}, "threads = 0"),
        ({"executor": "dask"}, "executor is 'dask'; give a concurrent.futures.Executor"),
    ],
)
def test_options_that_are_wrong(tmp_path, options, said):
    with pytest.raises(gz.InputError, match=said):
        sweep.run(plan(), tmp_path / "a.zarr", **options)


def test_a_chunk_that_does_not_fit_into_memory(tmp_path, monkeypatch):
    monkeypatch.setattr("grazing.memory.physical_memory", lambda: 1000)
    with pytest.raises(gz.InputError, match=r"use smaller chunks \(7,\), or fewer threads"):
        sweep.run(plan(), tmp_path / "a.zarr", chunk=7)


# ---- resume


def test_a_recipe_makes_the_plan_again(tmp_path, monkeypatch):
    made = []

    def plan_of(recipe):
        made.append(recipe)
        return plan(recipe["n"], recipe=recipe, finish=finish)

    monkeypatch.setattr("grazing.config.plan_of", plan_of, raising=False)
    store = tmp_path / "a.zarr"
    sweep.run(plan_of({"n": 7}), store, chunk=2, shard=(1, 2))
    assert sweep.resume(store).complete
    assert made == [{"n": 7}] * 2
    assert sweep.verify(store).ok
    # opening takes no recipe that names no study of ours; the plan itself finishes
    assert sweep.open_store(store, plan=plan(7, finish=finish)).attrs["finished"] == "yes"


def test_without_a_recipe_the_plan_is_needed(tmp_path):
    store = tmp_path / "a.zarr"
    sweep.run(plan(), store, chunk=2, shard=(1, 2))
    with pytest.raises(gz.InputError, match=r"a.zarr keeps no recipe of its plan; give the plan itself"):
        sweep.resume(store)
    assert sweep.resume(store, plan()).complete
    with pytest.raises(gz.InputError, match=r"there is no sweep in"):
        sweep.resume(tmp_path / "b.zarr", plan())


# ---- interruptions


@pytest.mark.parametrize("threads", [1, 2])
def test_an_exception_leaves_a_store_to_be_resumed(tmp_path, threads):
    store = tmp_path / "a.zarr"
    for error, bad in ((KeyboardInterrupt, 4), (ZeroDivisionError, 1)):  # at the second nothing but one may be left
        some, calls = plan(9), count(1)
        compute = some.compute

        def failing(cells, arrays, compute=compute, calls=calls, error=error, bad=bad):
            if next(calls) == bad:  # of one thread alone, however many there are
                raise error
            yield from compute(cells, arrays)

        object.__setattr__(some, "compute", failing)
        with pytest.raises(error):
            sweep.run(some, store, chunk=1, threads=threads)
        assert not sweep.status(store).running
    assert 0 < sweep.status(store).chunks_done < 9
    sweep.run(plan(9), store)
    sweep.run(plan(9), tmp_path / "b.zarr", chunk=1)
    assert files(store) == files(tmp_path / "b.zarr")


def test_what_is_no_plan_is_refused(tmp_path):
    """It was a bare AttributeError."""
    for call in (sweep.run, lambda plan, store: sweep.estimate(plan)):
        with pytest.raises(gz.InputError, match=r"plan is {'a': 1}; give one of gz.plans"):
            call({"a": 1}, tmp_path / "a.zarr")


def test_progress_counts_cells_and_those_of_before(tmp_path):
    seen = []
    sweep.run(plan(7), tmp_path / "a.zarr", chunk=2, shard=(1, 2), progress=lambda *two: seen.append(two))
    assert seen[-1] == (4, 4)
    seen.clear()
    sweep.run(plan(7), tmp_path / "a.zarr", threads=1, progress=lambda *two: seen.append(two))
    assert [total for _done, total in seen] == [7, 7] and 5 <= seen[0][0] <= 6 and seen[1][0] == 7
    seen.clear()
    sweep.run(plan(7), tmp_path / "a.zarr", progress=lambda *two: seen.append(two))
    assert seen == []


def test_the_history_and_the_times_stand_beside_the_result(tmp_path):
    sweep.run(plan(), tmp_path / "a.zarr", chunk=2, shard=(1, 2))
    sweep.run(plan(), tmp_path / "a.zarr")
    lines = (tmp_path / "a.zarr" / ".grazing" / "history.jsonl").read_text().splitlines()
    first, second = map(json.loads, lines)
    assert first["shard"] == "1/2" and second["shard"] is None
    assert second["pid"] == os.getpid() and second["versions"]["numpy"] == np.__version__
    assert sweep.status(tmp_path / "a.zarr").seconds > 0.0
