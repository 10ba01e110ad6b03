"""Launches of a ball on a pinball table: where they leave and how long they last, as they are asked for and told."""

from __future__ import annotations

from typing import Any

from grazing.catalogue.study import Row, Study
from grazing.catalogue.words import share, short, table


def found(result: Any) -> Row:
    """Return the ways out with their shares of the launches, and impacts and times until then."""
    import numpy as np

    ways, hits, times = (result[name].values.ravel() for name in ("exit", "hits", "time"))
    rows = []
    for name in sorted({*ways.tolist()}, key=lambda name: -int((ways == name).sum())):
        here = ways == name
        lasts = times[here & np.isfinite(times)]
        rows.append(
            {
                "exit": name,
                "share": float(here.mean()),
                "hits": float(hits[here].mean()),
                "time": float(np.median(lasts)) if len(lasts) else None,
            }
        )
    return {
        "launches": int(ways.size),
        "ways": rows,
        "hits": [int(hits.min()), int(hits.max())],
        "ambiguous": 0,
    }


def words(found: Row, *_of: Any) -> list[str]:
    """Return a row for each way out."""
    rows = [
        [row["exit"] or "still there", share(row["share"], found["launches"]), short(row["hits"], 4),
         "-" if row["time"] is None else short(row["time"], 4)]
        for row in found["ways"]
    ]  # fmt: skip
    said = table(["exit", "share", "impacts, mean", "time, median"], rows)
    return [*said, f"{found['launches']} launches with {found['hits'][0]} to {found['hits'][1]} impacts"]


STUDY = Study(
    name="launches", place=75, compute="grazing.studies.exits:exits", most=2, varies="coordinate",
    says="where launches on a pinball table leave, after how many impacts, and when",
    help="Launch balls on a pinball table: where each leaves, after how many impacts, and when.",
    example="--table classic angle=1.2:1.9:200 speed=12:22:200 -o exits.png",
    prints="the ways out with their shares, mean impacts and median times",
    found=found, words=words, figure="launches", takes_long="launching balls", counts="launches", tables_only=True,
)  # fmt: skip
