"""Lyapunov exponents as one parameter varies."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from grazing.plot.classes import legend_beside, patch
from grazing.plot.drawn import inline
from grazing.plot.expected import choice, expect
from grazing.plot.provenance import provenance_of
from grazing.plot.raster import axes_along, bands_of, edges_of, name_single, ordered
from grazing.plot.style import DOUBLE, INK, note, root, styled, symbol, unit_of

Floats = NDArray[np.float64]

#: By how much the mark of each further exponent is wider than the one before it.
RIM = 0.7
#: Colours of the exponents, the greatest first; further ones have the last colour.
COLOURS = (INK, "#2f7fb8", "#e69f00", "#86d3b4", "#b9b3e3")
CHAOS_SHADE = "#f6ddd3"
#: Height of the row of marks for minus infinity, as a share of the axes.
ROW = 0.1
#: Points above the axes at which the legend ends.
OVER = 14.0
#: More marks than this are pixels in vector files.
MANY = 3000


@inline
def lyapunov(
    result: Any, ax: Axes | None = None, *, per: str = "step", positive: float = 1e-3, legend: bool | None = None
) -> dict[str, Any]:
    """Draw Lyapunov exponents against a parameter, for all starts.

    Parameters
    ----------
    result : xarray.Dataset
        From :func:`grazing.lyapunov`: ``exponent`` and ``exponent_per_time`` on (parameter, "start", "index").
    ax : matplotlib Axes, optional
        Default: a new figure two columns wide.
    per : {"step", "time"}
        Whether the exponents are those per step of the map or per unit of time.
    positive : float
        Where the greatest exponent of any start, per step, is greater than this the diagram is shaded: chaos. An
        exponent that is zero in truth is found with an error that falls as the number of steps grows.
    legend : bool, optional
        Whether one stands beside the axes; None for one in a figure of its own only.

    Returns
    -------
    dict
        ``exponents`` (one line for each index), ``infinite`` (index to the marks of minus infinity, in a row at the
        bottom), ``zero``, ``chaos`` (list of shaded bands), ``legend`` and ``note`` (or None), ``provenance``,
        ``figure``.

    Raises
    ------
    InputError
        For another kind of result, or ``per``.
    """
    variable = "exponent" if choice(per, "per", ("step", "time")) == "step" else "exponent_per_time"
    needed = dict.fromkeys((variable, "exponent"), ("<parameter>", "start", "index"))
    name, _start, _index = expect(result, "lyapunov", needed)
    values, where = ordered(result[name].values)
    exponent = np.asarray(result[variable].values, np.float64)[where]
    starts, count = exponent.shape[1:]
    with styled():
        ax = axes_along(ax, DOUBLE, 70.0, values)
        edges = edges_of(values, ax.xaxis)
        greatest = np.asarray(result["exponent"].values, np.float64)[where, :, 0]
        known = np.where(np.isnan(greatest), -np.inf, greatest).max(axis=1)
        chaotic = bands_of(known > positive, edges, ax.xaxis)
        bands = [ax.axvspan(low, high, color=CHAOS_SHADE, lw=0, zorder=0) for low, high in chaotic]
        zero = ax.axhline(0.0, color="#595959", lw=0.6, zorder=1.5)
        lines = _lines(ax, values, exponent)
        infinite = _infinite(ax, values, exponent)
        ax.set_xlim(edges[0], edges[-1])
        name_single(ax.xaxis, values)
        ax.set_xlabel(symbol(result[name]))
        which = "Lyapunov exponent" if count == 1 else "Lyapunov exponents"
        unit = unit_of(result[variable])
        ax.set_ylabel(f"{which} per {'step' if per == 'step' else 'unit of time'}{unit}")
        lost = int(np.isnan(greatest).sum())
        none = f"{lost:,} of {greatest.size:,} starts have none: they ended or have no derivative" if lost else ""
        beside = None
        entries = _entries(count, starts, bool(bands), infinite)
        if legend and entries:
            place: dict[str, Any] = {
                "loc": "lower left",
                "bbox_to_anchor": (0.0, 1.0),
                "ncols": len(entries),
                "columnspacing": 1.4,
            }
            beside = legend_beside(ax, entries, **place)
        said = note(ax, none, 2.0 if beside is None else OVER)
    return {
        "figure": root(ax),
        "exponents": lines,
        "infinite": infinite,
        "zero": zero,
        "chaos": bands,
        "legend": beside,
        "note": said,
        "provenance": provenance_of(result),
    }


def _lines(ax: Axes, values: Floats, exponent: Floats) -> list[Any]:
    """Draw a line for a single start, else marks: starts on several attractors have several exponents."""
    _values, starts, count = exponent.shape
    finite = np.where(np.isfinite(exponent), exponent, np.nan)
    drawn = []
    for k in reversed(range(count)):  # the greatest on top
        look: dict[str, Any] = {"color": COLOURS[min(k, len(COLOURS) - 1)], "zorder": 3.0 - 0.1 * k}
        if starts == 1:
            few = values.size <= 60
            (line,) = ax.plot(values, finite[:, 0, k], lw=0.9, marker="o" if few else None, ms=2.0, **look)
        else:
            size = float(np.clip(200.0 / values.size, 1.0, 2.6))
            x = np.repeat(values, starts)
            size *= 1.0 + RIM * k  # where two are equal, the rim of the lower one is seen
            (line,) = ax.plot(x, finite[:, :, k].ravel(), "o", ls="none", ms=size, mew=0, **look)
            line.set_rasterized(x.size > MANY)
        drawn.append(line)
    return drawn[::-1]


def _infinite(ax: Axes, values: Floats, exponent: Floats) -> dict[int, Any]:
    """Mark exponents of minus infinity in a row of their own, below all finite ones."""
    present = [k for k in range(exponent.shape[2]) if np.isneginf(exponent[:, :, k]).any()]
    low, high = _limits(exponent)
    ax.set_ylim(low - (high - low) * ROW / (1.0 - ROW) if present else low, high)
    if not present:
        return {}
    ax.axhline(low, color="#595959", lw=0.4, ls=(0, (2, 2)), zorder=1.4)
    drawn = {}
    for place, k in enumerate(present):
        at = values[np.isneginf(exponent[:, :, k]).any(axis=1)]
        height = ROW * (1.0 - (place + 0.5) / len(present))
        colour = COLOURS[min(k, len(COLOURS) - 1)]
        (drawn[k],) = ax.plot(
            at,
            np.full(at.size, height),
            "v",
            ls="none",
            ms=2.6,
            mew=0,
            color=colour,
            transform=ax.get_xaxis_transform(),
            rasterized=at.size > MANY,
            zorder=3,
        )
    look: dict[str, Any] = {"ha": "right", "va": "center", "fontsize": 7.5, "textcoords": "offset points"}
    ax.annotate(r"$-\infty$", (0.0, 0.5 * ROW), (-4, 0), xycoords="axes fraction", **look)
    ticks = [tick for tick in ax.get_yticks() if low + 0.04 * (high - low) <= tick <= high]
    ax.set_yticks(ticks)
    return drawn


def _limits(exponent: Floats) -> tuple[float, float]:
    """Return limits with all finite exponents and zero in them."""
    finite = exponent[np.isfinite(exponent)]
    low, high = (min(float(finite.min()), 0.0), max(float(finite.max()), 0.0)) if finite.size else (-1.0, 1.0)
    pad = 0.06 * ((high - low) or 1.0)
    return low - pad, high + pad


def _entries(count: int, starts: int, chaos: bool, infinite: dict[int, Any]) -> list[Any]:
    entries: list[Any] = []
    for k in range(count if count > 1 else 0):
        name = "greatest" if k == 0 else f"{k + 1}{ {2: 'nd', 3: 'rd'}.get(k + 1, 'th') }"
        mark: dict[str, Any] = (
            {"ls": "-", "lw": 1.2} if starts == 1 else {"ls": "none", "marker": "o", "ms": 3.0, "mew": 0}
        )
        entries.append(Line2D([], [], color=COLOURS[min(k, len(COLOURS) - 1)], label=name, **mark))
    if chaos:
        entries.append(patch(CHAOS_SHADE, "chaos: greatest > 0", linewidth=0))
    if infinite:
        look: dict[str, Any] = {"ls": "none", "marker": "v", "ms": 3.2, "mew": 0, "color": INK}
        entries.append(Line2D([], [], label=r"$-\infty$: completed chatter or rest", **look))
    return entries
