"""Compile a plain Python function together with every function it names, in strict or fast arithmetic.

Nothing is decorated: a kernel is a plain function that calls other plain functions by bare name, and
:func:`compiled` follows those names. That is why kernels never write ``module.f``: a name behind a dot could be
neither compiled nor hashed here. The machine code is kept on disk under the hash of all of that source, so an
edit anywhere below a kernel can never be answered from an old file.
"""

from __future__ import annotations

import hashlib
import os
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import cache
from types import CellType, FunctionType
from typing import Any

import numpy as np

from grazing.kernel.content import (
    COMPILED,
    Known,
    Seen,
    below,
    compiled_as,
    digest,
    enclosed,
    frozen,
    is_kernel,
    named,
)
from grazing.kernel.disk import cache_folder as cache_folder
from grazing.kernel.prepared import family, own
from grazing.kernel.prepared import told as said_to_numba
from grazing.kernel.primitives import pointed, signatures
from grazing.kernel.wide import forms, plain
from grazing.outcome import GrazingError, InputError, UserCodeError, told

#: strict: no contraction, so the same bits everywhere. fast: a*b + c may become one fused operation.
FLAGS: dict[str, bool | set[str]] = {"strict": False, "fast": {"contract"}}

_lock = threading.RLock()
_inner: dict[tuple[str, str], Any] = {}
_begun: set[tuple[str, str]] = set()
_outer: dict[tuple[Callable[..., Any], str], Any] = {}


class _Lost:
    """A lock that another thread held when this process was forked from its own: nobody is left to let it go.

    What that thread left half made, in the compiler and in the import of modules, stays half made as well.
    """

    def acquire(self, *_how: Any) -> bool:
        raise GrazingError(
            "this process was forked while another thread compiled, and cannot compile itself; fork before, or "
            "start processes by 'spawn'"
        )

    __enter__ = acquire

    def release(self, *_what: Any) -> None:
        """Nothing was taken."""

    __exit__ = release


def _forked() -> None:
    """Tell a new process which locks are lost."""
    theirs = getattr(sys.modules.get("numba.core.compiler_lock"), "global_compiler_lock", None)
    owners: list[Any] = [sys.modules[__name__], theirs]
    for owner in owners:
        lock = getattr(owner, "_lock", None)
        if lock is None or isinstance(lock, _Lost):
            continue
        if lock.acquire(False):
            lock.release()
        else:
            owner._lock = _Lost()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_forked)


def jit_disabled() -> bool:
    """Whether ``NUMBA_DISABLE_JIT`` asks for plain Python."""
    return os.environ.get("NUMBA_DISABLE_JIT", "0") not in ("", "0")


def apart() -> bool:
    """Whether units have machine code of their own: not where code leaves the process, nor by numba's own pipeline."""
    return not plain() and os.environ.get("GRAZING_UNITS", "1") != "0"


def compiled(function: Callable[..., Any], arithmetic: str = "strict", announce: str = "") -> Callable[..., Any]:
    """Compile a kernel and everything it calls.

    Parameters
    ----------
    function : callable
        A plain Python function; functions it names, globally or in its closure, are compiled with it. Values that
        it names are frozen at the first compilation of a process: pass what varies as a parameter.
    arithmetic : {"strict", "fast"}
        Whether ``a*b + c`` must be two rounded operations (strict) or may be contracted to one (fast).
    announce : str
        Said on the standard error stream before a compilation that takes seconds; kernels found on disk say nothing.

    Returns
    -------
    callable
        The compiled function; with ``NUMBA_DISABLE_JIT=1`` the plain one.

    Raises
    ------
    InputError
        For any other arithmetic.
    UserCodeError
        For a kernel that calls itself.
    """
    if arithmetic not in FLAGS:
        raise InputError(f"arithmetic is {arithmetic!r}; allowed are 'strict' and 'fast'")
    if jit_disabled() or not isinstance(function, FunctionType):
        return function
    with _lock:
        key = (function, arithmetic)
        if key not in _outer:
            _outer[key] = _jit(function, arithmetic, "entry", {}, announce)
        return _outer[key]  # type: ignore[no-any-return]


def ahead(function: Callable[..., Any], arguments: Sequence[tuple[str, int]], who: str) -> Callable[..., Any]:
    """Compile a kernel before it is called, and return it.

    Parameters
    ----------
    function : callable
        A plain Python function, see :func:`compiled`.
    arguments : sequence of tuple
        Of each the kind of its numbers, such as ``"float64"``, and how many axes it has: 0 for one number.
    who : str
        Who is to blame if it does not compile.
    """
    entry: Any = compiled(function)
    if not jit_disabled():
        from numba import types

        kinds = [(getattr(types, kind), axes) for kind, axes in arguments]
        with _lock:
            call(entry.compile, tuple(types.Array(kind, axes, "C") if axes else kind for kind, axes in kinds), who=who)
    return entry  # type: ignore[no-any-return]


@cache
def address(function: Callable[..., Any], signature: str, arithmetic: str = "strict", who: str = "kernel") -> float:
    """Compile a function of numbers and return where its code lies, for :func:`grazing.kernel.primitives.called`.

    A kernel that gets functions by address is compiled once for all of them.

    Parameters
    ----------
    function : callable
        A plain Python function, see :func:`compiled`.
    signature : {"value", "sweep", "block", "derivative"}
        ``value``: ``f(v, row) -> float``; ``sweep``: ``f(work, tables, room, runs, count)``; ``block``:
        ``f(x, said, width, steps)``; ``derivative``: ``f(state, row, found, said)``. All but ``v`` and the integers
        ``room``, ``count``, ``width`` and ``steps`` are addresses: of numbers, ``runs`` and ``said`` of integers.
    arithmetic : {"strict", "fast"}
    who : str
        Who is to blame if it does not compile.

    Returns
    -------
    float
        The address; with ``NUMBA_DISABLE_JIT=1`` the place of the function in a list.
    """
    if jit_disabled():
        pointed.append(function)
        return float(len(pointed) - 1)
    wanted, key = signatures()[signature], (function, f"{arithmetic} by address")
    with _lock:
        if key not in _outer:  # where it stays: its code must not go
            _outer[key] = _jit(function, arithmetic, "entry", {}, python=False)  # type: ignore[arg-type]
        entry = _outer[key]
        call(entry.compile, wanted.args, who=who)
        code = entry.overloads[wanted.args]
    if code.signature.return_type != wanted.return_type:  # what calls an address finds another type nowhere
        raise UserCodeError(f"{who} returns {code.signature.return_type}; let it return {wanted.return_type}")
    return float(code.library.get_pointer_to_function(code.fndesc.llvm_func_name))


@contextmanager
def compiler_time() -> Iterator[Callable[[], float]]:
    """Yield a function that says how many seconds the compiler has taken in the block so far."""
    if jit_disabled():
        yield lambda: 0.0
        return
    from grazing.kernel.private import event

    with event.install_listener("numba:compile", event.TimingListener()) as clock:
        yield lambda: float(clock.duration) if clock.done else 0.0


def call(entry: Callable[..., Any], *args: Any, who: str = "kernel") -> Any:
    """Call a compiled kernel; an error of the compiler, or of a user's function, becomes one sentence."""
    try:
        return entry(*args)
    except (GrazingError, MemoryError):
        raise
    except Exception as error:
        if jit_disabled():
            raise
        if not type(error).__module__.startswith("numba."):
            raise UserCodeError(f"{who} raised {told(error)}; let it return nan where it has no value") from error
        raise UserCodeError(f"{who} does not compile: {_first_sentence(error)}") from None


def _first_sentence(error: Exception) -> str:
    """Reduce a compiler's report to the construct and its line."""
    lines = [line.strip() for line in str(error).splitlines() if line.strip()]
    wanted = ("Untyped global", "No implementation", "Invalid use", "Unknown attribute", "NotDefined", "Unsupported")
    said = [line for line in lines if line.startswith(wanted)][:1] or lines[1:2] or lines[:1]
    files = [line for line in lines if line.startswith("File ")]
    where = [line for line in files if "grazing" not in line][-1:] or files[-1:]
    return "; ".join(said + where) + ". Use arithmetic on floats, math functions and plain tuples only"


def _jit(
    function: FunctionType, arithmetic: str, role: str, known: Known, announce: str = "", python: bool = True
) -> Any:
    wide = not plain()  # which imports numba, and lets no interrupt into that
    import numba

    if numba.config.DISABLE_JIT:
        numba.config.reload_config()  # it may be as it was when numba was imported
    if numba.config.DISABLE_JIT:
        raise InputError("numba is told by a file .numba_config.yaml not to compile; set NUMBA_DISABLE_JIT=1 instead")
    content = digest(function, known)
    resolved = _resolved(function, lambda callee: _inner_jit(callee, arithmetic, known))
    # Machine code from the disk brings its callees along, and the linker knows them by name only: two different
    # kernels must never share a name, whatever process compiled them.
    resolved.__qualname__ = resolved.__name__ = f"{function.__name__}_{arithmetic}_{content[:32]}"
    # no C ever calls a kernel, and none but an entry Python, not even that if its address is what is wanted: skipping
    # the wrappers halves the compile time
    options: dict[str, Any] = {"error_model": "numpy", "fastmath": FLAGS[arithmetic], "nogil": True}
    options |= {"no_cfunc_wrapper": True, "no_cpython_wrapper": role != "entry" or not python}
    # what is not said numba takes from who calls first, and writes it into the name that the linker knows: code, and
    # its speed, would depend on what was compiled before
    options["forceinline"] = getattr(function, "inlined", False)
    way: dict[str, Any] = {}
    if wide:
        from grazing.kernel.pipeline import pipeline
        from grazing.kernel.uninterrupted import uninterrupted

        uninterrupted()
        way["pipeline_class"] = pipeline(role, (function.__module__ or "").partition(".")[0] == "grazing")
    dispatcher = numba.njit(**options, **way)(resolved)
    for each, said in known.items():
        compiled_as.setdefault(each, said)
    if role != "part":
        try:
            from grazing.kernel.cache import KernelCache
        except (ImportError, AttributeError):  # another numba keeps its kernels in another way: they are not kept
            return dispatcher
        units = [_inner_jit(unit, arithmetic, known) for unit in _units(function)] if apart() else []
        dispatcher._cache = KernelCache(resolved, f"{content} {options} {apart()}", units, announce)
    return dispatcher


def _inner_jit(function: FunctionType, arithmetic: str, known: Known) -> Any:
    key = (digest(function, known), arithmetic)
    if key not in _inner:
        if key in _begun:
            raise UserCodeError(f"{function.__name__} calls itself; a kernel must not be recursive")
        role = "unit" if getattr(function, "unit", False) and apart() else "part"
        try:
            _begun.add(key)
            _inner[key] = _jit(function, arithmetic, role, known)
        finally:  # also of an interrupt, after which it is to be had again
            _begun.discard(key)
    return _inner[key]


def _units(function: FunctionType) -> list[FunctionType]:
    """Return the units that a kernel's code may call: those on the way down to other units."""
    found: dict[FunctionType, bool] = {}
    left = below(function)
    while left:
        each = left.pop()
        if each not in found:
            found[each] = getattr(each, "unit", False)
            left += [] if found[each] else below(each)
    return [each for each, unit in found.items() if unit]


def whole(value: Any) -> Any:
    """Return a value as the compiler is to see it.

    A record of whole numbers becomes a module: what stands behind the dot of a module is a constant, as if it had a
    name of its own, while that of a tuple is taken out of all of it at each place.
    """
    if not (isinstance(value, tuple) and hasattr(value, "_asdict")) or not all(type(item) is int for item in value):
        return value
    module = Seen(type(value).__name__)
    vars(module).update(value._asdict())
    return module


def kept(value: Any, met: dict[int, Seen] | None = None) -> Any:
    """Return a value as nobody else can change it: of arrays that are large, or have gaps, code has the place only.

    A module gets a name that says what is in it: code that is given it is called by that.
    """
    met = {} if met is None else met
    if isinstance(value, np.ndarray):
        return np.array(value, order="A", subok=True)
    if isinstance(value, tuple) and (type(value) is tuple or hasattr(value, "_make")):
        items = [kept(item, met) for item in value]
        changed = any(new is not old for new, old in zip(items, value, strict=True))
        return getattr(type(value), "_make", tuple)(items) if changed else value
    if not isinstance(value, Seen):
        return value
    if id(value) not in met:
        met[id(value)] = module = type(value)(value.__name__, digest(value)[:16])
        vars(module).update({key: kept(item, met) for key, item in vars(value).items()})
    return met[id(value)]


class Bits:
    """A number that equals those of its kind and bits alone: defaults that are equal are one to numba."""

    def __eq__(self, other: object) -> bool:
        return type(self) is type(other) and np.array(self).tobytes() == np.array(other).tobytes()

    def __hash__(self) -> int:
        return hash(np.array(self).tobytes())


class Float(Bits, float):
    """A number, see :class:`Bits`."""


class Complex(Bits, complex):
    """A complex one."""


def apart_from(value: Any) -> Any:
    """Return a default that equals no other one of other bits."""
    if isinstance(value, tuple) and (type(value) is tuple or hasattr(value, "_make")):
        return getattr(type(value), "_make", tuple)([apart_from(item) for item in value])
    kind = {float: Float, np.float64: Float, complex: Complex, np.complex128: Complex}.get(type(value))
    return value if kind is None else kind(value)


def _resolved(function: FunctionType, replace: Callable[[FunctionType], Any]) -> FunctionType:
    """Return a copy of the function in which every kernel it names is replaced."""
    # numba imports the module when it reads a kernel from the disk, where equal code may be that of any other: of a
    # notebook, of a file of one's own
    names = {"__name__": COMPILED, "__builtins__": function.__globals__.get("__builtins__")}
    # by its name alone: a record in a closure, or that is a default, may be taken apart as a tuple
    seen = {key: whole(value) if key.isidentifier() else value for key, value in frozen(function).items()}

    def code(key: str, value: Any) -> Any:
        if not isinstance(value, FunctionType):
            return kept(seen[key])
        return replace(value) if is_kernel(value) else forms().get(value, value)

    names |= {name: code(name, value) for name, value in named(function).items()}
    cells = [CellType(code(f"{i}", item)) for i, item in enumerate(enclosed(function))]
    given = apart_from(tuple(kept(seen[f"{i}"]) for i, _ in enumerate(function.__defaults__ or (), len(cells))))
    copy = FunctionType(function.__code__, names, function.__name__, given or None, tuple(cells))
    copy.__kwdefaults__ = {key: apart_from(kept(seen[f"{key}="])) for key in function.__kwdefaults__ or {}}
    copy.original = function  # type: ignore[attr-defined]  # not __wrapped__: its defaults would be taken
    return copy


@cache
def processor() -> str:
    """Return the processor that kernels are compiled for: on another one the last digits of fast ones may differ.

    A family before it is that of prepared kernels, see :mod:`grazing.kernel.prepared`; *plain* says that the forms are,
    *uncompiled* that Python computes. Behind it stands what the environment says to the compiler.
    """
    _system, name, features = own()
    told = said_to_numba()
    how = "plain" if plain() else "" if told else family(name, features)
    how = "uncompiled" if jit_disabled() else how
    return f"{how} {name} {hashlib.sha256(features.encode()).hexdigest()[:8]} {told}".strip()


@cache
def width() -> int:
    """Return how many numbers compiled code may take side by side; 1 in plain forms."""
    if plain():
        return 1
    from grazing.kernel.private import cpu_target
    from grazing.kernel.wide.simd import width_for

    return width_for(cpu_target.target_context)
