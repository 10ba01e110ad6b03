"""The ladder of reductions: each window of one-impact orbits on every rung, and its error split among the rungs."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from grazing.compare.branches import Linearised, Local, Point
from grazing.compare.edges import march, windows_on
from grazing.compare.orders import LAST, with_orders
from grazing.maps.normal_form import NormalForm, constants, normal_form
from grazing.orbits.windows import EDGES, windows
from grazing.oscillator.constants import forcing
from grazing.oscillator.model import Oscillator
from grazing.outcome import GrazingError, InputError, OutsideForm, shown
from grazing.parameter import checked_periods, whole
from grazing.theory import mu_bc, mu_pd

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]

#: The rungs, from the simplest map to the flow.
RUNGS = {
    "gap": "one-dimensional gap map (2.6)",
    "linearised": "two-dimensional linearised map in (x, y)",
    "lowest": "discontinuity map of lowest order, (2.4)/(2.5)",
    "full": "discontinuity map with all terms of (2.2)/(2.3)",
    "corrected": "the same with the acceleration after the impact",
    "flow": "the oscillator",
}
SIDES = ("low", "high")
#: Speeds at which a branch is looked at, per factor of ten.
PER_DECADE = 16


class Found(NamedTuple):
    """A window on one rung: values, types and dips of its low and high edge; why there is none."""

    value: tuple[float, float] = (np.nan, np.nan)
    type: tuple[str, str] = ("", "")
    dip: tuple[int, int] = (0, 0)
    status: str = "ok"


def ladder(
    model: Oscillator,
    name: str,
    N: int | Iterable[int] = range(2, 8),
    *,
    rungs: Sequence[str] = tuple(RUNGS),
    span: tuple[float, float] | None = None,
    last: int = LAST,
) -> xr.Dataset:
    """Return each window of the orbit with one impact in N periods on every rung, from the gap map up to the flow.

    Parameters
    ----------
    model : Oscillator
        Any damped model with a reset law that is affine piece by piece.
    name : str
        The parameter that unfolds the graze, such as ``"d"``.
    N : int or iterable of int
        Periods between impacts, each 1 to 1000.
    rungs : sequence of str
        Of *gap*, *linearised*, *lowest*, *full*, *corrected*, *flow*; the flow always belongs to them.
    span : (low, high), optional
        Where the windows of the flow are sought; default as for :func:`grazing.windows`, around the graze.
    last : int
        The orders are fitted to so many of the largest N, >= 3.

    Returns
    -------
    xarray.Dataset
        On (rung, N, side), side *low* or *high*: ``edge``, the value of the parameter; ``type``, as in
        :func:`grazing.windows`, a border collision of a map being the graze ``gr`` of a dip; ``dip``, 1 the last before
        the impact; ``error``, edge less that of the flow; ``step``, edge less that of the next rung that has one, so
        that the steps from a rung up add up to its error. ``status`` (rung, N) says why there is no window.
        ``distance`` (N, side): of the flow's edge from the graze. On (rung, side): ``order`` and ``step_order``, the
        exponents q with which error and step fall as distance^q, with ``order_error`` and ``step_order_error``, and
        ``expected`` and ``expected_step``, the orders in theory, see :mod:`grazing.compare.orders`.

    Raises
    ------
    InputError
        For an unknown rung or parameter, or a period that is no whole number >= 1.
    OutsideForm
        Without a graze that the parameter unfolds, or for a reset law that is not known to be affine.

    Notes
    -----
    On every rung an edge is a zero of a test function along the branch of the orbit, to the last bits: multiplier -1,
    +1 or a pair on the unit circle, or a point on the border. The gap map's are Proposition 3.1, those of the flow
    :func:`grazing.windows`. The discontinuity maps stand at the phase of the graze. A window whose gap map lies
    outside (2.6), such as b < 0 or lambda outside (0, 1), begins on the rung above.

    References
    ----------
    Pring and Budd, IMA J. Appl. Math. 76 (2011) 67-84, section 2 and Proposition 3.1.

    Examples
    --------
    >>> import grazing as gz
    >>> from grazing.compare.ladder import ladder
    >>> found = ladder(gz.pinball(V=0.4), "d", N=[3, 4])
    >>> for rung in found.rung.values:
    ...     print(f"{rung:10s} {found.edge.sel(rung=rung, N=4, side='high').item():.10f}")
    gap        0.1285456212
    linearised 0.1285557052
    lowest     0.1285563719
    full       0.1282656581
    corrected  0.1285834713
    flow       0.1285807155
    """
    chosen = _rungs(rungs)
    periods = checked_periods(N)
    form = normal_form(model, name)
    if form.model.params["alpha"] == 0.0:
        raise OutsideForm("alpha = 0: without damping the gap map neglects what it keeps; the ladder needs alpha > 0")
    last = whole(last, "last", 3)
    climbed = [climb(model, form, n, chosen) for n in periods]
    table = windows(form.model, name, periods, span)
    for found, n in zip(climbed, periods, strict=True):
        found["flow"] = _of_flow(table, n, [found[rung] for rung in chosen[:-1]], form.graze)
    result = _dataset(model, form, chosen, periods, climbed, table.attrs["span"])
    return with_orders(result, has_jerk(form), decays(form), last)


def decays(form: NormalForm) -> bool:
    """Whether free flights die away without oscillation, so that windows of all N pile up at the graze."""
    return form.b > 0.0 and form.lam > 0.0 and form.lam**2 > 4.0 * form.det


def has_jerk(form: NormalForm) -> bool:
    """Whether the steady response has a third derivative where it touches the wall, beyond rounding."""
    c = constants(form.model)
    _F, rate = forcing(form.time, c)
    return abs(rate - c.alpha * form.acceleration) > 1e-9 * c.rate * c.force


def climb(model: Oscillator, form: NormalForm, N: int, rungs: Sequence[str]) -> dict[str, Found]:
    """Return the window of one N on the rungs below the flow."""
    found: dict[str, Found] = {}
    if "gap" in rungs:
        found["gap"] = _of_gap(form, N)
    linear = Linearised(form, N)
    speeds = np.geomspace(1e-8, 10.0, 9 * PER_DECADE + 1).tolist()
    known = windows_on(linear, march(linear, speeds, 0, None))
    reason = "" if known else f"no stable orbit with one impact in {N} periods"
    window = max(known, key=lambda w: abs(w.fast.value - w.slow.value), default=None)
    if "linearised" in rungs:
        edges = [(edge.value, edge.type, edge.dip) for edge in window or ()]
        found["linearised"] = _placed(form, edges) if edges else Found(status=reason)
    unit = form.scale**0.5
    near: Point | None = None
    top = 1.0 if window is None else window.fast.point.s
    bottom = 1e-3 if window is None else window.slow.point.s
    middle = (top * bottom) ** 0.5
    s = middle * unit
    try:
        near = Point(s, -s / form.acceleration, form.parameter(linear.mu(middle)), np.empty(0), np.empty(0))
    except GrazingError:
        near = Point(s, -s / form.acceleration, form.graze, np.empty(0), np.empty(0))
    for order in ("lowest", "full", "corrected"):
        if order in rungs:
            found[order] = _of_local(Local(model, form, N, order), near, (bottom * unit, top * unit))
    return found


def _of_gap(form: NormalForm, N: int) -> Found:
    """Return the window of the gap map, Proposition 3.1, in the model's parameter."""
    if form.b <= 0.0:
        return Found(status=f"outside (2.6): b = {form.b:g} <= 0, the square root enters with the other sign")
    if not 0.0 < form.lam < 1.0:
        return Found(status=f"outside (2.6): lambda = {form.lam:g}; Proposition 3.1 needs 0 < lambda < 1")
    pd, bc = mu_pd(N, form.lam, form.l), mu_bc(N, form.lam, form.l)
    if not pd < bc:
        return Found(status=f"no stable orbit with one impact in {N} periods")
    return _placed(form, [(pd, "pd", 0), (bc, "gr", 1)])


def _placed(form: NormalForm, edges: list[tuple[float, str, int]]) -> Found:
    """Return the window between two values of mu, as values of the parameter."""
    found, said = [], "ok"
    for mu, kind, dip in edges:
        try:
            found.append((form.parameter(mu) if np.isfinite(mu) else np.nan, kind, dip))
        except OutsideForm as error:
            found.append((np.nan, kind, dip))
            said = str(error)
    return _sided(found, form.mu, said)


def _of_local(rung: Local, near: Point, known: tuple[float, float]) -> Found:
    """Return the window of a discontinuity map around the speeds where the linearised map has its own."""
    decades = np.log10(known[1] / known[0] * 400.0)
    speeds = np.geomspace(known[0] / 20.0, 20.0 * known[1], max(8, int(PER_DECADE * decades)))
    start = int(np.argmin(np.abs(np.log(speeds / near.s))))
    branch = march(rung, speeds.tolist(), start, near)
    if not branch:
        return Found(
            status="the orbit was not found: Newton's method did not arrive; the map is too far from its graze"
        )
    several = windows_on(rung, branch)
    if not several:
        return Found(status=f"no stable orbit with one impact in {rung.N} periods")
    window = max(several, key=lambda w: _overlap((w.slow.point.s, w.fast.point.s), known))
    return _sided([(edge.value, edge.type, edge.dip) for edge in window], None, "ok")


def _overlap(a: tuple[float, float], b: tuple[float, float]) -> float:
    """Return by which factor the common part of two intervals of speeds reaches, as a logarithm; negative if apart."""
    return float(np.log(min(a[1], b[1]) / max(a[0], b[0])))


def _sided(edges: list[tuple[float, str, int]], mu: Any, status: str) -> Found:
    """Return a window with its low edge first; an edge at infinity lies beyond the other, on the side of rising mu."""
    first, second = edges
    if np.isnan(first[0]) != np.isnan(second[0]) and mu is not None:
        there = second if np.isnan(first[0]) else first
        h = 1e-6 * max(1.0, abs(there[0]))
        falls = mu(there[0] + h) < mu(there[0] - h)
        first, second = (second, first) if falls else (first, second)
    elif second[0] < first[0]:
        first, second = second, first
    return Found((first[0], second[0]), (first[1], second[1]), (first[2], second[2]), status)


def _of_flow(table: xr.Dataset, N: int, below: list[Found], graze: float) -> Found:
    """Return the window of the flow that lies nearest to that of the highest rung which has one."""
    rows = [table.isel(window=w) for w in np.flatnonzero(table["N"].values == N)]
    if not rows:
        return Found(status=f"no stable orbit with one impact in {N} periods in the span searched")
    wanted = next((f.value for f in reversed(below) if np.isfinite(f.value).any()), (graze, graze))

    def away(row: xr.Dataset) -> float:
        return float(np.nansum(np.abs(np.array([row[side].item() for side in SIDES]) - wanted)))

    row = min(rows, key=away)
    low, high = (row[side].item() for side in SIDES)
    types = (str(row["low_type"].item()), str(row["high_type"].item()))
    return Found((low, high), types, (int(row["low_dip"].item()), int(row["high_dip"].item())))


def _rungs(rungs: Sequence[str]) -> list[str]:
    """Return the rungs asked for, from below, the flow last; or raise InputError."""
    alone = isinstance(rungs, str) or not isinstance(rungs, Iterable) or getattr(rungs, "ndim", 1) == 0
    several = [rungs] if alone else list(rungs)
    for rung in several:
        if not isinstance(rung, str) or rung not in RUNGS:
            raise InputError(f"rung {shown(rung)} is not known; allowed are {', '.join(RUNGS)}")
    return [rung for rung in RUNGS if rung in several or rung == "flow"]


def _dataset(
    model: Oscillator, form: NormalForm, rungs: list[str], periods: list[int], climbed: list[dict[str, Found]],
    span: Any,
) -> xr.Dataset:  # fmt: skip
    """Return edges, errors and steps as a labelled table."""
    from grazing.late import xarray as xr

    def field(get: Any, kind: Any) -> NDArray[Any]:
        return np.array([[get(found[rung]) for found in climbed] for rung in rungs], kind)

    edge = field(lambda f: f.value, np.float64)
    above = np.full_like(edge, np.nan)  # the edge on the next rung that has one
    for i in reversed(range(len(rungs) - 1)):
        above[i] = np.where(np.isnan(edge[i + 1]), above[i + 1], edge[i + 1])
    step = edge - above
    step[-1] = np.where(np.isnan(edge[-1]), np.nan, 0.0)
    about = model.describe(form.name).attributes
    words = "; ".join(f"{kind}: {meaning}" for kind, meaning in EDGES.items())
    dims = ("rung", "N", "side")
    return xr.Dataset(
        {
            "edge": (dims, edge, about),
            "type": (dims, field(lambda f: f.type, "<U4"), {"long_name": "type of the edge", "meaning": words}),
            "dip": (dims, field(lambda f: f.dip, np.int64), {"long_name": "dip that touches the wall, 0 none"}),
            "error": (dims, edge - edge[-1], about | {"long_name": "edge less that of the flow"}),
            "step": (dims, step, about | {"long_name": "edge less that of the next rung"}),
            "status": (dims[:2], field(lambda f: f.status, object), {"long_name": "ok, or why there is no window"}),
            "graze": ((), form.graze, about | {"long_name": "value at the graze of the steady response"}),
            "distance": (
                dims[1:], np.abs(edge[-1] - form.graze),
                about | {"long_name": "distance of the flow's edge from the graze"},
            ),
        },
        {
            "rung": rungs,
            "N": ("N", periods, {"long_name": "periods between impacts", "units": "1"}),
            "side": list(SIDES),
        },
        {
            "title": f"the ladder of reductions: windows of one-impact orbits in {form.name}",
            "parameter": form.name,
            "model": repr(model),
            "parameters": json.dumps(dict(model.params)),
            "graze": form.graze,
            "lam": form.lam,
            "l": form.l,
            "b": form.b,
            "det": form.det,
            "span": list(span),
            "meaning": "; ".join(f"{rung}: {RUNGS[rung]}" for rung in rungs),
            "arithmetic": "strict",
            **model.attributes,
        },
    )  # fmt: skip
