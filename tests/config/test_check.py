"""Configurations: every error at once with its path, and what was left out filled in."""

import inspect
import json
from datetime import date, time

import pytest

import grazing as gz
from grazing import InputError
from grazing.catalogue import studies
from grazing.config import checked
from grazing.config.build import map_in
from grazing.config.maps import map_of, names_of
from grazing.config.parameters import LAWS, law_names, parameter_names
from grazing.config.schema import MAPS
from grazing.config.settings import ARGUMENTS, SETTINGS, settings_of
from grazing.late import named

DIAGRAM = {"study": "diagram", "vary": {"d": "0.05:0.16:5"}}
GAP = {"study": "diagram", "map": "gap", "parameters": {"lam": 0.5, "l": 0.1}, "vary": {"mu": "0:0.1:5"}}


def problems(config, **more):
    with pytest.raises(InputError) as error:
        checked(config, **more)
    return [line.strip() for line in str(error.value).splitlines()]


#: All that an oscillator needs that is not the paper's pinball.
FULL = {"alpha": 3.0, "k": 1.0, "omega": 2.2, "d": 0.12, "cos": [1.0], "r": 0.8}


# ---- what was left out


def test_defaults_are_those_of_the_functions():
    found = checked(DIAGRAM)
    paper = {name: item.default for name, item in inspect.signature(gz.pinball).parameters.items()}
    assert {name: value for name, value in found["parameters"].items() if name in paper} == {
        name: value for name, value in paper.items() if name != "d"
    }
    assert list(found) == ["study", "map", "law", "parameters", "vary", "settings"]
    assert found["map"] == "stroboscopic" and found["law"] == "active"
    for study in studies():
        known = inspect.signature(named(studies()[study].compute)).parameters
        for name, field in settings_of(study).model_fields.items():
            usual = inspect.Parameter.empty if field.is_required() else field.default
            assert usual is known[name].default or usual == known[name].default


@pytest.mark.parametrize("study", studies())
def test_every_argument_of_a_study_is_a_setting_or_none_for_a_reason(study):
    known = studies()[study]
    assert set(inspect.signature(named(known.compute)).parameters) <= {*SETTINGS, *ARGUMENTS, *known.options}


def test_a_checked_configuration_is_checked_again_to_itself():
    for config in (
        DIAGRAM,
        GAP,
        {**DIAGRAM, "map": "discontinuity", "parameters": {**FULL, "V": 0.4, "cos": [1, 0.5]}},
    ):
        found = checked(config)
        assert checked(found) == found
        assert checked(json.loads(json.dumps(found))) == found


def test_a_parameter_that_varies_has_no_fixed_value():
    assert "d" not in checked({**DIAGRAM, "parameters": {"d": 0.1}})["parameters"]


def test_whole_numbers_and_text_become_floats():
    found = checked({**DIAGRAM, "parameters": {"V": "0.25", "alpha": 2}, "settings": {"starts": "7"}})
    assert found["parameters"]["V"] == 0.25 and repr(found["parameters"]["alpha"]) == "2.0"
    assert found["settings"]["starts"] == 7


@pytest.mark.parametrize("kind", MAPS)
@pytest.mark.parametrize("law", LAWS)
def test_every_map_with_every_law_can_be_made(kind, law):
    if kind == "gap":
        names, coordinates = names_of({"map": kind})
        assert (names, coordinates) == (["lam", "mu", "l"], ["x"])
        return
    own = {"active": {}, "newton": FULL, "triggered": {**FULL, "V": 0.4, "trigger": 0.1}}[law]
    given = {"map": kind, "law": law, "parameters": dict(own)}
    varied = "mu" if kind == "normal-form" else "d"
    if kind == "normal-form" and law == "triggered":
        given["parameters"]["trigger"] = 0.0  # else the law is passive near zero speed, where the form is taken
    P = map_in(checked({"study": "diagram", **given, "vary": {varied: "0.1:0.12:2"}}))
    names, coordinates = names_of(given)
    assert (list(P.params), list(P.coordinates)) == (names, coordinates)
    if kind != "normal-form":
        assert set(law_names(law)) <= set(P.params)


# ---- outside the pinball nothing is assumed


def test_what_is_not_the_pinball_keeps_no_value_of_the_paper():
    """A wall that moved, another wave or another law: the paper's d, cos and the rest belong to its own machine."""
    for beyond, said in (
        ({"law": "newton"}, "law = newton"),
        ({"parameters": {"sigma": -0.1}}, "sigma"),
        ({"parameters": {"cos": [1.0, 0.5]}}, "cos"),
        ({"parameters": {"sin": [1.0]}}, "sin"),
        ({"vary": {"sigma": "0:0.1:5"}}, "sigma"),
        ({"vary": {"cos1": "0.5:1:5"}}, "cos1"),
    ):
        given = beyond.get("parameters", {})
        found = problems({**DIAGRAM, "vary": {"omega": "2:3:5"}, **beyond, "parameters": {**given, "alpha": 0.1}})
        lacking = [line.split(":")[0].removeprefix("parameters.") for line in found[1:]]
        needed = {"k", "omega", "d", "cos", "r", "V"} - {*given} - {*beyond.get("vary", {"omega": 0})}
        needed -= {"cos"} if said == "cos1" else {"V"} if said == "law = newton" else set()
        assert set(lacking) == needed, (beyond, found)
        assert all(f"with {said} this is not the paper's pinball, and nothing is assumed" in line for line in found[1:])


@pytest.mark.parametrize("cos", [[1.0], [1.0, 0.0], [1, 0, -0.0]])
@pytest.mark.parametrize("sin", [[], [0.0], [0, 0.0, 0]])
def test_amplitudes_of_zero_at_the_end_leave_the_pinball_the_pinball(cos, sin):
    """All of it is named, and zeros add nothing to a force: its starts are drawn where its own are."""
    whole = {name: item.default for name, item in inspect.signature(gz.pinball).parameters.items()}
    config = {"map": "stroboscopic", "parameters": {**whole, "cos": cos, "sin": sin}}
    assert map_of(config).box == gz.stroboscopic_map(gz.pinball()).box
    for other in ({"cos": [*cos, 1e-9]}, {"sin": [*sin, 0.0, 1e-9]}, {"cos": [0.5]}, {"cos": [0.0]}, {"sigma": 0.1}):
        changed = map_of({**config, "parameters": {**config["parameters"], **other}})
        model = gz.Oscillator(3.0, 1.0, changed.model.forcing, gz.active(0.8, 0.4), other.get("sigma", 0.0))
        assert changed.box == gz.stroboscopic_map(model).box != map_of(config).box


def test_terms_that_are_not_named_are_not_there():
    found = checked({**DIAGRAM, "law": "newton", "parameters": {**FULL, "cos": [0.0], "sin": [0.5]}})
    assert [found["parameters"][name] for name in ("t0", "sigma", "phase")] == [0.0, 0.0, 0.0]
    model = map_of({**found, "parameters": {**found["parameters"], "d": 0.3}}).model
    assert (model.forcing.cos, model.forcing.sin, model.forcing.offset) == ((0.0,), (0.5,), 0.3)
    assert checked({**DIAGRAM, "vary": {"cos1": "0:1:3"}, "parameters": {**FULL, "cos": None, "V": 0.1}})


def test_what_the_pinball_is_named_by_leaves_it_the_pinball():
    for name in ("alpha", "k", "omega", "t0", "d", "r", "V", "phase"):
        found = checked(
            {"study": "diagram", "vary": {"d" if name != "d" else "V": "0.1:0.2:3"}, "parameters": {name: 0.7}}
        )
        for other, usual in {"alpha": 3.0, "k": 1.0, "omega": 2.2, "r": 0.8, "cos": [1.0], "sigma": 0.0}.items():
            assert found["parameters"][other] == (0.7 if other == name else usual)


@pytest.mark.parametrize("law", LAWS)
def test_recipes_of_old_results_mean_the_same(law):
    """They name every parameter but those that vary; the pinball's d may vary over a range that its value decides."""
    flat = {
        "alpha": 3.0,
        "k": 1.0,
        "omega": 2.2,
        "t0": 0.0,
        "sigma": 0.0,
        "cos": [1.0],
        "sin": [],
        "r": 0.8,
        "phase": 0.0,
    }
    flat |= {"V": 0.4} if law != "newton" else {}
    flat |= {"trigger": 0.1} if law == "triggered" else {}
    recipe = {"study": "diagram", "map": "stroboscopic", "law": law, "parameters": flat, "vary": [["d", "0.1:0.2:3"]]}
    assert checked(recipe)["parameters"] == flat
    windows = {**recipe, "study": "windows", "vary": [["d", "default"]], "settings": {"N": [2]}}
    if law == "active":
        assert checked(windows)["parameters"] == {**flat, "d": 0.12}


# ---- what is wrong


def test_of_pairs_none_is_dropped():
    recipe = {"study": "diagram", "vary": [["d", "0.1:0.2:3"], ["d", "0.3:0.4:3"]]}
    with pytest.raises(InputError, match=r"vary.*d.*: a name is given twice"):
        checked(recipe)


def test_all_errors_come_at_once_with_their_paths():
    found = problems(
        {
            "study": "chart",
            "studdy": 1,
            "order": "full",
            "parameters": {"r": 1.2, "omega": 0, "V": True, "phse": 0.0, "cos": [1, "x"]},
            "vary": {"d": "0.05:0.16", "b": "0:1:3"},
            "settings": {"strats": 3, "keep": 0, "arithmetic": "slow"},
        },
        source="study.toml",
    )
    assert found[0] == "study.toml has 12 errors:"
    text = "\n".join(found)
    for said in (
        "studdy: unknown key; did you mean 'study'? allowed are study, map",
        "order: the discontinuity map has one, the stroboscopic map has not",
        "parameters.r = 1.2; allowed is 0 <= r <= 1 (coefficient of restitution)",
        "parameters.omega = 0; allowed is omega > 0",
        "parameters.V = True is not a real number; allowed is V >= 0",
        "parameters.phse: unknown parameter; did you mean 'phase'?",
        "parameters.cos: cos[1] = 'x' is not a real number",
        "vary.d = '0.05:0.16'; give start:stop:count",
        "vary.b: unknown parameter; allowed are alpha, k",
        "settings.strats: unknown key; did you mean 'starts'?",
        "settings.keep = 0; allowed is a whole number >= 1",
        "settings.arithmetic = 'slow'; allowed are fast, strict",
    ):
        assert said in text, said


@pytest.mark.parametrize(
    ("config", "said"),
    [
        ({}, "study: missing; give what is computed"),
        ({"study": "diagrm"}, "study = 'diagrm'; allowed are 'diagram', 'density'"),
        ({**DIAGRAM, "map": "stroboscpic"}, "map = 'stroboscpic'; did you mean 'stroboscopic'?"),
        ({**DIAGRAM, "map": 3}, "map = 3; give a text"),
        ({**DIAGRAM, "law": "elastic"}, "law = 'elastic'; allowed are 'active', 'newton', 'triggered'"),
        ({**DIAGRAM, "parameters": 3}, "parameters = 3; give a table"),
        ({**DIAGRAM, "settings": 3}, "settings = 3; give a table"),
        ({**DIAGRAM, "vary": "d"}, "vary = 'd'; give a table"),
        ({**DIAGRAM, "settings": [{"starts": 3}]}, "settings: a list of tables; give one, [settings] in place of [[se"),
        ({**DIAGRAM, "parameters": {"d": date(1979, 5, 27)}}, "parameters.d = 'the date 1979-05-27' is not a real"),
        ({**DIAGRAM, "vary": {"d": time(7, 32, 10)}}, "vary.d = 'the time 07:32:10': start = 'the time 07'"),
        ({**DIAGRAM, "": 1}, "'': unknown key; allowed are"),
        ({**DIAGRAM, "parameters": {" ": 1.0}}, "parameters.' ': unknown parameter"),
        ({**DIAGRAM, "si": "m=0.8,c=2.4,k=3200,gap=1.2mm", "table": "classic"}, "si: the table brings all that is on"),
        ({**DIAGRAM, "si": "m=0.8,c=2.4,k=3200,gap=1.2mm", "model": "own.py:m"}, "si: the model brings its own"),
        ({"study": "orbit", "settings": {"word": 9}}, "settings.word = 9; give a text"),
        ({**DIAGRAM, "vary": {}}, "vary: nothing varies; diagram varies 1 parameter of alpha"),
        ({**DIAGRAM, "vary": {"d": [0.1], "V": [0.1]}}, "vary: 2 vary; diagram varies 1 parameter"),
        ({**DIAGRAM, "vary": {"r": "0.5:1.5:10"}}, "vary.r = 1.5; allowed is 0 <= r <= 1"),
        ({**DIAGRAM, "vary": {"omega": [1.0, 0.0]}}, "vary.omega = 0; allowed is omega > 0"),
        ({**DIAGRAM, "law": "newton", "parameters": {"V": 0.1}}, "parameters.V: the newton law has none"),
        ({**DIAGRAM, "law": "triggered"}, "parameters.trigger: missing; give least speed of impact"),
        ({**DIAGRAM, "unfold": "d"}, "unfold: the normal-form map has one, the stroboscopic map has not"),
        ({**DIAGRAM, "map": "impact", "parameters": {"phase": 0.1}}, "parameters.phase: unknown parameter"),
        ({**DIAGRAM, "parameters": {"omega": 1e-200}}, "omega = 1e-200; allowed is 1e-60 <= omega"),
        ({**DIAGRAM, "settings": {"starts": [[0.1, "a"]]}}, "settings.starts: starts[0][1] = 'a' is not"),
        ({**DIAGRAM, "settings": {"box": [[1, 0]]}}, "the lower end must come first"),
        ({**DIAGRAM, "settings": {"sweep": "left"}}, "settings.sweep = 'left'; allowed are up, down"),
        ({**DIAGRAM, "settings": {"seed": 1.5}}, "settings.seed = 1.5; allowed is a whole number >= 0"),
        ({**GAP, "law": "newton"}, "law: the map gap has no reset law"),
        ({**GAP, "parameters": {"lam": 0.5}}, "parameters.l: missing; give size of the gap"),
        ({**GAP, "parameters": {"lam": 0.5, "l": -1e999}}, "parameters.l = -inf is not finite"),
        ({**GAP, "vary": {"m": "0:1:3"}}, "vary.m: unknown parameter; did you mean 'mu'?"),
        ({"study": "trajectory"}, "settings.state: missing; give initial state"),
        ({"study": "trajectory", "settings": {"state": [0, 0]}, "vary": {"d": [0.1]}}, "a trajectory varies nothing"),
        ({"study": "cobweb", "settings": {"state": [0, 0]}}, "a cobweb needs a map with one, such as gap"),
        ({"study": "basins", "vary": {"x": "0:1:3"}}, "vary.x: unknown coordinate; allowed are u, v"),
        (3, "give a table of keys and values"),
    ],
)  # fmt: skip
def test_each_error_says_where_what_and_what_is_allowed(config, said):
    assert said in "\n".join(problems(config))


def test_errors_in_one_part_do_not_hide_those_in_another():
    found = problems({"study": "nothing", "parameters": {"r": 2}, "vary": {"b": "0:1:2"}, "settings": 1})
    assert len(found) == 4 and "study" in found[1]


def test_parameters_are_described_once():
    for name in parameter_names():
        if name not in ("cos", "sin"):
            from grazing.config.parameters import described

            assert described(name).meaning and described(name).meaning != "parameter of the reset law"


def test_a_setting_at_the_top_of_a_file_is_told_where_it_belongs():
    found = problems({**DIAGRAM, "vary": {"d": "0:1:3"}, "starts": 3})
    assert found[0].startswith("starts: unknown key here; it belongs in [settings]; allowed are study, map")


# ---- messages that name the wrong thing


def test_a_name_that_is_no_file_and_name_is_not_said_to_be_code_that_must_be_named_where_it_is():
    assert problems({**DIAGRAM, "model": "classic"}) == ["model = 'classic'; give file.py:name"]
    assert problems({**DIAGRAM, "model": "classic"}, code="trust") == ["model = 'classic'; give file.py:name"]


def test_the_gap_map_has_its_own_coordinates_whatever_walls_are_named_beside_it():
    found = problems({**GAP, "study": "cobweb", "vary": {}, "walls": "A=newton", "settings": {"state": [0.1]}})
    assert "walls: the map gap has no wall; leave them out" in found
    assert not any("coordinates" in line for line in found)


def test_a_mass_that_is_not_finite_is_told_what_a_mass_may_be():
    assert problems({**DIAGRAM, "mass": "inf"}) == ["mass = inf is not finite; allowed is mass > 0, finite"]


@pytest.mark.parametrize(
    ("config", "said"),
    [
        ({**DIAGRAM, "vary": "d"}, ["vary = 'd'; give a table"]),
        ({"study": "trajectory", "vary": {"d": "0:1"}, "settings": {"state": [0.1, 0.0]}},
         ["vary: d: a trajectory varies nothing; give single values"]),
        ({**GAP, "si": "m=0.8,c=2.4,k=3200,gap=1.2mm"}, ["si: the map gap is dimensionless; leave it out"]),
    ],
)  # fmt: skip
def test_what_follows_from_another_error_is_not_said(config, said):
    assert problems(config) == said


@pytest.mark.parametrize("key", ["table", "model"])
@pytest.mark.parametrize("study", ["trajectory", "diagram"])
def test_a_table_or_model_without_a_name_is_refused(key, study):
    assert problems({"study": study, key: ""}) == [f"{key}: '' names nothing; leave it out"]


def test_what_varies_where_nothing_does_is_told_without_the_code(tmp_path):
    config = {"study": "cobweb", "map": f"{tmp_path}/own.py:tent", "vary": {"a": "0:1:3"}, "settings": {"state": [0.1]}}
    assert problems(config) == ["vary: a: a cobweb varies nothing; give single values"]
