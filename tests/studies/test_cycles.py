"""The cycle beside an orbit: matrices, Newton's method and the approach, against linear algebra and closed forms."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

import grazing as gz
from grazing import theory
from grazing.kernel.compile import call
from grazing.maps.derivative import extended
from grazing.maps.map import kernels_of
from grazing.studies import cycles
from grazing.studies.classify import classify
from grazing.studies.cycles import (
    FOUND,
    NO_TANGENT,
    NONE,
    contracting_norm,
    falling,
    finder,
    keeps,
    log_radius,
    multiplied,
    room_for,
    settler,
    solved,
)
from grazing.studies.recurrence import compiled_recurrence
from tests.models import packed
from tests.studies import twin
from tests.studies.maps import FOLLOWER, HENON, LOGISTIC, SMOOTH, SPIRAL, linear_map, states_in

SIZES = [1, 2, 3, 5]


@pytest.mark.parametrize("d", SIZES)
def test_products_and_equations_are_those_of_linear_algebra(d):
    rng = np.random.default_rng(d)
    for _ in range(50):
        a, b, x = rng.normal(size=(d, d)), rng.normal(size=(d, d)), rng.normal(size=d)
        product = np.empty((d, d))
        multiplied(a, b, product)
        assert np.allclose(product, a @ b, rtol=1e-13, atol=1e-13)
        right = a @ x
        assert solved(a.copy(), right, np.ones(d))
        assert np.allclose(right, x, rtol=0, atol=1e-13 * np.linalg.cond(a))


def test_elimination_pivots_and_sees_singular_matrices():
    b = np.array([2.0, 3.0])
    assert solved(np.array([[0.0, 1.0], [1.0, 0.0]]), b, np.ones(2))
    assert b.tolist() == [3.0, 2.0]
    b = np.array([1.0, 1.0])
    assert solved(np.array([[1e-20, 1.0], [1.0, 1.0]]), b, np.ones(2))  # without pivots the first unknown is lost
    assert np.allclose(b, [0.0, 1.0], atol=1e-15)
    for singular in ([[0.0, 0.0], [0.0, 1.0]], [[1.0, 2.0], [2.0, 4.0]], [[np.nan, 0.0], [0.0, 1.0]]):
        assert not solved(np.array(singular), np.ones(2), np.ones(2))


@pytest.mark.parametrize("d", SIZES)
def test_the_radius_is_that_of_the_eigenvalues(d):
    rng = np.random.default_rng(10 + d)
    for _ in range(100):
        M = rng.normal(size=(d, d)) * 10.0 ** rng.uniform(-6, 6)
        assert log_radius(M) == pytest.approx(np.log(np.abs(np.linalg.eigvals(M)).max()), abs=1e-11)


def test_the_radius_of_matrices_without_a_basis_of_eigenvectors():
    assert log_radius(np.array([[0.5, 1.0], [0.0, 0.5]])) == pytest.approx(np.log(0.5), abs=1e-10)
    c, s = np.cos(1.0), np.sin(1.0)
    assert log_radius(0.99 * np.array([[c, -25.0 * s], [s / 25.0, c]])) == pytest.approx(np.log(0.99), abs=1e-11)
    assert log_radius(np.array([[0.0, 1.0], [0.0, 0.0]])) == -np.inf  # nilpotent
    assert log_radius(np.zeros((1, 1))) == log_radius(np.zeros((3, 3))) == -np.inf
    assert log_radius(np.array([[-0.25]])) == np.log(0.25)


@pytest.mark.parametrize("d", [2, 3])
def test_the_radius_of_what_is_no_number(d):
    assert np.isnan(log_radius(np.full((d, d), np.nan)))
    M = 0.5 * np.eye(d)
    M[0, 1] = np.nan
    assert np.isnan(log_radius(M))


@pytest.mark.parametrize("unit", [1e-12, 1.0, 1e9])
def test_what_a_matrix_keeps_is_the_projector_of_its_multipliers_1(unit):
    R, b, e = np.empty((2, 2)), 0.7, 0.9355
    assert keeps(np.array([[1.0, b * unit], [0.0, e]]), R)  # a flight without a spring, a period long
    assert np.allclose(R, [[1.0, b * unit / (1.0 - e)], [0.0, 0.0]], rtol=1e-12, atol=0.0)
    rng, S = np.random.default_rng(1), np.empty((4, 4))
    for _ in range(20):
        X = rng.normal(size=(4, 4)) * np.array([1.0, unit, 1.0, 1.0])[:, None]
        assert keeps(X @ np.diag([1.0, 1.0, -0.8, 0.3]) @ np.linalg.inv(X), S)
        exact = X @ np.diag([1.0, 1.0, 0.0, 0.0]) @ np.linalg.inv(X)
        size = np.array([1.0, unit, 1.0, 1.0])
        assert np.allclose(S * size / size[:, None], exact * size / size[:, None], atol=1e-6)


@pytest.mark.parametrize(
    "M",
    [
        [[1.0, 0.7], [0.0, 1.0]],  # what drifts ever farther
        [[-1.0, 0.0], [0.0, 0.5]],
        [[np.cos(1.0), -np.sin(1.0)], [np.sin(1.0), np.cos(1.0)]],
        [[np.cos(2.0 * np.pi / 3.0), -np.sin(2.0 * np.pi / 3.0)], [np.sin(2.0 * np.pi / 3.0), np.cos(2.0 * np.pi / 3)]],
        [[0.5, 1.0], [0.0, 0.9]],
        [[1.0, 0.0], [0.0, 1.5]],
        [[1.0, np.nan], [0.0, 0.5]],
        [[1.0 - 1e-6, 0.0], [0.0, 0.5]],
    ],
)
def test_other_matrices_keep_nothing(M):
    assert not keeps(np.array(M), np.empty((2, 2)))


def test_a_matrix_is_not_changed():
    M = np.array([[0.3, 0.2], [-0.1, 0.4]])
    kept, Q = M.copy(), np.empty((2, 2))
    log_radius(M)
    contracting_norm(M, 0.9, Q)
    assert np.array_equal(M, kept)


@pytest.mark.parametrize("d", SIZES)
@pytest.mark.parametrize("radius", [0.1, 0.9, 0.999])
def test_the_norm_contracts_every_turn(d, radius):
    rng = np.random.default_rng(int(1000 * radius) + d)
    for _ in range(20):
        M = rng.normal(size=(d, d))
        M *= radius / np.abs(np.linalg.eigvals(M)).max()
        rate, Q = 0.5 * (1.0 + radius), np.empty((d, d))
        contracting_norm(M, rate, Q)
        A = M / rate  # Q = 1 + A^T Q A, a linear equation
        plain = np.linalg.solve(np.eye(d * d) - np.kron(A.T, A.T), np.eye(d).ravel()).reshape(d, d)
        assert np.allclose(Q, plain, rtol=1e-8, atol=1e-8 * np.abs(plain).max())
        assert np.allclose(Q, Q.T, rtol=1e-12)
        for x in rng.normal(size=(50, d)):
            assert (M @ x) @ Q @ (M @ x) <= rate**2 * (x @ Q @ x) * (1 + 1e-9)


def search(P, state, letters, tolerance=1e-12):
    """Run the finder from one state, with the letters of the next steps: as plain Python, which gives the same bits."""
    find, c = finder(extended(kernels_of(P)[1]), P.dimension), packed(P)
    z, M = np.empty((P.dimension, 1)), np.empty((P.dimension, P.dimension))
    x = np.asarray(state, np.float64).reshape(1, -1, 1)
    s = np.asarray(letters, np.int64).reshape(-1, 1)
    room = room_for(len(s), P.dimension)
    return find(x, s, 0, len(s), c, np.full((P.dimension, 1), tolerance), z, M, room), z[:, 0], M


@pytest.mark.parametrize(("N", "lam", "l"), [(2, 0.5, 0.1), (3, 0.8, 1.0), (4, 0.34, 0.21), (5, 0.9, 0.8)])
def test_newton_finds_the_maximal_orbit_and_its_multiplier(N, lam, l):
    low, high = theory.mu_pd(N, lam, l), theory.mu_bc(N, lam, l)
    mu = low + 0.3 * (high - low)
    exact = theory.maximal_orbit(N, lam, mu, l)
    found, z, M = search(gz.gap_map(lam, mu, l), [exact[0] * (1 + 1e-3)], [0] * (N - 1) + [1])
    assert found == FOUND
    assert z[0] == pytest.approx(exact[0], rel=1e-11)
    assert M[0, 0] == pytest.approx(theory.multiplier(N, lam, mu, l), rel=1e-9)


def test_newton_finds_unstable_cycles_too():
    mu = theory.mu_pd(3, 0.5, 0.1) - 1e-3
    exact = theory.maximal_orbit(3, 0.5, mu, 0.1)
    found, z, M = search(gz.gap_map(0.5, mu, 0.1), exact[:1] + 1e-5, [0, 0, 1])
    assert found == FOUND and z[0] == pytest.approx(exact[0], rel=1e-10)
    assert -1.1 < M[0, 0] < -1.0


@pytest.mark.parametrize("P", [HENON.replace(a=0.3), FOLLOWER, SMOOTH, LOGISTIC], ids=lambda P: f"{P.name}")
def test_newton_in_every_dimension_is_the_plain_one(P):
    N = {"Henon map": 1}.get(P.name, 2)
    orbit = P.orbit(states_in(P, 1)[:, 0], 400)
    letters, off = orbit.letters[-N:], orbit.points[-1] * (1.0 + 1e-4)
    found, z, M = search(P, off, letters)
    other, matrix = twin.cycle_beside(P, off, letters, np.full(P.dimension, 1e-12))
    assert found == FOUND
    assert np.allclose(z, other, rtol=1e-10, atol=1e-11)
    assert np.allclose(M, matrix, rtol=1e-8, atol=1e-8)
    assert np.allclose(P.orbit(z, N).points[-1], z, rtol=1e-9, atol=1e-10)


def test_a_shorter_cycle_or_other_letters_are_refused():
    G = gz.gap_map(0.8, 0.5, 1.0)
    exact = theory.maximal_orbit(3, 0.8, 0.5, 1.0)
    assert search(G, exact[:1], [0, 0, 1])[0] == FOUND
    assert search(G, exact[:1], [0, 0, 1, 0, 0, 1])[0] == NONE
    assert search(G, exact[:1], [0, 1, 0])[0] == NONE


def test_no_tangent_at_the_orbit_is_said():
    assert search(gz.gap_map(0.8, 0.5, 1.0), [0.0], [1])[0] == NO_TANGENT  # the slope is infinite at 0


def test_of_a_continuum_the_cycle_is_the_one_that_the_orbit_approaches():
    found, z, M = search(linear_map([[1.0]]), [0.3], [0])
    assert (found, z[0], M[0, 0]) == (FOUND, 0.3, 1.0)
    found, z, _M = search(linear_map([[1.0, 0.5], [0.0, 0.9]]), [0.3, -0.2], [0])
    assert found == FOUND and z == pytest.approx([0.3 - 0.2 * 0.5 / 0.1, 0.0], abs=1e-14)  # sum of 0.5 v 0.9^n
    drift = gz.Map(lambda state, p: (state[0] + p.a,), params={"a": 0.01}, tangent=drifting)
    assert search(drift, [0.3], [0])[0] == NONE


def drifting(state, p):
    return (state[0] + p.a,), 0, 0, (1.0,)


def test_newton_takes_as_many_steps_as_it_says():
    # x -> x + x^2/2 has a double root at 0: the distance halves, so that twelve steps do not reach the tolerance
    def tangent(state, p):
        (x,) = state
        return (x + 0.5 * p.a * x * x,), 0, 0, (1.0 + p.a * x,)

    P = gz.Map(lambda state, p: (state[0] + 0.5 * p.a * state[0] ** 2,), params={"a": 1.0}, tangent=tangent)
    assert search(P, [0.5], [0], 0.5 ** (cycles.STEPS + 2))[0] == NONE
    found, z, _M = search(P, [0.5], [0], 0.5 ** (cycles.STEPS + 1))
    assert found == FOUND and z[0] == pytest.approx(0.5 ** (cycles.STEPS + 1), rel=1e-9)


def beside(points, z, M, N=1, tolerance=1e-12):
    """Ask the kernel and the plain twin whether points (keep, dim) approach."""
    x = np.asarray(points, np.float64)
    one = falling(x[:, :, None], 0, N, np.asarray(z).reshape(-1, 1), np.asarray(M), np.full((x.shape[1], 1), tolerance))
    return bool(one), twin.approaches(np.asarray(z), np.asarray(M), x, N, np.full(x.shape[1], tolerance))


def test_a_spiral_approaches_although_its_coordinates_do_not_shrink_every_time():
    c, s = 0.99 * np.cos(1.0), 0.99 * np.sin(1.0)
    M = np.array([[c, -5.0 * s], [s / 5.0, c]])
    points = [np.array([0.7, 0.2])]
    for _ in range(40):
        points.append(M @ points[-1])
    points = np.array(points)
    assert (np.diff(np.linalg.norm(points, axis=1)) > 0).any()
    assert beside(points, [0.0, 0.0], M) == (True, True)
    assert beside(points[::-1], [0.0, 0.0], M) == (False, False)


def test_who_stands_still_or_arrived():
    M = [[0.5]]
    assert beside(np.full((20, 1), 1e-13), [0.0], M) == (True, True)  # within the tolerance
    assert beside(np.full((20, 1), 1e-3), [0.0], M) == (False, False)
    assert beside(np.full((20, 1), 1e-3), [0.0], [[1.0]]) == (False, False)
    assert beside(0.999 ** np.arange(20)[:, None], [0.0], M) == (False, False)  # much slower than the multiplier says


def test_a_quadratic_term_near_a_doubling_lifts_every_other_distance():
    x, points = 0.02, []
    for _ in range(60):
        points.append([x])
        x = -0.999 * x + 0.9 * x * x - 0.9 * x**3
    sizes = np.abs(points)[:, 0]
    assert (np.diff(sizes) > 0).any()
    assert beside(points, [0.0], [[-0.999]]) == (True, True)


@given(
    arrays(np.float64, (2, 2), elements=st.floats(-1.0, 1.0)),
    arrays(np.float64, 2, elements=st.floats(-1.0, 1.0)),
)
def test_a_linear_orbit_approaches_if_it_contracts(M, start):
    radius = np.abs(np.linalg.eigvals(M)).max()
    points = [start]
    for _ in range(300):
        points.append(M @ points[-1])
    one, _plain = beside(points, np.zeros(2), M, tolerance=1e-9)
    if radius < 0.95:
        assert one
    if radius > 1.0 + 1e-9:
        assert not one


@pytest.mark.parametrize("beyond", [3e-3, 1e-4])
def test_the_settler_gives_the_period_of_the_cycle_that_is_approached(beyond):
    lam, l, N = 0.5, 0.1, 3
    mu = theory.mu_pd(N, lam, l) * (1 + beyond)
    G = gz.gap_map(lam, mu, l)
    starts = theory.maximal_orbit(N, lam, mu, l)[0] + np.array([[1e-6, -1e-6, 3e-4]])
    points, letters, outcomes = G.run(starts.copy(), 0, 60)
    period, doubtful, sizes = np.empty((1, 3), np.int32), np.empty((1, 3), np.int32), np.empty((2, 1, 1, 3))
    found = np.ascontiguousarray(points[None]), np.ascontiguousarray(letters[None], np.int64)
    call(
        compiled_recurrence(), *found, np.ascontiguousarray(outcomes[None]), 1e-9, np.ones(1), period, doubtful, *sizes
    )
    extent = np.ptp(points[:, 0], axis=0)
    assert np.allclose(sizes[0, 0, 0], extent, rtol=1e-15)
    assert np.allclose(sizes[1, 0, 0], 1e-9 * extent + 1e-13 * np.abs(points[:, 0]).max(axis=0), rtol=1e-15)
    derived, which = G.derivative(G.packed()[1][None]), np.argwhere(doubtful)
    entry = settler(derived.tangent, derived.prepare, derived.kind, 1)
    which = np.ascontiguousarray(np.column_stack([which, which[:, 0], doubtful[doubtful > 0]]))  # one kernel for all
    call(entry, derived.rows, *found, *sizes, which, period)
    assert period[0].tolist() == twin.classified(G, points, letters, outcomes[0])[0]
    assert period[0, 0] == period[0, 1] == N


def test_spirals_of_every_angle_are_settled_on_their_fixed_point():
    for turn in np.linspace(0.0, np.pi, 13):
        for r in (0.9, 0.99):
            P = SPIRAL.replace(turn=turn, r=r)
            points, letters, outcomes = P.run(states_in(P, 6), 20, 60)

            found = classify(P, points, letters, outcomes[0]).period.tolist()
            assert found == twin.classified(P, points, letters, outcomes[0])[0], (turn, r)
            assert set(found) == {1}, (turn, r)


def test_elimination_meets_the_same_pivots_in_any_unit():
    rng = np.random.default_rng(4)
    for _ in range(20):
        a, b = rng.normal(size=(4, 4)), rng.normal(size=4)
        unit, size = (2.0 ** rng.integers(-40, 40, 4) for _ in range(2))
        plain, other = b.copy(), b * size
        assert solved(a.copy(), plain, np.ones(4)) and solved(a * size[:, None] / unit, other, unit)
        assert (other == plain * unit).all()
