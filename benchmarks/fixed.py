"""The fixed set that every program is judged by: near grazes and ordinary orbits, with their exact answers."""

from __future__ import annotations

from enum import IntEnum
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np

from .models import MODELS, STANDARD, Array, Columns, Model
from .program import Program

FILE = Path(__file__).parent / "data" / "fixed.npz"

#: What the file holds: dips, and as many clearances, for one force and one depth; ordinary orbits of a model.
EACH, ORBITS = 25, 50

#: A state further off than this, one period after a near graze, comes from the wrong answer: hit or no hit.
WRONG = 1e-3


class Kind(IntEnum):
    """What a near graze does: it dips below the wall, or it clears it."""

    DIP = 0
    CLEARANCE = 1


@cache
def fixed_set() -> dict[str, Array]:
    """Return the stored arrays.

    ``stress_start`` and ``stress_after`` (2, d, depth, kind, each) hold (u, v) at 0 and one period later;
    ``orbit_start`` (2, orbits) and ``orbit_states`` (model, 2, periods, orbits) hold ordinary orbits at ``orbit_d``.
    """
    with np.load(FILE) as stored:
        return dict(stored)


class Verdict(NamedTuple):
    """How right a program is; None where the set has nothing for its model."""

    dips: int | None  # tried
    missed: int | None
    clearances: int | None  # tried
    false: int | None
    orbits: int
    worst: float  # largest error of u or v at any strobe of these orbits; infinite if one is not finite


def judge(program: Program, model: Model, each: int, orbits: int) -> Verdict:
    """Run a program on ``each`` dips and clearances for every d and depth, and on some ordinary orbits."""
    tried, wrong = near_grazes(program, each) if model == STANDARD else (None, {})
    worst = ordinary_orbits(program, model, orbits)
    return Verdict(tried, wrong.get(Kind.DIP), tried, wrong.get(Kind.CLEARANCE), orbits, worst)


def near_grazes(program: Program, each: int) -> tuple[int, dict[Kind, int]]:
    """Return how many near grazes of each kind were tried, and how many answers were wrong."""
    stored = fixed_set()
    start, after = stored["stress_start"][..., :each], stored["stress_after"][..., :each]
    count = len(stored["d"])
    u, v = program(Columns(stored["d"], *start.reshape(2, count, -1).copy()), 0, 1)
    off = error(np.stack([u[:, 0], v[:, 0]]).reshape(after.shape), after)
    tried = off[:, :, Kind.DIP].size
    return tried, {kind: int((off[:, :, kind] > WRONG).sum()) for kind in Kind}


def ordinary_orbits(program: Program, model: Model, orbits: int) -> float:
    """Return the largest error at any strobe of the first orbits of the set."""
    stored = fixed_set()
    exact = stored["orbit_states"][list(MODELS).index(model.name), :, :, :orbits]
    start = stored["orbit_start"][:, None, :orbits].copy()
    u, v = program(Columns(stored["orbit_d"], *start), 0, exact.shape[1])
    return float(error(np.stack([u[0], v[0]]), exact).max())


def error(states: Array, exact: Array) -> Array:
    """Return the larger error of u and v; infinite where a state is not finite."""
    off: Array = np.abs(states - exact).max(axis=0)
    return np.where(np.isfinite(off), off, np.inf)
