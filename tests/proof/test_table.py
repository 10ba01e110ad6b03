"""Orbits on tables are proven, and what is no orbit is not."""

import math

import numpy as np
import pytest
from flint import arb

import grazing as gz
from grazing.orbits.bounces import Bounces, solid_surfaces
from grazing.proof.table import described, part_of
from grazing_checker.balls import precision
from grazing_checker.table import Table
from tests.billiard.orbits import active_discs, bowl, in_a_row, pinball
from tests.billiard.tables import ELASTIC, mixed, three_discs


def orbits(table, periods, **more):
    return gz.periodic_orbits(gz.collision_map(table), periods, starts=200, **more)


def test_all_cycles_of_three_discs_to_length_six_are_proven_unstable():
    found = orbits(three_discs(6.0), range(2, 7))
    assert len(found) == 23
    for orbit in found:
        proof = gz.certify(orbit)
        assert proof.proven and not proof.reason and proof.claims["stability"] == "unstable"
        assert gz.check_certificate(proof.document) == proof.statement
        low, high = map(float, proof.claims["time"])
        assert low <= orbit.time * (1 + 1e-14) and orbit.time * (1 - 1e-14) <= high and high - low < 1e-12
        (sums,) = proof.claims["sums"]
        assert float(sums[0]) == pytest.approx(orbit.transverse.sum().real, rel=1e-12)
        assert proof.claims["least_period"] and float(proof.claims["apart"][0]) > 1e-3


def test_orbits_of_an_active_table_are_proven():
    """Kicked by bumpers, over walls that take energy, with gravity: fourteen words to three impacts."""
    found = orbits(pinball(), range(1, 4))
    proofs = [gz.certify(orbit) for orbit in found]
    assert len(found) >= 10 and all(proof.proven for proof in proofs)
    for orbit, proof in zip(found, proofs, strict=True):
        assert gz.check_certificate(proof.document) == proof.statement
        a, b, c = (float(low) for low, _high in proof.claims["sums"])
        roots = orbit.multipliers
        pairs = roots[0] * roots[1] + roots[1] * roots[2] + roots[2] * roots[0]
        np.testing.assert_allclose([a, b, c], np.real([roots.sum(), pairs, roots.prod()]), rtol=1e-10)


def test_stable_and_neutral_orbits_are_told_apart():
    """Two bounces in a bowl attract; one at its bottom has multipliers on the unit circle."""
    stable = next(one for one in orbits(bowl(r=0.8), 2) if one.stable)
    assert gz.certify(stable).claims["stability"] == "stable"
    neutral = next(one for one in orbits(bowl(), 1) if one.neutral)
    proof = gz.certify(neutral)
    assert proof.proven and proof.claims["stability"] == "undecided" and "on the unit circle" in proof.reason
    assert "nothing is claimed of its stability" in proof.statement and repr(proof).endswith("stability undecided>")


def test_the_statement_says_the_table_and_the_orbit():
    proof = gz.certify(orbits(active_discs(3.0), 2)[0])
    said = proof.statement
    for part in ('the disc "A" (x = 0.0, y = 0.0, radius = 1.0)', "p.r = 0.8, p.V = 0.25", 'hits "A", "B"',
                 "in this order", "meets nothing else", "of least period 2 impacts", "asymptotically" * 0,
                 "unstable"):  # fmt: skip
        assert part in said or any(part.replace('"A", "B"', order) in said for order in ('"B", "A"',))
    energy = gz.certify(orbits(three_discs(6.0), 2)[0]).statement
    assert "with the energy 0.5 for a mass of 1" in energy


def test_what_is_no_orbit_or_one_of_a_family_is_not_proven():
    (virtual,) = gz.periodic_orbits(gz.collision_map(in_a_row(0.5)), word="AC")
    proof = gz.certify(virtual)
    assert not proof.proven and "virtual" in proof.reason and proof.document is None
    touching, _other = sorted(orbits(in_a_row(0.5), 2), key=lambda one: one.word)
    assert gz.certify(touching).proven  # between A and B, beside C

    named = gz.table([gz.disc(name, (x, 0.0), 1.0, ELASTIC) for name, x in (("\u0391", 0.0), ("B", 6.0))])
    assert "cannot be called" in gz.certify(orbits(named, 2)[0]).reason


def power(v, p):
    return 0.9 * (-v) ** 0.9 + 0.2


def rooted(v, p):
    return 0.9 * math.sqrt(-v) + 0.2


def test_laws_of_ones_own_are_proven_if_they_are_expressions():
    """Neither needs to be defined for v > 0, of which Newton's method asks on its way."""
    for law, said in ((power, ""), (rooted, "cannot be written as an expression")):
        discs = [gz.disc(name, (x, 0.0), 1.0, gz.reset(law)) for name, x in (("A", 0.0), ("B", 4.0))]
        found = orbits(gz.table(discs), 2)
        assert [one.word for one in found] == ["AB"]
        proof = gz.certify(found[0])
        assert proof.proven is not bool(said) and said in proof.reason
        assert not proof.proven or "0.9*(-v)^0.9 + 0.2" in proof.statement


@pytest.mark.parametrize("tilt", [0.0, 0.4])
@pytest.mark.parametrize("energy", [None, 3.0])
def test_the_checkers_equations_are_those_of_the_search(energy, tilt):
    """On every kind of part: left and right of a segment, ends, discs, both sides of an arc."""
    table = mixed(0.1, tilt)
    surfaces = solid_surfaces(table)
    chosen = [surfaces[k] for k in (0, -1, 9, -3, 8, 14, -2, 16)]
    chosen = [s for s in chosen if energy is None or gz.table([table.objects[s.owner]]).objects[0].law(-1.0) == 1.0]
    bounces = Bounces(table, chosen, energy)
    orbit = orbits(three_discs(6.0), 2)[0]
    data = described(orbit) | {"centre": [], "radius": [], "unique": [], "preconditioner": [], "claims": {}}
    data |= {"tilt": float(tilt).hex(), "rho": (0.1).hex(), "g": (1.0).hex()}
    from grazing.proof.table import _object

    data["objects"] = [_object(one, [1.0]) for one in table.objects]
    data["impacts"] = [[table.names[s.owner], part_of(table.objects[s.owner], s)] for s in chosen]
    data["energy"] = None if energy is None else energy.hex()
    x = np.random.default_rng(2).uniform(0.3, 1.2, 2 * len(chosen))
    F, J = bounces.defects(x[None])
    with precision(128):
        checker = Table(data)
        point = [arb(one) for one in x.tolist()]
        np.testing.assert_allclose([float(one) for one in checker.defect(point)], F[0], atol=1e-12)
        rows = [[float(one) for one in row] for row in checker.derivative(point)]
    np.testing.assert_allclose(rows, J[0], atol=1e-11 * np.abs(J).max())
