"""Trajectories of systems of one's own, against oscillators, closed forms, energy and another integrator."""

import pickle
from math import sqrt

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import grazing as gz
from tests.systems.balls import beam, billiard, bouncing, parabola, table_bound
from tests.systems.models import oscillator


@pytest.mark.parametrize("walls", [1, 2])
@pytest.mark.parametrize("kind", [{}, {"alpha": 3.0, "k": 1.0, "omega": 2.2}, {"alpha": 0.0, "k": 2.0, "omega": 1.3}])
def test_an_oscillator_written_again_has_the_same_impacts(walls, kind):
    system, model = oscillator(walls=walls, **kind)
    box, count = np.array(system.box), 0
    for start in np.random.default_rng(0).uniform(box[:, 0], box[:, 1], (12, 2)):
        a, b = gz.trajectory(system, start, until=12.0), gz.trajectory(model, start, until=12.0)
        assert a.sizes["impact"] == b.sizes["impact"] and a.outcome == "ok" and a.trust == "numerical"
        np.testing.assert_allclose(a.impact_time, b.impact_time, rtol=0, atol=1e-12)
        np.testing.assert_allclose(np.abs(a.v_plus), np.abs(b.v_plus), rtol=0, atol=1e-11)
        if walls == 2:
            assert a.impact_wall.values.tolist() == b.impact_wall.values.tolist()
        np.testing.assert_allclose(np.interp(b.t, a.t, a.u), b.u, atol=1e-3)
        count += a.sizes["impact"]
    assert count > 1


def test_a_ball_on_a_floor_at_rest_bounces_in_geometric_times():
    flown = gz.trajectory(bouncing(A=0.0, r=0.5), (0.5, 0.0), until=2.99, samples=5)
    n = np.arange(8)  # the first after 1, then 1, 1/2, 1/4, ...
    np.testing.assert_allclose(flown.impact_time.values[:8], 3.0 - 2.0 ** (1.0 - n), atol=1e-14)
    np.testing.assert_allclose(flown.v_plus.values[:8], 0.5 ** (n + 1), atol=1e-14)


def test_a_ball_on_a_vibrating_table_has_the_orbit_of_the_closed_form():
    """g T/2 (1 - r) = (1 + r) A omega cos(phi): it leaves and lands with g T/2 once per period."""
    r, A, g, T = 0.6, 0.05, 1.0, 1.0
    phi = np.arccos(g * T / 2 * (1 - r) / ((1 + r) * A * 2 * np.pi))
    start = (A * np.sin(phi), g * T / 2)
    flown = gz.trajectory(bouncing(A=A, r=r), start, start=phi / (2 * np.pi), until=phi / (2 * np.pi) + 4.5)
    np.testing.assert_allclose(flown.impact_time.values, phi / (2 * np.pi) + np.arange(1, 5), atol=1e-12)
    np.testing.assert_allclose(flown.after.values[:, 1], g * T / 2, atol=1e-12)


def test_a_ball_in_a_box_keeps_its_energy_and_is_where_unfolding_puts_it():
    start, until = np.array([0.3, 0.7, 0.91, -0.37]), 2000.0
    flown = gz.trajectory(billiard(), start, until=until, samples=2)
    x, y, vx, vy = (flown[name].values for name in ("x", "y", "vx", "vy"))
    np.testing.assert_allclose(vx**2 + vy**2, (start[2:] ** 2).sum(), rtol=1e-13)
    for found, at, speed, width in ((x, 0.3, 0.91, 1.0), (y, 0.7, -0.37, 2.0)):
        way = (at + speed * flown.t.values) % (2.0 * width)
        np.testing.assert_allclose(found, np.minimum(way, 2.0 * width - way), atol=2e-10)
    assert flown.sizes["impact"] == int(0.3 + 0.91 * until) + int((2.0 - 0.7 + 0.37 * until) / 2.0)


def test_a_beam_of_two_modes_hits_its_stop_where_scipy_finds_it():
    system, start = beam(), np.array([-0.1, 0.02, 0.2, 0.05])
    p = system.params
    K = np.array([p["k1"], p["k2"]])
    push = np.array([1.0, -0.5]) * p["force"]

    def rate(t, x):
        return np.concatenate([x[2:], push * np.cos(p["omega"] * t) - 2 * p["zeta"] * K * x[2:] - K**2 * x[:2]])

    def stop(t, x):
        return p["gap"] - (x[0] - x[1])

    stop.terminal, stop.direction = True, -1
    flown = gz.trajectory(system, start, until=25.0, samples=2)
    t, x, n = 0.0, start, np.array([1.0, -1.0])
    for time in flown.impact_time.values[:12]:
        found = solve_ivp(rate, (t, 25.0), x, method="DOP853", rtol=1e-12, atol=1e-13, events=stop, max_step=0.02)
        t, x = found.t_events[0][0], found.y_events[0][0].copy()
        assert abs(t - time) < 1e-9
        x[2:] -= (1.0 + p["r"]) * (n @ x[2:]) * n / 2.0
    assert flown.sizes["impact"] >= 6


def test_chatter_ends_by_name_and_invents_no_rest():
    flown = gz.trajectory(bouncing(A=0.0, r=0.5), (0.5, 0.0), until=50.0)
    assert flown.outcome == "chatter not resolved" and 30 < flown.sizes["impact"] <= 2000
    assert abs(flown.t.values[-1] - 3.0) < 1e-3 and "impacts" in gz.describe(flown.grazing_outcome)


def test_a_law_of_ones_own_and_one_that_is_wrong():
    def bumper(t, state, p):
        x, v = state
        return x, -p.r * v + p.V

    def floor(t, state, p):
        x, v = state
        return x, v

    def nothing(t, state, p):
        x, v = state
        return x, v * (1.0 if p.V > 0.0 or v >= 0.0 else sqrt(v))

    def ball(law):
        params = {"g": 1.0, "A": 0.0, "omega": 1.0, "r": 0.5, "V": 0.3}
        surface = gz.Surface("A", floor, table_bound, law)
        return gz.System(("x",), ("v",), params, parabola, [surface], ((0.1, 0.5), (-0.1, 0.1)))

    flown = gz.trajectory(ball(bumper), (0.5, 0.0), until=3.0)
    np.testing.assert_allclose(flown.v_plus.values, -0.5 * flown.v_minus.values + 0.3, rtol=1e-14)
    with pytest.raises(gz.UserCodeError, match=r"the law of surface A made .* rate of the gap is -1; allowed are"):
        gz.trajectory(ball(nothing), (0.5, 0.0), until=3.0)
    with pytest.raises(gz.UserCodeError, match=r"the law of surface A raised ValueError.* in line \d+ of .* sqrt\(v\)"):
        gz.trajectory(ball(nothing).replace(V=-1.0), (0.5, 0.0), until=3.0)

    def none(t, state, p):
        return state[0], state[1] * (1.0 if state[1] >= 0.0 else float("nan"))

    said = (
        rf"the law of surface A made .*nan.*\(defined in line {none.__code__.co_firstlineno} of .*test_trajectory\.py"
    )
    with pytest.raises(gz.UserCodeError, match=said):
        gz.trajectory(ball(none), (0.5, 0.0), until=3.0)


def test_where_rounding_is_said_the_word_is_certified():
    def rounding(t, t0, state, p):
        return 1e-14, 1e-14

    flown = gz.trajectory(bouncing(rounding=rounding), (0.4, 0.0), until=1.5)
    assert flown.trust == "certified"


@pytest.mark.parametrize(
    ("state", "said"),
    [
        ((0.4,), "give 2 numbers"),
        (("a", 0), "x = 'a' is not a real number"),
        ((-1.0, 0.0), "the start is inside surface A: its gap is -1"),
    ],
)
def test_starts_are_checked(state, said):
    with pytest.raises(gz.InputError, match=said):
        gz.trajectory(bouncing(), state)


def test_a_system_is_a_value_and_can_be_pickled():
    one = bouncing(height=0.7)
    copy = pickle.loads(pickle.dumps(one))
    assert copy == one and hash(copy) == hash(one) and one.replace(r=0.4) != one
    a, b = (gz.trajectory(each, (0.3, 0.2), until=3.0) for each in (one, copy))
    assert a.identical(b)
