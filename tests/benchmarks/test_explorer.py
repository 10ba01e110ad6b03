"""The part of the benchmarks that drives the page: that it can, and what it says where it cannot."""

import json
import re
import sys

import pytest

from benchmarks import explorer
from benchmarks.__main__ import main

#: So little of everything that all rows take seconds; a chart and an oscillator of few cells.
LITTLE = {"COLUMNS": 30, "CELLS": (12, 10), "SIDE": 40, "LOOKS": 5, "PICTURES": 1, "SECONDS": 1.0, "MINUTES": 0.05}


@pytest.mark.parametrize(
    ("parts", "expected"),
    [
        (("sliders", "weight"), ("gap map", "oscillator", "chart", "all in")),
        pytest.param(("frames", "opened", "heaps"), ("table", "4 x", "opened", "6 x", "heap"), marks=pytest.mark.long),
    ],
)
def test_every_row_is_measured(parts, expected, monkeypatch, tmp_path, capsys):
    pytest.importorskip("playwright.sync_api", reason="no playwright: pip install playwright")
    if explorer.chromium() is None:
        pytest.skip("no Chromium found: install one, or name it in GRAZING_CHROMIUM")
    for name, value in LITTLE.items():
        monkeypatch.setattr(explorer, name, value)
    monkeypatch.setattr(explorer, "PARTS", {name: explorer.PARTS[name] for name in parts})
    assert main(["explorer", "--quick", "--json", str(tmp_path / "rows.json")]) == 0
    rows = json.loads((tmp_path / "rows.json").read_text())["explorer"]
    assert [row["missing"] for row in rows] == [""] * len(rows)
    assert all(row["values"] for row in rows)
    held = [row["name"] for row in rows if row["goal"] is not None]
    for each in expected:
        assert any(each in name for name in held), each
    assert len(re.findall(r"\| (?:yes|no) \|", capsys.readouterr().out)) == len(held)


def test_without_a_browser_the_row_says_so(monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(explorer, "chromium", lambda: None)
    assert main(["explorer", "--quick", "--json", str(tmp_path / "rows.json")]) == 0
    assert "explorer (no Chromium found: install one, or name it in GRAZING_CHROMIUM)" in capsys.readouterr().out
    (row,) = json.loads((tmp_path / "rows.json").read_text())["explorer"]
    assert row["missing"].startswith("no Chromium found") and row["values"] == []


def test_without_playwright_the_row_says_so(monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "playwright.sync_api", None)
    assert main(["explorer", "--quick"]) == 0
    assert "explorer (no playwright: pip install 'grazing[test]')" in capsys.readouterr().out
