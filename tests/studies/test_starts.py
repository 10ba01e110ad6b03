import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import grazing as gz
from grazing.studies.starts import checked_box, checked_seed, checked_starts, mixed, random_starts, uniform
from tests.examples import examples

MASK = 2**64 - 1


def twin(z):
    z = (z + 0x9E3779B97F4A7C15) & MASK
    z = ((z ^ (z >> 30)) * 0xBF58476D1CE4E5B9) & MASK
    z = ((z ^ (z >> 27)) * 0x94D049BB133111EB) & MASK
    return z ^ (z >> 31)


def test_first_number_of_splitmix64():
    assert int(mixed(np.array([0], np.uint64))[0]) == 0xE220A8397B1DCDAF  # the published first output of seed 0


@given(st.integers(0, MASK), st.floats(allow_nan=False), st.integers(0, 50), st.integers(0, 3))
@settings(max_examples=examples(50))
def test_numbers_are_those_of_the_plain_twin(seed, value, lane, coordinate):
    bits = int(np.array([value + 0.0]).view(np.uint64)[0])
    key = twin(twin(seed) ^ twin(bits))
    number = twin(twin(key ^ twin(lane)) ^ twin(coordinate ^ 0x9E3779B97F4A7C15))
    assert uniform(seed, (value,), lane + 1, 4)[lane, coordinate] == (number >> 11) * 2.0**-53


def test_numbers_are_uniform_and_not_correlated():
    u = uniform(3, (0.1, 0.2), 20_000, 3)
    assert u.min() >= 0.0
    assert u.max() < 1.0
    assert np.abs(u.mean(axis=0) - 0.5).max() < 5 / np.sqrt(12 * 20_000)
    assert np.abs(u.var(axis=0) - 1 / 12).max() < 0.003
    assert np.abs(np.corrcoef(u.T) - np.eye(3)).max() < 0.03
    assert np.abs(np.corrcoef(u[1:, 0], u[:-1, 0])[0, 1]) < 0.03


def test_every_part_of_the_key_counts():
    base = uniform(1, (0.1, 0.2), 4, 2)
    for other in (uniform(2, (0.1, 0.2), 4, 2), uniform(1, (0.2, 0.1), 4, 2), uniform(1, (0.1,), 4, 2)):
        assert not (base == other).any()
    assert (uniform(1, (0.0,), 4, 2) == uniform(1, (-0.0,), 4, 2)).all()
    assert len(np.unique(base)) == base.size


def test_a_start_does_not_depend_on_how_many_there_are():
    box = ((-1.0, 1.0), (2.0, 5.0))
    many = random_starts(7, (0.3,), 100, box)
    assert (random_starts(7, (0.3,), 13, box) == many[:, :13]).all()
    assert (many[0] >= -1).all() and (many[0] < 1).all() and (many[1] >= 2).all() and (many[1] < 5).all()
    assert np.ptp(many[1]) > 2.0


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda: checked_seed(-1), "seed = -1; allowed is a whole number >= 0"),
        (lambda: checked_seed("a"), "seed = 'a'; allowed is a whole number >= 0"),
        (lambda: checked_seed(0.5), "seed = 0.5; allowed is a whole number >= 0"),
        (lambda: checked_seed(2**64), "seed = 18446744073709551616; allowed is a whole number below"),
        (lambda: checked_box(3, ("u", "v")), r"box is 3; give one \(low, high\) for each of u, v"),
        (lambda: checked_box(((0, 1),), ("u", "v")), "box has 1 intervals for 2 coordinates; give one"),
        (lambda: checked_box(((1, 0),), ("x",)), r"box of x is \(1, 0\); the lower end must come first"),
        (lambda: checked_box(((0, np.inf),), ("x",)), "box of x = inf is not finite"),
        (lambda: checked_starts(0, ("x",)), "starts = 0; allowed is a whole number >= 1"),
        (lambda: checked_starts(2.5, ("x",)), "starts = 2.5; allowed is a whole number >= 1"),
        (lambda: checked_starts([1.0, 2.0], ("x",)), r"starts have shape \(2,\); give .* states of shape \(n, 1\): x"),
        (lambda: checked_starts([[1.0, 2.0]], ("x",)), r"starts have shape \(1, 2\)"),
        (lambda: checked_starts([[1.0], [np.nan]], ("x",)), "start 1 is not finite; give"),
        (lambda: checked_starts([["a"]], ("x",)), "starts are not numbers; give"),
    ],
)
def test_error_texts(call, said):
    with pytest.raises(gz.InputError, match=said):
        call()
