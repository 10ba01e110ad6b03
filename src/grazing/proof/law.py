"""Reset laws in balls, with their exact slopes: a law is called with numbers that carry derivatives."""

from __future__ import annotations

from math import isfinite
from typing import TYPE_CHECKING, Any

from grazing.oscillator.exact import Undecided, sign
from grazing.oscillator.reset import Reset
from grazing.parameter import parameter_tuple

if TYPE_CHECKING:
    from flint import arb


class NotInBalls(Exception):
    """The law uses more than arithmetic, comparisons and ``abs`` on its arguments."""


class BreaksPromise(Exception):
    """The law returns a velocity into the wall, or not finite."""


class Dual:
    """A ball with its derivatives by the incoming velocity and by a parameter; comparisons are certain or raise."""

    __slots__ = ("ball", "slopes")
    __hash__ = None  # type: ignore[assignment]

    def __init__(self, x: Any, slopes: tuple[arb, arb] | None = None) -> None:
        from flint import arb

        if isinstance(x, bool) or not isinstance(x, (int, float, arb, Dual)):
            raise TypeError(f"{x!r} is not a number that a ball can hold")
        carried = x.slopes if isinstance(x, Dual) else (slopes or (arb(0), arb(0)))
        self.ball: arb = x.ball if isinstance(x, Dual) else arb(x)
        self.slopes: tuple[arb, arb] = carried

    def chained(self, value: arb, slope: arb) -> Dual:
        """Return a function of this number with that value and derivative."""
        return Dual(value, (slope * self.slopes[0], slope * self.slopes[1]))

    def __neg__(self) -> Dual:
        return Dual(-self.ball, (-self.slopes[0], -self.slopes[1]))

    def __pos__(self) -> Dual:
        return self

    def __abs__(self) -> Dual:
        return -self if self < 0 else self

    def __add__(self, x: Any) -> Dual:
        other = Dual(x)
        sums = self.slopes[0] + other.slopes[0], self.slopes[1] + other.slopes[1]
        return Dual(self.ball + other.ball, sums)

    def __sub__(self, x: Any) -> Dual:
        return self + -Dual(x)

    def __mul__(self, x: Any) -> Dual:
        other = Dual(x)
        a, b = self.ball, other.ball
        slopes = self.slopes[0] * b + a * other.slopes[0], self.slopes[1] * b + a * other.slopes[1]
        return Dual(a * b, slopes)

    def __truediv__(self, x: Any) -> Dual:
        other = Dual(x)
        return self * other.chained(1 / other.ball, -1 / other.ball**2)

    def __pow__(self, x: Any) -> Dual:
        power = Dual(x)
        a, b = self.ball, power.ball
        steady = all(slope.is_zero() for slope in power.slopes)
        if steady and b.is_zero():
            return Dual(1)
        raised = self.chained(a**b, b * a ** (b - 1))
        return raised if steady else raised + power.chained(0 * a, a.log() * a**b)

    __radd__, __rmul__ = __add__, __mul__

    def __rsub__(self, x: Any) -> Dual:
        return Dual(x) - self

    def __rtruediv__(self, x: Any) -> Dual:
        return Dual(x) / self

    def __rpow__(self, x: Any) -> Dual:
        return Dual(x) ** self

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


class Law:
    """The reset law of one model; the parameters are balls, one of them may be the unknown.

    Parameters
    ----------
    reset : Reset
        The law.
    params : mapping of str to arb
        All parameters of the model.
    name : str, optional
        The parameter by which derivatives are asked for.
    """

    def __init__(self, reset: Reset, params: dict[str, arb], name: str | None = None) -> None:
        from flint import arb

        self.reset = reset
        ones = (arb(0), arb(1))
        fields = [Dual(x, ones if key == name else None) for key, x in params.items()]
        self.p = parameter_tuple(tuple(params))(*fields)

    def __call__(self, v: arb) -> tuple[arb, arb, arb]:
        """Return the velocity after an impact at v, its slope, and its derivative by the parameter.

        Raises
        ------
        Undecided
            If a comparison in the law holds for a part of the ball only.
        NotInBalls, BreaksPromise
            If the law cannot be evaluated so, or does not return a finite velocity.
        """
        from flint import arb

        try:
            w = self.reset.law(Dual(v, (arb(1), arb(0))), self.p)
            answer = Dual(w)
        except Undecided:
            raise
        except Exception as error:  # the law is not ours: whatever it raises, it does not take balls
            raise NotInBalls(f"{type(error).__name__}: {error}") from error
        if isinstance(w, float) and not isfinite(w):
            raise BreaksPromise
        if not all(x.is_finite() for x in (answer.ball, *answer.slopes)):
            raise Undecided
        return answer.ball, answer.slopes[0], answer.slopes[1]
