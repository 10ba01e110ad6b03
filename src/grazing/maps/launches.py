"""Launches of a ball on a pinball table: through which drain it leaves, after how many impacts, and when."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import partial
from itertools import islice
from math import pi
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from grazing.billiard.flown import BEFORE, FLAGS, OWNER, TIME, flights_of
from grazing.billiard.objects import two_of
from grazing.billiard.plunger import PLACE
from grazing.billiard.rows import CIRCLES
from grazing.billiard.strategy import Strategy
from grazing.billiard.table import AWAY, Table
from grazing.billiard.workspace import room_for
from grazing.kernel.compile import call, compiled
from grazing.kernel.lanes import abreast_loop, aligned
from grazing.maps.collisions import asked_of, blocks_of, checked_table, fastest, plain_block
from grazing.maps.derivative import Derived
from grazing.maps.hits import Names
from grazing.maps.launch import (
    FREE,
    ROUNDS,
    WATCHED,
    Launch,
    all_launched,
    heading,
    launcher,
    watcher,
)  # fmt: skip
from grazing.maps.map import Map
from grazing.maps.origin import Origin
from grazing.maps.settle import Settled
from grazing.memory import refuse_too_large
from grazing.outcome import AMBIGUOUS, ESCAPED, InputError, UserCodeError, shown
from grazing.parameter import Parameter, in_order, real, whole
from grazing.pool import run_tasks

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
NAN, INFINITY = float("nan"), float("inf")
#: Impacts of a launch at most, unless said.
HITS = 10_000
#: Speeds of the plunger that are tried, unless said.
SPEEDS = 200
#: Launches of one task.
TOGETHER = 8192
#: Launches of one call at which a strategy looks.
SEEN = 256
#: Impacts that may be asked for.
MOST = 1_000_000
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


*POINT, HITS_OF = OWN


def exactly(table: Table, x: float, y: float, angle: float, speed: float, most: int) -> tuple[int, int, float, int]:
    """Return what :func:`launch` does, each flight that doubles cannot decide being decided exactly."""
    s, c = heading(angle)
    flights = flights_of(table, (x, y, speed * c, speed * s), 0.0, INFINITY, most + 1)
    last, flags = flights[-1], int(np.bitwise_or.reduce(flights[:, FLAGS].astype(int)))
    owner = int(last[OWNER])
    way = -1 if not flags & ESCAPED else (owner if owner >= 0 else len(table.objects))
    hits = int((~np.isnan(flights[:, BEFORE])).sum())
    return way, min(hits, most), float(flights[:, TIME].sum()), flags


class OfLaunches(Origin):
    """The origin of the map of launches of a table."""

    exact = True
    together = TOGETHER
    starts_only = True

    def __init__(self, table: Table, own: Sequence[str]) -> None:
        self.table, self.asks = table, asked_of(table)
        names = [*table.params, *own]
        #: Where the numbers of a launch stand in a row of parameters.
        self.where = [names.index(name) for name in (*(PLACE if len(own) == 1 else POINT), HITS_OF)]

    @property
    def config(self) -> dict[str, str]:
        """What decides a result beside the map's name, coordinates and parameters."""
        return self.table.config

    def replace(self, params: Mapping[str, float]) -> Map:
        """Make the map at other values."""
        own = {name: value for name, value in params.items() if name in self.table.params}
        x, y, hits = (list(params.values())[i] for i in self.where)
        return launch_map(self.table.replace(**own), (x, y) if POINT[0] in params else None, int(hits))

    def derivative(self, rows: Floats, arithmetic: str = "strict") -> Derived:
        """Return the derivative of the step, compiled once for all tables."""
        n = len(self.table.params)
        addresses, blocks = blocks_of(self.table, rows[:, :n], arithmetic)
        numbers = np.hstack([addresses, rows[:, self.where]])
        if self.table.player.drains:
            return Derived(WATCHED.tangent, None, Launch, numbers, blocks, WATCHED.step)
        loop = compiled(abreast_loop(all_launched, 2), arithmetic)
        return Derived(FREE.tangent, None, Launch, numbers, blocks, FREE.step, loop)

    def describe(self, name: str) -> Parameter | None:
        """Return what is known of a parameter or coordinate."""
        return COORDINATES.get(name) or OWN.get(name) or self.table.describe(name)

    def left(self, letters: Ints) -> NDArray[np.bool_]:
        """Return that each step ends with a ball that has left."""
        return np.ones(letters.shape, np.bool_)

    def settle(self, row: list[float], state: tuple[float, ...]) -> Settled | None:
        """Decide a launch in exact arithmetic."""
        table = self.table.at(dict(zip(self.table.params, row, strict=False)))
        x, y, hits = (row[i] for i in self.where)
        way, _hits, _t, flags = exactly(table, x, y, state[0], state[1], int(hits))
        new = (float(way), 0.0) if way >= 0 else (NAN, NAN)
        return Settled(new, max(way, 0), flags, INFINITY, INFINITY)


def launch_map(table: Table, point: Sequence[float] | None = None, hits: int = HITS) -> Map:
    """Return the map of launches from a point of a pinball table: one step is the whole way of a ball.

    Parameters
    ----------
    table : Table
        Of :func:`grazing.table`.
    point : (x, y), optional
        Where the ball's centre is launched; in the table's plunger if not given.
    hits : int
        Impacts after which a ball that has not left is given up, with outcome *too_many_impacts*; a million at most.

    Returns
    -------
    Map
        State (angle, speed) of a launch, the angle from the x axis. The letter of a step is the drain through which
        the ball leaves, or *away*. It then rests there, a state of speed 0 whose angle is the number of that way out:
        so ways out are attractors, and :func:`grazing.basins` draws which launches lead to each. Parameters are those
        of the table, ``launch.x`` and ``launch.y`` if a point is given, and ``launch.hits``.

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
    values = dict(zip(OWN, checked_launch(table, point, hits), strict=True))
    if isinstance(table.player, Strategy):
        table.player.tried(table.params)
    if any(name in table.params for name in OWN):
        raise InputError("an object is called 'launch', as the parameters of a launch are; give it another name")
    if point is None:  # its place is a parameter of the table
        values = {HITS_OF: values[HITS_OF]}
    fast, aim, shot = fastest(table.params), 0.5 * pi, table.plunger
    origin = OfLaunches(table, tuple(values))
    kernels = WATCHED if table.player.drains else FREE
    return Map(
        kernels.plain,
        params={**table.params, **values},
        coordinates=tuple(COORDINATES),
        box=((shot.angle - aim, shot.angle + aim), (shot.slow, shot.fast)) if point is None and shot
        else ((0.0, pi), (0.1 * fast, fast)),
        letters=Names((*table.names, AWAY)),
        prepare=partial(_plain, table, origin.where),
        tangent=kernels.plain_tangent,
        name="launch map",
        origin=origin,
    )  # fmt: skip


def _plain(table: Table, where: Sequence[int], p: Any) -> Launch:
    block = plain_block(table, p[: len(table.params)])
    return Launch(block, *(p[i] for i in where))  # itself, in place of where it lies


def checked_launch(table: Table, point: Any, hits: Any) -> tuple[float, float, float]:
    """Return where a ball is launched and its most impacts, or raise InputError."""
    if point is None and table.plunger is None:
        raise InputError("the table has no plunger; give the point (x, y) where the ball is launched")
    pair = two_of((table.plunger.x, table.plunger.y) if point is None and table.plunger else point)
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
        found = np.array([real(x, name, "") for x in islice(iter(in_order(items)), MOST + 1)])
    except Exception:  # of whatever object was given
        found = np.empty(0)
    if not 0 < len(found) <= MOST or found.min() < least:
        limit = "" if least == -INFINITY else f" >= {least:g}"
        raise InputError(f"{name} is {shown(values)}; give finite numbers{limit} in one list, a million at most")
    return found


def _flown(block: Floats, launch: tuple[float, float, int], part: Sequence[Any]) -> Iterator[None]:
    """Fly launches, angles and speeds and then what is found of each, side by side."""
    w, job = aligned(room_for(int(block[CIRCLES]))), np.array([0, 0])
    while job[0] < len(part[0]) or job[1] > 0:  # some rounds at a time, so that it can be stopped
        call(launcher(), block, w, job, ROUNDS, *launch, *part)
        yield


def _watched(block: Floats, launch: tuple[float, float, int], part: Sequence[Any]) -> Iterator[None]:
    """Fly launches at which a strategy looks, one after the other."""
    for first in range(0, len(part[0]), SEEN):  # some at a time, so that it can be stopped
        call(watcher(), block, *launch, *(one[first : first + SEEN] for one in part))
        yield


def _plays(table: Table, launch: tuple[float, float, int], parts: Sequence[Any], threads: int | None) -> bool:
    """Fly launches at which a strategy looks, and say so; False for one that only Python follows, or that fails."""
    try:
        block = table.blocks(table.row(), asks=True)[0]
        run_tasks([partial(_watched, block, launch, part) for part in parts], threads)
    except UserCodeError:
        return False
    return True


def launches(
    table: Table, point: Sequence[float] | None = None, angle: ArrayLike | None = None, speed: ArrayLike | None = None,
    hits: int = HITS, *, threads: int | None = None,
) -> xr.Dataset:  # fmt: skip
    """Launch a ball at many angles and speeds: how each leaves the table, after how many impacts, and when.

    Parameters
    ----------
    table : Table
        Of :func:`grazing.table`.
    point : (x, y), optional
        Where the ball's centre is launched; in the table's plunger if not given.
    angle : array_like, shape (m,), optional
        Angles from the x axis, in radians; that of the plunger if not given.
    speed : array_like, shape (n,), optional
        Speeds, >= 0; 200 of the plunger's if not given.
    hits : int
        Impacts after which a ball that has not left is given up, with outcome *too_many_impacts*; a million at most.
    threads : int, optional
        One per processor if not given. The result does not depend on it.

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
    from grazing.late import xarray as xr

    table = checked_table(table)
    x, y, most = checked_launch(table, point, hits)
    if angle is None or speed is None:
        if table.plunger is None:
            raise InputError("the table has no plunger; give the angles and the speeds of the launches")
        angle = table.plunger.angle if angle is None else angle
        speed = np.linspace(table.plunger.slow, table.plunger.fast, SPEEDS) if speed is None else speed
    angles, speeds = _listed(angle, "angle"), _listed(speed, "speed", 0.0)
    shape = len(angles), len(speeds)
    refuse_too_large(64 * shape[0] * shape[1], f"launch fewer than {shape[0]} x {shape[1]}")
    ways, count, outcomes = (np.empty(shape, np.int64) for _ in range(3))
    times = np.empty(shape)
    launch = x, y, int(most)
    each = [grid.ravel() for grid in np.meshgrid(angles, speeds, indexing="ij")]
    flat = [*each, *(one.reshape(-1) for one in (ways, count, times, outcomes))]
    parts = [[one[first : first + TOGETHER] for one in flat] for first in range(0, len(each[0]), TOGETHER)]
    alone = False  # a function of the user's that is asked in Python says what is wrong for which ball
    if isinstance(table.player, Strategy):
        table.player.tried(table.params)
        alone = not _plays(table, launch, parts, threads)
    else:
        block = table.blocks(table.row())[0]
        run_tasks([partial(_flown, block, launch, part) for part in parts], threads)
    for i, j in np.ndindex(shape) if alone else np.argwhere(outcomes & AMBIGUOUS):
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
