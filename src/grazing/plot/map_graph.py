"""Graph of a map along one coordinate, broken where the letter changes."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from grazing.outcome import InputError
from grazing.plot.drawn import inline
from grazing.plot.expected import choice
from grazing.plot.options import passed_on
from grazing.plot.style import INK, axes, mathematics, root, styled
from grazing.studies.graph import Graph as Graph
from grazing.studies.graph import graph_of as graph_of


@inline
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
    if not isinstance(graph, Graph):
        raise InputError(f"plot.map_graph cannot draw a {type(graph).__name__}; allowed is what plot.graph_of returns")
    seen = choice(graph.coordinate if coordinate is None else coordinate, "coordinate", graph.coordinates)
    column = graph.images[:, graph.coordinates.index(seen)]
    ends = np.flatnonzero(np.diff(graph.letters)) + 1
    legend = line.pop("label", None)
    pieces: list[Line2D] = []
    with styled(), passed_on("a line of the graph"):
        ax = axes(ax)
        for x, y in zip(np.split(graph.starts, ends), np.split(column, ends), strict=True):
            pieces += ax.plot(x, y, color=colour, label=None if pieces else legend, **line)
            if x.size == 1:  # a line of one point is unseen
                pieces[-1].set(marker="o", markersize=pieces[-1].get_linewidth(), markeredgewidth=0.0)
        ax.set(xlabel=at_step(graph.coordinate, "n"), ylabel=at_step(seen, "n+1"))
    return {"pieces": pieces, "figure": root(ax)}


def at_step(symbol: str, step: str) -> str:
    r"""Return the symbol of a coordinate with the number of a step, in mathematics.

    Examples
    --------
    >>> from grazing.plot.map_graph import at_step
    >>> at_step("u", "n+1"), at_step("v_plus", "n")
    ('$u_{n+1}$', '$v_{\\mathrm{plus},n}$')
    """
    base, _, index = (f"({symbol})" if "-" in symbol else symbol).partition("_")
    formula = f"{base}_{{\\mathrm{{{index}}},{step}}}" if index else f"{base}_{{{step}}}"
    return mathematics(formula, f"{symbol}, {step}")
