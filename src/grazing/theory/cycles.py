"""Escape rates from periodic orbits: the spectral determinant of a hyperbolic flow, expanded over its cycles.

What stays of many balls after a time t falls as exp(-gamma t). The rate gamma is the least real zero s of

    F(s) = exp(- sum over p and r >= 1 of  exp(s r T_p) / (r |det(1 - J_p^r)|) ),

p being the cycles, the orbits gone round once, T_p their times and J_p their derivatives across themselves and across a
conserved energy. Ordered by the number of impacts, with a factor z^(r n_p), the series of F in z is cut off behind the
longest cycles that are known, and z put to 1 (Cvitanovic and Eckhardt). Its terms fall faster than any exponential if
all words occur, and the cut costs about as much as the last term did.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from decimal import Decimal, localcontext
from itertools import pairwise
from math import isfinite
from typing import Any, NamedTuple

from grazing.outcome import InputError, shown

#: Digits of the arithmetic beyond those of the numbers given, and of doubles.
SPARE, DOUBLE = 10, 17
#: Newton steps for a zero; first step of the search for one, in units of a mean time, and how many.
STEPS, FIRST, SCANS = 60, 0.05, 400
#: By what share a zero may be above the rate of the slowest cycle: that of a cut series is off by as much as it is cut.
ABOVE = Decimal("0.01")


class Cycle(NamedTuple):
    """A cycle as the expansion needs it; a :class:`grazing.BounceOrbit` serves as well.

    Parameters
    ----------
    period : int
        Number of impacts, >= 1.
    time : float or Decimal
        How long one turn takes, > 0.
    transverse : tuple of float, complex or Decimal
        The multipliers, without those that are 1 for the direction of the flow and for a conserved quantity.
    """

    period: int
    time: Any
    transverse: tuple[Any, ...]


@dataclass(frozen=True)
class CycleExpansion:
    """An escape rate from cycles, cut off at each length.

    Parameters
    ----------
    estimates : tuple of Decimal or None
        The rate from all cycles of up to 1, 2, ... impacts; None where the cut series has no zero.
    cycles : int
        How many cycles were used.
    per : {"time", "impact"}
    """

    estimates: tuple[Decimal | None, ...]
    cycles: int
    per: str

    @property
    def value(self) -> Decimal:
        """The rate from all cycles, with all its digits."""
        last = self.estimates[-1]
        assert last is not None
        return last

    @property
    def escape_rate(self) -> float:
        """The rate from all cycles."""
        return float(self.value)

    @property
    def error(self) -> float:
        """The greater of the last two changes: what longer cycles change is less, once these fall; infinity for none.

        Two, since one is small by chance where they are of changing signs.
        """
        last = self.estimates[-3:]
        known = [one for one in last if one is not None]
        if len(known) < 3:
            return float("inf")
        return float(max(abs(b - a) for a, b in pairwise(known)))

    def __repr__(self) -> str:
        rate = f"{self.value:.12g} +- {self.error:.1e} {'an' if self.per == 'impact' else 'a'} {self.per}"
        return f"<CycleExpansion: {rate}, {self.cycles} cycles to length {len(self.estimates)}>"


def cycle_expansion(
    cycles: Iterable[Any], *, per: str = "time", contracting: bool = True, digits: int = DOUBLE
) -> CycleExpansion:
    """Return the escape rate of an open hyperbolic system from its cycles, with what each length adds.

    Parameters
    ----------
    cycles : iterable of Cycle or BounceOrbit
        All cycles up to a number of impacts, each once: ``gz.periodic_orbits(P, range(1, n + 1))`` of the collision
        map of a table, or :func:`three_disc_cycles`. One that is left out makes the result wrong. Of such a search the
        series goes as far as it looked, also where nothing was found.
    per : {"time", "impact"}
        Whether the rate is one in time or counts impacts.
    contracting : bool
        Whether multipliers inside the unit circle count, too. The rate is the same without them: what they add are
        other zeros. With them F has no singularity, and its terms fall faster than any exponential in the end; where
        something contracts slowly, as the speed between active bumpers does, that takes longer words than without them.
    digits : int
        Of the arithmetic; more are of use with cycles that have as many.

    Returns
    -------
    CycleExpansion
        Its ``estimates`` show how the series converges.

    Raises
    ------
    InputError
        For no cycles, anything that is none, a virtual orbit, and a series without a zero.

    References
    ----------
    P. Cvitanovic and B. Eckhardt, Phys. Rev. Lett. 63 (1989) 823-826 and J. Phys. A 24 (1991) L237-L241; P. Cvitanovic
    et al., Chaos: Classical and Quantum, chapters 22 and 23.

    Examples
    --------
    >>> import grazing as gz
    >>> gz.theory.cycle_expansion(gz.theory.three_disc_cycles(6.0, 5, digits=20))
    <CycleExpansion: 0.410338407770 +- 2.7e-07 a time, 14 cycles to length 5>
    """
    if not isinstance(per, str) or per not in ("time", "impact"):
        raise InputError(f"per is {shown(per)}; allowed are 'time' and 'impact'")
    if not isinstance(contracting, bool):
        raise InputError(f"contracting is {shown(contracting)}; give True or False")
    if isinstance(digits, bool) or not isinstance(digits, int) or not 5 <= digits <= 1000:
        raise InputError(f"digits is {shown(digits)}; allowed is a whole number from 5 to 1000")
    try:
        each = iter(cycles)
    except TypeError:
        raise InputError(f"cycles are {shown(cycles)}; give a list of Cycle(period, time, transverse)") from None
    every = list(each)  # what making them raises is not blamed on the list
    searched = getattr(cycles, "searched", None)  # of gz.periodic_orbits
    given = [_checked(one, contracting) for one in every]
    if not given:
        raise InputError(
            "there are no cycles: nothing stays, or what stays slows down for ever, as between discs with r < 1 that "
            "do not kick; gz.escape_rate(P) counts what stays"
        )
    with localcontext() as context:
        context.prec = digits + SPARE
        series = _Series(given, per, 0 if searched is None else max(searched.periods))
        estimates, near = [], None
        for N in range(1, series.longest + 1):
            found = series.zero(N, near, Decimal(10) ** -(digits + SPARE // 2))
            near = found if found is not None else near
            estimates.append(found)
        if estimates[-1] is None:
            raise InputError(
                f"the series over cycles to length {series.longest} has no zero: some are missing, or longer ones count"
                + (", as they do less with contracting=False" if contracting else "")
            )
        context.prec = digits
        return CycleExpansion(tuple(None if one is None else +one for one in estimates), len(given), per)


def _checked(one: Any, contracting: bool) -> Cycle:
    """Return a cycle, with its contracting multipliers or without, or raise InputError."""
    try:
        n, T, roots = one.period, one.time, tuple(one.transverse)
    except (AttributeError, TypeError):
        raise InputError(
            f"a cycle is {shown(one)}; give Cycle(period, time, transverse), or orbits of a table"
        ) from None
    if getattr(one, "admissible", True) is False:
        raise InputError(f"a cycle is virtual, which no ball follows: {shown(one)}; leave those away")
    if isinstance(n, bool) or not isinstance(n, int) or n < 1:
        raise InputError(f"the period of a cycle is {shown(n)}; allowed is a whole number >= 1")
    if not (isinstance(T, Decimal) or isfinite(float(T))) or not T > 0:
        raise InputError(f"the time of a cycle is {shown(T)}; allowed is a number > 0")
    if not all(isinstance(root, Decimal) or isfinite(abs(complex(root))) for root in roots):
        raise InputError(f"the multipliers of a cycle are {shown(roots)}; give finite numbers")
    kept = roots if contracting else tuple(root for root in roots if abs(root) > 1)
    return Cycle(n, T if isinstance(T, Decimal) else Decimal(float(T)), kept)


def expanding(roots: Sequence[Any]) -> Decimal:
    """Return the logarithm of the product of the multipliers outside the unit circle."""
    sizes = (abs(root) for root in roots)
    return sum((Decimal(size).ln() for size in sizes if size > 1), Decimal(0))


def stays(roots: Sequence[Any], r: int) -> Decimal:
    """Return 1/|det(1 - J^r)| of a derivative with these eigenvalues."""
    if all(isinstance(root, Decimal) or complex(root).imag == 0.0 for root in roots):
        found = Decimal(1)
        for root in roots:
            found *= 1 - (root if isinstance(root, Decimal) else Decimal(complex(root).real)) ** r
        size = abs(found)
    else:
        product, far = complex(1.0), False
        for root in roots:
            try:
                product *= 1.0 - complex(root) ** r
            except OverflowError:
                far = True
        if far or not isfinite(abs(product)):
            raise InputError(f"the multipliers of a cycle are {shown(roots)}: their powers are no doubles")
        size = Decimal(abs(product))
    if size == 0:
        raise InputError("a multiplier of a cycle is 1: it is not hyperbolic, and has no weight")
    return 1 / size


class _Series:
    """The cycles with the weights of their repeats, for the coefficients of log F and of F in z."""

    def __init__(self, cycles: Sequence[Cycle], per: str, least: int) -> None:
        self.longest = max(least, *(one.period for one in cycles))
        self.cycles = [
            (
                one.period, one.time if per == "time" else Decimal(one.period),
                [stays(one.transverse, r) for r in range(1, self.longest // one.period + 1)],
            )
            for one in cycles
        ]  # fmt: skip
        # while a ball stays near one cycle it escapes as that says: no rate is greater than the least of these
        slowest = [
            (n, max(-weights[0].ln(), expanding(one.transverse)) / T)
            for one, (n, T, weights) in zip(cycles, self.cycles, strict=True)
        ]
        self.most = [min((rate for n, rate in slowest if n <= N), default=Decimal(0)) for N in range(self.longest + 1)]
        self.mean = sum((T for _n, T, _w in self.cycles), Decimal(0)) / sum(n for n, _T, _w in self.cycles)

    def at(self, s: Decimal, N: int) -> tuple[Decimal, Decimal]:
        """Return F and dF/ds of the series cut off behind z^N."""
        c, d = [Decimal(0)] * (N + 1), [Decimal(0)] * (N + 1)
        for n, T, weights in self.cycles:
            if n > N:
                continue
            once = (s * T).exp()
            grown = Decimal(1)
            for r in range(1, N // n + 1):
                grown *= once
                term = grown * weights[r - 1]
                c[n * r] -= term / r
                d[n * r] -= term * T
        a, b = [Decimal(1)] + [Decimal(0)] * N, [Decimal(0)] * (N + 1)
        for m in range(1, N + 1):
            for k in range(1, m + 1):
                a[m] += k * c[k] * a[m - k] / m
                b[m] += k * (d[k] * a[m - k] + c[k] * b[m - k]) / m
        return sum(a, Decimal(0)), sum(b, Decimal(0))

    def zero(self, N: int, near: Decimal | None, small: Decimal) -> Decimal | None:
        """Return the least zero s of the cut series, near one that is known or looked for; None for none."""
        most = self.most[N] * (1 + ABOVE) + ABOVE / self.mean
        for begin in (near, None):
            s = self.crossing(N, most) if begin is None else begin
            found = None if s is None else self.newton(N, s, small)
            if found is not None and found <= most:
                return found
        return None

    def newton(self, N: int, s: Decimal, small: Decimal) -> Decimal | None:
        """Return the zero near s, None where Newton's method leads away."""
        far = 10 * Decimal(FIRST) / self.mean
        for _ in range(STEPS):
            F, slope = self.at(s, N)
            if slope == 0 or abs(F) > far * abs(slope):
                return None
            s -= F / slope
            if abs(F / slope) <= small * (1 + abs(s)):
                return s
        return None

    def crossing(self, N: int, most: Decimal) -> Decimal | None:
        """Return about where F first falls below 0, from where it is nearly 1 as all terms are small, or None."""
        step = Decimal(FIRST) / self.mean
        s = Decimal(0)
        for _ in range(SCANS):
            if self.at(s, N)[0] > Decimal("0.5"):
                break
            s -= 10 * step
        before = self.at(s, N)[0]
        step = max(step, (most - s) / (SCANS - 2))
        for _ in range(SCANS):
            after = self.at(s + step, N)[0]
            if before > 0 >= after:
                return s + step * before / (before - after)
            s, before = s + step, after
        return None
