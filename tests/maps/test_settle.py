"""What doubles cannot decide is decided in ball arithmetic, and the orbit goes on from there."""

import functools

import numpy as np
import pytest

import grazing as gz
from grazing.maps import settle
from grazing.maps.columns import empty_columns
from grazing.maps.map import CHATTER_LETTER, STUCK_LETTER
from grazing.oscillator.constants import steady_response
from grazing.oscillator.exact import exact_period
from grazing.outcome import AMBIGUOUS, CHATTER, GRAZE
from tests.models import changed_origin, packed

#: Models whose orbit without impacts grazes once in every period at the force that ``normal_form`` names.
GRAZING = {
    "over-damped": gz.pinball(),
    "critical, shifted wall": gz.pinball(alpha=2.0, k=1.0, sigma=0.3, V=0.2, r=0.6),
    "under-damped": gz.pinball(alpha=0.2, k=3.0, V=0.1),
    "passive": gz.pinball(V=0.0, t0=0.3),
}
WAYS = [("block", "fast"), ("block", "strict"), ("scalar", "fast"), ("scalar", "strict")]


@functools.cache
def graze_at(name):
    return gz.normal_form(GRAZING[name], "d").graze


def grazing_map(name, side, phase=0.0):
    """Return the model at the graze, or one double beside it; its map; the orbit that grazes, at the strobe."""
    d = graze_at(name)
    m = GRAZING[name].replace(d=float(np.nextafter(d, d + side)))
    P = gz.stroboscopic_map(m, phase)
    y, v = steady_response(0.0, packed(P))
    return m, P, (y + m.sigma, v)


def flown(P, start, n, *, transient=0, records=None, way=("scalar", "strict"), settle="map"):
    """Run one orbit; return what was found and its last state."""
    if settle != "map":
        P = changed_origin(P, settle=settle)
    lanes = np.array(start).reshape(1, 2, 1)
    rows = [list(P.params.values())]
    found = P.run_columns(
        rows, lanes, transient, n, records=records or max(n, 1), algorithm=way[0], arithmetic=way[1], threads=1
    )
    return found, lanes[0, :, 0]


def exact_letters(m, states, phase):
    periods = [exact_period(m, tuple(state), phase) for state in states]
    assert None not in periods
    letters = [
        CHATTER_LETTER if p.outcome & CHATTER else (STUCK_LETTER if p.lay else p.impacts) for p in periods
    ]  # fmt: skip
    return letters, min(p.near for p in periods), min(p.slow for p in periods)


@pytest.mark.parametrize("name", GRAZING)
@pytest.mark.parametrize("side", [-1, 0, 1])
def test_at_the_graze_every_step_is_right(name, side):
    for phase in (0.0, 1.1):
        m, P, start = grazing_map(name, side, phase)
        for way in WAYS:
            doubtful, _ = flown(P, start, 6, way=way, settle=None)
            assert doubtful.undecided[0, 0] > 0, "the start was meant to graze"
            assert doubtful.undecided[0, 0] == np.count_nonzero(doubtful.outcomes & AMBIGUOUS)
            found, last = flown(P, start, 6, way=way)
            states = [start, *found.points[0, :, :, 0]]
            letters, _near, _slow = exact_letters(m, states[:-1], phase)
            assert found.letters[0, :, 0].tolist() == letters
            assert found.undecided[0, 0] == 0
            assert not (found.outcomes & (AMBIGUOUS | GRAZE)).any()
            assert np.array_equal(last, states[-1])


@pytest.mark.parametrize("way", WAYS)
def test_doubles_alone_are_wrong_there(way):
    """Else the tests above would prove nothing: without ball arithmetic some letters are others."""
    wrong = 0
    for name in GRAZING:
        for side in (-1, 0, 1):
            m, P, start = grazing_map(name, side)
            found, _ = flown(P, start, 6, way=way, settle=None)
            states = [start, *found.points[0, :, :, 0]]
            wrong += found.letters[0, :, 0].tolist() != exact_letters(m, states[:-1], 0.0)[0]
    assert wrong > 0


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("transient", [0, 3, 12])
def test_records_and_transient_change_nothing(way, transient):
    _, P, start = grazing_map("over-damped", 1)
    every, end = flown(P, start, 12, way=way)
    folded, last = flown(P, start, 12 - transient, transient=transient, records=1, way=way)
    assert np.array_equal(folded.points, every.points[:, transient:])
    assert np.array_equal(folded.letters, every.letters[:, transient:])
    assert folded.outcomes[0, 0, 0] == np.bitwise_or.reduce(every.outcomes[0, :, 0])
    assert (folded.near_miss, folded.slowest, folded.undecided) == (every.near_miss, every.slowest, every.undecided)
    assert np.array_equal(last, end)


def test_only_orbits_with_a_doubt_are_gone_through_again():
    _, P, start = grazing_map("over-damped", 0)
    asked = []

    def noting(row, state):
        asked.append((row, state))
        return P.origin.settle(row, state)

    n = 5
    starts = np.array([[start[0], start[0] + 0.01, start[0]], [start[1], 0.1, start[1]]])
    rows = np.array([list(P.params.values())] * 2)
    rows[1, list(P.params).index("d")] = 0.2
    R = changed_origin(P, settle=noting)
    plain = changed_origin(P, settle=None)
    for arithmetic in ("strict", "fast"):
        asked.clear()
        lanes, bare = (np.stack([starts, starts]) for _ in range(2))
        found = R.run_columns(rows, lanes, 0, n, arithmetic=arithmetic, threads=1)
        left = plain.run_columns(rows, bare, 0, n, arithmetic=arithmetic, threads=1)
        assert (left.undecided > 0).tolist() == [[True, False, True], [False] * 3]
        assert {tuple(row) for row, _ in asked} == {tuple(rows[0].tolist())}
        assert asked[0][1] == start
        sure = left.undecided == 0
        assert np.array_equal(found.points.transpose(0, 3, 1, 2)[sure], left.points.transpose(0, 3, 1, 2)[sure])
        assert np.array_equal(lanes.transpose(0, 2, 1)[sure], bare.transpose(0, 2, 1)[sure])
        assert np.array_equal(found.points[0, :, :, 0], found.points[0, :, :, 2])


@pytest.mark.parametrize("limit", [0, 1, 2, 5])
def test_the_limit_of_an_orbit_is_kept(monkeypatch, limit):
    _, P, start = grazing_map("critical, shifted wall", 1)  # every period is in doubt
    monkeypatch.setattr(settle, "LIMIT", limit)
    asked = []

    def noting(row, state):
        asked.append(state)
        return P.origin.settle(row, state)

    n = 4
    R = changed_origin(P, settle=noting)
    lanes = np.tile(np.array(start).reshape(1, 2, 1), (1, 1, 2))
    found = R.run_columns([list(P.params.values())], lanes, 0, n, records=n, algorithm="scalar", threads=1)
    settled = n if limit > 0 else 0  # it comes back to the same state: one answer holds for ever
    assert len(asked) == min(settled, 1)
    assert found.undecided.sum() == 2 * (n - settled)
    for i in (0, 1):
        doubtful = (found.outcomes[0, :, i] & AMBIGUOUS) != 0
        assert doubtful.tolist() == [False] * settled + [True] * (n - settled)
        assert np.array_equal(lanes[0, :, i], found.points[0, -1, :, i])


@pytest.mark.parametrize("limit", [0, 1, 2, 5, 9])
def test_the_limit_counts_states_that_differ(monkeypatch, limit):
    monkeypatch.setattr(settle, "LIMIT", limit)
    n = 7

    def again(row, state, steps):
        one = empty_columns(1, 1, 1, steps, steps)
        one.points[0, :, 0, 0], one.outcomes[0, :, 0] = state[0] + np.arange(1.0, steps + 1.0), AMBIGUOUS
        return one

    def proven(row, state):
        return settle.Settled((state[0] + 1.0,), 0, 0, np.inf, np.inf)

    found, lanes = empty_columns(1, 1, 1, n, n), np.zeros((1, 1, 1))
    settle.settle_orbit(np.zeros(1), 0, 0, np.zeros((1, 1, 1)), lanes, 0, found, proven, again)
    assert found.undecided[0, 0] == max(n - limit, 0)
    assert (found.outcomes[0, :, 0] & AMBIGUOUS != 0).tolist() == [i >= limit for i in range(n)]
    assert (found.points[0, :, 0, 0].tolist(), lanes[0, 0, 0]) == ([1.0 + i for i in range(n)], 7.0)


@pytest.mark.parametrize("way", WAYS)
def test_what_no_precision_decides_stays_ambiguous(way):
    _, P, start = grazing_map("over-damped", 1)
    plain, end = flown(P, start, 8, way=way, settle=None)
    asked, last = flown(P, start, 8, way=way, settle=lambda row, state: None)
    assert asked.undecided == plain.undecided > 0
    assert np.array_equal(asked.letters, plain.letters)
    assert np.array_equal(asked.outcomes, plain.outcomes)
    assert np.allclose(last, end, rtol=0.0, atol=1e-15)
    assert asked.slowest[0, 0] == pytest.approx(plain.slowest[0, 0])
    assert asked.near_miss[0, 0] == pytest.approx(plain.near_miss[0, 0], abs=1e-14)


def test_an_exact_tie_is_reported():
    """A ball that touches the wall exactly: no number of digits decides it."""
    m = gz.Oscillator(0.0, 0.0, gz.Forcing(omega=2.0, offset=2.0, cos=(0.0,)), gz.active(r=0.5, V=0.3))
    start = (1.0, -2.0)  # (1 - t)^2 touches the wall at t = 1
    assert exact_period(m, start) is None
    orbit = gz.stroboscopic_map(m).orbit(start, 1)
    assert (orbit.letters[0], orbit.outcomes[0], orbit.undecided) == (0, GRAZE | AMBIGUOUS, 1)


@pytest.mark.parametrize(("side", "offset"), [(1, 1e-8), (1, 1e-12), (0, 1e-8), (-1, 1e-13)])
@pytest.mark.parametrize("way", [("scalar", "strict"), ("block", "fast")])
def test_trust_is_that_of_the_orbit_that_was_kept(side, offset, way):
    """Near miss and slowest impact come from the steps of this orbit, not from a step that ball arithmetic undid."""
    m, P, (u, v) = grazing_map("over-damped", side)
    start = (u + offset, v)
    found, _ = flown(P, start, 40, way=way)
    assert found.undecided[0, 0] == 0
    letters, near, slow = exact_letters(m, [start, *found.points[0, :-1, :, 0]], 0.0)
    assert found.letters[0, :, 0].tolist() == letters
    assert found.slowest[0, 0] == pytest.approx(slow, rel=1e-6)
    assert 0.25 * near <= found.near_miss[0, 0] <= 4.0 * near  # so narrow a miss has few digits, but it has a size


def test_progress_counts_the_tasks_of_the_run_alone():
    _, P, start = grazing_map("over-damped", 1)
    for starts in (600, 2):
        said = []
        lanes = np.tile(np.array(start).reshape(1, 2, 1), (1, 1, starts))
        lanes[0, 0, 1:] += 0.01
        rows = [list(P.params.values())]
        P.run_columns(rows, lanes, 0, 4, threads=1, progress=lambda *now, said=said: said.append(now))
        total = said[0][1]
        assert said == [(i, total) for i in range(1, total + 1)]
