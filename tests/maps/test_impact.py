"""The impact map: closed forms, its Jacobian's determinant as a law, and its outcomes."""

import math

import numpy as np
import pytest

import grazing as gz
from grazing.maps.returning import within_period
from grazing.outcome import CHATTER, NO_IMPACT, STUCK
from tests.models import MODELS


@pytest.mark.parametrize("name", ["standard", "under-damped", "two harmonics", "near resonance", "trigger", "critical"])
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


def test_a_ball_that_never_hits_again_is_neither_a_graze_nor_ambiguous():
    segment = gz.impact_map(gz.pinball(alpha=0.1, k=1, omega=3, d=1.0, V=0, r=0.7)).orbit((0.0, 0.5), 200)
    assert (segment.outcomes == NO_IMPACT).all()  # it settles 0.875 above the wall


def first_impact(m, w, last):
    """Return when a ball that leaves the wall at t = 0 comes back, from samples of its flight in closed form.

    With None for never, and the narrowest miss before: no window, no error bound and no piece of ours is in here.
    """
    alpha, k, omega, t0, d = (m.params[name] for name in ("alpha", "k", "omega", "t0", "d"))
    low, high = np.roots([1.0, alpha, k * k]).astype(complex)
    steady = np.exp(1j * omega * t0) / (k * k - omega**2 + 1j * alpha * omega)
    h0, h1 = -(steady + d / k**2).real, w - (1j * omega * steady).real
    b = (h1 - low * h0) / (high - low)

    def fly(t):
        a, c, turn = (h0 - b) * np.exp(low * t), b * np.exp(high * t), steady * np.exp(1j * omega * t)
        return (a + c + turn).real + d / k**2, (low * a + high * c + 1j * omega * turn).real

    t = np.linspace(0.0, last, int(64 * last * max(k, omega)))[1:]
    _y, v = fly(t)
    (turns,) = np.nonzero((v[:-1] < 0.0) & (v[1:] >= 0.0))
    a, b_ = t[turns], t[turns + 1]
    for _ in range(60):
        middle = 0.5 * (a + b_)
        falls = fly(middle)[1] < 0.0
        a, b_ = np.where(falls, middle, a), np.where(falls, b_, middle)
    lows = fly(a)[0]
    (below,) = np.nonzero(lows < 0.0)
    miss = np.abs(lows[: below[0] + 1] if below.size else lows).min(initial=np.inf)
    if not below.size:
        return None, miss
    hi, lo = a[below[0]], t[turns[below[0]]]
    while fly(lo)[0] < 0.0:
        lo -= t[0]
    for _ in range(60):
        middle = 0.5 * (lo + hi)
        lo, hi = (middle, hi) if fly(middle)[0] >= 0.0 else (lo, middle)
    return lo, miss


@pytest.mark.parametrize("damping", [0.0, 1e-4, 1e-2, 0.3])
def test_impacts_after_many_periods_and_none_at_all_are_told_without_doubt(damping):
    """The ball leaves slowly from where the steady response is lowest: back there it comes when both swings agree."""
    rng = np.random.default_rng(int(1e4 * damping) + 3)
    late = none = 0
    for _ in range(5):
        k, omega, w = 10.0 ** rng.uniform(-0.7, 0.7), 10.0 ** rng.uniform(-0.7, 0.7), 10.0 ** rng.uniform(-3, 0)
        if abs(k - omega) < 0.1 * k:
            continue
        steady = 1.0 / (k * k - omega**2 + 1j * damping * k * omega)
        d = abs(steady) * k * k * (1.0 + 10.0 ** rng.uniform(-3.0, 0.5))
        t0 = (math.pi - np.angle(steady)) / omega
        m = gz.pinball(alpha=damping * k, k=k, omega=omega, t0=t0, d=d, V=0.0, r=0.7)
        due, miss = first_impact(m, w, 1000.0 * m.period)
        segment = gz.impact_map(m).orbit((0.0, w), 1)
        if miss < 1e-9:
            continue
        assert segment.outcomes[0] == (NO_IMPACT if due is None else 0), (m, due, miss)
        if due is None:
            none += 1
        else:
            late += due > 30.0 * m.period
            assert segment.points[1, 0] + segment.letters[0] * m.period == pytest.approx(due, rel=1e-9, abs=1e-7)
    assert none if damping else late, (none, late)


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


LATE = r"{} = -?1e\+17; allowed is \|{}\| <= {}\d*e\+14: beyond, doubles are too coarse for what happens within "


@pytest.mark.parametrize(
    "call",
    [
        lambda Q: Q.orbit((1e17, 0.4), 3),
        lambda Q: Q((-1e17, 0.4)),
        lambda Q: gz.basins(Q, {"tau": [0.0, 1e17]}),
        lambda Q: gz.graph(Q, "tau", [0.0, 1e17]),
        lambda Q: gz.lyapunov(Q, starts=[(1e17, 0.4)]),
        lambda Q: gz.orbit_diagram(Q, "omega", [2.2], box=((0.0, 1e17), (0.0, 0.4))),
    ],
)
@pytest.mark.parametrize("walls", [False, True])
def test_a_phase_that_no_double_has_is_refused_wherever_it_is_given(call, walls):
    """At 1e300 the ball began at phase 0, certified."""
    above = [gz.wall(0.5, gz.newton(0.6), side="above"), gz.wall(-0.5, gz.newton(0.6))] if walls else None
    given = {"walls": above} if walls else {"reset": gz.newton(0.6)}
    Q = gz.impact_map(gz.Oscillator(alpha=0.1, k=1.0, forcing=gz.Forcing(omega=2.2, cos=(1.0,)), **given))
    with pytest.raises(gz.InputError, match=LATE.format("tau", "tau", "4.5454")):
        call(Q)


@pytest.mark.parametrize("tau", [0.5, 1e-8, -0.3, 1e16])
def test_a_start_after_more_periods_than_a_double_counts_is_at_some_phase(tau):
    """In fast arithmetic it was many periods before the first one, and the flight from there took years."""
    P = gz.impact_map(gz.pinball(omega=1e59))
    lanes = np.array([[[tau], [1.0]]])
    assert P.run_columns(P.packed()[1][None], lanes, 0, 1, arithmetic="fast").outcomes[0, 0, 0] & NO_IMPACT
    assert within_period(tau, P.origin.model.period) == pytest.approx(0.0, abs=P.origin.model.period)
