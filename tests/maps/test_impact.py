"""The impact map: closed forms, its Jacobian's determinant as a law, and its outcomes."""

import math

import numpy as np
import pytest

import grazing as gz
from grazing.outcome import CHATTER, NO_IMPACT, STUCK
from tests.models import MODELS


@pytest.mark.parametrize(
    "name", ["standard", "under-damped", "three harmonics", "near resonance", "trigger", "critical"]
)
def test_determinant_law(name):
    """Area in (tau, w): det = e^{-alpha t} (v0/v1) g'(v1), t the time of flight, v0 after, v1 before an impact.

    Area shrinks by e^{-alpha t} in the flow; (tau, w) carries the area w dtau dw at a departure, |v| at an arrival.
    """
    m = MODELS[name]
    Q = gz.impact_map(m)
    checked = 0
    for tau, w in ((0.1, 0.5), (1.0, 0.3), (0.5, 0.9), (2.0, 0.2)):
        (end, _), strobes = Q((tau % m.period, w))
        flown = gz.trajectory(m, (m.sigma, w), start=tau % m.period, until=(tau % m.period) + 9 * m.period)
        if flown.sizes["impact"] == 0:
            continue
        v = float(flown.v_minus[0])
        time = end + strobes * m.period - tau % m.period
        J = Q.jacobian((tau % m.period, w))
        expected = math.exp(-m.alpha * time) * (w / v) * m.reset.slope(v, _law(m))
        assert np.linalg.det(J) == pytest.approx(expected, rel=1e-7, abs=1e-12)
        checked += 1
    assert checked >= 2


def _law(m):
    from grazing.parameter import parameter_tuple

    return parameter_tuple(tuple(m.reset.params))(*m.reset.params.values())


def test_bouncing_ball_in_closed_form():
    m = gz.Oscillator(
        alpha=0.0, k=0.0, forcing=gz.Forcing(omega=1.0, offset=-2.0, cos=(0.0,)), reset=gz.active(0.5, 0.25)
    )
    Q = gz.impact_map(m)
    (tau, w), strobes = Q((1.0, 3.0))  # flight 2 w/g = 3
    assert (tau, w, strobes) == (pytest.approx(4.0, abs=1e-14), pytest.approx(1.75, abs=1e-14), 0)
    (tau, w), strobes = Q((tau, 3.0))
    assert (tau + strobes * m.period, strobes) == (pytest.approx(7.0, abs=1e-14), 1)
    assert Q.jacobian((1.0, 3.0)) == pytest.approx(np.array([[1.0, 1.0], [0.0, 0.5]]), abs=1e-14)


def test_agrees_with_trajectory_through_many_impacts():
    m = MODELS["trigger"]
    Q = gz.impact_map(m)
    flown = gz.trajectory(m, (0.3, 0.0), until=12 * m.period)
    state = (float(flown.impact_time[0]) % m.period, float(flown.v_plus[0]))
    orbit = Q.iterate(state, 5)
    assert orbit[1:, 1] == pytest.approx(flown.v_plus.values[1:6], abs=1e-10)


def test_no_impact_is_named():
    m = gz.pinball(d=2.0)  # the steady response stays above the wall
    segment = gz.impact_map(m).orbit((0.0, 0.5), 2)
    assert segment.outcomes[0] == NO_IMPACT
    assert np.isnan(segment.points[1:]).all()


def test_chatter_and_sticking_end_at_the_release():
    m = gz.pinball(V=0.0, r=0.3, d=-0.2)
    Q = gz.impact_map(m)
    release = (2.0 * math.pi - math.acos(0.2)) / 2.2
    segment = Q.orbit((1.7, 1e-3), 1)
    assert segment.points[1] == pytest.approx([release, 0.0], abs=1e-14)
    assert segment.outcomes[0] == CHATTER | STUCK
    assert (Q.jacobian((1.7, 1e-3)) == 0.0).all()
    landed, _ = Q(segment.points[1])  # flies from the release to a true impact
    assert landed[1] > 0.0


def test_pressed_for_ever_never_leaves():
    m = gz.pinball(V=0.0, r=0.3, d=-1.5)
    segment = gz.impact_map(m).orbit((0.3, 1e-3), 1)
    assert segment.outcomes[0] & NO_IMPACT
    assert segment.outcomes[0] & STUCK


def test_velocity_into_the_wall_is_refused():
    with pytest.raises(gz.InputError, match=r"v_plus = -0.1 points into the wall; give the velocity after an impact"):
        gz.impact_map(gz.pinball())((0.0, -0.1))


def test_a_release_exactly_at_the_strobe():
    """F = sin t turns at t = 0: the ball lies up to the strobe and is released there."""
    forcing = gz.Forcing(omega=1.0, cos=(0.0,), sin=(1.0,))
    m = gz.Oscillator(alpha=0.5, k=1.0, forcing=forcing, reset=gz.newton(r=0.2))
    (tau, w), strobes = gz.impact_map(m)((4.0, 0.01))
    assert (tau, w, strobes) == (0.0, 0.0, 1)


def test_the_phase_stays_below_the_period():
    m = gz.Oscillator(
        alpha=0.0, k=0.0, forcing=gz.Forcing(omega=math.pi, offset=-1.0, cos=(0.0,)), reset=gz.newton(1.0)
    )
    assert m.period == 2.0
    (tau, w), strobes = gz.impact_map(m)((0.0, 1.0))
    assert (tau, w, strobes) == (0.0, 1.0, 1)


def test_the_jacobian_is_undefined_for_a_kick_from_rest():
    assert np.isnan(gz.impact_map(gz.pinball(d=-1.5, V=0.3)).jacobian((0.0, 0.0))).all()
