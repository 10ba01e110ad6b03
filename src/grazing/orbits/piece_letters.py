"""What the pieces of a map do at their borders: how large borders are, which pieces end there, whose a point is."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from grazing.maps.bordered import Images
from grazing.maps.map import Map
from grazing.orbits.one_sided import EPS
from grazing.orbits.piece_end import POWER
from grazing.orbits.search_windows import drawn

Floats = NDArray[np.float64]

#: Letters whose images miss the next point by less than this part of its size are equally good.
EQUAL = 1e-9

#: States of the box from which lines to a border begin, and distances from it, in their length, at which pieces are
#: looked at.
LINES, BESIDE = 64, 4.0 ** np.arange(-18.0, -5.0)


def border_units(P: Map) -> Floats:
    """Return the size of each border function over the box, 1 where it is nothing."""
    corners = np.array(np.meshgrid(*P.box)).reshape(P.dimension, -1).T[:64]
    states = np.vstack([corners, np.array(P.box).mean(axis=1)])
    borders = np.abs(P.images()(P.packed()[1][None], 0, states, 0, 0.0)[1])
    size = np.where(np.isfinite(borders), borders, 0.0).max(axis=0)
    return np.where(size > 0.0, size, 1.0)


def one_sided(P: Map) -> tuple[bool, ...]:
    """Return which pieces have no value beyond a border of theirs, or are infinitely steep at it.

    They are looked at along lines through the box from one side of the border to the other.
    """
    assert P.formulas is not None
    row, images, m = P.packed()[1][None], P.images(), len(P.formulas.borders)
    states = drawn(0, LINES, np.array(P.box), 0.0).T
    borders = images(row, 0, states, 0, 0.0)[1]
    found = [False] * (m + 1)
    for i in range(m):
        inside, outside = states[borders[:, i] < 0.0], states[borders[:, i] >= 0.0]
        count = min(len(inside), len(outside), 4)
        a, b = inside[:count], outside[:count]
        for _ in range(60 if count else 0):
            middle = 0.5 * (a + b)
            left = (images(row, 0, middle, 0, 0.0)[1][:, i] < 0.0)[:, None]
            a, b = np.where(left, middle, a), np.where(left, b, middle)
        way = outside[:count] - inside[:count]
        for k in (i, i + 1):
            if count and not P.formulas.rooted[k]:
                found[k] |= any(_steep(images, row, k, b, side * way) for side in (1.0, -1.0))
    return tuple(found)


def _steep(images: Images, row: Floats, k: int, points: Floats, way: Floats) -> bool:
    """Whether a piece has no value next to points (n, dim) in directions, or is infinitely steep there."""
    ahead = points + np.stack([BESIDE, 2.0 * BESIDE])[..., None, None] * way
    values = images(row, 0, ahead.reshape(-1, points.shape[1]), k, 0.0)[0].reshape(ahead.shape)
    if not np.isfinite(values).all():
        return True
    change, noise = np.abs(values[1] - values[0]).max(axis=-1), 1e3 * EPS * np.abs(values).max(axis=(0, -1))
    with np.errstate(all="ignore"):
        power = np.log(change[1:] / change[:-1]) / np.log(BESIDE[1:] / BESIDE[:-1])[:, None]
    heard = (change > noise)[1:] & (change > noise)[:-1]
    seen = [one[good][:4] for one, good in zip(power.T, heard.T, strict=True)]
    return any(len(one) == 4 and bool((one < POWER).all()) for one in seen)


def letters_from(P: Map, points: Floats) -> tuple[tuple[int, ...], Floats]:
    """Return the letters of an orbit's points from their images, so that those of a virtual one are right, and roots.

    Where two letters lead to the next point the map's own one is taken.
    """
    assert P.formulas is not None
    row, images, after = P.packed()[1][None], P.images(), np.roll(points, -1, axis=0)
    own = [int(P.orbit(point, 1).letters[0]) for point in points]
    size = 1.0 + np.abs(after).max()
    best: list[tuple[float, int, float]] = [(np.inf, k, 0.0) for k in own]
    borders = images(row, 0, points, 0, 0.0)[1]
    for k, rooted in enumerate(P.formulas.rooted):
        distance = (
            np.sqrt(np.maximum((-1.0 if k == 0 else 1.0) * borders[:, 0], 0.0)) if rooted else np.zeros(len(points))
        )
        for sign in (1.0, -1.0) if rooted else (1.0,):
            found = images(row, 0, points, k, sign * distance)[0]
            off = np.nan_to_num(np.abs(found - after).max(axis=1), nan=np.inf)
            for j, one in enumerate(off):
                close = one <= EQUAL * size and (best[j][0] > EQUAL * size or (k == own[j] and best[j][1] != k))
                if close or (one < best[j][0] and best[j][0] > EQUAL * size):
                    best[j] = float(one), k, float(sign * distance[j])
    return tuple(one[1] for one in best), np.array([one[2] for one in best])
