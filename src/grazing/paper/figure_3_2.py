"""Figure 3.2: bifurcation diagram of the gap map, to be set beside Figure 1.6."""

from __future__ import annotations

from typing import Any

from matplotlib.figure import Figure

from grazing.paper.gap_diagram import gap_diagram, gap_panel
from grazing.paper.run import Run
from grazing.plot.style import DOUBLE, panels

TITLE = "Gap map, bifurcation diagram for λ = 0.34, l = 0.21"
PARAMETERS = {"lambda": 0.34, "l": 0.21, "mu": "-0.1 to 0.6"}
CAPTION = "Limit sets of the map (2.6) against μ, from random starts; windows of Proposition 3.1 shaded and named."
SEE = "Only maximal orbits: a fixed point left of the graze, a jump at it, then overlapping windows of falling period."


def compute(run: Run) -> dict[str, Any]:
    """Return the diagram."""
    return gap_diagram(run, 0.34, 0.21, -0.1, 0.6)


def draw(data: dict[str, Any]) -> Figure:
    """Draw the diagram."""
    fig, (ax,) = panels(DOUBLE, 82)
    gap_panel(ax, data)
    return fig
