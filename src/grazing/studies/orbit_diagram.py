"""The orbit diagram: where orbits from many starts settle while one parameter varies."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import lru_cache, partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from grazing.kernel.compile import call, compiled
from grazing.maps.columns import Columns
from grazing.maps.map import Map
from grazing.outcome import InputError, shown
from grazing.parameter import checked_name
from grazing.studies import labels
from grazing.studies.classify import settled_columns
from grazing.studies.plan import Arrays, Plan, Progress, Variable, planned
from grazing.studies.runs import Runs, checked_map, checked_runs, describe_values, tolerance_config

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: Names of variables and dimensions, which neither the parameter nor a coordinate may have.
TAKEN = (
    "start", "n", "letter", "period", "word", "outcome", "trust", "drift", "near_miss", "slowest", "undecided",
    "outside",
)  # fmt: skip
#: How near each orbit came to being another one, see :class:`grazing.maps.columns.Columns`.
NEARNESS = ("near_miss", "slowest", "undecided")
#: Ways to begin at a value where the orbits of its neighbour ended.
SWEEPS = ("up", "down")


@planned
def orbit_diagram(
    P: Map,
    name: str,
    values: ArrayLike,
    starts: int | ArrayLike = 100,
    transient: int = 200,
    keep: int = 50,
    seed: int = 0,
    threads: int | None = None,
    arithmetic: str = "fast",
    box: Sequence[tuple[float, float]] | None = None,
    progress: Progress | None = None,
    *,
    sweep: str | None = None,
) -> Plan:
    """Return where orbits of a map settle while one parameter varies.

    Parameters
    ----------
    P : Map
        Any map.
    name : str
        Which of ``P.params`` varies.
    values : array_like, shape (m,)
        Its values, finite, in any order; the order is kept.
    starts : int or array_like, shape (s, dim)
        How many random starts, drawn anew for every value; or the starts themselves.
    transient, keep : int
        Steps that are thrown away, then steps that are kept.
    seed : int
        Of the random starts. They depend on the seed, the value and their own number alone, so that a value
        computed again, alone or in another range, has the same orbits.
    threads : int, optional
        None for one per processor; the result does not depend on it.
    arithmetic : {"fast", "strict"}
        strict for the same bits on every machine.
    box : sequence of (low, high), optional
        Where random starts are drawn; None for the box of the map at each value.
    progress : callable, optional
        ``progress(done, total)``, called now and then with the number of finished values.
    sweep : {"up", "down"}, optional
        Begin at each value where the orbits of the next smaller ("up") or larger ("down") value ended, so that
        hysteresis shows; the first value has the ``starts``, and so has an orbit that ended or that a moving wall
        overtook. None: every value has its own starts.

    Returns
    -------
    xarray.Dataset
        On the dimensions (name, "start", "n"): one variable per coordinate, and ``letter``, of the step to the
        point. On (name, "start"): ``period`` (0 undecided, -1 aperiodic as far as seen, -2 ended), ``word`` (text),
        ``outcome`` (bits of :class:`grazing.Outcome`, transient included) and ``trust`` (0 certified, 1 numerical,
        2 ambiguous); ``drift``, by how much an orbit with a period moves in one, in sides of the map's box: beside a
        bifurcation it is still on its way to the cycle that its period and word tell of, and a longer ``transient``
        takes it there; ``near_miss``, ``slowest`` and ``undecided``, see :class:`grazing.maps.columns.Columns`. Periods
        up to keep/2 can be seen; the rule is in :mod:`grazing.studies.classify`.

    Raises
    ------
    InputError
        For an input out of range, or a result larger than half of the memory.

    Examples
    --------
    >>> import grazing as gz
    >>> from grazing.studies.orbit_diagram import orbit_diagram
    >>> diagram = orbit_diagram(gz.gap_map(lam=0.5, mu=0.1, l=0.1), "mu", [0.04, 0.07, 0.1], starts=20)
    >>> dict(diagram.sizes)
    {'mu': 3, 'start': 20, 'n': 50}
    >>> diagram.word.sel(mu=0.07)[0].item(), diagram.period.sel(mu=0.07)[0].item()
    ('LLR', 3)
    """
    if sweep is not None and (not isinstance(sweep, str) or sweep not in SWEEPS):
        raise InputError(
            f"sweep = {shown(sweep)}; allowed are 'up', 'down' and None: starts of their own for every value"
        )
    name = checked_name(name, checked_map(P).params, P.name or "the map")
    runs = checked_runs(P, {name: values}, starts, transient, keep, seed, arithmetic, box, TAKEN)
    grid, lanes, keep = runs.axes[name], runs.settings.lanes, runs.settings.keep
    config = {
        "study": "orbit_diagram",
        "parameter": name,
        "values": describe_values(grid),
        **runs.config,
        **tolerance_config(keep),
    }

    return Plan(
        P=P,
        title=f"orbit diagram of the {P.name} in {name}",
        config=config | ({} if sweep is None else {"sweep": sweep}),
        axes=runs.axes,
        axis_attrs={name: labels.quantity(P, name)},
        sizes={"start": lanes, "n": keep},
        variables=_variables(P, keep) | runs.variables,
        compute=partial(_compute, runs, name, sweep),
        together=runs.together,
        work=runs.work,
        working=runs.kept_size,
        sequential=sweep is not None,
    )


plan = orbit_diagram.plan


def _compute(runs: Runs, name: str, sweep: str | None, cells: Ints, arrays: Arrays) -> Iterator[None]:
    """Compute cells, see :class:`grazing.studies.plan.Plan`."""
    if sweep is None:
        yield from _fill(runs, cells, arrays, slice(0, len(cells)), None)
        return
    P, grid, lanes = runs.P, runs.axes[name], runs.settings.lanes
    order = np.argsort(grid[cells], kind="stable")
    order = order if sweep == "up" else order[::-1]
    states = np.full((1, P.dimension, lanes), np.nan)
    for i in order.tolist():
        at = {**P.params, name: float(grid[cells[i]])}
        allowed = [_allowed(P, state, at) for state in states[0].T]
        states = np.where(allowed, states, runs.states(cells[i : i + 1]))
        yield from _fill(runs, cells[i : i + 1], arrays, slice(i, i + 1), states)


def _allowed(P: Map, state: Floats, params: Mapping[str, float]) -> bool:
    """Return whether an orbit may begin at a state: not where one ended, nor where a wall has moved."""
    if not np.isfinite(state).all():
        return False
    try:
        P.origin.check(tuple(state.tolist()), params)
    except InputError:
        return False
    return True


def _variables(P: Map, keep: int) -> dict[str, Variable]:
    both, nearness = ("start", "n"), labels.nearness_attributes(P)
    drift = {"long_name": "change of the last point in the last period, in sides of the box", "units": "1"}
    points = {name: Variable(both, "float64", labels.quantity(P, name)) for name in P.coordinates}
    return points | {
        "letter": Variable(both, "int32", labels.letter_attributes(P)),
        "period": Variable(("start",), "int32", labels.period_attributes(keep // 2)),
        "word": Variable(("start",), "text", labels.word_attributes(), labels.longest_word(keep // 2, P.letters)),
        "outcome": Variable(("start",), "int32", labels.outcome_attributes()),
        "trust": Variable(("start",), "int8", labels.trust_attributes()),
        "drift": Variable(("start",), "float64", drift),
        "near_miss": Variable(("start",), "float64", nearness["near_miss"]),
        "slowest": Variable(("start",), "float64", nearness["slowest"]),
        "undecided": Variable(("start",), "int32", nearness["undecided"]),
    }


def _fill(runs: Runs, cells: Ints, arrays: Arrays, part: slice, states: Floats | None) -> Iterator[None]:
    """Compute cells and write them to a part of the arrays; given states are replaced by the last ones."""
    found: Columns | None = None
    for found in runs.columns(cells, states):
        if found is None:
            yield
    assert found is not None
    for j, coordinate in enumerate(runs.P.coordinates):
        call(compiled_turning(), found.points, j, arrays[coordinate][part])
    call(compiled_turning(), found.letters[:, :, None], 0, arrays["letter"][part])
    arrays["outcome"][part] = found.outcomes[:, 0]
    runs.say_outside(cells, found.points[:, -1], {name: array[part] for name, array in arrays.items()})
    settled = settled_columns(runs.P, runs.rows(cells), found)
    arrays["period"][part], arrays["trust"][part] = settled.period, settled.trust
    arrays["word"][part] = settled.words
    arrays["drift"][part] = drift_of(found.points, settled.period, runs.boxes(cells))
    for name in NEARNESS:
        arrays[name][part] = getattr(found, name)


def drift_of(points: Floats, period: NDArray[np.int32], boxes: Floats) -> Floats:
    """Return how far last points are from those a period earlier, in sides of the box; not a number without a period.

    ``points`` (columns, keep, dim, starts), ``period`` (columns, starts), ``boxes`` (columns, dim, 2) where starts lie:
    that of the map depends on values that vary, which a recipe does not keep.
    """
    known = period > 0
    before = points.shape[1] - 1 - np.where(known, period, 0)
    with np.errstate(invalid="ignore"):  # of orbits without a period, which may be infinite
        change = points[:, -1] - np.take_along_axis(points, before[:, None, None], axis=1)[:, 0]
    sides = boxes[:, :, 1] - boxes[:, :, 0]
    return np.where(known, np.abs(change / sides[:, :, None]).max(axis=1), np.nan)


def turned(values: Any, i: int, out: Any) -> None:
    """Write coordinate i of values (columns, keep, dim, starts) to ``out`` (columns, starts, keep)."""
    columns, keep, _dimension, starts = values.shape
    for q in range(columns):
        for j in range(starts):
            for n in range(keep):
                out[q, j, n] = values[q, n, i, j]


@lru_cache(maxsize=1)
def compiled_turning() -> Any:
    """Return :func:`turned`, compiled."""
    return compiled(turned, "strict")
