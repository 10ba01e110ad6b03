"""Branches: an orbit followed in a parameter, through folds and grazes, with all that happens on the way."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from grazing.copies import ByValue
from grazing.maps.map import Map
from grazing.orbits.branch_table import branch_table
from grazing.orbits.corrector import closed
from grazing.orbits.equations import Equations
from grazing.orbits.orbit import Orbit
from grazing.orbits.signature import equations_of
from grazing.orbits.special import Relabelling, Special
from grazing.orbits.switching import Seed, seeded, seeded_at_fold, switched, turns
from grazing.outcome import InputError, abridged, listed, shown
from grazing.parameter import checked_name, named_by, real, refuse_ends, value_of, whole

if TYPE_CHECKING:
    import xarray as xr
from grazing.orbits.branch_search import Piece, Pieces, Work

Floats = NDArray[np.float64]

#: Narrowest range, in units of its ends.
NARROWEST = 1e-10
#: Points that following takes in all, unless more are asked for: some 100 s.
POINTS = 20_000


@dataclass(frozen=True, eq=False)
class Branch(ByValue):
    """An orbit followed in a parameter; see :func:`continuation`.

    Parameters
    ----------
    map : Map
        The map at the parameter value where the branch was begun.
    parameter : str
        Name of the parameter.
    bounds : (low, high)
        Its range.
    pieces : tuple of Piece
        The first one holds the orbit that the branch was begun with; the others begin at grazes.
    special : tuple of Special
        In the order in which they lie on the pieces.
    relabellings : tuple of Relabelling
        Where an impact crosses the strobe; no bifurcations.
    unfollowed : int
        Grazes at which further pieces begin that were not followed, as the limit of points was reached.
    """

    map: Map
    parameter: str
    bounds: tuple[float, float]
    pieces: tuple[Piece, ...]
    special: tuple[Special, ...]
    relabellings: tuple[Relabelling, ...]
    unfollowed: int = 0

    def __repr__(self) -> str:
        low, high = self.bounds
        names = (
            listed(f"{one.type} {one.value:.6g}{'' if one.admissible else ' (virtual)'}" for one in self.special)
            or "no special point"
        )
        words = listed(map(abridged, dict.fromkeys(orbit.word for orbit in self)), 8)
        rest = f"; unfinished: {self.unfinished}" if self.unfinished else ""
        return f"<Branch of {words} in {self.parameter} [{low:g}, {high:g}]: {names}{rest}>"

    @property
    def complete(self) -> bool:
        """Whether it was followed to its ends: neither was a limit of points reached, nor a piece lost."""
        return not self.unfinished

    @property
    def cut(self) -> bool:
        """Whether a piece or the branch has reached the limit of its points."""
        return self.unfollowed > 0 or any("limit" in piece.ends for piece in self.pieces)

    @property
    def unfinished(self) -> str:
        """Why it was not followed to its ends; empty if it was."""
        if self.cut:
            return "the limit of points was reached before the end of the branch"
        lost = any("lost" in piece.ends for piece in self.pieces)
        return "where a piece is lost, Newton's method finds no next point; what is beyond is not known" if lost else ""

    def __iter__(self) -> Iterator[Orbit]:
        for piece in self.pieces:
            yield from piece.orbits

    @property
    def dataset(self) -> xr.Dataset:
        """The branch as a labelled table, see :func:`grazing.orbits.branch_table.branch_table`."""
        return branch_table(self)

    def at(self, value: float) -> tuple[Orbit, ...]:
        """Return every orbit of the branch at one value of the parameter, solved there.

        Parameters
        ----------
        value : float

        Returns
        -------
        tuple of Orbit
            In the order in which the branch passes them; empty where it has none.
        """
        value = real(value, self.parameter, f"give a value in [{self.bounds[0]:g}, {self.bounds[1]:g}]")
        places = ((piece, i) for piece in self.pieces for i in piece.passing(value))
        found = (piece.between(i, value) for piece, i in places if i == 0 or piece.values[i] != value)
        return tuple(orbit for orbit in found if orbit is not None)


def continuation(
    P: Map,
    orbit: Orbit | Special,
    name: str,
    bounds: tuple[float, float],
    *,
    step: float = 0.03,
    limit: int = 2000,
    points: int = POINTS,
) -> Branch:
    """Follow a periodic orbit in a parameter, by pseudo-arclength, and locate all that happens to it.

    Parameters
    ----------
    P : Map
        The map of the orbit, at the value where it is known.
    orbit : Orbit or Special
        Where to begin; from a special point of type pd or bp of another branch the branch that crosses it there.
    name : str
        Any parameter of the map.
    bounds : (low, high)
        Range of the parameter; the orbit's own value lies inside.
    step : float
        Longest step, in units of the range and of the natural size of times and velocities.
    limit : int
        Most points of one piece.
    points : int
        Most points of all pieces together. Without damping, grazes can begin pieces with ever more impacts, without
        end.

    Returns
    -------
    Branch
        Pieces, special points with brackets, relabellings. Virtual orbits are followed too, and marked. What was found
        when a limit was reached or a piece was lost is kept; ``branch.complete`` is False then, and
        ``branch.unfinished`` says why.

    Raises
    ------
    InputError
        For an orbit of another map, an unknown parameter, a range that does not hold the orbit's value, or an orbit
        that does not solve its own equations.

    Notes
    -----
    An orbit of the oscillator is followed in the times and velocities of its impacts (:mod:`grazing.orbits.closing`),
    in which nothing is singular at a graze: the speed of an impact passes through zero, and beyond it the orbit is
    virtual. Where the law leaves a ball that touches the wall with no speed (V = 0), a graze joins two branches, one
    with an impact more than the other; the branch goes on along the admissible part of both. Where it kicks the ball
    (V > 0), an orbit ends at a graze: its continuation is virtual.

    References
    ----------
    Ghosh and Simpson, arXiv:2510.16218, follow the velocity instead of the section's map for the same reason.

    Examples
    --------
    >>> import grazing as gz
    >>> m = gz.pinball(d=0.11, V=0.4)
    >>> orbit = gz.one_impact_orbits(m, 3)[0]
    >>> branch = gz.continuation(orbit.map, orbit, "d", (0.09, 0.13))
    >>> [(point.type, round(point.value, 9)) for point in branch.special if point.admissible]
    [('gr', 0.098450445), ('pd', 0.12328145), ('v0', 0.123908389)]
    """
    return followed(P, orbit, name, bounds, step, limit, Work(whole(points, "points", 2)))


class Unsettled(InputError):
    """The points of an orbit are not those of a periodic orbit of its period: its equations lead elsewhere."""


def followed(
    P: Map, orbit: Orbit | Special, name: str, bounds: tuple[float, float], step: float, limit: int, work: Work
) -> Branch:
    """Return the branch through an orbit, see :func:`continuation`; stop when there is no work left."""
    low, high = checked_bounds(P, name, bounds)
    step = checked_step(step)
    if isinstance(orbit, Special):
        seeds = switched(orbit, name, (low, high))
    elif isinstance(orbit, Orbit):
        equations, x, value = own_equations(P, orbit, name, (low, high))
        seeds = [begun(equations, x, value, orbit, name)]
    else:
        raise InputError(f"orbit is {shown(orbit)}; give an Orbit, or a special point of a branch")
    search = Pieces(name, (low, high), step, whole(limit, "limit", 2), seeds, work)
    while search.waiting and work.left > 1:
        search.advance()
    found = tuple(search.pieces), tuple(search.special), tuple(search.relabellings)
    return Branch(P, name, (low, high), *found, len(search.waiting))


def checked_step(step: Any) -> float:
    """Return the longest step as a float > 0, or raise InputError."""
    length = real(step, "step", "give a length in scaled units, such as 0.03")
    if not length > 0.0:
        raise InputError(f"step is {length:g}; give a length > 0, such as 0.03")
    return length


def checked_bounds(P: Map, name: str, bounds: Any) -> tuple[float, float]:
    """Return the range of a parameter as two floats, or raise InputError."""
    if not isinstance(P, Map):
        raise InputError(f"P is {shown(P)}; give a map, such as gz.stroboscopic_map(model)")
    checked_name(name, P.params, P.name or "the map")
    try:
        low, high = bounds
    except (TypeError, ValueError):
        raise InputError(f"bounds is {shown(bounds)}; give the pair (low, high) of values of {name}") from None
    low, high = P.describe(name).check(low), P.describe(name).check(high)
    low, high = real(low, name, "give a finite value"), real(high, name, "give a finite value")
    refuse_ends(low, high, f"bounds of {name} are ({low:g}, {high:g})")
    if P.walled is not None and name in P.walled.params:
        for end in (low, high):  # room between walls is least at an end: it is a least of linear functions
            try:
                P.walled.replace(**{name: end})
            except InputError as error:
                raise InputError(f"bounds of {name} are ({low:g}, {high:g}); at {end:g} {error}") from None
    if high - low < NARROWEST * max(abs(low), abs(high)):
        raise InputError(f"bounds of {name} are {high - low:.1e} apart; double precision needs a wider range")
    return low, high


def own_equations(P: Map, orbit: Orbit, name: str, bounds: tuple[float, float]) -> tuple[Equations, Floats, float]:
    """Return the equations of an orbit of a map, its unknowns and its value of a parameter; refuse another's orbit."""
    low, high = bounds
    value = value_of(name, orbit.map.params)
    moved = (*named_by(name, P.params), *P.origin.followers)
    differ = [
        key for key, x in orbit.map.params.items() if key not in P.params or not (key in moved or P.params[key] == x)
    ]
    if differ:
        raise InputError(
            f"{shown(orbit)} is an orbit of {shown(orbit.map)}, not of {shown(P)}: {', '.join(differ)}; give "
            f"its own map"
        )
    if not low <= value <= high:
        raise InputError(f"the orbit is known at {name} = {value:g}, outside of [{low:g}, {high:g}]; widen the range")
    return *equations_of(orbit, (name,), np.array([high - low])), value


def begun(equations: Equations, x: Floats, value: float, orbit: Orbit, name: str) -> Seed:
    """Return where a branch begins that holds a given orbit."""
    p = np.array([value])
    if equations.linear and orbit.degenerate:
        raise Unsettled(
            f"{shown(orbit)} is one of a continuum at {name} = {value:g}: a multiplier is 1, and no branch leads "
            "through one of them alone; begin with an orbit that has impacts"
        )
    solved = closed(equations, x, p)
    if solved is None:  # at a fold the derivative is singular; across it, it is not
        fold = seeded_at_fold(equations, x, p)
        if fold is not None:
            return Seed(equations, fold, both=True)
    if solved is None or np.abs((solved - x) / equations.scale).max(initial=0.0) > 1e-3:
        raise Unsettled(
            f"{shown(orbit)} does not solve its own equations at {name} = {value:g}: Newton's method "
            f"{'fails' if solved is None else 'goes elsewhere'}; begin with an orbit of gz.periodic_orbits"
        )
    k = turns(equations, solved, p)
    if k > 1:
        raise Unsettled(
            f"{shown(orbit)} goes {k} times round an orbit of period {orbit.period // k}: begin with that one; "
            f"near a period doubling a settling orbit can look like one of period {orbit.period}"
        )
    return Seed(equations, seeded(equations, solved, p), both=True)
