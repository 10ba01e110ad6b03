"""Recipes of what Python made with two walls: the command makes the same numbers."""

import json

import numpy as np
import pytest

import grazing as gz
from grazing.config import checked, command_of, recipe_of, result_of

SI = {"m": 1.35, "c": 3.8, "k": 5100, "force": 4.2, "frequency": 12}


def between(low, high, **more):
    force = gz.Forcing(omega=0.8, t0=0.1, offset=0.05, cos=(1.0, 0.2), sin=(0.0, 0.1))
    return gz.Oscillator(alpha=0.1, k=1.0, forcing=force, walls=(low, high), **more)


SHAKE = gz.Forcing(omega=1.6, t0=0.3, cos=(0.02,), sin=(0.01,))
MODELS = {
    "plain": lambda: between(gz.wall(-0.5, gz.newton(0.7)), gz.wall(0.5, gz.newton(0.7))),
    "laws, names and a motion": lambda: between(
        gz.wall(-0.5, gz.triggered(0.7, 0.1, 0.2), name="Z"), gz.wall(0.5, gz.active(0.6, 0.1), motion=SHAKE, name="B")
    ),
    "SI": lambda: gz.Oscillator.from_si(
        **SI, walls=(gz.wall("-0.9 mm", gz.newton(0.6)), gz.wall("1.3 mm", gz.newton(0.5)))
    ),
    "a base": lambda: gz.Oscillator.from_si(
        **{**SI, "force": 0.0}, base="0.3 mm", moves="stop",
        walls=(gz.wall("-0.9 mm", gz.newton(0.6)), gz.wall("1.3 mm", gz.newton(0.5))),
    ),
}  # fmt: skip
STUDIES = {
    "response": lambda P, name, values: gz.response(P, name, values, starts=2),
    "diagram": lambda P, name, values: gz.orbit_diagram(P, name, values, starts=3, transient=20, keep=5),
}
CASES = [
    (model, study, name)
    for model, study, names in (
        ("plain", "response", ["omega"]),
        ("plain", "diagram", ["r", "cos1", "A.sigma", "B.r"]),
        ("laws, names and a motion", "diagram", ["omega", "Z.sigma", "B.cos2", "offset"]),
        ("SI", "response", ["omega"]),
        ("SI", "diagram", ["omega", "A.sigma"]),
        ("a base", "diagram", ["omega"]),
    )
    for name in names
]


@pytest.mark.parametrize(("model", "study", "name"), CASES)
def test_what_python_made_between_walls_is_made_again_by_its_recipe(model, study, name):
    P = gz.stroboscopic_map(MODELS[model]())
    value = P.params["A.r" if name == "r" else name]
    made = STUDIES[study](P, name, value * np.array([1.0, 1.05, 1.1]) if value else [0.0, 0.05, 0.1])
    recipe = recipe_of(made.attrs, {name: made[name].values})
    assert recipe == checked(recipe) and command_of(recipe)
    again = result_of(recipe)
    assert json.loads(again.attrs["grazing_config"]) == json.loads(made.attrs["grazing_config"])
    for key, column in made.data_vars.items():
        np.testing.assert_array_equal(again[key].values, column.values, err_msg=str(key))


def test_a_name_that_stands_for_an_unknown_number_of_walls_is_refused():
    P = gz.stroboscopic_map(between(gz.wall(-0.5, gz.newton(0.7)), gz.wall(0.5, gz.active(0.6, 0.1))))
    found = gz.orbit_diagram(P, "V", [0.1, 0.2], starts=2, transient=2, keep=2)
    with pytest.raises(gz.InputError, match="does not say of which walls V is"):
        recipe_of(found.attrs)


def test_a_result_itself_is_not_its_attributes():
    found = gz.orbit_diagram(gz.gap_map(lam=0.5, mu=0.1, l=0.2), "mu", [0.0, 0.1], starts=2, transient=2, keep=2)
    with pytest.raises(gz.InputError, match=r"give those of a result, result\.attrs"):
        recipe_of(found)
