"""The check of tables passes what is right, and finds what is planted."""

import numpy as np
import pytest

import grazing as gz
from grazing.billiard import check as module
from grazing.billiard.flown import NEXT, TIME
from tests.billiard.tables import ELASTIC, box, layout, mixed


@pytest.mark.parametrize("rho", [0.0, 0.25])
def test_right_tables_pass(rho):
    gz.testing.check_table(mixed(rho), states=2, seed=1)
    gz.testing.check_table(gz.table(layout(3), rho=rho), states=4)


@pytest.mark.parametrize(
    ("plant", "said"),
    [
        (lambda flights: flights[0].__setitem__(TIME, flights[0][TIME] * 1.001), "exact is"),
        (lambda flights: flights[0].__setitem__(1, 1.0), "ends at surface 1; exact is"),
        (lambda flights: flights[0].__setitem__(NEXT, flights[0][NEXT] + 1e-3), "away from it"),
        (
            lambda flights: flights[0].__setitem__(NEXT + 2, 3.0 + flights[0][NEXT + 2]),
            "changes the square of the speed",
        ),
    ],
)
def test_what_is_planted_is_found(monkeypatch, plant, said):
    found = module.flights_of

    def planted(*args):
        flights = found(*args)
        plant(flights)
        return flights

    monkeypatch.setattr(module, "flights_of", planted)
    with pytest.raises(AssertionError, match=said):
        gz.testing.check_table(mixed(0.25), states=1)


def test_an_object_that_is_not_met_is_found(monkeypatch):
    """Geometry that the rows of a table do not have: a ball flies through it."""
    table = gz.table([gz.disc("A", (0, 0), 1.0, ELASTIC), gz.disc("B", (3, 0), 1.0, ELASTIC)])
    shown = type(table).distances
    monkeypatch.setattr(
        type(table), "distances", lambda self, x, y, t=0.0: shown(self, x, y, t) | {"B": np.hypot(x, y - 2.0) - 1.0}
    )
    with pytest.raises(AssertionError, match=r"misses B|ends at B, but"):
        for seed in range(9):
            gz.testing.check_table(table, states=4, seed=seed)


def test_a_ball_that_fits_nowhere_is_refused():
    with pytest.raises(gz.InputError, match="fits nowhere among the objects"):
        gz.testing.check_table(gz.table(box(1.0, 3.0), rho=0.6))
    with pytest.raises(gz.InputError, match=r"give gz\.table"):
        gz.testing.check_table(gz.pinball())
