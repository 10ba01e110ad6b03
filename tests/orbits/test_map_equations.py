"""Orbits of impact maps of systems of one's own in a parameter: points lie on surfaces that bend and move."""

from copy import copy

import numpy as np
import pytest

import grazing as gz
from grazing.maps.impact_of_system import TimedReturned
from grazing.orbits import map_equations, path
from grazing.orbits.map_equations import alike, product
from tests.systems.balls import bouncing

TABLE = {"A": 0.1, "r": 0.7, "height": 0.8}


@pytest.fixture(scope="module")
def orbits():
    """Short orbits between a vibrating table and a ceiling, by their words."""
    P = gz.impact_map(bouncing(**TABLE))
    return {one.word: one for one in gz.periodic_orbits(P, period=[1, 2], starts=60, threads=1)}


@pytest.mark.parametrize(("name", "bounds"), [("A", (0.05, 0.2)), ("r", (0.5, 0.9)), ("height", (0.78, 0.9))])
def test_an_orbit_between_surfaces_is_followed_through_points_that_lie_inside_one(orbits, name, bounds):
    """Along a tangent its points leave the curved table, to either side: there the equations go on smoothly.

    Each of the two impacts takes r twice of a volume in phase space: of the velocity, and of the distance between
    neighbours that hit one after the other. In the three coordinates of a point on a surface one multiplier is 0.
    """
    orbit = orbits["1A2A"]
    branch = gz.continuation(orbit.map, orbit, name, bounds)
    assert branch.complete and not any("lost" in piece.ends for piece in branch.pieces)
    grazes = [one.orbit for one in branch.special if one.type == "gr"]
    for one in branch:
        assert abs(one.multipliers[:2].prod() / one.map.params["r"] ** 4 - 1.0) < 1e-9
        if one.admissible and not any(np.array_equal(one.points, graze.points) for graze in grazes):
            again = one.map.orbit(one.points[0] + np.array([0.0, 1e-13, 0.0]), 2)
            assert np.abs(again.points[2, 1:] - one.points[0, 1:]).max() < 1e-9 * np.abs(one.multipliers).max()


def test_no_path_is_followed_without_end_where_steps_stay_too_short(orbits, monkeypatch):
    """Where no flight begins inside a surface each tangent leaves the piece at once, and no end is found there."""

    def refusing(self):
        found = copy(self)
        found.check = lambda state, params: None
        return found

    tried = []

    def counted(*args, advanced=path.advanced):
        tried.append(1)
        return advanced(*args)

    monkeypatch.setattr(TimedReturned, "eased", refusing)
    monkeypatch.setattr(path, "FEWEST", 100)
    monkeypatch.setattr(path, "advanced", counted)
    branch = gz.continuation(orbits["1A2A"].map, orbits["1A2A"], "A", (0.05, 0.2), limit=5)
    assert not branch.complete and len(tried) <= 2 * 100 + 10


@pytest.mark.parametrize("name", ["A", "r"])
def test_an_impact_that_crosses_the_strobe_is_no_border_collision(orbits, name):
    """There a phase comes round from a period to 0, and two words name one branch, the same from either."""
    bounds = {"A": (0.05, 0.2), "r": (0.5, 0.9)}[name]
    branches = [gz.continuation(orbits[word].map, orbits[word], name, bounds) for word in ("A1B", "1AB")]
    found = [sorted((one.type, one.value) for one in branch.special) for branch in branches]
    assert [type for type, _value in found[0]] == ["lp", "pd"] == [type for type, _value in found[1]]
    np.testing.assert_allclose(*([value for _type, value in one] for one in found), rtol=1e-11)
    for branch, (before, after) in zip(branches, [("A1B", "1AB"), ("1AB", "A1B")], strict=True):
        (one,) = branch.relabellings
        assert (one.before, one.after) == (before, after)
    assert abs(branches[0].relabellings[0].value - branches[1].relabellings[0].value) < 1e-11


def test_where_rounding_hides_how_an_impact_loses_its_speed_its_graze_has_not_converged(orbits):
    """The orbit without this impact touches the ceiling at the same place, and that is found to rounding."""
    free = gz.continuation(orbits["2A"].map, orbits["2A"], "omega", (5.0, 8.0))
    (touch,) = (one for one in free.special if one.type == "gr")
    hits = gz.continuation(orbits["1A1B"].map, orbits["1A1B"], "omega", (5.0, 8.0))
    (end,) = (one for one in hits.special if one.type == "gr")
    assert touch.converged
    assert not end.converged and end.low <= touch.value <= end.high and end.high - end.low < 1e-5


def test_a_point_next_to_zero_is_no_warning():
    """Its part of the box is beyond doubles."""
    assert not alike(np.array([1e10]), np.array([[5e-324], [1.0]]))


def test_derivatives_beyond_all_doubles_are_not_known_and_warn_of_nothing():
    turn = product(np.array(2 * [[[1e200, 1.0], [0.0, -1e200]]]))
    assert np.isinf(turn[0, 0]) and np.isnan(map_equations.tests_of(turn)).all()
