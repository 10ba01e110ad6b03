"""The table [si]: a rig in SI units in files and in the shell is the one that Python makes of the same numbers."""

import contextlib
import json
import math
import random
import tomllib

import numpy as np
import pytest

import grazing as gz
from grazing.cli import main
from grazing.config import checked, command_of, json_schema, load_config, recipe_of, toml_of
from grazing.config.build import map_in
from grazing.io import load
from grazing.outcome import InputError

SI = {"m": 0.8, "c": 2.4, "k": 3200.0, "force": 2.5, "gap": 1.2e-3, "frequency": 14.0}
TEXT = "m=0.8,c=2.4,k=3200,force=2.5,gap=1.2 mm,frequency=14 Hz"
RIG = {"study": "diagram", "si": SI, "parameters": {"r": 0.7}, "vary": {"sigma": "-2e-3:-1e-3:3"}}


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def rig():
    return gz.Oscillator.from_si(**SI, reset=gz.newton(0.7))


@pytest.mark.parametrize("si", [SI, TEXT, SI | {"gap": "1.2 mm", "m": "800 g", "frequency": "840 rpm"}], ids=str)
def test_it_is_the_model_that_python_makes(si, rig):
    recipe = checked(RIG | {"si": si})
    assert "si" not in recipe and (recipe["mass"], recipe["law"]) == (0.8, "newton")
    P = map_in(recipe)
    assert P.model.mass == 0.8
    params, plain = dict(P.params), dict(gz.stroboscopic_map(rig).params)
    params["offset"] = params.pop("d")
    assert params.keys() == plain.keys()
    for name in params.keys() - {"sigma"}:
        assert params[name] == pytest.approx(plain[name], rel=1e-15), name


def test_a_decimal_comma_is_named_and_nothing_else_is_said_of_the_table():
    with pytest.raises(gz.InputError) as refused:
        checked(RIG | {"si": "m=0,8,c=2.4,k=3200,force=2.5,gap=1.2 mm,frequency=14"})
    assert str(refused.value).endswith("write a decimal point in numbers") and "frequency, in Hz" not in str(
        refused.value
    )


@pytest.mark.parametrize(("side", "sign"), [("above", -1.0), ("below", 1.0)])
def test_words_of_the_table(side, sign):
    recipe = checked(RIG | {"si": SI | {"side": side, "load": 8.0, "base": 1e-3, "moves": "stop"}})
    assert recipe["parameters"]["d"] == pytest.approx(sign * 10.0, rel=1e-15)
    w = 28.0 * math.pi
    assert recipe["parameters"]["sin"] == [] and recipe["base"] == f"moves=stop,displacement={sign * 1e-3!r}"
    model = map_in(recipe).model
    assert model.params["sin1"] == pytest.approx(sign * 2.4 * w * 1e-3 / 0.8, rel=1e-14)
    swept = SI | {"base": 1e-3}
    del swept["frequency"]
    both = {"study": "diagram", "vary": {"omega": "80:90:3"}, "parameters": {"r": 0.7}, "si": swept}
    assert map_in(checked(both)).replace(omega=80.0).model.base.displacement == (-1e-3,)
    if side == "below":  # said beside the table it means the same
        assert checked(RIG | {"stop": side}) == checked(RIG | {"si": SI | {"side": side}})
    with pytest.raises(gz.InputError, match="base = 'moves=up'; give moves=both, spring or stop"):
        checked({"study": "diagram", "vary": {"d": "0:1:3"}, "base": "moves=up"})


def test_a_frequency_that_varies_is_omega_in_turns(rig):
    si = {name: value for name, value in SI.items() if name != "frequency"}
    for given in (si, SI):
        recipe = checked({"study": "response", "si": given, "parameters": {"r": 0.7}, "vary": {"frequency": "5:19:57"}})
        assert recipe["vary"] == {"omega": f"{10 * math.pi!r}:{38 * math.pi!r}:57"}
    bounds = {"study": "windows", "si": si, "parameters": {"r": 0.7}, "vary": {"frequency": "5:19"}}
    assert checked(bounds)["vary"]["omega"] == f"{10 * math.pi!r}:{38 * math.pi!r}"
    listed = checked({"study": "diagram", "si": si, "parameters": {"r": 0.7}, "vary": {"frequency": [5.0, 6.0]}})
    assert listed["vary"]["omega"] == [10 * math.pi, 12 * math.pi]


@pytest.mark.filterwarnings("ignore:the gap is")  # metres make round numbers
def test_what_varies_of_a_rig_is_in_its_own_units():
    rig = {"study": "chart", "si": SI, "parameters": {"r": 0.7}}
    recipe = checked(rig | {"vary": {"force": "2:4:5", "gap": "1 mm:2 mm:3"}})
    assert recipe["vary"] == {"cos1": "-2.5:-5.0:5", "sigma": "-0.001:-0.002:3"}
    recipe = checked(rig | {"vary": {"frequency": "5 Hz:300 rpm:1", "cos1": "-4 N:-2 N:5"}})
    assert recipe["vary"] == {"omega": f"{10 * math.pi!r}:{10 * math.pi!r}:1", "cos1": "-5.0:-2.5:5"}
    assert checked(rig | {"vary": {"gap": "1:4:3:log", "load": "1,2"}})["vary"]["sigma"] == [-1.0, -2.0, -4.0]
    below = rig | {"si": SI | {"side": "below"}, "vary": {"force": "2:4:5", "omega": "1:2:3"}}
    assert checked(below)["vary"]["cos1"] == "2.5:5.0:5"
    for vary, said in [
        ({"gap": "1 N:2 N:3"}, "gap = '1 N'; its units do not match"),
        ({"force": "1:2:3", "cos1": "1:2:3"}, "force and cos1 both vary"),
    ]:
        with pytest.raises(InputError, match=said):
            checked(rig | {"vary": vary})
    with pytest.raises(InputError, match="unknown parameter"):  # the base makes the force: nothing of it is left
        checked(rig | {"si": SI | {"base": 1e-3}, "vary": {"force": "2:4:5", "gap": "1:2:3"}})


def test_spring_and_damper_vary_as_they_are_given():
    rig = {"study": "diagram", "si": SI, "parameters": {"r": 0.7}}
    assert checked(rig | {"vary": {"c": "1:2:3"}})["vary"] == {"alpha": "1.25:2.5:3"}
    even = checked(rig | {"vary": {"k": "3 N/mm:3.4 N/mm:3"}})["vary"]["k"]  # even in k, not in its root
    assert even == pytest.approx([math.sqrt(k / 0.8) for k in (3000.0, 3200.0, 3400.0)], rel=1e-15)
    low, high = math.sqrt(1e3 / 0.8), math.sqrt(4e3 / 0.8)
    first, last, count, log = checked(rig | {"vary": {"k": "1000:4000:3:log"}})["vary"]["k"].split(":")
    assert [float(first), float(last)] == pytest.approx([low, high], rel=1e-15) and (count, log) == ("3", "log")
    bare = {name: SI[name] for name in ("m", "force", "frequency")}  # what varies need not be given, too
    recipe = checked(
        rig | {"study": "chart", "si": bare | {"c": 2.4}, "vary": {"k": "1e3:4e3:3", "gap": "1e-3:2e-3:3"}}
    )
    assert {"k", "sigma"}.isdisjoint(recipe["parameters"]) and [*recipe["vary"]] == ["k", "sigma"]
    with pytest.raises(InputError, match="si: c missing"):
        checked(rig | {"study": "chart", "si": bare, "vary": {"k": "1e3:4e3:3", "gap": "1e-3:2e-3:3"}})
    branch = rig | {"study": "branch", "vary": {"k": "1000:4000"}, "settings": {"word": "0", "at": "2 N/mm"}}
    found = checked(branch)
    assert [float(end) for end in found["vary"]["k"].split(":")] == pytest.approx([low, high], rel=1e-15)
    assert found["settings"]["at"] == pytest.approx([math.sqrt(2e3 / 0.8)], rel=1e-15)


def test_what_is_of_the_rig_may_stand_beside_the_table():
    less = {name: value for name, value in SI.items() if name not in ("frequency", "gap")}
    beside = {"study": "diagram", "si": less, "vary": {"force": "2:3:3"}}
    wanted = checked({**beside, "si": SI, "parameters": {"r": 0.7}})
    assert checked({**beside, "parameters": {"r": 0.7, "frequency": "14 Hz", "gap": "1.2e-3"}}) == wanted
    assert checked({**beside, "parameters": {"r": 0.7, "omega": "28 Hz", "gap": 1.2e-3}})["parameters"][
        "omega"
    ] == pytest.approx(56 * math.pi)


@pytest.mark.filterwarnings("ignore:the gap is")  # metres make round numbers
def test_a_branch_is_looked_at_in_the_units_of_what_varies():
    branch = {"study": "branch", "si": SI, "parameters": {"r": 0.7}, "vary": {"frequency": "5:25"}}
    for at in (20, "20", "20 Hz", [20.0], "1200 rpm"):
        found = checked(branch | {"settings": {"word": "0", "at": at, "locus": "force=2:4"}})["settings"]
        assert found["at"] == [pytest.approx(40 * math.pi, rel=1e-14)], at
        assert found["locus"] == {"cos1": [-5.0, -2.5]}
    bounds = checked(branch | {"vary": {"gap": "1:2"}, "settings": {"word": "0", "at": "1500 mm"}})
    assert (bounds["vary"], bounds["settings"]["at"]) == ({"sigma": "-2.0:-1.0"}, [-1.5])
    with pytest.raises(InputError, match=r"at: frequency = '2 m'; its units do not match"):
        checked(branch | {"settings": {"word": "0", "at": "2 m"}})
    with pytest.raises(InputError, match=r"at = 4; allowed is 5 <= frequency <= 25"):
        checked(branch | {"settings": {"word": "0", "at": "4 Hz"}})


def test_recipes_files_and_commands_lead_back(tmp_path):
    recipe = checked(RIG)
    (tmp_path / "a.toml").write_text(toml_of(RIG))
    assert tomllib.loads((tmp_path / "a.toml").read_text())["si"] == SI
    assert load_config(tmp_path / "a.toml") == recipe == checked(json.loads(json.dumps(recipe)))
    assert "--mass 0.8" in command_of(recipe)
    assert "si" in json_schema()["$defs"]["DiagramConfig"]["properties"]


def test_a_result_made_in_python_remembers_its_mass(rig):
    found = gz.orbit_diagram(gz.stroboscopic_map(rig), "sigma", [-2e-3, -1e-3], starts=2, keep=8)
    recipe = recipe_of(found.attrs)
    assert recipe["mass"] == 0.8 and map_in(recipe).describe("sigma").units == "m"


def test_the_shell_prints_and_writes_the_units_that_are_asked_for(capsys, tmp_path):
    small = ["frequency=13:15:3", "--si", TEXT, "--r", "0.7", "--starts", "2", "-q"]
    assert main(["response", *small, "--units", "Hz,mm,N s", "-o", "a.nc", "-o", "a.png", "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert (
        "frequency" in said["units"]["Hz"] and "amplitude" in said["units"]["mm"] and "impulse" in said["units"]["N s"]
    )
    np.testing.assert_allclose(load("a.nc").omega, [13.0, 14.0, 15.0], rtol=1e-14)
    assert main(["response", *small]) == 0
    out = capsys.readouterr().out
    assert "units: " in out and "Hz (" in out and "N s/kg (impulse" in out
    assert "greatest amplitude (m) " in out and "frequency = 14 to 15 Hz (2 values)" in out
    assert main(["response", *small, "--units", "rad/s"]) == 0
    assert "differ at omega = 87.9646 to 94.2478 rad/s (2 values)" in capsys.readouterr().out
    assert main(["response", *small, "--units", "Hz,mm"]) == 0
    out = capsys.readouterr().out
    assert "up and down differ at frequency = 14 to 15 Hz" in out and "greatest amplitude (mm)" in out
    assert main(["diagram", "sigma=-2e-3:-1e-3:3", *small[1:], "-o", "b.nc"]) == 0
    assert "gap (m) from" in capsys.readouterr().out
    assert main(["windows", "frequency=5:19", *small[1:5], "--N", "1", "--units", "Hz", "-q"]) == 0
    out = capsys.readouterr().out
    assert "frequency (Hz) from" in out and "searched: frequency from 5 to 19 Hz\n" in out
    assert main(["lyapunov", *small, "--units", "Hz"]) == 0
    assert " at frequency = 15 Hz" in capsys.readouterr().out
    assert main(["plot", "b.nc", "-o", "b.png", "--units", "mm"]) == 0
    assert main(["export", "b.nc", "b.csv", "--units", "mm"]) == 0
    assert any("\n-2.0," in file.read_text() for file in tmp_path.glob("b*.csv"))


@pytest.mark.filterwarnings("default")
def test_units_are_checked_before_anything_is_computed(capsys, folder):
    assert main(["trajectory", "u=0.1", "v=0", "--units", "mmm", "-q"]) == 2
    assert "'mmm' is no unit" in capsys.readouterr().err
    assert main(["trajectory", "u=0.1", "v=0", "--units", "mm", "-q"]) == 2
    assert "--units: the model is dimensionless; give it with --si" in capsys.readouterr().err
    rig = ["trajectory", "u=0", "v=0", "--si", TEXT, "--r", "0.7", "--until", "0.2", "-q"]
    assert main([*rig, "--units", "mm,furlong^2"]) == 2
    assert "'furlong^2' matches nothing that a result has" in capsys.readouterr().err
    assert main([*rig, "--units", "mm,N", "-o", "a.csv"]) == 0
    assert "--units: 'N' matches nothing in the result" in capsys.readouterr().err
    assert "u (mm positive down)" in (folder / "a.csv").read_text()


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"si": SI | {"m": -1}}, "si: m = -1; allowed is m > 0"),
        ({"si": SI | {"gap": "1.2 kg"}}, "si: gap = '1.2 kg'; its units do not match"),
        ({"si": SI | {"gap": -1e-3}}, "si: gap = -0.001 m; it is a distance"),
        ({"si": {"m": 1.0}}, "si: c, k, gap missing"),
        ({"si": SI | {"mas": 1.0}}, "unknown parameter 'mas' of si. Allowed are: m, c, k"),
        ({"si": 3}, "si = 3; give a table"),
        ({"si": "m"}, "si = 'm'; give NAME=VALUE"),
        ({"si": SI | {"m": [1.0]}}, "si: m = [1.0] is not a real number"),
        ({"parameters": {"r": 0.7, "alpha": 3.0}}, "si: alpha follows from what it gives; leave it out"),
        ({"mass": 0.7}, "si: mass follows from what it gives; leave it out"),
        ({"parameters": {}}, "parameters.r: missing; give coefficient of restitution; 0 <= r <= 1"),
        ({"vary": {"frequency": "1:2:3", "omega": "1:2:3"}}, "si: frequency and omega both vary"),
        ({"vary": {"frequency": "a:2:3"}}, "vary.frequency = 'a' is not a real number"),
        ({"vary": {"frequency": "5-25"}}, "vary.frequency = '5-25'; give start:stop:count, such as 5:25:100"),
        ({"vary": {"frequency": "5:25"}}, "vary.frequency = '5:25'; give start:stop:count, such as 5:25:100"),
        ({"vary": {"frequency": "5:25:x"}}, "vary.frequency = '5.0:25.0:x': count = 'x'"),
        ({"vary": {"frequency": "-5:25:3"}}, "vary.frequency = -5; allowed is frequency > 0"),
        ({"vary": {"gap": "1 mm to 2 mm"}}, "such as 1 mm:2 mm:100"),
        ({"vary": {"k": "60 rad/s:70 rad/s:3"}}, "its units do not match: give a quantity such as '1 N/m'"),
        ({"vary": {"m": "1:2:3"}}, "vary.m: unknown parameter; here that is the mass by which forces are divided"),
        ({"parameters": {"r": 0.7, "gap": 0.1}}, "parameters.gap = 0.1; the table of the rig gives it, too"),
        ({"map": "gap"}, "si: the map gap is dimensionless; leave it out"),
        ({"si": {k: v for k, v in SI.items() if k != "frequency"}}, "si: neither is given; give frequency"),
    ],
    ids=str,
)  # fmt: skip
def test_what_is_wrong_is_said(change, said):
    with pytest.raises(InputError) as error:
        checked(RIG | change)
    assert said in str(error.value)


@pytest.mark.parametrize(
    "written", ['units = "Hz, mm"\n{}', 'units = ["Hz", "mm"]\n{}', '{}[settings]\nunits = "Hz,mm"\n']
)
def test_a_file_says_in_which_units_things_are_shown(written, folder, capsys):
    rest = """si = "m=0.8,c=2.4,k=3200,force=2.5,gap=1.2 mm"
vary.frequency = "13:15:2"
parameters.r = 0.7
"""
    (folder / "a.toml").write_text('study = "response"\n' + written.format(rest))
    recipe = load_config("a.toml")
    assert recipe["units"] == "Hz,mm" and "--units Hz,mm" in command_of(recipe)
    assert load_config("a.toml") == checked(tomllib.loads(toml_of(recipe)))
    small = ["response", "--config", "a.toml", "--starts", "1", "-q"]
    assert main([*small, "-o", "a.nc"]) == 0
    assert "Hz (" in capsys.readouterr().out
    made = load("a.nc")
    np.testing.assert_allclose(made.omega, [13.0, 15.0], rtol=1e-14)
    assert "units" not in json.loads(made.attrs["grazing_recipe"])  # another look at it has its own
    assert recipe_of(made.attrs)["units"] == "Hz,mm"
    assert main([*small, "--units", "mm/s", "--json"]) == 0  # the shell overrides
    assert {"mm/s", "m", "Hz"} <= json.loads(capsys.readouterr().out)["units"].keys()


@pytest.mark.parametrize(
    ("units", "said"),
    [("mmm", "units: 'mmm' is no unit"), (3, "units = 3; give units with commas"), (["mm", 2], "give units with"),
     ("furlong^2", "units: 'furlong^2' matches nothing that a result has")],
)  # fmt: skip
def test_units_of_a_file_are_checked(units, said):
    with pytest.raises(InputError) as error:
        checked(RIG | {"units": units})
    assert said in str(error.value)
    with pytest.raises(InputError, match="units: the model is dimensionless"):
        checked({"study": "diagram", "units": "mm", "vary": {"d": "0:1:3"}})


@pytest.mark.parametrize(
    ("study", "vary", "said"),
    [
        ("coexistence", {}, "of c, k, frequency, t0, load, force, sin1, gap, r, phase, such as load=0.1:0.2:100"),
        ("orbit", {"frequency": "10:20:5"}, "frequency: an orbit varies nothing"),
        ("windows", {"frequency": "default"}, "vary.frequency: it has no default, so its range is not known; give one, "
         "such as frequency=0.1:0.5, or a value to search around among the numbers of the rig"),
    ],
)  # fmt: skip
def test_refusals_name_what_a_rig_varies_as_the_rig_does(study, vary, said):
    si = {name: value for name, value in SI.items() if name not in vary}
    with pytest.raises(gz.InputError) as refused:
        checked({"study": study, "si": si, "parameters": {"r": 0.7}, "vary": vary})
    assert said in str(refused.value)


@pytest.mark.parametrize("name", ["sigma", "gap"])
def test_a_range_of_gaps_without_values_is_refused(name):
    si = {key: value for key, value in SI.items() if key != name}
    with pytest.raises(gz.InputError, match=rf"vary\.{name}"):
        checked(RIG | {"si": si, "vary": {name: []}})


def test_all_that_is_wrong_is_told_at_once():
    si = {"m": -1, "c": "2 kg", "k": math.nan, "gap": -1e-3, "side": "left", "force": ["2 N", "x"], "mas": 1.0}
    config = {"study": "diagram", "si": si, "parameters": {"r": 1.2, "alpha": 3.0}, "vary": {"frequency": "a:2:3"}}
    with pytest.raises(InputError) as error:
        checked(config | {"settings": {"strats": 3}})
    said = str(error.value)
    assert said.startswith("there are 11 errors:")
    for part in (
        "m = -1", "c = '2 kg'", "k = nan", "gap = -0.001 m", "side = 'left'", "force[1] = 'x'", "'mas' of si",
        "frequency = 'a' is not", "alpha follows from what it gives", "parameters.r = 1.2", "settings.strats",
    ):  # fmt: skip
        assert part in said, part
    with pytest.raises(InputError, match="c, k, gap missing") as error:
        checked({"study": "diagram", "si": {"m": -1}, "vary": {"omega": "1:2:3"}})
    assert str(error.value).count("\n") == 3 and "m = -1" in str(error.value)  # and r, of the law


@pytest.mark.parametrize("gap", [math.nan, -1e-3])
def test_a_wrong_gap_of_a_wall_is_told_by_its_name_alone(gap):
    walls = {"walls": "A=newton,B=newton", "parameters": {"A.gap": "1 mm", "B.gap": gap, "A.r": 0.5, "B.r": 0.5}}
    with pytest.raises(InputError, match=r"si: B\.gap = ") as error:
        checked({"study": "diagram", "si": "m=1,c=1,k=1,force=1", "vary": {"frequency": "1:2:3"}} | walls)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("si", [{}, "m", 3, {"x": 1.0}, {"m": 1.0, "frequency": "1 m"}])
@pytest.mark.parametrize("vary", [{"frequency": [1.0, 2.0]}, {"frequency": "5:19"}, {"frequency": 3}])
def test_what_stands_for_a_wrong_table_is_no_error_itself(si, vary):
    study = "windows" if vary["frequency"] == "5:19" else "diagram"
    with pytest.raises(InputError) as error:
        checked({"study": study, "si": si, "parameters": {"r": 0.7}, "vary": vary})
    assert all("si" in line for line in str(error.value).splitlines() if "errors" not in line)


@pytest.mark.parametrize("mass", [-1, 0, "a", math.nan, [1]])
def test_a_mass_alone_is_checked(mass):
    with pytest.raises(InputError, match="mass"):
        checked({"study": "diagram", "mass": mass, "vary": {"d": "0:1:3"}})


#: What somebody, or a broken program, may write.
ODD = [
    None, True, -1, 0, 1e400, math.nan, "", "a", "1.2 mm", "1.2 kg", [], [1.0], ["2 N", "x"], {}, {"a": 1}, "9**9 m",
    10**400, 1e308, 5e-324, "mm", "above", "both", b"x", (1, 2), "1 " + "m" * 50, "\u202e1 m", [[1]], "inf", "1 Hz",
    "80 rad/s", [1.0] * 2000, 1e160,
]  # fmt: skip


@pytest.mark.filterwarnings("ignore:the gap is")  # of 1e160 m, too
@pytest.mark.parametrize("part", range(4))
def test_whatever_stands_in_the_table_is_answered(part):
    for seed in range(100 * part, 100 * part + 100):
        chosen = random.Random(seed)
        table = dict(SI)
        for _ in range(chosen.choice((1, 1, 2, 3))):
            table[chosen.choice([*SI, "side", "base", "moves", "load", "omega", "x", ""])] = chosen.choice(ODD)
        config = {
            "study": chosen.choice(["diagram", "response", "windows", "trajectory", "basins"]),
            "si": chosen.choice([table, table, ",".join(f"{k}={v}" for k, v in table.items()), chosen.choice(ODD)]),
            "parameters": chosen.choice([{"r": 0.7}, {"r": 0.7, "V": 0.1}, {}, 3]),
            "vary": chosen.choice(
                [{"frequency": "5:19:5"}, {"frequency": "5:19"}, {"omega": [1.0]}, {"frequency": chosen.choice(ODD)}, 3]
            ),
        }
        with contextlib.suppress(InputError):
            checked(config)


def test_a_base_of_too_many_harmonics_is_what_is_blamed():
    """It was cos, of which nobody had said anything."""
    shaken = {"study": "diagram", "vary": {"omega": "2:3:4"}, "mass": 1.0}
    with pytest.raises(InputError, match=r"^base: .*have 1001 harmonics; allowed are at most 1000$"):
        checked({**shaken, "base": f"moves=both,displacement={' '.join(['1e-4'] * 1001)}"})


BEGUN = [
    ({"study": "trajectory", "settings": {"state": ["1 mm", "3 mm/s"]}}, {"state": [1e-3, 3e-3]}),
    ({"study": "trajectory", "settings": {"state": "1 mm, 3 mm/s"}}, {"state": [1e-3, 3e-3]}),
    ({"study": "trajectory", "settings": {"state": ["1 mm", 0.5]}}, {"state": [1e-3, 0.5]}),
    ({"study": "trajectory", "settings": {"state": "0.1,0"}}, {"state": [0.1, 0.0]}),
    ({"study": "basins", "map": "impact", "vary": {"tau": "0 ms:1 ms:3", "v_plus": "1 mm/s:2 mm/s:3"}}, {}),
    ({"study": "graph", "vary": {"u": "0 mm:1 mm:3"}, "settings": {"fixed": "v=5 mm/s"}}, {"fixed": {"v": 5e-3}}),
    ({"study": "graph", "vary": {"v": "0,5 mm/s"}, "settings": {"fixed": {"u": "1 mm"}}}, {"fixed": {"u": 1e-3}}),
]


@pytest.mark.parametrize(("given", "settings"), BEGUN)
def test_a_start_of_a_rig_has_units(given, settings):
    """Parameters had them, and of u = 1 mm it was said that it is no number, or that its units are not known."""
    found = checked({**given, "si": SI, "parameters": {"r": 0.7}})
    assert {key: found["settings"][key] for key in settings} == settings
    for name, written in given.get("vary", {}).items():
        assert name in found["vary"] and "m" in written and "m" not in str(found["vary"][name])


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({"state": ["1 kg", "0"]}, r"state: u = '1 kg'; its units do not match: give a quantity such as '1 m'"),
        ({"state": ["1 mm", "0", "2 s"]}, r"state = '2 s'; the units of state are not known"),
        ({"state": "1 mm;2 mm"}, "state"), (3, "settings"), ({"state": [["1 mm"], 0]}, "state"),
    ],
)  # fmt: skip
def test_what_is_wrong_with_a_start_of_a_rig_is_said(settings, said):
    with pytest.raises(InputError, match=said):
        checked({"study": "trajectory", "si": SI, "parameters": {"r": 0.7}, "settings": settings})


def test_a_start_in_millimetres_in_the_shell_is_that_in_metres(capsys):
    rig = ["trajectory", "--si", TEXT, "--r", "0.7", "--until", "0.2", "-q", "--units", "mm", "-o"]
    assert main([*rig, "a.nc", "u=1 mm", "v=5 mm/s"]) == 0 and main([*rig, "b.nc", "u=0.001", "v=0.005"]) == 0
    assert load("a.nc").u.values.tolist() == load("b.nc").u.values.tolist()
    assert main(["trajectory", "u=1 mm", "v=0"]) == 2  # without a rig there are no units
    assert "u = '1 mm' is not a real number" in capsys.readouterr().err


@pytest.mark.parametrize("kind", ["vary", "si"])
def test_a_frequency_of_a_rig_that_is_too_low_is_refused_in_its_own_unit(kind):
    low = {"vary": {"frequency": "1e-300:1:3"}} if kind == "vary" else {"vary": {"gap": "1e-4:1e-3:2"}}
    si = {name: x for name, x in SI.items() if name not in ("frequency", "gap")}
    si |= {"gap": 1e-3} if kind == "vary" else {"frequency": 1e-300}
    with pytest.raises(InputError, match=r"frequency = 1e-300; allowed is 1\.59e-61 <= frequency <= 1\.59e\+59"):
        checked({"study": "diagram", "si": si, "parameters": {"r": 0.7}, **low})
