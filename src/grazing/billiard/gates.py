"""Gates of a strategy as kernels take them: a function of the user's, by address, is asked where a ball crosses one.

What is pressed decides what follows. So a ball has its own copy of the table's block, with a row for each gate: how far
its flipper had turned at a time, and until when its button is pressed. The pieces of the flipper's motion follow.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from grazing.billiard.elements import element, gap_of, holds, is_passed, width_of
from grazing.billiard.flippers import AT, BEGIN, CX, CY, FLIPPER_WIDTH, KINDS, OMEGA, PIECE_WIDTH, PIECES, PX, PY
from grazing.billiard.hit import away_of, first_turning, rows_of
from grazing.billiard.rows import (
    CIRCLES,
    EX,
    EY,
    FACES,
    FLIPPERS,
    HEAD,
    LAW,
    LONG,
    OWNER,
    PASSED,
    ROW,
    SIDES,
    THING,
    THINGS,
    WIDTH,
)
from grazing.billiard.strategy import MOTION
from grazing.kernel.elementary import sincos
from grazing.kernel.primitives import behind, derived_at, inlined

INFINITY = float("inf")
#: Widths of what touches beyond which a ball has left a line: more than a slide holds for touching.
LEFT = 256.0
#: Of a gate: which flipper it is of, the angle at which that rests, which way it turns, by how much at most, how fast
#: up and down, for how long a button is pressed; then how far it has turned at a time, and until when it is pressed.
TURNS, REST, WAY, STROKE, UP, DOWN, HOLD, SINCE, TURNED, UNTIL, GATE = range(11)


@inlined
def gates_at(table: Any) -> int:
    """Return where in a block the rows of gates begin: behind the pieces of all flippers."""
    flippers = HEAD + THING * int(table[THINGS]) + WIDTH * (int(table[FACES]) + int(table[CIRCLES]) + int(table[SIDES]))
    last = behind(table, flippers + FLIPPER_WIDTH * (int(table[FLIPPERS]) - 1))
    return flippers + int(last[AT]) + PIECE_WIDTH * int(last[PIECES])


def own_copy(table: Any) -> Any:
    """Return a copy of a block up to its gates, for one ball."""
    size = gates_at(table) + GATE * (int(table[THINGS]) - away_of(table))
    own = np.empty(size)
    for i in range(size):
        own[i] = table[i]
    return own


@inlined
def motion_at(gate: Any, t: float) -> Any:
    """Return (turned, rate, by_turned, by_until): how far a flipper has turned at a time, and how that depends.

    On how far it had turned before, and on when its button is released.
    """
    since, until, stroke = gate[SINCE], gate[UNTIL], gate[STROKE]
    top, rate, by_turned, by_until, end = gate[TURNED], gate[UP], 1.0, gate[UP], min(t, until)
    if end > since:
        top += gate[UP] * (end - since)
    else:
        by_until = 0.0
    if until > since and top >= stroke:
        top, rate, by_turned, by_until = stroke, 0.0, 0.0, 0.0
    if t < until:
        return top, rate, by_turned, 0.0
    rate = -gate[DOWN]
    top -= gate[DOWN] * (t - max(until, since))
    if until > since:
        by_until += gate[DOWN]
    return (top, rate, by_turned, by_until) if top > 0.0 else (0.0, 0.0, 0.0, 0.0)


@inlined
def flipper_of(gate: Any, table: Any) -> Any:
    """Return the rows of all flippers, and that of a gate."""
    flippers = behind(rows_of(table), WIDTH * (int(table[FACES]) + int(table[CIRCLES]) + int(table[SIDES])))
    return flippers, behind(flippers, FLIPPER_WIDTH * int(gate[TURNS]))


@inlined
def pivot_of(gate: Any, table: Any) -> Any:
    """Return the pivot of the flipper of a gate."""
    _flippers, row = flipper_of(gate, table)
    return row[PX], row[PY]


def moved(gate: Any, table: Any, since: float, turned: float, until: float) -> None:
    """Write down how the flipper of a gate moves from a time on."""
    gate[SINCE], gate[TURNED], gate[UNTIL] = since, turned, until
    flippers, row = flipper_of(gate, table)
    pieces, n, begin = behind(flippers, int(row[AT])), 0, since
    if until > since:
        there = since + (gate[STROKE] - turned) / gate[UP]
        if turned < gate[STROKE]:
            n = piece_put(pieces, n, begin, gate, turned, gate[UP])
        if there < until:
            n = piece_put(pieces, n, max(there, since), gate, gate[STROKE], 0.0)
        turned, begin = min(turned + gate[UP] * (until - since), gate[STROKE]), until
    if turned > 0.0:
        n = piece_put(pieces, n, begin, gate, turned, -gate[DOWN])
        begin += turned / gate[DOWN]
    for i in range(n, MOTION):
        n = piece_put(pieces, n, begin if i == n else INFINITY, gate, 0.0, 0.0)


@inlined
def piece_put(pieces: Any, n: int, begin: float, gate: Any, turned: float, rate: float) -> int:
    """Write a piece of a flipper's motion, and return the number of the next one."""
    piece = behind(pieces, PIECE_WIDTH * n)
    s, c = sincos(gate[REST] + gate[WAY] * turned)
    piece[BEGIN], piece[CX], piece[CY], piece[OMEGA] = begin, c, s, gate[WAY] * rate
    return n + 1


@inlined
def gate_of(number: int, table: Any) -> Any:
    """Return the row of a gate by its number among gates."""
    return behind(table, gates_at(table) + GATE * number)


@inlined
def gate_under(surface: int, table: Any) -> int:
    """Return the number of the gate of the flipper that a surface is of, -1 for none."""
    for number in range(int(table[THINGS]) - away_of(table)):
        if int(gate_of(number, table)[TURNS]) == (surface - first_turning(table)) // KINDS:
            return number
    return -1


def asked(number: int, x: float, y: float, vx: float, vy: float, t: float, table: Any) -> int:
    """Ask at a gate, unless the button is pressed, and press it; return what it says, 1 or 0, or -1 for neither."""
    gate = gate_of(number, table)
    if t <= gate[UNTIL]:
        return 0
    thing = behind(table, HEAD + THING * (away_of(table) + number))
    (said,), _said = derived_at(thing[LAW], (x, y, vx, vy), thing[ROW], (0.0,))
    if said == 0.0:
        return 0
    if said != 1.0:
        return -1
    turned, _rate, _by_turned, _by_until = motion_at(gate, t)
    moved(gate, table, t, turned, t + gate[HOLD])
    return 1


@inlined
def passed_at(i: int, surface: int, x: float, y: float, vx: float, vy: float, table: Any) -> int:
    """Return the side of the face i on which a ball comes that goes through the gate of a surface, -1 for none.

    Gates may lie on one line, or cross there.
    """
    if surface // 2 == i:
        return surface
    row = behind(rows_of(table), WIDTH * i)
    if int(row[OWNER]) < away_of(table) or row[LONG] < 0.0:
        return -1
    rate = row[EY] * vx - row[EX] * vy
    side = 2 * i + (1 if rate < 0.0 else 0)
    line = element(side, 0.0, table)
    width = 2.0 * width_of(line, x, y)
    on = rate != 0.0 and abs(gap_of(line, x, y)) <= width and holds(line, x, y, width)
    return side if on else -1


@inlined
def shut(surface: int, table: Any) -> None:
    """Let a ball through the side of a gate, on which it is not met again before it has left that line."""
    row, side = behind(rows_of(table), WIDTH * (surface // 2)), 2.0 * (surface % 2) - 1.0
    row[PASSED] = side * (row[LONG] if row[LONG] >= 0.0 else abs(row[PASSED]))
    row[LONG] = -1.0


@inlined
def opened(owner: int, surface: int, x: float, y: float, table: Any) -> Any:
    """Open the gates whose lines a ball has left, and say whether it is still on that of another one.

    All, if it comes to the surface of a solid ``owner``, which may turn it back at once, or once around a circle to a
    gate again.
    """
    every = 0 <= owner < away_of(table) or is_passed(surface, table)
    some = False
    for i in range(int(table[FACES])):
        row = behind(rows_of(table), WIDTH * i)
        if row[PASSED] != 0.0:
            line = element(2 * i, 0.0, table)
            if every or abs(gap_of(line, x, y)) > LEFT * width_of(line, x, y):
                row[LONG], row[PASSED] = abs(row[PASSED]), 0.0
            else:
                some = True
    return some
