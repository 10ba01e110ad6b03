"""The model: a forced linear oscillator above a wall, with a reset law."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import pi
from typing import Any

from grazing.oscillator.constants import natural_size
from grazing.oscillator.deflection import warn_of_gap
from grazing.oscillator.forcing import HIGHEST, Forcing, series_said
from grazing.oscillator.parameters import COORDINATES, MASS, describe_parameter, means_model
from grazing.oscillator.reach import Reach, before_saddle, drive_of, natural, reach_of
from grazing.oscillator.reset import Reset, active, linear_part, probe, warn_of_gain
from grazing.oscillator.rig import Place, Rig, places_of
from grazing.oscillator.si import Base, checked_side, si_numbers
from grazing.oscillator.spring import frequency_of, spring_of
from grazing.oscillator.wall import NAMES, Wall
from grazing.outcome import InputError, listed, shown
from grazing.parameter import Parameter, checked_text, refuse_late


@dataclass(frozen=True, slots=True)
class Oscillator(Rig):
    """A forced linear oscillator above a wall: u'' + alpha u' + k^2 u = f(t) for u > sigma, and a reset law.

    Parameters
    ----------
    alpha : float
        Damping coefficient; a negative one feeds the motion.
    k : float
        Natural frequency, >= 0.
    forcing : Forcing
        The periodic forcing f.
    sigma : float
        Position of the wall.
    reset : Reset
        What an impact does: :func:`newton`, :func:`active`, :func:`triggered` or :func:`reset`.
    mass : float, optional
        In kg, > 0: the numbers are then metres and seconds, and results and figures carry units. Default: all is
        dimensionless. :meth:`from_si` makes such a model from mass, damper, spring and force.
    stiffness : float, optional
        In place of k, and a parameter of this name: u'' + alpha u' + stiffness u = f(t). A negative one drives the ball
        away from u = 0, as gravity does an inverted pendulum; one that nothing holds has *diverged*.
    walls : sequence of wall, optional
        One or two of :func:`wall`, instead of ``reset`` and ``sigma``: walls on either side of the ball, which may
        move. The model is then of another class; what is for one wall at rest alone refuses it.

    Raises
    ------
    InputError
        For a value out of range.

    References
    ----------
    Pring and Budd, IMA J. Appl. Math. 76 (2011) 67-84, equations (1.1) to (1.3).

    Examples
    --------
    >>> import grazing as gz
    >>> m = gz.Oscillator(alpha=0.1, k=1, forcing=gz.Forcing(omega=2.8), sigma=-0.1, reset=gz.newton(r=0.9))
    >>> m.replace(r=0.5).params["r"]
    0.5
    """

    alpha: float
    k: float = None  # type: ignore[assignment]  # a number, unless the stiffness is given
    forcing: Forcing = None  # type: ignore[assignment]  # these two are asked for
    reset: Reset = None  # type: ignore[assignment]
    sigma: float = 0.0
    stiffness: float | None = field(default=None, kw_only=True)
    mass: float | None = field(default=None, kw_only=True, repr=False)
    offset_name: str = field(default="offset", kw_only=True, repr=False)
    paper: bool = field(default=False, kw_only=True, repr=False)
    base: Base | None = field(default=None, kw_only=True, repr=False)
    stop: str | None = field(default=None, kw_only=True, repr=False)

    def __post_init__(self) -> None:
        if isinstance(self.sigma, Sequence) and not isinstance(self.sigma, (str, bytes)):
            raise InputError(
                f"sigma = {shown(self.sigma)}; sigma is one number, the place of a single wall below the ball; "
                "give two as walls=[gz.wall(low, law), gz.wall(high, law)]"
            )
        spring = spring_of(self)[0]
        for name in ("alpha", spring, "sigma"):
            object.__setattr__(self, name, describe_parameter(name).check(getattr(self, name)))
        if self.mass is not None:
            object.__setattr__(self, "mass", MASS.check(self.mass))
        if self.stop is not None:
            checked_side(self.stop, "stop")
        for name, high in (("alpha", HIGHEST), (spring, HIGHEST if spring == "k" else HIGHEST**2)):
            value = getattr(self, name)
            if abs(value) > high:
                size = f"|{name}|" if value < 0.0 or name == "stiffness" else name
                raise InputError(f"{name} = {value:g}; allowed is {size} <= {high:g}: beyond, numbers overflow")
        if not isinstance(self.forcing, Forcing):
            raise InputError(f"forcing is {shown(self.forcing)}; {series_said(self.forcing)}")
        if not isinstance(self.reset, Reset):
            raise InputError(f"reset is {shown(self.reset)}; give gz.newton(r), gz.active(r, V) or gz.reset(law, ...)")
        clash = [name for name in self.reset.params if means_model(name)]
        if clash:
            raise InputError(f"the reset law's parameter {min(clash)!r} has the name of a model parameter; rename it")
        if self.base is not None:
            cos, sin = zip(*self.base.forces(self.alpha, self.k2, self.forcing.omega), strict=True)
            object.__setattr__(self, "forcing", replace(self.forcing, cos=cos, sin=sin))
        if not self.reset.affine:
            f, force = self.forcing, self.forcing.offset - self.k2 * self.sigma
            speed = drive_of(self.alpha, frequency_of(self), f.omega, force, f.cos, f.sin)[1]
            probe(self.reset, speed)
            warn_of_gain(self.reset, speed)

    def __new__(cls, *args: Any, walls: Any = None, **named: Any) -> Any:
        """Make an oscillator over one wall, or with ``walls`` one between them."""
        if walls is None:
            return object.__new__(cls)
        from grazing.oscillator.walled import Walled

        given = dict(zip(("alpha", "k", "forcing", "reset"), args, strict=False)) | named
        kept = {"alpha", "k", "stiffness", "forcing", "mass", "base"}
        cls._refuse_beside(sorted(set(given) - kept) or (["reset"] if len(args) > 3 else []))
        if missing := [name for name in ("alpha", "forcing") if name not in given]:
            raise InputError(f"an oscillator between walls needs {listed(missing)} as well")
        return Walled(**({"k": None} | given), walls=walls)

    @staticmethod
    def _refuse_beside(names: Sequence[str]) -> None:
        """Raise InputError for what is given beside walls, and belongs to each of them."""
        if names:
            raise InputError(
                f"walls are given beside {listed(names)}; each wall has its own law and position: "
                "gz.wall(position, law)"
            )

    @classmethod
    def from_si(
        cls,
        *,
        m: Any,
        c: Any,
        k: Any,
        gap: Any = None,
        reset: Any = None,
        force: Any = 0.0,
        side: str | None = None,
        base: Any = 0.0,
        moves: str = "both",
        load: Any = 0.0,
        frequency: Any = None,
        omega: Any = None,
        acceleration: Any = 0.0,
        walls: Any = None,
    ) -> Any:
        """Return the model of a mass on a spring and a damper with a stop, all in SI units.

        Every number may also be a quantity of pint, or a text such as ``"1.2 mm"`` (``pip install 'grazing[units]'``).

        Parameters
        ----------
        m, c, k : float
            Mass, > 0, in kg; viscous damping, >= 0, in N s/m; stiffness, >= 0, in N/m.
        gap : float
            Distance from the mass to the stop where the spring is relaxed, >= 0, in m. A warning says where it is more
            than ten times the largest deflection that the force brings.
        reset : Reset
            Such as ``gz.newton(0.7)``; its speeds are in m/s.
        force : float or sequence of float
            Amplitude in N: the mass feels force cos(omega t), upwards. Several are those of harmonics 1, 2, ...
        side : {"above", "below"}
            Where the stop is; above, unless said. Above, u points down: u = -x; below, u = x. In both the wall is at
            u = -gap. Figures show x, upwards; results, tables and starts are in u.
        base : float or sequence of float
            Amplitude in m of a base that moves by base cos(omega t), positive upwards. A sweep in ``omega`` keeps it:
            the force grows with the frequency.
        moves : {"both", "spring", "stop"}
            What the base carries: spring, damper and stop; the first two; or the stop. If it carries the stop, u is
            relative to the base.
        load : float
            Constant force in N, positive upwards: a weight is ``-9.81 * m``.
        frequency, omega : float
            Of the forcing, in Hz or in rad/s: one of them.
        acceleration : float or sequence of float
            Amplitude in m/s^2 of a base, which a sweep in ``omega`` keeps: it moves by
            acceleration/omega^2 cos(omega t). Added to ``base``.
        walls : sequence of wall
            One or two of :func:`wall`, in place of ``gap``, ``reset`` and ``side``: stops at these positions x, upwards
            from where the spring is relaxed, in m or with units, as ``gz.wall("1.2 mm", law)``. u is then x. A base
            that carries "the stop" carries both.

        Returns
        -------
        Oscillator
            alpha = c/m, k = sqrt(k/m), the forces per unit of mass; ``mass`` is m. Results of it carry units.

        Raises
        ------
        InputError
            For units that do not match, a mass that is not positive, or a negative gap.

        Examples
        --------
        >>> import grazing as gz
        >>> law = gz.newton(0.7)
        >>> rig = gz.Oscillator.from_si(m=0.8, c=2.4, k=3200, force=2.5, gap="1.2 mm", frequency=14, reset=law)
        >>> rig
        <Oscillator alpha=3, k=63.2456, omega=87.9646, t0=0, offset=0, cos1=-3.125, sin1=0, sigma=-0.0012, mass=0.8,
        newton(r=0.7)>
        """
        numbers = {"m": m, "c": c, "k": k, "force": force, "base": base, "moves": moves, "load": load}
        numbers |= {"frequency": frequency, "omega": omega, "acceleration": acceleration}
        if walls is not None:
            from grazing.oscillator.walled import Walled

            beside = [name for name, one in (("gap", gap), ("reset", reset), ("side", side)) if one is not None]
            cls._refuse_beside(beside)
            found = si_numbers(**numbers, gap=0.0, side="below")
            forcing = Forcing(found.omega, offset=found.offset, cos=found.cos, sin=found.sin)
            model = Walled(found.alpha, found.k, forcing, walls, mass=found.mass, base=found.base)
            still = not model.moves
            warn_of_gap(found, min(-one.sign * one.position for one in model.walls) if still else 0.0)
            return model
        if gap is None or reset is None:
            one = "gap is missing; give the distance to the stop, such as gap='1.2 mm'"
            one = one if gap is None else "reset is missing; give the law of the stop, such as reset=gz.newton(r=0.7)"
            raise InputError(f"{one}; or several stops as walls")
        side = "above" if side is None else side
        found = si_numbers(**numbers, gap=gap, side=side)
        warn_of_gap(found, -found.sigma)
        forcing = Forcing(found.omega, offset=found.offset, cos=found.cos, sin=found.sin)
        return cls(found.alpha, found.k, forcing, reset, found.sigma, mass=found.mass, base=found.base, stop=side)

    def describe(self, name: str) -> Parameter:
        """Return what is known of a parameter or a coordinate, with its units."""
        own = checked_text(name) in COORDINATES and name not in self.reset.params
        known = COORDINATES[name] if own else describe_parameter(name)
        return known if self.mass is not None else replace(known, units="1")

    def _flight_params(self) -> dict[str, float]:
        f = self.forcing
        spring, value = spring_of(self)
        values = {"alpha": self.alpha, spring: value, "omega": f.omega, "t0": f.t0, self.offset_name: f.offset}
        for j, (c, s) in enumerate(zip(f.cos, f.sin, strict=True), start=1):
            values |= {f"cos{j}": c, f"sin{j}": s}
        return values | {"sigma": self.sigma}

    @property
    def reach(self) -> Reach:
        """How far and how fast the ball goes, as a rule: where random starts are drawn unless said."""
        return self.reach_at(list(self.params.values()))

    def reach_at(self, row: Sequence[float]) -> Reach:
        """Return how far and how fast the ball goes at other parameter values, in the order of :attr:`params`."""
        alpha, spring, omega, _t0, offset = row[:5]
        k, k2 = (spring, spring * spring) if self.stiffness is None else (natural(spring), spring)
        wall = 5 + 2 * self.harmonics
        sigma, cos, sin, force = row[wall], row[5:wall:2], row[6:wall:2], offset - k2 * row[wall]
        forces, law = (omega, force, cos, sin), dict(zip(self.reset.params, row[wall + 1 :], strict=False))
        if self.reset.affine:
            r, V = law.get("r", 0.0), law.get("V", 0.0)
        else:
            r, V = linear_part(self.reset, law, drive_of(alpha, k, *forces)[1])
        return Reach(sigma, 2.0 * pi / omega, *before_saddle(reach_of(alpha, k, *forces, sigma, r, V), force, k2))

    def unit_of(self, name: str) -> float:
        """Return the model's own unit of a parameter, > 0: what counts as a step where the parameter itself is 0."""
        f = self.forcing
        push = math.fsum(map(math.hypot, f.cos, f.sin)) or abs(f.offset - self.k2 * self.sigma) or 1.0
        drive = drive_of(self.alpha, frequency_of(self), f.omega, push, f.cos, f.sin)[1]
        known = {
            "alpha": f.omega, "k": f.omega, "omega": f.omega, "t0": 0.5 * self.period,
            "sigma": natural_size(self.alpha, self.period, push), "V": drive, "trigger": drive,
        }  # fmt: skip
        return known.get(checked_text(name), push if describe_parameter(name).units == "N/kg" else 1.0)

    @property
    def params(self) -> Mapping[str, float]:
        """All parameters, flat and in a fixed order: alpha k omega t0 offset cos1 sin1 ... sigma, then the law's."""
        return {**self._flight_params(), **self.reset.params}

    @property
    def harmonics(self) -> int:  # type: ignore[override]  # as many as the forcing has
        """Number of harmonics of the forcing."""
        return len(self.forcing.cos)

    @property
    def walls(self) -> tuple[Wall, ...]:  # type: ignore[override]  # its wall is this number and the law
        """The one wall, below the ball and at rest."""
        return (Wall(self.sigma, self.reset, "below", None, NAMES[0]),)

    @property
    def seen(self) -> tuple[Oscillator, ...]:  # type: ignore[override]
        """What the wall sees: this oscillator."""
        return (self,)

    @property
    def places(self) -> tuple[Place, ...]:  # type: ignore[override]
        """Where the numbers of the wall stand in a row of :attr:`params`."""
        return places_of(self.walls, self.forcing)

    def replace(self, **changes: float) -> Oscillator:
        """Return the model with other parameter values.

        Parameters
        ----------
        **changes : float or pint.Quantity
            Names of :attr:`params`.
        """
        new = self.changed(changes)
        new[self.offset_name] = describe_parameter(self.offset_name).check(new[self.offset_name])
        forcing = Forcing(
            omega=new["omega"],
            t0=new["t0"],
            offset=new[self.offset_name],
            cos=tuple(new[f"cos{j + 1}"] for j in range(self.harmonics)),
            sin=tuple(new[f"sin{j + 1}"] for j in range(self.harmonics)),
        )
        law = self.reset.replace(**{name: new[name] for name in self.reset.params})
        kept: dict[str, Any] = {name: getattr(self, name) for name in ("mass", "offset_name", "paper", "base", "stop")}
        kept[spring_of(self)[0]] = new[spring_of(self)[0]]
        return Oscillator(new["alpha"], forcing=forcing, reset=law, sigma=new["sigma"], **kept)

    def __repr__(self) -> str:
        values = listed(f"{name}={value:g}" for name, value in self._flight_params().items())
        mass = "" if self.mass is None else f"mass={self.mass:g}, "
        mass += "" if self.base is None else f"base ({self.base.text}), "
        return f"<Oscillator {values}, {mass}{shown(self.reset)}>"


def checked_phase(model: Any, phase: Any) -> float:
    """Return the time of a section, or raise InputError, also for one so late that doubles have no phase there."""
    time = describe_parameter("phase").check(phase)
    refuse_late(time, "phase", model.period)
    return time


def checked_model(model: Any) -> Oscillator:
    """Return an oscillator over one wall at rest, or raise InputError."""
    if isinstance(model, Rig) and model.walled:
        raise InputError(
            f"model is {shown(model)}; this is for an oscillator with one wall below it, at rest. Orbits, branches "
            "and windows of others: gz.periodic_orbits and gz.continuation of their maps, gz.windows"
        )
    if not isinstance(model, Oscillator):
        raise InputError(f"model is {shown(model)}; give an oscillator, such as gz.pinball() or gz.Oscillator(...)")
    return model


def pinball(
    alpha: float = 3.0,
    k: float = 1.0,
    omega: float = 2.2,
    t0: float = 0.0,
    d: float = 0.12,
    r: float = 0.8,
    V: float = 0.4,
    sigma: float = 0.0,
) -> Oscillator:
    """Return the paper's pinball machine: f(t) = cos(omega (t + t0)) + d, active bumper at u = sigma.

    Parameters
    ----------
    alpha : float
        Damping coefficient, >= 0.
    k : float
        Natural frequency, >= 0.
    omega : float
        Frequency of the forcing, > 0.
    t0 : float
        Time shift of the forcing.
    d : float
        Constant part of the forcing.
    r : float
        Coefficient of restitution, 0 <= r <= 1.
    V : float
        Extra velocity given by the bumper, >= 0; V = 0 is the passive oscillator.
    sigma : float
        Position of the wall.

    Returns
    -------
    Oscillator
        The defaults are the standard set of Figure 1.5.

    References
    ----------
    Pring and Budd, IMA J. Appl. Math. 76 (2011) 67-84, equations (1.1) and (1.3).

    Examples
    --------
    >>> import grazing as gz
    >>> m = gz.pinball(alpha=3, k=1, omega=2.2, t0=0, d=0.12, r=0.8, V=0.4)
    >>> m
    <Oscillator alpha=3, k=1, omega=2.2, t0=0, d=0.12, cos1=1, sin1=0, sigma=0, active(r=0.8, V=0.4)>
    >>> m.replace(d=0.10).params["d"]
    0.1
    """
    forcing = Forcing(omega=omega, t0=t0, offset=describe_parameter("d").check(d))
    return Oscillator(alpha, k, forcing, active(r, V), sigma, offset_name="d", paper=True)
