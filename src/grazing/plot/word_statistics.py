"""The words that orbits spell most often; or what the next letter still tells, as one parameter varies."""

from __future__ import annotations

from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_hex

from grazing.outcome import InputError
from grazing.plot.drawn import inline
from grazing.plot.expected import expect
from grazing.plot.provenance import provenance_of
from grazing.plot.raster import axes_along, name_single, ordered
from grazing.plot.style import DOUBLE, INK, axes, note, plain, root, styled, symbol

#: Millimetres of a word's row, and of the rest of the figure; characters of a word that are written.
ROW, REST, LONGEST = 4.2, 22.0, 72


@inline
def word_statistics(result: Any, ax: Axes | None = None, *, colour: str = INK) -> dict[str, Any]:
    """Draw the shares of the most frequent words, or over a parameter the entropies of a letter after a known word.

    Parameters
    ----------
    result : xarray.Dataset
        From :func:`grazing.word_statistics`.
    ax : matplotlib Axes, optional
        Default: a new figure.
    colour : str
        Of the bars; over a parameter of the marks for the longest words, those of shorter ones being lighter.

    Returns
    -------
    dict
        ``shares`` (bars, one of each word) or ``entropies`` (length to a line of marks); ``errors`` (bars of one
        standard error to either side), ``note`` (what is not drawn, or None), ``provenance``, ``figure``.

    Raises
    ------
    InputError
        For another kind of result, or one without a word.

    Examples
    --------
    >>> import grazing as gz
    >>> found = gz.word_statistics(gz.gap_map(lam=0.5, mu=0.07, l=0.1), length=3)
    >>> [text.get_text() for text in gz.plot.word_statistics(found)["figure"].axes[0].get_yticklabels()]
    ['LLR', 'LRL', 'RLL']
    """
    varied = hasattr(result, "sizes") and "left" in result and result["left"].ndim > 0
    name = ("<parameter>",) if varied else ()
    needed = {"conditional_entropy": (*name, "length"), "conditional_entropy_error": (*name, "length")}
    expect(result, "word_statistics", needed | {"word": (*name, "rank"), "share": (*name, "rank")})
    drawn = _along(result, ax, colour) if varied else _bars(result, ax, colour)
    return {**drawn, "provenance": provenance_of(result)}


def _bars(result: Any, ax: Axes | None, colour: str) -> dict[str, Any]:
    words = [str(word) for word in result["word"].values if word]
    if not words:
        raise InputError("plot.word_statistics finds no word in the result: orbits left or ended before")
    share, error = (result[name].values[: len(words)] for name in ("share", "share_error"))
    length = int(result["length"].values[-1])
    with styled():
        ax = axes(ax, DOUBLE, REST + ROW * len(words))
        places = np.arange(len(words))
        bars = ax.barh(places, share, height=0.7, color=colour, alpha=0.45)
        errors = ax.errorbar(share, places, xerr=error, fmt="none", ecolor=colour, lw=0.8)
        ax.set_yticks(places, [plain(w if len(w) <= LONGEST else f"{w[: LONGEST - 3]}...") for w in words])
        ax.tick_params(axis="y", length=0)
        ax.set(xlim=(0.0, None), ylim=(len(words) - 0.4, -0.6), xlabel=f"share of the words of {length} letters")
        more = int(result["words"].values[-1]) - len(words)
        rest = 1.0 - float(share.sum())
        others = (
            f"{more:,} more words have {100.0 * rest:.3g} % together"
            if more > 1
            else f"1 more word has {100.0 * rest:.3g} %"
        )
        said = note(ax, others if more else "")
    return {"figure": root(ax), "shares": list(bars), "errors": errors, "note": said}


def _along(result: Any, ax: Axes | None, colour: str) -> dict[str, Any]:
    name = str(result["left"].dims[0])
    values, where = ordered(result[name].values)
    entropy, error = (result[f"conditional_entropy{end}"].values[where] for end in ("", "_error"))
    lengths = result["length"].values.tolist()
    shades = matplotlib.colors.LinearSegmentedColormap.from_list("entropies", ["#c9c9c9", colour])
    lines, bars = {}, {}
    with styled():
        ax = axes_along(ax, 120.0, 70.0, values)
        for i, length in enumerate(lengths):
            shade = to_hex(shades((i + 1) / len(lengths)))
            says = ("alone", "after 1 letter", f"after {length - 1} letters")[min(i, 2)]
            line, _caps, sides = ax.errorbar(
                values, entropy[:, i], yerr=error[:, i], fmt="o-", ms=2.0, lw=0.8, color=shade, label=says, zorder=2 + i
            )
            lines[length], bars[length] = line, sides
        name_single(ax.xaxis, values)
        ax.set(xlabel=symbol(result[name]), ylabel="entropy of a letter (nat)", ylim=(0.0, None))
        ax.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=4)
    return {"figure": root(ax), "entropies": lines, "errors": bars, "note": None}
