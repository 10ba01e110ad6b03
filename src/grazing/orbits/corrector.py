"""Points of a path: the unknowns x and the parameter p, each divided by its scale, corrected by Newton's method.

A guess is corrected in the plane across a direction (Keller), so that a fold is a point like any other.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from grazing.orbits.equations import Equations, Test
from grazing.orbits.one_sided import EPS

Floats = NDArray[np.float64]

#: Newton steps of the corrector, and the last one's length that counts as arrived.
STEPS, SMALL = 10, 1e-13
#: Newton steps cut short at the end of a piece, one after the other, after which there is no solution on it.
CUT = 3
#: Defect, in scaled unknowns and beside rounding, up to which a point on a piece of a map is a solution.
CLOSED = 1e-13


class Point(NamedTuple):
    """A solution z = (x, p) in scaled coordinates, the unit tangent there, and the test functions."""

    z: Floats
    tangent: Floats
    tests: tuple[Test, ...]


def unscaled(equations: Equations, z: Floats) -> tuple[Floats, Floats]:
    """Return x and p of a point in scaled coordinates."""
    n = len(equations.scale)
    return z[:n] * equations.scale, z[n:] * equations.spans


@np.errstate(over="ignore", invalid="ignore")  # what leaves the numbers is looked at
def closed(equations: Equations, x: Floats, p: Floats) -> Floats | None:
    """Solve the equations at fixed parameters by Newton's method; None where it does not converge."""
    x, before, cut = np.array(x, np.float64), np.inf, 0
    for _ in range(30):
        F, J = equations.defects(x, p)
        if not (np.isfinite(F).all() and np.isfinite(J).all()):
            return None
        F, J = weighed(F, J * equations.scale)
        try:
            move = np.linalg.solve(J, F) * equations.scale
        except np.linalg.LinAlgError:
            return None
        size = float(np.abs(move / equations.scale).max()) if len(move) else 0.0
        if equations.pieced:
            share = equations.reach(x, p, np.asarray(-move, np.float64), np.zeros(len(p)))
            if share < 1.0:
                cut += 1
                if share == 0.0 or cut > CUT:
                    return None
                x, before = x - share * move, np.inf
                continue
            cut = 0
        x = x - move
        if size <= 1e-15 or (size <= 1e-9 and size >= 0.25 * before):
            return x
        if not size < 1e3:
            return None
        before = size
    return None


def linearised(equations: Equations, z: Floats) -> tuple[Floats, Floats]:
    """Return the defects and their derivative (n, n + 1) in scaled coordinates, see :func:`weighed`."""
    x, p = unscaled(equations, z)
    F, J, slopes = equations.expanded(x, p)
    wide = np.empty((len(F), len(z)))
    wide[:, : len(x)], wide[:, len(x) :] = J * equations.scale, slopes * equations.spans
    return weighed(F, wide)


def weighed(F: Floats, wide: Floats) -> tuple[Floats, Floats]:
    """Return equations with derivatives in scaled coordinates, each divided by the size of its derivatives.

    Positions and velocities then weigh alike, and elimination meets the same pivots in any unit. Sizes are rounded to
    powers of two, by which nothing else is rounded.
    """
    size = np.abs(wide).max(axis=1)
    size = np.ldexp(1.0, np.frexp(np.where(size > 0.0, size, 1.0))[1])
    return F / size, wide / size[:, None]


def tangent_of(wide: Floats, along: Floats) -> Floats:
    """Return the unit null vector of a derivative (n, n + 1) that points along a given vector."""
    right = np.zeros(len(along))
    right[-1] = 1.0
    t = solved_or_least(np.vstack([wide, along]), right)
    t = np.ldexp(t, -int(np.frexp(np.abs(t).max())[1]))  # its length may be beyond all numbers
    t = t / np.linalg.norm(t)
    return np.asarray(t if t @ along >= 0.0 else -t)


def solved_or_least(A: Floats, b: Floats) -> Floats:
    """Solve A x = b; where A is singular, as where two branches cross, the shortest x with the least defect."""
    try:
        return np.asarray(np.linalg.solve(A, b))
    except np.linalg.LinAlgError:
        return np.asarray(np.linalg.lstsq(A, b)[0])


def corrected(
    equations: Equations, z: Floats, across: Floats, known: Floats | None = None
) -> tuple[Floats, Floats, int] | None:
    """Solve the equations in the plane through z across a vector: the point, the derivative there, steps; or None.

    Equations of one piece of a map are solved from within: steps are cut short where they would leave it, the first one
    from a ``known`` point.
    """
    plane, before, cut, step = z.copy(), np.inf, 0, 0
    z = z.copy()
    if equations.pieced and known is not None:
        z = known + within(equations, known, z - known) * (z - known)
    while step < STEPS:
        step += 1
        F, wide = linearised(equations, z)
        if not (np.isfinite(F).all() and np.isfinite(wide).all()):
            return None
        A, missed = np.vstack([wide, across]), np.append(F, across @ (z - plane))
        move = solved_or_least(A, missed)
        if not EPS * np.abs(A).max() * np.abs(move).max() <= np.abs(missed).max():  # A is singular but for rounding
            move = np.asarray(np.linalg.lstsq(A, missed)[0])
        size = float(np.abs(move).max())
        if not size < 1e3:
            return None
        if equations.pieced:
            share = within(equations, z, -move)
            if share < 1.0:
                cut, step = cut + 1, step - 1
                if share == 0.0 or cut > CUT:
                    return None
                z, before = z - share * move, np.inf
                continue
            cut = 0
        z = z - move
        if size <= SMALL or (size <= 1e-9 and size >= 0.25 * before):
            if closes(equations, z):
                return z, wide, step
        if size > 2.0 * before and step > 2:
            return None
        before = size
    return None


def within(equations: Equations, z: Floats, move: Floats) -> float:
    """Return the part of a step in scaled coordinates after which equations of one piece hold still."""
    return equations.reach(*unscaled(equations, z), *unscaled(equations, move))


def closes(equations: Equations, z: Floats) -> bool:
    """Whether what Newton's method found on a piece of a map is a solution, not a place where the map jumps."""
    if not equations.pieced:
        return True
    x, p = unscaled(equations, z)
    F, J = equations.defects(x, p)
    rounding = 8.0 * EPS * (np.abs(J) @ np.abs(x))
    return bool((np.abs(F) <= CLOSED * equations.scale * (1.0 + np.abs(z[: len(F)])) + rounding).all())


def point_at(equations: Equations, z: Floats, along: Floats, known: Floats | None = None) -> Point | None:
    """Return the point of the path in the plane through z across ``along``."""
    found = corrected(equations, z, along, known)
    if found is None:
        return None
    z, wide, _steps = found
    return Point(z, tangent_of(wide, along), equations.tests(*unscaled(equations, z)))


def advanced(equations: Equations, here: Point, h: float) -> tuple[Point | None, int]:
    """Return the point one step further, and the Newton steps that took."""
    found = corrected(equations, here.z + h * here.tangent, here.tangent, here.z)
    if found is None:
        return None, STEPS
    z, wide, steps = found
    if np.linalg.norm(z - here.z) > 2.0 * h:
        return None, STEPS
    return Point(z, tangent_of(wide, here.tangent), equations.tests(*unscaled(equations, z))), steps


def at_value(equations: Equations, a: Point, b: Point, value: float, index: int = -1) -> Point | None:
    """Return the point between two at which a scaled coordinate has a value, by Newton's method at that value.

    The coordinate is the parameter, if no other ``index`` is given.
    """
    share = (value - a.z[index]) / (b.z[index] - a.z[index])
    z = a.z + share * (b.z - a.z)
    z[index] = value
    across = np.zeros(len(z))
    across[index] = 1.0
    found = corrected(equations, z, across, a.z)
    if found is None:
        return None
    z, wide, _steps = found
    z[index] = value
    return Point(z, tangent_of(wide, a.tangent), equations.tests(*unscaled(equations, z)))
