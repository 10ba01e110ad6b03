"""Models that the tests vary: every damping, one to three harmonics, shifted walls, every kind of law."""

import dataclasses
from copy import copy

import grazing as gz
from grazing.parameter import parameter_tuple


def changed_origin(P, **changes):
    """A map with an origin that knows something else: its ``settle``, its ``section``."""
    origin = copy(P.origin)
    for name, value in changes.items():
        setattr(origin, name, value)
    return dataclasses.replace(P, origin=origin)


def cubic(v, p):
    """A user's law: restitution that falls with the speed of impact."""
    return -p.e * v / (1.0 - p.c * v)


#: Kernels are compiled for a number of harmonics, and those for two are prepared: three are for what is plain Python,
#: and for flights and contacts of the oscillator, which :mod:`tests.reference` knows.
THREE = gz.Forcing(omega=1.1, t0=0.4, offset=0.2, cos=(1.0, 0.3, -0.2), sin=(0.1, 0.0, 0.25))
THREE_HARMONICS = gz.Oscillator(alpha=0.5, k=1.3, forcing=THREE, sigma=-0.3, reset=gz.newton(r=0.7))
TWO = gz.Forcing(omega=1.1, t0=0.4, offset=0.2, cos=(1.0, -0.3), sin=(0.1, 0.25))
TWO_HARMONICS = gz.Oscillator(alpha=0.5, k=1.3, forcing=TWO, sigma=-0.3, reset=gz.newton(r=0.7))

MODELS = {
    "standard": gz.pinball(),
    "passive": gz.pinball(V=0.0),
    "critical": gz.pinball(alpha=2.0, k=1.0, sigma=0.3),
    "under-damped": gz.pinball(alpha=0.2, k=3.0, V=0.1, d=0.3),
    "undamped, no stiffness": gz.pinball(alpha=0.0, k=0.0, d=-0.5, V=0.2),
    "near resonance": gz.pinball(alpha=1e-10, k=2.2, r=0.9, V=0.1),
    "soft": gz.pinball(k=1e-8),
    "stiff": gz.pinball(alpha=200.0),
    "two harmonics": TWO_HARMONICS,
    "chatter": gz.pinball(V=0.0, r=0.3, d=-0.2),
    "stick": gz.pinball(V=0.0, r=0.0),
    "trigger": gz.Oscillator(
        alpha=1.0, k=2.0, forcing=gz.Forcing(omega=2.5, offset=-0.1), reset=gz.triggered(r=0.6, V=0.5, trigger=0.1)
    ),
    "own law": gz.Oscillator(
        alpha=0.7, k=1.5, forcing=gz.Forcing(omega=1.9, offset=-0.3), sigma=0.1, reset=gz.reset(cubic, e=0.9, c=0.5)
    ),
    "elastic": gz.pinball(r=1.0, V=0.0, d=-0.3),
}
PLAIN = MODELS | {"three harmonics": THREE_HARMONICS}


def packed(P):
    """The constants a map's step gets, in plain Python."""
    p = parameter_tuple(tuple(P.params))(*P.params.values())
    return P.prepare(p) if P.prepare is not None else p


def model_of(problem):
    """The library's model of a problem of the reference."""
    law = problem.law
    reset = gz.triggered(law.r, law.V, law.speed) if law.speed else gz.active(law.r, law.V)
    forcing = gz.Forcing(omega=problem.omega, t0=problem.t0, offset=problem.offset, cos=problem.cos, sin=problem.sin)
    return gz.Oscillator(alpha=problem.alpha, k=problem.k, forcing=forcing, sigma=problem.sigma, reset=reset)
