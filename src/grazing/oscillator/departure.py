"""What the wall does with a ball that meets it: it leaves, comes to rest by chatter, or lies until it is released."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from math import sqrt
from typing import Any

from grazing.kernel.primitives import unit
from grazing.oscillator.constants import Constants, forcing
from grazing.oscillator.contact import (
    INFINITY,
    NAN,
    NO_LAUNCH,
    Ball,
    next_launch,
    placed,
    push_in_doubt,
    window_of,
    window_sign,
)
from grazing.outcome import AMBIGUOUS, BAD_LAW, CHATTER, DIVERGED, OK, STUCK

#: What a contact ends in: the ball flies on, lies until the strobe, or is released by the forcing within the period.
FLIES, LIES, RELEASED = 0, 1, 2


def hop_bounds(m: float, M: float, w: float, c: Constants) -> tuple[float, float]:
    """Return (n, s): a hop of speed w, or less, lasts at most 2 w/n and lands with at most s w, see docs/chatter.md.

    With a = max(-alpha, 0), b = max(-k^2, 0): n = m - a w - b w^2/(2 n), and x^2 <= w^2 (M + a x)/n for the landing
    speed x. n is 0 where there is none: the hop may be one that does not come back.
    """
    a, b = max(-c.alpha, 0.0), max(-c.k2, 0.0)
    rest = m - a * w
    room = rest * rest - 2.0 * b * w * w
    if not (rest > 0.0 and room >= 0.0):
        return 0.0, INFINITY
    n = 0.5 * (rest + sqrt(room))
    lift = 0.5 * a * w / n
    return n, lift + sqrt(lift * lift + M / n)


def chatter_completes(
    t: float, w: float, end: float, ratio: float, speed: float, c: Constants, blur: float = 0.0
) -> bool:
    """Return whether a ball that leaves the wall at t with w > 0 comes to rest before ``end``, where F < 0 throughout.

    With m <= -F <= M on [t, t + e] every hop lasts at most 2 w/m and ends with at most sqrt(M/m) w, and the law
    returns at most ``ratio`` of a speed up to ``speed``. The geometric sum then bounds the whole sequence. Where
    alpha or the stiffness is negative both are those of :func:`hop_bounds`. ``blur`` is added to m and taken off M.
    """
    F, _dF = forcing(t, c)
    if not 0.0 < ratio < 1.0 or F >= 0.0:  # ratio 0 is one impact and a dead stop
        return False
    e = max(4.0 * w / (-F * (1.0 - ratio)), 1e-16 * c.T)
    while t + e <= end:
        Fe, _dFe = forcing(t + e, c)
        slack = 0.125 * c.bend * e * e - blur
        m = min(-F, -Fe) - slack
        M = max(-F, -Fe) + slack
        if m > 0.0:
            M = max(M, 0.0)  # of a force as weak as its rounding nothing is left
            m, grown = hop_bounds(m, M, w, c) if c.grows > 0.0 else (m, sqrt(M / m))
            if ratio * grown < 1.0 and grown * w <= speed and 2.0 * w <= e * m * (1.0 - ratio * grown):
                return True
        e *= 2.0
    return False


def beyond_doubles(w: float, t: float, speed: float, kick: float, c: Constants) -> bool:
    """Return whether a pressed ball hops for less than the spacing of times, by a law of which nothing is known.

    Such hops cannot be followed: times stand still, and in the end speeds lose their digits. ``speed`` is 0 where no
    contraction is known. A law with a ``kick`` at rest makes hops for ever; its impacts end at the budget, by name.
    """
    F, _dF = forcing(t, c)
    return speed <= 0.0 and kick == 0.0 and w <= -1e-16 * c.T * F


@lru_cache(maxsize=256)
def departure_of(
    law: Callable[..., float], slope: Callable[..., float], contraction: Callable[..., Any]
) -> Callable[..., Any]:
    """Return the contact rule for a reset law.

    Parameters
    ----------
    law, slope : callable
        ``law(v_minus, p) -> v_plus`` and its derivative in v_minus.
    contraction : callable
        ``contraction(p) -> (ratio, speed)``: v_plus <= ratio |v_minus| for |v_minus| <= speed.

    Returns
    -------
    callable
        ``departure(ball, patience, c) -> (kind, ball, flags)`` for a contact with v <= 0. ``kind`` is FLIES (on, with
        the ball's velocity), LIES (until T) or RELEASED (flies from the ball's time with v = 0). Chatter is completed
        in closed form once the ball leaves slower than ``patience``. A law that jumps within the error of the
        impact's velocity makes the step ambiguous, and so does a rest that a doubtful zero of F may end, or one that
        is reached by hops too short to be followed, under a law that is not known to contract.
    """

    @unit
    def departure(ball: Ball, patience: float, c: Constants) -> tuple[int, Ball, int]:
        t, v = ball.t, ball.v
        i = window_of(t, ball.i, c)
        pressed = window_sign(i, c) < 0.0
        if not v > -INFINITY:
            return FLIES, placed(t, NAN, NAN, i), DIVERGED
        w = law(v, c.p) if v < 0.0 or pressed else 0.0
        still = v == 0.0 or w == 0.0
        if w == 0.0 and pressed:
            w = law(0.0, c.p)
        if not 0.0 <= w < INFINITY:
            return FLIES, placed(t, 0.0, w, i), BAD_LAW
        flags = OK
        launch = NO_LAUNCH
        if v < 0.0:
            g = slope(v, c.p)
            launch, dv = next_launch(ball, w, g, c)
            jump = abs(law(min(v + dv, 0.0), c.p) - law(v - dv, c.p))
            if jump > 4.0 * abs(g) * dv + 1e-12 * (w - v):
                flags |= AMBIGUOUS
        if still and push_in_doubt(t, launch.late, law(0.0, c.p) > 0.0, c):
            flags |= AMBIGUOUS
        if c.doubtful[i] > 0.0 and w <= 1e-13 * c.bend * c.T * c.T * c.T:  # a hidden pair of zeros could bring it back
            flags |= AMBIGUOUS
        if not pressed:
            return FLIES, Ball(t, 0.0, w, i, 0.0, 0.0, launch), flags
        end = c.edges[i + 1]
        if w > 0.0:
            ratio, speed = contraction(c.p)
            completes = w <= patience and chatter_completes(t, w, end, ratio, speed, c)
            if w <= patience and 0.0 < ratio < 1.0:
                # the same question with all the errors of this departure, one way and the other
                late, off = launch.late, launch.off
                if chatter_completes(t + late, w + off, end, ratio, speed, c, -c.blur) != chatter_completes(
                    t - late, max(w - off, 0.5 * w), end, ratio, speed, c, c.blur
                ):
                    flags |= AMBIGUOUS
            if not completes and not beyond_doubles(w, t, speed, law(0.0, c.p), c):
                return FLIES, Ball(t, 0.0, w, i, 0.0, 0.0, launch), flags
            flags |= CHATTER if completes else AMBIGUOUS
        elif v < 0.0:  # a dead stop, or a speed that only rounds to 0
            _ratio, speed = contraction(c.p)
            if beyond_doubles(-v, t, speed, 0.0, c):
                flags |= AMBIGUOUS
        flags |= STUCK
        if c.doubtful[i] > 0.0:  # is it released, and when?
            flags |= AMBIGUOUS
        if end >= c.T:
            return LIES, placed(c.T, 0.0, 0.0, i), flags
        return RELEASED, placed(end, 0.0, 0.0, i + 1), flags

    return departure
