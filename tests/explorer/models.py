"""Oscillators that differ in damping, harmonics, wall, law, shift and section, with a parameter that varies."""

import grazing as gz

#: (model, phase, parameter, values)
CASES = {
    "standard set": (gz.pinball(), 0.0, "d", (0.05, 0.13)),
    "passive, wall moved": (gz.pinball(V=0.0, sigma=-0.2, d=0.0, omega=2.6, alpha=1.0), 0.3, "omega", (2.2, 2.9)),
    "lightly damped, two harmonics": (
        gz.Oscillator(0.05, 1.0, gz.Forcing(2.8, 0.1, 0.02, (1.0, 0.3), (0.0, -0.2)), gz.newton(0.9), -0.1),
        0.0,
        "r",
        (0.5, 1.0),
    ),
    "two harmonics, kick": (
        gz.Oscillator(0.4, 1.2, gz.Forcing(1.7, 0.0, 0.1, (0.5, 0.4), (0.3, 0.2)), gz.active(0.7, 0.2), 0.15),
        0.7,
        "sigma",
        (-0.1, 0.3),
    ),
    "resonance, no steady response": (
        gz.Oscillator(0.0, 2.0, gz.Forcing(2.0, 0.0, 0.0, (1.0,)), gz.newton(0.6), 0.0),
        0.0,
        "cos1",
        (0.5, 1.5),
    ),
    "free ball that falls, chatter": (
        gz.Oscillator(0.0, 0.0, gz.Forcing(1.0, 0.0, -1.0, (0.6,)), gz.newton(0.5), 0.0),
        0.2,
        "r",
        (0.1, 0.9),
    ),
    "triggered": (
        gz.Oscillator(0.2, 1.0, gz.Forcing(2.2, 0.0, -0.2, (1.0, 0.2)), gz.triggered(0.6, 0.5, 0.3), 0.0),
        0.0,
        "trigger",
        (0.0, 0.8),
    ),
    "overdamped, strong kick": (gz.pinball(alpha=6.0, k=1.0, omega=1.3, V=1.5, d=-0.1, r=0.3), 1.1, "V", (0.0, 2.0)),
}

#: With one that only tests take whose Python needs no kernel of its own: for three harmonics that compiles ten seconds.
MORE_CASES = CASES | {
    "three harmonics, kick": (
        gz.Oscillator(0.4, 1.2, gz.Forcing(1.7, 0.0, 0.1, (0.5, 0.0, 0.4), (0.3, 0.2)), gz.active(0.7, 0.2), 0.15),
        0.7,
        "sigma",
        (-0.1, 0.3),
    )
}
