"""States built backwards so that the first flight dips below the wall, or clears it, by a tiny amount."""

from __future__ import annotations

import random
from typing import NamedTuple

from .exact import Problem, advance, force, free_flight


class Dip(NamedTuple):
    """A start (u, v) at t = 0 whose first flight turns at sigma - depth (hits) or sigma + depth near t_m."""

    u: float
    v: float
    hits: bool
    t_m: float


def dips(problem: Problem, depth: float, count: int, seed: int, tries: int = 3000) -> list[Dip]:
    """`count` states, dips and clearances in turn, each checked by flying the rounded state forward.

    A dip is kept when its first impact comes just before t_m, a clearance when none comes until well after.
    """
    rng = random.Random(f"{seed} {depth!r} {problem!r}")
    period = float(problem.period)
    horizon = min(period, 8.0 / max(problem.alpha, 1e-3))  # a longer flight back grows too much
    found: list[Dip] = []
    for _ in range(tries):
        if len(found) == count:
            return found
        hits = len(found) % 2 == 0
        t_m = rng.uniform(0.02, 1.0) * horizon
        push = float(force(problem, t_m))
        if push < 0.05:
            continue
        width = (2 * depth / push) ** 0.5
        if t_m + width > period or t_m < 2 * width:
            continue
        side = -depth if hits else depth
        u_exact, v_exact = free_flight(problem, t_m, problem.sigma + side, 0.0, -t_m)
        u, v = float(u_exact), float(v_exact)
        if not (2 * depth < u - problem.sigma < 8.0 and abs(v) < 4.0):
            continue
        impacts = advance(problem, u, v, 1)[0].impacts
        first = float(impacts[0].t) if impacts else 2 * period
        if (t_m - 3 * width < first < t_m) if hits else (first > t_m + 3 * width):
            found.append(Dip(u, v, hits, t_m))
    raise RuntimeError(f"only {len(found)} of {count} states of depth {depth} found for {problem}")
