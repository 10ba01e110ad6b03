"""What the speeds are held to: ratios of rows of one run."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from .measure import Result, ratio
from .rows import (
    BATCH,
    FEW,
    FORMER,
    FORMER_STRICT,
    GAP,
    MAIN,
    OWN,
    PASSIVE_ROW,
    ROOTS,
    STRICT,
    THREE,
    TIGHT,
    TWO,
    UNDER,
    WALLS,
)


class Goal(NamedTuple):
    """``row`` is to be at least ``wanted`` times as fast as ``other``, all cores together."""

    row: str
    wanted: float
    other: str


def goals(other: str | None = None) -> list[Goal]:
    """Return all goals; ``other`` is the name of the function of --against."""
    against = [Goal(MAIN, 1.4, FORMER.format(other)), Goal(STRICT, 1.4, FORMER_STRICT.format(other))] if other else []
    return [
        *against,
        Goal(MAIN, 130.0, BATCH),
        Goal(MAIN + UNDER, 30.0, BATCH + UNDER),
        Goal(MAIN + THREE, 30.0, BATCH + THREE),
        Goal(MAIN + WALLS, 50.0, BATCH + WALLS),
        Goal(MAIN + TIGHT, 50.0, BATCH + TIGHT),
        Goal(TWO, 1.9, MAIN),
        Goal(PASSIVE_ROW, 0.8, MAIN),
        Goal(FEW, 0.7, MAIN),
        Goal(OWN, 0.8, MAIN),
        Goal(GAP, 1.0 / 1.1, ROOTS),
    ]


def reached(goal: Goal, results: Sequence[Result]) -> float | None:
    """Return the ratio that was measured, or None if one of the two rows did not run."""
    ran = {result.row.name: result for result in results if result.seconds}
    if goal.row not in ran or goal.other not in ran:
        return None
    row, other = ran[goal.row], ran[goal.other]
    return ratio(row, other) * row.row.threads / other.row.threads
