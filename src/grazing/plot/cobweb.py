"""Cobweb of an orbit of a one-dimensional map."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import ArrayLike

from grazing.maps.map import Map
from grazing.outcome import InputError
from grazing.plot.map_graph import graph_of, map_graph
from grazing.plot.style import INK, axes, period_colour, root, styled


def cobweb(P: Map, points: ArrayLike, ax: Axes | None = None, *, closed: bool = True) -> dict[str, Any]:
    """Draw the graph of a one-dimensional map, the diagonal and the steps of an orbit between them.

    Parameters
    ----------
    P : Map
        With one coordinate.
    points : array_like, shape (n,) or (n, 1)
        The orbit in the order of iteration, such as ``P.iterate(x, n)`` or the points of a cycle.
    ax : matplotlib Axes, optional
        Default: a new figure one column wide.
    closed : bool
        Whether the last point maps to the first one.

    Returns
    -------
    dict
        ``graph`` (list of lines), ``diagonal``, ``steps``, ``points``, ``figure``.

    Raises
    ------
    InputError
        For a map with more coordinates.
    """
    if P.dimension != 1:
        raise InputError(f"{P.name} has coordinates {', '.join(P.coordinates)}; a cobweb needs a map with one")
    x = np.asarray(points, dtype=np.float64).reshape(-1)
    low, high = float(x.min()), float(x.max())
    pad = 0.12 * max(high - low, 1e-12)
    low, high = low - pad, high + pad
    # the borders of a map with letters usually lie at 0: take both sides of it closely
    grid = np.union1d(np.linspace(low, high, 1200), np.array([-1e-12, 0.0]) if low < 0.0 < high else [low])
    path = np.append(x, x[0]) if closed else x
    corners = np.column_stack([np.repeat(path, 2)[:-1], np.repeat(path, 2)[1:]])
    name = P.coordinates[0]
    with styled():
        ax = axes(ax, height=80.0)
        (diagonal,) = ax.plot([low, high], [low, high], color=INK, lw=0.5, ls=(0, (4, 2)))
        graph = map_graph(graph_of(P, grid), ax, lw=1.4)["pieces"]
        colour = period_colour(x.size if closed else -1)
        (steps,) = ax.plot(corners[:, 0], corners[:, 1], color=colour, lw=0.9, zorder=4)
        (dots,) = ax.plot(x, x, "o", ms=4, color=colour, zorder=5)
        ax.set_xlim(low, high)
        ax.set_ylim(low, high)
        ax.set_aspect("equal")
        ax.set_xlabel(f"${name}_n$")
        ax.set_ylabel(f"${name}_{{n+1}}$")
    return {"figure": root(ax), "graph": graph, "diagonal": diagonal, "steps": steps, "points": dots}
