"""Who works the flippers: motions, names, ranges."""

import copy
import pickle

import numpy as np
import pytest

import grazing as gz
from grazing.billiard.players import angle_at
from tests.billiard.flippers import pair
from tests.billiard.tables import ELASTIC

SHAPE = {"rest": -0.5, "raised": 0.5, "up": 10.0, "down": 5.0}


@pytest.mark.parametrize("player", [gz.flips(2.0, 0.3, {"L": 0.1, "R": 0.4}), gz.presses(L=[0.1, 0.3, 4.0]), None])
def test_tables_with_flippers_are_frozen_values(player):
    table = pair(player)
    assert pickle.loads(pickle.dumps(table)) == table == copy.deepcopy(table)
    assert table.at(table.params) == table
    for name in table.params:
        assert table.describe(name).name == name
    assert (table == pair()) == (player is None)


def test_the_numbers_of_a_player_are_parameters_of_the_table():
    table = pair(gz.flips(2.0, 0.3, {"L": 0.1, "R": 0.4}))
    own = {
        name: value for name, value in table.params.items() if name.split(".")[1:] in (["period"], ["hold"], ["phase"])
    }
    assert own == {"flips.period": 2.0, "L.hold": 0.3, "L.phase": 0.1, "R.hold": 0.3, "R.phase": 0.4}
    other = table.replace(**{"R.phase": 0.0, "flips.period": 3.0, "R.up": 5.0})
    assert other.player.phase["R"] == 0.0 and other.player.period == 3.0
    assert other.angles(0.1)["R"] == pytest.approx(other.params["R.rest"] - 0.5)


def test_a_flipper_turns_until_its_stop_and_back():
    """Up in 0.1, down in 0.2; pressed for 0.05 it comes half of the way."""
    player = gz.flips(1.0, {"A": 0.3, "B": 0.05}, 0.9).bound(["A", "B"])
    found = {name: player.motion(name, SHAPE, player.params) for name in "AB"}

    for t, known in ((0.0, 0.5), (0.15, 0.5), (0.3, 0.0), (0.4, -0.5), (0.9, -0.5), (0.95, 0.0), (17.95, 0.0)):
        assert angle_at(t, *found["A"]) == pytest.approx(known, abs=1e-12)
    for t, known in ((0.9, -0.5), (0.93, -0.2), (0.95, 0.0), (1.0, -0.25), (0.05, -0.5), (-0.05, 0.0)):
        assert angle_at(t, *found["B"]) == pytest.approx(known, abs=1e-12)


def test_a_recording_may_turn_it_round_on_its_way():
    motion = gz.presses(A=[1.0, 1.05, 1.07, 3.0]).motion("A", SHAPE, {})

    for t, known in (
        (-9.0, -0.5),
        (1.0, -0.5),
        (1.05, 0.0),
        (1.07, -0.1),
        (1.12, 0.4),
        (2.0, 0.5),
        (3.1, 0.0),
        (9.0, -0.5),
    ):
        assert angle_at(t, *motion) == pytest.approx(known, abs=1e-12)


def test_motions_do_not_jump():
    random = np.random.default_rng(0)
    for _ in range(200):
        period = random.uniform(0.5, 3.0)
        player = gz.flips(period, random.uniform(0.0, 0.2), random.uniform(-5.0, 5.0)).bound(["A"])
        T, pieces = player.motion("A", SHAPE, player.params)
        assert T == period and pieces[0].begin <= 0.0 and all(0.0 < one.begin < T for one in pieces[1:])
        for one, other in zip(pieces, [*pieces[1:], pieces[0]._replace(begin=T)], strict=True):
            end = one.angle + one.omega * (other.begin - one.begin)
            shift = other.omega * (other.begin - (pieces[0].begin + T if other.begin == T else other.begin))
            assert end == pytest.approx(other.angle + shift, abs=1e-12)


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: gz.flips(0.0, 0.1), r"flips\.period = 0; allowed is flips\.period > 0"),
        (lambda: gz.flips(1.0, -0.1), r"hold = -0\.1; allowed is hold >= 0"),
        (lambda: gz.flips(1.0, {"L": -0.1}), r"L\.hold = -0\.1"),
        (
            lambda: pair(gz.flips(1.0, 0.95)),
            "the flipper L needs 1.07222 to go up and come back to rest, the period is 1",
        ),
        (lambda: pair(gz.flips(1.0, {"L": 0.1})), "hold has nothing for the flipper 'R'"),
        (
            lambda: pair(gz.flips(1.0, 0.1, {"L": 0.1, "R": 0, "M": 0})),
            "phase names 'M', which is no flipper of the table",
        ),
        (lambda: pair(gz.presses(M=[1.0])), "presses names 'M', which is no flipper"),
        (lambda: gz.presses(L=[1.0, 1.0]), "the times of L are"),
        (lambda: gz.presses(L=[1.0, float("nan")]), "a time of L = nan is not finite"),
        (lambda: gz.presses(L=3), "a time of L = None is not a real number"),
        (lambda: pair(0.9), r"player is 0\.9; give gz\.flips"),
    ],
)
def test_wrong_players_are_refused(make, said):
    with pytest.raises(gz.InputError, match=said):
        make()


def flipper(**changes):
    given = {
        "pivot": (0, 0),
        "length": 2.0,
        "radius": 0.2,
        "rest": 0.0,
        "raised": 1.0,
        "law": ELASTIC,
        "up": 4,
        "down": 1,
    }
    return gz.flipper("A", **(given | changes))


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: flipper(radius=0.0), r"A\.hub = 0; allowed is A\.hub > 0"),
        (lambda: flipper(radius=(0.2, 2.3)), "the radii of A, 0.2 and 2.3, differ by its length 2 or more"),
        (lambda: flipper(raised=3.5), "A turns from 0 to 3.5; allowed is half a turn, in radians"),
        (lambda: flipper(up=0.0), r"A\.up = 0; allowed is A\.up > 0"),
        (lambda: flipper(law=None), "law of A is None"),
        (lambda: flipper(law=gz.reset(lambda v, p: -p.up * v, up=0.5)), "parameter 'up', as its shape has"),
        (lambda: gz.table([flipper(), gz.disc("B", (1.5, 1.5), 0.3, ELASTIC)]), "B is in the way of A, by"),
        (lambda: gz.table([flipper(), gz.segment("B", (0.5, 1.5), (0.9, 0.7), ELASTIC)]), "B is in the way of A, by"),
        (
            lambda: gz.table([flipper(), gz.segment("B", (-0.1, 0.3), (-0.1, -0.3), ELASTIC)]),
            "B is in the way of A, by",
        ),
        (lambda: gz.table([flipper(), gz.arc("B", (1.5, 1.5), 0.6, 3.0, 6.0, ELASTIC)]), "B is in the way of A, by"),
        (
            lambda: gz.table([flipper(law=gz.reset(lambda v, p: -p.hold * v, hold=0.5))], player=gz.flips(9.0, 0.1)),
            r"A\.hold is a parameter of the player",
        ),
        (lambda: gz.table([flipper(up=1e80)]), "the largest angular speed of the table is 1e\\+80"),
    ],
)
def test_wrong_flippers_are_refused(make, said):
    with pytest.raises(gz.InputError, match=said):
        make()


def test_what_a_flipper_may_touch():
    """A rail that ends at the hub, and a post that the tip just passes."""
    rail = gz.segment("rail", (-3.0, 1.0), (-0.2, 0.0), ELASTIC)
    gz.table([flipper(), rail, gz.disc("post", (2.5, 0.0), 0.3, ELASTIC)])
