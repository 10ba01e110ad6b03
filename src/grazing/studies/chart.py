"""The chart: what orbits settle on as two parameters vary, the attractors of every cell with their shares."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from grazing.kernel.compile import call, compiled
from grazing.maps.columns import Columns
from grazing.maps.map import Map
from grazing.outcome import InputError
from grazing.parameter import whole
from grazing.studies import labels
from grazing.studies.classify import APERIODIC, CERTIFIED, ENDED, UNDECIDED, Settled, settled_columns
from grazing.studies.growth import grower
from grazing.studies.plan import Arrays, Plan, Progress, Variable, run_plan
from grazing.studies.runs import Runs, checked_map, checked_runs, describe_values, tolerance_config

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: Names of variables and dimensions, which a parameter must not have.
TAKEN = ("rank", "period", "word", "share", "exponent", "outcome", "trust")
#: The period of a rank that no attractor holds.
UNUSED = -3


def chart(
    P: Map,
    params: Mapping[str, ArrayLike],
    *,
    starts: int | ArrayLike = 8,
    transient: int = 500,
    keep: int = 64,
    exponent_steps: int = 500,
    seed: int = 0,
    threads: int | None = None,
    arithmetic: str = "fast",
    box: Sequence[tuple[float, float]] | None = None,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Return what orbits of a map settle on as two parameters vary.

    Parameters
    ----------
    P : Map
        Any map.
    params : mapping of str to array_like
        Two of ``P.params`` with their values; the first is the horizontal axis of a figure.
    starts, transient, keep, seed, threads, arithmetic, box
        As in :func:`grazing.orbit_diagram`; periods up to keep/2 can be seen.
    exponent_steps : int
        Steps along which the exponent of an attractor without a period is measured.
    progress : callable, optional
        ``progress(done, total)``, with numbers of cells.

    Returns
    -------
    xarray.Dataset
        On the dimensions of the parameters, in the order given, and "rank", from the attractor that most starts reach
        to the one that fewest do: ``period`` (0 undecided: no period up to keep/2 was seen, yet nearby orbits meet, so
        that a longer transient or keep may show one; -1 aperiodic as far as seen, -2 ended, -3 no further attractor),
        ``word``, ``share`` of the starts, ``exponent``, the largest Lyapunov exponent per step (minus infinity through
        completed chatter or sticking, not a number for orbits that ended), ``outcome`` and ``trust``, of all its orbits
        together. Attractors of the same word and period are one.

    Raises
    ------
    InputError
        For an input out of range, or a result larger than half of the memory.

    Examples
    --------
    >>> import grazing as gz
    >>> from grazing.studies.chart import chart
    >>> found = chart(gz.gap_map(lam=0.5, mu=0.1, l=0.1), {"mu": [0.043, 0.07], "l": [0.1, 0.2]})
    >>> found.word.sel(mu=0.07, l=0.1).values[:2].tolist(), found.share.sel(mu=0.07, l=0.1).values[0].item()
    (['LLR', ''], 1.0)
    """
    made = plan(
        P, params, starts=starts, transient=transient, keep=keep, exponent_steps=exponent_steps, seed=seed,
        arithmetic=arithmetic, box=box,
    )  # fmt: skip
    return run_plan(made, threads, progress)


def plan(
    P: Map,
    params: Mapping[str, ArrayLike],
    *,
    starts: int | ArrayLike = 8,
    transient: int = 500,
    keep: int = 64,
    exponent_steps: int = 500,
    seed: int = 0,
    arithmetic: str = "fast",
    box: Sequence[tuple[float, float]] | None = None,
) -> Plan:
    """Return the plan of a chart, see :func:`chart`."""
    checked_map(P)
    if not isinstance(params, Mapping) or len(params) != 2:
        raise InputError(f"params is {params!r}; give two parameters with their values, such as {{'d': ..., 'V': ...}}")
    runs = checked_runs(P, params, starts, transient, keep, seed, arithmetic, box, TAKEN)
    lanes, steps = runs.settings.lanes, whole(exponent_steps, "exponent_steps", 1)

    def compute(cells: Ints, arrays: Arrays) -> Iterator[None]:
        found: Columns | None = None
        for found in runs.columns(cells):
            if found is None:
                yield
        assert found is not None
        settled = settled_columns(P, runs.rows(cells), found)
        yield
        rank(runs, cells, found, settled, steps, arrays)

    names = " and ".join(runs.axes)
    return Plan(
        P=P,
        title=f"chart of the {P.name} in {names}",
        config={
            "study": "chart",
            "axes": list(runs.axes),
            "parameters": {name: describe_values(values) for name, values in runs.axes.items()},
            "exponent_steps": steps,
            **runs.config,
            **tolerance_config(runs.settings.keep),
        },
        axes=runs.axes,
        axis_attrs={name: labels.quantity(P, name) for name in runs.axes},
        sizes={"rank": lanes},
        variables=_variables(runs.settings.keep),
        compute=compute,
        together=runs.together,
        work=runs.work,
    )


def _variables(keep: int) -> dict[str, Variable]:
    period = labels.period_attributes(keep // 2)
    period["flag_values"] = np.array([0, -1, -2, UNUSED], np.int32)
    period["flag_meanings"] += " no_further_attractor"
    return {
        "period": Variable(("rank",), "int32", period),
        "word": Variable(("rank",), "text", labels.word_attributes(), labels.longest_word(keep // 2)),
        "share": Variable(("rank",), "float64", {"long_name": "share of the starts", "units": "1"}),
        "exponent": Variable(("rank",), "float64", {"long_name": "largest Lyapunov exponent per step", "units": "1"}),
        "outcome": Variable(("rank",), "int32", labels.outcome_attributes()),
        "trust": Variable(("rank",), "int8", labels.trust_attributes()),
    }


def rank(runs: Runs, cells: Ints, found: Columns, settled: Settled, steps: int, arrays: Arrays) -> None:
    """Write the attractors of cells, the one with the greatest share first."""
    shape = settled.period.shape
    count, first = np.zeros(shape, np.int64), np.zeros(shape, np.int64)
    outcome, trust = np.zeros(shape, np.int64), np.zeros(shape, np.int64)
    states = settled.period, settled.key, found.outcomes, settled.trust
    call(compiled_ranking(), *states, count, first, outcome, trust)
    used = count > 0
    period = np.where(used, np.take_along_axis(settled.period, first, 1), UNUSED)
    arrays["period"][...] = period
    arrays["word"][...] = np.where(used, np.take_along_axis(settled.words, first, 1), "")
    arrays["share"][...] = count / shape[1]
    arrays["outcome"][...], arrays["trust"][...] = outcome, np.where(used, trust, CERTIFIED)
    exponent = np.full(shape, np.nan)
    grows = used & (period != ENDED)
    q, _rank = np.nonzero(grows)
    last = found.points[q, -1, :, first[grows]], found.letters[q, :, first[grows]]
    exponent[grows] = exponents(runs, cells[q], *last, period[grows], steps)
    arrays["exponent"][...] = exponent
    arrays["period"][...] = np.where((period == APERIODIC) & (exponent < 0.0), UNDECIDED, period)


def exponents(runs: Runs, cells: Ints, states: Floats, seen: Ints, period: NDArray[np.int32], steps: int) -> Floats:
    """Return the largest exponent per step of orbits on their attractors, one a row of ``states``.

    ``seen`` are the latest letters of each orbit. A cycle is first reached by Newton's method; without a period the
    exponent is the mean over ``steps`` steps.
    """
    P, derived = runs.P, runs.P.derivative(runs.rows(cells))
    entry = grower(derived.tangent, derived.prepare, derived.kind, P.dimension)
    cyclic, result = period > 0, np.empty(len(states))
    many = np.where(cyclic, period, steps).astype(np.int64)
    points, latest = np.ascontiguousarray(states), np.ascontiguousarray(seen)
    call(entry, derived.rows, points, latest, many, cyclic, result, who=f"the step of {P.name}")
    return result


def ranking(
    period: Any, key: Any, outcomes: Any, trusts: Any, count: Any, first: Any, outcome: Any, trust: Any
) -> None:
    """Find the attractors among the orbits (columns, starts) of each column, ordered by how many orbits reach them.

    ``first`` becomes the number of the first orbit on each, which breaks a tie; outcomes are folded, and of trusts
    the worst one counts.
    """
    columns, starts = period.shape
    for q in range(columns):
        found = 0
        for j in range(starts):
            k = 0
            while k < found and not (period[q, first[q, k]] == period[q, j] and key[q, first[q, k]] == key[q, j]):
                k += 1
            if k == found:
                first[q, k] = j
                found += 1
            count[q, k] += 1
            outcome[q, k] |= outcomes[q, 0, j]
            trust[q, k] = max(trust[q, k], trusts[q, j])
        for k in range(1, found):  # insertion keeps the order of equals
            i = k
            while i > 0 and count[q, i] > count[q, i - 1]:
                count[q, i], count[q, i - 1] = count[q, i - 1], count[q, i]
                first[q, i], first[q, i - 1] = first[q, i - 1], first[q, i]
                outcome[q, i], outcome[q, i - 1] = outcome[q, i - 1], outcome[q, i]
                trust[q, i], trust[q, i - 1] = trust[q, i - 1], trust[q, i]
                i -= 1


@lru_cache(maxsize=1)
def compiled_ranking() -> Any:
    """Return :func:`ranking`, compiled."""
    return compiled(ranking, "strict")
