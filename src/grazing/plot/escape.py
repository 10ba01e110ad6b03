"""Escape rates as one parameter varies."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes

from grazing.plot.drawn import inline
from grazing.plot.expected import expect
from grazing.plot.provenance import provenance_of
from grazing.plot.raster import axes_along, name_single, ordered
from grazing.plot.style import INK, root, styled, symbol


@inline
def escape(result: Any, ax: Axes | None = None, *, colour: str = INK) -> dict[str, Any]:
    """Draw escape rates with their errors against a parameter.

    Parameters
    ----------
    result : xarray.Dataset
        From the study *escape*: ``rate`` and ``error`` on the parameter.
    ax : matplotlib Axes, optional
        Default: a new figure one column wide.
    colour : str
        Of the marks.

    Returns
    -------
    dict
        ``rates`` (a line of marks), ``errors`` (bars of one standard error to either side), ``provenance``, ``figure``.

    Raises
    ------
    InputError
        For another kind of result.

    Examples
    --------
    >>> import grazing as gz
    >>> from grazing.studies.escape import escape
    >>> P = gz.collision_map(gz.read_table("one_bumper"))
    >>> found = escape(P, "bumper.V", [0.2, 0.8], orbits=100, transient=1, steps=1, populations=2)
    >>> gz.plot.escape(found)["rates"].get_xdata().tolist()
    [0.2, 0.8]
    """
    (name,) = expect(result, "escape", dict.fromkeys(("rate", "error"), ("<parameter>",)))
    values, where = ordered(result[name].values)
    rate, error = (np.asarray(result[key].values, np.float64)[where] for key in ("rate", "error"))
    with styled():
        ax = axes_along(ax, 85.0, 60.0, values)
        line, _caps, bars = ax.errorbar(values, rate, yerr=error, fmt="o-", ms=2.5, lw=0.8, color=colour)
        name_single(ax.xaxis, values)
        ax.set(xlabel=symbol(result[name]), ylabel="escape rate per step")
    return {"figure": root(ax), "rates": line, "errors": bars, "provenance": provenance_of(result)}
