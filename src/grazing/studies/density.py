"""The density: an orbit diagram as counts in a raster, of which no point is ever stored."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import lru_cache, partial
from math import floor
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from grazing.kernel.compile import call, compiled
from grazing.maps.map import Map
from grazing.memory import refuse_too_large
from grazing.outcome import AMBIGUOUS, FATAL, InputError, shown
from grazing.parameter import checked_name, in_order, real, whole
from grazing.studies import labels
from grazing.studies.plan import Arrays, Plan, Progress, Variable, planned
from grazing.studies.runs import Runs, checked_map, checked_runs, describe_values
from grazing.studies.trial import trial_ranges

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: Names of variables of the result, which neither the parameter nor a coordinate may have.
TAKEN = ("count", "below", "above", "ended", "ambiguous", "outside")
#: Points whose places in the raster are found together, in a loop that vectorises.
BLOCK = 64
#: Bytes that a bin takes: counts, while they are made and as they are stored, edges and centres.
BIN = 8 * 6


@planned
def density(
    P: Map,
    name: str,
    values: ArrayLike,
    *,
    bins: int = 1000,
    coordinate: str | None = None,
    range: tuple[float, float] | None = None,
    starts: int | ArrayLike = 100,
    transient: int = 200,
    keep: int = 500,
    seed: int = 0,
    threads: int | None = None,
    arithmetic: str = "fast",
    box: Sequence[tuple[float, float]] | None = None,
    progress: Progress | None = None,
) -> Plan:
    """Return how often orbits visit each part of a coordinate's range while one parameter varies.

    Parameters
    ----------
    P : Map
        Any map.
    name : str
        Which of ``P.params`` varies.
    values : array_like, shape (m,)
        Its values, finite, in any order.
    bins : int
        Parts of the range, of equal size.
    coordinate : str, optional
        Which coordinate is counted; None for the first.
    range : (low, high), optional
        The raster's ends; low <= x <= high is counted, high in the last part. None for the range of a short trial at
        some of the values, and a little more.
    starts, transient, keep, seed, threads, arithmetic, box, progress
        As in :func:`grazing.orbit_diagram`.

    Returns
    -------
    xarray.Dataset
        ``count`` on (name, coordinate), the coordinate's values being the middles of the parts; on (name)
        ``below`` and ``above``, the points beyond the raster's ends, and ``ended``, the starts whose orbits ended,
        whose points since then are not counted, and ``ambiguous``, those with a decision that could not be made.

    Raises
    ------
    InputError
        For an input out of range, or a raster larger than half of the memory.

    Examples
    --------
    >>> import grazing as gz
    >>> from grazing.studies.density import density
    >>> G = gz.gap_map(lam=0.5, mu=0.1, l=0.1)
    >>> found = density(G, "mu", [0.05, 0.07], bins=40, range=(-0.3, 0.1), starts=20, keep=300)
    >>> found["count"].sum("x").values.tolist(), int((found["count"].sel(mu=0.07) > 0).sum())
    ([6000, 6000], 3)
    """
    name = checked_name(name, checked_map(P).params, P.name or "the map")
    runs = checked_runs(P, {name: values}, starts, transient, keep, seed, arithmetic, box, TAKEN, as_they_come=True)
    seen = P.coordinates[0] if coordinate is None else coordinate
    if not isinstance(seen, str) or seen not in P.coordinates:
        raise InputError(f"coordinate = {shown(coordinate)}; allowed are {', '.join(P.coordinates)}")
    bins, i = whole(bins, "bins", 1), list(P.coordinates).index(seen)
    refuse_too_large(BIN * bins, f"reduce bins ({bins})", "one cell and the places of its bins")
    grid = runs.axes[name]
    low, high = trial_ranges(runs, [i], "range=(low, high)")[0] if range is None else checked_range(range)

    edges = np.linspace(low, high, bins + 1)
    ends = {"low": low, "high": high}
    return Plan(
        P=P,
        title=f"density of the {P.name} in {name}",
        config={
            "study": "density",
            "parameter": name,
            "values": describe_values(grid),
            "coordinate": seen,
            "bins": bins,
            "range": [low, high],
            **runs.config,
        },
        axes=runs.axes,
        axis_attrs={name: labels.quantity(P, name)},
        sizes={seen: bins},
        coords={seen: (seen, 0.5 * edges[1:] + 0.5 * edges[:-1], labels.quantity(P, seen) | ends)},
        variables={
            "count": Variable((seen,), "int64", {"long_name": "points in this part of the range", "units": "1"}),
            "below": Variable((), "int64", {"long_name": "points below the raster", "units": "1"}),
            "above": Variable((), "int64", {"long_name": "points above the raster", "units": "1"}),
            "ended": Variable((), "int64", {"long_name": "starts whose orbits ended", "units": "1"}),
            "ambiguous": Variable((), "int64", {"long_name": "starts with an ambiguous decision", "units": "1"}),
            **runs.variables,
        },
        compute=partial(_compute, runs, i, low, high, bins),
        together=runs.together,
        work=runs.work,
        working=runs.piece_size + 3 * 8 * bins,
    )


plan = density.plan


def _compute(runs: Runs, i: int, low: float, high: float, bins: int, cells: Ints, arrays: Arrays) -> Iterator[None]:
    """Compute cells, see :class:`grazing.studies.plan.Plan`."""
    last = np.empty((len(cells), runs.P.dimension, 0))
    counts = np.zeros((len(cells), bins + 3), np.int64)
    lost, doubtful = np.zeros((2, len(cells), runs.settings.lanes), np.int64)
    for part in runs.pieces(cells):
        call(compiled_raster(), part.points, i, low, high, bins, counts)
        lost |= part.outcomes[:, 0] & FATAL
        doubtful |= part.outcomes[:, 0] & AMBIGUOUS
        if part.points.shape[1]:
            last = part.points[:, -1]
        yield
    runs.say_outside(cells, last, arrays)
    arrays["count"][...] = counts[:, 1:-2]
    arrays["below"][...], arrays["above"][...] = counts[:, 0], counts[:, -2]
    arrays["ended"][...] = np.count_nonzero(lost, axis=1)
    arrays["ambiguous"][...] = np.count_nonzero(doubtful, axis=1)


def checked_range(ends: object) -> tuple[float, float]:
    """Return the ends of a raster, or raise InputError."""
    wanted = f"range = {shown(ends)}; give (low, high), finite, low < high"
    try:
        low, high = (real(end, "range", wanted) for end in in_order(ends))
    except (TypeError, ValueError, InputError):
        raise InputError(wanted) from None
    if not (-np.inf < low < high < np.inf and np.isfinite(high - low)):
        raise InputError(wanted)
    return low, high


def raster(points: Any, i: int, low: float, high: float, bins: int, counts: Any) -> None:
    """Count coordinate i of points (columns, steps, dim, lanes) in ``counts`` (columns, bins + 3).

    Places: 0 below, then the parts of the range, one above, one for what is not a number.
    """
    columns, steps, _dimension, lanes = points.shape
    scale = bins / (high - low)
    place = np.empty(BLOCK, np.int64)
    for q in range(columns):
        for n in range(steps):
            for start in range(0, lanes, BLOCK):
                width = min(BLOCK, lanes - start)
                for j in range(width):
                    x = points[q, n, i, start + j]
                    inside = low <= x <= high
                    at = min(floor(((x if inside else low) - low) * scale), bins - 1.0) + 1.0
                    at = at if inside else (0.0 if x < low else (bins + 1.0 if x > high else bins + 2.0))
                    place[j] = int(at)
                for j in range(width):
                    counts[q, place[j]] += 1


@lru_cache(maxsize=1)
def compiled_raster() -> Any:
    """Return :func:`raster`, compiled."""
    return compiled(raster, "strict")
