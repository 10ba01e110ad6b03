"""Where a flight grazes, or an impact loses its speed, another branch begins: with an impact more, or with one less."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from grazing.orbits.closing import DIPS, OTHER, WHEN
from grazing.orbits.closure import PASSIVE, WHOLE
from grazing.orbits.contacts import PIECES, kick_of
from grazing.orbits.events import Event
from grazing.orbits.free_equations import FreeEquations
from grazing.orbits.impact_equations import ImpactEquations
from grazing.orbits.switching import Seed, begins
from grazing.oscillator.frames import frame_of
from grazing.oscillator.reset import triggered_law
from grazing.oscillator.rig import Rig

Floats = NDArray[np.float64]

#: Impacts a period beyond which no branch with one more is begun: grazes accumulate at an onset of chatter.
MOST = 12


def begun(equations: ImpactEquations, event: Event, x: Floats, p: Floats) -> Seed | None:
    """Return the branch that begins at an event of an orbit with impacts."""
    if kicked(equations, event, p):
        return None
    return grown(equations, event, x, p) if event.type == "gr" else shrunk(equations, event, x, p)


def kicked(equations: ImpactEquations | FreeEquations, event: Event, p: Floats) -> bool:
    """Whether the law of the wall kicks a ball that only touches it: then no other branch begins."""
    return kick_of(equations.model_at(p), equations.touched(event.type, event.where)[1]) != 0.0


def slowest(model: Rig, wall: int) -> int:
    """Return the contact of an impact without speed."""
    return PIECES * wall + (PASSIVE if model.walls[wall].law.law is triggered_law else WHOLE)


def risen(equations: FreeEquations, event: Event, x: Floats, p: Floats) -> Seed | None:
    """Return the branch with one impact, which begins with speed 0 where a free flight touches the wall."""
    wall = event.where
    seen = frame_of(wall == 1, equations.frames(p))
    if kicked(equations, event, p) or not any((*seen.cos, *seen.sin)):  # a ball at rest lies down on the wall
        return None
    _end, _E, dips = equations.turned(x, p)
    new = ImpactEquations(equations.model, equations.names, 1, (slowest(equations.model, wall),), equations.spans)
    return begins(new, np.array([dips[wall, 1], 0.0]), p, "v0", 0)


def grown(equations: ImpactEquations, event: Event, x: Floats, p: Floats) -> Seed | None:
    """Return the branch with one impact more, which begins with speed 0 where a flight touches the wall."""
    model, n, (i, wall) = equations.model, equations.n, equations.touched(event.type, event.where)
    if n >= MOST * equations.N:
        return None
    row = equations.profile(x, p).table[i]
    row = row if wall == equations.walls[i] else np.roll(row, -OTHER)
    if row[DIPS] == 0:
        return None
    times = np.insert(x[:n], i + 1, x[i] + row[WHEN])
    after = np.insert(x[n:], i + 1, 0.0)
    pieces = (*equations.pieces[: i + 1], slowest(model, wall), *equations.pieces[i + 1 :])
    new = ImpactEquations(model, equations.names, equations.N, pieces, equations.spans)
    return begins(new, np.concatenate([times, after]), p, "v0", i + 1)


def shrunk(equations: ImpactEquations, event: Event, x: Floats, p: Floats) -> Seed | None:
    """Return the branch with one impact less, which begins where that impact has lost its speed."""
    n, k = equations.n, event.where
    if n == 1:
        free = FreeEquations(equations.model, equations.names, equations.spans)
        start = free.start(p)
        wall = equations.walls[0]
        if not np.isfinite(start).all() or abs(free.turned(start, p)[2][wall, 0]) > 1e-6 * free.scale[0]:
            return None
        return begins(free, start, p, "gr", wall)
    times, after = np.delete(x[:n], k), np.delete(x[n:], k)
    pieces = (*equations.pieces[:k], *equations.pieces[k + 1 :])
    new = ImpactEquations(equations.model, equations.names, equations.N, pieces, equations.spans)
    flight = (k - 1) % (n - 1)
    return begins(new, np.concatenate([times, after]), p, "gr", equations.walls[k] * (n - 1) + flight)
