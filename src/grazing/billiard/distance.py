"""How far objects are from a point and from each other, as long as nothing moves."""

from __future__ import annotations

from collections.abc import Mapping
from math import atan2, cos, hypot, pi, sin, sqrt

from grazing.billiard.flippers import distance_from, least_on_line
from grazing.billiard.objects import ARC, DISC, FLIPPER, SEGMENT, Thing
from grazing.billiard.outline import outline_of

#: Objects that touch may overlap by so much of their size: rounding.
SLACK = 1e-12


def distance(one: Thing, x: float, y: float, angle: float = 0.0) -> float:
    """Return how far a point is from an object, negative inside a disc or a flipper; that is at an angle."""
    shape = one.shape
    if one.kind == FLIPPER:
        return distance_from(shape, x, y, angle)
    if one.kind == DISC:
        return hypot(x - shape["x"], y - shape["y"]) - shape["radius"]
    if one.kind == ARC:
        dx, dy, radius = x - shape["x"], y - shape["y"], shape["radius"]
        if (atan2(dy, dx) - shape["start"]) % (2.0 * pi) <= shape["stop"] - shape["start"]:
            return abs(hypot(dx, dy) - radius)
        return min(hypot(dx - radius * cos(a), dy - radius * sin(a)) for a in (shape["start"], shape["stop"]))
    dx, dy, length = x - shape["x1"], y - shape["y1"], hypot(shape["x2"] - shape["x1"], shape["y2"] - shape["y1"])
    ex, ey = (shape["x2"] - shape["x1"]) / length, (shape["y2"] - shape["y1"]) / length
    along = min(max(dx * ex + dy * ey, 0.0), length)
    return hypot(dx - along * ex, dy - along * ey)


def room_of(flipper: Thing, other: Thing, angle: float) -> float:
    """Return how far a flipper at an angle is from a disc, a segment or an arc."""

    def of(x: float, y: float) -> float:
        return distance_from(flipper.shape, x, y, angle)

    shape = other.shape
    if other.kind == DISC:
        return of(shape["x"], shape["y"]) - shape["radius"]
    if other.kind == SEGMENT:
        return least_on_line(of, tuple(shape.values()))
    return min(of(x, y) for x, y in outline_of(other).points.tolist())


def crosses(one: Thing, other: Thing) -> bool:
    """Say whether two segments or arcs cross between their ends."""
    if ARC in (one.kind, other.kind):
        arc, cut = (one, other) if one.kind == ARC else (other, one)
        return pierces(arc.shape, cut)

    def sides(a: Thing, b: Thing) -> float:
        p, q = a.shape, b.shape
        length = hypot(p["x2"] - p["x1"], p["y2"] - p["y1"])
        ex, ey = (p["x2"] - p["x1"]) / length, (p["y2"] - p["y1"]) / length
        size = hypot(q["x1"] - p["x1"], q["y1"] - p["y1"]) + hypot(q["x2"] - p["x1"], q["y2"] - p["y1"])
        one, two = (ex * (q[f"y{i}"] - p["y1"]) - ey * (q[f"x{i}"] - p["x1"]) for i in (1, 2))
        return 1.0 if min(abs(one), abs(two)) <= SLACK * size or (one > 0.0) == (two > 0.0) else -1.0

    return sides(one, other) < 0.0 and sides(other, one) < 0.0


def pierces(arc: Mapping[str, float], other: Thing) -> bool:
    """Say whether an arc crosses a segment or another arc, and does not just touch it or end there."""
    x, y, radius, shape = arc["x"], arc["y"], arc["radius"], other.shape
    if other.kind == ARC:
        dx, dy, size = shape["x"] - x, shape["y"] - y, radius + shape["radius"]
        far = hypot(dx, dy)
        if far <= SLACK * size:
            return False
        nx, ny, bend = dx / far, dy / far, shape["radius"]
        foot = 0.5 * (far + (radius - bend) * (radius + bend) / far)
        sharp = far / (radius * bend)
    else:
        ex, ey = shape["x2"] - shape["x1"], shape["y2"] - shape["y1"]
        length = hypot(ex, ey)
        nx, ny, size = ey / length, -ex / length, radius + length
        foot, sharp = nx * (shape["x1"] - x) + ny * (shape["y1"] - y), 1.0 / radius
    slack = SLACK * (size + abs(x) + abs(y))
    if abs(foot) >= radius - slack:
        return False
    half = sqrt((radius - foot) * (radius + foot))
    wide = slack / (half * sharp)  # along both, as they cross at an angle of the sine half sharp
    places = [(x + nx * foot - ny * s, y + ny * foot + nx * s) for s in (half, -half)]
    return any(between(arc, *place, wide) and between(shape, *place, wide) for place in places)


def between(shape: Mapping[str, float], x: float, y: float, wide: float) -> bool:
    """Say whether a place on the line or the circle of a segment or an arc is surely between its ends."""
    if "radius" in shape:
        turned = (atan2(y - shape["y"], x - shape["x"]) - shape["start"]) % (2.0 * pi)
        return wide < turned * shape["radius"] < (shape["stop"] - shape["start"]) * shape["radius"] - wide
    ex, ey = shape["x2"] - shape["x1"], shape["y2"] - shape["y1"]
    length = hypot(ex, ey)
    return wide < ((x - shape["x1"]) * ex + (y - shape["y1"]) * ey) / length < length - wide
