import os
import tracemalloc

import numpy as np
import pytest
import xarray as xr
from scipy.io import netcdf_file

import grazing as gz
from grazing.io import load, save


def everything():
    """Every type that a result may have, in an order that is not the alphabet's."""
    kinds = ("float64", "float32", "int8", "int16", "int32", "int64", "uint8", "uint16", "uint32", "uint64", "bool")
    result = xr.Dataset({f"a_{kind}": ("d", np.array([0, 1, 100], kind)) for kind in kinds})
    result["special"] = ("d", [np.nan, -np.inf, 5e-324])
    result["words"] = (("d", "start"), np.array([["LLR", ""], ["L", "λμ(12)"], ["", ""]]))
    result["empty"] = ("d", np.array(["", "", ""]))
    result["multipliers"] = ("d", np.array([1 + 2j, np.nan, -1e-300j]))
    result["large"] = ("d", np.array([2**53, -(2**40), 3]))
    result["scalar"] = 3
    result["nothing"] = ("zero", np.zeros(0, np.int64))
    result = result.assign_coords(
        d=("d", [0.3, 0.2, 0.1], {"units": "1", "symbol": r"\mu"}), tag=("d", ["a", "b", "c"])
    )
    result["a_int8"].attrs = {"flag_values": np.array([1], np.int8), "list": [1, 2], "flag_meanings": "one"}
    result.attrs = {"text": "λ", "empty": "", "whole": 3, "number": 0.1, "one": np.array([1]), "np": np.float64(2.5)}
    return result


def test_what_is_saved_comes_back(tmp_path):
    result = everything()
    path = save(result, tmp_path / "all.nc")
    loaded = load(path)
    xr.testing.assert_identical(loaded, result)
    assert list(loaded.data_vars) == list(result.data_vars)
    for name in result.variables:
        assert loaded[name].dtype == result[name].dtype, name
    for name, value in result.attrs.items():
        assert type(loaded.attrs[name]) is type(value)
    assert loaded["a_int8"].attrs["flag_values"].dtype == np.int8
    assert loaded["a_int8"].attrs["flag_values"].shape == (1,)
    assert loaded["a_int8"].attrs["list"] == [1, 2]
    assert loaded.encoding["date_created"].startswith("20")


@pytest.mark.parametrize("kind", ["c8", "c16"])
def test_complex_numbers_come_back_bit_by_bit(kind, tmp_path):
    """Their parts were added: an infinite imaginary part made the real one NaN, and -0 became 0."""
    parts = [(np.inf, 1.0), (1.0, np.inf), (-0.0, 0.0), (np.nan, -np.inf), (0.0, -0.0)]
    given = xr.Dataset({"z": ("d", np.array([complex(*both) for both in parts], kind))})
    assert load(save(given, tmp_path / "a.nc")).z.values.tobytes() == given.z.values.tobytes()


def test_saved_again_it_is_the_same(tmp_path):
    once = load(save(everything(), tmp_path / "a.nc"))
    xr.testing.assert_identical(load(save(once, tmp_path / "b.nc")), everything())


def test_the_dataset_itself_is_left_alone(tmp_path):
    result = everything()
    save(result, tmp_path / "a.nc")
    xr.testing.assert_identical(result, everything())
    assert not result["a_float64"].encoding


def test_the_loaded_result_does_not_hold_the_file(tmp_path):
    path = save(everything(), tmp_path / "a.nc")
    loaded = load(path)
    path.unlink()
    assert loaded["special"].values[2] == 5e-324


def test_other_programs_read_the_numbers(tmp_path):
    path = save(everything(), tmp_path / "a.nc")
    with xr.open_dataset(path, engine="scipy") as plain:
        assert plain["a_float64"].values.tolist() == [0.0, 1.0, 100.0]
        assert plain["d"].attrs["symbol"] == r"\mu"


def test_trajectory(tmp_path):
    result = gz.trajectory(gz.pinball(), (0.1, 0.0), until=20.0)
    xr.testing.assert_identical(load(save(result, tmp_path / "flight.nc")), result)


@pytest.mark.parametrize("where", ["writing", "renaming"])
def test_a_failure_leaves_the_old_file_and_nothing_else(tmp_path, monkeypatch, where):
    path = save(everything(), tmp_path / "a.nc")
    before = path.read_bytes()

    def full(*args, **kwargs):
        if where == "writing":
            args[0].fp.write(b"CDF half")
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(*((netcdf_file, "flush") if where == "writing" else (os, "replace")), full)
    with pytest.raises(gz.InputError, match="cannot be written: No space left on device; choose another folder"):
        save(xr.Dataset({"x": 1}), path)
    assert path.read_bytes() == before
    assert os.listdir(tmp_path) == ["a.nc"]


def test_a_folder_that_is_not_one(tmp_path):
    """A file stands where the folder should be: unwritable for everybody, the superuser included."""
    (tmp_path / "file").write_text("mine")
    with pytest.raises(gz.InputError, match=r"there is no folder .*file; make it first"):
        save(everything(), tmp_path / "file" / "a.nc")
    assert (tmp_path / "file").read_text() == "mine"


@pytest.mark.parametrize(
    ("result", "name", "said"),
    [
        (xr.Dataset(), "a.csv", "a.csv ends in '.csv'; allowed is '.nc'"),
        (xr.Dataset(), "a", "a ends in 'nothing'; allowed is '.nc'"),
        (xr.Dataset(), "missing/a.nc", "there is no folder .*missing; make it first"),
        (xr.Dataset(), "folder.nc", "folder.nc is a folder; give the name of a file"),
        ({"x": 1}, "a.nc", "cannot save dict; give the xarray.Dataset that a study returns"),
        (xr.Dataset({"x": ((), object())}), "a.nc", "variable 'x' is of type object; a file holds numbers and text"),
        (xr.Dataset({"x": 2**60 + 1}), "a.nc", r"variable 'x' has whole numbers beyond 2\^53"),
        (xr.Dataset({3: 1}), "a.nc", "variable 3 has no text for a name; rename it"),
        (xr.Dataset(attrs={"a": None}), "a.nc", "attribute 'a' of the dataset is None; give text"),
        (xr.Dataset(attrs={"a": True}), "a.nc", "attribute 'a' of the dataset is True; give text"),
        (xr.Dataset(attrs={"a": {"b": 1}}), "a.nc", "attribute 'a' of the dataset is {'b': 1}; give text"),
        (xr.Dataset({"x": ((), 1, {"a": ["b"]})}), "a.nc", r"attribute 'a' of variable 'x' is \['b'\]; give text"),
        (xr.Dataset(attrs={"int": "b"}), "a.nc", "a.nc cannot be written: Not a valid attribute name; rename it"),
        (xr.Dataset(attrs={1: "b"}), "a.nc", "attribute 1 of the dataset has no text for a name"),
    ],
)
def test_what_cannot_be_saved(tmp_path, result, name, said):
    (tmp_path / "folder.nc").mkdir()
    with pytest.raises(gz.InputError, match=said):
        save(result, tmp_path / name)
    assert os.listdir(tmp_path) == ["folder.nc"]


def test_what_cannot_be_loaded(tmp_path):
    ours = save(everything(), tmp_path / "ours.nc")
    foreign = tmp_path / "foreign.nc"
    xr.Dataset({"x": 1.0}).to_netcdf(foreign, engine="scipy")
    text = tmp_path / "text.nc"
    text.write_text("words")
    newer = tmp_path / "newer.nc"
    newer.write_bytes(b"\x89HDF\r\n\x1a\n")
    damaged = tmp_path / "damaged.nc"
    damaged.write_bytes(ours.read_bytes()[:500])
    for path, said in [
        (tmp_path / "none.nc", "there is no file .*none.nc"),
        (tmp_path, "is a folder: give the store of a sweep, or a file that gz.save wrote; "),
        (foreign, "foreign.nc was not written by gz.save; open it with xarray.open_dataset instead"),
        (newer, "newer.nc was not written by gz.save; open it with xarray.open_dataset instead"),
        (text, "text.nc was not written by gz.save; give a .nc file that it wrote, or a store"),
        (damaged, "damaged.nc is damaged and cannot be read"),
    ]:
        with pytest.raises(gz.InputError, match=said):
            load(path)


def test_a_file_from_the_future(tmp_path):
    path = save(xr.Dataset({"x": 1}), tmp_path / "a.nc")
    path.write_bytes(path.read_bytes().replace(b'"format": 1', b'"format": 9'))
    with pytest.raises(gz.InputError, match="has format 9, this version reads 1; update grazing"):
        load(path)


def test_saving_and_loading_take_few_copies(tmp_path):
    """What is refused beyond half of the memory is the result, and the copies that its file takes must fit as well."""
    result = xr.Dataset({"x": ("n", np.linspace(0.0, 1.0, 10**6))})
    save(result[{"n": [0]}], tmp_path / "small.nc")  # imports what it needs
    load(tmp_path / "small.nc")
    for action, copies in ((lambda: save(result, tmp_path / "a.nc"), 1), (lambda: load(tmp_path / "a.nc"), 3)):
        tracemalloc.start()
        try:
            action()
            assert tracemalloc.get_traced_memory()[1] < (copies + 0.4) * result.nbytes
        finally:
            tracemalloc.stop()


def test_the_room_of_texts_is_foreseen(tmp_path, monkeypatch):
    """Each takes that of the longest: one word of 400 letters made 240 MB of 0.8."""
    words = np.array(["L"] * 999 + ["L" * 400], object)
    monkeypatch.setattr("grazing.memory.physical_memory", lambda: 2 * 1000 * 400 * 6 - 1)
    with pytest.raises(
        gz.InputError, match=r"the file would take 0\.0024 GB.*'word', whose longest text has 400 letters"
    ):
        save(xr.Dataset({"word": ("n", words)}), tmp_path / "a.nc")
    assert not list(tmp_path.iterdir())
    monkeypatch.setattr("grazing.memory.physical_memory", lambda: 2 * 1000 * 400 * 6)
    save(xr.Dataset({"word": ("n", words)}), tmp_path / "a.nc")


@pytest.mark.parametrize("error", [MemoryError("no room"), ImportError("no memory for its code")])
def test_a_file_is_not_blamed_for_a_lack_of_memory(tmp_path, monkeypatch, error):
    """It was "damaged" where the reader itself could not be loaded."""

    def fails(*_given):
        raise error

    file = save(xr.Dataset({"a": 1.0}), tmp_path / "a.nc")
    monkeypatch.setattr("grazing.io._read", fails)
    with pytest.raises(type(error), match=str(error)):
        load(file)


def test_a_disk_that_fails_while_a_file_is_read(tmp_path, monkeypatch):
    def fails(*_given):
        raise OSError(5, "Input/output error")

    file = save(xr.Dataset({"a": 1.0}), tmp_path / "a.nc")
    monkeypatch.setattr("grazing.io._read", fails)
    with pytest.raises(gz.InputError, match=r"a\.nc cannot be read: Input/output error"):
        load(file)
