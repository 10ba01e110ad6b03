"""Density diagram: how often orbits visit each bin as one parameter varies."""

from __future__ import annotations

from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import Colormap, ListedColormap, Normalize
from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator
from numpy.typing import NDArray

from grazing.plot.basins import percent
from grazing.plot.drawn import inline
from grazing.plot.expected import choice, expect
from grazing.plot.norms import norm_of, round_ticks
from grazing.plot.provenance import provenance_of
from grazing.plot.raster import axes_along, edges_of, is_even, name_single, ordered, raster, refined
from grazing.plot.style import DOUBLE, note, root, styled, symbol

Floats = NDArray[np.float64]

#: Most columns, and most bins, that are drawn one by one.
MOST = 4000


@inline
def density(
    result: Any,
    ax: Axes | None = None,
    *,
    norm: str | Normalize = "eqhist",
    units: str = "share",
    cmap: str | Colormap | None = None,
    bar: bool = True,
) -> dict[str, Any]:
    """Draw a density diagram: darker bins are visited more often, empty ones are left white.

    Parameters
    ----------
    result : xarray.Dataset
        From :func:`grazing.density`: ``count`` on (parameter, coordinate).
    ax : matplotlib Axes, optional
        Default: a new figure two columns wide.
    norm : {"eqhist", "log", "linear"} or matplotlib Normalize
        From numbers to colours: histogram-equalised, where equal ranges of colour are equally many bins; logarithmic;
        linear; or your own.
    units : {"share", "count"}
        Whether the numbers are shares of the points at a parameter value, those outside the raster included, or
        counts.
    cmap : str or Colormap, optional
        Default: from light yellow to black.
    bar : bool
        Whether a colour bar stands beside the diagram.

    Returns
    -------
    dict
        ``image``, ``bar`` (Colorbar or None), ``note`` (text above the axes that says how much lies outside of the
        raster, or None), ``provenance``, ``figure``.

    Raises
    ------
    InputError
        For another kind of result, norm or units.
    """
    name, coordinate = expect(result, "density", {"count": ("<parameter>", "<coordinate>")})
    choice(units, "units", ("share", "count"))
    values, where = ordered(result[name].values)
    count, columns, bins = pooled(np.asarray(result["count"].values), where)
    sides = (result[side].values[where] for side in ("below", "above") if side in result)
    outside = np.add.reduceat(sum(sides, np.zeros(where.size)), columns)
    total = count.sum(axis=1) + outside
    wide, high = (np.diff([*first, size]) for first, size in ((columns, where.size), (bins, result[coordinate].size)))
    count /= (np.maximum(total, 1.0) if units == "share" else wide)[:, None] * high  # of one bin, on average
    with styled():
        ax = axes_along(ax, DOUBLE, 80.0, values)
        scale = norm_of(norm, count)
        shown = np.ma.masked_less_equal(count.astype(np.float32), 0.0)
        x, y = edges_of(values, ax.xaxis), bins_of(result[coordinate])
        image = raster(
            ax,
            *refined(ax, kept(x, columns), kept(y, bins), shown),
            smooth=True,
            norm=scale,
            cmap=cmap if cmap is not None else paper_map(),
        )
        ax.set(xlim=(x[0], x[-1]), ylim=(y[0], y[-1]))
        name_single(ax.xaxis, values)
        ax.set(xlabel=symbol(result[name]), ylabel=symbol(result[coordinate]))
        drawn = bar_beside(ax, image, units) if bar else None
        note = said_beside(ax, float(outside.sum()), float(total.sum()), result)
    return {"figure": root(ax), "image": image, "bar": drawn, "note": note, "provenance": provenance_of(result)}


def pooled(counts: NDArray[Any], where: NDArray[np.intp]) -> tuple[Floats, NDArray[np.intp], NDArray[np.intp]]:
    """Return counts in the order of the values, and the first column and the first bin of every cell that is drawn.

    A page has some thousand dots: where there are more columns or bins, neighbours are drawn as one, so that drawing
    takes the same memory however large the result is.
    """
    columns, bins = (np.arange(0, size, -(-size // MOST)) for size in (where.size, counts.shape[1]))
    ends = [*columns[1:].tolist(), where.size]
    found = np.empty((columns.size, bins.size))
    for i, (start, end) in enumerate(zip(columns.tolist(), ends, strict=True)):
        found[i] = np.add.reduceat(counts[where[start:end]].sum(axis=0, dtype=np.float64), bins)
    return found, columns, bins


def kept(edges: Floats, first: NDArray[np.intp]) -> Floats:
    """Return the edges of cells that begin at these ones; even ones stay even, so that the last may reach too far."""
    if first.size == edges.size - 1 or not is_even(edges):
        return np.append(edges[first], edges[-1])
    width = (edges[-1] - edges[0]) / (edges.size - 1) * (first[1] - first[0])
    return np.asarray(edges[0] + width * np.arange(first.size + 1), np.float64)


def paper_map() -> ListedColormap:
    """Return the colours of densities: dark is much, and the least is still darker than white paper."""
    return ListedColormap(matplotlib.colormaps["magma_r"](np.linspace(0.1, 1.0, 256)), name="density")


def bins_of(coordinate: Any) -> Any:
    """Return the edges of the bins: the ends of the raster are kept, for the sake of rounding."""
    centres = np.asarray(coordinate.values, np.float64)
    low, high = (coordinate.attrs.get(end) for end in ("low", "high"))
    return edges_of(centres) if low is None or high is None else np.linspace(float(low), float(high), centres.size + 1)


def bar_beside(ax: Axes, image: Any, units: str) -> Any:
    """Draw the bar of the colours beside axes."""
    drawn = root(ax).colorbar(image, ax=ax, pad=0.015, fraction=0.05, aspect=30)
    drawn.outline.set_linewidth(0.4)
    drawn.set_label("points per bin" if units == "count" else "share of the points per bin")
    if image.norm.vmin and image.norm.vmin > 0.0:  # a linear scale begins at 0 and has ticks of its own
        drawn.ax.yaxis.set_major_locator(FixedLocator(round_ticks(image.norm)))
        drawn.ax.yaxis.set_major_formatter(FuncFormatter(plain))
    drawn.ax.yaxis.set_minor_locator(NullLocator())
    return drawn


def plain(value: float, _place: Any = None) -> str:
    r"""Return a round number for a scale over many decades: as it is where that is short.

    Examples
    --------
    >>> from grazing.plot.density import plain
    >>> plain(0.05), plain(0.0005), plain(0.001), plain(20.0), plain(1e6)
    ('0.05', '$5\\times 10^{-4}$', '$10^{-3}$', '20', '$10^{6}$')
    """
    if value == 0.0 or 0.01 <= value < 10_000.0:
        return f"{value:g}"
    digit, decade = f"{value:e}".split("e")
    power = f"10^{{{int(decade)}}}"
    return f"${power}$" if float(digit) == 1.0 else rf"${float(digit):g}\times {power}$"


def said_beside(ax: Axes, outside: float, total: float, result: Any) -> Any:
    """Say above the axes what the raster does not show."""
    said = []
    if outside > 0.0:
        said.append(f"{percent(outside / total).replace('<', 'less than')} of the points lie outside")
    ended = int(np.sum(result["ended"].values)) if "ended" in result else 0
    if ended:
        said.append(f"{ended:,} {'start' if ended == 1 else 'starts'} ended")
    return note(ax, "; ".join(said))
