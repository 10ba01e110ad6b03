"""The oscillator followed backwards in time: to the contact before, through the impact, to the strobe before.

Backwards the oscillator is an oscillator again: its damping changes sign, its forcing runs the other way, and its
reset law is the inverse. The lemma of :mod:`grazing.oscillator.contact` does not ask for the sign of the damping, so
the same routine finds the contact before, and none is missed. Errors grow on the way back as much as they shrink on
the way forward: whoever uses these points follows them forward again.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from grazing.kernel.compile import call, compiled
from grazing.kernel.lanes import unpacker
from grazing.kernel.primitives import replaced
from grazing.maps.period import period_of
from grazing.oscillator.constants import Constants, constants_of, forcing, section_phase
from grazing.oscillator.contact import next_contact, placed
from grazing.oscillator.departure import FLIES, departure_of
from grazing.oscillator.flight import anchored, flight
from grazing.oscillator.model import Oscillator
from grazing.oscillator.pointed import POINTED, Pointed, flight_kind, pointed_law, pointed_model
from grazing.oscillator.reset import active_law, newton_law, triggered_law
from grazing.parameter import parameters

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
INFINITY = float("inf")

#: Speeds of impact at which a law of one's own is looked at for one given speed of departure: RUNGS per factor of 2,
#: from 2**-LADDER to 2**LADDER times that speed.
LADDER, RUNGS = 40, 4
#: Speeds of impact for one speed of departure beyond which a law of one's own is not followed backwards.
BRANCHES = 8
# columns of a line: a ball on its way back
BACK, HEIGHT, CLIMB, HIT = range(4)


def reversed_constants(c: Constants) -> Constants:
    """Return the constants of the same oscillator in the time T - t; it has no reset law."""
    sin, hs, edges, doubtful = c.sin, c.hs, c.edges, c.doubtful
    for j in range(len(sin)):
        sin = replaced(sin, j, -c.sin[j])
        hs = replaced(hs, j, -c.hs[j])
    zeros = 0
    for i in range(1, len(c.edges)):
        if c.edges[i] < c.T:
            zeros += 1
    for i in range(1, zeros + 1):
        edges = replaced(edges, i, c.T - c.edges[zeros + 1 - i])
    for i in range(zeros + 1):
        doubtful = replaced(doubtful, i, c.doubtful[zeros - i])
    first = -c.first if zeros % 2 == 1 else c.first
    return Constants(
        -c.alpha, c.k2, c.q2, -c.l2, -c.l1, c.spread, c.omega, -c.theta, c.T, c.sigma, c.F0, c.cos, sin, c.Y0, c.hc, hs,
        c.steady, c.rate, c.size, c.force, c.bend, c.piece, edges, first, doubtful, c.blur, 0.0, c.p,
    )  # fmt: skip


@lru_cache(maxsize=64)
def flyer(harmonics: int) -> Callable[..., None]:
    """Compile ``fly(row, lines)``: each ball back to the contact before, or to the beginning of the period.

    A line, see the columns above, is the time T - t, the height y, the velocity -v; then whether there was a contact.
    """
    unpack, prepare = unpacker(flight_kind(harmonics)), constants_of(harmonics, section_phase)

    def fly(row: Any, lines: Any) -> None:
        back = reversed_constants(prepare(unpack(row)))
        for line in lines:
            hit, ball, _flags, _near = next_contact(placed(line[0], line[1], line[2], 0), back)
            line[0], line[1], line[2], line[3] = ball.t, ball.y, ball.v, (1.0 if hit else 0.0)

    return compiled(fly)


@lru_cache(maxsize=64)
def climber(harmonics: int) -> Callable[..., None]:
    """Compile ``climb(row, w, speeds)``: every speed of impact found from which a law makes the departures w."""
    unpack = unpacker(flight_kind(harmonics))

    def climb(row: Any, departures: Any, speeds: Any) -> None:
        p = unpack(row)
        for i in range(len(departures)):
            w, found = departures[i], 0
            slow, fast = 0.0, w * 2.0**-LADDER
            low = pointed_law(-slow, p) - w
            for _rung in range(2 * LADDER * RUNGS + 1):
                high = pointed_law(-fast, p) - w
                if (low < 0.0) != (high < 0.0) and found < speeds.shape[1]:
                    a, b = slow, fast
                    for _ in range(200):
                        middle = 0.5 * (a + b)
                        if not a < middle < b:
                            break
                        if ((pointed_law(-middle, p) - w) < 0.0) == (low < 0.0):
                            a = middle
                        else:
                            b = middle
                    if abs(pointed_law(-b, p) - w) <= 1e-9 * w:  # else the law jumps across w
                        speeds[i, found] = b
                        found += 1
                slow, low, fast = fast, high, fast * 2.0 ** (1.0 / RUNGS)

    return compiled(climb)


class Seen(NamedTuple):
    """An oscillator seen at a phase; its numbers are made once for all its flights back."""

    model: Oscillator
    numbers: Pointed

    @classmethod
    def at(cls, model: Oscillator, phase: float) -> Seen:
        """Return an oscillator seen at a phase."""
        return cls(model, pointed_model(model, phase))


def impacts_before(seen: Seen, w: Floats) -> Floats:
    """Return the speeds of impact, > 0, from which the reset law makes the departures w > 0.

    Parameters
    ----------
    seen : Seen
        An oscillator, at the phase of the section.
    w : ndarray, shape (n,)

    Returns
    -------
    ndarray, shape (n, branches)
        NaN where there is none. A law known to be affine has one branch, or two with a trigger; of a law of one's
        own all changes of sign on a ladder of speeds are found, a quarter of an octave apart.
    """
    law, p = seen.model.reset, parameters(seen.model.reset.params)
    if law.law in (newton_law, active_law, triggered_law):
        if p.r == 0.0:
            return np.full((len(w), 0), np.nan)
        if law.law is not triggered_law:
            speeds = ((w - getattr(p, "V", 0.0)) / p.r)[:, None]
        else:
            speeds = np.column_stack([w / p.r, (w - p.V) / p.r])
            speeds[speeds[:, 0] >= p.trigger, 0] = np.nan
            speeds[speeds[:, 1] < p.trigger, 1] = np.nan
        return np.where(speeds > 0.0, speeds, np.nan)
    speeds = np.full((len(w), BRANCHES), np.nan)
    call(
        climber(seen.model.harmonics),
        seen.numbers.row,
        np.ascontiguousarray(w),
        speeds,
        who=f"the reset law {law.name}",
    )
    return np.where(speeds > 0.0, speeds, np.nan)


def flown_back(seen: Seen, lines: Floats) -> None:
    """Fly every line, shape (n, 4), back to the contact before or to the beginning of the period."""
    call(flyer(seen.model.harmonics), seen.numbers.row, lines, who="the flight backwards")


@lru_cache(maxsize=64)
def toucher(harmonics: int) -> Callable[..., None]:
    """Compile ``touch(row, starts, times, hops, found)``, see :func:`touches`."""
    departure = departure_of(*POINTED)
    unpack, prepare = unpacker(flight_kind(harmonics)), constants_of(harmonics, section_phase)

    def touch(row: Any, starts: Any, times: Any, hops: Any, found: Any) -> None:
        c = prepare(unpack(row))
        for i in range(len(times)):
            end = times[i]
            early = min(0.25 * hops[i], 1e-3 * c.T)  # rounding may make the touch a slow impact, a little before
            start = ball = placed(0.0, starts[i, 0] - c.sigma, starts[i, 1], 0)
            impacts, contact = 0, ball.y == 0.0 and ball.v <= 0.0
            while True:
                if contact:
                    if ball.t >= end - early and abs(ball.v) <= c.force * early:
                        break
                    arrived = ball.v
                    how, ball, _flags = departure(ball, INFINITY, c)
                    if arrived < 0.0 or ball.v > 0.0:
                        impacts += 1
                    start = ball
                    if how != FLIES or not 0.0 <= ball.v < INFINITY or impacts > 10_000:
                        impacts = -1
                        break
                if ball.t >= end:
                    break
                contact, ball, _flags, _near = next_contact(ball, c)
                if ball.t > end + early:
                    break
            y, v = np.nan, np.nan
            if start.t <= end:
                y, v = flight(end - start.t, anchored(start.t, start.y, start.v, c), c)
            F, _dF = forcing(min(end, c.T), c)
            lift = F - c.alpha * v - c.k2 * y
            found[i, 0] = y - 0.5 * v * v / lift if lift > 0.0 else np.nan
            found[i, 1] = impacts if abs(v) <= lift * early else -1

    return compiled(touch)


def touches(model: Oscillator, phase: float, starts: Floats, times: Floats, hops: Floats) -> tuple[Floats, Ints]:
    """Follow states forward by the exact routine, to a time in the next period at which they should touch the wall.

    Parameters
    ----------
    model : Oscillator
    phase : float
        Of the section.
    starts : ndarray, shape (n, 2)
        States (u, v).
    times : ndarray, shape (n,)
        In (0, T].
    hops : ndarray, shape (n,)
        Time since the impact before, or since the strobe.

    Returns
    -------
    height : ndarray, shape (n,)
        u - sigma at the lowest point next to that time: 0 but for rounding. NaN where the force does not lift.
    impacts : ndarray of int, shape (n,)
        Before the touch; -1 where the ball comes to rest before it, or is not near a lowest point then.
    """
    numbers, found = pointed_model(model, phase), np.empty((len(starts), 2))
    states, who = np.ascontiguousarray(starts), f"the reset law {model.reset.name}"
    call(toucher(model.harmonics), numbers.row, states, times, hops, found, who=who)
    return found[:, 0], found[:, 1].astype(np.int64)


@lru_cache(maxsize=64)
def stepper(harmonics: int) -> Callable[..., None]:
    """Compile ``advance(row, states, periods)``: every state some periods on."""
    period = period_of(*POINTED, False)
    unpack, prepare = unpacker(flight_kind(harmonics)), constants_of(harmonics, section_phase)

    def advance(row: Any, states: Any, periods: Any) -> None:
        c = prepare(unpack(row))
        for i in range(len(periods)):
            state = (states[i, 0], states[i, 1])
            for _ in range(periods[i]):
                state, _letter, _outcome, _J, _near, _slow = period(state, c)
            states[i, 0], states[i, 1] = state

    return compiled(advance)


def periods_later(model: Oscillator, phase: float, starts: Floats, periods: Ints) -> Floats:
    """Return states (n, 2) each so many periods later, by the exact routine; NaN after a fatal outcome."""
    numbers, states = pointed_model(model, phase), np.array(starts, np.float64)
    call(stepper(model.harmonics), numbers.row, states, periods, who=f"the reset law {model.reset.name}")
    return states
