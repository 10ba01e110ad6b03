"""The names of numba and llvmlite that nobody promised to keep: all that are used, and where they are found.

What numba documents (``njit``, ``types``, ``extending``) and the builder of llvmlite are not among them. A name is
looked for when it is asked for. With any version of numba kernels need those of the second group to be kept on disk;
the others are for the versions that they were tried on, see :mod:`grazing.kernel.wide`.
"""

from __future__ import annotations

from importlib import import_module
from importlib.metadata import version
from typing import Any

#: The versions that all was tried on, by the numbers they begin with.
TRIED = {"numba": "0.68", "llvmlite": "0.50"}

#: Where the names are that the wide forms need, and the short way through the compiler.
WIDE = {
    "CFGraph": "numba.core.controlflow",
    "Compiler": "numba.core.compiler",
    "Function": "numba.core.types",
    "JITCodeLibrary": "numba.core.codegen",
    "NativeLowering": "numba.core.typed_passes",
    "PassManager": "numba.core.compiler_machinery",
    "cgutils": "numba.core",
    "cpu_target": "numba.core.registry",
    "ffi": "llvmlite.binding",
    "lowering": "numba.core",
    "module": "llvmlite.binding",
    "register_pass": "numba.core.compiler_machinery",
}
#: Where those are that keep kernels on disk, and that say how long the compiler took.
KEPT = {
    "CompileResultCacheImpl": "numba.core.caching",
    "FunctionCache": "numba.core.caching",
    "dumps": "numba.core.serialize",
    "event": "numba.core",
    "normalize_signature": "numba.core.sigutils",
}


def missing() -> str:
    """Return what is not as it was when it was tried; empty for nothing."""
    for package, tried in TRIED.items():
        found = version(package)
        if not f"{found}.".startswith(f"{tried}."):
            return f"{package} is {found}, they were tried on {tried}"
    try:
        for name in (*WIDE, *KEPT):
            __getattr__(name)
    except (ImportError, AttributeError) as error:
        return str(error)
    return ""


def __getattr__(name: str) -> Any:
    place = {**WIDE, **KEPT}.get(name)
    if place is None:
        raise AttributeError(name)
    return getattr(import_module(place), name)
