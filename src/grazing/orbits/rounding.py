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


def moved_by_rounding(equations: Equations, x: Floats, p: Floats, index: int, crossed: bool = False) -> float:
    """Return how far from p[-1] the parameter may be at which a test function is zero; infinity where nothing says.

    Parameters
    ----------
    equations : Equations
    x, p : ndarray
        The place that was found.
    index : int
        Which test function.
    crossed : bool
        Whether another branch crosses this one there: then the place is taken along this one.
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
    off[-1] += test.error
    return shift_of(A, off, crossed) * float(equations.spans[-1])


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


def shift_of(A: Floats, off: Floats, crossed: bool) -> float:
    """Return how far the last coordinate may be off, if defects with derivative A may be off by so much."""
    norm = np.abs(A).max(axis=1)
    if not (norm > 0.0).all():
        return float("inf")
    A, off = A / norm[:, None], off / norm
    if crossed:  # what takes one branch to the other is no error of the place on this one
        U, S, across = np.linalg.svd(A)
        inverse = (across[:-1].T / S[:-1]) @ U[:, :-1].T
    else:
        try:
            inverse = np.linalg.inv(A)
        except np.linalg.LinAlgError:
            return float("inf")
    found = float(np.abs(inverse[-1]) @ off)
    return found if np.isfinite(found) else float("inf")
