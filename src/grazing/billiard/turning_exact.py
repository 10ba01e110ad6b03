"""Contacts with flippers in exact arithmetic: polynomials while they are at rest, ball arithmetic while they turn.

Doubles that say when a piece of a motion begins, how fast it turns and where it is then are exact, as those of a flight
are. On an interval on which a gap, its rate or its second derivative has one sign, the roots are known; others are cut
in two. A graze is told from a contact at any depth but 0.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from math import inf
from typing import Any, NamedTuple

import numpy as np
from flint import arb, ctx, fmpq_poly
from numpy.typing import NDArray

from grazing.billiard.flippers import (
    ARM,
    AT,
    AT_TIP,
    COSINE,
    CX,
    CY,
    FLIPPER_WIDTH,
    KINDS,
    LONG,
    OMEGA,
    OWNER,
    PIECE_WIDTH,
    PX,
    PY,
    SINE,
    SIZE,
    TIP,
)  # fmt: skip
from grazing.billiard.gaps import EPS
from grazing.billiard.roots import Gap, Root, Undecided, exact, inside, made, roots_of
from grazing.billiard.turning import begin_of, clock_of, comes_near, piece_at, slips_over

Floats = NDArray[np.float64]
#: A gap that begins below 0 by less than this share of the sizes it is made of begins at 0: that is rounding.
SHARE = 2.0**-46
#: Steps of the interval form of Newton's method.
STEPS = 200


class Window(NamedTuple):
    """A part of a flight, in one piece of a flipper's motion: from when to when, and when the piece begins."""

    start: float
    end: float
    begin: float
    piece: Floats
    first: bool


def windows_of(
    row: Floats, pieces: Floats, state: tuple[float, ...], g: float, clock: float, left: int, end: float
) -> Iterator[Window]:  # fmt: skip
    """Yield the parts of a flight until ``end`` in which the ball is near a flipper, as the march takes them."""
    x, y, vx, vy = state
    flight, phase, t = (x - row[PX], y - row[PY], vx, vy, g, x, y), clock_of(clock, row), 0.0
    if left < 0:
        t = comes_near(t, flight, row, end)
    while t < end:
        number, turns = piece_at(t, phase, row, pieces)
        until = min(begin_of(number + 1, turns, phase, row, pieces), end)
        piece = pieces[PIECE_WIDTH * number :][:PIECE_WIDTH]
        yield Window(t, until, begin_of(number, turns, phase, row, pieces), piece, t == 0.0)
        t = comes_near(until, flight, row, end) if until < end else inf


def slips_off(rows: Floats, state: tuple[float, ...], g: float, left: int, clock: float) -> bool:
    """Say whether a ball leaves a flipper as one that slid off it; ``left`` counts from the first surface of all."""
    row = rows[FLIPPER_WIDTH * (left // KINDS) :][:FLIPPER_WIDTH]
    x, y, vx, vy = state
    flight = (x - row[PX], y - row[PY], vx, vy, g, x, y)
    return slips_over(flight, left % KINDS, clock_of(clock, row), row, rows[int(row[AT]) :])


def turning_roots(
    rows: Floats, flippers: int, state: tuple[float, ...], g: float, left: int, base: int, clock: float, end: float,
    last: bool,
) -> Iterator[Root]:  # fmt: skip
    """Yield where sides and tips of flippers are hit or touched until ``end``; ``left`` counts from the first one."""
    for i in range(flippers):
        row = rows[FLIPPER_WIDTH * i : FLIPPER_WIDTH * (i + 1)]
        pieces, own = rows[int(row[AT]) :], left - KINDS * i
        own = own if 0 <= own < KINDS else -1
        for window in windows_of(row, pieces, state, g, clock, own, end):
            found = [
                one
                for kind in range(KINDS)
                for one in _in_window(kind, base + KINDS * i + kind, row, window, state, g, own == kind, last)
            ]
            yield from found
            if any(not one.touch for one in found):
                break


def _in_window(
    kind: int, surface: int, row: Floats, window: Window, state: tuple[float, ...], g: float, left: bool, last: bool
) -> list[Root]:  # fmt: skip
    fresh = left and window.first
    if window.piece[OMEGA] == 0.0:
        return _at_rest(kind, surface, row, window, state, g, fresh, last)
    motion = Motion(kind, row, window, state, g)
    found: list[Root] = []
    for t in motion.falls(fresh):
        foot = arb(0) if kind == AT_TIP else motion.foot(t)
        room = foot if kind == AT_TIP else min(foot, arb(exact(row[LONG])) - foot, key=lambda one: float(one.mid()))
        if kind != AT_TIP and not (room > 0 or room < 0):
            raise Undecided
        if not room < 0:
            found.append(Root(t, Gap(surface, int(row[OWNER]), None, (), fresh, motion.size), False))
            break
    return found


def _at_rest(
    kind: int, surface: int, row: Floats, window: Window, state: tuple[float, ...], g: float, fresh: bool, last: bool
) -> list[Root]:  # fmt: skip
    """Return contacts and touches in a window in which the flipper does not turn."""
    x, y, vx, vy = map(exact, state)
    late = fmpq_poly([exact(window.start), 1])
    fly_x, fly_y = fmpq_poly([x, vx])(late), fmpq_poly([y, vy, -exact(g) / 2])(late)
    ux, uy = exact(window.piece[CX]), exact(window.piece[CY])
    within: tuple[fmpq_poly, ...] = ()
    if kind == AT_TIP:
        dx = fly_x - exact(row[PX] + row[ARM] * window.piece[CX])
        dy = fly_y - exact(row[PY] + row[ARM] * window.piece[CY])
        size = exact(row[TIP])
        h, scale = dx * dx + dy * dy - size * size, 2.0 * float(row[TIP])
    else:
        nx, ny = _normal(kind, ux, uy, row)
        dx, dy, way = fly_x - exact(row[PX]), fly_y - exact(row[PY]), 1 - 2 * kind
        h, scale = nx * dx + ny * dy - exact(row[SIZE]), 1.0
        foot = way * (ny * dx - nx * dy)
        within = foot, exact(row[LONG]) - foot
    spread = abs(state[0]) + abs(state[1]) + float(row[TIP] + row[ARM] if kind == AT_TIP else row[SIZE])
    gap = made(surface, int(row[OWNER]), h, within, fresh, spread, scale)
    rate = SHARE * scale * (abs(state[2]) + abs(state[3]))
    pressed = fresh and h[1] < -exact(rate)  # it has begun to move towards the ball
    roots = [Root(arb(0), gap, False)] if pressed else roots_of(gap)
    found = []
    for root in roots:
        t = root.t + arb(exact(window.start))
        if window.end < inf and t > arb(exact(window.end)):
            break
        where = inside(root)
        if where == 0 and not last:
            raise Undecided
        if where >= 0:
            found.append(root._replace(t=t, gap=gap._replace(h=None)))
            if not root.touch:
                break
    return found


def _normal(kind: int, ux: Any, uy: Any, row: Floats) -> tuple[Any, Any]:
    sine, side = exact(row[SINE]), (1 - 2 * kind) * exact(row[COSINE])
    return sine * ux - side * uy, sine * uy + side * ux


class Motion:
    """The gap of a surface that turns, with two derivatives, at balls of time."""

    def __init__(self, kind: int, row: Floats, window: Window, state: tuple[float, ...], g: float) -> None:
        self.kind, self.row, self.window = kind, row, window
        x, y, self.vx, self.vy = map(exact, state)
        self.dx, self.dy, self.g = x - exact(row[PX]), y - exact(row[PY]), exact(g)
        self.omega, self.begin = exact(window.piece[OMEGA]), exact(window.begin)
        far = abs(float(self.dx.p) / float(self.dx.q)) + abs(float(self.dy.p) / float(self.dy.q))
        self.size = (far + float(row[ARM])) ** 2 if kind == AT_TIP else far + float(row[SIZE])

    def frame(self, t: arb) -> tuple[arb, arb, arb, arb, arb, arb]:
        """Return the vector along which the gap is measured, place and velocity."""
        turned = arb(self.omega) * (t - arb(self.begin))
        c, s, cx, cy = turned.cos(), turned.sin(), exact(self.window.piece[CX]), exact(self.window.piece[CY])
        ux, uy = c * arb(cx) - s * arb(cy), s * arb(cx) + c * arb(cy)
        if self.kind != AT_TIP:
            sine, side = arb(exact(self.row[SINE])), arb((1 - 2 * self.kind) * exact(self.row[COSINE]))
            ux, uy = sine * ux - side * uy, sine * uy + side * ux
        x, y = arb(self.dx) + arb(self.vx) * t, arb(self.dy) + (arb(self.vy) - arb(self.g) * t / 2) * t
        return ux, uy, x, y, arb(self.vx), arb(self.vy) - arb(self.g) * t

    def look(self, t: arb) -> tuple[arb, arb, arb]:
        """Return the gap and its first two derivatives."""
        nx, ny, x, y, vx, vy = self.frame(t)
        omega, g = arb(self.omega), arb(self.g)
        f, df = nx * x + ny * y, nx * vx + ny * vy + omega * (nx * y - ny * x)
        ddf = 2 * omega * (nx * vy - ny * vx) - g * ny - omega * omega * f
        if self.kind != AT_TIP:
            return f - arb(exact(self.row[SIZE])), df, ddf
        arm, size = arb(exact(self.row[ARM])), arb(exact(self.row[TIP]))
        h = x * x + y * y - 2 * arm * f + (arm - size) * (arm + size)
        return h, 2 * (x * vx + y * vy - arm * df), 2 * (vx * vx + vy * vy - g * y - arm * ddf)

    def foot(self, t: arb) -> arb:
        """Return how far along its side the ball is."""
        nx, ny, x, y, _vx, _vy = self.frame(t)
        return (1 - 2 * self.kind) * (ny * x - nx * y)

    def falls(self, fresh: bool) -> Iterator[arb]:
        """Yield the times at which the gap comes down to 0 from above, in order; Undecided where balls do not tell."""
        a, b = arb(exact(self.window.start)), arb(exact(self.window.end))
        h, dh, _ddh = self.look(a)
        offset = arb(h.mid()) if fresh else arb(0)
        if fresh or abs(float(h.mid())) <= SHARE * self.size:
            if not (dh > 0 or dh < 0):
                raise Undecided
            if dh < 0:
                yield a
            else:
                while not self.look(hull(a, b))[1] > 0:
                    b = middle(a, b)
                    if not b > a:
                        raise Undecided
                a, b = b, arb(exact(self.window.end))
        yield from falls_of(lambda t: shifted(self.look(t), offset), a, b)


def shifted(found: tuple[arb, arb, arb], offset: arb) -> tuple[arb, arb, arb]:
    """Return a gap that is 0 where it was ``offset``."""
    return found[0] - offset, found[1], found[2]


def hull(a: arb, b: arb) -> arb:
    """Return a ball around the interval between two balls."""
    return a.union(b)


def middle(a: arb, b: arb) -> arb:
    """Return a number between two others."""
    return arb(((a + b) / 2).mid())


def falls_of(look: Callable[[arb], tuple[arb, arb, arb]], a: arb, b: arb) -> Iterator[arb]:
    """Yield where a function comes down to 0 from above in [a, b], in order; ``look`` gives it with two derivatives."""
    if not b > a:
        return
    t, m = hull(a, b), middle(a, b)
    h, dh, ddh = look(t)
    near = look(m)[0] + dh * (t - m)
    if h > 0 or h < 0 or near > 0 or near < 0 or dh > 0:
        return
    if dh < 0:
        start, end = look(a)[0], look(b)[0]
        if start < 0 or end > 0:
            return
        if not (start > 0 and end < 0):
            raise Undecided
        yield root_of(lambda s: look(s)[:2], a, b)
        return
    if ddh > 0 or ddh < 0:
        rate_a, rate_b = look(a)[1], look(b)[1]
        if not ((rate_a > 0 or rate_a < 0) and (rate_b > 0 or rate_b < 0)):
            raise Undecided
        if (rate_a > 0) != (rate_b > 0):
            c = root_of(lambda s: look(s)[1:], a, b)
            value = look(c)[0]
            if not (value > 0 or value < 0):
                if ddh < 0 and look(b)[0] < 0 and look(a)[0] < 0:
                    return  # it touches 0 from below
                raise Undecided
            if (value > 0 and ddh > 0) or (value < 0 and ddh < 0):
                return
            low, high = (a, c) if ddh > 0 else (c, b)
            if (look(low)[0] if ddh > 0 else -look(high)[0]) < 0:
                return
            yield root_of(lambda s: look(s)[:2], arb(low.mid()), arb(high.mid()))
            return
    if float((b - a).mid()) <= 2.0 ** (-ctx.prec // 2) * float(abs(b).mid()):
        raise Undecided
    yield from falls_of(look, a, m)
    yield from falls_of(look, m, b)


def root_of(look: Callable[[arb], tuple[arb, arb]], a: arb, b: arb) -> arb:
    """Return a ball with the root between a and b of a function that changes its sign there and has one root."""
    start = look(a)[0] > 0
    for _ in range(STEPS):
        t, m = hull(a, b), middle(a, b)
        value, rate = look(m)[0], look(t)[1]
        if rate > 0 or rate < 0:
            new = m - value / rate
            low, high = arb(new.lower()), arb(new.upper())
            closer = low if low > a else a, high if high < b else b
            if float((closer[1] - closer[0]).mid()) < 0.4 * float((b - a).mid()):
                a, b = closer
                continue
        if not (value > 0 or value < 0):
            break
        if (value > 0) == start:
            a = m
        else:
            b = m
        if float((b - a).mid()) <= EPS * 2.0 ** (-ctx.prec // 2) * float(abs(b).mid()):
            break
    return hull(a, b)
