"""The export: what is refused, and a kernel of a few lines as a module."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from grazing.explorer.webassembly import Argument, Entry, exported, linker, linker_version
from grazing.kernel.export import ENVIRONMENT
from grazing.outcome import InputError

needs_linker = pytest.mark.skipif(linker() is None, reason="no WebAssembly linker: install lld or ziglang")
SOURCE = Path(__file__).parents[2] / "src"


def one(x):
    return x + 1.0


def test_an_export_needs_a_process_of_its_own(monkeypatch):
    for name in ENVIRONMENT:
        monkeypatch.delenv(name, raising=False)
    with pytest.raises(InputError, match="a process of their own"):
        exported([Entry("one", one, (), (Argument("x", "float64"),), "float64")])


def test_an_export_needs_a_linker(monkeypatch):
    for name, value in ENVIRONMENT.items():
        monkeypatch.setenv(name, value)
    monkeypatch.setattr("grazing.explorer.webassembly.linker", lambda: None)
    with pytest.raises(InputError, match="install lld"):
        exported([Entry("one", one, (), (Argument("x", "float64"),), "float64")])


def test_the_linker_is_the_one_that_is_asked_for(monkeypatch):
    monkeypatch.setenv("GRAZING_WASM_LD", "/somewhere/wasm-ld --flag")
    assert linker() == ["/somewhere/wasm-ld", "--flag"]


PROGRAM = """
import sys
from grazing.explorer.webassembly import Argument, Entry, exported
from grazing.kernel.primitives import called
from grazing.kernel.elementary import exp, log, power, sincos
from math import floor, sqrt
import math
import numpy as np

def mixed(x, n, out):
    room = np.empty(n)
    for i in range(n):
        room[i] = floor(sqrt(x * i)) + exp(-x) * log(x + i) + sincos(x)[0] + x ** (0.5 * i) + math.log(x) + math.exp(x)
    total = 0.0
    for i in range(n):
        out[i] = room[n - 1 - i]
        total += out[i]
    return total

def count(a, b):
    return a * b - 1

def lost(x):
    return math.gamma(x)

def doubled(x, row):
    return 2.0 * x + row[0]

def at(where, x, row):
    return called(where, x % 0.75, row)

x, n, out = Argument("x", "float64"), Argument("n", "int64"), Argument("out", "float64", ("n",))
entries = [
    Entry("mixed", mixed, (), (x, n, out), "float64"),
    Entry("count", count, (), (Argument("a", "int64"), Argument("b", "int64")), "int64"),
    Entry("doubled", doubled, (), (x, Argument("row", "float64", (1,))), "float64", addressed=True),
    Entry("at", at, (), (Argument("where", "float64"), x, Argument("row", "float64")), "float64"),
]
if sys.argv[1] == "lost":
    entries = [Entry("lost", lost, (), (x,), "float64")]
sys.stdout.buffer.write(exported(entries))
"""


def run(folder, how):
    program = folder / "program.py"
    program.write_text(PROGRAM, encoding="utf-8")
    settings = {**os.environ, **ENVIRONMENT, "GRAZING_CACHE": str(folder), "PYTHONPATH": str(SOURCE)}
    return subprocess.run([sys.executable, str(program), how], env=settings, capture_output=True, check=False)


@needs_linker
def test_a_kernel_as_a_module(tmp_path):
    import ctypes

    import wasmtime

    from grazing.kernel.elementary import exp, log, power, sincos

    done = run(tmp_path, "both")
    assert done.returncode == 0, done.stderr.decode()
    engine = wasmtime.Engine()
    module = wasmtime.Module(engine, done.stdout)
    assert list(module.imports) == []
    store = wasmtime.Store(engine)
    exports = wasmtime.Instance(store, module, []).exports(store)
    place = exports["__heap_base"].value(store)
    exports["arena"](store, place + 800)
    x, n = 1.75, 20
    total = exports["mixed"](store, x, n, place)
    start = ctypes.addressof(exports["memory"].data_ptr(store).contents) + place
    found = (ctypes.c_double * n).from_address(start)[:]
    want = [
        float(int((x * i) ** 0.5)) + exp(-x) * log(x + i) + sincos(x)[0] + power(x, 0.5 * i) + log(x) + exp(x)
        for i in range(n)
    ]
    assert found == want[::-1]
    assert total == sum(found)
    assert exports["count"](store, 7, -6) == -43
    where = exports["doubled"](store)  # of nothing: it says where the kernel lies
    assert exports["at"](store, float(where), -10.4, float(place)) == 2.0 * (-10.4 % 0.75) + found[0]
    assert json.dumps(linker_version(linker())).startswith('"LLD ')


@needs_linker
def test_a_kernel_that_needs_a_library_is_refused_by_name(tmp_path):
    done = run(tmp_path, "lost")
    assert done.returncode != 0
    assert "the kernels need" in done.stderr.decode()
