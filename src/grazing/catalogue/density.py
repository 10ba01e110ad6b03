"""The density of orbits, as it is asked for and told."""

from __future__ import annotations

from typing import Any

from grazing.catalogue.study import Row, Study
from grazing.catalogue.words import of, short


def found(result: Any) -> Row:
    """Return how many points were counted, how many fell beyond the ends, and how much of the range was visited."""
    name, coordinate = (str(dim) for dim in result["count"].dims)
    count = result["count"].values
    said = {key: int(result[key].values.sum()) for key in ("below", "above", "ended", "ambiguous")}
    about = result[coordinate].attrs
    return {
        "parameter": name,
        "coordinate": coordinate,
        "range": [float(about["low"]), float(about["high"])],
        "counted": int(count.sum()),
        **said,
        "visited": float((count > 0).mean()),
    }


def words(found: Row, *_of: Any) -> list[str]:
    """Return how many points were counted, and how many lie beyond the range."""
    low, high = (short(end) for end in found["range"])
    over = f"{found['coordinate']} from {low} to {high} {of(found['coordinate'], found)}".rstrip()
    said = [f"{found['counted']} points counted over {over}"]
    said.append(f"{found['below']} below and {found['above']} above that range")
    said.append(f"visited: {100.0 * found['visited']:.2g} % of the parts")
    return [*said, f"{found['ended']} orbits ended"] if found["ended"] else said


STUDY = Study(
    name="density", place=20, compute="grazing.studies.density:density", least=1, most=1,
    says="how often orbits visit each part of a range",
    help="Count how often orbits visit each part of a range as one parameter varies.",
    example="d=0.05:0.16:2000 --bins 1000 -o density.png",
    prints="the points counted, and those beyond the range",
    found=found, words=words, kept=("range",), counts="starts",
)  # fmt: skip
