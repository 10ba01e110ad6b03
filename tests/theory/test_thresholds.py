import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from grazing import theory
from tests.theory.naive import LAMS


def test_values_of_the_figures():
    assert theory.l_coexist(3, 0.5) == 0.05859375
    assert theory.l_exist(4, 0.9) == pytest.approx(0.08000775, abs=5e-16)
    assert theory.l_exist(5, 0.9) == pytest.approx(0.1796237775, abs=5e-16)
    assert theory.l_coexist(3, 0.9) == pytest.approx(0.62724375, abs=5e-16)
    assert theory.l_all(0.9) == pytest.approx((0.340273, 10), abs=5e-7)


@settings(deadline=None)
@given(N=st.integers(2, 12), lam=LAMS, factor=st.floats(0.5, 2.0))
def test_l_exist_parts_gaps_with_and_without_a_window(N, lam, factor):
    l = theory.l_exist(N, lam)
    assume(abs(factor - 1) > 1e-9)
    if l > 0:
        assert theory.stability_interval(N, lam, factor * l).empty == (factor < 1)
    else:
        assert not theory.stability_interval(N, lam, 1e-3 * factor).empty


@settings(deadline=None)
@given(N=st.integers(1, 12), lam=LAMS, factor=st.floats(0.5, 2.0))
def test_l_coexist_is_where_two_edges_meet(N, lam, factor):
    l = theory.l_coexist(N, lam)
    assume(abs(factor - 1) > 1e-9)
    if l > 0:
        assert theory.mu_pd(N, lam, l) == pytest.approx(theory.mu_bc(N + 1, lam, l), rel=1e-13)
        assert theory.windows_overlap(N, lam, factor * l) == (factor > 1)
    else:
        assert theory.windows_overlap(N, lam, 0.0) == (l < 0)


def test_period_1_needs_no_gap():
    assert theory.l_exist(1, 0.9) == -math.inf
    assert theory.l_exist([1, 4], 0.9)[0] == -math.inf
    assert theory.l_coexist(1, 0.3) == -0.1875


@settings(deadline=None)
@given(lam=st.floats(0.6668, 0.98))
def test_l_all_is_the_greatest_threshold(lam):
    thresholds = theory.l_exist(np.arange(1, 2000), lam)
    worst = theory.l_all(lam)
    assert worst.l == pytest.approx(thresholds.max(), rel=1e-13)
    assert thresholds[worst.N - 1] == pytest.approx(thresholds.max(), rel=1e-13)
    assert worst.l > 0


@pytest.mark.parametrize("lam", [0.01, 0.5, 0.66, 2 / 3])
def test_every_period_has_a_window_up_to_two_thirds(lam):
    assert theory.l_all(lam) == (0.0, None)
    assert all(not theory.stability_interval(N, lam, 0.0).empty for N in range(1, 60))


def test_l_all_for_slopes_at_the_ends_of_its_range():
    assert theory.l_all(np.nextafter(2 / 3, 1)).l >= 0
    near_1 = theory.l_all(1 - 1e-9)
    assert near_1.N == pytest.approx(math.log(2) / 1e-9, rel=1e-6)
    assert near_1.l == pytest.approx(1 / (16 * 1e-9), rel=1e-6)
