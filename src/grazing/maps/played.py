"""A step of a table from impact to impact whose flippers are worked by a strategy, as kernels take it.

Behind place, angle and speed a state has two numbers for each gate: how far its flipper has turned from rest, and for
how long its button stays pressed.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np

from grazing.billiard.carried import DVX, DVY, DX, DY, EACH, OF_GATES, OF_TURNED, OF_UNTIL, ahead_of, next_carried
from grazing.billiard.gates import STROKE, UNTIL, WAY, gate_of, gate_under, motion_at, moved, own_copy, pivot_of
from grazing.billiard.hit import slope_of, spot_at, way_at
from grazing.billiard.rows import LENGTH
from grazing.kernel.primitives import behind, numbers, replaced
from grazing.maps.collide import Kernels, arrived, arriving, departing, gone, kernels_of, velocity
from grazing.outcome import AMBIGUOUS, DIVERGED, ESCAPED, FATAL, GRAZE

NAN = float("nan")


@lru_cache(maxsize=32)
def played_by(gates: int) -> Kernels:
    """Return the kernels of tables with so many gates."""
    size = 3 + EACH * gates
    width = OF_GATES + EACH * gates
    zero, nothing, lost = (0.0,) * size, (0.0,) * (size * size), (NAN,) * (size * size)
    nowhere = (NAN,) * size

    def begun(state: Any, table: Any) -> bool:
        """Let the flippers stand as a state says; say whether they can."""
        sane = True
        for g in range(gates):
            gate, turned, held = gate_of(g, table), state[3 + EACH * g], state[4 + EACH * g]
            sane = sane and turned >= 0.0 and turned <= gate[STROKE] and held >= 0.0
            moved(gate, table, 0.0, turned, held)
        return sane

    def departed(state: Any, surface: int, frame: Any, where: Any, table: Any, d: Any) -> None:
        """Write down how a ball that leaves depends on each coordinate of the state."""
        (x, y), under = where, gate_under(surface, table)
        for k in range(size):
            one = behind(d, width * k)
            for i in range(width):
                one[i] = 0.0
            if k < 3:
                one[DX], one[DY], one[DVX], one[DVY] = departing(k, state[1], state[2], frame)
                continue
            one[OF_GATES + k - 3] = 1.0
            if k == 3 + EACH * under:  # it turns with the flipper
                way = gate_of(under, table)[WAY]
                px, py = pivot_of(gate_of(under, table), table)
                vx, vy = velocity(frame[0], frame[1], state[1], state[2])
                one[DX], one[DY], one[DVX], one[DVY] = -way * (y - py), way * (x - px), -way * vy, way * vx

    def slopes_of(found: Any, d: Any, table: Any) -> Any:
        """Return the Jacobian of a step, from what was carried to just before the impact."""
        (surface, owner, t, _flags, _on), before, _after, speeds, force = found
        bend, J = slope_of(owner, speeds[0], table), nothing
        for k in range(size):
            one = behind(d, width * k)
            later = ahead_of(one, surface, t, table)
            shift, turn, gain, late = arriving(
                one[DX], one[DY], one[DVX], one[DVY], later, before, force, speeds, bend
            )  # fmt: skip
            J = replaced(replaced(replaced(J, k, shift), size + k, turn), 2 * size + k, gain)
            for g in range(gates):
                gate, own, row = gate_of(g, table), behind(one, OF_GATES + EACH * g), (3 + EACH * g) * size + k
                _turned, rate, by_turned, by_until = motion_at(gate, t)
                J = replaced(J, row, by_turned * own[OF_TURNED] + by_until * own[OF_UNTIL] + rate * late)
                J = replaced(J, row + size, own[OF_UNTIL] - late if gate[UNTIL] > t else 0.0)
        return J

    def taken(state: Any, table: Any, d: Any, with_tangent: bool) -> Any:
        """Return what :func:`take` does, of a ball that has not left, with room of its own."""
        sane = begun(state, table)
        surface, x, y, frame = spot_at(state[0], 0.0, table)
        if surface < 0 or not sane:
            return nowhere, 0, DIVERGED, lost
        if with_tangent:
            departed(state, surface, frame, (x, y), table, d)
        vx, vy = velocity(frame[0], frame[1], state[1], state[2])
        columns = size if with_tangent else 0
        found = next_carried(x, y, vx, vy, 1.0 * surface, 0.0, table, d, columns, width)
        event, before, after, speeds, _force = found
        (place, angle, speed), t, letter, flags = arrived((event, before, after, speeds), 0.0, table)
        if flags & FATAL:
            return nowhere, 0, flags, lost
        new = replaced(zero, 0, place)
        if flags & ESCAPED:
            return new, letter, flags, nothing
        new = replaced(replaced(new, 1, angle), 2, speed)
        for g in range(gates):
            gate = gate_of(g, table)
            turned, _rate, _by_turned, _by_until = motion_at(gate, t)
            new = replaced(replaced(new, 3 + EACH * g, turned), 4 + EACH * g, max(gate[UNTIL] - t, 0.0))
        J = lost
        if with_tangent and not flags & (GRAZE | AMBIGUOUS) and speeds[0] < 0.0 and speed > 0.0:
            J = slopes_of(found, d, table)
        return new, letter, flags, J

    def take(state: Any, block: Any, with_tangent: bool) -> Any:
        """Return (state, letter, outcome, J) of a step."""
        way = way_at(state[0] - block[LENGTH], block)
        if way >= 0:
            away, way = gone(way, block)
            return replaced(zero, 0, away[0]), way, ESCAPED, nothing
        own, work = own_copy(block), np.empty(size * width)
        found = taken(state, numbers(own), numbers(work), with_tangent)
        own[0] = work[0] = 0.0  # an array lives up to its last use, its numbers do not keep it
        return found

    return kernels_of(take)
