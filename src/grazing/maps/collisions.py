"""The map of a pinball table from impact to impact."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import lru_cache, partial
from math import atan2, cos, hypot, pi, sin, sqrt
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from grazing.billiard.contact import next_impact
from grazing.billiard.flown import COLUMNS, FLAGS, NEXT, SURFACE, decided
from grazing.billiard.flown import OWNER as FLOWN_OWNER
from grazing.billiard.hit import met, place_of, slope_of, spot, way_at
from grazing.billiard.objects import ARC, DISC, DRAIN
from grazing.billiard.rows import FROM, GRAVITY, LENGTH, LONG, OWNER, THINGS, surfaces_of
from grazing.billiard.table import AWAY, Table
from grazing.kernel.compile import call, compiled
from grazing.kernel.primitives import numbers, numbers_at, replaced
from grazing.maps.derivative import Derived
from grazing.maps.hits import Names
from grazing.maps.map import Map
from grazing.maps.origin import Origin
from grazing.maps.settle import Settled
from grazing.outcome import AMBIGUOUS, DIVERGED, ESCAPED, FATAL, GRAZE, InputError, shown
from grazing.parameter import Parameter

Floats = NDArray[np.float64]
NAN, INFINITY = float("nan"), float("inf")
LOST = (NAN,) * 9
NOTHING: tuple[float, ...] = (0.0,) * 9


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


def collide(state: Any, table: Any, with_tangent: bool) -> Any:
    """Return (state, letter, outcome, J) of a step from impact to impact."""
    place, angle, speed = state
    way = way_at(place - table[LENGTH], table)
    if way >= 0:
        away, way = gone(way, table)
        return away, way, ESCAPED, NOTHING
    surface, x, y, nx, ny, curvature = spot(place, table)
    if surface < 0:
        return (NAN, NAN, NAN), 0, DIVERGED, LOST
    vx, vy = velocity(nx, ny, angle, speed)
    (met_at, owner, t, flags), before, after, speeds = next_impact(x, y, vx, vy, 1.0 * surface, table)
    if flags & FATAL:
        return (NAN, NAN, NAN), 0, flags, LOST
    if flags & ESCAPED:
        away, way = gone(owner, table)
        return away, way, flags, NOTHING
    v_minus, v_plus, along, _curvature, _nx, _ny = speeds
    new = place_of(met_at, after[0], after[1], table), atan2(along, v_plus), hypot(along, v_plus)
    J = NOTHING
    if with_tangent:
        J = LOST
        if not flags & (GRAZE | AMBIGUOUS) and v_minus < 0.0 and new[2] > 0.0:
            bend = slope_of(owner, v_minus, table)
            J = slopes(state, (nx, ny, curvature), t, before, speeds, bend, table[GRAVITY])
    return new, owner, flags, J


def slopes(state: Any, frame: Any, t: float, before: Any, speeds: Any, bend: float, g: float) -> Any:
    """Return the Jacobian of a step, row by row: docs/table.md says how it is derived."""
    _place, angle, speed = state
    nx, ny, curvature = frame
    _px, _py, vx, vy = before
    v_minus, v_plus, along, there, mx, my = speeds
    size2 = v_plus * v_plus + along * along
    J = NOTHING
    for j in range(3):
        dx, dy = (-ny, nx) if j == 0 else (0.0, 0.0)
        turned, of = (0.0, 1.0) if j == 2 else (0.5 * pi, speed * (curvature if j == 0 else 1.0))
        ux, uy = velocity(nx, ny, angle + turned, of)
        dx, dy = dx + t * ux, dy + t * uy
        late = -(mx * dx + my * dy) / v_minus
        uy -= g * late
        shift = -my * (dx + vx * late) + mx * (dy + vy * late)
        away = bend * (mx * ux + my * uy + there * shift * along)
        beside = -my * ux + mx * uy - there * shift * v_minus
        J = replaced(J, j, shift)
        J = replaced(J, 3 + j, (v_plus * beside - along * away) / size2)
        J = replaced(J, 6 + j, (v_plus * away + along * beside) / sqrt(size2))
    return J


def collision(state: Any, c: Place) -> Any:
    """Return (state, letter, outcome) of a step from impact to impact."""
    new, letter, outcome, _J = collide(state, numbers_at(c.block), False)
    return new, letter, outcome


def derived(state: Any, c: Place) -> Any:
    """Return a step with its Jacobian, and nothing that is known of its determinant apart from that."""
    new, letter, outcome, J = collide(state, numbers_at(c.block), True)
    return new, letter, outcome, (*J, NAN)


def plain_collision(state: Any, block: Any) -> Any:
    """Return a step as plain Python takes it: with the block of a table itself, of whatever length."""
    new, letter, outcome, _J = collide(state, block, False)
    return new, letter, outcome


def plain_tangent(state: Any, block: Any) -> Any:
    """Return a step with its Jacobian as plain Python takes it."""
    return collide(state, block, True)


@lru_cache(maxsize=1)
def placer() -> Callable[..., float]:
    """Compile ``start(block, state, found) -> surface``: place and velocity of a ball in a state of the map."""

    def start(block: Any, state: Any, found: Any) -> Any:
        surface, x, y, nx, ny, _curvature = spot(state[0], numbers(block))
        found[0], found[1] = x, y
        found[2], found[3] = velocity(nx, ny, state[1], state[2])
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

    def __init__(self, table: Table, on: str) -> None:
        self.table, self.impacts_on, self.on = table, table, on
        self.exact = all(one.law is None or one.law.exact_slope for one in table.objects)

    def replace(self, params: Mapping[str, float]) -> Map:
        """Make the map at other values."""
        return collision_map(self.table.replace(**params), self.on)

    def derivative(self, rows: Floats, arithmetic: str = "strict") -> Derived:
        """Return the derivative of the step, compiled once for all tables."""
        blocks = self.table.blocks(rows, arithmetic)
        return Derived(derived, None, Place, blocks_at(blocks), blocks, collision)

    def describe(self, name: str) -> Parameter | None:
        """Return what is known of a parameter or coordinate."""
        return COORDINATES.get(name) or self.table.describe(name)

    def boxes(self, rows: Floats) -> Floats:
        """Return where starts are drawn: on one object, in all directions away from it."""
        names = list(self.table.params)
        return np.array([box_of(self.table, self.on, dict(zip(names, row, strict=True))) for row in rows.tolist()])

    def settle(self, row: list[float], state: tuple[float, ...]) -> Settled | None:
        """Decide a step in exact arithmetic."""
        block, start = self.table.blocks(np.array([row]))[0], np.empty(4)
        left = int(call(placer(), block, np.array(state), start))
        flight = decided(block, start, left) if left >= 0 else None
        if flight is None:
            return None
        flags, owner = int(flight[FLAGS]), int(flight[FLOWN_OWNER])
        if flags & ESCAPED:
            away, way = gone(owner, block)
            return Settled(away, way, flags, INFINITY, INFINITY)
        surface, (x, y, vx, vy) = int(flight[SURFACE]), flight[NEXT:COLUMNS].tolist()
        _owner, _x, _y, nx, ny, _curvature = met(surface, x, y, block)
        place = place_of(surface, x, y, block)
        away, along = vx * nx + vy * ny, vy * nx - vx * ny
        return Settled((float(place), atan2(along, away), hypot(along, away)), owner, flags, INFINITY, INFINITY)


def places_on(table: Table, name: str, params: Mapping[str, float]) -> tuple[float, float]:
    """Return from where to where the places on an object go: all around it, or the left or inner side of a line."""
    surfaces = surfaces_of(table.objects, params["rho"], params)
    owner = table.names.index(name)
    rows = [row for kind in surfaces[:3] for row in kind if row[OWNER] == owner and row[LONG] > 0.0]
    if not rows:
        raise InputError(f"a ball without a radius never meets {name}, a pin; give one of them a radius")
    row = rows[-1] if table.objects[owner].kind == ARC else rows[0]
    return float(row[FROM]), float(row[FROM] + row[LONG])


def box_of(table: Table, on: str, params: Mapping[str, float]) -> tuple[tuple[float, float], ...]:
    """Return where starts are drawn: on an object, away from it, up to as fast as a fall over the table, or 1."""
    fast = fastest(params)
    return places_on(table, on, params), (-0.5 * pi, 0.5 * pi), (0.1 * fast, fast)


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
        state. Parameters are those of the table.

    Raises
    ------
    InputError
        For anything but a table, an unknown object, or one at which a ball of its radius fits nowhere.

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
        _surface, x, y, *_rest = spot(low + (high - low) * (i + 0.5) / TRIED, block)
        if table.overlap(x, y)[0] == 0.0:
            break
    else:
        raise InputError(
            f"a ball of radius {table.rho:g} fits nowhere beside {on}: something else is nearer than its diameter "
            "everywhere; make rho smaller, or give another object as on="
        )
    return Map(
        plain_collision,
        params=table.params,
        coordinates=tuple(COORDINATES),
        box=box_of(table, on, table.params),
        letters=Names((*table.names, AWAY)),
        prepare=partial(plain_block, table),
        tangent=plain_tangent,
        name="collision map",
        origin=OfTable(table, on),
    )
