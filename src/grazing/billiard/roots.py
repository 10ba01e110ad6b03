"""Roots of the gaps of surfaces along a flight, in ball arithmetic: where polynomials come down to 0, or touch it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from fractions import Fraction
from typing import Any, NamedTuple

from flint import arb, ctx, fmpq, fmpq_poly

from grazing.pool import LOCK

#: A gap that begins below 0 by less than this share of the sizes it is made of begins at 0: that is rounding.
SHARE = 2.0**-46


class Undecided(Exception):
    """What no precision that is tried decides."""


class Gap(NamedTuple):
    """The gap of a surface along a flight; ``within`` are polynomials that are >= 0 where the surface is.

    ``h`` is None where it is no polynomial of the time.

    ``size`` is that of the coordinates, ``scale`` by how much more than a place the gap changes, as that of a circle is
    one of squares; ``h`` is divided by the time so many ``times``.
    """

    surface: int
    owner: int
    h: fmpq_poly | None
    within: tuple[fmpq_poly, ...]
    fresh: bool
    size: float
    scale: float = 1.0
    times: int = 0
    clear: tuple[fmpq_poly, ...] = ()


class Root(NamedTuple):
    """Where a gap comes down to 0, or touches it."""

    t: arb
    gap: Gap
    touch: bool


def exact(x: float) -> fmpq:
    """Return a double as a rational number."""
    return fmpq(*float(x).as_integer_ratio())


def made(
    surface: int, owner: int, h: fmpq_poly, within: tuple[fmpq_poly, ...], fresh: bool, size: float, scale: float = 1.0
) -> Gap:  # fmt: skip
    """Return a gap; it is 0 at the beginning by definition where the ball just left the surface, from either side."""
    return Gap(surface, owner, h - h[0] if fresh else h, within, fresh, size, scale)


@contextmanager
def precision(bits: int) -> Iterator[None]:
    """Let ball arithmetic have so many bits for a while."""
    with LOCK, ctx.workprec(bits):
        yield


def at(h: fmpq_poly, t: arb) -> arb:
    """Return a polynomial at a ball."""
    found = arb(0)
    for i in range(h.degree(), -1, -1):
        found = found * t + arb(h[i])
    return found


def unsure(gap: Gap) -> float:
    """Return the rounding of a gap."""
    return SHARE * gap.size * gap.scale


def sign_at(h: fmpq_poly, root: Root | arb) -> int:
    """Return the sign of a polynomial at a root, 0 where balls of this precision do not tell."""
    value = at(h, root if isinstance(root, arb) else root.t)
    return 1 if value > 0 else (-1 if value < 0 else 0)


def roots_of(gap: Gap) -> list[Root]:
    """Return where a gap comes down to 0 from above after the start, or touches it, in order."""
    h: Any = gap.h
    found: list[Root] = []
    if not (gap.fresh or gap.times) and h[0] <= 0 and float(Fraction(int(h[0].p), int(h[0].q))) > -unsure(gap):
        h -= h[0]
        if h[1] < 0 or (h[1] == 0 and h[2] < 0):
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


def joined(gap: Gap) -> list[Root]:
    """Return where a flight comes past an end of an arc onto it: touching its circle, within rounding, and pressed.

    So it does from a wall that runs into the arc tangentially. That it passes the end on the other side by rounding is
    no way out: there is none between wall and arc.
    """
    h: Any = gap.h
    if len(gap.within) != 1 or h is None or (gap.fresh and not gap.times):
        return []
    h *= fmpq_poly([0, 1]) ** gap.times
    (end,) = gap.within
    rate, press, found = h.derivative(), h.derivative().derivative(), []
    roots: Any = end.numer().complex_roots() if end.degree() > 0 else []
    for z, count in roots:
        t = z.real
        if not (z.imag == 0 and t > 0 and count == 1 and sign_at(end.derivative(), t) > 0 > sign_at(press, t)):
            continue
        off, way, bend = at(h, t), at(rate, t), -at(press, t)
        # it would come down by so much in the time in which it rises, or has risen, by that
        if abs(off) < unsure(gap) and way * way < unsure(gap) * bend:
            found.append(Root(t, gap, False))
    return found


def inside(root: Root) -> int:
    """Say whether a root is on the surface itself, between its ends: 1, or -1 for not; 0 for at an end."""
    return min((sign_at(one, root) for one in (*root.gap.within, *root.gap.clear)), default=1)


def beside(root: Root) -> bool:
    """Say whether a root is on the surface itself, or beyond its ends by no more than rounding."""
    slack = exact(SHARE * root.gap.size)
    clear = all(at(one, root.t) > 0 for one in root.gap.clear)
    return clear and all(at(one, root.t) + slack > 0 for one in root.gap.within)


def same(one: Root, other: Root) -> bool:
    """Say whether two gaps surely have a root in common where their roots are not told apart."""
    if one.gap.h is None or other.gap.h is None:
        return False
    common = one.gap.h.gcd(other.gap.h)
    if common.degree() < 1:
        return bool(one.t == other.t)
    roots: Any = common.numer().complex_roots()
    for z, _times in roots:
        if z.imag == 0 and z.real.overlaps(one.t) and z.real.overlaps(other.t):
            return True
    return False
