"""The first contact of one flight in exact arithmetic: what double precision cannot decide.

Along a parabola the gap of every surface of a table is a polynomial of degree two or four, and its coefficients are
rational, as doubles are. Its real roots come isolated, with multiplicities: a root of odd multiplicity at which it
falls is a contact, one of even multiplicity a graze. The order of two surfaces is that of isolated roots.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np
from flint import arb, ctx, fmpq, fmpq_poly
from numpy.typing import NDArray

from grazing.billiard.march import body_of, face_corner, side_corner
from grazing.billiard.rows import (
    BARE,
    CIRCLES,
    COSINE,
    EX,
    EY,
    FACES,
    GRAVITY,
    HEAD,
    LONG,
    MX,
    MY,
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
from grazing.outcome import AMBIGUOUS, GRAZE, OK

Floats = NDArray[np.float64]
#: Bits of precision that are tried in turn; roots of such polynomials that differ at all differ within the last.
BITS = (128, 512, 2048, 8192)
#: A gap that begins below 0 by less than this share of the sizes it is made of begins at 0: that is rounding.
SHARE = 2.0**-46


class Undecided(Exception):
    """What no precision that is tried decides."""


class Gap(NamedTuple):
    """The gap of a surface along a flight; ``within`` are polynomials that are >= 0 where the surface is.

    ``size`` are the sizes that the gap at the beginning is made of.
    """

    surface: int
    owner: int
    h: fmpq_poly
    within: tuple[fmpq_poly, ...]
    fresh: bool
    size: float


class Root(NamedTuple):
    """Where a gap comes down to 0, or touches it."""

    t: arb
    gap: Gap
    touch: bool


def exact(x: float) -> fmpq:
    """Return a double as a rational number."""
    return fmpq(*float(x).as_integer_ratio())


def gaps_of(block: Floats, state: tuple[float, ...], left: int) -> Iterator[Gap]:
    """Yield the gaps of all surfaces along the flight from a state."""
    x, y, vx, vy = map(exact, state)
    fall = -exact(block[GRAVITY]) / 2
    faces, circles, sides = (int(block[i]) for i in (FACES, CIRCLES, SIDES))
    rows = block[HEAD + THING * int(block[THINGS]) :]
    body = body_of(left, faces, circles, rows)
    for i in range(faces + circles + sides):
        row = rows[WIDTH * i : WIDTH * (i + 1)]
        dx, dy = fmpq_poly([x - exact(row[PX]), vx]), fmpq_poly([y - exact(row[PY]), vy, fall])
        within: tuple[fmpq_poly, ...]
        owner, size = int(row[OWNER]), fmpq_poly([exact(row[SIZE])])
        spread = abs(state[0] - row[PX]) + abs(state[1] - row[PY]) + row[SIZE]
        if i < faces:
            ex, ey = exact(row[EX]), exact(row[EY])
            off, foot = ey * dx - ex * dy, ex * dx + ey * dy
            within = foot, fmpq_poly([exact(row[LONG])]) - foot
            bare = left >= 0 and left // 2 != i and row[SIZE] == 0.0
            corner, way = face_corner(row, state[0], state[1], state[2], state[3], body) if bare else (False, 0.0)
            for side, sign in enumerate((-1, 1)):
                surface = 2 * i + side
                if corner and sign * way < 0.0:
                    continue
                if corner:
                    off -= off[0]
                fresh = left == surface or (left // 2 == i and row[SIZE] == 0.0)
                yield made(surface, owner, sign * off - size, within, fresh, spread)
            continue
        surface, h = faces + i, dx * dx + dy * dy - size * size
        if i < faces + circles:
            yield made(surface, owner, h, (), left == surface, spread * spread)
        else:
            within = (exact(row[MX]) * dx + exact(row[MY]) * dy - exact(row[COSINE]) * size,)
            other = rows[WIDTH * (left - faces) :][:WIDTH] if left >= 2 * faces + circles else row
            fresh = left == surface or (other is not row and (other[OWNER], other[SIZE]) == (row[OWNER], row[SIZE]))
            if row[BARE] > 0.0 and left >= 0 and not fresh:
                fresh, comes = side_corner(row, state[0], state[1], state[2], state[3], body)
                if comes:
                    continue
            yield made(surface, owner, int(row[SIGN]) * h, within, fresh, spread * spread)


def made(surface: int, owner: int, h: fmpq_poly, within: tuple[fmpq_poly, ...], fresh: bool, size: float) -> Gap:
    """Return a gap; it is 0 at the beginning by definition where the ball just left the surface, from either side."""
    return Gap(surface, owner, h - h[0] if fresh else h, within, fresh, size)


@contextmanager
def precision(bits: int) -> Iterator[None]:
    """Let ball arithmetic have so many bits for a while."""
    before, ctx.prec = ctx.prec, bits
    try:
        yield
    finally:
        ctx.prec = before


def at(h: fmpq_poly, t: arb) -> arb:
    """Return a polynomial at a ball."""
    found = arb(0)
    for i in range(h.degree(), -1, -1):
        found = found * t + arb(h[i])
    return found


def sign_at(h: fmpq_poly, root: Root | arb) -> int:
    """Return the sign of a polynomial at a root, 0 where balls of this precision do not tell."""
    value = at(h, root if isinstance(root, arb) else root.t)
    return 1 if value > 0 else (-1 if value < 0 else 0)


def roots_of(gap: Gap) -> list[Root]:
    """Return where a gap comes down to 0 from above after the start, or touches it, in order."""
    h, found = gap.h, []
    if not gap.fresh and h[0] <= 0 and h[1] < 0 and float(Fraction(int(h[0].p), int(h[0].q))) > -SHARE * gap.size:
        found.append(Root(arb(0), gap, False))
    if h.degree() < 1:
        return found
    roots: Any = h.numer().complex_roots()
    for z, times in roots:
        t = z.real
        if not z.imag == 0 or not t > 0:
            if z.imag == 0 and not t < 0 and not t == 0:
                raise Undecided
            continue
        slope = h
        for _ in range(times):
            slope = slope.derivative()
        way = sign_at(slope, t)
        if way == 0:
            raise Undecided
        if (way < 0) == (times % 2 == 1):
            found.append(Root(t, gap, times % 2 == 0))
    return sorted(found, key=lambda one: float(one.t))


def inside(root: Root) -> int:
    """Say whether a root is on the surface itself, between its ends: 1, or -1 for not; 0 for at an end."""
    return min((sign_at(one, root) for one in root.gap.within), default=1)


def exact_contact(block: Floats, state: tuple[float, ...], left: int) -> tuple[int, float, int]:
    """Return (surface, t, flags): what a ball hits first, -1 for nothing, and whether it grazed something before.

    Of two that it hits at the same time it is the one whose object comes first, and *ambiguous*: a flight beside it
    may hit the other one first.

    Raises
    ------
    Undecided
        If no precision tells.
    """
    gaps = list(gaps_of(block, state, left))
    for bits in BITS:
        with precision(bits):
            try:
                return _first(gaps, state, last=bits == BITS[-1])
            except (Undecided, OverflowError):  # so large that it is infinite in doubles
                continue
    raise Undecided


def _first(gaps: list[Gap], state: tuple[float, ...], last: bool) -> tuple[int, float, int]:
    hits: list[Root] = []
    touches: list[Root] = []
    flags = OK
    for gap in gaps:
        for root in roots_of(gap):
            where = inside(root)
            if where == 0 and not last:
                raise Undecided
            if where >= 0:
                (touches if root.touch else hits).append(root)
                if not root.touch:
                    break
    if not hits:
        return -1, float("inf"), GRAZE if touches else OK
    best = hits[0]
    for root in hits[1:]:
        if root.t < best.t:
            best = root
        elif not root.t > best.t:
            if not last and not same(root, best):
                raise Undecided
            if root.gap.owner != best.gap.owner:
                flags |= AMBIGUOUS
            best = min(best, root, key=lambda one: one.gap.owner)
    if any(one.t < best.t for one in touches):
        flags |= GRAZE
    return best.gap.surface, float(best.t), flags


def same(one: Root, other: Root) -> bool:
    """Say whether two gaps surely have a root in common where their roots are not told apart."""
    common = one.gap.h.gcd(other.gap.h)
    if common.degree() < 1:
        return bool(one.t == other.t)
    roots: Any = common.numer().complex_roots()
    for z, _times in roots:
        if z.imag == 0 and z.real.overlaps(one.t) and z.real.overlaps(other.t):
            return True
    return False
