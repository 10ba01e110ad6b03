"""Slides on flippers while they turn: the constraint in many digits, the normal force, walls in the way."""

from math import cos, hypot, pi, sin, tan

import mpmath as mp
import numpy as np
import pytest

import grazing as gz
from grazing.billiard.flippers import LONG
from grazing.billiard.flown import (
    AFTER,
    BEFORE,
    FIRST,
    FLAGS,
    LAST,
    LEFT,
    NEXT,
    OWNER,
    PATH,
    TIME,
    flights_of,
    way_along,
)
from grazing.billiard.hit import pose
from grazing.billiard.march import first_contact
from grazing.billiard.turning import OFF, RIDES, normal_at
from grazing.outcome import CHATTER, STUCK, TOO_MANY_IMPACTS

SOFT, UP = gz.newton(0.5), 0.5 * pi


def swings(up=2.0, down=0.5, more=(), times=(1.0, 3.0), angles=(-0.4, 0.7)):
    """Return a table with a flipper under a ball, that is pressed for a while."""
    one = gz.flipper("F", (0, 0), 2.0, (0.2, 0.1), *angles, gz.newton(0.0), up=up, down=down)
    return gz.table([one, *more], 0.1, tilt=UP, player=gz.presses(F=list(times)))


def on_line(state, normal, omega, size, g, t):
    """Return the state after a time of a ball on a line that turns about the origin: its constraint, in many digits."""
    with mp.workdps(25):

        def rates(s, y):
            c, d = mp.cos(omega * s), mp.sin(omega * s)
            n = c * normal[0] - d * normal[1], d * normal[0] + c * normal[1]
            spun = -omega * n[1], omega * n[0]
            # n . p = size for ever, twice differentiated: what the line must push with
            push = omega**2 * size - 2 * (spun[0] * y[2] + spun[1] * y[3]) + g * n[1]
            return [y[2], y[3], push * n[0], push * n[1] - g]

        return [float(one) for one in mp.odefun(rates, 0, [mp.mpf(float(one)) for one in state], tol=1e-18)(t)]


def rides_of(flights):
    """Return the rows of slides on flippers that turn."""
    return np.flatnonzero(flights[:, LEFT] % 1.0 == RIDES)


@pytest.mark.parametrize("start", [0.5, 1.2])
def test_on_a_flipper_that_turns_it_slides_as_the_constraint_says(start):
    """It ended there by name: *bounces too small to tell apart*."""
    table = swings(times=(1.0, 1.4))
    flights = flights_of(table, (start, 1.0, 0.0, 0.0), 0.0, 9.0)
    clocks, found = np.concatenate([[0.0], np.cumsum(flights[:-1, TIME])]), rides_of(flights)
    assert len(found) > 0
    block = table.blocks(table.row())[0]
    for k in found[flights[found, TIME] > 1e-3]:
        row, kind, ux, uy, omega = pose(int(flights[k, PATH]), 0.0, clocks[k], block)
        normal, (x, y, vx, vy) = normal_at(kind, ux, uy, row), flights[k, FIRST:LAST]
        off = normal[0] * (vx + omega * y) + normal[1] * (vy - omega * x)  # less than can be told
        state = x, y, vx - off * normal[0], vy - off * normal[1]
        ends = on_line(state, normal, omega, 0.3, table.gravity, flights[k, TIME])
        np.testing.assert_allclose(flights[k, LAST:NEXT], ends, rtol=0.0, atol=1e-13)
        middle = way_along(block, flights[k], float(clocks[k]), np.array([0.5 * flights[k, TIME]]))[0]
        assert abs(table.distances(*middle[:2], clocks[k] + 0.5 * flights[k, TIME])["F"] - 0.1) < 1e-13


def test_it_leaves_a_flipper_that_turns_away_where_nothing_presses_it_on():
    """It slides down and outwards, and N = g n_y - 2 w q - D w^2 falls to 0."""
    table = swings(down=0.7, times=(0.0, 1.0), angles=(-1.2, -0.2))
    flights = flights_of(table, (0.2, 0.5, 0.0, 0.0), 0.0, 9.0)
    (k,) = (k for k in rides_of(flights) if flights[k + 1, LEFT] % 1.0 == OFF)
    t = flights[: k + 1, TIME].sum()
    row, kind, ux, uy, omega = pose(int(flights[k, PATH]), 0.0, t, table.blocks(table.row())[0])
    nx, ny = normal_at(kind, ux, uy, row)
    x, y, vx, vy = flights[k, NEXT:PATH]
    s, q = nx * y - ny * x, nx * vy - ny * vx - omega * 0.3
    assert abs(table.gravity * ny - 2.0 * omega * q - 0.3 * omega**2) < 1e-13 and 0.3 < -s < row[LONG] - 0.1
    assert flights[k, TIME] > 0.1 and flights[k + 1, TIME] > 0.01


def test_what_is_in_its_way_as_it_slides_it_hits():
    table = swings(more=[gz.disc("post", (1.0, 1.4), 0.15, gz.newton(1.0))], times=(0.6, 3.0))
    flights = flights_of(table, (1.1, 0.6, 0.0, 0.0), 0.0, 4.0, 5)
    (k, *_) = (k for k in rides_of(flights) if flights[k, OWNER] == 1.0)
    assert hypot(flights[k, LAST] - 1.0, flights[k, LAST + 1] - 1.4) == pytest.approx(0.25, abs=1e-12)
    assert flights[k, TIME] > 0.01 and flights[k + 1, LEFT] % 1.0 == 0.0 and flights[k, AFTER] == -flights[k, BEFORE]


@pytest.mark.parametrize(("bounce", "place", "phase"), [(0.0, 5.589388355242445, 0.61), (0.5, 5.54, 0.9)])
def test_jammed_between_a_flipper_and_a_post_it_ends_by_name(bounce, place, phase):
    """A thousand impacts of no time were decided exactly, for ten seconds; maps went on with them for ever."""
    post = gz.disc("post", (0.8, 1.2), 0.15, gz.newton(bounce))
    flights = flights_of(swings(more=[post], times=(0.6, 3.0)), (0.9, 0.6, 0.0, 0.0), 0.0, 9.0, 5000)
    assert int(flights[-1, FLAGS]) & TOO_MANY_IMPACTS and len(flights) < 200 and flights[-1, TIME] < 1e-15
    one = gz.flipper("F", (0, 0), 2.0, (0.2, 0.1), -0.4, 0.7, gz.newton(0.0), up=2.0, down=1.0)
    P = gz.collision_map(gz.table([one, post], 0.1, tilt=UP, player=gz.flips(4.0, 1.2, phase=0.6)))
    assert P.orbit((place, 0.0, 0.05, phase), 50).outcomes[-1] & TOO_MANY_IMPACTS


def test_slowly_squeezed_out_between_a_flipper_and_a_post_it_ends_by_name():
    """Some ten thousand impacts without any time, each of which makes it faster: maps went on with that."""
    one = gz.flipper(
        "F",
        (0, 0),
        2.0,
        (0.2, 0.1),
        -0.7864623913161676,
        0.7,
        gz.newton(0.0),
        up=4.487080878944846,
        down=1.262673107311589,
    )
    post = gz.disc("post", (0.9251155610205202, 1.2884758377290084), 0.15, gz.newton(0.3))
    T = gz.table([one, post], 0.1, tilt=UP, player=gz.flips(6.0, 1.4, phase=0.8417871099505136))
    flights = flights_of(T, (0.8349179348456317, 0.5112679021259277, 0.0, 0.0), 0.0, 12.0, 5000)
    assert int(flights[-1, FLAGS]) & TOO_MANY_IMPACTS and len(flights) < 9


@pytest.mark.parametrize(
    ("angle", "side", "scale"), [(0.1, 1, 1.0), (0.1, -1, 1e3), (0.0021, 1, 1e-3), (0.0021, -1, 1.0)]
)
def test_in_a_narrow_corner_it_is_not_jammed(angle, side, scale):
    """It meets both walls pi/angle times, nearly all of them without any time: by unfolding."""
    tip, long = 5.0 * side * scale, 9.0 * scale
    places = [((-tip, 0), (tip, 0)), ((tip, 0), (tip - side * long * cos(angle), long * sin(angle)))]
    walls = [gz.segment(name, *ends, gz.newton(1.0)) for name, ends in zip("AB", places, strict=True)]
    rho = scale * min(0.1, 2.0 * angle)
    start = side * (4.0 * scale - rho / tan(angle / 2)), rho, 2.0 * side * scale, 0.0
    flights = flights_of(gz.table(walls, rho, scale, tilt=UP), start, 0.0, 2.0)
    touched = flights[(flights[:, TIME] < 1e-12) & (flights[:, OWNER] >= 0.0)]
    assert len(touched) == int(pi / angle) - 1 and not int(flights[-1, FLAGS]) & TOO_MANY_IMPACTS


def test_a_map_goes_on_through_a_slide_on_a_flipper_that_turns():
    one = gz.flipper("F", (0, 0), 2.0, (0.2, 0.1), -0.4, 0.7, gz.newton(0.0), up=2.0, down=1.0)
    more = [gz.drain("out", (-9, -9), (9, -9)), gz.segment("roof", (-3, 4), (5, 4), gz.newton(1.0))]
    P = gz.collision_map(gz.table([one, *more], 0.1, tilt=UP, player=gz.flips(4.0, 1.2)))
    orbit = P.orbit((19.25, 0.1, 0.3, 1.4), 3)
    assert orbit.outcomes[1] == CHATTER | STUCK
    assert all(np.isfinite(P.jacobian(one)).all() for one in orbit.points[:2])


def test_samples_of_a_slide_on_a_flipper_that_a_strategy_moves_are_on_that():
    one = gz.flipper("F", (0, 0), 2.0, (0.2, 0.1), -0.4, 0.7, gz.newton(0.0), up=2.0, down=0.5)
    player = gz.strategy(lambda _state, _p: True, {"F": ((-3.0, 0.8), (3.0, 0.8))}, 0.8)
    found = gz.trajectory(gz.table([one], 0.1, tilt=UP, player=player), (0.8, 1.0, 0.0, 0.0), until=2.0, samples=400)
    played = gz.table([one], 0.1, tilt=UP, player=gz.presses(**found.attrs["presses"]))
    again = gz.trajectory(played, (0.8, 1.0, 0.0, 0.0), until=2.0, samples=400)
    assert np.isclose(found.x[-1], again.x[-1]) and "F" in found.attrs["presses"]
    t, x, y = found.t.values, found.x.values, found.y.values
    rooms = [played.distances(*place)["F"] for place in zip(x, y, t, strict=True)]
    assert min(rooms) > 0.1 - 1e-9 and np.sum(np.isclose(rooms, 0.1, atol=1e-12)) > 20


@pytest.mark.parametrize(("long", "late"), [(1.0, 1.0), (2.0**20, 2.0**-10)])
def test_off_the_end_of_a_side_it_leaves_in_any_units(long, late):
    """The rate of the tip's gap, a difference of squares, was held to a speed: in large units it grazed."""
    speeds = {"up": 0.6382906053776889 / late, "down": 0.7448040755536407 / late}
    one = gz.flipper("F", (0, 0), 2.0 * long, (0.2 * long, 0.1 * long), -0.4, 0.7, gz.newton(0.0), **speeds)
    table = gz.table([one], 0.1 * long, long / late**2, UP, gz.flips(4.0 * late, 1.2 * late))
    place, velocity = (1.8199122672540307, 0.8763100704078841), (0.44556452728890644, 1.4721282770486668)
    state = (*(long * x for x in place), *(long / late * v for v in velocity))
    found = first_contact(*state, OFF, 1.1745363630080368 * late, table.blocks(table.row(), "python")[0])
    assert found[2] == 0
