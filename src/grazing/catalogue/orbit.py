"""Periodic orbits, as they are asked for and told."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from grazing.catalogue.rows import proof_row, rows_of
from grazing.catalogue.study import Row, Study
from grazing.catalogue.words import aligned, short, unit_in
from grazing.outcome import GrazingError


def found(result: Any) -> dict[str, Any]:
    """Return the orbits of a result."""
    names = ["word", "period", "impacts", "stable", "neutral", "admissible", "condition", "residual"]
    names += [name for name in ("walls", "symmetric", "depth") if name in result]
    rows = rows_of(result, {name: name for name in names})
    coordinates = [str(name) for name in result.data_vars if result[name].dims == ("orbit", "n")]
    points = list(zip(*(result[name].values.tolist() for name in coordinates), strict=True))
    parts = [result[f"multiplier_{part}"].values.tolist() for part in ("real", "imag")]
    for row, point, real, imag in zip(rows, points, *parts, strict=True):
        for name in {"stable", "neutral", "admissible", "symmetric"} & {*row}:
            row[name] = bool(row[name])
        row["multipliers"] = [list(pair) for pair in zip(real, imag, strict=True)]
        row["points"] = [list(state) for state in zip(*point, strict=True)][: row["period"]]
    return {"orbits": rows, "coordinates": coordinates, "statement": result.attrs["statement"]}


def complex_text(parts: Sequence[float]) -> str:
    """Return a multiplier in words."""
    real, imag = parts
    return short(real, 5) if imag == 0.0 else f"{real:.5g}{imag:+.5g}i"


def words(found: Mapping[str, Any], result: Any, recipe: Mapping[str, Any]) -> list[str]:
    """Return the table of orbits and how they were found."""
    rows = []
    for row in found["orbits"]:
        kind = "stable" if row["stable"] else "neutral" if row["neutral"] else "unstable"
        kind = f"symmetric, {kind}" if row.get("symmetric") else kind
        first = ", ".join(short(x, 9) for x in row["points"][0])
        roots = ", ".join(map(complex_text, row["multipliers"]))
        impacts = "-" if row["impacts"] < 0 else str(row["impacts"])
        cells = row["word"], str(row["period"]), impacts, kind, "admissible" if row["admissible"] else "virtual"
        rows.append([*cells, roots, short(row["condition"], 3), first])
    head = ["word", "period", "impacts", "", "", "multipliers", "condition"]
    point = ", ".join(f"{name} {unit_in(result, name)}".rstrip() for name in found["coordinates"])
    table = aligned([*head, f"first point ({point})"], rows) if rows else []
    return [*table, *([""] if table else []), f"{found['statement']}.", ""]


def prove(_of: Any, found: Any) -> list[Row]:
    """Return a proof of each admissible orbit, or why there is none."""
    from grazing.proof.certify import certify

    proofs = []
    for i, one in enumerate(found):
        of = f"{one.word}, period {one.period}"
        row: Row = {"of": of, "orbit": i, "due": one.admissible, "stem": f"{one.word}-period-{one.period}"}
        if not one.admissible:
            proofs.append({**row, "proven": False, "reason": "it is virtual, no orbit of the map"})
            continue
        try:
            proofs.append({**row, **proof_row(certify(one))})
        except GrazingError as error:
            proofs.append({**row, "proven": False, "reason": str(error)})
    return proofs


STUDY = Study(
    name="orbit", place=130, compute="grazing.orbits.periodic:periodic_orbits", orbits=True,
    says="periodic orbits, stable and unstable",
    help="Find periodic orbits, stable and unstable, and prove them.",
    example="--word 001 --d 0.12 --V 0.4 --certify",
    prints="the orbits with their multipliers, and how they were looked for",
    found=found, words=words, options={"starts": ("whole", 1, "random starts of the search for orbits")},
    table="grazing.orbits.table:orbit_table", figure="", takes_long="searching for orbits",
    proves="each admissible orbit", prove=prove,
)  # fmt: skip
