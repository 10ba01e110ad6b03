"""What the studies print of what they found: short, no finer than it is known, and the same as data."""

import json
import math

import pytest

from grazing.catalogue import studies
from grazing.catalogue.words import ROWS, share, words_of
from grazing.cli import main

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
    assert words_of(studies()[tokens[0]], found)[:-1] == said


RIG = ["--si", "m=0.8,c=2.4,k=3200,force=2.5,gap=1.2 mm,frequency=14", "--r", "0.7", "-q", "--units"]


@pytest.mark.parametrize(
    ("tokens", "said"),
    [
        (["history", "u=0", "v=0", "--until", "0.5", *RIG, "ms,mm"],
         ["impact at t (ms)  v before (m/s)  v after (m/s)", "m/s\nu -1.2 to ", " mm at the instants"]),
        (["sample", "u=0", "v=0", "--until", "0.5", "--rate", "200", *RIG, "mm"],
         ["101 samples, 200 per s, t from 0 to 0.5 s", " mm at the instants"]),
        (["spectrum", "u=0", "v=0", "--until", "2", *RIG, "mm,Hz"],
         ["frequency (Hz)  order ", "amplitude (mm)", "in steps of 0.5 Hz"]),
        (["basins", "u=-0.0012:0.009:5", "v=-0.4:0.4:5", *RIG, "mm"], ["point (u mm, v m/s)", "-0.14006, -0.17316"]),
        (["lyapunov", *RIG, "ms"], ["per time (1/s)", "time of a step (ms)", "71.4286"]),
        (["density", "frequency=13:14:3", "--bins", "5", "--starts", "3", *RIG, "mm"], [" mm\n0 below"]),
        (["orbit", "--word", "1", "--starts", "200", *RIG, "mm"],
         ["first point (u mm, v m/s)", "-0.140059991, -0.173159905", "units:   mm (u), m/s (v)"]),
    ],
    ids=lambda item: item[0] if len(item) > 4 else "",
)  # fmt: skip
def test_what_is_printed_of_a_rig_has_its_units(tokens, said, capsys):
    assert main(tokens) == 0
    out = capsys.readouterr().out
    for part in said:
        assert part in out, out


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
    said = words_of(studies()["diagram"], found)
    assert said[ROWS + 1] == f"and {50 - ROWS} more; --json lists them" and len(said) <= 12
    assert all(len(line) < 120 for line in said) and "2 orbits are ambiguous" in said[-3]


def test_what_is_not_a_number_is_said_without_one():
    row = {"word": "", "period": -2, "kind": "ended", "share": 1.0, "point": [math.nan, math.nan]}
    found = {"states": 9, "coordinates": ["u", "v"], "attractors": [row], "ambiguous": 0}
    assert words_of(studies()["basins"], found) == ["word         share  point (u, v)", "-     ended  100 %  -", ""]
    row |= {
        "exponent": [[math.nan, math.nan]],
        "exponent_per_time": [[math.nan, math.nan]],
        "return_time": [math.nan] * 2,
    }
    head, line, *_rest = words_of(studies()["lyapunov"], {"attractors": [row], "starts": 9})
    assert "time of a step" in head and line.split() == ["-", "ended", "100", "%", "-", "-", "-"]
