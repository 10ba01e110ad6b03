"""The loop around a step that costs much: what comes after an orbit is back at a state, to the bit, is known."""

from __future__ import annotations

from math import copysign
from typing import Any

import numpy as np

from grazing.explorer.composed import Step, emptied, fated
from grazing.kernel.lanes import column, put, unpacker
from grazing.kernel.primitives import inlined
from grazing.studies.density import raster

#: Steps between two states that later ones are compared with: no fewer than FEWEST, and a share of all so far, so that
#: long cycles are found as well.
FEWEST, SHARE = 8, 8


@inlined
def alike(a: Any, b: Any) -> bool:
    """Return whether the bits of two states are equal: a step may ask for the sign of a zero."""
    for i in range(len(a)):
        if a[i] != b[i] or copysign(1.0, a[i]) != copysign(1.0, b[i]):
            return False
    return True


def recurring_loop(step: Step, prepare: Step, kind: type, dimension: int) -> Step:
    """Return the loop around a step, with the same bits as :func:`grazing.kernel.lanes.loop_of`, of folded outcomes.

    A step depends on nothing but its state and its parameters. So orbits that are attracted by a cycle, which in
    doubles most reach, take only the steps until then; those of a column after the first one know it already.
    """
    unpack, zero = unpacker(kind), (0.0,) * dimension

    def run(rows: Any, lanes: Any, transient: int, points: Any, letters: Any, outcomes: Any) -> None:
        columns, n, keep = lanes.shape[0], lanes.shape[2], points.shape[1]
        for q in range(columns):
            c = prepare(unpack(rows[q]))
            home, turn = column(lanes[q], 0, zero), 0
            for j in range(n):
                state = column(lanes[q], j, zero)
                known, since, look, lag, taken, first = state, 0, FEWEST, 0, 0, 0
                while taken < transient + keep and not 0 < lag <= taken - max(first, transient):
                    state, letter, outcome = step(state, c)
                    outcomes[q, 0, j] |= outcome
                    if taken >= transient:
                        put(points[q, taken - transient], j, state)
                        letters[q, taken - transient, j] = letter
                    taken += 1
                    if lag > 0:
                        continue
                    if alike(state, known):
                        home, turn, lag, first = state, taken - since, taken - since, since
                    elif turn > 0 and alike(state, home):
                        lag, first = turn, taken
                    if lag > 0:
                        taken += max(transient + min(keep - lag, 0) - taken, 0) // lag * lag
                    elif taken == look:
                        known, since, look = state, taken, taken + max(FEWEST, taken // SHARE)
                for k in range(taken - transient, keep):
                    for i in range(dimension):
                        points[q, k, i, j] = points[q, k - lag, i, j]
                    letters[q, k, j] = letters[q, k - lag, j]
                if keep > 0:
                    state = column(points[q, keep - 1], j, zero)
                put(lanes[q], j, state)

    return run


def recurring_counter(run: Step, dimension: int) -> Step:
    """Return the kernel that counts the orbits of such a loop in a raster, one after the other."""

    def count(
        rows: Any, lanes: Any, transient: int, keep: int, i: int, low: float, high: float, bins: int, counts: Any,
        ended: Any, ambiguous: Any,
    ) -> None:  # fmt: skip
        columns, n = lanes.shape[0], lanes.shape[2]
        points, letters = np.empty((1, keep, dimension, 1)), np.empty((1, keep, 1), np.int32)
        for q in range(columns):
            emptied(counts, ended, ambiguous, q)
            for j in range(n):
                outcomes = np.zeros((1, 1, 1), np.int32)
                run(rows[q : q + 1], lanes[q : q + 1, :, j : j + 1], transient, points, letters, outcomes)
                raster(points, i, low, high, bins, counts[q : q + 1])
                fated(lanes, outcomes[0, 0, 0], q, j, ended, ambiguous)

    return count
