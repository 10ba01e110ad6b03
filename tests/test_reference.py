"""The arbitrary-precision reference, judged by closed forms, by itself and by another integrator."""

from __future__ import annotations

import math
import random

import mpmath
import numpy as np
import pytest
from flint import arb, ctx
from scipy.integrate import solve_ivp

from tests.reference import (
    PERIODS,
    PROBLEMS,
    STARTS,
    Problem,
    Undecidable,
    active,
    advance,
    dips,
    free_flight,
    load,
    load_dips,
    load_orbits,
    newton,
    trigger,
)
from tests.reference.build import decimal, parameters, row

CLOSE = mpmath.mpf(10) ** -35


def mp(x: arb) -> mpmath.mpf:
    """A flint number as an mpmath number."""
    with ctx.workdps(60):
        return mpmath.mpf(x.str(55, radius=False))


def falling(g: float, r: float, V: float = 0.0, sigma: float = 0.0) -> Problem:
    """A ball under constant acceleration -g, sampled with period 1 / 2 or so."""
    return Problem(0.0, 0.0, 12.0, offset=-g, cos=(0.0,), sigma=sigma, law=active(r, V))


@pytest.fixture(autouse=True)
def _precision():
    with mpmath.workdps(60):
        yield


# closed forms


def test_bouncing_ball_before_its_accumulation_point():
    g, r, h = 2.0, 0.5, 1.0
    strobes = advance(falling(g, r), h, 0.0, 8)
    impacts = [impact for strobe in strobes for impact in strobe.impacts]
    t, speed = mpmath.sqrt(2 * h / mpmath.mpf(g)), mpmath.sqrt(2 * h * mpmath.mpf(g))
    for impact in impacts[:60]:
        assert abs(mp(impact.t) - t) < CLOSE
        assert abs(mp(impact.v_minus) + speed) < CLOSE
        speed *= r
        t += 2 * speed / g


def test_bouncing_ball_comes_to_rest_at_the_geometric_sum():
    g, r, h = 2.0, 0.5, 1.0
    strobes = advance(falling(g, r), h, 0.0, 8, digits=60)
    impacts = [impact for strobe in strobes for impact in strobe.impacts]
    total = mpmath.sqrt(2 * h / mpmath.mpf(g)) * (1 + r) / (1 - mpmath.mpf(r))
    assert impacts[-1].v_plus == 0
    assert abs(mp(impacts[-1].t) - total) < mpmath.mpf(10) ** -35
    assert strobes[-1].u == 0
    assert strobes[-1].v == 0
    assert not strobes[-1].impacts


def test_bumper_under_constant_acceleration_shifted_obstacle():
    g, r, V, sigma = 1.0, 0.5, 0.25, -0.75
    strobes = advance(falling(g, r, V, sigma), sigma, -1.0, 12)
    t, v = mpmath.mpf(0), mpmath.mpf(-1)
    for impact in [impact for strobe in strobes for impact in strobe.impacts]:
        assert abs(mp(impact.t) - t) < CLOSE
        assert abs(mp(impact.v_minus) - v) < CLOSE
        v = -(-mpmath.mpf(r) * v + V)  # it comes down as fast as it went up
        t += 2 * -v / g


@pytest.mark.parametrize("name", ["no stiffness", "no stiffness, no damping"])
def test_free_flight_without_stiffness(name):
    p = PROBLEMS[name]
    alpha, w, c, d = (mpmath.mpf(x) for x in (p.alpha, p.omega, p.cos[0], p.offset))
    t, u0, v0 = mpmath.mpf(7) / 4, mpmath.mpf(3), mpmath.mpf(1) / 2
    u, v = free_flight(p, 0.0, 3.0, 0.5, 1.75)
    if alpha == 0:
        expected = u0 + v0 * t + d * t**2 / 2 + c * (1 - mpmath.cos(w * t)) / w**2
    else:  # v = decay + steady part of v' + alpha v = d + c cos(w t)
        a, b = c * alpha / (alpha**2 + w**2), c * w / (alpha**2 + w**2)
        rest = v0 - d / alpha - a
        swing = (a * mpmath.sin(w * t) + b * (1 - mpmath.cos(w * t))) / w
        expected = u0 + rest * (1 - mpmath.exp(-alpha * t)) / alpha + d / alpha * t + swing
    assert abs(mp(u) - expected) < CLOSE
    back = free_flight(p, 1.75, u, v, -1.75)
    assert abs(back[0] - arb(3)) < 1e-35
    assert abs(back[1] - arb(0.5)) < 1e-35


@pytest.mark.parametrize(
    "name",
    [
        "standard d=0.12",
        "under-damped",
        "undamped",
        "near resonance",
        "three harmonics",
        "stiff",
        "stiff spring",
    ],
)
def test_free_flight_against_the_steady_response(name):
    p = PROBLEMS[name]
    t, start, v0 = 2.5, 0.3, -0.1
    alpha, k, w, t0 = (mpmath.mpf(x) for x in (p.alpha, p.k, p.omega, p.t0))
    i = mpmath.mpc(0, 1)

    def steady(time):
        u, v = mpmath.mpf(p.offset) / k**2, mpmath.mpf(0)
        for j in range(1, p.harmonics + 1):
            c = p.cos[j - 1] if j <= len(p.cos) else 0.0
            s = p.sin[j - 1] if j <= len(p.sin) else 0.0
            amplitude = mpmath.mpc(c, -s) / (k**2 - (j * w) ** 2 + i * j * w * alpha)
            wave = amplitude * mpmath.exp(i * j * w * (time + t0))
            u, v = u + wave.real, v + (i * j * w * wave).real
        return u, v

    u_s, v_s = steady(mpmath.mpf(0))
    x, y = mpmath.mpf(start) - u_s, mpmath.mpf(v0) - v_s
    root = mpmath.sqrt(mpmath.mpc(alpha**2 / 4 - k**2))
    l1, l2 = -alpha / 2 + root, -alpha / 2 - root
    c1, c2 = (y - l2 * x) / (l1 - l2), (l1 * x - y) / (l1 - l2)
    e1, e2 = mpmath.exp(l1 * t), mpmath.exp(l2 * t)
    u_t, v_t = steady(mpmath.mpf(t))
    u, v = free_flight(p, 0.0, start, v0, t)
    assert abs(mp(u) - (u_t + (c1 * e1 + c2 * e2).real)) < mpmath.mpf(10) ** -30
    assert abs(mp(v) - (v_t + (l1 * c1 * e1 + l2 * c2 * e2).real)) < mpmath.mpf(10) ** -30


def test_free_flight_at_resonance_and_at_critical_damping():
    w, t = mpmath.mpf(1.25), mpmath.mpf(9)
    u, _ = free_flight(Problem(0.0, 1.25, 1.25), 0.0, 0.0, 0.0, 9.0)
    assert abs(mp(u) - t * mpmath.sin(w * t) / (2 * w)) < CLOSE
    u, _ = free_flight(Problem(2.5, 1.25, 1.0, cos=(0.0,)), 0.0, 1.0, 0.5, 9.0)
    assert abs(mp(u) - mpmath.exp(-w * t) * (1 + (0.5 + w) * t)) < CLOSE


def test_sticking_until_the_force_changes_sign():
    p = Problem(3.0, 1.0, 2.0, offset=0.0, sin=(-1.0,), cos=(), law=newton(0.0))
    strobe = advance(p, 0.0, 0.0, 1)[0]  # pressed on until t = pi / 2, free from there
    rest = free_flight(p, math.pi / 2, 0.0, 0.0, math.pi / 2)
    assert not strobe.impacts
    assert abs(float(strobe.u - rest[0])) < 1e-16
    assert abs(float(strobe.v - rest[1])) < 1e-16


# conventions


def test_a_start_on_the_wall_with_incoming_speed_is_hit_in_period_one():
    strobe = advance(PROBLEMS["lifted"], 0.0, -0.4, 1)[0]
    assert [float(i.t) for i in strobe.impacts] == [0.0]
    assert float(strobe.impacts[0].v_plus) == pytest.approx(0.6 * 0.4 + 0.5)


def test_a_start_at_rest_on_the_wall():
    assert not advance(PROBLEMS["lifted"], 0.0, 0.0, 1)[0].impacts  # it lifts off
    kick = advance(PROBLEMS["pressed"], 0.0, 0.0, 1)[0].impacts[0]
    assert (float(kick.t), float(kick.v_minus), float(kick.v_plus)) == (0.0, 0.0, 0.5)
    resting = advance(Problem(1.0, 1.0, 2.0, offset=-1.5, law=newton(0.6)), 0.0, 0.0, 2)[-1]
    assert (resting.u, resting.v, resting.impacts) == (0, 0, [])


def test_trigger_law():
    law = trigger(0.5, 0.25, 1.0)
    assert law(arb(-0.5)) == 0.25
    assert law(arb(-1.0)) == 0.75
    assert law(arb(-2.0)) == 1.25


def test_a_touch_that_cannot_be_decided_raises():
    p = falling(-1.0, 0.5)  # y = (t - 1/4)^2 / 2 touches the wall
    with pytest.raises(Undecidable):
        advance(p, 1 / 32, -0.25, 1)
    assert not advance(p, 1 / 32 + 2.0**-50, -0.25, 1)[0].impacts
    assert len(advance(p, 1 / 32 - 2.0**-50, -0.25, 1)[0].impacts) == 1


def test_a_start_below_the_wall_is_refused():
    with pytest.raises(ValueError, match="below the obstacle"):
        advance(PROBLEMS["high obstacle"], 0.29, 0.0, 1)


def test_start_shifts_the_phase():
    p = Problem(3.0, 1.0, 2.0, offset=0.12, law=active(0.8, 0.4))
    shifted = Problem(3.0, 1.0, 2.0, t0=0.75, offset=0.12, law=active(0.8, 0.4))
    a, b = advance(p, 0.1, -0.2, 4, start=0.75)[-1], advance(shifted, 0.1, -0.2, 4)[-1]
    assert abs(a.u - b.u) < 1e-38
    assert abs(a.v - b.v) < 1e-38


# the reference against itself


@pytest.mark.parametrize("name", [n for n in PROBLEMS if n not in ("very stiff", "stiff", "slow")])
def test_more_digits_give_the_same_thirty_digits(name):
    u, v = STARTS[name][0]
    periods = min(6, PERIODS[name])
    a, b = advance(PROBLEMS[name], u, v, periods)[-1], advance(PROBLEMS[name], u, v, periods, digits=80)[-1]
    assert abs(a.u - b.u) < 1e-30
    assert abs(a.v - b.v) < 1e-30


@pytest.mark.parametrize("name", ["standard d=0.12", "undamped", "three harmonics", "trigger", "stiff spring"])
def test_jacobian_against_finite_differences(name):
    p, (u, v) = PROBLEMS[name], STARTS[name][0]
    strobe = advance(p, u, v, 4, jacobian=True)[-1]
    with ctx.workdps(60):
        h = arb(10) ** -18
        for column, (du, dv) in enumerate(((h, 0), (0, h))):
            plus = advance(p, arb(u) + du, arb(v) + dv, 4)[-1]
            minus = advance(p, arb(u) - du, arb(v) - dv, 4)[-1]
            for line, difference in enumerate((plus.u - minus.u, plus.v - minus.v)):
                assert abs(difference / (2 * h) - strobe.jacobian[line][column]) < 1e-25


def test_jacobian_vanishes_through_chatter_and_factor_bounds_it():
    strobe = advance(PROBLEMS["chatter"], 0.118, 0.263, 1, jacobian=True)[0]
    assert all(entry == 0 for line in strobe.jacobian for entry in line)
    for s in advance(PROBLEMS["passive"], 0.004, -0.223, 5, jacobian=True):
        assert s.factor >= max(1.0, *(abs(float(entry)) for line in s.jacobian for entry in line))


# another integrator


@pytest.mark.parametrize("name", ["standard d=0.09", "under-damped", "three harmonics", "many impacts"])
def test_against_an_integrator_with_events(name):
    p, (u, v) = PROBLEMS[name], STARTS[name][0]
    j = np.arange(1, p.harmonics + 1)
    cos, sin = (np.resize(np.append(x, np.zeros(p.harmonics)), p.harmonics) for x in (p.cos, p.sin))

    def field(t, state):
        phase = j * p.omega * (t + p.t0)
        f = p.offset + cos @ np.cos(phase) + sin @ np.sin(phase)
        return state[1], f - p.alpha * state[1] - p.k**2 * state[0]

    def contact(t, state):
        return state[0] - p.sigma

    contact.terminal, contact.direction = True, -1
    end = 2 * 2 * math.pi / p.omega
    t, state, count = 0.0, np.array([u, v]), 0
    while t < end:
        options = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-14, "max_step": 0.05, "events": contact}
        solution = solve_ivp(field, (t, end), state, **options)
        t, state = solution.t[-1], solution.y[:, -1]
        if solution.status == 1:
            count += 1
            state = np.array([p.sigma, -p.law.r * state[1] + p.law.V])
    strobes = advance(p, u, v, 2)
    assert count == sum(len(s.impacts) for s in strobes)
    assert float(strobes[-1].u) == pytest.approx(state[0], abs=1e-10)
    assert float(strobes[-1].v) == pytest.approx(state[1], abs=1e-10)


# stress states and stored data


def test_dips_dip_and_clear():
    p = PROBLEMS["standard d=0.12"]
    states = dips(p, 1e-9, 4, seed=3)
    assert [s.hits for s in states] == [True, False, True, False]
    assert states == dips(p, 1e-9, 4, seed=3)
    for s in states:
        times = [float(i.t) for i in advance(p, s.u, s.v, 1)[0].impacts]
        assert any(abs(t - s.t_m) < 1e-3 for t in times) == s.hits


def test_stored_problems_are_the_present_ones():
    now = {name: parameters(problem) for name, problem in PROBLEMS.items()}
    assert load("orbits")["problems"] == now
    assert load("dips")["problems"] == now


def test_stored_orbits_are_complete_and_reproduced():
    orbits = load_orbits()
    assert [(o.problem, o.u, o.v) for o in orbits] == [(n, u, v) for n in PROBLEMS for u, v in STARTS[n]]
    assert all(len(o.strobes) == PERIODS[o.problem] for o in orbits)
    for orbit in random.Random(1).sample([o for o in orbits if "stiff" not in o.problem], 12):
        for stored, strobe in zip(orbit.strobes, advance(PROBLEMS[orbit.problem], orbit.u, orbit.v, 5), strict=False):
            assert stored.exact == (decimal(strobe.u), decimal(strobe.v))


def test_stored_dips_are_complete_and_reproduced():
    states = load_dips()
    assert len(states) >= 1000
    assert sum(s.hits for s in states) * 2 == len(states)
    assert {s.depth for s in states} == {float(f"1e-{n}") for n in range(3, 14)}
    for s in random.Random(2).sample(states, 60):
        strobe = advance(PROBLEMS[s.problem], s.u, s.v, 1, jacobian=True)[0]
        u, v, impacts, factor = row(PROBLEMS[s.problem], strobe)
        assert (s.strobe.exact, s.strobe.impacts, s.strobe.factor) == ((u, v), impacts, factor)
