"""Where itineraries of launches change along the sides of cells over a plane, and what happens there."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from grazing.maps.itineraries import Flown, Itineraries

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
#: The coordinate along a side.
ANGLE, SPEED = 0, 1
#: A change is known to this share of the box, or to some neighbouring doubles.
SHARE, ULPS = 2.0**-44, 4.0
#: Distances from a change, as shares of the box, at which its impact is looked at, and 16 times as far: the first one
#: is taken at which the itinerary is still the same, none nearer than so many brackets. The root of 16 is 4; of half
#: of that or twice that.
PROBES, FARTHER, CLEAR = (2.0**-28, 2.0**-33, 2.0**-38), 16.0, 2.0**8
LEAST, MOST = 2.0, 8.0
#: The share by which an impact differs on both sides of a change at which nothing happens.
SAME = 1e-6
#: What a change is: the ball grazes an object; it meets something else, or nothing; or nothing happens, as where
#: a face goes on in the circle around its end.
GRAZE, CORNER, SEAM = "graze", "corner", "seam"


@dataclass(frozen=True, eq=False)
class Change:
    """A change of the itinerary between two launches that differ in one coordinate by hardly anything."""

    axis: int
    at: float
    low: float
    high: float
    before: int
    after: int
    kind: str
    #: The objects that are hit before, and that which is grazed; of a corner what is met on both sides.
    word: tuple[int, ...]
    objects: tuple[int, ...]
    #: Whether it is hit on the side of higher values.
    hit_above: bool

    @property
    def label(self) -> tuple[str, tuple[int, ...], tuple[int, ...]]:
        """What changes along one curve have in common."""
        return self.kind, self.word, self.objects

    @property
    def place(self) -> tuple[float, float]:
        """Angle and speed in the middle of the bracket."""
        middle = self.low + 0.5 * (self.high - self.low)
        return (middle, self.at) if self.axis == ANGLE else (self.at, middle)


Box = tuple[tuple[float, float], tuple[float, float]]
#: A side of cells: its axis, its place on the lattice across, and its two ends along.
Side = tuple[int, int, int, int]
#: Two launches on a side: where they are, and their itineraries.
Gap = tuple[Side, float, float, int, int]
#: Parts of a side that is looked at more closely.
PROBED = 32


@dataclass(eq=False)
class Borders:
    """A lattice over a box of angles and speeds, looked at where it is asked for.

    ``lattice`` is how many steps there are along angle and speed.
    """

    itineraries: Itineraries
    box: Box
    lattice: tuple[int, int]
    points: dict[tuple[int, int], int] = field(default_factory=dict)
    sides: dict[Side, list[Change]] = field(default_factory=dict)
    halves: dict[Side, tuple[Side, Side]] = field(default_factory=dict)
    #: Sides on which changes were found since it was last cleared.
    news: set[Side] = field(default_factory=set)

    def along(self, axis: int, k: int) -> float:
        """Return a coordinate on the lattice."""
        low, high = self.box[axis]
        return high if k == self.lattice[axis] else low + (high - low) * (k / self.lattice[axis])

    def look(self, points: Iterable[tuple[int, int]]) -> None:
        """Find the itineraries of points of the lattice."""
        new = sorted({point for point in points if point not in self.points})
        angles, speeds = (np.array([self.along(axis, point[axis]) for point in new]) for axis in (ANGLE, SPEED))
        self.points |= zip(new, self.itineraries.of(angles, speeds).tolist(), strict=True)

    def ends(self, side: Side) -> tuple[tuple[int, int], tuple[int, int]]:
        """Return the two ends of a side, on the lattice."""
        axis, across, low, high = side
        return ((low, across), (high, across)) if axis == ANGLE else ((across, low), (across, high))

    def _span(self, side: Side) -> tuple[float, float]:
        axis, _across, low, high = side
        return self.along(axis, low), self.along(axis, high)

    def changes(self, side: Side) -> list[Change]:
        """Return all changes along a side, in order."""
        if side in self.halves:
            return [one for half in self.halves[side] for one in self.changes(half)]
        return self.sides[side]

    def all(self) -> list[Change]:
        """Return all changes, in an order that does not depend on how they were found."""
        return [one for side in sorted(self.sides) for one in self.sides[side]]

    def search(self, sides: Iterable[Side]) -> None:
        """Find changes along sides whose ends differ."""
        sides = [side for side in dict.fromkeys(sides) if side not in self.sides and side not in self.halves]
        self.look(end for side in sides for end in self.ends(side))
        self.sides |= {side: [] for side in sides}
        self._found([gap for side in sides for gap in self._gaps(side, {})])

    def split(self, sides: Iterable[Side]) -> None:
        """Halve sides, and find what changes on the way to their middles and was not seen from their ends."""
        sides = [side for side in dict.fromkeys(sides) if side not in self.halves]
        parts = {
            side: ((*side[:2], side[2], (side[2] + side[3]) // 2), (*side[:2], (side[2] + side[3]) // 2, side[3]))
            for side in sides
        }
        self.look(self.ends(lower)[1] for lower, _upper in parts.values())
        for side, (lower, upper) in parts.items():
            known, at = self.sides.pop(side), self.along(side[0], lower[3])
            below = [one for one in known if one.low + one.high <= 2.0 * at]
            self.sides[lower], self.sides[upper], self.halves[side] = below, known[len(below) :], (lower, upper)
        self._found([gap for halves in parts.values() for half in halves for gap in self._gaps(half, {})])

    def probe(self, sides: Iterable[Side]) -> None:
        """Look at more launches along sides, and find what changes between them."""
        sides = [side for side in dict.fromkeys(sides) if side not in self.halves]
        values = [np.linspace(*self._span(side), PROBED + 1)[1:-1] for side in sides]
        if not sides:
            return
        on = [side for side in sides for _ in range(PROBED - 1)]
        numbers = self.itineraries.of(*self._launched(on, np.concatenate(values))).reshape(len(sides), -1)
        looked = [dict(zip(*map(np.ndarray.tolist, pair), strict=True)) for pair in zip(values, numbers, strict=True)]
        self._found([gap for side, seen in zip(sides, looked, strict=True) for gap in self._gaps(side, seen)])

    def _gaps(self, side: Side, seen: dict[float, int]) -> list[Gap]:
        """Return the gaps of a side: neighbouring launches with other itineraries between which no change is known."""
        first, last = (self.points[end] for end in self.ends(side))
        low, high = self._span(side)
        changes = self.sides[side]
        free = {at: k for at, k in seen.items() if not any(one.low <= at <= one.high for one in changes)}
        before = sorted([(low, first), *((one.high, one.after) for one in changes), *free.items()])
        after = sorted([*((one.low, one.before) for one in changes), *free.items(), (high, last)])
        return [
            (side, *both)
            for both in ((a, b, k, m) for (a, k), (b, m) in zip(before, after, strict=True) if k != m and a < b)
        ]

    def _found(self, gaps: Sequence[Gap]) -> None:
        """Find all changes in gaps between launches with other itineraries, and put them on their sides."""
        sides, brackets = self._bisected(gaps)
        for side, change in zip(sides, self._told(sides, brackets), strict=True):
            self.sides[side].append(change)
        self.news.update(sides)
        for side in dict.fromkeys(sides):
            self.sides[side].sort(key=lambda one: one.low)

    def _launched(self, sides: Sequence[Side], values: Floats) -> tuple[Floats, Floats]:
        """Return angles and speeds of launches on sides."""
        along_angle = np.array([side[0] == ANGLE for side in sides], dtype=bool)
        across = np.array([self.along(1 - side[0], side[1]) for side in sides])
        return np.where(along_angle, values, across), np.where(along_angle, across, values)

    def _bisected(self, gaps: Sequence[Gap]) -> tuple[list[Side], list[tuple[float, float, int, int]]]:
        """Halve gaps until they are brackets; one in whose middle there is a third itinerary becomes two."""
        going, sides, found = list(gaps), [], []
        while going:
            wide = []
            for side, low, high, before, after in going:
                span = self.box[side[0]][1] - self.box[side[0]][0]
                middle = low + 0.5 * (high - low)
                narrow = max(SHARE * span, ULPS * np.spacing(max(abs(low), abs(high))))
                if high - low <= narrow or not low < middle < high:
                    sides.append(side)
                    found.append((low, high, before, after))
                else:
                    wide.append((side, low, high, before, after, middle))
            on = [one[0] for one in wide]
            numbers = self.itineraries.of(*self._launched(on, np.array([one[5] for one in wide]))).tolist()
            going = []
            for (side, low, high, before, after, middle), number in zip(wide, numbers, strict=True):
                if number != before:
                    going.append((side, low, middle, before, number))
                if number != after:
                    going.append((side, middle, high, number, after))
        return sides, found

    def _told(self, sides: Sequence[Side], brackets: Sequence[tuple[float, float, int, int]]) -> list[Change]:
        """Say of brackets what changes there."""
        slow = [self._slow(sides, brackets, above) for above in (False, True)]
        codes, owners = self.itineraries.codes, self.itineraries.owners
        found = []
        for i, (side, (low, high, before, after)) in enumerate(zip(sides, brackets, strict=True)):
            k = _first_difference(codes[before], codes[after])
            word = tuple(one for one in owners[before][:k].tolist() if one >= 0)
            met = [int(owners[one][k]) if k < len(owners[one]) else -1 for one in (before, after)]
            grazed = [speeds[i][0] for speeds in slow]
            same = met[0] == met[1] >= 0 and abs(slow[0][i][1] - slow[1][i][1]) <= SAME * abs(slow[0][i][1])
            kind = GRAZE if any(grazed) else SEAM if same else CORNER
            objects = (met[grazed.index(True)],) if kind == GRAZE else tuple(sorted(met))
            hit_above = not grazed[0] if kind == GRAZE else tuple(codes[after][k:]) > tuple(codes[before][k:])
            at = self.along(1 - side[0], side[1])
            found.append(Change(side[0], at, low, high, before, after, kind, word, objects, hit_above))
        return found

    def _slow(
        self, sides: Sequence[Side], brackets: Sequence[tuple[float, float, int, int]], above: bool
    ) -> list[tuple[bool, float]]:
        """Say of one side of each bracket whether the impact there ceases as a square root, and how fast it is."""
        found = [(False, np.nan)] * len(brackets)
        going = list(range(len(brackets)))
        for share in PROBES:
            for i, far, near in self._fall(sides, brackets, going, share, above):
                found[i] = LEAST * abs(near) <= abs(far) <= MOST * abs(near), near
            going = [i for i in going if np.isnan(found[i][1])]
        # Nearer to the change a small speed that is left there shows.
        slow = [i for i, one in enumerate(found) if one[0]]
        for i, far, near in self._fall(sides, brackets, slow, 0.0, above):
            found[i] = LEAST * abs(near) <= abs(far) <= MOST * abs(near), found[i][1]
        return found

    def _fall(
        self,
        sides: Sequence[Side],
        brackets: Sequence[tuple[float, float, int, int]],
        which: Sequence[int],
        share: float,
        above: bool,
    ) -> Iterator[tuple[int, float, float]]:
        """Return how fast the impacts are beside some brackets, farther away and near, where both are there."""
        if not which:
            return
        edges = np.array([brackets[i][1 if above else 0] for i in which])
        spans = np.array([np.subtract(*self.box[sides[i][0]][::-1]) for i in which])
        wide = np.array([brackets[i][1] - brackets[i][0] for i in which])
        away = np.maximum(share * spans, CLEAR * wide)
        codes, speeds = self.itineraries.codes, []
        for far in (FARTHER, 1.0):
            values = edges + (far if above else -far) * away
            flown = self.itineraries.fly(*self._launched([sides[i] for i in which], values))
            speeds.append([_speed(flown, n, *_wanted(brackets[i], codes, above)) for n, i in enumerate(which)])
        for i, far, near in zip(which, *speeds, strict=True):
            if not np.isnan(far + near):
                yield i, far, near


def _first_difference(one: Integers, other: Integers) -> int:
    """Return the first place at which two lists differ."""
    n = min(len(one), len(other))
    differ = np.flatnonzero(one[:n] != other[:n])
    return int(differ[0]) if len(differ) else n


def _wanted(bracket: tuple[float, float, int, int], codes: list[Integers], above: bool) -> tuple[Integers, int]:
    """Return the codes of one side of a bracket, and at which the two sides differ."""
    before, after = (codes[number] for number in bracket[2:])
    return (after if above else before), _first_difference(before, after)


def _speed(flown: Flown, n: int, codes: Integers, k: int) -> float:
    """Return how fast a launch hits where two sides differ; NaN if it does not, or comes there on another way."""
    same = k < len(codes) and flown.codes.shape[1] > k and (flown.codes[n, : k + 1] == codes[: k + 1]).all()
    return float(flown.before[n, k]) if same else np.nan
