"""Phase portrait of a trajectory."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from grazing.measured import of_table, sign_of
from grazing.outcome import InputError, shown
from grazing.plot.curves import in_units_of
from grazing.plot.drawn import inline
from grazing.plot.expected import expect
from grazing.plot.style import GRAZE, INK, WALL, axes, quantity, root, styled
from grazing.plot.table import table

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]
#: What a ball at rest moves less than, in shares of its place: rounding.
STILL = 1e-12
#: Of a state of a rig.
UNITS = {"u": "m", "v": "m/s"}


@inline
def trajectory(result: Any, ax: Axes | None = None, *, colour: str = INK, strobe: Any = None) -> dict[str, Any]:
    """Draw a trajectory in the (u, v) plane: flights solid, impacts dashed along the walls.

    Parameters
    ----------
    result : xarray.Dataset
        From :func:`grazing.trajectory`.
    ax : matplotlib Axes, optional
        Default: a new figure one column wide.
    colour : str
        Of the flights.
    strobe : array_like, shape (n, 2), optional
        States (u, v) of the model at the section, in its own units, drawn as squares.

    Returns
    -------
    dict
        ``flights`` (one line with a break at each impact), ``impacts`` (one line each), ``strobe``, ``wall``,
        ``figure``.
    """
    expect(result, "trajectory", {"u": ("t",), "v": ("t",)})
    states = None if strobe is None else _states(strobe)
    with styled():
        ax = axes(ax)
        walls = walls_of(result)
        u, v = np.asarray(result["u"].values), np.asarray(result["v"].values)
        t, hits = result["t"].values, result["impact_time"].values
        cut = cuts(t, hits)
        (flights,) = ax.plot(np.insert(u, cut, np.nan), np.insert(v, cut, np.nan), color=colour, lw=1.1, zorder=3)
        impacts: list[Line2D] = []
        seen = (hits >= t[0]) & (hits <= t[-1])  # of a part of a trajectory, its own
        places, *speeds = (values[seen] for values in impacts_of(result))
        for at, before, after in zip(places, *speeds, strict=True):
            impacts += ax.plot([at, at], [before, after], color=GRAZE, lw=1.0, ls=(0, (3, 1.5)), zorder=4)
            ax.plot(at, before, "o", ms=3.2, color=GRAZE, zorder=5)
            ax.plot(at, after, "o", ms=3.2, mfc="white", mec=GRAZE, mew=0.8, zorder=5)
        dots = None
        if states is not None:
            x, y = (sign_of(result) * in_units_of(result, states, name) for name in ("u", "v"))
            (dots,) = ax.plot(x, y, "s", ms=3.6, mfc="white", mec=colour, mew=0.9, zorder=6)
        low, high = (float(most(np.concatenate([[0.0], v, *speeds]))) for most in (np.min, np.max))
        ends = limits(np.append(u, places), walls)
        wall = None
        for at, below in walls:
            far, near = (ends[0], at.max()) if below else (ends[1], at.min())
            outer = at.min() if below else at.max()
            wall = ax.axvspan(far, outer, color=WALL, lw=0, zorder=0)
            if near != outer:  # where it moves
                ax.axvspan(outer, near, color=WALL, alpha=0.4, lw=0, zorder=0)
        ax.axhline(0.0, color=INK, lw=0.4, zorder=1)
        room = 0.08 * ((high - low) or 1.0)  # a ball at rest has no scale
        ax.set(xlim=ends, ylim=(low - room, high + room), xlabel=quantity(result["u"]), ylabel=quantity(result["v"]))
    return {"figure": root(ax), "flights": flights, "impacts": impacts, "strobe": dots, "wall": wall}


def _states(given: Any) -> xr.Dataset:
    """Return states (u, v) of a model in its own units, or raise InputError."""
    from grazing.late import xarray as xr

    try:
        points = np.atleast_2d(np.asarray(given, np.float64))
    except (TypeError, ValueError):
        points = np.empty((0, 0))
    if points.ndim != 2 or points.shape[1] != 2:
        raise InputError(f"strobe is {shown(given)}; give states (u, v), an array of shape (n, 2)")
    columns = zip(("u", "v"), points.T, strict=True)
    return xr.Dataset({name: ("state", x, {"units": UNITS[name]}) for name, x in columns})


def walls_of(result: Any) -> list[tuple[Floats, bool]]:
    """Return where the walls of a trajectory are at its times, in its own units, and which are below the ball.

    Surfaces of a system of one's own are no such walls.
    """
    if "wall_position" in result:
        sides = result["side"].values.tolist()
        return [(at, side == "below") for at, side in zip(result["wall_position"].values, sides, strict=True)]
    if "before" in result:
        return []
    at = float(result["wall"]) if "wall" in result else float(result.attrs.get("parameter_sigma", 0.0))
    return [(np.full(result.sizes["t"], at), sign_of(result) > 0.0)]


def impacts_of(result: Any) -> tuple[Floats, Floats, Floats]:
    """Return where each impact of a trajectory is, and the velocities before and after it.

    By its record: between two points of a trajectory, or two samples, a wall may move.
    """
    if "before" in result:  # of a system of one's own, whose v_minus and v_plus are rates of a gap
        before, after = (result[name].sel(coordinate=["u", "v"]).values for name in ("before", "after"))
        return before[:, 0], before[:, 1], after[:, 1]
    jumps = result["v_minus"].values, result["v_plus"].values
    if "impact_position" in result:
        return result["impact_position"].values, *jumps
    ((at, _below),) = walls_of(result)
    return np.full(result.sizes["impact"], at[0]), *jumps


def cuts(t: Floats, hits: Floats) -> NDArray[np.intp]:
    """Return where a line breaks at impacts: before the first point after each.

    A trajectory has two points at an impact, samples have none: the line breaks between before and after.
    """
    cut = np.searchsorted(t, hits)
    cut += t[np.minimum(cut + 1, len(t) - 1)] == hits
    return np.unique(cut[(cut > 0) & (cut < len(t))])


def limits(u: Floats, walls: list[tuple[Floats, bool]]) -> tuple[float, float]:
    """Return the ends of an axis of positions: a little beyond the motion, and into the walls."""
    low = min([float(u.min()), *(float(at.min()) for at, below in walls if below)])
    high = max([float(u.max()), *(float(at.max()) for at, below in walls if not below)])
    edge = 0.08 * (max(high - low, STILL * max(abs(low), abs(high))) or 1.0)
    return low - edge, high + edge


def whole(result: Any, **style: Any) -> dict[str, Any]:
    """Draw the figure of a stored trajectory; that of a ball on a table is drawn on the table of its recipe."""
    if not of_table(result):
        return trajectory(result, **style)
    return table(table_in(result), result, **style)


def table_in(result: Any) -> Any:
    """Return the pinball table that a result was made on, from the recipe that it keeps."""
    from grazing.config.maps import model_of
    from grazing.config.origin import recipe_of

    return model_of(recipe_of(result.attrs, {}))
