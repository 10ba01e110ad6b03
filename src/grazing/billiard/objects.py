"""What stands on a table: discs, segments, arcs and flippers that the ball hits, each by a law, and drains."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import islice
from math import hypot, pi
from types import MappingProxyType
from typing import Any

from grazing.copies import ByValue
from grazing.oscillator.reset import KNOWN, Reset
from grazing.outcome import InputError, shown
from grazing.parameter import Parameter, checked_params, in_order, real

DISC, SEGMENT, ARC, DRAIN, FLIPPER = "disc", "segment", "arc", "drain", "flipper"
X, Y = (Parameter(name, name, f"{name} of the centre", units="m") for name in "xy")
RADIUS = Parameter("radius", "R", "radius", 0.0, units="m")
ENDS = tuple(Parameter(f"{a}{i}", f"{a}_{i}", f"{a} of end {i}", units="m") for i in (1, 2) for a in "xy")
#: Names of the numbers of each kind, in the order in which they stand in a row of parameters.
GEOMETRY: Mapping[str, tuple[Parameter, ...]] = MappingProxyType({
    DISC: (X, Y, RADIUS),
    SEGMENT: ENDS,
    ARC: (X, Y, replace(RADIUS, open="low"),
          Parameter("start", r"\theta_1", "angle at which it begins", units="rad"),
          Parameter("stop", r"\theta_2", "angle at which it ends, counterclockwise", units="rad")),
    DRAIN: ENDS,
    FLIPPER: (X, Y, Parameter("length", "L", "distance from pivot to centre of the tip", 0.0, open="low", units="m"),
              Parameter("hub", "R_h", "radius at the pivot", 0.0, open="low", units="m"),
              Parameter("tip", "R_t", "radius at the tip", 0.0, open="low", units="m"),
              Parameter("rest", r"\theta_0", "angle at rest", units="rad"),
              Parameter("raised", r"\theta_1", "angle when raised", units="rad"),
              Parameter("up", r"\omega_1", "angular speed on the way up", 0.0, open="low", units="1/s"),
              Parameter("down", r"\omega_0", "angular speed on the way down", 0.0, open="low", units="1/s")),
})  # fmt: skip


@lru_cache(maxsize=4096)
def numbers_of(kind: str, owner: str) -> dict[str, Parameter]:
    """Return what is known of the numbers of an object, which messages call by its name as well."""
    return {known.name: replace(known, name=f"{owner}.{known.name}") for known in GEOMETRY[kind]}


def checked_name(name: Any, kind: str) -> str:
    """Return the name of an object, or raise InputError."""
    if not (isinstance(name, str) and name.isidentifier() and not name.startswith("_")):
        raise InputError(
            f"name of a {kind} is {shown(name)}; allowed are letters, digits and _, as in 'bumper1': it stands in "
            "front of the parameters and in words"
        )
    return str(name)


@dataclass(frozen=True, eq=False)
class Thing(ByValue):
    """An object of a table; made by :func:`disc`, :func:`segment`, :func:`arc`, :func:`flipper` and :func:`drain`.

    ``params`` are the numbers of its shape, then those of its law; a drain has no ``law``.
    """

    name: str
    kind: str
    shape: Mapping[str, float]
    law: Reset | None = None

    def __post_init__(self) -> None:
        name = checked_name(self.name, self.kind)
        if self.kind != DRAIN and not isinstance(self.law, Reset):
            raise InputError(
                f"law of {self.name} is {shown(self.law)}; give gz.newton(r), gz.active(r, V), "
                "gz.triggered(r, V, trigger) or gz.reset(your_law, ...)"
            )
        known, shape = numbers_of(self.kind, name), checked_params(self.shape)
        for key, value in shape.items():
            known[key].check(value)
        clash = [key for key in (self.law.params if self.law else ()) if key in known]
        if clash:
            raise InputError(f"the law of {self.name} has a parameter {clash[0]!r}, as its shape has; rename it")
        object.__setattr__(self, "name", name)
        object.__setattr__(self, "shape", MappingProxyType(shape))
        self._refuse_no_extent()

    def __reduce__(self) -> Any:
        return Thing, (self.name, self.kind, dict(self.shape), self.law)

    def _refuse_no_extent(self) -> None:
        shape, name = self.shape, self.name
        if self.kind in (SEGMENT, DRAIN) and not hypot(shape["x2"] - shape["x1"], shape["y2"] - shape["y1"]) > 0.0:
            raise InputError(
                f"both ends of {name} are at ({shape['x1']:g}, {shape['y1']:g}); give two different points"
            )
        if self.kind == ARC and not 0.0 < shape["stop"] - shape["start"] <= 2.0 * pi * (1.0 + 1e-15):
            raise InputError(
                f"{name} goes from {shape['start']:g} to {shape['stop']:g}; allowed is start < stop <= start + 2 pi, "
                "in radians, counterclockwise"
            )
        if self.kind == FLIPPER and not abs(shape["hub"] - shape["tip"]) < shape["length"]:
            raise InputError(
                f"the radii of {name}, {shape['hub']:g} and {shape['tip']:g}, differ by its length {shape['length']:g} "
                "or more; make it longer"
            )
        if self.kind == FLIPPER and not abs(shape["raised"] - shape["rest"]) <= pi:
            raise InputError(
                f"{name} turns from {shape['rest']:g} to {shape['raised']:g}; allowed is half a turn, in radians"
            )

    @property
    def params(self) -> Mapping[str, float]:
        """The numbers of its shape, then those of its law."""
        return {**self.shape, **(self.law.params if self.law else {})}

    @property
    def lengths(self) -> list[float]:
        """Those numbers of its shape that are lengths."""
        return [self.shape[known.name] for known in GEOMETRY[self.kind] if known.units == "m"]

    def replaced(self, values: Mapping[str, float]) -> Thing:
        """Return the object with all its parameters changed."""
        if all(values[name] is value for name, value in self.params.items()):  # nothing to be checked again
            return self
        shape = {name: values[name] for name in self.shape}
        law = self.law.replace(**{name: values[name] for name in self.law.params}) if self.law else None
        return replace(self, shape=shape, law=law)

    def describe(self, name: str) -> Parameter | None:
        """Return what is known of one of its parameters."""
        known: dict[str, Parameter] = {**KNOWN, **{one.name: one for one in GEOMETRY[self.kind]}}
        if name not in self.params:
            return None
        found = known.get(name) or Parameter(name, name, f"parameter {name} of its law")
        full = f"{self.name}.{name}"
        owner = self.name.replace("_", r"\_")
        symbol = rf"{found.symbol}^\mathrm{{{owner}}}"
        return replace(found, name=full, symbol=symbol, meaning=f"{found.meaning} of {self.name}", units="1")

    def __repr__(self) -> str:
        values = ", ".join(f"{name}={value:g}" for name, value in self.shape.items())
        return f"{self.kind}({self.name!r}, {values}{f', {self.law!r}' if self.law else ''})"


def two_of(value: Any) -> list[Any]:
    """Return what a point holds, two things; any other number of things for what is no point."""
    try:
        return [] if isinstance(value, str) else list(islice(iter(in_order(value)), 3))
    except Exception:  # of whatever object was given
        return []


def point_of(value: Any, name: str, what: str) -> tuple[float, float]:
    """Return a point as two floats, or raise InputError."""
    pair = two_of(value)
    if len(pair) != 2:
        raise InputError(f"{what} of {shown(name)} is {shown(value)}; give a point (x, y)")
    x, y = (real(number, f"{what} of {shown(name)}", "give a point (x, y) of finite numbers") for number in pair)
    return x, y


def _ends(name: str, start: Any, stop: Any) -> dict[str, float]:
    (x1, y1), (x2, y2) = point_of(start, name, "start"), point_of(stop, name, "stop")
    return {"x1": x1, "y1": y1, "x2": x2, "y2": y2}


def disc(name: str, centre: Sequence[float], radius: float, law: Reset) -> Thing:
    """Return a disc, a post or a bumper, for :func:`grazing.table`.

    Parameters
    ----------
    name : str
        Stands in words, and in front of the parameters: ``name.x``, ``name.y``, ``name.radius`` and those of the law.
    centre : (x, y)
    radius : float
        >= 0; 0 is a pin, which a ball with a radius can hit.
    law : Reset
        :func:`grazing.newton`, :func:`grazing.active`, :func:`grazing.triggered` or one of your own: it acts on the
        velocity along the normal.

    Returns
    -------
    Thing

    Raises
    ------
    InputError
        For a name that is none, a value out of range or no law.

    Examples
    --------
    >>> import grazing as gz
    >>> gz.disc("bumper1", (2, 6), 0.5, gz.active(r=0.9, V=0.4))
    disc('bumper1', x=2, y=6, radius=0.5, active(r=0.9, V=0.4))
    """
    x, y = point_of(centre, name, "centre")
    return Thing(name, DISC, {"x": x, "y": y, "radius": radius}, law)


def segment(name: str, start: Sequence[float], stop: Sequence[float], law: Reset) -> Thing:
    """Return a straight wall between two points, hit from either side and at its ends, for :func:`grazing.table`.

    Parameters
    ----------
    name : str
        Stands in words, and in front of the parameters: ``name.x1``, ``name.y1``, ``name.x2``, ``name.y2``, and those
        of the law.
    start, stop : (x, y)
    law : Reset
        As in :func:`grazing.disc`; an active one makes a slingshot.

    Returns
    -------
    Thing

    Raises
    ------
    InputError
        For a name that is none, two equal ends or no law.

    Examples
    --------
    >>> import grazing as gz
    >>> gz.segment("left", (0, 0), (0, 10), gz.newton(0.9))
    segment('left', x1=0, y1=0, x2=0, y2=10, newton(r=0.9))
    """
    return Thing(name, SEGMENT, _ends(name, start, stop), law)


def arc(name: str, centre: Sequence[float], radius: float, start: float, stop: float, law: Reset) -> Thing:
    """Return a circular arc, hit from either side and at its ends, for :func:`grazing.table`.

    Parameters
    ----------
    name : str
        Stands in words, and in front of the parameters: ``name.x``, ``name.y``, ``name.radius``, ``name.start``,
        ``name.stop``, and those of the law.
    centre : (x, y)
    radius : float
        > 0. From inside it is hit only if the ball's radius is smaller.
    start, stop : float
        Angles in radians, counterclockwise from start to stop, at most a full turn apart.
    law : Reset
        As in :func:`grazing.disc`.

    Returns
    -------
    Thing

    Raises
    ------
    InputError
        For a name that is none, a value out of range or no law.

    Examples
    --------
    >>> import grazing as gz
    >>> gz.arc("dome", (3, 7), 3.0, 0.0, 3.14, gz.newton(0.9))
    arc('dome', x=3, y=7, radius=3, start=0, stop=3.14, newton(r=0.9))
    """
    x, y = point_of(centre, name, "centre")
    return Thing(name, ARC, {"x": x, "y": y, "radius": radius, "start": start, "stop": stop}, law)


def flipper(
    name: str, pivot: Sequence[float], length: float, radius: float | Sequence[float], rest: float, raised: float,
    law: Reset, *, up: float, down: float,
) -> Thing:  # fmt: skip
    """Return a flipper, a rigid body that turns about a pivot when its button is pressed, for :func:`grazing.table`.

    It is what two discs cover, one at the pivot and one at the tip, with all between them. It turns with the angular
    speed ``up`` until it is raised while its button is pressed, else with ``down`` until it is at rest, and stops there
    at once; the ball does not slow it down. The law acts on the velocity along the normal relative to the surface's.

    Parameters
    ----------
    name : str
        Stands in words, and in front of the parameters: ``name.x``, ``name.y``, ``name.length``, ``name.hub``,
        ``name.tip``, ``name.rest``, ``name.raised``, ``name.up``, ``name.down``, and those of the law.
    pivot : (x, y)
    length : float
        From the pivot to the centre of the tip, > 0.
    radius : float or (float, float)
        Of both ends, or of the hub at the pivot and of the tip; > 0.
    rest, raised : float
        Angles from the x axis in radians, at most half a turn apart.
    law : Reset
        As in :func:`grazing.disc`.
    up, down : float
        Angular speeds, > 0, in radians per unit of time.

    Returns
    -------
    Thing

    Raises
    ------
    InputError
        For a name that is none, a value out of range or no law.

    Examples
    --------
    >>> import grazing as gz
    >>> gz.flipper("left", (1, 1), 1.5, (0.2, 0.1), -0.5, 0.5, gz.newton(0.8), up=14, down=8)
    flipper('left', x=1, y=1, length=1.5, hub=0.2, tip=0.1, rest=-0.5, raised=0.5, up=14, down=8, newton(r=0.8))
    """
    x, y = point_of(pivot, name, "pivot")
    both = two_of(radius)
    hub, tip = both if len(both) == 2 else (radius, radius)
    shape: dict[str, Any] = {"x": x, "y": y, "length": length, "hub": hub, "tip": tip}
    return Thing(name, FLIPPER, {**shape, "rest": rest, "raised": raised, "up": up, "down": down}, law)


def drain(name: str, start: Sequence[float], stop: Sequence[float]) -> Thing:
    """Return a line through which the ball escapes, a drain or any other exit, for :func:`grazing.table`.

    The ball has left where its centre crosses the line, from either side.

    Parameters
    ----------
    name : str
        Stands in words, and in front of the parameters ``name.x1``, ``name.y1``, ``name.x2``, ``name.y2``.
    start, stop : (x, y)

    Returns
    -------
    Thing

    Raises
    ------
    InputError
        For a name that is none, or two equal ends.

    Examples
    --------
    >>> import grazing as gz
    >>> gz.drain("out", (2, 0), (4, 0))
    drain('out', x1=2, y1=0, x2=4, y2=0)
    """
    return Thing(name, DRAIN, _ends(name, start, stop))
