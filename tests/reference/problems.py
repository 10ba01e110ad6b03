"""Named problems that cover the regimes of the oscillator, with starts that can be followed for long."""

from __future__ import annotations

from .exact import Problem, active, newton, trigger

bumper = active(0.8, 0.4)

PROBLEMS: dict[str, Problem] = {
    "standard d=0.12": Problem(3.0, 1.0, 2.2, offset=0.12, law=bumper),
    "standard d=0.09": Problem(3.0, 1.0, 2.2, offset=0.09, law=bumper),
    "passive": Problem(3.0, 1.0, 2.2, offset=0.12, law=newton(0.8)),
    "critical": Problem(2.0, 1.0, 2.2, offset=0.1, law=bumper),
    "nearly critical": Problem(2.0 + 1e-13, 1.0, 2.2, offset=0.1, law=bumper),
    "under-damped": Problem(0.2, 3.0, 2.2, offset=0.3, law=active(0.6, 0.2)),
    "undamped": Problem(0.0, 1.0, 2.3, offset=0.1, law=active(0.5, 0.3)),
    "resonance": Problem(0.0, 1.0, 1.0, offset=0.1, law=active(0.5, 0.1)),
    "resonance, growing": Problem(0.0, 1.0, 1.0, sigma=-6.0, law=active(0.3, 0.1)),
    "near resonance": Problem(1e-10, 1.0, 1.0 + 1e-9, offset=0.1, law=active(0.5, 0.1)),
    "soft": Problem(1e-10, 1e-8, 2.2, offset=-0.6, cos=(0.5,), law=active(0.5, 0.3)),
    "soft, driven": Problem(1e-10, 1e-8, 2.2, offset=-0.3, law=active(0.5, 0.2)),
    "no stiffness": Problem(0.5, 0.0, 1.5, offset=-0.2, law=active(0.6, 0.3)),
    "no stiffness, no damping": Problem(0.0, 0.0, 1.5, offset=-0.45, cos=(0.25,), law=active(0.5, 0.4)),
    "no stiffness, no damping, driven": Problem(0.0, 0.0, 1.5, offset=-0.25, law=active(0.6, 0.2)),
    "three harmonics": Problem(
        1.2, 1.3, 1.7, t0=0.4, offset=0.05, cos=(0.6, -0.3, 0.2), sin=(0.2, 0.4, -0.1), law=bumper
    ),
    "high obstacle": Problem(3.0, 1.0, 2.2, t0=0.5, offset=0.4, sigma=0.3, law=bumper),
    "low obstacle": Problem(3.0, 1.0, 2.2, offset=-0.2, sin=(0.3,), sigma=-0.3, law=bumper),
    "pressed": Problem(1.0, 1.0, 2.0, offset=-1.5, law=active(0.6, 0.5)),
    "lifted": Problem(1.0, 1.0, 2.0, offset=1.3, law=active(0.6, 0.5)),
    "trigger": Problem(3.0, 1.0, 2.2, offset=0.1, law=trigger(0.8, 0.4, 0.15)),
    "trigger, chatter": Problem(3.0, 1.0, 2.2, offset=-0.1, law=trigger(0.4, 0.3, 0.6)),
    "many impacts": Problem(1.0, 1.0, 1.0, offset=-1.2, law=active(0.9, 0.2)),
    "chatter": Problem(3.0, 1.0, 2.2, offset=-0.2, law=newton(0.3)),
    "stick": Problem(3.0, 1.0, 2.2, offset=0.05, law=newton(0.0)),
    "stiff": Problem(200.0, 1.0, 2.2, offset=-0.6, law=bumper),
    "very stiff": Problem(1000.0, 5.0, 2.2, offset=-0.6, law=bumper),
    "stiff spring": Problem(2.0, 20.0, 2.2, offset=0.9, law=active(0.6, 0.01)),
    "slow": Problem(3.0, 1.0, 0.1, offset=0.05, law=active(0.7, 0.3)),
    "fast": Problem(0.5, 1.0, 10.0, offset=0.005, law=active(0.7, 0.02)),
}

# all in periodic regimes, or so weakly expanding that PERIODS[name] periods can be compared
STARTS: dict[str, tuple[tuple[float, float], ...]] = {
    "standard d=0.12": ((0.02, 0.278), (0.115, -0.196), (0.521, 0.231), (0.0, -0.3), (0.0, 0.0)),
    "standard d=0.09": ((0.114, -0.398), (0.034, 0.356), (0.721, -0.376), (0.0, -0.1), (0.0, 0.0)),
    "passive": ((0.004, -0.223), (0.066, -0.003), (0.175, -0.032), (0.232, -0.383), (0.0, -0.2)),
    "critical": ((0.126, 0.045), (0.096, -0.251), (0.577, 0.169), (0.0, -0.2)),
    "nearly critical": ((0.126, 0.045), (0.096, -0.251), (0.577, 0.169), (0.0, -0.2)),
    "under-damped": ((0.026, 0.039), (0.407, 0.223), (0.392, -0.376), (0.0, -0.25)),
    "undamped": ((0.007, 0.163), (0.059, -0.264), (0.616, 0.032), (0.0, 0.0)),
    "resonance": ((0.077, 0.362), (0.04, 0.038), (0.627, 0.256), (0.0, -0.1)),
    "resonance, growing": ((0.2, 0.1), (-3.0, 1.0), (1.0, -0.5)),
    "near resonance": ((0.081, 0.099), (0.004, -0.216), (0.689, 0.239), (0.0, -0.1)),
    "soft": ((0.05, 0.2), (0.2, -0.1), (0.02, 0.3), (0.0, -0.3)),
    "soft, driven": ((0.121, 0.015), (0.404, -0.012), (0.008, 0.296)),
    "no stiffness": ((0.038, 0.273), (0.604, -0.2), (0.276, -0.344), (0.0, -0.1)),
    "no stiffness, no damping": ((0.05, 0.2), (0.2, -0.1), (0.02, 0.3)),
    "no stiffness, no damping, driven": ((0.258, -0.021), (0.024, 0.022), (0.0, -0.2)),
    "three harmonics": ((0.016, 0.32), (0.017, -0.386), (0.117, 0.175), (0.0, -0.3)),
    "high obstacle": ((0.402, 0.036), (0.479, 0.119), (0.616, 0.061), (0.3, -0.2)),
    "low obstacle": ((-0.155, 0.3), (-0.052, 0.351), (0.295, -0.067), (-0.3, -0.2)),
    "pressed": ((0.132, -0.37), (0.086, -0.263), (0.694, 0.379)),
    "lifted": ((0.031, 0.139), (0.065, -1.5), (0.72, -2.5), (0.0, -0.4)),
    "trigger": ((0.148, 0.226), (0.051, -0.23), (0.706, 0.15)),
    "trigger, chatter": ((0.073, 0.388), (0.013, -0.264), (0.729, -0.23)),
    "many impacts": ((0.13, 0.083), (0.143, 0.31), (0.059, 0.293)),
    "chatter": ((0.118, 0.263), (0.457, -0.221), (0.0, -0.1)),
    "stick": ((0.139, -0.034), (0.042, 0.23), (0.536, -0.327), (0.0, 0.0), (0.0, -0.5)),
    "stiff": ((0.005, 0.0), (0.01, -0.5), (0.002, -0.3)),
    "very stiff": ((0.005, 0.0), (0.001, -0.5)),
    "stiff spring": ((0.005, 0.0), (0.01, -0.2), (0.002, -0.1)),
    "slow": ((0.137, 0.376), (0.784, 0.034), (0.0, -0.3)),
    "fast": ((0.046, -0.203), (0.148, -0.042), (0.753, -0.088)),
}

SHORT = {"resonance, growing": 8, "soft, driven": 8, "no stiffness, no damping, driven": 8}
PERIODS: dict[str, int] = {name: SHORT.get(name, 20) for name in PROBLEMS}
