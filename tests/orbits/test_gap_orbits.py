"""All orbits of the gap map of one period: residuals by the map itself, completeness by iteration, doubled orbits."""

import math

import numpy as np
import pytest

import grazing as gz
from grazing.orbits.gap_orbits import gap_orbits

CASES = [(0.9, 0.3, 0.4), (0.8, 0.5, 1.0), (0.5, 0.05, 0.1), (0.342, 0.023, -0.668), (-0.4, 0.6, 0.2), (1.2, 0.1, 0.3)]


@pytest.mark.parametrize(("lam", "mu", "l"), CASES)
def test_admissible_orbits_are_cycles_of_the_map(lam, mu, l):
    G = gz.gap_map(lam=lam, mu=mu, l=l)
    admissible = 0
    for period in range(1, 9):
        for orbit in gap_orbits(G, period):
            assert orbit.map is G and orbit.period == period and orbit.points.shape == (period, 1)
            assert period % len(orbit.word) == 0 and orbit.residual < 1e-11
            letters = "".join("L" if x < 0 else "R" for x in orbit.points[:, 0])
            assert orbit.admissible == (letters == orbit.word * (period // len(orbit.word)))
            if not orbit.admissible:
                continue
            admissible += 1
            for here, after in zip(orbit.points, np.roll(orbit.points, -1, axis=0), strict=True):
                assert G(here)[0] == pytest.approx(after, abs=1e-10)
            turn = math.prod(float(G.jacobian(x)[0, 0]) for x in orbit.points)
            assert orbit.multipliers[0].real == pytest.approx(turn, rel=1e-6)
            assert orbit.condition == pytest.approx(1 / abs(1 - turn), rel=1e-5)
            # least period: no shorter shift repeats the points
            assert all(abs(orbit.points - np.roll(orbit.points, -n, axis=0)).max() > 1e-9 for n in range(1, period))
    assert admissible > 0


@pytest.mark.parametrize(("lam", "mu", "l"), CASES)
def test_periods_are_all_sign_changes_of_the_iterated_map(lam, mu, l):
    # f^n(x) - x on a fine grid: between two grid points of one itinerary the iterate is continuous
    G = gz.gap_map(lam=lam, mu=mu, l=l)
    x = np.linspace(-3.0, 3.0, 400_001)
    y, letters = x.copy(), np.zeros(x.size, dtype=int)
    for n in range(1, 6):
        letters = 2 * letters + (y >= 0)
        y = np.where(y < 0, lam * y + mu, mu - l - np.sqrt(np.maximum(y, 0)))
        crossed = np.flatnonzero((letters[1:] == letters[:-1]) & ((y - x)[1:] * (y - x)[:-1] <= 0))
        seen = np.sort(x[crossed])
        divisors = [d for d in range(1, n + 1) if n % d == 0]
        mine = [p for d in divisors for o in gap_orbits(G, d) if o.admissible for p in o.points[:, 0]]
        mine = np.sort([p for p in mine if -3 < p < 3])
        for p in seen:
            assert np.abs(mine - p).min() < 1e-4, (n, p)


def test_a_doubled_orbit_is_an_orbit_of_its_own():
    low, high = gz.theory.doubled_interval(3, 0.8, 1.0)
    mu = 0.5 * (low + high)
    G = gz.gap_map(lam=0.8, mu=mu, l=1.0)
    (single,) = [o for o in gap_orbits(G, 3) if o.word == "LLR"]
    (double,) = [o for o in gap_orbits(G, 6) if o.word == "LLR"]
    assert single.stable and single.period == 3
    assert not double.stable and double.period == 6 and double.admissible
    assert double.points[:, 0] == pytest.approx(gz.theory.doubled_orbit(3, 0.8, mu, 1.0), rel=1e-9)
    assert double.multipliers[0] == pytest.approx(gz.theory.doubled_multiplier(3, 0.8, mu, 1.0), rel=1e-9)


def test_the_gap_map_of_a_normal_form_will_do():
    G = gz.normal_form(gz.pinball(V=0.2), "d").gap_map(0.12)
    assert any(o.stable and o.admissible for n in range(1, 7) for o in gap_orbits(G, n))


@pytest.mark.parametrize(
    ("call", "error", "said"),
    [
        (lambda: gap_orbits(gz.stroboscopic_map(gz.pinball()), 2), gz.InputError, "give a gap map"),
        (lambda: gap_orbits(gz.gap_map(lam=0.5, mu=0.1, l=0.1), 0), gz.InputError, "period = 0"),
        (lambda: gap_orbits(gz.gap_map(lam=1.0, mu=0.1, l=0.1), 1), gz.OutsideForm, "in families or not at all"),
    ],
)
def test_error_texts(call, error, said):
    with pytest.raises(error, match=said):
        call()
