"""A chart has the fixed colours in its cells, shows coexistence, and names what is in it."""

import numpy as np
import pytest
import xarray as xr
from matplotlib.colors import to_rgba_array

import grazing as gz
from grazing import plot
from grazing.outcome import InputError
from grazing.plot import stripes
from grazing.plot.chart import INFINITE
from grazing.plot.style import CHAOS, ENDED, PERIODS
from tests.plot import results


def rgb(colour):
    return np.round(255 * to_rgba_array(colour)[0]).astype(np.uint8)


def names(legend):
    return [text.get_text() for text in legend.get_texts()]


def one_cell(period, share, word=None, exponent=None):
    result = results.chart(1, 1, len(period))
    result["period"][0, 0], result["share"][0, 0] = period, share
    return result


def test_cells_have_the_colours_of_their_periods():
    result = results.chart(20, 16)
    drawn = plot.chart(result, stripes=False)
    pixels = drawn["image"].get_array()
    assert pixels.shape == (16, 20, 4)
    first = result["period"].values[:, :, 0]
    for code, colour in ((1, PERIODS[0]), (4, PERIODS[3]), (-1, CHAOS), (-2, ENDED)):
        assert (first == code).any()
        assert (pixels.swapaxes(0, 1)[first == code] == rgb(colour)).all()
    assert drawn["image"].get_extent() == pytest.approx((-1 - 1 / 19, 1 + 1 / 19, -0.4 / 30, 0.4 + 0.4 / 30))
    ax = drawn["image"].axes
    assert (ax.get_xlabel(), ax.get_ylabel()) == (r"$\mu$", "$l$")
    assert names(drawn["legend"]) == ["1", "2", "3", "4", "5", "aperiodic", "ended"]


def test_a_colour_shared_by_periods_is_one_entry():
    result = results.chart(40, 10, 1, periods=(1, 2, 17, 18, 33))
    assert names(plot.chart(result)["legend"])[:2] == ["1, 17, …", "2, 18"]


@pytest.mark.parametrize("n", [1, 7, 400])
def test_the_area_of_a_stripe_is_its_share(n):
    result = results.chart(n, n, 3)
    result["period"][:], result["share"][:] = [3, 2, -3], [0.625, 0.375, 0.0]
    drawn = plot.chart(result)
    pixels = drawn["image"].get_array().reshape(-1, 4)
    assert (pixels == rgb(PERIODS[2])).all(1).mean() == pytest.approx(0.625, abs=0.01)
    assert (pixels == rgb(PERIODS[1])).all(1).mean() == pytest.approx(0.375, abs=0.01)
    assert names(drawn["legend"]) == ["2", "3", "coexisting, by\nshare of starts"]


def test_stripes_are_equally_far_apart_in_print_at_any_number_of_cells():
    found = []
    for n in (3, 50):
        result = results.chart(n, n, 2)
        result["period"][:], result["share"][:] = [3, 2], [0.5, 0.5]
        drawn = plot.chart(result)
        row = (drawn["image"].get_array()[0] == rgb(PERIODS[2])).all(1)
        millimetres = drawn["image"].axes.get_window_extent().width / drawn["figure"].dpi * 25.4
        found.append(millimetres / (np.diff(row.astype(int)) == 1).sum())
    assert found == pytest.approx([stripes.PITCH, stripes.PITCH], rel=0.03)


def test_stripes_go_on_where_the_order_of_the_ranks_changes():
    result = results.chart(2, 1, 2)
    result["share"][:] = 0.5
    result["period"][0], result["period"][1] = [3, 2], [2, 3]
    one = plot.chart(result)["image"].get_array()
    result["period"][1] = [3, 2]
    assert np.array_equal(plot.chart(result)["image"].get_array(), one)


def test_two_attractors_of_one_colour_are_parted_by_a_white_line():
    pixels = plot.chart(one_cell([3, 3, 5], [0.5, 0.25, 0.25]))["image"].get_array().reshape(-1, 4)
    white = (pixels == 255).all(1).mean()
    assert 0.3 * stripes.LINE < white * stripes.PITCH < 2.0 * stripes.LINE
    assert not (plot.chart(one_cell([3, 2], [0.5, 0.5]))["image"].get_array() == 255).all(-1).any()


def test_only_coexisting_cells_are_striped():
    result = results.chart(2, 2, 2)
    result["period"][:], result["share"][:] = [3, -3], [1.0, 0.0]
    result["period"][0, 0], result["share"][0, 0] = [3, 0], [0.5, 0.5]
    pixels = plot.chart(result)["image"].get_array()
    half = pixels.shape[0] // 2, pixels.shape[1] // 2
    assert (pixels[half[0] :] == rgb(PERIODS[2])).all()
    assert not (pixels[: half[0], : half[1]] == rgb(PERIODS[2])).all()


def test_uneven_and_logarithmic_cells_keep_their_edges():
    x = np.array([0.01, 0.1, 1.0])
    result = results.chart(x=x, ny=2, ranks=2)
    result["period"][:], result["share"][:] = [3, -3], [1.0, 0.0]
    result["period"][0], result["share"][0] = [1, 2], [0.5, 0.5]
    _fig, (ax,) = plot.panels()
    ax.set_xscale("log")
    mesh = plot.chart(result, ax)["image"]
    edges = np.asarray(mesh.get_coordinates())[0, :, 0]
    assert edges[[0, -1]] == pytest.approx(10.0 ** np.array([-2.5, 0.5]))
    blue = (mesh.get_array()[0] == rgb(PERIODS[2])).all(-1)
    assert edges[:-1][blue].min() == pytest.approx(10.0**-1.5, rel=0.05)
    image = plot.chart(result, plot.panels()[1][0])["image"]
    blue = (image.get_array()[0] == rgb(PERIODS[2])).all(-1)
    low, high, *_ = image.get_extent()
    assert low + (high - low) * np.argmax(blue) / blue.size == pytest.approx(0.055, abs=2e-3)


def test_how_many_attractors():
    result = results.chart(1, 4, 8)
    result["period"][0] = [[1, 2, -1, 0, -2, -3, -3, -3], [0, -2, *[-3] * 6], range(1, 9), [5, *[-3] * 7]]
    result["share"][0] = np.where(result["period"][0] == -3, 0.0, 0.1)
    drawn = plot.chart(result, by="attractors")
    assert drawn["legend"].get_title().get_text() == "attractors"
    assert names(drawn["legend"]) == ["none", "1", "3", "6 or more"]
    assert (drawn["image"].get_array()[1, 0] == rgb(ENDED)).all()


def test_exponents_diverge_from_zero():
    result = results.chart(30, 20, 2)
    drawn = plot.chart(result, by="exponent")
    pixels = drawn["image"].get_array().swapaxes(0, 1).astype(float)
    top = result["exponent"].values[..., 0]
    finite = np.isfinite(top)
    redder = pixels[..., 0] - pixels[..., 2]
    assert (redder[finite & (top > 0.02)] > 0).all()
    assert (redder[finite & (top < -0.02)] < 0).all()
    assert (pixels[np.isneginf(top)] == rgb(INFINITE)).all()
    assert names(drawn["legend"]) == ["−∞: chatter or rest"]
    ticks = drawn["bar"].get_ticks()
    assert 0.0 in ticks and min(ticks) < 0.0 < max(ticks)
    assert drawn["bar"].ax.get_ylabel() == "largest exponent per step"


def test_exponents_without_range():
    result = results.chart(3, 3, 1)
    for value in (np.nan, 0.0, -np.inf, 0.5):
        result["exponent"][:] = value
        drawn = plot.chart(result, by="exponent")
        plot.rendered(drawn, "png")
    assert drawn["legend"] is None
    without = plot.chart(result, by="exponent", legend=False)
    assert without["bar"] is without["legend"] is None
    assert plot.chart(result, legend=False)["legend"] is None


def test_curves_are_named_where_they_are():
    x = np.linspace(-1.0, 1.0, 30)
    curves = {"low": (x, 0.1 + 0 * x), "high": (x, 0.3 + 0.05 * x), "far": (x, x + 9.0), "dot": ([0.0], [0.2])}
    drawn = plot.chart(results.chart(), curves=curves)
    assert drawn["curves"]["far"][1] is drawn["curves"]["dot"][1] is None
    assert drawn["curves"]["low"][0].get_ydata().tolist() == (0.1 + 0 * x).tolist()
    at = drawn["curves"]["high"][1].get_position()
    assert at[1] == pytest.approx(0.3 + 0.05 * at[0], abs=1e-6)
    assert drawn["image"].axes.get_ylim()[1] < 0.5


def test_curves_may_be_what_boundaries_returns():
    found = gz.boundaries(gz.gap_map(lam=0.9, mu=0.1, l=0.1), ("mu", 0.0, 1.0), ("l", 0.01, 0.4), N=[3, 4])
    twice = xr.concat([found, found.isel(curve=[0])], "curve")
    drawn = plot.chart(results.chart(), curves=twice)["curves"]
    assert set(drawn) == {"3 pd", "3 bc", "4 pd", "4 bc"} and sum(found.sizes.values()) > 4
    x, y = found.mu.values, found.l.values
    for k, name in enumerate(found.label.values):
        line = np.column_stack(drawn[name][0].get_data())
        want = np.column_stack([x[k], y[k]])
        assert np.array_equal(line[: len(want)], want, equal_nan=True)
        assert np.isnan(line[len(want)]).all() and (len(line) > len(want) + 1) == (k == 0)
    with pytest.raises(InputError, match=r"curves have N, kind, label, V, .*but no mu; give gz.boundaries\(P, \('mu'"):
        plot.chart(results.chart(), curves=found.rename(mu="V")[["N", "kind", "label", "V", "l"]])


def test_curves_may_have_gaps_and_stand_upright():
    curves = {"wall": ([0.5, 0.5, np.nan, 0.5], [0.4, 0.0, np.nan, 0.1]), "back": ([1.0, -1.0], [0.1, 0.3])}
    drawn = plot.chart(results.chart(), curves=curves)["curves"]
    assert drawn["wall"][1].get_position()[0] == pytest.approx(0.5)
    assert np.cos(np.radians(drawn["back"][1].get_rotation())) > 0.0


@pytest.mark.parametrize("curve", [1.0, ([1, 2], [1]), ([[1]], [[1]]), (["a"], ["b"]), ([], [])])
def test_what_is_no_curve_is_refused(curve):
    with pytest.raises(InputError, match=r"curve 'm' is not a pair \(x, y\) of equally long"):
        plot.chart(results.chart(), curves={"m": curve})


def test_what_is_no_chart_is_refused():
    with pytest.raises(InputError, match=r"by is 'words'; allowed are 'period', 'word', 'exponent', 'attractors'"):
        plot.chart(results.chart(), by="words")
    with pytest.raises(
        InputError, match=r"plot.chart finds no share in a result with period.*\(<first parameter>, <sec"
    ):
        plot.chart(results.chart().drop_vars("share"))
    with pytest.raises(InputError, match=r"finds no exponent"):
        plot.chart(results.chart().drop_vars("exponent"), by="exponent")
    assert plot.chart(results.chart().drop_vars("exponent"))["legend"]
    with pytest.raises(InputError, match=r"finds period on \(attractor\)"):
        plot.chart(results.basins())


def test_axes_given_are_used():
    fig, (left, right) = plot.panels(174, 70, 1, 2)
    assert plot.chart(results.chart(), left)["figure"] is fig
    assert plot.chart(results.chart(), right, by="exponent")["image"].axes is right
    plot.rendered(fig, "pdf")
