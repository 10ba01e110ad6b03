"""Derivatives through slides and rests, against differences of a twin in 40 digits, and of the steps themselves."""

from math import pi

import mpmath as mp
import numpy as np
import pytest

import grazing as gz
from grazing.billiard.swing import swung, swung_by

FLOOR = gz.segment("floor", (-20, -4), (20, -4), gz.newton(0.7))
FAR = gz.flipper("L", (15.0, 8.0), 1.0, 0.1, -0.5, 0.6, gz.newton(0.7), up=14.0, down=9.0)
RHO = 0.5


def landed(x, y, vx, vy, floor):
    """Fall onto the floor: place, angle, speed and the time it takes."""
    height = y - floor
    t = vy + mp.sqrt(vy**2 + 2 * height)
    v = mp.mpf(gz.newton(0.7).params["r"]) * (t - vy)
    return x + vx * t, mp.atan2(-vx, v), mp.hypot(vx, v), t


def differences(twin, at, columns):
    with mp.workdps(40):
        h, found = mp.mpf(10) ** -15, []
        for j in columns:
            ends = []
            for sign in (1, -1):
                moved = [mp.mpf(x) for x in at]
                moved[j] += sign * h
                ends.append(twin(*moved))
            found.append([float((a - b) / (2 * h)) for a, b in zip(*ends, strict=True)])
    return np.array(found).T


def test_down_a_rail_and_off_its_end():
    (x1, y1), (x2, y2) = (-3.0, 1.0), (1.0, 0.0)
    rail = gz.segment("rail", (x1, y1), (x2, y2), gz.newton(0.5))
    player = gz.flips(period=40.0, hold=0.1)
    P = gz.collision_map(gz.table([rail, FLOOR, FAR], rho=RHO, tilt=pi / 2, player=player), on="rail")
    length, end = mp.hypot(x2 - x1, y2 - y1), P.box[0][1]
    ex, ey = (x2 - x1) / length, (y2 - y1) / length

    def twin(place, speed, clock):  # places go back along the left side
        u = mp.sqrt(speed**2 - 2 * ey * (length - (mp.mpf(end) - place)))
        place, angle, out, t = landed(x2 - RHO * ey, y2 + RHO * ex, u * ex, u * ey, mp.mpf(-4) + RHO)
        return -place, angle, out, clock + (u - speed) / -ey + t

    state = (end - 1.25, -pi / 2, 0.4, 1.0)
    new, letter = P(state)
    assert P.letters.symbol(letter) == "(floor)"
    kept = state[0], state[2], state[3]
    np.testing.assert_allclose(new[1:], [float(x) for x in twin(*map(mp.mpf, kept))[1:]], rtol=0, atol=1e-12)
    J = P.jacobian(state)
    np.testing.assert_allclose(J[:, [0, 2, 3]], differences(twin, kept, range(3)), rtol=0, atol=1e-12)
    assert np.abs(J[:, 1]).max() < 1e-14  # what it has along the normal is lost


@pytest.mark.parametrize("way", [1, -1])
def test_off_a_disc_where_the_normal_force_is_gone(way):
    disc = gz.disc("d", (0.0, 0.0), 1.0, gz.newton(0.5))
    P = gz.collision_map(gz.table([disc, FLOOR], rho=RHO, tilt=pi / 2), on="d")
    size = mp.mpf(1 + RHO)

    def twin(place, speed):
        start = place / size - mp.pi
        y = (speed**2 + 2 * size * mp.sin(start)) / 3  # there u^2 = g y
        x, u = way * mp.sqrt(size**2 - y**2), mp.sqrt(y)
        place, angle, out, _t = landed(x, y, way * u * y / size, -way * u * x / size, mp.mpf(-4) + RHO)
        return -place, angle, out

    state = (float((mp.pi * 3 / 2 - mp.mpf(way) / 10) * size), -way * pi / 2, 0.3)
    new, letter = P(state)
    assert P.letters.symbol(letter) == "(floor)"
    kept = state[0], state[2]
    np.testing.assert_allclose(new[1:], [float(x) for x in twin(*map(mp.mpf, kept))[1:]], rtol=0, atol=1e-12)
    J = P.jacobian(state)
    np.testing.assert_allclose(J[:, [0, 2]], differences(twin, kept, range(2)), rtol=0, atol=1e-11)
    assert np.abs(J[:, 1]).max() < 1e-13


def test_a_slide_that_hits_something_and_one_inside_an_arc():
    bowl = gz.arc("bowl", (0.0, 0.0), 2.0, -pi, 0.0, gz.newton(0.5))
    post = gz.segment("post", (0.6, -1.9), (0.6, 0.0), gz.newton(0.8))
    P = gz.collision_map(gz.table([bowl, post], rho=RHO, tilt=pi / 2), on="bowl")
    size = mp.mpf(2 - RHO)
    low, high = P.box[0]

    def twin(place, speed):  # by its energy at x = 0.6 - rho; places go clockwise inside
        turn = (mp.mpf(high) - place) / size - mp.pi
        x = mp.mpf(0.6) - RHO
        y = -mp.sqrt(size**2 - x**2)
        u = mp.sqrt(speed**2 + 2 * (size * mp.sin(turn) - y))
        vx, vy = -u * y / size, u * x / size
        out = mp.mpf(0.8) * vx
        return y, mp.atan2(-vy, out), mp.hypot(out, vy)

    state = (high - 1.2, pi / 2, 0.3)
    new, letter = P(state)
    kept = state[0], state[2]
    assert P.letters.symbol(letter) == "(post)" and low < state[0] < high
    np.testing.assert_allclose(new[2], float(twin(*map(mp.mpf, kept))[2]), rtol=0, atol=1e-12)
    J, D = P.jacobian(state)[:, [0, 2]], differences(twin, kept, range(2))
    np.testing.assert_allclose(np.abs(J), np.abs(D), rtol=0, atol=1e-11)


def test_how_a_pendulum_depends_on_where_it_begins():
    a, w, b, t, h = 0.3, 0.7, -1.3, 2.0, 1e-5
    found = np.array(swung_by(a, w, b, t)).reshape(2, 2)
    for j, (da, dw) in enumerate(((h, 0.0), (0.0, h))):
        (high, up), (low, down) = (np.array(swung(a + s * da, w + s * dw, b, t)) for s in (1, -1))
        np.testing.assert_allclose(found[:, j], [(2 * da + high - low) / 2 / h, (up - down) / 2 / h], atol=1e-9)
    assert np.linalg.det(found) == pytest.approx(1.0, abs=1e-13)


def test_a_stroke_under_a_ball_that_slides():
    flipper = gz.flipper("L", (0.0, 0.0), 3.0, 0.2, 0.1, 0.9, gz.newton(0.7), up=4.0, down=3.0)
    roof = gz.segment("roof", (-5, 6), (5, 6), gz.newton(0.5))
    T = gz.table([flipper, roof], rho=0.1, tilt=pi / 2, player=gz.flips(period=3.0, hold=0.5, phase=1.0))
    P = gz.collision_map(T)
    state = np.array([P.box[0][1] - 1.0, 0.5 * pi, 0.1, 0.5])
    state[0] = P.box[0][0] + 1.0
    new, letter = P(state)
    assert P.letters.symbol(letter) == "L" and new[3] == pytest.approx(1.0, abs=1e-12)
    J, h = P.jacobian(state), 1e-6
    for j in (0, 2, 3):
        moved = h * np.eye(4)[j]
        D = (P(state + moved)[0] - P(state - moved)[0]) / (2 * h)
        np.testing.assert_allclose(J[:, j], D, rtol=0, atol=1e-7)


@pytest.mark.parametrize(
    ("rest", "down", "foot", "along", "wait", "ends"),
    [(-1.2, 0.7, 1.7, -0.1, 0.1, "lets go"), (-0.4, 1.0, 0.9, 0.1, 0.4, "stops"), (-0.4, 0.5, 0.6, 0.8, 0.2, "hub")],
)
def test_on_a_flipper_that_turns(rest, down, foot, along, wait, ends):
    """Until nothing presses it on, the flipper stops, or it flies past the hub; there derivatives were not a number."""
    one = gz.flipper("F", (0, 0), 2.0, (0.2, 0.1), rest, rest + 1.0, gz.newton(0.0), up=2.0, down=down)
    P = gz.collision_map(gz.table([one, FLOOR], 0.1, tilt=pi / 2, player=gz.flips(9.0, 1.0)), on="F")
    size, lean, long = mp.mpf(0.2) + mp.mpf(0.1), mp.acos(mp.mpf(0.1) / 2), P.box[0][1]

    def twin(place, angle, speed, clock):
        w, a = -mp.mpf(down), mp.mpf(rest) + 1 - mp.mpf(down) * (clock - 1) + lean
        s, q = place - mp.mpf(long), speed * mp.sin(angle) - w * size

        def at(t):
            z, n = w * t, (mp.cos(a), mp.sin(a))
            c, d = mp.cosh(z) - mp.cos(z), mp.sinh(z) - mp.sin(z)
            here = s * mp.cosh(z) + q / w * mp.sinh(z) - (c * n[0] - d * n[1]) / (2 * w**2)
            rate = s * w * mp.sinh(z) + q * mp.cosh(z)
            rate -= ((mp.sinh(z) + mp.sin(z)) * n[0] - (mp.cosh(z) - mp.cos(z)) * n[1]) / (2 * w)
            return here, rate, mp.cos(a + z), mp.sin(a + z)

        def until(t):
            here, rate, _nx, ny = at(t)
            return here if ends == "hub" else ny - 2 * w * rate - size * w**2

        t = 1 + 1 / mp.mpf(down) - clock if ends == "stops" else mp.findroot(until, 0.5)
        s, q, nx, ny = at(t)
        if ends == "stops":  # it falls onto the side that stands still, and slides on
            return s, -mp.pi / 2, -(q + w * size), clock + t
        x, y, u = size * nx - s * ny, size * ny + s * nx, q + w * size
        place, angle, out, late = landed(x, y, -u * ny - w * s * nx, u * nx - w * s * ny, mp.mpf(-4) + mp.mpf(0.1))
        return -place, angle, out, clock + t + late

    push = down * foot  # the ball moves with the side
    state = long - foot, float(np.arctan2(along, -push)), float(np.hypot(along, push)), 1.0 + wait
    new, letter = P(state)
    assert P.letters.symbol(letter) == ("F" if ends == "stops" else "(floor)")
    np.testing.assert_allclose(new[1:], [float(x) for x in twin(*map(mp.mpf, state))[1:]], rtol=0, atol=1e-12)
    np.testing.assert_allclose(P.jacobian(state), differences(twin, state, range(4)), rtol=0, atol=1e-11)
