"""The gap map without a gap, l = 0: the three regimes in lam, and what they say at finite N.

At l = 0 the window of N is not empty iff ``K_N < 3``, and the windows of N and N + 1 overlap iff
``(3/4) K_N < 1``. As N grows K_N tends to ``1/(1-lam)``: hence 2/3 and 1/4.
"""

from __future__ import annotations

import math
from enum import Enum

from grazing.outcome import OutsideForm, shown
from grazing.theory._inputs import elements, number, period
from grazing.theory.edges import mu_pd, sum_minus_3
from grazing.theory.interval import Interval

__all__ = ["Regime", "lam_exist", "lam_overlap", "last_window", "regime", "robust_chaos"]


class Regime(Enum):
    """What the windows of the maximal orbits do as mu falls to 0 at l = 0, in words."""

    overlapping = "every two neighbouring windows overlap"
    separated = "every N has a window; from some N on, neighbouring windows are apart"
    chaotic = "only finitely many N have a window; below the last of them no maximal orbit is stable"


def regime(lam: float) -> Regime:
    """Regime of the gap map at l = 0 as mu falls to 0.

    Parameters
    ----------
    lam : float
        Slope of the gap map for x < 0, 0 < lam < 1.

    Returns
    -------
    Regime
        ``overlapping`` for lam <= 1/4, ``separated`` for 1/4 < lam <= 2/3, ``chaotic`` for lam > 2/3.

    Raises
    ------
    InputError
        If lam lies outside its range.

    Notes
    -----
    Pring & Budd, after Proposition 3.1, leave the two bounds open; at either of them K_N stays
    below its limit, so the bound belongs to the regime on its left. For 1/4 < lam < 2/3 they say that windows
    do not intersect: this fails for small N, see :func:`lam_overlap`.

    Examples
    --------
    >>> from grazing import theory
    >>> [theory.regime(lam).name for lam in (0.25, 0.5, 0.9)]
    ['overlapping', 'separated', 'chaotic']
    """
    a = number("lam", lam)
    if a <= 0.25:
        return Regime.overlapping
    return Regime.separated if _beyond(a) <= 0 else Regime.chaotic


def lam_overlap(N: int) -> float:
    """Value of lam below which the windows of N and N + 1 overlap at l = 0.

    Parameters
    ----------
    N : int
        The smaller of the two periods, N >= 1.

    Returns
    -------
    float
        The root of ``(3/4) K_N = 1``: 1/3 for N = 2, 0.26376 for N = 3, falling to 1/4. For N = 1 it is 1:
        these windows overlap for every lam.

    Raises
    ------
    InputError
        If N is not an integer >= 1.

    Examples
    --------
    >>> from grazing import theory
    >>> [round(theory.lam_overlap(N), 5) for N in (1, 2, 3, 30)]
    [1.0, 0.33333, 0.26376, 0.25]
    """
    return _root_of_sum(period(N), 1 / 3)


def lam_exist(N: int) -> float:
    """Value of lam below which the maximal orbit of period N has a window at l = 0.

    Parameters
    ----------
    N : int
        Period, N >= 1.

    Returns
    -------
    float
        The root of ``K_N = 3``, falling to 2/3 as N grows. For N <= 3 it is 1: windows for every lam.

    Raises
    ------
    InputError
        If N is not an integer >= 1.

    Examples
    --------
    >>> from grazing import theory
    >>> [round(theory.lam_exist(N), 5) for N in (3, 4, 5, 60)]
    [1.0, 0.81054, 0.74127, 0.66667]
    """
    return _root_of_sum(period(N), 2.0)


def last_window(lam: float) -> int:
    """Largest period N whose maximal orbit has a window at l = 0.

    Parameters
    ----------
    lam : float
        Slope of the gap map for x < 0, 2/3 < lam < 1.

    Returns
    -------
    int
        The largest N with ``K_N < 3``, at least 3.

    Raises
    ------
    InputError
        If lam lies outside its range.
    OutsideForm
        If lam <= 2/3, where every N has a window.

    Notes
    -----
    Proposition 3.2 (i) of Pring & Budd, made quantitative.

    Examples
    --------
    >>> from grazing import theory
    >>> theory.last_window(0.9), theory.last_window(0.7)
    (3, 6)
    """
    a = number("lam", lam)
    if _beyond(a) <= 0:
        raise OutsideForm(f"no last window at lam = {shown(a)}: for lam <= 2/3 every N has a window at l = 0")
    N = max(3, math.floor(math.log(_beyond(a)) / math.log(a)))  # K_N < 3 iff lam^N > 3 lam - 2
    while _has_window(N + 1, a):
        N += 1
    while N > 3 and not _has_window(N, a):
        N -= 1
    return N


def robust_chaos(lam: float) -> Interval:
    """Interval of mu above 0, at l = 0, in which no maximal orbit is stable.

    Parameters
    ----------
    lam : float
        Slope of the gap map for x < 0, 0 < lam < 1.

    Returns
    -------
    Interval
        From 0 to ``mu_pd(N, lam, 0)`` of the last period N that has a window; the interval is the largest
        of its kind. Empty for lam <= 2/3: then windows accumulate at mu = 0.

    Raises
    ------
    InputError
        If lam lies outside its range.

    Notes
    -----
    Pring & Budd, after Proposition 3.1: a continuous jump to robust chaos for lam > 2/3, quoted there for small
    mu. In the whole interval no periodic orbit attracts: a block L^(n-1) R takes ``s = sqrt(x)`` to ``s'^2 = C - c
    s`` and stretches the weighted length ``sqrt(s) ds`` by ``c/(2 sqrt(s s')) >= (3 c^2/(4 C))^(3/4)``, because ``s'
    (C - s'^2) <= 2 (C/3)^(3/2)``. This exceeds 1 for ``mu < mu_pd(n, lam, 0)``, and a block with an empty window does
    not occur for greater mu. The same holds between any two windows, for every l >= 0.

    Examples
    --------
    >>> from grazing import theory
    >>> round(theory.robust_chaos(0.9).high, 6)
    0.181577
    >>> theory.robust_chaos(0.5).empty
    True
    """
    a = number("lam", lam)
    return Interval(0.0, mu_pd(last_window(a), a, 0.0) if _beyond(a) > 0 else 0.0)


def _beyond(lam: float) -> float:
    """Return 3 lam - 2, exact near lam = 2/3."""
    return lam - 2 * (1 - lam)


def _has_window(N: int, lam: float) -> bool:
    return float(sum_minus_3(*elements(N=N, lam=lam))) < 0


def _root_of_sum(N: int, total: float) -> float:
    """Solve lam + ... + lam^(N-1) = total for lam in (0, 1); 1 where no lam < 1 reaches the total."""
    if N - 1 <= total:
        return 1.0
    # (1 + t) x - x^N - t is concave and negative at t/(1 + t): Newton's steps rise to the smaller root.
    x, step = total / (1 + total), 1.0
    while step > 0:
        step = (x**N - (1 + total) * x + total) / (1 + total - N * x ** (N - 1))
        step = step if x + step > x else 0.0
        x += step
    return x
