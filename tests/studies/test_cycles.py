import numpy as np
import pytest

import grazing as gz
from grazing import theory
from grazing.studies.cycles import NoTangent, approaches, find_cycle

TOLERANCE = np.array([1e-12])


@pytest.mark.parametrize(("N", "lam", "l"), [(2, 0.5, 0.1), (3, 0.8, 1.0), (4, 0.34, 0.21), (5, 0.9, 0.8)])
def test_newton_finds_the_maximal_orbit_and_its_multiplier(N, lam, l):
    low, high = theory.mu_pd(N, lam, l), theory.mu_bc(N, lam, l)
    mu = low + 0.3 * (high - low)
    exact = np.asarray(theory.maximal_orbit(N, lam, mu, l))
    letters = np.array([0] * (N - 1) + [1])
    cycle = find_cycle(gz.gap_map(lam, mu, l), np.array([exact[0] * (1 + 1e-3)]), letters, TOLERANCE)
    assert np.allclose(cycle.points[:, 0], exact, rtol=1e-10, atol=1e-13)
    assert cycle.radius == pytest.approx(abs(theory.multiplier(N, lam, mu, l)), rel=1e-9)


def test_newton_finds_unstable_cycles_too():
    mu = theory.mu_pd(3, 0.5, 0.1) - 1e-3
    exact = np.asarray(theory.maximal_orbit(3, 0.5, mu, 0.1))
    cycle = find_cycle(gz.gap_map(0.5, mu, 0.1), exact[:1], np.array([0, 0, 1]), TOLERANCE)
    assert 1.0 < cycle.radius < 1.1
    points = np.tile(exact, 5)[:, None, None]
    assert not approaches(cycle, points, np.tile([0, 0, 1], 5)[:, None], TOLERANCE[:, None]).any()


def test_a_shorter_cycle_or_other_letters_are_refused():
    G = gz.gap_map(0.8, 0.5, 1.0)
    exact = np.asarray(theory.maximal_orbit(3, 0.8, 0.5, 1.0))
    assert find_cycle(G, exact[:1], np.array([0, 0, 1, 0, 0, 1]), TOLERANCE) is None
    assert find_cycle(G, exact[:1], np.array([0, 1, 0]), TOLERANCE) is None


def test_no_tangent_at_the_orbit_is_said():
    G = gz.gap_map(0.8, 0.5, 1.0)
    with pytest.raises(NoTangent):
        find_cycle(G, np.array([0.0]), np.array([1]), TOLERANCE)  # the slope is infinite at 0


def test_a_spiral_approaches_although_its_coordinates_do_not_shrink_every_time():
    # a rotation by 1 rad in a skew frame: the plain distance grows in some steps, the one in eigenvectors never
    def step(state, p):
        x, y = state
        c, s = 0.99 * 0.5403023058681398, 0.99 * 0.8414709848078965
        return c * x - 5.0 * s * y, s / 5.0 * x + c * y

    P = gz.Map(step, params={"a": 1.0}, coordinates=("x", "y"), box=((-1.0, 1.0), (-1.0, 1.0)))
    points, letters, _ = P.run(np.array([[0.7, 0.2], [0.1, -0.4]]), 0, 40)
    lengths = np.linalg.norm(points, axis=1)
    assert (np.diff(lengths, axis=0) > 0).any()
    cycle = find_cycle(P, points[-1, :, 0], np.array([0]), np.full(2, 1e-12))
    assert cycle.radius == pytest.approx(0.99, abs=1e-6)
    assert np.abs(cycle.points).max() < 1e-9
    assert approaches(cycle, points, letters, np.full((2, 2), 1e-12)).all()
    assert not approaches(cycle, points[::-1], letters, np.full((2, 2), 1e-12)).any()
