"""The equations of an orbit with n >= 1 impacts in N periods of the forcing, in times and velocities of its impacts."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from itertools import takewhile
from math import floor
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from grazing.kernel.compile import call
from grazing.maps.period import product, saltation
from grazing.maps.stroboscopic import stroboscopic_map
from grazing.orbits.closing import CONTACT, DEEP, ENDING, FORCE, LOW, OTHER, PROFILE, SLOPE, STRUCK, closer
from grazing.orbits.closure import FIRED, WHOLE
from grazing.orbits.contacts import PIECES, addresses, frames_at, letters_of_walls, piece_of, wall_of
from grazing.orbits.equations import ONE, Equations, Test
from grazing.orbits.even_equations import EVEN, EvenEquations
from grazing.orbits.flight_equations import FlightEquations, Prepared
from grazing.orbits.impact_orbit import ImpactOrbit, delay, mirrors_in
from grazing.orbits.one_impact import multipliers
from grazing.orbits.orbit import condition_of
from grazing.orbits.word import word
from grazing.oscillator.constants import HEAD
from grazing.oscillator.contact import placed
from grazing.oscillator.flight import anchored, flight, modes
from grazing.oscillator.frames import Frames, frame_of, seen_at_strobe
from grazing.oscillator.rig import Rig
from grazing.oscillator.trajectory import refuse_swings

Floats = NDArray[np.float64]

#: Shortest flight, in periods: beyond, two impacts have become one.
SHORTEST = 1e-9


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
    model : Rig
        Gives the values of all parameters that do not vary.
    names : tuple of str
        Parameters that vary.
    N : int
        Periods of the forcing.
    pieces : sequence of int
        For each impact which piece of the reset law acts: WHOLE, or for a trigger FIRED or PASSIVE; for the second
        wall PIECES more, see :mod:`grazing.orbits.contacts`.
    spans : array_like
        Size of each parameter that varies.
    """

    others = "grazing.orbits.grazes:begun"

    def __init__(self, model: Rig, names: tuple[str, ...], N: int, pieces: Sequence[int], spans: Any = None) -> None:
        super().__init__(model, names, spans)
        refuse_swings(model)
        self.N, self.pieces = N, tuple(pieces)
        self.n = len(self.pieces)
        self.walls = [wall_of(piece) for piece in self.pieces]
        sizes = [self.sizes(wall) for wall in range(len(model.walls))]
        self._high, self._fast = [high for high, _fast in sizes], [fast for _high, fast in sizes]
        self._force = self.own_frames.a.force or 1.0
        self.scale = np.array([self.period_at(self.own)] * self.n + [self._fast[wall] for wall in self.walls])
        self._gaps, self._close, self._profile = closer(model.harmonics, model.walled)

    def laws(self, seen: list[Floats]) -> Floats:
        """Return for each impact the addresses of its law, of its slope and of their numbers, and its wall.

        Their numbers are those that the walls see, and must live as long as the addresses are used.
        """
        k = len(seen[0])
        laws, starts = np.empty((k, self.n, 4)), np.empty((k, len(seen)))
        laws[:] = self._codes
        for wall, one in enumerate(seen):
            first = one.__array_interface__["data"][0]
            starts[:, wall] = np.arange(first, first + k * one.strides[0], one.strides[0])
        laws[:, :, 2] += starts[:, self.walls]
        return laws

    @cached_property
    def _codes(self) -> Floats:
        """What :meth:`laws` returns, of numbers their places in a row: it holds for all values of parameters."""
        return np.column_stack([addresses(self.model, self.pieces), self.walls]).astype(np.float64)

    def defects(self, x: Floats, p: Floats) -> tuple[Floats, Floats]:
        """Return the defects of the closing equations and their derivatives; NaN for flights of no time."""
        F, J = self.evaluated(x[None], p[None])
        return F[0], J[0]

    def evaluated(self, x: Floats, p: Floats) -> tuple[Floats, Floats]:
        """Return :meth:`defects` at several points."""
        at, n = self.prepared(p), 2 * self.n
        F, J = np.empty((len(x), n)), np.empty((len(x), n, n))
        F.fill(np.nan)
        J.fill(np.nan)
        call(self._gaps, at.rows, np.ascontiguousarray(x), self.N, at.laws, F, J, who="the closing equations")
        shut = ~(at.room > 0.0)
        if shut.any():
            F[shut], J[shut] = np.nan, np.nan
        return F, J

    def solve(self, guesses: Floats, p: Floats) -> Floats:
        """Solve by Newton's method from each row of guesses (k, 2n), which they become; residuals, NaN for none."""
        at, residuals = self.prepared(p[None]), np.full(len(guesses), np.nan)
        arguments = at.rows[0], guesses, self.N, at.laws[0], residuals
        call(self._close, *arguments, who="the closing equations")
        return residuals

    def profile(self, x: Floats, p: Floats, contacts: bool = False) -> Profile:
        """Return what a solution's flights do; with ``contacts`` each is flown by the exact advance as well."""
        tables, out = self._profiles(x[None], self.prepared(p[None]), contacts)
        return Profile(tables[0], *out[0].tolist())

    def _profiles(self, x: Floats, at: Prepared, contacts: bool = False) -> tuple[Floats, Floats]:
        """Return tables (k, n, PROFILE) of several solutions, and their s tr J, s det J and s (k, 3)."""
        tables, out = np.empty((len(x), self.n, PROFILE)), np.empty((len(x), 3))
        arguments = at.rows, np.ascontiguousarray(x), self.N, at.laws, contacts, tables, out
        call(self._profile, *arguments, who="the closing equations")
        return tables, out

    def tests(self, x: Floats, p: Floats) -> tuple[Test, ...]:
        """Return pd, bp-and-lp, ns of the turn, then for each impact its speed, trigger and force, and the dips.

        All are in units of their size.
        """
        at = self.prepared(p[None])
        found = self._tested(x[None], at, *self._profiles(x[None], at))
        return tuple(Test(type, float(values[0]), where) for type, where, values in found)

    def heights(self, x: Floats, p: Floats, index: int, kind: tuple[str, int]) -> Floats:
        """Return a test function at several points."""
        if (x[:, self.n :] == 0.0).any():  # there a test of the force comes in between
            return super().heights(x, p, index, kind)
        at = self.prepared(p)
        type, where, values = self._tested(x, at, *self._profiles(x, at))[index]
        return values if (type, where) == kind else np.full(len(x), np.nan)

    def _tested(self, x: Floats, at: Prepared, tables: Floats, out: Floats) -> list[tuple[str, int, Floats]]:
        """Return all test functions at several points with these profiles, each with its type and what it is about."""
        table, (trace, det, scale) = tables.T, out.T
        sign = -1.0 if self.n % 2 else 1.0  # sign scale > 0 while all v < 0
        found = [
            ("pd", -1, sign * (scale + trace + det)),
            ("lp", -1, sign * (scale - trace + det)),
            ("ns", -1, sign * (scale - det)),
        ]
        for i in range(self.n):
            k = (i + 1) % self.n
            speed, fast = -table[ENDING, i], self._fast[self.walls[k]]
            found.append(("v0", k, speed / fast))
            if piece_of(self.pieces[k]) != WHOLE:
                law = self._law_numbers(self.walls[k], at.seen)
                over = speed - law["trigger"] if piece_of(self.pieces[k]) == FIRED else law["trigger"] - speed
                found.append(("law", k, np.where(law["V"] != 0.0, over / fast, 1.0)))  # without a kick both are one law
            wall = self.walls[i]
            for low, dipped in ((LOW, wall), (LOW + OTHER, 1 - wall))[: len(at.seen)]:
                lows = table[low, i]
                found.append(("gr", dipped * self.n + i, np.where(np.isfinite(lows), lows / self._high[dipped], 1.0)))
            if x[0, self.n + i] == 0.0:
                found.append(("st", i, table[FORCE, i] / self._force))
        return found

    def _law_numbers(self, wall: int, seen: list[Floats]) -> dict[str, Floats]:
        """Return the parameters (k,) of the law of a wall by name, of all that walls see."""
        law = self.model.walls[wall].law.params
        return dict(zip(law, seen[wall][:, -len(law) :].T, strict=True))

    def touched(self, type: str, where: int) -> tuple[int, int]:
        """Return which impact or flight a test function is about, and at which wall."""
        if type == "gr":
            return where % self.n, where // self.n
        return where, self.walls[where] if type in ("v0", "law", "st") else -1

    def begins_in(self, x: Floats, p: Floats) -> int:
        """Return how many periods after the first one the first impact comes."""
        return floor(float(x[0]) / self.period_at(p))

    def doubling(self, x: Floats, p: Floats) -> tuple[Equations, Floats]:
        """Return the equations of two turns, and the solution that goes round twice."""
        n, N = self.n, self.N
        twice = ImpactEquations(self.model, self.names, 2 * N, self.pieces * 2, self.spans)
        return twice, np.concatenate([x[:n], x[:n] + N * self.period_at(p), x[n:], x[n:]])

    def halving(self, x: Floats, p: Floats) -> tuple[Equations, Floats]:
        """Return the equations of half the turns, and the mean of both halves of a solution."""
        n, h, turn = self.n, self.n // 2, self.N // 2 * self.period_at(p)
        half = ImpactEquations(self.model, self.names, self.N // 2, self.pieces[:h], self.spans)
        return half, 0.5 * np.concatenate([x[:h] + x[h:n] - turn, x[n : n + h] + x[n + h :]])

    def later(self, x: Floats, p: Floats, k: int) -> Floats | None:
        """Return by how much an orbit differs, scaled, if begun a k-th of its turn later."""
        n, m, N = self.n, self.n // k, self.N
        if n % k or self.walls[m:] + self.walls[:m] != self.walls:
            return None
        period = (x[m] - x[0]) / (N // k)  # that of the forcing, if it does repeat
        if abs(period - self.period_at(p)) > 0.1 * self.period_at(p):
            return None
        times = np.concatenate([x[m:n], x[:m] + N * period]) - (N // k) * period
        return np.asarray(np.concatenate([times - x[:n], np.roll(x[n:], -m) - x[n:]]) / self.scale)

    def same(self, x: Floats, other: Equations, y: Floats, p: Floats) -> bool:
        """Whether two solutions are one orbit, begun at another impact perhaps."""
        if not isinstance(other, ImpactEquations) or len(x) != len(y):
            return super().same(x, other, y, p)
        n, T = self.n, self.period_at(p)
        for k in range(n):
            if other.walls[k:] + other.walls[:k] != self.walls:
                continue
            times = np.concatenate([y[k:n], y[:k] + self.N * T])
            gap = np.mod(times - x[:n] + 0.5 * T, T) - 0.5 * T
            after = np.concatenate([y[n + k :], y[n : n + k]])
            if max(np.abs(gap / self.scale[:n]).max(), np.abs((after - x[n:]) / self.scale[n:]).max()) < ONE:
                return True
        return False

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
        h = self.n // 2
        if self.n % 2 or self.N % 2 or self.pieces[:h] != self.pieces[h:]:
            return None
        return self.uneven(x, self.period_at(p), 2)

    def images(self, x: Floats, p: Floats) -> dict[int, Floats]:
        """Return by how much an orbit differs, scaled, from its images, by the number of parts it could be made of.

        With T/g the period of what moves the model, a solution is one again T/g later, and half of that later at the
        other walls where the model is its own mirror image. So a turn N T of an orbit may be m parts that follow from
        each other: where m divides N g, or 2 N g but not N g. Powers of two tell where a multiplier of one part is -1
        and its symmetry breaks; in an even number of periods T that is where they double, see :meth:`halved`.
        """
        found: dict[int, Floats] = {}
        if self.n % 2 or self.N % 2 == 0:
            return found
        row, m = self.values(p), 2  # no model is made: this is asked at every point of a path
        turned = self.model.turns_at(row)
        swapped = tuple(PIECES * (1 - wall_of(one)) + piece_of(one) for one in self.pieces)
        while self.n % m == 0:
            h = self.n // m
            later = self.pieces[h:] + self.pieces[:h]
            mirror = m == mirrors_in(turned) and later == swapped and self.model.symmetric_at(row)
            if mirror or (turned % m == 0 and later == self.pieces):
                found[m] = self.uneven(x, self.period_at(p), m)
            m *= 2
        return found

    def reflections(self, x: Floats, p: Floats) -> list[Floats]:
        """Return the images of an orbit, each begun at the impact that the first one is to it."""
        n, turn, found = self.n, self.N * self.period_at(p), []
        for m in self.images(x, p):
            h = n // m
            times = np.append(x[h:n], x[:h] + turn) - turn / m
            found.append(np.append(times, np.roll(x[n:], -h)))
        return found

    def even(self, x: Floats, p: Floats) -> EvenEquations | None:
        """Return the equations of the orbits that are made of equal parts, of as many as this one nearly is."""
        near = [*takewhile(lambda image: np.abs(image[1]).max() < EVEN, self.images(x, p).items())]
        return EvenEquations(self, near[-1][0]) if near else None

    def uneven(self, x: Floats, T: float, m: int) -> Floats:
        """Return by how much the impacts of the second part of m differ from those of the first one, scaled."""
        n, h = self.n, self.n // m
        apart = np.append(x[h : 2 * h] - x[:h] - self.N / m * T, x[n + h : n + 2 * h] - x[n : n + h])
        return np.asarray(apart / np.append(self.scale[:h], self.scale[n : n + h]))

    def strobes(self, x: Floats, p: Floats) -> Floats:
        """Return the times of the impacts in periods of the forcing."""
        T = 2.0 * np.pi / self.prepared(p).values[:, [HEAD.index("omega")]]
        return np.asarray(x[:, : self.n] / T)

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
        n, N, c, model, at = self.n, self.N, self.frames(p), self.model_at(p), self.prepared(p[None])
        tables, out = self._profiles(x[None], at, contacts=True)
        T, table, (trace, det, scale) = c.a.T, tables[0], out[0].tolist()
        times, outgoing, incoming = x[:n] - T * floor(x[0] / T), x[n:], np.roll(table[:, ENDING], 1)
        late = np.abs(table[:, CONTACT] - np.diff(np.append(times, times[0] + N * T)))
        next_walls = np.roll(self.walls, -1)
        size = np.array([frame_of(bool(wall), c).size for wall in next_walls])
        arrives = (table[:, ENDING] < 0.0) & (late <= delay(table[:, ENDING], size, T))
        arrives &= table[:, STRUCK] == next_walls
        tests = [values[0] for type, _i, values in self._tested(x[None], at, tables, out) if type in ("law", "st")]
        flown = Flown(times, outgoing, self.walls, N)
        points, letters = strobed(flown, model, c, 0.0)
        J = monodromy(flown, incoming, np.roll(table[:, SLOPE], 1), c)
        scale = scale if scale != 0.0 else np.nan
        P = stroboscopic_map(model)
        return ImpactOrbit(
            map=P,
            points=points,
            word=word(letters, P.letters),
            period=N,
            multipliers=multipliers(trace / scale, det / scale),
            admissible=bool(arrives.all() and (outgoing >= 0.0).all() and all(value >= 0.0 for value in tests)),
            condition=condition_of(J),
            residual=float(np.abs(self.defects(x, p)[0]).max()),
            times=times,
            incoming=incoming,
            outgoing=outgoing,
            clearance=float(table[:, [DEEP, DEEP + OTHER]].min()),
            walls="".join(str(model.walls[wall].name) for wall in self.walls),
        )


class Flown(NamedTuple):
    """The impacts of N periods of the forcing: times, velocities after them, numbers of their walls."""

    times: Floats
    outgoing: Floats
    walls: Sequence[int]
    N: int


def strobed(flown: Flown, model: Rig, c: Frames, phase: float) -> tuple[Floats, list[int]]:
    """Return the states (u, v) at phase, phase + T, ..., and the letters of the periods that end there.

    An impact at the strobe belongs to the period before it: (phase + jT, phase + (j + 1) T].
    """
    times, N, T = flown.times, flown.N, c.a.T
    points, letters, hits = np.empty((N, 2)), [0] * N, letters_of_walls(model)
    passed = (times - phase) / T
    period = np.ceil(passed) - 1.0
    for i in np.argsort(passed - period, kind="stable"):
        j = int(period[i]) % N
        letters[j] = letters[j] + 1 if hits is None else hits.longer(letters[j], flown.walls[i])
    strobe = c if phase == 0.0 else frames_at(model, np.array([*model.params.values()]), phase)
    for j in range(N):
        s = np.mod(phase + j * T - times, N * T)  # time since each impact; one at the strobe has just happened
        i = int(np.argmin(s))
        b = flown.walls[i] > 0
        here = frame_of(b, c)
        y, v = flight(float(s[i]), anchored(times[i], 0.0, flown.outgoing[i], here), here)
        points[j] = seen_at_strobe(placed(0.0, y, v, 0), b, strobe)
    return points, letters


def monodromy(flown: Flown, incoming: Floats, slopes: Floats, c: Frames) -> Floats:
    """Return the derivative (2, 2) of N periods at the orbit's state at time 0; NaN where an impact has v = 0."""
    J, now, end = (1.0, 0.0, 0.0, 1.0), 0.0, flown.N * c.a.T
    times, outgoing = flown.times, flown.outgoing
    when = np.where(times > 0.0, times, times + end)
    when = when - end * np.floor((when - 1e-300) / end)
    for i in np.argsort(when):
        here = frame_of(flown.walls[i] > 0, c)
        jump = saltation(times[i], float(incoming[i]), float(outgoing[i]), float(slopes[i]), here)
        J = product(jump, product(modes(when[i] - now, here), J))
        now = when[i]
    return np.array(product(modes(end - now, c.a), J)).reshape(2, 2)
