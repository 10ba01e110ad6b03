"""Equations of orbits of the oscillator: what they all do with its parameters."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grazing.orbits.contacts import Model, flight_row, frames_at, oscillators_of
from grazing.orbits.equations import Equations
from grazing.oscillator.constants import HEAD
from grazing.oscillator.frames import Frames, frame_of
from grazing.oscillator.walled import Walled
from grazing.parameter import checked_name, named_by

Floats = NDArray[np.float64]


class FlightEquations(Equations):
    """Equations whose flights are those of an oscillator.

    Parameters
    ----------
    model : Oscillator or Walled
        Gives the values of all parameters that do not vary.
    names : tuple of str
        Parameters that vary.
    spans : array_like, optional
        Size of each of them.
    """

    def __init__(self, model: Model, names: tuple[str, ...], spans: Any = None) -> None:
        params = model.params
        for name in names:
            checked_name(name, params, "the model")
        model.refuse_made(names)
        self.model, self.names = model, names
        self.spans = np.ones(len(names)) if spans is None else np.asarray(spans, np.float64)
        self._places = [[list(params).index(one) for one in named_by(name, params)] for name in names]
        self._base = np.array(list(params.values()))

    @property
    def own(self) -> Floats:
        """The values that the model itself has for the parameters that vary."""
        return self._base[[first for first, *_others in self._places]]

    def values(self, p: Floats) -> Floats:
        """Return all parameters of the model, in their order."""
        values: Floats = self._base.copy()
        for places, value in zip(self._places, p, strict=True):
            values[places] = value
        return self.model.made_from_base(values)

    def row(self, values: Floats) -> Floats:
        """Return the numbers that a flight needs, see :func:`grazing.orbits.contacts.flight_row`."""
        return flight_row(self.model, values)

    def apart(self, values: Floats) -> bool:
        """Whether there is room between the walls."""
        return not isinstance(self.model, Walled) or bool(self.model.rooms(values[None])[0] > 0.0)

    def model_at(self, p: Floats) -> Model:
        """Return the model with these values of the parameters that vary."""
        return self.model.replace(**dict(zip(self.names, map(float, p), strict=True)))

    def period_at(self, p: Floats) -> float:
        """Return the period of the forcing, which changes with its frequency."""
        return float(2.0 * np.pi / self.values(p)[HEAD.index("omega")])

    def frames(self, p: Floats) -> Frames:
        """Return what the walls see, in plain Python."""
        return frames_at(self.model, self.values(p))

    @cached_property
    def own_frames(self) -> Frames:
        """What the walls see at the values that the model itself has."""
        return self.frames(self.own)

    def constants(self, p: Floats) -> Any:
        """Return the constants of flights as the first wall sees them, in plain Python."""
        return self.frames(p).a

    def sizes(self, wall: int = 0) -> tuple[float, float]:
        """Return the sizes of positions and velocities that a wall sees, > 0: of a still ball those of its starts."""
        c = frame_of(bool(wall), self.own_frames)
        if c.size > 0.0:
            return c.size, c.size * c.rate
        at = oscillators_of(self.model)[wall].reach
        return at.height, at.speed
