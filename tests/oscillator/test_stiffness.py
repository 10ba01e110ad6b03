"""Negative stiffness and negative damping: flights, dips and errors against ball arithmetic; what refuses them."""

import math
from dataclasses import replace

import numpy as np
import pytest
from flint import arb, ctx

import grazing as gz
from grazing.oscillator.constants import roots
from grazing.oscillator.exact import exact_period
from grazing.oscillator.flight import anchored, flight, noise
from grazing.outcome import AMBIGUOUS, DIVERGED, OK
from grazing.parameter import parameters
from tests.models import packed
from tests.reference import Problem, active, advance, dips, free_flight

TWO = {"omega": 1.3, "t0": 0.4, "cos": (1.0, -0.3), "sin": (0.1, 0.25)}
CASES = {
    "negative stiffness": Problem(0.3, 0.0, offset=-0.3, stiffness=-0.7, **TWO),
    "negative stiffness, stiff": Problem(0.5, 0.0, offset=-1.0, sigma=0.1, stiffness=-9.0, **TWO),
    "negative damping": Problem(-0.2, 1.3, offset=0.1, sigma=-0.2, **TWO),
    "negative damping, many swings": Problem(-0.05, 0.0, offset=1.0, stiffness=40.0, **TWO),
    "both": Problem(-0.25, 0.0, offset=-0.2, sigma=0.3, stiffness=-0.6, **TWO),
    "no spring": Problem(-0.3, 0.0, offset=-0.2, **TWO),
    "a trace of stiffness": Problem(0.2, 0.0, offset=-0.2, stiffness=-1e-9, **TWO),
    "critical": Problem(-1.0, 0.0, offset=-0.2, stiffness=0.25, **TWO),
    "above critical": Problem(-1.0, 0.0, offset=-0.2, stiffness=0.25 - 1e-13, **TWO),
    "below critical": Problem(-1.0, 0.0, offset=-0.2, stiffness=0.25 + 1e-13, **TWO),
    "positive": Problem(0.3, 0.0, offset=-0.2, stiffness=0.7, **TWO),
}
PUSHED = gz.Forcing(omega=1.0, offset=-0.6, cos=(0.3,))


def spring_of(problem):
    return {"k": problem.k} if problem.stiffness is None else {"stiffness": problem.stiffness}


def force_of(problem):
    return gz.Forcing(problem.omega, problem.t0, problem.offset, problem.cos, problem.sin)


def model_of(problem):
    law = gz.active(problem.law.r, problem.law.V)
    return gz.Oscillator(
        alpha=problem.alpha, forcing=force_of(problem), reset=law, sigma=problem.sigma, **spring_of(problem)
    )


@pytest.mark.parametrize("name", CASES)
def test_flight_and_its_error_bound(name):
    problem = replace(CASES[name], sigma=0.0)
    c = packed(gz.stroboscopic_map(model_of(problem)))
    rng = np.random.default_rng(7)
    ratios = []
    for _ in range(40):
        t, y, v = (float(rng.uniform(*ends)) for ends in ((0.0, c.T), (0.0, 1.0), (-1.0, 1.0)))
        s = min(float(rng.uniform(0.0, 1.0) ** 3 * (c.T - t)), c.piece)
        a = anchored(t, y, v, c)
        got, exact, bounds = flight(s, a, c), free_flight(problem, t, y, v, s), noise(s, a, c)
        ratios.append([abs(float(x - arb(z))) / bound for x, z, bound in zip(exact, got, bounds, strict=True)])
        # and an error that the anchor brings along is never more than the bound says
        off = free_flight(problem, t, y + 1e-3, v - 1e-3, s)
        wide = noise(s, a._replace(error_y=1e-3, error_v=1e-3), c)
        ratios.append([abs(float(x - z)) / bound for x, z, bound in zip(exact, off, wide, strict=True)])
    assert np.max(ratios) <= 1.0 + 1e-9


@pytest.mark.parametrize(("alpha", "stiffness"), [(-0.3, -4.8), (0.3, -4.8), (-0.3, -4.2), (-4.0, 1.0)])
def test_impacts_are_as_sharp_as_flights_that_would_go_far_beyond_the_wall(alpha, stiffness):
    """By the end of a window flights may have parted by e to the 30: an impact early in it is not as blurred."""
    law = active(0.8, 0.1)
    problem = Problem(
        alpha, 0.0, 0.5, 5.19, offset=-0.1, cos=(1.1,), sin=(0.0,), sigma=-0.49, stiffness=stiffness, law=law
    )
    u = 0.46
    for v in (-1.14, -1.3, -1.6, -2.0):
        flown = gz.trajectory(model_of(problem), (u, v), until=2.0)
        assert flown.trust.item() == "certified"
        height, speed = free_flight(problem, 0.0, u, v, float(flown.impact_time.values[0]))
        assert abs(float(height) - problem.sigma) <= 1e-14
        assert abs(float(speed) - flown.v_minus.values[0]) <= 1e-13


@pytest.mark.parametrize("name", CASES)
def test_no_dip_is_missed_and_none_is_made_up(name):
    """Dips and clearances of 1e-4 to 1e-12; a missed one changes the state by what the kick V is."""
    problem = replace(CASES[name], law=active(0.6, 0.4))
    P = gz.stroboscopic_map(model_of(problem))
    for depth in (1e-4, 1e-7, 1e-10, 1e-12):
        for dip in dips(problem, depth, 4, seed=3):
            (strobe,) = advance(problem, dip.u, dip.v, 1, jacobian=True)
            start = np.array([[dip.u], [dip.v]])[None]
            row, size = np.array([list(P.params.values())]), 1.0 + abs(float(strobe.u)) + abs(float(strobe.v))
            for arithmetic in ("strict", "fast"):
                found = P.run_columns(row, start.copy(), 0, 1, arithmetic=arithmetic, threads=1)
                point = found.points[0, 0, :, 0]
                assert found.letters[0, 0, 0] == len(strobe.impacts), (name, depth, dip, arithmetic)
                assert not found.outcomes[0, 0, 0] & AMBIGUOUS
                assert np.abs(point - (float(strobe.u), float(strobe.v))).max() <= 1e-14 * size * (strobe.factor or 1.0)


@pytest.mark.parametrize("name", ["negative stiffness", "both", "below critical"])
def test_a_second_wall_sees_its_dips_too(name):
    """The mirror image, with another wall far away: the same impacts, at the upper wall."""
    problem = replace(CASES[name], law=active(0.6, 0.4))
    law = gz.active(0.6, 0.4)
    f = force_of(problem)
    turned = gz.Forcing(f.omega, f.t0, -f.offset, [-x for x in f.cos], [-x for x in f.sin])
    walls = [gz.wall(-problem.sigma - 50.0, law), gz.wall(-problem.sigma, law)]
    P = gz.stroboscopic_map(gz.Oscillator(alpha=problem.alpha, forcing=turned, walls=walls, **spring_of(problem)))
    for depth in (1e-4, 1e-8, 1e-12):
        for dip in dips(problem, depth, 4, seed=5):
            (strobe,) = advance(problem, dip.u, dip.v, 1, jacobian=True)
            segment = P.orbit((-dip.u, -dip.v), 1)
            assert P.letters.symbol(int(segment.letters[0])).strip("()") == ("B" * len(strobe.impacts) or "0")
            size = 1.0 + abs(float(strobe.u)) + abs(float(strobe.v))
            wrong = np.abs(segment.points[1] + (float(strobe.u), float(strobe.v))).max()
            assert wrong <= 1e-14 * size * (strobe.factor or 1.0)


@pytest.mark.parametrize("name", CASES)
def test_ball_arithmetic_says_the_same(name):
    problem = replace(CASES[name], law=active(0.6, 0.4))
    for dip in dips(problem, 1e-9, 2, seed=9):
        (strobe,), proven = advance(problem, dip.u, dip.v, 1), exact_period(model_of(problem), (dip.u, dip.v))
        assert proven.impacts == len(strobe.impacts) and proven.outcome == OK
        assert proven.state == (float(strobe.u), float(strobe.v))


def test_impact_map_and_trajectory_go_through_the_same_impacts():
    seen = 0
    for name in ("negative stiffness", "negative damping", "both"):
        problem = replace(CASES[name], law=active(0.6, 0.3), offset=-0.9)
        m = model_of(problem)
        flown = gz.trajectory(m, (problem.sigma + 0.1, 0.0), until=12.0)
        times, before, after = flown.impact_time.values, flown.v_minus.values, flown.v_plus.values
        Q = gz.impact_map(m)
        seen += len(times) - 1
        for i in range(min(len(times) - 1, 6)):
            (tau, w), _strobes = Q((times[i] % m.period, after[i]))
            assert abs(tau - times[i + 1] % m.period) < 1e-11 and w == pytest.approx(after[i + 1], rel=1e-10)
        strobes = advance(problem, problem.sigma + 0.1, 0.0, 1)
        for impact, t, v in zip(strobes[0].impacts[:4], times, before, strict=False):
            assert abs(float(impact.t) - t) < 1e-13 and float(impact.v_minus) == pytest.approx(v, rel=1e-12)
    assert seen >= 5


def test_jacobians_are_derivatives():
    for problem in (replace(CASES["both"], offset=-0.9), replace(CASES["negative stiffness"], offset=-0.9)):
        P = gz.stroboscopic_map(model_of(replace(problem, law=active(0.6, 0.4))))
        u, v, h = problem.sigma + 0.2, 0.1, 1e-6
        moved = [(P.iterate(a, 1)[1] - P.iterate(b, 1)[1]) / (2 * h) for a, b in (
            ((u + h, v), (u - h, v)), ((u, v + h), (u, v - h)))]  # fmt: skip
        assert P.jacobian((u, v)) == pytest.approx(np.array(moved).T, rel=1e-6, abs=1e-6)


# ---- the roots


def test_roots_keep_their_digits_near_critical_damping_and_of_either_sign():
    with ctx.workprec(200):
        for alpha in (-1.1, 1.1, -0.3, 0.0):
            for stiffness in (0.25 * alpha * alpha - 1e-17, 0.3025, 0.0, -2.0, -1e-12, 0.25 * alpha * alpha * 0.9):
                q2, spread, l1, l2 = roots(parameters({"alpha": alpha, "stiffness": stiffness}))
                exact = arb(alpha) ** 2 / 4 - arb(stiffness)
                assert q2 == pytest.approx(float(exact), rel=4e-16)
                assert spread == pytest.approx(math.sqrt(abs(q2)), rel=4e-16)
                if q2 > 0.0:
                    slow, fast = (float(-arb(alpha) / 2 + sign * exact.sqrt()) for sign in (1, -1))
                    assert (l1, l2) == (pytest.approx(slow, rel=1e-15), pytest.approx(fast, rel=1e-15))
                else:
                    assert l1 == l2 == -0.5 * alpha


def test_stiffness_is_k_squared():
    """Where k^2 is a double both names give the same motion; the parameter has the one that was given."""
    f, law = gz.Forcing(omega=1.3, offset=-0.2), gz.newton(0.7)
    a = gz.Oscillator(alpha=0.3, k=1.5, forcing=f, reset=law)
    b = gz.Oscillator(alpha=0.3, stiffness=2.25, forcing=f, reset=law)
    P, Q = gz.stroboscopic_map(a), gz.stroboscopic_map(b)
    assert np.abs(P.iterate((0.3, 0.1), 20) - Q.iterate((0.3, 0.1), 20)).max() < 1e-14
    assert list(b.params) == ["alpha", "stiffness", "omega", "t0", "offset", "cos1", "sin1", "sigma", "r"]
    assert b.describe("stiffness").units == "1" and "stiffness=2.25" in repr(b)
    assert b.replace(stiffness=-1.0).stiffness == -1.0 and b.k is None and a.stiffness is None
    assert replace(b, mass=2.0).describe("stiffness").units == "1/s^2"
    with pytest.raises(gz.InputError, match="unknown parameter"):
        b.replace(k=1.0)
    assert np.abs(np.array(P.box) - np.array(Q.box)).max() < 1e-14


# ---- where nothing holds the ball


def test_a_ball_that_leaves_for_ever_has_diverged():
    for m in (
        gz.Oscillator(alpha=0.1, stiffness=-0.5, forcing=PUSHED, reset=gz.newton(0.7)),
        gz.Oscillator(alpha=-0.5, k=0.0, forcing=PUSHED, reset=gz.newton(0.7)),
        gz.Oscillator(alpha=-0.5, k=2.0, forcing=PUSHED, reset=gz.newton(1.0)),
        gz.Oscillator(alpha=0.0, stiffness=-1e8, forcing=PUSHED, reset=gz.newton(0.7)),
    ):
        segment = gz.stroboscopic_map(m).orbit((6.0, 3.0), 2000)
        last, *later = np.flatnonzero(segment.outcomes)
        assert later == [*range(last + 1, 2000)]  # an orbit that has ended keeps its outcome
        assert segment.outcomes[last] & DIVERGED
        assert np.isfinite(segment.points[: last + 1]).all() and np.isnan(segment.points[last + 1 :]).all()
        flown = gz.trajectory(m, (6.0, 3.0), until=2000.0, samples=4)
        assert flown.attrs["grazing_outcome"] & DIVERGED
        assert np.isfinite(flown.u.values).all() and flown.t.values[-1] < 2000.0 and flown.u.values.max() > 1e100
    up = gz.Oscillator(alpha=0.1, stiffness=-0.5, forcing=PUSHED, reset=gz.newton(0.7))
    Q = gz.impact_map(up)
    assert Q.orbit((0.0, 9.0), 1).outcomes[-1] & DIVERGED


def test_between_stops_nothing_diverges():
    """An inverted pendulum: at the stops a restitution takes what the fall towards them gives."""
    stops = [gz.wall(-1.0, gz.newton(0.8)), gz.wall(1.0, gz.newton(0.8))]
    m = gz.Oscillator(alpha=-0.05, stiffness=-1.0, forcing=gz.Forcing(omega=2.0, cos=(2.0,)), walls=stops)
    segment = gz.stroboscopic_map(m).orbit((0.1, 0.0), 300)
    assert len(segment.outcomes) == 300 and np.abs(segment.points[:, 0]).max() <= 1.0
    assert m.replace(stiffness=0.5).stiffness == 0.5
    c = gz.stroboscopic_map(m)
    assert c.params["stiffness"] == -1.0 and "k" not in c.params


def test_a_moving_wall_adds_its_inertia_with_a_negative_stiffness_too():
    """With x = u - z the force is f - z'' - alpha z' - stiffness z, here written out."""
    z, W = 0.05, 2.0
    walls = [gz.wall(0.0, gz.active(0.6, 0.3), motion=gz.Forcing(omega=W, cos=(z,)))]
    spring = {"alpha": -0.1, "stiffness": -0.8}
    moved = gz.Oscillator(forcing=gz.Forcing(omega=W, offset=-0.9, cos=(0.3,)), walls=walls, **spring)
    force = gz.Forcing(omega=W, offset=-0.9, cos=(0.3 + z * W * W + 0.8 * z,), sin=(-0.1 * W * z,))
    still = gz.Oscillator(forcing=force, reset=gz.active(0.6, 0.3), **spring)
    there = gz.stroboscopic_map(moved).orbit((0.2, 0.0), 5)
    here = gz.stroboscopic_map(still).orbit((0.2 - z, 0.0), 5)
    assert there.letters.tolist() == here.letters.tolist() and there.letters.max() > 1
    assert np.abs(there.points - here.points - (z, 0.0)).max() < 1e-11


def test_grazing_curves_graze():
    spring = {"alpha": -0.1, "stiffness": -0.8}
    m = gz.Oscillator(forcing=gz.Forcing(omega=2.0, offset=-0.3, cos=(0.9,)), reset=gz.active(0.6, 0.3), **spring)
    curve, P = gz.grazing_curve(m, preimages=1, points=30), gz.stroboscopic_map(m)
    states = [(s, n) for s, n in zip(curve.graze.values, curve.order.values, strict=True) if np.isfinite(s).all()]
    assert {int(n) for _s, n in states} == {0, 1}
    for state, n in states:
        segment = P.orbit(tuple(state), int(n) + 1)
        assert min(segment.near_miss, segment.slowest**2) < 1e-11


def test_starts_are_drawn_where_a_negative_stiffness_does_not_carry_them_away():
    m = gz.Oscillator(alpha=0.0, stiffness=-0.5, forcing=gz.Forcing(1.0, 0.0, -0.6, (0.0,)), reset=gz.newton(0.7))
    (low, high), (slow, fast) = gz.stroboscopic_map(m).box
    assert high <= 0.5 * 0.6 / 0.5 and fast <= 0.5 * 0.6 / math.sqrt(0.5)
    for u in (low, high):
        for v in (slow, fast):
            assert not gz.stroboscopic_map(m).orbit((u, v), 40).outcomes.max() & DIVERGED


# ---- studies, and what refuses


def test_the_steady_response_is_found_and_is_unstable():
    m = gz.Oscillator(alpha=0.1, stiffness=-0.5, forcing=PUSHED, reset=gz.newton(0.7))
    found = [orbit for orbit in gz.periodic_orbits(gz.stroboscopic_map(m), 1) if orbit.word == "0"]
    assert len(found) == 1 and not found[0].stable
    u, v = found[0].points[0]
    W, kappa = 1.0, -0.5
    response = 0.3 / complex(kappa - W * W, 0.1 * W)
    assert (u, v) == (pytest.approx(-0.6 / kappa + response.real, rel=1e-12), pytest.approx(-response.imag, rel=1e-10))
    size = sorted(abs(x) for x in found[0].multipliers)
    q = math.sqrt(0.0025 + 0.5)
    assert size == pytest.approx([math.exp(2 * math.pi * (-0.05 + s * q)) for s in (-1, 1)], rel=1e-12)


def test_branches_are_followed_through_zero_stiffness():
    f = gz.Forcing(omega=2.2, offset=-0.2)
    m = gz.Oscillator(alpha=0.4, stiffness=0.3, forcing=f, reset=gz.active(0.6, 0.3))
    P = gz.stroboscopic_map(m)
    orbit = next(o for o in gz.one_impact_orbits(m, 1) if o.admissible)
    branch = gz.continuation(P, orbit, "stiffness", (-0.3, 0.3))
    values = branch.dataset["stiffness"].values
    assert values.min() <= -0.29
    for i in (0, len(values) // 2, len(values) - 1):
        Q = P.replace(stiffness=float(values[i]))
        point = np.array([branch.dataset["u"].values[i], branch.dataset["v"].values[i]]).reshape(2, -1)[:, 0]
        assert np.abs(Q.iterate(tuple(point), 1)[1] - point).max() < 1e-9


@pytest.mark.parametrize(
    "ask",
    [
        lambda m: gz.normal_form(m, "offset"),
        lambda m: gz.windows(m, "offset", 1),
        lambda m: gz.discontinuity_map(m),
        lambda m: gz.zdm(m),
        lambda m: gz.response(gz.stroboscopic_map(m), "omega", [1.0, 1.1]),
    ],
)
@pytest.mark.parametrize("spring", [{"alpha": 0.4, "stiffness": -0.1}, {"alpha": -0.01, "k": 0.3}])
def test_what_is_not_right_for_such_models_refuses_them(ask, spring):
    m = gz.Oscillator(forcing=gz.Forcing(omega=2.2, offset=-0.2), reset=gz.active(0.6, 0.3), **spring)
    has = "a stiffness in place of k" if "stiffness" in spring else "alpha = -0.01"
    said = f"is for oscillators with alpha >= 0 and a natural frequency k, not for one with {has}"
    with pytest.raises(gz.GrazingError, match=said):
        ask(m)


def test_no_law_has_a_parameter_called_stiffness():
    law = gz.reset(lambda v, p: -0.5 * v / (1.0 + p.stiffness), stiffness=1.0)
    with pytest.raises(gz.InputError, match="'stiffness' has the name of a model parameter; rename it"):
        gz.Oscillator(0.1, 1.0, gz.Forcing(omega=1.0), law)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({}, "give k, the natural frequency, or stiffness"),
        ({"k": 1.0, "stiffness": 1.0}, "one of the two"),
        ({"stiffness": 1e121}, r"stiffness = 1e\+121; allowed is \|stiffness\| <= 1e\+120"),
        ({"stiffness": -1e121}, r"allowed is \|stiffness\| <= 1e\+120"),
        ({"k": 1.0, "alpha": -1e61}, r"alpha = -1e\+61; allowed is \|alpha\| <= 1e\+60"),
        ({"k": -1.0}, "k = -1; allowed is k >= 0"),
    ],
)
def test_ranges_are_said(given, words):
    for walls in ({"reset": gz.newton(0.5)}, {"walls": [gz.wall(0.0, gz.newton(0.5))]}):
        with pytest.raises(gz.InputError, match=words):
            gz.Oscillator(**({"alpha": 0.1, "forcing": gz.Forcing(omega=1.0)} | given | walls))


def test_a_buckled_beam_between_equal_stops_is_its_own_mirror_image():
    walls = gz.wall(-1.0, gz.newton(0.8)), gz.wall(1.0, gz.newton(0.8))
    m = gz.Oscillator(alpha=0.1, stiffness=-0.25, forcing=gz.Forcing(omega=2.0, cos=(1.5,)), walls=walls)
    assert m.symmetric and not m.replace(offset=0.1).symmetric
    assert m.replace(stiffness=0.25).symmetric


def test_units_of_a_negative_stiffness_are_those_of_its_force():
    m = gz.Oscillator(alpha=0.1, stiffness=-0.25, forcing=gz.Forcing(omega=2.0, cos=(1.5,)), reset=gz.newton(0.8))
    assert m.unit_of("sigma") > 0.0 and m.unit_of("offset") > 0.0
