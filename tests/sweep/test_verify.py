import numpy as np
import pytest
import zarr

import grazing as gz
from grazing import sweep
from tests.sweep.plans import files, plan


@pytest.fixture
def store(tmp_path):
    sweep.run(plan(7), tmp_path / "a.zarr", chunk=2)
    return tmp_path / "a.zarr"


def test_an_untouched_store(store):
    found = sweep.verify(store, plan=plan(7))
    assert found.ok and found.read == 4 and len(found.computed) == 1 and not found.differences
    assert str(found) == "4 chunks read, 1 of them computed again: no difference"
    assert sweep.verify(store, 1.0, plan=plan(7)).computed == (0, 1, 2, 3)
    assert len(sweep.verify(store, 0.3, plan=plan(7)).computed) == 2
    assert len({sweep.verify(store, 0.0, seed, plan(7)).computed for seed in range(20)}) == 4


@pytest.mark.parametrize("name", ["points/c/1/0/0", "mean/c/1", "period/c/1", "word/c/1/0/0"])
def test_every_flipped_byte_is_found_whatever_the_share(store, name):
    content = (store / name).read_bytes()
    for at in {*range(0, len(content), 7), len(content) - 1}:
        (store / name).write_bytes(content[:at] + bytes([content[at] ^ 0x10]) + content[at + 1 :])
        (one,) = sweep.verify(store, 0.0, plan=plan(7)).differences
        assert (one.variable, one.chunk, one.cells) == (name.partition("/")[0], 1, (2, 3))
        assert "cannot be read" in one.reason
    assert "points in chunk 1 (mu 2 to 3)" in str(one) or name[:6] != "points"


@pytest.mark.parametrize("name", ["points/c/1/0/0", "word/c/1/0/0"])
def test_a_missing_or_empty_file(store, name):
    (store / name).write_bytes(b"")
    assert not sweep.verify(store, 0.0, plan=plan(7)).ok
    (store / name).unlink()
    (one,) = sweep.verify(store, 0.0, plan=plan(7)).differences
    assert one.reason == f"cannot be read: {name}: its file is missing"


@pytest.mark.parametrize(
    ("name", "value", "cells"), [("points", -0.0, (4,)), ("mean", 1.5, (4,)), ("period", 9, (4,)), ("word", 90, (4,))]
)
def test_wrong_numbers_are_found_by_computing_again(tmp_path, name, value, cells):
    wrong, compute = plan(7), plan(7).compute

    def slip(numbers, arrays):  # a computation that went wrong; what it wrote is what is there
        yield from compute(numbers, arrays)
        if 4 in numbers:
            array = arrays[name]
            array[(list(numbers).index(4), *(0,) * (array.ndim - 1))] = chr(value) if name == "word" else value

    object.__setattr__(wrong, "compute", slip)
    sweep.run(wrong, tmp_path / "b.zarr", chunk=2)
    assert sweep.verify(tmp_path / "b.zarr", 0.0, 1, plan=plan(7)).ok  # chunk 0 alone is computed again
    (one,) = sweep.verify(tmp_path / "b.zarr", 1.0, plan=plan(7)).differences
    assert (one.variable, one.chunk, one.cells) == (name, 2, cells)
    assert one.reason == "1 of 2 cells differ from what is computed"


def test_one_bit_of_a_nan_is_a_difference(store):
    array = zarr.open_array(str(store / "mean"), mode="r+")
    assert np.isnan(array[2])
    array[2] = np.array(0x7FC00001, np.uint32).view(np.float32)
    assert not sweep.verify(store, 1.0, plan=plan(7)).ok


def test_what_is_damaged_is_repaired_by_computing_it_again(store):
    before = files(store)
    (store / "points/c/1/0/0").write_bytes(b"rubbish")
    zarr.open_array(str(store / "period"), mode="r+")[6] = 99
    found = sweep.verify(store, 1.0, plan=plan(7), repair=True)
    assert found.repaired and {one.chunk for one in found.differences} == {1, 3} == {*found.missing}
    assert str(found).splitlines()[-1] == f"repaired: 2 chunks marked as missing (1, 3); resume {store}"
    assert sweep.status(store).chunks_done == 2
    assert sweep.resume(store, plan(7)).complete
    assert files(store) == before


@pytest.mark.parametrize("way", ["repair", "resume"])
def test_what_a_killed_process_left_anywhere_goes_away(store, way):
    """Of two at work on a chunk, as after a lock was removed by force, one was killed and the other finished it."""
    before = files(store)
    if way == "resume":
        (store / "done/c/3").unlink()
    for key in ("points/c/1/0/0", "mu/c/0", "manifest/template", "zarr.json", "mean/zarr.json"):
        (store / f"{key}.{'ab' * 16}.partial").touch()
    if way == "repair":
        sweep.verify(store, plan=plan(7), repair=True)
    else:
        sweep.resume(store, plan(7))
    assert files(store) == before


def test_coordinates_are_compared_and_put_back(store):
    before = files(store)
    zarr.open_array(str(store / "mu"), mode="r+")[0] = 0.0
    (one,) = sweep.verify(store, plan=plan(7)).differences
    assert str(one) == "mu: cannot be read: mu/c/0: it does not hold what was written there"
    found = sweep.verify(store, plan=plan(7), repair=True)
    assert not found.missing and str(found).splitlines()[-1] == "repaired: mu/c/0"
    assert files(store) == before


def test_a_store_that_is_not_complete(tmp_path):
    sweep.run(plan(7), tmp_path / "a.zarr", chunk=2, shard=(2, 2))
    assert sweep.verify(tmp_path / "a.zarr", 1.0, plan=plan(7)).computed == (1, 3)
    for number in (1, 3):
        (tmp_path / "a.zarr" / "done" / "c" / str(number)).unlink()
    assert sweep.verify(tmp_path / "a.zarr", plan=plan(7)).read == 0


def test_what_is_not_allowed(store):
    with pytest.raises(gz.InputError, match=r"share = 2; allowed is 0 <= share <= 1"):
        sweep.verify(store, 2, plan=plan(7))
    with pytest.raises(gz.InputError, match=r"holds another sweep: keep is 4 there and 5 here"):
        sweep.verify(store, plan=plan(7, keep=5))
    with pytest.raises(gz.InputError, match=r"keeps no recipe of its plan; give the plan itself"):
        sweep.verify(store)
