"""heyoka: a Taylor method that isolates the roots of its polynomials; scalar, and many orbits in SIMD lanes."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..models import Array, Columns, Model
from ..program import Program, in_lanes, one_by_one, peer, strobes

LANES = 16


def equations(hy: Any, model: Model) -> tuple[list[Any], Any]:
    """Return the equations of motion, with d as the parameter, and u, whose zeros are the impacts."""
    u, v = hy.make_vars("u", "v")
    f = hy.par[0]
    for w, c, s in model.waves:
        f += c * hy.cos(w * hy.time) + (s * hy.sin(w * hy.time) if s else 0.0)
    return [(u, v), (v, f - model.alpha * v - model.k**2 * u)], u


def batch(model: Model, **options: Any) -> Program:
    """Return heyoka in batch mode: the kernel advances LANES orbits at once, walls are terminal events."""
    hy = peer("heyoka")
    motion, u = equations(hy, model)

    def impact(solver: Any, sign: int, lane: int) -> bool:
        state[0, lane] = 0.0
        state[1, lane] = model.V - model.r * state[1, lane]
        return True

    def above(solver: Any, sign: int, lane: int) -> bool:
        state[0, lane] = model.gap
        state[1, lane] = -model.V - model.r * state[1, lane]
        return True

    walls = [hy.t_event_batch(u, direction=hy.event_direction.negative, callback=impact)]
    if model.gap is not None:
        walls.append(hy.t_event_batch(u - model.gap, direction=hy.event_direction.positive, callback=above))
    start = np.full((2, LANES), 0.1)
    solver = hy.taylor_adaptive_batch(motion, state=start, pars=np.zeros((1, LANES)), t_events=walls, **options)
    state = solver.state  # a view of the solver's own memory, as is solver.pars

    def program(columns: Columns, transient: int, keep: int) -> tuple[Array, Array]:
        times = np.repeat(np.append(0.0, strobes(model, transient, keep))[:, None], LANES, axis=1)

        def advance(d: Array, u: Array, v: Array) -> Array:
            solver.set_time(0.0)
            solver.reset_cooldowns()
            solver.pars[0], state[0], state[1] = d, u, v
            states: Array = solver.propagate_grid(times)[1][1:]
            return states

        return in_lanes(advance, columns, keep, LANES)

    return program


def scalar(model: Model, **options: Any) -> Program:
    """Return heyoka with one orbit at a time."""
    hy = peer("heyoka")
    motion, u = equations(hy, model)

    def impact(solver: Any, sign: int) -> bool:
        state[0] = 0.0
        state[1] = model.V - model.r * state[1]
        return True

    wall = hy.t_event(u, direction=hy.event_direction.negative, callback=impact)
    solver = hy.taylor_adaptive(motion, state=[0.1, 0.1], pars=[0.0], t_events=[wall], **options)
    state = solver.state

    def follow(d: float, u: float, v: float, times: Array) -> Array:
        solver.time = 0.0
        solver.reset_cooldowns()
        solver.pars[0], state[0], state[1] = d, u, v
        states: Array = solver.propagate_grid(np.append(0.0, times))[-1][1:].T
        return states

    return one_by_one(model, follow)
