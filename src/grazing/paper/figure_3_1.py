"""Figure 3.1: a period-3 orbit of the gap map."""

from __future__ import annotations

from typing import Any

from matplotlib.figure import Figure

from grazing.maps.gap import gap_map
from grazing.paper.drawing import note
from grazing.paper.run import Run
from grazing.paper.settle import settled
from grazing.plot.cobweb import cobweb
from grazing.plot.style import SINGLE, panels, styled
from grazing.theory.maximal import multiplier

TITLE = "The gap map and its orbit LLR"
PARAMETERS = {"lambda": 0.8, "l": 1, "mu": 0.5}
CAPTION = "Graph of the map (2.6) with its jump at x = 0, the diagonal, and the cycle on which a start settles."
SEE = "Two points on the linear side (L), one on the square-root side (R): the word LLR."


def compute(run: Run) -> dict[str, Any]:
    """Return the map and the cycle from a start."""
    P = gap_map(0.8, 0.5, 1.0)
    return {"map": P, "cycle": settled(P, (-0.5,)), "multiplier": multiplier(3, 0.8, 0.5, 1.0)}


def draw(data: dict[str, Any]) -> Figure:
    """Draw the cobweb with the points named."""
    fig, (ax,) = panels(SINGLE, 84)
    x = data["cycle"].points[:, 0]
    cobweb(data["map"], x, ax)
    with styled():
        ax.axvline(0.0, lw=0.4, color="#1a1a1a")
        for i, value in enumerate(x, start=1):
            letter = "L" if value < 0 else "R"
            ax.annotate(rf"$x_{i}$ ({letter})", (value, value), (6, -9), textcoords="offset points", zorder=6)
    said = "\n".join(rf"$x_{i} = {value:.10f}$" for i, value in enumerate(x, start=1))
    note(ax, f"{said}\nmultiplier ${data['multiplier']:.6f}$", 0.37, 0.14)
    return fig
