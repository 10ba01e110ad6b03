"""The part of the benchmarks that drives the page: what it says where it cannot."""

import json
import sys

from benchmarks import explorer
from benchmarks.__main__ import main


def test_without_a_browser_the_row_says_so(monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(explorer, "chromium", lambda: None)
    assert main(["explorer", "--quick", "--json", str(tmp_path / "rows.json")]) == 0
    assert "explorer (no Chromium found: install one, or name it in GRAZING_CHROMIUM)" in capsys.readouterr().out
    (row,) = json.loads((tmp_path / "rows.json").read_text())["explorer"]
    assert row["missing"].startswith("no Chromium found") and row["first"] == row["full"] == []


def test_without_playwright_the_row_says_so(monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "playwright.sync_api", None)
    assert main(["explorer", "--quick"]) == 0
    assert "explorer (no playwright: pip install 'grazing[test]')" in capsys.readouterr().out
