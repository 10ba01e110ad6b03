"""How figures look: sizes for print, type, a fixed colour for each period, provenance in the file; no global state."""

from __future__ import annotations

import json
import re
import warnings
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import lru_cache
from importlib.metadata import PackageNotFoundError, version
from io import BytesIO
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_hex, to_rgba
from matplotlib.figure import Figure
from matplotlib.mathtext import MathTextParser

from grazing.outcome import InputError, in_one_line, shown
from grazing.paths import path_of
from grazing.plot.drawn import Inline
from grazing.plot.options import checked, passed_on
from grazing.writing import whole_file

#: Widths in millimetres: one column and two columns of a journal page.
SINGLE, DOUBLE = 85.0, 174.0
#: Letters that XML does not have, in UTF-8.
_NO_XML = re.compile(rb"[\0-\x08\x0b\x0c\x0e-\x1f]|\xef\xbf[\xbe\xbf]")
#: The formats that :func:`save` writes.
FORMATS = ("png", "pdf", "svg")

RC: dict[str, Any] = {
    "font.family": "STIXGeneral",
    "mathtext.fontset": "stix",
    "font.size": 8.0,
    "axes.titlesize": 8.0,
    "axes.labelsize": 8.5,
    "legend.fontsize": 7.5,
    "xtick.labelsize": 7.5,
    "ytick.labelsize": 7.5,
    "axes.linewidth": 0.6,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "xtick.minor.width": 0.4,
    "ytick.minor.width": 0.4,
    "xtick.direction": "out",
    "ytick.direction": "out",
    "xtick.major.size": 2.5,
    "ytick.major.size": 2.5,
    "xtick.minor.size": 1.5,
    "ytick.minor.size": 1.5,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.axisbelow": True,
    "lines.linewidth": 1.0,
    "legend.frameon": False,
    "legend.handlelength": 1.8,
    "figure.dpi": 100.0,
    "savefig.dpi": 300.0,
    "pdf.fonttype": 42,  # TrueType: journals refuse Type 3
    "ps.fonttype": 42,
    "pdf.compression": 6,
    "svg.hashsalt": "grazing",
    "path.simplify": True,
}

#: Colour of period N is PERIODS[(N - 1) % 16]. Even and odd periods differ in lightness (CIE L* in the comment) by
#: more than 20, so that neighbours can be told apart in grey and by readers who see fewer hues.
PERIODS = (
    "#1a1a1a",  # 1  L* 9  black
    "#e69f00",  # 2  L* 71  orange
    "#0064a4",  # 3  L* 41  blue
    "#5cbceb",  # 4  L* 72  sky
    "#9c2a1b",  # 5  L* 36  brick
    "#e08fbf",  # 6  L* 69  pink
    "#00624a",  # 7  L* 36  green
    "#b3b53c",  # 8  L* 72  olive
    "#5b2c83",  # 9  L* 29  purple
    "#f0d48a",  # 10  L* 86  sand
    "#1f7a8c",  # 11  L* 47  teal
    "#f2a07b",  # 12  L* 73  salmon
    "#7a4a12",  # 13  L* 36  brown
    "#86d3b4",  # 14  L* 79  mint
    "#b0186b",  # 15  L* 39  magenta
    "#b9b3e3",  # 16  L* 75  lavender
)
#: Without a period: aperiodic as far as seen, undecided, ended. Greys that no period has.
CHAOS, UNDECIDED, ENDED = "#8c8c8c", "#c2c2c2", "#e6e6e6"
INK = "#1a1a1a"
WALL = "#d9d9d9"
GRAZE = "#b00020"


@checked
def period_colour(N: int) -> str:
    """Return the colour that period N always has; a grey for N < 1: no period was found.

    Parameters
    ----------
    N : int
        Period, or 0 undecided, -1 aperiodic as far as seen, -2 ended.

    Examples
    --------
    >>> from grazing.plot.style import period_colour
    >>> period_colour(3), period_colour(19), period_colour(-1)
    ('#0064a4', '#0064a4', '#8c8c8c')
    """
    if N >= 1:
        return PERIODS[(N - 1) % len(PERIODS)]
    return {0: UNDECIDED, -2: ENDED}.get(N, CHAOS)


@contextmanager
def styled() -> Iterator[None]:
    """Apply the style inside a ``with`` block; matplotlib's settings are as before afterwards."""
    with matplotlib.rc_context():
        matplotlib.rcdefaults()
        matplotlib.rcParams.update(RC)  # type: ignore[arg-type]
        yield


@checked
def figure(width: float = SINGLE, height: float = 62.0) -> Figure:
    """Return an empty figure of a size in millimetres, from 1 to 1200; it belongs to no window and no global list."""
    with styled():
        return Inline(figsize=(width / 25.4, height / 25.4), layout="constrained")


def axes(ax: Axes | None, width: float = SINGLE, height: float = 62.0) -> Axes:
    """Return the axes given, or those of a new figure; warn of a dark ground, on which much would not be seen."""
    if ax is None:
        return panels(width, height)[1][0]
    grounds = [to_rgba(each) for each in (ax.get_facecolor(), root(ax).get_facecolor())]
    if any(each[3] and ink_on(to_hex(each)) != INK for each in grounds):
        warnings.warn(
            "the axes are dark, and these colours are for a light ground: period 1 is black, and so is what is "
            "written; make the axes outside of the dark style, or by gz.plot.panels()",
            stacklevel=4,
        )
    return ax


def root(ax: Axes) -> Figure:
    """Return the figure of axes, the outermost one."""
    found = ax.get_figure(root=True)
    assert found is not None
    return found


@checked
def panels(
    width: float = SINGLE, height: float = 62.0, rows: int = 1, columns: int = 1, **grid: Any
) -> tuple[Figure, list[Axes]]:
    """Return a figure of a size in millimetres and its panels, row by row.

    Parameters
    ----------
    width, height : float
        In millimetres, from 1 to 1200.
    rows, columns : int
        From 1 to 20.
    **grid
        Passed to ``Figure.subplots``, such as ``sharex=True`` or ``width_ratios=(3, 1)``.

    Raises
    ------
    InputError
        For a size or a number out of range, or what ``Figure.subplots`` does not take.
    """
    with styled(), passed_on("panels"):
        fig = figure(width, height)
        return fig, list(np.ravel(fig.subplots(rows, columns, squeeze=False, **grid)))


def software() -> str:
    """Return the name and version that files carry."""
    try:
        return f"grazing {version('grazing')}"
    except PackageNotFoundError:
        return "grazing"


def figure_of(drawn: Figure | Mapping[str, Any]) -> Figure:
    """Return a figure as it is, or that of the artists which a function of this package returned."""
    found = drawn.get("figure") if isinstance(drawn, Mapping) else drawn
    if not isinstance(found, Figure):
        raise InputError(
            f"a {type(drawn).__name__} without a figure cannot be written; allowed are a matplotlib Figure and what "
            "the functions of grazing.plot return"
        )
    return found


def rendered(
    fig: Figure | Mapping[str, Any], kind: str, title: str = "", provenance: Mapping[str, Any] | None = None
) -> bytes:
    """Return a figure as the bytes of a file; the same figure gives the same bytes.

    Parameters
    ----------
    fig : Figure or mapping
        A figure, or the artists that a function of this package returned.
    kind : {"png", "pdf", "svg"}
    title : str
        Stored in the file.
    provenance : mapping, optional
        How the figure came about, such as parameters and seed; stored as JSON, together with what the artists carry
        of it (``"provenance"``, of the result that was drawn). No time of day is stored.

    Returns
    -------
    bytes

    Raises
    ------
    InputError
        For any other kind, what has no figure, or numbers that cannot be drawn.
    """
    if not isinstance(kind, str) or kind not in FORMATS:
        raise InputError(
            f"figure format {shown(kind)}; allowed are {', '.join(FORMATS)}: choose the ending of the file's name"
        )
    if not isinstance(title, str):
        raise InputError(f"title = {shown(title)}; give text")
    if not isinstance(provenance, Mapping | None):
        raise InputError(f"provenance = {shown(provenance)}; give a mapping or None")
    title = "".join(letter if letter.isprintable() else ascii(letter)[1:-1] for letter in title)
    carried = fig.get("provenance", {}) if isinstance(fig, Mapping) else {}
    origin = json.dumps({**carried, **(provenance or {})}, sort_keys=True, default=str)
    fields: dict[str, dict[str, Any]] = {
        "png": {"Title": title, "Software": software(), "Description": origin},
        "pdf": {"Title": title, "Creator": software(), "Subject": origin, "CreationDate": None, "ModDate": None},
        "svg": {"Title": title, "Creator": software(), "Description": origin, "Date": None},
    }
    out = BytesIO()
    drawn = figure_of(fig)
    try:
        with styled(), np.errstate(over="ignore", invalid="ignore"):
            drawn.savefig(out, format=kind, metadata=fields[kind], dpi=RC["savefig.dpi"])
    except (ValueError, ArithmeticError) as error:  # axes that a double cannot cut into ticks
        raise InputError(
            f"the figure cannot be drawn ({in_one_line(error)}); its numbers are too large or too far apart: draw fewer"
        ) from error
    return out.getvalue() if kind != "svg" else _NO_XML.sub(b"", out.getvalue())


def save(
    fig: Figure | Mapping[str, Any], path: str | Path, title: str = "", provenance: Mapping[str, Any] | None = None
) -> Path:
    """Write a figure to a PNG, PDF or SVG file, whole or not at all.

    Parameters
    ----------
    fig : Figure or mapping
        A figure, or the artists that a function of this package returned.
    path : str or Path
        Its ending chooses the format.
    title, provenance
        See :func:`rendered`.

    Returns
    -------
    Path
    """
    path = path_of(path)
    data = rendered(fig, path.suffix.lstrip(".").lower(), title, provenance)
    with whole_file(path) as part:
        part.write_bytes(data)
    return path


def note(ax: Axes, text: str, up: float = 2.0) -> Any:
    """Say above the right end of axes, by so many points, what is not drawn in them; None for nothing to say."""
    if not text:
        return None
    look: dict[str, Any] = {"ha": "right", "va": "bottom", "fontsize": 6.5, "color": "#595959"}
    return ax.annotate(text, (1.0, 1.0), (0, up), xycoords="axes fraction", textcoords="offset points", **look)


def ink_on(colour: str) -> str:
    """Return black or white, whichever is read better on a colour."""
    red, green, blue = (int(colour[i : i + 2], 16) / 255.0 for i in (1, 3, 5))
    return INK if 0.2126 * red**2.2 + 0.7152 * green**2.2 + 0.0722 * blue**2.2 > 0.25 else "#ffffff"


def label(name: str, symbol: str | None = None) -> str:
    """Return an axis label: the symbol in mathematics, or the name as it is."""
    return mathematics(symbol, name) if symbol else plain(name)


def symbol(variable: Any) -> str:
    """Return an axis label of a variable: its symbol, or its name, and its unit."""
    return f"{label(str(variable.name), variable.attrs.get('symbol'))}{unit_of(variable)}"


def unit_of(variable: Any) -> str:
    """Return the unit of a variable as a label ends with it, nothing if there is none."""
    unit = str(variable.attrs.get("units", "1"))
    return "" if unit == "1" else f" ({plain(unit)})"


def quantity(variable: Any) -> str:
    """Return an axis label that says what a variable is: its long name, symbol and unit, as far as it has them."""
    attrs = variable.attrs
    words = [plain(str(attrs["long_name"]))] if "long_name" in attrs else []
    if "symbol" in attrs or not words:
        words.append(label(str(variable.name), attrs.get("symbol")))
    return " ".join(words) + unit_of(variable)


def mathematics(formula: str, name: str) -> str:
    r"""Return a formula as a text of a figure; where matplotlib cannot read it, the name instead, as it is.

    Symbols may be names that somebody chose, and a figure must not break on them.

    Examples
    --------
    >>> from grazing.plot.style import mathematics
    >>> mathematics(r"\omega", "omega"), mathematics("a_b_c", "a_b_c")
    ('$\\omega$', 'a_b_c')
    """
    ends = re.search(r"(?<!\\)\$", formula)  # a dollar would end the formula early
    return plain(name) if ends or not _reads(f"${formula}$") else f"${formula}$"


@lru_cache(maxsize=1024)
def _reads(text: str) -> bool:
    try:
        MathTextParser("path").parse(text)
    except ValueError:
        return False
    return True


def drawable(text: str) -> str:
    """Return a text that may hold mathematics between dollars; as it is where matplotlib cannot read that."""
    return text if _reads(text) and not text.startswith("_") else plain(text)


def plain(text: str) -> str:
    """Return a text that a figure shows as it is: no mathematics, and no label that hides itself."""
    return (" " if text.startswith("_") else "") + text.replace("$", r"\$")
