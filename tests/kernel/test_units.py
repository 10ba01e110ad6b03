"""Units: machine code of their own that kernels call by name, in this process and out of files of another."""

import json
import os
from pathlib import Path

import pytest
from numba.core import event

import grazing
from grazing.kernel import cache
from grazing.kernel.compile import compiled
from grazing.kernel.content import digest
from grazing.kernel.primitives import inlined, unit
from grazing.kernel.wide import plain
from grazing.parameter import parameter_tuple
from tests.kernel.test_compile import run_in_a_process
from tests.processes import python

pytestmark = pytest.mark.skipif(bool(plain()), reason=f"numba's own pipeline knows no units: {plain()}")


def made(factor):
    """Two callers of one unit, one out of an inlined function, and the unit: as functions that only the disk knows."""

    @unit
    def middle(x, c):
        return (factor * x[0] * c[1], x[1]), 3

    @inlined
    def within(x):
        return middle((x, 2.0), (1.0, 2.0, 3.0))

    def first(x):
        y, n = within(x)
        return y[0] + n

    def second(x):
        y, n = middle((x, 2.0), (1.0, 2.0, 3.0))
        return y[0] - n

    return first, second, middle


class Heard(event.Listener):
    """The names of what is compiled, not of what is in it."""

    def __init__(self):
        self.names = []

    def on_start(self, said):
        self.names.append(said.data["dispatcher"].py_func.__name__.partition("_")[0])

    def on_end(self, _said):
        pass


def test_a_unit_is_compiled_once_and_its_callers_only_name_it(folder):
    factor = float.fromhex(f"0x1.{os.urandom(5).hex()}p0")
    first, second, _middle = made(factor)
    with event.install_listener("numba:compile", Heard()) as heard:
        assert compiled(first)(2.0) == 4.0 * factor + 3.0
        assert compiled(second)(2.0) == 4.0 * factor - 3.0
    assert heard.names.count("middle") == 1
    (code,) = compiled(second).overloads.values()
    text = code.library.get_llvm_str()
    assert "declare" in text and "fmul" not in text
    assert sorted(file.name.partition("-")[0] for file in folder.iterdir()) == ["first", "middle", "second"]


def test_an_edited_unit_is_another_one(folder):
    first, _second, middle = made(1.5)
    other, _second, changed = made(2.5)
    assert digest(middle) != digest(changed) and digest(first) != digest(other)
    assert compiled(first)(2.0) == 9.0 and compiled(other)(2.0) == 13.0


def test_types_of_one_length_are_told_apart(folder):
    """The linker knows a name; that of numba for a named tuple says how long it is, not what its fields are."""

    @unit
    def weighed(p):
        return 2.0 * p.a + p.b

    ab, ba = parameter_tuple(("a", "b")), parameter_tuple(("b", "a"))

    def one(x):
        return weighed(ab(x, 1.0))

    def two(x):
        return weighed(ba(x, 1.0))

    assert compiled(one)(10.0) == 21.0
    assert compiled(two)(10.0) == 12.0


PROGRAM = """
import json, sys
sys.path[:0] = [{source!r}, {root!r}]
from numba.core import event
from grazing.kernel.compile import compiled
from tests.kernel.test_units import Heard, made
with event.install_listener("numba:compile", Heard()) as heard:
    found = [compiled(each)(2.0) for each in made(1.5)[:2] if each.__name__ in sys.argv[1:]]
print(json.dumps([found, sorted({{n for n in heard.names if n in ("first", "second", "middle")}})]))
"""


def in_a_process(folder, *callers):
    source, root = (str(Path(grazing.__file__).parents[1]), str(Path(__file__).parents[2]))
    program = PROGRAM.format(source=source, root=root)
    env = {**os.environ, "GRAZING_CACHE": str(folder)}
    done = python(program, *(callers or ("first", "second")), env=env)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout), done.stderr


def test_files_of_a_unit_may_be_missing_or_damaged(tmp_path):
    """A caller whose unit is not there would end the process: it is made again, with the same numbers."""
    folder, right = tmp_path / "kept", [9.0, 3.0]
    assert in_a_process(folder)[0] == [right, ["first", "middle", "second"]]
    assert in_a_process(folder)[0] == [right, []]
    (file,) = folder.glob("middle-*")
    file.unlink()
    assert in_a_process(folder)[0] == [right, ["middle"]]
    (file,) = folder.glob("middle-*")
    file.write_bytes(file.read_bytes()[:-1])
    found, said = in_a_process(folder)
    assert found == [right, ["middle"]] and "it is damaged" in said
    for file in folder.glob("first-*"):
        file.unlink()
    assert in_a_process(folder)[0] == [right, ["first"]]
    assert in_a_process(folder)[0] == [right, []]


def test_the_name_of_a_unit_does_not_depend_on_its_callers(tmp_path):
    """What is not said of a function numba takes from its caller: files of others would name what is not there."""
    folder = tmp_path / "kept"
    assert in_a_process(folder, "first")[0] == [[9.0], ["first", "middle"]]
    (file,) = folder.glob("middle-*")
    file.unlink()
    assert in_a_process(folder, "second")[0] == [[3.0], ["middle", "second"]]
    assert in_a_process(folder)[0] == [[9.0, 3.0], []]


def test_a_caller_that_names_a_unit_nobody_has_is_compiled_again(folder, monkeypatch):
    first, _second, _middle = made(1.5)
    assert compiled(first)(2.0) == 9.0
    monkeypatch.setattr(cache, "_there", {})  # as if this process had none, and none could be entered
    monkeypatch.setattr(cache.KernelCache, "_enter", lambda self, result: None)
    again, _second, _middle = made(1.5)
    with event.install_listener("numba:compile", Heard()) as heard:
        assert compiled(again)(2.0) == 9.0
    assert "first" in heard.names


def test_a_unit_may_be_given_a_record_and_a_module(tmp_path):
    """What it was given could not be written to the disk with it."""
    (tmp_path / "theirs.py").write_text("K = 3.0\n")
    (tmp_path / "top.py").write_text(
        """
from collections import namedtuple
from grazing.kernel.primitives import unit
import theirs
SIZES = namedtuple("sizes", "a b")(2, 5)

@unit
def inner(sizes, module, x):
    return sizes.a * module.K * x

def outer(x):
    return inner(SIZES, theirs, x) + theirs.K
"""
    )
    said = [run_in_a_process(tmp_path, tmp_path / "cache")[0] for _ in range(2)]
    assert said == [[15.0, 0], [15.0, 1]]
