"""Both forms of lists of some, and of records turned into rows."""

import numpy as np
import pytest

from grazing.kernel.compile import compiled, width
from grazing.kernel.primitives import numbers
from grazing.kernel.vectors import (
    WHOLE,
    appended,
    combined,
    handed_back,
    listed,
    made_whole,
    repeated,
    spread,
    transposed,
)  # fmt: skip


def deals(work, to, step, table, where, plus):
    transposed(numbers(work), to, step, numbers(table), where, plus)


def test_records_are_dealt_out_to_rows():
    table = np.random.default_rng(2).normal(size=(3, 40))
    records = np.array([0, 64, 8, 8, 25, 103, 3, 48])
    plain, fast = np.zeros(300), np.zeros(300)
    for work in (plain, fast):
        work[250:258] = records + WHOLE
    deals(plain, 5, 11, table, 250, 9)
    compiled(deals)(fast, 5, 11, table, 250, 9)
    for h in range(4):
        assert np.array_equal(plain[5 + 11 * h : 13 + 11 * h], table.ravel()[records + 9 + h])
    assert np.count_nonzero(plain) == 32 + len(records)
    assert np.array_equal(fast, plain)


def lists(work, to, flags, first):
    return listed(numbers(work), to, flags, first)


def test_places_with_a_flag_are_listed():
    flags = np.array([[1.0 if k >> b & 1 else (0.0, -1.0, np.nan)[b % 3] for b in range(8)] for k in range(256)])
    for one in flags:
        plain, fast = np.full(40, 7.0), np.full(40, 7.0)
        plain[9:17] = fast[9:17] = one
        places = 64.0 + np.flatnonzero(one > 0.0)
        for work, found in ((plain, lists(plain, 21, 9, 64.0)), (fast, compiled(lists)(fast, 21, 9, 64.0))):
            assert found == len(places)
            assert np.array_equal(work[21 : 21 + found], places)
            assert (work[:9] == 7.0).all() and (work[17:21] == 7.0).all() and (work[29:] == 7.0).all()


#: Where FREE, two rows and two lists begin in the arrays below, and how far from each other.
STEP = 60


def appends(work, start, end, place):
    return appended(numbers(work), start, end, 0, (60, 120), (180, 240), place)


def hands_back(work, start, end, place):
    handed_back(numbers(work), start, end, 0, (180, 240), (60, 120), 300, 360, place)


def marked(seed, start, end):
    """Return random numbers, the first row of which says who is free; all beyond the places asked."""
    random = np.random.default_rng(seed)
    work = random.normal(size=7 * STEP)
    work[:STEP] = np.where(random.random(STEP) < random.random(), 1.0, -1.0)
    work[:start], work[end:STEP] = 1.0, 1.0
    return work, start + np.flatnonzero(work[start:end] < 0.0)


PLACES = [(0, 8), (4, 4), (3, 20), (8, 40), (2, 35)]


@pytest.mark.parametrize("place", [0, 3])
@pytest.mark.parametrize(("start", "end"), PLACES)
def test_those_that_are_not_free_are_appended(start, end, place):
    for seed in range(20):
        work, bound = marked(seed, start, end)
        plain, fast = work.copy(), work.copy()
        length = place + len(bound)
        assert appends(plain, start, end, place) == compiled(appends)(fast, start, end, place) == length
        for found in (plain, fast):
            for source, target in ((60, 180), (120, 240)):
                assert np.array_equal(found[target + place : target + length], work[source + bound])
                assert np.array_equal(found[target : target + place], work[target : target + place])
            assert np.array_equal(found[:180], work[:180])


@pytest.mark.parametrize("place", [0, 3])
@pytest.mark.parametrize(("start", "end"), PLACES)
def test_what_was_appended_is_handed_back(start, end, place):
    for seed in range(20):
        work, bound = marked(seed, start, end)
        plain, fast = work.copy(), work.copy()
        hands_back(plain, start, end, place)
        compiled(hands_back)(fast, start, end, place)
        wanted = work.copy()
        for source, target in ((180, 60), (240, 120)):
            wanted[target + bound] = work[source + place : source + place + len(bound)]
        wanted[360 + bound] = np.minimum(work[360 + bound], work[300 + place : 300 + place + len(bound)])
        assert np.array_equal(plain, wanted)
        assert np.array_equal(fast, wanted)
        appends(plain, start, end, place)  # and there again
        assert np.array_equal(plain[180:300], work[180:300])


def spreads(work, start, end, table, at, count):
    spread(numbers(work), start, end, 2, 50, numbers(table), at, count)


@pytest.mark.parametrize(("start", "end"), [(3, 11), (0, 3), (5, 5), (1, 30)])
def test_places_are_filled(start, end):
    """What compiled code writes over the end is less than a vector."""
    table, over = np.arange(40.0) + 0.1, -(start - end) // -width() * width() + start
    plain, fast = np.zeros(200), np.zeros(200)
    spreads(plain, start, end, table, 7, 3)
    compiled(spreads)(fast, start, end, table, 7, 3)
    written = np.zeros(200, bool)
    for h in range(3):
        row = slice(2 + 50 * h + start, 2 + 50 * h + end)
        assert (plain[row] == table[7 + h]).all()
        assert np.array_equal(fast[row], plain[row])
        written[2 + 50 * h + start : 2 + 50 * h + over] = True
    assert np.count_nonzero(plain) == 3 * (end - start)
    assert not fast[~written].any()


# ---- results: so many places and none beyond

COUNTS = [0, 1, 3, 4, 5, 7, 8, 9, 12, 31]


def writes(out, whole, to, count, work, table):
    combined(numbers(out), to, count, numbers(work), 2, 50, numbers(table), 1, 0.75)
    made_whole(numbers(whole), to, count, numbers(work), 100)


def writes_again(out, whole, to, count, start):
    repeated(numbers(out), to, count, start)
    repeated(numbers(whole), to, count, start)


@pytest.mark.parametrize("arithmetic", ["strict", "fast"])
@pytest.mark.parametrize("count", COUNTS)
def test_pairs_are_combined_and_counts_made_whole(count, arithmetic):
    random = np.random.default_rng(count)
    work, table = random.normal(size=150), random.normal(size=8)
    work[100:140] = random.integers(-3, 4000, 40)
    made = []
    for form in (writes, compiled(writes, arithmetic)):
        out, whole = np.full(60, np.nan), np.full(60, -77)
        form(out, whole, 7, count, work, table)
        made.append((out, whole))
    (plain, plain_whole), (fast, fast_whole) = made
    x, y = work[2 : 2 + count], work[50 : 50 + count]
    assert np.array_equal(plain[7 : 7 + count], 0.75 + (table[1] + (table[2] * x + table[3] * y)))
    assert np.array_equal(plain_whole[7 : 7 + count], work[100 : 100 + count])
    assert np.isfinite(plain).sum() == (plain_whole != -77).sum() == count
    assert np.array_equal(fast_whole, plain_whole)
    if arithmetic == "strict":
        assert np.array_equal(fast, plain, equal_nan=True)
    assert np.allclose(fast, plain, rtol=0.0, atol=1e-15, equal_nan=True)


@pytest.mark.parametrize("count", COUNTS)
def test_what_was_written_is_written_again(count):
    random = np.random.default_rng(count)
    numbers_before, whole_before = random.normal(size=80), random.integers(-9, 10**15, 80)
    for form in (writes_again, compiled(writes_again)):
        out, whole = numbers_before.copy(), whole_before.copy()
        form(out, whole, 41, count, 5)
        for now, before in ((out, numbers_before), (whole, whole_before)):
            assert np.array_equal(now[41 : 41 + count], before[5 : 5 + count])
            assert np.array_equal(np.delete(now, np.s_[41 : 41 + count]), np.delete(before, np.s_[41 : 41 + count]))
