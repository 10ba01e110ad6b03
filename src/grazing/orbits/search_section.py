"""Periodic orbits of a section of the oscillator: guesses from closed forms, simulation, neighbours and at random."""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Sequence
from dataclasses import replace
from math import floor
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from grazing.kernel.random import uniform
from grazing.maps.hits import LATER, Hits, Struck
from grazing.maps.map import Map, swift
from grazing.maps.stroboscopic import stroboscopic_map
from grazing.orbits.contacts import (
    frames_at,
    left_walls,
    letters_of_walls,
    model_of,
    numbered,
    pieces_of,
    signs_of,
    strobes_of,
)
from grazing.orbits.finder import Finder, Looked, Tally, Wanted
from grazing.orbits.free_equations import FreeEquations
from grazing.orbits.impact_equations import Flown, ImpactEquations, strobed
from grazing.orbits.impact_orbit import ImpactOrbit
from grazing.orbits.one_impact import one_impact_orbits
from grazing.orbits.orbit import Orbit, condition_of
from grazing.orbits.search_flights import recorded
from grazing.orbits.search_impacts import A_FEW, NOTHING, WORK, Solutions
from grazing.orbits.search_rest import resting_orbits
from grazing.orbits.search_windows import WIDE, drawn, recurrences, refuse_many, simulated, steps_of
from grazing.orbits.search_words import refuse_impossible
from grazing.orbits.word import least_rotation, letters_of, word
from grazing.oscillator.contact import placed
from grazing.oscillator.flight import anchored, flight
from grazing.oscillator.frames import seen_at_strobe
from grazing.oscillator.rig import Rig
from grazing.outcome import InputError, OutsideForm, level_outside, shown

if TYPE_CHECKING:
    from grazing.orbits.periodic import Searched

Floats = NDArray[np.float64]

#: Impacts of a flight beyond which it is no guess of an orbit: per period of the forcing, and in all.
PER_PERIOD, IN_ALL = 8, 40
#: Impacts up to which signatures are tried at random and by neighbours: in N periods so many times N, and two more.
MOST = 2
#: Random guesses of a signature, and of a word that is asked for.
GUESSES, AIMED = 200, 4000
#: Work on the guesses of a word, in that on the flights of one number of impacts: so words of up to 15 get them all.
MORE = 20
#: Impacts of all flights together of which a search says beforehand that they take long: some ten seconds; starts and
#: periods of each that are flown to know it.
MANY, FEW, A_WHILE = 5_000_000, 8, 3
#: Most impacts of a word that is looked for.
MOST_IMPACTS = 200
#: Forcing periods from one impact to the next that closed forms are tried for, on the impact map.
FAR = 8


class Sections(Finder):
    """Finds the orbits of a section of an oscillator in the times and velocities of impacts, and those that rest."""

    def refuse_word(self, text: str, letters: tuple[int, ...]) -> None:
        """Raise InputError for a word that no orbit can have."""
        refuse_impossible(self.P, text, letters)

    def refuse_long(self, text: str, letters: tuple[int, ...], longest: int) -> None:
        """Raise InputError for a word of a stroboscopic map with too many impacts."""
        impacts = self.impacts(letters, longest)
        if impacts > MOST_IMPACTS:
            raise InputError(
                f"word {shown(text)} and period {longest} have {impacts} impacts; allowed are {MOST_IMPACTS}: the "
                "search costs the cube of them. Simulate with gz.orbit_diagram; complete chatter is the letter C"
            )

    def impacts(self, letters: Sequence[int], longest: int) -> int:
        """Return how many impacts a word of a stroboscopic map has in so many steps."""
        return impacts_in(self.P, letters) * longest // len(letters) if letters and self.P.section == "strobe" else 0

    def find(self, wanted: Wanted) -> Looked:
        """Return the orbits; where none has the word that is wanted the virtual ones, too."""
        P, tally, model = self.P, Tally(), model_of(self.P)
        assert model is not None
        refuse_many(P, wanted.starts, wanted.periods[-1])
        search = Search(P, model, *wanted[:4], wanted.letters)
        solutions = solutions_of(search, tally)
        found, met = orbits_of(search, solutions, wanted.virtual)
        found += [orbit for orbit in resting_orbits(P, wanted.periods[-1]) if orbit.period in wanted.periods]
        asked = wanted.word
        if asked is not None and not any(orbit.admissible and orbit.word == asked for orbit in found):
            found, met = orbits_of(search, solutions, virtual=True)
        return Looked(found, tally, met, turned=turned(found, asked) if P.section == "strobe" else ())

    def of_many(self, orbit: Orbit) -> bool:
        """Whether an orbit is a flight without impacts, as a ball without a spring has one from everywhere."""
        return self.P.section == "strobe" and impacts_in(self.P, letters_of(orbit.word, self.P.letters)) == 0

    def beside(self, s: Searched, word: str | None) -> str:
        """Say up to how many impacts were tried, and how many guesses of the word."""
        if not s.signatures:
            return ""
        said = f", with up to {max(n for n, _N in s.signatures)} impacts"
        letters = letters_of(word, self.P.letters) if word is not None else ()
        impacts = max((self.impacts(letters, n) for n in s.periods), default=0)
        if self.P.section == "strobe" and aimed_guesses(impacts) < AIMED:
            said += f", {aimed_guesses(impacts)} random guesses of the word instead of {AIMED}, as each costs "
            said += f"the cube of its {impacts} impacts"
        return said


def impacts_in(P: Map, letters: Sequence[int]) -> int:
    """Return how many impacts a word of a stroboscopic map has; one that rests counts as one, as it is no sequence."""
    if isinstance(P.letters, Hits):
        return sum(len(P.letters.walls(letter)) for letter in letters)
    return sum(map(abs, letters))


def turned(found: list[Orbit], asked: str | None) -> tuple[str, ...]:
    """Return the words of admissible orbits that would have the word asked for, were the strobe at another time."""
    kept = [orbit for orbit in found if orbit.admissible]
    if asked is None or any(orbit.word == asked for orbit in kept):
        return ()
    around = {orbit.word: _around(orbit, orbit.word) for orbit in kept}
    return tuple(sorted({one.word for one in kept if around[one.word] and around[one.word] == _around(one, asked)}))


def _around(orbit: Orbit, text: str) -> tuple[int, ...]:
    """Return the walls that an orbit would hit in its period if it had a word, least rotation; none for other maps."""
    symbols = orbit.map.letters
    letters = letters_of(text, symbols)
    if not isinstance(symbols, Hits) or min(letters) < 0:
        return ()
    walls = [wall for letter in letters for wall in symbols.walls(letter)] * (orbit.period // len(letters))
    return least_rotation(walls) if walls else ()


class Search(NamedTuple):
    """What is looked for: a map of an oscillator, periods in its steps, how hard, and a word's letters if any."""

    P: Map
    model: Rig
    periods: tuple[int, ...]
    starts: int
    seed: int
    threads: int | None
    letters: tuple[int, ...] | None


def solutions_of(search: Search, tally: Tally) -> Solutions:
    """Return all solutions of the closing equations that are found."""
    found = Solutions(search.model, tally)
    wanted = sorted({*search.periods, *(n // 2 for n in search.periods if n % 2 == 0)})
    impacts = search.P.section == "impact"
    P = search.P if impacts else stroboscopic_map(search.model)
    states = starts_of(search, P)
    warn_of_many(P, states, steps_of(wanted[-1]))
    runs = simulated(P, states, wanted[-1], search.threads)
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


def warn_of_many(P: Map, states: Floats, steps: int) -> None:
    """Warn of a search that takes long, as balls hit a wall hundreds of times in a period."""
    if P.section != "strobe":
        return
    starts = states.shape[1]
    few = states[:, :: -(-starts // FEW)]
    with warnings.catch_warnings():  # the search itself says what is wrong with a law
        warnings.simplefilter("ignore")
        run = swift(P).run_columns(P.packed()[1][None], few[None].copy(), 0, A_WHILE, threads=1)
    each = impacts_in(P, run.letters.ravel().tolist()) / run.letters.size
    if starts * steps * each > MANY:
        warnings.warn(
            f"the search flies {starts} starts for {steps} periods with some {each:.0f} impacts in each, "
            f"{starts * steps * each:.1e} in all, which takes long; fewer starts take less",
            UserWarning,
            stacklevel=level_outside(),
        )


def starts_of(search: Search, P: Map) -> Floats:
    """Return random states, half of them in the map's box, half as far as forcing and impacts can carry the ball."""
    half = search.starts // 2
    frames = FreeEquations(search.model, ()).frames(NOTHING)
    c, low = frames.a, frames.za
    speed = c.size * c.rate
    box = np.array(P.box)
    if P.section == "impact":
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
    for j, seen in enumerate(search.model.seen) if 1 in counts else ():
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
    if search.P.section != "impact" and found.neighbours(N, max(counts)):
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
    impacts = search.P.section == "impact"
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
    if P.section == "impact":
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
