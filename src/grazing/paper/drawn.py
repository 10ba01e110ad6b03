"""The modules that draw: one a figure, and one that sets two figures side by side."""

from __future__ import annotations

from importlib import import_module
from types import ModuleType

#: The comparison of Figures 1.6 and 3.2.
BESIDE = "1.6-3.2"


def module_of(name: str) -> ModuleType:
    """Return the module that draws a figure, the comparison included."""
    return import_module("grazing.paper.beside" if name == BESIDE else f"grazing.paper.figure_{name.replace('.', '_')}")
