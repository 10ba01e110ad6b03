"""Cells are where their values are."""

import numpy as np
import pytest

import grazing as gz
from grazing import plot
from grazing.plot.raster import edges_of, is_even, ordered, raster, refined
from tests.plot import results


def test_edges_lie_halfway():
    assert edges_of(np.array([2.0])).tolist() == pytest.approx([1.9, 2.1])
    assert edges_of(np.array([0.0])).tolist() == [-0.05, 0.05]
    _fig, (ax,) = plot.panels()
    ax.set_xscale("log")
    assert edges_of(np.array([1.0, 10.0, 100.0]), ax.xaxis) == pytest.approx(10.0 ** np.array([-0.5, 0.5, 1.5, 2.5]))
    assert edges_of(np.array([1.0, 3.0]), ax.yaxis).tolist() == [0.0, 2.0, 4.0]


@pytest.mark.parametrize("values", [[-1e308, 1.7e308], [1e-250, 1.7e308]])
def test_values_too_large_for_edges_are_refused(values):
    with pytest.raises(gz.InputError, match=r"to 1.7e\+308 cannot be drawn: they are too large"):
        edges_of(np.array(values))


def test_values_are_ordered_and_distinct():
    values, where = ordered([3.0, 1.0, 3.0, 2.0])
    assert (values.tolist(), where.tolist()) == ([1.0, 2.0, 3.0], [1, 3, 0])


def test_even_cells_are_an_image_others_a_mesh():
    cells = np.arange(6.0).reshape(3, 2)
    even, uneven = np.arange(4.0), np.array([0.0, 1.0, 2.0, 4.0])
    assert is_even(np.linspace(0.1, 0.7, 1001))
    _fig, (ax,) = plot.panels()
    image = raster(ax, even, np.arange(3.0), cells)
    assert np.array_equal(image.get_array(), cells.T)
    assert image.get_extent() == [0.0, 3.0, 0.0, 2.0]
    mesh = raster(ax, uneven, np.arange(3.0), cells)
    assert np.array_equal(mesh.get_array(), cells.T)
    assert ax.get_xlim() == (0.0, 4.0)
    _fig, (ax,) = plot.panels()
    ax.set_xscale("log")
    assert not hasattr(raster(ax, even + 1.0, np.arange(3.0), cells), "get_extent")
    assert ax.get_xscale() == "log"


def test_cells_about_as_large_as_a_dot_have_several_pixels():
    _fig, (ax,) = plot.panels(85, 62)
    cells = np.ma.masked_equal(np.arange(500.0 * 10).reshape(500, 10), 3.0)
    x, y = np.linspace(0.0, 1.0, 501), np.linspace(0.0, 2.0, 11)
    fine_x, fine_y, fine = refined(ax, x, y, cells)
    times = fine.shape[0] // 500
    assert times > 1
    assert fine.shape == (500 * times, 10)  # wide cells need none
    assert np.ma.allequal(fine[::times], cells)
    assert np.ma.getmaskarray(fine).sum() == times
    assert fine_x[::times] == pytest.approx(x)
    assert fine_y == pytest.approx(y)
    uneven = x**2
    assert refined(ax, uneven, y, cells)[0] is uneven


SPACED = np.geomspace(1e-3, 1.0, 7)


@pytest.mark.parametrize("name", ["chart", "coexistence", "density", "lyapunov", "orbit_diagram"])
def test_values_spaced_in_their_logarithm_have_such_an_axis(name):
    if name == "orbit_diagram":
        G = gz.gap_map(lam=0.5, mu=0.05, l=0.1)
        result = gz.orbit_diagram(G, "mu", SPACED, starts=2, keep=4, transient=20)
    else:
        result = getattr(results, name)(**{"x" if name == "chart" else "values": SPACED})
    draw = getattr(plot, name)
    scale = [draw(result, **given)["figure"].axes[0].get_xscale() for given in ({}, {"ax": plot.panels()[1][0]})]
    assert scale == ["log", "linear"]  # axes that are given keep theirs


def test_changes_are_halfway_on_the_axis():
    result = results.coexistence(SPACED)
    drawn = plot.coexistence(result)["changes"]
    at = sorted(x for line in drawn.values() for x in line.get_xdata())
    assert at == pytest.approx(sorted(np.sqrt(result.before * result.after).values.tolist()))
