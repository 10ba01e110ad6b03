"""The first contact with faces: the side that seems to come first is met first, and ends what must be looked at.

Of all others it is then shown that they are not met until the first contact of all, or they are met as well.
"""

from __future__ import annotations

from math import floor, sqrt
from typing import Any

from grazing.billiard.gaps import DEEP, EPS, GAP, face_crossing, face_root, rests, touches
from grazing.billiard.rows import COSINE, EX, EY, LONG, MX, MY, OWNER, PASSED, PX, PY, SIGN, SIZE, WIDTH
from grazing.kernel.primitives import behind, inlined, unit
from grazing.outcome import AMBIGUOUS, FATAL, INSIDE_WALL, OK, STUCK

INFINITY = float("inf")
#: Flags with which the search for a contact ends.
STOP = FATAL | STUCK
#: Errors of a gap within which a ball without a radius is in a corner: as many as a slide along the face makes.
CORNER = 4.0
#: The sine of an angle below which a face goes on along a surface, and does not rise from it.
RISES = 2.0**-40
#: The part of a surface that tells near its end on which side of another one it is.
CLOSE = 2.0**-10


@inlined
def nearer(found: Any, surface: int, owner: float, t: float, late: float) -> Any:
    """Return the earlier of what was found and another contact, ambiguous if their order is not sure.

    ``found`` is (surface, time, how late that may be, object, flags). Two surfaces of one object are the same contact:
    a face ends where the circle around its end begins.
    """
    hit, best, slack, who, flags = found
    if hit >= 0 and who != owner and abs(t - best) <= late + slack:
        flags |= AMBIGUOUS
    if t < best:
        return surface, t, late, owner, flags
    return hit, best, slack, who, flags


@inlined
def ended(found: Any, surface: int, t: float, flags: int) -> Any:
    """Return what was found where a flight ends by name."""
    return surface, t, 0.0, -1.0, found[4] | flags


@inlined
def body_of(surface: int, faces: int, circles: int, rows: Any, x: float, y: float) -> Any:
    """Return a point of what lies at a surface: in a corner it says on which side of the other one the ball is.

    It is near to a place at which the surface ends; else it is in the middle.
    """
    if surface < 0:
        return 0.0, 0.0
    face, side = surface < 2 * faces, surface >= 2 * faces + circles
    row = behind(rows, WIDTH * (surface // 2 if face else surface - faces))
    e = slack_of(row, x, y)
    if face:
        bx, by = from_end(row, x, y, e)
        part = 0.5 - (0.5 - CLOSE) * (bx * row[EX] + by * row[EY])
        return row[PX] + part * row[LONG] * row[EX], row[PY] + part * row[LONG] * row[EY]
    (bx, by), turned = from_end_of_arc(row, x, y, e), CLOSE * row[LONG]
    if side and (bx != 0.0 or by != 0.0):
        bent = 0.5 * turned * turned / (row[SIZE] * row[SIZE])
        return x + turned * bx - bent * (x - row[PX]), y + turned * by - bent * (y - row[PY])
    far = row[SIZE] if side else 0.0
    return row[PX] + far * row[MX], row[PY] + far * row[MY]


@inlined
def joint(last: int, faces: int, circles: int, rows: Any, x: float, y: float, ex: float, ey: float, e: float) -> Any:
    """Return (rise, middle): how steeply a face that begins at a place rises from a surface, 0 if that is not there.

    ``middle``: it begins between the ends of the surface.
    """
    face, side = last < 2 * faces, last >= 2 * faces + circles
    row = behind(rows, WIDTH * (last // 2 if face else last - faces))
    dx, dy, size = x - row[PX], y - row[PY], row[SIZE]
    sign = 2.0 * (last % 2) - 1.0 if face else (row[SIGN] if side else 1.0)
    far = max(sqrt(dx * dx + dy * dy), e)  # a face may begin at the centre
    foot = row[EX] * dx + row[EY] * dy
    nx, ny, room = sign * row[EY], -sign * row[EX], min(foot, row[LONG] - foot)
    gap = nx * dx + ny * dy - size
    if not face:
        nx, ny, gap = sign * dx / far, sign * dy / far, far - size
        room = row[MX] * dx + row[MY] * dy - row[COSINE] * size if side else size
    on = abs(gap) <= e and room >= -e
    return nx * ex + ny * ey if on else 0.0, room > e


@unit
def closing(
    last: int, faces: int, circles: int, rows: Any, row: Any, sign: float, far: float, here: bool, e: float
) -> float:  # fmt: skip
    """Return whether an end of a side of a face is closed to a ball that left a surface, 1; open, -1; or not there, 0.

    The end is on that surface. If the face rises before it, rounding leaves no way between both. If it falls away, the
    ball does not meet it there: not its back, nothing where the surface goes on beyond it, nor that at which it is
    ``here``. The side is the right one for ``sign`` 1, the end the second one for ``far`` 1.
    """
    ex, ey = row[EX], row[EY]
    x, y, way = row[PX] + far * row[LONG] * ex, row[PY] + far * row[LONG] * ey, 1.0 - 2.0 * far
    rise, middle = joint(last, faces, circles, rows, x, y, way * ex, way * ey, e)
    bx, by = body_of(last, faces, circles, rows, x, y)
    back = sign * (ey * (bx - row[PX]) - ex * (by - row[PY])) > 0.0
    if rise > RISES:
        return 1.0
    return -1.0 if rise < -RISES and (here or middle or back) else 0.0


@inlined
def from_end(row: Any, x: float, y: float, e: float) -> Any:
    """Return the direction in which a face goes on from a place at which it ends, (0, 0) if it does not end there."""
    dx, dy, ex, ey = x - row[PX], y - row[PY], row[EX], row[EY]
    foot = ex * dx + ey * dy
    ends = (1.0 if abs(foot) <= e else 0.0) - (1.0 if abs(foot - row[LONG]) <= e else 0.0)
    ends = ends if abs(ey * dx - ex * dy) <= e else 0.0
    return ends * ex, ends * ey


@inlined
def end_of_arc(row: Any, turn: float) -> Any:
    """Return an end of a side of an arc, the first one for ``turn`` -1, and the direction in which it goes on there."""
    c, size = row[COSINE], row[SIZE]
    s = sqrt(max(1.0 - c * c, 0.0))
    ux, uy = c * row[MX] - turn * s * row[MY], c * row[MY] + turn * s * row[MX]
    return row[PX] + size * ux, row[PY] + size * uy, turn * uy, -turn * ux


@inlined
def ends_at(row: Any, turn: float, x: float, y: float, e: float) -> Any:
    """Say whether a side of an arc has an end at a place."""
    px, py, _bx, _by = end_of_arc(row, turn)
    return row[COSINE] >= -1.0 and abs(x - px) + abs(y - py) <= e


@inlined
def from_end_of_arc(row: Any, x: float, y: float, e: float) -> Any:
    """Return what :func:`from_end` does, of a side of an arc."""
    turn = 1.0 if row[MX] * (y - row[PY]) - row[MY] * (x - row[PX]) >= 0.0 else -1.0
    _px, _py, bx, by = end_of_arc(row, turn)
    ends = 1.0 if ends_at(row, turn, x, y, e) else 0.0
    return ends * bx, ends * by


@unit
def covered(i: int, b: Any, last: int, x: float, y: float, a: Any, n: Any, faces: int, rows: Any) -> Any:
    """Say whether another face than i lies between two ways from where it ends: ``b``, and ``a`` on a surface.

    ``n`` is the normal of that. A ball without a radius that comes this way, or leaves that surface, meets it first.
    """
    if b[0] == 0.0 and b[1] == 0.0:
        return False
    turned = turned_from(a, n, b[0], b[1])
    for j in range(faces):
        row = behind(rows, WIDTH * j)
        cx, cy = from_end(row, x, y, slack_of(row, x, y))
        other = j != i and j != last // 2 and (cx != 0.0 or cy != 0.0)
        if other and turned_from(a, n, cx, cy) < turned - RISES:
            return True
    return False


@unit
def shut_off(i: int, b: Any, last: int, x: float, y: float, faces: int, circles: int, rows: Any) -> Any:
    """Say whether a way ``b`` on the face i, or on none, is :func:`covered` to a ball that left a surface's end."""
    if last >= 2 * faces and last < 2 * faces + circles:
        return False
    left = behind(rows, WIDTH * (last // 2 if last < 2 * faces else last - faces))
    dx, dy, e = x - left[PX], y - left[PY], slack_of(left, x, y)
    ax, ay = from_end(left, x, y, e)
    sign = 2.0 * (last % 2) - 1.0
    nx, ny = sign * left[EY], -sign * left[EX]
    if last >= 2 * faces:
        far, on = left[SIGN] * sqrt(dx * dx + dy * dy), left[MX] * dx + left[MY] * dy - left[COSINE] * left[SIZE] <= e
        nx, ny, turn = dx / far, dy / far, left[SIGN] if left[MX] * dy - left[MY] * dx < 0.0 else -left[SIGN]
        ax, ay = (-turn * ny, turn * nx) if on else (0.0, 0.0)
    return (ax != 0.0 or ay != 0.0) and covered(i, b, last, x, y, (ax, ay), (nx, ny), faces, rows)


@unit
def sunk(row: Any, turn: float, last: int, faces: int, circles: int, rows: Any) -> Any:
    """Say whether a side of an arc ends on the surface that a ball without a radius has left, and lies behind that.

    Or behind a face that ends there: the ball does not meet it at that end.
    """
    if row[COSINE] < -1.0:
        return False
    x, y, bx, by = end_of_arc(row, turn)
    rise, _middle = joint(last, faces, circles, rows, x, y, bx, by, slack_of(row, x, y))
    return rise < -RISES or shut_off(-1, (bx, by), last, x, y, faces, circles, rows)


@inlined
def at_sunk(row: Any, ends: Any, x: float, y: float, e: float) -> Any:
    """Say whether a place is at an end of a side of an arc that is :func:`sunk`, the first or the second one."""
    return (ends[0] and ends_at(row, -1.0, x, y, e)) or (ends[1] and ends_at(row, 1.0, x, y, e))


@inlined
def turned_from(a: Any, n: Any, bx: float, by: float) -> Any:
    """Return how far a direction is turned from another one over its normal: from 0 for not at all to 4 for once."""
    along = a[0] * bx + a[1] * by
    return 1.0 - along if n[0] * bx + n[1] * by >= 0.0 else 3.0 + along


@inlined
def slack_of(row: Any, x: float, y: float) -> Any:
    """Return within what a ball without a radius is at the line or at an end of a face."""
    return CORNER * GAP * EPS * (abs(x) + abs(y) + abs(x - row[PX]) + abs(y - row[PY]) + row[LONG])


@unit
def face_corner(
    i: int, x: float, y: float, vx: float, vy: float, last: int, faces: int, circles: int, rows: Any
) -> Any:  # fmt: skip
    """Return (corner, way, shut): whether a ball without a radius is on the line of a face, on its right or left, +-.

    It is on the side on which the body is of what it left; if the face falls away from that, on the other one; and on
    that to which it flies, if another face lies between both: then it is ``shut`` off, and meets no side of it there.
    """
    row = behind(rows, WIDTH * i)
    dx, dy, ex, ey = x - row[PX], y - row[PY], row[EX], row[EY]
    e, foot, leaves = slack_of(row, x, y), ex * dx + ey * dy, ey * vx - ex * vy
    if abs(ey * dx - ex * dy) > e:
        return False, 0.0, False
    shut = shut_off(i, from_end(row, x, y, e), last, x, y, faces, circles, rows)
    body = body_of(last, faces, circles, rows, x, y)
    way = ey * (body[0] - row[PX]) - ex * (body[1] - row[PY])
    far = 1.0 if foot > 0.5 * row[LONG] else 0.0
    if abs(way) <= e or shut:  # one line goes on as the other: it leaves both
        way = leaves
    elif abs(foot - far * row[LONG]) <= e and closing(last, faces, circles, rows, row, 0.0, far, True, e) < 0.0:
        way = -way
    return True, way, shut


@inlined
def beside_face(row: Any, sign: float, x: float, y: float, vx: float, vy: float) -> Any:
    """Say whether a ball that slides off something slides off the end of a side of a face, too."""
    dx, dy, ex, ey = x - row[PX], y - row[PY], row[EX], row[EY]
    h, e = sign * (ey * dx - ex * dy) - row[SIZE], GAP * EPS * (abs(dx) + abs(dy) + row[SIZE])
    return touches(h, ey * vx - ex * vy, e, abs(vx) + abs(vy))


@inlined
def spread_of(dx: float, dy: float, size: float, long: float) -> float:
    """Return the sizes that the gap of a face is made of: a ball without a radius may be at its very end."""
    return abs(dx) + abs(dy) + (size if size > 0.0 else long)


@inlined
def inside_face(off: float, foot: float, size: float, long: float, e: float) -> Any:
    """Say whether a ball is surely nearer to a face than it can be."""
    return size - abs(off) - DEEP * e > 0.0 and foot > e and foot < long - e


@inlined
def foot_at(t: float, late: float, along: Any, v: Any, face: Any, g: float) -> Any:
    """Return where on a face the foot of a ball is at a time, and how far that may be off."""
    (dx, dy), (vx, vy), (ex, ey, size, _long) = along, v, face
    spread, speed, s = abs(dx) + abs(dy) + size, abs(vx) + abs(vy), t if t < INFINITY else 0.0
    foot = ex * (dx + vx * s) + ey * (dy + (vy - 0.5 * g * s) * s)
    return foot, GAP * EPS * (spread + (speed + g * s) * s) + (speed + g * s) * late


@inlined
def on_face(t: float, late: float, along: Any, v: Any, face: Any, g: float, end: float, slack: float) -> Any:
    """Return (met, unsure): whether a face is met at the time t, before ``end`` and between its ends.

    ``along`` is the ball's place as seen from the first end, ``face`` its direction, size and length; ``slack`` is how
    near to an end without a circle it is in doubt.
    """
    _ex, _ey, size, long = face
    foot, unsure = foot_at(t, late, along, v, face, g)
    on = (t < INFINITY) & (t <= end + late) & (foot >= -unsure) & (foot <= long + unsure)
    near = unsure + slack
    bare = on & (size == 0.0) & ((foot < near) | (foot > long - near))  # no circle is around that end
    return on, bare


@inlined
def guess(along: Any, v: Any, face: Any, g: float, left: float, right: float, last: float) -> Any:
    """Return (t, surface, stuck): when the side of a face on which a ball is seems to be met, infinity for never.

    Nothing of this is sure, but ``stuck``: it just left that side, and bounces by less than can be told. ``left`` and
    ``right`` are the numbers of the sides.
    """
    (dx, dy), (vx, vy), (ex, ey, size, long) = along, v, face
    off, fresh = ey * dx - ex * dy, (last == left) | (last == right)
    surface = last if fresh else (right if off >= 0.0 else left)
    sign = 1.0 if surface == right else -1.0
    h, dh, bend = 0.0 if fresh else sign * off - size, sign * (ey * vx - ex * vy), sign * (0.5 * g * ex)
    D = dh * dh - 4.0 * bend * h
    down = (dh < 0.0) & (not fresh)
    meets = (D >= 0.0) & (down | (bend < 0.0))
    root = sqrt(max(D, 0.0))
    over, under = 2.0 * h if down else -0.5 * (dh + root), root - dh if down else bend
    t = over / (under if meets else 1.0)
    foot = ex * (dx + vx * t) + ey * (dy + (vy - 0.5 * g * t) * t)
    stuck = fresh & rests(dh, bend, GAP * EPS * spread_of(dx, dy, size, long))
    return t if meets & (t >= 0.0) & (foot >= 0.0) & (foot <= long) else INFINITY, surface, stuck


@inlined
def met_side(along: Any, v: Any, face: Any, g: float, surface: float, last: float, far: float) -> Any:
    """Return (met, t, late): whether one side of a face is met beyond doubt, and when; False if that is in doubt.

    ``far``: |x| + |y|, by a share of which rounding put it beside what it left.
    """
    (dx, dy), (vx, vy), (ex, ey, size, long) = along, v, face
    sign, fresh = 4.0 * (0.5 * surface - floor(0.5 * surface)) - 1.0, last == surface
    off, e, d = ey * dx - ex * dy, GAP * EPS * spread_of(dx, dy, size, long), GAP * EPS * (abs(vx) + abs(vy))
    h, rate, bend = sign * off - size, sign * (ey * vx - ex * vy), sign * (0.5 * g * ex)
    sure, t, late = face_root(h, rate, bend, e, d, fresh)
    beside = CORNER * (e + GAP * EPS * (far + long)) if (size == 0.0) & (last >= 0.0) else 0.0
    on, unsure = on_face(t, late, along, v, face, g, INFINITY, beside)
    deep = (last != surface) & ((h < -e) | (abs(off) < beside))
    return sure & on & (not deep) & (not unsure), t, late


@inlined
def passes(
    along: Any, v: Any, face: Any, g: float, left: float, right: float, last: float, end: float, far: float
) -> Any:  # fmt: skip
    """Say whether a ball surely meets no side of a face until ``end``; ``far`` as for :func:`met_side`.

    It stays on one side of both lines, or beyond one end, as a parabola leaves its chord by g end^2/8 at most; or it
    leaves one of the sides and does not turn back.
    """
    (dx, dy), (vx, vy), (ex, ey, size, long) = along, v, face
    t = end if end < INFINITY else 0.0
    speed = abs(vx) + abs(vy) + g * t
    unsure = CORNER * GAP * EPS * (far + abs(dx) + abs(dy) + size + long + speed * t)
    bow = 0.125 * g * t * t + unsure
    off, rate = ey * dx - ex * dy, ey * vx - ex * vy
    then = off + (rate + 0.5 * g * ex * t) * t
    foot = ex * dx + ey * dy
    thence = foot + (ex * vx + ey * vy - 0.5 * g * ey * t) * t
    away = max(min(off, then), -max(off, then)) - abs(ex) * bow - unsure - size
    beside = max(min(foot, thence) - long, -max(foot, thence)) - abs(ey) * bow - unsure
    sign = 1.0 if last == right else -1.0
    leaves = min(sign * rate, sign * (rate + 0.5 * g * ex * t)) > 2.0 * GAP * EPS * speed
    return (end < INFINITY) & ((max(away, beside) > 0.0) | (leaves & ((last == left) | (last == right))))


def of_some_face(
    found: Any, x: float, y: float, vx: float, vy: float, g: float, last: int, faces: int, rows: Any
) -> Any:  # fmt: skip
    """Return the contact with the side of a face that seems to come first, if there is one beyond doubt."""
    soonest, best = INFINITY, -1.0
    for i in range(faces):
        row = behind(rows, WIDTH * i)
        face = row[EX], row[EY], row[SIZE], row[LONG]
        along = x - row[PX], y - row[PY]
        t, surface, stuck = guess(along, (vx, vy), face, g, 2.0 * i, 2.0 * i + 1.0, 1.0 * last)
        if stuck:
            return ended(found, last, 0.0, STUCK)
        if t < soonest:
            soonest, best = t, surface
    if best < 0.0:
        return found
    row = behind(rows, WIDTH * (int(best) // 2))
    along, face = (x - row[PX], y - row[PY]), (row[EX], row[EY], row[SIZE], row[LONG])
    sure, t, late = met_side(along, (vx, vy), face, g, best, 1.0 * last, abs(x) + abs(y))
    return nearer(found, int(best), row[OWNER], t, late) if sure else found


def of_other_faces(
    found: Any, x: float, y: float, vx: float, vy: float, g: float, last: int, slid: bool, faces: int, circles: int,
    rows: Any,
) -> Any:  # fmt: skip
    """Return the first contact with any face, or what was found before that; ``slid``: it slid off what it left."""
    far = abs(x) + abs(y)
    for i in range(faces):
        if slid and last >= 0 and last // 2 == i:  # it has no radius, and is beyond its end
            continue
        row = behind(rows, WIDTH * i)
        along, face = (x - row[PX], y - row[PY]), (row[EX], row[EY], row[SIZE], row[LONG])
        end, left = found[1] + found[2], 2.0 * i
        if row[LONG] < 0.0:  # it has just gone through that gate
            found = through_gate(found, i, along, (vx, vy), g, row)
            continue
        if found[0] // 2 == i or passes(along, (vx, vy), face, g, left, left + 1.0, 1.0 * last, end, far):
            continue
        if not found[4] & STOP:
            found = of_face(found, x, y, vx, vy, g, last, slid, i, faces, circles, rows)
    return found


@inlined
def through_gate(found: Any, i: int, along: Any, v: Any, g: float, row: Any) -> Any:
    """Return when a ball goes back through a gate on whose line it begins, or what was found before that."""
    (dx, dy), (vx, vy), ex, ey, long = along, v, row[EX], row[EY], abs(row[PASSED])
    sign = -1.0 if row[PASSED] > 0.0 else 1.0
    rate, bend = sign * (ey * vx - ex * vy), sign * 0.5 * g * ex
    e, d = GAP * EPS * spread_of(dx, dy, 0.0, long), GAP * EPS * (abs(vx) + abs(vy))
    t, late, said = face_crossing(0.0, rate, bend, e, d, True)
    if said & STUCK:  # at once, if it turns round there
        t, late, said = max(rate, 0.0) / -bend, d / -bend, AMBIGUOUS
    on, unsure = on_face(t, late, along, v, (ex, ey, 0.0, long), g, found[1] + found[2], 0.0)
    if on:
        found = nearer(found, 2 * i + (0 if sign < 0.0 else 1), row[OWNER], t, late)
    return found[0], found[1], found[2], found[3], found[4] | said | (AMBIGUOUS if unsure else OK)


@inlined
def of_face(
    found: Any, x: float, y: float, vx: float, vy: float, g: float, last: int, slid: bool, i: int, faces: int,
    circles: int, rows: Any,
) -> Any:  # fmt: skip
    """Return the first contact with a face, or what was found before that.

    A ball without a radius that has just left something where a face begins is on the line of that face: it is on the
    side on which the body of the other one is.
    """
    row = behind(rows, WIDTH * i)
    dx, dy, ex, ey, size = x - row[PX], y - row[PY], row[EX], row[EY], row[SIZE]
    off = ey * dx - ex * dy  # along the right normal
    e, d = GAP * EPS * (abs(x) + abs(y) + spread_of(dx, dy, size, row[LONG])), GAP * EPS * (abs(vx) + abs(vy))
    beside, foot = last // 2 != i, ex * dx + ey * dy
    if beside and inside_face(off, foot, size, row[LONG], e):
        return ended(found, 2 * i, 0.0, INSIDE_WALL)
    corner, way, shut = False, 0.0, False
    if size == 0.0 and last >= 0 and beside:
        corner, way, shut = face_corner(i, x, y, vx, vy, last, faces, circles, rows)
    for k in range(2):
        sign, surface = 2.0 * k - 1.0, 2 * i + k
        if size == 0.0 and last == 2 * i + 1 - k:
            continue  # both sides are one line, and it leaves that from the other one
        if (corner and sign * way < 0.0) or (slid and beside_face(row, sign, x, y, vx, vy)):
            continue
        h, rate, bend = sign * off - size, sign * (ey * vx - ex * vy), sign * 0.5 * g * ex
        if corner or (beside and size > 0.0 and h >= -DEEP * e and foot > e and foot < row[LONG] - e):
            h = max(h, 0.0)  # rounding put it behind what it touches
        t, late, said = face_crossing(h, rate, bend, e, d, last == surface)
        if said & STUCK:
            return ended(found, surface, 0.0, said)
        face = ex, ey, size, row[LONG]
        end = found[1] + found[2]
        on, unsure = on_face(t, late, (dx, dy), (vx, vy), face, g, end, 0.0)
        if size == 0.0 and last >= 0 and t <= end + late and t < INFINITY:
            then, wide = foot_at(t, late, (dx, dy), (vx, vy), face, g)
            wide += slack_of(row, x, y)
            far = 1.0 if then > 0.5 * row[LONG] else 0.0
            if abs(then - far * row[LONG]) <= wide:
                here = corner and abs(foot - far * row[LONG]) <= wide
                side = -1.0
                if not (here and shut):
                    side = closing(last, faces, circles, rows, row, sign, far, here, wide)
                on, unsure = (side > 0.0, False) if side != 0.0 else (on, unsure)
        if on:
            found = nearer(found, surface, row[OWNER], t, late)
        found = found[0], found[1], found[2], found[3], found[4] | said | (AMBIGUOUS if unsure else OK)
    return found
