"""Recurrence side by side: no orbit decides about another one, and shortcuts refuse nothing."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grazing.kernel.compile import call
from grazing.outcome import DIVERGED, NO_IMPACT
from grazing.studies.recurrence import (
    BITS,
    LANES,
    compiled_numbering,
    compiled_recurrence,
    compiled_spelling,
    least_lags,
    may_repeat,
    next_cycle,
    same_letters,
    spoken,
)
from tests.studies import twin

KEEP = 40


def orbits(columns, n, dimension):
    """Cycles of several periods, cycles that are approached, noise, and points that are no numbers."""
    rng = np.random.default_rng(columns * n)
    k = np.arange(KEEP)
    points, letters = np.empty((columns, KEEP, dimension, n)), np.empty((columns, KEEP, n), np.int64)
    for q in range(columns):
        for j in range(n):
            N, kind = rng.integers(1, 8), rng.integers(0, 5)
            cycle, word = rng.normal(size=(N, dimension)), rng.integers(-2, 4, N)
            x = cycle[k % N]
            if kind == 1:
                x = x * (1.0 + 0.3 * 0.8**k)[:, None]
            elif kind == 2:
                x = rng.normal(size=(KEEP, dimension))
            elif kind == 3:
                x[rng.integers(0, KEEP), 0] = rng.choice([np.nan, np.inf])
            points[q, :, :, j], letters[q, :, j] = x, word[k % N]
    return points, letters


def recurred(points, letters, outcomes):
    shape = letters.shape[0], letters.shape[2]
    found = np.empty(shape, np.int32), np.empty(shape, np.int32)
    sizes = np.empty((2, shape[0], points.shape[2], shape[1]))
    call(compiled_recurrence(), points, letters, outcomes, 1e-9, np.ones(points.shape[2]), *found, *sizes)
    return *found, *sizes


@pytest.mark.parametrize(("columns", "n"), [(1, 1), (1, LANES), (1, LANES + 1), (40, 3), (9, 8), (5, 100)])
@pytest.mark.parametrize("dimension", [1, 2])
def test_orbits_of_any_columns_are_each_alone(columns, n, dimension):
    points, letters = orbits(columns, n, dimension)
    outcomes = np.zeros((columns, 1, n), np.int64)
    outcomes[-1, 0, -1] = DIVERGED | NO_IMPACT
    period, doubtful, extents, tolerances = recurred(points, letters, outcomes)
    assert period[-1, -1] == twin.ENDED
    for q in range(columns):
        for j in range(n):
            one = np.ascontiguousarray(points[[q]][..., [j]]), np.ascontiguousarray(letters[[q]][..., [j]])
            alone = recurred(*one, outcomes[[q]][..., [j]])
            assert alone[0][0, 0] == period[q, j] and alone[1][0, 0] == doubtful[q, j]
            assert np.array_equal(alone[2][0, :, 0], extents[q, :, j], equal_nan=True)
            assert np.array_equal(alone[3][0, :, 0], tolerances[q, :, j], equal_nan=True)
    for q, j in np.argwhere((doubtful == 0) & (period != twin.ENDED))[:60]:
        x, s = points[q, :, :, j], letters[q, :, j]
        tolerance = tolerances[q, :, j]
        lag = next((N for N in range(1, KEEP // 2 + 1) if twin.recurs(x, s, N, tolerance)), twin.APERIODIC)
        assert period[q, j] == lag


@given(st.integers(2, 100), st.integers(1, 30), st.integers(0, 2**32 - 1), st.booleans())
def test_letters_that_repeat_are_never_refused(keep, N, seed, repeat):
    rng = np.random.default_rng(seed)
    s = np.empty((keep, LANES), np.int64)
    s[:, :] = rng.integers(-2, 3, (min(N, keep), 1))[np.arange(keep) % min(N, keep)]
    if not repeat:
        s[rng.integers(0, keep), 0] += 1
    last = np.empty(LANES, np.int64)
    spoken(s, last)
    assert last[0] == int("".join(str(letter & 1) for letter in s[-BITS:, 0]), 2)
    for n in range(1, keep // 2 + 1):
        if same_letters(s, 0, n):
            assert may_repeat(int(last[0]), min(keep, BITS), n)
        newest = s[-min(keep, BITS) :, 0] & 1
        assert may_repeat(int(last[0]), min(keep, BITS), n) == (newest[n:] == newest[:-n]).all()


@pytest.mark.parametrize("shape", [(1, 1), (7, 3), (200, 9)])
def test_keys_are_numbered_as_they_appear(shape):
    rng = np.random.default_rng(shape[0])
    key = rng.choice(np.r_[0, rng.integers(1, 2**62, 40)], shape)
    code, first = np.empty(shape, np.int32), np.empty(key.size + 1, np.int64)
    count = call(compiled_numbering(), key, code, first)
    assert first[0] == -1 and (code[key == 0] == 0).all()
    assert count == len(set(key.ravel().tolist()) | {0})
    places = first[1:count]
    assert (np.diff(places) > 0).all() and np.array_equal(code.ravel()[places], np.arange(1, count))
    assert np.array_equal(np.r_[0, key.ravel()[places]][code], key)


def test_keys_of_words_forget_where_an_orbit_was_seen():
    word = np.array([0, 0, 1, 0, 1])
    letters = np.stack([np.roll(np.tile(word, 4), j) for j in range(5)], axis=-1)[None]
    key, begin, length = np.empty((1, 5), np.int64), np.empty((1, 5), np.int32), np.empty((1, 5), np.int32)
    call(compiled_spelling(), letters, np.full((1, 5), 10, np.int32), key, begin, length)
    assert len(set(key[0].tolist())) == 1 and (length == 5).all()
    for j in range(5):
        assert letters[0, begin[0, j] - 10 :, j][:5].tolist() == word.tolist()


class Counted:
    """An array that counts how often it is read."""

    def __init__(self, values):
        self.values, self.shape, self.read = values, values.shape, 0

    def __getitem__(self, place):
        self.read += 1
        return self.values[place]


@pytest.mark.parametrize("kind", ["late to settle", "chaotic"])
def test_long_orbits_take_no_time_that_grows_with_the_square(kind):
    keep = 600
    orbit = np.arange(keep) % 2 + np.where(np.arange(keep) < 9, 0.3, 0.0)
    for k in range(1, keep if kind == "chaotic" else 0):
        orbit[k] = 3.9 * orbit[k - 1] * (1.0 - orbit[k - 1]) if k > 1 else 0.3
    x = Counted(np.repeat(orbit[:, None, None], LANES, axis=2))
    s = np.zeros((keep, LANES), np.int64)
    ones, lag = np.ones((1, LANES)), np.zeros(LANES, np.int64)
    least_lags(x, s, 1e-9 * ones, lag + 1, lag + 1, lag)
    assert not lag.any() and x.read < 20 * LANES * keep  # of 600 * 300 pairs for each lane
    x.read = 0
    assert next_cycle(x, s, 0, ones, 1e-9 * ones, 0, 0, 3) == (0 if kind == "chaotic" else 4)
    assert x.read < 20 * keep
