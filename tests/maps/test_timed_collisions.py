"""Maps of tables whose flippers are worked: the phase as a coordinate, its tangent, exits, what is refused."""

import numpy as np
import pytest

import grazing as gz
from grazing.billiard.flown import FLAGS, NEXT, decided, flights_of
from grazing.outcome import AMBIGUOUS
from tests.billiard.flippers import pair

FLIPS = gz.flips(0.9, 0.4, {"L": 0.0, "R": 0.3})


def test_the_phase_is_a_coordinate_of_a_table_that_is_periodic_in_time():
    P = gz.collision_map(pair(FLIPS))
    assert P.coordinates == ("place", "angle", "speed", "phase") and P.box[3] == (0.0, 0.9)
    assert P.replace(**{"flips.period": 2.0}).box[3] == (0.0, 2.0)
    assert gz.collision_map(pair()).coordinates == ("place", "angle", "speed")
    gz.testing.check_map(P, states=4, steps=3)
    gz.testing.check_map(gz.collision_map(pair(), on="A"), states=4, steps=3)


def test_jacobians_are_those_of_differences():
    P, random, seen = gz.collision_map(pair(FLIPS)), np.random.default_rng(0), {}
    low, high = np.array(P.box).T
    low[0], high[0] = 0.0, 30.0
    names = P.letters.symbol
    for _ in range(150):
        orbit = P.orbit(random.uniform(low, high), 4)
        before = ""
        for state, letter in zip(orbit.points[:-1], orbit.letters, strict=True):
            if not np.isfinite(state).all() or ("(" in names(int(letter)) and "o" in names(int(letter))):
                break
            J, h = P.jacobian(state), 1e-6
            near = [[P.orbit(state + s * h * e, 1) for s in (1, -1)] for e in np.eye(4)]
            if any(one.letters[0] != letter for two in near for one in two) or not np.isfinite(J).all():
                continue
            D = np.array([(up.points[1] - down.points[1]) / (2 * h) for up, down in near]).T
            if np.abs(J).max() > 1e3 or not np.abs(D).max() < 1e4:  # a phase that begins anew
                continue
            np.testing.assert_allclose(J, D, atol=1e-7 * np.abs(J).max() ** 2)
            seen[before, names(int(letter))] = seen.get((before, names(int(letter))), 0) + 1
            before = names(int(letter))
    assert sum(count for (one, _two), count in seen.items() if one in "LR" and one) > 20
    assert sum(count for (_one, two), count in seen.items() if two in "LR") > 40


def test_points_are_those_of_the_trajectory():
    table = pair(FLIPS)
    P = gz.collision_map(table, on="L")
    for angle in np.linspace(-0.4, 0.4, 30):
        state = np.array([P.box[0][0] + 0.6, angle, 4.5, 0.03])  # on the left flipper, on its way up
        orbit = P.orbit(state, 12)
        if not orbit.outcomes.any() and (orbit.letters[3:] < 2).any():
            break
    assert np.isfinite(orbit.points).all() and not orbit.outcomes.any()
    row, start = list(table.params.values()), np.empty(4)
    settled = P.origin.settle(row, tuple(state.tolist()))
    assert settled.letter == orbit.letters[0] and settled.state == pytest.approx(tuple(orbit.points[1]), rel=1e-12)
    from grazing.kernel.compile import call
    from grazing.maps.collisions import placer

    block = table.blocks(table.row())[0]
    left = int(call(placer(), block, state, 0.03, start))
    first = decided(block, start, left, 0.03)
    flights = flights_of(table, tuple(first[NEXT : NEXT + 4].tolist()), 0.03 + first[0], 60.0)
    names = [P.letters.symbol(k) for k in orbit.letters[1:]]
    found = [table.names[int(k)] for k in flights[:11, 2]]
    assert [f"({name})" if len(name) > 1 else name for name in found] == names
    assert not (flights[:, FLAGS].astype(int) & AMBIGUOUS).any()
    np.testing.assert_allclose((0.03 + first[0] + np.cumsum(flights[:11, 0])) % 0.9, orbit.points[2:, 3], atol=1e-9)


def test_a_ball_that_has_left_stays_where_it_is():
    P = gz.collision_map(pair(FLIPS))
    orbit = P.orbit(np.array([P.box[0][0] + 0.6, 0.2, 1.0, 0.3]), 80)
    assert P.letters.symbol(int(orbit.letters[-1])) == "(out)"
    np.testing.assert_array_equal(orbit.points[-1], orbit.points[-2])
    found = gz.basins(P, {"angle": np.linspace(-1, 1, 4), "phase": [0.0, 0.5]}, transient=1000,
                      fixed={"place": P.box[0][0] + 0.5, "speed": 2.0})  # fmt: skip
    assert set(found.word.values.ravel().tolist()) == {"(out)"}


def test_a_phase_that_no_double_has_is_refused():
    words = r"phase = 1e\+17; allowed is \|phase\| <= 1.4\d+e\+14: beyond, doubles are too coarse .* within 0.9"
    with pytest.raises(gz.InputError, match=words):
        gz.collision_map(pair(FLIPS)).origin.check((0.0, 0.0, 1.0, 1e17), {"flips.period": 0.9})
    with pytest.raises(gz.InputError, match=r"R.phase = 1e\+300; allowed is \|R.phase\| <= "):
        pair(gz.flips(0.9, 0.4, {"L": 0.0, "R": 1e300}))


def test_a_recording_has_no_map_but_launches():
    table = pair(gz.presses(L=[0.5, 0.9, 2.5]))
    with pytest.raises(gz.InputError, match="worked by a recording, which does not repeat"):
        gz.collision_map(table)
    angles, speeds = np.linspace(0.6, 2.4, 7), np.linspace(1.0, 4.0, 5)
    found, still = gz.launches(table, (3.0, 4.0), angles, speeds), gz.launches(pair(), (3.0, 4.0), angles, speeds)
    assert (found.exit.values == "out").any() and (found.hits.values != still.hits.values).any()
    L = gz.launch_map(table, (3.0, 4.0))
    for i, angle in enumerate(angles):
        for j, speed in enumerate(speeds):
            if found.exit.values[i, j]:
                assert L.letters.symbol(L((angle, speed))[1]) == f"({found.exit.values[i, j]})"
    one = gz.trajectory(table, (3.0, 4.0, speeds[1] * np.cos(angles[2]), speeds[1] * np.sin(angles[2])), until=200.0)
    assert len(one.impact_time) == found.hits.values[2, 1]
