"""The library as a program: the entry that the rows use gives what its maps give."""

import numpy as np

import grazing as gz
from benchmarks.models import MODELS, STANDARD
from benchmarks.ours import oscillator, rows_of, run_columns


def test_columns_are_the_map_with_other_parameters():
    G = gz.gap_map(lam=0.34, mu=0.05, l=0.21)
    mu, starts = [0.02, 0.11], np.array([[[0.3, -0.2, 0.5]], [[0.1, 0.2, -0.7]]])
    points = run_columns(G, rows_of(G, "mu", mu), starts.copy(), 2, 3, "strict", "scalar", 2)
    for i, value in enumerate(mu):
        for j in range(3):
            orbit = G.replace(mu=value).orbit(starts[i, :, j], 5).points
            assert points[i, :, :, j].tolist() == orbit[3:].tolist()


def test_models_are_those_of_the_peers():
    for model in MODELS.values():
        m = oscillator(model)
        assert (m.alpha, m.k, m.period) == (model.alpha, model.k, model.period)
        assert m.params["r"] == model.r and m.params["V"] == model.V
        assert m.harmonics == len(model.waves)


def test_the_law_of_ones_own_kicks_like_the_built_in_one():
    built_in, own = oscillator(STANDARD).reset, oscillator(STANDARD, own_law=True).reset
    assert own.law is not built_in.law
    assert [own(v) for v in (-1.0, -0.3, 0.0)] == [built_in(v) for v in (-1.0, -0.3, 0.0)]
