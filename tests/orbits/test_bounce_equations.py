"""Orbits of a table followed in a parameter: grazes, folds and doublings where closed forms have them."""

import numpy as np
import pytest

import grazing as gz
from grazing.orbits import events
from grazing.orbits.events import located
from grazing.orbits.signature import equations_of
from tests.billiard.orbits import active_discs, bowl, in_a_row, pinball
from tests.billiard.tables import unit_cell


def test_a_graze_is_met_where_a_disc_touches_the_way():
    """The middle one of three discs comes down between the outer ones, and leaves below."""
    P = gz.collision_map(in_a_row(1.5))
    (orbit,) = gz.periodic_orbits(P, word="AC")
    branch = gz.continuation(P, orbit, "B.y", (-2.0, 2.0))
    assert [one.type for one in branch.special] == ["gr", "gr"] and branch.complete
    np.testing.assert_allclose([one.value for one in branch.special], [-1.0, 1.0], atol=1e-12)
    values, admissible = branch.dataset["B.y"].values, branch.dataset.admissible.values
    assert (admissible[np.abs(values) > 1.0 + 1e-6] == 1).all() and (admissible[np.abs(values) < 1.0 - 1e-6] == 0).all()
    assert (np.abs(branch.dataset.multiplier_real.values[:, 0] - (5 + 2 * 6**0.5) ** 2) < 1e-10).all()


def test_a_ball_in_a_bowl_doubles_where_it_rises_by_half_the_radius(monkeypatch):
    """The trace of the turn is 2 - 4 v^2/(g R), with v = V/(1 - r): -2 at v^2 = g R; then two bounces alternate."""
    P = gz.collision_map(bowl(radius=2.0, rho=0.25, r=0.5, V=0.4, g=1.5))
    found = gz.periodic_orbits(P, word="(bowl)", starts=200)
    assert [one.stable or one.neutral for one in found].count(True) == 1 and len(found) == 3  # and on either end
    orbit = next(one for one in found if one.neutral)
    assert orbit.along[0] % (2 * np.pi) == pytest.approx(1.5 * np.pi)
    tried = []  # no torus, although two multipliers have the product 1 all along, but for the sign of rounding
    monkeypatch.setattr(events, "located", lambda *given: (tried.append(given[4]), located(*given))[1])
    branch = gz.continuation(P, orbit, "bowl.V", (0.1, 1.5))
    (doubling,) = branch.special
    assert tried == ["pd"]
    assert doubling.type == "pd" and doubling.low <= 0.5 * (1.5 * 1.75) ** 0.5 <= doubling.high and doubling.converged
    assert doubling.high - doubling.low < 1e-13
    other = gz.continuation(P, doubling, "bowl.V", (0.1, 1.5))
    assert {one.period for one in other} == {2} and len({round(x, 6) for x in list(other)[-1].along}) == 2


def test_multipliers_are_those_of_the_map_and_virtual_orbits_have_some_too():
    P = gz.collision_map(unit_cell(0.3))  # a ball without a radius between faces
    _multipliers_are_those_of(P, gz.periodic_orbits(P, (2, 3), starts=1))
    P = gz.collision_map(pinball())
    found = gz.periodic_orbits(P, (2, 3), starts=200, virtual=True)
    assert any(not orbit.admissible for orbit in found)
    _multipliers_are_those_of(P, found)


def _multipliers_are_those_of(P, found):
    for orbit in found:
        assert np.isfinite(orbit.multipliers).all()
        if orbit.admissible:
            J = np.eye(3)
            for state in orbit.points:
                J = P.jacobian(state) @ J
            roots = np.linalg.eigvals(J)
            np.testing.assert_allclose(np.sort(np.abs(roots)), np.sort(np.abs(orbit.multipliers)), rtol=1e-9)


def test_an_orbit_scales_with_its_kick():
    """Without gravity V > 0 sets the scale of speed only."""
    P = gz.collision_map(active_discs(3.0, V=0.5))
    (orbit,) = gz.periodic_orbits(P, word="ABC")
    branch = gz.continuation(P, orbit, "A.V", (0.1, 1.0))
    assert branch.complete and all(one.admissible for one in branch) and not branch.special
    equations, x = equations_of(orbit, ("A.V", "B.V", "C.V"))
    F, _J = equations.defects(np.where(np.arange(6) % 2 == 0, x, x / 3.0), np.full(3, 1.5))
    assert np.abs(F).max() < 1e-13


def test_an_impact_that_slides_off_its_wall_ends_the_branch():
    P = gz.collision_map(pinball())
    orbit = next(one for one in gz.periodic_orbits(P, word="P(ceiling)", starts=200) if one.admissible)
    branch = gz.continuation(P, orbit, "ceiling.x2", (-0.5, 4.0))
    assert branch.pieces[0].ends == ("bounds", "an impact has left ceiling at an end")
    assert branch.pieces[0].values[-1] == pytest.approx(2.0, abs=0.3)


def test_slopes_and_other_surfaces_are_those_of_the_table():
    P = gz.collision_map(pinball())
    orbit = next(one for one in gz.periodic_orbits(P, word="PQ", starts=200) if one.admissible)
    equations, x = equations_of(orbit, ("P.V", "tilt"))
    p, h = np.array([0.4, 0.2]), 1e-5
    D = [(equations.defects(x, p + h * e)[0] - equations.defects(x, p - h * e)[0]) / (2 * h) for e in np.eye(2)]
    np.testing.assert_allclose(equations.slopes(x, p), np.array(D).T, atol=1e-8)
    assert np.isnan(equations.defects(-x, p)[0]).all()
    with pytest.raises(gz.InputError, match="nothing"):
        equations_of(orbit, ("nothing",))


def test_at_a_graze_a_flight_just_touches_a_bumper_and_the_branch_goes_on_virtual():
    """A bumper is raised into a flight over it, with gravity; by a dense search on the flight the gap is 0."""
    P = gz.collision_map(pinball())
    orbit = next(one for one in gz.periodic_orbits(P, word="P(right)(left)", starts=100) if one.admissible)
    branch = gz.continuation(P, orbit, "Q.y", (6.0, 8.0))
    (graze,) = branch.special
    assert graze.type == "gr" and graze.converged and graze.admissible and branch.complete
    before, after = (branch.at(graze.value + shift)[0] for shift in (-1e-4, 1e-4))
    assert before.admissible and not after.admissible
    touching, g = graze.orbit, P.origin.table.gravity
    gaps = []
    for k in range(3):
        (x, y), (x1, y1) = touching.corners[k], touching.corners[(k + 1) % 3]
        T = touching.durations[k]
        t = np.linspace(0.0, T, 400_001)
        way = x + (x1 - x) * t / T, y + (y1 - y) * t / T + 0.5 * g * t * (T - t)
        gaps.append((np.hypot(way[0] - 4.0, way[1] - graze.value) - 0.6).min())
    assert abs(min(gaps)) < 1e-9


def up_and_down(thing, r=0.78, V=0.3):
    """A ball that rises by (V/(1 - r))^2/2 from the bottom of a bowl at -2, and something in its way."""
    P = gz.collision_map(gz.table([*bowl(r=r, V=V).objects, thing], tilt=0.5 * np.pi))
    (orbit,) = gz.periodic_orbits(P, word="(bowl)", starts=5)
    return orbit


def test_a_ball_without_a_radius_touches_a_lid():
    orbit = up_and_down(gz.segment("lid", (-1.0, -0.5), (1.0, -0.5), gz.newton(0.5)))
    (touch,) = (one for one in gz.continuation(orbit.map, orbit, "bowl.V", (0.28, 0.4)).special if one.type == "gr")
    assert touch.value == pytest.approx(0.22 * 3**0.5, rel=1e-12)


def test_the_outer_side_of_a_bowl_is_not_in_the_way_of_a_ball_inside():
    """It was the nearest to every flight that stays below the centre, and hid what was touched."""
    orbit = up_and_down(gz.disc("post", (0.5, -1.3), 0.2, gz.newton(0.5)))
    (touch,) = gz.continuation(orbit.map, orbit, "post.x", (0.15, 0.5)).special
    assert touch.type == "gr" and touch.value == pytest.approx(0.2, rel=1e-12)


def test_a_flight_through_the_centre_of_a_bowl_touches_nothing():
    """Just there the nearest place of the bowl is on the other side, and rounding says on which."""
    P = gz.collision_map(gz.table(bowl(radius=2e6, r=0.76, V=4.9e5).objects, g=5e5, tilt=0.5 * np.pi))
    (orbit,) = gz.periodic_orbits(P, word="(bowl)", starts=5)
    equations, x = equations_of(orbit, ("bowl.V",))
    for turned in np.arange(-3, 4) * np.spacing(x[0]):
        (dip,) = (one for one in equations.tests(x + np.array([turned, 0.0]), np.array([4.9e5])) if one.type == "gr")
        assert dip.value > 0.0
