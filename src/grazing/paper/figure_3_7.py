"""Figure 3.7: close-up of the gap map near the graze, lambda = 0.9, l = 0.8."""

from __future__ import annotations

from typing import Any

from matplotlib.figure import Figure

from grazing.paper.gap_diagram import gap_diagram, gap_panel
from grazing.paper.run import Run
from grazing.plot.style import DOUBLE, GRAZE, INK, PERIODS, panels, styled
from grazing.theory.asymptotics import width_ratio

TITLE = "Close-up near the graze, λ = 0.9, l = 0.8"
PARAMETERS = {"lambda": 0.9, "l": 0.8, "mu": "0.002 to 0.06"}
CAPTION = (
    "Limit sets of (2.6) for small μ; windows of Proposition 3.1 shaded and named. Right: the factor by which the "
    "windows shrink from N to N + 1."
)
SEE = "Windows of ever higher period, each narrower than the one to its right by a factor that tends slowly to λ."


def compute(run: Run) -> dict[str, Any]:
    """Return the diagram and the width ratios of neighbouring windows."""
    data = gap_diagram(run, 0.9, 0.8, 0.002, 0.06, transient=6000, keep=160)
    return {**data, "ratios": {N: width_ratio(N, 0.9, 0.8) for N in range(6, 121)}}


def draw(data: dict[str, Any]) -> Figure:
    """Draw the diagram and the shrink factors."""
    fig, (ax, shrink) = panels(DOUBLE, 92, 1, 2, width_ratios=(3.4, 1.0))
    gap_panel(ax, data, size=0.8, longest=80, low=True)
    with styled():
        ax.axhline(0.0, color=INK, lw=0.4, zorder=1)
        N, ratio = list(data["ratios"]), list(data["ratios"].values())
        shrink.plot(N, ratio, "o", ms=2.6, color=PERIODS[2], mew=0)
        shrink.axhline(data["lam"], color=GRAZE, lw=0.9, ls=(0, (5, 2)))
        shrink.annotate(
            rf"$\lambda = {data['lam']}$",
            (N[-1], data["lam"]),
            (0, 3),
            textcoords="offset points",
            ha="right",
            color=GRAZE,
        )
        shrink.set_xlabel("$N$")
        shrink.set_title(r"width of $\Omega_{N+1}$ / width of $\Omega_N$")
    return fig
