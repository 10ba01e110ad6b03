"""Phase portrait of a trajectory."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from grazing.plot.drawn import inline
from grazing.plot.expected import expect
from grazing.plot.style import GRAZE, INK, WALL, axes, quantity, root, styled


@inline
def trajectory(result: Any, ax: Axes | None = None, *, colour: str = INK, strobe: Any = None) -> dict[str, Any]:
    """Draw a trajectory in the (u, v) plane: flights solid, impacts dashed along the wall.

    Parameters
    ----------
    result : xarray.Dataset
        From :func:`grazing.trajectory`.
    ax : matplotlib Axes, optional
        Default: a new figure one column wide.
    colour : str
        Of the flights.
    strobe : array_like, shape (n, 2), optional
        States (u, v) at the section, drawn as circles.

    Returns
    -------
    dict
        ``flights`` (one line with a break at each impact), ``impacts`` (one line each), ``strobe``, ``wall``,
        ``figure``.
    """
    expect(result, "trajectory", {"u": ("t",), "v": ("t",)})
    with styled():
        ax = axes(ax)
        sigma = wall_of(result)
        u, v = np.asarray(result["u"].values), np.asarray(result["v"].values)
        # an impact is a time that occurs twice, before and after it, with two velocities
        cut = np.flatnonzero((np.diff(result["t"].values) <= 0.0) & (np.abs(np.diff(v)) > 1e-9 * np.abs(v).max())) + 1
        (flights,) = ax.plot(np.insert(u, cut, np.nan), np.insert(v, cut, np.nan), color=colour, lw=1.1, zorder=3)
        impacts: list[Line2D] = []
        for before, after in zip(result["v_minus"].values, result["v_plus"].values, strict=True):
            impacts += ax.plot([sigma, sigma], [before, after], color=GRAZE, lw=1.0, ls=(0, (3, 1.5)), zorder=4)
            ax.plot(sigma, before, "o", ms=3.2, color=GRAZE, zorder=5)
            ax.plot(sigma, after, "o", ms=3.2, mfc="white", mec=GRAZE, mew=0.8, zorder=5)
        dots = None
        if strobe is not None:
            points = np.atleast_2d(strobe)
            (dots,) = ax.plot(points[:, 0], points[:, 1], "s", ms=3.6, mfc="white", mec=colour, mew=0.9, zorder=6)
        reach = max(float(u.max()) - sigma, 1e-12)
        low, high = float(min(v.min(), 0.0)), float(max(v.max(), 0.0))
        wall = ax.axvspan(sigma - 0.08 * reach, sigma, color=WALL, lw=0, zorder=0)
        ax.axhline(0.0, color=INK, lw=0.4, zorder=1)
        ax.set_xlim(sigma - 0.08 * reach, sigma + 1.08 * reach)
        ax.set_ylim(low - 0.08 * (high - low), high + 0.08 * (high - low))
        ax.set_xlabel(quantity(result["u"]))
        ax.set_ylabel(quantity(result["v"]))
    return {"figure": root(ax), "flights": flights, "impacts": impacts, "strobe": dots, "wall": wall}


def wall_of(result: Any) -> float:
    """Return the position of the wall of a trajectory, in its own units."""
    return float(result["wall"]) if "wall" in result else float(result.attrs.get("parameter_sigma", 0.0))
