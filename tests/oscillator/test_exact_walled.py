"""The period in ball arithmetic between walls: against the closed form, one wall, and what doubles are sure of."""

from fractions import Fraction
from math import inf, sqrt

import numpy as np
import pytest

import grazing as gz
from grazing.oscillator.exact import exact_period
from grazing.outcome import AMBIGUOUS

RIDING = gz.Forcing(omega=2.2, sin=(0.05,), cos=(0.02,))


def between(alpha=0.3, k=1.1, low=-0.4, high=0.3, omega=2.2, motion=None, **more):
    force = gz.Forcing(omega=omega, offset=0.05, cos=(1.0, 0.2), sin=(0.3, 0.0))
    walls = gz.wall(low, gz.newton(0.7), motion=motion), gz.wall(high, gz.active(r=0.5, V=0.3))
    return gz.Oscillator(alpha, k, force, walls=walls, **more)


@pytest.mark.parametrize("b", [0.3, 0.1, 1.0 / 3.0])
def test_a_swing_to_a_wall_hits_it_where_algebra_says_so(b):
    # u'' + u = 0 swings up to sqrt(u^2 + v^2), which fractions compare to b
    still = gz.Forcing(omega=1.0, cos=(0.0,))
    model = gz.Oscillator(0.0, 1.0, still, walls=(gz.wall(-1.0, gz.newton(0.5)), gz.wall(b, gz.newton(0.5))))
    P, seen = gz.stroboscopic_map(model), set()
    for v in b * np.linspace(0.1, 0.9, 9):
        near = sqrt(b * b - v * v)
        for u in (near, np.nextafter(near, 0.0), np.nextafter(near, inf)):
            over = Fraction(u) ** 2 + Fraction(v) ** 2 - Fraction(b) ** 2
            hits, period, orbit = bool(over > 0), exact_period(model, (u, v)), P.orbit((u, v), 1)
            if over == 0:  # an exact graze, 0.18^2 + 0.24^2 = 0.3^2 in doubles, too: no number of bits tells
                assert period is None and orbit.outcomes[0] & AMBIGUOUS
                continue
            assert period.walls == ((1,) if hits else ())
            assert P.letters.symbol(int(orbit.letters[0])) == ("B" if hits else "0")
            assert not orbit.outcomes[0] & AMBIGUOUS
            seen.add(hits)
    assert seen == {True, False}


def test_studies_leave_no_such_swing_undecided():
    still, b, v = gz.Forcing(omega=1.0, cos=(0.0,)), 0.3, 0.03
    model = gz.Oscillator(0.0, 1.0, still, walls=(gz.wall(-1.0, gz.newton(0.5)), gz.wall(b, gz.newton(0.5))))
    P, starts = (
        gz.stroboscopic_map(model),
        np.array([[sqrt(b * b - v * v), v], [np.nextafter(sqrt(b * b - v * v), 0.0), v]]),
    )
    found = gz.orbit_diagram(P, "B.r", [0.5], starts=starts, transient=1, keep=4, threads=1)
    assert int(found.undecided.sum()) == 0 and not (found.outcome.values & AMBIGUOUS).any()


@pytest.mark.parametrize("k", [0.0, 0.5, 1.1])
@pytest.mark.parametrize("motion", [None, RIDING], ids=["still", "moving"])
def test_what_doubles_are_sure_of_is_so(k, motion):
    model = between(k=k, motion=motion)
    P, rng = gz.stroboscopic_map(model, phase=0.3), np.random.default_rng(5)
    for _ in range(12):
        start = float(rng.uniform(-0.3, 0.25)), float(rng.uniform(-1.0, 1.0))
        orbit, period = P.orbit(start, 1), exact_period(model, start, 0.3)
        assert not orbit.outcomes[0] & AMBIGUOUS
        np.testing.assert_allclose(period.state, orbit.points[1], atol=1e-12)
        assert P.letters.walls(int(orbit.letters[0])) == period.walls


@pytest.mark.parametrize("side", [1.0, -1.0], ids=["below", "above"])
def test_chatter_and_rest_are_those_over_one_wall(side):
    where, other = ("below", "above") if side > 0.0 else ("above", "below")
    walls = gz.wall(0.0, gz.newton(0.2), side=where), gz.wall(9.0 * side, gz.newton(0.5), side=other)
    model = gz.Oscillator(0.3, 0.7, gz.Forcing(omega=1.0, offset=-0.4 * side, cos=(side,)), walls=walls)
    one = gz.Oscillator(0.3, 0.7, gz.Forcing(omega=1.0, offset=-0.4, cos=(1.0,)), gz.newton(0.2))
    P, rests = gz.stroboscopic_map(model), set()
    for u, v in ((0.0, -0.3), (0.1, 0.2), (0.0, 0.0), (5.0, 4.0)):
        start = side * u, side * v
        ours, theirs = exact_period(model, start), exact_period(one, (u, v))
        assert ours.state == tuple(side * x + 0.0 for x in theirs.state)
        assert {*ours.walls, ours.rest} <= {0, model.names.index("A" if side > 0.0 else "B")}
        assert (ours.impacts, ours.lay, ours.outcome, ours.slow) == (
            theirs.impacts, theirs.lay, theirs.outcome, theirs.slow,
        )  # fmt: skip
        settled, flown = P.origin.settle(list(P.params.values()), start), P.orbit(start, 1)
        assert settled.letter == flown.letters[0]
        rests.add(theirs.outcome)
    assert len(rests) > 1


def test_a_ball_that_may_lie_on_a_moving_wall_is_not_decided():
    model = between(motion=RIDING)
    (at, _high), (speed, _still) = model.places_at(np.array([0.0]))
    assert exact_period(model, (float(at[0]), float(speed[0]))) is None
    assert exact_period(model, (float(at[0]) + 1e-9, float(speed[0]))) is not None


def test_a_ball_that_ends_at_rest_on_a_moving_wall_is_where_the_next_step_has_the_wall():
    """The place rounded once is a unit in the last place beside: the next step took the ball for one that chatters."""
    for phase in (0.1, 0.3, 0.7, 1.9):
        ride = gz.Forcing(omega=1.3, t0=0.2, cos=(0.1,), sin=(0.05,))
        model = gz.Oscillator(
            0.1, 0.3, gz.Forcing(omega=1.3, offset=-5.0, cos=(0.1,)), walls=[gz.wall(0.4, gz.newton(0.3), motion=ride)]
        )
        step = gz.stroboscopic_map(model, phase=phase)((0.6, -1.0))[0]
        assert exact_period(model, (0.6, -1.0), phase).state == tuple(step)


def test_a_law_that_takes_no_balls_leaves_a_step_undecided():
    def law(v, p):
        return float(np.float64(0.5) * -v)

    walls = gz.wall(-0.4, gz.reset(law)), gz.wall(0.3, gz.newton(0.5))
    model = gz.Oscillator(0.3, 1.1, gz.Forcing(omega=2.2, cos=(1.0,)), walls=walls)
    assert exact_period(model, (-0.4, -1.0)) is None
