"""Count how many shallow impacts an event finder sees.

The steady response of the oscillator dips below the wall once per period, by `depth` times its amplitude. Orbits
start on it at random phases; every one of them hits the wall within a period. The script counts who notices.
Run it with `python examples/shallow_impacts.py`.
"""

import argparse
import math

import numpy as np
from scipy.integrate import solve_ivp

import grazing as gz

ALPHA, K, OMEGA = 0.1, 1.0, 2.8
PERIOD = 2.0 * math.pi / OMEGA
GAIN = 1.0 / complex(K**2 - OMEGA**2, ALPHA * OMEGA)  # of the steady response
DEPTHS = (1e-1, 1e-2, 1e-3, 1e-4, 1e-6, 1e-8)
SOLVERS = {"SciPy RK45": "RK45", "SciPy DOP853": "DOP853", "SciPy LSODA": "LSODA"}


def starts(d, count, seed=0):
    """Random times and the states (u, v) of the steady response there, all above the wall."""
    times = np.random.default_rng(seed).uniform(0.0, PERIOD, 4 * count)
    turning = GAIN * np.exp(1j * OMEGA * times)
    u, v = d / K**2 + turning.real, (1j * OMEGA * turning).real
    above = np.flatnonzero(u > 0.5 * abs(GAIN))[:count]
    return times[above], u[above], v[above]


def seen_by_scipy(method, d, t, u, v):
    """Whether solve_ivp, at rtol = 1e-9, reports u falling through 0 within a period."""

    def motion(t, state):
        return state[1], math.cos(OMEGA * t) + d - ALPHA * state[1] - K**2 * state[0]

    def height(t, state):
        return state[0]

    height.direction = -1
    run = solve_ivp(motion, (t, t + PERIOD), (u, v), method=method, rtol=1e-9, atol=1e-12, events=height)
    return run.t_events[0].size > 0


def seen_by_grazing(d, t, u, v):
    """Whether gz.trajectory lists an impact within a period."""
    model = gz.pinball(alpha=ALPHA, k=K, omega=OMEGA, d=d)
    return gz.trajectory(model, (u, v), start=t, until=t + PERIOD).sizes["impact"] > 0


def main(tokens=None):
    """Print one row per program: the share of impacts seen, by depth."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=100, help="orbits per depth")
    count = parser.parse_args(tokens).count
    finders = {name: lambda *a, m=method: seen_by_scipy(m, *a) for name, method in SOLVERS.items()}
    finders["grazing"] = seen_by_grazing
    print(f"{'depth of the dip':18}" + "".join(f"{depth:8.0e}" for depth in DEPTHS))
    shares = {}
    for name, seen in finders.items():
        row = []
        for depth in DEPTHS:
            d = K**2 * abs(GAIN) * (1.0 - depth)
            row.append(float(np.mean([seen(d, *start) for start in zip(*starts(d, count), strict=True)])))
        shares[name] = row
        print(f"{name:18}" + "".join(f"{share:8.2f}" for share in row))
    return shares


if __name__ == "__main__":
    main()
