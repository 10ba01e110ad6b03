"""The module of the oscillator: its map, its flight, its discontinuity map and its reduction to the gap map.

Its wall may move, and a second one may be above the ball; the last two are of one wall at rest. A reset law is a number
in the row of parameters, so that one module does for all the laws that come with the package.
"""

from __future__ import annotations

from dataclasses import replace
from math import pi
from typing import Any

from grazing.explorer.composed import Module, arguments, common_entries, entries_of, orbits_entry
from grazing.explorer.webassembly import Argument, Entry
from grazing.kernel.lanes import unpacker
from grazing.kernel.primitives import unit
from grazing.maps.derivative import deriving, plainly, stepping
from grazing.maps.discontinuity import ORDERS, local_map_of, zero_time_of
from grazing.maps.period import period_of, walled_period
from grazing.maps.reduction import graze_search_of, has_steady_response, mu_factor, reduction_of, steady_low
from grazing.maps.starting import paper_box, reach_box
from grazing.oscillator.constants import HEAD, constants_of, section_phase
from grazing.oscillator.flight import anchored, flight
from grazing.oscillator.frames import alone, frame_of, linked
from grazing.oscillator.legs import END, HIT, LEG, PERIOD, SEEN, START, V, Y, recorder_of, walled_recorder_of
from grazing.oscillator.parameters import describe_parameter
from grazing.oscillator.reach import reach_of
from grazing.oscillator.reset import (
    active_contraction,
    active_law,
    newton_contraction,
    newton_law,
    newton_slope,
    triggered_contraction,
    triggered_law,
)
from grazing.oscillator.windows import series
from grazing.parameter import Parameter, parameter_tuple

#: Harmonics of the forcing that a row has; a model with fewer has zeros, and the same bits.
HARMONICS = 3
#: The laws, each by its place here.
LAWS = ("newton", "active", "triggered")
NEWTON, ACTIVE = 0.0, 1.0
INFINITY, NAN = float("inf"), float("nan")


WAVES = tuple(f"{name}{j}" for j in range(1, HARMONICS + 1) for name in ("cos", "sin"))
#: Of the upper wall, and of the motion that walls have together.
UPPER, MOTION = ("sigma_B", "r_B", "V_B", "trigger_B"), ("cos_A", "sin_A")
#: The parameters in the order of a row: those of the flight, of all laws, of the upper wall, of the motion of walls,
#: the law of both, the phase of the section, whether there is an upper wall, the order of the discontinuity map,
#: which other kernels ignore, and whether starts are those of the paper's pinball.
FIELDS = (*HEAD, *WAVES, "sigma", "r", "V", "trigger", *UPPER, *MOTION, "law", "phase", "two", "order", "paper")
KIND = parameter_tuple(FIELDS)

PHASE = FIELDS.index("phase")
PREPARE = constants_of(HARMONICS, section_phase)
UNPACK = unpacker(KIND)


def still(p: Any) -> bool:
    """Return whether there is one wall, at rest."""
    return p.two == 0.0 and p.cos_A == 0.0 and p.sin_A == 0.0  # type: ignore[no-any-return]


@unit
def seen_from(p: Any, sign: float, sigma: float, r: float, V: float, trigger: float) -> Any:
    """Return the parameters of the oscillator that a wall sees, see :meth:`grazing.oscillator.walled.Walled`."""
    lift, drag = p.omega * p.omega - p.k * p.k, p.alpha * p.omega
    cos, sin = p.cos1 + (lift * p.cos_A - drag * p.sin_A), p.sin1 + (lift * p.sin_A + drag * p.cos_A)
    return KIND(
        p.alpha, p.k, p.omega, p.t0, sign * p.offset + 0.0, sign * cos + 0.0, sign * sin + 0.0, sign * p.cos2 + 0.0,
        sign * p.sin2 + 0.0, sign * p.cos3 + 0.0, sign * p.sin3 + 0.0, sign * sigma + 0.0, r, V, trigger, p.sigma_B,
        p.r_B, p.V_B, p.trigger_B, p.cos_A, p.sin_A, p.law, p.phase, p.two, p.order, p.paper,
    )  # fmt: skip


@unit
def lower(p: Any) -> Any:
    """Return what the lower wall sees."""
    return seen_from(p, 1.0, p.sigma, p.r, p.V, p.trigger)


@unit
def upper(p: Any) -> Any:
    """Return what the upper wall sees."""
    return seen_from(p, -1.0, p.sigma_B, p.r_B, p.V_B, p.trigger_B)


@unit
def walls_of(p: Any) -> Any:
    """Return the frames of a row."""
    if still(p):
        return alone(PREPARE(p))
    a = PREPARE(lower(p))
    two, wave = p.two > 0.0, (p.cos_A, 0.0, 0.0, p.sin_A, 0.0, 0.0)
    b = PREPARE(upper(p)) if two else a
    high = p.sigma_B if two else p.sigma
    room = p.sigma_B - p.sigma if two else INFINITY  # exactly: walls move together
    return linked(a, b, (p.two, 1.0, room, p.sigma, *wave, high, *wave))


def chosen_law(v: float, p: Any) -> float:
    """Apply the law of the row."""
    if p.law == NEWTON:
        return newton_law(v, p)
    return active_law(v, p) if p.law == ACTIVE else triggered_law(v, p)


def chosen_contraction(p: Any) -> tuple[float, float]:
    """Return what is known of the law of the row near zero speed."""
    if p.law == NEWTON:
        return newton_contraction(p)
    return active_contraction(p) if p.law == ACTIVE else triggered_contraction(p)


LAW = chosen_law, newton_slope, chosen_contraction


def box_of(p: Any) -> Any:
    """Return where random starts of a row are drawn."""
    if p.paper != 0.0:
        return paper_box(p.sigma, 2.0 * pi / p.omega)
    force, V = p.offset - p.k * p.k * p.sigma, 0.0 if p.law == NEWTON else p.V
    cos, sin = (p.cos1, p.cos2, p.cos3), (p.sin1, p.sin2, p.sin3)
    height, speed, _after = reach_of(p.alpha, p.k, p.omega, force, cos, sin, p.sigma, p.r, V)
    return reach_box(p.sigma, height, speed)


def walls_box(p: Any) -> Any:
    """Return where random starts are drawn between walls, or at one that moves, see :mod:`grazing.maps.walled`."""
    c = walls_of(p)
    height, speed = seen_reach(c.a)
    low, high, slow, fast = c.za, c.za + height, c.wa, c.wa
    if c.two:
        _height, other = seen_reach(c.b)
        speed, high = max(speed, other), c.zb
        slow, fast = min(slow, c.wb), max(fast, c.wb)
    edge = 1e-3 * (high - low)
    return (low + edge, high - edge), (slow - speed, fast + speed)


def seen_reach(c: Any) -> Any:
    """Return how far orbits go from a wall, and how fast."""
    p = c.p
    cos, sin = (p.cos1, p.cos2, p.cos3), (p.sin1, p.sin2, p.sin3)
    V = 0.0 if p.law == NEWTON else p.V
    height, speed, after = reach_of(p.alpha, p.k, p.omega, c.F0, cos, sin, p.sigma, p.r, V)
    return height, min(speed, after) if p.two > 0.0 else speed


def boxes(rows: Any, boxes: Any) -> None:
    """Write where random starts are drawn, (low, high) of u and of v for each row."""
    for q in range(rows.shape[0]):
        p = UNPACK(rows[q])
        (u_low, u_high), (v_low, v_high) = box_of(p) if still(p) else walls_box(p)
        boxes[q, 0, 0], boxes[q, 0, 1], boxes[q, 1, 0], boxes[q, 1, 1] = u_low, u_high, v_low, v_high


LOWEST, FULL, CORRECTED = (local_map_of(chosen_law, newton_slope, order, True)[0] for order in ORDERS)


def local_step(state: Any, c: Any) -> Any:
    """Apply the discontinuity map of the row's order."""
    if c.p.order == 0.0:
        return LOWEST(state, c)
    return FULL(state, c) if c.p.order == 1.0 else CORRECTED(state, c)


ONE, ONE_TANGENT = period_of(*LAW, False), period_of(*LAW, True)
MORE, MORE_TANGENT = walled_period(LAW, LAW, False), walled_period(LAW, LAW, True)


def period(state: Any, c: Any) -> Any:
    """Take one period, as the map of the row's walls does."""
    return ONE(state, c.a) if still(c.a.p) else MORE(state, c)


def period_tangent(state: Any, c: Any) -> Any:
    """Take one period, with its derivative."""
    return ONE_TANGENT(state, c.a) if still(c.a.p) else MORE_TANGENT(state, c)


RECORD, RECORD_WALLED = recorder_of(*LAW, PREPARE, KIND), walled_recorder_of(*LAW, walls_of, KIND)


def legs(row: Any, state: Any, legs: Any, until: float, patience: float) -> int:
    """Record the legs of a flight; ``state`` begins with u where walls move or are two, else with the height."""
    if not still(UNPACK(row)):
        return RECORD_WALLED(row, state, legs, until)
    count = RECORD(row, state, legs, until, patience)
    for k in range(count):
        legs[k, SEEN], legs[k, HIT] = 0.0, 0.0
    return count


def sample(row: Any, legs: Any, times: Any, u: Any, v: Any) -> None:
    """Give the state at increasing times along the legs of a trajectory."""
    p = UNPACK(row)
    walls = walls_of(p)
    T = walls.a.T
    k = 0
    for j in range(times.shape[0]):
        while k + 1 < legs.shape[0] and times[j] >= legs[k + 1, PERIOD] * T + legs[k + 1, START]:
            k += 1
        leg = legs[k]
        b = leg[SEEN] > 0.0
        c, side = frame_of(b, walls), -1.0 if b else 1.0
        s = min(max(times[j] - (leg[PERIOD] * T + leg[START]), 0.0), leg[END] - leg[START])
        y, w = 0.0, 0.0
        if leg[LEG] == 0.0:
            y, w = flight(s, anchored(leg[START], leg[Y], leg[V], c), c)
        if still(p):
            u[j], v[j] = max(y, 0.0) + c.sigma, w
            continue
        at, speed = series(leg[START] + s, 0.0, (p.cos_A, 0.0, 0.0), (p.sin_A, 0.0, 0.0), c.omega, c.theta)
        place = at + (p.sigma_B if b else p.sigma) + side * max(y, 0.0)
        if p.two > 0.0:
            place = max(min(place, at + p.sigma_B), at + p.sigma)
        u[j], v[j] = place, speed + side * w


def at_zero(row: Any) -> Any:
    """Return the constants of a row with time measured from t = 0, as the normal form measures it."""
    changed = row.copy()
    changed[PHASE] = 0.0
    return PREPARE(UNPACK(changed))


def height(value: float, context: Any) -> float:
    """Return how high the steady response stays above the wall, with one parameter changed; NaN where there is none."""
    row, which = context
    changed = row.copy()
    changed[which] = value
    c = at_zero(changed)
    return steady_low(c)[1] if has_steady_response(c) else NAN


ZERO_TIME = zero_time_of(chosen_law)


def zero_time(row: Any, u0: float, v0: float, corners: Any, numbers: Any) -> float:
    """Write the four points of the zero-time map, then delta and A; return x, not a number without an impact."""
    c = PREPARE(UNPACK(row))
    y = u0 - c.sigma
    x, delta, A, root, V2, U3, V3 = ZERO_TIME(y, v0, c)
    corners[0, 0], corners[0, 1], corners[1, 0], corners[1, 1] = u0, v0, c.sigma, -root
    corners[2, 0], corners[2, 1], corners[3, 0], corners[3, 1] = c.sigma, V2, U3 + c.sigma, V3
    numbers[0], numbers[1] = delta, A
    return x if v0 < 0.0 and x >= 0.0 and y >= 0.0 else NAN


SEARCH = graze_search_of(height)
REDUCTION = reduction_of(chosen_law, newton_slope)


def clearance(row: Any, which: int, values: Any, heights: Any) -> None:
    """Write the heights for many values of one parameter."""
    for j in range(values.shape[0]):
        heights[j] = height(values[j], (row, which))


def graze(row: Any, which: int, low: float, high: float, open_low: int) -> float:
    """Return the nearest value of a parameter at which the steady response grazes the wall."""
    return SEARCH((row, which), row[which], low, high, open_low != 0, 1.0)


def reduce(row: Any, numbers: Any) -> None:
    """Write the numbers of the normal form of a model that is at a graze."""
    found = REDUCTION(at_zero(row))
    for i in range(len(found)):
        numbers[i] = found[i]
    numbers[len(found)] = mu_factor(found.lam, found.det, found.acceleration, found.b, found.r)


def described(name: str) -> Parameter | dict[str, Any]:
    """Return what is known of a field: a parameter, or one of a few choices by number."""
    if name == "law":
        return {"name": name, "meaning": "reset law", "choices": list(LAWS)}
    if name == "order":
        return {"name": name, "meaning": "order of the discontinuity map", "choices": list(ORDERS)}
    if name == "paper":
        return {"name": name, "meaning": "whether starts are those of the paper's pinball", "choices": ["no", "yes"]}
    if name == "two":
        return {"name": name, "meaning": "whether there is a wall above the ball", "choices": ["no", "yes"]}
    if name in MOTION:
        word = "cosine" if name == "cos_A" else "sine"
        return Parameter(name, f"{name[0]}_{{A}}", f"{word} amplitude of the motion of the walls")
    if name in UPPER:
        known = describe_parameter(name.removesuffix("_B"))
        letter, _below, sub = known.symbol.partition("_")
        return replace(known, name=name, symbol=f"{letter}_{{{sub}B}}", meaning=f"upper wall: {known.meaning}")
    return describe_parameter(name)


def oscillator_module() -> Module:
    """Return the module."""
    return Module(entries(), tuple(described(name) for name in FIELDS), ("u", "v"), None)


def entries() -> list[Entry]:
    """Return the functions of the module."""
    fields = len(FIELDS)
    row = Argument("row", "float64", (fields,), "parameter values, in the order of `fields`")
    which = Argument("which", "int64", (), "which of `fields` varies")
    return [
        *common_entries(boxes, fields, 2),
        *entries_of(stepping(period), plainly(deriving(period_tangent)), walls_of, KIND, 2),
        orbits_entry(local_step, PREPARE, KIND, 2, "orbits_local", "iterate the discontinuity map"),
        Entry(
            "legs", legs, ("capacity",),
            (row, *arguments("""
                state: float64[8]  periods, t, u - sigma (u if walls move or are two), v, window, fastest, 0 at a \
                    strobe, wall; moved on
                legs: float64[capacity, 11]  period, t, height above the wall, v, t at the end, v before and after \
                    the impact there, outcome, 1 for a rest, wall that sees it so, wall at its end
                until: float64  time at which to stop, from the section on
                patience: float64  chatter is followed down to this share of its first speed
            """)),
            "int64", "follow the ball from impact to impact; returns how many legs were filled",
        ),
        Entry(
            "sample", sample, ("count", "samples"),
            (row, *arguments("""
                legs: float64[count, 11]  from `legs`
                times: float64[samples]  increasing, from the section on
                u: float64[samples]  position at those times
                v: float64[samples]  velocity at those times
            """)),
            meaning="position and velocity along the legs of a trajectory",
        ),
        Entry(
            "zero_time", zero_time, (),
            (row, *arguments("""
                u0: float64  position at the section
                v0: float64  velocity at the section
                corners: float64[4, 2]  (U0, V0) to (U3, V3)
                numbers: float64[2]  delta, acceleration A
            """)),
            "float64", "the zero-time map of a state; returns v^2 - 2 A (u - sigma), not a number without an impact",
        ),
        Entry(
            "clearance", clearance, ("count",),
            (row, which, *arguments("""
                values: float64[count]  values of that parameter
                heights: float64[count]  lowest point of the steady response above the wall
            """)),
            meaning="how high the response without impacts stays; mu is `factor` times this",
        ),
        Entry(
            "graze", graze, (),
            (row, which, *arguments("""
                low: float64  least value allowed
                high: float64  greatest value allowed
                open_low: int64  1 if the least value itself is not allowed
            """)),
            "float64",
            "the value of a parameter at which the steady response grazes; not a number if there is none near",
        ),
        Entry(
            "reduce", reduce, (),
            (row, *arguments("""
                numbers: float64[13]  time, acceleration, lam, l, b, det, scale, r, V, a, e21, d, factor
            """)),
            meaning="the normal form of the model at a graze, with the row of the graze",
        ),
    ]  # fmt: skip
