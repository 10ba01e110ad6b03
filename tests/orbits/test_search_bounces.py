"""Orbits by bumper word: all of them where that is proven, those of other searches, the same in any unit."""

from math import sqrt

import numpy as np
import pytest

import grazing as gz
from grazing.orbits.search_impacts import Tally
from grazing.orbits.search_map import Cycles
from grazing.orbits.search_windows import recurrences, simulated
from tests.billiard.orbits import active_discs, in_a_row, pinball
from tests.billiard.tables import ELASTIC, three_discs


def test_every_word_of_three_discs_has_its_orbit():
    """2^n + 2 (-1)^n points of period n, and 3, 2, 3, 6, 9 orbits of least period 2 to 6."""
    found = gz.periodic_orbits(gz.collision_map(three_discs(6.0)), range(1, 7))
    assert [sum(orbit.period == n for orbit in found) for n in range(1, 7)] == [0, 3, 2, 3, 6, 9]
    assert found.searched.complete and found.searched.missing == () and found.statement.count("these are all") == 1
    assert all(orbit.admissible and orbit.conserves and not orbit.stable for orbit in found)
    assert [orbit.word for orbit in found[:5]] == ["AB", "AC", "BC", "ABC", "ACB"]
    for orbit in found:
        flown = orbit.map.orbit(orbit.points[0], orbit.period)
        size = 1e-14 * abs(orbit.multipliers[0])
        np.testing.assert_allclose(flown.points[-1, 1:], orbit.points[0, 1:], atol=size)
        assert orbit.transverse.prod().real == pytest.approx(1.0, rel=1e-12)


@pytest.mark.parametrize(
    ("distance", "known"),
    [
        (6.0, [(4.0, 5.0 + 2.0 * sqrt(6.0)), (4.26794919243112, 11.7714551963856)]),
        (3.0, [(1.0, 3.73205080756888), (3.0 - sqrt(3.0), 4.71616661635874)]),
    ],
)
def test_cycles_of_three_discs_have_the_times_and_multipliers_that_are_known(distance, known):
    P = gz.collision_map(three_discs(distance))
    for name, (T, L) in zip(("AB", "ABC"), known, strict=True):
        (orbit,) = gz.periodic_orbits(P, word=name)
        assert orbit.time / orbit.period == pytest.approx(T, rel=1e-14)
        assert abs(orbit.multipliers[0]) ** (1.0 / orbit.period) == pytest.approx(L, rel=1e-13)


def test_energy_sets_the_scale_of_speed_only_on_a_level_table():
    P = gz.collision_map(three_discs(6.0))
    (slow,), (fast,) = (gz.periodic_orbits(P, word="ABC", energy=E) for E in (0.5, 8.0))
    assert fast.time == pytest.approx(slow.time / 4.0) and fast.points[0, 2] == pytest.approx(4.0)
    np.testing.assert_allclose(fast.multipliers, slow.multipliers, rtol=1e-12)


def test_between_elastic_discs_with_gravity_orbits_come_by_their_energy():
    """Straight up and down between a disc and one above it: the time follows from the energy."""
    discs = [gz.disc("low", (0, 0), 1.0, ELASTIC), gz.disc("high", (0, 4), 1.0, ELASTIC)]
    P = gz.collision_map(gz.table(discs, g=1.0, tilt=0.3))
    left_out = gz.periodic_orbits(P, word="(low)(high)")
    assert len(left_out) == 0 and left_out.searched.families == ("(low)(high)",)
    assert "conserve energy" in left_out.statement
    g, E = P.origin.table.gravity, 3.0
    (orbit,) = gz.periodic_orbits(P, word="(low)(high)", energy=E)
    fast, slow = sqrt(2.0 * (E - g)), sqrt(2.0 * (E - 3.0 * g))
    assert orbit.time == pytest.approx(2.0 * (fast - slow) / g) and orbit.energy == E
    with pytest.raises(gz.InputError, match="only orbits of a table"):
        gz.periodic_orbits(gz.gap_map(lam=0.8, mu=0.5, l=1.0), 1, energy=1.0)


def test_what_the_search_that_all_maps_share_finds_is_among_them():
    """Near-recurrences of flights of an active table."""
    P = gz.collision_map(active_discs(3.0), on="A")
    found = gz.periodic_orbits(P, range(2, 5), starts=200)
    random, box = np.random.default_rng(1), np.array(P.box)
    states = box[:, :1] + (box[:, 1:] - box[:, :1]) * random.random((3, 3000))
    cycles = Cycles(P, Tally())
    runs, met = simulated(P, states, 4, 1), 0
    for n in (2, 3, 4):
        cycles.add(recurrences(runs, n, 500).points)
        for other in cycles.orbits(n):
            if other.word and "away" not in other.word:
                same = [one for one in found if one.word == other.word and one.period == n]
                assert any(np.allclose(one.points.sum(0), other.points.sum(0), atol=1e-8) for one in same)
                met += 1
    assert len(found) == 8 and met >= 3


def test_an_active_table_in_other_units_has_the_same_orbits():
    """Lengths a thousand times larger, times the same."""
    one, other = (gz.periodic_orbits(gz.collision_map(pinball(0.4, scale)), 2, starts=200) for scale in (1.0, 1e3))
    assert [orbit.word for orbit in one] == [orbit.word for orbit in other] and len(one) == 5
    for a, b in zip(one, other, strict=True):
        assert b.time == pytest.approx(a.time, rel=1e-10)
        np.testing.assert_allclose(np.abs(a.multipliers), np.abs(b.multipliers), rtol=1e-8)
        np.testing.assert_allclose(b.corners, 1e3 * a.corners, rtol=1e-10)


def test_two_active_discs_have_their_orbit_in_closed_form():
    """Between them, v = V/(1 - r), and the multipliers of a law with slope r."""
    (orbit,) = gz.periodic_orbits(gz.collision_map(active_discs(3.0, 0.8, 0.25)), word="AB")
    assert orbit.time == pytest.approx(2.0 / 1.25, rel=1e-14) and np.isnan(orbit.energy)
    # speed is a direction of its own, with 0.8 an impact; along the disc the velocity stays, so that
    # one flight and impact are [[1, d], [2, 1 + 2 d]] with d = 1, mirrored, as without losses
    L = (2.0 + sqrt(3.0)) ** 2
    np.testing.assert_allclose(np.abs(orbit.multipliers), [L, 0.64, 1.0 / L], rtol=1e-12)


def test_words_that_no_orbit_can_have_are_refused_with_the_reason():
    P = gz.collision_map(three_discs(6.0))
    with pytest.raises(gz.InputError, match="no orbit of collision map has word A: a straight way that leaves A"):
        gz.periodic_orbits(P, word="AA")
    with pytest.raises(gz.InputError, match="left through away does not come back"):
        gz.periodic_orbits(P, word="A(away)")
    with pytest.raises(gz.InputError, match="word 'AD' has 'D' at position 1"):
        gz.periodic_orbits(P, word="AD")
    pins = gz.collision_map(
        gz.table([gz.disc(name, (x, 0.0), x, ELASTIC) for name, x in (("A", 0.0), ("B", 2.0))]), on="B"
    )
    with pytest.raises(gz.InputError, match="a ball without a radius never meets A"):
        gz.periodic_orbits(pins, word="AB")
    Q = gz.collision_map(pinball())
    with pytest.raises(gz.InputError, match="the impacts take energy, and none gives any"):
        gz.periodic_orbits(Q, word="(left)(right)")
    with pytest.raises(gz.InputError, match="allowed are periods up to 20"):
        gz.periodic_orbits(P, 21)


def test_the_only_orbit_of_a_word_is_virtual_where_a_disc_is_in_its_way():
    P = gz.collision_map(in_a_row(0.5))
    (orbit,) = gz.periodic_orbits(P, word="AC")
    assert not orbit.admissible and orbit.time == pytest.approx(8.0)
    every = gz.periodic_orbits(P, 2)
    assert [one.word for one in every] == ["AB", "BC"] and every.searched.virtual == 1 and every.searched.complete


def room(*corners):
    """A room between elastic walls, and its map from wall to wall."""
    ends = zip("abcd", corners, (*corners[1:], corners[0]), strict=False)
    return gz.collision_map(gz.table([gz.segment(name, one, two, ELASTIC) for name, one, two in ends]))


def test_orbits_that_have_others_beside_them_are_not_said_to_be_all():
    """Parallels of a way over all walls of a rectangle have its word; in a triangle they close after two turns."""
    square = gz.periodic_orbits(room((0, 0), (4, 0), (4, 3), (0, 3)), word="abcd")
    assert len(square) == 1 and square[0].degenerate and not square.searched.complete
    P = room((0, 0), (4, 0), (1.7, 3.3))
    once, twice = (gz.periodic_orbits(P, period, word="abc", starts=20) for period in (3, 6))
    assert len(once) == 1 and once.searched.complete and not twice.searched.complete
    beside = P.orbit(once[0].points[0] + [0.05, 0.0, 0.0], 6).points
    np.testing.assert_allclose(beside[6], beside[0], atol=1e-14)
    assert abs(beside[3, 0] - beside[0, 0]) == pytest.approx(0.1)


def test_parallel_faces_that_see_each_other_have_more_orbits_than_those_at_their_ends():
    """Newton's method finds the two at the ends of the common stretch only; without that stretch they are none."""
    for shift, complete in ((2.0, False), (3.5, True)):
        faces = [gz.segment(name, (x, y), (x, y + 3), ELASTIC) for name, x, y in (("a", 0, 0), ("b", 3, shift))]
        found = gz.periodic_orbits(gz.collision_map(gz.table(faces, rho=0.1)), 2, starts=20)
        assert len(found) == 1 and found.searched.complete is complete


def test_words_of_one_disc_without_any_orbit_are_named_and_nothing_is_claimed():
    """A disc beside a drain on a slope: a ball that comes back to its top needs a kick."""
    law = gz.active(0.5, 0.5)
    discs = [gz.disc("A", (0, 0), 1.0, law), gz.disc("B", (30, 0), 1.0, gz.newton(0.5))]
    found = gz.periodic_orbits(gz.collision_map(gz.table(discs, tilt=0.5)), (1, 2), starts=200)
    assert [orbit.word for orbit in found] == ["A"] and not found.searched.complete
    assert found.searched.impossible == ("B alone, one of B among them: the impacts take energy, and none gives any",)
    assert found.searched.missing == ("AB",) and found.statement.endswith("no proof that there are no others")
