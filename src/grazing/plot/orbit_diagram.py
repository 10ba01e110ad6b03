"""Orbit diagram: where orbits settle as one parameter varies, coloured by period."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.transforms import IdentityTransform
from numpy.typing import NDArray

from grazing.plot.classes import ENDED, legend_beside, patch, patches_of, tell_ends
from grazing.plot.drawn import inline
from grazing.plot.expected import choice, expect
from grazing.plot.provenance import provenance_of
from grazing.plot.raster import axes_along, bands_of, edges_of, ordered
from grazing.plot.style import CHAOS, DOUBLE, period_colour, root, styled, symbol
from grazing.plot.words import worded, words_in

#: Points closer than this fraction of the axis are one point: below a pixel in print.
GRAIN = 1 / 2400
#: Room beside the first and the last column, as shares of the axis: a point is seen whole, and no more than that.
LEAST, MOST = 0.003, 0.02


@inline
def orbit_diagram(
    result: Any,
    ax: Axes | None = None,
    coordinate: str | None = None,
    *,
    by: str = "period",
    size: float = 1.1,
    longest: int = 24,
    legend: bool | None = None,
) -> dict[str, Any]:
    """Draw an orbit diagram; orbits of period N in the colour of N, all others in grey.

    Of an orbit of period N the last N points are drawn: those before may not have arrived at its cycle yet. Ranges in
    which every orbit ended are shaded, and the legend says why.

    Parameters
    ----------
    result : xarray.Dataset
        From :func:`grazing.orbit_diagram`.
    ax : matplotlib Axes, optional
        Default: a new figure two columns wide.
    coordinate : str, optional
        Which coordinate is shown; default: the first variable.
    by : {"period", "word"}
        What colours tell apart: periods, or words, such as orbits of period 1 with and without impacts.
    size : float
        Diameter of a point in points.
    longest : int
        Longer periods are drawn in grey.
    legend : bool, optional
        Whether a legend of the periods stands beside the axes; None for one in a figure of its own only.

    Returns
    -------
    dict
        ``points``: mapping from period (0: none), or from word ("": none), to a line without strokes, rasterised in
        vector files; ``ended`` (a list of shaded ranges); ``legend``, or None; ``provenance``, ``figure``.

    Raises
    ------
    InputError
        For another kind of result, or ``by``.
    """
    choice(by, "by", ("period", "word"))
    needed = {name: ("<parameter>", "start") for name in dict.fromkeys(("period", by))}
    expect(result, "orbit_diagram", needed)
    seen = [str(key) for key, variable in result.data_vars.items() if variable.ndim == 3]
    shown = choice(seen[0] if coordinate is None and seen else coordinate, "coordinate", seen)
    name, _start, _n = result[shown].dims
    values = np.asarray(result[name].values, dtype=np.float64)
    y = np.asarray(result[shown].values)
    period = np.asarray(result["period"].values)
    arrived = np.arange(y.shape[2]) >= y.shape[2] - np.where(period >= 1, period, y.shape[2])[:, :, None]
    settled = y[arrived & np.isfinite(y)]
    grain = (float(np.ptp(settled)) if settled.size else 0.0) * GRAIN or 1.0
    drawn: dict[Any, Any] = {}
    beside = None
    with styled():
        ax = axes_along(ax, DOUBLE, 80.0, values)
        known = words_in(root(ax)) if by == "word" else None
        chosen, colours, entries = _classes(result, period, longest, known)
        for place, (key, those) in enumerate(chosen.items()):
            x, z = _thinned(values, y, those[:, :, None] & arrived, grain)
            (drawn[key],) = ax.plot(
                x,
                z,
                "o",
                ls="none",
                ms=size if key else 0.9 * size,
                mew=0,
                rasterized=True,
                color=colours[key],
                zorder=2.0 + 1.0 / (1 + place) if key else 1.9,
            )
        bands = [
            ax.axvspan(low, high, color=period_colour(ENDED), lw=0, zorder=0)
            for low, high in _ended(values, period, ax.xaxis)
        ]
        ax.set(xlim=ends_of(values, ax.xaxis), xlabel=symbol(result[name]), ylabel=symbol(result[shown]))
        if legend:
            tell_ends(entries, result)
            beside = legend_beside(ax, entries, by)
    return {
        "points": drawn, "ended": bands, "legend": beside, "figure": root(ax), "provenance": provenance_of(result)
    }  # fmt: skip


def ends_of(values: NDArray[Any], axis: Any = None) -> tuple[float, float]:
    """Return where an axis ends that shows the outermost columns whole: half a column beyond, but little of the axis.

    ``axis`` is the matplotlib axis whose scale says how far that is; a linear one unless given.

    Examples
    --------
    >>> import numpy as np
    >>> from grazing.plot.orbit_diagram import ends_of
    >>> ends_of(np.linspace(0.0, 1.0, 101)), ends_of(np.array([0.0, 1.0]))
    ((-0.005, 1.005), (-0.02, 1.02))
    """
    x, _order = ordered(values)
    if len(x) == 1:
        low, high = edges_of(x)
        return float(low), float(high)
    scale = IdentityTransform() if axis is None else axis.get_transform()
    at = scale.transform(x)
    span = at[-1] - at[0]
    beyond = np.clip([0.5 * (at[1] - at[0]), 0.5 * (at[-1] - at[-2])], LEAST * span, MOST * span)
    low, high = scale.inverted().transform(np.array([at[0] - beyond[0], at[-1] + beyond[1]]))
    return float(low), float(high)


def _ended(values: NDArray[Any], period: NDArray[Any], axis: Any) -> list[tuple[float, float]]:
    """Return the ranges of neighbouring values at which every orbit ended, to halfway to the next values."""
    x, order = ordered(values)
    return bands_of((period[order] == ENDED).all(axis=1), edges_of(x, axis), axis)


def _classes(
    result: Any, period: NDArray[Any], longest: int, known: dict[str, str] | None
) -> tuple[dict[Any, Any], dict[Any, str], list[Any]]:
    """Return which orbits belong to each period, 0 for those that are grey, the colours, and what the legend says.

    With the colours of words that are known the same by word, "" for those that are grey.
    """
    if known is not None:
        return _by_word(result, period, longest, known)
    shown = np.where((period >= 1) & (period <= longest), period, 0)
    chosen = {int(N): shown == N for N in np.unique(shown)}
    entries = patches_of([int(N) for N in np.unique(period) if N <= longest])
    if (period > longest).any():
        entries.append(patch(CHAOS, f"above {longest}"))
    return chosen, {N: period_colour(N) if N else CHAOS for N in chosen}, entries


def _by_word(
    result: Any, period: NDArray[Any], longest: int, known: dict[str, str]
) -> tuple[dict[Any, Any], dict[Any, str], list[Any]]:
    seen = np.where(period <= longest, period, -1)
    codes, words, colours, entries = worded(seen, result["word"].values, np.ones(period.shape), known)
    grey = (codes < 1) | (codes > len(words))
    chosen = {"": grey} if grey.any() else {}
    chosen |= {word: codes == i for i, word in enumerate(words, 1)}
    return chosen, {"": CHAOS} | {word: colours[i] for i, word in enumerate(words, 1)}, entries


def _thinned(
    values: NDArray[Any], y: NDArray[Any], chosen: NDArray[Any], step: float
) -> tuple[NDArray[Any], NDArray[Any]]:
    """Return the chosen points, those that fall on one another in print, nearer than a step, taken once."""
    index = np.broadcast_to(np.arange(values.size)[:, None, None], y.shape)
    kept = chosen & np.isfinite(y)
    low = y[kept].min(initial=np.inf)
    grain = np.round((y[kept] - low) / step).astype(np.int64)
    _unique, which = np.unique(index[kept] * 10_000_019 + grain, return_index=True)
    return values[index[kept][which]], y[kept][which]
