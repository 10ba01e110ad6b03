"""diffrax: jitted Runge-Kutta methods on JAX, all orbits at once through vmap, one thread."""

from __future__ import annotations

import os
from typing import Any

import numpy as np

from ..models import Array, Columns, Model
from ..program import ATOL, RTOL, Program, in_lanes, peer

#: Orbits side by side; more are not faster.
LANES = 2000


def solver(model: Model, method: str) -> Program:
    """Return diffrax with one of its methods; the wall is an event with a root finder."""
    os.environ.setdefault("XLA_FLAGS", "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1")
    dx, jax, optimistix = peer("diffrax"), peer("jax"), peer("optimistix")
    jax.config.update("jax_enable_x64", True)
    jnp, T = jax.numpy, model.period

    def motion(t: Any, state: Any, d: Any) -> Any:
        u, v = state
        f = d + sum(c * jnp.cos(w * t) + s * jnp.sin(w * t) for w, c, s in model.waves)
        return v, f - model.alpha * v - model.k**2 * u

    def height(t: Any, y: Any, args: Any, **_: Any) -> Any:
        return y[0]

    settings = {
        "terms": dx.ODETerm(motion),
        "solver": getattr(dx, method)(),
        "stepsize_controller": dx.PIDController(rtol=RTOL, atol=ATOL),
        "event": dx.Event(height, optimistix.Newton(1e-12, 1e-12), direction=False),
        "saveat": dx.SaveAt(t1=True),
        "max_steps": None,
        "throw": False,
    }

    def flight(carry: Any) -> Any:
        t, u, v, d = carry
        run = dx.diffeqsolve(t0=t, t1=T, dt0=None, y0=(u, v), args=d, **settings)
        hit = run.result == dx.RESULTS.event_occurred
        u, v = run.ys[0][-1], run.ys[1][-1]
        return run.ts[-1], jnp.where(hit, 0.0, u), jnp.where(hit, model.V - model.r * v, v), d

    def period(d: Any, u: Any, v: Any) -> Any:
        _, u, v, _ = jax.lax.while_loop(lambda carry: carry[0] < T, flight, (jnp.zeros(()), u, v, d))
        return u, v

    step = jax.jit(jax.vmap(period))

    def program(columns: Columns, transient: int, keep: int) -> tuple[Array, Array]:
        def advance(d: Array, u: Any, v: Any) -> Array:
            states = []
            for _ in range(transient + keep):
                u, v = step(d, u, v)
                states.append((u, v))
            return np.array(states[transient:])

        return in_lanes(advance, columns, keep, LANES)

    return program
