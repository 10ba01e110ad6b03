"""Exponents stand at their values, minus infinity in a row of its own, chaos in a shade."""

import numpy as np
import pytest

import grazing as gz
from grazing import plot
from grazing.outcome import InputError
from grazing.plot import raster
from tests.plot import results


def names(legend):
    return [text.get_text() for text in legend.get_texts()]


def test_equal_exponents_are_both_seen():
    """A pair of complex multipliers gives two equal exponents: the second was hidden under the first."""
    P = gz.stroboscopic_map(gz.pinball(alpha=0.1, d=2.0, V=0.4))  # a free motion: both are -alpha T/2
    first, second = plot.lyapunov(gz.lyapunov(P, "d", [2.0, 2.1], starts=3))["exponents"]
    assert np.allclose(first.get_ydata(), second.get_ydata(), rtol=1e-6)
    assert second.get_markersize() > 1.5 * first.get_markersize() and second.get_zorder() < first.get_zorder()


def test_starts_without_exponents_are_counted():
    """Where all orbits ended the axes were empty without a word; many maps have no wall that they could touch."""
    result = results.lyapunov(starts=3)
    assert plot.lyapunov(result)["note"].get_text() == "1 of 360 starts have none: they ended or have no derivative"
    assert plot.lyapunov(results.lyapunov(infinite=False))["note"] is None


def test_all_starts_and_indices_are_drawn():
    result = results.lyapunov(starts=3, count=2, infinite=False)
    drawn = plot.lyapunov(result)
    assert len(drawn["exponents"]) == 2
    for k, line in enumerate(drawn["exponents"]):
        x, y = line.get_data()
        assert x.tolist() == np.repeat(result["r"].values, 3).tolist()
        assert np.array_equal(y, result["exponent"].values[:, :, k].ravel())
        assert line.get_linestyle() == "None"
    assert drawn["infinite"] == {}
    assert drawn["zero"].get_ydata()[0] == 0.0
    ax = drawn["zero"].axes
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("r", "Lyapunov exponents per step")
    low, high = ax.get_ylim()
    assert low < result["exponent"].min() < result["exponent"].max() < high


def test_one_start_is_a_line():
    result = results.lyapunov(starts=1, count=1, infinite=False)
    drawn = plot.lyapunov(result, per="time")
    (line,) = drawn["exponents"]
    assert line.get_linestyle() == "-"
    assert np.array_equal(line.get_ydata(), result["exponent_per_time"].values[:, 0, 0])
    assert line.axes.get_ylabel() == "Lyapunov exponent per unit of time"
    assert names(drawn["legend"]) == ["chaos: greatest > 0"]


def test_minus_infinity_has_a_row_below_everything():
    result = results.lyapunov(starts=2, count=2)
    drawn = plot.lyapunov(result)
    gone = np.isneginf(result["exponent"].values)
    assert list(drawn["infinite"]) == [0, 1]
    for k, marks in drawn["infinite"].items():
        assert marks.get_xdata().tolist() == result["r"].values[gone[:, :, k].any(1)].tolist()
        assert 0.0 < marks.get_ydata()[0] < 0.1  # in shares of the axes
    ax = drawn["zero"].axes
    low, high = ax.get_ylim()
    finite = result["exponent"].values[np.isfinite(result["exponent"].values)]
    assert (finite.min() - low) / (high - low) > 0.1
    assert min(ax.get_yticks()) >= low + 0.1 * (high - low)
    assert names(drawn["legend"])[-1] == r"$-\infty$: completed chatter or rest"


def test_nothing_finite():
    result = results.lyapunov(np.array([1.0, 2.0]), starts=1, count=1)
    result["exponent"][:] = -np.inf
    drawn = plot.lyapunov(result)
    assert drawn["chaos"] == []
    plot.rendered(drawn, "png")
    result["exponent"][:] = np.nan
    assert plot.lyapunov(result)["legend"] is None


def test_chaos_is_shaded_where_an_exponent_is_positive():
    result = results.lyapunov(np.linspace(0.0, 1.0, 5), starts=2, count=1, infinite=False)
    result["exponent"][:, :, 0] = [[-1.0, -1.0], [0.5, -1.0], [0.5, np.nan], [np.nan, np.nan], [5e-4, -1.0]]
    bands = plot.lyapunov(result)["chaos"]
    assert [(band.get_x(), band.get_width()) for band in bands] == [pytest.approx((0.125, 0.5))]
    assert len(plot.lyapunov(result, positive=0.0)["chaos"]) == 2


@pytest.mark.parametrize("values", [np.linspace(1.0, 2.0, 901), np.geomspace(1e-3, 1.0, 901)])
def test_no_more_bands_are_drawn_than_a_page_has_dots(values, monkeypatch):
    """One for each of 50,000 runs took a minute, and minutes in SVG."""
    monkeypatch.setattr(raster, "DOTS", 30)
    result = results.lyapunov(values, starts=1, count=1, infinite=False)
    result["exponent"][:, 0, 0] = np.where(np.arange(901) % 2, 0.5, -0.5)
    result["exponent"][300:600, 0, 0] = -0.5
    bands = plot.lyapunov(result)["chaos"]
    found = [(band.get_x(), band.get_x() + band.get_width()) for band in bands]
    wanted = [(values[1], values[299]), (values[601], values[899])]
    assert found == [pytest.approx(pair, rel=5e-3) for pair in wanted]


def test_chaos_is_shaded_and_labelled_in_any_unit_of_time():
    """A threshold in exponents per unit of time shaded nothing in milliseconds, and the axis did not say the unit."""
    result = results.lyapunov()
    result["exponent_per_time"] = result["exponent_per_time"] * 1e-6
    result["exponent_per_time"].attrs["units"] = "1/ms"
    per_step, per_time = (plot.lyapunov(result, per=per) for per in ("step", "time"))
    seen = [[band.get_extents().intervalx.tolist() for band in drawn["chaos"]] for drawn in (per_step, per_time)]
    assert seen[0] == seen[1] != []
    assert per_time["figure"].axes[0].get_ylabel() == "Lyapunov exponents per unit of time (1/ms)"
    assert per_step["figure"].axes[0].get_ylabel() == "Lyapunov exponents per step"


def test_many_marks_are_pixels_in_vector_files():
    many = results.lyapunov(np.linspace(3.4, 4.0, 500), starts=8)
    assert all(line.get_rasterized() for line in plot.lyapunov(many)["exponents"])
    assert not any(line.get_rasterized() for line in plot.lyapunov(results.lyapunov())["exponents"])


def test_what_is_refused():
    with pytest.raises(InputError, match="per is 'year'; allowed are 'step', 'time'"):
        plot.lyapunov(results.lyapunov(), per="year")
    with pytest.raises(InputError, match=r"lyapunov finds no exponent_per_time in a result with exponent"):
        plot.lyapunov(results.lyapunov().drop_vars("exponent_per_time"), per="time")
    with pytest.raises(InputError, match=r"finds exponent on \(mu, l, rank\); allowed .*\(<parameter>, start, index\)"):
        plot.lyapunov(results.chart())
