"""What the compiler layer promises: two arithmetics, content hashes, a cache that cannot be stale, plain words."""

import cmath
import enum
import json
import math
import os
import shutil
import subprocess
import sys
import textwrap
from collections import namedtuple
from pathlib import Path
from types import ModuleType

import numba
import numpy as np
import pytest

import grazing
from grazing.kernel.compile import cache_folder, call, compiled
from grazing.kernel.content import digest, identity
from grazing.kernel.primitives import inlined
from grazing.kernel.wide import plain
from grazing.outcome import InputError, UserCodeError
from tests.processes import python

SOURCE = str(Path(grazing.__file__).parents[1])
WIDE = pytest.mark.skipif(bool(plain()), reason=f"plain forms are taken: {plain()}")


def own_module(**values):
    made = ModuleType("theirs")
    vars(made).update(values)
    return made


def inner(x):
    return 3.0 * x


def outer(x):
    return inner(x) + 1.0


def test_a_kernel_is_compiled_with_all_it_calls():
    assert compiled(outer)(2.0) == 7.0
    assert compiled(outer) is compiled(outer)


def test_strict_rounds_twice_and_fast_may_not():
    def fused(a, b, c):
        return a * b + c

    a = 1.0 + 2.0**-30
    exact = 2.0**-60  # (1 + e)^2 - (1 + 2e) = e^2, lost when the product is rounded first
    assert compiled(fused, "strict")(a, a, -(1.0 + 2.0**-29)) == 0.0
    assert compiled(fused, "fast")(a, a, -(1.0 + 2.0**-29)) in (0.0, exact)


def test_unknown_arithmetic_is_refused():
    with pytest.raises(InputError, match="arithmetic is 'quick'; allowed are 'strict' and 'fast'"):
        compiled(outer, "quick")


def test_digest_is_that_of_python_without_docstrings():
    """``python -OO`` numbers all constants anew, and compiled every kernel with a docstring again."""
    source = 'def f(x):\n    """{}"""\n    if x > 1.5:\n        return None\n    return [x, {}]\n'

    def of(text, constant="2.0", optimize=0):
        scope = {}
        exec(compile(source.format(text, constant), "f.py", "exec", optimize=optimize), scope)
        return digest(scope["f"])

    assert of("Say.") == of("Say more.") == of("Say.", optimize=2)
    assert of("Say.") != of("Say.", "-2.0") != of("Say.", "2")
    assert of("Say.", "g(a=x)") != of("Say.", "g(b=x)")  # was the same: a kernel was taken for another one


def test_digest_sees_what_a_function_takes():
    """One that takes y was found again for one that takes all that follows."""
    texts = ("lambda x, y: y", "lambda x, *y: y", "lambda x, **y: y", "lambda x, *, y: y", "lambda x, y, /: y")
    assert len({digest(eval(text)) for text in texts}) == len(texts)


def test_digest_sees_callees_constants_defaults_and_closures_but_not_lines():
    def make(text):
        scope = {}
        exec(compile(textwrap.dedent(text), "<kernel>", "exec"), scope)
        return digest(scope["f"])

    base = make("c = 2.0\ndef g(x): return x\ndef f(x, y=1.0): return g(x) + c\n")
    assert make("\n\n# moved\nc = 2.0\ndef g(x): return x\ndef f(x, y=1.0): return g(x) + c\n") == base
    for other in (
        "c = 2.0\ndef g(x): return x + 0.0\ndef f(x, y=1.0): return g(x) + c\n",  # a callee
        "c = 2.5\ndef g(x): return x\ndef f(x, y=1.0): return g(x) + c\n",  # a named constant
        "c = -0.0\ndef g(x): return x\ndef f(x, y=1.0): return g(x) + c\n",
        "c = 2.0\ndef g(x): return x\ndef f(x, y=2.0): return g(x) + c\n",  # a default
        "c = 2\ndef g(x): return x\ndef f(x, y=1.0): return g(x) + c\n",  # a type
    ):
        assert make(other) != base

    def closed(k):
        return lambda x: k * x

    def keyword(k):
        def f(x, *, factor=k):
            return factor * x

        return f

    assert digest(keyword(1.0)) != digest(keyword(2.0))
    long, other = np.ones(3000), np.ones(3000)
    other[1500] = 1.0 + 1e-15  # beyond what a repr shows
    assert digest(closed(long)) != digest(closed(other))
    assert digest(closed(long)) == digest(closed(long.copy()))
    assert digest(closed({"a": 1.0})) != digest(closed({"a": 1.0}))  # of unknown kinds nothing is found again
    assert digest(closed({"a": 1.0}.get)) != digest(closed({"a": 1.0}.get))

    assert digest(closed(1.0)) != digest(closed(2.0))
    assert digest(closed(1.0)) == digest(closed(1.0))


@pytest.mark.parametrize(
    ("text", "name", "before", "after"),
    [
        ("a.K * x", "a", {"K": 2.0}, {"K": 3.0}),
        ("getattr(a, 'K') * x", "a", {"K": 2.0}, {"K": 3.0}),
        ("a.b.K * x", "a", {"b": {"K": 2.0}}, {"b": {"K": 3.0}}),
        ("(lambda y: a.K * y)(x)", "a", {"K": 2.0}, {"K": 3.0}),
        ("abs(root(x))", "root", math.sqrt, cmath.sqrt),
        ("a['K'][0] * x", "a", np.array([(2.0, 3.0)], "f8,f8"), np.array([(2.0, 3.0)], [("f1", "f8"), ("f0", "f8")])),
        ("a(x)[1]", "a", namedtuple("A", "x k", defaults=[2.0]), namedtuple("A", "x k", defaults=[3.0])),
    ],
    ids=lambda value: value if isinstance(value, str) and " " in value else "",
)
def test_digest_sees_what_the_compiler_freezes(text, name, before, after):
    """A constant of a module of the user's own was changed, and maps went on with the old one."""

    def module(value):
        if not isinstance(value, dict):
            return value
        made = ModuleType("theirs")
        vars(made).update({key: module(item) for key, item in value.items()})
        return made

    def of(value):
        scope = {name: module(value)}
        exec(f"def f(x):\n    return {text}\ndef g(x):\n    return f(x)\n", scope)
        return digest(scope["g"])

    assert of(before) == of(before) != of(after)
    if isinstance(before, dict):  # what is not used may be anything
        assert of(before) == of({**before, "other": object()})


#: Pairs of texts of one bytecode, and of one repr of all constants, that mean something else in a kernel.
TWINS = {
    "the lines that a try holds": (
        """
        def g(x):
            if x > 1.0:
                raise ValueError
            return x

        def f(x):
            y = 0.0
            {0}
                z = g(x + 1.0)
            except Exception:
                return -y
            return z
        """,
        "try:\n        y = g(x)",
        "y = g(x)\n    try:",
    ),
    "the lines that an if holds, behind lines that do nothing": (
        """
        def f(x, y):
            if x > 0.0:
                {0}
            return y
        """,
        "pass\n        pass\n        x = x + 1.0\n    y = x",
        "x = x + 1.0\n        y = x",
    ),
    "the sign of a NaN in a tuple": (
        "def f(x):\n    for n in ({0}(1e999 - 1e999), 2.0): x = math.copysign(x, n)\n    return x",
        "",
        "-",
    ),
    "a number of a class": ("class C:\n    K = {0}\ndef f(x): return x * C.K", "2.0", "3.0"),
    "one of a class below it": (
        "class B:\n    K = {0}\nclass C(B):\n    __slots__ = ()\n    def f(x): return x * C.K\ndef f(x): return C.f(x)",
        "2.0",
        "3.0",
    ),
    "how the numbers of an array lie": (
        "A = np.arange(6.0).reshape(2, 3).copy({0})\ndef f(x): return x * A.strides[0]",
        "'C'",
        "'F'",
    ),
    "what is behind a module that is a default": ("def f(x, m=module({0})): return x * m.K", "2.0", "3.0"),
    "what is behind one that is a keyword's": ("def f(x, *, m=module({0})): return x * m.K", "2.0", "3.0"),
    "what is behind one that is called as a library": (
        "class C:\n    K = {0}\nm = module(C, 'C')\nm.__name__ = 'math'\ndef f(x): return x * m.C.K",
        "2.0",
        "3.0",
    ),
    "the sign of a NaN": ("N = {0}math.nan\ndef f(x): return math.copysign(x, N)", "", "-"),
    "the sign of a NaN in the text": ("def f(x): return math.copysign(x, {0}(1e999 - 1e999))", "", "-"),
    "an enum that shows no number": (
        "class E(enum.IntEnum):\n    __repr__ = enum.Enum.__str__\n    A = {0}\nA = E.A\ndef f(x): return x * A",
        "2",
        "3",
    ),
    "a number that shows no number": (
        "class C(complex):\n    def __repr__(self): return 'C'\nA = C({0})\ndef f(x): return (x * A).real",
        "2",
        "3",
    ),
    "a number that shows another number": (
        "class F(float):\n    def hex(self): return '0x0'\nA = F({0})\ndef f(x): return x * A",
        "2",
        "3",
    ),
    "which module of a ring comes next": (
        "a, b, c = module(1.0), module(2.0), module(3.0)\na.n, b.n, c.n = b, c, {0}\ndef f(x): return a.n.n.n.K * x",
        "a",
        "b",
    ),
    "which module of a ring stands in a pair": (
        "a, b = module(1.0), module(2.0)\na.n, b.n = (b, 1), ({0}, 1)\ndef f(x): return a.n[0].n[0].K * x",
        "a",
        "b",
    ),
}


@pytest.mark.parametrize("what", TWINS)
def test_digest_sees_what_bytecode_and_repr_do_not_show(what):
    """The compiled kernel of the one text was run for the other."""
    text, *both = TWINS[what]

    def module(value, name="K"):
        made = ModuleType("theirs")
        setattr(made, name, value)
        return made

    def made(change):
        scope = {"module": module, "math": math, "enum": enum, "np": np, "__name__": "theirs"}
        exec(textwrap.dedent(text).replace("{0}", change), scope)
        return digest(scope["f"])

    assert made(both[0]) == made(both[0]) != made(both[1])


@pytest.mark.parametrize(
    ("library", "name", "value", "function"),
    [
        (math, "pi", 3.0, lambda x: x * math.pi),
        (math, "pair", (3.0, 1.0), lambda x: x * math.pair[0]),
        (np, "row", np.ones(2), lambda x: x * np.row[0]),
        (np.linalg, "K", 3.0, lambda x: x * np.linalg.K),
        (np, "mine", own_module(K=3.0), lambda x: x * np.mine.K),
    ],
)
def test_digest_sees_what_was_set_in_a_library(monkeypatch, library, name, value, function):
    """What is behind the dot of a module of one's own was seen, that behind ``math`` or ``numpy`` was not."""
    before = digest(function)
    monkeypatch.setattr(library, name, value, raising=False)
    assert digest(function) != before


@pytest.mark.parametrize(
    "text",
    [
        "class E(enum.Enum):\n    A = {0}\nmath.mine = E\ndef f(x): return x * math.mine.A.value",
        "class E(enum.Enum):\n    A = {0}\nmath.mine = E.A\ndef f(x): return x * math.mine.value",
        "math.mine = numba.njit(lambda x: {0} * x)\ndef f(x): return math.mine(x)",
    ],
)
def test_what_is_set_in_a_library_is_not_its_own(monkeypatch, text):
    """Of an enum and a compiled function the hash held the name alone."""
    monkeypatch.setattr(math, "mine", 0.0, raising=False)
    for k in (2.0, 3.0, 2.0):
        scope = {"math": math, "enum": enum, "numba": numba, "__name__": "theirs"}
        exec(text.replace("{0}", str(k)), scope)
        assert compiled(scope["f"])(1.5) == 1.5 * k


def test_modules_that_all_name_each_other_are_hashed_at_once():
    """Every way through them was gone."""
    modules = [own_module(K=float(i)) for i in range(12)]
    for module in modules:
        vars(module).update({f"m{i}": each for i, each in enumerate(modules)})
    scope = {"m": modules[0]}
    exec(f"def f(x): return x * ({' + '.join(f'm.m{i}.K' for i in range(12))})", scope)
    assert compiled(scope["f"])(1.0) == 66.0


class Lazy(ModuleType):
    """A package that imports what it is asked for."""

    def __getattr__(self, name):
        if name == "K":
            return 2.0
        raise ModuleNotFoundError(f"No module named 'theirs.{name}'")


def test_a_module_is_not_asked_for_what_stands_behind_no_dot_or_is_not_there(recwarn):
    """A package that imports what it is asked for was asked for all; NumPy warns of ``str``."""
    theirs, unit = Lazy("theirs"), own_module(L=3.0)

    def f(x):
        return theirs.K * unit.L * x * len(str(1)) * np.cos(0.0)

    assert compiled(f)(1.5) == 9.0
    assert not [one for one in recwarn if "np.str" in str(one.message)]


@pytest.mark.parametrize("both", [(math.floor, math.ceil), (float, int), (np.float64, np.int64), (np.floor, np.ceil)])
def test_what_is_a_library_own_is_another_by_another_name(monkeypatch, both):
    """The hash held the name that a program had given it, alone."""
    for one in both:
        monkeypatch.setattr(math, "mine", one, raising=False)
        assert compiled(lambda x: math.mine(x))(1.5) == one(1.5)


@pytest.mark.skipif(not hasattr(os, "fork"), reason="two processes are forked, to be alike")
def test_a_function_that_a_kernel_is_given_is_another_in_every_process(folder):
    """Where addresses are not random, that of another process was taken for it."""

    def given(g, x):
        return g(x) + 1.0

    def said(k):
        made = numba.njit(eval(f"lambda x: {k} * x"))
        made.__class__.__repr__ = lambda self: "as in the other process"
        return compiled(given)(made, 1.5)

    for k in (2.0, 3.0):
        read, write = os.pipe()
        child = os.fork()
        if not child:
            try:
                os.write(write, str(said(k)).encode())
            finally:
                os._exit(0)  # whatever happened: there is a second run of the tests otherwise
        os.close(write)
        with os.fdopen(read) as pipe:
            assert float(pipe.read()) == 1.5 * k + 1.0
        os.waitpid(child, 0)


PROGRAM = """
import json, sys
sys.path.insert(0, {source!r}); sys.path.insert(0, {folder!r})
import top
from grazing.kernel.compile import compiled
said = []
for name in {names!r}:
    entry = compiled(getattr(top, name))
    said += [entry(2.0), sum(entry.stats.cache_hits.values())]
print(json.dumps(said))
"""


def run_in_a_process(folder, cache, source=SOURCE, names=("outer",), **environment):
    program = PROGRAM.format(source=str(source), folder=str(folder), names=names)
    env = {**os.environ, "GRAZING_CACHE": str(cache), "PYTHONDONTWRITEBYTECODE": "1", **environment}
    done = python(program, env=env)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout), done.stderr


@pytest.mark.skipif(not hasattr(os, "fork"), reason="two processes are forked, to be alike")
def test_what_nobody_knows_is_another_in_every_process(monkeypatch):
    """Two containers give their processes the same number, and objects the same address where it is not random."""

    def said():
        unknown = object()
        sin, clip = np.sin, np.clip

        class Theirs:
            __slots__ = ("b",)
            a: float
            made = staticmethod(lambda x: 2.0 * x)
            again = classmethod(lambda cls, x: 3.0 * x)
            half = property(lambda self: 0.5 * self.b)

        known = digest(lambda x: (clip(sin(x), 0.0, 1.0), Theirs, numba.TypingError))
        return id(unknown), digest(lambda: unknown), digest(lambda: unknown), known

    monkeypatch.setattr(os, "getpid", lambda: 1)
    found = []
    for _ in range(2):
        read, write = os.pipe()
        child = os.fork()
        if child == 0:
            os.write(write, json.dumps(said()).encode())
            os._exit(0)
        os.waitpid(child, 0)
        found.append(json.loads(os.read(read, 1000)))
        os.close(read)
        os.close(write)
    (place, one, again, known), (same_place, other, _, same_known) = found
    assert place == same_place and one == again
    assert one != other
    assert known == same_known  # was another: no sweep of a map with ``from numpy import sin`` was gone on with


def test_an_edit_in_a_callee_is_never_answered_from_the_cache(tmp_path):
    (tmp_path / "leaf.py").write_text("def inner(x):\n    return 2.0 * x\n")
    (tmp_path / "top.py").write_text("from leaf import inner\n\ndef outer(x):\n    return inner(x) + 1.0\n")
    cache = tmp_path / "cache"
    assert run_in_a_process(tmp_path, cache)[0] == [5.0, 0]
    assert run_in_a_process(tmp_path, cache)[0] == [5.0, 1]  # the second process finds the machine code
    stamp = (tmp_path / "leaf.py").stat()
    (tmp_path / "leaf.py").write_text("def inner(x):\n    return 3.0 * x\n")
    os.utime(tmp_path / "leaf.py", ns=(stamp.st_atime_ns, stamp.st_mtime_ns))  # same time, same size
    assert run_in_a_process(tmp_path, cache)[0] == [7.0, 0]
    for stored in cache.glob("*.nbc"):  # torn files are as good as none
        stored.write_bytes(stored.read_bytes()[:50])
    assert run_in_a_process(tmp_path, cache)[0] == [7.0, 0]


#: Kernels around forms that write code, by the form's name, and what they give for 2.
FORMS = """
from grazing.kernel.primitives import at
from grazing.kernel.rows import first_bit
from grazing.kernel.turns import eights

def uses_at(x):
    return 1.0 * at(int(x))

def uses_eights(x):
    return 1.0 * eights(int(x))

def uses_first_bit(x):
    return 1.0 * first_bit(int(x))
"""
GIVEN = {"at": 2.0, "eights": 2.0, "first_bit": 1.0}


@pytest.fixture(scope="module")
def copied(tmp_path_factory):
    """A copy of the source, to be edited, and a cache with kernels that a process compiled and another one found."""
    folder = tmp_path_factory.mktemp("copied")
    leave = shutil.ignore_patterns("__pycache__", "*.wasm", "prepared")
    shutil.copytree(Path(SOURCE) / "grazing", folder / "source" / "grazing", ignore=leave)
    (folder / "top.py").write_text(FORMS)
    names = [f"uses_{name}" for name in GIVEN]
    for hits in (0, 1):
        found = run_in_a_process(folder, folder / "cache", folder / "source", names)[0]
        assert found == [each for value in GIVEN.values() for each in (value, hits)]
    return folder


@pytest.mark.parametrize(
    ("name", "function", "line", "edit", "after"),
    [
        ("primitives", "at", "return args[0]", "return _builder.add(args[0], args[0])", 4.0),
        pytest.param("wide/turns", "eights", "min(width_for", "max(width_for", 2.0, marks=WIDE),
        pytest.param("wide/simd", "eights", "number, whole, short = ", "number, whole, short  = ", 2.0, marks=WIDE),
        pytest.param("pipeline", "first_bit", '"with_lifting", ', "", 1.0, marks=WIDE),
        ("rows", "first_bit", "return int(", "return 1 + int(", 2.0),
    ],
)
def test_an_edit_of_a_compiled_form_is_never_answered_from_the_cache(copied, name, function, line, edit, after):
    """It is code that writes code, which no bytecode of a kernel shows."""
    file = copied / "source" / "grazing" / "kernel" / f"{name}.py"
    before = file.read_text()
    assert line in before
    file.write_text(before.replace(line, edit))
    try:
        found = run_in_a_process(copied, copied / "cache", copied / "source", [f"uses_{function}"])[0]
    finally:
        file.write_text(before)
    assert found == [after, 0]


SISTERS = """
import json, sys
sys.path[:0] = [{source!r}, {root!r}]
import grazing as gz
from tests.models import MODELS, packed

same = []
for name in {names!r}:
    P = gz.discontinuity_map(MODELS[name], order="full", phase=0.7)
    for v in (-0.1, -0.4):
        state = (0.16, v)
        same.append(P(state)[0].tolist() == list(P.step(state, packed(P))[0]))
print(json.dumps(same))
"""


def test_cached_kernels_of_one_family_do_not_mix(tmp_path):
    """Two processes compile maps that differ in the reset law alone; a third loads both and must keep them apart."""
    env = {**os.environ, "GRAZING_CACHE": str(tmp_path)}

    def agree(names):
        program = SISTERS.format(source=SOURCE, root=str(Path(__file__).parents[2]), names=names)
        done = python(program, env=env)
        assert done.returncode == 0, done.stderr
        return json.loads(done.stdout)

    assert agree(["under-damped"]) == agree(["own law"]) == [True, True]
    assert agree(["under-damped", "own law"]) == [True] * 4


def test_a_cache_that_cannot_be_written_falls_back_with_one_warning(tmp_path):
    (tmp_path / "top.py").write_text("def outer(x):\n    return x + 1.0\n")
    (tmp_path / "file").write_text("")  # a file where the folder should be
    result, said = run_in_a_process(tmp_path, tmp_path / "file", TMPDIR=str(tmp_path))
    assert result[0] == 3.0
    assert said.count("compiled kernels cannot be kept") == 1 and "Set GRAZING_CACHE to choose" in said


def test_cache_folder_honours_the_environment():
    assert os.access(cache_folder(), os.W_OK)


def built(x):
    return 2.0 * x


def test_a_users_function_may_have_the_name_of_a_primitive():
    def calls(x):
        return built(x) + 1.0

    assert compiled(calls)(3.0) == 7.0


#: Ways by which a function takes what stands behind the dot of a module, whose name stands in another function.
ELSEWHERE = [
    "def g(n, x): return n.K * x\ndef f(x): return g(m, x)",
    "def g(n, x): return n[1].K * x\ndef f(x): return g((1.0, m), x)",
    "def g(): return m\ndef f(x): return g().K * x",
    "def g():\n    yield m\ndef f(x):\n    for n in g(): x = n.K * x\n    return x",
    "def g(n, x): return getattr(m, n) * x\ndef f(x): return g('K', x)",
    "def g(*n): return getattr(m, n[0]) * n[1]\ndef f(x): return g('K', x)",
    "def n(): return 'K'\ndef g(x): return getattr(m, n()) * x\ndef f(x): return g(x)",
    "look = getattr\ndef g(n, x): return look(m, n[0]) * x\ndef f(x): return g(('K', 1), x)",
    "def g(n, x): return getattr(m, n, 1.0) * x\ndef f(x): return g('K', x)",
    "def g(n, x): return x if hasattr(m, n) else -x\ndef f(x): return g('K', x)",
    "def g(n, x): return n.m.K * x\ndef f(x): return g(m.m, x)",
]


@pytest.mark.parametrize("module", ["theirs", "math"])
@pytest.mark.parametrize("text", ELSEWHERE)
def test_what_is_behind_a_module_is_taken_where_the_module_is_named(text, module, monkeypatch):
    """Neither hash held the number: kernels went on with the old one, from the disk, too."""
    named = math if module == "math" else ModuleType("theirs")
    monkeypatch.setattr(named, "K", 2.0, raising=False)
    monkeypatch.setattr(named, "m", named, raising=False)
    scope = {"m": named}
    exec(text, scope)
    for _ in range(2):  # the second time it was said to call itself
        with pytest.raises(UserCodeError, match=f"{module} has no K, or none that is taken where {module} is named"):
            call(compiled(scope["f"]), 1.5)


def test_a_module_may_be_handed_on_with_what_is_taken_where_it_is_named():
    def shape(library, theirs, x):
        return library.sin(x) * theirs.K

    def handing(library, theirs):
        return lambda x: shape(library, theirs, x) + 0.0 * library.sin(x) * theirs.K

    found = [compiled(handing(math, own_module(K=k)))(0.5) for k in (2.0, 3.0, 2.0)]
    assert found == [k * math.sin(0.5) for k in (2.0, 3.0, 2.0)]


def test_a_record_of_whole_numbers_may_be_handed_on():
    """To the compiler it is a module, but its numbers are hashed where it has its name."""
    kind = namedtuple("kind", "a b")

    def taken(record, x):
        return record.a * x

    def handing(record):
        return lambda x: taken(record, x)

    assert [compiled(handing(kind(a, 3)))(1.5) for a in (2, 5, 2)] == [3.0, 7.5, 3.0]


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("math.copysign(x, of)", [(0.0, 1.5), (-0.0, -1.5), (np.float64(0.0), 1.5), (np.float64(-0.0), -1.5)]),
        ("math.copysign(x, of[0])", [((0.0, 1.0), 1.5), ((-0.0, 1.0), -1.5)]),
        ("math.copysign(x, of.imag)", [(complex(0.0, 0.0), 1.5), (complex(0.0, -0.0), -1.5)]),
        ("x + of[0] * 2**62", [((4,), 1.5), ((4.0,), 2.0**64)]),  # whole numbers have 64 bits
    ],
)
def test_defaults_that_are_equal_are_not_one(text, found):
    """To numba a default of -0.0 is that of 0.0 which it has met, and 4 in a pair is 4.0."""
    for value, wanted in (*found, *found[::-1]):
        scope = {"math": math, "value": value}
        exec(f"def g(x, of=value): return {text}\ndef f(x): return g(x)", scope)
        assert compiled(scope["f"])(1.5) == wanted


def test_a_function_whose_closure_is_not_complete_is_refused():
    def f(x):
        return later * x

    with pytest.raises(InputError, match="f names what has no value yet"):
        compiled(f)
    later = 2.0


def test_recursion_is_refused():
    def loop(x):
        return loop(x - 1.0)

    with pytest.raises(UserCodeError, match="loop calls itself; a kernel must not be recursive"):
        compiled(lambda x: loop(x))


def test_an_interrupted_compilation_can_be_made_again(monkeypatch):
    def interrupted(*_way, **_options):
        raise KeyboardInterrupt

    def callee(x):
        return 5.0 * x

    with monkeypatch.context() as patch:
        patch.setattr(numba, "njit", interrupted)
        with pytest.raises(KeyboardInterrupt):
            compiled(lambda x: callee(x))
    assert compiled(lambda x: callee(x))(2.0) == 10.0


def test_what_does_not_compile_is_named():
    def opens(x):
        return len({"a": x}.popitem()) + open("nowhere")

    with pytest.raises(UserCodeError, match=r"the step of mine does not compile: .*open.*Use arithmetic on floats"):
        call(compiled(opens), 1.0, who="the step of mine")


@pytest.mark.parametrize("value", ["0", ""])
def test_plain_python_when_the_jit_is_off(tmp_path, value):
    program = (
        f"import sys; sys.path.insert(0, {SOURCE!r})\n"
        "from grazing.kernel.compile import compiled\n"
        "from grazing.kernel.elementary import exp\n"
        "print(compiled(exp) is exp, 'numba' in sys.modules)"
    )
    env = {**os.environ, "NUMBA_DISABLE_JIT": "1"}
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, env=env)
    assert done.stdout.split() == ["True", "False"], done.stderr
    env["NUMBA_DISABLE_JIT"] = value
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, env=env)
    assert done.stdout.split() == ["False", "True"], done.stderr


def test_a_file_that_tells_numba_not_to_compile_is_said(monkeypatch):
    """Numba alone reads it, .numba_config.yaml in the folder of a process: it ended in an AttributeError."""
    import numba

    monkeypatch.setattr(numba.config, "DISABLE_JIT", 1)
    monkeypatch.setattr(numba.config, "reload_config", lambda: None)
    with pytest.raises(InputError, match=r"\.numba_config\.yaml not to compile; set NUMBA_DISABLE_JIT=1 instead"):
        compiled(lambda x: x + 1.0)


def test_compiled_kernels_release_the_lock():
    entry = compiled(outer)
    assert entry.targetoptions["nogil"] is True
    assert np.isfinite(entry(1.0))


def test_a_mark_changes_the_hash():
    """Code that is compiled into its caller may be contracted with it: in fast arithmetic its bits can differ."""

    def marked(x):
        return 2.0 * x

    before = digest(marked)
    assert digest(inlined(marked)) != before


FORKED = """
import os, signal, sys, threading, warnings
import numba.core.compiler_lock as theirs
from grazing.kernel import compile as ours
from grazing.outcome import GrazingError

warnings.simplefilter("ignore")
owner = {"ours": ours, "numba's": theirs.global_compiler_lock}[sys.argv[1]]
taken, over = threading.Event(), threading.Event()

def work():
    with owner._lock:
        taken.set()
        over.wait()

thread = threading.Thread(target=work)
thread.start()
taken.wait()
pid = os.fork()
if not pid:
    signal.alarm(10)
    try:
        ours.call(ours.compiled(lambda x: 3.0 * x + 17.25), 2.0)
    except GrazingError as error:
        print(error, flush=True)
    os._exit(0)
print(os.waitpid(pid, 0)[1])
over.set()
thread.join()
print(ours.compiled(lambda x: 3.0 * x + 17.25)(2.0))
"""


@pytest.mark.skipif(not hasattr(os, "fork"), reason="processes")
@pytest.mark.parametrize("lock", ["ours", "numba's"])
def test_a_process_forked_while_another_thread_compiles_says_so(lock, tmp_path):
    """It waited for a thread that is not there."""
    env = {**os.environ, "NUMBA_DISABLE_JIT": "0", "GRAZING_CACHE": str(tmp_path)}
    done = python(f"import sys; sys.path.insert(0, {SOURCE!r})\n{FORKED}", lock, env=env)
    assert done.returncode == 0, done.stderr
    said, status, value = done.stdout.splitlines()
    assert "was forked while another thread compiled" in said and (status, value) == ("0", "23.25")


def test_a_result_never_names_other_numbers_than_its_code_was_compiled_with():
    """A number that a step names was changed after the first call: results had its hash, and the old code."""
    scope = {"C": 1.0, "A": np.array([1.0])}
    text = "def step(state, p):\n    return p.a * C * A[0] * state\n"
    exec(text, scope)
    step, a = scope["step"], namedtuple("p", "a")(0.5)
    assert compiled(step)(1.0, a) == 0.5
    before = identity(step)
    for change in ("C = 2.0", "A[0] = 3.0"):
        exec(change, scope)
        with pytest.raises(InputError, match=r"a value that step names.* define step again, or make"):
            identity(step)
        exec(text, scope)
        assert identity(scope["step"]) != before
        exec("C, A[0] = 1.0, 1.0", scope)
    assert identity(step) == before and compiled(step)(1.0, a) == 0.5


@pytest.mark.parametrize("made", [lambda: np.arange(6.0)[::2], lambda: np.arange(200_000.0)], ids=["gaps", "large"])
@pytest.mark.parametrize(
    "text",
    ["lambda x: a[1] * x", "lambda x, b=a: b[1] * x", "tupled(a)", "lambda x: module.a[1] * x", "moduled(a)"],
)
def test_the_array_of_one_function_is_not_that_of_an_equal_one(made, text, folder):
    """Two with equal arrays have one code, which looked into the first of them after that had changed."""

    def tupled(a):
        both = a, 2.0
        return lambda x: both[0][1] * x

    def behind(a):
        found = ModuleType("theirs")
        found.a = found.b = a
        found.inner = ModuleType("below")
        found.inner.pair = a, 1.0
        return found

    def moduled(a):
        module = behind(a)
        return lambda x, m=module: m.inner.pair[0][1] * x

    def scope(a):
        return {"a": a, "tupled": tupled, "moduled": moduled, "module": behind(a)}

    def around(inner):
        return lambda x: inner(x)

    first, second = made(), made()
    inner = [eval(text, scope(array)) for array in (first, second)]
    one, other = (compiled(around(each)) for each in inner)
    before = one(1.0)
    assert other(1.0) == before
    first[1] = 50.0
    assert other(1.0) == before == inner[1](1.0)
    inner.append(eval(text, scope(second.copy())))
    assert digest(inner[1]) == digest(inner[2])  # as a worker has it, out of a pickle
