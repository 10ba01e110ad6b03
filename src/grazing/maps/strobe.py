"""A step of a table in time, from strobe to strobe, as kernels take it.

A ball that slides or rests at a strobe touches a surface up to rounding, and is found on it again: that is no
coordinate.
"""

from __future__ import annotations

from math import atan2, floor, hypot
from typing import Any, NamedTuple

import numpy as np

from grazing.billiard.carried import (
    DVX,
    DVY,
    DX,
    DY,
    OF_GATES,
    flown_by,
    loosened,
    off_surface,
    onto_surface,
    ridden_along,
    slid_by,
)
from grazing.billiard.contact import NONE, SLIDES, jammed, next_event, slid_on
from grazing.billiard.elements import bend_of, element, normal_of, slid
from grazing.billiard.hit import away_of, flown, slope_of, way_at
from grazing.billiard.ride import carried_to
from grazing.billiard.rows import GRAVITY
from grazing.billiard.slide import pressing
from grazing.billiard.turning import ON, RIDES
from grazing.kernel.primitives import behind, inlined, numbers, numbers_at, replaced
from grazing.maps.collide import LOST, NOTHING, Kernels, arriving, departing
from grazing.maps.hits import MANY
from grazing.outcome import AMBIGUOUS, BAD_LAW, ESCAPED, FATAL, GRAZE, NO_IMPACT, OK, STUCK, TOO_MANY_SWINGS

NAN = float("nan")
#: How many times the reach of a table away the first ball lies that has left; each next way out is one further.
BEYOND = 3.0


class Strobe(NamedTuple):
    """What a kernel needs of a strobe: the address of the table's block, the phase, the time between two strobes.

    ``reach`` is how far the table reaches, ``most`` how many impacts a letter can tell apart.
    """

    block: Any
    phase: float
    period: float
    reach: float
    most: float


def left_by(way: int, reach: float) -> tuple[float, float, float, float]:
    """Return where a ball lies that has left: at rest, far beside the table, one place for each way out."""
    return (BEYOND + way) * reach, 0.0, 0.0, 0.0


def way_from(state: Any, reach: float, table: Any) -> int:
    """Return the way out through which a ball has left; -1 for a ball on the table."""
    x, y, vx, vy = state
    if not (y == 0.0 and vx == 0.0 and vy == 0.0 and x >= BEYOND * reach):
        return -1
    number = floor(x / reach - BEYOND + 0.5)
    return way_at(1.0 * number, table) if x == (BEYOND + number) * reach else -1


@inlined
def longer(letter: int, count: int, owner: int, most: int, table: Any) -> Any:
    """Return the letter of a step with one object more, as :class:`grazing.maps.hits.Bounces` spells it."""
    return (away_of(table) + 2) * letter + owner + 1 if count <= most else MANY


@inlined
def along_for(left: float, last: int, state: Any, t: float, clock: float, table: Any) -> Any:
    """Return the state of a ball that flies, slides or rides for a time in which nothing ends that."""
    x, y, vx, vy = state
    if last < 0:
        return flown(x, y, vx, vy, table[GRAVITY], t)
    if left == last + RIDES:
        return carried_to(last, state, t, clock, table)
    return slid(last, x, y, vx, vy, t, clock, table)


@inlined
def carry(d: Any, left: float, last: int, state: Any, clock: float, found: Any, table: Any) -> Any:
    """Carry derivatives along a flight, a slide or a ride, and off it; return the acceleration at its end."""
    if last < 0:
        flown_by(d, 4, OF_GATES, found[0][2])
        return 0.0, -table[GRAVITY]
    if left == last + RIDES:
        return ridden_along(d, 4, OF_GATES, last, state, clock, found, table)
    return slid_by(d, 4, OF_GATES, last, state, clock, found, table)


@inlined
def off_it(d: Any, last: int, state: Any, clock: float, table: Any) -> None:
    """Let derivatives on a slide be those of x, y, vx and vy."""
    x, y, vx, vy = state
    el = element(last, clock, table)
    (nx, ny), bend = normal_of(el, x, y), bend_of(el)
    speed = vy * nx - vx * ny
    off_surface(d, 4, OF_GATES, (nx, ny, bend), speed, pressing(nx, ny, bend, speed, table[GRAVITY]), 0.0)


def kicked(d: Any, before: Any, after: Any, speeds: Any, force: Any, bend: float, g: float) -> None:
    """Carry derivatives through an impact: as the step of the map from impact to impact, seen at the same time."""
    _v_minus, v_plus, along, nx, ny, curvature, omega, ux, uy = speeds
    out, frame = v_plus + (ux * nx + uy * ny), (nx, ny, curvature, omega, ux, uy)
    angle, speed = atan2(along, out), hypot(along, out)
    for k in range(4):
        one = behind(d, OF_GATES * k)
        moved = arriving(one[DX], one[DY], one[DVX], one[DVY], 0.0, before, force, speeds, bend)
        dx, dy, dvx, dvy = -after[2] * moved[3], -after[3] * moved[3], 0.0, g * moved[3]
        for j in range(4):
            by = departing(j, angle, speed, frame)
            dx, dy = dx + moved[j] * by[0], dy + moved[j] * by[1]
            dvx, dvy = dvx + moved[j] * by[2], dvy + moved[j] * by[3]
        one[DX], one[DY], one[DVX], one[DVY] = dx, dy, dvx, dvy


def strobed(state: Any, c: Strobe, table: Any, d: Any, with_tangent: bool) -> Any:
    """Return (state, letter, outcome) one period later; ``d`` is room for four columns of derivatives, J by columns."""
    phase, T, reach, most = c.phase, c.period, c.reach, int(c.most)
    way = way_from(state, reach, table)
    if way >= 0:
        return left_by(way, reach), way + 1, ESCAPED
    for k in range(4 if with_tangent else 0):
        one = behind(d, OF_GATES * k)
        for i in range(OF_GATES):
            one[i] = 1.0 if i == k else 0.0  # of x, y, vx, vy; the clock is not ahead
    t, left, letter, hits, flags, (x, y, vx, vy) = 0.0, -1.0, 0, 0, OK, state
    for _ in range(SLIDES):
        clock = phase + t
        last = slid_on(left, clock, table)
        if with_tangent and last < 0 and left == int(left) + ON:  # what it lay on begins to turn
            loosened(d, 4, OF_GATES, int(left), x, y, vx, vy, clock, table)
        found = next_event(x, y, vx, vy, left, clock, table)
        (surface, owner, length, said, on), before, after, speeds = found
        within = t + length <= T
        gone = said & ESCAPED and (within or owner < 0)
        if not within and not gone and not said & FATAL & ~(NO_IMPACT | BAD_LAW):  # of what comes later nothing is said
            flags |= said & (GRAZE | AMBIGUOUS) | (STUCK if last >= 0 else OK)
            rests = last >= 0 and surface < 0
            new = before if rests else along_for(left, last, (x, y, vx, vy), T - t, clock, table)
            if with_tangent:
                carry(d, left, last, (x, y, vx, vy), clock, ((surface, -1, T - t, OK, left), new, new, NONE), table)
                if last >= 0 and left != last + RIDES:
                    off_it(d, last, new, phase + T, table)
            return new, letter, flags
        flags |= said
        if said & FATAL and not gone:
            return (NAN, NAN, NAN, NAN), 0, flags
        if gone:
            way = owner if owner >= 0 else away_of(table)
            return left_by(way, reach), longer(letter, hits + 1, way, most, table), flags
        if with_tangent:
            force = carry(d, left, last, (x, y, vx, vy), clock, found, table)
            if owner < 0 and surface >= 0 and on == surface + ON and last != surface:
                onto_surface(d, 4, OF_GATES, element(surface, clock + length, table), after)
        if owner >= 0:
            hits += 1
            letter = longer(letter, hits, owner, most, table)
            flags |= jammed(owner, length, flags, on, clock + length, after, table)
            if flags & FATAL:
                return (NAN, NAN, NAN, NAN), 0, flags
            if not (speeds[0] < 0.0 and hypot(after[2], after[3]) > 0.0):
                flags |= GRAZE
            elif with_tangent:
                kicked(d, before, after, speeds, force, slope_of(owner, speeds[0], table), table[GRAVITY])
        t, left, (x, y, vx, vy) = t + length, on, after
    return (NAN, NAN, NAN, NAN), 0, flags | TOO_MANY_SWINGS


def slopes(state: Any, c: Strobe, table: Any) -> Any:
    """Return (state, letter, outcome, J) one period later."""
    work = np.empty(4 * OF_GATES)
    d = numbers(work)
    new, letter, outcome = strobed(state, c, table, d, True)
    J = NOTHING if outcome & ESCAPED else LOST
    if not outcome & (FATAL | ESCAPED | GRAZE | AMBIGUOUS):
        for k in range(4):
            one = behind(d, OF_GATES * k)
            J = replaced(replaced(J, k, one[DX]), 4 + k, one[DY])
            J = replaced(replaced(J, 8 + k, one[DVX]), 12 + k, one[DVY])
    work[0] = 0.0  # an array lives up to its last use, its numbers do not keep it
    return new, letter, outcome, J


def step(state: Any, c: Strobe) -> Any:
    """Return (state, letter, outcome) one period later, of a table whose block lies at an address."""
    table = numbers_at(c.block)
    return strobed(state, c, table, table, False)


def tangent(state: Any, c: Strobe) -> Any:
    """Return what :func:`step` does, and J; nothing is known of its determinant apart from that."""
    new, letter, outcome, J = slopes(state, c, numbers_at(c.block))
    return new, letter, outcome, (*J, NAN)


def plain(state: Any, c: Strobe) -> Any:
    """Return what :func:`step` does, as plain Python takes it: it has the block itself."""
    return strobed(state, c, c.block, c.block, False)


def plain_tangent(state: Any, c: Strobe) -> Any:
    """Return what :func:`tangent` does, as plain Python takes it."""
    return slopes(state, c, c.block)


#: The step of the stroboscopic map of a table.
STROBED = Kernels(step, tangent, plain, plain_tangent)
