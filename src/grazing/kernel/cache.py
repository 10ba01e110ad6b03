"""Compiled kernels on the disk: how one is found again, with the units that its code calls.

numba's own cache looks at one file's time stamp and so serves stale code after an edit in a callee. Here the name of a
file is the hash of all that its kernel is made of. It imports numba: those who need it import it late.
"""

from __future__ import annotations

import hashlib
import os
import sys
import warnings
from collections.abc import Sequence
from functools import cache
from importlib.machinery import EXTENSION_SUFFIXES
from types import FunctionType
from typing import Any

import llvmlite
import numba
from numba import types

from grazing.kernel.content import content, text
from grazing.kernel.disk import KernelFiles, cache_folder, folders
from grazing.kernel.prepared import machines, told
from grazing.kernel.private import CompileResultCacheImpl, FunctionCache, normalize_signature
from grazing.kernel.wide import plain

#: To be raised when this file stores kernels in another way, so that older files are left alone.
LAYOUT = 6

#: The units whose machine code is there: by the name that the linker knows.
_there: dict[str, Any] = {}


def spelled(kind: Any) -> str:
    """Return the name of a type; of named tuples with the fields, of functions with what they are."""
    if isinstance(kind, types.Dispatcher):  # which shows an address
        return repr(content(kind.dispatcher, (), {}))
    if not isinstance(kind, types.BaseTuple):
        return str(kind)
    made = getattr(kind, "instance_class", tuple)
    names = f"{made.__module__}.{made.__qualname__}{getattr(made, '_fields', '')}"
    return f"{names}({', '.join(map(spelled, kind.types))})"


def mark(kinds: Sequence[Any]) -> str:
    """Return what tells the code for these types from that for others, in the name that the linker knows."""
    return hashlib.sha256(", ".join(map(spelled, kinds)).encode()).hexdigest()[:16]


class Files(CompileResultCacheImpl):  # type: ignore[misc]
    """How a kernel becomes the content of a file, and a file a kernel."""

    def __init__(self, function: FunctionType, stamp: str, units: Sequence[Any]) -> None:
        self._filename_base = f"{function.__name__.split('_')[0]}-{stamp[:40]}"
        self._units = {unit.py_func.__name__: unit for unit in units}

    @property
    def locator(self) -> Any:
        """Return who knows where files are."""
        return self

    def ensure_cache_path(self) -> None:
        """Make the folder."""
        cache_folder()

    def check_cachable(self, result: Any) -> bool:
        """Say whether the code means the same in another process."""
        return not (result.lifted or result.library.has_dynamic_globals)

    def reduce(self, result: Any) -> Any:
        """Return what is kept: the code, and the units that it calls, each with the types of its arguments."""
        functions = result.library._final_module.functions
        called = [_there[each.name] for each in functions if each.is_declaration and each.name in _there]
        return called, super().reduce(result)

    def rebuild(self, target_context: Any, payload: Any) -> Any:
        """Return the kernel; a name that the linker did not find would end the process."""
        called, code = payload
        for name, kinds, symbol in called:
            self._units[name].compile(kinds)
            if symbol not in _there:
                raise ValueError(f"there is no {symbol}")
        return super().rebuild(target_context, code)


@cache
def say_once(words: str) -> None:
    """Say on the standard error stream what is going to take a while."""
    print(f"grazing: {words}", file=sys.stderr, flush=True)


class KernelCache(FunctionCache):  # type: ignore[misc]
    """The files of one kernel.

    Parameters
    ----------
    function : function
        As it is compiled.
    content : str
        The hash of all that it is made of, and how it is compiled.
    units : sequence
        The compiled units that its code may call.
    announce : str
        Said before a compilation; empty for nothing.
    """

    def __init__(self, function: FunctionType, content: str, units: Sequence[Any], announce: str) -> None:
        ways = "plain" if plain() else text("grazing.kernel.pipeline") + text("grazing.kernel.wide")
        # one bytecode may be that of several Pythons, whose interfaces for C, and what is pickled, are not the same
        versions = f"{LAYOUT} {ways} {numba.__version__} {llvmlite.__version__} {EXTENSION_SUFFIXES[0]}"
        self._stamp = hashlib.sha256(" ".join(filter(None, (content, versions, told()))).encode()).hexdigest()
        self._name, self._py_func, self._announce = repr(function), function, announce
        self._impl = Files(function, self._stamp, units)
        folder, read = folders()
        self._cache_path = os.fspath(folder or "")
        self._cache_file = KernelFiles(folder, self._impl.filename_base, read)
        self.enable()

    def _index_key(self, signature: Any, codegen: Any) -> Any:
        return self._key(signature, codegen.magic_tuple())

    def _key(self, signature: Any, machine: Any) -> Any:
        kinds, _returned = normalize_signature(signature)
        return (mark(kinds), machine, self._stamp)

    def _load_overload(self, signature: Any, target_context: Any) -> Any:
        own = target_context.codegen()
        found = self._rebuilt(self._cache_file.load(self._index_key(signature, own)), target_context)
        for machine in machines(own.magic_tuple()) if found is None else ():
            data = self._cache_file.load_prepared(self._key(signature, machine))
            found = self._rebuilt(data, target_context) if found is None else found
        if found is not None:
            self._enter(found)
        elif self._announce:
            say_once(self._announce)
        return found

    def _rebuilt(self, data: Any, target_context: Any) -> Any:
        """Return a kernel from the content of a file; None if there was none."""
        try:
            return None if data is None else self._impl.rebuild(target_context, data)
        except Exception:  # what the linker does not take is as good as none: compile again
            return None

    def _save_overload(self, signature: Any, result: Any) -> None:
        self._enter(result)
        try:
            super()._save_overload(signature, result)
        except OSError as error:  # a full disk must not stop a computation that has its code already
            warnings.warn(f"a compiled kernel could not be kept: {error}", RuntimeWarning, stacklevel=2)

    def _enter(self, result: Any) -> None:
        """Note that the machine code is there."""
        symbol = result.fndesc.llvm_func_name
        _there[symbol] = (self._py_func.__name__, result.signature.args, symbol)
