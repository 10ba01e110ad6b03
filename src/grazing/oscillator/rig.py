"""What every oscillator knows, over one wall or between several: its units, its mass, the base that moves it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import pi
from typing import TYPE_CHECKING, Any

from grazing.oscillator.forcing import Forcing, refuse_out_of_range
from grazing.oscillator.si import Base
from grazing.outcome import InputError
from grazing.parameter import Parameter, spread, updated
from grazing.units import magnitude

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


class Rig:
    """A forced linear oscillator with stops: what does not depend on how many there are.

    ``mass`` in kg is None for a dimensionless model, ``base`` for one that no moving base drives. ``stop`` says where
    the stop is on the rig: above or below, or "walls" where u is the rig's x, and each is at its own place.
    """

    __slots__ = ()

    alpha: float
    k: float
    stiffness: float | None
    forcing: Forcing
    mass: float | None
    base: Base | None
    stop: str | None

    @property
    def params(self) -> Mapping[str, float]:
        """All parameters, flat and in a fixed order."""
        raise NotImplementedError

    def describe(self, name: str) -> Parameter:
        """Return what is known of a parameter or a coordinate, with its units."""
        raise NotImplementedError

    @property
    def k2(self) -> float:
        """The stiffness: k^2, or as it was given."""
        return self.k * self.k if self.stiffness is None else self.stiffness

    @property
    def period(self) -> float:
        """Period T = 2 pi/omega of the forcing."""
        return 2.0 * pi / self.forcing.omega

    def units_of(self, names: Sequence[str]) -> str:
        """Return the units of several coordinates, one after the other; ``"1"`` if all is dimensionless."""
        return "1" if self.mass is None else ", ".join(self.describe(name).units for name in names)

    @property
    def attributes(self) -> dict[str, Any]:
        """What a result says of the rig: the mass in kg by which forces are divided, the side of the stop, the base."""
        base = None if self.base is None else self.base.text
        said = {"mass": self.mass, "stop": self.stop, "base": base}
        return {name: value for name, value in said.items() if value is not None}

    def made_from_base(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """Write the forces of a base into all parameters, shape (..., parameters), in place; return these."""
        if self.base is not None:
            self.base.row(values)
        return values

    def refuse_made(self, names: Sequence[str]) -> None:
        """Raise InputError for parameters that are made from a base, and cannot vary by themselves."""
        for name in names if self.base is not None else ():
            if name in self.base.made:  # type: ignore[union-attr]
                raise InputError(f"{name} is made by the moving base; make another model with from_si to change it")

    def refuse_base(self, what: str, names: Sequence[str]) -> None:
        """Raise InputError where something would change parameters that a base answers to, and keep its force."""
        if self.base is not None and not {*names}.isdisjoint(("alpha", "k", "omega", *self.base.made)):
            raise InputError(
                f"{what} in {', '.join(names)} does not know that the force of a base depends on it; vary something "
                "else, or follow orbits with gz.continuation"
            )

    def changed(self, changes: Mapping[str, Any]) -> dict[str, float]:
        """Return all parameters with other values for some, and with the forces that a base then makes."""
        params = self.params
        named = spread(changes, params, "the model")  # names before units, which others have not
        given = {name: self._number(name, value) for name, value in named.items()}
        new = updated(params, given, "the model")
        if self.base is not None:
            refuse_out_of_range(new["omega"])  # before forces are divided by its square
            made = self.base.forces(new["alpha"], new["k"], new["omega"])
            for name, value in zip(self.base.made, (x for pair in made for x in pair), strict=True):
                if name in given and new[name] not in (value, params[name]):
                    self.refuse_made([name])
                new[name] = value
        return new

    def _number(self, name: str, value: Any) -> Any:
        """Return what a parameter is changed to, in its units."""
        if type(value) is float:  # it has none
            return value
        try:
            return magnitude(value, self.describe(name).units, name)
        except InputError as error:
            if name == "k" and self.stop is not None:
                raise InputError(f"{error}. That is the natural frequency sqrt(k/m), and no stiffness, here") from None
            raise
