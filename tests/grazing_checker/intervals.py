"""The balls of grazing_checker once more, as intervals of mpmath: what balls.py takes from python-flint.

An interval [a, b] has its ends as binary fractions, rounded down and up. Its middle is any number near, and its radius
reaches from there to both ends. Nothing of FLINT is used.
"""

import importlib
import sys
from contextlib import contextmanager
from types import ModuleType

from mpmath.libmp import (
    from_float,
    from_int,
    from_man_exp,
    fzero,
    mpf_add,
    mpf_cmp,
    mpf_gt,
    mpf_le,
    mpf_lt,
    mpf_sub,
    round_ceiling,
    round_floor,
    round_nearest,
    to_float,
    to_man_exp,
)
from mpmath.libmp.libmpi import (
    mpi_abs,
    mpi_add,
    mpi_cos_sin,
    mpi_div,
    mpi_exp,
    mpi_log,
    mpi_mul,
    mpi_neg,
    mpi_pi,
    mpi_pow_int,
    mpi_sqrt,
    mpi_sub,
)

EVERYTHING = (from_float(float("-inf")), from_float(float("inf")))


class Context:
    """The working precision."""

    prec = 53


ctx = Context()


def finite(ends):
    return all(one == fzero or one[1] for one in ends)


class arb:
    """An interval that surely holds the number that is meant."""

    __hash__ = None

    def __init__(self, middle=0, radius=None):
        if isinstance(middle, arb):
            self.ends = middle.ends
        elif isinstance(middle, tuple):
            self.ends = (from_man_exp(*(int(one) for one in middle)),) * 2
        elif isinstance(middle, int):
            self.ends = (from_int(middle),) * 2
        elif isinstance(middle, float):
            self.ends = (from_float(middle),) * 2
        else:
            raise TypeError(f"no interval can be made of {middle!r}")
        if radius is not None:
            reach = abs(arb(radius)).ends[1]
            low, high = self.ends
            self.ends = (
                mpf_sub(low, reach, ctx.prec, round_floor),
                mpf_add(high, reach, ctx.prec, round_ceiling),
            )

    @classmethod
    def of(cls, ends):
        made = cls.__new__(cls)
        made.ends = ends if finite(ends) else EVERYTHING
        return made

    @classmethod
    def pi(cls):
        return cls.of(mpi_pi(ctx.prec))

    def _with(self, other, operation, turned=False):
        if not isinstance(other, (arb, int, float)):
            return NotImplemented
        one, two = self.ends, arb(other).ends
        if not (finite(one) and finite(two)):
            return arb.of(EVERYTHING)
        return arb.of(operation(two, one, ctx.prec) if turned else operation(one, two, ctx.prec))

    def __add__(self, other):
        return self._with(other, mpi_add)

    def __sub__(self, other):
        return self._with(other, mpi_sub)

    def __mul__(self, other):
        return self._with(other, mpi_mul)

    def __truediv__(self, other):
        return self._with(other, divided)

    __radd__, __rmul__ = __add__, __mul__

    def __rsub__(self, other):
        return self._with(other, mpi_sub, turned=True)

    def __rtruediv__(self, other):
        return self._with(other, divided, turned=True)

    def __neg__(self):
        return arb.of(mpi_neg(self.ends))

    def __pos__(self):
        return self

    def __abs__(self):
        return arb.of(mpi_abs(self.ends, ctx.prec)) if finite(self.ends) else self

    def __pow__(self, exponent):
        if not isinstance(exponent, int):
            raise TypeError(f"the exponent {exponent!r} is not whole")
        return arb.of(mpi_pow_int(self.ends, exponent, ctx.prec)) if finite(self.ends) else self

    # true only if it holds for all numbers of both

    def __lt__(self, other):
        return self._known(other) and mpf_lt(self.ends[1], arb(other).ends[0])

    def __le__(self, other):
        return self._known(other) and mpf_le(self.ends[1], arb(other).ends[0])

    def __gt__(self, other):
        return arb(other) < self

    def __ge__(self, other):
        return arb(other) <= self

    def __eq__(self, other):
        return self <= other and self >= other

    def _known(self, other):
        return finite(self.ends) and finite(arb(other).ends)

    # functions

    def sqrt(self):
        known = finite(self.ends) and not mpf_lt(self.ends[0], fzero)
        return arb.of(mpi_sqrt(self.ends, ctx.prec) if known else EVERYTHING)

    def exp(self):
        return arb.of(mpi_exp(self.ends, ctx.prec) if finite(self.ends) else EVERYTHING)

    def log(self):
        known = finite(self.ends) and mpf_gt(self.ends[0], fzero)
        return arb.of(mpi_log(self.ends, ctx.prec) if known else EVERYTHING)

    def sin_cos(self):
        if not finite(self.ends):
            return arb(0, 1), arb(0, 1)
        cosine, sine = mpi_cos_sin(self.ends, ctx.prec)
        return arb.of(sine), arb.of(cosine)

    def gamma(self):
        """Return (n - 1)! of an exact whole number."""
        low, high = self.ends
        n = round(to_float(low))
        if low != high or from_int(n) != low or not 0 < n < 10**5:
            raise ValueError("gamma of whole numbers only")
        result = arb(1)
        for i in range(2, n):
            result *= i
        return result

    # parts

    def is_finite(self):
        return finite(self.ends)

    def is_zero(self):
        return self.ends == (fzero, fzero)

    def lower(self):
        return arb.of((self.ends[0],) * 2)

    def upper(self):
        return arb.of((self.ends[1],) * 2)

    def mid(self):
        low, high = self.ends
        if not finite(self.ends):
            return arb(0)
        if low == high:
            return self
        total = mpf_add(low, high, ctx.prec, round_nearest)
        return arb.of(mpi_mul((total, total), arb(0.5).ends, ctx.prec + 8))

    def rad(self):
        low, high = self.ends
        if not finite(self.ends):
            return self
        middle = self.mid().ends[0]
        sides = [
            mpf_sub(middle, low, ctx.prec, round_ceiling),
            mpf_sub(high, middle, ctx.prec, round_ceiling),
        ]
        reach = max_of(sides)
        return arb.of((reach, reach))

    def man_exp(self):
        if self.ends[0] != self.ends[1]:
            raise ValueError("not exact")
        return to_man_exp(self.ends[0])

    def __float__(self):
        return to_float(self.mid().ends[0]) if finite(self.ends) else float("nan")

    def __repr__(self):
        return f"[{to_float(self.ends[0])!r}, {to_float(self.ends[1])!r}]"

    def str(self, *_digits, **_options):
        return repr(self)


def max_of(numbers):
    found = numbers[0]
    for one in numbers[1:]:
        if mpf_cmp(one, found) > 0:
            found = one
    return found


def divided(one, two, prec):
    """Division, of which nothing is known where the divisor may be 0."""
    low, high = two
    if mpf_gt(low, fzero) or mpf_lt(high, fzero):
        return mpi_div(one, two, prec)
    return EVERYTHING


@contextmanager
def checker_on_intervals():
    """Yield a fresh import of grazing_checker.check that computes with these intervals, not with flint."""
    flint = ModuleType("flint")
    flint.arb, flint.ctx = arb, ctx
    kept = {name: module for name, module in sys.modules.items() if name.split(".")[0] in ("flint", "grazing_checker")}
    for name in kept:
        del sys.modules[name]
    sys.modules["flint"] = flint
    try:
        check = importlib.import_module("grazing_checker.check")
        balls = importlib.import_module("grazing_checker.balls")
        assert balls.arb is arb
        yield check
    finally:
        for name in [name for name in sys.modules if name.split(".")[0] in ("flint", "grazing_checker")]:
            del sys.modules[name]
        sys.modules.update(kept)
