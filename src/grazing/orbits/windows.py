"""Windows: the intervals of a parameter on which a stable one-impact orbit of period N exists, with typed edges."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from itertools import pairwise
from math import inf
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from grazing import late
from grazing.memory import refuse_too_large
from grazing.orbits.closure import TESTS, TWO_PI
from grazing.orbits.curves import Curve, Edge, curves, wrapped
from grazing.orbits.exact_edges import before_fold, family_scale, ordered
from grazing.orbits.survey import CLEARANCE, DIP, FIRST_TEST, PHASE, extremum, families
from grazing.orbits.word_windows import PIECES, VALUES, checked_words, piece_words, word_windows
from grazing.oscillator.parameters import damped
from grazing.oscillator.rig import Rig
from grazing.oscillator.spring import refuse_stiffness
from grazing.oscillator.trajectory import refuse_swings
from grazing.outcome import InputError, shown
from grazing.parameter import checked_name, checked_periods, refuse_ends, unknown, value_of, whole
from grazing.pool import Progress, checked_progress

if TYPE_CHECKING:
    import xarray as xr

#: What ends a window, in words.
EDGES = {
    "gr": "graze: a dip of the flight touches the wall",
    "pd": "period doubling: a multiplier reaches -1, of a double that is born there that of the orbit it doubles",
    "lp": "fold: a multiplier reaches +1, the impact phase loses its solution",
    "ns": "Neimark-Sacker: complex multipliers reach the unit circle",
    "v0": "the impact speed reaches 0",
    "law": "the impact speed reaches the trigger",
    "st": "sticking: a ball that the impact leaves at rest is no longer lifted off at once",
    "bp": "branch point: another branch crosses, as where the symmetry of an orbit breaks",
    "end": "end of the span searched",
}
#: Edges that are closer than this share of the parameter are told apart with many digits.
CLOSE = 1e-10
#: Bytes of a cell of the first grid: the columns of a few phases, found and followed.
ROW = 2000
LAST_TEST = FIRST_TEST + len(TESTS)
#: A window: N, its edges, the piece of the law, the phases of its orbit's first impact at the edges.
Row = tuple[int, Edge, Edge, str, tuple[float, float]]


def windows(
    model: Rig,
    name: str,
    N: int | Iterable[int] = range(1, 8),
    span: tuple[float, float] | None = None,
    samples: int | None = None,
    words: str | Sequence[str] | None = None,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Return every interval of a parameter with a stable admissible one-impact orbit of period N, and why it ends.

    Between walls: with an orbit of each word, the walls that are hit in order.

    Parameters
    ----------
    model : Oscillator
        With a reset law that is affine piece by piece: newton, active or triggered. With ``walls=`` any.
    name : str
        Any parameter of the model; the others keep their values. Between walls ``r`` stands for ``A.r`` and ``B.r``.
    N : int or iterable of int
        Periods of the forcing between impacts, each 1 to 1000; 1 to 7 if none are named. Attribute ``N`` of the result.
        Between walls those of an orbit.
    span : (low, high), optional
        The values searched, within the allowed range. Default: the whole range of r; half to twice the value of
        alpha, k, omega, V and trigger ([0, 1] for a value 0); the value plus or minus the sum of the amplitudes for
        the offset and the amplitudes, half a period for t0, the farthest push in one period for sigma.
    samples : int
        Cells of the first grid, >= 2; 2000, unless said. Cells are then halved where impact phases appear, disappear
        or run fast. Between walls the values at which orbits are searched, 16 unless said.
    words : str or sequence of str
        Between walls: orders of walls, such as ``"A,AB,AABB"``, begun at any of the impacts. Default: each wall alone,
        and to and fro.
    progress : callable, optional
        ``progress(done, total)``, with numbers of values that are searched, over one wall for each N.

    Returns
    -------
    xarray.Dataset
        Dimension ``window``, ordered by N, then low. Variables: ``N``; ``low`` and ``high``; ``low_type`` and
        ``high_type``, one of gr pd lp ns v0 law st end (in words: attribute ``meaning``); ``low_dip`` and
        ``high_dip``, for gr the dip that touches the wall, 1 the last before the impact, else 0; ``low_status`` and
        ``high_status``: *zero* (of a test function, bracketed to the last bits), *bracket* (the curve could be
        followed no further), *span*; ``low_phase`` and ``high_phase``, of the forcing at the impact there, omega (t +
        t0) in [0, 2 pi): they tell orbits apart that end at one value; ``piece`` of the reset law: whole, fired,
        passive. Between walls also ``word``, at whose first letter the phases are, ``low_wall`` and ``high_wall``, the
        wall of a graze, and ``symmetric``; an edge may be *bp*: symmetry breaks. Orbits that were found and could not
        be followed are in the attribute ``not_followed``.

    Raises
    ------
    InputError
        For an unknown parameter, a period that is no whole number >= 1, or a span out of range.
    OutsideForm
        For a reset law that is not known to be affine.

    Notes
    -----
    An edge is a zero of a test function along a curve of impact phases (see :mod:`grazing.orbits.closure`): Jury's
    conditions 1 + tr J + det J > 0 (pd), 1 - tr J + det J > 0 (lp), det J < 1 (ns), the impact speed (v0), its
    distance from the trigger (law), the force on a ball left at rest (st: r = 0 and V = 0), the lowest dip of the
    flight (gr). A further impact can appear at a graze only. What can be missed lies within one cell of the first
    grid: a pair of folds, or two zeros of one test function that leave no extremum on the grid. Narrow windows are
    found as long as their two edges are zeros of different test functions. Edges that doubles cannot tell apart, next
    to each other or to a fold, are computed with 512 bits; windows narrower than a double are left out. Orbits that lie
    on the wall for a while are outside: beyond st they go on with an impact, rest and release.

    Between walls orbits are searched at ``samples`` values, and followed by :func:`grazing.continuation` through folds,
    grazes and breaking symmetry. A window between two values is found if its branch leads to one of them. Two orbits
    that are mirror images of each other have one row.

    References
    ----------
    Pring and Budd, IMA J. Appl. Math. 76 (2011) 67-84, Figures 1.6 and 3.2.

    Examples
    --------
    >>> import grazing as gz
    >>> from grazing.orbits.windows import windows
    >>> table = windows(gz.pinball(V=0.4), "d", N=3)
    >>> for w in range(table.sizes["window"]):
    ...     row = table.isel(window=w)
    ...     print(f"{row.low:.12f} {row.low_type:s} {row.high:.12f} {row.high_type:s}")
    0.098450444937 gr 0.123281449644 pd
    """
    progress = checked_progress(progress)
    if isinstance(model, Rig) and model.walled:
        return _between_walls(model, name, N, span, samples, words, progress)
    if words is not None:
        raise InputError(f"words = {shown(words)} are orders of walls; an oscillator with one wall has one impact here")
    families(model, 1)  # refuses what is no oscillator, and laws outside the form
    refuse_stiffness(model, "a search for windows")
    if not isinstance(name, str) or name not in model.params:
        raise unknown(name, model.params, "the model")
    model.refuse_base("a search for windows", [name])
    low, high = _span(model, name, span)
    cells = whole(2000 if samples is None else samples, "samples", 2)
    refuse_too_large(ROW * cells, f"reduce samples ({cells})", "the first grid")
    values = np.linspace(low, high, cells + 1)
    found: list[Row] = []
    periods = checked_periods(N)
    for done, n in enumerate(periods):
        if progress is not None:
            progress(cells * done, cells * len(periods))
        for family in families(model, n, name):
            for curve in curves(family, values, model.unit_of(name)):
                for low_end, high_end in stable_intervals(curve):
                    phases = phase_of(curve, low_end), phase_of(curve, high_end)
                    found.append((n, low_end, high_end, PIECES[family.law], phases))
    if progress is not None:
        progress(cells * len(periods), cells * len(periods))
    found.sort(key=lambda window: (window[0], window[1].value, window[2].value))
    return _dataset(model, name, periods, (low, high), cells, found)


def phase_of(curve: Curve, edge: Edge) -> float:
    """Return the phase of the impact at an edge, in [0, 2 pi); at a fold that of the nearest orbit found."""
    return float(curve.at(edge.value)[PHASE]) % TWO_PI


def _between_walls(
    model: Rig, name: str, N: Any, span: Any, samples: int | None, words: Any, progress: Progress | None
) -> xr.Dataset:
    """Return the windows of orbits between walls."""
    checked_name(name, model.params, "the model")
    model.refuse_made([name])
    periods, bounds = checked_periods(N), _span(model, name, span)
    orders = checked_words(model, words)
    values = whole(VALUES if samples is None else samples, "samples", 2)

    def told(done: int) -> None:
        if progress is not None:
            progress(done, values)

    found, failed = word_windows(model, name, periods, orders, bounds, values, told)
    rows = [(one.N, one.low, one.high, piece_words(one, model), one.phases) for one in found]
    table = _dataset(model, name, periods, bounds, values, rows)
    texts = {"word": [one.word for one in found]}
    texts |= {f"{side}_wall": [one.walls[end] for one in found] for end, side in enumerate(("low", "high"))}
    said = {"word": "walls that are hit, in order", "low_wall": "wall of the low edge", "high_wall": "of the high one"}
    for key, column in texts.items():
        table[key] = "window", np.array(column, dtype=object), {"long_name": said[key]}
    symmetric = np.array([one.symmetric for one in found], np.int8)
    table["symmetric"] = "window", symmetric, {"long_name": "whether the orbit is its own mirror image"}
    table.attrs |= {"title": f"windows of orbits between walls in {name}", "words": ",".join(orders)}
    return table.assign_attrs(not_followed=json.dumps(failed)) if failed else table


def stable_intervals(curve: Curve) -> list[tuple[Edge, Edge]]:
    """Return where all test functions are positive along one curve: pairs of edges."""
    inside = [edge for edge in _zeros(curve) if curve.low.value < edge.value < curve.high.value]
    below, above = _before_fold(curve, 0, curve.low), _before_fold(curve, -1, curve.high)
    edges = [curve.low, *below, *_told_apart(curve, inside), *above, curve.high]
    good: list[tuple[Edge, Edge]] = []
    for (low, high), stable in zip(pairwise(edges), _stable(curve, edges, len(below), len(above)), strict=True):
        if high.value < low.value or not stable:
            continue
        if good and good[-1][1] is low:  # a zero that changes nothing: the others decide
            good[-1] = (good[-1][0], high)
        else:
            good.append((low, high))
    return [(low, high) for low, high in good if low.value < high.value]


def _stable(curve: Curve, edges: list[Edge], below: int, above: int) -> list[bool]:
    """Return for every stretch between two edges whether all test functions are positive on it.

    They are looked at in the middle; not between edges that are too close, and not next to a fold, where ``below`` and
    ``above`` edges lie beyond the last points: there each edge turns the sign of its own test function.
    """
    signs: list[dict[str, bool] | None] = []
    for i, (low, high) in enumerate(pairwise(edges)):
        seen = below <= i < len(edges) - 1 - above and high.value - low.value > _close(curve, low.value)
        tests = curve.at(0.5 * (low.value + high.value))[FIRST_TEST:LAST_TEST] > 0.0 if seen else None
        signs.append(None if tests is None else dict(zip(TESTS, tests.tolist(), strict=True)))
    for order in (range(1, len(signs)), range(len(signs) - 2, -1, -1)):
        for i in order:
            near, edge = (i - 1, edges[i]) if order.step > 0 else (i + 1, edges[i + 1])
            known = signs[near]
            if signs[i] is None and known is not None:
                signs[i] = {kind: sign != (kind == edge.type) for kind, sign in known.items()}
    return [known is not None and all(known.values()) for known in signs]


def _close(curve: Curve, value: float) -> float:
    """Return the distance below which doubles may take two edges for each other."""
    return CLOSE * family_scale(curve.family, value)


def _told_apart(curve: Curve, edges: list[Edge]) -> list[Edge]:
    """Return edges in increasing order; of different ones that are close together many digits decide."""
    edges = sorted(edges, key=lambda edge: edge.value)
    groups: list[list[Edge]] = []
    for edge in edges:
        if groups and edge.value - groups[-1][-1].value <= _close(curve, edge.value):
            groups[-1].append(edge)
        else:
            groups.append([edge])
    found: list[Edge] = []
    for group in groups:
        if len({edge.type for edge in group}) > 1:
            guesses = [(edge.type, float(curve.at(edge.value)[PHASE]), edge.value) for edge in group]
            order = ordered(curve.family, guesses)
            if order is not None:
                group = [group[i]._replace(value=value) for i, value in order]
        found += group
    return found


def _before_fold(curve: Curve, last: int, fold: Edge) -> list[Edge]:
    """Return the edges between the last point of a curve, at index ``last``, and its fold, in increasing order.

    Doubles lose the two zeros of G there. Many digits are asked if a test function may change its sign on the way: by
    more than a tenth, as it goes on with the phase.
    """
    if fold.type != "lp" or fold.status != "zero" or len(curve.rows) < 2:
        return []
    row, before = curve.rows[last], curve.rows[1 if last == 0 else -2]
    guess = extremum(curve.family, fold.value, float(row[PHASE]))[0]
    moved, left = float(wrapped(row[PHASE] - before[PHASE])), float(wrapped(guess - row[PHASE]))
    tests = _finite(row[FIRST_TEST:LAST_TEST])
    change = tests - _finite(before[FIRST_TEST:LAST_TEST])
    share = abs(left / moved) if moved != 0.0 else inf
    others = np.array([kind != "lp" for kind in TESTS])
    with np.errstate(invalid="ignore"):
        if not (np.abs(share * change) > 0.1 * np.abs(tests))[others].any():
            return []
    found = before_fold(curve.family, float(row[PHASE]), tests, fold.value, float(row[PHASE]) + left)
    if found is None:
        return []
    edges = [Edge(value, kind, "zero", int(row[DIP]) if kind == "gr" else 0) for value, kind in found]
    return edges[::-1] if last == 0 else edges


def _zeros(curve: Curve) -> list[Edge]:
    """Return the zeros of all test functions between the values of a curve."""
    found = []
    values, rows = np.array(curve.values), np.array(curve.rows)
    for column, kind in enumerate(TESTS, start=FIRST_TEST):
        heights = _finite(rows[:, column])
        for low, high in _brackets(curve, column, values, heights):
            value = _zero(curve, column, low, high)
            dip = int(curve.at(value)[DIP]) if column == CLEARANCE else 0
            found.append(Edge(value, kind, "zero", dip))
    return found


def _finite(heights: Any) -> NDArray[np.float64]:
    """Return test values with a flight without dips, of infinite clearance, as one of clearance 1."""
    return np.where(np.isinf(heights), 1.0, heights)


def _brackets(
    curve: Curve, column: int, values: NDArray[np.float64], heights: NDArray[np.float64]
) -> list[tuple[float, float]]:
    """Return intervals in which one test function changes sign, extrema that dip across 0 included."""
    positive = heights > 0.0
    found = [(values[i], values[i + 1]) for i in np.flatnonzero(positive[1:] != positive[:-1])]
    size = np.abs(heights)
    alike = (positive[1:-1] == positive[:-2]) & (positive[1:-1] == positive[2:])
    rise = np.maximum(size[:-2], size[2:]) - size[1:-1]
    # a parabola through three values dips below the middle one by less than an eighth of the larger rise
    inner = np.flatnonzero(alike & (size[1:-1] < np.minimum(size[:-2], size[2:])) & (size[1:-1] < 2.0 * rise))
    for i in inner + 1:
        sign = 1.0 if positive[i] else -1.0
        least = late.optimize.minimize_scalar(
            lambda value, sign=sign: sign * float(_finite(curve.at(value)[column])),
            bounds=(values[i - 1], values[i + 1]),
            method="bounded",
            options={"xatol": 1e-9 * (values[i + 1] - values[i - 1])},
        )
        if least.fun < 0.0:
            found += [(values[i - 1], float(least.x)), (float(least.x), values[i + 1])]
    return found


def _zero(curve: Curve, column: int, low: float, high: float) -> float:
    """Return the zero of one test function in a bracket, to the last bits."""

    def height(value: float) -> float:
        return float(_finite(curve.at(value)[column]))

    ends = height(low), height(high)
    if ends[0] * ends[1] >= 0.0:
        return low if abs(ends[0]) <= abs(ends[1]) else high
    smallest = 1e-18 * (curve.values[-1] - curve.values[0])
    return float(late.optimize.brentq(height, low, high, xtol=smallest, rtol=1e-15, maxiter=300))


def _span(model: Rig, name: str, span: Any) -> tuple[float, float]:
    """Return the span searched, checked, or the default one."""
    known = model.describe(name)
    parameter = known if model.walled else damped(known)
    if span is not None:
        try:
            low, high = span
        except (TypeError, ValueError):
            raise InputError(f"span is {shown(span)}; give the pair (low, high) of values of {name}") from None
        low, high = parameter.check(low), parameter.check(high)
        refuse_ends(low, high, f"span of {name} is ({low:g}, {high:g})")
        for value in (low, high):  # some are out of range beside the others only
            refuse_swings(model.replace(**{name: value}))
        return low, high
    value = value_of(name, model.params)
    if parameter.high < inf:
        return parameter.low, parameter.high
    if parameter.low == 0.0:
        return (0.5 * value, 2.0 * value) if value > 0.0 else (0.0, model.unit_of(name))
    return value - model.unit_of(name), value + model.unit_of(name)


def _dataset(
    model: Rig,
    name: str,
    periods: list[int],
    span: tuple[float, float],
    samples: int,
    found: list[Row],
) -> xr.Dataset:
    """Return the windows as a labelled table."""
    from grazing.late import xarray as xr

    about = model.describe(name).attributes
    words = "; ".join(f"{kind}: {meaning}" for kind, meaning in EDGES.items())

    def column(values: list[Any], dtype: Any, long_name: str, **more: str) -> Any:
        return "window", np.array(values, dtype), {"long_name": long_name, **more}

    columns = {"N": column([w[0] for w in found], np.int64, "periods between impacts", units="1")}
    for side, end in ((1, "low"), (2, "high")):
        edges: list[Any] = [w[side] for w in found]
        dip = "dip that touches the wall, 1 the last before the impact, 0 none"
        columns |= {
            end: ("window", np.array([e.value for e in edges], np.float64), about),
            f"{end}_type": column([e.type for e in edges], "<U4", f"type of the {end} edge", meaning=words),
            f"{end}_dip": column([e.dip for e in edges], np.int64, dip, units="1"),
            f"{end}_status": column([e.status for e in edges], "<U8", f"how the {end} edge was found"),
            f"{end}_phase": column(
                [w[4][side - 1] for w in found], np.float64, f"phase of the impact at the {end} edge", units="rad"
            ),
        }
    columns["piece"] = column([w[3] for w in found], "<U8", "piece of the reset law")
    attributes = {
        "title": f"windows of one-impact orbits in {name}",
        "parameter": name,
        "model": repr(model),
        "parameters": json.dumps(dict(model.params)),
        "N": periods,
        "span": list(span),
        "samples": samples,
        "arithmetic": "strict",
        **model.attributes,
    }
    return xr.Dataset(columns, attrs=attributes)
