"""What every oscillator knows, over one wall or between several: its units, its mass, the base that moves it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import gcd, pi
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from grazing.oscillator.forcing import Forcing, refuse_out_of_range
from grazing.oscillator.si import Base
from grazing.oscillator.spring import spring_of
from grazing.oscillator.wall import Wall, harmonics_of
from grazing.outcome import InputError
from grazing.parameter import Parameter, parameter_tuple, spread, updated
from grazing.units import magnitude

if TYPE_CHECKING:
    from grazing.oscillator.model import Oscillator

Floats = NDArray[np.float64]
#: Numbers in front of the harmonics: alpha, k, omega, t0, offset.
HEAD = 5
#: Places in a period, times the number of harmonics, at which the room between two walls is measured.
PLACES = 64


class Place(NamedTuple):
    """Where the numbers of a wall stand in a row of parameters: its position, motion (a cosine first) and law."""

    sigma: int
    motion: slice
    law: slice


def places_of(walls: Sequence[Wall], forcing: Forcing) -> tuple[Place, ...]:
    """Return where the numbers of each wall stand in a row of :attr:`Walled.params`."""
    found, at = [], HEAD + 2 * len(forcing.cos)
    for one in walls:
        moving = 0 if one.motion is None else 2 * len(harmonics_of(one.motion, forcing)[0])
        law = at + 1 + moving
        found.append(Place(at, slice(at + 1, law), slice(law, law + len(one.law.params))))
        at = law + len(one.law.params)
    return tuple(found)


class Rig:
    """A forced linear oscillator with stops: what does not depend on how many there are.

    ``mass`` in kg is None for a dimensionless model, ``base`` for one that no moving base drives. ``stop`` says where
    the stop is on the rig: above or below, or "walls" where u is the rig's x, and each is at its own place. ``walls``
    are one or two, from below. ``walled`` says that they are given one by one: they have names in results, and frames
    of their own in kernels; else there is one, at rest below the ball.
    """

    __slots__ = ()

    alpha: float
    k: float
    stiffness: float | None
    forcing: Forcing
    mass: float | None
    base: Base | None
    stop: str | None
    walls: Sequence[Wall]
    #: Where the numbers of each wall stand in a row of :attr:`params`; the number of harmonics of force and motions.
    places: tuple[Place, ...]
    #: The oscillator above one wall at rest that each wall sees.
    seen: tuple[Oscillator, ...]
    harmonics: int
    offset_name: str
    walled: ClassVar[bool] = False
    #: What says of it what certificates do.
    certified_as: ClassVar[str] = "grazing.proof.same_model:of_rig"

    @property
    def params(self) -> Mapping[str, float]:
        """All parameters, flat and in a fixed order."""
        raise NotImplementedError

    def describe(self, name: str) -> Parameter:
        """Return what is known of a parameter or a coordinate, with its units."""
        raise NotImplementedError

    def unit_of(self, name: str) -> float:
        """Return the model's own unit of a parameter, > 0: what counts as a step where the parameter itself is 0."""
        raise NotImplementedError

    @property
    def names(self) -> str:
        """The names of the walls, from below."""
        return "".join(str(one.name) for one in self.walls)

    @property
    def moves(self) -> bool:
        """Whether a wall moves."""
        return any(one.motion is not None for one in self.walls)

    @property
    def turns(self) -> int:
        """How often what moves it repeats itself in a period, by the harmonics that it has; 0 if nothing moves."""
        return self.turns_at(list(self.params.values()))

    def turns_at(self, row: Sequence[float] | Floats) -> int:
        """Return :attr:`turns` at a row of :attr:`params`."""
        waves = [slice(HEAD, HEAD + 2 * len(self.forcing.cos)), *(place.motion for place in self.places)]
        return gcd(*(i // 2 + 1 for wave in waves for i, value in enumerate(row[wave]) if value != 0.0))

    @property
    def symmetric(self) -> bool:
        """Whether the model is its own mirror image half a period later, of the period of what moves it."""
        return self.symmetric_at(np.array(list(self.params.values())))

    def symmetric_at(self, row: Floats) -> bool:
        """Return :attr:`symmetric` at a row of :attr:`params`."""
        return False

    def rows_seen_from(self, j: int, rows: Floats) -> Floats:
        """Return the parameters of the oscillator that wall j sees, for rows of :attr:`params`; its law's are last.

        One wall at rest, below the ball, sees all as they are.
        """
        return rows

    def rows_seen(self, rows: Floats) -> list[Floats]:
        """Return what each wall sees of rows of :attr:`params`."""
        return [self.rows_seen_from(j, rows) for j in range(len(self.walls))]

    def kind_seen_from(self, j: int) -> type:
        """Return the named tuple of a row of :meth:`rows_seen_from`, and of a phase behind it."""
        waves = [f"{name}{i}" for i in range(1, self.harmonics + 1) for name in ("cos", "sin")]
        head = ("alpha", spring_of(self)[0], "omega", "t0", "offset", *waves, "sigma")
        return parameter_tuple((*head, *self.walls[j].law.params, "phase"))

    def waves(self, j: int, rows: Floats) -> Floats:
        """Return the motion of wall j as harmonics 1, 2, ..., cosine and sine: shape (rows, 2 harmonics)."""
        found = np.zeros((len(rows), 2 * self.harmonics))
        motion = rows[:, self.places[j].motion]
        found[:, : motion.shape[1]] = motion
        return found

    def rooms(self, rows: Floats) -> Floats:
        """Return the least distance between two walls in a period, or less: shape (rows,); infinity for one wall."""
        if len(self.walls) < 2:
            return np.full(len(rows), np.inf)
        low, high = self.places
        still = rows[:, high.sigma] - rows[:, low.sigma]
        between = self.waves(1, rows) - self.waves(0, rows) if self.moves else np.zeros(0)
        if not between.any():
            return np.asarray(still)
        size = np.hypot(between[:, ::2], between[:, 1::2])
        # between two places the distance differs from the nearer one's by half a step's second derivative at most
        j = np.arange(1, self.harmonics + 1)
        angles = np.arange(PLACES * self.harmonics) * (2.0 * pi / (PLACES * self.harmonics))
        seen = between[:, ::2] @ np.cos(np.outer(j, angles)) + between[:, 1::2] @ np.sin(np.outer(j, angles))
        bend = 0.125 * (angles[1] ** 2) * (size * j * j).sum(axis=1)
        return np.asarray(still + np.maximum(seen.min(axis=1) - bend, -size.sum(axis=1)))

    def places_at(self, t: Floats) -> tuple[Floats, Floats]:
        """Return positions and velocities of the walls at times: shape (walls, times)."""
        f, rows = self.forcing, np.array([list(self.params.values())])
        j = np.arange(1, self.harmonics + 1)
        angle = np.outer(f.omega * (t + f.t0), j)
        cosine, sine = np.cos(angle), np.sin(angle)
        at, speed = [], []
        for i, wall in enumerate(self.walls):
            wave = self.waves(i, rows)[0]
            at.append(wall.position + cosine @ wave[::2] + sine @ wave[1::2])
            speed.append(cosine @ (j * f.omega * wave[1::2]) - sine @ (j * f.omega * wave[::2]))
        return np.array(at), np.array(speed)

    def replace(self, **changes: float) -> Self:
        """Return the model with other parameter values; names as in :attr:`params`."""
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

    def made_from_base(self, values: Floats) -> Floats:
        """Write the forces of a base into all parameters, shape (..., parameters), in place; return these."""
        if self.base is not None:
            spring = values[..., 1]
            self.base.row(values, spring * spring if self.stiffness is None else spring)
        return values

    def refuse_made(self, names: Sequence[str]) -> None:
        """Raise InputError for parameters that are made from a base, and cannot vary by themselves."""
        for name in names if self.base is not None else ():
            if name in self.base.made:  # type: ignore[union-attr]
                raise InputError(f"{name} is made by the moving base; make another model with from_si to change it")

    def refuse_base(self, what: str, names: Sequence[str]) -> None:
        """Raise InputError where something would change parameters that a base answers to, and keep its force."""
        if self.base is not None and not {*names}.isdisjoint(("alpha", "k", "stiffness", "omega", *self.base.made)):
            raise InputError(
                f"{what} does not know that the force of a moving base depends on its motion, on damper, spring and "
                "frequency; vary something else, or follow orbits with gz.continuation"
            )

    def changed(self, changes: Mapping[str, Any]) -> dict[str, float]:
        """Return all parameters with other values for some, and with the forces that a base then makes."""
        params = self.params
        named = spread(changes, params, "the model")  # names before units, which others have not
        given = {name: self._number(name, value) for name, value in named.items()}
        new = updated(params, given, "the model")
        if self.base is not None:
            refuse_out_of_range(new["omega"])  # before forces are divided by its square
            k2 = new["k"] * new["k"] if self.stiffness is None else new["stiffness"]
            made = self.base.forces(new["alpha"], k2, new["omega"])
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
