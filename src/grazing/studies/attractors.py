"""What the starts of an orbit diagram reach: the classes of orbits at each value, with their shares."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from grazing.outcome import InputError

if TYPE_CHECKING:
    import xarray as xr


class Class(NamedTuple):
    """A class of orbits: how many there are, a point of theirs, and whether that is on a neutral cycle."""

    period: int
    word: str
    orbits: int
    point: NDArray[np.float64]
    neutral: bool


#: Whether cycles of so many points through points (n, dim) are neutral, as :attr:`grazing.Orbit.neutral` says, and the
#: derivative of a turn through each (n, dim, dim).
Neutral = Callable[[int, NDArray[np.float64]], tuple[NDArray[np.bool_], NDArray[np.float64]]]
#: Share of a distance by which a turn may change it along a line of cycles: derivatives have ten digits at best.
ALONG = 1e-8


def attractors_of(
    period: NDArray[np.int32],
    words: NDArray[Any],
    points: NDArray[np.float64],
    same: NDArray[np.float64],
    neutral: Neutral,
) -> tuple[NDArray[np.int64], list[Class]]:
    """Sort orbits by the attractor they are on, the one with most orbits first.

    Parameters
    ----------
    period, words : ndarray, shape (n,)
    points : ndarray, shape (n, dim)
        A point of each orbit's attractor, chosen by the same rule for all.
    same : ndarray, shape (dim,)
        Points of one attractor differ by less along each coordinate.
    neutral : callable
        ``neutral(N, points)``: which of them are on neutral cycles, and the derivative of a turn. Those of one word
        that lie along what the derivative keeps are one continuum.

    Returns
    -------
    which : ndarray of int, shape (n,)
    classes : list of Class
        Orbits without a period are on one attractor for each kind, without a point.
    """
    texts, code = np.unique(words.astype(np.str_), return_inverse=True)
    found: list[tuple[Class, NDArray[np.int64]]] = []
    for N, k in np.unique(np.column_stack([period, code]), axis=0).tolist():
        left = np.flatnonzero((period == N) & (code == k))
        while left.size:
            first = points[left[0]]
            with np.errstate(invalid="ignore"):  # infinity is near to nothing, not even to itself
                near = np.ones(left.size, bool) if N < 1 else (np.abs(points[left] - first) < same).all(axis=1)
            near[0] = True
            idle = N >= 1 and neutral(N, first[None])
            if idle and idle[0][0] and not near.all():
                apart = (points[left] - first) / same
                kept = np.abs(apart @ (idle[1][0] * same / same[:, None]).T - apart).max(axis=1)
                near |= (kept <= ALONG * np.abs(apart).max(axis=1)) & neutral(N, points[left])[0]
            found.append((Class(N, str(texts[k]), int(near.sum()), first, bool(idle and idle[0][0])), left[near]))
            left = left[~near]
    found.sort(key=lambda one: (-one[0].orbits, one[0].period, one[0].word, one[0].point.tolist()))
    which = np.empty(len(period), np.int64)
    for i, (_class, rows) in enumerate(found):
        which[rows] = i
    return which, [one for one, _rows in found]


class Attractor(NamedTuple):
    """A class of orbits at one parameter value, with the share of starts that reach it."""

    value: float
    word: str
    period: int
    share: float


def attractors(diagram: xr.Dataset) -> list[Attractor]:
    """Return what the starts of an orbit diagram reach, per value each (word, period) with its share of starts.

    Parameters
    ----------
    diagram : xarray.Dataset
        From :func:`grazing.orbit_diagram`, or any result with ``period`` and ``word`` on (parameter, start).

    Returns
    -------
    list of Attractor
        In the order of the values, the greatest share first. Attractors with the same word and period are one;
        orbits without a word have their period's code: 0 undecided, -1 aperiodic as far as seen, -2 ended.

    Examples
    --------
    >>> import grazing as gz
    >>> from grazing.studies.attractors import attractors
    >>> from grazing.studies.orbit_diagram import orbit_diagram
    >>> diagram = orbit_diagram(gz.gap_map(lam=0.5, mu=0.1, l=0.1), "mu", [0.043])
    >>> [(a.word, a.period) for a in attractors(diagram)]
    [('LLR', 3), ('LLLR', 4)]
    """
    if not {"period", "word"} <= {*getattr(diagram, "data_vars", ())}:
        raise InputError(f"the diagram is a {type(diagram).__name__}; give what gz.orbit_diagram returns")
    name = str(diagram["period"].dims[0])
    found = []
    for value, words, periods in zip(
        diagram[name].values.tolist(), diagram["word"].values.tolist(), diagram["period"].values.tolist(), strict=True
    ):
        counts: dict[tuple[str, int], int] = {}
        for key in zip(words, periods, strict=True):
            counts[key] = counts.get(key, 0) + 1
        order = sorted(counts.items(), key=lambda item: (-item[1], item[0]))
        found += [Attractor(value, word, period, count / len(words)) for (word, period), count in order]
    return found
