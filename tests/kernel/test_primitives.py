"""What plain Python and a compiler say in two ways must be one thing: compiled and plain, bit for bit."""

import os
import platform
import subprocess
import sys
from collections import namedtuple
from pathlib import Path

import numpy as np
import pytest

import grazing
from grazing.kernel.compile import address, compiled
from grazing.kernel.lanes import unpacker
from grazing.kernel.primitives import (
    appended,
    at,
    built,
    called,
    called_for_all,
    filled,
    handed_back,
    inlined,
    numbers_at,
    replaced,
    transposed,
)
from grazing.outcome import UserCodeError

Three = namedtuple("Three", "a b c")
unpack = unpacker(Three)


def law(v, row):
    p = unpack(row)
    return -p.a * v / (p.b - p.c * v)


def other_law(v, row):
    return row[1] - row[0] * v


def sweep(work, start, end, row):
    for i in range(start, end):
        work[i] = row[0] * work[i] + row[1]


def calls(function, v, row):
    return called(function, v, row)


def calls_for_all(function, work, start, end, row):
    called_for_all(function, work, start, end, row)


def in_plain_python(monkeypatch, function, signature):
    """Return what ``address`` gives where nothing is compiled."""
    with monkeypatch.context() as patch:
        patch.setenv("NUMBA_DISABLE_JIT", "1")
        return address.__wrapped__(function, signature)


ROW = np.array([0.7, 1.1, 0.3])
WHERE = float(ROW.ctypes.data)


@pytest.mark.parametrize("arithmetic", ["strict", "fast"])
def test_a_law_by_its_address(monkeypatch, arithmetic):
    place = in_plain_python(monkeypatch, law, "value")
    code = address(law, "value", arithmetic)
    entry = compiled(calls, arithmetic)
    for v in np.random.default_rng(0).uniform(-2.0, 0.0, 50).tolist():
        plain = law(v, ROW.tolist())
        assert calls(place, v, WHERE) == plain
        assert entry(code, v, WHERE) == (plain if arithmetic == "strict" else pytest.approx(plain, rel=1e-15))


def test_one_caller_serves_every_address():
    entry = compiled(calls)
    assert entry(address(law, "value"), -1.0, WHERE) == law(-1.0, ROW)
    before = len(entry.overloads)
    assert entry(address(other_law, "value"), -1.0, WHERE) == other_law(-1.0, ROW)
    assert len(entry.overloads) == before == 1
    assert address(law, "value") == address(law, "value") != address(other_law, "value")


def test_an_address_is_a_whole_number_that_a_float_holds():
    code = address(law, "value")
    assert code.is_integer() and 0.0 < code < 2.0**53
    assert WHERE == ROW.ctypes.data


@pytest.mark.parametrize(("start", "end"), [(0, 7), (2, 5), (3, 3)])
def test_a_loop_by_its_address(monkeypatch, start, end):
    work = np.random.default_rng(1).normal(size=7)
    expected = work.copy()
    expected[start:end] = ROW[0] * expected[start:end] + ROW[1]
    plain, fast = work.copy(), work.copy()
    calls_for_all(in_plain_python(monkeypatch, sweep, "sweep"), plain, start, end, WHERE)
    compiled(calls_for_all)(address(sweep, "sweep"), fast, start, end, WHERE)
    assert np.array_equal(plain, expected)
    assert np.array_equal(fast, expected)


def test_numbers_at_an_address_are_the_numbers():
    numbers = numbers_at(WHERE)
    assert [numbers[i] for i in range(3)] == ROW.tolist()


def test_what_does_not_compile_behind_an_address_is_named():
    def opens(v, row):
        return float(f"{v:g}")

    with pytest.raises(UserCodeError, match=r"the reset law opens does not compile: .*Use arithmetic on floats"):
        address(opens, "value", who="the reset law opens")


def test_places_and_named_tuples():
    def entry(numbers, i, row):
        kind = built(Three, replaced(row, 1, numbers[at(i)]))
        return kind, kind.a + kind.b * kind.c

    numbers = np.array([5.0, 6.0, 7.0])
    for i in range(3):
        found, total = compiled(entry)(numbers, i, (1.0, 2.0, 3.0))
        assert (tuple(found), total) == ((1.0, numbers[i], 3.0), 1.0 + 3.0 * numbers[i])
        assert entry(numbers, i, (1.0, 2.0, 3.0)) == (found, total)
    assert [at(i) for i in range(5)] == list(range(5))


def test_an_inlined_kernel_is_the_same_kernel():
    def bare(x):
        return x * x + 0.1

    def marked(x):
        return x * x + 0.1

    assert inlined(marked) is marked
    assert [compiled(lambda x: marked(x))(x) for x in (0.1, 0.3)] == [
        compiled(lambda x: bare(x))(x) for x in (0.1, 0.3)
    ]


def deals(work, to, step, table, where, plus):
    transposed(work, to, step, table, where, plus)


def test_records_are_dealt_out_to_rows():
    table = np.random.default_rng(2).normal(size=(3, 40))
    records = np.array([0, 64, 8, 8, 25, 103, 3, 48])
    plain, fast = np.zeros(300), np.zeros(300)
    for work in (plain, fast):
        work[250:258] = records
    deals(plain, 5, 11, table, 250, 9)
    compiled(deals)(fast, 5, 11, table, 250, 9)
    for h in range(8):
        assert np.array_equal(plain[5 + 11 * h : 13 + 11 * h], table.ravel()[records + 9 + h])
    assert np.count_nonzero(plain) == 64 + np.count_nonzero(records)
    assert np.array_equal(fast, plain)


def appends(work, i, place):
    return appended(work, i, 0, 20, (40, 60), (80, 100), place)


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
    return handed_back(work, i, 0, 20, (80, 100), (40, 60), place)


@pytest.mark.parametrize("place", [0, 3])
def test_what_was_appended_is_handed_back(place):
    random = np.random.default_rng(4)
    for _ in range(50):
        work = random.normal(size=120)
        work[random.integers(0, 40, 3)] = np.nan
        chosen = np.array([not work[k] >= work[20 + k] for k in range(2, 10)])
        plain, fast = work.copy(), work.copy()
        assert hands_back(plain, 2, place) == compiled(hands_back)(fast, 2, place) == place + chosen.sum()
        for found in (plain, fast):
            for source, target in ((80, 40), (100, 60)):
                given, kept = found[target + 2 : target + 10], work[target + 2 : target + 10]
                assert np.array_equal(given[chosen], work[source + place :][: chosen.sum()])
                assert np.array_equal(given[~chosen], kept[~chosen], equal_nan=True)
        assert np.array_equal(fast, plain, equal_nan=True)
        appends(plain, 2, place)  # and there again
        assert np.array_equal(plain, fast, equal_nan=True)


OLDER = """
import sys
sys.path[:0] = [{source!r}, {root!r}]
import numpy as np
from grazing.kernel.compile import compiled
from tests.kernel.test_primitives import appends, deals, fills, hands_back

work = np.random.default_rng(5).normal(size=300)
work[250:258] = [0, 64, 8, 8, 25, 103, 3, 48]
table = np.random.default_rng(2).normal(size=(3, 40))
plain, fast = work.copy(), work.copy()
for kernel in (appends, hands_back):
    assert kernel(plain, 2, 3) == compiled(kernel)(fast, 2, 3)
deals(plain, 5, 11, table, 250, 9), compiled(deals)(fast, 5, 11, table, 250, 9)
fills(plain, 3, 0.1), compiled(fills)(fast, 3, 0.1)
print(bool(np.array_equal(plain[:80], fast[:80])))
"""


@pytest.mark.skipif(platform.machine() not in ("x86_64", "AMD64"), reason="names a processor of this family")
def test_processors_without_wide_registers(tmp_path):
    source = Path(grazing.__file__).parents[1]
    env = {
        **os.environ, "NUMBA_CPU_NAME": "x86-64", "NUMBA_CPU_FEATURES": "", "GRAZING_CACHE": str(tmp_path),
    }  # fmt: skip
    env.pop("NUMBA_DISABLE_JIT", None)
    program = OLDER.format(source=str(source), root=str(Path(__file__).parents[2]))
    ran = subprocess.run([sys.executable, "-c", program], env=env, capture_output=True, text=True)
    assert ran.stdout == "True\n", ran.stderr


def fills(work, i, x):
    filled(work, i, x)


def test_eight_neighbours_are_filled():
    plain, fast = np.zeros(20), np.zeros(20)
    fills(plain, 3, 0.1)
    compiled(fills)(fast, 3, 0.1)
    assert np.array_equal(plain, [0.0] * 3 + [0.1] * 8 + [0.0] * 9)
    assert np.array_equal(fast, plain)


ORDER = """
import sys
sys.path.insert(0, {source!r})
from random import Random
from grazing.kernel.compile import compiled
from grazing.oscillator.flight import divided3

def kernel(a, b, c, d):
    z = divided3(complex(a, b), complex(c, d), complex(0.0, 2.2), 1.3)
    return z.real + z.imag

random = Random(0)
rows = [[random.gauss(0.0, 1.0) for _ in range(4)] for _ in range(500)]
for arithmetic in {order!r}:
    found = [compiled(kernel, arithmetic)(*row) for row in rows]
print(found == [kernel(*row) for row in rows])
"""


@pytest.mark.parametrize("order", [("strict",), ("fast", "strict")])
def test_strict_bits_do_not_depend_on_what_was_compiled_before(tmp_path, order):
    """The compiler shares its complex products between both arithmetics; ours are written out."""
    program = ORDER.format(source=str(Path(grazing.__file__).parents[1]), order=order)
    env = {**os.environ, "GRAZING_CACHE": str(tmp_path), "NUMBA_DISABLE_JIT": "0"}
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, env=env)
    assert done.stdout.split() == ["True"], done.stderr
