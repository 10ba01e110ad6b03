"""Arbitrary-precision orbits of the forced impact oscillator, slow and plain, to judge the library by.

The flight u'' + alpha u' + k^2 u = f(t) is expanded in a Taylor series at the start of every step; the
coefficients follow from the equation itself, so resonance, critical damping, k = 0 and alpha = 0 are not
special.  The first contact in a step is isolated by ball arithmetic on the Taylor polynomial and its
derivative: an interval is settled when the height is positive on all of it, or when the velocity has one sign
on it and the height at its right end is known; any other interval is halved.  Nothing is scanned with a fixed
density and nothing is assumed about the sign of the forcing.

A comparison that the working precision cannot decide raises `Undecidable`.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import lru_cache
from typing import NamedTuple

from flint import arb, arb_mat, arb_poly, ctx

GUARD = 20  # working digits beyond the digits asked for
REACH = 6  # a step h has (rate bound) * h <= REACH
MAX_IMPACTS = 20_000  # in one period

Number = float | arb


class Undecidable(ArithmeticError):
    """A decision (a sign) lies within the rounding error of the working precision."""


@dataclass(frozen=True)
class Law:
    """The impact law v+ = -r v- for |v-| < speed, and v+ = -r v- + V otherwise."""

    r: float
    V: float = 0.0
    speed: float = 0.0

    def __call__(self, v: arb) -> arb:
        rebound = -arb(self.r) * v
        return rebound if sign(abs(v) - arb(self.speed)) < 0 else rebound + arb(self.V)

    @property
    def slope(self) -> arb:
        """g'(v-), which is -r for all three laws away from the trigger speed."""
        return -arb(self.r)


def newton(r: float) -> Law:
    """Newton's passive law, v+ = -r v-."""
    return Law(r)


def active(r: float, V: float) -> Law:
    """The active bumper, v+ = -r v- + V."""
    return Law(r, V)


def trigger(r: float, V: float, speed: float) -> Law:
    """A bumper that kicks only from an impact speed on."""
    return Law(r, V, speed)


@dataclass(frozen=True)
class Problem:
    """u'' + alpha u' + k^2 u = f(t) above u = sigma, v+ = law(v-) at it; every float is taken as exact.

    f(t) = offset + sum over j = 1, 2, ... of cos[j-1] cos(j omega (t + t0)) + sin[j-1] sin(j omega (t + t0)).
    """

    alpha: float
    k: float
    omega: float
    t0: float = 0.0
    offset: float = 0.0
    cos: tuple[float, ...] = (1.0,)
    sin: tuple[float, ...] = ()
    sigma: float = 0.0
    law: Law = Law(1.0)
    stiffness: float | None = field(default=None, repr=False)  # in place of k^2, of either sign

    @property
    def period(self) -> arb:
        """The forcing period at the working precision."""
        return 2 * arb.pi() / arb(self.omega)

    @property
    def harmonics(self) -> int:
        """The number of harmonics of the forcing."""
        return max(len(self.cos), len(self.sin), 1)


class Impact(NamedTuple):
    """One impact: its time and the velocities on both sides; v_plus is 0 where the ball comes to rest."""

    t: arb
    v_minus: arb
    v_plus: arb


class Strobe(NamedTuple):
    """The state at the end of one period, after any impact there, and the impacts of that period.

    `jacobian` is ((du/du0, du/dv0), (dv/du0, dv/dv0)) with respect to the start.  `factor` says how much a
    small error made at any earlier moment of the orbit can have grown by now (never below 1).
    """

    u: arb
    v: arb
    impacts: list[Impact]
    jacobian: tuple[tuple[arb, arb], tuple[arb, arb]] | None = None
    factor: float | None = None


def sign(x: arb) -> int:
    """The sign of x; `Undecidable` when the ball holds zero and is not zero."""
    if x > 0:
        return 1
    if x < 0:
        return -1
    if x == 0:
        return 0
    raise Undecidable(f"sign of {x}")


class _Taylor:
    """Taylor coefficients of the forcing and of the flight of one problem at one working precision."""

    def __init__(self, problem: Problem) -> None:
        p = problem
        self.phase0 = arb(p.t0)
        self.sigma = arb(p.sigma)
        self.k2 = arb(p.k) * arb(p.k) if p.stiffness is None else arb(p.stiffness)
        self.alpha = arb(p.alpha)
        self.level = arb(p.offset) - self.k2 * self.sigma
        pad = (0.0,) * p.harmonics
        self.waves = [
            (arb(j) * arb(p.omega), arb(c), arb(s))
            for j, c, s in zip(range(1, p.harmonics + 1), p.cos + pad, p.sin + pad, strict=False)
        ]
        # |n-th derivative| <= size * rate^n for the flight, with size = max(|y|, |v| / rate, amplitude)
        k = p.k if p.stiffness is None else abs(p.stiffness) ** 0.5
        self.rate = max(float(self.waves[-1][0]), abs(p.alpha) + k + 1.0) * (1 + 1e-12)
        self.amplitude = abs(self.level) + sum((abs(c) + abs(s) for _, c, s in self.waves), arb(0))
        self.step = arb(REACH / self.rate)

        size, self.order = 1.0, 0
        while size > 10.0 ** -(ctx.dps + 2) or self.order < 4 * REACH:
            self.order += 1
            size *= REACH / self.order
        n_range = range(self.order + 1)
        self.inverse = [arb(1) / ((n + 1) * (n + 2)) for n in n_range]
        self.stiffness = [self.k2 * i for i in self.inverse]
        self.damping = [self.alpha / (n + 2) for n in n_range]
        self.turns = [[w / (n + 1) for n in n_range] for w, _, _ in self.waves]
        # twice the first dropped term bounds the dropped terms and their derivatives, as REACH < order / 4
        rate = arb(self.rate)
        self.tail = 2 * rate ** (self.order + 1) / arb(self.order + 1).gamma() / (self.order + 1)
        self.generator = arb_mat([[0, 1], [-self.k2, -self.alpha]])

    def forcing(self, t: arb) -> list[arb]:
        """Coefficients of F = f - k^2 sigma at t."""
        out = [arb(0)] * (self.order + 1)
        out[0] = self.level
        for (w, c, s), turn in zip(self.waves, self.turns, strict=True):
            sine, cosine = (w * (t + self.phase0)).sin_cos()
            x, y = c * cosine + s * sine, s * cosine - c * sine
            for n, q in enumerate(turn):
                out[n] += x
                x, y = y * q, -x * q
        return out

    def forcing_poly(self, t: arb) -> list[arb]:
        """Coefficients of F at t, the remainder as a last ball."""
        return [*self.forcing(t), arb(0, (self.tail * self.amplitude).upper())]

    def flight(self, t: arb, y: arb, v: arb, released: bool = False) -> list[arb]:
        """Coefficients of the height y = u - sigma at t, remainder as a last ball; F(t) = 0 if released."""
        f = self.forcing(t)
        if released:
            f[0] = arb(0)
        c = [y, v]
        for n in range(self.order - 1):
            c.append(f[n] * self.inverse[n] - self.stiffness[n] * c[n] - self.damping[n] * c[n + 1])
        size = abs(y).max(abs(v) / arb(self.rate)).max(self.amplitude)
        c.append(arb(0, (self.tail * size).upper()))
        return c

    def propagator(self, h: arb) -> arb_mat:
        """The derivative of the state after a flight of length h with respect to the state before it."""
        return (self.generator * h).exp()


@lru_cache(maxsize=64)
def _taylor(problem: Problem, dps: int) -> _Taylor:
    return _Taylor(problem)


def _right_sign(coefficients: list[arb]) -> tuple[int, list[arb]]:
    """The sign just right of the expansion point, and the coefficients without the leading zeros."""
    for n, c in enumerate(coefficients[:-1]):
        s = sign(c)
        if s:
            return s, coefficients[n:]
    return 0, []


def first_root(coefficients: list[arb], h: arb, digits: int) -> arb | None:
    """The first zero in (0, h] of a polynomial that is positive at 0, or None."""
    p = arb_poly(coefficients)
    slope = p.derivative()
    tiny = h * arb(10) ** -digits
    todo = [(arb(0), h)]
    while todo:
        a, b = todo.pop()  # p(a) > 0 is known
        span = a.union(b)
        if p(span) > 0:
            continue
        rise = slope(span)
        if rise > 0:
            continue
        if rise < 0:
            end = p(b)
            if end > 0:
                continue
            if end < 0:
                return _polish(p, slope, a, b, digits)
        if b - a < tiny:
            raise Undecidable(f"contact or clearance of {p(b).str(3)} near the time {b.str(10)} of a step")
        middle = ((a + b) / 2).mid()
        todo += [(middle, b), (a, middle)]
    return None


def _polish(p: arb_poly, slope: arb_poly, a: arb, b: arb, digits: int) -> arb:
    """The zero of p in (a, b), where p falls through it."""
    x = ((a + b) / 2).mid()
    close = arb(10) ** -(digits + GUARD // 2)
    for _ in range(10 * ctx.dps):
        value = p(x)
        if value > 0:
            a = x
        elif value < 0:
            b = x
        else:
            return x
        new = (x - value / slope(x)).mid()
        if not (new > a and new < b):
            new = ((a + b) / 2).mid()
        if abs(new - x) < close * x:
            return new
        x = new
    raise Undecidable(f"no convergence to a contact near {x.str(10)}")


class _Orbit:
    """The state of one orbit, moved on by one period at a time."""

    def __init__(self, problem: Problem, u: Number, v: Number, start: Number, digits: int, jacobian: bool) -> None:
        self.problem, self.digits, self.jacobian = problem, digits, jacobian
        self.taylor = _taylor(problem, ctx.dps)
        self.start = arb(start)
        self.n = 0
        self.s = arb(0)  # time since the last strobe
        self.y, self.v = arb(u) - self.taylor.sigma, arb(v)
        self.resting = self.released = False
        self.impacts: list[Impact] = []
        self.segments: list[arb_mat] = []  # derivatives of the pieces of the orbit, in order
        self.rest_speed = arb(10) ** -(5 * digits // 8)
        height = sign(self.y)
        if height < 0:
            raise ValueError(f"the start u = {u} is below the obstacle at {problem.sigma}")
        if height == 0:
            speed = sign(self.v)
            if speed < 0:
                self.hit()
            elif speed == 0:
                self.settle()

    def time(self) -> arb:
        """The time within the forcing, less whole periods."""
        return self.start + self.s

    def settle(self) -> None:
        """Decide what a ball on the wall with v = 0 does."""
        side, _ = _right_sign(self.taylor.forcing_poly(self.time()))
        if side > 0:
            return
        if side < 0 and sign(self.problem.law(arb(0))) > 0:
            self.hit()
        else:
            self.rest()

    def rest(self) -> None:
        """Stay on the wall from now on; what happened before is forgotten."""
        self.y = self.v = arb(0)
        self.resting = True
        self.segments.append(arb_mat([[0, 0], [0, 0]]))

    def hit(self) -> None:
        """Apply the impact law at y = 0, v <= 0."""
        law, before = self.problem.law, self.v
        after = law(before).mid()
        force = self.taylor.forcing_poly(self.time())
        stops = sign(after) == 0 or (after < self.rest_speed and sign(law(arb(0))) == 0)
        stops = stops and _right_sign(force)[0] <= 0
        self.y, self.v = arb(0), arb(0) if stops else after
        t = self.start + self.n * self.problem.period + self.s
        self.impacts.append(Impact(t.mid(), before, self.v))
        if len(self.impacts) > MAX_IMPACTS:
            raise RuntimeError(f"more than {MAX_IMPACTS} impacts in period {self.n + 1}")
        if stops:
            self.rest()
        elif self.jacobian:
            alpha, slope = self.taylor.alpha, law.slope
            kick = (force[0] - alpha * after - slope * (force[0] - alpha * before)) / before
            self.segments.append(arb_mat([[after / before, 0], [kick, slope]]))

    def _advance_time(self, x: arb) -> None:
        if self.jacobian and not self.resting:
            self.segments.append(self.taylor.propagator(x))
        self.s = (self.s + x).mid()

    def period(self) -> Strobe:
        """Move on to the next strobe."""
        taylor, end = self.taylor, self.problem.period
        while True:
            left = (end - self.s).mid()
            last = not left > taylor.step
            h = left if last else taylor.step
            if self.resting:
                side, push = _right_sign([-c for c in taylor.forcing_poly(self.time())])
                root = first_root(push, h, self.digits) if side > 0 else None
            else:
                c = taylor.flight(self.time(), self.y, self.v, self.released)
                side, height = _right_sign(c)
                if side < 0:
                    raise Undecidable("a flight that starts below the wall")
                root = first_root(height, h, self.digits) if side > 0 else None
                p = arb_poly(c)
            x = h if root is None else root
            self._advance_time(x)
            if self.resting:
                if root is not None:
                    self.resting, self.released = False, True
            else:
                self.released = False
                self.v = p.derivative()(x).mid()
                self.y = p(x).mid() if root is None else arb(0)
                if root is not None:
                    self.hit()
            if root is None and last:
                return self._strobe()

    def _strobe(self) -> Strobe:
        impacts, self.impacts = self.impacts, []
        self.s, self.n = arb(0), self.n + 1
        matrix, factor = None, None
        if self.jacobian:
            product, worst = arb_mat([[1, 0], [0, 1]]), 1.0
            for segment in reversed(self.segments):
                product = arb_mat(2, 2, [e.mid() for e in (product * segment).entries()])
                rows = [abs(float(e)) for e in product.entries()]
                worst = max(worst, rows[0] + rows[1], rows[2] + rows[3])
                if all(e == 0 for e in product.entries()):
                    break
            j = product.entries()
            matrix, factor = ((j[0], j[1]), (j[2], j[3])), worst
        return Strobe((self.y + self.taylor.sigma).mid(), self.v, impacts, matrix, factor)


def advance(
    problem: Problem,
    u: Number,
    v: Number,
    periods: int,
    digits: int = 40,
    start: Number = 0.0,
    jacobian: bool = False,
) -> list[Strobe]:
    """The strobe states at start + T, start + 2 T, ... of the orbit from (u, v) at the time `start`.

    An infinite impact sequence is followed down to impact speeds of 10^(-5 digits / 8) and then put to rest.
    A contact with v = 0 counts as an impact only when the law kicks the ball off.
    """
    with ctx.workdps(digits + GUARD):
        orbit = _Orbit(problem, u, v, start, digits, jacobian)
        return [orbit.period() for _ in range(periods)]


def free_flight(problem: Problem, t: Number, u: Number, v: Number, dt: Number, digits: int = 40) -> tuple[arb, arb]:
    """The state a time dt (of either sign) after the state (u, v) at t, with no obstacle in the way."""
    with ctx.workdps(digits + GUARD):
        taylor = _taylor(problem, ctx.dps)
        now, y, w, left = arb(t), arb(u) - taylor.sigma, arb(v), arb(dt)
        while left != 0:
            h = left if abs(left) <= taylor.step else taylor.step * sign(left)
            p = arb_poly(taylor.flight(now, y, w))
            y, w = p(h).mid(), p.derivative()(h).mid()
            now, left = (now + h).mid(), (left - h).mid()
        return (y + taylor.sigma).mid(), w


def force(problem: Problem, t: Number, digits: int = 40) -> arb:
    """F(t) = f(t) - k^2 sigma."""
    with ctx.workdps(digits + GUARD):
        return _taylor(problem, ctx.dps).forcing(arb(t))[0]
