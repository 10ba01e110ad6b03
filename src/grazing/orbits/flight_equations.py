"""Equations of orbits of the oscillator: what they all do with its parameters."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from grazing.orbits.equations import Equations
from grazing.oscillator.constants import HEAD, constants_of
from grazing.oscillator.model import Oscillator
from grazing.oscillator.pointed import flight_fields, flight_kind
from grazing.parameter import unknown

Floats = NDArray[np.float64]


class FlightEquations(Equations):
    """Equations whose flights are those of an oscillator.

    Parameters
    ----------
    model : Oscillator
        Gives the values of all parameters that do not vary.
    names : tuple of str
        Parameters that vary.
    spans : array_like, optional
        Size of each of them.
    """

    def __init__(self, model: Oscillator, names: tuple[str, ...], spans: Any = None) -> None:
        params = model.params
        for name in names:
            if name not in params:
                raise unknown(name, params, "the model")
        model.refuse_made(names)
        self.model, self.names = model, names
        self.spans = np.ones(len(names)) if spans is None else np.asarray(spans, np.float64)
        self._index = [list(params).index(name) for name in names]
        self._base = np.array(list(params.values()))

    @property
    def own(self) -> Floats:
        """The values that the model itself has for the parameters that vary."""
        return np.asarray(self._base[self._index])

    def values(self, p: Floats) -> Floats:
        """Return all parameters of the model, in their order."""
        values: Floats = self._base.copy()
        values[self._index] = p
        return self.model.made_from_base(values)

    def row(self, values: Floats) -> Floats:
        """Return the numbers that a flight needs, in the order of :func:`grazing.oscillator.pointed.flight_fields`."""
        row = np.zeros(len(flight_fields(self.model.harmonics)))
        head = (
            len(HEAD) + 2 * self.model.harmonics + 1
        )  # alpha to sigma; the section's phase and the law's fields are 0
        row[:head] = values[:head]
        row[head + 1] = 1.0 if self.model.stiffness is not None else 0.0
        return row

    def model_at(self, p: Floats) -> Oscillator:
        """Return the model with these values of the parameters that vary."""
        return self.model.replace(**dict(zip(self.names, map(float, p), strict=True)))

    def period_at(self, p: Floats) -> float:
        """Return the period of the forcing, which changes with its frequency."""
        return float(2.0 * np.pi / self.values(p)[HEAD.index("omega")])

    def constants(self, p: Floats) -> Any:
        """Return the constants of flights, in plain Python."""
        kind = flight_kind(self.model.harmonics)
        return constants_of(self.model.harmonics)(kind(*self.row(self.values(p)).tolist()))

    def sizes(self) -> tuple[float, float]:
        """Return the sizes of positions and velocities, > 0: of a ball that nothing moves those of its starts."""
        c, at = self.constants(self.own), self.model.reach
        return (c.size, c.size * c.rate) if c.size > 0.0 else (at.height, at.speed)
