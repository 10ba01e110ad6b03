"""What is known of a parameter, said once: read by checks, docstrings, options and axis labels."""

from __future__ import annotations

import math
from collections import namedtuple
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from functools import lru_cache
from typing import Any

from grazing.outcome import InputError


@dataclass(frozen=True, slots=True)
class Parameter:
    """A named real number with its symbol, meaning and allowed range.

    Parameters
    ----------
    name : str
        Name in Python, on the command line and in files.
    symbol : str
        LaTeX, without dollar signs.
    meaning : str
        What it is, in a few words.
    low, high : float
        Allowed range, ends included unless ``open`` says otherwise.
    open : str
        ``"low"`` when the lower end itself is not allowed, else empty.

    Examples
    --------
    >>> Parameter("r", "r", "coefficient of restitution", 0.0, 1.0).check(0.8)
    0.8
    """

    name: str
    symbol: str
    meaning: str
    low: float = -math.inf
    high: float = math.inf
    open: str = ""

    @property
    def allowed(self) -> str:
        """The range in words, such as ``0 <= r <= 1``."""
        if self.low == -math.inf and self.high == math.inf:
            return f"any finite {self.name}"
        if self.high == math.inf:
            return f"{self.name} {'>' if self.open == 'low' else '>='} {self.low:g}, finite"
        return f"{self.low:g} {'<' if self.open == 'low' else '<='} {self.name} <= {self.high:g}"

    def check(self, value: Any) -> float:
        """Return the value as a float, or raise InputError saying what is allowed."""
        number = real(value, self.name, f"allowed is {self.allowed} ({self.meaning})")
        inside = self.low <= number <= self.high and not (self.open == "low" and number == self.low)
        if not inside:
            raise InputError(f"{self.name} = {number:g}; allowed is {self.allowed} ({self.meaning})")
        return number


@lru_cache(maxsize=256)
def parameter_tuple(names: tuple[str, ...]) -> type:
    """Return the named tuple type of these fields; the same type for the same names, as compiled code needs it."""
    return namedtuple("Parameters", names)


def real(value: Any, name: str, allowed: str) -> float:
    """Return a finite float, or raise InputError; booleans, text and complex numbers are refused."""
    try:
        if isinstance(value, (bool, str, bytes)):
            raise TypeError
        number = float(value)
    except (TypeError, ValueError, OverflowError):
        raise InputError(f"{name} = {value!r} is not a real number; {allowed}") from None
    if not math.isfinite(number):
        raise InputError(f"{name} = {number} is not finite; {allowed}")
    return number


def whole(value: Any, name: str, low: int) -> int:
    """Return an int >= low, or raise InputError."""
    try:
        if isinstance(value, bool) or int(value) != value:
            raise TypeError
    except (TypeError, ValueError, OverflowError):
        raise InputError(f"{name} = {value!r}; allowed is a whole number >= {low}") from None
    if value < low:
        raise InputError(f"{name} = {value}; allowed is a whole number >= {low}")
    return int(value)


def unknown(name: object, names: Iterable[str], of: str) -> InputError:
    """Return the error for a name that does not exist, with the nearest one that does."""
    known = list(names)
    near = get_close_matches(str(name), known, n=1)
    hint = f" Did you mean {near[0]!r}?" if near else ""
    return InputError(f"unknown parameter {name!r} of {of}.{hint} Allowed are: {', '.join(known)}")


def updated(params: Mapping[str, float], changes: Mapping[str, Any], of: str) -> dict[str, Any]:
    """Return params with changes applied, refusing names that do not exist."""
    for name in changes:
        if name not in params:
            raise unknown(name, params, of)
    return {**params, **changes}
