"""The spectrum of a motion, over frequencies or orders."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes

from grazing.outcome import InputError, shown
from grazing.plot.drawn import inline
from grazing.plot.expected import expect
from grazing.plot.style import INK, axes, quantity, root, styled

#: Decades below the strongest line that are shown.
DECADES = 6.0


@inline
def spectrum(result: Any, ax: Axes | None = None, *, over: str = "frequency", colour: str = INK) -> dict[str, Any]:
    """Draw an amplitude spectrum, in decades.

    Parameters
    ----------
    result : xarray.Dataset
        From :func:`grazing.spectrum`.
    ax : matplotlib Axes, optional
        Default: a new figure one column wide.
    over : {"frequency", "order"}
        Orders count in the frequency of the forcing: period n has lines at multiples of 1/n.
    colour : str

    Returns
    -------
    dict
        ``lines`` (one line), ``figure``.
    """
    expect(result, "spectrum", {"amplitude": ("frequency",), "order": ("frequency",)})
    if over not in ("frequency", "order"):
        raise InputError(f"over = {shown(over)}; allowed are frequency and order")
    with styled():
        ax = axes(ax)
        x, y = np.asarray(result[over].values), np.asarray(result["amplitude"].values)
        top = float(y.max()) or 1.0
        (lines,) = ax.semilogy(x[1:], np.maximum(y[1:], top * 10.0**-DECADES), color=colour, lw=0.8)
        ax.set_xlim(0.0, x[-1])
        ax.set_ylim(top * 10.0**-DECADES, 2.0 * top)
        ax.set_xlabel(quantity(result[over]))
        ax.set_ylabel(quantity(result["amplitude"]))
    return {"figure": root(ax), "lines": lines}
