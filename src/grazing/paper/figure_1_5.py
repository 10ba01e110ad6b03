"""Figure 1.5: phase portrait of the active oscillator."""

from __future__ import annotations

from typing import Any

from grazing.paper.figure_1_2 import draw, portrait
from grazing.paper.run import Run

__all__ = ["CAPTION", "PARAMETERS", "SEE", "TITLE", "compute", "draw"]

TITLE = "Active oscillator, phase portrait"
PARAMETERS = {"alpha": 3, "k": 1, "omega": 2.2, "t0": 0, "r": 0.8, "V": 0.4, "d": 0.12}
CAPTION = (
    "The orbit on which the oscillator with the bumper's law (1.3) settles. Squares: states once per forcing period. "
    "Filled circle: the ball arrives at the wall; open circle: it leaves; the dashed line between them is the impact."
)
SEE = "The orbit closes after three forcing periods, with one impact; the ball leaves the bumper faster than it came."


def compute(run: Run) -> dict[str, Any]:
    """Return the settled cycle and its flight."""
    return portrait(run, 0.4)
