"""The commands of the studies: options made from the schema, files by their endings, what is printed."""

import csv
import json
import shlex
import tomllib

import numpy as np
import pytest
import xarray as xr

import grazing as gz
from grazing.catalogue import studies
from grazing.cli import main
from grazing.cli.study import underway
from grazing.config import load_config
from grazing.config.parameters import GAP_MAP, parameter_names
from grazing.config.settings import settings_of
from grazing.oscillator.parameters import describe_parameter

GAP = ["--map", "gap", "--lam", "0.5", "--l", "0.1"]
SMALL = ["mu=0:0.1:5", *GAP, "--starts", "3", "--keep", "8"]


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "100")
    return tmp_path


def refused(capsys, *tokens):
    assert main(list(tokens)) == 2
    out, err = capsys.readouterr()
    assert not out and err.startswith("error: ") and "Traceback" not in err
    return err


@pytest.mark.parametrize("option", ["--table=", "--model="])
@pytest.mark.parametrize("given", ["trajectory u=0 v=0", "launches angle=1:2:3", "diagram d=0:1:3"])
def test_an_option_without_a_name_is_refused(option, given, capsys):
    """An empty table ended in a TypeError, and for an empty model the paper's pinball was computed."""
    assert "'' names nothing" in refused(capsys, *given.split(), option)


# ---- help


@pytest.mark.parametrize("study", studies())
def test_help_shows_every_parameter_with_its_meaning_range_and_default(study, capsys):
    assert main([study, "--help"]) == 0
    out = capsys.readouterr().out
    words = " ".join(out.replace("│", " ").split())
    unknown = ("phase", *GAP_MAP) if studies()[study].of == "model" else ()  # it has no map
    for name in (*parameter_names(), *settings_of(study).model_fields):
        if name in unknown:
            assert f"--{name} " not in out
            continue
        assert f"--{name.replace('_', '-')} " in out
    for name in ("alpha", "k", "omega", "r", "V", "trigger"):
        known = describe_parameter(name)
        limits = "" if known.low == -known.high else f"; {known.allowed}"  # nothing is said of any finite number
        assert f"{known.meaning}{limits}" in words
    assert f"Example: grazing {study} " in words
    for said in ("[default: 2.2]", "--out", "--config FILE", "--json", "Exit codes", "--V NUMBER", "NAME=..."):
        assert said in words
    for switch in ("virtual", "sensitivity"):  # a file can say these, so the command line can take them back
        out = out.replace(f"--no-{switch}", "")
    assert "--v " not in out and "--no-" not in out and "--given" not in out


def test_names_keep_their_case(capsys):
    assert "Unknown option: --v. Did you mean --V?" in refused(capsys, "diagram", "d=0.1:0.2:3", "--v", "0.4")


# ---- a run


def test_the_result_is_that_of_the_python_call(capsys):
    assert main(["diagram", *SMALL, "-o", "out.nc", "--seed", "3", "-q"]) == 0
    P = gz.gap_map(lam=0.5, mu=0.0, l=0.1)
    expected = gz.orbit_diagram(P, "mu", np.linspace(0.0, 0.1, 5), starts=3, keep=8, seed=3)
    found = gz.load("out.nc")
    assert json.loads(found.attrs.pop("grazing_recipe"))["study"] == "diagram"
    xr.testing.assert_identical(found, expected)


def test_endings_choose_formats(folder, capsys):
    files = ["a.png", "a.pdf", "a.svg", "a.nc", "a.csv", "a.zarr"]
    assert main(["diagram", *SMALL, "--json", *(token for file in files for token in ("-o", file))]) == 0
    out, _err = capsys.readouterr()
    summary = json.loads(out)
    assert sorted(summary["files"]) == sorted(files)
    starts = {"a.png": b"\x89PNG", "a.pdf": b"%PDF", "a.svg": b"<?xml", "a.nc": b"CDF", "a.csv": b"mu,start,n,x"}
    for file, head in starts.items():
        assert (folder / file).read_bytes().startswith(head)
    from grazing.sweep import open_store, status

    assert status("a.zarr").complete
    one, other = gz.load("a.nc"), open_store("a.zarr")
    xr.testing.assert_identical(one, other)


def test_json_is_one_object_with_progress_elsewhere(capsys):
    assert main(["diagram", *SMALL, "--json"]) == 0
    out, err = capsys.readouterr()
    assert out.count("\n") == 1
    summary = json.loads(out)
    assert summary["sizes"] == {"mu": 5, "start": 3, "n": 8}
    assert summary["files"] == [] and summary["seconds"] >= 0.0 and len(summary["config_sha256"]) == 64
    assert summary["command"] == "grazing diagram mu=0:0.1:5 --map gap --lam 0.5 --l 0.1 --starts 3 --keep 8"
    assert "[5/5]" in err


def test_words(capsys):
    assert main(["diagram", *SMALL, "-q"]) == 0
    out, err = capsys.readouterr()
    assert not err
    head, found, rest = out.split("\n\n")
    assert head == "orbit diagram of the gap map in mu" and found.startswith("word ")
    assert rest.startswith("sizes:   mu 5, start 3, n 8\ntime:    ")
    assert "written: nothing; -o diagram.png" in out


@pytest.mark.parametrize(
    ("tokens", "sizes"),
    [
        (["density", "mu=0:0.1:5", *GAP, "--bins", "20", "--range=-1:1"], {"mu": 5, "x": 20}),
        (["chart", "mu=0:0.1:4", "l=0:0.2:3", "--map", "gap", "--lam", "0.5"], {"mu": 4, "l": 3, "rank": 8}),
        (["lyapunov", "mu=0.02:0.1:4", *GAP, "--steps", "50"], {"mu": 4, "start": 10, "index": 1}),
        (["basins", "x=-1:1:9", *GAP, "mu=0.05"], {"x": 9}),
        (["coexistence", "mu=0.02:0.1:4", *GAP, "--starts", "9"], {"mu": 4}),
        (["cobweb", "x=0.1", "mu=0.05", *GAP, "--steps", "7"], {"n": 8, "step": 7, "place": 1202}),
        (["trajectory", "u=0.1", "v=0", "--until", "5"], {}),
        (["graph", "u=0.01:0.06:7", "v=-0.2", "--order", "full", "--coordinate", "v"], {"map": 2, "u": 7}),
    ],
    ids=lambda value: value[0] if isinstance(value, list) else "",
)
def test_every_study_runs_and_is_drawn(tokens, sizes, folder, capsys):
    assert main([*tokens, "--json", "-q", "-o", "a.png", "-o", "a.nc", "-o", "a.csv"]) == 0
    summary = json.loads(capsys.readouterr().out)
    assert sizes.items() <= summary["sizes"].items()
    assert (folder / "a.png").read_bytes().startswith(b"\x89PNG")
    assert main(["plot", "a.nc", "-o", "b.png"]) == 0
    assert (folder / "a.png").read_bytes() == (folder / "b.png").read_bytes()
    capsys.readouterr()
    assert main(["info", "a.nc", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["recipe"] == json.loads(_info(capsys, "a.png"))["recipe"]


def _info(capsys, file):
    assert main(["info", file, "--json"]) == 0
    return capsys.readouterr().out


# ---- files and options together


def test_a_file_gives_defaults_and_options_override(folder, capsys):
    (folder / "study.toml").write_text(
        'study = "diagram"\nmap = "gap"\n[parameters]\nlam = 0.5\nl = 0.1\n[vary]\nmu = "0:0.1:5"\n'
        "[settings]\nstarts = 3\nkeep = 8\n"
    )
    assert main(["diagram", "--config", "study.toml", "--dump-config"]) == 0
    found = tomllib.loads(capsys.readouterr().out)
    assert found["vary"] == {"mu": "0:0.1:5"} and found["settings"]["keep"] == 8
    tokens = ["diagram", "--config", "study.toml", "l=0:0.1:3", "--mu", "0.02", "--keep", "4", "--dump-config"]
    assert main(tokens) == 0
    text = capsys.readouterr().out
    found = tomllib.loads(text)
    assert found["vary"] == {"l": "0:0.1:3"} and found["settings"]["keep"] == 4 and found["parameters"]["mu"] == 0.02
    (folder / "again.toml").write_text(text)
    assert load_config(folder / "again.toml") == found


def test_errors_name_options_and_keys_of_the_file(folder, capsys):
    (folder / "study.toml").write_text('study = "diagram"\n[parameters]\nr = 2\n[vary]\nd = "0:1:5"\n')
    err = refused(capsys, "diagram", "--config", "study.toml", "--k", "-1", "--keep", "x")
    assert err.splitlines() == [
        "error: there are 3 errors:",
        "  --k = -1; allowed is k >= 0, finite (natural frequency; the stiffness is k^2)",
        "  study.toml: parameters.r = 2; allowed is 0 <= r <= 1 (coefficient of restitution)",
        "  --keep = 'x'; allowed is a whole number >= 1",
    ]
    assert "study.toml: study = 'diagram'; this is the command for 'chart'" in refused(
        capsys, "chart", "--config", "study.toml"
    )
    assert "--d: d varies in study.toml" in refused(
        capsys, "diagram", "--config", "study.toml", "--r", "0.5", "--d", "0.1"
    )


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("diagram", "nothing varies; diagram varies 1 parameter of alpha"),
        ("diagram d=0:1:5 --omega 1e-200", "error: omega = 1e-200; allowed is 1e-60 <= omega"),
        ("diagram d", "'d' is not NAME=START:STOP:COUNT or NAME=VALUE"),
        ("diagram d=0:1", "d = '0:1'; give start:stop:count"),
        ("diagram b=0:1:5", "b: unknown parameter; allowed are alpha"),
        ("diagram d=0.1:0.2:5 d=0.1", "'d=0.1': d is given twice"),
        ("diagram d=0.1:0.2:5 --d 0.1", "--d: d varies here; give it a range there"),
        ("chart d=0.1:0.2:5 d=0.1:0.3:5", "'d=0.1:0.3:5': d is given twice"),
        ("trajectory u=1 u=0 v=0", "'u=0': u is given twice"),
        ("trajectory u=0 v=0 --state 0.1,0", "the initial state is given twice: by --state, and by u, v"),
        ("basins u=0 u=1", "'u=1': u is given twice"),
        ("diagram d=0.1:0.2:5 V=0:1:2", "2 vary; diagram varies 1 parameter"),
        ("diagram d=0.1:0.2:5 W=1", "W: unknown parameter; allowed are alpha"),
        ("diagram d=0.1:0.2:5 --map gap", "--lam: missing; give slope"),
        ("diagram d=0.1:0.2:5 --threads 0", "--threads = 0; allowed is a whole number >= 1"),
        (
            "diagram d=0.1:0.2:5 -o a.txt",
            "-o a.txt: the ending chooses the format; allowed are png, pdf, svg, nc, csv, parquet, zarr",
        ),
        ("diagram d=0.1:0.2:5 -o no/a.png", "there is no folder no; make it first"),
        (f"diagram d=0.1:0.2:5 -o {'n' * 256}.png", "the name is too long for a file; give a shorter name"),
        ("diagram d=0.1:0.2:5 -o .png", "the ending chooses the format"),
        ("diagram d=0.1:0.2:5 -o a.zarr -o b.zarr", "one store at a time"),
        ("diagram --config no.toml", "there is no file no.toml"),
        ("lyapunov d=0.1 -o a.png", "there is no figure of exponents at one value"),
        ("chart d=0.1:0.2:5", "1 vary; chart varies 2 parameters"),
        ("trajectory", "--state: missing; give initial state"),
        ("trajectory u=0.1", "the initial state lacks v; give u, v"),
        ("trajectory u=0.1 v=abc", "error: v = 'abc' is not a real number"),
        ("trajectory u=1e999 v=0", "error: u = inf is not finite"),
        ("trajectory u=0.1 v=0 --phase 0.5", "Unknown option"),
        ("diagram d=0:1:3 --offset 0.5", "A parameter that has no option is given as offset=VALUE."),
        ("diagram d=0:1:3 --bins 4", "Unknown option: --bins. 'grazing diagram --help'"),
        ("trajectory u=0.1 v=0 phase=0.5", "a trajectory has no section; leave it out"),
        ("trajectory u=0.1 v=0 --map impact", "Unknown option"),
        ("trajectory u=0.1 v=0 -o a.zarr", "allowed are png, pdf, svg, nc, csv"),
        ("trajectory u=-0.1 v=0", "the ball starts inside the wall"),
        ("cobweb x=0.1", "the stroboscopic map has coordinates u, v; a cobweb needs a map with one, such as gap"),
        ("basins x=0:1:5", "x: unknown coordinate; allowed are u, v"),
        ("graph", "nothing varies; graph varies 1 coordinate of u, v, such as u=0.1:0.2:100"),
        ("graph u=0:0.1:5 v=0:1:5", "2 vary; graph varies 1 coordinate of u, v"),
        ("graph d=0.1:0.2:5", "d: unknown coordinate; allowed are u, v"),
        ("graph u=0:0.1:5 --fixed w=1", "w: unknown coordinate; allowed are u, v"),
        ("graph u=0:0.1:5 --fixed u=1", "fixed has 'u'; allowed are v"),
        ("graph u=0:0.1:5 --coordinate w", "--coordinate = 'w'; allowed are u, v"),
        ("graph u=0:0.1:5 --order second", "--order = 'second'; allowed are 'lowest', 'full', 'corrected', 'none'"),
        ("diagram d=0.1:0.2:5 --order none", "--order = 'none'; allowed are 'lowest', 'full', 'corrected'"),
        ("graph u=0:0.1:5 --map discontinuity --order none", "leaves out the map beside the stroboscopic map"),
        ("graph u=0:0.1:5 --map impact --order full", "the discontinuity map has one, the impact map has not"),
        ("graph u=-0.1:0.1:5", "the ball starts inside the wall: u = -0.1"),
        ("graph u=0:0.1:5 -o a.zarr", "allowed are png, pdf, svg, nc, csv"),
        ("diagram d=0.05-0.16", "error: d = '0.05-0.16'; give start:stop:count, such as 0.05:0.16:100"),
        ("diagram d=file.py:name", "error: d = 'file.py:name'; give start:stop:count (evenly spaced), start"),
        ("diagram d=0.05:0.16", "error: d = '0.05:0.16'; give start:stop:count, such as 0.05:0.16:100 for 100 values"),
        ("branch d=0.05..0.16 --word 001", "error: d = '0.05..0.16'; give low:high, here 0.05:0.16"),
        (
            "response force=1:2:9",
            "force: unknown parameter; here that is cos1 = force/m, with its sign; it has its own",
        ),
        (
            "diagram d=0.1:0.2:5 load=1",
            "load: unknown parameter; here that is d = load/m, with its sign; it has its own",
        ),
        ("diagram d=0.1:0.2:5 --gap 3", "--gap. Here that is sigma = -gap; a rig with a gap is given by --si"),
        ("history u=0 v=0 --frequency 3", "Here that is omega = 2 pi frequency, in SI units also '14 Hz'; a rig with"),
        ("diagram x=0.1:0.2:5 --map gap --force 3", "Here that is cos1"),
    ],
)
def test_each_error_says_what_to_do(line, said, capsys):
    assert said in refused(capsys, *shlex.split(line))


@pytest.mark.parametrize(
    ("option", "near"), [("--N", ""), ("--x", ""), ("--verbose", ""), ("--D", "--d"), ("--ou", "--out")]
)
def test_an_option_is_like_another_without_its_dashes(option, near, capsys):
    """The dashes, equal in all, made --r the one that --N was most like."""
    said = refused(capsys, "diagram", "d=0.1:0.2:3", option, "3")
    meant = f"Did you mean {near}?" if near else f"A parameter that has no option is given as {option[2:]}=VALUE."
    assert said.startswith(f"error: Unknown option: {option}. {'' if option == '--N' else f'{meant} '}'grazing")


@pytest.mark.parametrize(
    "line",
    ["d=0.1:0.2:3 --co\u0455=1", "\u0455=0.1:0.2:3", "d=0.1:0.2:3 --\u0455=1", "--map=gap \u0455=0:1:3 lam=0.5 l=0.1"],
)
def test_a_letter_that_looks_like_another_is_named(line, capsys):
    """``--coѕ`` was answered with: did you mean ``--cos``?"""
    assert "(its 'ѕ' is U+0455, CYRILLIC SMALL LETTER DZE)" in refused(capsys, "diagram", *shlex.split(line))


def test_a_stiffness_that_is_no_number_is_not_unknown(capsys):
    said = refused(
        capsys, *shlex.split("diagram d=0.1:0.2:3 --alpha 1 --omega 1 --cos 1 --r 0.5 --V 0.1 --stiffness nan")
    )
    assert said == "error: --stiffness = nan is not finite; allowed is any finite stiffness\n"


@pytest.mark.parametrize("further", [(), ("--config", "a.toml")])
def test_what_was_not_understood_may_be_what_varies(further, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.toml").write_text("parameters.r = 0.5\n")
    said = refused(capsys, "diagram", "a.toml", *further)
    assert len(said.splitlines()) == 1 and said.startswith("error: 'a.toml' is not NAME=START:STOP:COUNT")


def test_errors_of_the_line_and_of_the_configuration_stand_one_a_line(capsys):
    said = refused(capsys, "diagram", "d", "d=0.1:0.2:3", "--r", "1.2", "--strats=3").splitlines()
    assert "Unknown option" in said[0]
    said = refused(capsys, "diagram", "d", "d=0.1:0.2:3", "--r", "1.2", "--starts", "0").splitlines()
    assert said[0] == "error: there are 3 errors:" and len(said) == 4
    assert all(line.startswith("  ") for line in said[1:])


def test_the_help_of_a_trajectory_names_what_it_has(capsys):
    assert main(["trajectory", "--help"]) == 0
    shown = capsys.readouterr().out
    assert "--until" in shown and "--model" in shown and "--law" in shown and "--omega" in shown
    assert not any(f"{name} " in shown for name in ("--map", "--unfold", "--order", "--phase", "--lam", "--mu", "--l"))


def test_nothing_is_computed_before_the_files_are_checked(monkeypatch, capsys):
    def never(*_arguments, **_more):
        raise AssertionError("it was computed")

    monkeypatch.setattr("grazing.cli.study.made_of", never)
    refused(capsys, "diagram", *SMALL, "-o", "no/a.png")


def test_a_dry_run_computes_nothing_and_says_what_it_takes(folder, capsys):
    assert main(["diagram", *SMALL, "--dry-run", "-o", "a.nc"]) == 0
    assert "5 cells" in capsys.readouterr().out
    assert main(["diagram", *SMALL, "--dry-run", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["cells"] == 5
    assert main(["diagram", *SMALL, "--dry-run", "--sweep", "up"]) == 0
    assert "5 cells, each after its neighbour" in capsys.readouterr().out
    assert list(folder.iterdir()) == []


def test_a_sweep_along_a_parameter_is_refused_as_a_store(capsys):
    assert "cannot be swept in chunks" in refused(capsys, "diagram", *SMALL, "--sweep", "up", "-o", "a.zarr")


def test_a_graph_is_that_of_python_and_one_table(folder, capsys):
    assert (
        main(["graph", "u=0.01:0.06:7", "v=-0.23", "--phase", "0.1", "--omega", "2.1", "-o", "a.nc", "-o", "a.csv"])
        == 0
    )
    assert "sizes:   map 2, u 7" in capsys.readouterr().out
    P = gz.stroboscopic_map(gz.pinball(omega=2.1), phase=0.1)
    want = gz.graph(P, "u", np.linspace(0.01, 0.06, 7), fixed={"v": -0.23})
    found = gz.load("a.nc")
    assert found.attrs.pop("grazing_recipe")
    xr.testing.assert_identical(found, want)
    with open("a.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [float(row["image_v_stroboscopic map"]) for row in rows] == want["image_v"].values[0].tolist()


def test_the_coordinate_of_a_graph_is_drawn_and_told(folder, capsys):
    line = ["graph", "u=0.01:0.06:7", "v=-0.23", "-q", "-o"]
    for name, more in (("u", []), ("v", ["--coordinate", "v"])):
        assert main([*line, f"{name}.nc", "-o", f"{name}.png", *more]) == 0
    assert (folder / "u.png").read_bytes() != (folder / "v.png").read_bytes()
    assert gz.load("u.nc").attrs["grazing_config_sha256"] == gz.load("v.nc").attrs["grazing_config_sha256"]
    assert "--coordinate v " in _info(capsys, "v.png") and "--coordinate" not in _info(capsys, "u.png")
    assert main(["plot", "v.nc", "-o", "v2.png"]) == 0
    assert main(["plot", "u.nc", "-o", "v3.png", "--style", "coordinate=v"]) == 0
    assert (folder / "v.png").read_bytes() == (folder / "v2.png").read_bytes() == (folder / "v3.png").read_bytes()
    assert "allowed are u, v" in refused_after(capsys, "plot", "u.nc", "-o", "w.png", "--style", "coordinate=w")
    assert "u.nc is no chart" in refused_after(capsys, "plot", "u.nc", "-o", "w.png", "--curves", "2")


def refused_after(capsys, *tokens):
    capsys.readouterr()
    return refused(capsys, *tokens)


def test_a_graph_of_ones_own_oscillator_and_maps(folder, capsys):
    (folder / "mine.py").write_text(
        "import grazing as gz\nball = gz.pinball(alpha=1.0)\nP = gz.stroboscopic_map(ball)\n"
        "G = gz.gap_map(0.5, 0.1, 0.1)\n"
    )
    for option, names in (
        (["--model", "mine.py:ball", "--order", "full"], ["stroboscopic map", "discontinuity map, full order"]),
        (["--map", "mine.py:P"], ["stroboscopic map", "discontinuity map, lowest order"]),
        (["--map", "mine.py:P", "--order", "none"], ["stroboscopic map"]),
    ):
        assert main(["graph", "u=0.01:0.06:7", "v=-0.23", *option, "-q", "-o", "a.nc"]) == 0
        found = gz.load("a.nc")
        assert found["map"].values.tolist() == names
        want = gz.stroboscopic_map(gz.pinball(alpha=1.0))([0.06, -0.23])[0]
        assert [found["image_u"].values[0, -1], found["image_v"].values[0, -1]] == want.tolist()
    assert main(["graph", "x=-1:1:5", "--map", "mine.py:G", "-q", "-o", "a.nc"]) == 0
    assert gz.load("a.nc").sizes == {"map": 1, "x": 5}
    said = refused_after(capsys, "graph", "x=-1:1:5", "--map", "mine.py:G", "--order", "full")
    assert "the discontinuity map has one" in said


def test_coordinates_of_basins_are_fixed_by_a_value(capsys):
    assert main(["basins", "u=0:0.3:4", "v=0.25", "d=0.1", "--dump-config"]) == 0
    found = tomllib.loads(capsys.readouterr().out)
    assert found["settings"]["fixed"] == {"v": 0.25} and found["parameters"]["d"] == 0.1


def test_negative_values_can_be_given_in_every_way(capsys):
    for tokens in (["--t0", "-0.5"], ["--t0=-0.5"], ["t0=-0.5"]):
        assert main(["diagram", "d=0.1:0.2:3", *tokens, "--box", "-1:1,-2:2", "--dump-config"]) == 0
        found = tomllib.loads(capsys.readouterr().out)
        assert found["parameters"]["t0"] == -0.5 and found["settings"]["box"] == [[-1.0, 1.0], [-2.0, 2.0]]


# ---- tables


def test_a_table_has_every_point_with_its_bits(folder):
    assert main(["diagram", *SMALL, "-q", "-o", "a.csv", "-o", "a.nc"]) == 0
    result = gz.load("a.nc")
    with (folder / "a.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == result.x.size
    assert np.array_equal([float(row["x"]) for row in rows], result.x.values.ravel())
    assert [row["word"] for row in rows] == np.repeat(result.word.values.ravel(), 8).tolist()


def test_interruption_leaves_no_file(folder, monkeypatch, capsys):
    def stop(*_arguments, **_more):
        raise KeyboardInterrupt

    monkeypatch.setattr("grazing.cli.study.made_of", stop)
    assert main(["diagram", *SMALL, "-o", "a.png", "-q"]) == 130
    assert "stopped: interrupted" in capsys.readouterr().err
    assert list(folder.iterdir()) == []


# ---- maps and models of one's own


def test_a_map_and_a_model_of_ones_own(folder, capsys):
    (folder / "mine.py").write_text(
        "import grazing as gz\n"
        "def step(state, p):\n    (x,) = state\n    return (p.a * x * (1.0 - x),)\n"
        "P = gz.Map(step, params={'a': 3.2, 'b': 0.0}, coordinates=('x',), box=((0.1, 0.9),), name='logistic map')\n"
        "def soft(v, p):\n    return -p.r * v / (1.0 - p.c * v)\n"
        "ball = gz.Oscillator(3.0, 1.0, gz.Forcing(2.2, offset=0.12), gz.reset(soft, r=0.8, c=0.1))\n"
    )
    tokens = ["diagram", "a=2.8:3.4:3", "b=0.5", "--map", "mine.py:P", "--starts", "2", "--keep", "8", "-q", "--json"]
    assert main([*tokens, "-o", "a.nc", "-o", "a.png", "-o", "a.zarr"]) == 0
    command = json.loads(capsys.readouterr().out)["command"]
    assert command.startswith(f"grazing diagram a=2.8:3.4:3 --map {folder}/mine.py:P b=0.5 --starts 2 --keep 8")
    assert gz.load("a.nc").period.values[:, 0].tolist() == [1, 2, 2]
    for file in ("a.nc", "a.png", "a.zarr"):
        capsys.readouterr()
        assert f"--map {folder}/mine.py:P b=0.5" in json.loads(_info(capsys, file))["command"]
    assert "--map" in refused(capsys, "sweep", "resume", "a.zarr")
    assert main(["sweep", "resume", "a.zarr", "--map", "mine.py:P"]) == 0
    capsys.readouterr()
    assert main(["diagram", "c=0:0.2:3", "--model", "mine.py:ball", "--starts", "2", "--keep", "4", "-q"]) == 0
    assert "c 3, start 2" in capsys.readouterr().out
    assert "mine.py has no name 'Q'; it has P, ball" in refused(capsys, "diagram", "a=1:2:3", "--map", "mine.py:Q")


@pytest.mark.parametrize(("name", "said"), [("branch", "following branches"), ("windows", "looking for windows")])
def test_what_follows_values_of_its_own_choice_says_at_once_what_is_going_on(name, said, capsys):
    with underway(studies()[name], {"vary": {"d": "0.1:0.2"}}, quiet=False):
        assert capsys.readouterr().err.splitlines() == [said]
