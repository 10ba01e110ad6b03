"""Walls in files and in the shell: laws by name, numbers as parameters, the same model as in Python."""

import json
import tomllib

import numpy as np
import pytest

import grazing as gz
from grazing.cli import main
from grazing.config import checked, command_of, load_config, result_of, toml_of
from grazing.config.build import model_near
from grazing.config.maps import map_of, model_of
from grazing.config.schema import json_schema
from grazing.config.si import gaps_asked

RATTLE = """study = "diagram"
[walls]
A = "newton"
B = "active"
[parameters]
alpha = 0.1
k = 0.5
omega = 2.0
cos = [2.0]
A.sigma = -0.5
A.r = 0.8
B.sigma = 0.5
B.V = 0.1
[vary]
B.r = "0.3:0.6:3"
[settings]
starts = 3
keep = 20
"""
SHELL = (
    "--walls A=newton,B=active --alpha 0.1 --k 0.5 --omega 2 --cos 2 A.sigma=-0.5 A.r=0.8 B.sigma=0.5 B.V=0.1".split()
)
FLIGHT = {"alpha": 0.0, "k": 0.0, "omega": 1.0, "cos": [0.0]}


@pytest.fixture
def rattle():
    walls = gz.wall(-0.5, gz.newton(0.8)), gz.wall(0.5, gz.active(0.3, 0.1))
    return gz.Oscillator(alpha=0.1, k=0.5, forcing=gz.Forcing(omega=2.0, cos=(2.0,)), walls=walls)


def refused(capsys, *tokens):
    assert main(list(tokens)) == 2
    out, err = capsys.readouterr()
    assert not out and err.startswith("error: ") and "Traceback" not in err
    return err


def test_a_file_makes_the_model_of_python(tmp_path, rattle):
    file = tmp_path / "rattle.toml"
    file.write_text(RATTLE)
    recipe = load_config(file)
    given = {**recipe["parameters"], "B.r": 0.3}
    assert model_of({**recipe, "parameters": given}) == rattle
    assert list(map_of({**recipe, "parameters": given}).params.items()) == list(
        gz.stroboscopic_map(rattle).params.items()
    )
    again = tmp_path / "again.toml"
    again.write_text(toml_of(recipe))
    assert load_config(again) == recipe == checked(json.loads(json.dumps(recipe)))


def test_the_result_is_that_of_python_and_says_how_it_was_made(tmp_path, rattle):
    recipe = checked(tomllib.loads(RATTLE))
    found = result_of(recipe)
    true = gz.orbit_diagram(gz.stroboscopic_map(rattle), "B.r", np.linspace(0.3, 0.6, 3), starts=3, keep=20)
    assert np.array_equal(found["u"], true["u"]) and np.array_equal(found["word"], true["word"])
    command = command_of(recipe)
    assert "B.r=0.3:0.6:3 --walls A=newton,B=active" in command and "A.sigma=-0.5" in command and "A.cos" not in command


def test_the_shell_says_the_same(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "rattle.toml").write_text(RATTLE)
    found = []
    for tokens in (["--config", "rattle.toml"], ["B.r=0.3:0.6:3", *SHELL, "--starts", "3", "--keep", "20"]):
        assert main(["diagram", *tokens, "--json", "-q"]) == 0
        found.append(json.loads(capsys.readouterr().out))
    assert found[0]["config_sha256"] == found[1]["config_sha256"] and found[0]["found"] == found[1]["found"]
    assert "(BAB)" in {one["word"] for one in found[0]["found"]["attractors"]}
    # what is given here is stronger than the file
    assert main(["diagram", "--config", "rattle.toml", "A.r=0.7", "--dump-config"]) == 0
    assert tomllib.loads(capsys.readouterr().out)["parameters"]["A.r"] == 0.7


def test_a_motion_is_a_list_of_amplitudes_and_may_vary():
    table = {"walls": {"A": "newton"}, "parameters": {**FLIGHT, "offset": -1.0, "r": 0.5, "A": {"sin": [2.0]}}}
    motion = gz.Forcing(omega=1.0, cos=(), sin=(2.0,))
    force = gz.Forcing(omega=1.0, offset=-1.0, cos=(0.0,))
    true = gz.Oscillator(alpha=0, k=0, forcing=force, walls=[gz.wall(0.0, gz.newton(0.5), motion=motion)])
    recipe = checked({"study": "trajectory", **table, "parameters": {**table["parameters"], "sigma": 0.0},
                      "settings": {"state": [4.0, 0.0]}})  # fmt: skip
    assert model_of(recipe) == true
    varied = checked({"study": "diagram", "walls": "A=newton", "vary": {"A.sin1": "1:2:3"},
                      "parameters": {**FLIGHT, "sigma": 0.0, "r": 0.5}})  # fmt: skip
    assert map_of(varied).params["A.sin1"] == 0.0


def test_a_single_wall_may_be_above():
    given = {**FLIGHT, "k": 1.0, "cos": [1.0], "sigma": 0.5, "r": 0.3}
    recipe = checked({"study": "lyapunov", "walls": "A=newton above", "parameters": given})
    assert model_of(recipe).walls[0].side == "above" and recipe["walls"] == {"A": "newton above"}


@pytest.mark.parametrize(
    ("more", "said"),
    [
        (["--walls", "A=newton,C=newton"], "--walls: walls has 'C'; a name is one capital letter other than C and S"),
        (["--walls", "A=bouncy"], "--walls: walls.A = 'bouncy'; allowed are active, newton, triggered, each alone"),
        (["--walls", "A=newton,B=newton,D=newton"], "give one or two, such as A=newton,B=active"),
        (["--walls", "A"], "walls.A = ''; allowed are active, newton, triggered, each alone"),
        ([*SHELL, "B.r=0.5", "--law", "newton"], "--law: the walls bring their own laws; leave the law out"),
        ([*SHELL, "B.r=0.5", "B.q=1"], "B.q: unknown parameter"),
        ([*SHELL], "error: B.r: missing; give coefficient of restitution"),
        ([*SHELL, "B.r=1.5"], "allowed is 0 <= r <= 1 (coefficient of restitution)"),
        ([*SHELL, "B.r=0.5", "A.sigma=0.5"], "A.sigma is given twice"),
        ([*SHELL, "B.r=0.5", "A.cos=x"], "A.cos[0]"),
        (["cos=1:3:5", *SHELL, "B.r=0.5"], "cos: unknown parameter; did you mean 'cos1'"),
        ([*SHELL, "B.r=0.5", "--map", "gap"], "--walls: the map gap has no wall; leave them out"),
    ],
)
def test_what_is_wrong_with_walls_is_said_in_words(more, said, capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "200")
    assert said in " ".join(refused(capsys, "lyapunov", *more).split())


def test_what_stands_for_both_walls_begins_in_the_middle_of_its_range():
    """Windows in r of two walls without one found no value to begin at, and said that r = None."""
    given = {"alpha": 0.1, "k": 0.5, "omega": 2.0, "cos": [2.0], "A.sigma": -0.5, "B.sigma": 0.5}
    walls = {"A": "newton", "B": "newton"}
    recipe = checked({"study": "windows", "walls": walls, "parameters": given, "vary": {"r": "default"}})
    assert [wall.law.params["r"] for wall in model_near(recipe, "r").walls] == [0.5, 0.5]
    given, walls = {**given, "r": 0.5}, {"A": "active", "B": "newton"}
    with pytest.raises(gz.InputError, match=r"give one, such as A.V=0.1:0.5$"):
        checked({"study": "windows", "walls": walls, "parameters": given, "vary": {"A.V": "default"}})


def test_walls_in_each_other_are_refused(capsys):
    tokens = [token.replace("B.sigma=0.5", "B.sigma=-0.5") for token in SHELL]
    assert "both walls are at -0.5; the ball needs room between them" in refused(capsys, "lyapunov", *tokens, "B.r=0.5")


def test_the_schema_knows_walls():
    from jsonschema import Draft202012Validator

    good = {**tomllib.loads(RATTLE), "parameters": {}, "vary": {"B.r": "0.3:0.6:3"}}
    errors = lambda config: list(Draft202012Validator(json_schema()).iter_errors(config))  # noqa: E731
    assert not errors(good)
    for walls in ({"C": "newton"}, {"A": "bouncy"}, {}, {"A": "newton", "B": "newton", "D": "newton"}):
        assert errors({**good, "walls": walls})


OWN = """
import grazing as gz

walls = gz.wall(-0.5, gz.newton(0.8)), gz.wall(0.5, gz.newton(0.6))
rattle = gz.Oscillator(alpha=0.1, k=0.5, forcing=gz.Forcing(omega=2.0, cos=(2.0,)), walls=walls)


def flight(t, t0, state, p):
    x, w = state
    s = t - t0
    return x + (w - 0.5 * p.g * s) * s, w - p.g * s


def gap(t, state, p):
    return state


def bound(t, width, state, p):
    return p.g


floor = gz.Surface("A", gap, bound)
ball = gz.System(("x",), ("w",), {"g": 1.0, "r": 0.5}, flight, [floor], box=((0.5, 1.0), (-1.0, 1.0)), period=1.0)
"""


def test_a_file_of_ones_own_holds_walls_or_a_system(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "own.py").write_text(OWN)
    assert main(["trajectory", "x=0.5", "w=0", "--model", "own.py:ball", "--until", "2.6", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)["found"]
    assert [one["t"] for one in found["first"]] == pytest.approx([1.0, 2.0, 2.5]) and found["x"] == [0.0, 0.5]
    assert main(["graph", "u=-0.4:0.4:9", "--model", "own.py:rattle", "--json", "-q"]) == 0
    assert [one["letter"] for one in json.loads(capsys.readouterr().out)["found"]["letters"]] == ["(BAB)"]
    assert "there is a history of an oscillator only" in refused(
        capsys, "history", "x=0.5", "w=0", "--model", "own.py:ball"
    )


# ---- in SI units

STOPS = """study = "diagram"
[si]
m = 0.8
c = 2.4
k = 3200.0
force = 12.5
frequency = "840 rpm"
A.gap = "0.8 mm"
[walls]
A = "newton"
B = "newton"
[parameters]
A.r = 0.8
B.r = 0.6
[vary]
B.gap = "1.0 mm:1.5 mm:3"
[settings]
starts = 2
keep = 10
"""
TWO_STOPS = "--walls A=newton,B=newton A.r=0.8 B.r=0.6 --si m=0.8,c=2.4,k=3200,force=12.5,frequency=14".split()


def stops(high, **beside):
    walls = gz.wall("-0.8 mm", gz.newton(0.8)), gz.wall(high, gz.newton(0.6))
    given = {"m": 0.8, "c": 2.4, "k": 3200, "force": 12.5, "frequency": 14} | beside
    return gz.Oscillator.from_si(**given, walls=walls)


def test_a_table_of_a_rig_with_stops_on_either_side_makes_the_model_of_python():
    recipe = checked(tomllib.loads(STOPS))
    given = {**recipe["parameters"], "B.sigma": 1.2e-3}
    found, true = model_of({**recipe, "parameters": given}), stops("1.2 mm")
    assert dict(found.params) == pytest.approx(dict(true.params), rel=1e-15) and found.mass == 0.8
    assert recipe["vary"] == {"B.sigma": "0.001:0.0015:3"} and "law" not in recipe and "stop" not in recipe
    assert checked(recipe) == recipe == checked(json.loads(json.dumps(recipe)))
    result = result_of(recipe)
    assert result["B.sigma"].attrs["units"] == "m" and result.attrs["stop"] == "walls"
    assert "--mass 0.8" in command_of(recipe)


def test_gaps_and_positions_say_the_same(capsys):
    found = []
    for gaps in (
        ["A.gap=0.8 mm", "B.gap=1.2 mm"],
        ["A.sigma=-0.8 mm", "B.sigma=1.2 mm"],
        ["A.sigma=-0.0008", "B.gap=1.2 mm"],
    ):
        assert main(["trajectory", "u=0", "v=0", "--until", "0.2", *TWO_STOPS, *gaps, "--dump-config"]) == 0
        found.append(tomllib.loads(capsys.readouterr().out)["parameters"])
    assert found[0] == found[2]
    places = [[one["A.sigma"], one["B.sigma"]] for one in found]
    assert places[0] == pytest.approx(places[1], rel=1e-15)
    one = ["--walls", "A=newton above", "--si", "m=0.8,c=2.4,k=3200,force=12.5,frequency=14,gap=1.2 mm", "--r", "0.7"]
    assert main(["trajectory", "u=0", "v=0", "--until", "0.2", *one, "--dump-config"]) == 0
    assert tomllib.loads(capsys.readouterr().out)["parameters"]["sigma"] == 1.2e-3


@pytest.mark.parametrize(
    ("varied", "low"),
    [("A.gap=0.7 mm:0.9 mm:3", 0.7), ("B.gap=0.7 mm:0.9 mm:3", 0.7), ("A.sigma=-0.9 mm:-0.7 mm:3", -0.9)],
)
def test_tables_call_what_varies_between_walls_as_it_was_asked_for(varied, low, tmp_path, capsys):
    """A gap was called a position, with the other sign."""
    name, wall = varied.partition("=")[0], varied[0]
    rest = "B.gap=1.2 mm" if wall == "A" else "A.gap=1.2 mm"
    few = ["--starts", "2", "--transient", "20", "--keep", "9", "--units", "mm", "-q", "-o", f"{tmp_path}/a.svg"]
    assert main(["diagram", varied, rest, *TWO_STOPS, *few]) == 0
    said = capsys.readouterr().out
    assert said.startswith(f"orbit diagram of the stroboscopic map in {name}\n") and f"{name} (mm) from" in said
    assert f"sizes:   {name} 3" in said
    sign = "-" if wall == "A" else ""
    assert f"$\\sigma^{{{wall}}}={sign}\\mathrm{{gap}}^{{{wall}}}$ (mm)" in (tmp_path / "a.svg").read_text()
    assert main(["diagram", varied, rest, *TWO_STOPS, *few[:-2], "--json"]) == 0
    found = json.loads(capsys.readouterr().out)["found"]
    assert found["parameter"] == name
    assert min(min(span) for row in found["attractors"] for span in row["ranges"]) == pytest.approx(low, rel=1e-12)


def test_a_locus_between_walls_is_told_in_gaps():
    asked = {"walls": "A=newton,B=newton above", "vary": {"B.gap": "1:2"}, "settings": {"locus": "A.gap=1:2"}}
    assert gaps_asked(asked) == {"A.sigma": ("A.gap", -1.0), "B.sigma": ("B.gap", 1.0)}
    assert gaps_asked({"walls": 3, "settings": 4, "vary": []}) == {}


def test_a_base_and_a_load_between_stops_in_a_file():
    table = tomllib.loads(STOPS)
    table["si"] |= {"base": "0.3 mm", "moves": "stop", "load": -7.8, "B.gap": "1.2 mm"}
    table["vary"] = {"frequency": "12:14:3"}
    del table["si"]["frequency"]
    recipe = checked(table)
    true = stops("1.2 mm", base="0.3 mm", moves="stop", load=-7.8)
    model = model_of({**recipe, "parameters": {**recipe["parameters"], "omega": true.params["omega"]}})
    assert dict(model.params) == pytest.approx(dict(true.params), rel=1e-15) and model.base == true.base


@pytest.mark.parametrize(
    ("tokens", "said"),
    [
        (
            ["--si", "m=0.8,c=2.4,k=3200,gap=1,A.gap=1,frequency=14"],
            "gap is that of one stop; of walls give A.gap and B.gap",
        ),
        (["--si", "m=0.8,c=2.4,k=3200,side=above,frequency=14"], "side is that of one stop"),
        (["--si", "m=0.8,k=3200,frequency=14"], "c missing; give m, c and k, with units or in kg, N s/m and N/m"),
        (["--si", "m=0.8,c=2.4,k=3200,frequency=14", "A.gap=-1 mm"], "it is a distance, >= 0"),
        (["--si", "m=0.8,c=2.4,k=3200,frequency=14", "A.gap=1 s"], "units do not match"),
        (
            ["--si", "m=0.8,c=2.4,k=3200,frequency=14,A.gap=1 mm", "A.sigma=0.1"],
            "A.sigma follows from what it gives; leave it out",
        ),
        (
            ["--si", "m=0.8,c=2.4,k=3200,frequency=14"],
            "A.gap missing; give the distance to the stop, such as A.gap='1.2 mm'",
        ),
        (["--stop", "above", "--mass", "1"], "the walls say themselves where they are"),
    ],
)
def test_what_a_rig_between_stops_does_not_have_is_refused(capsys, tokens, said):
    given = ["B.sigma=1:2:3", "--walls", "A=newton,B=newton", "A.r=0.8", "B.r=0.6"]
    assert said in refused(capsys, "diagram", *given, *tokens)


def test_a_gap_that_is_missing_is_asked_for_by_its_name_once(capsys):
    tokens = [token for token in TWO_STOPS if token != "B.r=0.6"]
    said = refused(capsys, "diagram", "B.r=0.2:0.6:3", *tokens, "A.gap=1 mm")
    assert "B.gap missing; give the distance" in said and "sigma" not in said and "A.gap" not in said
    said = refused(capsys, "diagram", "B.r=0.2:0.6:3", *tokens)
    assert "A.gap missing" in said and "B.gap missing" in said and "sigma" not in said


# ---- a stiffness in place of k


def test_a_stiffness_of_either_sign_is_a_parameter_of_files_and_the_shell(capsys):
    flight = {"alpha": -0.05, "stiffness": -0.5, "omega": 2.0, "cos": [0.5]}
    force = gz.Forcing(omega=2.0, cos=(0.5,))
    config = {"study": "trajectory", "settings": {"state": [0.1, 0.0]}, "law": "newton"}
    recipe = checked({**config, "parameters": {**flight, "d": 0.0, "r": 0.7}})
    one = gz.Oscillator(alpha=-0.05, stiffness=-0.5, forcing=force, reset=gz.newton(0.7))
    assert list(model_of(recipe).params.values()) == list(one.params.values())
    walls = {"walls": "A=newton,B=newton", "law": None}
    between = {"A.sigma": -0.5, "A.r": 0.7, "B.sigma": 0.5, "B.r": 0.7}
    recipe = checked({**config, **walls, "parameters": {**flight, **between}})
    two = gz.Oscillator(
        alpha=-0.05, stiffness=-0.5, forcing=force, walls=[gz.wall(x, gz.newton(0.7)) for x in (-0.5, 0.5)]
    )
    assert model_of(recipe) == two and "--stiffness=-0.5" in command_of(recipe)
    assert checked(recipe) == recipe
    tokens = ["--alpha", "0.1", "--omega", "2", "--cos", "0.5", "--walls", "A=newton", "A.r=0.7", "sigma=-0.5"]
    said = refused(capsys, "diagram", "stiffness=-0.5:0.5:3", "--k", "2", "--r", "0.7", *tokens)
    assert "--k: stiffness is given in its place" in said


def test_a_result_that_python_made_with_a_stiffness_has_a_command():
    model = gz.Oscillator(alpha=0.1, stiffness=-0.5, forcing=gz.Forcing(omega=2.0), sigma=-0.5, reset=gz.newton(0.7))
    found = gz.orbit_diagram(gz.stroboscopic_map(model), "stiffness", np.linspace(0.5, 1.5, 3), starts=2, keep=5)
    from grazing.config import recipe_of

    assert "grazing diagram stiffness=0.5:1.5:3" in command_of(recipe_of(found.attrs))


@pytest.mark.parametrize(
    ("walls", "said"),
    [("A=newton,A=newton", "a name is given twice"), ("C=newton,B=newton", "a name is one capital letter")],
)
def test_walls_that_are_wrong_are_all_that_is_said_of_them(walls, said):
    """What parameters there are depends on them: A.sigma was called unknown, and r missing."""
    with pytest.raises(gz.InputError, match=said) as error:
        checked({"study": "windows", "walls": walls, "parameters": {"A.sigma": 0, "B.sigma": 1}, "vary": {"d": "0:1"}})
    assert "sigma" not in str(error.value) and "missing" not in str(error.value)
