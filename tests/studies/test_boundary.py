"""Dimension and entropy of basin boundaries: smooth curves, a Cantor set, and counts by hand."""

import numpy as np
import pytest

import grazing as gz
from grazing.studies.boundary import BOX, basin_entropy, uncertain_share, uncertainty
from tests.studies.maps import tent_escape_step


@pytest.mark.parametrize("n", [100, 400])
@pytest.mark.parametrize(
    "inside",
    [
        lambda x, y: x + 0.37 * y < 0.61,
        lambda x, y: (x - 0.5) ** 2 + (y - 0.45) ** 2 < 0.09,
        lambda x, y: y < 0.5 + 0.2 * np.sin(7 * x),
    ],
    ids=["line", "circle", "wave"],
)
def test_a_smooth_curve_has_dimension_one(inside, n):
    x, y = np.meshgrid(np.linspace(0, 1, n), np.linspace(0, 1, n), indexing="ij")
    found = uncertainty(inside(x, y).astype(np.int64))
    assert found["uncertainty_exponent"] == pytest.approx(1.0, abs=0.06)
    assert found["boundary_dimension"] == pytest.approx(1.0, abs=0.06)
    assert 0.0 <= found["uncertainty_error"] < 0.05


def test_points_on_a_line_have_dimension_zero():
    x = np.linspace(0, 1, 2000)
    found = uncertainty(np.searchsorted([0.21, 0.5, 0.76], x) % 2)
    assert found["uncertainty_exponent"] == pytest.approx(1.0, abs=0.01)
    assert found["boundary_dimension"] == pytest.approx(0.0, abs=0.01)


def tent_basins(n):
    """Where orbits of the open tent map leave, and to which side: the boundary is the middle-thirds Cantor set."""
    x = (np.arange(n) + 0.5) / n
    where = np.full(n, -1)
    for step in range(60):
        inside = (x >= 0) & (x <= 1)
        where[(where < 0) & ~inside] = step % 2
        x = np.where(inside, np.where(x < 0.5, 3 * x, 3 - 3 * x), x)
    where[where < 0] = 2
    return where


def test_the_cantor_set_has_its_dimension():
    found = uncertainty(tent_basins(3**11))
    assert found["boundary_dimension"] == pytest.approx(np.log(2) / np.log(3), abs=0.02)
    assert found["uncertainty_error"] < 0.02
    square = np.tile(tent_basins(3**6)[:, None], (1, 3**6))  # a Cantor set times a line
    assert uncertainty(square)["boundary_dimension"] == pytest.approx(1 + np.log(2) / np.log(3), abs=0.05)


def test_basins_of_a_map_with_a_fractal_boundary():
    """Letters tell after how many steps, even or odd, an orbit leaves for one of two far points."""

    def step(state, p):
        x, turn = state
        inside = 0.0 <= x <= 1.0
        new = (
            (3.0 * x if x < 0.5 else 3.0 - 3.0 * x) if inside else (0.5 * (x + 4.0) if turn > 0.0 else 0.5 * (x - 6.0))
        )
        if not inside and -10.0 < x < 0.0 and turn > 0.0:
            new = 4.0
        return new, (-turn if inside else turn)

    P = gz.Map(step, params={"a": 1.0}, coordinates=("x", "turn"), box=((0.0, 1.0), (-1.0, 1.0)))
    x = (np.arange(3**8) + 0.5) / 3**8
    found = gz.basins(P, {"x": x}, fixed={"turn": 1.0}, transient=120, keep=30)
    assert found.attrs["boundary_dimension"] == pytest.approx(np.log(2) / np.log(3), abs=0.05)


def test_noise_fills_the_plane():
    grid = np.random.default_rng(0).integers(0, 2, (200, 200))
    found = uncertainty(grid)
    assert found["uncertainty_exponent"] == pytest.approx(0.0, abs=0.01)
    assert found["boundary_dimension"] == pytest.approx(2.0, abs=0.01)


@pytest.mark.parametrize("shape", [(40,), (30, 50), (1,), (2, 2), (0,)])
def test_without_a_boundary_there_is_no_dimension(shape):
    found = uncertainty(np.zeros(shape, np.int64))
    assert all(np.isnan(value) for value in found.values())


def test_shares_by_hand():
    grid = np.array([0, 0, 0, 1, 1, 1, 0, 0])
    assert uncertain_share(grid, 1, 1) == pytest.approx(4 / 6)  # cells 2, 3, 5 and 6 of 1 to 6
    assert uncertain_share(grid, 2, 2) == pytest.approx(4 / 4)
    plane = np.zeros((5, 5), np.int64)
    plane[2, 2] = 1
    assert uncertain_share(plane, 1, 1) == pytest.approx(5 / 9)
    assert uncertain_share(grid, 1, 2) == pytest.approx(3 / 4)  # cells 2, 3 and 5 of 2 to 5


def test_entropy_by_hand():
    half = np.repeat([0, 1], BOX)  # two pure boxes
    assert basin_entropy(half)["basin_entropy"] == 0.0
    assert np.isnan(basin_entropy(half)["boundary_basin_entropy"])
    mixed = np.array([0, 0, 1, 1, 1, *[2] * BOX])
    p = np.array([0.4, 0.6])
    S = -(p * np.log(p)).sum()
    found = basin_entropy(mixed)
    assert found["basin_entropy"] == pytest.approx(S / 2)
    assert found["boundary_basin_entropy"] == pytest.approx(S)
    plane = np.zeros((2 * BOX + 3, BOX + 1), np.int64)  # what is left of whole boxes does not count
    plane[:BOX, 0] = 3
    plane[-1] = 9
    q = np.array([0.2, 0.8])
    assert basin_entropy(plane)["basin_entropy"] == pytest.approx(-(q * np.log(q)).sum() / 2)
    assert np.isnan(basin_entropy(np.zeros((4, 9), np.int64))["basin_entropy"])


def test_entropy_of_noise_is_the_logarithm_of_the_number_of_attractors():
    """Less the bias of 25 draws: (k - 1)/(2 * 25) to first order (Miller, 1955)."""
    for k in (2, 3, 5):
        grid = np.random.default_rng(k).integers(0, k, (500, 500))
        assert basin_entropy(grid)["basin_entropy"] == pytest.approx(np.log(k) - (k - 1) / 50, abs=0.01)


def test_the_map_of_the_cantor_set_leaves_as_it_says():
    P = gz.Map(tent_escape_step, params={"a": 1.0}, letters="LRM")
    assert P.orbit((0.4,), 3).letters.tolist() == [2, 1, 1]
