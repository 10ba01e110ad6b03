import inspect
import math

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import grazing as gz
from grazing.orbits.one_impact import one_impact_orbits
from grazing.orbits.table import window_table
from grazing.orbits.windows import EDGES, windows
from tests.examples import examples

# The windows of the standard set in d, V = 0.4: lower edge (graze of the last dip), upper edge (period doubling).
STANDARD = {
    1: (-0.292842872677, -0.001093712885170),
    2: (0.007144192787102, 0.103087550966506),
    3: (0.098450444937096, 0.123281449643921),
    4: (0.121919639750295, 0.128580715549025),
    5: (0.128264386287936, 0.130184992541112),
    6: (0.130117517248798, 0.130703521954424),
    7: (0.130689714696606, 0.130875382579699),
}


def oscillator(alpha, k, omega, offset=0.0, sigma=0.0, reset=None, **forcing):
    forces = gz.Forcing(omega=omega, offset=offset, **forcing)
    return gz.Oscillator(alpha=alpha, k=k, sigma=sigma, reset=reset, forcing=forces)


# model, parameter, N, span, the types of the edges in order
LIGHT = oscillator(0.1, 1.0, 2.8, sigma=-0.1, reset=gz.active(r=0.9, V=0.0))
TYPED = {
    "fold": (LIGHT, "omega", 2, None, "pd lp"),
    "fold and graze": (oscillator(0.05, 1.0, 3.0, -0.3, 0.3, gz.active(r=0.1, V=0.0)), "offset", 2, None, "gr2 lp"),
    "torus": (oscillator(0.05, 0.3, 1.03, -0.5, 0.3, gz.active(r=0.8, V=2.0)), "offset", 1, None, "end ns"),
    "torus from below": (oscillator(0.05, 0.3, 1.03, -0.5, 0.3, gz.active(r=0.8, V=2.0)), "offset", 2, None, "ns end"),
    "no speed": (oscillator(3.0, 1.0, 2.2, reset=gz.active(r=0.8, V=0.0)), "cos1", 1, (-1.0, 2.0), "end v0 v0 end"),
    "trigger": (
        oscillator(3.0, 1.0, 3.2, -0.73, reset=gz.triggered(r=0.1, V=2.0, trigger=0.28)), "omega", 1, None, "lp law"
    ),
    "sticking": (oscillator(1.0, 0.3, 1.7, 0.0, 0.3, gz.active(r=0.0, V=0.0)), "offset", 1, None, "st pd"),
}  # fmt: skip


def edges_of(table):
    """Every edge of a table of windows: (type with its dip, value, +1 for a lower edge or -1, width of the window)."""
    for w in range(table.sizes["window"]):
        row = table.isel(window=w)
        width = float(row.high) - float(row.low)
        for end, inward in (("low", 1.0), ("high", -1.0)):
            dip = int(row[f"{end}_dip"])
            kind = row[f"{end}_type"].item()
            yield kind + (str(dip) if dip > 1 else ""), float(row[end]), inward, width


def stable(model, name, value, N):
    return [o for o in one_impact_orbits(model.replace(**{name: value}), N) if o.stable and o.admissible]


def inside(table, value):
    return int(((table.low < value) & (value < table.high)).sum())


def test_the_windows_of_the_standard_set_to_12_digits():
    table = windows(gz.pinball(), "d", N=range(1, 8))
    assert table.N.values.tolist() == list(STANDARD)
    for w, (low, high) in enumerate(STANDARD.values()):
        assert float(table.low[w]) == pytest.approx(low, abs=1e-12)
        assert float(table.high[w]) == pytest.approx(high, abs=1e-12)
    assert set(table.low_type.values) == {"gr"} and set(table.high_type.values) == {"pd"}
    assert set(table.low_dip.values) == {1} and set(table.high_dip.values) == {0}
    assert set(table.low_status.values) == set(table.high_status.values) == {"zero"}


def test_orbits_of_every_period_are_looked_for_if_none_is_named():
    """An impact in every period is the commonest orbit of all: a default must not leave it out."""
    model = gz.pinball(alpha=1.96, k=0.6, omega=2.1, r=0.6, V=0.1, d=-0.05)
    table = windows(model, "d", samples=20)
    assert table.attrs["N"] == [1, 2, 3, 4, 5, 6, 7]
    assert 1 in table.N.values
    for function in (windows, gz.boundaries, gz.sensitivity, window_table):
        assert list(inspect.signature(function).parameters["N"].default) == table.attrs["N"], function


def test_coarse_grids_find_the_same_windows():
    fine = windows(gz.pinball(), "d", N=range(2, 8), samples=2000)
    for samples in (20, 301):
        coarse = windows(gz.pinball(), "d", N=range(2, 8), samples=samples, span=(0.0, 0.16))
        assert coarse.low.values == pytest.approx(fine.low.values, abs=1e-14)
        assert coarse.high.values == pytest.approx(fine.high.values, abs=1e-14)


def test_phases_that_run_fast_are_followed_on_a_grid_of_seven_cells():
    """From omega = 1.4 to 5.6 the phase turns round while orbits of four periods appear and disappear."""
    fine, coarse = (windows(LIGHT, "omega", N=range(1, 5), samples=samples) for samples in (2000, 7))
    assert fine.sizes["window"] == 3
    assert list(edges_of(coarse)) == [
        (kind, pytest.approx(value, abs=1e-12), inward, pytest.approx(width, abs=1e-12))
        for kind, value, inward, width in edges_of(fine)
    ]


def test_two_zeros_of_one_test_function_within_a_cell_are_found_by_the_extremum_between():
    model = gz.pinball(alpha=0.1, k=2.0, omega=2.97, d=0.06, V=0.0)
    fine, coarse = (windows(model, "omega", 1, samples=samples) for samples in (2000, 4))
    assert fine.sizes["window"] == 2
    assert coarse.low.values == pytest.approx(fine.low.values, abs=1e-12)
    assert coarse.high.values == pytest.approx(fine.high.values, abs=1e-12)


def test_next_to_a_fold_rounding_tears_no_window_apart():
    model = gz.pinball(alpha=1.0, omega=3.09, r=0.1, V=0.0)
    for samples in (20, 21, 500, 2000):
        table = windows(model, "cos1", 2, samples=samples)
        assert [kind for kind, *_ in edges_of(table)] == ["lp", "end"]
        assert float(table.low[0]) == pytest.approx(1.0757458104400344, abs=1e-14)
        assert table.low_status[0] == "zero"


@pytest.mark.parametrize("name", TYPED)
def test_every_type_of_edge_is_met_where_it_must_be(name):
    model, parameter, N, span, types = TYPED[name]
    table = windows(model, parameter, N, span)
    assert " ".join(kind for kind, *_ in edges_of(table)) == types
    for kind, value, inward, width in edges_of(table):
        e = 1e-7 * width
        (orbit,) = stable(model, parameter, value + inward * e, N)
        if kind == "end":
            assert value in table.attrs["span"]
            continue
        beyond = one_impact_orbits(model.replace(**{parameter: value - inward * e}), N)
        here = one_impact_orbits(model.replace(**{parameter: value + inward * e}), N)
        near = [o for o in beyond if abs(o.v_minus - orbit.v_minus) < 1e-4 * (1 + abs(orbit.v_minus))]
        check_edge(kind, model, parameter, value, orbit, near, len(here), len(beyond))


def check_edge(kind, model, parameter, value, orbit, near, here, beyond):
    """The property that the edge is named for: just reached inside, and lost just outside."""
    if kind == "lp":
        assert abs(orbit.multipliers[0] - 1.0) < 0.01 and beyond == here - 2
        return
    if kind == "law":
        assert abs(-orbit.v_minus - model.params["trigger"]) < 1e-5 and near == []
        return
    if kind == "v0":
        assert -1e-5 < orbit.v_minus < 0.0
        return
    (lost,) = near
    if kind == "pd":
        assert lost.multipliers[0].real < -1.0 < orbit.multipliers[0].real < -0.999
    elif kind == "ns":
        assert abs(orbit.multipliers[0]) < 1.0 < abs(lost.multipliers[0]) and lost.multipliers[0].imag != 0.0
    elif kind == "st":
        assert lost.stable and not lost.admissible and lost.v_plus == 0.0
    else:
        assert lost.stable and not lost.admissible and lost.clearance < 0.0 < orbit.clearance < 1e-4


@pytest.mark.parametrize("N", [2, 3, 4])
def test_the_map_stays_inside_the_window_and_leaves_beyond_its_edges(N):
    low, high = STANDARD[N]
    e = 1e-3 * (high - low)
    for d in (low + e, 0.5 * (low + high), high - e):
        (orbit,) = stable(gz.pinball(), "d", d, N)
        settled = orbit.map.iterate(orbit.points[0] + 1e-7, 20 * N)[::N][-1]
        assert np.abs(orbit.map.iterate(orbit.points[0], 20 * N)[::N] - orbit.points[0]).max() < 1e-12
        assert np.abs(settled - orbit.points[0]).max() < 3e-7
    (doubled,) = [o for o in one_impact_orbits(gz.pinball(d=high + e), N) if o.admissible]
    away = doubled.map.iterate(doubled.points[0] + 1e-9, 4000 * N)[::N] - doubled.points[0]
    assert np.abs(away).max() > 1e-3
    (virtual,) = [o for o in one_impact_orbits(gz.pinball(d=low - e), N) if o.clearance < 0.0 and o.stable]
    assert np.abs(virtual.map.iterate(virtual.points[0], N)[-1] - virtual.points[0]).max() > 1e-3


def test_a_fold_is_where_the_closing_equation_is_tangent_to_zero():
    """The fold in omega in 30 digits, from the exponential of the flight and the height at its end."""
    (fold,) = [value for kind, value, *_ in edges_of(windows(LIGHT, "omega", 2)) if kind == "lp"]
    near = one_impact_orbits(LIGHT.replace(omega=fold * (1 - 1e-12)), 2)
    with mpmath.workdps(30):
        mp = mpmath.mpf

        def height(phase, omega):  # y(NT) of the flight that obeys the reset law, as a function of the phase
            A = mpmath.matrix(
                [[0, 1, 0, 0, 0], [-1, -mp(0.1), mp(0.1), 1, 0], [0] * 5, [0, 0, 0, 0, -omega], [0, 0, 0, omega, 0]]
            )
            M = mpmath.expm(A * 4 * mpmath.pi / omega)
            z = mpmath.matrix([1, mpmath.cos(phase), mpmath.sin(phase)])
            Ry, Rv = (sum(M[i, 2 + j] * z[j] for j in range(3)) for i in (0, 1))
            return M[0, 1] * -mp(0.9) * Rv / (1 + mp(0.9) * M[1, 1]) + Ry

        def tangent(phase, omega):
            h = mp(10) ** -12
            return [height(phase, omega), (height(phase + h, omega) - height(phase - h, omega)) / h]

        exact = mpmath.findroot(tangent, (near[0].phase, fold))[1]
        assert abs(exact - fold) < 1e-14


models = st.builds(
    lambda alpha, k, omega, offset, cos, sigma, r, V, trigger: oscillator(
        alpha, k, omega, offset, sigma, cos=(1.0, *cos),
        reset=gz.triggered(r=r, V=V, trigger=trigger) if trigger else gz.active(r=r, V=V),
    ),
    st.sampled_from([0.0, 0.05, 1.0, 3.0]),
    st.sampled_from([0.0, 0.3, 1.0, 2.0]),
    st.floats(0.5, 4.0),
    st.floats(-1.0, 1.0),
    st.sampled_from([(), (0.3,)]),
    st.sampled_from([0.0, -0.2, 0.3]),
    st.sampled_from([0.0, 0.1, 0.5, 0.8, 1.0]),
    st.sampled_from([0.0, 0.1, 0.5, 2.0]),
    st.sampled_from([0.0, 0.0, 0.2]),
)  # fmt: skip


@settings(deadline=None, max_examples=examples(80))
@given(
    models,
    st.sampled_from(["offset", "omega", "r", "V", "alpha", "k", "sigma", "cos1"]),
    st.integers(1, 4),
    st.lists(st.floats(0.0, 1.0), min_size=5, max_size=5),
)
def test_a_stable_orbit_exists_exactly_inside_a_window(model, name, N, shares):
    table = windows(model, name, N, samples=400)
    low, high = table.attrs["span"]
    values = [low + share * (high - low) for share in shares]
    for _kind, value, inward, width in edges_of(table):
        values += [value + inward * 1e-6 * width, value - inward * 1e-6 * width, value + inward * 0.5 * width]
    for value in values:
        clear = min(np.abs(np.r_[table.low, table.high, low, high] - value)) > 1e-10
        if not (low < value < high and clear):
            continue
        try:
            found = stable(model, name, value, N)
        except gz.OutsideForm:
            found = []
        assert len(found) == inside(table, value)


def test_the_shift_of_time_moves_no_window():
    table = windows(gz.pinball(d=0.12), "t0", N=(2, 3))
    assert table.N.values.tolist() == [3]
    assert [kind for kind, *_ in edges_of(table)] == ["end", "end"]
    plain = windows(gz.pinball(), "d", N=3)
    moved = windows(gz.pinball(t0=1.4), "d", N=3)
    assert moved.low.values == pytest.approx(plain.low.values, abs=1e-13)


def test_the_wall_and_the_offset_are_one_parameter():
    """With k = 1 only offset - k^2 sigma counts."""
    table = windows(gz.pinball(d=0.0), "sigma", N=(2, 3), span=(-0.2, 0.1))
    assert (-table.high.values).tolist() == pytest.approx([STANDARD[2][0], STANDARD[3][0]], abs=1e-12)
    assert (-table.low.values).tolist() == pytest.approx([STANDARD[2][1], STANDARD[3][1]], abs=1e-12)


def test_scaling_force_and_kick_scales_the_windows():
    s = 1e-3
    model = oscillator(3.0, 1.0, 2.2, 0.0, 0.0, gz.active(r=0.8, V=0.4 * s), cos=(s,))
    table = windows(model, "offset", N=range(2, 6))
    assert table.low.values / s == pytest.approx([STANDARD[N][0] for N in range(2, 6)], abs=1e-11)
    assert table.high.values / s == pytest.approx([STANDARD[N][1] for N in range(2, 6)], abs=1e-11)


def test_the_table_says_what_it_holds():
    table = windows(gz.pinball(), "d", N=2)
    assert table.attrs["parameter"] == "d" and table.low.attrs["units"] == "1"
    for kind, meaning in EDGES.items():
        assert f"{kind}: {meaning}" in table.low_type.attrs["meaning"]
    assert all(isinstance(x, str | int | float | list) for x in table.attrs.values())
    empty = windows(gz.pinball(), "d", N=2, span=(0.2, 0.3))
    assert empty.sizes["window"] == 0 and empty.low_type.dtype == table.low_type.dtype


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ({"name": "offset"}, r"unknown parameter 'offset' of the model\..* Allowed are: alpha, k, omega, t0, d"),
        ({"name": "d", "N": 0}, "N = 0; allowed is a whole number >= 1"),
        ({"name": "d", "N": 2.5}, "N = 2.5; allowed is a whole number >= 1"),
        ({"name": "d", "N": None}, r"N is None; give a whole number from 1 to 1000 or several"),
        ({"name": "t0", "span": (0.0, 1e200)}, r"t0 = 1e\+200; allowed is \|t0\| <="),
        ({"name": "k", "span": (1.0, 1e9)}, "more than 47,000 swings of the free ball"),
        ({"name": "d", "span": (1.0, 0.0)}, r"span of d is \(1, 0\); the lower end must come first"),
        ({"name": "d", "span": 3}, r"span is 3; give the pair \(low, high\) of values of d"),
        ({"name": "r", "span": (0.5, 1.5)}, "r = 1.5; allowed is 0 <= r <= 1"),
        ({"name": "omega", "span": (0.0, 1.5)}, "omega = 0; allowed is omega > 0"),
        ({"name": "d", "samples": 1}, "samples = 1; allowed is a whole number >= 2"),
    ],
)
def test_what_is_not_allowed_is_refused_by_name(arguments, said):
    with pytest.raises(gz.InputError, match=said):
        windows(gz.pinball(), **arguments)


def test_a_law_of_ones_own_and_what_is_no_model_are_refused():
    model = oscillator(1.0, 1.0, 2.0, reset=gz.reset(lambda v, p: -p.e * v / (1.0 - v), e=0.5))
    with pytest.raises(gz.OutsideForm, match="affine piece by piece"):
        windows(model, "offset")
    with pytest.raises(gz.InputError, match="give an oscillator"):
        windows("S", "d")


def test_a_speed_that_vanishes_takes_no_other_test_along():
    """At k = 8/5 omega every flight of five periods closes: the impact loses its speed, and all that it multiplies.

    V = 0 and r < 1 have no Neimark-Sacker bifurcation: det J = r^2.
    """
    push = gz.Forcing(2.5, offset=-0.4, cos=(0.8, -0.2))
    table = windows(gz.Oscillator(0.0, 2.0, push, gz.newton(0.47), -0.33), "k", 5, (3.98, 4.02), 50)
    assert table.high.values == pytest.approx([4.0], rel=1e-12)
    assert table.low_type.values.tolist() == ["lp"] and table.high_type.values.tolist() == ["v0"]


@pytest.mark.parametrize(
    ("name", "span"),
    [
        ("r", (0.0, 1.0)),
        ("V", (0.2, 0.8)),
        ("omega", (1.1, 4.4)),
        ("d", (-0.88, 1.12)),
        ("t0", (-math.pi / 2.2, math.pi / 2.2)),
    ],
)
def test_default_spans(name, span):
    assert windows(gz.pinball(), name, N=1, samples=2).attrs["span"] == pytest.approx(span)


@pytest.mark.parametrize(("name", "span"), [("d", (-1e9, 1e9)), ("V", (0.0, 1e12))])
def test_windows_do_not_depend_on_how_wide_the_range_is(name, span):
    """Cells were halved down to a part of the range: in wide ones folds were invented, and windows not seen at all."""
    model = gz.pinball(d=0.12, V=0.4)
    found, expected = gz.windows(model, name, N=3, span=span), gz.windows(model, name, N=3, span=(0.0, 1.0))
    for end in ("low", "high"):
        np.testing.assert_allclose(found[end], expected[end], rtol=1e-12)
        assert found[f"{end}_type"].values.tolist() == expected[f"{end}_type"].values.tolist()
