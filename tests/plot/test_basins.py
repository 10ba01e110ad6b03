"""Basins have the colours of their attractors, a legend with word, period and share, and the grazing curve on top."""

import numpy as np
import pytest
import xarray as xr
from matplotlib.colors import to_rgba_array

import grazing as gz
from grazing import plot
from grazing.outcome import InputError
from grazing.plot.style import CHAOS, PERIODS
from tests.maps.test_collisions import pinball
from tests.plot import results


def rgb(colour):
    return np.round(255 * to_rgba_array(colour)[0]).astype(np.uint8)


def names(legend):
    return [text.get_text() for text in legend.get_texts()]


def test_launches_are_named_by_their_way_out():
    """No period of a ball that has left, and no entry for a mark that lies outside of the axes."""
    table = pinball()
    grid = {"angle": np.linspace(-3.0, 3.0, 12), "speed": np.linspace(0.2, 2.0, 8)}
    found = gz.basins(gz.launch_map(table, (0.5, 5.0)), grid, transient=1, keep=4)
    legend = plot.basins(found)["legend"]
    assert legend.get_title().get_text() == "way out: share of the area"
    assert sorted(name.partition(":")[0] for name in names(legend)) == ["left_drain", "right_drain"]
    places = {"place": np.linspace(0.05, 3.7, 6), "angle": np.linspace(-1.4, 1.4, 6)}
    found = gz.basins(gz.collision_map(table), places, fixed={"speed": 1.5}, transient=300, keep=8)
    assert {name.partition(":")[0] for name in names(plot.basins(found)["legend"])} <= {"left_drain", "right_drain"}
    mirrors = [gz.segment(name, (0, y), (4, y), gz.newton(1.0)) for name, y in (("A", 0.0), ("B", 2.0))]
    starts = {"place": np.array([1.5]), "angle": np.array([0.0, 1.2])}  # for ever up and down, and away
    found = gz.basins(gz.collision_map(gz.table(mirrors)), starts, fixed={"speed": 1.0}, transient=40, keep=8)
    legend = plot.basins(found, legend=True)["legend"]
    assert legend.get_title().get_text() == "way out or word, period: share of the area"
    assert [name.rpartition(":")[0].removesuffix(", neutral") for name in names(legend)][:2] == ["away", "AB, period 2"]


def test_states_have_the_colour_of_their_attractor():
    result = results.basins(40)
    drawn = plot.basins(result)
    assert drawn["colours"][0] == PERIODS[1]
    assert drawn["colours"][3] == CHAOS
    larger = 1 if result["fraction"][1] > result["fraction"][2] else 2
    assert drawn["colours"][larger] == PERIODS[2]  # of two attractors of period 3 the larger basin
    assert drawn["colours"][3 - larger] not in (*PERIODS, CHAOS)
    pixels = drawn["image"].get_array().swapaxes(0, 1)
    for k, colour in drawn["colours"].items():
        assert (pixels[result["basin"].values == k] == rgb(colour)).all()
    half = 0.5 * 0.62 / 39
    assert drawn["image"].get_extent()[:2] == pytest.approx((-0.5 - half, 0.12 + half))
    assert drawn["image"].axes.get_xlabel() == "u"


def test_the_legend_says_word_period_and_share():
    result = results.basins(40)
    share = [round(100 * float(x), 1) for x in result["fraction"]]
    found = names(plot.basins(result)["legend"])
    assert f"12, period 2: {share[0]:g} %" in found
    assert f"0(12)1, period 3: {share[1]:g} %" in found
    assert f"aperiodic: {share[3]:g} %" in found
    assert found[-3:] == ["grazing curve", "its preimages, orders 1 to 3", "a point of the attractor"]
    assert plot.basins(result, legend=False)["legend"] is None


def test_many_attractors_are_summed_up():
    result = results.basins(40, tuple(range(1, 41)), ["LR"] * 40, graze=False)
    found = names(plot.basins(result, points=False)["legend"])
    assert len(found) == 14
    assert found[-1].startswith("27 more: ")
    total = sum(float(name.split(": ")[1].removesuffix(" %")) for name in found)
    assert total == pytest.approx(100.0, abs=0.7)


def test_the_grazing_curve_and_its_preimages():
    result = results.basins(20)
    drawn = plot.basins(result)["graze"]
    assert list(drawn) == [0, 1, 2, 3]
    own = result["graze"].values[result["graze_order"].values == 2]
    assert np.array_equal(np.column_stack(drawn[2].get_data()), own, equal_nan=True)
    assert [drawn[k].get_alpha() for k in drawn] == sorted((line.get_alpha() for line in drawn.values()), reverse=True)
    assert list(plot.basins(result, graze=1)["graze"]) == [0, 1]
    assert names(plot.basins(result, graze=1)["legend"])[-2] == "its preimage"
    assert plot.basins(result, graze=-1)["graze"] == {}
    assert plot.basins(results.basins(20, graze=False))["graze"] == {}


def test_pieces_of_one_order_that_stand_apart_are_not_joined():
    result = results.basins(20).isel(graze_point=slice(0, 6))
    result["graze_order"][:] = [0, 0, 1, 1, 0, 0]
    x = plot.basins(result)["graze"][0].get_xdata()
    assert np.isnan(x).tolist() == [False, False, True, False, False]


def test_points_lie_on_top():
    result = results.basins(20)
    drawn = plot.basins(result)["points"]
    assert list(drawn) == [0, 1, 2]  # the aperiodic class has no point
    assert drawn[1].get_data()[0].tolist() == [result["point"].values[1, 0]]
    assert plot.basins(result, points=False)["points"] == {}
    assert plot.basins(result.drop_vars("point"))["points"] == {}


def test_one_coordinate_is_a_strip():
    result = results.strip()
    result = result.assign(graze=(("graze_point", "coordinate"), [[0.0], [-0.5]]), graze_order=("graze_point", [0, 1]))
    drawn = plot.basins(result)
    pixels = drawn["image"].get_array()
    assert pixels.shape == (1, 400, 4)
    assert (pixels[0][result["basin"].values == 1] == rgb(PERIODS[3])).all()
    assert drawn["graze"][1].get_xdata().tolist() == [-0.5]
    assert drawn["points"][0].get_xdata().tolist() == [-0.3]
    assert drawn["image"].axes.get_yticks().size == 0
    assert drawn["figure"].get_size_inches()[1] * 25.4 < 40.0


def test_coordinates_in_another_order():
    result = results.basins(20)
    turned = plot.basins(result.transpose("v", "u", ...))
    assert turned["image"].axes.get_xlabel() == "v"
    assert turned["points"][0].get_data()[0].tolist() == [result["point"].values[0, 1]]
    down = plot.basins(result.isel(u=slice(None, None, -1)))
    assert np.array_equal(down["image"].get_array(), plot.basins(result)["image"].get_array())


def test_what_are_no_basins():
    with pytest.raises(InputError, match=r"basins cannot draw a dict; .*basin on \(<first coordinate>, <second"):
        plot.basins({"attractor": 1})
    with pytest.raises(InputError, match="finds no basin in a result with no variables"):
        plot.basins(xr.Dataset())
    with pytest.raises(InputError, match="finds basin from 0 to 3 in a table of 2; allowed are the numbers of its"):
        plot.basins(results.basins(20).isel(attractor=slice(2)))
    with pytest.raises(InputError, match="finds no word"):
        plot.basins(results.basins(20).drop_vars("word"))
