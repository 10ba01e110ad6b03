"""One period of the oscillator by the scalar routine: the reference for every faster way."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from math import log
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grazing.kernel.primitives import unit
from grazing.maps.map import CHATTER_LETTER, STUCK_LETTER
from grazing.oscillator.constants import FAR, LEAP, OFFSET, Constants, forcing
from grazing.oscillator.contact import MAX_SWINGS, next_contact, placed
from grazing.oscillator.departure import FLIES, LIES, departure_of
from grazing.oscillator.flight import beside_far_wall, modes
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
    """Return ``period(state, c) -> (state, letter, outcome, J, near, slow)``: one period (0, T] of the oscillator.

    The letter is the number of impacts, or says that chatter was completed or that the ball lay throughout. An impact
    exactly at the end counts; the state returned is the one after it. J is the derivative row by row,
    then the logarithm of |det J|, summed up from flights and impacts: J itself loses it where damping is strong.
    ``near`` is the narrowest miss, see
    :func:`grazing.oscillator.contact.piece_hit`; ``slow`` the speed of the slowest impact; infinity for none.
    """
    departure = departure_of(law, slope, contraction)

    @unit
    def period(state: Any, c: Any) -> Any:
        u, v = state
        J, area, lost = (1.0, 0.0, 0.0, 1.0), 0.0, (NAN, NAN, NAN, NAN, NAN)
        y = u - c.sigma
        if not y >= 0.0 or not abs(v) < INFINITY:
            return (NAN, NAN), 0, (INSIDE_WALL if y < 0.0 else OK), lost, INFINITY, INFINITY
        if c.T > MAX_SWINGS * c.piece:
            return (NAN, NAN), 0, TOO_MANY_SWINGS, lost, INFINITY, INFINITY
        ball = placed(0.0, y, v, 0)
        impacts, outcome, near, slow = 0, OK, INFINITY, INFINITY
        contact = y == 0.0 and v <= 0.0
        smooth, chattered, lay, aloft = True, False, False, True
        while True:
            if contact:
                aloft = False
                arrived = ball.v
                kind, ball, flags = departure(ball, INFINITY, c)
                outcome |= flags
                if flags & (BAD_LAW | DIVERGED):
                    return (NAN, NAN), impacts, outcome, lost, near, slow
                chattered = chattered or (flags & CHATTER) != 0
                if arrived < 0.0 or ball.v > 0.0:
                    impacts += 1
                    slow = min(slow, -arrived)
                if with_tangent:
                    if kind != FLIES:
                        J, area = (0.0, 0.0, 0.0, 0.0), -INFINITY
                    elif arrived < 0.0:
                        steep = slope(arrived, c.p)
                        J = product(saltation(ball.t, arrived, ball.v, steep, c), J)
                        area += log_size(steep * ball.v / arrived)
                    else:  # a touch, or a kick from rest: nearby orbits do something else
                        smooth = False
                if kind == LIES:
                    lay = impacts == 0
                    break
                if impacts > MAX_IMPACTS:
                    return (NAN, NAN), impacts, outcome | TOO_MANY_IMPACTS, lost, near, slow
                if ball.t >= c.T:
                    break
            left = ball.t
            contact, ball, flags, low = next_contact(ball, c)
            near = min(near, low)
            outcome |= flags
            if with_tangent:
                J = product(modes(ball.t - left, c), J)
                area -= c.alpha * (ball.t - left)
            if not contact:
                break
        u_end, v_end = ball.y + c.sigma, ball.v
        if aloft and abs(u_end) < FAR * abs(c.sigma) and c.grows * c.T <= LEAP:
            u_end, v_end = beside_far_wall(c.T, u, v, c.p[OFFSET], c)
        whole = (J[0], J[1], J[2], J[3], area)
        if with_tangent and (not smooth or outcome & (GRAZE | AMBIGUOUS)):
            whole = lost
        letter = CHATTER_LETTER if chattered else (STUCK_LETTER if lay else impacts)
        return (u_end, v_end), letter, outcome, whole, near, slow

    return period


def periods_passed(omega: int, rows: Floats, first: Floats, last: Floats, letters: Ints, steps: int) -> Floats:
    """Return the time that so many periods take; ``omega`` is the place of the frequency in a row."""
    return np.broadcast_to(steps * 2.0 * np.pi / rows[:, omega, None], letters.shape)
