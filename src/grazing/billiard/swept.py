"""Flippers that turn beside a ball that slides: whether one sweeps it off, and when its motion has to be looked at.

The distance h from what turns with omega changes by |v| + |omega| R per time at most, and |v| by gravity: a step in
which that does not use up h is safe. So is one in which a distance that grows does not fall back to 0. Seen from the
flipper the ball is accelerated by less than gravity + L (4 L bend + 7 |omega|), L = |v| + |omega| (R + h), for a time
in which that changes its velocity by L. Without it one that comes loose slowly took a hundred thousand steps.
"""

from __future__ import annotations

from math import sqrt
from typing import Any

from grazing.billiard.elements import TOUCH, bend_of, element, gap_of, slid, width_of
from grazing.billiard.flippers import (
    ARM,
    AT,
    AT_TIP,
    FLIPPER_WIDTH,
    KINDS,
    LONG,
    OMEGA,
    PIECE_WIDTH,
    PIECES,
    PX,
    PY,
    REACH,
    SIZE,
    TIP,
)
from grazing.billiard.hit import first_turning, rows_of
from grazing.billiard.rows import CIRCLES, FACES, FLIPPERS, GRAVITY, SIDES, WIDTH
from grazing.billiard.turning import begin_of, clock_of, direction_at, normal_at, piece_at
from grazing.kernel.primitives import behind, inlined

INFINITY = float("inf")
#: Steps beside one flipper, after which what comes is not looked at.
MOST = 100_000


@inlined
def flippers_of(table: Any) -> Any:
    """Return where the rows of flippers begin."""
    return behind(rows_of(table), WIDTH * (int(table[FACES]) + int(table[CIRCLES]) + int(table[SIDES])))


@inlined
def is_near(row: Any, el: Any, x: float, y: float, room: float) -> Any:
    """Say whether a flipper that ever turns may come to a ball that moves no further than ``room``, on an element."""
    dx, dy = x - row[PX], y - row[PY]
    far = abs(gap_of(el, row[PX], row[PY])) - width_of(el, x, y)
    on_way = far <= row[REACH] or not room < INFINITY
    return row[PIECES] > 1.0 and on_way and sqrt(dx * dx + dy * dy) <= row[REACH] + room


def horizon(el: Any, x: float, y: float, room: float, clock: float, table: Any) -> Any:
    """Return (t, busy): when a flipper that may come to a ball begins or ends to turn, and whether one turns now."""
    end, busy, rows = INFINITY, False, flippers_of(table)
    for i in range(int(table[FLIPPERS])):
        row = behind(rows, FLIPPER_WIDTH * i)
        if not is_near(row, el, x, y, room):
            continue
        pieces, phase = behind(rows, int(row[AT])), clock_of(clock, row)
        number, turns = piece_at(0.0, phase, row, pieces)
        busy = busy or pieces[PIECE_WIDTH * number + OMEGA] != 0.0
        # the time must go on, by what the clock can tell
        end = min(end, max(begin_of(number + 1, turns, phase, row, pieces), 2.0**-50 * abs(clock)))
    return end, busy


def room_beside(
    row: Any, ux: float, uy: float, omega: float, x: float, y: float, vx: float, vy: float, width: float
) -> Any:  # fmt: skip
    """Return (h, rate, kind, grows): how far the ball's centre is from where it would touch sides or tip of a flipper.

    ``rate`` says whether it comes, ``grows`` is the rate of that distance, or less.
    """
    dx, dy = x - row[PX], y - row[PY]
    kind, wx, wy = 0 if ux * dy - uy * dx >= 0.0 else 1, vx + omega * dy, vy - omega * dx
    nx, ny = normal_at(kind, ux, uy, row)
    way = 1.0 - 2.0 * kind
    foot, h = way * (ny * dx - nx * dy), nx * dx + ny * dy - row[SIZE]
    if foot > row[LONG]:
        kind = AT_TIP
        ex, ey = dx - row[ARM] * ux, dy - row[ARM] * uy
        far = sqrt(ex * ex + ey * ey)
        nx, ny, h = ex / far, ey / far, far - row[TIP]
    elif foot <= width:  # where the side begins at the hub, on which the ball may slide
        return sqrt(foot * foot + h * h), -way * (ny * wx - nx * wy), kind, -sqrt(wx * wx + wy * wy)
    return h, nx * wx + ny * wy, kind, nx * wx + ny * wy


def swept(
    surface: int, x: float, y: float, vx: float, vy: float, rests: bool, end: float, clock: float, table: Any
) -> Any:  # fmt: skip
    """Return (t, surface): when a ball that slides on a surface, or rests there, meets a flipper that turns.

    That is before ``end``; the surface is -1 for never.
    """
    best, met, rows, g = end, -1, flippers_of(table), table[GRAVITY]
    bend = 0.0 if rests else abs(bend_of(element(surface, clock, table)))
    for i in range(int(table[FLIPPERS])):
        row = behind(rows, FLIPPER_WIDTH * i)
        pieces, phase = behind(rows, int(row[AT])), clock_of(clock, row)
        number, turns = piece_at(0.0, phase, row, pieces)
        piece, begin = behind(pieces, PIECE_WIDTH * number), begin_of(number, turns, phase, row, pieces)
        omega, t, least = piece[OMEGA], 0.0, 0.0
        if omega == 0.0:
            continue
        width = TOUCH * (abs(x) + abs(y) + row[REACH])
        for _ in range(MOST):
            fx, fy, fvx, fvy = (x, y, 0.0, 0.0) if rests else slid(surface, x, y, vx, vy, t, clock, table)
            ux, uy, _turned = direction_at(t, begin, piece)
            h, rate, kind, grows = room_beside(row, ux, uy, omega, fx, fy, fvx, fvy, width)
            if h <= width and rate < 0.0:
                best, met = t, first_turning(table) + KINDS * i + kind
                break
            fast = sqrt(fvx * fvx + fvy * fvy) + abs(omega) * row[REACH]
            least = 2.0 * least if h <= width else width / fast
            h = max(h, 0.0)
            safe = 2.0 * h / (fast + sqrt(fast * fast + 4.0 * g * h))
            grows -= TOUCH * fast
            if grows > 0.0:
                fast += abs(omega) * h
                most = g + fast * (4.0 * fast * bend + 7.0 * abs(omega))
                safe = max(safe, min((grows + sqrt(grows * grows + 2.0 * most * h)) / most, fast / most))
            t += max(safe, least, width / fast)
            if not t < best:
                break
    return best, met
