"""Stripes: attractors that coexist share the area of a cell."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from grazing.plot.classes import UNUSED, order_of
from grazing.plot.raster import Floats, is_even, is_linear
from grazing.plot.style import root

#: Distance of stripes along the axes and width of the white line between equal colours, in millimetres.
PITCH, LINE = 1.6, 0.13
#: Pixels per millimetre: 400 per inch; on other than linear axes fewer, since a mesh is slow.
FINE, COARSE = 400.0 / 25.4, 120.0 / 25.4
#: Pixels that are coloured in one go, for the sake of memory.
TOGETHER = 1 << 18


def striped(
    ax: Axes,
    x: Floats,
    y: Floats,
    index: NDArray[np.intp],
    share: Floats,
    codes: NDArray[Any],
    colours: NDArray[np.uint8],
) -> tuple[Floats, Floats, NDArray[np.uint8]]:
    """Return a finer raster in which cells with several attractors are striped.

    Parameters
    ----------
    ax : matplotlib Axes
        Its size says how fine.
    x, y : ndarray, shape (n + 1,) and (m + 1,)
        Edges of the cells.
    index : ndarray, shape (n, m, rank)
        Into ``codes`` and ``colours``.
    share : ndarray, shape (n, m, rank)
        Widths, zero for what is not shown.
    codes : ndarray
        Periods, and codes of classes without one.
    colours : ndarray, shape (len(codes), 4)

    Returns
    -------
    x, y : ndarray
        Edges of the pixels.
    pixels : ndarray, shape (len(x) - 1, len(y) - 1, 4)
    """
    box = ax.get_window_extent()
    size = np.array([box.width, box.height]) / root(ax).dpi * 25.4
    fine = FINE if is_linear(ax) else COARSE
    fine_x, i = _finer(x, int(size[0] * fine) + 1, ax.xaxis)
    fine_y, j = _finer(y, int(size[1] * fine) + 1, ax.yaxis)
    # bands in a fixed order, so that a stripe goes on from cell to cell
    keys = np.array([order_of(int(code)) if code != UNUSED else (True, 99) for code in codes], int)
    rank = np.empty(len(codes), np.intp)
    rank[np.lexsort((keys[:, 1], keys[:, 0]))] = np.arange(len(codes))
    place = np.argsort(np.where(share > 0.0, rank[index], len(codes)), axis=-1, kind="stable")
    index, share = np.take_along_axis(index, place, -1), np.take_along_axis(share, place, -1)
    edges = np.cumsum(share, axis=-1)
    edges = edges / np.where(edges[..., -1:] > 0.0, edges[..., -1:], 1.0)
    pixels = colours[index[..., 0]][i][:, j]
    a, b = np.nonzero(((share > 0.0).sum(axis=-1) > 1)[i][:, j])
    for first in range(0, len(a), TOGETHER):
        p, q = a[first : first + TOGETHER], b[first : first + TOGETHER]
        where = (p + 0.5) * size[0] / len(i) + (q + 0.5) * size[1] / len(j)
        cells = (i[p], j[q])
        pixels[p, q] = _bands(where % PITCH / PITCH, index[cells], edges[cells], share[cells], colours)
    return fine_x, fine_y, pixels


def _bands(
    phase: Floats, index: NDArray[np.intp], edges: Floats, share: Floats, colours: NDArray[np.uint8]
) -> NDArray[np.uint8]:
    """Return the colours of points at a phase of the pattern between 0 and 1, shape (n, 4)."""
    n = np.arange(len(phase))
    last = (share > 0.0).sum(axis=-1) - 1
    band = np.minimum((phase[:, None] >= edges).sum(axis=-1), last)
    found: NDArray[np.uint8] = colours[index[n, band]]
    after = np.where(band == last, 0, band + 1)  # beyond the last band the first one begins again
    same = (found == colours[index[n, after]]).all(axis=-1)
    end = np.where(band == last, 1.0, edges[n, band])
    found[same & (end - phase < LINE / PITCH)] = 255
    return found


def _finer(edges: Floats, pixels: int, axis: Any) -> tuple[Floats, NDArray[np.intp]]:
    """Return edges of at least so many pixels, and the cell that each is in."""
    cells = len(edges) - 1
    scale = axis.get_transform()
    at = scale.transform(edges)
    if is_even(at):
        times = -(-pixels // cells)
        fine, inside = np.linspace(at[0], at[-1], cells * times + 1), np.repeat(np.arange(cells), times)
    else:
        fine = np.linspace(at[0], at[-1], pixels + 1)
        middle = 0.5 * (fine[1:] + fine[:-1])
        inside = np.clip(np.searchsorted(at, middle, side="right") - 1, 0, cells - 1)
    back = fine if axis.get_scale() == "linear" else scale.inverted().transform(fine)
    back[[0, -1]] = edges[[0, -1]]
    return back, inside
