"""Derivatives by differences that stay on one piece of a map, each with its error."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from grazing.kernel.compile import call, compiled

Floats = NDArray[np.float64]

#: Neighbouring distances differ by this factor; they begin at this part of the size of what is moved.
FINER, FIRST = 4.0, 0.05
#: How many distances there are, at least and at most; the finest are small against the coordinate itself, too.
LEVELS, MOST = 24, 60
#: Columns of the table of extrapolations.
DEPTH = 5
EPS = float(np.finfo(float).eps)
NAN, INFINITY = float("nan"), float("inf")


class Slope(NamedTuple):
    """A derivative, the error of each of its numbers, and those from below and from above."""

    value: Floats
    error: Floats
    below: Floats
    above: Floats


def distances(size: Any, place: Any) -> Floats:
    """Return distances (levels, ...) at which differences are taken, from coarse to fine.

    Next to a place of 0 floating-point numbers lie close, and a square root there wants distances as small.
    """
    size, place = np.broadcast_arrays(np.asarray(size, np.float64), np.abs(np.asarray(place, np.float64)))
    with np.errstate(divide="ignore", over="ignore"):
        near = np.log(np.max(size / np.maximum(place, 1e-300), initial=1.0)) / np.log(FINER)
    levels = int(min(LEVELS + np.ceil(max(near, 0.0)), MOST))
    powers = FINER ** -np.arange(levels, dtype=np.float64)
    return np.asarray(FIRST * size * powers.reshape(-1, *(1,) * size.ndim))


def slope(middle: Floats, low: Floats, high: Floats, down: Floats, up: Floats) -> Slope:
    """Return the derivative of a function from its values at a point and on both sides, by extrapolation.

    Parameters
    ----------
    middle : ndarray
        Values at the point.
    low, high : ndarray, shape (levels, ...)
        Values below and above, from far to near; NaN where the point is on another piece.
    down, up : ndarray, shape (levels, ...)
        How far below and above.

    Returns
    -------
    Slope
        The best of central and both one-sided differences. Where those from below and above contradict each other, as
        at a kink, the error is their difference; where there are no values, it is infinite.
    """
    levels = len(low)
    shape = np.broadcast_shapes(middle.shape, low.shape[1:], down.shape[1:])
    # copies that are all alike, so that one kernel is for all
    sides = np.empty((4, levels, *shape))
    for side, one in zip(sides, (low, high, down, up), strict=True):
        side[...] = one
    flat, centre, found = sides.reshape(4, levels, -1), np.empty(shape), np.empty((4, *shape))
    centre[...] = middle
    with np.errstate(all="ignore"):  # where kernels are not compiled
        run = compiled(slopes)
        call(run, centre.ravel(), *flat, np.empty((3, levels)), found.reshape(4, -1))
    return Slope(*found)


def slopes(middle: Any, low: Any, high: Any, down: Any, up: Any, room: Any, found: Any) -> None:
    """Write value, error and both one-sided derivatives (4, n) of n numbers; ``room`` is (3, levels)."""
    levels = len(low)
    rough, finer, noise = room[0], room[1], room[2]
    for e in range(len(middle)):
        loudest = abs(middle[e])
        for i in range(levels):
            for height in (abs(low[i, e]), abs(high[i, e])):
                if height > loudest or loudest != loudest:
                    loudest = height
        loudest = 4.0 * EPS * loudest  # a value that is small where larger ones cancel is as noisy as they are
        for i in range(levels):
            apart = up[i, e] + down[i, e]
            rough[i], noise[i] = (high[i, e] - low[i, e]) / apart, loudest / apart
        value, error = extrapolated(rough, finer, noise, 2)
        for i in range(levels):
            rough[i], noise[i] = (middle[e] - low[i, e]) / down[i, e], loudest / down[i, e]
        below, error_below = extrapolated(rough, finer, noise, 1)
        for i in range(levels):
            rough[i], noise[i] = (high[i, e] - middle[e]) / up[i, e], loudest / up[i, e]
        above, error_above = extrapolated(rough, finer, noise, 1)
        usual = loudest * FIRST / (4.0 * EPS * up[0, e])
        gap = abs(above - below)
        torn = gap > 10.0 * (error_below + error_above)
        best = relative(value, error, usual)
        for other, its_error in ((below, error_below), (above, error_above)):
            share = relative(other, its_error, usual)
            if share < best or (share != share and best == best):
                value, error, best = other, its_error, share
        found[0, e] = value
        found[1, e] = gap if torn and gap > error else error
        found[2, e], found[3, e] = below, above


def extrapolated(rough: Any, finer: Any, noise: Any, power: int) -> tuple[float, float]:
    """Return the limit of differences and its error, after Ridders: the entry that varies least.

    ``rough`` (levels,) are the differences and ``noise`` what rounding leaves of them; ``rough`` and ``finer`` are
    overwritten.
    """
    usual = noise[0] * FIRST / (4.0 * EPS)
    value, error, best, factor = NAN, INFINITY, INFINITY, 1.0
    for m in range(1, DEPTH + 1):
        for _ in range(power):
            factor *= FINER
        share = 1.0 / (factor - 1.0)
        count = len(rough) - m
        for i in range(count):
            finer[i] = rough[i + 1] + share * (rough[i + 1] - rough[i])
        for i in range(count):
            apart = larger(abs(finer[i] - rough[i + 1]), abs(finer[i] - rough[i])) + 2.0 * noise[m + i]
            if i < count - 1:  # two may agree by chance
                apart = larger(apart, abs(finer[i + 1] - finer[i]))
            off = apart if apart < INFINITY else INFINITY
            this = relative(finer[i], off, usual)
            if (m == 1 and i == 0) or this < best or (this != this and best == best):
                value, error, best = finer[i], off, this
        for i in range(count):
            rough[i] = finer[i]
    return value, error


def larger(a: float, b: float) -> float:
    """Return the larger of two numbers, NaN if one is."""
    return a if a > b or a != a else b


def relative(value: float, error: float, usual: float) -> float:
    """Return an error in units of the slope, or of a usual one where it is less: too far off a steep one looks flat."""
    return error / (abs(value) + usual) if error < INFINITY else INFINITY
