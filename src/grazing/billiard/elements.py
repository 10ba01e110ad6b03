"""The surfaces of a table at a moment, all in one form: lines and circles on which the centre of a ball slides.

An *element* is (curved, owner, px, py, ax, ay, size, span). ``curved`` is 0 for a line: it begins at the place (px, py)
of the ball's centre, has the normal (ax, ay) to the ball, and is ``span`` long along that turned by a quarter. Else it
is a circle with centre (px, py) and radius ``size``, 1 for outside and -1 for inside; (ax, ay) points to the middle of
an arc, and ``span`` is the cosine of half of it, -2 for a whole circle.
"""

from __future__ import annotations

from math import pi, sqrt
from typing import Any

from grazing.billiard.flippers import ARM, AT_TIP, KINDS, TIP
from grazing.billiard.hit import first_turning, pose, rows_of
from grazing.billiard.rows import (
    CIRCLES,
    COSINE,
    EX,
    EY,
    FACES,
    FLIPPERS,
    GRAVITY,
    LONG,
    MX,
    MY,
    OWNER,
    PASSED,
    PX,
    PY,
    SIGN,
    SIZE,
    WIDTH,
)
from grazing.billiard.swing import swung
from grazing.billiard.turning import normal_at
from grazing.kernel.elementary import arccos, arctan2, sincos
from grazing.kernel.primitives import behind, inlined, unit

INFINITY = float("inf")
#: Longer than any way along an element that has ends.
MOST = 1e300
#: Units of the last place of the sizes involved within which a ball touches a surface, and normals are the same.
TOUCH, SAME = 64.0 * 2.0**-52, 2.0**-40


#: An angle within which rounding puts a place behind one that is ahead.
BEHIND = 1e-6


def count_of(table: Any) -> int:
    """Return how many surfaces a table has."""
    return first_turning(table) + KINDS * int(table[FLIPPERS])


def turns_at(surface: int, clock: float, table: Any) -> bool:
    """Say whether a surface is that of a flipper that turns at a time."""
    if surface < first_turning(table):
        return False
    _row, _kind, _ux, _uy, omega = pose(surface, 0.0, clock, table)
    return omega != 0.0  # type: ignore[no-any-return]


def element(surface: int, clock: float, table: Any) -> Any:
    """Return a surface as an element, at a time."""
    rows, faces, circles = rows_of(table), int(table[FACES]), int(table[CIRCLES])
    if surface >= first_turning(table):
        row, kind, ux, uy, _omega = pose(surface, 0.0, clock, table)
        if kind == AT_TIP:
            return 1.0, int(row[OWNER]), row[PX] + row[ARM] * ux, row[PY] + row[ARM] * uy, ux, uy, row[TIP], -2.0
        nx, ny = normal_at(kind, ux, uy, row)
        back = row[LONG] * (1.0 - kind)
        x, y = row[PX] + row[SIZE] * nx + back * ny, row[PY] + row[SIZE] * ny - back * nx
        return 0.0, int(row[OWNER]), x, y, nx, ny, row[SIZE], row[LONG]
    if surface < 2 * faces:
        row, sign = behind(rows, WIDTH * (surface // 2)), 2.0 * (surface % 2) - 1.0
        long = row[LONG] if row[LONG] >= 0.0 else abs(row[PASSED])
        nx, ny, back = sign * row[EY], -sign * row[EX], long * (1.0 - surface % 2)
        x, y = row[PX] + row[SIZE] * nx + back * row[EX], row[PY] + row[SIZE] * ny + back * row[EY]
        return 0.0, int(row[OWNER]), x, y, nx, ny, row[SIZE], long
    row = behind(rows, WIDTH * (surface - faces))
    if surface >= 2 * faces + circles:
        return row[SIGN], int(row[OWNER]), row[PX], row[PY], row[MX], row[MY], row[SIZE], row[COSINE]
    return 1.0, int(row[OWNER]), row[PX], row[PY], 0.0, 0.0, row[SIZE], -2.0


@inlined
def is_passed(surface: int, table: Any) -> Any:
    """Say whether a surface is the side of a gate on which a ball came that has just gone through that."""
    if surface < 0 or surface >= 2 * int(table[FACES]):
        return False
    return behind(rows_of(table), WIDTH * (surface // 2))[PASSED] * (2.0 * (surface % 2) - 1.0) > 0.0


@inlined
def normal_of(el: Any, x: float, y: float) -> Any:
    """Return the normal of an element at the ball's place, to the ball."""
    curved, _owner, px, py, ax, ay, _size, _span = el
    if curved == 0.0:
        return ax, ay
    dx, dy = x - px, y - py
    far = curved * sqrt(dx * dx + dy * dy)
    return dx / far, dy / far


@inlined
def bend_of(el: Any) -> Any:
    """Return the curvature of an element, negative inside a circle."""
    return el[0] / el[6] if el[0] != 0.0 else 0.0


@inlined
def gap_of(el: Any, x: float, y: float) -> Any:
    """Return how far the ball's centre is from an element, negative behind it."""
    curved, _owner, px, py, ax, ay, size, _span = el
    dx, dy = x - px, y - py
    if curved == 0.0:
        return ax * dx + ay * dy
    return curved * (sqrt(dx * dx + dy * dy) - size)


@inlined
def width_of(el: Any, x: float, y: float) -> Any:
    """Return within what a ball at a place touches an element."""
    return TOUCH * (abs(x) + abs(y) + abs(el[2]) + abs(el[3]) + el[6])


@inlined
def holds(el: Any, x: float, y: float, slack: float) -> Any:
    """Say whether a place on the line or circle of an element lies between its ends."""
    curved, _owner, px, py, ax, ay, size, span = el
    dx, dy = x - px, y - py
    if curved == 0.0:
        foot = ax * dy - ay * dx
        return foot >= -slack and foot <= span + slack
    return span < -1.0 or size * (arccos(span) - abs(arctan2(ax * dy - ay * dx, ax * dx + ay * dy))) >= -slack


@inlined
def to_end(el: Any, x: float, y: float, way: float) -> Any:
    """Return how far it is along an element to its end, in one of both ways; infinity for none."""
    curved, _owner, px, py, ax, ay, size, span = el
    dx, dy = x - px, y - py
    if curved == 0.0:
        foot = ax * dy - ay * dx
        return max(span - foot if way > 0.0 else foot, 0.0)
    if span < -1.0:
        return INFINITY
    return max(arccos(span) - way * curved * arctan2(ax * dy - ay * dx, ax * dx + ay * dy), 0.0) * size


@inlined
def apart(line: Any, other: Any, x: float, y: float) -> Any:
    """Return within what a ball touches a line and another element, twice: so far from the one it does not."""
    return 2.0 * (width_of(line, x, y) + width_of(other, x, y) + TOUCH * line[7])


@inlined
def rises(line: Any, x: float, y: float, nx: float, ny: float) -> Any:
    """Say whether a line that goes through a place, within rounding, rises there in the direction of a normal."""
    _curved, _owner, px, py, ax, ay, _size, span = line
    begin = nx * (px - x) + ny * (py - y)
    return max(begin, begin + span * (nx * -ay + ny * ax)) > SAME * span


@unit
def shares_end(el: Any, other: Any, x: float, y: float, width: float) -> Any:
    """Say whether the nearer end of an element is on another one."""
    more, less = to_end(el, x, y, 1.0), to_end(el, x, y, -1.0)
    (nx, ny), gap = normal_of(el, x, y), gap_of(el, x, y)  # the ball is on it up to rounding
    ex, ey = along(el, x - gap * nx, y - gap * ny, 1.0 if more < less else -1.0, min(more, less, MOST))
    return min(more, less) < MOST and abs(gap_of(other, ex, ey)) <= width and holds(other, ex, ey, width)


@inlined
def joins(el: Any, wall: Any, x: float, y: float, width: float) -> Any:
    """Say whether a wall rises from the middle of an element."""
    nx, ny = normal_of(el, x, y)
    return rises(wall, x, y, nx, ny) and shares_end(wall, el, x, y, width) and not shares_end(el, wall, x, y, width)


@inlined
def along(el: Any, x: float, y: float, way: float, s: float) -> Any:
    """Return the place on an element a length s further."""
    curved, _owner, px, py, ax, ay, _size, _span = el
    if curved == 0.0:
        return x - way * ay * s, y + way * ax * s
    return turned_by(px, py, x, y, way * curved * s / el[6])


@inlined
def turned_by(px: float, py: float, x: float, y: float, angle: float) -> Any:
    """Return a place turned about another one."""
    (s, c), dx, dy = sincos(angle), x - px, y - py
    return px + c * dx - s * dy, py + s * dx + c * dy


def ahead_on_line(x: float, y: float, wx: float, wy: float, other: Any, width: float) -> Any:
    """Return (s, touch): where the gap of an element first comes down to 0 on a straight way, infinity for nowhere.

    ``touch`` is where it does so up to rounding, and rises again.
    """
    curved, _owner, px, py, ax, ay, size, _span = other
    h = gap_of(other, x, y)
    dx, dy = x - px, y - py
    if curved == 0.0:
        rate = ax * wx + ay * wy
        return (max(h, 0.0) / -rate if h >= -width and rate < -SAME else INFINITY), INFINITY
    b, c = dx * wx + dy * wy, (sqrt(dx * dx + dy * dy) - size) * (sqrt(dx * dx + dy * dy) + size)
    apart = abs(dx * wy - dy * wx)  # of its centre from the way
    D = (size - apart) * (size + apart)
    unsure = 2.0 * width * size
    if curved > 0.0:
        if h < -width or b >= 0.0 or D < -unsure:
            return INFINITY, INFINITY
        if D <= unsure:
            return INFINITY, -b
        return max(c, 0.0) / (sqrt(D) - b), INFINITY
    return (sqrt(D) - b if D > unsure and (b < 0.0 or h >= 0.0) else INFINITY), INFINITY


def ahead_on_circle(el: Any, x: float, y: float, way: float, other: Any, width: float) -> Any:
    """Return (s, joint, touch) on a circle, as :func:`ahead_on_line`; ``joint``: where it comes up to 0 from below."""
    curved, _owner, px, py, _ax, _ay, size, _span = el
    bent, _other, qx, qy, nx, ny, radius, _long = other
    q, dx, dy, level, reach = way * curved, x - px, y - py, 0.0, size
    if bent == 0.0:
        gx, gy = nx, ny
        level = nx * (px - qx) + ny * (py - qy)
    else:
        gx, gy = px - qx, py - qy
        far = sqrt(gx * gx + gy * gy)
        if far <= width:
            return INFINITY, INFINITY, INFINITY
        level, reach = (size - radius) * (size + radius) + far * far, 2.0 * size * far
    start = arctan2(gx * dy - gy * dx, gx * dx + gy * dy)  # the angle of the ball from (gx, gy)
    sign = -1.0 if bent < 0.0 else 1.0  # the gap is sign (level + reach cos)
    slack = width * (1.0 if bent == 0.0 else 2.0 * (radius + size))
    top, bottom = sign * level + reach, sign * level - reach
    if top < -slack or bottom > slack:
        return INFINITY, INFINITY, INFINITY
    if top <= slack:  # it is nowhere above but for one place
        joint = (0.0 if sign > 0.0 else pi) - q * start
        return INFINITY, size * (joint % (2.0 * pi)), INFINITY
    if bottom >= -slack:
        return INFINITY, INFINITY, size * (((pi if sign > 0.0 else 0.0) - q * start) % (2.0 * pi))
    turn = (sign * arccos(-level / reach) - q * start) % (2.0 * pi)
    if turn > 2.0 * pi - BEHIND and gap_of(other, x, y) >= 0.0:  # it is not behind it: that is rounding
        turn = 0.0
    return size * turn, INFINITY, INFINITY


def slid(surface: int, x: float, y: float, vx: float, vy: float, t: float, clock: float, table: Any) -> Any:
    """Return place and velocity of a ball that slides on a surface after a time, if nothing ends that before."""
    el, g = element(surface, clock, table), table[GRAVITY]
    nx, ny = normal_of(el, x, y)
    speed, bend = vy * nx - vx * ny, bend_of(el)
    if el[0] == 0.0:
        s, speed = (speed - 0.5 * g * nx * t) * t, speed - g * nx * t
        fx, fy = along(el, x, y, 1.0, s)
        return fx, fy, -ny * speed, nx * speed
    turned, rate = swung(arctan2(ny, nx), bend * speed, bend * g, t)
    fx, fy = turned_by(el[2], el[3], x, y, turned)
    mx, my = normal_of(el, fx, fy)
    return fx, fy, -my * rate / bend, mx * rate / bend
