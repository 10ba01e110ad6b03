"""One flight, seen from the walls that it may hit: the first contact with any of them.

Each wall sees the ball as that of an oscillator above it, see :mod:`grazing.oscillator.walled`, and its contacts are
found there, by the signs of its own force. The ball's numbers are kept as the wall that it left last sees them: so it
leaves that wall from y = 0 exactly. What the other wall finds before the next contact with this one comes first.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from grazing.kernel.primitives import built, replaced, unit
from grazing.oscillator.constants import Constants, angle, constants_of, section_phase
from grazing.oscillator.contact import INFINITY, NO_LAUNCH, Ball, Launch, contact_until
from grazing.oscillator.pointed import flight_fields, flight_kind, pointed_rows
from grazing.oscillator.rig import Rig
from grazing.oscillator.windows import series
from grazing.outcome import OK
from grazing.parameter import parameter_tuple

Floats = NDArray[np.float64]


class Frames(NamedTuple):
    """What a flight needs between walls: the oscillator that each sees, and how they lie to each other."""

    a: Constants  # of the lower wall, or of the only one
    b: Constants  # of the upper wall; those of the first where there is no other
    two: bool
    side: float  # 1 if the first wall is below the ball, -1 if above
    za: float  # where the first wall is at the strobe
    wa: float  # and how fast it moves
    zb: float
    wb: float
    gap: float  # constant part of the distance of the walls
    cos: tuple[float, ...]  # its harmonics
    sin: tuple[float, ...]
    blur: float  # bound on the rounding of the distance
    blur_w: float  # and of its rate
    unsure: float  # the same of the first wall's place at the strobe, where it moves
    unsure_w: float
    patience: float  # speed of departure up to which a ball that chatters surely stays away from the other wall


class Clock(NamedTuple):
    """What :func:`wave_at` needs of what a wall sees: room for harmonics, and the phase at the strobe."""

    cos: tuple[float, ...]
    sin: tuple[float, ...]
    omega: float
    theta: float


def frame_of(b: bool, c: Frames) -> Constants:
    """Return what the first wall sees, or the second."""
    return c.b if b else c.a


def alone(c: Constants) -> Frames:
    """Return the frames of an oscillator over one wall below it, at rest."""
    return Frames(
        c, c, False, 1.0, c.sigma, 0.0, c.sigma, 0.0, 0.0, c.cos, c.sin, 0.0, 0.0, 0.0, 0.0, float("inf")
    )  # fmt: skip


def seen_across(t: float, y: float, v: float, c: Frames) -> tuple[float, float]:
    """Return distance and velocity, as one wall sees them at time t, as the other sees them."""
    gap, rate = series(t, c.gap, c.cos, c.sin, c.a.omega, c.a.theta)
    return gap - y, rate - v


def across(ball: Ball, c: Frames) -> Ball:
    """Return the ball as the other wall sees it: not behind it, where rounding puts one that touches it."""
    y, v = seen_across(ball.t, ball.y, ball.v, c)
    y = max(y, 0.0)
    old = ball.launch
    launch = Launch(old.t, -old.w, -old.lift, old.late, old.off)
    error_y, error_v = ball.error_y + c.blur, ball.error_v + c.blur_w
    return Ball(ball.t, y, v, 0, error_y, error_v, launch)


@unit
def first_contact(ball: Ball, b: bool, c: Frames) -> tuple[bool, bool, Ball, int, float]:
    """Fly to the first impact with any wall, or to the end of the period.

    Parameters
    ----------
    ball : Ball
    b : bool
        Whether it is the second wall that sees the ball so.
    c : Frames

    Returns
    -------
    hit : bool
    b : bool
        Whether it is the second wall that is hit, and that sees the ball so.
    ball : Ball
    flags : int
    near : float
        See :func:`grazing.oscillator.contact.contact_until`.
    """
    here = frame_of(b, c)
    hit, end, flags, near = contact_until(ball, here.T, here)
    if not c.two:
        return hit, b, end, flags, near
    there = across(ball, c)
    if there.y == 0.0 and there.v < 0.0:  # on the other wall at the strobe, but for rounding
        return True, not b, there, OK, INFINITY
    before, other, said, low = contact_until(there, end.t, frame_of(not b, c))
    if before:  # what was found here beyond that never comes
        _hit, _end, flags, near = contact_until(ball, other.t, here)
        return True, not b, other, flags | said, min(near, low)
    return hit, b, end, flags | said, min(near, low)


def inside_wall(u: float, c: Frames) -> bool:
    """Return whether a state at the strobe is inside a wall, by more than the rounding of a moving wall's place."""
    return c.side * (u - c.za) < -c.unsure or (c.two and u - c.zb > c.unsure)


def seen_from_strobe(u: float, v: float, c: Frames) -> tuple[bool, Ball]:
    """Return the ball of a state at the strobe as a wall sees it, and whether that is the second wall.

    That is the first wall, but for a ball that touches the second one. A ball within the rounding of a moving wall's
    place, on its far side, is on the wall.
    """
    if c.two and u >= c.zb:
        return True, Ball(0.0, 0.0, c.wb - v, 0, 0.0, c.unsure_w, NO_LAUNCH)
    y = max(c.side * (u - c.za), 0.0)
    return False, Ball(0.0, y, c.side * (v - c.wa), 0, c.unsure if y != 0.0 else 0.0, c.unsure_w, NO_LAUNCH)


def rest_in_doubt(u: float, v: float, c: Frames) -> bool:
    """Return whether a state at the strobe may be that of a ball at rest on a moving wall, or beside it.

    The wall's place and velocity are then nearer than their rounding; a ball that has them to the bit lies on the wall.
    """
    y, w = c.side * (u - c.za), v - c.wa
    if c.two and c.zb - u < y:
        y, w = c.zb - u, v - c.wb
    return abs(y) <= c.unsure and abs(w) <= c.unsure_w and not (y == 0.0 and w == 0.0)


def seen_at_strobe(ball: Ball, b: bool, c: Frames) -> tuple[float, float]:
    """Return the state at the end of a period of the ball that a wall sees."""
    if b:
        return c.zb - ball.y, c.wb - ball.v
    return c.za + c.side * ball.y, c.wa + c.side * ball.v


def linked(a: Constants, b: Constants, link: tuple[float, ...]) -> Frames:
    """Return the frames of a model from what each wall sees, and numbers as :func:`link_of` gives them."""
    H = len(a.cos)
    two, side, room = link[0] > 0.0, link[1], link[2]
    first, second = 3, 4 + 2 * H
    za, wa = wave_at(link, first, a)
    zb, wb = wave_at(link, second, a)
    cos, sin = a.cos, a.sin
    size, speed, moved, rushed = abs(link[first]) + abs(link[second]), 0.0, 0.0, 0.0
    for j in range(H):
        c, s = link[second + 1 + j] - link[first + 1 + j], link[second + 1 + H + j] - link[first + 1 + H + j]
        cos, sin = replaced(cos, j, c), replaced(sin, j, s)
        size += abs(c) + abs(s)
        speed += (j + 1) * a.omega * (abs(c) + abs(s))
        wave = abs(link[first + 1 + j]) + abs(link[first + 1 + H + j])
        wave += abs(link[second + 1 + j]) + abs(link[second + 1 + H + j])
        moved, rushed = moved + wave, rushed + (j + 1) * a.omega * wave
    gap = link[second] - link[first]
    blur, unsure = 1e-15 * H * size, 1e-15 * H * (size + moved) if moved > 0.0 else 0.0
    # a hop that leaves no faster rises to no more than half the room in a period
    return Frames(
        a, b, two, side, za, wa, zb, wb, gap, cos, sin, blur, 1e-15 * H * speed,
        unsure, 1e-15 * H * rushed, 0.5 * max(room, 0.0) / a.T,
    )  # fmt: skip


def wave_at(link: tuple[float, ...], first: int, c: Constants | Clock) -> tuple[float, float]:
    """Return where a wall is at the strobe, and how fast it moves; its numbers begin at a place."""
    H = len(c.cos)
    cos, sin = c.cos, c.sin
    for j in range(H):
        cos, sin = replaced(cos, j, link[first + 1 + j]), replaced(sin, j, link[first + 1 + H + j])
    return series(0.0, link[first], cos, sin, c.omega, c.theta)


def walls_at_strobe(model: Rig, row: Floats) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return place and velocity of the first wall and of the last one at a row of the model's parameters and a phase.

    They are those of :func:`plain_frames`, without the windows of the force.
    """
    rows, none = np.asarray(row, np.float64).reshape(1, -1), (0.0,) * model.harmonics
    _alpha, _spring, omega, t0, *_rest, phase = rows[0].tolist()
    clock = Clock(none, none, omega, angle(omega, t0) + angle(omega, phase))
    link = tuple(link_rows(model, rows)[0].tolist())
    return wave_at(link, 3, clock), wave_at(link, 4 + 2 * model.harmonics, clock)


@lru_cache(maxsize=64)
def frames_kind(harmonics: int) -> type:
    """Return the named tuple of a row of :func:`frames_rows`."""
    flight = flight_fields(harmonics)
    waves = [f"{name}{j + 1}" for name in ("cos", "sin") for j in range(harmonics)]
    walls = [f"{wall}_{name}" for wall in "ab" for name in ("at", *(f"moves_{wave}" for wave in waves))]
    return parameter_tuple((*(f"{wall}_{name}" for wall in "ab" for name in flight), "two", "side", "room", *walls))


@lru_cache(maxsize=64)
def frames_of(harmonics: int) -> Callable[..., Frames]:
    """Return ``prepare(p) -> Frames`` for rows of :func:`frames_rows`."""
    kind, prepare = flight_kind(harmonics), constants_of(harmonics, section_phase)
    n = len(flight_fields(harmonics))
    m = 2 * n

    @unit
    def frames(p: Any) -> Any:
        return linked(prepare(built(kind, p[:n])), prepare(built(kind, p[n:m])), p[m:])

    return frames


def link_rows(model: Rig, rows: Floats) -> Floats:
    """Return how the walls lie to each other, for rows of the model's parameters.

    Whether there are two, the side of the first (1 for below, -1 for above), a lower bound on the room between them,
    and for each its position and the cosines and sines of its motion; the first one's again where there is one only.
    """
    two, H = len(model.walls) > 1, model.harmonics
    found = np.empty((len(rows), 5 + 4 * H))
    found[:, 0], found[:, 1], found[:, 2] = two, model.walls[0].sign, model.rooms(rows)
    for j, first in ((0, 3), (1 if two else 0, 4 + 2 * H)):
        waves = model.waves(j, rows)
        found[:, first] = rows[:, model.places[j].sigma]
        found[:, first + 1 : first + 1 + H] = waves[:, ::2]
        found[:, first + 1 + H : first + 1 + 2 * H] = waves[:, 1::2]
    return found


def frames_rows(model: Rig, rows: Floats, arithmetic: str) -> tuple[Floats, Floats]:
    """Return the numbers that a kernel needs at rows of the model's parameters and a phase, and what they point into.

    Each wall's numbers are those of :func:`grazing.oscillator.pointed.flight_fields`; the laws come by address.
    """
    seen = [np.column_stack([model.rows_seen_from(j, rows), rows[:, -1]]) for j in range(len(model.walls))]
    source = np.ascontiguousarray(np.column_stack(seen))
    found, at = [], 0
    for j, one in enumerate(seen):
        own = source[:, at : at + one.shape[1]]
        found.append(pointed_rows(model.harmonics, model.walls[j].law, model.kind_seen_from(j), own, arithmetic))
        at += one.shape[1]
    return np.ascontiguousarray(np.column_stack([found[0], found[-1], link_rows(model, rows)])), source


def plain_frames(model: Rig, row: Floats) -> Frames:
    """Return the frames at a row of the model's parameters and a phase, with laws as plain Python has them."""
    rows = np.asarray(row, np.float64).reshape(1, -1)
    prepare = constants_of(model.harmonics, section_phase)
    seen = [
        prepare(model.kind_seen_from(j)(*model.rows_seen_from(j, rows)[0].tolist(), float(rows[0, -1])))
        for j in range(len(model.walls))
    ]
    return linked(seen[0], seen[-1], tuple(link_rows(model, rows)[0].tolist()))
