"""What results of orbits, branches and windows say, as rows: for JSON, and for the tables in words."""

from __future__ import annotations

import json as text
import math
from collections.abc import Callable, Mapping
from typing import Any

Row = dict[str, Any]


def rows_of(result: Any, names: Mapping[str, str]) -> list[Row]:
    """Return variables on one dimension as rows, by new names."""
    columns = [result[name].values.tolist() for name in names.values()]
    return [dict(zip(names, row, strict=True)) for row in zip(*columns, strict=True)]


def unfinished(result: Any) -> dict[str, str]:
    """Return what a limit has cut off, if it was reached."""
    said = result.attrs.get("unfinished")
    return {} if said is None else {"unfinished": str(said)}


def orbit_rows(result: Any) -> dict[str, Any]:
    """Return the orbits of a result."""
    names = ["word", "period", "impacts", "stable", "neutral", "admissible", "condition", "residual"]
    names += [name for name in ("walls", "symmetric", "depth") if name in result]
    rows = rows_of(result, {name: name for name in names})
    coordinates = [str(name) for name in result.data_vars if result[name].dims == ("orbit", "n")]
    points = list(zip(*(result[name].values.tolist() for name in coordinates), strict=True))
    parts = [result[f"multiplier_{part}"].values.tolist() for part in ("real", "imag")]
    for row, point, real, imag in zip(rows, points, *parts, strict=True):
        for name in {"stable", "neutral", "admissible", "symmetric"} & {*row}:
            row[name] = bool(row[name])
        row["multipliers"] = [list(pair) for pair in zip(real, imag, strict=True)]
        row["points"] = [list(state) for state in zip(*point, strict=True)][: row["period"]]
    return {"orbits": rows, "coordinates": coordinates, "statement": result.attrs["statement"]}


def special_rows(result: Any) -> list[Row]:
    """Return the special points of a result, with what happens there in words."""
    names = ("type", "value", "low", "high", "converged", "admissible", "period", "piece", "to", "wall")
    rows = rows_of(result, {name: f"special_{name}" for name in names if f"special_{name}" in result})
    words = meanings(result["special_type"])
    for row in rows:
        row["converged"], row["admissible"] = bool(row["converged"]), bool(row["admissible"])
        row["meaning"] = words.get(row["type"], "")
    return rows


def window_rows(result: Any) -> list[Row]:
    """Return the windows of branches."""
    return rows_of(
        result, {name: f"window_{name}" for name in ("word", "period", "low", "low_type", "high", "high_type")}
    )


def branch_rows(result: Any) -> dict[str, Any]:
    """Return special points, windows and loci of a branch."""
    relabelled = rows_of(result, {name: f"relabelling_{name}" for name in ("value", "before", "after")})
    found = {
        "special": special_rows(result),
        "windows": window_rows(result),
        "relabellings": relabelled,
        **unfinished(result),
    }
    found["not_followed"] = text.loads(result.attrs.get("not_followed", "[]"))
    if "locus_parameters" not in result.attrs:
        return found
    names = text.loads(result.attrs["locus_parameters"])
    loci = rows_of(result, {"type": "locus_type", "word": "locus_word"})
    numbers = result["locus_number"].values.tolist()
    meetings = rows_of(
        result,
        {
            "locus": "meeting_number",
            "type": "meeting_type",
            "admissible": "meeting_admissible",
            **{name: f"meeting_{name}" for name in names},
        },
    )
    for row in meetings:
        row["admissible"] = bool(row["admissible"])
    for i, row in enumerate(loci):
        row["points"] = numbers.count(i)
        for name in names:
            along = [x for x, k in zip(result[f"locus_{name}"].values.tolist(), numbers, strict=True) if k == i]
            row[name] = [min(along), max(along)] if along else []
    failed = text.loads(result.attrs["locus_not_followed"])
    return {**found, "loci": loci, "meetings": meetings, "locus_not_followed": failed}


def edge_rows(result: Any) -> dict[str, Any]:
    """Return the windows of one-impact orbits, with derivatives if there are any."""
    names = ("N", "low", "low_type", "low_status", "high", "high_type", "high_status", "piece")
    rows = rows_of(result, {name: name for name in names})
    if "derivative" in result:
        moved, edges = result["moved"].values.tolist(), result["edge"].values.tolist()
        for row, slopes, errors in zip(rows, result["derivative"].values, result["error"].values, strict=True):
            for e, side in enumerate(edges):
                row[f"{side}_derivatives"] = dict(zip(moved, slopes[e].tolist(), strict=True))
                row[f"{side}_errors"] = dict(zip(moved, errors[e].tolist(), strict=True))
    return {"windows": rows, "span": list(result.attrs["span"]), "meanings": meanings(result["low_type"])}


def diagram_rows(result: Any) -> dict[str, Any]:
    """Return windows, special points and disagreements of a scan and its branches."""
    names = ("kind", "low", "high", "values", "word", "period", "reason")
    differ = rows_of(result, {name: f"disagreement_{name}" for name in names})
    return {
        "windows": window_rows(result),
        "special": special_rows(result),
        "disagreements": differ,
        **unfinished(result),
    }


def response_rows(result: Any) -> dict[str, Any]:
    """Return what the sweeps up and down read, where they differ, where each reading is greatest, special points."""
    readings = [str(key) for key in result.data_vars if f"special_{key}" in result and key != "period"]
    name, run = (str(dim) for dim in result["word"].dims)
    grid, runs = result[name].values.tolist(), result[run].values.tolist()
    swept, peaks = [], []
    for i, way in enumerate(runs):
        columns = {key: result[key].values[:, i].tolist() for key in (*readings, "period", "word")}
        rows = [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]
        if way in ("up", "down"):
            swept += [{run: way, name: value, **row} for value, row in zip(grid, rows, strict=True)]
        for reading in readings:
            read = [(row[reading], value) for value, row in zip(grid, rows, strict=True)]
            finite = [pair for pair in read if math.isfinite(pair[0])]
            if finite:
                most, where = max(finite)
                peaks.append({run: way, "reading": reading, "greatest": most, name: where})
    special = special_rows(result)
    for reading in readings:
        for row, value in zip(special, result[f"special_{reading}"].values.tolist(), strict=True):
            row[reading] = value
    differ = rows_of(result, {key: f"difference_{key}" for key in ("low", "high", "values")})
    return {"differences": differ, "special": special, "peaks": peaks, "swept": swept, **unfinished(result)}


def meanings(variable: Any) -> dict[str, str]:
    """Return what the types of edges and special points mean."""
    pairs = [item.partition(": ") for item in str(variable.attrs.get("meaning", "")).split("; ")]
    return {name: words for name, _colon, words in pairs}


TABLES: dict[str, Callable[[Any], dict[str, Any]]] = {
    "orbit": orbit_rows, "branch": branch_rows, "windows": edge_rows, "bifurcations": diagram_rows,
    "response": response_rows,
}  # fmt: skip


def plain(value: Any) -> Any:
    """Return what JSON can write: null for numbers that are not finite."""
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
