"""Escape rates by simulation, as they are asked for and told."""

from __future__ import annotations

from typing import Any

from grazing.catalogue.study import Row, Study
from grazing.catalogue.words import of, short, table


def found(result: Any) -> Row:
    """Return the rate with its error, at each value of what varies."""
    name = str(result["rate"].dims[0]) if result["rate"].dims else ""
    values = result[name].values.tolist() if name else [None]
    columns = (result[key].values.ravel().tolist() for key in ("rate", "error", "lost"))
    rows = [
        {**({name: value} if name else {}), "rate": rate, "error": error, "lost": lost}
        for value, rate, error, lost in zip(values, *columns, strict=True)
    ]
    return {
        "parameter": name,
        "rates": rows,
        **{key: int(result.attrs[key]) for key in ("orbits", "populations", "steps")},
    }


def words(found: Row, *_of: Any) -> list[str]:
    """Return a row for each value."""
    name = found["parameter"]
    head = [f"{name} {of(name, found)}".rstrip()] if name else []
    rows = [
        [*([short(row[name])] if name else []), short(row["rate"], 6), short(row["error"], 1)] for row in found["rates"]
    ]
    lost = sum(row["lost"] for row in found["rates"])
    said = table([*head, "escape rate a step", "error"], rows)
    said.append(f"{found['populations']} populations of {found['orbits']} orbits over {found['steps']} steps")
    return [*said, f"{lost} orbits ended otherwise"] if lost else said


STUDY = Study(
    name="escape", place=57, compute="grazing.studies.escape:escape", most=1,
    says="how fast orbits escape, such as balls from a pinball table",
    help="Measure how fast orbits escape, such as balls from a pinball table, with its error.",
    example="--table one_bumper bumper.V=0.1:0.9:5 -o escape.png",
    prints="the escape rate a step and its standard error, at each value",
    found=found, words=words, undrawn="there is no figure of a rate at one value", takes_long="populations",
    options={
        "orbits": ("whole", 100, "orbits of a population"),
        "steps": ("whole", 1, "steps over which the rate is measured"),
        "populations": ("whole", 2, "independent populations: the error is by how much they differ"),
        "stir": ("number", "by how much copies of orbits are moved; of a table, in radians of the angle"),
    },
)  # fmt: skip
