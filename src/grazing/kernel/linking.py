"""Linking into which an interrupt may come.

The linker destroys the module that it takes in. llvmlite notes so after the call, but Python raises an interrupt before
anything else, once a call has ended: the module was destroyed a second time, and the process ended.
"""

from __future__ import annotations

from typing import Any

from grazing.kernel.private import module as modules


def linked(target: Any, source: Any) -> None:
    """Link a module into another."""
    source._owned = True  # by the linker: nobody else destroys it
    _link(target, source)


_link = modules.link_modules


def link_carefully() -> None:
    """Link so from now on, in this process."""
    modules.link_modules = linked
