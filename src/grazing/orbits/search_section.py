"""Periodic orbits of a section of the oscillator: guesses from closed forms, simulation, neighbours and at random."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from math import floor
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from grazing.kernel.random import uniform
from grazing.maps.hits import LATER, Struck
from grazing.maps.map import Map
from grazing.maps.stroboscopic import stroboscopic_map
from grazing.orbits.contacts import (
    Model,
    frames_at,
    left_walls,
    letters_of_walls,
    numbered,
    oscillators_of,
    pieces_of,
    section_of,
    signs_of,
    strobes_of,
)
from grazing.orbits.free_equations import FreeEquations
from grazing.orbits.impact_equations import Flown, ImpactEquations, strobed
from grazing.orbits.impact_orbit import ImpactOrbit
from grazing.orbits.one_impact import one_impact_orbits
from grazing.orbits.orbit import Orbit, condition_of
from grazing.orbits.search_flights import recorded
from grazing.orbits.search_impacts import A_FEW, NOTHING, WORK, Solutions, Tally
from grazing.orbits.search_windows import WIDE, drawn, recurrences, simulated
from grazing.orbits.word import word
from grazing.oscillator.contact import placed
from grazing.oscillator.flight import anchored, flight
from grazing.oscillator.frames import seen_at_strobe
from grazing.outcome import OutsideForm

Floats = NDArray[np.float64]

#: Impacts of a flight beyond which it is no guess of an orbit: per period of the forcing, and in all.
PER_PERIOD, IN_ALL = 8, 40
#: Impacts up to which signatures are tried at random and by neighbours: in N periods so many times N, and two more.
MOST = 2
#: Random guesses of a signature, and of a word that is asked for.
GUESSES, AIMED = 200, 4000
#: Work on the guesses of a word, in that on the flights of one number of impacts: so words of up to 15 get them all.
MORE = 20
#: Forcing periods from one impact to the next that closed forms are tried for, on the impact map.
FAR = 8


class Search(NamedTuple):
    """What is looked for: a map of an oscillator, periods in its steps, how hard, and a word's letters if any."""

    P: Map
    model: Model
    periods: tuple[int, ...]
    starts: int
    seed: int
    threads: int | None
    letters: tuple[int, ...] | None


def solutions_of(search: Search, tally: Tally) -> Solutions:
    """Return all solutions of the closing equations that are found."""
    found = Solutions(search.model, tally)
    wanted = sorted({*search.periods, *(n // 2 for n in search.periods if n % 2 == 0)})
    impacts = section_of(search.P) == "impact"
    P = search.P if impacts else stroboscopic_map(search.model)
    runs = simulated(P, starts_of(search, P), wanted[-1], search.threads)
    tally.starts, tally.steps = runs.starts, runs.steps
    for n in wanted:
        window = recurrences(runs, n, search.starts)
        if impacts:
            times, after, left = _impacts_of(window.points, window.letters, search)
            N = strobes_of(P, window.letters).sum(axis=1)
            speed = 2.0 * float(np.max(after, initial=found.speed))
            for turns in sorted({*range(1, FAR + 1), *N.tolist()} - {0}):
                for at in np.unique(left[N == turns], axis=0):
                    rows = (N == turns) & (left == at).all(axis=1)
                    found.from_outgoing(turns, np.hstack([times[rows], after[rows]]), at.tolist())
                if turns <= FAR * n:
                    _others(found, search, turns, [n], speed)
                found.images(turns)
            continue
        flown = recorded(search.model, window.points[:, 0], n, min(PER_PERIOD * n, IN_ALL))
        found.from_flights(n, flown)
        speed = 2.0 * float(np.max(flown.outgoing, initial=found.speed, where=np.isfinite(flown.outgoing)))
        most = min(int(flown.counts.max(initial=0)) + 1, MOST * n + 2)
        _others(found, search, n, list(range(1, most + 1)), speed)
        if search.letters is not None and n in search.periods:
            aimed, walls = _aimed(search, n, speed)
            found.from_outgoing(n, aimed, walls)
        found.images(n)
    return found


def starts_of(search: Search, P: Map) -> Floats:
    """Return random states, half of them in the map's box, half as far as forcing and impacts can carry the ball."""
    half = search.starts // 2
    frames = FreeEquations(search.model, ()).frames(NOTHING)
    c, low = frames.a, frames.za
    speed = c.size * c.rate
    box = np.array(P.box)
    if section_of(P) == "impact":
        ends = [0.0, *(sign * WIDE * speed for sign in signs_of(search.model))]
        wide = np.array([[0.0, c.T], [min(ends), max(ends)]])
    else:
        far = frames.zb if frames.two else low + frames.side * (WIDE * c.size)
        wide = np.array([sorted((low, far)), [frames.wa - WIDE * speed, frames.wa + WIDE * speed]])
    return np.hstack([drawn(search.seed, search.starts - half, box, 0.0), drawn(search.seed, half, wide, 1.0)])


def _impacts_of(points: Floats, letters: NDArray[np.int64], search: Search) -> tuple[Floats, Floats, NDArray[np.int64]]:
    """Return times, velocities away from the wall and walls of the impacts of stretches of the impact map."""
    strobes, after = strobes_of(search.P, letters), points[:, :, 1]
    passed = np.cumsum(strobes, axis=1) - strobes
    return points[:, :, 0] + passed * search.model.period, np.abs(after), left_walls(search.model, after)


def _others(found: Solutions, search: Search, N: int, counts: list[int], speed: float) -> None:
    """Add what closed forms, random guesses, neighbours and doubled orbits give for N periods."""
    for j, seen in enumerate(oscillators_of(search.model)) if 1 in counts else ():
        try:
            known = one_impact_orbits(seen, N)
        except OutsideForm:
            known = ()
        for orbit in known:
            guess = np.concatenate([orbit.times, orbit.outgoing])[None]
            found.add(N, pieces_of(search.model, orbit.incoming, [j]), guess)
    for n in counts:
        found.at_random(N, n, speed, GUESSES, search.seed)
    found.doublings(N)
    if section_of(search.P) != "impact" and found.neighbours(N, max(counts)):
        found.neighbours(N, max(counts))


def aimed_guesses(n: int) -> int:
    """Return how many random guesses of a word with n impacts are tried, each of which costs n^3."""
    return min(AIMED, MORE * WORK // (n + 2) ** 3 + A_FEW)


def _aimed(search: Search, N: int, speed: float) -> tuple[Floats, list[int]]:
    """Return random guesses whose impacts fall into the periods that a word wants, (k, 2n), and their walls."""
    assert search.letters is not None
    letters, hits = search.letters * (N // len(search.letters)), letters_of_walls(search.model)
    struck = [(0,) * max(letter, 0) if hits is None else hits.walls(letter) for letter in letters]
    where = np.repeat(np.arange(N), [len(walls) for walls in struck])
    numbers = uniform(search.seed, (float(N), -1.0, *map(float, letters)), aimed_guesses(len(where)), 2 * len(where))
    times = np.sort(where + numbers[:, : len(where)], axis=1) * search.model.period
    return np.hstack([times, numbers[:, len(where) :] * speed]), [wall for walls in struck for wall in walls]


def orbits_of(search: Search, found: Solutions, virtual: bool) -> tuple[list[Orbit], int]:
    """Return the orbits of the wanted periods as the map sees them, and how many are virtual.

    Unless they are wanted, of virtual orbits only those are among them that it takes the exact advance to tell.
    """
    orbits: list[Orbit] = []
    met = 0
    for equations, x in _wanted(search, found):
        if not virtual and isinstance(equations, ImpactEquations) and found.surely_virtual(x, equations):
            met += 1
            continue
        orbit = equations.orbit(x, NOTHING)
        met += not orbit.admissible
        orbits.append(seen(orbit, search.P))
    return orbits, met


def _wanted(search: Search, found: Solutions) -> Iterator[tuple[ImpactEquations | FreeEquations, Floats]]:
    """Yield the solutions of the wanted periods with their equations."""
    impacts = section_of(search.P) == "impact"
    if not impacts and 1 in search.periods:
        free = FreeEquations(search.model, ())
        start = free.neutral(NOTHING)
        start = start if np.isfinite(start).all() else free.start(NOTHING)
        if np.isfinite(start).all():  # in resonance there is no free orbit, or one from every state
            yield free, start
    for (N, pieces), solutions in sorted(found.found.items()):
        if (len(pieces) if impacts else N) in search.periods:
            for x in solutions:
                yield found.equations(N, pieces), x


def seen(orbit: ImpactOrbit, P: Map) -> Orbit:
    """Return an orbit of the oscillator as a map of it sees it: at its own phase, or from impact to impact."""
    phase, T = float(P.params.get("phase", 0.0)), orbit.model.period
    if section_of(P) == "impact":
        walls = np.array(numbered(orbit.model, orbit.walls))
        points = np.column_stack([np.mod(orbit.times, T), signs_of(orbit.model)[walls] * orbit.outgoing])
        passed = np.floor(np.append(orbit.times[1:], orbit.times[0] + orbit.period * T) / T) - np.floor(orbit.times / T)
        later = LATER if isinstance(P.letters, Struck) else 0
        letters = [int(letter) + later * int(wall) for letter, wall in zip(passed, np.roll(walls, -1), strict=True)]
    elif phase == 0.0:
        return replace(orbit, map=P)
    else:
        points, letters = _strobed(orbit, phase)
    J = np.eye(2)
    if orbit.admissible:
        for point in points:
            J = P.jacobian(point) @ J
    return Orbit(
        map=P,
        points=points,
        word=word(letters, P.letters),
        period=len(points),
        multipliers=orbit.multipliers,
        admissible=orbit.admissible,
        condition=condition_of(J) if orbit.admissible else float("nan"),
        residual=orbit.residual,
    )


def _strobed(orbit: ImpactOrbit, phase: float) -> tuple[Floats, list[int]]:
    """Return the states at phase, phase + T, ..., and the letters of the periods between."""
    model, T = orbit.model, orbit.model.period
    free = FreeEquations(model, ())
    c = free.frames(NOTHING)
    if orbit.impacts:
        walls = numbered(model, orbit.walls)
        return strobed(Flown(orbit.times, orbit.outgoing, walls, orbit.period), model, c, phase)
    y, v = free.state(orbit).tolist()
    y, v = flight(phase - T * floor(phase / T), anchored(0.0, y, v, c.a), c.a)
    strobe = frames_at(model, np.array([*model.params.values()]), phase)
    return np.array([seen_at_strobe(placed(0.0, y, v, 0), False, strobe)]), [0]
