"""Proposition 3.1 verified by iteration and multiplier, inside and just outside both edges of many windows."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from grazing.maps.gap import gap_map
from grazing.paper.claims import Claim, claim
from grazing.paper.run import Run
from grazing.theory.doubled import doubled_interval, doubled_multiplier, doubled_orbit
from grazing.theory.edges import mu_bc, mu_pd
from grazing.theory.windows import stability_interval


class Check(NamedTuple):
    """What iteration says at one distance from an edge of a window."""

    returns: bool
    multiplier: float


def cases(number: int) -> list[tuple[int, float, float]]:
    """Return (N, lam, l) whose windows are not empty, spread evenly by a fixed rule."""
    rng = np.random.default_rng(2011)
    found: list[tuple[int, float, float]] = []
    while len(found) < number:
        N, lam, l = (
            int(rng.integers(2, 12)),
            float(rng.uniform(0.1, 0.95)),
            float(rng.choice([0.0, rng.uniform(0.0, 1.5)])),
        )
        if not stability_interval(N, lam, l).empty:
            found.append((N, lam, l))
    return found


def iterated(N: int, lam: float, mu: float, l: float) -> Check:
    """Return whether starts next to the orbit L^(N-1) R come back to it, and its multiplier.

    The point is found by bisection on the N-th iterate of the map along L^(N-1) R, not by the formula.
    """
    P = gap_map(lam, mu, l)
    c = lam ** (N - 1)
    low, high = 0.0, max(mu, 0.0)

    def surplus(x: float) -> float:
        return lam ** (N - 1) * (mu - l - math.sqrt(x)) + mu * sum(lam**i for i in range(N - 1)) - x

    for _ in range(200):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if surplus(middle) > 0.0 else (low, middle)
    start = low
    x = P.iterate((start,), N)[:, 0]
    virtual = bool((x[1:N] >= 0.0).any()) or start >= mu
    multiplier = -c / (2.0 * math.sqrt(start)) if start > 0.0 else -math.inf
    nearby = np.array([[start * (1.0 + 1e-6), start * (1.0 - 1e-6)]])
    _points, letters, _outcomes = P.run(nearby, 0, 400 * N)
    after = np.abs(nearby[0] - start)
    word = (letters[-N:] == np.array([0] * (N - 1) + [1])[:, None]).all(axis=0) if N > 1 else np.array([True])
    rolled = bool(word.any()) or bool((np.sort(letters[-N:], axis=0)[:-1] == 0).all())
    return Check(not virtual and rolled and bool((after < 1e-6 * start).all()), multiplier)


def edges(run: Run) -> Iterator[Claim]:
    """Check Proposition 3.1 by iteration, inside and just outside both edges."""
    inside, below, above, slopes = [], [], [], []
    chosen = cases(run.size.cases)
    for N, lam, l in chosen:
        low, high = stability_interval(N, lam, l)
        step = 0.02 * (high - low)
        inside += [iterated(N, lam, mu, l) for mu in (low + step, 0.5 * (low + high), high - step)]
        below.append(iterated(N, lam, low - step, l))
        above.append(iterated(N, lam, high + step, l))
        slopes.append(iterated(N, lam, low, l).multiplier)
    n = len(chosen)
    said = f"{n} choices of (N, λ, l), N = 2 to 11; 2 % of the width from the edge"
    yield claim(
        "prop1-inside",
        "Proposition 3.1",
        "inside the window nearby starts return to the orbit",
        3 * n,
        sum(c.returns for c in inside),
        note=said,
    )
    yield claim(
        "prop1-inside-multiplier",
        "Proposition 3.1",
        "and its multiplier lies between −1 and 0",
        3 * n,
        sum(-1.0 < c.multiplier < 0.0 for c in inside),
    )
    yield claim("prop1-below", "Proposition 3.1", "just below μ_PD,N none returns", "0", sum(c.returns for c in below))
    yield claim(
        "prop1-below-multiplier",
        "Proposition 3.1",
        "and the multiplier is below −1",
        n,
        sum(c.multiplier < -1.0 for c in below),
    )
    yield claim(
        "prop1-above",
        "Proposition 3.1",
        "just above μ_BC,N none returns: the orbit is virtual",
        "0",
        sum(c.returns for c in above),
    )
    worst = max(abs(s + 1.0) for s in slopes)
    yield claim(
        "prop1-pd", "Proposition 3.1", "at μ_PD,N the multiplier is −1: largest deviation", 0, worst, tolerance=1e-8
    )
    yield claim(
        "prop1-closed",
        "Proposition 3.1",
        "the orbit is stable at the edges too: Ω_N is closed",
        True,
        all(abs(s) < 1.0 - 1e-8 for s in slopes),
        slip=17,
        note="open at both ends: the multiplier is −1 at μ_PD,N, and at μ_BC,N the orbit meets the border",
    )


def closed_bc(N: int, lam: float, l: float) -> float | None:
    """Return μ_BC,N from the closed form of Proposition 3.1 as it stands, None where it divides by zero."""
    top = lam ** (N - 2)
    sum_ = (1.0 - lam ** (N - 1)) / (1.0 - lam)
    try:
        return float((top + math.sqrt(top * top + 4.0 * top * l * sum_)) ** 2 / (4.0 * sum_**2))
    except ZeroDivisionError:
        return None


def first_window(run: Run) -> Iterator[Claim]:
    """Check Proposition 3.1 for N = 1."""
    yield claim(
        "prop1-N1",
        "Proposition 3.1",
        "N = 1: μ_PD,1 = l + 3/4",
        0.25 + 0.75,
        float(mu_pd(1, 0.5, 0.25)),
        tolerance=1e-15,
    )
    yield claim(
        "prop1-bc-closed",
        "Proposition 3.1",
        "the closed form of μ_BC,N gives the edge, N = 2 to 12, λ = 0.5, l = 0.25: largest deviation",
        0,
        max(abs((closed_bc(N, 0.5, 0.25) or math.inf) - float(mu_bc(N, 0.5, 0.25))) for N in range(2, 13)),
        tolerance=1e-14,
    )
    yield claim(
        "prop1-N1-bc",
        "Proposition 3.1",
        "N = 1: the printed formula gives a μ_BC,1; its divisor (1 − λ^(N−1))² is not 0",
        True,
        closed_bc(1, 0.5, 0.25) is not None,
        slip=16,
        note="the divisor is 0: a fixed point has no negative iterate and its window no upper edge",
    )
    inside = iterated(1, 0.5, 1.1, 0.25)
    outside = iterated(1, 0.5, 0.95, 0.25)
    yield claim(
        "prop1-N1-iterated",
        "reference",
        "N = 1 by multiplier, stable at μ = 1.1 and not at 0.95 (λ = 0.5, l = 0.25)",
        [True, False],
        [abs(inside.multiplier) < 1, abs(outside.multiplier) < 1],
    )


def doubling(run: Run) -> Iterator[Claim]:
    """Check what the period doubling leaves behind."""
    multipliers, drifts = [], []
    for N, lam, l in cases(run.size.cases):
        low, high = doubled_interval(N, lam, l)
        mu = 0.5 * (low + high)
        orbit = doubled_orbit(N, lam, mu, l)
        multipliers.append(doubled_multiplier(N, lam, mu, l))
        image = gap_map(lam, mu, l).iterate((orbit[N - 1],), 2 * N)[-1, 0]
        drifts.append(abs(image - orbit[N - 1]) / multipliers[-1])
    yield claim(
        "pd-subcritical",
        "reference",
        "the period doubling is subcritical: an unstable orbit of twice the period lies inside the window, "
        "number of unstable ones",
        run.size.cases,
        sum(m > 1.0 for m in multipliers),
        note=f"multipliers from {min(multipliers):.3f} on; beyond the edge orbits jump to another window or to chaos",
    )
    yield claim(
        "pd-orbit",
        "reference",
        "the unstable doubled orbits are orbits: largest defect after 2N iterates",
        0,
        max(drifts),
        tolerance=1e-9,
    )


GROUPS = (
    (("3.1", "3.2"), edges),
    (("3.1", "3.2"), first_window),
    (("3.1", "3.2"), doubling),
)
