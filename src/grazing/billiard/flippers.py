"""What a flipper is in numbers: a row for kernels, how far a point is from it, and whether something is in its way.

In the frame that turns with it, with the pivot at 0 and the tip at (L, 0), the sides of a flipper are the outer
tangents of the circles around hub and tip. With sin b = (R_h - R_t)/L their normals are (sin b, +-cos b), their
distance from the pivot is R_h, and they are L cos b long.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from math import acos, cos, hypot, nextafter, pi, sin, sqrt

import numpy as np
from numpy.typing import NDArray

from grazing.billiard.players import Piece
from grazing.kernel.elementary import sincos

Floats = NDArray[np.float64]
#: Of a row: pivot, R_h + rho, the object; where places on its left side begin, and how long that is.
PX, PY, SIZE, OWNER, FROM, LONG = range(6)
#: R_t + rho, L, where places on the right side and at the tip begin, sin b and cos b; the radius of a circle around the
#: pivot that the ball's centre must be in; the period of the motion, 0 for none, how many pieces it has, and where the
#: first one lies, counted from the first row.
TIP, ARM, RIGHT, ROUND, SINE, COSINE, REACH, PERIOD, PIECES, AT, FLIPPER_WIDTH = range(6, 17)
#: Of a piece: when it begins, the direction of the flipper there, and the angular velocity.
BEGIN, CX, CY, OMEGA, PIECE_WIDTH = range(5)
#: Surfaces of a flipper: left and right as seen from the pivot, and the tip. Its hub is a circle like any other.
LEFT_SIDE, RIGHT_SIDE, AT_TIP, KINDS = range(4)
#: Angles beyond which those sines are not meant.
FAR = 1e5
#: Steps of a search for the least distance from a line, each of which leaves 0.618 of it.
SHRUNK = 80


def row_of(shape: Mapping[str, float], rho: float, owner: float, place: float, period: float) -> list[float]:
    """Return the row of a flipper for a ball of radius rho; ``place`` is where places on it begin."""
    length, hub, tip = shape["length"], shape["hub"], shape["tip"]
    sine = (hub - tip) / length
    cosine = sqrt((1.0 - sine) * (1.0 + sine))
    side, around = length * cosine, 2.0 * acos(sine) * (tip + rho)
    reach = (max(length + tip, hub) + rho) * (1.0 + 2.0**-40)
    return [
        shape["x"], shape["y"], hub + rho, owner, place + side + around, side,
        tip + rho, length, place, place + side, sine, cosine, reach, period, 0.0, 0.0,
    ]  # fmt: skip


def places_of(row: Sequence[float]) -> float:
    """Return the length of all places on the sides and the tip of a flipper."""
    return row[FROM] + row[LONG] - row[RIGHT]


def piece_row(one: Piece) -> list[float]:
    """Return a piece as kernels get it."""
    # the sines of kernels, so that a table in a browser has the same bits
    s, c = sincos(one.angle) if abs(one.angle) < FAR else (sin(one.angle), cos(one.angle))
    return [one.begin, c, s, one.omega]


def distance_from(shape: Mapping[str, float], x: float, y: float, angle: float) -> float:
    """Return how far a point is from a flipper at an angle, negative inside it."""
    dx, dy, length = x - shape["x"], y - shape["y"], shape["length"]
    hub, tip, c, s = shape["hub"], shape["tip"], cos(angle), sin(angle)
    along, beside = dx * c + dy * s, abs(dy * c - dx * s)
    sine = (hub - tip) / length
    cosine = sqrt((1.0 - sine) * (1.0 + sine))
    foot = along * cosine - beside * sine
    if foot <= 0.0:
        return hypot(along, beside) - hub
    if foot >= length * cosine:
        return hypot(along - length, beside) - tip
    return along * sine + beside * cosine - hub


def points_of(shape: Mapping[str, float], angle: float, points: int) -> Floats:
    """Return the outline of a flipper at an angle, counterclockwise, closed."""
    lean = acos((shape["hub"] - shape["tip"]) / shape["length"])
    n = points // 2
    back, front = np.linspace(lean, 2.0 * pi - lean, n), np.linspace(-lean, lean, n)
    found = []
    for turn, radius, along in ((back, shape["hub"], 0.0), (front, shape["tip"], shape["length"])):
        x, y = shape["x"] + along * cos(angle), shape["y"] + along * sin(angle)
        found.append(np.column_stack([x + radius * np.cos(turn + angle), y + radius * np.sin(turn + angle)]))
    return np.concatenate([*found, found[0][:1]])


def least_on_line(of: Callable[[float, float], float], ends: Sequence[float]) -> float:
    """Return the least value on a line (x1, y1, x2, y2) of a convex function of a point, by golden sections."""
    x1, y1, x2, y2 = ends

    def at(share: float) -> float:
        return of(x1 + share * (x2 - x1), y1 + share * (y2 - y1))

    low, high, ratio = 0.0, 1.0, 0.5 * (sqrt(5.0) - 1.0)
    a, b = high - ratio, low + ratio
    at_a, at_b = at(a), at(b)
    for _ in range(SHRUNK):
        if at_a < at_b:
            high, b, at_b = b, a, at_a
            a = high - ratio * (high - low)
            at_a = at(a)
        else:
            low, a, at_a = a, b, at_b
            b = low + ratio * (high - low)
            at_b = at(b)
    return min(at_a, at_b, at(0.0), at(1.0))


def tightest(shape: Mapping[str, float], room: Callable[[float], float], slack: float) -> float:
    """Return the least room that a flipper has in its sweep, or less than -slack if there is less.

    ``room(angle)`` is the distance to something; it changes by no more than the length of the way of the tip's end.
    """
    low, high = sorted((shape["rest"], shape["raised"]))
    far = shape["length"] + shape["tip"] + shape["hub"]
    least, angle = min(room(low), room(high)), low
    while angle < high and least >= -slack:
        now = room(angle)
        least = min(least, now)
        angle = max(angle + max(now, 0.0) / far, angle + (high - low) / 500.0, nextafter(angle, high))
    return least
