"""Loci: where a special point lies as a second parameter varies, and the points of codimension two on the way."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from grazing.copies import ByValue
from grazing.orbits.branch import checked_bounds, checked_step
from grazing.orbits.contacts import model_of, sizes_of
from grazing.orbits.corrector import Point, at_value, closed, linearised, tangent_of
from grazing.orbits.equations import Equations, Test
from grazing.orbits.even_equations import evenly
from grazing.orbits.orbit import Orbit
from grazing.orbits.path import Path, follow, joined
from grazing.orbits.piece_letters import border_units
from grazing.orbits.piece_orbit import PieceOrbit
from grazing.orbits.signature import equations_of
from grazing.orbits.solved import Solved
from grazing.orbits.special import SPECIAL, Special
from grazing.orbits.switching import ZERO
from grazing.outcome import InputError, abridged, listed, shown
from grazing.parameter import in_order, spread, value_of, whole

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]

#: Special points that are zeros of one test function.
FOLLOWED = ("lp", "pd", "ns", "bp", "gr", "bcb", "v0", "law")
#: Part of an unknown's size by which it is moved to see how a test function changes.
MOVED = 1e-5
#: A fold whose second parameter turns round at a point where the first one does, too, is a cusp.
STANDS = 1e-5
#: Multipliers of a pair whose product differs from 1 by less lie on the unit circle, two that differ by less are one.
DOUBLE = 1e-3
#: Meetings nearer than this part of both ranges are one, if their orbits differ by less than that part of their size.
SAME, ALIKE = 1e-7, 1e-3


class LocusEquations(Equations):
    """The equations of an orbit and one test function of it, with the first of two parameters among the unknowns."""

    def __init__(
        self, base: Equations, type: str, where: int, bounds: tuple[float, float], x: Floats, p: Floats
    ) -> None:
        self.base, self.type, self.bounds = base, type, bounds
        self.names, self.N = base.names, base.N
        self.spans = base.spans[1:]
        self.scale = np.append(base.scale, base.spans[0])
        tests = base.tests(x, p)
        # at a graze of a passive wall an impact's speed and a dip's depth are one thing, and the speed is smoother
        alike = {"gr": ("v0", "gr"), "v0": ("v0", "gr"), "bp": ("lp",)}.get(type, (type,))
        places = [i for i, test in enumerate(tests) if test.type in alike and test.where in (where, -1)]
        if not places:
            raise InputError(
                f"this {type} cannot be followed: a map of one's own says on which side of a border a point lies, not "
                f"how far from it. Give it by pieces, gz.Map(pieces=..., border=...), follow lp, pd and ns of it, or "
                f"find the {type} with gz.continuation at several values of the second parameter"
            )
        self._wall = base.touched(type, where)[1]
        self._index = min(places, key=lambda i: (max(abs(tests[i].value), ZERO), alike.index(tests[i].type)))
        self._kinds = tuple(test[::2] for test in tests)

    def split(self, X: Floats, p: Floats) -> tuple[Floats, Floats]:
        """Return the unknowns of the orbit and both parameters."""
        return X[:-1], np.array([X[-1], p[-1]])

    def defects(self, X: Floats, p: Floats) -> tuple[Floats, Floats]:
        """Return the defects of the orbit and the test function, with their derivatives."""
        F, J, _slopes = self.expanded(X, p)
        return F, J

    def expanded(self, X: Floats, p: Floats) -> tuple[Floats, Floats, Floats]:
        """Return the defects of the orbit and the test function, with their derivatives, those in p apart."""
        x, both = self.split(X, p)
        n = len(x)
        F, J, slopes = self.base.expanded(x, both)
        wide = np.full((n + 1, n + 2), np.nan)
        if not (np.isfinite(F).all() and np.isfinite(J).all()):
            return np.full(n + 1, np.nan), wide[:, :-1], wide[:, -1:]
        h = MOVED * np.append(self.scale, self.spans[0])
        around = np.append(x, both) + np.concatenate([np.zeros((1, n + 2)), np.diag(h), -np.diag(h)])
        kind = self._kinds[self._index]
        heights = self.base.heights(around[:, :n], around[:, n:], self._index, kind)
        wide[:n, :n], wide[:n, n:] = J, slopes
        wide[n] = (heights[1 : n + 3] - heights[n + 3 :]) / (2.0 * h)
        return np.append(F, heights[0]), wide[:, :-1], wide[:, -1:]

    def tests(self, X: Floats, p: Floats) -> tuple[Test, ...]:
        """Return the other test functions of the orbit: where one of them is zero, two things happen at once."""
        x, both = self.split(X, p)
        others = (test for i, test in enumerate(self.base.tests(x, both)) if i != self._index)
        return tuple(
            Test(f"{self.type}+{test.type}", test.value, test.where) for test in others if not self._same_touch(test)
        )

    def _same_touch(self, test: Test) -> bool:
        """Whether a test function is about the touch that is followed, which may happen in each of several periods."""
        if self.type != "gr" or test.type not in ("gr", "v0"):
            return False
        return abs(test.value) <= ZERO and self.base.touched(test.type, test.where)[1] == self._wall

    def broken(self, X: Floats, p: Floats) -> str:
        """Say whether the first parameter has left its range, or the orbit is none any more."""
        x, both = self.split(X, p)
        low, high = self.bounds
        if not low <= both[0] <= high:
            return "bounds"
        return self.base.broken(x, both)

    def orbit(self, X: Floats, p: Floats) -> Orbit:
        """Return the orbit."""
        return self.base.orbit(*self.split(X, p))


class Meeting(NamedTuple):
    """A point of codimension two: its type such as *gr+lp* or *cusp*, both parameters, the orbit, and its trust.

    Where more than two things happen at once, as at a resonant graze, all of them are in its type: *gr+lp+pd*.
    """

    type: str
    values: tuple[float, float]
    orbit: Orbit
    converged: bool


@dataclass(frozen=True, eq=False)
class Locus(ByValue):
    """Where a special point lies in the plane of two parameters; see :func:`locus`.

    Parameters
    ----------
    type : str
        Of the special point.
    parameters : (str, str)
    bounds : ((low, high), (low, high))
    values : ndarray, shape (n, 2)
    orbits : sequence of Orbit
    meetings : tuple of Meeting
    ends : (str, str)
        Why it ends at either end.
    """

    type: str
    parameters: tuple[str, str]
    bounds: tuple[tuple[float, float], tuple[float, float]]
    values: Floats
    orbits: Sequence[Orbit]
    meetings: tuple[Meeting, ...]
    ends: tuple[str, str]

    def __repr__(self) -> str:
        met = (
            listed(
                f"{one.type} ({one.values[0]:.6g}, {one.values[1]:.6g}){'' if edge(one.orbit) else ' (virtual)'}"
                for one in self.meetings
            )
            or "none"
        )
        of = f"{self.type} of {abridged(self.orbits[0].word)}"
        return f"<Locus of {of} in {', '.join(self.parameters)}; meetings: {met}>"

    @property
    def dataset(self) -> xr.Dataset:
        """The locus as a labelled table: dimensions ``point`` and ``meeting``."""
        from grazing.late import xarray as xr

        P = self.orbits[0].map
        columns: dict[str, Any] = {}
        for j, name in enumerate(self.parameters):
            about = P.describe(name)
            attrs = about.attributes
            columns[name] = "point", self.values[:, j], attrs
            columns[f"meeting_{name}"] = (
                "meeting",
                np.array([one.values[j] for one in self.meetings], np.float64),
                attrs,
            )
        columns["admissible"] = (
            "point",
            np.array([int(edge(o)) for o in self.orbits], np.int8),
            {"long_name": "admissible"},
        )
        kinds = np.array([one.type for one in self.meetings], dtype=object)
        columns["meeting_type"] = "meeting", kinds, {"long_name": "what happens at once"}
        kept = np.array([int(edge(one.orbit)) for one in self.meetings], np.int8)
        columns["meeting_admissible"] = "meeting", kept, {"long_name": "admissible"}
        attributes = {
            "title": f"{SPECIAL[self.type].split(':')[0]} of {self.orbits[0].word} in {' and '.join(self.parameters)}",
            "type": self.type, "word": self.orbits[0].word, "period": self.orbits[0].period,
            "parameters": json.dumps(list(self.parameters)), "bounds": json.dumps([list(b) for b in self.bounds]),
            "map": P.name or "map", "map_parameters": json.dumps(dict(P.params)), "ends": json.dumps(list(self.ends)),
            **P.origin.attributes,
        }  # fmt: skip
        return xr.Dataset(columns, attrs=attributes)


def edge(orbit: Orbit) -> bool:
    """Whether an orbit is admissible, or only just not: on a locus of grazes it is on the edge."""
    clearance = getattr(orbit, "clearance", None)
    if clearance is None:
        return orbit.admissible
    fast, model = getattr(orbit, "incoming", np.empty(0)), model_of(orbit.map)
    height, speed = (1.0, 1.0) if model is None else sizes_of(model)  # units of its own
    if isinstance(orbit, PieceOrbit):
        height = float(border_units(orbit.map).max())
    return bool(clearance > -1e-9 * height and (fast < 1e-9 * speed).all())


def on_the_circle(orbit: Orbit) -> bool:
    """Whether two multipliers have the product 1, a complex pair or, on a locus of lp or pd, 1 or -1 twice."""
    roots = orbit.multipliers
    if not np.isfinite(roots).all():
        return False
    pairs = [(roots[i], roots[j]) for i in range(len(roots)) for j in range(i)]
    return any(abs(a * b - 1.0) < DOUBLE and (a.imag != 0.0 or abs(a - b) < DOUBLE) for a, b in pairs)


def name_of(parts: Iterable[str]) -> str:
    """Return the one name of a point of codimension two on whichever locus: a cusp first, then by letter."""
    each = sorted(parts)
    once = list(dict.fromkeys(each))
    once = each if len(once) == 1 else once  # two things of one type, as two grazes
    if "cusp" in once:
        once = ["cusp", *(part for part in once if part not in ("cusp", "lp"))]
    return "+".join(once)


def always_zero(path: Path) -> set[tuple[str, int]]:
    """Return type and place of the test functions that are zero along a path: their signs are those of rounding."""
    zeros = Counter((test.type, test.where) for q in path.points for test in q.tests if abs(test.value) <= ZERO)
    return {which for which, count in zeros.items() if 2 * count > len(path.points)}


def met_once(met: Iterable[Meeting], spans: Floats) -> tuple[Meeting, ...]:
    """Return meetings, those at one point as one, with all that happens there in its type."""
    found: list[Meeting] = []
    for one in met:
        for i, known in enumerate(found):
            if same_meeting(one, known, spans):
                parts = {*known.type.split("+"), *one.type.split("+")}
                kind = known.type if len(parts) == 1 else name_of(parts)
                found[i] = known._replace(type=kind, converged=known.converged and one.converged)
                break
        else:
            found.append(one)
    return tuple(found)


def same_meeting(one: Meeting, other: Meeting, spans: Floats) -> bool:
    """Whether two meetings are one point: the same parameters, and the same orbit begun at whatever point."""
    if (np.abs(np.subtract(one.values, other.values)) > SAME * spans).any():
        return False
    a, b = one.orbit.points, other.orbit.points
    size = np.abs(a).max(initial=0.0) + np.ptp(a, axis=0)
    return len(a) == len(b) and any((np.abs(np.roll(b, k, axis=0) - a) <= ALIKE * size).all() for k in range(len(a)))


def trim(path: Path, equations: LocusEquations) -> None:
    """Move the ends of a path that lie beyond the range of the first parameter to its edge."""
    low, high = (bound / float(equations.scale[-1]) for bound in equations.bounds)
    for last, inner in ((0, 1), (-1, -2)):
        while len(path.points) > 2 and not low <= path.points[inner].z[-2] <= high:
            path.points.pop(last)  # a meeting beyond the edge has a point of its own
        value = float(path.points[last].z[-2])
        if low <= value <= high:
            continue
        there = at_value(equations, path.points[inner], path.points[last], low if value < low else high, -2)
        if there is not None:
            path.points[last] = there
            continue
        path.points.pop(last)
        if last == 0:
            path.began = "lost"
        else:
            path.ended = "lost"


def locus(
    special: Special,
    names: tuple[str, str],
    bounds: tuple[tuple[float, float], tuple[float, float]],
    *,
    step: float = 0.03,
    limit: int = 1000,
) -> Locus:
    """Follow a special point of a branch in two parameters.

    Parameters
    ----------
    special : Special
        Of type lp, pd, ns, gr, bcb, v0 or law; or a bp at which the symmetry of an orbit between walls breaks, in
        parameters that keep the symmetry of the model.
    names : (str, str)
        Two different parameters of its map; between walls ``r`` stands for ``A.r`` and ``B.r``.
    bounds : ((low, high), (low, high))
        Their ranges; the values at the special point lie inside.
    step : float
        Longest step, as in :func:`continuation`.
    limit : int
        Most points in each direction.

    Returns
    -------
    Locus
        With its meetings, the points of codimension two where another test function is zero as well (*gr+pd*, ...) or
        a fold turns round in both parameters (*cusp*). Beyond *ns+pd* and *ns+lp* one of type ns goes on with two real
        multipliers of product 1, a neutral saddle: no torus is born there.

    Raises
    ------
    InputError
        For a special point of another type, unknown or equal parameters, or ranges that do not hold it.

    Examples
    --------
    >>> import grazing as gz
    >>> orbit = gz.one_impact_orbits(gz.pinball(d=0.11, V=0.4), 3)[0]
    >>> branch = gz.continuation(orbit.map, orbit, "d", (0.09, 0.13))
    >>> graze = branch.special[0]
    >>> curve = gz.locus(graze, ("d", "V"), ((0.0, 0.14), (0.2, 0.6)))
    >>> curve.type, bool((abs(curve.orbits[-1].clearance) < 1e-12))
    ('gr', True)
    """
    if not isinstance(special, Special) or special.type not in FOLLOWED:
        got = special.type if isinstance(special, Special) else type(special).__name__
        instead = "; find an ep with gz.continuation at several values of the second parameter" if got == "ep" else ""
        raise InputError(
            f"{got} cannot be followed in two parameters; allowed are special points {', '.join(FOLLOWED)}{instead}"
        )
    try:
        (one, other), (first, second) = in_order(names), in_order(bounds)
    except (TypeError, ValueError):
        raise InputError(
            f"names {shown(names)}, bounds {shown(bounds)}; give two names and two pairs (low, high)"
        ) from None
    if not (isinstance(one, str) and isinstance(other, str)):
        raise InputError(f"names {shown(names)}; give two names of parameters, such as ('d', 'V')")
    names = str(one), str(other)
    one, other = names
    if one == other:
        raise InputError(f"both parameters are {shown(one)}; give two different ones")
    P = special.orbit.map
    ranges = checked_bounds(P, one, first), checked_bounds(P, other, second)
    spread(dict.fromkeys(names), P.params, "the map")  # r and A.r are no two parameters
    p = np.array([value_of(one, P.params), value_of(other, P.params)])
    for name, value, (low, high) in zip(names, p, ranges, strict=True):
        if not low <= value <= high:
            raise InputError(
                f"the special point has {name} = {value:g}, outside of [{low:g}, {high:g}]; widen the range"
            )
    spans = np.array([high - low for low, high in ranges])
    base, x = equations_of(special.orbit, (one, other), spans)
    if special.type == "bp":
        base, x = evenly(special, base, x, p)
    equations = LocusEquations(base, special.type, special.where, ranges[0], x, p)
    X = closed(equations, np.append(x, p[0]), p[1:])
    if X is None:
        raise InputError(f"{shown(special)} is not regular in {one}: vary other parameters, or begin at another point")
    z = np.concatenate([X / equations.scale, p[1:] / equations.spans])
    _F, wide = linearised(equations, z)
    ahead = np.zeros(len(z))
    ahead[-1] = 1.0
    start = Point(z, tangent_of(wide, ahead), equations.tests(X, p[1:]))
    most = whole(limit, "limit", 2)
    step = checked_step(step)
    forward = follow(equations, start, ranges[1], step=step, limit=most)
    back = start._replace(tangent=-start.tangent)
    path = (
        forward
        if forward.ended == "closed"
        else joined(follow(equations, back, ranges[1], step=step, limit=most), forward)
    )
    trim(path, equations)
    solutions = [path.unscaled(q.z) for q in path.points]
    low, high = ranges[0]
    met = []
    always = always_zero(path)
    for _index, event in path.events:
        if (event.type, event.where) in always:
            continue
        X, q = path.unscaled(event.point.z)
        kind = event.type
        if kind in ("lp", "bp"):  # the second parameter turns round: a cusp if the first one stands still too
            if special.type != "lp" or abs(event.point.tangent[-2]) > STANDS:
                continue
            kind = "cusp"
        orbit = equations.orbit(X, q)
        if kind.endswith("+ns") and not on_the_circle(orbit):
            continue
        if low <= X[-1] <= high:
            own, *others = kind.split("+")
            both = np.array([X[-1], q[-1]])
            kind = name_of([own, *(base.called(other, event.where, both)[0] for other in others)])
            met.append(Meeting(kind, (float(X[-1]), float(q[-1])), orbit, event.converged))
    values = np.array([[X[-1], q[-1]] for X, q in solutions])
    orbits = Solved(solutions, equations)
    return Locus(special.type, (one, other), ranges, values, orbits, met_once(met, spans), (path.began, path.ended))
