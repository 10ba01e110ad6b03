"""The fixed set is what it claims to be, and the judge finds what is wrong with a program."""

import dataclasses

import numpy as np
import pytest

from benchmarks import build
from benchmarks.fixed import EACH, ORBITS, WRONG, Kind, fixed_set, judge
from benchmarks.models import MODELS, PASSIVE, STANDARD
from tests.reference import advance

STORED = fixed_set()
D, DEPTH, START, AFTER = (STORED[name] for name in ("d", "depth", "stress_start", "stress_after"))


def test_sizes():
    assert START.shape == AFTER.shape == (2, 10, 9, len(Kind), EACH)
    assert START[0, :, :, Kind.DIP].size == START[0, :, :, Kind.CLEARANCE].size == 2250
    assert D.min() == 0.05 and D.max() == 0.16
    assert DEPTH.tolist() == [float(f"1e-{n}") for n in range(4, 13)]
    assert STORED["orbit_states"].shape == (len(MODELS), 2, 20, ORBITS)
    assert np.isfinite(START).all() and np.isfinite(AFTER).all()
    assert (START[0] > 0.0).all() and (AFTER[0] >= 0.0).all()


def test_no_start_is_there_twice():
    assert len(np.unique(START.reshape(2, -1), axis=1).T) == 4500


@pytest.mark.parametrize("kind", Kind)
@pytest.mark.parametrize("j", range(9))
def test_near_grazes_against_the_reference(kind, j):
    """A dip hits the wall and not one half a depth below its lowest point; a clearance the other way round."""
    i, k = (3 * j + 5 * kind) % 10, (7 * j + kind) % EACH
    u, v = START[:, i, j, kind, k]
    p = build.problem(STANDARD, D[i])
    other = dataclasses.replace(p, sigma=(-1.5 if kind == Kind.DIP else 1.5) * DEPTH[j])
    (right,), (wrong,) = advance(p, u, v, 1), advance(other, u, v, 1)
    assert AFTER[:, i, j, kind, k].tolist() == [float(right.u), float(right.v)]
    assert max(abs(float(right.u - wrong.u)), abs(float(right.v - wrong.v))) > WRONG
    hits, misses = (right, wrong) if kind == Kind.DIP else (wrong, right)
    first = hits.impacts[0]
    assert abs(float(first.v_minus)) < 2.0 * np.sqrt(DEPTH[j])  # v^2 = 2 F depth, with F below 1.16
    assert not misses.impacts or misses.impacts[0].t > first.t


@pytest.mark.parametrize("i", range(len(MODELS)))
def test_ordinary_orbits_against_the_reference(i):
    model, j = list(MODELS.values())[i], 11 * i
    u, v = STORED["orbit_start"][:, j]
    states = build.strobes(build.problem(model, STORED["orbit_d"][0]), u, v, 20)
    assert STORED["orbit_states"][i, :, :, j].tolist() == states.tolist()


# ---- the judge


def told(model, change=lambda states: states):
    """A program that looks the answers up, and changes them."""

    def program(columns, transient, keep):
        if len(columns.d) > 1:
            each = columns.u.shape[1] // (len(DEPTH) * len(Kind))
            states = AFTER[..., :each].reshape(2, len(D), 1, -1)
        else:
            i = list(MODELS).index(model.name)
            states = STORED["orbit_states"][i, :, None, :, : columns.u.shape[1]]
        return change(states.copy())

    return program


def test_exact_answers_are_right():
    found = judge(told(STANDARD), STANDARD, 2, 7)
    assert found == (180, 0, 180, 0, 7, 0.0)
    assert judge(told(PASSIVE), PASSIVE, 2, 7) == (None, None, None, None, 7, 0.0)


def test_wrong_answers_are_counted():
    def spoil(states):
        states[1, 0, 0, 0] += 2.0 * WRONG  # the first dip, and the first ordinary orbit
        return states

    found = judge(told(STANDARD, spoil), STANDARD, EACH, 7)
    assert found[:4] == (2250, 1, 2250, 0)
    assert found.worst == pytest.approx(2.0 * WRONG)


def test_no_number_is_a_wrong_answer():
    found = judge(told(STANDARD, lambda states: states * np.nan), STANDARD, 1, 1)
    assert found[:4] == (90, 90, 90, 90)
    assert found.worst == np.inf
