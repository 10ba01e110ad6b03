"""Classes of orbits in figures: their colours, names and order, the same in every figure."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from itertools import groupby
from typing import Any

import matplotlib
from matplotlib.axes import Axes
from matplotlib.colors import to_hex, to_rgb
from matplotlib.patches import Patch

from grazing.outcome import Outcome
from grazing.plot.style import INK, PERIODS, ink_on, mathematics, period_colour, plain, root

#: Codes of orbits without a period, in the order of legends, and what they are called.
ENDED = -2
NAMES = {-1: "aperiodic", 0: "undecided", ENDED: "ended"}
#: Why an orbit ended, in few words; one that could not be computed on has diverged as well.
ENDS = {
    Outcome.too_many_impacts: "chatter,\ntoo many impacts",
    Outcome.too_many_swings: "too many swings\nin a period",
    Outcome.no_impact: "no further impact",
    Outcome.bad_law: "the reset law failed",
    Outcome.inside_wall: "inside the wall",
    Outcome.diverged: "diverged",
}
#: The code of a place for an attractor that has none.
UNUSED = -3
#: Towards what a dark colour goes for further attractors of one period; black would become the grey of chaos.
TINT, TINT_OF_BLACK = "#ffffff", "#d2a679"
#: Characters in a line of a word, and its lines.
WIDE, LINES = 24, 3
#: Height of an entry of a legend in millimetres.
ENTRY = 3.75
#: A run of at least so many equal letters is written as a power; of letters in parentheses a pair is.
RUN = 4

_LETTER = re.compile(r"\([^()]*\)|.")


def order_of(period: int) -> tuple[bool, int]:
    """Return a key that sorts periods first, then aperiodic, undecided and ended.

    Examples
    --------
    >>> from grazing.plot.classes import order_of
    >>> sorted([0, 3, -2, 1, -1], key=order_of)
    [1, 3, -1, 0, -2]
    """
    period = int(period)
    return (period < 1, period if period >= 1 else list(NAMES).index(period) if period in NAMES else len(NAMES))


def attractor_colours(periods: Sequence[int]) -> list[str]:
    """Return one colour for each attractor: that of its period, and for further ones of the same colour shades of it.

    Parameters
    ----------
    periods : sequence of int

    Examples
    --------
    >>> from grazing.plot.classes import attractor_colours
    >>> attractor_colours([3, 2, 3])
    ['#0064a4', '#e69f00', '#bfd8e8']
    """
    base = [period_colour(int(period)) for period in periods]
    found = []
    for i, colour in enumerate(base):
        rank, last = base[:i].count(colour), base.count(colour) - 1
        found.append(shade(colour, (rank - 1) / max(last - 1, 1) if last > 1 else 1.0) if rank else colour)
    return found


def shade(colour: str, far: float) -> str:
    """Return a shade of a colour, from the nearest, 0, to the farthest, 1: dark ones lighter, light ones darker."""
    light = ink_on(colour) == INK
    end = to_rgb(INK if light else TINT_OF_BLACK if colour == PERIODS[0] else TINT)
    share = 0.32 + 0.23 * far if light else 0.4 + 0.35 * far
    red, green, blue = ((1.0 - share) * a + share * b for a, b in zip(to_rgb(colour), end, strict=True))
    return to_hex((red, green, blue))


def name_of(period: int) -> str:
    """Return what a class of orbits is called: ``period 3``, ``aperiodic``, ``undecided`` or ``ended``."""
    return f"period {int(period)}" if period >= 1 else NAMES.get(int(period), f"class {int(period)}")


def written(word: str) -> str:
    r"""Return a word as it stands in a figure: runs as powers, in lines; of one longer than those its length is said.

    Examples
    --------
    >>> from grazing.plot.classes import written
    >>> written("LLR"), written("LLLLLR"), written("1(12)0"), written("(left_drain)")
    ('LLR', '$\\mathrm{L}^{5}\\mathrm{R}$', '1(12)0', '(left_drain)')
    >>> print(written("(BBAA)(BBA)" * 5))
    (BBAA)(BBA)(BBAA)(BBA)
    (BBAA)(BBA)(BBAA)(BBA)
    (BBAA)(BBA)
    """
    parts: list[tuple[str, int]] = []
    for letter, same in groupby(_LETTER.findall(word)):
        count = len(list(same))
        parts += [(letter, count)] if count >= (RUN if len(letter) == 1 else 2) else [(letter, 1)] * count
    lines: list[list[tuple[str, int]]] = [[]]
    for part in parts:
        if lines[-1] and sum(len(letter) for letter, _count in lines[-1]) + len(part[0]) > WIDE:
            lines.append([])
        lines[-1].append(part)
    cut = len(lines) > LINES
    shown = [_line(line) for line in lines[:LINES]]
    return "\n".join(
        [*shown[:-1], f"{shown[-1]}… ({sum(count for _letter, count in parts)} letters)"] if cut else shown
    )


def _line(parts: Sequence[tuple[str, int]]) -> str:
    """Return a line of letters with how often each stands there."""
    if all(count == 1 for _letter, count in parts):
        return plain("".join(letter for letter, _count in parts))
    formula = "".join(rf"\mathrm{{{a}}}".replace("_", r"\_") + (f"^{{{n}}}" if n > 1 else "") for a, n in parts)
    return mathematics(formula, "".join(a * n for a, n in parts))


def class_name(word: str, period: int) -> str:
    """Return word and period of a class of orbits, or what it is called if it has none."""
    if period < 1 or not word:
        return name_of(period)
    return f"{written(word)}, period {int(period)}"


def patches_of(periods: Iterable[int]) -> list[Patch]:
    """Return the entries of a legend: each colour once, with the periods present that have it."""
    groups: dict[str, list[int]] = {}
    for period in sorted({int(period) for period in periods} - {UNUSED}, key=order_of):
        groups.setdefault(period_colour(period), []).append(period)
    found = []
    for colour, members in groups.items():
        name = ", ".join(map(str, members[:2])) + (", …" if len(members) > 2 else "")
        found.append(patch(colour, name if members[0] >= 1 else name_of(members[0])))
    return found


def why_ended(outcomes: Any) -> list[str]:
    """Return why orbits with these outcomes ended, each reason once.

    Examples
    --------
    >>> from grazing import Outcome
    >>> from grazing.plot.classes import why_ended
    >>> why_ended([Outcome.diverged, Outcome.diverged | Outcome.no_impact, Outcome.ok])
    ['no further impact', 'diverged']
    """
    first = {next((flag for flag in ENDS if bits & flag), None) for bits in {*map(int, outcomes)}}
    return [words for flag, words in ENDS.items() if flag in first]


def tell_ends(entries: Sequence[Any], result: Any) -> None:
    """Say in the entry of a legend for orbits that ended why they did, as far as the result says so."""
    if "outcome" not in result or result["outcome"].dims != result["period"].dims:
        return
    reasons = why_ended(result["outcome"].values[result["period"].values == ENDED])
    for entry in entries:
        if reasons and entry.get_label() == NAMES[ENDED]:
            entry.set_label(f"{NAMES[ENDED]}: {'; '.join(reasons)}")


def patch(colour: Any, name: str, **look: Any) -> Patch:
    """Return the entry of a legend for an area; a hairline keeps light colours apart from paper."""
    return Patch(**{"facecolor": colour, "edgecolor": "#404040", "linewidth": 0.3, "label": name, **look})


def blended(colour: str, share: float) -> str:
    """Return a colour as it looks on white when it is drawn with an opacity."""
    parts = (int(colour[i : i + 2], 16) for i in (1, 3, 5))
    return "#" + "".join(f"{round(255 + share * (part - 255)):02x}" for part in parts)


def rows_beside(ax: Axes) -> int:
    """Return how many entries a legend beside the axes has room for, its title left out."""
    return max(4, int(ax.get_window_extent().height / root(ax).dpi * 25.4 / ENTRY) - 1)


def legend_beside(ax: Axes, handles: Sequence[Any], title: str = "", **look: Any) -> Any:
    """Put a legend to the right of the axes, where it covers no data; in columns no longer than the axes."""
    lines = sum(1 + str(handle.get_label()).count("\n") for handle in handles)
    look.setdefault("ncols", -(-lines // rows_beside(ax)))
    with matplotlib.rc_context({"legend.handlelength": 1.3, "legend.handleheight": 0.9, "legend.labelspacing": 0.35}):
        place: dict[str, Any] = {
            "loc": "upper left",
            "bbox_to_anchor": (1.0, 1.0),
            "borderaxespad": 0.3,
            "alignment": "left",
        }
        found = ax.legend(handles=list(handles), title=title or None, **{**place, **look})
    found.get_title().set_fontsize(7.5)
    for text in found.get_texts():
        text.set_linespacing(1.0)
    return found


def legend_extended(ax: Axes, entries: Sequence[Any]) -> Any:
    """Put entries into the legend beside the axes, after those that are there."""
    old = ax.get_legend()
    handles: list[Any] = [] if old is None else list(old.legend_handles)
    title = "" if old is None else old.get_title().get_text()
    known = {handle.get_label() for handle in handles}
    return legend_beside(ax, [*handles, *(entry for entry in entries if entry.get_label() not in known)], title)
