"""A one-dimensional manifold grown from a short straight piece next to its saddle, in pieces that are smooth.

The piece is so long that its image begins where it ends: all its images together are the manifold. A point is known by
the parameter t of its start on that piece, so that a new one between two others is computed from the saddle on, never
interpolated. Where neighbours have a different history the map is discontinuous or has a kink somewhere on their way:
the parameters of the two are bisected until they are neighbouring numbers, and the curve is cut there.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from grazing.orbits.manifold_steps import Leaves, Steps, traced

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]

#: Starts tried first on the short piece.
FIRST = 33
#: Two neighbouring chords turn by no more than this, and a chord times its turn is no more than BEND spacings, unless
#: the chord is shorter than SHORT spacings.
TURN, BEND, SHORT = 0.2, 0.02, 1e-3
#: Points put at once between two that are far apart, at most, and where a curve begins or ends.
MOST, SECTION = 16, 7
#: Neighbouring parameters are as near as this at a cut: the rounding of a number next to 1.
NEAREST = 2.5e-16
#: Distances outside the box count less; states farther away than FAR half widths are not told apart, and those
#: farther than LOST are given up.
OUTSIDE, FAR, LOST = 0.15, 20.0, 1e6
#: Rounds of refinement of one image of the short piece.
ROUNDS = 400


class Ruler:
    """Distances in the plane, in sides of a box: true inside it, shorter outside, none far from it."""

    def __init__(self, box: Floats) -> None:
        self.middle, self.half = box.mean(axis=1), 0.5 * (box[:, 1] - box[:, 0])

    def place(self, state: Floats) -> Floats:
        """Return where states (n, 2) are drawn on this ruler."""
        share = (state - self.middle) / self.half
        inside = np.clip(share, -1.0, 1.0)
        return np.asarray(0.5 * (inside + OUTSIDE * np.arcsinh(np.clip(share, -FAR, FAR) - inside)))

    def away(self, state: Floats) -> Floats:
        """Return how many half widths states are away from the middle, in the larger coordinate."""
        return np.asarray(np.abs((state - self.middle) / self.half).max(axis=1, initial=0.0))


class Line(NamedTuple):
    """Leaves along their curves: the place of each among the parameters, whether the next goes on, the chord to it."""

    leaves: Leaves
    spot: Ints
    goes_on: Bools  # (n - 1,)
    chord: Floats  # (n - 1,)
    where: Floats  # (n, 2), on the ruler

    @classmethod
    def of(cls, leaves: Leaves, t: Floats, ruler: Ruler, spacing: float) -> Line:
        """Put leaves in order: by code, then by parameter; a step that no bisection shortens goes on nowhere."""
        leaves = leaves.at(ruler.away(leaves.state) < LOST)
        spot = np.searchsorted(t, leaves.t)
        rows = np.lexsort((spot, leaves.code))
        leaves, spot = leaves.at(rows), spot[rows]
        goes_on = (leaves.code[1:] == leaves.code[:-1]) & (spot[1:] == spot[:-1] + 1)
        where = ruler.place(leaves.state)
        chord = np.hypot(*np.diff(where, axis=0).T) if len(where) else np.empty(0)
        gap = np.append(np.diff(t), np.inf)[spot[:-1]]
        return cls(leaves, spot, goes_on & ~((gap <= NEAREST) & (chord > spacing)), chord, where)

    def run(self, ruler: Ruler, gaps: int) -> Floats:
        """Return the length, inside the box, of all curves up to each parameter but the last."""
        inside = ruler.away(self.leaves.state) <= 1.0
        counts = self.goes_on & (inside[1:] | inside[:-1])
        return np.asarray(np.bincount(self.spot[:-1][counts], self.chord[counts], minlength=gaps)[:gaps], np.float64)

    def turns(self) -> Floats:
        """Return by how much the line turns at each leaf, 0 at ends."""
        turn = np.zeros(len(self.leaves))
        if len(turn) > 2:
            step = np.diff(self.where, axis=0)
            ahead = np.arctan2(step[:, 1], step[:, 0])
            by = np.abs((np.diff(ahead) + np.pi) % (2.0 * np.pi) - np.pi)
            middle = self.goes_on[1:] & self.goes_on[:-1] & (self.chord[1:] > 0.0) & (self.chord[:-1] > 0.0)
            turn[1:-1] = np.where(middle, by, 0.0)
        return turn


def wanted(line: Line, t: Floats, ruler: Ruler, spacing: float, room: float) -> Ints:
    """Return how many points are wanted between neighbouring parameters, shape (n - 1,)."""
    more = np.zeros(len(t) + 1, np.int64)  # more[i + 1]: between i and i + 1
    if len(line.leaves) == 0:
        return more[1:-1]
    first = line.spot[:-1][line.goes_on] + 1
    chord = line.chord[line.goes_on]
    np.maximum.at(more, first, np.minimum(np.ceil(chord / spacing) - 1.0, MOST).astype(np.int64))
    turn = line.turns()
    for side in (0, 1):  # the turn at either end of a chord
        bend = turn[side : len(turn) - 1 + side][line.goes_on]
        bent = ((bend > TURN) & (chord > SHORT * spacing)) | (chord * bend > BEND * spacing)
        np.maximum.at(more, first, np.where(bent, 1, 0))
    away = ruler.away(line.leaves.state)
    near = away < FAR
    begins, ends = np.append(True, ~line.goes_on), np.append(~line.goes_on, True)
    np.maximum.at(more, line.spot[ends & near] + 1, SECTION)
    np.maximum.at(more, line.spot[begins & near], SECTION)
    dip = np.zeros(len(away), bool)  # towards the box, between points far from it
    dip[1:-1] = line.goes_on[1:] & line.goes_on[:-1] & (away[1:-1] > 1.0)
    dip[1:-1] &= away[1:-1] < 0.75 * np.minimum(away[2:], away[:-2])
    np.maximum.at(more, line.spot[dip], 1)
    np.maximum.at(more, line.spot[dip] + 1, 1)
    run = line.run(ruler, len(t) - 1)
    more = more[1:-1]
    more[np.cumsum(run) - run > room] = 0
    more[np.diff(t) <= NEAREST] = 0
    return more


def put_between(t: Floats, more: Ints) -> Floats:
    """Return new parameters, so many between each two neighbours, evenly; none where numbers are too coarse."""
    gap = np.repeat(np.arange(len(more)), more)
    number = np.arange(len(gap)) - np.repeat(np.cumsum(more) - more, more) + 1
    fresh = t[gap] + (t[gap + 1] - t[gap]) * (number / (more[gap] + 1))
    return np.unique(fresh[(fresh > t[gap]) & (fresh < t[gap + 1])])


class Piece(NamedTuple):
    """A smooth piece of one image: parameters (n,) of its starts, states (n, 2), its letters; ``cut`` at either end."""

    t: Floats
    state: Floats
    letters: NDArray[np.int32]
    length: float
    cut: tuple[bool, bool]


class Image(NamedTuple):
    """One image of the short piece: smooth pieces inside the box, their length, and the parameters worth keeping."""

    pieces: list[Piece]
    length: float
    t: Floats
    leaves: Leaves  # those of these parameters
    full: bool  # whether it was ended by its length
    cut_short: bool  # or because it has too many points
    alive: bool  # whether any point is left, inside the box or not
    near: bool  # whether any is not far outside it
    extent: float  # length on the ruler, the parts outside the box included


def image_of(
    steps: Steps, distance: Floats, order: int, t: Floats, leaves: Leaves, ruler: Ruler, spacing: float, room: float,
    most: int,
) -> Image:  # fmt: skip
    """Return one image of the short piece, refined until it is smooth and its cuts are where they are.

    Parameters
    ----------
    steps : Steps
    distance : ndarray, shape (2,)
        Of the starts from the saddle, in directions, signed: distance[0] at t = 0, geometrically to distance[1] at
        t = 1; linearly if distance[0] is 0.
    order : int
        Steps from the short piece.
    t : ndarray, shape (n,)
        Parameters tried first, increasing from 0 to 1.
    leaves : Leaves
        What becomes of the starts of these parameters in so many steps.
    ruler : Ruler
    spacing, room : float
        Distance of neighbouring points; length after which the image is ended.
    most : int
        Points that may be computed.
    """
    line = Line.of(leaves, t, ruler, spacing)
    for _ in range(ROUNDS):
        fresh = put_between(t, wanted(line, t, ruler, spacing, room))
        if len(fresh) == 0 or len(t) + len(fresh) > most:
            break
        leaves = leaves.with_more(traced(steps, fresh, along(fresh, distance), order))
        t = np.sort(np.concatenate([t, fresh]))
        line = Line.of(leaves, t, ruler, spacing)
    cut_short = len(fresh) > 0
    run = line.run(ruler, len(t) - 1)
    before = np.append(0.0, np.cumsum(run))  # the length up to each parameter
    pieces, kept = _pieces(line, t, ruler, spacing, before <= room), _kept(line, t, spacing)
    near = ruler.away(line.leaves.state) < FAR
    return Image(
        pieces, sum(piece.length for piece in pieces), kept, leaves.at(np.isin(leaves.t, kept)),
        bool(before[-1] > room), cut_short, len(line.leaves) > 0, bool(near.any()),
        float(line.chord[line.goes_on].sum()),
    )  # fmt: skip


def along(t: Floats, distance: Floats) -> Floats:
    """Return the distance from the saddle of the start of parameter t."""
    if distance[0] == 0.0:
        return np.asarray(distance[1] * t)
    return np.asarray(distance[1] * (distance[0] / distance[1]) ** (1.0 - t))


def _pieces(line: Line, t: Floats, ruler: Ruler, spacing: float, within: Bools) -> list[Piece]:
    """Return the smooth pieces inside the box, each with a point beyond its edge, less points too near to be seen."""
    if len(line.leaves) == 0:
        return []
    inside = ruler.away(line.leaves.state) <= 1.0
    joined = line.goes_on & (line.chord <= 4.0 * spacing)
    keep = inside.copy()
    keep[:-1] |= inside[1:] & joined
    keep[1:] |= inside[:-1] & joined
    keep &= within[line.spot]
    goes_on = joined & keep[:-1] & keep[1:]
    found = []
    for rows in np.split(np.arange(len(keep)), np.flatnonzero(~goes_on) + 1):
        if not keep[rows[0]] or len(rows) < 2:
            continue
        spots = line.spot[rows]
        length = float(line.chord[rows[:-1]].sum())
        cell = np.floor(np.append(0.0, np.cumsum(line.chord[rows[:-1]])) / (0.01 * spacing))
        seen = np.append(True, np.diff(cell) > 0.0)
        seen[-1] = True
        cut = (
            bool(spots[0] > 0 and inside[rows[0]] and t[spots[0]] - t[spots[0] - 1] <= 4.0 * NEAREST),
            bool(spots[-1] < len(t) - 1 and inside[rows[-1]] and t[spots[-1] + 1] - t[spots[-1]] <= 4.0 * NEAREST),
        )
        kept = rows[seen]
        leaves = line.leaves.at(kept)
        found.append(Piece(leaves.t, leaves.state, leaves.letters[0], length, cut))
    return sorted(found, key=lambda piece: float(piece.t[0]))


def _kept(line: Line, t: Floats, spacing: float) -> Floats:
    """Return the parameters from which the next image is begun: those at ends, and others that are not close."""
    ends = np.zeros(len(t), bool)
    ends[[0, -1]] = True
    moved = np.zeros(len(t) - 1)
    if len(line.leaves):
        np.maximum.at(moved, line.spot[:-1][line.goes_on], line.chord[line.goes_on])
        for end in (np.append(True, ~line.goes_on), np.append(~line.goes_on, True)):
            ends[line.spot[end]] = True
        # the other side of every cut
        for shift in (-1, 1):
            ends |= np.roll(ends, shift) & (np.minimum(np.diff(t, append=2.0), np.diff(t, prepend=-1.0)) <= NEAREST)
    place = np.append(0.0, np.cumsum(moved))
    cell = np.floor(place / (0.5 * spacing))
    even = np.floor(t * (FIRST - 1))
    seen = np.append(True, (np.diff(cell) > 0.0) | (np.diff(even) > 0.0))
    return t[seen | ends]
