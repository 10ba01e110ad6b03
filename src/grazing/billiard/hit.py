"""An impact: where a ball is when it meets a surface, and what the law of that object makes of its velocity."""

from __future__ import annotations

from math import atan2, cos, pi, sin, sqrt
from typing import Any

from grazing.billiard.rows import (
    ANGLE,
    CIRCLES,
    EX,
    EY,
    FACES,
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


def met(surface: int, x: float, y: float, table: Any) -> Any:
    """Return what a ball at a surface meets: the object, its own place moved onto the surface, normal, curvature.

    The normal points to the ball; the curvature is that of the ball's way along the surface, negative inside an arc.
    """
    rows, faces, circles = rows_of(table), int(table[FACES]), int(table[CIRCLES])
    if surface < 2 * faces:
        row, sign = behind(rows, WIDTH * (surface // 2)), 2.0 * (surface % 2) - 1.0
        nx, ny = sign * row[EY], -sign * row[EX]
        off = row[SIZE] - (nx * (x - row[PX]) + ny * (y - row[PY]))
        return int(row[OWNER]), x + off * nx, y + off * ny, nx, ny, 0.0
    row = behind(rows, WIDTH * (surface - faces))
    sign, size = row[SIGN] if surface >= 2 * faces + circles else 1.0, row[SIZE]
    dx, dy = x - row[PX], y - row[PY]
    far = sqrt(dx * dx + dy * dy)
    ux, uy = dx / far, dy / far
    return int(row[OWNER]), row[PX] + size * ux, row[PY] + size * uy, sign * ux, sign * uy, sign / size


def place_of(surface: int, x: float, y: float, table: Any) -> Any:
    """Return the place of a ball on a surface, as a length, see :mod:`grazing.billiard.rows`."""
    rows, faces, circles = rows_of(table), int(table[FACES]), int(table[CIRCLES])
    if surface < 2 * faces:
        row = behind(rows, WIDTH * (surface // 2))
        foot = row[EX] * (x - row[PX]) + row[EY] * (y - row[PY])
        return row[RIGHT] + foot if surface % 2 == 1 else row[FROM] + row[LONG] - foot
    row = behind(rows, WIDTH * (surface - faces))
    sign, size = row[SIGN] if surface >= 2 * faces + circles else 1.0, row[SIZE]
    turn = sign * (atan2(y - row[PY], x - row[PX]) - row[ANGLE]) % (2.0 * pi)
    span = row[LONG] / size
    if turn > span:
        turn = span if turn - span < 2.0 * pi - turn else 0.0
    return row[FROM] + size * turn


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


def way_at(number: float, table: Any) -> int:
    """Return the way out of a number, a drain or, behind all objects, *away*; -1 for a number of none."""
    things = int(table[THINGS])
    if not (number >= 0.0 and number < things + 1.0):
        return -1
    way = int(number)
    return way if way == things or is_open(way, table) else -1


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
