"""Ensembles of oscillators: many starts at many parameter values, one kernel for every reset law."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from grazing.kernel.compile import compiled, width
from grazing.kernel.lanes import unpacker
from grazing.kernel.primitives import behind, inlined, numbers
from grazing.kernel.vectors import combined, made_whole, repeated
from grazing.maps.period import period_of
from grazing.oscillator.cells import (
    BAND,
    CYCLE,
    HOLDING,
    LAW,
    LOOKED_AT,
    NEEDY,
    SIGMA,
    STATE,
    TABLED,
    WAKE,
    WHICH,
    fill_table,
    table_size,
)  # fmt: skip
from grazing.oscillator.certificate import certify, onward
from grazing.oscillator.constants import constants_of, section_phase
from grazing.oscillator.facing import held_between, mirrored
from grazing.oscillator.impacts import impacts_of
from grazing.oscillator.pairs import held_back, state_of
from grazing.oscillator.pointed import POINTED, flight_kind
from grazing.oscillator.still import LONGEST as LONGEST_CYCLE
from grazing.oscillator.still import SELDOM, find_cycles, remember, stand_still
from grazing.oscillator.workspace import AWAKE, FLOWN, W
from grazing.outcome import AMBIGUOUS

Floats = NDArray[np.float64]
INFINITY = float("inf")
ANNOUNCEMENT = "compiling the oscillator's kernel, some ten seconds, once on this machine"


class Box(NamedTuple):
    """The orbits of a block."""

    top: int  # the first of its columns
    columns: int  # how many there are
    stride: int  # the room of each in the workspace
    left: int  # the first of the starts
    starts: int  # how many there are


class Found(NamedTuple):
    """What is written of the periods that are kept, see :class:`grazing.maps.columns.Columns`."""

    points: Any
    letters: Any
    outcomes: Any
    undecided: Any


class Setting(NamedTuple):
    """What an ensemble flies in: the walls, and what depends on them."""

    walls: int  # that the ball may hit
    kind: type  # the named tuple of a row of numbers
    prepare: Callable[..., Any]  # (row) -> c
    period: Callable[..., Any]  # (state, c) -> (state, letter, outcome, J, near, slow): the scalar routine
    fill: Callable[..., bool]  # (t, s, x, c, blocks): fill the tables, s that of a second wall; whether there are any
    impacts: Callable[..., int]  # see :func:`grazing.oscillator.impacts.impacts_of`


@lru_cache(maxsize=64)
def above_wall(harmonics: int) -> Setting:
    """Return the setting of an oscillator above one wall at rest."""

    def fill(t: Any, s: Any, x: Any, c: Any, blocks: int) -> bool:
        t[LAW] = c.p.row
        return blocks != 0 and fill_table(t, x, c, c.p.ratio, 0.0, 0.0)

    prepare, period = constants_of(harmonics, section_phase), period_of(*POINTED, False)
    return Setting(1, flight_kind(harmonics), prepare, period, fill, impacts_of(harmonics))


@lru_cache(maxsize=128)
def ensemble(setting: Setting, harmonics: int, arithmetic: str) -> Callable[..., None]:
    """Compile the kernel: once for a setting, a number of harmonics and an arithmetic, whatever the laws.

    Parameters
    ----------
    setting : Setting
    harmonics : int
        At least 1.
    arithmetic : {"strict", "fast"}

    Returns
    -------
    callable
        ``run(rows, strikes, job, *workspace, lanes, points, letters, outcomes, near, slow, undecided)``. ``rows`` are
        numbers in the order of ``setting.kind``, column after column; ``strikes`` the addresses of :func:`strike_of`
        for each of two walls. ``job``: columns from, to; how many of them are a block, and the room of each there;
        starts from, to; whether to use the block; periods to pass over; those to keep from, to. ``workspace`` is that
        of so many columns, for each wall. ``lanes`` (columns, 2, starts) hold the states. Results are as in
        :class:`grazing.maps.columns.Columns`.
    """
    walls, kind, prepare, period, fill, impacts = setting
    fields, unpack, two = len(kind._fields), unpacker(kind), walls > 1  # type: ignore[attr-defined]
    room = table_size(harmonics)

    def constants_at(rows: Any, q: int) -> Any:
        return prepare(unpack(rows, q * fields))

    @inlined
    def held(w: Any, tables: Any, columns: int, stride: int, q: int, i: int) -> float:
        """Turn the state of an orbit into what its walls see, see :func:`held_back`."""
        t = behind(tables, q * room)
        if two:
            return held_between(w, i, columns * stride, t, behind(t, columns * room))
        return held_back(w, i, t)

    def begin(w: Any, tables: Any, rows: Any, blocks: int, box: Box, lanes: Any) -> None:
        """Fill the tables of a block's columns, and take the states."""
        top, columns, stride, left, starts = box
        for q in range(columns):
            t, c = behind(tables, q * room), constants_at(rows, top + q)
            s = behind(t, (walls - 1) * columns * room)
            t[HOLDING], t[NEEDY] = 1.0, 0.0
            t[LOOKED_AT], t[CYCLE], t[WAKE] = 0.0, 0.0, 0.0
            t[TABLED] = 1.0 if fill(t, s, behind(w, W.Y0), c, blocks) else 0.0
            t[WHICH] = float(q)
            if two:
                s[TABLED], s[WHICH] = t[TABLED], float(columns + q)
            for n in range(walls):
                for j in range(stride):
                    i = (n * columns + q) * stride + j
                    w[W.C1 + i], w[W.C2 + i], w[W.WANTED + i] = 0.0, 0.0, 0.0
                    w[W.NEAR + i], w[W.SLOW + i] = INFINITY, INFINITY
            for j in range(starts):
                i = q * stride + j
                w[W.U + i], w[W.V + i] = lanes[top + q, 0, left + j], lanes[top + q, 1, left + j]
                w[W.WHERE + i] = held(w, tables, columns, stride, q, i)

    def end(w: Any, tables: Any, box: Box, lanes: Any, near: Any, slow: Any) -> None:
        """Give back the states of a block, and how near its orbits came to being others."""
        top, columns, stride, left, starts = box
        for q in range(columns):
            t = behind(tables, q * room)
            measured = t[BAND] if t[TABLED] > 0.0 else INFINITY
            if two:
                measured = min(measured, t[columns * room + BAND] if t[TABLED] > 0.0 else INFINITY)
            for j in range(starts):
                i = q * stride + j
                if two:
                    h = i + columns * stride
                    w[W.NEAR + i], w[W.SLOW + i] = min(w[W.NEAR + i], w[W.NEAR + h]), min(w[W.SLOW + i], w[W.SLOW + h])
                if w[W.WHERE + i] == FLOWN:
                    w[W.U + i], w[W.V + i] = state_of(w[W.C1 + i], w[W.C2 + i], t)
                lanes[top + q, 0, left + j], lanes[top + q, 1, left + j] = w[W.U + i], w[W.V + i]
                near[top + q, left + j] = min(near[top + q, left + j], w[W.NEAR + i], measured)
                slow[top + q, left + j] = min(slow[top + q, left + j], w[W.SLOW + i])

    @inlined
    def want_all(w: Any, tables: Any, box: Box) -> None:
        """Give the orbits of columns without a table to the scalar routine."""
        for q in range(box.columns):
            t, first = behind(tables, q * room), q * box.stride
            if t[TABLED] == 0.0:
                t[NEEDY] = float(box.starts)
                for i in range(first, first + box.starts):
                    w[W.WANTED + i] = 1.0

    @inlined
    def back_to_states(w: Any, tables: Any, box: Box) -> None:
        """Find the states of the orbits that the scalar routine gets from the block."""
        for q in range(box.columns):
            t, first = behind(tables, q * room), q * box.stride
            for i in range(first, first + box.starts if t[NEEDY] > 0.0 else first):
                if w[W.WANTED + i] > 0.0 and w[W.WHERE + i] == FLOWN:
                    w[W.U + i], w[W.V + i] = state_of(w[W.C1 + i], w[W.C2 + i], t)

    def fly(w: Any, tables: Any, rows: Any, box: Box, record: int, found: Found) -> int:
        """Take the wanted orbits through one period by the scalar routine; return how many columns now hold states."""
        top, columns, stride, left, starts = box
        holding = 0
        for q in range(columns):
            t, first = behind(tables, q * room), q * stride
            if t[HOLDING] > 0.0:
                for i in range(first, first + starts):
                    w[W.WHERE + i] = w[W.WHERE + i] if w[W.WANTED + i] > 0.0 else FLOWN
                t[HOLDING] = 0.0
            if t[NEEDY] == 0.0:
                continue
            c = constants_at(rows, top + q)
            for i in range(first, first + starts):
                if w[W.WANTED + i] > 0.0:
                    state, letter, outcome, _J, near, slow = period((w[W.U + i], w[W.V + i]), c)
                    w[W.U + i], w[W.V + i] = state
                    w[W.NEAR + i], w[W.SLOW + i] = min(w[W.NEAR + i], near), min(w[W.SLOW + i], slow)
                    w[W.HITS + i] = float(letter)
                    found.outcomes[top + q, record, left + i - first] |= outcome
                    found.undecided[top + q, left + i - first] += 1 if outcome & AMBIGUOUS else 0
                    w[W.WHERE + i], w[W.WANTED + i] = held(w, tables, columns, stride, q, i), 0.0
                t[HOLDING] += w[W.WHERE + i]
            t[NEEDY] = 0.0
            holding += 1 if t[HOLDING] > 0.0 else 0
        return holding

    @inlined
    def keep(w: Any, t: Any, first: int, starts: int, points: Any, letters: Any, row: int, n: int, left: int) -> None:
        """Write the states of a column's pairs, and how often each hit the wall."""
        u, v, hits = written_at(points, row, n, left)
        combined(numbers(points), u, starts, w, W.C1 + first, W.C2 + first, t, STATE, t[SIGMA])
        combined(numbers(points), v, starts, w, W.C1 + first, W.C2 + first, t, STATE + 3, 0.0)
        made_whole(numbers(letters), hits, starts, w, W.HITS + first)

    @inlined
    def repeat(points: Any, letters: Any, row: int, n: int, before: int, left: int, starts: int) -> None:
        """Write for a column what was written in an earlier period."""
        here, there = written_at(points, row, n, left), written_at(points, row, before, left)
        repeated(numbers(points), here[0], starts, there[0])
        repeated(numbers(points), here[1], starts, there[1])
        repeated(numbers(letters), here[2], starts, there[2])

    def advance(
        w: Any,
        tables: Any,
        runs: Any,
        rows: Any,
        strikes: tuple[float, float],
        box: Box,
        span: tuple[int, int, int],
        found: Found,
    ) -> None:
        """Take a block through its periods; in one call, as each call counts who uses the arrays."""
        top, columns, stride, left, starts = box
        transient, start, stop = span
        points, letters, outcomes, _undecided = found
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
            if two:  # the columns of the second wall behind those of the first
                for q in range(awake):
                    runs[AWAKE + awake + q] = columns + runs[AWAKE + q]
            certify(w, tables, room, runs, awake * walls, stride, starts)
            if bare > 0:
                want_all(w, tables, box)
            needy = bare + impacts(w, tables, runs, awake, columns, stride, strikes, kept >= 0)
            if needy > 0:
                back_to_states(w, tables, box)
            onward(w, tables, room, runs, awake, stride)
            if two:
                mirrored(w, tables, room, runs, awake, columns, stride)
            if needy + holding > 0:  # in most periods nobody needs the scalar routine
                holding = fly(w, tables, rows, box, record, found)
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
                    if w[W.WHERE + first + j] != FLOWN:
                        points[top + q, kept, 0, left + j] = w[W.U + first + j]
                        points[top + q, kept, 1, left + j] = w[W.V + first + j]

    def run(
        rows: Any, strikes: Any, job: Any, work: Any, tables: Any, runs: Any, lanes: Any, points: Any, letters: Any,
        outcomes: Any, near: Any, slow: Any, undecided: Any,
    ) -> None:  # fmt: skip
        top, bottom, several, stride, left, right, blocks, transient, start, stop = job
        w, t, ends = numbers(work), numbers(tables), numbers(runs)
        for first in range(top, bottom, several):
            box = Box(first, min(several, bottom - first), stride, left, right - left)
            begin(w, t, numbers(rows), blocks, box, lanes)
            found = Found(points, letters, outcomes, undecided)
            advance(w, t, ends, numbers(rows), strikes, box, (transient, start, stop), found)
            end(w, t, box, lanes, near, slow)

    return compiled(run, arithmetic, announce=ANNOUNCEMENT)


def padded(starts: int) -> int:
    """Return the room of a column in a block: whole vectors, so that loops that run over the end hit no neighbour."""
    return -(-starts // width()) * width()


@inlined
def written_at(points: Any, row: int, n: int, left: int) -> tuple[int, int, int]:
    """Return where position, velocity and letter of a start are written for period n of a column."""
    starts = points.shape[3]
    first = row * points.shape[1] + n
    return 2 * first * starts + left, (2 * first + 1) * starts + left, first * starts + left
