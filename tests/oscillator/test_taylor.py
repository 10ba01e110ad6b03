"""The polynomial over one cell against the flight in forty digits, at every damping."""

from math import factorial

import mpmath
import numpy as np
import pytest

from grazing.kernel.compile import compiled
from grazing.oscillator.taylor import bends, coarse, cosh_root, expand, impulse, rough, sinhc_root, value

#: Damping, stiffness: over-damped, critical, nearly so, under-damped, undamped, free; their fastest rates are below.
DAMPINGS = ((3.0, 1.0), (2.0, 1.0), (2.0, 1.0 + 1e-9), (0.2, 3.0), (0.0, 2.2), (0.7, 0.0), (0.0, 0.0), (40.0, 1.0))
#: (fastest rate) * (time from the middle) up to which a series is used.
FAR = 0.3
#: Which derivative each function returns, and the power of that time of the first term left out.
FIRST_LEFT_OUT = {
    value: ((0, 14), (1, 13)), rough: ((0, 7), (1, 6)), coarse: ((0, 5), (1, 4)), bends: ((2, 7), (3, 5)),
}  # fmt: skip


class Flight:
    """A ball from (y, v) under F0 + sum of a cos(n t) + b sin(n t), as the exponential of a linear system."""

    def __init__(self, alpha, k, F0, waves, y, v):
        size = 3 + 2 * len(waves)
        self.matrix = mpmath.zeros(size)
        self.start = mpmath.zeros(size, 1)
        self.matrix[0, 1], self.matrix[1, 0], self.matrix[1, 1] = 1, -(mpmath.mpf(k) ** 2), -mpmath.mpf(alpha)
        self.matrix[1, 2] = 1
        self.start[0], self.start[1], self.start[2] = y, v, F0
        for j, (n, a, b) in enumerate(waves):  # (g, g') with g'' = -n^2 g
            i = 3 + 2 * j
            self.matrix[1, i] = self.matrix[i, i + 1] = 1
            self.matrix[i + 1, i] = -(mpmath.mpf(n) ** 2)
            self.start[i], self.start[i + 1] = a, n * mpmath.mpf(b)

    def at(self, s):
        """Return position, velocity, acceleration and jerk."""
        state = mpmath.expm(self.matrix * s, "taylor") * self.start
        rate = self.matrix * state
        return state[0], state[1], rate[1], (self.matrix * rate)[1]


def forces(F0, waves):
    """Return derivatives 0 to 11 of the force at s = 0."""
    found = []
    for order in range(12):
        total = F0 if order == 0 else 0.0
        for n, a, b in waves:
            total += n**order * (a, b, -a, -b)[order % 4]
        found.append(total)
    return tuple(found)


def cases(alpha, k):
    """Return random flights over the longest cell allowed, with their size: what rounding is measured by."""
    random = np.random.default_rng(int(100 * alpha + 10 * k))
    for harmonics in (1, 3):
        for _ in range(4):
            omega = random.uniform(0.3, 3.0)
            a, b = random.normal(size=(2, harmonics)).tolist()
            waves = [(j * omega, a[j - 1], b[j - 1]) for j in range(1, harmonics + 1)]
            F0, y, v = random.normal(size=3).tolist()
            rate = max(harmonics * omega, k, 0.5 * alpha + np.sqrt(max(0.0, 0.25 * alpha**2 - k * k)))
            size = abs(y) + abs(v) / rate + (abs(F0) + np.abs([a, b]).sum()) / rate**2
            coefficients = expand(y, v, alpha, k * k, forces(F0, waves))
            yield coefficients, Flight(alpha, k, F0, waves, y, v), rate, size


@pytest.mark.parametrize(("alpha", "k"), DAMPINGS)
def test_the_flight_over_a_cell(alpha, k):
    """Beside a few roundings, what is wrong is of the size of the first term left out."""
    with mpmath.workdps(40):
        for a, flight, rate, size in cases(alpha, k):
            for x in (-FAR, -0.2, -0.05, 0.0, 0.1, FAR):
                s = x / rate
                exact = flight.at(s)
                for function, parts in FIRST_LEFT_OUT.items():
                    for found, (derivative, order) in zip(function(a, s), parts, strict=True):
                        allowed = 8 * 2.0**-53 + 6.0 * abs(x) ** order / factorial(order)
                        assert abs(found - exact[derivative]) < allowed * size * rate**derivative, function.__name__


def test_what_is_left_out_grows_as_the_first_terms_left_out():
    """Halving the reach takes 2^7 off the error of ``rough``."""
    with mpmath.workdps(40):
        for coefficients, flight, rate, _size in cases(3.0, 1.0):
            a = tuple(mpmath.mpf(x) for x in coefficients)
            far, near = (abs(rough(a, s / rate)[0] - flight.at(s / rate)[0]) for s in (mpmath.mpf(2), mpmath.mpf(1)))
            assert 2.0**6.3 < far / near < 2.0**7.7


@pytest.mark.parametrize(("alpha", "k"), DAMPINGS)
def test_an_impulse_seen_from_before(alpha, k):
    """The free flight that passes (0, 1), back to where it was s earlier."""
    rate = max(k, 0.5 * alpha + np.sqrt(max(0.0, 0.25 * alpha**2 - k * k))) or 1.0
    q2 = (0.5 * alpha - k) * (0.5 * alpha + k)
    with mpmath.workdps(40):
        flight = Flight(alpha, k, 0.0, [], 0.0, 1.0)
        for x in (-FAR, -0.2, -0.05, 0.0, 0.1, FAR):
            s = x / rate
            exact = flight.at(-s)
            for found, derivative in zip(impulse(s, alpha, q2), (0, 1), strict=True):
                assert abs(found - exact[derivative]) < 8 * 2.0**-53 * rate ** (derivative - 1)


@pytest.mark.parametrize("z", [0.0, 1e-300, 1e-9, -1e-5, 0.03, -0.03, 0.09, -0.09])
def test_functions_of_the_root_of_a_number_of_either_sign(z):
    with mpmath.workdps(40):
        root = mpmath.sqrt(z)
        assert abs(cosh_root(z) - mpmath.re(mpmath.cosh(root))) <= 2.5e-16
        assert abs(sinhc_root(z) - (mpmath.re(mpmath.sinh(root) / root) if z else 1)) <= 2.5e-16


def test_the_polynomials_leave_out_less_than_a_rounding():
    """In exact arithmetic, up to the rounding of the coefficients."""
    with mpmath.workdps(40):
        for z in mpmath.linspace(-0.09, 0.09, 61):
            root = mpmath.sqrt(z)
            assert abs(cosh_root(z) - mpmath.re(mpmath.cosh(root))) <= 4.5e-17
            assert abs(sinhc_root(z) - (mpmath.re(mpmath.sinh(root) / root) if z else 1)) <= 5e-18


def test_compiled_and_plain_agree_to_the_last_bit():
    def entry(y, v, alpha, k2, F, s):
        a = expand(y, v, alpha, k2, F)
        return value(a, s), rough(a, s), coarse(a, s), bends(a, s), impulse(s, alpha, 0.25 * alpha * alpha - k2)

    random = np.random.default_rng(0)
    for _ in range(20):
        numbers, F = random.normal(size=4).tolist(), tuple(random.normal(size=12).tolist())
        s = random.uniform(-0.3, 0.3)
        assert compiled(entry)(*numbers, F, s) == entry(*numbers, F, s)
