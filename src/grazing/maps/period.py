"""One period of the oscillator by the scalar routine: the reference for every faster way."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from math import log
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grazing.kernel.primitives import unit
from grazing.maps.hits import MANY, MOST
from grazing.maps.map import CHATTER_LETTER, STUCK_LETTER
from grazing.oscillator.constants import FAR, LEAP, OFFSET, Constants, forcing
from grazing.oscillator.contact import MAX_SWINGS, next_contact, placed
from grazing.oscillator.departure import FLIES, LIES, departure_of
from grazing.oscillator.flight import beside_far_wall, modes
from grazing.oscillator.frames import (
    alone,
    first_contact,
    frame_of,
    inside_wall,
    rest_in_doubt,
    seen_at_strobe,
    seen_from_strobe,
)
from grazing.outcome import (
    AMBIGUOUS,
    BAD_LAW,
    CHATTER,
    DIVERGED,
    GRAZE,
    INSIDE_WALL,
    OK,
    TOO_MANY_IMPACTS,
    TOO_MANY_SWINGS,
)

#: Impacts in one period after which the step gives up by name.
MAX_IMPACTS = 10_000
Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
INFINITY = float("inf")
NAN = float("nan")
#: A reset law, its slope and its contraction.
Law = tuple[Callable[..., float], Callable[..., float], Callable[..., Any]]


def saltation(t: float, v: float, w: float, slope: float, c: Constants) -> tuple[float, float, float, float]:
    """Return the saltation matrix of an impact at t with velocities v < 0 and w; undefined (NaN) at v = 0.

    S = [[w/v, 0], [(a_plus - g' a_minus)/v, g']] with a = F - alpha v; det S = g' w/v.
    """
    if v == 0.0:
        return NAN, NAN, NAN, NAN
    F, _dF = forcing(t, c)
    return w / v, 0.0, ((F - c.alpha * w) - slope * (F - c.alpha * v)) / v, slope


def log_size(x: float) -> float:
    """Return log|x|, minus infinity for 0."""
    return log(abs(x)) if x != 0.0 else -INFINITY


def product(
    a: tuple[float, float, float, float], b: tuple[float, float, float, float]
) -> tuple[float, float, float, float]:
    """Return the product of two 2 x 2 matrices, row by row."""
    return (
        a[0] * b[0] + a[1] * b[2],
        a[0] * b[1] + a[1] * b[3],
        a[2] * b[0] + a[3] * b[2],
        a[2] * b[1] + a[3] * b[3],
    )


@lru_cache(maxsize=256)
def period_of(
    law: Callable[..., float], slope: Callable[..., float], contraction: Callable[..., Any], with_tangent: bool
) -> Callable[..., Any]:
    """Return ``period(state, c)`` as :func:`walled_period` has it, over one wall at rest below the ball."""
    between = _period_of((law, slope, contraction), (law, slope, contraction), with_tangent, True)

    @unit
    def period(state: Any, c: Any) -> Any:
        return between(state, alone(c))

    return period


@lru_cache(maxsize=256)
def walled_period(first: Law, second: Law, with_tangent: bool) -> Callable[..., Any]:
    """Return ``period(state, c) -> (state, letter, outcome, J, near, slow)``: one period (0, T] between walls.

    The letter is that of the walls that are hit, in order, or the number of impacts where there is one wall; or it says
    that chatter was completed or that the ball lay throughout. An impact exactly at the end counts; the state returned
    is the one after it. J is the derivative row by row, then the logarithm of |det J|, summed up from flights and
    impacts: J itself loses it where damping is strong. ``near`` is the narrowest miss, see
    :func:`grazing.oscillator.contact.piece_hit`; ``slow`` the speed of the slowest impact; infinity for none.

    Parameters
    ----------
    first, second : tuple of callable
        ``law``, ``slope`` and ``contraction`` of the first wall and of the second.
    with_tangent : bool
    """
    return unit(_period_of(first, second, with_tangent, False))


def _period_of(first: Law, second: Law, with_tangent: bool, still: bool) -> Callable[..., Any]:
    """Return the period; ``still`` is for one wall at rest below the ball, whose frames are ``alone``."""
    departs, departs_b = departure_of(*first), departure_of(*second)
    slope, slope_b = first[1], second[1]

    def period(state: Any, c: Any) -> Any:
        u, v = state
        J, area, lost = (1.0, 0.0, 0.0, 1.0), 0.0, (NAN, NAN, NAN, NAN, NAN)
        T = c.a.T
        inside = inside_wall(u, c)
        if inside or not abs(u) < INFINITY or not abs(v) < INFINITY:
            return (NAN, NAN), 0, (INSIDE_WALL if inside else OK), lost, INFINITY, INFINITY
        if T > MAX_SWINGS * c.a.piece:
            return (NAN, NAN), 0, TOO_MANY_SWINGS, lost, INFINITY, INFINITY
        b, ball = (False, placed(0.0, max(u - c.za, 0.0), v, 0)) if still else seen_from_strobe(u, v, c)
        unsure = not still and rest_in_doubt(u, v, c)
        impacts, outcome, near, slow = 0, (AMBIGUOUS if unsure else OK), INFINITY, INFINITY
        contact = ball.y == 0.0 and ball.v <= 0.0
        smooth, aloft, letter, special, lay = True, True, 0, 0, False
        while True:
            if contact:
                aloft = False
                arrived, here = ball.v, c.a if still else frame_of(b, c)
                if b and not still:
                    kind, ball, flags = departs_b(ball, c.patience, here)
                else:
                    kind, ball, flags = departs(ball, c.patience, here)
                outcome |= flags
                if flags & (BAD_LAW | DIVERGED):
                    return (NAN, NAN), impacts, outcome, lost, near, slow
                if flags & CHATTER:
                    special = CHATTER_LETTER - (2 if b else 0)
                if arrived < 0.0 or ball.v > 0.0:
                    impacts += 1
                    letter = 3 * letter + (2 if b else 1) if impacts <= MOST else letter
                    slow = min(slow, -arrived)
                if with_tangent:
                    if kind != FLIES:
                        J, area = (0.0, 0.0, 0.0, 0.0), -INFINITY
                    elif arrived < 0.0:
                        steep = slope_b(arrived, here.p) if b else slope(arrived, here.p)
                        J = product(saltation(ball.t, arrived, ball.v, steep, here), J)
                        area += log_size(steep * ball.v / arrived)
                    else:  # a touch, or a kick from rest: nearby orbits do something else
                        smooth = False
                if kind == LIES:
                    lay = impacts == 0
                    break
                if impacts > MAX_IMPACTS:
                    return (NAN, NAN), impacts, outcome | TOO_MANY_IMPACTS, lost, near, slow
                if ball.t >= T:
                    break
            left = ball.t
            if still:
                contact, ball, flags, low = next_contact(ball, c.a)
            else:
                contact, b, ball, flags, low = first_contact(ball, b, c)
            near = min(near, low)
            outcome |= flags
            if with_tangent:
                J = product(modes(ball.t - left, c.a), J)
                area -= c.a.alpha * (ball.t - left)
            if not contact:
                break
        end = (ball.y + c.za, ball.v) if still else seen_at_strobe(ball, b, c)
        if still and aloft and abs(end[0]) < FAR * abs(c.za) and c.a.grows * T <= LEAP:
            end = beside_far_wall(T, u, v, c.a.p[OFFSET], c.a)
        whole = (J[0], J[1], J[2], J[3], area)
        if with_tangent and (not smooth or outcome & (GRAZE | AMBIGUOUS)):
            whole = lost
        if not c.two:
            letter = impacts
        elif impacts > MOST:
            letter = MANY
        if special != 0:
            letter = special
        elif lay:
            letter = STUCK_LETTER - (2 if b else 0)
        return end, letter, outcome, whole, near, slow

    return period


def periods_passed(omega: int, rows: Floats, first: Floats, last: Floats, letters: Ints, steps: int) -> Floats:
    """Return the time that so many periods take; ``omega`` is the place of the frequency in a row."""
    return np.broadcast_to(steps * 2.0 * np.pi / rows[:, omega, None], letters.shape)
