import json

import numpy as np
import pytest

import grazing as gz
from grazing.sweep import letters
from grazing.sweep.letters import decoded, encoded, restored_attrs, stored_attrs


@pytest.mark.parametrize("texts", [["LLR", "", "L"], [""], [], ["λμ", "a b", "R" * 8], [["L", "R"], ["", "LR"]]])
def test_texts_come_back(texts):
    texts = np.array(texts, object)
    rows = encoded(texts, 8, "word")
    assert rows.dtype == np.uint8 and rows.shape == (*texts.shape, 8)
    back = decoded(rows)
    assert back.dtype == object and back.shape == texts.shape and (back == texts).all()


def test_equal_texts_are_the_same_object():
    back = decoded(encoded(np.array(["LR", "L", "LR"], object), 2, "word"))
    assert back[0] is back[2] and type(back[0]) is str


def test_a_text_that_is_too_long_is_no_shorter_text():
    with pytest.raises(gz.GrazingError, match=r"word is 'LLLR', 4 letters; the plan announced at most 3"):
        encoded(np.array(["L", "LLLR"], object), 3, "word")


def test_texts_of_no_letters():
    assert decoded(encoded(np.array(["", ""], object), 0, "word")).tolist() == ["", ""]


ATTRS = {
    "text": "λ",
    "whole": 3,
    "number": 0.1,
    "np": np.float32(0.1),
    "nan": np.nan,
    "infinities": [np.inf, -np.inf, 1.0],
    "flags": np.array([0, -1], np.int8),
    "one": np.array([1]),
    "doubles": np.array([np.nan, 0.1]),
    "list": [1, 2],
}


def test_attributes_come_back_as_they_were():
    types = {}
    stored = json.loads(json.dumps(stored_attrs(ATTRS, "x", types), allow_nan=False))
    back = restored_attrs(stored, "x", types)
    assert list(back) == list(ATTRS)
    for name, value in ATTRS.items():
        assert type(back[name]) is type(value), name
        np.testing.assert_array_equal(back[name], value)
        if isinstance(value, np.ndarray):
            assert back[name].dtype == value.dtype and back[name].shape == value.shape


@pytest.mark.parametrize("kind", ["a", "<a5", "i1,a", "U9", "f4,f4", "3f8", "M8", "nonsense"])
def test_a_type_that_no_store_has(kind):
    """At an old name of NumPy's it warned, before it was refused."""
    with pytest.raises(ValueError, match=r"it names a type '.*', which no store has"):
        restored_attrs({"a": 1.0}, "x", {"x/a": kind})


@pytest.mark.parametrize("value", [[0, 1e999], [300, 0], -1])
def test_a_number_that_its_type_cannot_hold(value):
    """300 came back as 44, and an infinity as some number, with a warning of NumPy's."""
    with pytest.raises(OverflowError):
        restored_attrs({"a": value}, "x", {"x/a": f"uint8 {np.ndim(value)}"})


@pytest.mark.parametrize("value", [None, True, {"a": 1}, np.ones((2, 2)), 1j])
def test_attributes_that_no_file_holds(value):
    with pytest.raises(gz.InputError, match=r"attribute 'bad' of x is"):
        stored_attrs({"bad": value}, "x", {})


def test_equal_texts_of_several_chunks_are_one_object():
    known: dict[bytes, str] = {}
    chunk = encoded(np.array(["LR", "L", "", "LR"], object), 2, "word")
    one, other = decoded(chunk, known), decoded(chunk[::-1], known)
    assert one.tolist() == other.tolist()[::-1] == ["LR", "L", "", "LR"]
    assert one[0] is one[3] is other[0]


def test_texts_are_decoded_in_parts(monkeypatch):
    monkeypatch.setattr(letters, "TOGETHER", 2)
    words = np.array([["LR", "L", "ä"], ["", "LR", "R"]], object)
    assert decoded(encoded(words, 2, "word")).tolist() == words.tolist()
