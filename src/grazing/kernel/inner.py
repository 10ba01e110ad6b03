"""Compile functions that are only ever linked into their callers, without making machine code of them.

numba turns each function into machine code of its own as soon as it is compiled, and then again with every caller it
is linked into. Of a kernel only the outermost function is ever called; leaving out the others' machine code saves a
sixth of the time.
"""

from __future__ import annotations

from functools import cache
from typing import Any


@cache
def pipeline(optimised: bool) -> Any:
    """Return the compiler pipeline for such functions; importing numba here is the reason to be lazy.

    Those that are not ``optimised`` are so with their callers only, once instead of twice.
    """
    from numba.core.codegen import JITCodeLibrary
    from numba.core.compiler import Compiler

    class Unnamed:
        """What stands for the code generator where an environment is to be entered: there is no code to enter it in."""

        def set_env(self, name: str, env: Any) -> None:
            pass

    class Linked(JITCodeLibrary):  # type: ignore[misc]
        """Code to be linked into other code."""

        @property
        def codegen(self) -> Any:
            return Unnamed()

        def _optimize_final_module(self) -> None:
            if optimised:
                super()._optimize_final_module()

        def _finalize_final_module(self) -> None:
            self._finalize_dynamic_globals()
            self._verify_declare_only_symbols()
            self._finalized = True

        def get_pointer_to_function(self, name: str) -> int:
            self._ensure_finalized()
            return 0

    class Inner(Compiler):  # type: ignore[misc]
        """The usual pipeline, with such a library."""

        def define_pipelines(self) -> Any:
            if self.state.library is None:
                generator = self.state.targetctx.codegen()
                self.state.library = Linked(generator, self.state.func_id.func_qualname)
            return super().define_pipelines()

    return Inner
