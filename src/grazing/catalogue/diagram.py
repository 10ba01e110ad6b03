"""The orbit diagram, as it is asked for and told."""

from __future__ import annotations

from typing import Any

from grazing.catalogue.rows import AMBIGUOUS, attractor, numbered, ranges_of
from grazing.catalogue.study import Row, Study
from grazing.catalogue.words import headed, named, places, share, table

#: Drift, in sides of the box, that a figure shows.
VISIBLE = 1e-3


def found(result: Any) -> Row:
    """Return the attractors of an orbit diagram, those that most orbits reach first, and where each was reached."""
    import numpy as np

    name = str(result["period"].dims[0])
    grid = result[name].values.astype(np.float64)
    kinds, which = numbered(result["period"].values, result["word"].values)
    rows = []
    for i, (period, word) in enumerate(kinds):
        here = which == i
        reached = here.any(axis=1)
        rows.append(
            attractor(
                period, word, share=float(here.mean()), values=int(reached.sum()), ranges=ranges_of(grid, reached)
            )
        )
    rows.sort(key=lambda row: -row["share"])
    doubtful = int((result["trust"].values == AMBIGUOUS).sum())
    drift = result["drift"].values if "drift" in result else np.zeros(0)  # of a file made before 0.2
    return {
        "parameter": name, "values": len(grid), "orbits": which.size, "attractors": rows, "ambiguous": doubtful,
        "unsettled": int((drift > VISIBLE).sum()),
    }  # fmt: skip


def words(found: Row, *_of: Any) -> list[str]:
    """Return the attractors of a diagram, with the values at which each was reached."""
    name, many = found["parameter"], found["orbits"]
    rows = [
        [*named(row), share(row["share"], many), f"{row['values']} of {found['values']}", places(row["ranges"])]
        for row in found["attractors"]
    ]
    told = table(["word", "", "orbits", "values", f"{headed(name, found.get('unit', ''))} from"], rows)
    if found.get("unsettled"):
        part = share(found["unsettled"] / many, many)
        told += ["", f"{part} of the orbits are still on their way to their cycle, and move by more than {VISIBLE:g} "
                 "of the box in a period: a longer transient settles them"]  # fmt: skip
    return told


STUDY = Study(
    name="diagram", place=10, compute="grazing.studies.orbit_diagram:orbit_diagram", least=1, most=1,
    says="where orbits settle as one parameter varies",
    help="Show where orbits settle as one parameter varies.",
    example="d=0.05:0.16:500 --V 0.4 -o diagram.png",
    prints="the attractors by word and period, how many orbits reach them, and at which values",
    found=found, words=words,
)  # fmt: skip
