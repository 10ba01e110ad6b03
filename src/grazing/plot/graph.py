"""The graph of a map along one coordinate, beside that of the map which comes near it, as in Figure 2.2."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from grazing.plot.drawn import inline
from grazing.plot.expected import choice, expect
from grazing.plot.map_graph import at_step, map_graph
from grazing.plot.provenance import provenance_of
from grazing.plot.style import INK, PERIODS, axes, plain, root, styled, unit_of
from grazing.studies.graph import Graph

#: How each map is drawn; the second is laid over the first.
LINES: tuple[dict[str, Any], ...] = (
    {"colour": INK, "lw": 1.3},
    {"colour": PERIODS[1], "lw": 1.5, "ls": (0, (4, 1.5))},
)


@inline
def graph(
    result: Any, ax: Axes | None = None, *, coordinate: str | None = None, legend: bool | None = None
) -> dict[str, Any]:
    """Draw the images of a row of states under one step of a map, or of two maps to be compared.

    Parameters
    ----------
    result : xarray.Dataset
        From :func:`grazing.graph`.
    ax : matplotlib Axes, optional
        Default: a new figure one column wide.
    coordinate : str, optional
        Which coordinate of the images is shown; default: the one that varies.
    legend : bool, optional
        Whether two maps are named; None for one in a figure of its own only.

    Returns
    -------
    dict
        ``graphs``, for the name of each map a list of lines, one for each run of equal letters, so that the jump at a
        graze stays a jump; ``legend`` or None, ``provenance``, ``figure``.

    Raises
    ------
    InputError
        For another kind of result, or a coordinate that it does not have.
    """
    _map, name = expect(result, "graph", {"letter": ("map", "<coordinate>"), "outcome": ("map", "<coordinate>")})
    known = [str(own).removeprefix("image_") for own in result.data_vars if str(own).startswith("image_")]
    shown = choice(name if coordinate is None else coordinate, "coordinate", known)
    result = result.sortby(name)
    starts = np.asarray(result[name].values, np.float64)
    images = np.array([result[f"image_{own}"].values for own in known], np.float64)  # (coordinate, map, n)
    names = [str(each) for each in result["map"].values]
    graphs: dict[str, list[Line2D]] = {}
    with styled():
        ax = axes(ax)
        for i, each in enumerate(names):
            letters = np.asarray(result["letter"].values[i], np.int64)
            drawn = Graph(starts, images[:, i].T, letters, name, tuple(known))
            graphs[each] = map_graph(drawn, ax, coordinate=shown, label=plain(each), **LINES[i % len(LINES)])["pieces"]
        for axis, own, of, step in ((ax.xaxis, name, name, "n"), (ax.yaxis, shown, f"image_{shown}", "n+1")):
            axis.set_label_text(at_step(str(result[of].attrs.get("symbol", own)), step) + unit_of(result[of]))
        beside = ax.legend(loc="best") if legend and len(names) > 1 else None
    return {"figure": root(ax), "graphs": graphs, "legend": beside, "provenance": provenance_of(result)}
