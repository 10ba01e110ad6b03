import numpy as np
import pytest

import grazing as gz
from grazing.orbits.backward import BACK, CLIMB, HEIGHT, HIT, Seen, flown_back, impacts_before, periods_later, touches


def soft(v, p):
    return -p.r * v / (1.0 - p.c * v)


def bent(v, p):
    """Jumps down at a speed of 1: two speeds of impact for some speeds of departure."""
    return -p.a * v if v > -1.0 else -0.1 * v


def oscillator(alpha, k, omega, reset, offset=0.0, **forcing):
    return gz.Oscillator(alpha=alpha, k=k, forcing=gz.Forcing(omega=omega, offset=offset, **forcing), reset=reset)


FLIGHTS = {
    "over-damped": oscillator(3.0, 1.0, 2.2, gz.newton(0.8), 0.3),
    "critical": oscillator(2.0, 1.0, 2.2, gz.newton(0.8), 0.4),
    "under-damped": oscillator(0.3, 2.0, 1.1, gz.newton(0.8), 0.8, cos=(1.0, 0.3), sin=(0.2, 0.5)),
    "undamped": oscillator(0.0, 1.0, 1.3, gz.newton(0.8), 0.8),
    "resonant": oscillator(0.0, 1.3, 1.3, gz.newton(0.8), 0.8),
    "free": oscillator(0.0, 0.0, 2.2, gz.newton(0.8), 0.8, cos=(1.0, 0.4)),
    "dragged": oscillator(1.0, 0.0, 2.2, gz.newton(0.8), 0.2),
}


@pytest.mark.parametrize("name", FLIGHTS)
def test_there_and_back_again(name):
    model, phase = FLIGHTS[name], 0.7
    P, seen = gz.stroboscopic_map(model, phase), Seen.at(model, phase)
    rng = np.random.default_rng(3)
    none = hit = 0
    for start in rng.uniform([0.0, -1.5], [1.5, 1.5], (200, 2)):
        orbit = P.orbit(start, 1)
        if orbit.letters[0] not in (0, 1) or min(orbit.near_miss, orbit.slowest) < 1e-4:
            continue
        u, v = orbit.points[1]
        line = np.array([[0.0, u, -v, 0.0]])
        flown_back(seen, line)
        if orbit.letters[0] == 1:
            assert line[0, HIT] == 1.0 and line[0, HEIGHT] == 0.0 and line[0, CLIMB] < 0.0
            line[0, CLIMB] = impacts_before(seen, -line[:, CLIMB])[0, 0]
            flown_back(seen, line)
            hit += 1
        else:
            none += 1
        assert line[0, HIT] == 0.0 and line[0, BACK] == model.period
        assert [line[0, HEIGHT], -line[0, CLIMB]] == pytest.approx(start, abs=1e-9)
    assert none + hit >= 10


def test_following_forwards_is_the_map():
    model = FLIGHTS["under-damped"]
    starts = np.array([[0.3, 0.2], [0.5, -1.0], [0.1, 0.9]])
    later = periods_later(model, 0.7, starts, np.array([0, 1, 3]))
    P = gz.stroboscopic_map(model, 0.7)
    for start, end, n in zip(starts, later, (0, 1, 3), strict=True):
        assert end == pytest.approx(P.iterate(start, n)[-1], abs=1e-15)


def test_a_touch_and_what_is_none():
    model = oscillator(0.0, 0.0, 1.0, gz.newton(0.5), 2.0, cos=(0.0,))  # u'' = 2: u = (t - 1)^2 touches at t = 1
    states = np.array([[1.0, -2.0], [1.0 + 1e-12, -2.0], [1.5, -2.0], [0.2, -2.0]])
    heights, impacts = touches(model, 0.0, states, np.full(4, 1.0), np.full(4, 1.0))
    assert heights[:3] == pytest.approx([0.0, 1e-12, 0.5], abs=1e-15)
    assert impacts[:3].tolist() == [0, 0, 0]
    assert impacts[3] != 0  # it hits before


def test_the_inverse_of_the_reset_laws():
    w = np.array([0.05, 0.3, 0.7, 2.0])

    def speeds(law):
        return impacts_before(Seen.at(oscillator(0.1, 1.0, 2.0, law), 0.0), w)

    assert speeds(gz.newton(0.5))[:, 0] == pytest.approx(2.0 * w)
    assert speeds(gz.newton(0.0)).size == 0
    assert np.isnan(speeds(gz.reset(lambda v, p: p.V, V=0.3))).all()
    kicked = speeds(gz.active(0.5, 0.3))[:, 0]
    assert np.isnan(kicked[:2]).all() and kicked[2:] == pytest.approx([0.8, 3.4])
    both = speeds(gz.triggered(0.5, 0.3, 0.7))
    assert both[:, 0] == pytest.approx([0.1, 0.6, np.nan, np.nan], nan_ok=True)
    assert both[:, 1] == pytest.approx([np.nan, np.nan, 0.8, 3.4], nan_ok=True)
    own = speeds(gz.reset(soft, r=0.8, c=0.3))
    assert own[:, 0] == pytest.approx(w / (0.8 - 0.3 * w))
    assert np.isnan(own[:, 1:]).all()
    twice = speeds(gz.reset(bent, a=0.6))
    assert np.isfinite(twice).sum(axis=1).tolist() == [1, 2, 1, 1]
    assert twice[1, :2] == pytest.approx([0.5, 3.0]) and twice[3, 0] == pytest.approx(20.0)
