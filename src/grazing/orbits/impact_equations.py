"""The equations of an orbit with n >= 1 impacts in N periods of the forcing, in times and velocities of its impacts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import lru_cache
from math import ceil, floor, gcd
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from grazing.kernel.compile import call
from grazing.maps.period import product, saltation
from grazing.maps.stroboscopic import stroboscopic_map
from grazing.orbits.closing import CONTACT, ENDING, FORCE, LOW, PROFILE, SLOPE, closer
from grazing.orbits.closure import FIRED, PASSIVE, WHOLE
from grazing.orbits.equations import Test
from grazing.orbits.flight_equations import FlightEquations
from grazing.orbits.impact_orbit import ImpactOrbit
from grazing.orbits.one_impact import multipliers
from grazing.orbits.orbit import condition_of
from grazing.orbits.word import word
from grazing.oscillator.flight import anchored, flight, modes
from grazing.oscillator.model import Oscillator
from grazing.oscillator.pointed import law_addresses
from grazing.oscillator.reset import active_law, newton_law, newton_slope, triggered_law
from grazing.oscillator.trajectory import refuse_swings
from grazing.parameter import parameter_tuple

Floats = NDArray[np.float64]

#: Shortest flight, in periods: beyond, two impacts have become one.
SHORTEST = 1e-9


def force_turns(params: Mapping[str, float]) -> int:
    """Return how often the force repeats itself in a period T, by its active harmonics; 0 if it is constant."""
    names = (name for name in params if name[:3] in ("cos", "sin") and name[3:].isdigit())
    return gcd(*(int(name[3:]) for name in names if params[name] != 0.0))


class Profile(NamedTuple):
    """What a solution's flights do: ``table`` (n, PROFILE), and s tr J, s det J, s of its turn (see closing)."""

    table: Floats
    trace: float
    det: float
    scale: float


class ImpactEquations(FlightEquations):
    """Closing equations of n impacts in N periods; unknowns are the times, then the velocities after the impacts.

    Parameters
    ----------
    model : Oscillator
        Gives the values of all parameters that do not vary.
    names : tuple of str
        Parameters that vary.
    N : int
        Periods of the forcing.
    pieces : sequence of int
        For each impact which piece of the reset law acts: WHOLE, or for a trigger FIRED or PASSIVE.
    spans : array_like
        Size of each parameter that varies.
    """

    def __init__(
        self, model: Oscillator, names: tuple[str, ...], N: int, pieces: Sequence[int], spans: Any = None
    ) -> None:
        super().__init__(model, names, spans)
        refuse_swings(model)
        self.N, self.pieces = N, tuple(pieces)
        self.n = len(self.pieces)
        c = self.constants(self.own)
        self.scale = np.repeat([c.T, c.size * c.rate], self.n)
        self._high, self._fast, self._force = c.size or 1.0, c.size * c.rate or 1.0, c.force or 1.0
        self._gaps, self._close, self._profile = closer(model.harmonics)

    def _laws(self, values: Floats) -> Floats:
        """Return for each impact the addresses of its law, of its slope and of their numbers, which must live."""
        at, slope = addresses(self.model, self.pieces)
        return np.column_stack([at, slope, np.full(self.n, float(values.ctypes.data))])

    def defects(self, x: Floats, p: Floats) -> tuple[Floats, Floats]:
        """Return the defects of the closing equations and their derivatives; NaN for flights of no time."""
        values, F, J = self.values(p), np.full(2 * self.n, np.nan), np.full((2 * self.n, 2 * self.n), np.nan)
        call(self._gaps, self.row(values), x, self.N, self._laws(values), F, J, who="the closing equations")
        return F, J

    def solve(self, guesses: Floats, p: Floats) -> Floats:
        """Solve by Newton's method from each row of guesses (k, 2n), which they become; residuals, NaN for none."""
        values, residuals = self.values(p), np.full(len(guesses), np.nan)
        arguments = self.row(values), guesses, self.N, self._laws(values), residuals
        call(self._close, *arguments, who="the closing equations")
        return residuals

    def profile(self, x: Floats, p: Floats, contacts: bool = False) -> Profile:
        """Return what a solution's flights do; with ``contacts`` each is flown by the exact advance as well."""
        values, table, out = self.values(p), np.empty((self.n, PROFILE)), np.empty(3)
        arguments = self.row(values), x, self.N, self._laws(values), contacts, table, out
        call(self._profile, *arguments, who="the closing equations")
        return Profile(table, *out.tolist())

    def tests(self, x: Floats, p: Floats) -> tuple[Test, ...]:
        """Return pd, bp-and-lp, ns of the turn, then for each impact its speed, trigger and force, and the dips.

        Speeds, forces and heights are in units of their size.
        """
        table, trace, det, scale = self.profile(x, p)
        sign = -1.0 if self.n % 2 else 1.0  # sign scale > 0 while all v < 0
        found = [
            Test("pd", sign * (scale + trace + det)),
            Test("lp", sign * (scale - trace + det)),
            Test("ns", sign * (scale - det)),
        ]
        trigger = self.values(p)[-1] if self.model.reset.law is triggered_law else 0.0
        # without a kick both pieces of a trigger are one law
        kicks = "V" not in self.model.params or self.values(p)[list(self.model.params).index("V")] != 0.0
        for i in range(self.n):
            k = (i + 1) % self.n
            speed = -table[i, ENDING]
            found.append(Test("v0", speed / self._fast, k))
            if self.pieces[k] != WHOLE:
                over = speed - trigger if self.pieces[k] == FIRED else trigger - speed
                found.append(Test("law", over / self._fast if kicks else 1.0, k))
            # a flight that leaves into the wall dips at once: that is the impact before it, which has lost its speed
            low = float(table[i, LOW]) if x[self.n + i] >= 0.0 else abs(float(table[i, LOW]))
            found.append(Test("gr", low / self._high if np.isfinite(low) else 1.0, i))
            if x[self.n + i] == 0.0:
                found.append(Test("st", table[i, FORCE] / self._force, i))
        return tuple(found)

    def turned_to(self, x: Floats, p: Floats, like: Floats) -> tuple[Floats, NDArray[np.int64]]:
        """Return the solution, begun at another impact or period, that is nearest to another, and its order."""
        n, T = self.n, self.period_at(p)
        found = []
        for k in range(n):
            if self.pieces[k:] + self.pieces[:k] != self.pieces:
                continue
            times = np.concatenate([x[k:n], x[:k] + self.N * T])
            times -= T * np.round((times[0] - like[0]) / T)
            turned = np.roll(np.arange(n), -k)
            y, order = np.append(times, np.roll(x[n:], -k)), np.append(turned, n + turned)
            found.append((float(np.abs((y - like) / self.scale).max()), k, y, order))
        return min(found)[2:]

    def halved(self, x: Floats, p: Floats) -> Floats | None:
        """Return by how much the two halves of an orbit differ, scaled; None where they cannot be the same."""
        n, T = self.n, self.period_at(p)
        h = n // 2
        turns = force_turns(dict(zip(self.model.params, self.values(p), strict=False)))
        if n % 2 or turns * self.N % 2 or self.pieces[:h] != self.pieces[h:]:
            return None
        apart = np.append(x[h:n] - x[:h] - self.N / 2 * T, x[n + h :] - x[n : n + h])
        return np.asarray(apart / np.append(self.scale[:h], self.scale[n : n + h]))

    def broken(self, x: Floats, p: Floats) -> str:
        """Say whether two impacts have become one, or the law gives no velocity."""
        T = self.period_at(p)
        times = np.append(x[: self.n], x[0] + self.N * T)
        if not (np.diff(times) > SHORTEST * T).all():
            return "two impacts have become one: the flight between them takes no time"
        if not np.isfinite(x).all():
            return "the reset law gives no velocity"
        return ""

    def orbit(self, x: Floats, p: Floats) -> ImpactOrbit:
        """Return the orbit of a solution: admissible if the exact advance from each impact ends at the next one."""
        n, N, c, model = self.n, self.N, self.constants(p), self.model_at(p)
        profile = self.profile(x, p, contacts=True)
        table = profile.table
        times, outgoing, incoming = x[:n] - c.T * floor(x[0] / c.T), x[n:], np.roll(table[:, ENDING], 1)
        late = np.abs(table[:, CONTACT] - np.diff(np.append(times, times[0] + N * c.T)))
        with np.errstate(divide="ignore"):
            arrives = (table[:, ENDING] < 0.0) & (late <= 1e-9 * c.T + 1e-14 * c.size / np.abs(table[:, ENDING]))
        tests = [test.value for test in self.tests(x, p) if test.type in ("law", "st")]
        points, letters = strobed(times, outgoing, N, c)
        J = monodromy(times, incoming, outgoing, np.roll(table[:, SLOPE], 1), N, c)
        scale = profile.scale if profile.scale != 0.0 else np.nan
        return ImpactOrbit(
            map=stroboscopic_map(model),
            points=points,
            word=word(letters),
            period=N,
            multipliers=multipliers(profile.trace / scale, profile.det / scale),
            admissible=bool(arrives.all() and (outgoing >= 0.0).all() and all(value >= 0.0 for value in tests)),
            condition=condition_of(J),
            residual=float(np.abs(self.defects(x, p)[0]).max()),
            times=times,
            incoming=incoming,
            outgoing=outgoing,
            clearance=float(table[:, LOW].min()),
        )


@lru_cache(maxsize=64)
def _addresses(law: Any, slope: Any, name: str, kind: type) -> tuple[float, float]:
    """Return the addresses of a law and its slope in strict arithmetic."""
    at, slope_at, _strike = law_addresses(law, slope, name, kind, "strict")
    return at, slope_at


def addresses(model: Oscillator, pieces: Sequence[int]) -> tuple[list[float], list[float]]:
    """Return for each impact the address of the piece of the law that acts there, and of its slope.

    A piece of a trigger goes on smoothly beyond the trigger's speed, so that Newton's method and virtual orbits can.
    """
    kind, law = parameter_tuple(tuple(model.params)), model.reset
    known = {
        WHOLE: (law.law, law.slope, law.name),
        FIRED: (active_law, newton_slope, "active"),
        PASSIVE: (newton_law, newton_slope, "newton"),
    }
    pairs = [_addresses(*known[piece], kind) for piece in pieces]
    return [at for at, _slope in pairs], [slope for _at, slope in pairs]


def strobed(times: Floats, outgoing: Floats, N: int, c: Any) -> tuple[Floats, list[int]]:
    """Return the states (u, v) at 0, T, ..., (N - 1) T, and the impacts in each period (jT, (j + 1) T]."""
    points, letters = np.empty((N, 2)), [0] * N
    for t in times:
        letters[(ceil(t / c.T) - 1) % N] += 1
    for j in range(N):
        s = np.mod(j * c.T - times, N * c.T)  # time since each impact; an impact at the strobe has just happened
        i = int(np.argmin(s))
        points[j] = flight(float(s[i]), anchored(times[i], 0.0, outgoing[i], c), c)
    return points + np.array([c.sigma, 0.0]), letters


def monodromy(times: Floats, incoming: Floats, outgoing: Floats, slopes: Floats, N: int, c: Any) -> Floats:
    """Return the derivative (2, 2) of N periods at the orbit's state at time 0; NaN where an impact has v = 0."""
    J, now = (1.0, 0.0, 0.0, 1.0), 0.0
    when = np.where(times > 0.0, times, times + N * c.T)
    when = when - N * c.T * np.floor((when - 1e-300) / (N * c.T))
    for i in np.argsort(when):
        jump = saltation(times[i], float(incoming[i]), float(outgoing[i]), float(slopes[i]), c)
        J = product(jump, product(modes(when[i] - now, c), J))
        now = when[i]
    return np.array(product(modes(N * c.T - now, c), J)).reshape(2, 2)
