"""A claim of the paper beside what is computed, and the rule that compares the two."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from decimal import ROUND_HALF_EVEN, Decimal
from enum import StrEnum
from typing import Any

import numpy as np

Value = float | int | bool | str | list[Any] | None


class Verdict(StrEnum):
    """What became of a claim."""

    agrees = "agrees"
    differs = "differs"
    corrected = "corrected"


@dataclass(frozen=True)
class Claim:
    """One number or statement.

    Parameters
    ----------
    id : str
        Short and unique.
    where : str
        Place in the paper; *reference* where the paper prints no number and the value is the project's own.
    claim : str
        What is said, in our words.
    claimed : str, bool or list
        As printed: a number as text keeps its digits, so that ``"0.130"`` is more than ``"0.13"``.
    computed : float, int, bool, str or list
        From this run.
    tolerance : float, optional
        How far from ``claimed`` a number may be; default: half a unit of its last printed digit.
    slip : int, optional
        Number in the list of known slips of the paper: what is then computed is the right value.
    note : str
        What the reader should know.
    """

    id: str
    where: str
    claim: str
    claimed: Value
    computed: Value
    tolerance: float | None = None
    slip: int | None = None
    note: str = ""

    @property
    def allowed(self) -> float:
        """The tolerance, or half a unit of the last printed digit; 0 for what is no number."""
        if self.tolerance is not None:
            return self.tolerance
        return 0.5 * float(step_of(self.claimed)) if is_number(self.claimed) else 0.0

    @property
    def verdict(self) -> Verdict:
        """Equal within what is printed: *agrees*; else *corrected* for a known slip, *differs* for all others."""
        if agree(self.claimed, self.computed, self.tolerance):
            return Verdict.agrees
        return Verdict.differs if self.slip is None else Verdict.corrected

    def record(self) -> dict[str, Any]:
        """Return the claim as it stands in ``claims.json``."""
        fields = asdict(self)
        computed = fields["computed"]
        if isinstance(computed, float) and not math.isfinite(computed):
            fields["computed"] = str(computed)
        return {**fields, "tolerance": self.allowed, "verdict": self.verdict.value}


def is_number(value: object) -> bool:
    """Tell whether a value is a number, also as printed text."""
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        return True
    try:
        return isinstance(value, str) and Decimal(value).is_finite()
    except ArithmeticError:
        return False


def step_of(claimed: object) -> Decimal:
    """Return one unit of the last printed digit: 0.01 for ``"0.17"``, 1 for ``"3"``."""
    exponent = Decimal(str(claimed)).as_tuple().exponent
    return Decimal(1).scaleb(exponent) if isinstance(exponent, int) else Decimal(0)


def agree(claimed: Value, computed: Value, tolerance: float | None = None) -> bool:
    """Tell whether a computed value is the claimed one.

    Parameters
    ----------
    claimed, computed
        Numbers (the first perhaps as printed), texts, truth values or lists of them.
    tolerance : float, optional
        Without it a number is rounded to the printed digits and must then be equal.

    Returns
    -------
    bool

    Examples
    --------
    >>> agree("0.17", 0.181577), agree("0.22", 0.224377), agree(True, True), agree("0.5", 0.4987, 0.02)
    (False, True, True, True)
    """
    if isinstance(claimed, (list, tuple)) or isinstance(computed, (list, tuple)):
        if not (isinstance(claimed, (list, tuple)) and isinstance(computed, (list, tuple))):
            return False
        return len(claimed) == len(computed) and all(
            agree(a, b, tolerance) for a, b in zip(claimed, computed, strict=True)
        )
    if not (is_number(claimed) and is_number(computed)):
        return type(claimed) is type(computed) and claimed == computed
    value = float(computed)  # type: ignore[arg-type]
    if not math.isfinite(value):
        return False
    if tolerance is not None:
        return abs(value - float(claimed)) <= tolerance  # type: ignore[arg-type]
    return Decimal(repr(value)).quantize(step_of(claimed), ROUND_HALF_EVEN) == Decimal(str(claimed))


def plain(value: Any) -> Value:
    """Return a value as JSON can say it: numpy scalars and arrays become Python's."""
    if isinstance(value, np.ndarray):
        return [plain(item) for item in value.tolist()]
    if isinstance(value, np.generic):
        return plain(value.item())
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    return value  # type: ignore[no-any-return]


def claim(id: str, where: str, says: str, claimed: Value, computed: Any, note: str = "", **more: Any) -> Claim:
    """Return a claim with its computed value made plain."""
    return Claim(id, where, says, claimed, plain(computed), note=note, **more)
