"""What the figures of the paper have in common: panels, the graze, notes beside the axes."""

from __future__ import annotations

from typing import Any

from matplotlib.axes import Axes

from grazing.plot.orbit_diagram import orbit_diagram
from grazing.plot.style import GRAZE, INK, styled
from grazing.plot.windows import windows


def mark(
    ax: Axes, x: float, text: str, *, height: float = 0.97, side: str = "left", colour: str = GRAZE, top: float = 1.0
) -> dict[str, Any]:
    """Mark a value of the horizontal axis with a dashed line, up to a fraction of the height, and a name beside it."""
    with styled():
        line = ax.axvline(x, ymax=top, color=colour, lw=0.9, ls=(0, (5, 2)), zorder=5)
        text_artist = ax.annotate(
            text,
            (x, height),
            (3 if side == "right" else -3, 0),
            xycoords=ax.get_xaxis_transform(),
            textcoords="offset points",
            color=colour,
            ha="left" if side == "right" else "right",
            va="top",
            fontsize=7.5,
            zorder=6,
            bbox={"facecolor": "white", "alpha": 0.75, "lw": 0, "pad": 0.6},
        )
    return {"line": line, "text": text_artist}


def note(ax: Axes, text: str, x: float = 0.02, y: float = 0.97, **changes: Any) -> Any:
    """Write a note in the axes, at a place given in fractions of them."""
    with styled():
        look = {
            "ha": "left" if x < 0.5 else "right",
            "va": "top" if y > 0.5 else "bottom",
            "fontsize": 7.5,
            "color": INK,
        }
        box = {"facecolor": "white", "alpha": 0.8, "lw": 0, "pad": 1.0}
        return ax.text(x, y, text, transform=ax.transAxes, bbox=box, zorder=7, **{**look, **changes})


def panel(
    ax: Axes, result: Any, edges: dict[int, tuple[float, float]], coordinate: str, size: float = 1.1, longest: int = 24
) -> dict[str, Any]:
    """Draw an orbit diagram with its windows shaded and named."""
    drawn = orbit_diagram(result, ax, coordinate, size=size, longest=longest)
    return {**drawn, "windows": windows(edges, ax)}
