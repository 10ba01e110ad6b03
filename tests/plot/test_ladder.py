"""Errors are lines of the numbers in the result, windows bars between their edges."""

import numpy as np
import pytest
import xarray as xr

from grazing import plot
from grazing.outcome import InputError
from grazing.plot.ladder import CALLED, LOOKS, ladder
from tests.plot import results

RUNGS = list(LOOKS)


def made_up(graze=1.0, periods=(2, 3, 4), crossing=False):
    """A ladder whose windows shrink by 0.3, and whose errors fall rung by rung."""
    N = np.array(periods)
    away = 0.3**N
    low, high = graze - away, graze - 0.4 * away
    if crossing:
        high = graze + 0.1 * away
    flow = np.stack([low, high], axis=-1)
    edge = np.stack([flow + 10.0 ** -(k + 2.0) * away[:, None] ** 1.5 for k in range(5)] + [flow])
    dims = ("rung", "N", "side")
    order = np.full((6, 2), 1.5)
    order[0], order[1] = 12.0, np.nan
    result = xr.Dataset(
        {
            "edge": (dims, edge, {"symbol": "d"}),
            "error": (dims, edge - edge[-1]),
            "step": (dims, np.concatenate([edge[:-1] - edge[1:], np.zeros_like(edge[-1:])])),
            "distance": (dims[1:], np.abs(edge[-1] - graze)),
            "order": (("rung", "side"), order),
            "order_error": (
                ("rung", "side"),
                np.array([[2.0], [np.nan], [0.03], [0.004], [0.0], [np.nan]]).repeat(2, 1),
            ),
            "step_order": (("rung", "side"), np.full((6, 2), np.nan)),
            "step_order_error": (("rung", "side"), np.full((6, 2), np.nan)),
        },
        {"rung": RUNGS, "N": N, "side": ["low", "high"]},
        {**results.ATTRS, "graze": graze, "parameter": "d"},
    )
    return result


@pytest.mark.parametrize("by", ["error", "step"])
@pytest.mark.parametrize("against", ["distance", "N"])
def test_lines_are_the_numbers(by, against):
    result = made_up()
    drawn = ladder(result, by=by, side="low", against=against)
    assert list(drawn["lines"]) == RUNGS[:-1]  # the flow has no error
    x = result.distance.sel(side="low") if against == "distance" else result.N
    for rung, line in drawn["lines"].items():
        assert line.get_xdata() == pytest.approx(x.values)
        assert line.get_ydata() == pytest.approx(np.abs(result[by].sel(rung=rung, side="low").values))
    ax = drawn["lines"]["gap"].axes
    assert ax.get_yscale() == "log" and ax.get_xscale() == ("log" if against == "distance" else "linear")
    assert drawn["provenance"]["title"] == "made up"


def test_the_legend_gives_measured_orders_with_their_uncertainty():
    drawn = ladder(made_up())
    texts = {text.get_text() for text in drawn["legend"].get_texts()}
    assert texts == {
        "gap map  12.0",
        "linearised map",
        "lowest order  1.50(3)",
        "full order  1.500(4)",
        "corrected  1.500",
    }
    assert drawn["legend"].get_texts()[0].get_text() == "gap map  12.0"  # in the order in which they end
    assert ladder(made_up(), by="step")["legend"].get_title().get_text() == "rung"
    inside = ladder(made_up(), legend=False)["legend"]
    assert {text.get_text() for text in inside.get_texts()} == texts


def test_bars_lie_between_the_edges():
    result = made_up()
    bars = ladder(result, by="windows")["bars"]
    assert set(bars) == {(rung, N) for rung in RUNGS for N in (2, 3, 4)}
    for (rung, N), bar in bars.items():
        ends = sorted(np.abs(result.edge.sel(rung=rung, N=N).values - 1.0))
        assert (bar.get_x(), bar.get_x() + bar.get_width()) == pytest.approx(ends)
    ax = bars["gap", 2].axes
    assert ax.get_xscale() == "log" and ax.get_xlim()[0] > ax.get_xlim()[1]  # the graze is to the right
    assert [text.get_text() for text in ax.get_yticklabels()] == [CALLED[rung] for rung in RUNGS]


def test_windows_on_both_sides_of_the_graze_are_drawn_over_the_parameter():
    result = made_up(crossing=True)
    bars = ladder(result, by="windows")["bars"]
    ax = bars["flow", 2].axes
    assert ax.get_xscale() == "linear"
    assert bars["flow", 2].get_x() == pytest.approx(result.edge.sel(rung="flow", N=2, side="low").item())
    assert ax.get_xlabel() == "$d$"


def test_windows_that_are_missing_or_have_no_end():
    result = made_up()
    result.edge[0, 0] = np.nan
    result.edge[1, 0, 0] = np.nan
    bars = ladder(result, by="windows")["bars"]
    assert ("gap", 2) not in bars
    right = bars["linearised", 2]
    assert right.get_x() + right.get_width() == pytest.approx(max(right.axes.get_xlim()))


@pytest.mark.parametrize("by", ["error", "windows"])
@pytest.mark.parametrize("kind", ["png", "pdf", "svg"])
def test_it_can_be_written(by, kind):
    assert plot.rendered(ladder(made_up(), by=by), kind)


def test_axes_given():
    _fig, (ax,) = plot.panels(80, 60)
    assert ladder(made_up(), ax)["lines"]["gap"].axes is ax


def test_what_is_refused():
    with pytest.raises(InputError, match="by is 'errors'; allowed are 'error', 'step', 'windows'"):
        ladder(made_up(), by="errors")
    with pytest.raises(InputError, match="side is 'upper'"):
        ladder(made_up(), side="upper")
    with pytest.raises(InputError, match="against is 'mu'"):
        ladder(made_up(), against="mu")
    with pytest.raises(InputError, match=r"plot.ladder finds no edge .* grazing\.ladder returns"):
        ladder(results.chart())
    none = made_up()
    with pytest.raises(InputError, match="finds no error on the high side"):
        ladder(none.assign(error=none.error * np.nan))
    with pytest.raises(InputError, match="finds no window on any rung"):
        ladder(none.assign(edge=none.edge * np.nan), by="windows")


@pytest.mark.parametrize("by", ["error", "step"])
def test_an_error_of_nothing_is_on_the_lower_edge(by):
    result = made_up()
    result[by].loc[{"rung": "corrected"}] = 0.0
    result[by].loc[{"rung": "full", "N": 3}] = 0.0
    drawn = ladder(result, by=by)
    assert {rung: len(line.get_xdata()) for rung, line in drawn["zeros"].items()} == {"full": 1, "corrected": 3}
    ax = drawn["lines"]["gap"].axes
    (x, y), box = drawn["zeros"]["full"].get_transform().transform(drawn["zeros"]["full"].get_xydata())[0], ax.bbox
    assert y == pytest.approx(box.y0) and box.x0 < x < box.x1
    assert len(drawn["lines"]["corrected"].get_xdata()) == 0 and len(drawn["lines"]["full"].get_xdata()) == 2
    assert [text.get_text() for text in drawn["legend"].get_texts()][-1] == "0"
