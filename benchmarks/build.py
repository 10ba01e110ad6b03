"""Write the fixed set: `python -m benchmarks.build` from the root of the project, about two minutes.

Every state is computed with 40 digits by the reference of the tests and then rounded to double.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import numpy as np

from tests.reference import Dip, Problem, active, advance, dips

from .fixed import EACH, FILE, ORBITS, WRONG, Kind
from .models import MODELS, STANDARD, Array, Model, family

D = np.linspace(0.05, 0.16, 10)  # the constant forces of the stress set
DEPTHS = np.array([float(f"1e-{n}") for n in range(4, 13)])
PERIODS, ORBIT_D = 20, 0.09  # of the ordinary orbits
MARK = 10.0 * WRONG  # the least that a wrong answer changes the state one period later


def problem(model: Model, d: float) -> Problem:
    """Return a model in the words of the reference."""
    law = active(model.r, model.V)
    return Problem(model.alpha, model.k, model.omega, offset=d, cos=model.cos, sin=model.sin, law=law)


def strobes(p: Problem, u: float, v: float, periods: int) -> Array:
    """Return the states (2, periods) of one orbit at the strobes."""
    return np.array([(float(s.u), float(s.v)) for s in advance(p, u, v, periods)]).T


def telling(p: Problem, dip: Dip, depth: float) -> bool:
    """Whether the wrong answer, hit or no hit, leaves a clear mark: what a wall a little lower or higher would do."""
    away = replace(p, sigma=-1.5 * depth if dip.hits else 1.5 * depth)
    wrong, right = strobes(away, dip.u, dip.v, 1), strobes(p, dip.u, dip.v, 1)
    return bool(np.abs(wrong - right).max() > MARK)


def stress() -> dict[str, Array]:
    """Return starts that just hit, or just clear, the wall in their first period, and their states after it."""
    starts: Array = np.empty((2, len(D), len(DEPTHS), len(Kind), EACH))
    after: Array = np.empty_like(starts)
    for (i, d), (j, depth) in product(enumerate(D.tolist()), enumerate(DEPTHS.tolist())):
        p = problem(STANDARD, d)
        found = [dip for dip in dips(p, depth, 3 * EACH, seed=3) if telling(p, dip, depth)]
        for kind in Kind:
            fitting = [dip for dip in found if dip.hits == (kind == Kind.DIP)]
            for k, dip in enumerate(fitting[:EACH]):
                starts[:, i, j, kind, k] = dip.u, dip.v
                after[:, i, j, kind, k] = strobes(p, dip.u, dip.v, 1)[:, 0]
            assert len(fitting) >= EACH, f"only {len(fitting)} states for d = {d:g}, depth {depth:g}"
    return {"d": D, "depth": DEPTHS, "stress_start": starts, "stress_after": after}


def ordinary() -> dict[str, Array]:
    """Return random orbits of each model and their states at the strobes."""
    _, u, v = family(1, ORBITS)
    states = np.empty((len(MODELS), 2, PERIODS, ORBITS))
    for i, model in enumerate(MODELS.values()):
        p = problem(model, ORBIT_D)
        for j in range(ORBITS):
            states[i, :, :, j] = strobes(p, u[0, j], v[0, j], PERIODS)
    return {"orbit_d": np.array([ORBIT_D]), "orbit_start": np.stack([u[0], v[0]]), "orbit_states": states}


if __name__ == "__main__":
    np.savez_compressed(FILE, allow_pickle=False, **stress(), **ordinary())
