"""Norms are what they say: monotone, inverted by their inverse, with round ticks in their range."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.colors import LogNorm, Normalize

from grazing.plot.norms import EqHist, norm_of, round_ticks

COUNTS = st.lists(st.integers(0, 10**6), min_size=1, max_size=200)


@given(COUNTS)
def test_equalised_values_are_shares_of_those_below(counts):
    norm = EqHist(counts)
    positive = np.array([c for c in counts if c > 0])
    places = np.asarray(norm(np.unique(positive)))
    if np.unique(positive).size > 1:
        assert (np.diff(places) > 0).all()
        assert (places[0], places[-1]) == (0.0, 1.0)
        share = np.array([(positive <= c).mean() for c in np.unique(positive)])
        assert places == pytest.approx((share - share[0]) / (1.0 - share[0]))
        assert norm.inverse(places) == pytest.approx(np.unique(positive))
    assert norm.scaled()


def test_equal_ranges_of_colour_hold_equally_many_bins():
    data = np.random.default_rng(0).pareto(1.2, 100_000) + 1.0
    norm = EqHist(data)
    assert len(norm.levels) <= 1025
    assert np.histogram(norm(data), 10, (0.0, 1.0))[0] == pytest.approx(np.full(10, 10_000), rel=0.02)


def test_outside_and_masked():
    norm = EqHist([2, 4, 8])
    assert norm(np.array([1.0, 100.0])).tolist() == [-1.0, 1.0]  # below everything: the colour for that
    assert norm(np.ma.masked_less(np.array([0.0, 4.0]), 1.0)).tolist() == [None, 0.5]
    assert float(norm(4)) == 0.5
    assert EqHist([])(1.0) == 0.0
    assert EqHist([3, 3, np.nan, np.inf, -2]).vmin == 3.0


def test_norms_by_name():
    data = np.array([0.0, 1.0, 5.0, np.nan])
    assert isinstance(norm_of("eqhist", data), EqHist)
    log = norm_of("log", data)
    assert (log.vmin, log.vmax) == (1.0, 5.0)
    assert norm_of("log", np.zeros(2)).vmax > norm_of("log", np.zeros(2)).vmin
    own = Normalize()
    assert norm_of(own, data) is own


@pytest.mark.parametrize("norm", [LogNorm(0.003, 7.0), EqHist(np.geomspace(0.001, 0.7, 300)), EqHist([0.5, 0.5, 0.1])])
def test_ticks_are_round_apart_and_inside(norm):
    ticks = round_ticks(norm)
    assert len(ticks) >= 2
    places = np.array([float(norm(tick)) for tick in ticks])
    assert (np.diff(places) >= 0.07).all()
    assert all(norm.vmin <= tick <= norm.vmax for tick in ticks)
    assert all(f"{tick:e}"[0] in "1235" for tick in ticks)
