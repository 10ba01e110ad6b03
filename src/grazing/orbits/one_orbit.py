"""Whether two solutions of the equations of an orbit are one solution that rounding has moved.

Where the defects F of an orbit are off by e, its solution is off by F'^-1 e to first order. So solutions are copies of
one where they differ by no more than that, however much it is: next to a law that takes hardly any speed it is a
million times as much as elsewhere, and two orbits whose equations are well conditioned may be as near as Newton's
method leaves them.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from grazing.orbits.one_sided import EPS

Floats = NDArray[np.float64]

#: By how much rounding may be larger than a unit of what is rounded, and a solution be off by more than to first order.
SAFETY, BENT = 8.0, 2.0
#: Part of the size of unknowns by which rounding may move them at most: beyond, orbits are a family rather than one.
FAR = 0.125
#: So far from a solution, in its units, Newton's method may end by itself, though its defects be rounding.
NEAR = 1e-11


def moved(F: Floats, J: Floats, x: Floats, rounded: Floats, scale: Floats, least: float) -> Floats:
    """Return by how much each unknown of a solution may be off, with all that solutions count as copies for.

    Parameters
    ----------
    F, J : ndarray, shapes (n,) and (n, n)
        Defects at the solution, and their derivative.
    x, rounded, scale : ndarray, shape (n,)
        The solution, what rounding may do to the defects besides that of the unknowns, and the units of unknowns.
    least : float
        What counts where nothing can be said: so much in these units.
    """
    wide = J * scale
    rows = np.abs(wide).max(axis=1, initial=0.0)
    if not (np.isfinite(F).all() and np.isfinite(wide).all() and (rows > 0.0).all()):
        return least * scale
    off = np.abs(F) + SAFETY * (rounded + EPS * (np.abs(J) @ np.abs(x)))
    try:
        inverse = np.linalg.inv(wide / rows[:, None])
    except np.linalg.LinAlgError:
        return least * scale
    found = BENT * np.abs(inverse) @ (off / rows)
    if not found.max(initial=0.0) < FAR:
        return least * scale
    return np.asarray(np.maximum(found, NEAR) * scale)


def cells(prints: Floats, size: float) -> list[NDArray[np.int64]]:
    """Return the rows of which all numbers are alike to this size, each in order, in the order of their first ones."""
    if not len(prints):
        return []
    _cell, which = np.unique(np.round(prints / size), axis=0, return_inverse=True)
    order = np.argsort(which.ravel(), kind="stable")
    return sorted(np.split(order, np.flatnonzero(np.diff(which.ravel()[order])) + 1), key=lambda rows: int(rows[0]))
