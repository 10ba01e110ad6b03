"""Chart of two parameters: which attractors there are in each cell."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LinearSegmentedColormap, TwoSlopeNorm, to_rgba_array
from matplotlib.patches import Patch
from matplotlib.ticker import FuncFormatter, MaxNLocator
from numpy.typing import NDArray

from grazing.plot.classes import UNUSED, legend_beside, patch, patches_of, tell_ends
from grazing.plot.curves import curves_of, lay_curves
from grazing.plot.drawn import inline
from grazing.plot.expected import choice, expect
from grazing.plot.provenance import provenance_of
from grazing.plot.raster import axes_along, edges_of, name_single, ordered, raster
from grazing.plot.stripes import striped
from grazing.plot.style import ENDED, INK, period_colour, root, styled, symbol
from grazing.plot.words import OTHERS, worded, words_in

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]

#: Exponents: stable is blue and light in grey, chaos is red and dark in grey, zero is white.
STABLE, CHAOTIC = ("#3f8fc4", "#a9d3ee", "#ffffff"), ("#ffffff", "#f3a582", "#c5372c", "#5e0018")
#: Exponents of minus infinity: completed chatter or sticking.
INFINITE = "#00335c"
#: Numbers of attractors from 1 on; 0 is ENDED.
HOW_MANY = ("#f7e8c6", "#f4b183", "#dd6b66", "#a53a78", "#5e2a7e", "#221331")


@inline
def chart(
    result: Any,
    ax: Axes | None = None,
    *,
    by: str = "period",
    stripes: bool = True,
    curves: Any = None,
    legend: bool | None = None,
) -> dict[str, Any]:
    """Draw a chart of two parameters.

    Parameters
    ----------
    result : xarray.Dataset
        From :func:`grazing.chart`: ``period``, ``share`` and ``exponent`` on (first parameter, second one, "rank").
    ax : matplotlib Axes, optional
        Default: a new figure between one and two columns wide.
    by : {"period", "word", "exponent", "attractors"}
        What is shown: the periods, each in its fixed colour; the words, so that orbits of one period
        with and without impacts are told apart; the largest Lyapunov exponent of the most common
        attractor; how many attractors there are.
    stripes : bool
        Whether attractors that coexist share a cell: diagonal stripes about 1.5 mm apart, whatever the size of the
        cells, as wide as their shares of the starts, so that the area of a colour is its share; a white line parts
        attractors of one colour. Else a cell has the colour of the most common one.
    curves : xarray.Dataset, Locus, Branch, list of them, or mapping of str to (x, y), optional
        What is laid on top: what :func:`grazing.boundaries` or :func:`grazing.locus` returns for these two parameters
        (of a locus the part on orbits that the map has), the stable part of a branch in one of them, or any curves;
        each name is written on its curve. By word, curves of orbits have the colours of their words.
    legend : bool, optional
        Whether a legend, or a colour bar for exponents, stands beside the chart; None for one in a figure of its own
        only.

    Returns
    -------
    dict
        ``image``, ``legend``, ``bar`` (each None where there is none), ``curves`` (name to (line, text)),
        ``provenance``, ``figure``.

    Raises
    ------
    InputError
        For another kind of result, or ``by``; for boundaries in other parameters.
    """
    plane = ("<first parameter>", "<second parameter>", "rank")
    choice(by, "by", ("period", "word", "exponent", "attractors"))
    needed = {"period": plane, "share": plane} | ({by: plane} if by in ("exponent", "word") else {})
    first, second, _rank = expect(result, "chart", needed)
    curves, words_of = curves_of(curves, result, first, second)
    (x_values, i), (y_values, j) = ordered(result[first].values), ordered(result[second].values)
    period, share = _shown(result, i, j)
    bar = beside = None
    own: dict[str, str] = {}
    with styled():
        ax = axes_along(ax, 120.0, 88.0, x_values, y_values)
        x, y = edges_of(x_values, ax.xaxis), edges_of(y_values, ax.yaxis)
        if by == "exponent":
            exponent = np.asarray(result["exponent"].values, np.float64)[i][:, j][..., 0]
            image, bar, beside = _exponents(ax, x, y, exponent, bool(legend))
        else:
            if by == "attractors":
                image, handles = _attractors(ax, x, y, period, share)
            elif by == "word":
                words = np.asarray(result["word"].values)[i][:, j][..., : period.shape[2]]
                shades = words_in(root(ax))
                codes, _words, colours, entries = worded(period, words, share, shades, words_of.values())
                own = {name: shades.get(word, OTHERS) for name, word in words_of.items()}
                image, handles = _classes(ax, x, y, codes, share, stripes, colours.__getitem__, lambda _codes: entries)
            else:
                image, handles = _classes(ax, x, y, period, share, stripes, period_colour, patches_of)
            tell_ends(handles, result)
            beside = legend_beside(ax, handles, by) if legend else None
        drawn = lay_curves(ax, curves, own)
        name_single(ax.xaxis, x_values)
        name_single(ax.yaxis, y_values)
        ax.set(xlabel=symbol(result[first]), ylabel=symbol(result[second]))
    return {
        "figure": root(ax),
        "image": image,
        "legend": beside,
        "bar": bar,
        "curves": drawn,
        "provenance": provenance_of(result),
    }


def _shown(result: xr.Dataset, i: NDArray[np.intp], j: NDArray[np.intp]) -> tuple[NDArray[Any], Floats]:
    """Return periods and shares in order, with no more ranks than some cell has attractors.

    There are as many ranks as starts, and most of them are empty everywhere: colouring them would take many times the
    memory of the result.
    """
    period, share = (np.asarray(result[name].values) for name in ("period", "share"))
    missing = ~np.asarray(result["done"].values, bool) if "done" in result else np.zeros(period.shape[:2], bool)
    ranks = range(period.shape[2])
    used = [k for k in ranks if ((share[..., k] > 0.0) & (period[..., k] != UNUSED) & ~missing).any()]
    last = max(used, default=0) + 1
    period, share = period[..., :last][i][:, j], share[..., :last][i][:, j]
    missing = missing[i][:, j]
    period[missing], share[missing] = UNUSED, 0.0  # of a sweep that is not complete: it stays white
    return period, share


def _classes(
    ax: Axes,
    x: Floats,
    y: Floats,
    period: NDArray[Any],
    share: NDArray[Any],
    stripes: bool,
    colour_of: Callable[[int], str],
    entries_of: Callable[[list[int]], list[Patch]],
) -> tuple[Any, list[Any]]:
    """Show the classes of orbits in each cell; those that have a period are numbered from 1 on."""
    used = (share > 0.0) & (period != UNUSED)
    used[..., 0] = True  # the most common one is shown in any case
    if not stripes:
        period, share, used = period[..., :1], share[..., :1], used[..., :1]
    codes, where = np.unique(np.where(used, period, UNUSED), return_inverse=True)
    table = to_rgba_array([colour_of(int(code)) if code != UNUSED else "#ffffff" for code in codes])
    colours = np.round(255.0 * table).astype(np.uint8)
    index = where.reshape(period.shape)
    several = used.sum(axis=-1) > 1
    handles: list[Any] = list(entries_of(codes.tolist()))
    if not several.any():
        return raster(ax, x, y, colours[index[..., 0]]), handles
    fine_x, fine_y, cells = striped(ax, x, y, index, np.where(used, share, 0.0), codes, colours)
    handles.append(patch("white", "coexisting, by\nshare of starts", hatch="/////"))
    return raster(ax, fine_x, fine_y, cells, smooth=True), handles


def _attractors(ax: Axes, x: Floats, y: Floats, period: NDArray[Any], share: NDArray[Any]) -> tuple[Any, list[Any]]:
    """Show how many attractors there are; undecided and ended orbits are none."""
    many = ((share > 0.0) & ((period >= 1) | (period == -1))).sum(axis=-1)
    most = len(HOW_MANY)
    colours = np.round(255.0 * to_rgba_array([ENDED, *HOW_MANY])).astype(np.uint8)
    shown = np.minimum(many, most)
    handles = [
        patch((ENDED, *HOW_MANY)[n], f"{n} or more" if n == most and many.max() > most else f"{n}" if n else "none")
        for n in np.unique(shown).tolist()
    ]
    return raster(ax, x, y, colours[shown]), handles


def _exponents(ax: Axes, x: Floats, y: Floats, exponent: Floats, legend: bool) -> tuple[Any, Any, Any]:
    finite = exponent[np.isfinite(exponent)]
    # a few cells may lie beyond the ends: one close to a graze would take the colours from all others
    high = float(np.quantile(finite[finite > 0.0], 0.98)) if (finite > 0.0).any() else 0.0
    low = float(np.quantile(finite[finite < 0.0], 0.01)) if (finite < 0.0).any() else 0.0
    reach = max(high, -low) or 1.0
    # each side has a slope of its own, else weak chaos is white beside strong stability
    low, high = min(low, -0.05 * reach), max(high, 0.05 * reach)
    norm = TwoSlopeNorm(0.0, low, high)
    half = [(k / 4.0, colour) for k, colour in enumerate(STABLE)]
    rest = [(0.5 + k / 6.0, colour) for k, colour in enumerate(CHAOTIC)]
    cmap = LinearSegmentedColormap.from_list("exponent", half + rest[1:], N=512)
    cells = cmap(norm(np.where(np.isfinite(exponent), exponent, 0.0)))
    cells[np.isnan(exponent)] = to_rgba_array(ENDED)
    cells[np.isneginf(exponent)] = to_rgba_array(INFINITE)
    image = raster(ax, x, y, np.round(255.0 * np.asarray(cells)).astype(np.uint8))
    if not legend:
        return image, None, None
    scale = ScalarMappable(norm, cmap)
    ends = np.isfinite(exponent) & (exponent < low), exponent > high
    beyond = bool(ends[1].any()), bool(ends[0].any())
    extend = {(True, True): "both", (True, False): "max", (False, True): "min"}.get(beyond, "neither")
    bar = root(ax).colorbar(scale, ax=ax, pad=0.02, fraction=0.06, aspect=26, extend=extend)
    bar.outline.set_linewidth(0.4)
    sides = [MaxNLocator(4, steps=[1, 2, 5, 10]).tick_values(*side) for side in ((low, 0.0), (0.0, high))]
    bar.set_ticks([float(tick) for tick in np.unique(np.concatenate(sides)) if low <= tick <= high])
    bar.set_label("largest exponent per step")
    bar.ax.yaxis.set_major_formatter(FuncFormatter(lambda tick, _place: f"{tick:g}".replace("-", "\N{MINUS SIGN}")))
    bar.ax.axhline(0.0, color=INK, lw=0.5)
    special: list[tuple[Any, str, str]] = [
        (np.isneginf, INFINITE, "−∞: chatter or rest"),
        (np.isnan, ENDED, "none: the orbit ended"),
    ]
    handles = [patch(colour, name) for test, colour, name in special if test(exponent).any()]
    place: dict[str, Any] = {"loc": "lower left", "bbox_to_anchor": (0.0, 1.0), "ncols": 2}
    return image, bar, legend_beside(ax, handles, **place) if handles else None
