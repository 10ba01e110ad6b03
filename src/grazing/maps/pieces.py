"""An orbit in pieces: long runs that can be stopped, and points that are used up as they come."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from grazing.maps.columns import CUT, Columns
from grazing.outcome import DIVERGED

if TYPE_CHECKING:
    from grazing.maps.map import Map

#: Steps of a piece, over all its orbits, each well under 0.2 s: of a map that is a formula, of one whose orbits fly as
#: blocks, and of one that follows flight after flight.
FORMULA, BLOCK, FLIGHT = 6_000_000, 200_000, 40_000
#: Sizes of the box beyond which an orbit that still grows has diverged, and the fewest points that show that it grows.
FAR_AWAY, LEAST = 1e4, 6
#: How much farther all of the last third of an orbit is than the first where the box says nothing of where orbits go;
#: and by how much growth may differ, in logarithms, from third to third and from the nearest points to the farthest.
FARTHER, EVEN = 1.1, 1.25

Floats = NDArray[np.float64]


def pieces(
    P: Map, rows: Floats, lanes: Floats, transient: int, keep: int, arithmetic: str = "fast"
) -> Iterator[Columns]:
    """Advance many orbits piece by piece.

    Parameters
    ----------
    P : Map
    rows, lanes, transient, keep, arithmetic
        As in :meth:`grazing.Map.run_columns`; lanes hold the last states of the latest piece.

    Yields
    ------
    Columns
        Of one piece, in order; ``points`` and ``letters`` have as many steps as were kept in it, possibly none.
    """
    stride = steps_of_piece(P, lanes.shape[0] * lanes.shape[2])
    for n in range(0, max(transient + keep, 1), stride):
        end = min(n + stride, transient + keep)
        passed = max(0, min(end, transient) - n)
        over = ~np.isfinite(lanes).all(axis=1)
        found = P.run_columns(rows, lanes, passed, end - n - passed, arithmetic=arithmetic, threads=1)
        if n > 0:
            found.outcomes[:, 0][over] = 0  # an earlier piece has said how these ended
        yield found


def steps_of_piece(P: Map, orbits: int) -> int:
    """Return how many steps a piece of so many orbits has."""
    cut = CUT if P.origin.block is not None else 1
    return cut * max(1, steps_of(P) // (cut * max(1, orbits)))


def steps_of(P: Map) -> int:
    """Return how many steps of a map, over all orbits, a piece of work should have."""
    return BLOCK if P.origin.block is not None else (FORMULA if P.prepare is None else FLIGHT)


def joined(parts: list[Columns]) -> Columns:
    """Return the pieces of the same orbits as one, their outcomes folded."""
    kept = [part for part in parts if part.points.shape[1]] or parts[:1]
    return Columns(
        np.concatenate([part.points for part in kept], axis=1) if len(kept) > 1 else kept[0].points,
        np.concatenate([part.letters for part in kept], axis=1) if len(kept) > 1 else kept[0].letters,
        np.bitwise_or.reduce([part.outcomes for part in parts]),
        np.minimum.reduce([part.near_miss for part in parts]),
        np.minimum.reduce([part.slowest for part in parts]),
        np.add.reduce([part.undecided for part in parts]),
    )


def let_go(P: Map, found: Columns) -> Columns:
    """Return orbits of which those that grow without bound have ended, with outcome diverged.

    These are farther away than so many sizes of the map's box, and get farther with every third of what is kept; those
    of an oscillator from impact to impact. The box of another map may be far from where its orbits go: there all of the
    last third is farther than all of the first, and growth does not slow down; or, on an orbit that is by turns near
    and far, its nearest and its farthest points grow alike. The numbers would take thousands of steps more to overflow.
    """
    keep = found.points.shape[1]
    if keep < LEAST:
        return found
    size = np.array([high - low for low, high in P.box])[:, None]
    with np.errstate(invalid="ignore", over="ignore", divide="ignore"):
        parts = np.array_split(found.points, 3, axis=1)
        late = (np.abs(parts[2]) / size).max(axis=2)
        last = late.max(axis=1)
        if not (last > FAR_AWAY).any():
            return found
        first, second = ((np.abs(part) / size).max(axis=(1, 2)) for part in parts[:2])
        gone = (first > FAR_AWAY) & (second > first) & (last > second)
        if P.origin.sized:  # a ball that nothing brings back is another matter
            gone &= (np.array_split(found.letters, 3, axis=1)[2] != 0).any(axis=1)
        else:
            steady = (late.min(axis=1) > FARTHER * first) & (last - second > second - first)
            gone &= steady | grows_evenly(np.abs(found.points) / size)
    if not gone.any():
        return found
    points, outcomes = found.points.copy(), found.outcomes.copy()
    points[np.broadcast_to(gone[:, None, None], points.shape)] = np.nan
    outcomes[:, -1][gone] |= DIVERGED
    return found._replace(points=points, outcomes=outcomes)


def grows_evenly(sizes: Floats) -> NDArray[np.bool_]:
    """Return whether the greatest coordinates of orbits, sizes (columns, keep, dim, starts), grow by equal factors.

    From third to third, of an even number of points each: so do the farthest points of an orbit that alternates, and
    the nearest.

    Examples
    --------
    >>> import numpy as np
    >>> from grazing.maps.pieces import grows_evenly
    >>> n = np.arange(12.0)
    >>> by_turns, tent = np.where(n % 2 == 0, 9.0, 1.0) * 1.1**n, np.tile([1.0, 2.0, 3.0, 4.0], 3)
    >>> grows_evenly(np.array([by_turns, tent])[:, :, None, None]).ravel().tolist()
    [True, False]
    """
    many = 2 * (sizes.shape[1] // 6)
    thirds = np.log(sizes[:, -3 * many :].max(axis=2)).reshape(len(sizes), 3, many, -1)
    growth = np.concatenate([np.diff(thirds.max(axis=2), axis=1), np.diff(thirds.min(axis=2), axis=1)], axis=1)
    least = growth.min(axis=1)
    return np.asarray((least > 0.5 * np.log(FARTHER)) & (growth.max(axis=1) < EVEN * least))
