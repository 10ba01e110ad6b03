"""The stroboscopic map of a pinball table: the ball once per period of its flippers, or at equal times."""

from __future__ import annotations

from collections.abc import Mapping
from math import hypot
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grazing.billiard.flown import (
    BEFORE,
    FIRST,
    FLAGS,
    LAST,
    OWNER,
    PATH,
    TIME,
    block_played,
    flights_of,
    way_along,
)
from grazing.billiard.hit import flown
from grazing.billiard.players import PERIOD
from grazing.billiard.table import AWAY, Table
from grazing.maps.collisions import asked_of, blocks_of, fastest, plain_block, ways_out
from grazing.maps.derivative import Derived
from grazing.maps.hits import Bounces
from grazing.maps.map import Map
from grazing.maps.origin import Origin
from grazing.maps.settle import Settled
from grazing.maps.strobe import STROBED, Strobe, left_by
from grazing.oscillator.model import checked_phase
from grazing.oscillator.parameters import describe_parameter
from grazing.outcome import AMBIGUOUS, ESCAPED, FATAL, GRAZE, OK, STUCK, InputError, shown
from grazing.parameter import Parameter

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
INFINITY = float("inf")
#: The narrowest miss and the slowest impact, which are not measured on a table.
NOTHING_SEEN = INFINITY, INFINITY
COORDINATES = {
    one.name: one
    for one in (
        Parameter("x", "x", "x of the ball's centre"),
        Parameter("y", "y", "y of the ball's centre"),
        Parameter("vx", "v_x", "velocity along x"),
        Parameter("vy", "v_y", "velocity along y"),
    )
}
#: The last parameter, behind those of the table: of one whose flippers are worked periodically, and of one that nothing
#: works.
PHASE, EVERY = "phase", "period"
OWN = {
    PHASE: describe_parameter(PHASE),
    EVERY: Parameter(EVERY, "T", "time from one strobe to the next", 0.0, open="low"),
}
#: Looks at a ball while it crosses a table, where nobody says how many.
LOOKS = 20


def reach_of(table: Table, params: Mapping[str, float]) -> float:
    """Return the largest length of a table at values of its parameters."""
    things = (one.replaced({name: params[f"{one.name}.{name}"] for name in one.params}) for one in table.objects)
    return max(params["rho"], *(abs(x) for one in things for x in one.lengths))


def box_of(table: Table) -> tuple[tuple[float, float], ...]:
    """Return where starts are drawn: between the objects, up to as fast as a fall over the table, or 1."""
    points, fast = np.concatenate([one.points for one in table.outlines()]), fastest(table.params)
    (left, low), (right, high) = points.min(axis=0).tolist(), points.max(axis=0).tolist()
    size = max(right - left, high - low)
    left, right = (left, right) if left < right else (left - 0.5 * size, right + 0.5 * size)
    high = high if low < high else low + size  # all objects lie on one line
    return (left, right), (low, high), (-fast, fast), (-fast, fast)


def usual_period(table: Table) -> float:
    """Return a twentieth of the time in which a ball as fast as the fastest start crosses the table."""
    (left, right), (low, high), (_, fast), _ = box_of(table)
    return hypot(right - left, high - low) / (LOOKS * fast)


class Strobed(Origin):
    """The origin of the stroboscopic map of a table."""

    starts_only = True

    def __init__(self, table: Table) -> None:
        self.table, self.alphabet = table, Bounces((*table.names, AWAY))
        self.own = PHASE if table.period else EVERY
        self.exact = all(one.law is None or one.law.exact_slope for one in table.objects)
        self.asks = asked_of(table)

    @property
    def config(self) -> dict[str, str]:
        """What decides a result beside the map's name, coordinates and parameters."""
        return self.table.config

    def replace(self, params: Mapping[str, float]) -> Map:
        """Make the map at other values."""
        own = dict(params)
        last = {self.own: own.pop(self.own)}
        return map_of_table(self.table.replace(**own), **last)

    def derivative(self, rows: Floats, arithmetic: str = "strict") -> Derived:
        """Return the derivative of the step, compiled once for all tables."""
        addresses, blocks = blocks_of(self.table, rows[:, :-1], arithmetic)
        numbers = np.hstack([addresses, [self.numbers(row) for row in rows.tolist()]])
        return Derived(STROBED.tangent, None, Strobe, numbers, blocks, STROBED.step)

    def numbers(self, row: list[float]) -> tuple[float, float, float, float]:
        """Return what a step needs beside the table, at a row of parameters: the rest of a ``Strobe``."""
        known = dict(zip(self.table.params, row, strict=False))
        phase, period = (row[-1], known[PERIOD.name]) if self.own == PHASE else (0.0, row[-1])
        return phase, period, reach_of(self.table, known), float(self.alphabet.most)

    def describe(self, name: str) -> Parameter | None:
        """Return what is known of a parameter or coordinate."""
        return COORDINATES.get(name) or (OWN[name] if name == self.own else self.table.describe(name))

    def boxes(self, rows: Floats) -> Floats:
        """Return where starts are drawn at each row of parameters."""
        names = list(self.table.params)
        return np.array([box_of(self.table.at(dict(zip(names, row, strict=False)))) for row in rows.tolist()])

    def clock(self, rows: Floats, first: Floats, last: Floats, letters: Ints, steps: int) -> Floats:
        """Return the time that orbits took for so many steps, each of a period."""
        periods = rows[:, list(self.table.params).index(PERIOD.name)] if self.own == PHASE else rows[:, -1]
        return np.broadcast_to(steps * periods[:, None], letters.shape)

    def left(self, letters: Ints) -> NDArray[np.bool_]:
        """Return which steps end with a ball that has left: the last object of their letters is a way out."""
        return (letters > 0) & np.isin(letters % (len(self.alphabet.names) + 1) - 1, ways_out(self.table))

    def settle(self, row: list[float], state: tuple[float, ...]) -> Settled | None:
        """Decide a step in exact arithmetic."""
        values, (phase, period, *_) = dict(zip(self.table.params, row, strict=False)), self.numbers(row)
        return settled(self.table.at(values), self.alphabet, phase, period, state)


def settled(table: Table, alphabet: Bounces, phase: float, period: float, state: tuple[float, ...]) -> Settled | None:
    """Decide a step in exact arithmetic, from a state on the table."""
    end = phase + period
    flights = flights_of(table, state, phase, end)
    last, begin = flights[-1], phase + float(flights[:-1, TIME].sum())
    within, said, owner = begin + last[TIME] <= end, int(last[FLAGS]), int(last[OWNER])
    gone, struck = bool(said & ESCAPED) and (within or owner < 0), ~np.isnan(flights[:, BEFORE])
    struck[-1] &= within
    flags = int(np.bitwise_or.reduce(flights[:-1, FLAGS].astype(int)))
    if flags & FATAL or (within and not gone):  # its flags say why none follows
        return None
    hit = [*map(int, flights[struck, OWNER])]
    if gone:
        hit.append(owner if owner >= 0 else len(table.objects))
        return Settled(
            left_by(hit[-1], reach_of(table, table.params)), alphabet.letter(hit), flags | said, *NOTHING_SEEN
        )
    flags |= said & (GRAZE | AMBIGUOUS) | (STUCK if last[PATH] >= 0.0 else OK)
    x, y, vx, vy = last[FIRST:LAST].tolist()
    if last[PATH] < 0.0:
        new = flown(x, y, vx, vy, table.gravity, end - begin)
    else:
        new = way_along(block_played(table, {}), last, begin, np.array([end - begin]))[0].tolist()
    return Settled(tuple(new), alphabet.letter(hit), flags, *NOTHING_SEEN)


def map_of_table(table: Table, phase: float = 0.0, period: float | None = None) -> Map:
    """Return the stroboscopic map of a table; :func:`grazing.stroboscopic_map` calls this."""
    if table.period == INFINITY:
        raise InputError(
            "the flippers of the table are worked by a recording or a strategy, which have no period: a stroboscopic "
            "map needs player=gz.flips(period, hold), flips = {...} in a file, or no player; a map of a table with a "
            "strategy is gz.collision_map"
        )
    origin = Strobed(table)
    if table.period:
        if period is not None:
            raise InputError(f"period is {shown(period)}; this table has one, {PERIOD.name} = {table.period:g}")
        own = checked_phase(table, phase)
    else:
        if phase != 0.0:
            raise InputError(f"phase is {shown(phase)}; nothing on this table moves, so that it has none: leave it out")
        own = OWN[EVERY].check(usual_period(table) if period is None else period)

    def prepare(values: Any) -> Strobe:
        """Return what a step in plain Python needs."""
        row = list(values)
        return Strobe(plain_block(table, row[:-1]), *origin.numbers(row))

    return Map(
        STROBED.plain,
        params={**table.params, origin.own: own},
        coordinates=tuple(COORDINATES),
        box=box_of(table),
        letters=origin.alphabet,
        prepare=prepare,
        tangent=STROBED.plain_tangent,
        name="stroboscopic map of a table",
        origin=origin,
    )
