"""The block decides as ball arithmetic and the scalar routine do, and says how near every orbit came to another."""

import numpy as np
import pytest

import grazing as gz
from benchmarks.fixed import WRONG, Kind, fixed_set
from benchmarks.models import STANDARD
from benchmarks.ours import oscillator, rows_of
from grazing.maps.map import CHATTER_LETTER, STUCK_LETTER
from grazing.oscillator.constants import forcing
from grazing.oscillator.exact import exact_period
from grazing.oscillator.flight import anchored, flight, modes
from grazing.outcome import AMBIGUOUS, CHATTER, FATAL, STUCK
from tests.models import MODELS, PLAIN, model_of, packed
from tests.reference import PROBLEMS, advance, load_dips

ARITHMETICS = ("strict", "fast")
DIPS = load_dips()


def flown(P, rows, lanes, n, *, arithmetic="fast", algorithm="block", records=None, threads=1):
    return P.run_columns(
        rows, lanes.copy(), 0, n, records=records or n, arithmetic=arithmetic, algorithm=algorithm, threads=threads
    )  # fmt: skip


def letter_of(period):
    if period.outcome & CHATTER:
        return CHATTER_LETTER
    return STUCK_LETTER if period.lay else period.impacts


# ---- the stored near grazes


@pytest.mark.parametrize("threads", [1, 2])
@pytest.mark.parametrize(("algorithm", "arithmetic"), [("block", "fast"), ("block", "strict"), ("scalar", "strict")])
def test_no_dip_is_missed_and_none_invented(algorithm, arithmetic, threads):
    """4500 starts that dip below the wall, or clear it, by 1e-4 to 1e-12."""
    stored = fixed_set()
    start, after, depth = stored["stress_start"], stored["stress_after"], stored["depth"]
    P = gz.stroboscopic_map(oscillator(STANDARD))
    lanes = np.ascontiguousarray(start.reshape(2, len(stored["d"]), -1).transpose(1, 0, 2))
    found = flown(
        P, rows_of(P, "offset", stored["d"]), lanes, 1, arithmetic=arithmetic, algorithm=algorithm, threads=threads
    )  # fmt: skip
    off = np.abs(found.points[:, 0].transpose(1, 0, 2).reshape(after.shape) - after).max(axis=0)
    assert off.shape == (10, 9, len(Kind), 25)
    missed, invented = ((~(off[:, :, kind] <= WRONG)).sum() for kind in (Kind.DIP, Kind.CLEARANCE))
    assert (missed, invented) == (0, 0)
    assert not found.undecided.any()
    assert not found.outcomes.any()
    # an impact of speed w magnifies a rounding by 1/w; here w is about sqrt(depth)
    assert (off <= 1e-15 + 2e-16 / np.sqrt(depth)[:, None, None]).all()


@pytest.mark.parametrize("name", sorted({dip.problem for dip in DIPS}))
def test_stored_dips_at_every_damping_and_law(name):
    """The scalar routine is held to the same dips in test_stroboscopic.py."""
    dips = [dip for dip in DIPS if dip.problem == name]
    m = model_of(PROBLEMS[name])
    P = gz.stroboscopic_map(m)
    lanes = np.array([(dip.u, dip.v) for dip in dips]).T[None].copy()
    arithmetic = "strict" if m.harmonics > 1 else "fast"  # one kernel is enough for the others
    found = flown(P, [list(P.params.values())], lanes, 1, arithmetic=arithmetic)
    for i, dip in enumerate(dips):
        if dip.strobe.impacts is None:  # a chatter or a rest in this period
            assert found.letters[0, 0, i] < 0
        else:
            assert found.letters[0, 0, i] == dip.strobe.impacts
        scale = max(1.0, abs(dip.strobe.u), abs(dip.strobe.v)) * dip.strobe.factor
        error = np.abs(found.points[0, 0, :, i] - (dip.strobe.u, dip.strobe.v)).max()
        assert error <= 1e-13 * scale
    assert not found.undecided.any()


# ---- built grazes at every damping, in one table

#: Models with the built-in bumper, all in the columns of one table: names and parameter values.
TOGETHER = (
    "standard", "critical", "under-damped", "undamped, no stiffness", "near resonance", "soft", "stiff", "passive",
    "chatter", "stick",
)  # fmt: skip


def table_of(names, **changes):
    models = [PLAIN[name].replace(**changes) for name in names]
    P = gz.stroboscopic_map(models[0])
    return P, models, np.array([list(gz.stroboscopic_map(m).params.values()) for m in models])


def grazing_starts(m, n, seed, heights):
    """Return n states at the strobe whose free flight turns at a height above the wall of 10^-h, or as far below it."""
    random = np.random.default_rng(seed)
    c = packed(gz.stroboscopic_map(m))
    found = []
    for _ in range(100 * n):
        t = random.uniform(0.02, 0.98) * c.T
        height = 10.0 ** -random.uniform(*heights) * random.choice((-1.0, 1.0))
        E = np.array(modes(t, c)).reshape(2, 2)
        y, v = flight(t, anchored(0.0, 0.0, 0.0, c), c)
        if forcing(t, c)[0] <= 0.0 or abs(np.linalg.det(E)) < 1e-20:
            continue
        start = np.linalg.solve(E, np.array([height - y, -v]))
        if start[0] >= 0.0 and np.abs(start).max() < 100.0 * c.size:
            found.append((float(start[0] + m.sigma), float(start[1])))
        if len(found) == n:
            return np.array(found).T
    return np.array([[m.sigma + 0.1] * n, [0.1] * n])  # a wall that the force always presses on has no grazes


EACH = 16


def built(names=TOGETHER, heights=(2.0, 15.0), **changes):
    P, models, rows = table_of(names, **changes)
    lanes = np.stack([grazing_starts(m, EACH, seed, heights) for seed, m in enumerate(models)])
    return P, models, rows, lanes


def test_beside_built_grazes_as_ball_arithmetic_says():
    P, models, rows, lanes = built(t0=0.2)
    every = {way: flown(P, rows, lanes, 1, arithmetic=way) for way in ARITHMETICS}
    grazed = 0
    for q, m in enumerate(models):
        for i in range(EACH):
            truth = exact_period(m, tuple(lanes[q, :, i]))
            assert truth is not None
            grazed += truth.near < 1e-3 or truth.slow < 1e-3
            for found in every.values():
                assert found.letters[q, 0, i] == letter_of(truth)
                assert found.undecided[q, i] == 0
                assert not found.outcomes[q, 0, i] & AMBIGUOUS
    assert grazed > 4 * EACH  # the starts are what they are meant to be


def test_three_harmonics_beside_built_grazes():
    P, models, rows, lanes = built(("three harmonics",), heights=(2.0, 9.0))
    block, scalar = (flown(P, rows, lanes, 3, arithmetic="strict", algorithm=way) for way in ("block", "scalar"))
    assert not np.array_equal(block.points, scalar.points)  # the block did have a say
    assert np.array_equal(block.letters, scalar.letters)
    assert np.array_equal(block.outcomes, scalar.outcomes)
    for i in range(EACH):
        assert block.letters[0, 0, i] == letter_of(exact_period(models[0], tuple(lanes[0, :, i])))
    speeds = np.minimum(scalar.slowest, 1.0)
    assert (np.abs(block.points - scalar.points).max(axis=(1, 2)) * speeds <= 1e-13).all()


# ---- the block and the scalar routine, along every parameter

SWEEPS = {
    "alpha": (0.0, 0.2, 2.0, 2.0 + 1e-9, 6.0),
    "k": (0.0, 1e-8, 0.5, 1.5, 3.0),
    "omega": (0.7, 1.5, 2.9, 4.0, 8.0),
    "t0": (-3.0, 0.3, 1.0, 40.0, 1e6),
    "d": (-1.5, -0.2, 0.05, 0.3, 1.4),  # beyond 1 the force has one sign
    "cos1": (-1.0, 0.0, 0.3, 1.5, 4.0),
    "sin1": (-2.0, -0.3, 0.1, 0.6, 3.0),
    "sigma": (-0.7, -0.1, 0.05, 0.3, 2.0),
    "r": (0.0, 0.3, 0.7, 0.95, 1.0),
    "V": (0.0, 0.01, 0.1, 0.5, 2.0),
    "phase": (-1.0, 0.3, 1.4, 2.5, 2.8),
}
TOGETHER_CHANGED = ({"V": 0.0, "r": 0.3, "d": -0.2}, {"V": 0.0, "r": 0.0, "d": -0.2}, {"V": 0.0, "r": 0.9, "d": -0.1})


@pytest.mark.parametrize("arithmetic", ARITHMETICS)
@pytest.mark.parametrize("base", ["standard", "under-damped"])
def test_block_and_scalar_agree_along_every_parameter(base, arithmetic):
    """All in one table, 3 periods: the same decisions, and the same points to rounding."""
    P = gz.stroboscopic_map(MODELS[base])
    params = dict(P.params)
    changes = [{name: value} for name, values in SWEEPS.items() for value in values] + list(TOGETHER_CHANGED)
    rows = np.array([list({**params, **change}.values()) for change in changes])
    random = np.random.default_rng(4)
    wall = rows[:, [list(params).index("sigma")]]
    lanes = np.stack([wall + random.uniform(0.0, 0.3, (len(rows), 9)), random.uniform(-0.5, 0.5, (len(rows), 9))], 1)
    block, scalar = (flown(P, rows, lanes, 3, arithmetic=arithmetic, algorithm=way) for way in ("block", "scalar"))
    assert np.array_equal(block.letters, scalar.letters)
    assert np.array_equal(block.outcomes, scalar.outcomes)
    assert np.array_equal(block.undecided, scalar.undecided)
    off = np.abs(block.points - scalar.points).max(axis=(1, 2)) * np.minimum(scalar.slowest, 1.0)
    assert (off <= 1e-12 * (1.0 + np.abs(scalar.points).max(axis=(1, 2, 3))[:, None])).all()
    moved = (block.points != scalar.points).any(axis=(1, 2, 3))
    # every column goes through the block, unless each period rests on the wall or has more impacts than margins allow
    rests = ((scalar.outcomes & STUCK) != 0).all(axis=(1, 2))
    assert moved[~rests & (scalar.letters.min(axis=(1, 2)) < 6)].all()
    assert {CHATTER_LETTER, 0, 1, 2, 3} <= set(scalar.letters.ravel().tolist())


@pytest.mark.parametrize("arithmetic", ARITHMETICS)
def test_a_ball_at_rest_at_the_strobe_stays_at_rest(arithmetic):
    """Pressed on the wall at the strobe, for ever or until the force turns: its state is the wall, to the last bit."""
    P = gz.stroboscopic_map(gz.pinball())
    params = dict(P.params)
    random = np.random.default_rng(7)
    n = 60
    rows = np.tile(list(params.values()), (n, 1))
    drawn = {
        "alpha": random.choice([0.0, 0.2, 2.0, 3.0, 5.0], n), "k": random.choice([0.0, 0.5, 1.0, 3.0], n),
        "omega": random.uniform(1.0, 4.0, n), "d": random.uniform(-3.0, 0.0, n), "V": 0.0,
        "r": random.choice([0.0, 0.3, 0.6], n), "sigma": random.choice([0.0, 0.3, -0.7], n),
        "phase": random.uniform(0.0, 2.8, n),
    }  # fmt: skip
    for name, values in drawn.items():
        rows[:, list(params).index(name)] = values
    wall = rows[:, [list(params).index("sigma")]]
    lanes = np.stack([wall + random.uniform(0.0, 0.3, (n, 2)), random.uniform(-0.5, 0.5, (n, 2))], 1)
    block, scalar = (flown(P, rows, lanes, 8, arithmetic=arithmetic, algorithm=way) for way in ("block", "scalar"))
    rests = (scalar.points[:, :, 0] == wall[:, None]) & (scalar.points[:, :, 1] == 0.0)
    assert 0.1 < rests.mean() < 0.9
    assert (scalar.letters == STUCK_LETTER).any()
    assert not (block.outcomes & FATAL).any()
    assert np.array_equal(block.letters, scalar.letters)
    assert np.array_equal(block.outcomes, scalar.outcomes)
    assert (block.points[:, :, 0][rests] >= np.broadcast_to(wall[:, None], rests.shape)[rests]).all()


# ---- how near an orbit came to being another one


@pytest.mark.parametrize("arithmetic", ARITHMETICS)
def test_the_narrowest_miss(arithmetic):
    """The scalar routine measures each; the block those below a height that depends on the column, a bound for others.

    Both measure where y/phi is lowest, for one phi or another: there y differs from its least value in second order.
    """
    names = ("standard", "critical", "under-damped", "near resonance", "passive")
    P, models, rows, lanes = built(names, heights=(3.0, 12.0))
    block, scalar = (flown(P, rows, lanes, 1, arithmetic=arithmetic, algorithm=way) for way in ("block", "scalar"))
    measured = bounded = 0
    for q, m in enumerate(models):
        height = block.near_miss[q].max()
        assert height > 0.0
        for i in range(EACH):
            near = exact_period(m, tuple(lanes[q, :, i])).near
            allowed = 20.0 * near**2 + 1e-14 if near < 1.0 else 0.0
            assert scalar.near_miss[q, i] == near or abs(scalar.near_miss[q, i] - near) <= allowed
            if near < height:
                assert abs(block.near_miss[q, i] - near) <= allowed
                measured += 1
            else:
                assert block.near_miss[q, i] == height <= near
                bounded += 1
    assert measured > 10 and bounded > 10


def test_the_narrowest_miss_of_many_periods():
    P = gz.stroboscopic_map(MODELS["standard"])
    for start in ((0.1, 0.05), (0.3, -0.4), (0.02, 0.2)):
        for algorithm in ("block", "scalar"):
            lanes = np.array(start).reshape(1, 2, 1)
            found = flown(P, [list(P.params.values())], lanes, 30, algorithm=algorithm)
            states = [start, *found.points[0, :-1, :, 0].tolist()]
            near = min(exact_period(MODELS["standard"], tuple(state)).near for state in states)
            if algorithm == "scalar":
                assert found.near_miss[0, 0] == pytest.approx(near, rel=1e-6)
            else:
                assert 0.0 < found.near_miss[0, 0] <= near * (1.0 + 1e-6)


@pytest.mark.parametrize("name", ["standard d=0.09", "under-damped", "trigger", "three harmonics", "high obstacle"])
def test_the_slowest_impact(name):
    """Against the impacts of the reference, over eight periods, in the block and out of it."""
    problem = PROBLEMS[name]
    P = gz.stroboscopic_map(model_of(problem))
    starts = [(problem.sigma + u, v) for u, v in ((0.1, 0.05), (0.25, -0.4), (0.02, 0.3))]
    lanes = np.array(starts).T[None].copy()
    ways = [
        flown(P, [list(P.params.values())], lanes, 8, arithmetic="strict", algorithm=way) for way in ("block", "scalar")
    ]
    for i, (u, v) in enumerate(starts):
        strobes = advance(problem, u, v, 8)
        speeds = [-float(impact.v_minus) for strobe in strobes for impact in strobe.impacts]
        for found in ways:
            assert found.letters[0, :, i].tolist() == [len(strobe.impacts) for strobe in strobes]
            assert found.slowest[0, i] == pytest.approx(min(speeds, default=np.inf), rel=1e-9)


def test_without_impact_there_is_no_slowest():
    m = gz.pinball(d=1.4)
    P = gz.stroboscopic_map(m)
    for algorithm in ("block", "scalar"):
        found = flown(P, [list(P.params.values())], np.array([[[1.0], [0.0]]]), 5, algorithm=algorithm)
        assert not found.letters.any()
        assert np.isinf(found.slowest).all()


@pytest.mark.parametrize("arithmetic", ARITHMETICS)
def test_what_an_impact_leaves_of_a_fast_flight_has_its_digits(arithmetic):
    """The flight after it was that before it and a change: of 1e30 there was 1e13 left after a dead stop, certified."""
    P = gz.stroboscopic_map(gz.pinball(alpha=0.1, k=0.0, d=0.4, r=0.0, V=0.0))
    rows, lanes = [list(P.params.values())], np.array([[[0.24e30, 0.24e6, 0.24], [-0.11e30, -0.11e6, -0.11]]])
    block = flown(P, rows, lanes, 2, arithmetic=arithmetic)
    scalar = flown(P, rows, lanes, 2, arithmetic=arithmetic, algorithm="scalar")
    assert np.array_equal(block.letters, scalar.letters) and scalar.letters[0, 0].tolist() == [1, 1, 0]
    assert np.allclose(block.points, scalar.points, rtol=0.0, atol=1e-12)
