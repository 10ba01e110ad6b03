"""Both forms of the operations on vectors, and what they are meant to do."""

import os
import platform
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import grazing
from grazing.kernel.compile import compiled
from grazing.kernel.primitives import numbers
from grazing.kernel.vectors import (
    appended,
    failing,
    filled,
    first_bit,
    first_failed,
    handed_back,
    passing,
    transposed,
)  # fmt: skip


def deals(work, to, step, table, where, plus):
    transposed(numbers(work), to, step, numbers(table), where, plus)


def test_records_are_dealt_out_to_rows():
    table = np.random.default_rng(2).normal(size=(3, 40))
    records = np.array([0, 64, 8, 8, 25, 103, 3, 48])
    plain, fast = np.zeros(300), np.zeros(300)
    for work in (plain, fast):
        work[250:258] = records
    deals(plain, 5, 11, table, 250, 9)
    compiled(deals)(fast, 5, 11, table, 250, 9)
    for h in range(4):
        assert np.array_equal(plain[5 + 11 * h : 13 + 11 * h], table.ravel()[records + 9 + h])
    assert np.count_nonzero(plain) == 32 + np.count_nonzero(records)
    assert np.array_equal(fast, plain)


def appends(work, i, place):
    return appended(numbers(work), i, 0, 20, (40, 60), (80, 100), place)


@pytest.mark.parametrize("place", [0, 3])
def test_what_falls_short_is_appended(place):
    """Not a number falls short of anything, and anything of it."""
    random = np.random.default_rng(3)
    for _ in range(50):
        work = random.normal(size=120)
        work[random.integers(0, 40, 3)] = np.nan
        wanted = [k for k in range(2, 10) if not work[k] >= work[20 + k]]
        plain, fast = work.copy(), work.copy()
        assert appends(plain, 2, place) == compiled(appends)(fast, 2, place) == place + len(wanted)
        for found in (plain, fast):
            for source, target in ((40, 80), (60, 100)):
                assert np.array_equal(found[target + place :][: len(wanted)], work[source:][wanted])
                assert np.array_equal(found[target : target + place], work[target : target + place])


def hands_back(work, i, place):
    return handed_back(numbers(work), i, 0, 20, (80, 100), (40, 60), 120, 140, place)


@pytest.mark.parametrize("place", [0, 3])
def test_what_was_appended_is_handed_back(place):
    random = np.random.default_rng(4)
    for _ in range(50):
        work = random.normal(size=160)
        work[random.integers(0, 40, 3)] = np.nan
        chosen = np.array([not work[k] >= work[20 + k] for k in range(2, 10)])
        plain, fast = work.copy(), work.copy()
        assert hands_back(plain, 2, place) == compiled(hands_back)(fast, 2, place) == place + chosen.sum()
        for found in (plain, fast):
            for source, target in ((80, 40), (100, 60), (120, 140)):
                given, kept = found[target + 2 : target + 10], work[target + 2 : target + 10]
                new = work[source + place :][: chosen.sum()]
                wanted = np.minimum(new, kept[chosen]) if target == 140 else new
                assert np.array_equal(given[chosen], wanted)
                assert np.array_equal(given[~chosen], kept[~chosen], equal_nan=True)
        assert np.array_equal(fast, plain, equal_nan=True)
        appends(plain, 2, place)  # and there again
        assert np.array_equal(plain[:120], fast[:120], equal_nan=True)


def fills(work, i, x):
    filled(numbers(work), i, x)


def test_eight_neighbours_are_filled():
    plain, fast = np.zeros(20), np.zeros(20)
    fills(plain, 3, 0.1)
    compiled(fills)(fast, 3, 0.1)
    assert np.array_equal(plain, [0.0] * 3 + [0.1] * 8 + [0.0] * 9)
    assert np.array_equal(fast, plain)


def asks(table, at, step, count, x, y, limit):
    return failing(numbers(table), at, step, count, x, y, limit)


def judges(table, at, step, count, x, y, limit):
    return passing(numbers(table), at, step, count, x, y, limit)


@pytest.mark.parametrize("count", [0, 1, 5, 8, 31, 40])
def test_a_pair_passes_where_it_fails_no_row(table, count):
    """Behind the rows stand some that every pair passes."""
    table[1, 3 + count : 13 + count], table[1, 53 + count : 63 + count] = 0.0, 0.0
    table[1, 103 + count : 113 + count] = 1e300
    verdicts = set()
    for x, y, limit in ((1.0, 2.0, -40.0), (-1.0, 0.5, 3.0), (0.5, 0.0, -3.0), (np.nan, 1.0, 0.0), (1.0, 1.0, np.nan)):
        passes = asks(table, 223, 50, count, x, y, limit) == 0
        assert judges(table, 223, 50, count, x, y, limit) == passes
        if limit == limit and x == x:
            for arithmetic in ("strict", "fast"):
                assert compiled(judges, arithmetic)(table, 223, 50, count, x, y, limit) == passes
        verdicts.add(passes)
    assert verdicts == ({True} if count == 0 else {True, False})


def searches(work, table, at, step, count, upright):
    first_failed(numbers(work), 0, 10, 20, 31, numbers(table), at, step, count, upright)


def lowest(bits):
    return first_bit(bits)


@pytest.fixture
def table():
    """Two tables of 40 rows, the numbers of which lie 50 apart; whole numbers, so that sums are exact."""
    found = np.random.default_rng(5).integers(-3, 4, (2, 220)).astype(float)
    found[:, 150:200] = np.arange(1.0, 51.0)
    return found


@pytest.mark.parametrize("count", [0, 1, 5, 8, 31, 40])
def test_rows_that_a_pair_fails_are_bits(table, count):
    for x, y, limit in ((1.0, 2.0, 0.0), (-1.0, 0.5, 3.0), (0.0, 0.0, -9.0), (np.nan, 1.0, 0.0), (1.0, 1.0, np.nan)):
        p, q, r = (table[1, 3 + h : 3 + h + count] for h in (0, 50, 100))
        wanted = sum(1 << n for n in range(count) if not p[n] * x + q[n] * y + r[n] >= limit)
        assert asks(table, 223, 50, count, x, y, limit) == wanted
        for arithmetic in ("strict", "fast"):
            assert compiled(asks, arithmetic)(table, 223, 50, count, x, y, limit) == wanted


@pytest.mark.parametrize("upright", [0, 1])
@pytest.mark.parametrize("count", [0, 1, 7, 40])
def test_the_first_row_that_fails_is_found_for_eight_pairs(table, count, upright):
    if upright:
        table[1, :50] = 1.0
    random = np.random.default_rng(6)
    for _ in range(20):
        work = random.integers(-4, 5, 40).astype(float)
        work[random.integers(0, 28, 2)] = np.nan
        wanted = np.zeros(8)
        for k in range(8):
            bits = asks(table, 220, 50, count, work[k], work[10 + k], work[20 + k])
            wanted[k] = table[1, 150 + lowest(bits)] if bits else 0.0
        plain = work.copy()
        searches(plain, table, 220, 50, count, upright)
        assert np.array_equal(plain[31:39], wanted)
        assert np.array_equal(np.delete(plain, range(31, 39)), np.delete(work, range(31, 39)), equal_nan=True)
        for arithmetic in ("strict", "fast"):
            fast = work.copy()
            compiled(searches, arithmetic)(fast, table, 220, 50, count, upright)
            assert np.array_equal(fast, plain, equal_nan=True)


def test_the_lowest_bit_is_found():
    for bits in (1, 2, 3, 96, 1 << 40, (1 << 61) + (1 << 33)):
        place = min(n for n in range(62) if bits >> n & 1)
        assert lowest(bits) == compiled(lowest)(bits) == place


OTHER = """
import sys
sys.path[:0] = [{source!r}, {root!r}]
import numpy as np
from grazing.kernel.compile import compiled
from tests.kernel.test_vectors import appends, asks, deals, fills, hands_back, lowest, searches

work = np.random.default_rng(5).normal(size=300)
work[250:258] = [0, 64, 8, 8, 25, 103, 3, 48]
table = np.random.default_rng(2).normal(size=(3, 40))
plain, fast = work.copy(), work.copy()
for kernel in (appends, hands_back):
    assert kernel(plain, 2, 3) == compiled(kernel)(fast, 2, 3)
deals(plain, 5, 11, table, 250, 9), compiled(deals)(fast, 5, 11, table, 250, 9)
fills(plain, 3, 0.1), compiled(fills)(fast, 3, 0.1)
for upright in (0, 1):
    table = np.round(3 * table)  # whole numbers: sums are exact
    table[0, :20] = 1.0 if upright else table[0, :20]
    for kernel, row in ((searches, plain), (compiled(searches), fast)):
        row[:30] = np.round(3 * work[:30])
        kernel(row, table, 0, 20, 13, upright)
    bits = asks(table, 5, 20, 11, *work[:3])
    assert bits == compiled(asks)(table, 5, 20, 11, *work[:3])
assert bits and lowest(bits) == compiled(lowest)(bits)
print(bool(np.array_equal(plain[:80], fast[:80])))
"""


@pytest.mark.skipif(platform.machine() not in ("x86_64", "AMD64"), reason="names processors of this family")
@pytest.mark.parametrize(("name", "features"), [("x86-64", ""), ("haswell", "+avx,+avx2,+fma,+bmi,+bmi2,+popcnt")])
def test_processors_with_narrower_registers(tmp_path, name, features):
    from llvmlite import binding

    able = binding.get_host_cpu_features()
    if not all(able.get(feature.removeprefix("+")) for feature in features.split(",") if feature):
        pytest.skip(f"this processor cannot do what {name} can")
    source = Path(grazing.__file__).parents[1]
    env = {
        **os.environ, "NUMBA_CPU_NAME": name, "NUMBA_CPU_FEATURES": features, "GRAZING_CACHE": str(tmp_path),
    }  # fmt: skip
    env.pop("NUMBA_DISABLE_JIT", None)
    program = OTHER.format(source=str(source), root=str(Path(__file__).parents[2]))
    ran = subprocess.run([sys.executable, "-c", program], env=env, capture_output=True, text=True)
    assert ran.stdout == "True\n", ran.stderr
