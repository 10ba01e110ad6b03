"""Own exp, sincos and log against 400-bit arithmetic, and the same bits with and without the compiler."""

import math

import mpmath as mp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grazing.kernel.compile import compiled
from grazing.kernel.elementary import arccos, arctan2, exp, length, log, power, remainder, sincos
from grazing.kernel.primitives import exponent_of

RNG = np.random.default_rng(20111)


def test_exp_is_within_1_3_ulp():
    with mp.workprec(400):
        worst = 0.0
        for x in np.concatenate(
            [RNG.uniform(-708, 709, 4000), RNG.uniform(-1, 1, 1000), RNG.uniform(-1e-9, 1e-9, 200)]
        ):
            exact = mp.exp(mp.mpf(float(x)))
            worst = max(worst, float(abs(exp(float(x)) - exact)) / math.ulp(float(exact)))
    assert worst < 1.3


def test_log_is_within_1_ulp():
    with mp.workprec(400):
        worst = 0.0
        for x in np.concatenate(
            [np.exp(RNG.uniform(-740, 709, 4000)), RNG.uniform(0.5, 2.0, 2000), 1.0 + RNG.uniform(-1e-9, 1e-9, 200)]
        ):
            exact = mp.log(mp.mpf(float(x)))
            worst = max(worst, float(abs(log(float(x)) - exact)) / math.ulp(float(exact)))
    assert worst < 1.0


def test_ends_of_the_range_of_log():
    assert log(1.0) == 0.0
    assert log(0.0) == log(-0.0) == -math.inf
    assert log(math.inf) == math.inf
    assert math.isnan(log(-1.0)) and math.isnan(log(math.nan))
    assert log(5e-324) == pytest.approx(math.log(5e-324), rel=1e-15)
    assert log(1.7976931348623157e308) == pytest.approx(math.log(1.7976931348623157e308), rel=1e-15)


@given(st.floats(5e-324, 1.7e308))
def test_compiled_and_plain_log_have_the_same_bits(x):
    assert compiled(log)(x) == log(x)


def exponent(x):
    return exponent_of(x)


@given(st.floats(2.2250738585072014e-308, 1.7e308))
def test_the_exponent_of_a_number(x):
    n = exponent_of(x)
    assert compiled(exponent)(x) == n
    assert math.ldexp(1.0, int(n)) <= x
    assert n == 1023 or x < math.ldexp(1.0, int(n) + 1)


@given(st.floats(1e-3, 1e3), st.integers(-60, 60), st.floats(-20.0, 20.0))
def test_powers(x, n, y):
    assert power(x, float(n)) == pytest.approx(x**n, rel=1e-13)
    assert power(x, y) == pytest.approx(x**y, rel=1e-12)
    assert compiled(power)(x, y) == power(x, y)


def test_powers_of_0_and_with_0():
    assert power(0.0, 0.0) == power(3.0, 0.0) == 1.0
    assert power(0.0, 2.5) == power(0.0, 3.0) == 0.0


def test_sincos_is_within_1_5e_16():
    with mp.workprec(400):
        worst = 0.0
        for x in np.concatenate([RNG.uniform(-10, 10, 3000), RNG.uniform(-1e5, 1e5, 2000)]):
            sine, cosine = sincos(float(x))
            point = mp.mpf(float(x))
            worst = max(worst, float(abs(sine - mp.sin(point))), float(abs(cosine - mp.cos(point))))
    assert worst < 1.5e-16


@pytest.mark.parametrize("quarters", range(-9, 10))
def test_sincos_on_and_beside_the_quarters(quarters):
    for x in (quarters * math.pi / 2, math.nextafter(quarters * math.pi / 2, 99.0), (quarters + 0.5) * math.pi / 2):
        assert sincos(x) == pytest.approx((math.sin(x), math.cos(x)), abs=2e-16)


def test_ends_of_the_range_of_exp():
    assert exp(0.0) == 1.0
    assert exp(-709.0) == 0.0
    assert exp(-1e300) == 0.0
    assert exp(710.0) == math.inf
    assert exp(709.0) == pytest.approx(math.exp(709.0), rel=1e-15)
    assert exp(-708.0) == pytest.approx(math.exp(-708.0), rel=1e-15)


@given(st.floats(-800.0, 800.0), st.floats(-1e4, 1e4))
def test_compiled_and_plain_have_the_same_bits(x, angle):
    assert compiled(exp)(x) == exp(x)
    assert compiled(sincos)(angle) == sincos(angle)


@given(st.floats(-300.0, 300.0), st.floats(-300.0, 300.0))
def test_laws_of_exp_and_sincos(x, y):
    assert exp(x) * exp(-x) == pytest.approx(1.0, rel=1e-15)
    sine, cosine = sincos(x)
    assert sine * sine + cosine * cosine == pytest.approx(1.0, abs=5e-16)
    assert sincos(-x) == (-sine, cosine)
    s2, c2 = sincos(y)
    assert sincos(x + y)[0] == pytest.approx(sine * c2 + cosine * s2, abs=2e-13)


def test_length_in_any_unit():
    assert length(3.0, -4.0) == 5.0 and length(0.0, 0.0) == 0.0 and length(math.inf, 1.0) == math.inf
    for unit in (5e-324 * 2.0**60, 2.0**-600, 2.0**600, 2.0**1000):
        assert length(-3.0 * unit, 4.0 * unit) == pytest.approx(5.0 * unit, rel=1e-15)


@given(st.floats(), st.floats())
def test_remainder_is_that_of_the_c_library(x, y):
    found = remainder(x, y)
    if math.isnan(x) or math.isnan(y) or math.isinf(x) or y == 0.0:
        assert math.isnan(found)
    else:
        assert found == math.fmod(x, y)


@pytest.mark.parametrize(("x", "y"), [(1e308, 5e-324), (1e308, 3.0), (-7.5, 2.0), (2.0, math.inf), (5e-324, 5e-324)])
def test_remainder_at_the_ends_of_doubles(x, y):
    assert remainder(x, y) == math.fmod(x, y) == compiled(remainder)(x, y)


def test_angles_are_within_2_ulp():
    with mp.workprec(400):
        worst = 0.0
        scale = np.exp(RNG.uniform(-30, 30, (2000, 2))) * RNG.choice([-1.0, 1.0], (2000, 2))
        for y, x in [*scale, *RNG.normal(size=(3000, 2))]:
            exact = mp.atan2(mp.mpf(float(y)), mp.mpf(float(x)))
            worst = max(worst, float(abs(arctan2(float(y), float(x)) - exact)) / math.ulp(float(exact)))
        assert worst < 2.0
        for x in [*RNG.uniform(-1, 1, 2000), *(1.0 - np.exp(RNG.uniform(-36, 0, 500)))]:
            exact = mp.acos(mp.mpf(float(x)))
            worst = max(worst, float(abs(arccos(float(x)) - exact)) / math.ulp(float(exact)))
    assert worst < 4.0


@pytest.mark.parametrize(
    ("y", "x"), [(0.0, 1.0), (0.0, -1.0), (1.0, 0.0), (-1.0, 0.0), (0.0, 0.0), (-0.0, -1.0), (5e-324, 1e308)]
)
def test_angles_along_the_axes(y, x):
    assert arctan2(y, x) == (math.atan2(y, x) if x or y else 0.0) == compiled(arctan2)(y, x)


def test_ends_of_the_arccosine():
    assert [arccos(x) for x in (1.0, 0.0, -1.0)] == [0.0, math.acos(0.0), math.pi]
