"""Graph of a map along one coordinate, broken where the letter changes."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from numpy.typing import ArrayLike, NDArray

from grazing.maps.map import Map
from grazing.plot.style import INK, axes, root, styled


class Graph(NamedTuple):
    """Starts along one coordinate, their images, shape (n, dim), and letters; made by :func:`graph_of`."""

    starts: NDArray[np.float64]
    images: NDArray[np.float64]
    letters: NDArray[np.int64]
    coordinate: str
    coordinates: tuple[str, ...]


def graph_of(P: Map, values: ArrayLike, coordinate: str | None = None, **fixed: float) -> Graph:
    """Apply a map once to a row of starts.

    Parameters
    ----------
    P : Map
    values : array_like, shape (n,)
        Of the coordinate that varies.
    coordinate : str, optional
        Default: the first one.
    **fixed : float
        The other coordinates.

    Returns
    -------
    Graph

    Examples
    --------
    >>> import grazing as gz
    >>> from grazing.plot.map_graph import graph_of
    >>> graph_of(gz.gap_map(0.8, 0.5, 1.0), [-1.0, 0.25]).images[:, 0].round(6).tolist()
    [-0.3, -1.0]
    """
    names = tuple(P.coordinates)
    name = coordinate or names[0]
    x = np.asarray(values, dtype=np.float64)
    lanes = np.array([x if own == name else np.full_like(x, fixed[own]) for own in names])
    points, letters, _outcomes = P.run(lanes.copy(), 0, 1)
    return Graph(x, points[0].T.copy(), letters[0], name, names)


def map_graph(
    graph: Graph, ax: Axes | None = None, *, coordinate: str | None = None, colour: str = INK, **line: Any
) -> dict[str, Any]:
    """Draw the graph of a map: one line for each run of equal letters, so that a jump stays a jump.

    Parameters
    ----------
    graph : Graph
        From :func:`graph_of`.
    ax : matplotlib Axes, optional
        Default: a new figure one column wide.
    coordinate : str, optional
        Which coordinate of the image is shown; default: the one that varies.
    colour : str
    **line
        Passed to ``Axes.plot``, such as ``ls="--"``; ``label`` goes to the first piece only.

    Returns
    -------
    dict
        ``pieces``, a list of lines, and ``figure``.
    """
    shown = coordinate or graph.coordinate
    column = graph.images[:, graph.coordinates.index(shown)]
    ends = np.flatnonzero(np.diff(graph.letters)) + 1
    legend = line.pop("label", None)
    pieces: list[Line2D] = []
    with styled():
        ax = axes(ax)
        for x, y in zip(np.split(graph.starts, ends), np.split(column, ends), strict=True):
            pieces += ax.plot(x, y, color=colour, label=None if pieces else legend, **line)
        ax.set_xlabel(f"${graph.coordinate}_n$")
        ax.set_ylabel(f"${shown}_{{n+1}}$")
    return {"pieces": pieces, "figure": root(ax)}
