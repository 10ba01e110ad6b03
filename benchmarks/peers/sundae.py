"""scikit-sundae: SUNDIALS' CVODE with its root finder, started again after each impact."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..models import Array, Model
from ..program import ATOL, RTOL, Program, force, one_by_one, peer

#: The status of a step that ended at an event.
HIT = 2


def cvode(model: Model, method: str) -> Program:
    """Return CVODE with the method Adams or BDF."""
    CVODE = peer("sksundae.cvode").CVODE
    f, alpha, k2 = force(model), model.alpha, model.k**2

    def motion(t: float, state: Any, rates: Any, d: float) -> None:
        u, v = state
        rates[0] = v
        rates[1] = f(t, d) - alpha * v - k2 * u

    def wall(t: float, state: Any, height: Any, d: float) -> None:
        height[0] = state[0]

    wall.terminal = [True]  # type: ignore[attr-defined]
    wall.direction = [-1]  # type: ignore[attr-defined]

    def follow(d: float, u: float, v: float, times: Array) -> Array:
        solver = CVODE(
            motion, method=method, rtol=RTOL, atol=ATOL, userdata=d, eventsfn=wall, num_events=1, max_num_steps=100_000
        )
        solver.init_step(0.0, [u, v])
        states = np.empty((2, len(times)))
        for n, time in enumerate(times):
            run = solver.step(time)
            while run.status == HIT:
                solver.init_step(float(run.t), [0.0, model.V - model.r * run.y[1]])
                run = solver.step(time)
            states[:, n] = run.y
        return states

    return one_by_one(model, follow)
