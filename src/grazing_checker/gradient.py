"""Balls with their derivatives: whoever computes with them computes these as well, by the rules of the calculus."""

from __future__ import annotations

from typing import Any, Self

from grazing_checker.balls import Ball, number


class Gradient:
    """A ball with its derivatives by variables, each known by a number; those that are left out are 0.

    It does what the equations of a table and reset laws ask of a ball; what compares it looks at its value only.
    """

    __slots__ = ("by", "x")

    def __init__(self, x: Ball, by: dict[int, Ball]) -> None:
        self.x, self.by = x, by

    def _made(self, x: Ball, slope: Any, other: Gradient, other_slope: Any) -> Gradient:
        """Return a function of two, with its derivatives by them."""
        by = {k: slope * one for k, one in self.by.items()}
        for k, two in other.by.items():
            by[k] = by[k] + other_slope * two if k in by else other_slope * two
        return Gradient(x, by)

    def _of(self, x: Ball, slope: Any) -> Gradient:
        """Return a function of one, with its derivative."""
        return Gradient(x, {k: slope * one for k, one in self.by.items()})

    def __add__(self, other: Any) -> Gradient:
        two = lifted(other)
        return self._made(self.x + two.x, 1, two, 1)

    def __sub__(self, other: Any) -> Gradient:
        two = lifted(other)
        return self._made(self.x - two.x, 1, two, -1)

    def __mul__(self, other: Any) -> Gradient:
        two = lifted(other)
        return self._made(self.x * two.x, two.x, two, self.x)

    def __truediv__(self, other: Any) -> Gradient:
        two = lifted(other)
        ratio = self.x / two.x
        return self._made(ratio, 1 / two.x, two, -ratio / two.x)

    __radd__, __rmul__ = __add__, __mul__

    def __rsub__(self, other: Any) -> Gradient:
        return lifted(other) - self

    def __rtruediv__(self, other: Any) -> Gradient:
        return lifted(other) / self

    def __neg__(self) -> Gradient:
        return self._of(-self.x, -1)

    def __pow__(self, exponent: int) -> Gradient:
        return self._of(self.x**exponent, exponent * self.x ** max(exponent - 1, 0))

    def sqrt(self) -> Gradient:
        """Return the square root."""
        root = self.x.sqrt()
        return self._of(root, 1 / (2 * root))

    def exp(self) -> Gradient:
        """Return the exponential."""
        power = self.x.exp()
        return self._of(power, power)

    def log(self) -> Gradient:
        """Return the natural logarithm."""
        return self._of(self.x.log(), 1 / self.x)

    def sin_cos(self) -> tuple[Gradient, Gradient]:
        """Return sine and cosine."""
        sine, cosine = self.x.sin_cos()
        return self._of(sine, cosine), self._of(cosine, -sine)

    def is_finite(self) -> bool:
        """Return whether it and all its derivatives are."""
        return all(one.is_finite() for one in (self.x, *self.by.values()))

    def is_zero(self) -> bool:
        """Return whether its value is 0 and nothing else."""
        return bool(self.x.is_zero())

    def __lt__(self, other: Self | Ball | int) -> bool:
        return bool(self.x < lifted(other).x)

    def __le__(self, other: Self | Ball | int) -> bool:
        return bool(self.x <= lifted(other).x)

    def __gt__(self, other: Self | Ball | int) -> bool:
        return bool(self.x > lifted(other).x)

    def __ge__(self, other: Self | Ball | int) -> bool:
        return bool(self.x >= lifted(other).x)


def lifted(x: Any) -> Gradient:
    """Return a number as one that depends on nothing."""
    return x if isinstance(x, Gradient) else Gradient(x if isinstance(x, Ball) else number(x), {})


def variables(x: list[Ball]) -> list[Gradient]:
    """Return balls as variables, numbered as they come."""
    return [Gradient(one, {i: number(1)}) for i, one in enumerate(x)]


def derivative_of(F: list[Any], columns: int) -> list[list[Ball]]:
    """Return the rows of the derivatives of functions by the first variables."""
    return [[lifted(one).by.get(j, number(0)) for j in range(columns)] for one in F]
