"""``--certify`` between walls: orbits and edges of windows are proven by the same calls as over one wall."""

import json

import pytest

from grazing.cli import main

RATTLE = ["--walls", "A=newton,B=newton", "A.sigma=-0.5", "A.r=0.8", "B.sigma=0.5"]
RATTLE += ["--alpha", "0.1", "--k", "0.5", "--omega", "2", "--cos", "2", "-q"]


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def told(capsys, *tokens):
    capsys.readouterr()
    main([*tokens, "--json"])
    return json.loads(capsys.readouterr().out)


def verified(capsys, file):
    assert main(["orbit", "check", file]) == 0
    return "verified" in capsys.readouterr().out


def test_orbits_between_walls_are_proven(capsys):
    found = told(capsys, "orbit", "--word", "(AB)", *RATTLE, "B.r=0.6", "--starts", "20", "--save", "proofs")
    ((row,), (orbit,)) = found["proofs"], found["orbits"]
    assert row["proven"] and 'meets the walls "A", "B", in this order' in row["statement"] and not orbit["stable"]
    assert "unstable" in row["statement"] and row["file"].endswith("(AB)-period-1.json")
    assert verified(capsys, row["file"])


def test_edges_of_windows_between_walls_are_proven(capsys):
    words = ["--N", "1", "--words", "ABB", "--samples", "2"]
    found = told(capsys, "windows", "B.r=0.6:0.95", *RATTLE, *words, "--save", "proofs")
    (window,), rows = found["windows"], found["proofs"]
    (proof,) = (row for row in rows if row["side"] == "high")
    assert proof["proven"] and proof["of"] == "N = 1 ABB, high edge, lp"
    assert proof["file"].endswith("N1-ABB-high-lp.json")
    low, high = proof["enclosure"]
    assert low - 1e-11 < window["high"] < high + 1e-11 and verified(capsys, proof["file"])


def test_the_place_of_certificates_is_called_by_its_option(capsys):
    """It was said of -o, which was not given."""
    orbit = ["orbit", "--period", "2", "--map", "gap", "--lam", "0.8", "--mu", "0.5", "--l", "1", "--certify"]
    assert main([*orbit, "--save", "none/a.json"]) == 2
    assert capsys.readouterr().err == "error: --save none/a.json: there is no folder none; make it first\n"
