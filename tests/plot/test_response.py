"""The figure of a response: what was reached, the branches, the special points and their names."""

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_hex

import grazing as gz
from grazing.plot import response


@pytest.fixture(scope="module")
def result():
    """The rig of tests/compare/test_response.py from 8 to 19 Hz."""
    law, forcing = gz.newton(0.7), gz.Forcing(omega=88.0, cos=(-2.5 / 0.8,))
    rig = gz.Oscillator(alpha=3.0, k=np.sqrt(4000.0), forcing=forcing, sigma=-1.2e-3, reset=law)
    return gz.response(gz.stroboscopic_map(rig), "omega", 2.0 * np.pi * np.arange(8.0, 19.5, 0.5), starts=3)


@pytest.mark.parametrize("by", ["amplitude", "mean", "rms_velocity", "impact_speed", "impulse", "impacts_per_period"])
def test_every_reading_is_drawn_as_it_is(result, by):
    drawn = response(result, by=by)
    for run in ("up", "down"):
        np.testing.assert_array_equal(drawn["runs"][run].get_xdata(), result.omega.values)
        np.testing.assert_array_equal(drawn["runs"][run].get_ydata(), result[by].sel(run=run).values)
    assert drawn["runs"]["starts"].get_ydata().size == 3 * result.sizes["omega"]
    solid = [line for line in drawn["lines"] if line.get_linestyle() == "-"]
    dashed = [line for line in drawn["lines"] if line.get_linestyle() != "-"]
    assert len(solid) == 2 and len(dashed) == 1  # above the graze, and with impacts; from the graze to the fold
    xs = np.concatenate([line.get_xdata() for line in dashed]) / (2.0 * np.pi)
    assert xs.min() == pytest.approx(12.92270, abs=1e-5) and xs.max() == pytest.approx(16.58097, abs=1e-5)
    assert all(np.isfinite(line.get_ydata()).all() for line in drawn["lines"])


def test_special_points_are_marked_and_named_on_the_figure_and_in_the_legend(result):
    drawn = response(result)
    names = sorted(text.get_text() for text in drawn["names"] if text.get_visible())
    assert names == ["gr", "lp"]
    places = sorted(float(marker.get_xdata()[0]) / (2.0 * np.pi) for marker in drawn["markers"])
    assert places[0] == pytest.approx(12.92270, abs=1e-5) and places[-1] == pytest.approx(16.58097, abs=1e-5)
    said = [text.get_text() for text in drawn["legend"].get_texts()]
    assert said == ["random starts", "going up", "going down", "stable orbits", "unstable orbits", "lp: fold",
                    "gr: graze", "up and down differ"]  # fmt: skip
    (band,) = drawn["differences"]
    low, high = band.get_extents().transformed(drawn["figure"].axes[0].transData.inverted()).intervalx / (2.0 * np.pi)
    assert (low, high) == pytest.approx((13.0, 16.5), abs=0.51)


def test_sweeps_that_differ_at_one_value_are_shaded_as_wide_as_its_cell(result):
    values = result[result.amplitude.dims[0]].values
    alone = result.isel(difference=[0]).assign(
        difference_low=("difference", values[[4]]), difference_high=("difference", values[[4]])
    )
    (band,) = response(alone)["differences"]
    assert band.get_x() == 0.5 * (values[3] + values[4])
    assert band.get_x() + band.get_width() == pytest.approx(0.5 * (values[4] + values[5]), rel=1e-12)
    assert response(alone.isel({result.amplitude.dims[0]: slice(5, None)}))["differences"] == []


def test_names_cover_neither_each_other_nor_marks_where_points_crowd():
    P = gz.stroboscopic_map(gz.pinball(V=0.4))
    crowded = gz.bifurcation_diagram(P, "d", np.linspace(0.09, 0.14, 60), starts=5)
    drawn = gz.plot.bifurcation_diagram(crowded)
    renderer = FigureCanvasAgg(drawn["figure"]).get_renderer()
    drawn["figure"].get_layout_engine().execute(drawn["figure"])
    names = [text.get_window_extent(renderer) for text in drawn["names"] if text.get_visible()]
    assert len(names) >= 5
    assert not any(one.overlaps(other) for i, one in enumerate(names) for other in names[:i])
    at = [drawn["figure"].axes[0].transData.transform(mark.get_xydata()[0]) for mark in drawn["markers"]]
    assert not any(box.contains(x, y) for box in names for x, y in at)
    said = [text.get_text().partition(":")[0] for text in drawn["legend"].get_texts()]
    assert {"2", "3", "stable", "pd", "gr", "shaded"} <= {*said}
    assert gz.plot.bifurcation_diagram(crowded, legend=False)["legend"] is None


def test_names_and_legend_can_be_left_out_and_colours_tell_up_from_down(result):
    drawn = response(result, names=False, legend=False)
    assert drawn["names"] == [] and drawn["legend"] is None
    up, down = (to_hex(drawn["runs"][run].get_markeredgecolor()) for run in ("up", "down"))
    assert up != down
    assert drawn["provenance"]["grazing_config"]["study"] == "response"


def test_names_of_a_branch_are_seen_whatever_the_parameter_is(result):
    """In a parameter beyond 1, names were sought before the axes knew their limits, and hidden."""
    law, forcing = gz.newton(0.7), gz.Forcing(omega=88.0, cos=(-2.5 / 0.8,))
    rig = gz.Oscillator(alpha=3.0, k=np.sqrt(4000.0), forcing=forcing, sigma=-1.2e-3, reset=law)
    orbit = next(one for one in gz.one_impact_orbits(rig, 1) if one.stable and one.admissible)
    drawn = gz.plot.branch(gz.continuation(orbit.map, orbit, "omega", (70.0, 110.0)), virtual=False)
    assert [text.get_text() for text in drawn["names"] if text.get_visible()].count("lp") == 1
    assert any(text.get_text() == "gr" and text.get_visible() for text in drawn["names"])


def test_what_cannot_be_drawn_is_said(result):
    with pytest.raises(gz.InputError, match="by is 'speed'; allowed are 'amplitude', 'mean', 'peak_velocity'"):
        response(result, by="speed")
    with pytest.raises(gz.InputError, match="allowed are 'amplitude'"):
        response(result, by="period")
    with pytest.raises(gz.InputError, match="response finds no amplitude"):
        response(gz.orbit_diagram(gz.gap_map(0.5, 0.1, 0.1), "mu", [0.1, 0.2], starts=2))
    with pytest.raises(gz.InputError, match="cannot draw a list"):
        response([1.0])
