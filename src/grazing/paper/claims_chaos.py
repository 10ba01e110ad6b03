"""Claims of section 3 on Figures 3.5 and 3.6 and on chaos: the regimes at l = 0, the trapping interval."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from grazing.maps.gap import gap_map
from grazing.paper.claims import Claim, claim
from grazing.paper.lyapunov import exponent
from grazing.paper.run import Run
from grazing.paper.settle import words
from grazing.theory.edges import mu_bc, mu_pd
from grazing.theory.regimes import lam_overlap, robust_chaos
from grazing.theory.thresholds import l_all
from grazing.theory.trapping import trapping_interval
from grazing.theory.windows import existence_interval, overlapping, stability_interval, windows_overlap


def second_gaps(run: Run) -> Iterator[Claim]:
    """Check Figures 3.5 and 3.6: λ = 0.9."""
    pd, bc = float(mu_pd(3, 0.9, 0.0)), float(mu_bc(3, 0.9, 0.0))
    yield claim(
        "3.6-pd3", "section 3", "λ = 0.9, l = 0: μ_PD,3 ≈", "0.17", pd, slip=3, note="by the paper's own formula"
    )
    yield claim("3.6-pd3-right", "reference", "the same", "0.181577", pd)
    yield claim("3.6-bc3", "section 3", "λ = 0.9, l = 0: μ_BC,3 ≈", "0.22", bc)
    yield claim("3.6-bc3-exact", "reference", "the same", "0.224377", bc)
    yield claim(
        "3.6-none",
        "section 3",
        "l = 0: periods 4 and 5 have no window",
        [True, True],
        [stability_interval(N, 0.9, 0.0).empty for N in (4, 5)],
    )
    data = run.figure("3.6")
    yield claim("3.6-exist4", "section 3", "period 4 exists (is stable) for l >", "0.08", data["appear"][4])
    yield claim("3.6-exist4-exact", "reference", "the same", "0.0800077500", data["appear"][4])
    yield claim("3.6-exist5", "section 3", "period 5 exists (is stable) for l >", "0.19", data["appear"][5], slip=4)
    yield claim("3.6-exist5-right", "reference", "the same", "0.1796237775", data["appear"][5])
    yield claim("3.6-meet", "reference", "3 and 4 coexist from l", "0.62724375", data["meet"][(3, 4)])
    yield claim(
        "3.6-meet-text",
        "section 3",
        "the windows of 3 and 4 intersect at l = 0.4, at l = 0.9",
        [False, True],
        [windows_overlap(3, 0.9, l) for l in (0.4, 0.9)],
    )
    yield claim(
        "3.6-order",
        "Figure 3.6",
        "at l = 0: μ_BC,5 < μ_BC,4 < μ_BC,3 and μ_PD,5 < μ_PD,4 < μ_PD,3",
        [True, True],
        [bool((np.diff([float(edge(N, 0.9, 0.0)) for N in (3, 4, 5)]) < 0).all()) for edge in (mu_bc, mu_pd)],
    )
    worst = l_all(0.9)
    yield claim("3.5-every", "reference", "every N has a window for l >", "0.340273", worst.l)
    yield claim("3.5-every-N", "reference", "the last to get one is N =", "10", worst.N)
    yield claim(
        "3.5-exists",
        "section 3",
        "no orbit of period 4 exists at l = 0",
        True,
        existence_interval(4, 0.9, 0.0).empty,
        slip=12,
        note="it exists, unstable, between its graze and its border collision: 'exists' means 'is stable'",
    )


def chaos(run: Run) -> Iterator[Claim]:
    """Check robust chaos at l = 0, λ = 0.9."""
    span = robust_chaos(0.9)
    grid = np.linspace(0.002, 0.999 * span.high, 12)
    maps = [gap_map(0.9, float(mu), 0.0) for mu in grid]
    yield claim(
        "3.5-robust",
        "Figure 3.5",
        "l = 0: no stable periodic orbit for 0 < μ < μ_PD,3: words found",
        [""],
        sorted(set().union(*(words(P, 32, 6000) for P in maps))),
        note=f"12 values of μ up to {span.high:.6f}",
    )
    least = min(exponent(P) for P in maps)
    yield claim(
        "3.5-exponent",
        "Figure 3.5",
        "the Lyapunov exponent is positive there",
        True,
        least > 0.0,
        note=f"least of 12: {least:.4f}",
    )
    first = gap_map(0.9, 0.5 * (float(mu_pd(3, 0.9, 0.0)) + float(mu_bc(3, 0.9, 0.0))), 0.0)
    yield claim(
        "3.5-first", "section 3", "the first window is that of period 3", ["001"], sorted(words(first, 64, 4000))
    )
    sizes = [
        float(np.ptp(gap_map(0.9, float(mu), 0.0).iterate((-0.01,), 4000)[2000:, 0])) for mu in np.logspace(-8, -3, 11)
    ]
    slope = float(np.polyfit(np.linspace(-8, -3, 11), np.log10(sizes), 1)[0])
    yield claim(
        "3.5-continuous",
        "section 3",
        "l = 0: the jump to chaos is continuous, the attractor grows with exponent",
        "0.5",
        slope,
        tolerance=0.02,
    )


def overlaps(run: Run) -> Iterator[Claim]:
    """Check where chaos and where overlap lies for l > 0, λ = 0.9."""
    yield claim(
        "3.5-where",
        "section 3",
        "λ = 0.9, l = 0.4: windows overlap at large μ only, chaos lies between them at small μ; N ≤ 40 that "
        "overlap N + 1",
        [1, 2],
        overlapping(0.9, 0.4, 40),
        slip=11,
        note="for every l > 0 all windows of large enough N overlap: chaos between them is left at moderate N only",
    )
    low, high = float(mu_pd(40, 0.9, 0.4)), float(mu_bc(41, 0.9, 0.4))
    P = gap_map(0.9, 0.5 * (low + high), 0.4)
    lengths = sorted(len(w) for w in words(P, 200, 20_000, longest=60))
    yield claim(
        "3.5-where-iterated", "reference", "the same by iteration: periods found in Ω40 ∩ Ω41", [40, 41], lengths
    )
    moderate = gap_map(0.9, 0.5 * (float(mu_bc(8, 0.9, 0.4)) + float(mu_pd(7, 0.9, 0.4))), 0.4)
    yield claim(
        "3.5-moderate",
        "Figure 3.5",
        "chaos between the windows of 8 and 7",
        [""],
        sorted(words(moderate, 64, 6000)),
        note="λ = 0.9, l = 0.4",
    )
    yield claim(
        "3.5-overlap",
        "reference",
        "λ = 0.9, l = 0.8: N ≤ 18 that overlap N + 1",
        [1, 2, 3, 16, 17, 18],
        overlapping(0.9, 0.8, 18),
    )


def no_gap(run: Run) -> Iterator[Claim]:
    """Check the three regimes at l = 0."""
    meet = {N: lam_overlap(N) for N in (1, 2, 3)}
    yield claim(
        "l0-disjoint",
        "section 3",
        "l = 0, 1/4 < λ < 2/3: windows do not intersect; number of N ≤ 20 that meet N + 1 at λ = 0.3",
        "0",
        len(overlapping(0.3, 0.0, 20)),
        slip=10,
        note=f"1 and 2 always meet, 2 and 3 for λ < {meet[2]:.6f}, 3 and 4 for λ < {meet[3]:.5f}; 1/4 is the "
        f"limit of large N",
    )
    P = gap_map(0.3, 0.5 * (float(mu_pd(2, 0.3, 0.0)) + float(mu_bc(3, 0.3, 0.0))), 0.0)
    yield claim(
        "l0-meet-2-3",
        "reference",
        "by iteration, λ = 0.3: words in Ω2 ∩ Ω3",
        ["001", "01"],
        sorted(words(P, 256, 4000)),
    )
    yield claim("l0-lam-2", "reference", "2 and 3 meet for λ <", "0.33333", meet[2])
    yield claim("l0-lam-3", "reference", "3 and 4 meet for λ <", "0.26376", meet[3])
    yield claim("l0-lam-limit", "section 3", "the bound for large N", "0.25", lam_overlap(400), tolerance=1e-6)
    yield claim(
        "l0-overlap",
        "section 3",
        "λ < 1/4: neighbouring windows intersect, N = 1 to 60, λ = 0.05 to 0.24",
        True,
        all(windows_overlap(N, lam, 0.0) for N in range(1, 61) for lam in (0.05, 0.1, 0.15, 0.2, 0.24)),
    )
    yield claim(
        "l0-exist",
        "section 3",
        "λ < 2/3: every N has a window, N = 1 to 60",
        True,
        all(not stability_interval(N, lam, 0.0).empty for N in range(1, 61) for lam in (0.3, 0.5, 0.66)),
    )


def trapping(run: Run) -> Iterator[Claim]:
    """Check the trapping interval and what happens at the graze."""
    outside = 0.0
    for lam, mu, l in ((0.5, 0.1, 0.3), (0.9, 0.2, 0.4), (0.34, 0.05, 0.21), (0.8, 0.5, 1.0), (0.9, 0.1, 0.0)):
        low, high = trapping_interval(mu, l)
        x = np.linspace(low, high, 4001).reshape(1, -1).copy()
        gap_map(lam, mu, l).run(x, 1, 0)
        outside = max(outside, low - float(x.min()), float(x.max()) - high)
    yield claim(
        "trap",
        "section 3",
        "[−√μ + μ − l, μ] is taken into itself: farthest image outside",
        0,
        max(outside, 0.0),
        tolerance=1e-15,
        note="4001 points for five (λ, μ, l)",
    )
    x = gap_map(0.9, 0.0, 0.4).iterate((-0.3,), 3000)[-1, 0]
    yield claim(
        "trap-attractor",
        "section 3",
        "μ = 0: the attractor is [−l, 0], of size",
        "0.4",
        float(abs(x)),
        slip=12,
        note="every orbit climbs to 0 from below, its limit set is {0}: the interval is the trapping interval. λ "
        "= 0.9, l = 0.4",
    )
    yield claim(
        "fixed-point",
        "section 3",
        "μ < 0: one fixed point attracts, μ/(1 − λ)",
        -0.5,
        float(gap_map(0.9, -0.05, 0.4).iterate((0.3,), 3000)[-1, 0]),
        tolerance=1e-12,
    )
    near = [float(np.ptp(gap_map(0.9, mu, 0.4).iterate((-0.1,), 9000)[6000:, 0])) for mu in (1e-6, 1e-8)]
    yield claim(
        "trap-jump",
        "section 3",
        "l > 0: the attractor jumps to the size l at the graze",
        "0.4",
        near[1],
        tolerance=0.01,
        note="λ = 0.9, l = 0.4, μ = 1e-8",
    )


GROUPS = (
    (("3.6",), second_gaps),
    (("3.5",), chaos),
    (("3.5",), overlaps),
    (("3.3", "3.5"), no_gap),
    (("3.3", "3.5"), trapping),
)
