"""True certificates of every kind, cheap to make, from which others are forged."""

from functools import cache

import grazing as gz
from grazing.proof.enclose import enclose
from grazing.proof.gap import certify_gap_edge, certify_gap_orbit
from grazing.proof.gap_chaos import prove_no_attractor
from tests.billiard.orbits import active_discs, beside_a_tip, bowl, bowl_and_disc, pinball, posted
from tests.billiard.tables import ELASTIC, three_discs
from tests.grazing_checker.documents import documents

KINDS = (
    "periodic orbit",
    "periodic orbit with walls",
    "periodic orbit on a table",
    "bifurcation value",
    "bifurcation value with walls",
    "bifurcation value on a table",
    "gap map orbit",
    "gap map edge",
    "gap map without attracting orbits",
)

GAP_NAMES = (
    "R", "LLR", "LLRLR", "LLRLLR", "LLRR", "gap pd", "gap bc", "gap gr", "gap lp", "gap bc of two", "gap pd of R",
    "small", "between", "narrow",
)  # fmt: skip
TABLE_NAMES = (
    "back and forth", "triangle", "kicked", "kicked and lit", "by the ceiling", "in the bowl", "on the tip",
    "up and down",
)  # fmt: skip
TABLE_VALUE_NAMES = ("bowl pd", "bowl lp", "bowl ns", "post gr", "tip gr", "elastic pd")


@cache
def bases():
    """Return documents by name."""
    return {**documents(), **gap_bases(), **table_bases(), **table_value_bases()}


@cache
def table_bases():
    """Return documents about orbits on tables by name."""

    def of(table, word, **more):
        return [
            one for one in gz.periodic_orbits(gz.collision_map(table), word=word, starts=100, **more) if one.admissible
        ]

    two = [gz.disc("low", (0, 0), 1.0, ELASTIC), gz.disc("high", (0, 4), 1.0, ELASTIC)]
    found = {
        "back and forth": of(three_discs(6.0), "AB")[0],
        "triangle": of(three_discs(3.0), "ABC")[0],
        "kicked": of(active_discs(3.0), "ABC")[0],
        "kicked and lit": of(active_discs(3.0), "ABAC")[0],
        "by the ceiling": of(pinball(), "PQ(ceiling)")[0],
        "in the bowl": next(one for one in of(bowl(r=0.8), "(bowl)", period=2) if one.stable),
        "on the tip": next(one for one in of(bowl(rho=0.1), "(bowl)") if not one.neutral),
        "up and down": of(gz.table(two, tilt=0.3), "(low)(high)", energy=3.0)[0],
    }
    assert tuple(found) == TABLE_NAMES
    return {name: gz.certify(orbit).document for name, orbit in found.items()}


@cache
def table_value_bases():
    """Return documents about bifurcations of orbits on tables by name."""

    def of(table, word, **more):
        return gz.periodic_orbits(gz.collision_map(table), word=word, starts=20, **more)

    points = {
        "bowl pd": (of(bowl(r=0.78), "(bowl)")[0], "pd", "bowl.r"),
        "bowl lp": (of(bowl(r=0.8, V=0.262), "(bowl)", period=3)[0], "lp", "bowl.V"),
        "bowl ns": (of(bowl_and_disc(r=0.79427), "(bowl)A")[1], "ns", "bowl.r"),
        "post gr": (of(posted(0.69), "ABC")[0], "gr", "post.y"),
        "tip gr": (of(beside_a_tip(-0.85), "(bowl)", period=3)[1], "gr", "wire.y2"),
        "elastic pd": (of(bowl(radius=1.9, r=1.0, V=0.0), "(bowl)", energy=-1.0)[0], "pd", "bowl.radius"),
    }
    assert tuple(points) == TABLE_VALUE_NAMES
    return {name: enclose(*point).document for name, point in points.items()}


@cache
def gap_bases():
    """Return documents about the gap map by name."""
    proofs = {
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
    assert tuple(proofs) == GAP_NAMES
    for name, one in proofs.items():
        assert one.document is not None, f"{name}: {one.statement}"
    return {name: one.document for name, one in proofs.items()}
