"""Lyapunov exponents, as they are asked for and told."""

from __future__ import annotations

from math import isnan
from typing import Any

from grazing.catalogue.rows import attractor, numbered
from grazing.catalogue.study import Row, Study
from grazing.catalogue.words import ROWS, between, headed, named, of, share, short, table


def found(result: Any) -> Row:
    """Return the exponents of each attractor at one value; over a range how the largest one varies and changes sign."""
    import numpy as np

    exponent = result["exponent"].values
    if result["period"].ndim == 1:
        return {"attractors": measured(result), "starts": len(exponent)}
    name = str(result["period"].dims[0])
    grid, order = result[name].values.astype(np.float64), np.argsort(result[name].values, kind="stable")
    every = np.where(np.isnan(exponent[..., 0]), -np.inf, exponent[..., 0])
    known = ~np.isnan(exponent[..., 0]).all(axis=1)
    x, largest = grid[order][known[order]], every.max(axis=1)[order][known[order]]
    said: Row = {"parameter": name, "values": len(grid), "known": int(known.sum())}
    if not x.size:
        return said
    up = largest > 0.0
    turns = np.flatnonzero(up[1:] != up[:-1])
    return said | {
        "least": {"exponent": float(largest.min()), name: float(x[largest.argmin()])},
        "greatest": {"exponent": float(largest.max()), name: float(x[largest.argmax()])},
        "positive": int(up.sum()),
        "sign_changes": [[float(x[i]), float(x[i + 1])] for i in turns],
    }


def measured(result: Any) -> list[Row]:
    """Return the attractors at one value with the ranges of their exponents, the greatest exponent first."""
    import numpy as np

    kinds, which = numbered(result["period"].values, result["word"].values)
    rows = []
    for i, (period, word) in enumerate(kinds):
        here = which == i
        row = attractor(period, word, share=float(here.mean()))
        for name in ("exponent", "exponent_per_time", "return_time"):
            if name in result:
                numbers = result[name].values[here]
                row[name] = (
                    np.column_stack([numbers.min(axis=0), numbers.max(axis=0)]).tolist()
                    if numbers.ndim > 1
                    else [float(numbers.min()), float(numbers.max())]
                )
        rows.append(row)
    return sorted(rows, key=lambda row: -row["share"])


def words(found: Row, *_of: Any) -> list[str]:
    """Return the exponents, or over a range how the largest one varies."""
    if "starts" in found:
        return exponent_words(found)
    name, known, unit = found["parameter"], found["known"], found.get("unit", "")
    if not known:
        return ["no value has an orbit with exponents"]
    ends = [
        f"{short(found[end]['exponent'], 4)} at {name} = {short(found[end][name])} {unit}".rstrip()
        for end in ("least", "greatest")
    ]
    said = [f"largest exponent per step: from {ends[0]} to {ends[1]}"]
    said.append(f"positive at {found['positive']} of {known} values")
    turns = found["sign_changes"]
    if turns:
        first = ", ".join(between(turn) for turn in turns[:ROWS])
        more = f" and {len(turns) - ROWS} more" if len(turns) > ROWS else ""
        said.append(f"changes sign between neighbours {name} = {first}{more}")
    if known < found["values"]:
        said.append(f"none at {found['values'] - known} values: no orbit has a derivative there")
    return said


def exponent_words(found: Row) -> list[str]:
    """Return the exponents at one value: of a cycle from its multipliers, else the means that the starts gave."""
    rows = []
    for row in found["attractors"]:
        digits = 6 if row["period"] > 0 else 3
        if isnan(row["exponent"][0][0]):  # of orbits that ended, and at a graze
            none = ["-"] * (3 if "return_time" in row else 1)
            rows.append([*named(row), share(row["share"], found["starts"]), *none])
            continue
        cells = ["; ".join(between(ends, digits) for ends in row["exponent"])]
        if "return_time" in row:
            cells += ["; ".join(between(ends, digits) for ends in row["exponent_per_time"])]
            cells += [between(row["return_time"], digits)]
        rows.append([*named(row), share(row["share"], found["starts"]), *cells])
    timed = any("return_time" in row for row in found["attractors"])
    times = [("per time", "exponent_per_time"), ("time of a step", "return_time")] if timed else []
    head = ["word", "", "starts", "exponents per step", *(headed(says, of(name, found)) for says, name in times)]
    return table(head, rows)


STUDY = Study(
    name="lyapunov", place=50, compute="grazing.studies.lyapunov:lyapunov", most=1,
    says="Lyapunov exponents",
    help="Compute Lyapunov exponents.",
    example="d=0.05:0.16:500 -o exponents.png",
    prints="at one value the exponents and the mean time of a step; over a range the least and the greatest largest "
    "exponent, and where its sign changes",
    found=found, words=words, undrawn="there is no figure of exponents at one value",
)  # fmt: skip
