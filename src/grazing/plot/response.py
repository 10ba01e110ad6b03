"""Responses: what was reached going up, going down and from random starts, over branches with their special points."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from grazing.plot.bifurcation_diagram import branch_part
from grazing.plot.branch import DASHES, branch, kinds, special_entries
from grazing.plot.classes import blended, legend_beside, patch
from grazing.plot.drawn import inline
from grazing.plot.expected import choice, expect
from grazing.plot.provenance import provenance_of
from grazing.plot.raster import axes_along, edges_of, ordered
from grazing.plot.spread import spread
from grazing.plot.style import CHAOS, DOUBLE, GRAZE, INK, quantity, root, styled, symbol

if TYPE_CHECKING:
    import xarray as xr

#: Marks of the sweeps; random starts are dots.
RUNS = {"up": "^", "down": "v"}
COLOURS = {"up": "#0064a4", "down": GRAZE}
#: Room beside the first and the last mark, as a share of the axis.
EDGE = 0.012
#: Opacity of the ranges in which up and down differ.
SHADE = 0.07


@inline
def response(
    result: Any, ax: Axes | None = None, *, by: str = "amplitude", names: bool = True, legend: bool | None = None
) -> dict[str, Any]:
    """Draw a reading over the parameter: sweeps as triangles, random starts as dots, branches as lines.

    Parameters
    ----------
    result : xarray.Dataset
        From :func:`grazing.response`.
    ax : matplotlib Axes, optional
        Default: a new figure two columns wide.
    by : str
        Which reading: ``amplitude``, ``mean``, ``peak_velocity``, ``rms_velocity``, ``impact_speed``,
        ``mean_impact_speed``, ``impulse`` or ``impacts_per_period``.
    names : bool
        Whether special points carry their names.
    legend : bool, optional
        Whether to say what lines, marks and names are; None for one in a figure of its own only.

    Returns
    -------
    dict
        ``runs`` (*up*, *down* and *starts* to a line of marks), ``lines``, ``markers`` and ``names`` as
        :func:`grazing.plot.branch`, ``differences`` (a list of shaded bands, where up and down differ), ``legend``
        (or None), ``provenance``, ``figure``.

    Raises
    ------
    InputError
        For another kind of result, or a reading that it does not have.
    """
    name, _run = expect(result, "response", {"amplitude": ("<parameter>", "run"), "branch_piece": ("branch_point",)})
    known = [str(key) for key in result.data_vars if f"special_{key}" in result and f"branch_{key}" in result]
    readings = [key for key in known if result[key].dims == (name, "run") and key != "period"]
    choice(by, "by", readings)
    table = branch_part(result, name, [by])
    table[by] = table[by].expand_dims("one", -1)
    values, runs = result[name].values, result["run"].values.tolist()
    with styled():
        ax = axes_along(ax, DOUBLE, 90.0, values)
        found = {}
        starts = [i for i, run in enumerate(runs) if run not in RUNS]
        y = result[by].values
        (found["starts"],) = ax.plot(
            np.repeat(values, len(starts)), y[:, starts].ravel(), ".", ms=2.0, color=CHAOS, mew=0, zorder=2, ls="none"
        )
        for run, mark in RUNS.items():
            if run in runs:
                (found[run],) = ax.plot(
                    values,
                    y[:, runs.index(run)],
                    mark,
                    ms=4.0,
                    mfc="none",
                    mec=COLOURS[run],
                    mew=0.7,
                    zorder=4,
                    ls="none",
                )
        rising, _where = ordered(values)
        edges = edges_of(rising, ax.xaxis)  # of cells: the sweeps may differ at one value alone
        first = np.searchsorted(rising, result["difference_low"].values)
        last = np.searchsorted(rising, result["difference_high"].values, side="right")
        seen = first < last  # of a part of a result, its own
        bands = [
            ax.axvspan(edges[a], edges[b], color=INK, alpha=SHADE, lw=0, zorder=0)
            for a, b in zip(first[seen], last[seen], strict=True)
        ]
        scale = ax.xaxis.get_transform()
        at = scale.transform(np.array([values.min(), values.max()]))
        ax.set_xlim(*scale.inverted().transform(at + EDGE * np.ptp(at) * np.array([-1.0, 1.0])))
        drawn = branch(table, ax, virtual=False, names=names, legend=False)
        ax.set(xlabel=symbol(result[name]), ylabel=quantity(result[by]))
        said = explained(ax, table, found, bool(bands)) if legend else None
        spread(ax, drawn["names"], drawn["markers"])
    return {
        "figure": root(ax), "runs": found, "lines": drawn["lines"], "markers": drawn["markers"],
        "names": drawn["names"], "differences": bands, "legend": said, "provenance": provenance_of(result),
    }  # fmt: skip


def explained(ax: Axes, table: xr.Dataset, runs: dict[str, Any], differ: bool) -> Any:
    """Add a legend beside the axes: what marks and lines are, and the names of special points in words."""
    texts = {"up": "going up", "down": "going down", "starts": "random starts"}
    handles: list[Any] = []
    for run, artist in runs.items():
        handle = Line2D([], [], ls="none", marker=artist.get_marker(), color=artist.get_color(), label=texts[run])
        handle.set(ms=artist.get_markersize(), mfc=artist.get_markerfacecolor(), mec=artist.get_markeredgecolor())
        handles.append(handle)
    seen = kinds(table)
    for kind, width in (("stable", 1.2), ("unstable", 0.8)):
        if (seen == kind).any():
            handles.append(Line2D([], [], color=INK, ls=DASHES[kind], lw=width, label=f"{kind} orbits"))
    handles += special_entries(table)
    if differ:
        handles.append(patch(blended(INK, SHADE), "up and down differ"))
    return legend_beside(ax, handles, "")
