"""The balls of grazing_checker once more, as intervals of mpmath: what balls.py takes from python-flint.

An interval [a, b] has its ends as binary fractions, rounded down and up. Its middle is any number near, and its radius
reaches from there to both ends. Nothing of FLINT is used.
"""

import importlib
import sys
from math import isfinite
from types import ModuleType

from mpmath.libmp import (
    from_float,
    from_int,
    from_man_exp,
    fzero,
    mpf_add,
    mpf_gt,
    mpf_le,
    mpf_lt,
    mpf_neg,
    mpf_shift,
    mpf_sub,
    round_ceiling,
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


class Context:
    """The working precision."""

    prec = 53


ctx = Context()


class arb:
    """An interval that surely holds the number that is meant; its ends are None if nothing is known of it."""

    __hash__ = None
    __slots__ = ("ends",)

    def __init__(self, middle=0, radius=None):
        if isinstance(middle, arb):
            self.ends = middle.ends
        elif isinstance(middle, tuple):
            self.ends = (from_man_exp(*(int(one) for one in middle)),) * 2
        elif isinstance(middle, int):
            self.ends = (from_int(middle),) * 2
        elif isinstance(middle, float) and isfinite(middle):
            self.ends = (from_float(middle),) * 2
        else:
            raise TypeError(f"no interval can be made of {middle!r}")
        if radius is not None:
            reach = abs(arb(radius)).ends[1]
            self.ends = mpi_add(self.ends, (mpf_neg(reach), reach), ctx.prec)

    @classmethod
    def of(cls, ends):
        made = cls.__new__(cls)
        made.ends = ends
        return made

    @classmethod
    def pi(cls):
        return cls.of(mpi_pi(ctx.prec))

    def _with(self, other, operation, turned=False):
        if not isinstance(other, (arb, int, float)):
            return NotImplemented
        one, two = self.ends, (other if type(other) is arb else arb(other)).ends
        if one is None or two is None:
            return arb.of(None)
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

    def _of(self, function, *arguments):
        return arb.of(None if self.ends is None else function(self.ends, *arguments, ctx.prec))

    def __neg__(self):
        return self._of(mpi_neg)

    def __pos__(self):
        return self

    def __abs__(self):
        return self._of(mpi_abs)

    def __pow__(self, exponent):
        if not isinstance(exponent, int) or exponent < 0:
            raise TypeError(f"the exponent {exponent!r} is no whole number >= 0")
        return self._of(mpi_pow_int, exponent)

    # true only if it holds for all numbers of both

    def __lt__(self, other):
        if not isinstance(other, (arb, int, float)):
            return NotImplemented
        one, two = self.ends, arb(other).ends
        return one is not None and two is not None and mpf_lt(one[1], two[0])

    def __le__(self, other):
        if not isinstance(other, (arb, int, float)):
            return NotImplemented
        one, two = self.ends, arb(other).ends
        return one is not None and two is not None and mpf_le(one[1], two[0])

    def __gt__(self, other):
        return arb(other) < self if isinstance(other, (arb, int, float)) else NotImplemented

    def __ge__(self, other):
        return arb(other) <= self if isinstance(other, (arb, int, float)) else NotImplemented

    def __eq__(self, other):
        return self <= other and self >= other

    # functions

    def sqrt(self):
        return self._of(mpi_sqrt) if self >= 0 else arb.of(None)

    def exp(self):
        return self._of(mpi_exp)

    def log(self):
        return self._of(mpi_log) if self > 0 else arb.of(None)

    def sin_cos(self):
        if self.ends is None:
            return arb(0, 1), arb(0, 1)
        cosine, sine = mpi_cos_sin(self.ends, ctx.prec)
        return arb.of(sine), arb.of(cosine)

    # parts

    def is_finite(self):
        return self.ends is not None

    def is_zero(self):
        return self.ends == (fzero, fzero)

    def lower(self):
        return arb.of((self.ends[0],) * 2 if self.ends else None)

    def upper(self):
        return arb.of((self.ends[1],) * 2 if self.ends else None)

    def mid(self):
        """Return an exact number near the middle."""
        if self.ends is None:
            return arb(0)
        low, high = self.ends
        middle = low if low == high else mpf_shift(mpf_add(low, high, ctx.prec, round_nearest), -1)
        return arb.of((middle, middle))

    def rad(self):
        """Return an exact bound on how far all numbers are from ``mid``."""
        if self.ends is None:
            return self
        low, high = self.ends
        middle = self.mid().ends[0]
        below = mpf_sub(middle, low, ctx.prec, round_ceiling)
        above = mpf_sub(high, middle, ctx.prec, round_ceiling)
        reach = above if mpf_lt(below, above) else below
        return arb.of((reach, reach))

    def man_exp(self):
        if self.ends is None or self.ends[0] != self.ends[1]:
            raise ValueError("not exact")
        return to_man_exp(self.ends[0], signed=True)

    def __float__(self):
        return to_float(self.mid().ends[0]) if self.ends else float("nan")

    def __repr__(self):
        return f"[{to_float(self.ends[0])!r}, {to_float(self.ends[1])!r}]" if self.ends else "[unknown]"

    def str(self, *_digits, **_options):
        return repr(self)


class arb_poly:
    """A polynomial, by its coefficients."""

    def __init__(self, terms):
        self.terms = list(terms)

    def derivative(self):
        return arb_poly([n * term for n, term in enumerate(self.terms)][1:])

    def __call__(self, s):
        total = arb(0)
        for term in reversed(self.terms):
            total = total * s + term
        return total


def divided(one, two, prec):
    """Division, of which nothing is known where the divisor may be 0."""
    low, high = two
    return mpi_div(one, two, prec) if mpf_gt(low, fzero) or mpf_lt(high, fzero) else None


def checker_on_intervals():
    """Return a second grazing_checker.check that computes with these intervals and not with flint."""
    flint = ModuleType("flint")
    flint.arb, flint.arb_poly, flint.ctx = arb, arb_poly, ctx
    kept = forgotten()
    sys.modules["flint"] = flint
    try:
        check = importlib.import_module("grazing_checker.check")
        assert sys.modules["grazing_checker.balls"].Ball is arb
    finally:
        forgotten()
        sys.modules.update(kept)
    return check


def forgotten():
    """Take flint and the checker out of what is imported, and return it."""
    names = [name for name in sys.modules if name.split(".")[0] in ("flint", "grazing_checker")]
    return {name: sys.modules.pop(name) for name in names}
