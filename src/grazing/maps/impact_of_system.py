"""The impact map of a system of one's own: from just after one impact to just after the next, with any surface."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from copy import copy
from functools import lru_cache, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grazing.kernel.primitives import replaced
from grazing.maps.derivative import Derived
from grazing.maps.hits import LATER, Names, Struck
from grazing.maps.map import Map
from grazing.maps.of_system import INFINITY, NAN, OfSystem, kind_of, widths_after
from grazing.maps.origin import Origin
from grazing.maps.own_step import ending
from grazing.maps.returning import MAX_PERIODS, within_period
from grazing.maps.settle import said_in_flight
from grazing.outcome import AMBIGUOUS, FATAL, GRAZE, NO_IMPACT, OK, InputError
from grazing.parameter import Parameter, refuse_late
from grazing.systems.contact import Asked, asked_of
from grazing.systems.contract import System
from grazing.systems.march import RISING, WHICHEVER
from grazing.systems.pointed import Place, pointed_of
from grazing.systems.saltation import derivative_of, flow_of, moment_of, product_of, saltation_of
from grazing.systems.trajectory import flights_of

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
HEAD = Place._fields
PHASE = Parameter("tau", r"\tau", "phase of the impact")


@lru_cache(maxsize=256)
def return_of(asked: Asked, n: int, timed: bool, with_tangent: bool, origin: float) -> Callable[..., Any]:
    """Return ``fly(state, widths, p) -> (state, letter, outcome, J)``: to just after the next impact.

    ``origin`` says what flights leave, :data:`grazing.systems.march.WHICHEVER` or :data:`grazing.systems.march.RISING`.

    ``timed`` says that the phase stands in front of the n numbers of a state, else flights begin at t = 0. Starting
    later by dtau is starting at -flow dtau in the flight's own time.
    """
    flight, contact, duration = asked.flight, asked.contact, asked.period
    derivative, saltation, product = derivative_of(flight, n), saltation_of(asked, n), product_of(n)
    flow, moment = flow_of(asked, n), moment_of(asked, n)
    first, m = (1, n + 1) if timed else (0, n)
    zero, nowhere = (0.0,) * n, (NAN,) * m  # an orbit that has ended does not begin anew at 0
    same, lost = tuple(float(i == j) for i in range(n) for j in range(n)), (NAN,) * (m * m)

    def back(A: Any, j: int, t: float, before: Any, after: Any, tau: float, x: Any, widths: Any, p: Any) -> Any:
        """Return the Jacobian of the step, from the derivative A of the flight from x at tau to the impact at t."""
        S, later = saltation(j, t, before, after, widths, p)
        gone = flow(t, after, moment(j, t, after, widths, p), p)
        begun = flow(tau, x, moment(j, tau, x, widths, p), p)
        J = lost
        for k in range(m):
            change = zero
            for i in range(n):
                moved = 0.0
                if k < first:
                    for h in range(n):
                        moved -= A[i * n + h] * begun[h]
                else:
                    moved = A[i * n + k - first]
                change = replaced(change, i, moved)
            delay = 0.0
            for i in range(n):
                delay += later[i] * change[i]
            if timed:
                J = replaced(J, k, delay)
            for i in range(n):
                moved = gone[i] * delay
                for h in range(n):
                    moved += S[i * n + h] * change[h]
                J = replaced(J, (i + first) * m + k, moved)
        return J

    def fly(state: Any, widths: Any, p: Any) -> Any:
        T, tau, x = duration(p), 0.0, zero
        end, most = T * MAX_PERIODS, 0
        if timed:
            tau, end, most = within_period(state[0], T), T, MAX_PERIODS
        for i in range(n):
            x = replaced(x, i, state[first + i])
        start, begin, left, strobes, outcome, A, J = x, tau, origin, 0, OK, same, lost
        j, at, before, after = -1, tau, x, x
        while strobes <= most:
            j, at, flags, _broken, _rate, _away, before, after = contact(begin, x, end, left, p)
            outcome |= flags
            if flags & FATAL:
                return nowhere, 0, outcome, lost
            if with_tangent:
                A = product(derivative(at, begin, x, widths, p), A)
            if j >= 0:
                break
            x, begin, left, strobes = after, 0.0, -1.0, strobes + 1
        if j < 0:
            return nowhere, strobes, outcome | NO_IMPACT, lost
        if with_tangent and not outcome & (GRAZE | AMBIGUOUS):
            J = back(A, j, at, before, after, tau, start, widths, p)
        found, letter = nowhere, j
        if timed:
            if at >= T:
                at, strobes = 0.0, strobes + 1
            found, letter = replaced(found, 0, at), j * LATER + strobes
        for i in range(n):
            found = replaced(found, first + i, after[i])
        return found, letter, outcome, J

    return fly


@lru_cache(maxsize=256)
def return_step_of(n: int, timed: bool, T: Any, *parts: Any) -> Callable[..., Any]:
    """Return the step of the map, as a formula of its own."""
    fly, widths = return_of(asked_of(T, *parts), n, timed, False, WHICHEVER), (0.0,) * n

    def step(state: Any, p: Any) -> Any:
        new, letter, outcome, _J = fly(state, widths, p)
        return new, letter, outcome

    step.made_by = return_step_of, (n, timed, T, *parts)  # type: ignore[attr-defined]
    return step


@lru_cache(maxsize=256)
def return_tangent_of(widths: tuple[float, ...], timed: bool, T: Any, *parts: Any) -> Callable[..., Any]:
    """Return the step of the map with its Jacobian, as a formula of its own."""
    fly = return_of(asked_of(T, *parts), len(widths), timed, True, WHICHEVER)

    def tangent(state: Any, p: Any) -> Any:
        return fly(state, widths, p)

    tangent.made_by = return_tangent_of, (widths, timed, T, *parts)  # type: ignore[attr-defined]
    return tangent


@lru_cache(maxsize=16)
def pointed_return(n: int, timed: bool, origin: float) -> tuple[Callable[..., Any], Callable[..., Any], type]:
    """Return step and derivative of the map of whatever system lies at a place, and the kind of what they need."""
    asked, zero = pointed_of(n // 2), (0.0,) * n
    alone, both = (return_of(asked, n, timed, slopes, origin) for slopes in (False, True))
    widths_of = widths_after(HEAD, n)

    def step(state: Any, c: Any) -> Any:
        new, letter, outcome, _J = alone(state, zero, c)
        return new, letter, outcome

    def derived(state: Any, c: Any) -> Any:
        new, letter, outcome, J = both(state, widths_of(c), c)
        return new, letter, outcome, (*J, -INFINITY)  # all images lie on a surface

    return ending(step, INFINITY), derived, kind_of(HEAD, n)


class Returned(OfSystem):
    """The origin of the impact map of a system of one's own that does not depend on time."""

    timed, leaves = False, WHICHEVER

    def derivative(self, rows: Floats, arithmetic: str = "strict") -> Derived:
        """Return the derivative of the map, compiled once for all systems with as many positions."""
        return self._derived(pointed_return(len(self.system.coordinates), self.timed, self.leaves), rows)

    def start_of(self, state: Sequence[float]) -> tuple[float, tuple[float, ...]]:
        """Return the time at which a state stands, and the coordinates of the system."""
        return 0.0, tuple(map(float, state))

    def check(self, state: Sequence[float], params: Mapping[str, float]) -> None:
        """Raise InputError for a phase that is too late, or a start inside a surface."""
        self.refuse_late(state, params)
        if self.leaves == WHICHEVER:
            self.system.refuse_inside(*self.start_of(state), params)

    def eased(self) -> Origin:
        """Return the origin of the map that goes on smoothly from points on a surface to those just inside it."""
        found = copy(self)
        found.leaves = RISING
        return found

    def explain(self, row: Sequence[float], state: tuple[float, ...]) -> str:
        """Say what a function of the system did wrong in the step from a state."""
        system = self.system.replace(**dict(zip(self.system.params, row, strict=True)))
        start, x = self.start_of(state)
        fly = partial(flights_of, system, x, start, start + MAX_PERIODS * system.span)
        return said_in_flight(fly, f"a function of {system.name}")


class TimedReturned(Returned):
    """The origin of the impact map of a system of one's own that repeats itself after a period."""

    timed = True

    def describe(self, name: str) -> Parameter | None:
        """Return what is known of the phase."""
        return PHASE if name == PHASE.name else None

    def refuse_late(self, state: Sequence[float], params: Mapping[str, float]) -> None:
        """Raise InputError for a phase so late that a double has none."""
        refuse_late(state[0], "tau", self.system.period_at(params))

    def start_of(self, state: Sequence[float]) -> tuple[float, tuple[float, ...]]:
        """Return the time at which a state stands, and the coordinates of the system."""
        tau, *x = map(float, state)
        return tau, tuple(x)

    def periods(self, rows: Floats) -> Floats:
        """Return the period at each row of parameters."""
        names = list(self.system.params)
        return np.array([self.system.period_at(dict(zip(names, row, strict=True))) for row in rows.tolist()])

    def rounds(self, rows: Floats) -> Floats:
        """Return after how much each coordinate comes round: the phase after a period."""
        found = np.full((len(rows), 1 + len(self.system.box)), INFINITY)
        found[:, 0] = self.periods(rows)
        return found

    def clock(self, rows: Floats, first: Floats, last: Floats, letters: Ints, steps: int) -> Floats:
        """Return the time from one impact to a later one: the phases, and a period for every strobe between them."""
        return last[:, 0] - first[:, 0] + (letters % LATER) * self.periods(rows)[:, None]

    def boxes(self, rows: Floats) -> Floats:
        """Return the boxes at parameter values: phases are those of a period."""
        found = np.empty((len(rows), 1 + len(self.system.box), 2))
        found[:, 0, 0], found[:, 0, 1], found[:, 1:] = 0.0, self.periods(rows), self.system.box
        return found


def impact_map_of_system(system: System) -> Map:
    """Return the impact map of a system; :func:`grazing.impact_map` calls this."""
    widths, timed = tuple(high - low for low, high in system.box), system.period is not None
    names = tuple(one.name for one in system.surfaces)
    box, phase = tuple(system.box), ("tau",) * timed
    if timed and "tau" in system.coordinates:
        raise InputError("tau is a coordinate of the system, and the phase in its impact map; give it another name")
    return Map(
        return_step_of(len(widths), timed, system.clock, *system.parts),
        params=system.params,
        coordinates=(*phase, *system.coordinates),
        box=((0.0, system.span), *box) if timed else box,
        letters=Struck("".join(names)) if timed and len(names) > 1 else None if timed else Names(names),
        tangent=return_tangent_of(widths, timed, system.clock, *system.parts),
        name=f"impact map of {system.name}",
        origin=TimedReturned(system) if timed else Returned(system),
    )
