"""Studies of one oscillator in units that are powers of two: what has no unit is the same to the last bit."""

import numpy as np
import pytest

import grazing as gz


def measured(L, T):
    """What studies say of a chaotic ball whose unit of length is L and of time T, without units."""
    S, F = L / T, L / T**2
    push = gz.Forcing(2.8 / T, offset=0.1 * F, cos=(F,))
    P = gz.stroboscopic_map(gz.Oscillator(0.3 / T, 1.0 / T, push, gz.newton(0.95)))
    forces, same = np.array([0.1, 0.16, 0.3]) * F, {"transient": 60, "arithmetic": "strict"}
    starts = np.array([[0.1, 0.2], [0.5, -0.3], [0.02, 0.0]]) * (L, S)
    exponents = gz.lyapunov(P, "offset", forces, starts=starts, steps=60, **same)
    chart = gz.chart(P, {"offset": forces, "r": [0.9, 0.95]}, starts=starts, exponent_steps=60, **same)
    found = gz.coexistence(P, "offset", forces, starts=starts, **same)
    count = gz.density(P, "offset", forces, starts=starts, bins=40, keep=40, **same)["count"]
    curve = gz.grazing_curve(P.model, preimages=1, points=200)
    return [
        exponents.exponent.values, exponents.exponent_per_time.values * T, chart.exponent.values, chart.period.values,
        found.lifetime.values, found.share.values, count.values, curve.graze.values / (L, S), curve.order.values,
    ]  # fmt: skip


PLAIN = measured(1.0, 1.0)


@pytest.mark.parametrize(("a", "b"), [(20, 0), (0, 20), (0, -20), (17, -13), (-19, 20)])
def test_studies_in_units_of_powers_of_two(a, b):
    for one, other in zip(PLAIN, measured(2.0**a, 2.0**b), strict=True):
        assert one.shape == other.shape and np.allclose(one, other, rtol=1e-9, atol=1e-9, equal_nan=True)
