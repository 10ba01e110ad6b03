"""Lyapunov exponents: how fast nearby orbits part or meet, with the saltation at every impact."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from grazing.kernel.compile import call
from grazing.maps.columns import Columns
from grazing.maps.derivative import STEP
from grazing.maps.map import Map
from grazing.outcome import AMBIGUOUS, FATAL, InputError
from grazing.parameter import checked_name, whole
from grazing.studies import labels
from grazing.studies.classify import AMBIGUOUS_TRUST, ENDED, settled_columns
from grazing.studies.differences import error_of_cycles
from grazing.studies.growth import SMALL, sides_of, stretcher, turned
from grazing.studies.plan import Arrays, Plan, Progress, Variable, planned
from grazing.studies.runs import Runs, checked_map, checked_runs, describe_values, tolerance_config

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: Names of variables and dimensions of the result, which a parameter must not have.
TAKEN = (
    "start", "index", "exponent", "exponent_error", "exponent_per_time", "return_time", "period", "word", "outcome",
    "trust",
)  # fmt: skip
#: Steps in which the frame of deviations turns into place before anything is summed.
WARM = 64
#: Batches whose means tell the statistical error of an exponent.
BATCHES = 20
#: Eigenvalues that are equal but for so many units of rounding are equal.
ROUNDING = 32 * np.finfo(float).eps
#: What rounding may add to every step's logarithm where derivatives are differences.
ROUNDED = np.finfo(float).eps / STEP
#: Logarithm of a multiplier above which a cycle repels: an orbit is on it only to rounding, as 2 x mod 1 comes to 0.
REPELS = 1e-6
#: A step with its derivative takes about so many times as long as one without.
SLOWER = 10
#: Steps of a tile, over all its orbits.
TILE = 100_000


@planned
def lyapunov(
    P: Map,
    name: str | None = None,
    values: ArrayLike | None = None,
    *,
    starts: int | ArrayLike = 10,
    transient: int = 200,
    steps: int = 1000,
    keep: int = 64,
    seed: int = 0,
    threads: int | None = None,
    arithmetic: str = "fast",
    box: Sequence[tuple[float, float]] | None = None,
    progress: Progress | None = None,
) -> Plan:
    """Return the Lyapunov exponents of a map's orbits, at one or many values of a parameter.

    Parameters
    ----------
    P : Map
        Any map; without a ``tangent`` of its own, derivatives are differences and the result *numerical*.
    name, values : str and array_like, optional
        A parameter that varies, with its values; None for the map as it is.
    starts, transient, seed, threads, arithmetic, box, progress
        As in :func:`grazing.orbit_diagram`.
    steps : int
        Steps along which the exponents of an orbit without a period are measured, after ``transient + keep``.
    keep : int
        Steps in which a period is looked for; where there is one, the exponents are those of its multipliers.

    Returns
    -------
    xarray.Dataset
        ``exponent`` on (name, "start", "index"), per step of the map, the greatest first: minus infinity through
        completed chatter or sticking, not a number where an orbit ended or has no derivative (a graze).
        ``exponent_error``, its standard error: 0 for an orbit with a period; else that of the mean of 20 batches of
        the steps, which holds as far as an orbit forgets within a batch, and not a number beside what is not finite.
        It does not see a slow approach: where an orbit nears a neutral one as a power of the steps, as at a period
        doubling, each exponent is that far from its limit, by many errors; more ``transient`` takes it nearer.
        Where derivatives are differences 4e-11 is added for rounding; those of a cycle then have an error, too: what
        rounding and twice the step change, which is much beside a maximum of a map.
        For a map of a model also ``exponent_per_time`` and ``return_time``, the mean time of a step. On (name,
        "start"): ``period``, ``word``, ``outcome`` and ``trust`` as in :func:`grazing.orbit_diagram`. An orbit on a
        cycle that repels is *ambiguous*: rounding has put it there, as 2 x mod 1 takes every double to 0, or holds it.
        Cycles longer than ``keep`` are noticed up to a third of ``steps``, where orbits come back to the last bit.

    References
    ----------
    Saltation: Mueller, Chaos, Solitons and Fractals 5 (1995) 1671-1681. Batch means: Fishman, Management Science 24
    (1978) 510-521.

    Examples
    --------
    >>> import grazing as gz, numpy as np
    >>> from grazing.studies.lyapunov import lyapunov
    >>> found = lyapunov(gz.gap_map(lam=0.5, mu=0.07, l=0.1), starts=1)
    >>> bool(np.isclose(found.exponent[0, 0], np.log(abs(gz.theory.multiplier(3, 0.5, 0.07, 0.1))) / 3, rtol=1e-12))
    True
    """
    checked_map(P)
    if (name is None) != (values is None):
        raise InputError("give a parameter's name with its values, or neither of them")
    axes = {} if name is None else {checked_name(name, P.params, P.name or "the map"): values}
    runs = checked_runs(P, axes, starts, transient, keep, seed, arithmetic, box, TAKEN)  # type: ignore[arg-type]
    steps, lanes = whole(steps, "steps", 1), runs.settings.lanes

    return Plan(
        P=P,
        title=f"Lyapunov exponents of the {P.name}" + (f" in {name}" if name else ""),
        config={
            "study": "lyapunov",
            **({} if name is None else {"parameter": name, "values": describe_values(runs.axes[name])}),
            "steps": steps,
            "warm": WARM,
            **runs.config,
            **tolerance_config(runs.settings.keep),
        },
        axes=runs.axes,
        axis_attrs={name: labels.quantity(P, name) for name in runs.axes},
        sizes={"start": lanes, "index": P.dimension},
        variables=_variables(P, runs.settings.keep),
        compute=partial(_compute, runs, steps),
        together=max(1, runs.together // 8),
        work=runs.work + SLOWER * lanes * steps,
        working=2 * runs.kept_size,  # letters once more, and deviations
    )


plan = lyapunov.plan


def _compute(runs: Runs, steps: int, cells: Ints, arrays: Arrays) -> Iterator[None]:
    """Compute cells, see :class:`grazing.studies.plan.Plan`."""
    found: Columns | None = None
    for found in runs.columns(cells):
        if found is None:
            yield
    assert found is not None
    P, rows = runs.P, runs.rows(cells)
    settled = settled_columns(P, rows, found)
    arrays["period"][...], arrays["word"][...] = settled.period, settled.words
    arrays["trust"][...], arrays["outcome"][...] = settled.trust, found.outcomes[:, 0]
    arrays["exponent"][...], arrays["exponent_error"][...] = np.nan, np.nan
    if P.origin.clock is not None:
        arrays["return_time"][...] = np.nan
    for part in (settled.period > 0, (settled.period <= 0) & (settled.period != ENDED)):
        q, j = np.nonzero(part)
        if q.size:
            many = settled.period[part] if settled.period[part][0] > 0 else None
            seen = found.points[q, -1, :, j], found.letters[q, :, j]
            yield from _measure(P, rows[q], *seen, many, steps, part, arrays)
            if many is not None and by_differences(P):
                last = found.points[q, :, :, j]
                doubt = error_of_cycles(P, rows[q], last, many.astype(np.int64), runs.settings.arithmetic)
                known = np.isfinite(arrays["exponent"][part])
                arrays["exponent_error"][part] = np.where(known, np.maximum(doubt, ROUNDED), np.nan)
    repels = arrays["exponent"][..., 0] * np.maximum(settled.period, 1) > REPELS
    arrays["trust"][repels & ((settled.period > 0) | back(found.points, sides_of(P)))] = AMBIGUOUS_TRUST
    if P.origin.clock is not None:
        arrays["exponent_per_time"][...] = arrays["exponent"] / arrays["return_time"][..., None]


def by_differences(P: Map) -> bool:
    """Return whether a map's derivatives are differences."""
    return P.tangent is None and P.origin.derivative is None


def back(points: Floats, sides: Floats) -> NDArray[np.bool_]:
    """Return whether orbits, points (columns, keep, dim, starts), come back to their last points but for rounding."""
    with np.errstate(invalid="ignore"):  # of what is infinite
        apart = np.abs(points[:, :-1] - points[:, -1:]) / sides[:, None]
    return np.asarray((apart.max(axis=2) <= SMALL).any(axis=1))


def _variables(P: Map, keep: int) -> dict[str, Variable]:
    both = ("start", "index")
    per_step = "Lyapunov exponent per step"
    found = {
        "exponent": Variable(both, "float64", {"long_name": per_step, "units": "1"}),
        "exponent_error": Variable(both, "float64", {"long_name": f"standard error of the {per_step}", "units": "1"}),
    }
    if P.origin.clock is not None:
        time = labels.units(P, "t")
        found["exponent_per_time"] = Variable(
            both,
            "float64",
            {"long_name": "Lyapunov exponent per unit of time", "units": "1" if time == "1" else f"1/{time}"},
        )
        found["return_time"] = Variable(("start",), "float64", {"long_name": "mean time of a step", "units": time})
    return found | {
        "period": Variable(("start",), "int32", labels.period_attributes(keep // 2)),
        "word": Variable(("start",), "text", labels.word_attributes(), labels.longest_word(keep // 2, P.letters)),
        "outcome": Variable(("start",), "int32", labels.outcome_attributes()),
        "trust": Variable(("start",), "int8", labels.trust_attributes()),
    }


def _measure(
    P: Map, rows: Floats, states: Floats, seen: Ints, periods: NDArray[np.int32] | None, steps: int,
    part: NDArray[np.bool_], arrays: Arrays,
) -> Iterator[None]:  # fmt: skip
    """Measure the exponents of single orbits, of given periods or none, and write them to their part of the arrays."""
    if periods is not None:
        exponent, first, last, letters = of_cycles(P, rows, states, seen, periods)
        error = np.where(np.isnan(exponent), np.nan, 0.0)
        many = periods.astype(np.float64)
        yield
    else:
        exponent, error, first, last, letters, outcomes, again = yield from of_orbits(P, rows, states, steps)
        arrays["outcome"][part] |= outcomes
        arrays["period"][part] = np.where(outcomes & FATAL, ENDED, arrays["period"][part])
        doubtful = (again & (exponent[:, 0] > REPELS)) | ((outcomes & AMBIGUOUS) != 0)
        arrays["trust"][part] = np.where(doubtful, AMBIGUOUS_TRUST, arrays["trust"][part])
        many = np.full(len(states), float(steps))
    rounding = ROUNDED if by_differences(P) else 0.0
    arrays["exponent"][part], arrays["exponent_error"][part] = exponent, np.hypot(error, rounding)
    if P.origin.clock is not None:
        for n in np.unique(many):
            here = many == n
            time = P.origin.clock(rows[here], first[here, :, None], last[here, :, None], letters[here, None], int(n))
            arrays["return_time"][tuple(index[here] for index in np.nonzero(part))] = time[:, 0] / n


def of_cycles(
    P: Map, rows: Floats, states: Floats, seen: Ints, periods: NDArray[np.int32]
) -> tuple[Floats, Floats, Floats, Ints]:
    """Return exponents from the multipliers of cycles, the point twice, and the sum of a period's letters.

    ``seen`` are the latest letters of each orbit.

    The least modulus of a multiplier follows from the determinant, a product of scalars: it keeps its digits where
    the matrix itself has lost them.
    """
    n, d = states.shape
    many = periods.astype(np.int64)
    points, turns, logs, letters = turned(P, rows, states, seen, many)
    known = np.isfinite(turns).all(axis=(1, 2))
    moduli = np.full((n, d), np.nan)
    moduli[known] = moduli_of(turns[known])
    with np.errstate(divide="ignore"):
        exponents = completed(np.log(moduli), np.where(known, logs, np.nan))
    return exponents / many[:, None], points, points, letters


def moduli_of(M: Floats) -> Floats:
    """Return the moduli of the eigenvalues of matrices (n, dim, dim), not ordered.

    Of two by two matrices in closed form: a double eigenvalue, as at critical damping, keeps its digits then, which a
    general method loses half of.
    """
    if M.shape[1] != 2:
        return np.asarray(np.abs(np.linalg.eigvals(M)))
    middle, half = 0.5 * (M[:, 0, 0] + M[:, 1, 1]), 0.5 * (M[:, 0, 0] - M[:, 1, 1])
    square, cross = half * half, M[:, 0, 1] * M[:, 1, 0]
    apart = square + cross
    apart = np.where(np.abs(apart) <= ROUNDING * (square + np.abs(cross)), 0.0, apart)
    root = np.sqrt(np.abs(apart))
    pair = np.stack([np.abs(middle) + root, np.abs(np.abs(middle) - root)], axis=1)
    return np.asarray(np.where((apart < 0.0)[:, None], np.hypot(middle, root)[:, None], pair))


def completed(exponents: Floats, total: Floats) -> Floats:
    """Return exponents (n, dim), greatest first, the last one being the known total less the others.

    The others are those of the matrix; its least one is lost to rounding where the matrix is nearly singular.
    """
    ordered = -np.sort(-exponents, axis=1)
    rest = ordered[:, :-1].sum(axis=1)  # minus infinity where the orbit chatters or sticks
    known = np.isfinite(rest) & ~np.isnan(total)
    ordered[known, -1] = total[known] - rest[known]
    return -np.sort(-ordered, axis=1)  # equal ones may have changed places by rounding


def of_orbits(P: Map, rows: Floats, states: Floats, steps: int) -> Any:
    """Measure the exponents of orbits.

    An iterator that returns exponents, their errors, first and last states, letters, outcomes, and which orbits came
    back to a state, to the last bit.
    """
    n, d = states.shape
    derived, who = P.derivative(rows), f"the step of {P.name}"
    entry = stretcher(derived.tangent, derived.prepare, derived.kind, d)
    rows, lanes, unit = derived.rows, np.ascontiguousarray(states)[:, :, None].copy(), sides_of(P)
    frames, areas = np.tile(np.eye(d), (n, 1, 1, 1)), np.zeros((n, 1))
    sums, sides = np.zeros((n, 1, d)), np.ones((n, 1, d))
    letters, outcomes = np.zeros((n, 1), np.int64), np.zeros((n, 1), np.int64)
    marks, spans = lanes.copy(), np.ones((n, 1, 2), np.int64)
    spans[..., 0] = 0
    found = frames, sums, sides, areas, letters, outcomes, marks, spans
    call(entry, rows, unit, lanes, WARM, *found, who=who)
    first, tile = lanes[:, :, 0].copy(), max(1, TILE // n)
    sums[np.isfinite(sums)], sides[...], areas[np.isfinite(areas)], letters[...] = 0.0, 1.0, 0.0, 0
    ends = np.unique(np.linspace(0, steps, BATCHES + 1).astype(np.int64))
    grown, total = np.zeros((len(ends), n, d)), np.zeros((len(ends), n))
    for i, (begin, end) in enumerate(pairwise(ends.tolist()), start=1):
        for done in range(begin, end, tile):
            call(entry, rows, unit, lanes, min(tile, end - done), *found, who=who)
            yield
        grown[i], total[i] = (sums + np.log(sides))[:, 0], areas[:, 0]
    exponents, errors = completed(grown[-1], total[-1]) / steps, errors_of(grown, total, ends)
    return exponents, errors, first, lanes[:, :, 0], letters[:, 0], outcomes[:, 0], spans[:, 0, 1] == 0


def errors_of(grown: Floats, total: Floats, ends: Ints) -> Floats:
    """Return the standard errors (n, dim) of exponents, the greatest first, from the means of batches of steps.

    Parameters
    ----------
    grown : ndarray, shape (batches + 1, n, dim)
        Sums of logarithms after so many batches.
    total : ndarray, shape (batches + 1, n)
        Logarithms of determinants, not a number where they are not known.
    ends : ndarray of int, shape (batches + 1,)
        Steps until then.
    """
    order = np.argsort(-grown[-1], axis=1, kind="stable")
    with np.errstate(invalid="ignore"):  # of what is infinite
        growth, area = np.take_along_axis(np.diff(grown, axis=0), order[None], axis=2), np.diff(total, axis=0)
        growth[..., -1] = np.where(np.isnan(area), growth[..., -1], area - growth[..., :-1].sum(axis=2))
        means, many = growth / np.diff(ends)[:, None, None], len(ends) - 1
        if many < 2:
            return np.full(means.shape[1:], np.nan)
        middle = (
            sum(means) / many
        )  # one after the other: NumPy sums in an order that depends on how many orbits there are
        return np.asarray(np.sqrt(sum((one - middle) ** 2 for one in means) / (many * (many - 1))))
