import json

import numpy as np
import pytest

import grazing as gz
from grazing import theory
from grazing.orbits.boundaries import boundaries
from grazing.outcome import InputError, OutsideForm

GAP = {"lam": 0.9, "mu": 0.1, "l": 0.2}
#: Each pair in one order: in the other the curves are the same, see below.
PLANES = {
    "mu and l": (("mu", 0.0, 0.4), ("l", 0.0, 1.0)),
    "lam and mu": (("lam", 0.05, 0.95), ("mu", 0.0, 0.4)),
    "l and lam": (("l", 0.0, 1.0), ("lam", 0.0, 1.0)),
    "a thin slice": (("lam", 0.0, 1.0), ("mu", 0.1, 0.1 + 1e-5)),
}


def points_of(found, curve, first, second):
    x, y = found[first].values[curve], found[second].values[curve]
    kept = np.isfinite(x)
    assert np.array_equal(kept, np.isfinite(y)) and kept.any() and (np.diff(kept.astype(int)) <= 0).all()
    return x[kept], y[kept]


@pytest.mark.parametrize("plane", PLANES)
def test_points_of_the_gap_map_satisfy_the_formulas(plane):
    x, y = PLANES[plane]
    found = boundaries(gz.gap_map(**GAP), x, y)
    assert found.sizes["curve"] >= 4
    for curve in range(found.sizes["curve"]):
        at = {name: np.array([value]) for name, value in GAP.items()}
        at[x[0]], at[y[0]] = points_of(found, curve, x[0], y[0])
        lam, mu, l = np.broadcast_arrays(at["lam"], at["mu"], at["l"])
        n = int(found.N[curve])
        formula = {"pd": theory.mu_pd, "bc": theory.mu_bc}[found.kind.values[curve]]
        assert formula(n, lam, l) == pytest.approx(mu, rel=1e-12, abs=1e-15)
        assert (theory.mu_pd(n, lam, l) <= theory.mu_bc(n, lam, l) * (1.0 + 1e-12)).all()  # there is a window
        for (name, low, high), values in ((x, at[x[0]]), (y, at[y[0]])):
            assert (values >= low).all() and (values <= high).all()
            if plane != "a thin slice":
                assert np.abs(np.diff(values)).max() <= 0.0101 * (high - low), name


def test_a_window_begins_where_theory_says():
    found = boundaries(gz.gap_map(**GAP), ("l", 0.0, 1.0), ("mu", 0.0, 0.4), N=[4, 5])
    for curve in range(4):
        n = int(found.N[curve])
        assert float(found.l[curve].min()) == pytest.approx(theory.l_exist(n, 0.9), abs=1e-14)


def test_inside_the_boundaries_of_the_gap_map_the_orbit_is_there():
    found = boundaries(gz.gap_map(**GAP), ("mu", 0.0, 0.4), ("l", 0.0, 1.0), N=3)
    mu, l = points_of(found, 0, "mu", "l")
    for at in range(5, len(l) - 5, 20):
        for shift, stable in ((1e-3, True), (-1e-3, False)):
            low = shift if found.kind.values[0] == "pd" else -shift
            interval = theory.stability_interval(3, 0.9, float(l[at]))
            assert (float(mu[at]) + low in interval) == stable


def test_which_parameter_comes_first_does_not_matter():
    one = boundaries(gz.gap_map(**GAP), ("lam", 0.1, 0.9), ("mu", 0.0, 0.3), N=3)
    other = boundaries(gz.gap_map(**GAP), ("mu", 0.0, 0.3), ("lam", 0.1, 0.9), N=3)
    assert np.array_equal(one.lam.values, other.lam.values, equal_nan=True)
    assert np.array_equal(one.mu.values, other.mu.values, equal_nan=True)


@pytest.fixture(scope="module")
def pinball():
    return boundaries(gz.stroboscopic_map(gz.pinball()), ("d", 0.06, 0.131), ("V", 0.2, 0.6), N=[2, 3])


def test_points_of_an_oscillator_are_edges_of_its_windows(pinball):
    assert {"2 pd", "3 gr", "3 pd"} <= set(pinball.label.values)
    for curve in range(pinball.sizes["curve"]):
        d, V = points_of(pinball, curve, "d", "V")
        assert len(d) > 4
        for at in range(0, len(d), 6):
            table = gz.windows(gz.pinball(V=V[at]), "d", N=int(pinball.N[curve]), span=(0.0, 0.14))
            edges = [
                float(table[side][w])
                for side in ("low", "high")
                for w in range(table.sizes["window"])
                if table[f"{side}_type"].values[w] == pinball.kind.values[curve]
            ]
            assert np.abs(np.array(edges) - d[at]).min() < 1e-11


def test_between_the_points_the_curves_are_straight(pinball):
    for curve in range(pinball.sizes["curve"]):
        d, V = points_of(pinball, curve, "d", "V")
        middle = len(d) // 2
        between = 0.5 * (V[middle] + V[middle + 1])
        table = gz.windows(gz.pinball(V=between), "d", N=int(pinball.N[curve]), span=(0.0, 0.14))
        edges = np.concatenate([table.low.values, table.high.values])
        assert np.abs(edges - 0.5 * (d[middle] + d[middle + 1])).min() < 1e-3 * 0.071


def test_a_boundary_along_the_other_parameter_is_found_too():
    # the trigger only matters where the impact is as slow as it: along d the whole row changes at once
    model = gz.pinball(d=0.12, V=0.4)
    one = boundaries(model, ("d", 0.1, 0.12), ("V", 0.2, 0.6), N=3)
    other = boundaries(model, ("V", 0.2, 0.6), ("d", 0.1, 0.12), N=3)
    assert sorted(one.label.values) == sorted(other.label.values)
    for curve in range(one.sizes["curve"]):
        d, V = points_of(one, curve, "d", "V")
        twin = int(np.flatnonzero(other.label.values == one.label.values[curve])[0])
        d2, V2 = points_of(other, twin, "d", "V")
        order = np.argsort(d2)
        inside = (d > d2.min()) & (d < d2.max())
        assert np.interp(d[inside], d2[order], V2[order]) == pytest.approx(V[inside], abs=2e-3 * 0.4 + 1e-4)


def test_the_maps_of_one_model_have_the_same_boundaries(pinball):
    again = boundaries(gz.impact_map(gz.pinball()), ("d", 0.06, 0.131), ("V", [0.2, 0.3, 0.6]), N=[2, 3])
    assert np.array_equal(again.d.values, pinball.d.values, equal_nan=True)


def test_the_result_says_what_it_is(pinball):
    assert pinball.d.dims == pinball.V.dims == ("curve", "point")
    assert "period doubling" in pinball.kind.attrs["meaning"]
    assert pinball.d.attrs == {"long_name": "constant part of the forcing", "units": "1", "symbol": "d"}
    config = json.loads(pinball.attrs["grazing_config"])
    assert config["x"] == ["d", 0.06, 0.131] and config["N"] == [2, 3]
    assert "d" not in config["params"] and config["params"]["r"] == 0.8


def test_nothing_to_be_found_is_an_empty_table():
    found = boundaries(gz.gap_map(**GAP), ("l", 0.0, 1.0), ("mu", -2.0, -1.0))
    assert found.sizes == {"curve": 0, "point": 0}


def own_step(state, p):
    return (p.a * state[0] + p.b,)


@pytest.mark.parametrize(
    ("P", "x", "y", "N", "error", "said"),
    [
        (gz.Map(own_step, {"a": 0.5, "b": 0.1}), ("a", 0, 1), ("b", 0, 1), 2, OutsideForm, "own_step has no bound"),
        (gz.discontinuity_map(gz.pinball()), ("d", 0, 1), ("V", 0, 1), 2, OutsideForm, "lowest order has no bound"),
        (gz.gap_map(**GAP), ("l", 0, 1), ("l", 0, 1), 2, InputError, "x and y are both 'l'"),
        (gz.gap_map(**GAP), ("l", 0, 1), ("mi", 0, 1), 2, InputError, "unknown parameter 'mi' of the gap map"),
        (gz.gap_map(**GAP), ("l", -1, 1), ("mu", 0, 1), 2, InputError, "l = -1; allowed is l >= 0"),
        (gz.gap_map(**GAP), ("l", 1, 0), ("mu", 0, 1), 2, InputError, "x runs from 1 to 0"),
        (gz.gap_map(**GAP), ("l", 0, 1), 3, 2, InputError, "y is 3; give"),
        (gz.gap_map(**GAP), ("l", 0, 1), ("mu", "a"), 2, InputError, "y is .*; give"),
        (gz.gap_map(**GAP), ("l", 0, 1), ("mu", 0, 1), 0, InputError, "N = 0; allowed is a whole number >= 1"),
        (gz.pinball(), ("d", 0, 1), ("W", 0, 1), 2, InputError, "unknown parameter 'W' of the model"),
        (gz.pinball(), ("d", 0, 1), ("r", 0, 2), 2, InputError, "r = 2; allowed is 0 <= r <= 1"),
    ],
)
def test_what_is_refused(P, x, y, N, error, said):
    with pytest.raises(error, match=said):
        boundaries(P, x, y, N=N)


def test_a_law_of_ones_own_is_outside_the_form():
    def own(v, p):
        return -p.c * v

    model = gz.Oscillator(1.0, 1.0, gz.Forcing(2.0), gz.reset(own, c=0.5))
    with pytest.raises(OutsideForm, match="affine piece by piece"):
        boundaries(model, ("alpha", 0.5, 1.0), ("k", 0.5, 1.0))


def test_the_graze_of_the_response_without_impacts_is_among_the_boundaries():
    """Its amplitude is F/|k^2 - omega^2 + i alpha omega|: the curve goes from side to side of the chart."""
    model = gz.Oscillator(alpha=0.4, k=2.0, forcing=gz.Forcing(omega=2.5, cos=(0.5,)), sigma=-0.3, reset=gz.newton(0.8))
    found = boundaries(model, ("omega", 2.2, 2.6), ("sigma", -0.35, -0.2), N=1)
    rows = np.flatnonzero(found.label.values == "0 gr")
    assert found.N.values[rows].tolist() == [0] * len(rows) and len(rows) > 0
    omegas = []
    for row in rows:
        omega, sigma = points_of(found, row, "omega", "sigma")
        assert -sigma == pytest.approx(0.5 / np.hypot(4.0 - omega**2, 0.4 * omega), rel=1e-12)
        omegas += omega.tolist()
    ends = []
    for height in (0.35, 0.2):
        half = 0.5 * (8.0 - 0.4**2)
        ends.append(np.sqrt(half + np.sqrt(half**2 - 16.0 + (0.5 / height) ** 2)))
    assert (min(omegas), max(omegas)) == pytest.approx(ends, abs=1e-12)
    assert "0 gr" not in boundaries(model, ("omega", 2.3, 2.4), ("sigma", -0.31, -0.3), N=2).label.values
