"""Windows of mu in which the maximal orbit L^(N-1) R exists, is stable, and meets its neighbour."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from grazing.outcome import InputError
from grazing.theory._inputs import Periods, elements, number, period
from grazing.theory.edges import mu_bc, mu_gr, mu_pd, triple_sum_minus_4
from grazing.theory.interval import Interval

__all__ = ["Window", "existence_interval", "overlapping", "stability_interval", "window", "windows_overlap"]

#: The most windows that are held against each other at once.
MOST_PERIODS = 10**6


@dataclass(frozen=True)
class Window:
    """The three edges in mu of the maximal orbit of one period.

    Parameters
    ----------
    N : int
        Period.
    mu_gr, mu_pd, mu_bc : float
        Graze, period doubling and border collision of the orbit.
    """

    N: int
    mu_gr: float
    mu_pd: float
    mu_bc: float

    @property
    def existence(self) -> Interval:
        """Open interval of mu in which the orbit exists; never empty."""
        return Interval(self.mu_gr, self.mu_bc)

    @property
    def stability(self) -> Interval:
        """Open interval of mu in which the orbit exists and is stable; may be empty."""
        return Interval(self.mu_pd, self.mu_bc)


def window(N: int, lam: float, l: float) -> Window:
    """Edges of the maximal orbit of period N, with its intervals of existence and of stability.

    Parameters
    ----------
    N : int
        Period, N >= 1.
    lam : float
        Slope of the gap map for x < 0, 0 < lam < 1.
    l : float
        Gap, l >= 0.

    Returns
    -------
    Window
        With `existence` and `stability` as intervals; `stability` is the window Omega_N.

    Raises
    ------
    InputError
        If an argument lies outside its range.

    Notes
    -----
    Pring & Budd, Proposition 3.1, where Omega_N is printed closed and said to be where the orbit
    "exists". It is open, since the multiplier is -1 at one end and the orbit is gone at the other, and the
    orbit exists, unstable, also between graze and period doubling.

    Examples
    --------
    >>> from grazing import theory
    >>> w = theory.window(3, 0.8, 1.0)
    >>> 0.5 in w.stability, 0.3 in w.stability, 0.3 in w.existence
    (True, False, True)
    """
    n, a, gap = period(N), number("lam", lam), number("l", l)
    return Window(n, mu_gr(n, a, gap), mu_pd(n, a, gap), mu_bc(n, a, gap))


def existence_interval(N: int, lam: float, l: float) -> Interval:
    """Open interval of mu in which the maximal orbit of period N exists.

    Parameters
    ----------
    N : int
        Period, N >= 1.
    lam : float
        Slope of the gap map for x < 0, 0 < lam < 1.
    l : float
        Gap, l >= 0.

    Returns
    -------
    Interval
        From :func:`mu_gr` to :func:`mu_bc`.

    Raises
    ------
    InputError
        If an argument lies outside its range.

    Examples
    --------
    >>> from grazing import theory
    >>> theory.existence_interval(2, 0.5, 0.0)
    Interval(low=0.0, high=1.0, closed=False)
    """
    return window(N, lam, l).existence


def stability_interval(N: int, lam: float, l: float) -> Interval:
    """Open interval of mu in which the maximal orbit of period N is stable, the window Omega_N.

    Parameters
    ----------
    N : int
        Period, N >= 1.
    lam : float
        Slope of the gap map for x < 0, 0 < lam < 1.
    l : float
        Gap, l >= 0.

    Returns
    -------
    Interval
        From :func:`mu_pd` to :func:`mu_bc`; empty for l <= :func:`l_exist`.

    Raises
    ------
    InputError
        If an argument lies outside its range.

    Examples
    --------
    >>> from grazing import theory
    >>> theory.stability_interval(2, 0.5, 0.0)
    Interval(low=0.125, high=1.0, closed=False)
    >>> theory.stability_interval(4, 0.9, 0.0).empty
    True
    """
    return window(N, lam, l).stability


def windows_overlap(N: int, lam: float, l: float) -> bool:
    """Tell whether the windows of periods N and N + 1 have a value of mu in common.

    Parameters
    ----------
    N : int
        The smaller of the two periods, N >= 1.
    lam : float
        Slope of the gap map for x < 0, 0 < lam < 1.
    l : float
        Gap, l >= 0.

    Returns
    -------
    bool
        True if and only if ``l > lam^(N-1) (9 K_N/16 - 3/4)``; at l = 0 this says ``(3/4) K_N < 1``.

    Raises
    ------
    InputError
        If an argument lies outside its range.

    Notes
    -----
    Both edges fall as N grows, so the windows meet if and only if ``mu_pd(N) < mu_bc(N+1)``, that
    is, ``C < c sqrt(mu)`` at the period doubling, where ``C = 3 c^2/4``. The windows of 1 and 2 always
    overlap. For l > 0 all windows of large enough N do: chaos between windows survives only at moderate N,
    while the discussion of Fig. 3.5 in Pring & Budd has it at small mu.

    Examples
    --------
    >>> from grazing import theory
    >>> theory.windows_overlap(3, 0.5, 0.058), theory.windows_overlap(3, 0.5, 0.059)
    (False, True)
    """
    return bool(_overlap(period(N), lam, l))


def overlapping(lam: float, l: float, N_max: int) -> npt.NDArray[np.int64]:
    """Periods N from 1 to N_max whose window overlaps the window of N + 1.

    Parameters
    ----------
    lam : float
        Slope of the gap map for x < 0, 0 < lam < 1.
    l : float
        Gap, l >= 0.
    N_max : int
        Largest N considered, 1 <= N_max <= 10^6.

    Returns
    -------
    ndarray of int
        The periods, ascending. What is missing is one run of consecutive N, endless only for l = 0.

    Raises
    ------
    InputError
        If an argument lies outside its range.

    Examples
    --------
    >>> from grazing import theory
    >>> theory.overlapping(0.9, 0.8, 18).tolist()
    [1, 2, 3, 16, 17, 18]
    """
    last = period(N_max)
    if last > MOST_PERIODS:
        raise InputError(f"N_max = {last}; allowed is at most {MOST_PERIODS}; windows_overlap tells of a larger one")
    periods = np.arange(1, last + 1)
    return periods[_overlap(periods, lam, l)]


def _overlap(N: Periods, lam: float, l: float) -> npt.NDArray[np.bool_]:
    """Return whether the windows of N and N + 1 overlap, for each N."""
    gap = number("l", l)
    n, a = elements(N=N, lam=number("lam", lam))
    bracket = 0.1875 * triple_sum_minus_4(n, a)
    return np.asarray((bracket < 0) | (gap > np.power(a, n - 1) * bracket))
