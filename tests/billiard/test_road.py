"""A graze of an active object: its gap and its square root, by simulation and by the formula of docs/road.md."""

from math import cos, pi, sin, sqrt

import numpy as np
import pytest

import grazing as gz

R, RHO = 0.7, 0.1
FLOOR = gz.segment("floor", (-30.0, 0.0), (30.0, 0.0), gz.newton(0.5))


def turned(a):
    """Return a vector turned by a quarter."""
    return np.array([-a[1], a[0]])


def landed(p, w, g):
    """Return where a ball lands on the floor that flies from p with w, when, and its velocity there: closed forms."""
    T = (w[1] + sqrt(w[1] ** 2 + 2.0 * g * (p[1] - RHO))) / g if g > 0.0 else (RHO - p[1]) / w[1]
    return p[0] + w[0] * T, T, np.array([w[0], w[1] - g * T])


def formula(p, w, n, curvature, g, V):
    """Return the gap and the coefficient of sqrt(depth) of the place on the floor."""
    place, T, b = landed(p, w + V * n, g)
    tau, a, m, along = turned(n), np.array([0.0, -g]), np.array([0.0, 1.0]), np.array([1.0, 0.0])
    A = curvature * (w @ tau) ** 2 + a @ n
    moved = V * n + T * ((1.0 + R) * A * n - curvature * V * (w @ tau) * tau)
    out = turned(b) / (m @ b)  # along its surface, whose tangent is m turned by a quarter: -x
    assert turned(m) @ along == -1.0
    return place - landed(p, w, g)[0], -(out @ moved) * sqrt(2.0 / A)


def disc(V, depth):
    """Grazed from above by a ball on its way down, on a tilted table."""
    n = np.array([cos(0.4), sin(0.4)])
    p, w, g = np.array([2.0, 5.0]), 1.3 * np.array([n[1], -n[0]]), 0.6
    centre = p - 0.8 * n
    return (p, w, n, 1.0 / 0.8, g), gz.disc("it", tuple(centre), 0.7 + depth, gz.active(r=R, V=V))


def level(V, depth):
    """Grazed on a level table: the way is straight."""
    n = np.array([cos(0.3), sin(0.3)])
    p, w = np.array([2.0, 5.0]), 1.3 * np.array([n[1], -n[0]])
    return (p, w, n, 1.0 / 0.8, 0.0), gz.disc("it", tuple(p - 0.8 * n), 0.7 + depth, gz.active(r=R, V=V))


def dome(V, depth):
    """Grazed from below, inside an arc: gravity takes the ball away faster than the arc turns towards it."""
    angle, size, g = 1.8, 4.0, 1.1
    n = -np.array([cos(angle), sin(angle)])
    centre = np.array([2.0, 3.0])
    p, w = centre - (size - RHO) * n, 0.9 * turned(n)
    it = gz.arc("it", tuple(centre), size - depth, 0.5, 2.6, gz.active(r=R, V=V))
    return (p, w, n, -1.0 / (size - RHO), g), it


def ceiling(V, depth):
    """A segment, grazed from below at the highest point of a flight along it."""
    lean, g = 0.2, 0.8
    n = np.array([sin(lean), -cos(lean)])
    p, w = np.array([2.0, 5.0]), 1.2 * np.array([cos(lean), sin(lean)])
    along = np.array([cos(lean), sin(lean)])
    ends = [tuple(p - (RHO - depth) * n + s * along) for s in (-2.0, 2.0)]
    return (p, w, n, 0.0, g), gz.segment("it", *ends, gz.active(r=R, V=V))


def place(geometry, V, depth):
    """Return where the ball lands on the floor, and what it hit before."""
    (p, w, _n, _curvature, g), it = geometry(V, depth)
    back = 0.7
    start = *(p - w * back + np.array([0.0, -0.5 * g * back * back])), w[0], w[1] + g * back
    flown = gz.trajectory(gz.table([it, FLOOR], rho=RHO, g=g, tilt=0.5 * pi), start, until=40.0)
    names = flown.impact_wall.values.tolist()
    return flown.after.values[names.index("floor"), 0], names[: names.index("floor")]


@pytest.mark.parametrize("V", [0.0, 0.2])
@pytest.mark.parametrize("geometry", [disc, level, dome, ceiling])
def test_a_graze_of_an_active_object_has_the_square_root_and_the_gap_of_the_formula(geometry, V):
    gap, coefficient = formula(*geometry(V, 0.0)[0], V)
    miss, nothing = place(geometry, V, -1e-13)
    assert nothing == []
    depths = 1e-8 * np.array([1.0, 0.25, 0.0625])
    hits = [place(geometry, V, depth) for depth in depths]
    assert all(before == ["it"] for _place, before in hits)
    _square, slope, jump = np.polyfit(np.sqrt(depths), [x - miss for x, _before in hits], 2)
    assert slope == pytest.approx(coefficient, rel=1e-5)
    assert jump == pytest.approx(gap, abs=1e-9) and (abs(gap) > 1e-4) == (V > 0.0)
