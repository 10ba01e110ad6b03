import numpy as np
import pytest

import grazing as gz
from grazing.orbits.closure import FIRED, PASSIVE, WHOLE
from grazing.orbits.contacts import contacts_of
from grazing.orbits.impact_equations import ImpactEquations
from grazing.orbits.periodic import periodic_orbits
from grazing.oscillator.reset import triggered_law
from tests.models import MODELS

NOTHING = np.empty(0)


def unknowns(model, n, N, seed):
    """Times in order, with room between them, and velocities of the model's own size."""
    random = np.random.default_rng(seed)
    pieces = (FIRED, PASSIVE) * n if model.reset.law is triggered_law else (WHOLE,) * n
    equations = ImpactEquations(model, (), N, pieces[:n])
    times = (np.arange(n) + random.uniform(0.2, 0.8, n)) * N * model.period / n
    return equations, np.concatenate([times, equations.scale[n:] * random.uniform(0.1, 1.0, n)])


@pytest.mark.parametrize("name", MODELS)
@pytest.mark.parametrize(("n", "N"), [(1, 1), (3, 2)])
def test_derivatives_are_those_of_the_defects(name, n, N):
    equations, x = unknowns(MODELS[name], n, N, 1)
    _F, J = equations.defects(x, NOTHING)
    for j in range(2 * n):
        h = 1e-5 * equations.scale[j]
        step = np.zeros(2 * n)
        step[j] = h
        high, low = (equations.defects(x + sign * step, NOTHING)[0] for sign in (1.0, -1.0))
        difference = (high - low) / (2.0 * h)
        # a slope by differences, as that of a user's law, has ten digits
        assert difference == pytest.approx(J[:, j], abs=2e-6 * np.abs(J).max(), rel=2e-6), j


@pytest.mark.parametrize("name", ["standard", "passive", "under-damped", "trigger", "undamped, no stiffness"])
def test_multipliers_are_those_of_the_map(name):
    P = gz.stroboscopic_map(MODELS[name])
    orbits = [one for one in periodic_orbits(P, (1, 2, 3), starts=500) if abs(one.multipliers[0]) < 1e3]
    assert orbits
    for orbit in orbits:
        J = np.eye(2)
        for point in orbit.points:
            J = P.jacobian(point) @ J
        trace, det = orbit.multipliers.sum().real, orbit.multipliers.prod().real
        size = np.abs(J).max() + 1.0
        assert np.trace(J) == pytest.approx(trace, abs=1e-7 * size), orbit
        assert np.linalg.det(J) == pytest.approx(det, abs=1e-7 * size * size), orbit


@pytest.mark.parametrize("name", ["standard", "passive", "trigger"])
def test_newton_is_quadratic(name):
    P = gz.stroboscopic_map(MODELS[name])
    orbit = next(one for one in periodic_orbits(P, (1, 2, 3), starts=500) if len(one.times))
    pieces = [WHOLE] * orbit.impacts
    if MODELS[name].reset.law is triggered_law:
        pieces = [FIRED if -v >= MODELS[name].params["trigger"] else PASSIVE for v in orbit.incoming]
    equations = ImpactEquations(orbit.model, (), orbit.period, pieces)
    x = np.concatenate([orbit.times, orbit.outgoing])
    off = np.resize((1.0, -1.0, 0.5), len(x)) * equations.scale
    errors = []
    for size in (1e-2, 1e-3, 1e-4):
        F, J = equations.defects(x + size * off, NOTHING)
        errors.append(np.abs((x + size * off - np.linalg.solve(J, F) - x) / equations.scale).max())
    orders = np.log10(np.array(errors[:-1]) / errors[1:])
    assert (orders > 1.8).all(), errors


def test_a_far_guess_that_does_not_converge_is_no_orbit():
    equations = ImpactEquations(gz.pinball(d=0.5), (), 1, (WHOLE,))  # so much offset that the wall is not reached
    guesses = np.array([[0.1, 3.0], [2.0, 0.2]])
    assert np.isnan(equations.solve(guesses, NOTHING)).all()


@pytest.mark.parametrize("walls", [1, 2])
def test_a_flight_through_a_wall_that_it_touches_is_no_orbit_of_the_oscillator(walls):
    """A spring of half the frequency of the force closes every flight after two periods, through walls or not.

    Where such a flight turns at a wall, rounding decides the sign of its speed there.
    """
    sides = gz.wall(-0.7, gz.newton(0.3)), gz.wall(5.3, gz.newton(0.3))
    force = gz.Forcing(omega=1.0, cos=(1.5,))
    model = gz.Oscillator(alpha=0.0, k=0.5, forcing=force, walls=sides[:walls])
    equations = ImpactEquations(model, (), 2, (contacts_of(model)[0],))
    x = np.column_stack([np.linspace(0.2, 6.2, 100), np.full(100, 1e-3)])
    solved = x[equations.solve(x, NOTHING) < 1e-14]
    touches = [equations.orbit(one, NOTHING) for one in solved]
    assert len([one for one in touches if one.incoming[0] < 0.0 <= one.outgoing[0]]) > 2
    assert not any(one.admissible for one in touches)
