"""The legs of a trajectory, flights and rests, one after the other; every impact located, none sampled."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grazing.kernel.compile import call, compiled
from grazing.kernel.lanes import unpacker
from grazing.oscillator.constants import constants_of, section_phase
from grazing.oscillator.contact import placed
from grazing.oscillator.departure import FLIES, departure_of
from grazing.oscillator.flight import anchored, flight
from grazing.oscillator.frames import (
    alone,
    first_contact,
    frame_of,
    frames_kind,
    frames_of,
    frames_rows,
    rest_in_doubt,
    seen_at_strobe,
    seen_from_strobe,
)  # fmt: skip
from grazing.oscillator.model import Oscillator
from grazing.oscillator.pointed import POINTED, flight_kind, pointed_model
from grazing.oscillator.reset import in_python
from grazing.oscillator.rig import Rig
from grazing.outcome import AMBIGUOUS, BAD_LAW, DIVERGED, OK, InputError, UserCodeError, defined
from grazing.parameter import parameters

Floats = NDArray[np.float64]

#: Chatter is followed impact by impact down to this fraction of its first speed, then completed in closed form.
PATIENCE = 1e-6
CAPACITY = 4096
#: A trajectory lists every impact; beyond so many it is refused by name.
MAX_IMPACTS = 200_000
# columns of a leg; the last two say which wall sees it, and which it ends at
PERIOD, START, Y, V, END, V_MINUS, V_PLUS, FLAGS, LEG, SEEN, HIT = range(11)


def numbered(b: bool) -> float:
    """Return the number of a wall: 1 for the second."""
    return 1.0 if b else 0.0


@lru_cache(maxsize=64)
def recorder_of(
    law: Callable[..., float],
    slope: Callable[..., float],
    contraction: Callable[..., Any],
    prepare: Callable[..., Any],
    kind: type,
) -> Callable[..., int]:
    """Return ``record(row, state, legs, until, patience)``: fill legs until a time or the table's end.

    ``state`` holds (periods, t, y, v, window, fastest, in the air) and is moved along, so the call can be repeated.
    A leg is a flight or a rest from (period, t, y, v) to t_end; v_minus and v_plus are NaN where it ends without an
    impact. As in the stroboscopic map, the state at each strobe is the one that the next decisions are right for.
    """
    return _recorder_of(departure_of(law, slope, contraction), prepare, kind, True)


def walled_recorder(harmonics: int) -> Callable[..., int]:
    """Compile :func:`walled_recorder_of` for laws by address."""
    return compiled(walled_recorder_of(*POINTED, frames_of(harmonics), frames_kind(harmonics)))


@lru_cache(maxsize=64)
def walled_recorder_of(
    law: Callable[..., float],
    slope: Callable[..., float],
    contraction: Callable[..., Any],
    prepare: Callable[..., Any],
    kind: type,
) -> Callable[..., int]:
    """Return ``record(row, state, legs, until)``: fill legs until a time or the table's end.

    ``state`` holds (periods, t, u or y, v, window, fastest, in the air, wall): at a strobe the state (u, v), else the
    ball as a wall sees it. It is moved along, so the call can be repeated.
    """
    between = _recorder_of(departure_of(law, slope, contraction), prepare, kind, False)

    def record(row: Any, state: Any, legs: Any, until: float) -> int:
        return between(row, state, legs, until, PATIENCE)

    return record


def _recorder_of(
    departure: Callable[..., Any], prepare: Callable[..., Any], kind: type, still: bool
) -> Callable[..., int]:
    """Return the recorder; ``still`` is for one wall at rest below the ball, whose frames are ``alone``."""
    unpack = unpacker(kind)

    def record(row: Any, state: Any, legs: Any, until: float, patience: float) -> int:
        c = alone(prepare(unpack(row))) if still else prepare(unpack(row))
        n, fastest, grounded = int(state[0]), state[5], state[6] == 0.0
        if grounded and not still:
            b, ball = seen_from_strobe(state[2], state[3], c)
        else:
            b, ball = not still and state[7] > 0.0, placed(state[1], state[2], state[3], int(state[4]))
        u, v, count = state[2], state[3], 0
        while count + 2 < legs.shape[0] and n * c.a.T + ball.t < until:
            leg = legs[count]
            leg[0], leg[1], leg[2], leg[3] = n, ball.t, ball.y, ball.v
            leg[5], leg[6], leg[7], leg[8] = np.nan, np.nan, 0.0, 0.0
            count += 1
            left, flags = b, AMBIGUOUS if not still and grounded and rest_in_doubt(u, v, c) else OK
            hit = grounded and ball.y == 0.0 and ball.v <= 0.0
            if not hit:
                hit, b, ball, said, _near = first_contact(ball, b, c)
                flags |= said
            leg[4] = ball.t
            if not still:
                leg[9], leg[10] = numbered(left), numbered(b)
            if hit:
                arrived = ball.v
                how, ball, said = departure(ball, min(c.patience, patience * fastest), frame_of(b, c))
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
                    if not still:
                        rest[9], rest[10] = numbered(b), numbered(b)
                    count += 1
            leg[7] = flags
            grounded = ball.t >= c.a.T  # only at a strobe can the ball be on the wall with its contact still to come
            if grounded:
                n, fastest = n + 1, 0.0
                if still:
                    ball = placed(0.0, ball.y, ball.v, 0)
                else:
                    u, v = seen_at_strobe(ball, b, c)
                    b, ball = seen_from_strobe(u, v, c)
        state[0], state[1], state[4], state[5], state[6] = n, ball.t, ball.i, fastest, 0.0 if grounded else 1.0
        state[2], state[3] = (u, v) if grounded and not still else (ball.y, ball.v)
        if not still:
            state[7] = numbered(b)
        return count

    return record


@lru_cache(maxsize=64)
def sampler_of(prepare: Callable[..., Any], kind: type) -> Callable[..., None]:
    """Compile ``sample(row, t, y, v, s, h, w)``: height h and velocity w at times s after flights began at (t, y, v).

    Numbers of one flight stand together: what it needs is computed once.
    """
    unpack = unpacker(kind)

    def sample(row: Any, t: Any, y: Any, v: Any, s: Any, h: Any, w: Any) -> None:
        c = prepare(unpack(row))
        a = anchored(t[0], y[0], v[0], c)
        for j in range(s.shape[0]):
            if j > 0 and not (t[j] == t[j - 1] and y[j] == y[j - 1] and v[j] == v[j - 1]):
                a = anchored(t[j], y[j], v[j], c)
            h[j], w[j] = flight(s[j], a, c)

    return compiled(sample)


def flown_legs(model: Rig, state: tuple[float, float], start: float, until: float, limit: int) -> Floats:
    """Return all legs of a trajectory, shape (legs, 11), columns as named at the top of this file."""
    u, v = state
    if model.walled:
        rows, source = frames_rows(model, np.array([[*model.params.values(), start]], np.float64), "strict")
        row, record, now = rows[0], walled_recorder(model.harmonics), np.array([0.0, 0.0, u, v, 0.0, 0.0, 0.0, 0.0])
        given: tuple[Any, ...] = (until - start,)
    else:
        prepare = constants_of(model.harmonics, section_phase)
        row, source = pointed_model(model.seen[0], start)
        record = compiled(recorder_of(*POINTED, prepare, flight_kind(model.harmonics)))
        now, given = np.array([0.0, 0.0, u - model.walls[0].position, v, 0.0, 0.0, 0.0]), (until - start, PATIENCE)
    who = " or ".join(dict.fromkeys(f"the reset law {wall.law.name}" for wall in model.walls))
    tables, impacts = [], 0
    while now[0] * model.period + now[1] < until - start:
        legs = np.zeros((CAPACITY, 11))
        count = call(record, row, now, legs, *given, who=who)
        tables.append(legs[:count])
        bad = legs[:count][legs[:count, FLAGS].astype(int) & BAD_LAW != 0]
        if bad.size:
            law = model.walls[int(bad[0, HIT])].law
            in_python(law.law)(float(bad[0, V_MINUS]), parameters(law.params))  # which says its line, if it raises
            raise UserCodeError(
                f"the reset law {law.name} returned {bad[0, LEG]} for v_minus = {bad[0, V_MINUS]:g} "
                f"at t = {start + bad[0, PERIOD] * model.period + bad[0, END]:g}; "
                f"allowed is a finite v_plus >= 0, away from the wall{defined(law.law)}"
            )
        impacts += int(np.count_nonzero(~np.isnan(legs[:count, V_MINUS])))
        if impacts > limit:
            raise InputError(
                f"more than {limit} impacts up to t = {start + now[0] * model.period + now[1]:g}; "
                "choose an earlier end, r < 1 or a larger V, or declare the contraction of your law"
            )
        if (legs[:count, FLAGS].astype(int) & DIVERGED).any():
            break
    del source  # the laws' numbers lie in it: it had to live so long
    return np.concatenate(tables)


def heights(model: Oscillator, start: float, t: Floats, y: Floats, v: Floats, s: Floats) -> tuple[Floats, Floats]:
    """Return heights and velocities at times ``s`` after flights began at ``t``, counted from the section ``start``.

    ``y`` are heights above the wall, through which these flights may go.
    """
    numbers = pointed_model(model, start)
    sample = sampler_of(constants_of(model.harmonics, section_phase), flight_kind(model.harmonics))
    h, w = np.empty_like(s), np.empty_like(s)
    if s.size:
        sample(numbers.row, t, y, v, s, h, w)
    return h, w


def flown(model: Oscillator, start: float, t: Floats, y: Floats, v: Floats, s: Floats) -> tuple[Floats, Floats]:
    """Return positions and velocities at such times, none inside the wall.

    Where the ball rests, is for the caller to say.
    """
    h, w = heights(model, start, t, y, v, s)
    return np.maximum(h, 0.0) + model.sigma, w
