"""The pinball table in a browser's machine code: the same hits as Python, in the same order, to the last bit."""

from itertools import pairwise

import numpy as np
import pytest

import grazing as gz
from grazing.billiard.flown import AFTER, COLUMNS, FLAGS, NEXT, OWNER, PATH, SURFACE, TIME, flights_of
from grazing.billiard.objects import DRAIN, FLIPPER
from grazing.billiard.players import pieces_of
from grazing.config.tables import read_table
from grazing.explorer.table import BALL, HITS, MOTION, described_table, described_tables
from grazing.outcome import AMBIGUOUS, ESCAPED, FATAL

ROOM = 400  # pieces of a flipper


class Played:
    """A table in a module, as the page has it: the block that ships, addresses of its own, room for motions."""

    def __init__(self, machine, tables, name, **values):
        self.machine, self.layout, self.table = machine, tables["layout"], tables["tables"][name]
        put, table = self.layout, self.table
        n, self.flippers = len(table["block"]), [o for o in table["objects"] if o["kind"] == FLIPPER]
        width = put["PIECE_WIDTH"]
        self.block = np.concatenate([table["block"], np.zeros(ROOM * width * len(self.flippers))])
        base = (machine.exports["__heap_base"].value(machine.store) + 63) // 64 * 64
        at = table["row"]
        for name, value in values.items():
            self.block[at + table["params"].index(name)] = value
        for j, one in enumerate(table["objects"]):
            thing = put["HEAD"] + put["THING"] * j
            if one["law"]:
                first = table["params"].index(f"{one['name']}.{one['law']['params'][0]}")
                self.block[thing + put["LAW"]] = machine.exports[f"law_{one['law']['name']}"](machine.store)
                self.block[thing + put["ROW"]] = base + 8 * (at + first)
        surfaces = sum(int(self.block[put[key]]) for key in ("FACES", "CIRCLES", "SIDES"))
        rows = put["HEAD"] + put["THING"] * len(table["objects"]) + put["WIDTH"] * surfaces
        self.motions = []
        for i, one in enumerate(self.flippers):
            row = rows + put["FLIPPER_WIDTH"] * i
            old = rows + int(self.block[row + put["AT"]])
            new = n + ROOM * width * i
            self.block[new : new + width] = self.block[old : old + width]
            self.block[row + put["AT"]] = new - rows
            motion = np.zeros((ROOM, MOTION))
            motion[0, 1] = one["shape"]["rest"]
            self.motions.append([motion, 1])

    def press(self, i, t, down):
        shape, (motion, count) = self.flippers[i]["shape"], self.motions[i]
        way = 1.0 if shape["raised"] > shape["rest"] else -1.0
        goal, rate = (shape["raised"], way * shape["up"]) if down else (shape["rest"], -way * shape["down"])
        self.motions[i][1] = self.machine.call(
            "pressed", numbers=len(self.block), capacity=ROOM, block=self.block, flipper=i, motion=motion, pieces=count,
            t=t, goal=goal, rate=rate,
        )  # fmt: skip

    def record(self, now, until, capacity=4096):
        flights = np.zeros((capacity, COLUMNS))
        n = self.machine.call(
            "record",
            numbers=len(self.block),
            capacity=capacity,
            block=self.block,
            now=now,
            flights=flights,
            until=until,
        )
        return flights[: abs(n)]


@pytest.fixture(scope="module")
def tables():
    return described_tables()


@pytest.fixture
def machine(machines):
    return machines["table"]


def switch_times(seed, until):
    random = np.random.default_rng(seed)
    times = np.cumsum(random.uniform(0.02, 0.4, int(8 * until)))
    return times[times < until].tolist()


def test_a_thousand_hits_are_those_of_python(machine, tables):
    T = read_table("classic")
    hits, start = 0, 0
    while hits < 1000:
        start += 1
        state, until = (5.275, 0.7, 0.0, 15.0 + start % 7), 40.0
        times = {one: switch_times(100 * start + i, until) for i, one in enumerate(("left_flipper", "right_flipper"))}
        played = Played(machine, tables, "classic")
        live = sorted((t, i, j % 2 == 0) for i, one in enumerate(times.values()) for j, t in enumerate(one))
        now, found = np.array([0.0, -1.0, *state]), []
        for t, i, down in [*live, (until, -1, False)]:  # what is to come is not known yet, as at a table
            some = played.record(now, t)
            last = int(some[-1, FLAGS])
            ended = (
                last & (FATAL | ESCAPED | AMBIGUOUS) and now[0] + some[-1, TIME] <= t
            )  # Python decides doubts exactly
            found += [*some] if ended or i < 0 else [*some[:-1]]  # else the last one is in progress
            if ended or i < 0:
                break
            played.press(i, t, down)
        truth = flights_of(gz.table(T.objects, T.rho, T.g, T.tilt, gz.presses(**times)), state, 0.0, until)
        found = np.array(found)
        n = len(found) - 1
        assert n + 1 == len(truth) or int(found[-1, FLAGS]) & AMBIGUOUS
        np.testing.assert_array_equal(found[:n, [SURFACE, OWNER]], truth[:n, [SURFACE, OWNER]])
        np.testing.assert_array_equal(
            found[:n, [TIME, AFTER, *range(NEXT, PATH + 1)]], truth[:n, [TIME, AFTER, *range(NEXT, PATH + 1)]]
        )
        hits += n
    assert start < 400


@pytest.mark.parametrize("rest", [-0.5, 3.6])
def test_a_motion_is_that_of_python_piece_by_piece(machine, tables, rest):
    played = Played(machine, tables, "classic")
    i = [one["shape"]["rest"] for one in played.flippers].index(
        min((o["shape"]["rest"] for o in played.flippers), key=lambda a: abs(a - rest))
    )
    times = switch_times(3, 30.0)
    for j, t in enumerate(times):
        played.press(i, t, j % 2 == 0)
    motion, count = played.motions[i]
    pieces = pieces_of(played.flippers[i]["shape"], times)
    np.testing.assert_array_equal(motion[:count], np.array(pieces))


def test_ghosts_are_where_their_own_flights_are(machine, tables):
    played, many = Played(machine, tables, "classic"), 20
    balls = np.zeros((many, BALL))
    balls[:, 1] = -1.0
    balls[:, 2:6] = [(5.275, 0.7, 0.0, 17.0 + 1e-3 * i) for i in range(many)]
    starts, places = balls[:, 2:6].copy(), np.empty((many, 4))
    for t in (0.3, 1.1, 2.0, 9.0):
        played.machine.call(
            "follow", numbers=len(played.block), many=many, block=played.block, balls=balls, until=t, most=10_000,
            places=places,
        )  # fmt: skip
        for i in range(many):
            flown = flights_of(read_table("classic"), tuple(starts[i]), 0.0, t)
            if (flown[:, FLAGS].astype(int) & (AMBIGUOUS | ESCAPED | FATAL)).any():
                continue
            assert balls[i, HITS] == len(flown) - 1
            seen = gz.trajectory(read_table("classic"), starts[i], until=t)
            np.testing.assert_allclose(
                places[i], [seen[k].values[-1] for k in ("x", "y", "vx", "vy")], rtol=0, atol=1e-12
            )


def test_exits_are_those_of_python(machine, tables):
    played = Played(machine, tables, "classic")
    T = read_table("classic")
    angle, speed = np.linspace(1.2, 1.9, 12), np.linspace(8.0, 22.0, 11)
    shape = len(angle), len(speed)
    ways, hits, outcomes = (np.empty(shape, np.int64) for _ in range(3))
    times = np.empty(shape)
    played.machine.call(
        "fan", numbers=len(played.block), angles=shape[0], speeds=shape[1], block=played.block, x=5.275, y=0.7,
        most=500, angle=angle, speed=speed, ways=ways, hits=hits, times=times, said=outcomes,
    )  # fmt: skip
    truth = gz.launches(T, (5.275, 0.7), angle, speed, hits=500)
    sure = (outcomes & AMBIGUOUS) == 0
    names = np.array([*T.names, "away", ""])
    assert sure.mean() > 0.9
    assert (names[ways][sure] == truth.exit.values[sure]).all()
    np.testing.assert_array_equal(times[sure], truth.time.values[sure])


def test_a_kick_is_changed_in_the_row(machine, tables):
    changed = {f"bumper{i}.V": 3.0 for i in (1, 2, 3)}
    played = Played(machine, tables, "classic", **changed)
    state = (5.275, 0.7, 0.0, 18.0)
    found = played.record(np.array([0.0, -1.0, *state]), 5.0)
    truth = flights_of(read_table("classic").replace(**changed), state, 0.0, 5.0)
    n = min(len(found), len(truth))
    assert n > 5
    np.testing.assert_array_equal(found[:n, NEXT:PATH], truth[:n, NEXT:PATH])


def test_tables_are_described_without_addresses_of_a_process():
    one, two = described_table("classic"), described_table("classic")
    assert one == two
    assert [o["kind"] for o in one["objects"]].count(DRAIN) == 3
    assert all(a < b for a, b in pairwise([0, one["row"], len(one["block"])]))
