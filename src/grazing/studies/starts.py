"""Random starts from a counter: the same whatever the threads, the order of the work or the rest of the sweep.

Each number is a hash of (seed, cell, lane, coordinate). A cell is named by its parameter values, so that a cell
computed alone, or in a finer sweep, gets the same starts.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from grazing.kernel.random import mixed as mixed
from grazing.kernel.random import uniform as uniform
from grazing.kernel.random import uniform_numbers
from grazing.outcome import InputError, shown
from grazing.parameter import checked_box as checked_box
from grazing.parameter import in_order, whole


def random_starts(seed: int, cell: ArrayLike, lanes: int, box: ArrayLike) -> NDArray[np.float64]:
    """Return random states in a box, shape (dim, lanes); for many cells (cells, dim, lanes).

    Parameters
    ----------
    seed : int
        0 <= seed < 2^64.
    cell : array_like of float, shape (n,) or (cells, n)
        The parameter values that name a cell.
    lanes : int
        Number of states; a state does not depend on how many there are.
    box : array_like, shape (dim, 2) or (cells, dim, 2)
        (low, high) of each coordinate.

    Examples
    --------
    >>> random_starts(0, (0.1,), 3, ((0.0, 1.0), (5.0, 6.0))).shape
    (2, 3)
    """
    ends = np.asarray(box, np.float64)
    low, high = ends[..., 0, None], ends[..., 1, None]
    numbers = np.swapaxes(uniform(seed, cell, lanes, ends.shape[-2]), -1, -2)
    return np.ascontiguousarray(low + (high - low) * numbers)


def drawn_starts(seed: float, names: Any, boxes: Any, lanes: Any) -> None:
    """Fill ``lanes`` (cells, dim, n) with the states of :func:`random_starts`: a kernel, for other machines.

    ``seed`` is a whole number below 2^53, ``names`` (cells, n) and ``boxes`` (cells, dim, 2) are as there.
    """
    uniform_numbers(seed, names, lanes)
    for q in range(lanes.shape[0]):
        for i in range(lanes.shape[1]):
            low, high = boxes[q, i, 0], boxes[q, i, 1]
            for j in range(lanes.shape[2]):
                lanes[q, i, j] = low + (high - low) * lanes[q, i, j]


def checked_seed(seed: object) -> int:
    """Return the seed, or raise InputError."""
    number = whole(seed, "seed", 0, math.inf)
    if number >= 2**64:
        raise InputError(f"seed = {shown(number)}; allowed is a whole number below 2^64")
    return number


def checked_starts(starts: ArrayLike, coordinates: Sequence[str]) -> int | NDArray[np.float64]:
    """Return a number of random starts, or given starts as an array (n, dim); raise InputError for neither."""
    if not hasattr(starts, "__len__") or getattr(starts, "ndim", 1) == 0:
        return whole(starts, "starts", 1)
    wanted = f"give a whole number >= 1, or states of shape (n, {len(coordinates)}): {', '.join(coordinates)}"
    try:
        if np.iscomplexobj(starts):
            raise TypeError
        states = np.array(in_order(starts), np.float64)
    except Exception:  # of whatever object was given, or of one too large
        raise InputError(f"starts are not numbers; {wanted}") from None
    if states.ndim != 2 or states.shape[1] != len(coordinates) or not len(states):
        raise InputError(f"starts have shape {states.shape}; {wanted}")
    if not np.isfinite(states).all():
        raise InputError(f"start {np.flatnonzero(~np.isfinite(states).all(axis=1))[0]} is not finite; {wanted}")
    return states
