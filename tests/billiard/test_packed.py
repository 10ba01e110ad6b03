"""Balls side by side: the bits of balls one by one, whichever share a block, and faces that are surely passed."""

from dataclasses import replace
from math import cos, pi, sin

import numpy as np
import pytest

import grazing as gz
from grazing.billiard.faces import passes
from grazing.billiard.gaps import first_step
from grazing.billiard.packed import contacts, flights, impacts, near, of_all_circles, pass_face, widest
from grazing.billiard.rows import CIRCLES, EX, EY, LONG, PX, PY, SIZE, WIDTH
from grazing.billiard.workspace import LANES, I, W, room_for
from grazing.kernel.compile import call, compiled
from grazing.kernel.lanes import column
from grazing.kernel.primitives import numbers
from grazing.maps.collide import STEADY, TIMED, Place
from grazing.maps.launch import ROUNDS, Found, fly, heading, launch, launcher
from tests.billiard.tables import box, layout, mixed, three_discs


def one_by_one(block, x, y, most, angles, speeds, ways, hits, times, outcomes):
    table = numbers(block)
    for i in range(len(angles)):
        s, c = heading(angles[i])
        ways[i], hits[i], times[i], outcomes[i] = launch(x, y, speeds[i] * c, speeds[i] * s, most, table)


def room(n):
    return np.zeros(n, np.int64), np.zeros(n, np.int64), np.zeros(n), np.zeros(n, np.int64)


def classic():
    table = gz.read_table("classic")
    player = gz.flips(0.5, 0.15, {"left_flipper": 0.0, "right_flipper": 0.25})
    return gz.table(table.objects, table.rho, table.g, table.tilt, player)


#: Tables, with a launch and how fast: discs, arcs, segments with free ends, drains, flippers, a ball without a radius,
#: one without gravity.
TABLES = {
    "box": (gz.table([*layout(8), *box()], tilt=pi / 2), (0.2, 9.8), (0.5, 2.0)),
    "mixed": (mixed(0.1), (3.0, 4.5), (1.0, 4.0)),
    "without a radius": (mixed(0.0), (3.0, 4.5), (1.0, 4.0)),
    "classic": (classic(), (5.275, 0.7), (14.0, 19.0)),
    "galton": (gz.read_table("galton"), (0.05, 9.0), (0.1, 1.0)),
    "level": (three_discs(6.0), (2.9, 1.6), (0.5, 2.0)),
}


@pytest.mark.parametrize("name", TABLES)
def test_launches_side_by_side_have_the_bits_of_launches_one_by_one(name):
    table, (x, y), speeds = TABLES[name]
    block, n, most = table.blocks(table.row())[0], 3 * LANES + 5, 200
    random = np.random.default_rng(0)
    angles, fast = random.uniform(0.0, 2.0 * pi, n), random.uniform(*speeds, n)
    alone, beside = room(n), room(n)
    call(compiled(one_by_one), block, x, y, most, angles, fast, *alone)
    w, job, calls = np.zeros(room_for(int(block[CIRCLES]))), np.array([0, 0]), 0
    while job[0] < n or job[1] > 0:
        call(launcher(), block, w, job, 50, x, y, most, angles, fast, *beside)  # a few rounds at a time
        calls += 1
    assert calls > 1 or alone[1].max() < 50
    for one, other in zip(alone, beside, strict=True):
        np.testing.assert_array_equal(one, other)
    assert len(np.unique(alone[1])) > 3 or len(np.unique(alone[2])) == n  # they differ


@pytest.mark.parametrize("n", [2, LANES + 9])
@pytest.mark.parametrize("name", TABLES)
def test_steps_from_impact_to_impact_have_the_bits_of_orbits_one_by_one(name, n):
    """Until all have left, where they can; states that are on no object and those that have left among them."""
    table, steps, random = TABLES[name][0], 40, np.random.default_rng(1)
    P = gz.collision_map(table, on="bumper3" if name == "classic" else None)
    lanes = np.array([random.uniform(low, high, n) for low, high in P.box])
    lanes[0, : n // 3] += np.linspace(0.0, 60.0, n // 3)
    block, step = table.blocks(table.row())[0], (TIMED if table.period else STEADY).step

    def one_by_one(block, lanes, points, letters, outcomes):
        for j in range(lanes.shape[1]):
            state = column(lanes, j, zero)
            for i in range(points.shape[0]):
                state, letters[i, j], outcome = step(state, Place(block))
                outcomes[0, j] |= outcome
                for k in range(len(zero)):
                    points[i, k, j] = state[k]

    zero = (0.0,) * P.dimension
    alone = np.empty((steps, *lanes.shape)), np.empty((steps, n), np.int64), np.zeros((1, n), np.int64)
    call(compiled(one_by_one), 1.0 * block.ctypes.data, lanes, *alone)
    bare = replace(P, origin=P.origin.unsettled())
    for one, other in zip(alone, bare.run(lanes.copy(), 0, steps, records=1), strict=True):
        np.testing.assert_array_equal(one, other)


def test_plain_python_has_the_bits_of_the_compiled_kernel():
    table, (x, y), speeds = TABLES["box"]
    block, n = table.blocks(table.row(), "python")[0], 9
    angles, fast = np.linspace(0.1, 6.0, n), np.linspace(*speeds, n)
    plain, compiled_ones, job = room(n), room(n), np.array([0, 0])
    fly(np.zeros(room_for(int(block[CIRCLES]))), job, 20, x, y, 8, angles, fast, block, Found(*plain))
    block, job = table.blocks(table.row())[0], np.array([0, 0])
    w = np.zeros(room_for(int(block[CIRCLES])))
    call(launcher(), block, w, job, ROUNDS, x, y, 8, angles, fast, *compiled_ones)
    for one, other in zip(plain, compiled_ones, strict=True):
        np.testing.assert_array_equal(one, other)


def test_few_balls_are_in_doubt_but_those_that_graze():
    """All but those that touch a disc within rounding are decided side by side."""
    table = gz.table([gz.disc("A", (5.0, 5.0), 1.0, gz.newton(1.0)), *box(20.0, 20.0)])
    block = table.blocks(table.row())[0]

    def look(block, w, width):  # given: a constant is a type of its own, for which all would be compiled again
        contacts(numbers(w), width, numbers(block))

    w = np.zeros(room_for(int(block[CIRCLES])))
    height = np.concatenate([1.0 + np.geomspace(1e-12, 1.0, 31), [1.0], 1.0 - np.geomspace(1e-12, 0.9, 32)])
    w[W.X : W.X + LANES], w[W.Y : W.Y + LANES] = 15.0, 5.0 + height
    w[W.VX : W.VX + LANES], w[W.LEFT : W.LEFT + LANES] = -1.0, -1.0
    call(compiled(look), block, w, LANES)
    doubt, surface = w[W.DOUBT : W.DOUBT + LANES], w[W.SURFACE : W.SURFACE + LANES]
    assert doubt[31] == 1.0 and doubt.sum() == 1.0
    assert len(set(surface[:31])) == len(set(surface[32:])) == 1 and surface[0] != surface[-1]


def test_impacts_are_taken_side_by_side_but_those_that_may_be_none():
    """On discs, walls and arcs; not one so slow that it may settle, a drain, nor of a ball that meets nothing."""
    law = gz.newton(1.0)
    things = [gz.disc("A", (5.0, 5.0), 1.0, law), gz.arc("B", (15.0, 5.0), 1.0, 0.5, 5.5, law), *box(20.0, 20.0)[1:]]
    table = gz.table([*things, gz.drain("out", (0.0, 0.0), (20.0, 0.0))], rho=0.1, tilt=0.5 * pi)
    block = table.blocks(table.row())[0]

    def strike(block, w, n, width):
        contacts(numbers(w), width, numbers(block))
        impacts(numbers(w), n, numbers(block))

    w, n = np.zeros(room_for(int(block[CIRCLES]))), 7
    w[W.LEFT : W.LEFT + 8] = -1.0
    starts = [(5.0, 8.0, 0.1, -1.0), (15.0, 8.0, 0.1, -1.0), (15.0, 5.0, -5.0, 0.1), (1.0, 9.0, -9.0, 0.0)]
    starts += [(10.0, 1.0, 0.0, 0.0), (5.0, 6.1 + 1e-11, 0.0, 0.0), (10.0, 10.0, np.nan, 0.0)]
    w[: 4 * LANES].reshape(4, LANES)[:, :n] = np.transpose(starts)
    call(compiled(strike), block, w, n, 8)
    assert w[I.PLAIN : I.PLAIN + n].tolist() == [1.0] * 4 + [0.0] * 3
    assert w[I.PLAIN + n] == 0.0
    call(compiled(strike), block, w, 3, 8)  # so few are not looked at
    assert not w[I.PLAIN : I.PLAIN + 8].any()


def test_a_circle_that_is_left_out_has_no_step_before_what_was_found():
    random, clear = np.random.default_rng(5), 0
    w = np.zeros(room_for(1))
    for _ in range(300):
        scale, g = 10.0 ** random.uniform(-6, 6), float(random.choice([0.0, 1.0]))
        circle = np.zeros((1, 12))
        circle[0, :3] = *(random.normal(size=2) * random.choice([1.0, 1e5])), random.choice([0.01, 1.0, 5.0])
        place = circle[0, :2] + random.normal(size=(8, 2)) * random.choice([0.1, 2.0, 30.0])
        for row, values in zip((W.X, W.Y, W.VX, W.VY), (*place.T, *(random.normal(size=(2, 8)) * scale)), strict=True):
            w[row : row + 8] = values
        w[W.TIME : W.TIME + 8], w[W.LAST : W.LAST + 8] = random.choice([0.1, 1.0, 10.0, np.inf]) / scale, -1.0
        of_all_circles(w, 8, 0, 1, circle.ravel(), g)
        near(w, 8, *circle[0, :3], 0.0, g)
        for i in np.flatnonzero(w[W.ONE : W.ONE + 8] == 0.0):
            dx, dy = place[i] - circle[0, :2]
            step, said = first_step(dx, dy, w[W.VX + i], w[W.VY + i], g, circle[0, 2], False, w[W.PART + i])
            assert said == 0 and step >= w[W.END + i]
            clear += 1
    assert 500 < clear < 2000


def test_a_face_that_is_passed_is_not_met():
    """Against places along the flight: the ball stays farther from the face than it is wide."""
    random, passed = np.random.default_rng(3), 0
    for _ in range(2000):
        dx, dy, vx, vy = random.normal(size=4)
        turn, size, long, g = (
            random.uniform(0, 2 * pi),
            random.choice([0.0, 0.2]),
            random.uniform(0.1, 2),
            random.choice([0, 1.0]),
        )
        ex, ey, end = cos(turn), sin(turn), random.choice([0.1, 1.0, 3.0])
        if not passes((dx, dy), (vx, vy), (ex, ey, size, long), g, 0.0, 1.0, -1.0, end, 0.0):
            continue
        t = np.linspace(0.0, end, 400)
        x, y = dx + vx * t, dy + (vy - 0.5 * g * t) * t
        foot, off = ex * x + ey * y, ey * x - ex * y
        between = (foot >= 0.0) & (foot <= long)
        assert not (between & (abs(off) <= size)).any()
        turns = np.flatnonzero(np.diff(np.sign(off)) != 0)
        assert not between[turns].any() or not between[turns + 1].any()
        passed += 1
    assert 500 < passed < 2000


@pytest.mark.parametrize("g", [0.0, 1.0])
def test_a_circle_that_was_just_left_is_left_out_where_the_ball_goes_away_from_it(g):
    random, clear = np.random.default_rng(7), 0
    w = np.zeros(room_for(1))
    for _ in range(100):
        turn, way = random.uniform(0.0, 2.0 * pi, 8), random.uniform(-0.5 * pi, 0.5 * pi, 8)
        centre, speed = random.normal(size=2), 10.0 ** random.uniform(-2, 2)
        circle = np.zeros((1, WIDTH))
        circle[0, [PX, PY, SIZE]] = *centre, 0.5
        w[W.X : W.X + 8], w[W.Y : W.Y + 8] = centre[0] + 0.5 * np.cos(turn), centre[1] + 0.5 * np.sin(turn)
        w[W.VX : W.VX + 8], w[W.VY : W.VY + 8] = speed * np.cos(turn + way), speed * np.sin(turn + way)
        w[W.TIME : W.TIME + 8], w[W.LAST : W.LAST + 8] = 1.0, 0.0
        of_all_circles(w, 8, 0, 1, circle.ravel(), g)
        near(w, 8, *centre, 0.5, 0.0, g)
        for i in np.flatnonzero(w[W.ONE : W.ONE + 8] == 0.0):
            dx, dy = w[W.X + i] - centre[0], w[W.Y + i] - centre[1]
            step, said = first_step(dx, dy, w[W.VX + i], w[W.VY + i], g, 0.5, True, w[W.PART + i])
            assert said == 0 and step == np.inf
            clear += 1
    assert clear == 800 if g == 0.0 else 100 < clear < 800


def test_faces_passed_side_by_side_are_passed_one_by_one():
    random, passed, row = np.random.default_rng(11), 0, np.zeros(WIDTH)
    w = np.zeros(room_for(0))
    for _ in range(400):
        turn, scale = random.uniform(0.0, 2.0 * pi), 10.0 ** random.uniform(-3, 3)
        row[[PX, PY]], row[EX], row[EY] = random.normal(size=2) * random.choice([0.0, 1e4]), cos(turn), sin(turn)
        row[SIZE], row[LONG] = random.choice([0.0, 0.2]), random.uniform(0.1, 2.0)
        g, end, last = float(random.choice([0.0, 1.0])), random.choice([0.1, 1.0, np.inf]), random.integers(-1, 4, 8)
        for first, values in zip((W.X, W.Y, W.VX, W.VY), random.normal(size=(4, 8)), strict=True):
            w[first : first + 8] = values
        w[W.X : W.X + 8], w[W.Y : W.Y + 8] = w[W.X : W.X + 8] + row[PX], w[W.Y : W.Y + 8] + row[PY]
        w[W.VX : W.VX + 8], w[W.VY : W.VY + 8] = w[W.VX : W.VX + 8] * scale, w[W.VY : W.VY + 8] * scale
        w[W.TIME : W.TIME + 8], w[W.LAST : W.LAST + 8], w[W.SURFACE : W.SURFACE + 8] = end / scale, last, -1.0
        flights(w, 8, widest(1, row), g)
        some = pass_face(w, 8, 0, row)
        assert some == w[W.ONE : W.ONE + 8].any()
        face = row[EX], row[EY], row[SIZE], row[LONG]
        for i in np.flatnonzero(w[W.ONE : W.ONE + 8] == 0.0):
            x, y, v = w[W.X + i], w[W.Y + i], (w[W.VX + i], w[W.VY + i])
            along, far = (x - row[PX], y - row[PY]), abs(x) + abs(y)
            assert passes(along, v, face, g, 0.0, 1.0, w[W.LAST + i], w[W.TIME + i], far)
            passed += 1
        w[W.SURFACE : W.SURFACE + 8] = [0.0, 1.0] * 4
        flights(w, 8, widest(1, row), g)
        assert not pass_face(w, 8, 0, row)  # it is that which was found
    assert 800 < passed < 2400
