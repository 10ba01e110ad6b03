"""The values a closed form accepts, checked in one place: N, lam, mu, l, always in this order.

Scalars give Python numbers back (:func:`period`, :func:`number`); :func:`elements` checks whole arrays.
"""

from __future__ import annotations

from typing import Any, Final, NamedTuple

import numpy as np
import numpy.typing as npt

from grazing.outcome import InputError, shown

__all__ = ["FloatArray", "Periods", "Values", "elements", "number", "period", "plain"]

FloatArray = npt.NDArray[np.float64]
Periods = int | npt.ArrayLike
Values = float | npt.ArrayLike


class Rule(NamedTuple):
    """What one parameter may be: lower bound, whether it is attained, upper bound, and the advice."""

    low: float
    attained: bool
    high: float
    allowed: str
    advice: str


#: Beyond, squares of it could overflow.
LARGEST: Final = 1e100

RULES: Final = {
    "N": Rule(1, True, np.inf, "an integer >= 1", "give the period of the orbit as an int"),
    "lam": Rule(0, False, 1, "a finite number with 0 < lam < 1", "lam is the slope of (2.6) for x < 0"),
    "mu": Rule(-LARGEST, True, LARGEST, "a finite number up to 1e100 in size", "mu is the offset of (2.6)"),
    "l": Rule(0, True, LARGEST, "a finite number >= 0, up to 1e100", "l is the gap of (2.6); l = 0 closes it"),
}


def elements(**values: object) -> list[FloatArray]:
    """Check each value, element by element, and return them as float arrays of one common shape."""
    arrays = [_checked(name, value) for name, value in values.items()]
    try:
        return list(np.broadcast_arrays(*arrays))
    except ValueError:
        shapes = ", ".join(f"{name} {array.shape}" for name, array in zip(values, arrays, strict=True))
        raise InputError(f"shapes do not match: {shapes}; give scalars or arrays that broadcast") from None


def plain(value: FloatArray) -> float | FloatArray:
    """Return a Python float for a value without dimensions and the array itself for any other."""
    array = np.asarray(value)
    return float(array) if array.ndim == 0 else array


def period(N: object) -> int:
    """Check one period and return it as an int."""
    return int(number("N", N))


def number(name: str, value: object) -> float:
    """Check one number and return it as a float."""
    array = _checked(name, value)
    if array.ndim:
        raise InputError(f"{name} has shape {array.shape}; one number is allowed here; call once per element")
    return float(array)


def _checked(name: str, value: object) -> FloatArray:
    rule = RULES[name]
    array = _as_numbers(name, value)
    with np.errstate(over="ignore"):  # of a wider number: inf is refused
        wide = array.astype(np.float64)  # narrow numbers cannot be compared with bounds beyond them
    above = wide >= rule.low if rule.attained else wide > rule.low
    allowed = above & (wide < rule.high)
    if not np.all(allowed):
        raise _refusal(name, array[~allowed].flat[0] if array.ndim else value)
    return np.asarray(array, dtype=np.float64)


def _as_numbers(name: str, value: object) -> npt.NDArray[Any]:
    try:
        array = np.asarray(value)
    except Exception:  # of whatever object was given, or of one too large
        raise _refusal(name, value) from None
    if np.ma.is_masked(value) or array.dtype.kind not in ("iu" if name == "N" else "iuf"):
        raise _refusal(name, value)
    return array


def _refusal(name: str, got: object) -> InputError:
    plain = got.item() if isinstance(got, np.generic) else got
    rule = RULES[name]
    return InputError(f"{name} = {shown(plain)} is not allowed; {name} must be {rule.allowed}: {rule.advice}")
