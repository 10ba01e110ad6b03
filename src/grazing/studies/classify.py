"""Say what orbits have settled on: the period, the word and how far to trust them. Shared by the studies.

The rule, for the last ``keep`` points of an orbit, with tolerance ``rtol * extent + 1e-13 * size`` per coordinate
(the extent of the orbit along it; the size of the orbit, its greatest coordinate):

1. The orbit *recurs* after N steps if every kept point and letter equals the one N steps earlier, points within the
   tolerance; N is at most keep/2, so that a cycle is seen at least twice. The least such N is the candidate.
2. Recurrence alone is ambiguous where convergence is slow: near a period doubling an orbit that still alternates
   about its cycle recurs after 2N long before it recurs after N, or not yet at all. So for every N below the
   candidate that divides it (every N <= keep/5 if there is no candidate) whose letters repeat and after which the
   orbit recurs better and better, the multiplier decides: Newton's method, begun at the last point, gives the
   cycle of N points with these letters; if all its multipliers (the eigenvalues of the product of
   ``P.jacobian``) lie inside the unit circle and the distance to it falls, the period is N.
3. Without candidate or cycle the orbit is aperiodic as far as seen; undecided if it seemed to settle where the map
   has no Jacobian, or if a single point was kept.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from grazing.maps.map import Map
from grazing.orbits.word import word
from grazing.outcome import AMBIGUOUS, FATAL
from grazing.studies.cycles import NoTangent, approaches, find_cycle

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

UNDECIDED, APERIODIC, ENDED = 0, -1, -2
CERTIFIED, NUMERICAL, AMBIGUOUS_TRUST = 0, 1, 2

#: Relative tolerance of recurrence unless told otherwise.
TOLERANCE = 1e-9
#: The absolute part of the tolerance, in units of the orbit's greatest coordinate.
FLOOR = 1e-13
#: An orbit nearly recurs within this share of its extent; others are not worth a search for a cycle.
NEAR = 0.1


class Classified(NamedTuple):
    """What n orbits are: ``period`` (n,) int32, ``word`` (n,) text, ``trust`` (n,) int8."""

    period: NDArray[np.int32]
    word: NDArray[np.str_]
    trust: NDArray[np.int8]


def classify(
    P: Map, points: Floats, letters: NDArray[np.signedinteger], outcomes: Ints, tolerance: float = TOLERANCE
) -> Classified:
    """Find period and word of orbits of one map.

    Parameters
    ----------
    P : Map
        The map, with the parameters of these orbits; asked for multipliers where recurrence is ambiguous.
    points : ndarray, shape (keep, dim, n)
    letters : ndarray of int, shape (keep, n)
    outcomes : ndarray of int, shape (n,)
        Folded over the whole of each orbit; all three as :meth:`grazing.Map.run` returns them.
    tolerance : float
        ``rtol`` of the rule at the top of this file.

    Returns
    -------
    Classified
        ``period``: 0 undecided, -1 aperiodic as far as seen, -2 ended (diverged or another fatal outcome).
        ``word``: empty where period is below 1. ``trust``: 0 certified, 1 numerical (the map has no exact tangent),
        2 ambiguous (some step was closer to a graze than the rounding error).

    Examples
    --------
    >>> import grazing as gz, numpy as np
    >>> G = gz.gap_map(lam=0.8, mu=0.5, l=1.0)
    >>> points, letters, outcomes = G.run(np.array([[-0.5, 0.3]]), 200, 50)
    >>> found = classify(G, points, letters, outcomes[0])
    >>> found.period.tolist(), found.word.tolist(), found.trust.tolist()
    ([3, 3], ['LLR', 'LLR'], [0, 0])
    """
    keep, _dim, n = points.shape
    period = np.full(n, UNDECIDED, np.int32)
    ended = ((outcomes & FATAL) != 0) | ~np.isfinite(points).all(axis=(0, 1))
    period[ended] = ENDED
    alive = np.flatnonzero(~ended)
    if keep > 1 and alive.size:
        everything = alive.size == n
        x, s = (points, letters) if everything else (points[:, :, alive], letters[:, alive])
        scales = _scales(x, tolerance)
        period[alive] = _settled(P, x, s, scales, _recurrence(x, s, scales.tolerance))
    trust = np.full(n, CERTIFIED if P.tangent is not None and P.exact else NUMERICAL, np.int8)
    trust[(outcomes & AMBIGUOUS) != 0] = AMBIGUOUS_TRUST
    return Classified(period, _words(letters, period, P.letters), trust)


class _Scales(NamedTuple):
    """Lengths that belong to n orbits, each (dim, n)."""

    extent: Floats
    tolerance: Floats


def _scales(points: Floats, rtol: float) -> _Scales:
    high, low = points.max(axis=0), points.min(axis=0)
    floor = FLOOR * np.maximum(high, -low).max(axis=0)
    extent = high - low
    return _Scales(np.maximum(extent, 10.0 * floor + 1e-300), rtol * extent + floor)


def _recurrence(points: Floats, letters: NDArray[np.signedinteger], tolerance: Floats) -> NDArray[np.int32]:
    """Return the least lag N <= keep/2 after which each orbit recurs, 0 for none."""
    keep, n = letters.shape
    lags = np.arange(1, keep // 2 + 1)
    # the last point alone rules out nearly every lag; what is left is checked in full
    close = (np.abs(points[keep - 1 - lags] - points[-1]) <= tolerance).all(axis=1)
    close &= letters[keep - 1 - lags] == letters[-1]
    period = np.zeros(n, np.int32)
    remaining = np.flatnonzero(close.any(axis=0))
    while remaining.size:
        candidates = lags[close[:, remaining].argmax(axis=0)]
        for N in np.unique(candidates):
            rows = remaining[candidates == N]
            x, s = points[:, :, rows], letters[:, rows]
            good = (np.abs(x[N:] - x[:-N]) <= tolerance[:, rows]).all(axis=(0, 1)) & (s[N:] == s[:-N]).all(axis=0)
            period[rows[good]] = N
            close[N - 1, rows] = False
        remaining = remaining[(period[remaining] == 0) & close[:, remaining].any(axis=0)]
    return period


def _settled(
    P: Map, points: Floats, letters: NDArray[np.signedinteger], scales: _Scales, candidate: NDArray[np.int32]
) -> NDArray[np.int32]:
    """Return the period after the multiplier has had its say (step 2 of the rule), -1 or 0 where there is none."""
    keep = len(points)
    period = np.where(candidate > 0, candidate, APERIODIC).astype(np.int32)
    open_ = candidate != 1
    for N in range(1, keep // 3 + 1):
        divides = (candidate > N) & (candidate % N == 0)
        rows = np.flatnonzero(open_ & (divides | ((candidate == 0) & (5 * N <= keep))))
        rows = rows[(letters[N:, rows] == letters[:-N, rows]).all(axis=0)]
        rows = rows[_settling(points[:, :, rows] / scales.extent[:, rows], N)]
        while rows.size:
            x, s, tolerance = points[:, :, rows], letters[:, rows], scales.tolerance[:, rows]
            near = np.zeros(rows.size, bool)
            try:
                cycle = find_cycle(P, x[-1, :, 0], s[-N:, 0].astype(np.int64), tolerance[:, 0])
                if cycle is not None:
                    near = approaches(cycle, x, s, tolerance)
            except NoTangent:
                period[rows[0]] = max(period[rows[0]], UNDECIDED)
            period[rows[near]] = N
            open_[rows[near]] = False
            near[0] = True  # its turn is over, one way or the other
            rows = rows[~near]
    return period


def _settling(scaled: Floats, N: int) -> NDArray[np.bool_]:
    """Say which orbits recur better and better after N steps, and nearly so after N or 2N; points in extents."""
    keep, dimension, n = scaled.shape
    if not n:
        return np.zeros(0, bool)
    after = np.abs(scaled[N:] - scaled[:-N]).max(axis=1)
    groups = min(4, len(after) // N)
    worst = np.array([part.max(axis=0) for part in np.array_split(after, groups)])
    better = (worst[1:] < worst[:-1] * (1.0 - 1e-10)).all(axis=0)  # more than rounding
    if N == 1 and dimension > 1:  # a spiral into a fixed point: its extent is itself the distance that shrinks
        return np.asarray(better)
    after_two = np.abs(scaled[-N:] - scaled[keep - 3 * N : keep - 2 * N]).max(axis=(0, 1))
    return np.asarray(better & (np.minimum(worst[-1], after_two) <= NEAR))


def _words(letters: NDArray[np.signedinteger], period: NDArray[np.int32], symbols: str | None) -> NDArray[np.str_]:
    known: dict[tuple[int, bytes], str] = {}
    rows = np.ascontiguousarray(letters.T)
    words = []
    for row, N in zip(rows, period.tolist(), strict=True):
        if N < 1:
            words.append("")
            continue
        key = (N, row[-N:].tobytes())
        if key not in known:
            known[key] = word(row[-N:].tolist(), symbols)
        words.append(known[key])
    return np.array(words, dtype=np.str_)
