"""Sliding and resting: closed forms, elliptic integrals in many digits, energy, random tables."""

from math import cos, hypot, pi, sin, sqrt

import mpmath as mp
import numpy as np
import pytest

import grazing as gz
from grazing.billiard.check import free_place
from grazing.billiard.contact import next_event
from grazing.billiard.flown import AFTER, BEFORE, FLAGS, LAST, NEXT, OWNER, PATH, TIME, flights_of
from grazing.billiard.swing import swung
from grazing.billiard.turning import ON
from grazing.outcome import CHATTER, ESCAPED, FATAL, NO_IMPACT, STUCK

DEAD, SOFT, UP = gz.newton(0.0), gz.newton(0.5), 0.5 * pi


@pytest.mark.parametrize("unit", [1.0, 1e-9, 1e9])
@pytest.mark.parametrize("r", [0.0, 0.5, 0.7])
def test_along_a_rail_a_ball_falls_as_if_it_did_not_bounce(r, unit):
    """Without friction the motion along a straight rail is uniformly accelerated, whatever the ball does across it."""
    a, L, rho = 0.3, 40.0 * unit, 0.1 * unit
    end = (L * cos(a), -L * sin(a))
    table = gz.table([gz.segment("rail", (0, 0), end, gz.newton(r))], rho, 1.0 / unit, UP)
    start = np.array([0.5 * unit, 0.6 * unit])
    flights = flights_of(table, (*start, 0.0, 0.0), 0.0, np.inf)
    slid = int(np.flatnonzero(flights[:, PATH] == 1)[-1] if (flights[:, PATH] == 1).any() else 0)
    slid = slid or int(np.flatnonzero(flights[:, PATH] == 0)[-1])
    foot = start @ np.array([cos(a), -sin(a)])
    g = 1.0 / unit * sin(a)
    assert flights[: slid + 1, TIME].sum() == pytest.approx(sqrt(2.0 * (L - foot) / g), rel=1e-12)
    x, y, vx, vy = flights[slid, NEXT:PATH]
    assert hypot(x - end[0] - rho * sin(a), y - end[1] - rho * cos(a)) < 1e-12 * L
    assert (vx, vy) == pytest.approx(tuple(sqrt(2.0 * g * (L - foot)) * np.array([cos(a), -sin(a)])), rel=1e-12)
    assert int(np.bitwise_or.reduce(flights[:, FLAGS].astype(int))) & ~CHATTER == STUCK | ESCAPED


@pytest.mark.parametrize("v0", [1e-6, 0.1, 0.5])
def test_a_ball_leaves_a_disc_where_two_thirds_say(v0):
    """From the top of a disc with the speed v0: cos = 2/3 + v0^2/(3 g R), after an elliptic integral of time."""
    R = 1.5
    table = gz.table([gz.disc("d", (0, 0), 1.2, DEAD)], rho=0.3, tilt=UP)
    flights = flights_of(table, (0.0, R, v0, 0.0), 0.0, np.inf)
    (k,) = np.flatnonzero(flights[:, PATH] >= 0)
    x, y, vx, vy = flights[k, NEXT:PATH]
    c = 2.0 / 3.0 + v0**2 / (3.0 * R)
    assert y / R == pytest.approx(c, abs=1e-13) and x > 0.0
    assert hypot(vx, vy) ** 2 == pytest.approx(R * c, rel=1e-13) and abs(vx * x + vy * y) < 1e-14
    with mp.workdps(30):

        def slowness(q):
            return 1 / mp.sqrt((mp.mpf(v0) / R) ** 2 + 2 / mp.mpf(R) * (1 - mp.cos(q)))

        T = mp.quad(slowness, [0, *(mp.mpf(10) ** -k for k in (6, 5, 4, 3, 2, 1)), mp.acos(c)])
    # at the top the way is unstable: what the place is rounded by counts in units of the way that v0 makes
    assert flights[k, TIME] == pytest.approx(float(T), rel=1e-12, abs=2e-15 / v0)
    assert int(flights[-1, FLAGS]) & ESCAPED and len(flights) <= k + 2


@pytest.mark.parametrize("amplitude", [0.3, 1.2])
def test_in_a_cup_it_is_a_pendulum(amplitude):
    R = 1.75
    table = gz.table([gz.arc("cup", (0, 0), 2.0, pi, 2.0 * pi, DEAD)], rho=0.25, tilt=UP)
    place = R * sin(amplitude), -R * cos(amplitude)
    period = float(4 * mp.sqrt(R) * mp.ellipk(mp.sin(mp.mpf(amplitude) / 2) ** 2))
    flown = gz.trajectory(table, (*place, 0.0, 0.0), until=3.0 * period, samples=600)
    assert flown.outcome == "stays for ever" and flown.trust == "certified"
    np.testing.assert_allclose(np.hypot(flown.x, flown.y), R, rtol=1e-13)
    energy = 0.5 * (flown.vx**2 + flown.vy**2) + flown.y
    assert np.ptp(energy.values) < 1e-12
    assert float(flown.x[-1]) == pytest.approx(place[0], abs=1e-10)
    half = np.interp(0.5 * period, flown.t, flown.x)
    assert half == pytest.approx(-place[0], abs=1e-3)
    found = gz.launches(table, place, 0.0, 0.0)
    assert int(found.outcome.item()) & FATAL == NO_IMPACT and found.exit.item() == ""


def test_the_series_of_a_pendulum_is_right_in_double_precision():
    for a, w, b in ((1.2, 0.3, 2.0), (-1.0, 5.0, 1.0), (4.0, 0.0, -3.0)):
        with mp.workdps(20):
            y = mp.odefun(lambda _t, y, b=b: [y[1], -b * mp.cos(y[0])], 0, [mp.mpf(a), mp.mpf(w)])(2)
        turned, rate = swung(a, w, b, 2.0)
        assert abs(a + turned - float(y[0])) < 1e-14 and abs(rate - float(y[1])) < 2e-14


def test_a_ball_rolls_round_the_end_of_a_ledge_and_off_it():
    """At the edge it is on a circle of its own radius: it leaves there with cos = 2/3 + v^2/(3 g rho)."""
    rho, v = 0.5, 0.3
    table = gz.table([gz.segment("ledge", (-2, 0), (0, 0), DEAD), gz.drain("out", (-9, -5), (9, -5))], rho, tilt=UP)
    flown = flights_of(table, (-1.0, rho, v, 0.0), 0.0, np.inf)
    face, tip = np.flatnonzero(flown[:, PATH] >= 0)
    assert flown[face, TIME] == pytest.approx(1.0 / v, rel=1e-13)
    x, y = flown[tip, NEXT : NEXT + 2]
    assert hypot(x, y) == pytest.approx(rho, rel=1e-14)
    assert y / rho == pytest.approx(2.0 / 3.0 + v * v / (3.0 * rho), abs=1e-13)
    assert table.names[int(flown[-1, OWNER])] == "out"
    fast = flights_of(table, (-1.0, rho, 2.0, 0.0), 0.0, np.inf)  # no force presses it on the tip
    assert fast[fast[:, PATH] >= 0, TIME].tolist() == [0.5, 0.0] and len(fast) == len(flown)


def test_it_passes_from_a_lane_into_a_bowl_without_an_impact():
    lane, bowl = gz.segment("lane", (-3, -2), (0, -2), DEAD), gz.arc("bowl", (0, 0), 2.0, 1.5 * pi, 2.0 * pi, DEAD)
    table = gz.table([lane, bowl], rho=0.25, tilt=UP)
    flown = gz.trajectory(table, (-2.0, -1.75, 1.0, 0.0), until=12.0)
    assert flown.sizes["impact"] == 0 and flown.trust == "certified"
    assert float(flown.y.max()) == pytest.approx(-1.75 + 0.5, abs=1e-3) and float(flown.vx.min()) == -1.0


def test_in_a_wedge_it_rests_between_two_and_a_stroke_is_an_impact():
    stroke = {"up": 10.0, "down": 8.0}
    flipper = gz.flipper("F", (0, 0), 2.0, 0.2, 0.35, 0.5, SOFT, **stroke)
    wall = gz.segment("wall", (0.5, 0.65), (0.5, 3), SOFT)
    table = gz.table([flipper, wall], rho=0.15, tilt=UP, player=gz.presses(F=[30.0, 30.3]))
    flights = flights_of(table, (1.2, 1.0, 0.0, 0.0), 0.0, 30.005)
    k = int(np.flatnonzero(flights[:, PATH] >= 0)[-1])
    x, y, vx, vy = flights[k, NEXT:PATH]
    assert (vx, vy) == (0.0, 0.0) and flights[: k + 1, TIME].sum() == pytest.approx(30.0)
    distances = table.distances(x, y)
    assert max(abs(room - 0.15) for room in distances.values()) < 1e-12
    struck = flights[k + 1]
    push = 10.0 * (x * cos(0.35) + y * sin(0.35))  # the surface's velocity along its normal
    assert struck[TIME] == 0.0 and struck[BEFORE] == pytest.approx(-push) and struck[AFTER] == pytest.approx(0.5 * push)
    still = gz.table([flipper, wall], rho=0.15, tilt=UP)
    found = gz.launches(still, (1.2, 1.0), 0.0, 0.0)
    assert int(found.outcome.item()) & FATAL == NO_IMPACT


def test_a_flipper_sweeps_a_ball_off_a_rail():
    flipper = gz.flipper("F", (0, 0.3), 2.0, 0.1, 0.9, -0.05, DEAD, up=3.0, down=3.0)
    floor = gz.segment("floor", (-1, -1), (6, -1), DEAD)
    table = gz.table([flipper, floor], rho=0.2, tilt=UP, player=gz.presses(F=[1.0, 3.0]))
    for x in (1.0, 5.0):
        flights = flights_of(table, (x, -0.8, 0.0, 0.0), 0.0, 2.5)
        hit = flights[flights[:, OWNER] == 0]
        assert len(hit) == 0  # it ends above the ball
    low = gz.flipper("F", (0, 0.3), 2.0, 0.1, 0.9, -0.55, DEAD, up=3.0, down=3.0)
    table = gz.table([low, floor], rho=0.2, tilt=UP, player=gz.presses(F=[1.0, 3.0]))
    flights = flights_of(table, (1.5, -0.8, 0.0, 0.0), 0.0, 2.5)
    hit = flights[flights[:, OWNER] == 0]
    clock = np.cumsum(flights[:, TIME])[np.flatnonzero(flights[:, OWNER] == 0)[0]]
    assert len(hit) >= 1 and abs(table.distances(1.5, -0.8, clock)["F"] - 0.2) < 1e-12 and hit[0, BEFORE] < 0.0


def test_maps_launches_and_trajectories_slide_alike():
    rail = gz.segment("rail", (0, 2), (4, 1), SOFT)
    table = gz.table(
        [rail, gz.segment("end", (4.5, 0), (4.5, 2), SOFT), gz.drain("out", (-1, 0), (4.5, 0))], 0.1, 1, 0.1
    )
    flown = gz.trajectory(table, (1.0, 3.0, 0.0, 0.0), until=900.0)
    found = gz.launches(table, (1.0, 3.0), 0.0, 0.0)
    assert flown.outcome == "escaped" and flown.exit == found.exit.item() == "out"
    assert int(found.hits.item()) == flown.sizes["impact"]
    assert float(found.time.item()) == pytest.approx(float(flown.t[-1]), rel=1e-12)
    P = gz.collision_map(table)
    x, y, vx, vy = flown.after.values[0]
    ex, ey = 4.0 / sqrt(17.0), -1.0 / sqrt(17.0)
    foot, along, away = (x * ex + (y - 2.0) * ey), vx * ex + vy * ey, -vx * ey + vy * ex
    place = P.box[0][0] + sqrt(17.0) - foot  # the left side is behind its length
    orbit = P.orbit((place, np.arctan2(-along, away), hypot(vx, vy)), flown.sizes["impact"])
    names = [table.names[k] for k in orbit.letters[: flown.sizes["impact"] - 1]]
    assert names == flown.impact_wall.values[1:].tolist() and names[-1] == "end"


def layout(random):
    """Objects of all kinds at random places, soft ones, some of which touch."""
    rho, tilt = float(random.choice([0.1, 0.3])), float(random.choice([0.1, UP]))

    def law():
        return gz.newton(float(random.uniform(0.0, 0.7)))

    sides = [("floor", (0, 1), (8, 0)), ("left", (0, 0), (0, 9)), ("right", (10, 0), (10, 9))]
    objects = [gz.segment(*side, law()) for side in sides] + [gz.drain("out", (8, 0), (10, 0))]

    def add(one):
        try:
            gz.table([*objects, one], rho, tilt=tilt)
        except gz.InputError:
            return
        objects.append(one)

    for i in range(7):
        p, a = random.uniform(1.5, 8.5, 2), random.uniform(-1.0, 1.0)
        if i % 3 == 0:
            add(gz.disc(f"disc{i}", p, random.uniform(0.2, 1.0), law()))
        elif i % 3 == 1:
            q = p + random.uniform(0.5, 3.0) * np.array([cos(a), sin(a)])
            add(gz.segment(f"rail{i}", p, q, law()))
            add(gz.segment(f"next{i}", q, q + random.uniform(0.5, 2.0) * np.array([cos(a - 0.7), sin(a - 0.7)]), law()))
        else:
            R, begin = random.uniform(0.5, 2.0), pi + random.uniform(0.1, 1.3)
            end = p + R * np.array([cos(begin), sin(begin)])
            add(gz.arc(f"bowl{i}", p, R, begin, begin + random.uniform(0.5, 2.0), law()))
            add(gz.segment(f"lane{i}", end + np.array([sin(begin), -cos(begin)]), end, law()))
    return gz.table(objects, rho, tilt=tilt)


@pytest.mark.parametrize("seed", range(12))
def test_on_random_tables_balls_stay_outside_of_things_and_gain_no_energy(seed):
    random = np.random.default_rng(seed)
    table = layout(random)
    for _ in range(3):
        speed = sqrt(table.gravity)
        state = (*free_place(table, random), *(random.uniform(-2.0, 2.0, 2) * speed))
        flown = gz.trajectory(table, state, until=60.0 / speed, samples=300)
        assert flown.outcome in ("ok", "escaped", "stays for ever")
        energy = 0.5 * (flown.vx.values**2 + flown.vy.values**2) + table.gravity * flown.y.values
        assert np.diff(energy).max() < 1e-11 * abs(energy).max()
        for x, y in zip(flown.x.values[::5].tolist(), flown.y.values[::5].tolist(), strict=True):
            rooms = table.distances(x, y)
            assert all(room > table.rho - 1e-9 for name, room in rooms.items() if name != "out"), (seed, state)
        step = np.hypot(np.diff(flown.x), np.diff(flown.y))
        fast = np.hypot(flown.vx, flown.vy).values
        assert (
            step <= (np.maximum(fast[1:], fast[:-1]) + table.gravity * np.diff(flown.t)) * np.diff(flown.t) + 1e-9
        ).all()


@pytest.mark.parametrize("side", [-0.9, 0.9])
def test_a_ball_without_a_radius_slides_in_a_bowl(side):
    """It fell through, certified: both sides are one circle, and a doubt about the other one was decided."""
    bowl = gz.table([gz.arc("bowl", (0.0, 0.0), 1.0, np.pi, 2.0 * np.pi, gz.newton(0.0))], tilt=1.0)
    flown = gz.trajectory(bowl, (np.sin(side), -0.6 * np.cos(side), 0.0, 0.0), until=9.0)
    later = flown.t.values > flown.impact_time.values[0]
    assert flown.outcome == "stays for ever" and flown.trust.item() == "certified"
    np.testing.assert_allclose(np.hypot(flown.x, flown.y).values[later], 1.0, rtol=1e-13)


@pytest.mark.parametrize(("r", "start"), [(0.0, (-0.34, 2.8, -0.12, 0.0)), (0.4, (0.5, 2.5, 0.2, 0.0))])
def test_a_ball_without_a_radius_comes_to_rest_in_a_corner(r, start):
    """It fell through, certified: moving away from one side of a face it met the other one, at the same place."""
    faces = [gz.segment("a", (-2, 2), (0, 0), gz.newton(r)), gz.segment("b", (0, 0), (2, 1.5), gz.newton(r))]
    flown = gz.trajectory(gz.table(faces, tilt=1.0), start, until=100.0, samples=2)
    assert flown.outcome == "stays for ever" and hypot(flown.x[-1], flown.y[-1]) < 1e-3


@pytest.mark.parametrize("rho", [0.0, 0.02, 0.25])
def test_a_wall_that_runs_into_a_bowl_leaves_no_way_out_between_them(rho):
    law, (x, y) = gz.newton(0.0), (3.7, -1.3)
    bowl = gz.arc("bowl", (x, y), 1.0, np.pi, 2 * np.pi, law)
    walls = [gz.segment(name, (x + side, y), (x + side, y + 4), law) for name, side in (("left", -1), ("right", 1))]
    found = gz.trajectory(gz.table([bowl, *walls], rho=rho, tilt=1.0), (x - 0.7, y + 1.5, -0.5, 0.0), until=20.0)
    t, across, up = found.t.values, found.x.values - x, found.y.values - y
    after = t > 2.0  # the left wall took the speed along its normal
    height = up + (found.vx.values**2 + found.vy.values**2) / (2.0 * np.sin(1.0))
    assert np.ptp(height[after]) < 1e-13 and found.trust == "certified"
    assert (up > rho - 1 - 1e-12).all() and (np.abs(across) < 1 - rho + 1e-12).all()
    assert across.max() > 0.7 and up[across > 0.0].max() > 1.0  # over to the other wall, and up along it


def test_a_ball_without_a_radius_bounces_in_a_corner_whose_end_rounding_put_it_beyond():
    law = gz.newton(0.4)
    floor, wall = gz.segment("floor", (-2, 0.3), (2, 0), law), gz.segment("wall", (2, 0), (2, 4), law)
    table = gz.table([floor, wall, gz.segment("far", (-2, 0.3), (-2, 4), law)], rho=0.0, tilt=1.0)
    for start in (-0.31, 0.07, 0.52, 0.64):
        found = gz.trajectory(table, (start, 2.0, 0.3, 0.0), until=60.0)
        assert float(found.y.min()) > -1e-12, start


@pytest.mark.parametrize("slope", [0.05, 0.5, 0.9])
@pytest.mark.parametrize("more", ["bowl", "lane"])
def test_a_ball_without_a_radius_goes_on_where_the_next_surface_begins_without_a_kink(slope, more):
    """There is no circle around the end of the lane to hand it on: it fell through what follows, certified."""
    along, up, law = np.array([cos(slope), -sin(slope)]), np.array([sin(slope), cos(slope)]), gz.newton(0.0)
    joint = np.array([0.7, -0.3])
    centre = joint + 1.3 * up
    begin = np.arctan2(*(joint - centre)[::-1])
    after = gz.arc("next", centre, 1.3, begin, begin + slope + 1.0, law)
    if more == "lane":
        after = gz.segment("next", joint, joint + along, law)
    lane = gz.segment("lane", joint - 2.0 * along, joint, law)
    flights = flights_of(gz.table([lane, after], tilt=UP), (*(joint - along + 0.1 * up).tolist(), 0.1, 0.0), 0.0, 5.0)
    first, second = (flights[k] for k in np.flatnonzero(flights[:, PATH] >= 0.0)[:2])
    height = [0.5 * hypot(*one[LAST + 2 : NEXT]) ** 2 + one[LAST + 1] for one in (first, second)]
    assert second[TIME] > 0.1 and second[PATH] != first[PATH] and height[0] == pytest.approx(height[1], rel=1e-12)


@pytest.mark.parametrize("rho", [0.0, 0.1])
@pytest.mark.parametrize("r", [1.0, 0.75])
def test_it_comes_to_the_other_side_of_what_it_slides_away_from(r, rho):
    """A floor across a dome, a lid across a bowl, a post in a ring: one surface at both ends of a way along another."""
    dome = [gz.segment("floor", (-2, 0), (2, 0), DEAD), gz.arc("wall", (0, 0), 2.0, 0.0, pi, gz.newton(r))]
    flown = gz.trajectory(gz.table(dome, rho, tilt=UP), (0.0, rho, 1.0, 0.0), until=20.0)
    far, keeps = sqrt((2.0 - rho) ** 2 - rho**2), 1.0 - (1.0 + r) * (1.0 - (rho / (2.0 - rho)) ** 2)
    times = np.cumsum([far, *(2.0 * far / abs(keeps) ** k for k in range(1, 9))])
    walls = flown.impact_time.values[flown.impact_wall.values == "wall"]
    assert walls == pytest.approx(times[times < 20.0], rel=1e-12) and abs(flown.x.values).max() < far + 1e-12

    half = sqrt(1.5**2 - 0.3**2)
    lid = gz.segment("lid", (-half, -0.3), (half, -0.3), gz.newton(r))
    bowl = gz.table([lid, gz.arc("bowl", (0, 0), 1.5, pi, 2.0 * pi, DEAD)], rho, tilt=UP)
    flown = gz.trajectory(bowl, (0.0, rho - 1.5, 2.0, 0.0), until=20.0)
    assert flown.y.values.max() < -0.3 - rho + 1e-12 and (flown.impact_wall.values == "lid").sum() > 4

    ring = [gz.disc("post", (1.1, 0.0), 0.3, gz.newton(r)), gz.arc("ring", (0, 0), 1.5, 0.0, 2.0 * pi, DEAD)]
    flown = gz.trajectory(gz.table(ring, 0.1), (0.0, -1.4, 1.0, 0.0), until=60.0)
    assert np.hypot(flown.x - 1.1, flown.y).values.min() > 0.4 - 1e-12
    assert flown.outcome == "ok" and (flown.impact_wall.values == "post").sum() >= 2


@pytest.mark.parametrize("side", [1, -1])
def test_from_a_dome_onto_a_wall_of_a_level_table_it_hits_the_floor(side):
    """Nothing presses it on there; it was taken for one that slid off the floor, which was ahead, and went through."""
    walls = [gz.segment("wall", (2 * side, -3), (2 * side, 0), SOFT), gz.segment("floor", (-3, -3), (3, -3), SOFT)]
    table = gz.table([gz.arc("dome", (0, 0), 2.0, 0.0, pi, DEAD), *walls], 0.1)
    flown = gz.trajectory(table, (0.0, 1.2, side, 0.2), until=20.0)
    assert flown.y.values.min() > -2.9 - 1e-12 and "floor" in flown.impact_wall.values


@pytest.mark.parametrize("speed", [1e-3, 1e-15, 1e-30])
def test_a_ball_in_a_corner_slides_on_at_any_speed_without_a_doubt(speed):
    """Slower than 1e-15 it left the wall by less than rounding tells: each flight of no time was decided exactly."""
    walls = [gz.segment("wall", (0, 5), (0, 0), SOFT), gz.segment("floor", (0, 0), (6, 0), SOFT)]
    table = gz.table(walls, 0.2, tilt=0.3)
    found = next_event(0.2, 0.2, speed, 0.0, 0.0, 0.0, table.blocks(table.row(), "python")[0])
    (_surface, owner, t, flags, left), _before, after, _speeds = found
    assert (owner, t, flags, left) == (-1, 0.0, STUCK, 2.0 + ON) and after == (0.2, 0.2, speed, 0.0)


@pytest.mark.parametrize(("high", "waits"), [(3.0, False), (0.9, True)])
def test_a_slide_waits_only_for_flippers_that_reach_its_way(high, waits):
    """A slow ball on the floor waited at each stroke of a flipper above: ten thousand slides, and it ended by name."""
    one = gz.flipper("F", (3, high), 0.5, 0.05, 0.0, 1.0, SOFT, up=10.0, down=5.0)
    things = [gz.segment("floor", (0, 0), (6, 0), SOFT), gz.segment("wall", (6, 0), (6, 5), SOFT), one]
    table = gz.table(things, 0.2, tilt=0.3, player=gz.flips(1.0, 0.3))
    block = table.blocks(table.row(), "python")[0]
    (_surface, owner, t, flags, _left), *_rest = next_event(1.0, 0.2, 0.01, 0.0, ON, 0.0, block)
    assert (owner, flags) == ((-1, STUCK) if waits else (1, STUCK))
    assert t == pytest.approx(0.1 if waits else 480.0)
