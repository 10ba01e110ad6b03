"""Numbers that are sure: balls that contain the true one, and comparisons that hold for all of a ball."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from flint import arb, fmpq


class Undecided(ArithmeticError):
    """The ball is too wide for this decision; a higher precision may do."""


class Beyond(Exception):
    """More digits would not help: too much work, or a law that does not take balls."""


def certain(x: arb) -> int:
    """Return the sign that all of the ball has, 0 if there is none."""
    return 1 if x > 0 else (-1 if x < 0 else 0)


def sign(x: arb) -> int:
    """Return the sign of the number in the ball, or raise Undecided."""
    if x.is_zero():
        return 0
    known = certain(x)
    if known == 0:
        raise Undecided
    return known


class Sure:
    """A number for reset laws: arithmetic on balls, and comparisons that are certain or raise Undecided."""

    __slots__ = ("ball",)
    __hash__ = None  # type: ignore[assignment]

    def __init__(self, x: Any) -> None:
        from flint import arb

        if isinstance(x, bool) or not isinstance(x, (int, float, arb, Sure)):
            raise TypeError(f"{x!r} is not a number that a ball can hold")
        self.ball: arb = x.ball if isinstance(x, Sure) else arb(x)

    def __neg__(self) -> Sure:
        return Sure(-self.ball)

    def __pos__(self) -> Sure:
        return self

    def __abs__(self) -> Sure:
        return Sure(abs(self.ball))

    def __add__(self, x: Any) -> Sure:
        return Sure(self.ball + Sure(x).ball)

    def __sub__(self, x: Any) -> Sure:
        return Sure(self.ball - Sure(x).ball)

    def __mul__(self, x: Any) -> Sure:
        return Sure(self.ball * Sure(x).ball)

    def __truediv__(self, x: Any) -> Sure:
        return Sure(self.ball / Sure(x).ball)

    def __pow__(self, x: Any) -> Sure:
        return Sure(self.ball ** Sure(x).ball)

    __radd__, __rmul__ = __add__, __mul__

    def __rsub__(self, x: Any) -> Sure:
        return Sure(x) - self

    def __rtruediv__(self, x: Any) -> Sure:
        return Sure(x) / self

    def __rpow__(self, x: Any) -> Sure:
        return Sure(x) ** self

    def compared(self, x: Any) -> int:
        """Return the sign of the difference, or raise Undecided."""
        return sign((self - x).ball)

    def __lt__(self, x: Any) -> bool:
        return self.compared(x) < 0

    def __le__(self, x: Any) -> bool:
        return self.compared(x) <= 0

    def __gt__(self, x: Any) -> bool:
        return self.compared(x) > 0

    def __ge__(self, x: Any) -> bool:
        return self.compared(x) >= 0

    def __eq__(self, x: object) -> bool:
        return self.compared(x) == 0

    def __bool__(self) -> bool:
        return self.compared(0) != 0


class Slope:
    """A number for reset laws with its derivative by the velocity, for all velocities in a ball."""

    __slots__ = ("slope", "value")
    __hash__ = None  # type: ignore[assignment]

    def __init__(self, value: Any, slope: Any) -> None:
        self.value, self.slope = Sure(value), Sure(slope).ball

    @staticmethod
    def of(x: Any) -> Slope:
        """Return a number as one with a derivative."""
        return x if isinstance(x, Slope) else Slope(x, 0)

    def __neg__(self) -> Slope:
        return Slope(-self.value, -self.slope)

    def __pos__(self) -> Slope:
        return self

    def __abs__(self) -> Slope:
        if self.value.ball <= 0:
            return -self
        if self.value.ball >= 0:
            return self
        raise Undecided

    def __add__(self, x: Any) -> Slope:
        other = Slope.of(x)
        return Slope(self.value + other.value, self.slope + other.slope)

    def __sub__(self, x: Any) -> Slope:
        return self + -Slope.of(x)

    def __mul__(self, x: Any) -> Slope:
        other = Slope.of(x)
        return Slope(self.value * other.value, self.slope * other.value.ball + self.value.ball * other.slope)

    def __truediv__(self, x: Any) -> Slope:
        other = Slope.of(x)
        ratio = self.value / other.value
        return Slope(ratio, (self.slope - ratio.ball * other.slope) / other.value.ball)

    def __pow__(self, x: Any) -> Slope:
        if not isinstance(x, (int, float)) or x != int(x) or x < 1:
            raise TypeError("only whole powers have a slope here")
        return Slope(self.value ** int(x), int(x) * self.value.ball ** (int(x) - 1) * self.slope)

    __radd__, __rmul__ = __add__, __mul__

    def __rsub__(self, x: Any) -> Slope:
        return Slope.of(x) - self

    def __rtruediv__(self, x: Any) -> Slope:
        return Slope.of(x) / self

    def __lt__(self, x: Any) -> bool:
        return self.value < Slope.of(x).value

    def __le__(self, x: Any) -> bool:
        return self.value <= Slope.of(x).value

    def __gt__(self, x: Any) -> bool:
        return self.value > Slope.of(x).value

    def __ge__(self, x: Any) -> bool:
        return self.value >= Slope.of(x).value

    def __eq__(self, x: object) -> bool:
        return self.value == Slope.of(x).value

    def __bool__(self) -> bool:
        return bool(self.value)


def arb_between(low: float, high: float) -> arb:
    """Return a ball of all numbers between two, and no others where their half is a power of two."""
    from flint import arb

    return arb(0.5 * (low + high), 0.5 * (high - low))


def rational(x: float) -> fmpq:
    """Return a float as the fraction that it is."""
    from flint import fmpq

    return fmpq(*x.as_integer_ratio())
