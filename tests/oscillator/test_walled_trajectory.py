"""Trajectories between walls: the map's states, samples, and figures of them."""

import matplotlib.pyplot as plt
import numpy as np
import pytest

import grazing as gz


def rig(side=None):
    """A ball between two moving walls, or at one of them."""
    low = gz.wall(-0.4, gz.active(r=0.7, V=0.2), motion=gz.Forcing(omega=3.4, cos=(0.05,), t0=0.3))
    high = gz.wall(0.6, gz.newton(0.6), motion=gz.Forcing(omega=1.7, cos=(), sin=(0.1,)))
    walls = {"below": [low], "above": [gz.wall(0.6, gz.newton(0.6), "above", high.motion)], None: [low, high]}[side]
    return gz.Oscillator(0.2, 1.1, gz.Forcing(omega=1.7, offset=0.1, cos=(1.2, 0.3)), walls=walls)


@pytest.mark.parametrize("side", [None, "below", "above"])
def test_trajectory_and_stroboscopic_map_have_the_same_states(side):
    m = rig(side)
    P = gz.stroboscopic_map(m, phase=0.7)
    orbit = P.orbit((0.1, 0.2), 8)
    for n in range(1, 9):
        tr = gz.trajectory(m, (0.1, 0.2), start=0.7, until=0.7 + n * m.period)
        np.testing.assert_allclose([tr.u[-1], tr.v[-1]], orbit.points[n], atol=1e-12)
    hits = "".join(tr.impact_wall.values)
    if side is None:
        assert hits == "".join(P.letters.symbol(int(letter)).strip("(0)") for letter in orbit.letters)
    else:
        assert len(hits) == orbit.letters.sum()


@pytest.mark.parametrize("side", [None, "below", "above"])
def test_impacts_are_at_their_walls_and_obey_their_laws(side):
    m = rig(side)
    tr = gz.trajectory(m, (0.1, 0.2), until=40.0)
    t = tr.impact_time.values
    at, speed = m.places_at(t)
    assert tr.sizes["impact"] > 8
    for i, name in enumerate(tr.impact_wall.values):
        j = m.names.index(name)
        wall = m.walls[j]
        arrives = wall.sign * (float(tr.v_minus[i]) - speed[j, i])
        leaves = wall.sign * (float(tr.v_plus[i]) - speed[j, i])
        assert float(tr.impact_speed[i]) == pytest.approx(-arrives, abs=1e-14)
        assert arrives < 0 and leaves == pytest.approx(wall.law(arrives), abs=1e-14)
        at_impact = tr.u.values[tr.t.values == t[i]]
        np.testing.assert_allclose(at_impact, at[j, i], atol=2e-15)
    for j, wall in enumerate(m.walls):
        assert (wall.sign * (tr.u.values - tr.wall_position.values[j])).min() >= 0.0


def test_the_equation_of_motion_holds_between_impacts():
    m = rig()
    tr = gz.trajectory(m, (0.1, 0.2), until=10.0, samples=4000)
    t, u, v = (tr[name].values for name in "tuv")
    clear = (t > t[0]) & (t < t[-1])  # at the ends differences are one-sided
    for hit in tr.impact_time.values:
        clear &= np.abs(t - hit) > 0.01
    force = 0.1 + 1.2 * np.cos(1.7 * t) + 0.3 * np.cos(3.4 * t)
    with np.errstate(divide="ignore", invalid="ignore"):
        wrong = np.gradient(v, t) - (force - 0.2 * v - 1.21 * u)
    assert np.abs(wrong[clear & np.isfinite(wrong)]).max() < 1e-4


@pytest.mark.parametrize("side", [None, "below", "above"])
def test_samples_lie_on_the_trajectory(side):
    m = rig(side)
    fine = gz.trajectory(m, (0.1, 0.2), until=12.0)
    few = gz.sample(gz.trajectory(m, (0.1, 0.2), until=12.0, samples=2), rate=50.0)
    whole = gz.sample(fine, rate=50.0)
    np.testing.assert_allclose(few.u, whole.u, atol=1e-13)
    np.testing.assert_allclose(few.v, whole.v, atol=1e-12)
    np.testing.assert_allclose(few.wall_position.values, m.places_at(few.t.values)[0])
    assert gz.spectrum(whole, of="u").sizes["frequency"] > 10


def test_samples_of_a_ball_that_rides_a_wall_move_with_it():
    walls = [gz.wall(-1.0, gz.newton(0.5), motion=gz.Forcing(omega=1.0, cos=(0.1,))), gz.wall(1.0, gz.newton(0.4))]
    m = gz.Oscillator(0.1, 0, gz.Forcing(omega=1.0, offset=-1.0, cos=()), walls=walls)
    taken = gz.sample(gz.trajectory(m, (0.1, 0.0), until=20.0, samples=3), rate=30.0)
    late = taken.t.values > 2 * m.period
    np.testing.assert_allclose(taken.u.values[late], -1 + 0.1 * np.cos(taken.t.values[late]), atol=1e-15)


def test_a_rest_lasts_as_long_as_the_ball_rides_the_wall():
    """A table that shakes with 2 sin t under a ball that stops dead: it leaves where 2 sin t = 1, with g = 1."""
    table = gz.wall(0.0, gz.newton(0.0), motion=gz.Forcing(omega=1.0, sin=(2.0,), cos=()))
    m = gz.Oscillator(alpha=0, k=0, forcing=gz.Forcing(omega=1.0, offset=-1.0, cos=()), walls=[table])
    tr = gz.trajectory(m, (3.0, 0.0), until=40.0)
    assert tr.sizes["rest"] > 2
    for begin, end in tr.rest_time.values:
        assert begin in tr.impact_time.values and begin < end
        if end < 40.0:
            assert 2.0 * np.sin(end) == pytest.approx(1.0, abs=1e-12)
        here = (tr.t.values >= begin) & (tr.t.values <= end)
        np.testing.assert_allclose(tr.u.values[here], tr.wall_position.values[0, here], atol=1e-14)


@pytest.mark.parametrize("side", [None, "below", "above"])
def test_figures_show_every_wall_and_the_impacts_on_it(side):
    m = rig(side)
    tr = gz.trajectory(m, (0.1, 0.2), until=20.0)
    drawn = gz.plot.history(tr)
    marks = drawn["impacts"][0]
    places = [float(m.places_at(np.array([t]))[0][m.names.index(name), 0])
              for t, name in zip(tr.impact_time.values, tr.impact_wall.values, strict=True)]  # fmt: skip
    np.testing.assert_allclose(marks.get_ydata(), places, atol=1e-12)
    low, high = drawn["motion"].axes.get_ylim()
    at = tr.wall_position.values
    assert low < min(tr.u.values.min(), at.min()) and high > max(tr.u.values.max(), at.max() if side is None else -1)
    assert len(drawn["motion"].axes.collections) == len(m.walls)
    portrait = gz.plot.trajectory(tr)
    assert len(portrait["impacts"]) == tr.sizes["impact"]
    plt.close("all")


def test_a_law_that_fails_is_named_with_the_time():
    def law(v, p):
        return -v if v > -0.5 else -1.0

    walls = gz.wall(-0.4, gz.reset(law)), gz.wall(0.6, gz.newton(1.0))
    with pytest.raises(gz.UserCodeError, match="returned -1"):
        m = gz.Oscillator(0.0, 0.0, gz.Forcing(omega=1.7, cos=(0.01,)), walls=walls)
        gz.trajectory(m, (0.1, 3.0), until=20.0)


def test_too_many_impacts_are_refused():
    law = gz.newton(1.0)
    m = gz.Oscillator(0, 0, gz.Forcing(omega=1.0, cos=()), walls=(gz.wall(0.0, law), gz.wall(1e-4, law)))
    with pytest.raises(gz.InputError, match="more than 200000 impacts up to t = "):
        gz.trajectory(m, (5e-5, 10.0), until=10.0)


@pytest.mark.parametrize("moving", [False, True])
def test_a_ball_on_the_second_wall_but_for_rounding_hits_it_at_once(moving):
    """Rounding put it behind the wall, and its impact was sought backwards in time."""
    w = 1.3
    waves = [gz.Forcing(omega=w, cos=(a,), sin=(b,)) if moving else None for a, b in ((0.12, 0.05), (0.0862, 0.0))]
    laws = gz.newton(0.8), gz.active(0.7, 0.1)
    walls = [gz.wall(x, law, motion=wave) for x, law, wave in zip((-0.6, 0.7), laws, waves, strict=True)]
    model = gz.Oscillator(alpha=0.25, k=0.5, forcing=gz.Forcing(omega=w, cos=(1.0, 0.2)), walls=walls)
    for start in (0.7068230085975923, 0.8281876103171107, 4.105031856744109):  # at which the distance is rounded down
        u = 0.7 + (0.0862 * np.cos(w * start) if moving else 0.0)
        for _ in range(3):
            u = float(np.nextafter(u, 0.0))
            flown = gz.trajectory(model, (u, 1.0), start=start, until=start + 0.4)
            assert abs(float(flown.impact_time[0]) - start) < 1e-12 and str(flown.impact_wall[0].values) == "B"
            assert (np.diff(flown.impact_time) > 0.0).all() and (np.diff(flown.t) >= 0.0).all()
