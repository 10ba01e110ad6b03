"""Figure 3.3: the gap map at lambda = 0.5 for three gaps."""

from __future__ import annotations

from typing import Any

from matplotlib.figure import Figure

from grazing.paper.gap_diagram import gap_diagram, gap_panel
from grazing.paper.run import Run
from grazing.plot.style import DOUBLE, panels

TITLE = "Gap map for λ = 0.5 and l = 0, 0.1, 0.5"
PARAMETERS = {"lambda": 0.5, "l": "0, 0.1, 0.5", "mu": "-0.05 to 0.35"}
CAPTION = "Limit sets of (2.6) against μ for three gaps; windows of Proposition 3.1 shaded and named."
SEE = "At l = 0 chaos separates the windows of 3 and 4; at l = 0.1 they overlap, at l = 0.5 all neighbours do."
LAM, GAPS, SPAN = 0.5, (0.0, 0.1, 0.5), (-0.05, 0.35)


def compute(run: Run) -> dict[str, Any]:
    """Return the three diagrams."""
    return {"panels": [gap_diagram(run, LAM, l, *SPAN) for l in GAPS]}


def draw(data: dict[str, Any]) -> Figure:
    """Draw the three diagrams below one another."""
    fig, axes = panels(DOUBLE, 176, len(data["panels"]), sharex=True)
    for ax, each in zip(axes, data["panels"], strict=True):
        gap_panel(ax, each)
        ax.label_outer()
    return fig
