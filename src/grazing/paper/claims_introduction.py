"""Claims of the introduction: the graze, the two phase portraits and the two bifurcation diagrams."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from grazing.maps.stroboscopic import stroboscopic_map
from grazing.paper.claims import Claim, claim
from grazing.paper.run import Run
from grazing.paper.settle import settled, words
from grazing.theory.windows import stability_interval


def graze(run: Run) -> Iterator[Claim]:
    """Check the graze of the steady response of the set S."""
    model = run.standard(0.0)
    p = model.params
    amplitude = 1.0 / abs(complex(p["k"] ** 2 - p["omega"] ** 2, p["omega"] * p["alpha"]))
    found = run.normal_form(0.0).graze
    yield claim(
        "graze-d",
        "section 1",
        "the grazing bifurcation is at about d",
        "0.135",
        found,
        slip=1,
        note="k²a with a the amplitude of the steady response; found here as the root of its lowest height",
    )
    yield claim("graze-amplitude", "reference", "graze of S: d = k²a", "0.130961869350", p["k"] ** 2 * amplitude)
    yield claim("graze-root", "reference", "graze of S by root finding", "0.130961869350", found)
    rest = [settled(stroboscopic_map(run.standard(V, d=0.14)), (0.1, 0.0)) for V in (0.0, 0.4)]
    yield claim(
        "above-graze",
        "section 1",
        "above the graze: period 1, no impact",
        [1, "0"],
        [rest[0].period, rest[0].word],
        note="V = 0, d = 0.14",
    )
    yield claim("above-graze-active", "Figure 1.6", "the same for V = 0.4", [1, "0"], [rest[1].period, rest[1].word])


def passive_portrait(run: Run) -> Iterator[Claim]:
    """Check Figure 1.2."""
    passive = run.figure("1.2")
    yield claim("1.2-period", "Figure 1.2", "passive orbit at d = 0.12: period", "2", passive["cycle"].period)
    yield claim(
        "1.2-impacts", "Figure 1.2", "number of impacts until the orbit closes", "1", passive["flight"].sizes["impact"]
    )
    speed = abs(float(passive["flight"]["v_minus"].values[0]))
    share = speed / float(np.abs(passive["flight"]["v"].values).max())
    yield claim(
        "1.2-low-velocity",
        "Figure 1.2",
        "the impact has low velocity: less than half of the greatest speed",
        True,
        share < 0.5,
        note=f"impact speed {speed:.6f}, {100 * share:.0f} % of the greatest speed of the orbit",
    )
    inside, outside = (passive_impact_speed(run, d) for d in (0.1300, 0.1309))
    yield claim(
        "graze-speed",
        "section 1",
        "the impact speed falls to zero at the graze",
        True,
        0.0 < outside < inside,
        note=f"slowest impact {inside:.5f} at d = 0.13, {outside:.5f} at d = 0.1309",
    )


def active_portrait(run: Run) -> Iterator[Claim]:
    """Check Figure 1.5."""
    active = run.figure("1.5")
    yield claim("1.5-period", "Figure 1.5", "active orbit at d = 0.12: period", "3", active["cycle"].period)
    yield claim(
        "1.5-impacts", "Figure 1.5", "number of impacts until the orbit closes", "1", active["flight"].sizes["impact"]
    )
    before, after = float(active["flight"]["v_minus"].values[0]), float(active["flight"]["v_plus"].values[0])
    yield claim(
        "1.5-faster",
        "section 1",
        "the ball may leave faster than it came",
        True,
        after > -before,
        note=f"v⁻ = {before:.6f}, v⁺ = {after:.6f}",
    )
    yield claim("1.5-reset", "(1.3)", "v⁺ + r v⁻ = V at the impact", "0.4", after + 0.8 * before, tolerance=1e-12)


def passive_impact_speed(run: Run, d: float) -> float:
    """Return the least impact speed in 60 periods of the passive oscillator after a transient."""
    from grazing.oscillator.trajectory import trajectory

    model = run.standard(0.0, d)
    start = stroboscopic_map(model).iterate((0.1, 0.0), 400)[-1]
    return float(np.abs(trajectory(model, start, until=60 * model.period, samples=2)["v_minus"].values).min())


def growth(run: Run, V: float, closest: float, farthest: float) -> tuple[float, Any]:
    """Return the exponent of the size of the attractor against the distance from the graze, and the sizes."""
    graze_at = run.normal_form(V).graze
    distance = np.logspace(np.log10(closest), np.log10(farthest), 49)
    sizes = []
    for d in graze_at - distance:
        P = stroboscopic_map(run.standard(V, float(d)))
        lanes = np.tile([[0.08], [0.1]], 6) * np.linspace(1.0, 2.0, 6)
        points, _letters, _outcomes = P.run(lanes, 300, 80)
        sizes.append(float(np.ptp(points[:, 0])))
    return float(np.polyfit(np.log(distance), np.log(sizes), 1)[0]), np.array(sizes)


def diagrams(run: Run) -> Iterator[Claim]:
    """Check Figures 1.3 and 1.6."""
    exponent, _size = growth(run, 0.0, 1e-9, 1e-3)
    yield claim(
        "1.3-square-root",
        "Figure 1.3",
        "V = 0: the attractor grows from the graze with exponent",
        "0.5",
        exponent,
        tolerance=0.02,
        note="regression of its extent in u over six decades of the distance",
    )
    exponent, size = growth(run, 0.4, 1e-9, 1e-5)
    yield claim(
        "1.6-jump",
        "Figure 1.6",
        "V = 0.4: the attractor jumps at the graze, exponent",
        "0",
        exponent,
        tolerance=0.02,
        note=f"extent in u {float(size[0]):.5f} at a distance of 1e-9",
    )
    low, high = float(size.min()), float(size.max())
    yield claim(
        "1.6-jump-size",
        "Figure 1.6",
        "its extent keeps its size up to the graze",
        True,
        low > 0.95 * high,
        note=f"{low:.5f} to {high:.5f} at distances 1e-9 to 1e-5",
    )
    passive = run.figure("1.3")
    seen = {int(p) for name in ("diagram", "close") for p in np.unique(passive[name]["period"].values)}
    yield claim(
        "1.3-incrementing",
        "Figure 1.3",
        "periods 2, 3, 4 on the way to the graze",
        True,
        {2, 3, 4} <= seen,
        note=f"periods found: {sorted(p for p in seen if p > 0)}",
    )
    for N in (3, 4):
        low, high = run.windows(0.0)[N][1], run.windows(0.0)[N + 1][0]
        found_words = words(stroboscopic_map(run.standard(0.0, d=0.5 * (low + high))), 32, 2000)
        yield claim(
            f"1.3-chaos-{N}-{N + 1}",
            "Figure 1.3",
            f"chaos between the windows of {N} and {N + 1}: no start finds a period",
            [True, [""]],
            [low < high, sorted(found_words)],
            note=f"the windows leave {low:.8f} < d < {high:.8f} between them",
        )


def coexistence(run: Run) -> Iterator[Claim]:
    """Neighbours N and N + 1 in the overlap of their exact windows, found from random starts."""
    edges = run.windows(0.4)
    for N in (2, 3, 4, 5):
        low, high = edges[N + 1][0], edges[N][1]
        P = stroboscopic_map(run.standard(0.4, d=0.5 * (low + high)))
        found = words(P, 128, 2000, within=1e-8)
        yield claim(
            f"1.6-coexist-{N}-{N + 1}",
            "Figure 1.6",
            f"orbits of periods {N} and {N + 1} coexist in Ω{N} ∩ Ω{N + 1}",
            sorted(["0" * (N - 1) + "1", "0" * N + "1"]),
            sorted(found),
            note=f"words of 128 random starts at d = {0.5 * (low + high):.8f}",
        )
    active = run.figure("1.6")
    near = active["close"]
    at = near["d"].values
    seen = [
        {len(str(word)) for word in np.unique(near["word"].values[i]) if str(word).strip("0") == "1"}
        for i in np.flatnonzero(at < active["graze"])
    ]
    highest = [max(lengths) for lengths in seen if lengths]
    steps = np.diff(highest)
    yield claim(
        "1.6-incrementing",
        "Figure 1.6",
        "the period rises by one from window to window towards the graze",
        True,
        bool((steps >= 0).all()) and {3, 4, 5, 6} <= set().union(*seen),
        note=f"greatest N found with one impact in N periods, at each d of the close-up: {highest[0]} to {highest[-1]}",
    )


def high_periods(run: Run) -> Iterator[Claim]:
    """Orbits of high period next to the graze, as many as the normal form says."""
    nf = run.normal_form(0.4)
    found, right = [], []
    for distance in (1e-5, 1e-7, 1e-9, 1e-11):
        d = nf.graze - distance
        mu = nf.mu(d)
        low, high = (float(edge) for edge in window_numbers(nf.lam, nf.l, mu))
        P = stroboscopic_map(run.standard(0.4, d=d))
        found.append(settled(P, (0.07, 0.2), within=1e-11).period)
        right.append(low <= found[-1] <= high)
    yield claim(
        "1.6-high",
        "Figure 1.6",
        "orbits of ever higher period are born at the graze, those whose window the normal form puts there",
        [True] * 4,
        right,
        note="at distances 1e-5, 1e-7, 1e-9 and 1e-11: periods " + ", ".join(str(N) for N in found),
    )


def window_numbers(lam: float, l: float, mu: float) -> tuple[int, int]:
    """Return the least and the greatest period whose window contains mu."""
    inside = [N for N in range(1, 80) if mu in stability_interval(N, lam, l)]
    return min(inside), max(inside)


GROUPS = (
    (("1.3",), graze),
    (("1.2",), passive_portrait),
    (("1.5",), active_portrait),
    (("1.3", "1.6"), diagrams),
    (("1.6",), coexistence),
    (("1.6",), high_periods),
)
