"""What an orbit settles on: its cycle, found by recurrence."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from grazing.maps.map import Map
from grazing.orbits.word import word


class Cycle(NamedTuple):
    """The end of an orbit: points (period, dim) from the least first coordinate on, letters, period (0: none found)."""

    points: NDArray[np.float64]
    letters: tuple[int, ...]
    period: int

    @property
    def word(self) -> str:
        """The letters as text: digits for counts."""
        return "".join(str(letter) for letter in self.letters)


def settled(P: Map, start: ArrayLike, transient: int = 4000, longest: int = 64, within: float = 1e-10) -> Cycle:
    """Return the cycle on which the orbit of a start settles.

    Parameters
    ----------
    P : Map
    start : array_like, shape (dim,)
    transient : int
        Steps thrown away.
    longest : int
        Longest period looked for.
    within : float
        How closely the orbit must come back, all along the second half of what is kept.

    Returns
    -------
    Cycle
    """
    segment = P.orbit(start, transient + 2 * longest)
    points, letters = segment.points[transient:-1], segment.letters[transient:]
    for period in range(1, longest + 1):
        if float(np.abs(points[period:] - points[:-period]).max()) <= within:
            first = int(np.argmin(points[:period, 0]))
            turn = slice(first, first + period)
            return Cycle(points[turn], tuple(int(i) for i in letters[turn]), period)
    return Cycle(points, tuple(int(i) for i in letters), 0)


def words(P: Map, starts: int, transient: int, longest: int = 16, seed: int = 0, within: float = 1e-9) -> set[str]:
    """Return the words of the cycles that random starts in the map's box settle on; ``""`` stands for no cycle.

    An oscillator's starts fly together: the block passes over what repeats, which is most of the transient.
    """
    rng = np.random.default_rng(seed)
    lanes = np.array([[rng.uniform(low, high, starts) for low, high in P.box]])
    row = P.packed()[1][None]
    run = P.run_columns(row, lanes, transient, 2 * longest, arithmetic="strict", algorithm="block", threads=1)
    points, letters = run.points[0], run.letters[0]
    found: set[str] = set()
    for lane in range(starts):
        x = points[:, :, lane]
        name = ""
        for period in range(1, longest + 1):
            if float(np.abs(x[period:] - x[:-period]).max()) <= within:
                name = word(letters[:period, lane].tolist())
                break
        found.add(name)
    return found
