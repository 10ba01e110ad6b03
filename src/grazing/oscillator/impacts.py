"""The impacts of one period: over one wall, for all orbits of a block together."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any

from grazing.kernel.primitives import behind, called_for_all, unit
from grazing.oscillator.block import dip, hand_back, hand_on, is_chord, kick, look_up, placed, set_apart, solve_of
from grazing.oscillator.cells import GO_ON, NEEDY, table_size
from grazing.oscillator.certificate import (
    candidates,
    certify_rest,
    count_hits,
    describe,
    locate,
    next_event,
    runs_of,
)  # fmt: skip
from grazing.oscillator.workspace import HIGH, W


@lru_cache(maxsize=64)
def impacts_of(harmonics: int) -> Callable[..., int]:
    """Return ``impacts(w, tables, runs, awake, columns, stride, strikes, counted)`` for a number of harmonics.

    It takes the orbits that hit to the end of the period, all their next impacts together, and returns how many of
    them the scalar routine must fly instead. ``strikes`` are the addresses of :func:`strike_of`, wall by wall.
    """
    solve = solve_of(harmonics)
    room = table_size(harmonics)

    @unit
    def impacts(
        w: Any, tables: Any, runs: Any, awake: int, columns: int, stride: int, strikes: Any, counted: bool
    ) -> int:  # fmt: skip
        places, several = candidates(w, runs, awake, stride)
        if counted:
            count_hits(w, runs, awake, columns, stride)
        locate(w, tables, room, runs, several)
        first, needy = True, 0
        while places > 0:
            look_up(w, tables, room, places, harmonics)
            solve(w, places)
            called_for_all(strikes[0], w, tables, room, runs, several)
            kick(w, places)
            left = certify_rest(w, tables, room, runs, several)
            if first:  # most orbits hit once and are done: as if all were
                hand_back(w, runs, several, stride, left)
            else:
                hand_on(w, places, left)
            first = False
            dips = set_apart(w, left)
            dip(w, dips)
            places, dips = int(0.0), 0  # of a literal 0 the compiler would make versions of their own
            for n in range(left):
                k = int(w[W.REST + n])
                i, q, cell = int(w[W.ORBIT + k]), int(w[W.COLUMN + k]), int(w[W.INSIDE + k])
                met, t = w[W.MET + k], behind(tables, q * room)
                if w[W.WIDER + k] < HIGH:
                    x, y, doubt, when = w[W.Z1 + k], w[W.Z2 + k], w[W.WIDER + k], w[W.WHEN + k]
                    event = next_event(t, t[GO_ON + cell], x, y, doubt)
                    placed(w, places, q, x, y, doubt, event, float(cell), when, i, met + 1.0)
                    places += 1
                    continue
                clear = False
                if is_chord(w[W.EVENT + k]):
                    clear = w[W.PROVEN + dips] > 0.0
                    if clear and w[W.PULL + dips] > 0.0:
                        w[W.NEAR + i] = min(w[W.NEAR + i], w[W.AFTER + dips])
                    dips += 1
                if not clear:
                    w[W.WANTED + i] = 1.0
                    t[NEEDY] += 1.0
                    needy += 1
                    continue
                x, y, doubt = w[W.X1 + k], w[W.X2 + k], w[W.DOUBT + k]
                event = next_event(t, w[W.EVENT + k] + 1.0, x, y, doubt)
                if event > 0.0:
                    placed(w, places, q, x, y, doubt, event, -1.0, 0.0, i, met)
                    places += 1
                else:
                    w[W.C1 + i], w[W.C2 + i], w[W.HITS + i] = x, y, met
            several = runs_of(w, places, runs)
            describe(w, tables, room, runs, several)
        return needy

    return impacts
