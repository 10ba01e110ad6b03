"""A recorder of impacts, as a kernel: each state is flown for some periods, and its impacts are written down."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from grazing.kernel.compile import call, compiled
from grazing.kernel.lanes import unpacker
from grazing.oscillator.constants import constants_of
from grazing.oscillator.contact import FLIES, departure_of, next_contact, placed
from grazing.oscillator.model import Oscillator
from grazing.oscillator.pointed import POINTED, flight_kind, pointed_model
from grazing.outcome import BAD_LAW, DIVERGED

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

INFINITY = float("inf")


class Flights(NamedTuple):
    """Impacts of many flights: how many, -1 where the ball rests or more impacts than asked for; times and velocities.

    ``times``, ``incoming`` and ``outgoing`` have shape (flights, most); ``times`` are counted from the start.
    """

    counts: Ints
    times: Floats
    incoming: Floats
    outgoing: Floats


@lru_cache(maxsize=64)
def recorder(harmonics: int) -> Callable[..., None]:
    """Compile ``record(row, states, N, counts, times, incoming, outgoing)`` for models with so many harmonics."""
    unpack, constants = unpacker(flight_kind(harmonics)), constants_of(harmonics)
    departure = departure_of(*POINTED)

    def impacts(u: float, v: float, N: int, k: int, times: Any, incoming: Any, outgoing: Any, c: Any) -> int:
        """Write the impacts of flight k in N periods; return how many, -1 where it is no sequence of impacts."""
        n, y = 0, u - c.sigma
        contact = y <= 0.0 and v <= 0.0
        for period in range(N):
            ball = placed(0.0, max(y, 0.0), v, 0)
            while True:
                if contact:
                    arrived = ball.v
                    kind, ball, flags = departure(ball, INFINITY, c)
                    if kind != FLIES or flags & (BAD_LAW | DIVERGED) or n == times.shape[1]:
                        return -1
                    if arrived < 0.0 or ball.v > 0.0:
                        times[k, n], incoming[k, n], outgoing[k, n] = period * c.T + ball.t, arrived, ball.v
                        n += 1
                    if ball.t >= c.T:
                        contact = False
                        break
                contact, ball, _flags, _near = next_contact(ball, c)
                if not contact:
                    break
            y, v = ball.y, ball.v
        return n

    def record(row: Any, states: Any, N: int, counts: Any, times: Any, incoming: Any, outgoing: Any) -> None:
        c = constants(unpack(row))
        for k in range(states.shape[0]):
            counts[k] = impacts(states[k, 0], states[k, 1], N, k, times, incoming, outgoing, c)

    return compiled(record)


def recorded(model: Oscillator, states: Floats, N: int, most: int) -> Flights:
    """Fly each state (u, v) at time 0, rows of (k, 2), for N periods, and return the impacts.

    Parameters
    ----------
    model : Oscillator
    states : ndarray, shape (k, 2)
        With u >= sigma.
    N : int
        Periods.
    most : int
        More impacts than so many are not written down.
    """
    k, numbers = len(states), pointed_model(model)
    found = Flights(
        np.zeros(k, np.int64), np.full((k, most), np.nan), np.full((k, most), np.nan), np.full((k, most), np.nan)
    )
    call(recorder(model.harmonics), numbers.row, np.ascontiguousarray(states), N, *found, who="the flight")
    return found
