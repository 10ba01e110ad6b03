"""The interval that traps every orbit of the gap map for mu >= 0."""

from __future__ import annotations

import math

from grazing.outcome import OutsideForm, shown
from grazing.theory._inputs import number
from grazing.theory.interval import Interval

__all__ = ["trapping_interval"]


def trapping_interval(mu: float, l: float) -> Interval:
    """Trapping interval of the gap map: it is taken into itself, for every lam in (0, 1).

    Parameters
    ----------
    mu : float
        Offset, mu >= 0.
    l : float
        Gap, l >= 0.

    Returns
    -------
    Interval
        From ``mu - l - sqrt(mu)`` to ``mu``, closed. The lower end is the image of the upper one.

    Raises
    ------
    InputError
        If an argument lies outside its range.
    OutsideForm
        If mu < 0, where every orbit tends to the fixed point ``mu/(1 - lam)``.

    Notes
    -----
    Pring & Budd, after Proposition 3.1. No further condition is needed for it to be trapping.
    *Invariant*: a point x < 0 goes to ``lam x + mu``, above x and below mu; a point x >= 0 of it goes to ``mu
    - l - sqrt(x)``, between the two ends as x <= mu. *Absorbing*: every orbit enters after finitely many
    steps, because the climb through x < 0 ends in [0, mu), and from there at most one step leads in; at mu =
    0 < l the climb passes -l. The one exception is mu = l = 0, where the interval is the point 0 and orbits
    only tend to it.

    It is not the attractor. At mu = 0 < l, where the paper calls [-l, 0] the attractor, every orbit climbs
    towards 0 from below and its limit set is {0}, which is not a fixed point. For mu > 0 the interval reaches
    across the border if and only if ``mu < mu_bc(2, lam, l) = ((1 + sqrt(1 + 4 l))/2)^2``; from there on it
    lies in x >= 0, where the gap plays no part, and all orbits tend to the fixed point of period 1.

    Examples
    --------
    >>> from grazing import theory
    >>> theory.trapping_interval(0.25, 0.5)
    Interval(low=-0.75, high=0.25, closed=True)
    """
    offset, gap = number("mu", mu), number("l", l)
    if offset < 0:
        raise OutsideForm(
            f"no trapping interval at mu = {shown(offset)}; it needs mu >= 0: "
            "for mu < 0 every orbit tends to the fixed point mu/(1 - lam)"
        )
    return Interval(offset - gap - math.sqrt(offset), offset, closed=True)
