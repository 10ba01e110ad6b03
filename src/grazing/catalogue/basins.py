"""Basins of attraction, as they are asked for and told."""

from __future__ import annotations

import math
from typing import Any

from grazing.catalogue.rows import AMBIGUOUS, attractor
from grazing.catalogue.study import Row, Study
from grazing.catalogue.words import named, of, share, short, table


def found(result: Any) -> Row:
    """Return the attractors with their shares of the grid, and what the boundary between them is like."""
    import numpy as np

    columns = (result[name].values.tolist() for name in ("period", "word", "fraction", "point"))
    rows = [attractor(p, w, share=share, point=point) for p, w, share, point in zip(*columns, strict=True)]
    for row, neutral in zip(rows, result["neutral"].values.tolist() if "neutral" in result else (), strict=False):
        row |= {"neutral": bool(neutral)} | ({"kind": f"{row['kind']}, a neutral continuum"} if neutral else {})
    said = {
        "states": int(result["basin"].size),
        "coordinates": result["coordinate"].values.tolist(),
        "attractors": rows,
        "ambiguous": int((result["trust"].values == AMBIGUOUS).sum()),
    }
    about = ("basin_entropy", "uncertainty_exponent", "uncertainty_error", "boundary_dimension")
    return said | {name: float(x) for name in about if np.isfinite(x := result.attrs.get(name, np.nan))}


def words(found: Row, *_of: Any) -> list[str]:
    """Return the attractors with their basins, and the dimension of the boundary."""
    many = found["states"]
    rows = []
    for row in found["attractors"]:
        point = ", ".join(short(x) for x in row["point"]) if all(map(math.isfinite, row["point"])) else "-"
        rows.append([*named(row), share(row["share"], many), point])
    point = ", ".join(f"{name} {of(name, found)}".rstrip() for name in found["coordinates"])
    said = table(["word", "", "share", f"point ({point})"], rows)
    if "boundary_dimension" in found:
        dimension, error = short(found["boundary_dimension"], 3), short(found["uncertainty_error"], 1)
        said.append(f"dimension of the boundary {dimension}, standard error {error}")
    return said


STUDY = Study(
    name="basins", place=40, compute="grazing.studies.basins:basins", most=2, varies="coordinate",
    says="which attractor each initial state reaches",
    help="Show which attractor each initial state reaches.",
    example="u=0:0.3:400 v=-0.5:0.5:400 --d 0.1 -o basins.png",
    prints="the attractors with their shares and a point of each, the dimension of the boundary",
    found=found, words=words, takes_long="following the attractors and the grazing curve", counts="initial states",
)  # fmt: skip
