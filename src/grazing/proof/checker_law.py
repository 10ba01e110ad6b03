"""Reset laws as the checker sees them: the built-in ones by their formulas, a user's with a number type of its own."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple

from grazing.kernel.compile import digest
from grazing.parameter import parameter_tuple
from grazing.proof.checker_reading import Rejected, demand

if TYPE_CHECKING:
    from flint import arb

BUILT_IN = {"newton": {"r"}, "active": {"r", "V"}, "triggered": {"r", "V", "trigger"}}


class Answer(NamedTuple):
    """The velocity after an impact, its slope, and its derivative by the unknown parameter."""

    w: arb
    slope: arb
    change: arb


class Jet:
    """A ball and its derivative, for a user's law; a comparison that is not certain rejects the certificate."""

    __hash__ = None  # type: ignore[assignment]

    def __init__(self, x: arb, d: arb) -> None:
        self.x, self.d = x, d

    @staticmethod
    def of(other: Any) -> Jet:
        """Return a number as a jet."""
        from flint import arb

        if isinstance(other, Jet):
            return other
        if isinstance(other, bool) or not isinstance(other, (int, float)):
            raise TypeError(f"{other!r} is not a number that a ball can hold")
        return Jet(arb(other), arb(0))

    def __neg__(self) -> Jet:
        return Jet(-self.x, -self.d)

    def __pos__(self) -> Jet:
        return self

    def __abs__(self) -> Jet:
        return self if self >= 0 else -self

    def __add__(self, other: Any) -> Jet:
        o = Jet.of(other)
        return Jet(self.x + o.x, self.d + o.d)

    def __sub__(self, other: Any) -> Jet:
        o = Jet.of(other)
        return Jet(self.x - o.x, self.d - o.d)

    def __mul__(self, other: Any) -> Jet:
        o = Jet.of(other)
        return Jet(self.x * o.x, self.x * o.d + self.d * o.x)

    def __truediv__(self, other: Any) -> Jet:
        o = Jet.of(other)
        ratio = self.x / o.x
        return Jet(ratio, (self.d - ratio * o.d) / o.x)

    def __pow__(self, other: Any) -> Jet:
        from flint import arb

        o = Jet.of(other)
        if o.d.is_zero() and o.x.is_zero():
            return Jet(arb(1), arb(0))
        value = self.x**o.x
        change = o.x * self.x ** (o.x - 1) * self.d
        return Jet(value, change if o.d.is_zero() else change + value * self.x.log() * o.d)

    __radd__, __rmul__ = __add__, __mul__

    def __rsub__(self, other: Any) -> Jet:
        return Jet.of(other) - self

    def __rtruediv__(self, other: Any) -> Jet:
        return Jet.of(other) / self

    def __rpow__(self, other: Any) -> Jet:
        return Jet.of(other) ** self

    def side(self, other: Any) -> int:
        """Return the sign of the difference."""
        gap = self.x - Jet.of(other).x
        if gap.is_zero():
            return 0
        if not (gap > 0 or gap < 0):
            raise Rejected("a comparison in the reset law is not certain over the box")
        return 1 if gap > 0 else -1

    def __lt__(self, other: Any) -> bool:
        return self.side(other) < 0

    def __le__(self, other: Any) -> bool:
        return self.side(other) <= 0

    def __gt__(self, other: Any) -> bool:
        return self.side(other) > 0

    def __ge__(self, other: Any) -> bool:
        return self.side(other) >= 0

    def __eq__(self, other: object) -> bool:
        return self.side(other) == 0

    def __bool__(self) -> bool:
        return self.side(0) != 0


Impact = Callable[["arb"], Answer]


def impact_of(law: Any, params: dict[str, arb], all_params: dict[str, arb], unknown: str, code: Any) -> Impact:
    """Return the reset law of a certificate: from the velocity before an impact to the answer.

    Parameters
    ----------
    law : dict
        Name, parameters and fingerprint, as the certificate has them.
    params, all_params : dict of str to arb
        Parameters of the law alone, and all of the model, in the order in which a law of the user's gets them.
    unknown : str
        The parameter by which derivatives are asked for, or empty.
    code : callable or None
        The user's law.
    """
    if law["code"] == "":
        name = law["name"]
        demand(
            name in BUILT_IN and set(params) == BUILT_IN[name], f"{name!r} is no built-in reset law with its parameters"
        )
        demand(params["r"] >= 0 and params["r"] <= 1, "r is not in [0, 1]")
        return _built_in(name, params, unknown)
    demand(
        callable(code),
        f"the reset law {law['name']!r} is not one of the package; give it too: check_certificate(..., law=function)",
    )
    demand(
        digest(code)[:16] == law["code"], f"the function given is not the reset law {law['name']!r} of the certificate"
    )
    return _users(code, all_params, unknown)


def _built_in(name: str, p: dict[str, arb], unknown: str) -> Impact:
    from flint import arb

    def impact(v: arb) -> Answer:
        kicks = name == "active"
        if name == "triggered":
            above, beneath = -v >= p["trigger"], -v < p["trigger"]
            demand(above or beneath, "it is not certain whether an impact fires the bumper")
            kicks = bool(above)
        w = -p["r"] * v + (p["V"] if kicks else 0)
        change = {"r": -v, "V": arb(1 if kicks else 0)}.get(unknown, arb(0))
        return Answer(w, -p["r"], change)

    return impact


def _users(code: Any, params: dict[str, arb], unknown: str) -> Impact:
    from flint import arb

    kind = parameter_tuple(tuple(params))

    def derivative(v: Jet, by: str) -> Jet:
        p = kind(*(Jet(x, arb(1 if name == by else 0)) for name, x in params.items()))
        try:
            return Jet.of(code(v, p))
        except Rejected:
            raise
        except Exception as error:  # the law is not ours
            raise Rejected(f"the reset law cannot be evaluated in balls ({type(error).__name__}: {error})") from None

    def impact(v: arb) -> Answer:
        along, across = derivative(Jet(v, arb(1)), ""), derivative(Jet(v, arb(0)), unknown)
        demand(all(x.is_finite() for x in (along.x, along.d, across.d)), "the reset law is not finite over the box")
        return Answer(along.x, along.d, across.d)

    return impact
