"""The content of a kernel as a hash: what two kernels share exactly if they are compiled to the same code."""

from __future__ import annotations

import dis
import hashlib
import inspect
import math
import sys
from collections.abc import Callable
from functools import cache, lru_cache
from pathlib import Path
from types import (
    BuiltinFunctionType,
    CodeType,
    FunctionType,
    GetSetDescriptorType,
    MemberDescriptorType,
    ModuleType,
    NoneType,
)
from typing import Any
from uuid import uuid4

import numpy as np

from grazing.kernel.wide import forms
from grazing.outcome import InputError, UserCodeError

#: The functions of this module have a compiled form of their own always, those that are wide where it is taken.
PRIMITIVES = "grazing.kernel.primitives"

#: The module of functions as the compiler sees them: the name of each says its arithmetic and its content.
COMPILED = "grazing.kernel"

#: Modules whose names say what stands behind their dots, beside the version of numba.
LIBRARIES = {"math", "cmath", "numpy", "numba"}

#: What a program can set in a library, and the compiler freezes.
VALUES = (int, float, complex, np.generic, np.ndarray, str, bytes, tuple, ModuleType)

#: Plain numbers and texts; a kind of one's own may show itself otherwise.
SHOWN = (bool, int, complex, str, bytes)

#: The instructions that a function begins with.
FIRST = {"COPY_FREE_VARS", "MAKE_CELL", "RESUME", "NOP"}

#: Those that take what has a name of its own.
GLOBAL = {"LOAD_GLOBAL", "LOAD_NAME"}

#: The bits of the NaN that has no sign.
NAN = np.array(math.nan).tobytes()

#: Hashes of functions, for as long as nothing can change what they name: during one compilation.
Known = dict[FunctionType, str]

#: Hashes of functions as they were when each was first compiled in this process: its code stays that of then.
compiled_as: Known = {}

#: The flag of classes that a ``class`` has made.
STATED = 1 << 9

#: What every class has, and what changes nothing.
MADE = {
    "__module__", "__dict__", "__weakref__", "__doc__", "__qualname__", "__firstlineno__", "__static_attributes__",
    "__annotations__", "__annotate_func__", "__annotations_cache__",
}  # fmt: skip

#: What stands for objects of whose content nothing is known, by address, which is nobody else's while they are kept.
_unknown: dict[int, tuple[str, Any]] = {}


def digest(function: Callable[..., Any] | ModuleType | tuple[Any, ...], known: Known | None = None) -> str:
    """Hash a kernel: its bytecode, its constants and, recursively, all that it names.

    Parameters
    ----------
    function : callable
        A plain Python function, or a tuple of them.
    known : dict, optional
        Hashes of functions met before; those met now are added.

    Returns
    -------
    str
        64 hexadecimal digits; equal for equal code, whatever file or line it stands in.
    """
    return hashlib.sha256(repr(content(function, (), {} if known is None else known)).encode()).hexdigest()


def identity(*functions: Callable[..., Any] | None) -> str:
    """Hash users' functions as results name them.

    Raises
    ------
    InputError
        If what one of them names has changed since it was compiled: its code has the old value.
    """
    known: Known = {}
    found = digest(functions if len(functions) > 1 else functions[0], known)  # type: ignore[arg-type]
    for each in functions:
        if isinstance(each, FunctionType) and compiled_as.get(each, known[each]) != known[each]:
            raise InputError(
                f"a value that {each.__name__} names, itself or below, has changed since it was compiled: its code has "
                f"the old one; define {each.__name__} again, or make the value a parameter"
            )
    return found


def is_kernel(value: object) -> bool:
    """Say whether a value is a function that is compiled from its source."""
    return isinstance(value, FunctionType) and value.__module__ != PRIMITIVES and value not in forms()


def named(function: FunctionType) -> dict[str, Any]:
    """Return the global values that a function names, by name."""
    return {
        name: function.__globals__[name]
        for name in sorted(global_names(function.__code__) & function.__globals__.keys())
    }


def below(function: FunctionType) -> list[FunctionType]:
    """Return the kernels that a function names, globally or in its closure."""
    return [value for value in (*named(function).values(), *enclosed(function)) if is_kernel(value)]


def enclosed(function: FunctionType) -> list[Any]:
    """Return the values in the closure of a function.

    Raises
    ------
    InputError
        If one of them has no value yet.
    """
    try:
        return [cell.cell_contents for cell in function.__closure__ or ()]
    except ValueError:
        raise InputError(f"{function.__name__} names what has no value yet; define it later") from None


@lru_cache(maxsize=4096)
def global_names(code: CodeType) -> frozenset[str]:
    """Return the global names of a function; not those behind a dot, which may only look like one."""
    inner = [const for const in code.co_consts if isinstance(const, CodeType)]
    own = {op.argval for op in dis.get_instructions(code) if op.opname in GLOBAL}
    return frozenset(own.union(*(global_names(const) for const in inner)))


@lru_cache(maxsize=4096)
def attributes(code: CodeType) -> frozenset[str]:
    """Return all names that may stand behind a dot in a function, or be given to ``getattr``."""
    names = {op.argval for op in dis.get_instructions(code) if op.opcode in dis.hasname and op.opname not in GLOBAL}
    own = names.union(const for const in code.co_consts if isinstance(const, str))
    return frozenset(own.union(*(attributes(const) for const in code.co_consts if isinstance(const, CodeType))))


class Unseen(UserCodeError, AttributeError):
    """What a function takes from a module that has its name in another one: it would be in no hash."""


class Seen(ModuleType):
    """A module as one function sees it: with what that function names behind dots alone, which is what is hashed.

    Whoever is given it, by whatever way, finds nothing else there. To the compiler it equals those that hold the same.
    """

    __slots__ = ("__holds__",)

    def __init__(self, name: str, holds: str = "") -> None:
        super().__init__(name)
        self.__holds__ = holds  # a hash, or nothing for as long as nobody compiles it

    def __repr__(self) -> str:
        return f"{self.__name__} {self.__holds__}".strip()

    def __eq__(self, other: object) -> bool:
        return type(self) is type(other) and repr(self) == repr(other)

    def __hash__(self) -> int:
        return hash(repr(self))

    def __reduce__(self) -> Any:
        return type(self), (self.__name__, self.__holds__), vars(self)

    def __getattr__(self, name: str) -> Any:
        said = self.__name__
        raise Unseen(f"{said} has no {name}, or none that is taken where {said} is named; take it there")


class SeenLibrary(Seen):
    """One of those whose names say what stands behind their dots, but for what a program has set there."""


def is_library(module: ModuleType) -> bool:
    """Say whether a module's name says what stands behind its dots."""
    name = module.__name__
    return name.partition(".")[0] in LIBRARIES and sys.modules.get(name) is module


def is_of_library(kind: type) -> bool:
    """Say whether a class stands in a library by its name."""
    module = sys.modules.get(kind.__module__)
    return module is not None and is_library(module) and vars(module).get(kind.__name__) is kind


def seen(value: Any, names: frozenset[str], met: dict[int, Seen] | None = None) -> Any:
    """Return a value as a function sees it that has these names behind dots."""
    met = {} if met is None else met
    if isinstance(value, tuple) and (type(value) is tuple or hasattr(value, "_make")):
        items = [seen(item, names, met) for item in value]
        changed = any(new is not old for new, old in zip(items, value, strict=True))
        return getattr(type(value), "_make", tuple)(items) if changed else value
    if not isinstance(value, ModuleType):
        return value
    if id(value) not in met:
        kind = SeenLibrary if is_library(value) else Seen
        met[id(value)] = found = kind(value.__name__)
        for name in sorted(names - MADE):
            try:
                taken = getattr(value, name)
            except Exception:  # of whatever kind: a module may import what it is asked for
                continue
            vars(found)[name] = seen(taken, names, met)
    return met[id(value)]


def reached(value: Any, met: list[Seen] | None = None) -> list[Seen]:
    """Return the modules in a value, and behind the dots of these, each once."""
    met = [] if met is None else met
    if isinstance(value, tuple):
        for item in value:
            reached(item, met)
    elif isinstance(value, Seen) and not any(value is each for each in met):
        met.append(value)
        for key in sorted(vars(value)):
            reached(vars(value)[key], met)
    return met


def frozen(function: FunctionType) -> dict[str, Any]:
    """Return all values that stand in a function by a name, a place in its closure, or as a default, as it sees them.

    The compiler freezes them.
    """
    found = {f"{i}": value for i, value in enumerate((*enclosed(function), *(function.__defaults__ or ())))}
    found |= {f"{key}=": value for key, value in sorted((function.__kwdefaults__ or {}).items())}
    names = attributes(function.__code__)
    return {key: seen(value, names) for key, value in (named(function) | found).items()}


def listed(module: Seen) -> list[tuple[str, Any]]:
    """Return what is hashed of a module, by name: of what a library has made itself the names alone."""
    own = isinstance(module, SeenLibrary)
    return [(key, (own and names_of(item)) or item) for key, item in sorted(vars(module).items())]


def names_of(value: Any) -> tuple[str, ...]:
    """Return the names of what a library has made itself; none of anything else, which a program can set there."""
    said = [getattr(value, name, None) for name in ("__module__", "__qualname__", "__name__", "name")]
    maker, *names = [name if isinstance(name, str) else "" for name in said]
    maker = maker or type(value).__module__
    own = not isinstance(value, VALUES) and maker.partition(".")[0] in LIBRARIES | {"builtins"}
    return (maker, *names) if own else ()


def content(value: Any, above: tuple[Any, ...], known: Known) -> Any:
    """Return a value whose repr changes whenever the meaning of ``value`` inside a kernel changes."""
    if isinstance(value, FunctionType):
        if value in above:
            return value.__name__
        if value not in known:
            known[value] = hashlib.sha256(repr(_function(value, (*above, value), known)).encode()).hexdigest()
        return known[value]
    if isinstance(value, tuple):
        kind = (type(value).__name__, getattr(value, "_fields", ()))
        return (kind, [content(item, above, known) for item in value])
    if isinstance(value, (staticmethod, classmethod, property)):
        parts = (value.fget, value.fset, value.fdel) if isinstance(value, property) else (value.__func__,)
        return (type(value).__name__, [content(part, above, known) for part in parts])
    if isinstance(value, (MemberDescriptorType, GetSetDescriptorType)):
        return ("slot", value.__name__)
    if type(value) is type and is_of_library(value):
        return (value.__module__, value.__name__)
    if type(value) is type:
        stated = value.__flags__ & STATED and value not in above
        items = getattr(value, "_field_defaults", vars(value)) if stated else {}
        own = [(key, content(item, (*above, value), known)) for key, item in items.items() if key not in MADE]
        bases = [content(base, (*above, value), known) for base in value.__bases__] if stated else []
        return (value.__name__, getattr(value, "_fields", ()), bases, own)
    if isinstance(value, Seen):
        place = next((i for i, each in enumerate(reversed(above)) if each is value), None)
        if place is not None:
            return ("module", place)
        modules = reached(value)
        above = (*above, *modules)
        return ("modules", [[(key, content(item, above, known)) for key, item in listed(each)] for each in modules])
    if isinstance(value, ModuleType):
        return ("module", value.__name__)
    if isinstance(value, BuiltinFunctionType) and isinstance(value.__self__, (ModuleType, NoneType)):
        # math and cmath have functions of the same names
        return (value.__module__, value.__qualname__)
    name = getattr(value, "__name__", None)
    if isinstance(name, str) and vars(np).get(name) is value:
        return ("numpy", name)
    if isinstance(value, np.ndarray):
        numbers = hashlib.sha256(np.ascontiguousarray(value).tobytes()).hexdigest()
        return ("array", repr(value.dtype), value.shape, value.flags.fnc, numbers)
    if isinstance(value, np.void):
        return ("record", repr(value.dtype), value.tobytes())
    if isinstance(value, float):
        return float.hex(value) if math.isfinite(value) else shown(value)
    if value is None or isinstance(value, (*SHOWN, np.generic)):
        return (type(value).__name__, shown(value))
    made = getattr(value, "py_func", None)
    if getattr(made, "__module__", "") == COMPILED:
        return ("compiled", made.__name__)  # type: ignore[union-attr]
    # unknown: never found again, so never stale. Another process may have its number and address, as in a container
    return ("object", _unknown.setdefault(id(value), (uuid4().hex, value))[0])


def _function(value: FunctionType, above: tuple[Any, ...], known: Known) -> Any:
    if value.__module__ == PRIMITIVES:
        return ("primitive", value.__name__, text(PRIMITIVES))  # both its forms
    if value in forms():
        return ("primitive", value.__name__, text(value.__module__), text("grazing.kernel.wide"))

    return (
        [mark for mark in ("inlined", "unit") if getattr(value, mark, False)],
        coded(value.__code__),
        [(key, content(item, above, known)) for key, item in frozen(value).items()],
    )


@cache
def text(module: str) -> str:
    """Hash the text of a module of this folder, or of all that are in a folder in it."""
    place = Path(__file__).with_name(module.rpartition(".")[2])
    files = sorted(place.glob("*.py")) or [place.with_suffix(".py")]
    return hashlib.sha256(b"".join(file.read_bytes() for file in files)).hexdigest()


@lru_cache(maxsize=4096)
def coded(code: CodeType) -> Any:
    """Return what the code of a function does, without the file and the lines that it stands in, and its docstring.

    Constants stand where they are used: ``python -OO`` has none in the docstring's place, and numbers all others anew.
    The docstring leaves an instruction that does nothing, in front of all others but those that every function has.
    """
    consts, steps, begins = code.co_consts, [], True
    for op in dis.get_instructions(code):
        begins = begins and op.opname in FIRST
        if not (begins and op.opname == "NOP"):
            # not op.argval, which does not know the names of keywords
            constant = op.arg is not None and op.opcode in dis.hasconst
            steps.append((op.opcode, _said(consts[op.arg]) if constant else op.arg))  # type: ignore[index]
    stars = code.co_flags & (inspect.CO_VARARGS | inspect.CO_VARKEYWORDS)
    taken = (code.co_argcount, code.co_posonlyargcount, code.co_kwonlyargcount, stars)
    return (steps, taken, code.co_names, code.co_varnames, code.co_freevars, code.co_exceptiontable)


def _said(constant: Any) -> Any:
    """Return what a constant is; a set of texts has another order in every process."""
    if isinstance(constant, CodeType):
        return coded(constant)
    if isinstance(constant, tuple):
        return ("tuple", [_said(item) for item in constant])
    said = repr(sorted(map(repr, constant))) if isinstance(constant, frozenset) else shown(constant)
    return (type(constant).__name__, said)


def shown(value: Any) -> str:
    """Return the repr of a value, and what it leaves out: the bits of a NaN, the number of an enum."""
    plain = next((kind.__repr__(value) for kind in SHOWN if isinstance(value, kind)), "")
    bits = np.array(value).tobytes() if isinstance(value, (float, complex, np.inexact)) and value != value else NAN
    return repr(value) + ("" if plain in ("", repr(value)) else plain) + ("" if bits == NAN else bits.hex())
