"""Sign windows of the forcing: all simple zeros of a trigonometric polynomial over a period, none missed.

The search marches with steps that a bound on the second derivative proves either free of zeros or monotone
(then one sign test finds the only zero). Where neither holds for a step of 1e-7 of a period, a pair of zeros may hide.
A flight does not feel it: between them the polynomial is below 1e-12 of its size. A ball that lies on the wall does: it
is released or not. So windows beside such a step, or before a zero that is badly known, are marked as doubtful.
"""

from __future__ import annotations

from math import sqrt

from grazing.kernel.elementary import length, sincos
from grazing.kernel.primitives import replaced


def series(
    t: float, F0: float, cos: tuple[float, ...], sin: tuple[float, ...], omega: float, theta: float
) -> tuple[float, float]:
    """Return F0 + sum_j cos_j cos(j phi) + sin_j sin(j phi), phi = omega t + theta, and its derivative in t."""
    s1, c1 = sincos(omega * t + theta)
    return summed(F0, cos, sin, omega, s1, c1)


def summed(
    F0: float, cos: tuple[float, ...], sin: tuple[float, ...], omega: float, s1: float, c1: float
) -> tuple[float, float]:
    """Return :func:`series` where the phase has sine s1 and cosine c1."""
    F, dF = F0, 0.0
    sj, cj = s1, c1
    for j in range(len(cos)):
        F += cos[j] * cj + sin[j] * sj
        dF += (j + 1) * omega * (sin[j] * cj - cos[j] * sj)
        sj, cj = sj * c1 + cj * s1, cj * c1 - sj * s1
    return F, dF


def starts_at_zero(F0: float, cos: tuple[float, ...], theta: float) -> bool:
    """Return whether the series is 0 at t = 0, exactly: its phase is 0 and its cosines add up to 0 without rounding."""
    total, lost = F0, 0.0
    for j in range(len(cos)):
        new = total + cos[j]
        seen = new - total
        lost += abs((total - (new - seen)) + (cos[j] - seen))
        total = new
    return theta == 0.0 and total == 0.0 and lost == 0.0


def free_distance(F: float, dF: float, bend: float) -> float:
    """Return how far F keeps its sign for certain, given |F''| <= bend."""
    towards = max(0.0, -dF if F > 0.0 else dF)
    square = towards * towards + 2.0 * bend * abs(F)
    root = sqrt(square) if 1e-280 < square < 1e300 else length(towards, sqrt(2.0 * bend) * sqrt(abs(F)))
    return 2.0 * abs(F) / (root + towards) if root > 0.0 else 0.0


def simple_zero(
    lo: float,
    hi: float,
    f_lo: float,
    F0: float,
    cos: tuple[float, ...],
    sin: tuple[float, ...],
    omega: float,
    theta: float,
) -> float:
    """Return the zero in [lo, hi] where F changes sign once, by Newton's method kept inside the bracket."""
    t, small = 0.5 * (lo + hi), 1e-12 / omega
    for _ in range(80):
        F, dF = series(t, F0, cos, sin, omega, theta)
        if (F > 0.0) == (f_lo > 0.0):
            lo = t
        else:
            hi = t
        new = t - F / dF if dF != 0.0 else lo
        if abs(new - t) <= small:  # convergence is quadratic: what is left is rounding
            return min(max(new, lo), hi)
        if not lo < new < hi:
            new = 0.5 * (lo + hi)
        if hi - lo <= small * 1e-4:
            return new
        t = new
    return t


def window_edges(
    F0: float,
    cos: tuple[float, ...],
    sin: tuple[float, ...],
    omega: float,
    theta: float,
    T: float,
    bend: float,
    no_edges: tuple[float, ...],
    lost: float = 0.0,
) -> tuple[tuple[float, ...], float, tuple[float, ...]]:
    """Return the edges of the sign windows of F in [0, T], the sign in the first one, and which are doubtful.

    Parameters
    ----------
    F0, cos, sin, omega, theta
        The polynomial, see :func:`series`.
    T : float
        Period 2 pi/omega.
    bend : float
        Bound on the second derivative.
    no_edges : tuple of float
        Zeros, as long as the result: 2 * harmonics + 2.
    lost : float
        How wrong F0 may be.

    Returns
    -------
    edges : tuple of float
        0, the zeros in increasing order, then T repeated. Signs alternate from window to window.
    first : float
        +1, -1, or 0 for F = 0 throughout.
    doubtful : tuple of float
        For each window 1 where a pair of zeros may hide in it or beside it, or where one of its ends is known to
        worse than 1e-12 T. Else 0.
    """
    edges, doubtful = no_edges, no_edges
    for i in range(1, len(no_edges)):
        edges = replaced(edges, i, T)
    smallest = 1e-7 * T
    floor = abs(F0)  # below 1e-15 of this a sign means nothing: the last one that did is kept
    for j in range(len(cos)):
        floor += (abs(cos[j]) + abs(sin[j])) * (j + 1)
    floor *= 1e-15
    blur = floor + lost
    t, count, first = 0.0, 0, 0.0
    F, dF = series(t, F0, cos, sin, omega, theta)
    sign = 1.0 if F > floor else (-1.0 if F < -floor else 0.0)
    decided, F_decided = t, F
    while t < T:
        free = free_distance(F, dF, bend)
        monotone = 0.9 * abs(dF) / bend if bend > 0.0 else T
        end = min(T, t + max(0.9 * free, monotone, smallest))
        proven = monotone >= max(0.9 * free, smallest) or (0.9 * free >= smallest and abs(F) > 10.0 * blur)
        new, dnew = series(end, F0, cos, sin, omega, theta)
        new_sign = 1.0 if new > floor else (-1.0 if new < -floor else sign)
        if sign != 0.0 and new_sign != sign and count < len(no_edges) - 2:
            zero = simple_zero(decided, end, F_decided, F0, cos, sin, omega, theta)
            if 0.0 < zero < T:
                count += 1
                edges = replaced(edges, count, zero)
                if count == 1:
                    first = sign
                _F, slope = series(zero, F0, cos, sin, omega, theta)
                if not proven or blur > 1e-12 * T * abs(slope):
                    doubtful = replaced(doubtful, count - 1, 1.0)
                    doubtful = replaced(doubtful, count, 1.0)
            else:  # F(0) or F(T) itself is the zero: it separates nothing inside the period
                sign = new_sign
        sign = new_sign
        if not proven:
            doubtful = replaced(doubtful, count, 1.0)
        if abs(new) > floor:
            decided, F_decided = end, new
        t, F, dF = end, new, dnew
    # a zero at T: before or after it?
    if abs(F) <= blur + 4e-16 * T * abs(dF) and (lost > 0.0 or not starts_at_zero(F0, cos, theta)):
        doubtful = replaced(doubtful, count, 1.0)
    return edges, (first if count > 0 else sign), doubtful
