"""The pieces of a branch: seeds that are followed, and what begins at the special points on the way."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import combinations
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from grazing.copies import ByValue
from grazing.orbits.corrector import Point, closed, point_at, unscaled
from grazing.orbits.equations import Equations
from grazing.orbits.events import HALVES, Event, located
from grazing.orbits.orbit import Orbit
from grazing.orbits.path import Path, follow, joined
from grazing.orbits.point_equations import PointEquations
from grazing.orbits.rounding import moved_by_rounding
from grazing.orbits.signature import equations_of
from grazing.orbits.solved import Solved
from grazing.orbits.special import SPECIAL, Relabelling, Special
from grazing.orbits.switching import (
    BARELY,
    ZERO,
    Seed,
    allowed,
    evened,
    nearly_even,
    on_the_edge,
    once,
    partners,
    turns,
)
from grazing.orbits.word import word
from grazing.outcome import abridged, listed

Floats = NDArray[np.float64]

#: Part of all points that one of several branches may take.
SHARE = 0.25
#: Part of the range and of its size by which a graze that is noted twice may differ: two test functions vanish there.
ALIKE = 1e-9


@dataclass(frozen=True, eq=False)
class Piece(ByValue):
    """A stretch of a branch on which the same equations hold: its orbits in order, and why it ends at either end.

    ``events`` are the numbers of the orbits at special points and ``types`` what happens there; where the piece begins
    at a special point of another one, its first orbit is among them, and where it comes back to that, its last one.
    """

    equations: Equations = field(compare=False)  # what it keeps of its work is no part of the result
    unknowns: Floats
    values: Floats
    orbits: Sequence[Orbit]
    events: tuple[int, ...]
    types: tuple[str, ...]
    ends: tuple[str, str]

    def __repr__(self) -> str:
        words = listed(map(abridged, dict.fromkeys(orbit.word for orbit in self.orbits)), 8)
        return f"<Piece of {len(self.orbits)} orbits of {words}; ends {' and '.join(self.ends)}>"

    def passing(self, value: float) -> list[int]:
        """Return after which orbits the piece passes a value of the parameter, or lies at it."""
        a, b = self.values[:-1], self.values[1:]
        return np.flatnonzero((np.minimum(a, b) <= value) & (value <= np.maximum(a, b))).tolist()

    def between(self, i: int, value: float) -> Orbit | None:
        """Return the orbit at a value between those of one orbit and the next, solved there; None if lost."""
        low, high = self.values[i], self.values[i + 1]
        share = (value - low) / (high - low) if high != low else 0.0
        guess = self.unknowns[i] + share * (self.unknowns[i + 1] - self.unknowns[i])
        x = closed(self.equations, guess, np.array([value]))
        return None if x is None else self.equations.orbit(x, np.array([value]))


@dataclass
class Work:
    """How many points are still to be spent on following, of how many, and who is told."""

    left: int
    told: Callable[[int], None] | None = None

    def spend(self, points: int) -> None:
        """Count points."""
        self.left = max(self.left - points, 0)
        if self.told is not None:
            self.told(points)

    def part(self, most: int) -> Work:
        """Return the work on one thing: at most so much of what is left, and counted here as well."""
        return Work(min(self.left, max(most, 2)), self.spend)


def relabels(equations: Equations, event: Event) -> tuple[Equations, Point] | None:
    """Return how an orbit goes on that meets a border where its map by pieces is smooth: with another letter."""
    if event.type != "bcb" or not event.converged:
        return None
    found = equations.across(*unscaled(equations, event.point.z), event.where)
    if found is None or not found.smooth:
        return None
    new, old = found.equations, event.point
    point = point_at(new, np.concatenate([found.x / new.scale, old.z[len(equations.scale) :]]), old.tangent)
    if point is None:
        return None
    tests = tuple(  # on the side that the path goes to
        test._replace(value=BARELY)
        if (test.type, test.where) == ("bcb", event.where) and abs(test.value) < ZERO
        else test
        for test in point.tests
    )
    return new, point._replace(tests=tests)


def one_graze(one: Special, other: Special, span: float) -> bool:
    """Whether two special points of a piece are one graze, at which an impact has no speed and a flight touches.

    So it is where an orbit meets one of half its period or less that grazes.
    """
    if (one.type, one.piece) != ("gr", other.piece) or other.type != "gr" or one.direction @ other.direction < 0.0:
        return False
    points, others = one.orbit.points, other.orbit.points
    size = np.abs(points).max(axis=0) + np.ptp(points, axis=0)
    return bool(abs(one.value - other.value) <= ALIKE * span and (np.abs(points - others) <= ALIKE * size).all())


def bracketed(equations: Equations, event: Event, x: Floats, p: Floats) -> tuple[float, float, bool]:
    """Return the bracket of an event, and whether it has converged: then the bracket holds what rounding can do."""
    value = float(p[-1])
    low, high = min(event.low, value), max(event.high, value)
    crossed = event.type == "bp"
    kind = "lp" if crossed else event.type, -1 if crossed else event.where
    index = next((i for i, test in enumerate(equations.tests(x, p)) if test[::2] == kind), -1)
    if not event.converged or index < 0:
        return low, high, event.converged
    even = equations.even(x, p) if crossed else None
    if even is not None:
        shift = moved_by_rounding(even, even.part(x, p), p, index)
    else:
        shift = moved_by_rounding(equations, x, p, index, event.point.tangent if crossed else None)
    if not np.isfinite(shift):
        return low, high, False
    return value - shift, value + shift, True


def turning(multipliers: NDArray[np.complex128]) -> bool:
    """Whether the two multipliers whose product is 1 are a complex pair; at two real ones there is no bifurcation."""
    pair = min(combinations(multipliers.tolist(), 2), key=lambda both: abs(both[0] * both[1] - 1.0))
    return bool(abs(pair[0].imag) > 0.0)


class Crossing(NamedTuple):
    """Where a smooth map changes the letters of an orbit: those before and beyond, the value, and where it goes on."""

    letters: tuple[int, ...]
    beyond: tuple[int, ...]
    value: float
    x: Floats
    point: Point


class Pieces:
    """Pieces that are known, and seeds of pieces that wait to be followed."""

    def __init__(
        self, name: str, bounds: tuple[float, float], step: float, limit: int, seeds: list[Seed], work: Work
    ) -> None:
        self.name, self.bounds, self.step, self.limit = name, bounds, step, limit
        self.work = work
        self.waiting = list(seeds)
        self.pieces: list[Piece] = []
        self.special: list[Special] = []
        self.relabellings: list[Relabelling] = []
        self.crossings: list[Crossing] = []

    def advance(self) -> None:
        """Follow the next seed as far as it goes; grazes on the way become seeds of their own."""
        seed = self.waiting.pop(0)
        number = len(self.pieces)
        if seed.origin >= 0:
            if self._known(seed):
                return
        path = self._path(seed)
        equations = seed.equations
        middle = path.points[len(path.points) // 2]
        lost = path.ended == "lost" and len(path.points) < 2
        if seed.origin >= 0 and (lost or turns(equations, *unscaled(equations, middle.z)) > 1):
            return  # all impacts lose their speed at once: what begins is a shorter orbit, gone round several times
        if seed.origin >= 0:
            self.special[seed.origin] = self.special[seed.origin]._replace(to=number)
        self._halved(path)
        solutions = [self._solution(path, point) for point in path.points]
        orbits = Solved(solutions, equations)
        unknowns, values = np.array([x for x, _p in solutions]), np.array([p[-1] for _x, p in solutions])
        kinds = {index: kind for index, event in path.events if (kind := self._note(equations, path, event, number))}
        if seed.type in SPECIAL:
            kinds.setdefault(0, seed.type)
            if path.ended == "closed":
                kinds.setdefault(len(orbits) - 1, seed.type)
        events = tuple(sorted(kinds))
        types = tuple(kinds[index] for index in events)
        self.pieces.append(Piece(equations, unknowns, values, orbits, events, types, (path.began, path.ended)))
        self._relabelled(path, number)
        for equations, point, leaves in path.beyond:
            self._beyond(path, equations, point, leaves, number)

    def _halved(self, path: Path) -> None:
        """Put points at which an orbit is one of half its period, or its own mirror image, where that one branches."""
        equations = path.equations
        for number, (i, event) in enumerate(path.events):
            x, p = path.unscaled(event.point.z)
            if event.where != HALVES and not (event.type == "bp" and nearly_even(equations, x, p)):
                continue
            ends: tuple[float, float] | None = event.low, event.high
            if event.where == HALVES:
                half, x, p, good = once(equations, x, p, event.high - event.low)
                _twice, x = half.doubling(x, p)
                ends = ends if good else None
            else:
                x, p, ends = evened(equations, x, p, event.high - event.low)
                path.events[number] = i, event._replace(converged=ends is not None)
            if ends is not None:
                point = event.point._replace(z=np.concatenate([x / equations.scale, p / equations.spans]))
                path.points[i] = point
                path.events[number] = i, event._replace(point=point, low=ends[0], high=ends[1], converged=True)

    def _solution(self, path: Path, point: Point) -> tuple[Floats, Floats]:
        """Return x and p of a point; an end of the range that rounding has missed is that end."""
        x, p = path.unscaled(point.z)
        for bound in self.bounds:
            if abs(p[-1] - bound) <= 1e-15 * (abs(bound) + self.bounds[1] - self.bounds[0]):
                p = np.array([bound])
        return x, p

    def _followed(self, seed: Seed, first: Point) -> Path:
        """Return the path from a point of a seed on."""
        limit = min(self.limit, max(self.work.left, 2))

        def stop(event: Event) -> bool:
            return relabels(seed.equations, event) is not None

        path = follow(seed.equations, first, self.bounds, step=self.step, limit=limit, stop=stop)
        if path.ended == "stopped":  # only the word changes: the orbit goes on with another letter
            _i, event = path.events.pop()
            there = relabels(seed.equations, event)
            assert there is not None
            path.ended = "relabelled"
            path.beyond.append((there[0], there[1], event.point))
        self.work.spend(len(path.points))
        return path

    def _path(self, seed: Seed) -> Path:
        """Return the path through a seed, on both sides of it if wanted."""
        forward = self._followed(seed, seed.point)
        if not seed.both or forward.ended == "closed":
            forward.began = "closed" if forward.ended == "closed" else seed.type
            if seed.leaves is not None:
                forward.points.insert(0, seed.leaves)
                forward.events = [(i + 1, event) for i, event in forward.events]
            return forward
        back = seed.point._replace(tangent=-seed.point.tangent)
        backward = self._followed(seed, back)
        return joined(backward, forward)

    def _note(self, equations: Equations, path: Path, event: Event, number: int) -> str:
        """Keep an event as a special point, and what begins there as a seed; its type, nothing if it is none."""
        x, p = path.unscaled(event.point.z)
        if event.where == HALVES:
            half, x, p, good = once(equations, x, p, event.high - event.low)
            good = good and event.converged
            orbit = half.orbit(x, p)
            value = float(p[-1])
            low, high, good = bracketed(half, event._replace(type="pd", where=-1, converged=good), x, p)
            one = Special("pd", value, low, high, good, orbit, allowed(half, x, p), -1, number)
            self.special.append(one)
            return one.type
        type, orbit = event.type, equations.orbit(x, p)
        if type == "ns" and not turning(orbit.multipliers):
            return ""
        seeds = partners(equations, event, x, p) if type in ("gr", "v0", "bcb") else []
        type, wall = equations.called(type, event.where, p)
        edge = on_the_edge(equations, event)
        value, where = float(p[-1]), max(event.where, -1)
        found = value, *bracketed(equations, event, x, p)
        one = Special(type, *found, orbit, edge, where, number, direction=event.point.tangent, wall=wall)
        span = self.bounds[1] - self.bounds[0]
        place = next((i for i, other in enumerate(self.special) if one_graze(one, other, span)), len(self.special))
        if place == len(self.special):
            self.special.append(one)
        elif one.converged and not self.special[place].converged:
            self.special[place] = one
        self.waiting += [seed._replace(origin=place) for seed in seeds]
        return type

    def _known(self, seed: Seed) -> bool:
        """Whether a piece that is known already passes through a seed: then a graze lies there with its impacts."""
        x, p = unscaled(seed.equations, seed.point.z)
        for number, begun_there in enumerate(self.pieces):  # from another point that collides there too
            there, near = begun_there.equations, abs(begun_there.values[0] - p[-1]) < 1e-6 * seed.equations.spans[-1]
            known = begun_there.ends[0] in SPECIAL and near and seed.equations.alike(there)
            if known and seed.equations.same(x, there, begun_there.unknowns[0], p):
                self.special[seed.origin] = self.special[seed.origin]._replace(to=number)
                return True
        for i, one in enumerate(self.special):
            piece = self.pieces[one.piece].equations
            if i == seed.origin or not seed.equations.alike(piece):
                continue
            there, _x = equations_of(one.orbit, (self.name,), seed.equations.spans)
            near = abs(one.value - p[-1]) < 1e-6 * seed.equations.spans[-1]
            if near and seed.equations.same(x, there, _x, p):
                self.special[seed.origin] = self.special[seed.origin]._replace(to=one.piece)
                return True
        return False

    def _beyond(self, path: Path, equations: Equations, point: Point, leaves: Point, number: int) -> None:
        """Note that only the word changes where a piece of a map ends, and go on, unless that is known from beyond."""
        old = path.equations
        assert isinstance(equations, PointEquations) and isinstance(old, PointEquations)
        x, p = unscaled(equations, point.z)
        near = 1e-9 * float(equations.spans[-1])
        for one in self.crossings:
            if {one.letters, one.beyond} == {old.letters, equations.letters} and abs(one.value - p[-1]) < near:
                if np.abs((one.x - x) / equations.scale).max() < 1e-6:
                    self.waiting = [seed for seed in self.waiting if seed.point is not one.point]
                    return
        self.crossings.append(Crossing(old.letters, equations.letters, float(p[-1]), x, point))
        before, after = (word(letters, equations.P.letters) for letters in (old.letters, equations.letters))
        self.relabellings.append(Relabelling(path.value(leaves), before, after, number))
        self.waiting.append(Seed(equations, point, leaves=leaves, type="relabelled"))

    def _relabelled(self, path: Path, number: int) -> None:
        """Note where the word changes although the equations stay: an impact crosses the strobe."""
        equations, piece = path.equations, self.pieces[number]
        times = equations.strobes(piece.unknowns, piece.values[:, None])
        if times is None:
            return
        periods = np.ceil(times - np.floor(times[:, :1]))
        for i in np.flatnonzero((periods[1:] != periods[:-1]).any(axis=1)).tolist():
            one, other = piece.orbits[i], piece.orbits[i + 1]
            if one.word != other.word:
                found = crossing(equations, path.points[i], path.points[i + 1])
                value = float(path.unscaled(found.z)[1][-1]) if found is not None else float(np.nan)
                self.relabellings.append(Relabelling(value, one.word, other.word, number))


def crossing(equations: Equations, a: Point, b: Point) -> Point | None:
    """Return where between two points an impact crosses the strobe."""

    def times(q: Point) -> Floats:
        x, p = unscaled(equations, q.z)
        found = equations.strobes(x[None], p[None])
        assert found is not None
        return np.asarray(found[0])

    before, after = (np.floor(times(q)) for q in (a, b))
    moved = np.flatnonzero(before != after)
    if len(moved) == 0:
        return None
    i, edge = int(moved[0]), float(max(before[moved[0]], after[moved[0]]))
    chord = b.z - a.z
    length = float(np.linalg.norm(chord))
    found = located(equations, a, chord / length, length, "strobe", i, lambda q: float(times(q)[i] - edge))
    return None if found is None else found[1].point
