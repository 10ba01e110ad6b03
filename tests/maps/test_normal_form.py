"""The normal form: the true graze, λ, l and μ of any model, the change to (x, y), and what is refused by name."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import expm

import grazing as gz
from grazing import theory
from grazing.maps.normal_form import constants, lowest_points, steady_minimum
from grazing.maps.reduction import steady_low
from grazing.oscillator.constants import steady_response
from tests.examples import examples
from tests.models import MODELS, TWO

S = gz.pinball(alpha=3, k=1, omega=2.2, t0=0, r=0.8, V=0.4)


def test_standard_set():
    nf = gz.normal_form(S, "d")
    assert nf.graze == pytest.approx(0.130961869350, abs=5e-13)
    amplitude = 1.0 / abs(complex(1.0 - 2.2**2, 3 * 2.2))
    assert nf.graze == pytest.approx(amplitude, abs=1e-15)
    assert nf.acceleration == pytest.approx(2.2**2 * amplitude, abs=1e-14)
    assert (round(nf.acceleration, 6), round(nf.lam, 6), round(nf.l, 6)) == (0.633855, 0.336482, 0.649353)
    assert round(gz.normal_form(S.replace(V=0.2), "d").l, 6) == 0.324676
    assert nf.det == pytest.approx(math.exp(-3.0 * S.period), rel=1e-12)


TABLE = {  # N: (border collision, period doubling) predicted by the normal form
    2: (-0.161022, 0.0993620152),
    3: (0.0889539502, 0.1229797662),
    4: (0.120993751428, 0.128545621172),
    5: (0.128139975581, 0.130178331572),
    6: (0.130095981315, 0.130701523177),
    7: (0.130685021777, 0.130874639682),
}


@pytest.mark.parametrize("N", TABLE)
def test_predicted_windows(N):
    nf = gz.normal_form(S, "d")
    low, high = TABLE[N]
    assert nf.parameter(theory.mu_bc(N, nf.lam, nf.l)) == pytest.approx(low, abs=5.1e-7 if N == 2 else 5.1e-11)
    assert nf.parameter(theory.mu_pd(N, nf.lam, nf.l)) == pytest.approx(high, abs=5.1e-11)
    assert nf.parameter(theory.mu_pd(1, nf.lam, nf.l)) == pytest.approx(-0.063818, abs=5.1e-7)


@pytest.mark.parametrize("d", [0.05, 0.12, 0.14])
def test_mu_is_the_papers_formula(d):
    """mu = [(d g1 - b g2) - g1]/(2 A b^2 (1+r)^2), with g the drift of a period at the phase of the graze."""
    nf = gz.normal_form(S, "d")
    P = gz.stroboscopic_map(S.replace(d=d + 5.0), phase=nf.time)  # lifted by 5: the same flow without the wall
    g1, g2 = P((5.0, 0.0))[0] - (5.0, 0.0)
    a, b, _c, e = nf.entries
    # the lifted flow moves about u = 5: P(5, 0) = (5, 0) + g
    mu = ((e * g1 - b * g2) - g1) / (2.0 * nf.acceleration * b * b * 1.8**2)
    assert nf.mu(d) == pytest.approx(mu, rel=1e-12, abs=1e-14)
    assert a + e == nf.lam


@given(
    alpha=st.floats(0.3, 6.0),
    k=st.floats(0.3, 3.0),
    omega=st.floats(0.5, 4.0),
    V=st.floats(0.0, 1.0),
    sigma=st.floats(-0.5, 0.5),
)
@settings(max_examples=examples(40))
def test_the_graze_is_a_graze(alpha, k, omega, V, sigma):
    m = gz.pinball(alpha=alpha, k=k, omega=omega, V=V, sigma=sigma)
    nf = gz.normal_form(m, "d")
    amplitude = 1.0 / abs(complex(k**2 - omega**2, alpha * omega))
    assert nf.graze / k**2 - amplitude == pytest.approx(sigma, abs=1e-12)
    assert nf.acceleration == pytest.approx(omega**2 * amplitude, rel=1e-10)
    steep = abs(nf.mu(nf.graze + 1.0) - nf.mu(nf.graze)) * max(1.0, nf.graze)  # what one unit of rounding is worth
    assert abs(nf.mu(nf.graze)) <= 4e-15 * steep
    for mu in (-0.02, 0.03):
        if steep < 1e9:  # b is not yet lost in e^{-alpha T}
            assert nf.mu(nf.parameter(mu)) == pytest.approx(mu, abs=4e-15 * steep)


@pytest.mark.parametrize("name", ["omega", "alpha", "k", "sigma", "cos1"])
def test_any_parameter_unfolds_the_graze(name):
    nf = gz.normal_form(S, name)
    assert steady_minimum(S.replace(**{name: nf.graze}))[1] == pytest.approx(0.0, abs=2e-16)
    h = 1e-3 * abs(nf.graze) + 1e-3
    assert nf.mu(nf.graze - h) * nf.mu(nf.graze + h) < 0.0
    assert nf.mu(np.array([nf.graze, nf.graze + h])).shape == (2,)


def test_two_harmonics_graze_at_the_global_minimum():
    m = gz.Oscillator(alpha=0.5, k=1.3, forcing=TWO, sigma=-0.3, reset=gz.active(r=0.7, V=0.1))
    nf = gz.normal_form(m, "offset")
    at = m.replace(offset=nf.graze)
    free = gz.trajectory(at.replace(sigma=-9.0), (0.0, 0.0), until=40 * at.period, samples=2000)
    last = free.u.values[free.t.values > 39 * at.period]
    assert last.min() == pytest.approx(-0.3, abs=1e-5)


def test_xy_coordinates():
    """The change of coordinates is invertible and gives the stated linear map up to squares of the velocities."""
    nf = gz.normal_form(S, "d")
    states = np.random.default_rng(5).uniform(-0.2, 0.2, (20, 2))
    assert nf.from_xy(nf.to_xy(states)) == pytest.approx(states, abs=1e-15)
    P = gz.stroboscopic_map(nf.model.replace(sigma=-9.0), phase=nf.time)  # no wall in reach
    for w in states:
        image = P(w)[0]
        (x, y), (x1, y1) = nf.to_xy(w), nf.to_xy(image)
        assert x1 - image[1] ** 2 == pytest.approx(nf.lam * x + y - nf.entries[0] * w[1] ** 2, abs=1e-14)
        d = nf.entries[3]
        assert y1 + d * image[1] ** 2 == pytest.approx(-nf.det * (x - w[1] ** 2), abs=1e-14)


@pytest.mark.parametrize("d", [0.10, 0.12, 0.128])
def test_reductions_have_the_same_word_near_the_graze(d):
    nf = gz.normal_form(S, "d")
    words = []
    for P, start in (
        (gz.stroboscopic_map(S.replace(d=d)), (0.1, 0.0)),
        (nf.xy_map(d), (0.0, 0.0)),
        (nf.gap_map(d), (-0.1,)),
    ):
        letters = P.orbit(P.iterate(start, 400)[-1], 24).letters
        words.append((int(letters.sum()), 24))
    assert len(set(words)) == 1


def test_law_near_zero_speed_decides():
    assert gz.normal_form(gz.pinball(V=0.0), "d").l == 0.0
    m = gz.Oscillator(3.0, 1.0, gz.Forcing(omega=2.2, offset=0.1), gz.triggered(r=0.8, V=0.4, trigger=0.05))
    nf = gz.normal_form(m, "offset")
    assert (nf.V, nf.l, nf.r) == (0.0, 0.0, 0.8)


def test_negative_b_and_lambda_are_handled_or_refused_by_name():
    m = gz.pinball(alpha=0.3, k=2.0, omega=2.6, V=0.2)  # a period of 3/4 of a turn: b < 0
    nf = gz.normal_form(m, "d")
    assert nf.b < 0.0
    with pytest.raises(
        gz.OutsideForm, match=r"b = -0.\d+ <= 0: the square root enters with a plus sign, outside the gap map"
    ):
        nf.gap_map()
    assert nf.xy_map(nf.graze).params["root"] < 0.0
    negative = gz.normal_form(gz.pinball(alpha=0.3, k=2.0, omega=4.4, V=0.2), "d")
    assert negative.lam < 0.0 < negative.b
    assert negative.gap_map(negative.graze).params["lam"] == negative.lam


@pytest.mark.parametrize(
    ("model", "name", "error", "words"),
    [
        (S, "V", gz.OutsideForm, r"the graze does not depend on V; vary a parameter of the flight"),
        (S, "t0", gz.OutsideForm, r"the graze does not depend on t0"),
        (S, "D", gz.InputError, r"unknown parameter 'D' of the model"),
        (
            S.replace(alpha=0.0, omega=1.0),
            "d",
            gz.OutsideForm,
            r"alpha = 0 and k = 1 omega: at this resonance there is no",
        ),
        (S.replace(alpha=0.0, omega=0.5), "d", gz.OutsideForm, r"alpha = 0 and k = 2 omega: .* one of a continuum"),
        (S.replace(alpha=0.0, k=0.0, d=0.0), "sigma", gz.OutsideForm, r"alpha = 0 and k = 0 omega"),
        (S.replace(k=0.0), "d", gz.OutsideForm, r"k = 0 with a constant force: the ball drifts for ever"),
        (S.replace(cos1=0.0), "omega", gz.OutsideForm, r"no graze of the steady response found for omega in"),
        (MODELS["chatter"], "omega", gz.OutsideForm, r"no graze of the steady response found for omega"),
    ],
)
def test_what_has_no_normal_form_is_refused_by_name(model, name, error, words):
    with pytest.raises(error, match=words):
        gz.normal_form(model, name)


def undamped(omega):
    """The oscillator of Budd and Dux (1994)."""
    forcing = gz.Forcing(omega=omega, cos=(-1.0,))
    return gz.Oscillator(alpha=0.0, k=1.0, forcing=forcing, sigma=-0.15, reset=gz.newton(0.8))


@pytest.mark.parametrize("omega", [2.76, 1.7, 0.7])
def test_without_damping_the_response_grazes_and_does_not_attract(omega):
    nf = gz.normal_form(undamped(omega), "sigma")
    T = 2.0 * np.pi / omega
    assert nf.graze == pytest.approx(-1.0 / abs(1.0 - omega**2), rel=1e-14)
    assert (nf.lam, nf.det, nf.b) == pytest.approx((2.0 * np.cos(T), 1.0, np.sin(T)), abs=1e-14)
    assert "the steady response attracts nothing" in repr(nf)


def over_an_impact(model, time, state):
    """A period of the model from one section to the next, the states there continued as if without the wall."""
    T, c, wall = model.period, constants(model), np.array([model.sigma, 0.0])
    B = np.array([[0.0, 1.0], [-(model.params["k"] ** 2), -model.params["alpha"]]])

    def steady(t):
        return np.array(steady_response(t, c)) + wall

    P = gz.stroboscopic_map(model, (time + 0.5 * T) % T)
    start = steady(time - 0.5 * T) + expm(-0.5 * T * B) @ (state - steady(time))
    end, hits = P(start)
    far = steady(time + T) + expm(0.5 * T * B) @ (np.array(end) - steady(time + 0.5 * T))
    return far, hits, np.linalg.det(P.jacobian(start))


@pytest.mark.parametrize(
    "model",
    [S.replace(V=0.0), gz.pinball(alpha=0.2, omega=2.8, V=0.0), undamped(2.76)],
    ids=["standard", "lightly damped", "undamped"],
)
def test_the_map_of_chin_et_al_is_the_direct_expansion(model):
    """(x, y) -> (alpha x + y + rho, -gamma x), and with an impact (-sqrt(x) + y + rho, -gamma tau^2 x) + O(x)."""
    nf = gz.normal_form(model, "sigma")
    alpha, gamma, tau = nf.lam, nf.det, nf.r
    free, hit = [], []
    for e in (1e-4, 1e-5):
        value = nf.parameter(0.5 * e)
        here, rho = replace(nf, model=nf.model.replace(sigma=value)), nf.mu(value)
        for x in (-e, e):
            y = 0.3 * e
            end, hits, det = over_an_impact(here.model, nf.time, here.from_xy(np.array([x, y]) * nf.scale))
            found = here.to_xy(end) / nf.scale
            if hits:
                assert det == pytest.approx(gamma * tau**2, rel=1e-8)
                hit.append(found - (-np.sqrt(x) + y + rho, -gamma * tau**2 * x))
            else:
                free.append(found - (alpha * x + y + rho, -gamma * x))
    assert abs(free[1]) == pytest.approx(abs(free[0]) / 100.0, rel=0.05, abs=1e-13)  # of order x^2
    assert abs(hit[1]) == pytest.approx(abs(hit[0]) / 10.0, rel=0.05, abs=1e-13)  # of order x


def test_repr_is_short():
    assert (
        repr(gz.normal_form(S, "d"))
        == "<NormalForm d=0.13096186935 at the graze: lam=0.336482, l=0.649353, b=0.149973>"
    )


def rooted(v, p):
    return 0.5 * p.c * math.sqrt(-v)


def test_two_contacts_in_a_period_are_refused():
    """Each has a square root of its own, and from one to the other it is not a whole period."""
    twice = gz.Forcing(omega=1.1, cos=(0.0, 1.0))  # that of omega = 2.2
    m = gz.Oscillator(0.3, 1.0, twice, gz.newton(0.8))
    with pytest.raises(
        gz.OutsideForm, match=r"touches the wall 2 times in a period, at t = 2\.778\d+, 5\.634\d+: .* omega"
    ):
        gz.normal_form(m, "sigma")
    assert gz.normal_form(m.replace(cos1=1e-6), "sigma").b != 0.0  # one of them is higher
    once = gz.Oscillator(0.3, 1.0, gz.Forcing(omega=2.2), gz.newton(0.8))
    assert gz.normal_form(once, "sigma").det == pytest.approx(math.exp(-0.3 * once.period))


@given(st.lists(st.integers(-99, 99).map(lambda n: n / 99), min_size=2, max_size=6), st.floats(-3.0, 3.0))
@settings(max_examples=50, deadline=None)
def test_the_lowest_point_is_among_the_lowest(waves, t0):
    half = len(waves) // 2
    force = gz.Forcing(omega=2.2, t0=t0, cos=(1.0, *waves[:half]), sin=waves[half:])
    c = constants(gz.Oscillator(0.3, 1.0, force, gz.newton(0.8)))
    found, (time, height) = lowest_points(c), steady_low(c)
    apart = np.abs((found - time + 0.5 * c.T) % c.T - 0.5 * c.T)
    assert apart.min() < 1e-6 * c.T
    for t in found:
        assert steady_response(float(t), c)[0] == pytest.approx(height, abs=1e-8)


def soft(v, p):
    return -p.e * v / (1.0 - p.c * v) + (p.K if v <= 0.0 else 0.0)


def test_a_law_that_is_not_linear_near_zero_speed_is_refused():
    forcing = gz.Forcing(omega=2.2, offset=0.12)
    with pytest.raises(gz.OutsideForm, match="the reset law rooted is not linear near zero speed"):
        gz.normal_form(gz.Oscillator(3.0, 1.0, forcing, gz.reset(rooted, c=0.5)), "offset")
    nf = gz.normal_form(gz.Oscillator(3.0, 1.0, forcing, gz.reset(soft, e=0.8, c=0.5, K=0.2)), "offset")
    assert (nf.r, nf.V) == (pytest.approx(0.8, abs=1e-5), 0.2)


@pytest.mark.parametrize(("a", "b"), [(20, 0), (-20, 0), (0, 20), (0, -20), (-19, 20), (17, -13), (-60, 80)])
@pytest.mark.parametrize("law", ["newton", "active", "triggered", "soft"])
@pytest.mark.parametrize("offset", [0.0, 0.3])
def test_it_is_the_same_in_any_unit(law, offset, a, b):
    """Accelerations were compared with lengths, slopes taken over a speed of 6e-9, grazes sought 1000 units away."""

    def reduced(L, T):
        laws = {"newton": gz.newton(0.8), "active": gz.active(0.8, 0.4 * L / T),
                "triggered": gz.triggered(0.8, 0.4 * L / T, 0.2 * L / T),
                "soft": gz.reset(soft, e=0.8, c=0.5 * T / L, K=0.2 * L / T)}  # fmt: skip
        push = gz.Forcing(2.2 / T, offset=offset * L / T**2, cos=(L / T**2,))
        return gz.normal_form(gz.Oscillator(3.0 / T, 1.0 / T, push, laws[law], -0.1 * L), "offset")

    L, T = 2.0**a, 2.0**b
    one, other = reduced(1.0, 1.0), reduced(L, T)
    assert (other.lam, other.det) == (one.lam, one.det)
    assert (other.l, other.r) == pytest.approx((one.l, one.r), rel=1e-12)
    assert (other.graze, other.acceleration) == (one.graze * L / T**2, one.acceleration * L / T**2)
    assert other.parameter(0.01) == pytest.approx(one.parameter(0.01) * L / T**2, rel=1e-12)


@pytest.mark.parametrize("mu", [2.2e-308, -2.2e-308, 5e-324, 1e-17, -1e-17, 1e-12])
def test_a_mu_of_the_size_of_rounding_has_a_parameter(mu):
    """At the graze μ is rounding, here -2e-17 or so, and smaller ones of its sign were found nowhere: a ValueError."""
    for alpha in (0.5, 1.0, 2.0, 3.0):
        nf = gz.normal_form(gz.pinball(alpha=alpha), "d")
        assert nf.parameter(mu) == pytest.approx(nf.graze, abs=1e-10)
