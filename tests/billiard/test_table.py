"""Tables: parameters, what is refused, distances."""

import pickle
from math import cos, pi, sin, sqrt

import numpy as np
import pytest

import grazing as gz
from grazing.billiard.distance import crosses, distance
from grazing.billiard.exact import exact_contact
from tests.billiard.tables import ELASTIC, box, mixed


def test_every_number_is_a_named_parameter():
    table = mixed(0.25)
    assert table.params["rho"] == 0.25 and table.params["bumper.V"] == 0.6 and table.params["slope.x2"] == 5.4
    other = table.replace(**{"bumper.V": 0.1, "post.x": 1.6, "dome.stop": 2.0, "tilt": 0.1, "slope.r": 0.5})
    assert [name for name in table.params if table.params[name] != other.params[name]] == [
        "tilt", "post.x", "bumper.V", "dome.stop", "slope.r",
    ]  # fmt: skip
    assert other.gravity == sin(0.1) and other.replace(**table.params) == table
    assert pickle.loads(pickle.dumps(table)) == table and hash(table) == hash(mixed(0.25))
    with pytest.raises(AttributeError):
        table.rho = 1.0


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"bumper.V": -1.0}, r"bumper.V = -1; allowed is bumper.V >= 0"),
        ({"bumper.r": 1.1}, "0 <= bumper.r <= 1"),
        ({"bumper.v": 1.0}, "unknown parameter 'bumper.v' of the table"),
        ({"tilt": 2.0}, r"tilt = 2; allowed is 0 <= tilt <= 1.5708"),
        ({"g": -1.0}, "g = -1; allowed is g >= 0"),
        ({"rho": float("inf")}, "rho = inf is not finite"),
        ({"post.x": 4.0}, "post and bumper overlap by 0.27"),
        ({"post.radius": 2.0}, "overlap"),
    ],
)
def test_wrong_values_are_refused(changes, said):
    with pytest.raises(gz.InputError, match=said):
        mixed(0.25).replace(**changes)


@pytest.mark.parametrize(
    ("objects", "said"),
    [
        ([], "give a list of gz.disc"),
        (gz.disc("A", (0, 0), 1.0, ELASTIC), "give a list"),
        ([gz.newton(1.0)], "give a list"),
        ([gz.disc("A", (0, 0), 1.0, ELASTIC), gz.disc("A", (3, 0), 1.0, ELASTIC)], "two objects are called 'A'"),
        ([gz.disc("tilt", (0, 0), 1.0, ELASTIC)], "called 'tilt', which means something else"),
        ([gz.drain("away", (0, 0), (1, 0))], "called 'away'"),
        ([gz.disc("A", (0, 0), 1.0, ELASTIC), gz.disc("B", (1.5, 0), 1.0, ELASTIC)], "A and B overlap by 0.5"),
        ([gz.disc("A", (0, 0), 1.0, ELASTIC), gz.segment("B", (-2, 0.5), (2, 0.5), ELASTIC)], "B and A overlap by 0.5"),
        ([gz.segment("A", (-1, 0), (1, 0), ELASTIC), gz.segment("B", (0, -1), (0, 1), ELASTIC)], "A and B cross"),
        (
            [
                gz.disc("a", (0, 0), 1.0, gz.reset(lambda v, p: -p.b_x * v, b_x=0.5)),
                gz.disc("a_b", (9, 0), 1.0, ELASTIC),
            ],
            "'a.b_x' and 'a_b.x' are the same in code",
        ),
    ],
)
def test_wrong_tables_are_refused(objects, said):
    with pytest.raises(gz.InputError, match=said):
        gz.table(objects)


def test_objects_may_touch():
    disc, post = gz.disc("A", (0, 0), 1.0, ELASTIC), gz.disc("B", (2, 0), 1.0, ELASTIC)
    wall, other = gz.segment("C", (-3, 1), (3, 1), ELASTIC), gz.segment("D", (0, 1), (0, 4), ELASTIC)
    assert gz.table([disc, post, wall, other]).names == ("A", "B", "C", "D")
    assert gz.table(box()).names == ("floor", "right", "ceiling", "left") and not crosses(wall, other)


def test_distances_are_those_to_the_nearest_of_many_points():
    random = np.random.default_rng(0)
    arc = gz.arc("A", (0.3, -0.2), 1.3, -2.0, 1.1, ELASTIC)
    segment, disc = gz.segment("B", (0.1, 0.2), (1.4, -0.7), ELASTIC), gz.disc("C", (0.5, 0.5), 0.4, ELASTIC)
    angles, along = np.linspace(-2.0, 1.1, 20_001), np.linspace(0.0, 1.0, 20_001)
    on_arc = 0.3 + 1.3 * np.cos(angles), -0.2 + 1.3 * np.sin(angles)
    on_segment = 0.1 + 1.3 * along, 0.2 - 0.9 * along
    for x, y in random.uniform(-3.0, 3.0, (50, 2)):
        for one, (a, b) in ((arc, on_arc), (segment, on_segment)):
            assert distance(one, x, y) == pytest.approx(np.hypot(x - a, y - b).min(), abs=1e-6)
        assert distance(disc, x, y) == pytest.approx(np.hypot(x - 0.5, y - 0.5) - 0.4)


def test_a_table_is_the_same_in_any_unit():
    """Lengths times a, times times b: every impact is where it was, in the new units."""

    def made(a, b):
        kick = gz.active(r=0.8, V=0.6 * a / b)
        inside = [
            gz.disc("bumper", (4.4 * a, 2.4 * a), 0.6 * a, kick),
            gz.disc("post", (1.5 * a, 4.0 * a), 0.4 * a, ELASTIC),
        ]
        return gz.table([*box(6.0 * a, 10.0 * a), *inside], rho=0.2 * a, g=a / b**2, tilt=pi / 2)

    plain = gz.trajectory(made(1.0, 1.0), (0.7, 1.0, 1.1, 2.9), until=12.0)
    for a, b in ((1e-3, 1e-2), (2.0**20, 2.0**-10), (1e6, 1.0)):
        scaled = gz.trajectory(made(a, b), (0.7 * a, 1.0 * a, 1.1 * a / b, 2.9 * a / b), until=12.0 * b)
        assert scaled.impact_wall.values.tolist() == plain.impact_wall.values.tolist()
        np.testing.assert_allclose(scaled.impact_time / b, plain.impact_time, rtol=1e-9)
        assert scaled.trust == "certified"
    assert plain.sizes["impact"] > 8


@pytest.mark.parametrize("T", [1.0, 2.0**-15, 2.0**-90, 2.0**60])
def test_a_ball_inside_an_arc_is_not_taken_for_one_outside_in_other_units_of_time(T):
    # what counts as rounding of the first gap was measured by the coefficients of later times, too
    table = gz.table([gz.arc("ring", (0, 0), 5.0, 0.0, 2.0 * pi, gz.newton(0.9))], g=1.0 / T**2, tilt=0.4)
    block = table.blocks(table.row())[0]
    surface, t, _flags = exact_contact(block, (1.0, 0.5, 0.0, -2.0 / T), -1)
    plain = -(2.0 - sqrt(4.0 + 2.0 * sin(0.4) * (0.5 + sqrt(24.0)))) / sin(0.4)
    assert surface == 1 and t / T == pytest.approx(plain, rel=1e-14)


def test_sizes_whose_fourth_powers_are_no_doubles_are_refused():
    # a table of size 1e-200 had its impacts at t = 0, certified, or ended in a ZeroDivisionError
    for size in (1e-300, 1e-200, 1e-75, 1e75, 1e200):
        with pytest.raises(gz.InputError, match="choose other units"):
            gz.table([gz.disc("A", (3.0 * size, 0), size, ELASTIC)])
        with pytest.raises(gz.InputError, match=r"g sin\(tilt\) of the table"):
            gz.table([gz.disc("A", (3, 0), 1.0, ELASTIC)], g=size, tilt=1.0)
    for tiny in (gz.disc("B", (6, 0), 1e-308, ELASTIC), gz.arc("B", (6, 0), 1e-308, 0.0, 2.0, ELASTIC)):
        # one collision took exact arithmetic more than a minute
        with pytest.raises(gz.InputError, match="the smallest radius of the table is 1e-308"):
            gz.table([gz.disc("A", (3, 0), 1.0, ELASTIC), tiny])
    seen = []
    for L in (1e-55, 1.0, 1e55):  # and within the range all is the same
        table = gz.table([gz.disc("A", (3.0 * L, 4.1 * L), L, ELASTIC), *box(9.0 * L, 9.0 * L)])
        for v in (1e-55, 1.0, 1e55):
            found = gz.trajectory(table, (1.5 * L, L, v, 0.2 * v), until=40.0 * L / v)
            times = found.impact_time.values / L * v
            assert len(times) > 5 and found.outcome == "ok"
            seen.append(times[:3])
    assert np.ptp(seen, axis=0) == pytest.approx([0.0] * 3, abs=1e-9)


def test_a_ball_as_small_as_rounding_is_refused():
    """At 1e-12 it left closed rooms, certified: its circles around the ends of faces were narrower than rounding."""
    for size in (1e-6, 1.0, 1000.0):
        wall = gz.segment("wall", (0, 0), (3.0 * size, 0), ELASTIC)
        with pytest.raises(gz.InputError, match="give 0 or at least") as told:
            gz.table([wall], 1e-12 * size)
        least = float(str(told.value).rpartition(" ")[2])
        assert 2e-12 < least / size < 4e-12 and gz.table([wall], least).rho == least
    assert gz.table([wall], 0.0).rho == 0.0


def test_arcs_that_cross_something_are_refused_where_the_ball_has_no_radius():
    """They put it behind walls, certified; those that touch, end on something or go on in it are no such arcs."""
    wall, lane = gz.segment("wall", (-2, 0), (2, 0), ELASTIC), gz.segment("lane", (-3, -1), (0, -1), ELASTIC)
    bow = gz.arc("bow", (0, 0.3), 0.5, pi, 2.0 * pi, ELASTIC)
    for other in (gz.arc("B", (0.4, -0.3), 0.5, -1.0, 2.0, ELASTIC), wall):
        with pytest.raises(gz.InputError, match="cross; let one end at the other, as the ball has no radius"):
            gz.table([other, bow])
        assert gz.table([other, bow], 0.1).rho == 0.1
    for turn in np.linspace(0.0, 6.0, 25):
        c, s = cos(turn), sin(turn)
        touching = [
            [lane, gz.arc("bowl", (0, 0), 1.0, 1.5 * pi, 1.5 * pi + turn / 6.1 + 0.01, ELASTIC)],
            [gz.segment("floor", (-3, -1), (3, -1), ELASTIC), gz.arc("ring", (0, 0), 1.0, 0.0, 2.0 * pi, ELASTIC)],
            [gz.segment("wall", (3.0 * c, 3.0 * s), (5.0 * c, 5.0 * s), ELASTIC),
             gz.arc("foot", (3.0 * c + s, 3.0 * s - c), 1.0, turn + 0.5 * pi, turn + 2.0, ELASTIC)],
            [gz.arc("one", (0, 0), 1.0, turn, turn + 2.0, ELASTIC),
             gz.arc("next", (2.0 * c, 2.0 * s), 1.0, turn + pi, turn + 4.0, ELASTIC)],
        ]  # fmt: skip
        for objects in touching:
            assert gz.table(objects).rho == 0.0


def test_crossing_and_distance_know_no_unit():
    for size in (2.0**-600, 1.0, 2.0**600):
        one, two, three = (
            gz.segment(name, (a * size, b * size), (c * size, d * size), ELASTIC)
            for name, a, b, c, d in (("a", -1, 0, 1, 0), ("b", 0, -1, 0, 1), ("c", 2, -1, 2, 1))
        )
        assert crosses(one, two) and not crosses(one, three)
        assert (
            distance(one, 0.5 * size, 2.0 * size) == 2.0 * size and distance(one, 4.0 * size, 4.0 * size) == 5.0 * size
        )


@pytest.mark.parametrize("speed", [0.0, 1e-300, 1e-100])
def test_a_ball_at_rest_on_a_level_table_has_not_left_it(speed):
    # it was said to have escaped, away, at t = infinity
    table = gz.table([gz.disc("A", (3, 0), 1.0, gz.newton(0.0)), gz.drain("out", (-1, -1), (-1, 1))])
    found = gz.trajectory(table, (0.0, 0.0, speed, 0.0), until=10.0)
    assert found.outcome == "bounces too small to tell apart" and found.exit.item() == ""
    (left,) = gz.launches(table, (0.0, 0.0), [0.0], [speed, 1.0]).exit.values.tolist()
    assert left == ["", ""]  # the other one stops at the disc
    assert gz.launches(table, (0.0, 0.0), [np.pi], [1.0]).exit.item() == "out"


@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize("speed", [0.2, 0.3, 0.9])
def test_a_slingshot_fires_where_the_normal_speed_reaches_its_trigger(side, speed):
    """v+ = r v + V from the trigger on, r v below, from either side and at an end; what is along the band stays."""
    sling = gz.segment("sling", (1.0, 1.0), (3.0, 2.0), gz.triggered(r=0.6, V=2.0, trigger=0.3))
    table = gz.table([sling], rho=0.1)
    along, normal = np.array([2.0, 1.0]) / np.sqrt(5.0), side * np.array([-1.0, 2.0]) / np.sqrt(5.0)
    kicked = 0.6 * speed + (2.0 if speed >= 0.3 else 0.0)
    for centre, n, t in ((np.array([2.0, 1.5]), normal, along), (np.array([3.0, 2.0]), along, normal)):
        v = 0.25 * t - speed * (1.0 + 1e-12) * n
        start = centre + 0.1 * n - 0.5 * v
        flown = gz.trajectory(table, (*start, *v), until=2.0)
        assert flown.impact_wall.values.tolist() == ["sling"]
        left = np.array([flown.vx.values[-1], flown.vy.values[-1]])
        np.testing.assert_allclose((left @ n, left @ t), (kicked, 0.25), rtol=0, atol=1e-9)
