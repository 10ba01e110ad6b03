"""Figure 3.6: edges of the windows of periods 3, 4 and 5 against the gap, lambda = 0.9."""

from __future__ import annotations

from typing import Any

from grazing.paper.figure_3_4 import draw, edges
from grazing.paper.run import Run

__all__ = ["CAPTION", "PARAMETERS", "SEE", "TITLE", "compute", "draw"]

TITLE = "Edges of the windows 3, 4 and 5 for λ = 0.9"
PARAMETERS = {"lambda": 0.9, "N": "3, 4, 5", "l": "0 to 1"}
CAPTION = "Period doubling (dashed) and border collision (solid) against l; a window is the band between the two."
SEE = "Windows 4 and 5 appear where their two lines cross; 3 and 4 overlap only from l = 0.627 on."


def compute(run: Run) -> dict[str, Any]:
    """Return the edges for N = 3, 4 and 5."""
    return edges(0.9, (3, 4, 5), 1.0)
