"""The periodic orbit of an oscillator, with its impacts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grazing.orbits.contacts import model_of
from grazing.orbits.orbit import Orbit
from grazing.oscillator.rig import Rig
from grazing.oscillator.wall import NAMES

#: An orbit and its mirror image that differ by less, in parts of a period and of its speed, are one.
ALIKE = 1e-7
#: Speed of an arrival, in sizes per period, below which it is a touch: rounding moves it by the root of its unit only.
TOUCHING = 1e-8


def delay(speed: NDArray[np.float64], size: NDArray[np.float64] | float, T: float) -> NDArray[np.float64]:
    """Return by how much rounding may change when a ball arrives, at this speed, in motions of this size."""
    return 1e-9 * T + 1e-14 * size / np.maximum(np.abs(speed), TOUCHING * size / T)


def mirrors_in(turns: int) -> int:
    """Return of how many parts, each the mirror image of the one before, a symmetric orbit is made: a power of two.

    What moves the model has the period T/g, g its :attr:`turns`, and half of it is an odd part of a turn N T, N odd.
    """
    return 2 * (turns & -turns) or 2


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class ImpactOrbit(Orbit):
    """A periodic orbit of the oscillator; ``map`` is its stroboscopic map at phase 0, ``period`` is in its steps.

    Parameters
    ----------
    times : ndarray, shape (n,)
        Times of the impacts, increasing, the first in [0, T) and all within ``period`` T of it. Empty for an orbit
        without impacts. Read-only, as are the next two.
    incoming, outgoing : ndarray, shape (n,)
        Velocity just before each impact, < 0 on an admissible orbit, and just after it, >= 0: relative to the wall and
        away from it.
    clearance : float
        Lowest local minimum of the distance to a wall between impacts, at flights' ends excepted; negative for a
        virtual orbit that passes through a wall, infinite where no flight has a local minimum. Zero at a graze.
    walls : str
        The wall of each impact, by its letter; with one wall all are the same.
    """

    times: NDArray[np.float64]
    incoming: NDArray[np.float64]
    outgoing: NDArray[np.float64]
    clearance: float
    walls: str = ""

    def __post_init__(self) -> None:
        super().__post_init__()
        object.__setattr__(self, "walls", self.walls or NAMES[0] * len(self.times))
        for name in ("times", "incoming", "outgoing"):
            array = np.array(getattr(self, name), np.float64)
            array.flags.writeable = False
            object.__setattr__(self, name, array)

    @property
    def solves(self) -> str:
        """What makes the equations of its impacts."""
        return "grazing.orbits.signature:of_impacts"

    @property
    def model(self) -> Rig:
        """The oscillator."""
        model = model_of(self.map)
        assert model is not None
        return model

    @property
    def impacts(self) -> int:
        """Number of impacts in ``period`` periods of the forcing."""
        return len(self.times)

    @property
    def symmetric(self) -> bool:
        """Whether it is its own mirror image: half a period later it does the same at the other walls.

        Only between the walls of a model that is its own mirror image, ``model.symmetric``; that of what moves it is
        the period that counts.
        """
        n, N, model = len(self.times), self.period, self.model
        m = mirrors_in(model.turns)
        if n % m or N % 2 == 0 or not model.symmetric:
            return False
        if n == 0:
            return True
        h, turn = n // m, N * model.period
        if (self.walls[h:] + self.walls[:h]).translate(str.maketrans(model.names, model.names[::-1])) != self.walls:
            return False
        late = np.append(self.times, self.times[:h] + turn)[h:] - self.times - turn / m
        speed = float(np.abs(self.outgoing).max(initial=0.0))
        apart = np.abs(np.roll(self.outgoing, -h) - self.outgoing)
        return bool((np.abs(late) <= ALIKE * model.period).all() and (apart <= ALIKE * speed).all())

    def __repr__(self) -> str:
        said = super().__repr__()
        return said.replace(f"period {self.period}", f"period {self.period}, symmetric") if self.symmetric else said

    @property
    def depth(self) -> float:
        """How far a virtual orbit passes through a wall; 0 for one that does not."""
        return max(0.0, -self.clearance)
