"""Basins of attraction: which attractor each initial state reaches."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgba_array
from matplotlib.lines import Line2D
from matplotlib.patheffects import withStroke
from numpy.typing import NDArray

from grazing.outcome import InputError, Outcome
from grazing.plot.classes import attractor_colours, class_name, legend_beside, order_of, patch, rows_beside
from grazing.plot.drawn import inline
from grazing.plot.expected import expect
from grazing.plot.provenance import provenance_of
from grazing.plot.raster import axes_along, edges_of, name_single, ordered, raster
from grazing.plot.style import GRAZE, INK, plain, root, styled, symbol

Floats = NDArray[np.float64]

#: Entries of a legend; smaller basins are summed up.
LISTED = 14


@inline
def basins(
    result: Any, ax: Axes | None = None, *, points: bool = True, graze: int | None = None, legend: bool | None = None
) -> dict[str, Any]:
    """Draw basins of attraction; those of a map with one coordinate as a strip.

    Parameters
    ----------
    result : xarray.Dataset
        From :func:`grazing.basins`: ``basin`` on one or two coordinates, and the table ``period``, ``word``,
        ``fraction`` (and ``point``) on "attractor".
    ax : matplotlib Axes, optional
        Default: a new figure between one and two columns wide.
    points : bool
        Whether one point of each attractor is marked.
    graze : int, optional
        Preimages of the grazing curve up to this order are drawn, 0 for the curve alone, -1 for nothing; default:
        all that the result has.
    legend : bool, optional
        Whether a legend with word, period and share of the area stands beside the basins, None for one in a figure of
        its own only. Ways out of a table stand there by their names.

    Returns
    -------
    dict
        ``image``, ``colours`` (attractor to colour), ``points`` (attractor to line), ``graze`` (order to line),
        ``legend`` (or None), ``provenance``, ``figure``.

    Raises
    ------
    InputError
        For another kind of result.
    """
    shape = getattr(result.get("basin"), "dims", ()) if hasattr(result, "get") else ()
    grid = ("<coordinate>",) if len(shape) == 1 else ("<first coordinate>", "<second coordinate>")
    table = {"period": ("attractor",), "word": ("attractor",), "fraction": ("attractor",)}
    names = expect(result, "basins", {"basin": grid, **table})
    period = [int(value) for value in result["period"].values]
    axis_values = [ordered(result[name].values) for name in names]
    index = np.asarray(result["basin"].values)[np.ix_(*(where for _values, where in axis_values))].astype(np.intp)
    if index.min() < 0 or index.max() >= len(period):
        raise InputError(
            f"plot.basins finds basin from {index.min()} to {index.max()} in a table of {len(period)}; "
            "allowed are the numbers of its rows"
        )
    colours = _colours(period, np.asarray(result["fraction"].values, np.float64))
    with styled():
        ax = axes_along(ax, 130.0, 90.0 if len(names) == 2 else 32.0, *(values for values, _where in axis_values))
        edges = [edges_of(values, axis) for (values, _), axis in zip(axis_values, (ax.xaxis, ax.yaxis), strict=False)]
        if len(names) == 1:
            edges, index = [edges[0], np.array([0.0, 1.0])], index[:, None]
        table_of_colours = np.round(255.0 * to_rgba_array(colours)).astype(np.uint8)
        image = raster(ax, edges[0], edges[1], table_of_colours[index])
        lines = _graze(ax, result, names, graze)
        dots = _points(ax, result, names, colours) if points else {}
        ax.set(xlim=(edges[0][0], edges[0][-1]), ylim=(edges[1][0], edges[1][-1]))
        for axis, (values, _where) in zip((ax.xaxis, ax.yaxis), axis_values, strict=False):
            name_single(axis, values)
        ax.set_xlabel(symbol(result[names[0]]))
        if len(names) == 2:
            ax.set_ylabel(symbol(result[names[1]]))
        else:
            ax.set_yticks([])
            ax.spines["left"].set_visible(False)
        beside = legend_beside(ax, _entries(ax, result, colours, lines, dots), _title(result)) if legend else None
    return {
        "figure": root(ax),
        "image": image,
        "colours": dict(enumerate(colours)),
        "points": dots,
        "graze": lines,
        "legend": beside,
        "provenance": provenance_of(result),
    }


def _colours(period: list[int], fraction: Floats) -> list[str]:
    """Return the colours of the attractors: of several with one period the largest basin has its full colour."""
    by_size = sorted(range(len(period)), key=lambda k: -float(fraction[k]))
    given = dict(zip(by_size, attractor_colours([period[k] for k in by_size]), strict=True))
    return [given[k] for k in range(len(period))]


def _columns(result: Any, variable: str, names: tuple[str, ...]) -> list[Floats]:
    """Return the components of points along the axes; across a strip all lie in the middle."""
    points = result[variable]
    columns = [np.asarray(points.sel(coordinate=name).values, np.float64) for name in names]
    return columns if len(names) == 2 else [*columns, np.full_like(columns[0], 0.5)]


def _points(ax: Axes, result: Any, names: tuple[str, ...], colours: list[str]) -> dict[int, Any]:
    if "point" not in result:
        return {}
    x, y = _columns(result, "point", names)
    rim = [withStroke(linewidth=2.6, foreground=INK)]
    look: dict[str, Any] = {
        "ls": "none",
        "marker": "o",
        "ms": 4.2,
        "mew": 1.1,
        "mec": "white",
        "zorder": 6,
        "clip_on": True,
    }
    return {
        k: ax.plot(x[k], y[k], mfc=colours[k], path_effects=rim, **look)[0]
        for k in range(len(colours))
        if np.isfinite(x[k]) and np.isfinite(y[k])
    }


def _graze(ax: Axes, result: Any, names: tuple[str, ...], highest: int | None) -> dict[int, Any]:
    """Draw the grazing curve and its preimages, thinner and fainter with their order."""
    if "graze" not in result or "graze_order" not in result or not result.sizes.get("graze_point", 0):
        return {}
    x, y = _columns(result, "graze", names)
    order = np.asarray(result["graze_order"].values)
    drawn: dict[int, Any] = {}
    for k in sorted({int(value) for value in order}):
        if highest is not None and k > highest:
            continue
        chosen = np.flatnonzero(order == k)
        # a piece ends at NaN, and where points of another order stand between
        broken = np.flatnonzero(np.diff(chosen) > 1) + 1
        column = [np.insert(values[chosen], broken, np.nan) for values in (x, y)]
        fade = 0.8**k
        rim = [withStroke(linewidth=(0.9 + 1.2) * fade**0.5, foreground="white", alpha=0.75 * fade)]
        look: dict[str, Any] = {"color": GRAZE, "alpha": max(fade, 0.2), "zorder": 5 - 0.01 * k, "path_effects": rim}
        if len(names) == 2:
            (drawn[k],) = ax.plot(*column, lw=0.9 * fade**0.5, **look)
        else:
            (drawn[k],) = ax.plot(column[0], column[1], ls="none", marker="|", ms=16.0 * fade**0.5, mew=0.9, **look)
    return drawn


def _entries(ax: Axes, result: Any, colours: list[str], lines: dict[int, Any], dots: dict[int, Any]) -> list[Any]:
    period, fraction = (result[name].values.tolist() for name in ("period", "fraction"))
    words = [str(word) for word in result["word"].values]
    ways = ways_out(result)
    called = [
        plain(word.strip("()")) if out else class_name(word, n)
        for word, n, out in zip(words, period, ways, strict=True)
    ]
    idle = result["neutral"].values.tolist() if "neutral" in result else [0] * len(words)
    largest = sorted(range(len(colours)), key=lambda k: -fraction[k])
    marked = any(_seen(ax, dot) for dot in dots.values())
    room = min(LISTED, rows_beside(ax) - 2 * bool(lines) - marked)
    listed = largest if len(largest) <= room else largest[: max(room, 2) - 1]
    entries: list[Any] = [
        patch(colours[k], f"{called[k]}{', neutral' * idle[k]}: {percent(fraction[k])}")
        for k in sorted(listed, key=lambda k: (*order_of(period[k]), -fraction[k]))
    ]
    rest = largest[len(listed) :]
    if rest:
        entries.append(patch("none", f"{len(rest)} more: {percent(sum(fraction[k] for k in rest))}", edgecolor="none"))
    if lines:
        entries.append(Line2D([], [], color=GRAZE, lw=0.9, label="grazing curve"))
        if max(lines) > 0:
            last = max(lines)
            name = "its preimage" if last == 1 else f"its preimages, orders 1 to {last}"
            entries.append(Line2D([], [], color=GRAZE, lw=0.7, alpha=0.45, label=name))
    if marked:
        look: dict[str, Any] = {"ls": "none", "marker": "o", "ms": 4.2, "mfc": "white", "mec": INK, "mew": 0.8}
        entries.append(Line2D([], [], label="a point of the attractor", **look))
    return entries


def _seen(ax: Axes, dot: Any) -> bool:
    """Say whether a dot lies within the axes."""
    (x,), (y,) = dot.get_data()
    ends = *sorted(ax.get_xlim()), *sorted(ax.get_ylim())
    return bool(ends[0] <= x <= ends[1] and ends[2] <= y <= ends[3])


def ways_out(result: Any) -> list[bool]:
    """Say which attractors are ways out of a table: every ball that reaches one has escaped, and stays there."""
    period, basin = result["period"].values, result["basin"].values
    if "outcome" not in result:
        return [False] * len(period)
    stayed = np.broadcast_to(result["outcome"].values & int(Outcome.escaped) == 0, basin.shape)
    inside = {*np.unique(basin[stayed]).tolist()}
    return [int(period[k]) == 1 and k not in inside for k in range(len(period))]


def _title(result: Any) -> str:
    """Return what the entries of the legend say."""
    ways, period = ways_out(result), result["period"].values.tolist()
    others = any(n > 0 and not out for n, out in zip(period, ways, strict=True))
    kinds = ["way out"] * any(ways) + ["word, period"] * (others or not any(ways))
    return f"{' or '.join(kinds)}: share of the area"


def percent(share: float) -> str:
    """Return a share as a percentage with three digits, never rounded to nothing or to all.

    Examples
    --------
    >>> from grazing.plot.basins import percent
    >>> percent(0.5), percent(0.12345), percent(0.00123), percent(0.0), percent(1e-6)
    ('50 %', '12.3 %', '0.12 %', '0 %', '< 0.01 %')
    """
    if 0.0 < share < 1e-4:
        return "< 0.01 %"
    shown = 100.0 * share
    return f"{round(shown, 1 if shown >= 1.0 else 2):g} %"
