"""Stroboscopic maps of systems of one's own, against those of oscillators."""

import pickle

import numpy as np
import pytest

import grazing as gz
from tests.systems.balls import billiard, bouncing
from tests.systems.models import oscillator


@pytest.mark.parametrize("walls", [1, 2])
def test_points_letters_and_jacobians_are_those_of_the_oscillator(walls):
    system, model = oscillator(walls=walls)
    P, Q = gz.stroboscopic_map(system, phase=0.4), gz.stroboscopic_map(model, phase=0.4)
    a, b = P.orbit((0.1, 0.3), 30), Q.orbit((0.1, 0.3), 30)
    np.testing.assert_allclose(a.points, b.points, atol=1e-11)
    assert a.letters.tolist() == b.letters.tolist() and P.letters == Q.letters
    for state in b.points[:12]:
        A, B = P.jacobian(state), Q.jacobian(state)
        np.testing.assert_allclose(A, B, atol=3e-11 * np.abs(B).max())


def test_orbits_branches_and_exponents_are_those_of_the_oscillator():
    system, model = oscillator(walls=2)
    P, Q = gz.stroboscopic_map(system), gz.stroboscopic_map(model)
    (one,), (other,) = (gz.periodic_orbits(R, period=1, starts=20, threads=1) for R in (P, Q))
    assert one.word == other.word == "(BAB)"
    np.testing.assert_allclose(one.points, other.points, atol=1e-11)
    np.testing.assert_allclose(one.multipliers, other.multipliers, atol=1e-9)
    ours, theirs = (gz.continuation(R, orbit, "B.r", (0.5, 0.8)).special for R, orbit in ((P, one), (Q, other)))
    assert [one.type for one in ours] == ["gr", "pd"]  # the oscillator's branch goes on beyond its graze
    for a, b in zip(ours, theirs, strict=False):
        assert a.type == b.type and abs(a.value - b.value) < 1e-9
    small = {"starts": 3, "transient": 100, "keep": 20, "threads": 1, "box": P.box}
    values = np.array([0.55, 0.6, 0.7])
    a, b = (gz.lyapunov(R, "B.r", values, **small).exponent.values for R in (P, Q))
    np.testing.assert_allclose(a, b, atol=1e-9)
    a, b = (gz.orbit_diagram(R, "B.r", values, **small) for R in (P, Q))
    assert a.word.values.tolist() == b.word.values.tolist() and a.attrs["title"]


def test_the_laws_of_maps_hold_and_copies_are_equal():
    P = gz.stroboscopic_map(bouncing(A=0.05, r=0.6, height=0.6))
    gz.testing.check_map(P, states=4, steps=4)
    assert pickle.loads(pickle.dumps(P)) == P
    with pytest.raises(gz.InputError, match="the start is inside surface B"):
        P((1.0, 0.0))


def test_letters_name_many_surfaces():
    P = gz.stroboscopic_map(billiard())
    letters = P.orbit((0.5, 0.7, 0.9, -0.8), 8).letters
    flown = gz.trajectory(billiard(), (0.5, 0.7, 0.9, -0.8), until=8.0, samples=2)
    said = "".join(P.letters.symbol(int(letter)).strip("()0") for letter in letters)
    assert said == "".join(flown.impact_wall.values) and {*said} == {*"LRBA"}


def test_chatter_ends_the_orbit_by_name():
    orbit = gz.stroboscopic_map(bouncing(A=0.0, r=0.2)).orbit((0.3, 0.0), 3)
    assert orbit.outcomes[1] & gz.Outcome.too_many_impacts and np.isnan(orbit.points[-1]).all()


def shown(walls, L, T):
    """What the map of an oscillator written as a system says of it, without units."""
    P, S = gz.stroboscopic_map(oscillator(walls=walls, L=L, T=T)[0], phase=0.4 * T), L / T
    orbit = P.orbit((0.1 * L, 0.3 * S), 12)
    J = np.array([P.jacobian(state) for state in orbit.points[:5]]) * [[1.0, 1.0 / T], [T, 1.0]]
    starts = np.array([[0.1, 0.2], [0.2, -0.3]]) * (L, S)
    found = gz.lyapunov(P, "A.r", [0.7, 0.75], starts=starts, transient=40, steps=40, threads=1, arithmetic="strict")
    flown = gz.trajectory(P.origin.system, (0.1 * L, 0.3 * S), until=9.0 * T, samples=4)
    return [
        orbit.points / (L, S), orbit.letters, orbit.outcomes, J, found.exponent.values,
        found.exponent_per_time.values * T, flown.impact_time.values / T, flown.v_plus.values / S,
    ]  # fmt: skip


@pytest.mark.parametrize("walls", [1, 2])
def test_systems_are_the_same_in_any_unit(walls):
    # errors were those of positions and velocities added up; differences in time reached over a thousandth of whatever
    # unit, and a Jacobian was good to three digits in a slow one
    plain = shown(walls, 1.0, 1.0)
    for a, b in [(30, 0), (-30, 20), (0, 30), (25, -20)]:
        for one, other in zip(plain, shown(walls, 2.0**a, 2.0**b), strict=True):
            assert one.shape == other.shape and (one == other).all()
    for one, other in zip(plain, shown(walls, 1e-6, 1e3), strict=True):
        np.testing.assert_allclose(other, one, rtol=1e-8, atol=1e-8)


@pytest.mark.parametrize("T", [2.0**-50, 2.0**50])
def test_no_unit_of_time_makes_an_orbit_ambiguous(T):
    P = gz.stroboscopic_map(oscillator(walls=2, T=T)[0])
    assert not P.orbit((0.1, 0.3 / T), 12).outcomes.any()
    assert gz.trajectory(P.origin.system, (0.1, 0.3 / T), until=20.0 * T, samples=2).trust == "numerical"


def test_a_flight_is_tried_over_a_time_of_its_own():
    # it was tried over a quarter of whatever unit, in which what is damped fast leaves the range of numbers
    system, model = oscillator(alpha=30.0, T=1e-4)
    P, Q = gz.stroboscopic_map(system), gz.stroboscopic_map(model)
    assert np.allclose(P.orbit((0.1, 3e3), 4).points, Q.orbit((0.1, 3e3), 4).points, rtol=1e-9)
