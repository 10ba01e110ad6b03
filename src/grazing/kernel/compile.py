"""Compile a plain Python function together with every function it names, in strict or fast arithmetic.

Nothing is decorated: a kernel is a plain function that calls other plain functions by bare name, and
:func:`compiled` follows those names. That is why kernels never write ``module.f``: a name behind a dot could be
neither compiled nor hashed here. The machine code is kept on disk under the hash of all of that source, so an
edit anywhere below a kernel can never be answered from an old file.
"""

from __future__ import annotations

import dis
import hashlib
import math
import os
import sys
import threading
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache, lru_cache
from pathlib import Path
from types import BuiltinFunctionType, CellType, CodeType, FunctionType, ModuleType
from typing import Any

import numpy as np

from grazing.kernel.disk import KernelFiles
from grazing.kernel.disk import cache_folder as cache_folder
from grazing.kernel.primitives import forms, pointed
from grazing.outcome import InputError, UserCodeError

#: strict: no contraction, so the same bits everywhere. fast: a*b + c may become one fused operation.
FLAGS: dict[str, bool | set[str]] = {"strict": False, "fast": {"contract"}}

#: The functions of these modules have a compiled form of their own and are not compiled from their source.
PRIMITIVES = ("grazing.kernel.primitives", "grazing.kernel.turns", "grazing.kernel.rows", "grazing.kernel.vectors")
#: To be raised when this file stores kernels in another way, so that older files are left alone.
LAYOUT = 4

_lock = threading.RLock()
_inner: dict[tuple[FunctionType, str], Any] = {}
_outer: dict[tuple[FunctionType, str], Any] = {}


def jit_disabled() -> bool:
    """Whether ``NUMBA_DISABLE_JIT`` asks for plain Python."""
    return os.environ.get("NUMBA_DISABLE_JIT", "0") not in ("", "0")


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
            _outer[key] = _jit(function, arithmetic, entry=True, announce=announce)
        return _outer[key]  # type: ignore[no-any-return]


@cache
def address(function: Callable[..., Any], signature: str, arithmetic: str = "strict", who: str = "kernel") -> float:
    """Compile a function of numbers and return where its code lies, for :func:`grazing.kernel.primitives.called`.

    A kernel that gets functions by address is compiled once for all of them.

    Parameters
    ----------
    function : callable
        A plain Python function, see :func:`compiled`.
    signature : {"value", "sweep"}
        ``value``: ``f(v, row) -> float``; ``sweep``: ``f(work, tables, room, runs, count)``. All but ``v`` and the
        integers ``room`` and ``count`` are addresses: of numbers, ``runs`` of integers.
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
    from numba import types

    number, count, numbers = types.float64, types.int64, types.CPointer(types.float64)
    kinds = {"value": (number, numbers), "sweep": (numbers, numbers, count, types.CPointer(count), count)}
    wanted = kinds[signature]
    entry: Any = compiled(function, arithmetic)
    with _lock:
        call(entry.compile, wanted, who=who)
        code = entry.overloads[wanted]
    return float(code.library.get_pointer_to_function(code.fndesc.llvm_cfunc_wrapper_name))


@contextmanager
def compiler_time() -> Iterator[Callable[[], float]]:
    """Yield a function that says how many seconds the compiler has taken in the block so far."""
    if jit_disabled():
        yield lambda: 0.0
        return
    from numba.core import event

    with event.install_listener("numba:compile", event.TimingListener()) as clock:
        yield lambda: float(clock.duration) if clock.done else 0.0


def call(entry: Callable[..., Any], *args: Any, who: str = "kernel") -> Any:
    """Call a compiled kernel; a compilation error becomes one sentence that names the construct."""
    if jit_disabled():
        return entry(*args)
    try:
        return entry(*args)
    except Exception as error:
        if not type(error).__module__.startswith("numba."):
            raise
        raise UserCodeError(f"{who} does not compile: {_first_sentence(error)}") from None


def _first_sentence(error: Exception) -> str:
    """Reduce a compiler's report to the construct and its line."""
    lines = [line.strip() for line in str(error).splitlines() if line.strip()]
    wanted = ("Untyped global", "No implementation", "Invalid use", "Unknown attribute", "NotDefined", "Unsupported")
    said = [line for line in lines if line.startswith(wanted)][:1] or lines[1:2] or lines[:1]
    files = [line for line in lines if line.startswith("File ")]
    where = [line for line in files if "grazing" not in line][-1:] or files[-1:]
    return "; ".join(said + where) + ". Use arithmetic on floats, math functions and plain tuples only"


def _jit(function: FunctionType, arithmetic: str, entry: bool, announce: str = "") -> Any:
    import numba

    from grazing.kernel.pipeline import pipeline

    content = digest(function)
    resolved = _resolved(function, lambda callee: _inner_jit(callee, arithmetic))
    # Machine code from the disk brings its callees along, and the linker knows them by name only: two different
    # kernels must never share a name, whatever process compiled them.
    resolved.__qualname__ = resolved.__name__ = f"{function.__name__}_{arithmetic}_{content[:32]}"
    options: dict[str, Any] = {"error_model": "numpy", "fastmath": FLAGS[arithmetic], "nogil": True}
    inlined = getattr(function, "inlined", False)
    if not entry:  # no Python ever calls it: skipping the wrappers halves the compile time
        options |= {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
    if inlined:
        options["forceinline"] = True
    own = function.__module__.partition(".")[0] == "grazing"
    dispatcher = numba.njit(**options, pipeline_class=pipeline(not entry, own))(resolved)
    if entry:
        _attach_cache(dispatcher, resolved, content + repr(options), announce)
    return dispatcher


def _inner_jit(function: FunctionType, arithmetic: str) -> Any:
    key = (function, arithmetic)
    if key not in _inner:
        _inner[key] = None
        _inner[key] = _jit(function, arithmetic, entry=False)
    if _inner[key] is None:
        raise UserCodeError(f"{function.__name__} calls itself; a kernel must not be recursive")
    return _inner[key]


def _is_kernel(value: object) -> bool:
    return isinstance(value, FunctionType) and value.__module__ not in PRIMITIVES


@lru_cache(maxsize=4096)
def _names(code: CodeType) -> frozenset[str]:
    """Return the global names of a function; not those behind a dot, which may only look like one."""
    inner = [const for const in code.co_consts if isinstance(const, CodeType)]
    own = {op.argval for op in dis.get_instructions(code) if op.opname in ("LOAD_GLOBAL", "LOAD_NAME")}
    return frozenset(own.union(*(_names(const) for const in inner)))


def _resolved(function: FunctionType, replace: Callable[[FunctionType], Any]) -> FunctionType:
    """Return a copy of the function in which every kernel it names is replaced."""
    names = {"__name__": function.__module__, "__builtins__": function.__globals__.get("__builtins__")}
    for name in _names(function.__code__) & function.__globals__.keys():
        value = function.__globals__[name]
        names[name] = replace(value) if _is_kernel(value) else forms.get(value, value) if callable(value) else value
    cells = []
    for cell in function.__closure__ or ():
        value = cell.cell_contents
        cells.append(CellType(replace(value) if _is_kernel(value) else value))
    copy = FunctionType(function.__code__, names, function.__name__, function.__defaults__, tuple(cells))
    copy.__kwdefaults__ = function.__kwdefaults__
    return copy


# ---- the hash of everything a kernel is made of


@cache
def processor() -> str:
    """Return the processor that kernels are compiled for: on another one the last digits of fast ones may differ."""
    from llvmlite import binding

    features = hashlib.sha256(binding.get_host_cpu_features().flatten().encode()).hexdigest()
    return f"{binding.get_host_cpu_name()} {features[:8]}"


@cache
def width() -> int:
    """Return how many numbers compiled code may take side by side; 1 in plain Python."""
    if jit_disabled():
        return 1
    from numba.core.registry import cpu_target

    from grazing.kernel.simd import width_for

    return width_for(cpu_target.target_context)


def digest(function: Callable[..., Any]) -> str:
    """Hash a kernel: its bytecode, its constants and, recursively, all that it names.

    Parameters
    ----------
    function : callable
        A plain Python function.

    Returns
    -------
    str
        64 hexadecimal digits; equal for equal code, whatever file or line it stands in.
    """
    return hashlib.sha256(repr(_content(function, ())).encode()).hexdigest()


def _content(value: Any, above: tuple[Any, ...]) -> Any:
    """Return a value whose repr changes whenever the meaning of ``value`` inside a kernel changes."""
    if isinstance(value, FunctionType) and value.__module__ in PRIMITIVES:
        return ("primitive", value.__name__, _text(value.__module__), _text("grazing.kernel.simd"))  # both its forms
    if isinstance(value, FunctionType):
        if value in above:
            return value.__name__
        below = (*above, value)
        code = value.__code__
        names = sorted(_names(code) & value.__globals__.keys())
        return (
            getattr(value, "inlined", False),
            _code_content(code),
            [(name, _content(value.__globals__[name], below)) for name in names],
            [_content(cell.cell_contents, below) for cell in value.__closure__ or ()],
            [_content(default, below) for default in value.__defaults__ or ()],
            sorted((name, _content(default, below)) for name, default in (value.__kwdefaults__ or {}).items()),
        )
    if isinstance(value, tuple):
        kind = (type(value).__name__, getattr(value, "_fields", ()))
        return (kind, [_content(item, above) for item in value])
    if isinstance(value, (type, ModuleType, BuiltinFunctionType)):
        return (getattr(value, "__name__", ""), getattr(value, "_fields", ()))
    if isinstance(value, float):
        return value.hex() if math.isfinite(value) else repr(value)
    if isinstance(value, np.ndarray):
        return (
            "array",
            value.dtype.str,
            value.shape,
            hashlib.sha256(np.ascontiguousarray(value).tobytes()).hexdigest(),
        )
    if value is None or isinstance(value, (int, complex, str, bytes, np.generic)):
        return (type(value).__name__, repr(value))
    return ("object", os.getpid(), id(value))  # unknown: never found again, so never stale


@cache
def _text(module: str) -> str:
    """Hash the text of a module of this folder."""
    name = module.rpartition(".")[2]
    return hashlib.sha256(Path(__file__).with_name(f"{name}.py").read_bytes()).hexdigest()


@lru_cache(maxsize=4096)
def _code_content(code: CodeType) -> Any:
    consts = [_code_content(c) if isinstance(c, CodeType) else (type(c).__name__, repr(c)) for c in code.co_consts]
    return (code.co_code.hex(), consts, code.co_names, code.co_varnames, code.co_freevars)


# ---- the disk cache


def _attach_cache(dispatcher: Any, function: FunctionType, content: str, announce: str) -> None:
    """Give a dispatcher a disk cache whose file name is the hash of its content.

    numba's own cache looks at one file's time stamp and so serves stale code after an edit in a callee.
    """
    import llvmlite
    import numba
    from numba.core.caching import CompileResultCacheImpl, FunctionCache

    ways = _text("grazing.kernel.pipeline") + _text("grazing.kernel.simd")
    versions = f"{LAYOUT} {ways} {numba.__version__} {llvmlite.__version__}"
    stamp = hashlib.sha256(f"{content} {versions}".encode()).hexdigest()

    class Implementation(CompileResultCacheImpl):  # type: ignore[misc]
        def __init__(self, py_func: FunctionType) -> None:
            self._filename_base = f"{py_func.__name__.split('_')[0]}-{stamp[:40]}"

        @property
        def locator(self) -> Any:
            return self

        def ensure_cache_path(self) -> None:
            cache_folder()

        def check_cachable(self, result: Any) -> bool:
            return not (result.lifted or result.library.has_dynamic_globals)

    class ContentCache(FunctionCache):  # type: ignore[misc]
        def __init__(self, py_func: FunctionType) -> None:
            self._name = repr(py_func)
            self._py_func = py_func
            self._impl = Implementation(py_func)
            self._cache_path = os.fspath(cache_folder())
            self._cache_file = KernelFiles(self._cache_path, self._impl.filename_base)
            self.enable()

        def _index_key(self, sig: Any, codegen: Any) -> Any:
            return (sig, codegen.magic_tuple(), stamp)

        def _load_overload(self, sig: Any, target_context: Any) -> Any:
            try:
                found = super()._load_overload(sig, target_context)
            except Exception:  # what the linker does not take is as good as none: compile again
                found = None
            if found is None and announce:
                print(f"grazing: {announce}", file=sys.stderr, flush=True)
            return found

        def _save_overload(self, sig: Any, data: Any) -> None:
            try:
                super()._save_overload(sig, data)
            except OSError as error:  # a full disk must not stop a computation that has its code already
                warnings.warn(f"a compiled kernel could not be kept: {error}", RuntimeWarning, stacklevel=2)

    dispatcher._cache = ContentCache(function)
