"""The first contact of one flight in exact arithmetic: what double precision cannot decide.

Along a parabola the gap of every surface of a table is a polynomial of degree two or four, and its coefficients are
rational, as doubles are. Its real roots come isolated, with multiplicities: a root of odd multiplicity at which it
falls is a contact, one of even multiplicity a graze. The order of two surfaces is that of isolated roots. Flippers that
turn are in :mod:`grazing.billiard.turning_exact`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from fractions import Fraction
from math import inf, nextafter

import numpy as np
from flint import fmpq, fmpq_poly
from numpy.typing import NDArray

from grazing.billiard.faces import at_sunk, beside_face, body_of, closing, end_of_arc, face_corner, slack_of, sunk
from grazing.billiard.gaps import DEEP
from grazing.billiard.hit import away_of
from grazing.billiard.joints import at_joints, bare
from grazing.billiard.march import beside_circle, side_corner
from grazing.billiard.roots import (
    SHARE,
    Gap,
    Root,
    Undecided,
    beside,
    exact,
    inside,
    joined,
    made,
    precision,
    roots_of,
    same,
)
from grazing.billiard.rows import (
    CIRCLES,
    COSINE,
    EX,
    EY,
    FACES,
    FLIPPERS,
    GRAVITY,
    HEAD,
    LONG,
    MX,
    MY,
    OWNER,
    PASSED,
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
from grazing.billiard.turning_exact import slips_off, turning_roots
from grazing.outcome import AMBIGUOUS, GRAZE, OK

Floats = NDArray[np.float64]
#: Bits of precision that are tried in turn; roots of such polynomials that differ at all differ within the last.
BITS = (128, 512, 2048, 8192)


def gaps_of(block: Floats, state: tuple[float, ...], left: int, slid: bool = False) -> Iterator[Gap]:
    """Yield the gaps of all surfaces along the flight from a state; ``slid``: it slid off the surface that it left."""
    (x, y, vx, vy), (x0, y0, vx0, vy0) = map(exact, state), state
    fall = -exact(block[GRAVITY]) / 2
    faces, circles, sides = (int(block[i]) for i in (FACES, CIRCLES, SIDES))
    rows = block[HEAD + THING * int(block[THINGS]) :]
    for i in range(faces + circles + sides):
        row = rows[WIDTH * i : WIDTH * (i + 1)]
        dx, dy = fmpq_poly([x - exact(row[PX]), vx]), fmpq_poly([y - exact(row[PY]), vy, fall])
        within: tuple[fmpq_poly, ...]
        owner, size = int(row[OWNER]), fmpq_poly([exact(row[SIZE])])
        scale = abs(x0 - row[PX]) + abs(y0 - row[PY]) + row[SIZE]
        spread = abs(x0) + abs(y0) + scale
        if slid and i < faces and left // 2 == i:
            continue
        if i < faces:
            ex, ey = exact(row[EX]), exact(row[EY])
            off, foot = ey * dx - ex * dy, ex * dx + ey * dy
            within = foot, fmpq_poly([exact(row[LONG])]) - foot
            if row[LONG] < 0.0:  # it has just gone through that gate, and may go back
                side, sign = (0, -1) if row[PASSED] > 0.0 else (1, 1)
                within = foot, fmpq_poly([exact(abs(row[PASSED]))]) - foot
                yield made(2 * i + side, owner, sign * off, within, True, spread, scale)
                continue
            bare, slack = left >= 0 and left // 2 != i and row[SIZE] == 0.0, slack_of(row, x0, y0)
            corner, way, shut = False, 0.0, False
            if bare:
                corner, way, shut = face_corner(i, x0, y0, vx0, vy0, left, faces, circles, rows)
            for side, sign in enumerate((-1, 1)):
                surface = 2 * i + side
                if (corner and sign * way < 0.0) or (slid and beside_face(row, float(sign), *state)):
                    continue
                if row[SIZE] == 0.0 and left == 2 * i + 1 - side:
                    continue  # both sides are one line, and it leaves that from the other one
                if corner:
                    off -= off[0]
                seen: tuple[fmpq_poly, ...] = within
                if bare:
                    seen = closed(within, row, float(sign), corner, shut, slack, left, faces, circles, rows)
                yield made(surface, owner, sign * off - size, seen, left == surface, spread)
            continue
        surface, h = faces + i, dx * dx + dy * dy - size * size
        if slid and (surface == left or (i >= faces + circles and beside_circle(row, *state))):
            within = (exact(row[MX]) * dx + exact(row[MY]) * dy - exact(row[COSINE]) * size,)
            sign = int(row[SIGN]) if i >= faces + circles else 1
            pull = vx0 * vx0 + vy0 * vy0 + float(block[GRAVITY]) * scale
            yield slid_off(surface, owner, sign * h, within if i >= faces + circles else (), spread, scale, pull)
        elif i < faces + circles:
            yield made(surface, owner, h, (), left == surface, spread, scale)
        else:
            within = (exact(row[MX]) * dx + exact(row[MY]) * dy - exact(row[COSINE]) * size,)
            clear: tuple[fmpq_poly, ...] = ()
            other = rows[WIDTH * (left - faces) :][:WIDTH] if left >= 2 * faces + circles else row
            fresh = left == surface or (other is not row and (other[OWNER], other[SIZE]) == (row[OWNER], row[SIZE]))
            if row[THICK] == 0.0 and left >= 0 and not fresh:
                fresh, comes = side_corner(row, x0, y0, vx0, vy0, body_of(left, faces, circles, rows, x0, y0))
                ends = sunk(row, -1.0, left, faces, circles, rows), sunk(row, 1.0, left, faces, circles, rows)
                begins = at_sunk(row, ends, x0, y0, slack_of(row, x0, y0))
                if comes and not begins:
                    continue
                fresh = fresh or begins
                clear = tuple(apart(row, turn, dx, dy) for turn, end in zip((-1.0, 1.0), ends, strict=True) if end)
            yield made(surface, owner, int(row[SIGN]) * h, within, fresh, spread, scale)._replace(clear=clear)


def apart(row: Floats, turn: float, dx: fmpq_poly, dy: fmpq_poly) -> fmpq_poly:
    """Return where a ball is not at an end of an arc, whose centre it sees (dx, dy) away: the gap of a circle."""
    x, y, _bx, _by = end_of_arc(row, turn)
    wide = exact(DEEP * slack_of(row, x, y))
    ex, ey = dx - exact(x - row[PX]), dy - exact(y - row[PY])
    return ex * ex + ey * ey - wide * wide


def closed(
    within: tuple[fmpq_poly, ...], row: Floats, sign: float, corner: bool, off: bool, slack: float, left: int,
    faces: int, circles: int, rows: Floats,
) -> tuple[fmpq_poly, ...]:  # fmt: skip
    """Return where a side of a face is to a ball that left a surface on which it ends: rounding leaves no way out."""

    def shut(far: int) -> fmpq:
        here = corner and abs(within[far][0]) <= exact(slack)
        side = -1.0
        if not (here and off):
            side = closing(left, faces, circles, rows, row, sign, float(far), here, slack)
        return exact(slack * (side if side > 0.0 else 2.0 * side))  # where it is not, it is not near either

    return within[0] + shut(0), within[1] + shut(1)


def slid_off(
    surface: int, owner: int, h: fmpq_poly, within: tuple[fmpq_poly, ...], spread: float, scale: float, pull: float
) -> Gap:  # fmt: skip
    """Return the gap of a circle off which the ball slid, h/s^2, as h and h' are 0 at the begin; h'' is not below 0.

    ``pull`` are the sizes that h'' is made of.
    """
    rest = fmpq_poly([h[i] for i in range(2, 5)])
    # where an arc ends below a ball without a radius
    pressed = float(Fraction(int(rest[0].p), int(rest[0].q))) < -SHARE * pull
    return made(surface, owner, rest, within, rest[0] <= 0 and not pressed, spread, scale)._replace(times=2)


def exact_contact(
    block: Floats, state: tuple[float, ...], left: float, clock: float = 0.0
) -> tuple[int, float, int]:  # fmt: skip
    """Return (surface, t, flags): what a ball hits first, -1 for nothing, and whether it grazed something before.

    Of two that it hits at the same time it is the one whose object comes first, and *ambiguous*: a flight beside it
    may hit the other one first. The flight begins at the time ``clock``.

    Raises
    ------
    Undecided
        If no precision tells.
    """
    faces, others = int(block[FACES]), int(block[CIRCLES]) + int(block[SIDES])
    base = 2 * faces + others
    last, slid = int(left), left > int(left)
    gaps = list(gaps_of(block, state, last if last < base else -1, slid))
    rows = block[HEAD + THING * int(block[THINGS]) + WIDTH * (faces + others) :]

    if last >= base and (slid or slips_off(rows, state, float(block[GRAVITY]), last - base, clock)):
        raise Undecided  # off a flipper: that it comes back to that at once is not decided here
    number = last - base

    def turning(end: float, final: bool) -> Iterator[Root]:
        return turning_roots(rows, int(block[FLIPPERS]), state, float(block[GRAVITY]), number, base, clock, end, final)

    for bits in BITS:
        with precision(bits):
            try:
                return _first(gaps, turning, state, block, last=bits == BITS[-1])
            except (Undecided, OverflowError):  # so large that it is infinite in doubles
                continue
    raise Undecided


def _first(
    gaps: list[Gap], turning: Callable[[float, bool], Iterator[Root]], state: tuple[float, ...], block: Floats,
    last: bool,
) -> tuple[int, float, int]:  # fmt: skip
    hits: list[Root] = []
    touches: list[Root] = []
    near: list[Root] = []
    for gap in gaps:
        for root in roots_of(gap):
            where = inside(root)
            if where == 0 and not last:
                raise Undecided
            if not root.touch and gap.within and bare(gap.surface, block) and beside(root):
                near.append(root)
            if where >= 0:
                (touches if root.touch else hits).append(root)
                if not root.touch:
                    break
        hits += joined(gap)
    hits, unsure = at_joints(near, hits, state, block) if len(near) > 1 else (hits, False)
    flags = AMBIGUOUS if unsure else OK
    end = min((nextafter(float(one.t.upper()), inf) for one in hits), default=inf)
    for root in turning(end, last):
        (touches if root.touch else hits).append(root)
    if not hits:
        return -1, float("inf"), GRAZE if touches else OK
    best = hits[0]
    for root in hits[1:]:
        if root.t < best.t:
            best = root
        elif not root.t > best.t:
            if not last and not same(root, best):
                raise Undecided
            if root.gap.owner != best.gap.owner and min(root.gap.owner, best.gap.owner) < away_of(block):
                flags |= AMBIGUOUS
            best = min(best, root, key=lambda one: one.gap.owner)
    if any(one.t < best.t for one in touches):
        flags |= GRAZE
    return best.gap.surface, float(best.t), flags
