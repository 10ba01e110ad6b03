"""All attractors along a parameter, as they are asked for and told."""

from __future__ import annotations

from typing import Any

from grazing.catalogue.rows import AMBIGUOUS, attractor, ranges_of
from grazing.catalogue.study import Row, Study
from grazing.catalogue.words import headed, named, places, table


def found(result: Any) -> Row:
    """Return the attractors with where they were reached and their greatest share, and the changes in order."""
    import numpy as np

    share = result["share"].values
    name = next(str(dim) for dim in result["share"].dims if dim != "attractor")
    grid = result[name].values.astype(np.float64)
    columns = result["period"].values.tolist(), result["word"].values.tolist(), share.T
    rows = [
        attractor(p, w, values=int((s > 0.0).sum()), greatest=float(s.max()), ranges=ranges_of(grid, s > 0.0))
        for p, w, s in zip(*columns, strict=True)
    ]
    names = "before", "after", "kind", "word_before", "word_after", "period_before", "period_after"
    changes = zip(*(result[key].values.tolist() for key in names), strict=True)
    return {
        "parameter": name,
        "values": len(grid),
        "attractors": rows,
        "most_at_once": int((share > 0.0).sum(axis=1).max()),
        "changes": [dict(zip(names, change, strict=True)) for change in changes],
        "ambiguous": int((result["trust"].values == AMBIGUOUS).sum()),
    }


def words(found: Row, *_of: Any) -> list[str]:
    """Return the attractors, where each was reached, and how many changes there are."""
    name = found["parameter"]
    ranked = sorted(found["attractors"], key=lambda row: -row["values"])
    rows = [
        [
            *named(row),
            f"{row['values']} of {found['values']}",
            f"{100.0 * row['greatest']:.0f} %",
            places(row["ranges"]),
        ]
        for row in ranked
    ]
    said = table(["word", "", "values", "most starts", f"{headed(name, found.get('unit', ''))} from"], rows)
    said.append(f"at most {found['most_at_once']} at one value")
    kinds: dict[str, int] = {}
    for change in found["changes"]:
        kinds[change["kind"]] = kinds.get(change["kind"], 0) + 1
    told = ", ".join(f"{kind} {count}" for kind, count in kinds.items())
    return [*said, f"changes between neighbouring values: {told or 'none'}"]


STUDY = Study(
    name="coexistence", place=60, compute="grazing.studies.coexistence:coexistence", least=1, most=1,
    says="all attractors and their shares",
    help="Follow all attractors and their shares of the starts as one parameter varies.",
    example="d=0.05:0.16:500 --starts 200 -o shares.png",
    prints="the attractors by word and period, how many orbits reach them, and at which values",
    found=found, words=words, takes_long="following the attractors",
)  # fmt: skip
