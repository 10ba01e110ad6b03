"""The first contact of a ball on a table: no surface can be jumped over. Proof: docs/table.md.

A face is solved first, as that is quick. The earliest contact known so far is the end of what must be looked at: of
what is surely free until then nothing more is asked.
"""

from __future__ import annotations

from math import sqrt
from typing import Any

from grazing.billiard.faces import (
    CORNER,
    STOP,
    at_sunk,
    body_of,
    ended,
    nearer,
    of_other_faces,
    of_some_face,
    slack_of,
    sunk,
)
from grazing.billiard.flippers import AT, FLIPPER_WIDTH, KINDS
from grazing.billiard.gaps import DEEP, EPS, GAP, LOOKS, crossing, first_step, lowest, rests, slid_off, touches
from grazing.billiard.rows import (
    CIRCLES,
    COSINE,
    FACES,
    FLIPPERS,
    GRAVITY,
    HEAD,
    MX,
    MY,
    OWNER,
    PX,
    PY,
    SIDES,
    SIGN,
    SIZE,
    THICK,
    THING,
    THINGS,
    WIDTH,
)  # fmt: skip
from grazing.billiard.turning import of_flipper
from grazing.kernel.primitives import behind, inlined
from grazing.outcome import AMBIGUOUS, DIVERGED, FATAL, INSIDE_WALL, OK, STUCK, TOO_MANY_IMPACTS, TOO_MANY_SWINGS

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
        The surface that it just left, -1 for none; OFF more for one off which it slid. Where it bounces on that by less
        than can be told, it *sticks*. A float: a literal would be a type of its own.
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
    found, off, slid = (-1, INFINITY, 0.0, -1.0, OK), -1, left > int(left)
    if slid and last >= 0:
        off = last
        found = back_on(found, off, x, y, vx, vy, g, faces, circles, rows)
    if not slid:
        found = of_some_face(found, x, y, vx, vy, g, last, faces, rows)
    if not found[4] & STOP:
        rows = behind(rows, WIDTH * faces)
        found = of_circles(found, x, y, vx, vy, g, last, off, 2 * faces, circles, rows)
    if not found[4] & STOP:
        rows = behind(rows, WIDTH * circles)
        found = of_sides(found, x, y, vx, vy, g, last, off, slid, faces, circles, int(table[SIDES]), rows, start)
    if table[FLIPPERS] > 0.0 and not found[4] & STOP:
        rows = behind(rows, WIDTH * int(table[SIDES]))
        on = left - int(left)
        found = of_flippers(found, x, y, vx, vy, g, turns, on, surfaces, clock, int(table[FLIPPERS]), rows)
    if not found[4] & STOP:
        found = of_other_faces(found, x, y, vx, vy, g, last, slid, faces, circles, start)
    return found[0], found[1], found[4]


@inlined
def beside_circle(row: Any, x: float, y: float, vx: float, vy: float) -> Any:
    """Say whether a ball that slides off something slides off the end of a side of an arc, too."""
    dx, dy, size = x - row[PX], y - row[PY], row[SIZE]
    far = sqrt(dx * dx + dy * dy)
    return touches(far - size, (dx * vx + dy * vy) / far, GAP * EPS * (far + size), abs(vx) + abs(vy))


def back_on(
    found: Any, off: int, x: float, y: float, vx: float, vy: float, g: float, faces: int, circles: int, rows: Any
) -> Any:  # fmt: skip
    """Return when a ball comes back to the circle off which it slid; a face off which it slid it never meets."""
    if off < 2 * faces:
        return found
    row = behind(rows, WIDTH * (off - faces))
    side = off >= 2 * faces + circles
    t, late, said = slid_off(x - row[PX], y - row[PY], vx, vy, g, row[SIZE], row[SIGN] if side else 1.0)
    found = found[0], found[1], found[2], found[3], found[4] | said
    if not t < INFINITY:
        return found
    if side:
        px, py = x - row[PX] + vx * t, y - row[PY] + (vy - 0.5 * g * t) * t
        if px * row[MX] + py * row[MY] < row[COSINE] * row[SIZE]:
            return found
    return nearer(found, off, row[OWNER], t, late)


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


def side_contact(
    x: float, y: float, vx: float, vy: float, g: float, row: Any, fresh: bool, passed: bool, begins: bool, ends: Any,
    end: float,
) -> Any:  # fmt: skip
    """Return (t, late, flags): when a side of an arc is hit first before ``end``, infinity for never.

    ``fresh``: it just left this side; ``passed``: it just left the other side, which is the same circle. ``begins``: it
    left neither, but is at one of ``ends`` where the arc is not met, the first or the second one.
    """
    dx, dy, size, sign = x - row[PX], y - row[PY], row[SIZE], row[SIGN]
    t, flags, far2 = 0.0, OK, dx * dx + dy * dy
    e = GAP * EPS * (2.0 * far2 + size * size)
    if fresh and not begins and rests(sign * 2.0 * (dx * vx + dy * vy), sign * (vx * vx + vy * vy - g * dy), e):
        return 0.0, 0.0, STUCK
    # else it is on the other side of the circle, beyond the ends of the arc
    outside = fresh or (not passed and sign * (far2 - size * size) >= -e)
    if not outside and row[THICK] > 0.0:
        far = sqrt(far2)
        wide = GAP * EPS * (far + size)
        if dx * row[MX] + dy * row[MY] > row[COSINE] * far + wide:
            outside = sign * (far2 - size * size) >= -DEEP * e  # rounding put it behind what it touches
            if not outside and sign * (far - size) > DEEP * wide - row[THICK]:
                return 0.0, 0.0, INSIDE_WALL
    fresh = fresh or passed
    for _ in range(LOOKS):
        t, late, said = crossing(dx, dy, vx, vy, g, size, sign if outside else -sign, t, fresh, end)
        flags |= said
        if t == INFINITY or said & (TOO_MANY_IMPACTS | TOO_MANY_SWINGS | DIVERGED):
            return t, late, flags
        if outside:
            px, py = dx + vx * t, dy + (vy - 0.5 * g * t) * t
            inside = px * row[MX] + py * row[MY] - row[COSINE] * size
            unsure = GAP * EPS * (abs(dx) + abs(dy) + size + (abs(vx) + abs(vy) + g * t) * t)
            unsure += (abs(vx) + abs(vy) + g * t) * late
            there = at_sunk(row, ends, row[PX] + px, row[PY] + py, DEEP * slack_of(row, x, y) + unsure)
            if inside >= -unsure and not there:
                return t, late, flags | AMBIGUOUS if inside <= unsure else flags
        outside, fresh = not outside, True
    return t, 0.0, flags | TOO_MANY_SWINGS


def of_circles(
    found: Any, x: float, y: float, vx: float, vy: float, g: float, last: int, off: int, base: int, circles: int,
    rows: Any,
) -> Any:  # fmt: skip
    """Return the first contact with a circle, or what was found before that; ``base`` is the first one's number.

    The nearest circle comes first: it brings the end forward for all others.
    """
    first, end = -1, found[1] + found[2]
    soonest, least = end, vx * vx + vy * vy + lowest(-g * vy, 0.25 * g * g, end)
    for i in range(circles):
        if off == base + i:
            continue
        row = behind(rows, WIDTH * i)
        step, said = first_step(x - row[PX], y - row[PY], vx, vy, g, row[SIZE], last == base + i, least)
        if said:
            return ended(found, base + i, 0.0, said)
        if step < soonest:
            first, soonest = i, step
    for n in range(circles + 1 if first >= 0 else 0):
        i = first if n == 0 else n - 1
        if (n > 0 and i == first) or off == base + i:
            continue
        row, step = behind(rows, WIDTH * i), soonest
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
        if n == 0:
            end = found[1] + found[2]
    return found


def of_sides(
    found: Any, x: float, y: float, vx: float, vy: float, g: float, last: int, off: int, slid: bool, faces: int,
    circles: int, sides: int, rows: Any, start: Any,
) -> Any:  # fmt: skip
    """Return the first contact with a side of an arc, or what was found before; ``start`` are the rows of all surfaces.

    A ball without a radius that has just left something where an arc begins is treated as at a face.
    """
    base = 2 * faces + circles
    for i in range(sides):
        if off == base + i:
            continue
        if slid and beside_circle(behind(rows, WIDTH * i), x, y, vx, vy):
            found = back_on(found, base + i, x, y, vx, vy, g, faces, circles, start)
            continue
        row, fresh, passed, begins, ends = behind(rows, WIDTH * i), last == base + i, False, False, (False, False)
        if not fresh and last >= base:  # without a radius both sides are one circle
            other = behind(rows, WIDTH * (last - base))
            passed = other[OWNER] == row[OWNER] and other[SIZE] == row[SIZE]
        if row[THICK] == 0.0 and last >= 0 and not fresh and not passed:
            passed, behind_it = side_corner(row, x, y, vx, vy, body_of(last, faces, circles, start, x, y))
            ends = sunk(row, -1.0, last, faces, circles, start), sunk(row, 1.0, last, faces, circles, start)
            begins = at_sunk(row, ends, x, y, slack_of(row, x, y))
            if begins:  # it is on the side to which it moves
                rate = row[SIGN] * ((x - row[PX]) * vx + (y - row[PY]) * vy)
                bend = row[SIGN] * (vx * vx + vy * vy - g * (y - row[PY]))
                fresh = rate > 0.0 or (rate == 0.0 and bend >= 0.0)
                passed = not fresh
            elif behind_it:
                continue
        t, late, said = side_contact(x, y, vx, vy, g, row, fresh, passed, begins, ends, found[1] + found[2])
        if said & STOP:
            return ended(found, base + i, t, said)
        found = found[0], found[1], found[2], found[3], found[4] | said
        if t < INFINITY:
            found = nearer(found, base + i, row[OWNER], t, late)
    return found


def of_flippers(
    found: Any, x: float, y: float, vx: float, vy: float, g: float, last: int, slid: float, base: int, clock: float,
    flippers: int, rows: Any,
) -> Any:  # fmt: skip
    """Return the first contact with a flipper but for its hub, or what was found before that."""
    for i in range(flippers):
        found = of_one_flipper(found, x, y, vx, vy, g, last - KINDS * i, slid, base + KINDS * i, clock, i, rows)
        if found[4] & STOP:
            break
    return found


@inlined
def of_one_flipper(
    found: Any, x: float, y: float, vx: float, vy: float, g: float, left: int, slid: float, base: int, clock: float,
    i: int, rows: Any,
) -> Any:  # fmt: skip
    """Return the first contact with flipper i, or what was found before; ``left`` is its surface just left, if one."""
    row, left = behind(rows, FLIPPER_WIDTH * i), left if left < KINDS else -1
    end = found[1] + found[2]
    kind, t, late, said = of_flipper(x, y, vx, vy, g, left, slid, clock, row, behind(rows, int(row[AT])), end)
    if said & STOP:
        return ended(found, base + kind, t, said)
    found = found[0], found[1], found[2], found[3], found[4] | said
    if t < INFINITY:
        found = nearer(found, base + kind, row[OWNER], t, late)
    return found
