"""What instruments read from a periodic motion: amplitude, mean, speeds and impulses, from its flights in closed form.

Each flight is an entire function of time whose fastest rate is known. Cut into pieces that are short in units of that
rate, position and velocity are their Legendre series of degree 19 to rounding: integrals over them are Gauss's
quadrature, and extreme values lie at ends of flights and at roots of a polynomial. Nothing falls between samples.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray

from grazing.memory import refuse_too_large
from grazing.oscillator.constants import constants_of, section_phase
from grazing.oscillator.legs import END, LEG, MAX_IMPACTS, START, V_MINUS, V_PLUS, V, Y, flown, flown_legs
from grazing.oscillator.model import Oscillator
from grazing.oscillator.pointed import flight_kind, pointed_model

Floats = NDArray[np.float64]

#: What is read from a motion, each over a whole cycle, and its units for a model in SI units: of position and velocity,
#: and of impacts, 0 where there is none.
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
        Time at which each begins, from the section at ``start``; height above the wall, velocity; how long it takes.
    rest : float
        How long the ball rests on the wall.
    incoming, outgoing : ndarray, shape (m,)
        Velocities just before and just after each impact.
    periods : int
        Of the forcing.
    start : float
        Time of the section.
    """

    flights: Floats
    rest: float
    incoming: Floats
    outgoing: Floats
    periods: int
    start: float


def flown_cycle(model: Oscillator, state: tuple[float, float], periods: int, start: float = 0.0) -> Cycle:
    """Return the motion that a ball makes from a state at time ``start`` in so many periods.

    Parameters
    ----------
    model : Oscillator
    state : (float, float)
        Position and velocity.
    periods : int
    start : float

    Raises
    ------
    UserCodeError
        For a reset law that returns what it must not.
    """
    legs = flown_legs(model, state, start, start + periods * model.period, MAX_IMPACTS)
    length, rests = legs[:, END] - legs[:, START], legs[:, LEG] != 0.0
    hits = ~np.isnan(legs[:, V_MINUS])
    return Cycle(
        np.column_stack([legs[:, [START, Y, V]], length])[~rests],
        float(length[rests].sum()),
        legs[hits, V_MINUS],
        legs[hits, V_PLUS],
        periods,
        start,
    )


def repeated_cycle(
    model: Oscillator, state: tuple[float, float], times: Floats, incoming: Floats, outgoing: Floats, periods: int
) -> Cycle:
    """Return the motion with impacts at these times and no others, which it repeats after so many periods.

    Parameters
    ----------
    model : Oscillator
    state : (float, float)
        Position and velocity at time 0; of no matter where there are impacts.
    times, incoming, outgoing : ndarray, shape (n,)
        Of an :class:`grazing.ImpactOrbit`.
    periods : int
    """
    if times.size:
        length = np.diff(np.append(times, times[0] + periods * model.period))
        flights = np.column_stack([times, np.zeros_like(times), outgoing, length])
    else:
        flights = np.array([[0.0, state[0] - model.sigma, state[1], periods * model.period]])
    return Cycle(flights, 0.0, np.asarray(incoming), np.asarray(outgoing), periods, 0.0)


def gauged(model: Oscillator, cycle: Cycle) -> dict[str, float]:
    """Return the readings of a motion, by the names of :data:`READINGS`.

    Parameters
    ----------
    model : Oscillator
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
    time = cycle.periods * model.period
    speeds = np.concatenate([-cycle.incoming, cycle.outgoing, [0.0]])
    wall = np.zeros(1 if cycle.rest > 0.0 else 0)
    return {
        "amplitude": 0.5 * (_greatest(u, wall) + _greatest(-u, wall)),
        "mean": float((2.0 * u[:, 0] * half).sum() / time) + model.sigma,
        "peak_velocity": max(_greatest(v, speeds), _greatest(-v, speeds)),
        "rms_velocity": float(np.sqrt((v * v @ (1.0 / _DEGREES) * half).sum() / time)),  # Parseval
        "impact_speed": float(np.abs(cycle.incoming).max(initial=0.0)),
        "mean_impact_speed": float(-cycle.incoming.mean()) if cycle.incoming.size else 0.0,
        "impulse": float((cycle.outgoing - cycle.incoming).sum()) / cycle.periods,
        "impacts_per_period": cycle.incoming.size / cycle.periods,
    }


def _pieces(model: Oscillator, cycle: Cycle) -> tuple[Floats, Floats, Floats]:
    """Return half the length of each piece, and the series of height and velocity on it, shape (pieces, NODES)."""
    numbers = pointed_model(model, cycle.start)
    prepare = constants_of(model.harmonics, section_phase)
    rate = prepare(flight_kind(model.harmonics)(*numbers.row.tolist())).rate
    flights = cycle.flights[cycle.flights[:, 3] > 0.0]
    cuts = np.ceil(flights[:, 3] * rate / LENGTH)
    refuse_too_large(SIZE * float(cuts.sum()), "its flights change too fast to be read", "one motion")
    counts = cuts.astype(np.int64)
    which = np.repeat(np.arange(len(flights)), counts)
    half = 0.5 * (flights[:, 3] / counts)[which]
    number = np.arange(len(which)) - np.repeat(np.cumsum(counts) - counts, counts)
    passed = (half * (2 * number + 1))[:, None] + half[:, None] * _AT
    t, y, v = (np.repeat(flights[which, j], NODES) for j in range(3))
    u, w = flown(model, cycle.start, t, y, v, passed.ravel())
    return half, (u - model.sigma).reshape(passed.shape) @ _SERIES.T, w.reshape(passed.shape) @ _SERIES.T


def _greatest(series: Floats, known: Floats) -> float:
    """Return the greatest value of several Legendre series on [-1, 1], and of numbers that are known."""
    tops = (series @ _GRID).max(axis=1)
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
