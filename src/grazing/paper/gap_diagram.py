"""What the diagrams of the gap map have in common."""

from __future__ import annotations

from typing import Any

from matplotlib.axes import Axes

from grazing.maps.gap import gap_map
from grazing.paper.drawing import mark, note, panel
from grazing.paper.run import Run
from grazing.theory.windows import stability_interval


def gap_windows(lam: float, l: float, longest: int = 60) -> dict[int, tuple[float, float]]:
    """Return the windows of Proposition 3.1 for N = 1 to ``longest``."""
    return {N: tuple(stability_interval(N, lam, l)) for N in range(1, longest + 1)}  # type: ignore[misc]


def gap_diagram(
    run: Run,
    lam: float,
    l: float,
    low: float,
    high: float,
    *,
    transient: int = 3000,
    keep: int = 96,
    values: float = 1.0,
) -> dict[str, Any]:
    """Return the orbit diagram of (2.6) in mu with the windows of the theory."""
    result = run.diagram(gap_map(lam, low, l), "mu", low, high, transient, keep, values)
    return {"diagram": result, "windows": gap_windows(lam, l), "lam": lam, "l": l}


def gap_panel(
    ax: Axes, data: dict[str, Any], size: float = 1.1, longest: int = 24, low: bool = False
) -> dict[str, Any]:
    """Draw one diagram of (2.6): windows named, the graze mu = 0 marked."""
    drawn = panel(ax, data["diagram"], data["windows"], "x", size, longest)
    ax.set(xlabel=r"$\mu$", ylabel="$x_n$")
    if float(data["diagram"]["mu"].min()) < 0.0:
        drawn["graze"] = mark(ax, 0.0, r"graze, $\mu = 0$", height=0.12, side="right")
    grey = ("; " if low else "\n") + "grey: no period found" if 0 in drawn["points"] else ""
    drawn["note"] = note(ax, rf"$\lambda = {data['lam']:g}$, $l = {data['l']:g}${grey}", 0.012, 0.02 if low else 0.96)
    return drawn
