"""The pinball table: a ball on a tilted plane among objects that stand or turn, and drains through which it leaves."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from math import inf, pi
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from grazing.billiard.distance import SLACK, crosses, distance, room_of
from grazing.billiard.flippers import tightest
from grazing.billiard.flown import table_trajectory
from grazing.billiard.gaps import DEEP, EPS, GAP
from grazing.billiard.laws import addresses, strategy_address
from grazing.billiard.march import LEAST, MOST
from grazing.billiard.objects import ARC, DISC, DRAIN, FLIPPER, SEGMENT, Thing
from grazing.billiard.outline import Outline, outline_of
from grazing.billiard.players import NOBODY, Flips, Presses, angle_at
from grazing.billiard.plunger import KNOWN, Plunger
from grazing.billiard.rows import HEAD, LAW, ROW, SLOPE, THING, block_of, gravity_of, surfaces_of
from grazing.billiard.strategy import Player, Strategy
from grazing.copies import ByValue
from grazing.kernel.content import identity
from grazing.outcome import InputError, abridged, listed, shown
from grazing.parameter import Parameter, checked_params, checked_text, unknown, updated

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]
RHO = Parameter("rho", r"\rho", "radius of the ball", 0.0)
G = Parameter("g", "g", "acceleration of gravity", 0.0)
TILT = Parameter("tilt", r"\theta", "angle by which the table is tilted, 0 for none", 0.0, 0.5 * pi)
OWN = {one.name: one for one in (RHO, G, TILT)}
COORDINATES = ("x", "y", "vx", "vy")
#: What a ball does that leaves for good without meeting anything: no object can be called so.
AWAY = "away"
#: Objects of a table, and flippers among them: each is held against every other.
MOST_OBJECTS, MOST_FLIPPERS = 2_000, 20


@dataclass(frozen=True, eq=False)
class Table(ByValue):
    """A ball on a table; made by :func:`table`.

    Parameters
    ----------
    objects : sequence of Thing
        Of :func:`grazing.disc`, :func:`grazing.segment`, :func:`grazing.arc`, :func:`grazing.flipper` and
        :func:`grazing.drain`.
    rho, g, tilt : float
    player : Player
    plunger : Plunger or None
        See :func:`table`.
    """

    objects: Sequence[Thing]
    rho: float
    g: float
    tilt: float
    player: Player = NOBODY
    plunger: Plunger | None = None
    params: Mapping[str, float] = field(init=False, repr=False, compare=False)
    #: What says of it what certificates do.
    certified_as: ClassVar[str] = "grazing.proof.same_model:of_table"

    def __post_init__(self) -> None:
        objects = tuple(self.objects) if isinstance(self.objects, (list, tuple)) else ()
        if not objects or not all(isinstance(one, Thing) for one in objects):
            raise InputError(
                f"objects are {shown(self.objects)}; give a list of gz.disc, gz.segment, gz.arc, gz.flipper, gz.drain"
            )
        turning = sum(one.kind == FLIPPER for one in objects)
        refuse_too_many(len(objects), turning)
        names = [one.name for one in objects]
        for name in names:
            if names.count(name) > 1:
                raise InputError(f"two objects are called {shown(name)}; give each a name of its own")
            if name in (*OWN, AWAY):
                raise InputError(f"an object is called {name!r}, which means something else; give it another name")
        object.__setattr__(self, "objects", objects)
        for name, known in OWN.items():
            object.__setattr__(self, name, known.check(getattr(self, name)))
        if not isinstance(self.player, Player):
            raise InputError(f"player is {shown(self.player)}; give gz.flips, gz.presses or gz.strategy")
        if self.player != NOBODY and not any(one.kind == FLIPPER for one in objects):
            raise InputError("there is a player, but the table has no flipper; put a gz.flipper on it")
        object.__setattr__(self, "player", self.player.bound([one.name for one in objects if one.kind == FLIPPER]))
        for gate in self.player.drains:
            if gate.name in names:
                raise InputError(f"an object is called {gate.name!r}, as a gate of the strategy is; rename it")
        params = {name: getattr(self, name) for name in OWN}
        for one in objects:
            params |= {f"{one.name}.{name}": value for name, value in one.params.items()}
        for name, value in self.player.params.items():
            if name in params:
                raise InputError(f"{name} is a parameter of the player; rename that of the law")
            params[name] = value
        if not (self.plunger is None or isinstance(self.plunger, Plunger)):
            raise InputError(f"plunger is {shown(self.plunger)}; give gz.plunger((x, y), angle, slow, fast)")
        for name, value in self.plunger.params.items() if self.plunger else ():
            if name in params:
                raise InputError(f"{name} is a parameter of the plunger; rename the object")
            params[name] = value
        _refuse_same_in_code(checked_params(params))
        object.__setattr__(self, "params", MappingProxyType(params))
        self._refuse_out_of_range()
        self._refuse_ball_of_rounding()
        self._refuse_overlaps()
        self.angles(0.0)  # a motion that is none is refused
        self._refuse_stopped_flippers()
        if self.plunger:
            self.refuse_inside(self.plunger.x, self.plunger.y)

    def __reduce__(self) -> Any:
        return Table, (self.objects, self.rho, self.g, self.tilt, self.player, self.plunger)

    def __repr__(self) -> str:
        own = ", ".join(f"{name}={getattr(self, name):g}" for name in OWN)
        return f"<Table {listed(map(abridged, self.names))}; {own}>"

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the objects."""
        return tuple(one.name for one in self.objects)

    @property
    def gravity(self) -> float:
        """What pulls the ball down the table, along -y: g sin(tilt)."""
        return gravity_of(self.g, self.tilt)

    @property
    def period(self) -> float:
        """The period of its flippers, 0 if they do not move, or infinity if what they do is not repeated."""
        if isinstance(self.player, Flips):
            return self.player.period
        return inf if self.player.times or self.player.drains else 0.0

    @property
    def config(self) -> dict[str, str]:
        """What decides a result beside the parameters: reset laws of one's own, by content, and a recording."""
        laws = [one.law for one in self.objects if one.law is not None and one.law.own]
        own = ", ".join(f"{law.name} {identity(law.law)[:16]}" for law in laws)
        recorded = self.player.times if isinstance(self.player, Presses) else {}
        asked = {"strategy": self.player.config} if isinstance(self.player, Strategy) else {}
        return ({"law": own} if own else {}) | ({"presses": repr(dict(recorded))} if recorded else {}) | asked

    def replace(self, **changes: float) -> Table:
        """Return the table with other parameter values; names as in :attr:`params`.

        Dots cannot stand in keywords: ``table.replace(**{"bumper1.V": 0.5})``.
        """
        new = updated(self.params, changes, "the table")
        for name in changes:
            new[name] = self.describe(name).check(new[name])
        return self.at(new)

    def at(self, params: Mapping[str, float]) -> Table:
        """Return the table at values of all its parameters."""
        objects = [one.replaced({name: params[f"{one.name}.{name}"] for name in one.params}) for one in self.objects]
        rho, g, tilt = (params[name] for name in OWN)
        return Table(objects, rho, g, tilt, self.player.at(params), self.plunger and Plunger.at(params))

    def describe(self, name: str) -> Parameter:
        """Return what is known of a parameter."""
        if checked_text(name) in OWN or (self.plunger and name in KNOWN):
            return (OWN | KNOWN)[name]
        front, _dot, last = name.partition(".")
        for one in self.objects:
            known = one.describe(last) if one.name == front else None
            if known is not None:
                return known
        if (known := self.player.describe(name)) is not None:
            return known
        raise unknown(name, self.params, "the table")

    def blocks(
        self, rows: Floats, arithmetic: str = "strict", player: Player | None = None, asks: bool = False
    ) -> Floats:
        """Return the numbers that kernels get, one block in a row for each row of parameters.

        Gates of a strategy stand in it as drains behind all objects; ``player`` is what it has done so far. Where a
        kernel asks the strategy itself, that is compiled.

        ``rows`` (columns, parameters) are values in the order of :attr:`params`. A block points into itself: it must
        live as long as it is used.
        """
        names, n, gates = list(self.params), len(self.objects), self.player.drains
        fixed = {f"{gate.name}.{name}": value for gate in gates for name, value in gate.shape.items()}
        found = []
        for row in rows:
            values = dict(zip(names, row.tolist(), strict=True)) | fixed
            things = (*self.objects, *gates)
            surfaces = surfaces_of(things, values["rho"], values, self.player if player is None else player)
            block = block_of(things, surfaces, gravity_of(values["g"], values["tilt"]), len(gates))
            if isinstance(self.player, Strategy):
                block = np.concatenate([block, self.player.rows(things, values)])
            found.append(np.concatenate([block, row, [0.0]]))  # a law without parameters looks at the last number
        first = np.array([names.index(f"{one.name}.{next(iter(one.params))}") + len(one.shape) for one in self.objects])
        laws = np.array([addresses(one.law, arithmetic) for one in self.objects])
        blocks = padded(found)
        for block, own in zip(blocks, found, strict=True):
            objects = block[HEAD : HEAD + THING * n].reshape(n, THING)
            objects[:, LAW], objects[:, SLOPE] = laws.T
            params = block.ctypes.data + block.itemsize * (len(own) - 1 - len(names))
            objects[:, ROW] = params + block.itemsize * first
            if asks and isinstance(self.player, Strategy):
                of_gates = block[HEAD + THING * n : HEAD + THING * (n + len(gates))].reshape(-1, THING)
                of_gates[:, LAW], of_gates[:, ROW] = strategy_address(self.player, tuple(names), arithmetic), params
        return blocks

    def row(self) -> Floats:
        """Return the values of all parameters."""
        return np.array([list(self.params.values())])

    @property
    def autonomous(self) -> bool:
        """Whether nothing depends on time: there is no flipper."""
        return not any(one.kind == FLIPPER for one in self.objects)

    def trajectory(self, state: ArrayLike, start: float, until: float, samples: int) -> xr.Dataset:
        """Follow the ball in continuous time; :func:`grazing.trajectory` calls this."""
        return table_trajectory(self, state, start, until, samples)

    def outlines(self, t: float = 0.0) -> tuple[Outline, ...]:
        """Return the objects as figures show them at a time."""
        angles = self.angles(t)
        return tuple(outline_of(one, angles.get(one.name, 0.0)) for one in self.objects)

    def angles(self, t: float) -> dict[str, float]:
        """Return the angle of each flipper at a time."""
        found = {}
        for one in self.objects:
            if one.kind == FLIPPER:
                found[one.name] = angle_at(t, *self.player.motion(one.name, one.shape, self.params))
        return found

    def distances(self, x: float, y: float, t: float = 0.0) -> dict[str, float]:
        """Return how far the ball's centre is from each object at a time; negative inside a disc."""
        angles = self.angles(t)
        return {one.name: distance(one, x, y, angles.get(one.name, 0.0)) for one in self.objects}

    def overlap(self, x: float, y: float, t: float = 0.0) -> tuple[float, str]:
        """Return by how much a ball at a place overlaps an object at a time, and which: 0 for none beyond rounding."""
        found, now = (0.0, ""), self.distances(x, y, t)
        for one in self.objects:
            room, size = now[one.name] - self.rho, max(map(abs, one.lengths))
            if one.kind != DRAIN and room < -SLACK * (size + self.rho + abs(x) + abs(y)):
                found = max(found, (-room, one.name))
        return found

    def refuse_inside(self, x: float, y: float, t: float = 0.0) -> None:
        """Raise InputError for a ball that overlaps an object at a time."""
        deep, name = self.overlap(x, y, t)
        if deep > 0.0:
            raise InputError(
                f"a ball of radius {self.rho:g} at ({x:g}, {y:g}) overlaps {name} by {deep:g}; start where it is free"
            )

    def _refuse_out_of_range(self) -> None:
        lengths = [abs(x) for one in self.objects for x in one.lengths]
        radii = [self.rho, *(one.shape.get(name, 0.0) for one in self.objects for name in ("radius", "hub", "tip"))]
        speeds = [max(one.shape[way] for way in ("up", "down")) for one in self.objects if one.kind == FLIPPER]
        sizes = (
            ("the largest length", max(self.rho, *lengths)),
            ("the smallest radius", min(filter(None, radii), default=0.0)),
            ("the largest angular speed", max(speeds, default=0.0)),
        )
        for what, size in (*sizes, ("g sin(tilt)", self.gravity)):
            if size != 0.0 and not LEAST <= size <= MOST:
                raise InputError(
                    f"{what} of the table is {size:g}; allowed are {LEAST:g} to {MOST:g}: choose other units, as "
                    "fourth powers of it have no place in double precision"
                )

    def _refuse_ball_of_rounding(self) -> None:
        largest = max(abs(x) for one in self.objects for x in one.lengths)
        least = DEEP * GAP * EPS * 4.0 * largest  # so far behind a surface it may be: the coordinates of both
        if 0.0 < self.rho < least:
            raise InputError(
                f"rho = {self.rho:g}: a ball so small is not told from rounding on a table with lengths up to "
                f"{largest:g}; give 0 or at least {1.05 * least:.2g}"
            )

    def _refuse_stopped_flippers(self) -> None:
        for one in self.objects:
            for other in self.objects if one.kind == FLIPPER else ():
                if other.kind in (DISC, SEGMENT, ARC):
                    slack = SLACK * max(map(abs, (*one.lengths, *other.lengths)))
                    room = tightest(one.shape, partial(room_of, one, other), slack)
                    if room < -slack:
                        raise InputError(
                            f"{other.name} is in the way of {one.name}, by {-room:g} somewhere on its way; "
                            "objects may touch: move one, or make it smaller"
                        )

    def _refuse_overlaps(self) -> None:
        discs = [one for one in self.objects if one.kind == DISC]
        others = [one for one in self.objects if one.kind in (SEGMENT, ARC)]
        for i, one in enumerate(discs):
            x, y, radius = one.shape.values()
            for other in [*discs[:i], *others]:
                room = distance(other, x, y) - radius
                if room < -SLACK * (radius + abs(x) + abs(y)):
                    raise InputError(
                        f"{other.name} and {one.name} overlap by {-room:g}; objects may touch: move one, or make it "
                        "smaller"
                    )
        lines = [one for one in others if one.kind == SEGMENT or self.rho == 0.0]
        for i, one in enumerate(lines):
            for other in lines[:i]:
                if crosses(one, other):
                    bare = ", as the ball has no radius" if ARC in (one.kind, other.kind) else ""
                    raise InputError(f"{other.name} and {one.name} cross; let one end at the other{bare}")


def refuse_too_many(objects: int, flippers: int) -> None:
    """Raise InputError for more objects, or flippers among them, than a table may have."""
    if objects > MOST_OBJECTS or flippers > MOST_FLIPPERS:
        raise InputError(
            f"the table has {objects} objects, {flippers} of them flippers; allowed are {MOST_OBJECTS}, and "
            f"{MOST_FLIPPERS} flippers, as each is held against every other"
        )


def padded(blocks: Sequence[Floats]) -> Floats:
    """Return blocks as rows of one array: a table may have fewer surfaces at some parameters."""
    found = np.zeros((len(blocks), max(map(len, blocks), default=0)))
    for row, block in zip(found, blocks, strict=True):
        row[: len(block)] = block
    return found


def _refuse_same_in_code(params: Mapping[str, float]) -> None:
    seen: dict[str, str] = {}
    for name in params:
        code = name.replace(".", "_")
        if code in seen:
            raise InputError(
                f"the parameters {seen[code]!r} and {name!r} are the same in code, {code}; rename an object"
            )
        seen[code] = name


def table(
    objects: Sequence[Thing], rho: float = 0.0, g: float = 1.0, tilt: float = 0.0, player: Player = NOBODY,
    plunger: Plunger | None = None,
) -> Table:  # fmt: skip
    """Return a pinball table: a ball on a plane, and what it hits.

    The ball flies freely, in a straight line on a level table and in a parabola, x'' = 0, y'' = -g sin(tilt), on one
    that is tilted. Where it touches an object, the law of that acts on its velocity along the normal; the rest of it
    stays as it is. There is no friction and no drag, and the ball does not spin.

    Parameters
    ----------
    objects : sequence of Thing
        What stands on it: :func:`grazing.disc`, :func:`grazing.segment`, :func:`grazing.arc`, :func:`grazing.flipper`,
        and the lines through which the ball leaves, :func:`grazing.drain`. Of two that are hit at once the first one in
        the list acts first. At most 2000, and 20 flippers.
    rho : float
        Radius of the ball, 0 or more than rounding: at least 1e-12 of the largest length. A ball without a radius never
        meets the ends of segments and arcs.
    g : float
        Acceleration of gravity, >= 0.
    tilt : float
        Angle of the table in radians, from 0 to pi/2.
    player : Player
        Who works the flippers: :func:`grazing.flips`, which makes the table periodic in time, or a recording,
        :func:`grazing.presses`. Default: nobody, they stay at rest.
    plunger : Plunger, optional
        Where balls are launched: :func:`grazing.plunger`.

    Returns
    -------
    Table
        Frozen; ``params`` are ``rho``, ``g``, ``tilt`` and those of the objects, as ``bumper1.V``, of the player and
        of the plunger; ``replace`` changes them.

    Raises
    ------
    InputError
        For no objects or too many, names that collide, a value out of range, a disc that overlaps something, or
        segments that cross; so do arcs, to a ball without a radius.

    Examples
    --------
    >>> import grazing as gz
    >>> bumper = gz.disc("bumper", (3, 5), 0.5, gz.active(r=0.9, V=0.4))
    >>> ends = {"left": [(0, 0), (0, 9)], "right": [(6, 0), (6, 9)]}
    >>> walls = [gz.segment(name, *points, gz.newton(0.9)) for name, points in ends.items()]
    >>> T = gz.table([bumper, *walls, gz.drain("out", (0, 0), (6, 0))], rho=0.1, tilt=0.1)
    >>> flown = gz.trajectory(T, (3.2, 8.0, 0.0, 0.0), until=60.0)
    >>> flown.impact_wall.values.tolist(), flown.outcome
    (['bumper', 'right', 'left'], 'escaped')
    """
    return Table(objects, rho, g, tilt, player, plunger)
