"""A density diagram shows the counts where they belong, and says what its colours mean."""

import sys

import numpy as np
import pytest
from matplotlib.colors import LogNorm, Normalize

import grazing as gz
from grazing import plot
from grazing.outcome import InputError
from grazing.plot.density import pooled
from tests.plot import results


def test_the_image_holds_the_shares_in_their_place():
    result = results.density()
    drawn = plot.density(result)
    image = drawn["image"]
    half = 0.5 * (4.0 - 3.4) / 59
    assert image.get_extent() == pytest.approx((3.4 - half, 4.0 + half, 0.1, 0.95))
    shown, count = image.get_array(), result["count"].values.T
    assert shown.shape == count.shape
    assert np.array_equal(np.ma.getmaskarray(shown), count == 0)  # empty bins are left white
    total = (result["count"].sum("x") + result["below"] + result["above"]).values
    assert np.ma.allclose(shown, count / total)
    assert drawn["bar"].ax.get_ylabel() == "share of the points per bin"
    assert drawn["image"].axes.get_ylabel() == "$x$"
    assert drawn["image"].axes.get_xlabel() == "r"
    assert drawn["figure"].get_size_inches()[0] * 25.4 == pytest.approx(174.0)


def test_counts_without_a_bar_and_a_norm_of_ones_own():
    result = results.density()
    own = Normalize(0.0, 100.0)
    drawn = plot.density(result, units="count", norm=own, bar=False)
    assert drawn["bar"] is None
    assert drawn["image"].norm is own
    assert drawn["image"].get_array().max() == result["count"].values.max()
    assert isinstance(plot.density(result, units="count", norm="log")["image"].norm, LogNorm)
    linear = plot.density(result, units="count", norm="linear")
    assert linear["bar"].ax.get_ylabel() == "points per bin"
    assert linear["image"].norm.vmin == 0.0


def test_more_points_are_darker():
    image = plot.density(results.density(), units="count")["image"]
    colours = image.cmap(image.norm(image.norm.inverse(np.linspace(0.0, 1.0, 9))))
    light = colours[:, :3] @ [0.2126, 0.7152, 0.0722]
    assert (np.diff(light) < 0.0).all()


def test_uneven_values_have_uneven_cells():
    values = np.array([3.4, 3.5, 3.52, 3.9])
    image = plot.density(results.density(values))["image"]
    x = image.get_coordinates()[0, :, 0]
    assert x.tolist() == pytest.approx([3.35, 3.45, 3.51, 3.71, 4.09])
    assert image.get_rasterized()


def test_values_in_another_order_are_the_same_figure():
    values = np.linspace(3.4, 4.0, 20)
    one = plot.density(results.density(values))["image"].get_array()
    mixed = results.density(values).isel(r=np.random.default_rng(0).permutation(20))
    assert np.ma.allequal(plot.density(mixed)["image"].get_array(), one)


def test_a_single_value_has_the_only_tick():
    ax = plot.density(results.density(np.array([3.9])))["image"].axes
    assert ax.get_xticks().tolist() == [3.9]


def test_what_the_raster_leaves_out_is_said():
    whole = results.density(low=0.0, high=1.0)
    assert plot.density(whole)["note"] is None
    note = plot.density(results.density(np.array([3.9, 4.0]), ended=3))["note"].get_text()
    assert note.endswith("% of the points lie outside; 6 starts ended")
    whole["ended"][0] = 1
    assert plot.density(whole)["note"].get_text() == "1 start ended"
    few = whole.assign(above=whole["above"] + np.where(np.arange(60) == 0, 1, 0), ended=0 * whole["ended"])
    assert plot.density(few)["note"].get_text() == "less than 0.01 % of the points lie outside"
    most = few.assign(above=few["above"] + 999 * few["count"].sum("x"))
    assert plot.density(most)["note"].get_text() == "99.9 % of the points lie outside"


def test_an_empty_raster_can_be_drawn():
    result = results.density()
    drawn = plot.density(result.assign(count=0 * result["count"]))
    assert np.ma.getmaskarray(drawn["image"].get_array()).all()
    plot.rendered(drawn, "png")


def test_a_raster_without_ends_takes_them_from_its_centres():
    result = results.density()
    result["x"].attrs = {}
    assert plot.density(result)["image"].get_extent()[2:] == pytest.approx((0.1, 0.95))


def test_what_is_not_a_density_is_refused():
    with pytest.raises(
        InputError, match=r"density cannot draw a list; allowed is the xarray.Dataset that grazing.density"
    ):
        plot.density([1, 2])
    with pytest.raises(
        InputError, match=r"finds no count in a result with exponent, .*with count on \(<parameter>, <co"
    ):
        plot.density(results.lyapunov())
    with pytest.raises(InputError, match=r"finds count on \(r\); allowed"):
        plot.density(results.density().sum("x"))
    with pytest.raises(InputError, match="finds nothing along r: the result is empty"):
        plot.density(results.density().isel(r=slice(0)))
    with pytest.raises(InputError, match="norm is 'cube'; allowed are 'eqhist', 'log', 'linear' and a matplotlib"):
        plot.density(results.density(), norm="cube")
    with pytest.raises(InputError, match="units is 'percent'; allowed are 'share', 'count'"):
        plot.density(results.density(), units="percent")


def test_more_cells_than_a_page_has_dots_are_drawn_together(monkeypatch):
    """No point is lost, scale and axes stay, and the picture of a large result takes no more than a smaller one's."""
    result = gz.density(gz.gap_map(lam=0.5, mu=0.1, l=0.2), "mu", np.linspace(0.0, 0.3, 23), starts=3, bins=31, keep=40)
    count, columns, bins = pooled(result["count"].values, np.arange(23))
    assert np.array_equal(count, result["count"].values) and columns.size == 23 and bins.size == 31
    whole = gz.plot.density(result, units="count")["image"].axes
    monkeypatch.setattr(sys.modules["grazing.plot.density"], "MOST", 6)  # the name is that of the function, too
    count, columns, bins = pooled(result["count"].values, np.arange(23))
    assert columns.tolist() == [0, 4, 8, 12, 16, 20] and bins.tolist() == [0, 6, 12, 18, 24, 30]
    assert count.sum() == result["count"].values.sum()
    assert count[1, 2] == result["count"].values[4:8, 12:18].sum()
    drawn = gz.plot.density(result, units="count")["image"]
    assert (drawn.axes.get_xlim(), drawn.axes.get_ylim()) == (whole.get_xlim(), whole.get_ylim())
    assert drawn.get_array().max() == pytest.approx(
        (count / np.array([4, 4, 4, 4, 4, 3])[:, None] / [*[6] * 5, 1]).max()
    )
