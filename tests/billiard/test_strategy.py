"""Players who look at the ball: asked where it enters a zone, in flight and on a slide; what they press is played."""

import pickle

import numpy as np
import pytest

import grazing as gz
from grazing.outcome import TOO_MANY_IMPACTS

LAW, STROKE = gz.newton(0.8), {"up": 14.0, "down": 9.0}
LEFT = gz.flipper("L", (1.2, 1.0), 1.45, (0.2, 0.12), -0.5, 0.6, LAW, **STROKE)
RIGHT = gz.flipper("R", (4.8, 1.0), 1.45, (0.2, 0.12), np.pi + 0.5, np.pi - 0.6, LAW, **STROKE)
GATES = {"L": ((1.0, 1.7), (3.0, 1.7)), "R": ((3.0, 1.7), (5.0, 1.7))}
WALLS = [gz.segment("left", (0, 10), (0, 0), LAW), gz.segment("right", (6, 0), (6, 10), LAW),
         gz.arc("dome", (3, 10), 3.0, 0.0, np.pi, LAW), gz.disc("A", (2.6, 6.0), 0.5, gz.active(0.9, 0.4))]  # fmt: skip
OUT = gz.drain("out", (0, -1), (6, -1))


def table(flip, gates=GATES, objects=(LEFT, RIGHT, *WALLS, OUT), hold=0.25):
    return gz.table(objects, rho=0.1, tilt=0.5, player=gz.strategy(flip, gates, hold))


def played(times):
    return gz.table([LEFT, RIGHT, *WALLS, OUT], rho=0.1, tilt=0.5, player=gz.presses(**times))


def yes(_state, _p):
    return True


def no(_state, _p):
    return False


def test_who_never_presses_plays_as_nobody_does():
    start = (2.2, 8.0, 0.3, 0.0)
    seen, still = gz.trajectory(table(no), start, until=12.0), gz.trajectory(played({}), start, until=12.0)
    assert seen.impact_wall.values.tolist() == still.impact_wall.values.tolist()
    np.testing.assert_allclose(seen.impact_time, still.impact_time, rtol=0, atol=1e-9)
    assert seen.attrs["presses"] in ({"L": []}, {"R": []}, {"L": [], "R": []}) and seen.trust.item() == "certified"


def test_what_a_strategy_presses_is_the_recording_of_its_game():
    start = (2.2, 8.0, 0.3, 0.0)
    seen = gz.trajectory(table(yes), start, until=25.0)
    pressed = seen.attrs["presses"]
    assert any(pressed.values())
    for times in pressed.values():
        assert (np.diff(times) > 0.0).all() and np.allclose(np.diff(times)[::2], 0.25)
    early = 12.0  # before rounding has grown
    again = gz.trajectory(played(pressed), start, until=early)
    here = seen.impact_time.values < early
    assert again.impact_wall.values.tolist() == seen.impact_wall.values[here].tolist()
    np.testing.assert_allclose(again.impact_time, seen.impact_time[here], rtol=0, atol=1e-6)
    assert {"L", "R"} & {*seen.impact_wall.values}


def test_a_zone_is_entered_on_the_way_up_and_on_the_way_down():
    asked = []

    def flip(state, p):
        asked.append((state, p["rho"]))
        return False

    rim = (LEFT, gz.drain("out", (-9, -5), (9, -5)))
    T = gz.table(rim, rho=0.1, g=1.0, tilt=0.5 * np.pi, player=gz.strategy(flip, {"L": ((5, 4), (7, 4))}, 0.2))
    flown = gz.trajectory(T, (6.0, 3.5, 0.1, 2.0), until=60.0)
    root = np.sqrt(4.0 - 2.0 * 0.5)  # v^2 = v0^2 - 2 g h
    assert [rho for _state, rho in asked] == [0.1, 0.1] and flown.exit.item() == "out"
    for (x, y, vx, vy), t, up in zip((s for s, _ in asked), (2.0 - root, 2.0 + root), (root, -root), strict=True):
        np.testing.assert_allclose((x, y, vx, vy), (6.0 + 0.1 * t, 4.0, 0.1, up), rtol=0, atol=1e-12)


def test_a_ball_that_slides_into_a_zone_is_seen_once():
    asked, ends = [], ((0.0, 3.0), (4.0, 1.0))

    def flip(state, _p):
        asked.append(state)
        return True

    far = gz.flipper("L", (8.0, 3.0), 0.9, 0.1, -0.5, 0.6, LAW, **STROKE)
    things = [gz.segment("rail", *ends, gz.newton(0.0)), far, gz.drain("out", (-9, -5), (9, -5))]
    player = gz.strategy(flip, {"L": ((2.0, 0.5), (2.0, 5.0))}, 0.2)
    T = gz.table(things, rho=0.0, g=1.0, tilt=0.5 * np.pi, player=player)
    flown = gz.trajectory(T, (1.0, 2.6, 0.0, 0.0), until=60.0)
    ((x, y, vx, vy),) = asked
    assert (x, y) == pytest.approx((2.0, 2.0), abs=1e-9)
    along = np.array([2.0, -1.0]) / np.sqrt(5.0)
    fall = np.sqrt(2.0 * 0.1) / np.sqrt(5.0)  # what is left of the fall onto the rail
    speed = np.sqrt(fall**2 + 2.0 * 0.5)
    np.testing.assert_allclose((vx, vy), speed * along, rtol=0, atol=1e-9)
    assert len(flown.attrs["presses"]["L"]) == 2 and flown.exit.item() == "out"


def questions(things, gates, start, until=60.0, said=False):
    """Return what a strategy is asked about a ball of radius 0.1 under g = 1, and how that ends."""
    asked = []

    def flip(state, _p):
        asked.append(state)
        return said

    far = [
        gz.flipper(name, (90.0, y), 0.9, 0.1, -0.5, 0.6, LAW, **STROKE) for name, y in zip(gates, (3, 9), strict=False)
    ]
    T = gz.table([*things, *far], rho=0.1, tilt=0.5 * np.pi, player=gz.strategy(flip, gates, 0.2))
    flown = gz.trajectory(T, start, until=until, samples=2)
    assert flown.trust.item() == "certified"
    return asked, flown


@pytest.mark.parametrize("names", ["L", "LR"])
def test_a_ball_that_turns_round_on_a_slide_is_asked_at_each_way_through_each_gate(names):
    """A gate was shut until the end of a slide; two on one line asked for ever on a slide, one in a flight."""
    dead, (c, s) = gz.newton(0.0), np.array([2.0, 1.0]) / np.sqrt(5.0)
    at = np.array([1.0 - 0.1 * s, 0.5 + 0.1 * c])  # on a slope, one along it from a gate
    slope, gate = gz.segment("slope", (0, 0), (9, 4.5), dead), ((at[0] + c, -9.0), (at[0] + c, 9.0))
    asked, _ = questions([slope], dict.fromkeys(names, gate), (*at, 1.2 * c, 1.2 * s), until=6.0)
    v = np.sqrt(1.2**2 - 2.0 * s)
    each = [(at[0] + c, at[1] + s, way * v * c, way * v * s) for way in (1.0, -1.0) for _name in names]
    np.testing.assert_allclose(asked, each, rtol=0, atol=1e-12)

    bowl, level = [gz.arc("bowl", (0, 0), 1.1, np.pi, 2.0 * np.pi, dead)], ((-3.0, -0.6), (3.0, -0.6))
    asked, _ = questions(bowl, dict.fromkeys(names, level), (0.0, -1.0, 1.0, 0.0), until=9.0)
    assert [np.sign(x) for x, *_ in asked] == [way for way in (1, 1, -1, -1, 1, 1) for _name in names]

    ring, short = [gz.arc("ring", (0, 0), 1.1, 0.0, 2.0 * np.pi, dead)], ((0.5, 0.0), (1.5, 0.0))
    asked, _ = questions(ring, dict.fromkeys(names, short), (0.0, -1.0, 3.0, 0.0), until=7.0)  # once around in 2.42
    assert len(asked) == 3 * len(names)
    asked, _ = questions([], dict.fromkeys(names, level), (0.0, -1.0, 0.1, 2.0))
    assert len(asked) == 2 * len(names)


def test_a_gate_holds_nothing():
    """A ball at rest on a slope where a gate or a drain is stayed there for ever; one that rises to a gate does not."""
    slope, at = (
        gz.segment("slope", (0, 0), (4, 2), gz.newton(0.0)),
        np.array([2.0, 1.0]) + 0.1 * np.array([-1, 2]) / 5**0.5,
    )
    gate = ((at[0], -9.0), (at[0], 9.0))
    asked, flown = questions([slope], {"L": gate}, (*at, 0.0, 0.0))
    assert asked == [(*at, 0.0, 0.0)] and flown.outcome == "escaped"
    drained = gz.trajectory(
        gz.table([slope, gz.drain("out", *gate)], 0.1, tilt=0.5 * np.pi), (*at, 0.0, 0.0), until=1.0
    )
    assert drained.exit.item() == "out"
    for high, times in ((2.0 - 2.0**-52, 2), (2.0, 0)):  # by less than doubles tell
        asked, _ = questions([], {"L": ((-3.0, high), (3.0, high))}, (0.0, 0.0, 0.3, 2.0))
        assert len(asked) == times


def test_launches_are_those_of_trajectories():
    T, angle, speed = table(lambda s, p: s[2] > 0.0 and p["tilt"] == 0.5), [0.4, 1.1], [0.5, 1.5]
    found = gz.launches(T, (3.0, 8.5), angle, speed, hits=60)
    for i, a in enumerate(angle):
        for j, v in enumerate(speed):
            flown = gz.trajectory(T, (3.0, 8.5, v * np.cos(a), v * np.sin(a)), until=500.0, samples=2)
            assert found.exit.values[i, j] == flown.exit.item() or found.hits.values[i, j] == 60
            assert found.hits.values[i, j] == min(flown.sizes["impact"], 60)
    assert table(yes) == table(yes) != table(no) and pickle.loads(pickle.dumps(table(yes))) == table(yes)
    player = gz.strategy(lambda s, p: s[3] < 0.0, {"L": ((0.0, 0.0), (1.0, 0.0))}, hold=0.1)
    again = pickle.loads(pickle.dumps(player))
    assert again == player and hash(again) == hash(player)
    assert table(yes).config["strategy"] != table(no).config["strategy"]


def test_launches_that_a_kernel_follows_are_those_that_only_python_does_and_hits_are_impacts():
    """Ways to gates and along walls were counted as hits, and a launch was given up before it had as many."""
    angle, speed = np.linspace(0.3, 2.8, 25)[[0, 2, 6, 7]], np.linspace(0.2, 3.0, 20)[[1, 7, 8]]
    flips = lambda s, _p: s[0] > 2.0 and s[3] < 0.0, lambda s, p: s[0] > 2.0 and s[3] < 0.0 < p["L.x"]
    followed = gz.launches(table(flips[0]), (2.0, 4.0), angle, speed, hits=60)
    alone = gz.launches(table(flips[1]), (2.0, 4.0), angle, speed, hits=200)
    given_up = (followed.outcome.values & TOO_MANY_IMPACTS) != 0
    assert 0 < given_up.sum() < given_up.size and (followed.hits.values[given_up] == 60).all()
    assert (alone.hits.values[given_up] >= 60).all()
    for name in ("exit", "hits", "time"):
        assert (followed[name].values == alone[name].values)[~given_up].all()


def broken(_state, _p):
    raise ZeroDivisionError("by zero")


def picky(state, _p):
    if state[3] < 0.0:
        raise ValueError("it falls")
    return True


def orbits_of(flip):
    """Iterate the map of launches of a table with this strategy, as studies do."""
    grid = {"angle": [1.4, 1.6], "speed": [0.5, 0.6]}
    return gz.basins(gz.launch_map(table(flip), (2.0, 4.0)), grid, transient=1, keep=2)


@pytest.mark.parametrize(
    ("made", "said"),
    [
        (lambda: gz.strategy(3, GATES, 0.2), "flip is 3; give a function"),
        (lambda: gz.strategy(yes, {}, 0.2), "gates is {}; give a line"),
        (lambda: gz.strategy(yes, {"L": 3}, 0.2), "the gate of 'L' is 3; give its ends"),
        (lambda: gz.strategy(yes, {"L": ((0, 0), (0, 0))}, 0.2), r"both ends of gate_of_L"),
        (lambda: gz.strategy(yes, GATES, 0.0), "hold = 0; give for how long"),
        (lambda: table(yes, {"M": GATES["L"]}), "gates names 'M', which is no flipper"),
        (
            lambda: table(yes, objects=(LEFT, RIGHT, gz.disc("gate_of_L", (3, 9), 0.1, LAW))),
            "as a gate of the",
        ),
        (lambda: gz.trajectory(table(broken), (2.0, 4.0, 0, 0), until=9.0), "the strategy raised ZeroDivisionError"),
        (lambda: gz.trajectory(table(lambda s, p: float("nan")), (2.0, 4.0, 0, 0), until=9.0), "returned nan for the"),
        (lambda: gz.launches(table(lambda s, p: None), (2.0, 4.0), [0.0], [0.0]), "returned None for the ball"),
        (lambda: gz.launches(table(picky), (2.0, 4.0), [1.5], [0.5]), "the strategy raised ValueError: it falls.* for"),
        (lambda: orbits_of(picky), "the strategy (or a reset law of launch map )?raised ValueError: it falls"),
    ],
)
def test_what_is_no_strategy_is_refused(made, said):
    with pytest.raises(gz.GrazingError, match=said):
        made()
