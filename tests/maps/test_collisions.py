"""Maps of tables from impact to impact: cycles in closed form, tangents, ways out, studies."""

import pickle
from dataclasses import replace
from math import pi, sqrt

import numpy as np
import pytest

import grazing as gz
from grazing.billiard.rows import LENGTH
from grazing.orbits.search_impacts import Tally
from grazing.orbits.search_map import Cycles
from grazing.outcome import ESCAPED
from tests.billiard.tables import ELASTIC, box, layout, mixed, three_discs, unit_cell


def pinball(V=0.4):
    """Two bumpers over two drains, between walls."""
    walls = [one for one in box(law=gz.newton(0.9)) if one.name != "floor"]
    bumpers = [gz.disc(name, (x, 6.0), 0.5, gz.active(r=0.9, V=V)) for name, x in (("P", 2.0), ("Q", 4.0))]
    drains = gz.drain("left_drain", (0.0, 0.0), (3.0, 0.0)), gz.drain("right_drain", (3.0, 0.0), (6.0, 0.0))
    return gz.table([*bumpers, *walls, *drains], rho=0.1, tilt=0.2)


def test_the_two_cycle_of_three_discs_has_the_multiplier_of_the_closed_form():
    """Between two unit discs 6 apart: T = 4, Lambda = 5 + 2 sqrt 6 a bounce."""
    P = gz.collision_map(three_discs(6.0))
    start = (0.0 + pi, 0.0, 1.0)  # on A, towards B
    found = P.orbit(start, 2)
    assert [P.letters.symbol(k) for k in found.letters] == ["B", "A"]
    np.testing.assert_allclose(found.points[2], start, atol=1e-15)
    multipliers = np.sort(np.abs(np.linalg.eigvals(P.jacobian(found.points[1]) @ P.jacobian(start))))
    np.testing.assert_allclose(multipliers, [(5 - 2 * sqrt(6)) ** 2, 1.0, (5 + 2 * sqrt(6)) ** 2], rtol=1e-12)
    flown = gz.trajectory(P.origin.table, (1.0, 0.0, 1.0, 0.0), until=30.0)
    np.testing.assert_allclose(np.diff(flown.impact_time), 4.0, rtol=1e-15)


def test_the_three_cycle_of_three_discs_has_the_period_and_multiplier_that_are_known():
    """Equilateral, T = 4.26794919243112 and |Lambda| = 11.7714551963856 a bounce."""
    P = gz.collision_map(three_discs(6.0))
    start = (pi + pi / 6.0, -pi / 6.0, 1.0)  # on A, from the direction of the centre of the triangle, towards B
    found = P.orbit(start, 3)
    assert [P.letters.symbol(k) for k in found.letters] == ["B", "C", "A"]
    np.testing.assert_allclose(found.points[3], start, atol=1e-11)
    J = P.jacobian(found.points[2]) @ P.jacobian(found.points[1]) @ P.jacobian(start)
    assert np.abs(np.linalg.eigvals(J)).max() ** (1.0 / 3.0) == pytest.approx(11.7714551963856, abs=1e-11)
    table = P.origin.table
    half = 6.0 / 2.0 - np.cos(pi / 6.0)
    assert 2.0 * half == pytest.approx(4.26794919243112, abs=1e-13)
    corner = np.array([np.cos(pi / 6.0), np.sin(pi / 6.0)])
    flown = gz.trajectory(table, (*corner, 1.0, 0.0), until=13.0)
    np.testing.assert_allclose(np.diff(flown.impact_time), 2.0 * half, rtol=1e-12)


def test_the_cycles_are_found_by_the_search_that_all_maps_share():
    P = gz.collision_map(three_discs(6.0), on="A")
    start = np.array([pi, 0.0, 1.0])
    assert P.orbit(start, 1).outcomes[0] == 0 and P.letters.read("(away)", 0) == (3, 6)


@pytest.mark.parametrize("rho", [0.0, 0.25])
def test_jacobians_are_those_of_differences(rho):
    P, count = gz.collision_map(mixed(rho)), 0
    orbit = P.orbit((0.9, 0.4, 3.0), 60)
    seen = set()
    for state, letter in zip(orbit.points[:-1], orbit.letters, strict=True):
        J, h = P.jacobian(state), 1e-6
        near = [[P.orbit(state + s * h * e, 1) for s in (1, -1)] for e in np.eye(3)]
        if any(one.letters[0] != letter for pair in near for one in pair) or not np.isfinite(J).all():
            continue
        D = np.array([(up.points[1] - down.points[1]) / (2 * h) for up, down in near]).T
        if np.abs(J).max() > 1e3:
            continue
        np.testing.assert_allclose(J, D, atol=3e-7 * np.abs(J).max() ** 2)
        count += 1
        seen.add(P.letters.symbol(int(letter)))
    assert count > 30 and len(seen) > 3


def test_active_discs_let_go_of_as_many_balls_as_is_known():
    """Three discs at three radii, restitution 0.8 and no kick: 0.845 +- 0.01 an impact, impacts 3 to 9."""
    table, n, most = three_discs(3.0), 400_000, 9
    P = gz.collision_map(table.replace(**{"A.r": 0.8, "B.r": 0.8, "C.r": 0.8}))
    random = np.random.default_rng(0)
    lanes = np.array([random.uniform(0, 2 * pi, n), np.arcsin(random.uniform(-1, 1, n)), np.ones(n)])
    letters = P.run(lanes, 0, most + 1)[1]
    left = (letters < 3).sum(axis=1)[2:]  # not away
    rate, error = np.polyfit(np.arange(len(left)), np.log(left), 1, w=np.sqrt(left), cov="unscaled")
    assert -rate[0] == pytest.approx(0.845, abs=0.01 + 3.0 * sqrt(error[0, 0]))


def test_phase_volume_is_kept_where_impacts_are_elastic():
    """cos(angle) speed^2 ds dangle dspeed is kept: at an elastic table without kicks."""
    P = gz.collision_map(gz.table([*layout(3), *box()], tilt=pi / 2))
    orbit = P.orbit((0.4, 0.3, 3.5), 40)
    for before, after in zip(orbit.points, orbit.points[1:], strict=False):
        J = P.jacobian(before)
        kept = [np.cos(point[1]) * point[2] ** 2 for point in (before, after)]
        assert abs(np.linalg.det(J)) == pytest.approx(kept[0] / kept[1], rel=1e-8)


def test_points_are_those_of_the_trajectory():
    table = mixed(0.25)
    P = gz.collision_map(table)
    orbit = P.orbit((0.9, 0.4, 3.0), 20)
    from grazing.billiard.hit import spot
    from grazing.maps.collide import velocity

    block = table.blocks(table.row(), "python")[0]
    states = []
    for place, angle, speed in orbit.points:
        _s, x, y, nx, ny, _c = spot(place, block)
        states.append((x, y, *velocity(nx, ny, angle, speed)))
    flown = gz.trajectory(table, states[0], until=40.0)
    assert flown.impact_wall.values[:12].tolist() == [table.names[k] for k in orbit.letters[:12]]
    np.testing.assert_allclose(flown.after.values[:12], states[1:13], atol=1e-8)


def test_only_ways_out_are_fixed_points_behind_the_objects():
    """A search on the map finds the drains and *away*, and no ball at rest in a solid."""
    P = gz.collision_map(pinball())
    cycles = Cycles(P, Tally())
    cycles.at_random(1, *np.array([(0.0, -1.5, 0.0), (60.0, 1.5, 2.0)]), 500, 0)
    assert {str(one.word) for one in cycles.orbits(1)} <= {"(left_drain)", "(right_drain)", "(away)"}
    assert not any("drain" in one.word or "away" in one.word for one in gz.periodic_orbits(P, (1, 2), starts=100))
    table = P.origin.table
    behind = float(table.blocks(table.row())[0][LENGTH])
    for k, name in enumerate([*table.names, "away", "beyond"]):
        after = P.orbit((behind + k + 0.5, 0.0, 0.0), 1)
        if name in ("left_drain", "right_drain", "away"):
            assert after.points[1].tolist() == [behind + k + 0.5, 0.0, 0.0] and after.outcomes[0] == ESCAPED
        else:
            assert after.outcomes[0] & gz.Outcome.diverged


def test_ways_out_are_attractors_and_have_basins():
    P = gz.collision_map(pinball())
    grid = {"place": np.linspace(0.05, 3.7, 20), "angle": np.linspace(-1.4, 1.4, 20)}
    found = gz.basins(P, grid, fixed={"speed": 1.5}, transient=300, keep=8)
    assert {*found.word.values.tolist()} == {"(left_drain)", "(right_drain)"}
    assert found.fraction.values.sum() == pytest.approx(1.0) and (found.outcome.values & ESCAPED).all()
    i, j = 3, 11
    place, angle = grid["place"][i], grid["angle"][j]
    orbit = P.orbit((place, angle, 1.5), 300)
    assert f"({P.letters.names[orbit.letters[-1]]})" == str(found.word.values[int(found.basin[i, j])])


def test_studies_take_it_as_any_map():
    P = gz.collision_map(pinball())
    diagram = gz.orbit_diagram(P, "P.V", np.linspace(0.0, 1.0, 4), starts=6, transient=100, keep=10)
    assert {*np.ravel(diagram.word.values).tolist()} <= {"(left_drain)", "(right_drain)"}
    chart = gz.chart(P, {"P.V": np.linspace(0.0, 1.0, 3), "tilt": np.linspace(0.1, 0.3, 3)}, transient=200)
    assert chart.sizes["P.V"] == 3
    exponents = gz.lyapunov(gz.collision_map(unit_cell(0.3)), starts=4, steps=500).exponent.values
    assert (exponents[:, 0] > 0.3).all() and np.abs(exponents.sum(axis=1)).max() < 0.01
    cell = gz.collision_map(unit_cell(0.3))
    density = gz.density(cell, "disc.radius", [0.2, 0.3], coordinate="angle", starts=8, transient=10, keep=500, bins=20)
    counts = density["count"].values
    assert counts.shape == (2, 20) and (counts[:, 9:11].mean(axis=1) > 3.0 * counts[:, [0, 19]].mean(axis=1)).all()


def sinai(radius, starts, steps):
    """Return lambda + 2 ln R an impact with the disc of a Sinai billiard, and its standard error."""
    P = gz.collision_map(unit_cell(radius))
    random = np.random.default_rng(0)
    lanes = np.array([
        random.uniform(0, 2 * pi * radius, starts), np.arcsin(random.uniform(-1, 1, starts)), np.ones(starts),
    ])  # fmt: skip
    found = gz.lyapunov(P, starts=lanes.T, transient=0, steps=steps, arithmetic="strict")
    letters = P.run(lanes, 64, steps)[1]
    total, hits = found.exponent.values[:, 0] * steps, (letters == 0).sum(axis=0)  # of the same steps
    exponent = total.sum() / hits.sum()
    return exponent + 2.0 * np.log(radius), (total - exponent * hits).std() * sqrt(starts) / hits.sum()


#: Of the exponent of a Sinai billiard with small discs, an impact with the disc.
SINAI = 1.0 - 4.0 * np.log(2.0) + 27.0 * 1.2020569031595942 / (2.0 * pi**2)


def test_the_sinai_billiard_has_the_exponent_that_is_known_for_small_discs():
    """lambda = -2 ln R + 1 - 4 ln 2 + 27 zeta(3)/(2 pi^2) + o(1) an impact with the disc."""
    assert pytest.approx(-0.128372041086545, abs=1e-14) == SINAI
    near, far = (abs(found - SINAI) for found, _error in (sinai(0.01, 64, 20_000), sinai(0.1, 64, 20_000)))
    error = sinai(0.01, 64, 20_000)[1]
    assert near < 3.0 * error and error < 0.012 and far > 0.07


def test_a_step_that_doubles_cannot_decide_is_decided_exactly():
    """From one disc past another that is touched, as exactly as doubles can say."""
    discs = [gz.disc("A", (0, 0), 1.0, ELASTIC), gz.disc("B", (4, 1), 1.0, ELASTIC), gz.disc("C", (9, 0), 1.0, ELASTIC)]
    P = gz.collision_map(gz.table(discs))
    start = pi, 0.0, 1.0  # from the right end of A along the x axis, which touches B
    bare = replace(P, origin=P.origin.unsettled()).orbit(start, 1)
    assert gz.Outcome(int(bare.outcomes[0])) == gz.Outcome.ambiguous | gz.Outcome.graze
    found = P.orbit(start, 1)
    assert gz.Outcome(int(found.outcomes[0])) == gz.Outcome.graze and found.undecided == 0
    assert P.letters.names[found.letters[0]] == "C" and np.isnan(P.jacobian(start)).all()
    np.testing.assert_allclose(found.points[1], [4.0 * pi, 0.0, 1.0], atol=1e-14)


def test_a_state_on_a_wall_inside_another_object_ends_by_name():
    table = gz.table([gz.disc("A", (0, 0), 1.0, ELASTIC), gz.disc("B", (2.1, 0), 1.0, ELASTIC)], rho=0.2)
    P = gz.collision_map(table)
    assert gz.Outcome(int(P.orbit((1.2 * pi, 0.0, 1.0), 1).outcomes[0])) == gz.Outcome.inside_wall
    assert P.orbit((0.0, 0.0, 1.0), 1).letters[0] == 2


def test_it_is_plain_python_too_equal_and_goes_through_a_pickle():
    P = gz.collision_map(pinball())
    c = P.prepare(tuple(P.params.values()))
    new, letter, outcome = P.step((0.3, 0.2, 1.0), c)
    again = P.orbit((0.3, 0.2, 1.0), 1)
    np.testing.assert_allclose(new, again.points[1], atol=1e-12)
    assert (letter, outcome) == (again.letters[0], again.outcomes[0])
    Q = pickle.loads(pickle.dumps(P))
    assert P == Q and Q((0.3, 0.2, 1.0))[1] == letter
    assert P.replace(**{"P.V": 0.7}).params["P.V"] == 0.7 and P.describe("P.V").low == 0.0
    gz.testing.check_map(gz.collision_map(gz.table([*layout(3), *box()], tilt=pi / 2)), states=8, steps=4)


def test_a_table_may_have_hundreds_of_objects():
    discs = [gz.disc(f"d{i}_{j}", (i, j), 0.3, ELASTIC) for i in range(16) for j in range(16)]
    P = gz.collision_map(gz.table(discs))
    state, c = (1.0, 0.3, 1.0), P.prepare(tuple(P.params.values()))
    new, letter, _outcome = P.step(state, c)
    again = P.orbit(state, 1)
    assert letter == again.letters[0] and np.abs(np.array(new) - again.points[1]).max() < 1e-12


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: gz.collision_map(gz.pinball()), "give gz.table"),
        (lambda: gz.collision_map(gz.table([gz.drain("out", (0, 0), (1, 0))])), "drains only"),
        (lambda: gz.collision_map(gz.table([gz.disc("pin", (0, 0), 0.0, ELASTIC)])), "drains and pins"),
        (lambda: gz.collision_map(pinball(), on="R"), "on is 'R'; allowed are P, Q, right"),
        (lambda: gz.collision_map(gz.table([gz.arc("A", (0, 0), 1.0, 0.0, 2 * pi, ELASTIC)], rho=0.99), on="A"), None),
        (lambda: gz.collision_map(gz.table(box(1.0, 10.0), rho=0.6), on="floor"), "fits nowhere beside floor"),
    ],
)
def test_wrong_input_is_refused(make, said):
    if said is None:
        assert make().params["rho"] == 0.99
        return
    with pytest.raises(gz.InputError, match=said):
        make()


def test_a_pin_is_not_where_balls_without_a_radius_start():
    # it has no places: the default object was one that is never hit
    pin = gz.disc("pin", (0, 0), 0.0, ELASTIC)
    P = gz.collision_map(gz.table([pin, gz.disc("A", (3, 0), 1.0, ELASTIC)]))
    assert P.origin.on == "A" and P.box[0] == (0.0, pytest.approx(2.0 * pi))
    wide = gz.collision_map(gz.table([pin, gz.disc("A", (3, 0), 1.0, ELASTIC)], rho=0.1))
    assert wide.origin.on == "pin"
    with pytest.raises(gz.InputError, match="never meets it"):
        wide.replace(rho=0.0)
    with pytest.raises(gz.InputError, match="never meets"):
        gz.lyapunov(wide, "rho", [0.1, 0.0, 0.2], starts=2, steps=2, transient=0)


def test_an_impact_at_no_speed_or_that_leaves_none_is_a_graze():
    """A ball runs up a wall onto an active dome that goes on from it; one stops at a dead wall: both were *ok*."""
    walls = [
        gz.segment("wall", (2, -3), (2, 0), gz.newton(0.5)),
        gz.segment("floor", (-3, -3), (3, -3), gz.newton(0.5)),
    ]
    P = gz.collision_map(gz.table([gz.arc("dome", (0, 0), 2.0, 0.0, pi, gz.active(0.9, 0.4)), *walls], 0.1, tilt=0.5))
    dead = gz.segment("dead", (0, 0), (0, 4), gz.newton(0.0)), gz.segment("wall", (3, 4), (3, 0), ELASTIC)
    for one, start in ((P, (13.5, -pi / 2, 2.0)), (gz.collision_map(gz.table(dead, 0.1)), (14.0, 0.0, 1.0))):
        found = one.orbit(start, 1)
        assert gz.Outcome(int(found.outcomes[0])) == gz.Outcome.graze and np.isfinite(found.points).all()
        assert np.isnan(one.jacobian(start)).all()
