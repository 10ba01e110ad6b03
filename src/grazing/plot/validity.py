"""Validity of a reduction over two parameters: where its words are those of the flow."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LinearSegmentedColormap, Normalize, to_rgba_array
from matplotlib.lines import Line2D

from grazing.plot.classes import legend_beside, patch
from grazing.plot.curves import curves_of, lay_curves
from grazing.plot.drawn import inline
from grazing.plot.expected import choice, expect
from grazing.plot.provenance import provenance_of
from grazing.plot.raster import axes_along, edges_of, name_single, ordered, raster
from grazing.plot.style import ENDED, GRAZE, root, styled, symbol

#: Colours of the classes of agreement, from light to dark the worse, and their names in the legend.
CLASSES = {
    0: ("#cfe8df", "same words"),
    1: ("#f2c14e", "some in common"),
    2: ("#b5482f", "none in common"),
    3: ("#4a3b6b", "several impacts\nin a period"),
    4: (ENDED, "outside its form"),
}
#: Overlap of the shares of the words, from none to all.
OVERLAP = ("#5e1a12", "#b5482f", "#f2c14e", "#cfe8df")


@inline
def validity(
    result: Any,
    ax: Axes | None = None,
    *,
    by: str = "agreement",
    curves: Any = None,
    legend: bool | None = None,
) -> dict[str, Any]:
    """Draw where the words of a reduction are those of the flow.

    Parameters
    ----------
    result : xarray.Dataset
        From :func:`grazing.validity`: ``agreement``, ``overlap`` and ``graze``.
    ax : matplotlib Axes, optional
        Default: a new figure between one and two columns wide.
    by : {"agreement", "overlap"}
        What is shown: the classes, or the overlap of the shares of the words.
    curves : xarray.Dataset, Locus, list of them, or mapping of str to (x, y), optional
        Further curves to be laid on top, such as edges of windows, as :func:`grazing.plot.chart` takes them; each name
        is written on its curve.
    legend : bool, optional
        Whether a legend, or a colour bar, stands beside; None for one in a figure of its own only.

    Returns
    -------
    dict
        ``image``, ``legend``, ``bar`` and ``graze`` (each None where there is none), ``curves`` (name to (line,
        text)), ``provenance``, ``figure``.

    Raises
    ------
    InputError
        For another kind of result, or ``by``.
    """
    choice(by, "by", ("agreement", "overlap"))
    plane = ("<first parameter>", "<second parameter>")
    first, second = expect(result, "validity", {"agreement": plane, "overlap": plane, "graze": ("<one of them>",)})
    (x_values, i), (y_values, j) = ordered(result[first].values), ordered(result[second].values)
    codes = np.asarray(result["agreement"].values)[i][:, j]
    shares = np.asarray(result["overlap"].values, np.float64)[i][:, j]
    bar = beside = None
    with styled():
        ax = axes_along(ax, 120.0, 88.0, x_values, y_values)
        x, y = edges_of(x_values, ax.xaxis), edges_of(y_values, ax.yaxis)
        handles: list[Any] = []
        if by == "agreement":
            table = np.round(255.0 * to_rgba_array([colour for colour, _name in CLASSES.values()])).astype(np.uint8)
            image = raster(ax, x, y, table[codes])
            handles += [patch(*CLASSES[code]) for code in CLASSES if (codes == code).any()]
        else:
            cmap = LinearSegmentedColormap.from_list("overlap", OVERLAP)
            cells = cmap(np.nan_to_num(shares))
            cells[np.isnan(shares)] = to_rgba_array(ENDED)
            image = raster(ax, x, y, np.round(255.0 * np.asarray(cells)).astype(np.uint8))
            if legend:
                bar = root(ax).colorbar(ScalarMappable(Normalize(0.0, 1.0), cmap), ax=ax, pad=0.02, aspect=26)
                bar.set_label("overlap of the shares of the words")
                bar.outline.set_linewidth(0.4)
        line = _graze(ax, result, first, (x[0], x[-1]), (y[0], y[-1]))
        drawn = lay_curves(ax, curves_of(curves, result, first, second)[0])
        if line is not None:
            handles.append(Line2D([], [], color=GRAZE, lw=line.get_linewidth(), ls=line.get_linestyle(), label="graze"))
        if legend and by == "agreement":
            beside = legend_beside(ax, handles)
        elif legend and line is not None:
            beside = legend_beside(ax, handles, loc="lower left", bbox_to_anchor=(0.0, 1.0))
        name_single(ax.xaxis, x_values)
        name_single(ax.yaxis, y_values)
        ax.set(xlabel=symbol(result[first]), ylabel=symbol(result[second]))
    return {
        "figure": root(ax),
        "image": image,
        "legend": beside,
        "bar": bar,
        "graze": line,
        "curves": drawn,
        "provenance": provenance_of(result),
    }


def _graze(ax: Axes, result: Any, first: str, x: tuple[Any, Any], y: tuple[Any, Any]) -> Line2D | None:
    """Draw where the steady response grazes, if that is inside."""
    along = str(result["graze"].dims[0])
    order = np.argsort(result[along].values)
    at, value = result[along].values[order], np.asarray(result["graze"].values, np.float64)[order]
    if along == first:
        span, (u, v) = y, (at, value)
    else:
        span, (u, v) = x, (value, at)
    if not ((value > span[0]) & (value < span[1])).any():
        return None
    (line,) = ax.plot(u, v, color=GRAZE, lw=0.9, ls=(0, (5, 2)), zorder=3)
    ax.set(xlim=x, ylim=y)
    return line
