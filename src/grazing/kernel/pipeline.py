"""The way of a kernel through the compiler: numba's, without what kernels have no need of.

numba turns each function into machine code of its own as soon as it is compiled, and then again with every caller it
is linked into. Of a kernel only the outermost function is ever called, so the others are left as they are. It also
asks of each operation anew which of a dozen templates it fits: here the answers are remembered. And passes that look
for what no kernel has, closures or expressions of whole arrays, are left out for kernels of the library. Two things are
added: what :mod:`grazing.kernel.wide.turns` asks of loops, and a stack on which registers lie in one line of the cache.
"""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from operator import ipow, pow
from types import BuiltinFunctionType
from typing import Any

from llvmlite import binding

from grazing.kernel.cache import mark
from grazing.kernel.private import (
    Compiler,
    Function,
    JITCodeLibrary,
    NativeLowering,
    PassManager,
    lowering,
    register_pass,
)
from grazing.kernel.wide.simd import register_bytes
from grazing.kernel.wide.turns import take_at_once

#: Passes of numba that find nothing to do in a kernel of the library.
IDLE = frozenset(
    {
        "with_lifting", "inline_closure_likes", "Rewrite dynamic raises", "make_function_op_code_to_jit_function",
        "inline_inlinables", "find_literally", "literal_unroll", "LiteralPropagation", "inline_overloads",
        "nopython_rewrites", "dump_parfor_diagnostics",
    }
)  # fmt: skip

_resolved: dict[tuple[Any, tuple[Any, ...]], Any] = {}


@cache
def pipeline(role: str, own: bool) -> Any:
    """Return the compiler for a function.

    Parameters
    ----------
    role : {"entry", "unit", "part"}
        An entry is called by Python. A unit has machine code of its own, which kernels call. A part is only ever linked
        into others: it is optimised with them, not by itself.
    own : bool
        Whether it is one of the library's: what others wrote may need every pass.
    """
    return type("Pipeline", (Pipeline,), {"library": LIBRARIES[role], "own": own})


@contextmanager
def uncollected() -> Iterator[None]:
    """Let Python not look for garbage: a compiler makes millions of objects, nearly all of which it keeps."""
    was = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was:
            gc.enable()


class Unnamed:
    """What stands for the code generator where an environment is to be entered: there is no code to enter it in."""

    def set_env(self, name: str, env: Any) -> None:
        """Do nothing."""


class Part(JITCodeLibrary):  # type: ignore[misc]
    """Code to be linked into other code."""

    @property
    def codegen(self) -> Any:
        """Return what takes no environment."""
        return Unnamed()

    def _optimize_final_module(self) -> None:
        pass

    def _finalize_final_module(self) -> None:
        self._finalize_dynamic_globals()
        self._verify_declare_only_symbols()
        self._finalized = True

    def get_pointer_to_function(self, name: str) -> int:
        """Return no address: there is no machine code."""
        self._ensure_finalized()
        return 0


class Unit(JITCodeLibrary):  # type: ignore[misc]
    """Code of its own: its callers know its name only, and the linker finds it when they are loaded."""

    @property
    def codegen(self) -> Any:
        """Return what takes no environment."""
        return Unnamed()

    def _get_module_for_linking(self) -> Any:
        return binding.parse_assembly("")


LIBRARIES = {"entry": None, "unit": Unit, "part": Part}


class Remembering:
    """A typing context that asks only once what a function of numba's makes of given types."""

    def __init__(self, context: Any) -> None:
        self._context = context

    def __getattr__(self, name: str) -> Any:
        return getattr(self._context, name)

    def resolve_function_type(self, function: Any, args: tuple[Any, ...], kws: dict[str, Any]) -> Any:
        """Return the signature of a call."""
        if kws or type(function) not in (Function, BuiltinFunctionType):
            return self._context.resolve_function_type(function, args, kws)
        if (function, args) not in _resolved:
            _resolved[function, args] = self._context.resolve_function_type(function, args, kws)
        return _resolved[function, args]


class Lower(lowering.Lower):  # type: ignore[misc]
    """Operators as numba lowers them, but not typed a second, third and fourth time."""

    def lower_binop(self, result: Any, expr: Any, operator: Any) -> Any:
        """Write the code of an operator between two values."""
        if operator in (pow, ipow):  # whose compiled form depends on the exponent, not on its type only
            return super().lower_binop(result, expr, operator)
        signature, sides = self.fndesc.calltypes[expr], (expr.lhs.name, expr.rhs.name)
        values = [
            self.context.cast(self.builder, self.loadvar(side), self.typeof(side), kind)
            for side, kind in zip(sides, signature.args, strict=True)
        ]
        function = self.context.typing_context.resolve_value_type(operator)
        signature = Remembering(self.context.typing_context).resolve_function_type(function, signature.args, {})
        value = self.context.get_function(function, signature)(self.builder, values)
        return self.context.cast(self.builder, value, signature.return_type, result)

    def lower_function_body(self) -> Any:
        """Write the code of a function, and what is to be known of its loops and its stack."""
        tail = super().lower_function_body()
        take_at_once(self.function, self.blkmap[self.firstblk])
        wide = register_bytes(self.context)
        if wide > 16:  # or registers that are put on the stack lie across two lines of the cache
            self.function.attributes.add("nounwind")
            self.function.attributes.alignstack = wide
        return tail


@register_pass(mutates_CFG=True, analysis_only=False)
class Lowering(NativeLowering):  # type: ignore[misc]
    """The pass that writes the code of a function."""

    _name = "kernel_lowering"

    @property
    def lowering_class(self) -> Any:
        """Return who does it."""
        return Lower


class Pipeline(Compiler):  # type: ignore[misc]
    """The usual passes, or those that are needed."""

    library: Any
    own: bool

    def _compile_core(self) -> Any:
        with uncollected():
            return super()._compile_core()

    def define_pipelines(self) -> Any:
        """Return the passes."""
        self.state.typingctx = Remembering(self.state.typingctx)
        if self.library is not None and self.state.library is None:
            generator = self.state.targetctx.codegen()
            self.state.library = self.library(generator, self.state.func_id.func_qualname)
        if self.library is Unit:
            self.state.library.enable_object_caching()
            # callers on the disk know it by its name, in which numba counts what it has compiled so far
            self.state.func_id.unique_id = mark(self.state.args)
        usual = super().define_pipelines()
        if not self.own:
            return usual
        needed = PassManager("kernel")
        for each, description in usual[0].passes:
            if each.name() not in IDLE:
                needed.add_pass(Lowering if each is NativeLowering else each, description)
        needed.finalize()
        return [needed]
