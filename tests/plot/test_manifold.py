"""Manifolds are drawn in pieces, alone or on top of basins, with the saddle and a legend that is added to."""

import numpy as np
import pytest
import xarray as xr

from grazing import plot
from grazing.outcome import InputError
from grazing.plot.manifold import IMAGE, PAPER, manifolds
from tests.plot import results


def made(side="stable", word="01"):
    """Two pieces with a cut between them, and one without a cut."""
    s = np.linspace(0.0, 1.0, 20)
    one = np.column_stack([-0.4 + 0.3 * s, 0.2 * s])
    two = np.column_stack([0.1 * s, 0.4 + 0.3 * s**2])
    three = np.column_stack([0.05 * s, -0.1 - 0.2 * s])
    gap = np.full((1, 2), np.nan)
    piece = np.repeat([0, 0, 1, 1, 2], [20, 1, 20, 1, 20])
    return xr.Dataset(
        {
            "manifold": (("point", "coordinate"), np.concatenate([one, gap, two, gap, three])),
            "piece": ("point", piece),
            "cut_first": ("piece", np.array([False, True, False])),
            "cut_last": ("piece", np.array([True, False, False])),
            "saddle": (("saddle_index", "coordinate"), np.array([[-0.4, 0.0], [0.05, 0.3]])),
        },
        {"coordinate": ["u", "v"]},
        {**results.ATTRS, "side": side, "orbit_word": word, "box": np.array([-0.3, 1.0, -0.5, 0.6])},
    )


def names(legend):
    return [text.get_text() for text in legend.get_texts()]


def test_pieces_are_drawn_as_they_are_and_no_line_joins_them():
    result = made()
    drawn = manifolds(result)
    x, y = drawn["line"].get_data()
    assert np.array_equal(np.column_stack([x, y]), result.manifold.values, equal_nan=True)
    assert np.isnan(x).sum() == 2 and drawn["line"].get_color() == PAPER["stable"]
    ax = drawn["line"].axes
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("$u$", "$v$")
    # as far as the curve lies in its box, and a margin
    assert ax.get_xlim() == pytest.approx((-0.3 - 0.04 * 0.4, 0.1 + 0.04 * 0.4))
    assert ax.get_ylim()[1] == pytest.approx(0.6 + 0.04 * 0.9)
    assert np.array_equal(drawn["saddle"].get_xydata(), result.saddle.values)
    assert drawn["cuts"] is None and names(drawn["legend"]) == ["stable manifold", "saddle 01"]
    assert drawn["provenance"]["title"] == "made up"


def test_cuts_are_marked_on_both_sides():
    result = made("unstable")
    drawn = manifolds(result, cuts=True, saddle=False)
    assert drawn["cuts"].get_xydata().tolist() == [[0.0, 0.4], result.manifold.values[19].tolist()]
    assert drawn["saddle"] is None
    assert names(drawn["legend"]) == ["unstable manifold", "cut: the map is not smooth"]
    assert drawn["line"].get_color() == PAPER["unstable"]


def test_on_top_of_basins_limits_and_labels_stay_and_the_legend_goes_on():
    basins = plot.basins(results.basins(20))
    ax = basins["figure"].axes[0]
    before = ax.get_xlim(), ax.get_ylim(), ax.get_xlabel(), names(basins["legend"])
    one = manifolds(made("stable", "01"), ax)
    two = manifolds(made("stable", "001"), ax)
    assert (ax.get_xlim(), ax.get_ylim(), ax.get_xlabel()) == before[:3]
    assert names(two["legend"]) == [*before[3], "stable manifold", "saddle 01", "saddle 001"]
    assert two["legend"].get_title().get_text() == "word, period: share of the area"
    assert one["line"].get_color() == IMAGE["stable"]
    assert len(plot.rendered(one, "png")) > 1000


def test_without_a_legend():
    basins = plot.basins(results.basins(20))
    ax = basins["figure"].axes[0]
    assert manifolds(made(), ax, legend=False)["legend"] is None
    assert names(ax.get_legend()) == names(basins["legend"])


def test_a_result_of_another_kind_is_refused():
    with pytest.raises(InputError, match=r"plot.manifolds finds no manifold"):
        manifolds(results.basins(20))
    with pytest.raises(InputError, match=r"cannot draw a list"):
        manifolds([1.0])
