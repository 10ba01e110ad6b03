"""A scan and the branches through it, as they are asked for and told."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from grazing.catalogue.rows import rows_of, special_rows, unfinished, window_rows
from grazing.catalogue.study import Study
from grazing.catalogue.words import aligned, headed, short, special_words, unfinished_words, unit_in, window_words


def found(result: Any) -> dict[str, Any]:
    """Return windows, special points and disagreements of a scan and its branches."""
    names = ("kind", "low", "high", "values", "word", "period", "reason")
    differ = rows_of(result, {name: f"disagreement_{name}" for name in names})
    return {
        "windows": window_rows(result),
        "special": special_rows(result),
        "disagreements": differ,
        **unfinished(result),
    }


def words(found: Mapping[str, Any], result: Any, recipe: Mapping[str, Any]) -> list[str]:
    """Return windows, special points on them and disagreements."""
    [name] = recipe["vary"]
    admissible = [row for row in found["special"] if row["admissible"]]
    head = headed(name, unit_in(result, name))
    said = window_words(found["windows"], head) + special_words(admissible, head, virtual=False)
    said += unfinished_words(result)
    if not found["disagreements"]:
        return [*said, "scan and branches agree", ""]
    rows = []
    for one in found["disagreements"]:
        place = short(one["low"]) if one["low"] == one["high"] else f"{short(one['low'])} to {short(one['high'])}"
        rows.append([one["kind"], place, str(one["values"]), one["word"], str(one["period"]), one["reason"]])
    return [*said, *aligned(["disagreement", head, "values", "word", "period", "why"], rows), ""]


STUDY = Study(
    name="bifurcations", place=160, compute="grazing.compare.bifurcation_diagram:bifurcation_diagram", least=1, most=1,
    orbits=True,
    says="a scan and the branches through it",
    help="Show a scan and the branches through it, and where the two disagree.",
    example="d=0.05:0.16:600 --V 0.4 -o bifurcations.png",
    prints="the windows and the special points, and where scan and branches disagree",
    found=found, words=words, options={"period": ("whole", 1, "longest period of an attractor that is followed")},
    titled="bifurcation diagram", takes_long="points of branches",
)  # fmt: skip
