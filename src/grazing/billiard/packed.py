"""The first contacts of many balls on one table, side by side: what march.py does, with loops over balls innermost.

The arithmetic is the same, operation by operation, so that times have the same bits; loops over eight balls become
vectors. What that does not settle is in doubt, and goes to :func:`grazing.billiard.contact.next_impact`, ball by ball.
"""

from __future__ import annotations

from math import floor
from typing import Any

from grazing.billiard.contact import flight_to, jammed, next_impact
from grazing.billiard.faces import guess, met_side, of_face, passes
from grazing.billiard.gaps import (
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
from grazing.billiard.hit import first_turning, rows_of
from grazing.billiard.march import LEAST, MOST, of_flippers, of_sides
from grazing.billiard.rows import CIRCLES, EX, EY, FACES, FLIPPERS, GRAVITY, LONG, OWNER, PX, PY, SIDES, SIZE, WIDTH
from grazing.billiard.workspace import LANES, W
from grazing.kernel.primitives import behind, inlined, unit
from grazing.kernel.turns import eights
from grazing.outcome import ESCAPED, FATAL, OK

INFINITY = float("inf")
#: Fewer balls are asked one by one, which is quicker.
FEW = 4
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
    of_all_circles(w, width, 2 * faces, circles, around, g)
    nearest(w, width, 2 * faces, circles, around, g)
    if table[SIDES] + table[FLIPPERS] > 0.0:
        for i in range(width):
            if not w[W.DOUBT + i] > 0.0:
                of_others(w, i, faces, circles, rows, around, surfaces, g, table)
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
def of_others(
    w: Any, i: int, faces: int, circles: int, rows: Any, around: Any, surfaces: int, g: float, table: Any
) -> None:  # fmt: skip
    """Meet arcs and flippers, ball by ball."""
    x, y, vx, vy, sides = w[W.X + i], w[W.Y + i], w[W.VX + i], w[W.VY + i], int(table[SIDES])
    found = int(w[W.SURFACE + i]), w[W.TIME + i], w[W.LATE + i], w[W.WHO + i], OK
    beyond = behind(around, WIDTH * circles)
    found = of_sides(found, x, y, vx, vy, g, int(w[W.LAST + i]), -1, False, faces, circles, sides, beyond, rows)
    if found[4] == OK:
        turns, beyond = int(w[W.LEFT + i]) - surfaces, behind(beyond, WIDTH * sides)
        found = of_flippers(found, x, y, vx, vy, g, turns, 0.0, surfaces, w[W.CLOCK + i], int(table[FLIPPERS]), beyond)
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


@inlined
def begin(w: Any, width: int, g: float, surfaces: int) -> None:
    """Begin with nothing found."""
    for k in range(width):
        i = eights(k)
        fast = abs(w[W.VX + i]) + abs(w[W.VY + i])
        fits = abs(w[W.X + i]) + abs(w[W.Y + i]) <= MOST and fast <= MOST and (g != 0.0 or fast >= LEAST)
        fits = fits and w[W.LEFT + i] == floor(w[W.LEFT + i])  # else it slides, or slid off something
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
    for k in range(width):
        i = eights(k)
        w[W.STEP + i], w[W.FIRST + i] = INFINITY, -1.0
    for f in range(faces):
        guess_face(w, width, f, behind(rows, WIDTH * f), g)
    for i in range(width):
        row = behind(rows, WIDTH * (int(max(w[W.FIRST + i], 0.0)) // 2))
        w[W.DX + i], w[W.DY + i], w[W.PSIZE + i] = w[W.X + i] - row[PX], w[W.Y + i] - row[PY], row[SIZE]
        w[W.PEX + i], w[W.PEY + i], w[W.PEND + i], w[W.PWHO + i] = row[EX], row[EY], row[LONG], row[OWNER]
    meet_face(w, width, g)


@inlined
def of_other_faces(w: Any, width: int, faces: int, circles: int, rows: Any, g: float) -> None:
    """Meet those faces, ball by ball, of which it is not sure that what was found comes before."""
    for f in range(faces):
        if not pass_face(w, width, f, behind(rows, WIDTH * f), g):
            continue
        for i in range(width):
            if w[W.ONE + i] > 0.0 and not w[W.DOUBT + i] > 0.0:
                x, y, vx, vy, last = w[W.X + i], w[W.Y + i], w[W.VX + i], w[W.VY + i], int(w[W.LAST + i])
                found = int(w[W.SURFACE + i]), w[W.TIME + i], w[W.LATE + i], w[W.WHO + i], OK
                found = of_face(found, x, y, vx, vy, g, last, False, f, faces, circles, rows)
                w[W.SURFACE + i], w[W.TIME + i] = 1.0 * found[0], found[1]
                w[W.LATE + i], w[W.WHO + i] = found[2], found[3]
                w[W.DOUBT + i] = 1.0 if found[4] != OK else 0.0


@inlined
def guess_face(w: Any, width: int, f: int, row: Any, g: float) -> None:
    """Guess when the side of a face is met on which a ball is: STEP and FIRST."""
    px, py, ex, ey, size, long = row[PX], row[PY], row[EX], row[EY], row[SIZE], row[LONG]
    for k in range(width):
        i = eights(k)
        along, v, left = (w[W.X + i] - px, w[W.Y + i] - py), (w[W.VX + i], w[W.VY + i]), 2.0 * f
        t, surface, stuck = guess(along, v, (ex, ey, size, long), g, left, left + 1.0, w[W.LAST + i])
        w[W.DOUBT + i] = 1.0 if stuck else w[W.DOUBT + i]
        soonest = w[W.STEP + i]
        w[W.STEP + i] = t if t < soonest else soonest
        w[W.FIRST + i] = surface if t < soonest else w[W.FIRST + i]


@inlined
def meet_face(w: Any, width: int, g: float) -> None:
    """Take the side of a face that a ball seems to meet first, if there is one and it is met beyond doubt."""
    for k in range(width):
        i = eights(k)
        along, v = (w[W.DX + i], w[W.DY + i]), (w[W.VX + i], w[W.VY + i])
        face, side = (w[W.PEX + i], w[W.PEY + i], w[W.PSIZE + i], w[W.PEND + i]), w[W.FIRST + i]
        sure, t, late = met_side(along, v, face, g, side, w[W.LAST + i], abs(w[W.X + i]) + abs(w[W.Y + i]))
        met = sure and side >= 0.0
        w[W.SURFACE + i], w[W.TIME + i] = side if met else -1.0, t if met else INFINITY
        w[W.LATE + i], w[W.WHO + i] = late if met else 0.0, w[W.PWHO + i] if met else -1.0


@inlined
def pass_face(w: Any, width: int, f: int, row: Any, g: float) -> Any:
    """Set ONE where it is not sure that a face is not met before what was found, unless it is that; say if any."""
    px, py, ex, ey, size, long = row[PX], row[PY], row[EX], row[EY], row[SIZE], row[LONG]
    for k in range(width):
        i = eights(k)
        x, y, left = w[W.X + i], w[W.Y + i], 2.0 * f
        along, v, far = (x - px, y - py), (w[W.VX + i], w[W.VY + i]), abs(x) + abs(y)
        end, itself = w[W.TIME + i] + w[W.LATE + i], w[W.SURFACE + i] == left or w[W.SURFACE + i] == left + 1.0
        passed = passes(along, v, (ex, ey, size, long), g, left, left + 1.0, w[W.LAST + i], end, far)
        w[W.ONE + i] = 0.0 if passed or itself else 1.0
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
def of_all_circles(w: Any, width: int, base: int, circles: int, rows: Any, g: float) -> None:
    """Ask how long all circles are surely not met: STEPS, the least of them and its circle."""
    for k in range(width):
        i = eights(k)
        vx, vy, end = w[W.VX + i], w[W.VY + i], w[W.TIME + i] + w[W.LATE + i]
        w[W.PART + i] = vx * vx + vy * vy + lowest(-g * vy, 0.25 * g * g, end)
        w[W.STEP + i], w[W.SECOND + i], w[W.FIRST + i] = end, end, -1.0
    for c in range(circles):
        row = behind(rows, WIDTH * c)
        px, py, size, surface, at = row[PX], row[PY], row[SIZE], 1.0 * (base + c), W.STEPS + LANES * c
        for k in range(width):
            i = eights(k)
            fresh = w[W.LAST + i] == surface
            dx, dy, vx, vy = w[W.X + i] - px, w[W.Y + i] - py, w[W.VX + i], w[W.VY + i]
            step, said = first_step(dx, dy, vx, vy, g, size, fresh, w[W.PART + i])
            least = w[W.STEP + i]
            w[W.SECOND + i] = least if step < least else min(w[W.SECOND + i], step)
            w[W.FIRST + i] = 1.0 * c if step < least else w[W.FIRST + i]
            w[W.STEP + i] = step if step < least else least
            w[W.ONE + i] = step
            w[W.DOUBT + i] = 1.0 if said != OK else w[W.DOUBT + i]
        for i in range(width):
            w[at + i] = w[W.ONE + i]


def nearest(w: Any, width: int, base: int, circles: int, rows: Any, g: float) -> None:
    """March to circles, the nearest one first: it brings the end forward for all others."""
    n = 0
    for i in range(width):
        w[W.BALL + n], w[W.CIRCLE + n], w[W.END + i] = 1.0 * i, w[W.FIRST + i], w[W.TIME + i] + w[W.LATE + i]
        n += 1 if w[W.FIRST + i] >= 0.0 and not w[W.DOUBT + i] > 0.0 else 0
    march(w, n, base, rows, g)
    n = 0
    for i in range(width):
        w[W.END + i] = w[W.TIME + i] + w[W.LATE + i]
        if not w[W.SECOND + i] < w[W.END + i] or w[W.DOUBT + i] > 0.0:
            continue
        for c in range(circles):
            w[W.BALL + n], w[W.CIRCLE + n] = 1.0 * i, 1.0 * c
            n += 1 if w[W.STEPS + LANES * c + i] < w[W.END + i] and w[W.FIRST + i] != c else 0
            if n == LANES:
                march(w, n, base, rows, g)
                n = 0
    march(w, n, base, rows, g)


def march(w: Any, n: int, base: int, rows: Any, g: float) -> None:
    """March to all circles on the list, as :func:`grazing.billiard.gaps.crossing` does, and take what is found."""
    repeated(w, n, W.BALL, W.DX)
    padded = (n + 7) // 8 * 8
    for k in range(padded):
        i, c = int(w[W.BALL + k]), int(w[W.CIRCLE + k])
        row = behind(rows, WIDTH * c)
        w[W.DX + k], w[W.DY + k], w[W.PSIZE + k] = w[W.X + i] - row[PX], w[W.Y + i] - row[PY], row[SIZE]
        w[W.PVX + k], w[W.PVY + k], w[W.PEND + k] = w[W.VX + i], w[W.VY + i], w[W.END + i]
        w[W.PTIME + k] = w[W.STEPS + LANES * c + i]
    looked_at(w, padded, g)
    landed(w, padded, g)
    for k in range(n):
        i, c = int(w[W.BALL + k]), int(w[W.CIRCLE + k])
        what, t = w[W.WHAT + k], w[W.PTIME + k]
        doubt = w[W.SAID + k] > 0.0 or what == ON
        t = INFINITY if what == MISSED or doubt else t
        taken(w, i, base + c, rows[WIDTH * c + OWNER], t, w[W.PLATE + k], doubt)


@inlined
def looked_at(w: Any, n: int, g: float) -> None:
    """Look at circles, eight at a time, until nothing is to be looked at again."""
    for k in range(n):
        w[W.WHAT + eights(k)], w[W.SAID + eights(k)] = 1.0 * ON, 0.0
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
        w[W.PTIME + i] = t if on else begin
        w[W.PLATE + i], w[W.RATE + i] = error if on else w[W.PLATE + i], rate if on else w[W.RATE + i]
        w[W.H + i], w[W.DH + i] = h if on else w[W.H + i], dh if on else w[W.DH + i]
        w[W.K + i], w[W.C3 + i] = bend if on else w[W.K + i], c3 if on else w[W.C3 + i]
        w[W.REACH + i] = reach if on else w[W.REACH + i]
        w[W.SAID + i] = 1.0 if on and doubt else w[W.SAID + i]
        w[W.WHAT + i] = 1.0 * what if on else w[W.WHAT + i]


@inlined
def landed(w: Any, n: int, g: float) -> None:
    """Bring flights down to where they are seen to land, as :func:`grazing.billiard.gaps.landing` does."""
    for k in range(n):
        i = eights(k)
        near = w[W.WHAT + i] == NEAR
        w[W.S + i] = first_guess(w[W.H + i], w[W.DH + i], w[W.K + i], w[W.REACH + i]) if near else 0.0
        w[W.A + i], w[W.B + i], w[W.GOING + i] = 0.0, w[W.REACH + i], 1.0 if near else 0.0
    for _ in range(ROOTS):
        some = 0
        for k in range(n):
            i = eights(k)
            old, going = w[W.S + i], w[W.GOING + i] > 0.0
            s, low, high, done = nearer_root(
                old, w[W.A + i], w[W.B + i], w[W.H + i], w[W.DH + i], w[W.K + i], w[W.C3 + i], 0.25 * g * g
            )
            w[W.S + i], w[W.A + i], w[W.B + i] = s if going else old, low, high
            w[W.GOING + i] = 0.0 if done else w[W.GOING + i]
            some |= 1 if going and not done else 0
        if some == 0:
            break
    for k in range(n):
        i = eights(k)
        begin = w[W.PTIME + i]
        w[W.PLATE + i] = lateness(w[W.PLATE + i], w[W.RATE + i], begin)
        w[W.PTIME + i] = begin + w[W.S + i]


@inlined
def any_of(w: Any, b: int, row: int, value: float) -> Any:
    """Say whether one of eight numbers of a row is the value."""
    found = 0
    for k in range(8):
        found |= 1 if w[row + b + eights(k)] == value else 0
    return found != 0
