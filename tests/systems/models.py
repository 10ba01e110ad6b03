"""Systems that tests share: oscillators written again as systems, with one wall and with two."""

from math import cos, cosh, exp, sin, sinh, sqrt

import grazing as gz


def steady(t, p):
    """The steady response to F cos(omega t) + offset, with its rate."""
    a, b = p.k * p.k - p.omega * p.omega, p.alpha * p.omega
    size = a * a + b * b
    c, s = p.F * a / size, p.F * b / size
    x = c * cos(p.omega * t) + s * sin(p.omega * t)
    v = p.omega * (s * cos(p.omega * t) - c * sin(p.omega * t))
    return x + p.offset / (p.k * p.k), v


def oscillator_flight(t, t0, state, p):
    u, v = state
    x, w = steady(t0, p)
    s = t - t0
    y, z = u - x, v - w
    q2 = 0.25 * p.alpha * p.alpha - p.k * p.k
    q = sqrt(abs(q2))
    if q2 < 0.0:
        C, S = cos(q * s), sin(q * s) / q
    else:
        C, S = cosh(q * s), sinh(q * s) / q
    h = 0.5 * p.alpha
    fade = exp(-h * s)
    x, w = steady(t, p)
    return x + fade * (C * y + S * (z + h * y)), w + fade * (C * z - S * (h * z + p.k * p.k * y))


def oscillator_bound(t, w, state, p):
    """The steady part has the amplitude of its harmonic, the free one a falling energy that bounds u and v."""
    u, v = state
    x, z = steady(t, p)
    free = sqrt((v - z) ** 2 + p.k * p.k * (u - x) ** 2)
    a, b = p.k * p.k - p.omega * p.omega, p.alpha * p.omega
    size = p.F / sqrt(a * a + b * b)
    return size * p.omega * p.omega + free * (p.alpha + p.k)


def wall_below(t, state, p):
    u, v = state
    return u - p.A_sigma, v


def wall_above(t, state, p):
    u, v = state
    return p.B_sigma - u, -v


def period(p):
    return 6.283185307179586 / p.omega


def oscillator(alpha=0.2, k=1.1, omega=1.7, offset=0.1, walls=1, r=0.8, L=1.0, T=1.0):
    """Return an oscillator above one wall or between two, as a system and as this package has it.

    The units of length and of time are 1/L and 1/T.
    """
    alpha, k, omega, offset, F, S = alpha / T, k / T, omega / T, offset * L / T**2, L / T**2, L / T
    force = gz.Forcing(omega=omega, offset=offset, cos=(F,))
    params = {"alpha": alpha, "k": k, "omega": omega, "offset": offset, "F": F, "A.sigma": -0.2 * L, "A.r": r}
    surfaces = [gz.Surface("A", wall_below, oscillator_bound)]
    if walls == 1:
        model = gz.Oscillator(alpha, k, force, gz.newton(r), sigma=-0.2 * L)
    else:
        pair = gz.wall(-0.2 * L, gz.newton(r)), gz.wall(0.3 * L, gz.newton(0.6))
        model = gz.Oscillator(alpha, k, force, walls=pair)
        params |= {"B.sigma": 0.3 * L, "B.r": 0.6}
        surfaces.append(gz.Surface("B", wall_above, oscillator_bound))
    box = ((-0.15 * L, 0.25 * L), (-1.0 * S, 1.0 * S))
    return gz.System(("u",), ("v",), params, oscillator_flight, surfaces, box, period=period), model
