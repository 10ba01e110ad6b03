"""Solutions of the closing equations of an oscillator, gathered from many guesses: each orbit once, and what was tried.

A signature is the number of impacts in so many periods, with the wall of each and the piece of its law that acts.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import product
from math import gcd, nan

import numpy as np
from numpy.typing import NDArray

from grazing.kernel.random import uniform
from grazing.orbits.closing import DEEP, DIPS, ENDING, OTHER, WHEN
from grazing.orbits.closure import FIRED, PASSIVE
from grazing.orbits.contacts import PIECES, contacts_of, piece_of, pieces_of, wall_of
from grazing.orbits.corrector import weighed
from grazing.orbits.finder import Tally
from grazing.orbits.free_equations import FreeEquations
from grazing.orbits.impact_equations import SHORTEST, ImpactEquations
from grazing.orbits.one_orbit import cells, moved
from grazing.orbits.search_flights import Flights
from grazing.oscillator.reset import Reset
from grazing.oscillator.rig import Rig
from grazing.outcome import UserCodeError

Floats = NDArray[np.float64]
Pieces = tuple[int, ...]

#: Residual, in natural units, up to which a solution counts.
CLOSED = 1e-10
#: Solutions of which rounding is not known are one where they differ by less than this, in natural units.
SAME = 1e-7
#: Triggers and second walls give 2^n signatures; only up to so many impacts are all of them tried at random.
ALL_PIECES = 4
#: Solutions of a signature whose neighbours are looked at.
NEIGHBOURS = 40
#: Newton steps cost n^3: of flights with n impacts so many, divided by that, are tried, and a few of any.
WORK, A_FEW = 1_000_000, 20
#: How far doubled orbits are looked for from the orbit that they double, in natural units.
APART = (1e-3, 1e-2, 5e-2, 0.2)

NOTHING = np.empty(0)


class Solutions:
    """Distinct solutions of one model, by periods and pieces of the law; none repeats a shorter one."""

    def __init__(self, model: Rig, tally: Tally) -> None:
        self.model, self.tally = model, tally
        c = FreeEquations(model, ()).constants(NOTHING)
        self.T, self.speed = model.period, float(c.size * c.rate)
        self.contacts = contacts_of(model)
        self.found: dict[tuple[int, Pieces], Floats] = {}
        self._equations: dict[tuple[int, Pieces], ImpactEquations] = {}
        self._off: dict[tuple[int, Pieces, bytes], Floats] = {}

    def equations(self, N: int, pieces: Pieces) -> ImpactEquations:
        """Return the closing equations of a signature."""
        key = N, pieces
        if key not in self._equations:
            self._equations[key] = ImpactEquations(self.model, (), N, pieces)
        return self._equations[key]

    def add(self, N: int, pieces: Pieces, guesses: Floats) -> Floats:
        """Solve from guesses (k, 2n), times then velocities, and keep what is new; return the new solutions."""
        n = len(pieces)
        none = np.empty((0, 2 * n))
        if len(guesses) == 0 or n == 0:
            return none
        turn = min(range(n), key=lambda k: pieces[k:] + pieces[:k])
        x, pieces = np.ascontiguousarray(turned(guesses, turn, N * self.T)), pieces[turn:] + pieces[:turn]
        equations = self.equations(N, pieces)
        self.tally.attempts += len(x)
        self.tally.signatures.add((n, N))
        residuals = equations.solve(x, NOTHING)
        good = (residuals < CLOSED) & (flights(x, N * self.T) > SHORTEST * self.T).all(axis=1)
        self.tally.converged += int(good.sum())
        x = x[good]
        x = x[~self._repeats(x, N, pieces, equations)]
        known = self.found.get((N, pieces), none)
        new = self._distinct(x, known, equations)
        self.found[N, pieces] = np.concatenate([known, new])
        return new

    def _repeats(self, x: Floats, N: int, pieces: Pieces, equations: ImpactEquations) -> NDArray[np.bool_]:
        """Return which solutions go round a shorter one several times."""
        n = len(pieces)
        repeats = np.zeros(len(x), bool)
        for d in range(2, gcd(n, N) + 1):
            if n % d or N % d:  # an orbit of N/d points of the map, however soon the force repeats itself
                continue
            shift = turned(x, n // d, N * self.T) - np.repeat([N / d * self.T, 0.0], n)
            repeats |= (np.abs((shift - x) / equations.scale) < SAME).all(axis=1)
        return repeats

    def _distinct(self, x: Floats, known: Floats, equations: ImpactEquations) -> Floats:
        """Return those of the solutions that are not known, each once and in its own order of impacts."""
        n, pieces = equations.n, equations.pieces
        starts = [k for k in range(n) if pieces[k:] + pieces[:k] == pieces]
        kept, new = known, list[int]()
        off = np.array([self._moved(one, equations) for one in known]).reshape(-1, 2 * n)
        for cell in cells(self.prints(x, equations), SAME):
            while len(cell):
                one, own = x[cell[:1]], self._moved(x[cell[0]], equations)
                if not any(
                    self._alike(turned(one, k, 0.0)[0], turned(own[None], k, 0.0)[0], kept, off).any() for k in starts
                ):
                    new.append(cell[0])
                    kept, off = np.concatenate([kept, one]), np.concatenate([off, own[None]])
                cell = cell[1:]
                same = [self._alike(turned(one, k, 0.0)[0], own, x[cell], own) for k in starts if len(cell)]
                cell = cell[~np.any(same, axis=0)] if same else cell
        return ordered(x[new], equations)

    def _alike(self, x: Floats, own: Floats, others: Floats, off: Floats) -> NDArray[np.bool_]:
        """Return which of several solutions (k, 2n) are one with another that begins at the same impact."""
        n, gap = len(x) // 2, others - x
        gap[:, :n] -= self.T * np.round(gap[:, :n] / self.T)
        return np.asarray((np.abs(gap) <= own + off).all(axis=1))

    def _moved(self, x: Floats, equations: ImpactEquations) -> Floats:
        """Return by how much rounding may have moved a solution (2n,)."""
        key = equations.N, equations.pieces, x.tobytes()
        if key not in self._off:
            F, J = equations.defects(x, NOTHING)
            self._off[key] = moved(F, J, x, equations.rounded(x), equations.scale, SAME)
        return self._off[key]

    def prints(self, x: Floats, equations: ImpactEquations) -> Floats:
        """Return numbers (k, 6) that do not depend on which impact comes first, nor in which period."""
        n = x.shape[1] // 2
        angle, w = x[:, :n] * (2.0 * np.pi / self.T), x[:, n:] / equations.scale[n:]
        c, s = np.cos(angle), np.sin(angle)
        return np.asarray(np.stack([c, s, w, w * w, w * c, w * s]).sum(axis=2).T)

    # ways to come by guesses

    def from_flights(self, N: int, found: Flights) -> None:
        """Try the impacts of flights of N periods."""
        for n in range(1, found.times.shape[1] + 1):
            rows = np.flatnonzero(found.counts == n)[: WORK // (n + 2) ** 3 + A_FEW]
            groups: dict[Pieces, list[int]] = {}
            for row in rows:
                walls = found.walls[row, :n].astype(np.int64).tolist()
                pieces = (
                    self.contacts * n
                    if len(self.contacts) == 1
                    else pieces_of(self.model, found.incoming[row, :n], walls)
                )
                groups.setdefault(pieces, []).append(row)
            for pieces, members in sorted(groups.items()):
                self.add(N, pieces, np.hstack([found.times[members, :n], found.outgoing[members, :n]]))

    def from_outgoing(self, N: int, guesses: Floats, walls: Sequence[int] | None = None) -> None:
        """Try times and velocities after the impacts, from which it shows which piece of a trigger acted."""
        n = guesses.shape[1] // 2
        at = [0] * n if walls is None else list(walls)
        own = [[contact for contact in self.contacts if wall_of(contact) == wall] for wall in at]  # FIRED first
        if n == 0 or all(len(pieces) == 1 for pieces in own):
            self.add(N, tuple(pieces[0] for pieces in own), guesses)
            return
        fired = np.zeros((len(guesses), n), bool)
        for i, wall in enumerate(at):
            p = self.model.walls[wall].law.params
            if len(own[i]) > 1:
                fired[:, i] = guesses[:, n + i] >= p["r"] * p["trigger"] + 0.5 * p["V"]
        for row in np.unique(fired, axis=0):
            pieces = tuple(some[0] if kicks else some[-1] for some, kicks in zip(own, row, strict=True))
            self.add(N, pieces, guesses[(fired == row).all(axis=1)])

    def at_random(
        self, N: int, n: int, speed: float, count: int, seed: int, signatures: Sequence[Pieces] | None = None
    ) -> None:
        """Try random times and velocities of n impacts in N periods, at these contacts or at many orders of them."""
        for pieces in self._signatures(n) if signatures is None else signatures:
            numbers = uniform(seed, (float(N), float(n), *map(float, pieces)), count, 2 * n)
            times, after = np.sort(numbers[:, :n], axis=1) * N * self.T, numbers[:, n:] * speed
            self.add(N, pieces, np.hstack([times, after]))

    def _signatures(self, n: int) -> list[Pieces]:
        """Return which contacts are tried for n impacts, one rotation of each: all, or of many impacts equal ones.

        Between two walls also those that go to and fro.
        """
        if len(self.contacts) == 1:
            return [self.contacts * n]
        if n <= ALL_PIECES:
            every = product(self.contacts, repeat=n)
            return sorted({min(one[k:] + one[:k] for k in range(n)) for one in every})
        low = [contact for contact in self.contacts if wall_of(contact) == 0]
        high = [contact for contact in self.contacts if wall_of(contact) > 0]
        turns = [pair * (n // 2) for pair in product(low, high)] if n % 2 == 0 else []
        return [(contact,) * n for contact in self.contacts] + turns

    def neighbours(self, N: int, most: int) -> int:
        """Try solutions of N periods with an impact more, at a dip, or one less; return how many are new."""
        guesses: dict[Pieces, list[Floats]] = {}
        for (periods, pieces), found in sorted(self.found.items()):
            if periods == N and len(pieces) <= most:
                for x in self._real_first(N, pieces, found)[:NEIGHBOURS]:
                    for signature, guess in self._grown_or_shrunk(x, N, pieces, most):
                        guesses.setdefault(signature, []).append(guess)
        return sum(len(self.add(N, pieces, np.array(some))) for pieces, some in sorted(guesses.items()))

    def _real_first(self, N: int, pieces: Pieces, found: Floats) -> Floats:
        """Return solutions with those first that may be admissible."""
        equations = self.equations(N, pieces)
        return found[np.argsort([self.surely_virtual(x, equations) for x in found], kind="stable")]

    def _grown_or_shrunk(self, x: Floats, N: int, pieces: Pieces, most: int) -> Iterator[tuple[Pieces, Floats]]:
        n, equations = len(pieces), self.equations(N, pieces)
        table = equations.profile(x, NOTHING).table
        slow = 0.05 * self.speed
        laws = [wall.law for wall in self.model.walls]
        for i in range(n):
            for contact in self.contacts if n < most else ():
                wall = wall_of(contact)
                row = table[i] if wall == equations.walls[i] else np.roll(table[i], -OTHER)
                if row[DIPS] > 0:
                    speed = laws[wall].params["trigger"] if piece_of(contact) == FIRED else slow
                    kick = slow if piece_of(contact) == PASSIVE else self._kick(laws[wall], speed)
                    times = np.insert(x[:n], i + 1, x[i] + row[WHEN])
                    after = np.insert(x[n:], i + 1, kick)
                    yield (*pieces[: i + 1], contact, *pieces[i + 1 :]), np.concatenate([times, after])
            if n > 1:
                less = np.concatenate([np.delete(x[:n], i), np.delete(x[n:], i)])
                yield (*pieces[:i], *pieces[i + 1 :]), less

    def _kick(self, law: Reset, speed: float) -> float:
        try:
            return law(-speed)
        except UserCodeError:  # a law that fails at this speed gives no guess
            return nan

    def doublings(self, N: int) -> None:
        """Look for orbits of N periods beside the known ones of N/2, in the direction in which those would double."""
        for (periods, pieces), found in sorted(self.found.items()):
            if 2 * periods != N:
                continue
            n = len(pieces)
            equations = self.equations(N, pieces * 2)
            guesses = []
            for x in found[:NEIGHBOURS]:
                twice = np.concatenate([x[:n], x[:n] + periods * self.T, x[n:], x[n:]])
                F, J = equations.defects(twice, NOTHING)
                if not np.isfinite(J).all():
                    continue
                _F, wide = weighed(F, J * equations.scale)
                flip = np.kron(np.eye(2), np.vstack([np.eye(n), -np.eye(n)])) / np.sqrt(2.0)  # opposite in the turns
                away = flip @ np.linalg.svd(wide @ flip)[2][-1]
                guesses += [twice + size * away * equations.scale for size in APART]
            if guesses:
                self.add(N, pieces * 2, np.array(guesses))

    def images(self, N: int) -> None:
        """Add the mirror images of the known solutions of N periods, where the model has them."""
        if not self.model.symmetric:
            return
        for (periods, pieces), found in sorted(self.found.items()):
            if periods == N and len(found):
                swapped = tuple(PIECES * (1 - wall_of(one)) + piece_of(one) for one in pieces)
                later = 0.5 * self.T / max(self.model.turns, 1)
                self.add(N, swapped, found + np.repeat([later, 0.0], len(pieces)))

    def surely_virtual(self, x: Floats, equations: ImpactEquations) -> bool:
        """Whether a solution comes out of the wall, passes through it, or has a velocity into it, beyond doubt."""
        n, speed = equations.n, 1e-6 * float(equations.scale[equations.n :].min())
        size = speed * self.T
        table = equations.profile(x, NOTHING).table
        return bool(
            (x[n:] < -speed).any() or (table[:, ENDING] > speed).any() or (table[:, [DEEP, DEEP + OTHER]] < -size).any()
        )


def turned(x: Floats, k: int, turn: float) -> Floats:
    """Return solutions (m, 2n) begun at impact k instead."""
    n = x.shape[1] // 2
    return np.hstack([x[:, k:n], x[:, :k] + turn, x[:, n + k :], x[:, n : n + k]])


def flights(x: Floats, turn: float) -> Floats:
    """Return the times from each impact to the next, (m, n)."""
    n = x.shape[1] // 2
    return np.diff(x[:, :n], axis=1, append=x[:, :1] + turn)


def ordered(x: Floats, equations: ImpactEquations) -> Floats:
    """Return solutions begun at the impact whose phase is least, the first time in [0, T): the same for every guess.

    Of the impacts those count from which the same contacts follow.
    """
    n, pieces, T, speed = equations.n, equations.pieces, equations.scale[0], equations.scale[equations.n]
    starts = [k for k in range(n) if pieces[k:] + pieces[:k] == pieces]
    out = np.empty_like(x)
    for i, one in enumerate(x):
        phase, w = np.round(np.mod(one[:n] / T, 1.0), 7) % 1.0, np.round(one[n:] / speed, 7)
        k = min(starts, key=lambda j: (phase[j], w[j]))
        out[i] = turned(one[None], k, equations.N * T)[0]
        out[i, :n] -= T * np.floor(out[i, 0] / T)
    return out
