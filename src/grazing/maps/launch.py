"""Launches of a ball on a table, as kernels take them: one by one, or side by side, one in the place of another."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from math import pi
from typing import Any, NamedTuple

import numpy as np

from grazing.billiard.carried import next_carried
from grazing.billiard.contact import next_impact
from grazing.billiard.gates import own_copy
from grazing.billiard.hit import away_of, way_at
from grazing.billiard.packed import impact_of, impacts, padded_contacts
from grazing.billiard.rows import CIRCLES
from grazing.billiard.workspace import LANES, I, W, room_for
from grazing.kernel.compile import compiled
from grazing.kernel.elementary import sincos
from grazing.kernel.primitives import inlined, numbers, numbers_at, picked
from grazing.kernel.turns import eights
from grazing.maps.collide import Kernels
from grazing.outcome import ESCAPED, FATAL, OK, TOO_MANY_IMPACTS

NAN = float("nan")
#: Angles beyond which the sines of kernels are not meant.
FAR = 1e5
#: Impacts of each ball in one call of the kernel, in which nothing stops it.
ROUNDS = 10_000


class Launch(NamedTuple):
    """What a kernel needs of a launch: where the block of a table lies, the ball, and most impacts."""

    block: Any
    x: float
    y: float
    hits: float


@inlined
def launch(x: float, y: float, vx: float, vy: float, most: int, table: Any) -> Any:
    """Return (way, hits, time, outcome): how a ball leaves, by the number of the drain, the last one being *away*."""
    left, t, outcome = -1.0, 0.0, OK
    for hits in range(most + 1):
        (_surface, owner, length, flags, on), _before, after, _speeds = next_impact(x, y, vx, vy, left, t, table)
        outcome |= flags
        t += length
        if flags & FATAL:
            return -1, hits, t, outcome
        if flags & ESCAPED:
            return owner if owner >= 0 else away_of(table), hits, t, outcome
        left, (x, y, vx, vy) = on, after
    return -1, most, t, outcome | TOO_MANY_IMPACTS


@inlined
def stays(angle: float, speed: float, table: Any) -> int:
    """Return the number of the way out in which a ball rests in this state; -1 if it is one of a launch."""
    way = way_at(angle, table)
    return way if speed == 0.0 and way >= 0 and way == angle else -1


@inlined
def way_out(state: Any, x: float, y: float, most: int, table: Any) -> Any:
    """Return (state, letter, outcome) of a launch: the way out, and the ball at rest there."""
    angle, speed = state
    way = stays(angle, speed, table)
    if way >= 0:
        return (1.0 * way, 0.0), way, ESCAPED
    s, c = heading(angle)
    way, _hits, _t, outcome = launch(x, y, speed * c, speed * s, most, table)
    if outcome & FATAL:
        return (NAN, NAN), 0, outcome
    return (1.0 * way, 0.0), way, outcome


def watched(x: float, y: float, vx: float, vy: float, most: int, table: Any, room: Any) -> Any:
    """Return what :func:`launch` does, of a ball that a strategy looks at; ``table`` is the ball's own."""
    left, t, outcome = -1.0, 0.0, OK
    for hits in range(most + 1):
        (_surface, owner, length, flags, on), _before, after, _speeds, _force = next_carried(
            x, y, vx, vy, left, t, table, room, 0, 0
        )
        outcome |= flags
        t += length
        if flags & FATAL:
            return -1, hits, t, outcome
        if flags & ESCAPED:
            return owner if owner >= 0 else away_of(table), hits, t, outcome
        left, (x, y, vx, vy) = on, after
    return -1, most, t, outcome | TOO_MANY_IMPACTS


def watched_out(state: Any, x: float, y: float, most: int, table: Any) -> Any:
    """Return what :func:`way_out` does, of a ball that a strategy looks at."""
    angle, speed = state
    way = stays(angle, speed, table)
    if way >= 0:
        return (1.0 * way, 0.0), way, ESCAPED
    own, room, (s, c) = own_copy(table), np.empty(1), heading(angle)
    way, _hits, _t, outcome = watched(x, y, speed * c, speed * s, most, numbers(own), numbers(room))
    own[0] = room[0] = 0.0  # an array lives up to its last use, its numbers do not keep it
    if outcome & FATAL:
        return (NAN, NAN), 0, outcome
    return (1.0 * way, 0.0), way, outcome


def kernels_of(out: Callable[..., Any]) -> Kernels:
    """Return the kernels of launches that end as ``out`` says; J is 0: the ball comes to rest in one of few places."""

    def step(state: Any, c: Launch) -> Any:
        return out(state, c.x, c.y, int(c.hits), numbers_at(c.block))

    def tangent(state: Any, c: Launch) -> Any:
        new, letter, outcome = out(state, c.x, c.y, int(c.hits), numbers_at(c.block))
        return new, letter, outcome, (0.0, 0.0, 0.0, 0.0, NAN)

    def plain(state: Any, c: Any) -> Any:
        return out(state, c.x, c.y, int(c.hits), c.block)

    def plain_tangent(state: Any, c: Any) -> Any:
        new, letter, outcome = out(state, c.x, c.y, int(c.hits), c.block)
        return new, letter, outcome, (0.0, 0.0, 0.0, 0.0)

    return Kernels(step, tangent, plain, plain_tangent)


#: Launches of a ball, and of one that a strategy looks at.
FREE, WATCHED = kernels_of(way_out), kernels_of(watched_out)


def heading(angle: float) -> tuple[float, float]:
    """Return sine and cosine of an angle, with the bits of a browser; beyond 1e5 whole turns are taken off first."""
    return sincos(angle if abs(angle) < FAR else angle % (2.0 * pi))


def fan(
    block: Any, x: float, y: float, most: int, angles: Any, speeds: Any, ways: Any, hits: Any, times: Any,
    outcomes: Any,
) -> None:  # fmt: skip
    """Launch a ball at all angles and speeds of two lists."""
    table = numbers(block)
    for i in range(len(angles)):
        s, c = heading(angles[i])
        for j in range(len(speeds)):
            vx, vy = speeds[j] * c, speeds[j] * s
            ways[i, j], hits[i, j], times[i, j], outcomes[i, j] = launch(x, y, vx, vy, most, table)


def watched_fan(
    block: Any, x: float, y: float, most: int, angles: Any, speeds: Any, ways: Any, hits: Any, times: Any,
    outcomes: Any,
) -> None:  # fmt: skip
    """Launch balls that a strategy looks at, each at an angle and a speed."""
    table = numbers(block)
    for i in range(len(angles)):
        own, room, (s, c) = own_copy(table), np.empty(1), heading(angles[i])
        vx, vy = speeds[i] * c, speeds[i] * s
        ways[i], hits[i], times[i], outcomes[i] = watched(x, y, vx, vy, most, numbers(own), numbers(room))
        own[0] = room[0] = 0.0  # an array lives up to its last use, its numbers do not keep it


@lru_cache(maxsize=1)
def watcher() -> Any:
    """Compile :func:`watched_fan`."""
    return compiled(watched_fan)


class Found(NamedTuple):
    """Where a kernel writes what :func:`launch` returns, launch by launch.

    Compiled code is given addresses: arrays are counted, ball by ball, and counting takes longer than an impact.
    """

    ways: Any
    hits: Any
    times: Any
    outcomes: Any


@inlined
def begun(w: Any, i: int, number: int, x: float, y: float, angle: float, speed: float) -> None:
    """Put a launch into a workspace."""
    s, c = heading(angle)
    w[W.X + i], w[W.Y + i], w[W.VX + i], w[W.VY + i] = x, y, speed * c, speed * s
    w[W.CLOCK + i], w[W.LEFT + i], w[W.NUMBER + i], w[W.HITS + i], w[W.OUTCOME + i] = 0.0, -1.0, 1.0 * number, 0.0, 0.0


@inlined
def ended(w: Any, i: int, most: int, table: Any, found: Found) -> bool:
    """Take a ball over its next impact; write down what becomes of it, if that is the end."""
    (_surface, owner, length, flags, on), _before, after, _speeds = impact_of(w, i, table)
    at, hits, t = int(w[W.NUMBER + i]), int(w[W.HITS + i]), w[W.CLOCK + i] + length
    outcome = int(w[W.OUTCOME + i]) | flags
    w[W.CLOCK + i], w[W.LEFT + i], w[W.HITS + i], w[W.OUTCOME + i] = t, on, hits + 1.0, 1.0 * outcome
    w[W.X + i], w[W.Y + i], w[W.VX + i], w[W.VY + i] = after
    if not flags & (FATAL | ESCAPED) and hits < most:
        return False
    way = -1
    if flags & ESCAPED and not flags & FATAL:
        way = owner if owner >= 0 else away_of(table)
    if not flags & (FATAL | ESCAPED):
        outcome |= TOO_MANY_IMPACTS
    found.ways[at], found.hits[at], found.times[at], found.outcomes[at] = way, hits, t, outcome
    return True


@inlined
def went_on(w: Any, n: int, most: int) -> None:
    """Take balls over plain impacts, but for their last one; the others are then not PLAIN."""
    for k in range((n + 7) // 8 * 8):
        i = eights(k)
        goes = (w[I.PLAIN + i] > 0.0) & (w[W.HITS + i] < most)
        w[I.PLAIN + i] = 1.0 if goes else 0.0
        w[W.X + i], w[W.Y + i] = picked(goes, w[I.X + i], w[W.X + i]), picked(goes, w[I.Y + i], w[W.Y + i])
        w[W.VX + i], w[W.VY + i] = picked(goes, w[I.VX + i], w[W.VX + i]), picked(goes, w[I.VY + i], w[W.VY + i])
        w[W.CLOCK + i] = w[W.CLOCK + i] + picked(goes, w[W.TIME + i], 0.0)
        w[W.LEFT + i] = picked(goes, w[W.SURFACE + i], w[W.LEFT + i])
        w[W.HITS + i] = w[W.HITS + i] + (1.0 if goes else 0.0)


def fly(
    w: Any, job: Any, rounds: int, x: float, y: float, most: int, angles: Any, speeds: Any, table: Any, found: Found
) -> None:  # fmt: skip
    """Follow launches side by side, as :func:`launch` does each, for so many impacts of a ball at most.

    ``job`` holds how many launches have begun, and how many of them have not ended: those are in the workspace. It is
    called until there are none.
    """
    begin, n = job[0], job[1]
    for _ in range(rounds):
        while n < LANES and begin < len(angles):
            begun(w, n, begin, x, y, angles[begin], speeds[begin])
            begin, n = begin + 1, n + 1
        if n == 0:
            break
        padded_contacts(w, n, table)
        impacts(w, n, table)
        went_on(w, n, most)
        for i in range(n - 1, -1, -1):
            if not w[I.PLAIN + i] > 0.0 and ended(w, i, most, table, found):
                n -= 1
                for row in range(W.X, W.SURFACE, LANES):  # the last one takes its place
                    w[row + i] = w[row + n]
    job[0], job[1] = begin, n


@lru_cache(maxsize=1)
def launcher() -> Callable[..., None]:
    """Compile ``run(block, w, job, rounds, x, y, most, angles, speeds, ways, hits, times, outcomes)``: :func:`fly`."""

    def run(
        block: Any, w: Any, job: Any, rounds: int, x: float, y: float, most: int, angles: Any, speeds: Any, ways: Any,
        hits: Any, times: Any, outcomes: Any,
    ) -> None:  # fmt: skip
        found = Found(numbers(ways), numbers(hits), numbers(times), numbers(outcomes))
        fly(numbers(w), job, rounds, x, y, most, angles, speeds, numbers(block), found)

    return compiled(run)


def all_launched(row: Any, lanes: Any, letters: Any, outcomes: Any) -> None:
    """Take all states of lanes (2, n) one step further, as :func:`way_out` does each."""
    c, n, m, job = Launch(row[0], row[1], row[2], row[3]), lanes.shape[1], 0, np.zeros(2, np.int64)
    table, angles, speeds, which = numbers_at(c.block), np.empty(n), np.empty(n), np.empty(n, np.int64)
    for j in range(n):
        letters[j], outcomes[j] = stays(lanes[0, j], lanes[1, j], table), ESCAPED
        if letters[j] < 0:
            angles[m], speeds[m], which[m] = lanes[0, j], lanes[1, j], j
            m += 1
    w = np.empty(room_for(int(table[CIRCLES])))
    ways, hits, times, said = np.empty(n, np.int64), np.empty(n, np.int64), np.empty(n), np.empty(n, np.int64)
    found = Found(numbers(ways), numbers(hits), numbers(times), numbers(said))
    while job[0] < m or job[1] > 0:
        fly(numbers(w), job, ROUNDS, c.x, c.y, int(c.hits), angles[:m], speeds[:m], table, found)
    for k in range(m):
        j, way, outcomes[which[k]] = which[k], ways[k], said[k]
        lost = said[k] & FATAL
        lanes[0, j], lanes[1, j], letters[j] = (NAN, NAN, 0) if lost else (1.0 * way, 0.0, way)
