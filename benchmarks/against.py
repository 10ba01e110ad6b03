"""Another kernel from a file, as a row of the same rounds: `--against FILE:FUNCTION`.

The function is called as ``function(alpha, k, omega, r, V, d, u, v, transient, keep)`` with d (columns,) and u, v
(columns, starts), and returns u and v of shape (columns, keep, starts), whatever may follow them.
"""

from __future__ import annotations

import ast
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from .models import STANDARD, Array, Columns, Model
from .program import Program, summary

#: The flags for numba that such a file defines; without the flag below, a*b + c stays two rounded operations.
FLAGS, CONTRACT = "FM", "contract"


class BadKernel(ValueError):
    """What is wrong with the argument of --against."""


def parsed(argument: str) -> tuple[Path, str]:
    """Split FILE:FUNCTION and see that both exist."""
    file, colon, name = argument.rpartition(":")
    path = Path(file)
    if not colon or not name.isidentifier():
        raise BadKernel(f"--against is {argument!r}; give FILE:FUNCTION, such as kernels.py:run")
    if not path.is_file():
        raise BadKernel(f"--against names the file {file}, which does not exist")
    try:
        functions = [node.name for node in tree_of(path).body if isinstance(node, ast.FunctionDef)]
    except (SyntaxError, UnicodeDecodeError) as error:
        raise BadKernel(f"--against names {file}, which is not a Python file: {error}") from None
    if name not in functions:
        raise BadKernel(f"{file} has no function {name}; it has {', '.join(functions) or 'none'}")
    return path, name


def tree_of(path: Path) -> ast.Module:
    """Parse a file."""
    return ast.parse(path.read_text(encoding="utf-8"), str(path))


def flags_line(tree: ast.Module) -> int | None:
    """Return which statement of a file sets its flags."""
    for index, node in enumerate(tree.body):
        if isinstance(node, ast.Assign) and any(isinstance(t, ast.Name) and t.id == FLAGS for t in node.targets):
            return index
    return None


def loaded(path: Path, contraction: bool) -> ModuleType:
    """Run a file as a module, with contraction taken out of its flags if so asked."""
    tree = tree_of(path)
    line = flags_line(tree)
    if not contraction and line is not None:
        tree.body[line + 1 : line + 1] = ast.parse(f"{FLAGS} = set({FLAGS}) - {{{CONTRACT!r}}}").body
    module = ModuleType(path.stem)
    module.__file__ = str(path)
    try:
        exec(compile(tree, str(path), "exec"), module.__dict__)
    except Exception as error:
        raise BadKernel(f"{path.name} does not run: {summary(error)}") from error
    return module


def program_of(path: Path, name: str, contraction: bool, model: Model = STANDARD) -> Program:
    """Return the kernel as a program on one thread."""
    import numba

    function: Callable[..., Any] = getattr(loaded(path, contraction), name)

    def program(columns: Columns, transient: int, keep: int) -> tuple[Array, Array]:
        before = numba.get_num_threads()
        numba.set_num_threads(1)
        try:
            u, v, *_ = function(model.alpha, model.k, model.omega, model.r, model.V, *columns, transient, keep)
        except Exception as error:
            raise BadKernel(f"{name} of {path.name} failed: {summary(error)}") from error
        finally:
            numba.set_num_threads(before)
        wanted = (len(columns.d), keep, columns.u.shape[1])
        if np.shape(u) != wanted or np.shape(v) != wanted:
            raise BadKernel(f"{name} returned arrays {np.shape(u)} and {np.shape(v)}; wanted is {wanted} for u and v")
        return u, v

    return program
