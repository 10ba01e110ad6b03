"""Steps of the compiler that an interrupt must not cut short: it waits, some milliseconds, until they are done.

The linker destroys the module that it takes in, and llvmlite notes so after the call: interrupted in between, the
module was destroyed a second time, and the process ended. So it is with all that llvmlite closes, texts among them, and
with a module that the engine takes over. The tables of what numba can compile are filled from streams that go on where
they last were: what an interrupt kept from its table was missing until the session ended.
"""

from __future__ import annotations

from functools import cache
from typing import Any

from grazing.interrupt import held_back
from grazing.kernel.private import JITCodeLibrary, cpu_target, ffi
from grazing.kernel.private import module as modules


def linked(target: Any, source: Any) -> None:
    """Link a module into another."""
    source._owned = True  # by the linker: nobody else destroys it, whatever comes as the call ends
    _link(target, source)


_link = modules.link_modules


@held_back()
@cache
def uninterrupted() -> None:
    """Take these steps so from now on, in this process."""
    steps: list[tuple[Any, str]] = [
        (cpu_target.typing_context, "refresh"), (cpu_target.target_context, "refresh"),
        (ffi.OutputString, "close"), (ffi.ObjectRef, "close"), (JITCodeLibrary, "_finalize_final_module"),
    ]  # fmt: skip
    modules.link_modules = linked
    for owner, name in steps:
        setattr(owner, name, held_back()(getattr(owner, name)))
