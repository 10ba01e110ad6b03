"""Ensembles of oscillators: many starts at many parameter values, one kernel for every reset law."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import lru_cache, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grazing.kernel.compile import compiled
from grazing.kernel.lanes import unpacker
from grazing.kernel.pool import Task
from grazing.kernel.primitives import at, called_for_all, inlined
from grazing.maps.columns import Columns
from grazing.maps.period import period_of
from grazing.maps.pointed import (
    flight_fields,
    law_addresses,
    pointed_contraction,
    pointed_law,
    pointed_rows,
    pointed_slope,
)
from grazing.oscillator.block import (
    AFTER,
    BEFORE,
    C1,
    C2,
    COLUMN,
    DOUBT,
    EVENT,
    LANES,
    LIMIT,
    NEAR,
    NEXT,
    NOTHING,
    PROVEN,
    PULL,
    SINCE,
    SLOW,
    WHEN,
    WIDTH,
    X1,
    X2,
    U,
    V,
    cell_of,
    certify,
    certify_rest,
    dip_of,
    gathered,
    guess_of,
    kick,
    next_event,
    solve_of,
    spread_constants,
    workspace_size,
)  # fmt: skip
from grazing.oscillator.cells import (
    BAND,
    CERTIFICATE,
    MARGIN,
    MAX_CERTIFICATE,
    ONWARD,
    PAIR,
    SIGMA,
    STATE,
    fill_table,
    table_size,
)
from grazing.oscillator.constants import constants_of, section_phase
from grazing.oscillator.reset import Reset
from grazing.outcome import AMBIGUOUS
from grazing.parameter import parameter_tuple

Floats = NDArray[np.float64]
INFINITY = float("inf")
NAN = float("nan")
ANNOUNCEMENT = "compiling the oscillator's kernel, ten to fifteen seconds, once on this machine"
#: Where an orbit's state is: in its pair, after a period in the block; in U and V, too; in U and V alone.
FLOWN, FRESH, HELD = 0, 1, 2


@lru_cache(maxsize=128)
def ensemble(harmonics: int, arithmetic: str) -> Callable[..., None]:
    """Compile the kernel: once for a number of harmonics and an arithmetic, whatever the law.

    Parameters
    ----------
    harmonics : int
        At least 1.
    arithmetic : {"strict", "fast"}

    Returns
    -------
    callable
        ``run(rows, strike, law_rows, job, lanes, points, letters, outcomes, near, slow, undecided)``. ``rows`` are the
        numbers of :func:`flight_fields`, column after column; ``strike`` and ``law_rows`` the addresses of
        :func:`strike_of` and of its numbers. ``job``: columns from, to; starts from, to; whether to use the block;
        periods to pass over; those to keep from, to. ``lanes`` (columns, 2, starts) hold the states. Results are as in
        :class:`grazing.maps.columns.Columns`.
    """
    fields = len(flight_fields(harmonics))
    unpack = unpacker(parameter_tuple(flight_fields(harmonics)))
    prepare = constants_of(harmonics, section_phase)
    period = period_of(pointed_law, pointed_slope, pointed_contraction, False)
    guess, solve, dip = guess_of(harmonics), solve_of(harmonics), dip_of(harmonics)
    size, work = table_size(harmonics), workspace_size(harmonics)

    def constants_at(rows: Any, q: int) -> Any:
        return prepare(unpack(rows, q * fields))

    def fly(w: Any, start: int, end: int, c: Any, wanted: Any, hits: Any, flags: Any) -> None:
        """Take the wanted orbits through one period by the scalar routine; states are in U and V."""
        for i in range(start, end):
            if wanted[i]:
                state, letter, outcome, _J, near, slow = period((w[U + i], w[V + i]), c)
                w[U + i], w[V + i] = state
                w[NEAR + i], w[SLOW + i] = min(w[NEAR + i], near), min(w[SLOW + i], slow)
                hits[i], flags[i] = letter, outcome

    @inlined
    def placed(w: Any, to: int, t: Any, q: int, cell: int, x: float, y: float, doubt: float) -> None:
        """Put an orbit with an impact in this cell to the impacts at hand."""
        gathered(w, to, t, q, cell, harmonics)
        w[at(X1 + to)], w[at(X2 + to)], w[at(DOUBT + to)] = x, y, doubt

    def first_impacts(
        w: Any, t: Any, columns: int, seg: Any, who: Any, event: Any, cell: Any, met: Any, wanted: Any, needy: Any
    ) -> int:
        """Gather the first impacts of the orbits that the certificate did not settle; return their number."""
        places = 0
        for q in range(columns):
            for k in range(seg[q], seg[q + 1]):
                i = who[k]
                found = int(w[at(EVENT + i)])
                if found == 0:  # not surely above the wall at the strobe
                    wanted[i] = 1
                    needy[q] += 1
                    continue
                x, y, doubt = w[at(C1 + i)], w[at(C2 + i)], w[at(LIMIT + i)]
                inside = cell_of(t, q, found, x, y, doubt, 0, harmonics)
                placed(w, places, t, q, inside, x, y, doubt)
                who[places], event[places], cell[places], met[places] = i, found, inside, 0
                places += 1
        return places

    def impacts(
        w: Any, low: Any, t: Any, places: int, who: Any, event: Any, cell: Any, met: Any, hits: Any, wanted: Any,
        needy: Any, strike: float, law_rows: float,
    ) -> None:  # fmt: skip
        """Take the orbits with impacts at hand to the end of the period, all their next impacts together."""
        while places > 0:
            spread_constants(w, places, t)
            guess(w, places)
            solve(w, places)
            called_for_all(strike, w, 0, places, law_rows)
            kick(w, places)
            certify_rest(w, places, t)
            count, dips = places, 0
            places = 0
            for k in range(count):
                i = who[k]
                if w[at(PROVEN + k)] > 0.0:
                    w[at(SLOW + i)] = min(w[at(SLOW + i)], -w[at(BEFORE + k)])
                    if w[at(NEXT + k)] == NOTHING:
                        w[at(C1 + i)], w[at(C2 + i)] = w[at(X1 + k)], w[at(X2 + k)]
                        hits[i] = met[k] + 1
                        continue
                    found, before, when = int(w[at(NEXT + k)]), cell[k], w[at(WHEN + k)]
                    x, y, doubt, q = w[at(X1 + k)], w[at(X2 + k)], w[at(DOUBT + k)], int(w[at(COLUMN + k)])
                    inside = cell_of(t, q, found, x, y, doubt, before, harmonics)
                    placed(w, places, t, q, inside, x, y, doubt)
                    if inside == before:
                        w[at(SINCE + places)] = when
                    who[places], event[places], cell[places], met[places] = i, found, inside, met[k] + 1
                    places += 1
                elif event[k] % 2 == 1:
                    for j in range(X1, work, WIDTH):
                        low[at(j + dips)] = w[at(j + k)]
                    low[at(C1 + dips)], low[at(C2 + dips)], low[at(NEAR + dips)] = float(i), float(event[k]), met[k]
                    dips += 1
                else:
                    wanted[i] = 1
                    needy[int(w[at(COLUMN + k)])] += 1
            if dips > 0:
                dip(low, dips)
            for k in range(dips):
                i, q = int(low[at(C1 + k)]), int(low[at(COLUMN + k)])
                if not low[at(PROVEN + k)] > 0.0:
                    wanted[i] = 1
                    needy[q] += 1
                    continue
                if low[at(PULL + k)] > 0.0:
                    w[NEAR + i] = min(w[NEAR + i], low[at(AFTER + k)])
                x, y, doubt = low[at(X1 + k)], low[at(X2 + k)], low[at(DOUBT + k)]
                found = next_event(t, q, x, y, doubt, int(low[at(C2 + k)]) + 1)
                if found == NOTHING:
                    w[C1 + i], w[C2 + i] = x, y
                    hits[i] = int(low[at(NEAR + k)])
                    continue
                inside = cell_of(t, q, found, x, y, doubt, 0, harmonics)
                placed(w, places, t, q, inside, x, y, doubt)
                who[places], event[places], cell[places] = i, found, inside
                met[places] = int(low[at(NEAR + k)])
                places += 1

    def onward(w: Any, start: int, end: int, t: Any, q: int) -> None:
        """Take the pairs of column q over to the next period."""
        start = max(start, 0)
        s0, a00, a01 = t[q, ONWARD], t[q, ONWARD + 1], t[q, ONWARD + 2]
        s1, a10, a11 = t[q, ONWARD + 3], t[q, ONWARD + 4], t[q, ONWARD + 5]
        for i in range(start, end):
            x, y = w[at(C1 + i)], w[at(C2 + i)]
            w[at(C1 + i)] = a00 * x + (a01 * y + s0)
            w[at(C2 + i)] = a10 * x + (a11 * y + s1)

    def run(
        rows: Any, strike: float, law_rows: float, job: Any, lanes: Any, points: Any, letters: Any, outcomes: Any,
        near: Any, slow: Any, undecided: Any,
    ) -> None:  # fmt: skip
        top, bottom, left, right, blocks, transient, start, stop = job
        columns, starts = bottom - top, right - left
        last = outcomes.shape[1] - 1
        t = np.empty((columns, size))
        tabled = np.zeros(columns, np.int64)
        w, low = np.zeros(work), np.zeros(work)
        who, event = np.zeros(WIDTH, np.int64), np.zeros(WIDTH, np.int64)
        cell, met, hits = np.zeros(WIDTH, np.int64), np.zeros(WIDTH, np.int64), np.zeros(WIDTH, np.int64)
        wanted, flags, needy = np.zeros(WIDTH, np.int64), np.zeros(WIDTH, np.int64), np.zeros(columns, np.int64)
        seg, held, fresh = np.zeros(columns + 1, np.int64), np.zeros(WIDTH, np.int64), np.ones(columns, np.int64)
        for q in range(columns):
            c = constants_at(rows, top + q)
            tabled[q] = 1 if blocks and fill_table(t, q, c, c.p.ratio) else 0
            for j in range(starts):
                i = q * starts + j
                w[NEAR + i], w[SLOW + i] = INFINITY, INFINITY
                w[U + i], w[V + i] = lanes[top + q, 0, left + j], lanes[top + q, 1, left + j]
                held[i] = held_back(w, i, t, q, tabled[q])
        for n in range(transient + stop - start):
            count = 0
            for q in range(columns):
                first = q * starts
                seg[q] = count
                needy[q] = 0
                if n >= transient:
                    for i in range(first, first + starts):
                        hits[i] = 0
                if not tabled[q]:
                    needy[q] = starts
                    for i in range(first, first + starts):
                        wanted[i] = 1
                    continue
                certify(w, first, first + starts, t, q)
                for i in range(first, first + starts):
                    who[at(count)] = i
                    count += 1 if w[at(EVENT + i)] < NOTHING else 0
            seg[columns] = count
            places = first_impacts(w, t, columns, seg, who, event, cell, met, wanted, needy)
            impacts(w, low, t, places, who, event, cell, met, hits, wanted, needy, strike, law_rows)
            kept = n - transient + start if n >= transient else -1
            record = min(max(kept, 0), last)
            for q in range(columns):
                first = q * starts
                if needy[q]:
                    for i in range(first, first + starts):
                        if wanted[i] and held[i] == FLOWN:
                            w[U + i], w[V + i] = state_of(w[C1 + i], w[C2 + i], t, q)
                if tabled[q]:
                    onward(w, first, first + starts, t, q)
                if fresh[q]:
                    for i in range(first, first + starts):
                        held[i] = held[i] if wanted[i] else FLOWN
                fresh[q] = 0
                if needy[q]:
                    fly(w, first, first + starts, constants_at(rows, top + q), wanted, hits, flags)
                    for i in range(first, first + starts):
                        if wanted[i]:
                            j = left + i - first
                            outcomes[top + q, record, j] |= flags[i]
                            undecided[top + q, j] += 1 if flags[i] & AMBIGUOUS else 0
                            held[i] = held_back(w, i, t, q, tabled[q])
                            wanted[i] = 0
                        fresh[q] += held[i]
                if kept >= 0:
                    if tabled[q]:
                        sigma, u0, u1, u2 = t[q, SIGMA], t[q, STATE], t[q, STATE + 1], t[q, STATE + 2]
                        v0, v1, v2 = t[q, STATE + 3], t[q, STATE + 4], t[q, STATE + 5]
                        for j in range(starts):
                            x, y = w[at(C1 + first + j)], w[at(C2 + first + j)]
                            points[top + q, kept, 0, left + j] = sigma + (u0 + (u1 * x + u2 * y))
                            points[top + q, kept, 1, left + j] = v0 + (v1 * x + v2 * y)
                    for j in range(starts):
                        letters[top + q, kept, left + j] = hits[first + j]
                        if fresh[q] and held[first + j] != FLOWN:
                            points[top + q, kept, 0, left + j] = w[U + first + j]
                            points[top + q, kept, 1, left + j] = w[V + first + j]
        for q in range(columns):
            for j in range(starts):
                i = q * starts + j
                if held[i] == FLOWN:
                    w[U + i], w[V + i] = state_of(w[C1 + i], w[C2 + i], t, q)
                lanes[top + q, 0, left + j], lanes[top + q, 1, left + j] = w[U + i], w[V + i]
                measured = t[q, BAND] if tabled[q] else INFINITY
                near[top + q, left + j] = min(near[top + q, left + j], w[NEAR + i], measured)
                slow[top + q, left + j] = min(slow[top + q, left + j], w[SLOW + i])

    return compiled(run, arithmetic, announce=ANNOUNCEMENT)


def held_back(w: Any, i: int, t: Any, q: int, tabled: int) -> int:
    """Turn the state of orbit i into a pair as well: FRESH; return HELD where the block must not have it.

    That is a ball on the wall, or so near that the certificate cannot tell. A fresh state is what the scalar routine
    gets if it must fly the next period: the way to a pair and back would cost a rounding.
    """
    if tabled:
        y, v = (w[U + i] - t[q, SIGMA]) - t[q, STATE], w[V + i] - t[q, STATE + 3]
        x, y = t[q, PAIR] * y + t[q, PAIR + 1] * v, t[q, PAIR + 2] * y + t[q, PAIR + 3] * v
        margin = t[q, MARGIN] + (t[q, MARGIN + 1] * abs(x) + t[q, MARGIN + 2] * abs(y))
        at = CERTIFICATE
        height = t[q, at] * x + (t[q, at + MAX_CERTIFICATE] * y + t[q, at + 2 * MAX_CERTIFICATE])
        if height > 2.0 * margin:
            w[C1 + i], w[C2 + i] = x, y
            return FRESH
    w[C1 + i], w[C2 + i] = NAN, NAN  # fails every row of the certificate, the first one first
    return HELD


def state_of(x: float, y: float, t: Any, q: int) -> tuple[float, float]:
    """Return the state at the strobe of a pair (c1, c2)."""
    u = t[q, SIGMA] + (t[q, STATE] + (t[q, STATE + 1] * x + t[q, STATE + 2] * y))
    return u, t[q, STATE + 3] + (t[q, STATE + 4] * x + t[q, STATE + 5] * y)


# ---- tasks for the driver of columns

#: Periods of a tile: with the orbits of a block well under 0.2 s, even where every period needs the scalar routine.
PERIODS = 256


def ensemble_tasks(
    harmonics: int, law: Reset, kind: type, rows: Floats, lanes: Floats, transient: int, found: Columns,
    arithmetic: str, block: bool,
) -> list[Task]:  # fmt: skip
    """Return tasks that take the oscillators of many columns through their periods.

    Parameters
    ----------
    harmonics : int
        Of the model.
    law : Reset
        Its reset law.
    kind : type
        The named tuple of the map's parameters: those of the flight, of the law, and the phase.
    rows : ndarray, shape (columns, parameters)
    lanes : ndarray, shape (columns, 2, starts)
        The starts; overwritten with the last states.
    transient : int
    found : Columns
        To be filled.
    arithmetic : {"strict", "fast"}
    block : bool
        Whether to use the block kernel; else every period goes through the scalar routine.
    """
    rows = np.ascontiguousarray(rows)
    flat, where = pointed_rows(harmonics, law, kind, rows, arithmetic)
    strike = law_addresses(law.law, law.slope, law.name, kind, arithmetic)[2]
    entry = ensemble(harmonics, arithmetic)
    starts, keep = lanes.shape[2], found.points.shape[1]
    shape = max(1, LANES // starts), min(starts, LANES)

    def task(top: int, left: int) -> Iterator[None]:
        box = top, min(top + shape[0], len(rows)), left, min(left + shape[1], starts)
        for n in range(0, max(transient + keep, 1), PERIODS):
            end = min(n + PERIODS, transient + keep)
            passed = max(0, min(end, transient) - n)
            job = (
                *box, int(block), passed, max(n - transient, 0), max(end - transient, 0),
            )  # fmt: skip
            entry(flat.ravel(), strike, float(where[top]), job, lanes, *found)
            yield

    return [partial(task, q, i) for q in range(0, len(rows), shape[0]) for i in range(0, starts, shape[1])]
