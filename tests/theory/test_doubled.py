import math

import mpmath
import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from grazing import theory
from grazing.outcome import OutsideForm
from tests.theory.naive import GAPS, LAMS, exact, gap_map, iterate, pass_of_word, product_of_slopes

PERIODS = st.integers(1, 10)
CASES = [
    (1, 0.5, 0.25),
    (1, 0.9, 0.0),
    (2, 0.5, 0.0),
    (3, 0.9, 0.0),
    (3, 0.8, 1.0),
    (5, 0.9, 0.4),
    (6, 0.4, 2.0),
]


def at(interval, share):
    return interval.low + share * interval.width


@settings(deadline=None)
@given(N=PERIODS, lam=LAMS, l=GAPS, share=st.floats(0.02, 0.98))
def test_the_points_are_an_orbit_of_twice_the_period(N, lam, l, share):
    interval = theory.doubled_interval(N, lam, l)
    assume(interval.width > 1e-9 * interval.high)
    mu = at(interval, share)
    points = theory.doubled_orbit(N, lam, mu, l)
    assert points.shape == (2 * N,)
    assert "".join("L" if x < 0 else "R" for x in points) == ("L" * (N - 1) + "R") * 2
    assert points[N - 1] < points[2 * N - 1] and points[0] == points.min()
    for here, following in zip(points, np.roll(points, -1), strict=True):
        assert gap_map(here, lam, mu, l) == pytest.approx(following, abs=1e-11 * (abs(following) + mu + l))


@settings(deadline=None)
@given(N=PERIODS, lam=LAMS, l=GAPS, share=st.floats(0.02, 0.98))
def test_its_multiplier_is_the_product_of_slopes_and_exceeds_1(N, lam, l, share):
    interval = theory.doubled_interval(N, lam, l)
    assume(interval.width > 1e-4 * interval.high)
    mu = at(interval, share)
    turn = theory.doubled_multiplier(N, lam, mu, l)
    assert turn > 1
    assert turn == pytest.approx(product_of_slopes(theory.doubled_orbit(N, lam, mu, l), lam), rel=1e-8)


@pytest.mark.parametrize(("N", "lam", "l"), CASES)
@pytest.mark.parametrize("share", [0.1, 0.5, 0.9])
def test_against_a_root_of_two_passes_at_high_precision(N, lam, l, share):
    mu = at(theory.doubled_interval(N, lam, l), share)
    points = theory.doubled_orbit(N, lam, mu, l)
    with mpmath.workdps(50):
        a, m, gap = exact(lam, mu, l)
        twice = lambda x: pass_of_word(pass_of_word(x, N, a, m, gap), N, a, m, gap)  # noqa: E731
        for x in (points[N - 1], points[2 * N - 1]):
            truth = mpmath.findroot(lambda y: twice(y) - y, exact(x * (1 - 1e-6), x * (1 + 1e-6)), solver="anderson")
            assert x == pytest.approx(float(truth), rel=1e-11)
            turn = mpmath.diff(twice, truth)
            assert theory.doubled_multiplier(N, lam, mu, l) == pytest.approx(float(turn), rel=1e-10)


@pytest.mark.parametrize(("N", "lam", "l"), CASES)
def test_it_bounds_the_basin_of_the_stable_orbit(N, lam, l):
    """Between its positive points orbits spiral in to the maximal orbit; outside they spiral out."""
    mu = at(theory.doubled_interval(N, lam, l), 0.3)
    doubled, stable = theory.doubled_orbit(N, lam, mu, l), theory.maximal_orbit(N, lam, mu, l)
    (small, great), fixed = doubled[[N - 1, 2 * N - 1]], stable[-1]
    away, near = (math.log(abs(product_of_slopes(points, lam))) for points in (doubled, stable))
    periods = math.ceil(40 / away - 30 / near)  # to leave the one and to come to the other
    assert small < fixed < great
    assert iterate(great - 1e-6 * (great - fixed), periods * N, lam, mu, l) == pytest.approx(fixed, rel=1e-9)
    out = iterate(great + 1e-6 * min(great, mu - great if N > 1 else great), 2 * N, lam, mu, l)
    assert out > great + 1e-6 * min(great, mu - great if N > 1 else great)


@pytest.mark.parametrize(("N", "lam", "l", "end"), [
    (2, 0.5, 0.0, "border collision"), (3, 0.9, 0.0, "border collision"), (3, 0.8, 0.9, "border collision"),
    (3, 0.8, 1.0, "graze"), (1, 0.5, 0.25, "graze"), (6, 0.4, 2.0, "graze"), (5, 0.9, 3.0, "graze"),
])  # fmt: skip
def test_what_ends_it(N, lam, l, end):
    interval = theory.doubled_interval(N, lam, l)
    mu = at(interval, 1 - 1e-9)
    points = theory.doubled_orbit(N, lam, mu, l)
    graze, border = points[N - 1] / points[-1], -(points[-2] / mu) if N > 1 else 1.0
    assert (graze < 1e-6) == (end == "graze")
    assert (border < 1e-6) == (end == "border collision")
    with pytest.raises(OutsideForm, match=f"mu below its {end}, "):
        theory.doubled_orbit(N, lam, at(interval, 1 + 1e-9), l)
    with pytest.raises(OutsideForm, match="two different positive points need mu > mu_pd = "):
        theory.doubled_multiplier(N, lam, at(interval, -1e-9), l)


@settings(deadline=None)
@given(N=PERIODS, lam=LAMS, l=GAPS)
def test_it_lives_inside_the_window_and_only_where_there_is_one(N, lam, l):
    doubled, stable = theory.doubled_interval(N, lam, l), theory.stability_interval(N, lam, l)
    assert doubled.empty == stable.empty
    assert stable.empty or (doubled.low == stable.low and doubled.high < stable.high)


def test_without_a_window_there_is_none():
    assert theory.doubled_interval(4, 0.9, 0.0).empty
    with pytest.raises(OutsideForm, match=r"no doubled orbit at N = 4, lam = 0.9, l = 0.0: the window of N is empty"):
        theory.doubled_orbit(4, 0.9, 0.15, 0.0)
