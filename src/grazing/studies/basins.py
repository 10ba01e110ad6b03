"""Basins: which attractor each initial state reaches."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import partial
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from grazing.maps.columns import Columns
from grazing.maps.map import Map
from grazing.maps.pieces import joined, let_go, pieces
from grazing.orbits.grazing_curve import MOST_PREIMAGES, grazing_arrays
from grazing.orbits.orbit import ROUNDING
from grazing.outcome import InputError, shown
from grazing.parameter import whole
from grazing.studies import labels, outside
from grazing.studies.attractors import attractors_of
from grazing.studies.boundary import basin_entropy, evenly_spaced, uncertainty
from grazing.studies.classify import Settled, settled_columns
from grazing.studies.growth import on_cycles, turned
from grazing.studies.plan import Arrays, Plan, Progress, Variable, planned
from grazing.studies.runs import (
    checked_arithmetic,
    checked_fixed,
    checked_map,
    checked_values,
    describe_values,
    size_of_orbit,
    together,
    tolerance_config,
)

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: Names of variables and dimensions of the result, which a coordinate must not have.
TAKEN = (
    "basin", "attractor", "coordinate", "period", "word", "neutral", "fraction", "point", "trust", "outcome", "graze",
    "graze_order", "outside",
)  # fmt: skip
#: Two orbits of the same word and period are on one attractor if their points differ by less than this share of the
#: grid's extent.
SAME = 1e-6
#: Points of the grazing curve and of each of its preimages.
CURVE = 2000


@planned
def basins(
    P: Map,
    grid: Mapping[str, ArrayLike] | None = None,
    *,
    fixed: Mapping[str, float] | None = None,
    transient: int = 500,
    keep: int = 64,
    preimages: int = 3,
    threads: int | None = None,
    arithmetic: str = "fast",
    progress: Progress | None = None,
) -> Plan:
    """Return which attractor each initial state of a grid reaches.

    Parameters
    ----------
    P : Map
        Any map.
    grid : mapping of str to array_like, optional
        One or two coordinates of the map with their values; None for 200 values of each of the first two over the
        map's box.
    fixed : mapping of str to float, optional
        The other coordinates; each is in the middle of the map's box unless said.
    transient, keep : int
        Steps that are thrown away, then steps in which a period up to keep/2 is looked for.
    preimages : int
        How many preimages of the grazing curve come with it, for a stroboscopic map; at most 100.
    threads, arithmetic, progress
        As in :func:`grazing.orbit_diagram`.

    Returns
    -------
    xarray.Dataset
        ``basin`` on the grid: the row in the tables on the dimension "attractor", the one with the largest basin
        first: ``period`` (0 undecided, -1 aperiodic as far as seen, -2 ended), ``word``, ``fraction`` of the grid,
        ``point``, a point of the attractor. Orbits without a period are one row for each kind, and so are *neutral*
        ones of one word on a line, ``neutral`` = 1, whose largest multiplier has modulus 1: a continuum, as where a
        ball without a spring touches no wall. ``trust`` and ``outcome`` as in :func:`grazing.orbit_diagram`.
        Attributes: ``basin_entropy`` and ``boundary_basin_entropy`` in boxes of 5 cells a side;
        ``uncertainty_exponent`` with its standard error ``uncertainty_error``, and ``boundary_dimension``: not a
        number where no boundary was met, or where the grid is not evenly spaced. An orbit that begins exactly on an
        unstable cycle stays there, and has a row of its own.
        For a stroboscopic map ``graze`` (graze_point, coordinate), the states that touch the wall within a period,
        and their preimages, with ``graze_order``; rows that are not numbers separate pieces. The boundaries lie on
        them or on the stable manifolds of saddles.

    Raises
    ------
    InputError
        For an input out of range, a state that is not allowed, or a result larger than half of the memory.

    References
    ----------
    McDonald, Grebogi, Ott and Yorke, Physica D 17 (1985) 125-153; Daza, Wagemakers, Georgeot, Guery-Odelin and
    Sanjuan, Scientific Reports 6 (2016) 31416.

    Examples
    --------
    >>> import grazing as gz, numpy as np
    >>> from grazing.studies.basins import basins
    >>> found = basins(gz.gap_map(lam=0.5, mu=0.043, l=0.1), {"x": np.linspace(-1, 1, 400)})
    >>> found.word.values.tolist(), bool(found.fraction.sum() == 1.0)
    (['LLR', 'LLLR'], True)
    """
    checked_map(P)
    axes = _checked_grid(P, grid)
    others = checked_fixed(P, axes, fixed)
    transient, keep = whole(transient, "transient", 0), whole(keep, "keep", 1)
    preimages, arithmetic = whole(preimages, "preimages", 0, MOST_PREIMAGES), checked_arithmetic(arithmetic)
    shape = tuple(len(values) for values in axes.values())
    for corner in product(*[(int(values.argmin()), int(values.argmax())) for values in axes.values()]):
        state = _states(P, axes, others, np.array([np.ravel_multi_index(corner, shape)]))
        P.origin.check(tuple(state[:, 0].tolist()), P.params)
    name = P.name or "map"
    return Plan(
        P=P,
        title=f"basins of the {name}",
        config={
            "study": "basins",
            "params": dict(P.params),
            "axes": list(axes),
            "grid": {name: describe_values(values) for name, values in axes.items()},
            "fixed": others,
            "transient": transient,
            "keep": keep,
            "preimages": preimages,
            "same": SAME,
            "arithmetic": arithmetic,
            **tolerance_config(keep),
        },
        axes=axes,
        axis_attrs={name: labels.quantity(P, name) for name in axes},
        sizes={"coordinate": P.dimension},
        coords={"coordinate": ("coordinate", np.array(P.coordinates))},
        variables={
            "reached_period": Variable((), "int32", labels.period_attributes(keep // 2)),
            "reached_word": Variable((), "text", labels.word_attributes(), labels.longest_word(keep // 2, P.letters)),
            "reached_point": Variable(("coordinate",), "float64", {"long_name": "a point of the attractor"}),
            "outcome": Variable((), "int32", labels.outcome_attributes()),
            "trust": Variable((), "int8", labels.trust_attributes()),
            **({outside.NAME: Variable((), "int32", outside.ATTRIBUTES)} if grid is None else {}),
        },
        compute=partial(_compute, P, axes, others, transient, keep, arithmetic),
        together=together(P, arithmetic),
        work=transient + keep,
        working=size_of_orbit(P, keep),
        finish=partial(_with_attractors, P, axes, preimages),
        finish_work=partial(_finish_work, P, axes, preimages),
    )


plan = basins.plan


def _compute(
    P: Map, axes: Mapping[str, Floats], others: Mapping[str, float], transient: int, keep: int, arithmetic: str,
    cells: Ints, arrays: Arrays,
) -> Iterator[None]:  # fmt: skip
    """Compute cells, see :class:`grazing.studies.plan.Plan`."""
    row = np.array([list(P.params.values()) or [0.0]])
    lanes, parts = _states(P, axes, others, cells)[None], []
    for part in pieces(P, row, lanes, transient, keep, arithmetic):
        parts.append(part)
        yield
    found = let_go(P, joined(parts))
    if outside.NAME in arrays:
        arrays[outside.NAME][...] = outside.beyond(found.points[:, -1], np.array([P.box]))[0]
    settled = settled_columns(P, row, found)
    arrays["reached_period"][...], arrays["reached_word"][...] = settled.period[0], settled.words[0]
    arrays["reached_point"][...] = _points(P, row, found, settled)
    arrays["outcome"][...], arrays["trust"][...] = found.outcomes[0, 0], settled.trust[0]


def _checked_grid(P: Map, grid: Mapping[str, ArrayLike] | None) -> dict[str, Floats]:
    wanted = f"give one or two of {', '.join(P.coordinates)} with their values"
    if grid is None:
        ends = dict(zip(P.coordinates[:2], P.box, strict=False))
        return {name: np.linspace(low, high, 200) for name, (low, high) in ends.items()}
    if not isinstance(grid, Mapping) or not 1 <= len(grid) <= 2:
        raise InputError(f"grid is {shown(grid)}; {wanted}")
    for name in grid:
        if name not in P.coordinates:
            raise InputError(f"{shown(name)} is no coordinate of the {P.name}; {wanted}")
        if name in TAKEN:
            raise InputError(f"{shown(name)} names a dimension or variable of the result; rename it in the map")
    return {name: checked_values(name, values, P) for name, values in grid.items()}


def _states(P: Map, axes: Mapping[str, Floats], others: Mapping[str, float], cells: Ints) -> Floats:
    """Return the initial states of cells, shape (dim, cells)."""
    places = np.unravel_index(cells, tuple(len(values) for values in axes.values()))
    known = {name: values[i] for (name, values), i in zip(axes.items(), places, strict=True)}
    return np.array([known.get(name, np.full(len(cells), others.get(name))) for name in P.coordinates], np.float64)


def _points(P: Map, row: Floats, found: Columns, settled: Settled) -> Floats:
    """Return, for each orbit with a period, the point of its cycle at which the word begins.

    Of several such points, the one that comes first in order. Newton's method takes the orbit's own point to the cycle,
    so that orbits which approach it slowly agree.
    """
    keep = found.points.shape[1]
    period, begin, length = settled.period[0], settled.begin[0], settled.length[0]
    x, letters = np.moveaxis(found.points[0], 2, 0), found.letters[0].T  # (orbits, keep, dim), (orbits, keep)
    result = np.full(x[:, 0].shape, np.nan)
    for N, start, p in np.unique(np.column_stack([period, begin, length]), axis=0).tolist():
        if N < 1:
            continue
        here = np.flatnonzero((period == N) & (begin == start) & (length == p))
        first = keep - N
        # a letter is that of the step to its point: the word begins one point earlier
        turns = np.array([first + (start - 1 - first + k * p) % N for k in range(N // p)])
        turn = turns[_first_in_order(x[here][:, turns])]
        seen = letters[here[:, None], first + (turn[:, None] + 1 - first + np.arange(N)) % N]
        result[here] = on_cycles(P, np.repeat(row, len(here), axis=0), x[here, turn], seen)
    return result


def _first_in_order(candidates: Floats) -> Ints:
    """Return which of several points (orbits, points, dim) comes first in lexicographic order, for each orbit."""
    best = np.zeros(len(candidates), np.int64)
    rows = np.arange(len(candidates))
    for k in range(1, candidates.shape[1]):
        other, leader = candidates[:, k], candidates[rows, best]
        differ = other != leader
        first = differ.argmax(axis=1)
        smaller = differ.any(axis=1) & (other[rows, first] < leader[rows, first])
        best = np.where(smaller, k, best)
    return best


def _neutral(P: Map, N: int, points: Floats) -> tuple[NDArray[np.bool_], Floats]:
    """Return which of points (n, dim) are on neutral cycles of N points, and the derivative of a turn."""
    n = len(points)
    rows = np.repeat([list(P.params.values()) or [0.0]], n, axis=0)
    turns = turned(P, rows, points, np.zeros((n, N), np.int64), np.full(n, N))[1]
    result = np.zeros(n, bool)
    known = np.isfinite(turns).all(axis=(1, 2))
    result[known] = np.abs(np.abs(np.linalg.eigvals(turns[known])).max(axis=1) - 1.0) <= ROUNDING
    return result, turns


def _same(P: Map, axes: Mapping[str, Floats]) -> Floats:
    """Return by how much points of one attractor differ at most."""
    extents = np.array([np.ptp(axes[name]) if name in axes else 0.0 for name in P.coordinates])
    same: Floats = SAME * np.maximum(extents, np.array([high - low for low, high in P.box]))
    return same


def _finish_work(P: Map, axes: Mapping[str, Floats], preimages: int, result: xr.Dataset) -> float:
    """Return about how many steps :func:`_with_attractors` takes: states are compared with one of each attractor."""
    period, words = result["reached_period"].values.ravel(), result["reached_word"].values.ravel()
    points = result["reached_point"].values.reshape(-1, P.dimension)
    with np.errstate(all="ignore"):
        places = np.where((period < 1)[:, None], 0.0, np.floor(points / _same(P, axes)))
    _texts, code = np.unique(words.astype(np.str_), return_inverse=True)
    kinds = np.unique(np.column_stack([period, code, places]), axis=0)
    return 0.01 * len(period) * len(kinds) + float(CURVE) * 2.0 ** min(preimages, 400)


def _with_attractors(P: Map, axes: Mapping[str, Floats], preimages: int, result: xr.Dataset) -> xr.Dataset:
    """Replace what each state reached by tables of the attractors, and add what the whole grid says."""
    from grazing.late import xarray as xr

    period, words = result["reached_period"].values, result["reached_word"].values
    points = result["reached_point"].values.reshape(-1, P.dimension)
    which, rows = attractors_of(period.ravel(), words.ravel(), points, _same(P, axes), partial(_neutral, P))
    grid = which.reshape(period.shape)
    state = labels.units(P, *P.coordinates)
    table: dict[str, Any] = {
        "basin": (tuple(axes), grid.astype(np.int32), {"long_name": "attractor that is reached, a row of the tables"}),
        "period": ("attractor", np.array([row.period for row in rows], np.int32), result["reached_period"].attrs),
        "word": ("attractor", np.array([row.word for row in rows], object), result["reached_word"].attrs),
        "neutral": (
            "attractor",
            np.array([row.neutral for row in rows], np.int8),
            {"long_name": "whether the largest multiplier has modulus 1: all such orbits of a word are one row"},
        ),
        "fraction": (
            "attractor",
            np.array([row.orbits for row in rows]) / grid.size,
            {"long_name": "share of the grid", "units": "1"},
        ),
        "point": (
            ("attractor", "coordinate"),
            np.array([row.point for row in rows]),
            {"long_name": "a point of the attractor", "units": state},
        ),
    }
    kept = result.drop_vars(["reached_period", "reached_word", "reached_point"])
    plane = len(axes) == 2 and all(np.ptp(values) > 0.0 for values in axes.values())
    if P.model is not None and P.section == "strobe" and plane:
        ends = [(float(axes[name].min()), float(axes[name].max())) for name in P.coordinates]
        curve, order = grazing_arrays(P.model, P.params["phase"], preimages, CURVE, box=ends)
        table["graze"] = (
            ("graze_point", "coordinate"),
            curve,
            {"long_name": "states that touch the wall within a period, and their preimages", "units": state},
        )
        table["graze_order"] = ("graze_point", order.astype(np.int32), {"long_name": "order of the preimage"})
    done = xr.Dataset({**kept.data_vars, **table}, kept.coords, kept.attrs)
    even = all(evenly_spaced(values) for values in axes.values())
    return done.assign_attrs(basin_entropy(grid, even) | uncertainty(grid, even))
