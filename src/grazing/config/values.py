"""Values that a file writes as numbers and lists and a command line as text: numbers, ranges, states, boxes."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grazing.memory import refuse_too_large
from grazing.outcome import InputError, shown
from grazing.parameter import LARGEST, real, refuse_ends, whole

#: More values along one axis than any grid has; a typing error, not a wish.
MOST = 10**8
#: Bytes that a value of an axis takes while a study is prepared.
AXIS = 64
#: More periods than any picture shows curves of.
MANY = 1000
#: What stands for the bounds that a function chooses itself.
DEFAULT = "default"
#: Two numbers, with units or without, and what people write between the ends of a range.
_REAL = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_ENDS = re.compile(
    rf"[\[(]?\s*({_REAL})(\s*[^\W\d_/]+)?\s*(?:-|–|—|\.\.+|…|;|to|(?<=\s)and|,)\s*({_REAL})(\s*[^\W\d_/]+)?\s*[\])]?"
)
#: What begins with a number.
_BEGINS = re.compile(rf"\s*{_REAL}")
#: How periods are written, right or wrong; what is written in another way is a file.
_PERIODS = re.compile(r"[-\d,: ]*")
RANGE_FORM = "start:stop:count (evenly spaced), start:stop:count:log (evenly in the logarithm) or a list of numbers"


def number(value: Any, name: str, allowed: str = "any finite number is allowed") -> float:
    """Return a finite float from a number or its text, or raise InputError."""
    return real(_plain(value, float), name, allowed)


def count(value: Any, name: str, low: int, high: int = LARGEST) -> int:
    """Return a whole number from low to high from a number or its text, or raise InputError."""
    return whole(_plain(value, int), name, low, high)


def _plain(value: Any, kind: Callable[[str], Any]) -> Any:
    """Return what a text says, or the value as it is; what is wrong with it is said by the check that follows."""
    if not isinstance(value, str):
        return value
    try:
        return kind(value.strip())
    except ValueError:
        return value


def numbers(value: Any, name: str, least: int = 1) -> list[float]:
    """Return a list of floats from a list, a number or text such as ``0.1,0.2``."""
    items = value.split(",") if isinstance(value, str) else value
    if isinstance(items, (int, float)) and not isinstance(items, bool):
        items = [items]
    if not isinstance(items, (list, tuple)) or len(items) < least:
        raise InputError(f"{name} = {shown(value)}; give a list of numbers")
    return [number(item, f"{name}[{i}]") for i, item in enumerate(items)]


def wholes(value: Any, name: str) -> list[int]:
    """Return whole numbers >= 1 from a list, a number or text such as ``2,3,5`` or ``2:7``, which is 2 to 7.

    Examples
    --------
    >>> wholes("2:5", "curves"), wholes([3, 2, 3], "curves")
    ([2, 3, 4, 5], [2, 3])
    """
    if isinstance(value, str) and ":" in value:
        low, high = (count(item, name, 1) for item in pair(value, name))
        if high - low >= MANY:
            raise InputError(f"{name} = {shown(value)}: more than {MANY} numbers; give a shorter range")
        return list(range(low, high + 1))
    items = value.split(",") if isinstance(value, str) else value
    if not isinstance(items, (list, tuple)):
        items = [items]
    if not items:
        raise InputError(f"{name} = {shown(value)}; give whole numbers >= 1, such as 2,3,5 or 2:7")
    return sorted({count(item, name, 1) for item in items})


def curves(value: Any, name: str) -> list[int | str]:
    """Return periods whose boundary curves are drawn, in order, then files with branches and loci.

    Examples
    --------
    >>> curves("2:4", "curves"), curves(["locus.nc", "3", 2], "curves")
    ([2, 3, 4], [2, 3, 'locus.nc'])
    """
    items = value if isinstance(value, (list, tuple)) and value else [value]
    files = [item for item in items if isinstance(item, str) and not _PERIODS.fullmatch(item)]
    periods = [period for item in items if item not in files for period in wholes(item, name)]
    return [*sorted({*periods}), *dict.fromkeys(files)]


def found_from(value: Any, folder: str) -> Any:
    """Return what :func:`curves` takes with the whole paths of its files, found from a folder."""
    if isinstance(value, list):
        return [found_from(item, folder) for item in value]
    return (
        os.path.abspath(os.path.join(folder, value))
        if isinstance(value, str) and not _PERIODS.fullmatch(value)
        else value
    )


def pair(value: Any, name: str) -> list[float]:
    """Return [low, high] from a list of two numbers or text such as ``-1:1``."""
    items = value.split(":") if isinstance(value, str) else value
    if not isinstance(items, (list, tuple)) or len(items) != 2:
        raise InputError(f"{name} = {shown(value)}; give low:high, or [low, high] in a file")
    low, high = (number(item, name) for item in items)
    refuse_ends(low, high, f"{name} = {low:g}:{high:g}")
    return [low, high]


def pairs(value: Any, name: str) -> list[list[float]]:
    """Return [[low, high], ...], one for each coordinate, from lists or text such as ``0:1,-2:2``."""
    items = value.split(",") if isinstance(value, str) else value
    if not isinstance(items, (list, tuple)) or not items:
        raise InputError(
            f"{name} = {shown(value)}; give low:high for each coordinate, commas between them, or a list of [low, high]"
        )
    return [pair(item, name) for item in items]


def states(value: Any, name: str) -> int | list[list[float]]:
    """Return a number of random starts, or the starts themselves, from lists or text such as ``0.1,0;0.2,0``."""
    if isinstance(value, str) and ("," in value or ";" in value):
        value = [part for part in value.split(";") if part.strip()]
    if not isinstance(value, (list, tuple)):
        try:
            return count(value, name, 1)
        except InputError:
            raise InputError(
                f"{name} = {shown(value)}; allowed is a whole number >= 1, or states: 0.1,0;0.2,0 (0.1; is one of "
                "one number) or a list of lists"
            ) from None
    return [numbers(item, f"{name}[{i}]") for i, item in enumerate(value)]


def by_name(value: Any, name: str) -> dict[str, float]:
    """Return numbers by name from a table or text such as ``v=0,w=1``."""
    if isinstance(value, str):
        parts = [part.partition("=") for part in value.split(",")]
        if not all(equals for _name, equals, _number in parts):
            raise InputError(f"{name} = {shown(value)}; give coordinate=value, commas between several")
        value = {key.strip(): item for key, _equals, item in parts}
    if not isinstance(value, Mapping):
        raise InputError(f"{name} = {shown(value)}; give a table of coordinates, such as {{ v = 0.0 }}")
    return {str(key): number(item, f"{name}.{key}") for key, item in value.items()}


def other_range(text: str) -> tuple[str, str] | None:
    """Return the ends of a range that is written in another way than ours; None for what is a number, a list or ours.

    Examples
    --------
    >>> other_range("5-25"), other_range("5 Hz..25 Hz"), other_range("1e-3"), other_range("5:25"), other_range("5,25")
    (('5', '25'), ('5 Hz', '25 Hz'), None, None, None)
    """
    found = _ENDS.fullmatch(text.strip())
    if found is None or _plain(text, float) is not text or (found[2] and not found[4]):
        return None
    if "," in text and text.strip()[0] not in "[(":
        return None
    low, high = (found[i] + (found[i + 1] or "") for i in (1, 3))
    return low, high


def checked_form(value: Any, name: str, bounded: bool) -> None:
    """Raise InputError for a range that is written in another way than ours, with how it is written."""
    if not isinstance(value, str):
        return
    ends, said = other_range(value), f"{name} = {shown(value)}"
    if ends and bounded:
        raise InputError(f"{said}; give low:high, here {ends[0]}:{ends[1]}")
    if ends is None and not bounded and value.count(":") == 1 and all(map(_BEGINS.match, value.split(":"))):
        low, _, high = value.partition(":")
        ends = low.strip(), high.strip()
    if ends:
        raise InputError(f"{said}; give start:stop:count, such as {ends[0]}:{ends[1]}:100 for 100 values")


def range_of(value: Any, name: str) -> str | list[float]:
    """Return a range as it is written, checked: text ``start:stop:count[:log]``, or a list of floats.

    Examples
    --------
    >>> range_of(" 0 : 0.5:11", "d"), range_of("0.1,0.2", "d")
    ('0:0.5:11', [0.1, 0.2])
    """
    checked_form(value, name, False)
    if isinstance(value, str) and ":" in value:
        text = ":".join(part.strip() for part in value.split(":"))
        _ends(text, name)
        return text
    if isinstance(value, (list, tuple)) or (isinstance(value, str) and "," in value):
        return numbers(value, name)
    raise InputError(f"{name} = {shown(value)}; give {RANGE_FORM}")


def values_of(written: str | list[float]) -> NDArray[np.float64]:
    """Return the values of a range.

    Examples
    --------
    >>> values_of("0:0.5:3").tolist(), values_of("1:100:3:log").tolist()
    ([0.0, 0.25, 0.5], [1.0, 10.0, 100.0])
    """
    if not isinstance(written, str):
        return np.array(written, np.float64)
    if written.count(":") == 1:
        return np.array(pair(written, "range"))
    start, stop, n, log = _ends(written, "range")
    return np.geomspace(start, stop, n) if log else np.linspace(start, stop, n)


def bounds_of(value: Any, name: str) -> str:
    """Return bounds as they are written, checked: text ``low:high``, or the word ``default``.

    Examples
    --------
    >>> bounds_of(" 0.02 : 0.14", "d"), bounds_of([0.02, 0.14], "d")
    ('0.02:0.14', '0.02:0.14')
    """
    if isinstance(value, str) and value == DEFAULT:
        return DEFAULT
    checked_form(value, name, True)
    if isinstance(value, str) and value.count(":") in (2, 3):
        raise InputError(f"{name} = {shown(value)}; give low:high, without a count: the steps are chosen along the way")
    low, high = pair(value, name)
    if isinstance(value, str):
        return ":".join(part.strip() for part in value.split(":"))
    return f"{low!r}:{high!r}"


def bounds_by_name(value: Any, name: str) -> dict[str, list[float]]:
    """Return one name with its bounds from a table or text such as ``V=0.1:0.6``.

    Examples
    --------
    >>> bounds_by_name("V=0.1:0.6", "locus")
    {'V': [0.1, 0.6]}
    """
    if isinstance(value, str):
        key, equals, text = value.partition("=")
        value = {key.strip(): text} if equals else value
    if not isinstance(value, Mapping) or len(value) != 1 or "" in value:
        raise InputError(f"{name} = {shown(value)}; give one parameter and its range, NAME=LOW:HIGH, such as V=0.1:0.6")
    return {str(key): pair(item, f"{name} {key}") for key, item in value.items()}


def extremes(written: str | list[float]) -> tuple[float, float]:
    """Return the least and the greatest value of a range."""
    if not isinstance(written, str):
        return min(written), max(written)
    if written.count(":") == 1:
        low, high = pair(written, "range")
        return low, high
    start, stop, n, _log = _ends(written, "range")
    return (min(start, stop), max(start, stop)) if n > 1 else (start, start)


def written_as(values: NDArray[np.float64]) -> str | list[float]:
    """Return the shortest way to write values that gives back the same bits.

    Examples
    --------
    >>> written_as(np.linspace(0.05, 0.16, 12)), written_as(np.array([1.0, 2.0, 4.0]))
    ('0.05:0.16:12', '1.0:4.0:3:log')
    """
    start, stop = float(values[0]), float(values[-1])
    text = f"{start!r}:{stop!r}:{values.size}"
    forms = [text, f"{text}:log"] if start > 0.0 and stop > 0.0 else [text]
    for form in forms if start != stop else ():
        if np.array_equal(values_of(form), values):
            return form
    return [float(value) for value in values]


def _ends(text: str, name: str) -> tuple[float, float, int, bool]:
    """Return (start, stop, count, log) of a range in words, or raise InputError."""
    parts = text.split(":")
    if not (len(parts) == 3 or (len(parts) == 4 and parts[3] == "log")):
        raise InputError(f"{name} = {shown(text)}; give {RANGE_FORM}")
    try:
        start, stop = number(parts[0], "start"), number(parts[1], "stop")
        n = count(parts[2], "count", 1)
    except InputError as error:
        raise InputError(f"{name} = {shown(text)}: {error}") from None
    if n > MOST:
        raise InputError(f"{name} = {shown(text)}: {n} values are more than {MOST}; give a smaller count")
    refuse_too_large(AXIS * n, "give a smaller count", f"{name} with {n} values")
    log = len(parts) == 4
    if log and not (start > 0.0 and stop > 0.0):
        raise InputError(f"{name} = {shown(text)}: a logarithm needs both ends > 0")
    if n > 1 and start == stop:
        raise InputError(f"{name} = {shown(text)}: both ends are {start:g}; give different ends or count 1")
    if not math.isfinite(stop - start):
        raise InputError(f"{name} = {shown(text)}: the ends are too far apart")
    return start, stop, n, log
