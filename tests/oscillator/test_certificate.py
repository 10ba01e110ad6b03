"""The rows of a table against the states they stand for, and the questions to them in every form."""

import numpy as np
import pytest

import grazing as gz
from grazing.kernel.compile import compiled
from grazing.kernel.primitives import numbers
from grazing.oscillator.cells import (
    ALWAYS,
    CELLS,
    CERTIFICATE,
    COUNT,
    GO_ON,
    MARGIN,
    MAX_ROWS,
    NEVER,
    POINTS,
    ROW_COUNT,
    ROWS,
    TABLED,
    THEN,
    UPRIGHT,
    cell_size,
    fill_table,
    table_size,
)  # fmt: skip
from grazing.oscillator.certificate import certify, certify_rest, locate, next_event
from grazing.oscillator.workspace import HIGH, WIDTH, W, workspace_size
from tests.models import MODELS, packed

NAMES = [name for name, model in MODELS.items() if name != "stiff"]
N = 32  # orbits asked: whole vectors


def table_of(name):
    c = packed(gz.stroboscopic_map(MODELS[name]))
    t = np.zeros(table_size(len(c.cos)))
    assert fill_table(t, np.zeros(9 * POINTS), c, 1.0)
    return t


def rows(t, start, count):
    """Return p, q, r and the place of every row of a list, without its padding."""
    found = t[start : start + 4 * MAX_ROWS].reshape(4, MAX_ROWS)[:, : int(t[count])].T
    return found[found[:, 2] < NEVER]


def thens(t, name):
    """Return for each cell the first row of the certificate to be asked after an impact there."""
    size = cell_size(MODELS[name].harmonics)
    return t[CELLS + THEN :: size][: int(rows(t, ROWS, ROW_COUNT)[-1, 3]) // 2]


def pairs(t, n=N):
    """Return pairs that pass all rows, some, and few."""
    list_of_all = rows(t, CERTIFICATE, COUNT)
    size = np.abs(list_of_all[:, 2][list_of_all[:, 2] > ALWAYS]).max()
    return np.random.default_rng(1).uniform(-2.0, 2.0, (2, n)) * size


def ease(t, x, y):
    """Move the wall off until half of the pairs pass; rows that fail always do so no more."""
    heights = []
    for start, count in ((CERTIFICATE, COUNT), (ROWS, ROW_COUNT)):
        constants = t[start + 2 * MAX_ROWS :][: int(t[count])]
        constants[constants == ALWAYS] = NEVER / 2.0
        found = rows(t, start, count)
        heights.append((found[:, :2] @ (x, y) + found[:, 2:3]).min(axis=0))
    for start in (CERTIFICATE, ROWS):
        t[start + 2 * MAX_ROWS :][:MAX_ROWS] -= np.median(heights)


@pytest.mark.parametrize("name", NAMES)
def test_both_lists_are_in_the_order_of_time(name):
    t = table_of(name)
    certificate, every = rows(t, CERTIFICATE, COUNT), rows(t, ROWS, ROW_COUNT)
    assert (np.diff(certificate[:, 3]) >= 0.0).all()
    assert (np.diff(every[:, 3]) > 0.0).all()
    assert set(certificate[:, 3]) <= set(every[:, 3])
    ends = every[every[:, 3] % 2 == 0]
    assert np.array_equal(ends[:, 3], 2.0 * np.arange(len(ends)))  # the start and the end of every cell
    short, long = (part[part[:, 3] % 2 == 1] for part in (certificate, every))
    assert len(short) == 2 * len(long)


@pytest.mark.parametrize("name", NAMES)
def test_upright_tables_have_p_1_in_all_rows(name):
    t = table_of(name)
    for start, count in ((CERTIFICATE, COUNT), (ROWS, ROW_COUNT)):
        found = rows(t, start, count)
        drawn = found[found[:, 2] > ALWAYS]
        assert (drawn[:, 0] == 1.0).all() or not t[UPRIGHT]
    m = MODELS[name].params
    assert bool(t[UPRIGHT]) == (m["alpha"] >= 2.0 * m["k"])


@pytest.mark.parametrize("name", NAMES)
def test_longer_chords_ask_for_more(name):
    """So what the certificate leaves open is found in the list of all rows, up to rounding."""
    t = table_of(name)
    certificate, every = rows(t, CERTIFICATE, COUNT), rows(t, ROWS, ROW_COUNT)
    x, y = pairs(t, 4000)
    margin = 1e-12 * (np.abs(x) + np.abs(y)).max()
    for place in every[every[:, 3] % 2 == 1][:, 3]:
        long = every[every[:, 3] == place][0]
        if long[2] == ALWAYS:
            continue
        passed = long[0] * x + long[1] * y + long[2] >= 0.0
        inside = passed.copy()  # between the grazing states of the cell both halves pass where the whole does
        for p, q, r, _place in certificate[certificate[:, 3] == place]:
            inside &= p * x + q * y + r >= -margin
        ends = every[(every[:, 3] == place - 1) | (every[:, 3] == place + 1)]
        both = (ends[:, :1] * x + ends[:, 1:2] * y + ends[:, 2:3] >= 0.0).all(axis=0)
        assert inside[passed & both].all()


def asks(work, table, runs, since, events):
    """Ask all questions: the answers to each are left in ``work``."""
    w, t, room = numbers(work), numbers(table), len(table)
    certify(w, t, room, numbers(runs), 1, N, N)
    locate(w, t, room, numbers(runs), 1)
    for i in range(N):
        events[i] = next_event(t, since[i], w[W.X1 + i], w[W.X2 + i], w[W.DOUBT + i])
    return certify_rest(w, t, room, numbers(runs), 1)


@pytest.mark.parametrize("arithmetic", ["strict", "fast"])
@pytest.mark.parametrize(
    "name", ["standard", "critical", "under-damped", "undamped, no stiffness", "near resonance", "two harmonics"]
)
def test_every_form_of_a_question_gives_the_answer_of_the_rows(name, arithmetic):
    t = table_of(name)
    x, y = pairs(t)
    ease(t, x, y)
    x[3], y[5], x[7] = np.nan, np.nan, 1e-3
    certificate, every = rows(t, CERTIFICATE, COUNT), rows(t, ROWS, ROW_COUNT)
    random, cells = np.random.default_rng(2), int(every[-1, 3]) // 2
    since = random.integers(0, 2 * cells + 2, N).astype(float)
    inside = random.integers(0, cells, N)
    heights = certificate[:, :1] * x + (certificate[:, 1:2] * y + certificate[:, 2:3])
    failing = ~(every[:, :1] * x + (every[:, 1:2] * y + every[:, 2:3]) >= 1e-9)
    later = failing & (every[:, 3:] >= since)
    first, following = (
        np.where(found.any(axis=0), every[found.argmax(axis=0), 3], 0.0) for found in (failing, later)
    )  # fmt: skip
    rest = certificate[:, 3:] >= t[GO_ON + inside]
    wider = np.where(random.random(N) < 0.2, np.nan, 1e-9)
    free = (np.where(rest, heights, np.inf) >= 1e-9).all(axis=0) & (wider < HIGH)
    t[MARGIN : MARGIN + 3] = 1e-9, 0.0, 0.0
    lowest = heights.min(axis=0) - 1e-9
    clear = ~(np.abs(lowest) < 1e-14 * np.nanmax(np.abs(heights)))
    assert set(lowest[clear] >= 0.0) == {True, False}
    for upright in {0.0, t[UPRIGHT]}:
        w, events, runs = np.zeros(workspace_size(3)), np.zeros(N), np.zeros(3 * WIDTH, np.int64)
        t[UPRIGHT] = upright
        for start, values in ((W.C1, x), (W.C2, y), (W.X1, x), (W.X2, y), (W.Z1, x), (W.Z2, y), (W.WIDER, wider)):
            w[start : start + N] = values
        w[W.THEN : W.THEN + N] = thens(t, name)[inside]
        runs[:2], t[TABLED] = (0, N), 1.0
        w[W.NEED : W.NEED + N] = np.where(np.isfinite(x + y), 1e-9 - upright * x, np.nan)
        left = compiled(asks, arithmetic)(w, t, runs, since, events)
        passed, event = (w[start : start + N] for start in (W.FREE, W.EVENT))
        assert np.array_equal(passed[clear], np.where(lowest[clear] >= 0.0, 1.0, -1.0))
        assert np.array_equal(event, first)
        assert np.array_equal(events, following)
        assert (event > 0.0).any()
        assert np.array_equal(w[W.REST : W.REST + left], np.flatnonzero(~free))


@pytest.mark.parametrize("name", NAMES)
def test_after_an_impact_the_certificate_goes_on_at_the_first_row_from_there_on(name):
    t = table_of(name)
    places, then = t[CERTIFICATE + 3 * MAX_ROWS :][: int(t[COUNT]) + 8], thens(t, name)
    for cell in range(int(rows(t, ROWS, ROW_COUNT)[-1, 3]) // 2):
        assert then[cell] == np.argmax(places >= t[GO_ON + cell])
