"""The periodic orbit of a map by pieces, with its letters."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grazing.orbits.orbit import Orbit

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False, kw_only=True)
class PieceOrbit(Orbit):
    """A periodic orbit of a map by pieces, virtual where a point lies beyond the border of its letter.

    Parameters
    ----------
    letters : tuple of int
        The piece of each point.
    margins : ndarray, shape (period,)
        How far each point lies on the side of its letter, in the unit of the border; negative beyond it. Read-only.
    """

    letters: tuple[int, ...]
    margins: Floats

    def __post_init__(self) -> None:
        super().__post_init__()
        margins = np.array(self.margins)
        margins.flags.writeable = False
        object.__setattr__(self, "margins", margins)

    @property
    def clearance(self) -> float:
        """The least margin."""
        return float(self.margins.min())

    @property
    def depth(self) -> float:
        """How far beyond its border the farthest point of a virtual orbit lies; 0 for none."""
        return max(0.0, -self.clearance)

    def __repr__(self) -> str:
        said = super().__repr__()
        return said if self.admissible else f"{said[:-1]} ({self.depth:.3g} beyond the border)>"
