"""Which edges an orbit of the gap map leads to: a word may have up to three orbits at one mu."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from grazing.orbits.orbit import Orbit
from grazing.outcome import InputError
from grazing.proof.gap import GapProof, certify_gap_edge
from grazing.theory import word_orbits
from grazing.theory.words import blocks_of

Floats = NDArray[np.float64]

#: Where the way to an edge ends, in parts of it or of mu; how often it is halved there, and most steps of a half.
NEAR, STEPS = 1e-9, 200
#: The slopes at both ends of a step tell how far an orbit moves, but for this part; it moves no farther than that part.
TOLD, FAR = 0.3, 0.2
#: How near to its edge an orbit has then come, in parts of its roots: as the root of that way at a fold.
CLOSE = 1e-3


def nearest_edge(orbit: Orbit, edge: str) -> GapProof | None:
    """Return the proof of the edge nearest in mu that an orbit of the gap map leads to, with no fold on the way.

    Parameters
    ----------
    orbit : Orbit
        Of a gap map.
    edge : {"gr", "bc", "pd", "lp"}

    Returns
    -------
    GapProof or None
        None where its word has no such edge, or those it has belong to other orbits of it. Of edges that are not
        proven it is not known whose they are: if none is joined to this orbit, one of them says why.

    Raises
    ------
    InputError
        For an orbit that goes round its word twice: edges are those of words that repeat no shorter one.

    Examples
    --------
    >>> import grazing as gz
    >>> from grazing.orbits.gap_orbits import gap_orbits
    >>> from grazing.proof.gap_branch import nearest_edge
    >>> (orbit,) = (one for one in gap_orbits(gz.gap_map(lam=0.9, mu=0.17, l=0.0), 3) if one.word == "LLR")
    >>> nearest_edge(orbit, "pd").value[0] < 0.18157749077490773
    True
    """
    if orbit.period != len(orbit.word):
        raise InputError(
            f"the orbit has period {orbit.period} and goes round {orbit.word} {orbit.period // len(orbit.word)} times; "
            "edges are proven for orbits of words that repeat no shorter one"
        )
    lam, mu, l = (float(orbit.map.params[key]) for key in ("lam", "mu", "l"))
    proofs = certify_gap_edge(orbit.word, edge, lam, l)
    unproven = [one for one in proofs if one.value is None]
    joined = [one for one in proofs if one.value is not None and _leads(orbit, one, edge)]
    if not joined:
        return unproven[0] if unproven else None
    return min(joined, key=lambda one: abs(one.value[0] - mu) if one.value is not None else 0.0)


def _leads(orbit: Orbit, proof: GapProof, edge: str) -> bool:
    """Whether an orbit, followed in mu, comes to that of a proven edge; at a fold two orbits do."""
    assert proof.document is not None and proof.value is not None
    data, (low, high) = proof.document["data"], proof.value
    ends = np.array([[float(x) for x in pair] for pair in data["claims"]["roots"]]).mean(axis=1)
    lam, l = (float(orbit.map.params[key]) for key in ("lam", "l"))
    end, mu = 0.5 * (low + high), float(orbit.map.params["mu"])

    def roots(value: float) -> Floats:
        found = [one.roots for one in word_orbits(orbit.word, lam, value, l)]
        return np.array(found).reshape(len(found), len(ends))

    def slope(s: Floats) -> Floats:
        blocks = blocks_of(orbit.word, lam, mu, l)
        D = np.diag(2.0 * s)
        D[range(len(s)), range(-1, len(s) - 1)] += blocks.c
        return np.linalg.solve(D, np.array(blocks.K))

    least = float(orbit.points.min())
    own = min(word_orbits(orbit.word, lam, mu, l), key=lambda one: abs(float(one.points.min()) - least))
    s, way = np.array(own.roots), mu - end
    near = NEAR * max(abs(way), abs(end))
    while abs(way) > near:
        followed = _followed(roots, slope, s, end + way, end + 0.5 * way)
        if followed is None:
            return False
        s, way = followed, 0.5 * way
    last = roots(end + way)
    if len(last) == 0:
        return False
    gaps, scale = np.abs(last - ends).max(axis=1), np.abs(own.roots).max()
    there = [i for i in np.argsort(gaps)[: 2 if edge == "lp" else 1] if gaps[i] <= CLOSE * scale]
    return int(np.argmin(np.abs(last - s).max(axis=1))) in there


def _followed(
    roots: Callable[[float], Floats], slope: Callable[[Floats], Floats], s: Floats, start: float, stop: float
) -> Floats | None:
    """Return the roots at one mu that those at another go over into; None if they end on the way, or are not told."""
    at, step = start, stop - start
    for _ in range(STEPS):
        to = stop if abs(step) >= 0.99 * abs(stop - at) else at + step
        there = roots(to)
        try:
            ahead = slope(s) * (to - at)
            near = there[np.argmin(np.abs(there - s - ahead).max(axis=1))] if len(there) else s
            off = np.abs(near - s - np.array([ahead, slope(near) * (to - at)])).max()
        except np.linalg.LinAlgError:
            return None
        moved = np.abs(near - s).max()
        if len(there) and off <= TOLD * moved and moved <= FAR * np.abs(s).max():
            if to == stop:
                return near
            s, at, step = near, to, 2.0 * step
        else:
            step *= 0.5
    return None
