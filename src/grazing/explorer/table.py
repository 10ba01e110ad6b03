"""The module of the pinball table: its flights, its flippers at a player's hands, and the exits of launches.

A table travels as the block of numbers that kernels get in Python too, see :mod:`grazing.billiard.rows`, with room
behind it for what a player does to the flippers. The page changes numbers in it, and makes none.
"""

from __future__ import annotations

from collections.abc import Callable
from math import pi
from typing import Any

from grazing.billiard import flippers as rows_of_flippers
from grazing.billiard import rows as rows_of_tables
from grazing.billiard.contact import next_event, slid_on
from grazing.billiard.elements import slid
from grazing.billiard.flippers import AT, FLIPPER_WIDTH, PIECE_WIDTH, PIECES
from grazing.billiard.flown import COLUMNS, record
from grazing.billiard.hit import flown, rows_of
from grazing.billiard.laws import law_at
from grazing.billiard.objects import Thing
from grazing.billiard.players import switched
from grazing.billiard.ride import carried_to
from grazing.billiard.rows import CIRCLES, FACES, GRAVITY, SIDES, WIDTH, gravity_of
from grazing.billiard.table import Table
from grazing.billiard.turning import ON, RIDES
from grazing.config.tables import LAWS, read_table, shipped
from grazing.explorer.composed import Module, arguments
from grazing.explorer.webassembly import Argument, Entry
from grazing.kernel.elementary import sincos
from grazing.kernel.primitives import behind, numbers
from grazing.maps.launch import fan
from grazing.oscillator.reset import Reset
from grazing.outcome import ESCAPED, FATAL, NO_IMPACT, TOO_MANY_IMPACTS
from grazing.parameter import parameter_tuple

#: Where a ball is thrown from for the picture of exits, and how fast at most, where that is not in the plunger.
THROWN = {"classic": (2.55, 5.6, 12.0), "galton": (0.05, 9.0, 3.0), "one_bumper": (0.3, 4.0, 3.0)}
#: What a millimetre is, on tables where that means something.
MILLIMETRE = {"classic": 0.01}
#: Of a ball that is followed: time, surface just left and state at the begin of its flight, then impacts, the object it
#: hit last, and bits of outcomes.
CLOCK, LEFT, X, Y, VX, VY, HITS, LAST, FLAGS, BALL = range(10)
#: Of a motion: when a piece begins, the angle there and the angular velocity.
MOTION = 3
#: Numbers of a row of parameters that laws of the page may have.
LONGEST = 3


def pressed(block: Any, flipper: int, motion: Any, count: int, t: float, goal: float, rate: float) -> int:
    """Turn a flipper towards an angle from t on, and return how many pieces its motion has then.

    What was to come after t is dropped; the first piece of a motion is where the flipper is since ever.
    """
    n = count
    while n > 1 and motion[n - 1, 0] >= t:
        n -= 1
    angle, there = switched(motion[n - 1, 0], motion[n - 1, 1], motion[n - 1, 2], t, goal, rate)
    if there > t:
        motion[n, 0], motion[n, 1], motion[n, 2] = t, angle, rate
        n += 1
    motion[n, 0], motion[n, 1], motion[n, 2] = max(there, t), goal, 0.0
    n += 1
    table = numbers(block)
    start = WIDTH * (int(table[FACES]) + int(table[CIRCLES]) + int(table[SIDES]))
    first = behind(rows_of(table), start)
    row = behind(first, FLIPPER_WIDTH * flipper)
    row[PIECES] = 1.0 * n
    for i in range(n):
        piece = behind(first, int(row[AT]) + PIECE_WIDTH * i)
        s, c = sincos(motion[i, 1])
        piece[0], piece[1], piece[2], piece[3] = motion[i, 0], c, s, motion[i, 2]
    return n


def placed(x: float, y: float, vx: float, vy: float, left: float, late: float, clock: float, table: Any) -> Any:
    """Return the state of a ball some time after the begin of its flight or slide, if that lasts as long."""
    surface = slid_on(left, clock, table)
    if surface >= 0 and left == surface + RIDES:
        return carried_to(surface, (x, y, vx, vy), late, clock, table)
    if surface >= 0:
        return slid(surface, x, y, vx, vy, late, clock, table)
    return flown(x, y, vx, vy, table[GRAVITY], late)


def place(block: Any, now: Any, until: float, state: Any) -> None:
    """Write the state at a time of a ball whose flight or slide under way is known."""
    found = placed(now[2], now[3], now[4], now[5], now[1], max(until - now[0], 0.0), now[0], numbers(block))
    for j in range(4):
        state[j] = found[j]


def follow(block: Any, balls: Any, until: float, most: int, places: Any) -> None:
    """Follow many balls to a time, each for at most so many flights and slides, and write their states there.

    A ball that has left, or met what ends it, keeps the state of its end. What doubles cannot decide is decided by the
    scalar routine, and noted in the ball's outcomes.
    """
    table = numbers(block)
    for i in range(balls.shape[0]):
        ball = balls[i]
        said, events = int(ball[FLAGS]), 0
        going = not said & (FATAL | ESCAPED)
        while going:
            (surface, owner, length, flags, left), before, after, _speeds = next_event(  # noqa: RUF059
                ball[X], ball[Y], ball[VX], ball[VY], ball[LEFT], ball[CLOCK], table
            )
            if flags & FATAL and not flags & NO_IMPACT:
                said |= flags
                break
            if not ball[CLOCK] + length <= until:
                break
            said |= flags
            ball[CLOCK] += length
            ball[LEFT] = left
            if owner >= 0:
                ball[LAST] = 1.0 * owner
            if flags & ESCAPED:
                ball[X], ball[Y], ball[VX], ball[VY] = before
                going = False
            else:
                ball[X], ball[Y], ball[VX], ball[VY] = after
                ball[HITS] += 1.0 if owner >= 0 else 0.0
                events += 1
                if events >= most:
                    said |= TOO_MANY_IMPACTS
                    going = False
        ball[FLAGS] = 1.0 * said
        late = max(until - ball[CLOCK], 0.0) if going and not said & FATAL else 0.0
        state = placed(ball[X], ball[Y], ball[VX], ball[VY], ball[LEFT], late, ball[CLOCK], table)
        for j in range(4):
            places[i, j] = state[j]


def law_entry(name: str, made: Callable[..., Reset]) -> Entry:
    """Return the entry that says where a law lies."""
    law = example(made)
    kind = parameter_tuple(tuple(law.params))
    arguments = Argument("v", "float64"), Argument("row", "float64", (LONGEST,), "its parameters")
    return Entry(
        f"law_{name}", law_at(law.law, kind), (), arguments, "float64", f"where the law {name} lies", addressed=True
    )


def example(made: Callable[..., Reset]) -> Reset:
    """Return a reset law with whatever parameters."""
    from inspect import signature

    return made(**dict.fromkeys(signature(made).parameters, 0.5))


def described_thing(one: Thing) -> dict[str, Any]:
    """Return an object as the page draws it, and the names of its law's parameters."""
    law = None if one.law is None else {"name": one.law.name, "params": list(one.law.params)}
    return {"name": one.name, "kind": one.kind, "shape": dict(one.shape), "law": law}


def described_table(name: str) -> dict[str, Any]:
    """Return a table that ships as the page gets it."""
    table: Table = read_table(name)
    block, names = table.blocks(table.row())[0].copy(), list(table.params)
    own = len(block) - 1 - len(names)
    things = block[rows_of_tables.HEAD :][: rows_of_tables.THING * len(table.objects)].reshape(-1, rows_of_tables.THING)
    things[:, [rows_of_tables.LAW, rows_of_tables.SLOPE, rows_of_tables.ROW]] = 0.0  # addresses, which are the page's
    shot = table.plunger
    assert shot is not None
    x, y = ([value for one in table.outlines() for value in one.points[:, axis].tolist()] for axis in (0, 1))
    return {
        "objects": [described_thing(one) for one in table.objects],
        "rho": table.rho,
        "box": [min(x), max(x), min(y), max(y)],
        "launch": [shot.x, shot.y, shot.angle],
        "speeds": [shot.slow, shot.fast],
        "from": list(THROWN.get(name, (shot.x, shot.y, shot.fast))),
        "mm": MILLIMETRE.get(name, 0.0),
        "block": block.tolist(),
        "params": names,
        "row": own,
        "values": list(table.params.values()),
    }


def described_tables() -> dict[str, Any]:
    """Return the tables that ship, and where in a block the numbers are that the page changes."""
    return {"layout": LAYOUT, "tables": {name: described_table(name) for name in shipped()}}


#: Numbers of a block by name, for the page.
LAYOUT = {
    name: getattr(rows_of_tables, name)
    for name in ("GRAVITY", "FACES", "CIRCLES", "SIDES", "THINGS", "FLIPPERS", "HEAD", "LAW", "ROW", "OPEN", "THING",
                 "PX", "PY", "SIZE", "OWNER", "WIDTH")
} | {
    **{name: getattr(rows_of_flippers, name) for name in ("PIECES", "AT", "FLIPPER_WIDTH", "PIECE_WIDTH")},
    "ON": ON,
}  # fmt: skip


def table_module() -> Module:
    """Return the module."""
    return Module(entries(), (), ("x", "y", "vx", "vy"), None)


def entries() -> list[Entry]:
    """Return the functions of the module."""
    block = Argument("block", "float64", ("numbers",), "a table, see `tables`; laws and rows by address")
    return [
        *(law_entry(name, made) for name, made in LAWS.items()),
        Entry(
            "record", record, ("numbers", "capacity"),
            (block, *arguments(f"""
                now: float64[6]  time, surface just left, state; moved on
                flights: float64[capacity, {COLUMNS}]  length, surface, object, v_minus, v_plus, outcome; \
                    states at its begin, its end, and after the impact there; slid on, and left
                until: float64  the time up to which
            """)),
            "int64",
            "follow the ball from impact to impact; returns how many rows were filled, negative if none follows",
        ),
        Entry(
            "place", place, ("numbers",),
            (block, *arguments("""
                now: float64[6]  as `record` left it
                until: float64  the time up to which
                state: float64[4]  of the ball at that time
            """)),
            meaning="where the ball is",
        ),
        Entry(
            "follow", follow, ("numbers", "many"),
            (block, *arguments(f"""
                balls: float64[many, {BALL}]  time, surface just left, state, impacts, object hit last, \
                    outcome; moved on
                until: float64  the time up to which
                most: int64  impacts of a ball at most
                places: float64[many, 4]  states at that time
            """)),
            meaning="follow many balls to a time",
        ),
        Entry(
            "pressed", pressed, ("numbers", "capacity"),
            (block, *arguments(f"""
                flipper: int64  which
                motion: float64[capacity, {MOTION}]  begin, angle and angular velocity of its pieces
                pieces: int64  how many it has
                t: float64  when its button is pressed or released
                goal: float64  the angle to which it turns then
                rate: float64  the angular velocity
            """)),
            "int64", "press or release the button of a flipper; returns how many pieces its motion has then",
        ),
        Entry(
            "fan", fan, ("numbers", "angles", "speeds"),
            (block, *arguments("""
                x: float64  where the ball is launched
                y: float64  where the ball is launched
                most: int64  impacts of a ball at most
                angle: float64[angles]  of the launches
                speed: float64[speeds]  of the launches
                ways: int64[angles, speeds]  the drain through which each ball leaves; behind all objects, away
                hits: int64[angles, speeds]  impacts before
                times: float64[angles, speeds]  when it leaves
                said: int64[angles, speeds]  outcomes, bits
            """)),
            meaning="launch balls at all of these angles and speeds",
        ),
        Entry(
            "gravity", gravity_of, (),
            arguments(f"""
                g: float64  acceleration
                tilt: float64  up to {pi / 2:.4f}
            """),
            "float64", "what pulls the ball down the table",
        ),
    ]  # fmt: skip
