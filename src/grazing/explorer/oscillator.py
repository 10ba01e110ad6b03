"""The module of the oscillator: its map, its flight, its discontinuity map and its reduction to the gap map.

Its wall may move, and a second one may be above the ball; the last two are of one wall at rest. A reset law is a number
in the row of parameters, so that one module does for all the laws that come with the package.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from math import pi
from typing import Any, NamedTuple

from grazing.explorer.composed import Module, Step, arguments, common_entries, entries_of, orbits_entry
from grazing.explorer.recurring import recurring_counter, recurring_loop
from grazing.explorer.webassembly import Argument, Entry
from grazing.kernel.lanes import unpacker
from grazing.kernel.primitives import built, replaced, unit
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
from grazing.oscillator.reach import drive_of, reach_of
from grazing.oscillator.reset import (
    Reset,
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
#: Parameters of the laws, and of a wall.
OF_LAWS = ("r", "V", "trigger")
OF_WALL = ("sigma", *OF_LAWS)
#: Of the upper wall, and of the motion that walls have together.
UPPER, MOTION = tuple(f"{name}_B" for name in OF_WALL), ("cos_A", "sin_A")
#: The parameters in the order of a row: those of the flight, of all laws, of the upper wall, of the motion of walls,
#: the law of both, the phase of the section, whether there is an upper wall, the order of the discontinuity map,
#: which other kernels ignore, and whether starts are those of the paper's pinball.
FIELDS = (*HEAD, *WAVES, *OF_WALL, *UPPER, *MOTION, "law", "phase", "two", "order", "paper")
#: Where the phase of the section stands in a row, and the constant force, behind which its amplitudes are.
PHASE, OFFSET = FIELDS.index("phase"), FIELDS.index("offset")
#: Constants of a flight from a row.
PREPARE = constants_of(HARMONICS, section_phase)


class Laws(NamedTuple):
    """The reset laws of a module as one law of a row, with all that a row holds for them.

    ``line(p, drive)`` gives the (r, V) of the law v_plus = r |v_minus| + V most like that of the row, at the speed that
    what :func:`drive_of` is given says; ``fields`` are those of a row, ``lower`` and ``upper`` those of them that are
    parameters of a wall.
    """

    names: tuple[str, ...]
    fields: tuple[str, ...]
    lower: tuple[str, ...]
    upper: tuple[str, ...]
    law: Callable[..., float]
    slope: Callable[..., float]
    contraction: Callable[..., Any]
    line: Callable[..., Any]


def still(p: Any) -> bool:
    """Return whether there is one wall, at rest."""
    return p.two == 0.0 and p.cos_A == 0.0 and p.sin_A == 0.0  # type: ignore[no-any-return]


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


def chosen_line(p: Any, drive: Any) -> tuple[float, float]:
    """Return (r, V) of the law of the row, which is affine piece by piece."""
    return p.r, 0.0 if p.law == NEWTON else p.V


#: Those that come with the package.
BUILT_IN = Laws(LAWS, FIELDS, OF_WALL, UPPER, chosen_law, newton_slope, chosen_contraction, chosen_line)


def name_of(own: Reset) -> str:
    """Return what links call a law of the user's own."""
    return own.name if own.name.isidentifier() and own.name not in LAWS else "own"


def field_of(name: str) -> str:
    """Return the field of a parameter of a law: that of the laws here, or one of the lower wall's own."""
    return name if name in OF_LAWS else f"A.{name}"


def with_own(own: Reset) -> Laws:
    """Return the laws of a module for one more, of the user's own.

    Parameters that are called as those of the laws here are the same numbers; others get fields of their own, behind
    all others.
    """
    added = tuple(field_of(name) for name in own.params if name not in OF_LAWS)
    above = tuple(f"B.{name}" for name in own.params if name not in OF_LAWS)
    fields = (*FIELDS, *added, *above)
    places = tuple(fields.index(field_of(name)) for name in own.params)
    number, kind, zero = float(len(LAWS)), parameter_tuple(tuple(own.params)), (0.0,) * max(len(own.params), 1)
    law_of, slope_of, contraction_of = own.law, own.slope, own.contraction

    def params(p: Any) -> Any:
        values = zero
        for i in range(len(places)):
            values = replaced(values, i, p[places[i]])
        return built(kind, values)

    def law(v: float, p: Any) -> float:
        return law_of(v, params(p)) if p.law == number else chosen_law(v, p)

    def slope(v: float, p: Any) -> float:
        return slope_of(v, params(p)) if p.law == number else newton_slope(v, p)

    def contraction(p: Any) -> tuple[float, float]:
        return contraction_of(params(p)) if p.law == number else chosen_contraction(p)

    def line(p: Any, drive: Any) -> tuple[float, float]:
        if p.law != number:
            return chosen_line(p, drive)
        speed, kick = drive_of(*drive)[1], law_of(0.0, params(p))
        fast = law_of(-speed, params(p)) if speed > 0.0 else kick
        if not (0.0 <= kick < INFINITY and 0.0 <= fast < INFINITY):
            return 1.0, 0.0
        return min(max((fast - kick) / speed if speed > 0.0 else 1.0, 0.0), 1.0), kick

    names, lower, upper = (*LAWS, name_of(own)), (*OF_WALL, *added), (*UPPER, *above)
    return Laws(names, fields, lower, upper, law, slope, contraction, line)


class Frames(NamedTuple):
    """A row as kernels want it: its type, from an array, and the frames of its walls."""

    kind: type
    unpack: Callable[..., Any]
    walls: Callable[..., Any]


def frames_of_rows(laws: Laws) -> Frames:
    """Return what makes frames of rows."""
    kind, own = parameter_tuple(laws.fields), len(laws.lower) - len(OF_WALL)
    wall, above, motion, end = (*(FIELDS.index(name) for name in ("sigma", "sigma_B", "cos_A")), len(FIELDS))
    last = end + own

    @unit
    def seen_from(p: Any, sign: float, of_wall: Any) -> Any:
        """Return the oscillator that a wall sees, see :meth:`grazing.oscillator.walled.Walled`."""
        lift, drag = p.omega * p.omega - p.k * p.k, p.alpha * p.omega
        cos, sin = p.cos1 + (lift * p.cos_A - drag * p.sin_A), p.sin1 + (lift * p.sin_A + drag * p.cos_A)
        seen = (
            sign * p.offset + 0.0, sign * cos + 0.0, sign * sin + 0.0, sign * p.cos2 + 0.0, sign * p.sin2 + 0.0,
            sign * p.cos3 + 0.0, sign * p.sin3 + 0.0, sign * of_wall[0] + 0.0,
        )  # fmt: skip
        return built(kind, p[:OFFSET] + seen + of_wall[1:4] + p[above:end] + of_wall[4:] + p[last:])

    @unit
    def walls(p: Any) -> Any:
        """Return the frames of a row."""
        if still(p):
            return alone(PREPARE(p))
        a = PREPARE(seen_from(p, 1.0, p[wall:above] + p[end:last]))
        two, wave = p.two > 0.0, (p.cos_A, 0.0, 0.0, p.sin_A, 0.0, 0.0)
        b = PREPARE(seen_from(p, -1.0, p[above:motion] + p[last:])) if two else a
        high = p.sigma_B if two else p.sigma
        room = p.sigma_B - p.sigma if two else INFINITY  # exactly: walls move together
        return linked(a, b, (p.two, 1.0, room, p.sigma, *wave, high, *wave))

    return Frames(kind, unpacker(kind), walls)


def boxes_of(laws: Laws, frames: Frames) -> Step:
    """Return the kernel that says where random starts of rows are drawn."""
    unpack, walls_of, line = frames.unpack, frames.walls, laws.line

    def reach(p: Any, force: float) -> Any:
        """Return how far orbits go from a wall, how fast, and how fast they leave it."""
        cos, sin = (p.cos1, p.cos2, p.cos3), (p.sin1, p.sin2, p.sin3)
        r, V = line(p, (p.alpha, p.k, p.omega, force, cos, sin))
        return reach_of(p.alpha, p.k, p.omega, force, cos, sin, p.sigma, r, V)

    def box(p: Any) -> Any:
        """Return where random starts of a row are drawn."""
        if p.paper != 0.0:
            return paper_box(p.sigma, 2.0 * pi / p.omega)
        height, speed, _after = reach(p, p.offset - p.k * p.k * p.sigma)
        return reach_box(p.sigma, height, speed)

    def walls_box(p: Any) -> Any:
        """Return where they are drawn between walls, or at one that moves, see :mod:`grazing.maps.walled`."""
        c = walls_of(p)
        height, speed, after = reach(c.a.p, c.a.F0)
        low, high, slow, fast = c.za, c.za + height, c.wa, c.wa
        if c.two:
            _height, other, left = reach(c.b.p, c.b.F0)
            speed, high = max(min(speed, after), min(other, left)), c.zb
            slow, fast = min(slow, c.wb), max(fast, c.wb)
        edge = 1e-3 * (high - low)
        return (low + edge, high - edge), (slow - speed, fast + speed)

    def boxes(rows: Any, boxes: Any) -> None:
        for q in range(rows.shape[0]):
            p = unpack(rows[q])
            (u_low, u_high), (v_low, v_high) = box(p) if still(p) else walls_box(p)
            boxes[q, 0, 0], boxes[q, 0, 1], boxes[q, 1, 0], boxes[q, 1, 1] = u_low, u_high, v_low, v_high

    return boxes


def steps_of(laws: Laws) -> tuple[Step, Step, Step]:
    """Return one period, as the map of the row's walls takes it, the same with its derivative, and the local map."""
    law = laws.law, laws.slope, laws.contraction
    one, one_tangent = period_of(*law, False), period_of(*law, True)
    more, more_tangent = walled_period(law, law, False), walled_period(law, law, True)
    lowest, full, corrected = (local_map_of(laws.law, laws.slope, order, True)[0] for order in ORDERS)

    def period(state: Any, c: Any) -> Any:
        return one(state, c.a) if still(c.a.p) else more(state, c)

    def tangent(state: Any, c: Any) -> Any:
        return one_tangent(state, c.a) if still(c.a.p) else more_tangent(state, c)

    def local(state: Any, c: Any) -> Any:
        if c.p.order == 0.0:
            return lowest(state, c)
        return full(state, c) if c.p.order == 1.0 else corrected(state, c)

    return period, tangent, local


def flights_of(laws: Laws, frames: Frames) -> tuple[Step, Step]:
    """Return what records the legs of a flight, and what gives the state along them."""
    unpack, walls_of = frames.unpack, frames.walls
    law = laws.law, laws.slope, laws.contraction
    record, record_walled = recorder_of(*law, PREPARE, frames.kind), walled_recorder_of(*law, walls_of, frames.kind)

    def legs(row: Any, state: Any, legs: Any, until: float, patience: float) -> int:
        """Record legs; ``state`` begins with u where walls move or are two, else with the height."""
        if not still(unpack(row)):
            return record_walled(row, state, legs, until)
        count = record(row, state, legs, until, patience)
        for k in range(count):
            legs[k, SEEN], legs[k, HIT] = 0.0, 0.0
        return count

    def sample(row: Any, legs: Any, times: Any, u: Any, v: Any) -> None:
        """Give the state at increasing times."""
        p = unpack(row)
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

    return legs, sample


def at_graze_of(laws: Laws, frames: Frames) -> tuple[Step, Step, Step, Step]:
    """Return what is computed of the local map and the normal form: zero_time, clearance, graze, reduce."""
    unpack, of_law = frames.unpack, zero_time_of(laws.law)

    def zero_time(row: Any, u0: float, v0: float, corners: Any, numbers: Any) -> float:
        """Write the four points of the zero-time map, then delta and A; return x, not a number without an impact."""
        c = PREPARE(unpack(row))
        y = u0 - c.sigma
        x, delta, A, root, V2, U3, V3 = of_law(y, v0, c)
        corners[0, 0], corners[0, 1], corners[1, 0], corners[1, 1] = u0, v0, c.sigma, -root
        corners[2, 0], corners[2, 1], corners[3, 0], corners[3, 1] = c.sigma, V2, U3 + c.sigma, V3
        numbers[0], numbers[1] = delta, A
        return x if v0 < 0.0 and x >= 0.0 and y >= 0.0 else NAN

    def at_zero(row: Any) -> Any:
        """Return the constants of a row with time measured from t = 0, as the normal form measures it."""
        changed = row.copy()
        changed[PHASE] = 0.0
        return PREPARE(unpack(changed))

    def height(value: float, context: Any) -> float:
        """Return how high the steady response stays above the wall, with one parameter changed; NaN where none is."""
        row, which = context
        changed = row.copy()
        changed[which] = value
        c = at_zero(changed)
        return steady_low(c)[1] if has_steady_response(c) else NAN

    search, reduction = graze_search_of(height), reduction_of(laws.law, laws.slope)

    def clearance(row: Any, which: int, values: Any, heights: Any) -> None:
        """Write the heights for many values of one parameter."""
        for j in range(values.shape[0]):
            heights[j] = height(values[j], (row, which))

    def graze(row: Any, which: int, low: float, high: float, open_low: int) -> float:
        """Return the nearest value of a parameter at which the steady response grazes the wall."""
        return search((row, which), row[which], low, high, open_low != 0, 1.0)

    def reduce(row: Any, numbers: Any) -> None:
        """Write the numbers of the normal form of a model that is at a graze."""
        found = reduction(at_zero(row))
        for i in range(len(found)):
            numbers[i] = found[i]
        numbers[len(found)] = mu_factor(found.lam, found.det, found.acceleration, found.b, found.r)

    return zero_time, clearance, graze, reduce


def described(name: str, laws: Laws) -> Parameter | dict[str, Any]:
    """Return what is known of a field: a parameter, or one of a few choices by number."""
    if name == "law":
        return {"name": name, "meaning": "reset law", "choices": list(laws.names)}
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
    if "." in name:
        wall, _, own = name.partition(".")
        known = describe_parameter(own)
        above = wall == "B"
        return replace(
            known, name=name, symbol=f"{own}_{{B}}" if above else own,
            meaning=f"upper wall: {known.meaning}" if above else known.meaning,
        )  # fmt: skip
    return describe_parameter(name)


def oscillator_module(own: Reset | None = None) -> Module:
    """Return the module, with a reset law of the user's own beside those of the package if there is one."""
    laws = BUILT_IN if own is None else with_own(own)
    return Module(entries(laws), tuple(described(name, laws) for name in laws.fields), ("u", "v"), None)


def entries(laws: Laws) -> list[Entry]:
    """Return the functions of the module."""
    fields, frames = len(laws.fields), frames_of_rows(laws)
    period, tangent, local = steps_of(laws)
    run = recurring_loop(stepping(period), frames.walls, frames.kind, 2)
    legs, sample = flights_of(laws, frames)
    zero_time, clearance, graze, reduce = at_graze_of(laws, frames)
    row = Argument("row", "float64", (fields,), "parameter values, in the order of `fields`")
    which = Argument("which", "int64", (), "which of `fields` varies")
    return [
        *common_entries(boxes_of(laws, frames), fields, 2),
        *entries_of(run, recurring_counter(run, 2), plainly(deriving(tangent)), frames.walls, frames.kind, 2),
        orbits_entry(
            recurring_loop(local, PREPARE, frames.kind, 2), frames.kind, 2, "orbits_local",
            "iterate the discontinuity map",
        ),
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
