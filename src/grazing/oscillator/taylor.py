"""The flight over one cell as a Taylor polynomial about the middle of the cell, coefficients from the equation itself.

A series is used up to (fastest rate) * |s| = 0.3 from its middle. The first term left out is then below
0.3^14 / 14! = 5e-19 of the flight's size, and of its velocity 3e-17 in units of size and rate. No exponential or sine
is evaluated, so one loop serves every damping.
"""

from __future__ import annotations

from math import sqrt

from grazing.kernel.primitives import inlined

#: (fastest rate) * (length of a cell) is at most this.
REACH = 0.6

Derivatives = tuple[
    float, float, float, float, float, float, float, float, float, float, float, float, float, float
]  # 0 to 13


@inlined
def expand(
    y: float, v: float, alpha: float, k2: float, F: tuple[float, float, float, float, float, float, float, float,
                                                         float, float, float, float]
) -> Derivatives:  # fmt: skip
    """Return the derivatives of the flight from (y, v); F are the derivatives 0 to 11 of the force at the middle.

    y'' = F - alpha y' - k^2 y, differentiated again and again; the terms are grouped so that each derivative waits
    for only one operation of the one before.
    """
    F0, F1, F2, F3, F4, F5, F6, F7, F8, F9, F10, F11 = F
    y2 = (F0 - k2 * y) - alpha * v
    y3 = (F1 - k2 * v) - alpha * y2
    y4 = (F2 - k2 * y2) - alpha * y3
    y5 = (F3 - k2 * y3) - alpha * y4
    y6 = (F4 - k2 * y4) - alpha * y5
    y7 = (F5 - k2 * y5) - alpha * y6
    y8 = (F6 - k2 * y6) - alpha * y7
    y9 = (F7 - k2 * y7) - alpha * y8
    y10 = (F8 - k2 * y8) - alpha * y9
    y11 = (F9 - k2 * y9) - alpha * y10
    y12 = (F10 - k2 * y10) - alpha * y11
    y13 = (F11 - k2 * y11) - alpha * y12
    return y, v, y2, y3, y4, y5, y6, y7, y8, y9, y10, y11, y12, y13


@inlined
def even(z: float, y0: float, y2: float, y4: float, y6: float, y8: float, y10: float, y12: float) -> float:
    """Return y0 + y2 z/2! + y4 z^2/4! + ... + y12 z^6/12!; the factors wait for z alone."""
    tail = y8 + z * (1.0 / 90.0) * (y10 + z * (1.0 / 132.0) * y12)
    return y0 + z * 0.5 * (y2 + z * (1.0 / 12.0) * (y4 + z * (1.0 / 30.0) * (y6 + z * (1.0 / 56.0) * tail)))


@inlined
def odd(z: float, y1: float, y3: float, y5: float, y7: float, y9: float, y11: float) -> float:
    """Return y1 + y3 z/3! + y5 z^2/5! + ... + y11 z^5/11!."""
    tail = y9 + z * (1.0 / 110.0) * y11
    return y1 + z * (1.0 / 6.0) * (y3 + z * (1.0 / 20.0) * (y5 + z * (1.0 / 42.0) * (y7 + z * (1.0 / 72.0) * tail)))


@inlined
def value(y: Derivatives, s: float) -> tuple[float, float]:
    """Return position and velocity at s; even and odd powers apart, for half the waiting."""
    y0, y1, y2, y3, y4, y5, y6, y7, y8, y9, y10, y11, y12, y13 = y
    z = s * s
    position = even(z, y0, y2, y4, y6, y8, y10, y12) + s * odd(z, y1, y3, y5, y7, y9, y11 + z * (1.0 / 156.0) * y13)
    return position, even(z, y1, y3, y5, y7, y9, y11, y13) + s * odd(z, y2, y4, y6, y8, y10, y12)


@inlined
def coarse(y: Derivatives, s: float) -> tuple[float, float]:
    """Return position and velocity to about four digits, from the first five derivatives."""
    y0, y1, y2, y3, y4 = y[:5]
    z = s * s
    position = (y0 + z * 0.5 * (y2 + z * (1.0 / 12.0) * y4)) + s * (y1 + z * (1.0 / 6.0) * y3)
    return position, (y1 + z * 0.5 * y3) + s * (y2 + z * (1.0 / 6.0) * y4)


@inlined
def rough(y: Derivatives, s: float) -> tuple[float, float]:
    """Return position and velocity to about eight digits, from the first seven derivatives."""
    y0, y1, y2, y3, y4, y5, y6 = y[:7]
    z = s * s
    position = y0 + z * 0.5 * (y2 + z * (1.0 / 12.0) * (y4 + z * (1.0 / 30.0) * y6))
    position += s * (y1 + z * (1.0 / 6.0) * (y3 + z * (1.0 / 20.0) * y5))
    velocity = y1 + z * 0.5 * (y3 + z * (1.0 / 12.0) * y5)
    return position, velocity + s * (y2 + z * (1.0 / 6.0) * (y4 + z * (1.0 / 20.0) * y6))


@inlined
def bends(y: Derivatives, s: float) -> tuple[float, float]:
    """Return acceleration and jerk to about four digits; a step from a good guess needs no more."""
    y2, y3, y4, y5, y6, y7, y8 = y[2:9]
    z = s * s
    acceleration = y2 + z * 0.5 * (y4 + z * (1.0 / 12.0) * (y6 + z * (1.0 / 30.0) * y8))
    acceleration += s * (y3 + z * (1.0 / 6.0) * (y5 + z * (1.0 / 20.0) * y7))
    jerk = (y3 + z * 0.5 * (y5 + z * (1.0 / 12.0) * y7)) + s * (y4 + z * (1.0 / 6.0) * y6)
    return acceleration, jerk


#: For |z| <= 0.09, z^6 is within 0.0385 * 0.09^6 of FOURTH z^4 - SECOND z^2: what is left is the Chebyshev polynomial
#: T3 of m z^2/0.09^2 - m + 1 with m = 1 + sqrt(3)/2, which is 0 for z = 0.
FOURTH, SECOND = (6.0 * sqrt(3.0) - 9.0) * 0.09**2, 6.0 * (7.0 - 4.0 * sqrt(3.0)) * 0.09**4


@inlined
def cosh_root(z: float) -> float:
    """Return cosh(sqrt(z)) = 1 + z/2! + z^2/4! + ...; for |z| <= 0.09 what is left out is below 4.5e-17."""
    p = (1.0 / 3628800.0) * z + (1.0 / 40320.0 + FOURTH / 479001600.0)
    p = p * z + 1.0 / 720.0
    p = p * z + (1.0 / 24.0 - SECOND / 479001600.0)
    p = p * z + 0.5
    return p * z + 1.0


@inlined
def sinhc_root(z: float) -> float:
    """Return sinh(sqrt(z))/sqrt(z) = 1 + z/3! + z^2/5! + ...; for |z| <= 0.09 what is left out is below 5e-18."""
    p = (1.0 / 39916800.0) * z + (1.0 / 362880.0 + FOURTH / 6227020800.0)
    p = p * z + 1.0 / 5040.0
    p = p * z + (1.0 / 120.0 - SECOND / 6227020800.0)
    p = p * z + 1.0 / 6.0
    return p * z + 1.0


@inlined
def impulse(s: float, alpha: float, q2: float) -> tuple[float, float]:
    """Return position and velocity, s earlier, of the free flight that passes (0, 1); q2 = alpha^2/4 - k^2.

    At time t it is (E12, E22) = e^{-alpha t/2} (S, C - alpha S/2) with S = sinh(q t)/q, C = cosh(q t).
    """
    h = 0.5 * alpha * s
    x, z = h * h, q2 * (s * s)
    grown = cosh_root(x) + h * sinhc_root(x)
    S, C = -s * sinhc_root(z), cosh_root(z)
    return grown * S, grown * (C - 0.5 * alpha * S)
