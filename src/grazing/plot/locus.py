"""Loci: where special points lie in the plane of two parameters, with the points where two of them meet."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes

from grazing.outcome import InputError
from grazing.plot.drawn import inline
from grazing.plot.spread import spread
from grazing.plot.style import GRAZE, INK, axes, root, styled, symbol

if TYPE_CHECKING:
    import xarray as xr

#: Colours of the types of special points, each with dashes of its own so that print in grey keeps them apart.
LINES: dict[str, tuple[str, Any]] = {
    "lp": ("#0064a4", "-"), "pd": ("#e69f00", "-"), "ns": ("#00624a", "-"), "gr": (GRAZE, "-"),
    "bp": ("#0064a4", (0, (4.0, 1.5))),
    "bcb": (GRAZE, (0, (4.0, 1.5))), "v0": ("#5b2c83", (0, (4.0, 1.5))), "law": ("#7a4a12", (0, (4.0, 1.5))),
}  # fmt: skip


@inline
def locus(result: Any, ax: Axes | None = None, *, virtual: bool = True, names: bool = True) -> dict[str, Any]:
    """Draw loci in the plane of their two parameters; on the axes of a chart of the same two, too.

    Parameters
    ----------
    result : Locus, xarray.Dataset, or several of them
        From :func:`grazing.locus`, or its ``dataset``; all in the same parameters.
    ax : matplotlib Axes, optional
    virtual : bool
        Whether the parts on virtual orbits are drawn, thin.
    names : bool
        Whether meetings carry their names.

    Returns
    -------
    dict
        ``lines``, ``markers``, ``names``, ``legend`` and ``figure``.

    Raises
    ------
    InputError
        For anything else, or loci in different parameters.
    """
    tables = [table_of(one) for one in (result if isinstance(result, (list, tuple)) else [result])]
    if not tables:
        raise InputError("no locus to draw; give what gz.locus returns, or several of them")
    x, y = json.loads(tables[0].attrs["parameters"])
    if any(json.loads(table.attrs["parameters"]) != [x, y] for table in tables):
        raise InputError("the loci lie in the planes of different parameters; draw them in figures of their own")
    lines: list[Any] = []
    markers: list[Any] = []
    texts: list[Any] = []
    with styled():
        ax = axes(ax)
        known: dict[str, Any] = {}
        met: list[tuple[str, tuple[float, float]]] = []
        for table in tables:
            colour, dashes = LINES[table.attrs["type"]]
            good = table["admissible"].values == 1
            joined = ~good | np.append(~good[1:], False) | np.append(False, ~good[:-1])  # no gap between the two
            thick = good | np.append(False, good[:-1])  # as far as the next point
            for kept, width in ((thick, 1.3), (joined, 0.5))[: 1 + virtual]:
                at = [np.where(kept, table[n].values, np.nan) for n in (x, y)]
                lines += ax.plot(*at, color=colour, ls=dashes, lw=width, label=table.attrs["type"])
                known.setdefault(table.attrs["type"], lines[-1])
            for i, kind in enumerate(table["meeting_type"].values.astype(str).tolist()):
                flown = bool(table["meeting_admissible"].values[i])
                place = float(table[f"meeting_{x}"].values[i]), float(table[f"meeting_{y}"].values[i])
                if (not flown and not virtual) or any(kind == one and near(place, at, table) for one, at in met):
                    continue  # each once, though it lies on several loci
                met.append((kind, place))
                markers += ax.plot(*place, "o", ms=3.5, mfc="white", mec=INK, mew=0.8, zorder=6)
                if names:
                    said = kind if flown else f"{kind} (virtual)"
                    text = ax.annotate(said, place, xytext=(3.0, 3.0), textcoords="offset points", color=INK, zorder=7)
                    text.set_fontsize(6.5)
                    texts.append(text)
        spread(ax, texts, markers)
        ax.set(xlabel=symbol(tables[0][x]), ylabel=symbol(tables[0][y]))
        legend = ax.legend(handles=list(known.values()), labels=list(known), fontsize=6.5, loc="best")
    return {"figure": root(ax), "lines": lines, "markers": markers, "names": texts, "legend": legend}


def near(a: tuple[float, float], b: tuple[float, float], table: xr.Dataset) -> bool:
    """Whether two meetings are drawn at one place."""
    spans = [float(np.ptp(table[name].values)) for name in json.loads(table.attrs["parameters"])]
    return all(abs(x - y) <= 1e-6 * span for x, y, span in zip(a, b, spans, strict=True))


def table_of(one: Any) -> xr.Dataset:
    """Return the table of a locus, or refuse what is none."""
    from grazing.late import xarray as xr

    table = one if isinstance(one, xr.Dataset) else getattr(one, "dataset", None)
    if not isinstance(table, xr.Dataset) or "meeting_type" not in table:
        raise InputError(f"no locus can be drawn from this {type(one).__name__}; give what gz.locus returns")
    return table
