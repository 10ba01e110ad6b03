"""Proposition 3.2 and Figure 3.7: windows of large period."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from grazing.paper.claims import Claim, claim
from grazing.paper.claims_propositions import iterated
from grazing.paper.run import Run
from grazing.theory.asymptotics import mu_bc_leading, mu_pd_leading, width_ratio
from grazing.theory.edges import mu_bc, mu_pd
from grazing.theory.regimes import last_window
from grazing.theory.windows import stability_interval


def ordering(run: Run) -> Iterator[Claim]:
    """Check the note after Proposition 3.1: the order of the edges."""
    good = True
    for lam in (0.1, 0.34, 0.5, 0.7, 0.9, 0.97):
        for l in (0.0, 0.05, 0.4, 0.8, 2.0):
            for edge in (mu_pd, mu_bc):
                good &= bool((np.diff(np.asarray(edge(np.arange(2, 40), lam, l))) < 0.0).all())
    yield claim(
        "note-order", "section 3", "both edges fall as N grows, N = 2 to 39", True, good, note="30 pairs (λ, l)"
    )


def large_periods(run: Run) -> Iterator[Claim]:
    """Check Proposition 3.2."""
    yield claim(
        "prop2-i",
        "reference",
        "l = 0, λ > 2/3: no stable maximal orbit for large N; last N with a window at λ = 0.7, 0.8, 0.9",
        [6, 4, 3],
        [last_window(lam) for lam in (0.7, 0.8, 0.9)],
        note="values of the project; the proposition says that there is a last one",
    )
    yield claim(
        "prop2-i-exists",
        "Proposition 3.2 (i)",
        "l = 0, λ > 2/3: no period-N orbit exists at all for large N",
        "0",
        unstable_orbits(),
        slip=12,
        note="unstable ones do, for every N: found at λ = 0.9 for N = 4 to 23; the proposition is about stable ones",
    )
    yield claim(
        "prop2-ii",
        "Proposition 3.2 (ii)",
        "l > 0: windows for all large N, N = 200 to 400, λ = 0.3 to 0.95, l = 0.01 to 1",
        True,
        all(
            not stability_interval(N, lam, l).empty
            for N in range(200, 401, 20)
            for lam in (0.3, 0.5, 0.8, 0.95)
            for l in (0.01, 0.1, 1.0)
        ),
    )
    for l, N in ((0.0, 60), (0.8, 200)):
        pd = float(mu_pd(N, 0.9, l)) / float(mu_pd_leading(N, 0.9, l))
        bc = float(mu_bc(N, 0.9, l)) / float(mu_bc_leading(N, 0.9, l))
        yield claim(
            f"prop2-leading-{l:g}",
            "Proposition 3.2, proof",
            f"leading order of both edges, l = {l:g}: ratio to the exact value at N = {N}, λ = 0.9",
            [1, 1],
            [pd, bc],
            tolerance=0.01,
        )
    chain = float(mu_bc(201, 0.9, 0.8)) / float(mu_pd(200, 0.9, 0.8))
    yield claim(
        "3.1-chain",
        "(3.1)",
        "μ_BC,N+1 ≈ μ_PD,N: ratio at N = 200",
        "1",
        chain,
        tolerance=1e-3,
        note="λ = 0.9, l = 0.8; at N = 20 the ratio is "
        + f"{float(mu_bc(21, 0.9, 0.8)) / float(mu_pd(20, 0.9, 0.8)):.4f}",
    )


def unstable_orbits() -> int:
    """Return for how many N from 4 to 23 the gap map with λ = 0.9, l = 0 has an unstable orbit L^(N-1) R."""
    count = 0
    for N in range(4, 24):
        mu = 0.5 * float(mu_bc(N, 0.9, 0.0))
        x = iterated(N, 0.9, mu, 0.0)
        count += x.multiplier < -1.0
    return count


def scaling(run: Run) -> Iterator[Claim]:
    """Check Figure 3.7."""
    data = run.figure("3.7")
    ratios = data["ratios"]
    yield claim(
        "3.7-ratio",
        "Figure 3.7",
        "windows shrink by the factor λ as N grows: ratio of widths at N = 200",
        "0.9",
        width_ratio(200, 0.9, 0.8),
        tolerance=1e-3,
        note="the limit is reached slowly: " + ", ".join(f"{ratios[N]:.4f} at N = {N}" for N in (10, 20, 40, 80)),
    )
    diagram = data["diagram"]
    wrong, seen, mu = 0, 0, diagram["mu"].values
    for i in range(mu.size):
        periods = set(diagram["period"].values[i].tolist())
        for N, (low, high) in data["windows"].items():
            width = high - low
            if low + 0.15 * width < mu[i] < high - 0.15 * width:
                seen += 1
                wrong += N not in periods
    yield claim(
        "3.7-windows",
        "Figure 3.7",
        "inside each window random starts find its orbit: values of μ where none does",
        "0",
        wrong,
        note=f"{seen} pairs of μ and window, the outer 15 % of each window left out",
    )
    top = max(int(p) for p in np.unique(diagram["period"].values))
    yield claim(
        "3.7-high",
        "Figure 3.7",
        "orbits of high period are found, above N = 20",
        True,
        top > 20,
        note=f"highest period found {top}",
    )


GROUPS = (
    (("3.6", "3.7"), ordering),
    (("3.6", "3.7"), large_periods),
    (("3.7",), scaling),
)
