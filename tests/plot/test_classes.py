"""Colours and names of classes are those of the documentation, in every figure."""

import re
from pathlib import Path

import pytest

from grazing import plot
from grazing.plot.classes import (
    NAMES,
    attractor_colours,
    class_name,
    legend_beside,
    name_of,
    patches_of,
    written,
)
from grazing.plot.style import PERIODS, period_colour

PAGE = Path(__file__).parents[2] / "docs" / "figures-and-colours.md"


def test_the_page_has_the_colours_of_the_code():
    text = PAGE.read_text(encoding="utf-8")
    listed = {int(N): colour for N, colour in re.findall(r"\| (\d+) \| `(#\w{6})` \| \w+ ", text)}
    assert listed == {N: period_colour(N) for N in range(1, len(PERIODS) + 1)}
    greys = {int(code): colour for code, colour in re.findall(r"\| (-?\d) \| `(#\w{6})` \|\n", text)}
    assert greys == {code: period_colour(code) for code in NAMES}


def test_attractors_of_one_period_have_shades_that_differ():
    found = attractor_colours([1, 2, 1, 1, -1, 17])
    assert found[:2] == [PERIODS[0], PERIODS[1]]
    assert len(set(found)) == 6


@pytest.mark.parametrize(
    ("word", "text"),
    [
        ("LLR", "LLR"),
        ("LLLLR", r"$\mathrm{L}^{4}\mathrm{R}$"),
        ("0(12)(12)(12)(12)", r"$\mathrm{0}\mathrm{(12)}^{4}$"),
        ("LR" * 10, "LR" * 10),
        ("LR" * 20, "LR" * 12 + "\n" + "LR" * 8),
        ("LR" * 50, "\n".join(["LR" * 12] * 3) + "… (100 letters)"),
        ("(BBAA)" * 3, r"$\mathrm{(BBAA)}^{3}$"),
        ("(BBAA)(BBA)" * 3, "\n".join(["(BBAA)(BBA)" * 2, "(BBAA)(BBA)"])),
        ("LR" * 6, "LRLRLRLRLRLR"),
        ("", ""),
    ],
)
def test_words(word, text):
    assert written(word) == text


def test_names():
    assert class_name("LLR", 6) == "LLR, period 6"
    assert class_name("", 3) == "period 3"
    assert class_name("", -1) == "aperiodic"
    assert [name_of(code) for code in (0, -2, -9)] == ["undecided", "ended", "class -9"]


def test_entries_are_in_order_and_what_is_unused_is_left_out():
    assert [entry.get_label() for entry in patches_of([0, 2, -3, -1, 1, 2])] == ["1", "2", "aperiodic", "undecided"]


def test_a_legend_is_no_longer_than_its_axes():
    _fig, (ax,) = plot.panels(85, 62)
    assert legend_beside(ax, patches_of(range(1, 5)))._ncols == 1
    assert legend_beside(ax, patches_of(range(1, 17)))._ncols == 2
