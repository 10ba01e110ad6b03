"""How far rounding may move the place on a path at which a test function is zero.

The place solves F(x, p) = 0 and f(x, p) = 0, of the defects F of an orbit and a test function f. Where both are off by
e, it moves by A^-1 e to first order, A being their derivative. What rounding leaves of them is measured: it is by how
much they miss a straight line within a few hundred units in the last place.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from grazing.orbits.equations import Equations
from grazing.orbits.one_sided import EPS

Floats = NDArray[np.float64]

#: Distances at which rounding is measured, and at which a test function is differentiated, in units of coordinates.
NOISY, SMOOTH = 256.0 * EPS, 2.0**-17
#: Part of its size that a coordinate near 0 counts as.
LEAST = 2.0**-10
#: Points at which rounding is measured, and the factor by which it may be larger elsewhere.
PROBES, SAFETY = 16, 4.0
#: Distances across a branch at which it is measured where rounding may have put a place, in scaled coordinates.
ACROSS = 0.5 ** np.arange(52.0, 6.0, -1.0)
#: So many of them beyond the last at which nothing is seen: the place may lie beside the crossing.
MARGIN = 2
#: By how much a test function may rise less steeply along a branch than along its chord.
CHORD = 2.0
#: Test functions that are 1 less a product of derivatives, or plus.
OF_MULTIPLIERS = ("lp", "pd", "ns")


def moved_by_rounding(
    equations: Equations, x: Floats, p: Floats, index: int, along: Floats | None = None
) -> float:  # fmt: skip
    """Return how far from p[-1] the parameter may be at which a test function is zero; infinity where nothing says.

    Parameters
    ----------
    equations : Equations
    x, p : ndarray
        The place that was found.
    index : int
        Which test function.
    along : ndarray, optional
        Where another branch crosses this one there, the direction of this one, in scaled coordinates.
    """
    test, n = equations.tests(x, p)[index], len(x)
    F, J, slopes = equations.expanded(x, p)
    unit = np.concatenate([equations.scale, equations.spans])
    z = np.concatenate([x, p]) / unit
    size = np.maximum(np.abs(z), LEAST)

    def both(shifts: Floats) -> Floats:
        at = (z + shifts) * unit
        heights = equations.heights(at[:, :n], at[:, n:], index, test[::2])
        return np.column_stack([equations.evaluated(at[:, :n], at[:, n:])[0], heights])

    here = np.append(F, test.value)
    slope = sloped(lambda shifts: both(shifts)[:, -1], test.value, SMOOTH * size)
    A = np.vstack([np.column_stack([J, slopes]) * unit, slope])
    if not (np.isfinite(here).all() and np.isfinite(A).all()):
        return float("inf")
    off = np.abs(here) + noise(both, here, size) + EPS * (np.abs(A) @ np.abs(z))
    off[:-1] += equations.rounded(x)  # of numbers far from 0, whose digits end before the defect's
    off[-1] += test.error + (4.0 * EPS if test.type in OF_MULTIPLIERS else 0.0)
    if along is None:
        return shift_of(A, off) * float(equations.spans[-1])
    return crossing_shift(A, off, along, lambda shifts: both(shifts) - here) * float(equations.spans[-1])


def noise(values: Callable[[Floats], Floats], here: Floats, size: Floats) -> Floats:
    """Return what rounding may do to each of several functions at a point, by how much they miss a straight line.

    Parameters
    ----------
    values : callable
        ``values(shifts)`` are the functions (k, m) at points that lie beside it by shifts (k, n).
    here : ndarray, shape (m,)
        Their values at the point itself.
    size : ndarray, shape (n,)
        Of the coordinates.
    """
    ways = NOISY * size * np.cos(np.arange(1.0, PROBES * len(size) + 1.0) ** 2).reshape(PROBES, -1)
    missed = np.abs(0.5 * (values(ways) + values(-ways)) - here)
    missed[~np.isfinite(missed)] = 0.0  # on another piece
    return np.asarray(SAFETY * missed.max(axis=0))


def sloped(height: Callable[[Floats], Floats], middle: float, far: Floats) -> Floats:
    """Return the derivative of a test function by differences, one-sided where it is defined on one side only."""
    above, below = height(np.diag(far)), height(-np.diag(far))
    central = (above - below) / (2.0 * far)
    either = np.where(np.isfinite(above), (above - middle) / far, (middle - below) / far)
    return np.where(np.isfinite(central), central, either)


def shift_of(A: Floats, off: Floats) -> float:
    """Return how far the last coordinate may be off, if defects with derivative A may be off by so much."""
    norm = np.abs(A).max(axis=1)
    if not (norm > 0.0).all():
        return float("inf")
    A, off = A / norm[:, None], off / norm
    try:
        inverse = np.linalg.inv(A)
    except np.linalg.LinAlgError:
        return float("inf")
    found = float(np.abs(inverse[-1]) @ off)
    return found if np.isfinite(found) else float("inf")


def crossing_shift(A: Floats, off: Floats, along: Floats, change: Callable[[Floats], Floats]) -> float:
    """Return how far the last coordinate may be off where another branch crosses.

    There the derivative of the defects has a second null vector, across this branch: along it they change at second
    order or less, so that rounding moves the place by its root or more. How far is measured.

    Parameters
    ----------
    A, off : ndarray
        As of :func:`shift_of`, defects before the test function.
    along : ndarray
        Unit direction of this branch, nearly: that of a chord.
    change : callable
        ``change(shifts)`` is by how much defects and test function differ (k, m) beside the place.
    """
    U, S, V = np.linalg.svd(A[:-1])
    across = V[-1] * (along @ V[-2]) - V[-2] * (along @ V[-1])
    size, fall = float(np.linalg.norm(across)), abs(float(A[-1] @ along))
    if not (size > 0.0 and fall > 0.0):
        return float("inf")
    across /= size
    ways = ACROSS[:, None] * across
    changes = np.stack([change(ways), change(-ways)])
    unseen = (np.abs(changes[..., :-1] @ U[:, -1]) <= np.abs(U[:, -1]) @ off[:-1]).any(axis=0)
    last = int(np.flatnonzero(unseen)[-1]) + MARGIN if unseen.any() else 0
    if last >= len(ACROSS):
        return float("inf")
    beside = np.abs(V[: len(S) - 1].T / S[:-1] @ U[:, :-1].T) @ off[:-1]
    height = off[-1] + float(np.abs(A[-1]) @ beside) + float(np.abs(changes[:, last, -1]).max())
    found = (
        CHORD * height / fall * abs(float(along[-1])) + float(beside[-1]) + float(ACROSS[last]) * abs(float(across[-1]))
    )
    return found if np.isfinite(found) else float("inf")
