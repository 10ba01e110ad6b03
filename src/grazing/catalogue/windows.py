"""Windows of orbits with one impact, as they are asked for and told."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import Any

from grazing.catalogue.rows import meanings, proof_row, rows_of
from grazing.catalogue.study import Row, Study
from grazing.catalogue.words import aligned, headed, legend, unit_in


def found(result: Any) -> dict[str, Any]:
    """Return the windows of one-impact orbits, with derivatives if there are any."""
    names = ("N", "low", "low_type", "low_status", "high", "high_type", "high_status", "piece")
    walls = ("word", "low_wall", "high_wall", "symmetric") if "word" in result else ()
    rows = rows_of(result, {name: name for name in (*names, *walls)})
    if "derivative" in result:
        moved, edges = result["moved"].values.tolist(), result["edge"].values.tolist()
        for row, slopes, errors in zip(rows, result["derivative"].values, result["error"].values, strict=True):
            for e, side in enumerate(edges):
                row[f"{side}_derivatives"] = dict(zip(moved, slopes[e].tolist(), strict=True))
                row[f"{side}_errors"] = dict(zip(moved, errors[e].tolist(), strict=True))
    found = {"windows": rows, "span": list(result.attrs["span"]), "meanings": meanings(result["low_type"])}
    failed = result.attrs.get("not_followed")
    return {**found, "not_followed": json.loads(failed)} if failed else found


def slope(x: float, error: float) -> str:
    """Return a derivative in words: 0 where it is not told from rounding, nothing where the edge is no zero."""
    if math.isnan(x):
        return "-"
    return "0" if abs(x) <= error else f"{x:+.4g}"


def _end(window: Row, side: str) -> str:
    """Return what ends a window, with the wall that it is at."""
    return f"{window[f'{side}_type']} {window.get(f'{side}_wall', '')}".rstrip()


def words(found: Mapping[str, Any], result: Any, recipe: Mapping[str, Any]) -> list[str]:
    """Return the table of windows, what their types mean, and derivatives."""
    [name] = recipe["vary"]
    low, high = found["span"]
    unit = unit_in(result, "low")
    left_out = [f"not followed: {why}" for why in found.get("not_followed", ())]
    rows = [
        [
            f"{w['N']} {w['word']}" if "word" in w else str(w["N"]),
            *(part for end in ("low", "high") for part in (f"{w[end]:.13g}", _end(w, end))),
            w["piece"],
        ]
        for w in found["windows"]
    ]
    if not rows:
        asked = ", ".join(map(str, result.attrs["N"]))
        asked += f" of {result.attrs['words']}" if "words" in result.attrs else ""
        none = f"no window with N = {asked} for {name} from {low:g} to {high:g} {unit}".rstrip()
        return [f"{none}; try another range, or other periods with --N", *left_out, ""]
    head = ["N" if "word" not in result else "N word", f"{headed(name, unit)} from", "", "to", "", "piece of the law"]
    if {row[-1] for row in rows} == {"whole"}:  # of a law in one piece there is nothing to say
        head, rows = head[:-1], [row[:-1] for row in rows]
    said = [*aligned(head, rows), ""]
    seen = {row[side] for row in found["windows"] for side in ("low_type", "high_type")}
    said += legend({kind: words for kind, words in found["meanings"].items() if kind in seen})
    said.append(f"searched: {name} from {low:g} to {high:g} {unit}".rstrip())
    if "derivative" in result:
        moved = [key for key in result["moved"].values.tolist() if key != name]
        slopes = [
            [
                f"{w['N']} {side}",
                *(slope(w[f"{side}_derivatives"][key], w[f"{side}_errors"][key]) for key in moved),
            ]
            for w in found["windows"]
            for side in ("low", "high")
        ]
        said += ["", f"derivatives of the edges in {name}:", *aligned(["edge", *moved], slopes)]
    return [*said, *left_out, ""]


def prove(of: Any, found: Any) -> list[Row]:
    """Return a proof of each edge of each window, or why there is none."""
    from grazing.proof.edges import edge_proofs

    proofs = []
    for w, side, proof in edge_proofs(of, found):
        row = found.isel(window=w)
        N, kind = int(row["N"]), str(row[f"{side}_type"].values)
        word = f" {row['word'].item()}" if "word" in row else ""
        stem = f"N{N}{word.replace(' ', '-')}-{side}-{kind}"
        head: Row = {"of": f"N = {N}{word}, {side} edge, {kind}", "window": w, "side": side, "stem": stem}
        provable = not (isinstance(proof, str) and proof.startswith("a proof needs"))
        told = {"proven": False, "reason": proof} if isinstance(proof, str) else proof_row(proof)
        proofs.append({**head, "due": provable, **told})
    return proofs


STUDY = Study(
    name="windows", place=150, compute="grazing.orbits.table:window_table", of="model", least=1, most=1, form="bounds",
    orbits=True,
    says="where stable one-impact orbits exist, or between walls those of words",
    help="List where stable one-impact orbits exist, or between walls those of words, and why they end.",
    example="d --N 2:7 --V 0.4 -o windows.png",
    prints="the windows, what ends each, and the derivatives of their edges",
    found=found, words=words, figure="windows", titled="windows of", takes_long="looking for windows",
    options={
        "samples": ("whole", 2, "cells of the first grid, 2000; between walls values at which orbits are searched, 16"),
        "words": ("text", "between walls, which of them an orbit hits, in order: A,AB,AABB"),
    },
    proves="the edges of the windows", prove=prove,
)  # fmt: skip
