"""A flight up to its first contact, and the impact there: what trajectories and maps of a system are made of."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any, NamedTuple

from grazing.kernel.primitives import inlined
from grazing.outcome import BAD_LAW, FATAL
from grazing.systems.contract import constant
from grazing.systems.march import BOUND_BROKEN, LAW_BROKEN, kernels_of, march_of

NAN, INFINITY = float("nan"), float("inf")


class Asked(NamedTuple):
    """The functions of a system that trajectories and maps call: the march is behind ``contact``."""

    flight: Callable[..., Any]
    gap: Callable[..., Any]
    bound: Callable[..., Any]
    law: Callable[..., Any]
    contact: Callable[..., Any]
    period: Callable[..., Any]


@lru_cache(maxsize=256)
def asked_of(period: Any, *parts: Any) -> Asked:
    """Return the functions of a system from its period and :attr:`grazing.systems.contract.System.parts`."""
    flight, gap, bound, law, _rounding = kernels_of(*parts)
    T = period if callable(period) else constant(period)

    def duration(p: Any) -> Any:
        return 1.0 * T(p)

    return Asked(flight, gap, bound, law, contact_of(*parts), duration)


@lru_cache(maxsize=256)
def contact_of(*parts: Any) -> Callable[..., Any]:
    """Return ``contact(t0, state, end, left, p)``: fly to the first contact, up to end, and hit what is there.

    It returns (surface, t, flags, broken) as :func:`grazing.systems.march.march_of` says, the rates of the gap before
    and after the impact, which are NaN for none, and the states before and after.
    """
    march, (flight, gap, _bound, law, rounding) = march_of(*parts), kernels_of(*parts)

    @inlined
    def contact(t0: float, state: Any, end: float, left: float, p: Any) -> Any:
        j, t, flags, broken = march(t0, state, end, left, p)
        before, after, rate, away = state, state, NAN, NAN
        if not flags & FATAL:
            before = flight(t, t0, state, p)
            after = before
            if j >= 0:
                h, rate = gap(j, t, before, p)
                after, wrong = law(j, t, before, p), False
                for x in after:
                    if not abs(x) < INFINITY:
                        wrong = True
                _h, away = gap(j, t, after, p)
                _e, d = rounding(t, t0, state, before, h, rate, p)
                if wrong or not away >= -d:
                    flags, broken = flags | BAD_LAW, BOUND_BROKEN if rate > 0.0 else LAW_BROKEN
        return j, t, flags, broken, rate, away, before, after

    return contact
