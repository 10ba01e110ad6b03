"""Edges of the maximal orbit L^(N-1) R of the gap map in mu: graze, period doubling, border collision.

The gap map (2.6) is ``x -> lam x + mu`` for x < 0 and ``x -> mu - l - sqrt(x)`` for x >= 0. With
``K_N = 1 + lam + ... + lam^(N-1)``, ``c = lam^(N-1)`` and ``C = K_N mu - c l`` the point ``x_N = s^2`` of the
maximal orbit solves ``s^2 + c s = C``; every edge below is a value of C or of s.
"""

from __future__ import annotations

from typing import Any, overload

import numpy as np

from grazing.theory._inputs import FloatArray, Periods, Values, elements, plain

__all__ = ["geometric_sum", "mu_bc", "mu_gr", "mu_pd"]


@overload
def geometric_sum(N: int, lam: float) -> float: ...  # type: ignore[overload-overlap]
@overload
def geometric_sum(N: Periods, lam: Values) -> FloatArray: ...
def geometric_sum(N: Periods, lam: Values) -> float | FloatArray:
    """Sum of the first N powers of lam, ``K_N = (1 - lam^N)/(1 - lam)``.

    Parameters
    ----------
    N : int or array_like of int
        Number of terms, N >= 1.
    lam : float or array_like of float
        Slope of the gap map for x < 0, 0 < lam < 1.

    Returns
    -------
    float or ndarray
        K_N, to a few units in the last place also for lam near 0 and near 1.

    Raises
    ------
    InputError
        If an argument lies outside its range.

    Examples
    --------
    >>> from grazing import theory
    >>> theory.geometric_sum(3, 0.5)
    1.75
    """
    n, a = elements(N=N, lam=lam)
    return plain(powers_sum(n, a))


@overload
def mu_gr(N: int, lam: float, l: float) -> float: ...  # type: ignore[overload-overlap]
@overload
def mu_gr(N: Periods, lam: Values, l: Values) -> FloatArray: ...
def mu_gr(N: Periods, lam: Values, l: Values) -> float | FloatArray:
    """Value of mu at which the maximal orbit of period N grazes, x_N = 0: it exists only above.

    Parameters
    ----------
    N : int or array_like of int
        Period, N >= 1.
    lam : float or array_like of float
        Slope of the gap map for x < 0, 0 < lam < 1.
    l : float or array_like of float
        Gap, l >= 0.

    Returns
    -------
    float or ndarray
        ``lam^(N-1) l / K_N``.

    Raises
    ------
    InputError
        If an argument lies outside its range.

    Notes
    -----
    From the quadratic for sqrt(x_N) in the proof of Proposition 3.1 of Pring & Budd: its root is positive
    if and only if C > 0. There the multiplier of the orbit is minus infinity.

    Examples
    --------
    >>> from grazing import theory
    >>> theory.mu_gr(2, 0.5, 3.0)
    1.0
    """
    n, a, gap = elements(N=N, lam=lam, l=l)
    return plain(graze_edge(np.power(a, n - 1), powers_sum(n, a), gap))


@overload
def mu_pd(N: int, lam: float, l: float) -> float: ...  # type: ignore[overload-overlap]
@overload
def mu_pd(N: Periods, lam: Values, l: Values) -> FloatArray: ...
def mu_pd(N: Periods, lam: Values, l: Values) -> float | FloatArray:
    """Value of mu at which the maximal orbit of period N doubles its period: multiplier -1.

    Parameters
    ----------
    N : int or array_like of int
        Period, N >= 1.
    lam : float or array_like of float
        Slope of the gap map for x < 0, 0 < lam < 1.
    l : float or array_like of float
        Gap, l >= 0.

    Returns
    -------
    float or ndarray
        ``(lam^(N-1) l + (3/4) lam^(2(N-1))) / K_N``; for N = 1 this is ``l + 3/4``.

    Raises
    ------
    InputError
        If an argument lies outside its range.

    Notes
    -----
    Pring & Budd, Proposition 3.1. The orbit is stable above; the doubling is subcritical (see
    :func:`doubled_orbit`). The value is a bifurcation only where it lies below :func:`mu_bc`.

    Examples
    --------
    >>> from grazing import theory
    >>> round(theory.mu_pd(3, 0.9, 0.0), 6)
    0.181577
    >>> theory.mu_pd([1, 2], 0.5, 0.25).round(6).tolist()
    [1.0, 0.208333]
    """
    n, a, gap = elements(N=N, lam=lam, l=l)
    return plain(doubling_edge(np.power(a, n - 1), powers_sum(n, a), gap))


@overload
def mu_bc(N: int, lam: float, l: float) -> float: ...  # type: ignore[overload-overlap]
@overload
def mu_bc(N: Periods, lam: Values, l: Values) -> FloatArray: ...
def mu_bc(N: Periods, lam: Values, l: Values) -> float | FloatArray:
    """Value of mu at which the maximal orbit of period N collides with the border, x_(N-1) = 0.

    Parameters
    ----------
    N : int or array_like of int
        Period, N >= 1.
    lam : float or array_like of float
        Slope of the gap map for x < 0, 0 < lam < 1.
    l : float or array_like of float
        Gap, l >= 0.

    Returns
    -------
    float or ndarray
        The square of the positive root m of ``K_(N-1) m^2 - lam^(N-2) m - lam^(N-2) l = 0``. Infinite for
        N = 1, whose orbit has no point left of the border.

    Raises
    ------
    InputError
        If an argument lies outside its range.

    Notes
    -----
    Pring & Budd, Proposition 3.1, whose printed formula divides by zero for N = 1. The iterate that meets the
    border is the greatest negative one; the first lines of the proof call it the positive one.

    Examples
    --------
    >>> from grazing import theory
    >>> round(theory.mu_bc(3, 0.9, 0.0), 6)
    0.224377
    >>> theory.mu_bc(1, 0.5, 0.1)
    inf
    """
    n, a, gap = elements(N=N, lam=lam, l=l)
    before = np.maximum(n, 2.0) - 1  # N = 1 is replaced below
    edge = collision_edge(np.power(a, before - 1), powers_sum(before, a), gap)
    return plain(np.where(n == 1, np.inf, edge))


def graze_edge(c: Any, k: Any, l: Any) -> Any:
    """Return mu_gr from c = lam^(N-1) and K_N; for arrays and, as a kernel, for single numbers."""
    return c * l / k


def doubling_edge(c: Any, k: Any, l: Any) -> Any:
    """Return mu_pd from c = lam^(N-1) and K_N; for arrays and, as a kernel, for single numbers."""
    return c * (l + 0.75 * c) / k


def collision_edge(q: Any, k: Any, l: Any) -> Any:
    """Return mu_bc from q = lam^(N-2) and K_(N-1), N > 1; for arrays and, as a kernel, for single numbers."""
    m = (q + np.sqrt(q) * np.sqrt(q + 4 * l * k)) / (2 * k)
    return m * m


def powers_sum(n: FloatArray, lam: FloatArray) -> FloatArray:
    """K_n for arrays already checked; exactly 1 for n = 1."""
    # expm1 of n log(lam) loses nothing: for a negative argument its relative condition is at most 1.
    return np.where(n == 1, 1.0, -np.expm1(n * np.log(lam)) / (1 - lam))


def sum_minus_3(n: FloatArray, lam: FloatArray) -> FloatArray:
    """K_n - 3, whose sign says whether n has a window at l = 0, without cancellation near lam = 2/3."""
    far = lam - 2 * (1 - lam) - np.power(lam, n)  # each difference is exact near lam = 2/3
    return np.where(lam < 0.75, far / (1 - lam), powers_sum(n, lam) - 3)


def triple_sum_minus_4(n: FloatArray, lam: FloatArray) -> FloatArray:
    """3 K_n - 4, whose sign says whether n and n + 1 overlap at l = 0; no cancellation near lam = 1/4."""
    far = (4 * lam - 1) - 3 * np.power(lam, n)
    return np.where(lam < 0.5, far / (1 - lam), 3 * powers_sum(n, lam) - 4)
