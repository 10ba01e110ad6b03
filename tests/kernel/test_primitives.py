"""What plain Python and a compiler say in two ways must be one thing: compiled and plain, bit for bit."""

import os
from collections import namedtuple
from pathlib import Path

import numpy as np
import pytest

import grazing
from grazing.kernel.compile import address, compiled
from grazing.kernel.lanes import unpacker
from grazing.kernel.primitives import (
    at,
    behind,
    built,
    called,
    called_for_all,
    inlined,
    numbers,
    numbers_at,
    replaced,
)
from grazing.outcome import UserCodeError
from tests.processes import python

Three = namedtuple("Three", "a b c")
unpack = unpacker(Three)


def law(v, row):
    p = unpack(row)
    return -p.a * v / (p.b - p.c * v)


def other_law(v, row):
    return row[1] - row[0] * v


def sweep(work, tables, room, runs, count):
    for n in range(count):
        row = numbers_at(tables[n * room])
        for i in range(runs[n], runs[n + 1]):
            work[i] = row[0] * work[i] + row[1] + tables[n * room + 1]


def calls(function, v, row):
    return called(function, v, row)


def calls_for_all(function, work, tables, room, runs, count):
    called_for_all(function, numbers(work), numbers(tables), room, numbers(runs), count)


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


@pytest.mark.parametrize("runs", [(0, 7), (2, 5), (3, 3), (1, 3, 3, 6)])
def test_a_loop_by_its_address(monkeypatch, runs):
    work, tables = np.random.default_rng(1).normal(size=7), np.zeros((3, 4))
    tables[:, 0], tables[:, 1] = WHERE, (2.5, -0.5, 0.25)
    expected, count = work.copy(), len(runs) - 1
    for row, start, end in zip(tables, runs, runs[1:], strict=False):
        expected[start:end] = ROW[0] * expected[start:end] + ROW[1] + row[1]
    plain, fast = work.copy(), work.copy()
    calls_for_all(in_plain_python(monkeypatch, sweep, "sweep"), plain, tables, 4, np.array(runs), count)
    compiled(calls_for_all)(address(sweep, "sweep"), fast, tables, 4, np.array(runs), count)
    assert np.array_equal(plain, expected)
    assert np.array_equal(fast, expected)


def test_numbers_at_an_address_are_the_numbers():
    found = numbers_at(WHERE)
    assert [found[i] for i in range(3)] == ROW.tolist()


def total(array, start, count):
    items, found = behind(numbers(array), start), 0.0
    for i in range(count):
        found += items[i]
        items[i] = -1
    return found


@pytest.mark.parametrize("kind", [np.float64, np.int64])
@pytest.mark.parametrize("shape", [(12,), (3, 4), (2, 3, 2)])
def test_numbers_of_an_array_stand_one_after_the_other(kind, shape):
    for function in (total, compiled(total), compiled(total, "fast")):
        array = np.arange(12).astype(kind).reshape(shape)
        assert function(array, 3, 5) == 25.0
        assert array.ravel().tolist() == [0, 1, 2, -1, -1, -1, -1, -1, 8, 9, 10, 11]


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
    done = python(program, env={**os.environ, "GRAZING_CACHE": str(tmp_path), "NUMBA_DISABLE_JIT": "0"})
    assert done.stdout.split() == ["True"], done.stderr
