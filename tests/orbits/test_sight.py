"""What is called impossible never happens: reasons in closed form, and flights that try it."""

from itertools import pairwise, product

import numpy as np
import pytest

import grazing as gz
from grazing.billiard.flown import SURFACE, flights_of
from grazing.orbits.bounces import solid_surfaces
from grazing.orbits.sight import covered, gain_of, one_at_most, one_way, unseen
from tests.billiard.orbits import active_discs, in_a_row
from tests.billiard.tables import ELASTIC, mixed, three_discs


@pytest.mark.parametrize(("rho", "tilt"), [(0.1, 0.0), (0.1, 0.5), (0.0, 0.0), (0.0, 0.5), (0.25, -0.0)])
def test_no_flight_does_what_is_impossible(rho, tilt):
    """Balls thrown about a box with a disc, a bumper, an arc and a slope, from everywhere and in all directions."""
    table, random = mixed(rho, tilt), np.random.default_rng(3)
    surfaces = solid_surfaces(table)
    forbidden = {(one.number, other.number) for one, other in product(surfaces, surfaces) if unseen(table, one, other)}
    seen, thrown = set(), 0
    while thrown < 40:
        x, y = random.uniform(0.5, 5.5), random.uniform(0.5, 9.5)
        if table.overlap(x, y)[0] > 0.0 or min(table.distances(x, y).values()) < rho + 0.05:
            continue
        thrown += 1
        state = x, y, *(3.0 * random.normal(size=2))
        seen |= set(pairwise(flights_of(table, state, 0.0, 60.0)[:, SURFACE].astype(int)[:-1].tolist()))
    assert len(forbidden) > 20 and len(seen) > 60
    assert not forbidden & seen


def test_a_disc_covers_another_until_a_way_leads_past_it():
    """Equal discs in a row: a common tangent is a way at once."""
    for beside, covers in ((0.0, False), (1e-9, False), (0.5, False)):  # all three touch one line
        a, _b, c = solid_surfaces(in_a_row(beside))
        assert (covered(in_a_row(beside), a, c) >= 0) is covers
    small = [gz.disc("A", (0, 0), 1.0, ELASTIC), gz.disc("C", (6, 0), 1.0, ELASTIC)]
    for radius, beside, covers in ((1.2, 0.0, True), (1.2, 0.19, True), (1.2, 0.21, False), (1.2, -0.19, True)):
        table = gz.table([*small, gz.disc("B", (3, beside), radius, ELASTIC)])
        a, c, _b = solid_surfaces(table)
        assert (unseen(table, a, c) == "B covers C from A") is covers
        found = gz.periodic_orbits(gz.collision_map(table), 2)
        assert ("A then C: B covers C from A" in found.searched.impossible) is covers


def test_words_that_only_take_or_only_give_energy_are_impossible():
    laws = gz.newton(0.5), gz.newton(1.0), gz.active(1.0, 0.2), gz.active(0.5, 0.2), gz.triggered(0.5, 0.0, 0.1)
    table = gz.table([gz.disc(f"D{i}", (4 * i, 0), 1.0, law) for i, law in enumerate(laws)])
    assert [gain_of(one.law) for one in table.objects] == [-1, 0, 1, None, -1]
    assert "take energy" in one_way(table, [0, 1]) and "give energy" in one_way(table, [1, 2, 1])
    assert "take energy" in one_way(table, [0, 4])
    assert not one_way(table, [1]) and not one_way(table, [0, 2]) and not one_way(table, [0, 3])


def test_a_word_has_one_orbit_at_most_between_convex_bodies_that_are_elastic():
    assert one_at_most(three_discs(3.0), [0, 1, 2]) and not one_at_most(active_discs(3.0), [0, 1])
    bowl = gz.table([gz.arc("bowl", (0, 0), 2.0, 0.0, 6.0, ELASTIC)])
    assert not one_at_most(bowl, [0])
    assert not one_at_most(gz.table(three_discs(3.0).objects, tilt=0.1), [0, 1])
