"""The closing equations of words on a table: their derivatives, and solutions that are known in closed form."""

from math import pi

import mpmath as mp
import numpy as np
import pytest

import grazing as gz
from grazing.orbits.bounces import Bounces, conserves, elastic, solid_surfaces
from tests.billiard.orbits import active_discs, pinball
from tests.billiard.tables import ELASTIC, mixed, three_discs


@pytest.mark.parametrize("energy", [None, 3.0])
@pytest.mark.parametrize("word", [(0,), (1, 1), (0, -1, 9, -3, 8, 3), (-1, -2), (14, 15, -1)])
@pytest.mark.parametrize("tilt", [0.0, 0.4])
def test_derivatives_are_those_of_differences(word, energy, tilt):
    """On faces, ends, discs and both sides of an arc, of one impact and of several."""
    surfaces, h = solid_surfaces(mixed(0.1, tilt)), 1e-6
    bounces = Bounces(mixed(0.1, tilt), [surfaces[k] for k in word], energy)
    x = np.random.default_rng(1).uniform(0.3, 1.2, (3, 2 * len(word)))
    _F, J = bounces.defects(x)
    E = np.eye(x.shape[1])
    D = np.stack([(bounces.defects(x + h * e)[0] - bounces.defects(x - h * e)[0]) / (2 * h) for e in E], -1)
    np.testing.assert_allclose(J, D, atol=1e-9 * max(np.abs(J).max(), 1.0) ** 1.5)


def test_the_triangle_of_three_discs_is_the_one_that_is_known():
    """T = 4.26794919243112 a bounce, from guesses that are off by half a radian."""
    table = three_discs(6.0)
    bounces = Bounces(table, solid_surfaces(table), 0.5)
    x = np.array([[0.1, 2.9, -1.9, 4.0, 4.0, 4.0]])
    assert bounces.solve(x)[0] < 1e-14
    np.testing.assert_allclose(x[0], [pi / 6, 5 * pi / 6, -pi / 2, *[6.0 - 2.0 * np.cos(pi / 6)] * 3], atol=1e-14)


def test_a_ball_above_a_bumper_bounces_as_high_as_the_law_says():
    """With r and V it leaves at V/(1 - r) each time."""
    table = pinball(0.4)
    bounces = Bounces(table, [surface for surface in solid_surfaces(table) if surface.owner == 0])
    x = np.array([[1.2, 30.0]])
    bounces.solve(x)
    np.testing.assert_allclose(x[0], [pi / 2, 2.0 * 4.0 / table.gravity], rtol=1e-14)


def test_an_orbit_is_that_of_thirty_digits_flown_by_another_formula():
    """States flown and reflected in mpmath, shot from one bumper to the ceiling and back by way of the other one."""
    table = pinball(0.4)
    orbit = next(one for one in gz.periodic_orbits(gz.collision_map(table), word="PQ(ceiling)") if one.admissible)
    with mp.workdps(30):
        g, D, r, V = mp.mpf(table.gravity), mp.mpf(0.5) + mp.mpf(0.1), mp.mpf(0.9), mp.mpf(0.4)

        def flown(x, y, vx, vy, t):
            return x + vx * t, y + vy * t - g * t * t / 2, vx, vy - g * t

        def struck(x, y, vx, vy, nx, ny, bumper):
            v = vx * nx + vy * ny
            new = -r * v + (V if bumper else 0)
            return x, y, vx + (new - v) * nx, vy + (new - v) * ny

        def closing(angle, direction, speed, *times):
            x, y = 4 + D * mp.cos(angle), 6 + D * mp.sin(angle)
            state, out = (x, y, speed * mp.cos(direction), speed * mp.sin(direction)), []
            for t, centre in zip(times, (None, 2, 4), strict=True):
                x, y, vx, vy = flown(*state, t)
                if centre is None:
                    out.append(y - (10 - mp.mpf(0.1)))
                    state = struck(x, y, vx, vy, 0, -1, False)
                else:
                    nx, ny = (x - centre) / D, (y - 6) / D
                    out.append(nx * nx + ny * ny - 1)
                    state = struck(x, y, vx, vy, nx, ny, True)
            end = mp.atan2(state[1] - 6, state[0] - 4), mp.atan2(state[3], state[2]), mp.hypot(state[2], state[3])
            return [*out, end[0] - angle, end[1] - direction, end[2] - speed]

        names = [table.names[k] for k in orbit.map.orbit(orbit.points[0], 3).letters]
        k = (names.index("Q") + 1) % 3
        u, tau = np.roll(orbit.along, -k), np.roll(orbit.durations, -k)
        bounces = Bounces(table, [surface for s in np.roll(orbit.surfaces, -k)
                                  for surface in solid_surfaces(table) if surface.number == s])  # fmt: skip
        w = bounces.velocities(np.concatenate([u, tau]))[0][:, 0]
        guess = [u[0], np.arctan2(w[1], w[0]), np.hypot(*w), *tau]
        found = mp.findroot(closing, guess, tol=1e-25)
        np.testing.assert_allclose(np.array([float(one) for one in found]), guess, rtol=1e-12)


def test_laws_that_change_nothing_are_elastic_whoever_wrote_them():
    def mirror(v, p):
        return -v

    assert elastic(ELASTIC) and elastic(gz.active(1.0, 0.0)) and elastic(gz.reset(mirror))
    assert not elastic(gz.newton(1.0 - 1e-15)) and not elastic(gz.active(1.0, 1e-9)) and not elastic(None)
    assert conserves(three_discs(6.0).objects) and not conserves(active_discs(3.0).objects)
