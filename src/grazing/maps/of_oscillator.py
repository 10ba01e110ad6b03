"""What the maps of an oscillator know of it: of any, and of one over one wall."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from grazing.kernel.content import identity
from grazing.maps.derivative import Derived
from grazing.maps.origin import Origin
from grazing.maps.starting import Box, boxes_at
from grazing.oscillator.frames import frames_kind, frames_of, frames_rows
from grazing.oscillator.model import Oscillator
from grazing.oscillator.pointed import flight_kind, pointed_rows
from grazing.oscillator.reach import Reach
from grazing.oscillator.rig import Rig
from grazing.oscillator.walled import Walled
from grazing.outcome import InputError
from grazing.parameter import Parameter, parameter_tuple

Floats = NDArray[np.float64]


class OfRig(Origin):
    """The origin of a map of an oscillator, over one wall or between several: units, mass and base are the model's."""

    rig: Rig

    @property
    def finder(self) -> str:
        """What finds periodic orbits: where the map shows the oscillator exactly, by the equations of its impacts."""
        return super().finder if self.section is None else "grazing.orbits.search_section:Sections"

    @property
    def equations(self) -> str:
        """What makes the equations of an orbit: where the map shows the oscillator exactly, those of its impacts."""
        return super().equations if self.section is None else "grazing.orbits.signature:of_section"

    def describe(self, name: str) -> Parameter:
        """Return what is known of a parameter or coordinate."""
        return self.rig.describe(name)

    def complete(self, rows: Floats) -> Floats:
        """Write the forces of a base into all parameters."""
        return self.rig.made_from_base(rows)

    def refuse_made(self, names: Sequence[str]) -> None:
        """Raise InputError for parameters that a base makes."""
        self.rig.refuse_made(names)

    def units_of(self, names: Sequence[str]) -> str:
        """Return the units of coordinates."""
        return self.rig.units_of(names)

    @property
    def followers(self) -> tuple[str, ...]:
        """The parameters that a base makes."""
        return () if self.rig.base is None else self.rig.base.made

    @property
    def attributes(self) -> dict[str, Any]:
        """What a result says of the rig: its mass, its stop, its base."""
        return self.rig.attributes

    @property
    def config(self) -> dict[str, str]:
        """The base, which makes forces from other parameters, and reset laws of one's own, each by name and content."""
        own = ", ".join(f"{one.law.name} {identity(one.law.law)[:16]}" for one in self.rig.walls if one.law.own)
        return ({} if self.rig.base is None else {"base": self.rig.base.text}) | ({"law": own} if own else {})


class OfWalls(OfRig):
    """The origin of a map of an oscillator between walls, or at one that moves or is above the ball."""

    rig: Walled

    def __init__(self, walled: Walled) -> None:
        self.rig = walled
        self.exact = all(wall.law.exact_slope for wall in walled.walls)

    @staticmethod
    def box_of(model: Walled, row: list[float]) -> tuple[tuple[float, float], tuple[float, float]]:
        """Return where starts are drawn at a row of the map's parameters."""
        raise NotImplementedError

    def boxes(self, rows: Floats) -> Floats:
        """Return the boxes at parameter values."""
        return np.array([self.box_of(self.rig, row) for row in rows.tolist()]).reshape(-1, 2, 2)

    def _derived(self, tangent: Callable[..., Any], rows: Floats, arithmetic: str) -> Derived:
        """Return a derivative with the laws by address, compiled once for all; the phase is last in rows."""
        numbers, source = frames_rows(self.rig, np.ascontiguousarray(rows), arithmetic)
        H = self.rig.harmonics
        return Derived(tangent, frames_of(H), frames_kind(H), numbers, source)


class OfOscillator(OfRig):
    """The origin of a map of an oscillator over one wall: the model."""

    sized: ClassVar[bool] = True
    #: Whether the phase of a section is a parameter of the map, the last one.
    phased: ClassVar[bool] = True
    model: Oscillator

    def __init__(self, model: Oscillator) -> None:
        self.model = self.rig = model
        self.exact = model.reset.exact_slope

    @staticmethod
    def form(at: Reach, paper: bool) -> Box:
        """Return the box of random starts, from how far and how fast the ball goes."""
        raise NotImplementedError

    def compiled(self) -> tuple[Callable[..., Any], Callable[..., Any]]:
        """Return the tangent, which calls the law by its address and gives log|det J| too, and its ``prepare``."""
        raise NotImplementedError

    def derivative(self, rows: Floats, arithmetic: str = "strict") -> Derived:
        """Return the derivative of the step with the law by address: compiled once for all laws."""
        model, source = self.model, np.ascontiguousarray(rows)
        kind = parameter_tuple((*model.params, "phase") if self.phased else tuple(model.params))
        flat = pointed_rows(model.harmonics, model.reset, kind, source, arithmetic)
        tangent, prepare = self.compiled()
        return Derived(tangent, prepare, flight_kind(model.harmonics), flat, source)

    def boxes(self, rows: Floats) -> Floats:
        """Return the boxes at parameter values."""
        return boxes_at(self.model, self.form, rows)


def apart(params: Mapping[str, float]) -> tuple[dict[str, float], float]:
    """Return the parameters of a model, and the phase of the section."""
    return {name: value for name, value in params.items() if name != "phase"}, params["phase"]


def above_wall(state: Sequence[float], params: Mapping[str, float]) -> None:
    """Raise InputError for a ball inside the wall."""
    if state[0] < params["sigma"]:
        raise InputError(
            f"the ball starts inside the wall: u = {state[0]:g}, sigma = {params['sigma']:g}; start with u >= sigma"
        )
