"""Cycles beside an orbit that has not settled: Newton's method, multipliers, and whether the orbit approaches."""

from __future__ import annotations

from dataclasses import dataclass
from functools import reduce

import numpy as np
from numpy.typing import NDArray

from grazing.maps.map import Map
from grazing.outcome import InputError

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: Newton steps after which a cycle counts as not found.
STEPS = 12
#: Share of the linear rate of contraction that an approaching orbit must show at least.
RATE = 0.1


class NoTangent(Exception):
    """The map has no Jacobian at a point of the orbit itself, so that no multiplier can be asked for."""


@dataclass(frozen=True, eq=False)
class Cycle:
    """A periodic orbit of least period N.

    Parameters
    ----------
    points : ndarray, shape (N, dim)
    letters : ndarray, shape (N,)
        Letters of the steps from these points.
    radius : float
        Greatest modulus of a multiplier; the cycle attracts if it is below 1.
    frames : ndarray, shape (N, dim, dim)
        At each point the matrix from deviations to coordinates along the eigenvectors.
    """

    points: Floats
    letters: Ints
    radius: float
    frames: NDArray[np.complex128]

    @property
    def period(self) -> int:
        """Least period N."""
        return len(self.points)


def find_cycle(P: Map, state: Floats, letters: Ints, tolerance: Floats) -> Cycle | None:
    """Return the cycle with these letters to which Newton's method leads from a state, or None.

    Parameters
    ----------
    P : Map
    state, tolerance : ndarray, shape (dim,)
        Where to begin, and the Newton step that is small enough.
    letters : ndarray, shape (N,)
        Letters of the next N steps; they set the period.

    Returns
    -------
    Cycle or None
        None if Newton's method does not converge, or ends on a cycle of other letters or of a shorter period.

    Raises
    ------
    NoTangent
        If there is no Jacobian at the state or on the orbit from it.
    """
    with np.errstate(all="ignore"):
        try:
            _tangents(P, state, len(letters))
        except InputError:
            raise NoTangent from None
        try:
            return _newton(P, state, letters, tolerance)
        except (InputError, np.linalg.LinAlgError):  # an iterate that is no state, or a multiplier of exactly 1
            return None


def _newton(P: Map, x: Floats, letters: Ints, tolerance: Floats) -> Cycle | None:
    N = len(letters)
    for _ in range(STEPS):
        end, matrices = _tangents(P, x, N)
        move = np.linalg.solve(np.eye(P.dimension) - reduce(_after, matrices), end - x)
        x = x + move
        if (np.abs(move) <= tolerance).all():
            break
    else:
        return None
    _end, matrices = _tangents(P, x, N)
    orbit = P.orbit(x, N)
    shorter = [k for k in range(1, N) if N % k == 0 and (np.abs(orbit.points[k] - x) <= tolerance).all()]
    if shorter or (orbit.letters != letters).any():
        return None
    turns = [reduce(_after, matrices[s:] + matrices[:s]) for s in range(N)]
    radius = float(np.abs(np.linalg.eigvals(turns[0])).max())
    return Cycle(orbit.points[:-1], orbit.letters, radius, np.array([_frame(M) for M in turns]))


def approaches(cycle: Cycle, points: Floats, letters: Ints, tolerance: Floats) -> NDArray[np.bool_]:
    """Say which orbits approach an attracting cycle.

    Parameters
    ----------
    cycle : Cycle
    points : ndarray, shape (keep, dim, n)
    letters : ndarray, shape (keep, n)
    tolerance : ndarray, shape (dim, n)

    Returns
    -------
    ndarray of bool, shape (n,)
        True where the distance to the cycle, in coordinates along the eigenvectors, falls in every two periods (near
        -1 a quadratic term makes one of the two sides larger), and over all at no less than a tenth of the linear
        rate; a distance within the tolerance counts as arrived.
    """
    N, n = cycle.period, points.shape[2]
    best = np.full(n, np.inf)
    result = np.zeros(n, bool)
    for s in range(N):
        same = (letters[-N:] == np.roll(cycle.letters, -s)[:, None]).all(axis=0)
        deviations = points[::-1][::N] - cycle.points[s][:, None]
        distances = np.abs(np.einsum("ij,tjn->tin", cycle.frames[s], deviations)).max(axis=1)
        floor = np.abs(cycle.frames[s]).sum(axis=1).max() * tolerance.max(axis=0)
        falls = ((distances[:-2] < distances[2:]) | (distances[:-2] <= floor)).all(axis=0)
        turns = (len(distances) - 1) // 2 * 2
        bound = distances[turns] * (1.0 - RATE * (1.0 - cycle.radius)) ** turns
        nearest = same & (distances[0] < best)
        best[nearest] = distances[0, nearest]
        result[nearest] = (falls & (distances[0] <= np.maximum(bound, floor)))[nearest]
    return result & (cycle.radius < 1.0)


def _after(first: Floats, second: Floats) -> Floats:
    return second @ first


def _tangents(P: Map, x: Floats, N: int) -> tuple[Floats, list[Floats]]:
    """Return the N-th iterate and the Jacobians of the N steps; raise InputError where one is undefined."""
    points = P.orbit(x, N).points
    matrices = [P.jacobian(point) for point in points[:-1]]
    if not (np.isfinite(points).all() and np.isfinite(matrices).all()):
        raise InputError("no Jacobian")
    return points[-1], matrices


def _frame(M: Floats) -> NDArray[np.complex128]:
    """Return the inverse of the matrix of eigenvectors; the identity where that is close to singular."""
    vectors = np.linalg.eig(M)[1].astype(np.complex128)
    if np.linalg.cond(vectors) > 1e8:
        return np.eye(len(M), dtype=np.complex128)
    return np.linalg.inv(vectors).astype(np.complex128)
