"""Windows of large period: leading order as N grows, Proposition 3.2."""

from __future__ import annotations

from typing import overload

import numpy as np

from grazing.outcome import OutsideForm, shown
from grazing.theory._inputs import FloatArray, Periods, Values, elements, plain
from grazing.theory.windows import window

__all__ = ["mu_bc_leading", "mu_pd_leading", "width_ratio"]


@overload
def mu_pd_leading(N: int, lam: float, l: float) -> float: ...  # type: ignore[overload-overlap]
@overload
def mu_pd_leading(N: Periods, lam: Values, l: Values) -> FloatArray: ...
def mu_pd_leading(N: Periods, lam: Values, l: Values) -> float | FloatArray:
    """Leading order of :func:`mu_pd` as N grows.

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
        ``(1-lam) lam^(N-1) l`` for l > 0, ``(3/4)(1-lam) lam^(2N-2)`` for l = 0. The relative remainder is
        of order lam^N in both cases; for l > 0 its coefficient is ``1 + 3/(4 l lam)``.

    Raises
    ------
    InputError
        If an argument lies outside its range.

    Notes
    -----
    Pring & Budd, proof of Proposition 3.2.

    Examples
    --------
    >>> from grazing import theory
    >>> theory.mu_pd_leading(3, 0.5, 1.0), theory.mu_pd_leading(3, 0.5, 0.0)
    (0.125, 0.0234375)
    """
    n, a, gap = elements(N=N, lam=lam, l=l)
    c = np.power(a, n - 1)
    return plain((1 - a) * c * np.where(gap > 0, gap, 0.75 * c))


@overload
def mu_bc_leading(N: int, lam: float, l: float) -> float: ...  # type: ignore[overload-overlap]
@overload
def mu_bc_leading(N: Periods, lam: Values, l: Values) -> FloatArray: ...
def mu_bc_leading(N: Periods, lam: Values, l: Values) -> float | FloatArray:
    """Leading order of :func:`mu_bc` as N grows.

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
        ``(1-lam) lam^(N-2) l`` for l > 0, with a relative remainder ``sqrt((1-lam)/l) lam^((N-2)/2)`` to
        lowest order; ``(1-lam)^2 lam^(2N-4)`` for l = 0, with the remainder ``2 lam^(N-1)``. Meaningless at N
        = 1.

    Raises
    ------
    InputError
        If an argument lies outside its range.

    Notes
    -----
    Pring & Budd, proof of Proposition 3.2. The remainder for l > 0 falls only as the square root
    of lam^N: this is why the windows of Fig. 3.7 approach their limit slowly, and why neighbours overlap in
    the end although ``mu_bc(N+1)`` and ``mu_pd(N)`` agree to leading order (3.1): the remainder is positive.

    Examples
    --------
    >>> from grazing import theory
    >>> theory.mu_bc_leading(3, 0.5, 1.0), theory.mu_bc_leading(3, 0.5, 0.0)
    (0.25, 0.0625)
    """
    n, a, gap = elements(N=N, lam=lam, l=l)
    q = np.power(a, n - 2)
    return plain((1 - a) * q * np.where(gap > 0, gap, (1 - a) * q))


def width_ratio(N: int, lam: float, l: float) -> float:
    """Width of the window of N + 1 divided by the width of the window of N.

    Parameters
    ----------
    N : int
        Period, N >= 2.
    lam : float
        Slope of the gap map for x < 0, 0 < lam < 1.
    l : float
        Gap, l >= 0.

    Returns
    -------
    float
        The ratio. As N grows it tends to lam for l > 0, with a remainder of order lam^(N/2), and to lam^2 for
        l = 0 and lam < 2/3.

    Raises
    ------
    InputError
        If an argument lies outside its range.
    OutsideForm
        If one of the two windows is empty or, for N = 1, infinitely wide.

    Notes
    -----
    Pring & Budd, Proposition 3.2 and Fig. 3.7.

    Examples
    --------
    >>> from grazing import theory
    >>> round(theory.width_ratio(200, 0.9, 0.8), 3)
    0.9
    """
    here, following = window(N, lam, l), window(N + 1, lam, l)
    for w in (here, following):
        if w.stability.empty or w.N == 1:
            reason = "infinitely wide" if w.N == 1 else "empty"
            raise OutsideForm(
                f"no width ratio at lam = {shown(lam)}, l = {shown(l)}: the window of N = {w.N} is {reason}"
            )
    return following.stability.width / here.stability.width
