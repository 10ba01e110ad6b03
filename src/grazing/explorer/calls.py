"""Calls of kernels by a page whose server computes: the functions of a module, compiled for this machine.

A call is the length of its head in four bytes, the head, and the arrays that are given, one after the other. The head
says in JSON the ``name`` of the function, its ``numbers`` (sizes too), and which arrays are ``given`` and ``wanted``.
The answer is the result, as a double, and the arrays that are wanted. The bits are those of a module.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from grazing.explorer.webassembly import Argument, Entry
from grazing.kernel.compile import ahead, call
from grazing.outcome import InputError

#: Where the page sends calls, seen from itself.
CALLS = "/calls/oscillator"
#: Bytes of a call, and of all its arrays: a picture of the page has a few millions.
LARGEST_CALL, LARGEST_ARRAYS = 2**26, 2**28


class Calls:
    """Answers calls: ``calls(body)`` is the answer.

    Parameters
    ----------
    entries : sequence of Entry
    who : str
        Who is to blame for a function that does not compile.
    """

    def __init__(self, entries: Sequence[Entry], who: str) -> None:
        self.entries, self.who = {entry.name: entry for entry in entries}, who

    def compile(self) -> None:
        """Compile all functions, so that the page need not wait for it."""
        for entry in self.entries.values():
            ahead(entry.kernel, [(argument.kind, len(argument.shape)) for argument in entry.arguments], self.who)

    def __call__(self, body: bytes) -> bytes:
        """Answer a call.

        Raises
        ------
        InputError
            For one that is none of a function's.
        """
        try:
            (size,) = struct.unpack_from("<I", body)
            head = json.loads(body[4 : 4 + size])
            entry, numbers, given = self.entries[head["name"]], head["numbers"], [*head["given"]]
            values = _values(entry, numbers, given, memoryview(body)[4 + size :])
            _check(entry, numbers, dict(zip((argument.name for argument in entry.arguments), values, strict=True)))
        except (KeyError, TypeError, ValueError, OverflowError, struct.error) as error:
            raise InputError(f"this is no call of a kernel: {error}") from None
        kinds = [(argument.kind, len(argument.shape)) for argument in entry.arguments]
        result = call(ahead(entry.kernel, kinds, self.who), *values, who=self.who)
        wanted = [v for a, v in zip(entry.arguments, values, strict=True) if a.name in head["wanted"]]
        return struct.pack("<d", result or 0.0) + b"".join(array.tobytes() for array in wanted)


def _whole(size: str | int, numbers: Mapping[str, Any]) -> int:
    """Return a size, by name, number, or a name and a number."""
    if isinstance(size, int):
        return size
    name, _, more = size.partition(" + ")
    return int(numbers[name]) + int(more or 0)


def _values(entry: Entry, numbers: Mapping[str, Any], given: Sequence[str], arrays: memoryview) -> list[Any]:
    """Return what a kernel is called with; arrays that are not given begin with zeros."""
    found: list[Any] = []
    left = LARGEST_ARRAYS
    for argument in entry.arguments:
        if not argument.shape:
            found.append(float(numbers[argument.name]) if argument.kind == "float64" else int(numbers[argument.name]))
            continue
        array, arrays = _array(argument, numbers, arrays if argument.name in given else None, arrays, left)
        left -= array.nbytes
        found.append(array)
    if len(arrays):
        raise ValueError(f"{len(arrays)} bytes too many")
    return found


def _array(
    argument: Argument, numbers: Mapping[str, Any], given: memoryview | None, arrays: memoryview, room: int
) -> tuple[Any, memoryview]:
    """Return an array of a call, and what is left of the bytes."""
    shape, kind = tuple(_whole(size, numbers) for size in argument.shape), np.dtype(argument.kind)
    if min(shape) < 0 or np.prod(shape, dtype=float) * kind.itemsize > room:
        raise ValueError(f"{argument.name} has the shape {shape}")
    array = np.zeros(shape, kind)
    if given is None:
        return array, arrays
    array[...] = np.frombuffer(given[: array.nbytes], kind.newbyteorder("<")).reshape(shape)
    return array, arrays[array.nbytes :]


def _check(entry: Entry, numbers: Mapping[str, Any], values: Mapping[str, Any]) -> None:
    """Refuse numbers that kernels take for places in arrays, and that are none: a kernel does not look."""
    if "which" in values and not 0 <= values["which"] < values["row"].size:
        raise ValueError(f"which = {values['which']}")
    if "coordinate" in values and not (0 <= values["coordinate"] < values["lanes"].shape[1] and values["bins"] >= 1):
        raise ValueError(f"coordinate = {values['coordinate']}, bins = {values['bins']}")
    if entry.name == "attractors":
        lasting = values["period"] >= 1
        if (values["period"] > int(numbers["keep"])).any() or (values["length"][lasting] < 1).any():
            raise ValueError("periods are longer than orbits")
