"""Figures in a notebook: shown where they are the last line, and never twice."""

import inspect

import pytest
from matplotlib import pyplot
from matplotlib.backend_bases import FigureManagerBase

import grazing as gz
from grazing.plot.drawn import Drawn

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
    for name in {*gz.plot.__all__} - helps - {"styled"}:
        draw = getattr(gz.plot, name)
        assert inspect.unwrap(draw) is not draw, name
