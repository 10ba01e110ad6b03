"""What an object says of itself fits a screen, however much it holds, and is short for what is short."""

import inspect
from pathlib import Path

import numpy as np
import pytest

import grazing as gz
from grazing.orbits.branch_search import Piece
from grazing.orbits.locus import Meeting
from grazing.orbits.periodic import Searched
from grazing.orbits.special import Special
from grazing.proof.gap import GapProof
from grazing.sweep import Difference, Verified
from grazing.theory.words import WordOrbit

#: 25 lines of 80 characters.
SCREEN = 2000
MANY = 1000
LONG = "L" * (MANY - 1) + "R"


def _step(state, p):
    return state


def _flight(t, t0, state, p):
    return state


def _gap(t, state, p):
    return state


def _bound(t, w, state, p):
    return 0.0


def all_sorts():
    """One of each public class, with a thousand of whatever it can hold."""
    numbers = tuple(1.0 / (i + 1) for i in range(MANY))
    forcing = gz.Forcing(2.2, cos=numbers, sin=numbers)
    ball = gz.Oscillator(3.0, 1.0, forcing, gz.active(0.8, 0.4))
    flown = gz.Oscillator(3.0, 1.0, gz.Forcing(2.2, cos=numbers[:200]), gz.active(0.8, 0.4))
    law = gz.reset(lambda v, p: -p.a0 * v, **{f"a{i}": 0.5 for i in range(MANY)})
    names = [f"a{i}" for i in range(MANY)]
    P = gz.Map(_step, params=dict.fromkeys(names, 1.0), coordinates=("x",), box=((0.0, 1.0),), name="map of thousands")
    surface = gz.Surface("A", _gap, _bound, lambda t, state, p: state)
    system = gz.System(("x",), ("v",), dict.fromkeys(names, 1.0), _flight, (surface,), ((0.0, 1.0),) * 2)
    points, one = np.zeros((MANY, 1)), np.zeros(1)
    orbit = gz.Orbit(
        map=P, word=LONG, period=MANY, points=points, multipliers=one, condition=1.0, residual=0.0, admissible=True
    )
    beyond = gz.PieceOrbit(
        map=P, word=LONG, period=MANY, points=points, multipliers=one, condition=1.0, residual=0.0, admissible=False,
        letters=(0,) * MANY, margins=np.linspace(-1.0, 1.0, MANY),
    )  # fmt: skip
    orbits = (orbit,) * MANY
    searched = Searched(tuple(range(1, 3 * MANY, 3)), 1, 1, 1, 1, ((1, 1),) * MANY, 0, False, 0)
    special = Special("lp", 0.5, 0.5, 0.5, True, orbit, True, -1, 0)
    meeting = Meeting("gr+lp", (0.1, 0.2), orbit, True)
    piece = Piece(None, points, np.zeros(MANY), orbits, (), (), ("lp", "gr"))
    grid = np.linspace(0.0, 1.0, MANY)
    difference = Difference("u", 1, tuple(range(MANY)), "here", "other bits")
    ends = (0.0, 1.0)
    return {
        "Forcing": forcing, "Oscillator": ball, "Reset": law, "Map": gz.stroboscopic_map(flown), "own Map": P,
        "Orbit": orbit, "PieceOrbit": beyond, "Searched": searched,
        "Orbits": gz.periodic_orbits(gz.gap_map(0.8, 0.5, 1.0), 3),
        "many Orbits": type(gz.periodic_orbits(gz.gap_map(0.8, 0.5, 1.0), 3))(orbits, P, LONG, searched),
        "Special": special, "Meeting": meeting, "Piece": piece,
        "Branch": gz.Branch(P, "a0", ends, (piece,) * MANY, (special,) * MANY, ()),
        "Locus": gz.Locus("lp", ("a0", "a1"), (ends, ends), np.zeros((MANY, 2)), orbits, (meeting,) * MANY, ("", "")),
        "WordOrbit": WordOrbit(LONG, np.zeros(MANY), numbers, 0.5, True, 0.0),
        "GapProof": GapProof(True, "proven", {"data": {"points": list(numbers)}, "kind": "orbit"}),
        "Certificate": gz.Certificate(True, "proven", "", {"data": list(numbers)}, "periodic orbit"),
        "Difference": difference,
        "Verified": Verified(9, tuple(range(MANY)), (difference,) * MANY, True, tuple(range(MANY)), Path("a.zarr")),
        "Plan": gz.plans.chart(gz.gap_map(0.8, 0.5, 1.0), {"mu": grid, "l": grid}),
        "NormalForm": gz.normal_form(gz.pinball(), "d"),
        "Attractor": gz.Attractor(0.1, LONG, MANY, 1.0), "Surface": surface, "System": system,
    }  # fmt: skip


SORTS = all_sorts()


@pytest.mark.parametrize("name", SORTS)
def test_it_fits_a_screen(name):
    said = repr(SORTS[name])
    assert len(said) <= SCREEN or (said.count("\n") < 40 and name == "trajectory")
    assert len(str(SORTS[name])) == len(said) or name in ("Verified", "Difference")


def test_no_public_class_is_left_out():
    classes = {name for name in gz.__all__ if inspect.isclass(getattr(gz, name))}
    plain = {"GrazingError", "InputError", "OutsideForm", "UserCodeError", "Outcome", "Trust"}  # say their own text
    tried = {type(one).__name__ for one in SORTS.values()}
    assert classes - plain - {"ImpactOrbit", "BounceOrbit"} <= tried
    assert issubclass(gz.ImpactOrbit, gz.Orbit) and issubclass(gz.BounceOrbit, gz.Orbit)


def test_what_is_left_out_is_counted():
    assert "and 992 more" in repr(SORTS["Forcing"]) and "(1000 characters)" in repr(SORTS["Orbit"])
    assert repr(SORTS["own Map"]).startswith("<Map map of thousands: (x); a0=1, a1=1") and "984 more" in repr(
        SORTS["own Map"]
    )


def test_what_is_short_is_said_whole():
    forcing = gz.Forcing(2.2, cos=(1.0,))
    assert repr(forcing) == "Forcing(omega=2.2, t0=0.0, offset=0.0, cos=(1.0,), sin=(0.0,))"
    assert eval(repr(forcing), {"Forcing": gz.Forcing}) == forcing
    two = gz.Forcing(2.2, cos=(1.0, 0.5))
    assert eval(repr(two), {"Forcing": gz.Forcing}) == two


def test_objects_that_look_alike_are_still_told_apart():
    one, other = (gz.Forcing(2.2, cos=(*[1.0] * 20, last)) for last in (0.1, 0.2))
    a, b = (gz.Oscillator(3.0, 1.0, forcing, gz.newton(0.8)) for forcing in (one, other))
    assert repr(a) == repr(b) and a != b and len({a, b}) == 2
