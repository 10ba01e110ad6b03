"""Claims of section 2.1: the flow map and the zero-time discontinuity map, Figure 2.1."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from grazing.maps.normal_form import constants
from grazing.maps.stroboscopic import stroboscopic_map
from grazing.oscillator.flight import modes
from grazing.paper.claims import Claim, claim
from grazing.paper.exact_zdm import orders, substituted
from grazing.paper.run import Run

#: A start from which the ball flies for a whole period without impact, in the set S.
FREE = (0.3, 0.0)


def flow_map(run: Run) -> Iterator[Claim]:
    """Check (2.1) and the matrix B."""
    model = run.standard(0.4)
    J = stroboscopic_map(model).jacobian(FREE)
    yield claim(
        "2.1-determinant",
        "section 2.2",
        "det e^(BT) = e^(-αT)",
        math.exp(-3.0 * model.period),
        float(np.linalg.det(J)),
        tolerance=1e-12,
        note="from the derivative of the stroboscopic map where no impact occurs",
    )
    a, b, c, d = modes(model.period, constants(model))
    yield claim(
        "2.1-linear",
        "(2.1)",
        "without impact the map is linear, its derivative e^(BT)",
        0,
        float(np.abs(J - [[a, b], [c, d]]).max()),
        tolerance=1e-12,
    )
    yield claim(
        "2.1-small",
        "section 2.2",
        "ad − bc ≈ 0",
        "0",
        math.exp(-3.0 * model.period),
        tolerance=1e-3,
        note="e^(-αT) for S",
    )
    stiff = model.replace(k=1.5)
    J = stroboscopic_map(stiff).jacobian((1.0, 0.0))
    printed = modes(model.period, constants(model))
    yield claim(
        "2.1-stiffness",
        "section 2.1",
        "B with the printed entry −1 gives the derivative of the map, largest defect",
        "0.000000",
        float(np.abs(J - np.array(printed).reshape(2, 2)).max()),
        slip=7,
        note="the entry is −k²; measured at k = 1.5, it is harmless at k = 1",
    )
    right = modes(stiff.period, constants(stiff))
    yield claim(
        "2.1-stiffness-right",
        "section 2.1",
        "the same with −k²",
        0,
        float(np.abs(J - np.array(right).reshape(2, 2)).max()),
        tolerance=1e-12,
    )


def zero_time(run: Run) -> Iterator[Claim]:
    """Check (2.2), (2.3) and Figure 2.1."""
    data = run.figure("2.1")
    four, model = data["points"], data["model"]
    U, V = four.points[:, 0], four.points[:, 1]
    r, bump = model.params["r"], model.params["V"]
    yield claim(
        "2.1-signs",
        "Figure 2.1",
        "U0 > 0, V0 < 0, δ > 0, A > 0",
        [True] * 4,
        [U[0] > 0, V[0] < 0, four.delta > 0, four.acceleration > 0],
    )
    yield claim("2.1-wall", "Figure 2.1", "U1 = U2 = 0", [0, 0], [U[1], U[2]], tolerance=1e-15)
    yield claim("2.1-reset", "section 2.1", "V2 = −r V1 + V", float(-r * V[1] + bump), V[2], tolerance=1e-15)
    yield claim(
        "2.1-law",
        "section 2.1",
        "R applies the passive law (1.2): V2 = −r V1",
        float(-r * V[1]),
        V[2],
        tolerance=1e-12,
        slip=7,
        note="R is the active law (1.3): V2 = −r V1 + V",
    )
    lowest = V[0] + bump + (1.0 + r) * math.sqrt(V[0] ** 2 - 2.0 * four.acceleration * U[0])
    yield claim(
        "2.3-V3", "section 2.1", "V3 = V0 + V + (1 + r)√(V0² − 2AU0) from (2.3)", float(lowest), V[3], tolerance=1e-14
    )
    three = substituted(model, (U[0], V[0]))
    yield claim(
        "2.2-substituted",
        "section 2.1, below (2.3)",
        "δ put into (2.2): U3 = U0 + δ((1 + r)V0 + V)",
        three["printed"],
        three["expansion"],
        tolerance=1e-12,
        slip=14,
        note="(2.2) gives U0 − δ(V + (1 + r)√(V0² − 2AU0)); harmless for the lowest order, where U3 = U0",
    )
    yield claim(
        "2.2-substituted-right",
        "section 2.1",
        "U3 = U0 − δ(V + (1 + r)√(V0² − 2AU0))",
        three["right"],
        three["expansion"],
        tolerance=1e-14,
    )
    yield claim(
        "2.1-time",
        "section 2.1",
        "δ approximates the time to the impact",
        data["hit"],
        four.delta,
        tolerance=0.05 * data["hit"],
        note=f"exact {data['hit']:.6f}: within five per cent",
    )


def error_orders(run: Run) -> Iterator[Claim]:
    """Measure the orders of the neglected terms against the exact zero-time map."""
    model, hit = run.figure("2.2")["model"], run.figure("2.2")["time"]
    how = "slope of log error against log δ, δ from 1e-4 to 1e-2, impact speed equal to δ, against the exact flow"
    jumps = "the acceleration jumps by −α(v⁺ − v⁻) at the impact, which both expansions neglect"
    near = "with an impact speed of the order of the time to the wall, as near a graze"
    found = orders(model, hit, 1.0)
    case = "V = 0.2, α = 3"
    yield claim(
        "2.3-order",
        "(2.3)",
        f"order of the error of V3, {case}",
        "2",
        found["full"][1],
        tolerance=0.1,
        slip=15,
        note=f"{jumps}; {how}",
    )
    yield claim(
        "2.2-order",
        "(2.2)",
        f"order of the error of U3, {case}",
        "3",
        found["full"][0],
        tolerance=0.1,
        slip=15,
        note=jumps,
    )
    yield claim(
        "2.4-order",
        "reference",
        f"lowest order, orders of the errors of (U3, V3), {case}",
        [1, 1],
        list(found["lowest"]),
        tolerance=0.1,
    )
    yield claim(
        "2.3-order-corrected",
        "reference",
        f"with the jump of the acceleration put in, {case}",
        [2, 2],
        list(found["corrected"]),
        tolerance=0.1,
        note="U3 stays at 2: at an impact speed of order δ the time δ is itself known to O(δ²), and U3 contains δ V2",
    )
    passive = orders(model.replace(V=0.0), hit, 1.0)
    yield claim(
        "2.3-order-passive",
        "(2.3)",
        f"order of the error of V3, V = 0, α = 3, {near}",
        "2",
        passive["full"][1],
        tolerance=0.1,
    )
    yield claim(
        "2.2-order-passive",
        "(2.2)",
        f"order of the error of U3, V = 0, α = 3, {near}",
        "3",
        passive["full"][0],
        tolerance=0.1,
    )
    yield claim(
        "2.4-order-passive",
        "reference",
        f"lowest order, V = 0, α = 3, {near}",
        [2, 2],
        list(passive["lowest"]),
        tolerance=0.1,
    )
    free = orders(model.replace(alpha=0.0), hit, 1.0)
    yield claim(
        "2.3-order-undamped",
        "(2.3)",
        "order of the error of V3, V = 0.2, α = 0",
        "2",
        free["full"][1],
        tolerance=0.1,
        note="without damping the acceleration does not jump",
    )


GROUPS = (
    (("2.2",), flow_map),
    (("2.1",), zero_time),
    (("2.2",), error_orders),
)
