"""Tables of orbits, branches and windows in words."""

from __future__ import annotations

import json as text
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

from grazing.cli.orbit_rows import Row


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


def complex_text(parts: Sequence[float]) -> str:
    """Return a multiplier in words."""
    real, imag = parts
    return short(real, 5) if imag == 0.0 else f"{real:.5g}{imag:+.5g}i"


def unfinished(result: Any) -> list[str]:
    """Return what a limit has cut off, a line, or none."""
    said = result.attrs.get("unfinished", "")
    return [f"unfinished: {said}", ""] if said else []


def orbit_words(tables: Mapping[str, Any], result: Any, recipe: Mapping[str, Any]) -> list[str]:
    """Return the table of orbits and how they were found."""
    rows = []
    for row in tables["orbits"]:
        kind = "stable" if row["stable"] else "neutral" if row["neutral"] else "unstable"
        kind = f"symmetric, {kind}" if row.get("symmetric") else kind
        first = ", ".join(short(x, 9) for x in row["points"][0])
        roots = ", ".join(map(complex_text, row["multipliers"]))
        impacts = "-" if row["impacts"] < 0 else str(row["impacts"])
        cells = row["word"], str(row["period"]), impacts, kind, "admissible" if row["admissible"] else "virtual"
        rows.append([*cells, roots, short(row["condition"], 3), first])
    head = ["word", "period", "impacts", "", "", "multipliers", "condition"]
    point = ", ".join(f"{name} {unit_in(result, name)}".rstrip() for name in tables["coordinates"])
    table = aligned([*head, f"first point ({point})"], rows) if rows else []
    return [*table, *([""] if table else []), f"{tables['statement']}.", ""]


def unit_in(result: Any, *names: str) -> str:
    """Return the unit of the first of some variables that a result has, nothing where it is dimensionless."""
    unit = next((str(result[name].attrs.get("units", "1")) for name in names if name in result), "1")
    return "" if unit == "1" else unit


def headed(name: str, unit: str) -> str:
    """Return a name as it stands over a column."""
    return f"{name} ({unit})" if unit else name


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


def branch_words(tables: Mapping[str, Any], result: Any, recipe: Mapping[str, Any]) -> list[str]:
    """Return special points, windows and meetings."""
    [name] = recipe["vary"]
    virtual = bool(recipe["settings"].get("virtual"))
    head = headed(name, unit_in(result, name))
    said = special_words(tables["special"], head, virtual) + window_words(tables["windows"], head)
    said += [f"not followed: {why}" for why in tables["not_followed"]] + unfinished(result)
    if "loci" not in tables:
        return said
    first, second = text.loads(result.attrs["locus_parameters"])
    rows = [
        [one["type"], one["word"], str(one["points"]), *(" to ".join(map(short, one[n])) for n in (first, second))]
        for one in tables["loci"]
    ]
    heads = [headed(each, unit_in(result, f"locus_{each}")) for each in (first, second)]
    said += [*aligned(["locus", "word", "points", *heads], rows), ""] if rows else ["no locus", ""]
    met = [
        [
            one["type"],
            f"{one[first]:.10g}",
            f"{one[second]:.10g}",
            tables["loci"][one["locus"]]["type"],
            "admissible" if one["admissible"] else "virtual",
        ]
        for one in tables["meetings"]
    ]
    said += [*aligned(["meeting", *heads, "on locus", ""], met), ""] if met else ["no meeting of two of them", ""]
    return [*said, *(f"not followed: {why}" for why in tables["locus_not_followed"])]


def slope(x: float, error: float) -> str:
    """Return a derivative in words: 0 where it is not told from rounding, nothing where the edge is no zero."""
    if math.isnan(x):
        return "-"
    return "0" if abs(x) <= error else f"{x:+.4g}"


def edge_words(tables: Mapping[str, Any], result: Any, recipe: Mapping[str, Any]) -> list[str]:
    """Return the table of windows, what their types mean, and derivatives."""
    [name] = recipe["vary"]
    low, high = tables["span"]
    unit = unit_in(result, "low")
    rows = [
        [str(w["N"]), f"{w['low']:.13g}", w["low_type"], f"{w['high']:.13g}", w["high_type"], w["piece"]]
        for w in tables["windows"]
    ]
    if not rows:
        asked = ", ".join(map(str, recipe["settings"]["N"]))
        none = f"no window with N = {asked} for {name} from {low:g} to {high:g} {unit}".rstrip()
        return [f"{none}; try another range, or other periods with --N", ""]
    head = ["N", f"{headed(name, unit)} from", "", "to", "", "piece of the law"]
    if {row[-1] for row in rows} == {"whole"}:  # of a law in one piece there is nothing to say
        head, rows = head[:-1], [row[:-1] for row in rows]
    said = [*aligned(head, rows), ""]
    seen = {row[side] for row in tables["windows"] for side in ("low_type", "high_type")}
    said += legend({kind: words for kind, words in tables["meanings"].items() if kind in seen})
    said.append(f"searched: {name} from {low:g} to {high:g} {unit}".rstrip())
    if "derivative" in result:
        moved = [key for key in result["moved"].values.tolist() if key != name]
        slopes = [
            [
                f"{w['N']} {side}",
                *(slope(w[f"{side}_derivatives"][key], w[f"{side}_errors"][key]) for key in moved),
            ]
            for w in tables["windows"]
            for side in ("low", "high")
        ]
        said += ["", f"derivatives of the edges in {name}:", *aligned(["edge", *moved], slopes)]
    return [*said, ""]


def diagram_words(tables: Mapping[str, Any], result: Any, recipe: Mapping[str, Any]) -> list[str]:
    """Return windows, special points on them and disagreements."""
    [name] = recipe["vary"]
    admissible = [row for row in tables["special"] if row["admissible"]]
    head = headed(name, unit_in(result, name))
    said = window_words(tables["windows"], head) + special_words(admissible, head, virtual=False)
    said += unfinished(result)
    if not tables["disagreements"]:
        return [*said, "scan and branches agree", ""]
    rows = []
    for one in tables["disagreements"]:
        place = short(one["low"]) if one["low"] == one["high"] else f"{short(one['low'])} to {short(one['high'])}"
        rows.append([one["kind"], place, str(one["values"]), one["word"], str(one["period"]), one["reason"]])
    return [*said, *aligned(["disagreement", head, "values", "word", "period", "why"], rows), ""]


def response_words(tables: Mapping[str, Any], result: Any, recipe: Mapping[str, Any]) -> list[str]:
    """Return where the sweeps differ, the greatest amplitudes and impact speeds, and the special points."""
    [name] = recipe["vary"]
    unit = unit_in(result, name)
    said = [f"up and down differ at {name} = {_between(one, unit)}" for one in tables["differences"]]
    said = said or ["up and down agree at every value"]
    told = {"amplitude": "greatest amplitude", "impact_speed": "greatest speed of an impact"}
    peaks = {(row["run"], row["reading"]): row for row in tables["peaks"]}
    rows = []
    for way in ("up", "down"):
        found = [peaks[way, reading] for reading in told if (way, reading) in peaks]
        if found:
            at = (f"{short(row['greatest'])} at {name} = {short(row[name])} {unit}".rstrip() for row in found)
            rows.append([way, *at])
    heads = [headed(said, unit_in(result, reading)) for reading, said in told.items()]
    table = [*aligned(["", *heads], rows), ""] if rows else []
    admissible = [row for row in tables["special"] if row["admissible"]]
    return [*said, "", *table, *special_words(admissible, headed(name, unit), False), *unfinished(result)]


def _between(one: Row, unit: str) -> str:
    """Return a range of values at which the sweeps differ, in words."""
    if one["values"] == 1:
        return f"{short(one['low'])} {unit}".rstrip()
    return " ".join(filter(None, (short(one["low"]), "to", short(one["high"]), unit, f"({one['values']} values)")))


WORDS: dict[str, Callable[[Mapping[str, Any], Any, Mapping[str, Any]], list[str]]] = {
    "orbit": orbit_words, "branch": branch_words, "windows": edge_words, "bifurcations": diagram_words,
    "response": response_words,
}  # fmt: skip
