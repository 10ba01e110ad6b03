"""The map of a pinball table from impact to impact."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import lru_cache, partial
from math import atan2, cos, hypot, pi, sin, sqrt
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from grazing.billiard.contact import next_impact
from grazing.billiard.flown import BEFORE, FLAGS, NEXT, PATH, SURFACE, followed
from grazing.billiard.flown import OWNER as FLOWN_OWNER
from grazing.billiard.hit import met, period_of, place_at, slope_of, spot_at, way_at
from grazing.billiard.objects import ARC, DISC, DRAIN, FLIPPER
from grazing.billiard.players import PERIOD
from grazing.billiard.rows import FROM, GRAVITY, LENGTH, LONG, OWNER, THINGS, surfaces_of
from grazing.billiard.table import AWAY, Table
from grazing.kernel.compile import call, compiled
from grazing.kernel.primitives import numbers, numbers_at, replaced
from grazing.maps.derivative import Derived
from grazing.maps.hits import Names
from grazing.maps.map import Map
from grazing.maps.origin import Origin
from grazing.maps.settle import Settled
from grazing.outcome import AMBIGUOUS, DIVERGED, ESCAPED, FATAL, GRAZE, OK, STUCK, InputError, shown
from grazing.parameter import Parameter

Floats = NDArray[np.float64]
NAN, INFINITY = float("nan"), float("inf")
LOST = (NAN,) * 16
NOTHING: tuple[float, ...] = (0.0,) * 16


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


class Place(NamedTuple):
    """What a kernel needs of a table: the address of its block."""

    block: float


def velocity(nx: float, ny: float, angle: float, speed: float) -> Any:
    """Return the velocity of a ball that leaves a surface at an angle from its normal."""
    away, along = speed * cos(angle), speed * sin(angle)
    return away * nx - along * ny, away * ny + along * nx


def gone(way: int, table: Any) -> Any:
    """Return where a ball lies that has left, one place for each way out, and that way."""
    way = way if way >= 0 else int(table[THINGS])
    return (table[LENGTH] + way + 0.5, 0.0, 0.0), way


def collide(state: Any, clock: float, table: Any, with_tangent: bool) -> Any:
    """Return (state, t, letter, outcome, J) of a step from impact to impact, from the time ``clock`` on.

    The state has no phase; J, row by row, is by place, angle, speed and clock.
    """
    place, angle, speed = state
    way = way_at(place - table[LENGTH], table)
    if way >= 0:
        away, way = gone(way, table)
        return away, 0.0, way, ESCAPED, NOTHING
    surface, x, y, frame = spot_at(place, clock, table)
    if surface < 0:
        return (NAN, NAN, NAN), NAN, 0, DIVERGED, LOST
    vx, vy = velocity(frame[0], frame[1], angle, speed)
    (met_at, owner, t, flags, _left), before, after, speeds = next_impact(x, y, vx, vy, 1.0 * surface, clock, table)
    if flags & FATAL:
        return (NAN, NAN, NAN), NAN, 0, flags, LOST
    if flags & ESCAPED:
        away, way = gone(owner, table)
        return away, 0.0, way, flags, NOTHING
    v_minus, v_plus, along, nx, ny, _curvature, _omega, ux, uy = speeds
    out = v_plus + (ux * nx + uy * ny)
    new = place_at(met_at, after[0], after[1], t, clock, table), atan2(along, out), hypot(along, out)
    J = NOTHING
    if with_tangent:
        J = LOST
        if not flags & (GRAZE | AMBIGUOUS | STUCK) and v_minus < 0.0 and new[2] > 0.0:
            bend = slope_of(owner, v_minus, table)
            J = slopes(angle, speed, frame, t, before, speeds, bend, table[GRAVITY])
    return new, t, owner, flags, J


def slopes(angle: float, speed: float, frame: Any, t: float, before: Any, speeds: Any, bend: float, g: float) -> Any:
    """Return the Jacobian of a step, row by row: docs/table.md says how it is derived."""
    nx, ny, curvature, omega, sx, sy = frame
    _px, _py, vx, vy = before
    v_minus, v_plus, along, mx, my, there, spin, ux, uy = speeds
    push, drag = ux * mx + uy * my, uy * mx - ux * my  # the surface's velocity along its normal, and along itself
    out, coming = v_plus + push, v_minus + push
    size2 = out * out + along * along
    wx, wy = velocity(nx, ny, angle, 1.0)
    J = NOTHING
    for j in range(4):
        turned = speed * (curvature if j == 0 else (1.0 if j == 1 else (omega if j == 3 else 0.0)))
        dwx, dwy = -wy * turned, wx * turned
        dx, dy, later = 0.0, 0.0, 0.0
        if j == 0:
            dx, dy = -ny, nx
        elif j == 2:
            dwx, dwy = wx, wy
        elif j == 3:
            dx, dy, later = sx, sy, 1.0
        dx, dy = dx + t * dwx - ux * later, dy + t * dwy - uy * later
        late = -(mx * dx + my * dy) / v_minus
        dwy -= g * late
        shift = -my * (dx + (vx - ux) * late) + mx * (dy + (vy - uy) * late)
        tilt = there * shift + spin * (later + late)
        pushed = (there * drag - spin) * shift
        away = bend * (mx * dwx + my * dwy + tilt * along - pushed) + pushed
        beside = -my * dwx + mx * dwy - tilt * coming
        J = replaced(J, j, shift)
        J = replaced(J, 4 + j, (out * beside - along * away) / size2)
        J = replaced(J, 8 + j, (out * away + along * beside) / sqrt(size2))
        J = replaced(J, 12 + j, later + late)
    return J


def in_three(J: Any) -> Any:
    """Return the part of a Jacobian that has no phase."""
    return J[0], J[1], J[2], J[4], J[5], J[6], J[8], J[9], J[10]


def collision(state: Any, c: Place) -> Any:
    """Return (state, letter, outcome) of a step from impact to impact."""
    new, _t, letter, outcome, _J = collide(state, 0.0, numbers_at(c.block), False)
    return new, letter, outcome


def derived(state: Any, c: Place) -> Any:
    """Return a step with its Jacobian, and nothing that is known of its determinant apart from that."""
    new, _t, letter, outcome, J = collide(state, 0.0, numbers_at(c.block), True)
    return new, letter, outcome, (*in_three(J), NAN)


def plain_collision(state: Any, block: Any) -> Any:
    """Return a step as plain Python takes it: with the block of a table itself, of whatever length."""
    new, _t, letter, outcome, _J = collide(state, 0.0, block, False)
    return new, letter, outcome


def plain_tangent(state: Any, block: Any) -> Any:
    """Return a step with its Jacobian as plain Python takes it."""
    new, _t, letter, outcome, J = collide(state, 0.0, block, True)
    return new, letter, outcome, in_three(J)


def timed(state: Any, table: Any, with_tangent: bool) -> Any:
    """Return (state, letter, outcome, J) of a step of a table that is periodic in time."""
    place, angle, speed, phase = state
    new, t, letter, outcome, J = collide((place, angle, speed), phase, table, with_tangent)
    later = 0.0 if outcome & ESCAPED else (phase + t) % period_of(table)
    return (new[0], new[1], new[2], later), letter, outcome, J


def timed_collision(state: Any, c: Place) -> Any:
    """Return (state, letter, outcome) of a step of a table that is periodic in time."""
    new, letter, outcome, _J = timed(state, numbers_at(c.block), False)
    return new, letter, outcome


def timed_derived(state: Any, c: Place) -> Any:
    """Return such a step with its Jacobian, and nothing that is known of its determinant apart from that."""
    new, letter, outcome, J = timed(state, numbers_at(c.block), True)
    return new, letter, outcome, (*J, NAN)


def plain_timed(state: Any, block: Any) -> Any:
    """Return such a step as plain Python takes it."""
    new, letter, outcome, _J = timed(state, block, False)
    return new, letter, outcome


def plain_timed_tangent(state: Any, block: Any) -> Any:
    """Return such a step with its Jacobian as plain Python takes it."""
    return timed(state, block, True)


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
    blocks = table.blocks(np.array([list(values)]), "python")
    return np.asarray(blocks[0])


def blocks_at(blocks: Floats) -> Floats:
    """Return the addresses of blocks, shape (columns, 1)."""
    return blocks.ctypes.data + blocks.strides[0] * np.arange(len(blocks), dtype=np.float64)[:, None]


class OfTable(Origin):
    """The origin of the map of a table from impact to impact."""

    stirred = ("angle",)
    finder = "grazing.orbits.search_bounces:Bounced"

    def __init__(self, table: Table, on: str) -> None:
        self.table, self.impacts_on, self.on = table, table, on
        self.exact = all(one.law is None or one.law.exact_slope for one in table.objects)

    @property
    def config(self) -> dict[str, str]:
        """What decides a result beside the map's name, coordinates and parameters."""
        return self.table.config

    def replace(self, params: Mapping[str, float]) -> Map:
        """Make the map at other values."""
        return collision_map(self.table.replace(**params), self.on)

    def derivative(self, rows: Floats, arithmetic: str = "strict") -> Derived:
        """Return the derivative of the step, compiled once for all tables."""
        blocks = self.table.blocks(rows, arithmetic)
        tangent, step = (timed_derived, timed_collision) if self.table.period else (derived, collision)
        return Derived(tangent, None, Place, blocks_at(blocks), blocks, step)

    def describe(self, name: str) -> Parameter | None:
        """Return what is known of a parameter or coordinate."""
        return (PHASE if name == PHASE.name else COORDINATES.get(name)) or self.table.describe(name)

    def boxes(self, rows: Floats) -> Floats:
        """Return where starts are drawn: on one object, in all directions away from it."""
        names = list(self.table.params)
        return np.array([box_of(self.table, self.on, dict(zip(names, row, strict=True))) for row in rows.tolist()])

    def settle(self, row: list[float], state: tuple[float, ...]) -> Settled | None:
        """Decide a step in exact arithmetic."""
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
        if self.table.period:
            new = *new, t % self.table.period
        return Settled(new, owner, flags, INFINITY, INFINITY)


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
    return (*found, (0.0, params[PERIOD.name])) if table.period else found


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
        Parameters are those of the table.

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
    if table.period == INFINITY:
        raise InputError(
            "the flippers of the table are worked by a recording, which does not repeat: gz.trajectory and gz.launches "
            "follow that; a map needs gz.flips(period, hold), or no player"
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
    step, tangent = (plain_timed, plain_timed_tangent) if table.period else (plain_collision, plain_tangent)
    return Map(
        step,
        params=table.params,
        coordinates=(*COORDINATES, *([PHASE.name] if table.period else [])),
        box=box_of(table, on, table.params),
        letters=Names((*table.names, AWAY)),
        prepare=partial(plain_block, table),
        tangent=tangent,
        name="collision map",
        origin=OfTable(table, on),
    )
