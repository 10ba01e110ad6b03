"""What a table looks like: each object as a line of points, for figures."""

from __future__ import annotations

from math import pi
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from grazing.billiard.flippers import points_of
from grazing.billiard.objects import ARC, DISC, DRAIN, FLIPPER, Thing
from grazing.copies import by_value

#: Points of a full circle.
POINTS = 181


@by_value
class Outline(NamedTuple):
    """An object as a figure shows it: a line, whether it is closed, kicks or is a drain, and where its name stands."""

    name: str
    points: NDArray[np.float64]
    closed: bool
    kicks: bool
    opens: bool
    label: tuple[float, float]


def outline_of(one: Thing, angle: float = 0.0) -> Outline:
    """Return the outline of an object, a flipper at an angle; one kicks whose law makes something of no speed."""
    shape = one.shape
    if one.kind in (DISC, ARC):
        begin, end = shape.get("start", 0.0), shape.get("stop", 2.0 * pi)
        angles = np.linspace(begin, end, POINTS)
        points = np.column_stack([
            shape["x"] + shape["radius"] * np.cos(angles), shape["y"] + shape["radius"] * np.sin(angles),
        ])  # fmt: skip
    elif one.kind == FLIPPER:
        points = points_of(shape, angle, POINTS)
    else:
        points = np.array([[shape["x1"], shape["y1"]], [shape["x2"], shape["y2"]]])
    if one.kind == DISC:
        label = shape["x"], shape["y"]
    else:
        x, y = points[len(points) // 2] if one.kind == ARC else points.mean(axis=0)
        label = float(x), float(y)
    kicks = one.law is not None and (one.law(0.0) > 0.0 or one.law.params.get("V", 0.0) > 0.0)
    return Outline(one.name, points, one.kind in (DISC, FLIPPER), kicks, one.kind == DRAIN, label)
