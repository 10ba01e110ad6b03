"""Branches of periodic orbits, as they are asked for and told."""

from __future__ import annotations

import json as text
from collections.abc import Mapping
from typing import Any

from grazing.catalogue.rows import rows_of, special_rows, unfinished, window_rows
from grazing.catalogue.study import Study
from grazing.catalogue.words import aligned, headed, short, special_words, unfinished_words, unit_in, window_words


def found(result: Any) -> dict[str, Any]:
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


def words(found: Mapping[str, Any], result: Any, recipe: Mapping[str, Any]) -> list[str]:
    """Return special points, windows and meetings."""
    [name] = recipe["vary"]
    virtual = bool(recipe["settings"].get("virtual"))
    head = headed(name, unit_in(result, name))
    said = special_words(found["special"], head, virtual) + window_words(found["windows"], head)
    said += [f"not followed: {why}" for why in found["not_followed"]] + unfinished_words(result)
    if "loci" not in found:
        return said
    first, second = text.loads(result.attrs["locus_parameters"])
    rows = [
        [one["type"], one["word"], str(one["points"]), *(" to ".join(map(short, one[n])) for n in (first, second))]
        for one in found["loci"]
    ]
    heads = [headed(each, unit_in(result, f"locus_{each}")) for each in (first, second)]
    said += [*aligned(["locus", "word", "points", *heads], rows), ""] if rows else ["no locus", ""]
    met = [
        [
            one["type"],
            f"{one[first]:.10g}",
            f"{one[second]:.10g}",
            found["loci"][one["locus"]]["type"],
            "admissible" if one["admissible"] else "virtual",
        ]
        for one in found["meetings"]
    ]
    said += [*aligned(["meeting", *heads, "on locus", ""], met), ""] if met else ["no meeting of two of them", ""]
    return [*said, *(f"not followed: {why}" for why in found["locus_not_followed"])]


STUDY = Study(
    name="branch", place=140, compute="grazing.compare.word_branches:branches", least=1, most=1, form="bounds",
    orbits=True,
    says="periodic orbits followed in a parameter",
    help="Follow the orbits of a word in a parameter, through folds and grazes.",
    example="d=0.02:0.14 --word 001 --V 0.4 -o branch.png",
    prints="the special points, where an orbit is stable, and where loci meet",
    found=found, words=words, options={"starts": ("whole", 1, "random starts of the search for orbits")},
    figure="branch", titled="branch in", takes_long="following branches",
)  # fmt: skip
