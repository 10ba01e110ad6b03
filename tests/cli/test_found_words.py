"""What the studies print of what they found: short, no finer than it is known, and the same as data."""

import json
import math

import pytest

from grazing.cli import main
from grazing.cli.found_words import ROWS, share, words_of

GAP = ["--map", "gap", "--lam", "0.5", "--l", "0.1", "-q"]
STUDIES = [
    (["diagram", "mu=0.06:0.08:5", *GAP, "--starts", "9"], "LLR   period 3  100 %   5 of 5  0.06 to 0.08"),
    (["chart", "mu=0.06:0.08:3", "l=0.1:0.12:3", *GAP[:4], "-q"], "LLR   period 3  100 %  100 %"),
    (["basins", "x=-1:1:90", "mu=0.07", *GAP], "LLR   period 3  100 %  -0.241341"),
    (["lyapunov", "mu=0.07", *GAP], "LLR   period 3  100 %   -0.175052"),
    (["lyapunov", "mu=0.06:0.08:5", *GAP], "positive at 0 of 5 values"),
    (["coexistence", "mu=0.04:0.046:3", *GAP, "--starts", "50"], "appears 1, disappears 1"),
    (["density", "mu=0.06:0.08:5", *GAP, "--range=-1:1"], "0 below and 0 above that range"),
    (["trajectory", "u=0.1", "v=0", "--until", "20", "--d", "0.12", "--V", "0.4", "-q"], "3 impacts, certified"),
    (["cobweb", "x=0.1", "mu=0.07", *GAP, "--steps", "9"], "letters: RLLRLLRLL"),
    (["graph", "u=0.01:0.06:60", "v=-0.23", "--omega", "2.1", "-q"], "letters agree at "),
]


@pytest.mark.parametrize(("tokens", "line"), STUDIES, ids=lambda item: item[0] if isinstance(item, list) else "")
def test_every_study_prints_what_it_found_and_says_the_same_as_data(tokens, line, capsys):
    assert main(tokens) == 0
    out = capsys.readouterr().out
    assert line in out
    _title, _empty, *said = out.split("\n\nsizes:")[0].splitlines()
    assert 1 <= len(said) <= 12
    assert main([*tokens, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)["found"]
    assert words_of(tokens[0], found)[:-1] == said


@pytest.mark.parametrize(
    ("part", "whole", "text"),
    [
        (0.5, 10, "50 %"),
        (1.0, 10, "100 %"),
        (0.99999, 40_000, "over 99.99 %"),
        (0.98123, 40_000, "98.12 %"),
        (0.981, 1000, "98.1 %"),
        (0.996, 250, "over 99 %"),
        (1e-6, 10**6, "under 0.01 %"),
        (0.0, 10**6, "0.00 %"),
    ],
)
def test_a_share_is_no_finer_than_one_of_the_whole(part, whole, text):
    assert share(part, whole) == text


def test_many_attractors_are_counted_not_listed():
    row = {
        "word": "L" * 400,
        "period": 400,
        "kind": "period 400",
        "share": 0.01,
        "values": 1,
        "ranges": [[0.1, 0.1]] * 9,
    }
    found = {"parameter": "d", "values": 9, "orbits": 900, "attractors": [row] * 50, "ambiguous": 2, "note": "box"}
    said = words_of("diagram", found)
    assert said[ROWS + 1] == f"and {50 - ROWS} more; --json lists them" and len(said) <= 12
    assert all(len(line) < 120 for line in said) and "2 orbits are ambiguous" in said[-3]


def test_what_is_not_a_number_is_said_without_one():
    row = {"word": "", "period": -2, "kind": "ended", "share": 1.0, "point": [math.nan, math.nan]}
    found = {"states": 9, "coordinates": ["u", "v"], "attractors": [row], "ambiguous": 0}
    assert words_of("basins", found) == ["word         share  point (u, v)", "-     ended  100 %  -", ""]
