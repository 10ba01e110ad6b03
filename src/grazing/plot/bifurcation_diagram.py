"""Bifurcation diagrams: scanned points under branches, special points named, windows shaded."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

from matplotlib.axes import Axes

from grazing.outcome import InputError
from grazing.plot.branch import branch, shade_of, special_entries
from grazing.plot.classes import blended, legend_extended, patch
from grazing.plot.drawn import inline
from grazing.plot.expected import choice
from grazing.plot.orbit_diagram import ends_of, orbit_diagram
from grazing.plot.provenance import provenance_of
from grazing.plot.raster import axes_along
from grazing.plot.spread import spread
from grazing.plot.style import DOUBLE, INK, root, styled
from grazing.plot.words import words_in

if TYPE_CHECKING:
    import xarray as xr

#: Opacity of scanned points and of shaded windows.
FAINT, SHADE = 0.35, 0.10


@inline
def bifurcation_diagram(
    result: Any,
    ax: Axes | None = None,
    *,
    coordinate: str | None = None,
    by: str = "period",
    virtual: bool = False,
    names: bool = True,
    legend: bool | None = None,
) -> dict[str, Any]:
    """Draw scan and branches: points faint, stable orbits solid, unstable dashed, virtual dotted, windows shaded.

    Parameters
    ----------
    result : xarray.Dataset
        From :func:`grazing.bifurcation_diagram`.
    ax : matplotlib Axes, optional
        Default: a new figure two columns wide.
    coordinate : str, optional
        Which coordinate of the map; the first one by default.
    by : {"period", "word"}
        What colours tell apart, of points, branches and windows alike.
    virtual : bool
        Whether orbits that the map does not have are drawn too.
    names : bool
        Whether special points carry their names.
    legend : bool, optional
        Whether to say what colours, lines, marks and shades are; None for one in a figure of its own only.

    Returns
    -------
    dict
        ``points`` as :func:`grazing.plot.orbit_diagram` returns them, ``lines``, ``markers`` and ``names`` as
        :func:`grazing.plot.branch`, ``windows`` (a list of shaded bands), ``legend`` (or None), ``provenance``,
        ``figure``.

    Raises
    ------
    InputError
        For anything else.
    """
    from grazing.late import xarray as xr

    if not isinstance(result, xr.Dataset) or "branch_piece" not in result:
        raise InputError(
            f"no bifurcation diagram can be drawn from this {type(result).__name__}; "
            "give the result of gz.bifurcation_diagram"
        )
    name = str(result["period"].dims[0])
    table = branches_of(result, name)
    known = json.loads(table.attrs["coordinate_names"])
    chosen = choice(known[0] if coordinate is None else coordinate, "coordinate", known)
    with styled():
        ax = axes_along(ax, DOUBLE, 95.0, result[name].values)
        scan = orbit_diagram(result, ax, chosen, by=by, size=1.0, legend=legend)
        for line in scan["points"].values():
            line.set_alpha(FAINT)
        low, high = ax.get_ylim()
        drawn = branch(table, ax, coordinate=chosen, by=by, virtual=virtual, names=names, legend=legend)
        shades = words_in(root(ax)) if by == "word" else None
        bands = []
        ends = (result[f"window_{key}"].values.tolist() for key in ("low", "high", "word", "period"))
        for a, b, word, N in zip(*ends, strict=True):
            bands.append(ax.axvspan(a, b, color=shade_of(str(word), N, shades), alpha=SHADE, lw=0, zorder=0))
        ax.set_xlim(*ends_of(result[name].values, ax.xaxis))
        if virtual:
            ax.set_ylim(low, high)
        beside = None
        if legend:
            shaded = [patch(blended(INK, SHADE), "shaded: stable")] if bands else []
            beside = legend_extended(ax, [*special_entries(table, virtual), *shaded])
        spread(ax, drawn["names"], drawn["markers"])
    return {
        "figure": root(ax), "points": scan["points"], "lines": drawn["lines"], "markers": drawn["markers"],
        "names": drawn["names"], "windows": bands, "legend": beside, "provenance": provenance_of(result),
    }  # fmt: skip


def branches_of(result: xr.Dataset, name: str) -> xr.Dataset:
    """Return the branches of a bifurcation diagram as a table of their own."""
    coordinates = [str(key) for key in result.data_vars if result[key].dims == (name, "start", "n") and key != "letter"]
    return branch_part(result, name, coordinates)


def branch_part(result: xr.Dataset, name: str, coordinates: list[str]) -> xr.Dataset:
    """Return the variables of branches in a result as the table of a branch, to be drawn in these coordinates."""
    keys = [str(key) for key in result.variables if str(key).startswith(("branch_", "special_"))]
    table = result[keys].drop_vars([key for key in result.coords if key not in keys], errors="ignore")
    front = "branch_"
    renamed = {key: key.removeprefix(front) for key in [*keys, *map(str, table.dims)] if key.startswith(front)}
    table = table.rename(renamed)
    table.attrs = {"parameter": name, "coordinate_names": json.dumps(coordinates)}
    return table
