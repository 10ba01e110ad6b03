"""Loops of which compiled code takes several turns at once, as vectors side by side.

A processor looks a few dozen operations ahead. Where each turn is one long chain of operations it waits most of the
time; taken two vectors at a time, operation by operation, one works while the other waits. The mark stands at the index
of the innermost loop, whose number of turns must be a multiple of those that are taken at once. It counts in kernels of
the library.
"""

from __future__ import annotations

import os
from typing import Any

from grazing.kernel.primitives import compiled_form


def abreast(index: int) -> int:
    """Return an index; compiled code takes as many turns of the loop around it at once as fill a register."""
    return index


def eights(index: int) -> int:
    """Return an index; compiled code takes eight turns of the loop around it at once."""
    return index


def _register() -> None:
    """Write down the compiled forms; importing numba here is the reason to be lazy."""
    from numba.core import types

    from grazing.kernel.simd import width_for

    def marking(turns: int) -> Any:
        def mark(_context: Any, index: Any) -> Any:
            def code(context: Any, builder: Any, _signature: Any, args: Any) -> Any:
                builder.block.vectors = max(turns // width_for(context), 1)
                return args[0]

            return types.int64(types.int64), code

        return mark

    compiled_form(abreast)(marking(1))
    compiled_form(eights)(marking(8))


if os.environ.get("NUMBA_DISABLE_JIT", "0") in ("", "0"):
    _register()
