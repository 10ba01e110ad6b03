import math

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import grazing as gz
from grazing.orbits import closure
from grazing.orbits.one_impact import one_impact_orbits
from grazing.orbits.survey import DET, SLOPE, TRACE, V_MINUS, families, survey
from grazing.oscillator.constants import constants_of
from grazing.oscillator.flight import anchored, flight
from tests.examples import examples
from tests.models import MODELS

# name -> model, N: every damping, no stiffness, shifted wall, passive wall, r = 0, two harmonics, resonance
CASES = {
    "standard": (gz.pinball(), 3),
    "under-damped": (gz.pinball(alpha=0.2, k=1.0, omega=2.8, d=0.3, V=0.1, r=0.9), 2),
    "critical": (gz.pinball(alpha=2.0, k=1.0, d=0.1, V=0.3), 2),
    "no stiffness": (gz.pinball(alpha=0.2, k=0.0, omega=2.0, d=-0.3, r=0.6, V=0.3), 2),
    "nothing but forcing": (gz.pinball(alpha=0.0, k=0.0, omega=2.8, d=-0.6, r=0.5, V=0.5), 1),
    "resonance": (gz.pinball(alpha=1e-10, k=2.2, omega=2.2, d=0.1, r=0.7, V=0.1), 2),
    "soft": (gz.pinball(alpha=0.3, k=1e-8, d=-0.1, r=0.5, V=0.2), 3),
    "shifted wall": (gz.pinball(sigma=-0.05, t0=0.7, d=0.02), 2),
    "passive": (gz.pinball(V=0.0, d=0.1), 2),
    "passive, dead": (gz.pinball(V=0.0, r=0.0, d=0.0), 1),
    "two harmonics": (
        gz.Oscillator(
            alpha=0.5, k=1.3, sigma=-0.3, reset=gz.active(r=0.7, V=0.2),
            forcing=gz.Forcing(omega=1.1, t0=0.4, offset=0.2, cos=(1.0, -0.3), sin=(0.1, 0.25)),
        ),
        1,
    ),
}  # fmt: skip


class Flight:
    """The flight over N periods in 30 digits: one matrix exponential, with the forcing as further states."""

    def __init__(self, model, N):
        p, f, mp = model.params, model.forcing, mpmath.mpf
        m, self.model, self.T = model.harmonics, model, 2 * mpmath.pi / mp(model.forcing.omega)
        A = mpmath.zeros(3 + 2 * m)  # y, v, 1, cos 1, sin 1, ...
        A[0, 1], A[1, 0], A[1, 1] = 1, -(mp(model.k) ** 2), -mp(model.alpha)
        A[1, 2] = mp(f.offset) - mp(model.k) ** 2 * mp(model.sigma)
        for j in range(m):
            W, i = (j + 1) * mp(f.omega), 3 + 2 * j
            A[1, i], A[1, i + 1] = mp(f.cos[j]), mp(f.sin[j])
            A[i, i + 1], A[i + 1, i] = -W, W
        self.M = mpmath.expm(A * N * self.T)
        self.law = mp(p["r"]), mp(p["V"])

    def state(self, tau, w):
        f = self.model.forcing
        phases = [(j + 1) * mpmath.mpf(f.omega) * (tau + f.t0) for j in range(self.model.harmonics)]
        return mpmath.matrix([0, w, 1, *(z for x in phases for z in (mpmath.cos(x), mpmath.sin(x)))])

    def closing(self, tau, w):
        """What must vanish: the height at the end, and the defect of the reset law."""
        y, v = (self.M * self.state(tau, w))[:2]
        return [y, w - (-self.law[0] * v + self.law[1])]

    def phases_of_orbits(self, n=4000):
        """Where, on a dense grid of impact times, the height at the end changes sign while the impact is one."""
        M = np.array(self.M.tolist(), dtype=float)
        r, V = map(float, self.law)
        f = self.model.forcing
        tau = np.linspace(0.0, float(self.T), n + 1) + 1e-4
        z = [np.ones_like(tau)]
        for j in range(self.model.harmonics):
            x = (j + 1) * f.omega * (tau + f.t0)
            z += [np.cos(x), np.sin(x)]
        R = M[:2, 2:] @ np.array(z)
        w = (V - r * R[1]) / (1 + r * M[1, 1])
        y, v = M[0, 1] * w + R[0], M[1, 1] * w + R[1]
        return [i for i in range(n) if y[i] * y[i + 1] < 0 and v[i] < 0]


@pytest.mark.parametrize("name", CASES)
def test_orbits_solve_the_defining_equations_in_30_digits_and_none_is_missing(name):
    model, N = CASES[name]
    found = one_impact_orbits(model, N)
    with mpmath.workdps(30):
        exact = Flight(model, N)
        assert len(found) == len(exact.phases_of_orbits()) > 0
        for orbit in found:
            tau, w = mpmath.findroot(exact.closing, (orbit.tau, orbit.v_plus))
            size = 1 / abs(1 - orbit.multipliers.sum() + orbit.multipliers.prod())
            assert abs(tau - orbit.tau) < 1e-13 * (1 + size)
            assert abs(w - orbit.v_plus) < 1e-13 * (1 + size)
            v = (exact.M * exact.state(tau, w))[1]
            assert abs(v - orbit.v_minus) < 1e-13 * (1 + size)
            J = exact.M[:2, :2] * saltation(model, tau, w, v)
            assert abs(J[0, 0] + J[1, 1] - orbit.multipliers.sum().real) < 1e-11 * (1 + size)
            assert abs(mpmath.det(J) - orbit.multipliers.prod().real) < 1e-12 * (1 + size)


def saltation(model, tau, w, v):
    """The saltation matrix by its definition: reset, with the change of time of the impact on either side."""
    f, r = model.forcing, model.params["r"]
    F = mpmath.mpf(f.offset) - mpmath.mpf(model.k) ** 2 * model.sigma
    for j in range(model.harmonics):
        x = (j + 1) * mpmath.mpf(f.omega) * (tau + f.t0)
        F += f.cos[j] * mpmath.cos(x) + f.sin[j] * mpmath.sin(x)
    before = mpmath.matrix([v, F - model.alpha * v])
    after = mpmath.matrix([w, F - model.alpha * w])
    reset = mpmath.matrix([[1, 0], [0, -mpmath.mpf(r)]])  # (y, v) -> (y, g(v))
    normal = mpmath.matrix([[1, 0]])
    return reset + (after - reset * before) * normal / v


models = st.builds(
    lambda alpha, k, omega, t0, offset, cos, sin, sigma, r, V: gz.Oscillator(
        alpha=alpha, k=k, sigma=sigma, reset=gz.active(r=r, V=V),
        forcing=gz.Forcing(omega=omega, t0=t0, offset=offset, cos=(1.0, *cos), sin=sin),
    ),
    st.sampled_from([0.0, 0.1, 1.0, 3.0]) | st.floats(0.0, 5.0),
    st.sampled_from([0.0, 1e-8, 0.5, 1.0]) | st.floats(0.0, 5.0),
    st.floats(0.5, 4.0),
    st.floats(-3.0, 3.0),
    st.floats(-1.0, 1.0),
    st.sampled_from([(), (-0.3,)]),  # kernels for two harmonics are prepared
    st.sampled_from([(0.0,), (0.4,)]),
    st.sampled_from([0.0, -0.3, 0.2]),
    st.sampled_from([0.0, 0.5, 0.8, 1.0]),
    st.sampled_from([0.0, 0.1, 0.4, 2.0]),
)  # fmt: skip


def orbits_of(model, N):
    try:
        return one_impact_orbits(model, N)
    except gz.OutsideForm:  # alpha = 0 and r = 1 at a resonance
        return ()


@settings(deadline=None, max_examples=examples(150))
@given(models, st.integers(1, 5))
def test_every_orbit_closes_has_its_word_and_knows_whether_it_is_admissible(model, N):
    for orbit in orbits_of(model, N):
        size = max(1.0, np.abs(orbit.points).max(), orbit.v_plus)
        assert orbit.residual < 1e-11 * size
        assert orbit.v_minus < 0.0 <= orbit.v_plus == model.reset.law(orbit.v_minus, P(model.reset.params))
        assert 0.0 <= orbit.tau < model.period and orbit.points.shape == (N, 2)
        assert (orbit.word, orbit.period, orbit.impacts) == ("0" * (N - 1) + "1", N, 1)
        if orbit.v_plus > 0.0:
            assert orbit.admissible == (orbit.clearance > 0.0)
        assert orbit.stable == (abs(orbit.multipliers[0]) < 1.0 - 1e-15)


class P:
    def __init__(self, params):
        self.__dict__.update(params)


@settings(deadline=None, max_examples=examples(60))
@given(models, st.integers(1, 4))
def test_multipliers_and_points_are_those_of_the_stroboscopic_map(model, N):
    for orbit in orbits_of(model, N):
        if not orbit.admissible or orbit.points[:, 0].min() < model.sigma or not 1e-9 < orbit.tau < model.period - 1e-9:
            continue
        segment = orbit.map.orbit(orbit.points[0], N)
        J = np.eye(2)
        for point in orbit.points:
            J = orbit.map.jacobian(point) @ J
        grown = 1.0 + np.linalg.norm(J)
        scale = max(1.0, np.abs(orbit.points).max())
        assert np.abs(segment.points[:-1] - orbit.points).max() < 1e-12 * scale * grown
        assert np.abs(segment.points[-1] - orbit.points[0]).max() < 1e-12 * scale * grown
        if abs(orbit.v_minus) < 1e-4 or orbit.clearance < 1e-6:
            continue
        assert segment.letters.tolist() == [0] * (N - 1) + [1]
        assert orbit.multipliers.sum() == pytest.approx(np.trace(J), abs=1e-9 * grown)
        assert orbit.multipliers.prod() == pytest.approx(np.linalg.det(J), abs=1e-9 * grown**2)
        singular = np.linalg.svd(np.eye(2) - J, compute_uv=False)
        assert orbit.condition == pytest.approx(1.0 / singular[-1], rel=1e-6 * grown, abs=1e-9)


@pytest.mark.parametrize(("d", "N"), [(0.1, 2), (0.12, 3), (0.125, 4)])
def test_multipliers_are_those_of_finite_differences_of_the_map(d, N):
    (orbit,) = [orbit for orbit in one_impact_orbits(gz.pinball(d=d), N) if orbit.admissible]
    h = 1e-6
    columns = [
        (orbit.map.iterate(orbit.points[0] + e, N)[-1] - orbit.map.iterate(orbit.points[0] - e, N)[-1]) / (2 * h)
        for e in h * np.eye(2)
    ]
    J = np.array(columns).T
    assert sorted(np.linalg.eigvals(J)) == pytest.approx(sorted(orbit.multipliers.real), abs=1e-7)


@settings(deadline=None, max_examples=examples(100))
@given(models, st.integers(1, 5))
def test_a_multiplier_1_is_a_double_zero_of_the_closing_equation(model, N):
    """G'(phi) omega = v (1 - tr J + det J): the orbit is lost where the closing equation is tangent to 0."""
    (family,) = families(model, N)
    table, counts = survey(family, np.zeros(1))
    for row in table[0, : counts[0]]:
        v, tr, det = row[V_MINUS], row[TRACE], row[DET]
        expected = v - v * tr + v * det
        if abs(v) > 1e-8:
            assert row[SLOPE] * model.forcing.omega == pytest.approx(expected, rel=1e-6, abs=1e-9 * (1 + abs(v * tr)))


@settings(deadline=None, max_examples=examples(60))
@given(models, st.integers(1, 3))
def test_clearance_is_the_lowest_dip_that_dense_samples_see(model, N):
    for orbit in orbits_of(model, N):
        if orbit.v_plus == 0.0:
            continue
        family = families(model, N)[0]
        c = constants_of(family.harmonics)(family.kind(*family.row.tolist()))
        anchor = anchored(orbit.tau, 0.0, orbit.v_plus, c)
        y = np.array([flight(s, anchor, c)[0] for s in np.linspace(0.0, N * c.T, 600 * N)])
        dips = [y[i] for i in range(1, len(y) - 1) if y[i] < y[i - 1] and y[i] <= y[i + 1]]
        reach = 2.0 * (1.0 + np.abs(y).max()) * (c.T * 5.0 / 600) ** 2 * (1 + c.alpha)
        seen = min(dips, default=math.inf)
        assert orbit.clearance <= seen + 1e-12
        if math.isfinite(orbit.clearance) and math.isfinite(seen):
            assert orbit.clearance > seen - reach


@pytest.mark.parametrize("damping, k", [(1.0, 0.3), (1e12, 0.9), (2.0, 0.0)])
def test_a_dip_of_a_flight_that_drags_takes_few_steps(damping, k, monkeypatch):
    """Of force and drag, equal but for rounding, the slope of the velocity had no digit: ten million steps a period."""
    steps = 0

    def counted(s, anchor, c):
        nonlocal steps
        steps += 1
        assert steps < 1000
        return flight(s, anchor, c)

    monkeypatch.setattr(closure, "flight", counted)
    forcing = gz.Forcing(omega=1e-9, offset=0.0, cos=(1.0,))
    (family,) = families(gz.Oscillator(alpha=damping, k=k, forcing=forcing, reset=gz.newton(0.5)), 1)
    c = constants_of(family.harmonics)(family.kind(*family.row.tolist()))
    low, dip, dips, when, _deepest = closure.lowest_dip(0.0, 0.0, 0.0, c.T, False, c)
    with mpmath.workdps(60):
        W, drag, pull = mpmath.mpf(c.omega), mpmath.mpf(damping), mpmath.mpf(k * k)
        q = mpmath.sqrt(drag**2 / 4 - pull)
        slow, fast = (-drag / 2 + q, -drag / 2 - q) if k else (mpmath.mpf(0), -drag)
        det = (pull - W * W) ** 2 + (drag * W) ** 2
        a, b = (pull - W * W) / det, drag * W / det  # y = a cos + b sin + A e^(slow t) + B e^(fast t), at rest at 0
        A = (fast * a - b * W) / (slow - fast)

        def fall(t):
            return W * (b * mpmath.cos(W * t) - a * mpmath.sin(W * t)) + A * slow * mpmath.exp(slow * t)

        bottom = mpmath.findroot(fall, when)
        height = a * mpmath.cos(W * bottom) + b * mpmath.sin(W * bottom) + A * mpmath.exp(slow * bottom)
    assert (dip, dips) == (1, 1)
    assert when == pytest.approx(float(bottom), abs=1e-9 * c.T)
    assert low == pytest.approx(float(height), abs=1e-14 * c.size)


@pytest.mark.parametrize("name", MODELS)
def test_every_model_of_the_tests_has_its_orbits_or_is_refused(name):
    model = MODELS[name]
    if name == "own law":
        with pytest.raises(gz.OutsideForm, match=r"affine piece by piece .*cubic.*gz\.orbit_diagram"):
            one_impact_orbits(model, 1)
        return
    for N in (1, 2):
        for orbit in one_impact_orbits(model, N):
            assert orbit.residual < 1e-10


def test_both_pieces_of_a_trigger_are_solved_and_kept_only_where_they_apply():
    base = {"alpha": 3.0, "k": 1.0, "forcing": gz.Forcing(omega=2.2, offset=0.08)}
    kicked = one_impact_orbits(gz.Oscillator(**base, reset=gz.active(r=0.8, V=0.4)), 2)
    passive = one_impact_orbits(gz.Oscillator(**base, reset=gz.newton(r=0.8)), 2)
    speeds = [-orbit.v_minus for orbit in (*kicked, *passive)]
    for trigger in (0.0, *speeds, *(1.001 * s for s in speeds), 10.0):
        both = one_impact_orbits(gz.Oscillator(**base, reset=gz.triggered(r=0.8, V=0.4, trigger=trigger)), 2)
        wanted = [o.tau for o in kicked if -o.v_minus >= trigger] + [o.tau for o in passive if -o.v_minus < trigger]
        assert sorted(o.tau for o in both) == pytest.approx(sorted(wanted), abs=1e-14)


def test_an_impact_at_the_strobe_belongs_to_the_period_that_ends_there():
    model = gz.pinball(d=0.12)
    (orbit,) = [orbit for orbit in one_impact_orbits(model, 3) if orbit.admissible]
    onto = orbit.phase / model.forcing.omega  # this shift of time moves the impact onto the strobe
    seen = set()
    for shift in (onto - 1e-12, np.nextafter(onto, 0.0), onto, np.nextafter(onto, 9.0), onto + 1e-12):
        (moved,) = [o for o in one_impact_orbits(model.replace(t0=float(shift)), 3) if o.admissible]
        at_strobe = min(moved.tau, model.period - moved.tau)
        assert at_strobe < 2e-12
        seen.add(moved.tau)
        assert moved.multipliers == pytest.approx(orbit.multipliers, abs=1e-10)
        if moved.tau == 0.0:
            assert moved.points[0].tolist() == [0.0, moved.v_plus]
        elif moved.tau < 1.0:  # it has been flying for almost a period
            assert moved.points[0][0] > 0.01
        else:
            assert moved.points[0] == pytest.approx([0.0, moved.v_plus], abs=1e-9)
        assert moved.map.orbit(moved.points[0], 3).points[-1] == pytest.approx(moved.points[0], abs=1e-9)
    assert 0.0 in seen


def test_an_orbit_says_what_it_is():
    (orbit,) = [orbit for orbit in one_impact_orbits(gz.pinball(d=0.12), 3) if orbit.admissible]
    assert repr(orbit) == "<OneImpactOrbit 001, period 3, stable, admissible>"
    virtual = [orbit for orbit in one_impact_orbits(gz.pinball(d=0.09), 3) if not orbit.admissible]
    assert virtual and all(orbit.clearance < 0.0 and "virtual" in repr(orbit) for orbit in virtual)
    with pytest.raises(ValueError, match="read-only"):
        orbit.points[0] = 0.0


def test_the_family_at_a_resonance_is_refused_by_name():
    model = gz.pinball(alpha=0.0, k=1.1, omega=2.2, r=1.0, V=0.0)
    with pytest.raises(gz.OutsideForm, match="orbits come in families"):
        one_impact_orbits(model, 1)


@pytest.mark.parametrize(
    ("N", "said"),
    [(0, "N = 0; allowed is a whole number >= 1"), (2.5, "N = 2.5; allowed is a whole number"), (True, "N = True")],
)
def test_what_is_no_period_is_refused(N, said):
    with pytest.raises(gz.InputError, match=said):
        one_impact_orbits(gz.pinball(), N)


def test_what_is_no_oscillator_is_refused():
    with pytest.raises(gz.InputError, match=r"model is 3; give an oscillator"):
        one_impact_orbits(3, 1)


def test_a_ball_that_swings_too_often_is_refused_before_the_search():
    """It was searched for minutes, swing after swing."""
    model = gz.Oscillator(0.3, 1e9, gz.Forcing(omega=2.2, offset=0.1), gz.active(0.8, 0.3))
    for search in (
        lambda: one_impact_orbits(model, 2),
        lambda: gz.periodic_orbits(gz.stroboscopic_map(model), word="01", starts=2),
    ):
        with pytest.raises(gz.InputError, match="more than 47,000 swings of the free ball"):
            search()
