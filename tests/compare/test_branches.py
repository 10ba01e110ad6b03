"""An orbit of a branch is a periodic orbit of the map of its rung, with its multipliers and its letters."""

import numpy as np
import pytest

import grazing as gz
from grazing.compare.branches import Linearised, Local, Point
from grazing.maps.linearised import linearised_map
from tests.models import TWO, packed

MODELS = {
    "standard": (gz.pinball(V=0.4), "d"),
    "passive": (gz.pinball(V=0.0), "d"),
    "shifted wall, in omega": (gz.pinball(V=0.2, r=0.5, sigma=0.1, d=0.15, t0=0.7), "omega"),
    "two harmonics": (gz.Oscillator(2.5, 1.1, TWO, sigma=-0.3, reset=gz.active(r=0.7, V=0.3)), "offset"),
    "in alpha": (gz.pinball(V=0.4, d=0.13), "alpha"),
    "oscillating flight": (gz.pinball(alpha=0.5, k=0.3, V=0.1), "d"),
}
ORDERS = ("lowest", "full", "corrected")


@pytest.fixture(params=list(MODELS))
def case(request):
    model, name = MODELS[request.param]
    return model, gz.normal_form(model, name)


def start(form, N, s):
    """A guess near the orbit with an impact of speed s."""
    mu = Linearised(form, N).mu(s / form.scale**0.5)
    none = np.empty(0)
    return Point(s, -s / form.acceleration, form.parameter(mu), none, none)


def flown(P, state, N):
    """N steps in plain Python: the last state, the letters and the Jacobian."""
    c, letters, jacobian, state = packed(P), [], np.eye(2), tuple(float(x) for x in state)
    for _ in range(N):
        state, letter, _outcome, J = P.tangent(state, c)
        letters.append(letter)
        jacobian = np.array(J).reshape(2, 2) @ jacobian
    return np.array(state), letters, jacobian


def held(point, jacobian):
    """Compare the test functions with the eigenvalues of the Jacobian of N steps."""
    J = np.linalg.det(jacobian), np.trace(jacobian)
    expected = np.array([1.0 + J[1] + J[0], 1.0 - J[1] + J[0], 1.0 - J[0]])
    scale = np.abs(expected).max()
    ratio = point.tests / expected
    assert (ratio > 0.0).all()
    assert ratio == pytest.approx(np.full(3, ratio[0]), rel=1e-6 * scale)


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("N", [5, 7])
def test_the_orbit_is_one_of_the_discontinuity_map(case, order, N):
    model, form = case
    s = 0.005 * form.scale**0.5
    rung = Local(model, form, N, order)
    point = rung.at(s, start(form, N, s))
    assert point is not None and point.s == s
    w, _z, dw, _dz = rung.crossing(s, point.delta, rung.period(point.value))
    here = model.replace(**{form.name: point.value})
    Z = gz.discontinuity_map(here, order=order, phase=form.time)
    state = np.array([here.sigma, 0.0]) + w
    if state[1] >= 0.0:  # the impact was before the section, and v < 0 is the paper's condition for one
        assert w[0] < 0.0 and form.name == "omega"
        return
    end, letters, jacobian = flown(Z, state, N)
    if all(left > 0.0 for left in point.left):
        assert letters == [1] + [0] * (N - 1)
        assert end == pytest.approx(state, abs=1e-12)
        held(point, jacobian)
        assert np.linalg.det(dw) > 0.0  # s for a constant A


@pytest.mark.parametrize("N", [1, 2, 5])
def test_the_orbit_is_one_of_the_linearised_map(case, N):
    _model, form = case
    rung = Linearised(form, N)
    for s in (1e-4, 0.1, 0.7):
        point = rung.at(s)
        Q = linearised_map(form.lam, form.det, point.value, form.l)
        w = rung.drift * point.value - rung.kick * (s + form.l)
        assert w[0] == pytest.approx(s * s, abs=1e-14)
        jacobian, state = np.eye(2), w
        for k in range(N):
            push = np.array([point.value - (s + form.l if k == 0 else 0.0), 0.0])  # by the word, admissible or not
            jacobian = rung.powers[1] @ jacobian - (np.array([[0.5 / s, 0], [0, 0]]) if k == 0 else 0.0)
            state = rung.powers[1] @ state + push
            if k < N - 1:
                assert point.left[k] == pytest.approx(-state[0], abs=1e-15)
        assert state == pytest.approx(w, abs=1e-13)
        held(point, jacobian)
        if (point.left > 0.0).all():
            assert flown(Q, w, N)[1] == [1] + [0] * (N - 1)


def test_a_negative_root_too():
    form = gz.normal_form(gz.pinball(alpha=0.5, k=1.0, omega=1.3, V=0.01), "d")
    assert form.b < 0.0
    rung = Linearised(form, 1)
    point = rung.at(0.2)
    Q = linearised_map(form.lam, form.det, point.value, form.l, -1.0)
    w = rung.drift * point.value - rung.kick * (-0.2 + form.l)
    end, letters, jacobian = flown(Q, w, 1)
    assert end == pytest.approx(w, abs=1e-14)
    assert letters == [1]
    held(point, jacobian)


def test_an_orbit_that_is_not_found_is_none():
    model = gz.pinball(V=0.4)
    form = gz.normal_form(model, "d")
    rung = Local(model, form, 3, "full")
    assert rung.at(0.02, Point(0.02, 1e9, 1e9, np.empty(0), np.empty(0))) is None  # far from the section
    steep = gz.normal_form(model, "alpha")
    assert Local(model, steep, 3, "full").at(50.0, Point(50.0, -80.0, 3.0, np.empty(0), np.empty(0))) is None
