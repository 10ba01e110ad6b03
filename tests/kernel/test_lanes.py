"""The loop over lanes: order, blocks, folding of outcomes."""

from collections import namedtuple

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grazing.kernel.compile import compiled
from grazing.kernel.lanes import BLOCK, column, runner, unpacker
from grazing.kernel.primitives import built, power_of_two, replaced

Pair = namedtuple("Pair", "a b")


def turn(state, p):
    """A rotation with a counter: its letter is the sign of x, its outcome a bit that depends on the state."""
    x, y, n = state
    return (p.a * x - p.b * y, p.b * x + p.a * y, n + 1.0), (1 if x > 0.0 else 0), (4 if n == 3.0 else 0)


def by_hand(start, p, transient, keep):
    state, points, letters, outcomes = tuple(start), [], [], 0
    for i in range(transient + keep):
        state, letter, outcome = turn(state, p)
        outcomes |= outcome
        if i >= transient:
            points.append(state)
            letters.append(letter)
    return points, letters, outcomes


@pytest.mark.parametrize("lanes", [1, 2, BLOCK - 1, BLOCK, BLOCK + 1, 3 * BLOCK + 5])
@pytest.mark.parametrize(("transient", "keep"), [(0, 4), (5, 3), (2, 0)])
def test_every_lane_is_the_plain_loop(lanes, transient, keep):
    p = Pair(0.8, 0.6)
    run = runner(turn, None, Pair, 3, "strict")
    starts = np.random.default_rng(lanes).normal(size=(3, lanes))
    starts[2] = 0.0
    states = starts.copy()
    points = np.full((keep, 3, lanes), np.nan)
    letters, outcomes = np.zeros((keep, lanes), np.int64), np.zeros((1, lanes), np.int64)
    run(np.array([p]), states[None], transient, points[None], letters[None], outcomes[None])
    for j in range(lanes):
        expected, said, flags = by_hand(starts[:, j], p, transient, keep)
        assert np.array_equal(points[:, :, j], np.array(expected).reshape(keep, 3))
        assert letters[:, j].tolist() == said
        assert outcomes[0, j] == flags
    last, _, _ = by_hand(starts[:, 0], p, 0, transient + keep)
    assert tuple(states[:, 0]) == last[-1]


def turn_prepared(state, c):
    return turn(state, c)


def doubled(p):
    return Pair(2.0 * p.a, p.b)


@pytest.mark.parametrize("prepare", [None, doubled])
@pytest.mark.parametrize(("columns", "lanes"), [(1, 3), (7, 1), (3, 40), (9, BLOCK), (2, BLOCK + 3)])
def test_a_column_does_not_depend_on_its_neighbours_in_a_block(columns, lanes, prepare):
    run = runner(turn_prepared, prepare, Pair, 3, "strict")
    rng = np.random.default_rng(columns)
    rows, starts = rng.uniform(0.1, 0.5, (columns, 2)), rng.normal(size=(columns, 3, lanes))

    def found(q):
        states, n = starts[q].copy(), len(rows[q])
        points, letters = np.empty((n, 5, 3, lanes)), np.zeros((n, 5, lanes), np.int64)
        outcomes = np.zeros((n, 1, lanes), np.int64)
        run(rows[q], states, 3, points, letters, outcomes)
        return points, letters, outcomes, states

    together = found(slice(None))
    for q in range(columns):
        assert all(np.array_equal(a[q], b[0]) for a, b in zip(together, found(slice(q, q + 1)), strict=True))
    p = Pair(*rows[-1]) if prepare is None else doubled(Pair(*rows[-1]))
    expected, said, _flags = by_hand(starts[-1, :, -1], p, 3, 5)
    assert np.array_equal(together[0][-1, :, :, -1], np.array(expected))
    assert together[1][-1, :, -1].tolist() == said


def test_outcomes_can_be_kept_apart():
    run = runner(turn, None, Pair, 3, "strict")
    outcomes = np.zeros((1, 6, 1), np.int64)
    letters = np.zeros((1, 6, 1), np.int64)
    run(np.array([[1.0, 0.0]]), np.zeros((1, 3, 1)), 0, np.empty((1, 6, 3, 1)), letters, outcomes)
    assert outcomes[0, :, 0].tolist() == [0, 0, 0, 4, 0, 0]


@given(st.tuples(st.floats(), st.floats(), st.floats()), st.integers(0, 2), st.floats())
def test_replaced_is_the_same_compiled(items, index, value):
    def entry(items, index, value):
        return replaced(items, index, value)

    assert np.array_equal(compiled(entry)(items, index, value), replaced(items, index, value), equal_nan=True)


@given(st.integers(-1022, 1023))
def test_power_of_two(n):
    assert compiled(power_of_two)(float(n)) == power_of_two(float(n)) == 2.0**n


def test_rows_become_named_tuples_and_columns_states():
    unpack = unpacker(Pair)

    def entry(row, lanes):
        return unpack(row), column(lanes, 1, (0.0, 0.0))

    row, lanes = np.array([1.0, 2.0]), np.array([[3.0, 4.0], [5.0, 6.0]])
    p, state = compiled(entry)(row, lanes)
    assert (p.a, p.b, state) == (1.0, 2.0, (4.0, 6.0))
    assert entry(row, lanes) == (Pair(1.0, 2.0), (4.0, 6.0))
    assert built(Pair, (1.0, 2.0)) == Pair(1.0, 2.0)
