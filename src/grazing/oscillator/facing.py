"""Two walls that face each other: the tables of both, and the pairs that they see at the strobe.

See :mod:`grazing.oscillator.between`. One wall that moves, or that is above the ball, is seated here, too.
"""

from __future__ import annotations

from typing import Any

from grazing.kernel.primitives import behind, inlined
from grazing.oscillator.cells import (
    BROUGHT,
    CERTIFICATE,
    GROWN,
    LAW,
    LEAST,
    LEVER,
    MARGIN,
    MAX_ROWS,
    MIRROR,
    PAIR,
    SHARP,
    SIGMA,
    SPAN,
    STATE,
    UPRIGHT,
    fill_table,
)  # fmt: skip
from grazing.oscillator.frames import Frames
from grazing.oscillator.pairs import held_back, margin_of
from grazing.oscillator.workspace import AWAKE, FRESH, HELD, HIGH, NAN, W


@inlined
def fill_frames(t: Any, s: Any, x: Any, c: Frames, blocks: int) -> bool:
    """Fill the tables of the walls, ``s`` being that of the second where there are two; see :func:`fill_table`."""
    t[LAW] = c.a.p.row
    if c.two:
        s[LAW] = c.b.p.row
    if not blocks or not fill_table(t, x, c.a, c.a.p.ratio, c.unsure, c.unsure_w):
        return False
    if c.two:
        if not fill_table(s, x, c.b, c.b.p.ratio, c.unsure + c.blur, c.unsure_w + c.blur_w):
            return False
        face(t, s, c)
    seat(t, c)
    return True


def seat(t: Any, c: Frames) -> None:
    """Let pairs stand for the ball's own position and velocity, not for those that the first wall sees."""
    t[SIGMA] = c.side * t[SIGMA] + (c.za - c.side * c.a.sigma)
    for h in range(6):
        t[STATE + h] *= c.side
    for h in range(4):
        t[PAIR + h] *= c.side
    t[STATE + 3] += c.wa


def face(t: Any, s: Any, c: Frames) -> None:
    """Write what the tables of two walls say of each other.

    The distances from the walls add up to that of the walls, and the free flights are the same: so do the pairs, up to
    the pair of a free flight that is 0 where k > 0 and both take the steady response for the forced flight.
    """
    x, y = 0.0, 0.0
    if not (c.a.steady and c.b.steady and c.a.k2 > 0.0):
        one, two = t[STATE] + (t[SIGMA] - c.a.sigma), s[STATE] + (s[SIGMA] - c.b.sigma)
        high, fast = (c.zb - c.za) - one - two, (c.wb - c.wa) - t[STATE + 3] - s[STATE + 3]
        x, y = t[PAIR] * high + t[PAIR + 1] * fast, t[PAIR + 2] * high + t[PAIR + 3] * fast
    t[MIRROR], t[MIRROR + 1], s[MIRROR], s[MIRROR + 1] = x, y, x, y
    share = s[LEAST] / t[LEAST]
    for h in range(3):  # errors of heights then count alike in the rows of both
        t[MARGIN + h] *= max(1.0 / share, 1.0)
        s[MARGIN + h] *= max(share, 1.0)
    t[BROUGHT], s[BROUGHT] = s[MARGIN] * s[SHARP], t[MARGIN] * t[SHARP]
    s[MARGIN] += s[BROUGHT]  # at the strobe all come from the first wall's pair
    lever = min(c.a.T, 1.0 / c.a.alpha) if c.a.alpha > 0.0 else c.a.T
    lever = min(lever, 1.0 / c.a.spread) if c.a.spread > 0.0 else lever
    t[LEVER], t[GROWN] = lever, 1.0 if c.a.q2 > 0.0 else 1.0 + 0.5 * c.a.alpha * lever
    t[SPAN] = 0.5 * c.patience * c.a.T  # a quarter of the room between the walls
    s[LEVER], s[GROWN], s[SPAN] = t[LEVER], t[GROWN], t[SPAN]


@inlined
def mirrored(w: Any, tables: Any, room: int, runs: Any, awake: int, columns: int, stride: int) -> None:
    """Write the pairs that the second wall sees at a strobe, and what they need."""
    half = columns * stride
    for n in range(awake):
        q = runs[AWAKE + n]
        s = behind(tables, (q + columns) * room)
        m1, m2, base, by_x, by_y, upright = (
            s[MIRROR],
            s[MIRROR + 1],
            s[MARGIN],
            s[MARGIN + 1],
            s[MARGIN + 2],
            s[UPRIGHT],
        )
        for i in range(q * stride, (q + 1) * stride):
            x, y = m1 - w[W.C1 + i], m2 - w[W.C2 + i]
            least = base + (by_x * abs(x) + by_y * abs(y))
            w[W.C1 + half + i], w[W.C2 + half + i] = x, y
            w[W.NEED + half + i] = (least if least < HIGH else NAN) - upright * x


@inlined
def held_between(w: Any, i: int, half: int, t: Any, s: Any) -> float:
    """Do what :func:`grazing.oscillator.pairs.held_back` does, for two walls."""
    where = held_back(w, i, t)
    x, y = s[MIRROR] - w[W.C1 + i], s[MIRROR + 1] - w[W.C2 + i]
    least = margin_of(s, x, y)
    height = s[CERTIFICATE] * x + (s[CERTIFICATE + MAX_ROWS] * y + s[CERTIFICATE + 2 * MAX_ROWS])
    if where == FRESH and height > 2.0 * least:
        w[W.C1 + half + i], w[W.C2 + half + i], w[W.NEED + half + i] = x, y, least - s[UPRIGHT] * x
        return FRESH
    w[W.C1 + i], w[W.C2 + i], w[W.NEED + i] = NAN, NAN, NAN
    w[W.C1 + half + i], w[W.C2 + half + i], w[W.NEED + half + i] = NAN, NAN, NAN
    return HELD
