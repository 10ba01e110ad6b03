"""Claims of section 3 on Figures 3.1 to 3.4: the gap map, its cobweb, its windows at lambda = 0.5."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from grazing.maps.gap import gap_map
from grazing.paper.claims import Claim, claim
from grazing.paper.lyapunov import exponent
from grazing.paper.run import Run
from grazing.paper.settle import settled, words
from grazing.theory.edges import mu_bc, mu_pd
from grazing.theory.maximal import maximal_orbit
from grazing.theory.windows import stability_interval, windows_overlap


def cobweb(run: Run) -> Iterator[Claim]:
    """Check Figure 3.1 and the conditions printed before Figure 3.2."""
    data = run.figure("3.1")
    cycle, P = data["cycle"], data["map"]
    x = cycle.points[:, 0]
    word = "".join("LR"[i] for i in cycle.letters)
    yield claim("3.1-period", "Figure 3.1", "λ = 0.8, l = 1, μ = 0.5: period", "3", cycle.period)
    yield claim("3.1-word", "Figure 3.1", "its word", "LLR", word)
    for i, value in enumerate(("-1.0060750571", "-0.3048600457", "0.2561119634")):
        yield claim(f"3.1-x{i + 1}", "reference", f"x{i + 1} of the orbit", value, float(x[i]))
    slope = float(np.prod([P.jacobian(point)[0, 0] for point in cycle.points]))
    yield claim("3.1-multiplier", "reference", "multiplier of the orbit", "-0.632317", slope)
    lam, mu, l = 0.34, 0.5, 0.21
    orbit = maximal_orbit(2, lam, mu, l)
    yield claim(
        "3.1-closing",
        "section 3",
        "x1 = −√(x_N + μ − l)",
        float(orbit[0]),
        -math.sqrt(orbit[-1] + mu - l),
        tolerance=1e-12,
        slip=2,
        note="the closing condition is x1 = −√x_N + μ − l; claimed: the orbit's x1 at λ = 0.34, l = 0.21, μ = "
        "0.5, N = 2",
    )
    yield claim(
        "3.1-closing-right",
        "section 3",
        "x1 = −√x_N + μ − l",
        float(orbit[0]),
        float(-math.sqrt(orbit[-1]) + mu - l),
        tolerance=1e-14,
    )
    yield claim(
        "3.1-greatest",
        "Proposition 3.1, proof",
        "x_(N−1) is the single positive iterate",
        True,
        bool(x[-2] > 0.0),
        slip=2,
        note="it is the greatest negative one, x_N the single positive one",
    )


def maximal_only(run: Run) -> Iterator[Claim]:
    """Check Figure 3.2."""
    found = run.figure("3.2")["diagram"]
    mu, names = found["mu"].values, found["word"].values
    right = {str(word) for word in np.unique(names[mu > 0.01]) if word}
    others = sorted(word for word in right if word.strip("L") != "R")
    yield claim(
        "3.2-maximal",
        "Figure 3.2",
        "all orbits are maximal, L…LR: other words found",
        [],
        others,
        note=f"found: {', '.join(sorted(right, key=len))}",
    )
    yield claim(
        "3.2-overlap",
        "Figure 3.2",
        "neighbouring windows overlap, N = 1 to 40",
        True,
        all(windows_overlap(N, 0.34, 0.21) for N in range(1, 41)),
    )
    yield claim(
        "3.2-left",
        "Figure 3.2",
        "one fixed point left of the graze",
        ["L"],
        sorted({str(w) for w in np.unique(names[mu < 0.0])}),
    )
    P = gap_map(0.34, 1e-9, 0.21)
    size = float(np.ptp(settled(P, (-0.1,), longest=128, within=1e-13).points))
    low = -size
    yield claim(
        "3.2-jump",
        "Figure 3.2",
        "the attractor jumps at the graze to the size l",
        "0.21",
        -low,
        note="extent in x at μ = 1e-9",
    )


def first_gaps(run: Run) -> Iterator[Claim]:
    """Check Figure 3.3: λ = 0.5."""
    for l, overlap in ((0.0, False), (0.1, True), (0.5, True)):
        yield claim(
            f"3.3-overlap-{l:g}",
            "Figure 3.3",
            f"λ = 0.5, l = {l:g}: the windows of 3 and 4 overlap",
            overlap,
            windows_overlap(3, 0.5, l),
        )
    low, high = float(mu_bc(4, 0.5, 0.0)), float(mu_pd(3, 0.5, 0.0))
    P = gap_map(0.5, 0.5 * (low + high), 0.0)
    yield claim(
        "3.3-chaos",
        "Figure 3.3",
        "l = 0: chaos separates them, no start finds a period and the exponent is positive",
        [[""], True],
        [sorted(words(P, 64, 4000)), exponent(P) > 0.0],
        note=f"at μ = {P.params['mu']:.6f}, Lyapunov exponent {exponent(P):.4f}",
    )
    low, high = float(mu_pd(3, 0.5, 0.1)), float(mu_bc(4, 0.5, 0.1))
    P = gap_map(0.5, 0.5 * (low + high), 0.1)
    yield claim(
        "3.3-coexist",
        "Figure 3.3",
        "l = 0.1: orbits of periods 3 and 4 coexist",
        ["0001", "001"],
        sorted(words(P, 256, 4000)),
        note=f"words of 256 random starts at μ = {P.params['mu']:.6f}; 0 is L, 1 is R",
    )
    widths = [[stability_interval(N, 0.5, l).width for l in (0.0, 0.1, 0.5)] for N in range(2, 12)]
    yield claim(
        "3.3-widths",
        "section 3",
        "the windows widen as l grows, N = 2 to 11",
        True,
        all(a < b < c for a, b, c in widths),
    )


def first_edges(run: Run) -> Iterator[Claim]:
    """Check Figure 3.4: the edges of the windows 3 and 4 at λ = 0.5."""
    meet = run.figure("3.4")["meet"][(3, 4)]
    yield claim(
        "3.4-meet",
        "section 3",
        "λ = 0.5: periods 3 and 4 coexist from l ≈",
        "0.05",
        meet,
        slip=4,
        note="0.05859375 exactly",
    )
    yield claim("3.4-meet-exact", "reference", "the same", "0.05859375", meet)
    drawn = sorted(run.figure("3.4")["edges"])
    yield claim(
        "3.4-names",
        "section 3",
        "the intersection whose size is read off Figure 3.4 is Ω2 ∩ Ω3",
        [2, 3],
        drawn,
        slip=5,
        note="the figure shows Ω3 and Ω4; 2 and 3 meet at l = 0.046875",
    )
    gap = float(mu_bc(3, 0.5, meet) - mu_bc(4, 0.5, meet))
    yield claim(
        "3.4-distance",
        "section 3",
        "coexistence is measured by the distance of μ_BC,4 from μ_BC,3, which is then 0 at its onset",
        0,
        gap,
        tolerance=1e-12,
        slip=5,
        note="it is measured by μ_BC,4 − μ_PD,3",
    )
    yield claim(
        "3.4-distance-right",
        "section 3",
        "μ_BC,4 − μ_PD,3 is 0 at the onset",
        0,
        float(mu_bc(4, 0.5, meet) - mu_pd(3, 0.5, meet)),
        tolerance=1e-15,
    )
    l = np.linspace(meet, 2.0, 200)
    yield claim(
        "3.4-grows",
        "section 3",
        "and grows with l from there",
        True,
        bool((np.diff(np.asarray(mu_bc(4, 0.5, l)) - np.asarray(mu_pd(3, 0.5, l))) > 0).all()),
    )


GROUPS = (
    (("3.1",), cobweb),
    (("3.2",), maximal_only),
    (("3.3",), first_gaps),
    (("3.4",), first_edges),
)
