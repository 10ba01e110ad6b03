"""Launches at which a ball grazes an object of a pinball table, as curves over angle and speed."""

from __future__ import annotations

from collections.abc import Sequence
from math import pi
from typing import TYPE_CHECKING, Any

import numpy as np

from grazing.billiard.objects import two_of
from grazing.billiard.strategy import Strategy
from grazing.billiard.table import AWAY, Table
from grazing.maps.borders import ANGLE, CORNER, GRAZE, SPEED, Borders, Box, Change
from grazing.maps.collisions import checked_table
from grazing.maps.hits import Names
from grazing.maps.itineraries import Itineraries
from grazing.maps.launches import COORDINATES, checked_launch
from grazing.maps.linked import DEPTH, Curve, curves_of
from grazing.memory import refuse_too_large
from grazing.outcome import InputError, listed, shown
from grazing.parameter import in_order, real, refuse_ends, whole

if TYPE_CHECKING:
    import xarray as xr

#: Impacts before a graze, and cells along a side, at most; cells unless said.
MOST_ORDER, MOST_CELLS, CELLS = 100, 2_000, (64, 64)
INFINITY = float("inf")
#: Doubles along a cell at least.
FINEST = 2.0**8
#: Bytes that a cell takes.
CELL = 2_000


def grazes(
    table: Table, point: Sequence[float] | None = None, angle: Sequence[float] | None = None,
    speed: Sequence[float] | None = None, order: int = 1, objects: Sequence[str] | str | None = None, *,
    cells: Sequence[int] = CELLS,
) -> xr.Dataset:  # fmt: skip
    """Find the launches at which a ball grazes an object of a table, as curves over angle and speed.

    Parameters
    ----------
    table : Table
        Of :func:`grazing.table`; not one that a strategy plays.
    point : (x, y), optional
        Where the ball's centre is launched; in the table's plunger if not given.
    angle : (low, high), optional
        Angles from the x axis, in radians; a right angle to either side of the plunger's if not given.
    speed : (low, high), optional
        Speeds, >= 0; those of the plunger if not given.
    order : int
        Impacts before the graze, at most: 0 for those of the first flight, n for their preimages under the map from
        impact to impact, up to the n-th.
    objects : str or sequence of str, optional
        Names of those that are grazed; all if not given.
    cells : (int, int)
        Cells along angle and speed, see Notes.

    Returns
    -------
    xarray.Dataset
        ``angle`` and ``speed`` (point): the curves, one after the other with a row of NaN between two, the launches
        that hit on their left. ``angle_width`` and ``speed_width`` (point): the bracket around that point, one of
        them 0, within which the ball hits on one side and passes on the other. ``row`` (point): the row of the
        table on dimension "curve", with ``object``, what is grazed; ``word``, what is hit before; ``order``, the length
        of that; ``kick``, the velocity along the normal with which the object's law sends a ball away that grazes it:
        where that is not 0 the map jumps, else it has a square root; ``closed``. Attribute ``corners`` counts the
        changes on the sides of cells that are no grazes: the ball comes to something else where an end is sharp, as
        that of a drain is, or where it would hit two objects at once.

    Raises
    ------
    InputError
        For anything but such a table, a launch inside an object, or a value out of range.

    Notes
    -----
    Launches on the sides of a grid of cells are compared by the surfaces that they meet, and each change is bisected
    to 2**-44 of the box. It is a graze if the velocity along the normal falls to 0 as the square root of the distance
    from it. Cells in which it is not clear how changes are linked are halved, up to 16 times along each side. A curve
    that runs inside a cell, or two between neighbouring points of the grid, may be missed: finer cells show it.

    Examples
    --------
    A ball of radius 0.1 from the origin grazes a disc of radius 0.4 at (1, 0) at the angle asin(1/2).

    >>> import grazing as gz
    >>> table = gz.table([gz.disc("A", (1, 0), 0.4, gz.active(r=0.8, V=0.3))], rho=0.1)
    >>> found = gz.grazes(table, (0, 0), angle=(0.1, 1.5), speed=(1, 2), order=0)
    >>> found.object.values.tolist(), found.kick.values.tolist(), round(float(found.angle[0]), 9)
    (['A'], [0.3], 0.523598776)
    """
    table = checked_table(table)
    if isinstance(table.player, Strategy):
        raise InputError(
            "a strategy plays the table, and grazes are found for none; play a game with gz.trajectory, and put the "
            "recording in its place, gz.presses(**game.attrs['presses'])"
        )
    x, y, _hits = checked_launch(table, point, 1)
    box = _checked_box(table, angle, speed)
    order = whole(order, "order", 0, MOST_ORDER)
    grid = two_of(cells)
    if len(grid) != 2:
        raise InputError(f"cells are {shown(cells)}; give how many there are along angle and speed, such as (64, 64)")
    m, n = (whole(k, "cells", 1, MOST_CELLS) for k in grid)
    refuse_too_large((CELL + 16 * order) * m * n, f"give fewer cells than {m} x {n}")
    for name, (low, high), count in zip(COORDINATES, box, (m, n), strict=True):
        if high - low < FINEST * count * np.spacing(max(abs(low), abs(high))):
            said = f"{name} is ({low!r}, {high!r})"
            raise InputError(
                f"{said}; there are too few doubles between for {count} cells, give a wider range or fewer"
            )
    wanted = None if objects is None else _numbers(table, objects)

    def asked(one: Change) -> bool:
        return one.kind == GRAZE and (wanted is None or not wanted.isdisjoint(one.objects))

    size = 2**DEPTH
    borders = Borders(Itineraries(table, x, y, order + 1), box, (m * size, n * size))
    curves = curves_of(borders, (m, n), asked)
    attrs = {
        "title": f"grazes of launches from ({x:g}, {y:g}) on {table!r}",
        "launch": [x, y],
        "most_order": order,
        "box": [end for side in box for end in side],
        "cells": [m, n],
        "corners": sum(one.kind == CORNER for one in borders.all()),
        **{f"parameter_{name}": value for name, value in table.params.items()},
    }
    return _dataset(table, curves, attrs)


def _checked_box(table: Table, angle: Any, speed: Any) -> Box:
    """Return the box of launches, or raise InputError."""
    shot, aim = table.plunger, 0.5 * pi
    if shot is None and (angle is None or speed is None):
        raise InputError("the table has no plunger; give angle=(low, high) and speed=(low, high) of the launches")
    if shot is not None:
        angle = (shot.angle - aim, shot.angle + aim) if angle is None else angle
        speed = (shot.slow, shot.fast) if speed is None else speed
    return _ends(angle, "angle", -INFINITY), _ends(speed, "speed", 0.0)


def _ends(value: Any, name: str, least: float) -> tuple[float, float]:
    """Return the ends of a range, or raise InputError."""
    limit = "" if least == -INFINITY else f", both >= {least:g}"
    wanted = f"give {name}=(low, high), finite numbers{limit}"
    pair = two_of(value)
    if len(pair) != 2:
        raise InputError(f"{name} is {shown(value)}; {wanted}")
    low, high = (real(end, name, wanted) for end in pair)
    refuse_ends(low, high, f"{name} is ({low:g}, {high:g})")
    if low < least:
        raise InputError(f"{name} is ({low:g}, {high:g}); {wanted}")
    return low, high


def _numbers(table: Table, objects: Any) -> set[int]:
    """Return the numbers of objects from their names, or raise InputError."""
    try:
        names = [objects] if isinstance(objects, str) else list(in_order(objects))
    except Exception:  # of whatever object was given
        names = [objects]
    for name in names:
        if not isinstance(name, str) or name not in table.names:
            raise InputError(f"no object is called {shown(name)}; allowed are {listed(table.names)}")
    return {table.names.index(name) for name in names}


def _dataset(table: Table, curves: Sequence[Curve], attrs: dict[str, Any]) -> xr.Dataset:
    """Return curves as a labelled table, those of a low order first."""
    from grazing.late import xarray as xr

    alphabet = Names((*table.names, AWAY))
    told = sorted(curves, key=lambda one: (len(one.changes[0].word), one.changes[0].word, one.changes[0].objects))
    rows: list[tuple[float, ...]] = []
    number: list[int] = []
    for k, one in enumerate(told):
        rows += [(*change.place, *_widths(change)) for change in one.changes] + [(np.nan,) * 4] * (k < len(told) - 1)
        number += [k] * (len(rows) - len(number))
    columns = np.array(rows, np.float64).reshape(-1, 4).T
    firsts = [one.changes[0] for one in told]
    laws = [table.objects[one.objects[0]].law for one in firsts]

    def column(values: Any, dtype: Any, long_name: str, **more: str) -> Any:
        return "curve", np.array(values, dtype), {"long_name": long_name, **more}

    width = "width of the bracket in the {} of the launch"
    return xr.Dataset(
        {
            **{
                name: ("point", columns[axis], COORDINATES[name].attributes)
                for axis, name in ((ANGLE, "angle"), (SPEED, "speed"))
            },
            "angle_width": ("point", columns[2], {"long_name": width.format("angle"), "units": "1"}),
            "speed_width": ("point", columns[3], {"long_name": width.format("speed"), "units": "1"}),
            "row": ("point", np.array(number, np.int64), {"long_name": "row of the table of curves", "units": "1"}),
            "object": column([table.names[one.objects[0]] for one in firsts], object,
                             "object that is grazed"),
            "word": column(["".join(map(alphabet.symbol, one.word)) for one in firsts], object,
                           "objects that are hit before"),
            "order": column([len(one.word) for one in firsts], np.int64, "impacts before", units="1"),
            "kick": column([np.nan if law is None else law(0.0) for law in laws], np.float64,
                           "velocity along the normal after a graze", units="1"),
            "closed": column([one.closed for one in told], bool, "whether it ends where it begins"),
        },
        attrs=attrs,
    )  # fmt: skip


def _widths(change: Change) -> tuple[float, float]:
    """Return the widths of a bracket along angle and speed."""
    width = change.high - change.low
    return (width, 0.0) if change.axis == ANGLE else (0.0, width)
