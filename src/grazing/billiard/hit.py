"""An impact: where a ball is when it meets a surface, and what the law of that object makes of its velocity."""

from __future__ import annotations

from math import acos, atan2, cos, pi, sin, sqrt
from typing import Any

from grazing.billiard.flippers import (
    ARM,
    AT,
    AT_TIP,
    FLIPPER_WIDTH,
    KINDS,
    OMEGA,
    PERIOD,
    PIECE_WIDTH,
    ROUND,
    SINE,
    TIP,
)
from grazing.billiard.flippers import RIGHT as RIGHT_FROM
from grazing.billiard.rows import (
    ANGLE,
    CIRCLES,
    EX,
    EY,
    FACES,
    FLIPPERS,
    FROM,
    HEAD,
    LAW,
    LENGTH,
    LONG,
    OPEN,
    OWNER,
    PX,
    PY,
    RIGHT,
    ROW,
    SIDES,
    SIGN,
    SIZE,
    SLOPE,
    THING,
    THINGS,
    WIDTH,
)  # fmt: skip
from grazing.billiard.turning import begin_of, clock_of, direction_at, normal_at, piece_at
from grazing.kernel.primitives import behind, called, inlined

NAN, INFINITY = float("nan"), float("inf")


@inlined
def flown(x: float, y: float, vx: float, vy: float, g: float, t: float) -> Any:
    """Return place and velocity after a free flight."""
    return x + vx * t, y + (vy - 0.5 * g * t) * t, vx, vy - g * t


@inlined
def rows_of(table: Any) -> Any:
    """Return where the rows of a table begin."""
    return behind(table, HEAD + THING * int(table[THINGS]))


@inlined
def first_turning(table: Any) -> int:
    """Return the number of the first surface of a flipper."""
    return 2 * int(table[FACES]) + int(table[CIRCLES]) + int(table[SIDES])


def period_of(table: Any) -> Any:
    """Return the period of the flippers, of which there is one at least."""
    rows = behind(rows_of(table), WIDTH * (int(table[FACES]) + int(table[CIRCLES]) + int(table[SIDES])))
    return rows[PERIOD]


def pose(surface: int, t: float, clock: float, table: Any) -> Any:
    """Return (row, kind, ux, uy, omega) of a surface of a flipper, with its direction and how it turns.

    That is at a time of a flight. The flight begins at the time ``clock``.
    """
    number = surface - first_turning(table)
    rows = behind(rows_of(table), WIDTH * (int(table[FACES]) + int(table[CIRCLES]) + int(table[SIDES])))
    row = behind(rows, FLIPPER_WIDTH * (number // KINDS))
    pieces, phase = behind(rows, int(row[AT])), clock_of(clock, row)
    at, turns = piece_at(t, phase, row, pieces)
    piece = behind(pieces, PIECE_WIDTH * at)
    ux, uy, _turned = direction_at(t, begin_of(at, turns, phase, row, pieces), piece)
    return row, number % KINDS, ux, uy, piece[OMEGA]


def met_turning(surface: int, x: float, y: float, t: float, clock: float, table: Any) -> Any:
    """Return what :func:`met` does, of a flipper."""
    row, kind, ux, uy, omega = pose(surface, t, clock, table)
    dx, dy = x - row[PX], y - row[PY]
    nx, ny = normal_at(kind, ux, uy, row)
    size, curvature = row[SIZE], 0.0
    if kind == AT_TIP:
        dx, dy, size = dx - row[ARM] * ux, dy - row[ARM] * uy, row[TIP]
        far = sqrt(dx * dx + dy * dy)
        nx, ny, curvature = dx / far, dy / far, 1.0 / size
    off = size - (nx * dx + ny * dy)
    px, py = x + off * nx, y + off * ny
    return int(row[OWNER]), px, py, (nx, ny, curvature, omega, -omega * (py - row[PY]), omega * (px - row[PX]))


@inlined
def met(surface: int, x: float, y: float, t: float, clock: float, table: Any) -> Any:
    """Return what a ball at a surface meets: the object, its own place moved onto the surface, and the frame there.

    The frame is (nx, ny, curvature, omega, ux, uy) after a time t of a flight that begins at ``clock``. The normal
    points to the ball; the curvature is that of the ball's way along the surface, negative inside an arc. The surface
    turns with omega, and (ux, uy) is its velocity.
    """
    rows, faces, circles = rows_of(table), int(table[FACES]), int(table[CIRCLES])
    if surface >= first_turning(table):
        return met_turning(surface, x, y, t, clock, table)
    if surface < 2 * faces:
        row, sign = behind(rows, WIDTH * (surface // 2)), 2.0 * (surface % 2) - 1.0
        px, py, frame = at_line(x, y, row[PX], row[PY], row[SIZE], row[EX], row[EY], sign)
        return int(row[OWNER]), px, py, frame
    row = behind(rows, WIDTH * (surface - faces))
    sign = row[SIGN] if surface >= 2 * faces + circles else 1.0
    px, py, frame = at_circle(x, y, row[PX], row[PY], row[SIZE], sign)
    return int(row[OWNER]), px, py, frame


@inlined
def at_line(x: float, y: float, px: float, py: float, size: float, ex: float, ey: float, sign: float) -> Any:
    """Return (x, y, frame) of :func:`met` on a side of a face, its right for sign 1, its left for -1."""
    nx, ny = sign * ey, -sign * ex
    off = size - (nx * (x - px) + ny * (y - py))
    return x + off * nx, y + off * ny, (nx, ny, 0.0, 0.0, 0.0, 0.0)


@inlined
def at_circle(x: float, y: float, px: float, py: float, size: float, sign: float) -> Any:
    """Return (x, y, frame) of :func:`met` on a circle, from outside for sign 1, from inside for -1."""
    dx, dy = x - px, y - py
    far = sqrt(dx * dx + dy * dy)
    ux, uy = dx / far, dy / far
    return px + size * ux, py + size * uy, (sign * ux, sign * uy, sign / size, 0.0, 0.0, 0.0)


@inlined
def coming(vx: float, vy: float, frame: Any) -> Any:
    """Return (v_minus, along, push): velocities along a normal and along a surface, and the surface's own."""
    nx, ny, _curvature, _omega, ux, uy = frame
    push = ux * nx + uy * ny
    return min(vx * nx + vy * ny - push, 0.0), vy * nx - vx * ny, push


@inlined
def going(away: float, along: float, push: float, frame: Any) -> Any:
    """Return the velocity of a ball after an impact, from those that :func:`coming` returns."""
    nx, ny, out = frame[0], frame[1], away + push
    return out * nx - along * ny, out * ny + along * nx


def place_of(surface: int, x: float, y: float, table: Any) -> Any:
    """Return the place of a ball on a surface, as a length, see :mod:`grazing.billiard.rows`."""
    rows, faces, circles = rows_of(table), int(table[FACES]), int(table[CIRCLES])
    if surface < 2 * faces:
        row = behind(rows, WIDTH * (surface // 2))
        foot = row[EX] * (x - row[PX]) + row[EY] * (y - row[PY])
        return row[RIGHT] + foot if surface % 2 == 1 else row[FROM] + row[LONG] - foot
    row = behind(rows, WIDTH * (surface - faces))
    sign, size = row[SIGN] if surface >= 2 * faces + circles else 1.0, row[SIZE]
    turn = sign * (atan2(y - row[PY], x - row[PX]) - row[ANGLE])
    if not 0.0 <= turn < 2.0 * pi:
        turn %= 2.0 * pi
    span = row[LONG] / size
    if turn > span:
        turn = span if turn - span < 2.0 * pi - turn else 0.0
    return row[FROM] + size * turn


def place_at(surface: int, x: float, y: float, t: float, clock: float, table: Any) -> Any:
    """Return the place of a ball on any surface after a time t of a flight that begins at ``clock``."""
    if surface < first_turning(table):
        return place_of(surface, x, y, table)
    row, kind, ux, uy, _omega = pose(surface, t, clock, table)
    nx, ny = normal_at(kind, ux, uy, row)
    dx, dy, size = x - row[PX], y - row[PY], row[TIP]
    if kind == AT_TIP:
        lean = acos(row[SINE])
        dx, dy = dx - row[ARM] * ux, dy - row[ARM] * uy
        turn = atan2(ux * dy - uy * dx, ux * dx + uy * dy)
        return row[ROUND] + size * (min(max(turn, -lean), lean) + lean)
    foot = (1.0 - 2.0 * kind) * (ny * dx - nx * dy)
    return row[RIGHT_FROM] + foot if kind == 1 else row[FROM] + row[LONG] - foot


@inlined
def struck(owner: int, speed: float, table: Any) -> float:
    """Return the velocity along the normal just after an impact with an object, from that just before, speed <= 0."""
    thing = behind(table, HEAD + THING * owner)
    return called(thing[LAW], speed, thing[ROW])


def slope_of(owner: int, speed: float, table: Any) -> float:
    """Return the derivative of :func:`struck` by the speed."""
    thing = behind(table, HEAD + THING * owner)
    return called(thing[SLOPE], speed, thing[ROW])


@inlined
def is_open(owner: int, table: Any) -> Any:
    """Say whether an object is a drain."""
    return table[HEAD + THING * owner + OPEN] > 0.0


@inlined
def away_of(table: Any) -> Any:
    """Return how many objects there are, the number of *away* too: gates, behind them, are none."""
    things = int(table[THINGS])
    while things > 0 and table[HEAD + THING * (things - 1) + OPEN] > 1.0:
        things -= 1
    return things


def way_at(number: float, table: Any) -> int:
    """Return the way out of a number, a drain or, behind all objects, *away*; -1 for a number of none."""
    things = away_of(table)
    if not (number >= 0.0 and number < things + 1.0):
        return -1
    way = int(number)
    return way if way == things or is_open(way, table) else -1


def spot_turning(place: float, clock: float, table: Any) -> Any:
    """Return what :func:`spot_at` does, on the sides and tips of flippers."""
    rows = behind(rows_of(table), WIDTH * (int(table[FACES]) + int(table[CIRCLES]) + int(table[SIDES])))
    for i in range(int(table[FLIPPERS])):
        row = behind(rows, FLIPPER_WIDTH * i)
        along = place - row[RIGHT_FROM]
        if along < 0.0 or place >= row[FROM] + row[LONG]:
            continue
        kind = 1 if place < row[ROUND] else (AT_TIP if place < row[FROM] else 0)
        surface = first_turning(table) + KINDS * i + kind
        _row, _kind, ux, uy, omega = pose(surface, 0.0, clock, table)
        if kind == AT_TIP:
            turn = (place - row[ROUND]) / row[TIP] - acos(row[SINE])
            c, s = cos(turn), sin(turn)
            nx, ny, curvature = c * ux - s * uy, s * ux + c * uy, 1.0 / row[TIP]
            dx, dy = row[ARM] * ux + row[TIP] * nx, row[ARM] * uy + row[TIP] * ny
        else:
            foot, way = along if kind == 1 else row[LONG] - (place - row[FROM]), 1.0 - 2.0 * kind
            nx, ny = normal_at(kind, ux, uy, row)
            dx, dy, curvature = row[SIZE] * nx + way * foot * ny, row[SIZE] * ny - way * foot * nx, 0.0
        return surface, row[PX] + dx, row[PY] + dy, (nx, ny, curvature, omega, -omega * dy, omega * dx)
    return -1, NAN, NAN, (NAN, NAN, NAN, NAN, NAN, NAN)


def spot_at(place: float, clock: float, table: Any) -> Any:
    """Return (surface, x, y, frame) of a ball at a place on a solid object, surface -1 if there is none.

    The frame is that of :func:`met`, at the time ``clock``.
    """
    surface, x, y, nx, ny, curvature = spot(place, table)
    if surface < 0 and table[FLIPPERS] > 0.0:
        return spot_turning(place, clock, table)
    return surface, x, y, (nx, ny, curvature, 0.0, 0.0, 0.0)


def spot(place: float, table: Any) -> Any:
    """Return (surface, x, y, nx, ny, curvature) of a ball at a place on solid objects; surface -1 if there is none."""
    rows, faces, circles, sides = rows_of(table), int(table[FACES]), int(table[CIRCLES]), int(table[SIDES])
    if not (place >= 0.0 and place < table[LENGTH]):
        return -1, NAN, NAN, NAN, NAN, NAN
    for i in range(faces):
        row = behind(rows, WIDTH * i)
        if is_open(int(row[OWNER]), table):
            continue
        for side in range(2):
            along = place - (row[RIGHT] if side == 1 else row[FROM])
            if along >= 0.0 and along < row[LONG]:
                sign, ex, ey = 2.0 * side - 1.0, row[EX], row[EY]
                foot = along if side == 1 else row[LONG] - along
                nx, ny = sign * ey, -sign * ex
                size = row[SIZE]
                return 2 * i + side, row[PX] + foot * ex + size * nx, row[PY] + foot * ey + size * ny, nx, ny, 0.0
    for i in range(circles + sides):
        row = behind(rows, WIDTH * (faces + i))
        along = place - row[FROM]
        if along >= 0.0 and along < row[LONG]:
            sign, size = row[SIGN] if i >= circles else 1.0, row[SIZE]
            angle = row[ANGLE] + sign * along / size
            ux, uy = cos(angle), sin(angle)
            return 2 * faces + i, row[PX] + size * ux, row[PY] + size * uy, sign * ux, sign * uy, sign / size
    return -1, NAN, NAN, NAN, NAN, NAN
