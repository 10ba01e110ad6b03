import math

import numpy as np
import pytest

from grazing import theory
from grazing.outcome import InputError

BAD_PERIODS = [0, -1, 2.5, 3.0, math.nan, True, "3", None, [1, 0], [1.0], 1 + 0j]
BAD_LAMS = [0.0, 1.0, -0.1, 1.5, math.nan, math.inf, np.finfo(np.longdouble).max, True, "a", None]
BAD_GAPS = [-1e-300, -1, math.nan, math.inf, "0", None, False]


@pytest.mark.parametrize("function", [theory.mu_pd, theory.mu_bc, theory.mu_gr, theory.window])
@pytest.mark.parametrize("N", BAD_PERIODS)
def test_a_period_that_is_no_positive_integer_is_refused(function, N):
    with pytest.raises(InputError, match=r"N (= .* is not allowed; N must be an integer >= 1|has shape)"):
        function(N, 0.5, 0.1)


@pytest.mark.parametrize("lam", BAD_LAMS)
@pytest.mark.parametrize("call", [
    lambda lam: theory.mu_pd(2, lam, 0.1),
    lambda lam: theory.geometric_sum(2, lam),
    lambda lam: theory.l_all(lam),
    lambda lam: theory.regime(lam),
    lambda lam: theory.last_window(lam),
    lambda lam: theory.robust_chaos(lam),
    lambda lam: theory.maximal_orbit(2, lam, 0.5, 0.1),
    lambda lam: theory.doubled_interval(2, lam, 0.1),
    lambda lam: theory.windows_overlap(2, lam, 0.1),
])  # fmt: skip
def test_a_lam_outside_the_open_unit_interval_is_refused(call, lam):
    with pytest.raises(InputError, match=r"lam = .* is not allowed; lam must be a finite number with 0 < lam < 1"):
        call(lam)


@pytest.mark.parametrize("l", BAD_GAPS)
@pytest.mark.parametrize("call", [
    lambda l: theory.mu_bc(2, 0.5, l),
    lambda l: theory.multiplier(2, 0.5, 0.5, l),
    lambda l: theory.doubled_orbit(2, 0.5, 0.5, l),
    lambda l: theory.trapping_interval(0.5, l),
    lambda l: theory.overlapping(0.5, l, 3),
])  # fmt: skip
def test_a_gap_that_is_negative_or_no_number_is_refused(call, l):
    with pytest.raises(InputError, match=r"l = .* is not allowed; l must be a finite number >= 0"):
        call(l)


@pytest.mark.parametrize("mu", [math.nan, math.inf, -math.inf, "x", None, True])
def test_an_offset_that_is_not_finite_is_refused(mu):
    for call in (theory.maximal_orbit, theory.multiplier, theory.doubled_orbit, theory.doubled_multiplier):
        with pytest.raises(InputError, match=r"mu = .* is not allowed; mu must be a finite number"):
            call(2, 0.5, mu, 0.1)
    with pytest.raises(InputError, match="mu = "):
        theory.trapping_interval(mu, 0.1)


def test_the_whole_sentence():
    with pytest.raises(InputError) as caught:
        theory.mu_pd(2.5, 0.5, 0.0)  # type: ignore[call-overload]
    said = "N = 2.5 is not allowed; N must be an integer >= 1: give the period of the orbit as an int"
    assert str(caught.value) == said
    with pytest.raises(InputError) as caught:
        theory.mu_pd(2, 0.5, [0.0, -2.0])
    said = (
        "l = -2.0 is not allowed; l must be a finite number >= 0, up to 1e100: l is the gap of (2.6); l = 0 closes it"
    )
    assert str(caught.value) == said


def test_shapes_that_do_not_match_are_named():
    with pytest.raises(InputError, match=r"shapes do not match: N \(2,\), lam \(3,\), l \(\)"):
        theory.mu_pd([1, 2], [0.1, 0.2, 0.3], 0.0)
    with pytest.raises(InputError, match=r"lam has shape \(1,\); one number is allowed here"):
        theory.window(2, [0.5], 0.1)
    with pytest.raises(InputError, match="lam = "):
        theory.mu_pd(2, [[0.5], [0.5, 0.6]], 0.1)


def test_numbers_of_numpy_pass():
    assert theory.mu_pd(np.int32(3), np.float64(0.9), np.int64(0)) == theory.mu_pd(3, 0.9, 0.0)
    assert isinstance(theory.mu_pd(np.int64(3), np.float64(0.9), 0), float)
    assert theory.window(np.int64(3), np.float32(0.5), 1).N == 3
