import math

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from grazing import theory
from tests.theory.naive import GAPS, LAMS, PERIODS, exact, pass_of_word

CASES = [(N, lam, l) for N in (1, 2, 3, 7, 15) for lam in (0.05, 0.34, 0.6, 0.9, 0.99) for l in (0.0, 0.05, 1.0, 20.0)]


@settings(deadline=None)
@given(N=st.integers(1, 5000), lam=st.floats(1e-300, 1 - 2**-53) | st.floats(1 - 1e-6, 1 - 2**-53))
def test_geometric_sum_keeps_its_digits_for_every_lam(N, lam):
    with mpmath.workdps(60):
        a = mpmath.mpf(lam)
        truth = (1 - a**N) / (1 - a)
        assert abs(theory.geometric_sum(N, lam) - truth) <= 4 * 2**-52 * truth


def test_geometric_sum_of_few_terms():
    assert theory.geometric_sum(1, 0.3) == 1.0
    assert theory.geometric_sum([1, 2, 3], 0.5).tolist() == [1.0, 1.5, 1.75]


@pytest.mark.parametrize(("N", "lam", "l"), CASES)
def test_mu_pd_solves_fixed_point_and_multiplier_minus_one(N, lam, l):
    with mpmath.workdps(150):
        a, gap = exact(lam, l)

        def excess(x, mu):
            turn = mpmath.diff(lambda y: pass_of_word(y, N, a, mu, gap), x)
            return [pass_of_word(x, N, a, mu, gap) - x, turn + 1]

        start = (
            a ** (2 * N - 2) / 4 * (1 + mpmath.mpf("1e-3")),
            theory.mu_pd(N, lam, l) * (1 + mpmath.mpf("1e-3")),
        )
        _, truth = mpmath.findroot(excess, start, tol=mpmath.mpf(10) ** -220)
        assert theory.mu_pd(N, lam, l) == pytest.approx(float(truth), rel=4e-15)


@pytest.mark.parametrize(("N", "lam", "l"), [case for case in CASES if case[0] > 1])
def test_mu_bc_solves_the_collision_of_the_greatest_negative_point(N, lam, l):
    with mpmath.workdps(60):
        a, gap = exact(lam, l)

        def excess(mu):  # x_(N-1) = 0 goes to mu, which goes down and climbs N - 2 times, back to 0
            return pass_of_word(mu, N - 1, a, mu, gap)

        low, high = mpmath.mpf(theory.mu_gr(N, lam, l)) / 2 + mpmath.mpf(10) ** -40, mpmath.mpf(100)
        truth = mpmath.findroot(excess, (low, high), solver="anderson", tol=1e-90, maxsteps=500)
        assert theory.mu_bc(N, lam, l) == pytest.approx(float(truth), rel=4e-15)


@pytest.mark.parametrize(("N", "lam", "l"), CASES)
def test_mu_gr_is_where_the_pass_takes_zero_to_zero(N, lam, l):
    with mpmath.workdps(60):
        a, gap, mu = exact(lam, l, theory.mu_gr(N, lam, l))
        assert abs(pass_of_word(mpmath.mpf(0), N, a, mu, gap)) <= 4e-16 * a ** (N - 1) * gap


def test_values_of_figure_3_5():
    assert theory.mu_pd(3, 0.9, 0.0) == pytest.approx(0.1815774908, abs=5e-11)
    assert theory.mu_bc(3, 0.9, 0.0) == pytest.approx(0.2243767313, abs=5e-11)


def test_period_1_has_no_upper_end():
    assert theory.mu_pd(1, 0.7, 0.25) == 1.0
    assert theory.mu_bc(1, 0.7, 0.25) == math.inf
    assert theory.mu_gr(1, 0.7, 0.25) == 0.25


@settings(deadline=None)
@given(N=PERIODS, lam=LAMS, l=GAPS)
def test_order_of_the_edges(N, lam, l):
    graze, doubling, collision = (f(N, lam, l) for f in (theory.mu_gr, theory.mu_pd, theory.mu_bc))
    assert graze < doubling
    assert graze < collision
    margin = theory.l_exist(N, lam) - l
    if abs(margin) > 1e-9:
        assert (doubling < collision) == (margin < 0)


@settings(deadline=None)
@given(N=PERIODS, lam=LAMS, l=GAPS)
def test_edges_fall_as_the_period_grows_and_rise_with_the_gap(N, lam, l):
    for edge in (theory.mu_pd, theory.mu_bc):
        assert edge(N + 1, lam, l) < edge(N, lam, l)
        assert edge(N, lam, l) <= edge(N, lam, l + 0.01)
    assert theory.mu_gr(N + 1, lam, l) < theory.mu_gr(N, lam, l) or l == 0


@settings(deadline=None)
@given(N=st.integers(2, 12), lam=LAMS, l=GAPS)
def test_scaling_with_the_gap(N, lam, l):
    """mu_gr is linear in l, mu_pd affine; mu_bc scales as q^2 when l does as q = lam^(N-2), at fixed K."""
    assert theory.mu_gr(N, lam, 3 * l) == pytest.approx(3 * theory.mu_gr(N, lam, l), rel=1e-14)
    rise = theory.mu_pd(N, lam, l) - theory.mu_pd(N, lam, 0.0)
    assert rise == pytest.approx(theory.mu_gr(N, lam, l), rel=1e-9, abs=1e-15)
    q, k = lam ** (N - 2), theory.geometric_sum(N - 1, lam)
    m = math.sqrt(theory.mu_bc(N, lam, q * l)) / q
    assert m == pytest.approx((1 + math.sqrt(1 + 4 * l * k)) / (2 * k), rel=1e-13)


def test_arrays_broadcast_and_agree_with_scalars():
    N, lam, l = np.arange(1, 6)[:, None, None], np.array([0.2, 0.9])[:, None], np.array([0.0, 0.3, 2.0])
    for edge in (theory.mu_gr, theory.mu_pd, theory.mu_bc):
        table = edge(N, lam, l)
        assert table.shape == (5, 2, 3)
        for i, j, k in np.ndindex(table.shape):
            assert table[i, j, k] == pytest.approx(edge(i + 1, float(lam[j, 0]), float(l[k])), rel=1e-15)


def test_extreme_values_stay_finite():
    assert theory.mu_pd(10**6, 0.5, 1.0) == 0.0
    assert theory.mu_bc(10**6, 0.999999, 1.0) > 0.0
    assert theory.mu_bc(2, 5e-324, 0.0) == 1.0
