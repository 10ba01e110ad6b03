"""The command that makes a thing again says all that differs from the defaults, and makes the same bits."""

import inspect
import json
import shlex
import tomllib
from contextlib import redirect_stdout
from io import StringIO

import numpy as np
import pytest
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st

import grazing as gz
from grazing import InputError
from grazing.cli import main
from grazing.config import boundaries_of, checked, command_of, plan_of, recipe_of, result_of
from grazing.config.build import map_in
from grazing.studies import orbit_diagram
from grazing.studies.plan import run_plan
from grazing.studies.runs import checked_runs
from tests.examples import examples

GAP = {"study": "diagram", "map": "gap", "parameters": {"lam": 0.5, "l": 0.1}, "vary": {"mu": "0:0.1:5"}}
BALL = {"alpha": 3.0, "k": 1.0, "omega": 2.2, "t0": -0.5, "cos": [1.0], "r": 0.8}
CONFIGS = [
    GAP,
    {**GAP, "parameters": {"lam": -0.5, "l": 0.1}, "settings": {"starts": [[0.1]], "keep": 4, "arithmetic": "strict"}},
    {**GAP, "settings": {"box": [[-0.5, 0.25]], "starts": 3, "seed": 5, "sweep": "down"}},
    {"study": "diagram", "vary": {"d": [0.1, 0.13, 0.11]}, "parameters": {**BALL, "V": 0.4, "cos": [1.0, 0.1]}},
    {"study": "diagram", "map": "discontinuity", "order": "full", "law": "newton", "vary": {"r": "0.5:0.9:3"},
     "parameters": {**BALL, "d": 0.12}},
    {"study": "diagram", "map": "normal-form", "vary": {"mu": "0:0.1:3"}, "parameters": {"V": 0.2}},
    {"study": "diagram", "map": "impact", "law": "triggered", "vary": {"trigger": "0:0.1:3"},
     "parameters": {**BALL, "d": 0.12, "V": 0.4}},
    {"study": "chart", "map": "gap", "parameters": {"lam": 0.5}, "vary": {"mu": "0:0.1:3", "l": "0:0.2:2"},
     "curves": [2, 3]},
    {"study": "density", "map": "gap", "parameters": {"lam": 0.5, "l": 0.0}, "vary": {"mu": "0:0.1:3"},
     "settings": {"range": [-1.0, 0.5], "bins": 10}},
    {"study": "lyapunov", "map": "gap", "parameters": {"lam": 0.5, "l": 0.0, "mu": 0.1}, "settings": {"steps": 50}},
    {"study": "basins", "map": "gap", "parameters": {"lam": 0.5, "l": 0.0, "mu": 0.1}, "vary": {"x": "-1:1:9"}},
    {"study": "trajectory", "settings": {"state": [0.1, -0.25], "until": 7.0}},
    {"study": "cobweb", "map": "gap", "parameters": {"lam": 0.5, "l": 0.0, "mu": -0.1}, "settings": {"state": [-0.1]}},
    {"study": "graph", "order": "corrected", "law": "newton", "vary": {"v": "-0.3:0.1:9"}, "coordinate": "u",
     "parameters": {**BALL, "d": 0.12, "cos": [0.5, -0.25], "sin": [0.0, 0.3], "sigma": -0.1},
     "settings": {"fixed": {"u": 0.02}}},
    {"study": "graph", "order": "none", "vary": {"u": [0.01, 0.05, 0.02]}, "parameters": {"phase": 0.25}},
    {"study": "graph", "map": "gap", "parameters": {"lam": 0.5, "l": 0.0, "mu": -0.1}, "vary": {"x": "-1:1:9"}},
]  # fmt: skip


@pytest.mark.parametrize("config", CONFIGS)
def test_the_command_asks_for_the_same(config, capsys):
    recipe = checked(config)
    assert main([*shlex.split(command_of(recipe))[1:], "--dump-config"]) == 0
    assert checked(tomllib.loads(capsys.readouterr().out)) == recipe


NUMBERS = st.sampled_from([0.0, 0.12, 0.4, 0.8, 1.0])
WAVES = st.lists(st.sampled_from([0.0, 0.5, 1.0]), min_size=1, max_size=3)
NAMES = {name: NUMBERS for name in ("alpha", "k", "omega", "t0", "sigma", "d", "r", "V", "trigger", "phase")}


@settings(deadline=None, max_examples=examples(60))
@given(
    st.sampled_from([None, "active", "newton", "triggered"]),
    st.fixed_dictionaries({}, optional={**NAMES, "cos": WAVES, "sin": WAVES}),
    st.booleans(),
    st.sampled_from(["d", "V", "r", "omega", "sigma", "cos1"]),
)
def test_what_is_named_is_kept_and_the_pinball_alone_brings_values(law, named, rest, varied):
    """Whatever is named: the recipe has it, checks to itself, and its command asks for the same."""
    named = {**({**BALL, "d": 0.1, "V": 0.3} if rest else {}), **named}
    for name in [varied] + ["V"] * (law == "newton") + ["trigger"] * (law != "triggered"):
        named.pop(name, None)
    config = {"study": "diagram", "vary": {varied: "0.1:0.2:2"}, "parameters": named, **({"law": law} if law else {})}
    try:
        found = checked(config)
    except InputError as error:
        assert "missing" in str(error) or "omega" in str(error) or "unknown parameter" in str(error)
        return
    pinball = law in (None, "active") and not {"cos", "sin", "sigma"} & {*named} and varied not in ("sigma", "cos1")
    usual = {name: item.default for name, item in inspect.signature(gz.pinball).parameters.items()} | {"cos": [1.0]}
    for name, value in found["parameters"].items():
        if name in named:
            assert value == named[name]
        else:
            assert value in (0.0, [], [0.0]) or (pinball and value == usual[name])
    assert checked(json.loads(json.dumps(found))) == found
    with redirect_stdout(StringIO()) as printed:
        assert main([*shlex.split(command_of(found))[1:], "--dump-config"]) == 0
    assert checked(tomllib.loads(printed.getvalue())) == found


@pytest.mark.parametrize("config", [CONFIGS[1], CONFIGS[3], CONFIGS[7], *CONFIGS[12:]])
def test_the_printed_command_makes_the_same_bits(config, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    small = {"starts": 2, "keep": 8} if config["study"] in ("diagram", "chart") else {}
    recipe = checked({**config, "settings": {**small, **config.get("settings", {})}})
    first = result_of(recipe)
    title = first.attrs["title"]
    gz.plot.save(_figure(first, recipe), "figure.png", title, gz.plot.provenance_of(first))
    assert main(["info", "figure.png", "--json"]) == 0
    command = json.loads(capsys.readouterr().out)["command"]
    again = command.replace("-o figure.png", "-o again.nc -o again.png")
    assert main([*shlex.split(again)[1:], "-q"]) == 0
    xr.testing.assert_identical(gz.load("again.nc"), first)
    assert (tmp_path / "again.png").read_bytes() == (tmp_path / "figure.png").read_bytes()


def _figure(result, recipe):
    from grazing.cli.figures import figure

    shown = {"curves": boundaries_of(recipe), "coordinate": recipe.get("coordinate")}
    return figure(result, **{name: value for name, value in shown.items() if value is not None})


def test_what_needs_quotes_is_quoted(tmp_path):
    file = tmp_path / "my map.py"
    file.write_text("import grazing as gz\nP = gz.gap_map(0.5, 0.1, 0.1)\n")
    command = command_of({**GAP, "map": f"{file}:P"}, ["a figure.png"])
    assert f"'{file}:P'" in command and command.endswith("-o 'a figure.png'")
    assert f"{file}:P" in shlex.split(command)


# ---- from results that Python made


def test_a_result_made_in_python_says_its_command():
    P = gz.stroboscopic_map(gz.pinball(V=0.3, alpha=2.0), phase=0.25)
    result = gz.orbit_diagram(P, "d", np.linspace(0.1, 0.12, 3), starts=2, keep=6, seed=4)
    recipe = recipe_of(result.attrs)
    assert command_of(recipe) == (
        "grazing diagram d=0.1:0.12:3 --alpha 2.0 --V 0.3 --phase 0.25 --starts 2 --keep 6 --seed 4"
    )
    again = run_plan(plan_of(recipe))
    assert again.attrs["grazing_config_sha256"] == result.attrs["grazing_config_sha256"]
    xr.testing.assert_identical(again, result)


def test_a_bifurcation_diagram_made_in_python_says_its_command_with_its_limits(tmp_path, capsys):
    P = gz.gap_map(lam=0.8, mu=0.3, l=1.0)
    result = gz.bifurcation_diagram(P, "mu", np.linspace(0.3, 0.9, 4), starts=2, period=3, points=500)
    recipe = recipe_of(result.attrs)
    again = "grazing bifurcations mu=0.3:0.9:4 --map gap --lam 0.8 --l 1.0 --starts 2 --period 3 --points 500"
    assert command_of(recipe) == again
    assert result_of(recipe).attrs["grazing_config_sha256"] == result.attrs["grazing_config_sha256"]
    gz.plot.save(gz.plot.bifurcation_diagram(result), tmp_path / "a.png", "a")
    assert main(["info", str(tmp_path / "a.png")]) == 0
    assert again in capsys.readouterr().out
    usual = gz.bifurcation_diagram(P, "mu", [0.3, 0.9], starts=2)
    assert {"period": 16, "points": 20_000}.items() <= json.loads(usual.attrs["grazing_config"]).items()
    old = {**result.attrs, "grazing_config": gz.orbit_diagram(P, "mu", [0.3], starts=1).attrs["grazing_config"]}
    with pytest.raises(InputError, match="did not say how far its branches were followed"):
        recipe_of(old)


def test_values_that_are_not_even_are_taken_from_the_result():
    result = gz.orbit_diagram(gz.gap_map(0.5, 0.1, 0.1), "mu", [0.01, 0.05, 0.02], starts=2, keep=6)
    assert recipe_of(result.attrs, {"mu": result.mu.values})["vary"] == {"mu": [0.01, 0.05, 0.02]}
    with pytest.raises(InputError, match=r"values of mu are not evenly spaced and were not kept"):
        recipe_of(result.attrs)


def test_an_oscillator_with_harmonics_and_its_own_box():
    model = gz.Oscillator(0.1, 1.0, gz.Forcing(2.8, cos=(1.0, 0.2), sin=(0.1,)), gz.newton(0.9), sigma=-0.1)
    result = gz.orbit_diagram(gz.stroboscopic_map(model), "r", [0.5, 0.9], starts=2, keep=6)
    recipe = recipe_of(result.attrs)
    assert recipe["parameters"]["cos"] == [1.0, 0.2] and recipe["parameters"]["sin"] == [0.1]
    assert recipe["law"] == "newton" and "box" not in recipe["settings"]
    assert np.array_equal(run_plan(plan_of(recipe)).u.values, result.u.values)


MOVING = (
    gz.pinball(omega=20.0),
    gz.pinball(omega=20.0).replace(sigma=0.1),
    gz.Oscillator(3.0, 1.0, gz.Forcing(2.2, offset=0.12), gz.active(0.8, 0.4)),
    gz.Oscillator(3.0, 1.0, gz.Forcing(2.2, offset=0.12), gz.active(0.8, 0.4), offset_name="d"),
    gz.Oscillator(0.5, 1.0, gz.Forcing(2.2, offset=0.12, cos=(0.4,)), gz.newton(0.8), 0.2),
    gz.Oscillator(0.5, 1.0, gz.Forcing(2.2, offset=0.12), gz.triggered(0.8, 0.4, 0.1)),
)


@pytest.mark.parametrize("of", [gz.stroboscopic_map, gz.impact_map, gz.discontinuity_map])
@pytest.mark.parametrize("model", MOVING)
@pytest.mark.parametrize("name", ["alpha", "omega", "sigma", "cos1", "r", "offset"])
def test_starts_of_a_recipe_are_those_of_the_result_or_it_is_refused(of, model, name):
    """Without a run: where a command would draw its starts, at every value, also where the box moves with it."""
    name = model.offset_name if name == "offset" else name
    P, values = of(model), model.params[name] * np.linspace(0.7, 1.1, 4) - (0.1 if name == "sigma" else 0.0)
    for box in (None, ((0.3, 0.4), (0.1, 0.2)), P.box):
        runs = checked_runs(P, {name: values}, 3, 2, 5, 0, "fast", box)
        plan = orbit_diagram.plan(P, name, values, starts=3, transient=2, keep=5, box=box)
        try:
            recipe = recipe_of(plan.document, {name: values})
        except InputError as error:
            assert "its starts were drawn in boxes" in str(error)
            assert box is not None or model in MOVING[1:4] or name in ("sigma", "cos1"), error
            continue
        again, kept = map_in(recipe), recipe["settings"].get("box")
        ends = checked_runs(again, {next(iter(recipe["vary"])): values}, 3, 2, 5, 0, "fast", kept)
        assert np.array_equal(runs.states(np.arange(4)), ends.states(np.arange(4)))


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"map": "my map"}, "known to Python alone"),
        ({"study": "survey"}, "not one that a command can do"),
        ({"starts": {"given": 3, "sha256": ""}}, "only their fingerprint was kept"),
        ({"params": {"lam": "a", "l": 0.1}}, "not one that a command can say"),
    ],
)
def test_what_a_result_does_not_say(change, said):
    result = gz.orbit_diagram(gz.gap_map(0.5, 0.1, 0.1), "mu", [0.01, 0.05], starts=2, keep=6)
    config = json.loads(result.attrs["grazing_config"]) | change
    with pytest.raises(InputError, match=said):
        recipe_of({"grazing_config": json.dumps(config)})


def test_what_is_no_result():
    with pytest.raises(InputError, match="does not say how it was made"):
        recipe_of({})
    with pytest.raises(InputError, match="damaged"):
        recipe_of({"grazing_config": "[1]"})


def test_the_order_of_a_charts_axes_survives_sorted_keys():
    config = {"study": "chart", "vary": {"d": "0.05:0.16:4", "V": "0:0.4:3"}, "settings": {"starts": 1}}
    plan = plan_of(config)
    kept = json.loads(json.dumps(plan.recipe, sort_keys=True))
    assert list(plan_of(kept).axes) == ["d", "V"]
    assert plan_of(kept).document["grazing_config_sha256"] == plan.document["grazing_config_sha256"]


def test_a_chart_made_in_python_knows_its_axes_from_a_figure_too(tmp_path):
    params = {"mu": np.linspace(0.0, 0.1, 3), "l": np.linspace(0.0, 0.2, 4)}
    result = gz.chart(gz.gap_map(0.5, 0.1, 0.1), params, starts=2)
    gz.plot.save(gz.plot.chart(result), tmp_path / "a.png", provenance=gz.plot.provenance_of(result))
    stored = gz.plot.provenance(tmp_path / "a.png")["provenance"]
    assert list(recipe_of(stored)["vary"]) == ["mu", "l"]
    assert list(recipe_of(result.attrs, {name: result[name].values for name in ("mu", "l")})["vary"]) == ["mu", "l"]


@pytest.mark.parametrize("order", ["lowest", "corrected", None])
def test_a_graph_made_in_python_says_its_command(order):
    model = gz.Oscillator(0.4, 1.2, gz.Forcing(1.7, cos=(0.5, 0.4), sin=(0.3,)), gz.newton(0.7), sigma=-0.1)
    u = np.linspace(0.0, 0.06, 7)
    result = gz.graph(gz.stroboscopic_map(model, phase=0.25), "u", u, fixed={"v": -0.25}, order=order)
    recipe = recipe_of(result.attrs)
    said = {"lowest": "", "corrected": " --order corrected", None: " --order none"}[order]
    assert command_of(recipe) == (
        f"grazing graph u=0:0.06:7{said} --law newton --alpha 0.4 --k 1.2 --omega 1.7 --d 0.0 --sigma=-0.1 "
        "--cos 0.5,0.4 --sin 0.3 --r 0.7 --phase 0.25 --fixed v=-0.25"
    )
    again = result_of(recipe)
    np.testing.assert_array_equal(again["image_u"], result["image_u"])  # what names d has other attributes
    assert again["map"].values.tolist() == result["map"].values.tolist()


def test_the_graph_of_a_discontinuity_map_made_in_python_has_its_order():
    result = gz.graph(gz.discontinuity_map(gz.pinball(), "full"), "u", np.linspace(0.0, 0.06, 7), fixed={"v": -0.25})
    recipe = recipe_of(result.attrs)
    assert command_of(recipe) == "grazing graph u=0:0.06:7 --map discontinuity --order full --fixed v=-0.25"
    again = result_of(recipe)
    del again.attrs["grazing_recipe"]
    xr.testing.assert_identical(again, result)


@pytest.mark.parametrize("study", ["trajectory", "cobweb", "graph"])
def test_what_is_computed_as_a_whole_has_no_plan(study):
    config = next(config for config in CONFIGS if config["study"] == study)
    with pytest.raises(InputError, match="has no cells to sweep"):
        plan_of(config)


def softer(v, p):
    return -0.5 * p.r * v


@pytest.mark.parametrize("walls", [1, 2])
def test_a_law_of_ones_own_is_not_taken_for_one_with_the_same_parameters(walls):
    def model(law):
        push = {"alpha": 0.2, "k": 1.0, "forcing": gz.Forcing(omega=1.5)}
        both = gz.wall(-0.5, gz.newton(0.7)), gz.wall(0.5, law)
        return gz.Oscillator(**push, reset=law) if walls == 1 else gz.Oscillator(**push, walls=both)

    def attrs_with(law):
        P = gz.stroboscopic_map(model(law))
        return gz.orbit_diagram(P, "r", [0.6, 0.7], starts=2, transient=5, keep=2).attrs

    ours, own = attrs_with(gz.newton(0.7)), attrs_with(gz.reset(softer, r=0.7))
    assert recipe_of(ours)["parameters"] and ours["grazing_config_sha256"] != own["grazing_config_sha256"]
    with pytest.raises(gz.InputError, match="its reset law is known to Python alone"):
        recipe_of(own)
