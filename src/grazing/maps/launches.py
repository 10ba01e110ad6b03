"""Launches of a ball on a pinball table: through which drain it leaves, after how many impacts, and when."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import partial
from itertools import islice
from math import pi
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from grazing.billiard.flown import BEFORE, FLAGS, OWNER, TIME, flights_of
from grazing.billiard.objects import two_of
from grazing.billiard.rows import CIRCLES
from grazing.billiard.table import AWAY, Table
from grazing.billiard.workspace import room_for
from grazing.kernel.compile import call, compiled
from grazing.kernel.lanes import abreast_loop
from grazing.maps.collisions import blocks_of, checked_table, fastest, plain_block
from grazing.maps.derivative import Derived
from grazing.maps.hits import Names
from grazing.maps.launch import (
    ROUNDS,
    Launch,
    all_launched,
    heading,
    launched,
    launched_derived,
    launcher,
    plain_launched,
    plain_tangent,
)  # fmt: skip
from grazing.maps.map import Map
from grazing.maps.origin import Origin
from grazing.maps.settle import Settled
from grazing.memory import refuse_too_large
from grazing.outcome import AMBIGUOUS, ESCAPED, InputError, shown
from grazing.parameter import Parameter, real, whole

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]
NAN, INFINITY = float("nan"), float("inf")
#: Impacts of a launch at most, unless said.
HITS = 10_000
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
        return Derived(
            launched_derived,
            None,
            Launch,
            numbers,
            blocks,
            launched,
            compiled(abreast_loop(all_launched, 2), arithmetic),
        )

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
