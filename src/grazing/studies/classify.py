"""Say what orbits have settled on: the period, the word and how far to trust them. Shared by the studies.

The rule, for the last ``keep`` points of an orbit, with tolerance ``rtol * extent + 1e-13 * size`` per coordinate
(the extent of the orbit along it; the size of the orbit, its greatest coordinate, in units of the box of the map):

1. The orbit *recurs* after N steps if every kept point and letter equals the one N steps earlier, points within the
   tolerance; N is at most keep/2, so that a cycle is seen at least twice. The least such N is the candidate.
2. Recurrence alone is ambiguous where convergence is slow: near a period doubling an orbit that still alternates
   about its cycle recurs after 2N long before it recurs after N, or not yet at all. So for every N below the
   candidate that divides it (every N <= keep/5 if there is no candidate) whose letters repeat and after which the
   orbit recurs better and better, or has arrived, the multiplier decides: Newton's method, begun at the last point,
   gives the cycle of N points with these letters; if all its multipliers (the eigenvalues of the product of
   ``P.jacobian``) lie inside the unit circle, by more than 1e-9, and the distance to it falls, the period is N.
   A fixed point whose greatest multiplier is 1 - q is asked about, too, where the extent is 1e4 tolerances or less, and
   2/q tolerances away counts as arrived: rounding goes round it there.
3. Without candidate or cycle the orbit is aperiodic as far as seen; undecided if it seemed to settle where the map
   has no Jacobian, if cycles of 20 keep points in all were tried (more than there are up to keep = 1000), or if a
   single point was kept.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from grazing.kernel.compile import call
from grazing.maps.columns import Columns
from grazing.maps.hits import Alphabet
from grazing.maps.map import Map
from grazing.orbits.word import word
from grazing.outcome import AMBIGUOUS
from grazing.studies.cycles import settler
from grazing.studies.recurrence import APERIODIC as APERIODIC
from grazing.studies.recurrence import ENDED as ENDED
from grazing.studies.recurrence import FLOOR as FLOOR
from grazing.studies.recurrence import UNDECIDED as UNDECIDED
from grazing.studies.recurrence import compiled_numbering, compiled_recurrence, compiled_spelling

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

CERTIFIED, NUMERICAL, AMBIGUOUS_TRUST = 0, 1, 2

#: Relative tolerance of recurrence unless told otherwise.
TOLERANCE = 1e-9


class Classified(NamedTuple):
    """What orbits are: ``period`` int32, ``word`` text, ``trust`` int8, all of one shape."""

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
    row = np.array([list(P.params.values()) or [0.0]])
    settled = settle_columns(P, row, points[None], letters[None], outcomes[None, None], tolerance)
    return Classified(settled.period[0], settled.words[0].astype(np.str_), settled.trust[0])


class Settled(NamedTuple):
    """What the orbits of many columns are, each (columns, starts): ``period``, ``trust``, ``code`` of the word.

    ``texts`` are the words by code, 0 for none. ``begin`` says with which of the kept letters, counted from 0, the
    word begins, and ``length`` how many letters it has.
    """

    period: NDArray[np.int32]
    trust: NDArray[np.int8]
    code: NDArray[np.int32]
    begin: NDArray[np.int32]
    length: NDArray[np.int32]
    texts: NDArray[Any]

    @property
    def words(self) -> NDArray[Any]:
        """The words as Python objects, equal ones the same object."""
        found: NDArray[Any] = self.texts[self.code]
        return found


def settle_columns(
    P: Map, rows: Floats, points: Floats, letters: NDArray[np.signedinteger], outcomes: Ints, tolerance: float
) -> Settled:
    """Find period and word of the orbits of many columns, see :func:`classify`.

    Parameters
    ----------
    P : Map
    rows : ndarray, shape (columns, parameters)
    points, letters, outcomes
        As in :class:`grazing.maps.columns.Columns`, outcomes folded.
    tolerance : float
    """
    shape = letters.shape[0], letters.shape[2]
    period, doubtful = np.empty(shape, np.int32), np.empty(shape, np.int32)
    found = (np.ascontiguousarray(points), np.ascontiguousarray(letters, np.int64))
    unit = np.array([high - low for low, high in P.box])
    sizes = np.empty((2, shape[0], points.shape[2], shape[1]))
    call(compiled_recurrence(), *found, np.ascontiguousarray(outcomes), tolerance, unit, period, doubtful, *sizes)
    which = np.argwhere(doubtful)
    if which.size:
        columns, row = np.unique(which[:, 0], return_inverse=True)
        derived = P.derivative(rows[columns])
        entry = settler(derived.tangent, derived.prepare, derived.kind, P.dimension)
        places = np.ascontiguousarray(np.column_stack([which, row, doubtful[doubtful > 0]]))  # one kernel for all
        call(entry, derived.rows, *found, *sizes, places, period, who=f"the step of {P.name}")
    key, begin, length = np.empty(shape, np.int64), np.empty(shape, np.int32), np.empty(shape, np.int32)
    call(compiled_spelling(), found[1], period, key, begin, length)
    code, first = np.empty(shape, np.int32), np.empty(key.size + 1, np.int64)
    texts = np.full(call(compiled_numbering(), key, code, first), "", object)
    for i, place in enumerate(first[1 : len(texts)].tolist(), start=1):  # one orbit spells a word for all
        q, j = divmod(place, shape[1])
        start = begin[q, j] - period[q, j]  # the letters repeat, and here none of the word lies beyond the end
        texts[i] = _spelled(tuple(found[1][q, start : start + length[q, j], j].tolist()), P.letters)
    trust = np.full(shape, CERTIFIED if P.tangent is not None and P.origin.exact else NUMERICAL, np.int8)
    trust[(outcomes[:, 0] & AMBIGUOUS) != 0] = AMBIGUOUS_TRUST
    return Settled(period, trust, code, begin, length, texts)


def settled_columns(P: Map, rows: Floats, found: Columns, tolerance: float = TOLERANCE) -> Settled:
    """Find period and word of all orbits that :meth:`grazing.Map.run_columns` returned."""
    return settle_columns(P, rows, found.points, found.letters, found.outcomes, tolerance)


@lru_cache(maxsize=65536)
def _spelled(letters: tuple[int, ...], symbols: str | Alphabet | None) -> str:
    return word(letters, symbols)
