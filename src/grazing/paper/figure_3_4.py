"""Figure 3.4: edges of the windows of periods 3 and 4 against the gap, lambda = 0.5."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from grazing.paper.drawing import mark
from grazing.paper.run import Run
from grazing.plot.style import INK, SINGLE, panels, period_colour, styled
from grazing.theory.edges import mu_bc, mu_pd
from grazing.theory.thresholds import l_coexist, l_exist

TITLE = "Edges of the windows 3 and 4 for λ = 0.5"
PARAMETERS = {"lambda": 0.5, "N": "3, 4", "l": "0 to 0.5"}
CAPTION = "Period doubling (dashed) and border collision (solid) against l; a window is the band between the two."
SEE = "The two bands begin to overlap where the dashed line of 3 meets the solid line of 4."
LAM, PERIODS_, LAST = 0.5, (3, 4), 0.5


def edges(lam: float, periods: tuple[int, ...], last: float) -> dict[str, Any]:
    """Return both edges on a grid of gaps, and the gaps at which windows appear and at which neighbours meet."""
    l = np.linspace(0.0, last, 401)
    return {
        "lam": lam,
        "l": l,
        "edges": {N: (np.asarray(mu_pd(N, lam, l)), np.asarray(mu_bc(N, lam, l))) for N in periods},
        "appear": {N: float(l_exist(N, lam)) for N in periods},
        "meet": {(N, N + 1): float(l_coexist(N, lam)) for N in periods[:-1]},
    }


def compute(run: Run) -> dict[str, Any]:
    """Return the edges for N = 3 and 4."""
    return edges(LAM, PERIODS_, LAST)


def curves(ax: Axes, data: dict[str, Any]) -> None:
    """Draw the edges, the bands between them and the thresholds."""
    with styled():
        for N, (pd, bc) in data["edges"].items():
            colour = period_colour(N)
            ax.fill_between(data["l"], pd, bc, where=pd < bc, color=colour, alpha=0.16, lw=0)
            ax.plot(data["l"], pd, color=colour, lw=1.2, ls=(0, (4, 1.6)))
            ax.plot(data["l"], bc, color=colour, lw=1.2)
        ax.set_xlim(data["l"][0], data["l"][-1])
        ax.set_ylim(bottom=0.0)
        ax.set(xlabel="gap, $l$", ylabel=r"$\mu$")
        name_curves(ax, data)
    for N, l in data["appear"].items():
        if l > 0.0:
            lone = float(mu_pd(N, data["lam"], l))
            mark(
                ax,
                l,
                f"{N} appears\n$l = {l:.10f}$".rstrip("0"),
                side="right",
                height=1.6 - 0.16 * N,
                top=1.6 - 0.16 * N,  # below the names of smaller periods
                colour=period_colour(N),
            )
            ax.plot(l, lone, "o", ms=3, color=period_colour(N), zorder=6)
    for (N, M), l in data["meet"].items():
        if 0.0 < l < data["l"][-1]:
            late = l > 0.7 * data["l"][-1]
            mark(
                ax,
                l,
                f"{N} and {M} meet\n$l = {l:.8f}$",
                side="left" if l > 0.4 * data["l"][-1] else "right",
                height=0.14 if late else 0.98,
                colour=INK,
            )
            ax.plot(l, float(mu_pd(N, data["lam"], l)), "o", ms=3.4, mfc="white", mec=INK, zorder=6)


def name_curves(ax: Axes, data: dict[str, Any]) -> None:
    """Write the name of each curve at its right end, names kept apart."""
    ends = sorted(
        (value[-1], rf"$\mu_{{{kind},{N}}}$", period_colour(N))
        for N, pair in data["edges"].items()
        for kind, value in zip(("PD", "BC"), pair, strict=True)
    )
    low, high = ax.get_ylim()
    place = low
    for end, name, colour in ends:
        place = max(end, place + 0.05 * (high - low))
        ax.annotate(
            name,
            (data["l"][-1], place),
            (4, 0),
            textcoords="offset points",
            color=colour,
            va="center",
            annotation_clip=False,
        )


def draw(data: dict[str, Any]) -> Figure:
    """Draw the edges against l."""
    fig, (ax,) = panels(SINGLE * 1.3, 80)
    curves(ax, data)
    return fig
