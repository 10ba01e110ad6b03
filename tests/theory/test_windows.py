import math
from itertools import pairwise

import pytest
from hypothesis import assume, given, settings

from grazing import InputError, theory
from tests.theory.naive import GAPS, LAMS, PERIODS, iterate, product_of_slopes, true_right_point, word

CASES = [
    (1, 0.5, 0.0), (1, 0.9, 0.8), (2, 0.5, 0.0), (3, 0.9, 0.0), (3, 0.5, 0.1), (4, 0.9, 0.4),
    (4, 0.34, 0.21), (6, 0.7, 0.3), (10, 0.9, 0.35), (12, 0.9, 0.8), (25, 0.95, 2.0),
]  # fmt: skip


def growth(points, share, n, lam, mu, l):
    """By how much n periods multiply a small distance from the point right of the border."""
    start = points[-1] * (1 + share)
    return (iterate(start, n * len(points), lam, mu, l) - points[-1]) / (start - points[-1])


def periods_for(factor, turn):
    """An even number of periods after which a distance has changed about by the factor."""
    return 2 * math.ceil(math.log(factor) / math.log(abs(turn)) / 2)


@pytest.mark.parametrize(("N", "lam", "l"), CASES)
@pytest.mark.parametrize("share", [0.02, 0.5, 0.98])
def test_stable_inside_the_window(N, lam, l, share):
    low, high = theory.stability_interval(N, lam, l)
    mu = low + share * (min(high, l + 2) - low)
    points = theory.maximal_orbit(N, lam, mu, l)
    turn = product_of_slopes(points, lam)
    assert -1 < turn < 0
    n = periods_for(0.02, turn)
    assert growth(points, 1e-6, n, lam, mu, l) == pytest.approx(turn**n, rel=0.02)
    assert sorted(word(points[-1], N, lam, mu, l)) == ["L"] * (N - 1) + ["R"]


@pytest.mark.parametrize(("N", "lam", "l"), CASES)
def test_unstable_just_below_the_period_doubling(N, lam, l):
    (low, high), (graze, _) = theory.stability_interval(N, lam, l), theory.existence_interval(N, lam, l)
    mu = low - 0.02 * min(high - low, low - graze)
    points = theory.maximal_orbit(N, lam, mu, l)
    turn = product_of_slopes(points, lam)
    assert turn < -1
    n = periods_for(50, turn)
    assert growth(points, 1e-7, n, lam, mu, l) == pytest.approx(turn**n, rel=0.02)


@pytest.mark.parametrize(("N", "lam", "l"), [case for case in CASES if case[0] > 1])
def test_gone_just_above_the_border_collision(N, lam, l):
    low, high = theory.stability_interval(N, lam, l)
    mu = high + 0.01 * (high - low)
    x = float(true_right_point(N, lam, mu, l))  # the fixed point of the pass: not one of the map
    assert abs(iterate(x, N, lam, mu, l) - x) > 1e-4 * mu
    assert word(x, N, lam, mu, l) != "R" + "L" * (N - 1)


@pytest.mark.parametrize(("N", "lam"), [(3, 0.5), (2, 0.5), (3, 0.9), (4, 0.3), (5, 0.8)])
def test_neighbours_coexist_just_above_the_threshold_and_not_below(N, lam):
    l = theory.l_coexist(N, lam)
    assert not theory.windows_overlap(N, lam, l * (1 - 1e-9))
    assert theory.windows_overlap(N, lam, l * (1 + 1e-9))
    mu = (theory.mu_pd(N, lam, 1.1 * l) + theory.mu_bc(N + 1, lam, 1.1 * l)) / 2
    for n in (N, N + 1):
        points = theory.maximal_orbit(n, lam, mu, 1.1 * l)
        turn = product_of_slopes(points, lam)
        n = periods_for(0.02, turn)
        assert turn > -1 and growth(points, 1e-6, n, lam, mu, 1.1 * l) == pytest.approx(turn**n, rel=0.02)
    mu = (theory.mu_pd(N, lam, 0.9 * l) + theory.mu_bc(N + 1, lam, 0.9 * l)) / 2
    assert not any(mu in theory.stability_interval(n, lam, 0.9 * l) for n in range(1, 60))


@settings(deadline=None)
@given(N=PERIODS, lam=LAMS, l=GAPS)
def test_the_overlap_rule_is_a_common_value_of_mu(N, lam, l):
    here, following = theory.stability_interval(N, lam, l), theory.stability_interval(N + 1, lam, l)
    low, high = max(here.low, following.low), min(here.high, following.high)
    assume(abs(high / low - 1) > 1e-9)
    assert theory.windows_overlap(N, lam, l) == (low < high)


@settings(deadline=None)
@given(N=PERIODS, lam=LAMS)
def test_without_a_gap_windows_overlap_where_three_quarters_of_the_sum_is_below_1(N, lam):
    assume(abs(0.75 * sum(lam**n for n in range(N)) - 1) > 1e-12)
    assert theory.windows_overlap(N, lam, 0.0) == (0.75 * sum(lam**n for n in range(N)) < 1)


@pytest.mark.parametrize(("l", "expected"), [
    (0.0, [1]),
    (0.4, [1, 2, *range(24, 61)]),
    (0.8, [1, 2, 3, *range(16, 61)]),
])  # fmt: skip
def test_which_neighbours_overlap_at_lam_09(l, expected):
    assert theory.overlapping(0.9, l, 60).tolist() == expected


def test_overlap_survives_underflow():
    assert theory.windows_overlap(10**6, 0.5, 1e-12) and not theory.windows_overlap(10**6, 0.5, 0.0)
    assert theory.windows_overlap(10**6, 0.2, 0.0)


@settings(deadline=None)
@given(N=PERIODS, lam=LAMS, l=GAPS)
def test_window_bundles_the_edges(N, lam, l):
    w = theory.window(N, lam, l)
    assert (w.N, w.mu_gr, w.mu_pd, w.mu_bc) == (
        N,
        *(f(N, lam, l) for f in (theory.mu_gr, theory.mu_pd, theory.mu_bc)),
    )
    assert w.existence == theory.existence_interval(N, lam, l) and not w.existence.empty
    assert w.stability == theory.stability_interval(N, lam, l)
    assert w.stability.low not in w.stability and w.stability.high not in w.stability


def test_chain_of_proposition_3_2():
    """(3.1): mu_bc(N+1) and mu_pd(N) agree to leading order; mu_pd(N) < mu_bc(N+1) for large N."""
    lam, l = 0.8, 0.5
    gaps = []
    for N in (40, 60, 80):
        assert theory.mu_pd(N, lam, l) < theory.mu_bc(N + 1, lam, l) < theory.mu_pd(N - 1, lam, l) * 1.1
        gaps.append(theory.mu_bc(N + 1, lam, l) / theory.mu_pd(N, lam, l) - 1)
    for first, second in pairwise(gaps):
        assert math.log(second / first) / 20 == pytest.approx(math.log(lam) / 2, rel=0.02)


def test_more_windows_than_can_be_told_apart_are_refused_at_once():
    """2^31 of them took half an hour and 16 GB."""
    with pytest.raises(InputError, match="N_max = 2147483648; allowed is at most 1000000; windows_overlap tells"):
        theory.overlapping(0.9, 0.8, 2**31)
    assert len(theory.overlapping(0.9, 0.8, 10**6)) == 10**6 - 12
