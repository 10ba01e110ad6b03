"""The free flight as the checker sees it: Taylor series of y'' = F - alpha y' - k^2 y, with a bound on what is cut off.

Nothing here is shared with the finder, which uses matrix exponentials.

The derivatives obey y^(n+2) = F^(n) - alpha y^(n+1) - k^2 y^(n). Let W be the highest frequency of F, A the sum of its
amplitudes and rho = alpha + k + 2 W. If |y^(n)| <= C rho^n for n = K - 2 and n = K - 1 and
A <= C (rho^2 - alpha rho - k^2), it holds for all later n, so that beyond K the series is at most
C (rho h)^K/K! e^(rho h). The derivative by a parameter obeys the same equation with another forcing, bounded likewise.
"""

from __future__ import annotations

from itertools import pairwise
from math import ceil
from typing import TYPE_CHECKING, NamedTuple

from grazing.proof.checker_reading import demand

if TYPE_CHECKING:
    from flint import arb

#: Longest step times rho, and most steps of a flight.
STEP, MOST_STEPS = 2, 40_000


class Motion(NamedTuple):
    """A model's parameters as balls, and the derivatives of all of them by the one that is unknown."""

    alpha: arb
    k: arb
    omega: arb
    t0: arb
    offset: arb
    sigma: arb
    cos: list[arb]
    sin: list[arb]
    slopes: dict[str, arb]

    @property
    def k2(self) -> arb:
        """The stiffness."""
        return self.k * self.k

    @property
    def period(self) -> arb:
        """The period of the forcing."""
        from flint import arb

        return 2 * arb.pi() / self.omega

    @property
    def level(self) -> arb:
        """The constant part of F = f - k^2 sigma."""
        return self.offset - self.k2 * self.sigma

    def slope(self, name: str) -> arb:
        """Return the derivative of a parameter by the unknown one: 1 or 0."""
        from flint import arb

        return self.slopes.get(name, arb(0))

    def period_slope(self) -> arb:
        """Return the derivative of the period by the unknown parameter."""
        return -self.period / self.omega * self.slope("omega")

    def turns(self, t: arb) -> list[tuple[int, arb, arb]]:
        """Return (j, cos, sin) of the phase of every harmonic at time t."""
        found = []
        for j in range(1, len(self.cos) + 1):
            sine, cosine = (j * self.omega * (t + self.t0)).sin_cos()
            found.append((j, cosine, sine))
        return found

    def force(self, t: arb) -> arb:
        """Return F at time t."""
        total = self.level
        for j, cosine, sine in self.turns(t):
            total += self.cos[j - 1] * cosine + self.sin[j - 1] * sine
        return total


class Series(NamedTuple):
    """A Taylor series: coefficients, the constant C of its tail, and rho."""

    terms: list[arb]
    C: arb
    rho: arb

    def __call__(self, s: arb, order: int = 0) -> arb:
        """Return the derivative of some order (0, 1 or 2) after time s, of either sign; s may be a ball."""
        from flint import arb

        K = len(self.terms)
        total = arb(0)
        for n in range(K - 1, order - 1, -1):
            falling = 1
            for i in range(order):
                falling *= n - i
            total = total * s + falling * self.terms[n]
        reach = self.rho * abs(s).upper()
        tail = self.C * self.rho**order * reach ** (K - order) / arb(K - order + 1).gamma() * reach.exp()
        return total + arb(0, 1) * tail.upper()


class Checked:
    """Free flights of a motion at the working precision; ``sensitive`` adds the derivative by the parameter."""

    def __init__(self, motion: Motion, sensitive: bool = False) -> None:
        from flint import arb, ctx

        self.motion, self.sensitive = motion, sensitive
        count = max(len(motion.cos), 1)
        self.W = (count * motion.omega).upper()
        self.rho = (motion.alpha + motion.k + 2 * self.W).upper()
        self.room = (self.rho * self.rho - motion.alpha * self.rho - motion.k2).lower()
        demand(self.room > 0, "the rates of the model cannot be bounded")
        self.A = (abs(motion.level) + sum((abs(x) for x in (*motion.cos, *motion.sin)), arb(0))).upper()
        terms = 16
        while arb(STEP) ** terms / arb(terms + 1).gamma() > arb(2) ** -(ctx.prec + 16):
            terms += 4
        self.K = terms

    def forces(self, t: arb) -> list[arb]:
        """Return the Taylor coefficients of F at time t."""
        from flint import arb

        m = self.motion
        total = [m.level, *([arb(0)] * (self.K - 1))]
        for j, cosine, sine in m.turns(t):
            c, s, W = m.cos[j - 1], m.sin[j - 1], j * m.omega
            self._add(total, c * cosine + s * sine, W * (s * cosine - c * sine), W)
        return total

    def _add(self, total: list[arb], value: arb, slope: arb, W: arb) -> None:
        """Add the series of a solution of x'' = -W^2 x with that value and slope."""
        W2 = W * W
        for n in range(0, len(total), 2):
            total[n] = total[n] + value
            value = -W2 * value / ((n + 1) * (n + 2))
        for n in range(1, len(total), 2):
            total[n] = total[n] + slope
            slope = -W2 * slope / ((n + 1) * (n + 2))

    def force_slopes(self, t: arb, y: list[arb]) -> tuple[list[arb], arb]:
        """Return the Taylor coefficients of what forces the derivative by the parameter, and the bound of its series.

        It is dF/dp - (d alpha/dp) v - (d k^2/dp) y.
        """
        from flint import arb

        m, K = self.motion, self.K
        dk2 = 2 * m.k * m.slope("k")
        level = m.slope("offset") - dk2 * m.sigma - m.k2 * m.slope("sigma")
        total, bound = [level, *([arb(0)] * (K - 1))], abs(level)
        for j, cosine, sine in m.turns(t):
            c, s, W = m.cos[j - 1], m.sin[j - 1], j * m.omega
            dc, ds = m.slope(f"cos{j}"), m.slope(f"sin{j}")
            self._add(total, dc * cosine + ds * sine, W * (ds * cosine - dc * sine), W)
            # d/dp of the phase is j (dw (t + t0) + w dt0): it grows with t, so that its series is a product
            turn = [arb(0)] * K
            self._add(turn, s * cosine - c * sine, -W * (s * sine + c * cosine), W)
            at, rate = j * (m.slope("omega") * (t + m.t0) + m.omega * m.slope("t0")), j * m.slope("omega")
            for n in range(K):
                total[n] += at * turn[n] + (rate * turn[n - 1] if n else 0)
            # |n-th derivative| <= |at| W^n A_j + rate n W^(n-1) A_j, and n <= 2^n / 2 * 1, W >= omega
            size = abs(c) + abs(s)
            bound += abs(dc) + abs(ds) + size * (abs(at) + abs(rate) / (2 * m.omega))
        for n in range(K):
            rising = (n + 1) * y[n + 1] if n + 1 < len(y) else arb(0)
            total[n] -= m.slope("alpha") * rising + dk2 * (y[n] if n < len(y) else 0)
        return total, bound

    def solution(self, F: list[arb], y: arb, v: arb, bound: arb) -> Series:
        """Return the series of x'' = F - alpha x' - k^2 x from (y, v); ``bound`` bounds |F^(n)| by bound rho^n."""
        m, K = self.motion, self.K
        x = [y, v]
        for n in range(K - 2):
            x.append((F[n] - m.alpha * (n + 1) * x[n + 1] - m.k2 * x[n]) / ((n + 1) * (n + 2)))
        from flint import arb

        factorial = arb(K - 1).gamma()  # (K - 2)!
        ends = (
            abs(x[K - 2]) * factorial / self.rho ** (K - 2),
            abs(x[K - 1]) * factorial * (K - 1) / self.rho ** (K - 1),
        )
        C = max((a.upper() for a in (*ends, bound / self.room)), key=lambda a: float(a) if a.is_finite() else 1e308)
        demand(C.is_finite() and all(a <= C for a in ends), "a flight leaves all bounds")
        return Series(x, C, self.rho)

    def expanded(self, t: arb, y: arb, v: arb) -> Series:
        """Return the series of the flight that is at (y, v) at time t."""
        return self.solution(self.forces(t), y, v, self.A)

    def count(self, L: arb) -> int:
        """Return the number of steps of a flight."""
        steps = float((self.rho * abs(L)).upper()) / STEP
        demand(steps < MOST_STEPS, "a flight has too many time scales")
        return max(1, ceil(steps))


class Free(NamedTuple):
    """The two unforced flights, from (1, 0) and from (0, 1), and balls around them up to a step before and after."""

    h: arb
    flights: tuple[Series, Series]
    around: list[tuple[arb, arb]]

    def __call__(self, s: arb, order: int) -> tuple[arb, arb]:
        """Return balls around their derivatives of some order after time s."""
        if abs(s) <= self.h:
            return self.around[order]
        one, two = self.flights
        return one(s, order), two(s, order)

    @property
    def matrix(self) -> tuple[arb, arb, arb, arb]:
        """The unforced flight of one step, E(h)."""
        one, two = self.flights
        return one(self.h), two(self.h), one(self.h, 1), two(self.h, 1)


def free_flights(flights: Checked, h: arb) -> Free:
    """Return the unforced flights for steps of length h."""
    from flint import arb

    nothing = [arb(0)] * flights.K
    one, two = (flights.solution(nothing, arb(a), arb(b), arb(0)) for a, b in ((1, 0), (0, 1)))
    reach = arb(0, 1) * abs(h).upper()
    return Free(h, (one, two), [(one(reach, order), two(reach, order)) for order in range(3)])


class Piece(NamedTuple):
    """A step of a flight: the series of the middle of its starting states, and what these states differ by."""

    series: Series
    y: arb
    v: arb
    free: Free

    def __call__(self, s: arb, order: int = 0) -> arb:
        """Return the derivative of some order after time s."""
        one, two = self.free(s, order)
        return self.series(s, order) + one * self.y + two * self.v


class Path:
    """A flight from (y, v) at time t over a length L, as a chain of series.

    A ball of states is carried on by E(h) and not by a series, in which its size would grow like e^(alpha h).
    """

    def __init__(self, flights: Checked, t: arb, y: arb, v: arb, L: arb) -> None:
        from flint import arb

        self.flights, self.t, self.L = flights, t, L
        self.count = flights.count(L)
        self.h = L / self.count
        free = free_flights(flights, self.h)
        E = free.matrix
        self.pieces: list[Piece] = []
        dy, dv = arb(0), arb(0)
        for i in range(self.count):
            at = t + i * self.h
            F = flights.forces(at)
            piece, y, v = self._stepped(F, y, v, flights.A, E, free)
            if flights.sensitive:
                G, bound = flights.force_slopes(at, self._whole(piece))
                m, C = flights.motion, self._size(piece)
                bound += abs(m.slope("alpha")) * C * flights.rho + abs(2 * m.k * m.slope("k")) * C
                _series, dy, dv = self._stepped(G, dy, dv, bound, E, free)
            self.pieces.append(piece)
        self.y, self.v, self.dy, self.dv = y, v, dy, dv

    def _stepped(
        self, F: list[arb], y: arb, v: arb, bound: arb, E: tuple[arb, arb, arb, arb], free: Free
    ) -> tuple[Piece, arb, arb]:
        """Return the piece that starts at (y, v), and the state at its end."""
        series = self.flights.solution(F, y.mid(), v.mid(), bound)
        piece = Piece(series, y - y.mid(), v - v.mid(), free)
        end = series(self.h) + E[0] * piece.y + E[1] * piece.v
        return piece, end, series(self.h, 1) + E[2] * piece.y + E[3] * piece.v

    def _whole(self, piece: Piece) -> list[arb]:
        """Return the coefficients of a piece, those of its difference included."""
        one, two = piece.free.flights
        return [a + b * piece.y + c * piece.v for a, b, c in zip(piece.series.terms, one.terms, two.terms, strict=True)]

    def _size(self, piece: Piece) -> arb:
        """Return the constant C that bounds all derivatives of a piece."""
        one, two = piece.free.flights
        return piece.series.C + one.C * abs(piece.y) + two.C * abs(piece.v)

    def at(self, s: arb, order: int = 0) -> arb:
        """Return y, v or y'' after time s, which may be a ball shorter than a step."""
        i = min(max(int(float(s.mid()) / float(self.h.mid())), 0), self.count - 1)
        return self.pieces[i](s - i * self.h, order)


def transition(flights: Checked, L: arb) -> tuple[arb, arb, arb, arb]:
    """Return the unforced flight E(L), row by row; L may have either sign."""
    from flint import arb_mat

    count = flights.count(L)
    E = free_flights(flights, L / count).matrix
    whole = arb_mat([[E[0], E[1]], [E[2], E[3]]]) ** count
    return whole[0, 0], whole[0, 1], whole[1, 0], whole[1, 1]


#: Halvings of a stretch, and pieces in all, after which a bound is not proven.
DEEPEST, MOST = 260, 100_000


def exceeds(path: Path, low: arb, high: arb, order: int, limit: arb, sign: int = 1) -> bool:
    """Return whether sign x > limit is proven on [low, high], x being y (order 0), v (1) or y'' (2)."""
    from flint import arb

    def shown(a: arb, b: arb) -> bool:
        middle, reach = (a + b) / 2, ((b - a) / 2).upper()
        around = middle.mid() + arb(0, 1) * (reach + middle.rad())
        if order == 2:
            return bool(sign * path.at(around, 2) > limit)
        bend = path.at(around, 2)
        s = arb(0, 1) * reach
        if order == 1:
            value = path.at(middle, 1) + s * bend
        else:
            value = path.at(middle) + s * path.at(middle, 1) + arb(0.5, 0.5) * (reach * reach / 2) * bend
        return bool(sign * value > limit)

    cells = [low + (high - low) * i / path.count for i in range(path.count + 1)]
    todo = [(a, b, 0) for a, b in pairwise(cells)]
    done = 0
    while todo:
        a, b, depth = todo.pop()
        done += 1
        if shown(a, b):
            continue
        if depth >= DEEPEST or done > MOST:
            return False
        middle = (a + b) / 2
        if not sign * path.at(middle, order) > limit:
            return False
        todo += [(a, middle, depth + 1), (middle, b, depth + 1)]
    return True
