"""Trajectories: flights and impacts in continuous time, every impact located, none sampled."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from math import ceil
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from grazing.kernel.compile import call, compiled
from grazing.kernel.lanes import unpacker
from grazing.memory import refuse_too_large
from grazing.oscillator.constants import constants_of, piece_of, roots, section_phase
from grazing.oscillator.contact import FLIES, MAX_SWINGS, departure_of, next_contact, placed
from grazing.oscillator.flight import anchored, flight
from grazing.oscillator.model import Oscillator, checked_model
from grazing.oscillator.pointed import POINTED, flight_kind, pointed_model
from grazing.oscillator.reset import in_python
from grazing.outcome import (
    AMBIGUOUS,
    BAD_LAW,
    CHATTER,
    DIVERGED,
    TOO_MANY_SWINGS,
    InputError,
    Trust,
    UserCodeError,
    describe,
    shown,
)
from grazing.parameter import parameters, real, whole

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]

#: Chatter is followed impact by impact down to this fraction of its first speed, then completed in closed form.
PATIENCE = 1e-6
CAPACITY = 4096
#: A trajectory lists every impact and samples every period; beyond these it is refused by name.
MAX_IMPACTS = 200_000
MAX_POINTS = 20_000_000
#: Bytes of a point, and of a leg beside its points.
POINT, LEG_SIZE = 64, 800
# columns of a leg
PERIOD, START, Y, V, END, V_MINUS, V_PLUS, FLAGS, LEG = range(9)


@lru_cache(maxsize=64)
def recorder_of(
    law: Callable[..., float],
    slope: Callable[..., float],
    contraction: Callable[..., Any],
    prepare: Callable[..., Any],
    kind: type,
) -> Callable[..., int]:
    """Compile ``record(row, state, legs, until, patience)``: fill legs until a time or the table's end.

    ``state`` holds (periods, t, y, v, window, fastest, in the air) and is moved along, so the call can be repeated.
    A leg is a flight or a rest from (period, t, y, v) to t_end; v_minus and v_plus are NaN where it ends without an
    impact. As in the stroboscopic map, the state at each strobe is the one that the next decisions are right for.
    """
    departure = departure_of(law, slope, contraction)
    unpack = unpacker(kind)

    def record(row: Any, state: Any, legs: Any, until: float, patience: float) -> int:
        c = prepare(unpack(row))
        n, fastest, grounded = int(state[0]), state[5], state[6] == 0.0
        ball = placed(state[1], state[2], state[3], int(state[4]))
        count = 0
        while count + 2 < legs.shape[0] and n * c.T + ball.t < until:
            leg = legs[count]
            leg[0], leg[1], leg[2], leg[3] = n, ball.t, ball.y, ball.v
            leg[5], leg[6], leg[7], leg[8] = np.nan, np.nan, 0.0, 0.0
            count += 1
            hit, flags = grounded and ball.y == 0.0 and ball.v <= 0.0, 0
            if not hit:
                hit, ball, flags, _near = next_contact(ball, c)
            leg[4] = ball.t
            if hit:
                arrived = ball.v
                how, ball, said = departure(ball, patience * fastest, c)
                flags |= said
                if arrived < 0.0 or ball.v > 0.0:
                    leg[5], leg[6] = arrived, ball.v
                fastest = max(fastest, ball.v) if how == FLIES else 0.0
                if said & (BAD_LAW | DIVERGED):
                    leg[7], leg[8] = flags, ball.v
                    break
                if how != FLIES:
                    rest = legs[count]
                    rest[0], rest[1], rest[2], rest[3], rest[4] = n, leg[4], 0.0, 0.0, ball.t
                    rest[5], rest[6], rest[7], rest[8] = np.nan, np.nan, 0.0, 1.0
                    count += 1
            leg[7] = flags
            grounded = ball.t >= c.T  # only at a strobe can the ball be on the wall with its contact still to come
            if grounded:
                n, fastest = n + 1, 0.0
                ball = placed(0.0, ball.y, ball.v, 0)
        state[0], state[1], state[2], state[3], state[4] = n, ball.t, ball.y, ball.v, ball.i
        state[5], state[6] = fastest, 0.0 if grounded else 1.0
        return count

    return compiled(record)


@lru_cache(maxsize=64)
def sampler_of(prepare: Callable[..., Any], kind: type) -> Callable[..., None]:
    """Compile ``sample(row, t, y, v, s, u, w)``: position u and velocity w at times s after flights began at (t, y, v).

    Numbers of one flight stand together: what it needs is computed once.
    """
    unpack = unpacker(kind)

    def sample(row: Any, t: Any, y: Any, v: Any, s: Any, u: Any, w: Any) -> None:
        c = prepare(unpack(row))
        a = anchored(t[0], y[0], v[0], c)
        for j in range(s.shape[0]):
            if j > 0 and not (t[j] == t[j - 1] and y[j] == y[j - 1] and v[j] == v[j - 1]):
                a = anchored(t[j], y[j], v[j], c)
            height, w[j] = flight(s[j], a, c)
            u[j] = max(height, 0.0) + c.sigma

    return compiled(sample)


def flown_legs(model: Oscillator, state: tuple[float, float], start: float, until: float, limit: int) -> Floats:
    """Return all legs of a trajectory, shape (legs, 9), columns as named at the top of this file."""
    law = model.reset
    numbers, prepare = pointed_model(model, start), constants_of(model.harmonics, section_phase)
    record = recorder_of(*POINTED, prepare, flight_kind(model.harmonics))
    now = np.array([0.0, 0.0, state[0] - model.sigma, state[1], 0.0, 0.0, 0.0])
    tables = []
    impacts = 0
    while now[0] * model.period + now[1] < until - start:
        legs = np.zeros((CAPACITY, 9))
        count = call(record, numbers.row, now, legs, until - start, PATIENCE, who=f"the reset law {law.name}")
        tables.append(legs[:count])
        bad = legs[:count][legs[:count, FLAGS].astype(int) & BAD_LAW != 0]
        if bad.size:
            in_python(law.law)(float(bad[0, V_MINUS]), parameters(law.params))  # which says its line, if it raises
            raise UserCodeError(
                f"the reset law {law.name} returned {bad[0, LEG]} for v_minus = {bad[0, V_MINUS]:g} "
                f"at t = {start + bad[0, PERIOD] * model.period + bad[0, END]:g}; "
                "allowed is a finite v_plus >= 0, away from the wall"
            )
        impacts += int(np.count_nonzero(~np.isnan(legs[:count, V_MINUS])))
        if impacts > limit:
            raise InputError(
                f"more than {limit} impacts up to t = {start + now[0] * model.period + now[1]:g}; "
                "choose an earlier end, r < 1 or a larger V, or declare the contraction of your law"
            )
    return np.concatenate(tables)


def trajectory(
    model: Oscillator,
    state: ArrayLike,
    start: float = 0.0,
    until: float = 50.0,
    samples: int = 200,
) -> xr.Dataset:
    """Follow the ball in continuous time.

    Parameters
    ----------
    model : Oscillator
    state : array_like, shape (2,)
        (u, v) at time ``start``, u >= sigma. At u = sigma with v < 0 the ball is hit at once.
    start, until : float
        Time interval, until > start.
    samples : int
        Points per forcing period, at least 2; each flight also has its two ends, so that velocities jump where
        they do. Impacts do not depend on it.

    Returns
    -------
    xarray.Dataset
        ``u``, ``v`` on ``t``; ``impact_time``, ``v_minus``, ``v_plus`` on ``impact``; ``wall``, where it is;
        ``trust``, one word: *certified* (right for the state at each ``start`` + nT, as in the stroboscopic map) or
        *ambiguous*. Chatter is listed down to 1e-6 of the fastest departure since the last strobe or rest
        and then completed.

    Raises
    ------
    InputError
        For a ball inside the wall, an empty or reversed interval, or more impacts than can be listed.
    UserCodeError
        For a reset law that returns what it must not.

    Examples
    --------
    >>> import grazing as gz
    >>> tr = gz.trajectory(gz.pinball(d=0.12, V=0.4), (0.1, 0.0), until=20.0)
    >>> tr.sizes["impact"], str(tr.trust.item())
    (3, 'certified')
    """
    import xarray as xr

    checked_model(model)
    start = real(start, "start", "a finite time is allowed")
    until = real(until, "until", "a finite time is allowed")
    samples = whole(samples, "samples", 2)
    if not until > start:
        raise InputError(f"until = {until:g} is not after start = {start:g}; give until > start")
    u, v = checked_state(state, model)
    _refuse_too_much(model, (until - start) / model.period * samples, samples)
    legs = flown_legs(model, (u, v), start, until, MAX_IMPACTS)
    times, us, vs = _sampled(model, legs, start, until, samples)
    ends = np.array([_instants(leg, start, model.period)[1] for leg in legs])
    hits = ~np.isnan(legs[:, V_MINUS]) & (ends <= until)
    flags = int(np.bitwise_or.reduce(legs[:, FLAGS].astype(int)))
    trust = Trust.ambiguous if flags & AMBIGUOUS else Trust.certified
    about = {name: model.describe(name).attributes for name in ("t", "u", "v", "v_minus", "v_plus")}
    result = xr.Dataset(
        {
            "u": ("t", us, about["u"]),
            "v": ("t", vs, about["v"]),
            "impact_time": ("impact", ends[hits], about["t"] | {"long_name": "time of impact"}),
            "v_minus": ("impact", legs[hits, V_MINUS], about["v_minus"]),
            "v_plus": ("impact", legs[hits, V_PLUS], about["v_plus"]),
            "wall": ((), model.sigma, model.describe("sigma").attributes),
            "trust": ((), trust.value),
        },
        coords={"t": ("t", times, about["t"])},
    )
    result.attrs = {
        "title": f"trajectory of {model!r}",
        "grazing_outcome": flags,
        "chatter": int(bool(flags & CHATTER)),
        **model.attributes,
        **{f"parameter_{name}": value for name, value in model.params.items()},
    }
    return result


def _refuse_too_much(model: Oscillator, points: float, samples: int) -> None:
    if points > MAX_POINTS:
        raise InputError(
            f"{points:.3g} points are more than {MAX_POINTS:.3g}; choose an earlier end or fewer samples per period, "
            "or iterate the stroboscopic map"
        )
    # a period is a leg at least, whose three arrays are objects of their own until they are joined
    refuse_too_large(
        POINT * points + LEG_SIZE * (points / samples),
        "choose an earlier end or fewer samples per period",
        "the trajectory",
    )
    q2, spread, _l1, _l2 = roots(model.alpha, model.k)
    if q2 < 0.0 and model.period > MAX_SWINGS * piece_of(q2, spread, model.period):
        raise InputError(describe(TOO_MANY_SWINGS))


def checked_state(state: ArrayLike, model: Oscillator) -> tuple[float, float]:
    """Return (u, v) as floats, or raise InputError: two finite numbers, not inside the wall."""
    try:
        values = np.asarray(state, dtype=object).ravel().tolist() if len(state) == 2 else []  # type: ignore[arg-type]
    except Exception:  # of whatever object was given
        values = []
    if len(values) != 2:
        raise InputError(f"state is {shown(state)}; give two numbers (u, v)")
    u, v = (real(x, name, "any finite number is allowed") for x, name in zip(values, "uv", strict=True))
    if u < model.sigma:
        raise InputError(f"the ball starts inside the wall: u = {u:g}, sigma = {model.sigma:g}; start with u >= sigma")
    return u, v


def _instants(leg: Floats, start: float, period: float) -> tuple[float, float]:
    """Return the times at which a leg begins and ends; the end of a period is the beginning of the next."""
    origin, following = start + leg[PERIOD] * period, start + (leg[PERIOD] + 1.0) * period
    return min(origin + leg[START], following), following if leg[END] >= period else min(origin + leg[END], following)


def flown(model: Oscillator, start: float, t: Floats, y: Floats, v: Floats, s: Floats) -> tuple[Floats, Floats]:
    """Return positions and velocities at times ``s`` after flights began at ``t``, counted from the section ``start``.

    ``y`` are heights above the wall. Where the ball rests, is for the caller to say.
    """
    numbers = pointed_model(model, start)
    sample = sampler_of(constants_of(model.harmonics, section_phase), flight_kind(model.harmonics))
    u, w = np.empty_like(s), np.empty_like(s)
    if s.size:
        sample(numbers.row, t, y, v, s, u, w)
    return u, w


def _sampled(
    model: Oscillator, legs: Floats, start: float, until: float, samples: int
) -> tuple[Floats, Floats, Floats]:
    """Return times, positions and velocities along the legs, both ends of every leg included."""
    times, ways, which, last = [], [], [], []
    for number, leg in enumerate(legs):
        begins, ends = _instants(leg, start, model.period)
        ends = min(ends, until)
        if begins > ends:
            continue
        length = leg[END] - leg[START] if ends < until else min(until - begins, leg[END] - leg[START])
        s = np.linspace(0.0, length, max(2, ceil(samples * length / model.period) + 1))
        times.append(np.minimum(begins + s, ends))
        times[-1][-1] = ends
        ways.append(s)
        which.append(number)
        last.append(length == leg[END] - leg[START])
    counts = np.array([len(s) for s in ways])
    begun = legs[np.repeat(which, counts)]
    t, y, w = np.ascontiguousarray(begun[:, [START, Y, V]].T)
    u, v = flown(model, start, t, y, w, np.concatenate(ways))
    rest = begun[:, LEG] != 0.0
    u[rest], v[rest] = model.sigma, 0.0
    # the ends of a flight are known better than by a formula
    flew = legs[which, LEG] == 0.0
    after = np.cumsum(counts)
    first = (after - counts)[flew]
    u[first], v[first] = legs[which, Y][flew] + model.sigma, legs[which, V][flew]
    hit = flew & np.array(last) & ~np.isnan(legs[which, V_MINUS])
    u[after[hit] - 1], v[after[hit] - 1] = model.sigma, legs[which, V_MINUS][hit]
    return np.concatenate(times), u, v
