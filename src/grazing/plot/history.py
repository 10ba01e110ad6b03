"""A motion in time, with every impact."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes

from grazing.outcome import InputError, shown
from grazing.plot.drawn import inline
from grazing.plot.expected import expect
from grazing.plot.style import DOUBLE, GRAZE, INK, WALL, axes, quantity, root, styled
from grazing.plot.trajectory import cuts, impacts_of, limits, walls_of

#: Width of the line and size of the marks in points, at most and at least, and shares of how far swings and impacts
#: are apart: many of them are drawn finer, else they run into a bar.
LINE, MARK = (1.0, 0.25, 0.35), (3.2, 0.8, 0.8)


@inline
def history(result: Any, ax: Axes | None = None, *, of: str | None = None, colour: str = INK) -> dict[str, Any]:
    """Draw a motion in time, with a mark at each impact.

    Parameters
    ----------
    result : xarray.Dataset
        From :func:`grazing.trajectory` or :func:`grazing.sample`.
    ax : matplotlib Axes, optional
        Default: a new figure two columns wide.
    of : {"u", "v"}, optional
        Position, with the walls, or velocity, which jumps at impacts. Default: position, unless the result says.
    colour : str
        Of the motion.

    Returns
    -------
    dict
        ``motion`` (a line, for the velocity broken at each impact), ``impacts`` (one line of marks: full before the
        impact, and for the velocity a second one, hollow, after it), ``wall`` (None for the velocity), ``legend`` (None
        without impacts), ``figure``.
    """
    expect(result, "trajectory", {"u": ("t",), "v": ("t",), "impact_time": ("impact",)}, "history")
    of = str(result.attrs.get("history_of", "u")) if of is None else of
    if not isinstance(of, str) or of not in ("u", "v"):
        raise InputError(f"of = {shown(of)}; allowed are u, the position, and v, the velocity")
    with styled():
        ax = axes(ax, DOUBLE, 50.0)
        walls = walls_of(result)
        t, x, hits = (np.asarray(result[name].values) for name in ("t", of, "impact_time"))
        shown_hits = (hits >= t[0]) & (hits <= t[-1])
        hits = hits[shown_hits]
        rises = np.diff(x) > 0.0
        width, size = _fine(ax, int((rises[:-1] & ~rises[1:]).sum()), LINE), _fine(ax, hits.size, MARK)
        wall, impacts = None, []
        at, *speeds = (values[shown_hits] for values in impacts_of(result))
        if of == "u":
            before = at
            ends = limits(np.append(x, at), walls)
            for place, below in walls:
                far = ends[0] if below else ends[1]
                wall = ax.fill_between(t, far, place, color=WALL, lw=0, zorder=0)
            ax.set_ylim(*ends)
        else:
            ax.axhline(0.0, color=INK, lw=0.4, zorder=1)
            before, after = speeds
            impacts += ax.plot(hits, after, "o", ls="", ms=size, mfc="white", mec=GRAZE, mew=0.25 * size, zorder=5)
            cut = cuts(t, hits)
            t, x = np.insert(t, cut, t[cut]), np.insert(x, cut, np.nan)
        impacts += ax.plot(hits, before, "o", ls="", ms=size, mew=0, color=GRAZE, zorder=4)
        (motion,) = ax.plot(t, x, color=colour, lw=width, zorder=3)
        ax.set(xlim=(t[0], t[-1]), xlabel=quantity(result["t"]), ylabel=quantity(result[of]))
        impacts = impacts[::-1]
        legend = None
        if hits.size:  # above the motion, which may be anywhere
            for marks, text in zip(
                impacts, ("impact",) if of == "u" else ("before an impact", "after it"), strict=True
            ):
                marks.set_label(text)
            legend = ax.legend(
                handles=impacts, ncols=2, frameon=False, handletextpad=0.2, markerscale=MARK[0] / size,
                loc="lower right", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.2,
            )  # fmt: skip
    return {"figure": root(ax), "motion": motion, "impacts": impacts, "wall": wall, "legend": legend}


def _fine(ax: Axes, count: int, look: tuple[float, float, float]) -> float:
    """Return how wide each of so many things is drawn beside each other: no wider than a share of their distance."""
    most, least, share = look
    points = ax.get_window_extent().width * 72.0 / root(ax).dpi
    return float(np.clip(share * points / max(count, 1), least, most))
