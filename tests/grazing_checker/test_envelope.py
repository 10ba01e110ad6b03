import json
from copy import deepcopy

import pytest

from grazing.proof.text import write_certificate
from grazing_checker.envelope import FIELDS, LARGEST, digest_of, opened, seal
from grazing_checker.reading import Rejected


def made(**changes):
    data = {"a": ["0x1p0", "1.5"], "n": 3, "deep": {"x": [True, None]}}
    rows = [{"name": "one", "left": "1", "relation": "<", "right": "2"}]
    return {**seal("test", "It is so.", ["arithmetic"], data, rows), **changes}


def test_what_is_sealed_opens_and_holds_what_was_given():
    document = made()
    assert opened(document) == document
    assert tuple(document) == FIELDS
    assert document["data"]["n"] == 3
    assert opened(json.loads(json.dumps(document))) == document


@pytest.mark.parametrize("field", [name for name in FIELDS if name not in ("format", "version")])
def test_a_change_of_any_field_is_found(field):
    document = made()
    value = document[field]
    changed = value + "x" if isinstance(value, str) else [*value, "x"] if isinstance(value, list) else {**value, "x": 1}
    with pytest.raises(Rejected, match="changed after it was sealed"):
        opened({**document, field: changed})


def test_a_change_deep_inside_is_found():
    document = made()
    for change in (lambda d: d["data"]["a"].reverse(), lambda d: d["data"]["deep"]["x"].__setitem__(0, 1)):
        other = deepcopy(document)
        change(other)
        with pytest.raises(Rejected, match="SHA-256"):
            opened(other)


@pytest.mark.parametrize(
    ("document", "said"),
    [
        ({"format": []}, "format is \\[\\]"),
        ({}, "format is None"),
        (made(format="other"), "format is 'other'"),
        (made(version=1), r"version 1 of the format, this program reads 2; prove it again .* gz.certify\(orbit\)"),
        (made(version=True), "version True"),
        (made(more=1), "lacks or adds fields: more"),
        ({name: value for name, value in made().items() if name != "sha256"}, "lacks or adds fields: sha256"),
        (made(kind=3), "kind of the certificate is 3"),
        (made(data=[]), "data of the certificate"),
        (made(data={"x": float("nan")}), "what JSON cannot"),
        (made(data={"x": {1}}), "what JSON cannot"),
    ],
)
def test_what_is_no_certificate_is_refused_by_name(document, said):
    with pytest.raises(Rejected, match=said):
        opened(document)


def test_nan_cannot_be_sealed():
    with pytest.raises(ValueError, match="not JSON compliant"):
        seal("test", "", [], {"x": float("inf")}, [])


def test_the_hash_does_not_depend_on_the_order_of_keys_or_on_blanks():
    assert digest_of({"a": 1, "b": [2]}) == digest_of({"b": [2], "a": 1})
    assert digest_of({"a": "é"}) == digest_of(json.loads('{ "a" : "\\u00e9" }'))


def test_a_file_is_read_back(tmp_path):
    document = made()
    path = write_certificate(document, tmp_path / "c.json")
    assert opened(path) == document
    assert opened(str(path)) == document
    assert opened(document) == document


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("{", "not the JSON"),
        ("[]", "format is 'list'"),
        ("[" * 100_000, "not the JSON"),
        ("9" * 5000, "not the JSON"),
        ('{"format": "grazing certificate", "format": 1}', "appears twice"),
        ('{"x": NaN}', "NaN"),
    ],
)
def test_what_is_no_json_is_refused(tmp_path, text, said):
    path = tmp_path / "c.json"
    path.write_text(text)
    with pytest.raises(Rejected, match=said):
        opened(path)


@pytest.mark.parametrize("source", ["no/such/file.json", 3, "/dev/zero", ".", "\0", "", b"none", None])
def test_what_is_no_file_is_refused(source):
    with pytest.raises(Rejected, match="no certificate can be read"):
        opened(source)


def test_what_is_no_file_is_named_as_what_it_is():
    for source, said in (("/dev/zero", "it is a device or a pipe"), ("", "No such file or directory")):
        with pytest.raises(Rejected, match=said):
            opened(source)


def test_a_path_is_named_as_it_was_given(tmp_path):
    with pytest.raises(Rejected, match=r"read from '.*none\.json': No such file or directory; give its path"):
        opened(tmp_path / "none.json")


def test_a_file_that_is_too_large_is_not_read(tmp_path):
    path = tmp_path / "c.json"
    with path.open("wb") as file:
        file.truncate(LARGEST + 1)
    with pytest.raises(Rejected, match="larger than"):
        opened(path)


def test_the_bytes_of_a_file_are_counted_not_its_letters(tmp_path):
    """With one letter of two bytes in it, what came after so many bytes was left away in silence."""
    path = tmp_path / "c.json"
    document = {**made(statement="é")}
    document["sha256"] = digest_of({name: value for name, value in document.items() if name != "sha256"})
    text = json.dumps(document, ensure_ascii=False).encode()
    path.write_bytes(text)
    assert opened(path) == document
    path.write_bytes(text.ljust(LARGEST + 1) + b"and no more of it")
    with pytest.raises(Rejected, match="larger than"):
        opened(path)


def test_a_document_is_what_a_file_of_it_would_be():
    """Python's own kinds of numbers, keys and lists mean what JSON makes of them: nothing else is checked."""

    class Two(int):
        def __eq__(self, other):
            return True

        __hash__ = int.__hash__

    assert opened({**made(), "data": {**made()["data"], "n": Two(3)}})["data"]["n"] == 3
    with pytest.raises(Rejected, match="changed after it was sealed"):
        opened({**made(), "data": {**made()["data"], "n": Two(4)}})
