"""Brackets of special points against closed forms in 40 digits, of the very doubles that the maps are given."""

import mpmath as mp
import numpy as np
import pytest

import grazing as gz
from grazing.orbits.rounding import shift_of


def hump(state, p):
    """A parabola with its top at c: fixed points meet at m = -1/4, and double at 3/4."""
    u = state[0] - p.c
    return (p.c + p.m - u * u,)


def henon(state, p):
    x, y = state
    return 1.0 - p.a * x * x + y, p.b * x


def delayed(state, p):
    return p.r * state[0] * (1.0 - state[1]), state[0]


def held(branch, wanted, narrow=1e-10):
    """How many special points have converged on a true value of their type, each of which must lie in the bracket."""
    count = 0
    for one in branch.special:
        true = min(wanted.get(one.type, ()), key=lambda value: abs(value - one.value), default=None)
        if true is not None and one.converged:
            assert one.low <= true <= one.high, (one, float(true - one.value), one.high - one.low)
            assert one.high - one.low < narrow * (1.0 + abs(one.value))
            count += 1
    return count


@pytest.mark.parametrize("c", [0.3, 37.0])
def test_folds_and_doublings_of_a_map_far_from_0_lie_in_their_brackets(c):
    P = gz.Map(hump, {"m": 0.2, "c": c}, box=((c - 2.0, c + 2.0),))
    branch = gz.continuation(P, gz.periodic_orbits(P, 1)[-1], "m", (-0.6, 1.1))
    assert held(branch, {"lp": [mp.mpf(-0.25)], "pd": [mp.mpf(0.75)]}) == 2


def test_doublings_and_a_torus_of_maps_of_the_plane_lie_in_their_brackets():
    box, b = ((-3.0, 3.0),) * 2, 0.3
    P = gz.Map(henon, {"a": 0.2, "b": b}, coordinates=("x", "y"), box=box)
    with mp.workdps(40):
        B = mp.mpf(b)
        wanted = {"lp": [-((1 - B) ** 2) / 4], "pd": [3 * (1 - B) ** 2 / 4]}
    assert held(gz.continuation(P, gz.periodic_orbits(P, 1)[-1], "a", (-1.0, 0.9), limit=60), wanted) == 2
    P = gz.Map(delayed, {"r": 1.85}, coordinates=("x", "y"), box=((0.05, 1.0),) * 2)
    assert held(gz.continuation(P, gz.periodic_orbits(P, 1)[-1], "r", (1.7, 2.2)), {"ns": [mp.mpf(2)]}) == 1


def test_a_graze_of_the_steady_response_lies_in_its_bracket_in_every_parameter():
    m = gz.pinball(alpha=0.7, k=1.3, omega=2.1, d=0.7, V=0.2)
    orbit = gz.periodic_orbits(gz.stroboscopic_map(m), 1, word="0")[0]
    with mp.workdps(40):

        def lift(k, omega):
            return k**2 / mp.sqrt((k**2 - omega**2) ** 2 + (mp.mpf(m.alpha) * omega) ** 2)

        k, omega = mp.mpf(m.k), mp.mpf(m.forcing.omega)
        true = {
            "d": lift(k, omega),
            "k": mp.findroot(lambda x: lift(x, omega) - mp.mpf(0.7), 1.5),
            "omega": mp.findroot(lambda x: lift(k, x) - mp.mpf(0.7), 1.9),
        }
    for name, value in true.items():
        branch = gz.continuation(orbit.map, orbit, name, (0.8 * float(value), 1.3 * float(value)))
        assert held(branch, {"gr": [value]}) >= 1, (name, value, branch)


def test_a_place_that_nothing_determines_may_be_anywhere():
    A = np.array([[1.0, 2.0], [2.0, 4.0]])
    assert shift_of(A, np.array([1e-16, 1e-16])) > 1.0
    assert shift_of(np.array([[0.0, 2.0], [1.0, 4.0]]), np.array([1e-16, 0.0])) == 5e-17


def scaled_logistic(state, p):
    return (p.a * state[0] * (1.0 - state[0] / p.s) + p.e * state[0],)


def cubic(state, p):
    x = state[0]
    return (p.m * x - p.q * x * x * x,)


@pytest.mark.parametrize("s, e", [(1.0, 0.0), (1463.0, -0.2449), (65.9, 0.28872), (5.56e-4, 0.4452), (2.0e5, 0.1)])
def test_branch_points_lie_in_their_brackets(s, e):
    P = gz.Map(scaled_logistic, {"a": 2.0 - e, "s": s, "e": e}, box=((-0.1 * s, s),))
    orbits = gz.periodic_orbits(P, 1)
    assert len(orbits) == 2
    wanted = {"bp": [1 - mp.mpf(e)]}
    assert sum(held(gz.continuation(P, orbit, "a", (0.3, 3.9)), wanted, 1e-6) for orbit in orbits) >= 1


def test_a_pitchfork_and_the_crossing_of_a_torus_map_lie_in_their_brackets():
    P = gz.Map(cubic, {"m": 1.5, "q": 1.7e-4}, box=((-100.0, 92.0),))
    (middle,) = (orbit for orbit in gz.periodic_orbits(P, 1) if abs(orbit.points[0, 0]) < 1e-9)
    assert held(gz.continuation(P, middle, "m", (-2.0, 3.0)), {"bp": [mp.mpf(1)], "pd": [mp.mpf(-1)]}, 1e-6) == 2
    P = gz.Map(delayed, {"r": 1.8}, coordinates=("x", "y"), box=((0.0, 1.0),) * 2)
    for orbit in gz.periodic_orbits(P, 1):
        held(gz.continuation(P, orbit, "r", (0.5, 2.4)), {"bp": [mp.mpf(1)], "ns": [mp.mpf(2)]}, 1e-6)


def pitchfork(state, p):
    u = state[0] - p.c
    return (p.c + p.m * u - p.q * u * u * u,)


def test_a_turn_at_a_pitchfork_far_from_0_lies_in_its_bracket():
    """Its defect is less than the last digit of the points, so that it seemed to be none at all."""
    c, s = 211.0464131975887, 64.21652362419843
    P = gz.Map(pitchfork, {"m": 1.5, "q": 1.0 / s**2, "c": c}, box=((c - 1.9 * s, c + 1.7 * s),))
    wanted = {"lp": [mp.mpf(1)], "bp": [mp.mpf(1)]}
    branches = [gz.continuation(P, orbit, "m", (-2.0, 2.8)) for orbit in gz.periodic_orbits(P, 1)]
    assert sum(held(branch, wanted, 1e-6) for branch in branches) >= 2


@pytest.mark.parametrize("e", [1e-5, 1e-7, 1e-10])
def test_where_a_bowl_takes_hardly_any_speed_the_doubling_lies_in_its_bracket(e):
    """V = (1 - r) sqrt(g R): defects were 0 all over the reach of the probes, and it was 4000 brackets off."""
    r, V = 1.0 - e, 1.2 * e
    bowl = gz.arc("bowl", (0.0, 0.0), 2.0, np.pi, 2.0 * np.pi, gz.active(r=r, V=V))
    orbit = gz.periodic_orbits(gz.collision_map(gz.table([bowl], tilt=0.5 * np.pi)), word="(bowl)", starts=10)[0]
    branch = gz.continuation(orbit.map, orbit, "bowl.V", (0.3 * V, 2.0 * V), points=400)
    true = (1 - mp.mpf(r)) * mp.sqrt(mp.mpf(orbit.map.params["g"]) * mp.sin(orbit.map.params["tilt"]) * 2)
    assert held(branch, {"pd": [true]}, 1e-4 * V) == 1
