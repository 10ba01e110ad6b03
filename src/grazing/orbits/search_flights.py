"""A recorder of impacts, as a kernel: each state is flown for some periods, and its impacts are written down."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from grazing.kernel.compile import call, compiled
from grazing.orbits.contacts import framer
from grazing.oscillator.contact import placed
from grazing.oscillator.departure import FLIES, departure_of
from grazing.oscillator.frames import first_contact, frame_of, frames_rows, seen_from_strobe
from grazing.oscillator.pointed import POINTED, pointed_model
from grazing.oscillator.rig import Rig
from grazing.outcome import BAD_LAW, DIVERGED

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

INFINITY = float("inf")


class Flights(NamedTuple):
    """Impacts of many flights: how many, -1 where the ball rests or more impacts than asked for; times and velocities.

    ``times``, ``incoming``, ``outgoing`` and ``walls``, the numbers of the walls, have shape (flights, most); ``times``
    are counted from the start.
    """

    counts: Ints
    times: Floats
    incoming: Floats
    outgoing: Floats
    walls: Floats


@lru_cache(maxsize=64)
def recorder(harmonics: int, walled: bool) -> Callable[..., None]:
    """Compile ``record(row, states, N, counts, times, incoming, outgoing, walls)``, see :class:`Flights`."""
    frames = framer(harmonics, walled)
    departure = departure_of(*POINTED)

    def impacts(
        u: float, v: float, N: int, k: int, times: Any, incoming: Any, outgoing: Any, walls: Any, c: Any
    ) -> int:
        """Write the impacts of flight k in N periods; return how many, -1 where it is no sequence of impacts."""
        b, ball = seen_from_strobe(u, v, c)
        n, T = 0, c.a.T
        contact = ball.y <= 0.0 and ball.v <= 0.0
        for period in range(N):
            while True:
                if contact:
                    arrived = ball.v
                    kind, ball, flags = departure(ball, c.patience, frame_of(b, c))
                    if kind != FLIES or flags & (BAD_LAW | DIVERGED) or n == times.shape[1]:
                        return -1
                    if arrived < 0.0 or ball.v > 0.0:
                        times[k, n], incoming[k, n], outgoing[k, n] = period * T + ball.t, arrived, ball.v
                        walls[k, n] = 1.0 if b else 0.0
                        n += 1
                    if ball.t >= T:
                        contact = False
                        break
                contact, b, ball, _flags, _near = first_contact(ball, b, c)
                if not contact:
                    break
            ball = placed(0.0, max(ball.y, 0.0), ball.v, 0)
        return n

    def record(
        row: Any, states: Any, N: int, counts: Any, times: Any, incoming: Any, outgoing: Any, walls: Any
    ) -> None:
        c = frames(row)
        for k in range(states.shape[0]):
            counts[k] = impacts(states[k, 0], states[k, 1], N, k, times, incoming, outgoing, walls, c)

    return compiled(record)


def recorded(model: Rig, states: Floats, N: int, most: int) -> Flights:
    """Fly each state (u, v) at time 0, rows of (k, 2), for N periods, and return the impacts.

    Parameters
    ----------
    model : Rig
    states : ndarray, shape (k, 2)
        Off the walls, or on them.
    N : int
        Periods.
    most : int
        More impacts than so many are not written down.
    """
    k = len(states)
    if model.walled:
        rows, source = frames_rows(model, np.array([[*model.params.values(), 0.0]]), "strict")
        row = rows[0]
    else:
        row, source = pointed_model(model.seen[0])
    found = Flights(np.zeros(k, np.int64), *(np.full((k, most), np.nan) for _ in range(4)))
    call(recorder(model.harmonics, model.walled), row, np.ascontiguousarray(states), N, *found, who="the flight")
    del source  # the laws' numbers lie in it: it had to live so long
    return found
