"""The wide forms of primitives, written as vectors by hand: taken where all that they lean on is as it was tried.

Elsewhere each primitive is compiled from its plain form, as any kernel, by numba's own way through its compiler: the
same bits in strict arithmetic, more slowly.
"""

from __future__ import annotations

import os
from importlib import import_module

from grazing.kernel.private import missing


def _reason() -> str:
    """Return why the wide forms are not taken; empty where they are: then this registers them."""
    if os.environ.get("NUMBA_DISABLE_JIT", "0") not in ("", "0"):
        return "NUMBA_DISABLE_JIT is set"
    if os.environ.get("GRAZING_WIDE", "1") == "0":
        return "GRAZING_WIDE is 0"
    said = missing()
    if not said:
        for name in ("rows", "turns", "vectors"):  # which register themselves
            import_module(f"grazing.kernel.wide.{name}")
    return said


#: Why the plain forms are taken; empty where the wide ones are.
PLAIN = _reason()
