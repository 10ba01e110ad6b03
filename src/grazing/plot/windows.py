"""Windows of periodic orbits beside a diagram: shaded in it and named above it, overlaps visible."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Rectangle
from matplotlib.transforms import Affine2D, ScaledTranslation, Transform, blended_transform_factory

from grazing.outcome import InputError
from grazing.plot.drawn import inline
from grazing.plot.style import DOUBLE, axes, ink_on, note, period_colour, root, styled, unit_of

#: Height of a bar, distance of rows and place of the lowest one, in points above the axes.
BAR, ROW, FIRST = 9.0, 10.5, 4.0
#: Overlap of two bars, as a share of the axes, beyond which it is seen.
SEEN = 1e-3


@inline
def windows(
    edges: Mapping[int, tuple[float, float]] | Any,
    ax: Axes | None = None,
    *,
    shade: float = 0.12,
    names: bool = True,
    narrowest: float = 0.03,
    numbered: float = 0.013,
) -> dict[str, Any]:
    """Shade the windows of period N and name them above the axes, odd and even N in rows of their own.

    Of two bars of a row that would overlap, the later one goes up to the next row with room for it, whatever its N.

    Parameters
    ----------
    edges : xarray.Dataset or mapping of int to (low, high)
        The result of :func:`grazing.windows` (variables ``N``, ``low``, ``high``), or period and the two edges of
        its window; windows that are empty (low >= high) are left out.
    ax : matplotlib Axes, optional
        Its limits should be set before. Default: a new figure of the windows alone.
    shade : float
        Opacity of the bands in the diagram; 0 draws only the bars above it.
    names : bool
        Whether each bar carries its Omega_N.
    narrowest : float
        A bar narrower than this fraction of the axes has its number only.
    numbered : float
        A bar narrower than this fraction has no name at all.

    Returns
    -------
    dict
        ``bars``, ``bands`` and ``names``, each a mapping from N (of several windows of one N the widest); ``figure``.

    Raises
    ------
    InputError
        For anything else.
    """
    bars: dict[int, Any] = {}
    bands: dict[int, Any] = {}
    texts: dict[int, Any] = {}
    with styled():
        of_its_own = ax is None
        ax = alone(edges) if ax is None else ax
        left, right = sorted(ax.get_xlim())
        to_axes = ax.transScale + ax.transLimits  # also on a logarithmic axis
        above = across(ax)
        taken: list[tuple[int, float, float]] = []
        for (N, low, high), word in zip(rows_of(edges), words_of(edges), strict=True):
            a, b = max(min(low, high), left), min(max(low, high), right)
            if low >= high or a >= b:
                continue
            left_end, right_end = sorted(float(x) for x in to_axes.transform([(a, 1.0), (b, 1.0)])[:, 0])
            place = N % 2
            while any(at == place and min(right_end, y) - max(left_end, x) > SEEN for at, x, y in taken):
                place += 1
            taken.append((place, left_end, right_end))
            colour, row = period_colour(N), FIRST + ROW * place
            bars[N] = ax.add_patch(
                Rectangle((a, row), b - a, BAR, transform=above, facecolor=colour, lw=0, clip_on=False, zorder=4)
            )
            if shade > 0.0:
                bands[N] = ax.axvspan(a, b, color=colour, alpha=shade, lw=0, zorder=0)
            share = right_end - left_end
            if names and share > numbered:
                text = word or (rf"$\Omega_{{{N}}}$" if share > narrowest else f"{N}")
                texts[N] = ax.text(
                    float(to_axes.inverted().transform((0.5 * (left_end + right_end), 0.5))[0]),
                    row + 0.5 * BAR - 0.3,
                    text,
                    transform=above,
                    color=ink_on(colour),
                    ha="center",
                    va="center",
                    fontsize=7.0,
                    zorder=6,
                    clip_on=False,
                )
        if of_its_own:
            note(ax, "" if bars else "no window")
            more = max((place - 1 for place, _left, _right in taken), default=0)
            root(ax).set_figheight(root(ax).get_figheight() + max(more, 0) * ROW / 72.0)
    return {"figure": root(ax), "bars": bars, "bands": bands, "names": texts}


def alone(edges: Any) -> Axes:
    """Return new axes over the range that was searched, or over what the windows take of it."""
    ax = axes(None, DOUBLE, 30.0)
    ends = [end for _N, low, high in rows_of(edges) if low < high for end in (low, high)]
    low, high = getattr(edges, "attrs", {}).get("span", (-np.inf, np.inf))
    if ends:  # most of a default range holds no window
        room = 0.05 * (max(ends) - min(ends))
        low, high = max(low, min(ends) - room), min(high, max(ends) + room)
    if np.isfinite(low) and np.isfinite(high):
        ax.set_xlim(low, high)
    ax.set_yticks([])
    ax.spines["left"].set_visible(False)
    if "parameter" in getattr(edges, "attrs", {}):
        shown = str(edges["low"].attrs.get("symbol", edges.attrs["parameter"]))
        ax.set_xlabel(f"${shown}${unit_of(edges['low'])}")
    return ax


def rows_of(edges: Any) -> list[tuple[int, float, float]]:
    """Return (N, low, high) of all windows, those of one N by width, or refuse what has another shape."""
    from grazing.late import xarray as xr

    try:
        if isinstance(edges, xr.Dataset):
            columns = [np.atleast_1d(edges[name].values).tolist() for name in ("N", "low", "high")]
            rows = list(zip(*columns, strict=True))
        else:
            rows = [(N, low, high) for N, (low, high) in edges.items()]
        plain = [(int(N), float(low), float(high)) for N, low, high in rows]
    except (AttributeError, KeyError, TypeError, ValueError):
        raise InputError(
            f"windows cannot be drawn from this {type(edges).__name__}; allowed are the xarray.Dataset that "
            "grazing.windows returns (variables N, low, high) and a mapping from N to (low, high)"
        ) from None
    return sorted(plain, key=lambda row: (row[0], row[2] - row[1]))


def words_of(edges: Any) -> list[str]:
    """Return the walls that the orbits of windows hit, in the order of :func:`rows_of`; nothing over one wall."""
    from grazing.late import xarray as xr

    rows = rows_of(edges)
    if not isinstance(edges, xr.Dataset) or "word" not in edges:
        return [""] * len(rows)
    known = {
        (int(N), float(low), float(high)): str(word)
        for N, low, high, word in zip(*(edges[name].values for name in ("N", "low", "high", "word")), strict=True)
    }
    return [known[row] for row in rows]


def across(ax: Axes) -> Transform:
    """Return the transform whose x is that of the data and whose y counts points above the axes."""
    assert ax.figure is not None
    points = Affine2D().scale(1.0 / 72.0) + ax.figure.dpi_scale_trans
    top = ScaledTranslation(0.0, 1.0, ax.transAxes)  # type: ignore[arg-type]  # the axes' own transform is affine
    return blended_transform_factory(ax.transData, points + top)
