"""Figure 1.6: bifurcation diagram of the active oscillator."""

from __future__ import annotations

from typing import Any

from grazing.paper.figure_1_3 import diagram, draw
from grazing.paper.run import Run

__all__ = ["CAPTION", "PARAMETERS", "SEE", "TITLE", "compute", "draw"]

TITLE = "Active oscillator, bifurcation diagram"
PARAMETERS = {"alpha": 3, "k": 1, "omega": 2.2, "t0": 0, "r": 0.8, "V": 0.4, "d": "0.05 to 0.16"}
CAPTION = (
    "As Figure 1.3, with the bumper: V = 0.4. Bars above are the exact windows of the orbits with one impact in "
    "N periods; where two bars lie over one another, both orbits are found from random starts."
)
SEE = "At the graze the attractor jumps to its full size at once; neighbouring windows N and N + 1 overlap."


def compute(run: Run) -> dict[str, Any]:
    """Return the diagram for V = 0.4."""
    return diagram(run, 0.4)
