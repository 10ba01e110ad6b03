"""Pieces of orbits: the bits of one long run, wherever it is cut."""

import numpy as np
import pytest

import grazing as gz
from grazing.maps import pieces as module
from grazing.maps.columns import Columns
from grazing.maps.pieces import CUT, joined, pieces
from tests.models import MODELS


def pair_step(state, p):
    x, y, z = state
    return (1.0 - p.a * x * x + y, p.b * x, 0.5 * z + x), (1 if x > 0.0 else 0), (1 if x > 1.2 else 0)


THREE_D = gz.Map(
    pair_step, params={"a": 1.4, "b": 0.3}, coordinates=("x", "y", "z"), box=((-0.1, 0.1),) * 3, letters="LR",
    escape=50.0, name="three dimensions",
)  # fmt: skip
MAPS = {
    "gap map": (gz.gap_map(0.9, 0.1, 0.0), "mu", [0.05, 0.1]),
    "three dimensions, some escape": (THREE_D, "a", [1.4, 1.9]),
    "oscillator": (gz.stroboscopic_map(gz.pinball(V=0.0, d=0.05)), "d", [0.02, 0.05]),
    "phase": (gz.stroboscopic_map(MODELS["two harmonics"], 0.7), "omega", [1.1, 1.3]),
    "chatter": (gz.stroboscopic_map(MODELS["chatter"]), "r", [0.2, 0.3]),
    "undamped": (gz.stroboscopic_map(MODELS["elastic"]), "d", [-0.3, -0.2]),
    "impact map": (gz.impact_map(gz.pinball(V=0.4, d=0.12)), "d", [0.05, 0.12]),
    "own law": (gz.stroboscopic_map(MODELS["own law"]), "e", [0.8, 0.9]),
}


def ensemble(P, name, values, n, seed=0):
    """Rows and starts of a small ensemble: (columns, parameters) and (columns, dim, n)."""
    rows = np.array([list(P.replace(**{name: value}).params.values()) for value in values])
    box = np.array(P.box)
    lanes = np.random.default_rng(seed).uniform(box[:, 0, None], box[:, 1, None], (len(values), P.dimension, n))
    return rows, lanes


def same(one, other):
    return all(np.array_equal(a, b, equal_nan=True) for a, b in zip(one, other, strict=True))


@pytest.mark.parametrize("arithmetic", ["fast", "strict"])
@pytest.mark.parametrize("kind", MAPS)
def test_pieces_have_the_bits_of_one_run(kind, arithmetic, monkeypatch):
    P, name, values = MAPS[kind]
    rows, lanes = ensemble(P, name, values, 5)
    for transient, keep in ((0, 600), (700, 30), (255, 2), (256, 1), (300, 300), (520, 0)):
        whole_lanes = lanes.copy()
        whole = P.run_columns(rows, whole_lanes, transient, keep, arithmetic=arithmetic, threads=1)
        for cut in (1, 2):
            monkeypatch.setattr(module, "steps_of", lambda P, steps=cut * CUT * 10: steps)
            cut_lanes = lanes.copy()
            parts = list(pieces(P, rows, cut_lanes, transient, keep, arithmetic))
            assert len(parts) == -(-(transient + keep) // (cut * CUT))
            assert sum(part.points.shape[1] for part in parts) == keep
            assert same(joined(parts), whole), (transient, keep, cut)
            assert np.array_equal(cut_lanes, whole_lanes, equal_nan=True)


def test_a_piece_is_short_however_many_orbits_there_are():
    P = gz.gap_map(0.9, 0.1, 0.0)
    for columns, n in ((1, 1), (1, 5000), (40, 100)):
        rows, lanes = np.tile([0.9, 0.1, 0.0], (columns, 1)), np.zeros((columns, 1, n))
        sizes = [part.points.shape[1] for part in pieces(P, rows, lanes, 0, 2000)]
        assert sum(sizes) == 2000
        assert max(sizes) * columns * n <= max(module.steps_of(P), columns * n)


@pytest.mark.parametrize(("transient", "keep"), [(0, 0), (0, 1), (1, 0)])
def test_shortest_runs(transient, keep):
    P = gz.gap_map(0.9, 0.1, 0.0)
    rows, lanes = np.array([[0.9, 0.1, 0.0]]), np.full((1, 1, 3), -0.5)
    parts = list(pieces(P, rows, lanes, transient, keep))
    assert len(parts) == 1 and parts[0].points.shape == (1, keep, 1, 3)
    assert np.allclose(lanes, -0.35 if transient + keep else -0.5)


def test_grazes_that_must_be_settled_are_settled_in_any_piece(monkeypatch):
    """An orbit that touches the wall every period, as closely as numbers allow."""
    model = gz.pinball(alpha=0.0, k=0.5, r=1.0, V=0.0, d=1.0, omega=1.0)
    P = gz.stroboscopic_map(model)
    rows = np.array([list(P.params.values())])
    rng = np.random.default_rng(1)
    lanes = np.concatenate([np.zeros((1, 1, 8)), rng.uniform(0, 1e-9, (1, 1, 8))], axis=1)
    whole = P.run_columns(rows, lanes.copy(), 100, 60, threads=1)
    monkeypatch.setattr(module, "steps_of", lambda P: 1)
    assert same(joined(list(pieces(P, rows, lanes.copy(), 100, 60))), whole)


def test_joining_folds_outcomes_and_keeps_the_nearest():
    def part(outcome, near, slow, undecided, steps):
        one = np.full((1, 1), 1.0)
        return Columns(
            np.zeros((1, steps, 2, 1)), np.full((1, steps, 1), outcome), np.full((1, 1, 1), outcome), near * one,
            slow * one, np.full((1, 1), undecided),
        )  # fmt: skip

    both = joined([part(1, 0.5, 0.1, 2, 3), part(4, 0.2, np.inf, 0, 0), part(9, 0.3, 0.4, 5, 4)])
    assert both.points.shape == (1, 7, 2, 1)
    assert both.letters[0, :, 0].tolist() == [1] * 3 + [9] * 4
    assert both.outcomes.item() == 13
    assert (both.near_miss.item(), both.slowest.item(), both.undecided.item()) == (0.2, 0.1, 7)
