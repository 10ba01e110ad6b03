"""The contact rule of one wall in ball arithmetic: impacts, chatter that completes, rest.

The rule is that of :mod:`grazing.oscillator.contact`, the flights are those of :mod:`grazing.oscillator.exact_flight`.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import floor, inf, isfinite, log2, nextafter
from typing import TYPE_CHECKING

from grazing.oscillator.exact_motion import Motion, Window
from grazing.oscillator.reset import Reset, contraction_at
from grazing.oscillator.sure import Beyond, Slope, Sure, Undecided, arb_between, sign
from grazing.outcome import BAD_LAW, CHATTER, OK, STUCK
from grazing.parameter import parameter_tuple

if TYPE_CHECKING:
    from flint import arb

#: Hops of this share of a period, by a law that is not known to contract, are followed no further.
SHORT = 1e-16
#: A ball that leaves the wall faster is followed no further: twice its speed would be no double.
FASTEST = 2.0**1021


def hop_bounds(m: arb, M: arb, w: arb, motion: Motion) -> tuple[arb, arb]:
    """Return the bounds of :func:`grazing.oscillator.departure.hop_bounds` in balls."""
    if not (motion.alpha < 0 or motion.k2 < 0):
        return m, (M / m).sqrt()
    a, b = (-motion.alpha).max(0 * w), (-motion.k2).max(0 * w)
    rest = m - a * w
    room = rest * rest - 2 * b * w * w
    if not (rest > 0 and room >= 0):
        return 0 * m, 0 * m
    n = (rest + room.sqrt()) / 2
    lift = a * w / n / 2
    return n, lift + (lift * lift + M / n).sqrt()


def chatter_completes(t: arb, w: arb, end: arb, ratio: float, speed: float, motion: Motion) -> bool:
    """Return whether a ball that leaves the wall at t with w > 0 surely rests before ``end``, F < 0 up to there.

    The bound of :func:`grazing.oscillator.departure.chatter_completes`, in balls.
    """
    F, _dF = motion.force(t)
    if not (0.0 < ratio < 1.0 and F < 0):
        return False
    bend = 2 * abs(motion.taylor(t, 2)[2])
    e = 4 * w / (-F * (1 - ratio))
    while t + e < end:
        Fe, _dFe = motion.force(t + e)
        slack = bend * e * e / 8
        m, M = (-F).min(-Fe) - slack, (-F).max(-Fe) + slack
        if m > 0:
            m, grown = hop_bounds(m, M, w, motion)
            if m > 0 and ratio * grown < 1 and grown * w <= speed and 2 * w <= e * m * (1 - ratio * grown):
                return True
        e = (2 * e).mid()
    return False


class Rule:
    """The contact rule of one wall at the working precision."""

    def __init__(self, motion: Motion, windows: list[Window], reset: Reset, params: Mapping[str, float]) -> None:
        kind = parameter_tuple(tuple(params))
        self.motion, self.windows, self.reset = motion, windows, reset
        self.p = kind(*(Sure(x) for x in params.values()))
        self.constants = kind(*(Slope(x, 0) for x in params.values()))
        self.ratio, self.speed = contraction_at(reset, kind(*params.values()))

    def answer(self, v: arb) -> arb | None:
        """Return the velocity after an impact, None if the law breaks its promise."""
        try:
            w = self.reset.law(Sure(v), self.p)
            if isinstance(w, float) and not isfinite(w):
                return None
            ball = Sure(w).ball
        except Undecided:
            raise
        except Exception as error:  # the law is not ours: whatever it raises, it does not take balls
            raise Beyond from error
        return ball if sign(ball) >= 0 else None

    def contraction(self, w: arb) -> tuple[float, float]:
        """Return (ratio, speed) of the law near zero speed: as it is declared, else as it is proven for speeds up to w.

        With g(0) = 0 and |g'| <= ratio on [-speed, 0] the law gives at most ratio |v| there. (1, 0) if that is not so.
        """
        if self.speed > 0.0:
            return self.ratio, self.speed
        top = float(w.upper())
        if not top < FASTEST:
            raise Beyond
        speed = 2.0 ** (floor(log2(top)) + 2) if top > 0.0 else 0.0
        try:
            still = Sure(self.reset.law(Sure(0), self.p)).ball
            steep = Slope.of(self.reset.law(Slope(arb_between(-speed, 0.0), 1), self.constants)).slope
        except Exception:  # it takes no slopes, or has none there: nothing is known
            return 1.0, 0.0
        ratio = nextafter(float(abs(steep).upper()), inf)
        return (ratio, speed) if still.is_zero() and ratio < 1.0 else (1.0, 0.0)

    def leave(self, t: arb, v: arb, i: int, patience: arb | float) -> tuple[arb, arb, int, int]:
        """Return time, velocity and window after a contact with v <= 0 in window i, and the bits of the outcome.

        A ball that lies up to T leaves in the window after the last. Chatter is completed where it begins no faster
        than ``patience``.
        """
        window = self.windows[i]
        pressed = window.sign < 0
        if v.is_zero() and not pressed:
            return t, v, i, OK
        w = self.answer(v)
        if w is not None and w.is_zero() and pressed:
            w = self.answer(0 * t)
        if w is None:
            return t, v, i, BAD_LAW
        if not pressed:
            return t, w, i, OK
        flags = STUCK
        if not w.is_zero():
            ratio, speed = self.contraction(w)
            if not (w <= patience and chatter_completes(t, w, window.end, ratio, speed, self.motion)):
                if self.speed <= 0.0 and w < SHORT * self.motion.T * abs(self.motion.force(t)[0]):
                    raise Beyond  # hops without an end in sight
                return t, w, i, OK
            flags |= CHATTER
        return window.end, 0 * t, i + 1, flags
