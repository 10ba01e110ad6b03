"""Systems by address: a kernel that gets one so is compiled once for all with as many positions."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from grazing.kernel.compile import address
from grazing.kernel.lanes import unpacker
from grazing.kernel.primitives import derived_at, replaced
from grazing.parameter import parameter_tuple
from grazing.systems.contact import Asked, asked_of
from grazing.systems.contract import System

Floats = NDArray[np.float64]
#: What is asked: one of the functions of :class:`grazing.systems.contact.Asked`.
FLIGHT, GAP, BOUND, LAW, CONTACT, PERIOD = (float(i) for i in range(6))
#: Numbers in front of the state in a question, and in front of the states before and after in an answer.
FRONT = 4


class Place(NamedTuple):
    """What a kernel needs of a system: the address of what answers for it, and where its parameters lie."""

    system: float
    row: float


@lru_cache(maxsize=16)
def pointed_of(positions: int) -> Asked:
    """Return the functions of whatever system lies at a place, which stands where they take the parameters."""
    zero = (0.0,) * (2 * positions)
    one, two = (0.0,) * FRONT + zero, (0.0,) * FRONT + zero + zero
    n = FRONT + len(zero)

    def flight(t: float, t0: float, state: Any, p: Any) -> Any:
        found, _said = derived_at(p.system, (FLIGHT, t, t0, 0.0, *state), p.row, one)
        return found[FRONT:]

    def gap(j: int, t: float, state: Any, p: Any) -> Any:
        found, _said = derived_at(p.system, (GAP, t, 1.0 * j, 0.0, *state), p.row, one)
        return found[0], found[1]

    def bound(j: int, t: float, w: float, state: Any, p: Any) -> Any:
        found, _said = derived_at(p.system, (BOUND, t, 1.0 * j, w, *state), p.row, one)
        return found[0]

    def law(j: int, t: float, state: Any, p: Any) -> Any:
        found, _said = derived_at(p.system, (LAW, t, 1.0 * j, 0.0, *state), p.row, one)
        return found[FRONT:]

    def contact(t0: float, state: Any, end: float, left: float, p: Any) -> Any:
        found, (j, flags) = derived_at(p.system, (CONTACT, end, t0, left, *state), p.row, two)
        return j, found[0], flags, int(found[1]), found[2], found[3], found[FRONT:n], found[n:]

    def period(p: Any) -> Any:
        found, _said = derived_at(p.system, (PERIOD, 0.0, 0.0, 0.0, *zero), p.row, one)
        return found[0]

    return Asked(flight, gap, bound, law, contact, period)


def system_address(system: System) -> float:
    """Compile the functions of a system, in strict arithmetic; return where the code lies that answers for them."""
    kind = parameter_tuple(tuple(system.params))
    return _address(kind, f"{system.name}", system.clock, *system.parts)


def place_of(system: System) -> tuple[Floats, Floats]:
    """Return the numbers of a :class:`Place`, and those that it points to: they must live on."""
    source = np.array(list(system.params.values()) or [0.0])
    return np.array([system_address(system), source.ctypes.data], np.float64), source


@lru_cache(maxsize=256)
def _address(kind: type, who: str, *parts: Any) -> float:
    # not once more in fast arithmetic: that takes three seconds, and the march is no faster
    return address(_answer(kind, *parts), "derivative", "strict", who)


@lru_cache(maxsize=256)
def _answer(kind: type, *parts: Any) -> Callable[..., None]:
    """Return ``answer(question, row, found, said)``, which calls one of the functions of a system."""
    flight, gap, bound, law, contact, period = asked_of(*parts)
    unpack, zero = unpacker(kind), (0.0,) * (2 * parts[1])
    n = len(zero)

    def answer(question: Any, row: Any, found: Any, said: Any) -> None:
        what, t, p, state = question[0], question[1], unpack(row), zero
        for i in range(n):
            state = replaced(state, i, question[FRONT + i])
        if what == CONTACT:
            j, at, flags, broken, rate, away, before, state = contact(question[2], state, t, question[3], p)
            said[0], said[1] = j, flags
            found[0], found[1], found[2], found[3] = at, 1.0 * broken, rate, away
            for i in range(n):
                found[FRONT + i], found[FRONT + n + i] = before[i], state[i]
        elif what == GAP:
            found[0], found[1] = gap(int(question[2]), t, state, p)
        elif what == BOUND:
            found[0] = bound(int(question[2]), t, question[3], state, p)
        elif what == PERIOD:
            found[0] = period(p)
        else:
            new = flight(t, question[2], state, p) if what == FLIGHT else law(int(question[2]), t, state, p)
            for i in range(n):
                found[FRONT + i] = new[i]

    return answer
