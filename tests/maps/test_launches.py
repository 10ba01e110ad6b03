"""Launches on tables, against parabolas in closed form and trajectories."""

import pickle
from itertools import pairwise
from math import pi

import numpy as np
import pytest

import grazing as gz
from grazing.maps import launches
from grazing.outcome import ESCAPED, TOO_MANY_IMPACTS
from grazing.pool import run_tasks
from tests.billiard.tables import ELASTIC, box
from tests.maps.test_collisions import pinball

POINT = 3.0, 8.0


def test_launches_over_level_ground_land_where_parabolas_do():
    """Without anything in the way a ball crosses y = 0 at x = v^2 sin(2 angle)/g."""
    edges = np.linspace(0.0, 4.0, 9)
    drains = [gz.drain(f"d{i}", (a, 0.0), (b, 0.0)) for i, (a, b) in enumerate(pairwise(edges))]
    table = gz.table(drains, tilt=pi / 2)
    angle, speed = np.linspace(0.1, 1.5, 12), np.linspace(0.5, 2.2, 9)
    found = gz.launches(table, (0.0, 1e-9), angle, speed)
    reach = speed**2 * np.sin(2.0 * angle[:, None])
    names = np.array([f"d{i}" for i in range(8)])[np.minimum(reach / 0.5, 7).astype(int)]
    expected = np.where(reach < 4.0, names, "away")
    assert found.exit.values.tolist() == expected.tolist() and not found.hits.values.any()
    landed = found.exit.values != "away"
    np.testing.assert_allclose(found.time.values[landed], (2 * speed * np.sin(angle[:, None]))[landed], rtol=1e-6)
    assert np.isinf(found.time.values[~landed]).all() and (found.outcome.values == ESCAPED).all()


def test_they_are_those_of_trajectories_and_of_the_map():
    table = pinball()
    angle, speed = np.linspace(-3.0, 3.0, 9), np.array([0.4, 1.3])
    found, L = gz.launches(table, POINT, angle, speed), gz.launch_map(table, POINT)
    for i, a in enumerate(angle):
        for j, v in enumerate(speed):
            flown = gz.trajectory(table, (*POINT, v * np.cos(a), v * np.sin(a)), until=500.0, samples=2)
            assert flown.exit.item() == found.exit.values[i, j] and flown.sizes["impact"] == found.hits.values[i, j]
            assert flown.t.values[-1] == pytest.approx(float(found.time[i, j]), rel=1e-12)
            state, letter = L((a, v))
            assert L.letters.names[letter] == flown.exit.item() and state.tolist() == [float(letter), 0.0]
            assert L(state)[1] == letter


def test_launches_are_the_same_on_any_number_of_threads(monkeypatch):
    angle, speed = np.linspace(-3.0, 3.0, 50), np.linspace(0.2, 2.0, 41)
    one = gz.launches(pinball(), POINT, angle, speed, threads=1)
    tasks = []
    monkeypatch.setattr(launches, "TOGETHER", 300)
    monkeypatch.setattr(launches, "run_tasks", lambda made, threads: (tasks.extend(made), run_tasks(made, threads)))
    assert one.identical(gz.launches(pinball(), POINT, angle, speed, threads=3))
    assert len(tasks) == 7
    with pytest.raises(gz.InputError, match="threads = 0"):
        gz.launches(pinball(), POINT, angle, speed, threads=0)


def with_plunger():
    table = pinball()
    return gz.table(table.objects, table.rho, table.g, table.tilt, plunger=gz.plunger(POINT, 1.2, 0.5, 2.0))


def test_a_plunger_says_where_balls_are_launched():
    table, angle, speed = with_plunger(), [0.4, 1.2], [0.7, 1.9]
    found, there = gz.launches(table, None, angle, speed), gz.launches(pinball(), POINT, angle, speed)
    assert found.exit.equals(there.exit) and found.time.equals(there.time)
    usual = gz.launches(table)
    assert usual.angle.values.tolist() == [1.2] and usual.speed.values[[0, -1]].tolist() == [0.5, 2.0]
    L = gz.launch_map(table)
    assert L.box == ((1.2 - 0.5 * pi, 1.2 + 0.5 * pi), (0.5, 2.0)) and "launch.x" not in L.params
    assert L((0.4, 0.7))[1] == gz.launch_map(pinball(), POINT)((0.4, 0.7))[1]
    grid = {"angle": np.linspace(0.0, 3.0, 9), "speed": np.array([1.0])}
    moved = L.replace(**{"plunger.x": 2.0, "plunger.y": 7.5})
    exits = gz.launches(pinball(), (2.0, 7.5), grid["angle"], grid["speed"]).exit.values
    seen = gz.basins(moved, grid, transient=1, keep=4)
    assert [f"({name})" for name in exits.ravel()] == seen.word.values[seen.basin.values].ravel().tolist()
    assert pickle.loads(pickle.dumps(table)) == table != pinball()
    assert table.replace(**{"plunger.fast": 3.0}).plunger.fast == 3.0


def test_a_plunger_that_is_none_is_refused():
    for wrong, said in (
        (lambda: gz.plunger(3.0, 1.0, 0.0, 1.0), r"point of 'a plunger' is 3\.0; give a point"),
        (lambda: gz.plunger((0, 0), 1.0, 2.0, 1.0), "from 2 to 1; allowed is slow < fast"),
        (lambda: gz.plunger((0, 0), 1.0, -2.0, 1.0), "plunger.slow = -2; allowed is"),
        (lambda: gz.table(pinball().objects, plunger=3), "plunger is 3; give gz.plunger"),
        (lambda: gz.table(pinball().objects, 0.1, plunger=gz.plunger((2.0, 6.1), 0, 0, 1)), "overlaps P"),
        (lambda: gz.table([gz.disc("plunger", (0, 0), 1.0, ELASTIC)], plunger=gz.plunger((4, 0), 0, 0, 1)),
         "plunger.x is a parameter of the plunger; rename the object"),
        (lambda: gz.launch_map(pinball()), "has no plunger; give the point"),
        (lambda: gz.launches(pinball(), POINT), "has no plunger; give the angles"),
    ):  # fmt: skip
        with pytest.raises(gz.InputError, match=said):
            wrong()


def test_ways_out_have_basins_over_launches():
    L = gz.launch_map(pinball(), POINT)
    grid = {"angle": np.linspace(-3.0, 3.0, 24), "speed": np.linspace(0.2, 2.0, 16)}
    found = gz.basins(L, grid, transient=1, keep=4)
    exits = gz.launches(pinball(), POINT, grid["angle"], grid["speed"]).exit.values
    words = found.word.values[found.basin.values]
    assert words.tolist() == [[f"({name})" for name in row] for row in exits.tolist()]
    assert {*exits.ravel()} == {"left_drain", "right_drain"}


def test_only_ways_out_are_at_rest():
    """A launch of no speed is that of a ball let go, unless its angle is the number of a way out."""
    table = pinball()
    L = gz.launch_map(table, POINT)
    assert not gz.periodic_orbits(L, 1)  # a ball that has left is no orbit, though it stays
    dropped = gz.launches(table, POINT, 0.0, 0.0).exit.item()
    for angle in (-1.0, 0.0, 0.5, float(len(table.names)) + 1.0):
        assert L.letters.symbol(L((angle, 0.0))[1]) == f"({dropped})"
    for k, name in enumerate([*table.names, "away"]):
        rests = name in ("left_drain", "right_drain", "away")
        assert L.letters.symbol(L((float(k), 0.0))[1]) == f"({name if rests else dropped})"


def test_a_ball_that_never_leaves_is_given_up():
    table = gz.table(box(1.0, 1.0))
    found = gz.launches(table, (0.3, 0.4), 0.6, 1.0, hits=50)
    assert found.exit.values.tolist() == [[""]] and found.hits.values.tolist() == [[50]]
    assert found.outcome.values.tolist() == [[TOO_MANY_IMPACTS]]
    assert gz.launch_map(table, (0.3, 0.4), hits=50).orbit((0.6, 1.0), 1).outcomes[0] == TOO_MANY_IMPACTS


def test_a_launch_that_doubles_cannot_decide_is_decided_exactly():
    """Past a disc that the ball touches: exact arithmetic says that it does not hit."""
    table = gz.table([gz.disc("A", (0, 0), 1.0, ELASTIC), gz.drain("out", (9, -5), (9, 5))])
    assert gz.launches(table, (-3.0, 1.0), 0.0, 1.0).exit.values.tolist() == [["out"]]
    found = gz.launch_map(table, (-3.0, 1.0)).orbit((0.0, 1.0), 1)
    assert gz.Outcome(int(found.outcomes[0])) == gz.Outcome.escaped | gz.Outcome.graze and found.letters[0] == 1


def test_the_map_is_plain_python_too_and_goes_through_a_pickle():
    L = gz.launch_map(pinball(), POINT)
    new, letter, outcome = L.step((0.3, 1.0), L.prepare(tuple(L.params.values())))
    again = L.orbit((0.3, 1.0), 1)
    assert (list(new), letter, outcome) == (again.points[1].tolist(), again.letters[0], again.outcomes[0])
    assert pickle.loads(pickle.dumps(L)) == L
    moved = L.replace(**{"launch.x": 2.9, "P.V": 0.1})
    assert moved.params["launch.x"] == 2.9 and moved.origin.table.params["P.V"] == 0.1
    assert L.describe("launch.hits").low == 1.0 and L.describe("P.V").low == 0.0


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: gz.launch_map(gz.pinball(), (0.0, 0.0)), "give gz.table"),
        (lambda: gz.launch_map(pinball(), (2.0, 6.1)), "overlaps P"),
        (lambda: gz.launch_map(pinball(), (2.0, float("nan"))), "y of the launch = nan"),
        (lambda: gz.launch_map(pinball(), POINT, hits=0), "hits = 0"),
        (lambda: gz.launch_map(gz.table([gz.disc("launch", (0, 0), 1.0, ELASTIC)]), (3.0, 0.0)), "called 'launch'"),
        (lambda: gz.launches(pinball(), 3.0, 0.0, 1.0), r"point is 3.0; give \(x, y\)"),
        (lambda: gz.launches(pinball(), POINT, "up", 1.0), "angle is 'up'; give finite numbers in one list"),
        (lambda: gz.launches(pinball(), POINT, 0.0, -1.0), "speed is -1.0; give finite numbers >= 0"),
    ],
)
def test_wrong_input_is_refused(make, said):
    with pytest.raises(gz.InputError, match=said):
        make()


@pytest.mark.parametrize("discs", [0, 1, 5, 30])
def test_the_workspace_of_launches_begins_where_a_line_of_the_cache_does(discs, monkeypatch):
    """Vectors of eight numbers that lie across two lines are read and written in two goes."""
    seen, asked = [], launches.call
    monkeypatch.setattr(launches, "call", lambda kernel, *given: [seen.append(given[1]), asked(kernel, *given)])
    things = [gz.disc(f"D{i}", (3.0 * i, 0.0), 1.0, ELASTIC) for i in range(discs)]
    gz.launches(gz.table([*things, gz.drain("out", (-9.0, -5.0), (99.0, -5.0))], tilt=0.5), (-3.0, 0.0), 0.5, 1.0)
    assert [w.ctypes.data % 64 for w in seen] == [0]
