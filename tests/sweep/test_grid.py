import itertools

import numpy as np
import pytest

import grazing as gz
from grazing.sweep.grid import FORMULA, LARGEST, LONG, Grid, grid_of
from tests.sweep.plans import plan


@pytest.mark.parametrize(
    ("shape", "chunk"),
    [((7,), (3,)), ((1,), (1,)), ((5, 4), (2, 3)), ((3, 2, 5), (2, 2, 2)), ((4, 6), (4, 6)), ((), ())],
)
def test_every_cell_is_in_one_chunk(shape, chunk):
    grid = Grid(shape, chunk)
    cells = [grid.cells(number) for number in range(grid.count)]
    assert sorted(itertools.chain(*cells)) == list(range(int(np.prod(shape))))
    numbers = np.arange(int(np.prod(shape))).reshape(shape)
    for number, some in enumerate(cells):
        assert some.tolist() == numbers[grid.block(number)].ravel().tolist()
        assert len(some) == grid.size(number) == np.prod(grid.block_shape(number))
        assert some.dtype == np.int64


@pytest.mark.parametrize(
    ("chunk", "expected"),
    [
        (1, (1, 1)),
        (4, (1, 4)),  # eight cells along l are cut in two, not in seven and one
        (7, (1, 4)),
        (8, (1, 8)),
        (25, (3, 8)),
        (33, (4, 8)),
        (1000, (7, 8)),
        ({"mu": 2}, (2, 8)),
        ({"l": 3}, (7, 3)),
        ({"l": 100, "mu": 1}, (1, 8)),
        (np.int64(8), (1, 8)),
    ],
)
def test_chunks_that_are_asked_for(chunk, expected):
    assert grid_of(plan(7, 8), chunk).chunk == expected


@pytest.mark.parametrize("chunk", [0, -1, 1.5, "3", True, {"mu": 0}, {"mu": "2"}])
def test_chunks_that_are_no_numbers(chunk):
    with pytest.raises(gz.InputError, match=r"allowed is a whole number >= 1"):
        grid_of(plan(), chunk)


def test_an_axis_that_is_not_there():
    with pytest.raises(gz.InputError, match=r"chunk names 'nu'; the axes of this sweep are mu, l"):
        grid_of(plan(7, 2), {"nu": 3})


def test_chunks_are_worth_a_second_and_whole_goes():
    long = plan(1000, together=3)
    (size,) = grid_of(long).chunk
    assert size * long.work * FORMULA == pytest.approx(LONG, rel=0.3)
    assert grid_of(plan(1000)).chunk == grid_of(plan(1000)).chunk
    few = grid_of(plan(5, together=2))
    assert few.count >= 2
    assert grid_of(plan(64, 64, together=2)).chunk[1] > 1


def test_a_chunk_of_flights_is_smaller():
    def size(P, **config):
        (size,) = grid_of(plan(100_000, P=P, config=config, together=1, work=10**4)).chunk
        return size

    formula, impact, strobe = plan().P, gz.impact_map(gz.pinball()), gz.stroboscopic_map(gz.pinball())
    flight = size(strobe, arithmetic="strict")
    assert size(impact) <= flight < size(strobe) < size(formula)


def test_chunks_fit_into_memory():
    large = plan(8, keep=10**6, together=8)
    assert grid_of(large).chunk == (LARGEST // large.size_of_cell,) == (2,)
    assert grid_of(plan(8, keep=10**7)).chunk == (1,)
