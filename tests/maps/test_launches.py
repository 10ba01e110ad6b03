"""Launches on tables, against parabolas in closed form and trajectories."""

import pickle
from itertools import pairwise
from math import pi

import numpy as np
import pytest

import grazing as gz
from grazing.outcome import ESCAPED, TOO_MANY_IMPACTS
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
    found = gz.periodic_orbits(L, 1)
    assert {str(one.word) for one in found} <= {"(left_drain)", "(right_drain)", "(away)"}
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
