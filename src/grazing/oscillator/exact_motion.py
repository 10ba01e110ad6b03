"""Forcing and free flight in ball arithmetic, as one wall sees them: rates, forces, formulas, windows of one sign.

The windows are algebra: the force is a polynomial with rational coefficients.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from math import factorial
from typing import TYPE_CHECKING, Any, NamedTuple

from grazing.oscillator.forcing import Forcing
from grazing.oscillator.sure import Beyond, Undecided, sign

if TYPE_CHECKING:
    from flint import arb, fmpq

#: Forces and states of flights that are evaluated at one precision; beyond, the period stays undecided.
BUDGET = 10_000
#: Longest period, in units of the fastest rate of the motion.
FAR = 1e9
#: Formulas in which terms cancel to less than this share give way to series and matrix exponentials; so do they for
#: flights that are as short a share of the fastest time scale.
NEAR = 2.0**-8
#: Longest time of a series, in units of the rate by which its derivatives grow at most.
REACH = 2
#: Bits beyond the working precision at which a series is cut off.
GUARD = 8
#: The share of a window at which its sign is looked at.
ODD = 0.4871939420700073


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
        from flint import arb, arb_mat, ctx

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
        # |y^(n)| <= C rate^n for n = terms - 2 and terms - 1 holds for all later n, by y'' = F - alpha y' - k^2 y and
        # |F^(n)| <= force rate^n, if force <= C room
        drag, stiffness = abs(self.alpha).upper(), abs(self.k2).upper()
        self.rate = (drag + stiffness.sqrt() + 2 * max(len(waves), 1) * self.omega).upper()
        self.room = (self.rate * self.rate - drag * self.rate - stiffness).lower()
        self.strongest = (abs(self.level) + sum((abs(c) + abs(s) for _j, c, s in self.waves), arb(0))).upper()
        self.terms = 8
        while arb(REACH) ** self.terms / factorial(self.terms) > arb(2) ** -(ctx.prec + GUARD):
            self.terms += 2
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
