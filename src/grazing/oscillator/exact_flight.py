"""Flights and the search for impacts in ball arithmetic, as one wall sees them.

A flight is the steady response and a free flight about it, as formulas. Where these would lose digits, near a singular
case or soon after the start, it is its Taylor series, with a bound on what is cut off, and for longer flights a sum of
matrix exponentials: the ball under the constant force, and a ball at rest under each harmonic, obey small linear
systems that have no singular case. Impacts are searched as in :mod:`grazing.oscillator.contact`: a
piece of a window of one sign holds at most one, and signs on both sides of it prove it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import cached_property
from math import factorial, inf, isfinite
from typing import TYPE_CHECKING

from grazing.oscillator.exact_motion import REACH, Motion, Window
from grazing.oscillator.sure import Beyond, Undecided, sign

if TYPE_CHECKING:
    from flint import arb, arb_mat, arb_poly

#: Bits to which the state at the end must be known, so that it can be rounded.
GOOD = 60
#: A state that is known to within 2^-TINY and may be 0 is 0.
TINY = 900
Curve = Callable[["arb"], tuple["arb", "arb"]]


def around(x: arb, radius: arb) -> arb:
    """Return a ball of all numbers within a radius of x."""
    from flint import arb

    return x + arb(0, 1) * radius


class Flight:
    """A flight from (y, v) at local time t.

    It is the steady response and a free flight, or the ball under a constant force, and at rest under each harmonic.
    """

    def __init__(self, motion: Motion, t: arb, y: arb, v: arb) -> None:
        self.motion, self.t, self.y, self.v = motion, t, y, v
        self.near = inf  # height of the lowest point that was no impact

    @cached_property
    def swing(self) -> tuple[arb, arb]:
        """The free flight at the start: what remains without the steady response."""
        Y, dY = self.motion.steady(self.t)
        return self.y - Y, self.v - dY

    @cached_property
    def parts(self) -> list[tuple[arb_mat, arb_mat]]:
        """The linear systems, each with its state at the start."""
        from flint import arb_mat

        found = [(self.motion.still, arb_mat([[self.y], [self.v], [self.motion.level]]))]
        for system, (a, b) in zip(self.motion.swings, self.motion.forces(self.t), strict=True):
            found.append((system, arb_mat([[0], [0], [a], [b]])))
        return found

    @cached_property
    def series(self) -> tuple[arb_poly, arb_poly, arb]:
        """The Taylor series of y and of v at the start, and the constant C of their tails."""
        from flint import arb_poly

        motion, K, x = self.motion, self.motion.terms, [self.y, self.v]
        for n, F in enumerate(motion.taylor(self.t, K - 2)[:-1], start=1):
            x.append((F - motion.alpha * (n * x[-1]) - motion.k2 * x[-2]) / (n * (n + 1)))
        last = ((abs(x[n]) * factorial(n) / motion.rate**n).upper() for n in (K - 2, K - 1))
        y = arb_poly(x)
        return y, y.derivative(), max(*last, (motion.strongest / motion.room).upper())

    def at(self, s: arb) -> tuple[arb, arb]:
        """Return (y, v) after time s."""
        motion = self.motion
        motion.count(1 + len(motion.waves))
        if motion.formulas and s > motion.short:
            (Y, dY), (h, dh) = motion.steady(self.t + s), motion.free(s, *self.swing)
            return Y + h, dY + dh
        reach = motion.rate * abs(s).upper()
        if reach <= REACH:
            height, speed, C = self.series
            tail = C * reach ** (motion.terms - 1) / factorial(motion.terms - 1) * reach.exp()
            return around(height(s), tail * reach / motion.terms), around(speed(s), tail * motion.rate)
        y, v = 0 * s, 0 * s
        for system, start in self.parts:
            state = (system * s).exp() * start
            y, v = y + state[0, 0], v + state[1, 0]
        return y, v

    def aloft(self, lo: arb, hi: arb) -> bool:
        """Return whether a swinging ball surely stays off the wall: the steady response less the swing around it."""
        motion = self.motion
        motion.count(1)
        (h, dh), (low, _slope) = self.swing, motion.steady(self.t + lo.union(hi))
        widest = hi if motion.alpha < 0 else lo
        swing = (h * h + (dh + motion.alpha * h / 2) ** 2 / -motion.q2).sqrt() * (-motion.alpha * widest / 2).exp()
        clear = low - swing
        if not clear > 0:
            return False
        self.near = min(self.near, float(clear.lower()))
        return True


def crossing(curve: Curve, lo: arb, hi: arb, x: arb) -> arb:
    """Return a ball around the only point in (lo, hi) where a curve passes from above 0 to below.

    ``curve`` returns value and slope, ``x`` is a first guess. Newton's method kept inside a bracket only guesses;
    the signs on both sides of the guess prove.
    """
    from flint import arb, ctx

    left, right, x = lo.mid(), hi.mid(), x.mid()
    step = arb(2) ** (16 - ctx.prec)
    for _ in range(4 * ctx.prec):
        value, slope = curve(x)
        if value > 0:
            left = x
        elif value < 0:
            right = x
        else:
            break
        new = (x - value / slope).mid() if slope < 0 else left
        if not (left < new and new < right):
            new = ((left + right) / 2).mid()
        done = abs(new - x) <= step * abs(x)
        x = new
        if done:
            break
    width = (step * abs(x)).mid()
    for _ in range(ctx.prec // 4):
        below, above = x - width, x + width
        if not (below > lo and above < hi):
            break
        if curve(below)[0] > 0 and curve(above)[0] < 0:
            return below.union(above)
        width *= 16
    raise Undecided


def pieces(flight: Flight, lo: arb, hi: arb) -> Iterator[tuple[arb, arb]]:
    """Cut a stretch of flight into pieces on which the lemma holds: under half a turn of the free ball.

    What surely stays off the wall is left out.
    """
    from flint import arb

    motion = flight.motion
    if sign(motion.q2) >= 0:
        yield lo, hi
        return
    longest = 0.95 * arb.pi() / (-motion.q2).sqrt()
    todo = [(lo, hi)]
    while todo:
        a, b = todo.pop()
        if b - a < longest:
            yield a, b
        elif not flight.aloft(a, b):
            middle = (a + b) / 2
            todo += [(middle, b), (a, middle)]


def pressed_hit(flight: Flight, lo: arb, hi: arb) -> arb | None:
    """Return the time of the impact in a piece with F < 0: there is one exactly if the ball would end below."""
    if sign(flight.at(hi)[0]) > 0:
        return None
    guess = (lo + hi) / 2
    if lo.is_zero() and flight.y.is_zero():  # a hop from the wall: first as long as under a constant force
        hop = 2 * flight.v / (flight.motion.alpha * flight.v - flight.motion.force(flight.t)[0])
        guess = hop if hop > lo and hop < hi else guess
    return crossing(flight.at, lo, hi, guess)


def lifted_hit(flight: Flight, lo: arb, hi: arb) -> arb | None:
    """Return the time of the impact in a piece with F >= 0: there is one exactly if the lowest point is below."""
    motion = flight.motion
    swings = sign(motion.q2) < 0
    spread = abs(motion.q2).sqrt()

    def descent(s: arb) -> tuple[arb, arb]:
        """Return phi' y/phi - v and its slope; y/phi falls where it is positive."""
        slope = -motion.alpha / 2 - spread * ((spread * (s - (lo + hi) / 2)).tan() if swings else 1)
        y, v = flight.at(s)
        g = v - slope * y
        return -g, (motion.alpha + slope) * g - motion.force(flight.t + s)[0]

    if descent(lo)[0] <= 0:
        return None
    if sign(flight.at(hi)[0]) < 0:
        return crossing(flight.at, lo, hi, (lo + hi) / 2)
    if descent(hi)[0] >= 0:
        return None
    low = crossing(descent, lo, hi, (lo + hi) / 2)
    height = flight.at(low)[0]
    if sign(height) < 0:
        return crossing(flight.at, lo, low, (lo + low) / 2)
    flight.near = min(flight.near, float(height))
    return None


def hit(flight: Flight, lo: arb, hi: arb, window: int) -> arb | None:
    """Return the time of the first impact in a piece of a window, None if there is none."""
    return pressed_hit(flight, lo, hi) if window < 0 else lifted_hit(flight, lo, hi)


def next_impact(flight: Flight, i: int, windows: list[Window], until: arb | None = None) -> tuple[arb, arb, int] | None:
    """Return time, velocity and window of the next impact of a flight that starts in window i; None up to T.

    ``until`` is a time in (0, T] at which the search ends.
    """
    lo = 0 * flight.t
    for n in range(i, len(windows)):
        last = until is not None and sign(until - windows[n].end) <= 0
        hi = (until if until is not None and last else windows[n].end) - flight.t
        for a, b in pieces(flight, lo, hi):
            s = hit(flight, a, b, windows[n].sign)
            if s is not None:
                v = flight.at(s)[1]
                if not v < 0:
                    raise Undecided
                return flight.t + s, v, n
        if last:
            break
        lo = hi
    return None


def rounded(x: arb, origin: float) -> float:
    """Return origin + x as a float, or raise Undecided if x is not known well enough to be rounded."""
    from flint import arb

    if x.rel_accuracy_bits() < GOOD and not x.is_zero():
        if not abs(x) < arb(2) ** -TINY:
            raise Undecided
        return origin
    total = float(x + arb(origin))
    if not isfinite(total):
        raise Beyond
    return total
