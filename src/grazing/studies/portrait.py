"""The portrait: how often orbits visit each part of the plane of two coordinates, of which no point is ever stored."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial

import numpy as np
from numpy.typing import ArrayLike, NDArray

from grazing.maps.map import Map
from grazing.memory import refuse_too_large
from grazing.outcome import AMBIGUOUS, FATAL, InputError, shown
from grazing.parameter import checked_box, whole
from grazing.studies import labels
from grazing.studies.plan import Arrays, Plan, Progress, Variable, planned
from grazing.studies.runs import Runs, checked_map, checked_runs
from grazing.studies.trial import trial_ranges

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: Names of variables of the result, which no coordinate may have.
TAKEN = ("count", "beyond", "left", "ended", "ambiguous", "outside")
#: Bytes that a part of the plane takes: counts, while they are made and as they are stored.
PART = 8 * 4


@planned
def portrait(
    P: Map,
    across: str | None = None,
    up: str | None = None,
    *,
    bins: int = 400,
    within: Sequence[tuple[float, float]] | None = None,
    starts: int | ArrayLike = 100,
    transient: int = 200,
    keep: int = 2000,
    seed: int = 0,
    threads: int | None = None,
    arithmetic: str = "fast",
    box: Sequence[tuple[float, float]] | None = None,
    progress: Progress | None = None,
) -> Plan:
    """Return how often orbits of a map visit each part of the plane of two coordinates: attractors as they look.

    Parameters
    ----------
    P : Map
        Of two or more coordinates. That of a ball on a table, seen often, is
        ``gz.stroboscopic_map(table, period=...)``: each part then shows for how long balls are there.
    across, up : str, optional
        Which coordinates; None for the first one and the next that is left.
    bins : int
        Parts along each of them, of equal size.
    within : ((low, high), (low, high)), optional
        What is shown of each; low <= x <= high is counted, high in the last part. None for where orbits of a short
        trial go, and a little more.
    starts, transient, keep, seed, threads, arithmetic, box, progress
        As in :func:`grazing.orbit_diagram`. Give 0 for ``transient`` to see balls before they leave a table.

    Returns
    -------
    xarray.Dataset
        ``count`` on (up, across), whose values are the middles of the parts; ``beyond``, the points outside of what is
        shown; ``left``, the orbits that have left, as a ball does through a drain, and ``ended``, those that ended
        otherwise: neither counts since then. ``ambiguous``, orbits with a decision that could not be made.

    Raises
    ------
    InputError
        For a map of one coordinate, an input out of range, or counts larger than half of the memory.

    Examples
    --------
    >>> import grazing as gz
    >>> P = gz.stroboscopic_map(gz.pinball(d=0.12, V=0.4))
    >>> found = gz.portrait(P, bins=50, starts=20, keep=300)
    >>> int(found["count"].sum()), int((found["count"] > 0).sum())
    (6000, 3)
    """
    coordinates = list(checked_map(P).coordinates)
    if len(coordinates) < 2:
        raise InputError(f"{P.name or 'the map'} has one coordinate, {coordinates[0]}; gz.density counts along that")
    names = [checked_coordinate(P, "across", across, [up]), checked_coordinate(P, "up", up, [across])]
    names[1] = names[1] if up is not None else checked_coordinate(P, "up", None, [names[0]])
    if names[0] == names[1]:
        raise InputError(f"across and up are both {names[0]}; give two coordinates of {', '.join(coordinates)}")
    runs = checked_runs(P, {}, starts, transient, keep, seed, arithmetic, box, TAKEN, as_they_come=True)
    bins, where = whole(bins, "bins", 1), [coordinates.index(name) for name in names]
    refuse_too_large(PART * bins * bins, f"reduce bins ({bins})", "the parts of the plane")
    give = "within=((low, high), (low, high))"
    ends = trial_ranges(runs, where, give) if within is None else checked_box(within, names, "within")
    axes = [
        (name, middles(low, high, bins), labels.quantity(P, name) | {"low": low, "high": high})
        for name, (low, high) in zip(names, ends, strict=True)
    ]

    def count(says: str) -> labels.Attributes:
        return {"long_name": says, "units": "1"}

    return Plan(
        P=P,
        title=f"portrait of the {P.name}",
        config={
            "study": "portrait",
            "across": names[0],
            "up": names[1],
            "bins": bins,
            "within": [list(each) for each in ends],
            **runs.config,
        },
        axes={},
        sizes=dict.fromkeys(names, bins),
        coords={name: (name, values, attrs) for name, values, attrs in axes},
        variables={
            "count": Variable((names[1], names[0]), "int64", count("points in this part of the plane")),
            "beyond": Variable((), "int64", count("points beyond what is shown")),
            "left": Variable((), "int64", count("orbits that have left")),
            "ended": Variable((), "int64", count("orbits that ended otherwise")),
            "ambiguous": Variable((), "int64", count("orbits with an ambiguous decision")),
            **runs.variables,
        },
        compute=partial(_compute, runs, where, ends, bins),
        together=1,
        work=runs.work,
        working=5 * runs.piece_size,
    )


plan = portrait.plan


def middles(low: float, high: float, bins: int) -> Floats:
    """Return the middles of the parts of a range."""
    edges = np.linspace(low, high, bins + 1)
    return np.asarray(0.5 * edges[1:] + 0.5 * edges[:-1])


def checked_coordinate(P: Map, what: str, name: object, other: Sequence[object]) -> str:
    """Return the name of a coordinate, or the first that is not the other one where none is given."""
    if name is None:
        return next(one for one in P.coordinates if one not in other)
    if not isinstance(name, str) or name not in P.coordinates:
        raise InputError(f"{what} = {shown(name)}; allowed are {', '.join(P.coordinates)}")
    return name


def _compute(
    runs: Runs, where: list[int], ends: Sequence[tuple[float, float]], bins: int, cells: Ints, arrays: Arrays
) -> Iterator[None]:
    """Compute cells, see :class:`grazing.studies.plan.Plan`."""
    last, gone = np.empty((len(cells), runs.P.dimension, 0)), np.zeros((len(cells), runs.settings.lanes), np.bool_)
    lost, doubtful = np.zeros((2, len(cells), runs.settings.lanes), np.int64)
    for name in ("count", "beyond"):
        arrays[name][...] = 0
    for part in runs.pieces(cells):
        left = np.logical_or.accumulate(runs.P.origin.left(part.letters), axis=1) | gone[:, None]
        for i in range(len(cells)):
            counted(part.points[i][:, where], ~left[i], ends, bins, arrays["count"][i], arrays["beyond"][i : i + 1])
        if part.points.shape[1]:
            last, gone = part.points[:, -1], left[:, -1]
        lost |= part.outcomes[:, 0] & FATAL
        doubtful |= part.outcomes[:, 0] & AMBIGUOUS
        yield
    runs.say_outside(cells, last, arrays)
    arrays["left"][...], arrays["ended"][...] = gone.sum(axis=1), np.count_nonzero(lost, axis=1)
    arrays["ambiguous"][...] = np.count_nonzero(doubtful, axis=1)


def counted(
    points: Floats,
    there: NDArray[np.bool_],
    ends: Sequence[tuple[float, float]],
    bins: int,
    count: Ints,
    beyond: Ints,
) -> None:
    """Count points (steps, 2, orbits) in ``count`` (up, across) where they are there, the others in ``beyond``."""
    inside, places = there & np.isfinite(points).all(axis=1), list[Ints]()
    beyond += inside.sum()
    for (low, high), x in zip(ends, np.moveaxis(points, 1, 0), strict=True):
        inside &= (low <= x) & (x <= high)
        at = np.floor((np.where(inside, x, low) - low) * (bins / (high - low)))
        places.append(np.minimum(at, bins - 1).astype(np.int64))
    np.add.at(count, tuple(place[inside] for place in reversed(places)), 1)
    beyond -= inside.sum()
