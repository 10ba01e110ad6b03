import math

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from grazing import theory
from grazing.outcome import InputError, OutsideForm
from grazing.theory import Regime
from tests.theory.naive import gap_map, product_of_slopes


def sum_to(N, lam):
    return sum(lam**n for n in range(N))


@pytest.mark.parametrize("N", [2, 3, 4, 7, 20, 100])
@pytest.mark.parametrize(("root", "total"), [(theory.lam_overlap, mpmath.mpf(4) / 3), (theory.lam_exist, 3)])
def test_roots_at_high_precision(root, total, N):
    if root is theory.lam_exist and N <= 3:
        assert root(N) == 1.0
        return
    with mpmath.workdps(40):
        truth = mpmath.findroot(lambda x: sum_to(N, x) - total, (0.2, 0.9), solver="anderson", tol=1e-60)
        assert root(N) == pytest.approx(float(truth), rel=1e-15)


def test_exceptions_at_small_periods():
    assert theory.lam_overlap(1) == 1.0
    assert theory.lam_overlap(2) == pytest.approx(1 / 3, rel=1e-15)
    assert theory.lam_overlap(3) == pytest.approx(0.26376, abs=5e-6)
    assert theory.lam_overlap(40) == 0.25
    assert theory.lam_exist(80) == pytest.approx(2 / 3, rel=1e-12)
    for root in (theory.lam_overlap, theory.lam_exist):
        with pytest.raises(InputError, match="N = 0 is not allowed"):
            root(0)


@pytest.mark.parametrize("N", [2, 3, 4, 6, 10])
def test_they_part_overlap_and_existence_at_l_0(N):
    for factor in (1 - 1e-6, 1 + 1e-6):
        assert theory.windows_overlap(N, theory.lam_overlap(N) * factor, 0.0) == (factor < 1)
        if N > 3:
            assert theory.stability_interval(N, theory.lam_exist(N) * factor, 0.0).empty == (factor > 1)


@pytest.mark.parametrize(("lam", "expected"), [
    (0.01, Regime.overlapping), (0.25, Regime.overlapping), (math.nextafter(0.25, 1), Regime.separated),
    (0.5, Regime.separated), (2 / 3, Regime.separated), (math.nextafter(2 / 3, 1), Regime.chaotic),
    (0.9, Regime.chaotic), (0.999, Regime.chaotic),
])  # fmt: skip
def test_regime_and_what_it_says_about_the_windows(lam, expected):
    assert theory.regime(lam) is expected
    far = range(30, 35)  # nearer to 1/4 and 2/3 it takes a larger N to tell
    if expected is Regime.overlapping:
        assert theory.overlapping(lam, 0.0, 40).tolist() == list(range(1, 41))
    elif lam > 0.26:
        assert not any(theory.windows_overlap(N, lam, 0.0) for N in far)
    if expected is Regime.chaotic and lam > 0.67:
        assert all(theory.stability_interval(N, lam, 0.0).empty for N in far)


@settings(deadline=None)
@given(lam=st.floats(math.nextafter(2 / 3, 1), 1 - 2**-53) | st.floats(math.nextafter(2 / 3, 1), 0.6667))
def test_last_window_is_the_last(lam):
    N = theory.last_window(lam)
    assert N >= 3
    with mpmath.workdps(60):
        a = mpmath.mpf(lam)
        assert a**N > 3 * a - 2 >= a ** (N + 1)


@pytest.mark.parametrize(("lam", "N"), [(0.9, 3), (0.8, 4), (0.75, 4), (0.72, 5), (0.7, 6), (0.68, 8), (0.67, 11)])
def test_robust_chaos_ends_at_the_last_window(lam, N):
    assert theory.last_window(lam) == N
    low, high = theory.robust_chaos(lam)
    assert low == 0.0 and high == theory.mu_pd(N, lam, 0.0)
    windows = [theory.stability_interval(n, lam, 0.0) for n in range(1, 200)]
    assert min(w.low for w in windows if not w.empty) == high
    assert all(w.empty for w in windows[N:]) and not any(w.empty for w in windows[:N])


@pytest.mark.parametrize("lam", [0.68, 0.7, 0.75, 0.8, 0.85, 0.9, 0.97])
def test_orbits_there_are_chaotic_and_beyond_it_periodic(lam):
    high = theory.robust_chaos(lam).high
    mu = high * np.concatenate([np.geomspace(1e-4, 0.1, 20), np.linspace(0.1, 0.98, 60)])
    assert np.all(lyapunov_exponents(lam, mu) > 0.005)
    N = theory.last_window(lam)
    inside = sum(theory.stability_interval(N, lam, 0.0)) / 2
    stable = theory.maximal_orbit(N, lam, inside, 0.0)
    exponent = lyapunov_exponents(lam, np.array([inside]), start=stable[-1])
    assert exponent == pytest.approx(math.log(-theory.multiplier(N, lam, inside, 0.0)) / N, abs=1e-3)


def lyapunov_exponents(lam, mu, start=None, transient=3000, keep=4000):
    x, total = -0.3 * np.sqrt(mu) if start is None else start, np.zeros_like(mu)
    for n in range(transient + keep):
        left, root = x < 0, np.sqrt(np.abs(x))
        if n >= transient:
            total += np.log(np.where(left, lam, 0.5 / np.maximum(root, 1e-300)))
        x = np.where(left, lam * x + mu, mu - root)
    return total / keep


@settings(deadline=None)
@given(lam=st.floats(0.68, 0.97), share=st.floats(0.01, 0.99), beyond=st.integers(1, 6))
def test_maximal_orbits_beyond_the_last_window_are_never_stable(lam, share, beyond):
    N = theory.last_window(lam) + beyond
    mu = share * theory.existence_interval(N, lam, 0.0).high
    assert product_of_slopes(theory.maximal_orbit(N, lam, mu, 0.0), lam) < -1


@pytest.mark.parametrize("lam", [0.75, 0.9])
def test_cycles_of_two_long_blocks_are_unstable(lam):
    """Blocks of two lengths, both with K_n >= 3, found by iterating the inverse branches, which contract."""
    n, found = theory.last_window(lam) + 1, 0
    for share in np.linspace(0.02, 0.98, 97):
        mu = share * theory.robust_chaos(lam).high
        x = mu / 2
        for _ in range(400):
            for N in (n + 1, n):
                x = ((sum_to(N, lam) * mu - x) / lam ** (N - 1)) ** 2
                x = min(x, 2 * mu)
        points = [x]
        for _ in range(2 * n):
            points.append(gap_map(points[-1], lam, mu, 0.0))
        if sum(y >= 0 for y in points[:-1]) == 2 and abs(gap_map(points[-1], lam, mu, 0.0) - x) < 1e-6 * mu:
            found += 1
            assert abs(product_of_slopes(points, lam)) > 1
    assert found > 0


def test_below_two_thirds_there_is_none():
    assert theory.robust_chaos(0.5).empty and theory.robust_chaos(2 / 3).empty
    with pytest.raises(OutsideForm, match=r"no last window at lam = 0.5: for lam <= 2/3 every N has"):
        theory.last_window(0.5)
