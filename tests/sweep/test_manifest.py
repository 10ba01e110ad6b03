"""The manifest: what is bound, who made what, and the stores that have none."""

import hashlib
import json
import os
import shutil
import zipfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
import zarr

import grazing as gz
from grazing import sweep
from grazing.studies.plan import run_plan
from grazing.sweep import manifest, same
from grazing.sweep.codec import decode, encode
from grazing.sweep.opened import open_existing
from tests.sweep.plans import files, plan


@pytest.fixture
def store(tmp_path):
    sweep.run(plan(7), tmp_path / "a.zarr", chunk=2)
    return tmp_path / "a.zarr"


@pytest.fixture
def unbound(tmp_path):
    """A store that version 0.1 wrote."""
    with zipfile.ZipFile(Path(__file__).with_name("store_0_1.zip")) as packed:
        packed.extractall(tmp_path / "old.zarr")
    return tmp_path / "old.zarr"


def other_version(monkeypatch):
    monkeypatch.setattr(gz, "__version__", "9.9")


# ---- what is bound


def test_every_file_of_the_result_is_bound(store):
    bound = set(manifest.read_template(store).metadata) | set(manifest.read_template(store).coordinates)
    identity = open_existing(store).token
    for number in range(4):
        record = manifest.read_record(store, identity, number)
        bound |= set(record.files)
        for key, (length, digest) in record.files.items():
            content = (store / key).read_bytes()
            assert (length, digest) == (len(content), hashlib.sha256(content).hexdigest())
    others = {key for key in files(store) if not key.startswith(("manifest/", "done/c/"))}
    assert others == bound


def test_two_swapped_chunks_are_found(store):
    one, two = (store / "period" / "c" / i for i in ("1", "2"))
    first, second = one.read_bytes(), two.read_bytes()
    one.write_bytes(second)
    two.write_bytes(first)
    with pytest.raises(
        gz.InputError, match=r"period in chunk 1 cannot be read \(period/c/1: it does not hold what was"
    ):
        sweep.open_store(store)
    found = sweep.verify(store, 0.0, plan=plan(7))
    assert [(one.variable, one.chunk) for one in found.differences] == [("period", 1), ("period", 2)]


def test_a_record_fits_one_place_in_one_store(store, tmp_path):
    chunks = store / "manifest" / "chunks"
    (chunks / "1").write_bytes((chunks / "2").read_bytes())
    with pytest.raises(gz.InputError, match=r"the record of chunk 1 cannot be read \(it belongs to chunk 2\)"):
        sweep.open_store(store)
    sweep.run(plan(7, seed=1), tmp_path / "b.zarr", chunk=2)
    (chunks / "1").write_bytes((tmp_path / "b.zarr" / "manifest" / "chunks" / "1").read_bytes())
    with pytest.raises(gz.InputError, match=r"the record of chunk 1 cannot be read \(it belongs to another store\)"):
        sweep.open_store(store)
    assert sweep.status(store).damaged == 1 and "damaged: the records of 1 chunks" in str(sweep.status(store))


def test_a_chunk_that_was_put_back_with_its_record_is_found(store, monkeypatch):
    older = store.parent / "older.zarr"
    shutil.copytree(store, older)
    (older / "done" / "c" / "2").unlink()
    with monkeypatch.context() as patch:
        other_version(patch)
        sweep.run(plan(7), older, other_code=True)
    for key in ("manifest/chunks/2", "points/c/2/0/0"):
        (store / key).write_bytes((older / key).read_bytes())
    with pytest.raises(gz.InputError, match=r"the record of chunk 2 .*it was put back or replaced"):
        sweep.open_store(store)
    before = files(older)
    assert sweep.verify(store, plan=plan(7), repair=True).missing == (2,)
    assert sweep.run(plan(7), store).complete
    assert before != files(store)
    assert "grazing_mixture" not in sweep.open_store(store).attrs


def test_a_done_chunk_without_a_record_is_damage_and_a_run_computes_it_again(store):
    before = files(store)
    (store / "manifest" / "chunks" / "3").unlink()
    with pytest.raises(gz.InputError, match=r"the record of chunk 3 cannot be read \(No such file"):
        sweep.open_store(store)
    assert sweep.run(plan(7), store).complete
    assert files(store) == before


def test_metadata_are_put_back_without_a_plan_and_by_any_version(store, monkeypatch):
    before = files(store)
    for key in ("zarr.json", "points/zarr.json", "manifest/seal"):
        (store / key).unlink()
    (store / "mean" / "zarr.json").write_bytes(b"{}")
    with pytest.raises(gz.InputError, match=r"zarr.json cannot be used \(it is missing\).*verify --repair"):
        sweep.open_store(store)
    found = sweep.verify(store, plan=plan(7), repair=True)
    assert set(found.mended) == {"zarr.json", "points/zarr.json", "mean/zarr.json"} and not found.ok
    assert files(store) == before


@pytest.mark.parametrize("also", [[], ["zarr.json"], ["zarr.json", "mu/c/0", "points/zarr.json"]])
def test_a_damaged_template_is_made_again(store, also):
    before = files(store)
    for key in ("manifest/template", *also):
        (store / key).write_bytes(b"rubbish")
    with pytest.raises(gz.InputError, match=r"is damaged"):
        sweep.open_store(store)
    if also:
        with pytest.raises(gz.InputError, match=r"Give the plan, with the versions|keeps no recipe"):
            sweep.verify(store, repair=True)
        with pytest.raises(gz.InputError, match=r"Give the plan, with the versions"):
            sweep.verify(store, plan=plan(7, seed=3), repair=True)
    sweep.verify(store, plan=plan(7), repair=True)
    assert files(store) == before


def test_the_seal_is_written_by_whoever_comes_next(store):
    before = files(store)
    (store / "manifest" / "seal").unlink()  # as when a run was killed just before
    assert sweep.run(plan(7), store).complete
    assert files(store) == before
    sweep.run(plan(7), store.parent / "half.zarr", chunk=2, shard=(1, 2))
    assert not (store.parent / "half.zarr" / "manifest" / "seal").exists()


# ---- the bytes are Zarr's


@pytest.mark.parametrize("dtype", ["float64", "float32", "int32", "int64", "uint8", "bool"])
@pytest.mark.parametrize(("shape", "chunk"), [((4, 3), (4, 3)), ((3, 2), (4, 3)), ((1,), (70_000,)), ((), ())])
def test_bytes_are_those_that_zarr_writes(tmp_path, dtype, shape, chunk):
    from zarr.codecs import Crc32cCodec, ZstdCodec

    values = np.random.default_rng(0).integers(0, 2, shape).astype(dtype)
    fill = np.nan if dtype.startswith("float") else 0
    array = zarr.create_array(
        str(tmp_path / "a"), shape=shape, chunks=chunk, dtype=dtype, fill_value=fill, filters=None,
        compressors=[ZstdCodec(level=0), Crc32cCodec()], config={"write_empty_chunks": True},
    )  # fmt: skip
    array[...] = values
    content = (tmp_path / "a" / "/".join(["c", *("0" for _ in shape)])).read_bytes()
    assert encode(values, chunk) == content
    back = decode(content, chunk, dtype)
    assert back.dtype == dtype and np.array_equal(back[tuple(map(slice, shape))], values)


# ---- who made it


def test_other_versions_are_refused_by_name_and_shown_as_a_mixture(store, monkeypatch):
    for number in ("1", "3"):
        (store / "done" / "c" / number).unlink()
    monkeypatch.setattr("grazing.studies.labels.installed", lambda package: "9.8" if package == "numpy" else "1")
    with pytest.raises(
        gz.InputError, match=r"was begun by other code: .*numpy is '.*' there and '9.8' here.*--other-code"
    ):
        sweep.resume(store, plan(7))
    assert sweep.resume(store, plan(7), other_code=True).complete
    found = sweep.open_store(store)
    assert found.made_by.values.tolist() == [0, 0, 1, 1, 0, 0, 1]
    makers = json.loads(found.made_by.attrs["makers"])
    assert makers[1]["numpy"] == "9.8" and makers[0]["numpy"] == np.__version__
    assert "2 of 4 chunks by the code" in found.attrs["grazing_mixture"] == sweep.status(store).mixture
    assert np.array_equal(found.points, run_plan(plan(7)).points, equal_nan=True)


def test_a_store_that_the_beginner_computed_nothing_of_says_so(tmp_path, monkeypatch):
    store = tmp_path / "a.zarr"
    sweep.run(plan(7), store, chunk=2, shard=(5, 5))  # five shards, four chunks: nothing
    other_version(monkeypatch)
    sweep.run(plan(7), store, other_code=True)
    assert sweep.open_store(store).attrs["grazing_mixture"].startswith("0 of 4 chunks by the code that the sweep was")


def test_one_maker_is_not_mentioned(store):
    found = sweep.open_store(store)
    assert not {"made_by", "done"} & set(found.variables)
    assert not {"grazing_mixture", "grazing_unbound", "grazing_made_by"} & set(found.attrs)
    assert sweep.status(store).mixture == ""


@pytest.mark.parametrize("text", ["lanes.py", "saltation.py", "flippers.py", "windows.py", "parameter.py"])
def test_the_package_s_own_text_counts(text, monkeypatch):
    """That of systems and of tables did not."""
    from grazing.sweep import made_by

    found = made_by.made_by(plan(7))
    assert set(found) >= {"code", "package", "grazing", "numpy", "numba", "llvmlite", "python", "machine", "arithmetic"}
    before = made_by._package.__wrapped__()
    read = Path.read_bytes
    monkeypatch.setattr(Path, "read_bytes", lambda file: read(file) + b"#" * (file.name == text))
    assert made_by._package.__wrapped__() != before == found["package"]


# ---- stores of version 0.1


def test_a_store_of_version_0_1_is_read_as_unbound(unbound):
    found = sweep.open_store(unbound)
    assert "without a manifest" in found.attrs.pop("grazing_unbound")
    expected = run_plan(plan(3))
    for name in expected.variables:
        xr.testing.assert_identical(found[name], expected[name])
    known = sweep.status(unbound)
    assert known.complete and not known.bound and "unbound: made by version 0.1" in str(known)


def test_a_store_of_version_0_1_is_neither_gone_on_with_nor_repaired(unbound):
    before = files(unbound)
    (unbound / "done" / "c" / "1").unlink()
    for act in (sweep.run, lambda some, store: sweep.resume(store, some)):
        with pytest.raises(gz.InputError, match=r"was begun by version 0.1, which wrote no manifest.*another folder"):
            act(plan(3), unbound)
    assert sweep.verify(unbound, 1.0, plan=plan(3), other_code=True).ok
    with pytest.raises(gz.InputError, match=r"has no manifest to repair it from"):
        sweep.verify(unbound, plan=plan(3), other_code=True, repair=True)
    assert {**files(unbound), "done/c/1": b"\1"} == before


def test_other_code_is_not_offered_where_it_does_not_help(unbound, monkeypatch):
    """Its arrays are others: --other-code was advised, and refused in its turn."""
    laid_out = same.laid_out

    def another(some, grid):
        layout, specs = laid_out(some, grid)
        return replace(layout, variables={**layout.variables, "more": "n"}), specs

    with pytest.raises(same.OtherCodeError, match="--other-code"):
        sweep.verify(unbound, plan=plan(3))
    monkeypatch.setattr(same, "laid_out", another)
    for allowed in (False, True):
        with pytest.raises(gz.InputError, match=r"stored other arrays; give another folder") as said:
            sweep.verify(unbound, plan=plan(3), other_code=allowed)
        assert "other-code" not in str(said.value)


def test_a_bound_store_does_not_pass_for_an_unbound_one(store):
    shutil.rmtree(store / "manifest")
    with pytest.raises(gz.InputError, match=r"manifest/template cannot be used"):
        sweep.open_store(store)
    with pytest.raises(gz.InputError, match=r"manifest/template cannot be used"):
        sweep.run(plan(7), store)


# ---- fsync


def test_fsync_forces_chunk_record_and_done_in_this_order(tmp_path, monkeypatch):
    if not Path("/proc/self/fd").is_dir():
        pytest.skip("needs /proc")
    forced, fsync = [], os.fsync
    monkeypatch.setattr(
        "grazing.sweep.files.os.fsync",
        lambda handle: (forced.append(os.readlink(f"/proc/self/fd/{handle}")), fsync(handle)),
    )
    sweep.run(plan(2), tmp_path / "a.zarr", chunk=2)
    assert forced == []
    sweep.run(plan(2), tmp_path / "b.zarr", chunk=2, fsync=True)
    names = [Path(name).relative_to(tmp_path / "b.zarr").as_posix() for name in forced if "/b.zarr/" in name]
    written = [name.split(".")[0] for name in names if name.endswith(".partial")]
    assert written[-3:] == ["manifest/chunks/0", "done/c/0", "manifest/seal"]
    assert {"points/c/0/0/0", "mean/c/0", "period/c/0", "word/c/0/0/0"} == set(written[:-3])
    assert {"points/c/0/0", "points/c/0", "manifest/chunks", "done/c", "manifest"} <= set(names)
    assert any("b.zarr-" in name and "zarr.json" in name for name in forced)  # the template
