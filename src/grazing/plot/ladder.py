"""The ladder of reductions: errors of windows rung by rung, or the windows themselves as bars."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Rectangle
from matplotlib.ticker import FuncFormatter, NullFormatter
from numpy.typing import NDArray

from grazing.outcome import InputError
from grazing.plot.classes import legend_beside
from grazing.plot.drawn import inline
from grazing.plot.expected import choice, expect
from grazing.plot.provenance import provenance_of
from grazing.plot.style import INK, axes, ink_on, label, period_colour, root, styled, unit_of

Floats = NDArray[np.float64]

#: Colour and marker of each rung; lightness falls from the gap map to the flow.
LOOKS = {
    "gap": ("#e69f00", "o"),
    "linearised": ("#5cbceb", "s"),
    "lowest": ("#d1495b", "^"),
    "full": ("#7a4a12", "v"),
    "corrected": ("#00624a", "D"),
    "flow": (INK, "x"),
}
#: What the rungs are called in figures.
CALLED = {
    "gap": "gap map",
    "linearised": "linearised map",
    "lowest": "lowest order",
    "full": "full order",
    "corrected": "corrected",
    "flow": "flow",
}
EDGE = {"low": "lower", "high": "upper"}
#: Share of a row that its bars take; the least share of the width at which a bar carries its number.
THICK, NAMED = 0.72, 0.035


@inline
def ladder(
    result: Any,
    ax: Axes | None = None,
    *,
    by: str = "error",
    side: str = "high",
    against: str = "distance",
    legend: bool = True,
) -> dict[str, Any]:
    """Draw what each reduction does to the windows of one-impact orbits.

    Parameters
    ----------
    result : xarray.Dataset
        From :func:`grazing.ladder`.
    ax : matplotlib Axes, optional
        Default: a new figure of one column, or between one and two with a legend beside.
    by : {"error", "step", "windows"}
        The errors of the edges, the steps that they are made of, with the measured orders in the legend; or the
        windows as bars, one row a rung.
    side : {"low", "high"}
        Of the windows, for errors and steps.
    against : {"distance", "N"}
        Abscissa of errors and steps: the distance of the flow's edge from the graze, on a logarithmic axis, or N.
    legend : bool
        Whether the legend of errors and steps stands beside the axes; else a smaller one is inside.

    Returns
    -------
    dict
        ``lines`` and ``zeros`` (rung to line; what is 0 is hollow, on the lower edge), or ``bars`` ((rung, N) to
        rectangle), ``legend``, ``provenance``, ``figure``.

    Raises
    ------
    InputError
        For another kind of result, another choice, or a result without a single error.
    """
    dims = ("rung", "N", "side")
    expect(
        result, "ladder", {"edge": dims, "error": dims, "step": dims, "distance": dims[1:], "order": (dims[0], "side")}
    )
    choice(by, "by", ("error", "step", "windows"))
    choice(side, "side", ("low", "high"))
    choice(against, "against", ("distance", "N"))
    with styled():
        ax = axes(ax, *((85.0, 68.0) if by == "windows" else (120.0, 68.0)))
        drawn = _bars(ax, result) if by == "windows" else _errors(ax, result, by, side, against, legend)
    return {"figure": root(ax), **drawn, "provenance": provenance_of(result)}


def _errors(ax: Axes, result: Any, by: str, side: str, against: str, legend: bool) -> dict[str, Any]:
    sizes = np.abs(result[by].sel(side=side).values)
    x = result["distance"].sel(side=side).values if against == "distance" else result["N"].values
    lines: dict[str, Any] = {}
    zeros: dict[str, Any] = {}
    name = "order" if by == "error" else "step_order"
    for rung, size in zip(result["rung"].values.tolist(), sizes, strict=True):
        known = np.isfinite(size) & np.isfinite(x)
        if rung == "flow" or not known.any():
            continue
        good, none = known & (size > 0.0), known & (size == 0.0)
        colour, marker = LOOKS[rung]
        text = CALLED[rung]
        order, error = (result[key].sel(rung=rung, side=side).item() for key in (name, f"{name}_error"))
        if np.isfinite(order):
            text += f"  {_with_error(order, error)}"
        (lines[rung],) = ax.plot(
            x[good], size[good], color=colour, marker=marker, ms=3.6, mew=0.5, mec="white", lw=0.9, label=text
        )
        if none.any():
            edge: dict[str, Any] = {"transform": ax.get_xaxis_transform(), "clip_on": False, "zorder": 3}
            (zeros[rung],) = ax.plot(
                x[none], np.zeros(none.sum()), marker, ms=3.6, mew=0.7, mfc="white", mec=colour, label="0", **edge
            )
    if not lines:
        raise InputError(
            f"plot.ladder finds no {by} on the {side} side: the flow or the reductions have no window; see 'status'"
        )
    ax.set_yscale("log")
    parameter = str(result.attrs.get("parameter", ""))
    symbol = label(parameter, result["edge"].attrs.get("symbol")) + unit_of(result["edge"])
    if against == "distance":
        ax.set_xscale("log")
        ax.set_xlabel(f"distance of the {EDGE[side]} edge from the graze, in {symbol}")
    else:
        ax.set_xlabel("periods between impacts, $N$")
        ax.set_xticks(result["N"].values)
    what = f"error of the {EDGE[side]} edge" if by == "error" else "step to the next rung"
    ax.set_ylabel(f"{what}, in {symbol}")
    ax.grid(True, which="major", color="#e6e6e6", lw=0.4)
    ordered = sorted(lines.values(), key=lambda line: -float(np.append(0.0, line.get_ydata())[-1]))  # as the lines end
    ordered += list(zeros.values())[:1]
    if not legend:
        small = ax.legend(handles=ordered, loc="best", fontsize=6.5, handlelength=1.4, labelspacing=0.25)
        return {"lines": lines, "zeros": zeros, "legend": small}
    measured = any("  " in str(line.get_label()) for line in ordered)
    return {"lines": lines, "zeros": zeros, "legend": legend_beside(ax, ordered, "rung, order" if measured else "rung")}


def _with_error(value: float, error: float) -> str:
    """Return a number with its uncertainty in the last digits, such as 1.98(3)."""
    if not 0.0 < error < 1.0:
        return f"{value:.1f}" if error >= 1.0 else f"{value:.3f}"
    digits = min(3, max(1, -int(np.floor(np.log10(error)))))
    return f"{value:.{digits}f}({max(1, round(error * 10**digits))})"


def _bars(ax: Axes, result: Any) -> dict[str, Any]:
    edge, graze = result["edge"].values, float(result["graze"] if "graze" in result else result.attrs["graze"])
    away = edge - graze
    known = away[np.isfinite(away)]
    if not known.size:
        raise InputError("plot.ladder finds no window on any rung; see the variable 'status' of the result")
    one_side = bool((known < 0.0).all() or (known > 0.0).all())
    at = np.abs(away) if one_side else edge
    rungs = result["rung"].values.tolist()
    symbol = label(str(result.attrs.get("parameter", "")), result["edge"].attrs.get("symbol"))
    symbol += unit_of(result["edge"])
    flow = at[-1][np.isfinite(at[-1])]
    seen = flow if flow.size else at[np.isfinite(at)]
    if one_side:
        ax.set_xscale("log")
        ax.set_xlim(
            *((1.8 * seen.max(), seen.min() / 1.4) if (known < 0.0).all() else (seen.min() / 1.4, 1.8 * seen.max()))
        )
        ax.set_xlabel(f"distance from the graze, in {symbol}")
    else:
        reach = 0.08 * float(np.ptp(seen))
        ax.set(xlim=(seen.min() - reach, seen.max() + reach), xlabel=symbol)
    ax.set_ylim(len(rungs) - 0.4, -0.6)
    ends = sorted(ax.get_xlim())
    to_axes = ax.transScale + ax.transLimits
    bars: dict[Any, Any] = {}
    for i, rung in enumerate(rungs):
        for n, N in enumerate(result["N"].values.tolist()):
            if np.isnan(at[i, n]).all():
                continue
            # an edge beyond all numbers reaches to the end
            low, high = sorted(np.where(np.isnan(at[i, n]), ends[1], at[i, n]).tolist())
            left, right = max(low, ends[0]), min(high, ends[1])
            if left >= right:
                continue
            colour, row = period_colour(N), i - 0.5 * THICK + (0.5 * THICK if N % 2 else 0.0)
            bars[rung, N] = ax.add_patch(
                Rectangle((left, row), right - left, 0.46 * THICK, facecolor=colour, lw=0, zorder=2)
            )
            pair = to_axes.transform([(left, 0.0), (right, 0.0)])[:, 0]
            if abs(float(pair[1] - pair[0])) > NAMED:
                middle = float(to_axes.inverted().transform((float(pair.mean()), 0.0))[0])
                place = {"color": ink_on(colour), "ha": "center", "va": "center", "fontsize": 6.0, "zorder": 3}
                ax.text(middle, row + 0.235 * THICK, f"{N}", **place)  # type: ignore[arg-type]
    ax.set_yticks(range(len(rungs)), [CALLED[rung] for rung in rungs])
    ax.tick_params(axis="y", length=0)
    ax.spines["left"].set_visible(False)
    if one_side:
        ax.xaxis.set_minor_formatter(NullFormatter())
    else:
        ax.axvline(graze, color=LOOKS["lowest"][0], lw=0.8, ls=(0, (5, 2)), zorder=1)
        ax.xaxis.set_major_formatter(FuncFormatter(lambda x, _place: f"{x:g}".replace("-", "\N{MINUS SIGN}")))
    return {"bars": bars, "legend": None}
