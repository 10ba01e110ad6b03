"""Trajectories on tables: closed forms, conservation laws, time reversal, ways out."""

import pickle
from functools import partial
from math import pi, sqrt

import numpy as np
import pytest

import grazing as gz
from grazing.billiard import flown as module
from grazing.billiard.hit import spot
from grazing.maps.collide import velocity
from tests.billiard.tables import ELASTIC, box, energy, layout, mixed, three_discs


def test_a_ball_in_a_box_is_where_unfolding_puts_it():
    start, until = np.array([0.3, 0.7, 0.91, -0.37]), 2000.0
    flown = gz.trajectory(gz.table(box(1.0, 2.0)), start, until=until, samples=2)
    x, y = flown.x.values, flown.y.values
    for found, at, speed, width in ((x, 0.3, 0.91, 1.0), (y, 0.7, -0.37, 2.0)):
        way = (at + speed * flown.t.values) % (2.0 * width)
        np.testing.assert_allclose(found, np.minimum(way, 2.0 * width - way), atol=2e-10)
    assert flown.sizes["impact"] == int(0.3 + 0.91 * until) + int((2.0 - 0.7 + 0.37 * until) / 2.0)
    assert flown.trust == "certified" and flown.outcome == "ok" and flown.exit == ""


def test_a_flight_without_flippers_is_the_same_at_any_hour():
    table, start = gz.table(box(1.0, 2.0)), (0.3, 0.7, 0.91e9, -0.37e9)
    early, late = gz.trajectory(table, start, until=1e-8), gz.trajectory(table, start, 1000.0, 1000.0 + 1e-8)
    assert (late.before.values == early.before.values).all() and late.sizes["impact"] == 9 + 2
    assert (late.impact_time.values == 1000.0 + early.impact_time.values).all() and late.t.values[-1] == 1000.0 + 1e-8


def test_a_ball_on_a_floor_bounces_in_geometric_times_and_rests():
    table = gz.table([gz.segment("floor", (-9, 0), (9, 0), gz.newton(0.5))], rho=0.5, tilt=pi / 2)
    flown = gz.trajectory(table, (0.0, 1.0, 0.0, 0.0), until=9.0, samples=2)
    n = np.arange(19)
    np.testing.assert_allclose(flown.impact_time.values[:19], 3.0 - 2.0 ** (1.0 - n), atol=1e-13)
    assert flown.outcome == "stays for ever" and flown.sizes["impact"] < 60 and flown.trust == "certified"
    assert flown.t.values[-1] == 9.0 and flown.y.values[-1] == 0.5


def test_a_ball_that_bounces_for_ever_ends_by_name(monkeypatch):
    monkeypatch.setattr(module, "played_flights", partial(module.played_flights, most=9))
    flown = gz.trajectory(gz.table(box(1.0, 1.0)), (0.3, 0.4, 1.0, 0.5), until=60.0)
    assert flown.outcome == "too many impacts" and flown.sizes["impact"] == 9


def test_energy_stays_over_many_collisions():
    table = gz.table([*layout(8), *box()], tilt=pi / 2)
    flown = gz.trajectory(table, (0.2, 9.0, 0.5, 1.0), until=6000.0, samples=2)
    E = energy(flown, 1.0)
    assert flown.sizes["impact"] > 5000
    assert np.ptp(E) < 1e-12 * E[0]


@pytest.mark.long
def test_energy_stays_over_a_million_collisions():
    table = gz.table([*layout(8), *box()], tilt=pi / 2)
    P, start = gz.collision_map(table), np.array([[0.5], [0.3], [4.0]])
    E0 = _energy(P, table, start[:, 0])
    P.run(start, 1_000_000, 0)
    assert abs(_energy(P, table, start[:, 0]) - E0) < 1e-10 * E0


def _energy(P, table, state):
    _surface, _x, y, *_rest = spot(state[0], table.blocks(table.row(), "python")[0])
    return 0.5 * state[2] ** 2 + table.gravity * y


def test_time_runs_backwards_as_well_as_the_tangent_allows():
    """Fifty collisions there and back: what is rounded at one end has grown at the other as the tangent says."""
    table = gz.table([*layout(1), *box()], tilt=pi / 2)
    P, block = gz.collision_map(table), table.blocks(table.row(), "python")[0]
    tried = 0
    for angle in np.linspace(-1.4, 1.4, 41):
        state, s = (0.4, angle, 3.5), 0.01
        orbit = P.orbit(state, 51)
        J, grown = np.eye(3), 1.0
        for point in orbit.points[:50]:
            J = P.jacobian(point) @ J
            grown = max(grown, np.linalg.norm(J, 2))
        if grown > 1e10:  # nothing would be left of sixteen digits
            continue
        _surface, x, y, nx, ny, _curvature = spot(state[0], block)
        vx, vy = velocity(nx, ny, *state[1:])
        start = np.array([x + vx * s, y + (vy - 0.5 * s) * s, vx, vy - s])
        there = gz.trajectory(table, start, until=400.0, samples=2)
        names = [table.names[k] for k in orbit.letters]
        assert there.impact_wall.values[:51].tolist() == names
        until = 0.5 * float(there.impact_time[49] + there.impact_time[50])
        there = gz.trajectory(table, start, until=until, samples=2)
        x, y, vx, vy = (float(there[name][-1]) for name in ("x", "y", "vx", "vy"))
        back = gz.trajectory(table, (x, y, -vx, -vy), until=until, samples=2)
        assert back.impact_wall.values.tolist() == names[49::-1]
        end = np.array([float(back[name][-1]) for name in ("x", "y", "vx", "vy")])
        assert np.abs(end * [1, 1, -1, -1] - start).max() < 50 * 2.0**-52 * 10.0 * grown
        tried += 1
    assert tried > 2


def test_a_ball_leaves_through_a_drain_or_for_good():
    table = gz.table([gz.disc("post", (0, 0), 1.0, ELASTIC), gz.drain("out", (-50, -3), (50, -3))], rho=0.1, tilt=0.4)
    flown = gz.trajectory(table, (0.3, 3.0, 0.0, 0.0), until=99.0)
    assert (flown.outcome, flown.exit.item(), flown.impact_wall.values.tolist()) == ("escaped", "out", ["post"])
    assert flown.y.values[-1] == pytest.approx(-3.0, abs=1e-12)
    away = gz.trajectory(three_discs(6.0), (3.0, 1.0, 0.0, -1.0), until=20.0)
    assert (away.outcome, away.exit.item(), away.sizes["impact"]) == ("escaped", "away", 0)
    before = gz.trajectory(table, (0.3, 3.0, 0.0, 0.0), until=1.0)
    assert (before.outcome, before.exit.item()) == ("ok", "")


def test_an_active_bumper_adds_its_kick_to_the_normal_velocity_only():
    table = gz.table([gz.disc("bumper", (0, 0), 1.0, gz.active(r=0.5, V=0.75))], rho=0.5)
    flown = gz.trajectory(table, (-4.0, 1.5 / sqrt(2.0), 2.0, 0.0), until=3.0)
    n, t = np.array([-1.0, 1.0]) / sqrt(2.0), np.array([1.0, 1.0]) / sqrt(2.0)
    (after,), (before,) = flown.after.values, flown.before.values
    assert before[2:] @ n == pytest.approx(-sqrt(2.0)) and flown.v_minus.values == pytest.approx([-sqrt(2.0)])
    assert after[2:] @ n == pytest.approx(0.5 * sqrt(2.0) + 0.75) and after[2:] @ t == pytest.approx(sqrt(2.0))


def test_laws_of_ones_own_act_and_are_blamed():
    def soft(v, p):
        return -p.r * v / (1.0 - p.c * v)

    def wrong(v, p):
        return -1.0 if v < -1.0 else 0.0

    table = gz.table([gz.disc("bumper", (0, 0), 1.0, gz.reset(soft, r=0.8, c=0.1))])
    flown = gz.trajectory(table, (-4.0, 0.0, 2.0, 0.0), until=3.0)
    assert flown.v_plus.values == pytest.approx([1.6 / 1.2]) and table.params["bumper.c"] == 0.1
    with pytest.raises(gz.UserCodeError, match="the reset law wrong returned -1"):
        gz.trajectory(gz.table([gz.disc("bumper", (0, 0), 1.0, gz.reset(wrong))]), (-4.0, 0.0, 2.0, 0.0), until=3.0)


def test_starts_that_are_not_allowed_are_refused():
    table = mixed(0.2)
    for state, said in (
        ((1.5, 3.1, 0.0, 0.0), r"a ball of radius 0.2 at \(1.5, 3.1\) overlaps post by 0.5"),
        ((0.1, 5.0, 0.0, 0.0), "overlaps left by 0.1"),
        ((1.0, 2.0, 3.0), "give 4 numbers"),
        ((1.0, 2.0, 3.0, float("nan")), "vy = nan is not finite"),
    ):
        with pytest.raises(gz.InputError, match=said):
            gz.trajectory(table, state)


def test_a_ball_that_never_leaves_ends_at_a_budget(monkeypatch):
    from grazing.billiard import flown as module

    flights = module.flights_of(gz.table(box(1.0, 1.0)), (0.3, 0.4, 1.0, 0.7), 0.0, 1e9, most=5000)
    assert len(flights) == 5000
    assert gz.Outcome(int(flights[-1, module.FLAGS])) == gz.Outcome.too_many_impacts


def test_a_trajectory_goes_on_in_pieces_and_a_table_through_a_pickle():
    table = mixed(0.25)
    whole = gz.trajectory(table, (0.7, 1.0, 1.1, 2.9), until=8.0)
    again = gz.trajectory(pickle.loads(pickle.dumps(table)), (0.7, 1.0, 1.1, 2.9), until=8.0)
    assert whole.identical(again)


def test_the_last_of_all_impacts_allowed_is_where_it_was(monkeypatch):
    """Its time was that of the one before, as that of a flight without an end."""
    monkeypatch.setattr(module, "played_flights", partial(module.played_flights, most=5))
    found = gz.trajectory(gz.table(box(1.0, 1.0)), (0.5, 0.5, 1.0, 0.0), until=90.0, samples=2)
    np.testing.assert_allclose(found.impact_time, [0.5, 1.5, 2.5, 3.5, 4.5])
    assert found.outcome == "too many impacts" and found.t[-1] == 4.5


def test_impacts_that_take_no_time_end_by_name():
    """Where the inside of a dome runs into a segment by rounding, a sliding ball came to both in turn, for an hour."""
    x, y, law = -6.549861652892474, 4.115623321421644, gz.triggered(0.6450598398919127, 0.6577549717644563, 1.39)
    wall = gz.segment("left", (x, 0.0), (0.0, 0.0), gz.newton(0.0)), gz.segment("right", (0.0, y), (x, y), ELASTIC)
    table = gz.table([*wall, gz.arc("top", (x, y / 2), y / 2, pi / 2, 3 * pi / 2, law)], rho=0.0922778247380345)
    start = -5.514421755419415, 3.942555132582573, -1.7657450624970692, -0.1847135785145091
    found = gz.trajectory(table, start, until=9.0, samples=2)
    assert found.outcome == "too many impacts" and np.ptp(found.impact_time[-200:].values) == 0.0
    assert module.STILL < len(found.impact_time) < 2 * module.STILL


def test_it_ends_at_the_tip_of_a_flipper_on_which_it_slid_there():
    """It ended where that slide began."""
    one = gz.flipper("F", (0, 0), 2.0, (0.1, 0.1), 0.0, -0.3, gz.newton(0.0), up=0.05, down=1.0)
    table = gz.table([one], 0.1, tilt=0.5, player=gz.presses(F=[0.0]))
    found = gz.trajectory(table, (1.9, 0.2, 0.1, 0.0), until=9.0, samples=50)
    angle = 0.05 * float(found.t[-1])
    assert found.outcome == "bounces too small to tell apart"
    np.testing.assert_allclose(np.hypot(found.x[-1], found.y[-1]), np.hypot(2.0, 0.2))
    np.testing.assert_allclose(found.y[-1], 0.2 * np.cos(angle) - 2.0 * np.sin(angle), atol=1e-12)


def test_a_flight_as_long_as_numbers_reach_is_sampled_without_a_warning():
    table = gz.table([gz.segment("floor", (-1.0, 0.0), (1.0, 0.0), gz.newton(0.5))], g=1.0, tilt=0.3)
    flown = gz.trajectory(table, (0.0, 1.0, 0.0, 0.0), until=1e308, samples=100)
    assert np.isfinite(flown["y"]).all() and flown["t"].values[-1] == 1e308
