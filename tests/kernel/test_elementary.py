"""Own exp and sincos against 400-bit arithmetic, and the same bits with and without the compiler."""

import math

import mpmath as mp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grazing.kernel.compile import compiled
from grazing.kernel.elementary import exp, sincos

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
