import math

import mpmath
import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from grazing import theory
from grazing.outcome import OutsideForm
from tests.examples import examples
from tests.theory.naive import GAPS, LAMS, PERIODS, gap_map, product_of_slopes, true_right_point, word

SHARES = st.floats(0.01, 0.99)


def inside(N, lam, l, share):
    """A value of mu at the given share of the interval of existence, cut at l + 3 for N = 1."""
    low, high = theory.existence_interval(N, lam, l)
    return low + share * (min(high, l + 3) - low)


def test_figure_3_1():
    points = theory.maximal_orbit(3, 0.8, 0.5, 1.0)
    assert points == pytest.approx([-1.0060750571, -0.3048600457, 0.2561119634], abs=5e-11)
    assert theory.multiplier(3, 0.8, 0.5, 1.0) == pytest.approx(-0.632317, abs=5e-7)


@settings(deadline=None)
@given(N=PERIODS, lam=LAMS, l=GAPS, share=SHARES)
def test_the_points_are_an_orbit_of_the_map_with_the_word(N, lam, l, share):
    mu = inside(N, lam, l, share)
    points = theory.maximal_orbit(N, lam, mu, l)
    assert points.shape == (N,) and points.dtype == np.float64
    assert np.all(np.diff(points) > 0)
    assert "".join("L" if x < 0 else "R" for x in points) == "L" * (N - 1) + "R"
    for here, following in zip(points, np.roll(points, -1), strict=True):
        image = gap_map(here, lam, mu, l)
        assert image == pytest.approx(following, abs=1e-12 * (abs(following) + mu + l))


@settings(deadline=None, max_examples=examples(40))
@given(N=PERIODS, lam=LAMS, l=GAPS, share=SHARES)
def test_the_right_point_and_the_multiplier_at_high_precision(N, lam, l, share):
    mu = inside(N, lam, l, share)
    with mpmath.workdps(50):
        truth = true_right_point(N, lam, mu, l)
        sensitivity = 1 + l / lam ** (N - 1)  # relative loss in C = K mu - c l
        assert theory.maximal_orbit(N, lam, mu, l)[-1] == pytest.approx(float(truth), rel=1e-13 * sensitivity)
        turn = -(mpmath.mpf(lam) ** (N - 1)) / (2 * mpmath.sqrt(truth))
        assert theory.multiplier(N, lam, mu, l) == pytest.approx(float(turn), rel=1e-13 * sensitivity)


@settings(deadline=None)
@given(N=PERIODS, lam=LAMS, l=GAPS, share=SHARES)
def test_the_multiplier_is_the_product_of_slopes_and_says_the_side_of_the_doubling(N, lam, l, share):
    mu = inside(N, lam, l, share)
    turn = theory.multiplier(N, lam, mu, l)
    assert turn == pytest.approx(product_of_slopes(theory.maximal_orbit(N, lam, mu, l), lam), rel=1e-9)
    doubling = theory.mu_pd(N, lam, l)
    assume(abs(mu / doubling - 1) > 1e-9)
    assert (turn > -1) == (mu > doubling)


@pytest.mark.parametrize(
    ("N", "lam", "l"), [(2, 0.3, 0.0), (3, 0.9, 0.0), (5, 0.9, 0.4), (9, 0.6, 1.5), (40, 0.9, 0.8)]
)
def test_beyond_either_end_the_word_is_lost(N, lam, l):
    low, high = theory.existence_interval(N, lam, l)
    width = high - low
    with mpmath.workdps(60):
        # just above mu_bc the pass still has a fixed point, but its last point left of the border is not
        x = true_right_point(N, lam, high + 1e-6 * width, l)
        assert (x - (high + 1e-6 * width)) / lam > 0
        x = true_right_point(N, lam, high - 1e-6 * width, l)
        assert (x - (high - 1e-6 * width)) / lam < 0
    assert theory.maximal_orbit(N, lam, high - 1e-6 * width, l)[-2:].prod() < 0
    with pytest.raises(OutsideForm, match=r"x_\(N-1\) < 0 fails; it needs mu < mu_bc = "):
        theory.maximal_orbit(N, lam, high + 1e-6 * width, l)
    with pytest.raises(OutsideForm, match="x_N > 0 fails; it needs mu > mu_gr = "):
        theory.maximal_orbit(N, lam, low - 1e-6 * width, l)
    assert theory.multiplier(N, lam, low + 1e-6 * width, l) < -10


def test_the_ends_themselves_are_outside():
    for mu in (0.0, 1.0):  # N = 2, l = 0: mu_gr and mu_bc, both exact
        with pytest.raises(OutsideForm):
            theory.multiplier(2, 0.5, mu, 0.0)
    with pytest.raises(OutsideForm) as caught:
        theory.maximal_orbit(1, 0.5, 0.25, 0.25)
    where, why = str(caught.value).split(": ")
    assert where == "no maximal orbit of period N = 1 at lam = 0.5, mu = 0.25, l = 0.25"
    assert why == "x_N > 0 fails; it needs mu > mu_gr = 0.25"


def test_period_1_exists_for_every_large_mu():
    for mu in (1.0, 10.0, 1e8):
        (x,) = theory.maximal_orbit(1, 0.5, mu, 0.2)
        assert gap_map(x, 0.5, mu, 0.2) == pytest.approx(x, rel=1e-12)
        assert math.isclose(theory.multiplier(1, 0.5, mu, 0.2), -0.5 / math.sqrt(x))


def test_long_orbits_keep_their_small_points_exact():
    N, lam, l = 120, 0.8, 0.5
    mu = sum(theory.stability_interval(N, lam, l)) / 2
    points = theory.maximal_orbit(N, lam, mu, l)
    assert lam * points[-2] + mu == pytest.approx(points[-1], rel=1e-6, abs=1e-12 * mu)
    assert word(points[0], N, lam, mu, l) == "L" * (N - 1) + "R"


@pytest.mark.parametrize(("N", "lam", "mu", "l"), [(2, 2.0e-12, 0.97, 0.0), (2, 1e-6, 3e-4, 0.5), (3, 0.6, 0.1, 0.0)])
def test_points_keep_their_digits_at_small_slopes(N, lam, mu, l):
    """At lam = 2e-12 the least point was off by 2e-5: backwards alone it cancels, and is divided by lam."""
    with mpmath.workdps(60):
        a, m, gap = map(mpmath.mpf, (lam, mu, l))
        c = a ** (N - 1)
        s = (-c + mpmath.sqrt(c * c + 4 * (m * (1 - a**N) / (1 - a) - c * gap))) / 2
        exact = [m - gap - s]
        for _ in range(N - 1):
            exact.append(a * exact[-1] + m)
        np.testing.assert_allclose(theory.maximal_orbit(N, lam, mu, l), np.array(exact, float), rtol=2e-14)
