"""The spectrum of a motion, over frequencies or orders."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from grazing.plot.drawn import inline
from grazing.plot.expected import choice, expect
from grazing.plot.style import INK, axes, note, quantity, root, styled

#: Decades below the strongest line that are shown.
DECADES = 6.0
#: Frequencies are shown up to the last one with this share of the strongest line, and of the forcing's highest harmonic
#: no less and no more than these multiples: impacts put lines at all of them.
SHARE, LEAST, MOST = 1e-3, 4.0, 40.0
#: Room behind the last line.
ROOM = 1.05


@inline
def spectrum(
    result: Any, ax: Axes | None = None, *, over: str = "frequency", until: float | None = None, colour: str = INK
) -> dict[str, Any]:
    """Draw an amplitude spectrum, in decades.

    Parameters
    ----------
    result : xarray.Dataset
        From :func:`grazing.spectrum`.
    ax : matplotlib Axes, optional
        Default: a new figure one column wide.
    over : {"frequency", "order"}
        Orders count in the frequency of the forcing: period n has lines at multiples of 1/n.
    until : float, optional
        Last frequency, or order, that is shown. Default: of the last line that has a thousandth of the strongest one,
        and no more than 40 times the highest harmonic of the forcing.
    colour : str

    Returns
    -------
    dict
        ``lines`` (one line), ``figure``.
    """
    expect(result, "spectrum", {"amplitude": ("frequency",), "order": ("frequency",)})
    choice(over, "over", ("frequency", "order"))
    with styled():
        ax = axes(ax)
        x, y = np.asarray(result[over].values), np.asarray(result["amplitude"].values)
        top = float(y[1:].max()) or 1.0
        note(ax, "" if y[1:].any() else "all amplitudes are 0")
        (lines,) = ax.semilogy(x[1:], np.maximum(y[1:], top * 10.0**-DECADES), color=colour, lw=0.8)
        ax.set_xlim(0.0, last_of(result) * x[-1] if until is None else until)
        ax.set_ylim(top * 10.0**-DECADES, 2.0 * top)
        ax.set(xlabel=quantity(result[over]), ylabel=quantity(result["amplitude"]))
    return {"figure": root(ax), "lines": lines}


def last_of(result: Any) -> float:
    """Return how far a spectrum is shown, as a share of its last frequency."""
    order, y = np.asarray(result["order"].values), np.asarray(result["amplitude"].values)
    strong = np.flatnonzero(y >= SHARE * (float(y[1:].max(initial=0.0)) or np.inf))
    found = ROOM * float(order[strong[-1]]) if strong.size else 0.0
    harmonic = highest(result.attrs)
    return float(min(max(found, LEAST * harmonic), MOST * harmonic, order[-1]) / (order[-1] or 1.0))


def highest(attrs: Any) -> int:
    """Return the highest harmonic of the forcing that the attributes of a spectrum name."""
    waves = (re.fullmatch(r"parameter_(?:cos|sin)(\d+)", str(name)) for name, value in attrs.items() if value)
    return max((int(wave[1]) for wave in waves if wave), default=1)
