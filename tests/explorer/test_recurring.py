"""Orbits that are followed until they recur, against orbits that are followed throughout."""

from math import copysign
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grazing.explorer.composed import counter_of
from grazing.explorer.recurring import recurring_counter, recurring_loop

TAKEN = [0]


class Slope(NamedTuple):
    a: float
    b: float


def tent(state, p):
    """Take a step of two contractions, whose letter is that of the side, and whose outcome that of a far one."""
    TAKEN[0] += 1
    x, y = state
    right = x >= 0.0
    return (p.a * x + (p.b if right else 0.4) - 0.7 * right, 0.5 * y + x), int(right), 2 * (x > 0.6)


def turned(state, p):
    """Turn the sign of a zero, which is the letter."""
    TAKEN[0] += 1
    x, y = state
    return (-x, y), int(copysign(1.0, x) > 0.0), 0


def throughout(step, rows, lanes, transient, keep):
    """Follow each orbit step by step."""
    columns, dimension, n = lanes.shape
    points, letters = np.empty((columns, keep, dimension, n)), np.empty((columns, keep, n), np.int32)
    outcomes, ends = np.zeros((columns, 1, n), np.int32), lanes.copy()
    for q in range(columns):
        for j in range(n):
            state = tuple(lanes[q, :, j])
            for k in range(transient + keep):
                state, letter, outcome = step(state, Slope(*rows[q]))
                outcomes[q, 0, j] |= outcome
                if k >= transient:
                    points[q, k - transient, :, j], letters[q, k - transient, j] = state, letter
            ends[q, :, j] = state
    return points, letters, outcomes, ends


def recurring(step, rows, lanes, transient, keep):
    found = [np.empty((len(rows), keep, 2, lanes.shape[2])), np.empty((len(rows), keep, lanes.shape[2]), np.int32)]
    outcomes, ends = np.zeros((len(rows), 1, lanes.shape[2]), np.int32), lanes.copy()
    recurring_loop(step, lambda p: p, Slope, 2)(rows, ends, transient, *found, outcomes)
    return *found, outcomes, ends


def drawn(seed, slopes, starts):
    rng = np.random.default_rng(seed)
    rows = np.column_stack([slopes, rng.uniform(0.1, 0.6, len(slopes))])
    return rows, rng.uniform(-1.0, 1.0, (len(slopes), 2, starts))


@given(
    st.lists(st.sampled_from([0.0, 0.1, 0.3, 0.8, -0.5, -1.0, 1.5]), min_size=1, max_size=3), st.integers(0, 2**32),
    st.integers(1, 4), st.integers(0, 90), st.integers(0, 90),
)  # fmt: skip
def test_the_bits_are_those_of_orbits_followed_throughout(slopes, seed, starts, transient, keep):
    rows, lanes = drawn(seed, slopes, starts)
    expected, found = (f(tent, rows, lanes, transient, keep) for f in (throughout, recurring))
    for a, b in zip(expected, found, strict=True):
        assert a.tobytes() == b.tobytes()


@pytest.mark.parametrize(("transient", "keep"), [(0, 31), (7, 40), (30, 1)])
def test_zeros_of_either_sign_are_different_states(transient, keep):
    rows, lanes = np.ones((1, 2)), np.array([[[0.0, -0.0], [1.0, 1.0]]])
    expected, found = (f(turned, rows, lanes, transient, keep) for f in (throughout, recurring))
    for a, b in zip(expected, found, strict=True):
        assert a.tobytes() == b.tobytes()


def test_no_more_steps_are_taken_than_until_an_orbit_recurs():
    rows, lanes = drawn(0, [0.3], 4)
    TAKEN[0] = 0
    recurring(tent, rows, lanes, 1000, 1000)
    assert TAKEN[0] <= 4 * 60  # it would be 264 if an orbit did not know the cycle of those before it
    TAKEN[0] = 0
    rows, lanes = drawn(0, [-1.0], 1)  # quasiperiodic or nearly: nothing is saved, and nothing lost
    recurring(tent, rows, lanes, 20, 30)
    assert TAKEN[0] <= 50


@given(st.integers(0, 2**32), st.integers(1, 3), st.integers(0, 60), st.integers(0, 60))
def test_they_are_counted_as_other_orbits_are(seed, starts, transient, keep):
    rows, lanes = drawn(seed, [0.3, 1.5], starts)

    def loop(rows, lanes, transient, points, letters, outcomes):
        points[:], letters[:], more, lanes[:] = throughout(tent, rows, lanes, transient, points.shape[1])
        outcomes |= more

    counted = []
    for count in (counter_of(loop, 2), recurring_counter(recurring_loop(tent, lambda p: p, Slope, 2), 2)):
        counts, ended, ambiguous = np.full((2, 13), 7, np.int32), np.full(2, 7, np.int32), np.full(2, 7, np.int32)
        ends = lanes.copy()
        count(rows, ends, transient, keep, 0, -0.5, 0.9, 10, counts, ended, ambiguous)
        counted.append((counts.tolist(), ended.tolist(), ambiguous.tolist(), ends.tobytes()))
    assert counted[0] == counted[1]
    assert sum(counted[0][0][0]) == starts * keep


@pytest.mark.parametrize("keep", [0, 1, 2, 5])
def test_what_is_said_of_a_cycle_is_said_of_each_orbit_on_it(keep):
    def around(state, p):
        """Go round a cycle of five states, on one of which something is said; other states fall on to it."""
        x, y = state
        return ((x + 1.0) % 5.0, 0.0), 0, 2 * (x == 3.0 and y == 0.0)

    rows, lanes = np.ones((1, 2)), np.array([[[0.0, 4.0, 1.0], [0.0, 1.0, 1.0]]])
    for transient in range(30):
        expected, found = (f(around, rows, lanes, transient, keep) for f in (throughout, recurring))
        for a, b in zip(expected, found, strict=True):
            assert a.tobytes() == b.tobytes()
