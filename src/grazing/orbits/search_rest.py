"""Orbits that rest on the wall: each of them leaves it at one of the few instants at which the forcing lifts the ball.

From a release on the orbit is one and the same flight, whatever came before. So all orbits with a rest are found by
flying from every release in turn; the list is complete up to the period that was asked for.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from grazing.maps.map import Map
from grazing.orbits.contacts import kick_of, model_of, on_wall, signs_of
from grazing.orbits.free_equations import FreeEquations
from grazing.orbits.orbit import Orbit
from grazing.orbits.word import word
from grazing.oscillator.reset import contraction_at
from grazing.oscillator.rig import Rig
from grazing.oscillator.trajectory import trajectory
from grazing.outcome import FATAL, STUCK
from grazing.parameter import parameters

Floats = NDArray[np.float64]


def presses(model: Rig) -> list[float]:
    """Return the middle of every stretch of time in which the forcing presses a ball on the wall, and then lifts it.

    One for each instant in a period at which the force on a ball at the wall turns from - to +.
    """
    c = FreeEquations(model, ()).constants(np.empty(0))
    edges = np.array(c.edges)
    edges = edges[: int(np.argmax(edges >= c.T)) + 1]  # behind the last edge T is repeated
    signs = c.first * (-1.0) ** np.arange(len(edges) - 1)
    found = [0.5 * float(a + b) for a, b, sign in zip(edges[:-1], edges[1:], signs, strict=True) if sign < 0.0]
    if len(signs) > 1 and signs[0] < 0.0 and signs[-1] < 0.0:  # one stretch, cut by the period
        found.pop()
    return found if len(signs) > 1 else []


def resting_starts(P: Map, model: Rig) -> list[Floats]:
    """Return states of a map of an oscillator from which the ball rests, or has just rested, before each release."""
    starts, phase = [], float(P.params.get("phase", 0.0))
    for j, seen in enumerate(model.seen):
        if kick_of(model, j) != 0.0 or never_rests(model, j):
            continue
        c = FreeEquations(seen, ()).constants(np.empty(0))
        times = presses(seen)
        if P.section == "impact":
            starts += [np.array([t, np.copysign(0.0, signs_of(model)[j])]) for t in times]
            continue
        if not times and c.first < 0.0:
            starts.append(np.array(on_wall(model, j, phase)))
        for t in times:
            until = phase + c.T * (np.floor((t - phase) / c.T) + 1.0)
            path = trajectory(model, on_wall(model, j, t), start=t, until=until, samples=2)
            u, side = float(path.u[-1]), signs_of(model)[j]
            at = on_wall(model, j, phase)[0]  # a ball that still lies there is there but for rounding
            starts.append(np.array([side * max(side * u, side * at), float(path.v[-1])]))
    return starts


def never_rests(model: Rig, j: int) -> bool:
    """Whether a ball cannot come to rest on a moving wall, as its law takes no speed from slow impacts.

    On a wall at rest it can be put, without rounding.
    """
    wall = model.walls[j]
    ratio, speed = contraction_at(wall.law, parameters(wall.law.params))
    return wall.motion is not None and not (ratio < 1.0 and speed > 0.0)


def resting_orbits(P: Map, longest: int) -> list[Orbit]:
    """Return all orbits of a map of an oscillator that rest on the wall, up to a period; both multipliers are 0.

    Two rests are the same bits, so an orbit closes exactly.
    """
    model = model_of(P)
    assert model is not None
    found: list[Orbit] = []
    for start in resting_starts(P, model):
        path = P.orbit(start, 3 * longest + 2)
        if (path.outcomes & FATAL).any():
            continue
        rests = np.flatnonzero(path.outcomes & STUCK)
        if len(rests) == 0:
            continue
        j = int(rests[0]) + 1
        for N in range(1, min(longest, len(path.letters) - j) + 1):
            if (path.points[j + N] == path.points[j]).all() and (path.outcomes[j : j + N] & STUCK).any():
                orbit = rested(P, path.points[j : j + N], path.letters[j : j + N])
                if all(not np.array_equal(orbit.points, other.points) for other in found):
                    found.append(orbit)
                break
    return found


def rested(P: Map, points: Floats, letters: NDArray[np.int64]) -> Orbit:
    """Return an orbit with a rest, begun at the first of its points in the order of their coordinates."""
    k = min(range(len(points)), key=lambda i: tuple(points[i]))
    return Orbit(
        map=P,
        points=np.roll(points, -k, axis=0),
        word=word(letters, P.letters),
        period=len(points),
        multipliers=np.zeros(P.dimension, np.complex128),
        admissible=True,
        condition=1.0,
        residual=0.0,
    )
