"""Random numbers from a counter: a hash of their place, so that no order of work can change them."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

_GOLDEN = np.uint64(0x9E3779B97F4A7C15)
_FIRST = np.uint64(0xBF58476D1CE4E5B9)
_SECOND = np.uint64(0x94D049BB133111EB)

Words = NDArray[np.uint64]


def mixed(z: Words) -> Words:
    """Return the finaliser of SplitMix64, a bijection of 64 bits in which every input bit moves every output bit.

    References
    ----------
    Steele, Lea and Flood, OOPSLA 2014, 453-472.
    """
    z = z + _GOLDEN
    z = (z ^ (z >> np.uint64(30))) * _FIRST
    z = (z ^ (z >> np.uint64(27))) * _SECOND
    return z ^ (z >> np.uint64(31))


def followed(key: Any, bits: Any) -> Any:
    """Return the key of a place that is reached from another one by some bits; for arrays and for single words."""
    return mixed(key ^ mixed(bits))


def coordinate_bits(i: Any) -> Any:
    """Return the bits of a coordinate's number, unlike those of a lane's."""
    return i ^ _GOLDEN


def unit(word: Any) -> Any:
    """Return the first 53 bits of a word as a number in [0, 1)."""
    return (word >> np.uint64(11)) * 2.0**-53


def uniform(seed: int, cell: ArrayLike, lanes: int, dimension: int) -> NDArray[np.float64]:
    """Return numbers in [0, 1), shape (lanes, dimension); for many cells (cells, lanes, dimension).

    Parameters
    ----------
    seed : int
        0 <= seed < 2^64.
    cell : array_like of float, shape (n,) or (cells, n)
        The parameter values that name a cell.
    lanes, dimension : int

    Examples
    --------
    >>> bool((uniform(1, (0.5,), 10, 2)[:4] == uniform(1, (0.5,), 4, 2)).all())
    True
    >>> bool((uniform(1, [[0.5], [0.7]], 4, 2)[1] == uniform(1, (0.7,), 4, 2)).all())
    True
    """
    names = np.atleast_2d(np.asarray(cell, np.float64)) + 0.0  # + 0.0: -0 and 0 are one value
    key = mixed(np.full(len(names), seed, np.uint64))
    for bits in np.ascontiguousarray(names.T).view(np.uint64):
        key = followed(key, bits)
    lane = followed(key[:, None], np.arange(lanes, dtype=np.uint64))
    coordinate = coordinate_bits(np.arange(dimension, dtype=np.uint64))
    numbers: NDArray[np.float64] = unit(followed(lane[:, :, None], coordinate))
    return numbers if np.ndim(cell) == 2 else numbers[0]


def uniform_numbers(seed: float, names: Any, out: Any) -> None:
    """Fill ``out`` (cells, dimension, lanes) with the numbers of :func:`uniform`: a kernel, for other machines.

    ``seed`` is a whole number below 2^53 and ``names`` (cells, n) the parameter values that name the cells.
    """
    cells, dimension, lanes = out.shape
    value = np.empty(1)
    for q in range(cells):
        key: Any = np.uint64(seed)
        key = mixed(key)
        for k in range(names.shape[1]):
            value[0] = names[q, k] + 0.0  # -0 and 0 are one value
            key = followed(key, value.view(np.uint64)[0])
        for j in range(lanes):
            lane = followed(key, np.uint64(j))
            for i in range(dimension):
                out[q, i, j] = unit(followed(lane, coordinate_bits(np.uint64(i))))
