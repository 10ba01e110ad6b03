"""The stroboscopic map against the arbitrary-precision reference, and each rare branch, compiled and plain."""

import math

import numpy as np
import pytest

import grazing as gz
from grazing.maps.map import CHATTER_LETTER, STUCK_LETTER, swift
from grazing.maps.period import MAX_IMPACTS
from grazing.outcome import (
    AMBIGUOUS,
    BAD_LAW,
    CHATTER,
    FATAL,
    GRAZE,
    INSIDE_WALL,
    STUCK,
    TOO_MANY_IMPACTS,
    TOO_MANY_SWINGS,
)
from tests.models import MODELS, changed_origin, model_of, packed
from tests.reference import PROBLEMS, Problem, active, advance, load_dips, load_orbits, trigger

ORBITS, DIPS = load_orbits(), load_dips()


def one_period(P, state):
    """Apply the step compiled and plain; both must agree to the last bit."""
    segment = P.orbit(state, 1)
    plain, letter, outcome = P.step(tuple(float(x) for x in state), packed(P))
    assert np.array_equal(np.array(plain), segment.points[1], equal_nan=True)
    assert (letter, outcome) == (segment.letters[0], segment.outcomes[0])
    return segment.points[1], letter, outcome


@pytest.mark.parametrize("name", PROBLEMS)
def test_20_periods_against_the_reference(name):
    P = gz.stroboscopic_map(model_of(PROBLEMS[name]))
    compared = 0
    for stored in (orbit for orbit in ORBITS if orbit.problem == name):
        segment = P.orbit((stored.u, stored.v), len(stored.strobes))
        for point, letter, strobe in zip(segment.points[1:], segment.letters, stored.strobes, strict=True):
            assert np.abs(point - (strobe.u, strobe.v)).max() <= 1e-12 * strobe.factor
            assert letter in ((CHATTER_LETTER,) if strobe.impacts is None else (strobe.impacts, STUCK_LETTER))
            compared += 1
        assert not np.bitwise_or.reduce(segment.outcomes) & (FATAL | AMBIGUOUS | GRAZE)
    assert compared >= 16


def test_no_impact_missed_and_none_invented():
    """1,040 states that dip to, or clear by, 1e-3 ... 1e-13, over 24 problems."""
    maps = {name: gz.stroboscopic_map(model_of(problem)) for name, problem in PROBLEMS.items()}
    missed = invented = undecided = 0
    for dip in DIPS:
        segment = maps[dip.problem].orbit((dip.u, dip.v), 1)
        right = np.abs(segment.points[1] - (dip.strobe.u, dip.strobe.v)).max() <= 1e-11 * dip.strobe.factor
        right &= dip.strobe.impacts is None or segment.letters[0] == dip.strobe.impacts
        missed += dip.hits and not right
        invented += not dip.hits and not right
        undecided += bool(segment.outcomes[0] & AMBIGUOUS)
    assert len(DIPS) >= 1000
    assert (missed, invented) == (0, 0)
    assert undecided <= 5


@pytest.mark.parametrize("name", MODELS)
def test_laws_of_models_and_maps(name):
    gz.testing.check_model(MODELS[name], states=6, periods=8)


def test_a_law_that_ball_arithmetic_settles_keeps_the_laws_of_maps():
    """What the plain step leaves ambiguous was taken for a difference from compiled code."""
    law = gz.reset(lambda v, p: -p.r * v, r=1e-20)
    P = gz.stroboscopic_map(gz.Oscillator(0.1, 1.0, gz.Forcing(omega=2.0, offset=-0.1), law, sigma=-0.1))
    start = (0.5359131519727733, -0.3062712001970738)
    assert swift(P).orbit(start, 1).outcomes[0] & AMBIGUOUS and not P.orbit(start, 1).outcomes[0] & AMBIGUOUS
    gz.testing.check_map(P, states=12, steps=2)


# ---- rare branches


def resting(d, V=0.0, r=0.5, **kw):
    return gz.stroboscopic_map(gz.pinball(V=V, r=r, d=d, **kw))


def test_a_start_on_the_wall_moving_in_is_hit_at_once():
    P = gz.stroboscopic_map(gz.pinball(V=0.4, r=0.5, d=1.2))
    inwards, letter, _ = one_period(P, (0.0, -0.6))
    outwards, none, _ = one_period(P, (0.0, 0.7))  # the law's answer to -0.6
    assert letter == none + 1 == 1
    assert inwards.tolist() == outwards.tolist()


def test_on_the_wall_at_rest_and_pulled_away_is_no_impact():
    point, letter, outcome = one_period(resting(d=1.2), (0.0, 0.0))
    assert (letter, outcome) == (0, 0)
    assert point[0] > 0.0


def test_on_the_wall_at_rest_and_pressed_throughout_is_stuck_for_ever():
    for _ in range(2):
        point, letter, outcome = one_period(resting(d=-1.5), (0.0, 0.0))
        assert point.tolist() == [0.0, 0.0]
        assert (letter, outcome) == (STUCK_LETTER, STUCK)


def test_on_the_wall_at_rest_and_pressed_against_a_bumper_is_kicked():
    point, letter, outcome = one_period(resting(d=-1.5, V=0.3), (0.0, 0.0))
    assert letter >= 1
    assert outcome == 0
    assert point[0] > 0.0 or point[1] > 0.0


def test_no_force_at_all_is_rest_without_impact():
    m = gz.Oscillator(alpha=1.0, k=1.0, forcing=gz.Forcing(omega=1.0, cos=(0.0,)), reset=gz.newton(r=0.5))
    point, letter, outcome = one_period(gz.stroboscopic_map(m), (0.0, 0.0))
    assert (point.tolist(), letter, outcome) == ([0.0, 0.0], 0, 0)


@pytest.mark.parametrize(("k", "offset"), [(0.0, -0.4), (0.3, -0.35)])
@pytest.mark.parametrize("ratio", [0.25, 0.6, 0.9])
def test_chatter_under_a_constant_force_ends_in_finite_time(k, offset, ratio):
    """The geometric series of the bouncing ball: rest for ever after t = 2 v0 / (g (1 - r)) or sooner with k > 0."""
    m = gz.Oscillator(alpha=0.0, k=k, forcing=gz.Forcing(omega=0.1, offset=offset, cos=(0.0,)), reset=gz.newton(ratio))
    assert 2.0 * 0.2 / (-offset * (1.0 - ratio)) < m.period
    point, letter, outcome = one_period(gz.stroboscopic_map(m), (0.0, 0.2))
    assert point.tolist() == [0.0, 0.0]
    assert letter == CHATTER_LETTER
    assert outcome == CHATTER | STUCK


def test_release_is_where_the_force_turns():
    m = gz.pinball(V=0.0, r=0.3, d=-0.2)
    flown = gz.trajectory(m, (0.0, 0.0), start=1.0, until=1.0 + m.period)
    release = (2.0 * math.pi - math.acos(0.2)) / 2.2  # cos(2.2 t) = 0.2, rising
    lying = flown.t.values[(flown.u.values == 0.0) & (flown.v.values == 0.0)]
    assert lying.max() == pytest.approx(release, abs=2e-15)


def test_budget_of_impacts_ends_by_name():
    """An elastic ball under a constant force hops for ever; faster hops than the budget allows."""
    m = gz.Oscillator(alpha=0.0, k=0.0, forcing=gz.Forcing(omega=1.0, offset=-1.0, cos=(0.0,)), reset=gz.newton(r=1.0))
    P = gz.stroboscopic_map(m)
    slow = P.orbit((0.0, 0.9 * m.period / (2.0 * MAX_IMPACTS)), 1)  # compiled: in Python so many impacts take long
    assert slow.outcomes[0] & TOO_MANY_IMPACTS
    assert np.isnan(slow.points[1]).all()
    assert slow.letters[0] > MAX_IMPACTS
    fast = 1.1 * m.period / (2.0 * MAX_IMPACTS)
    there = P.orbit((0.0, fast), 1)
    assert there.outcomes[0] == 0
    assert there.letters[0] == pytest.approx(m.period / (2.0 * fast), abs=1.5)


def breaks(v, p):
    """A law that breaks its promise for middling impacts only, which the first look at a law does not see."""
    if -0.9 < v < -0.3:
        return -0.1 if p.kind == 0.0 else (math.inf if p.kind == 1.0 else math.inf - math.inf)
    return 0.1


@pytest.mark.parametrize("kind", [0.0, 1.0, 2.0])
def test_a_law_that_breaks_its_promise_stops_the_orbit(kind):
    forcing = gz.Forcing(omega=2.2, offset=0.1)
    m = gz.Oscillator(alpha=3.0, k=1.0, forcing=forcing, reset=gz.reset(breaks, kind=kind))
    with pytest.warns(
        RuntimeWarning, match=r"the reset law breaks returned .* for v_minus = -0\.\d+; allowed is a finite"
    ):
        segment = gz.stroboscopic_map(m).orbit((0.1, -0.9), 3)
    assert segment.outcomes[0] == BAD_LAW
    assert np.isnan(segment.points[1:]).all()
    assert (segment.outcomes == BAD_LAW).all()
    with pytest.raises(gz.UserCodeError, match=r"the reset law breaks returned .* for v_minus = -0\.\d+ at t = 0\."):
        gz.trajectory(m, (0.1, -0.9))


def test_inside_the_wall_has_no_next_state():
    P = gz.stroboscopic_map(gz.pinball(sigma=0.2))
    with pytest.raises(
        gz.InputError, match=r"the ball starts inside the wall: u = 0.1, sigma = 0.2; start with u >= sigma"
    ):
        P((0.1, 0.0))
    lanes = np.array([[0.1], [0.0]])
    _, _, outcomes = P.run(lanes, 1, 0)
    assert outcomes[0, 0] == INSIDE_WALL
    assert np.isnan(lanes).all()


def graze_state():
    """A start of the undamped free ball, f = 2: u = (t - 1)^2 touches the wall at t = 1 exactly."""
    m = gz.Oscillator(
        alpha=0.0, k=0.0, forcing=gz.Forcing(omega=1.0, offset=2.0, cos=(0.0,)), reset=gz.active(0.8, 0.4)
    )
    return gz.stroboscopic_map(m), (1.0, -2.0)


def test_an_exact_graze_is_no_impact_and_is_reported():
    P, state = graze_state()
    point, letter, outcome = one_period(P, state)
    assert letter == 0
    assert outcome == GRAZE | AMBIGUOUS
    T = 2.0 * math.pi
    assert point == pytest.approx([(T - 1.0) ** 2, 2.0 * (T - 1.0)], rel=1e-14)


@pytest.mark.parametrize("depth", [1e-3, 1e-8, 1e-12, 1e-14])
def test_beside_the_graze_the_bumper_decides(depth):
    P, (u, v) = graze_state()
    below, hit, _ = one_period(P, (u - depth, v))
    above, none, _ = one_period(P, (u + depth, v))
    assert (hit, none) == (1, 0)
    assert below[1] - above[1] == pytest.approx(0.4, abs=1.9 * math.sqrt(2.0 * 2.0 * depth) + 1e-12)


def test_an_impact_exactly_at_the_strobe_belongs_to_the_period_that_ends():
    m = gz.Oscillator(alpha=0.0, k=0.0, forcing=gz.Forcing(omega=math.pi, offset=0.0, cos=(0.0,)), reset=gz.newton(0.5))
    assert m.period == 2.0
    segment = unsettled(gz.stroboscopic_map(m)).orbit((1.0, -0.5), 1)  # u = 1 - t/2
    assert segment.letters[0] == 1
    assert segment.points[1].tolist() == [0.0, 0.25]


def test_the_phase_of_the_section_shifts_the_forcing():
    m = gz.pinball(d=0.09, V=0.4, t0=0.3)
    P, Q = gz.stroboscopic_map(m, phase=0.7), gz.stroboscopic_map(m.replace(t0=1.0))
    assert np.allclose(P.iterate((0.1, 0.1), 30), Q.iterate((0.1, 0.1), 30), atol=1e-13)
    assert P.replace(phase=0.0).params["phase"] == 0.0


def test_work_per_period_is_counted(monkeypatch):
    """One flight a window (three, with the strobe), a few more for the lowest point of a dip or an impact. No scan."""
    from grazing.oscillator import contact

    calls = []
    plain = contact.flight
    monkeypatch.setattr(contact, "flight", lambda *a: calls.append(1) or plain(*a))
    P = gz.stroboscopic_map(gz.pinball(d=0.12, V=0.4))
    c, state = packed(P), (0.1, 0.0)
    counts = {0: [], 1: []}
    for _ in range(300):
        calls.clear()
        state, letter, _ = P.step(state, c)
        counts[letter].append(len(calls))
    assert min(counts[0]) == 3
    assert max(counts[0]) <= 10
    assert max(counts[1]) <= 20


# ---- decisions that are close, and extremes


def test_zeros_of_high_order_do_not_hide_others():
    """F = (1 - cos)^2 (cos - 0.3) has a quartic zero, whose rounding noise must not use up the places of the others."""
    q = np.polynomial.polynomial.polymul([1.0, -2.0, 1.0], [-0.3, 1.0])
    mean, *cos = np.polynomial.chebyshev.poly2cheb(q)
    for t0 in np.linspace(0.0, 6.2, 40):
        for sign in (1.0, -1.0):
            problem = Problem(0.5, 1.0, 1.0, t0, sign * mean, tuple(sign * x for x in cos), law=active(0.8, 0.4))
            exact = advance(problem, 0.3, 0.1, 1, jacobian=True)[0]
            segment = gz.stroboscopic_map(model_of(problem)).orbit((0.3, 0.1), 1)
            assert segment.letters[0] == len(exact.impacts)
            error = max(abs(float(exact.u) - segment.points[1, 0]), abs(float(exact.v) - segment.points[1, 1]))
            assert error <= 1e-12 * float(exact.factor)


def unsettled(P):
    """The map without ball arithmetic."""
    return changed_origin(P, settle=None)


def assert_settled(P, start):
    """Double precision says that it cannot decide; ball arithmetic decides as the reference does."""
    doubt = unsettled(P).orbit(start, 1)
    assert doubt.outcomes[0] & AMBIGUOUS
    assert doubt.undecided == 1
    for algorithm in ("block", "scalar"):
        rough = unsettled(P).run_columns([list(P.params.values())], np.array(start).reshape(1, 2, 1), 0, 1)
        assert rough.undecided[0, 0] == 1
        lanes = np.array(start).reshape(1, 2, 1)
        found = P.run_columns([list(P.params.values())], lanes, 0, 1, algorithm=algorithm)
        assert (found.outcomes[0, 0, 0], found.undecided[0, 0]) == (0, 0)
        proven = P.origin.settle(list(P.params.values()), start)
        assert tuple(found.points[0, 0, :, 0]) == tuple(lanes[0, :, 0]) == proven.state
        assert found.letters[0, 0, 0] == proven.letter
    sure = P.orbit(start, 1)
    assert (sure.outcomes[0], sure.undecided, sure.letters[0]) == (0, 0, proven.letter)


def test_a_decision_after_a_slow_impact_knows_its_error():
    law = active(0.5, 0.2689932407576071)
    problem = Problem(0.3, 5.874891519215663, 1.954939723854336, 0.9089794132507695, 2.3, law=law)
    assert_settled(gz.stroboscopic_map(model_of(problem)), (0.0922824657411291, -0.2241925416786858))


def test_an_impact_at_the_trigger_speed_is_ambiguous():
    law = trigger(0.8, 0.4, 0.27829748540636534)
    problem = Problem(3.0, 1.0, 2.2, 0.10880780956697578, 0.006967415105215757, law=law)
    P = gz.stroboscopic_map(model_of(problem))
    start = (0.1120386337877902, 0.12909475671487403)
    assert_settled(P, start)
    assert np.isnan(P.jacobian(start)).all()
    for shift in (-1e-6, 1e-6):
        assert not P.replace(trigger=0.27829748540636534 + shift).orbit(start, 1).outcomes[0] & AMBIGUOUS


def test_a_graze_beside_the_end_of_a_piece_is_ambiguous():
    problem = Problem(0.05, 3.0, 0.8, 0.0, 2.3, law=active(0.5, 0.3))
    P = gz.stroboscopic_map(model_of(problem))
    assert_settled(P, (0.7159046944715916, -0.2317763617397376))


@pytest.mark.parametrize("t0", [1e3, 1e6, 1e9, -1e9])
def test_a_large_time_shift_costs_no_digits(t0):
    problem = Problem(3.0, 1.0, 2.2, t0, 0.12, law=active(0.8, 0.4))
    exact = advance(problem, 0.1, -0.1, 1)[0]
    point, _ = gz.stroboscopic_map(model_of(problem))((0.1, -0.1))
    assert point == pytest.approx([float(exact.u), float(exact.v)], abs=1e-14)


@pytest.mark.parametrize("omega", [1e-7, 1e-60])
def test_time_scales_too_far_apart_end_by_name(omega):
    P = gz.stroboscopic_map(gz.pinball(alpha=0.0, k=1.0, d=-0.1, sigma=-5.0, omega=omega))
    point, letter, outcome = one_period(P, (0.1, 0.0))
    assert (letter, outcome) == (0, TOO_MANY_SWINGS)
    assert np.isnan(point).all()
    Q = gz.impact_map(P_model(omega))
    assert Q.orbit((0.0, 0.5), 1).outcomes[0] == TOO_MANY_SWINGS
    with pytest.raises(gz.InputError, match="more than 47,000 swings of the free ball in one period of the forcing"):
        gz.trajectory(P_model(omega), (0.1, 0.0), until=1.0)


def P_model(omega):
    return gz.pinball(alpha=0.0, k=1.0, d=-0.1, sigma=-5.0, omega=omega)


def test_overflow_is_not_blamed_on_the_law():
    P = gz.stroboscopic_map(gz.pinball(alpha=1e60, k=1e60, d=1e280))
    _, _, outcome = one_period(P, (1e300, -1e300))
    assert not outcome & BAD_LAW


@pytest.mark.parametrize("state", [(0.0, 0.0), (1.0, -2.0)])
def test_the_jacobian_is_undefined_at_a_touch(state):
    """At rest on the wall, and at an exact graze."""
    P, _ = graze_state()
    assert np.isnan(P.jacobian(state)).all()
    assert np.isfinite(P.jacobian((1.0, 0.5))).all()


@pytest.mark.parametrize("algorithm", ["scalar", "block"])
@pytest.mark.parametrize(("alpha", "k"), [(3.0, 1.0), (0.0, 2.2), (0.3, 0.0)])
def test_a_wall_however_far_below_costs_no_digits(alpha, k, algorithm):
    """Of heights above it nothing is left: a state came out as that of the wall, certified."""
    starts = np.array([[[0.1, 5.0], [0.3, -2.0]]])
    found = []
    for sigma in (-1e3, -1e10, -1e100):
        P = gz.stroboscopic_map(gz.pinball(alpha=alpha, k=k, sigma=sigma))
        found.append(P.run_columns([list(P.params.values())], starts.copy(), 0, 3, algorithm=algorithm, threads=1))
        assert not found[-1].outcomes.any() and not found[-1].letters.any()
    for other in found[1:]:
        assert np.allclose(other.points, found[0].points, rtol=0.0, atol=1e-11)


@pytest.mark.parametrize(("a", "b"), [(-400, 40), (150, -100), (0, 190)])
def test_units_of_powers_of_two_change_no_bit(a, b):
    """Of length and of time. Squares of small numbers are 0, as are high derivatives where time is long."""
    L, T, speed, force = 2.0**a, 2.0**b, 2.0 ** (a - b), 2.0 ** (a - 2 * b)
    law, push = gz.active(0.8, 0.4 * speed), gz.Forcing(2.2 / T, offset=0.03 * force, cos=(force,))
    plain, other = gz.pinball(alpha=0.2, k=3.0, d=0.03, V=0.4), gz.Oscillator(0.2 / T, 3.0 / T, push, law)
    for algorithm in ("scalar", "block"):
        found = []
        for m, start in ((plain, (0.1, 0.3)), (other, (0.1 * L, 0.3 * speed))):
            P, lanes = gz.stroboscopic_map(m), np.array(start).reshape(1, 2, 1)
            row = [list(P.params.values())]
            found.append(P.run_columns(row, lanes, 0, 5, algorithm=algorithm, arithmetic="strict", threads=1))
        points, again = found[0].points[0, :, :, 0], found[1].points[0, :, :, 0] / (L, speed)
        assert found[0].letters.sum() > 5 and np.array_equal(found[0].letters, found[1].letters)
        assert np.array_equal(found[0].outcomes, found[1].outcomes)
        assert np.array_equal(points, again) if algorithm == "scalar" else np.allclose(points, again, 0.0, 1e-13)
