"""Maps of tables that a strategy plays: what is pressed is part of the state, and they are what trajectories are."""

import pickle

import numpy as np
import pytest

import grazing as gz
from grazing.kernel.compile import call
from grazing.maps.collisions import placer
from grazing.testing import check_map
from tests.billiard.test_strategy import LAW, LEFT, OUT, WALLS, no, table, yes

GATE = {"L": ((1.0, 1.7), (3.0, 1.7))}
KICK = (*WALLS[:3], gz.disc("A", (2.6, 6.0), 0.5, gz.active(0.9, 0.4)))


def fast_down(state, p):
    return state[3] < -0.5 and p["A.V"] > 0.1 and p.A_V < 9.0 and p["tilt"] == 0.5


def watched(flip=fast_down):
    return table(flip, GATE, (LEFT, *KICK, OUT))


def start(P, share, angle, speed=1.0):
    low, high = P.box[0]
    return np.array([low + share * (high - low), angle, speed, 0.0, 0.0])


def flown(T, state, until):
    place = np.empty(4)
    call(placer(), T.blocks(T.row())[0], state, 0.0, place)
    return gz.trajectory(T, place, until=until)


def test_steps_are_the_impacts_of_a_trajectory():
    T = watched()
    P = gz.collision_map(T, on="A")
    assert P.coordinates == ("place", "angle", "speed", "L.turned", "L.held")
    seen = 0
    for share, angle in ((0.26, -0.4), (0.74, 0.9)):
        orbit, path = P.orbit(start(P, share, angle), 12), flown(T, start(P, share, angle), 100.0)
        n = min(12, path.sizes["impact"])
        assert [P.letters.symbol(k).strip("()") for k in orbit.letters[:n]] == path.impact_wall.values[:n].tolist()
        pressed = path.attrs["presses"].get("L", [])
        for k in range(n):
            t = path.impact_time.values[k]
            turned = gz.table([LEFT], player=gz.presses(L=[x for x in pressed if x - 0.25 <= t])).angles(t)["L"] + 0.5
            assert orbit.points[k + 1, 3] == pytest.approx(turned, abs=1e-7)
            held = [end - t for begin, end in zip(pressed[::2], pressed[1::2], strict=True) if begin <= t < end]
            assert orbit.points[k + 1, 4] == pytest.approx(held[0] if held else 0.0, abs=1e-7)
            seen += bool(held)
    assert seen > 1


def test_derivatives_know_when_the_button_was_pressed():
    P, h, seen = gz.collision_map(watched(yes), on="A"), 1e-7, 0
    orbit = P.orbit(start(P, 0.74, 0.9), 12)
    for k in range(12):
        if orbit.outcomes[k]:
            break
        J = P.jacobian(orbit.points[k])
        for j in range(5):
            low, high = orbit.points[k].copy(), orbit.points[k].copy()
            low[j] = max(low[j] - h, 0.0) if j > 2 else low[j] - h
            high[j] = min(high[j] + h, 1.1) if j == 3 else high[j] + h
            D = (P(high)[0] - P(low)[0]) / (high[j] - low[j])
            np.testing.assert_allclose(J[:, j], D, rtol=0, atol=3e-6 * max(1.0, np.abs(J).max()))
        seen += bool(np.abs(J[3:]).max())
    assert seen > 1


def test_what_is_never_pressed_is_the_map_of_nobody():
    P, plain = gz.collision_map(watched(no), on="A"), gz.collision_map(gz.table([LEFT, *KICK, OUT], 0.1, 1.0, 0.5), "A")
    here, there = P.orbit(start(P, 0.6, 0.9), 6), plain.orbit(start(P, 0.6, 0.9)[:3], 6)
    n = int(np.argmax(there.outcomes > 0)) or 6
    np.testing.assert_allclose(here.points[:n, :3], there.points[:n], rtol=0, atol=1e-9)
    assert not here.points[:n, 3:].any()


def test_launches_of_the_map_are_those_one_by_one():
    T = watched()
    L = gz.launch_map(T, (3.0, 8.5), hits=60)
    found = gz.launches(T, (3.0, 8.5), [0.4, 1.1], [0.5, 1.5], hits=60)
    for i, angle in enumerate(found.angle.values):
        for j, speed in enumerate(found.speed.values):
            assert L.letters.symbol(L((angle, speed))[1]).strip("()") == found.exit.values[i, j]


def test_studies_take_it():
    P = gz.collision_map(watched(), on="A")
    again = pickle.loads(pickle.dumps(gz.collision_map(watched(yes))))
    assert again.coordinates == P.coordinates and P.describe("L.turned").meaning == "angle from rest of L"
    check_map(P, states=3, steps=3)
    rate = gz.escape_rate(P, orbits=100, transient=2, steps=2, populations=2)
    assert rate.rate > 0.0
    lost = P.orbit((start(P, 0.6, 0.9)[0], 0.0, 1.0, 2.0, 0.0), 1)  # turned by more than it can
    assert lost.outcomes[0] & gz.Outcome.diverged


def test_what_is_decided_exactly_is_what_doubles_find_where_they_do():
    P = gz.collision_map(watched(), on="A")
    orbit, row = P.orbit(start(P, 0.26, -0.4), 11), list(P.params.values())
    for before, after, letter, flags in zip(
        orbit.points, orbit.points[1:], orbit.letters, orbit.outcomes, strict=False
    ):
        found = P.origin.settle(row, tuple(before.tolist()))
        assert (found.letter, found.outcome) == (letter, flags)
        np.testing.assert_allclose(found.state, after, rtol=0, atol=1e-9)
    T = gz.table([LEFT, *KICK, gz.disc("post", (4.0, 5.0), 0.3, LAW), gz.drain("out", (-9, -1), (9, -1))],
                 rho=0.1, tilt=0.0, player=gz.strategy(no, GATE, 0.2))  # fmt: skip
    graze = gz.collision_map(T, on="right")
    at = graze.box[0][0] + 5.0 - 0.4  # 5.4 or 4.6 high, straight to the left: past the post by nothing
    high = graze.orbit((at, 0.0, 1.0, 0.0, 0.0), 1)
    assert high.outcomes[0] == graze.origin.settle(list(graze.params.values()), (at, 0.0, 1.0, 0.0, 0.0)).outcome


def late(_state, _p):
    return __import__("math").pi > 3.0


@pytest.mark.parametrize("make", [gz.collision_map, lambda T: gz.launch_map(T, (3.0, 8.5))])
def test_what_is_no_decision_is_refused(make):
    with pytest.raises(gz.UserCodeError, match="returned None for the ball"):
        make(watched(lambda s, p: None))
    with pytest.raises(gz.UserCodeError, match="the strategy does not compile"):
        make(watched(late)).orbit((1.0,) * make(watched(late)).dimension, 1)
    with pytest.raises(gz.InputError, match="worked by a recording"):
        gz.collision_map(gz.table([LEFT, OUT], rho=0.1, player=gz.presses(L=[1.0, 2.0])))


def test_a_button_pressed_as_the_ball_rides_the_flipper_down_is_an_impact():
    """The ball went up with the flipper, whatever its law says; derivatives there are those of that impact."""
    made, out = [], []
    for r in (0.0, 0.5, 0.9):
        one = gz.flipper("F", (0, 0), 2.0, (0.2, 0.1), -1.2, -0.2, gz.newton(r), up=2.0, down=0.7)
        player = gz.strategy(yes, {"F": ((0.497, -3.0), (0.497, 3.0))}, 0.3)
        floor = gz.segment("floor", (-9, -4), (9, -4), gz.newton(0.8))
        P = gz.collision_map(gz.table([one, floor], 0.1, tilt=0.5 * np.pi, player=player))
        made.append(P)

        def riding(foot, along, turned, end=P.box[0][1]):  # with the speed of the side
            return np.array([end - foot, np.arctan2(along, -0.7 * foot), np.hypot(along, 0.7 * foot), turned, 0.0])

        new, letter = P(riding(0.4, -0.4, 0.9))
        assert P.letters.symbol(letter) == "F" and new[4] == 0.3
        out.append(new[2] * np.cos(new[1]))
    assert out[1] > out[0] + 0.1 and (out[2] - out[0]) / 0.9 == pytest.approx((out[1] - out[0]) / 0.5, abs=1e-9)
    P, J, at, h = made[1], made[1].jacobian(riding(0.4, -0.4, 0.9)), np.array([0.4, -0.4, 0.9]), 1e-6
    for way in h * np.eye(3):
        D, moved = P(riding(*at + way))[0] - P(riding(*at - way))[0], riding(*at + way) - riding(*at - way)
        np.testing.assert_allclose(J @ moved / (2 * h), D / (2 * h), rtol=0, atol=1e-6)
