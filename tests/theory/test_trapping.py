import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from grazing import theory
from grazing.outcome import OutsideForm
from tests.examples import examples
from tests.theory.naive import GAPS, LAMS, gap_map, iterate

OFFSETS = st.just(0.0) | st.floats(1e-6, 50.0)


@settings(deadline=None, max_examples=examples(300))
@given(lam=LAMS, mu=OFFSETS, l=GAPS, share=st.floats(0, 1))
def test_the_map_takes_it_into_itself_for_every_mu(lam, mu, l, share):
    low, high = theory.trapping_interval(mu, l)
    slack = 1e-14 * (abs(low) + high)
    for x in (low + share * (high - low), low, high, 0.0, -1e-300):
        if not low <= x <= high:
            continue
        assert low - slack <= gap_map(x, lam, mu, l) <= high + slack


@settings(deadline=None)
@given(lam=st.floats(0.05, 0.95), mu=OFFSETS, l=GAPS, x=st.floats(-1e3, 1e3))
def test_every_orbit_enters_it_after_finitely_many_steps(lam, mu, l, x):
    interval = theory.trapping_interval(mu, l)
    if mu == l == 0:
        return
    # the longest climb: from the lower of x and the image of x up to 0 (or to -l, for mu = 0)
    depth = max(abs(x), abs(gap_map(x, lam, mu, l)), 1e-300)
    target = max(mu / (1 - lam), l)
    steps = 4 + math.ceil(math.log1p(depth / target) / -math.log(lam))
    x = iterate(x, steps, lam, mu, l)
    slack = 1e-12 * (abs(interval.low) + interval.high)
    assert interval.low - slack <= x <= interval.high + slack


def test_the_exception_without_offset_and_gap():
    interval = theory.trapping_interval(0.0, 0.0)
    assert 0.0 in interval and interval.width == 0.0
    assert iterate(-1.0, 500, 0.9, 0.0, 0.0) not in interval
    assert iterate(-1.0, 500, 0.9, 0.0, 0.0) == pytest.approx(0.0, abs=1e-20)


def test_at_mu_0_it_is_not_the_attractor():
    for x in (-0.7, 0.0, 3.0):
        last = iterate(x, 400, 0.8, 0.0, 0.5)
        assert -1e-30 < last < 0
    assert tuple(theory.trapping_interval(0.0, 0.5)) == (-0.5, 0.0)


@settings(deadline=None)
@given(l=GAPS, factor=st.floats(0.3, 3.0), lam=LAMS)
def test_it_reaches_across_the_border_below_the_collision_of_period_2(l, factor, lam):
    if abs(factor - 1) < 1e-9:
        return
    mu = factor * theory.mu_bc(2, lam, l)
    assert (theory.trapping_interval(mu, l).low < 0) == (factor < 1)


@pytest.mark.parametrize(("lam", "l"), [(0.5, 0.0), (0.9, 0.4), (0.2, 3.0)])
def test_beyond_that_every_orbit_tends_to_period_1(lam, l):
    mu = 1.05 * theory.mu_bc(2, lam, l)
    fixed = theory.maximal_orbit(1, lam, mu, l)[0]
    for x in (-50.0, -0.1, 0.0, 1e-9, mu, 40.0):
        assert iterate(x, 3000, lam, mu, l) == pytest.approx(fixed, rel=1e-9)


def test_below_zero_there_is_none():
    with pytest.raises(OutsideForm, match=r"no trapping interval at mu = -0.1; it needs mu >= 0: .* mu/\(1 - lam\)"):
        theory.trapping_interval(-0.1, 0.5)
    for x in (-9.0, 0.0, 5.0):
        assert iterate(x, 400, 0.8, -0.1, 0.5) == pytest.approx(-0.5, rel=1e-12)
