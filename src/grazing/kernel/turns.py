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


def take_at_once(function: Any, entry: Any) -> None:
    """Tell the compiler, at the loops of a function in its intermediate form, what :func:`eights` asked for."""
    from llvmlite import ir
    from numba.core.controlflow import CFGraph

    marked = [block for block in function.blocks if hasattr(block, "vectors")]
    if not marked:
        return
    graph, ends = CFGraph(), {block: block.terminator for block in function.blocks if block.terminator is not None}
    for block in function.blocks:
        graph.add_node(block)
    for block, end in ends.items():
        for target in end.operands:
            if isinstance(target, ir.Block):
                graph.add_edge(block, target)
    graph.set_entry_point(entry)
    graph.process()
    for block in marked:
        around = [loop for loop in graph.loops().values() if block in loop.body]
        if not around:
            continue
        loop = min(around, key=lambda each: len(each.body))
        said = function.module.add_metadata([f"loop {len(function.module.metadata)}"])  # equal nodes would be one
        wishes = (
            ["llvm.loop.interleave.count", ir.Constant(ir.IntType(32), block.vectors)],
            ["llvm.loop.unroll.disable"],  # or a short loop is unrolled before it is made one of vectors
        )
        said.operands = (said, *(function.module.add_metadata(wish) for wish in wishes))
        for latch in loop.body & ends.keys():
            if loop.header in ends[latch].operands:
                ends[latch].set_metadata("llvm.loop", said)


if os.environ.get("NUMBA_DISABLE_JIT", "0") in ("", "0"):
    _register()
