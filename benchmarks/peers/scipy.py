"""SciPy's solve_ivp with the wall as a terminal event, started again after each impact."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..models import Array, Model
from ..program import ATOL, RTOL, Program, force, one_by_one


def solver(model: Model, method: str, **options: Any) -> Program:
    """Return solve_ivp with one of its methods."""
    from scipy.integrate import solve_ivp

    f, alpha, k2 = force(model), model.alpha, model.k**2
    options = {"rtol": RTOL, "atol": ATOL, **options}

    def motion(t: float, state: Any, d: float) -> tuple[float, float]:
        u, v = state
        return v, f(t, d) - alpha * v - k2 * u

    def wall(t: float, state: Any, d: float) -> float:
        return float(state[0])

    wall.terminal = True  # type: ignore[attr-defined]
    wall.direction = -1  # type: ignore[attr-defined]

    def follow(d: float, u: float, v: float, times: Array) -> Array:
        t, seen = 0.0, []
        while t < times[-1]:
            run = solve_ivp(
                motion,
                (t, times[-1]),
                (u, v),
                method=method,
                events=wall,
                args=(d,),
                t_eval=times[times > t],
                **options,
            )
            if len(run.t):
                seen.append(run.y)
            if run.status != 1:
                break
            t, (u, v) = run.t_events[0][-1], run.y_events[0][-1].tolist()
            u, v = 0.0, model.V - model.r * v
        return np.concatenate(seen, axis=1)

    return one_by_one(model, follow)
