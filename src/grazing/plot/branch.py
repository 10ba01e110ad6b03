"""Branches: stable orbits solid, unstable dashed, virtual dotted, and special points named."""

from __future__ import annotations

import json
from itertools import pairwise
from textwrap import fill
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from grazing.compare.word_branches import loci_of
from grazing.outcome import InputError, shown
from grazing.plot.classes import legend_extended, patch, written
from grazing.plot.drawn import inline
from grazing.plot.expected import choice
from grazing.plot.locus import locus
from grazing.plot.spread import MARKER, spread
from grazing.plot.style import INK, axes, panels, period_colour, root, styled, symbol
from grazing.plot.words import OTHERS, with_words, words_in

if TYPE_CHECKING:
    import xarray as xr

#: Dashes by kind of orbit.
DASHES: dict[str, Any] = {"stable": "-", "unstable": (0, (4.0, 2.0)), "virtual": (0, (1.0, 1.6))}
#: Part of the range of the parameter within which two values are the same.
ROUNDING = 1e-12
#: Letters of a line of a legend.
WIDTH = 26
#: Markers of special points: filled for stability, open for borders.
MARKERS = {
    "lp": ("o", True), "pd": ("s", True), "ns": ("D", True), "bp": ("P", True), "gr": ("v", False),
    "bcb": ("v", False), "ep": ("X", False), "v0": ("^", False), "law": ("<", False), "st": (">", False),
    "ch": ("*", False),
}  # fmt: skip


@inline
def branch(
    result: Any,
    ax: Axes | None = None,
    *,
    coordinate: str | None = None,
    by: str | None = None,
    virtual: bool = True,
    names: bool = True,
    legend: bool | None = None,
) -> dict[str, Any]:
    """Draw branches: all points of their orbits over the parameter.

    Parameters
    ----------
    result : Branch, xarray.Dataset, or several of them
        From :func:`grazing.continuation`, or its ``dataset``.
    ax : matplotlib Axes, optional
    coordinate : str, optional
        Which coordinate of the map; the first one by default.
    by : {"period", "word"}, optional
        What colours tell apart. Default: what they do in the figure; in a new one periods.
    virtual : bool
        Whether orbits that the map does not have are drawn, and special points on them.
    names : bool
        Whether special points carry their names.
    legend : bool, optional
        Whether to say what the lines and the special points are; None for one in a new figure, or where there is one.

    Returns
    -------
    dict
        ``lines``, ``markers`` and ``names``, lists of artists; ``figure``.

    Raises
    ------
    InputError
        For anything else, or a coordinate that the map does not have.
    """
    if by is not None:
        choice(by, "by", ("period", "word"))
    tables = [table_of(one) for one in (result if isinstance(result, (list, tuple)) else [result])]
    if not tables:
        raise InputError("no branch to draw; give a branch, its dataset, or several of them")
    name = tables[0].attrs["parameter"]
    coordinates = json.loads(tables[0].attrs["coordinate_names"])
    chosen = coordinates[0] if coordinate is None else coordinate
    if not isinstance(chosen, str) or chosen not in coordinates:
        raise InputError(f"coordinate {shown(chosen)}; allowed are {', '.join(coordinates)}")
    if any(table.attrs["parameter"] != name for table in tables):
        raise InputError("the branches run in different parameters; draw them in figures of their own")
    lines: list[Any] = []
    markers: list[Any] = []
    texts: list[Any] = []
    with styled():
        ax = axes(ax)
        known = words_in(root(ax))
        shades = known if by == "word" or (by is None and known) else None
        listed: dict[str, str] = {}
        if shades is not None:
            words = {word for table in tables for word in seen_words(table, virtual)}
            with_words(shades, words)
            listed = {word: shades.get(word, OTHERS) for word in sorted(words, key=lambda word: (len(word), word))}
        for table in tables:
            lines += drawn(table, ax, name, chosen, virtual, shades)
            for artist, text in marked(table, ax, chosen, virtual, names, shades):
                markers.append(artist)
                texts += [text] if text is not None else []
        ax.set(xlabel=symbol(tables[0][name]), ylabel=symbol(tables[0][chosen]))
        if legend:
            explained(ax, tables, virtual, listed)
        spread(ax, texts, markers)
    return {"figure": root(ax), "lines": lines, "markers": markers, "names": texts}


def whole(result: xr.Dataset, **style: Any) -> dict[str, Any]:
    """Draw all that a command found: a branch, and beside it the loci of its special points if there are any."""
    recipe = json.loads(result.attrs.get("grazing_recipe", "{}"))
    if recipe:
        style = {"virtual": bool(recipe["settings"].get("virtual")), **style}
    loci = loci_of(result)
    figure, (left, *right) = panels(174.0, 80.0, columns=2 if loci else 1)
    drawn = branch(result, left, **style)
    if not loci:
        return drawn
    locus(loci, *right, virtual=style.get("virtual", True), names=style.get("names", True))
    return {"figure": figure}


def table_of(one: Any) -> xr.Dataset:
    """Return the table of a branch, or refuse what is none."""
    from grazing.late import xarray as xr

    table = one if isinstance(one, xr.Dataset) else getattr(one, "dataset", None)
    if not isinstance(table, xr.Dataset) or not {"piece", "stable", "admissible", "special_value"} <= set(
        table.variables
    ):
        got = type(one).__name__
        raise InputError(f"branches cannot be drawn from this {got}; give a Branch of gz.continuation, or its dataset")
    return table


def kinds(table: xr.Dataset) -> NDArray[Any]:
    """Return which kind of line each point belongs to."""
    kind = np.where(table["stable"].values == 1, "stable", "unstable")
    return np.where(table["admissible"].values == 1, kind, "virtual")


def seen_words(table: xr.Dataset, virtual: bool) -> set[str]:
    """Return the words of the orbits of a branch that are drawn."""
    shown = (table["admissible"].values == 1) | virtual
    return {str(word) for word in table["word"].values[shown].tolist()}


def shade_of(word: str, period: int, shades: dict[str, str] | None) -> str:
    """Return the colour of an orbit: of its word, or of its period where words have no colours."""
    return period_colour(period) if shades is None else shades.get(word, OTHERS)


def drawn(
    table: xr.Dataset, ax: Axes, name: str, coordinate: str, virtual: bool, shades: dict[str, str] | None = None
) -> list[Any]:
    """Draw the lines: one for each stretch of one piece, colour and kind, joined to the point before it.

    Where an impact crosses the strobe the word changes, and some coordinates jump: others go on.
    """
    kind, piece = kinds(table), table["piece"].values
    word, period = table["word"].values.astype(str), table["period"].values
    x, y = table[name].values, table[coordinate].values
    goes_on = (piece[1:] == piece[:-1]) & (period[1:] == period[:-1])
    alike = goes_on & (word[1:] == word[:-1])
    goes_on &= alike | ~jumps(x, y, alike)
    # an orbit at a special point is on the edge of two kinds: a step is of the kind of its other end
    # the first point after it may be the same orbit again, to rounding
    at = table["event"].values == 1
    same = (piece[1:] == piece[:-1]) & (np.abs(np.diff(x)) <= ROUNDING * (np.ptp(x) if len(x) else 0.0))
    at[1:] |= at[:-1] & same
    step = np.where(at[:-1], kind[1:], kind[:-1])
    step = np.where(goes_on, step, "")
    new = step[1:] != step[:-1]
    if shades is not None:
        new |= word[1:-1] != word[:-2]
    edges = np.concatenate([[0], np.flatnonzero(new) + 1, [len(step)]]) if len(step) else [0]
    artists = []
    for first, last in pairwise(edges):
        what = str(step[first])
        if what == "" or (what == "virtual" and not virtual):
            continue
        rows = slice(first, last + 1)
        artists += ax.plot(
            x[rows],
            y[rows, : period[first]],
            color=shade_of(str(word[first]), int(period[first]), shades),
            ls=DASHES[what],
            lw={"stable": 1.2, "unstable": 0.8, "virtual": 0.5}[what],
            zorder={"stable": 3.0, "unstable": 2.8, "virtual": 2.5}[what],
        )
    return artists


def jumps(x: NDArray[Any], y: NDArray[Any], alike: NDArray[Any]) -> NDArray[Any]:
    """Return which steps from point to point are far longer than those beside them between orbits that are alike."""
    wide, high = np.abs(np.diff(x)), np.nan_to_num(np.abs(np.diff(y, axis=0))).max(axis=1, initial=0.0)
    beside_x, beside_y = np.zeros_like(wide), np.zeros_like(high)
    for here, there in ((slice(1, None), slice(None, -1)), (slice(None, -1), slice(1, None))):
        beside_x[here] = np.maximum(beside_x[here], np.where(alike[there], wide[there], 0.0))
        beside_y[here] = np.maximum(beside_y[here], np.where(alike[there], high[there], 0.0))
    longer = np.maximum(wide / np.where(beside_x > 0.0, beside_x, np.inf), 1.0)
    return np.asarray(high > 2.0 * longer * beside_y + 1e-9 * np.nan_to_num(np.abs(y)).max(initial=0.0))


def marked(
    table: xr.Dataset, ax: Axes, coordinate: str, virtual: bool, names: bool, shades: dict[str, str] | None = None
) -> list[tuple[Any, Any]]:
    """Draw the special points at the first point of their orbits, with their names."""
    artists = []
    places = table["special_value"].values
    span = float(np.ptp(places)) if places.size else 0.0
    span = span or 1.0
    seen: set[tuple[str, int]] = set()
    walls = table["special_wall"].values.astype(str) if "special_wall" in table else np.full(places.size, "")
    for i, kind in enumerate(table["special_type"].values.astype(str).tolist()):
        if not virtual and not table["special_admissible"].values[i]:
            continue
        x, y = float(table["special_value"].values[i]), float(table[f"special_{coordinate}"].values[i])
        name = f"{kind} {walls[i]}".strip()  # a graze of wall A is no graze of wall B
        place = name, round(1e4 * x / span)
        shape, filled = MARKERS[kind]
        colour = shade_of(word_at(table, i), int(table["special_period"].values[i]), shades)
        (artist,) = ax.plot(
            [x], [y], shape, ms=MARKER, mec=colour, mew=0.8, mfc=colour if filled else "white", zorder=5, ls="none"
        )
        text = None
        if names and place not in seen:  # where several branches meet one name is enough
            seen.add(place)
            text = ax.annotate(
                name, (x, y), xytext=(3.0, 3.0), textcoords="offset points", fontsize=6.5, color=INK, zorder=6
            )
        artists.append((artist, text))
    return artists


def word_at(table: xr.Dataset, i: int) -> str:
    """Return the word of the orbit next to a special point on its piece."""
    there = np.flatnonzero(table["piece"].values == table["special_piece"].values[i])
    if not there.size:
        return ""
    values = table[table.attrs["parameter"]].values[there]
    far = np.abs(values - table["special_value"].values[i])
    far[table["event"].values[there] != 1] += np.ptp(values)  # the point itself is on the piece
    return str(table["word"].values[there[int(np.argmin(far))]])


def special_entries(table: xr.Dataset, virtual: bool = False) -> list[Any]:
    """Return the entries of a legend for the special points that are drawn: their marks, names and what they are."""
    words = dict(item.split(": ", 1) for item in table["special_type"].attrs["meaning"].split("; "))
    shown = (table["special_admissible"].values == 1) | virtual
    there = {*table["special_type"].values[shown].tolist()}
    found = []
    for kind in (kind for kind in MARKERS if kind in there):
        shape, filled = MARKERS[kind]
        text = fill(f"{kind}: {words[kind].split(':')[0]}", WIDTH)
        look: dict[str, Any] = {"mec": INK, "mfc": INK if filled else "white", "ms": MARKER, "mew": 0.8}
        found.append(Line2D([], [], ls="none", marker=shape, label=text, **look))
    return found


def explained(ax: Axes, tables: list[xr.Dataset], virtual: bool, words: dict[str, str]) -> None:
    """Add a legend of the words that have colours, of the kinds of lines and of special points that occur."""
    seen = [kind for kind in DASHES if any((kinds(table) == kind).any() for table in tables)]
    handles: list[Any] = [
        Line2D([], [], color=INK, ls=DASHES[kind], lw=1.1 if kind == "stable" else 0.8, label=kind)
        for kind in seen
        if virtual or kind != "virtual"
    ]
    if words or ax.get_legend() is not None:
        entries = [patch(colour, written(word)) for word, colour in words.items()]
        legend_extended(ax, [*entries, *(handles if len(handles) > 1 else [])])
    elif len(handles) > 1:
        ax.legend(handles=handles, loc="best", fontsize=6.5, handlelength=2.4)
