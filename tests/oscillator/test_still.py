"""Columns that repeat themselves: which they are, when they are flown, and that nobody can tell from the results."""

import numpy as np
import pytest

import grazing as gz
from grazing.kernel.compile import compiled
from grazing.kernel.primitives import numbers
from grazing.oscillator.block import hand_back
from grazing.oscillator.cells import (
    CYCLE,
    HOLDING,
    K2,
    LOOKED_AT,
    ONWARD,
    POINTS,
    STATE,
    TABLED,
    WAKE,
    fill_table,
    table_size,
)  # fmt: skip
from grazing.oscillator.certificate import candidates, certify, count_hits, onward
from grazing.oscillator.still import SELDOM, UNSEEN, find_cycles, remember, stand_still
from grazing.oscillator.workspace import AWAKE, RUNS, WHOSE, WIDTH, W, workspace_size
from tests.models import MODELS, packed

STRIDE, STARTS = 8, 5


def tables(*names):
    """Return the tables of models, one behind the other: of columns without states, of which no cycle is known."""
    room = max(table_size(MODELS[name].harmonics) for name in names)
    rows = np.zeros((len(names), room))
    for name, t in zip(names, rows, strict=True):
        assert fill_table(t, np.zeros(9 * POINTS), packed(gz.stroboscopic_map(MODELS[name])), 1.0)
        t[TABLED], t[HOLDING], t[LOOKED_AT], t[CYCLE], t[WAKE] = 1.0, 0.0, 0.0, 0.0, 0.0
    return rows


def all_awake(columns):
    """Return lists of columns in which all are flown."""
    runs = np.zeros(3 * WIDTH, np.int64)
    runs[AWAKE : AWAKE + columns] = np.arange(columns)
    return runs


def looks(w, t, room, runs, awake, moved, length):
    """Remember the pairs, move them, and look whether they have come back."""
    remember(numbers(w), numbers(t), room, numbers(runs), awake, STRIDE)
    for i in range(moved.shape[1]):
        w[W.C1 + i] += moved[0, i]
        w[W.C2 + i] += moved[1, i]
    return find_cycles(numbers(w), numbers(t), room, numbers(runs), awake, STRIDE, STARTS, length)


FORMS = [looks, compiled(looks), compiled(looks, "fast")]


def pairs_of(columns, free=-1.0):
    """Return a workspace with pairs, all of which fly free or none."""
    w = np.zeros(workspace_size(3))
    count = columns * STRIDE
    w[W.C1 : W.C1 + count], w[W.C2 : W.C2 + count] = np.random.default_rng(3).normal(size=(2, count))
    w[W.FREE : W.FREE + count] = free
    return w


@pytest.mark.parametrize("length", [1, 2])
@pytest.mark.parametrize("form", FORMS)
def test_a_column_repeats_itself_if_every_orbit_came_back_to_the_bit(form, length):
    t = tables("standard", "under-damped", "standard", "critical", "standard", "standard", "standard")
    w, moved = pairs_of(7), np.zeros((2, 7 * STRIDE))
    w[W.C2 + 1 * STRIDE + 4], moved[1, 1 * STRIDE + 4] = 1.0, 3e-16  # the last orbit of column 1
    moved[:, 2 * STRIDE + STARTS : 3 * STRIDE] = 1.0  # behind the orbits of column 2
    w[W.C1 + 3 * STRIDE] = np.nan
    t[4, HOLDING], t[5, CYCLE] = 1.0, 9.0
    runs = all_awake(6)  # column 6 is not flown
    assert form(w, t.ravel(), t.shape[1], runs, 6, moved, length) == 2
    assert t[:, CYCLE].tolist() == [length, 0.0, length, 0.0, 0.0, 9.0, 0.0]
    t[4, HOLDING] = 0.0  # nor if the scalar routine flew a part of the cycle
    assert find_cycles(numbers(w), numbers(t), t.shape[1], runs, 6, STRIDE, STARTS, length) == 0
    t[:, CYCLE] = 0.0
    assert form(w, t.ravel(), t.shape[1], runs, 6, 0.0 * moved, length) == 5


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("name", ["standard", "critical", "under-damped", "two harmonics"])
def test_a_pair_that_flies_free_has_come_back_once_no_state_shows_it(form, name):
    """It is as good as zero then, now and later, while one that hits must come back to the bit."""
    t = tables(name)
    (u, u1, u2), (v, v1, v2), k2 = t[0, STATE : STATE + 3], t[0, STATE + 3 : STATE + 6], t[0, K2]
    x, y = np.random.default_rng(5).normal(size=(2, STRIDE))
    energies = k2 * (u1 * x + u2 * y) ** 2 + (v1 * x + v2 * y) ** 2
    size = UNSEEN * np.sqrt(min(k2 * u * u, v * v) / energies[:STARTS].max())
    for times, free, found in ((0.999, 1.0, 1), (0.999, -1.0, 0), (1.001, 1.0, 0)):
        w, moved = pairs_of(1, free), np.full((2, STRIDE), 1e-9 * size)
        w[W.C1 : W.C1 + STRIDE], w[W.C2 : W.C2 + STRIDE] = times * size * x, times * size * y
        t[0, CYCLE] = 0.0
        assert form(w, t.ravel(), t.shape[1], all_awake(1), 1, moved, 1) == t[0, CYCLE] == found
    w, moved = pairs_of(1, 1.0), np.stack([-0.5 * size * x, -0.5 * size * y])
    w[W.C1 : W.C1 + STRIDE], w[W.C2 : W.C2 + STRIDE] = 1.2 * size * x, 1.2 * size * y
    t[0, CYCLE] = 0.0  # what was written with the pair that was kept is to be written again: no state may show it
    assert form(w, t.ravel(), t.shape[1], all_awake(1), 1, moved, 2) == 0
    a, b = t[0, ONWARD + 1 : ONWARD + 3], t[0, ONWARD + 4 : ONWARD + 6]
    for place in (ONWARD, ONWARD + 3):
        pushed = t.copy()
        pushed[0, place] = 1e-30
        w[W.C1 : W.C1 + STRIDE], w[W.C2 : W.C2 + STRIDE] = 0.5 * size * x, 0.5 * size * y
        moved = np.full((2, STRIDE), 1e-9 * size)
        assert form(w.copy(), t.copy().ravel(), t.shape[1], all_awake(1), 1, moved, 1) == 1
        assert form(w.copy(), pushed.ravel(), t.shape[1], all_awake(1), 1, moved, 1) == 0
    for _ in range(300):
        assert (u + (u1 * (size * x) + u2 * (size * y)) == u).all()
        assert (v + (v1 * (size * x) + v2 * (size * y)) == v).all()
        x, y = a @ (x, y), b @ (x, y)


def flies(t, room, columns, runs, transient, total, found, cycles, flown):
    """Go through the periods of a run; cycles are found after given periods. Mark who is flown, and in which."""
    asked, awake, again = 0, 0, 0
    for n in range(total):
        if n >= again:
            awake, again = stand_still(numbers(t), room, columns, numbers(runs), n, transient, total)
            asked += 1
        for k in range(awake):
            flown[runs[AWAKE + k], n] = 1
        for q in range(columns):
            if n == found[q]:
                t[q * room + CYCLE] = cycles[q]
                again = n + 1
    return asked


@pytest.mark.parametrize("form", [flies, compiled(flies)])
@pytest.mark.parametrize(("transient", "keep"), [(240, 10), (0, 50), (31, 0), (17, 17), (1, 2), (0, 0)])
def test_whole_cycles_are_passed_over_and_the_rest_is_flown(form, transient, keep):
    """What is flown of a stretch are the same places of the cycle as without standing still."""
    total, columns = transient + keep, 6
    found, cycles = np.array([0, 4, 5, 20, 245, 1000]), np.array([1, 2, 3, 1, 2, 1])
    t = tables(*["standard"] * columns)
    flown = np.zeros((columns, total), np.int64)
    asked = form(t.ravel(), t.shape[1], columns, all_awake(columns), transient, total, found, cycles, flown)
    for row, known, cycle in zip(flown, found + 1, cycles, strict=True):
        assert row[:known].all()
        assert row[transient : transient + cycle].all()  # what is kept is written once, and then again
        for stretch in (row[:transient], row[transient:]):
            assert (stretch.sum() - len(stretch)) % cycle == 0  # the state is in the end that of the last period
        assert row[known:].sum() < 3 * cycle
    assert asked <= 5 * columns * cycles.max() or total < 30


def passes_over(w, t, room, runs, awake):
    """Do with a block what is done in a period, but for the impacts."""
    w, t, runs = numbers(w), numbers(t), numbers(runs)
    certify(w, t, room, runs, awake, STRIDE, STARTS)
    places, several = candidates(w, runs, awake, STRIDE)
    count_hits(w, runs, awake, awake, STRIDE)
    hand_back(w, runs, awake, STRIDE, 0)
    onward(w, t, room, runs, awake, STRIDE)
    return places, several


@pytest.mark.parametrize("form", [passes_over, compiled(passes_over)])
def test_a_column_that_stands_still_is_passed_over(form):
    t = tables("standard", "standard", "standard")
    w, runs = pairs_of(3), np.zeros(3 * WIDTH, np.int64)
    runs[AWAKE : AWAKE + 2] = 0, 2
    w[W.NEED : W.NEED + 3 * STRIDE] = 1e300  # nobody flies free
    w[W.HITS : W.HITS + 3 * STRIDE] = 7.0
    middle = slice(STRIDE, 2 * STRIDE)
    before = {row: w[row:][middle].copy() for row in (W.C1, W.C2, W.NEED, W.FREE, W.HITS)}
    places, several = form(w, t.ravel(), t.shape[1], runs, 2)
    assert (places, several) == (2 * STARTS, 2)
    assert runs[[RUNS, RUNS + 1, RUNS + 2]].tolist() == [0, STARTS, 2 * STARTS]
    assert runs[[WHOSE, WHOSE + 1]].tolist() == [0, 2]
    assert all(np.array_equal(w[row:][middle], kept) for row, kept in before.items())
    assert w[W.HITS : W.HITS + STRIDE].tolist() == [1.0] * STARTS + [0.0] * (STRIDE - STARTS)


#: Models, changes of them, and whether the orbits end in a cycle that is looked for.
CASES = {
    "an impact in every period, rounding goes to and fro": ("standard", {"V": 0.0, "d": 0.06}, True),
    "an impact in every second period": ("standard", {"d": 0.08}, True),
    "an impact in every third period": ("standard", {"d": 0.12}, False),
    "no impact": ("standard", {"d": 0.155}, True),
    "no impact, under-damped": ("under-damped", {"alpha": 0.5, "d": 3.0}, True),
    "no impact, two harmonics": ("two harmonics", {"offset": 4.0}, True),
    "impacts, two harmonics": ("two harmonics", {"offset": 0.5}, True),
}


@pytest.mark.parametrize("arithmetic", ["strict", "fast"])
@pytest.mark.parametrize(("transient", "keep"), [(0, 250), (3 * SELDOM - 1, 227), (150, 51), (245, 3), (250, 0)])
@pytest.mark.parametrize(("name", "change", "repeats"), CASES.values(), ids=CASES)
def test_company_that_never_repeats_itself_changes_no_bit(name, change, repeats, transient, keep, arithmetic):
    """Beside a start that is no number a column is flown to its end; results are the same to the last bit."""
    P = gz.stroboscopic_map(MODELS[name])
    rows = np.array([list({**P.params, **change}.values())])
    assert rows.shape == (1, len(P.params))
    random = np.random.default_rng(4)
    starts = np.stack([random.uniform(0.0, 0.2, (1, 6)), random.uniform(-0.3, 0.3, (1, 6))], axis=1)
    company = np.concatenate([starts, np.full((1, 2, 1), np.nan)], axis=2)
    alone, beside = (
        P.run_columns(rows, lanes, transient, keep, algorithm="block", arithmetic=arithmetic)
        for lanes in (starts, company)
    )
    assert all(np.array_equal(a, b[..., :6]) for a, b in zip(alone, beside, strict=True))
    assert np.array_equal(starts, company[..., :6])
    if keep > 2:
        assert np.array_equal(alone.points[0, -1], alone.points[0, -3]) == repeats


@pytest.mark.parametrize("arithmetic", ["strict", "fast"])
@pytest.mark.parametrize(
    ("name", "change"),
    [("standard", {"d": 0.155}), ("standard", {"d": 2.0, "omega": 0.7}), ("two harmonics", {"offset": 4.0})],
)
def test_flights_that_fade_are_written_as_long_as_they_show(name, change, arithmetic):
    """Columns of one start each, which fade out of sight in different periods, fast and slowly."""
    P = gz.stroboscopic_map(MODELS[name])
    params = {**P.params, **change}
    rows = np.array([list(params.values())] * 64)
    rest = P.replace(**params).orbit((params["sigma"] + 1.0, 0.0), 250).points[-1]
    starts = rest[None, :, None] + np.stack([np.geomspace(0.05, 1e-9, 64), np.zeros(64)], axis=1)[:, :, None]
    company = np.concatenate([starts, np.full((64, 2, 1), np.nan)], axis=2)
    alone, beside = (
        P.run_columns(rows, lanes, 0, 120, algorithm="block", arithmetic=arithmetic) for lanes in (starts, company)
    )
    assert not alone.letters.any()
    assert all(np.array_equal(a, b[..., :1]) for a, b in zip(alone, beside, strict=True))
