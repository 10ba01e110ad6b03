"""The branches through the attractors of a scan, and where the scan saw something else."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from grazing.maps.map import Map
from grazing.orbits.branch import Branch, Unsettled, followed
from grazing.orbits.branch_search import SHARE, Piece, Work
from grazing.orbits.branch_windows import windows_of_piece
from grazing.orbits.contacts import model_of
from grazing.orbits.free_equations import free_orbit
from grazing.orbits.orbit import Orbit, multipliers_of
from grazing.orbits.special import Special
from grazing.outcome import GrazingError
from grazing.studies.plan import Progress

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]

#: Orbits whose points differ by less than this part of the map's box are one.
SAME = 1e-6
#: Branches that are begun at most; step and points of one piece.
MOST, STEP, LIMIT = 200, 0.03, 2000
#: The word of the orbit of an oscillator without impacts.
FREE = "0"
#: Why an attractor was not followed that moves along a line of others.
NEUTRAL = (
    "it is neutral, one of a continuum of orbits: a multiplier is 1, and no branch leads through one of them alone"
)


class Attractor(NamedTuple):
    """A periodic orbit that a scan reached at a value of the parameter."""

    value: float
    period: int
    word: str
    points: Floats


class Disagreement(NamedTuple):
    """Neighbouring values at which scan and branches differ.

    ``kind`` is *scan only* (an attractor was reached that lies on no branch), *branch only* (no start reached a stable
    orbit) or *not followed* (an attractor whose period is beyond the limit, or whose branch could not be begun).
    """

    kind: str
    low: float
    high: float
    values: int
    word: str
    period: int
    reason: str


@dataclass
class Search:
    """The branches that are known, and where the scan saw something else."""

    P: Map
    name: str
    bounds: tuple[float, float]
    longest: int
    seen: int
    steps: int
    points: int
    progress: Progress | None = None
    work: Work = field(init=False)
    cut: int = 0
    waiting: list[tuple[int, Branch, Special]] = field(default_factory=list)
    branches: list[Branch] = field(default_factory=list)
    alone: list[tuple[float, str, int, str]] = field(default_factory=list)
    reached: set[tuple[float, int, int]] = field(default_factory=set)
    unsettled: list[Attractor] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.work = Work(self.points, self._told)

    def scanned(self, scan: xr.Dataset) -> None:
        """Go through all attractors of a scan, short ones first; follow those that lie on no branch."""
        order = np.argsort(scan[self.name].values, kind="stable")
        met = []
        for i in order.tolist():
            value = float(scan[self.name].values[i])
            periods, words = scan["period"].values[i], scan["word"].values[i]
            points = np.stack([scan[c].values[i] for c in self.P.coordinates], axis=-1)
            kept = representatives(periods, words, points, self.size).tolist()
            met += [Attractor(value, int(periods[j]), str(words[j]), points[j]) for j in kept]
        self._free(np.unique(scan[self.name].values).tolist(), met)
        for one in sorted(met, key=lambda one: one.period):
            self._begin(one.period)
            self._attractor(one.value, one.period, one.word, one.points)
        self._begin(self.longest)
        for one in self.unsettled:  # a branch that was begun at another value may pass through it
            if not self._lies(one.value, one.period, one.points[-one.period :]):
                why = (
                    f"its points after {self.steps} steps are not yet those of a periodic orbit, as near a bifurcation"
                )
                self.alone.append((one.value, one.word, one.period, f"{why}; a longer transient brings them nearer"))

    def _free(self, grid: list[float], met: list[Attractor]) -> None:
        """Follow the stable orbits without impacts that no start has reached, each of which is known in closed form."""
        if model_of(self.P) is None:
            return
        reached = {one.value for one in met if one.period == 1 and one.word == FREE}
        for value in grid:
            if value in reached:
                continue
            P = self.P.replace(**{self.name: value})
            orbit = free_orbit(model_of(P))
            if orbit is not None and orbit.admissible and orbit.stable and not self._passes(value, orbit):
                try:
                    self._add(self._followed(P, orbit))
                except GrazingError:
                    continue

    def _passes(self, value: float, orbit: Orbit) -> bool:
        """Whether a known branch passes through a stable orbit."""
        every = (one for branch in self.branches for piece in branch.pieces for one in stable_at(piece, value))
        return any(one.word == orbit.word and same_points(one.points, orbit.points, SAME * self.size) for one in every)

    def _begin(self, longest: int) -> None:
        """Follow the branches that begin at special points, of periods up to this one."""
        while True:
            ready = [item for item in self.waiting if item[0] <= longest]
            if not ready:
                return
            item = min(ready, key=lambda item: item[0])
            self.waiting.remove(item)
            _period, branch, one = item
            if len(self.branches) < MOST and not self._begun(branch, one):
                try:
                    self.branches.append(self._followed(branch.map, one))
                except GrazingError:
                    continue

    def _followed(self, P: Map, orbit: Orbit | Special) -> Branch:
        """Return the branch through an orbit, with at most its share of the points that are left."""
        if self.work.left < 2:
            self.cut += 1
            raise GrazingError(f"the limit of {self.points} points was reached")
        work = self.work.part(int(SHARE * self.points))
        branch = followed(P, orbit, self.name, self.bounds, STEP, LIMIT, work)
        self.cut += branch.cut
        return branch

    def _told(self, _points: int) -> None:
        """Say how many points of branches were found, of the limit."""
        if self.progress is not None:
            self.progress(self.points - self.work.left, self.points)

    @property
    def unfinished(self) -> str:
        """Say what the limit of points has cut off; nothing if it was not reached."""
        if self.cut == 0:
            return ""
        many = "1 branch was" if self.cut == 1 else f"{self.cut} branches were"
        limit = f"{self.points} points in all, of which one branch takes at most {int(SHARE * self.points)}"
        advice = "a larger limit (points) or a narrower range follows more"
        return f"{many} not followed to the end, as the limit of {limit} and a piece {LIMIT}, was reached; {advice}"

    @property
    def size(self) -> Floats:
        """Extent of the map's box along each coordinate."""
        return np.array([high - low for low, high in self.P.box])

    def _attractor(self, value: float, N: int, word: str, points: Floats) -> None:
        """Find the branch of one scanned attractor, or follow it."""
        if N > self.longest:
            self.alone.append((value, word, N, f"its period is beyond {self.longest}"))
            return
        if self._lies(value, N, points[-N:]):
            return
        if len(self.branches) >= MOST:
            self.alone.append((value, word, N, f"{MOST} branches are followed already"))
            return
        P = self.P.replace(**{self.name: value})
        orbit = Orbit(
            map=P, points=points[-N:], word=word, period=N, multipliers=multipliers_of(P, points[-N:]),
            admissible=True, condition=1.0, residual=0.0,
        )  # fmt: skip
        if orbit.degenerate:
            self.alone.append((value, word, N, NEUTRAL))
            return
        try:
            self._add(self._followed(P, orbit))
        except Unsettled:
            self.unsettled.append(Attractor(value, N, word, points))
            return
        except GrazingError as error:
            self.alone.append((value, word, N, str(error)))
            return
        if not self._lies(value, N, points[-N:]):
            self.alone.append((value, word, N, "its branch does not pass through its points"))

    def _add(self, branch: Branch) -> None:
        """Keep a branch, and note the branches that begin at its period doublings and branch points."""
        self.branches.append(branch)
        for one in branch.special:
            begins = one.orbit.period * (2 if one.type == "pd" else 1)
            if one.type in ("pd", "bp") and one.converged and one.admissible and begins <= self.longest:
                self.waiting.append((begins, branch, one))

    def _begun(self, its: Branch, special: Special) -> bool:
        """Whether another branch than its own, which is known, begins at this special point or passes it."""
        near = 1e-6 * (self.bounds[1] - self.bounds[0])
        for branch in self.branches:
            if branch is not its and special.type == "bp":
                crossing = (one for one in branch.special if one.type == "bp" and abs(one.value - special.value) < near)
                if any(one.orbit.period == special.orbit.period for one in crossing):
                    return True
            for piece in branch.pieces:
                twice = piece.orbits[0].period == (2 if special.type == "pd" else 1) * special.orbit.period
                apart = min(abs(piece.values[0] - special.value), abs(piece.values[-1] - special.value))
                if twice and apart < near:
                    return True
        return False

    def _lies(self, value: float, N: int, points: Floats) -> bool:
        """Whether a scanned orbit lies on a stable admissible stretch of a known branch; notes which if so."""
        for b, branch in enumerate(self.branches):
            for k, piece in enumerate(branch.pieces):
                for orbit in stable_at(piece, value):
                    # what is left of the distance at the start, next to a bifurcation not yet nothing
                    near = SAME + float(np.abs(orbit.multipliers).max()) ** (self.steps / N)
                    if orbit.period == N and same_points(orbit.points, points, near * self.size):
                        self.reached.add((value, b, k))
                        return True
        return False

    def missed(self) -> list[Disagreement]:
        """Return the attractors of the scan that lie on no branch, those at neighbouring values together."""
        kinds = {"its branch does not pass through its points": "scan only"}
        groups: dict[tuple[str, str, int, str], list[float]] = {}
        for value, word, N, reason in self.alone:
            groups.setdefault((kinds.get(reason, "not followed"), word, N, reason), []).append(value)
        return [
            Disagreement(kind, min(values), max(values), len(set(values)), word, N, reason)
            for (kind, word, N, reason), values in groups.items()
        ]

    def unreached(self, scan: xr.Dataset) -> list[Disagreement]:
        """Return the stable admissible stretches of branches at whose values no start got there."""
        found = []
        grid = np.sort(scan[self.name].values)
        for b, branch in enumerate(self.branches):
            for k, piece in enumerate(branch.pieces):
                for window in windows_of_piece(piece):
                    inside = grid[(grid > window.low) & (grid < window.high)]
                    lost = [value for value in inside.tolist() if (value, b, k) not in self.reached]
                    lost = [v for v in lost if not self._elsewhere(v, piece)]
                    if lost and window.period <= self.seen:
                        reason = f"none of the starts reached it at {len(lost)} of {len(inside)} values"
                        word, N = window.word, window.period
                        found.append(Disagreement("branch only", min(lost), max(lost), len(lost), word, N, reason))
        return list(dict.fromkeys(found))  # one orbit may be on several branches

    def _elsewhere(self, value: float, piece: Piece) -> bool:
        """Whether the orbits of a piece at a value are on another branch as well, which the scan reached."""
        for orbit in stable_at(piece, value):
            for b, branch in enumerate(self.branches):
                for k, other in enumerate(branch.pieces):
                    if other is piece or (value, b, k) not in self.reached:
                        continue
                    for one in stable_at(other, value):
                        if one.period == orbit.period and same_points(one.points, orbit.points, SAME * self.size):
                            return True
        return False


def representatives(periods: Any, words: Any, points: Floats, size: Floats) -> NDArray[np.int64]:
    """Return the first start on each periodic attractor at one value: by period, word and place."""
    found: list[int] = []
    for i in np.flatnonzero(periods >= 1).tolist():
        if not any(same_attractor(periods, words, points, i, j, size) for j in found):
            found.append(i)
    return np.array(found, np.int64)


def same_attractor(periods: Any, words: Any, points: Floats, i: int, j: int, size: Floats) -> bool:
    """Whether two starts at one value ended on the same periodic attractor: of one period, word and place."""
    N = int(periods[i])
    alike = N >= 1 and periods[j] == N and words[j] == words[i]
    return bool(alike and same_points(points[j, -N:], points[i, -N:], 1e-3 * size))


def same_points(a: Floats, b: Floats, tolerance: Floats) -> bool:
    """Whether two lists of points (N, dim) are the same cycle, begun at whatever point."""
    if len(a) != len(b):
        return False
    first = np.abs(b - a[0]) <= tolerance
    return any((np.abs(np.roll(b, -k, axis=0) - a) <= tolerance).all() for k in np.flatnonzero(first.all(axis=1)))


def stable_at(piece: Piece, value: float) -> list[Orbit]:
    """Return the stable admissible orbits of a piece at one value, solved there."""
    found = []
    for i in piece.passing(value):
        ends = piece.orbits[i], piece.orbits[i + 1]
        if any(end.stable or j in piece.events for j, end in zip((i, i + 1), ends, strict=True)):
            orbit = piece.between(i, value)
            if orbit is not None and orbit.stable and orbit.admissible:
                found.append(orbit)
    return found


def merged(P: Map, name: str, bounds: tuple[float, float], branches: Sequence[Branch]) -> Branch:
    """Return several branches as one, their pieces numbered on."""
    pieces: list[Piece] = []
    special: list[Special] = []
    relabellings: list[Any] = []
    for branch in branches:
        shift = len(pieces)
        pieces += branch.pieces
        special += [
            one._replace(piece=one.piece + shift, to=one.to + shift if one.to >= 0 else -1) for one in branch.special
        ]
        relabellings += [one._replace(piece=one.piece + shift) for one in branch.relabellings]
    left = sum(branch.unfollowed for branch in branches)
    return Branch(P, name, bounds, tuple(pieces), tuple(special), tuple(relabellings), left)
