"""Free flight of the forced linear oscillator, exact from one instant to another for any damping and stiffness.

The homogeneous part is written with functions that are entire in q^2 = alpha^2/4 - k^2, so over-, critically and
under-damped, undamped and free balls are one case, and so are those with a negative stiffness (k^2 stands for it) or
a negative damping. The forced part is the difference of two steady responses where
those are of ordinary size; otherwise (k -> 0, resonance) and for short flights it is Duhamel's integral, term by
term a divided difference of exponentials, which has no singular case.
"""

from __future__ import annotations

from math import sqrt
from typing import NamedTuple

from grazing.kernel.elementary import exp, length, sincos
from grazing.oscillator.constants import Constants, steady_response

#: Flights shorter than this fraction of 1/rate use Duhamel's form: near the anchor y/s then has all its digits.
SHORT = 0.25
#: A flight of more pieces than this is a long one: it is not cut if it surely stays off the wall.
STIFF = 8.0


class Anchor(NamedTuple):
    """Where a flight starts: local time, y = u - sigma, v, both less the steady response, their error bounds."""

    t: float
    y: float
    v: float
    h0: float
    h1: float
    error_y: float
    error_v: float


def anchored(t: float, y: float, v: float, c: Constants, error_y: float = 0.0, error_v: float = 0.0) -> Anchor:
    """Return the anchor of a flight that starts at (t, y, v), known up to the given errors."""
    if not c.steady:
        return Anchor(t, y, v, y, v, error_y, error_v)
    Y, dY = steady_response(t, c)
    return Anchor(t, y, v, y - Y, v - dY, error_y, error_v)


def modes(s: float, c: Constants) -> tuple[float, float, float, float]:
    """Return exp(Bs) = (E11, E12; E21, E22) row by row, the matrix of the unforced flight over time s >= 0."""
    z = c.q2 * s * s
    half = 0.5 * c.alpha
    if z > 0.1:
        e1, e2 = exp(c.l1 * s), exp(c.l2 * s)
        gap = 2.0 * c.spread
        E12 = (e1 - e2) / gap
        return (c.l1 * e2 - c.l2 * e1) / gap, E12, -c.k2 * E12, (c.l1 * e1 - c.l2 * e2) / gap
    if z < -0.1:
        sine, cosine = sincos(c.spread * s)
        S = sine / c.spread
    else:  # cosh(qs) and sinh(qs)/q as series in q^2 s^2; the first term left out is below 1e-19
        cosine = 1.0 + z / 2.0 * (1.0 + z / 12.0 * (1.0 + z / 30.0 * (1.0 + z / 56.0 * (1.0 + z / 90.0))))
        S = s * (1.0 + z / 6.0 * (1.0 + z / 20.0 * (1.0 + z / 42.0 * (1.0 + z / 72.0 * (1.0 + z / 110.0)))))
    e = exp(-half * s)
    return e * (cosine + half * S), e * S, -c.k2 * (e * S), e * (cosine - half * S)


def exp_complex(z: complex) -> complex:
    """Return e**z."""
    sine, cosine = sincos(z.imag)
    size = exp(z.real)
    return complex(size * cosine, size * sine)


def scaled(z: complex, x: float) -> complex:
    """Return x z. Products and quotients are written out: the compiler's own depend on what else it has compiled."""
    return complex(z.real * x, z.imag * x)


def times(a: complex, b: complex) -> complex:
    """Return a b."""
    return complex(a.real * b.real - a.imag * b.imag, a.real * b.imag + a.imag * b.real)


def over(a: complex, b: complex) -> complex:
    """Return a/b."""
    size = square(b)
    return complex((a.real * b.real + a.imag * b.imag) / size, (a.imag * b.real - a.real * b.imag) / size)


def square(z: complex) -> float:
    """Return |z|^2; abs would call the C library, whose last digit differs between machines."""
    return z.real * z.real + z.imag * z.imag


def divided2(a: complex, b: complex, s: float) -> complex:
    """Return the divided difference exp[a, b](s) = (e^{as} - e^{bs})/(a - b), continued to a = b."""
    w = scaled(a - b, 0.5 * s)
    z = times(w, w)
    if abs(z.real) + abs(z.imag) > 0.25:
        return over(exp_complex(scaled(a, s)) - exp_complex(scaled(b, s)), a - b)
    sinhc = complex(1.0)  # sinh(w)/w by its series
    for n in (156.0, 110.0, 72.0, 42.0, 20.0, 6.0):
        sinhc = 1.0 + scaled(times(z, sinhc), 1.0 / n)
    return scaled(times(exp_complex(scaled(a + b, 0.5 * s)), sinhc), s)


def divided3(a: complex, b: complex, c: complex, s: float) -> complex:
    """Return the divided difference exp[a, b, c](s), continued to coinciding nodes."""
    ab, bc, ac = square(a - b), square(b - c), square(a - c)
    if max(ab, bc, ac) * s * s < 1.0:
        # Taylor series about the mean node: s^2 e^{ms} sum_n h_n/(n+2)!, h_n the complete symmetric polynomials
        m = scaled(a + b + c, 1.0 / 3.0)
        x, y, w = scaled(a - m, s), scaled(b - m, s), scaled(c - m, s)
        e2, e3 = times(x, y) + times(y, w) + times(w, x), times(times(x, y), w)
        h0, h1, h2 = complex(1.0), complex(0.0), -e2
        total = scaled(h0, 0.5) + scaled(h2, 1.0 / 24.0)
        factorial = 24.0
        for n in range(3, 19):
            factorial *= n + 2.0
            h0, h1, h2 = h1, h2, times(e3, h0) - times(e2, h1)
            total += scaled(h2, 1.0 / factorial)
        return scaled(times(exp_complex(scaled(m, s)), total), s * s)
    # the two nodes farthest apart divide: no digits are lost
    if ac >= ab and ac >= bc:
        return over(divided2(a, b, s) - divided2(b, c, s), a - c)
    if ab >= bc:
        return over(divided2(a, c, s) - divided2(c, b, s), a - b)
    return over(divided2(b, a, s) - divided2(a, c, s), b - c)


def duhamel(s: float, t: float, c: Constants) -> tuple[float, float]:
    """Return position and velocity at t + s of a ball at rest at y = 0 at time t, under the forcing F alone."""
    return pushed(s, t, c.F0, c)


def beside_far_wall(s: float, u: float, v: float, offset: float, c: Constants) -> tuple[float, float]:
    """Return the state at local time s of a ball that is at (u, v) at local time 0 and meets no wall until then.

    Its height above a wall far below would have none of its digits left.
    """
    E11, E12, E21, E22 = modes(s, c)
    y, w = pushed(s, 0.0, offset, c)
    return E11 * u + E12 * v + y, E21 * u + E22 * v + w


def pushed(s: float, t: float, F0: float, c: Constants) -> tuple[float, float]:
    """Return :func:`duhamel` for another constant part of the force."""
    if c.q2 > 0.0:
        a, b = complex(c.l1), complex(c.l2)
    else:
        a, b = complex(c.l1, c.spread), complex(c.l2, -c.spread)
    still = complex(0.0)
    y3 = divided3(a, b, still, s)
    y = F0 * y3.real
    v = F0 * (times(a, y3) + divided2(b, still, s)).real
    s1, c1 = sincos(c.omega * t + c.theta)
    turn = complex(c1, s1)
    phase = turn
    for j in range(len(c.cos)):
        if c.cos[j] != 0.0 or c.sin[j] != 0.0:
            node = complex(0.0, (j + 1) * c.omega)
            amplitude = times(complex(c.cos[j], -c.sin[j]), phase)
            y3 = divided3(a, b, node, s)
            y += times(amplitude, y3).real
            v += times(amplitude, times(a, y3) + divided2(b, node, s)).real
        phase = times(phase, turn)
    return y, v


def flight(s: float, a: Anchor, c: Constants) -> tuple[float, float]:
    """Return (y, v) after a free flight of time s >= 0 from the anchor."""
    E11, E12, E21, E22 = modes(s, c)
    if c.steady and s * c.rate > SHORT:
        y, v = steady_response(a.t + s, c)
        return E11 * a.h0 + E12 * a.h1 + y, E21 * a.h0 + E22 * a.h1 + v
    y, v = duhamel(s, a.t, c)
    return E11 * a.y + E12 * a.v + y, E21 * a.y + E22 * a.v + v


def stiff(time: float, c: Constants) -> bool:
    """Return whether a swinging ball takes many pieces for this time."""
    return c.q2 < 0.0 and c.alpha >= 0.0 and time > STIFF * c.piece


def noise(s: float, a: Anchor, c: Constants) -> tuple[float, float]:
    """Return bounds on the errors of (y, v) from :func:`flight`: rounding, and what the anchor brought along.

    Tested against ball arithmetic in ``tests/oscillator/test_flight.py``.
    """
    if c.grows > 0.0:
        return growing_noise(s, a, c)
    reach = min(s, 1.0 / c.spread) if c.spread > 0.0 else s  # |E12| <= reach, |E11| and |E22| <= grown
    grown = 1.0 + 0.5 * c.alpha * reach if c.q2 <= 0.0 else 1.0
    if c.steady and s * c.rate > SHORT:
        rounding = 1.2e-15 * (abs(a.h0) + abs(a.h1) * reach + c.size)
        hurried = 0.0
    else:
        rounding = 1.2e-15 * (abs(a.y) + abs(a.v) * reach + min(c.size, 0.5 * c.force * s * s))
        hurried = c.force * s
    brought_y, brought_v = grown * a.error_y + reach * a.error_v, c.k2 * reach * a.error_y + grown * a.error_v
    if stiff(c.T, c):  # the energy of a free flight never grows; the plain bound would double in every piece
        k = sqrt(c.k2)
        energy = length(k * a.error_y, a.error_v)
        brought_y, brought_v = min(brought_y, energy / k), min(brought_v, energy)
    y = rounding + brought_y
    v = 4.0 * c.rate * rounding + 1e-15 * (abs(a.v) + hurried) + brought_v
    return y, v


def growing_noise(s: float, a: Anchor, c: Constants) -> tuple[float, float]:
    """Return the bounds of :func:`noise` where alpha or the stiffness is negative.

    With g = e^(l s), l the larger real part of the roots, |E12| <= g min(s, 1/q), and |E11| and |E22| are at most
    g (1 + |alpha|/2 min(s, 1/q)). What is rounded before the flight grows as much; e^(l s) has 1 + l s roundings.
    """
    g = exp(c.grows * s)
    reach = g * (min(s, 1.0 / c.spread) if c.spread > 0.0 else s)
    grown = g + 0.5 * abs(c.alpha) * reach
    last = 1.2e-15 * (1.0 + c.grows * s)
    if c.steady and s * c.rate > SHORT:
        rounding = last * (grown * (abs(a.h0) + c.size) + reach * (abs(a.h1) + c.rate * c.size))
        hurried = 0.0
    else:
        rounding = last * (grown * abs(a.y) + reach * abs(a.v) + g * min(c.size, 0.5 * c.force * s * s))
        hurried = c.force * s
    y = rounding + grown * a.error_y + reach * a.error_v
    v = 4.0 * c.rate * rounding + last * grown * (abs(a.v) + hurried)
    return y, v + abs(c.k2) * reach * a.error_y + grown * a.error_v
