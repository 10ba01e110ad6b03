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

from grazing.explorer.oscillator import HARMONICS
from grazing.explorer.webassembly import Argument, Entry
from grazing.kernel.compile import ahead, call
from grazing.outcome import InputError

#: Where the page sends calls, seen from itself.
CALLS = "/calls/own"
#: Bytes of a call, of all its arrays, and of its head: a picture of the page has a few millions, a head some hundreds.
LARGEST_CALL, LARGEST_ARRAYS, LARGEST_HEAD = 2**26, 2**28, 2**16
INFINITY = float("inf")


class Calls:
    """Answers calls: ``calls(body)`` is the answer. All functions are compiled first, so that the page need not wait.

    Parameters
    ----------
    entries : sequence of Entry
    who : str
        Who is to blame for a function that does not compile.
    """

    def __init__(self, entries: Sequence[Entry], who: str) -> None:
        self.entries, self.who = {entry.name: entry for entry in entries}, who
        self._compiled = {
            entry.name: ahead(entry.kernel, [(each.kind, len(each.shape)) for each in entry.arguments], who)
            for entry in entries
        }

    def __call__(self, body: bytes) -> bytes:
        """Answer a call.

        Raises
        ------
        InputError
            For one that is none of a function's.
        """
        try:
            (size,) = struct.unpack_from("<I", body)
            if size > LARGEST_HEAD:  # lists of three bytes take twenty times as many when they are read
                raise ValueError(f"its head has {size} bytes")
            head = json.loads(body[4 : 4 + size])
            entry, numbers, given = self.entries[head["name"]], head["numbers"], [*head["given"]]
            values = _values(entry, numbers, given, memoryview(body)[4 + size :])
            wanted = [v for a, v in zip(entry.arguments, values, strict=True) if a.shape and a.name in head["wanted"]]
            _check(entry, numbers, dict(zip((argument.name for argument in entry.arguments), values, strict=True)))
        except (ArithmeticError, LookupError, RecursionError, TypeError, ValueError, struct.error) as error:
            raise InputError(f"this is no call of a kernel: {str(error)[:200]}") from None
        result = call(self._compiled[entry.name], *values, who=self.who)
        return struct.pack("<d", result or 0.0) + b"".join(array.tobytes() for array in wanted)


def _integer(name: str, numbers: Mapping[str, Any]) -> int:
    """Return a whole number, of the 32 bits that a module takes."""
    value = int(numbers[name])
    if value != numbers[name] or not -(2**31) <= value < 2**31:
        raise ValueError(f"{name} is no whole number of 32 bits")
    return value


def _real(name: str, numbers: Mapping[str, Any]) -> float:
    """Return a number, or an infinity; a kernel may go up to one that is neither for ever."""
    value = float(numbers[name])
    if value != value:
        raise ValueError(f"{name} is not a number")
    return value


def _whole(size: str | int, numbers: Mapping[str, Any]) -> int:
    """Return a size, by name, number, or a name and a number."""
    if isinstance(size, int):
        return size
    name, _, more = size.partition(" + ")
    return _integer(name, numbers) + int(more or 0)


def _values(entry: Entry, numbers: Mapping[str, Any], given: Sequence[str], arrays: memoryview) -> list[Any]:
    """Return what a kernel is called with; arrays that are not given begin with zeros."""
    found: list[Any] = []
    left = LARGEST_ARRAYS
    for argument in entry.arguments:
        if not argument.shape:
            found.append((_real if argument.kind == "float64" else _integer)(argument.name, numbers))
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
    if min(shape) < 1 or np.prod(shape, dtype=float) * kind.itemsize > room:
        raise ValueError(f"{argument.name} has the shape {shape}")
    array = np.zeros(shape, kind)
    if given is None:
        return array, arrays
    array[...] = np.frombuffer(given[: array.nbytes], kind.newbyteorder("<")).reshape(shape)
    return array, arrays[array.nbytes :]


def _check(entry: Entry, numbers: Mapping[str, Any], values: Mapping[str, Any]) -> None:
    """Refuse numbers of which kernels make places in arrays, and that are none: a kernel does not look."""
    for name in {"row", "rows"} & values.keys():
        if not np.isfinite(values[name]).all():
            raise ValueError("parameters are not finite")
    if "which" in values and not 0 <= values["which"] < values["row"].size:
        raise ValueError(f"which = {values['which']}")
    if entry.name == "density":
        _check_raster(values["coordinate"], values["low"], values["high"], values["bins"], values["lanes"].shape[1])
    if entry.name == "legs" and not 0.0 <= values["state"][4] <= 2 * HARMONICS:
        raise ValueError("the flight begins in no window of the force")
    if entry.name == "attractors":
        lasting = values["period"] >= 1
        if (values["period"] > int(numbers["keep"])).any() or (values["length"][lasting] < 1).any():
            raise ValueError("periods are longer than orbits")


def _check_raster(coordinate: int, low: float, high: float, bins: int, dimension: int) -> None:
    if not 0 <= coordinate < dimension:
        raise ValueError(f"coordinate = {coordinate}")
    if not (bins >= 1 and -INFINITY < low < high < INFINITY and bins / (high - low) < INFINITY):
        raise ValueError(f"low = {low}, high = {high}, bins = {bins}")
