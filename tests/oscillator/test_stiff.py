"""Stiff walls: work grows with impacts, not with the swings of a ball that stays off the wall."""

import numpy as np
import pytest

import grazing as gz
from grazing.oscillator import contact, exact
from grazing.oscillator.cells import MAX_CELLS, cells_in
from grazing.oscillator.exact import exact_period
from grazing.outcome import AMBIGUOUS, TOO_MANY_SWINGS
from grazing.parameter import parameters


def stiff(k, alpha=0.0, sigma=-1.0, **more):
    return gz.pinball(alpha=alpha, k=k, r=0.5, V=0.4, sigma=sigma, **more)


@pytest.fixture
def work(monkeypatch):
    """Count the pieces of windows that are looked at."""
    seen, ask = [], contact.piece_hit

    def counted(*arguments):
        seen.append(arguments[1])
        return ask(*arguments)

    monkeypatch.setattr(contact, "piece_hit", counted)
    return seen


def step(m, start):
    P = gz.stroboscopic_map(m)
    return P.step(start, P.prepare(parameters(P.params)))


@pytest.mark.parametrize("k", [300.0, 1e3, 1e4])
@pytest.mark.parametrize("swing", [0.0, 0.5, 0.999])
@pytest.mark.parametrize("alpha", [0.0, 0.3])
def test_a_ball_that_stays_off_the_wall_takes_no_pieces(k, swing, alpha, work):
    _point, letter, outcome = step(stiff(k, alpha), (0.0, swing * k))
    assert (letter, outcome, len(work)) == (0, 0, 0)


@pytest.mark.parametrize("k", [300.0, 1e3])
def test_work_is_that_of_the_impacts(k, work):
    """The wall at rest position: two pieces for each impact. A damped ball: none after it swings too little."""
    _point, letter, _outcome = step(stiff(k, 0.1, sigma=0.0), (0.3, 0.2))
    assert letter > 0.4 * k / 2.2
    assert len(work) <= 2 * letter + 10
    work.clear()
    _point, letter, outcome = step(stiff(k, 2.0), (0.0, 1.2 * k))
    assert (outcome, len(work) <= 2 * letter + 0.1 * k) == (0, True)


def starts(count, seed):
    """Yield stiff models and starts of which about half hit the wall; a response that dips, too."""
    rng = np.random.default_rng(seed)
    for _ in range(count):
        k, alpha = 10.0 ** rng.uniform(1.3, 2.2), rng.choice([0.0, 10.0 ** rng.uniform(-3.0, 1.0)])
        size = 10.0 ** rng.uniform(-6.0, 6.0)
        dip = rng.choice([1e-3, 0.5, 0.95])  # the share of the height that the response dips
        forcing = gz.Forcing(rng.uniform(0.5, 3.0), rng.uniform(0.0, 3.0), 0.0, (0.8 * dip * k * k * size,))
        m = gz.Oscillator(alpha, k, forcing, gz.active(0.7, 0.1 * size), -size)
        swing = size * rng.choice([0.1, 1.0 - dip, 1.0, rng.uniform(0.3, 1.1)]) * rng.uniform(0.9, 1.02)
        turn = rng.uniform(0.0, 6.28)
        steady = 0.8 * dip * size * np.cos(forcing.omega * forcing.t0)
        u = steady + swing * np.cos(turn)
        if u > -size:
            yield m, (float(u), float(swing * k * np.sin(turn)))


@pytest.mark.parametrize("count", [25, pytest.param(1000, marks=pytest.mark.long)])
def test_no_impact_is_passed_over(count):
    hits, sure = 0, 0
    for m, start in starts(count, count):
        point, letter, outcome = step(m, start)
        period = exact_period(m, start)
        if outcome & AMBIGUOUS or period is None:
            continue
        sure += 1
        hits += letter > 0
        assert letter == period.impacts, (m, start)
        scale = max(abs(m.sigma), *map(abs, start[:1])), max(abs(m.sigma), abs(start[0])) * m.k
        lost = 1.0 + max(0, letter) * scale[1] / period.slow if letter else 1.0
        assert np.abs(np.subtract(point, period.state) / scale).max() < 1e-12 * lost, (m, start)
    assert sure > 0.7 * count
    assert 0.2 * count < hits < 0.9 * count


def test_balls_pass_over_what_stays_off_the_wall(monkeypatch):
    """The period that balls gave up as too much work takes a few evaluations; cutting everything gives the same."""
    for k in (300.0, 1e4):
        assert exact_period(stiff(k), (0.0, 0.0)).impacts == 0
    m = stiff(40.0, 0.2)
    found = exact_period(m, (0.0, 45.0))
    monkeypatch.setattr(exact.Flight, "aloft", lambda self, lo, hi: False)
    plain = exact_period(m, (0.0, 45.0))
    assert found[:4] == plain[:4]
    assert 0.0 < found.near <= plain.near


def test_the_cells_of_a_spring_beyond_whole_numbers_are_too_many():
    """Of two windows their sum went around, below 0: the table was written far behind its end."""
    P = gz.stroboscopic_map(stiff(5e14, alpha=1e-6, sigma=0.0, omega=4e-4))
    assert cells_in(P.origin.model.period, P.prepare(parameters(P.params))) == MAX_CELLS + 1
    lanes = np.array([[[0.1], [0.0]]])
    found = P.run_columns(P.packed()[1][None], lanes, 0, 1, algorithm="block")
    assert found.outcomes[0, 0, 0] & TOO_MANY_SWINGS
