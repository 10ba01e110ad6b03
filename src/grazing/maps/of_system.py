"""The stroboscopic map of a system of one's own: its state once per period, in letters the surfaces that are hit."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grazing.kernel.primitives import replaced
from grazing.maps.derivative import Derived
from grazing.maps.hits import MANY, Hits, most_of
from grazing.maps.map import Map
from grazing.maps.origin import Origin
from grazing.maps.own_step import ending
from grazing.maps.settle import said_in_flight
from grazing.outcome import AMBIGUOUS, FATAL, GRAZE, OK, TOO_MANY_IMPACTS
from grazing.parameter import parameter_tuple, real, refuse_late
from grazing.systems.contact import Asked, asked_of
from grazing.systems.contract import System
from grazing.systems.pointed import Place, pointed_of, system_address
from grazing.systems.saltation import derivative_of, product_of, saltation_of
from grazing.systems.trajectory import CHATTER_IMPACTS, CHATTER_SHARE, flights_of

#: Impacts in one period after which the step gives up by name.
MAX_IMPACTS = 10_000
NAN, INFINITY = float("nan"), float("inf")
Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@lru_cache(maxsize=256)
def period_of(asked: Asked, n: int, with_tangent: bool) -> Callable[..., Any]:
    """Return ``period(state, t, walls, most, widths, p) -> (state, letter, outcome, J)``: one period from t on."""
    flight, contact, duration = asked.flight, asked.contact, asked.period
    derivative, saltation, product = derivative_of(flight, n), saltation_of(asked, n), product_of(n)
    same, lost = tuple(float(i == j) for i in range(n) for j in range(n)), (NAN,) * (n * n)

    def period(state: Any, t: float, walls: int, most: int, widths: Any, p: Any) -> Any:
        length = duration(p)
        end, left, impacts, letter, outcome, J, counted = t + length, -1.0, 0, 0, OK, same, t
        while True:
            j, at, flags, _broken, _rate, _away, before, after = contact(t, state, end, left, p)
            outcome |= flags
            if flags & FATAL:
                break
            if with_tangent:
                J = product(derivative(at, t, state, widths, p), J)
                if j >= 0:
                    S, _later = saltation(j, at, before, after, widths, p)
                    J = product(S, J)
            t, left, state = at, 1.0 * j, after
            if j < 0:
                break
            impacts += 1
            letter = (walls + 1) * letter + j + 1 if impacts <= most else letter
            if impacts % CHATTER_IMPACTS == 0:
                if at - counted < CHATTER_SHARE * length or impacts > MAX_IMPACTS:
                    outcome |= TOO_MANY_IMPACTS
                    break
                counted = at
        if outcome & FATAL:
            for i in range(n):
                state = replaced(state, i, NAN)
        if outcome & (FATAL | GRAZE | AMBIGUOUS):
            J = lost
        if walls == 1:
            letter = impacts
        elif impacts > most:
            letter = MANY
        return state, letter, outcome, J

    return period


@lru_cache(maxsize=256)
def step_of(widths: tuple[float, ...], T: Any, *parts: Any) -> Callable[..., Any]:
    """Return the step of the map, as a formula of its own."""
    period, walls = period_of(asked_of(T, *parts), len(widths), False), (len(parts) - 3) // 4
    most = most_of(walls)

    def step(state: Any, p: Any) -> Any:
        new, letter, outcome, _J = period(state, p.phase, walls, most, widths, p)
        return new, letter, outcome

    step.made_by = step_of, (widths, T, *parts)  # type: ignore[attr-defined]
    return step


@lru_cache(maxsize=256)
def tangent_of(widths: tuple[float, ...], T: Any, *parts: Any) -> Callable[..., Any]:
    """Return the step of the map with its Jacobian, as a formula of its own."""
    period, walls = period_of(asked_of(T, *parts), len(widths), True), (len(parts) - 3) // 4
    most = most_of(walls)

    def tangent(state: Any, p: Any) -> Any:
        return period(state, p.phase, walls, most, widths, p)

    tangent.made_by = tangent_of, (widths, T, *parts)  # type: ignore[attr-defined]
    return tangent


#: What the map needs of any system, in front of the widths of its box.
HEAD = (*Place._fields, "phase", "walls", "most")


@lru_cache(maxsize=16)
def pointed_map(n: int) -> tuple[Callable[..., Any], Callable[..., Any], type]:
    """Return step and derivative of the map of whatever system lies at a place, and the kind of what they need."""
    asked, zero = pointed_of(n // 2), (0.0,) * n
    alone, both = period_of(asked, n, False), period_of(asked, n, True)
    widths_of = widths_after(HEAD, n)

    def step(state: Any, c: Any) -> Any:
        new, letter, outcome, _J = alone(state, c.phase, int(c.walls), int(c.most), zero, c)
        return new, letter, outcome

    def derived(state: Any, c: Any) -> Any:
        new, letter, outcome, J = both(state, c.phase, int(c.walls), int(c.most), widths_of(c), c)
        return new, letter, outcome, (*J, NAN)

    return ending(step, INFINITY), derived, kind_of(HEAD, n)


def widths_after(head: tuple[str, ...], n: int) -> Callable[..., Any]:
    """Return ``widths_of(c)``, the n numbers behind those of the head."""
    zero, first = (0.0,) * n, len(head)

    def widths_of(c: Any) -> Any:
        found = zero
        for i in range(n):
            found = replaced(found, i, c[first + i])
        return found

    return widths_of


def kind_of(head: tuple[str, ...], n: int) -> type:
    """Return the named tuple of a head and n widths behind it."""
    return parameter_tuple((*head, *(f"width{i}" for i in range(n))))


class OfSystem(Origin):
    """The origin of a map of a system of one's own, which is told what stands in front of the widths of its box."""

    exact = False

    def __init__(self, system: System) -> None:
        self.system = system

    def _derived(
        self, pointed: tuple[Callable[..., Any], Callable[..., Any], type], rows: Floats, *said: Any
    ) -> Derived:
        """Return the derivative of a map at rows of its parameters, which stand in its table behind what is read."""
        step, derived, kind = pointed
        widths = [high - low for low, high in self.system.box]
        front = len(Place._fields) + len(said)
        first = front + len(widths)
        table = np.empty((len(rows), first + rows.shape[1]))
        table[:, 0] = system_address(self.system)
        table[:, 1] = table.ctypes.data + table.strides[0] * np.arange(len(rows)) + table.itemsize * first
        for i, values in enumerate(said):
            table[:, len(Place._fields) + i] = values
        table[:, front:first], table[:, first:] = widths, rows
        return Derived(derived, None, kind, table, table, step)


class Strobed(OfSystem):
    """The origin of the stroboscopic map of a system of one's own."""

    def derivative(self, rows: Floats, arithmetic: str = "strict") -> Derived:
        """Return the derivative of the map, compiled once for all systems with as many positions."""
        walls = len(self.system.surfaces)
        pointed = pointed_map(len(self.system.coordinates))
        return self._derived(pointed, rows, rows[:, -1], walls, most_of(walls))

    def check(self, state: Sequence[float], params: Mapping[str, float]) -> None:
        """Raise InputError for a start inside a surface."""
        self.system.refuse_inside(params["phase"], tuple(float(x) for x in state), params)

    def explain(self, row: Sequence[float], state: tuple[float, ...]) -> str:
        """Say what a function of the system did wrong in the step from a state."""
        names = [*self.system.params, "phase"]
        params = dict(zip(names, row, strict=True))
        phase = params.pop("phase")
        system = self.system.replace(**params)
        fly = partial(flights_of, system, state, phase, phase + system.period_at(params))
        return said_in_flight(fly, f"a function of {system.name}")

    def clock(self, rows: Floats, first: Floats, last: Floats, letters: Ints, steps: int) -> Floats:
        """Return the time that orbits took for so many steps, each of a period."""
        names = [*self.system.params, "phase"]
        each = [self.system.period_at(dict(zip(names, row, strict=True))) for row in rows.tolist()]
        return np.broadcast_to(steps * np.array(each)[:, None], letters.shape)


def map_of_system(system: System, phase: float) -> Map:
    """Return the stroboscopic map of a system; :func:`grazing.stroboscopic_map` calls this."""
    phase = real(phase, "phase", "allowed is any finite number")
    T = system.period_at(system.params)
    refuse_late(phase, "phase", T)
    widths = tuple(high - low for low, high in system.box)
    surfaces = "".join(one.name for one in system.surfaces)
    return Map(
        step_of(widths, system.period, *system.parts),
        params={**system.params, "phase": phase % T},
        coordinates=system.coordinates,
        box=system.box,
        letters=Hits(surfaces) if len(surfaces) > 1 else None,
        tangent=tangent_of(widths, system.period, *system.parts),
        name=f"stroboscopic map of {system.name}",
        origin=Strobed(system),
    )
