"""Words of what a study found: tables and sentences, line by line."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from grazing.catalogue.study import Row, Study

#: Rows of a table, ranges of a row, and letters of a word that are printed; --json has all.
ROWS, RANGES, LONGEST = 6, 2, 24


def aligned(head: Sequence[str], rows: Iterable[Sequence[str]]) -> list[str]:
    """Return a table as lines; the last column is as wide as it is."""
    every = [list(head), *map(list, rows)]
    widths = [max(len(row[i]) for row in every) for i in range(len(head) - 1)]
    return [
        "  ".join([*(cell.ljust(w) for cell, w in zip(row, widths, strict=False)), row[-1]]).rstrip() for row in every
    ]


def short(x: float, digits: int = 6) -> str:
    """Return a number in few digits."""
    return f"{x:.{digits}g}"


def headed(name: str, unit: str) -> str:
    """Return a name as it stands over a column."""
    return f"{name} ({unit})" if unit else name


def share(part: float, whole: int) -> str:
    """Return a share in percent: no finer than one of the whole, and all or nothing only where it is so."""
    digits = max(0, min(2, int(math.log10(max(whole, 1))) - 2))
    text = f"{100.0 * part:.{digits}f}"
    least = f"{10.0**-digits:.{digits}f}"
    if part < 1.0 and float(text) == 100.0:
        return f"over {100.0 - float(least):.{digits}f} %"
    return f"under {least} %" if part > 0.0 and float(text) == 0.0 else f"{text} %"


def of(name: str, found: Row) -> str:
    """Return the unit of something measured, nothing where it is dimensionless."""
    return str(found.get("units", {}).get(name, ""))


def between(ends: Sequence[float], digits: int = 6) -> str:
    """Return a range, or one number if both ends read the same."""
    low, high = (short(end, digits) for end in ends)
    return low if low == high else f"{low} to {high}"


def places(ranges: Sequence[Sequence[float]]) -> str:
    """Return where something holds; of many ranges the first, and where the last one ends."""
    if len(ranges) <= RANGES:
        return ", ".join(map(between, ranges))
    return f"{between(ranges[0])}, ... up to {short(ranges[-1][1])} ({len(ranges)} ranges)"


def named(row: Row) -> list[str]:
    """Return the word and the kind of an attractor."""
    word = row["word"] or "-"
    return [word if len(word) <= LONGEST else f"{word[: LONGEST - 3]}...", row["kind"]]


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    """Return the first rows as a table, and how many there are beyond."""
    more = len(rows) - ROWS
    shown = aligned(head, rows[:ROWS]) if rows else []
    return [*shown, f"and {more} more; --json lists them"] if more > 0 else shown


def event_words(events: Mapping[str, int]) -> list[str]:
    """Return what happened at some steps."""
    told = ", ".join(f"{name.replace('_', ' ')} at {count} steps" for name, count in events.items())
    return [told.replace(" 1 steps", " 1 step")] if told else []


def unit_in(result: Any, *names: str) -> str:
    """Return the unit of the first of some variables that a result has, nothing where it is dimensionless."""
    unit = next((str(result[name].attrs.get("units", "1")) for name in names if name in result), "1")
    return "" if unit == "1" else unit


def special_words(special: Sequence[Row], name: str, virtual: bool) -> list[str]:
    """Return the table of special points."""
    shown = [row for row in special if virtual or row["admissible"]]
    rows: list[list[str]] = []
    seen: set[tuple[Any, ...]] = set()
    for row in sorted(shown, key=lambda row: float(row["value"])):
        place = row["type"], row.get("wall"), f"{row['value']:.9g}", row["period"], row["admissible"]
        if place in seen:  # several branches pass through it
            continue
        seen.add(place)
        converged = "yes" if row["converged"] else "no"
        kept = "admissible" if row["admissible"] else "virtual"
        width = f"{row['high'] - row['low']:.1e}"
        type = f"{row['type']} at {row['wall']}" if row.get("wall") else row["type"]
        rows.append([type, f"{row['value']:.13g}", width, converged, str(row["period"]), kept])
    said = aligned(["special point", name, "bracket", "converged", "period", ""], rows) if rows else []
    said += legend({row["type"]: row["meaning"] for row in shown})
    if not special:
        said.append("no special point")
    if len(shown) < len(special):
        more = "more " if shown else "special points "
        said.append(f"{len(special) - len(shown)} {more}on virtual parts; --virtual lists them")
    return [*said, ""]


def legend(words: Mapping[str, str]) -> list[str]:
    """Return what types mean, one a line."""
    return [f"{kind.ljust(4)} {meaning}" for kind, meaning in words.items()]


def window_words(windows: Sequence[Row], name: str) -> list[str]:
    """Return the table of the windows of branches."""
    if not windows:
        return ["no window: nowhere is an orbit stable and admissible", ""]
    head = ["window", "period", f"{name} from", "", "to", ""]
    rows = [
        [w["word"], str(w["period"]), f"{w['low']:.13g}", w["low_type"], f"{w['high']:.13g}", w["high_type"]]
        for w in windows
    ]
    return [*aligned(head, rows), ""]


def unfinished_words(result: Any) -> list[str]:
    """Return what a limit has cut off, a line, or none."""
    said = result.attrs.get("unfinished", "")
    return [f"unfinished: {said}", ""] if said else []


def words_of(study: Study, found: Row, result: Any = None, recipe: Any = None) -> list[str]:
    """Return what a study found as lines, with an empty line at the end."""
    said = study.words(found, result, recipe)
    if study.orbits:
        return said
    if found.get("ambiguous"):
        said.append(f"{found['ambiguous']} {study.counts} are ambiguous: a decision was closer than rounding")
    if "note" in found:
        said.append(f"note: {found['note']}")
    return [*said, ""]
