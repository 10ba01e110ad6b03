"""An independent arbitrary-precision reference for the forced impact oscillator.

`exact` computes orbits, `dips` builds near-grazing states, `problems` names test problems, and `load_orbits`
and `load_dips` read the stored results of `build`.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, NamedTuple

from .dips import Dip, dips
from .exact import (
    Impact,
    Law,
    Problem,
    Strobe,
    Undecidable,
    active,
    advance,
    force,
    free_flight,
    newton,
    trigger,
)
from .problems import PERIODS, PROBLEMS, STARTS

__all__ = [
    "PERIODS",
    "PROBLEMS",
    "STARTS",
    "Dip",
    "Impact",
    "Law",
    "Problem",
    "StoredDip",
    "StoredOrbit",
    "StoredStrobe",
    "Strobe",
    "Undecidable",
    "active",
    "advance",
    "dips",
    "force",
    "free_flight",
    "load",
    "load_dips",
    "load_orbits",
    "newton",
    "trigger",
]


class StoredStrobe(NamedTuple):
    """A state at a strobe, rounded to double; `exact` keeps the stored digits of (u, v).

    `impacts` is None for a period with a completed chatter.  A result in double precision can be expected to
    lie within a small multiple of 1e-16 * factor.
    """

    u: float
    v: float
    impacts: int | None
    factor: float
    exact: tuple[str, str]


class StoredOrbit(NamedTuple):
    """The strobes of PROBLEMS[problem] from the start (u, v)."""

    problem: str
    u: float
    v: float
    strobes: list[StoredStrobe]


class StoredDip(NamedTuple):
    """A near-grazing start (u, v) and its state one period later."""

    problem: str
    u: float
    v: float
    depth: float
    hits: bool
    t_m: float
    strobe: StoredStrobe


def load(name: str) -> dict[str, Any]:
    """A stored data file as it is, `orbits` or `dips`."""
    path = Path(__file__).parent / "data" / f"{name}.json"
    data: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return data


def _strobe(row: list[Any]) -> StoredStrobe:
    u, v, impacts, factor = row
    return StoredStrobe(float(u), float(v), impacts, factor, (u, v))


def load_orbits() -> list[StoredOrbit]:
    """The stored orbits of the named problems."""
    return [
        StoredOrbit(e["problem"], float.fromhex(e["u"]), float.fromhex(e["v"]), [_strobe(r) for r in e["rows"]])
        for e in load("orbits")["entries"]
    ]


def load_dips() -> list[StoredDip]:
    """The stored dip and clearance states."""
    return [
        StoredDip(
            e["problem"],
            float.fromhex(e["u"]),
            float.fromhex(e["v"]),
            e["depth"],
            e["hits"],
            e["t_m"],
            _strobe(e["row"]),
        )
        for e in load("dips")["entries"]
    ]
