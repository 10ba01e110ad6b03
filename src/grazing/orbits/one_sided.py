"""Derivatives by differences that stay on one piece of a map, each with its error."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

#: Neighbouring distances differ by this factor; they begin at this part of the size of what is moved.
FINER, FIRST = 4.0, 0.05
#: How many distances there are, at least and at most; the finest are small against the coordinate itself, too.
LEVELS, MOST = 24, 60
#: Columns of the table of extrapolations.
DEPTH = 5
EPS = float(np.finfo(float).eps)


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
    with np.errstate(all="ignore"):
        loud = np.fmax(np.fmax(np.abs(low), np.abs(high)), np.abs(middle))
        # a value that is small where larger ones cancel is as noisy as they are
        noise = np.broadcast_to(4.0 * EPS * np.fmax.reduce(loud, axis=0), low.shape)
        central = extrapolated((high - low) / (up + down), noise / (up + down), 2)
        sides = np.stack([(middle - low) / down, (high - middle) / up], axis=1)
        one_sided = extrapolated(sides, np.stack([noise / down, noise / up], axis=1), 1)
        values = np.stack([central[0], *one_sided[0]])
        errors = np.stack([central[1], *one_sided[1]])
        _middle, below, above = values
        usual = noise[0] * FIRST / (4.0 * EPS * up[0])
        torn = np.abs(above - below) > 10.0 * (errors[1] + errors[2])
        best = np.argmin(relative(values, errors, usual), axis=0)[None]
        value, least = (np.take_along_axis(one, best, 0)[0] for one in (values, errors))
        least = np.where(torn, np.maximum(np.abs(above - below), least), least)
    return Slope(value, least, below, above)


def extrapolated(rough: Floats, noise: Floats, power: int) -> tuple[Floats, Floats]:
    """Return the limit of differences (levels, ...) and its error, after Ridders: the entry that varies least."""
    column, entries, errors = rough, [], []
    for m in range(1, DEPTH + 1):
        share = 1.0 / (FINER ** (m if power == 1 else 2 * m) - 1.0)
        finer = column[1:] + share * (column[1:] - column[:-1])
        entries.append(finer)
        apart = np.maximum(np.abs(finer - column[1:]), np.abs(finer - column[:-1])) + 2.0 * noise[m:]
        apart[:-1] = np.maximum(apart[:-1], np.abs(finer[1:] - finer[:-1]))  # two may agree by chance
        errors.append(apart)
        column = finer
    error = np.concatenate(errors)
    error[~np.isfinite(error)] = np.inf
    value = np.concatenate(entries)
    place = np.argmin(relative(value, error, noise[0] * FIRST / (4.0 * EPS)), axis=0)[None]
    return np.take_along_axis(value, place, 0)[0], np.take_along_axis(error, place, 0)[0]


def relative(value: Floats, error: Floats, usual: Floats) -> Floats:
    """Return errors in units of the slope, or of a usual one where it is less: too far off a steep one looks flat."""
    return np.where(np.isfinite(error), error / (np.abs(value) + usual), np.inf)
