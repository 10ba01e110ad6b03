"""Random numbers keyed by their place: published values, prefixes, no visible structure."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grazing.kernel.compile import compiled
from grazing.kernel.random import mixed, uniform, uniform_numbers

GOLDEN = 0x9E3779B97F4A7C15
#: The first outputs of SplitMix64 from the seed 1234567, as its reference implementation prints them.
PUBLISHED = (
    6457827717110365317, 3203168211198807973, 9817491932198370423, 4593380528125082431, 16408922859458223821,
)  # fmt: skip


def test_outputs_of_splitmix64():
    """Its state grows by the golden ratio at every call, the first output included; ``mixed`` is one call."""
    states = np.array([(1234567 + i * GOLDEN) % 2**64 for i in range(5)], np.uint64)
    assert mixed(states).tolist() == list(PUBLISHED)


def unmixed(word):
    """Undo ``mixed`` in whole numbers."""
    mask = 2**64 - 1

    def unshifted(z, n):
        x = z
        for _ in range(64 // n + 1):
            x = z ^ (x >> n)
        return x

    z = unshifted(word, 31) * pow(0x94D049BB133111EB, -1, 2**64) & mask
    z = unshifted(z, 27) * pow(0xBF58476D1CE4E5B9, -1, 2**64) & mask
    return (unshifted(z, 30) - GOLDEN) & mask


@given(st.integers(0, 2**64 - 1))
def test_no_two_words_are_mixed_to_one(word):
    assert unmixed(int(mixed(np.array([word], np.uint64))[0])) == word


def test_each_input_bit_moves_half_of_the_output_bits():
    words = np.random.default_rng(0).integers(0, 2**64, 1000, np.uint64)
    for bit in range(64):
        moved = mixed(words) ^ mixed(words ^ np.uint64(1 << bit))
        share = np.unpackbits(moved.view(np.uint8)).mean()
        assert abs(share - 0.5) < 5.0 * 0.5 / np.sqrt(64 * 1000)


@pytest.mark.parametrize("lanes", [1, 7, 64, 1000])
@pytest.mark.parametrize("dimension", [1, 2, 3])
def test_a_number_depends_on_its_place_alone(lanes, dimension):
    every = uniform(5, (0.25, -3.0), 1000, 3)
    some = uniform(5, (0.25, -3.0), lanes, dimension)
    assert some.shape == (lanes, dimension)
    assert np.array_equal(some, every[:lanes, :dimension])


def test_numbers_are_uniform():
    """Chi-square of 64 bins, for lanes, cells and seeds in turn: within five standard deviations."""
    cells = np.array([uniform(0, (0.05 + 1e-5 * i,), 1, 1)[0, 0] for i in range(6400)])
    seeds = np.array([uniform(i, (0.05,), 1, 1)[0, 0] for i in range(6400)])
    for numbers in (uniform(0, (), 32_000, 2).ravel(), uniform(2**64 - 1, (0.1, 0.2), 32_000, 2)[:, 1], cells, seeds):
        assert numbers.min() >= 0.0 and numbers.max() < 1.0
        counts = np.histogram(numbers, 64, (0.0, 1.0))[0]
        expected = numbers.size / 64
        chi = ((counts - expected) ** 2 / expected).sum()
        assert abs(chi - 63.0) < 5.0 * np.sqrt(2.0 * 63.0)


def test_neighbours_are_not_correlated():
    n = 20_000
    one = uniform(3, (0.5,), n, 3)
    pairs = [
        (one[:, 0], one[:, 1]),
        (one[:-1, 0], one[1:, 0]),
        (one[:, 0], uniform(4, (0.5,), n, 3)[:, 0]),
        (one[:, 0], uniform(3, (np.nextafter(0.5, 1.0),), n, 3)[:, 0]),
        (uniform(3, (0.5, 0.25), n, 1)[:, 0], uniform(3, (0.25, 0.5), n, 1)[:, 0]),
    ]
    for a, b in pairs:
        assert abs(np.corrcoef(a, b)[0, 1]) < 5.0 / np.sqrt(n)
    assert len(np.unique(one)) == one.size


def test_seed_and_cell_name_the_numbers():
    assert np.array_equal(uniform(1, (0.0, 0.3), 4, 2), uniform(1, (-0.0, 0.3), 4, 2))  # minus zero is zero
    assert np.array_equal(uniform(1, (2,), 4, 2), uniform(1, (2.0,), 4, 2))
    kinds = [uniform(*key, 4, 2).tobytes() for key in ((1, ()), (1, (0.0,)), (1, (0.0, 0.0)), (2, (0.0,)), (0, (1.0,)))]
    assert len(set(kinds)) == 5


def test_many_cells_are_each_their_own():
    cells = np.array([[0.1, 0.2], [0.2, 0.1], [0.1, 0.2], [-0.0, np.pi]])
    every = uniform(9, cells, 6, 2)
    assert every.shape == (4, 6, 2)
    for q, cell in enumerate(cells):
        assert np.array_equal(every[q], uniform(9, tuple(cell), 6, 2))
    assert uniform(9, np.empty((3, 0)), 2, 1).shape == (3, 2, 1)  # cells without a name are all one cell
    assert np.array_equal(uniform(9, np.empty((3, 0)), 2, 1)[2], uniform(9, (), 2, 1))
    assert uniform(9, np.empty((0, 2)), 5, 3).shape == (0, 5, 3)
    strided = np.asfortranarray(np.repeat(cells, 2, axis=0))[::2]
    assert np.array_equal(uniform(9, strided, 6, 2), every)


@pytest.mark.parametrize("seed", [0, 3, 2**53 - 1])
def test_the_kernel_draws_the_same_numbers(seed):
    names = np.array([[0.25, -3.0], [-0.0, 1e300], [0.0, 1e300]])
    found = np.empty((3, 2, 9))
    compiled(uniform_numbers)(float(seed), names, found)
    np.testing.assert_array_equal(found, np.swapaxes(uniform(seed, names, 9, 2), 1, 2))
    assert (found[1] == found[2]).all()
