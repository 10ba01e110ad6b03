"""Ensembles of oscillators: many starts at many parameter values, one kernel for every reset law."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import lru_cache, partial
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grazing.kernel.compile import compiled, width
from grazing.kernel.lanes import unpacker
from grazing.kernel.pool import Task
from grazing.kernel.primitives import behind, called_for_all, inlined, numbers
from grazing.kernel.vectors import combined, made_whole, repeated
from grazing.maps.columns import CUT, LONGEST, Columns
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
    dip,
    hand_back,
    hand_on,
    is_chord,
    kick,
    look_up,
    placed,
    set_apart,
    solve_of,
)  # fmt: skip
from grazing.oscillator.cells import (
    BAND,
    CERTIFICATE,
    CYCLE,
    GO_ON,
    HOLDING,
    LAW,
    LOOKED_AT,
    MARGIN,
    MAX_ROWS,
    NEEDY,
    PAIR,
    SIGMA,
    STATE,
    TABLED,
    UPRIGHT,
    WAKE,
    WHICH,
    fill_table,
    table_size,
)  # fmt: skip
from grazing.oscillator.certificate import (
    candidates,
    certify,
    certify_rest,
    count_hits,
    describe,
    locate,
    next_event,
    onward,
    runs_of,
)  # fmt: skip
from grazing.oscillator.constants import constants_of, section_phase
from grazing.oscillator.reset import Reset
from grazing.oscillator.still import LONGEST as LONGEST_CYCLE
from grazing.oscillator.still import SELDOM, find_cycles, remember, stand_still
from grazing.oscillator.workspace import (
    AFTER,
    C1,
    C2,
    COLUMN,
    DOUBT,
    EVENT,
    HIGH,
    HITS,
    INSIDE,
    LANES,
    MET,
    NAN,
    NEAR,
    NEED,
    ORBIT,
    PROVEN,
    PULL,
    REST,
    SLOW,
    WANTED,
    WHEN,
    WHERE,
    WIDER,
    X1,
    X2,
    Y0,
    Z1,
    Z2,
    U,
    V,
    workspace,
)  # fmt: skip
from grazing.outcome import AMBIGUOUS
from grazing.parameter import parameter_tuple

Floats = NDArray[np.float64]
INFINITY = float("inf")
ANNOUNCEMENT = "compiling the oscillator's kernel, ten to fifteen seconds, once on this machine"
#: Columns of a block at most: the tables of more no longer stay near.
COLUMNS = 28
#: A task is so many blocks at most, as long as there are so many tasks.
BLOCKS, TASKS = 8, 32
#: Where an orbit's state is: in its pair, after a period in the block; in U and V, too; in U and V alone.
FLOWN, FRESH, HELD = 0.0, 1.0, 2.0


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
        ``run(rows, strike, job, *workspace, lanes, points, letters, outcomes, near, slow, undecided)``. ``rows`` are
        the numbers of :func:`flight_fields`, column after column; ``strike`` the address of :func:`strike_of`. ``job``:
        columns from, to; how many of them are a block, and the room of each there; starts from, to; whether to use the
        block; periods to pass over; those to keep from, to. ``workspace`` is that of so many columns. ``lanes``
        (columns, 2, starts) hold the states. Results are as in :class:`grazing.maps.columns.Columns`.
    """
    fields = len(flight_fields(harmonics))
    unpack = unpacker(parameter_tuple(flight_fields(harmonics)))
    prepare = constants_of(harmonics, section_phase)
    period = period_of(pointed_law, pointed_slope, pointed_contraction, False)
    solve = solve_of(harmonics)
    room = table_size(harmonics)

    def constants_at(rows: Any, q: int) -> Any:
        return prepare(unpack(rows, q * fields))

    def begin(
        w: Any, tables: Any, rows: Any, blocks: int, top: int, columns: int, stride: int, left: int, starts: int,
        lanes: Any,
    ) -> None:  # fmt: skip
        """Fill the tables of a block's columns, and take the states."""
        for q in range(columns):
            t, c = behind(tables, q * room), constants_at(rows, top + q)
            t[LAW], t[HOLDING], t[NEEDY] = c.p.row, 1.0, 0.0
            t[LOOKED_AT], t[CYCLE], t[WAKE] = 0.0, 0.0, 0.0
            t[TABLED] = 1.0 if blocks and fill_table(t, behind(w, Y0), c, c.p.ratio) else 0.0
            t[WHICH] = float(q)
            for j in range(stride):
                i = q * stride + j
                w[C1 + i], w[C2 + i], w[WANTED + i] = 0.0, 0.0, 0.0
                w[NEAR + i], w[SLOW + i] = INFINITY, INFINITY
                if j < starts:
                    w[U + i], w[V + i] = lanes[top + q, 0, left + j], lanes[top + q, 1, left + j]
                    w[WHERE + i] = held_back(w, i, t)

    def end(
        w: Any, tables: Any, top: int, columns: int, stride: int, left: int, starts: int, lanes: Any, near: Any,
        slow: Any,
    ) -> None:  # fmt: skip
        """Give back the states of a block, and how near its orbits came to being others."""
        for q in range(columns):
            t = behind(tables, q * room)
            measured = t[BAND] if t[TABLED] > 0.0 else INFINITY
            for j in range(starts):
                i = q * stride + j
                if w[WHERE + i] == FLOWN:
                    w[U + i], w[V + i] = state_of(w[C1 + i], w[C2 + i], t)
                lanes[top + q, 0, left + j], lanes[top + q, 1, left + j] = w[U + i], w[V + i]
                near[top + q, left + j] = min(near[top + q, left + j], w[NEAR + i], measured)
                slow[top + q, left + j] = min(slow[top + q, left + j], w[SLOW + i])

    @inlined
    def want_all(w: Any, tables: Any, columns: int, stride: int, starts: int) -> None:
        """Give the orbits of columns without a table to the scalar routine."""
        for q in range(columns):
            t, first = behind(tables, q * room), q * stride
            if t[TABLED] == 0.0:
                t[NEEDY] = float(starts)
                for i in range(first, first + starts):
                    w[WANTED + i] = 1.0

    @inlined
    def back_to_states(w: Any, tables: Any, columns: int, stride: int, starts: int) -> None:
        """Find the states of the orbits that the scalar routine gets from the block."""
        for q in range(columns):
            t, first = behind(tables, q * room), q * stride
            for i in range(first, first + starts if t[NEEDY] > 0.0 else first):
                if w[WANTED + i] > 0.0 and w[WHERE + i] == FLOWN:
                    w[U + i], w[V + i] = state_of(w[C1 + i], w[C2 + i], t)

    def fly(
        w: Any, tables: Any, rows: Any, top: int, columns: int, stride: int, starts: int, record: int, left: int,
        outcomes: Any, undecided: Any,
    ) -> int:  # fmt: skip
        """Take the wanted orbits through one period by the scalar routine; return how many columns now hold states."""
        holding = 0
        for q in range(columns):
            t, first = behind(tables, q * room), q * stride
            if t[HOLDING] > 0.0:
                for i in range(first, first + starts):
                    w[WHERE + i] = w[WHERE + i] if w[WANTED + i] > 0.0 else FLOWN
                t[HOLDING] = 0.0
            if t[NEEDY] == 0.0:
                continue
            c = constants_at(rows, top + q)
            for i in range(first, first + starts):
                if w[WANTED + i] > 0.0:
                    state, letter, outcome, _J, near, slow = period((w[U + i], w[V + i]), c)
                    w[U + i], w[V + i] = state
                    w[NEAR + i], w[SLOW + i] = min(w[NEAR + i], near), min(w[SLOW + i], slow)
                    w[HITS + i] = float(letter)
                    outcomes[top + q, record, left + i - first] |= outcome
                    undecided[top + q, left + i - first] += 1 if outcome & AMBIGUOUS else 0
                    w[WHERE + i], w[WANTED + i] = held_back(w, i, t), 0.0
                t[HOLDING] += w[WHERE + i]
            t[NEEDY] = 0.0
            holding += 1 if t[HOLDING] > 0.0 else 0
        return holding

    @inlined
    def impacts(w: Any, tables: Any, runs: Any, awake: int, stride: int, strike: float, counted: bool) -> int:
        """Take the orbits that hit to the end of the period, all their next impacts together.

        Return how many of them the scalar routine must fly instead.
        """
        places, several = candidates(w, runs, awake, stride)
        if counted:
            count_hits(w, runs, awake, stride)
        locate(w, tables, room, runs, several)
        first, needy = True, 0
        while places > 0:
            look_up(w, tables, room, places, harmonics)
            solve(w, places)
            called_for_all(strike, w, tables, room, runs, several)
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
                k = int(w[REST + n])
                i, q, cell = int(w[ORBIT + k]), int(w[COLUMN + k]), int(w[INSIDE + k])
                met, t = w[MET + k], behind(tables, q * room)
                if w[WIDER + k] < HIGH:
                    x, y, doubt, when = w[Z1 + k], w[Z2 + k], w[WIDER + k], w[WHEN + k]
                    event = next_event(t, t[GO_ON + cell], x, y, doubt)
                    placed(w, places, q, x, y, doubt, event, float(cell), when, i, met + 1.0)
                    places += 1
                    continue
                clear = False
                if is_chord(w[EVENT + k]):
                    clear = w[PROVEN + dips] > 0.0
                    if clear and w[PULL + dips] > 0.0:
                        w[NEAR + i] = min(w[NEAR + i], w[AFTER + dips])
                    dips += 1
                if not clear:
                    w[WANTED + i] = 1.0
                    t[NEEDY] += 1.0
                    needy += 1
                    continue
                x, y, doubt = w[X1 + k], w[X2 + k], w[DOUBT + k]
                event = next_event(t, w[EVENT + k] + 1.0, x, y, doubt)
                if event > 0.0:
                    placed(w, places, q, x, y, doubt, event, -1.0, 0.0, i, met)
                    places += 1
                else:
                    w[C1 + i], w[C2 + i], w[HITS + i] = x, y, met
            several = runs_of(w, places, runs)
            describe(w, tables, room, runs, several)
        return needy

    @inlined
    def keep(w: Any, t: Any, first: int, starts: int, points: Any, letters: Any, row: int, n: int, left: int) -> None:
        """Write the states of a column's pairs, and how often each hit the wall."""
        u, v, hits = written_at(points, row, n, left)
        combined(numbers(points), u, starts, w, C1 + first, C2 + first, t, STATE, t[SIGMA])
        combined(numbers(points), v, starts, w, C1 + first, C2 + first, t, STATE + 3, 0.0)
        made_whole(numbers(letters), hits, starts, w, HITS + first)

    @inlined
    def repeat(points: Any, letters: Any, row: int, n: int, before: int, left: int, starts: int) -> None:
        """Write for a column what was written in an earlier period."""
        here, there = written_at(points, row, n, left), written_at(points, row, before, left)
        repeated(numbers(points), here[0], starts, there[0])
        repeated(numbers(points), here[1], starts, there[1])
        repeated(numbers(letters), here[2], starts, there[2])

    def advance(
        w: Any, tables: Any, runs: Any, rows: Any, strike: float, top: int, columns: int, stride: int, left: int,
        starts: int, transient: int, start: int, stop: int, points: Any, letters: Any, outcomes: Any, undecided: Any,
    ) -> None:  # fmt: skip
        """Take a block through its periods; in one call, as each call counts who uses the arrays."""
        last, bare, holding, awake, again = outcomes.shape[1] - 1, 0, columns, columns, 0
        for q in range(columns):
            bare += 1 if tables[q * room + TABLED] == 0.0 else 0
        periods = transient + stop - start
        for n in range(periods):
            kept = n - transient + start if n >= transient else -1
            record = min(max(kept, 0), last)
            if n >= again:
                awake, again = stand_still(tables, room, columns, runs, n, transient, periods)
            if n % SELDOM == 0:
                remember(w, tables, room, runs, awake, stride)
            certify(w, tables, room, runs, awake, stride, starts)
            if bare > 0:
                want_all(w, tables, columns, stride, starts)
            needy = bare + impacts(w, tables, runs, awake, stride, strike, kept >= 0)
            if needy > 0:
                back_to_states(w, tables, columns, stride, starts)
            onward(w, tables, room, runs, awake, stride)
            if needy + holding > 0:  # in most periods nobody needs the scalar routine
                holding = fly(w, tables, rows, top, columns, stride, starts, record, left, outcomes, undecided)
            length = n % SELDOM + 1
            if length <= LONGEST_CYCLE and find_cycles(w, tables, room, runs, awake, stride, starts, length) > 0:
                again = n + 1
            for q in range(columns if kept >= 0 else 0):
                first, t = q * stride, behind(tables, q * room)
                if float(n) < t[WAKE]:
                    repeat(points, letters, top + q, kept, kept - int(t[CYCLE]), left, starts)
                    continue
                keep(w, t, first, starts, points, letters, top + q, kept, left)
                for j in range(starts if t[HOLDING] > 0.0 else 0):
                    if w[WHERE + first + j] != FLOWN:
                        points[top + q, kept, 0, left + j] = w[U + first + j]
                        points[top + q, kept, 1, left + j] = w[V + first + j]

    def run(
        rows: Any, strike: float, job: Any, work: Any, tables: Any, runs: Any, lanes: Any, points: Any, letters: Any,
        outcomes: Any, near: Any, slow: Any, undecided: Any,
    ) -> None:  # fmt: skip
        top, bottom, several, stride, left, right, blocks, transient, start, stop = job
        w, t, ends = numbers(work), numbers(tables), numbers(runs)
        for first in range(top, bottom, several):
            columns = min(several, bottom - first)
            begin(w, t, numbers(rows), blocks, first, columns, stride, left, right - left, lanes)
            advance(
                w, t, ends, numbers(rows), strike, first, columns, stride, left, right - left, transient, start, stop,
                points, letters, outcomes, undecided,
            )  # fmt: skip
            end(w, t, first, columns, stride, left, right - left, lanes, near, slow)

    return compiled(run, arithmetic, announce=ANNOUNCEMENT)


def padded(starts: int) -> int:
    """Return the room of a column in a block: whole vectors, so that loops that run over the end hit no neighbour."""
    return -(-starts // width()) * width()


def held_back(w: Any, i: int, t: Any) -> float:
    """Turn the state of orbit i into a pair as well: FRESH; return HELD where the block must not have it.

    That is a ball on the wall, or so near that the certificate cannot tell. A fresh state is what the scalar routine
    gets if it must fly the next period: the way to a pair and back would cost a rounding.
    """
    if t[TABLED] > 0.0:
        y, v = (w[U + i] - t[SIGMA]) - t[STATE], w[V + i] - t[STATE + 3]
        x, y = t[PAIR] * y + t[PAIR + 1] * v, t[PAIR + 2] * y + t[PAIR + 3] * v
        margin = t[MARGIN] + (t[MARGIN + 1] * abs(x) + t[MARGIN + 2] * abs(y))
        height = t[CERTIFICATE] * x + (t[CERTIFICATE + MAX_ROWS] * y + t[CERTIFICATE + 2 * MAX_ROWS])
        if height > 2.0 * margin:
            w[C1 + i], w[C2 + i], w[NEED + i] = x, y, margin - t[UPRIGHT] * x
            return FRESH
    w[C1 + i], w[C2 + i], w[NEED + i] = NAN, NAN, NAN  # fails every row of the certificate, the first one first
    return HELD


def state_of(x: float, y: float, t: Any) -> tuple[float, float]:
    """Return the state at the strobe of a pair (c1, c2)."""
    u = t[SIGMA] + (t[STATE] + (t[STATE + 1] * x + t[STATE + 2] * y))
    return u, t[STATE + 3] + (t[STATE + 4] * x + t[STATE + 5] * y)


@inlined
def written_at(points: Any, row: int, n: int, left: int) -> tuple[int, int, int]:
    """Return where position, velocity and letter of a start are written for period n of a column."""
    starts = points.shape[3]
    first = row * points.shape[1] + n
    return 2 * first * starts + left, (2 * first + 1) * starts + left, first * starts + left


# ---- tasks for the driver of columns


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
    flat = pointed_rows(harmonics, law, kind, rows, arithmetic).ravel()
    strike = law_addresses(law.law, law.slope, law.name, kind, arithmetic)[2]
    entry = ensemble(harmonics, arithmetic)
    starts, keep = lanes.shape[2], found.points.shape[1]
    wide = min(starts, LANES)
    stride = padded(wide)
    several = min(LANES // stride, COLUMNS)
    # a few blocks a task, for what a task costs, but many tasks, for threads
    together = several * min(max(len(rows) // (several * TASKS), 1), BLOCKS)
    spare: list[tuple[Any, ...]] = []  # workspaces that no task is using
    pace = [1]  # so many blocks may be a tile: more where tiles turn out to be short; the bits do not depend on it

    def task(source: Floats, top: int, left: int) -> Iterator[None]:  # flat points to the rows, its source
        bottom, space = min(top + together, len(source)), spare.pop() if spare else workspace(harmonics, several)
        while top < bottom:
            blocks, first = pace[0], top
            top = min(top + several * blocks, bottom)
            box = first, top, several, stride, left, min(left + wide, starts)
            for n in range(0, max(transient + keep, 1), CUT):
                end = min(n + CUT, transient + keep)
                passed = max(0, min(end, transient) - n)
                job = (
                    *box, int(block), passed, max(n - transient, 0), max(end - transient, 0),
                )  # fmt: skip
                before = perf_counter()
                entry(flat, strike, job, *space, lanes, *found)
                spent = perf_counter() - before
                yield
            pace[0] = paced(blocks, spent)
        spare.append(space)

    return [partial(task, rows, q, i) for q in range(0, len(rows), together) for i in range(0, starts, wide)]


def paced(blocks: int, spent: float) -> int:
    """Return how many blocks the next tile may have, after one of so many took so many seconds."""
    if spent < 0.25 * LONGEST:
        return min(2 * blocks, BLOCKS)
    return max(blocks // 2, 1) if spent > 0.5 * LONGEST else blocks
