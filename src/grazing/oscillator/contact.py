"""From one contact to the next: the first impact of a flight, and what the wall does with the ball.

Why no impact can be missed. Let F = f - k^2 sigma have one sign on a window, y = u - sigma, and phi > 0 solve the
unforced equation there. In the variable xi with dxi = e^{-alpha t}/phi^2 dt the quotient y/phi is concave where
F <= 0 and convex where F >= 0. So in a window with F < 0 a flight from above hits the wall exactly if it ends
below it, and at one point; in a window with F > 0 it has one lowest point, and grazing can happen only there.
Every search below is for a single simple root in a bracket: there is no scan and no step size.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from math import sqrt, tan
from typing import Any

from grazing.oscillator.constants import Constants, forcing
from grazing.oscillator.flight import Anchor, anchored, flight, noise
from grazing.outcome import AMBIGUOUS, BAD_LAW, CHATTER, GRAZE, OK, STUCK

#: What a contact ends in: the ball flies on, lies until the strobe, or is released by the forcing within the period.
FLIES, LIES, RELEASED = 0, 1, 2
INFINITY = float("inf")
NAN = float("nan")


def window_sign(i: int, c: Constants) -> float:
    """Return the sign of F in window i."""
    return -c.first if i % 2 == 1 else c.first


def window_of(t: float, i: int, c: Constants) -> int:
    """Return the window that begins at t or contains it, looking from window i on."""
    while i + 2 < len(c.edges) and t >= c.edges[i + 1] and c.edges[i + 1] < c.T:
        i += 1
    return i


def descent(a: Anchor, lo: float, hi: float, s: float, c: Constants) -> tuple[float, float]:
    """Return the time and velocity of the only zero of y in (lo, hi], where y(lo) >= 0 > y(hi); s is a first guess."""
    settled = noise(hi, a, c) / 64.0
    if a.y == 0.0:  # a hop from the wall: settle relative to its own height
        settled = min(settled, 2e-16 * abs(a.v) * s)
    for _ in range(100):
        y, v = flight(s, a, c)
        if y >= 0.0:
            lo = s
        else:
            hi = s
        if abs(y) <= settled and v < 0.0:
            new = s - y / v
            s = new if lo <= new <= hi else s
            break
        new = s - y / v if v < 0.0 else lo
        if not lo < new < hi:
            new = 0.5 * (lo + hi)
        if new == s or new == lo or new == hi:
            break
        s = new
    _y, v = flight(s, a, c)
    return s, min(v, 0.0)


def slope_of_phi(s: float, length: float, c: Constants) -> float:
    """Return phi'/phi of the comparison solution on a piece of this length, s from its start."""
    if c.q2 >= 0.0:
        return c.l2
    return c.l2 - c.spread * tan(c.spread * (s - 0.5 * length))


def lowest(a: Anchor, length: float, c: Constants) -> tuple[float, float]:
    """Return where y/phi is lowest on a piece with F > 0 that starts falling and ends rising, and y there.

    The zero of g = v - (phi'/phi) y, where g' = F - (alpha + phi'/phi) g; stops at the first point below the wall.
    """
    lo, hi = 0.0, length
    s, y = 0.5 * length, 0.0
    for _ in range(100):
        y, v = flight(s, a, c)
        if y < 0.0:
            break
        psi = slope_of_phi(s, length, c)
        g = v - psi * y
        if g < 0.0:
            lo = s
        else:
            hi = s
        F, _dF = forcing(a.t + s, c)
        rise = F - (c.alpha + psi) * g
        new = s - g / rise if rise > 0.0 else lo
        if not lo < new < hi:
            new = 0.5 * (lo + hi)
        # an error of 1e-9 in the time is one of 1e-18 in the height
        if abs(new - s) <= 1e-9 * length or new == lo or new == hi:
            break
        s = new
    return s, y


def piece_hit(
    a: Anchor, length: float, sign: float, end: float, c: Constants
) -> tuple[bool, float, float, float, float, int]:
    """Follow one piece of a window: (hit, time, velocity) of its impact, else (y, v) at its end, and flags."""
    yb, vb = flight(length, a, c)
    flags = AMBIGUOUS if end >= c.T and abs(yb) <= noise(length, a, c) and vb < 0.0 else OK
    if sign < 0.0:
        if yb >= 0.0:
            return False, length, vb, yb, vb, flags
        F, _dF = forcing(a.t, c)
        pull = c.alpha * a.v - F
        guess = 2.0 * a.v / pull if a.y == 0.0 and pull > 0.0 else 0.5 * length
        s, v = descent(a, 0.0, length, guess if guess < length else 0.5 * length, c)
        return True, s, v, yb, vb, flags
    if a.v - slope_of_phi(0.0, length, c) * a.y >= 0.0:
        return False, length, vb, max(yb, 0.0), vb, OK
    if yb < 0.0:
        s, v = descent(a, 0.0, length, 0.5 * length, c)
        return True, s, v, yb, vb, flags
    if vb - slope_of_phi(length, length, c) * yb < 0.0:
        return False, length, vb, yb, vb, flags
    low, y_low = lowest(a, length, c)
    close = abs(y_low) <= noise(low, a, c)
    flags = (AMBIGUOUS | GRAZE) if close else OK
    if y_low >= 0.0:
        return False, length, vb, yb, vb, flags
    s, v = descent(a, 0.0, low, 0.5 * low, c)
    return True, s, v, yb, vb, flags


def next_contact(t: float, y: float, v: float, i: int, c: Constants) -> tuple[bool, float, float, float, int, int]:
    """Fly from (t, y, v) in window i to the first impact, or to the end of the period.

    Returns
    -------
    hit : bool
    t, y, v : float
        Where the flight ends: at an impact y = 0 and v is the incoming velocity, else t = T.
    i : int
        The window at t.
    flags : int
    """
    flags = OK
    while t < c.T:
        i = window_of(t, i, c)
        end = min(c.edges[i + 1], t + c.piece)
        a = anchored(t, y, v, c)
        hit, s, v_hit, yb, vb, said = piece_hit(a, end - t, window_sign(i, c), end, c)
        flags |= said
        if hit:
            return True, min(t + s, c.T), 0.0, v_hit, i, flags
        t, y, v = end, yb, vb
        if y == 0.0 and v < 0.0:  # an impact exactly at the edge
            return True, t, y, v, i, flags
    return False, c.T, y, v, i, flags


def chatter_completes(t: float, w: float, end: float, ratio: float, speed: float, c: Constants) -> bool:
    """Return whether a ball that leaves the wall at t with w > 0 comes to rest before ``end``, where F < 0 throughout.

    With m <= -F <= M on [t, t + e] every hop lasts at most 2 w/m and ends with at most sqrt(M/m) w, and the law
    returns at most ``ratio`` of a speed up to ``speed``. The geometric sum then bounds the whole sequence.
    """
    F, _dF = forcing(t, c)
    if ratio >= 1.0 or F >= 0.0:
        return False
    e = 4.0 * w / (-F * (1.0 - ratio))
    while t + e <= end:
        Fe, _dFe = forcing(t + e, c)
        slack = 0.125 * c.bend * e * e
        m = min(-F, -Fe) - slack
        M = max(-F, -Fe) + slack
        if m > 0.0:
            grown = sqrt(M / m)
            if ratio * grown < 1.0 and grown * w <= speed and 2.0 * w <= e * m * (1.0 - ratio * grown):
                return True
        e *= 2.0
    return False


@lru_cache(maxsize=256)
def departure_of(law: Callable[..., float], contraction: Callable[..., Any]) -> Callable[..., Any]:
    """Return the contact rule for a reset law.

    Parameters
    ----------
    law : callable
        ``law(v_minus, p) -> v_plus``.
    contraction : callable
        ``contraction(p) -> (ratio, speed)``: v_plus <= ratio |v_minus| for |v_minus| <= speed.

    Returns
    -------
    callable
        ``departure(t, v, i, patience, c) -> (kind, t, w, i, flags)`` for a contact at t in window i with incoming
        v <= 0. ``kind`` is FLIES (from t with velocity w), LIES (until T) or RELEASED (flies from t with w = 0).
        Chatter is completed in closed form once the ball leaves slower than ``patience``.
    """

    def departure(t: float, v: float, i: int, patience: float, c: Constants) -> tuple[int, float, float, int, int]:
        i = window_of(t, i, c)
        pressed = window_sign(i, c) < 0.0
        flags = OK
        if v == 0.0 and not pressed:
            return FLIES, t, 0.0, i, flags
        w = law(v, c.p)
        if not 0.0 <= w < INFINITY:
            return FLIES, t, NAN, i, BAD_LAW
        if w == 0.0 and pressed and v < 0.0:
            w = law(0.0, c.p)
            if not 0.0 <= w < INFINITY:
                return FLIES, t, NAN, i, BAD_LAW
        if not pressed:
            return FLIES, t, w, i, flags
        end = c.edges[i + 1]
        if w > 0.0:
            ratio, speed = contraction(c.p)
            if w > patience or not chatter_completes(t, w, end, ratio, speed, c):
                return FLIES, t, w, i, flags
            flags |= CHATTER
        flags |= STUCK
        if end >= c.T:
            return LIES, c.T, 0.0, i, flags
        return RELEASED, end, 0.0, i + 1, flags

    return departure
