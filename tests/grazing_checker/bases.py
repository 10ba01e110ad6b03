"""True certificates of every kind, cheap to make, from which others are forged."""

from functools import cache

import grazing as gz
from grazing.proof.gap import certify_gap_edge, certify_gap_orbit
from grazing.proof.gap_chaos import prove_no_attractor
from tests.proof.orbits import doubled, without_impacts

KINDS = (
    "periodic orbit",
    "bifurcation value",
    "gap map orbit",
    "gap map edge",
    "gap map without attracting orbits",
)


@cache
def bases():
    """Return documents by name."""
    return {**oscillator_bases(), **gap_bases()}


@cache
def oscillator_bases():
    """Return documents about the oscillator by name."""
    model = gz.pinball(d=0.12, V=0.4)
    (orbit,) = gz.one_impact_orbits(model, 3)
    (fold,) = (o for o in gz.one_impact_orbits(gz.pinball(alpha=0.2, omega=2.8, V=0.0, d=0.55), 2) if o.stable)
    (ns,) = gz.one_impact_orbits(gz.pinball(alpha=0.05, d=0.1), 1)
    return documents(
        {
            "stable": gz.certify(orbit),
            "unstable": gz.certify(doubled(model, 3, "d", 0.12328144964392065, 0.11)),
            "free": gz.certify(without_impacts(gz.pinball(d=0.14))),
            "of period 1": gz.certify(ns),
            "pd": gz.enclose(orbit, "pd", "V"),
            "gr": gz.enclose(orbit, "gr", "d"),
            "lp": gz.enclose(fold, "lp", "d"),
            "ns": gz.enclose(ns, "ns", "r"),
        }
    )


@cache
def gap_bases():
    """Return documents about the gap map by name."""
    return documents(
        {
            "R": certify_gap_orbit("R", 0.5, 0.9, 0.0),
            "LLR": certify_gap_orbit("LLR", 0.8, 0.5, 1.0),
            "LLRLR": certify_gap_orbit("LLRLR", 0.9, 0.1, 0.05),
            "LLRLLR": certify_gap_orbit("LLRLLR", 0.8, 0.4, 1.0),
            "LLRR": certify_gap_orbit("LLRR", 0.5, 0.0235, -0.6),
            "gap pd": certify_gap_edge("LLLR", "pd", 0.9, 0.4)[0],
            "gap bc": certify_gap_edge("LLR", "bc", 0.9, 0.4)[0],
            "gap gr": certify_gap_edge("LLR", "gr", 0.9, 0.4)[0],
            "gap lp": certify_gap_edge("LLRR", "lp", 0.5, -0.6)[0],
            "gap bc of two": certify_gap_edge("LLRR", "bc", 0.5, -0.6)[0],
            "gap pd of R": certify_gap_edge("R", "pd", 0.9, 0.0)[0],
            "small": prove_no_attractor(0.9, 0.0, 0.0, 0.18),
            "between": prove_no_attractor(0.9, 0.4, 0.28, 0.3),
            "narrow": prove_no_attractor(0.75, 0.0, 0.0, 0.02),
        }
    )


def documents(proofs):
    for name, one in proofs.items():
        assert one.document is not None, f"{name}: {one.statement}"
    return {name: one.document for name, one in proofs.items()}
