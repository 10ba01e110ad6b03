"""Options of figures: what is absurd is refused in words, in every function."""

from inspect import signature

import numpy as np
import pytest
import xarray as xr

import grazing as gz
from grazing.plot.options import NUMBERS, WHOLE, option
from tests.plot import results

WRONG = (np.nan, 1e-400j, "x", [], {}, (1, 2), object(), np.array([1.0, 2.0]), "\ud800")


def options():
    """Each option of each function of a figure; a film checks its own."""
    for name in gz.plot.__all__:
        for one in signature(getattr(gz.plot, name)).parameters.values():
            if name != "animate" and one.kind is not one.VAR_KEYWORD:
                yield one


def test_every_option_that_is_a_number_has_a_range():
    """Drawing options went to matplotlib and NumPy as they were, and came back as their errors."""
    for one in options():
        kind = str(one.annotation).removesuffix(" | None")
        assert kind != "float" or one.name in NUMBERS, one
        assert kind != "int" or one.name in WHOLE, one


def test_absurd_options_are_refused_in_words():
    for one in options():
        kind = str(one.annotation)
        if not kind.startswith(("Axes", "bool", "float", "int")) and one.name not in ("colour", "cmap"):
            continue
        for value in WRONG:
            with pytest.raises(gz.InputError, match=one.name):
                option(one.name, value, kind)
        if one.default is not one.empty:
            assert option(one.name, one.default, kind) == one.default


MOTION = xr.Dataset(
    {"u": ("t", [0.0, 1.0]), "v": ("t", [1.0, 0.0]), "impact_time": ("impact", [0.5])}, {"t": [0.0, 1.0]}
)
SCAN = xr.Dataset({"u": (("d", "start", "n"), np.zeros((1, 1, 2))), "period": (("d", "start"), [[1]])}, {"d": [0.1]})
LINES = xr.Dataset({"amplitude": ("frequency", [1.0, 2.0]), "order": ("frequency", [0.0, 1.0])})


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda: gz.plot.figure(width=-3), "width = -3; allowed is 1 <= width <= 1200"),
        (lambda: gz.plot.figure(height="x"), "height = 'x' is not a real number"),
        (lambda: gz.plot.panels(rows=0), "rows = 0; allowed is a whole number >= 1"),
        (lambda: gz.plot.panels(columns=10**6), "columns = 1000000; allowed is a whole number from 1 to 20"),
        (lambda: gz.plot.panels(nonsense=1), "panels: .*nonsense"),
        (lambda: gz.plot.period_colour("x"), "N = 'x'"),
        (lambda: gz.plot.zdm(xr.Dataset()), "cannot draw a Dataset; allowed is what gz.zdm_points returns"),
        (lambda: gz.plot.map_graph(xr.Dataset()), "cannot draw a Dataset; allowed is what plot.graph_of returns"),
        (lambda: gz.plot.graph_of(gz.gap_map(0.8, 0.5, 1.0), 10**30), r"values have shape \(\)"),
        (lambda: gz.plot.graph_of(gz.gap_map(0.8, 0.5, 1.0), [0.0], "z"), "'z' is no coordinate .*; allowed are x"),
        (lambda: gz.plot.graph_of(gz.gap_map(0.8, 0.5, 1.0), [0.0], z=1.0), "fixed has 'z'"),
        (lambda: gz.plot.history(MOTION, of=np.array(["u", "v"])), "of = .*; allowed are u"),
        (lambda: gz.plot.spectrum(LINES, over=np.array(["order"])), "over is .*; allowed are 'frequency', 'order'"),
        (lambda: gz.plot.history(MOTION, 3), "ax is 3; allowed are axes of matplotlib"),
        (lambda: gz.plot.history(MOTION, colour="no such"), "colour is 'no such'; allowed is a colour of matplotlib"),
        (lambda: gz.plot.windows({2: (0.1, 0.2)}, shade=3.0), "shade = 3; allowed is 0 <= shade <= 1"),
        (lambda: gz.plot.trajectory(MOTION, strobe=[1.0]), "strobe is .*; give states"),
        (lambda: gz.plot.trajectory(MOTION, strobe="x"), "strobe is 'x'; give states"),
        (lambda: gz.plot.orbit_diagram(SCAN, coordinate="v"), "coordinate is 'v'; allowed are 'u'"),
        (lambda: gz.plot.density(results.density(bins=5), norm=np.ones(2)), "norm is .*; allowed are 'eqhist'"),
        (lambda: gz.plot.density(results.density(bins=5), cmap="no such"), "cmap is 'no such'; allowed is a colormap"),
        (lambda: gz.plot.windows({2: (0.1, 0.2)}, names=3), "names is 3; allowed are True and False"),
        (lambda: gz.plot.cobweb(gz.gap_map(0.8, 0.5, 1.0), ["a"]), "the points of an orbit are no numbers"),
    ],
)
def test_what_is_no_figure_is_said(call, said):
    with pytest.raises(gz.InputError, match=said):
        call()
