"""The portrait of orbits in a plane, as it is asked for and told."""

from __future__ import annotations

from typing import Any

from grazing.catalogue.study import Row, Study
from grazing.catalogue.words import of, short


def found(result: Any) -> Row:
    """Return how many points were counted, how many lie beyond what is shown, and how much of it was visited."""
    up, across = (str(dim) for dim in result["count"].dims)
    count = result["count"].values
    said = {key: int(result[key].values) for key in ("beyond", "left", "ended", "ambiguous")}
    ends = [[float(result[name].attrs[end]) for end in ("low", "high")] for name in (across, up)]
    return {
        "across": across,
        "up": up,
        "within": ends,
        "counted": int(count.sum()),
        **said,
        "visited": float((count > 0).mean()),
    }


def words(found: Row, *_of: Any) -> list[str]:
    """Return how many points were counted, and how many lie beyond what is shown."""
    ends = zip((found["across"], found["up"]), found["within"], strict=True)
    over = " and ".join(
        f"{name} from {short(low)} to {short(high)} {of(name, found)}".rstrip() for name, (low, high) in ends
    )
    said = [f"{found['counted']} points counted over {over}", f"{found['beyond']} beyond that"]
    said.append(f"visited: {100.0 * found['visited']:.2g} % of the parts")
    return said + [f"{found[key]} orbits {says}" for key, says in (("left", "left"), ("ended", "ended")) if found[key]]


STUDY = Study(
    name="portrait", place=22, compute="grazing.studies.portrait:portrait",
    says="how often orbits visit each part of the plane of two coordinates",
    help="Count how often orbits visit each part of a plane: attractors as they look.",
    example="V=0.4 omega=2.6 -o portrait.png",
    prints="the points counted, and those beyond what is shown",
    found=found, words=words, kept=("within",), counts="starts",
    options={
        "across": ("text", "coordinate to the right; the first one if not given"),
        "up": ("text", "coordinate upwards; the next one if not given"),
    },
)  # fmt: skip
