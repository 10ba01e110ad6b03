"""Periodic orbits for the tests of proofs: attractors by simulation, doubled orbits by Newton's method near a pd."""

import numpy as np

import grazing as gz
from grazing.orbits.free_equations import FreeEquations
from grazing.orbits.impact_equations import ImpactEquations
from grazing.orbits.signature import pieces_of

NOTHING = np.empty(0)


def without_impacts(model):
    equations = FreeEquations(model, ())
    return equations.orbit(equations.start(NOTHING), NOTHING)


def closed(model, N, times, outgoing, incoming):
    """The orbit with these impacts in N periods that Newton's method finds, and its residual."""
    equations = ImpactEquations(model, (), N, pieces_of(model, incoming))
    guess = np.concatenate([times, outgoing])[None].copy()
    residual = float(equations.solve(guess, NOTHING)[0])
    return equations.orbit(guess[0], NOTHING), residual


def attractor(model, start, periods, settle=3000):
    """The periodic attractor that a start reaches, or None if it does not repeat after so many periods."""
    P = gz.stroboscopic_map(model)
    points = P.orbit(start, settle).points
    if not np.allclose(points[-1], points[-1 - periods], atol=1e-9):
        return None
    path = gz.trajectory(model, tuple(points[-1]), until=periods * model.period, samples=2)
    times, v, w = path.impact_time.values, path.v_minus.values, path.v_plus.values
    return closed(model, periods, times, w, v)[0] if len(times) else without_impacts(model)


def doubled(model, N, name, edge, inside):
    """The orbit of twice the period beside a pd at ``edge``, on the side of ``inside``."""
    for share in (3e-3, 1e-3, 1e-4, 1e-5):
        near = model.replace(**{name: edge + share * (inside - edge)})
        (one,) = (o for o in gz.one_impact_orbits(near, N) if o.admissible and o.stable)
        equations = ImpactEquations(near, (), 2 * N, pieces_of(near, np.array([one.v_minus] * 2)))
        x = np.array([one.tau, one.tau + N * near.period, one.v_plus, one.v_plus])
        along = np.linalg.svd(equations.defects(x, NOTHING)[1])[2][-1]
        for size in np.geomspace(1e-5, 0.3, 40):
            guess = (x + size * along)[None].copy()
            residual = equations.solve(guess, NOTHING)[0]
            apart = abs(guess[0, 1] - guess[0, 0] - N * near.period)
            if residual < 1e-10 and 1e-6 < apart < 0.5:
                orbit = equations.orbit(guess[0], NOTHING)
                if orbit.admissible:
                    return orbit
    raise AssertionError("no doubled orbit was found")
