"""The compiled forms of lists of some of eight numbers, and of records turned into rows: they move whole vectors."""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types

from grazing.kernel.primitives import compiled_form
from grazing.kernel.private import cgutils
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


@compiled_form(listed)
def _listing(_context: Any, work: Any, to: Any, flags: Any, first: Any) -> Any:
    def code(_ctx: Any, builder: Any, _signature: Any, args: Any) -> Any:
        lanes, byte = Memory(builder, args[0], 8), ir.IntType(8)
        mask = builder.fcmp_ordered(">", lanes.load(args[2]).value, constant(builder, 0.0, 8).value)
        places = Lanes(builder, ir.Constant(lanes.kind, [float(k) for k in range(8)]))
        given = [(equal(builder, args[3], 8) + places).value, mask, ir.Constant(lanes.kind, ir.Undefined)]
        kind = ir.FunctionType(lanes.kind, [one.type for one in given])
        compress = cgutils.get_or_insert_function(builder.module, kind, "llvm.experimental.vector.compress.v8f64")
        lanes.store(Lanes(builder, builder.call(compress, given)), args[1])
        return builder.zext(builder.ctpop(builder.bitcast(mask, byte)), whole)

    return n(work, n, n, types.float64), code
