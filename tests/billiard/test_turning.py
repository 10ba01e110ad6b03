"""First contacts with flippers that turn: grazes that are built, a dense search, ball arithmetic, closed forms."""

from math import cos, pi, sin

import numpy as np
import pytest
from scipy.optimize import brentq

import grazing as gz
from grazing.billiard import check, turning
from grazing.billiard.exact import exact_contact
from grazing.billiard.flippers import AT_TIP, LONG, row_of
from grazing.billiard.flown import FIRST, FLAGS, LAST, NEXT, OWNER, SURFACE, TIME, flights_of
from grazing.billiard.turning import at_surface, clear_of, foot_at, look
from grazing.outcome import AMBIGUOUS, ESCAPED, INSIDE_WALL
from tests.billiard.flippers import KINDS, grazing, least_gap, pair
from tests.billiard.tables import ELASTIC
from tests.billiard.test_march import contact

FLIPS = gz.flips(0.9, 0.4, {"L": 0.0, "R": 0.3})


def count_grazes(count, seed):
    """Return how many built grazes were missed, seen where none was, left undecided, and decided in balls."""
    random, missed, false, left, exactly = np.random.default_rng(seed), 0, 0, 0, 0
    for i in range(count):
        depth = 10.0 ** -random.uniform(3.0, 13.0) * (1.0 if i % 2 else -1.0)
        table, state, t = grazing(KINDS[i % len(KINDS)], depth, random)
        truth = least_gap(table, state, t)
        assert abs(truth + depth) < 1e-14 + 1e-3 * abs(depth), (KINDS[i % len(KINDS)], depth, truth)
        surface, at, flags = contact(table, state)
        if flags & AMBIGUOUS:
            exactly += 1
            surface, at, flags = exact_contact(table.blocks(table.row())[0], state, -1)
            left += bool(flags & AMBIGUOUS)
        if surface >= 0 and at < t - 0.1:  # it meets the flipper before, which the builder did not see
            x, y = state[0] + state[2] * at, state[1] + state[3] * at - 0.5 * table.gravity * at * at
            assert abs(table.distances(x, y, at)["A"] - table.rho) < 1e-12
            continue
        hit = surface >= 0 and at < t + 0.1
        missed += truth < 0.0 and not hit
        false += truth > 0.0 and hit
    return missed, false, left, exactly


def test_no_built_graze_of_a_flipper_is_missed_and_none_is_seen_that_is_not():
    missed, false, left, exactly = count_grazes(200, 0)
    assert (missed, false, left) == (0, 0, 0)
    assert exactly < 40  # most are decided in doubles


@pytest.mark.parametrize(("omega", "most"), [(0.0, 1), (5.0, 4), (-14.0, 5)])
def test_a_landing_takes_few_looks(monkeypatch, omega, most, count=40):
    """Its root is that of a search without derivatives; it ends where a gap is within its rounding."""
    random, reach, landed = np.random.default_rng(9), 0.04, 0
    row = row_of({"x": 0.0, "y": 0.0, "length": 1.0, "hub": 0.2, "tip": 0.1}, 0.1, 0.0, 0.0, 0.0)
    looks = []
    monkeypatch.setattr(turning, "look", lambda *args: looks.append(args) or look(*args))
    while landed < count:
        x, y, vx, vy = random.uniform((0.1, 0.31, -1.0, -4.0), (0.9, 0.4, 1.0, -2.0))
        how = (x, y, vx, vy, 1.0, x, y), 0, row, 0.0, (0.0, 1.0, 0.0, omega)

        def gap(t, how=how):
            return look(t, *how)[0]

        if not (gap(0.0)[0] > 0.0 > gap(reach)[0] and max(gap(t)[1] for t in np.linspace(0.0, reach, 40)) < 0.0):
            continue
        looks.clear()
        t = turning.landing(*gap(0.0), 1.0, 0.0, reach, *how)
        assert len(looks) <= most
        assert abs(t - brentq(lambda t, gap=gap: gap(t)[0], 0.0, reach, xtol=1e-17, rtol=1e-15)) < 1e-15
        landed += 1


@pytest.mark.long
def test_no_graze_of_a_flipper_of_twenty_thousand_is_missed():
    missed, false, left, _exactly = count_grazes(20_000, 1)
    assert (missed, false, left) == (0, 0, 0)


def test_a_surface_of_a_flipper_that_is_clear_is_not_touched(count=250):
    """Against places along the flight: it crosses no side between its ends, and stays out of the tip."""
    random, clear = np.random.default_rng(6), np.zeros(3, int)
    for start, end, how in some_flights(random, count):
        sure, _side = clear_of(start, end, how[0], *how[1:])
        for kind in np.flatnonzero(sure):
            clear[kind] += 1
            assert is_clear(kind, np.linspace(start, end, 60), how)
    assert (clear > 0.2 * count).all() and (clear < 0.8 * count).all()


def test_a_ball_before_the_line_of_a_side_touches_nothing_else_of_a_flipper(count=250):
    random, apart, hits = np.random.default_rng(7), 0, 0
    for start, end, how in some_flights(random, count):
        _sure, first = clear_of(start, end, how[0], *how[1:])
        t, _late, _flags, alone = at_surface(how[0], first, *how[1:], start, False, end)
        if not alone:
            continue
        apart, hits, times = apart + 1, hits + (t < end), np.linspace(start, min(t, end), 60)[:-1]
        assert min(look(t, how[0], first, *how[1:])[0][0] for t in times) > 0.0
        assert all(is_clear(kind, times, how) for kind in range(3) if kind != first)
    assert apart > 0.4 * count and hits > 0.02 * count


def some_flights(random, count):
    """Yield begin, end and (flight, row, begin of the piece, piece) of flights around a flipper."""
    for _ in range(count):
        hub, tip = random.uniform(0.05, 0.4, 2)
        row = row_of({"x": 0.0, "y": 0.0, "length": 1.0, "hub": hub, "tip": tip}, 0.1, 0.0, 0.0, 0.0)
        turn, start, end = random.uniform(0.0, 2.0 * pi), 0.05, 0.05 + random.choice([0.01, 0.05, 0.2, 0.5])
        piece = -0.01, cos(turn), sin(turn), random.choice([0.0, -14.0, 5.0])
        dx, dy, vx, vy = random.normal(size=4) * random.choice([0.5, 1.0, 3.0])
        g = float(random.choice([0.0, 1.0, 60.0]))
        if g > 1.0:  # it rises and falls meanwhile
            vy = 0.5 * g * (start + end)
        yield start, end, ((dx, dy - vy * start, vx, vy, g, dx, dy - vy * start), row, piece[0], piece)


def is_clear(kind, times, how):
    """Say whether a ball is never in the tip, or crosses no side between its ends, from one time to the next."""
    h = np.array([look(t, how[0], kind, *how[1:])[0][0] for t in times])
    if kind == AT_TIP:
        return h.min() > 0.0
    foot = np.array([foot_at(t, how[0], kind, *how[1:])[0] for t in times])
    on = (foot >= 0.0) & (foot <= how[1][LONG])
    return not (on[1:] & on[:-1] & (h[1:] * h[:-1] <= 0.0)).any()


@pytest.mark.parametrize("rho", [0.05, 0.15])
def test_every_flight_among_flippers_is_that_of_balls_and_of_a_dense_search(rho):
    table, random, flippers = pair(FLIPS, rho), np.random.default_rng(1), 0
    block = table.blocks(table.row())[0]
    for _ in range(16):
        place, start = random.uniform((0.5, 3.0), (5.5, 5.0)), random.uniform(-3.0, 5.0)
        left, clock = -1, start
        for flight in flights_of(table, (*place, *random.uniform(-3.0, 3.0, 2)), start, start + 20.0):
            state, flags = tuple(flight[FIRST:LAST].tolist()), int(flight[FLAGS])
            surface, t, _flags = exact_contact(block, state, left, clock)
            assert surface == int(flight[SURFACE]) and not flags & AMBIGUOUS
            assert abs(t - flight[TIME]) <= 1e-12 * (1.0 + t)
            for s in np.linspace(0.0, flight[TIME], 30):
                x, y = state[0] + state[2] * s, state[1] + (state[3] - 0.5 * table.gravity * s) * s
                now = table.distances(x, y, clock + s)
                assert min(room for name, room in now.items() if name != "out") > rho - 1e-12
            if flight[OWNER] < 2:
                flippers += 1
                name = table.names[int(flight[OWNER])]
                assert abs(table.distances(*flight[NEXT : NEXT + 2], clock + t)[name] - rho) < 1e-12
            left, clock = surface, clock + flight[TIME]
    assert flippers > 20


def test_a_flipper_at_rest_is_a_segment_seen_by_a_larger_ball():
    random, hits = np.random.default_rng(4), set()
    flipper = gz.flipper("A", (0.3, 0.2), 1.5, 0.25, 0.4, 1.2, ELASTIC, up=9.0, down=9.0)
    table = gz.table([flipper], 0.1, tilt=0.3)
    tip = 0.3 + 1.5 * cos(0.4), 0.2 + 1.5 * sin(0.4)
    other = gz.table([gz.segment("A", (0.3, 0.2), tip, ELASTIC)], 0.35, tilt=0.3)
    for _ in range(200):
        state = *random.uniform(-2.0, 3.0, 2), *random.uniform(-2.0, 2.0, 2)
        if table.overlap(*state[:2])[0] > 0.0:
            continue
        surface, t, flags = contact(table, state)
        known, s, _flags = contact(other, state)
        assert (surface < 0) == (known < 0) and not flags & AMBIGUOUS
        if surface >= 0:
            hits.add(surface)
            assert abs(t - s) < 1e-12 * (1.0 + t)
    assert hits == {0, 1, 2, 3}  # the hub, both sides, the tip


@pytest.mark.parametrize("rise", [1.0, -1.0])
def test_a_ball_at_rest_is_hit_by_a_side_that_turns(rise):
    """On a level table: the side comes to the ball when it has turned by the angle between them."""
    flipper = gz.flipper("A", (0.0, 0.0), 2.0, 0.2, 0.0, rise * 1.0, gz.newton(0.6), up=4.0, down=1.0)
    table, (x, y) = gz.table([flipper], 0.1, player=gz.presses(A=[0.25])), (1.2, rise * 0.8)
    flight, *_rest = flights_of(table, (x, y, 1e-30, 0.0), 0.0, 9.0)
    far = np.hypot(x, y)
    turn = np.arctan2(0.8, 1.2) - np.arcsin(0.3 / far)  # the line at distance 0.3 beside the axis
    assert flight[TIME] == pytest.approx(0.25 + turn / 4.0, rel=1e-14)
    along = np.sqrt(far**2 - 0.3**2)
    normal = np.array([-sin(turn), rise * cos(turn)])
    assert flight[NEXT + 2 : NEXT + 4] == pytest.approx(1.6 * 4.0 * along * normal, rel=1e-13)


def test_a_ball_at_rest_is_hit_by_the_tip():
    flipper = gz.flipper("A", (0.0, 0.0), 2.0, 0.2, 0.0, 2.0, gz.newton(1.0), up=4.0, down=1.0)
    table, (x, y) = gz.table([flipper], 0.1, player=gz.presses(A=[0.0])), (0.0, 2.2)
    flight, *_rest = flights_of(table, (x, y, 0.0, 1e-30), 0.0, 9.0)
    angle = np.arcsin((2.0**2 + 2.2**2 - 0.3**2) / (2 * 2.0 * 2.2))  # the tip is at distance 0.3 from the ball
    assert flight[TIME] == pytest.approx(angle / 4.0, rel=1e-13)
    n = (np.array([x, y]) - 2.0 * np.array([cos(angle), sin(angle)])) / 0.3
    spun = 4.0 * 2.0 * np.array([-sin(angle), cos(angle)])
    assert flight[NEXT + 2 : NEXT + 4] == pytest.approx(2.0 * (spun @ n) * n, rel=1e-11)


def test_a_ball_inside_a_flipper_ends_by_name():
    table = gz.table([gz.flipper("A", (0, 0), 2.0, 0.2, 0.0, 1.0, ELASTIC, up=4.0, down=1.0)], 0.1)
    for x, y in ((1.0, 0.1), (2.1, 0.1), (0.0, 0.25)):
        assert contact(table, (x, y, 1.0, 0.3))[2] & INSIDE_WALL
        with pytest.raises(gz.InputError, match="overlaps A by"):
            gz.trajectory(table, (x, y, 1.0, 0.0), until=1.0)
    assert not contact(table, (1.0, 0.4, 1.0, 0.3))[2] & INSIDE_WALL


def test_motions_are_the_same_by_any_clock():
    """Flips of a period, and the same switches one by one."""
    flips = gz.flips(0.9, 0.4, 0.2)
    switches = [s for n in range(30) for s in (0.2 + 0.9 * n, 0.6 + 0.9 * n)]
    one, other = pair(flips), pair(gz.presses(L=switches, R=switches))
    for t in np.linspace(0.0, 20.0, 333):
        assert one.angles(t) == pytest.approx(other.angles(t), abs=1e-12)
    state = (2.5, 5.0, 0.3, 0.0)
    a, b = (gz.trajectory(table, state, until=8.0) for table in (one, other))
    assert a.impact_wall.values.tolist() == b.impact_wall.values.tolist() and "L" in a.impact_wall.values
    assert a.impact_time.values == pytest.approx(b.impact_time.values, abs=1e-9)


def test_a_table_with_flippers_keeps_the_laws_of_tables(monkeypatch):
    gz.testing.check_table(pair(FLIPS), states=6)
    found = check.flights_of

    def planted(*args):
        flights = found(*args)
        hit = np.flatnonzero(flights[:, OWNER] == 0.0)
        flights[hit, NEXT + 2] += 1e-3
        return flights

    monkeypatch.setattr(check, "flights_of", planted)
    with pytest.raises(AssertionError, match="changes the velocity by"):
        gz.testing.check_table(pair(FLIPS), states=20)


def test_a_flight_of_a_million_strokes_ends_by_name():
    """A ball that hangs over a flipper which twitches: many strokes are followed, too many are named."""
    flipper = gz.flipper("A", (0.0, 0.0), 2.0, 0.2, 0.0, 0.8, ELASTIC, up=4.0, down=4.0)
    table = gz.table([flipper], 0.1, player=gz.flips(1e-3, 1e-4))
    state = 1.5, 0.35, 0.0, -1e-3
    flown = gz.trajectory(table, state, until=100.0)  # 50000 strokes until it is there
    assert flown.outcome == "escaped" and 49.0 < flown.impact_time.values[0] < 50.0
    flown = gz.trajectory(table, (1.5, 0.35, 0.0, -1e-9), until=1e9)
    assert flown.outcome == "followed for too long" and flown.trust.item() == "certified" and not flown.impact_time.size


@pytest.mark.parametrize(("length", "time"), [(2.0**40, 1.0), (2.0**-40, 2.0**20), (1.0, 2.0**-30)])
def test_units_do_not_matter(length, time):
    table, params = pair(FLIPS), dict(pair(FLIPS).params)
    units = [
        (("x", "y", "x1", "y1", "x2", "y2", "radius", "length", "hub", "tip", "rho"), length),
        (("up", "down"), 1.0 / time),
        (("period", "hold", "phase"), time), (("V",), length / time), (("g",), length / time**2),
    ]  # fmt: skip
    scales = {name: unit for names, unit in units for name in names}
    other = table.at({name: value * scales.get(name.split(".")[-1], 1.0) for name, value in params.items()})
    angle, speed = np.linspace(0.2, 3.0, 12), np.linspace(1.0, 5.0, 10)
    one = gz.launches(table, (3.0, 4.0), angle, speed)
    two = gz.launches(other, (3.0 * length, 4.0 * length), angle, speed * length / time)
    np.testing.assert_array_equal(one.hits, two.hits)
    np.testing.assert_array_equal(one.time * time, two.time)


@pytest.mark.parametrize("way", [1, -1])
def test_along_the_underside_over_the_tip_or_from_it_it_leaves_at_once(way):
    """Without a bounce it has no speed along the normal but rounding, which put it behind the tip: it hung there."""
    for rest in np.linspace(2.1, 3.9, 13).tolist():
        one = gz.flipper("F", (0, 0), 2.0, (0.2, 0.1), rest, rest - 1.0, gz.newton(0.0), up=2.0, down=1.0)
        floor = gz.segment("floor", (-20, -4), (20, -4), gz.newton(0.7))
        P = gz.collision_map(gz.table([one, floor], 0.1, tilt=0.5 * np.pi), on="F")
        for place in (P.box[0][0], P.box[0][0] + 0.7):
            state = place, way * 0.5 * np.pi, 2.0
            new, letter = P(state)
            assert P.letters.symbol(letter) == "(floor)" or abs(new[0] - place) > 0.1
            assert np.isfinite(P.jacobian(state)).all() == (new[2] > 0.0)


@pytest.mark.parametrize("start", [0.0, 100.0])
def test_a_ball_that_a_flipper_presses_against_a_wall_stays_before_it(start):
    """Late times are coarse, and put it behind an arc by more than a gap is good to."""
    laws, random = [gz.newton(0.2), gz.newton(0.5), gz.active(r=0.5, V=0.3)], np.random.default_rng(1)
    for law in laws:
        flipper = gz.flipper("L", (1.0, 1.0), 2.0, 0.2, -0.2, 0.5, gz.newton(0.5), up=9.0, down=4.0)
        corners = ((0.0, 12.0), (4.0, 12.0), (4.0, 0.0))
        walls = [gz.segment("left", (0.0, 0.0), corners[0], law), gz.segment("top", *corners[:2], law)]
        walls += [gz.segment("right", *corners[1:], law), gz.arc("bowl", (2.0, 2.2), 2.2, pi, 2.0 * pi, law)]
        table = gz.table([flipper, *walls], rho=0.1, tilt=0.4, player=gz.flips(2.3, 0.5, 0.2))
        for state in random.uniform((0.5, 2.3, -1.0, -2.0), (3.5, 4.0, 1.0, 2.0), (12, 4)):
            flights = flights_of(table, tuple(state), start, start + 23.0, 5000)
            assert not int(flights[-1, FLAGS]) & (ESCAPED | INSIDE_WALL)
