"""The compiled forms of lists of some of eight numbers, and of records turned into rows: they move whole vectors."""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types

from grazing.kernel.primitives import compiled_form
from grazing.kernel.vectors import WHOLE_BITS, listed, transposed
from grazing.kernel.wide.simd import Lanes, Memory, constant, equal, short, whole

n = types.int64


@compiled_form(transposed)
def _transposing(_context: Any, work: Any, to: Any, step: Any, table: Any, where: Any, plus: Any) -> Any:
    def code(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        out, source = Memory(builder, args[0], 4), Memory(builder, args[3], 4)
        bits = builder.bitcast(args[0], whole.as_pointer())
        for half in (0, 4):
            lanes = [builder.load(builder.gep(bits, [builder.add(args[4], whole(half + k))])) for k in range(4)]
            less = builder.sub(args[5], whole(WHOLE_BITS))
            rows = [source.load(builder.add(lane, less)).value for lane in lanes]
            for size in (1, 2):  # blocks of this size change places across the diagonal
                for k in (0, 3 - size):
                    pair = rows[k], rows[k + size]
                    for h, first in ((k, 0), (k + size, size)):
                        order = [first + j % size + j // size % 2 * 4 + j // (2 * size) * 2 for j in range(4)]
                        kind = ir.Constant(ir.VectorType(short, 4), order)
                        rows[h] = builder.shuffle_vector(*pair, kind)
            for h, row in enumerate(rows):
                place = builder.add(builder.mul(args[2], whole(h)), whole(half))
                out.store(Lanes(builder, row), builder.add(args[1], place))
        return context.get_dummy_value()

    return types.void(work, n, n, table, n, n), code


def listings(module: Any) -> Any:
    """Return a table: of each eight bits, the lowest first, the places of those that are set, then zeros."""
    kind = ir.ArrayType(ir.VectorType(ir.IntType(8), 8), 256)
    if "listings" not in module.globals:
        table = ir.GlobalVariable(module, kind, "listings")
        table.linkage, table.global_constant = "internal", True
        set_bits = ([k for k in range(8) if bits >> k & 1] for bits in range(256))
        table.initializer = kind([kind.element((each + [0] * 8)[:8]) for each in set_bits])
    return module.globals["listings"]


@compiled_form(listed)
def _listing(_context: Any, work: Any, to: Any, flags: Any, first: Any) -> Any:
    def code(_ctx: Any, builder: Any, _signature: Any, args: Any) -> Any:
        lanes, byte = Memory(builder, args[0], 8), ir.IntType(8)
        mask = builder.fcmp_ordered(">", lanes.load(args[2]).value, constant(builder, 0.0, 8).value)
        bits = builder.bitcast(mask, byte)
        places = builder.load(builder.gep(listings(builder.module), [short(0), builder.zext(bits, whole)]))
        numbers = Lanes(builder, builder.uitofp(places, lanes.kind))
        lanes.store(equal(builder, args[3], 8) + numbers, args[1])
        return builder.zext(builder.ctpop(bits), whole)

    return n(work, n, n, types.float64), code
