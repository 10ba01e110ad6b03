"""Guesses of orbits on a table: the shortest closed way over a word of surfaces, and places drawn at random."""

from __future__ import annotations

from collections.abc import Sequence
from math import cos, hypot, pi, sin, sqrt

import numpy as np
from numpy.typing import NDArray

from grazing.billiard.table import Table
from grazing.kernel.random import uniform
from grazing.orbits.bounces import Bounces, Surface, by_number, solid_surfaces
from grazing.orbits.sight import normal_of
from grazing.parameter import parameters

Floats = NDArray[np.float64]
#: Sweeps of the ball's places towards a shortest way.
SWEEPS = 12
#: Part of its size by which a place is moved from there; shortest flight in sizes.
MOVED, SHORT = 0.3, 1e-3
#: Speeds, and times of flights in those of a fall, are guessed in these ranges, as powers of ten.
SPEEDS, FALLS = (-0.7, 0.7), (-1.2, 0.7)


def guessed(bounces: Bounces, many: int, seed: int, number: int) -> Floats:
    """Return guesses (many, 2n): the shortest way first, then places drawn around it and everywhere, and times."""
    n, surfaces = bounces.n, bounces.word
    u = np.tile(shortest(surfaces), (many, 1))
    if many > 1:
        drawn = uniform(seed, (float(n), float(number)), many, 3 * n)
        low, high = (np.array([getattr(s, side) for s in surfaces]) for side in ("low", "high"))
        everywhere = low + (high - low) * drawn[:, :n]
        near = u + MOVED * bounces.scale * (2.0 * drawn[:, :n] - 1.0)
        u = np.where(np.arange(many)[:, None] % 2 == 0, near, everywhere)
        u[0] = shortest(surfaces)
    else:
        drawn = np.full((1, 3 * n), 0.5)
    p, _normal, _m = bounces.frames(u)
    lengths = np.hypot(*np.moveaxis(np.roll(p, -1, -1) - p, 1, 0))
    if bounces.energy is not None and bounces.g == 0.0:
        return np.concatenate([u, np.maximum(lengths, SHORT * bounces.size.max()) / sqrt(2.0 * bounces.energy)], 1)
    if bounces.g == 0.0:
        speed = typical_speed(bounces) * 10.0 ** (SPEEDS[0] + (SPEEDS[1] - SPEEDS[0]) * drawn[:, n : n + 1])
        return np.concatenate([u, np.maximum(lengths, SHORT * bounces.size.max()) / speed], 1)
    fall = sqrt(2.0 * max(_height(bounces.table), bounces.table.rho) / bounces.g)
    return np.concatenate([u, fall * 10.0 ** (FALLS[0] + (FALLS[1] - FALLS[0]) * drawn[:, n : 2 * n])], 1)


def _height(table: Table) -> float:
    spans = [span_of(surface) for surface in solid_surfaces(table)]
    return max(s[3] for s in spans) - min(s[2] for s in spans)


def typical_speed(bounces: Bounces) -> float:
    """Return about how fast a ball is whose impacts take what they give: the mean of the laws' fixed points, or 1."""
    found = []
    for surface in bounces.word:
        law = bounces.table.objects[surface.owner].law
        assert law is not None
        each = by_number(law.law, parameters(law.params))
        kick = float(np.nan_to_num(each(np.zeros(1))[0]))
        loss = float(np.nan_to_num(2.0 - each(np.array([-kick]))[0] / kick, nan=1.0)) if kick > 0.0 else 1.0
        found.append(kick / loss if loss > 0.0 else kick)
    return float(np.mean(found)) or 1.0


def shortest(surfaces: Sequence[Surface]) -> Floats:
    """Return coordinates (n,) near those of the shortest closed way over surfaces, by sweeps from their middles."""
    n = len(surfaces)
    places, u = [middle_of(surface) for surface in surfaces], np.zeros(n)
    for _ in range(SWEEPS):
        for i, one in enumerate(surfaces):
            (ax, ay), (bx, by) = places[i - 1], places[(i + 1) % n]
            if one.round:
                u[i], places[i] = _on_circle(one, ax, ay, bx, by)
            else:
                u[i], places[i] = _on_face(one, ax, ay, bx, by)
    return u


def _on_circle(one: Surface, ax: float, ay: float, bx: float, by: float) -> tuple[float, tuple[float, float]]:
    """Return where the way from a to b by a circle is short: where the angles from its centre to both are halved."""
    da, db = hypot(ax - one.x, ay - one.y) or 1.0, hypot(bx - one.x, by - one.y) or 1.0
    x, y = (ax - one.x) / da + (bx - one.x) / db, (ay - one.y) / da + (by - one.y) / db
    u = float(np.arctan2(one.sign * y, one.sign * x)) if hypot(x, y) > 1e-12 else 0.5 * (one.low + one.high)
    return u, (one.x + one.size * float(np.cos(u)), one.y + one.size * float(np.sin(u)))


def _on_face(one: Surface, ax: float, ay: float, bx: float, by: float) -> tuple[float, tuple[float, float]]:
    """Return where the way from a to b by a face is shortest, on it."""
    nx, ny = one.sign * one.ey, -one.sign * one.ex
    x, y = one.x + one.size * nx, one.y + one.size * ny
    a, b = (abs((px - x) * nx + (py - y) * ny) for px, py in ((ax, ay), (bx, by)))
    feet = [(px - x) * one.ex + (py - y) * one.ey for px, py in ((ax, ay), (bx, by))]
    share = a / (a + b) if a + b > 0.0 else 0.5
    u = min(max(feet[0] + share * (feet[1] - feet[0]), 0.0), one.high)
    return u, (x + u * one.ex, y + u * one.ey)


def span_of(surface: Surface) -> tuple[float, float, float, float]:
    """Return the box (left, right, low, high) of the ball's centre on a surface, or one around that."""
    if surface.round:
        r = surface.size
        return surface.x - r, surface.x + r, surface.y - r, surface.y + r
    mx, my = normal_of(surface)
    ends = [
        (surface.x + surface.size * mx + s * surface.ex, surface.y + surface.size * my + s * surface.ey)
        for s in (0.0, surface.high)
    ]
    xs, ys = zip(*ends, strict=True)
    return min(xs), max(xs), min(ys), max(ys)


def middle_of(surface: Surface) -> tuple[float, float]:
    """Return a point in the middle of a surface: the centre of a circle, of a part of one the point halfway."""
    if surface.whole:
        return surface.x, surface.y
    if surface.round:
        half = 0.5 * (surface.low + surface.high) % (2.0 * pi)
        return surface.x + surface.size * cos(half), surface.y + surface.size * sin(half)
    left, right, low, high = span_of(surface)
    return 0.5 * (left + right), 0.5 * (low + high)
