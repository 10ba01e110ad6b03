"""What happens to attractors between neighbouring values of a parameter; relabellings told from bifurcations."""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from grazing.maps.map import Map
from grazing.orbits.word import word
from grazing.oscillator.trajectory import trajectory
from grazing.studies.classify import APERIODIC, classify

Floats = NDArray[np.float64]
#: Impacts of one orbit at neighbouring values are no farther apart than this, in periods.
NEAR = 0.25
#: Steps of the map that take as long as to compare two attractors.
PAIR = 1000.0


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
    words: NDArray[np.object_], last: Floats, transient: int, keep: int,
) -> list[Change]:  # fmt: skip
    """Return the changes between neighbouring values, in increasing order of the value.

    An attractor that no start reaches at the next value may still be there: its own point is followed there first.

    Parameters
    ----------
    P : Map
    name, values : str and ndarray, shape (m,)
    reached : ndarray, shape (m, starts)
        The row of each start's attractor in the table ``period``, ``words``.
    last : ndarray, shape (m, starts, dim)
        The last point of each orbit.
    transient, keep : int
        As in the study.
    """
    found: list[Change] = []
    order = np.argsort(values, kind="stable").tolist()
    for i, j in pairwise(order):
        before, after = (P.replace(**{name: float(values[n])}) for n in (i, j))
        here, there = (_attractors(reached[n], period) for n in (i, j))

        def there_too(R: Map, n: int, k: int) -> bool:
            x = _point(reached, last, n, k)
            return _is_on(R, x, transient, keep, int(period[k]), str(words[k]))

        gone = [k for k in sorted(here - there) if not there_too(after, i, k)]
        new = [k for k in sorted(there - here) if not there_too(before, j, k)]
        for a in list(gone):
            for b in list(new):
                points = _point(reached, last, i, a), _point(reached, last, j, b)
                kind = _kind((before, after), points, (int(period[a]), int(period[b])), (str(words[a]), str(words[b])))
                if kind and a in gone:
                    found.append(_change(values, i, j, words, period, a, b, kind))
                    gone.remove(a)
                    new.remove(b)
        found += [_change(values, i, j, words, period, a, None, "disappears") for a in gone]
        found += [_change(values, i, j, words, period, None, b, "appears") for b in new]
    return found


def work_of(values: Floats, reached: NDArray[np.int64], period: NDArray[np.int32], steps: int) -> float:
    """Return about how many steps of the map :func:`changes` takes, for orbits of so many steps."""
    total, order = 0.0, np.argsort(values, kind="stable").tolist()
    there = [_attractors(reached[n], period) for n in order]
    for here, next_ in pairwise(there):
        gone, new = len(here - next_), len(next_ - here)
        total += (gone + new) * float(steps) + PAIR * gone * new
    return total


def _attractors(reached: NDArray[np.int64], period: NDArray[np.int32]) -> set[int]:
    """Return the attractors that are reached; what is undecided or ended is none."""
    return {k for k in np.unique(reached).tolist() if period[k] > 0 or period[k] == APERIODIC}


def _is_on(P: Map, x: Floats, transient: int, keep: int, period: int, word: str) -> bool:
    """Return whether an orbit from x settles on an attractor of this period and word."""
    points, letters, outcomes = P.run(x.reshape(-1, 1).copy(), transient, keep)
    found = classify(P, points, letters, outcomes[0])
    return bool(found.period[0] == period and found.word[0] == word)


def _kind(
    maps: tuple[Map, Map], points: tuple[Floats, Floats], periods: tuple[int, int], words: tuple[str, str]
) -> str:
    """Return how one attractor becomes another, empty if it does not."""
    if words[0] == words[1] and words[0]:
        if 2 * periods[0] == periods[1]:
            return "doubles"
        if periods[0] == 2 * periods[1]:
            return "halves"
    return "relabelled" if _relabelled(maps[0], points[0], maps[1], points[1], *periods) else ""


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

    That is the phase farthest from the impacts of both; and the impacts must have moved little. Only a stroboscopic map
    has letters that depend on the phase.
    """
    if P.section != "strobe" or Q.section != "strobe" or N != M or N < 1:
        return False
    one, two = _impact_times(P, x, N), _impact_times(Q, y, N)
    if one is None or two is None or len(one) != len(two) or not len(one):
        return False
    both = np.sort(np.concatenate([one % 1.0, two % 1.0]))
    gaps = np.diff(np.append(both, both[0] + 1.0))
    phase = both[gaps.argmax()] + 0.5 * gaps.max()
    return _seen_at(phase, one, N) == _seen_at(phase, two, N) and _apart(one - phase, two - phase, N) < NEAR


def _apart(one: Floats, two: Floats, N: int) -> float:
    """Return how far impact times differ at most, in periods, for the best choice of the first period."""
    first = np.sort(one % N)
    return min(float(np.abs(np.sort((two + k) % N) - first).max()) for k in range(N))


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
