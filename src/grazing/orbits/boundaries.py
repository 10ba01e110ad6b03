"""Boundary curves in the plane of two parameters, exact where theory knows them: to be laid on top of a chart.

For the gap map (2.6) these are the edges of the windows of the maximal orbits (Proposition 3.1); each gives one of the
parameters in closed form once the others are known. For an oscillator they are the edges of the windows of its
one-impact orbits and the graze of its response without impacts, exact at each point; what is searched is how they go on
from one value to the next.
"""

from __future__ import annotations

import json
from collections.abc import Iterable
from itertools import pairwise
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from grazing import late
from grazing.maps.map import Map
from grazing.maps.normal_form import steady_minimum
from grazing.orbits.gap_boundaries import GAP, GAP_KINDS, Curve, Range, check_sides, gap_curves
from grazing.orbits.windows import EDGES, windows
from grazing.oscillator.model import Oscillator
from grazing.outcome import InputError, OutsideForm, shown
from grazing.parameter import Parameter, checked_periods, in_order, refuse_ends

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]

#: Seconds of a processor that each period of an oscillator takes, as measured.
SECONDS = 7
#: In place of a period: the response without impacts, whose word is 0.
FREE = 0
#: The other edges of a window's own span are no boundaries.
NO_BOUNDARY = "end"
#: First searches across an oscillator's chart in each direction, and cells of each of them.
ROWS, CELLS = 9, 60
#: A curve between neighbouring points of an oscillator is straight to this part of the chart.
STRAIGHT = 1e-3
#: How often the distance of two searches is halved, to see a bend; to find where an edge begins or ends.
BENDS, ENDS = 5, 8
#: Edges of neighbouring searches that are farther apart than this part of the chart are not joined.
JOINED = 0.12
#: Curves found along one parameter that are as near as this to one found along the other are the same.
SAME = 0.01


def boundaries(P: Map | Oscillator, x: Any, y: Any, *, N: int | Iterable[int] = range(1, 8)) -> xr.Dataset:
    """Return exact boundary curves in the plane of two parameters, from theory where it knows them.

    Parameters
    ----------
    P : Map or Oscillator
        A gap map; or the stroboscopic or impact map of an oscillator, or the oscillator itself, whose reset law is
        affine piece by piece. The other parameters keep their values.
    x, y : (name, low, high) or (name, values)
        The two parameters and their ranges, as in a chart: x is the first one, its horizontal axis.
    N : int or iterable of int
        Periods of the orbits, each 1 to 1000; 1 to 7 if none are named.

    Returns
    -------
    xarray.Dataset
        Dimensions ``curve`` and ``point``; variables named like the two parameters (curve, point), filled up with
        NaN; ``N``, ``kind`` and ``label`` (curve). Kinds are pd and bc for the gap map, where a window of stable
        maximal orbits ends, and for an oscillator those of :func:`grazing.windows` but for the ends of the search.
        With N = 1 among the periods of an oscillator also ``0 gr``, the graze of the steady response without impacts.

    Raises
    ------
    InputError
        For parameters that the map does not have, ranges that are none or out of bounds, or a wrong N.
    OutsideForm
        For a map without such a theory: neither the gap map nor one of an oscillator with an affine law.

    Notes
    -----
    For the gap map every point is a value of the formula, the curves are cut where they leave the chart or where the
    window is empty (mu_pd = mu_bc). For an oscillator each point is an edge found by :func:`grazing.windows` along x or
    along y; curves join edges of one N and kind, and neighbouring searches are halved until the steps are short.
    A window that is narrower than a step in both directions can be missed. That is some 250 to 300 searches, of all
    periods each: measured, 6 s of a processor with N = 1 and 14 s with N = [1, 2] on a plane of 2.2 by 0.5. One curve
    alone is followed by :func:`grazing.locus`, from one of its points.

    References
    ----------
    Pring and Budd, IMA J. Appl. Math. 76 (2011) 67-84, Proposition 3.1 and Figures 3.4 and 3.6.

    Examples
    --------
    >>> import grazing as gz
    >>> from grazing.orbits.boundaries import boundaries
    >>> found = boundaries(gz.gap_map(lam=0.9, mu=0.1, l=0.1), ("l", 0.0, 1.0), ("mu", 0.0, 0.4), N=[3, 4])
    >>> found.label.values.tolist()
    ['3 pd', '3 bc', '4 pd', '4 bc']
    >>> round(float(found.l.sel(curve=2).min()), 10)  # period 4 has a window from here on
    0.08000775
    """
    first, second = _range(x, "x"), _range(y, "y")
    if first.name == second.name:
        raise InputError(f"x and y are both {shown(first.name)}; give two different parameters")
    periods = checked_periods(N)
    model = P if isinstance(P, Oscillator) else _model_of(P)
    if isinstance(P, Map) and P.origin.orbits is not None:
        known, about = dict(P.params), GAP
        curves = gap_curves(dict(P.params), first, second, periods)
    elif isinstance(model, Oscillator):
        known = dict(model.params)
        about = {name: model.describe(name) for name in known}
        check_sides(first, second, about, "the model")
        curves = _oscillator_curves(model, first, second, periods)
    else:
        raise OutsideForm(
            f"{getattr(P, 'name', P)!s} has no boundaries in closed form: they are known for the gap map (gz.gap_map), "
            "and the stroboscopic and the impact map of an oscillator whose reset law is newton, active or triggered"
        )
    return _dataset(P, model, known, about, (first, second), periods, curves)


def _model_of(P: Any) -> Oscillator | None:
    """Return the oscillator whose orbits are those of a map; the local maps only come near them."""
    return P.model if isinstance(P, Map) and P.section is not None else None


# ---- oscillators


Key = tuple[int, str, int, str, str]


class Cut(NamedTuple):
    """The edges of the windows at one value of the other parameter: increasing values for each N, type, dip, side."""

    at: float
    edges: dict[Key, list[float]]

    def alike(self, other: Cut) -> bool:
        """Whether both have the same edges."""
        return {key: len(values) for key, values in self.edges.items()} == {
            key: len(values) for key, values in other.edges.items()
        }


def _oscillator_curves(model: Oscillator, x: Range, y: Range, periods: list[int]) -> list[Curve]:
    """Return the edges of the windows of one-impact orbits: searched along x, and along y for those that lie so."""
    size = np.array([x.high - x.low, y.high - y.low])
    found = [Curve(key[0], key[1], points) for key, points in _joined(model, x, y, periods)]
    for key, points in _joined(model, y, x, periods):
        known = [curve.points for curve in found if (curve.N, curve.kind) == key[:2]]
        found += [Curve(key[0], key[1], rest) for rest in _elsewhere(points[:, ::-1], known, size)]
    return sorted(found, key=lambda curve: (curve.N, curve.kind))


def _cut(model: Oscillator, along: Range, other: Range, at: float, periods: list[int]) -> Cut:
    """Return the edges along one parameter at one value of the other."""
    span = (along.low, along.high)
    here = model.replace(**{other.name: at})
    table = windows(here, along.name, periods, span, CELLS)
    edges: dict[Key, list[float]] = {}
    free = free_grazes(here, along) if 1 in periods else []
    if free:
        edges[FREE, "gr", -1, "", ""] = free
    for w in range(table.sizes["window"]):
        for side in ("low", "high"):
            kind = str(table[f"{side}_type"].values[w])
            if kind == NO_BOUNDARY:
                continue
            dip, piece = int(table[f"{side}_dip"].values[w]), str(table["piece"].values[w])
            key = int(table["N"].values[w]), kind, dip, piece, side
            edges.setdefault(key, []).append(float(table[side].values[w]))
    return Cut(at, {key: sorted(values) for key, values in edges.items()})


def free_grazes(model: Oscillator, along: Range) -> list[float]:
    """Return where the steady response without impacts grazes the wall, in increasing order."""

    def height(value: float) -> float:
        try:
            return steady_minimum(model.replace(**{along.name: value}))[1]
        except (InputError, OutsideForm):
            return float("nan")

    if along.name in (*model.reset.params, "t0"):
        return []
    values = np.linspace(along.low, along.high, CELLS + 1).tolist()
    heights = [height(value) for value in values]
    return [
        float(late.optimize.brentq(height, *ends, xtol=1e-300, rtol=8.9e-16)) if a * b < 0.0
        else ends[0 if a == 0.0 else 1]
        for ends, (a, b) in zip(pairwise(values), pairwise(heights), strict=True) if a * b < 0.0 or b == 0.0
    ]  # fmt: skip


def _cuts(model: Oscillator, along: Range, other: Range, periods: list[int]) -> list[Cut]:
    """Return searches so close that the edges between them are straight, and begin and end where they do."""
    length = along.high - along.low

    def between(a: Cut, b: Cut, depth: int) -> list[Cut]:
        """Return the searches needed between two."""
        alike = a.alike(b)
        if depth >= (BENDS if alike else ENDS):
            return []
        middle = _cut(model, along, other, 0.5 * (a.at + b.at), periods)
        if alike and a.alike(middle):
            bends = [
                abs(m - 0.5 * (low + high)) / length
                for key in a.edges
                for low, m, high in zip(a.edges[key], middle.edges[key], b.edges[key], strict=True)
            ]
            if max(bends, default=0.0) <= STRAIGHT:
                return [middle]
        return [*between(a, middle, depth + 1), middle, *between(middle, b, depth + 1)]

    rows = [_cut(model, along, other, float(at), periods) for at in np.linspace(other.low, other.high, ROWS)]
    cuts = [rows[0]]
    for a, b in pairwise(rows):
        cuts += [*between(a, b, 0), b]
    return cuts


def _joined(model: Oscillator, along: Range, other: Range, periods: list[int]) -> list[tuple[Key, Floats]]:
    """Return the edges as curves (n, 2) of (along, other), joined from search to search."""
    reach = JOINED * (along.high - along.low)
    done: list[tuple[Key, list[tuple[float, float]]]] = []
    growing: dict[Key, list[list[tuple[float, float]]]] = {}
    for cut in _cuts(model, along, other, periods):
        for key in growing.keys() | cut.edges.keys():
            before, values = growing.get(key, []), cut.edges.get(key, [])
            pairs = _matched([curve[-1][0] for curve in before], values, reach)
            taken = {j: i for i, j in pairs}
            done += [(key, curve) for i, curve in enumerate(before) if i not in dict(pairs)]
            growing[key] = [[*(before[taken[j]] if j in taken else []), (x, cut.at)] for j, x in enumerate(values)]
    done += [(key, curve) for key, several in growing.items() for curve in several]
    return [(key, np.array(curve)) for key, curve in sorted(done) if len(curve) > 1]


def _matched(a: list[float], b: list[float], reach: float) -> list[tuple[int, int]]:
    """Match edges of two searches: one by one where there are as many, else the nearest first."""
    if len(a) == len(b):
        pairs = [(i, i) for i in range(len(a))]
        return [(i, j) for i, j in pairs if abs(a[i] - b[j]) <= reach]
    near = sorted((abs(a[i] - b[j]), i, j) for i in range(len(a)) for j in range(len(b)))
    pairs, left, right = [], set(range(len(a))), set(range(len(b)))
    for away, i, j in near:
        if away <= reach and i in left and j in right:
            pairs.append((i, j))
            left.remove(i)
            right.remove(j)
    return pairs


def _elsewhere(points: Floats, known: list[Floats], size: Floats) -> list[Floats]:
    """Return the stretches of a curve that no known curve covers, with one point more at each end."""
    away = np.full(len(points), np.inf)
    for curve in known:
        a, step = curve[:-1] / size, np.diff(curve / size, axis=0)
        for i, point in enumerate(points / size):
            share = ((point - a) * step).sum(axis=1) / np.maximum((step**2).sum(axis=1), 1e-300)
            nearest = a + np.clip(share, 0.0, 1.0)[:, None] * step
            away[i] = min(away[i], float(np.hypot(*(point - nearest).T).min()))
    new = away > SAME
    found = []
    starts = np.flatnonzero(new & ~np.append(False, new[:-1]))
    ends = np.flatnonzero(new & ~np.append(new[1:], False))
    for start, end in zip(starts, ends, strict=True):
        stretch = points[max(start - 1, 0) : end + 2]
        if len(stretch) > 1:
            found.append(stretch)
    return found


# ---- arguments and result


def _range(value: Any, which: str) -> Range:
    """Return one side of the chart: (name, low, high), or (name, values) for the ends of values."""
    wanted = f"{which} is {shown(value)}; give (name, low, high), such as ('d', 0.05, 0.16), or (name, values)"
    try:
        name, *rest = value
    except (TypeError, ValueError):  # nothing is in it
        raise InputError(wanted) from None
    if isinstance(value, str) or not isinstance(name, str) or len(rest) not in (1, 2):
        raise InputError(wanted)
    try:
        ends = np.asarray(in_order(rest[0]) if len(rest) == 1 else rest, np.float64).ravel()
    except (TypeError, ValueError):
        raise InputError(wanted) from None
    if ends.size < 2 or not np.isfinite(ends).all():
        raise InputError(wanted)
    low, high = (float(ends.min()), float(ends.max())) if len(rest) == 1 else (float(ends[0]), float(ends[1]))
    refuse_ends(low, high, f"{which} runs from {low:g} to {high:g}")
    return Range(name, low, high)


def _dataset(
    P: Any,
    model: Any,
    params: dict[str, float],
    about: dict[str, Parameter],
    sides: tuple[Range, Range],
    periods: list[int],
    curves: list[Curve],
) -> xr.Dataset:
    """Return the curves as a labelled table, filled up with NaN."""
    from grazing.late import xarray as xr

    longest = max((len(curve.points) for curve in curves), default=0)
    variables: dict[str, Any] = {}
    for column, side in enumerate(sides):
        values = np.full((len(curves), longest), np.nan)
        for row, curve in enumerate(curves):
            values[row, : len(curve.points)] = curve.points[:, column]
        variables[side.name] = (("curve", "point"), values, about[side.name].attributes)
    kinds = np.array([curve.kind for curve in curves], dtype=object)
    words = GAP_KINDS if about is GAP else EDGES
    meaning = "; ".join(f"{kind}: {said}" for kind, said in words.items() if kind != NO_BOUNDARY)
    labels = np.array([f"{curve.N} {curve.kind}" for curve in curves], dtype=object)
    variables["N"] = (
        "curve",
        np.array([curve.N for curve in curves], np.int64),
        {"long_name": "period of the orbit, 0 for the response without impacts", "units": "1"},
    )
    variables["kind"] = ("curve", kinds, {"long_name": "what the curve is", "meaning": meaning})
    variables["label"] = ("curve", labels, {"long_name": "name of the curve"})
    held = {name: value for name, value in params.items() if name not in (sides[0].name, sides[1].name)}
    config = {"params": held, "x": list(sides[0]), "y": list(sides[1]), "N": periods}
    attributes = {
        "title": f"boundaries of the windows in {sides[0].name} and {sides[1].name}",
        "model": repr(P),
        "grazing_config": json.dumps(config, sort_keys=True, separators=(",", ":"), allow_nan=False),
        "arithmetic": "strict",
        **(model.attributes if isinstance(model, Oscillator) else {}),
    }
    return xr.Dataset(variables, attrs=attributes)
