"""Finders: the origin of a map names what finds its periodic orbits, so that a system brings its own."""

import numpy as np
import pytest

import grazing as gz
from grazing.maps.origin import Origin
from grazing.orbits.finder import Finder, Looked, Tally, counted, finder_of, ranged
from tests.models import MODELS


class Turned(Origin):
    """The origin of a rotation, whose orbits are known."""

    finder = f"{__name__}:Known"


class Known(Finder):
    """Knows that a rotation by 1/n of a turn has orbits of period n only, from every point."""

    longest, why = 3, "each point has one"

    def find(self, wanted):
        P = self.P
        n = round(1.0 / P.params["share"])
        points = P.iterate((0.1,), n)[:-1]
        one = gz.Orbit(
            map=P, points=points, word="L", period=n, multipliers=np.ones(1, complex), admissible=True, condition=1.0,
            residual=0.0,
        )  # fmt: skip
        return Looked([one] if n in wanted.periods else [], Tally(attempts=7), 0, complete=True)

    def of_many(self, orbit):
        return True


def turn(state, p):
    x = state[0] + p.share
    return ((x - 1.0 if x >= 1.0 else x),), 0


def rotation():
    return gz.Map(turn, params={"share": 0.5}, box=((0.0, 1.0),), letters="L", origin=Turned())


def test_an_origin_brings_its_own_finder():
    found = gz.periodic_orbits(rotation(), 2)
    assert [one.period for one in found] == [2]
    assert found.searched.complete
    assert found.searched.attempts == 7
    assert found.searched.continua == (("L", 2, 1),)
    assert found.statement.endswith("these are all, because each point has one")
    with pytest.raises(gz.InputError, match="allowed are periods up to 3"):
        gz.periodic_orbits(rotation(), 4)


@pytest.mark.parametrize(
    ("P", "name"),
    [
        (gz.stroboscopic_map(MODELS["standard"]), "Sections"),
        (gz.impact_map(MODELS["standard"]), "Sections"),
        (gz.discontinuity_map(MODELS["standard"]), "Steps"),  # it comes near the oscillator only
        (gz.gap_map(lam=0.8, mu=0.5, l=1.0), "Words"),
        (gz.collision_map(gz.table([gz.disc("a", (0.0, 0.0), 1.0, gz.newton(1.0))])), "Bounced"),
    ],
)  # fmt: skip
def test_maps_that_ship_name_theirs(P, name):
    assert type(finder_of(P)).__name__ == name


def test_words_of_statements():
    assert (counted(1, "orbit"), counted(0, "orbit")) == ("1 orbit", "0 orbits")
    assert (ranged((1, 2, 3)), ranged((1, 2)), ranged((1, 3, 5))) == ("1 to 3", "1, 2", "1, 3, 5")
