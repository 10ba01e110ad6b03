"""Solvers that are asked one thing: whether an orbit hits the wall within a period."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import Any

import grazing as gz

from .program import peer

ALPHA, K, OMEGA = 0.1, 1.0, 2.8
PERIOD = 2.0 * math.pi / OMEGA

#: ``sees(d, t, u, v)``: whether an impact is found within one period of time t, for the constant force d.
Sees = Callable[[float, float, float, float], bool]


def scipy(method: str, rtol: float, atol: float) -> Sees:
    """Return SciPy's solve_ivp."""
    from scipy.integrate import solve_ivp

    def motion(t: float, state: Any, d: float) -> tuple[float, float]:
        u, v = state
        return v, math.cos(OMEGA * t) + d - ALPHA * v - K**2 * u

    def wall(t: float, state: Any, d: float) -> float:
        return float(state[0])

    wall.direction = -1  # type: ignore[attr-defined]

    def sees(d: float, t: float, u: float, v: float) -> bool:
        span = (t, t + PERIOD)
        run = solve_ivp(motion, span, (u, v), method=method, rtol=rtol, atol=atol, events=wall, args=(d,))
        return bool(run.t_events[0].size)

    return sees


def cvode() -> Sees:
    """Return CVODE, Adams, through scikit-sundae."""
    CVODE = peer("sksundae.cvode").CVODE

    def motion(t: float, state: Any, rates: Any, d: float) -> None:
        u, v = state
        rates[0] = v
        rates[1] = math.cos(OMEGA * t) + d - ALPHA * v - K**2 * u

    def wall(t: float, state: Any, height: Any, d: float) -> None:
        height[0] = state[0]

    wall.direction = [-1]  # type: ignore[attr-defined]

    def sees(d: float, t: float, u: float, v: float) -> bool:
        solver = CVODE(motion, method="Adams", rtol=1e-9, atol=1e-12, userdata=d, eventsfn=wall, num_events=1)
        solver.init_step(t, [u, v])
        return bool(solver.step(t + PERIOD).status == 2)

    return sees


def diffrax() -> Sees:
    """Return diffrax, Tsit5."""
    dx, jax = peer("diffrax"), peer("jax")
    jax.config.update("jax_enable_x64", True)

    def motion(t: Any, state: Any, d: Any) -> Any:
        u, v = state
        return v, jax.numpy.cos(OMEGA * t) + d - ALPHA * v - K**2 * u

    def height(t: Any, y: Any, args: Any, **_: Any) -> Any:
        return y[0]

    @jax.jit  # type: ignore[untyped-decorator]
    def solve(d: Any, t: Any, u: Any, v: Any) -> Any:
        run = dx.diffeqsolve(
            dx.ODETerm(motion),
            dx.Tsit5(),
            t,
            t + PERIOD,
            None,
            (u, v),
            d,
            stepsize_controller=dx.PIDController(rtol=1e-9, atol=1e-12),
            event=dx.Event(height, direction=False),
            throw=False,
        )
        return run.result == dx.RESULTS.event_occurred

    return lambda d, t, u, v: bool(solve(d, t, u, v))


def heyoka() -> Sees:
    """Return heyoka at its default tolerance."""
    hy = peer("heyoka")
    u, v = hy.make_vars("u", "v")
    motion = [(u, v), (v, hy.cos(OMEGA * hy.time) + hy.par[0] - ALPHA * v - K**2 * u)]
    wall = hy.t_event(u, direction=hy.event_direction.negative)
    solver = hy.taylor_adaptive(motion, state=[0.1, 0.1], pars=[0.0], t_events=[wall])

    def sees(d: float, t: float, u: float, v: float) -> bool:
        solver.time = t
        solver.reset_cooldowns()
        solver.pars[0], solver.state[:] = d, (u, v)
        return bool(solver.propagate_until(t + PERIOD)[0] != hy.taylor_outcome.time_limit)

    return sees


def grazing() -> Sees:
    """Return gz.trajectory."""
    model = gz.pinball(alpha=ALPHA, k=K, omega=OMEGA)

    def sees(d: float, t: float, u: float, v: float) -> bool:
        return bool(gz.trajectory(model.replace(d=d), (u, v), start=t, until=t + PERIOD).sizes["impact"])

    return sees


FINDERS: dict[str, Callable[[], Sees]] = {
    "SciPy RK45, 1e-3": partial(scipy, "RK45", 1e-3, 1e-6),
    "SciPy RK45, 1e-9": partial(scipy, "RK45", 1e-9, 1e-12),
    "SciPy DOP853, 1e-12": partial(scipy, "DOP853", 1e-12, 1e-15),
    "SciPy LSODA, 1e-9": partial(scipy, "LSODA", 1e-9, 1e-12),
    "CVODE Adams, 1e-9": cvode,
    "diffrax Tsit5, 1e-9": diffrax,
    "heyoka": heyoka,
    "grazing": grazing,
}
