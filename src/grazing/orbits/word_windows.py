"""Windows between walls: where in a parameter orbits that hit the walls in a given order exist and are stable.

Orbits are searched at several values of the parameter, and each is followed through its grazes and folds by
:func:`grazing.continuation`. A window is a stretch of a branch on which the orbit is one of the oscillator and
attracts.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import product
from typing import Any, NamedTuple

import numpy as np

from grazing.maps.map import Map
from grazing.maps.stroboscopic import stroboscopic_map
from grazing.orbits.branch import Branch, continuation
from grazing.orbits.branch_search import Piece
from grazing.orbits.branch_windows import windows_of_piece
from grazing.orbits.closure import FIRED, PASSIVE, WHOLE
from grazing.orbits.contacts import contacts_of, piece_of, pieces_of, sizes_of, wall_of
from grazing.orbits.curves import Edge
from grazing.orbits.finder import Tally
from grazing.orbits.impact_equations import ImpactEquations
from grazing.orbits.impact_orbit import ImpactOrbit
from grazing.orbits.search_flights import recorded
from grazing.orbits.search_impacts import NOTHING, Solutions
from grazing.orbits.search_section import GUESSES, Search, starts_of
from grazing.orbits.search_windows import Runs, recurrences, simulated
from grazing.orbits.special import Special
from grazing.orbits.word import least_rotation
from grazing.oscillator.rig import Rig
from grazing.outcome import GrazingError, InputError, shown
from grazing.parameter import value_of

#: Pieces of a law, in words.
PIECES = {WHOLE: "whole", FIRED: "fired", PASSIVE: "passive"}
#: Values of the parameter at which orbits are searched, and random starts at each.
VALUES, STARTS, SEED = 16, 200, 0
#: Points of a branch, with what begins at its grazes.
POINTS = 3000
#: Impacts up to which flights become guesses, in a period and in all.
PER_PERIOD, IN_ALL = 8, 40
#: Windows whose ends differ by less, in parts of the range, are those of one orbit, or of its mirror image, if the
#: orbits at these ends differ by less, in periods and speeds: beside a fold they move with the root of ALIKE.
ALIKE, NEAR = 1e-9, 1e-3
#: Orbits that are nearer to each other, in units of the map's box, are one.
SAME = 1e-6


class WordWindow(NamedTuple):
    """A window of an orbit: its periods, its walls in order, its two ends, the walls grazed and its phases there.

    ``orbit`` is one inside, ``last`` those at the two ends.
    """

    N: int
    word: str
    low: Edge
    high: Edge
    walls: tuple[str, str]
    phases: tuple[float, float]
    symmetric: bool
    orbit: ImpactOrbit
    last: tuple[ImpactOrbit, ImpactOrbit]


def checked_words(model: Rig, words: Any) -> list[str]:
    """Return orders of walls, each begun so that it comes first; by default each wall alone, and to and fro.

    Raises
    ------
    InputError
        For walls that the model does not have.
    """
    names = model.names
    if words is None:
        return [*names, names] if len(names) > 1 else [names]
    given = words.split(",") if isinstance(words, str) else words
    if not isinstance(given, Sequence) or not given or not all(isinstance(one, str) for one in given):
        raise InputError(f"words is {shown(words)}; give orders of walls, such as 'A,AB,AABB'")
    found = []
    for one in (text.strip() for text in given):
        if not one or not {*one} <= {*names}:
            raise InputError(
                f"words has {shown(one)}; give the walls {' and '.join(names)} in the order of the impacts"
            )
        found.append("".join(names[i] for i in least_rotation(map(names.index, one))))
    return list(dict.fromkeys(found))


def word_windows(
    model: Rig, name: str, periods: Sequence[int], words: Sequence[str], bounds: tuple[float, float], values: int,
    told: Callable[[int], None],
) -> tuple[list[WordWindow], list[str]]:  # fmt: skip
    """Return the windows of orbits with these orders of walls, and which orbits were not followed.

    ``told(done)`` is called with numbers of values.
    """
    low, high = bounds
    P = stroboscopic_map(model)
    found: list[WordWindow] = []
    branches: list[Branch] = []
    failed: list[str] = []
    for share in range(values):
        told(share)
        value = low + (high - low) * (share + 0.5) / values
        here = P.replace(**{name: value})
        runs = flown(here, max(periods))
        for N in periods:
            for orbit in met(here, N, words, runs):
                if not any(passes(branch, orbit, value) for branch in branches):
                    branches += followed(here, orbit, name, bounds, failed)
                    told(share)
    told(values)
    for branch in branches:
        found += [window for window in windows_on(branch, model.names) if fits(window, periods, words)]
    return distinct(found, ALIKE * (high - low)), failed


def flown(P: Map, longest: int) -> Runs:
    """Fly random starts, long enough for guesses of up to so many periods."""
    model = P.walled
    assert model is not None
    return simulated(P, starts_of(Search(P, model, (longest,), STARTS, SEED, None, None), P), longest, None)


def met(P: Map, N: int, words: Sequence[str], runs: Runs) -> list[ImpactOrbit]:
    """Return orbits of N periods with these orders of walls: from flights of random starts, and from random guesses."""
    model = P.walled
    assert model is not None
    found = Solutions(model, Tally())
    window = recurrences(runs, N, STARTS)
    found.from_flights(N, recorded(model, window.points[:, 0], N, min(PER_PERIOD * N, IN_ALL)))
    wanted = [signature for word in words for signature in signatures(model, word)]
    for n in sorted({len(signature) for signature in wanted}):
        found.at_random(N, n, 2.0 * found.speed, GUESSES, SEED, [one for one in wanted if len(one) == n])
    orbits = []
    for (periods, pieces), solutions in sorted(found.found.items()):
        if periods == N and order_of(map(wall_of, pieces), model.names) in words:
            made = (found.equations(N, pieces).orbit(x, NOTHING) for x in solutions)
            orbits += [orbit for orbit in made if isinstance(orbit, ImpactOrbit) and orbit.admissible]
    return orbits


def signatures(model: Rig, word: str) -> Iterator[tuple[int, ...]]:
    """Yield the contacts of a word: of a trigger each piece of the law."""
    at = [[one for one in contacts_of(model) if wall_of(one) == model.names.index(wall)] for wall in word]
    yield from sorted({min(one[k:] + one[:k] for k in range(len(one))) for one in product(*at)})


def order_of(walls: Iterable[int], names: str) -> str:
    """Return the walls of an orbit, begun so that they come first."""
    return "".join(names[i] for i in least_rotation(walls))


def passes(branch: Branch, orbit: ImpactOrbit, value: float) -> bool:
    """Whether a branch holds an orbit."""
    box = np.array(orbit.map.box)
    size = box[:, 1] - box[:, 0]
    for other in branch.at(value):
        if other.period == orbit.period and isinstance(other, ImpactOrbit) and other.impacts == orbit.impacts:
            apart = np.abs(other.points - orbit.points[0]) / size
            if (apart < SAME).all(axis=1).any():
                return True
    return False


def followed(P: Map, orbit: ImpactOrbit, name: str, bounds: tuple[float, float], failed: list[str]) -> Iterator[Branch]:
    """Yield the branch of an orbit, and those that leave it where its symmetry breaks; note which are not followed."""
    waiting: list[tuple[Map, ImpactOrbit | Special]] = [(P, orbit)]
    while waiting:
        here, begin = waiting.pop(0)
        try:
            branch = continuation(here, begin, name, bounds, points=POINTS)
        except GrazingError as error:
            failed.append(f"{begin!r} at {name} = {value_of(name, here.params):g}: {error}")
            continue
        if begin is orbit:
            waiting += [(one.orbit.map, one) for one in branch.special if one.type == "bp" and one.admissible]
        yield branch


def windows_on(branch: Branch, names: str) -> Iterator[WordWindow]:
    """Yield the windows on a branch."""
    for number, piece in enumerate(branch.pieces):
        if not isinstance(piece.equations, ImpactEquations):
            continue
        word = order_of(piece.equations.walls, names)
        for one in windows_of_piece(piece):
            orbit = one.inner
            begin, end = (piece.orbits[i] for i in one.at)
            if isinstance(orbit, ImpactOrbit) and one.low < one.high:
                assert isinstance(begin, ImpactOrbit) and isinstance(end, ImpactOrbit)
                (low, left), (high, right) = (_edge(branch, number, piece, i) for i in one.at)
                phases = _phase(piece.equations, begin), _phase(piece.equations, end)
                last, symmetric = (begin, end), orbit.symmetric
                yield WordWindow(one.period, word, low, high, (left, right), phases, symmetric, orbit, last)


def _phase(equations: ImpactEquations, orbit: ImpactOrbit) -> float:
    """Return the phase of the forcing at the impact that begins the word of an orbit."""
    walls, model = tuple(equations.walls), orbit.model
    first = next(i for i in range(len(walls)) if walls[i:] + walls[:i] == least_rotation(walls))
    return float(model.params["omega"] * (orbit.times[first] + model.params["t0"]) % (2.0 * np.pi))


def _edge(branch: Branch, number: int, piece: Piece, index: int) -> tuple[Edge, str]:
    """Return where a window ends, at a special point of a piece or at an end of it, and the wall that this is about."""
    value, kind = float(piece.values[index]), dict(zip(piece.events, piece.types, strict=True)).get(index, "")
    if not kind:
        reason = piece.ends[0 if index == 0 else 1]
        return Edge(value, "end", "span" if reason == "bounds" else "bracket"), ""
    points = [one for one in branch.special if one.type == kind and abs(one.value - value) <= ALIKE * abs(value)]
    points.sort(key=lambda one: (one.piece != number and one.to != number, abs(one.value - value)))
    sure, wall = (points[0].converged, points[0].wall) if points else (True, "")
    return Edge(value, kind, "zero" if sure else "bracket"), wall if kind in ("gr", "v0", "law", "st") else ""


def fits(window: WordWindow, periods: Sequence[int], words: Sequence[str]) -> bool:
    """Whether a window is one of those that are asked for."""
    return window.N in periods and window.word in words


def distinct(found: Iterable[WordWindow], close: float) -> list[WordWindow]:
    """Return windows in order, each once: two orbits that are images of each other have one."""
    kept: list[WordWindow] = []
    for one in sorted(found, key=lambda one: (one.N, len(one.word), one.word, one.low.value, one.high.value)):
        if not any(
            (one.N, one.word) == (other.N, other.word)
            and abs(one.low.value - other.low.value) <= close
            and abs(one.high.value - other.high.value) <= close
            and all(map(alike, one.last, other.last))
            for other in kept
        ):
            kept.append(one)
    return kept


def alike(one: ImpactOrbit, other: ImpactOrbit) -> bool:
    """Whether two orbits are one, or mirror images of each other, begun at any of the impacts."""
    model = one.model
    if agree(one, other, other.walls, 0.0):
        return True
    turns = max(model.turns, 1)
    image = other.walls.translate(str.maketrans(model.names, model.names[::-1]))
    later = (0.5 * model.period * odd / turns for odd in range(1, 2 * turns, 2))
    return model.symmetric and any(agree(one, other, image, late) for late in later)


def agree(one: ImpactOrbit, other: ImpactOrbit, walls: str, late: float) -> bool:
    """Whether an orbit does what another one does at these walls, later by a given time and by whole periods."""
    n, T, (_height, fast) = len(one.times), one.model.period, sizes_of(one.model)
    times = np.append(other.times, other.times + one.period * T)
    speeds = np.append(other.outgoing, other.outgoing)
    for k in (k for k in range(n) if walls[k:] + walls[:k] == one.walls):
        delays = times[k : k + n] - one.times - late
        delays -= T * np.round(delays[0] / T)
        slower = speeds[k : k + n] - one.outgoing
        if (np.abs(delays) <= NEAR * T).all() and (np.abs(slower) <= NEAR * fast).all():
            return True
    return n == 0


def piece_words(window: WordWindow, model: Rig) -> str:
    """Return the pieces of the laws that act, in order; one word where they are the same."""
    orbit = window.orbit
    walls = [model.names.index(wall) for wall in orbit.walls]
    acted = [PIECES[piece_of(contact)] for contact in pieces_of(model, orbit.incoming, walls)]
    return acted[0] if len({*acted}) == 1 else "-".join(acted)
