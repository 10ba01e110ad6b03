import json
import os
import shutil

import numpy as np
import pytest
import xarray as xr
import zarr

import grazing as gz
from grazing import sweep
from grazing.sweep.grid import grid_of
from grazing.sweep.opened import open_existing
from grazing.sweep.template import create
from tests.sweep.plans import files, plan


@pytest.fixture
def store(tmp_path):
    sweep.run(plan(5, 3), tmp_path / "a.zarr", chunk={"mu": 2, "l": 2})
    return tmp_path / "a.zarr"


def test_the_template_is_there_before_any_work(tmp_path):
    some = plan(7)
    create(tmp_path / "a.zarr", some, grid_of(some, 3))
    names = {"points", "mean", "period", "word", "mu", "label", "x0", "done"}
    there = {name for name in files(tmp_path / "a.zarr") if name.count("/") == 1}
    assert there == {f"{name}/zarr.json" for name in names} | {"manifest/template"}
    found = open_existing(tmp_path / "a.zarr")
    assert not found.done().any() and len(found.done()) == 3
    assert found.arrays["points"].shape == (7, 3, 4) and found.arrays["points"].chunk == (3, 3, 4)
    assert found.arrays["done"].chunk == (1,) and found.arrays["done"].dtype == "uint8"
    assert found.read("mu", None, found.template.coordinates).tolist() == some.axes["mu"].tolist()
    group = zarr.open_group(str(tmp_path / "a.zarr"), mode="r")
    assert np.isnan(group["points"].fill_value) and group["period"].fill_value == 0
    assert [file.name for file in tmp_path.iterdir()] == ["a.zarr"]


def test_creating_twice_keeps_the_first(tmp_path):
    create(tmp_path / "a.zarr", plan(7), grid_of(plan(7), 3))
    before = files(tmp_path / "a.zarr")
    create(tmp_path / "a.zarr", plan(9), grid_of(plan(9), 2))
    assert files(tmp_path / "a.zarr") == before
    assert [file.name for file in tmp_path.iterdir()] == ["a.zarr"]


def test_xarray_opens_it(store):
    some = plan(5, 3)
    with xr.open_zarr(store) as result:
        assert result.points.dims == ("mu", "l", "start", "n")
        assert result.word.dims == ("mu", "l", "start", "4_letters")
        assert set(result.coords) == {"mu", "l", "label", "x0"}
        assert result.period.attrs["flag_meanings"] == "undecided aperiodic"
        assert result.attrs["grazing_config_sha256"] == some.document["grazing_config_sha256"]
        expected = gz.studies.plan.run_plan(some)
        for name in ("points", "mean", "period", "mu", "l", "x0"):
            assert result[name].dtype == expected[name].dtype
            np.testing.assert_array_equal(result[name], expected[name])
        assert result.done.values.tolist() == [[1, 1]] * 3


def test_its_metadata_is_strict_json(store):
    def refuse(name):
        raise AssertionError(name)

    seen = []
    for name, content in files(store).items():
        if name.endswith("zarr.json") and name != "points/zarr.json":
            seen.append(json.loads(content, parse_constant=refuse)["zarr_format"])
    assert len(seen) > 2 and set(seen) == {3}


def test_an_empty_folder_is_filled(tmp_path):
    (tmp_path / "a.zarr").mkdir()
    assert sweep.run(plan(), tmp_path / "a.zarr").complete


def foreign_file(path):
    path.write_text("mine")


def foreign_folder(path):
    path.mkdir()
    (path / "thesis.tex").write_text("mine")


def foreign_zarr(path):
    zarr.open_group(str(path), mode="w", zarr_format=3).create_array("x", shape=(3,), dtype="f8")


def foreign_old_zarr(path):
    zarr.open_group(str(path), mode="w", zarr_format=2)


def foreign_json(path):
    path.mkdir()
    (path / "zarr.json").write_text("[1, 2]")


def dangling_link(path):
    path.symlink_to(path.parent / "nowhere" / "at all")


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (foreign_file, "is not a folder; a sweep is stored in a folder of its own$"),
        (foreign_folder, "is a folder without a sweep; a sweep is stored in a folder of its own$"),
        (foreign_zarr, "was written by something else: it holds no sweep"),
        (foreign_old_zarr, "is a folder without a sweep"),
        (foreign_json, "is damaged: zarr.json cannot be used"),
        (dangling_link, "is not a folder"),
    ],
)
def test_what_is_not_ours_is_left_alone(tmp_path, make, said):
    path = tmp_path / "a.zarr"
    make(path)
    before = sorted((file.name, file.is_file() and file.read_bytes()) for file in tmp_path.rglob("*"))
    for action in (lambda: sweep.run(plan(), path), lambda: sweep.resume(path, plan()), lambda: sweep.status(path)):
        with pytest.raises(gz.InputError, match=said):
            action()
    assert sorted((file.name, file.is_file() and file.read_bytes()) for file in tmp_path.rglob("*")) == before


def test_a_link_to_an_empty_folder_is_filled(tmp_path):
    (tmp_path / "disk" / "inner").mkdir(parents=True)
    (tmp_path / "a.zarr").symlink_to(tmp_path / "disk" / "inner")
    assert sweep.run(plan(), tmp_path / "a.zarr", chunk=2, shard=(1, 2)).chunks_done == 2
    assert sweep.resume(tmp_path / "a.zarr", plan()).complete
    assert (tmp_path / "a.zarr").is_symlink() and (tmp_path / "disk" / "inner" / "zarr.json").is_file()
    assert [file.name for file in (tmp_path / "disk").iterdir()] == ["inner"]


@pytest.mark.parametrize("path", ["s3://bucket/a.zarr", "", None, 3])
def test_paths_that_are_none(path):
    with pytest.raises(gz.InputError, match=r"give the path of a folder on a disk of this machine"):
        sweep.run(plan(), path)


def test_a_folder_above_that_is_missing(tmp_path):
    with pytest.raises(gz.InputError, match=r"there is no folder .*missing; make it first"):
        sweep.run(plan(), tmp_path / "missing" / "a.zarr")
    with pytest.raises(gz.InputError, match=r"there is no sweep in"):
        sweep.status(tmp_path / "a.zarr")
    (tmp_path / "file").write_text("")
    with pytest.raises(gz.InputError, match=r"there is no folder|cannot be read"):
        sweep.run(plan(), tmp_path / "file" / "a.zarr")


def test_a_relative_path_and_one_with_spaces(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert sweep.run(plan(), "a sweep.zarr").path == tmp_path / "a sweep.zarr"
    assert sweep.open_store("a sweep.zarr").sizes["mu"] == 7


# ---- damage


def drop(store, name):
    (store / name).unlink()


def garble(store, name):
    (store / name).write_bytes(b"{}")


def cut(store, name):
    content = (store / name).read_bytes()
    (store / name).write_bytes(content[: len(content) // 2])


@pytest.mark.parametrize("harm", [drop, garble, cut])
@pytest.mark.parametrize("name", ["points/zarr.json", "done/zarr.json", "mu/zarr.json"])
def test_a_damaged_template_is_named_and_can_be_put_back(store, harm, name):
    copy = (store / name).read_bytes()
    shutil.rmtree(store / "done" / "c")
    harm(store, name)
    with pytest.raises(
        gz.InputError, match=f"a.zarr is damaged: {name} cannot be used .*Put that file back from a copy"
    ):
        sweep.run(plan(5, 3), store)
    (store / name).write_bytes(copy)
    assert sweep.run(plan(5, 3), store).complete


def test_a_store_without_its_head_is_not_taken_for_a_foreign_folder(store):
    (store / "zarr.json").unlink()
    with pytest.raises(gz.InputError, match=r"a.zarr is damaged: zarr.json cannot be used \(it is missing\)"):
        sweep.run(plan(5, 3), store)


def test_a_changed_attribute_is_damage(store):
    before = files(store)
    zarr.open_array(str(store / "points"), mode="r+").attrs["units"] = "m"
    for act in (sweep.open_store, sweep.status, lambda store: sweep.verify(store, 1.0, plan=plan(5, 3))):
        with pytest.raises(
            gz.InputError, match=r"points/zarr.json cannot be used \(it is not what the manifest says\)"
        ):
            act(store)
    assert "repaired: points/zarr.json" in str(sweep.verify(store, plan=plan(5, 3), repair=True))
    assert files(store) == before


def test_an_edited_configuration_is_damage(store):
    text = (store / "zarr.json").read_text()
    (store / "zarr.json").write_text(text.replace('\\"keep\\":4', '\\"keep\\":5'))
    with pytest.raises(gz.InputError, match=r"the configuration does not fit its hash"):
        sweep.status(store)


@pytest.mark.parametrize("number", ["9", "true", "1.0"])
def test_a_store_of_a_later_format(store, number):
    """True, which is 1 in Python, was taken for version 0.1, of which no chunk is held to a manifest."""
    text = (store / "zarr.json").read_text()
    (store / "zarr.json").write_text(text.replace('{\\"format\\":2', f'{{\\"format\\":{number}'))
    said = rf"a.zarr cannot be opened: it has format {json.loads(number)}, this version reads 1 and 2"
    with pytest.raises(gz.InputError, match=said):
        sweep.status(store)


def test_coordinates_that_a_store_cannot_hold(tmp_path):
    some = plan()
    some.coords["label"] = ("start", np.array(["a", 1, None], object))
    with pytest.raises(gz.InputError, match=r"coordinate 'label' has values that are neither numbers nor text"):
        sweep.run(some, tmp_path / "a.zarr")
    assert list(tmp_path.iterdir()) == []


def test_a_huge_cell_is_cut_into_several_files(tmp_path, monkeypatch):
    monkeypatch.setattr("grazing.sweep.layout.LARGEST_FILE", 100)
    sweep.run(plan(5), tmp_path / "a.zarr", chunk=2)
    assert len(list((tmp_path / "a.zarr" / "points" / "c").rglob("*"))) > 3 * 3
    xr.testing.assert_identical(sweep.open_store(tmp_path / "a.zarr"), gz.studies.plan.run_plan(plan(5)))
    assert sweep.verify(tmp_path / "a.zarr", 1.0, plan=plan(5)).ok


def test_names_that_a_store_keeps_for_itself(tmp_path):
    some = plan()
    for name in ("done", "manifest", "made_by", "a b", "a/b", ".x"):
        some.variables.clear()
        some.variables[name] = plan().variables["mean"]
        with pytest.raises(gz.InputError, match=r"a store keeps 'done', 'manifest' and 'made_by' for itself"):
            sweep.run(some, tmp_path / "a.zarr")
    some.variables.clear()
    some.variables["mu"] = plan().variables["mean"]
    with pytest.raises(gz.InputError, match=r"mu is both a variable and a coordinate"):
        sweep.run(some, tmp_path / "a.zarr")
    assert list(tmp_path.iterdir()) == []


def test_a_store_that_may_not_be_read_is_not_called_damaged(tmp_path, monkeypatch):
    """Of its manifest it was said that it is damaged, with the advice to put it back."""
    G = gz.gap_map(lam=0.8, mu=0.1, l=0.2)
    sweep.run(gz.plans.density(G, "mu", [0.1, 0.2], starts=3), tmp_path / "a.zarr")
    real = os.open
    for kept in ("template", "seal", "zarr.json"):

        def refuses(path, *given, kept=kept, **options):
            if os.path.basename(path) == kept:
                raise PermissionError(13, "Permission denied", path)
            return real(path, *given, **options)

        monkeypatch.setattr(os, "open", refuses)
        with pytest.raises(gz.InputError, match=rf"a\.zarr cannot be read: Permission denied \(\S*{kept}\)$"):
            gz.load(tmp_path / "a.zarr")
