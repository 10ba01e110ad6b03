"""Forcing, flights and the contact rule in ball arithmetic, as one wall sees them.

A flight is the steady response and a free flight about it, as formulas. Where these would lose digits, near a singular
case or soon after the start, it is a sum of matrix exponentials: the ball under the constant force, and a ball at rest
under each harmonic, obey small linear systems that have no singular case. Impacts are searched as in
:mod:`grazing.oscillator.contact`: a piece of a window of one sign holds at most one, and signs on both sides of it
prove it. The windows themselves are algebra: the force is a polynomial with rational coefficients.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import cached_property
from itertools import pairwise
from math import inf, isfinite
from typing import TYPE_CHECKING, Any, NamedTuple

from grazing.oscillator.forcing import Forcing
from grazing.oscillator.sure import Beyond, Undecided, sign

if TYPE_CHECKING:
    from flint import arb, arb_mat, fmpq

#: Forces and matrix exponentials that are evaluated at one precision; beyond, the period stays undecided.
BUDGET = 10_000
#: Longest period, in units of the fastest rate of the motion.
FAR = 1e9
#: Bits to which the state at the end must be known, so that it can be rounded.
GOOD = 60
#: Formulas in which terms cancel to less than this share give way to matrix exponentials; so do they for flights that
#: are as short a share of the fastest time scale.
NEAR = 2.0**-8
#: A state that is known to within 2^-TINY and may be 0 is 0.
TINY = 900
#: The share of a window at which its sign is looked at.
ODD = 0.4871939420700073

Curve = Callable[["arb"], tuple["arb", "arb"]]


class Window(NamedTuple):
    """A stretch of the period up to ``end`` on which F has one sign; 0 if F = 0 throughout."""

    end: arb
    sign: int


class Motion:
    """Forcing and free flight at the working precision, as a wall at rest at y = 0 sees them; counts evaluations.

    Parameters
    ----------
    alpha : float
    k2 : fmpq
        Stiffness.
    clock : Forcing
        Its omega and t0.
    level : fmpq
        Constant part of the force on a ball at the wall.
    waves : sequence of (fmpq, fmpq)
        Cosine and sine of each harmonic of the force.
    phase : float
        Where the local time begins.
    """

    def __init__(
        self, alpha: float, k2: fmpq, clock: Forcing, level: fmpq, waves: Sequence[tuple[fmpq, fmpq]], phase: float
    ) -> None:
        from flint import arb, arb_mat

        self.alpha, self.omega, self.k2 = arb(alpha), arb(clock.omega), arb(k2)
        self.q2 = self.alpha**2 / 4 - self.k2
        self.T = 2 * arb.pi() / self.omega
        self.theta = self.omega * (arb(clock.t0) + arb(phase))
        self.level = arb(level)
        self.waves = [(j, arb(c), arb(s)) for j, (c, s) in enumerate(waves, start=1) if c != 0 or s != 0]
        rates = [j * self.omega for j, _c, _s in self.waves]
        if not self.T * sum(rates, abs(self.alpha) + abs(self.k2).sqrt()) < FAR:
            raise Beyond
        self.turns = turning_phases(waves, level) if self.waves else []
        self.still = arb_mat([[0, 1, 0], [-self.k2, -self.alpha, 1], [0, 0, 0]])
        self.swings = [
            arb_mat([[0, 1, 0, 0], [-self.k2, -self.alpha, 1, 0], [0, 0, 0, W], [0, 0, -W, 0]]) for W in rates
        ]
        scale = self.alpha**2 + self.omega**2
        self.short = NEAR / sum(rates, abs(self.alpha) + abs(self.k2).sqrt())
        self.responses = []
        self.formulas = abs(self.q2) > NEAR * (self.alpha**2 + abs(self.k2)) and abs(self.k2) > NEAR * scale
        for j, c, s in self.waves:
            W = j * self.omega
            a, b = self.k2 - W * W, self.alpha * W
            size = a * a + b * b
            self.responses.append((j, W, (a * c - b * s) / size, (b * c + a * s) / size))
            self.formulas = self.formulas and size > NEAR * (abs(self.k2) + W * W) ** 2
        self.work = 0

    def count(self, work: int) -> None:
        """Count evaluations."""
        self.work += work
        if self.work > BUDGET:
            raise Beyond

    def forces(self, t: arb) -> list[tuple[arb, arb]]:
        """Return the force (a, b) of every harmonic at local time t: a acts, a' = W b, b' = -W a."""
        self.count(1)
        phase = self.omega * t + self.theta
        turns = [(j * phase).sin_cos() for j, _c, _s in self.waves]
        return [(c * x + s * y, s * x - c * y) for (_j, c, s), (y, x) in zip(self.waves, turns, strict=True)]

    def taylor(self, t: arb, terms: int) -> list[arb]:
        """Return the Taylor coefficients of F = f - k^2 sigma at local time t, the last one good for any later time."""
        from flint import arb

        total = [self.level, *([0 * self.level] * terms)]
        for (j, c, s), (a, b) in zip(self.waves, self.forces(t), strict=True):
            for n in range(terms):
                total[n] += a
                a, b = b * j * self.omega / (n + 1), -a * j * self.omega / (n + 1)
            total[terms] += arb(0, 1) * (c * c + s * s).sqrt() * (j * self.omega) ** terms / arb(terms + 1).gamma()
        return total

    def steady(self, t: arb) -> tuple[arb, arb]:
        """Return the steady response and its slope at local time t; balls without end where there is none."""
        Y, dY, phase = self.level / self.k2, 0 * t, self.omega * t + self.theta
        for j, W, hc, hs in self.responses:
            sine, cosine = (j * phase).sin_cos()
            Y, dY = Y + hc * cosine + hs * sine, dY + W * (hs * cosine - hc * sine)
        return Y, dY

    def free(self, s: arb, y: arb, v: arb) -> tuple[arb, arb]:
        """Return the free flight from (y, v) after time s, by formulas."""
        if self.q2 > 0:
            rate = self.q2.sqrt()
            sine, cosine = (rate * s).sinh_cosh()
        else:
            rate = (-self.q2).sqrt()
            sine, cosine = (rate * s).sin_cos()
        half, fading, sine = self.alpha / 2, (-self.alpha * s / 2).exp(), sine / rate
        return (
            fading * (cosine * y + sine * (half * y + v)),
            fading * (cosine * v - sine * (half * v + self.k2 * y)),
        )

    def force(self, t: arb) -> tuple[arb, arb]:
        """Return F and dF/dt at local time t."""
        F, dF, _rest = self.taylor(t, 2)
        return F, dF


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

    def at(self, s: arb) -> tuple[arb, arb]:
        """Return (y, v) after time s."""
        self.motion.count(1 + len(self.motion.waves))
        if self.motion.formulas and s > self.motion.short:
            (Y, dY), (h, dh) = self.motion.steady(self.t + s), self.motion.free(s, *self.swing)
            return Y + h, dY + dh
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


def turning_phases(waves: Sequence[tuple[fmpq, fmpq]], level: fmpq) -> list[arb]:
    """Return the phases phi = omega t + theta in (-pi, pi] at which the force turns round, ``level`` its mean.

    With x = tan(phi/2) the force is a polynomial over a power of 1 + x^2, and all its numbers are rational: its
    real roots are isolated with their multiplicities. At one of even multiplicity the sign stays. A degree below the
    full one is a root at phi = pi, where x is infinite.
    """
    from flint import arb, fmpq_poly

    full = 2 * len(waves)
    circle, turn = fmpq_poly([1, 0, 1]), (fmpq_poly([1, 0, -1]), fmpq_poly([0, 2]))  # (1 + ix)^2 = turn
    total, cosine, sine = fmpq_poly([level]), fmpq_poly([1]), fmpq_poly([0])
    for c, s in waves:
        cosine, sine = cosine * turn[0] - sine * turn[1], sine * turn[0] + cosine * turn[1]
        total = total * circle + c * cosine + s * sine
    roots: Any = total.numer().complex_roots()
    found = [2 * x.real.atan() for x, times in roots if x.imag.is_zero() and times % 2 == 1]
    return [*found, arb.pi()] if (full - total.degree()) % 2 == 1 else found


def windows_of(motion: Motion) -> list[Window]:
    """Return the windows of the period, F having one sign on each and opposite ones on neighbours.

    A zero at the strobe itself, as of sin t, separates nothing. It is there for theta = 0 only: the tangent of half of
    any other rational theta is transcendental (Lindemann), and x is not.
    """
    if not motion.waves:
        return [Window(motion.T, sign(motion.level))]
    ends = []
    for phase in motion.turns:
        if phase.is_zero() and motion.theta.is_zero():
            continue
        end = (phase - motion.theta) / motion.omega
        periods = (end / motion.T).floor().unique_fmpz()
        if periods is None:
            raise Undecided
        ends.append(end - periods * motion.T)
    ends.sort(key=lambda end: end.mid())
    ends = [0 * motion.T, *ends, motion.T]
    if not all(lo < hi for lo, hi in pairwise(ends)):
        raise Undecided
    i = max(range(len(ends) - 1), key=lambda i: (ends[i + 1] - ends[i]).mid())
    # double zeros like simple fractions of a window
    inside = sign(motion.force(ends[i] + ODD * (ends[i + 1] - ends[i]))[0])
    return [Window(end, inside if (n - i) % 2 == 0 else -inside) for n, end in enumerate(ends[1:])]


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
