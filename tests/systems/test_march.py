"""The first contact: none missed, none invented, however shallow, and what cannot be decided is said."""

import numpy as np
import pytest
from flint import arb

import grazing as gz
from grazing.outcome import AMBIGUOUS, BAD_LAW
from grazing.parameter import parameters
from grazing.systems.precise import balls, digits, in_balls, middle
from tests.systems.balls import billiard, bouncing, parabola, table, table_bound, turn
from tests.systems.models import oscillator, period

DEPTHS = [10.0**-k for k in (4, 6, 8, 10, 11, 12)]
KINDS = {
    "under": {},
    "undamped": {"alpha": 0.0, "k": 2.0, "omega": 1.3},
    "over": {"alpha": 3.0, "k": 1.0, "omega": 2.2},
}


def exact_low(system, start, t, sign):
    """The distance that a flight keeps from a wall near t, in many digits."""
    p = parameters(system.params)
    flight = in_balls(system.flight)
    with digits():
        t = arb(t)
        for _ in range(8):  # Newton's method on the rate
            rate, later = (flight(s, 0.0, balls(start), balls(p))[1] for s in (t, t + 1e-30))
            t = t - rate / ((later - rate) / 1e-30)
        return middle(sign * (flight(t, 0.0, balls(start), balls(p))[0] - system.params["AB"[sign < 0] + ".sigma"]))


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("walls", [1, 2])
def test_built_grazes_are_neither_missed_nor_invented(kind, walls):
    """A flight is begun at its lowest point and flown back; so each start grazes, by as much as is wanted."""
    system, model = oscillator(walls=walls, **KINDS[kind])
    random, p, seen = np.random.default_rng(1), parameters(system.params), {True: 0, False: 0}
    for depth in [sign * depth for depth in DEPTHS for sign in (1.0, -1.0)] * 12:
        sign = 1.0 if walls == 1 or random.integers(2) else -1.0
        wall = system.params["A.sigma" if sign > 0 else "B.sigma"]
        t = float(random.uniform(0.1, 1.2)) * model.period
        start = system.flight(0.0, t, (wall + sign * depth, 0.0), p)
        bend = sign * (system.flight(t + 1e-4, t, (wall + sign * depth, 0.0), p)[1]) / 1e-4
        inside = any(h < 0.0 for h, _dh in system.gaps(0.0, start, system.params).values())
        if inside or bend < 0.05:
            continue
        low = exact_low(system, start, t, sign)
        flown = gz.trajectory(system, start, until=t + 3.0 * (2.0 * abs(depth) / bend) ** 0.5 + 1e-6, samples=2)
        peer = gz.trajectory(model, start, until=flown.t.values[-1], samples=2)
        times = flown.impact_time.values
        if times.size and times[0] < t - 2.0 * (2.0 * abs(depth) / bend) ** 0.5 - 1e-6:
            continue  # another wall, or an earlier time
        if flown.trust == "ambiguous":  # only within the rounding errors of a fast start
            assert abs(low) < 3e-14 * (sum(map(abs, start)) + 1.0), (depth, low)
            continue
        assert (times.size > 0) == (low < 0.0), (depth, low)
        assert (peer.impact_time.size > 0) == (low < 0.0)
        seen[low < 0.0] += 1
        if low < 0.0:  # the time of a shallow impact is as ill-conditioned as its root
            assert abs(times[0] - peer.impact_time.values[0]) < 1e-12 + 1e-13 / (-2.0 * bend * low) ** 0.5
    assert min(seen.values()) > 3, seen


def test_what_rounding_cannot_decide_is_said_to_be_ambiguous():
    system, _model = oscillator()
    p, random, said = parameters(system.params), np.random.default_rng(2), 0
    for depth in (0.0, 1e-16, -1e-16, 1e-15, -1e-15) * 6:
        t = float(random.uniform(0.5, 3.0))
        start = system.flight(0.0, t, (-0.2 + depth, 0.0), p)
        bend = system.flight(t + 1e-4, t, (-0.2, 0.0), p)[1] / 1e-4
        if start[0] < -0.2 or bend < 0.05:
            continue
        flown = gz.trajectory(system, start, until=t + 0.01, samples=2)
        if flown.sizes["impact"] and flown.impact_time.values[0] < t - 0.01:
            continue
        assert flown.trust == "ambiguous" and flown.outcome == "grazing"
        said += 1
    assert said > 5


def test_a_law_is_not_asked_while_the_surface_is_left():
    """After an impact so slow that it is in doubt, a crossing that was found upwards blamed the bound."""
    system, _model = oscillator()
    p, random = parameters(system.params), np.random.default_rng(5)
    for _ in range(200):
        t, depth = float(random.uniform(0.1, 1.2)) * period(p), 10.0 ** -random.uniform(11.5, 16.0)
        start = system.flight(0.0, t, (-0.2 - depth, 0.0), p)
        if start[0] >= -0.2:
            flown = gz.trajectory(system, start, until=t + 0.5, samples=2)
            assert (flown.v_minus.values < 0.0).all() and flown.u.values.min() > -0.2 - 1e-12


def promised(t, w, state, p):
    """A bound whose promise the parameters spoil: too large, too small, or none below some velocity."""
    if state[1] > p.until:
        return p.much * table_bound(t, w, state, p) + p.more
    return p.lost + (p.huge * p.huge - p.huge * p.huge)  # no number where infinity is taken from infinity


def errors(t, t0, state, p):
    """Errors that are no longer any after some time."""
    if t < t0 + 0.1:
        return 1e-15, 1e-15
    return p.lost, 1e-15 + (p.huge * p.huge - p.huge * p.huge)


KEPT = {"much": 1.0, "more": 0.0, "until": -9.0, "lost": 0.0, "huge": 0.0}
SPOILT = {
    name: gz.System(
        ("x",), ("v",), bouncing().params | KEPT, parabola,
        [gz.Surface("A", table, bound)], bouncing().box, turn, rounding,
    )
    for name, bound, rounding in (("bound", promised, None), ("errors", table_bound, errors))
}  # fmt: skip


def test_nothing_is_lost_where_the_bound_is_a_thousand_times_too_large():
    usual, wide = bouncing(A=0.3, r=0.6), SPOILT["bound"].replace(A=0.3, r=0.6, much=1000.0)
    for start in ((0.5, 0.0), (0.4, 1.0), (0.31, -0.2)):
        a, b = (gz.trajectory(one, start, until=6.0, samples=2).impact_time.values for one in (usual, wide))
        np.testing.assert_allclose(a, b, atol=1e-12)


def test_a_bound_that_is_too_small_is_noticed_where_it_is_contradicted():
    wrong = SPOILT["bound"].replace(much=0.0, more=1e-3)
    for start, until in (((0.3, 0.5), 1.7), ((0.3, -0.1), 4.0)):
        with pytest.raises(gz.UserCodeError, match="the bound of surface A is too small or negative, or its gap"):
            gz.trajectory(wrong, start, until=until)


@pytest.mark.parametrize(
    ("what", "lost", "huge"),
    [("bound", -1.0, 0.0), ("bound", 0.0, 1e200), ("errors", -1e-9, 0.0), ("errors", 1e-15, 1e200)],
    ids=["negative bound", "bound that is no number", "negative error", "error that is no number"],
)
def test_promises_that_become_none_on_the_way_prove_nothing(what, lost, huge):
    """Where a system is made they are what they should be, and are asked once."""
    wrong = SPOILT[what].replace(until=-0.2, lost=lost, huge=huge)
    said = "the bound of surface A is too small or negative, or its gap, the round"
    with pytest.raises(gz.UserCodeError, match=said):
        gz.trajectory(wrong, (0.5, -0.3), until=3.0)
    with pytest.warns(RuntimeWarning, match=said):
        assert gz.stroboscopic_map(wrong).orbit((0.5, -0.3), 3).outcomes[0] & BAD_LAW


def test_a_corner_is_ambiguous_and_a_little_beside_it_is_not():
    box = billiard()
    flown = gz.trajectory(box, (0.5, 0.5, -0.5, -0.5), until=2.5, samples=2)
    assert flown.trust == "ambiguous" and sorted(flown.impact_wall.values[:2]) == ["B", "L"]
    np.testing.assert_allclose(flown.after.values[1], (0.0, 0.0, 0.5, 0.5), atol=1e-15)
    beside = gz.trajectory(box, (0.5, 0.5 + 1e-12, -0.5, -0.5), until=2.5, samples=2)
    assert beside.trust == "numerical" and beside.impact_wall.values[:2].tolist() == ["L", "B"]


def test_an_impact_at_the_end_of_a_flight_counts_once():
    P = gz.stroboscopic_map(bouncing(A=0.0, r=0.7, omega=2.0 * np.pi))
    orbit = P.orbit((0.5, 0.0), 2)  # lands at t = 1, the end of the first period, and again at 2.4
    assert orbit.letters.tolist() in ([1, 0], [0, 1]) and orbit.outcomes[0] & AMBIGUOUS
