"""What happens to attractors between neighbouring values of a parameter; relabellings told from bifurcations."""

from __future__ import annotations

import warnings
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from grazing.maps.map import Map
from grazing.orbits.corrector import closed
from grazing.orbits.orbit import Orbit
from grazing.orbits.signature import equations_of
from grazing.orbits.word import word
from grazing.oscillator.trajectory import trajectory
from grazing.outcome import GrazingError
from grazing.parameter import value_of
from grazing.studies.classify import APERIODIC, classify

Floats = NDArray[np.float64]
#: Impacts of one orbit at neighbouring values are no farther apart than this, in periods.
NEAR = 0.25
#: Equal steps in which a periodic orbit is moved to the next value, tried one after the other.
PARTS = (1, 8)
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
    P: Map, name: str, values: Floats, reached: NDArray[np.int32], period: NDArray[np.int32],
    words: NDArray[np.object_], last: Floats, transient: int, keep: int,
) -> list[Change]:  # fmt: skip
    """Return the changes between neighbouring values, in increasing order of the value.

    An attractor that no start reaches may still be there: it is followed up and down from the values where it is known.

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
    there = [
        {k: _point(reached, last, n, k) for k in sorted(_attractors(reached[n], period))} for n in range(len(values))
    ]

    def at(n: int) -> Map:  # a map for each value would take more memory than its orbits
        return P.replace(**{name: float(values[n])})

    for way in (order, order[::-1]):
        for i, j in pairwise(way):
            known = {k: x for k, x in there[i].items() if k not in there[j]}
            if known:
                there[j] |= _followed(at(i), at(j), name, known, period, words, transient, keep)
    for i, j in pairwise(order):
        gone, new = sorted(there[i].keys() - there[j].keys()), sorted(there[j].keys() - there[i].keys())
        for a in list(gone):
            for b in list(new):
                points, both = (there[i][a], there[j][b]), (at(i), at(j))
                kind = _kind(both, points, (int(period[a]), int(period[b])), (str(words[a]), str(words[b])))
                if kind and a in gone:
                    found.append(_change(values, i, j, words, period, a, b, kind))
                    gone.remove(a)
                    new.remove(b)
        found += [_change(values, i, j, words, period, a, None, "disappears") for a in gone]
        found += [_change(values, i, j, words, period, None, b, "appears") for b in new]
    return found


def work_of(values: Floats, reached: NDArray[np.int32], period: NDArray[np.int32], steps: int) -> float:
    """Return about how many steps of the map :func:`changes` takes, for orbits of so many steps."""
    total, order = 0.0, np.argsort(values, kind="stable").tolist()
    there = [_attractors(reached[n], period) for n in order]
    for k in set().union(*there):  # followed between the values where it is reached, and one beyond
        at = [n for n, here in enumerate(there) if k in here]
        total += (at[-1] - at[0] + 3 - len(at)) * float(steps)
    for here, next_ in pairwise(there):
        total += PAIR * len(here - next_) * len(next_ - here)
    return total


def _attractors(reached: NDArray[np.int32], period: NDArray[np.int32]) -> set[int]:
    """Return the attractors that are reached; what is undecided or ended is none."""
    return {k for k in np.unique(reached).tolist() if period[k] > 0 or period[k] == APERIODIC}


def _followed(
    P: Map, there: Map, name: str, known: dict[int, Floats], period: NDArray[np.int32], words: NDArray[np.object_],
    transient: int, keep: int,
) -> dict[int, Floats]:  # fmt: skip
    """Return which attractors of a map are those of another one too, with a point of each there.

    An orbit from a point of the attractor has to settle on one of its period and word: from the point of the periodic
    orbit itself at the new parameter, where it is stable, for near the end of a window all other orbits may leave.
    """
    starts = []
    for k, x in known.items():
        moved = (
            _moved(P, x, int(period[k]), str(words[k]), name, value_of(name, there.params)) if period[k] > 0 else None
        )
        starts.append(x if moved is None else moved)
    with warnings.catch_warnings():  # what a law does to orbits of the study itself has been said
        warnings.filterwarnings("ignore", "(?s).* outcome bad_law", RuntimeWarning)
        points, letters, outcomes = there.run(np.array(starts).T.copy(), transient, keep)
    found = classify(there, points, letters, outcomes[0])
    return {
        k: points[-1, :, n].copy()
        for n, k in enumerate(known)
        if found.period[n] == period[k] and found.word[n] == words[k]
    }


def _moved(P: Map, x: Floats, N: int, word: str, name: str, value: float) -> Floats | None:
    """Return a point of a periodic orbit at another value of a parameter; None where it is not stable, or not found."""
    orbit = Orbit(
        map=P, points=P.orbit(x, N).points[:N], word=word, period=N, multipliers=np.zeros(P.dimension, np.complex128),
        admissible=True, condition=1.0, residual=0.0,
    )  # fmt: skip
    try:
        equations, unknowns = equations_of(orbit, (name,))
    except GrazingError:  # it rests on the wall, or is no orbit of such a parameter
        return None
    now = value_of(name, P.params)
    for parts in PARTS:
        solved: Floats | None = unknowns
        for share in np.arange(1.0, parts + 1.0) / parts:
            p = np.array([(1.0 - share) * now + share * value])
            solved = None if solved is None else closed(equations, solved, p)
        if solved is not None:
            there = equations.orbit(solved, np.array([value]))
            return _seen(P, there) if there.stable and there.admissible else None
    return None


def _seen(P: Map, orbit: Orbit) -> Floats | None:
    """Return a point of an orbit as a map has it; of an oscillator's, at the map's own phase."""
    point = np.asarray(orbit.points[0])
    if P.section is None or P.params.get("phase") == 0.0:
        return point
    if P.section != "strobe":
        return None
    flown = trajectory(orbit.map.origin.rig, (point[0], point[1]), start=0.0, until=P.params["phase"], samples=2)
    return np.array([flown["u"].values[-1], flown["v"].values[-1]])


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


def _point(reached: NDArray[np.int32], last: Floats, i: int, k: int) -> Floats:
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
    if P.model is None or P.section != "strobe" or Q.section != "strobe" or N != M or N < 1:
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
