"""The block between walls: no dip below either is missed, none invented, and all decisions are the scalar routine's."""

import numpy as np
import pytest

import grazing as gz
from grazing.maps.hits import Hits
from grazing.outcome import AMBIGUOUS, FATAL

Long = np.longdouble


def wave(omega, t0, t, cos, sin):
    """A Fourier series and its derivative, in 19 digits."""
    j = np.arange(1, len(cos) + 1, dtype=Long)[:, None]
    c, s, angle = Long(1) * np.array(cos)[:, None], Long(1) * np.array(sin)[:, None], j * Long(omega) * (t + Long(t0))
    return (c * np.cos(angle) + s * np.sin(angle)).sum(0), (j * omega * (s * np.cos(angle) - c * np.sin(angle))).sum(0)


class Flight:
    """The free flights and the walls of a model with k > 0, written down anew."""

    def __init__(self, m):
        self.m, f = m, m.forcing
        alpha, k = Long(m.alpha), Long(m.k)
        W = np.arange(1, len(f.cos) + 1) * Long(f.omega)
        a, b = k * k - W * W, alpha * W
        c, s = np.array(f.cos, Long), np.array(f.sin, Long)
        self.response = (a * c - b * s) / (a * a + b * b), (b * c + a * s) / (a * a + b * b)
        self.rest = Long(f.offset) / (k * k)
        self.q2 = alpha * alpha / 4 - k * k

    def steady(self, t):
        y, v = wave(self.m.forcing.omega, self.m.forcing.t0, t, *self.response)
        return y + self.rest, v

    def wall(self, j, t):
        one = self.m.walls[j]
        if one.motion is None:
            return Long(one.position) + 0 * t, 0 * t
        y, v = wave(one.motion.omega, one.motion.t0, t, one.motion.cos, one.motion.sin)
        return y + Long(one.position), v

    def flown(self, t0, u, v, t):
        """The state at times t of flights that are at (u, v) at times t0."""
        s, half = t - t0, Long(self.m.alpha) / 2
        q = np.sqrt(abs(self.q2))
        even, odd = (np.cosh, np.sinh) if self.q2 > 0 else (np.cos, np.sin)
        C, S = even(q * s), odd(q * s) / q if q > 0 else s
        (Y, V), (end, speed) = self.steady(t0), self.steady(t)
        h, w, e, k2 = u - Y, v - V, np.exp(-half * s), Long(self.m.k) ** 2
        return e * ((C + half * S) * h + S * w) + end, e * (-k2 * S * h + (C - half * S) * w) + speed


def grazing_starts(m, n, seed):
    """Return starts whose free flight turns 10^-4 to 10^-12 above or below a wall, and what is hit first in the period.

    As many of each kind on each wall; before that they are well away from all walls. Of the arrays ``start`` (2, n),
    ``wall`` and ``crosses`` say what was built, ``first`` is the index of the wall that is hit first, -1 for none.
    """
    F, random, T = Flight(m), np.random.default_rng(seed), m.period
    wanted = {(j, c): n // (2 * len(m.walls)) for j in range(len(m.walls)) for c in (False, True)}
    found = []
    for turn in range(100):
        j, count = turn % len(m.walls), 1500
        if not (wanted[j, False] or wanted[j, True]):
            continue
        when = Long(T) * random.uniform(0.05, 0.95, count)
        depth = 10.0 ** random.uniform(-12, -4, count) * random.choice((-1.0, 1.0), count)
        at, rate = F.wall(j, when)
        u, v = (np.array(x, float) for x in F.flown(when, at + m.walls[j].sign * depth, rate, 0 * when))
        first, near, clear = np.where(depth < 0, j, -1), np.full(count, -1), np.ones(count, bool)
        for part in np.linspace(0.0, 1.0, 150):
            t = Long(T * part) + 0 * when
            y = F.flown(0 * t, Long(1) * u, Long(1) * v, t)[0]
            for i, wall in enumerate(m.walls):
                height = np.array(wall.sign * (y - F.wall(i, t)[0]), float)
                away = np.array((t - when) / T, float)
                room = np.minimum(1e-3, 2e-2 * away**2) if i == j else 1e-3
                late, beside = (away > 2e-2) & (first == -1), (i == j) & (abs(away) <= 2e-2)
                clear &= (height > room) | beside | (away > 0)
                clear &= ~late | (near == -1) | (near == i) | (height > room)
                clear &= ~late | (near != i) | (height < room)  # it came near and went away again
                near = np.where(late & (height < room), i, near)
                first = np.where(late & (height < -1e-3), i, first)
        clear &= (first != -1) | (near == -1)
        h = Long(2e-2 * T)  # it turns: higher on both sides, a little away
        for t in (when - h, when + h):
            y = F.flown(0 * t, Long(1) * u, Long(1) * v, t)[0]
            clear &= np.array(m.walls[j].sign * (y - F.wall(j, t)[0]) > 2 * abs(depth), bool)
        for c in (False, True):
            some = np.flatnonzero(clear & ((depth < 0) == c))[: wanted[j, c]]
            wanted[j, c] -= len(some)
            found.append((np.stack([u, v])[:, some], np.full(len(some), j), np.full(len(some), c), first[some]))
    return tuple(np.concatenate([one[i] for one in found], axis=-1) for i in range(4))


LAW, WEAK = gz.active(r=0.8, V=0.4), gz.active(r=0.6, V=0.3)
#: All of no more than two have the same kernels: the block in strict arithmetic compiles ten seconds between walls.
ONE, TWO, THREE = (1.0, 0.0), (0.9, 0.3), (0.8, 0.0, 0.35)
#: Damping, stiffness, harmonics of the force, distance of the walls, motion of the first and of the second wall.
BUILT = {
    "over-damped": (3.0, 1.0, ONE, 0.35, None, None),
    "over-damped, moving": (3.0, 1.0, ONE, 0.42, (0.03,), (0.02,)),
    "under-damped": (0.5, 1.3, ONE, 1.0, None, None),
    "under-damped, moving": (0.5, 1.3, ONE, 1.0, None, (0.1,)),
    "critical, moving": (2.0, 1.0, ONE, 0.6, (0.05,), None),
    "critical, two harmonics": (2.0, 1.0, TWO, 0.6, (0.05, 0.02), None),
    "over-damped, three harmonics": (3.0, 1.0, THREE, 0.4, None, (0.01, 0.0, 0.01)),
    "under-damped, three harmonics": (0.4, 1.1, THREE, 1.1, None, None),
}


def model_of(alpha, k, cos, gap, low, high):
    def motion(waves):
        return None if waves is None else gz.Forcing(omega=2.2, t0=0.3, cos=waves, sin=tuple(0.5 * c for c in waves))

    force = gz.Forcing(omega=2.2, t0=0.1, offset=0.1, cos=cos)
    walls = gz.wall(-0.05, LAW, motion=motion(low)), gz.wall(gap - 0.05, WEAK, motion=motion(high))
    return gz.Oscillator(alpha, k, force, walls=walls)


def ways(P, row, lanes, n, names=("strict", "fast")):
    """Run by the block in some arithmetics, and by the scalar routine."""
    for arithmetic, algorithm in (*((name, "block") for name in names), ("strict", "scalar")):
        yield P.run_columns(row, lanes.copy(), 0, n, records=n, arithmetic=arithmetic, algorithm=algorithm, threads=1)


def wrong_decisions(name, n, seed):
    """Return how many dips are missed, how many invented, and how many of either were asked on each wall."""
    m = model_of(*BUILT[name])
    start, wall, crosses, first = grazing_starts(m, n, seed)
    P = gz.stroboscopic_map(m)
    missed = false = 0
    for found in ways(
        P, [list(P.params.values())], start[None], 1, ("strict", "fast") if m.harmonics == 2 else ("fast",)
    ):
        said = np.array(["0AB".index(P.letters.symbol(int(x)).strip("()")[0]) - 1 for x in found.letters[0, 0]])
        missed += (said != first)[crosses].sum()
        false += (said != first)[~crosses].sum()
        assert not (found.outcomes & (AMBIGUOUS | FATAL)).any()
    return missed, false, [int(((wall == j) & (crosses == c)).sum()) for j in (0, 1) for c in (True, False)]


@pytest.mark.parametrize("name", [name for name in BUILT if "harmonics" not in name])
def test_no_dip_is_missed_and_none_invented(name):
    missed, false, asked = wrong_decisions(name, 120, 1)
    assert (missed, false) == (0, 0) and asked == [30] * 4


@pytest.mark.long
@pytest.mark.parametrize("name", BUILT)
def test_of_ten_thousand_dips_and_clearances_none_is_taken_for_the_other(name):
    missed, false, asked = wrong_decisions(name, 1400, 2)
    assert (missed, false) == (0, 0) and asked == [350] * 4


def random_rows(P, n, seed):
    """Return parameters of models of every kind, in several units of length and time: the rows of one map."""
    random, names = np.random.default_rng(seed), list(P.params)
    rows = np.tile(np.array(list(P.params.values())), (n, 1))
    value = dict(zip(names, rows.T, strict=True))  # views
    T, size = 10.0 ** random.uniform(-2, 2, n), 10.0 ** random.uniform(-3, 3, n)
    kind = random.integers(5, size=n)
    k = np.where(kind == 0, 0.0, random.uniform(0.1, 4.0, n))
    value["omega"][:] = 2 * np.pi / T
    value["k"][:] = k / T * 2
    value["alpha"][:] = np.where(kind == 1, 2 * k, np.where(kind == 2, 0.0, random.uniform(0.0, 8.0, n))) / T * 2
    value["t0"][:], value["phase"][:] = random.uniform(0, 1, n) * T, random.uniform(0, 1, n) * T
    force = size / T**2 * 20
    for name in names:
        last = name.rpartition(".")[2]
        moves = "." in name and last.startswith(("cos", "sin"))
        if last.startswith(("cos", "sin")):
            value[name][:] = random.normal(size=n) * (0.05 * size * random.integers(2, size=n) if moves else force)
        elif last == "r":
            value[name][:] = random.uniform(0.2, 1.0, n)
        elif last == "V":
            value[name][:] = random.uniform(0.0, 1.0, n) * size / T * random.integers(2, size=n)
    value["offset"][:] = random.normal(size=n) * 0.5 * force
    low = "A.sigma" if "A.sigma" in names else "sigma"
    value[low][:] = -size * random.uniform(0.2, 1.0, n)
    if "B.sigma" in names:
        value["B.sigma"][:] = size * random.uniform(0.3, 1.0, n)
    return rows, random


MOVES = gz.Forcing(omega=2.2, cos=(0.1,), sin=(0.1,))
WALLS = {
    "two": (gz.wall(-1.0, LAW, motion=MOVES), gz.wall(1.0, LAW, motion=MOVES)),
    "one below": (gz.wall(-1.0, LAW, motion=MOVES),),
    "one above": (gz.wall(-1.0, LAW, motion=MOVES, side="above"),),
}


@pytest.mark.parametrize("models", [60, pytest.param(1500, marks=pytest.mark.long)])
@pytest.mark.parametrize("walls", WALLS)
def test_random_models_are_flown_as_by_the_scalar_routine(walls, models):
    force = gz.Forcing(omega=2.2, sin=(0.1, 0.0))
    P = gz.stroboscopic_map(gz.Oscillator(3.0, 1.0, force, walls=WALLS[walls]))
    rows, random = random_rows(P, models, 4)
    boxes = P.origin.boxes(rows)
    lanes = random.uniform(boxes[:, :, :1], boxes[:, :, 1:], (models, 2, 12))
    strict, fast, scalar = ways(P, rows, lanes, 3)
    assert not np.array_equal(strict.points, scalar.points)  # the block did have a say
    size = (
        np.abs(scalar.points).max(axis=(1, 3), initial=0.0)[:, None, :, None]
        + (boxes[:, :, 1:] - boxes[:, :, :1])[:, None]
    )
    # an impact of a speed magnifies what was wrong before
    slow = np.minimum(scalar.slowest / (boxes[:, 1, 1:] - boxes[:, 1, :1]), 1.0)[:, None, None]
    for block in (strict, fast):
        settled = ~(scalar.outcomes & AMBIGUOUS).astype(bool)
        assert np.array_equal(block.letters[settled], scalar.letters[settled])
        assert np.array_equal(block.outcomes[settled], scalar.outcomes[settled])
        off = np.nanmax(np.abs(block.points - scalar.points) / size * slow**2, axis=2)
        assert off[settled].max() <= 1e-12


def test_the_record_of_near_misses_and_slow_impacts_is_that_of_the_scalar_routine():
    m = model_of(*BUILT["over-damped, moving"])
    P = gz.stroboscopic_map(m)
    start, _wall, crosses, _first = grazing_starts(m, 60, 5)
    strict, fast, scalar = ways(P, [list(P.params.values())], start[None], 1)
    for block in (strict, fast):
        slow = scalar.slowest[0, crosses]
        assert (abs(block.slowest[0, crosses] - slow) <= 1e-12 * slow + 1e-15 / slow).all()
        clear = block.near_miss[0, ~crosses]
        assert (clear < 1e-3).all()
        np.testing.assert_allclose(clear, np.minimum(scalar.near_miss[0, ~crosses], clear), rtol=1e-3, atol=1e-12)


def test_a_wall_out_of_reach_leaves_the_block_its_decisions():
    force = gz.Forcing(omega=2.2, offset=0.1)
    one = gz.stroboscopic_map(gz.Oscillator(3.0, 1.0, force, LAW))
    two = gz.stroboscopic_map(gz.Oscillator(3.0, 1.0, force, walls=(gz.wall(0.0, LAW), gz.wall(50.0, WEAK))))
    lanes = np.random.default_rng(0).uniform((1e-3, -0.3), (0.1, 0.3), (1, 200, 2)).transpose(0, 2, 1)
    found = [next(ways(P, [list(P.params.values())], lanes, 20, ("fast",))) for P in (one, two)]
    np.testing.assert_allclose(found[0].points, found[1].points, atol=1e-13)
    hits = np.vectorize(lambda letter: two.letters.symbol(int(letter)).count("A"))(found[1].letters)
    assert np.array_equal(found[0].letters, hits)


@pytest.mark.parametrize("gap", [0.25, 0.42, 0.6])
def test_columns_that_repeat_themselves_have_the_bits_of_those_in_company_that_never_does(gap):
    m = gz.Oscillator(3.0, 1.0, gz.Forcing(omega=2.2, offset=0.1), walls=(gz.wall(0.0, LAW), gz.wall(gap, LAW)))
    P = gz.stroboscopic_map(m)
    rows = np.tile(np.array(list(P.params.values())), (6, 1))
    rows[:, list(P.params).index("offset")] = np.linspace(0.05, 0.16, 6)
    lanes = np.random.default_rng(2).uniform((1e-3, -0.3), (0.1, 0.3), (6, 40, 2)).transpose(0, 2, 1).copy()
    beside = np.concatenate([lanes, np.full((6, 2, 1), np.nan)], axis=2)
    one, two = (P.run_columns(rows, x.copy(), 250, 9, threads=1) for x in (lanes, beside))
    np.testing.assert_array_equal(one.points, two.points[..., :-1])
    np.testing.assert_array_equal(one.letters, two.letters[..., :-1])
    np.testing.assert_array_equal(one.near_miss, two.near_miss[..., :-1])


def test_bits_depend_neither_on_threads_nor_on_how_many_orbits_there_are():
    m = model_of(*BUILT["under-damped, moving"])
    P = gz.stroboscopic_map(m)
    box = np.array(P.box)
    lanes = np.random.default_rng(3).uniform(box[:, 0], box[:, 1], (3, 700, 2)).transpose(0, 2, 1).copy()
    rows = np.tile(np.array(list(P.params.values())), (3, 1))
    whole = P.run_columns(rows, lanes.copy(), 3, 20, threads=1)
    again = P.run_columns(rows, lanes.copy(), 3, 20, threads=2)
    for a, b in zip(whole, again, strict=True):
        np.testing.assert_array_equal(a, b)
    for q, part in ((0, slice(0, 1)), (1, slice(3, 40)), (2, slice(250, 270))):
        few = P.run_columns(rows[q : q + 1], lanes[q : q + 1, :, part].copy(), 3, 20, threads=1)
        np.testing.assert_array_equal(few.points, whole.points[q : q + 1, ..., part])
        np.testing.assert_array_equal(few.letters, whole.letters[q : q + 1, ..., part])


def test_impacts_are_spelt_in_their_order():
    """Of every length that a letter tells apart, and beyond, as the trajectory lists them."""
    law = gz.newton(1.0)
    m = gz.Oscillator(0.1, 0.3, gz.Forcing(omega=1.0, cos=(0.4,)), walls=(gz.wall(-0.5, law), gz.wall(0.5, law)))
    P = gz.stroboscopic_map(m)
    assert isinstance(P.letters, Hits)
    speeds = np.linspace(0.2, 5.0, 20)
    found = next(ways(P, [list(P.params.values())], np.stack([0 * speeds, speeds])[None], 1, ("fast",)))
    seen = set()
    for speed, letter in zip(speeds, found.letters[0, 0], strict=True):
        walls = "".join(gz.trajectory(m, (0.0, speed), until=m.period).impact_wall.values)
        said = P.letters.symbol(int(letter)).strip("()")
        assert said == (walls if len(walls) < 20 else "more")
        seen.add(len(walls))
    assert min(seen) <= 2 and max(seen) > 19


def test_walls_at_rest_where_the_forced_flight_passes_zero():
    """There positions are kept without the place of the wall; pairs of a ball without a spring must not lose it."""
    walls = gz.wall(0.8, LAW), gz.wall(2.0, WEAK)
    m = gz.Oscillator(0.5, 0.0, gz.Forcing(omega=1.0, cos=ONE), walls=walls)
    P = gz.stroboscopic_map(m)
    box = np.array(P.box)
    lanes = np.random.default_rng(6).uniform(box[:, 0], box[:, 1], (1, 100, 2)).transpose(0, 2, 1)
    strict, fast, scalar = ways(P, [list(P.params.values())], lanes, 2)
    for block in (strict, fast):
        assert np.array_equal(block.letters, scalar.letters)
        assert not np.array_equal(block.points, scalar.points)
        np.testing.assert_allclose(block.points, scalar.points, atol=1e-11)
