"""Bars are the windows, marks are the words' status, branches join words."""

import sys

import numpy as np
import pytest
import xarray as xr
from matplotlib.colors import to_hex

from grazing.outcome import InputError
from grazing.plot.style import figure, period_colour, rendered
from grazing.plot.tree import tree


def made_up(low=0.1, depth_one=False):
    """Words of L, LLR, LR, LRR, R: a window for three of them, an orbit for four."""
    nan = np.nan
    columns = {
        "word": ["L", "LLR", "LR", "LRR", "R"],
        "length": [1, 3, 2, 3, 1],
        "level": [0, 2, 1, 2, 0],
        "left": [-1, 0, 0, 2, -1],
        "right": [-1, 2, 4, 4, -1],
        "status": ["stable", "unstable", "stable", "virtual", "stable"],
        "low": [-np.inf, nan, low, nan, 0.8],
        "high": [0.0, nan, 0.4, nan, np.inf],
        "exists_low": [-np.inf, 0.05, 0.05, nan, 0.5],
        "exists_high": [0.0, 0.2, 0.4, nan, np.inf],
    }
    result = xr.Dataset({name: ("node", values) for name, values in columns.items()}, attrs={"title": "made up"})
    result["low"].attrs["symbol"] = r"\mu"
    return result


def span(bar):
    return bar.get_x(), bar.get_x() + bar.get_width()


def test_bars_are_windows_coloured_by_the_length_of_the_word():
    drawn = tree(made_up())
    ax = drawn["windows"]["LR"].axes
    left, right = ax.get_xlim()
    assert set(drawn["windows"]) == {"L", "LR", "R"} and set(drawn["exist"]) == {"L", "LLR", "LR", "R"}
    assert span(drawn["windows"]["LR"]) == pytest.approx((0.1, 0.4))
    assert span(drawn["exist"]["LLR"]) == pytest.approx((0.05, 0.2))
    assert span(drawn["windows"]["R"]) == pytest.approx((0.8, right))  # cut at the limits
    assert span(drawn["windows"]["L"]) == pytest.approx((left, 0.0))
    assert to_hex(drawn["windows"]["LR"].get_facecolor()) == period_colour(2)
    assert ax.get_xlabel() == r"$\mu$"


def test_marks_and_branches():
    drawn = tree(made_up())
    assert {status: len(marks.get_offsets()) for status, marks in drawn["nodes"].items()} == {
        "stable": 3,
        "unstable": 1,
        "virtual": 1,
    }
    assert len(drawn["branches"]) == 6  # two for each word that joins others
    assert [text.get_text() for text in drawn["legend"].get_texts()] == ["stable", "unstable", "virtual"]
    assert drawn["names"]["LLR"].get_color() != drawn["names"]["LR"].get_color()
    # the parents stand farther out than what joins them
    across = {row: x for marks in drawn["nodes"].values() for x, row in marks.get_offsets().tolist()}
    assert across[0] == across[4] == 2 and across[2] == 1 and across[1] == across[3] == 0


def test_limits_that_were_set_are_kept_and_a_logarithmic_axis_leaves_out_what_is_not_positive():
    ax = figure().add_subplot()
    ax.set_xlim(0.2, 0.3)
    drawn = tree(made_up(), ax, legend=False)
    assert ax.get_xlim() == (0.2, 0.3) and drawn["legend"] is None
    assert span(drawn["windows"]["LR"]) == pytest.approx((0.2, 0.3))
    drawn = tree(made_up(), log=True)
    assert drawn["windows"]["LR"].axes.get_xscale() == "log" and "L" not in drawn["windows"]


def test_long_trees_name_only_the_words_with_a_window(monkeypatch):
    monkeypatch.setattr(sys.modules["grazing.plot.tree"], "NAMED", 3)  # the package has the function by this name
    assert set(tree(made_up())["names"]) == {"L", "LR", "R"}


def test_the_same_result_gives_the_same_bytes():
    assert rendered(tree(made_up()), "png") == rendered(tree(made_up()), "png")


def test_error_texts():
    with pytest.raises(InputError, match=r"allowed is the xarray.Dataset that grazing.adding_tree returns"):
        tree({"word": []})
    with pytest.raises(InputError, match="finds no status"):
        tree(made_up().drop_vars("status"))
