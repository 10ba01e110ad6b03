"""The command: with every peer missing, with bad input, and what it writes."""

import contextlib
import io
import json
import re
import sys
from pathlib import Path

import pytest

from benchmarks.__main__ import main
from benchmarks.gap import vector_bits

PAGE = (Path(__file__).parents[2] / "docs" / "benchmarks.md").read_text(encoding="utf-8")
PEERS = ("heyoka", "diffrax", "CVODE")
NO_PEER = "not installed: pip install 'grazing[bench]'"


@pytest.fixture(scope="module")
def content(tmp_path_factory):
    """Return what one run without peers writes and prints: all tests of it read the same."""
    file, out = tmp_path_factory.mktemp("benchmarks") / "rows.json", io.StringIO()
    only = [token for name in (*PEERS, "square roots") for token in ("--only", name)]
    with pytest.MonkeyPatch.context() as patch, contextlib.redirect_stdout(out):
        for name in ("heyoka", "diffrax", "jax", "sksundae", "sksundae.cvode"):
            patch.setitem(sys.modules, name, None)
        assert main(["--quick", "--rounds", "2", "--json", str(file), *only]) == 0
    return json.loads(file.read_text()), out.getvalue()


def test_a_missing_peer_is_a_row_that_says_so(content):
    found, out = content
    missing = [row for row in found["rows"] if row["missing"]]
    assert {row["missing"] for row in missing} == {NO_PEER}
    for name in PEERS:
        assert any(row["name"].startswith(name) for row in missing)
        assert re.search(rf"^\| \d+ \| {name}.* \({re.escape(NO_PEER)}\) \|", out, re.MULTILINE)
    assert {part["name"] for part in found["shallow"] if part["missing"] == NO_PEER} == {
        "CVODE Adams, 1e-9", "diffrax Tsit5, 1e-9", "heyoka",
    }  # fmt: skip
    assert all(line["missing"] == NO_PEER for line in found["chatter"])


def test_what_is_written_is_documented(content):
    found, _out = content
    (row,) = [row for row in found["rows"] if not row["missing"]]
    assert row["name"] == row["beside"] == "square roots alone"
    assert len(row["seconds"]) == found["rounds"] == 2
    assert row["rate_min"] <= row["rate"] <= row["rate_max"]
    assert row["ratio"] == 1.0
    names = {*found, *row, *found["shallow"][0], *found["chatter"][0]}
    assert {name for name in names if f"`{name}`" not in PAGE} == set()


def test_square_roots_are_taken_in_vectors(content):
    _found, out = content
    assert vector_bits() >= 128
    assert f"{vector_bits()}-bit registers" in out


@pytest.mark.parametrize(
    ("tokens", "message"),
    [
        (["speeds"], "there is no part 'speeds'; choose from speed, shallow, chatter"),
        (["--rounds", "0"], "--rounds is 0; give 1 or more"),
        (["--only", "nobody"], "--only 'nobody' fits no row; there are: grazing, block fast; "),
        (["--json", "/no/such/folder/rows.json"], "give a file in a folder that exists"),
        (["--against", "kernels.py"], "give FILE:FUNCTION"),
    ],
)
def test_bad_input_gets_one_line(tokens, message, capsys):
    assert main(tokens) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    (line,) = printed.err.splitlines()
    assert line.startswith("benchmarks: ")
    assert message in line
