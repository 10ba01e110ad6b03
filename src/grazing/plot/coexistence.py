"""Coexistence: the attractors in a range of a parameter with their shares of the starts, or their lifetimes."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, Locator, LogLocator, NullLocator, SymmetricalLogLocator
from numpy.typing import NDArray

from grazing.plot.classes import attractor_colours, class_name, legend_beside, order_of, patch, rows_beside, written
from grazing.plot.density import plain
from grazing.plot.drawn import inline
from grazing.plot.expected import choice, expect
from grazing.plot.provenance import provenance_of
from grazing.plot.raster import axes_along, edges_of, name_single, ordered
from grazing.plot.style import DOUBLE, INK, ink_on, root, styled, symbol
from grazing.plot.windows import across

Floats = NDArray[np.float64]

#: Marks of changes, in the order of the legend; others have the last one.
KINDS = {"appears": "^", "disappears": "v", "doubles": "D", "halves": "s", "relabelled": "o"}
OTHER = "x"
#: Entries of a legend, largest areas first.
LISTED = 20
#: Height of their first row above the axes and distance of rows, in points.
FIRST, ROW = 6.0, 5.0
#: Up to so many changes a hairline goes through the axes at each.
HAIRLINES = 24


@inline
def coexistence(
    result: Any, ax: Axes | None = None, *, of: str = "share", changes: bool = True, legend: bool | None = None
) -> dict[str, Any]:
    """Draw the shares of attractors as stacked areas, or the mean lifetimes of transients as lines.

    Lifetimes have a logarithmic axis, and one that is linear below one step where some are zero.

    Parameters
    ----------
    result : xarray.Dataset
        From :func:`grazing.coexistence`: ``share`` and ``lifetime`` on (parameter, "attractor"), ``word`` and
        ``period`` on "attractor", and the table of changes on "change".
    ax : matplotlib Axes, optional
        Default: a new figure two columns wide.
    of : {"share", "lifetime"}
    changes : bool
        Whether a row of marks above the axes says where attractors appear, disappear, double or change only their
        word: a relabelling is no bifurcation.
    legend : bool, optional
        Whether one stands beside the axes; None for one in a figure of its own only.

    Returns
    -------
    dict
        ``areas`` or ``lines`` (attractor to artist), ``names`` (attractor to text in its area), ``changes`` (kind to
        the line with its marks), ``legend`` (or None), ``provenance``, ``figure``.

    Raises
    ------
    InputError
        For another kind of result, or ``of``.
    """
    choice(of, "of", ("share", "lifetime"))
    table = {"word": ("attractor",), "period": ("attractor",)}
    needed = {of: ("<parameter>", "attractor"), "share": ("<parameter>", "attractor"), **table}
    name, _attractor = expect(result, "coexistence", needed)
    values, where = ordered(result[name].values)
    share, shown = (np.asarray(result[variable].values, np.float64)[where] for variable in ("share", of))
    period = [int(value) for value in result["period"].values]
    word = [str(value) for value in result["word"].values]
    stack = sorted((k for k in range(len(period)) if (share[:, k] > 0.0).any()), key=lambda k: order_of(period[k]))
    colours = dict(zip(stack, attractor_colours([period[k] for k in stack]), strict=True))
    with styled():
        ax = axes_along(ax, DOUBLE, 76.0, values)
        edges = edges_of(values, ax.xaxis)
        ax.set_xlim(edges[0], edges[-1])
        names: dict[int, Any] = {}
        if of == "share":
            areas = _areas(ax, edges, share, stack, colours)
            known = [word[k] for k in stack]
            # a word that stands for several attractors, such as a doubled one, names none of them
            single = {k: word[k] for k in stack if period[k] >= 1 and known.count(word[k]) == 1}
            names = _names(ax, edges, share, stack, colours, single)
            drawn = {"areas": areas}
            ax.set(ylim=(0.0, 1.0), ylabel="share of the starts")
        else:
            drawn = {"lines": _lifetimes(ax, values, shown, stack, colours)}
            ax.set_ylabel("mean steps before settling")
        name_single(ax.xaxis, values)
        ax.set_xlabel(symbol(result[name]))
        marks = _changes(ax, result) if changes else {}
        mean = share.mean(axis=0)
        beside = legend_beside(ax, _entries(ax, stack, mean, word, period, colours, marks)) if legend else None
    return {
        "figure": root(ax),
        **drawn,
        "names": names,
        "changes": marks,
        "legend": beside,
        "provenance": provenance_of(result),
    }


def _areas(ax: Axes, edges: Floats, share: Floats, stack: list[int], colours: dict[int, str]) -> dict[int, Any]:
    """Stack the shares, each value as wide as its cell: nothing is drawn between values that was not computed."""
    floor = np.zeros(len(share))
    drawn = {}
    rim = 0.35 if len(share) <= 400 else 0.0
    for k in stack:
        top = floor + np.nan_to_num(share[:, k])
        low, high = np.append(floor, floor[-1:]), np.append(top, top[-1:])
        there = high > low
        there[1:] |= there[:-1].copy()  # an area goes on to the end of its last cell
        look: dict[str, Any] = {"facecolor": colours[k], "edgecolor": "white", "lw": rim, "zorder": 2}
        drawn[k] = ax.fill_between(edges, low, high, where=there, step="post", **look)
        floor = top
    return drawn


def _names(
    ax: Axes, edges: Floats, share: Floats, stack: list[int], colours: dict[int, str], words: dict[int, str]
) -> dict[int, Any]:
    """Write words into areas that hold them."""
    box = ax.get_window_extent()
    points = 72.0 / root(ax).dpi
    scale = ax.xaxis.get_transform()
    at = scale.transform(edges)
    across_points = (at - at[0]) / (at[-1] - at[0]) * box.width * points
    top = np.cumsum(np.nan_to_num(share[:, stack]), axis=1) * box.height * points
    low = np.column_stack([np.zeros(len(share)), top[:, :-1]])
    drawn = {}
    for place, k in enumerate(stack):
        if not words.get(k):
            continue
        text = written(words[k])
        width = 4.6 * len(text.replace("\\mathrm", "").strip("$").translate({ord(c): None for c in "{}^"})) + 3.0
        # with room to spare if there is, so that the name stands within its area and not at its end
        tries = (_roomiest(across_points, low[:, place], top[:, place], times * width, 9.0) for times in (8, 4, 2, 1))
        best = next((found for found in tries if found is not None), None)
        if best is None:
            continue
        x, y = best
        x = float(scale.inverted().transform(at[0] + x / (box.width * points) * (at[-1] - at[0])))
        look: dict[str, Any] = {"ha": "center", "va": "center", "fontsize": 7.0, "color": ink_on(colours[k])}
        look |= {"zorder": 4, "bbox": {"facecolor": colours[k], "lw": 0, "pad": 0.8}}
        drawn[k] = ax.text(x, y / (box.height * points), text, **look)
    return drawn


def _roomiest(edges: Floats, low: Floats, top: Floats, width: float, height: float) -> tuple[float, float] | None:
    """Return the middle of the tallest place for a text inside an area, all in points; None if none holds it."""
    best, place = height, None
    for a in range(len(low)):
        b = int(np.searchsorted(edges, edges[a] + width))
        if b >= len(edges):
            break
        floor, roof = float(low[a:b].max()), float(top[a:b].min())
        if roof - floor > best:
            best, place = roof - floor, (0.5 * float(edges[a] + edges[b]), 0.5 * (floor + roof))
    return place


def _lifetimes(ax: Axes, values: Floats, lifetime: Floats, stack: list[int], colours: dict[int, str]) -> dict[int, Any]:
    marks: Locator
    if (lifetime[:, stack] == 0.0).any():  # of starts on their cycle; a logarithm has no zero
        ax.set_yscale("symlog", linthresh=1.0)
        marks = SymmetricalLogLocator(base=10.0, linthresh=1.0, subs=(1.0, 2.0, 5.0))
    else:
        ax.set_yscale("log")
        marks = LogLocator(subs=(1.0, 2.0, 5.0))
    ax.yaxis.set_major_locator(marks)
    ax.yaxis.set_major_formatter(FuncFormatter(plain))
    ax.yaxis.set_minor_locator(NullLocator())
    drawn = {}
    for k in stack:
        y = lifetime[:, k]
        # a value between two gaps has no line: it needs a mark
        size = float(np.clip(400.0 / values.size, 0.9, 2.4))
        (drawn[k],) = ax.plot(values, y, color=colours[k], lw=0.8, marker="o", ms=size, mew=0, zorder=3)
    return drawn


def _changes(ax: Axes, result: Any) -> dict[str, Any]:
    """Mark changes above the axes, each halfway between the values before and after it, kinds at one place in rows."""
    if any(name not in result for name in ("before", "after", "kind")):
        return {}
    before, after = (np.asarray(result[name].values, np.float64) for name in ("before", "after"))
    scale = ax.xaxis.get_transform()
    at = scale.inverted().transform(0.5 * (scale.transform(before) + scale.transform(after)))
    low, high = sorted(ax.get_xlim())
    inside = (at >= low) & (at <= high)  # of a part of a result, its own
    at, kinds = at[inside], np.array([str(kind) for kind in result["kind"].values])[inside]
    drawn: dict[str, Any] = {}
    rows: dict[float, int] = {}  # of marks at each place
    rest = sorted(set(kinds.tolist()) - set(KINDS))
    for kind in [*(kind for kind in KINDS if kind in kinds), *rest]:
        chosen = at[kinds == kind]
        above = [FIRST + ROW * rows.get(x, 0) for x in chosen.tolist()]
        rows |= {x: rows.get(x, 0) + 1 for x in set(chosen.tolist())}
        hollow = kind == "relabelled"
        (drawn[kind],) = ax.plot(
            chosen,
            above,
            KINDS.get(kind, OTHER),
            ls="none",
            ms=3.2,
            mew=0.7,
            mfc="white" if hollow else INK,
            mec=INK,
            transform=across(ax),
            clip_on=False,
            zorder=6,
            label=kind,
        )
        if at.size <= HAIRLINES:
            for x in chosen:
                ax.axvline(x, color=INK, lw=0.4, ls=(0, (1, 2)) if hollow else "-", alpha=0.7, zorder=3)
    return drawn


def _entries(
    ax: Axes,
    stack: list[int],
    mean: Floats,
    word: list[str],
    period: list[int],
    colours: dict[int, str],
    marks: dict[str, Any],
) -> list[Any]:
    room = min(LISTED, 2 * rows_beside(ax) - len(marks))  # in two columns
    listed = len(stack) if len(stack) <= room else max(room, 2) - 1
    largest = set(sorted(stack, key=lambda k: -float(mean[k]))[:listed])
    entries: list[Any] = [
        patch(colours[k], class_name(word[k], period[k])) for k in reversed(stack) if k in largest
    ]  # from the top of the stack down
    if len(stack) > len(largest):
        entries.append(patch("none", f"{len(stack) - len(largest)} more", edgecolor="none"))
    for kind, line in marks.items():
        look: dict[str, Any] = {
            "ls": "none",
            "marker": line.get_marker(),
            "ms": 3.4,
            "mfc": line.get_markerfacecolor(),
            "mec": INK,
        }
        entries.append(Line2D([], [], mew=0.7, label=kind, **look))
    return entries
