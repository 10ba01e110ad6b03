import math

import numpy as np
import pytest

from grazing import theory
from grazing.outcome import OutsideForm

N = np.arange(60, 121)


def order(remainder):
    """Exponent per period of a remainder that falls geometrically."""
    assert np.all(remainder > 0)
    return np.polyfit(N, np.log(remainder), 1)[0]


@pytest.mark.parametrize("lam", [0.8, 0.85])
@pytest.mark.parametrize(("edge", "leading", "l", "share"), [
    (theory.mu_pd, theory.mu_pd_leading, 0.0, 1.0),
    (theory.mu_bc, theory.mu_bc_leading, 0.0, 1.0),
    (theory.mu_pd, theory.mu_pd_leading, 0.7, 1.0),
    (theory.mu_bc, theory.mu_bc_leading, 0.7, 0.5),
])  # fmt: skip
def test_order_of_the_remainder(edge, leading, l, share, lam):
    remainder = edge(N, lam, l) / leading(N, lam, l) - 1
    assert order(remainder) == pytest.approx(share * math.log(lam), rel=0.01)


@pytest.mark.parametrize(("lam", "l"), [(0.8, 0.7), (0.9, 2.0), (0.85, 0.1)])
def test_coefficient_of_the_remainder(lam, l):
    n = 100
    doubling = theory.mu_pd(n, lam, l) / theory.mu_pd_leading(n, lam, l) - 1
    assert doubling == pytest.approx((1 + 3 / (4 * l * lam)) * lam**n, rel=1e-3)
    collision = theory.mu_bc(n, lam, l) / theory.mu_bc_leading(n, lam, l) - 1
    assert collision == pytest.approx(math.sqrt((1 - lam) / l) * lam ** ((n - 2) / 2), rel=0.03)
    assert theory.mu_pd(n, lam, 0.0) / theory.mu_pd_leading(n, lam, 0.0) - 1 == pytest.approx(lam**n, rel=1e-3)
    assert theory.mu_bc(n, lam, 0.0) / theory.mu_bc_leading(n, lam, 0.0) - 1 == pytest.approx(
        2 * lam ** (n - 1), rel=1e-3
    )


@pytest.mark.parametrize(
    ("lam", "l", "share", "first"), [(0.8, 0.7, 0.5, 80), (0.9, 0.8, 0.5, 160), (0.6, 0.0, 1.0, 20)]
)
def test_width_ratio_tends_to_lam_slowly_and_to_its_square_without_a_gap(lam, l, share, first):
    limit = lam if l > 0 else lam**2
    here, later = (abs(theory.width_ratio(n, lam, l) / limit - 1) for n in (first, first + 20))
    assert math.log(later / here) / 20 == pytest.approx(share * math.log(lam), rel=0.05)
    assert theory.width_ratio(250, lam, l) == pytest.approx(limit, rel=1e-4)


def test_width_ratio_needs_two_finite_windows():
    with pytest.raises(OutsideForm, match=r"no width ratio at lam = 0.9, l = 0.0: the window of N = 4 is empty"):
        theory.width_ratio(3, 0.9, 0.0)
    with pytest.raises(OutsideForm, match="the window of N = 1 is infinitely wide"):
        theory.width_ratio(1, 0.9, 0.4)


def test_scalars_give_floats():
    assert isinstance(theory.mu_pd_leading(3, 0.5, 1.0), float)
    assert isinstance(theory.mu_bc_leading(3, 0.5, 0.0), float)
