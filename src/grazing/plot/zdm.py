"""The zero-time discontinuity map in phase space, as in Figure 2.1."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from grazing.maps.discontinuity import ZeroTime
from grazing.outcome import InputError, shown
from grazing.plot.drawn import inline
from grazing.plot.style import GRAZE, INK, PERIODS, WALL, axes, root, styled

NAMES = ("U_0", "U_1", "U_2", "U_3")


@inline
def zdm(points: Any, ax: Axes | None = None, *, sigma: float = 0.0, flow: Any = None) -> dict[str, Any]:
    """Draw the four points of the zero-time map with U vertical and V horizontal, and the flights that join them.

    Parameters
    ----------
    points : ZeroTime
        From :func:`grazing.zdm_points`.
    ax : matplotlib Axes, optional
        Default: a new figure one column wide.
    sigma : float
        Position of the wall.
    flow : list of array_like, shape (n, 2), optional
        Pieces (u, v) of the exact flow, drawn thin behind the flights of constant acceleration.

    Returns
    -------
    dict
        ``points`` (line with the four markers), ``fall``, ``reset``, ``back``, ``wall``, ``flow``, ``figure``.
    """
    if not isinstance(points, ZeroTime):
        raise InputError(f"plot.zdm cannot draw a {type(points).__name__}; allowed is what gz.zdm_points returns")
    pieces = _checked_flow(flow)
    U, V = points.points[:, 0], points.points[:, 1]
    A = points.acceleration

    def flight(i: int, j: int) -> tuple[Any, Any]:
        """At constant acceleration A the path is U = U_i + (V^2 - V_i^2)/(2 A)."""
        v = np.linspace(V[i], V[j], 80)
        return v, (U[i] + (v * v - V[i] ** 2) / (2.0 * A) if A != 0.0 else np.linspace(U[i], U[j], 80))

    with styled():
        ax = axes(ax, height=70.0)
        behind = [ax.plot(p[:, 1], p[:, 0], color="#9a9a9a", lw=0.8, zorder=2)[0] for p in pieces]
        (fall,) = ax.plot(*flight(0, 1), color=PERIODS[2], lw=1.4, zorder=3)
        (reset,) = ax.plot(V[1:3], U[1:3], color=GRAZE, lw=1.2, ls=(0, (3, 1.5)), zorder=3)
        (back,) = ax.plot(*flight(2, 3), color=PERIODS[1], lw=1.6, ls=(0, (6, 1.5)), zorder=3)
        for line, colour in ((fall, PERIODS[2]), (back, PERIODS[1])):
            x, y = np.asarray(line.get_xdata()), np.asarray(line.get_ydata())
            head = {"arrowstyle": "-|>", "color": colour, "lw": 0.8, "shrinkA": 0, "shrinkB": 0, "mutation_scale": 9}
            ax.annotate("", (x[44], y[44]), (x[38], y[38]), arrowprops=head, zorder=4)
        (dots,) = ax.plot(V, U, "o", ms=4.2, color=INK, zorder=5, ls="none")
        ax.margins(0.18)
        ax.autoscale_view()
        low, high = ax.get_ylim()
        wall = ax.axhspan(low, sigma, color=WALL, lw=0, zorder=0)
        ax.set_ylim(low, high)
        ax.axhline(sigma, color=INK, lw=0.8, zorder=1)
        ax.axvline(0.0, color=INK, lw=0.4, zorder=1)
        ax.set(xlabel="velocity $V$", ylabel="position $U$")
    return {
        "figure": root(ax),
        "points": dots,
        "fall": fall,
        "reset": reset,
        "back": back,
        "wall": wall,
        "flow": behind,
    }


def _checked_flow(flow: Any) -> list[NDArray[np.float64]]:
    """Return pieces of a flow as arrays of rows (u, v), or raise InputError."""
    try:
        pieces = [np.asarray(piece, np.float64) for piece in (() if flow is None else flow)]
    except (TypeError, ValueError):
        pieces = [np.empty(0)]
    if any(piece.ndim != 2 or piece.shape[1] != 2 for piece in pieces):
        raise InputError(f"flow is {shown(flow)}; give a list of arrays of shape (n, 2), rows (u, v)")
    return pieces
