"""Copies of models, maps, orbits and plans: equal by value, and pickled with the functions that they are made of.

Compiled code is never copied: a copy finds it again by its content.
"""

from __future__ import annotations

import hashlib
import pickle
import re
from collections.abc import Callable, Mapping
from dataclasses import fields, is_dataclass
from functools import partial
from importlib import import_module
from importlib.util import MAGIC_NUMBER, find_spec
from operator import attrgetter
from types import BuiltinFunctionType, FunctionType
from typing import Any, TypeVar

import numpy as np

from grazing.kernel.content import below, coded, content, digest, frozen, reached
from grazing.outcome import InputError, raised

_Tuple = TypeVar("_Tuple", bound=tuple[Any, ...])
#: How the modules begin that a user's file is run as: no other process finds them by name.
OWN_MODULE = "_grazing_own_"


class ByValue:
    """Equality by value for classes of fields; the hash is that of what they say of themselves."""

    __slots__ = ()

    def __eq__(self, other: object) -> bool:
        return type(self) is type(other) and all(alike(*pair) for pair in zip(_parts(self), _parts(other), strict=True))

    def __hash__(self) -> int:
        # equal functions lie at places of their own, which their texts tell
        return hash((type(self).__name__, re.sub(" at 0x[0-9a-fA-F]+", "", repr(self))))


def by_value(kind: type[_Tuple]) -> type[_Tuple]:
    """Let named tuples with arrays in them compare by value: a tuple asks whether all of an array is true or not."""
    kind.__eq__ = alike  # type: ignore[method-assign]
    kind.__ne__ = lambda one, other: not alike(one, other)  # type: ignore[method-assign]
    kind.__hash__ = _hash_of_shapes  # type: ignore[method-assign, assignment]
    return kind


def _hash_of_shapes(value: tuple[Any, ...]) -> int:
    """Return a hash of what equal tuples have in common, whichever zero or NaN stands in them."""
    return hash((type(value).__name__, *(getattr(part, "shape", type(part).__name__) for part in value)))


def _parts(value: Any) -> list[Any]:
    """Return what an object consists of; what its class leaves out of comparisons tells no more than the rest."""
    if is_dataclass(value):
        return [getattr(value, field.name) for field in fields(value) if field.compare]
    return [vars(value)] if hasattr(value, "__dict__") else []


def alike(a: Any, b: Any) -> bool:
    """Say whether two values are the same: arrays by their numbers, functions by their code, NaN equals NaN."""
    if a is b:
        return True
    if isinstance(a, Mapping) and isinstance(b, Mapping):
        return list(a) == list(b) and all(alike(a[key], b[key]) for key in a)
    if type(a) is not type(b):
        return isinstance(a, str) and isinstance(b, str) and a == b  # a name may come from an array of names
    if isinstance(a, np.ndarray):
        if a.shape != b.shape or a.dtype != b.dtype:
            return False
        return (
            a.tolist() == b.tolist() if a.dtype.kind in "OU" else np.array_equal(a, b, equal_nan=a.dtype.kind in "fc")
        )
    if isinstance(a, (tuple, list)):
        return len(a) == len(b) and all(alike(*pair) for pair in zip(a, b, strict=True))
    if isinstance(a, partial):
        return alike((a.func, a.args, a.keywords), (b.func, b.args, b.keywords))
    if isinstance(a, FunctionType):
        return a.__name__ == b.__name__ and digest(a) == digest(b)
    if isinstance(a, float):
        return bool(a == b) or (a != a and b != b)
    if (
        not any("__eq__" in kind.__dict__ for kind in type(a).__mro__[:-1])
        and type(a).__module__.partition(".")[0] == "grazing"
    ):
        return all(alike(*pair) for pair in zip(_parts(a), _parts(b), strict=True))
    return bool(a == b)


class Code:
    """A function on its way into a pickle; what comes out is the function itself, and a copy in memory shares it.

    One that a module has at its top travels by name, with a hash of its code: what has that name elsewhere, or later,
    may be another one. One that has ``made_by``, a function and its arguments, is made again. Any other, such as a
    lambda, travels whole if cloudpickle is there, and so do those of a program, which others do not find by name.
    """

    def __init__(self, function: Callable[..., Any]) -> None:
        self.function = function

    def __deepcopy__(self, memo: Any) -> Callable[..., Any]:
        return self.function

    def __reduce__(self) -> Any:
        made_by = getattr(self.function, "made_by", None)
        if made_by is not None:
            factory, args = made_by
            return factory, tuple(packed(arg) for arg in args)
        module = str(getattr(self.function, "__module__", ""))
        whole = module.startswith(OWN_MODULE) or (module == "__main__" and find_spec("cloudpickle") is not None)
        try:
            if not whole:
                pickle.dumps(self.function)
                if isinstance(self.function, FunctionType):
                    return still, (module, self.function.__qualname__, _code(self.function))
                return _itself, (self.function,)
        except Exception:  # whatever an object says that cannot be pickled
            pass
        try:
            return unpacked, (MAGIC_NUMBER, _whole(self.function))
        except ImportError:
            name = getattr(self.function, "__qualname__", repr(self.function))
            raise InputError(
                f"{name} cannot be pickled, because no other process could find it by that name; "
                "define it at the top of a module with def, or pip install cloudpickle, which takes it whole"
            ) from None


def _code(function: Any) -> tuple[bytes, str] | None:
    """Return a hash of the code of a function that is not ours, with the Python that compiled it."""
    if isinstance(function, FunctionType) and not function.__module__.startswith("grazing."):
        return MAGIC_NUMBER, _outline(function)
    return None


def _outline(function: FunctionType) -> str:
    """Hash the code of a function and of those that it names, and the numbers and texts that they name.

    Another process with the same Python gets the same for the same; functions of this package are left out, as are
    values that no two processes can compare.
    """
    found, seen = [], [function]
    for each in seen:  # which grows
        found.append((coded(each.__code__), _comparable(frozen(each))))
        seen += [one for one in below(each) if one not in seen and not one.__module__.startswith("grazing.")]
    return hashlib.sha256(repr(found).encode()).hexdigest()


def _comparable(values: dict[str, Any]) -> list[Any]:
    """Return of values what two processes can compare, and of modules in them what is behind their dots."""
    parts = [values, *map(vars, reached(tuple(values.values())))]
    return [
        [(key, content(value, (), {})) for key, value in sorted(part.items()) if _is_comparable(value)]
        for part in parts
    ]


def _is_comparable(value: object) -> bool:
    """Say whether a value is a number, a text, an array or a tuple of them, or a function of ``math``."""
    if isinstance(value, tuple):
        return all(map(_is_comparable, value))
    return isinstance(value, (int, float, complex, str, bytes, np.generic, BuiltinFunctionType)) or (
        isinstance(value, np.ndarray) and value.dtype.kind in "biufcSU"
    )


def still(module: str, name: str, code: tuple[bytes, str] | None) -> Callable[..., Any]:
    """Return the function that a module has at its top by a name, if it is the one that was pickled.

    Raises
    ------
    InputError
        If it is gone, is another one, or names other numbers or functions.
    """
    try:
        function: Any = attrgetter(name)(import_module(module))
    except Exception as error:  # of whatever kind: a module is the code of its user
        raise InputError(
            f"{module}.{name}, which was pickled by its name, is not found here ({raised(error)}); put it back, or "
            "make the object anew"
        ) from error
    here = _code(function)
    if code is None or (here is not None and (code[0] != here[0] or code == here)):  # other Pythons cannot be compared
        return function  # type: ignore[no-any-return]
    raise InputError(
        f"{module}.{name} is not the function that was pickled: its code, or a number or "
        "function that it names, is another one here; put that back, or make the object anew"
    )


def _itself(function: Callable[..., Any]) -> Callable[..., Any]:
    """Return what a pickle found: no function of Python, such as one that was compiled."""
    return function


def unpacked(magic: bytes, content: bytes) -> Callable[..., Any]:
    """Return a function that travelled whole.

    Raises
    ------
    InputError
        For one of another Python, whose code this one cannot read, or without cloudpickle.
    """
    if magic != MAGIC_NUMBER or find_spec("cloudpickle") is None:
        wants = "the version of Python that pickled it" if magic != MAGIC_NUMBER else "cloudpickle: pip install it"
        raise InputError(f"a function was pickled whole; to read it takes {wants}, or make the object anew")
    return pickle.loads(content)  # type: ignore[no-any-return]


def _whole(function: Any) -> bytes:
    cloudpickle: Any = import_module("cloudpickle")
    name = str(getattr(function, "__module__", ""))
    if name.startswith(OWN_MODULE):
        cloudpickle.register_pickle_by_value(import_module(name))
    content: bytes = cloudpickle.dumps(function)
    return content


def packed(value: Any) -> Any:
    """Return a value as a pickle can keep it: functions as :class:`Code`, mappings as dictionaries."""
    if isinstance(value, Mapping):
        return {key: packed(item) for key, item in value.items()}
    if isinstance(value, tuple) and any(map(callable, value)):
        return tuple(map(packed, value))
    return Code(value) if callable(value) else value


def plain(value: Any) -> Any:
    """Return what :func:`packed` was given."""
    if isinstance(value, dict):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, tuple) and any(isinstance(item, Code) for item in value):
        return tuple(map(plain, value))
    return value.function if isinstance(value, Code) else value


def made_of(kind: Any, items: tuple[Any, ...]) -> Any:
    """Return an object of the parts that a pickle keeps, as :func:`packed` gave them."""
    return kind(*(plain(item) for item in items))
