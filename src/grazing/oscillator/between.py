"""Between two walls: the tables of both, and the impacts of one period for all orbits of a block together.

Each wall sees the ball as that of an oscillator above it, see :mod:`grazing.oscillator.frames`, and has a table of its
own. A block holds each orbit twice: the pair that the first wall sees, which is its state, and behind all of those, in
columns of their own, the pair that the second wall sees. An orbit that passes both certificates is free. Of two walls
that it may hit that one is asked whose cell ends before the other's begins; an orbit that may hit both within such a
time is left to the scalar routine. After an impact the rest of the period is asked of both walls, of the other one
from the cell on in which the impact was. See ``docs/proof.md``.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any

from grazing.kernel.primitives import behind, called_for_all, inlined, unit
from grazing.kernel.rows import passing
from grazing.oscillator.block import dip, hand_back, is_chord, kick, look_up, placed, set_apart, solve_of
from grazing.oscillator.cells import (
    ALPHA,
    BROUGHT,
    CERTIFICATE,
    COUNT,
    ENTER,
    GO_ON,
    GROWN,
    HALF,
    K2,
    LAST,
    LEVER,
    MAX_ROWS,
    MIDDLE,
    MIRROR,
    NEEDY,
    PACE,
    RATE,
    SHARP,
    SPAN,
    cell_size,
    table_size,
)  # fmt: skip
from grazing.oscillator.cells import CELLS as FIRST_CELL
from grazing.oscillator.certificate import candidates, count_hits, describe, locate, next_event, runs_of
from grazing.oscillator.pairs import margin_of
from grazing.oscillator.workspace import HIGH, NAN, WHOSE, W

#: A letter tells 19 impacts apart; an orbit that has this many or more of them is left to the scalar routine.
LONG = 3.0**17


@inlined
def cell_at(t: Any, size: int, time: float) -> int:
    """Return the cell that a time is in."""
    last = int(t[LAST])
    cell = min(max(int(time * t[PACE]), 0), last)
    while cell > 0 and time < t[MIDDLE + cell] - t[FIRST_CELL + cell * size + HALF]:
        cell -= 1
    while cell < last and time > t[MIDDLE + cell] + t[FIRST_CELL + cell * size + HALF]:
        cell += 1
    return cell


# ---- which wall comes first


@inlined
def order(t: Any, one: float, s: Any, other: float, size: int) -> int:
    """Return 1 if the event at place ``one`` of a table is before that of the other, -1 if after, 0 if it is open.

    Nothing of one wall is before the cell of its event; cells that end where others begin may seem to overlap.
    """
    if not (one > 0.0 and other > 0.0):
        return 0
    i, j = (int(one) - 1) // 2, (int(other) - 1) // 2
    h, k = t[FIRST_CELL + i * size + HALF], s[FIRST_CELL + j * size + HALF]
    between = s[MIDDLE + j] - t[MIDDLE + i]
    least = (h + k) - 1e-9 * min(h, k)
    return 1 if between >= least else (-1 if -between >= least else 0)


@inlined
def first_of_two(
    w: Any, tables: Any, room: int, size: int, runs: Any, places: int, several: int, columns: int, half: int
) -> tuple[int, int]:  # fmt: skip
    """Of orbits that both certificates left open keep the wall that comes first; return how many places, and runs.

    FREE gets 0 for the other one. Where neither is known to, the place is left without an event. DOUBT gets the error
    of heights: the margin without what chords make of it. Impacts carry that on; rows are asked with both.
    """
    rivals = 0
    for n in range(several):
        q = runs[WHOSE + n]
        sharp, brought = tables[q * room + SHARP], tables[q * room + BROUGHT] if q >= columns else 0.0
        for k in range(runs[n], runs[n + 1]):
            w[W.DOUBT + k] = w[W.DOUBT + k] * sharp + brought
        if q < columns:
            for k in range(runs[n], runs[n + 1]):
                w[W.PLACE + int(w[W.ORBIT + k])] = float(k)
            continue
        t, s = behind(tables, (q - columns) * room), behind(tables, q * room)
        for k in range(runs[n], runs[n + 1]):
            i = int(w[W.ORBIT + k]) - half
            if w[W.FREE + i] < 0.0:
                h = int(w[W.PLACE + i])
                sooner = order(t, w[W.EVENT + h], s, w[W.EVENT + k], size)
                w[W.FREE + i + (half if sooner >= 0 else 0)] = 0.0
                w[W.EVENT + h] = 0.0 if sooner == 0 else w[W.EVENT + h]
                rivals += 1
    if rivals == 0:
        return places, several
    count, to = int(0.0), int(0.0)  # of a literal 0 the compiler would make versions of their own
    for n in range(several):
        start, end = runs[n], runs[n + 1]
        runs[count], runs[WHOSE + count] = to, runs[WHOSE + n]
        for k in range(start, end):
            w[W.X1 + to], w[W.X2 + to], w[W.DOUBT + to] = w[W.X1 + k], w[W.X2 + k], w[W.DOUBT + k]
            w[W.ORBIT + to], w[W.EVENT + to] = w[W.ORBIT + k], w[W.EVENT + k]
            to += 1 if w[W.FREE + int(w[W.ORBIT + k])] < 0.0 else 0
        count += 1 if to > runs[count] else 0
    runs[count] = to
    describe(w, tables, room, runs, count)
    return to, count


# ---- the impacts of a period


@inlined
def strike_all(
    w: Any, tables: Any, room: int, runs: Any, count: int, columns: int, strikes: tuple[float, float]
) -> None:  # fmt: skip
    """Ask the laws, each for the runs of its wall."""
    n = int(0.0)
    while n < count:
        end, second = n + 1, runs[WHOSE + n] >= columns
        while end < count and (runs[WHOSE + end] >= columns) == second:
            end += 1
        called_for_all(strikes[1] if second else strikes[0], w, tables, room, behind(runs, n), end - n)
        n = end


@inlined
def begin_errors(w: Any, places: int) -> None:
    """Let flights begin at the strobe, where states are exact."""
    for base in range(0, places, 64):
        for k in range(64):
            i = base + k
            w[W.START + i], w[W.OFF_Y + i], w[W.OFF_V + i], w[W.BASE + i] = 0.0, 0.0, 0.0, w[W.DOUBT + i]


@inlined
def carry_errors(w: Any, tables: Any, room: int, runs: Any, count: int, first: bool) -> None:
    """Find how wrong the departures after the impacts at hand may be: WIDER gets what that does to heights later.

    The bound of :func:`kick` knows of no short flights, such as those between near walls. The ``first`` flights of
    a period bring nothing along.
    """
    for n in range(count):
        t = behind(tables, runs[WHOSE + n] * room)
        lever, grown, fast, alpha, k2 = t[LEVER], t[GROWN], t[RATE] - t[ALPHA], t[ALPHA], t[K2]
        if first:
            for i in range(runs[n], runs[n + 1]):
                depart(w, i, w[W.BASE + i], fast * w[W.BASE + i], alpha, grown, lever)
            continue
        for i in range(runs[n], runs[n + 1]):
            off_y, off_v, base = w[W.OFF_Y + i], w[W.OFF_V + i], w[W.BASE + i]
            time = t[MIDDLE + int(w[W.INSIDE + i])] + w[W.WHEN + i]
            reach = min(max(time - w[W.START + i], 0.0), lever)
            error_y = base + (grown * off_y + reach * off_v)
            depart(w, i, error_y, fast * base + (k2 * reach * off_y + grown * off_v), alpha, grown, lever)


@inlined
def depart(w: Any, i: int, error_y: float, error_v: float, alpha: float, grown: float, lever: float) -> None:
    """Find how wrong a departure is made by what is wrong on arrival."""
    v, u, pull = w[W.BEFORE + i], w[W.AFTER + i], w[W.PULL + i]
    late, lift = -w[W.INVERSE + i] * error_y, pull + alpha * (v - u)
    off_y, off_v = u * late, w[W.STEEP + i] * (error_v + abs(pull) * late) + abs(lift) * late
    w[W.NEXT_Y + i], w[W.NEXT_V + i] = off_y, off_v
    w[W.WIDER + i] = grown * off_y + lever * off_v if w[W.WIDER + i] < HIGH else NAN


@inlined
def certify_both(w: Any, tables: Any, room: int, size: int, runs: Any, count: int, columns: int) -> int:
    """Ask both certificates about the rest of the period; list those that do not fly free in REST."""
    left = 0
    for n in range(count):
        q = runs[WHOSE + n]
        t = behind(tables, q * room)
        s = behind(tables, (q + columns if q < columns else q - columns) * room)
        rows, others = int(t[COUNT]), CERTIFICATE + int(s[COUNT])
        for i in range(runs[n], runs[n + 1]):
            since, doubt = int(w[W.THEN + i]), w[W.WIDER + i]
            x, y = w[W.Z1 + i], w[W.Z2 + i]
            limit = margin_of(t, x, y) + doubt
            passes = passing(t, CERTIFICATE + since, MAX_ROWS, rows - since, x, y, limit) & (limit < HIGH)
            w[W.PAST + i] = 1.0 if passes else 0.0
            if passes:
                x, y = s[MIRROR] - x, s[MIRROR + 1] - y
                cell = cell_at(s, size, t[MIDDLE + int(w[W.INSIDE + i])] + w[W.WHEN + i])
                row, limit = int(s[ENTER + cell]), margin_of(s, x, y) + (s[BROUGHT] + doubt)
                passes = passing(s, row, MAX_ROWS, others - row, x, y, limit) & (limit < s[SPAN])
            w[W.REST + left] = float(i)
            left += 0 if passes else 1
    return left


@inlined
def hand_home(w: Any, tables: Any, room: int, runs: Any, count: int, columns: int, stride: int, left: int) -> None:
    """Give the pairs of orbits that hit the second wall to the first one's columns, but for those in REST."""
    half = columns * stride
    for n in range(left):
        i = int(w[W.ORBIT + int(w[W.REST + n])])
        w[W.FREE + i] = 0.0
    for n in range(count):
        q = runs[WHOSE + n]
        s = behind(tables, q * room)
        m1, m2 = s[MIRROR], s[MIRROR + 1]
        for h in range(q * stride, (q + 1) * stride if q >= columns else q * stride):
            i = h - half
            there = w[W.FREE + h] < 0.0
            w[W.C1 + i] = m1 - w[W.C1 + h] if there else w[W.C1 + i]
            w[W.C2 + i] = m2 - w[W.C2 + h] if there else w[W.C2 + i]
            w[W.HITS + i] = w[W.HITS + h] if there else w[W.HITS + i]
            w[W.FREE + i] = min(w[W.FREE + i], w[W.FREE + h])


@inlined
def finish(w: Any, s: Any, i: int, second: bool, x: float, y: float, letter: float) -> None:
    """Give an orbit its pair at the end of the period, as a wall sees it, and its letter."""
    w[W.C1 + i], w[W.C2 + i] = s[MIRROR] - x if second else x, s[MIRROR + 1] - y if second else y
    w[W.HITS + i] = letter


@inlined
def spelt(letter: float, second: bool) -> float:
    """Return a letter with one more impact."""
    return 3.0 * letter + (2.0 if second else 1.0)


@lru_cache(maxsize=64)
def impacts_between_of(harmonics: int) -> Callable[..., int]:
    """Return what :func:`grazing.oscillator.impacts.impacts_of` returns, for two walls."""
    solve = solve_of(harmonics)
    room, size = table_size(harmonics), cell_size(harmonics)

    @inlined
    def hand_on(w: Any, tables: Any, count: int, columns: int, left: int) -> None:
        """Give the orbits that hit again and then fly free their pairs, but for those in REST."""
        n = 0
        for k in range(count):
            i, q = int(w[W.ORBIT + k]), int(w[W.COLUMN + k])
            w[W.SLOW + i] = min(w[W.SLOW + i], w[W.SPEED + k])
            if n < left and int(w[W.REST + n]) == k:
                n += 1
            else:
                second = q >= columns
                t = behind(tables, q * room)
                finish(w, t, i, second, w[W.Z1 + k], w[W.Z2 + k], spelt(w[W.MET + k], second))

    @inlined
    def go_on(
        w: Any, tables: Any, columns: int, half: int, k: int, apart: int, places: int
    ) -> tuple[bool, int]:  # fmt: skip
        """Put the next event of the orbit at place k, of either wall, to the impacts at hand.

        ``apart`` is where :func:`set_apart` has put it. Return whether the scalar routine must fly it, and how many
        impacts are at hand then.
        """
        i, q, cell, letter = int(w[W.ORBIT + k]), int(w[W.COLUMN + k]), int(w[W.INSIDE + k]), w[W.MET + k]
        second = q >= columns
        p = q - columns if second else q + columns
        i = i - half if i >= half else i
        t, s = behind(tables, q * room), behind(tables, p * room)
        hits = w[W.WIDER + k] < HIGH
        if hits:
            x, y, when = w[W.Z1 + k], w[W.Z2 + k], w[W.WHEN + k]
            since, back, letter = t[GO_ON + cell], float(cell), spelt(letter, second)
            begun, off_y, off_v, kept = t[MIDDLE + cell] + when, w[W.NEXT_Y + k], w[W.NEXT_V + k], 0.0
        else:
            if not is_chord(w[W.EVENT + k]) or not w[W.PROVEN + apart] > 0.0:
                return True, places
            if w[W.PULL + apart] > 0.0:
                w[W.NEAR + i] = min(w[W.NEAR + i], w[W.AFTER + apart])
            x, y, when = w[W.X1 + k], w[W.X2 + k], w[W.SINCE + apart]
            since, back = w[W.EVENT + k] + 1.0, -1.0
            begun, off_y, off_v, kept = w[W.START + k], w[W.OFF_Y + k], w[W.OFF_V + k], w[W.BASE + k]
        time = t[MIDDLE + cell] + when
        u, v, j = s[MIRROR] - x, s[MIRROR + 1] - y, cell_at(s, size, time)
        mine, theirs, later = margin_of(t, x, y), margin_of(s, u, v), t[GROWN] * off_y + t[LEVER] * off_v
        limit = theirs + (s[BROUGHT] + (later + kept))
        if not limit < s[SPAN] or letter > LONG:
            return True, places
        own = 0.0
        if not (hits and w[W.PAST + k] > 0.0):
            own = next_event(t, since, x, y, mine + (later + kept))
        other = next_event(s, 2.0 * j + 1.0, u, v, limit)
        sooner = 1
        if other > 0.0:
            sooner = -1 if own == 0.0 else order(t, own, s, other, size)
        if sooner == 0:
            return True, places
        base = kept if kept > 0.0 else t[SHARP] * mine
        if sooner < 0:
            base = s[SHARP] * theirs + (s[BROUGHT] + kept)
            placed(w, places, p, u, v, base + later, other, float(j), time - s[MIDDLE + j], i, letter)
        elif own > 0.0:
            placed(w, places, q, x, y, base + later, own, back, when, i, letter)
        else:
            finish(w, t, i, second, x, y, letter)
            return False, places
        w[W.START + places], w[W.OFF_Y + places], w[W.OFF_V + places], w[W.BASE + places] = begun, off_y, off_v, base
        return False, places + 1

    @unit
    def impacts(
        w: Any, tables: Any, runs: Any, awake: int, columns: int, stride: int, strikes: Any, counted: bool
    ) -> int:  # fmt: skip
        half = columns * stride
        places, several = candidates(w, runs, 2 * awake, stride)
        if counted:
            count_hits(w, runs, 2 * awake, columns, stride)
        locate(w, tables, room, runs, several)
        places, several = first_of_two(w, tables, room, size, runs, places, several, columns, half)
        begin_errors(w, places)
        first, needy = True, 0
        while places > 0:
            look_up(w, tables, room, places, harmonics)
            solve(w, places)
            strike_all(w, tables, room, runs, several, columns, strikes)
            kick(w, places)
            carry_errors(w, tables, room, runs, several, first)
            left = certify_both(w, tables, room, size, runs, several, columns)
            if first:  # most orbits hit once and are done: as if all were
                hand_back(w, runs, several, stride, left)
                hand_home(w, tables, room, runs, several, columns, stride, left)
            else:
                hand_on(w, tables, places, columns, left)
            first = False
            dips = set_apart(w, left)
            dip(w, dips)
            places, dips = int(0.0), 0  # of a literal 0 the compiler would make versions of their own
            for n in range(left):
                k = int(w[W.REST + n])
                i, q = int(w[W.ORBIT + k]), int(w[W.COLUMN + k])
                misses = not w[W.WIDER + k] < HIGH and is_chord(w[W.EVENT + k])
                wanted, places = go_on(w, tables, columns, half, k, dips, places)
                dips += 1 if misses else 0
                if wanted:
                    t = behind(tables, (q - columns if q >= columns else q) * room)
                    w[W.WANTED + (i - half if i >= half else i)] = 1.0
                    t[NEEDY] += 1.0
                    needy += 1
            several = runs_of(w, places, runs)
            describe(w, tables, room, runs, several)
        return needy

    return impacts
