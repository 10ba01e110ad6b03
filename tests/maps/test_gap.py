"""The gap map (2.6): values of Figure 3.1, its two pieces, and properties for any parameters."""

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

import grazing as gz
from grazing import theory


def test_figure_3_1():
    G = gz.gap_map(lam=0.8, mu=0.5, l=1.0)
    orbit = G.orbit(G.iterate((-1.0,), 300)[-1], 3)
    order = np.argsort(orbit.points[:3, 0])
    assert orbit.points[:3, 0][order] == pytest.approx([-1.0060750571, -0.3048600457, 0.2561119634], abs=5e-11)
    assert sorted(orbit.letters) == [0, 0, 1]
    multiplier = math.prod(float(G.jacobian(point)[0, 0]) for point in orbit.points[:3])
    assert multiplier == pytest.approx(-0.632317, abs=5e-7)


@given(st.floats(-2, 2), st.floats(-2, 2), st.floats(0, 2), st.floats(-3, 3))
def test_one_step(lam, mu, l, x):
    G = gz.gap_map(lam, mu, l)
    new, letter = G((x,))
    assert letter == (0 if x < 0 else 1)
    assert new[0] == pytest.approx(lam * x + mu if x < 0 else mu - l - math.sqrt(x), abs=1e-15)


def test_the_edge_itself_takes_r_and_its_slope_is_infinite():
    G = gz.gap_map(lam=0.5, mu=0.3, l=0.2)
    assert G((0.0,))[1] == 1
    assert G.orbit((0.0,), 1).outcomes[0] == gz.Outcome.ambiguous  # the flow has no impact there
    assert G.orbit((1e-300,), 1).outcomes[0] == 0
    assert G((0.0,))[0][0] == pytest.approx(0.1, abs=1e-16)
    assert G.jacobian((0.0,))[0, 0] == -math.inf
    assert G.jacobian((-0.2,))[0, 0] == 0.5


@given(st.integers(2, 7), st.floats(0.2, 0.9), st.floats(0.05, 1.0), st.floats(0.02, 0.98))
def test_stable_maximal_orbits_attract_their_own_points(N, lam, l, part):
    window = theory.stability_interval(N, lam, l)
    assume(not window.empty)
    assume(window.width > 1e-6)
    mu = window.low + part * window.width
    points = theory.maximal_orbit(N, lam, mu, l)
    assume(abs(theory.multiplier(N, lam, mu, l)) < 0.9)
    assume(min(abs(points)) > 1e-4)
    G = gz.gap_map(lam, mu, l)
    near = G.iterate((points[0] + 1e-7,), 400 * N)
    assert near[-1, 0] == pytest.approx(points[0], abs=1e-10)


@pytest.mark.parametrize("bad", [{"lam": math.nan}, {"mu": "x"}, {"l": math.inf}])
def test_bad_input_is_answered_in_words(bad):
    with pytest.raises(gz.InputError, match=f"{next(iter(bad))} = "):
        gz.gap_map(**{"lam": 0.5, "mu": 0.1, "l": 0.1, **bad})
