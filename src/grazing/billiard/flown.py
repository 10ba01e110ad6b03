"""Trajectories on a table: every impact located, none sampled; what doubles cannot decide is decided exactly."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import lru_cache
from math import ceil
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from grazing.billiard.contact import SLIDES, flight_to, jammed, next_event, slid_on
from grazing.billiard.elements import element, is_passed, slid
from grazing.billiard.exact import exact_contact
from grazing.billiard.gates import gate_under, opened, passed_at, shut
from grazing.billiard.players import Presses
from grazing.billiard.ride import carried_to
from grazing.billiard.roots import Undecided
from grazing.billiard.rows import FACES
from grazing.billiard.strategy import Strategy
from grazing.billiard.turning import RIDES
from grazing.kernel.compile import call, compiled
from grazing.kernel.primitives import numbers
from grazing.memory import refuse_too_large
from grazing.oscillator.reset import checked_velocity
from grazing.outcome import (
    AMBIGUOUS,
    BAD_LAW,
    DIVERGED,
    ESCAPED,
    FATAL,
    GRAZE,
    INSIDE_WALL,
    NO_IMPACT,
    OK,
    TOO_MANY_IMPACTS,
    TOO_MANY_SWINGS,
    InputError,
    Trust,
    UserCodeError,
    shown,
)
from grazing.parameter import in_order, real

if TYPE_CHECKING:
    import xarray as xr

    from grazing.billiard.table import Table

Floats = NDArray[np.float64]
INFINITY = float("inf")
#: Flights of one call of the recorder, and impacts of a trajectory at most.
CAPACITY, MAX_IMPACTS = 2048, 1_000_000
#: Exact decisions after which a ball is followed no further that takes no time for them: less than a share of its time.
STILL, INSTANT = 200, 2.0**-46
#: Columns of a flight: its length, the surface and object it ends at or -1, velocities along the normal before and
#: after, flags; then the states at its begin, at its end and just after the impact there; the surface on which it is a
#: slide, -1 for a flight; the surface left at its begin, as kernels know it.
TIME, SURFACE, OWNER, BEFORE, AFTER, FLAGS = range(6)
FIRST, LAST, NEXT, PATH, LEFT, COLUMNS = 6, 10, 14, 18, 19, 20
#: What the outcome of a trajectory is called, by the first bit that is set; one that ends at its last impact allowed
#: has too many, others too small ones.
TOO_MANY = "too many impacts"
WORDS = (
    (TOO_MANY_IMPACTS, "bounces too small to tell apart"), (DIVERGED, "diverged"), (ESCAPED, "escaped"),
    (NO_IMPACT, "stays for ever"), (INSIDE_WALL, "inside an object"), (TOO_MANY_SWINGS, "followed for too long"),
    (GRAZE, "grazing"),
)  # fmt: skip


def record(block: Any, now: Any, flights: Any, until: float) -> int:
    """Fill rows with flights and slides, up to a time or a doubt, and return how many.

    The count is negative where none follows, or the last one is in doubt. ``now`` holds the time, the surface just left
    and the state; it is moved along, not beyond a flight in doubt.
    """
    table, t, left = numbers(block), now[0], now[1]
    x, y, vx, vy, count, going = now[2], now[3], now[4], now[5], 0, True
    while going and count < flights.shape[0]:
        (surface, owner, length, flags, on), before, after, speeds = next_event(x, y, vx, vy, left, t, table)
        flags |= jammed(owner, length, flags, on, t + length, after, table)
        row = flights[count]
        row[PATH], row[LEFT] = slid_on(left, t, table), left
        row[TIME], row[SURFACE], row[OWNER], row[FLAGS] = length, surface, owner, flags
        row[BEFORE], row[AFTER] = speeds[0], speeds[1]
        row[FIRST], row[FIRST + 1], row[FIRST + 2], row[FIRST + 3] = x, y, vx, vy
        for i in range(4):
            row[LAST + i], row[NEXT + i] = before[i], after[i]
        count += 1
        doubt = flags & AMBIGUOUS and row[PATH] < 0.0
        going = t + length <= until and not flags & (FATAL | ESCAPED) and not doubt
        if going:
            t, left, (x, y, vx, vy) = t + length, on, after
    now[0], now[1], now[2], now[3], now[4], now[5] = t, left, x, y, vx, vy
    return count if going else -count


@lru_cache(maxsize=1)
def recorder() -> Any:
    """Compile :func:`record`."""
    return compiled(record)


@lru_cache(maxsize=1)
def lander() -> Any:
    """Compile ``land(block, surface, t, state, left, clock, row)``: fill the row of a flight that ends there at t."""

    def land(block: Any, surface: int, t: float, state: Any, left: float, clock: float, row: Any) -> None:
        (_surface, owner, _t, flags, on), before, after, speeds = flight_to(
            surface, t, OK, (state[0], state[1], state[2], state[3]), left, clock, numbers(block)
        )
        row[TIME], row[SURFACE], row[OWNER], row[FLAGS], row[PATH] = t, on, owner, flags, -1.0
        row[BEFORE], row[AFTER] = speeds[0], speeds[1]
        for i in range(4):
            row[FIRST + i], row[LAST + i], row[NEXT + i] = state[i], before[i], after[i]

    return compiled(land)


def decided(block: Floats, state: Floats, left: float, clock: float = 0.0) -> Floats | None:
    """Return the row of a flight that is decided exactly, from a state that has just left a surface; None if not."""
    try:
        surface, t, flags = exact_contact(block, tuple(state.tolist()), left, clock)
    except Undecided:
        return None
    flight: Floats = np.full(COLUMNS, np.nan)
    flight[FIRST:LAST] = flight[LAST:NEXT] = flight[NEXT:PATH] = state
    flight[TIME], flight[SURFACE], flight[OWNER], flight[FLAGS] = INFINITY, -1, -1, ESCAPED
    flight[PATH], flight[LEFT] = -1, left
    if surface >= 0:
        call(lander(), block, surface, t, state, left, clock, flight)
    flight[FLAGS] = int(flight[FLAGS]) | flags
    return flight


def followed(block: Floats, now: Floats, until: float, most: int) -> tuple[Floats, bool]:
    """Return flights and slides from ``now`` on, at least one, and whether another one follows.

    ``now`` holds the time, the surface left as kernels know it, and the state; it is moved along to the next one.
    """
    flights = np.empty((min(CAPACITY, most), COLUMNS))
    count = call(recorder(), block, now, flights, until)
    flights, going = flights[: abs(count)], count > 0
    last = flights[-1]
    if int(last[FLAGS]) & AMBIGUOUS and last[PATH] < 0.0 and not int(last[FLAGS]) & FATAL:
        exact = decided(block, last[FIRST:LAST].copy(), float(now[1]), float(now[0]))
        last[:] = last if exact is None else exact
        going = exact is not None and now[0] + last[TIME] <= until and not int(last[FLAGS]) & (FATAL | ESCAPED)
        if going:
            now[:] = now[0] + last[TIME], last[SURFACE], *last[NEXT:PATH]
    return flights, going


def flights_of(table: Table, state: tuple[float, ...], start: float, until: float, most: int = MAX_IMPACTS) -> Floats:
    """Return all flights and slides of a trajectory of so many impacts at ``most``, columns as named above.

    The last one ends at or after ``until``, or is one after which none follows: its flags say why.
    """
    return played_flights(table, state, start, until, most)[0]


def played_flights(
    table: Table, state: tuple[float, ...], start: float, until: float, most: int = MAX_IMPACTS, left: float = -1.0,
    pressed: dict[str, list[float]] | None = None, once: bool = False,
) -> tuple[Floats, dict[str, list[float]]]:  # fmt: skip
    """Return what :func:`flights_of` does, and when a strategy has pressed and released which buttons.

    What was ``pressed`` before, and the surface just left, if any; ``once``: up to the first impact.
    """
    gates, pressed = len(table.objects), {} if pressed is None else pressed
    block, passed = block_played(table, pressed), list[int]()
    now, found, hits, idle, going = np.array([start, left, *state]), [], 0, 0, True
    still, at = 0, start  # decisions since that time, which is as good as now
    while going:
        flights, going = followed(block, now, until, 1 if passed or once else most - hits)
        found.append(flights)
        last, met = flights[-1], np.flatnonzero(~np.isnan(flights[:, BEFORE]))
        if int(last[FLAGS]) & BAD_LAW:
            law = table.objects[int(last[OWNER])].law
            assert law is not None
            checked_velocity(law, float(last[BEFORE]), law.params)
            raise UserCodeError(f"the reset law {law.name} returned {last[AFTER]:g} for v_minus = {last[BEFORE]:g}")
        if passed:
            x, y = last[LAST : LAST + 2].tolist()
            opened(int(last[OWNER]), int(last[SURFACE]), x, y, block)
            passed = [side for side in passed if is_passed(side, block)]
        t = float(now[0] + last[TIME])
        if last[OWNER] >= gates and t <= until:
            through(last, t, now)
            x, y, vx, vy = last[LAST:NEXT].tolist()
            sides = [passed_at(i, int(last[SURFACE]), x, y, vx, vy, block) for i in range(int(block[FACES]))]
            passed += [side for side in sides if side >= 0]
            for gate in (element(side, t, block)[1] - gates for side in sides if side >= 0):
                said = press_at(table, gate, t, last, pressed)
                if said and now[1] % 1.0 == RIDES and gate == gate_under(int(now[1]), block):
                    now[1] -= RIDES  # the flipper may turn back under it: an impact
                block = block_played(table, pressed) if said else block
            for side in passed:
                shut(side, block)
            going = True
        if once and not np.isnan(last[BEFORE]):
            break
        hits, idle = hits + len(met), len(flights) - 1 - met[-1] if len(met) else idle + len(flights)
        still, at = (still + 1, at) if now[0] - at <= INSTANT * abs(now[0]) else (0, float(now[0]))
        if going and (hits >= most or idle > SLIDES or still > STILL):
            last[FLAGS] = int(last[FLAGS]) | (TOO_MANY_IMPACTS if hits >= most or still > STILL else TOO_MANY_SWINGS)
            break
    return np.concatenate(found), pressed


def block_played(table: Table, pressed: Mapping[str, Sequence[float]]) -> Floats:
    """Return the block of a table whose player has pressed and released buttons at some times."""
    player = Presses({name: tuple(times) for name, times in pressed.items()}) if pressed else None
    block: Floats = table.blocks(table.row(), player=player)[0]
    return block


def press_at(table: Table, gate: int, t: float, flight: Floats, pressed: dict[str, list[float]]) -> bool:
    """Ask a strategy at a gate, unless that button is pressed; note what is pressed, and say whether anything is."""
    player = table.player
    assert isinstance(player, Strategy)
    name = player.gate_of(gate)
    times = pressed.setdefault(name, [])
    if (times and t <= times[-1]) or not player.asked(tuple(flight[LAST:NEXT].tolist()), table.params):
        return False
    times += [t, t + player.hold]
    return True


def through(flight: Floats, t: float, now: Floats) -> None:
    """Let a ball go on through a gate: its flight or slide ends there without an impact."""
    flight[OWNER], flight[BEFORE], flight[AFTER] = -1.0, np.nan, np.nan
    flight[FLAGS], flight[NEXT:PATH] = int(flight[FLAGS]) & ~ESCAPED, flight[LAST:NEXT]
    now[:] = t, (flight[LEFT] if flight[PATH] >= 0.0 else -1.0), *flight[LAST:NEXT]


@lru_cache(maxsize=1)
def slider() -> Any:
    """Compile ``along(block, surface, left, state, clock, times, found)``: where a ball is that slides on a surface."""

    def along(block: Any, surface: int, left: float, state: Any, clock: float, times: Any, found: Any) -> None:
        begin = state[0], state[1], state[2], state[3]
        (x, y, vx, vy), last = begin, 0.0
        for i in range(len(times)):
            if left == surface + RIDES:
                x, y, vx, vy = carried_to(surface, begin, times[i], clock, numbers(block))
            else:
                x, y, vx, vy = slid(surface, x, y, vx, vy, times[i] - last, clock, numbers(block))
            last = times[i]
            found[i, 0], found[i, 1], found[i, 2], found[i, 3] = x, y, vx, vy

    return compiled(along)


def way_along(block: Floats, slide: Floats, clock: float, times: Floats) -> Floats:
    """Return states of a ball at times of a slide, (times, 4)."""
    found = np.empty((len(times), 4))
    if slide[SURFACE] < 0.0:  # it rests
        found[:] = slide[LAST:NEXT]
    else:
        call(slider(), block, int(slide[PATH]), float(slide[LEFT]), slide[FIRST:LAST].copy(), clock, times, found)
    return found


def table_trajectory(table: Table, state: ArrayLike, start: float, until: float, samples: int) -> xr.Dataset:
    """Follow a ball on a table in continuous time; :func:`grazing.trajectory` calls this."""
    from grazing.late import xarray as xr

    names = "x", "y", "vx", "vy"
    begin = checked_start(state)
    table.refuse_inside(begin[0], begin[1], start)
    clock = start if table.autonomous else 0.0  # what its times are measured from: late ones have few digits
    if 0.0 < table.period < INFINITY:
        clock = start - start % table.period
    start, until, end = start - clock, until - clock, until
    flights, pressed = played_flights(table, begin, start, until)
    flags = int(np.bitwise_or.reduce(flights[:, FLAGS].astype(int)))
    begins = start + np.concatenate([[0.0], np.cumsum(flights[:-1, TIME])])
    if int(flights[-1, FLAGS]) & FATAL & ~NO_IMPACT and flights[-1, OWNER] < 0.0 and flights[-1, PATH] < 0.0:
        flights[-1, TIME] = 0.0  # a flight without an end
    ends = np.minimum(begins + flights[:, TIME], until)
    shares = (ends - begins) / (until - start)
    each = [max(2, ceil(samples * share) + 1) for share in shares]
    refuse_too_large(8 * 8 * sum(each), "choose an earlier end or fewer samples", "the trajectory")
    number = np.repeat(np.arange(len(flights)), each)
    t = np.concatenate([np.linspace(*of) for of in zip(begins, ends, each, strict=True)])
    s, (x, y, vx, vy) = t - begins[number], flights[number, FIRST:LAST].T
    a = table.gravity
    with np.errstate(over="ignore", invalid="ignore"):  # of a ball that has diverged
        path = dict(zip(names, (x + vx * s, y + (vy - 0.5 * a * s) * s, vx, vy - a * s), strict=True))
    block = block_played(table, pressed)
    for k in np.flatnonzero(flights[:, PATH] >= 0.0):
        here = number == k
        states = way_along(block, flights[k], float(begins[k]), s[here])
        for name, values in zip(names, states.T, strict=True):
            path[name][here] = values
    hits = ~np.isnan(flights[:, BEFORE]) & (begins + flights[:, TIME] <= until)
    gone = bool(flags & ESCAPED) and (flights[-1, OWNER] < 0.0 or begins[-1] + flights[-1, TIME] <= until)
    flags = flags if gone else flags & ~ESCAPED
    way = "" if not gone else (table.names[int(flights[-1, OWNER])] if flights[-1, OWNER] >= 0.0 else "away")
    word = next((word for bit, word in WORDS if flags & bit), "ok")
    if flags & TOO_MANY_IMPACTS and flights[-1, OWNER] >= 0.0:
        word = TOO_MANY
    time = {"long_name": "time", "units": "1"}
    speed = {"long_name": "velocity along the normal just {} an impact", "units": "1"}
    objects = np.array(table.names)[flights[hits, OWNER].astype(int)]
    return xr.Dataset(
        {
            **{name: ("t", path[name], {"long_name": f"coordinate {name}", "units": "1"}) for name in names},
            "impact_time": (
                "impact",
                clock + (begins + flights[:, TIME])[hits],
                time | {"long_name": "time of impact"},
            ),
            "v_minus": ("impact", flights[hits, BEFORE], {k: v.format("before") for k, v in speed.items()}),
            "v_plus": ("impact", flights[hits, AFTER], {k: v.format("after") for k, v in speed.items()}),
            "impact_wall": ("impact", objects, {"long_name": "object that is hit"}),
            "before": (
                ("impact", "coordinate"),
                flights[hits, LAST:NEXT],
                {"long_name": "state just before an impact"},
            ),
            "after": (
                ("impact", "coordinate"),
                flights[hits, NEXT:PATH],
                {"long_name": "state just after an impact"},
            ),
            "exit": ((), way, {"long_name": "drain through which it left, or away"}),
            "trust": ((), (Trust.ambiguous if flags & AMBIGUOUS else Trust.certified).value),
        },
        coords={"t": ("t", np.where(t < until, clock + t, end), time), "coordinate": ("coordinate", list(names))},
        attrs={
            "title": f"trajectory of {table!r}",
            "grazing_outcome": flags,
            "outcome": word,
            **({"presses": pressed} if table.player.drains else {}),
            **{f"parameter_{name}": value for name, value in table.params.items()},
        },
    )


def checked_start(state: ArrayLike) -> tuple[float, ...]:
    """Return the state of a ball as four floats, or raise InputError."""
    wanted = "give 4 numbers (x, y, vx, vy): place and velocity of the ball's centre"
    try:
        values = np.asarray(in_order(state), dtype=object).ravel().tolist()
    except Exception:  # of whatever object was given
        values = []
    if len(values) != 4:
        raise InputError(f"state is {shown(state)}; {wanted}")
    return tuple(
        real(v, name, "any finite number is allowed") for v, name in zip(values, ("x", "y", "vx", "vy"), strict=True)
    )
