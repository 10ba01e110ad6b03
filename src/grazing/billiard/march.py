"""The first contact of a ball on a table: no surface can be jumped over. Proof: docs/table.md.

A face is solved first, as that is quick. The earliest contact known so far is the end of what must be looked at: of
what is surely free until then nothing more is asked.
"""

from __future__ import annotations

from typing import Any

from grazing.billiard.faces import CORNER, body_of, ended, nearer, of_other_faces, of_some_face
from grazing.billiard.flippers import AT, FLIPPER_WIDTH, KINDS
from grazing.billiard.gaps import EPS, GAP, crossing, first_step, lowest, side_contact
from grazing.billiard.rows import (
    BARE,
    CIRCLES,
    FACES,
    FLIPPERS,
    GRAVITY,
    HEAD,
    OWNER,
    PX,
    PY,
    SIDES,
    SIGN,
    SIZE,
    THING,
    THINGS,
    WIDTH,
)  # fmt: skip
from grazing.billiard.turning import of_flipper
from grazing.kernel.primitives import behind, inlined
from grazing.outcome import DIVERGED, FATAL, OK, TOO_MANY_IMPACTS

INFINITY = float("inf")
#: Sizes and speeds beyond which a gap, of their fourth powers, leaves the range of doubles.
LEAST, MOST = 1e-60, 1e60


def first_contact(x: float, y: float, vx: float, vy: float, left: float, clock: float, table: Any) -> Any:
    """Return (surface, t, flags): what a ball hits first, -1 for nothing, and when, from t = 0 on.

    A ball that is at rest on a level table, or as slow as nothing, ends by name.

    Parameters
    ----------
    x, y, vx, vy : float
        Place and velocity of its centre.
    left : float
        The surface that it just left, -1 for none. A float: a literal would be a type of its own.
    clock : float
        The time at the begin of the flight: it says where flippers are.
    table : pointer to numbers
        Of :func:`grazing.billiard.rows.block_of`.
    """
    g, faces, circles = table[GRAVITY], int(table[FACES]), int(table[CIRCLES])
    fast = abs(vx) + abs(vy)
    if not (abs(x) + abs(y) <= MOST and fast <= MOST):
        return -1, 0.0, DIVERGED
    if g == 0.0 and fast < LEAST:
        return -1, 0.0, TOO_MANY_IMPACTS
    rows, last = behind(table, HEAD + THING * int(table[THINGS])), int(left)
    start, surfaces = rows, 2 * faces + circles + int(table[SIDES])
    turns = last - surfaces  # of a flipper, if it is one
    if turns >= 0:
        last = -1
    found = of_some_face((-1, INFINITY, 0.0, -1.0, OK), x, y, vx, vy, g, last, faces, rows)
    if not found[4] & FATAL:
        rows = behind(rows, WIDTH * faces)
        found = of_circles(found, x, y, vx, vy, g, last, 2 * faces, circles, rows)
    if not found[4] & FATAL:
        rows = behind(rows, WIDTH * circles)
        found = of_sides(found, x, y, vx, vy, g, last, faces, circles, int(table[SIDES]), rows, start)
    if table[FLIPPERS] > 0.0 and not found[4] & FATAL:
        rows = behind(rows, WIDTH * int(table[SIDES]))
        found = of_flippers(found, x, y, vx, vy, g, turns, surfaces, clock, int(table[FLIPPERS]), rows)
    if not found[4] & FATAL:
        found = of_other_faces(found, x, y, vx, vy, g, last, faces, circles, start)
    return found[0], found[1], found[4]


@inlined
def side_corner(row: Any, x: float, y: float, vx: float, vy: float, body: Any) -> Any:
    """Return (passed, comes): whether a ball without a radius is on the circle of an arc, but not on this side of it.

    ``comes``: it moves towards this side, and meets the other one.
    """
    dx, dy, size, sign = x - row[PX], y - row[PY], row[SIZE], row[SIGN]
    far2, bx, by = dx * dx + dy * dy, body[0] - row[PX], body[1] - row[PY]
    on = abs(far2 - size * size) <= CORNER * GAP * EPS * (far2 + size * size)
    passed = on and sign * (bx * bx + by * by - size * size) < 0.0
    return passed, passed and sign * (dx * vx + dy * vy) > 0.0


def of_circles(
    found: Any, x: float, y: float, vx: float, vy: float, g: float, last: int, base: int, circles: int, rows: Any
) -> Any:  # fmt: skip
    """Return the first contact with a circle, or what was found before that; ``base`` is the first one's number.

    The nearest circle comes first: it brings the end forward for all others.
    """
    first, soonest, speed2 = -1, found[1] + found[2], vx * vx + vy * vy
    least = speed2 + lowest(-g * vy, 0.25 * g * g, soonest)
    for i in range(circles):
        row = behind(rows, WIDTH * i)
        step, said = first_step(x - row[PX], y - row[PY], vx, vy, g, row[SIZE], last == base + i, least)
        if said:
            return ended(found, base + i, 0.0, said)
        if step < soonest:
            first, soonest = i, step
    for n in range(circles + 1 if first >= 0 else 0):
        i = first if n == 0 else n - 1
        if n > 0 and i == first:
            continue
        row, step, end = behind(rows, WIDTH * i), soonest, found[1] + found[2]
        if n > 0:
            step, _said = first_step(x - row[PX], y - row[PY], vx, vy, g, row[SIZE], last == base + i, least)
            if not step < end:
                continue
        t, late, said = crossing(x - row[PX], y - row[PY], vx, vy, g, row[SIZE], 1.0, step, False, end)
        if said & FATAL:
            return ended(found, base + i, t, said)
        found = found[0], found[1], found[2], found[3], found[4] | said
        if t < INFINITY:
            found = nearer(found, base + i, row[OWNER], t, late)
            least = speed2 + lowest(-g * vy, 0.25 * g * g, found[1] + found[2])
    return found


def of_sides(
    found: Any, x: float, y: float, vx: float, vy: float, g: float, last: int, faces: int, circles: int, sides: int,
    rows: Any, start: Any,
) -> Any:  # fmt: skip
    """Return the first contact with a side of an arc, or what was found before; ``start`` are the rows of all surfaces.

    A ball without a radius that has just left something where an arc begins is treated as at a face.
    """
    base = 2 * faces + circles
    for i in range(sides):
        row, fresh, passed = behind(rows, WIDTH * i), last == base + i, False
        if not fresh and last >= base:  # without a radius both sides are one circle
            other = behind(rows, WIDTH * (last - base))
            passed = other[OWNER] == row[OWNER] and other[SIZE] == row[SIZE]
        if row[BARE] > 0.0 and last >= 0 and not fresh and not passed:
            passed, behind_it = side_corner(row, x, y, vx, vy, body_of(last, faces, circles, start))
            if behind_it:
                continue
        t, late, said = side_contact(x, y, vx, vy, g, row, fresh, passed, found[1] + found[2])
        if said & FATAL:
            return ended(found, base + i, t, said)
        found = found[0], found[1], found[2], found[3], found[4] | said
        if t < INFINITY:
            found = nearer(found, base + i, row[OWNER], t, late)
    return found


def of_flippers(
    found: Any, x: float, y: float, vx: float, vy: float, g: float, last: int, base: int, clock: float, flippers: int,
    rows: Any,
) -> Any:  # fmt: skip
    """Return the first contact with a flipper but for its hub, or what was found before that."""
    for i in range(flippers):
        row = behind(rows, FLIPPER_WIDTH * i)
        left = last - KINDS * i
        if left >= KINDS:
            left = -1
        end = found[1] + found[2]
        kind, t, late, said = of_flipper(x, y, vx, vy, g, left, clock, row, behind(rows, int(row[AT])), end)
        if said & FATAL:
            return ended(found, base + KINDS * i + kind, t, said)
        found = found[0], found[1], found[2], found[3], found[4] | said
        if t < INFINITY:
            found = nearer(found, base + KINDS * i + kind, row[OWNER], t, late)
    return found
