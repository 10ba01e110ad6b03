"""Figure 3.5: the gap map at lambda = 0.9 for three gaps."""

from __future__ import annotations

from typing import Any

from grazing.paper.figure_3_3 import draw
from grazing.paper.gap_diagram import gap_diagram
from grazing.paper.run import Run

__all__ = ["CAPTION", "GAPS", "LAM", "PARAMETERS", "SEE", "SPAN", "TITLE", "compute", "draw"]

TITLE = "Gap map for λ = 0.9 and l = 0, 0.4, 0.8"
PARAMETERS = {"lambda": 0.9, "l": "0, 0.4, 0.8", "mu": "-0.05 to 0.6"}
CAPTION = "Limit sets of (2.6) against μ for three gaps; windows of Proposition 3.1 shaded and named."
SEE = (
    "At l = 0 chaos up to the window of 3, in three bands just below it (μ > 0.172); with a gap many windows, apart in "
    "the middle of the diagram and overlapping again for very small μ."
)
LAM, GAPS, SPAN = 0.9, (0.0, 0.4, 0.8), (-0.05, 0.6)


def compute(run: Run) -> dict[str, Any]:
    """Return the three diagrams."""
    return {"panels": [gap_diagram(run, LAM, l, *SPAN) for l in GAPS]}
