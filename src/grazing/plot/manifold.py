"""Stable and unstable manifolds of saddles, alone or on top of basins."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patheffects import withStroke
from numpy.typing import NDArray

from grazing.plot.classes import legend_extended
from grazing.plot.drawn import inline
from grazing.plot.expected import expect
from grazing.plot.provenance import provenance_of
from grazing.plot.style import INK, axes, label, plain, root, styled

Floats = NDArray[np.float64]

#: Colours of the two sides on paper and on an image; none is that of a period or of the grazing curve.
PAPER = {"stable": INK, "unstable": "#00979d"}
IMAGE = {"stable": "#ffffff", "unstable": "#5ff2f2"}
WIDTH, RIM = 1.0, 2.2


@inline
def manifolds(
    result: Any, ax: Axes | None = None, *, saddle: bool = True, cuts: bool = False, legend: bool | None = None
) -> dict[str, Any]:
    """Draw a stable or an unstable manifold; where it is cut, nothing joins the two sides.

    Parameters
    ----------
    result : xarray.Dataset
        From :func:`grazing.manifolds`: ``manifold`` (point, coordinate), the pieces with their ``cut_first`` and
        ``cut_last``, ``saddle`` (saddle_index, coordinate).
    ax : matplotlib Axes, optional
        Such as those of :func:`grazing.plot.basins` of the same map, whose limits and labels then stay. Default: a
        new figure between one and two columns wide.
    saddle : bool
        Whether the points of the saddle are marked.
    cuts : bool
        Whether the ends at which the map is not smooth are marked.
    legend : bool, optional
        Whether a legend stands beside the axes; entries of a legend that is there already are kept; None for one in a
        new figure, or where there is one.

    Returns
    -------
    dict
        ``line``, ``saddle`` and ``cuts`` (lines, or None), ``legend`` (or None), ``provenance``, ``figure``.

    Raises
    ------
    InputError
        For another kind of result.

    Examples
    --------
    >>> import grazing as gz
    >>> from grazing.plot.manifold import manifolds
    >>> orbit = gz.one_impact_orbits(gz.pinball(d=0.105, V=0.4), 2)[-1]
    >>> from grazing.orbits.manifold import manifolds as grown
    >>> drawn = manifolds(grown(orbit, "stable"))
    >>> [text.get_text() for text in drawn["legend"].get_texts()]
    ['stable manifold', 'saddle 01']
    """
    layout = {
        "manifold": ("point", "coordinate"),
        "piece": ("point",),
        "cut_first": ("piece",),
        "cut_last": ("piece",),
        "saddle": ("saddle_index", "coordinate"),
    }
    expect(result, "manifolds", layout)
    side, word = str(result.attrs.get("side", "stable")), str(result.attrs.get("orbit_word", ""))
    names = [str(name) for name in result["coordinate"].values]
    with styled():
        fresh = ax is None or not ax.has_data()
        ax = axes(ax, 130.0, 90.0)
        image = bool(ax.images)  # the colours of basins reach from black to light
        colour = (IMAGE if image else PAPER).get(side, INK)
        rim = [withStroke(linewidth=RIM, foreground=INK if image else "white", alpha=0.9)]
        limits = ax.get_xlim(), ax.get_ylim()
        x, y = np.asarray(result["manifold"].values, np.float64).T
        look: dict[str, Any] = {"color": colour, "lw": WIDTH, "path_effects": rim}
        (line,) = ax.plot(x, y, solid_capstyle="butt", zorder=5.2, **look)
        dot: dict[str, Any] = {"ms": 2.6, "mfc": colour, "mec": INK, "mew": 0.4}
        ends = _cuts(ax, result, dot) if cuts else None
        marks = _saddle(ax, np.asarray(result["saddle"].values, np.float64)) if saddle else None
        if fresh:
            limits = _limits(result, x, 0), _limits(result, y, 1)
            for text, axis in zip(_labels(result, names), (ax.xaxis, ax.yaxis), strict=True):
                axis.set_label_text(text)
        ax.set(xlim=limits[0], ylim=limits[1])
        entries = [Line2D([], [], label=f"{side} manifold", **look)]
        if ends is not None:
            entries.append(Line2D([], [], ls="none", marker="o", label="cut: the map is not smooth", **dot))
        if marks is not None:
            name = plain(f"saddle {word}".strip())
            entries.append(Line2D([], [], ls="none", marker="X", ms=5.0, mfc="white", mec=INK, mew=0.9, label=name))
        beside = legend_extended(ax, entries) if legend else None
    return {
        "figure": root(ax),
        "line": line,
        "saddle": marks,
        "cuts": ends,
        "legend": beside,
        "provenance": provenance_of(result),
    }


def _labels(result: Any, names: list[str]) -> list[str]:
    """Return what the axes say: symbols, or names where the result has no others, and units."""
    others = result["coordinate"].attrs.get("symbols") or names
    units = str(result["manifold"].attrs.get("units", "1")).split(", ")
    units = units if len(units) == len(names) else ["1"] * len(names)
    parts = zip(names, others, units, strict=True)
    return [label(name, other or name) + (f" ({plain(unit)})" if unit != "1" else "") for name, other, unit in parts]


def _cuts(ax: Axes, result: Any, look: dict[str, Any]) -> Line2D:
    """Mark the ends of pieces at which the map is discontinuous or has a kink."""
    piece = np.asarray(result["piece"].values)
    points = np.asarray(result["manifold"].values, np.float64)
    rows = np.flatnonzero(np.isfinite(points).all(axis=1))
    first = rows[np.append(True, np.diff(piece[rows]) != 0)] if len(rows) else rows
    last = rows[np.append(np.diff(piece[rows]) != 0, True)] if len(rows) else rows
    at = np.concatenate(
        [
            points[first[result["cut_first"].values[piece[first]]]],
            points[last[result["cut_last"].values[piece[last]]]],
        ]
    )
    (found,) = ax.plot(*at.T, ls="none", marker="o", zorder=5.3, **look)
    return found


def _saddle(ax: Axes, points: Floats) -> Line2D:
    """Mark the points of the saddle."""
    (found,) = ax.plot(*points.T, ls="none", marker="X", ms=5.0, mfc="white", mec=INK, mew=0.9, zorder=6.5)
    return found


def _limits(result: Any, values: Floats, axis: int) -> tuple[float, float]:
    """Return what is shown of one coordinate: the curve as far as it lies in its box, and the saddle."""
    points = np.append(values, result["saddle"].values[:, axis])
    everything = np.tile([-np.inf, np.inf], (2, 1))
    box = np.reshape(result["box"].values if "box" in result else result.attrs.get("box", everything), (2, 2))[axis]
    low, high = max(float(np.nanmin(points)), float(box[0])), min(float(np.nanmax(points)), float(box[1]))
    margin = 0.04 * (high - low) or 1.0
    return low - margin, high + margin
