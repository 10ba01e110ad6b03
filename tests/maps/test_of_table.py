"""The stroboscopic map of a table: twins, derivatives, slides and rides over a strobe, ways out, words, refusals."""

from math import pi

import numpy as np
import pytest

import grazing as gz
from grazing.maps.hits import MANY, Bounces
from grazing.maps.of_table import reach_of
from grazing.outcome import ESCAPED, INSIDE_WALL, STUCK
from tests.billiard.flippers import pair

FLIPS = gz.flips(0.9, 0.4, {"L": 0.0, "R": 0.3})


def bowl(law, kind="arc"):
    """A closed box in which a flipper throws up a ball that slides, rests and rides."""
    flipper = gz.flipper("L", (1.0, 1.0), 2.0, 0.2, -0.2, 0.5, law, up=3.0, down=2.0)
    corners = ((0.0, 0.0), (0.0, 12.0), (4.0, 12.0), (4.0, 0.0))
    walls = [gz.segment(name, *corners[i : i + 2], law) for i, name in enumerate(("left", "top", "right"))]
    floors = {
        "arc": [gz.arc("bowl", (2.0, 2.2), 2.2, pi, 2.0 * pi, law)],
        "lines": [gz.segment("slope", (4.0, 1.4), (3.2, 0.4), law), gz.segment("bottom", (3.2, 0.4), (0.0, 0.2), law)],
    }
    return gz.table([flipper, *walls, *floors[kind]], rho=0.1, tilt=0.5, player=gz.flips(2.3, 0.5, 0.2))


def steps(orbit):
    """The state before each step of an orbit, that after it, its letter and its outcome."""
    return orbit.points[:-1], orbit.points[1:], orbit.letters, orbit.outcomes


def flown(table, state, phase, steps):
    """Where the trajectory is at strobes."""
    T = table.period
    found = [gz.trajectory(table, state, start=phase, until=phase + T * k) for k in range(1, steps + 1)]
    return np.array([[one[name].values[-1] for name in ("x", "y", "vx", "vy")] for one in found])


@pytest.mark.parametrize("kind", ["arc", "lines"])
@pytest.mark.parametrize("phase", [0.1, 0.33, 0.55])  # at rest, on its way up, on its way down
def test_strobes_are_those_of_the_trajectory_while_it_slides_and_rides(kind, phase):
    seen = 0
    for law in (gz.newton(0.3), gz.active(r=0.5, V=0.4)):
        table = bowl(law, kind)
        P = gz.stroboscopic_map(table, phase)
        for state in ((2.1, 3.0, 0.0, 0.0), (2.6, 2.5, -0.2, 0.5), (0.5, 4.0, 0.3, 0.0)):
            orbit, grown = P.orbit(state, 8), np.eye(4)
            for before, after, truth in zip(
                orbit.points, orbit.points[1:], flown(table, state, phase, 8), strict=False
            ):
                grown = P.jacobian(before) @ grown
                if not np.isfinite(grown).all() or np.abs(grown).max() > 1e5:
                    break
                np.testing.assert_allclose(after, truth, atol=1e-13 * max(10.0, np.abs(grown).max()))
                seen += 1
    assert seen > 20


@pytest.mark.parametrize("kind", ["arc", "lines"])
def test_jacobians_are_those_of_differences(kind):
    table, random, seen = bowl(gz.newton(0.5), kind), np.random.default_rng(3), {}
    for phase in (0.1, 0.33, 0.55):
        P = gz.stroboscopic_map(table, phase)
        for start in random.uniform((0.5, 2.4, -0.5, -2.0), (3.5, 4.0, 0.5, 1.0), (12, 4)):
            for before, letter, outcome in zip(*P.orbit(start, 8)[:3], strict=False):
                if not np.isfinite(before).all() or table.overlap(*before[:2], phase)[0] > 0.0:
                    break
                J, h = P.jacobian(before), 1e-7
                near = [[P(before + s * h * e) for s in (1, -1)] for e in np.eye(4)]
                if any(not np.isfinite(one[0]).all() for two in near for one in two):  # so near to an object
                    continue
                if any(one[1] != letter for two in near for one in two) or not np.isfinite(J).all():
                    continue
                D = np.array([(up[0] - down[0]) / (2 * h) for up, down in near]).T
                np.testing.assert_allclose(J, D, atol=1e-6 * max(1.0, np.abs(J).max()) ** 2)
                kinds = bool(letter), bool(outcome & STUCK)
                seen[kinds] = seen.get(kinds, 0) + 1
    assert seen[True, False] > 20 and seen[False, False] > 20


def test_it_is_the_composition_of_the_map_from_impact_to_impact():
    table = pair(FLIPS)
    C, P = gz.collision_map(table, on="L"), gz.stroboscopic_map(table, 0.2)
    flights = gz.trajectory(table, (3.0, 6.0, 0.4, 0.0), start=0.2, until=0.2 + 0.9 * 12)
    orbit = P.orbit((3.0, 6.0, 0.4, 0.0), 12)
    hit = [name for letter in orbit.letters for name in P.letters.symbol(int(letter)).strip("()").split("-")]
    assert [name for name in hit if name != "0"] == flights.impact_wall.values.tolist()
    assert set(C.letters) == set(P.letters.names)


def test_a_ball_that_has_left_stays_where_that_way_out_is():
    walls = [gz.drain("hole", (0, 0), (3, 0)), gz.drain("lane", (3, 0), (6, 0))]
    flipper = gz.flipper("L", (9.0, 1.0), 1.0, 0.1, -0.5, 0.5, gz.newton(0.5), up=9.0, down=9.0)
    table = gz.table([*walls, flipper], rho=0.1, tilt=0.3, player=gz.flips(1.0, 0.2))
    P = gz.stroboscopic_map(table)
    for state, name in (
        ((1.0, 0.5, 0.0, -1.0), "(hole)"),
        ((4.0, 0.2, 0.0, -1.0), "(lane)"),
        ((-3.0, 0.0, 0.0, 0.0), "(away)"),
    ):
        orbit = P.orbit(state, 3)
        assert P.letters.symbol(int(orbit.letters[0])) == P.letters.symbol(int(orbit.letters[-1])) == name
        assert (orbit.outcomes == ESCAPED).all() and (orbit.points[1:] == orbit.points[1]).all()
        assert P(orbit.points[1])[0].tolist() == orbit.points[1].tolist()
        assert not np.any(P.jacobian(state))
    late = P.orbit((1.0, 9.0, 0.0, 0.0), 12)
    assert np.flatnonzero(late.outcomes & ESCAPED)[0] == int((18.0 / table.gravity) ** 0.5)  # it falls from 9
    grid = {"x": [1.0, 4.0], "y": [2.0, 3.0]}
    found = gz.basins(P, grid, fixed={"vx": 0.0, "vy": 0.0}, transient=20)
    assert len(np.unique(found.basin.values)) == 2


def test_a_ball_that_has_left_is_no_periodic_orbit():
    """It was listed as a stable one, beside the ball that a flipper throws up to the same place."""
    law = gz.newton(0.8)
    flipper = gz.flipper("L", (1.0, 1.0), 1.2, 0.2, -0.4, 0.5, law, up=9.0, down=5.0)
    ends = {"left": [(0.0, 0.0), (0.0, 8.0)], "top": [(0.0, 8.0), (5.0, 8.0)], "right": [(5.0, 8.0), (5.0, 0.0)]}
    objects = [flipper, *(gz.segment(name, *points, law) for name, points in ends.items())]
    objects += [gz.disc("bumper", (2.5, 4.5), 1.0, gz.active(0.9, 0.4)), gz.drain("out", (0.0, -1.0), (5.0, -1.0))]
    P = gz.stroboscopic_map(gz.table(objects, rho=0.1, tilt=0.3, player=gz.flips(2.0, 0.4, 0.1)))
    assert [one.word for one in gz.periodic_orbits(P, 1, starts=300, seed=1)] == ["(L-top)"]


def test_starts_inside_an_object_have_no_next_state():
    P = gz.stroboscopic_map(bowl(gz.newton(0.5)))
    for inside in ((2.0, 0.0), (2.0, 0.9), (1.0, 1.0), (0.05, 5.0)):  # the bowl, flipper, its hub, a wall
        orbit = P.orbit((*inside, 0.0, 0.0), 2)
        assert int(orbit.outcomes[0]) == INSIDE_WALL and np.isnan(orbit.points[1:]).all()
    found = gz.basins(P, {"x": [2.0, 2.2], "y": [0.9, 4.0]}, fixed={"vx": 0.0, "vy": 0.0}, transient=5)
    assert (found.outcome.values[..., 0] & INSIDE_WALL).all() and not (found.outcome.values[..., 1] & INSIDE_WALL).any()


def test_a_step_is_settled_in_exact_arithmetic_as_the_kernel_takes_it():
    seen = 0
    for table, states in (
        (pair(FLIPS), np.random.default_rng(5).uniform((0.3, 3.0, -1.0, -3.0), (5.7, 9.0, 1.0, 1.0), (40, 4))),
        (bowl(gz.newton(0.3)), np.random.default_rng(6).uniform((0.5, 2.4, -0.5, -2.0), (3.5, 4.0, 0.5, 1.0), (20, 4))),
    ):
        P = gz.stroboscopic_map(table, 0.25)
        row = list(P.params.values())
        for state in states:
            if table.overlap(state[0], state[1], 0.25)[0] > 0.0:
                continue
            for before, after, letter, outcome in zip(*steps(P.orbit(state, 4)), strict=True):
                settled = P.origin.settle(row, tuple(before.tolist())) if before[0] < 10.0 else None
                if settled is None:
                    continue
                assert (settled.letter, settled.outcome) == (letter, outcome)
                np.testing.assert_allclose(settled.state, after, rtol=1e-11, atol=1e-11)
                seen += 1
    assert seen > 80


def test_it_is_a_map_like_others():
    gz.testing.check_map(gz.stroboscopic_map(pair(FLIPS), 0.2), states=4, steps=3)
    P = gz.stroboscopic_map(bowl(gz.newton(0.5)), 0.1)
    moved = P.replace(**{"L.up": 3.5, "phase": 0.4})
    assert (moved.params["L.up"], moved.params["phase"]) == (3.5, 0.4)
    assert moved.describe("vx").meaning == "velocity along x"
    assert P.box[1] == (0.0, 12.0)
    found = gz.orbit_diagram(P, "L.up", [3.0, 3.2], starts=4, transient=10)
    assert found.sizes["L.up"] == 2


def test_lengths_may_have_any_unit():
    def table(unit):
        law = gz.newton(0.5)
        flipper = gz.flipper("L", (unit, unit), 2 * unit, 0.2 * unit, -0.2, 0.5, law, up=3.0, down=2.0)
        floor = gz.segment("floor", (0.0, 0.2 * unit), (4.0 * unit, 0.4 * unit), law)
        return gz.table([flipper, floor], rho=0.1 * unit, g=unit, tilt=0.5, player=gz.flips(2.3, 0.5, 0.2))

    one, other = (
        gz.stroboscopic_map(table(unit), 0.3).orbit(np.array((2.1, 3.0, 0.0, 0.0)) * unit, 6)
        for unit in (1.0, 2.0**-10)
    )
    assert (one.letters == other.letters).all() and (one.points == other.points * 1024.0).all()
    table = table(1.0)
    assert reach_of(table, table.params) == 4.0


def test_words_name_objects_and_are_read_again():
    names = Bounces(("A", "bumper", "away"))
    for hit in ([], [0], [1], [0, 1, 1, 2], [2] * names.most):
        letter = names.letter(hit)
        assert names.read(f"A{names.symbol(letter)}0", 1) == (letter, 1 + len(names.symbol(letter)))
    assert names.letter([0] * (names.most + 1)) == MANY and names.read("(more)", 0) == (MANY, 6)
    for wrong in ("B", "(A-)", "(A-C)", "(A", "()", "(0)-"):
        if wrong == "(0)-":
            assert names.read(wrong, 0) == (0, 3)
            continue
        with pytest.raises(gz.InputError, match="allowed are 0, A, \\(bumper\\), \\(away\\), up to"):
            names.read(wrong, 0)
    for code in (4, 4**20, -1):
        with pytest.raises(gz.InputError, match="no symbol"):
            names.symbol(code)


FREE = gz.table(
    [
        gz.disc("A", (2.0, 6.0), 0.5, gz.active(r=0.9, V=0.4)),
        gz.segment("left", (0.0, 10.0), (0.0, 0.0), gz.newton(0.9)),
        gz.segment("right", (6.0, 0.0), (6.0, 10.0), gz.newton(0.9)),
        gz.segment("top", (0.0, 10.0), (6.0, 10.0), gz.newton(0.9)),
        gz.segment("floor", (0.0, 0.3), (6.0, 0.0), gz.active(r=0.8, V=2.5)),
    ],
    rho=0.1,
    tilt=0.5,
)  # fmt: skip


def test_a_table_that_nothing_works_is_seen_at_equal_times():
    state, seen = (3.0, 8.0, 0.7, 0.0), []
    for period in (0.3, 0.6):
        P = gz.stroboscopic_map(FREE, period=period)
        assert (P.params["period"], P.describe("period").meaning) == (period, "time from one strobe to the next")
        seen.append(P.orbit(state, int(24.0 / period)))
    np.testing.assert_allclose(seen[0].points[::2], seen[1].points, atol=1e-8)
    flights = gz.trajectory(FREE, state, until=24.0)
    for orbit in seen:
        hit = [name for k in orbit.letters for name in P.letters.symbol(int(k)).strip("()").split("-") if name != "0"]
        assert hit == flights.impact_wall.values.tolist() and len(hit) > 5
    gz.testing.check_map(P, states=4, steps=3)
    J, here = P.jacobian(state), np.array(state)
    D = np.array([(P(here + h)[0] - P(here - h)[0]) / 2e-6 for h in 1e-6 * np.eye(4)]).T
    np.testing.assert_allclose(J, D, atol=1e-5 * np.abs(J).max())
    moved = P.replace(period=0.45)
    assert moved.params["period"] == 0.45 and (moved(state)[0] != P(state)[0]).any()
    row, after = list(P.params.values()), P(state)
    assert P.origin.settle(row, state).letter == after[1]
    np.testing.assert_allclose(P.origin.settle(row, state).state, after[0], atol=1e-11)


def test_exponents_per_time_are_those_of_the_map_from_impact_to_impact():
    law = gz.newton(1.0)
    corners = [(0.0, 0.0), (0.0, 3.0), (4.0, 3.0), (4.0, 0.0), (0.0, 0.0)]
    box = [gz.segment("abcd"[i], *corners[i : i + 2], law) for i in range(4)]
    table = gz.table([gz.disc("D", (2.0, 1.5), 0.8, law), *box], rho=0.05)  # a Sinai billiard
    P, S = gz.collision_map(table), gz.stroboscopic_map(table, period=0.7)
    hit = gz.lyapunov(P, starts=[(0.4, 0.3, 1.0)], transient=50, steps=20_000)
    seen = gz.lyapunov(S, starts=[(0.6, 0.7, 0.6, 0.8)], transient=50, steps=20_000)
    free = np.pi * (3.9 * 2.9 - np.pi * 0.85**2) / (2 * (3.9 + 2.9) + 2 * np.pi * 0.85)  # Santalo's mean free path
    first, second = float(hit.exponent[0, 0]) / free, float(seen.exponent_per_time[0, 0])
    errors = float(hit.exponent_error[0, 0]) / free, float(seen.exponent_error[0, 0]) / 0.7
    assert abs(first - second) < 5.0 * np.hypot(*errors) < 0.2 * first
    assert float(seen.return_time[0]) == pytest.approx(0.7)


def test_the_usual_period_has_the_units_of_the_table():
    assert gz.stroboscopic_map(FREE).params["period"] == pytest.approx(
        np.hypot(6.0, 10.0) / 20.0 / np.sqrt(2.0 * FREE.gravity * 10.0)
    )


@pytest.mark.parametrize("player", ["presses", "strategy"])
def test_a_table_without_a_period_is_refused(player):
    made = {
        "presses": {"player": gz.presses(L=[0.1, 0.2])},
        "strategy": {"player": gz.strategy(lambda state, p: True, {"L": ((1.0, 3.0), (3.0, 3.0))}, hold=0.2)},
    }[player]
    flipper = gz.flipper("L", (1.0, 1.0), 1.0, 0.1, -0.5, 0.5, gz.newton(0.5), up=9.0, down=9.0)
    with pytest.raises(gz.InputError, match="a recording or a strategy, which have no period"):
        gz.stroboscopic_map(gz.table([flipper], rho=0.1, tilt=0.3, **made))


@pytest.mark.parametrize(
    ("of", "given", "says"),
    [
        (pair(FLIPS), {"phase": 1e300}, "phase"),
        (pair(FLIPS), {"period": 1.0}, "this table has one, flips.period = 0.9"),
        (FREE, {"phase": 0.2}, "nothing on this table moves"),
        (FREE, {"period": 0.0}, "period = 0"),
        (gz.pinball(), {"period": 1.0}, "that of an oscillator or a system is its own"),
    ],
)
def test_what_else_is_refused(of, given, says):
    with pytest.raises(gz.InputError, match=says):
        gz.stroboscopic_map(of, **given)


@pytest.mark.parametrize("turn", [0, 1])
def test_starts_have_room_where_all_objects_lie_on_one_line(turn):
    ends = [(-2.0, 1.0), (4.0, 1.0)] if not turn else [(1.0, -2.0), (1.0, 4.0)]
    box = gz.stroboscopic_map(gz.table([gz.drain("out", *ends)], tilt=0.3)).box
    assert box[:2] == (((-2.0, 4.0), (1.0, 7.0)) if not turn else ((-2.0, 4.0), (-2.0, 4.0)))
