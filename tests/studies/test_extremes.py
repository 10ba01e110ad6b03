"""All studies at the ends of what models allow: nothing raises, nothing hangs, codes stay among the documented."""

import numpy as np
import pytest

import grazing as gz

EXTREMES = {
    "elastic": {"V": 0.0, "r": 1.0},
    "elastic and undamped": {"V": 0.0, "r": 1.0, "alpha": 0.0},
    "no restitution": {"V": 0.0, "r": 0.0, "d": -1.0},
    "nothing but forcing": {"alpha": 0.0, "k": 0.0, "V": 0.1, "d": -0.5},
    "resonance": {"alpha": 0.0, "k": 1.0, "omega": 1.0, "V": 0.0},
    "chatter": {"V": 0.0, "r": 0.3, "d": -0.3},
    "hard bumper": {"V": 1e6},
    "heavy damping": {"alpha": 1e6},
    "slow forcing": {"omega": 0.02},
    "fast forcing": {"omega": 1e4},
    "far wall": {"sigma": 1e6},
    "pushed away": {"d": 1e12},
}


@pytest.mark.parametrize("section", ["stroboscopic", "impact"])
@pytest.mark.parametrize("kind", EXTREMES)
def test_every_study_ends_with_codes_that_are_documented(kind, section):
    model = gz.pinball(**EXTREMES[kind])
    P = gz.stroboscopic_map(model) if section == "stroboscopic" else gz.impact_map(model)
    short = {"transient": 20, "keep": 12}
    d = model.params["d"]
    diagram = gz.orbit_diagram(P, "d", [d], starts=3, **short)
    assert set(diagram.period.values.ravel().tolist()) <= {-2, -1, 0, 1, 2, 3, 4, 5, 6}
    chart = gz.chart(P, {"d": [d], "r": [0.5, 1.0]}, starts=3, exponent_steps=20, **short)
    assert chart.share.sum("rank").values == pytest.approx(1.0)
    assert not (chart.exponent.values == np.inf).any()
    exponents = gz.lyapunov(P, "d", [d], starts=2, steps=20, **short)
    assert not (exponents.exponent.values == np.inf).any()
    through = exponents.exponent.values[..., 0] == -np.inf
    stops = gz.Outcome.chatter | gz.Outcome.stuck
    assert (exponents.outcome.values[through] & stops != 0).all()
    ended = exponents.period.values == -2
    assert np.isnan(exponents.exponent.values[ended]).all()
    found = gz.coexistence(P, "d", [d], starts=3, **short)
    assert found.share.sum() == pytest.approx(1.0)
    if not (diagram.period == -2).all():
        counts = gz.density(P, "d", [d], starts=3, bins=5, **short)
        assert int(counts["count"].sum() + counts.below.sum() + counts.above.sum()) <= 36
    grid = {
        name: low + (high - low) * np.array([0.1, 0.5, 0.9])
        for name, (low, high) in zip(P.coordinates, P.box, strict=True)
    }
    basins = gz.basins(P, grid, preimages=0, **short)
    assert basins.fraction.sum() == pytest.approx(1.0)


def test_steps_that_raise_at_some_value_are_named_before_anything_runs():
    def step(state, p):
        (x,) = state
        if p.a > 2.0:
            raise ValueError("too large")
        return (p.a * x,)

    P = gz.Map(step, params={"a": 1.0})
    for study in (gz.orbit_diagram, gz.density, gz.lyapunov, gz.coexistence):
        with pytest.raises(gz.UserCodeError, match=r"the step of step raised ValueError: too large.*'a': 3.0"):
            study(P, "a", [0.5, 3.0], starts=2)


def test_steps_of_which_all_orbits_end():
    P = gz.Map(lambda s, p: (p.a * s[0] + p.b,), params={"a": 3.0, "b": 0.0}, escape=10.0)
    starts = [[0.5], [0.7]]
    assert (gz.orbit_diagram(P, "a", [2.0, 3.0], starts=starts).period == -2).all()
    chart = gz.chart(P, {"a": [3.0, 0.5], "b": [0.0, 1.0]}, starts=starts)
    assert chart.period.values[:, :, 0].tolist() == [[-2, -2], [1, 1]]
    assert np.isnan(chart.exponent.values[0]).all()
    assert gz.coexistence(P, "a", [2.0, 3.0], starts=starts).period.values.tolist() == [-2]
    basins = gz.basins(P, {"x": [1.0, 0.0, -1.0]})
    assert basins.period.values.tolist() == [-2, 1] and basins.basin.values.tolist() == [0, 1, 0]


def test_values_may_repeat():
    G = gz.gap_map(0.5, 0.07, 0.1)
    same = gz.orbit_diagram(G, "mu", [0.07, 0.07], starts=3)
    assert np.array_equal(same.x.values[0], same.x.values[1])
    chart = gz.chart(G, {"mu": [0.07, 0.07], "l": [0.1, 0.1]}, starts=2)
    assert set(chart.word.values[:, :, 0].ravel().tolist()) == {"LLR"}
    assert np.ptp(gz.lyapunov(G, "mu", [0.07, 0.07], starts=1).exponent.values) == 0.0
