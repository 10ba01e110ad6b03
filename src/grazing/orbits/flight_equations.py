"""Equations of orbits of the oscillator: what they all do with its parameters."""

from __future__ import annotations

from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from grazing.orbits.contacts import flight_rows, framed, kick_of, room_in
from grazing.orbits.equations import Equations
from grazing.oscillator.constants import HEAD
from grazing.oscillator.frames import Frames, frame_of
from grazing.oscillator.rig import Rig
from grazing.parameter import checked_name, named_by

Floats = NDArray[np.float64]

#: How many values of the parameters are kept with what was prepared for them: those of a few points, and beside one.
KEPT = 6


class Prepared(NamedTuple):
    """All parameters of a model at k values of those that vary, and what follows from them.

    ``seen`` are the parameters that each wall sees, ``rows`` (k, ...) the numbers of flights, ``room`` (k,) is the one
    between the walls, see :mod:`grazing.orbits.contacts`, and ``laws`` (k, impacts, 4) those of impacts.
    """

    values: Floats
    seen: list[Floats]
    rows: Floats
    room: Floats
    laws: Floats


class FlightEquations(Equations):
    """Equations whose flights are those of an oscillator.

    Parameters
    ----------
    model : Rig
        Gives the values of all parameters that do not vary.
    names : tuple of str
        Parameters that vary.
    spans : array_like, optional
        Size of each of them.
    """

    def __init__(self, model: Rig, names: tuple[str, ...], spans: Any = None) -> None:
        params = model.params
        for name in names:
            checked_name(name, params, "the model")
        model.refuse_made(names)
        self.model, self.names = model, names
        self.spans = np.ones(len(names)) if spans is None else np.asarray(spans, np.float64)
        self._places = [[list(params).index(one) for one in named_by(name, params)] for name in names]
        self._base = np.array(list(params.values()))
        self._kept: dict[tuple[int, bytes], Prepared] = {}
        self._held: tuple[bytes, Rig] | None = None

    @property
    def own(self) -> Floats:
        """The values that the model itself has for the parameters that vary."""
        return self._base[[first for first, *_others in self._places]]

    def prepared(self, p: Floats) -> Prepared:
        """Return what kernels need at several values (k, names) of the parameters that vary; some are kept."""
        place = len(p), p.tobytes()
        found = self._kept.get(place)
        if found is None:
            values = np.empty((len(p), len(self._base)))
            values[:] = self._base
            for places, column in zip(self._places, p.T, strict=True):
                for at in places:
                    values[:, at] = column
            values = self.model.made_from_base(values)
            seen = self.model.rows_seen(values)
            rows = flight_rows(self.model, values, seen)
            found = Prepared(values, seen, rows, room_in(self.model, rows), self.laws(seen))
            while len(self._kept) >= KEPT:
                del self._kept[next(iter(self._kept))]
            self._kept[place] = found
        return found

    def laws(self, seen: list[Floats]) -> Floats:
        """Return what kernels need to know of the law of each impact at k values (k, impacts, 4); of none here.

        ``seen`` are the parameters that each wall sees.
        """
        return np.empty((len(seen[0]), 0, 4))

    def values(self, p: Floats) -> Floats:
        """Return all parameters of the model, in their order."""
        values: Floats = self.prepared(p[None]).values[0]
        return values

    def model_at(self, p: Floats) -> Rig:
        """Return the model with these values of the parameters that vary."""
        key = p.tobytes()
        if self._held is None or self._held[0] != key:
            self._held = key, self.model.replace(**dict(zip(self.names, map(float, p), strict=True)))
        return self._held[1]

    def period_at(self, p: Floats) -> float:
        """Return the period of the forcing, which changes with its frequency."""
        return float(2.0 * np.pi / self.values(p)[HEAD.index("omega")])

    def frames(self, p: Floats) -> Frames:
        """Return what the walls see, as numbers of Python."""
        return framed(self.model, self.prepared(p[None]).rows[0])

    @cached_property
    def own_frames(self) -> Frames:
        """What the walls see at the values that the model itself has."""
        return self.frames(self.own)

    def constants(self, p: Floats) -> Any:
        """Return the constants of flights as the first wall sees them, as numbers of Python."""
        return self.frames(p).a

    def called(self, type: str, where: int, p: Floats) -> tuple[str, str]:
        """Return the type of a special point, and the letter of the wall that it is about; empty for none.

        An impact that loses its speed at a wall that does not kick the ball is a graze, as one dip that meets it.
        """
        wall = self.touched(type, where)[1]
        if wall < 0:
            return type, ""
        grazes = type == "v0" and kick_of(self.model_at(p), wall) == 0.0
        return "gr" if grazes else type, self.model.names[wall]

    def sizes(self, wall: int = 0) -> tuple[float, float]:
        """Return the sizes of positions and velocities that a wall sees, > 0: of a still ball those of its starts."""
        c = frame_of(bool(wall), self.own_frames)
        if c.size > 0.0:
            return c.size, c.size * c.rate
        at = self.model.seen[wall].reach
        return at.height, at.speed
