"""Trajectories between walls, or at one that moves or is above: flights and impacts in continuous time."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from math import ceil
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from grazing.kernel.compile import call, compiled
from grazing.kernel.lanes import unpacker
from grazing.oscillator.contact import FLIES, departure_of, placed
from grazing.oscillator.frames import (
    first_contact,
    frame_of,
    frames_kind,
    frames_of,
    frames_rows,
    seen_at_strobe,
    seen_from_strobe,
)  # fmt: skip
from grazing.oscillator.legs import CAPACITY, MAX_IMPACTS, PATIENCE, flown
from grazing.oscillator.model import Oscillator
from grazing.oscillator.pointed import POINTED
from grazing.oscillator.reset import in_python, newton
from grazing.oscillator.spring import spring_of
from grazing.oscillator.walled import Walled
from grazing.outcome import AMBIGUOUS, BAD_LAW, CHATTER, DIVERGED, InputError, Trust, UserCodeError, defined
from grazing.parameter import parameters

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]

# columns of a leg: as in a trajectory over one wall, then which wall sees it, and which it ends at
PERIOD, START, Y, V, END, V_MINUS, V_PLUS, FLAGS, LEG, SEEN, HIT = range(11)


def numbered(b: bool) -> float:
    """Return the number of a wall: 1 for the second."""
    return 1.0 if b else 0.0


@lru_cache(maxsize=64)
def walled_recorder(harmonics: int) -> Callable[..., int]:
    """Compile ``record(row, state, legs, until)``: fill legs until a time or the table's end.

    ``state`` holds (periods, t, u or y, v, window, fastest, in the air, wall): at a strobe the state (u, v), else the
    ball as a wall sees it. It is moved along, so the call can be repeated.
    """
    departure, prepare = departure_of(*POINTED), frames_of(harmonics)
    unpack = unpacker(frames_kind(harmonics))

    def record(row: Any, state: Any, legs: Any, until: float) -> int:
        c = prepare(unpack(row))
        n, fastest, grounded = int(state[0]), state[5], state[6] == 0.0
        if grounded:
            b, ball = seen_from_strobe(state[2], state[3], c)
        else:
            b, ball = state[7] > 0.0, placed(state[1], state[2], state[3], int(state[4]))
        u, v, count = state[2], state[3], 0
        while count + 2 < legs.shape[0] and n * c.a.T + ball.t < until:
            leg = legs[count]
            leg[0], leg[1], leg[2], leg[3] = n, ball.t, ball.y, ball.v
            leg[5], leg[6], leg[7], leg[8] = np.nan, np.nan, 0.0, 0.0
            leg[9], leg[10] = numbered(b), numbered(b)
            count += 1
            hit, flags = grounded and ball.y == 0.0 and ball.v <= 0.0, 0
            if not hit:
                hit, b, ball, flags, _near = first_contact(ball, b, c)
            leg[4], leg[10] = ball.t, numbered(b)
            if hit:
                arrived = ball.v
                how, ball, said = departure(ball, min(c.patience, PATIENCE * fastest), frame_of(b, c))
                flags |= said
                if arrived < 0.0 or ball.v > 0.0:
                    leg[5], leg[6] = arrived, ball.v
                fastest = max(fastest, ball.v) if how == FLIES else 0.0
                if said & (BAD_LAW | DIVERGED):
                    leg[7], leg[8] = flags, (ball.v if said & BAD_LAW else 0.0)
                    break
                if how != FLIES:
                    rest = legs[count]
                    rest[0], rest[1], rest[2], rest[3], rest[4] = n, leg[4], 0.0, 0.0, ball.t
                    rest[5], rest[6], rest[7], rest[8] = np.nan, np.nan, 0.0, 1.0
                    rest[9], rest[10] = numbered(b), numbered(b)
                    count += 1
            leg[7] = flags
            grounded = ball.t >= c.a.T
            if grounded:
                n, fastest = n + 1, 0.0
                u, v = seen_at_strobe(ball, b, c)
                b, ball = seen_from_strobe(u, v, c)
        state[0], state[1], state[4], state[5] = n, ball.t, ball.i, fastest
        state[2], state[3] = (u, v) if grounded else (ball.y, ball.v)
        state[6], state[7] = 0.0 if grounded else 1.0, numbered(b)
        return count

    return compiled(record)


def walled_legs(model: Walled, state: tuple[float, float], start: float, until: float, limit: int) -> Floats:
    """Return all legs of a trajectory, shape (legs, 11), columns as named at the top of this file."""
    row = np.array([[*model.params.values(), start]], np.float64)
    numbers, source = frames_rows(model, row, "strict")
    record, now = walled_recorder(model.harmonics), np.array([0.0, 0.0, *state, 0.0, 0.0, 0.0, 0.0])
    tables, impacts = [], 0
    while now[0] * model.period + now[1] < until - start:
        legs = np.zeros((CAPACITY, 11))
        count = call(record, numbers[0], now, legs, until - start, who="a reset law")
        tables.append(legs[:count])
        bad = legs[:count][legs[:count, FLAGS].astype(int) & BAD_LAW != 0]
        if bad.size:
            law = model.walls[int(bad[0, HIT])].law
            in_python(law.law)(float(bad[0, V_MINUS]), parameters(law.params))  # which says its line, if it raises
            raise UserCodeError(
                f"the reset law {law.name} returned {bad[0, LEG]} for v_minus = {bad[0, V_MINUS]:g} at "
                f"t = {start + bad[0, PERIOD] * model.period + bad[0, END]:g}; allowed is a finite v_plus >= 0, away "
                f"from the wall{defined(law.law)}"
            )
        impacts += int(np.count_nonzero(~np.isnan(legs[:count, V_MINUS])))
        if impacts > limit:
            raise InputError(
                f"more than {limit} impacts up to t = {start + now[0] * model.period + now[1]:g}; choose an earlier "
                "end, r < 1 or a larger V, or declare the contraction of your law"
            )
        if (legs[:count, FLAGS].astype(int) & DIVERGED).any():
            break
    del source  # the laws' numbers lie in it: it had to live so long
    return np.concatenate(tables)


def above_first(model: Oscillator | Walled) -> Oscillator:
    """Return an oscillator that flies as a model does, above the place where its first wall is, or has its middle."""
    if isinstance(model, Oscillator):
        return model
    name, value = spring_of(model)
    spring: dict[str, Any] = {name: value}
    return Oscillator(model.alpha, forcing=model.forcing, reset=newton(1.0), sigma=model.walls[0].position, **spring)


def rests_in(begins: Floats, ends: Floats, lies: NDArray[np.bool_]) -> Floats:
    """Return from when until when the ball lies, shape (rests, 2); legs end at strobes, a rest need not."""
    on = lies & (ends > begins)
    first, last = begins[on], ends[on]
    new = np.append(True, first[1:] != last[:-1])[: len(first)]
    return np.column_stack([first[new], last[np.append(new, True)[1:]]])


def walled_trajectory(
    model: Walled, state: tuple[float, float], start: float, until: float, samples: int
) -> xr.Dataset:
    """Follow the ball in continuous time; :func:`grazing.trajectory` calls this."""
    import xarray as xr

    model.refuse_inside(state[0], start)
    legs = walled_legs(model, state, start, until, MAX_IMPACTS)
    T, names = model.period, list(model.names)
    begins = start + legs[:, PERIOD] * T + legs[:, START]
    ends = np.where(legs[:, END] >= T, start + (legs[:, PERIOD] + 1.0) * T, start + legs[:, PERIOD] * T + legs[:, END])
    times, us, vs = [], [], []
    seen = model.seen
    for leg, begin, end in zip(legs, begins, np.minimum(ends, until), strict=True):
        if begin > end:
            continue
        length = min(end - begin, leg[END] - leg[START])
        s = np.linspace(0.0, length, max(2, ceil(samples * length / T) + 1))
        t, j = np.minimum(begin + s, end), int(leg[SEEN])
        t[-1] = end
        at, speed = model.places_at(t)
        sign, whole = model.walls[j].sign, end >= begin + leg[END] - leg[START]
        if leg[LEG]:
            u, v = at[j], speed[j]
        else:
            first, height, speed_then = np.full((3, len(s)), leg[[START, Y, V]][:, None])
            y, w = flown(seen[j], start, first, height, speed_then, s)
            y -= seen[j].sigma
            y[0], w[0] = leg[Y], leg[V]  # the ends of a flight are known better than by a formula
            u, v = at[j] + sign * y, speed[j] + sign * w
            if not np.isnan(leg[V_MINUS]) and whole:
                i = int(leg[HIT])
                u[-1], v[-1] = at[i, -1], speed[i, -1] + model.walls[i].sign * leg[V_MINUS]
            u = np.clip(u, at[0] if model.walls[0].sign > 0.0 else None, at[-1] if model.walls[-1].sign < 0.0 else None)
        times.append(t)
        us.append(u)
        vs.append(v)
    hits = ~np.isnan(legs[:, V_MINUS]) & (ends <= until)
    at, speed = model.places_at(ends[hits])
    struck = legs[hits, HIT].astype(int)
    sign = np.array([wall.sign for wall in model.walls])[struck]
    carried = speed[struck, np.arange(len(struck))] if struck.size else np.empty(0)
    flags = int(np.bitwise_or.reduce(legs[:, FLAGS].astype(int)))
    trust = Trust.ambiguous if flags & AMBIGUOUS else Trust.certified
    about = {name: model.describe(name).attributes for name in ("t", "u", "v", "v_minus", "v_plus")}
    t = np.concatenate(times)
    before, after = (carried + sign * legs[hits, column] for column in (V_MINUS, V_PLUS))
    at, _speed = model.places_at(t)
    return xr.Dataset(
        {
            "u": ("t", np.concatenate(us), about["u"]),
            "v": ("t", np.concatenate(vs), about["v"]),
            "impact_time": ("impact", ends[hits], about["t"] | {"long_name": "time of impact"}),
            "v_minus": ("impact", before, about["v_minus"]),
            "v_plus": ("impact", after, about["v_plus"]),
            "impact_wall": ("impact", np.array(names)[struck], {"long_name": "wall that is hit"}),
            "impact_speed": (
                "impact",
                -legs[hits, V_MINUS],
                {"long_name": "speed of approach to the wall", "units": model.units_of("v")},
            ),
            "rest_time": (
                ("rest", "end"),
                rests_in(begins, np.minimum(ends, until), legs[:, LEG] != 0.0),
                about["t"] | {"long_name": "when the ball lies on a wall: from, until"},
            ),
            "wall_position": (
                ("wall", "t"),
                model.places_at(t)[0],
                {"long_name": "position of the wall", "units": model.units_of("u")},
            ),
            "side": ("wall", [str(wall.side) for wall in model.walls], {"long_name": "side of the ball"}),
            "trust": ((), trust.value),
        },
        coords={"t": ("t", t, about["t"]), "wall": ("wall", names)},
        attrs={
            "title": f"trajectory of {model!r}",
            "grazing_outcome": flags,
            "chatter": int(bool(flags & CHATTER)),
            **model.attributes,
            **{f"parameter_{name}": value for name, value in model.params.items()},
        },
    )
