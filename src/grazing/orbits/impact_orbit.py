"""The periodic orbit of an oscillator, with its impacts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grazing.orbits.orbit import Orbit
from grazing.oscillator.model import Oscillator


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class ImpactOrbit(Orbit):
    """A periodic orbit of the oscillator; ``map`` is its stroboscopic map at phase 0, ``period`` is in its steps.

    Parameters
    ----------
    times : ndarray, shape (n,)
        Times of the impacts, increasing, the first in [0, T) and all within ``period`` T of it. Empty for an orbit
        without impacts. Read-only, as are the next two.
    incoming, outgoing : ndarray, shape (n,)
        Velocity just before each impact, < 0 on an admissible orbit, and just after it, >= 0.
    clearance : float
        Lowest local minimum of u - sigma between impacts, at flights' ends excepted; negative for a virtual orbit that
        passes through the wall, infinite where no flight has a local minimum. Zero at a graze.
    """

    times: NDArray[np.float64]
    incoming: NDArray[np.float64]
    outgoing: NDArray[np.float64]
    clearance: float

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in ("times", "incoming", "outgoing"):
            array = np.array(getattr(self, name), np.float64)
            array.flags.writeable = False
            object.__setattr__(self, name, array)

    @property
    def model(self) -> Oscillator:
        """The oscillator."""
        assert self.map.model is not None
        return self.map.model

    @property
    def impacts(self) -> int:
        """Number of impacts in ``period`` periods of the forcing."""
        return len(self.times)
