"""A motion at equal times, as it is asked for and told."""

from __future__ import annotations

from typing import Any

from grazing.catalogue import trajectory
from grazing.catalogue.study import Row, Study
from grazing.catalogue.words import between, of, short


def found(result: Any) -> Row:
    """Return how many samples there are, over which time and at which rate, and what is said of a trajectory."""
    t = result["t"].values
    count = {"samples": len(t), "rate": float(result.attrs["sample_rate"]), "t": [float(t[0]), float(t[-1])]}
    return {**count, **trajectory.found(result)}


def words(found: Row, *_of: Any) -> list[str]:
    """Return how much was recorded, and the impacts."""
    t = of("t", found)
    said = f"{found['samples']} samples, {short(found['rate'])} per {'s' if t else 'unit of time'}, "
    said += f"t from {between(found['t'])} {t}".rstrip()
    return [said, *trajectory.words(found)]


STUDY = Study(
    name="sample", place=90, compute="grazing.signals.record:sampled", of="model",
    says="one orbit at equal times, as it is recorded",
    help="Record a motion at equal times, each computed and none interpolated.",
    example="u=0 v=0 --until 100 --rate 20 --d 0.12 --V 0.4 -o motion.csv",
    prints="how many samples, over which time and at which rate; then what a trajectory prints",
    found=found, words=words, figure="history",
)  # fmt: skip
