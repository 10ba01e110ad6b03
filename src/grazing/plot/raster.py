"""Rasters on a grid of values: exact edges of the cells, also of uneven ones and on logarithmic axes."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import ArrayLike, NDArray

from grazing.catalogue.rows import runs
from grazing.outcome import InputError
from grazing.plot.style import RC, axes, root

Floats = NDArray[np.float64]

#: Widths of cells that differ by less than this share are the same: values from ``linspace`` or ``arange``.
EVEN = 1e-6
#: Dots of a page along an axis: what is nearer than one is drawn as one.
DOTS = 2000


def ordered(values: ArrayLike) -> tuple[Floats, NDArray[np.intp]]:
    """Return the distinct values in rising order, and where each was found first."""
    return np.unique(np.asarray(values, np.float64), return_index=True)


def axes_along(ax: Axes | None, width: float, height: float, *values: ArrayLike) -> Axes:
    """Return the axes given, or those of a new figure: logarithmic along x, or y, where its values are spaced so."""
    new, ax = ax is None, axes(ax, width, height)
    if not new:
        return ax
    for change, spaced in zip((ax.set_xscale, ax.set_yscale), map(is_geometric, values), strict=False):
        if spaced:
            change("log")
    return ax


def is_geometric(values: ArrayLike) -> bool:
    """Whether three values or more are evenly spaced in their logarithm, and not in themselves.

    Examples
    --------
    >>> import numpy as np
    >>> from grazing.plot.raster import is_geometric
    >>> is_geometric(np.geomspace(1e-4, 1.0, 30)), is_geometric(np.linspace(1e-4, 1.0, 30))
    (True, False)
    """
    x, _where = ordered(values)
    return len(x) > 2 and bool(x[0] > 0.0) and is_even(np.log(x)) and not is_even(x)


def edges_of(values: Floats, axis: Any = None) -> Floats:
    """Return the edges of cells around rising values: halfway between neighbours, on the scale of an axis.

    Parameters
    ----------
    values : ndarray, shape (n,)
        Rising. A single value has a cell as wide as a tenth of it, or as 0.1.
    axis : matplotlib Axis, optional
        Whose scale says what halfway is; default: a linear one.

    Returns
    -------
    ndarray, shape (n + 1,)

    Raises
    ------
    InputError
        For values around which a double has no edges.

    Examples
    --------
    >>> import numpy as np
    >>> from grazing.plot.raster import edges_of
    >>> edges_of(np.array([0.0, 1.0, 3.0])).tolist()
    [-0.5, 0.5, 2.0, 4.0]
    """
    with np.errstate(over="ignore", invalid="ignore"):
        edges = _edges(values, axis)
        fits = np.isfinite(edges[-1] - edges[0])
    if not fits:
        raise InputError(f"values from {values[0]:g} to {values[-1]:g} cannot be drawn: they are too large")
    return edges


def _edges(values: Floats, axis: Any) -> Floats:
    if values.size == 1:
        half = 0.05 * (abs(values[0]) or 1.0)
        return np.array([values[0] - half, values[0] + half])
    scale = None if axis is None or axis.get_scale() == "linear" else axis.get_transform()
    at = values if scale is None else scale.transform(values)
    middle = 0.5 * (at[1:] + at[:-1])
    edges = np.concatenate([[2.0 * at[0] - middle[0]], middle, [2.0 * at[-1] - middle[-1]]])
    return np.asarray(edges if scale is None else scale.inverted().transform(edges), np.float64)


def bands_of(there: NDArray[np.bool_], edges: Floats, axis: Any) -> list[tuple[float, float]]:
    """Return where the runs of chosen cells begin and end.

    Where they are more than a page has dots, those less than a dot apart are one, so that drawing takes no longer
    however many there are.

    Parameters
    ----------
    there : ndarray of bool, shape (n,)
    edges : ndarray, shape (n + 1,)
    axis : matplotlib Axis
        On which a dot is as wide everywhere.
    """
    found = np.array(runs(there), np.intp).reshape(-1, 2)
    if len(found) > DOTS:
        place = axis.get_transform().transform(edges)
        apart = place[found[1:, 0]] - place[found[:-1, 1]] > (place[-1] - place[0]) / DOTS
        found = np.stack([found[np.append(True, apart), 0], found[np.append(apart, True), 1]], axis=1)
    return [(float(begin), float(end)) for begin, end in edges[found]]


def name_single(axis: Any, values: Floats) -> None:
    """Give an axis along which there is one value that tick alone: its cell has a width for the eye only."""
    if values.size == 1:
        axis.set_ticks([float(values[0])])


def is_even(edges: Floats) -> bool:
    """Whether all cells are equally wide."""
    widths = np.diff(edges)
    return bool(np.ptp(widths) <= EVEN * widths.mean())


def is_linear(ax: Axes) -> bool:
    """Whether both axes are linear."""
    return ax.get_xscale() == ax.get_yscale() == "linear"


def refined(ax: Axes, x: Floats, y: Floats, cells: NDArray[Any]) -> tuple[Floats, Floats, NDArray[Any]]:
    """Return the same raster with several pixels for each cell, where a cell is about as large as a dot of the page.

    Interpolation then keeps the edges of the cells, and lines as thin as a cell their ink.

    Parameters
    ----------
    ax, x, y, cells
        As in :func:`raster`.
    """
    if not (is_linear(ax) and is_even(x) and is_even(y)):
        return x, y, cells
    box = ax.get_window_extent()
    dots = np.array([box.width, box.height]) / root(ax).dpi * RC["savefig.dpi"]
    for axis in (0, 1):
        times = -(-2 * int(dots[axis]) // cells.shape[axis])
        if 1 < times < 6:
            cells = cells.repeat(times, axis)
    return (
        np.linspace(x[0], x[-1], cells.shape[0] + 1),
        np.linspace(y[0], y[-1], cells.shape[1] + 1),
        cells,
    )


def raster(ax: Axes, x: Floats, y: Floats, cells: NDArray[Any], *, smooth: bool = False, **look: Any) -> Any:
    """Draw cells between edges as pixels: an image where they are even, else a mesh, rasterised in vector files.

    Parameters
    ----------
    ax : matplotlib Axes
    x, y : ndarray, shape (n + 1,) and (m + 1,)
        Edges, rising.
    cells : ndarray, shape (n, m) or (n, m, 4)
        Numbers for a colour map, or colours; the first index is along x.
    smooth : bool
        Whether pixels of the page that hold several cells show their mean; else one of the cells.
    **look
        Such as ``cmap`` and ``norm``.

    Returns
    -------
    AxesImage or QuadMesh
    """
    turned = np.swapaxes(cells, 0, 1)
    if is_linear(ax) and is_even(x) and is_even(y):
        extent = (float(x[0]), float(x[-1]), float(y[0]), float(y[-1]))
        how = "auto" if smooth else "nearest"
        return ax.imshow(turned, extent=extent, origin="lower", aspect="auto", interpolation=how, zorder=1, **look)
    mesh = ax.pcolormesh(x, y, turned, rasterized=True, linewidth=0, zorder=1, **look)
    ax.set(xlim=(x[0], x[-1]), ylim=(y[0], y[-1]))
    return mesh
