"""Decide in ball arithmetic what double precision could not, and follow the orbit on from there."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from contextlib import suppress
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from grazing.maps.columns import CUT, Columns
from grazing.outcome import AMBIGUOUS, BAD_LAW, InputError, UserCodeError, level_outside

#: Steps of an orbit that are settled between two cuts; beyond, what is ambiguous stays so.
LIMIT = 64

Floats = NDArray[np.float64]


class Settled(NamedTuple):
    """A step whose decisions are proven: next state, letter, outcome, narrowest miss, slowest impact."""

    state: tuple[float, ...]
    letter: int
    outcome: int
    near_miss: float
    slowest: float


#: ``settle(row, state)``: the step at the parameter values ``row``; None where no precision decides.
Settle = Callable[[list[float], tuple[float, ...]], Settled | None]
#: ``explain(row, state)``: what a user's law did wrong in the step from a state, in words.
Explain = Callable[[list[float], tuple[float, ...]], str]
#: ``again(row, state, n)``: the orbit of one start by the same algorithm, with one record a step.
Again = Callable[[Floats, Floats, int], Columns]


def settle_orbits(
    rows: Floats, starts: Floats, lanes: Floats, transient: int, found: Columns, settle: Settle, again: Again
) -> None:
    """Go once more through every orbit with an undecided step, deciding it.

    Parameters
    ----------
    rows : ndarray, shape (columns, parameters)
    starts, lanes : ndarray, shape (columns, dim, n)
        First and last states; the last ones are replaced.
    transient : int
    found : Columns
        Replaced for those orbits; ``undecided`` counts what is left.
    settle, again : callable
    """
    known: dict[tuple[Any, ...], Settled | None] = {}

    def remembered(row: list[float], state: tuple[float, ...]) -> Settled | None:
        key = (*row, *state)  # orbits that have come together ask the same again and again
        if key not in known:
            known[key] = settle(row, state)
        return known[key]

    for q, i in np.argwhere(found.undecided > 0):
        settle_orbit(rows[q], q, i, starts, lanes, transient, found, remembered, again)


def settle_orbit(
    row: Floats, q: int, i: int, starts: Floats, lanes: Floats, transient: int, found: Columns, settle: Settle,
    again: Again,
) -> None:  # fmt: skip
    """Settle one orbit, between two cuts at a time: so its bits depend on nothing else."""
    keep, records = found.points.shape[1], found.outcomes.shape[1]
    state, n, total, undecided = starts[q, :, i].copy(), 0, transient + keep, 0
    near, slow, asked = np.inf, np.inf, 0
    found.outcomes[q, :, i] = 0

    def record(n: int, point: Floats, letter: int, outcome: int) -> None:
        kept = n - transient
        found.outcomes[q, min(max(kept, 0), records - 1), i] |= outcome
        if kept >= 0:
            found.points[q, kept, :, i], found.letters[q, kept, i] = point, letter

    while n < total:
        asked = 0 if n % CUT == 0 else asked
        steps = min(total - n, CUT - n % CUT)
        part = again(row, state, steps)
        doubtful = np.flatnonzero(part.outcomes[0, :, 0] & AMBIGUOUS)
        sure = int(doubtful[0]) if doubtful.size and asked < LIMIT else steps
        for j in range(sure):
            record(n + j, part.points[0, j, :, 0], part.letters[0, j, 0], part.outcomes[0, j, 0])
        if sure > 0:
            kept = part if sure == steps else again(row, state, sure)  # what was undone says nothing of the orbit
            near, slow = min(near, kept.near_miss[0, 0]), min(slow, kept.slowest[0, 0])
            state = part.points[0, sure - 1, :, 0]
        n += sure
        if sure == steps:
            undecided += doubtful.size
            continue
        asked += 1
        before = tuple(state.tolist())
        proven = settle(row.tolist(), before)
        if proven is None:
            undecided += 1
            outcome = int(part.outcomes[0, sure, 0])
            state, letter = part.points[0, sure, :, 0], int(part.letters[0, sure, 0])
            alone = again(row, np.array(before), 1)  # the part says it of all its steps, those to come included
            near, slow = min(near, alone.near_miss[0, 0]), min(slow, alone.slowest[0, 0])
        else:
            state, letter, outcome = np.array(proven.state), proven.letter, proven.outcome
            near, slow = min(near, proven.near_miss), min(slow, proven.slowest)
        record(n, state, letter, outcome)
        n += 1
        if proven is not None and proven.state == before:  # a step that changes nothing is the same for ever
            for same in range(n, total):
                record(same, state, letter, outcome)
            n = total
    lanes[q, :, i] = state
    found.near_miss[q, i], found.slowest[q, i], found.undecided[q, i] = near, slow, undecided


def said_in_flight(fly: Callable[[], Any], law: str) -> str:
    """Return what a flight raises of a user's law, with its line; if it does not, what is known anyway."""
    with suppress(InputError):
        try:
            fly()
        except UserCodeError as error:
            return str(error)
    return f"{law} returned what it must not"


def warn_of_bad_law(rows: Floats, starts: Floats, steps: int, found: Columns, explain: Explain, again: Again) -> None:
    """Warn, once a run, of orbits that ended because a reset law returned what it must not."""
    bad = np.argwhere((found.outcomes & BAD_LAW).any(axis=1))
    q, i = bad[0]
    part = again(rows[q], starts[q, :, i], steps)
    ended = np.flatnonzero(part.outcomes[0, :, 0] & BAD_LAW)
    n = int(ended[0]) if ended.size else steps - 1
    state = part.points[0, n - 1, :, 0] if n > 0 else starts[q, :, i]
    said = explain(rows[q].tolist(), tuple(state.tolist()))
    many = f"{len(bad)} of {found.near_miss.size} orbits ended" if len(bad) > 1 else "the orbit ended"
    warnings.warn(f"{said}; {many} there, with outcome bad_law", RuntimeWarning, stacklevel=level_outside())
