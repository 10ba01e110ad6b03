"""Central differences: against derivatives in closed form, their order, and what they leave alone."""

import math

import numpy as np
import pytest

import grazing as gz
from grazing.maps import derivative
from grazing.maps.derivative import differences_of, extended
from tests.models import MODELS
from tests.studies.maps import FOLLOWER, HENON, SMOOTH, linear_map, states_in


def without(P):
    """The same map without its own derivative."""
    return gz.Map(P.step, P.params, P.coordinates, P.box, P.letters, P.prepare, name=P.name)


@pytest.mark.parametrize("P", [SMOOTH, HENON, FOLLOWER], ids=lambda P: P.name)
def test_they_agree_with_closed_forms_to_about_ten_digits(P):
    for state in states_in(P, 20).T:
        assert np.allclose(without(P).jacobian(state), P.jacobian(state), rtol=1e-9, atol=1e-9)


def test_they_agree_with_the_saltation_of_the_oscillator():
    for name in ("standard", "two harmonics", "under-damped", "trigger"):
        P = gz.stroboscopic_map(MODELS[name])
        for state in states_in(P, 10).T:
            J, step = P.jacobian(state), differences_of(P.step, 2, (1.0, 1.0))
            kind, row = P.packed()
            _new, _letter, _outcome, flat = step(tuple(state), P.prepare(kind(*row)))
            if np.isfinite(J).all():
                assert np.allclose(np.reshape(flat, (2, 2)), J, rtol=2e-5, atol=2e-5 * np.abs(J).max())


@pytest.mark.parametrize("d", [1, 2, 3])
def test_a_linear_map_is_its_own_derivative(d):
    A = np.random.default_rng(d).normal(size=(d, d))
    P = linear_map(A)
    assert np.allclose(without(P).jacobian(np.ones(d)), A, rtol=1e-10, atol=1e-10)
    assert np.allclose(without(P).jacobian(np.full(d, 1e6)), A, rtol=1e-10, atol=1e-10)  # steps grow with the state


def test_the_error_is_of_second_order(monkeypatch):
    def step(state, c):
        x, y = state
        return (math.exp(x) * math.sin(y), x * y * y * y), 0, 0

    x, y = 0.3, 0.7
    exact = np.array([math.exp(x) * math.sin(y), math.exp(x) * math.cos(y), y**3, 3 * x * y * y])
    sizes, errors = np.logspace(-1, -3, 8), []
    for h in sizes:
        monkeypatch.setattr(derivative, "STEP", h)
        errors.append(np.abs(np.array(differences_of(step, 2, (1.0, 1.0))((x, y), None)[3]) - exact))
    for column in np.array(errors).T[[0, 1, 3]]:
        assert np.polyfit(np.log(sizes), np.log(column), 1)[0] == pytest.approx(2.0, abs=0.05)


def test_the_step_itself_is_unchanged_and_taken_from_the_state():
    calls = []

    def step(state, c):
        calls.append(state)
        return (2.0 * state[0], state[1] + c), 7, 1

    new, letter, outcome, J = differences_of(step, 2, (1.0, 1.0))((3.0, -4.0), 0.5)
    assert (new, letter, outcome) == ((6.0, -3.5), 7, 1)
    assert np.allclose(J, (2.0, 0.0, 0.0, 1.0), atol=1e-9)
    assert len(calls) == 5  # the state, and two neighbours along each coordinate
    assert {(x != 3.0) + (y != -4.0) for x, y in calls} == {0, 1}


def test_one_function_for_one_step():
    assert differences_of(HENON.step, 2, (1.0, 1.0)) is differences_of(HENON.step, 2, (1.0, 1.0))
    P, row = without(HENON), HENON.packed()[1][None]
    one, other = P.derivative(row), P.replace(a=1.1).derivative(row)
    assert one.tangent is other.tangent and one.rows[0, 0] == other.rows[0, 0]  # the same code
    assert np.array_equal(one.source[0], row)  # what the address in its row points to


def test_a_derivative_ends_with_the_logarithm_of_its_determinant_where_that_is_known():
    state, letter, outcome, J = extended(SMOOTH.tangent)((0.25,), SMOOTH.packed()[0](3.2))
    assert (state, letter, outcome) == ((0.6000000000000001,), 0, 0) and J[0] == 1.6 and math.isnan(J[1])


def test_beyond_the_escape_there_is_none():
    def step(state, p):
        return (p.a * state[0],)

    P = gz.Map(step, params={"a": 2.0}, escape=1.0)
    assert np.isfinite(P.jacobian((0.4,))).all()
    assert np.isnan(P.jacobian((0.5,))).all()  # one of the neighbours has left


def tripled(state, p):
    """x -> 3 x mod 1: it jumps without a letter."""
    return (3.0 * state[0] % 1.0,)


def bent(state, p):
    """A kink at 0 that letters tell of."""
    (x,) = state
    return (p.left * x if x < 0.0 else p.right * x,), 0 if x < 0.0 else 1


def test_no_difference_is_taken_across_a_jump_or_a_kink():
    """Slopes next to jumps were some 1e5: exponents of x -> 3 x mod 1 were too large by five times their error."""
    jumps, kinks = gz.Map(tripled, box=((0.0, 1.0),)), gz.Map(bent, {"left": 0.5, "right": -2.0}, letters="LR")
    for x in (1 / 3 - 1e-7, 1 / 3 + 1e-7, 0.0, 1.0 - 1e-9):
        assert jumps.jacobian((x,)) == pytest.approx(3.0, rel=1e-9)
    for x, slope in ((-1e-9, 0.5), (0.0, -2.0), (1e-9, -2.0)):
        assert kinks.jacobian((x,)) == pytest.approx(slope, rel=1e-9)
    found = gz.lyapunov(jumps, starts=4, steps=200_000, threads=1)
    assert (abs(found.exponent - np.log(3.0)) < 2.0 * found.exponent_error).all()
    assert (found.exponent_error < 1e-9).all()


def tent(state, p):
    (x,) = state
    if x < 0.0:
        return (p.a * x + p.mu * p.unit,), 0
    return (p.b * x + p.mu * p.unit,), 1


@pytest.mark.parametrize("unit", [1e-12, 1e-6, 1e-3, 1.0, 1e6, 1e12])
def test_slopes_and_orbits_are_the_same_in_every_unit_of_length(unit):
    """A kink that is a unit away is not crossed, and a state near 0 is not lost in the rounding of the rest."""
    P = gz.Map(
        tent, {"a": -1.29, "b": 1.27, "mu": -0.45, "unit": unit}, ("x",), ((-4.0 * unit, 4.0 * unit),), letters="LR"
    )
    for x, slope in ((-0.2, -1.29), (-1e-3, -1.29), (1e-3, 1.27), (3.0, 1.27)):
        assert P.jacobian((x * unit,))[0, 0] == pytest.approx(slope, rel=1e-6)
    (orbit,) = gz.periodic_orbits(P, word="L", starts=100)
    assert orbit.points[0, 0] / unit == pytest.approx(-0.45 / 2.29, rel=1e-12)


def test_rows_of_another_shape_are_refused():
    """A kernel read parameters behind the end of the array."""
    P = gz.Map(lambda x, p: (p.a * x[0] + p.b,), {"a": 0.5, "b": 0.1})
    for rows in (np.ones((2, 1)), np.ones(2), np.ones((1, 2), int), [[0.5, 0.1]], None):
        with pytest.raises(gz.InputError, match=r"rows is .*shape \(columns, 2\)"):
            P.derivative(rows)
