"""The flight over one cell as a Taylor polynomial about the middle of the cell, coefficients from the equation itself.

A series is used up to (fastest rate) * |s| = 0.3 from its middle. The first term left out is then below
0.3^14 / 14! = 5e-19 of the flight's size, and of its velocity 3e-17 in units of size and rate. No exponential or sine
is evaluated, so one loop serves every damping.
"""

from __future__ import annotations

from grazing.kernel.primitives import inlined

#: (fastest rate) * (length of a cell) is at most this.
REACH = 0.6

Coefficients = tuple[
    float, float, float, float, float, float, float, float, float, float, float, float, float, float
]  # of s^0 ... s^13


@inlined
def expand(
    y: float, v: float, alpha: float, k2: float, F: tuple[float, float, float, float, float, float, float, float,
                                                         float, float, float, float]
) -> Coefficients:  # fmt: skip
    """Return the coefficients of the flight from (y, v); F are the derivatives 0 to 11 of the force at the middle.

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
    return (
        y, v, y2 * (1.0 / 2.0), y3 * (1.0 / 6.0), y4 * (1.0 / 24.0), y5 * (1.0 / 120.0), y6 * (1.0 / 720.0),
        y7 * (1.0 / 5040.0), y8 * (1.0 / 40320.0), y9 * (1.0 / 362880.0), y10 * (1.0 / 3628800.0),
        y11 * (1.0 / 39916800.0), y12 * (1.0 / 479001600.0), y13 * (1.0 / 6227020800.0),
    )  # fmt: skip


@inlined
def value(a: Coefficients, s: float) -> tuple[float, float]:
    """Return position and velocity at s; even and odd powers apart, for half the waiting."""
    a0, a1, a2, a3, a4, a5, a6, a7, a8, a9, a10, a11, a12, a13 = a
    z = s * s
    e = a12 * z + a10
    de = a12 * z + e
    e = e * z + a8
    de = de * z + e
    e = e * z + a6
    de = de * z + e
    e = e * z + a4
    de = de * z + e
    e = e * z + a2
    de = de * z + e
    e = e * z + a0
    o = a13 * z + a11
    do = a13 * z + o
    o = o * z + a9
    do = do * z + o
    o = o * z + a7
    do = do * z + o
    o = o * z + a5
    do = do * z + o
    o = o * z + a3
    do = do * z + o
    o = o * z + a1
    return o * s + e, (2.0 * s) * de + (o + (2.0 * z) * do)


@inlined
def rough(a: Coefficients, s: float) -> tuple[float, float]:
    """Return position and velocity to about eight digits, from the first seven coefficients."""
    a0, a1, a2, a3, a4, a5, a6 = a[:7]
    p = a6 * s + a5
    d = a6 * s + p
    p = p * s + a4
    d = d * s + p
    p = p * s + a3
    d = d * s + p
    p = p * s + a2
    d = d * s + p
    p = p * s + a1
    d = d * s + p
    return p * s + a0, d


@inlined
def bends(a: Coefficients, s: float) -> tuple[float, float]:
    """Return acceleration and jerk to about four digits; a step from a good guess needs no more."""
    a2, a3, a4, a5, a6, a7, a8 = a[2:9]
    acceleration = 2.0 * a2 + s * (
        6.0 * a3 + s * (12.0 * a4 + s * (20.0 * a5 + s * (30.0 * a6 + s * (42.0 * a7 + s * (56.0 * a8)))))
    )
    jerk = 6.0 * a3 + s * (24.0 * a4 + s * (60.0 * a5 + s * (120.0 * a6 + s * (210.0 * a7))))
    return acceleration, jerk
