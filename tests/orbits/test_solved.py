"""Orbits along a path: made when they are asked for, each once, and the same as those of the equations."""

import copy
import pickle

import pytest

import grazing as gz
from grazing.copies import alike
from grazing.orbits.impact_equations import ImpactEquations


@pytest.fixture
def made(monkeypatch):
    """The solutions of which orbits were made."""
    calls, orbit = [], ImpactEquations.orbit

    def counted(self, x, p):
        calls.append(x)
        return orbit(self, x, p)

    monkeypatch.setattr(ImpactEquations, "orbit", counted)
    return calls


def followed():
    orbit = gz.one_impact_orbits(gz.pinball(d=0.11, V=0.4), 3)[0]
    return gz.continuation(orbit.map, orbit, "d", (0.09, 0.13))


def test_following_makes_the_orbits_of_special_points_only(made):
    branch = followed()
    (piece,) = branch.pieces
    assert len(piece.orbits) > 30 and len(made) == 1 + len(branch.special)  # and the first
    curve = gz.locus(branch.special[0], ("d", "V"), ((0.0, 0.14), (0.2, 0.6)))
    assert len(curve.orbits) > 10 and len(made) == 1 + len(branch.special) + len(curve.meetings)


def test_an_orbit_is_made_once_and_is_that_of_the_equations(made):
    branch = followed()
    (piece,) = branch.pieces
    before, middle = len(made), len(piece.orbits) // 2
    assert piece.orbits[middle] is piece.orbits[middle] and len(made) == before + 1
    assert alike(piece.orbits[middle], piece.equations.orbit(piece.unknowns[middle], piece.values[middle : middle + 1]))
    assert list(branch) == list(piece.orbits) == list(piece.orbits[:])
    assert piece.orbits[-1] is piece.orbits[len(piece.orbits) - 1] and piece.orbits[1:3] == tuple(piece.orbits)[1:3]
    with pytest.raises(IndexError):
        piece.orbits[len(piece.orbits)]


def test_copies_of_a_curve_have_the_same_orbits():
    branch = followed()
    curve = gz.locus(branch.special[0], ("d", "V"), ((0.0, 0.14), (0.2, 0.6)))
    for copied in (pickle.loads(pickle.dumps(curve)), copy.copy(curve), copy.deepcopy(curve)):
        assert copied == curve and list(copied.orbits) == list(curve.orbits)
    assert curve.orbits != tuple(curve.orbits)[:1] and repr(curve.orbits).startswith("(<ImpactOrbit 001")


def test_what_equations_have_kept_of_their_work_makes_no_difference():
    P = gz.gap_map(0.8, 0.5, 1.0)
    branches = [gz.continuation(P, gz.periodic_orbits(P, 2)[0], "mu", (0.4, 0.6)) for _ in range(2)]
    assert branches[0].at(0.45) and branches[0] == branches[1]
