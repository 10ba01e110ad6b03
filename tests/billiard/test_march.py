"""First contacts of balls on tables: grazes that are built, a dense search, and exact algebra."""

from functools import lru_cache
from math import cos, sin

import numpy as np
import pytest

import grazing as gz
from grazing.billiard.contact import next_event
from grazing.billiard.exact import exact_contact
from grazing.billiard.flown import FIRST, FLAGS, LAST, SURFACE, TIME, decided, flights_of
from grazing.billiard.march import first_contact
from grazing.kernel.compile import compiled
from grazing.kernel.primitives import numbers
from grazing.outcome import AMBIGUOUS, GRAZE, INSIDE_WALL, STUCK, TOO_MANY_IMPACTS
from tests.billiard.tables import ELASTIC, box, dense, grazing, least_gap, mixed

KINDS = "disc", "end", "face", "arc outside", "arc inside"


@lru_cache(maxsize=1)
def marcher():
    def march(block, state, left, found):
        met = next_event(state[0], state[1], state[2], state[3], left, 0.0, numbers(block))  # which is compiled already
        surface, _owner, t, flags, _left = met[0]
        found[0], found[1], found[2] = surface, t, flags

    return compiled(march)


def contact(table, state, left=-1.0):
    block, found = table.blocks(table.row())[0], np.empty(3)
    marcher()(block, np.array(state, float), left, found)
    return int(found[0]), float(found[1]), int(found[2])


def alone(table, state, left=-1.0):
    """The first contact, and nothing of what an event makes of it."""
    return first_contact(*state, left, 0.0, table.blocks(table.row(), "python")[0])


def count_grazes(count, seed):
    """Return how many built grazes were missed, seen where none was, left ambiguous, decided exactly."""
    random, missed, false, left, exactly = np.random.default_rng(seed), 0, 0, 0, 0
    for i in range(count):
        kind = KINDS[i % len(KINDS)]
        depth = 10.0 ** -random.uniform(3.0, 13.0) * (1.0 if i % 2 else -1.0)
        table, state, t = grazing(kind, depth, random)
        truth = least_gap(table, state, t)
        assert abs(truth + depth) < 1e-14, (kind, depth, truth)
        surface, at, flags = contact(table, state)
        if flags & AMBIGUOUS:
            exactly += 1
            surface, at, flags = exact_contact(table.blocks(table.row())[0], state, -1)
            left += bool(flags & AMBIGUOUS)
        hit = surface >= 0 and abs(at - t) < 0.2  # a dip is about as wide as its root is deep
        missed += truth < 0.0 and not hit
        false += truth > 0.0 and hit
    return missed, false, left, exactly


def test_no_built_graze_is_missed_and_none_is_seen_that_is_not():
    missed, false, left, exactly = count_grazes(200, 0)
    assert (missed, false, left) == (0, 0, 0)
    assert exactly < 40  # most are decided in doubles


@pytest.mark.long
def test_no_graze_of_twenty_thousand_is_missed():
    missed, false, left, _exactly = count_grazes(20_000, 1)
    assert (missed, false, left) == (0, 0, 0)


@pytest.mark.parametrize("rho", [0.02, 0.25])
def test_first_contacts_are_those_of_a_dense_search(rho):
    table, random, count = mixed(rho), np.random.default_rng(3), 0
    while count < 12:
        state = *random.uniform((0.5, 0.5), (5.5, 9.5)), *random.uniform(-2.0, 2.0, 2)
        if table.overlap(*state[:2])[0] > 0.0:
            continue
        flight = flights_of(table, state, 0.0, 1e-9)[0]
        name, t = dense(table, state, flight[TIME] * 1.2, steps=4000)
        assert abs(t - flight[TIME]) < 1e-10
        assert table.objects[int(flight[2])].name == name
        count += 1


@pytest.mark.parametrize("rho", [0.0, 0.25])
def test_every_flight_of_an_orbit_is_that_of_exact_algebra(rho):
    table, count = mixed(rho), 0
    block = table.blocks(table.row())[0]
    flights = flights_of(table, (0.7, 1.0, 1.1, 2.9), 0.0, 60.0)
    left = -1
    for flight in flights:
        state = flight[FIRST:LAST]
        surface, t, flags = exact_contact(block, tuple(state.tolist()), left)
        assert surface == int(flight[SURFACE]) and not flags & AMBIGUOUS
        assert abs(t - flight[TIME]) <= 1e-12 * (1.0 + t)
        left, count = surface, count + 1
    assert count > 30


def test_a_flight_that_touches_exactly_grazes_and_is_no_impact():
    """Straight past a pin of radius 1 at distance 1, and a parabola whose vertex is a ceiling."""
    level = gz.table([gz.disc("A", (0, 0), 1.0, ELASTIC)])
    _surface, _t, flags = contact(level, (-3.0, 1.0, 1.0, 0.0))
    assert flags & GRAZE and flags & AMBIGUOUS  # doubles cannot say
    block = level.blocks(level.row())[0]
    assert exact_contact(block, (-3.0, 1.0, 1.0, 0.0), -1) == (-1, float("inf"), GRAZE)
    assert exact_contact(block, (-3.0, 1.0 - 2.0**-53, 1.0, 0.0), -1)[0] == 0
    tilted = gz.table([gz.segment("A", (-5, 0.5), (5, 0.5), ELASTIC)], tilt=np.pi / 2)
    assert contact(tilted, (-1.0, 0.0, 1.0, 1.0))[2] & AMBIGUOUS
    flight = decided(tilted.blocks(tilted.row())[0], np.array([-1.0, 0.0, 1.0, 1.0]), -1)
    assert int(flight[FLAGS]) & GRAZE and flight[SURFACE] < 0


@pytest.mark.parametrize("rho", [0.0, 0.25])
def test_two_objects_that_are_hit_at_once_are_ambiguous_and_the_first_one_is_taken(rho):
    walls = box(2.0, 2.0)
    for order in (walls, walls[::-1]):
        table = gz.table(order, rho=rho)
        state = (1.0, 1.0, 1.0, 1.0)  # into a corner
        assert contact(table, state)[2] & AMBIGUOUS
        surface, t, flags = exact_contact(table.blocks(table.row())[0], state, -1)
        assert t == 1.0 - rho and flags & AMBIGUOUS
        first = min(order, key=lambda one: order.index(one) if one.name in ("right", "ceiling") else 9)
        assert order[surface // 2].name == first.name
        flown = gz.trajectory(table, state, until=10.0)
        assert flown.trust == "ambiguous" and {*flown.impact_wall.values.tolist()} == {
            "floor",
            "right",
            "ceiling",
            "left",
        }


@pytest.mark.parametrize("kind", ["box", "wedge", "reflex", "arc", "straight"])
def test_a_ball_without_a_radius_comes_out_of_a_corner(kind):
    """Shot exactly into the point in which two objects meet, it goes on, inside, and hits nothing for ever."""
    tip = 2.0, 1.0
    objects, start = {
        "box": ([gz.segment("A", (2, -3), tip, ELASTIC), gz.segment("B", tip, (-3, 1), ELASTIC)], (1.0, 0.0)),
        "wedge": ([gz.segment("A", (-2, 2), tip, ELASTIC), gz.segment("B", tip, (-2, 0), ELASTIC)], (0.0, 1.0)),
        "reflex": ([gz.segment("A", (2, -3), tip, ELASTIC), gz.segment("B", tip, (-3, 1), ELASTIC)], (3.0, 2.0)),
        "arc": ([gz.arc("A", (0, 1), 2.0, -1.5, 0.0, ELASTIC), gz.segment("B", tip, (-3, 1), ELASTIC)], (1.0, 0.5)),
        "straight": ([gz.segment("A", (-3, 1), tip, ELASTIC), gz.segment("B", tip, (7, 1), ELASTIC)], (2.0, 0.0)),
    }[kind]
    for order in (objects, objects[::-1]):
        table = gz.table(order)
        flown = gz.trajectory(table, (*start, tip[0] - start[0], tip[1] - start[1]), until=1.5)
        assert 1 <= flown.sizes["impact"] <= 7 and flown.trust == "ambiguous"  # a wedge of angle a: pi/a at most
        np.testing.assert_allclose(flown.impact_time, 1.0, atol=1e-12)
        x, y = float(flown.x[-1]), float(flown.y[-1])
        before = [gz.trajectory(gz.table([one]), (*start, x - start[0], y - start[1]), until=1.0) for one in order]
        assert all(one.sizes["impact"] == 0 for one in before)  # the straight way there is free: the same side


def test_two_contacts_a_hair_apart_are_told_apart_exactly():
    """Two discs met by one flight, the second one 2^-50 later than the first."""
    late = 2.0**-50
    for order in (1, -1):
        discs = [gz.disc("A", (5.0, 1.0), 1.0, ELASTIC), gz.disc("B", (5.0 + order * late * 4, -1.0), 1.0, ELASTIC)]
        table = gz.table(discs)
        state = (0.0, 0.0, 1.0, 0.0)
        surface, t, flags = exact_contact(table.blocks(table.row())[0], state, -1)
        assert t == pytest.approx(5.0) or surface == -1  # between two that touch at the line: grazes both
    a, b = gz.disc("A", (3.0, 0.5), 1.0, ELASTIC), gz.disc("B", (3.0 + late, -1.5), 1.0, ELASTIC)
    for state, name in (((0.0, -0.5, 1.0, 0.0), "A"), ((late, -0.5, 1.0, 0.0), "A")):
        table = gz.table([b, a])
        surface, _t, flags = exact_contact(table.blocks(table.row())[0], state, -1)
        assert table.names[surface] == name and not flags & AMBIGUOUS


def test_a_ball_inside_an_object_and_one_at_rest_end_by_name():
    table = gz.table(
        [gz.disc("A", (0, 0), 1.0, ELASTIC), gz.segment("B", (-9, -3), (9, -3), ELASTIC)], rho=0.1, tilt=0.3
    )
    assert alone(table, (0.2, 0.0, 1.0, 0.0))[2] & INSIDE_WALL
    assert alone(table, (5.0, -3.0, 1.0, 0.0))[2] & INSIDE_WALL
    _surface, t, flags = alone(table, (5.0, -2.9, 1.0, 1e-9), left=0.0)  # its left side points up
    assert flags == STUCK and t == 0.0
    _surface, t, flags = alone(table, (5.0, -2.9, 1.0, 1e-3), left=0.0)
    assert flags == 0 and t == pytest.approx(2e-3 / table.gravity)


@pytest.mark.parametrize(("far", "inside"), [(1.7, False), (1.95, True), (2.0, True), (2.05, True), (2.3, False)])
def test_a_ball_in_the_body_of_an_arc_ends_by_name(far, inside):
    table = gz.table([gz.arc("A", (1.0, 1.0), 2.0, 0.0, 1.5, gz.newton(0.5))], rho=0.1)
    state = (1.0 + far * cos(0.7), 1.0 + far * sin(0.7), 0.1, 0.2)
    assert bool(contact(table, state)[2] & INSIDE_WALL) == inside
    beyond = (1.0 + far * cos(1.9), 1.0 + far * sin(1.9), -0.2, 0.1)
    assert not contact(table, beyond)[2] & INSIDE_WALL


@pytest.mark.parametrize("up", [0.0, 1e-17, -1e-17, -1e-16])
def test_a_ball_that_lies_on_a_floor_does_not_fall_through(up):
    table = gz.table([gz.segment("A", (-9, 0), (9, 0), gz.newton(0.5))], rho=0.125, tilt=0.3)
    flown = gz.trajectory(table, (0.0, 0.125 + up, 1.0, 0.0), until=8.9)
    assert flown.outcome == "ok" and flown.y.values.min() > 0.124 and flown.x.values[-1] == pytest.approx(8.9)


def test_a_ball_that_meets_nothing_is_told_so():
    table = gz.table([gz.disc("A", (0, 0), 1.0, ELASTIC), gz.arc("B", (9, 0), 1.0, 0.0, 1.0, ELASTIC)])
    assert alone(table, (5.0, 5.0, 1.0, 1.0)) == (-1, float("inf"), 0)
    assert alone(table.replace(tilt=0.5), (5.0, 5.0, 1.0, 1.0))[0] == -1
    assert alone(table, (5.0, 5.0, 0.0, 0.0)) == (-1, 0.0, TOO_MANY_IMPACTS)  # at rest, not away
