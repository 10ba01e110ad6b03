"""The graph of a map is the map called state by state, and beside it stands the right discontinuity map."""

import json

import numpy as np
import pytest
import xarray as xr

import grazing as gz
from grazing import InputError
from grazing.maps.discontinuity import ORDERS
from grazing.studies.graph import graph, graph_of
from tests.studies.maps import HENON

SHALLOW = gz.pinball(omega=2.1, t0=2.2, d=0.11, V=0.2)  # of Figure 2.2
U = np.linspace(0.01, 0.06, 41)
#: Heights above the wall.
ABOVE = np.linspace(0.005, 0.2, 40)
#: (model, phase)
MODELS = {
    "figure 2.2": (SHALLOW, 0.0),
    "another phase": (SHALLOW, 0.15),
    "no kick": (SHALLOW.replace(V=0.0), 0.0),
    "no damping": (gz.Oscillator(0.0, 1.0, gz.Forcing(2.8, 0.1, 0.02, (1.0,)), gz.active(0.8, 0.2)), 0.0),
    "underdamped, passive": (gz.Oscillator(0.3, 1.2, gz.Forcing(2.6, 0.0, 0.05, (0.8,)), gz.newton(0.9), -0.1), 0.3),
    "a trigger, with chatter": (
        gz.Oscillator(0.4, 1.2, gz.Forcing(1.7, 0.0, 0.1, (0.5,), (0.3,)), gz.triggered(0.7, 0.2, 0.3), 0.15),
        0.3,
    ),
}


def called(P, values, name, fixed):
    """Images, shape (dim, n), and letters of a map that is called state by state."""
    made = [P([x if own == name else fixed[own] for own in P.coordinates]) for x in values]
    return np.array([image for image, _letter in made]).T, [letter for _image, letter in made]


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("kind", MODELS)
def test_both_maps_are_those_that_are_called_one_by_one(kind, order):
    model, phase = MODELS[kind]
    values = model.sigma + ABOVE
    found = graph(gz.stroboscopic_map(model, phase=phase), "u", values, fixed={"v": -0.23}, order=order)
    assert found["map"].values.tolist() == ["stroboscopic map", f"discontinuity map, {order} order"]
    for k, P in enumerate((gz.stroboscopic_map(model, phase=phase), gz.discontinuity_map(model, order, phase))):
        images, letters = called(P, values, "u", {"v": -0.23})
        np.testing.assert_array_equal([found["image_u"][k], found["image_v"][k]], images)
        np.testing.assert_array_equal(found["letter"][k], letters)
        assert len(set(letters)) > 1  # the line leads across the graze, or the comparison says little
    assert not np.array_equal(found["image_u"][0], found["image_u"][1])


@pytest.mark.parametrize("V", [0.0, 0.2])
def test_no_two_orders_are_the_same_with_a_kick_or_without(V):
    P = gz.stroboscopic_map(SHALLOW.replace(V=V))
    found = [graph(P, "u", U, fixed={"v": -0.23}, order=order)["image_u"].values for order in ORDERS]
    for one, other in ((0, 1), (1, 2), (0, 2)):
        np.testing.assert_array_equal(found[one][0], found[other][0])
        assert not np.array_equal(found[one][1], found[other][1])


def test_the_other_coordinate_varies():
    P, v = gz.stroboscopic_map(SHALLOW), np.linspace(-0.4, 0.1, 33)
    found = gz.graph(P, "v", v, fixed={"u": 0.03}, order="full")
    images, letters = called(gz.discontinuity_map(SHALLOW, "full"), v, "v", {"u": 0.03})
    assert found["image_v"].dims == ("map", "v")
    np.testing.assert_array_equal([found["image_u"][1], found["image_v"][1]], images)
    np.testing.assert_array_equal(found["letter"][1], letters)


@pytest.mark.parametrize(
    ("P", "name", "values", "fixed"),
    [
        (gz.gap_map(0.8, 0.5, 1.0), "x", [-1.0, -0.5, 0.0, 0.25], {}),
        (HENON, "y", [0.3, -0.2], {"x": 0.1}),
        (gz.impact_map(SHALLOW), "v_plus", np.linspace(0.3, 0.6, 9), {"tau": 0.4}),
        (gz.discontinuity_map(SHALLOW, "full"), "u", U, {"v": -0.23}),
    ],
    ids=["gap", "own", "impact", "discontinuity"],
)
def test_any_other_map_stands_alone(P, name, values, fixed):
    found = graph(P, name, values, fixed=fixed, order="full")
    assert found["map"].values.tolist() == [P.name]
    images, letters = called(P, values, name, fixed)
    np.testing.assert_array_equal([found[f"image_{own}"][0] for own in P.coordinates], images)
    np.testing.assert_array_equal(found["letter"][0], letters)
    assert "order" not in json.loads(found.attrs["grazing_config"])


def test_no_order_leaves_the_stroboscopic_map_alone():
    P = gz.stroboscopic_map(SHALLOW)
    both, alone = (graph(P, "u", U, fixed={"v": -0.23}, order=order) for order in ("lowest", None))
    assert alone["map"].values.tolist() == ["stroboscopic map"]
    np.testing.assert_array_equal(alone["image_u"][0], both["image_u"][0])
    assert alone.attrs["grazing_config_sha256"] != both.attrs["grazing_config_sha256"]
    assert alone.attrs["grazing_code_sha256"] != both.attrs["grazing_code_sha256"]


def test_what_is_not_fixed_is_in_the_middle_of_the_box():
    found = graph(HENON, "x", [0.0, 0.1])
    assert json.loads(found.attrs["grazing_config"])["fixed"] == {"y": 0.0}
    np.testing.assert_array_equal(found["image_x"][0], [1.0, HENON([0.1, 0.0])[0][0]])


def test_an_orbit_that_ends_says_so():
    falling = gz.Map(lambda state, p: (state[0] * 1e308,), params={}, coordinates=("x",), name="flight to infinity")
    found = graph(falling, "x", [1.0, 1e10])
    assert np.isfinite(found["image_x"].values).tolist() == [[True, False]]
    assert found["outcome"].values[0, 0] == 0 and found["outcome"].values[0, 1] & gz.Outcome.diverged


def test_the_configuration_and_a_file_keep_all(tmp_path):
    found = graph(gz.stroboscopic_map(SHALLOW, phase=0.25), "u", U, fixed={"v": -0.23}, order="corrected")
    config = json.loads(found.attrs["grazing_config"])
    assert config["study"] == "graph" and config["order"] == "corrected" and config["params"]["phase"] == 0.25
    assert config["grid"]["u"]["count"] == 41 and config["fixed"] == {"v": -0.23}
    assert found["image_u"].attrs["long_name"] == "image of u under the map"
    assert "GRAZE" in found["outcome"].attrs["flag_meanings"].upper()
    gz.save(found, tmp_path / "graph.nc")
    xr.testing.assert_identical(gz.load(tmp_path / "graph.nc"), found)


BALL = gz.stroboscopic_map(SHALLOW)


@pytest.mark.parametrize(
    ("arguments", "more", "said"),
    [
        ((SHALLOW, "u", U), {}, "give a map, such as gz.stroboscopic_map"),
        ((BALL, "w", U), {}, "'w' is no coordinate of the stroboscopic map; allowed are u, v"),
        ((BALL, "V", U), {}, "'V' is no coordinate of the stroboscopic map"),
        ((BALL, "u", []), {}, "give finite values of u"),
        ((BALL, "u", [0.1, np.nan]), {}, r"values\[1\] = nan is not finite"),
        ((BALL, "u", [[0.1]]), {}, r"values have shape \(1, 1\)"),
        ((BALL, "u", [0.2, -0.1, 0.3]), {}, "the ball starts inside the wall: u = -0.1"),
        ((BALL, "v", [0.1]), {"fixed": {"u": -0.5}}, "the ball starts inside the wall"),
        ((BALL, "u", U), {"fixed": {"u": 0.1}}, "fixed has 'u'; allowed are v"),
        ((BALL, "u", U), {"fixed": {"v": np.inf}}, "v = inf is not finite"),
        ((gz.gap_map(0.8, 0.5, 1.0), "x", U), {"fixed": {"x": 0.1}}, "allowed are none: all coordinates vary"),
        ((BALL, "u", U), {"order": "second"}, "order is 'second'; allowed are 'lowest', 'full', 'corrected' and None"),
        ((gz.gap_map(0.8, 0.5, 1.0), "x", U), {"order": "second"}, "order is 'second'; allowed are"),
    ],
)
def test_what_is_refused(arguments, more, said):
    with pytest.raises(InputError, match=said):
        graph(*arguments, **more)


@pytest.mark.parametrize(
    ("name", "other"), [("map", "x"), ("letter", "x"), ("outcome", "x"), ("image_x", "x"), ("image_image_x", "image_x")]
)
def test_a_coordinate_with_the_name_of_a_dimension_is_refused(name, other):
    P = gz.Map(lambda state, p: state, params={}, coordinates=(name, other), box=((0, 1),) * 2)
    with pytest.raises(InputError, match=f"'{name}' names a dimension or variable of the result; rename it"):
        graph(P, name, [0.5])


def test_a_row_of_images():
    row = graph_of(BALL, U, "u", v=-0.23)
    found = graph(BALL, "u", U, fixed={"v": -0.23}, order=None)
    np.testing.assert_array_equal(row.images.T, [found["image_u"][0], found["image_v"][0]])
    np.testing.assert_array_equal(row.letters, found["letter"][0])
    assert gz.plot.graph_of is graph_of
