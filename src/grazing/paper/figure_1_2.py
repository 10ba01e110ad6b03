"""Figure 1.2: phase portrait of the passive oscillator."""

from __future__ import annotations

from typing import Any

from matplotlib.figure import Figure

from grazing.maps.stroboscopic import stroboscopic_map
from grazing.oscillator.trajectory import trajectory
from grazing.paper.drawing import note
from grazing.paper.run import Run
from grazing.paper.settle import settled
from grazing.plot.style import SINGLE, panels
from grazing.plot.trajectory import trajectory as draw_trajectory

TITLE = "Passive oscillator, phase portrait"
PARAMETERS = {"alpha": 3, "k": 1, "omega": 2.2, "t0": 0, "r": 0.8, "V": 0, "d": 0.12}
CAPTION = (
    "The orbit on which the oscillator with Newton's law (1.2) settles. Squares: states once per forcing period. "
    "Filled circle: the ball arrives at the wall; open circle: it leaves; the dashed line between them is the impact."
)
SEE = "The orbit closes after two forcing periods, with one impact, at low speed."


def portrait(run: Run, V: float) -> dict[str, Any]:
    """Return the cycle at d = 0.12 and the flight along it until it closes."""
    model = run.standard(V)
    cycle = settled(stroboscopic_map(model), (0.1, 0.0))
    return {"cycle": cycle, "flight": trajectory(model, cycle.points[0], until=cycle.period * model.period), "V": V}


def compute(run: Run) -> dict[str, Any]:
    """Return the settled cycle and its flight."""
    return portrait(run, 0.0)


def draw(data: dict[str, Any]) -> Figure:
    """Draw flight, impact and strobe states."""
    cycle, flight = data["cycle"], data["flight"]
    fig, (ax,) = panels(SINGLE, 66)
    draw_trajectory(flight, ax, strobe=cycle.points)
    before, after = float(flight["v_minus"].values[0]), float(flight["v_plus"].values[0])
    note(
        ax,
        f"period {cycle.period}, {flight.sizes['impact']} impact\n$v^- = {before:.4f}$\n$v^+ = {after:.4f}$",
        0.455,
        0.5,
        ha="center",
        va="center",
    )
    return fig
