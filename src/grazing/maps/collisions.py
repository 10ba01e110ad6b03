"""The map of a pinball table from impact to impact."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache, partial
from math import atan2, hypot, pi, sin, sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grazing.billiard.flown import BEFORE, FLAGS, NEXT, PATH, SURFACE, TIME, block_played, followed, played_flights
from grazing.billiard.flown import OWNER as FLOWN_OWNER
from grazing.billiard.hit import met, place_at, spot_at
from grazing.billiard.objects import ARC, DISC, DRAIN, FLIPPER
from grazing.billiard.players import PERIOD, Presses, angle_at, pieces_of
from grazing.billiard.rows import FROM, LONG, OWNER, surfaces_of
from grazing.billiard.strategy import Strategy
from grazing.billiard.table import AWAY, Table
from grazing.kernel.compile import call, compiled
from grazing.kernel.lanes import abreast_loop
from grazing.kernel.primitives import numbers
from grazing.maps.collide import STEADY, TIMED, Place, all_collided, gone, named, velocity
from grazing.maps.derivative import Derived
from grazing.maps.hits import Names
from grazing.maps.map import Map
from grazing.maps.origin import Origin
from grazing.maps.played import played_by
from grazing.maps.settle import Settled
from grazing.outcome import ESCAPED, FATAL, OK, InputError, shown
from grazing.parameter import Parameter, refuse_late

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
NAN, INFINITY = float("nan"), float("inf")
#: Places around an object at which it is tried whether a ball fits there.
TRIED = 720
COORDINATES = {
    one.name: one
    for one in (
        Parameter("place", "s", "place of the ball's centre around the objects", 0.0),
        Parameter("angle", r"\varphi", "angle of the velocity from the normal"),
        Parameter("speed", "v", "speed", 0.0),
    )
}
#: The fourth coordinate of a table whose flippers are worked periodically.
PHASE = Parameter("phase", "t", "time, less whole periods", 0.0)


@lru_cache(maxsize=1)
def placer() -> Callable[..., float]:
    """Compile ``start(block, state, clock, found) -> surface``: place and velocity of a ball in a state of the map."""

    def start(block: Any, state: Any, clock: float, found: Any) -> Any:
        surface, x, y, frame = spot_at(state[0], clock, numbers(block))
        found[0], found[1] = x, y
        found[2], found[3] = velocity(frame[0], frame[1], state[1], state[2])
        return 1.0 * surface

    return compiled(start)


def plain_block(table: Table, values: Any) -> Floats:
    """Return the block of a table, at values of its parameters, whose laws are called in plain Python."""
    blocks = table.blocks(np.array([list(values)]), "python", asks=True)
    return np.asarray(blocks[0])


def blocks_of(table: Table, rows: Floats, arithmetic: str) -> tuple[Floats, Floats]:
    """Return the addresses of a table's blocks at rows of parameters, shape (columns, 1), and the blocks.

    Equal rows, of orbits at the same parameters, share a block.
    """
    known: dict[bytes, int] = {}
    which = [known.setdefault(row.tobytes(), len(known)) for row in np.ascontiguousarray(rows)]
    blocks = table.blocks(np.array([np.frombuffer(row) for row in known]), arithmetic, asks=True)
    return blocks.ctypes.data + blocks.strides[0] * np.array(which, float)[:, None], blocks


def asked_of(table: Table) -> str:
    """Return which functions of the user's a step on a table may call."""
    return "the strategy or a reset law" if table.player.drains else "a reset law"


def ways_out(table: Table) -> list[int]:
    """Return the numbers of the objects through which a ball leaves, and that of *away*."""
    return [number for number, one in enumerate(table.objects) if one.kind == DRAIN] + [len(table.objects)]


class OfTable(Origin):
    """The origin of the map of a table from impact to impact."""

    stirred = ("angle",)
    starts_only = True
    finder = "grazing.orbits.search_bounces:Bounced"

    def __init__(self, table: Table, on: str) -> None:
        self.table, self.impacts_on, self.on = table, table, on
        self.exact = all(one.law is None or one.law.exact_slope for one in table.objects)
        self.asks = asked_of(table)

    @property
    def config(self) -> dict[str, str]:
        """What decides a result beside the map's name, coordinates and parameters."""
        return self.table.config

    def replace(self, params: Mapping[str, float]) -> Map:
        """Make the map at other values."""
        return collision_map(self.table.replace(**params), self.on)

    def derivative(self, rows: Floats, arithmetic: str = "strict") -> Derived:
        """Return the derivative of the step, compiled once for all tables."""
        addresses, blocks = blocks_of(self.table, rows, arithmetic)
        if self.table.player.drains:
            played = played_by(len(self.table.player.drains))
            return Derived(played.tangent, None, Place, addresses, blocks, played.step)
        found = TIMED if self.table.period else STEADY
        loop = compiled(abreast_loop(all_collided, 4 if self.table.period else 3), arithmetic)
        return Derived(found.tangent, None, Place, addresses, blocks, found.step, loop)

    def describe(self, name: str) -> Parameter | None:
        """Return what is known of a parameter or coordinate."""
        known = {PHASE.name: PHASE, **COORDINATES, **watched(self.table)}
        return known.get(name) or self.table.describe(name)

    def refuse_late(self, state: Sequence[float], params: Mapping[str, float]) -> None:
        """Raise InputError for a phase so late that a double has none."""
        if PERIOD.name in params:
            refuse_late(state[3], PHASE.name, params[PERIOD.name])

    def check(self, state: Sequence[float], params: Mapping[str, float]) -> None:
        """Raise InputError for a phase that is too late."""
        self.refuse_late(state, params)

    def boxes(self, rows: Floats) -> Floats:
        """Return where starts are drawn: on one object, in all directions away from it."""
        names = list(self.table.params)
        return np.array([box_of(self.table, self.on, dict(zip(names, row, strict=True))) for row in rows.tolist()])

    def left(self, letters: Ints) -> NDArray[np.bool_]:
        """Return which steps end with a ball that has left: down a drain, or away."""
        return np.isin(letters, ways_out(self.table))

    def settle(self, row: list[float], state: tuple[float, ...]) -> Settled | None:
        """Decide a step in exact arithmetic."""
        if isinstance(self.table.player, Strategy):
            return settled(self.table.at(dict(zip(self.table.params, row, strict=True))), state)
        block, start = self.table.blocks(np.array([row]))[0], np.empty(4)
        clock, flags, going = state[3] if self.table.period else 0.0, OK, True
        left = float(call(placer(), block, np.array(state), clock, start))
        if left < 0.0:
            return None
        now = np.array([clock, left, *start])
        while going:
            (flight,), going = followed(block, now, INFINITY, 1)
            flags |= int(flight[FLAGS])
            if not np.isnan(flight[BEFORE]):
                break
        owner, surface = int(flight[FLOWN_OWNER]), int(flight[SURFACE])
        if flags & FATAL:
            return None
        if flags & ESCAPED:
            away, way = gone(owner, block)
            return Settled((*away, 0.0) if self.table.period else away, way, flags, INFINITY, INFINITY)
        if not going:
            return None
        t, (x, y, vx, vy) = float(now[0]), flight[NEXT:PATH].tolist()
        _owner, _x, _y, (nx, ny, *_rest) = met(surface, x, y, 0.0, t, block)
        away, along = vx * nx + vy * ny, vy * nx - vx * ny
        new: tuple[float, ...]
        new = float(place_at(surface, x, y, 0.0, t, block)), atan2(along, away), hypot(along, away)
        flags = named(flags, float(flight[BEFORE]), new[2])
        if self.table.period:
            new = *new, t % self.table.period
        return Settled(new, owner, flags, INFINITY, INFINITY)


def settled(table: Table, state: tuple[float, ...]) -> Settled | None:
    """Decide a step of a table that a strategy plays in exact arithmetic."""
    player, start = table.player, np.empty(4)
    assert isinstance(player, Strategy)
    shapes = {one.name: one.shape for one in table.objects}
    pressed = player.pressed_before(state[3:], shapes)
    left = float(call(placer(), block_played(table, pressed), np.array(state), 0.0, start))
    if left < 0.0:
        return None
    flights, pressed = played_flights(table, tuple(start.tolist()), 0.0, INFINITY, TRIED, left, pressed, once=True)
    flags, last = int(np.bitwise_or.reduce(flights[:, FLAGS].astype(int))), flights[-1]
    owner, surface, block = int(last[FLOWN_OWNER]), int(last[SURFACE]), block_played(table, pressed)
    if flags & ESCAPED and not flags & FATAL:
        away, way = gone(owner, block)
        return Settled((away[0], *(0.0,) * (len(state) - 1)), way, flags, INFINITY, INFINITY)
    if flags & FATAL or np.isnan(last[BEFORE]):
        return None
    t, (x, y, vx, vy) = float(flights[:, TIME].sum()), last[NEXT:PATH].tolist()
    _owner, _x, _y, (nx, ny, *_rest) = met(surface, x, y, 0.0, t, block)
    away, along = vx * nx + vy * ny, vy * nx - vx * ny
    new = [float(place_at(surface, x, y, 0.0, t, block)), atan2(along, away), hypot(along, away)]
    flags = named(flags, float(last[BEFORE]), new[2])
    for name in player.gates:
        times = pressed.get(name, [])
        turned = abs(angle_at(t, 0.0, pieces_of(shapes[name], times)) - shapes[name]["rest"])
        new += [turned, max(times[-1] - t, 0.0) if times else 0.0]
    return Settled(tuple(new), owner, flags, INFINITY, INFINITY)


def places_on(table: Table, name: str, params: Mapping[str, float]) -> tuple[float, float]:
    """Return from where to where the places on an object go: all around it, or the left or inner side of a line."""
    surfaces = surfaces_of(table.objects, params["rho"], params)
    owner = table.names.index(name)
    if table.objects[owner].kind == FLIPPER:
        row = next(row for row in surfaces.flippers if row[OWNER] == owner)
        return float(row[FROM]), float(row[FROM] + row[LONG])
    rows = [row for kind in surfaces[:3] for row in kind if row[OWNER] == owner and row[LONG] > 0.0]
    if not rows:
        raise InputError(f"a ball without a radius never meets {name}, a pin; give one of them a radius")
    row = rows[-1] if table.objects[owner].kind == ARC else rows[0]
    return float(row[FROM]), float(row[FROM] + row[LONG])


def box_of(table: Table, on: str, params: Mapping[str, float]) -> tuple[tuple[float, float], ...]:
    """Return where starts are drawn: on an object, away from it, up to as fast as a fall over the table, or 1."""
    fast = fastest(params)
    found = places_on(table, on, params), (-0.5 * pi, 0.5 * pi), (0.1 * fast, fast)
    if isinstance(table.player, Strategy):
        strokes = (abs(params[f"{name}.raised"] - params[f"{name}.rest"]) for name in table.player.gates)
        return (*found, *(span for stroke in strokes for span in ((0.0, stroke), (0.0, table.player.hold))))
    return (*found, (0.0, params[PERIOD.name])) if table.period else found


def watched(table: Table) -> dict[str, Parameter]:
    """Return the coordinates of flippers that a strategy works."""
    found = {}
    for name in table.player.gates if isinstance(table.player, Strategy) else ():
        of, mark = f" of {name}", rf"^\mathrm{{{name}}}".replace("_", r"\_")
        found[f"{name}.turned"] = Parameter(f"{name}.turned", rf"\beta{mark}", f"angle from rest{of}", 0.0)
        found[f"{name}.held"] = Parameter(f"{name}.held", f"h{mark}", f"for how long the button stays pressed{of}", 0.0)
    return found


def fastest(params: Mapping[str, float]) -> float:
    """Return how fast a ball is that falls over the whole table, 1 on a level one."""
    heights = [value for name, value in params.items() if name.rpartition(".")[2] in ("y", "y1", "y2")]
    return sqrt(2.0 * params["g"] * sin(params["tilt"]) * (max(heights) - min(heights))) or 1.0


def checked_table(table: object) -> Table:
    """Return a table, or raise InputError."""
    if not isinstance(table, Table):
        raise InputError(f"table is {shown(table)}; give gz.table([...])")
    return table


def collision_map(table: Table, on: str | None = None) -> Map:
    """Return the map of a pinball table from impact to impact.

    Parameters
    ----------
    table : Table
        Of :func:`grazing.table`.
    on : str, optional
        The object on which random starts are drawn: all around a disc, on the left side of a segment or the inner side
        of an arc. Default: the first one that is hit.

    Returns
    -------
    Map
        State (place, angle, speed) just after an impact: the place of the ball's centre, as a length, counterclockwise
        around one object after the other; the angle of the velocity from the normal, counterclockwise, between -pi/2
        and pi/2; the speed. Letters are the names of the objects, in parentheses where longer than one character. A
        ball that has left stays at a place of its own behind all others, one for each drain and one for *away*, with
        outcome *escaped*: so ways out are attractors, and have basins. Other places that are on no object have no next
        state. Where flippers are worked periodically, the phase is a fourth coordinate: the time, less whole periods.
        Where a strategy works them, each gate adds two, ``L.turned``, how far its flipper has turned from rest, and
        ``L.held``, for how long its button stays pressed. Parameters are those of the table.

    Raises
    ------
    InputError
        For anything but a table, one whose flippers are worked by a recording, an unknown object, or one at which a
        ball of its radius fits nowhere.

    Examples
    --------
    >>> import grazing as gz
    >>> discs = [gz.disc(name, xy, 1.0, gz.newton(1.0)) for name, xy in (("A", (0, 0)), ("B", (6, 0)), ("C", (3, 5.2)))]
    >>> P = gz.collision_map(gz.table(discs))
    >>> state, letter = P((3.141592653589793, 0.0, 1.0))
    >>> P.letters.symbol(letter), abs(state).round(6).tolist()
    ('B', [6.283185, 0.0, 1.0])
    """
    table = checked_table(table)
    if isinstance(table.player, Presses) and table.player.times:
        raise InputError(
            "the flippers of the table are worked by a recording, which does not repeat: gz.trajectory and gz.launches "
            "follow that; a map needs gz.flips(period, hold), a strategy, or no player"
        )
    pins = [one.name for one in table.objects if one.kind == DISC and one.shape["radius"] + table.rho == 0.0]
    solids = [one.name for one in table.objects if one.kind != DRAIN and one.name not in pins]
    if not solids:
        only = "drains and pins that a ball without a radius never meets" if pins else "drains only"
        raise InputError(f"the table has {only}; a map from impact to impact needs something that is hit")
    if isinstance(on, str) and on in pins:
        raise InputError(f"on is {on!r}: a ball without a radius never meets it; allowed are {', '.join(solids)}")
    if on is not None and not (isinstance(on, str) and on in solids):
        raise InputError(f"on is {shown(on)}; allowed are {', '.join(solids)}")
    on = solids[0] if on is None else on
    low, high = places_on(table, on, table.params)
    block = table.blocks(table.row(), "python")[0]
    for i in range(TRIED):
        _surface, x, y, _frame = spot_at(low + (high - low) * (i + 0.5) / TRIED, 0.0, block)
        if table.overlap(x, y)[0] == 0.0:
            break
    else:
        raise InputError(
            f"a ball of radius {table.rho:g} fits nowhere beside {on}: something else is nearer than its diameter "
            "everywhere; make rho smaller, or give another object as on="
        )
    kernels, more = STEADY, list(watched(table))
    if isinstance(table.player, Strategy):
        table.player.tried(table.params)
        kernels = played_by(len(table.player.gates))
    elif table.period:
        kernels, more = TIMED, [PHASE.name]
    return Map(
        kernels.plain,
        params=table.params,
        coordinates=(*COORDINATES, *more),
        box=box_of(table, on, table.params),
        letters=Names((*table.names, AWAY)),
        prepare=partial(plain_block, table),
        tangent=kernels.plain_tangent,
        name="collision map",
        origin=OfTable(table, on),
    )
