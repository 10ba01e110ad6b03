"""What a grid of basins says of their boundary: its dimension and its entropy."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

#: Cells a side of the boxes in which the entropy is measured.
BOX = 5
#: Neighbours at up to this part of the grid's side are compared, at so many distances.
REACH, DISTANCES = 0.1, 12


def evenly_spaced(values: NDArray[np.float64]) -> bool:
    """Return whether values go up or down in equal steps."""
    steps = np.diff(values)
    return bool(steps.size == 0 or ((np.abs(steps - steps[0]) <= 1e-6 * abs(steps[0])).all() and steps[0] != 0.0))


def basin_entropy(grid: NDArray[np.int64], even: bool = True) -> dict[str, float]:
    """Return the basin entropy, the mean over boxes of -sum p ln p, and its mean over boxes with several attractors.

    Parameters
    ----------
    grid : ndarray of int
        The attractor of each cell, in one or two dimensions; cells beyond the last whole box are left out.

    even : bool
        Whether the grid is evenly spaced; else both are not a number.

    References
    ----------
    Daza, Wagemakers, Georgeot, Guery-Odelin and Sanjuan, Scientific Reports 6 (2016) 31416.
    """
    whole = tuple(n // BOX for n in grid.shape)
    if 0 in whole or not even:
        return {"basin_entropy": float("nan"), "boundary_basin_entropy": float("nan")}
    cut = grid[tuple(slice(0, n * BOX) for n in whole)]
    split = cut.reshape([size for n in whole for size in (n, BOX)])
    boxes = np.moveaxis(split, list(range(1, 2 * grid.ndim, 2)), list(range(grid.ndim, 2 * grid.ndim)))
    boxes = boxes.reshape(int(np.prod(whole)), -1)
    entropy = np.zeros(len(boxes))
    for label in np.unique(cut):
        p = (boxes == label).mean(axis=1)
        entropy -= p * np.log(np.where(p > 0.0, p, 1.0))
    mixed = (boxes != boxes[:, :1]).any(axis=1)
    return {
        "basin_entropy": float(entropy.mean()),
        "boundary_basin_entropy": float(entropy[mixed].mean()) if mixed.any() else float("nan"),
    }


def uncertain_share(grid: NDArray[np.int64], distance: int, longest: int) -> float:
    """Return the share of cells with a neighbour, so many cells away along an axis, on another attractor.

    The cells are those that have both neighbours along every axis at the longest distance, the same for all distances.
    """
    inner = tuple(slice(longest, n - longest) for n in grid.shape)
    here = grid[inner]
    uncertain = np.zeros(here.shape, bool)
    for axis in range(grid.ndim):
        for shift in (-distance, distance):
            moved = list(inner)
            moved[axis] = slice(longest + shift, grid.shape[axis] - longest + shift)
            uncertain |= grid[tuple(moved)] != here
    return float(uncertain.mean())


def uncertainty(grid: NDArray[np.int64], even: bool = True) -> dict[str, float]:
    """Return the uncertainty exponent, its standard error and the dimension of the boundary.

    The share of uncertain cells grows with the distance e of their neighbours as e^a; the box-counting dimension of
    the boundary is the dimension of the grid less a. All are NaN where fewer than three distances meet a boundary.

    Parameters
    ----------
    grid : ndarray of int
        The attractor of each cell, in one or two dimensions.
    even : bool
        Whether the grid is evenly spaced; else all are not a number.

    References
    ----------
    McDonald, Grebogi, Ott and Yorke, Physica D 17 (1985) 125-153.
    """
    longest = max(1, int(REACH * min(grid.shape)))
    distances = np.unique(np.geomspace(1, longest, DISTANCES).round().astype(int))
    usable = [k for k in distances.tolist() if even and 2 * longest < min(grid.shape)]
    shares = np.array([uncertain_share(grid, k, longest) for k in usable])
    met = (shares > 0.0) & (shares < 1.0)
    slope = error = float("nan")
    if met.sum() >= 3:
        slope, error = line_through(np.log(np.array(usable)[met]), np.log(shares[met]))
    return {
        "uncertainty_exponent": slope,
        "uncertainty_error": error,
        "boundary_dimension": grid.ndim - slope,
    }


def line_through(x: NDArray[np.float64], y: NDArray[np.float64]) -> tuple[float, float]:
    """Return the slope of the line of least squares through points, and its standard error."""
    far = x - x.mean()
    slope = float((far * y).sum() / (far * far).sum())
    rest = y - y.mean() - slope * far
    return slope, float(np.sqrt((rest * rest).sum() / (len(x) - 2) / (far * far).sum()))
