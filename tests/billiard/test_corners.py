"""A ball without a radius where faces meet: rounding puts it beyond ends and lines, and none of that is a way out."""

from math import cos, hypot, pi, sin

import numpy as np
import pytest

import grazing as gz
from grazing.billiard.exact import exact_contact
from grazing.billiard.flown import BEFORE, FLAGS, LAST, NEXT, OWNER, PATH, SURFACE, TIME, flights_of
from grazing.billiard.rows import FEET
from grazing.outcome import AMBIGUOUS, ESCAPED, NO_IMPACT


def beyond(corners, x, y):
    """Return how far a place is outside a convex polygon, whose corners come counterclockwise."""
    sides = np.roll(corners, -1, axis=0) - corners
    off = sides[:, 1] * (x - corners[:, 0]) - sides[:, 0] * (y - corners[:, 1])
    return float((off / np.hypot(*sides.T)).max())


def walls(places, law):
    """Return segments between places, each given as (begin, end)."""
    return [gz.segment(f"s{k}", tuple(map(float, p)), tuple(map(float, q)), law) for k, (p, q) in enumerate(places)]


def triangle(random):
    """Return the corners of a random triangle with no angle below 6 degrees, counterclockwise."""
    while True:
        a, b, c = corners = random.uniform(-2.0, 2.0, (3, 2))
        area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
        if area > 0.1 * max(hypot(*(p - q)) for p, q in ((a, b), (b, c), (c, a))) ** 2:
            return corners


@pytest.mark.parametrize("r", [0.0, 0.3, 0.7])
def test_it_stays_in_a_triangle_and_on_one_side_of_a_wall_between_two_of_its_faces(r):
    """It left through corners of less than a right angle and at the foot of the wall, certified."""
    for seed in range(20):
        random = np.random.default_rng(seed)
        a, b, c = triangle(random)
        s, u = random.uniform(0.2, 0.8, 2)
        feet = a + s * (b - a), a + u * (c - a)
        table = gz.table(walls([(a, b), (c, b), (c, a), feet], gz.newton(r)), tilt=1.0)
        for room in (np.array([a, *feet]), np.array([feet[0], b, c, feet[1]])):
            start = random.dirichlet(np.ones(len(room))) @ room
            flights = flights_of(table, (*start.tolist(), *random.normal(0.0, 0.3, 2).tolist()), 0.0, 30.0)
            assert max(beyond(room, *place) for place in flights[:: 1 + len(flights) // 50, NEXT : NEXT + 2]) < 1e-9
            assert int(flights[-1, FLAGS]) & (ESCAPED | NO_IMPACT | AMBIGUOUS) == NO_IMPACT, seed


def test_it_does_not_leave_below_an_overhanging_face_that_it_does_not_press_on():
    """After an impact with r = 0 it flies along the face, and rounding put its foot beyond the end of the next one."""
    p, q, o = (0.21294368931825872, 0.9878685006574627), (-0.9373660888210208, -0.8071136094486336), (
        1.5714956057277933, -0.17886834507810187)  # fmt: skip
    table = gz.table(walls([(p, q), (q, o), (o, p)], gz.newton(0.0)), tilt=1.0)
    found = gz.trajectory(table, (-0.4110358020275996, -0.6290259477484619, 0.0, 0.0), until=40.0, samples=2)
    assert found.outcome == "stays for ever" and found.trust == "certified"
    np.testing.assert_allclose((found.x[-1], found.y[-1]), q, atol=1e-9)


@pytest.mark.parametrize("rho", [0.0, 0.02])
def test_it_slides_into_a_corner_and_stays(rho):
    """With a radius, too, it was behind the second face, by less than the rounding of its coordinates."""
    a, b, c = (-1.98, -0.31), (-2.37, -2.8), (-1.43, -2.42)
    for seed in range(20):
        random = np.random.default_rng(seed)
        shift = random.uniform(-3.0, 3.0, 2)
        places = [(np.array(p) + shift, np.array(q) + shift) for p, q in ((a, b), (b, c))]
        table = gz.table(walls(places, gz.newton(0.0)), rho, tilt=1.0)
        start = np.array(c) + shift + (-0.1, 0.2)
        flights = flights_of(table, (*start.tolist(), -1.0, -0.4), 0.0, 30.0)
        assert int(flights[-1, FLAGS]) & (ESCAPED | NO_IMPACT) == NO_IMPACT, seed


@pytest.mark.parametrize("stem", [False, True])
def test_it_slides_over_the_edge_of_a_roof_and_past_a_wall_below_and_hits_neither(stem):
    """It hit the back of the face beyond the edge, or the wall that ends on the other side of its own."""
    for seed in range(20):
        random = np.random.default_rng(seed)
        low, steep, edge = random.uniform(0.1, 0.5), random.uniform(0.6, 1.2), random.uniform(-2.0, 2.0, 2)
        back, down = edge + 2.0 * np.array([-cos(low), sin(low)]), edge + 3.0 * np.array([cos(steep), -sin(steep)])
        foot = edge + 0.7 * (back - edge)
        places = [(back, edge), (edge, down), *([(foot, (foot[0] + 0.1, foot[1] - 1.0))] if stem else [])]
        table = gz.table(walls(places, gz.newton(0.0)), tilt=1.0)
        start = edge + 1.8 * np.array([-cos(low), sin(low)]) + (0.0, 0.1)
        flights = flights_of(table, (*start.tolist(), 0.0, 0.0), 0.0, 1.2)
        assert [int(one) for one in flights[:, OWNER] if one >= 0][:1] == [0]
        assert set(flights[:, OWNER].tolist()) <= {-1.0, 0.0, 1.0}
        later = flights[-1, NEXT : NEXT + 2] if flights[-1, TIME] < np.inf else edge
        assert beyond(np.array([back, edge, down])[::-1], *later) > -1e-9


def test_thrown_into_a_corner_of_a_ceiling_it_falls_out_of_it():
    """Hits of no time took its speed to 1e-300 and never to 0: it hung there until the budget was spent."""
    table = gz.table(walls([((-1, 0), (0, 1)), ((0, 1), (0.4, 0)), ((-3, -4), (3, -4))], gz.newton(0.0)), tilt=1.0)
    flights = flights_of(table, (0.0, -1.0, 0.0, 3.0), 0.0, 30.0)
    assert len(flights) < 300
    np.testing.assert_allclose(flights[-1, NEXT + 1], -4.0)


def test_in_a_narrow_corner_it_comes_to_rest():
    for angle in (0.03, 0.1, pi / 4):
        ends = [(-2.0 * cos(0.3 + more), 2.0 * sin(0.3 + more)) for more in (0.0, angle)]
        table = gz.table(walls([(ends[0], (0, 0)), ((0, 0), ends[1])], gz.newton(0.3)), tilt=1.0)
        middle = -cos(0.3 + angle / 2), sin(0.3 + angle / 2)
        flights = flights_of(table, (*middle, 0.0, 0.0), 0.0, 60.0)
        assert int(flights[-1, FLAGS]) & (ESCAPED | NO_IMPACT) == NO_IMPACT and flights[-1, PATH] >= 0.0
        assert hypot(*flights[-1, NEXT : NEXT + 2]) < 1e-9


def test_shot_exactly_into_a_corner_it_does_not_pass_between_both_faces():
    """Beyond the ends of both by rounding, in exact arithmetic, it left certified."""
    doubtful = 0
    for seed in range(12):
        corners = triangle(np.random.default_rng(seed))
        a, b, c = corners
        table = gz.table(walls([(a, b), (c, b), (c, a)], gz.newton(0.5)), tilt=1.0)
        start, half = corners.mean(axis=0), np.array([0.0, 0.5 * table.gravity])
        for corner in corners:
            flights = flights_of(table, (*start.tolist(), *(corner - start + half).tolist()), 0.0, 2.0)
            assert not int(flights[-1, FLAGS]) & ESCAPED, seed
            doubtful += any(int(flags) & AMBIGUOUS for flags in flights[:, FLAGS])
    assert doubtful > 3


SHOTS = [  # corners counterclockwise, sides given from their second end, r, start and velocity
    ([(0.5704744763599111, 1.2580493480184554), (0.4959996539561975, 0.7226350938851012),
      (2.130577445955101, 1.6205354613045537), (-0.7451775942567456, 2.7599701743897644)], (), 1.0,
     (0.42547791651871325, 1.816136716635435, 0.16126256038158177, -0.24239736371294174)),
    ([(998.8464294648443, 998.4229737245475), (1000.2266631241606, 998.0147299132295),
      (1002.2817092112176, 997.5439745142411), (1001.9610823955168, 997.9112801319508),
      (1001.7748017094945, 998.8458702587104)], (1, 4), 0.7,
     (1001.5245051533362, 998.4683976661589, 0.9024761955127519, -0.9481197547425219)),
    ([(999.9615145576389, 1003.2156420776753), (998.4000183239912, 999.155866506316),
      (999.528346807178, 998.0776051968386), (1002.6522647083751, 998.5637681656134)], (0, 1, 3), 0.3,
     (1000.2746145327907, 999.1968907780066, -0.5025595289292133, -0.12899673783741472)),
]  # fmt: skip


@pytest.mark.parametrize(("corners", "turned", "r", "state"), SHOTS)
def test_at_a_corner_it_hits_the_face_in_front_not_the_back_of_the_other_one(corners, turned, r, state):
    """Past the edge that stands into the room by rounding it hit a face from outside; so it did far from the origin."""
    places = list(zip(corners, [*corners[1:], corners[0]], strict=True))
    places = [(q, p) if k in turned else (p, q) for k, (p, q) in enumerate(places)]
    flights = flights_of(gz.table(walls(places, gz.newton(r)), tilt=1.0), state, 0.0, 10.0)
    assert not int(flights[-1, FLAGS]) & ESCAPED


@pytest.mark.parametrize("r", [0.0, 0.7])
def test_where_three_faces_meet_it_does_not_hit_the_one_behind_another(r):
    """Sliding down into the corner of a room, and flying from one of its sides there, it hit the wall outside."""
    for seed in range(8):
        random = np.random.default_rng(seed)
        a, b, c = corners = triangle(random)
        low = corners[:, 1].argmin()
        angle, tip = random.uniform(0.0, 2.0 * pi), corners[low]
        outer = tip + 0.1 * np.array([cos(angle), sin(angle)])
        if beyond(corners, *outer) < 0.0:
            outer = 2.0 * tip - outer
        table = gz.table(walls([(tip, outer), (a, b), (b, c), (c, a)], gz.newton(r)), tilt=1.0)
        flights = flights_of(table, (*corners.mean(axis=0).tolist(), 0.1, 0.0), 0.0, 30.0)
        assert int(flights[-1, FLAGS]) & (ESCAPED | NO_IMPACT) == NO_IMPACT, seed
        np.testing.assert_allclose(flights[-1, NEXT : NEXT + 2], tip, atol=1e-9)


@pytest.mark.parametrize("rho", [0.0, 0.2])
def test_thrown_into_any_notch_of_a_ceiling_it_falls_out_of_it(rho):
    """With a radius, or between discs, hits of no time went on to the budget."""
    faces = walls([((-1, 0), (0, 1)), ((0, 1), (0.4, 0)), ((-3, -4), (3, -4))], gz.newton(0.0))
    flights = flights_of(gz.table(faces, rho, tilt=1.0), (0.0, -1.0, 0.01, 3.0), 0.0, 30.0)
    assert len(flights) < 300 and abs(flights[-1, NEXT + 1] + 4.0 - rho) < 1e-9
    discs = [gz.disc(name, (x, 0), 0.9, gz.newton(0.0)) for name, x in (("a", -1), ("b", 1))]
    flights = flights_of(gz.table(discs, 0.2, tilt=1.0), (0.001, -2.0, 0.01, 3.0), 0.0, 30.0)
    assert len(flights) < 300 and int(flights[-1, FLAGS]) & ESCAPED


def test_the_budget_counts_impacts_alone():
    """Slides and flights without an impact counted, too, so that launches decided exactly ended earlier than others."""
    floor = walls([((0, 0), (3, 0)), ((3, -1), (5, -1))], gz.newton(0.0))
    flights = flights_of(gz.table(floor, tilt=1.0), (1.0, 0.5, 1.0, 0.0), 0.0, 30.0, 3)
    impacts = np.flatnonzero(~np.isnan(flights[:, BEFORE]))
    assert len(impacts) == 2 < 3 < len(flights) and int(flights[-1, FLAGS]) & ESCAPED


@pytest.mark.parametrize("hidden", [(-1.0, -0.1), (-0.16, -0.017), (-1.0, 0.3)])
def test_it_falls_out_of_a_notch_and_not_onto_a_face_behind_that(hidden):
    """It was put on the upper side of the third face, certified, once hits in the notch had taken its speed to 0."""
    ends, law = [((0, 0), (0.03, -1.1)), ((0, 0), (-1.1, -1.0)), ((0, 0), hidden)], gz.newton(0.0)
    table = gz.table(walls(ends, law), tilt=1.0)
    flights = flights_of(table, (-0.3, -0.6, 0.3 / 0.7, 0.6 / 0.7 + 0.35 * table.gravity), 0.0, 5.0)
    assert set(flights[:, OWNER]) <= {0.0, 1.0, -1.0} and int(flights[-1, FLAGS]) & ESCAPED
    assert (flights[:, NEXT + 1] <= 1e-9).all() and set(flights[:-1, SURFACE]) == {1.0, 2.0}


def test_feet_of_walls_are_counted_and_corners_and_balls_with_a_radius_have_none():
    """Where there are none no impact is asked for them: that took as long as half of a collision."""
    law, box = gz.newton(1.0), [(0, 0), (6, 0), (6.1, 3.3), (0.1, 3.1)]
    sides, post = walls(list(zip(box, box[1:] + box[:1], strict=True)), law), gz.disc("post", (4, 2), 0.3, law)
    bow = gz.arc("bow", (2, 2), 0.5, 0.0, 1.0, law)

    def feet(*more, rho=0.0):
        table = gz.table([*sides, post, bow, *more], rho)
        return table.blocks(table.row())[0][FEET]

    stem, on_post = gz.segment("stem", (1, 0), (1, 1), law), gz.segment("stem", (4.3, 2), (5, 2), law)
    on_bow, drain = gz.segment("stem", (2.5, 2), (3, 2), law), gz.drain("out", (1, 0), (1, 1))
    assert [feet(), feet(drain), feet(stem, rho=0.1)] == [0.0, 0.0, 0.0]
    assert [feet(stem), feet(on_post), feet(on_bow)] == [1.0, 1.0, 1.0]


@pytest.mark.parametrize("r", [0.0, 0.7])
def test_it_meets_no_arc_that_hangs_below_the_wall_on_which_it_ends(r):
    """Shot exactly at where the arc ends it hit that, certified, and was behind the wall; so it did as it slid by."""
    for seed in range(40):
        random = np.random.default_rng(seed)
        turn, radius, lean = random.uniform(-0.6, 0.6), random.uniform(0.05, 0.4), random.uniform(0.2, 2.9)
        foot, along = random.uniform(-1.0, 1.0, 2), np.array([cos(turn), sin(turn)])
        up, ends = np.array([-along[1], along[0]]), [(foot - along, foot + along)]
        # at its end the arc goes on in the direction turn - lean, below the wall
        start = turn - lean - 0.5 * pi
        x, y = foot - radius * np.array([cos(start), sin(start)])
        bow = gz.arc("bow", (x, y), radius, start, start + min(lean, pi - lean), gz.newton(r))
        table = gz.table([bow, *walls(ends, gz.newton(r))], tilt=0.5 * pi)
        place, late = foot + random.uniform(-0.5, 0.5) * along + 0.4 * up, 0.5
        v = (foot - place) / late + np.array([0.0, 0.5 * late])
        slid_by = foot + 0.4 * np.copysign(1.0, turn) * along + 0.01 * up
        for state in ((*place, *v), (*slid_by, 0.0, 0.0)):
            flights = flights_of(table, tuple(map(float, state)), 0.0, 0.7)
            assert set(flights[:, OWNER]) <= {1.0, -1.0}, (seed, state)


def test_exact_decisions_know_that_both_sides_of_a_face_are_one_line():
    """Shot exactly into a corner with r = 0 it left a face by rounding towards its other side, and slid on that."""
    b, c, law = (1.7904092244172392, 1.1409328301471438), (1.5136958726453442, -1.172999099034479), gz.newton(0.0)
    ends = [((2.4012409255460034, 0.9667227146843909), b), (c, b), (c, (2.8798682259989885, 0.42955695579873326))]
    bow = gz.arc("bow", (2.0718226359702268, 1.329342305896394), 0.3386615401163799, 3.7315620750215666,
                 3.9610791174857716, law)  # fmt: skip
    table = gz.table([*walls(ends, law), bow], tilt=1.0)
    start = 2.0347185454173671, 0.045412263146425769, -0.32995735847712471, 1.7911034365651861
    flights = flights_of(table, start, 0.0, 5.0)
    assert flights[0, SURFACE] == 3.0 and 2.0 not in set(np.floor(flights[:, SURFACE]))
    assert (flights[:, NEXT + 1] < 1.141).all()


def test_without_gravity_it_flies_along_a_wall_past_an_arc_that_hangs_behind_it():
    """With r = 0 it flew along the wall, hit the end of the arc there, certified, and was behind the wall."""
    for seed in range(20):
        random = np.random.default_rng(seed)
        turn, lean, foot = random.uniform(-pi, pi), random.uniform(0.2, 2.9), random.uniform(-1.0, 1.0, 2)
        along, start = np.array([cos(turn), sin(turn)]), turn - lean - 0.5 * pi
        centre = foot - 0.2 * np.array([cos(start), sin(start)])
        bow = gz.arc("bow", centre, 0.2, start, start + min(lean, pi - lean), gz.newton(0.0))
        table = gz.table([bow, *walls([(foot - along, foot + along)], gz.newton(0.0))])
        place = foot - 0.6 * along + 0.1 * np.array([-along[1], along[0]])
        flights = flights_of(table, (*place.tolist(), *(foot - 0.3 * along - place).tolist()), 0.0, 9.0)
        assert flights[:, OWNER].tolist() == [1.0, -1.0], seed


@pytest.mark.parametrize("r", [0.7, 1.0])
def test_an_arc_that_begins_on_a_wall_lies_on_that_side_on_which_it_begins(r):
    """Its middle, beyond the line of the wall, told: shot into the joint a ball came out behind the wall."""
    for seed in range(20):
        random = np.random.default_rng(seed)
        lean, turn, foot = random.uniform(0.2, 0.4), random.uniform(-pi, pi), random.uniform(-1.0, 1.0, 2)
        along, up = np.array([cos(turn), sin(turn)]), np.array([-sin(turn), cos(turn)])
        # it comes down past the end of the wall, at twice the sine of the lean
        begin, end = turn + lean + 0.5 * pi, sin(lean)
        bow = gz.arc("bow", foot - np.array([cos(begin), sin(begin)]), 1.0, begin - 6.0 * lean, begin, gz.newton(r))
        table = gz.table([bow, *walls([(foot - along, foot + end * along)], gz.newton(r))])
        place = foot - random.uniform(0.1, 0.5) * along + 0.4 * up
        flights = flights_of(table, (*place.tolist(), *(foot - place).tolist()), 0.0, 9.0)
        assert flights[-1, LAST - 2 : LAST] @ up > 0.0, seed


@pytest.mark.parametrize("lean", [0.03, 0.3])
def test_exact_decisions_do_not_take_a_place_outside_a_small_arc_for_one_on_it(lean):
    """Rounding was the square of the coordinates, not these times the radius: from outside it hit the inside."""
    place, law = np.array([1000.0, 1000.0]), gz.newton(0.7)
    begin, radius = 0.5 * pi + lean, 0.1
    bow = gz.arc("bow", place - radius * np.array([cos(begin), sin(begin)]), radius, begin, begin + 1.0, law)
    table = gz.table([*walls([(place - (1.0, 0.0), place)], law), bow], tilt=1.0)
    block = table.blocks(table.row())[0]
    above = 1e-9 / sin(lean)  # so far from the joint the wall is 1e-9 above the arc
    surface, _t, _flags = exact_contact(block, (1000.0 - above, 1000.0, 1e-3, 1e-3), 0.0)
    assert surface == -1


def test_flying_along_a_wall_far_from_the_origin_it_does_not_hit_the_back_of_the_next_one():
    """With r = 0 and no gravity; rounding of the coordinates put it beside the wall, and so behind the next one."""
    for seed in range(40):
        random = np.random.default_rng(seed)
        turn, lean, end = random.uniform(-pi, pi), random.uniform(0.05, 2.0), random.uniform(-1000.0, 1000.0, 2)
        along, up = np.array([cos(turn), sin(turn)]), np.array([-sin(turn), cos(turn)])
        after = np.array([cos(turn - lean), sin(turn - lean)])
        table = gz.table(walls([(end - along, end), (end, end + after)], gz.newton(0.0)))
        place = end - 0.6 * along + 0.1 * up
        flights = flights_of(table, (*place.tolist(), *(end - 0.3 * along - place).tolist()), 0.0, 9.0)
        assert flights[:, OWNER].tolist() == [0.0, -1.0], seed


@pytest.mark.parametrize(("x", "hits"), [(-1e-16, "AsA"), (1e-16, "AA")])
def test_it_flies_by_a_face_that_begins_at_the_centre_of_the_arc_that_it_left(x, hits):
    """That centre has no direction from itself: 0/0, of which nothing was used, but warned."""
    objects = [gz.arc("A", (0, 0), 1.0, -0.5, 5.0, gz.newton(1.0)), *walls([((0, 0), (0.5, 0))], gz.newton(1.0))]
    found = gz.trajectory(gz.table(objects), (x, 0.5, 0.0, 1.0), until=2.8, samples=2)
    assert "".join(name[0] for name in found.impact_wall.values) == hits and found.trust == "certified"
