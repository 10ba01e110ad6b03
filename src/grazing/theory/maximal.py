"""The maximal orbit L^(N-1) R of the gap map: its points and its multiplier."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from grazing.outcome import OutsideForm, shown
from grazing.theory._inputs import FloatArray, number, period
from grazing.theory.edges import geometric_sum, mu_bc, mu_gr

__all__ = ["maximal_orbit", "multiplier"]


class Block(NamedTuple):
    """One pass L^(N-1) R of the gap map, from one point s^2 >= 0 to the next: ``s'^2 = C - c s``."""

    N: int
    lam: float
    mu: float
    l: float
    c: float
    C: float


def block(N: object, lam: object, mu: object, l: object) -> Block:
    """Check the parameters and form c = lam^(N-1) and C = K_N mu - c l."""
    n, a, offset, gap = period(N), number("lam", lam), number("mu", mu), number("l", l)
    c = float(np.power(a, n - 1.0))
    return Block(n, a, offset, gap, c, geometric_sum(n, a) * offset - c * gap)


def climb(b: Block, before: float, after: float) -> FloatArray:
    """Points x_1 < ... < x_N of the climb through x < 0 from one positive point to the next, given by their roots."""
    # Forwards x_j = K_j mu - lam^(j-1) (l + before), backwards x_(N-k) = -(K_k mu - after^2)/lam^k: each point by
    # the one that cancels less. Backwards x_(N-1) < 0 exactly when x_N < mu, which near the border has to hold.
    square = after * after
    if b.N == 1:
        return np.array([square])
    j = np.arange(1, b.N)
    rise, shrunk = geometric_sum(j, b.lam) * b.mu, np.power(b.lam, b.N - j)
    forwards = rise - np.power(b.lam, j - 1.0) * (b.l + before)
    with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
        lost = square / shrunk
        backwards = -(geometric_sum(b.N - j, b.lam) * b.mu - square) / shrunk
    return np.append(np.where((lost < rise) | (forwards >= 0.0), backwards, forwards), square)


def maximal_orbit(N: int, lam: float, mu: float, l: float) -> FloatArray:
    """Points of the maximal orbit L^(N-1) R, from its least point to its only one right of the border.

    Parameters
    ----------
    N : int
        Period, N >= 1.
    lam : float
        Slope of the gap map for x < 0, 0 < lam < 1.
    mu : float
        Offset; the orbit exists for ``mu_gr < mu < mu_bc``.
    l : float
        Gap, l >= 0.

    Returns
    -------
    ndarray, shape (N,)
        ``x_1 < ... < x_(N-1) < 0 < x_N``, stable or not.

    Raises
    ------
    InputError
        If an argument lies outside its range.
    OutsideForm
        If the orbit does not exist at this mu; the message names the condition that fails.

    Notes
    -----
    Pring & Budd, proof of Proposition 3.1: ``sqrt(x_N)`` is the positive root of ``s^2 + c s - C
    = 0``. The closing condition is ``x_1 = -sqrt(x_N) + mu - l``; before Fig. 3.2 the root is printed over mu
    - l as well.

    Examples
    --------
    >>> from grazing import theory
    >>> theory.maximal_orbit(3, 0.8, 0.5, 1.0).round(10).tolist()
    [-1.0060750571, -0.3048600457, 0.2561119634]
    """
    b = block(N, lam, mu, l)
    s = _root(b)
    return climb(b, s, s)


def multiplier(N: int, lam: float, mu: float, l: float) -> float:
    """Multiplier of the maximal orbit of period N, the slope of the N-th iterate along it.

    Parameters
    ----------
    N : int
        Period, N >= 1.
    lam : float
        Slope of the gap map for x < 0, 0 < lam < 1.
    mu : float
        Offset; the orbit exists for ``mu_gr < mu < mu_bc``.
    l : float
        Gap, l >= 0.

    Returns
    -------
    float
        ``-lam^(N-1)/(2 sqrt(x_N))``, never positive; the orbit is stable where it exceeds -1.

    Raises
    ------
    InputError
        If an argument lies outside its range.
    OutsideForm
        If the orbit does not exist at this mu; the message names the condition that fails.

    Notes
    -----
    Pring & Budd, proof of Proposition 3.1.

    Examples
    --------
    >>> from grazing import theory
    >>> round(theory.multiplier(3, 0.8, 0.5, 1.0), 6)
    -0.632317
    """
    b = block(N, lam, mu, l)
    return -b.c / (2 * _root(b))


def _root(b: Block) -> float:
    """Return sqrt(x_N), or say why there is no orbit."""
    if b.C <= 0:
        edge = mu_gr(b.N, b.lam, b.l)
        raise OutsideForm(f"{_none(b)}: x_N > 0 fails; it needs mu > mu_gr = {shown(edge)}")
    s = 2 * b.C / (b.c + math.sqrt(b.c**2 + 4 * b.C))
    if b.N > 1 and s * s >= b.mu:
        edge = mu_bc(b.N, b.lam, b.l)
        raise OutsideForm(f"{_none(b)}: x_(N-1) < 0 fails; it needs mu < mu_bc = {shown(edge)}")
    return s


def _none(b: Block) -> str:
    return f"no maximal orbit of period N = {b.N} at lam = {shown(b.lam)}, mu = {shown(b.mu)}, l = {shown(b.l)}"
