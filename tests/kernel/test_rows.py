"""Both forms of the questions to rows, and what they are meant to answer."""

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
from grazing.kernel.rows import all_passed, carried, failing, first_bit, first_failed, passing
from grazing.kernel.wide import plain

ARITHMETICS = ["strict", "fast"]


def asks(table, at, step, count, x, y, limit):
    return failing(numbers(table), at, step, count, x, y, limit)


def judges(table, at, step, count, x, y, limit):
    return passing(numbers(table), at, step, count, x, y, limit)


def searches(work, start, end, table, count, upright):
    """Pairs at 0 and 60, limits to 120, what is found to 180; the margin stands at 10, the rows from 220 on."""
    first_failed(numbers(work), start, end, 0, 60, 120, 180, numbers(table), 10, 50.0, 220, 50, count, upright)


def demands(work, start, end, table, count, upright):
    """What is needed stands at 120; the verdict goes to 180."""
    all_passed(numbers(work), start, end, 0, 60, 120, 180, numbers(table), 220, 50, count, upright)


def carries(work, start, end, table):
    """The map stands at 0, the margin at 10, the weight at 14; what is needed goes to 120."""
    carried(numbers(work), start, end, 0, 60, 120, numbers(table), 0, 10, 50.0, 14)


def lowest(bits):
    return first_bit(bits)


@pytest.fixture
def table():
    """Two tables of rows, the numbers of which lie 50 apart; whole numbers, so that sums are exact."""
    found = np.random.default_rng(5).integers(-3, 4, (2, 220)).astype(float)
    found[:, 150:200] = np.arange(1.0, 51.0)
    found[0, 10:13] = -4.0, 1.0, 2.0
    return found


def pairs(seed):
    """Return four rows of 60 places, pairs in the first two; some are not numbers, some large."""
    random = np.random.default_rng(seed)
    work = random.integers(-4, 5, 240).astype(float)
    work[random.integers(0, 120, 3)] = np.nan
    work[random.integers(0, 120, 2)] = 100.0
    return work


def limits(work, table):
    m0, m1, m2 = table[0, 10:13]
    least = m0 + m1 * np.abs(work[:60]) + m2 * np.abs(work[60:120])
    return np.where(least < 50.0, least, np.nan)


@pytest.mark.parametrize("count", [0, 1, 5, 8, 31, 40])
def test_rows_that_a_pair_fails_are_bits(table, count):
    for x, y, limit in ((1.0, 2.0, 0.0), (-1.0, 0.5, 3.0), (0.0, 0.0, -9.0), (np.nan, 1.0, 0.0), (1.0, 1.0, np.nan)):
        p, q, r = (table[1, 3 + h : 3 + h + count] for h in (0, 50, 100))
        wanted = sum(1 << n for n in range(count) if not p[n] * x + q[n] * y + r[n] >= limit)
        assert asks(table, 223, 50, count, x, y, limit) == wanted
        for arithmetic in ARITHMETICS:
            assert compiled(asks, arithmetic)(table, 223, 50, count, x, y, limit) == wanted


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
            for arithmetic in ARITHMETICS:
                assert compiled(judges, arithmetic)(table, 223, 50, count, x, y, limit) == passes
        verdicts.add(passes)
    assert verdicts == ({True} if count == 0 else {True, False})


PLACES = [(0, 8), (3, 3), (4, 16), (1, 20), (8, 47)]


@pytest.mark.parametrize("upright", [0, 1])
@pytest.mark.parametrize("count", [0, 1, 7, 40])
def test_the_first_row_that_fails_is_found(table, count, upright):
    table[1, :50] = 1.0 if upright else table[1, :50]
    table[1, count : count + 3], table[1, 50 + count : 53 + count] = (1.0 if upright else 0.0), 0.0
    table[1, 100 + count : 103 + count] = 1e300
    for seed, (start, end) in enumerate(PLACES * 4):
        work = pairs(seed)
        wanted, least = np.zeros(end - start), limits(work, table)
        for k in range(start, end):
            bits = asks(table, 220, 50, count, work[k], work[60 + k], least[k])
            wanted[k - start] = table[1, 150 + lowest(bits)] if bits else 0.0
        plain = work.copy()
        searches(plain, start, end, table, count, upright)
        assert np.array_equal(plain[180 + start : 180 + end], wanted)
        assert np.array_equal(plain[120 + start : 120 + end], least[start:end], equal_nan=True)
        assert np.array_equal(plain[:120], work[:120], equal_nan=True)
        for arithmetic in ARITHMETICS:
            fast = work.copy()
            compiled(searches, arithmetic)(fast, start, end, table, count, upright)
            known = np.isfinite(least[start:end]) if count == 0 else np.ones(end - start, bool)
            for first in (120, 180):
                found, plainly = (each[first + start : first + end] for each in (fast, plain))
                assert np.array_equal(found[known], plainly[known], equal_nan=True)


@pytest.mark.parametrize("upright", [0, 1])
@pytest.mark.parametrize("count", [4, 8, 40])
def test_those_that_pass_all_rows_are_free(table, count, upright):
    """What needs no number is never free."""
    seen = set()
    for seed, (start, end) in enumerate(PLACES * 4):
        work = pairs(seed)
        random = np.random.default_rng(seed)
        work[120:180] = random.integers(-40, 4, 60)
        work[120:180][~np.isfinite(work[:60] + work[60:120])] = np.nan  # as it comes of the pairs
        work[120 + random.integers(0, 60, 3)] = np.nan
        p, q, r = (table[1, h : h + count, None] for h in (0, 50, 100))
        rows = (0.0 if upright else p * work[:60]) + (q * work[60:120] + r)
        wanted = np.where((rows >= work[120:180]).all(axis=0), 1.0, -1.0)[start:end]
        plain = work.copy()
        demands(plain, start, end, table, count, upright)
        assert np.array_equal(plain[180 + start : 180 + end], wanted)
        for arithmetic in ARITHMETICS:
            fast = work.copy()
            compiled(demands, arithmetic)(fast, start, end, table, count, upright)
            assert np.array_equal(fast[180 + start : 180 + end], wanted)
            assert np.array_equal(fast[:180], work[:180], equal_nan=True)
        seen |= set(wanted)
    assert seen == {1.0, -1.0}


@pytest.mark.parametrize(("start", "end"), PLACES)
def test_pairs_are_carried_on(table, start, end):
    s0, a00, a01, s1, a10, a11 = table[0, :6]
    work = pairs(9)
    x, y = work[:60], work[60:120]
    wanted = work.copy()
    wanted[:60], wanted[60:120] = s0 + a00 * x + a01 * y, s1 + a10 * x + a11 * y
    wanted[120:180] = limits(wanted, table) - table[0, 14] * wanted[:60]
    assert np.isfinite(wanted[120:180]).any() and np.isnan(wanted[120:180]).any()
    for function in (carries, *(compiled(carries, arithmetic) for arithmetic in ARITHMETICS)):
        found = work.copy()
        function(found, start, end, table)
        for first in (0, 60, 120):
            row = slice(first + start, first + end)
            assert np.array_equal(found[row], wanted[row], equal_nan=True)


def test_the_lowest_bit_is_found():
    for bits in (1, 2, 3, 96, 1 << 40, (1 << 61) + (1 << 33)):
        place = min(n for n in range(62) if bits >> n & 1)
        assert lowest(bits) == compiled(lowest)(bits) == place


OTHER = """
import sys
sys.path[:0] = [{source!r}, {root!r}]
import numpy as np
from grazing.kernel.compile import compiled, width
from tests.kernel import test_rows, test_vectors

table = np.round(3.0 * np.random.default_rng(2).normal(size=(2, 220)))  # whole numbers: sums are exact
table[1, 100:150] += 1e3 * (np.arange(50) >= 24)
ran = []
for seed in range(9):
    work, _bound = test_vectors.marked(seed, 8, 40)
    plain, fast = work.copy(), work.copy()
    ran.append(test_vectors.appends(plain, 8, 40, 3) == compiled(test_vectors.appends)(fast, 8, 40, 3))
    test_vectors.hands_back(plain, 8, 40, 3), compiled(test_vectors.hands_back)(fast, 8, 40, 3)
    ran.append(np.array_equal(plain[:180], fast[:180]))
    for kernel, arguments in (
        (test_vectors.deals, (5, 11, table, 250, 9)), (test_vectors.spreads, (0, 16, table, 7, 3)),
    ):
        plain, fast = np.zeros(300), np.zeros(300)
        plain[250:258] = fast[250:258] = test_vectors.WHOLE + np.array([0, 64, 8, 8, 25, 103, 3, 48])
        kernel(plain, *arguments), compiled(kernel)(fast, *arguments)
        ran.append(np.array_equal(plain, fast))
    plain, fast = np.zeros((2, 60)), np.zeros((2, 60))
    for count in test_vectors.COUNTS:
        for form, (out, other) in ((test_vectors.writes, plain), (compiled(test_vectors.writes), fast)):
            form(out, other.view(np.int64), 7, count, np.round(work), table[0])
        ran.append(np.array_equal(plain.view(np.int64), fast.view(np.int64)))
    work = np.round(np.nan_to_num(test_rows.pairs(seed)))
    for kernel in (test_rows.searches, test_rows.demands):
        for upright in (0, 1):
            table[1, :50] = 1.0 if upright else table[0, 50:100]
            plain, fast = work.copy(), work.copy()
            kernel(plain, 8, 40, table, 24, upright), compiled(kernel)(fast, 8, 40, table, 24, upright)
            ran.append(np.array_equal(plain, fast, equal_nan=True))
    plain, fast = work.copy(), work.copy()
    test_rows.carries(plain, 8, 40, table), compiled(test_rows.carries)(fast, 8, 40, table)
    ran.append(np.array_equal(plain, fast, equal_nan=True))
    bits = test_rows.asks(table, 220, 50, 11, *work[:3])
    ran.append(bits == compiled(test_rows.asks)(table, 220, 50, 11, *work[:3]))
    verdict = test_rows.judges(table, 220, 50, 24, *work[:3])
    ran.append(verdict == compiled(test_rows.judges)(table, 220, 50, 24, *work[:3]))
    ran.append(not bits or test_rows.lowest(bits) == compiled(test_rows.lowest)(bits))
print(all(ran), width())
"""


@pytest.mark.skipif(platform.machine() not in ("x86_64", "AMD64"), reason="names processors of this family")
@pytest.mark.parametrize(
    ("name", "features", "width"),
    [
        ("x86-64", "", 4),
        ("haswell", "+avx,+avx2,+fma,+bmi,+bmi2,+popcnt", 4),
        ("skylake-avx512", "+avx,+avx2,+fma,+bmi,+bmi2,+popcnt,+avx512f,+avx512vl,+avx512dq,+avx512bw", 8),
    ],
)
def test_processors_with_other_registers(tmp_path, name, features, width):
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
    assert ran.stdout == f"True {1 if plain() else width}\n", ran.stderr
