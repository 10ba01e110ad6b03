import warnings

import numpy as np
import pytest

import grazing as gz
from grazing.orbits import search_section
from grazing.orbits.closure import WHOLE
from grazing.orbits.search_flights import recorded
from grazing.orbits.search_impacts import Solutions, Tally, turned
from grazing.orbits.search_rest import presses
from grazing.orbits.search_windows import cyclic_keys
from grazing.orbits.search_words import most_impacts
from tests.models import MODELS


def test_rotations_of_letters_share_a_key_and_other_words_do_not():
    one = np.array([[0, 0, 1, 2], [0, 1, 2, 0], [2, 0, 0, 1], [0, 0, 2, 1], [-1, 0, 1, 2]])
    keys, turn = cyclic_keys(one)
    assert len(set(keys[:3].tolist())) == 1 and len(set(keys.tolist())) == 3
    begun = [tuple(np.roll(row, -k)) for row, k in zip(one[:3], turn[:3], strict=True)]
    assert len(set(begun)) == 1


@pytest.mark.parametrize("name", ["standard", "passive", "under-damped", "two harmonics", "trigger", "own law"])
def test_recorded_impacts_are_those_of_the_trajectory(name):
    m = MODELS[name]
    states = np.array([[m.sigma + 0.02, -0.1], [m.sigma + 0.3, 0.2], [m.sigma, 0.4]])
    found = recorded(m, states, 4, 40)
    assert found.counts.max() > 0
    for i, state in enumerate(states):
        path = gz.trajectory(m, tuple(state), until=4.0 * m.period)
        n = len(path.impact_time)
        assert found.counts[i] == n
        assert found.times[i, :n] == pytest.approx(path.impact_time.values, abs=1e-9)
        assert found.incoming[i, :n] == pytest.approx(path.v_minus.values, abs=1e-9)
        assert found.outgoing[i, :n] == pytest.approx(path.v_plus.values, abs=1e-9)


def test_rests_and_too_many_impacts_are_no_guesses():
    m = MODELS["chatter"]
    assert recorded(m, np.array([[m.sigma + 0.05, -0.1]]), 3, 40).counts.tolist() == [-1]
    busy = MODELS["own law"]
    assert recorded(busy, np.array([[busy.sigma + 0.02, -0.3]]), 4, 1).counts.tolist() == [-1]


def test_a_solution_is_kept_once_whatever_its_first_impact_and_never_as_a_repetition():
    m = gz.pinball(d=0.1232, V=0.4)
    (orbit,) = gz.one_impact_orbits(m, 3)[-1:]
    x = np.array([[orbit.tau, orbit.v_plus]])
    found = Solutions(m, Tally())
    assert len(found.add(3, (WHOLE,), x)) == 1
    assert len(found.add(3, (WHOLE,), x + np.array([m.period, 0.0]))) == 0
    twice = np.array([[orbit.tau, orbit.tau + 3 * m.period, orbit.v_plus, orbit.v_plus]])
    assert len(found.add(6, (WHOLE,) * 2, twice)) == 0
    found.doublings(6)
    (doubled,) = found.found[6, (WHOLE,) * 2]
    assert len(found.add(6, (WHOLE,) * 2, turned(doubled[None], 1, 6 * m.period))) == 0


def test_a_ball_is_pressed_between_the_zeros_of_the_force():
    m = gz.pinball(d=-0.2, V=0.0)
    (t,) = presses(m)
    assert np.cos(m.params["omega"] * t) - 0.2 < 0.0
    assert presses(gz.pinball(d=2.0, V=0.0)) == [] == presses(gz.pinball(d=-2.0, V=0.0))


@pytest.mark.parametrize("V", [0.1, 0.4, 2.0])
def test_no_orbit_has_more_impacts_in_a_period_than_the_bound(V):
    m = gz.pinball(d=-0.5, V=V)
    P = gz.stroboscopic_map(m)
    random = np.random.default_rng(0)
    lanes = np.stack([random.uniform(0.0, 0.5, 500), random.uniform(-1.0, 1.0, 500)])
    _points, letters, _outcomes = P.run(lanes, 0, 30)
    assert letters.max() <= most_impacts(m) < np.inf
    assert most_impacts(m.replace(V=0.0)) == np.inf


def test_an_orbit_that_repeats_itself_after_half_a_period_is_one_of_whole_periods():
    """A force of the second harmonic alone repeats itself after T/2: 1 impact in 1.5 T is an orbit of 3 strobes."""
    single = gz.pinball(d=0.12, V=0.4)
    (orbit,) = gz.one_impact_orbits(single, 3)[-1:]
    half = gz.Oscillator(3.0, 1.0, gz.Forcing(omega=1.1, offset=0.12, cos=(0.0, 1.0)), single.reset)
    assert half.period == pytest.approx(2.0 * single.period)
    found = Solutions(half, Tally())
    times = orbit.tau + 3 * single.period * np.arange(4.0)
    twice, four = (np.r_[times[:n], np.full(n, orbit.v_plus)][None] for n in (2, 4))
    assert len(found.add(3, (WHOLE,) * 2, twice)) == 1
    assert len(found.add(6, (WHOLE,) * 4, four)) == 0
    assert found.tally.converged == 2
    (one,) = gz.periodic_orbits(gz.stroboscopic_map(half), 3)
    assert one.times == pytest.approx(np.mod(orbit.tau, single.period) + 3 * single.period * np.arange(2.0), abs=1e-9)


def test_guesses_are_not_decided_in_ball_arithmetic(monkeypatch):
    """Without a periodic force all orbits come to graze: thousands of guesses were settled one by one."""
    asked = []
    monkeypatch.setattr("grazing.maps.map.settle_orbits", lambda *args: asked.append(args))
    rig = gz.Oscillator.from_si(m=0.8, c=0.0, k=3200, gap="1 mm", load=-10.0, frequency=12, reset=gz.newton(0.7))
    P = gz.stroboscopic_map(rig)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = gz.periodic_orbits(P, period=1, starts=100)
        (orbit,) = found
        branch = gz.continuation(P, orbit, "offset", (10.0, 14.0))
    assert not asked and orbit.neutral and orbit.admissible
    assert abs(orbit.points[0, 0] - 12.5 / 4000.0) < 1e-12 and abs(orbit.points[0, 1]) < 1e-12  # it hangs at F/k
    (piece,) = branch.pieces
    assert piece.ends == ("bounds", "bounds")


def test_a_search_whose_flights_have_very_many_impacts_says_so_beforehand(monkeypatch, recwarn):
    P = gz.stroboscopic_map(gz.pinball(V=0.4))
    gz.periodic_orbits(P, 1, starts=3)
    assert not len(recwarn)
    monkeypatch.setattr(search_section, "MANY", 100)
    with pytest.warns(UserWarning, match=r"flies 3 starts for 255 periods with some \d impacts in each, .* takes long"):
        gz.periodic_orbits(P, 1, starts=3)
