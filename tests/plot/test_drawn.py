"""Figures in a notebook: shown where they are the last line, and never twice."""

import inspect

import numpy as np
import pytest
import xarray as xr
from matplotlib import pyplot
from matplotlib.backend_bases import FigureManagerBase

import grazing as gz
from grazing.plot.drawn import Drawn
from tests.plot import results

GAP = gz.gap_map(lam=0.5, mu=0.05, l=0.1)
PNG = b"\x89PNG\r\n"


@pytest.fixture(scope="module")
def motion():
    return gz.trajectory(gz.pinball(d=0.12, V=0.4), (0.1, 0.0), until=20.0)


def test_what_is_drawn_shows_its_figure(motion):
    drawn = gz.plot.trajectory(motion)
    assert isinstance(drawn, dict) and isinstance(drawn, Drawn) and drawn["figure"].axes
    assert drawn._repr_png_().startswith(PNG) and drawn["figure"]._repr_png_().startswith(PNG)
    assert drawn._repr_png_() == gz.plot.trajectory(motion)["figure"]._repr_png_()
    assert repr(drawn) == "<Drawn: figure, flights, impacts, strobe, wall>"


def test_a_figure_of_pyplot_is_not_shown_twice(motion):
    figure, ax = pyplot.subplots()
    assert isinstance(figure.canvas.manager, FigureManagerBase)
    assert gz.plot.trajectory(motion, ax)._repr_png_() is None
    pyplot.close(figure)


def test_a_panel_of_ours_shows_the_whole_figure(motion):
    figure, (left, _right) = gz.plot.panels(columns=2)
    assert gz.plot.trajectory(motion, left)._repr_png_() == figure._repr_png_()


def test_every_function_of_a_figure_returns_what_is_shown():
    helps = {"figure", "graph_of", "panels", "period_colour", "provenance", "provenance_of", "rendered", "save"}
    helps |= {"animate"}  # it writes a film
    for name in {*gz.plot.__all__} - helps - {"styled"}:
        draw = getattr(gz.plot, name)
        assert inspect.unwrap(draw) is not draw, name


@pytest.mark.parametrize("name", ["basins", "chart", "coexistence", "lyapunov", "orbit_diagram"])
def test_axes_that_are_given_get_no_legend_unless_it_is_asked_for(name):
    result = gz.orbit_diagram(GAP, "mu", [0.04, 0.07]) if name == "orbit_diagram" else getattr(results, name)()
    draw = getattr(gz.plot, name)
    assert draw(result)["legend"] is not None
    for more, there in (({}, False), ({"legend": None}, False), ({"legend": True}, True)):
        _figure, (ax,) = gz.plot.panels()
        assert (draw(result, ax=ax, **more)["legend"] is not None) == there == (ax.get_legend() is not None)


def test_every_legend_beside_is_left_out_of_given_axes():
    for name in gz.plot.__all__:
        given = inspect.signature(getattr(gz.plot, name)).parameters.get("legend")
        assert given is None or given.default is None or name == "ladder", name  # a ladder has one inside, else


def test_a_branch_goes_on_with_the_legend_that_is_there():
    P = gz.stroboscopic_map(gz.pinball(V=0.4))
    orbit = gz.periodic_orbits(P.replace(d=0.1), word="001", starts=50)[0]
    branch = gz.continuation(P, orbit, "d", (0.09, 0.12))
    _figure, (ax,) = gz.plot.panels()
    gz.plot.branch(branch, ax)
    assert ax.get_legend() is None
    ax.plot([0.1], [0.0], label="mine")
    ax.legend()
    gz.plot.branch(branch, ax)
    assert "mine" in [text.get_text() for text in ax.get_legend().get_texts()]
    assert len(ax.get_legend().get_texts()) > 1


def test_of_a_periodic_orbit_the_points_that_came_last_are_drawn():
    """Of an orbit of period 2 that is on its way, all points were drawn in its colour, as if it went there."""
    n = np.arange(40)
    u = np.stack([0.5 * (-1.0) ** n + 0.9**n, np.cos(n * n)])[None]
    data = {"u": (("a", "start", "n"), u), "period": (("a", "start"), np.array([[2, -1]], np.int32))}
    drawn = gz.plot.orbit_diagram(xr.Dataset(data, {"a": [1.0]}))["points"]
    assert sorted(drawn[2].get_ydata()) == pytest.approx(sorted(u[0, 0, -2:]), abs=1e-3)
    assert len(drawn[0].get_ydata()) > 30


@pytest.mark.parametrize("count", [2, 5, 40, 2000])
def test_the_outermost_columns_are_seen_whole(count):
    values = np.linspace(2.0, 4.0, count)
    u = np.zeros((count, 1, 2))
    data = {"u": (("a", "start", "n"), u), "period": (("a", "start"), np.ones((count, 1), np.int32))}
    drawn = gz.plot.orbit_diagram(xr.Dataset(data, {"a": values}))
    ax, figure = drawn["figure"].axes[0], drawn["figure"]
    figure.canvas.draw()
    radius = 0.5 * drawn["points"][1].get_markersize() * figure.dpi / 72.0
    low, high = (ax.transData.transform((end, 0.0))[0] for end in (2.0, 4.0))
    box = ax.get_window_extent()
    assert low - box.x0 >= radius and box.x1 - high >= radius
    assert low - box.x0 <= 0.025 * box.width


def test_outermost_columns_are_whole_on_a_logarithmic_axis():
    G = gz.gap_map(lam=0.34, mu=0.01, l=0.21)
    result = gz.orbit_diagram(G, "mu", np.geomspace(1e-4, 1e-2, 21), starts=3, transient=50, keep=4)
    _figure, ax = pyplot.subplots()
    ax.set_xscale("log")
    gz.plot.orbit_diagram(result, ax)
    low, high = ax.get_xlim()
    assert 1e-4 / low == pytest.approx(high / 1e-2) == pytest.approx(100.0**0.02)


def test_points_are_thinned_by_what_is_drawn():
    result = gz.orbit_diagram(GAP, "mu", [0.04, 0.07], starts=2, keep=6, transient=50)
    result["period"][:] = 2
    result["x"][:] = np.array([1e6, 0.0, 0.0, 0.0, 0.1, 0.2])  # only the last two are drawn
    assert len(gz.plot.orbit_diagram(result)["points"][2].get_xdata()) == 4
    result["x"][:] = 1.0 + np.array([0.0, 0.0, 0.0, 0.0, 1.0, 2.0]) * np.finfo(float).eps
    assert len(gz.plot.orbit_diagram(result)["points"][2].get_xdata()) == 4


def test_a_thick_line_of_a_locus_ends_where_it_begins():
    table = xr.Dataset(
        {
            "mu": ("point", np.arange(5.0)),
            "l": ("point", np.arange(5.0)),
            "admissible": ("point", [0, 1, 1, 0, 1]),
            "meeting_type": ("meeting", np.array([], str)),
        },
        attrs={"parameters": '["mu", "l"]', "type": "pd"},
    )
    thick, _thin = gz.plot.locus(table)["lines"]
    assert np.isnan(thick.get_xdata()).tolist() == [True, False, False, False, False]
