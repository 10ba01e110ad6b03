"""Which surface a ball without a radius hits where some end: rounding parts them there, and shows it their backs."""

from __future__ import annotations

from collections.abc import Sequence
from math import atan2

import numpy as np
from numpy.typing import NDArray

from grazing.billiard.elements import SAME, element, gap_of, holds, normal_of, to_end
from grazing.billiard.hit import flown
from grazing.billiard.roots import SHARE, Gap, Root, beside
from grazing.billiard.rows import FACES, GRAVITY, HEAD, SIZE, THICK, THING, THINGS, WIDTH

Floats = NDArray[np.float64]


def bare(surface: int, block: Floats) -> bool:
    """Say whether a surface with ends is that of a ball without a radius: nothing is around these."""
    faces, things = int(block[FACES]), HEAD + THING * int(block[THINGS])
    row = block[things + WIDTH * (surface // 2 if surface < 2 * faces else surface - faces) :]
    return bool(row[SIZE] == 0.0 if surface < 2 * faces else row[THICK] == 0.0)


def ways_at(root: Root, gap: Gap, state: tuple[float, ...], block: Floats) -> list[tuple[float, float]]:
    """Return (hand, angle) of each way in which a surface goes on from a contact, none where the surface is not.

    ``angle`` is that from the surface to where the ball comes from, on the side of the ball, ``hand`` the sense in
    which it turns. There are two at the middle of the surface.
    """
    if not beside(root._replace(gap=gap)):
        return []
    x, y, vx, vy = flown(state[0], state[1], state[2], state[3], float(block[GRAVITY]), float(root.t))
    el, slack = element(gap.surface, 0.0, block), SHARE * (abs(state[0]) + abs(state[1]) + abs(x) + abs(y))
    slack += SHARE * el[7] if el[0] == 0.0 else SHARE * el[6]
    if abs(gap_of(el, x, y)) > slack or not holds(el, x, y, slack):
        return []
    nx, ny = normal_of(el, x, y)
    down, past = -(vx * nx + vy * ny), vy * nx - vx * ny
    if not down > 0.0:
        return []
    return [(way, atan2(down, -way * past)) for way in (1.0, -1.0) if to_end(el, x, y, way) > slack]


def behind_others(own: Sequence[tuple[float, float]], others: Sequence[Sequence[tuple[float, float]]]) -> bool:
    """Say whether another surface lies between the end of one and where the ball comes from."""
    return len(own) == 1 and any(
        hand == own[0][0] and angle < own[0][1] - SAME for other in others for hand, angle in other
    )


def at_joints(near: list[Root], hits: list[Root], state: tuple[float, ...], block: Floats) -> tuple[list[Root], bool]:
    """Return the contacts of a ball without a radius, from those that it has, and whether one of them is no sure one.

    ``near`` are those with surfaces that have ends, between these or, by rounding, beyond. Where two surfaces meet the
    ball does not hit the one that is behind the other; and if it misses both, it hits what it comes to.
    """
    seen = [[[] if a.gap is b.gap else ways_at(a, b.gap, state, block) for b in near] for a in near]
    shown = [not behind_others(ways_at(a, a.gap, state, block), ways) for a, ways in zip(near, seen, strict=True)]
    hit = [any(root is one for one in hits) for root in near]
    every, added = range(len(near)), []
    for i in every:
        sure = any(hit[j] and shown[j] and seen[i][j] and seen[j][i] for j in every)
        if shown[i] and not hit[i] and any(seen[i]) and not sure:
            added.append(near[i])
    hidden = [near[i] for i in every if not shown[i]]
    return [one for one in hits if not any(one is root for root in hidden)] + added, bool(added)
