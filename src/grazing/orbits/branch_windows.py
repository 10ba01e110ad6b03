"""Windows on a branch: the stretches on which it is stable and admissible, and the special points that end them."""

from __future__ import annotations

from typing import NamedTuple

from grazing.orbits.branch import Branch
from grazing.orbits.branch_search import Piece
from grazing.orbits.orbit import Orbit


class Window(NamedTuple):
    """An interval of the parameter on which a branch is stable and admissible, and the special points that end it.

    ``inner`` is an orbit inside, and ``at`` has the numbers of the orbits at the low and the high end, on its piece.
    """

    low: float
    high: float
    low_type: str
    high_type: str
    word: str
    period: int
    inner: Orbit
    at: tuple[int, int]


def attracts(piece: Piece, i: int) -> bool:
    """Whether a piece is stable and admissible between one of its orbits and the next."""
    for j in (i, i + 1):
        if j not in piece.events:
            return piece.orbits[j].stable and piece.orbits[j].admissible
    orbit = piece.between(i, 0.5 * float(piece.values[i] + piece.values[i + 1]))
    return orbit is not None and orbit.stable and orbit.admissible


def windows_of_piece(piece: Piece) -> list[Window]:
    """Return the stretches of a piece that are stable and admissible, with the special points that end them.

    A piece that comes back to where it was begun has no end there.
    """
    good = [attracts(piece, i) for i in range(len(piece.orbits) - 1)]
    order, kinds = list(range(len(piece.orbits))), dict(zip(piece.events, piece.types, strict=True))
    if piece.ends[0] == "closed" and 0 not in kinds and not all(good):
        seam = good.index(False)
        good, order = good[seam:] + good[:seam], [*order[seam:-1], *order[: seam + 1]]
    found = []
    first: int | None = None
    for i, inside in enumerate([*good, False]):
        if inside and first is None:
            first = i
        if not inside and first is not None:
            ends = [(float(piece.values[j]), kinds.get(j, "end"), j) for j in (order[first], order[i])]
            (low, low_type, begin), (high, high_type, end) = sorted(ends)
            inner = piece.orbits[order[min(first + 1, i)]]
            found.append(Window(low, high, low_type, high_type, inner.word, inner.period, inner, (begin, end)))
            first = None
    return found


def windows_of(branch: Branch) -> list[Window]:
    """Return all windows of a branch by period and place, each once."""
    found: list[Window] = []
    for piece in branch.pieces:
        for one in windows_of_piece(piece):
            close = 1e-9 * (branch.bounds[1] - branch.bounds[0])
            if one.high - one.low < close:
                continue
            known = (w for w in found if (w.period, w.word) == (one.period, one.word))
            if not any(abs(w.low - one.low) < close and abs(w.high - one.high) < close for w in known):
                found.append(one)
    return sorted(found, key=lambda w: (w.period, w.low, w.word))
