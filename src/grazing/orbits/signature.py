"""From an orbit to the equations that it solves: flown once, if need be, to see its impacts."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from grazing.late import named
from grazing.maps.map import Map
from grazing.orbits.contacts import (
    left_walls,
    model_of,
    numbered,
    on_wall,
    pieces_of,
    relative,
    strobes_of,
)  # fmt: skip
from grazing.orbits.equations import Equations
from grazing.orbits.free_equations import FreeEquations
from grazing.orbits.impact_equations import ImpactEquations
from grazing.orbits.impact_orbit import ImpactOrbit
from grazing.orbits.map_equations import MapEquations
from grazing.orbits.orbit import Orbit
from grazing.orbits.piece_equations import PieceEquations
from grazing.orbits.piece_letters import letters_from, one_sided
from grazing.orbits.piece_orbit import PieceOrbit
from grazing.orbits.resting import resting_equations
from grazing.oscillator.trajectory import trajectory
from grazing.outcome import CHATTER, STUCK, InputError, listed

Floats = NDArray[np.float64]

#: A ball that is so near to a wall, in sizes of the map's box, and as fast to that part of a speed, lies on it.
LYING = 1e-12
#: Share of a parameter by which it is changed, towards 0, to see whether that moves a wall.
ASIDE = 2.0**-20


def equations_of(orbit: Orbit, names: tuple[str, ...], spans: Any = None) -> tuple[Equations, Floats]:
    """Return the equations that an orbit solves in these parameters, and its unknowns.

    Raises
    ------
    InputError
        For parameters that the map does not have, and for an orbit that rests on the wall.
    """
    found: tuple[Equations, Floats] = named(orbit.solves)(orbit, names, spans)
    return found


def of_impacts(orbit: ImpactOrbit, names: tuple[str, ...], spans: Any) -> tuple[Equations, Floats]:
    """Return the equations of the impacts of an orbit, or of its free flight."""
    if not orbit.impacts:
        free = FreeEquations(orbit.model, names, spans)
        return free, free.state(orbit)
    pieces = pieces_of(orbit.model, orbit.incoming, numbered(orbit.model, orbit.walls))
    equations = ImpactEquations(orbit.model, names, orbit.period, pieces, spans)
    return equations, np.concatenate([orbit.times, orbit.outgoing])


def of_section(orbit: Orbit, names: tuple[str, ...], spans: Any) -> tuple[Equations, Floats]:
    """Return the equations of an orbit of a section that shows the oscillator exactly: of its impacts, or its rests."""
    P = orbit.map
    if P.section == "strobe" and (P.walled is not None or P.params.get("phase") == 0.0) and rests(orbit):
        if P.walled is None:
            return resting_equations(P, names, orbit.points, spans), np.zeros(1)
        return _rested(orbit, names, spans)
    return of_impacts(flown(orbit), names, spans)


def of_points(orbit: Orbit, names: tuple[str, ...], spans: Any) -> tuple[Equations, Floats]:
    """Return the equations of the points of an orbit, on the pieces of its map if it has some.

    Where a piece of its word ends at its border after all, they are those of maps that are not by pieces, which do too.
    """
    if orbit.map.formulas is None:
        return mapped(orbit, names, spans)
    P = orbit.map
    if isinstance(orbit, PieceOrbit):
        letters, roots = orbit.letters, np.sign(orbit.margins) * np.sqrt(np.abs(orbit.margins))
    else:
        letters, roots = letters_from(P, orbit.points)
    if len(letters) != orbit.period:
        raise InputError(f"{orbit!r} has {len(letters)} points for period {orbit.period}")
    ends = one_sided(P)
    if any(ends[k] for k in letters):
        plain, x = MapEquations(P, names, letters, spans), orbit.points.ravel().copy()
        if plain.visited(x, np.array([P.params[name] for name in names]))[1] == letters:
            return plain, x
    equations = PieceEquations(P, names, letters, spans)
    return equations, equations.unknowns(orbit.points, roots)


def _rested(orbit: Orbit, names: tuple[str, ...], spans: Any) -> tuple[Equations, Floats]:
    """Return the equations of an orbit that rests between walls: those of its releases, or as its map has it."""
    P = orbit.map
    try:
        if P.params.get("phase") == 0.0:
            return resting_equations(P, names, orbit.points, spans), np.zeros(1)
    except InputError:  # it lies throughout, or is released elsewhere
        pass
    if _lies(orbit, names):
        raise InputError(
            f"the orbit rests on a wall when its map looks at it, and {listed(names)} moves that wall: it cannot be "
            "followed; take another phase if it is released at one, or scan the parameter with gz.orbit_diagram"
        )
    return mapped(orbit, names, spans)


def _lies(orbit: Orbit, names: tuple[str, ...]) -> bool:
    """Whether the ball is on a wall, and as fast, that parameters move: on one side of that state there is no other."""
    P, model = orbit.map, model_of(orbit.map)
    assert model is not None
    here = _on_walls(P)
    moves = np.zeros(len(here), bool)
    for name in names:
        value = P.params[name]
        there = _on_walls(P.replace(**{name: (1.0 - ASIDE) * value if value else ASIDE * model.unit_of(name)}))
        moves |= (there != here).any(axis=1)
    size = np.array([high - low for low, high in P.box])
    lies = (np.abs(orbit.points[:, None] - here[None]) < LYING * size).all(axis=2).any(axis=0)
    return bool((lies & moves).any())


def _on_walls(P: Map) -> Floats:
    """Return the states (walls, 2) of balls that lie on the walls when the map looks."""
    model = model_of(P)
    assert model is not None
    return np.array([on_wall(model, j, P.params["phase"]) for j in range(len(model.walls))])


def mapped(orbit: Orbit, names: tuple[str, ...], spans: Any) -> tuple[Equations, Floats]:
    """Return the equations of an orbit as its map has them, between grazes."""
    letters = tuple(orbit.map.orbit(point, 1).letters[0] for point in orbit.points)
    return MapEquations(orbit.map, names, letters, spans), orbit.points.ravel().copy()


def rests(orbit: Orbit) -> bool:
    """Whether an orbit comes to rest on the wall."""
    return bool(np.any(orbit.map.orbit(orbit.points[0], orbit.period).outcomes & (CHATTER | STUCK)))


def flown(orbit: Orbit) -> ImpactOrbit:
    """Return an orbit of a section of the oscillator with its impacts, closed by Newton's method.

    Raises
    ------
    InputError
        For an orbit that comes to rest on the wall, or does not close.
    """
    P, model = orbit.map, model_of(orbit.map)
    assert model is not None
    if P.section == "impact":
        start, after = map(float, orbit.points[0])
        u, v = on_wall(model, int(left_walls(model, orbit.points[0, 1])), start)
        state = u, v + after
        strobes = strobes_of(P, P.orbit(orbit.points[0], orbit.period).letters)
        N, count = int(strobes.sum()), orbit.period
        beyond = 0.5  # the last impact is where the flight would end, or beside it by rounding
    else:
        start, state = P.params.get("phase", 0.0), (float(orbit.points[0, 0]), float(orbit.points[0, 1]))
        N, count, beyond = orbit.period, None, 0.0
    path = trajectory(model, state, start=start, until=start + (N + beyond) * model.period, samples=2)
    if path.attrs["grazing_outcome"] & (CHATTER | STUCK):
        raise InputError(f"{orbit!r} comes to rest on the wall; give it as one of gz.stroboscopic_map(model), phase 0")
    times = path["impact_time"].values[:count]
    walls = numbered(model, path["impact_wall"].values[:count]) if "impact_wall" in path else [0] * len(times)
    incoming, outgoing = (relative(model, walls, times, path[key].values[:count]) for key in ("v_minus", "v_plus"))
    shift = model.period * np.floor(times[0] / model.period) if len(times) else 0.0
    nothing = np.empty(0)
    if not len(times):
        free = FreeEquations(model, ())
        return free.orbit(free.start(nothing), nothing)
    equations = ImpactEquations(model, (), N, pieces_of(model, incoming, walls))
    first = np.concatenate([times - shift, outgoing])
    guess = first[None].copy()
    closes = equations.solve(guess, nothing)[0] < 1e-9
    if not closes or np.abs((guess[0] - first) / equations.scale).max() > 1e-3:
        raise InputError(f"{orbit!r} does not close when it is flown; its points are not those of a periodic orbit")
    return equations.orbit(guess[0], nothing)
