"""A table as kernels get it: one block of numbers, a head, the objects, then rows of three kinds of surfaces.

Seen from the centre of a ball of radius rho, whatever the ball hits consists of

=======  ======================  ===================================================================================
face     of a segment or drain   both lines at distance D = rho beside it, between its ends
circle   of a disc, of an end    of radius D = R + rho, or rho, hit from outside; all of it
side     of an arc               a part of a circle of radius D = R + rho, hit from outside, or R - rho, from inside
flipper  but for its hub         see :mod:`grazing.billiard.flippers`; the hub is a circle
=======  ======================  ===================================================================================

Ends that two objects share are one circle. A *surface* is a side of a face, 2 i or 2 i + 1 for its left or right, a
circle, a side of an arc, or the left or right side or the tip of a flipper, numbered in this order. *Places* on
surfaces are one length: that of the way of the ball's centre, counterclockwise around one object after the other.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from math import cos, hypot, pi, sin
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from grazing.billiard.flippers import AT, FLIPPER_WIDTH, PIECE_WIDTH, PIECES, piece_row, places_of, row_of
from grazing.billiard.objects import ARC, DISC, DRAIN, FLIPPER, SEGMENT, Thing
from grazing.billiard.players import NOBODY
from grazing.billiard.strategy import Player
from grazing.kernel.elementary import sincos

Floats = NDArray[np.float64]
#: The head of a block: gravity along -y, how many faces, circles, sides of arcs and objects there are, the length of
#: all places on solid objects, how many flippers there are, and of a ball without a radius how many faces may end on
#: something else than the end of a face.
GRAVITY, FACES, CIRCLES, SIDES, THINGS, LENGTH, FLIPPERS, FEET, HEAD = range(9)
#: Of an object: addresses of its law, the slope of that and its parameters; 0 for a solid, 1 for a drain, 2 for a gate,
#: whose law is the strategy.
LAW, SLOPE, ROW, OPEN, THING = range(5)
#: Of a row: a point, D, the object; where its places begin, and how long they are; what follows depends on the kind.
PX, PY, SIZE, OWNER, FROM, LONG = range(6)
#: Of a face: its direction, where places on its right begin. Its point is its first end. Of a gate through which the
#: ball has just gone, whose length is -1 until it has left that line, the length, below 0 if it came from the left.
EX, EY, RIGHT, PASSED = 6, 7, 8, 9
#: Of a circle: the angle at which places begin. Its point is the centre.
ANGLE = 6
#: Of a side of an arc: beside the angle, 1 for outside and -1 for inside; the direction of its middle, and the cosine
#: of half of its span; how thick the arc is to the ball's centre: 0 for a ball without a radius, to which both sides
#: are one circle.
SIGN, MX, MY, COSINE, THICK = 7, 8, 9, 10, 11
WIDTH = 12
#: Ends that differ by this share of their coordinates are one: those of arcs are rounded.
SAME = 2.0**-50
#: So near to a surface an end may be on it: far more than kernels hold for touching.
NEAR = 2.0**-36


def gravity_of(g: float, tilt: float) -> float:
    """Return what pulls a ball down a table, for tilts up to pi/2: g sin(tilt), with the sine of kernels."""
    return g * sincos(tilt)[0]


class Surfaces(NamedTuple):
    """The rows of a table by kind, each of shape (rows, WIDTH), and the length of all places on solid objects.

    Then the rows of flippers, (flippers, FLIPPER_WIDTH), and those of all their pieces, (pieces, PIECE_WIDTH).
    """

    faces: Floats
    circles: Floats
    sides: Floats
    length: float
    flippers: Floats
    pieces: Floats


def surfaces_of(
    things: Sequence[Thing], rho: float, params: Mapping[str, float], player: Player = NOBODY
) -> Surfaces:  # fmt: skip
    """Return the surfaces of objects at parameter values, for a ball of radius rho."""
    made = _Rows(rho)
    for j, one in enumerate(things):
        shape = [params[f"{one.name}.{name}"] for name in one.shape]
        made.owner = float(j)
        add: dict[str, Callable[..., None]]
        if one.kind == FLIPPER:
            made.flipper(one.name, dict(zip(one.shape, shape, strict=True)), params, player)
            continue
        add = {DISC: made.disc, SEGMENT: made.segment, DRAIN: made.drain, ARC: made.arc}
        add[one.kind](*shape)
    faces, circles, sides = (np.array(rows).reshape(-1, WIDTH) for rows in (made.faces, made.circles, made.sides))
    flippers = np.array(made.flippers).reshape(-1, FLIPPER_WIDTH)
    flippers[:, AT] = flippers[:, AT] * PIECE_WIDTH + flippers.size
    return Surfaces(faces, circles, sides, made.place, flippers, np.array(made.pieces).reshape(-1, PIECE_WIDTH))


class _Rows:
    """Rows of surfaces in the making; ``place`` is where places on the next piece begin."""

    def __init__(self, rho: float) -> None:
        self.rho, self.place, self.owner = rho, 0.0, 0.0
        self.faces: list[list[float]] = []
        self.circles: list[list[float]] = []
        self.sides: list[list[float]] = []
        self.ends: list[tuple[float, float]] = []
        self.flippers: list[list[float]] = []
        self.pieces: list[list[float]] = []

    def row(self, x: float, y: float, size: float, length: float, *rest: float) -> list[float]:
        found = [x, y, size, self.owner, self.place, length, *rest]
        self.place += length
        return found + [0.0] * (WIDTH - len(found))

    def circle(self, x: float, y: float, size: float, angle: float, span: float) -> None:
        if size > 0.0:
            self.circles.append(self.row(x, y, size, size * span, angle))

    def end(self, x: float, y: float, angle: float) -> None:
        """Add the half circle around an end, once for all objects that have it."""
        if not any(abs(x - a) + abs(y - b) <= SAME * (abs(x) + abs(y)) for a, b in self.ends):
            self.ends.append((x, y))
            self.circle(x, y, self.rho, angle, pi)

    def disc(self, x: float, y: float, radius: float) -> None:
        self.circle(x, y, radius + self.rho, -pi, 2.0 * pi)

    def segment(self, x1: float, y1: float, x2: float, y2: float) -> None:
        length = hypot(x2 - x1, y2 - y1)
        ex, ey = (x2 - x1) / length, (y2 - y1) / length
        left = np.arctan2(ex, -ey)
        face = self.row(x1, y1, self.rho, length, ex, ey, 0.0)
        self.faces.append(face)
        self.end(x1, y1, left)
        face[RIGHT] = self.place
        self.place += length
        self.end(x2, y2, left - pi)

    def drain(self, x1: float, y1: float, x2: float, y2: float) -> None:
        length, place = hypot(x2 - x1, y2 - y1), self.place
        self.faces.append(self.row(x1, y1, 0.0, length, (x2 - x1) / length, (y2 - y1) / length, 0.0))
        self.place = place  # there are no places on it

    def arc(self, x: float, y: float, radius: float, start: float, stop: float) -> None:
        half, middle = 0.5 * (stop - start), 0.5 * (start + stop)
        whole = half >= pi * (1.0 - 1e-15)
        bounds = cos(middle), sin(middle), -2.0 if whole else cos(half), 2.0 * self.rho
        size = radius + self.rho
        self.sides.append(self.row(x, y, size, 2.0 * half * size, start, 1.0, *bounds))
        if not whole:
            self.end(x + radius * cos(stop), y + radius * sin(stop), stop)
        size = radius - self.rho
        if size > 0.0:
            self.sides.append(self.row(x, y, size, 2.0 * half * size, stop, -1.0, *bounds))
        if not whole:
            self.end(x + radius * cos(start), y + radius * sin(start), start - pi)

    def flipper(self, name: str, shape: Mapping[str, float], params: Mapping[str, float], player: Player) -> None:
        self.circle(shape["x"], shape["y"], shape["hub"] + self.rho, -pi, 2.0 * pi)
        period, pieces = player.motion(name, shape, params)
        row = row_of(shape, self.rho, self.owner, self.place, period)
        row[PIECES], row[AT] = float(len(pieces)), float(len(self.pieces))
        self.flippers.append(row)
        self.pieces += map(piece_row, pieces)
        self.place += places_of(row)


def feet_of(surfaces: Surfaces, solid: NDArray[np.bool_]) -> int:
    """Return how many faces of solids without a size may end on a surface, and not just where a face ends."""
    walls = surfaces.faces[(surfaces.faces[:, SIZE] == 0.0) & solid[surfaces.faces[:, OWNER].astype(int)]]
    long = walls[:, [LONG]]
    found = np.zeros(len(walls), dtype=bool)
    for ends in (walls[:, [PX, PY]], walls[:, [PX, PY]] + long * walls[:, [EX, EY]]):
        for rows in (walls, surfaces.circles, surfaces.sides):
            dx, dy = (ends[:, [k]] - rows[:, k] for k in (PX, PY))
            sizes = abs(ends).sum(axis=1)[:, None] + abs(rows[:, [PX, PY]]).sum(axis=1) + rows[:, LONG] + long
            if rows is walls:
                off, foot = rows[:, EY] * dx - rows[:, EX] * dy, rows[:, EX] * dx + rows[:, EY] * dy
                past = np.minimum(foot, rows[:, LONG] - foot)
                on = (abs(off) <= NEAR * sizes) & (past >= -NEAR * sizes)
                on &= (abs(off) > SAME * sizes) | (abs(past) > SAME * sizes)
            else:
                on = abs(np.hypot(dx, dy) - rows[:, SIZE]) <= NEAR * (sizes + rows[:, SIZE])
            found |= on.any(axis=1)
    return int(found.sum())


def block_of(things: Sequence[Thing], surfaces: Surfaces, gravity: float, gates: int = 0) -> Floats:
    """Return a table as one block of numbers; where its laws lie is still to be written. The last things are gates."""
    head = [gravity, len(surfaces.faces), len(surfaces.circles), len(surfaces.sides), len(things), surfaces.length]
    solid = np.array([one.kind != DRAIN for one in things])
    head += [len(surfaces.flippers), feet_of(surfaces, solid)]
    kinds = [float(one.kind == DRAIN) if i < len(things) - gates else 2.0 for i, one in enumerate(things)]
    objects = [[0.0, 0.0, 0.0, kind] for kind in kinds]
    return np.concatenate([head, np.ravel(objects), *(rows.ravel() for rows in (*surfaces[:3], *surfaces[4:]))])
