"""Responses: what instruments read along sweeps up and down and from random starts, with the branches through it."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from grazing.compare.bifurcation_diagram import documented, with_limit
from grazing.compare.search import Search, merged, same_attractor
from grazing.maps.columns import Columns
from grazing.maps.map import Map
from grazing.orbits.branch import POINTS, Branch
from grazing.orbits.branch_search import Piece
from grazing.orbits.branch_table import branch_table, special_once
from grazing.orbits.contacts import numbered
from grazing.orbits.impact_orbit import ImpactOrbit
from grazing.orbits.orbit import Orbit
from grazing.oscillator.gauge import flown_cycle, gauged, readings_of, repeated_cycle
from grazing.oscillator.spring import refuse_stiffness
from grazing.outcome import InputError, shown
from grazing.parameter import checked_name, whole
from grazing.studies import labels
from grazing.studies.growth import on_cycles
from grazing.studies.orbit_diagram import orbit_diagram
from grazing.studies.outside import NAME, with_note
from grazing.studies.plan import Progress
from grazing.studies.recurrence import ENDED, UNDECIDED
from grazing.studies.runs import checked_values

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]

#: Ways to come to a value, before the random starts.
SWEEPS = ("up", "down")
#: Orbits of a branch that are nearer to a special point, in units of the range, are at it.
ROUNDING = 1e-12
#: What is kept of the scans beside the readings.
KEPT = ("period", "word", "outcome", "trust")


def response(
    P: Map,
    name: str,
    values: ArrayLike,
    *,
    starts: int | ArrayLike = 20,
    transient: int = 400,
    keep: int = 48,
    seed: int = 0,
    period: int = 1,
    points: int = POINTS,
    box: Sequence[tuple[float, float]] | None = None,
    threads: int | None = None,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Return the response of an oscillator over a parameter, such as its frequency, as instruments on a rig record it.

    Parameters
    ----------
    P : Map
        The stroboscopic map of an oscillator, over one wall or between several.
    name : str
        Which of its parameters varies.
    values : array_like, shape (m,)
        Its values, at least 2 different ones.
    starts, transient, keep, seed, box, threads, progress
        Of the random starts, as in :func:`grazing.orbit_diagram`; each sweep makes the same steps at each value.
    period : int
        Attractors up to this period, in periods of the forcing, are followed as branches.
    points : int
        Most points of all branches together, as in :func:`grazing.bifurcation_diagram`.

    Returns
    -------
    xarray.Dataset
        On (name, "run"), where ``run`` is *up*, *down*, *start 1*, *start 2*, ...: ``amplitude`` (half of the
        peak-to-peak value of u), ``mean``, ``peak_velocity``, ``rms_velocity``, ``impact_speed`` (the greatest one),
        ``mean_impact_speed``, ``impulse`` (of the wall in a period of the forcing, per unit of mass, with what it gives
        a ball that lies on it) and ``impacts_per_period`` (of the forcing; of chatter those that a trajectory lists);
        of two walls these four of each, too, as ``A.impulse``, and ``impulse`` is the sum of both, each away from its
        wall. With these come ``period``, ``word``, ``outcome`` and ``trust`` as
        in :func:`grazing.orbit_diagram`. All branches as :attr:`grazing.Branch.dataset` has them, its variables with
        ``branch_`` in front but for those of special points, with the readings of each orbit (``branch_amplitude``,
        ...) and special point (``special_amplitude``, ...). Dimension ``difference``: ``difference_low``,
        ``difference_high`` and ``difference_values``, the least and the greatest of neighbouring values at which the
        sweeps up and down end on different attractors, and how many these are.

    Raises
    ------
    InputError
        For another map, or an input out of range.

    Notes
    -----
    The sweep up starts at the least value from rest, where the constant forces balance or at the wall, and at each
    value where the one before it ended; the sweep down does so from the greatest value. Readings of an attractor are
    taken over one cycle, in closed form from flight to flight: the cycle that Newton's method finds from the last point
    of the run, also where the run has not settled, as near a bifurcation; where it finds none, from that point. Those
    of an attractor without period are taken over ``keep`` periods. Chatter is read impact by impact as
    :func:`grazing.trajectory` lists it. The orbit without impacts is followed wherever it is stable, also where no run
    reached it. Virtual orbits, which the oscillator does not have, and orbits that ended have no readings. A branch is
    begun at each attractor that lies on no branch yet, so an unstable orbit that no branch leads to is missed.

    Examples
    --------
    >>> import grazing as gz, numpy as np
    >>> m, c, k, force, gap = 0.8, 2.4, 3200.0, 2.5, 1.2e-3  # kg, N s/m, N/m, N, m; a stop above: u is -x
    >>> forcing = gz.Forcing(omega=80, cos=(-force / m,))
    >>> rig = gz.Oscillator(alpha=c / m, k=np.sqrt(k / m), forcing=forcing, sigma=-gap, reset=gz.newton(0.7))
    >>> found = gz.response(gz.stroboscopic_map(rig), "omega", 2 * np.pi * np.arange(8.0, 19.0), starts=4)
    >>> (found.amplitude.sel(run=["up", "down"]).values[6] * 1e3).round(4).tolist()  # mm, at 14 Hz
    [1.7759, 0.834]
    >>> real = found.special_admissible.values == 1
    >>> places = zip(found.special_type.values[real], found.special_value.values[real] / 2 / np.pi)
    >>> sorted({(kind, round(float(value), 5)) for kind, value in places})  # Hz
    [('gr', 12.9227), ('lp', 16.58097)]
    """
    from grazing.late import xarray as xr

    P = checked_strobe(P)
    name = checked_name(name, P.origin.rig.params, "the oscillator")
    grid, longest = checked_values(name, values, P), whole(period, "period", 1)
    if len(np.unique(grid)) < 2:
        raise InputError(f"values of {name} are {np.unique(grid).tolist()}; give at least 2 different ones")
    last = {wave: wave.rpartition(".")[2] for wave in P.origin.rig.params}
    waves = [wave for wave, kind in last.items() if kind.startswith(("cos", "sin")) and kind[3:].isdigit()]
    if name not in waves and not any(P.params[wave] for wave in waves):
        warnings.warn("nothing shakes the ball: all amplitudes of the force are 0", UserWarning, stacklevel=2)

    def scanned(number: int, begin: int | ArrayLike, box: Any, sweep: str | None) -> xr.Dataset:
        def told(done: int, total: int) -> None:
            if progress is not None:
                progress(number * total + done, (1 + len(SWEEPS)) * total)

        return orbit_diagram(P, name, grid, begin, transient, keep, seed, threads, "fast", box, told, sweep=sweep)

    drawn = scanned(0, starts, box, None)
    swept = [scanned(n, [at_rest(P, name, grid)], None, sweep) for n, sweep in enumerate(SWEEPS, 1)]
    scans = xr.concat([one.drop_vars(NAME, errors="ignore") for one in (*swept, drawn)], "start")
    bounds = float(grid.min()), float(grid.max())
    search = Search(P, name, bounds, longest, keep // 2, transient + keep, whole(points, "points", 2), progress)
    search.scanned(scans)
    scans = on_their_cycles(P, name, scans)
    result = runs_read(P, name, scans)
    result = result.merge(differences(P, name, scans))
    result = result.merge(branches_read(merged(P, name, search.bounds, search.branches)))
    if NAME in drawn:
        result[NAME] = drawn[NAME]
    result.attrs = documented(P, f"response of the {P.name} in {name}", drawn, "response", search)
    return with_limit(with_note(result), search)


def checked_strobe(P: Any) -> Map:
    """Return the stroboscopic map of an oscillator at phase 0, where its branches are; raise InputError for others."""
    if not isinstance(P, Map) or P.section != "strobe":
        said = "a response is that of an oscillator; give its stroboscopic map, gz.stroboscopic_map(model)"
        raise InputError(f"P is {shown(P)}: {said}")
    refuse_stiffness(P.origin.rig, "a response, which sweeps follow where it attracts,")
    return P.replace(phase=0.0)  # readings do not depend on the section


def between_walls(P: Map, name: str, grid: Floats) -> tuple[float, float]:
    """Return from where to where a ball may start at every value of a parameter, at least inside the map's box."""
    low, high = P.box[0]
    for value in {*grid.tolist()} if name.rpartition(".")[0] or name in ("sigma", "omega", "t0") else (grid[0],):
        model = P.replace(**{name: value}).origin.rig
        for wall, at in zip(model.walls, model.places_at(np.zeros(1))[0][:, 0].tolist(), strict=True):
            low, high = (max(low, at), high) if wall.sign > 0.0 else (low, min(high, at))
    if low > high:
        raise InputError(f"the walls move so far with {name} that no ball may start at all of its values; give fewer")
    return low, high


def at_rest(P: Map, name: str, grid: Floats) -> tuple[float, float]:
    """Return a state that is allowed at every value: at rest where constant forces balance, inside the map's box."""
    model = P.origin.rig
    if model.walled:
        low, high = between_walls(P, name, grid)
        balance = model.forcing.offset / model.k2 if model.k2 > 0.0 else 0.5 * (low + high)
        return min(max(balance, low), high), 0.0
    wall, stiffness = float(grid.max()) if name == "sigma" else model.walls[0].position, model.k**2
    balance = model.forcing.offset / stiffness if stiffness > 0.0 else wall
    return max(wall, min(balance, P.box[0][1])), 0.0


def runs_read(P: Map, name: str, scans: xr.Dataset) -> xr.Dataset:
    """Return the readings of what every run reached at every value; each attractor with a period is read once."""
    from grazing.late import xarray as xr

    points, size = points_of(P, scans)
    periods, words, keep = scans["period"].values, scans["word"].values, scans.sizes["n"]
    readings = readings_of(P.origin.rig)
    found = np.full((*periods.shape, len(readings)), np.nan)
    for i, value in enumerate(scans[name].values.tolist()):
        model, seen = P.replace(**{name: value}).origin.rig, list[int]()
        for j, N in enumerate(periods[i].tolist()):
            if N == ENDED:
                continue
            same = [k for k in seen if same_attractor(periods[i], words[i], points[i], j, k, size)]
            if same:
                found[i, j] = found[i, same[0]]
                continue
            u, v = points[i, j, -1] if N >= 1 else points[i, j, 0]
            found[i, j] = list(gauged(model, flown_cycle(model, (float(u), float(v)), N if N >= 1 else keep)).values())
            seen.append(j)
    names = [*SWEEPS, *(f"start {j + 1}" for j in range(periods.shape[1] - len(SWEEPS)))]
    table = {key: ((name, "run"), found[..., k], about(key, P)) for k, key in enumerate(readings)}
    kept = {key: ((name, "run"), scans[key].values, scans[key].attrs) for key in KEPT}
    run = ("run", np.array(names, dtype=object), {"long_name": "how a value was come to"})
    return xr.Dataset({**table, **kept}, {name: scans[name], "run": run})


def on_their_cycles(P: Map, name: str, scans: xr.Dataset) -> xr.Dataset:
    """Return scans with the latest points of each orbit with a period on its cycle, as far as Newton's method finds it.

    The period may be that of a cycle which the orbit only approaches, see :mod:`grazing.studies.classify`: near a
    period doubling its own points, and what is read along them, are still off after any transient.
    """
    points, _size = points_of(P, scans)
    rows = np.array([list(P.replace(**{name: value}).params.values()) for value in scans[name].values.tolist()])
    periods = scans["period"].values
    for N in np.unique(periods[periods >= 1]).tolist():
        at, run = np.nonzero(periods == N)

        def turn(states: Floats, N: int = N, at: Any = at) -> Columns:
            lanes = states[:, :, None].copy()  # overwritten
            return P.run_columns(rows[at], lanes, 0, N, arithmetic="strict", threads=1)

        seen = turn(points[at, run, -N - 1]).letters[..., 0].astype(np.int64)
        cycle = on_cycles(P, rows[at], points[at, run, -1], seen)
        points[at, run, -N:] = turn(cycle).points[..., 0]
        points[at, run, -1] = cycle
    return scans.assign({c: scans[c].copy(data=points[..., k]) for k, c in enumerate(P.coordinates)})


def points_of(P: Map, scans: xr.Dataset) -> tuple[Floats, Floats]:
    """Return the points of scans, shape (values, starts, n, dim), and the extent of the map's box."""
    points = np.stack([scans[c].values for c in P.coordinates], axis=-1)
    return points, np.array([high - low for low, high in P.box])


def about(reading: str, P: Map) -> labels.Attributes:
    """Return the attributes of a reading."""
    meaning, units = readings_of(P.origin.rig)[reading]
    return {"long_name": meaning, "units": "1" if P.origin.rig.mass is None else units}


def differences(P: Map, name: str, scans: xr.Dataset) -> xr.Dataset:
    """Return the ranges of neighbouring values at which the first two runs ended on different attractors.

    Two without period are not told apart, nor is one whose period is undecided.
    """
    from grazing.late import xarray as xr

    points, size = points_of(P, scans)
    periods, words, grid = scans["period"].values, scans["word"].values, scans[name].values
    found: list[list[float]] = []
    apart = False
    for i in np.argsort(grid, kind="stable").tolist():
        pair = periods[i, :2].tolist()
        told = UNDECIDED not in pair and (max(pair) >= 1 or pair[0] != pair[1])
        before, apart = apart, told and not same_attractor(periods[i], words[i], points[i], 0, 1, size)
        if apart:
            found = [*found, []] if not before else found
            found[-1].append(float(grid[i]))
    ends = {"low": [one[0] for one in found], "high": [one[-1] for one in found]}
    table = {
        f"difference_{side}": ("difference", np.array(at, np.float64), scans[name].attrs) for side, at in ends.items()
    }
    many = np.array([len(one) for one in found], np.int64)
    said = {"long_name": "values at which the sweeps up and down ended on different attractors"}
    return xr.Dataset({**table, "difference_values": ("difference", many, said)})


def branches_read(branch: Branch) -> xr.Dataset:
    """Return the table of branches, their variables with ``branch_`` in front, with readings along them."""
    table = branch_table(branch)
    readable = [kept for piece in branch.pieces for kept in on_or_beside(piece, branch.bounds)]
    along = read_along(branch.map, list(branch), readable)
    special = special_once(branch)
    at = read_along(branch.map, [one.orbit for one in special], [one.admissible for one in special])
    for k, reading in enumerate(readings_of(branch.map.origin.rig)):
        table[reading] = "point", along[:, k], about(reading, branch.map)
        table[f"special_{reading}"] = "special", at[:, k], about(reading, branch.map)
    fronted = [key for key in [*table.variables, *table.dims] if not str(key).startswith("special")]
    return table.rename({key: f"branch_{key}" for key in fronted}).assign_attrs({})


def on_or_beside(piece: Piece, bounds: tuple[float, float]) -> list[bool]:
    """Return which orbits of a piece are those of the flow, or at a special point beside such ones, to rounding."""
    kept = [orbit.admissible for orbit in piece.orbits]
    found, near = list(kept), ROUNDING * (bounds[1] - bounds[0])
    for event in piece.events:
        first, last = event, event
        while first > 0 and abs(piece.values[first - 1] - piece.values[event]) <= near:
            first -= 1
        while last + 1 < len(kept) and abs(piece.values[last + 1] - piece.values[event]) <= near:
            last += 1
        if any(kept[max(first - 1, 0) : last + 2]):
            found[first : last + 1] = [True] * (last + 1 - first)
    return found


def read_along(P: Map, orbits: Sequence[Orbit], readable: Sequence[bool]) -> Floats:
    """Return the readings of periodic orbits, shape (orbits, readings), NaN for those that are none of the flow."""
    found = np.full((len(orbits), len(readings_of(P.origin.rig))), np.nan)
    for i, (orbit, wanted) in enumerate(zip(orbits, readable, strict=True)):
        if not wanted:
            continue
        model, state = orbit.map.origin.rig, (float(orbit.points[0, 0]), float(orbit.points[0, 1]))
        if isinstance(orbit, ImpactOrbit):
            walls = numbered(model, orbit.walls)
            cycle = repeated_cycle(model, state, orbit.times, orbit.incoming, orbit.outgoing, orbit.period, walls)
        else:
            cycle = flown_cycle(model, state, orbit.period)
        found[i] = list(gauged(model, cycle).values())
    return found
