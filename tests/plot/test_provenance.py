"""What a figure says about itself comes back from its file as it went in."""

import json
import struct
import zlib

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from matplotlib.figure import Figure

from grazing import plot
from grazing.outcome import InputError
from tests.examples import examples
from tests.plot import results

KINDS = ("png", "pdf", "svg")
AWKWARD = {"a": r"back\slash (and) <tags> & ]]> \n\033 ü ∞", "b": [1, 2.5e-300, None, True], "c": {"(": ")))"}}
TEXT = st.text(st.characters(codec="utf-8", exclude_categories=("Cs", "Cc")), max_size=30)
JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False, allow_infinity=False) | TEXT,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(TEXT, inner, max_size=3),
    max_leaves=8,
)


def write(path, data):
    path.write_bytes(data)
    return path


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("title", ["", "Plain", "Λ (λ = ½), ∞", r"a\(b"])
def test_there_and_back(tmp_path, kind, title):
    path = plot.save(plot.figure(20, 20), tmp_path / f"a.{kind}", title, AWKWARD)
    found = plot.provenance(path)
    assert found["provenance"] == AWKWARD
    assert found["title"] == title
    assert found["software"].startswith("grazing")
    renamed = path.rename(tmp_path / "a.data")
    assert plot.provenance(str(renamed)) == found  # the content decides, not the name


@pytest.mark.parametrize("kind", KINDS)
@settings(max_examples=examples(15), deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(provenance=st.dictionaries(TEXT, JSON, max_size=4))
def test_anything_that_json_holds(tmp_path, kind, provenance):
    path = plot.save(plot.figure(10, 10), tmp_path / f"a.{kind}", provenance=provenance)
    assert plot.provenance(path)["provenance"] == provenance


def test_a_figure_of_a_result_carries_its_configuration(tmp_path):
    result = results.density(np.linspace(3.5, 3.9, 5))
    for drawn in (plot.density(result), plot.chart(results.chart()), plot.basins(results.basins())):
        found = plot.provenance(plot.save(drawn, tmp_path / "a.png", provenance={"command": "x"}))["provenance"]
        assert found["grazing_config"] == json.loads(results.ATTRS["grazing_config"])
        assert found["grazing_config_sha256"] == results.ATTRS["grazing_config_sha256"]
        assert found["command"] == "x"
    bare = plot.provenance(plot.save(drawn["figure"], tmp_path / "b.png"))
    assert bare["provenance"] == {}


def test_the_provenance_of_a_result():
    result = results.density()
    result.attrs |= {"grazing_count": np.int64(3), "grazing_odd": "{not json", "history": "x"}
    found = plot.provenance_of(result)
    assert found == {
        "title": "made up",
        "source": "grazing 0.0",
        "grazing_config": {"study": "none", "map": "made up", "values": [1, 2]},
        "grazing_config_sha256": "0" * 64,
        "grazing_count": 3,
        "grazing_odd": "{not json",
    }
    assert plot.provenance_of(None) == {}


def chunk(kind, data):
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def test_all_kinds_of_text_in_png(tmp_path):
    whole = plot.rendered(plot.figure(10, 10), "png")
    origin = zlib.compress(b'{"a": 1}')
    start = whole[:8] + chunk(b"tEXt", b"Software\0grazing 9")
    packed = start + chunk(b"zTXt", b"Description\0\0" + origin) + chunk(b"IEND", b"")
    assert plot.provenance(write(tmp_path / "a", packed))["provenance"] == {"a": 1}
    international = start + chunk(b"iTXt", b"Description\0\1\0en\0Art\0" + origin) + chunk(b"IEND", b"")
    assert plot.provenance(write(tmp_path / "a", international))["provenance"] == {"a": 1}


def test_all_kinds_of_strings_in_pdf(tmp_path):
    body = rb"""%PDF-1.4
1 0 obj
<< /Creator (graz\151ng\
 9) /Title <FEFF 03BB> /Subject ({"a":\t"(b)\\\\ \0501\51"}) /Trapped /False /Size 3 >>
endobj
trailer << /Info 1 0 R >>
"""
    found = plot.provenance(write(tmp_path / "a", body))
    assert found == {"title": "λ", "software": "grazing 9", "provenance": {"a": "(b)\\ (1)"}}


@pytest.mark.parametrize("kind", KINDS)
def test_figures_of_others(tmp_path, kind):
    Figure((0.5, 0.5)).savefig(tmp_path / f"a.{kind}")
    with pytest.raises(
        InputError, match=r"(was written by|does not say what wrote it).* allowed are figures that graz"
    ):
        plot.provenance(tmp_path / f"a.{kind}")


def test_what_cannot_be_read(tmp_path):
    with pytest.raises(InputError, match=r"there is no file .*none.png"):
        plot.provenance(tmp_path / "none.png")
    with pytest.raises(InputError, match="is no figure; allowed are PNG, PDF and SVG files that grazing wrote"):
        plot.provenance(write(tmp_path / "a.png", b"hello"))
    with pytest.raises(InputError, match="does not say what wrote it and holds no provenance"):
        plot.provenance(write(tmp_path / "a.pdf", b"%PDF-1.7 compressed"))


DAMAGED = {
    "cut png": lambda png, pdf, svg: png[:60],
    "wrong checksum": lambda png, pdf, svg: png.replace(b"{}", b"[]", 1),
    "cut svg": lambda png, pdf, svg: svg[:500],
    "lost object": lambda png, pdf, svg: pdf.replace(b"/Info ", b"/Info 9"),
    "open string": lambda png, pdf, svg: b"%PDF-1.4\n1 0 obj\n<< /Title (abc\ntrailer /Info 1 0 R",
    "open dictionary": lambda png, pdf, svg: b"%PDF-1.4\n1 0 obj\n<< /Title /a\ntrailer /Info 1 0 R ]",
    "no json": lambda png, pdf, svg: pdf.replace(b"({})", b"({)"),
}


@pytest.mark.parametrize("how", DAMAGED)
def test_damage_is_said(tmp_path, how):
    files = [plot.rendered(plot.figure(10, 10), kind) for kind in KINDS]
    with pytest.raises(InputError, match=r"damaged \(.*make the figure again"):
        plot.provenance(write(tmp_path / "a", DAMAGED[how](*files)))
