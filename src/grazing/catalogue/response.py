"""What instruments read along sweeps, as it is asked for and told."""

from __future__ import annotations

import math
from collections.abc import Mapping
from itertools import combinations, groupby
from typing import Any

from grazing.catalogue.rows import rows_of, special_rows, unfinished
from grazing.catalogue.study import Row, Study
from grazing.catalogue.words import aligned, headed, short, special_words, unfinished_words, unit_in

#: Readings nearer to the greatest one than this share are equal to it: between two stops amplitudes differ by rounding.
SAME = 1e-9


def found(result: Any) -> dict[str, Any]:
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
                most = max(one for one, _value in finite)
                where = [value for one, value in finite if one >= most - SAME * abs(most)]
                peaks.append({
                    run: way, "reading": reading, "greatest": most, name: min(where), "last": max(where),
                    "values": len(where),
                })  # fmt: skip
    special = special_rows(result)
    for reading in readings:
        for row, value in zip(special, result[f"special_{reading}"].values.tolist(), strict=True):
            row[reading] = value
    differ = rows_of(result, {key: f"difference_{key}" for key in ("low", "high", "values")})
    pairs = [
        [rows[i] for i, way in enumerate(runs) if way in ("up", "down")] for rows in result["period"].values.tolist()
    ]
    compared = sum(0 not in pair and (max(pair) >= 1 or len({*pair}) > 1) for pair in pairs)
    return {
        "differences": differ, "compared": compared, "values": len(grid), "coexist": coexisting(result, name),
        "special": special, "peaks": peaks, "swept": swept, **unfinished(result),
    }  # fmt: skip


def coexisting(result: Any, name: str) -> list[list[float]]:
    """Return the ranges over which two stretches of stable orbits of branches lie side by side."""
    columns = (result[f"branch_{key}"].values.tolist() for key in ("piece", "event", "stable", "admissible", name))
    rows = [(piece, event, stable and kept, value) for piece, event, stable, kept, value in zip(*columns, strict=True)]
    beside = [{row[0] for row in rows[max(i - 1, 0) : i + 2] if row[2]} for i in range(len(rows))]
    good = [bool(row[2] or (row[1] and row[0] in pieces)) for row, pieces in zip(rows, beside, strict=True)]
    stretches = [
        (min(values), max(values))
        for (_piece, inside), some in groupby(zip(rows, good, strict=True), lambda one: (one[0][0], one[1]))
        if inside and (values := [row[3] for row, _good in some])
    ]
    both = sorted((max(a, c), min(b, d)) for (a, b), (c, d) in combinations(stretches, 2))
    joined: list[list[float]] = []
    for low, high in both:
        if joined and low <= joined[-1][1]:
            joined[-1][1] = max(joined[-1][1], high)
        elif high > low:
            joined.append([low, high])
    return joined


def words(found: Mapping[str, Any], result: Any, recipe: Mapping[str, Any]) -> list[str]:
    """Return where the sweeps differ, the greatest amplitudes and impact speeds, and the special points."""
    [name] = recipe["vary"]
    unit = unit_in(result, name)
    said = [f"up and down differ at {name} = {_between(one, unit)}" for one in found["differences"]]
    if not said:
        every = found["compared"] == found["values"]
        many = "every value" if every else f"{found['compared']} of {found['values']} values; the others have no period"
        said = [f"up and down agree at {many}"]
    ranges = ", ".join(f"{short(low)} to {short(high)}" for low, high in found["coexist"])
    said += [f"two stable orbits at {name} = {ranges} {unit}".rstrip()] if ranges else []
    told = {"amplitude": "greatest amplitude", "impact_speed": "greatest speed of an impact"}
    peaks = {(row["run"], row["reading"]): row for row in found["peaks"]}
    rows = []
    for way in ("up", "down"):
        greatest = [peaks[way, reading] for reading in told if (way, reading) in peaks]
        if greatest:
            rows.append([way, *(f"{short(row['greatest'])} at {_attained(row, name, unit)}" for row in greatest)])
    heads = [headed(said, unit_in(result, reading)) for reading, said in told.items()]
    table = [*aligned(["", *heads], rows), ""] if rows else []
    admissible = [row for row in found["special"] if row["admissible"]]
    return [*said, "", *table, *special_words(admissible, headed(name, unit), False), *unfinished_words(result)]


def _attained(peak: Row, name: str, unit: str) -> str:
    """Return where a reading is greatest, in words."""
    if peak["values"] == 1:
        return f"{name} = {short(peak[name])} {unit}".rstrip()
    return f"{peak['values']} values of {name}, {short(peak[name])} to {short(peak['last'])} {unit}".rstrip()


def _between(one: Row, unit: str) -> str:
    """Return a range of values at which the sweeps differ, in words."""
    if one["values"] == 1:
        return f"{short(one['low'])} {unit}".rstrip()
    return " ".join(filter(None, (short(one["low"]), "to", short(one["high"]), unit, f"({one['values']} values)")))


STUDY = Study(
    name="response", place=170, compute="grazing.compare.response:response", least=1, most=1, orbits=True,
    says="what instruments read going up, going down and from random starts",
    help="Show what instruments read going up, going down and from random starts, and the branches through it.",
    example="omega=2:3:200 --V 0.4 -o response.png",
    prints="where the sweeps differ, the greatest readings, and the special points",
    found=found, words=words, options={"period": ("whole", 1, "longest period of an attractor that is followed")},
    takes_long="points of branches",
)  # fmt: skip
