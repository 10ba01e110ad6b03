"""Proofs that the gap map has no attracting periodic orbit on an interval of mu.

Between two visits to x = s^2 >= 0 the gap map makes a block ``s'^2 = C - c s``. It stretches the weighted length
``sqrt(s) ds`` by ``c/(2 sqrt(s s')) >= (3 c^2/(4 C))^(3/4)``, since ``c s s' = s' (C - s'^2) <= 2 (C/3)^(3/2)``:
above 1 if and only if ``C < 3 c^2/4``, that is, below the period doubling of the maximal orbit of this block alone.
And the block does not occur at all beyond the border collision of that orbit. So an attracting periodic orbit needs
a mu in the window of a maximal orbit: between the windows every periodic orbit repels.
"""

from __future__ import annotations

from typing import Any

from grazing.outcome import InputError
from grazing.parameter import real
from grazing.proof.gap import NO_ATTRACTOR, GapProof, in_balls, sealed
from grazing.theory import geometric_sum, mu_bc, mu_pd, multiplier
from grazing_checker.gap import BLOCKS


def prove_no_attractor(lam: float, l: float, low: float, high: float) -> GapProof:
    """Prove that no periodic orbit of the gap map attracts, for every mu > 0 in [low, high].

    Parameters
    ----------
    lam : float
        Slope of the gap map for x < 0, 0 < lam < 1.
    l : float
        Gap, l >= 0.
    low, high : float
        The interval of mu, 0 <= low < high. It can begin at 0 for l = 0 and lam > 2/3 only.

    Returns
    -------
    GapProof
        Proven, or with the attracting orbit or the rounding that is in the way.

    Raises
    ------
    InputError
        For a number out of range.

    Notes
    -----
    The proof holds for intervals between the windows of :func:`grazing.theory.window`, up to the
    rounding of their edges, and fails for all others. With l = 0 and lam > 2/3 it covers
    :func:`grazing.theory.robust_chaos`, where Pring and Budd quote chaos for small mu.

    Examples
    --------
    >>> from grazing.proof.gap_chaos import prove_no_attractor
    >>> prove_no_attractor(0.9, 0.0, 0.0, 0.18157749).proven
    True
    >>> print(prove_no_attractor(0.9, 0.0, 0.15, 0.2).statement.split(" at ")[0])
    Nothing is proven: the orbit LLR attracts
    """
    lam, l, low, high = _checked(lam, l, low, high)
    turns: list[str] = []
    n = 1
    while not _rest(n, lam, l, low):
        turn = _turn(n, lam, l, low, high)
        if isinstance(turn, GapProof):
            return turn
        turns.append(turn.hex())
        n += 1
        if n > BLOCKS:
            why = f"blocks of more than {BLOCKS} letters occur at mu = {low!r}; begin further from 0"
            return GapProof(False, f"Nothing is proven: {why}.", None)
    data: dict[str, Any] = {"lam": lam.hex(), "l": l.hex(), "low": low.hex(), "high": high.hex(), "turns": turns}
    return in_balls(lambda: sealed(NO_ATTRACTOR, data))


def _checked(lam: float, l: float, low: float, high: float) -> tuple[float, float, float, float]:
    lam = real(lam, "lam", "allowed is 0 < lam < 1")
    l, low, high = (
        real(v, n, "allowed is any finite number >= 0") for v, n in ((l, "l"), (low, "low"), (high, "high"))
    )
    if not 0.0 < lam < 1.0:
        raise InputError(f"lam = {lam!r}; allowed is 0 < lam < 1, where every orbit comes back to x >= 0 for mu > 0")
    if l < 0.0:
        raise InputError(f"l = {l!r}; allowed is l >= 0, where points right of the border stay below mu")
    if not 0.0 <= low < high:
        raise InputError(
            f"the interval of mu is [{low!r}, {high!r}]; allowed is 0 <= low < high: for mu < 0 mu/(1 - lam) attracts"
        )
    if low == 0.0 and not (l == 0.0 and lam > 2.0 / 3.0):
        raise InputError(
            f"the interval of mu begins at 0 with lam = {lam!r}, l = {l!r}; windows of stable orbits accumulate there "
            "but for l = 0 and lam > 2/3: give a low > 0"
        )
    return lam, l, low, high


def _rest(n: int, lam: float, l: float, low: float) -> bool:
    """Whether blocks of n letters and more need no look: they do not occur, or stretch wherever they do."""
    if low == 0.0:
        return float(geometric_sum(n, lam)) > 3.0 + 1e-12
    return n > 1 and float(mu_bc(n, lam, l)) <= low


def _turn(n: int, lam: float, l: float, low: float, high: float) -> float | GapProof:
    """Return the mu up to which a block stretches and from which on it does not occur, or the window in the way."""
    pd, bc = float(mu_pd(n, lam, l)), float(mu_bc(n, lam, l))
    if high < pd:
        return high
    if bc < low:
        return low
    if bc < pd:  # its window is empty: between the two both are true
        return min(max(0.5 * (bc + pd), low), high)
    a, b = max(low, pd), min(high, bc)
    if not a < b:
        return high if high <= pd else low
    mu, word = 0.5 * (a + b), "L" * (n - 1) + "R"
    why = f"the orbit {word} attracts at mu = {mu!r}, with multiplier {multiplier(n, lam, mu, l):.6g}"
    return GapProof(False, f"Nothing is proven: {why}.", None)
