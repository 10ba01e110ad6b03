"""A forced linear oscillator between two walls, or at one that moves or is above it.

Seen from a wall, with y the distance to it, every such model is an oscillator above one wall at rest: a wall above
turns u into -u, a moving one adds its inertia to the force. So all that is proven of one wall holds for each.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from grazing.oscillator.forcing import Forcing, series_said
from grazing.oscillator.model import Oscillator
from grazing.oscillator.parameters import COORDINATES, MASS, describe_parameter, means_model, parameter_units
from grazing.oscillator.reach import Reach
from grazing.oscillator.rig import HEAD, Place, Rig, places_of
from grazing.oscillator.si import Base
from grazing.oscillator.spring import spring_of
from grazing.oscillator.wall import SAME, Wall, checked_walls, harmonics_of, in_harmonics
from grazing.outcome import InputError, listed, shown
from grazing.parameter import Parameter, checked_text, spread

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Walled(Rig):
    """A forced linear oscillator with its walls: what ``gz.Oscillator(..., walls=...)`` makes.

    u'' + alpha u' + k^2 u = f(t) between the walls, or with a stiffness of either sign in place of k^2; a wall's law
    says what an impact makes of the velocity relative to it.

    Parameters
    ----------
    alpha : float
        Damping coefficient.
    k : float or None
        Natural frequency, >= 0; 0 for a ball without a spring. None where the stiffness is given.
    forcing : Forcing
        The periodic force f; its frequency is that of the walls' motions, too.
    walls : sequence of Wall
        One or two of :func:`grazing.wall`; from below, once the model is made.
    stiffness : float, optional
        In place of k.
    mass : float, optional
        In kg: the numbers are then metres and seconds, and results carry units; see :meth:`Oscillator.from_si`.
    base : Base, optional
        A moving base, which makes the force.

    Raises
    ------
    InputError
        For a value out of range, walls that leave no room between them at some time, or a motion whose frequency is
        no multiple of the forcing's.

    Examples
    --------
    >>> import grazing as gz
    >>> table = gz.wall(0.0, gz.newton(0.85), motion=gz.Forcing(omega=1.0, sin=(1.0,), cos=()))
    >>> ball = gz.Oscillator(alpha=0, k=0, forcing=gz.Forcing(omega=1.0, offset=-1.0, cos=()), walls=[table])
    >>> ball.replace(r=0.5).params["r"]
    0.5
    """

    walled: ClassVar[bool] = True
    offset_name = "offset"

    alpha: float
    k: float
    forcing: Forcing
    walls: Sequence[Wall]
    stiffness: float | None = field(default=None, kw_only=True)
    mass: float | None = field(default=None, kw_only=True, repr=False)
    base: Base | None = field(default=None, kw_only=True, repr=False)
    #: The oscillator that each wall sees.
    seen: tuple[Oscillator, ...] = field(init=False, repr=False, compare=False)
    #: Where the numbers of each wall stand in a row of :attr:`params`; the number of harmonics of force and motions.
    places: tuple[Place, ...] = field(init=False, repr=False, compare=False)
    harmonics: int = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        walls = checked_walls(self.walls)
        if self.mass is not None:
            object.__setattr__(self, "mass", MASS.check(self.mass))
        elif any(one.metres for one in walls):
            raise InputError("the position of a wall has units, and the model has none; make it with from_si")
        if not isinstance(self.forcing, Forcing):
            raise InputError(f"forcing is {shown(self.forcing)}; {series_said(self.forcing)}")
        if self.base is not None:
            spring_of(self)
            cos, sin = zip(*self.base.forces(self.alpha, self.k2, self.forcing.omega), strict=True)
            object.__setattr__(self, "forcing", replace(self.forcing, cos=cos, sin=sin))
        walls = tuple(replace(one, motion=in_harmonics(one.motion, self.forcing)) for one in walls)
        object.__setattr__(self, "walls", walls)
        for one in walls:
            clash = [name for name in one.law.params if means_model(name)]
            if clash:
                raise InputError(
                    f"the parameter {min(clash)!r} of the law of wall {one.name} has the name of a model parameter; "
                    "rename it"
                )
        places = places_of(walls, self.forcing)
        moving = [(place.motion.stop - place.motion.start) // 2 for place in places]
        object.__setattr__(self, "places", places)
        object.__setattr__(self, "harmonics", max(len(self.forcing.cos), *moving))
        row = list(self.params.values())
        # checks ranges, and the laws at speeds of this model
        object.__setattr__(self, "seen", tuple(self._seen_from(j, row) for j in range(len(walls))))
        room = float(self.rooms(np.array([row]))[0])
        if not room > 0.0:
            raise InputError(
                f"the walls come within {room:g} of each other; the ball needs room between them: move them apart, or "
                "make their motions smaller"
            )

    # ---- parameters

    @property
    def params(self) -> Mapping[str, float]:
        """All parameters, flat and in a fixed order: those of the flight, then wall by wall from below.

        With two walls those of each have its name in front: ``A.sigma``, ``A.r``; so has a motion, ``A.cos1``, always.
        """
        f = self.forcing
        name, value = spring_of(self)
        values = {"alpha": self.alpha, name: value, "omega": f.omega, "t0": f.t0, "offset": f.offset}
        for j, (c, s) in enumerate(zip(f.cos, f.sin, strict=True), start=1):
            values |= {f"cos{j}": c, f"sin{j}": s}
        for one in self.walls:
            front = f"{one.name}." if len(self.walls) > 1 else ""
            values[f"{front}sigma"] = one.position
            if one.motion is not None:
                for j, (c, s) in enumerate(zip(*harmonics_of(one.motion, f), strict=True), start=1):
                    values |= {f"{one.name}.cos{j}": c, f"{one.name}.sin{j}": s}
            values |= {f"{front}{name}": value for name, value in one.law.params.items()}
        return values

    @property
    def stop(self) -> str | None:  # type: ignore[override]  # each wall has its own side
        """What results with units say of the stops: u is x, and each wall is where it is."""
        return None if self.mass is None else "walls"

    def replace(self, **changes: float) -> Walled:
        """Return the model with other parameter values; names as in :attr:`params`."""
        new = self.changed(changes)
        for name in spread(changes, self.params, "the model"):
            self.describe(name).check(new[name])
        row = list(new.values())
        head = dict(zip(("omega", "t0", "offset"), row[2:HEAD], strict=True))
        stop = HEAD + 2 * len(self.forcing.cos)
        forcing = Forcing(**head, cos=row[HEAD:stop:2], sin=row[HEAD + 1 : stop : 2])
        walls = []
        for one, place in zip(self.walls, self.places, strict=True):
            wave = row[place.motion]
            motion = Forcing(head["omega"], head["t0"], cos=wave[::2], sin=wave[1::2]) if wave else None
            law = one.law.replace(**dict(zip(one.law.params, row[place.law], strict=True)))
            walls.append(replace(one, position=row[place.sigma], motion=motion, law=law))
        kept: dict[str, Any] = {"k": None, spring_of(self)[0]: row[1], "mass": self.mass, "base": self.base}
        return Walled(row[0], **kept, forcing=forcing, walls=walls)

    def describe(self, name: str) -> Parameter:
        """Return what is known of a parameter or a coordinate."""
        front, _dot, last = checked_text(name).rpartition(".")
        known = COORDINATES[last] if last in COORDINATES and not front else describe_parameter(last)
        if front:
            of = "motion" if last.startswith(("cos", "sin")) else "wall"
            meaning = known.meaning.replace("of the forcing", f"of the motion of wall {front}")
            meaning = meaning if of == "motion" else f"{meaning.replace('of the wall', '').strip()} of wall {front}"
            symbol = f"{known.symbol.rstrip()}^{{{front}}}"
            if last == "sigma" and self.mass is not None:  # of a rig, the distance from where its spring is relaxed
                sign = "-" if self.walls[self.names.index(front)].side == "below" else ""
                symbol += rf"={sign}\mathrm{{gap}}^{{{front}}}"
            known = replace(known, name=name, symbol=symbol, meaning=meaning, units=parameter_units(name))
        return known if self.mass is not None else replace(known, units="1")

    def unit_of(self, name: str) -> float:
        """Return the model's own unit of a parameter, > 0: what counts as a step where the parameter itself is 0."""
        front, _dot, last = checked_text(name).rpartition(".")
        moving = bool(front) and last.startswith(("cos", "sin"))
        seen = self.seen[self.names.index(front) if front else 0]
        unit = seen.unit_of("sigma" if moving else last)
        room = float(self.rooms(np.array([list(self.params.values())]))[0])
        return min(unit, 0.5 * room) if moving or last == "sigma" else unit

    def symmetric_at(self, row: Floats) -> bool:
        """Whether the model is its own mirror image half a period later, as far as rounding tells.

        Then (u, t) -> (2 m - u, t + T/(2 g)) takes motions to motions, with m the middle between the walls, and T/g the
        period of what moves it (:attr:`turns`): both have the same law, and what the upper one sees is what the lower
        one saw half of that before.
        """
        if len(self.walls) < 2:
            return False
        low, high = ((one.law.law, list(one.law.params), row[place.law].tolist()) for one, place in
                     zip(self.walls, self.places, strict=True))  # fmt: skip
        if low != high:
            return False
        rows, stop = row[None], HEAD + 2 * self.harmonics
        k2 = float(row[1] * row[1] if self.stiffness is None else row[1])
        seen = [self.rows_seen_from(j, rows)[0, HEAD - 1 : stop + 1] for j in (0, 1)]
        pulls = abs(k2) * np.abs([one[-1] for one in seen]).max()
        for one in seen:
            one[0] -= k2 * one[-1]  # the constant force on a ball at the wall
        seen = [one[:-1] for one in seen]
        turns = np.arange(1, self.harmonics + 1) // max(self.turns_at(row), 1)  # all other harmonics are 0
        later = np.concatenate([[1.0], np.repeat((-1.0) ** turns, 2)])
        between = self.waves(1, rows)[0] - self.waves(0, rows)[0]
        size = np.abs(self.waves(0, rows)).max() + abs(row[self.places[1].sigma] - row[self.places[0].sigma])
        odd = later[1:] < 0.0
        return bool(
            np.abs(seen[1] - later * seen[0]).max() <= SAME * (np.abs(seen).max() + pulls)
            and np.abs(between[odd]).max(initial=0.0) <= SAME * size
        )

    # ---- the model as each wall sees it

    def rows_seen_from(self, j: int, rows: Floats) -> Floats:
        """Return parameters of the oscillator that wall j sees, for rows of :attr:`params`: shape (rows, numbers).

        In the order of :attr:`Oscillator.params`. With x = sign (u - z), z the motion of the wall, the force is
        sign (f - z'' - alpha z' - k^2 z) and the wall lies at rest at sign sigma.
        """
        place, sign, H = self.places[j], self.walls[j].sign, self.harmonics
        forces, stop = 2 * len(self.forcing.cos), HEAD + 2 * H
        found = np.zeros((len(rows), stop + 1 + place.law.stop - place.law.start))
        found[:, : HEAD + forces] = rows[:, : HEAD + forces]
        if self.walls[j].motion is not None:
            cosines, sines = rows[:, place.motion][:, ::2], rows[:, place.motion][:, 1::2]
            W = rows[:, 2:3] * np.arange(1, cosines.shape[1] + 1)
            stiffness = rows[:, 1:2] * rows[:, 1:2] if self.stiffness is None else rows[:, 1:2]
            lift, drag = W * W - stiffness, rows[:, :1] * W
            moved = slice(HEAD, HEAD + 2 * cosines.shape[1], 2), slice(HEAD + 1, HEAD + 1 + 2 * cosines.shape[1], 2)
            found[:, moved[0]] += lift * cosines - drag * sines
            found[:, moved[1]] += lift * sines + drag * cosines
        found[:, HEAD - 1 : stop] *= sign
        found[:, stop] = sign * rows[:, place.sigma]
        found[:, stop + 1 :] = rows[:, place.law]
        return found + 0.0  # no -0

    def _seen_from(self, j: int, row: list[float]) -> Oscillator:
        """Return the oscillator that wall j sees at a row of :attr:`params`."""
        found = self.rows_seen_from(j, np.array([row], np.float64))[0].tolist()
        stop = HEAD + 2 * self.harmonics
        law = self.walls[j].law
        forcing = Forcing(found[2], found[3], found[4], cos=found[HEAD:stop:2], sin=found[HEAD + 1 : stop : 2])
        law = law.replace(**dict(zip(law.params, found[stop + 1 :], strict=True)))
        spring = {spring_of(self)[0]: found[1]}
        return Oscillator(found[0], forcing=forcing, reset=law, sigma=found[stop], **spring)

    def reach_at(self, row: Sequence[float]) -> tuple[Reach, ...]:
        """Return how far and how fast the ball goes as each wall sees it, at a row of parameters."""
        rows = np.array([row], np.float64)
        return tuple(one.reach_at(self.rows_seen_from(j, rows)[0].tolist()) for j, one in enumerate(self.seen))

    def refuse_inside(self, u: float, t: float) -> None:
        """Raise InputError for a ball inside a wall at time t."""
        rows = np.array([list(self.params.values())])
        waves = [float(np.abs(self.waves(j, rows)).sum()) for j in range(len(self.walls))]
        places = self.places_at(np.array([t]))[0][:, 0].tolist()
        for wall, at, wave in zip(self.walls, places, waves, strict=True):
            if wall.sign * (u - at) < -1e-15 * self.harmonics * (wave + abs(wall.position)):
                allowed = "u >= " if wall.sign > 0.0 else "u <= "
                raise InputError(
                    f"the ball starts inside wall {wall.name}, which is {wall.side} it: u = {u:g}, the wall is at "
                    f"{at:g} then; start with {allowed}{at:g}"
                )

    def __repr__(self) -> str:
        values = listed(
            f"{name}={value:g}" for name, value in list(self.params.items())[: HEAD + 2 * len(self.forcing.cos)]
        )
        values += "" if self.mass is None else f", mass={self.mass:g}"
        values += "" if self.base is None else f", base ({self.base.text})"
        walls = ", ".join(
            f"{one.name} {one.side} at {one.position:g}{' moving' if one.motion is not None else ''}: {shown(one.law)}"
            for one in self.walls
        )
        return f"<Oscillator {values}; {walls}>"
