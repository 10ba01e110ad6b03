"""Figure 1.3: bifurcation diagram of the passive oscillator."""

from __future__ import annotations

from typing import Any

from matplotlib.figure import Figure

from grazing.maps.stroboscopic import stroboscopic_map
from grazing.paper.drawing import mark, note, panel
from grazing.paper.run import Run
from grazing.plot.style import DOUBLE, panels

TITLE = "Passive oscillator, bifurcation diagram"
PARAMETERS = {"alpha": 3, "k": 1, "omega": 2.2, "t0": 0, "r": 0.8, "V": 0, "d": "0.05 to 0.16"}
CAPTION = (
    "Position once per forcing period after a transient, from random starts, against d. Colours name the period; bars "
    "above are the exact windows of the orbits with one impact in N periods."
)
SEE = (
    "Right of the graze the ball never hits: period 1. Left of it the attractor grows from nothing like a square root. "
    "The windows of N = 3, 4, 5, … lie apart with chaos between them; those of 1 and 2, and barely 2 and 3, overlap."
)

#: The span of the close-up beside the diagram.
CLOSE = (0.1225, 0.1315)


def diagram(run: Run, V: float) -> dict[str, Any]:
    """Return the orbit diagram in d, the exact windows and the graze."""
    P = stroboscopic_map(run.standard(V))
    # without the bumper orbits are caught late: chaotic transients
    transient, starts = (1000, 0.75) if V > 0.0 else (1500, 0.5)
    return {
        "diagram": run.diagram(P, "d", 0.05, 0.16, transient, 48, 0.8, starts),
        "close": run.diagram(P, "d", *CLOSE, transient, 48, 0.4, starts),
        "windows": run.windows(V),
        "graze": run.normal_form(V).graze,
        "V": V,
    }


def compute(run: Run) -> dict[str, Any]:
    """Return the diagram for V = 0."""
    return diagram(run, 0.0)


def draw(data: dict[str, Any]) -> Figure:
    """Draw the diagram with its windows and the graze."""
    fig, (ax, near) = panels(DOUBLE, 82, 1, 2, width_ratios=(1.7, 1.0))
    for each, name in ((ax, "diagram"), (near, "close")):
        drawn = panel(each, data[name], data["windows"], "u")
        each.set(xlabel="constant part of the forcing, $d$", ylabel="position at the strobe, $u_n$")
        if each is ax:
            mark(each, data["graze"], f"graze, $d = k^2a$\n$= {data['graze']:.8f}$", side="right", height=0.99)
        else:
            mark(each, data["graze"], "graze", side="left", height=0.99)
        if 0 in drawn["points"] and each is ax:
            note(each, "grey: no period found", 0.985, 0.03)
    near.set_ylabel("")
    near.locator_params(axis="x", nbins=4)
    return fig
