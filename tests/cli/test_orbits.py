"""``grazing orbit``, ``branch``, ``windows``, ``bifurcations``: what they find, print, write, prove and refuse."""

import csv
import json
import os
import tomllib

import numpy as np
import pytest
from pyarrow import parquet

import grazing as gz
from grazing.cli import certificates, main, study
from grazing.config import checked, command_of, load_config, plan_of, recipe_of, result_of, toml_of

BALL = ["--V", "0.4", "-q"]
GAP = ["--map", "gap", "--lam", "0.8", "--l", "1", "-q"]
FEW = ["--starts", "100"]


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "100")
    return tmp_path


@pytest.fixture(autouse=True, scope="module")
def once():
    """Compute a study once that several command lines ask for, who say it, draw it or write it in different ways."""
    known, made_of = {}, study.made_of

    def asked(recipe, *rest):
        key = json.dumps(recipe)
        if ".py:" in key:  # a file of one's own may change
            return made_of(recipe, *rest)
        if key not in known:
            known[key] = made_of(recipe, *rest)
        return known[key]._replace(result=known[key].result.copy(deep=True))

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(study, "made_of", asked)
        yield


def said(capsys, code, *tokens):
    capsys.readouterr()
    assert main(list(tokens)) == code
    out, err = capsys.readouterr()
    assert "Traceback" not in err and "defect" not in err
    return out if code == 0 else out + err


def told(capsys, *tokens, code=0):
    capsys.readouterr()
    assert main([*tokens, "--json"]) == code
    out = capsys.readouterr().out
    assert out.count("\n") == 1
    return json.loads(out)


# ---- orbit


@pytest.mark.parametrize(("alpha", "V", "d"), [("3", "0.4", "0.12"), ("2", "0.3", "0.165")])
def test_orbits_are_those_of_the_closed_form(alpha, V, d, capsys):
    found = told(capsys, "orbit", "--word", "001", "--alpha", alpha, "--V", V, f"d={d}", "-q", *FEW)
    model = gz.pinball(alpha=float(alpha), V=float(V), d=float(d))
    expected = [one for one in gz.one_impact_orbits(model, 3) if one.admissible]
    assert len(found["orbits"]) == len(expected) == 1
    (row,), (orbit,) = found["orbits"], expected
    assert np.allclose(sorted(row["points"]), sorted(orbit.points.tolist()), rtol=0, atol=1e-10)
    assert np.allclose([complex(*pair) for pair in row["multipliers"]], orbit.multipliers, atol=1e-8)
    assert (row["word"], row["impacts"], row["stable"], row["admissible"]) == ("001", 1, orbit.stable, True)
    assert found["coordinates"] == ["u", "v"] and "this is no proof" in found["statement"]


def test_orbits_in_words_and_files(folder, capsys):
    files = ["-o", "a.nc", "-o", "a.csv", "-o", "a.parquet"]
    text = said(capsys, 0, "orbit", "--period", "1:4", "mu=0.5", *GAP, "--virtual", *files)
    lines = text.splitlines()
    assert lines[0] == "periodic orbits of the gap map" and lines[2].split()[:2] == ["word", "period"]
    rows = {line.split()[0]: line.split()[1:5] for line in lines[3:7]}
    assert rows == {
        "L": ["1", "-", "stable", "virtual"], "LR": ["2", "-", "unstable", "admissible"],
        "LLR": ["3", "-", "stable", "admissible"], "LLLR": ["4", "-", "stable", "virtual"],
    }  # fmt: skip
    assert "these are all, because every word of the length is solved by algebra." in text
    table = gz.load("a.nc")
    assert table.word.values.tolist() == ["L", "LR", "LLR", "LLLR"]
    point, image = table.x.values[2, :2]
    assert image == pytest.approx(0.8 * point + 0.5, abs=1e-14)
    assert next(csv.DictReader((folder / "a.csv").read_text().splitlines()))["word"] == "L"
    assert list(dict.fromkeys(parquet.read_table("a.parquet")["word"].to_pylist())) == table.word.values.tolist()
    assert "allowed are nc, csv, parquet, in small letters" in said(capsys, 2, "orbit", "--word", "L", "-o", "a.png")
    command = json.loads(said(capsys, 0, "info", "a.nc", "--json"))["command"]
    assert command == ("grazing orbit --map gap --lam 0.8 --mu 0.5 --l 1.0 --period 1,2,3,4 --virtual -o a.nc")


def test_no_orbit_is_no_error(capsys):
    found = told(capsys, "orbit", "--word", "LLR", "mu=-0.5", *GAP, "-o", "none.nc")
    assert [row["admissible"] for row in found["orbits"]] in ([], [False])
    assert gz.load("none.nc").sizes["orbit"] == len(found["orbits"])


# ---- certificates


def test_what_is_proven_is_saved_and_verified(folder, capsys):
    text = said(capsys, 0, "orbit", "--word", "001", "--d", "0.12", *BALL, *FEW, "--save", "proof.json")
    assert "001, period 3: proven\n  For the oscillator" in text and "written: proof.json" in text
    checked_again = said(capsys, 0, "orbit", "check", "proof.json")
    assert checked_again.startswith("proof.json: verified\nFor the oscillator")
    sentence = checked_again.splitlines()[1]
    assert sentence in text and sentence == gz.check_certificate("proof.json")
    assert told(capsys, "orbit", "check", "proof.json") == {
        "file": "proof.json", "verified": True, "statement": sentence,
    }  # fmt: skip
    info = said(capsys, 0, "info", "proof.json")
    assert "certificate, not checked here" in info and "grazing orbit check proof.json" in info
    document = json.loads((folder / "proof.json").read_text())
    document["data"]["claims"]["trace"][0] = "-1"
    (folder / "forged.json").write_text(json.dumps(document))
    (folder / "text.json").write_text("no JSON")
    assert "forged.json: NOT verified" in said(capsys, 1, "orbit", "check", "forged.json")
    assert "changed after it was sealed" in told(capsys, "orbit", "check", "forged.json", code=1)["reason"]
    assert "not the JSON of a certificate" in said(capsys, 1, "orbit", "check", "text.json")
    assert "there is no file no.json" in said(capsys, 2, "orbit", "check", "no.json")


def test_a_file_that_cannot_be_read_is_wrong_input_and_no_failed_proof(folder, capsys, monkeypatch):
    def refused(*_given):
        raise PermissionError(13, "Permission denied")

    (folder / "theirs.json").write_text("{}")
    monkeypatch.setattr("grazing.paths._at_once", refused)
    assert "theirs.json cannot be read: Permission denied" in said(capsys, 2, "orbit", "check", "theirs.json")


def test_several_certificates_get_names_of_their_own(folder, capsys):
    tokens = ["orbit", "--period", "2:3", "mu=0.5", *GAP, "--virtual"]
    found = told(capsys, *tokens, "--save", "proofs")
    assert found["files"] == ["proofs/LR-period-2.json", "proofs/LLR-period-3.json"]
    proven = {row["of"]: row["proven"] for row in found["proofs"]}
    assert proven == {"LR, period 2": True, "LLR, period 3": True}
    numbered = told(capsys, *tokens, "--save", "a.json")["files"]
    assert numbered == ["a-1.json", "a-2.json"]
    files = [*found["files"], *numbered]
    assert said(capsys, 0, "orbit", "check", *files).count(": verified\nFor lam = 0.8, mu = 0.5") == 4
    (folder / "b.json").write_text("no JSON")
    lines = said(capsys, 1, "orbit", "check", numbered[0], "b.json", numbered[1], "--json").splitlines()
    assert [(json.loads(line)["file"], json.loads(line)["verified"]) for line in lines] == [
        ("a-1.json", True), ("b.json", False), ("a-2.json", True),
    ]  # fmt: skip
    assert "there is no file c.json" in said(capsys, 2, "orbit", "check", numbered[0], "c.json")


def test_what_cannot_be_proven_says_why_and_fails(capsys, monkeypatch):
    def nothing(_orbit):
        raise gz.InputError("the law is not known")

    monkeypatch.setattr("grazing.proof.certify.certify", nothing)
    tokens = ["orbit", "--period", "3:4", "mu=0.5", *GAP, "--virtual", "--certify"]
    text = said(capsys, 1, *tokens)
    assert "LLR, period 3: not proven: the law is not known" in text
    assert "LLLR, period 4: not proven: it is virtual" in text
    said(capsys, 0, "orbit", "--period", "4", "mu=0.5", *GAP, "--virtual", "--certify")  # nothing is due


def test_a_law_of_ones_own_is_proven_and_verified_with_its_file(folder, capsys):
    (folder / "mine.py").write_text(
        "import grazing as gz\n"
        "def soft(v, p):\n    return -p.r * v / (1.0 - p.c * v)\n"
        "ball = gz.Oscillator(3.0, 1.0, gz.Forcing(2.2, offset=0.12), gz.reset(soft, r=0.8, c=0.1))\n"
    )
    said(capsys, 0, "orbit", "--model", "mine.py:ball", "--word", "01", "-q", *FEW, "--save", "own.json")
    # The file holds the law itself; --model holds a law of one's own against it.
    assert "u' = (-p.r)*v/(1.0 - p.c*v)" in said(capsys, 0, "orbit", "check", "own.json")
    assert "verified" in said(capsys, 0, "orbit", "check", "own.json", "--model", "mine.py:ball")
    (folder / "other.py").write_text((folder / "mine.py").read_text().replace("1.0 - p.c", "1.0 + p.c"))
    said(capsys, 1, "orbit", "check", "own.json", "--model", "other.py:ball")


# ---- branch


def test_a_branch_has_the_edges_of_the_window(capsys):
    found = told(capsys, "branch", "d=0.02:0.14", "--word", "001", *BALL, *FEW)
    kept = {row["type"]: row for row in found["special"] if row["admissible"]}
    (window,) = found["windows"]
    edges = gz.windows(gz.pinball(V=0.4), "d", N=3)
    assert window["low"] == pytest.approx(float(edges.low[0]), abs=1e-10)
    assert window["high"] == pytest.approx(float(edges.high[0]), abs=1e-10)
    assert (window["low_type"], window["high_type"]) == ("gr", "pd")
    assert set(kept) == {"gr", "pd", "v0"} and all(row["converged"] for row in kept.values())
    assert all(row["low"] <= row["value"] <= row["high"] for row in kept.values())
    assert "period doubling" in kept["pd"]["meaning"]


def test_virtual_parts_are_listed_on_request(capsys):
    tokens = ["branch", "d=0.1:0.13", "--word", "001", "--at", "0.11", *BALL, *FEW]
    text = said(capsys, 0, *tokens)
    assert "2 more on virtual parts; --virtual lists them" in text and "fold" not in text
    # the fold, and a dip that comes through the wall beside one that is below it
    assert "fold: two orbits meet" in said(capsys, 0, *tokens, "--virtual")


def test_a_branch_of_the_gap_map_is_drawn_stored_and_made_again(folder, capsys):
    tokens = ["branch", "mu=0.01:0.9", "--word", "LLR", *GAP]
    files = ["a.png", "a.svg", "a.nc", "a.csv"]
    text = said(capsys, 0, *tokens, *(token for file in files for token in ("-o", file)))
    # x = lam x + mu (- l after R): the one multiplier of LLR is -1 at its pd, and a point is 0 at its bcb
    assert "bcb" in text and "border collision" in text
    assert all((folder / file).stat().st_size for file in files)
    said(capsys, 0, "plot", "a.nc", "-o", "b.png")
    assert (folder / "a.png").read_bytes() == (folder / "b.png").read_bytes()
    for file in ("a.png", "a.svg", "a.nc"):
        command = json.loads(said(capsys, 0, "info", file, "--json"))["command"]
        assert command == f"grazing branch mu=0.01:0.9 --map gap --lam 0.8 --l 1.0 --word LLR -o {file}"
    recipe = recipe_of(gz.load("a.nc").attrs)
    assert np.array_equal(result_of(recipe).x.values, gz.load("a.nc").x.values, equal_nan=True)


def test_special_points_are_followed_in_two_parameters(folder, capsys):
    tokens = [
        "branch",
        "d=0.08:0.14",
        "--word",
        "001",
        "--at",
        "0.11",
        *BALL,
        *FEW,
        "--step",
        "0.1",
        "--locus",
        "V=0.3:0.5",
    ]
    found = told(capsys, *tokens, "-o", "a.png", "-o", "a.nc")
    assert {row["type"] for row in found["loci"]} == {"gr", "pd", "v0"}
    for row in found["loci"]:
        assert row["V"] == [pytest.approx(0.3), pytest.approx(0.5)] and row["points"] > 5
    low = next(row for row in found["loci"] if row["type"] == "gr")["d"]
    at_ends = [float(gz.windows(gz.pinball(V=V), "d", N=3).low[0]) for V in (0.5, 0.3)]
    assert low == pytest.approx(at_ends, abs=1e-9)
    said(capsys, 0, "plot", "a.nc", "-o", "b.png")
    assert (folder / "a.png").read_bytes() == (folder / "b.png").read_bytes()
    assert "--locus V=0.3:0.5" in said(capsys, 0, "info", "a.png")
    assert "locus" in said(capsys, 0, *tokens) and "no meeting of two of them" in said(capsys, 0, *tokens)


def test_meetings_are_printed(folder, capsys):
    (folder / "mine.py").write_text(
        "import grazing as gz\n"
        "def cubic(s, p):\n    (x,) = s\n    return (x + p.a + p.b * x - x * x * x,)\n"
        "P = gz.Map(cubic, params={'a': 0.0, 'b': 0.5}, coordinates=('x',), box=((-2.0, 2.0),), name='cubic map')\n"
    )
    tokens = ["branch", "a=-0.5:0.5", "--map", "mine.py:P", "--period", "1", "--at", "0.1", "-q", "--step", "0.1", *FEW]
    found = told(capsys, *tokens, "--locus", "b=-0.2:0.8", "-o", "a.png", "-o", "a.nc")
    cusps = [row for row in found["meetings"] if row["type"] == "cusp"]  # folds lie at 27 a^2 = 4 b^3
    assert cusps and all(abs(row["a"]) < 1e-6 and abs(row["b"]) < 1e-4 for row in cusps)
    table = gz.load("a.nc")
    on_fold = (table.locus_type.values == "lp")[table.locus_number.values]
    a, b = table.locus_a.values[on_fold], table.locus_b.values[on_fold]
    assert len(a) > 20 and np.allclose(27.0 * a**2, 4.0 * b**3, atol=1e-9)
    assert "\nmeeting  a" in said(capsys, 0, *tokens, "--locus", "b=-0.2:0.8")
    said(capsys, 0, "plot", "a.nc", "-o", "b.png")
    assert (folder / "a.png").read_bytes() == (folder / "b.png").read_bytes()


# ---- windows


@pytest.mark.parametrize(("name", "V", "N"), [("d", "0.4", "2:4"), ("V", "0.3", "3")])
def test_windows_are_those_of_python(name, V, N, capsys):
    found = told(capsys, "windows", name, "--V" if name == "d" else "--d", V if name == "d" else "0.12", "--N", N, "-q")
    model = gz.pinball(V=0.4) if name == "d" else gz.pinball(d=0.12)
    expected = gz.windows(model, name, N=[2, 3, 4] if N == "2:4" else 3)
    assert [row["low"] for row in found["windows"]] == expected.low.values.tolist()
    assert [row["high_type"] for row in found["windows"]] == expected.high_type.values.tolist()
    assert found["span"] == expected.attrs["span"]


TRIGGERED = ["--law", "triggered", "--trigger", "0.01", "--r", "0.8", "--V", "0.4", "--alpha", "3", "--k", "1",
             "--omega", "2.2", "--cos", "1", "-q"]  # fmt: skip


def test_windows_in_words_with_the_meaning_of_their_edges(capsys):
    text = said(capsys, 0, "windows", "d=0.09:0.13", "--N", "3", *BALL)
    assert "3  0.0984504449371  gr  0.1232814496439  pd\n" in text and "piece of the law" not in text
    pieces = said(capsys, 0, "windows", "d=0.09:0.13", "--N", "3", *TRIGGERED)
    assert "piece of the law" in pieces and "whole" not in pieces  # of a law in pieces the one that acts is named
    assert "gr   graze: a dip of the flight touches the wall" in text and "fold" not in text
    assert "searched: d from 0.09 to 0.13" in text
    none = "no window with N = 1, 2, 3, 4, 5, 6, 7 for d from 0.5 to 0.6; try another range"
    assert none in said(capsys, 0, "windows", "d=0.5:0.6", *BALL)
    rows = told(capsys, "windows", "d", *BALL)["windows"]  # an impact in every period is looked for, too
    assert rows[0]["N"] == 1 and rows[0]["high"] == pytest.approx(-0.00109371288517, abs=1e-12)


def test_edges_are_proven(folder, capsys):
    found = told(capsys, "windows", "d=0.09:0.13", "--N", "3", *BALL, "--save", "edges")
    assert [row["file"] for row in found["proofs"]] == ["edges/N3-low-gr.json", "edges/N3-high-pd.json"]
    for row, side in zip(found["proofs"], ("low", "high"), strict=True):
        low, high = row["enclosure"]
        assert low < found["windows"][0][side] < high and high - low < 1e-12
        said(capsys, 0, "orbit", "check", row["file"])
    text = said(capsys, 0, "windows", "d=0.1:0.13", "--N", "3", *BALL, "--certify")
    assert "N = 3, low edge, end: not proven: a proof needs an edge of type" in text  # and that is no failure


def test_derivatives_of_edges(capsys):
    found = told(capsys, "windows", "d=0.09:0.13", "--N", "3", *BALL, "--sensitivity", "-o", "a.nc", "-o", "a.png")
    expected = gz.sensitivity(gz.pinball(V=0.4), "d", N=3, span=(0.09, 0.13)).derivative
    assert found["windows"][0]["high_derivatives"]["cos1"] == float(
        expected.sel(window=0, edge="high", parameter="cos1")
    )
    text = said(capsys, 0, "windows", "d=0.09:0.13", "--N", "3", *BALL, "--sensitivity")
    assert "derivatives of the edges in d:" in text and "3 high" in text
    assert "grazing windows d=0.09:0.13 --N 3 --sensitivity" in said(capsys, 0, "info", "a.png")
    assert "written: b.png" in said(capsys, 0, "plot", "a.nc", "-o", "b.png")


def test_a_window_of_a_parameter_without_default(capsys):
    paper = "--alpha 3 --k 1 --omega 2.2 --d 0.12 --cos 1 --r 0.8".split()
    tokens = ["windows", "--law", "triggered", "--N", "3", *paper, *BALL]
    assert "trigger: it has no default, so its range is not known" in said(capsys, 2, *tokens, "trigger")
    walls = "--walls A=newton,B=newton --alpha 1 --k 1 --omega 2 --cos 1 B.sigma=0.5 A.r=0.7 B.r=0.8".split()
    assert "A.sigma: it has no default, so its range is not known" in said(capsys, 2, "windows", "A.sigma", *walls)
    assert told(capsys, *tokens, "trigger", "--trigger", "0.2")["span"] == [0.1, 0.4]
    assert told(capsys, *[word for word in tokens if word not in ("--r", "0.8")], "r", "--trigger", "0.2")["span"] == [
        0,
        1,
    ]
    assert told(capsys, *tokens, "trigger=0.01:0.5")["span"] == [0.01, 0.5]


# ---- bifurcations


def test_scan_and_branches_together(folder, capsys):
    tokens = ["bifurcations", "mu=0.3:0.9:7", *GAP, "--starts", "8", "--period", "4"]
    found = told(capsys, *tokens, "-o", "a.png", "-o", "a.nc", "-o", "a.csv")
    expected = gz.bifurcation_diagram(
        gz.gap_map(lam=0.8, mu=0.3, l=1.0), "mu", np.linspace(0.3, 0.9, 7), starts=8, period=4
    )
    assert [row["word"] for row in found["windows"]] == expected.window_word.values.tolist() != []
    assert [row["reason"] for row in found["disagreements"]] == expected.disagreement_reason.values.tolist()
    said(capsys, 0, "plot", "a.nc", "-o", "b.png")
    assert (folder / "a.png").read_bytes() == (folder / "b.png").read_bytes()
    command = json.loads(said(capsys, 0, "info", "a.nc", "--json"))["command"]
    assert command.startswith("grazing bifurcations mu=0.3:0.9:7 --map gap --lam 0.8 --l 1.0 --starts 8 --period 4")
    text = said(capsys, 0, *tokens)
    assert "\nwindow" in text and "unfinished" not in text
    assert "\nunfinished: " in said(capsys, 0, *tokens, "--points", "10")
    assert "limit of 10" in told(capsys, *tokens, "--points", "10")["unfinished"]
    assert ("scan and branches agree\n" if not found["disagreements"] else "\ndisagreement  mu") in text
    gz.save(expected, "python.nc")  # made in Python, it knows its limits too
    again = "grazing bifurcations mu=0.3:0.9:7 --map gap --lam 0.8 --l 1.0 --starts 8 --period 4"
    assert again in said(capsys, 0, "info", "python.nc")


# ---- response


RIG = ("--law", "newton", "--alpha", "3", "--k", "63.2455532", "--d", "0", "--cos=-3.125",
       "--sigma=-0.0012", "--r", "0.7")  # fmt: skip


def test_a_response_says_where_up_and_down_differ_and_the_grazes_and_folds_behind_it(folder, capsys):
    tokens = ["response", "omega=50.3:119.4:23", *RIG, "--starts", "3", "-q"]
    found = told(capsys, *tokens, "-o", "a.png", "-o", "a.nc", "-o", "a.csv")
    forcing, law = gz.Forcing(omega=60.0, cos=(-3.125,)), gz.newton(0.7)
    model = gz.Oscillator(alpha=3.0, k=63.2455532, forcing=forcing, sigma=-0.0012, reset=law)
    expected = gz.response(gz.stroboscopic_map(model), "omega", np.linspace(50.3, 119.4, 23), starts=3)
    assert [row["low"] for row in found["differences"]] == expected.difference_low.values.tolist()
    assert [(row["type"], row["value"]) for row in found["special"]] == list(
        zip(expected.special_type.values.tolist(), expected.special_value.values.tolist(), strict=True)
    )
    up = [row["amplitude"] for row in found["swept"] if row["run"] == "up"]
    assert up == expected.amplitude.sel(run="up").values.tolist()
    most = next(row for row in found["peaks"] if (row["run"], row["reading"]) == ("up", "amplitude"))
    assert (most["greatest"], most["omega"]) == (max(up), expected.omega.values[int(np.argmax(up))])
    said(capsys, 0, "plot", "a.nc", "-o", "b.png")
    assert (folder / "a.png").read_bytes() == (folder / "b.png").read_bytes()
    said(capsys, 0, "plot", "a.nc", "-o", "c.png", "--style", "by=impact_speed")
    assert (folder / "a.png").read_bytes() != (folder / "c.png").read_bytes()
    text = said(capsys, 0, *tokens)
    assert "up and down differ at omega = 84.85 to 103.695 (7 values)\n" in text
    assert "\nup    0.0023447 at omega = 103.695   " in text and "\ndown  " in text
    assert "\ngr             81.1957472" in text and "\nlp             104.18131165" in text
    gz.save(expected, "python.nc")
    again = [json.loads(said(capsys, 0, "info", file, "--json"))["command"] for file in ("a.nc", "python.nc")]
    assert again[0].startswith("grazing response omega=50.3:119.4:23 --law newton") and " --starts 3 " in again[0]
    assert again[1].split(" -o ")[0] == again[0].split(" -o ")[0]


def test_a_response_without_hysteresis_says_so(capsys):
    text = said(capsys, 0, "response", "omega=110:119:3", *RIG, "--starts", "2", "-q")
    assert "up and down agree at every value\n" in text and "no special point" in text


# ---- configurations


@pytest.mark.parametrize(
    "config",
    [
        {"study": "orbit", "settings": {"period": "1:3", "virtual": True}},
        {"study": "branch", "vary": {"d": [0.02, 0.14]}, "settings": {"word": "001", "locus": {"V": [0.2, 0.6]}}},
        {"study": "branch", "vary": {"V": "0:1"}, "settings": {"period": 2, "at": [0.2, 0.4], "step": 0.1}},
        {"study": "windows", "vary": {"d": "default"}, "settings": {"N": [2, 5], "sensitivity": True}},
        {"study": "bifurcations", "vary": {"d": "0.05:0.16:9"}, "settings": {"starts": 7, "period": 4}},
        {"study": "response", "vary": {"omega": "2:3:9"}, "settings": {"starts": 7, "period": 2}},
    ],
    ids=lambda config: config["study"],
)
def test_files_commands_and_recipes_say_the_same(config, folder, capsys):
    recipe = checked(config)
    (folder / "a.toml").write_text(toml_of(recipe))
    assert load_config("a.toml") == recipe == checked(recipe)
    for tokens in ([recipe["study"], "--config", "a.toml"], command_of(recipe).split()[1:]):
        assert checked(tomllib.loads(said(capsys, 0, *tokens, "--dump-config"))) == recipe
    with pytest.raises(gz.InputError, match="is computed as a whole and has no cells to sweep"):
        plan_of(recipe)


def test_options_take_back_what_a_file_says(folder, capsys):
    (folder / "a.toml").write_text('study = "orbit"\n[settings]\nperiod = 2\nvirtual = true\n')
    found = tomllib.loads(said(capsys, 0, "orbit", "--config", "a.toml", "--no-virtual", "--V", "0.1", "--dump-config"))
    assert found["settings"]["virtual"] is False and found["parameters"]["V"] == 0.1


# ---- what is refused


@pytest.mark.parametrize(
    ("tokens", "text"),
    [
        (["orbit"], "--period: missing; give least periods, such as 3 or 1:6, or a word, such as 001"),
        (["orbit", "--period", "0"], "--period = 0; allowed is a whole number >= 1"),
        (["orbit", "--word", "0a1"], "allowed are 0 to 9"),
        (["orbit", "--word", "009"], "one period holds at most"),
        (["orbit", "--period", "3", "--word", "01"], "allowed are its multiples"),
        (["orbit", "--word", "001", "-o", "a.png"], "allowed are nc, csv"),
        (["orbit", "--word", "001", "d=0.1:0.2:3"], "an orbit varies nothing; give single values"),
        (["orbit", "chekc"], "'chekc' is not NAME=VALUE"),
        (["orbit", "o.toml"], "is not NAME=VALUE, such as d=0.12; a file is given with --config o.toml"),
        (["orbit", "--word", "001", "--save", "a.txt"], "give a file that ends in .json, or a folder"),
        (["orbit", "--word", "001", "--save", "no/a"], "there is no folder no; make it first"),
        (["orbit", "--word", "001", "--save", "no/a.json"], "there is no folder no; make it first"),
        (["branch", "d=0.02:0.14:100", "--word", "001"], "give low:high, without a count"),
        (["branch", "d=0.14:0.02", "--word", "001"], "the lower end must come first"),
        (["branch", "d", "--word", "001"], "'d' is not NAME=LOW:HIGH or NAME=VALUE"),
        (["branch", "--word", "001"], "nothing varies; branch varies 1 parameter of alpha"),
        (["branch", "q=0:1", "--word", "001"], "q: unknown parameter; allowed are alpha"),
        (["branch", "r=0.5:1.5", "--word", "001"], "r = 1.5; allowed is 0 <= r <= 1"),
        (["branch", "d=0.1:0.2", "--word", "001", "--d", "0.1"], "d varies here"),
        (["branch", "d=0.1:0.2", "--word", "001", "--at", "0.3"], "--at = 0.3; allowed is 0.1 <= d <= 0.2"),
        (["branch", "d=0.1:0.2", "--word", "001", "--locus", "V"], "give one parameter and its range, NAME=LOW:HIGH"),
        (["branch", "d=0.1:0.2", "--word", "001", "--locus", "d=0:1"], "d is the parameter of the branch"),
        (["branch", "d=0.1:0.2", "--word", "001", "--locus", "q=0:1"], "unknown parameter 'q'"),
        (["branch", "d=0.1:0.2", "--word", "001", "--locus", "V=0.6:0.8"], "it must hold V = 0.4"),
        (["branch", "d=0.02:0.03", "--word", "001", *FEW, "-q"], "no orbit of word 001 was found at d = 0.021"),
        (["branch", "d=0.1:0.2", "--word", "001", "-o", "a.zarr"], "allowed are png, pdf, svg, nc, csv"),
        (["windows"], "nothing varies; windows varies 1 parameter"),
        (["windows", "q"], "q: unknown parameter"),
        (["windows", "d", "--N", "0"], "--N = 0; allowed is a whole number >= 1"),
        (["windows", "d", "--map", "gap"], "nknown option"),
        (["bifurcations", "d=0.1:0.2"], "give start:stop:count"),
        (["bifurcations"], "nothing varies; bifurcations varies 1 parameter"),
        (["response", "omega=2:3"], "give start:stop:count"),
        (["response", "mu=0:1:5", *GAP], "a response is that of an oscillator"),
    ],
)  # fmt: skip
def test_bad_input_gets_one_message(tokens, text, capsys):
    message = said(capsys, 2, *tokens)
    assert text in message and message.count("error: ") == 1


def test_nothing_is_searched_before_the_files_are_checked(monkeypatch, capsys):
    def never(*_arguments, **_more):
        raise AssertionError("it was searched")

    monkeypatch.setattr("grazing.cli.study.made_of", never)
    said(capsys, 2, "orbit", "--word", "001", "-o", "no/a.nc")
    said(capsys, 2, "orbit", "--word", "001", "--save", "no/a.json")
    monkeypatch.setattr(os, "access", lambda *_given, **_more: False)
    text = said(capsys, 2, "orbit", "--word", "001", "--save", "new")
    assert "--save new cannot be written: permission denied; choose another folder" in text


def test_a_folder_that_cannot_be_made_is_named(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(gz.InputError, match=r"file/new cannot be made: Not a directory; choose another one"):
        certificates.made(tmp_path / "file" / "new")
