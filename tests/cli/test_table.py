"""Pinball tables in the shell: drawn, played, launched, and studied like any map."""

import json
import shlex

import numpy as np
import pytest
from PIL import Image

import grazing as gz
from grazing import catalogue
from grazing.cli import main
from grazing.config import command_of, load_config, recipe_of, result_of
from grazing.config.check import checked
from grazing.studies.escape import escape

BALL = ["x=5.275", "y=0.7", "vx=0", "vy=17"]
OWN = """
rho = 0.1
tilt = 0.4
plunger = { x = 0.5, y = 3.0, angle = 0.4, slow = 0.1, fast = 0.9 }
presses = { L = [0.5, 0.9] }
[objects]
L = { kind = "flipper", x = 3.0, y = 0.5, length = 1.0, hub = 0.2, tip = 0.1, rest = -0.4, raised = 0.4, up = 9.0,
      down = 5.0, law = "newton", r = 0.8 }
post = { kind = "disc", x = 2.0, y = 1.5, radius = 0.2, law = "active", r = 0.9, V = 0.4 }
left = { kind = "drain", x1 = -30.0, y1 = -1.0, x2 = 2.0, y2 = -1.0 }
right = { kind = "drain", x1 = 2.0, y1 = -1.0, x2 = 40.0, y2 = -1.0 }
""".replace(",\n     ", ",")


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "100")
    (tmp_path / "own.toml").write_text(OWN)
    return tmp_path


def said(capsys, *tokens, code=0):
    assert main(list(tokens)) == code
    out, err = capsys.readouterr()
    return err if code else out


def test_a_table_is_told_and_drawn(capsys, folder):
    out = said(capsys, "table", "own.toml", "post.V=0.7", "-o", "t.png")
    assert "post   disc     active(r=0.9, V=0.7)" in out and "speeds 0.1 to 0.9" in out
    said_inside = gz.plot.provenance(folder / "t.png")["provenance"]
    assert said_inside["grazing_table"] == "own.toml" and said_inside["grazing_changed"] == {"post.V": 0.7}
    found = json.loads(said(capsys, "table", "classic", "--json"))
    assert [one["name"] for one in found["objects"]] == list(gz.read_table("classic").names)


def test_launches_are_those_of_python_and_can_be_made_again(capsys, folder):
    tokens = ["launches", "--table", "own.toml", "angle=0.1:1:7", "speed=0.2,0.8", "post.V=0.7", "--json", "-o", "l.nc"]
    found = json.loads(said(capsys, *tokens, "-o", "l.png", "-o", "l.csv"))
    table = gz.read_table("own.toml").replace(**{"post.V": 0.7})
    truth = gz.launches(table, None, np.linspace(0.1, 1.0, 7), [0.2, 0.8])
    seen = gz.load("l.nc")
    assert seen.exit.values.tolist() == truth.exit.values.tolist() and seen.time.equals(truth.time)
    assert {row["exit"]: row["share"] for row in found["found"]["ways"]} == {
        name: (truth.exit.values == name).mean() for name in np.unique(truth.exit.values)
    }
    recipe = recipe_of(seen.attrs)
    again = result_of(recipe)
    assert again.exit.equals(seen.exit) and command_of(recipe) == command_of(recipe_of(again.attrs))
    said(capsys, *shlex.split(command_of(recipe, ["m.nc"]))[1:])
    assert gz.load("m.nc").time.equals(seen.time)
    for by in ("exit", "hits", "time"):
        said(capsys, "plot", "l.nc", "-o", "by.png", "--style", f"by={by}")
    assert json.loads(said(capsys, "launches", "--table", "own.toml", "--json"))["sizes"] == {"angle": 1, "speed": 200}


def test_a_ball_is_played_to_a_figure_and_a_film(capsys, folder):
    said(capsys, "trajectory", "--table", "own.toml", "x=0.5", "y=3", "vx=0.8", "vy=0", "--until", "9", "-o", "a.gif",
         "-o", "a.png", "-o", "a.nc", "-q")  # fmt: skip
    with Image.open(folder / "a.gif") as film:
        assert film.n_frames > 20
    truth = gz.trajectory(gz.read_table("own.toml"), (0.5, 3.0, 0.8, 0.0), until=9.0)  # with the recording in the file
    seen = gz.load("a.nc")
    assert seen.x.equals(truth.x) and seen.impact_wall.values.tolist() == truth.impact_wall.values.tolist()
    said(capsys, "plot", "a.nc", "-o", "b.png")
    out = said(capsys, "trajectory", "--table", "classic", *BALL, "--until", "60", "-q")
    assert "left by" in out and "certified" in out
    assert "films are of a ball on a table" in said(capsys, "trajectory", "u=0.1", "v=0", "-o", "c.gif", "-q", code=2)


def test_grazes_are_those_of_python_and_can_be_made_again(capsys):
    tokens = "angle=0.1:1:9 speed=0.2:0.9:9 post.V=0.7 --impacts 0 --json -o g.nc -o g.png".split()
    found = json.loads(said(capsys, "grazes", "--table", "own.toml", *tokens))
    table = gz.read_table("own.toml").replace(**{"post.V": 0.7})
    truth = gz.grazes(table, angle=(0.1, 1.0), speed=(0.2, 0.9), order=0, cells=(8, 8))
    seen = gz.load("g.nc")
    assert seen.angle.equals(truth.angle) and seen.object.values.tolist() == truth.object.values.tolist()
    assert found["found"]["curves"] == truth.sizes["curve"] > 0
    said(capsys, *shlex.split(command_of(recipe_of(seen.attrs), ["m.nc"]))[1:])
    assert gz.load("m.nc").speed.equals(seen.speed)
    said(capsys, "plot", "g.nc", "-o", "again.png")


def test_portraits_and_words_are_those_of_python_and_can_be_made_again(capsys):
    table = gz.read_table("one_bumper")
    looks = gz.stroboscopic_map(table, period=0.1)
    cases = {
        "portrait --map stroboscopic period=0.1 --bins 20 --across y --up vy": gz.portrait(
            looks, "y", "vy", bins=20, starts=30, transient=0, keep=20
        ),
        "statistics bumper.V=0.2,0.6 --length 2 --most 5": gz.word_statistics(
            gz.collision_map(table), "bumper.V", [0.2, 0.6], length=2, most=5, starts=30, transient=0, keep=20
        ),
    }
    for command, truth in cases.items():
        study, *tokens = command.split()
        tokens += "--starts 30 --transient 0 --keep 20 -q -o a.nc -o a.png".split()
        assert f"{int(truth.left.sum())} orbits left" in said(capsys, study, "--table", "one_bumper", *tokens)
        seen = gz.load("a.nc")
        assert all(np.array_equal(seen[name], truth[name], equal_nan=seen[name].dtype.kind == "f") for name in truth)
        said(capsys, *shlex.split(command_of(recipe_of(seen.attrs), ["m.nc"]))[1:], "-q")
        assert gz.load("m.nc").drop_attrs().identical(seen.drop_attrs())
        said(capsys, "plot", "a.nc", "-o", "again.png")


def test_studies_of_maps_take_a_table(capsys, folder):
    out = said(capsys, "basins", "--table", "own.toml", "angle=0.1:1:9", "speed=0.8", "--transient", "1", "--keep", "4")
    assert "(left)" in out or "(right)" in out
    tokens = "bumper.V=0.1:0.9:3 --starts 2 --transient 20 --keep 4 -q -o d.nc".split()
    said(capsys, "diagram", "--table", "one_bumper", *tokens)
    assert recipe_of(gz.load("d.nc").attrs)["map"] == "collision"
    assert gz.load("d.nc").sizes["bumper.V"] == 3
    text = 'study = "launches"\ntable = "own.toml"\n[parameters]\npost.V = 0.7\n[vary]\nspeed = "0.2:0.8:3"\n'
    (folder / "deep").mkdir()
    (folder / "deep" / "own.toml").write_text(OWN)
    (folder / "deep" / "config.toml").write_text(text)  # a file beside the one that names it
    recipe = load_config("deep/config.toml")
    assert recipe["parameters"]["post.V"] == 0.7 and recipe["table"] == str((folder / "deep" / "own.toml").resolve())
    assert "launches from (0.5, 3)" in said(capsys, "launches", "--config", "deep/config.toml", "-q")


@pytest.mark.parametrize(
    ("tokens", "words"),
    [
        (["launches", "--table", "none.toml"], "there is no file"),
        (["launches", "angle=1:2:3"], "--table: missing; launches are of a pinball table: classic"),
        (["launches", "--table", "classic", "--law", "active"], "the table brings all that is on it"),
        (["launches", "--table", "classic", "bumper1.V=-3"], "bumper1.V = -3; allowed is"),
        (["launches", "--table", "classic", "bumper9.V=3"], "unknown parameter; did you mean"),
        (["launches", "--table", "classic", "place=1:2:3"], "unknown coordinate; allowed are angle, speed"),
        (["launches", "--table", "classic", "--map", "collision"], "--map = 'collision'; allowed are launch"),
        (["basins", "--table", "classic", "--map", "impact"], "allowed are collision, launch, stroboscopic"),
        (["basins", "--table", "own.toml", "--map", "stroboscopic"], "a recording or a strategy, which have no period"),
        (["basins", "--map", "launch"], "map = 'launch'; allowed are stroboscopic"),
        (["windows", "--table", "classic", "rho=0.1:0.2", "--N", "3"], "windows is offered for oscillators only"),
        (["response", "--table", "classic", "rho=0.1:0.2:3"], "a response is that of an oscillator"),
        (["trajectory", "--table", "classic", *BALL, "--until", "-3"], "until"),
        (["trajectory", "--table", "classic", *BALL[:3]], "the initial state lacks vy"),
        (["basins", "--table", "own.toml", "--map", "collision"], "worked by a recording"),
        (["table", "own.toml", "post.V"], "is not NAME=VALUE"),
        (["table", "own.toml", "post.W=1"], "unknown parameter; did you mean 'post."),
        (["table", "galton", "v=0"], "pin0.x, pin0.y, pin0.radius"),
        (["table", "galton", "v=0"], " and 578 more"),
        (["table", "own.toml", "post.V=much"], "is no number"),
        (["table", "own.toml", "g=1", "g=2"], "'g=2': g is given twice"),
        (["table", "clasic"], "tables that ship are classic"),
    ],
)
def test_what_means_nothing_is_refused(capsys, tokens, words):
    err = said(capsys, *tokens, code=2)
    assert words in err and "Traceback" not in err


def test_a_trajectory_begins_in_the_plunger_unless_it_is_told_where(tmp_path):
    shot = {"study": "trajectory", "table": "classic", "settings": {"until": 0.1}}
    for own, speed in (({}, gz.read_table("classic").plunger.fast), ({"plunger.fast": 13.0}, 13.0)):
        state = checked(shot | {"parameters": own})["settings"]["state"]
        assert state == pytest.approx([5.275, 0.7, 0.0, speed], abs=1e-12)
    (tmp_path / "bare.toml").write_text('[objects]\nout = { kind = "drain", x1 = 0.0, y1 = 0.0, x2 = 6.0, y2 = 0.0 }\n')
    with pytest.raises(gz.InputError, match="state"):
        checked(shot | {"table": str(tmp_path / "bare.toml")})


def test_the_map_from_strobe_to_strobe_of_a_file_is_that_of_python(tmp_path, capsys):
    (tmp_path / "thrown.toml").write_text(
        "rho = 0.1\ntilt = 0.5\nflips = { period = 2.3, hold = 0.5 }\n[objects]\n"
        'L = { kind = "flipper", x = 1.0, y = 1.0, length = 2.0, hub = 0.2, tip = 0.2, rest = -0.2, raised = 0.5, '
        'up = 3.0, down = 2.0, law = "newton", r = 0.5 }\n'
        'out = { kind = "drain", x1 = -9.0, y1 = 0.0, x2 = 9.0, y2 = 0.0 }\n'
    )
    file, still = str(tmp_path / "thrown.toml"), ["vx=0", "vy=0"]
    given = [
        "--table",
        file,
        "--map",
        "stroboscopic",
        "x=1.5:2.5:3",
        "y=2:3:2",
        "phase=0.3",
        *still,
        "--transient",
        "30",
    ]
    said(capsys, "basins", *given, "--keep", "4", "-o", str(tmp_path / "b.nc"))
    P = gz.stroboscopic_map(gz.read_table(file), 0.3)
    grid = {"x": np.linspace(1.5, 2.5, 3), "y": np.linspace(2.0, 3.0, 2)}
    own = gz.basins(P, grid, fixed={"vx": 0.0, "vy": 0.0}, transient=30, keep=4)
    found = gz.load(tmp_path / "b.nc")
    assert (found.word.values == own.word.values).all() and (found.word.values == "(out)").any()
    recipe = recipe_of(found.attrs)
    assert recipe["map"] == "stroboscopic" and "--map stroboscopic" in command_of(recipe)
    assert "--map" not in command_of({"study": "launches", "table": "classic"})


def test_escape_rates_are_those_of_python(capsys):
    few = ["--orbits", "100", "--transient", "1", "--steps", "1", "--populations", "2"]
    out = said(capsys, "escape", "--table", "one_bumper", *few, "bumper.V=0.2,0.8", "--json")
    for row in json.loads(out)["found"]["rates"]:
        P = gz.collision_map(gz.read_table("one_bumper").replace(**{"bumper.V": row["bumper.V"]}))
        rate = gz.escape_rate(P, orbits=100, transient=1, steps=1, populations=2)
        assert (row["rate"], row["error"]) == (rate.rate, rate.error)
    alone = escape(P, orbits=100, transient=1, steps=1, populations=2)
    told = "\n".join(catalogue.escape.words(catalogue.escape.found(alone)))
    assert alone.rate.dims == () and "escape rate a step" in told
    assert "2 populations of 100 orbits over 1 steps" in told
