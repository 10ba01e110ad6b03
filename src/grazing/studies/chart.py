"""The chart: what orbits settle on as two parameters vary, the attractors of every cell with their shares."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import lru_cache, partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from grazing.kernel.compile import call, compiled
from grazing.kernel.primitives import inlined
from grazing.maps.columns import Columns
from grazing.maps.map import Map
from grazing.outcome import InputError, shown
from grazing.parameter import whole
from grazing.studies import labels
from grazing.studies.classify import APERIODIC, CERTIFIED, ENDED, UNDECIDED, Settled, settled_columns
from grazing.studies.growth import grower, sides_of
from grazing.studies.plan import Arrays, Plan, Progress, Variable, planned
from grazing.studies.runs import Runs, checked_map, checked_runs, describe_values, tolerance_config

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: Most steps along which an exponent of a cell is averaged.
MOST_STEPS = 10**6
#: Names of variables and dimensions, which a parameter must not have.
TAKEN = ("rank", "period", "word", "share", "exponent", "outcome", "trust", "outside")
#: The period of a rank that no attractor holds.
UNUSED = -3


@planned
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
) -> Plan:
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
        Steps along which the exponent of an attractor without a period is measured, 1 to 1,000,000.
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
    checked_map(P)
    if not isinstance(params, Mapping) or len(params) != 2:
        raise InputError(
            f"params is {shown(params)}; give two parameters with their values, such as {{'d': ..., 'V': ...}}"
        )
    runs = checked_runs(P, params, starts, transient, keep, seed, arithmetic, box, TAKEN)
    lanes, steps = runs.settings.lanes, whole(exponent_steps, "exponent_steps", 1)
    if steps > MOST_STEPS:
        raise InputError(
            f"exponent_steps = {steps}; allowed is a whole number from 1 to {MOST_STEPS}: they are done in one go, "
            "which cannot be stopped; gz.lyapunov takes more"
        )

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
        variables=_variables(P, runs.settings.keep) | runs.variables,
        compute=partial(_compute, runs, steps),
        together=runs.together,
        work=runs.work,
        working=runs.kept_size,
    )


plan = chart.plan


def _compute(runs: Runs, steps: int, cells: Ints, arrays: Arrays) -> Iterator[None]:
    """Compute cells, see :class:`grazing.studies.plan.Plan`."""
    found: Columns | None = None
    for found in runs.columns(cells):
        if found is None:
            yield
    assert found is not None
    P = runs.P
    runs.say_outside(cells, found.points[:, -1], arrays)
    settled = settled_columns(P, runs.rows(cells), found)
    yield
    first = rank(settled, found.outcomes, arrays)
    yield
    grow(P, runs.rows(cells), found, first, steps, arrays)


def _variables(P: Map, keep: int) -> dict[str, Variable]:
    period = labels.period_attributes(keep // 2)
    period["flag_values"] = np.array([0, -1, -2, UNUSED], np.int32)
    period["flag_meanings"] += " no_further_attractor"
    return {
        "period": Variable(("rank",), "int32", period),
        "word": Variable(("rank",), "text", labels.word_attributes(), labels.longest_word(keep // 2, P.letters)),
        "share": Variable(("rank",), "float64", {"long_name": "share of the starts", "units": "1"}),
        "exponent": Variable(("rank",), "float64", {"long_name": "largest Lyapunov exponent per step", "units": "1"}),
        "outcome": Variable(("rank",), "int32", labels.outcome_attributes()),
        "trust": Variable(("rank",), "int8", labels.trust_attributes()),
    }


def rank(settled: Settled, outcomes: Ints, arrays: Arrays) -> Ints:
    """Write the attractors of cells, the one with the greatest share first; return the first orbit on each."""
    shape = settled.period.shape
    code, first = np.empty(shape, np.int32), np.empty(shape, np.int64)
    names = "period", "share", "outcome", "trust"
    states = settled.period, settled.code, outcomes, settled.trust
    call(compiled_ranking(), *states, *(arrays[name] for name in names), code, first)
    arrays["word"][...] = settled.texts[code]
    return first


def grow(P: Map, rows: Floats, found: Columns, first: Ints, steps: int, arrays: Arrays) -> None:
    """Write the largest exponent per step of the attractors of cells, from the first orbit on each.

    A cycle is first reached by Newton's method; without a period the exponent is the mean over ``steps`` steps.
    """
    period, exponent = arrays["period"], arrays["exponent"]
    exponent[...] = np.nan
    q, ranks = np.nonzero(period > ENDED)
    derived = P.derivative(rows)
    entry = grower(derived.tangent, derived.prepare, derived.kind, P.dimension)
    which = np.ascontiguousarray(np.column_stack([q, ranks, first[q, ranks]]))
    who = f"the step of {P.name}"
    call(entry, derived.rows, sides_of(P), found.points, found.letters, which, period, steps, exponent, who=who)
    period[(period == APERIODIC) & (exponent < 0.0)] = UNDECIDED


@inlined
def exchanged(ranked: Any, q: int, i: int) -> None:
    """Let the attractors of ranks i and i - 1 in column q change places."""
    ranked[q, i], ranked[q, i - 1] = ranked[q, i - 1], ranked[q, i]


def ranking(
    periods: Any, codes: Any, outcomes: Any, trusts: Any, period: Any, share: Any, outcome: Any, trust: Any,
    code: Any, first: Any,
) -> None:  # fmt: skip
    """Find the attractors among the orbits (columns, starts) of each column, ordered by how many orbits reach them.

    ``first`` becomes the number of the first orbit on each, which breaks a tie; outcomes are folded, and of trusts
    the worst one counts.
    """
    columns, starts = periods.shape
    count = np.empty(starts, np.int64)
    for q in range(columns):
        found = 0
        for k in range(starts):
            count[k], first[q, k] = 0, 0
            period[q, k], code[q, k], outcome[q, k], trust[q, k] = UNUSED, 0, 0, CERTIFIED
        for j in range(starts):
            k = 0
            while k < found and not (period[q, k] == periods[q, j] and code[q, k] == codes[q, j]):
                k += 1
            if k == found:
                period[q, k], code[q, k], first[q, k] = periods[q, j], codes[q, j], j
                found += 1
            count[k] += 1
            outcome[q, k] |= outcomes[q, 0, j]
            trust[q, k] = max(trust[q, k], trusts[q, j])
        for k in range(1, found):  # insertion keeps the order of equals
            i = k
            while i > 0 and count[i] > count[i - 1]:
                count[i], count[i - 1] = count[i - 1], count[i]
                exchanged(period, q, i)
                exchanged(code, q, i)
                exchanged(outcome, q, i)
                exchanged(trust, q, i)
                exchanged(first, q, i)
                i -= 1
        for k in range(starts):
            share[q, k] = count[k] / starts


@lru_cache(maxsize=1)
def compiled_ranking() -> Any:
    """Return :func:`ranking`, compiled."""
    return compiled(ranking, "strict")
