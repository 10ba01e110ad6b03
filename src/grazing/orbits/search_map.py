"""Periodic orbits of any map, gathered from many guesses by Newton's method in all points at once."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grazing.kernel.compile import call, compiled
from grazing.kernel.lanes import unpacker
from grazing.kernel.primitives import replaced
from grazing.maps.linear import solved
from grazing.maps.map import Map
from grazing.orbits.finder import Tally
from grazing.orbits.map_equations import MapEquations
from grazing.orbits.one_orbit import cells, moved
from grazing.orbits.one_sided import EPS
from grazing.orbits.orbit import Orbit
from grazing.orbits.search_windows import drawn
from grazing.outcome import ESCAPED, FATAL, InputError

Floats = NDArray[np.float64]

#: Newton steps after which an orbit counts as not found.
STEPS = 40
#: Residual, in sizes of the box, up to which a solution counts; solutions of which rounding is not known are one up to
#: SAME.
CLOSED, SAME = 1e-10, 1e-8


@lru_cache(maxsize=64)
def closer(
    tangent: Callable[..., Any], prepare: Callable[..., Any] | None, kind: type, dimension: int
) -> Callable[..., None]:
    """Compile Newton's method for x_{j+1} = P(x_j) in all N points at once.

    Returns
    -------
    callable
        ``close(row, guesses, size, residuals)``: guesses (k, N, dim) become solutions; ``size`` (dim,) are the units.
    """
    unpack = unpacker(kind)
    zero = (0.0,) * dimension
    constants = prepare if prepare is not None else _same

    def defects(x: Any, c: Any, F: Any, J: Any) -> bool:
        """Write x_{j+1} - P(x_j) and its derivative; False where the map has no value or no derivative."""
        N = x.shape[0]
        for i in range(N * dimension):
            for k in range(N * dimension):
                J[i, k] = 0.0
        for j in range(N):
            state = zero
            for i in range(dimension):
                state = replaced(state, i, x[j, i])
            after, _letter, outcome, slopes = tangent(state, c)
            if outcome & FATAL:
                return False
            to = (j + 1) % N
            for i in range(dimension):
                F[to * dimension + i] = x[to, i] - after[i]
                J[to * dimension + i, to * dimension + i] += 1.0
                for k in range(dimension):
                    J[to * dimension + i, j * dimension + k] -= slopes[i * dimension + k]
        return True

    def close(x: Any, size: Any, c: Any, F: Any, J: Any) -> float:
        N, before = x.shape[0], float("inf")
        for _ in range(STEPS):
            if not defects(x, c, F, J) or not solved(J, F, size):
                return float("nan")
            longest = 0.0
            for j in range(N):
                for i in range(dimension):
                    move = F[j * dimension + i]
                    x[j, i] -= move
                    longest = max(longest, abs(move) / size[i])
            if not longest < 1e6:
                return float("nan")
            if longest <= 1e-15 or (longest <= 1e-9 and longest >= 0.25 * before):
                if not defects(x, c, F, J):
                    return float("nan")
                worst = 0.0
                for j in range(N):
                    for i in range(dimension):
                        worst = max(worst, abs(F[j * dimension + i]) / size[i])
                return worst
            before = longest
        return float("nan")

    def close_all(row: Any, guesses: Any, size: Any, residuals: Any) -> None:
        c = constants(unpack(row))
        total = guesses.shape[1] * dimension
        F, J = np.empty(total), np.empty((total, total))
        for k in range(guesses.shape[0]):
            residuals[k] = close(guesses[k], size, c, F, J)

    return compiled(close_all)


def _same(p: Any) -> Any:
    return p


class Cycles:
    """Distinct periodic orbits of one map, by least period."""

    def __init__(self, P: Map, tally: Tally) -> None:
        self.P, self.tally = P, tally
        self.size = np.array([high - low for low, high in P.box])
        self.found: dict[int, Floats] = {}
        self._off: dict[bytes, Floats] = {}
        derived = P.derivative(P.packed()[1][None])
        self._derived = derived
        self._close = closer(derived.tangent, derived.prepare, derived.kind, P.dimension)

    def add(self, guesses: Floats) -> Floats:
        """Solve from guesses (k, N, dim), and keep what is new and goes round nothing shorter; return that."""
        N, d = guesses.shape[1:]
        none = np.empty((0, N, d))
        if len(guesses) == 0:
            return none
        x, residuals = np.ascontiguousarray(guesses), np.full(len(guesses), np.nan)
        who = f"the tangent of {self.P.name}"
        call(self._close, self._derived.rows[0], x, self.size, residuals, who=who)
        self.tally.attempts += len(x)
        good = residuals < CLOSED
        self.tally.converged += int(good.sum())
        self.tally.signatures.add((N, N))
        x = x[good]
        for n in range(1, N):
            if N % n == 0:
                x = x[(np.abs((np.roll(x, n, axis=1) - x) / self.size) >= SAME).any(axis=(1, 2))]
        known = self.found.get(N, none)
        new = self._distinct(begun_at_least(x, self.size), known)
        self.found[N] = np.concatenate([known, new])
        return new

    def _distinct(self, x: Floats, known: Floats) -> Floats:
        """Return those of the solutions that are not known, each once."""
        N, d = x.shape[1:]
        kept, new = list(known), list[int]()
        off = np.array([self._moved(one) for one in kept]).reshape(-1, d)
        means = known.mean(axis=1)
        for cell in cells(self.prints(x), SAME):
            while len(cell):
                one, own = x[cell[0]], self._moved(x[cell[0]])
                near = np.flatnonzero((np.abs(means - one.mean(axis=0)) <= off + own).all(axis=1))
                turns = [np.roll(one, -k, axis=0) for k in range(N)]
                if not any((np.abs(turn - kept[k]) <= off[k] + own).all() for k in near for turn in turns):
                    new.append(cell[0])
                    kept.append(one)
                    off, means = np.concatenate([off, own[None]]), np.concatenate([means, one.mean(axis=0)[None]])
                cell = cell[1:]
                cell = cell[(np.abs(x[cell] - one) > own).any(axis=(1, 2))]  # few: most are as near as rounding is
        return x[sorted(new)]

    def _moved(self, x: Floats) -> Floats:
        """Return by how much rounding may have moved the points of a solution (N, dim), (dim,)."""
        N, d = x.shape
        key = x.tobytes()
        if key not in self._off:
            F, J = np.full((N, d), np.nan), np.eye(N * d)
            with suppress(InputError):  # Newton's method may end where the map allows no state
                for j in range(N):
                    to = (j + 1) % N
                    F[to] = x[to] - self.P.orbit(x[j], 1).points[-1]
                    J[to * d : to * d + d, j * d : j * d + d] -= self.P.jacobian(x[j])
            rounded = EPS * np.tile(np.abs(x).max(axis=0), N)
            most = moved(F.ravel(), J, x.ravel(), rounded, np.tile(self.size, N), SAME)
            self._off[key] = most.reshape(N, d).max(axis=0)
        return self._off[key]

    def prints(self, x: Floats) -> Floats:
        """Return numbers (k, m) that do not depend on which point comes first."""
        z = x / self.size
        after = np.roll(z, -1, axis=1)
        return np.concatenate([z.mean(axis=1), (z * z).mean(axis=1), (z * after).mean(axis=1), (z**3).mean(axis=1)], 1)

    def at_random(self, N: int, low: Floats, high: Floats, count: int, seed: int) -> None:
        """Try random points in a region."""
        d = len(low)
        box = np.column_stack([np.tile(low, N), np.tile(high, N)])
        self.add(np.ascontiguousarray(drawn(seed, count, box, float(N)).T).reshape(count, N, d))

    def orbits(self, N: int) -> list[Orbit]:
        """Return the orbits of a least period, each checked on the map itself."""
        nothing, orbits = np.empty(0), []
        for x in self.found.get(N, ()):
            with suppress(InputError):  # Newton's method may end where the map allows no state
                steps = [self.P.orbit(point, 1) for point in x]
                if any(int(step.outcomes[0]) & ESCAPED for step in steps):
                    continue  # what has left is kept where it is, and comes back to nothing
                letters = tuple(int(step.letters[0]) for step in steps)
                orbits.append(MapEquations(self.P, (), letters).orbit(x.ravel(), nothing))
        return orbits


def begun_at_least(x: Floats, size: Floats) -> Floats:
    """Return orbits (k, N, dim) begun at their first point in the order of the coordinates, in these units."""
    out = np.empty_like(x)
    for i, one in enumerate(x):
        rough = [tuple(np.round(point / size, 9)) for point in one]
        out[i] = np.roll(one, -min(range(len(one)), key=rough.__getitem__), axis=0)
    return out
