"""Sign windows of the forcing: all simple zeros of a trigonometric polynomial over a period, none missed.

The search marches with steps that a bound on the second derivative proves either free of zeros or monotone
(then one sign test finds the only zero). A double zero, or a pair closer than about 1e-7 of a period, is dropped:
between such a pair the polynomial is below 1e-14 of its size, far below what a flight can feel.
"""

from __future__ import annotations

from math import sqrt

from grazing.kernel.elementary import sincos
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


def free_distance(F: float, dF: float, bend: float) -> float:
    """Return how far F keeps its sign for certain, given |F''| <= bend."""
    towards = max(0.0, -dF if F > 0.0 else dF)
    root = sqrt(towards * towards + 2.0 * bend * abs(F))
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
) -> tuple[tuple[float, ...], float]:
    """Return the edges of the sign windows of F in [0, T] and the sign in the first one.

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

    Returns
    -------
    edges : tuple of float
        0, the zeros in increasing order, then T repeated. Signs alternate from window to window.
    first : float
        +1, -1, or 0 for F = 0 throughout.
    """
    edges = no_edges
    for i in range(1, len(no_edges)):
        edges = replaced(edges, i, T)
    smallest = 1e-7 * T
    floor = abs(F0)  # below 1e-15 of this a sign means nothing: the last one that did is kept
    for j in range(len(cos)):
        floor += (abs(cos[j]) + abs(sin[j])) * (j + 1)
    floor *= 1e-15
    t, count, first = 0.0, 0, 0.0
    F, dF = series(t, F0, cos, sin, omega, theta)
    sign = 1.0 if F > floor else (-1.0 if F < -floor else 0.0)
    decided, F_decided = t, F
    while t < T:
        free = free_distance(F, dF, bend)
        monotone = 0.9 * abs(dF) / bend if bend > 0.0 else T
        end = min(T, t + max(0.9 * free, monotone, smallest))
        new, dnew = series(end, F0, cos, sin, omega, theta)
        new_sign = 1.0 if new > floor else (-1.0 if new < -floor else sign)
        if sign != 0.0 and new_sign != sign and count < len(no_edges) - 2:
            zero = simple_zero(decided, end, F_decided, F0, cos, sin, omega, theta)
            if 0.0 < zero < T:
                count += 1
                edges = replaced(edges, count, zero)
                if count == 1:
                    first = sign
            else:  # F(0) or F(T) itself is the zero: it separates nothing inside the period
                sign = new_sign
        sign = new_sign
        if abs(new) > floor:
            decided, F_decided = end, new
        t, F, dF = end, new, dnew
    return edges, (first if count > 0 else sign)
