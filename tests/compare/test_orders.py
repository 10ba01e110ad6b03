"""An order is the slope in logarithms, with an uncertainty that covers scatter and drift."""

import numpy as np
import pytest

from grazing.compare.orders import expected, fitted

D = 0.3 ** np.arange(1, 7)


@pytest.mark.parametrize("order", [0.5, 1.0, 1.5, 3.0])
def test_a_power_has_its_order(order):
    q, error = fitted(D, 0.2 * D**order)
    assert q == pytest.approx(order, abs=1e-12)
    assert error < 1e-11


def test_the_uncertainty_covers_a_second_term():
    for share in (0.3, 3.0, 30.0):
        q, error = fitted(D, D**1.5 * (1.0 + share * D))
        assert 0.0 < abs(q - 1.5) <= 3.0 * error


def test_the_uncertainty_covers_noise():
    noise = np.exp(0.1 * np.random.default_rng(2).standard_normal((200, len(D))))
    found = np.array([fitted(D, D**2 * one) for one in noise])
    assert (np.abs(found[:, 0] - 2.0) <= 2.0 * found[:, 1]).mean() > 0.9


def test_what_theory_expects():
    rungs = ("gap", "linearised", "lowest", "full", "corrected")
    assert [expected(rung, "gr", True, False) for rung in rungs] == [1.0, 2.0, 1.5, 1.5, 2.0]
    assert [expected(rung, "pd", True, True) for rung in rungs] == [1.0, 2.0, 2.0, 2.0, 3.0]
    assert [expected(rung, "pd", False, False) for rung in rungs] == [1.0, 2.0, 1.5, 1.5, 2.0]
    assert expected("corrected", "gr", False, True) == 1.5
    assert np.isnan([expected("flow", "gr", True, True), expected("gap", "lp", True, True)]).all()
