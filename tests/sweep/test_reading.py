import numpy as np
import pytest
import xarray as xr

import grazing as gz
from grazing import sweep
from grazing.io import load, save
from grazing.studies.plan import run_plan
from tests.sweep.plans import finish, plan


def test_missing_cells_are_marked(tmp_path):
    store = tmp_path / "a.zarr"
    sweep.run(plan(5, 3), store, chunk={"mu": 2, "l": 2}, shard=(2, 2))
    found, whole = sweep.open_store(store), run_plan(plan(5, 3))
    assert found.attrs["grazing_incomplete"] == "3 of 6 chunks are missing"
    assert found.done.dims == ("mu", "l")
    assert found.done.values.astype(int).tolist() == [[0, 0, 1]] * 5
    for name in ("points", "period", "word"):
        assert (found[name].where(found.done, drop=False) == whole[name]).sum() == found[name].where(
            found.done
        ).notnull().sum()
    assert np.isnan(found.points.values[~found.done.values]).all()
    assert (found.word.values[~found.done.values] == "").all()


def test_finish_needs_the_plan(tmp_path):
    store, some = tmp_path / "a.zarr", plan(finish=finish)
    sweep.run(some, store, chunk=2, shard=(1, 2))
    assert "total" not in sweep.open_store(store, some)  # not while cells are missing
    sweep.run(some, store)
    xr.testing.assert_identical(sweep.open_store(store, some), run_plan(some))
    raw = sweep.open_store(store)
    assert "total" not in raw and "the store keeps no recipe; give the plan" in raw.attrs["grazing_note"]
    with pytest.raises(gz.InputError, match=r"holds another sweep"):
        sweep.open_store(store, plan(8))


def test_attributes_keep_their_types(tmp_path):
    sweep.run(plan(), tmp_path / "a.zarr")
    found, whole = sweep.open_store(tmp_path / "a.zarr"), run_plan(plan())
    assert list(found.variables) == list(whole.variables) and list(found.attrs) == list(whole.attrs)
    for name in whole.variables:
        assert found[name].dtype == whole[name].dtype
        for key, value in whole[name].attrs.items():
            assert type(found[name].attrs[key]) is type(value)
            assert getattr(found[name].attrs[key], "dtype", None) == getattr(value, "dtype", None)
    assert found.points.attrs["bound"] == np.inf


def test_it_does_not_hold_the_store(tmp_path):
    sweep.run(plan(), tmp_path / "a.zarr")
    found = sweep.open_store(tmp_path / "a.zarr")
    (tmp_path / "a.zarr").rename(tmp_path / "b.zarr")
    assert found.points.notnull().all()
    xr.testing.assert_identical(load(save(found, tmp_path / "a.nc")), found)


@pytest.mark.parametrize("name", ["points", "word"])
def test_damage_is_said_in_one_sentence(name, tmp_path):
    """Of words it was said twice, one inside the other."""
    store = tmp_path / "a.zarr"
    sweep.run(plan(), store, chunk=2)
    (damaged,) = (file for file in (store / name / "c" / "1").rglob("*") if file.is_file())
    damaged.write_bytes(b"rubbish")
    with pytest.raises(gz.InputError) as said:
        sweep.open_store(store)
    assert f"a.zarr is damaged: {name} in chunk 1 cannot be read (" in str(said.value)
    assert str(said.value).count("sweep.verify finds all") == 1


def test_a_result_that_does_not_fit_into_memory(tmp_path, monkeypatch):
    sweep.run(plan(), tmp_path / "a.zarr")
    monkeypatch.setattr("grazing.memory.physical_memory", lambda: 1000)
    with pytest.raises(gz.InputError, match=r"open a part of it with xarray.open_zarr\('.*a.zarr'\)"):
        sweep.open_store(tmp_path / "a.zarr")


def test_a_missing_file_is_no_missing_cell(tmp_path):
    store = tmp_path / "a.zarr"
    sweep.run(plan(), store, chunk=2)
    (store / "points" / "c" / "1" / "0" / "0").unlink()
    with pytest.raises(
        gz.InputError,
        match=r"a.zarr is damaged: points in chunk 1 cannot be read \(points/c/1/0/0: its file is missing\)",
    ):
        sweep.open_store(store)
