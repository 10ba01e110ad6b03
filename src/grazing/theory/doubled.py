"""The orbit of period 2N that the subcritical period doubling of a maximal orbit leaves behind, unstable.

Two passes of L^(N-1) R join the points s^2 and t^2 right of the border: ``t^2 = C - c s`` and ``s^2 = C - c
t``. Their difference is ``(s - t)(s + t - c) = 0``, hence ``s + t = c`` and ``s t = c^2 - C``: s and t are
``(c ± sqrt(4C - 3c^2))/2``. The product of slopes is ``c^2/(4 s t)``, above 1 wherever s and t differ.
"""

from __future__ import annotations

import math

import numpy as np

from grazing.outcome import OutsideForm, shown
from grazing.theory._inputs import FloatArray, number, period
from grazing.theory.edges import geometric_sum
from grazing.theory.interval import Interval
from grazing.theory.maximal import Block, block, climb
from grazing.theory.windows import stability_interval

__all__ = ["doubled_interval", "doubled_multiplier", "doubled_orbit"]


def doubled_interval(N: int, lam: float, l: float) -> Interval:
    """Open interval of mu in which the doubled orbit (L^(N-1) R)^2 of period 2N exists.

    Parameters
    ----------
    N : int
        Period of the maximal orbit, N >= 1.
    lam : float
        Slope of the gap map for x < 0, 0 < lam < 1.
    l : float
        Gap, l >= 0.

    Returns
    -------
    Interval
        From :func:`mu_pd` to the first of two ends: the graze of the smaller positive point, C = c^2, or the
        border collision of the greatest negative one, ``max(s, t)^2 = mu``. Graze comes first if and only
        if ``l > c (K_N - 1)``, and always for N = 1. Empty if and only if the window of N is empty.

    Raises
    ------
    InputError
        If an argument lies outside its range.

    Notes
    -----
    The interval is a part of the window of N: there the doubled orbit bounds the basin of the maximal one.
    At the border collision ``(K_N - 1) mu + c sqrt(mu) = c (c + l)``, which gives the second end.

    Examples
    --------
    >>> from grazing import theory
    >>> theory.doubled_interval(1, 0.5, 0.25)
    Interval(low=1.0, high=1.25, closed=False)
    """
    n, a, gap = period(N), number("lam", lam), number("l", l)
    window = stability_interval(n, a, gap)
    if window.empty:
        return window
    c, k = float(np.power(a, n - 1.0)), geometric_sum(n, a)
    if n == 1 or gap > c * (k - 1):
        return Interval(window.low, c * (gap + c) / k)
    root = 2 * (c + gap) / (1 + math.sqrt(1 + 4 * (k - 1) * (1 + gap / c)))
    return Interval(window.low, root**2)


def doubled_orbit(N: int, lam: float, mu: float, l: float) -> FloatArray:
    """Points of the unstable doubled orbit (L^(N-1) R)^2, in the order of iteration from its least point.

    Parameters
    ----------
    N : int
        Period of the maximal orbit, N >= 1.
    lam : float
        Slope of the gap map for x < 0, 0 < lam < 1.
    mu : float
        Offset, inside :func:`doubled_interval`.
    l : float
        Gap, l >= 0.

    Returns
    -------
    ndarray, shape (2 N,)
        Positive at positions N - 1 (the smaller) and 2 N - 1 (the greater), negative elsewhere.

    Raises
    ------
    InputError
        If an argument lies outside its range.
    OutsideForm
        If the orbit does not exist at this mu; the message names the condition that fails.

    Examples
    --------
    >>> from grazing import theory
    >>> theory.doubled_orbit(1, 0.5, 1.125, 0.25).round(6).tolist()
    [0.021447, 0.728553]
    """
    b = block(N, lam, mu, l)
    small, great = _roots(b)
    return np.concatenate([climb(b, great, small), climb(b, small, great)])


def doubled_multiplier(N: int, lam: float, mu: float, l: float) -> float:
    """Multiplier of the doubled orbit, the slope of the 2N-th iterate along it.

    Parameters
    ----------
    N : int
        Period of the maximal orbit, N >= 1.
    lam : float
        Slope of the gap map for x < 0, 0 < lam < 1.
    mu : float
        Offset, inside :func:`doubled_interval`.
    l : float
        Gap, l >= 0.

    Returns
    -------
    float
        ``c^2/(4 (c^2 - C))``, above 1: the orbit is never stable.

    Raises
    ------
    InputError
        If an argument lies outside its range.
    OutsideForm
        If the orbit does not exist at this mu; the message names the condition that fails.

    Examples
    --------
    >>> from grazing import theory
    >>> theory.doubled_multiplier(1, 0.5, 1.125, 0.25)
    2.0
    """
    b = block(N, lam, mu, l)
    _roots(b)
    return b.c**2 / (4 * (b.c**2 - b.C))


def _roots(b: Block) -> tuple[float, float]:
    """Return the smaller and the greater root of the positive points, or say why there is no orbit."""
    low, high = doubled_interval(b.N, b.lam, b.l)
    if low >= high:
        raise OutsideForm(
            f"no doubled orbit at N = {b.N}, lam = {shown(b.lam)}, l = {shown(b.l)}: the window of N is empty"
        )
    none = f"no doubled orbit of period 2N = {2 * b.N} at lam = {shown(b.lam)}, mu = {shown(b.mu)}, l = {shown(b.l)}"
    if 4 * b.C <= 3 * b.c**2:
        raise OutsideForm(f"{none}: two different positive points need mu > mu_pd = {shown(low)}")
    if b.C >= b.c**2:
        raise OutsideForm(f"{none}: its smaller positive point needs mu below its graze, {shown(high)}")
    great = (b.c + math.sqrt(4 * b.C - 3 * b.c**2)) / 2
    if b.N > 1 and great**2 >= b.mu:
        raise OutsideForm(f"{none}: its greatest negative point needs mu below its border collision, {shown(high)}")
    return (b.c**2 - b.C) / great, great
