"""The orbit diagram: where orbits from many starts settle while one parameter varies."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from grazing.kernel.compile import FLAGS
from grazing.maps.columns import Columns
from grazing.maps.map import Map
from grazing.memory import refuse_too_large
from grazing.outcome import InputError
from grazing.parameter import unknown, whole
from grazing.studies import labels
from grazing.studies.cells import Progress, run_cells
from grazing.studies.classify import FLOOR, TOLERANCE, classify
from grazing.studies.starts import checked_box, checked_seed, checked_starts, random_starts

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]

#: Names of variables and dimensions, which neither the parameter nor a coordinate may have.
TAKEN = ("start", "n", "letter", "period", "word", "outcome", "trust", "near_miss", "slowest", "undecided")
#: How near each orbit came to being another one, see :class:`grazing.maps.columns.Columns`.
NEARNESS = ("near_miss", "slowest", "undecided")
#: Orbits that are computed together.
TOGETHER = 512


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
) -> xr.Dataset:
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

    Returns
    -------
    xarray.Dataset
        On the dimensions (name, "start", "n"): one variable per coordinate, and ``letter``, of the step to the
        point. On (name, "start"): ``period`` (0 undecided, -1 aperiodic as far as seen, -2 ended), ``word`` (text),
        ``outcome`` (bits of :class:`grazing.Outcome`, transient included) and ``trust`` (0 certified, 1 numerical,
        2 ambiguous); ``near_miss``, ``slowest`` and ``undecided``, see :class:`grazing.maps.columns.Columns`. Periods
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
    plan = _checked(P, name, values, starts, transient, keep, seed, arithmetic, box)
    arrays = _empty(plan)
    words: list[NDArray[np.str_]] = [np.empty(0, np.str_)] * len(plan.maps)

    together = max(1, TOGETHER // plan.lanes)

    def tile(k: int) -> None:
        first = k * together
        found = _orbits(plan, first, min(first + together, len(plan.maps)))
        for q in range(len(found.points)):
            i = first + q
            for j, coordinate in enumerate(P.coordinates):
                arrays[coordinate][i] = found.points[q, :, j].T
            arrays["letter"][i] = found.letters[q].T
            arrays["outcome"][i] = outcome = found.outcomes[q, 0]
            arrays["period"][i], words[i], arrays["trust"][i] = classify(
                plan.maps[i], found.points[q], found.letters[q], outcome
            )
            for name in NEARNESS:
                arrays[name][i] = getattr(found, name)[q]

    def finished(done: int, _total: int) -> None:
        if progress is not None:
            progress(min(done * together, len(plan.maps)), len(plan.maps))

    run_cells(tile, -(-len(plan.maps) // together), threads, finished)
    return _labelled(plan, arrays | {"word": np.array(words)})


class _Plan(NamedTuple):
    """Checked input: the map at every value, and what is the same for all of them."""

    P: Map
    name: str
    values: Floats
    maps: list[Map]
    starts: int | Floats
    transient: int
    keep: int
    seed: int
    arithmetic: str
    box: tuple[tuple[float, float], ...] | None

    @property
    def lanes(self) -> int:
        return self.starts if isinstance(self.starts, int) else len(self.starts)


def _checked(
    P: Map,
    name: str,
    values: ArrayLike,
    starts: int | ArrayLike,
    transient: int,
    keep: int,
    seed: int,
    arithmetic: str,
    box: Sequence[tuple[float, float]] | None,
) -> _Plan:
    if not isinstance(P, Map):
        raise InputError(f"the first argument is {P!r}; give a map, such as gz.stroboscopic_map(model)")
    if name not in P.params:
        raise unknown(name, P.params, P.name or "the map")
    for clash in {name, *P.coordinates} & {*TAKEN} | {name} & {*P.coordinates}:
        raise InputError(f"{clash!r} names a dimension or variable of the result; rename it in the map")
    if arithmetic not in FLAGS:
        raise InputError(f"arithmetic is {arithmetic!r}; allowed are 'strict' and 'fast'")
    grid = _checked_values(name, values)
    plan = _Plan(
        P,
        name,
        grid,
        [],
        checked_starts(starts, P.coordinates),
        whole(transient, "transient", 0),
        whole(keep, "keep", 1),
        checked_seed(seed),
        arithmetic,
        None if box is None else checked_box(box, P.coordinates),
    )
    size = len(grid) * plan.lanes * (plan.keep * (8 * P.dimension + 4) + 96)
    refuse_too_large(size, f"reduce values ({len(grid)}), starts ({plan.lanes}) or keep ({plan.keep})")
    maps = [P.replace(**{name: value}) for value in grid.tolist()]
    if P.check is not None and not isinstance(plan.starts, int):
        for at in maps:
            for start in plan.starts:
                P.check(start, at.params)
    return plan._replace(maps=maps)


def _checked_values(name: str, values: ArrayLike) -> Floats:
    wanted = f"give finite values of {name} in a list or a one-dimensional array"
    try:
        grid = np.array(values, np.float64)
    except (TypeError, ValueError):
        raise InputError(f"values are not numbers: {values!r}; {wanted}") from None
    if grid.ndim != 1 or not grid.size:
        raise InputError(f"values have shape {grid.shape}; {wanted}")
    if not np.isfinite(grid).all():
        i = int(np.flatnonzero(~np.isfinite(grid))[0])
        raise InputError(f"values[{i}] = {grid[i]} is not finite; {wanted}")
    return grid


def _orbits(plan: _Plan, first: int, last: int) -> Columns:
    """Compute the cells from first to last."""
    maps = plan.maps[first:last]
    if isinstance(plan.starts, int):
        cells = zip(plan.values[first:last], maps, strict=True)
        lanes = np.stack([random_starts(plan.seed, (x,), plan.starts, plan.box or P.box) for x, P in cells])
    else:
        lanes = np.tile(plan.starts.T, (len(maps), 1, 1))  # they are overwritten, and every cell needs its own
    rows = np.array([list(P.params.values()) for P in maps])
    return plan.P.run_columns(rows, lanes, plan.transient, plan.keep, arithmetic=plan.arithmetic, threads=1)


def _empty(plan: _Plan) -> dict[str, Any]:
    shape = (len(plan.maps), plan.lanes)
    arrays: dict[str, Any] = {coordinate: np.empty((*shape, plan.keep)) for coordinate in plan.P.coordinates}
    arrays["letter"] = np.empty((*shape, plan.keep), np.int32)
    kinds: dict[str, Any] = {"period": np.int32, "outcome": np.int32, "trust": np.int8}
    kinds |= {"near_miss": np.float64, "slowest": np.float64, "undecided": np.int32}
    return arrays | {name: np.empty(shape, kind) for name, kind in kinds.items()}


def _labelled(plan: _Plan, arrays: dict[str, Any]) -> xr.Dataset:
    import xarray as xr

    P = plan.P
    attributes = {coordinate: labels.quantity(P, coordinate) for coordinate in P.coordinates} | {
        "letter": labels.letter_attributes(P),
        "period": labels.period_attributes(plan.keep // 2),
        "word": labels.word_attributes(),
        "outcome": labels.outcome_attributes(),
        "trust": labels.trust_attributes(),
        **labels.nearness_attributes(),
    }
    dims = (plan.name, "start", "n")
    data = {name: (dims[: arrays[name].ndim], arrays[name], attributes[name]) for name in attributes}
    axis = {plan.name: (plan.name, plan.values, labels.quantity(P, plan.name))}
    return xr.Dataset(data, axis, labels.document(P, f"orbit diagram of the {P.name} in {plan.name}", _config(plan)))


def _config(plan: _Plan) -> dict[str, Any]:
    """Return all that decides the numbers; the swept parameter's own value in the map does not."""
    if isinstance(plan.starts, int):
        starts: dict[str, Any] = {"random": plan.starts, "seed": plan.seed}
        starts["box"] = plan.P.box if plan.box is None else plan.box
    else:
        starts = {"given": len(plan.starts), "sha256": labels.fingerprint(plan.starts)}
    return {
        "study": "orbit_diagram",
        "parameter": plan.name,
        "values": {
            "first": plan.values[0],
            "last": plan.values[-1],
            "count": plan.values.size,
            "sha256": labels.fingerprint(plan.values),
        },
        "params": {name: value for name, value in plan.P.params.items() if name != plan.name},
        "starts": starts,
        "transient": plan.transient,
        "keep": plan.keep,
        "arithmetic": plan.arithmetic,
        "tolerance": {"relative": TOLERANCE, "floor": FLOOR},
        "period_limit": plan.keep // 2,
    }
