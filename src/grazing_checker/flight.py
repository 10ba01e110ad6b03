"""The free flight as the checker sees it: Taylor series of y'' = F - alpha y' - k^2 y, with a bound on what is cut off.

In place of k^2 there may be a stiffness of either sign, and alpha may be < 0.

Nothing here is shared with the finder, which uses matrix exponentials.

The derivatives obey y^(n+2) = F^(n) - alpha y^(n+1) - k^2 y^(n). Let W be the highest frequency of F, A the sum of its
amplitudes and rho = |alpha| + sqrt|k^2| + 2 W. If |y^(n)| <= C rho^n for n = K - 2 and n = K - 1 and
A <= C (rho^2 - |alpha| rho - |k^2|), it holds for all later n, so that beyond K the series is at most
C (rho h)^K/K! e^(rho h). The derivative by a parameter obeys the same equation with another forcing, bounded likewise.
"""

from __future__ import annotations

from itertools import pairwise
from math import ceil, factorial
from typing import NamedTuple

from grazing_checker.balls import Ball, around, between_0_and, number, pi, polynomial, working_bits
from grazing_checker.reading import demand

#: A 2 x 2 matrix, row by row.
Matrix = tuple[Ball, Ball, Ball, Ball]

#: Longest step times rho.
STEP = 2
#: Most work for one certificate, in coefficients of series and the like: about half a minute.
MOST_WORK = 30_000_000
#: Most coefficients kept at a time, of the flights of a box and of one of them as other walls see it: some 230 MB of
#: 1024 bits. Each is paid for with 11 of the work or more, a proof flies three boxes at least, and then looks along
#: each flight for 10 a coefficient: nothing that the work allows is refused by this.
MOST_KEPT = 1_000_000
#: What is said of a certificate that asks for more.
TOO_MUCH = (
    "checking it takes too much work: the flights, steps, harmonics or impacts are more than the checker follows; "
    "prove an orbit of fewer periods, or rates and harmonics that are lower"
)


class Work:
    """What may still be computed for a certificate: a hostile one is rejected, not followed for days."""

    def __init__(self) -> None:
        self.left, self.kept = MOST_WORK, 0

    def spend(self, amount: int) -> None:
        """Take some of it; reject the certificate if none is left."""
        self.left -= amount
        demand(self.left >= 0, TOO_MUCH)

    def keep(self, coefficients: int) -> None:
        """Take memory; reject the certificate if it asks for too much at a time. Who lets go of it lowers ``kept``."""
        self.kept += coefficients
        demand(self.kept <= MOST_KEPT, TOO_MUCH)


class Motion(NamedTuple):
    """A model's parameters as balls, k2 the stiffness, and their derivatives by the one that is unknown."""

    alpha: Ball
    k2: Ball
    omega: Ball
    t0: Ball
    offset: Ball
    sigma: Ball
    cos: list[Ball]
    sin: list[Ball]
    slopes: dict[str, Ball]

    @property
    def period(self) -> Ball:
        """The period of the forcing."""
        return 2 * pi() / self.omega

    @property
    def level(self) -> Ball:
        """The constant part of F = f - k^2 sigma."""
        return self.offset - self.k2 * self.sigma

    def slope(self, name: str) -> Ball:
        """Return the derivative of a parameter by the unknown one."""
        return self.slopes.get(name, number(0))

    def period_slope(self) -> Ball:
        """Return the derivative of the period by the unknown parameter."""
        return -self.period / self.omega * self.slope("omega")

    def turns(self, t: Ball) -> list[tuple[int, Ball, Ball]]:
        """Return (j, cos, sin) of the phase of every harmonic at time t."""
        found = []
        for j in range(1, len(self.cos) + 1):
            sine, cosine = (j * self.omega * (t + self.t0)).sin_cos()
            found.append((j, cosine, sine))
        return found

    def force(self, t: Ball) -> Ball:
        """Return F at time t."""
        total = self.level
        for j, cosine, sine in self.turns(t):
            total += self.cos[j - 1] * cosine + self.sin[j - 1] * sine
        return total


class Series(NamedTuple):
    """A Taylor series: coefficients, the constant C of its tail, and rho."""

    terms: list[Ball]
    C: Ball
    rho: Ball

    def __call__(self, s: Ball, order: int = 0) -> Ball:
        """Return the derivative of some order (0, 1 or 2) after time s, of either sign; s may be a ball."""
        K = len(self.terms)
        reach = self.rho * abs(s).upper()
        tail = self.C * self.rho**order * reach ** (K - order) / factorial(K - order) * reach.exp()
        return around(polynomial(self.terms, s, order), tail.upper())


class Checked:
    """Free flights of a motion at the working precision; ``sensitive`` adds the derivative by the parameter."""

    def __init__(self, motion: Motion, sensitive: bool = False, work: Work | None = None) -> None:
        self.motion, self.sensitive, self.work = motion, sensitive, work or Work()
        count = max(len(motion.cos), 1)
        self.W = (count * motion.omega).upper()
        drag, stiffness = abs(motion.alpha).upper(), abs(motion.k2).upper()
        self.rho = (drag + stiffness.sqrt() + 2 * self.W).upper()
        self.room = (self.rho * self.rho - drag * self.rho - stiffness).lower()
        demand(self.room > 0, "the rates of the model cannot be bounded")
        self.A = (abs(motion.level) + sum((abs(x) for x in (*motion.cos, *motion.sin)), number(0))).upper()
        terms = 16
        while number(STEP) ** terms / factorial(terms) > number(1, -(working_bits() + 16)):
            terms += 4
        self.K = terms
        self.steps = [number((n + 1) * (n + 2)) for n in range(terms)]
        self.drags = [motion.alpha * (n + 1) for n in range(terms)]

    def keep(self, steps: int) -> None:
        """Take the work and the memory of so many steps, before they are made."""
        self.work.keep(steps * self.K)
        self.work.spend(steps * self.K * (len(self.motion.cos) + 10) * (4 if self.sensitive else 1))

    def forces(self, t: Ball) -> list[Ball]:
        """Return the Taylor coefficients of F at time t."""
        m = self.motion
        total = [m.level, *([number(0)] * (self.K - 1))]
        for j, cosine, sine in m.turns(t):
            c, s, W = m.cos[j - 1], m.sin[j - 1], j * m.omega
            self._add(total, c * cosine + s * sine, W * (s * cosine - c * sine), W)
        return total

    def _add(self, total: list[Ball], value: Ball, slope: Ball, W: Ball) -> None:
        """Add the series of a solution of x'' = -W^2 x with that value and slope."""
        turned, steps = -W * W, self.steps
        for n in range(0, len(total), 2):
            total[n] = total[n] + value
            value = turned * value / steps[n]
        for n in range(1, len(total), 2):
            total[n] = total[n] + slope
            slope = turned * slope / steps[n]

    def force_slopes(self, t: Ball, y: list[Ball]) -> tuple[list[Ball], Ball]:
        """Return the Taylor coefficients of what forces the derivative by the parameter, and the bound of its series.

        It is dF/dp - (d alpha/dp) v - (d k^2/dp) y.
        """
        m, K = self.motion, self.K
        dalpha, dk2 = m.slope("alpha"), m.slope("k2")
        level = m.slope("offset") - dk2 * m.sigma - m.k2 * m.slope("sigma")
        total, bound = [level, *([number(0)] * (K - 1))], abs(level)
        for j, cosine, sine in m.turns(t):
            c, s, W = m.cos[j - 1], m.sin[j - 1], j * m.omega
            dc, ds = m.slope(f"cos{j}"), m.slope(f"sin{j}")
            self._add(total, dc * cosine + ds * sine, W * (ds * cosine - dc * sine), W)
            # d/dp of the phase is j (dw (t + t0) + w dt0): it grows with t, so that its series is a product
            turn = [number(0)] * K
            self._add(turn, s * cosine - c * sine, -W * (s * sine + c * cosine), W)
            at, rate = j * (m.slope("omega") * (t + m.t0) + m.omega * m.slope("t0")), j * m.slope("omega")
            for n in range(K):
                total[n] += at * turn[n] + (rate * turn[n - 1] if n else 0)
            # |n-th derivative| <= |at| W^n A_j + rate n W^(n-1) A_j, and n <= 2^n / 2 * 1, W >= omega
            size = abs(c) + abs(s)
            bound += abs(dc) + abs(ds) + size * (abs(at) + abs(rate) / (2 * m.omega))
        for n in range(K):
            rising = (n + 1) * y[n + 1] if n + 1 < len(y) else number(0)
            total[n] -= dalpha * rising + dk2 * (y[n] if n < len(y) else 0)
        return total, bound

    def solution(self, F: list[Ball], y: Ball, v: Ball, bound: Ball) -> Series:
        """Return the series of x'' = F - alpha x' - k^2 x from (y, v); ``bound`` bounds |F^(n)| by bound rho^n."""
        k2, K, x = self.motion.k2, self.K, [y, v]
        for force, drag, step in zip(F[: K - 2], self.drags, self.steps, strict=False):
            y, v = v, (force - drag * v - k2 * y) / step
            x.append(v)
        bounds = (
            (abs(x[K - 2]) * factorial(K - 2) / self.rho ** (K - 2)).upper(),
            (abs(x[K - 1]) * factorial(K - 1) / self.rho ** (K - 1)).upper(),
            (bound / self.room).upper(),
        )
        demand(all(one.is_finite() for one in bounds), "a flight leaves all bounds")
        C = max(bounds)  # exact balls, compared as such: as doubles the smallest of them are all 0
        return Series(x, C, self.rho)

    def expanded(self, t: Ball, y: Ball, v: Ball) -> Series:
        """Return the series of the flight that is at (y, v) at time t."""
        return self.solution(self.forces(t), y, v, self.A)

    def count(self, L: Ball) -> int:
        """Return the number of steps of a flight."""
        steps = float((self.rho * abs(L)).upper()) / STEP
        demand(steps < MOST_WORK, "a flight has too many time scales")
        return max(1, ceil(steps))


class Free(NamedTuple):
    """The two unforced flights, from (1, 0) and from (0, 1), and balls around them up to a step before and after."""

    h: Ball
    flights: tuple[Series, Series]
    around: list[tuple[Ball, Ball]]

    def __call__(self, s: Ball, order: int) -> tuple[Ball, Ball]:
        """Return balls around their derivatives of some order after time s."""
        if abs(s) <= self.h:
            return self.around[order]
        one, two = self.flights
        return one(s, order), two(s, order)

    @property
    def matrix(self) -> Matrix:
        """The unforced flight of one step, E(h)."""
        one, two = self.flights
        return one(self.h), two(self.h), one(self.h, 1), two(self.h, 1)


def free_flights(flights: Checked, h: Ball) -> Free:
    """Return the unforced flights for steps of length h."""
    nothing = [number(0)] * flights.K
    one, two = (flights.solution(nothing, number(a), number(b), number(0)) for a, b in ((1, 0), (0, 1)))
    reach = around(number(0), abs(h).upper())
    return Free(h, (one, two), [(one(reach, order), two(reach, order)) for order in range(3)])


class Piece(NamedTuple):
    """A step of a flight: the series of the middle of its starting states, and what these states differ by."""

    series: Series
    y: Ball
    v: Ball
    free: Free

    def __call__(self, s: Ball, order: int = 0) -> Ball:
        """Return the derivative of some order after time s."""
        one, two = self.free(s, order)
        return self.series(s, order) + one * self.y + two * self.v


class Path:
    """A flight from (y, v) at time t over a length L, as a chain of series.

    A ball of states is carried on by E(h) and not by a series, in which its size would grow like e^(alpha h).
    ``slopes`` are the derivatives of (y, v) by the unknown parameter.
    """

    def __init__(
        self, flights: Checked, t: Ball, y: Ball, v: Ball, L: Ball, slopes: tuple[Ball, Ball] | None = None
    ) -> None:  # fmt: skip
        self.flights, self.t, self.L = flights, t, L
        self.count = flights.count(L)
        flights.keep(self.count)
        self.h = L / self.count
        free = free_flights(flights, self.h)
        E = free.matrix
        self.pieces: list[Piece] = []
        dy, dv = slopes or (number(0), number(0))
        for i in range(self.count):
            at = t + i * self.h
            F = flights.forces(at)
            piece, y, v = self._stepped(F, y, v, flights.A, E, free)
            if flights.sensitive:
                G, bound = flights.force_slopes(at, self._whole(piece))
                m, C = flights.motion, self._size(piece)
                bound += abs(m.slope("alpha")) * C * flights.rho + abs(m.slope("k2")) * C
                _series, dy, dv = self._stepped(G, dy, dv, bound, E, free)
            self.pieces.append(piece)
        self.y, self.v, self.dy, self.dv = y, v, dy, dv

    def _stepped(self, F: list[Ball], y: Ball, v: Ball, bound: Ball, E: Matrix, free: Free) -> tuple[Piece, Ball, Ball]:
        """Return the piece that starts at (y, v), and the state at its end."""
        series = self.flights.solution(F, y.mid(), v.mid(), bound)
        piece = Piece(series, y - y.mid(), v - v.mid(), free)
        end = series(self.h) + E[0] * piece.y + E[1] * piece.v
        return piece, end, series(self.h, 1) + E[2] * piece.y + E[3] * piece.v

    def _whole(self, piece: Piece) -> list[Ball]:
        """Return the coefficients of a piece, those of its difference included."""
        one, two = piece.free.flights
        return [a + b * piece.y + c * piece.v for a, b, c in zip(piece.series.terms, one.terms, two.terms, strict=True)]

    def _size(self, piece: Piece) -> Ball:
        """Return the constant C that bounds all derivatives of a piece."""
        one, two = piece.free.flights
        return piece.series.C + one.C * abs(piece.y) + two.C * abs(piece.v)

    def at(self, s: Ball, order: int = 0) -> Ball:
        """Return y, v or y'' after time s, which may be a ball shorter than a step."""
        i = min(max(int(float((s.mid() / self.h.mid()).mid())), 0), self.count - 1)  # all of them hold the flight
        return self.pieces[i](s - i * self.h, order)


def transition(flights: Checked, L: Ball) -> Matrix:
    """Return the unforced flight E(L), row by row; L may have either sign."""
    count = flights.count(L)
    flights.work.spend(10 * flights.K)
    power = free_flights(flights, L / count).matrix
    whole = None
    while count:  # E(L) = E(L/count)^count, by its binary digits
        if count & 1:
            whole = power if whole is None else product(whole, power)
        power, count = product(power, power), count >> 1
    assert whole is not None
    return whole


def product(a: Matrix, b: Matrix) -> Matrix:
    """Return the product of two 2 x 2 matrices, row by row."""
    return (
        a[0] * b[0] + a[1] * b[2], a[0] * b[1] + a[1] * b[3],
        a[2] * b[0] + a[3] * b[2], a[2] * b[1] + a[3] * b[3],
    )  # fmt: skip


#: Halvings of a stretch, and pieces in all, after which a bound is not proven.
DEEPEST, MOST = 260, 100_000


def exceeds(path: Path, low: Ball, high: Ball, order: int, limit: Ball, sign: int = 1) -> bool:
    """Return whether sign x > limit is proven on [low, high], x being y (order 0), v (1) or y'' (2)."""

    def shown(a: Ball, b: Ball) -> bool:
        middle, reach = (a + b) / 2, ((b - a) / 2).upper()
        here = around(middle.mid(), reach + middle.rad())
        if order == 2:
            return bool(sign * path.at(here, 2) > limit)
        bend = path.at(here, 2)
        s = around(number(0), reach)
        if order == 1:
            value = path.at(middle, 1) + s * bend
        else:
            value = path.at(middle) + s * path.at(middle, 1) + between_0_and((reach * reach / 2).upper()) * bend
        return bool(sign * value > limit)

    cells = [low + (high - low) * i / path.count for i in range(path.count + 1)]
    todo = [(a, b, 0) for a, b in pairwise(cells)]
    done = 0
    while todo:
        a, b, depth = todo.pop()
        done += 1
        path.flights.work.spend(10 * path.flights.K)
        if shown(a, b):
            continue
        if depth >= DEEPEST or done > MOST:
            return False
        middle = (a + b) / 2
        if not sign * path.at(middle, order) > limit:
            return False
        todo += [(a, middle, depth + 1), (middle, b, depth + 1)]
    return True
