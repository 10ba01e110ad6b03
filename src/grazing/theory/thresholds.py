"""Gaps l at which windows of the maximal orbits appear and start to overlap."""

from __future__ import annotations

import math
from typing import NamedTuple, overload

import numpy as np

from grazing.theory._inputs import FloatArray, Periods, Values, elements, number, plain
from grazing.theory.edges import sum_minus_3, triple_sum_minus_4

__all__ = ["WorstWindow", "l_all", "l_coexist", "l_exist"]


class WorstWindow(NamedTuple):
    """The gap beyond which every period has a window, and the last period to get one."""

    l: float
    N: int | None


@overload
def l_exist(N: int, lam: float) -> float: ...  # type: ignore[overload-overlap]
@overload
def l_exist(N: Periods, lam: Values) -> FloatArray: ...
def l_exist(N: Periods, lam: Values) -> float | FloatArray:
    """Gap beyond which the maximal orbit of period N has a window: it is stable somewhere iff l > l_exist.

    Parameters
    ----------
    N : int or array_like of int
        Period, N >= 1.
    lam : float or array_like of float
        Slope of the gap map for x < 0, 0 < lam < 1.

    Returns
    -------
    float or ndarray
        ``lam^(N-1) (lam K_(N-1)/4 - 1/2)``; minus infinity for N = 1. A negative value means that the
        window is there for every l >= 0.

    Raises
    ------
    InputError
        If an argument lies outside its range.

    Notes
    -----
    From ``mu_pd < mu_bc`` of Proposition 3.1 of Pring & Budd: at the period doubling ``s = c/2``,
    and the orbit exists there if ``s^2 < mu``. For lam = 0.9 the period 5 has a window beyond 0.1796; the
    printed 0.19 is a reading of Fig. 3.6.

    Examples
    --------
    >>> from grazing import theory
    >>> theory.l_exist([4, 5], 0.9).round(10).tolist()
    [0.08000775, 0.1796237775]
    """
    n, a = elements(N=N, lam=lam)
    value = np.power(a, n - 1) * sum_minus_3(n, a) / 4  # lam K_(N-1) = K_N - 1
    return plain(np.where(n == 1, -np.inf, value))


@overload
def l_coexist(N: int, lam: float) -> float: ...  # type: ignore[overload-overlap]
@overload
def l_coexist(N: Periods, lam: Values) -> FloatArray: ...
def l_coexist(N: Periods, lam: Values) -> float | FloatArray:
    """Gap beyond which the windows of periods N and N + 1 overlap.

    Parameters
    ----------
    N : int or array_like of int
        The smaller of the two periods, N >= 1.
    lam : float or array_like of float
        Slope of the gap map for x < 0, 0 < lam < 1.

    Returns
    -------
    float or ndarray
        ``lam^(N-1) (9 K_N/16 - 3/4)``. A negative value means that they overlap for every l >= 0.

    Raises
    ------
    InputError
        If an argument lies outside its range.

    Notes
    -----
    From ``mu_pd(N) = mu_bc(N+1)``, Proposition 3.1 of Pring & Budd. For lam = 0.5 and N = 3 the text there
    reads 0.05 off Fig. 3.4.

    Examples
    --------
    >>> from grazing import theory
    >>> theory.l_coexist(3, 0.5)
    0.05859375
    >>> round(theory.l_coexist(3, 0.9), 10)
    0.62724375
    """
    n, a = elements(N=N, lam=lam)
    return plain(np.power(a, n - 1) * 0.1875 * triple_sum_minus_4(n, a))


def l_all(lam: float) -> WorstWindow:
    """Gap beyond which every period N has a window, with the period that is the last to get one.

    Parameters
    ----------
    lam : float
        Slope of the gap map for x < 0, 0 < lam < 1.

    Returns
    -------
    WorstWindow
        `l`, the maximum of :func:`l_exist` over N, and the `N` at which it is attained. For lam <= 2/3 every
        N has a window at every l >= 0, l = 0 included: `l` is 0 and `N` is None.

    Raises
    ------
    InputError
        If lam lies outside its range.

    Notes
    -----
    With ``p = lam^N`` the threshold is the parabola ``p ((1-p)/(1-lam) - 3)/(4 lam)``, greatest at
    ``p = (3 lam - 2)/2``, so that only the two integers beside that N compete.

    Examples
    --------
    >>> from grazing import theory
    >>> worst = theory.l_all(0.9)
    >>> round(worst.l, 6), worst.N
    (0.340273, 10)
    """
    a = number("lam", lam)
    beyond = a - 2 * (1 - a)  # 3 lam - 2, exact near 2/3
    if beyond <= 0:
        return WorstWindow(0.0, None)
    peak = math.log(beyond / 2) / math.log(a)
    candidates = (max(2, math.floor(peak)), max(2, math.ceil(peak)))
    best = max(candidates, key=lambda n: l_exist(n, a))
    return WorstWindow(l_exist(best, a), best)
