"""Launches that graze an object of a pinball table, as they are asked for and told."""

from __future__ import annotations

from typing import Any

from grazing.catalogue.study import Row, Study
from grazing.catalogue.words import short, table


def found(result: Any) -> Row:
    """Return for each object and word how many curves there are, and between which launches."""
    import numpy as np

    rows: dict[tuple[Any, ...], Row] = {}
    names = [result[name].values.tolist() for name in ("order", "word", "object", "kick")]
    numbers, ends = result["row"].values, {name: result[name].values for name in ("angle", "speed")}
    for k, (order, word, name, kick) in enumerate(zip(*names, strict=True)):
        row = rows.setdefault(
            (order, word, name),
            {"object": name, "word": word, "order": order, "kick": kick, "curves": 0}
            | {each: [float("inf"), -float("inf")] for each in ends},
        )
        row["curves"] += 1
        for each, values in ends.items():
            here = values[numbers == k]
            row[each] = [min(row[each][0], float(np.nanmin(here))), max(row[each][1], float(np.nanmax(here)))]
    return {
        "curves": int(result.sizes["curve"]),
        "points": int(np.isfinite(ends["angle"]).sum()),
        "grazes": list(rows.values()),
        "ambiguous": 0,
    }


def words(found: Row, *_of: Any) -> list[str]:
    """Return a row for each object and word."""
    rows = [
        [row["object"], row["word"] or "-", short(row["kick"], 4) if row["kick"] else "-", str(row["curves"]),
         *(" to ".join(short(end, 5) for end in row[name]) for name in ("angle", "speed"))]
        for row in found["grazes"]
    ]  # fmt: skip
    said = table(["grazed", "after", "kick", "curves", "angle", "speed"], rows) if rows else ["no graze found"]
    return [*said, f"{found['curves']} curves of {found['points']} points"]


STUDY = Study(
    name="grazes", place=76, compute="grazing.studies.grazed:grazed", most=2, varies="coordinate",
    says="launches on a pinball table that graze an object, as curves over angle and speed",
    help="Find the launches on a pinball table that graze an object, as curves over angle and speed.",
    example="--table classic angle=1.2:1.9:65 speed=12:22:65 --impacts 1 -o grazes.png",
    prints="for each object and what is hit before it, the curves and between which launches they are",
    options={
        "impacts": ("whole", 0, "impacts before the graze, at most"),
        "objects": ("text", "names of those that are grazed, commas between; all if not given"),
    },
    found=found, words=words, figure="grazes", titled="grazes of", takes_long="looking for grazes", counts="curves",
    tables_only=True,
)  # fmt: skip
