"""A bumper of your own: its kick grows with the blow and saturates, v_plus = -r v + V (1 - exp(v/w)).

A slow ball gets no kick, a fast one gets V. Run it with `python examples/own_reset_law.py`.
"""

import math

import numpy as np

import grazing as gz


def saturating(v, p):
    """Return v_plus; v is the velocity into the wall, v <= 0."""
    return -p.r * v + p.V * (1.0 - math.exp(v / p.w))


def main():
    """Compare the saturating bumper with the paper's, and return the letters of one orbit of each."""
    forcing = gz.Forcing(omega=2.2, offset=0.12)
    laws = {
        "paper's bumper": gz.active(r=0.8, V=0.4),
        "saturating, w = 0.02": gz.reset(saturating, r=0.8, V=0.4, w=0.02),
        "saturating, w = 1": gz.reset(saturating, r=0.8, V=0.4, w=1.0),
    }
    seen = {}
    for name, law in laws.items():
        model = gz.Oscillator(alpha=3, k=1, forcing=forcing, reset=law)
        orbit = gz.stroboscopic_map(model).orbit((0.1, 0.0), 1000)
        seen[name] = orbit.letters[-8:].tolist()
        speeds = gz.trajectory(model, orbit.points[-1], until=8 * model.period).v_minus.values
        print(f"{name:22} impacts per period {seen[name]}, impact speeds {np.unique((-speeds).round(6))}")
    gz.testing.check_model(model, states=4)
    return seen


if __name__ == "__main__":
    main()
