"""The contract of a system of one's own: what moves, what it hits, and what is promised of both. All of it is here.

Every function is a kernel: plain scalar Python, tuples of floats, functions of :mod:`math`, other kernels by bare name.
``p`` is the named tuple of the parameters (``A.r`` is ``p.A_r``); ``state`` are the positions, then the velocities.

==========  ==========================  ================================================================================
flight      (t, t0, state, p)           the state at t of what is free and was at ``state`` at t0: exact, closed form
gap         (t, state, p)               (h, dh): how far from the surface, h >= 0 outside, and its rate along the flight
bound       (t, w, state, p)            M >= 0 with abs(h'') <= M on [t, t + w] along the flight from ``state`` at t
law         (t, state, p)               the state just after an impact; without one Newton's law along the normal
rounding    (t, t0, state, p)           (e, d): errors of h and dh as computed at t along the flight from t0, at most
==========  ==========================  ================================================================================
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import lru_cache
from math import pi
from types import MappingProxyType
from typing import Any

from grazing.copies import ByValue, made_of, packed
from grazing.outcome import InputError, UserCodeError, listed, shown, told
from grazing.parameter import (
    COARSE,
    checked_box,
    checked_coordinates,
    checked_params,
    parameters,
    real,
    refuse_late,
    updated,
)

#: Names that mean something else in the parameters or the results of a system.
TAKEN = ("t", "phase", "impact", "trust", "wall", "impact_time", "impact_wall", "v_minus", "v_plus")
#: More surfaces than the letters of a step can tell apart.
MOST_SURFACES = 12
LETTERS = "one capital letter other than C and S"


@dataclass(frozen=True, eq=False)
class Surface(ByValue):
    """Something that a system of one's own hits.

    Parameters
    ----------
    name : str
        One capital letter other than C and S: it stands for an impact in words.
    gap : callable
        ``gap(t, state, p) -> (h, dh)``: the distance, positive while there is none to hit and continued beyond 0, and
        its rate along the flight. ``dh`` must be affine in the velocities.
    bound : callable
        ``bound(t, w, state, p) -> M``: abs(h'') <= M on [t, t + w] along the free flight from ``state`` at t. The
        smaller, the faster; too small, and impacts are missed: :func:`grazing.testing.check_system` looks for that.
    law : callable, optional
        ``law(t, state, p) -> state`` just after an impact, with dh >= 0. Default: Newton's law, by which dh becomes
        -r dh along the normal; r is the parameter ``A.r`` of a surface A, or ``r`` of all.

    Examples
    --------
    >>> import grazing as gz
    >>> def gap(t, state, p):
    ...     x, v = state
    ...     return x, v
    >>> def bound(t, w, state, p):
    ...     return p.g
    >>> gz.Surface("A", gap, bound)
    <Surface A: gap>
    """

    name: str
    gap: Callable[..., Any]
    bound: Callable[..., Any]
    law: Callable[..., Any] | None = None

    def __post_init__(self) -> None:
        name = self.name
        if not (isinstance(name, str) and len(name) == 1 and "A" <= name <= "Z" and name not in "CS"):
            raise InputError(f"name of a surface is {shown(name)}; allowed is {LETTERS}, which stands in words")
        for what, form in (("gap", "(t, state, p) -> (h, dh)"), ("bound", "(t, w, state, p) -> M")):
            _refuse_no_function(getattr(self, what), f"{what} of surface {name}", f"{what}{form}")
        if self.law is not None:
            _refuse_no_function(self.law, f"law of surface {name}", "law(t, state, p) -> state")

    def __repr__(self) -> str:
        return f"<Surface {self.name}: {getattr(self.gap, '__name__', 'gap')}>"

    def __reduce__(self) -> Any:
        return made_of, (Surface, tuple(packed(getattr(self, item.name)) for item in fields(self)))


@dataclass(frozen=True, eq=False)
class System(ByValue):
    """A system of one's own that hits things: a flight in closed form, and surfaces.

    :func:`grazing.trajectory` follows it, :func:`grazing.stroboscopic_map` makes a map of it for all studies, and
    :func:`grazing.testing.check_system` holds its functions to what they promise.

    Parameters
    ----------
    positions, velocities : sequence of str
        Names of the coordinates, as many velocities as positions; a state has the positions first.
    params : mapping of str to float
        Ordered; the fields of ``p``, a dot in a name being an underscore there.
    flight : callable
        ``flight(t, t0, state, p) -> state`` at t of what is free and was at ``state`` at t0. Closed form, no solver.
    surfaces : sequence of Surface
        What it hits.
    box : sequence of (low, high)
        Where random starts are drawn, one pair per coordinate; those inside a surface end at once, by name.
    period : callable or float, optional
        ``period(p)`` of whatever drives flight and surfaces; needed for a stroboscopic map only.
    rounding : callable, optional
        ``rounding(t, t0, state, p) -> (e, d)``: how far gap and rate, as computed at t along the flight from t0, may be
        from the exact ones. Default: 32 units in the last place of the sizes involved, a velocity counting as the way
        gone in a radian of the period; then nothing is *certified*.
    name : str, optional
        Shown in messages and figures.

    Raises
    ------
    InputError
        For names that collide, or a box that does not fit.
    UserCodeError
        If a function raises or returns what it must not in the middle of the box.

    Examples
    --------
    >>> import grazing as gz
    >>> def flight(t, t0, state, p):
    ...     x, v = state
    ...     s = t - t0
    ...     return x + (v - 0.5 * p.g * s) * s, v - p.g * s
    >>> def gap(t, state, p):
    ...     x, v = state
    ...     return x, v
    >>> def bound(t, w, state, p):
    ...     return p.g
    >>> floor = gz.Surface("A", gap, bound)
    >>> ball = gz.System(("x",), ("v",), {"g": 1.0, "r": 0.5}, flight, [floor], box=((0.5, 1.0), (-1.0, 1.0)))
    >>> gz.trajectory(ball, (0.5, 0.0), until=2.6).impact_time.values
    array([1. , 2. , 2.5])
    """

    positions: Sequence[str]
    velocities: Sequence[str]
    params: Mapping[str, float]
    flight: Callable[..., Any]
    surfaces: Sequence[Surface]
    box: Sequence[tuple[float, float]]
    period: Callable[..., float] | float | None = None
    rounding: Callable[..., Any] | None = None
    name: str | None = None
    _parts: tuple[Any, ...] = field(init=False, repr=False, compare=False, default=())

    def __post_init__(self) -> None:
        if self.name is not None and not isinstance(self.name, str):
            raise InputError(f"name is {shown(self.name)}; give a text, or leave it out")
        positions, velocities = checked_coordinates(self.positions), checked_coordinates(self.velocities)
        if len(positions) != len(velocities):
            raise InputError(
                f"there are {len(positions)} positions ({', '.join(positions)}) and {len(velocities)} velocities "
                f"({', '.join(velocities)}); give a velocity for each position"
            )
        params = checked_params(self.params)
        _refuse_collisions([*positions, *velocities, *(name.replace(".", "_") for name in params)])
        _refuse_no_function(self.flight, "flight", "flight(t, t0, state, p) -> state")
        if self.rounding is not None:
            _refuse_no_function(self.rounding, "rounding", "rounding(t, t0, state, p) -> (e, d)")
        surfaces = tuple(self.surfaces) if isinstance(self.surfaces, Sequence) else (self.surfaces,)
        if not surfaces or not all(isinstance(one, Surface) for one in surfaces):
            raise InputError(f"surfaces are {shown(self.surfaces)}; give a list of gz.Surface(name, gap, bound)")
        if len(surfaces) > MOST_SURFACES:
            raise InputError(f"there are {len(surfaces)} surfaces; at most {MOST_SURFACES} are possible")
        names = [one.name for one in surfaces]
        twice = [name for name in names if names.count(name) > 1]
        if twice:
            raise InputError(f"two surfaces are called {twice[0]}; give each a name of its own")
        if not callable(self.period) and self.period is not None:
            object.__setattr__(self, "period", _positive(self.period))
        object.__setattr__(self, "positions", positions)
        object.__setattr__(self, "velocities", velocities)
        object.__setattr__(self, "params", MappingProxyType(params))
        object.__setattr__(self, "surfaces", surfaces)
        object.__setattr__(self, "box", checked_box(self.box, positions + velocities))
        object.__setattr__(self, "name", str(self.name or "system"))
        restitution = [-1 if one.law else _restitution(one.name, list(params)) for one in surfaces]
        flat = [(one.gap, one.bound, one.law, r) for one, r in zip(surfaces, restitution, strict=True)]
        usual = usual_rounding(len(positions), 2.0 * pi * self.span if self.period is None else self.period)
        rounding = usual if self.rounding is None else given_rounding(self.rounding)
        parts = (len(positions), self.flight, rounding, *(part for four in flat for part in four))
        object.__setattr__(self, "_parts", parts)
        self._try()

    def __repr__(self) -> str:
        values = listed(f"{name}={value:g}" for name, value in self.params.items())
        return f"<System {self.name}: ({listed(self.coordinates)}); {values}>"

    def __reduce__(self) -> Any:
        items = [getattr(self, item.name) for item in fields(self) if item.init]
        return made_of, (System, tuple(packed(item) for item in items))

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Names of the positions, then of the velocities."""
        return (*self.positions, *self.velocities)

    @property
    def parts(self) -> tuple[Any, ...]:
        """What compiled code is made of: number of positions, flight, rounding; gap, bound, law, r a surface."""
        return self._parts

    def replace(self, **changes: float) -> System:
        """Return the system with other parameter values; compiled code is kept."""
        return replace(self, params=updated(self.params, changes, self.name or "system"))

    def period_at(self, params: Mapping[str, float]) -> float:
        """Return the period at parameters, or raise InputError where there is none."""
        if self.period is None:
            raise InputError(
                f"{self.name} has no period; give gz.System(..., period=) the time after which flight and surfaces "
                "repeat themselves, or any time if they do not depend on it"
            )
        if not callable(self.period):
            return self.period
        try:
            return _positive(self.period(parameters(params)))
        except InputError:
            raise
        except Exception as error:
            raise UserCodeError(
                f"the period of {self.name} raised {told(error, self.period)} ({dict(params)})"
            ) from error

    @property
    def clock(self) -> Callable[..., float] | float:
        """The period as compiled code gets it; without one, a time of the system."""
        return self.span if self.period is None else self.period

    @property
    def span(self) -> float:
        """A time of the system, in its own unit: the period, or twice that in which a velocity crosses the box."""
        if self.period is not None:
            return self.period_at(self.params)
        n, widths = len(self.positions), [high - low for low, high in self.box]
        return 2.0 * max(x / v for x, v in zip(widths[:n], widths[n:], strict=True))

    def gaps(self, t: float, state: tuple[float, ...], params: Mapping[str, float]) -> dict[str, tuple[float, float]]:
        """Return gap and rate of each surface by its name, in plain Python."""
        p, found = parameters(params), {}
        for one in self.surfaces:
            h, dh = _numbers(one.gap, (t, state, p), 2, f"the gap of surface {one.name}", "(h, dh)")
            found[one.name] = h, dh
        return found

    def refuse_late(self, time: float, name: str, params: Mapping[str, float], span: float = math.inf) -> None:
        """Raise InputError for a time at which doubles lie too far apart for a period, or for a shorter motion."""
        span = span if self.period is None else min(span, self.period_at(params))
        refuse_late(time, name, COARSE * span)

    def refuse_inside(self, t: float, state: tuple[float, ...], params: Mapping[str, float]) -> None:
        """Raise InputError for a start inside a surface by more than rounding."""
        p = parameters(params)
        for name, (h, dh) in self.gaps(t, state, params).items():
            if self.rounding is not None:  # what it raises comes with its own line
                _numbers(self.rounding, (t, t, state, p), 2, "rounding", "(e, d)")
            e, _d = self._parts[2](t, t, state, state, h, dh, p)
            if h < -e:
                raise InputError(
                    f"the start is inside surface {name}: its gap is {h:g} at t = {t:g}, "
                    f"{', '.join(f'{x} = {value:g}' for x, value in zip(self.coordinates, state, strict=True))}; "
                    "start where all gaps are >= 0"
                )

    def _try(self) -> None:
        """Try each function once, so that its own errors come with its own line."""
        p, middle = parameters(self.params), tuple(0.5 * (low + high) for low, high in self.box)
        n, state = len(middle), f"a state of {len(middle)} finite numbers ({', '.join(self.coordinates)})"
        soon = 1e-3 * self.span
        _numbers(self.flight, (soon, 0.0, middle, p), n, "the flight", state)
        if self.rounding is not None:
            _numbers(self.rounding, (0.0, 0.0, middle, p), 2, "rounding", "(e, d), two finite numbers >= 0")
        for one in self.surfaces:
            of = f"of surface {one.name}"
            _numbers(one.gap, (0.0, middle, p), 2, f"the gap {of}", "(h, dh), two finite numbers")
            M = _numbers(one.bound, (0.0, soon, middle, p), 0, f"the bound {of}", "one finite number >= 0")[0]
            if M < 0.0:
                raise UserCodeError(f"the bound {of} returned {M:g}; it bounds abs(h''), so allowed is M >= 0")
            if one.law is not None:
                _numbers(one.law, (0.0, middle, p), n, f"the law {of}", state)


def constant(T: float) -> Callable[..., float]:
    """Return a period as a kernel that does not depend on the parameters."""

    def period(_p: Any) -> float:
        return T

    return period


@lru_cache(maxsize=256)
def usual_rounding(positions: int, period: Callable[..., float] | float) -> Callable[..., tuple[float, float]]:
    """Return ``rounding(t, t0, before, now, h, dh, p) -> (e, d)`` of a system that does not say how it rounds.

    That is 32 units in the last place of all sizes involved, a velocity counting as the way gone in a radian of the
    period.
    """
    time = period if callable(period) else constant(period)

    def rounding(t: float, t0: float, before: Any, now: Any, h: float, dh: float, p: Any) -> tuple[float, float]:
        turn = time(p) / (2.0 * pi)
        size, fast, moved = abs(h), abs(dh), 0.0
        for i in range(2 * positions):
            if i < positions:
                size += abs(before[i]) + abs(now[i])
            else:
                moved += abs(before[i])
                fast += abs(now[i])
        e = 7.2e-15 * (size + turn * (fast + moved)) + 9e-16 * abs(t) * fast
        return e, e / turn

    rounding.made_by = usual_rounding, (positions, period)  # type: ignore[attr-defined]
    return rounding


@lru_cache(maxsize=256)
def given_rounding(function: Callable[..., Any]) -> Callable[..., tuple[float, float]]:
    """Return a user's ``rounding(t, t0, state, p)`` with the arguments of the usual one."""

    def rounding(t: float, t0: float, before: Any, now: Any, h: float, dh: float, p: Any) -> tuple[float, float]:
        e, d = function(t, t0, before, p)
        return 1.0 * e, 1.0 * d

    rounding.made_by = given_rounding, (function,)  # type: ignore[attr-defined]
    return rounding


def _refuse_no_function(value: Any, what: str, form: str) -> None:
    if not callable(value):
        raise InputError(f"{what} is {shown(value)}; give a function {form}")


def _refuse_collisions(names: list[str]) -> None:
    for name in names:
        if names.count(name) > 1:
            raise InputError(f"{name} is the name of two coordinates or parameters; give each a name of its own")
        if name in TAKEN:
            raise InputError(f"{name} cannot be the name of a coordinate or parameter: it means something in results")


def _positive(value: Any) -> float:
    period = real(value, "period", "allowed is period > 0, finite")
    if not period > 0.0:
        raise InputError(f"period = {period:g}; allowed is period > 0, finite")
    return period


def _restitution(surface: str, names: list[str]) -> int:
    """Return the place of the coefficient of restitution of a surface without a law of its own."""
    for name in (f"{surface}.r", "r"):
        if name in names:
            return names.index(name)
    raise InputError(
        f"surface {surface} has no law, and there is no parameter '{surface}.r' or 'r' for Newton's; give one of them"
    )


def tried(function: Callable[..., Any], args: tuple[Any, ...], what: str) -> Any:
    """Call a user's function in plain Python: what it raises there comes with its own line."""
    try:
        return function(*args)
    except Exception as error:
        raise UserCodeError(f"{what} raised {told(error, function)} (called with {shown(args)})") from error


def _numbers(function: Callable[..., Any], args: tuple[Any, ...], n: int, what: str, wanted: str) -> tuple[float, ...]:
    """Call a user's function in plain Python; return its n numbers (0: one alone), or say what is wrong."""
    found = tried(function, args, what)
    several = found if n else (found,)
    fits = isinstance(several, tuple) and len(several) == max(n, 1)
    if not fits or not all(isinstance(x, (int, float)) and not isinstance(x, bool) for x in several):
        raise UserCodeError(f"{what} returned {shown(found)}; it must return {wanted}")
    if not all(math.isfinite(x) for x in several):
        raise UserCodeError(f"{what} returned {shown(found)} (called with {shown(args)}); it must return {wanted}")
    return tuple(float(x) for x in several)
