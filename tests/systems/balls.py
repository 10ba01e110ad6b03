"""Systems that tests share: balls on tables, in boxes, and a beam of two modes at a stop."""

from math import cos, exp, pi, sin, sqrt

import grazing as gz

# ---- a ball on a vibrating table, perhaps under a ceiling


def parabola(t, t0, state, p):
    x, v = state
    s = t - t0
    return x + (v - 0.5 * p.g * s) * s, v - p.g * s


def table(t, state, p):
    x, v = state
    return x - p.A * sin(p.omega * t), v - p.A * p.omega * cos(p.omega * t)


def table_bound(t, w, state, p):
    return p.g + p.A * p.omega * p.omega


def ceiling(t, state, p):
    x, v = state
    return p.height - x, -v


def ceiling_bound(t, w, state, p):
    return p.g


def turn(p):
    return 2.0 * pi / p.omega


def bouncing(A=0.1, r=0.5, omega=2.0 * pi, height=None, **options):
    params = {"g": 1.0, "A": A, "omega": omega, "r": r}
    surfaces = [gz.Surface("A", table, table_bound)]
    if height is not None:
        params["height"] = height
        surfaces.append(gz.Surface("B", ceiling, ceiling_bound))
    options = {"box": ((0.2, 0.4), (-0.5, 0.5)), "period": turn} | options
    return gz.System(("x",), ("v",), params, parabola, surfaces, **options)


# ---- a ball in a rectangular box, without gravity


def straight(t, t0, state, p):
    x, y, vx, vy = state
    s = t - t0
    return x + vx * s, y + vy * s, vx, vy


def left(t, state, p):
    return state[0], state[2]


def right(t, state, p):
    return 1.0 - state[0], -state[2]


def below(t, state, p):
    return state[1], state[3]


def above(t, state, p):
    return 2.0 - state[1], -state[3]


def none(t, w, state, p):
    return 0.0


def billiard(r=1.0):
    walls = [gz.Surface(name, gap, none) for name, gap in zip("LRBA", (left, right, below, above), strict=True)]
    box = ((0.1, 0.9), (0.1, 1.9), (-1.0, 1.0), (-1.0, 1.0))
    return gz.System(("x", "y"), ("vx", "vy"), {"r": r}, straight, walls, box, period=1.0, name="billiard")


# ---- a beam of two modes, shaken, whose tip hits a stop


def mode(t, t0, q, w, k, zeta, force, omega):
    """One damped mode under force * cos(omega t)."""
    a, b = k * k - omega * omega, 2.0 * zeta * k * omega
    size = a * a + b * b
    c, s = force * a / size, force * b / size
    x = c * cos(omega * t0) + s * sin(omega * t0)
    v = omega * (s * cos(omega * t0) - c * sin(omega * t0))
    h, turn_rate, d = zeta * k, k * sqrt(1.0 - zeta * zeta), t - t0
    fade, C, S = exp(-h * d), cos(turn_rate * d), sin(turn_rate * d) / turn_rate
    y, z = q - x, w - v
    x = c * cos(omega * t) + s * sin(omega * t)
    v = omega * (s * cos(omega * t) - c * sin(omega * t))
    return x + fade * (C * y + S * (z + h * y)), v + fade * (C * z - S * (h * z + k * k * y))


def beam_flight(t, t0, state, p):
    a, b, va, vb = state
    a, va = mode(t, t0, a, va, p.k1, p.zeta, p.force, p.omega)
    b, vb = mode(t, t0, b, vb, p.k2, p.zeta, -0.5 * p.force, p.omega)
    return a, b, va, vb


def tip(t, state, p):
    a, b, va, vb = state
    return p.gap - (a - b), -(va - vb)


def reach_of(t, q, w, k, zeta, force, omega):
    """A bound of |q''| for all times later."""
    a, b = k * k - omega * omega, 2.0 * zeta * k * omega
    size = a * a + b * b
    c, s = force * a / size, force * b / size
    x = c * cos(omega * t) + s * sin(omega * t)
    v = omega * (s * cos(omega * t) - c * sin(omega * t))
    free = sqrt((w - v) * (w - v) + k * k * (q - x) * (q - x))
    return sqrt(c * c + s * s) * omega * omega + free * k * (1.0 + 2.0 * zeta)


def tip_bound(t, w, state, p):
    a, b, va, vb = state
    first = reach_of(t, a, va, p.k1, p.zeta, p.force, p.omega)
    return first + reach_of(t, b, vb, p.k2, p.zeta, -0.5 * p.force, p.omega)


def beam():
    params = {"k1": 1.0, "k2": 6.27, "zeta": 0.02, "force": 0.6, "omega": 1.3, "gap": 0.4, "r": 0.7}
    box = ((-0.2, 0.1), (-0.05, 0.05), (-0.3, 0.3), (-0.1, 0.1))
    stop = gz.Surface("A", tip, tip_bound)
    return gz.System(("a", "b"), ("va", "vb"), params, beam_flight, [stop], box, period=turn, name="beam")
