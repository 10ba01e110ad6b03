"""The gap map (2.6): linear on one side, a square root on the other, and a gap of size l between them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import sqrt
from typing import Any

from grazing.maps.map import Map
from grazing.maps.origin import Formula
from grazing.outcome import AMBIGUOUS, OK
from grazing.parameter import Parameter
from grazing.theory import WordOrbit, word_orbits

PARAMETERS = {
    parameter.name: parameter
    for parameter in (
        Parameter("lam", r"\lambda", "slope of the map for x < 0"),
        Parameter("mu", r"\mu", "distance from the graze, which is at 0"),
        Parameter("l", "l", "size of the gap, in proportion to the bumper's V"),
    )
}


def gap_step(state: Any, p: Any) -> Any:
    """Apply (2.6) once: letter 0 (L) for x < 0, 1 (R) for x >= 0; ambiguous at 0, where the flow has none."""
    (x,) = state
    left = p.lam * x + p.mu
    right = p.mu - p.l - sqrt(max(x, 0.0))
    return (left if x < 0.0 else right,), (0 if x < 0.0 else 1), (AMBIGUOUS if x == 0.0 else OK)


def gap_tangent(state: Any, p: Any) -> Any:
    """Apply (2.6) once with its slope; infinite at x = 0."""
    (x,) = state
    new, letter, outcome = gap_step(state, p)
    slope = p.lam if x < 0.0 else (-0.5 / sqrt(x) if x > 0.0 else -float("inf"))
    return new, letter, outcome, (slope,)


def left(state: Any, p: Any) -> Any:
    """Apply the piece L of (2.6), whatever the sign of x."""
    return (p.lam * state[0] + p.mu,)


def right(_state: Any, p: Any, root: Any) -> Any:
    """Apply the piece R of (2.6): x is the square of the root, which is negative on virtual orbits."""
    return (p.mu - p.l - root,)


def border(state: Any, _p: Any) -> Any:
    """Return the distance from the graze."""
    return state[0]


#: The pieces of every gap map: :func:`gap_step` takes both at once, which is faster.
PIECES: dict[str, Any] = {"pieces": {"L": left, "R": right}, "border": border}


class Words(Formula):
    """The origin of a gap map: its orbits are solved word by word."""

    finder = "grazing.orbits.gap_orbits:Words"
    prover = "grazing.proof.gap:certify_gap_orbit"
    certified_as = "grazing.proof.same_model:of_gap_map"

    def orbits(self, word: str, params: Mapping[str, float]) -> Sequence[WordOrbit]:
        """Return all orbits of a word, admissible or virtual."""
        return word_orbits(word, params["lam"], params["mu"], params["l"])


def gap_map(lam: float, mu: float, l: float) -> Map:
    """Return the piecewise linear/square-root map with a gap, equation (2.6).

    Parameters
    ----------
    lam : float
        Slope λ for x < 0.
    mu : float
        Distance μ from the graze; μ = 0 is the graze.
    l : float
        Size of the gap, proportional to the bumper's V; 0 for a passive wall.

    Returns
    -------
    Map
        State (x,), letters L (x < 0) and R (x >= 0).

    References
    ----------
    Pring and Budd, IMA J. Appl. Math. 76 (2011) 67-84, equation (2.6).

    Examples
    --------
    >>> import grazing as gz
    >>> G = gz.gap_map(lam=0.8, mu=0.5, l=1.0)
    >>> G((-1.0,))
    (array([-0.3]), 0)
    >>> G.orbit((-1.0,), 3).letters.tolist()
    [0, 0, 1]
    """
    return Map(
        gap_step,
        params={"lam": lam, "mu": mu, "l": l},
        coordinates=("x",),
        box=((-1.0, 1.0),),
        letters="LR",
        tangent=gap_tangent,
        name="gap map",
        origin=Words(gap_map, PARAMETERS),
        **PIECES,
    )
