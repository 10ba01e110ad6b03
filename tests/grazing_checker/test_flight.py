"""The bound on what series leave out holds where it is large: with few terms, against the same flights with all."""

import random

import pytest

from grazing_checker.balls import around, double, number, pi, precision
from grazing_checker.flight import Checked, Motion, Path, transition
from tests.examples import examples

SCALARS = ("alpha", "k2", "omega", "t0", "offset", "sigma")


def motion(rng):
    """Any motion, and its derivatives by one of its parameters."""
    count = rng.randint(1, 3)
    scalars = [rng.uniform(-1, 1) for _ in SCALARS]
    scalars[2] = rng.uniform(0.3, 2)
    waves = [[double(rng.uniform(-1, 1)) for _ in range(count)] for _ in range(2)]
    unknown = rng.choice([*SCALARS, *(f"{kind}{j + 1}" for kind in ("cos", "sin") for j in range(count))])
    return Motion(*map(double, scalars), *waves, {unknown: number(1)})


@pytest.mark.parametrize("terms", [3, 4, 6, 10])
@pytest.mark.parametrize("seed", range(examples(25)))
def test_a_flight_of_few_terms_holds_that_of_all(seed, terms):
    rng = random.Random(seed)
    m, t, y, v = motion(rng), *(double(rng.uniform(-2, 2)) for _ in range(3))
    L, slopes = double(rng.uniform(0.2, 3)), (double(rng.uniform(-1, 1)), double(rng.uniform(-1, 1)))
    with precision(256):
        all_of_it, few = Checked(m, sensitive=True), Checked(m, sensitive=True)
        few.K = terms
        right, found = Path(all_of_it, t, y, v, L, slopes), Path(few, t, y, v, L, slopes)
        for one, two in zip(
            (found.y, found.v, found.dy, found.dv), (right.y, right.v, right.dy, right.dv), strict=True
        ):
            assert one.contains(two)
        for _ in range(4):
            s = double(rng.uniform(0, 1)) * L
            for order in range(3):
                assert found.at(s, order).contains(right.at(s, order))
                here = around(s, found.h / 8)
                assert found.at(here, order).contains(right.at(s, order))
        for one, two in zip(transition(few, L), transition(all_of_it, L), strict=True):
            assert one.contains(two)


@pytest.mark.parametrize("quarter", [0, 1, 2])
@pytest.mark.parametrize("wave", ["cos1", "sin1"])
@pytest.mark.parametrize("unknown", [*SCALARS, "cos1", "sin1"])
def test_a_flight_that_begins_at_rest_has_a_rest_all_the_same(unknown, wave, quarter):
    """Its first terms are 0, or those of its derivative: what follows is bounded by the force alone."""
    with precision(256):
        scalars = {name: number(0) for name in SCALARS} | {"k2": number(1), "omega": number(1)}
        waves = [[number(int(wave == name))] for name in ("cos1", "sin1")]
        m = Motion(*scalars.values(), *waves, {unknown: number(1)})
        all_of_it, few = Checked(m, sensitive=True), Checked(m, sensitive=True)
        few.K = 3
        t, L = quarter * pi() / 2, number(1, -1)  # one step
        for y, v in ((m.force(t), number(0)), (number(0), number(1)), (number(1), number(0))):
            right, found = Path(all_of_it, t, y, v, L), Path(few, t, y, v, L)
            for one in ("y", "v", "dy", "dv"):
                assert getattr(found, one).contains(getattr(right, one)), one
