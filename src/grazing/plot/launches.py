"""Launches on a pinball table: through which drain each leaves, after how many impacts, and when."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import FuncNorm, LogNorm, to_rgba_array
from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator

from grazing.catalogue.words import share
from grazing.plot.classes import attractor_colours, legend_beside, patch
from grazing.plot.density import plain
from grazing.plot.drawn import inline
from grazing.plot.expected import choice, expect
from grazing.plot.norms import round_ticks
from grazing.plot.provenance import provenance_of
from grazing.plot.raster import axes_along, edges_of, ordered, raster
from grazing.plot.style import root, styled, symbol

#: What can be drawn.
BY = "exit", "hits", "time"
#: Ways out of a legend; rarer ones are summed up.
LISTED = 14


@inline
def launches(
    result: Any, ax: Axes | None = None, *, by: str = "exit", legend: bool | None = None
) -> dict[str, Any]:  # fmt: skip
    """Draw launches over angle and speed; those of one angle or one speed as points above the other.

    Parameters
    ----------
    result : xarray.Dataset
        From :func:`grazing.launches`.
    ax : matplotlib Axes, optional
        Default: a new figure between one and two columns wide.
    by : {"exit", "hits", "time"}
        What the colour says: the way out; impacts before, or the time when the ball leaves, the *lifetime*, on
        a logarithmic scale, white for a ball that stays. Points of a line have the colours of ways out, and are that
        high, the time unless ``by="hits"``.
    legend : bool, optional
        Whether a legend of the ways out stands beside it, None for one in a figure of its own only.

    Returns
    -------
    dict
        ``image`` or ``points``, ``colours`` (way out to colour), ``legend``, ``bar``, ``provenance``, ``figure``.

    Raises
    ------
    InputError
        For another kind of result.

    Examples
    --------
    >>> import grazing as gz
    >>> drains = [gz.drain("short", (0, -1), (3, -1)), gz.drain("far", (3, -1), (9, -1))]
    >>> found = gz.launches(gz.table(drains, tilt=0.5), (0.5, 0.0), [0.6, 0.7], [0.5, 1.5])
    >>> sorted(gz.plot.launches(found)["colours"])
    ['far', 'short']
    """
    both = "angle", "speed"
    expect(result, "launches", {"exit": both, "hits": both, "time": both})
    by = choice(by, "by", BY)
    (x, i), (y, j) = (ordered(result[name].values) for name in both)
    ways, hits, times = (result[name].values[np.ix_(i, j)] for name in BY)
    times = np.where(np.isfinite(times) & (ways != ""), times, np.nan)
    found, index, count = np.unique(ways.ravel(), return_inverse=True, return_counts=True)
    by_size = np.argsort(-count, kind="stable")
    names, index = found[by_size].tolist(), np.argsort(by_size)[index].reshape(ways.shape)
    colours = dict(zip(names, attractor_colours(range(1, len(names) + 1)), strict=True))
    own = ax is None if legend is None else legend
    bar = beside = image = points = None
    with styled():
        if 1 in ways.shape:
            along, name = (y, "speed") if ways.shape[0] == 1 else (x, "angle")
            ax = axes_along(ax, 130.0, 90.0, along)
            high = (hits if by == "hits" else times).ravel()
            each = [index.ravel() == k for k in range(len(names))]
            points = [ax.plot(along[here], high[here], ".", ms=3.0, color=colours[way])[0]
                      for way, here in zip(names, each, strict=True)]  # fmt: skip
            ax.set(xlabel=symbol(result[name]), ylabel="impacts" if by == "hits" else "time")
        else:
            ax = axes_along(ax, 130.0, 90.0, x, y)
            edges = edges_of(x, ax.xaxis), edges_of(y, ax.yaxis)
            if by == "exit":
                palette = np.round(255.0 * to_rgba_array(list(colours.values()))).astype(np.uint8)
                image = raster(ax, *edges, palette[index])
            else:
                image, bar = _logarithmic(ax, edges, np.where(ways != "", hits, np.nan) if by == "hits" else times, by)
            ax.set(xlim=(edges[0][0], edges[0][-1]), ylim=(edges[1][0], edges[1][-1]))
            ax.set(xlabel=symbol(result["angle"]), ylabel=symbol(result["speed"]))
        if own and bar is None:
            shares = [share(float((ways == way).mean()), ways.size) for way in names]
            texts = [f"{way or 'still there'}: {part}" for way, part in zip(names, shares, strict=True)]
            entries = [patch(colours[way], text) for way, text in zip(names, texts, strict=True)]
            if len(names) > LISTED:
                rest = share(float(np.isin(ways, names[LISTED - 1 :]).mean()), ways.size)
                entries[LISTED - 1 :] = [patch("none", f"{len(names) - LISTED + 1} more: {rest}", edgecolor="none")]
            beside = legend_beside(ax, entries)
    return {
        "figure": root(ax), "image": image, "points": points, "colours": colours, "legend": beside, "bar": bar,
        "provenance": provenance_of(result),
    }  # fmt: skip


def _logarithmic(ax: Axes, edges: tuple[Any, Any], numbers: Any, by: str) -> tuple[Any, Any]:
    """Show numbers on a logarithmic scale with its bar; that of impacts is of one more, as there may be none."""
    known = numbers[np.isfinite(numbers)]
    low, high = (float(known.min()), float(known.max())) if known.size else (1.0, 10.0)
    high = high if high > low else 10.0 * low or 1.0
    norm = FuncNorm((np.log1p, np.expm1), low, high) if by == "hits" else LogNorm(low, high)
    image = raster(ax, *edges, np.ma.masked_invalid(numbers), norm=norm)
    bar = root(ax).colorbar(image, ax=ax, label="impacts" if by == "hits" else "time")
    ticks = [tick for tick in round_ticks(norm) if by == "time" or tick >= 1.0]
    bar.ax.yaxis.set_major_locator(FixedLocator([0.0, *ticks] if low == 0.0 else ticks))
    bar.ax.yaxis.set_major_formatter(FuncFormatter(plain))
    bar.ax.yaxis.set_minor_locator(NullLocator())
    return image, bar
