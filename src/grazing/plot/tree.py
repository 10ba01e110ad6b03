"""The tree of words of the gap map: the windows of each word in a row of its own, and what it joins beside them."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle
from mpl_toolkits.axes_grid1 import make_axes_locatable  # type: ignore[import-untyped]
from numpy.typing import NDArray

from grazing.plot.classes import written
from grazing.plot.drawn import inline
from grazing.plot.expected import expect
from grazing.plot.provenance import provenance_of
from grazing.plot.style import INK, SINGLE, WALL, axes, label, period_colour, root, styled

Floats = NDArray[np.float64]

#: Heights of a bar with a stable orbit, and of one with any orbit, in rows.
BAR, THIN = 0.62, 0.2
#: Height of a row in millimetres, what the axis needs besides, and width of the tree as a part of the windows'.
ROW, REST, TREE = 3.1, 20.0, 0.5
#: Rows beyond which only words with a stable orbit are named.
NAMED = 40
FAINT = "#9a9a9a"
#: Areas of the marks of words, in square points.
SIZES = {"stable": 11.0, "unstable": 9.0, "virtual": 4.0}


@inline
def tree(result: Any, ax: Axes | None = None, *, log: bool = False, legend: bool | None = None) -> dict[str, Any]:
    """Draw the windows of a tree of words, one row for each word, with the tree on the right.

    Parameters
    ----------
    result : xarray.Dataset
        From :func:`grazing.adding_tree`.
    ax : matplotlib Axes, optional
        Its limits in x are kept if they were set. Default: a new figure, one column wide and as high as it needs.
    log : bool
        Whether the axis of mu is logarithmic; windows at mu <= 0 are then left out.
    legend : bool, optional
        Whether one stands beside the axes; None for one in a figure of its own only.

    Returns
    -------
    dict
        ``windows`` (word to bar, stable, coloured by the length of the word), ``exist`` (word to thin bar, any
        admissible orbit), ``nodes`` (status to markers: filled for stable, open for unstable, grey for virtual),
        ``branches``, ``names`` (word to the text of its row), ``legend`` (or None), ``tree`` (the axes of the tree),
        ``provenance``, ``figure``.

    Raises
    ------
    InputError
        For another kind of result.
    """
    node = ("node",)
    columns = ("word", "length", "level", "left", "right", "status", "low", "high", "exists_low", "exists_high")
    expect(result, "adding_tree", dict.fromkeys(columns, node))
    rows = {name: result[name].values for name in columns}
    words = [str(word) for word in rows["word"]]
    with styled():
        given = ax is not None and not ax.get_autoscalex_on()
        ax = axes(ax, SINGLE, ROW * len(words) + REST)
        if log:
            ax.set_xscale("log")
        if not given:
            ax.set_xlim(*_limits(rows, log))
        ax.set_ylim(-0.8, len(words) - 0.2)
        windows = _bars(ax, rows, words, "low", "high", BAR)
        exist = _bars(ax, rows, words, "exists_low", "exists_high", THIN)
        ax.set_xlabel(label("mu", result["low"].attrs.get("symbol")))
        names = _names(ax, words, rows["status"])
        beside, nodes, branches = _tree(ax, rows)
        entries = _legend(ax, nodes) if legend else None
    return {
        "figure": root(ax),
        "windows": windows,
        "exist": exist,
        "nodes": nodes,
        "branches": branches,
        "names": names,
        "legend": entries,
        "tree": beside,
        "provenance": provenance_of(result),
    }


def _limits(rows: dict[str, Any], log: bool) -> tuple[float, float]:
    """Return limits that hold all finite edges, with a margin."""
    ends = np.concatenate([rows[name] for name in ("low", "high", "exists_low", "exists_high")])
    ends = ends[np.isfinite(ends) & ((ends > 0.0) | (not log))]
    if ends.size == 0:
        return (0.1, 1.0) if log else (0.0, 1.0)
    low, high = float(ends.min()), float(ends.max())
    if log:
        margin = (high / low) ** 0.04 if high > low else 1.5
        return low / margin, high * margin
    margin = 0.04 * (high - low) or 0.5
    return low - margin, high + margin


def _bars(ax: Axes, rows: dict[str, Any], words: list[str], low: str, high: str, height: float) -> dict[str, Any]:
    """Draw one bar for each word that has an interval within the limits."""
    left, right = sorted(ax.get_xlim())
    found = {}
    for i, word in enumerate(words):
        a, b = max(float(rows[low][i]), left), min(float(rows[high][i]), right)
        if not a < b:  # NaN included
            continue
        colour = period_colour(int(rows["length"][i]))
        look: dict[str, Any] = {"facecolor": colour, "lw": 0, "zorder": 3, "alpha": 1.0 if height == BAR else 0.45}
        found[word] = ax.add_patch(Rectangle((a, i - 0.5 * height), b - a, height, **look))
    return found


def _names(ax: Axes, words: list[str], status: Any) -> dict[str, Any]:
    """Write the words beside their rows, those without an orbit faintly."""
    shown = [i for i in range(len(words)) if len(words) <= NAMED or status[i] == "stable"]
    ax.set_yticks(shown, [written(words[i]) for i in shown], fontsize=6.5)
    ax.tick_params(axis="y", length=0.0, pad=2.0)
    ax.spines["left"].set_visible(False)
    for i in range(len(words)):
        ax.axhline(i, color=WALL, lw=0.35, zorder=0)
    names = {}
    for i, text in zip(shown, ax.get_yticklabels(), strict=True):
        text.set_color(INK if status[i] == "stable" else FAINT)
        names[words[i]] = text
    return names


def _tree(ax: Axes, rows: dict[str, Any]) -> tuple[Axes, dict[str, Any], list[Any]]:
    """Draw the tree beside the rows, its ends on the far side: each word between the two that it joins."""
    # the axes give up a part of their width: what stands outside of axes is laid out badly
    beside = make_axes_locatable(ax).append_axes("right", size=f"{100 * TREE:g}%", pad=0.04, sharey=ax)
    beside.set_axis_off()
    level = rows["level"]
    deepest = int(level.max())
    beside.set_xlim(-0.5, deepest + 0.5)
    across = deepest - level
    branches = []
    for i in range(len(level)):
        for parent in (int(rows["left"][i]), int(rows["right"][i])):
            if parent >= 0:
                faint = rows["status"][i] == "virtual"
                x, y = [across[parent], across[parent], across[i]], [parent, i, i]
                look = {"color": WALL if faint else FAINT, "lw": 0.6, "zorder": 1 if faint else 2}
                branches += beside.plot(x, y, solid_joinstyle="round", **look)
    nodes = {}
    for status, size in SIZES.items():
        chosen = np.flatnonzero(rows["status"] == status)
        colours = [FAINT if status == "virtual" else period_colour(int(n)) for n in rows["length"][chosen]]
        faces: Any = "white" if status == "unstable" else colours
        nodes[status] = beside.scatter(
            across[chosen], chosen, s=size, marker="o", linewidths=0.7, facecolors=faces, edgecolors=colours, zorder=4
        )
    return beside, nodes, branches


def _legend(ax: Axes, nodes: dict[str, Any]) -> Any:
    """Say above the axes what the marks mean that are there."""
    entries: list[Any] = []
    for status, drawn in nodes.items():
        if len(drawn.get_offsets()):
            ink = FAINT if status == "virtual" else INK
            face = "white" if status == "unstable" else ink
            entries.append(
                Line2D([], [], ls="none", marker="o", ms=SIZES[status] ** 0.5, mfc=face, mec=ink, mew=0.7, label=status)
            )
    return ax.legend(
        handles=entries,
        title="words with an orbit that is",
        title_fontsize=6.5,
        loc="lower center",
        bbox_to_anchor=(0.5, 1.0),
        ncols=len(entries),
        handletextpad=0.2,
        columnspacing=1.2,
        borderaxespad=0.1,
        fontsize=6.5,
    )
