"""The two-dimensional linearised map: linear in (x, y) but for a square root and a gap, the step before (2.6)."""

from __future__ import annotations

from math import sqrt
from typing import Any

from grazing.maps.gap import PARAMETERS as GAP
from grazing.maps.gap import border
from grazing.maps.map import Map
from grazing.maps.normal_form import NormalForm
from grazing.maps.origin import Formula
from grazing.outcome import AMBIGUOUS, OK, InputError, shown
from grazing.parameter import Parameter, real

PARAMETERS = {
    "lam": Parameter("lam", r"\lambda", "trace of the linear part"),
    "det": Parameter("det", r"\Delta", "determinant of the linear part, which the gap map neglects"),
    "mu": GAP["mu"],
    "l": GAP["l"],
    "root": Parameter("root", "s", "sign with which the root enters: 1 for b > 0, -1 for b < 0"),
}


def linearised_step(state: Any, p: Any) -> Any:
    """Apply the map once: letter 0 (L) for x < 0, 1 (R) for x >= 0; ambiguous at 0, where the flow has no impact."""
    x, y = state
    hit = p.root * sqrt(max(x, 0.0)) + p.l
    new = p.lam * x + y + p.mu - (0.0 if x < 0.0 else hit)
    return (new, -p.det * x), (0 if x < 0.0 else 1), (AMBIGUOUS if x == 0.0 else OK)


def linearised_tangent(state: Any, p: Any) -> Any:
    """Apply the map once with its Jacobian, row by row; infinite at x = 0."""
    new, letter, outcome = linearised_step(state, p)
    x = state[0]
    slope = p.lam if x < 0.0 else (p.lam - 0.5 * p.root / sqrt(x) if x > 0.0 else -p.root * float("inf"))
    return new, letter, outcome, (slope, 1.0, -p.det, 0.0)


def left(state: Any, p: Any) -> Any:
    """Apply the piece L, whatever the sign of x."""
    x, y = state
    return p.lam * x + y + p.mu, -p.det * x


def right(state: Any, p: Any, root: Any) -> Any:
    """Apply the piece R, whatever the sign of the root of x."""
    x, y = state
    return p.lam * x + y + p.mu - (p.root * root + p.l), -p.det * x


def linearised_map(lam: float, det: float, mu: float, l: float, root: float = 1.0) -> Map:
    """Return the two-dimensional map in (x, y) from which the gap map (2.6) is obtained, in the units of the gap map.

    x' = lam x + y + mu, y' = -det x; for x >= 0 less sqrt(x) + l in x. The gap map drops y, and lam x for x >= 0.

    Parameters
    ----------
    lam : float
        Trace of the linear part, of either sign.
    det : float
        Its determinant, exp(-alpha T) for the oscillator.
    mu : float
        Distance from the graze, which is at 0.
    l : float
        Size of the gap; negative where b < 0.
    root : {1, -1}
        Sign of b: with b < 0 the root is added, outside (2.6).

    Returns
    -------
    Map
        State (x, y), letters L (x < 0) and R (x >= 0), with tangent.

    Raises
    ------
    InputError
        For a root that is neither 1 nor -1.

    References
    ----------
    Pring and Budd, IMA J. Appl. Math. 76 (2011) 67-84, section 2.2: the map in (x, y) before (2.6). Divided by
    the scale (2Ab(1+r))^2 of :func:`grazing.normal_form` its coefficients are those of (2.6).

    Examples
    --------
    >>> import grazing as gz
    >>> from grazing.maps.linearised import linearised_map
    >>> Q, G = linearised_map(lam=0.8, det=0.0, mu=0.5, l=1.0), gz.gap_map(lam=0.8, mu=0.5, l=1.0)
    >>> float(Q((-1.0, 0.0))[0][0]), float(G((-1.0,))[0][0])
    (-0.30000000000000004, -0.30000000000000004)
    """
    if real(root, "root", "allowed are 1 and -1") not in (1.0, -1.0):
        raise InputError(f"root = {shown(root)}; allowed are 1 (b > 0, the root is taken off) and -1 (b < 0)")
    return Map(
        linearised_step,
        params={"lam": lam, "det": det, "mu": mu, "l": l, "root": float(root)},
        coordinates=("x", "y"),
        box=((-1.0, 1.0), (-1.0, 1.0)),
        letters="LR",
        tangent=linearised_tangent,
        name="linearised map",
        origin=Formula(linearised_map, PARAMETERS),
        pieces={"L": left, "R": right},
        border=border,
    )


def linearised_of(form: NormalForm, value: float | None = None) -> Map:
    """Return the linearised map of a model near its graze.

    Parameters
    ----------
    form : NormalForm
        From :func:`grazing.normal_form`.
    value : float, optional
        Of its parameter; default: the graze.

    Returns
    -------
    Map
        Its point (x, y) is that of :meth:`NormalForm.to_xy`, divided by ``form.scale``.

    Examples
    --------
    >>> import grazing as gz
    >>> from grazing.maps.linearised import linearised_of
    >>> nf = gz.normal_form(gz.pinball(V=0.4), "d")
    >>> linearised_of(nf, 0.12).orbit((-0.5, 0.0), 300).letters[-6:].tolist()
    [0, 0, 1, 0, 0, 1]
    """
    mu = float(form.mu(form.graze if value is None else value))
    return linearised_map(form.lam, form.det, mu, form.l, 1.0 if form.b > 0.0 else -1.0)
