"""A ball on a vibrating table, as a system of one's own: the road from one bounce in a period to chaos.

Run it with `python examples/bouncing_ball.py`; it writes bouncing_ball.png.
"""

import argparse
from math import cos, pi, sin

import numpy as np

import grazing as gz


def fall(t, t0, state, p):
    """Fall freely from t0 to t."""
    x, v = state
    s = t - t0
    return x + (v - 0.5 * s) * s, v - s


def table(t, state, p):
    """Return the height above the table, and its rate."""
    x, v = state
    return x - p.A * sin(2.0 * pi * t), v - 2.0 * pi * p.A * cos(2.0 * pi * t)


def bound(t, w, state, p):
    """Return gravity and the greatest acceleration of the table."""
    return 1.0 + 4.0 * pi * pi * p.A


def main(tokens=None):
    """Draw the diagram, and return the amplitude at which one bounce in a period doubles, and its closed form."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--values", type=int, default=300, help="amplitudes of the table")
    parser.add_argument("--out", default="bouncing_ball.png", help="file to write: .png, .pdf or .svg")
    options = parser.parse_args(tokens)

    floor = gz.Surface("A", table, bound)
    ball = gz.System(
        ("x",), ("v",), {"A": 0.045, "r": 0.5}, fall, [floor], ((0.1, 0.3), (-0.3, 0.3)), period=1.0, name="ball"
    )
    gz.testing.check_system(ball, states=2)
    P = gz.stroboscopic_map(ball)
    diagram = gz.orbit_diagram(P, "A", np.linspace(0.03, 0.09, options.values), starts=4, transient=300, keep=60)
    fig = gz.plot.orbit_diagram(diagram)["figure"]

    # one bounce a period: the ball leaves with 1/2, as (1 + r) w = (1 - r)/2 with w the speed of the table
    r, angle = 0.5, np.arccos(0.5 * (1 - 0.5) / ((1 + 0.5) * 2 * pi * 0.045))
    t = 1.0 - angle / (2 * pi)  # of flight, from the bounce to the strobe
    start = (0.045 * sin(angle) + 0.5 * t - 0.5 * t * t, 0.5 - t)
    orbit = next(one for one in gz.periodic_orbits(P, period=1) if np.allclose(one.points[0], start))
    branch = gz.continuation(P, orbit, "A", (0.03, 0.09))
    doubling = next(one.value for one in branch.special if "pd" in str(one))
    exact = np.hypot((1 - r) / (2 * (1 + r)) * 2 * pi, 2 * (1 + r * r) / (1 + r) ** 2) / (4 * pi * pi)
    print(f"one bounce a period doubles at A = {doubling:.10f}, in closed form {exact:.10f}")
    print(f"written: {gz.plot.save(fig, options.out)}")
    return doubling, exact


if __name__ == "__main__":
    main()
