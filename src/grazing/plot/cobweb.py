"""Cobweb of an orbit of a one-dimensional map."""

from __future__ import annotations

from math import isfinite
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import ArrayLike, NDArray

from grazing.maps.map import Map
from grazing.outcome import InputError
from grazing.plot.drawn import inline
from grazing.plot.expected import expect
from grazing.plot.map_graph import Graph, graph_of, map_graph
from grazing.plot.options import passed_on
from grazing.plot.provenance import provenance_of
from grazing.plot.style import INK, axes, mathematics, period_colour, root, styled
from grazing.studies.cobweb import places_of


@inline
def cobweb(
    P: Any, points: ArrayLike | None = None, ax: Axes | None = None, *, closed: bool | None = None
) -> dict[str, Any]:
    """Draw the graph of a one-dimensional map, the diagonal and the steps of an orbit between them.

    Parameters
    ----------
    P : Map or xarray.Dataset
        A map with one coordinate; or a result that has the graph and the orbit, such as of ``grazing cobweb``.
    points : array_like, shape (n,) or (n, 1), optional
        With a map: the orbit in the order of iteration, such as ``P.iterate(x, n)`` or the points of a cycle.
    ax : matplotlib Axes, optional
        Default: a new figure one column wide.
    closed : bool, optional
        Whether the last point maps to the first one. Default: it does for points, not for a result.

    Returns
    -------
    dict
        ``graph`` (list of lines), ``diagonal``, ``steps``, ``points``, ``provenance``, ``figure``.

    Raises
    ------
    InputError
        For a map with more coordinates, or without points; for another kind of result.
    """
    graph, x = _drawn(P, points) if isinstance(P, Map) else _stored(P, points)
    closed = isinstance(P, Map) if closed is None else closed
    low, high = _ends(graph.starts)
    path = np.append(x, x[0]) if closed else x
    corners = np.column_stack([np.repeat(path, 2)[:-1], np.repeat(path, 2)[1:]])
    name = graph.coordinate
    with styled():
        ax = axes(ax, height=80.0)
        (diagonal,) = ax.plot([low, high], [low, high], color=INK, lw=0.5, ls=(0, (4, 2)))
        pieces = map_graph(graph, ax, lw=1.4)["pieces"]
        colour = period_colour(x.size if closed else -1)
        (steps,) = ax.plot(corners[:, 0], corners[:, 1], color=colour, lw=0.9, zorder=4)
        (dots,) = ax.plot(x, x, "o", ms=4, color=colour, zorder=5)
        ax.set(xlim=(low, high), ylim=(low, high))
        ax.set_aspect("equal")
        ax.set(xlabel=mathematics(f"{name}_n", f"{name}, n"), ylabel=mathematics(f"{name}_{{n+1}}", f"{name}, n+1"))
    return {
        "figure": root(ax),
        "graph": pieces,
        "diagonal": diagonal,
        "steps": steps,
        "points": dots,
        "provenance": {} if isinstance(P, Map) else provenance_of(P),
    }


def _drawn(P: Map, points: ArrayLike | None) -> tuple[Graph, NDArray[np.float64]]:
    """Return the graph of a map around given points, and the points."""
    if P.dimension != 1:
        raise InputError(f"{P.name} has coordinates {', '.join(P.coordinates)}; a cobweb needs a map with one")
    with passed_on("the points of an orbit are no numbers"):
        x = np.asarray([] if points is None else points, dtype=np.float64).reshape(-1)
    if not x.size:
        raise InputError("a cobweb of a map needs points; give an orbit, such as P.iterate(x, n)")
    starts = places_of(x)
    _ends(starts)
    return graph_of(P, starts), x


def _ends(starts: NDArray[np.float64]) -> tuple[float, float]:
    """Return the ends of the graph, or refuse an orbit that no axis can hold."""
    low, high = float(starts[0]), float(starts[-1])
    if not isfinite(high - low):
        raise InputError("the points of the orbit cannot be drawn: they are too large")
    return low, high


def _stored(result: Any, points: ArrayLike | None) -> tuple[Graph, NDArray[np.float64]]:
    """Return the graph and the orbit that a result has."""
    expect(result, "cobweb", {"image": ("place",), "image_letter": ("place",)})
    if points is not None:
        raise InputError("points and a result are both given; the result has its own orbit")
    name = next(str(name) for name, item in result.data_vars.items() if item.dims == ("n",))
    starts = np.asarray(result["place"].values, np.float64)
    images = np.asarray(result["image"].values, np.float64)[:, None]
    graph = Graph(starts, images, np.asarray(result["image_letter"].values), name, (name,))
    return graph, np.asarray(result[name].values, np.float64)
