"""Portrait: how often orbits visit each part of a plane."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import Colormap, Normalize

from grazing.plot.density import bar_beside, bins_of, kept, paper_map, pooled, said_beside
from grazing.plot.drawn import inline
from grazing.plot.expected import choice, expect
from grazing.plot.norms import norm_of
from grazing.plot.provenance import provenance_of
from grazing.plot.raster import raster, refined
from grazing.plot.style import axes, root, styled, symbol

#: Of one table, along which lengths are to be equal.
PLACES = {"x of the ball's centre", "y of the ball's centre"}

#: Millimetres of the longer side of the plane, and of what stands beside and below it.
SIDE, BESIDE, BELOW = 80.0, 32.0, 12.0


@inline
def portrait(
    result: Any,
    ax: Axes | None = None,
    *,
    norm: str | Normalize = "eqhist",
    units: str = "share",
    cmap: str | Colormap | None = None,
    bar: bool = True,
) -> dict[str, Any]:
    """Draw a portrait: darker parts of the plane are visited more often, empty ones are left white.

    Parameters
    ----------
    result : xarray.Dataset
        From :func:`grazing.portrait`: ``count`` on (up, across).
    ax : matplotlib Axes, optional
        Default: a new figure. Places on a table are drawn to scale, so that :func:`grazing.plot.table` fits on them.
    norm, cmap, bar
        As in :func:`grazing.plot.density`.
    units : {"share", "count"}
        Whether the numbers are shares of all points, those beyond what is shown included, or counts.

    Returns
    -------
    dict
        ``image``, ``bar`` (Colorbar or None), ``note`` (text above the axes that says how much lies beyond what is
        shown, or None), ``provenance``, ``figure``.

    Raises
    ------
    InputError
        For another kind of result, norm or units.

    Examples
    --------
    >>> import grazing as gz
    >>> found = gz.portrait(gz.stroboscopic_map(gz.pinball(d=0.12, V=0.4)), bins=50, starts=20, keep=300)
    >>> gz.plot.portrait(found)
    <Drawn: figure, image, bar, note, provenance>
    """
    up, across = expect(result, "portrait", {"count": ("<up>", "<across>")})
    choice(units, "units", ("share", "count"))
    counts = np.asarray(result["count"].values).T
    count, columns, rows = pooled(counts, np.arange(counts.shape[0]))
    beyond = float(result["beyond"].values) if "beyond" in result else 0.0
    total = float(count.sum()) + beyond
    wide, high = (np.diff([*first, size]) for first, size in zip((columns, rows), counts.shape, strict=True))
    count /= wide[:, None] * high * (max(total, 1.0) if units == "share" else 1.0)
    with styled():
        x, y = bins_of(result[across]), bins_of(result[up])
        table = {str(result[name].attrs.get("long_name")) for name in (across, up)} == PLACES
        tall = float(min(max((y[-1] - y[0]) / (x[-1] - x[0]), 0.3), 3.0)) if table else 1.0
        ax = axes(ax, BESIDE + SIDE / max(tall, 1.0), BELOW + SIDE * min(tall, 1.0))
        shown = np.ma.masked_less_equal(count.astype(np.float32), 0.0)
        image = raster(
            ax,
            *refined(ax, kept(x, columns), kept(y, rows), shown),
            smooth=True,
            norm=norm_of(norm, count),
            cmap=cmap if cmap is not None else paper_map(),
        )
        ax.set(xlim=(x[0], x[-1]), ylim=(y[0], y[-1]))
        ax.set(xlabel=symbol(result[across]), ylabel=symbol(result[up]))
        if table:
            ax.set_aspect("equal")
        drawn = bar_beside(ax, image, units) if bar else None
        note = said_beside(ax, beyond, total, result)
    return {"figure": root(ax), "image": image, "bar": drawn, "note": note, "provenance": provenance_of(result)}
