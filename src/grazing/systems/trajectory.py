"""Trajectories of systems of one's own: every impact located, none sampled."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from math import ceil
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from grazing.kernel.compile import call, compiled
from grazing.kernel.lanes import unpacker
from grazing.kernel.primitives import replaced
from grazing.memory import refuse_too_large
from grazing.outcome import (
    AMBIGUOUS,
    BAD_LAW,
    DIVERGED,
    FATAL,
    GRAZE,
    TOO_MANY_IMPACTS,
    TOO_MANY_SWINGS,
    InputError,
    Trust,
    UserCodeError,
    defined,
    shown,
)
from grazing.parameter import in_order, parameters, real
from grazing.systems.contract import System, tried
from grazing.systems.march import LAW_BROKEN
from grazing.systems.pointed import Place, place_of, pointed_of

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]
INFINITY = float("inf")
#: Chatter: so many impacts in a row within such a share of the period (without one, of the whole time).
CHATTER_IMPACTS, CHATTER_SHARE = 1000, 1e-3
#: Flights of one call of the recorder, and impacts of a trajectory at most.
CAPACITY, MAX_IMPACTS = 2048, 1_000_000
#: Columns of a flight in front of its states: begins, ends, the surface it ends at or -1, rates before and after,
#: flags, what is broken; then the states at its begin, at its end and just after the impact there.
BEGIN, END, HIT, BEFORE, AFTER, FLAGS, BROKEN, HEAD = range(8)
NOT_RESOLVED = "chatter not resolved"
#: What the outcome of a trajectory is called, by the first bit that is set.
WORDS = (
    (TOO_MANY_IMPACTS, NOT_RESOLVED), (TOO_MANY_SWINGS, "too many looks"), (DIVERGED, "diverged"), (GRAZE, "grazing"),
)  # fmt: skip


@lru_cache(maxsize=16)
def recorder(positions: int) -> Callable[..., int]:
    """Compile ``record(place, now, table, until, short)``: fill a table with flights up to a time, or until it is full.

    ``now`` holds time, surface just left, impacts, time of the last count of chatter, and the state; it is moved along.
    """
    contact, unpack, n = pointed_of(positions).contact, unpacker(Place), 2 * positions
    zero = (0.0,) * n

    def record(place: Any, now: Any, table: Any, until: float, short: float) -> int:
        p, t, left, state, count = unpack(place), now[0], now[1], zero, 0
        for i in range(n):
            state = replaced(state, i, now[4 + i])
        going = True
        while going and count < table.shape[0]:
            j, end, flags, broken, rate, away, before, after = contact(t, state, until, left, p)
            going = j >= 0 and not flags & FATAL
            if rate < INFINITY:
                now[2] += 1.0
                if going and int(now[2]) % CHATTER_IMPACTS == 0:
                    if end - now[3] < short:
                        flags, going = flags | TOO_MANY_IMPACTS, False
                    now[3] = end
            one = table[count]
            one[0], one[1], one[2], one[3], one[4], one[5], one[6] = t, end, j, rate, away, flags, broken
            for i in range(n):
                one[HEAD + i], one[HEAD + n + i], one[HEAD + 2 * n + i] = state[i], before[i], after[i]
            t, left, state = end, 1.0 * j, after
            count += 1
        now[0], now[1] = t, left
        for i in range(n):
            now[4 + i] = state[i]
        return count

    return compiled(record)


@lru_cache(maxsize=16)
def sampler(positions: int) -> Callable[..., None]:
    """Compile ``sample(place, table, which, times, points)``: states at times, each on a flight of a table."""
    flight, unpack, n = pointed_of(positions).flight, unpacker(Place), 2 * positions
    zero = (0.0,) * n

    def sample(place: Any, table: Any, which: Any, times: Any, points: Any) -> None:
        p = unpack(place)
        for k in range(len(times)):
            one, state = table[which[k]], zero
            for i in range(n):
                state = replaced(state, i, one[HEAD + i])
            new = flight(times[k], one[0], state, p)
            for i in range(n):
                points[i, k] = new[i]

    return compiled(sample)


def flights_of(system: System, state: tuple[float, ...], start: float, until: float) -> Floats:
    """Return all flights of a trajectory, columns as named at the top of this file; raise for what is broken."""
    n, T = len(state), until - start if system.period is None else system.period_at(system.params)
    place, _source = place_of(system)
    record, now = recorder(n // 2), np.array([start, -1.0, 0.0, start, *state])
    tables: list[Floats] = []
    while True:
        table = np.zeros((CAPACITY, HEAD + 3 * n))
        count = call(record, place, now, table, until, CHATTER_SHARE * T, who=f"{system.name}")
        tables.append(table[:count])
        last = table[count - 1]
        flags = int(last[FLAGS])
        if flags & BAD_LAW:
            raise UserCodeError(_broken(system, last))
        if flags & FATAL or last[HIT] < 0.0:
            return np.concatenate(tables)
        if now[2] > MAX_IMPACTS:
            raise InputError(
                f"more than {MAX_IMPACTS} impacts up to t = {now[0]:g}; choose an earlier end, or a smaller restitution"
            )


def _broken(system: System, flight: Floats) -> str:
    n, surface = len(system.coordinates), system.surfaces[max(int(flight[HIT]), 0)]
    if flight[HIT] < 0.0:
        now = system.flight(float(flight[END]), float(flight[BEGIN]), tuple(flight[HEAD : HEAD + n].tolist()),
                            parameters(system.params))  # fmt: skip
        gaps = system.gaps(float(flight[END]), now, system.params)
        surface = min(system.surfaces, key=lambda one: gaps[one.name][0])
    if flight[BROKEN] == LAW_BROKEN:
        before, after = (tuple(flight[HEAD + k * n : HEAD + (k + 1) * n].tolist()) for k in (1, 2))
        if surface.law is not None:  # which says its line, if it raises
            args = float(flight[END]), before, parameters(system.params)
            tried(surface.law, args, f"the law of surface {surface.name}")
        return (
            f"the law of surface {surface.name} made {after} of {before} at t = {flight[END]:g}, whose rate of the gap "
            f"is {flight[AFTER]:g}; allowed are finite numbers and a rate >= 0, away from the surface"
            f"{defined(surface.law)}"
        )
    return (
        f"the bound of surface {surface.name} is too small or negative, or its gap, the rounding or the flight are "
        f"wrong: in the flight from {tuple(flight[HEAD : HEAD + n].tolist())} at t = {flight[BEGIN]:g} the gap at t = "
        f"{flight[END]:g} cannot be what it is; gz.testing.check_system looks for the reason"
    )


def system_trajectory(system: System, state: ArrayLike, start: float, until: float, samples: int) -> xr.Dataset:
    """Follow a system in continuous time; :func:`grazing.trajectory` calls this."""
    from grazing.late import xarray as xr

    names = system.coordinates
    begin = checked_start(system, state)
    system.refuse_inside(start, begin, system.params)
    span = until - start if system.period is None else min(system.period_at(system.params), until - start)
    points = (until - start) / span * samples
    refuse_too_large(8 * (2 * len(names) + 4) * points, "choose an earlier end or fewer samples", "the trajectory")
    flights = flights_of(system, begin, start, until)
    times, which = [], []
    for k, one in enumerate(flights):
        length = one[END] - one[BEGIN]
        times.append(np.linspace(one[BEGIN], one[END], max(2, ceil(samples * length / span) + 1)))
        which.append(np.full(len(times[-1]), k))
    t, number = np.concatenate(times), np.concatenate(which)
    path = np.empty((len(names), len(t)))
    place, _source = place_of(system)
    call(sampler(len(names) // 2), place, flights, number, t, path, who=f"{system.name}")
    hits = ~np.isnan(flights[:, BEFORE])
    flags = int(np.bitwise_or.reduce(flights[:, FLAGS].astype(int)))
    sure = Trust.certified if system.rounding is not None else Trust.numerical
    n, surfaces = len(names), np.array([one.name for one in system.surfaces])
    states = flights[hits, HEAD:].reshape(-1, 3, n)
    time = {"long_name": "time", "units": "1"}
    speed = {"long_name": "rate of the gap just {} an impact", "units": "1"}
    return xr.Dataset(
        {
            **{name: ("t", path[i], {"long_name": f"coordinate {name}", "units": "1"}) for i, name in enumerate(names)},
            "impact_time": ("impact", flights[hits, END], time | {"long_name": "time of impact"}),
            "v_minus": ("impact", flights[hits, BEFORE], {k: x.format("before") for k, x in speed.items()}),
            "v_plus": ("impact", flights[hits, AFTER], {k: x.format("after") for k, x in speed.items()}),
            "impact_wall": ("impact", surfaces[flights[hits, HIT].astype(int)], {"long_name": "surface that is hit"}),
            "before": (("impact", "coordinate"), states[:, 1], {"long_name": "state just before an impact"}),
            "after": (("impact", "coordinate"), states[:, 2], {"long_name": "state just after an impact"}),
            "trust": ((), (Trust.ambiguous if flags & AMBIGUOUS else sure).value),
        },
        coords={"t": ("t", t, time), "coordinate": ("coordinate", list(names))},
        attrs={
            "title": f"trajectory of {system!r}",
            "grazing_outcome": flags,
            "outcome": next((word for bit, word in WORDS if flags & bit), "ok"),
            **{f"parameter_{name}": value for name, value in system.params.items()},
        },
    )


def checked_start(system: System, state: ArrayLike) -> tuple[float, ...]:
    """Return a state as floats, or raise InputError."""
    names = system.coordinates
    wanted = f"give {len(names)} numbers ({', '.join(names)})"
    try:
        values = np.asarray(in_order(state), dtype=object).ravel().tolist() if len(state) == len(names) else []  # type: ignore[arg-type]
    except Exception:  # of whatever object was given
        values = []
    if len(values) != len(names):
        raise InputError(f"state is {shown(state)}; {wanted}")
    return tuple(real(x, name, "any finite number is allowed") for x, name in zip(values, names, strict=True))
