"""The wide forms of primitives, written as vectors by hand: taken where all that they lean on is as it was tried.

Elsewhere each primitive is compiled from its plain form, as any kernel, by numba's own way through its compiler: the
same bits in strict arithmetic, more slowly. Nothing is registered, and numba is not imported, before it is asked for.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from functools import cache
from importlib import import_module
from typing import Any

from grazing.interrupt import held_back
from grazing.kernel.primitives import noted, register


@cache
@held_back()
def plain() -> str:
    """Return why the plain forms are taken; empty where the wide ones are."""
    if os.environ.get("NUMBA_DISABLE_JIT", "0") not in ("", "0"):
        return "NUMBA_DISABLE_JIT is set"
    register()
    if os.environ.get("GRAZING_WIDE", "1") == "0":
        return "GRAZING_WIDE is 0"
    said: str = import_module("grazing.kernel.private").missing()
    if not said:
        for name in ("rows", "turns", "vectors"):  # which register themselves
            import_module(f"grazing.kernel.wide.{name}")
    return said


def forms() -> dict[Callable[..., Any], Any]:
    """Return what stands for each primitive in compiled code."""
    plain()
    return noted
