"""Claims of section 2.2: the change of coordinates and the reduction to the gap map (2.6)."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from grazing.maps.map import Map
from grazing.maps.stroboscopic import stroboscopic_map
from grazing.paper.claims import Claim, claim
from grazing.paper.run import Run


def reduction(run: Run) -> Iterator[Claim]:
    """Check the change of coordinates and the reduction to (2.6)."""
    nf = run.normal_form(0.4)
    yield claim("2.6-lambda", "Figure 3.2", "λ = a + d for ω = 2.2, α = 3", "0.34", nf.lam, note="trace of e^(BT)")
    for V, right in ((0.2, "0.324676"), (0.4, "0.649353")):
        own = run.normal_form(V)
        yield claim(
            f"3.2-l-{V:g}",
            "Figure 3.2",
            f"l for V = {V:g}, r = 0.8 and the acceleration at the graze",
            "0.21",
            own.l,
            slip=6,
            note="A = ω²a = 0.633855 at the graze; the printed value follows from A = |cos(1.4ω)|, no "
            "acceleration at a graze",
        )
        yield claim(f"3.2-l-right-{V:g}", "reference", f"l of the set S for V = {V:g}", right, own.l)
    yield claim("2.6-acceleration", "reference", "acceleration at the graze, ω²a", "0.633855", nf.acceleration)
    wrong = 0.2 / (2.0 * abs(math.cos(2.2 * 1.4)) * nf.b * (1.0 + nf.r) ** 2)
    yield claim("3.2-l-origin", "Figure 3.2", "the printed l follows from A = |cos(ω t0)| with t0 = 1.4", "0.21", wrong)
    yield claim(
        "2.6-proportional", "section 1", "l is proportional to V", "2", nf.l / run.normal_form(0.2).l, tolerance=1e-12
    )
    yield claim(
        "2.6-passive", "section 2.2", "without a bumper there is no gap: l", "0", run.normal_form(0.0).l, tolerance=0.0
    )
    defect, square = image_defect(run)
    yield claim(
        "2.6-image",
        "section 2.2",
        "the map in (x, y) equals (2.1): largest defect in x",
        "0.000000",
        defect,
        slip=9,
        note="it keeps a v² of the start and drops v² of the image: exact to second order in v only",
    )
    yield claim(
        "2.6-image-right",
        "section 2.2",
        "the defect is v² of the image less a v² of the start",
        0,
        square,
        tolerance=1e-12,
    )
    drop = nf.lam * 0.25
    G, Q = nf.gap_map(nf.graze - 1e-3), nf.xy_map(nf.graze - 1e-3)
    kept = float(Q((0.25 * nf.scale, 0.0))[0][0] / nf.scale - G((0.25,))[0][0])
    yield claim(
        "2.6-dropped",
        "(2.6)",
        "for x ≥ 0 the one-dimensional map keeps all terms but those in y",
        0,
        kept,
        tolerance=1e-12,
        slip=9,
        note=f"it drops λx as well, {drop:.6f} at x = 0.25, which the two-dimensional map keeps",
    )


def image_defect(run: Run) -> tuple[float, float]:
    """Return the defect of the (x, y) map in x for free flights, and what its closed form leaves of it."""
    nf = run.normal_form(0.4)
    model = nf.model
    phase = nf.time
    P: Map = stroboscopic_map(model, phase=phase)
    starts = np.array([[0.3, 0.02], [0.25, -0.05], [0.2, 0.05]])
    images = np.array([P(s)[0] for s in starts])
    x, y = nf.to_xy(starts).T
    predicted = nf.lam * x + y + nf.scale * nf.mu(nf.graze)
    actual = nf.to_xy(images)[:, 0]
    defect = actual - predicted
    return float(np.abs(defect).max()), float(
        np.abs(defect - (images[:, 1] ** 2 - nf.entries[0] * starts[:, 1] ** 2)).max()
    )


GROUPS = ((("3.2",), reduction),)
