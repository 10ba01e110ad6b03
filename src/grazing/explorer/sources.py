"""The source of a kernel as a hash: whether what was compiled from it, here or elsewhere, is still its own."""

from __future__ import annotations

import ast
import hashlib
import inspect
import textwrap
from collections.abc import Callable
from functools import cache
from pathlib import Path
from types import CellType, FunctionType
from typing import Any

import numpy as np

from grazing.kernel.content import PRIMITIVES, global_names
from grazing.kernel.wide import forms


def source_digest(function: Callable[..., Any]) -> str:
    """Hash the source of a kernel and of all that it names, without comments and documentation.

    Parameters
    ----------
    function : callable
        A kernel, plain or compiled.

    Returns
    -------
    str
        64 hexadecimal digits, the same in every version of Python; :func:`grazing.kernel.compile.digest` hashes
        bytecode, which is not.
    """
    seen: dict[str, str] = {}
    content = _described(function, seen)
    return hashlib.sha256(repr((content, sorted(seen.items()))).encode()).hexdigest()


def file_digest(file: Path) -> str:
    """Hash the source in a file, without comments and documentation."""
    tree = ast.parse(file.read_text(encoding="utf-8"))
    return hashlib.sha256(ast.unparse(_without_docstrings(tree)).encode()).hexdigest()


def _without_docstrings(tree: ast.AST) -> ast.AST:
    for node in ast.walk(tree):
        if isinstance(node, (ast.FunctionDef, ast.ClassDef, ast.Module)) and ast.get_docstring(node) is not None:
            node.body = node.body[1:] or [ast.Pass()]
    return tree


def _described(value: Any, seen: dict[str, str]) -> str:
    value = getattr(getattr(value, "py_func", None), "original", value)
    value = next((primitive for primitive, form in forms().items() if form is value), value)
    if not isinstance(value, FunctionType):
        if isinstance(value, float):
            return value.hex()
        if isinstance(value, type):
            return f"{value.__name__}{getattr(value, '_fields', '')}"
        if isinstance(value, tuple):
            return f"({', '.join(_described(item, seen) for item in value)})"
        plain = isinstance(value, (int, str, np.generic))
        return repr(value) if plain else getattr(value, "__name__", repr(type(value)))
    where = f"{value.__module__}:{value.__code__.co_qualname}"
    cells = [(name, cell) for name, cell in zip(value.__code__.co_freevars, value.__closure__ or (), strict=True)]
    mark = f"{where} {[name for name, _cell in cells]}"
    if value.__module__ == PRIMITIVES:
        seen[where] = "primitive"
        return where
    if where not in seen:
        seen[where] = _source(value)
        for name in sorted(global_names(value.__code__) & value.__globals__.keys()):
            seen[f"{where}.{name}"] = _described(value.__globals__[name], seen)
    return f"{mark}{[_cell(cell, seen) for _name, cell in cells]}"


def _cell(cell: CellType, seen: dict[str, str]) -> str:
    return _described(cell.cell_contents, seen)


@cache
def _source(function: FunctionType) -> str:
    """Return the source of a function as the parser sees it."""
    return ast.unparse(_without_docstrings(ast.parse(textwrap.dedent(inspect.getsource(function.__code__)))))
