"""Launches of a ball on a pinball table: through which drain it leaves, after how many impacts, and when."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import lru_cache, partial
from itertools import islice
from math import cos, pi, sin
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from grazing.billiard.contact import next_impact
from grazing.billiard.flown import FLAGS, OWNER, TIME, flights_of
from grazing.billiard.hit import way_at
from grazing.billiard.objects import two_of
from grazing.billiard.packed import LANES, W, contacts, impact_of, room_for
from grazing.billiard.rows import CIRCLES, THINGS
from grazing.billiard.table import AWAY, Table
from grazing.kernel.compile import call, compiled
from grazing.kernel.primitives import inlined, numbers, numbers_at
from grazing.maps.collisions import blocks_of, checked_table, fastest, plain_block
from grazing.maps.derivative import Derived
from grazing.maps.hits import Names
from grazing.maps.map import Map
from grazing.maps.origin import Origin
from grazing.maps.settle import Settled
from grazing.memory import refuse_too_large
from grazing.outcome import AMBIGUOUS, ESCAPED, FATAL, OK, TOO_MANY_IMPACTS, InputError, shown
from grazing.parameter import Parameter, real, whole

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]
NAN, INFINITY = float("nan"), float("inf")
#: Impacts of a launch at most, unless said.
HITS = 10_000
#: Impacts that may be asked for.
MOST = 1_000_000
#: Impacts of each ball in one call of the kernel, in which nothing stops it.
ROUNDS = 10_000
COORDINATES = {
    one.name: one
    for one in (
        Parameter("angle", r"\varphi", "angle of the launch, from the x axis"),
        Parameter("speed", "v", "speed of the launch", 0.0),
    )
}
#: Parameters of the map behind those of the table.
OWN = {
    one.name: one
    for one in (
        Parameter("launch.x", "x_0", "x of the launch"),
        Parameter("launch.y", "y_0", "y of the launch"),
        Parameter("launch.hits", "n_0", "impacts after which a launch is given up", 1.0, MOST),
    )
}


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
        (surface, owner, length, flags), _before, after, _speeds = next_impact(x, y, vx, vy, left, t, table)
        outcome |= flags
        t += length
        if flags & FATAL:
            return -1, hits, t, outcome
        if flags & ESCAPED:
            return owner if owner >= 0 else int(table[THINGS]), hits, t, outcome
        left, (x, y, vx, vy) = 1.0 * surface, after
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
    way, _hits, _t, outcome = launch(x, y, speed * cos(angle), speed * sin(angle), most, table)
    if outcome & FATAL:
        return (NAN, NAN), 0, outcome
    return (1.0 * way, 0.0), way, outcome


def launched(state: Any, c: Launch) -> Any:
    """Return (state, letter, outcome) of a launch."""
    return way_out(state, c.x, c.y, int(c.hits), numbers_at(c.block))


def launched_derived(state: Any, c: Launch) -> Any:
    """Return a launch with its Jacobian, which is 0: where the ball comes to rest is one of a few places."""
    new, letter, outcome = way_out(state, c.x, c.y, int(c.hits), numbers_at(c.block))
    return new, letter, outcome, (0.0, 0.0, 0.0, 0.0, NAN)


def plain_launched(state: Any, c: Any) -> Any:
    """Return a launch as plain Python takes it: with the block of a table itself, of whatever length."""
    return way_out(state, c.x, c.y, int(c.hits), c.block)


def plain_tangent(state: Any, c: Any) -> Any:
    """Return a launch with its Jacobian as plain Python takes it."""
    new, letter, outcome = way_out(state, c.x, c.y, int(c.hits), c.block)
    return new, letter, outcome, (0.0, 0.0, 0.0, 0.0)


class Found(NamedTuple):
    """Where a kernel writes what :func:`launch` returns, launch by launch."""

    ways: Any
    hits: Any
    times: Any
    outcomes: Any


@inlined
def begun(w: Any, i: int, number: int, x: float, y: float, angle: float, speed: float) -> None:
    """Put a launch into a workspace."""
    w[W.X + i], w[W.Y + i], w[W.VX + i], w[W.VY + i] = x, y, speed * cos(angle), speed * sin(angle)
    w[W.CLOCK + i], w[W.LEFT + i], w[W.NUMBER + i], w[W.HITS + i], w[W.OUTCOME + i] = 0.0, -1.0, 1.0 * number, 0.0, 0.0


@inlined
def ended(w: Any, i: int, most: int, table: Any, found: Found) -> bool:
    """Take a ball over its next impact; write down what becomes of it, if that is the end."""
    (surface, owner, length, flags), _before, after, _speeds = impact_of(w, i, table)
    at, hits, t = int(w[W.NUMBER + i]), int(w[W.HITS + i]), w[W.CLOCK + i] + length
    outcome = int(w[W.OUTCOME + i]) | flags
    w[W.CLOCK + i], w[W.LEFT + i], w[W.HITS + i], w[W.OUTCOME + i] = t, 1.0 * surface, hits + 1.0, 1.0 * outcome
    w[W.X + i], w[W.Y + i], w[W.VX + i], w[W.VY + i] = after
    if not flags & (FATAL | ESCAPED) and hits < most:
        return False
    way = -1
    if flags & ESCAPED and not flags & FATAL:
        way = owner if owner >= 0 else int(table[THINGS])
    if not flags & (FATAL | ESCAPED):
        outcome |= TOO_MANY_IMPACTS
    found.ways[at], found.hits[at], found.times[at], found.outcomes[at] = way, hits, t, outcome
    return True


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
        for i in range(n, (n + 7) // 8 * 8):
            for row in range(W.X, W.SURFACE, LANES):
                w[row + i] = w[row + n - 1]
        contacts(w, (n + 7) // 8 * 8, table)
        for i in range(n - 1, -1, -1):
            if ended(w, i, most, table, found):
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
        found = Found(ways, hits, times, outcomes)
        fly(numbers(w), job, rounds, x, y, most, angles, speeds, numbers(block), found)

    return compiled(run)


def step_all(
    w: Any, lanes: Any, c: Launch, angles: Any, speeds: Any, which: Any, found: Found, letters: Any, outcomes: Any
) -> None:  # fmt: skip
    """Take all states of lanes (2, n) one step further, as :func:`way_out` does each."""
    m, table, job = 0, numbers_at(c.block), np.zeros(2, np.int64)
    for j in range(lanes.shape[1]):
        letters[j], outcomes[j] = stays(lanes[0, j], lanes[1, j], table), ESCAPED
        if letters[j] < 0:
            angles[m], speeds[m], which[m] = lanes[0, j], lanes[1, j], j
            m += 1
    while job[0] < m or job[1] > 0:
        fly(w, job, ROUNDS, c.x, c.y, int(c.hits), angles[:m], speeds[:m], table, found)
    for k in range(m):
        j, way, outcomes[which[k]] = which[k], found.ways[k], found.outcomes[k]
        lost = found.outcomes[k] & FATAL
        lanes[0, j], lanes[1, j], letters[j] = (NAN, NAN, 0) if lost else (1.0 * way, 0.0, way)


@lru_cache(maxsize=2)
def flyer(arithmetic: str) -> Callable[..., None]:
    """Compile the loop around a step of the map of launches, see :func:`grazing.kernel.lanes.loop_of`."""

    def run(rows: Any, lanes: Any, transient: int, points: Any, letters: Any, outcomes: Any) -> None:
        columns, n, keep, last = lanes.shape[0], lanes.shape[2], points.shape[1], outcomes.shape[1] - 1
        angles, speeds, times = np.empty(n), np.empty(n), np.empty(n)
        which, ways, hits = np.empty(n, np.int64), np.empty(n, np.int64), np.empty(n, np.int64)
        ends, letter, outcome = np.empty(n, np.int64), np.empty(n, np.int64), np.empty(n, np.int64)
        for q in range(columns):
            c = Launch(rows[q, 0], rows[q, 1], rows[q, 2], rows[q, 3])
            w = np.empty(room_for(int(numbers_at(c.block)[CIRCLES])))
            for step in range(transient + keep):
                step_all(
                    numbers(w), lanes[q], c, angles, speeds, which, Found(ways, hits, times, ends), letter, outcome
                )
                i = max(step - transient, 0)
                for j in range(n):
                    outcomes[q, i if last > 0 else 0, j] |= outcome[j]
                    if step >= transient:
                        points[q, i, 0, j], points[q, i, 1, j] = lanes[q, 0, j], lanes[q, 1, j]
                        letters[q, i, j] = letter[j]

    return compiled(run, arithmetic)


def exactly(table: Table, x: float, y: float, angle: float, speed: float, most: int) -> tuple[int, int, float, int]:
    """Return what :func:`launch` does, each flight that doubles cannot decide being decided exactly."""
    flights = flights_of(table, (x, y, speed * cos(angle), speed * sin(angle)), 0.0, INFINITY, most + 1)
    last, flags = flights[-1], int(np.bitwise_or.reduce(flights[:, FLAGS].astype(int)))
    owner = int(last[OWNER])
    way = -1 if not flags & ESCAPED else (owner if owner >= 0 else len(table.objects))
    return way, min(len(flights) - 1, most), float(flights[:, TIME].sum()), flags


class OfLaunches(Origin):
    """The origin of the map of launches of a table."""

    exact = True
    together = 8192

    def __init__(self, table: Table) -> None:
        self.table = table

    @property
    def config(self) -> dict[str, str]:
        """What decides a result beside the map's name, coordinates and parameters."""
        return self.table.config

    def replace(self, params: Mapping[str, float]) -> Map:
        """Make the map at other values."""
        own = {name: value for name, value in params.items() if name not in OWN}
        x, y, hits = (params[name] for name in OWN)
        return launch_map(self.table.replace(**own), (x, y), int(hits))

    def derivative(self, rows: Floats, arithmetic: str = "strict") -> Derived:
        """Return the derivative of the step, compiled once for all tables."""
        n = len(self.table.params)
        addresses, blocks = blocks_of(self.table, rows[:, :n], arithmetic)
        numbers = np.hstack([addresses, rows[:, n:]])
        return Derived(launched_derived, None, Launch, numbers, blocks, launched, flyer(arithmetic))

    def describe(self, name: str) -> Parameter | None:
        """Return what is known of a parameter or coordinate."""
        return COORDINATES.get(name) or OWN.get(name) or self.table.describe(name)

    def settle(self, row: list[float], state: tuple[float, ...]) -> Settled | None:
        """Decide a launch in exact arithmetic."""
        n = len(self.table.params)
        table = self.table.at(dict(zip(self.table.params, row, strict=False)))
        way, _hits, _t, flags = exactly(table, row[n], row[n + 1], state[0], state[1], int(row[n + 2]))
        new = (float(way), 0.0) if way >= 0 else (NAN, NAN)
        return Settled(new, max(way, 0), flags, INFINITY, INFINITY)


def launch_map(table: Table, point: Sequence[float], hits: int = HITS) -> Map:
    """Return the map of launches from a point of a pinball table: one step is the whole way of a ball.

    Parameters
    ----------
    table : Table
        Of :func:`grazing.table`.
    point : (x, y)
        Where the ball's centre is launched.
    hits : int
        Impacts after which a ball that has not left is given up, with outcome *too_many_impacts*; a million at most.

    Returns
    -------
    Map
        State (angle, speed) of a launch, the angle from the x axis. The letter of a step is the drain through which
        the ball leaves, or *away*. It then rests there, a state of speed 0 whose angle is the number of that way out:
        so ways out are attractors, and :func:`grazing.basins` draws which launches lead to each. Parameters are those
        of the table, ``launch.x``, ``launch.y`` and ``launch.hits``.

    Raises
    ------
    InputError
        For anything but a table, a launch inside an object, or a value out of range.

    See Also
    --------
    launches : impacts and times beside the ways out.

    Examples
    --------
    >>> import grazing as gz
    >>> drains = [gz.drain("short", (0, -1), (3, -1)), gz.drain("far", (3, -1), (9, -1))]
    >>> L = gz.launch_map(gz.table(drains, tilt=0.5), (0.5, 0.0))
    >>> [L.letters.symbol(L((0.7, speed))[1]) for speed in (0.5, 1.5)]
    ['(short)', '(far)']
    """
    table = checked_table(table)
    values = checked_launch(table, point, hits)
    clash = [name for name in OWN if name in table.params]
    if clash:
        raise InputError("an object is called 'launch', as the parameters of a launch are; give it another name")
    params = {**table.params, **dict(zip(OWN, values, strict=True))}
    fast = fastest(table.params)
    return Map(
        plain_launched,
        params=params,
        coordinates=tuple(COORDINATES),
        box=((0.0, pi), (0.1 * fast, fast)),
        letters=Names((*table.names, AWAY)),
        prepare=partial(_plain, table),
        tangent=plain_tangent,
        name="launch map",
        origin=OfLaunches(table),
    )


def _plain(table: Table, p: Any) -> Launch:
    n = len(table.params)
    return Launch(plain_block(table, p[:n]), *p[n:])  # itself, in place of where it lies


def checked_launch(table: Table, point: Any, hits: Any) -> tuple[float, float, float]:
    """Return where a ball is launched and its most impacts, or raise InputError."""
    pair = two_of(point)
    if len(pair) != 2:
        raise InputError(f"point is {shown(point)}; give (x, y), where the ball is launched")
    x, y = (
        real(value, f"{name} of the launch", "give a finite number") for value, name in zip(pair, "xy", strict=True)
    )
    table.refuse_inside(x, y)
    return x, y, float(whole(hits, "hits", 1, MOST))


def _is_one(values: Any) -> bool:
    """Say whether something is one thing, not several: a text, or an array without a dimension."""
    return isinstance(values, str) or getattr(values, "ndim", 1) == 0


def _listed(values: ArrayLike, name: str, least: float = -INFINITY) -> Floats:
    """Return finite numbers in one list, or raise InputError."""
    try:
        items = values if isinstance(values, Iterable) and not _is_one(values) else [values]
        found = np.array([real(x, name, "") for x in islice(iter(items), MOST + 1)])
    except Exception:  # of whatever object was given
        found = np.empty(0)
    if not 0 < len(found) <= MOST or found.min() < least:
        limit = "" if least == -INFINITY else f" >= {least:g}"
        raise InputError(f"{name} is {shown(values)}; give finite numbers{limit} in one list, a million at most")
    return found


def launches(table: Table, point: Sequence[float], angle: ArrayLike, speed: ArrayLike, hits: int = HITS) -> xr.Dataset:
    """Launch a ball at many angles and speeds: how each leaves the table, after how many impacts, and when.

    Parameters
    ----------
    table : Table
        Of :func:`grazing.table`.
    point : (x, y)
        Where the ball's centre is launched.
    angle : array_like, shape (m,)
        Angles from the x axis, in radians.
    speed : array_like, shape (n,)
        Speeds, >= 0.
    hits : int
        Impacts after which a ball that has not left is given up, with outcome *too_many_impacts*; a million at most.

    Returns
    -------
    xarray.Dataset
        On (angle, speed): ``exit``, the name of the drain, *away*, or nothing for a ball that has not left; ``hits``,
        its impacts; ``time``, when it crossed the drain, infinity for *away*; ``outcome``, bits of
        :class:`grazing.Outcome`.

    Raises
    ------
    InputError
        For anything but a table, a launch inside an object, or a value out of range.

    Examples
    --------
    >>> import grazing as gz
    >>> drains = [gz.drain("short", (0, -1), (3, -1)), gz.drain("far", (3, -1), (9, -1))]
    >>> found = gz.launches(gz.table(drains, tilt=0.5), (0.5, 0.0), 0.7, [0.5, 1.5])
    >>> found.exit.values.tolist(), found.hits.values.tolist(), found.time.values.round(2).tolist()
    ([['short', 'far']], [[0, 0]], [[2.82, 4.89]])
    """
    import xarray as xr

    table = checked_table(table)
    x, y, most = checked_launch(table, point, hits)
    angles, speeds = _listed(angle, "angle"), _listed(speed, "speed", 0.0)
    shape = len(angles), len(speeds)
    refuse_too_large(64 * shape[0] * shape[1], f"launch fewer than {shape[0]} x {shape[1]}")
    ways, count, outcomes = (np.empty(shape, np.int64) for _ in range(3))
    times = np.empty(shape)
    block = table.blocks(table.row())[0]
    each, fast = (grid.ravel() for grid in np.meshgrid(angles, speeds, indexing="ij"))
    flat = [one.reshape(-1) for one in (ways, count, times, outcomes)]
    w, job = np.empty(room_for(int(block[CIRCLES]))), np.array([0, 0])
    while job[0] < len(each) or job[1] > 0:  # some rounds at a time, so that it can be stopped
        call(launcher(), block, w, job, ROUNDS, x, y, int(most), each, fast, *flat)
    for i, j in np.argwhere(outcomes & AMBIGUOUS):
        found = exactly(table, x, y, float(angles[i]), float(speeds[j]), int(most))
        ways[i, j], count[i, j], times[i, j], outcomes[i, j] = found
    names = np.array([*table.names, AWAY, ""])
    dims = "angle", "speed"
    return xr.Dataset(
        {
            "exit": (dims, names[ways], {"long_name": "drain through which the ball left, or away"}),
            "hits": (dims, count, {"long_name": "impacts", "units": "1"}),
            "time": (dims, times, {"long_name": "time at which it left", "units": "1"}),
            "outcome": (dims, outcomes, {"long_name": "what happened, bits of Outcome", "units": "1"}),
        },
        coords={
            "angle": ("angle", angles, COORDINATES["angle"].attributes),
            "speed": ("speed", speeds, COORDINATES["speed"].attributes),
        },
        attrs={
            "title": f"launches from ({x:g}, {y:g}) on {table!r}",
            "launch": [x, y],
            "most_hits": int(most),
            **{f"parameter_{name}": value for name, value in table.params.items()},
        },
    )
