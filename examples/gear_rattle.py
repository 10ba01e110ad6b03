"""Gear rattle: an idle gear with drag between the teeth of one that shakes, as a system of one's own.

Its letters say which flanks hit, D the driving one and B the back. The same gears are an oscillator between walls that
move, whose orbits are followed through grazes of both flanks. Run it with `python examples/gear_rattle.py`; it writes
gear_rattle.png.
"""

import argparse
from math import cos, exp, pi, sin

import numpy as np

import grazing as gz


def idle(t, t0, state, p):
    """Turn freely from t0 to t, slowed by oil (c) and by a constant torque (drag)."""
    x, v = state
    s, rest = t - t0, p.drag / p.c
    fade = exp(-p.c * s)
    return x - rest * s + (v + rest) * (1.0 - fade) / p.c, (v + rest) * fade - rest


def driving(t, state, p):
    """Return the backlash in front of the driving flank, and its rate."""
    x, v = state
    return x - p.A * sin(p.omega * t) + 0.5 * p.backlash, v - p.A * p.omega * cos(p.omega * t)


def back(t, state, p):
    """Return the backlash in front of the back flank, and its rate."""
    x, v = state
    return p.A * sin(p.omega * t) + 0.5 * p.backlash - x, p.A * p.omega * cos(p.omega * t) - v


def bound(t, w, state, p):
    """Return the deceleration now, which only fades, and the greatest acceleration of the teeth."""
    return abs(p.c * state[1] + p.drag) + p.A * p.omega * p.omega


def turn(p):
    """Return the period of the shaking."""
    return 2.0 * pi / p.omega


def between_walls():
    """Return the same gears as an oscillator without a spring between moving walls; ``offset`` is minus the drag."""
    shake = gz.Forcing(omega=1.0, sin=(1.0,), cos=())
    flanks = [gz.wall(x, gz.newton(0.6), motion=shake, name=name) for x, name in ((-0.5, "D"), (0.5, "B"))]
    return gz.Oscillator(alpha=0.1, k=0, forcing=gz.Forcing(omega=1.0, offset=-0.2, cos=()), walls=flanks)


def followed():
    """Follow the stable orbit of period 1 in the drag, and return its branch."""
    P = gz.stroboscopic_map(between_walls())
    orbit = next(one for one in gz.periodic_orbits(P, 1, starts=100) if one.stable)
    return gz.continuation(P, orbit, "offset", (-0.35, -0.1), points=400)


def main(tokens=None):
    """Draw where the gear settles as its drag grows, and return the share of settled orbits that hit both flanks."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--values", type=int, default=300, help="values of the drag")
    parser.add_argument("--out", default="gear_rattle.png", help="file to write: .png, .pdf or .svg")
    options = parser.parse_args(tokens)

    gears = gz.System(
        positions=("x",),
        velocities=("v",),
        params={"c": 0.1, "drag": 0.2, "A": 1.0, "omega": 1.0, "backlash": 1.0, "r": 0.6},
        flight=idle,
        surfaces=[gz.Surface("D", driving, bound), gz.Surface("B", back, bound)],
        box=((-0.4, 0.4), (-1.0, 1.0)),
        period=turn,
        name="gears",
    )
    gz.testing.check_system(gears, states=2)
    P = gz.stroboscopic_map(gears)
    diagram = gz.orbit_diagram(P, "drag", np.linspace(0.05, 0.5, options.values), starts=4, transient=300, keep=60)
    fig = gz.plot.orbit_diagram(diagram)["figure"]
    words = [str(word) for word in diagram.word.values.ravel() if word]
    both = np.mean(["D" in word and "B" in word for word in words])
    for word in sorted({*words}, key=words.count)[-5:]:
        print(f"{words.count(word):5} orbits settle on {word}")
    print(f"{both:.0%} of the settled orbits hit both flanks")
    same = gz.stroboscopic_map(between_walls())
    print(f"between walls a step ends {np.abs(P((0.1, 0.3))[0] - same((0.1, 0.3))[0]).max():.0e} from there")
    for point in followed().special:
        if point.admissible:
            at = f" of flank {point.wall}" if point.wall else ""
            print(f"drag {-point.value:.9f}: {point.type}{at}, {point.orbit.word}")
    print(f"written: {gz.plot.save(fig, options.out)}")
    return both


if __name__ == "__main__":
    main()
