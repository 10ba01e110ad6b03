"""The stroboscopic map of a system of one's own: its state once per period, in letters the surfaces that are hit."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grazing.kernel.primitives import replaced
from grazing.maps.hits import MANY, Hits, most_of
from grazing.maps.map import Map
from grazing.outcome import AMBIGUOUS, FATAL, GRAZE, OK, TOO_MANY_IMPACTS
from grazing.parameter import real
from grazing.systems.contract import System
from grazing.systems.march import kernels_of, march_of
from grazing.systems.saltation import derivative_of, product_of, saltation_of
from grazing.systems.trajectory import CHATTER_IMPACTS, CHATTER_SHARE, impact_of

#: Impacts in one period after which the step gives up by name.
MAX_IMPACTS = 10_000
NAN = float("nan")
Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


def constant_period(T: float) -> Callable[..., float]:
    """Return the period as a kernel that does not depend on the parameters."""

    def period(_p: Any) -> float:
        return T

    return period


@lru_cache(maxsize=256)
def period_of(widths: tuple[float, ...], with_tangent: bool, T: Any, *parts: Any) -> Callable[..., Any]:
    """Return ``period(state, p) -> (state, letter, outcome, J)``: from the phase of the section to one period later."""
    march, impact, flight = march_of(*parts), impact_of(*parts), kernels_of(*parts).flight
    derivative, saltation = derivative_of(widths, *parts), saltation_of(widths, *parts)
    n, walls = len(widths), (len(parts) - 3) // 4
    product, most, base, alone = product_of(n), most_of(walls), walls + 1, walls == 1
    duration = T if callable(T) else constant_period(T)
    same, lost = tuple(float(i == j) for i in range(n) for j in range(n)), (NAN,) * (n * n)

    def period(state: Any, p: Any) -> Any:
        t, length = p.phase, 1.0 * duration(p)
        end, left, impacts, letter, outcome, J, counted = t + length, -1.0, 0, 0, OK, same, t
        while True:
            j, at, flags, _broken = march(t, state, end, left, p)
            outcome |= flags
            if flags & FATAL:
                break
            if j < 0:
                if with_tangent:
                    J = product(derivative(end, t, state, p), J)
                state = flight(end, t, state, p)
                break
            if with_tangent:
                J = product(derivative(at, t, state, p), J)
            before, after, _rate, _away, flags = impact(j, at, t, state, p)
            outcome |= flags
            if flags & FATAL:
                break
            if with_tangent:
                J = product(saltation(j, at, before, after, p), J)
            impacts += 1
            letter = base * letter + j + 1 if impacts <= most else letter
            t, left, state = at, 1.0 * j, after
            if impacts % CHATTER_IMPACTS == 0:
                if at - counted < CHATTER_SHARE * length or impacts > MAX_IMPACTS:
                    outcome |= TOO_MANY_IMPACTS
                    break
                counted = at
        if outcome & FATAL:
            for i in range(n):
                state = replaced(state, i, NAN)
        if outcome & (FATAL | GRAZE | AMBIGUOUS):
            J = lost
        if alone:
            letter = impacts
        elif impacts > most:
            letter = MANY
        return state, letter, outcome, J

    return period


@lru_cache(maxsize=256)
def step_of(widths: tuple[float, ...], T: Any, *parts: Any) -> Callable[..., Any]:
    """Return the step of the map."""
    period = period_of(widths, False, T, *parts)

    def step(state: Any, p: Any) -> Any:
        new, letter, outcome, _J = period(state, p)
        return new, letter, outcome

    step.made_by = step_of, (widths, T, *parts)  # type: ignore[attr-defined]
    return step


@lru_cache(maxsize=256)
def tangent_of(widths: tuple[float, ...], T: Any, *parts: Any) -> Callable[..., Any]:
    """Return the step of the map with its Jacobian."""
    period = period_of(widths, True, T, *parts)

    def tangent(state: Any, p: Any) -> Any:
        new, letter, outcome, J = period(state, p)
        return new, letter, outcome, J

    tangent.made_by = tangent_of, (widths, T, *parts)  # type: ignore[attr-defined]
    return tangent


def map_of_system(system: System, phase: float) -> Map:
    """Return the stroboscopic map of a system; :func:`grazing.stroboscopic_map` calls this."""
    phase = real(phase, "phase", "allowed is any finite number")
    T = system.period_at(system.params)
    widths = tuple(high - low for low, high in system.box)
    surfaces = "".join(one.name for one in system.surfaces)
    return Map(
        step_of(widths, system.period, *system.parts),
        params={**system.params, "phase": phase % T},
        coordinates=system.coordinates,
        box=system.box,
        letters=Hits(surfaces) if len(surfaces) > 1 else None,
        tangent=tangent_of(widths, system.period, *system.parts),
        name=f"stroboscopic map of {system.name}",
        check=partial(_outside, system),
        exact=False,
        clock=partial(_passed, system),
    )


def _outside(system: System, state: Any, params: Any) -> None:
    """Raise InputError for a start inside a surface."""
    system.refuse_inside(params["phase"], tuple(float(x) for x in state), params)


def _passed(system: System, rows: Floats, first: Floats, last: Floats, letters: Ints, steps: int) -> Floats:
    names = [*system.params, "phase"]
    each = [system.period_at(dict(zip(names, row, strict=True))) for row in rows.tolist()]
    return np.broadcast_to(steps * np.array(each)[:, None], letters.shape)
