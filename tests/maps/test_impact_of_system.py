"""Impact maps of systems of one's own, against those of oscillators and closed forms."""

import pickle

import numpy as np
import pytest

import grazing as gz
from grazing.maps.derivative import tangent_runner
from tests.systems.balls import billiard, bouncing
from tests.systems.models import oscillator


@pytest.mark.parametrize("walls", [1, 2])
def test_points_letters_and_jacobians_are_those_of_the_oscillator(walls):
    system, model = oscillator(walls=walls)
    P, Q = gz.impact_map(system), gz.impact_map(model)
    a, b = P.orbit((0.3, -0.2, 0.5), 30), Q.orbit((0.3, 0.5), 30)
    np.testing.assert_allclose(a.points[:, (0, 2)], b.points, atol=1e-11)
    assert a.letters.tolist() == b.letters.tolist() and P.letters == Q.letters
    for ours, theirs in zip(a.points[:12], b.points[:12], strict=True):
        A, B = P.jacobian(ours), Q.jacobian(theirs)
        np.testing.assert_allclose(A[np.ix_([0, 2], [0, 2])], B, atol=1e-10 * np.abs(B).max())
        assert np.abs(A[1]).max() < 1e-10 * np.abs(B).max()  # whatever changes, the impact is at the wall


def test_a_start_off_the_surface_flies_to_the_first_impact():
    system, _model = oscillator(walls=2)
    flown = gz.trajectory(system, (0.1, 0.3), start=0.4, until=20.0, samples=2)
    (tau, u, v), _letter = gz.impact_map(system)((0.4, 0.1, 0.3))
    T = system.period_at(system.params)
    assert abs(tau - flown.impact_time.values[0] % T) < 1e-12 and abs(abs(v) - flown.v_plus.values[0]) < 1e-12
    assert abs(u - {"A": -0.2, "B": 0.3}[str(flown.impact_wall.values[0])]) < 1e-12


def test_orbits_branches_and_exponents_are_those_of_the_oscillator():
    system, model = (one.replace(**{"B.r": 0.55}) for one in oscillator(walls=2))
    P, Q = gz.impact_map(system), gz.impact_map(model)
    (one,), (other,) = (gz.periodic_orbits(R, period=3, starts=20, threads=1) for R in (P, Q))
    assert one.word == other.word == "AB1B" and one.stable is True
    ours, theirs = (points[np.argsort(points[:, 0])] for points in (one.points, other.points))
    np.testing.assert_allclose(ours[:, (0, 2)], theirs, atol=1e-11)
    np.testing.assert_allclose(np.sort_complex(one.multipliers)[[0, 1]], np.sort_complex(other.multipliers), atol=1e-9)
    assert abs(one.multipliers[2]) < 1e-12  # across the section nothing lasts
    ours, theirs = (gz.continuation(R, orbit, "B.r", (0.5, 0.6)).special for R, orbit in ((P, one), (Q, other)))
    assert [one.type for one in ours] == ["gr"]  # the oscillator's branch goes on beyond its graze
    assert theirs[0].type == "gr" and abs(ours[0].value - theirs[0].value) < 1e-9
    values, few = np.array([0.55, 0.6]), {"transient": 100, "keep": 30, "threads": 1, "arithmetic": "strict"}
    a, b = (
        gz.lyapunov(R, "B.r", values, starts=start[None], **few)
        for R, start in ((P, one.points[0]), (Q, other.points[0]))
    )
    for name in ("exponent", "exponent_per_time"):
        np.testing.assert_allclose(a[name].values[..., :1], b[name].values[..., :1], atol=1e-8)
    assert np.isneginf(a.exponent.values[..., -1]).all()  # it was the logarithm of rounding


def test_a_ball_without_a_clock_has_the_speeds_of_its_bounces():
    P = gz.impact_map(bouncing(A=0.0, r=0.5, period=None))
    assert P.coordinates == ("x", "v") and P.letters.symbol(0) == "A"
    orbit = P.orbit((0.5, 0.0), 6)
    np.testing.assert_allclose(orbit.points[1:, 1], 0.5 ** np.arange(1, 7), rtol=1e-13)
    np.testing.assert_allclose(P.jacobian((0.0, 1.0)), [[0.0, 0.0], [0.5, 0.5]], atol=1e-9)
    tangent, prepare, kind, rows, _source, *_more = P.derivative(P.packed()[1][None])
    lanes = np.zeros((2, 1))  # a bounce of no height takes long to give up, and began anew for ever
    outcome = tangent_runner(tangent, prepare, kind, 2)(rows[0], lanes, np.empty((2, 2)))
    assert outcome & gz.Outcome.too_many_swings and np.isnan(lanes).all()


def test_the_letters_of_a_billiard_are_its_walls():
    system = billiard()
    walls = gz.System(
        system.positions, system.velocities, system.params, system.flight, system.surfaces, system.box, name="billiard"
    )
    P = gz.impact_map(walls)
    start = (0.5, 0.7, 0.9, -0.8)
    letters = "".join(map(P.letters.symbol, P.orbit(start, 12).letters.tolist()))
    assert letters == "".join(gz.trajectory(walls, start, until=30.0, samples=2).impact_wall.values[:12])
    found = gz.lyapunov(P, "r", [1.0], starts=2, transient=2, keep=4, threads=1, arithmetic="strict")
    assert "exponent_per_time" not in found


def test_the_laws_of_maps_hold_and_copies_are_equal():
    P = gz.impact_map(bouncing(A=0.05, r=0.6, height=0.6))
    gz.testing.check_map(P, states=4, steps=4)
    assert pickle.loads(pickle.dumps(P)) == P
    with pytest.raises(gz.InputError, match="the start is inside surface B"):
        P((0.1, 1.0, 0.0))


def test_a_ball_that_meets_nothing_any_more_is_said_to():
    orbit = gz.impact_map(bouncing(A=0.0).replace(g=0.0)).orbit((0.0, 0.3, 0.1), 2)
    assert gz.Outcome(int(orbit.outcomes[0])) == gz.Outcome.no_impact and np.isnan(orbit.points[1]).all()


def shown(walls, L, T):
    """What the map of an oscillator written as a system says of it, without units."""
    P, S = gz.impact_map(oscillator(walls=walls, L=L, T=T)[0]), L / T
    orbit, units = P.orbit((0.1 * T, 0.1 * L, 0.3 * S), 12), np.array([T, L, S])
    J = np.array([P.jacobian(state) for state in orbit.points[:5]]) * (units / units[:, None])
    return [orbit.points / units, orbit.letters, orbit.outcomes, J]


@pytest.mark.parametrize("walls", [1, 2])
def test_the_map_is_the_same_in_any_unit(walls):
    plain = shown(walls, 1.0, 1.0)
    for a, b in [(30, 0), (-30, 20), (25, -20)]:
        for one, other in zip(plain, shown(walls, 2.0**a, 2.0**b), strict=True):
            assert one.shape == other.shape and (one == other).all()


def test_a_coordinate_cannot_be_called_like_the_phase():
    system = bouncing()
    with pytest.raises(gz.InputError, match="tau is a coordinate of the system"):
        gz.impact_map(
            gz.System(("tau",), ("v",), system.params, system.flight, system.surfaces, system.box, period=1.0)
        )
