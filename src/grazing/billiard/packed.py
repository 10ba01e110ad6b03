"""The first contacts of many balls on one table, side by side: what march.py does, with loops over balls innermost.

The arithmetic is the same, operation by operation, so that times have the same bits; loops over eight balls become
vectors. What that does not settle is in doubt, and goes to :func:`grazing.billiard.contact.next_impact`, ball by ball.
"""

from __future__ import annotations

from math import floor, sqrt
from typing import Any

from grazing.billiard.contact import flight_to, is_slow, jammed, may_settle, next_impact, takes_no_time
from grazing.billiard.faces import CORNER, met_side, of_face
from grazing.billiard.flippers import FLIPPER_WIDTH, KINDS, REACH
from grazing.billiard.flippers import PX as PIVOT_X
from grazing.billiard.flippers import PY as PIVOT_Y
from grazing.billiard.gaps import (
    EPS,
    GAP,
    MISSED,
    NEAR,
    ON,
    ROOTS,
    first_guess,
    first_step,
    glance,
    lateness,
    lowest,
    nearer_root,
)
from grazing.billiard.hit import at_circle, at_line, coming, first_turning, flown, going, is_open, rows_of, struck
from grazing.billiard.march import LEAST, MOST, of_one_flipper, of_sides
from grazing.billiard.rows import (
    CIRCLES,
    EX,
    EY,
    FACES,
    FEET,
    FLIPPERS,
    GRAVITY,
    LENGTH,
    LONG,
    OWNER,
    PX,
    PY,
    SIDES,
    SIZE,
    WIDTH,
)  # fmt: skip
from grazing.billiard.workspace import LANES, F, I, W
from grazing.kernel.primitives import behind, inlined, picked, unit
from grazing.kernel.turns import eights
from grazing.kernel.vectors import listed
from grazing.outcome import ESCAPED, FATAL, OK

INFINITY = float("inf")
#: Fewer balls are asked one by one, which is quicker.
FEW = 4
#: By how much a circle is missed that is not asked for a step: a share of k, and the share of the gap's terms that is
#: left at the end, which moves a root by more than the square root of rounding.
FAR, SHARE = 1.0 - 2.0**-22, 2.0**-20
#: Looks at a circle after which a ball is in doubt.
LOOKS = 12


@unit
def contacts(w: Any, width: int, table: Any) -> None:
    """Find the first contacts of balls 0 to ``width``, a multiple of eight: SURFACE and TIME, or DOUBT."""
    g, faces, circles = table[GRAVITY], int(table[FACES]), int(table[CIRCLES])
    rows, surfaces = rows_of(table), first_turning(table)
    begin(w, width, g, surfaces)
    of_some_faces(w, width, faces, rows, g)
    around = behind(rows, WIDTH * faces)
    pairs = of_all_circles(w, width, 2 * faces, circles, around, g)
    nearest(w, width, 2 * faces, circles, pairs, around, g)
    beyond = behind(around, WIDTH * circles)
    if table[SIDES] > 0.0:
        for i in range(width):
            if not w[W.DOUBT + i] > 0.0:
                of_arcs(w, i, faces, circles, rows, beyond, g, table)
    if table[FLIPPERS] > 0.0:
        of_all_flippers(w, width, surfaces, int(table[FLIPPERS]), behind(beyond, WIDTH * int(table[SIDES])), g)
    of_other_faces(w, width, faces, circles, rows, g)


@inlined
def padded_contacts(w: Any, n: int, table: Any) -> None:
    """Find the first contacts of n balls; the last one stands for those that are missing to a multiple of eight."""
    for i in range(n):
        w[W.DOUBT + i] = 1.0
    if n >= FEW:
        repeated(w, n, W.X, W.SURFACE)
        contacts(w, (n + 7) // 8 * 8, table)


@inlined
def of_arcs(w: Any, i: int, faces: int, circles: int, rows: Any, beyond: Any, g: float, table: Any) -> None:
    """Meet sides of arcs, ball by ball."""
    x, y, vx, vy, sides = w[W.X + i], w[W.Y + i], w[W.VX + i], w[W.VY + i], int(table[SIDES])
    last = int(w[W.LAST + i])
    found = of_sides(found_of(w, i), x, y, vx, vy, g, last, -1, False, faces, circles, sides, beyond, rows)
    put_found(w, i, found)


@inlined
def of_all_flippers(w: Any, width: int, surfaces: int, flippers: int, rows: Any, g: float) -> None:
    """Meet flippers, ball by ball, those balls that may come into the circle in which a flipper is met."""
    far = 0.0
    for f in range(flippers):
        row = behind(rows, FLIPPER_WIDTH * f)
        far = max(far, abs(row[PIVOT_X]) + abs(row[PIVOT_Y]) + row[REACH])
    bounds(w, width, far, g)
    for f in range(flippers):
        row, first = behind(rows, FLIPPER_WIDTH * f), surfaces + KINDS * f
        near(w, width, row[PIVOT_X], row[PIVOT_Y], row[REACH], -2.0, g)
        for k in range(width):
            i = eights(k)
            left = (w[W.LEFT + i] >= first) & (w[W.LEFT + i] < first + KINDS)
            w[W.ONE + i] = 1.0 if ((w[W.ONE + i] > 0.0) | left) & (w[W.DOUBT + i] <= 0.0) else 0.0
        for k in range(chosen(w, width)):
            i = int(w[W.BALL + k])
            x, y, vx, vy, left = w[W.X + i], w[W.Y + i], w[W.VX + i], w[W.VY + i], int(w[W.LEFT + i]) - first
            found, clock = found_of(w, i), w[W.CLOCK + i]
            put_found(w, i, of_one_flipper(found, x, y, vx, vy, g, left, 0.0, first, clock, f, rows))


@inlined
def chosen(w: Any, width: int) -> int:
    """List the balls of which ONE is set, and return how many there are."""
    n = 0
    for b in range(0, width, 8):
        n += listed(w, W.BALL + n, W.ONE + b, 1.0 * b)
    return n


@inlined
def found_of(w: Any, i: int) -> Any:
    """Return what is found of a ball, as :func:`grazing.billiard.march.first_contact` has it."""
    return int(w[W.SURFACE + i]), w[W.TIME + i], w[W.LATE + i], w[W.WHO + i], OK


@inlined
def put_found(w: Any, i: int, found: Any) -> None:
    """Put down what is found of a ball."""
    w[W.SURFACE + i], w[W.TIME + i] = 1.0 * found[0], found[1]
    w[W.LATE + i], w[W.WHO + i] = found[2], found[3]
    w[W.DOUBT + i] = 1.0 if found[4] != OK else 0.0


@inlined
def impact_of(w: Any, i: int, table: Any) -> Any:
    """Return what :func:`grazing.billiard.contact.next_impact` does, of a ball whose contact was looked for."""
    x, y, vx, vy, left, clock = w[W.X + i], w[W.Y + i], w[W.VX + i], w[W.VY + i], w[W.LEFT + i], w[W.CLOCK + i]
    if not w[W.DOUBT + i] > 0.0:
        found = flight_to(int(w[W.SURFACE + i]), w[W.TIME + i], OK, (x, y, vx, vy), left, clock, table)
        (surface, owner, t, flags, on), before, after, speeds = found
        if owner >= 0 or flags & (FATAL | ESCAPED):  # else it begins to slide
            flags |= jammed(owner, t, flags, on, clock + t, after, table)
            return (surface, owner, t, flags, on), before, after, speeds
    return next_impact(x, y, vx, vy, left, clock, table)


@unit
def impacts(w: Any, n: int, table: Any) -> None:
    """Let n balls hit what was found: PLAIN where that is an impact, not on a flipper, and nothing else."""
    g, length, faces, round_ones = table[GRAVITY], table[LENGTH], int(table[FACES]), 2.0 * table[FACES]
    surfaces, rows, width = first_turning(table), rows_of(table), (n + 7) // 8 * 8
    feet, arcs = table[FEET] > 0.0, round_ones + table[CIRCLES]
    for i in range(width):
        w[I.PLAIN + i] = 0.0
    if n < FEW:
        return
    for i in range(n):
        surface = int(w[W.SURFACE + i])
        plain = not w[W.DOUBT + i] > 0.0 and surface >= 0 and surface < surfaces and w[W.TIME + i] < INFINITY
        plain = plain and not feet and not is_open(int(w[W.WHO + i]), table)
        surface = surface if plain else 0
        row = behind(rows, WIDTH * (surface // 2 if surface < 2 * faces else surface - faces))
        w[I.PX + i], w[I.PY + i], w[I.SIZE + i] = row[PX], row[PY], row[SIZE]
        w[I.EX + i], w[I.EY + i] = row[EX], row[EY]
        w[I.PLAIN + i] = 1.0 if plain else 0.0
    for k in range(width):
        i = eights(k)
        surface, px, py, size, plain = w[W.SURFACE + i], w[I.PX + i], w[I.PY + i], w[I.SIZE + i], w[I.PLAIN + i] > 0.0
        t, flat = picked(plain, w[W.TIME + i], 0.0), (surface < round_ones) | (not plain)
        x, y, vx, vy = flown(w[W.X + i], w[W.Y + i], w[W.VX + i], w[W.VY + i], g, t)
        side = 4.0 * (0.5 * surface - floor(0.5 * surface)) - 1.0
        ax, ay, (anx, any_, abend, omega, ux, uy) = at_line(x, y, px, py, size, w[I.EX + i], w[I.EY + i], side)
        inside = picked(surface >= arcs, w[I.EY + i], 1.0)
        cx, cy, (cnx, cny, cbend, _omega, _ux, _uy) = at_circle(
            x, y, x - 1.0 if flat else px, py, 1.0 if flat else size, inside
        )
        nx, ny, bend = anx if flat else cnx, any_ if flat else cny, abend if flat else cbend
        speed, along, _push = coming(vx, vy, (nx, ny, bend, omega, ux, uy))
        w[I.X + i], w[I.Y + i], w[I.BVX + i], w[I.BVY + i] = ax if flat else cx, ay if flat else cy, vx, vy
        w[I.NX + i], w[I.NY + i], w[I.BEND + i], w[I.SPEED + i], w[I.ALONG + i] = nx, ny, bend, speed, along
    for i in range(n):
        w[I.AWAY + i] = struck(int(w[W.WHO + i]), w[I.SPEED + i], table) if w[I.PLAIN + i] > 0.0 else 0.0
    for k in range(width):
        i = eights(k)
        before, away, along = w[I.SPEED + i], w[I.AWAY + i], w[I.ALONG + i]
        frame = w[I.NX + i], w[I.NY + i], w[I.BEND + i], 0.0, 0.0, 0.0
        _speed, _along, push = coming(0.0, 0.0, frame)
        vx, vy = going(away, along, push, frame)
        after = w[I.X + i], w[I.Y + i], vx, vy
        settles, _most, _press = may_settle(after, (before, away, along, *frame), g, length)
        slow = is_slow(w[W.LEFT + i], (w[I.BVX + i], w[I.BVY + i]), after, g, length)
        plain = (away >= 0.0) & (away < INFINITY) & (not settles) & (not slow)
        plain = plain & (not takes_no_time(w[W.TIME + i], after, g, length))
        w[I.VX + i], w[I.VY + i], w[I.PLAIN + i] = vx, vy, picked(plain, w[I.PLAIN + i], 0.0)


@inlined
def begin(w: Any, width: int, g: float, surfaces: int) -> None:
    """Begin with nothing found."""
    for k in range(width):
        i = eights(k)
        fast = abs(w[W.VX + i]) + abs(w[W.VY + i])
        fits = (abs(w[W.X + i]) + abs(w[W.Y + i]) <= MOST) & (fast <= MOST) & ((g != 0.0) | (fast >= LEAST))
        fits = fits & (w[W.LEFT + i] == floor(w[W.LEFT + i]))  # else it slides, or slid off something
        w[W.DOUBT + i] = 0.0 if fits else 1.0
        w[W.SURFACE + i], w[W.TIME + i], w[W.LATE + i], w[W.WHO + i] = -1.0, INFINITY, 0.0, -1.0
        w[W.LAST + i] = -1.0 if w[W.LEFT + i] >= surfaces else w[W.LEFT + i]


@inlined
def taken(w: Any, i: int, surface: Any, owner: float, t: float, late: float, doubt: Any) -> None:
    """Take the earlier one of what was found and another contact, see :func:`grazing.billiard.march.nearer`."""
    best, slack, hit, who = w[W.TIME + i], w[W.LATE + i], w[W.SURFACE + i], w[W.WHO + i]
    tied = t < INFINITY and hit >= 0.0 and who != owner and abs(t - best) <= late + slack
    w[W.DOUBT + i] = 1.0 if doubt or tied else w[W.DOUBT + i]
    earlier = t < best
    w[W.SURFACE + i] = 1.0 * surface if earlier else hit
    w[W.TIME + i] = t if earlier else best
    w[W.LATE + i] = late if earlier else slack
    w[W.WHO + i] = owner if earlier else who


@inlined
def of_some_faces(w: Any, width: int, faces: int, rows: Any, g: float) -> None:
    """Find contacts with the face that seems to come first."""
    wide = widest(faces, rows)
    for k in range(width):
        i = eights(k)
        w[W.STEP + i], w[W.FIRST + i] = INFINITY, -1.0
        w[F.FACE + i], w[F.SIGN + i] = side_of(w[W.LAST + i])
        w[F.ERROR + i] = 2.0 * GAP * EPS * (abs(w[W.X + i]) + abs(w[W.Y + i]) + wide)
    for f in range(faces):
        guess_face(w, width, f, behind(rows, WIDTH * f), g)
    for i in range(width):
        row = behind(rows, WIDTH * (int(max(w[W.FIRST + i], 0.0)) // 2))
        w[W.DX + i], w[W.DY + i], w[W.PSIZE + i] = w[W.X + i] - row[PX], w[W.Y + i] - row[PY], row[SIZE]
        w[W.PEX + i], w[W.PEY + i], w[W.PEND + i], w[W.PWHO + i] = row[EX], row[EY], row[LONG], row[OWNER]
    meet_face(w, width, g)


@inlined
def widest(faces: int, rows: Any) -> float:
    """Return what the sizes of which gaps of faces are made are not greater than, but for the place of the ball."""
    wide = 0.0
    for f in range(faces):
        row = behind(rows, WIDTH * f)
        wide = max(wide, abs(row[PX]) + abs(row[PY]) + row[SIZE] + abs(row[LONG]))
    return wide


@inlined
def side_of(surface: float) -> Any:
    """Return the face of a surface, and 1 for its right side, -1 for its left one."""
    face = floor(0.5 * surface)
    return face, 4.0 * (0.5 * surface - face) - 1.0


@inlined
def of_other_faces(w: Any, width: int, faces: int, circles: int, rows: Any, g: float) -> None:
    """Meet those faces, ball by ball, of which it is not sure that what was found comes before."""
    flights(w, width, widest(faces, rows), g)
    for f in range(faces):
        if not pass_face(w, width, f, behind(rows, WIDTH * f)):
            continue
        for i in range(width):
            if w[W.ONE + i] > 0.0 and not w[W.DOUBT + i] > 0.0:
                x, y, vx, vy, last = w[W.X + i], w[W.Y + i], w[W.VX + i], w[W.VY + i], int(w[W.LAST + i])
                found = of_face(found_of(w, i), x, y, vx, vy, g, last, False, f, faces, circles, rows)
                put_found(w, i, found)


@inlined
def flights(w: Any, width: int, wide: float, g: float) -> None:
    """Set what :func:`pass_face` asks for of the flights up to what was found; ``wide`` is from :func:`widest`."""
    for k in range(width):
        i = eights(k)
        x, y, vx, vy, end = w[W.X + i], w[W.Y + i], w[W.VX + i], w[W.VY + i], w[W.TIME + i] + w[W.LATE + i]
        t = picked(end < INFINITY, end, 0.0)
        face, sign = side_of(w[W.LAST + i])
        w[F.MET + i], _side = side_of(w[W.SURFACE + i])
        speed, fallen = abs(vx) + abs(vy) + g * t, vy - g * t
        unsure = CORNER * GAP * EPS * (2.0 * (abs(x) + abs(y)) + wide + speed * t)
        unsure = picked(end < INFINITY, unsure, INFINITY)
        w[F.FACE + i], w[F.X + i], w[F.Y + i] = face, x + vx * t, y + (vy - 0.5 * g * t) * t
        w[F.VX + i], w[F.VY + i], w[F.FALLEN + i] = sign * vx, sign * vy, sign * fallen
        w[F.BOW + i], w[F.UNSURE + i] = 0.125 * g * t * t + unsure, unsure
        w[F.RATE + i] = picked(end < INFINITY, 4.0 * GAP * EPS * speed, INFINITY)


@inlined
def guess_face(w: Any, width: int, f: int, row: Any, g: float) -> None:
    """Guess when the side of a face is met on which a ball is, as :func:`grazing.billiard.faces.guess`: STEP and FIRST.

    In doubt is a ball that just left that side, and bounces by less than can be told of any face.
    """
    px, py, ex, ey, size, long = row[PX], row[PY], row[EX], row[EY], row[SIZE], row[LONG]
    face, pull = 1.0 * f, 2.0 * g * ex
    for k in range(width):
        i = eights(k)
        dx, dy, vx, vy, fresh = w[W.X + i] - px, w[W.Y + i] - py, w[W.VX + i], w[W.VY + i], w[F.FACE + i] == face
        off = ey * dx - ex * dy
        sign = picked(fresh, w[F.SIGN + i], 1.0 if off >= 0.0 else -1.0)
        h, dh, bend = picked(fresh, 0.0, sign * off - size), sign * (ey * vx - ex * vy), sign * pull  # four times that
        D, down = dh * dh - bend * h, (dh < 0.0) & (not fresh)
        meets, root = (D >= 0.0) & (down | (bend < 0.0)), sqrt(max(D, 0.0))
        over, under = picked(down, 2.0 * h, -2.0 * (dh + root)), picked(down, root - dh, bend)
        t, soonest = over / picked(meets, under, 1.0), w[W.STEP + i]
        foot = ex * (dx + vx * t) + ey * (dy + (vy - 0.5 * g * t) * t)
        sooner = meets & (t >= 0.0) & (foot >= 0.0) & (foot <= long) & (t < soonest)
        w[W.STEP + i] = picked(sooner, t, soonest)
        w[W.FIRST + i] = picked(sooner, picked(sign > 0.0, 2.0 * face + 1.0, 2.0 * face), w[W.FIRST + i])
        w[W.DOUBT + i] = picked(fresh & (dh * dh < -bend * w[F.ERROR + i]), 1.0, w[W.DOUBT + i])


@inlined
def meet_face(w: Any, width: int, g: float) -> None:
    """Take the side of a face that a ball seems to meet first, if there is one and it is met beyond doubt."""
    for k in range(width):
        i = eights(k)
        along, v = (w[W.DX + i], w[W.DY + i]), (w[W.VX + i], w[W.VY + i])
        face, side = (w[W.PEX + i], w[W.PEY + i], w[W.PSIZE + i], w[W.PEND + i]), w[W.FIRST + i]
        sure, t, late = met_side(along, v, face, g, side, w[W.LAST + i], abs(w[W.X + i]) + abs(w[W.Y + i]))
        met = sure & (side >= 0.0)
        w[W.SURFACE + i], w[W.TIME + i] = picked(met, side, -1.0), picked(met, t, INFINITY)
        w[W.LATE + i], w[W.WHO + i] = picked(met, late, 0.0), picked(met, w[W.PWHO + i], -1.0)


@inlined
def pass_face(w: Any, width: int, f: int, row: Any) -> Any:
    """Set ONE where it is not sure that a face is not met before what was found, unless it is that; say if any.

    What is surely passed is so for :func:`grazing.billiard.faces.passes`, too: errors are here those of any face.
    """
    px, py, ex, ey, size, long, face = row[PX], row[PY], row[EX], row[EY], row[SIZE], row[LONG], 1.0 * f
    for k in range(width):
        i = eights(k)
        dx, dy, fx, fy = w[W.X + i] - px, w[W.Y + i] - py, w[F.X + i] - px, w[F.Y + i] - py
        bow, unsure = w[F.BOW + i], w[F.UNSURE + i]
        off, then, foot, thence = ey * dx - ex * dy, ey * fx - ex * fy, ex * dx + ey * dy, ex * fx + ey * fy
        away = max(min(off, then), -max(off, then)) > abs(ex) * bow + unsure + size
        beside = max(min(foot, thence) - long, -max(foot, thence)) > abs(ey) * bow + unsure
        across = ey * w[F.VX + i]
        leaves = min(across - ex * w[F.VY + i], across - ex * w[F.FALLEN + i]) > w[F.RATE + i]
        passed = away | beside | (leaves & (w[F.FACE + i] == face)) | (w[F.MET + i] == face)
        w[W.ONE + i] = 0.0 if passed else 1.0
    some = 0
    for k in range(width):
        some |= 1 if w[W.ONE + eights(k)] > 0.0 else 0
    return some != 0


@inlined
def repeated(w: Any, n: int, first: int, last: int) -> None:
    """Repeat the last of n numbers of some rows until they are a multiple of eight."""
    for i in range(n, (n + 7) // 8 * 8):
        for row in range(first, last, LANES):
            w[row + i] = w[row + n - 1]


@inlined
def of_all_circles(w: Any, width: int, base: int, circles: int, rows: Any, g: float) -> int:
    """Ask how long circles are surely not met: the least STEP and its pair. Return how many pairs are on the list.

    Those are all pairs of a ball and a circle that may be met before what was found, each with its own step.
    """
    far = 0.0
    for c in range(circles):
        row = behind(rows, WIDTH * c)
        far = max(far, abs(row[PX]) + abs(row[PY]) + row[SIZE])
    bounds(w, width, far, g)
    n, first, steps = 0, 0, W.PAIRS + LANES * circles
    for c in range(circles):
        row, before = behind(rows, WIDTH * c), n
        px, py, size, surface = row[PX], row[PY], row[SIZE], 1.0 * (base + c)
        near(w, width, px, py, size, surface, g)
        for b in range(0, width, 8):
            n += listed(w, W.PAIRS + n, W.ONE + b, 1.0 * (LANES * c + b))
        if n - first > LANES:
            first_steps(w, first, before - first, steps, g)
            first = before
        for k in range(before - first, n - first):
            i = int(w[W.PAIRS + first + k]) - LANES * c
            gather(w, k, i, px, py, size)
            w[W.PEX + k], w[W.PEY + k] = w[W.PART + i], 1.0 if w[W.LAST + i] == surface else 0.0
    first_steps(w, first, n - first, steps, g)
    return n


def bounds(w: Any, width: int, far: float, g: float) -> None:
    """Set what :func:`near` asks for of each ball, for circles no part of which is further away than ``far``."""
    for k in range(width):
        i = eights(k)
        vx, vy, end = w[W.VX + i], w[W.VY + i], w[W.TIME + i] + w[W.LATE + i]
        fast, least = vx * vx + vy * vy, lowest(-g * vy, 0.25 * g * g, end)
        w[W.PART + i], w[W.STEP + i], w[W.END + i], w[W.FIRST + i] = fast + least, end, end, -1.0
        reach, speed = abs(w[W.X + i]) + abs(w[W.Y + i]) + far, abs(vx) + abs(vy)
        error = GAP * EPS * (3.0 * fast - least + g * reach)
        w[W.FALL + i], w[W.BEND + i] = GAP * EPS * reach * speed, FAR * (fast + least - 2.0 * error)
        w[W.SPARE + i] = SHARE * (2.0 * reach * speed + (fast - least + g * reach) * end) * end


def near(w: Any, width: int, px: float, py: float, size: float, surface: float, g: float) -> None:
    """Set ONE for those balls that may meet a circle before what was found.

    For others :func:`grazing.billiard.gaps.first_step` has no root, or one that is later by far more than rounding. A
    circle that was just left has none where k is not negative.
    """
    size2, pull = (1.0 + 4.0 * GAP * EPS) * size * size, FAR * g
    for k in range(width):
        i = eights(k)
        dx, dy, end = w[W.X + i] - px, w[W.Y + i] - py, w[W.END + i]
        h = (1.0 - 4.0 * GAP * EPS) * (dx * dx + dy * dy) - size2
        half, bend = dx * w[W.VX + i] + dy * w[W.VY + i] - w[W.FALL + i], w[W.BEND + i] - pull * dy
        then = half + bend * end
        up, misses = bend >= 0.0, (half * half < bend * h) | (half >= 0.0)
        later = (h + (half + then) * end >= w[W.SPARE + i]) & ((bend <= 0.0) | (then <= 0.0))
        left, clear = w[W.LAST + i] == surface, (h > 0.0) & ((misses & up) | later)
        w[W.ONE + i] = 0.0 if (left & up) | (clear & (not left)) else 1.0


def first_steps(w: Any, first: int, n: int, steps: int, g: float) -> None:
    """Ask of pairs on the list, which were gathered, how long they are surely apart."""
    repeated(w, n, W.DX, W.PWHO)
    for k in range((n + 7) // 8 * 8):
        i = eights(k)
        step, said = first_step(
            w[W.DX + i], w[W.DY + i], w[W.PVX + i], w[W.PVY + i], g, w[W.PSIZE + i], w[W.PEY + i] > 0.0, w[W.PEX + i]
        )
        w[steps + first + i], w[W.SAID + i] = step, 1.0 if said != OK else 0.0
    for k in range(n):
        pair = w[W.PAIRS + first + k]
        i, step = int(pair) % LANES, w[steps + first + k]
        least = w[W.STEP + i]
        w[W.FIRST + i if step < least else W.S] = pair  # without a branch
        w[W.STEP + i] = min(least, step)
    doubt = 0
    for k in range((n + 7) // 8 * 8):
        doubt |= 1 if w[W.SAID + eights(k)] > 0.0 else 0
    for k in range(n if doubt != 0 else 0):
        i = int(w[W.PAIRS + first + k]) % LANES
        w[W.DOUBT + i] = max(w[W.DOUBT + i], w[W.SAID + k])


@inlined
def gather(w: Any, k: int, i: int, px: float, py: float, size: float) -> None:
    """Put a ball as seen from a circle to a place."""
    w[W.DX + k], w[W.DY + k], w[W.PSIZE + k] = w[W.X + i] - px, w[W.Y + i] - py, size
    w[W.PVX + k], w[W.PVY + k] = w[W.VX + i], w[W.VY + i]


def nearest(w: Any, width: int, base: int, circles: int, pairs: int, rows: Any, g: float) -> None:
    """March to circles, the nearest one of each ball first: it brings the end forward for all others on the list."""
    for k in range(width):
        i = eights(k)
        w[W.ONE + i] = 1.0 if (w[W.FIRST + i] >= 0.0) & (w[W.DOUBT + i] <= 0.0) else 0.0
    n = chosen(w, width)
    for k in range(n):
        i = int(w[W.BALL + k])
        w[W.BALL + k], w[W.PTIME + k] = w[W.FIRST + i], w[W.STEP + i]
    march(w, n, base, rows, g)
    for k in range(width):
        i = eights(k)
        w[W.END + i] = w[W.TIME + i] + w[W.LATE + i] if w[W.DOUBT + i] <= 0.0 else -INFINITY
    n = 0
    for k in range(pairs):
        pair, step = w[W.PAIRS + k], w[W.PAIRS + LANES * circles + k]
        i = int(pair) % LANES
        w[W.BALL + n], w[W.PTIME + n] = pair, step
        n += int((step < w[W.END + i]) & (w[W.FIRST + i] != pair))
        if n == LANES:
            march(w, n, base, rows, g)
            n = 0
    march(w, n, base, rows, g)


def march(w: Any, n: int, base: int, rows: Any, g: float) -> None:
    """March from some balls to circles, as :func:`grazing.billiard.gaps.crossing` does, and take what is found."""
    for k in range(n):
        pair = int(w[W.BALL + k])
        i, row = pair % LANES, behind(rows, WIDTH * (pair // LANES))
        gather(w, k, i, row[PX], row[PY], row[SIZE])
        w[W.PEND + k], w[W.WHAT + k], w[W.SAID + k] = w[W.END + i], 1.0 * ON, 0.0
    repeated(w, n, W.DX, W.PEX)
    looked_at(w, padded(w, n), g)
    m = 0
    for b in range(0, n, 8):
        for k in range(8):
            i = b + eights(k)
            w[W.ONE + i] = 0.0 if w[W.WHAT + i] == MISSED else 1.0
        m += listed(w, W.S + m, W.ONE + b, 1.0 * b)
    for k in range(m):
        i = int(w[W.S + k])
        w[W.BALL + k] = w[W.BALL + i]
        for row in range(W.PTIME, W.PEND, LANES):
            w[row + k] = w[row + i]
        for row in range(W.WHAT, W.S, LANES):
            w[row + k] = w[row + i]
    landed(w, padded(w, m), g)
    for k in range(m):
        pair = int(w[W.BALL + k])
        i, c = pair % LANES, pair // LANES
        t, doubt = arrival(w, k)
        taken(w, i, base + c, rows[WIDTH * c + OWNER], t, w[W.PLATE + k], doubt)


@inlined
def padded(w: Any, n: int) -> int:
    """Return the multiple of eight from n on; what is there beside n circles is MISSED."""
    for k in range(n, (n + 7) // 8 * 8):
        w[W.WHAT + k] = 1.0 * MISSED
    return (n + 7) // 8 * 8


@inlined
def arrival(w: Any, k: int) -> Any:
    """Return (t, doubt): when a circle is met by what is known of it, infinity for never."""
    doubt = (w[W.SAID + k] > 0.0) | (w[W.WHAT + k] == ON)
    return INFINITY if doubt or w[W.WHAT + k] == MISSED else w[W.PTIME + k], doubt


@inlined
def looked_at(w: Any, n: int, g: float) -> None:
    """Look at circles, eight at a time, until nothing is to be looked at again."""
    for _ in range(LOOKS):
        some = False
        for b in range(0, n, 8):  # one after the other: a processor then works on several
            if any_of(w, b, W.WHAT, 1.0 * ON):
                look_at(w, b, g)
                some = True
        if not some:
            break


@inlined
def look_at(w: Any, b: int, g: float) -> None:
    """Look at eight circles, of which some are to be looked at."""
    for k in range(8):
        i = b + eights(k)
        begin, on = w[W.PTIME + i], w[W.WHAT + i] == ON
        (what, t, doubt), (h, dh, bend, c3, reach), (error, rate) = glance(
            w[W.DX + i], w[W.DY + i], w[W.PVX + i], w[W.PVY + i], g, w[W.PSIZE + i], begin, w[W.PEND + i]
        )
        w[W.PTIME + i] = picked(on, t, begin)
        w[W.PLATE + i], w[W.RATE + i] = picked(on, error, w[W.PLATE + i]), picked(on, rate, w[W.RATE + i])
        w[W.H + i], w[W.DH + i] = picked(on, h, w[W.H + i]), picked(on, dh, w[W.DH + i])
        w[W.K + i], w[W.C3 + i] = picked(on, bend, w[W.K + i]), picked(on, c3, w[W.C3 + i])
        w[W.REACH + i] = picked(on, reach, w[W.REACH + i])
        w[W.SAID + i] = picked(on & doubt, 1.0, w[W.SAID + i])
        w[W.WHAT + i] = picked(on, 1.0 * what, w[W.WHAT + i])


@inlined
def landed(w: Any, n: int, g: float) -> None:
    """Bring flights down to where they are seen to land, as :func:`grazing.billiard.gaps.landing` does."""
    for k in range(n):
        i = eights(k)
        near = w[W.WHAT + i] == NEAR
        w[W.S + i] = first_guess(w[W.H + i], w[W.DH + i], w[W.K + i], w[W.REACH + i]) if near else 0.0
        w[W.A + i], w[W.B + i], w[W.GOING + i] = 0.0, w[W.REACH + i] if near else 0.0, 1.0
    for _ in range(ROOTS):
        some = False
        for b in range(0, n, 8):
            if w[W.GOING + b] > 0.0:
                going = go_on(w, b, g)
                w[W.GOING + b] = 1.0 if going else 0.0
                some = some or going
        if not some:
            break
    for k in range(n):
        i = eights(k)
        begin, rate = w[W.PTIME + i], -1.0 if w[W.WHAT + i] == MISSED else w[W.RATE + i]
        w[W.PLATE + i] = lateness(w[W.PLATE + i], rate, begin)
        w[W.PTIME + i] = begin + w[W.S + i]


@inlined
def go_on(w: Any, b: int, g: float) -> Any:
    """Take a step of Newton's method for eight flights; say whether one of them is still to be brought down.

    The others stay where they are: there is nothing between their bounds.
    """
    some = 0
    for k in range(8):
        i = b + eights(k)
        s, low, high, done = nearer_root(
            w[W.S + i], w[W.A + i], w[W.B + i], w[W.H + i], w[W.DH + i], w[W.K + i], w[W.C3 + i], 0.25 * g * g
        )
        w[W.S + i], w[W.A + i], w[W.B + i] = s, s if done else low, s if done else high
        some |= 0 if done else 1
    return some != 0


@inlined
def any_of(w: Any, b: int, row: int, value: float) -> Any:
    """Say whether one of eight numbers of a row is the value."""
    found = 0
    for k in range(8):
        found |= 1 if w[row + b + eights(k)] == value else 0
    return found != 0
