"""Figure 1.6 beside Figure 3.2: the flow, its normal form and the printed parameters on one axis of mu."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from grazing.maps.gap import gap_map
from grazing.maps.stroboscopic import stroboscopic_map
from grazing.paper.drawing import note, panel
from grazing.paper.gap_diagram import gap_windows
from grazing.paper.run import Run
from grazing.plot.style import DOUBLE, panels
from grazing.studies.orbit_diagram import orbit_diagram

TITLE = "Figures 1.6 and 3.2 on one axis"
CAPTION = (
    "Above, the oscillator of Figure 1.6 with d turned into the μ of its normal form; in the middle, the gap map "
    "with the λ and l of that normal form; below, the gap map of Figure 3.2. The axis of μ is logarithmic, so that "
    "windows of all periods have about the same width; the graze is at its left end, infinitely far away."
)
SEE = (
    "The first two rows of windows agree better and better towards the graze. The printed l = 0.21 belongs to a weaker "
    "bumper: its windows are shifted."
)
LOW, HIGH = 1e-5, 0.6


def compute(run: Run) -> dict[str, Any]:
    """Return three diagrams on the same values of mu."""
    nf = run.normal_form(0.4)
    mu = np.logspace(np.log10(LOW), np.log10(HIGH), max(60, run.size.values // 2))
    count = max(6, run.size.starts)
    d = np.array([nf.parameter(float(m)) for m in mu])
    flow = (
        orbit_diagram(
            stroboscopic_map(nf.model),
            "d",
            d,
            starts=count,
            transient=200,
            keep=40,
            arithmetic="strict",
            progress=run.watch,
        )
        .assign_coords(d=mu)
        .rename({"d": "mu"})
    )
    maps = [
        orbit_diagram(
            gap_map(lam, LOW, l),
            "mu",
            mu,
            starts=count,
            transient=2000,
            keep=64,
            arithmetic="strict",
            progress=run.watch,
        )
        for lam, l in ((nf.lam, nf.l), (0.34, 0.21))
    ]
    exact = {N: (float(nf.mu(high)), float(nf.mu(low))) for N, (low, high) in run.windows(0.4).items()}
    return {
        "diagrams": [flow, *maps],
        "windows": [exact, gap_windows(nf.lam, nf.l), gap_windows(0.34, 0.21)],
        "names": [
            "oscillator, $V = 0.4$",
            rf"gap map, $\lambda = {nf.lam:.4f}$, $l = {nf.l:.4f}$ (normal form)",
            r"gap map, $\lambda = 0.34$, $l = 0.21$ (as printed)",
        ],
    }


def draw(data: dict[str, Any]) -> Figure:
    """Draw the three diagrams below one another."""
    fig, axes = panels(DOUBLE, 170, 3, sharex=True)
    for ax, diagram, edges, name in zip(axes, data["diagrams"], data["windows"], data["names"], strict=True):
        ax.set_xscale("log")
        panel(ax, diagram, edges, "u" if "u" in diagram else "x")
        ax.set(ylabel="$u_n$" if "u" in diagram else "$x_n$", xlabel=r"$\mu$")
        note(ax, name, 0.012, 0.95 if "u" in diagram else 0.05)
        ax.label_outer()
    return fig
