"""Coexistence: all attractors over a range of a parameter, followed by word, with their shares and lifetimes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import lru_cache, partial
from math import prod
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from grazing.kernel.compile import call, compiled
from grazing.maps.columns import Columns
from grazing.maps.map import Map
from grazing.maps.pieces import pieces
from grazing.parameter import checked_name
from grazing.studies import labels
from grazing.studies.changes import changes, work_of
from grazing.studies.classify import settled_columns
from grazing.studies.growth import sides_of
from grazing.studies.plan import Arrays, Plan, Progress, Variable, planned
from grazing.studies.runs import Runs, checked_map, checked_runs, describe_values, tolerance_config

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: Names of variables and dimensions of the result, which a parameter must not have.
TAKEN = (
    "attractor", "start", "coordinate", "change", "period", "word", "share", "lifetime", "reached", "steps", "last",
    "outcome", "trust", "before", "after", "word_before", "word_after", "period_before", "period_after", "kind",
    "outside",
)  # fmt: skip
#: An orbit has settled once it stays this near its cycle, in units of the greatest coordinate it has.
ARRIVED = 1e-6
#: The number of steps of an orbit that settled on no cycle.
NEVER = -1


@planned
def coexistence(
    P: Map,
    name: str,
    values: ArrayLike,
    *,
    starts: int | ArrayLike = 200,
    transient: int = 1000,
    keep: int = 64,
    seed: int = 0,
    threads: int | None = None,
    arithmetic: str = "fast",
    box: Sequence[tuple[float, float]] | None = None,
    progress: Progress | None = None,
) -> Plan:
    """Return all attractors that random starts reach while one parameter varies, with shares and lifetimes.

    Parameters
    ----------
    P : Map
        Any map.
    name, values : str and array_like
        The parameter that varies, and its values; changes are sought between neighbours.
    starts, transient, keep, seed, threads, arithmetic, box, progress
        As in :func:`grazing.orbit_diagram`; periods up to keep/2 can be seen.

    Returns
    -------
    xarray.Dataset
        Tables on the dimension "attractor", in the order of first appearance: ``period`` (0 undecided, -1 aperiodic as
        far as seen, -2 ended) and ``word``. Attractors of the same word and period are one row, such as the two wells
        of a cubic map: shares are those of all, and of changes the first that comes and the last that goes are listed;
        :func:`grazing.basins` tells them apart. On (name, "attractor"): ``share`` of the starts, and ``lifetime``, the
        mean number of steps after which an orbit was last away from its cycle, by more than 1e-6 of the greatest
        coordinate of its start or cycle, in units of the map's box; not a number where there is none. On (name,
        "start"): ``reached``, the row of the table, ``steps``, its lifetime (-1 for none), ``outcome`` and ``trust`` as
        in :func:`grazing.orbit_diagram`.
        On the dimension "change": ``before`` and ``after``, neighbouring values, ``word_before`` and ``word_after``,
        ``period_before`` and ``period_after`` (0 for none), and ``kind``: *appears*, *disappears*, *doubles*, *halves*,
        or *relabelled*, where an impact crosses the strobe: the same orbit, no bifurcation.

    Raises
    ------
    InputError
        For an input out of range, or a result larger than half of the memory.

    Examples
    --------
    >>> import grazing as gz
    >>> from grazing.studies.coexistence import coexistence
    >>> found = coexistence(gz.gap_map(lam=0.5, mu=0.1, l=0.1), "mu", [0.040, 0.043, 0.046], starts=50)
    >>> found.word.values.tolist(), (found.share > 0).values.tolist()
    (['LLLR', 'LLR'], [[True, False], [True, True], [False, True]])
    """
    name = checked_name(name, checked_map(P).params, P.name or "the map")
    runs = checked_runs(P, {name: values}, starts, transient, keep, seed, arithmetic, box, TAKEN)

    return Plan(
        P=P,
        title=f"attractors of the {P.name} in {name}",
        config={
            "study": "coexistence",
            "parameter": name,
            "values": describe_values(runs.axes[name]),
            "arrived": ARRIVED,
            **runs.config,
            **tolerance_config(runs.settings.keep),
        },
        axes=runs.axes,
        axis_attrs={name: labels.quantity(P, name)},
        sizes={"start": runs.settings.lanes, "coordinate": P.dimension},
        coords={"coordinate": ("coordinate", np.array(P.coordinates))},
        variables=_variables(P, runs.settings.keep) | runs.variables,
        compute=partial(_compute, runs),
        together=runs.together,
        work=2 * runs.work,
        working=runs.kept_size,
        finish=partial(_with_attractors, P, name, runs.settings.transient, runs.settings.keep),
        finish_work=partial(_finish_work, name, runs.settings.transient + runs.settings.keep),
    )


plan = coexistence.plan


def _compute(runs: Runs, cells: Ints, arrays: Arrays) -> Iterator[None]:
    """Compute cells, see :class:`grazing.studies.plan.Plan`."""
    found: Columns | None = None
    for found in runs.columns(cells):
        if found is None:
            yield
    assert found is not None
    settled = settled_columns(runs.P, runs.rows(cells), found)
    arrays["reached_period"][...], arrays["reached_word"][...] = settled.period, settled.words
    arrays["outcome"][...], arrays["trust"][...] = found.outcomes[:, 0], settled.trust
    runs.say_outside(cells, found.points[:, -1], arrays)
    arrays["last"][...] = found.points[:, -1].transpose(0, 2, 1)
    arrays["steps"][...] = yield from lifetimes(runs, cells, found, settled.period)


def _variables(P: Map, keep: int) -> dict[str, Variable]:
    never = {"flag_values": np.array([NEVER], np.int64), "flag_meanings": "settled_on_no_cycle"}
    return {
        "reached_period": Variable(("start",), "int32", labels.period_attributes(keep // 2)),
        "reached_word": Variable(
            ("start",), "text", labels.word_attributes(), labels.longest_word(keep // 2, P.letters)
        ),
        "last": Variable(("start", "coordinate"), "float64", {"long_name": "last point of the orbit", "units": "1"}),
        "outcome": Variable(("start",), "int32", labels.outcome_attributes()),
        "trust": Variable(("start",), "int8", labels.trust_attributes()),
        "steps": Variable(("start",), "int64", {"long_name": "steps before it settled", "units": "1", **never}),
    }


def lifetimes(runs: Runs, cells: Ints, found: Columns, period: NDArray[np.int32]) -> Any:
    """Fly orbits again from their starts beside the cycles they ended on; an iterator that returns their lifetimes.

    Those that are on no cycle stay where they are: what ended them has been said. The same steps give the same bits, so
    each point can be compared with the point of the cycle of its own turn.
    """
    steps = runs.settings.transient + runs.settings.keep
    cycles, result = np.ascontiguousarray(found.points), np.zeros(period.shape, np.int64)
    n, lanes, rows = 0, runs.states(cells), runs.rows(cells)
    # a position and a velocity have no common unit: each has the side of the box, where the orbit does not go farther
    size = np.maximum(np.abs(cycles).max(axis=1), np.abs(lanes))
    unit = np.maximum(size, sides_of(runs.P)[:, None])
    with np.errstate(invalid="ignore"):  # of orbits that ended
        near = ARRIVED * unit * (size / unit).max(axis=1, keepdims=True)
    lanes[np.broadcast_to((period < 1)[:, None], lanes.shape)] = np.nan
    for part in pieces(runs.P, rows, lanes, 0, steps, runs.settings.arithmetic):
        call(compiled_arrival(), part.points, cycles, period, near, n, steps, result)
        n += part.points.shape[1]
        yield
    return np.where(period > 0, result, NEVER)


def arrival(points: Any, cycles: Any, period: Any, near: Any, done: int, total: int, last: Any) -> None:
    """Write to ``last`` how many steps each orbit had made when it was last away from its cycle.

    ``points`` (columns, steps, dim, n) are those of the steps after ``done`` of ``total``; ``cycles`` (columns, keep,
    dim, n) the last ones of all; within ``near`` (columns, dim, n) is not away.
    """
    columns, steps, dimension, lanes = points.shape
    keep = cycles.shape[1]
    for q in range(columns):
        for j in range(lanes):
            N = period[q, j]
            if N < 1:
                continue
            for i in range(dimension):
                for n in range(steps):
                    k = keep - 1 - (total - 1 - done - n) % N
                    if not abs(points[q, n, i, j] - cycles[q, k, i, j]) <= near[q, i, j]:
                        last[q, j] = max(last[q, j], done + n + 1)


@lru_cache(maxsize=1)
def compiled_arrival() -> Any:
    """Return :func:`arrival`, compiled."""
    return compiled(arrival, "strict")


def _reached(result: xr.Dataset) -> tuple[NDArray[np.int32], NDArray[np.int32], NDArray[np.object_]]:
    """Return which attractor each start reached, and the table of these: periods and words."""
    both = zip(result["reached_period"].values.flat, result["reached_word"].values.flat, strict=True)
    known: dict[tuple[int, str], int] = {}  # few, in the order in which they come; of each start its number alone
    codes = (known.setdefault((int(N), word), len(known)) for N, word in both)
    shape = result["reached_period"].shape
    reached = np.fromiter(codes, np.int32, prod(shape)).reshape(shape)
    period = np.array([N for N, _word in known], np.int32)
    words = np.array([word for _N, word in known], object)
    return reached, period, words


def _finish_work(name: str, steps: int, result: xr.Dataset) -> float:
    """Return about how many steps :func:`_with_attractors` takes."""
    reached, period, _words = _reached(result)
    return work_of(result[name].values, reached, period, steps) + 0.01 * reached.size * len(period)


def _with_attractors(P: Map, name: str, transient: int, keep: int, result: xr.Dataset) -> xr.Dataset:
    """Replace what each start reached by a table of the attractors, and add shares, lifetimes and changes."""
    values, steps = result[name].values, result["steps"].values
    reached, period, words = _reached(result)
    share, lifetime = np.zeros((len(values), len(period))), np.full((len(values), len(period)), np.nan)
    for k in range(len(period)):
        here = reached == k
        share[:, k] = here.mean(axis=1)
        some = here.any(axis=1) & (period[k] > 0)
        total = np.where(here, steps, 0).sum(axis=1)
        lifetime[some, k] = total[some] / here.sum(axis=1)[some]
    found = changes(P, name, values, reached, period, words, result["last"].values, transient, keep)
    fields = {
        "before": f"{name} before the change",
        "after": f"{name} after the change",
        "word_before": "word before the change",
        "word_after": "word after the change",
        "period_before": "period before the change",
        "period_after": "period after the change",
        "kind": "what happens to the attractor",
    }
    table: dict[str, Any] = {
        "period": ("attractor", period, result["reached_period"].attrs),
        "word": ("attractor", words, result["reached_word"].attrs),
        "share": ((name, "attractor"), share, {"long_name": "share of the starts", "units": "1"}),
        "lifetime": ((name, "attractor"), lifetime, {"long_name": "mean steps before settling", "units": "1"}),
        "reached": ((name, "start"), reached, {"long_name": "attractor, a row of the table"}),
    }
    for field, meaning in fields.items():
        column = [getattr(change, field) for change in found]
        kind = {"before": float, "after": float}.get(field, np.int32 if field.startswith("period") else object)
        about = {"units": result[name].attrs.get("units", "1")} if kind is float else {}
        table[field] = ("change", np.array(column, kind), {"long_name": meaning, **about})
    return result.drop_vars(["reached_period", "reached_word", "last", "coordinate"]).assign(table)
