"""A step of a table from impact to impact, as kernels take it: ball by ball with its tangent, or side by side."""

from __future__ import annotations

from collections.abc import Callable
from math import atan2, cos, hypot, sin, sqrt
from typing import Any, NamedTuple

import numpy as np

from grazing.billiard.carried import AHEAD, DVX, DVY, DX, DY, OF_GATES, next_carried
from grazing.billiard.contact import next_impact
from grazing.billiard.hit import away_of, period_of, place_at, slope_of, spot_at, way_at
from grazing.billiard.packed import impact_of, padded_contacts
from grazing.billiard.rows import CIRCLES, GRAVITY, LENGTH
from grazing.billiard.workspace import LANES, W, room_for
from grazing.kernel.primitives import behind, inlined, numbers, numbers_at, replaced
from grazing.outcome import AMBIGUOUS, DIVERGED, ESCAPED, FATAL, GRAZE, STUCK

NAN = float("nan")
LOST = (NAN,) * 16
NOTHING: tuple[float, ...] = (0.0,) * 16


class Place(NamedTuple):
    """What a kernel needs of a table: the address of its block."""

    block: float


def velocity(nx: float, ny: float, angle: float, speed: float) -> Any:
    """Return the velocity of a ball that leaves a surface at an angle from its normal."""
    away, along = speed * cos(angle), speed * sin(angle)
    return away * nx - along * ny, away * ny + along * nx


def gone(way: int, table: Any) -> Any:
    """Return where a ball lies that has left, one place for each way out, and that way."""
    way = way if way >= 0 else away_of(table)
    return (table[LENGTH] + way + 0.5, 0.0, 0.0), way


def collide(state: Any, clock: float, table: Any, with_tangent: bool) -> Any:
    """Return (state, t, letter, outcome, J) of a step from impact to impact, from the time ``clock`` on.

    The state has no phase; J, row by row, is by place, angle, speed and clock.
    """
    place, angle, speed = state
    way = way_at(place - table[LENGTH], table)
    if way >= 0:
        away, way = gone(way, table)
        return away, 0.0, way, ESCAPED, NOTHING
    surface, x, y, frame = spot_at(place, clock, table)
    if surface < 0:
        return (NAN, NAN, NAN), NAN, 0, DIVERGED, LOST
    vx, vy = velocity(frame[0], frame[1], angle, speed)
    found = next_impact(x, y, vx, vy, 1.0 * surface, clock, table)
    new, t, letter, flags = arrived(found, clock, table)
    J = NOTHING if flags & ESCAPED else LOST
    if with_tangent and not flags & (FATAL | ESCAPED | GRAZE | AMBIGUOUS):
        _where, before, _after, speeds = found
        if speeds[0] < 0.0 and new[2] > 0.0 and flags & STUCK:
            J = carried_slopes(state, clock, (surface, x, y, frame), table)
        elif speeds[0] < 0.0 and new[2] > 0.0:
            J = slopes(angle, speed, frame, t, before, speeds, slope_of(letter, speeds[0], table), table[GRAVITY])
    return new, t, letter, flags, J


@inlined
def arrived(found: Any, clock: float, table: Any) -> Any:
    """Return (state, t, letter, outcome) after a flight from the time ``clock`` on and the impact that ends it."""
    (surface, owner, t, flags, _on), _before, after, speeds = found
    if flags & FATAL:
        return (NAN, NAN, NAN), NAN, 0, flags
    if flags & ESCAPED:
        away, way = gone(owner, table)
        return away, 0.0, way, flags
    v_minus, v_plus, along, nx, ny, _curvature, _omega, ux, uy = speeds
    out = v_plus + (ux * nx + uy * ny)
    new = place_at(surface, after[0], after[1], t, clock, table), atan2(along, out), hypot(along, out)
    return new, t, owner, named(flags, v_minus, new[2])


@inlined
def named(flags: int, before: float, speed: float) -> int:
    """Return the outcome of a step: an impact as slow as nothing, or one that leaves the ball at rest, is a graze."""
    return flags if before < 0.0 and speed > 0.0 else flags | GRAZE


@inlined
def departing(j: int, angle: float, speed: float, frame: Any) -> Any:
    """Return how place and velocity of a ball that leaves a surface depend on place, angle, speed or the clock."""
    nx, ny, curvature, omega, sx, sy = frame
    wx, wy = velocity(nx, ny, angle, 1.0)
    turned = speed * (curvature if j == 0 else (1.0 if j == 1 else (omega if j == 3 else 0.0)))
    dwx, dwy = -wy * turned, wx * turned
    dx, dy = 0.0, 0.0
    if j == 0:
        dx, dy = -ny, nx
    elif j == 2:
        dwx, dwy = wx, wy
    elif j == 3:
        dx, dy = sx, sy
    return dx, dy, dwx, dwy


@inlined
def arriving(dx: float, dy: float, dwx: float, dwy: float, later: float, before: Any, force: Any, speeds: Any,
             bend: float) -> Any:  # fmt: skip
    """Return (place, angle, speed, later) of an impact, from what just before it is different at the same time.

    ``later``: what is hit is ahead by so much; ``force``: the ball's acceleration.
    """
    _px, _py, vx, vy = before
    v_minus, v_plus, along, mx, my, there, spin, ux, uy = speeds
    push, drag = ux * mx + uy * my, uy * mx - ux * my  # the surface's velocity along its normal, and along itself
    out, coming = v_plus + push, v_minus + push
    size2 = out * out + along * along
    dx, dy = dx - ux * later, dy - uy * later
    late = -(mx * dx + my * dy) / v_minus
    dwx, dwy = dwx + force[0] * late, dwy + force[1] * late
    shift = -my * (dx + (vx - ux) * late) + mx * (dy + (vy - uy) * late)
    tilt = there * shift + spin * (later + late)
    pushed = (there * drag - spin) * shift
    away = bend * (mx * dwx + my * dwy + tilt * along - pushed) + pushed
    beside = -my * dwx + mx * dwy - tilt * coming
    turn, gain = (out * beside - along * away) / size2, (out * away + along * beside) / sqrt(size2)
    return shift, turn, gain, late


def slopes(angle: float, speed: float, frame: Any, t: float, before: Any, speeds: Any, bend: float, g: float) -> Any:
    """Return the Jacobian of a step of one flight, row by row: docs/table.md says how it is derived."""
    J = NOTHING
    for j in range(4):
        dx, dy, dwx, dwy = departing(j, angle, speed, frame)
        later = 1.0 if j == 3 else 0.0
        dx, dy = dx + t * dwx, dy + t * dwy
        shift, turn, gain, late = arriving(dx, dy, dwx, dwy, later, before, (0.0, -g), speeds, bend)
        J = replaced(J, j, shift)
        J = replaced(J, 4 + j, turn)
        J = replaced(J, 8 + j, gain)
        J = replaced(J, 12 + j, later + late)
    return J


def carried_slopes(state: Any, clock: float, spot: Any, table: Any) -> Any:
    """Return the Jacobian of a step with a slide, as :func:`slopes` does that of one flight."""
    work = np.empty(4 * OF_GATES)
    J = slopes_with_room(state, clock, spot, table, numbers(work))
    work[0] = 0.0  # an array lives up to its last use, its numbers do not keep it
    return J


def slopes_with_room(state: Any, clock: float, spot: Any, table: Any, d: Any) -> Any:
    """Return what :func:`carried_slopes` does, with room for it."""
    (_place, angle, speed), (surface, x, y, frame), J = state, spot, NOTHING
    for j in range(4):
        one = behind(d, OF_GATES * j)
        one[DX], one[DY], one[DVX], one[DVY] = departing(j, angle, speed, frame)
        one[AHEAD] = 1.0 if j == 3 else 0.0
    vx, vy = velocity(frame[0], frame[1], angle, speed)
    found, before, _after, speeds, force = next_carried(
        x, y, vx, vy, 1.0 * surface, clock, table, d, 4, OF_GATES
    )  # fmt: skip
    bend = slope_of(found[1], speeds[0], table)
    for j in range(4):
        one = behind(d, OF_GATES * j)
        later = one[AHEAD]
        shift, turn, gain, late = arriving(
            one[DX], one[DY], one[DVX], one[DVY], later, before, force, speeds, bend
        )  # fmt: skip
        J = replaced(replaced(J, j, shift), 4 + j, turn)
        J = replaced(replaced(J, 8 + j, gain), 12 + j, later + late)
    return J


def in_three(J: Any) -> Any:
    """Return the part of a Jacobian that has no phase."""
    return J[0], J[1], J[2], J[4], J[5], J[6], J[8], J[9], J[10]


def steady(state: Any, table: Any, with_tangent: bool) -> Any:
    """Return (state, letter, outcome, J) of a step of a table that does not depend on time."""
    new, _t, letter, outcome, J = collide(state, 0.0, table, with_tangent)
    return new, letter, outcome, in_three(J)


def timed(state: Any, table: Any, with_tangent: bool) -> Any:
    """Return (state, letter, outcome, J) of a step of a table that is periodic in time."""
    place, angle, speed, phase = state
    new, t, letter, outcome, J = collide((place, angle, speed), phase, table, with_tangent)
    later = 0.0 if outcome & ESCAPED else (phase + t) % period_of(table)
    return (new[0], new[1], new[2], later), letter, outcome, J


class Kernels(NamedTuple):
    """The step of a table: compiled, with and without derivative, and as plain Python takes it.

    Plain Python has the block of a table itself, of whatever length. Nothing is known of the determinant apart from J.
    """

    step: Callable[..., Any]
    tangent: Callable[..., Any]
    plain: Callable[..., Any]
    plain_tangent: Callable[..., Any]


def kernels_of(take: Callable[..., Any]) -> Kernels:
    """Return the kernels of ``take(state, table, with_tangent) -> (state, letter, outcome, J)``."""

    def step(state: Any, c: Place) -> Any:
        new, letter, outcome, _J = take(state, numbers_at(c.block), False)
        return new, letter, outcome

    def tangent(state: Any, c: Place) -> Any:
        new, letter, outcome, J = take(state, numbers_at(c.block), True)
        return new, letter, outcome, (*J, NAN)

    def plain(state: Any, block: Any) -> Any:
        new, letter, outcome, _J = take(state, block, False)
        return new, letter, outcome

    def plain_tangent(state: Any, block: Any) -> Any:
        return take(state, block, True)

    return Kernels(step, tangent, plain, plain_tangent)


STEADY, TIMED = kernels_of(steady), kernels_of(timed)


def all_collided(row: Any, lanes: Any, letters: Any, outcomes: Any) -> None:
    """Take all states of lanes (3 or 4, n) one step further, side by side, as :func:`collide` does each."""
    table, timely = numbers_at(row[0]), lanes.shape[0] > 3
    room = np.empty(room_for(int(table[CIRCLES])))
    w = numbers(room)
    for first in range(0, lanes.shape[1], LANES):
        m = 0
        for j in range(first, min(first + LANES, lanes.shape[1])):
            clock, way = lanes[3, j] if timely else 0.0, way_at(lanes[0, j] - table[LENGTH], table)
            if way >= 0:
                new, letters[j] = gone(way, table)
                outcomes[j] = ESCAPED
                put_at(lanes, j, new, 0.0, timely)
                continue
            surface, x, y, frame = spot_at(lanes[0, j], clock, table)
            if surface < 0:
                letters[j], outcomes[j] = 0, DIVERGED
                put_at(lanes, j, (NAN, NAN, NAN), NAN, timely)
            else:
                w[W.X + m], w[W.Y + m], w[W.CLOCK + m], w[W.LEFT + m] = x, y, clock, 1.0 * surface
                w[W.VX + m], w[W.VY + m] = velocity(frame[0], frame[1], lanes[1, j], lanes[2, j])
                w[W.NUMBER + m] = 1.0 * j
                m += 1
        padded_contacts(w, m, table)
        for i in range(m):
            j, clock = int(w[W.NUMBER + i]), w[W.CLOCK + i]
            new, t, letters[j], outcomes[j] = arrived(impact_of(w, i, table), clock, table)
            later = 0.0 if outcomes[j] & ESCAPED or not timely else (clock + t) % period_of(table)
            put_at(lanes, j, new, later, timely)
    room[0] = 0.0  # an array lives up to its last use, its numbers do not keep it


@inlined
def put_at(lanes: Any, j: int, state: Any, phase: float, timely: bool) -> None:
    """Write a state into a lane, with a phase where there is one."""
    lanes[0, j], lanes[1, j], lanes[2, j] = state
    if timely:
        lanes[3, j] = phase
