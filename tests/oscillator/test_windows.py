"""Sign windows against the roots of the polynomial on the unit circle, found by another method."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from grazing.kernel.compile import compiled
from grazing.oscillator.windows import free_distance, series, window_edges


def edges_of(mean, cos, sin, omega=1.0, theta=0.0):
    m = len(cos)
    bend = sum((j + 1) ** 2 * omega**2 * np.hypot(c, s) for j, (c, s) in enumerate(zip(cos, sin, strict=True)))
    T = 2.0 * np.pi / omega
    arguments = (mean, tuple(cos), tuple(sin), omega, theta, T, float(bend), (0.0,) * (2 * m + 2))
    edges, first, doubtful = window_edges(*arguments)
    assert compiled(window_edges)(*arguments) == (edges, first, doubtful)
    assert all(x in (0.0, 1.0) for x in doubtful)
    return np.array(edges), first, T


def circle_roots(mean, cos, sin, omega, theta):
    """Times of the zeros, from the companion matrix of z^m F."""
    m = len(cos)
    coefficients = np.zeros(2 * m + 1, complex)
    coefficients[m] = mean
    for j, (c, s) in enumerate(zip(cos, sin, strict=True), start=1):
        coefficients[m - j] = 0.5 * complex(c, -s)
        coefficients[m + j] = 0.5 * complex(c, s)
    z = np.roots(np.trim_zeros(coefficients, "f"))
    on_circle = z[np.abs(np.abs(z) - 1.0) < 1e-7]
    return np.sort(((np.angle(on_circle) - theta) % (2.0 * np.pi)) / omega)


AMPLITUDE = st.floats(-2.0, 2.0)


@given(
    st.integers(1, 5).flatmap(
        lambda m: st.tuples(st.lists(AMPLITUDE, min_size=m, max_size=m), st.lists(AMPLITUDE, min_size=m, max_size=m))
    ),
    AMPLITUDE,
    st.floats(0.05, 20.0),
    st.floats(-3.0, 3.0),
)
def test_all_zeros_are_found_and_no_other(harmonics, mean, omega, theta):
    cos, sin = harmonics
    assume(np.hypot(cos[-1], sin[-1]) > 1e-3)
    expected = circle_roots(mean, cos, sin, omega, theta)
    T = 2.0 * np.pi / omega
    circle = np.concatenate([[0.0], expected, [T]])
    assume(np.diff(circle).min(initial=T) > 1e-5 * T)  # double zeros have a test of their own
    slopes = [abs(series(t, mean, tuple(cos), tuple(sin), omega, theta)[1]) for t in expected]
    assume(min(slopes, default=1.0) > 1e-3 * omega)
    edges, first, _ = edges_of(mean, cos, sin, omega, theta)
    found = edges[(edges > 0.0) & (edges < T)]
    assert len(found) == len(expected)
    assert np.allclose(found, expected, rtol=0.0, atol=1e-7 * T)
    for i, (a, b) in enumerate(pairwise(edges)):
        if b > a:
            middle = series(0.5 * (a + b), mean, tuple(cos), tuple(sin), omega, theta)[0]
            assert np.sign(middle) == first * (-1) ** i


@pytest.mark.parametrize("mean", [1.5, -1.5])
def test_no_zero_is_one_window(mean):
    edges, first, T = edges_of(mean, [1.0], [0.0])
    assert edges.tolist() == [0.0, T, T, T]
    assert first == np.sign(mean)


def test_no_force_has_no_sign():
    edges, first, T = edges_of(0.0, [0.0], [0.0])
    assert (edges.tolist(), first) == ([0.0, T, T, T], 0.0)


@pytest.mark.parametrize("theta", [0.0, 0.3, -2.0])
@pytest.mark.parametrize("mean", [1.0, -1.0])
def test_a_double_zero_is_dropped_or_both_its_edges_coincide(mean, theta):
    edges, first, T = edges_of(mean, [1.0], [0.0], 2.2, theta)
    inside = edges[(edges > 0.0) & (edges < T)]
    assert len(inside) in (0, 2)
    assert np.ptp(inside) <= 1e-6 if len(inside) else True
    assert first == np.sign(mean)


def test_zeros_at_the_ends_of_the_period_separate_nothing():
    edges, first, T = edges_of(0.0, [0.0], [1.0])  # sin t
    assert edges[1] == pytest.approx(np.pi, abs=1e-15)
    assert edges[2:].tolist() == [T, T]
    assert first == 1.0


@pytest.mark.parametrize("gap", [1e-2, 1e-4, 1e-5])
def test_a_near_double_pair_is_resolved(gap):
    mean = float(np.cos(0.5 * gap))
    edges, first, T = edges_of(mean, [1.0], [0.0], theta=1.0)  # zeros at pi - 1 -+ gap/2
    inside = edges[(edges > 0.0) & (edges < T)]
    assert np.diff(inside) == pytest.approx(gap, rel=1e-3 if gap > 1e-5 else 0.1)
    assert first == 1.0


@given(AMPLITUDE, AMPLITUDE, st.floats(0.1, 10.0), st.floats(0.0, 6.0))
def test_free_distance_is_free(mean, c, omega, t):
    F, dF = series(t, mean, (c,), (0.3,), omega, 0.0)
    bend = omega**2 * float(np.hypot(c, 0.3))
    reach = free_distance(F, dF, bend)
    for s in np.linspace(0.0, 0.999 * reach, 7):
        value = series(t + s, mean, (c,), (0.3,), omega, 0.0)[0]
        assert value * F > 0.0 or abs(value) < 1e-14


def test_series_and_its_slope():
    cos, sin, omega, theta = (1.0, -0.4, 0.2), (0.3, 0.1, -0.7), 1.7, 0.4
    for t in np.linspace(0.0, 3.0, 7):
        angle = omega * t + theta
        expected = 0.2 + sum(
            c * np.cos((j + 1) * angle) + s * np.sin((j + 1) * angle)
            for j, (c, s) in enumerate(zip(cos, sin, strict=True))
        )
        value, slope = series(t, 0.2, cos, sin, omega, theta)
        assert value == pytest.approx(expected, abs=4e-15)
        h = 1e-5
        ahead, behind = (series(t + e, 0.2, cos, sin, omega, theta)[0] for e in (h, -h))
        assert slope == pytest.approx((ahead - behind) / (2.0 * h), abs=1e-8)


@pytest.mark.parametrize("unit", [2.0**-700, 2.0**600])
def test_zeros_of_a_force_in_any_unit_cost_the_same(unit):
    """Products of numbers as small are 0: a step then proved nothing, and a period took ten million."""
    bend = 2.2**2
    assert free_distance(0.7 * unit, -0.3 * unit, bend * unit) == pytest.approx(free_distance(0.7, -0.3, bend))
    edges, first, _T = edges_of(0.0, [unit], [0.0])
    plain, sign, _T = edges_of(0.0, [1.0], [0.0])
    assert first == sign and edges == pytest.approx(plain, rel=1e-14)
