"""What instruments read from a periodic motion: amplitude, mean, speeds and impulses, from its flights in closed form.

Each flight is an entire function of time whose fastest rate is known. Cut into pieces that are short in units of that
rate, position and velocity are their Legendre series of degree 19 to rounding: integrals over them are Gauss's
quadrature, and extreme values lie at ends of flights and at roots of a polynomial. Nothing falls between samples.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray

from grazing.memory import refuse_too_large
from grazing.oscillator.constants import constants_of, section_phase
from grazing.oscillator.legs import END, HIT, LEG, MAX_IMPACTS, SEEN, START, V_MINUS, V_PLUS, V, Y, flown_legs, heights
from grazing.oscillator.pointed import flight_kind, pointed_model
from grazing.oscillator.rig import Rig
from grazing.oscillator.walled_trajectory import above_first

Floats = NDArray[np.float64]

#: What is read from a motion, each over a whole cycle, and its units for a model in SI units: of position and velocity,
#: and of impacts, 0 where there is none; the impulse is also that of a wall on which the ball lies.
READINGS = {
    "amplitude": ("amplitude, half of peak to peak", "m"),
    "mean": ("mean position", "m"),
    "peak_velocity": ("greatest speed", "m/s"),
    "rms_velocity": ("root mean square of the velocity", "m/s"),
    "impact_speed": ("greatest speed of an impact", "m/s"),
    "mean_impact_speed": ("mean speed of impacts", "m/s"),
    "impulse": ("impulse of the wall in a period of the forcing, per unit of mass", "N s/kg"),
    "impacts_per_period": ("impacts in a period of the forcing", "1"),
}
#: Those that are said of each of two walls as well, with its name in front: ``A.impulse``.
BY_WALL = ("impact_speed", "mean_impact_speed", "impulse", "impacts_per_period")
#: Nodes of a piece, and its longest length in units of the fastest rate.
NODES, LENGTH = 20, 4.0
#: Bytes of a piece while it is read.
SIZE = 10 * 8 * NODES
_AT, _WEIGHTS = legendre.leggauss(NODES)
#: One over the integral of each polynomial's square; from values at nodes to coefficients, and to values on a grid.
_DEGREES = np.arange(NODES) + 0.5
_SERIES = _DEGREES[:, None] * (legendre.legvander(_AT, NODES - 1) * _WEIGHTS[:, None]).T
STEP = 2.0 / 64
_GRID = legendre.legvander(np.linspace(-1.0, 1.0, 65), NODES - 1).T
#: Coefficients below this part of the greatest one are rounding: without them the others have roots to many digits.
ROUNDING = 1e-14


class Cycle(NamedTuple):
    """A motion over whole periods of the forcing, to be read.

    Parameters
    ----------
    flights : ndarray, shape (n, 4)
        Time at which each begins, from the section at ``start``; height above the first wall, or where that has its
        middle, and its rate; how long it takes.
    rides : ndarray, shape (m, 3)
        When a ball begins to lie on a wall, how long, and on which.
    incoming, outgoing : ndarray, shape (k,)
        Velocities just before and just after each impact, relative to the wall and away from it.
    walls : ndarray of int, shape (k,)
        Which is hit, from below.
    periods : int
        Of the forcing.
    start : float
        Time of the section.
    """

    flights: Floats
    rides: Floats
    incoming: Floats
    outgoing: Floats
    walls: NDArray[np.int64]
    periods: int
    start: float


def readings_of(model: Rig) -> dict[str, tuple[str, str]]:
    """Return the readings of a model with what each means and its units: of two walls some are said of each, too."""
    if len(model.walls) < 2:
        return READINGS
    named = {f"{wall}.{name}": (wall, *READINGS[name]) for wall in model.names for name in BY_WALL}
    words = {name: (_of_wall(meaning, wall), units) for name, (wall, meaning, units) in named.items()}
    total = READINGS["impulse"]
    return {**READINGS, "impulse": (total[0].replace("the wall", "both walls"), total[1]), **words}


def _of_wall(meaning: str, wall: str) -> str:
    if "the wall" in meaning:
        return meaning.replace("the wall", f"wall {wall}")
    return f"{meaning}, wall {wall}".replace("an impact, ", "an impact at ").replace("impacts, ", "impacts at ")


def flown_cycle(model: Rig, state: tuple[float, float], periods: int, start: float = 0.0) -> Cycle:
    """Return the motion that a ball makes from a state at time ``start`` in so many periods.

    Parameters
    ----------
    model : Rig
    state : (float, float)
        Position and velocity.
    periods : int
    start : float

    Raises
    ------
    UserCodeError
        For a reset law that returns what it must not.
    """
    until = start + periods * model.period
    legs = flown_legs(model, state, start, until, MAX_IMPACTS)
    seen, hit = legs[:, SEEN].astype(np.int64), legs[:, HIT].astype(np.int64)
    length, rests = legs[:, END] - legs[:, START], legs[:, LEG] != 0.0
    hits = ~np.isnan(legs[:, V_MINUS])
    begins = legs[:, START]
    return Cycle(
        np.column_stack([begins, *_above_first(model, seen, start + begins, legs[:, Y], legs[:, V]), length])[~rests],
        np.column_stack([begins, length, seen])[rests],
        legs[hits, V_MINUS],
        legs[hits, V_PLUS],
        hit[hits],
        periods,
        start,
    )


def _above_first(model: Rig, seen: NDArray[np.int64], t: Floats, y: Floats, v: Floats) -> tuple[Floats, Floats]:
    """Return heights and velocities, as walls see them at times, above the place of the first wall, at rest."""
    at, speed = model.places_at(t)
    sign, which = np.array([wall.sign for wall in model.walls])[seen], np.arange(len(t))
    return at[seen, which] - model.walls[0].position + sign * y, speed[seen, which] + sign * v


def repeated_cycle(
    model: Rig,
    state: tuple[float, float],
    times: Floats,
    incoming: Floats,
    outgoing: Floats,
    periods: int,
    walls: Sequence[int] = (),
) -> Cycle:
    """Return the motion with impacts at these times and no others, which it repeats after so many periods.

    Parameters
    ----------
    model : Rig
    state : (float, float)
        Position and velocity at time 0; of no matter where there are impacts.
    times, incoming, outgoing : ndarray, shape (n,)
        Of an :class:`grazing.ImpactOrbit`.
    periods : int
    walls : sequence of int, shape (n,)
        Which wall is hit; the first, unless said.
    """
    struck = np.array([*walls] or [0] * len(times), np.int64)
    if times.size:
        length = np.diff(np.append(times, times[0] + periods * model.period))
        y, v = _above_first(model, struck, np.asarray(times), np.zeros_like(times), np.asarray(outgoing))
        flights = np.column_stack([times, y, v, length])
    else:
        flights = np.array([[0.0, state[0] - above_first(model).sigma, state[1], periods * model.period]])
    return Cycle(flights, np.empty((0, 3)), np.asarray(incoming), np.asarray(outgoing), struck, periods, 0.0)


def gauged(model: Rig, cycle: Cycle) -> dict[str, float]:
    """Return the readings of a motion, by the names of :func:`readings_of`.

    Parameters
    ----------
    model : Rig
    cycle : Cycle

    Examples
    --------
    >>> import grazing as gz
    >>> from grazing.oscillator.gauge import flown_cycle, gauged
    >>> model = gz.pinball(alpha=0.0, k=2.0, omega=1.0, d=4.0)  # u = 1 + cos(t)/3 stays off the wall
    >>> found = gauged(model, flown_cycle(model, (4 / 3, 0.0), periods=1))
    >>> {name: round(value, 12) for name, value in found.items() if value}
    {'amplitude': 0.333333333333, 'mean': 1.0, 'peak_velocity': 0.333333333333, 'rms_velocity': 0.235702260396}
    """
    half, u, v = _pieces(model, cycle)
    pressed, lies = _pressed(model, cycle), cycle.rides[:, 2]
    time = cycle.periods * model.period
    # relative to a wall that moves these speeds are not those of the ball, which the pieces have
    speeds = np.concatenate([-cycle.incoming, cycle.outgoing, [0.0]]) if not model.walled else np.zeros(1)
    none = np.empty(0)
    found = {
        "amplitude": 0.5 * (_greatest(u, none) + _greatest(-u, none)),
        "mean": float((2.0 * u[:, 0] * half).sum() / time) + above_first(model).sigma,
        "peak_velocity": max(_greatest(v, speeds), _greatest(-v, speeds)),
        "rms_velocity": float(np.sqrt((v * v @ (1.0 / _DEGREES) * half).sum() / time)),  # Parseval
        **_struck(cycle, np.ones(len(cycle.walls), bool), pressed),
    }
    for j, wall in enumerate(() if len(model.walls) < 2 else model.names):
        struck = _struck(cycle, cycle.walls == j, pressed[lies == j])
        found |= {f"{wall}.{name}": value for name, value in struck.items()}
    return found


def _struck(cycle: Cycle, hits: NDArray[np.bool_], pressed: Floats) -> dict[str, float]:
    """Return what is read from some of the impacts and rides, by the names in :data:`BY_WALL`."""
    incoming, outgoing = cycle.incoming[hits], cycle.outgoing[hits]
    speeds = float(np.abs(incoming).max(initial=0.0)), float(-incoming.mean()) if incoming.size else 0.0
    impulse = float((outgoing - incoming).sum() + pressed.sum())
    return dict(zip(BY_WALL, (*speeds, impulse / cycle.periods, incoming.size / cycle.periods), strict=True))


def _pressed(model: Rig, cycle: Cycle) -> Floats:
    """Return the impulse of the wall in each ride: the integral of -F, the force as the wall sees it."""
    found = np.zeros(len(cycle.rides))
    for j, seen in enumerate(model.seen):
        on, f = cycle.rides[:, 2] == j, seen.forcing
        begins, lasts = cycle.rides[on, :2].T
        order = f.omega * np.arange(1, len(f.cos) + 1)
        first, last = (np.outer(cycle.start + t + f.t0, order) for t in (begins, begins + lasts))
        waves = (np.sin(last) - np.sin(first)) @ (f.cos / order) - (np.cos(last) - np.cos(first)) @ (f.sin / order)
        found[on] = (seen.k2 * seen.sigma - f.offset) * lasts - waves
    return found


def _pieces(model: Rig, cycle: Cycle) -> tuple[Floats, Floats, Floats]:
    """Return half the length of each piece, and the series of height and velocity on it, shape (pieces, NODES).

    Heights are above the place of the first wall, at rest.
    """
    free = above_first(model)
    numbers = pointed_model(free, cycle.start)
    prepare = constants_of(free.harmonics, section_phase)
    rate = prepare(flight_kind(free.harmonics)(*numbers.row.tolist())).rate
    flights = cycle.flights[cycle.flights[:, 3] > 0.0]
    which, half, passed = _cut(flights[:, 3], rate)
    t, y, v = (np.repeat(flights[which, j], NODES) for j in range(3))
    h, w = heights(free, cycle.start, t, y, v, passed.ravel())
    series = half, h.reshape(passed.shape) @ _SERIES.T, w.reshape(passed.shape) @ _SERIES.T
    rides = cycle.rides[cycle.rides[:, 1] > 0.0]
    if not len(rides):
        return series
    fastest = 0.0 if not model.walled else model.harmonics * model.forcing.omega
    which, half, passed = _cut(rides[:, 1], fastest)
    wall, t = np.repeat(rides[which, 2].astype(np.int64), NODES), np.repeat(rides[which, 0], NODES) + passed.ravel()
    at, speed = (one[wall, np.arange(len(t))] for one in model.places_at(cycle.start + t))
    at = at - free.sigma
    ridden = half, at.reshape(passed.shape) @ _SERIES.T, speed.reshape(passed.shape) @ _SERIES.T
    whole = [np.concatenate(both) for both in zip(series, ridden, strict=True)]
    return whole[0], whole[1], whole[2]


def _cut(lengths: Floats, rate: float) -> tuple[NDArray[np.int64], Floats, Floats]:
    """Return pieces of stretches, so short that a rate is followed: of which each is, half its length, its nodes."""
    cuts = np.maximum(np.ceil(lengths * rate / LENGTH), 1.0)
    refuse_too_large(SIZE * float(cuts.sum()), "its flights change too fast to be read", "one motion")
    counts = cuts.astype(np.int64)
    which = np.repeat(np.arange(len(lengths)), counts)
    half = 0.5 * (lengths / counts)[which]
    number = np.arange(len(which)) - np.repeat(np.cumsum(counts) - counts, counts)
    return which, half, (half * (2 * number + 1))[:, None] + half[:, None] * _AT


def _greatest(series: Floats, known: Floats) -> float:
    """Return the greatest value of several Legendre series on [-1, 1], and of numbers that are known."""
    tops = (series @ _GRID).max(axis=1, initial=-np.inf)
    best = float(np.concatenate([tops, known]).max())
    # a maximum is at most half a step from a point of the grid, and flat
    bound = tops + 0.125 * STEP**2 * np.abs(legendre.legder(series, 2, axis=1)).sum(axis=1)
    for i in np.argsort(-bound):
        if not bound[i] > best:
            break
        slope = legendre.legder(series[i])
        slope = slope[: 1 + np.flatnonzero(np.abs(slope) > ROUNDING * np.abs(slope).max(initial=0.0))[-1]]
        at = legendre.legroots(slope).real
        best = max(best, float(legendre.legval(at[np.abs(at) < 1.0], series[i]).max(initial=-np.inf)))
    return best
