"""Figure 2.1: the zero-time discontinuity map, computed for a low-velocity impact."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from grazing.maps.discontinuity import zdm_points
from grazing.oscillator.model import pinball
from grazing.oscillator.trajectory import trajectory
from grazing.paper.drawing import note
from grazing.paper.run import Run
from grazing.plot.style import SINGLE, panels, styled
from grazing.plot.zdm import zdm

TITLE = "The zero-time discontinuity map"
START = (0.03, -0.23)
PARAMETERS = {
    "alpha": 3,
    "k": 1,
    "omega": 2.1,
    "t0": 2.2,
    "r": 0.8,
    "V": 0.2,
    "d": 0.11,
    "u(0)": START[0],
    "v(0)": START[1],
}
CAPTION = (
    "The low-velocity impact of Figure 2.2 at u(0) = 0.03, computed: forward by δ to the wall, the reset, back "
    "by δ. U is "
    "vertical and V horizontal; the obstacle is the horizontal axis. Thin grey: the exact orbit before and after "
    "the impact."
)
SEE = "The map takes (U0, V0) to (U3, V3) in no time: V jumps by V + (1 + r)√(V0² − 2AU0), U by less."


def compute(run: Run) -> dict[str, Any]:
    """Return the four points and the exact orbit around them."""
    model = pinball(**{name: float(value) for name, value in PARAMETERS.items() if "(" not in name})
    four = zdm_points(model, START)
    orbit = trajectory(model, START, until=0.55, samples=2000)
    u, v, t = orbit["u"].values, orbit["v"].values, orbit["t"].values
    cut = int(np.flatnonzero((np.diff(t) <= 0.0) & (np.diff(v) > 0.0))[0]) + 1
    flow = [np.column_stack([u[:cut], v[:cut]]), np.column_stack([u[cut:], v[cut:]])]
    return {"points": four, "flow": flow, "hit": float(orbit["impact_time"].values[0]), "model": model}


def draw(data: dict[str, Any]) -> Figure:
    """Draw the four points and the flights that join them."""
    fig, (ax,) = panels(SINGLE, 76)
    zdm(data["points"], ax, flow=data["flow"])
    places = ((7, 2, "left"), (-2, -12, "center"), (-6, 7, "right"), (-7, -3, "right"))
    with styled():
        for i, (dx, dy, side) in enumerate(places):
            ax.annotate(
                rf"$(U_{i}, V_{i})$",
                data["points"].points[i, ::-1],
                (dx, dy),
                textcoords="offset points",
                ha=side,
                zorder=6,
            )
        for (i, j), text, (dx, dy) in (
            ((0, 1), r"$\delta$", (-12, -4)),
            ((1, 2), "$R$", (0, 5)),
            ((2, 3), r"$-\delta$", (8, -4)),
        ):
            middle = data["points"].points[[i, j], ::-1].mean(axis=0)
            ax.annotate(text, middle, (dx, dy), textcoords="offset points", ha="center", zorder=6)
        ax.set_ylim(-0.06, 0.075)
    note(ax, rf"$\delta = {data['points'].delta:.4f}$, $A = {data['points'].acceleration:.4f}$", 0.5, 0.97, ha="center")
    return fig
