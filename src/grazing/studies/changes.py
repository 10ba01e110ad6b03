"""What happens to attractors between neighbouring values of a parameter; relabellings told from bifurcations."""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from grazing.maps.map import Map
from grazing.orbits.word import word
from grazing.oscillator.trajectory import trajectory

Floats = NDArray[np.float64]


class Change(NamedTuple):
    """What happens to an attractor between two values; an empty word and period 0 where it is not there."""

    before: float
    after: float
    word_before: str
    word_after: str
    period_before: int
    period_after: int
    kind: str


def changes(
    P: Map, name: str, values: Floats, reached: NDArray[np.int64], period: NDArray[np.int32],
    words: NDArray[np.object_], last: Floats,
) -> list[Change]:  # fmt: skip
    """Return the changes between neighbouring values, in increasing order of the value.

    Parameters
    ----------
    P : Map
    name, values : str and ndarray, shape (m,)
    reached : ndarray, shape (m, starts)
        The row of each start's attractor in the table ``period``, ``words``.
    last : ndarray, shape (m, starts, dim)
        The last point of each orbit.
    """
    found: list[Change] = []
    order = np.argsort(values, kind="stable").tolist()
    for i, j in pairwise(order):
        here = {k for k in np.unique(reached[i]).tolist() if period[k] > -2}
        there = {k for k in np.unique(reached[j]).tolist() if period[k] > -2}
        gone, new = sorted(here - there), sorted(there - here)
        for a in list(gone):
            for b in list(new):
                kind = ""
                if words[a] == words[b] and words[a] and 2 * period[a] == period[b]:
                    kind = "doubles"
                elif words[a] == words[b] and words[a] and period[a] == 2 * period[b]:
                    kind = "halves"
                elif _relabelled(
                    P.replace(**{name: values[i]}), _point(reached, last, i, a), P.replace(**{name: values[j]}),
                    _point(reached, last, j, b), int(period[a]), int(period[b]),
                ):  # fmt: skip
                    kind = "relabelled"
                if kind and a in gone:
                    found.append(_change(values, i, j, words, period, a, b, kind))
                    gone.remove(a)
                    new.remove(b)
        found += [_change(values, i, j, words, period, a, None, "disappears") for a in gone]
        found += [_change(values, i, j, words, period, None, b, "appears") for b in new]
    return found


def _point(reached: NDArray[np.int64], last: Floats, i: int, k: int) -> Floats:
    """Return a point of attractor k at value i."""
    return np.asarray(last[i, int(np.flatnonzero(reached[i] == k)[0])])


def _change(
    values: Floats, i: int, j: int, words: NDArray[np.object_], period: NDArray[np.int32], a: int | None, b: int | None,
    kind: str,
) -> Change:  # fmt: skip
    return Change(
        float(values[i]),
        float(values[j]),
        "" if a is None else str(words[a]),
        "" if b is None else str(words[b]),
        0 if a is None else int(period[a]),
        0 if b is None else int(period[b]),
        kind,
    )


def _relabelled(P: Map, x: Floats, Q: Map, y: Floats, N: int, M: int) -> bool:
    """Say whether two orbits with different words are one: they have one word when seen at another phase.

    That is the phase farthest from the impacts of both. Only a stroboscopic map has letters that depend on it.
    """
    if P.model is None or Q.model is None or "phase" not in P.params or N != M or N < 1:
        return False
    one, two = _impact_times(P, x, N), _impact_times(Q, y, N)
    if one is None or two is None or len(one) != len(two) or not len(one):
        return False
    both = np.sort(np.concatenate([one % 1.0, two % 1.0]))
    gaps = np.diff(np.append(both, both[0] + 1.0))
    phase = both[gaps.argmax()] + 0.5 * gaps.max()
    return _seen_at(phase, one, N) == _seen_at(phase, two, N)


def _impact_times(P: Map, x: Floats, N: int) -> Floats | None:
    """Return the times of the impacts of N periods, in periods from the strobe; None if the ball chatters or sticks."""
    model = P.model
    assert model is not None
    start = P.params["phase"]
    orbit = P.orbit(x, N)
    if (orbit.letters < 0).any() or orbit.outcomes.any():
        return None
    flown = trajectory(model, x, start=start, until=start + N * model.period)
    times = (flown["impact_time"].values - start) / model.period
    return np.asarray(times[(times > 0.0) & (times <= N)])


def _seen_at(phase: float, times: Floats, N: int) -> str:
    """Return the word of an orbit of N periods with these impact times, seen at another phase."""
    letters = np.bincount(np.floor((times - phase) % N).astype(np.int64), minlength=N)
    return word(letters.tolist())
