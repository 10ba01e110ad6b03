"""Launches that graze an object, as curves over angle and speed, alone or on the picture of exits."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patheffects import withStroke

from grazing.plot.classes import legend_extended
from grazing.plot.drawn import inline
from grazing.plot.expected import expect
from grazing.plot.provenance import provenance_of
from grazing.plot.style import INK, axes, root, styled, symbol

#: Of objects whose law kicks a ball that grazes them, and of others: what a legend says, and the colours.
KICKED, PASSIVE = "graze with a kick", "graze"
COLOURS = {KICKED: "#d62728", PASSIVE: INK}
WIDTH, RIM = 0.9, 2.0


@inline
def grazes(result: Any, ax: Axes | None = None, *, legend: bool | None = None) -> dict[str, Any]:
    """Draw the launches that graze an object; in red where its law kicks, and the map jumps.

    Parameters
    ----------
    result : xarray.Dataset
        From :func:`grazing.grazes`.
    ax : matplotlib Axes, optional
        Such as those of :func:`grazing.plot.launches` of the same table, whose limits and labels then stay. Default: a
        new figure between one and two columns wide.
    legend : bool, optional
        Whether a legend stands beside the axes; entries of a legend that is there already are kept; None for one in a
        new figure, or where there is one.

    Returns
    -------
    dict
        ``lines`` (what the legend says to line), ``legend`` (or None), ``provenance``, ``figure``.

    Raises
    ------
    InputError
        For another kind of result.

    Examples
    --------
    >>> import grazing as gz
    >>> table = gz.table([gz.disc("A", (1, 0), 0.4, gz.active(r=0.8, V=0.3))], rho=0.1)
    >>> found = gz.grazes(table, (0, 0), angle=(0.1, 1.5), speed=(1, 2), order=0)
    >>> list(gz.plot.grazes(found)["lines"])
    ['graze with a kick']
    """
    along = ("point",)
    expect(result, "grazes", {"angle": along, "speed": along, "row": along, "kick": ("curve",)})
    both = "angle", "speed"
    points = np.column_stack([np.asarray(result[name].values, np.float64) for name in both])
    kicked = result["kick"].values[result["row"].values] > 0.0
    with styled():
        fresh = ax is None or not ax.has_data()
        ax = axes(ax, 130.0, 90.0)
        legend = (fresh or ax.get_legend() is not None) if legend is None else legend
        limits = ax.get_xlim(), ax.get_ylim()
        rim = [withStroke(linewidth=RIM, foreground="white", alpha=0.9)]
        lines: dict[str, Line2D] = {}
        for name, here in ((PASSIVE, ~kicked), (KICKED, kicked)):
            if here.any():
                x, y = np.where(here[:, None], points, np.nan).T
                (lines[name],) = ax.plot(
                    x, y, color=COLOURS[name], lw=WIDTH, path_effects=rim, solid_capstyle="butt", zorder=5.2, label=name
                )
        if fresh:
            limits = tuple(np.reshape(result.attrs["box"], (2, 2)))
            ax.set(xlabel=symbol(result["angle"]), ylabel=symbol(result["speed"]))
        ax.set(xlim=limits[0], ylim=limits[1])
        beside = legend_extended(ax, list(lines.values())) if legend and lines else None
    return {"figure": root(ax), "lines": lines, "legend": beside, "provenance": provenance_of(result)}
