"""Exact windows of the full oscillator beside those that the normal form predicts."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import Any

from grazing.maps.stroboscopic import stroboscopic_map
from grazing.outcome import OutsideForm
from grazing.paper.claims import Claim, claim
from grazing.paper.run import Run
from grazing.paper.settle import words
from grazing.theory.edges import mu_bc, mu_pd

#: Edges in d of the set S with V = 0.4, recomputed by two independent routes.
REFERENCE = {
    1: (None, "-0.001093712885170"),
    2: ("0.007144192787102", "0.103087550966506"),
    3: ("0.098450444937096", "0.123281449643921"),
    4: ("0.121919639750295", "0.128580715549025"),
    5: ("0.128264386287936", "0.130184992541112"),
    6: ("0.130117517248798", "0.130703521954424"),
    7: ("0.130689714696606", "0.130875382579699"),
}
PREDICTED = {
    1: (None, "-0.063818"),
    2: ("-0.161022", "0.0993620152"),
    3: ("0.0889539502", "0.1229797662"),
    4: ("0.120993751428", "0.128545621172"),
    5: ("0.128139975581", "0.130178331572"),
    6: ("0.130095981315", "0.130701523177"),
    7: ("0.130685021777", "0.130874639682"),
}


def table(run: Run) -> list[dict[str, Any]]:
    """Return exact and predicted edges with their errors, one row per N from 1 to 7, for S and V = 0.4."""
    return run.once("window table", lambda: _table(run))


def _table(run: Run) -> list[dict[str, Any]]:
    nf, exact = run.normal_form(0.4), run.windows(0.4)
    rows = []
    for N in range(1, 8):
        edges = {"upper": float(mu_pd(N, nf.lam, nf.l)), "lower": float(mu_bc(N, nf.lam, nf.l)) if N > 1 else None}
        predicted = {}
        for side, mu in edges.items():
            try:
                predicted[side] = nf.parameter(mu) if mu is not None else None
            except OutsideForm:
                predicted[side] = None
        low, high = exact.get(N, (None, None))
        if N == 1:
            low = None  # no lower edge: the orbit is followed to the end of the span
        rows.append(
            {
                "N": N,
                "exact": [low, high],
                "predicted": [predicted["lower"], predicted["upper"]],
                "error": [difference(predicted["lower"], low), difference(predicted["upper"], high)],
            }
        )
    return rows


def difference(a: float | None, b: float | None) -> float | None:
    """Return a - b, None where one is missing."""
    return None if a is None or b is None else a - b


def windows_of_flow(run: Run) -> Iterator[Claim]:
    """Check the exact windows and those of the normal form against values recomputed by two independent routes."""
    rows = table(run)
    for row in rows:
        N = row["N"]
        for i, (side, kind) in enumerate((("lower", "graze"), ("upper", "period doubling"))):
            wanted = REFERENCE[N][i]
            if wanted is not None:
                yield claim(
                    f"S-{N}-{side}",
                    "Figure 1.6 (reference)",
                    f"exact {side} edge of Ω{N}, {kind}: d",
                    wanted,
                    row["exact"][i],
                    tolerance=1e-13,
                )
                yield claim(
                    f"S-{N}-{side}-predicted",
                    "Figure 1.6 (reference)",
                    "the normal form predicts d",
                    PREDICTED[N][i],
                    row["predicted"][i],
                    note=f"error {row['error'][i]:+.3e}",
                )


def reduction_against_flow(run: Run) -> Iterator[Claim]:
    """Check the types of the edges, the errors of the reduction, and the windows by random starts."""
    rows, table_of = table(run), run.window_table(0.4)
    types = {
        (str(low), str(high))
        for N, low, high in zip(*(table_of[k].values for k in ("N", "low_type", "high_type")), strict=True)
        if N > 1
    }
    yield claim(
        "S-types",
        "Figure 1.6 (reference)",
        "every window from N = 2 on ends in a graze (gr) below and a period doubling (pd) above",
        ["gr", "pd"],
        sorted(set().union(*types)),
        note="N = 2 to 11; the lower edge of Ω1 lies below d = −0.1",
    )
    upper = [abs(row["error"][1]) for row in rows]
    lower = [abs(row["error"][0]) for row in rows[1:]]
    yield claim(
        "S-errors",
        "section 2.2",
        "the error of the reduction falls as N grows, both edges",
        [True, True],
        [all(a > b for a, b in pairwise(e)) for e in (lower, upper)],
        note="upper edges: " + ", ".join(f"{e:.1e}" for e in upper),
    )
    yield claim(
        "S-1-2",
        "Figure 1.6 (reference)",
        "Ω1 and Ω2 overlap: predicted by the normal form, in the flow",
        [True, False],
        [rows[0]["predicted"][1] > rows[1]["predicted"][0], rows[0]["exact"][1] > rows[1]["exact"][0]],
        note=f"predicted {rows[1]['predicted'][0]:.4f} < {rows[0]['predicted'][1]:.4f}; exact "
        f"{rows[1]['exact'][0]:.6f} > {rows[0]['exact'][1]:.6f}: far from the graze the reduction fails",
    )
    wrong = []
    for row in rows[1:6]:
        low, high = row["exact"]
        step = 0.02 * (high - low)
        word = "0" * (row["N"] - 1) + "1"
        for d, inside in ((low - step, False), (low + step, True), (high - step, True), (high + step, False)):
            found = words(stroboscopic_map(run.standard(0.4, d=d)), 64, 3000, within=1e-8)
            if (word in found) is not inside:
                wrong.append(f"N = {row['N']}, d = {d:.8f}: {sorted(found)}")
    yield claim(
        "S-iterated",
        "Figure 1.6",
        "random starts find the orbit just inside both edges of Ω2 to Ω6 and not just outside: exceptions",
        [],
        wrong,
        note="2 % of the width from each edge",
    )


GROUPS = (
    (("1.6",), windows_of_flow),
    (("1.6",), reduction_against_flow),
)
