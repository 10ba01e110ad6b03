"""Marks on loops, and what they ask of the compiler: so many vectors side by side, operation by operation."""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types

from grazing.kernel.primitives import compiled_form
from grazing.kernel.private import CFGraph
from grazing.kernel.turns import abreast, eights
from grazing.kernel.wide.simd import width_for


def _marking(turns: int) -> Any:
    def mark(_context: Any, index: Any) -> Any:
        def code(context: Any, builder: Any, _signature: Any, args: Any) -> Any:
            width = min(width_for(context), turns)
            builder.block.vectors = width, turns // width
            return args[0]

        return types.int64(types.int64), code

    return mark


compiled_form(abreast)(_marking(4))
compiled_form(eights)(_marking(8))


class Apart(ir.MDValue):  # type: ignore[misc]
    """A node that equals no other."""

    def descr(self, buf: Any) -> None:
        """Write what stands behind its name."""
        buf += ("distinct !{}", "\n")


def take_at_once(function: Any, entry: Any) -> None:
    """Tell the compiler, at the loops of a function in its intermediate form, what the marks in it ask for."""
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
        width, vectors = block.vectors
        # that turns are independent is said, too: of rows one behind the other LLVM cannot tell, and takes one vector
        apart = Apart(function.module, (), str(len(function.module.metadata)))
        for inside in loop.body:
            for each in inside.instructions:
                if isinstance(each, (ir.LoadInstr, ir.StoreInstr, ir.CallInstr)):
                    each.set_metadata("llvm.access.group", apart)
        said = function.module.add_metadata([f"loop {len(function.module.metadata)}"])  # equal nodes would be one
        wishes = (
            # how wide is said, too: of a register of eight LLVM takes half where it thinks that all would slow it down
            ["llvm.loop.vectorize.width", ir.Constant(ir.IntType(32), width)],
            ["llvm.loop.interleave.count", ir.Constant(ir.IntType(32), vectors)],
            ["llvm.loop.parallel_accesses", apart],
            ["llvm.loop.unroll.disable"],  # or a short loop is unrolled before it is made one of vectors
        )
        said.operands = (said, *(function.module.add_metadata(wish) for wish in wishes))
        for latch in loop.body & ends.keys():
            if loop.header in ends[latch].operands:
                ends[latch].set_metadata("llvm.loop", said)
