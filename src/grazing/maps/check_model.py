"""Laws of motion that every oscillator must keep: its maps, its trajectory and ball arithmetic must agree."""

from __future__ import annotations

from typing import Any

import numpy as np

from grazing.maps.check import ROUGH, random_starts
from grazing.maps.check import check as check_map
from grazing.maps.impact import impact_map
from grazing.maps.map import CHATTER_LETTER, Map
from grazing.maps.stroboscopic import stroboscopic_map
from grazing.oscillator.constants import constants_of, forcing, section_phase
from grazing.oscillator.exact import exact_period
from grazing.oscillator.flight import anchored, flight, modes
from grazing.oscillator.model import Oscillator
from grazing.oscillator.reset import checked_velocity
from grazing.oscillator.trajectory import trajectory
from grazing.outcome import CHATTER
from grazing.parameter import parameters


def check(model: Oscillator, states: int, periods: int, seed: int) -> None:
    """Raise AssertionError with the first law that a model breaks, and the start."""
    P, Q = stroboscopic_map(model), impact_map(model)
    check_map(P, states, min(periods, 6), seed)
    check_map(Q, states, 3, seed)
    _check_grazes(model, P, 4 * states, seed)
    for start in random_starts(P, states, seed):
        flown = trajectory(model, start, until=periods * model.period)
        said = f"{model!r}, start {start.tolist()}"
        assert float(flown.u.min()) >= model.sigma, f"{said}: the ball is inside the wall, u = {float(flown.u.min())}"
        _check_impacts(model, flown, said)
        _check_motion(model, flown, said)
        orbit = P.orbit(start, periods)
        if not np.bitwise_or.reduce(orbit.outcomes) & ROUGH:
            end = np.array([flown.u.values[-1], flown.v.values[-1]])
            grown = np.abs(orbit.points).max() + 1.0
            for i in range(periods):
                grown *= max(1.0, float(np.linalg.norm(P.jacobian(orbit.points[i]), 2)))
            error = float(np.abs(end - orbit.points[-1]).max())
            assert error <= 1e-13 * grown, f"{said}: trajectory and stroboscopic map differ by {error:.1e}"
            _check_returns(model, Q, flown, said)


def _check_grazes(model: Oscillator, P: Map, count: int, seed: int) -> None:
    """Build flights that touch the wall, a little above or below it, and compare every path with ball arithmetic."""
    random = np.random.default_rng(seed)
    row = np.array(list(P.params.values()))[None]
    for _ in range(count):
        start = _grazing_start(model, random, 10.0 ** -random.uniform(2.0, 12.0) * random.choice((-1.0, 1.0)))
        truth = None if start is None else exact_period(model, start)
        if start is None or truth is None or truth.outcome & ROUGH:
            continue
        letter = CHATTER_LETTER if truth.outcome & CHATTER else truth.impacts
        for algorithm in ("block", "scalar"):
            lanes = np.array(start).reshape(1, 2, 1)
            found = P.run_columns(row, lanes, 0, 1, algorithm=algorithm, threads=1)
            said = f"{model!r}: from {start} ({algorithm})"
            assert found.letters[0, 0, 0] == letter, (
                f"{said} {found.letters[0, 0, 0]} impacts instead of {letter}, nearest miss {truth.near:.1e}"
            )
            slopes = P.jacobian(start)
            grown = max(1.0, float(np.abs(slopes).max())) if np.isfinite(slopes).all() else np.inf
            error = float(np.abs(found.points[0, 0, :, 0] - np.array(truth.state)).max())
            scale = np.abs(start).max() + np.abs(truth.state).max() + abs(model.sigma)
            assert error <= 1e-13 * (scale + 1.0) * grown, f"{said} the state is {error:.1e} off"


def _grazing_start(model: Oscillator, random: np.random.Generator, height: float) -> tuple[float, float] | None:
    """Return a state at t = 0 whose free flight turns at this height above the wall; None if it starts in the wall."""
    p = parameters({**model.params, "phase": 0.0})
    c = constants_of(model.harmonics, section_phase)(p)
    t = c.T * random.uniform(0.05, 0.95)
    F, _dF = forcing(t, c)
    if F <= 0.0:
        return None
    E = np.array(modes(t, c)).reshape(2, 2)
    y, v = flight(t, anchored(0.0, 0.0, 0.0, c), c)
    if not abs(np.linalg.det(E)) > 1e-30:
        return None
    start = np.linalg.solve(E, np.array([height - y, -v]))
    if not np.abs(start).max() < 1e6 * c.size or start[0] < 0.0:
        return None
    return float(start[0] + model.sigma), float(start[1])


def _check_impacts(model: Oscillator, flown: Any, said: str) -> None:
    times, before, after = flown.impact_time.values, flown.v_minus.values, flown.v_plus.values
    assert (np.diff(times) >= 0.0).all(), f"{said}: impacts out of order"
    assert (before <= 0.0).all(), f"{said}: an impact moves away from the wall"
    for v, w in zip(before, after, strict=True):
        if w > 0.0:  # 0 stands for the rest that ends a chatter
            expected = checked_velocity(model.reset, float(v), model.reset.params)
            assert w == expected, f"{said}: v_minus = {v} left with {w}, the law says {expected}"


def _check_motion(model: Oscillator, flown: Any, said: str) -> None:
    t, u, v = flown.t.values, flown.u.values, flown.v.values
    f, forcing = np.full_like(t, model.forcing.offset), model.forcing
    for j, (c, s) in enumerate(zip(forcing.cos, forcing.sin, strict=True), start=1):
        angle = j * forcing.omega * (t + forcing.t0)
        f += c * np.cos(angle) + s * np.sin(angle)
    a = f - model.alpha * v - model.k2 * u
    dt = np.diff(t)
    flying = (dt > 0.0) & (np.maximum(u[1:], u[:-1]) > model.sigma)
    # the trapezium rule, exact up to dt^3 times a second derivative that the rates bound
    rate = max(abs(model.alpha), abs(model.k2) ** 0.5, len(forcing.cos) * forcing.omega)
    slack = dt * (rate * dt) ** 2 * (np.abs(a).max() + rate * np.abs(v).max() + 1e-12) + 1e-13
    wrong_u = np.abs(np.diff(u) - 0.5 * dt * (v[1:] + v[:-1])) > slack
    wrong_v = np.abs(np.diff(v) - 0.5 * dt * (a[1:] + a[:-1])) > slack * max(1.0, rate)
    bad = flying & (wrong_u | wrong_v)
    assert not bad.any(), f"{said}: the equation of motion fails near t = {t[:-1][bad][:1]}"


def _check_returns(model: Oscillator, Q: Map, flown: Any, said: str) -> None:
    times, after = flown.impact_time.values, flown.v_plus.values
    for i in range(min(4, len(times) - 1)):
        (tau, w), _letter = Q((times[i] % model.period, after[i]))
        late = abs((tau - times[i + 1] + 0.5 * model.period) % model.period - 0.5 * model.period)
        slow = 1e-11 / max(abs(flown.v_minus.values[i + 1]), 1e-3) ** 2
        assert late <= slow, f"{said}: impact {i + 1} at {times[i + 1]}, the impact map is {late:.1e} off"
        assert abs(w - after[i + 1]) <= slow, (
            f"{said}: impact {i + 1} leaves with {after[i + 1]}, the impact map says {w}"
        )
