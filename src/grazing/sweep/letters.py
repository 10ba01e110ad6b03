"""Texts and attributes in a store: texts as rows of letters, attributes as JSON with a record of what they were."""

from __future__ import annotations

import math
from collections.abc import Hashable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grazing.outcome import GrazingError, InputError
from grazing.sweep.codec import type_named

Types = dict[str, str]
#: The attribute of an array that holds text.
TEXT = "grazing_text"
#: Rows that are objects of Python at a time.
TOGETHER = 65536


# ---- texts


def encoded(texts: NDArray[Any], longest: int, name: str) -> NDArray[np.uint8]:
    """Return texts as UTF-8 letters along a new last dimension, zeros behind the last letter.

    Raises
    ------
    GrazingError
        For a text with more letters than the store has room for.
    """
    width = width_of(longest)
    rows = [text.encode() for text in texts.ravel()]
    for row in rows:
        if len(row) > width:
            raise GrazingError(f"{name} is {row.decode()!r}, {len(row)} letters; the plan announced at most {width}")
    return np.array(rows, f"S{width}").view(np.uint8).reshape((*texts.shape, width))


def decoded(letters: NDArray[np.uint8], known: dict[bytes, str] | None = None) -> NDArray[Any]:
    """Return the texts; equal ones are the same object, that in ``known`` if it is there, else put there."""
    known = {} if known is None else known
    width = letters.shape[-1]
    rows = np.ascontiguousarray(letters, np.uint8).view(f"S{width}").ravel()
    texts = np.empty(len(rows), object)
    for begin in range(0, len(rows), TOGETHER):
        part = rows[begin : begin + TOGETHER].tolist()
        for row in set(part) - known.keys():
            known[row] = row.decode()
        texts[begin : begin + TOGETHER] = [known[row] for row in part]
    return texts.reshape(letters.shape[:-1])


def width_of(longest: int) -> int:
    """Return the length of the letters' dimension; Zarr has no chunk of size 0."""
    return max(1, longest)


# ---- attributes


def stored_attrs(attrs: Mapping[Any, Any], where: str, types: Types) -> dict[str, Any]:
    """Return attributes as JSON has them; ``types`` records which of them were NumPy's, under ``where/name``."""
    stored: dict[str, Any] = {}
    for name, value in attrs.items():
        if isinstance(value, str):
            stored[name] = value
            continue
        array = np.asarray(value)
        if isinstance(value, (bool, dict)) or array.dtype.kind not in "iuf" or array.ndim > 1:
            raise InputError(f"attribute {name!r} of {where} is {value!r}; give text, a number or an array of numbers")
        plain = array.tolist()
        stored[name] = [_finite(item) for item in plain] if array.ndim else _finite(plain)
        if isinstance(value, (np.ndarray, np.generic)) or stored[name] != value:
            kind = array.dtype.name if isinstance(value, (np.ndarray, np.generic)) else "python"
            types[f"{where}/{name}"] = f"{kind} {array.ndim}"
    return stored


def restored_attrs(attrs: Mapping[str, Any], where: str, types: Types) -> dict[Hashable, Any]:
    """Return the attributes as they were."""
    found: dict[Hashable, Any] = {}
    for name, value in attrs.items():
        kind, _, ndim = types.get(f"{where}/{name}", "").partition(" ")
        if kind == "python":
            found[name] = [float(item) for item in value] if ndim == "1" else float(value)
        elif kind:
            array = np.array(value, type_named(kind, "biuf"))  # none such as texts of a billion letters
            found[name] = array if ndim == "1" else array[()]
        else:
            found[name] = value
    return found


def _finite(number: Any) -> Any:
    """Return a number that JSON has; it has neither NaN nor infinity."""
    if isinstance(number, float) and not math.isfinite(number):
        return "NaN" if math.isnan(number) else ("Infinity" if number > 0 else "-Infinity")
    return number
