"""Coexistence: shares against attractors, lifetimes against a plain twin, and what happens between neighbours."""

import json
import tracemalloc
from itertools import pairwise

import numpy as np
import pytest
import xarray as xr

import grazing as gz
from grazing import theory
from grazing.studies.attractors import attractors
from grazing.studies.changes import _seen_at, changes
from grazing.studies.coexistence import ARRIVED, NEVER, _reached, coexistence, plan
from grazing.studies.orbit_diagram import orbit_diagram
from grazing.studies.plan import empty_arrays, labelled
from grazing.studies.starts import random_starts
from tests.studies.maps import DOUBLE_WELL, FOLLOWER, HENON, SMOOTH

GAP = gz.gap_map(0.5, 0.1, 0.1)
BALL = gz.stroboscopic_map(gz.pinball(V=0.4))
CASES = {
    "gap map": (GAP, "mu", np.linspace(0.03, 0.06, 9)),
    "Henon": (HENON, "a", [1.5, 0.2, 0.9, 1.06, 1.25]),
    "three dimensions": (FOLLOWER, "a", [3.2, 2.5, 3.9]),
    "oscillator": (BALL, "d", [0.09, 0.1, 0.12, 0.123]),
    "moving box": (BALL, "sigma", [-0.05, 0.0, 0.05]),
    "impact map": (gz.impact_map(gz.pinball(V=0.4)), "d", [0.1, 0.12]),
}
SMALL = {"starts": 25, "transient": 300, "keep": 40}


@pytest.mark.parametrize("kind", CASES)
def test_shares_are_those_of_the_orbit_diagram(kind):
    P, name, values = CASES[kind]
    found = coexistence(P, name, values, seed=2, **SMALL)
    diagram = orbit_diagram(P, name, values, seed=2, **SMALL)
    for i, value in enumerate(values):
        theirs = {(a.word, a.period): a.share for a in attractors(diagram) if a.value == value}
        ours = {
            (found.word.values[k], found.period.values[k]): found.share.values[i, k]
            for k in range(found.sizes["attractor"])
            if found.share.values[i, k] > 0
        }
        assert ours == pytest.approx(theirs)
        for j in range(25):
            k = found.reached.values[i, j]
            assert (found.word.values[k], found.period.values[k]) == (
                diagram.word.values[i, j],
                diagram.period.values[i, j],
            )
    assert found.share.sum("attractor").values == pytest.approx(1.0)
    first = [int(np.flatnonzero(found.reached.values.ravel() == k)[0]) for k in range(found.sizes["attractor"])]
    assert first == sorted(first)  # in the order of appearance


def test_attractors_of_one_word_and_period_are_one_row_and_it_says_so():
    found = coexistence(DOUBLE_WELL, "a", [1.2, 1.5], **SMALL)
    assert (found.word.values.tolist(), found.period.values.tolist()) == (["0"], [1])
    assert (found.share.values == 1.0).all() and found.sizes["change"] == 0
    assert gz.basins(DOUBLE_WELL).fraction.values.tolist() == [0.5, 0.5]
    assert "same word and period are one" in coexistence.__doc__


def lifetime_of(P, start, period, steps, keep):
    """How many steps an orbit had made when it was last away from the cycle that its last points are."""
    if period < 1:
        return NEVER
    points = P.orbit(start, steps).points[1:]
    size = np.maximum(np.abs(points[-keep:]).max(axis=0), np.abs(start))
    unit = np.maximum(size, [high - low for low, high in P.box])
    near = ARRIVED * unit * (size / unit).max()
    last = 0
    for n in range(steps):
        beside = points[steps - 1 - (steps - 1 - n) % period]
        if (np.abs(points[n] - beside) > near).any():
            last = n + 1
    return last


@pytest.mark.parametrize("kind", CASES)
def test_lifetimes_are_those_of_the_plain_twin(kind):
    P, name, values = CASES[kind]
    found = coexistence(P, name, values, arithmetic="strict", **SMALL)
    for i, value in enumerate(values):
        at = P.replace(**{name: value})
        starts = random_starts(0, (value,), 25, at.box)
        for j in range(25):
            period = found.period.values[found.reached.values[i, j]]
            assert found.steps.values[i, j] == lifetime_of(at, starts[:, j], period, 340, 40)
        for k in range(found.sizes["attractor"]):
            here = found.steps.values[i][found.reached.values[i] == k]
            if len(here) and found.period.values[k] > 0:
                assert found.lifetime.values[i, k] == pytest.approx(here.mean())
            else:
                assert np.isnan(found.lifetime.values[i, k])


def test_lifetimes_in_closed_form():
    # x -> x/2 + 1: after n steps an orbit is at e/2^n from 2; the greatest n with e/2^n > 2e-6 is when it was last away
    P = gz.Map(lambda state, p: (p.a * state[0] + 1.0,), params={"a": 0.5}, box=((0.0, 1.0),))
    starts = np.array([[2.0], [3.0], [2.0 + 1e-5], [1.0]])
    found = coexistence(P, "a", [0.5], starts=starts, transient=200)
    exact = [0] + [int(np.floor(np.log2(e / (ARRIVED * max(2.0, 2.0 + e))))) for e in (1.0, 1e-5, 1.0)]
    assert found.steps.values[0].tolist() == exact
    assert found.lifetime.item() == pytest.approx(np.mean(exact))


def test_lifetimes_of_a_fixed_point_at_the_origin():
    """A cycle at 0 has no size of its own, and orbits reach it all the same."""
    P = gz.Map(lambda state, p: (p.a * state[0],), params={"a": 0.5}, box=((0.5, 1.0),))
    found = coexistence(P, "a", [0.5], starts=10, transient=300)
    assert found.word.values.tolist() == ["0"]
    assert found.lifetime.item() < 60  # 0.5^60 is 1e-18 of the box


@pytest.mark.parametrize("kind", ["gap map", "oscillator", "moving box"])
def test_neither_threads_nor_pieces_change_a_bit(kind):
    P, name, values = CASES[kind]
    one = coexistence(P, name, values, threads=1, **SMALL)
    xr.testing.assert_identical(one, coexistence(P, name, values, threads=3, **SMALL))
    made = plan(P, name, values, **SMALL)
    arrays = empty_arrays(made, made.cells)
    for cells in np.array_split(np.random.default_rng(0).permutation(made.cells), 3):
        some = empty_arrays(made, len(cells))
        for _ in made.compute(cells, some):
            pass
        for key, array in arrays.items():
            array[cells] = some[key]
    xr.testing.assert_identical(labelled(made, arrays), one)


def told(found):
    return [
        (float(b), float(a), w, v, int(p), int(q), kind)
        for b, a, w, v, p, q, kind in zip(
            *(found[name].values for name in (
                "before", "after", "word_before", "word_after", "period_before", "period_after", "kind"
            )), strict=True,
        )
    ]  # fmt: skip


def test_windows_of_the_gap_map_open_and_close():
    lam, l = 0.5, 0.1
    pd, bc = theory.mu_pd(3, lam, l), theory.mu_bc(4, lam, l)
    found = coexistence(GAP, "mu", [bc + 1e-3, 0.5 * (pd + bc), pd - 1e-3], starts=100, transient=2000)
    assert told(found) == [
        (pd - 1e-3, 0.5 * (pd + bc), "", "LLR", 0, 3, "appears"),
        (0.5 * (pd + bc), bc + 1e-3, "LLLR", "", 4, 0, "disappears"),
    ]


@pytest.mark.parametrize(
    ("P", "name", "values", "word", "periods"),
    [
        (SMOOTH, "a", [2.9, 3.1, 3.5, 3.55], "0", [1, 2, 4, 8]),
        (HENON, "a", [0.3, 0.5, 0.95], None, [1, 2, 4]),
        (FOLLOWER, "a", [2.9, 3.02], "R", [1, 2]),
        (DOUBLE_WELL, "a", [1.9, 2.1], "0", [1, 2]),
    ],
    ids=["logistic", "Henon", "three dimensions", "wells"],
)
def test_a_period_doubling_is_one(P, name, values, word, periods):
    found = coexistence(P, name, values, starts=20, transient=3000)
    kinds = {(c[4], c[5]): c[6] for c in told(found)}
    same = word is not None
    for a, b in pairwise(periods):
        if same:
            assert kinds[a, b] == "doubles"
    if same:
        assert len(kinds) == len(periods) - 1
        assert [row[6] for row in told(coexistence(P, name, values[::-1], starts=20, transient=3000))] == [
            "doubles"
        ] * len(kinds)  # neighbours are taken in increasing order of the value


def test_a_halving_is_one():
    P = gz.Map(lambda s, p: ((4.0 - p.b) * s[0] * (1.0 - s[0]),), {"b": 0.8}, box=((0.05, 0.95),))
    found = coexistence(P, "b", [0.9, 1.1], starts=10, transient=2000)
    assert told(found) == [(0.9, 1.1, "0", "0", 2, 1, "halves")]


TWO = {"alpha": 0.3, "k": 1.0, "omega": 2.8, "r": 0.95, "V": 0.0, "d": -0.05}


def test_an_impact_that_crosses_the_strobe_is_no_bifurcation():
    """Two impacts in two periods: one in each (word 1, period 2) or both in one (word 02), as the strobe has it."""
    P = gz.stroboscopic_map(gz.pinball(**TWO))
    phases = np.linspace(0.0, P.model.period, 13)
    found = coexistence(P, "phase", phases, starts=12, transient=4000)
    seen = set(zip(found.word.values.tolist(), found.period.values.tolist(), strict=True))
    assert {("02", 2), ("1", 2)} <= seen
    changes = [row for row in told(found) if row[4] != -1 and row[5] != -1]  # less long transients
    assert {row[6] for row in changes} == {"relabelled"}
    assert {(row[2], row[3]) for row in changes} == {("02", "1"), ("1", "02")}


@pytest.mark.parametrize("shift", ["t0", "phase"])
def test_shifting_time_relabels_and_nothing_else(shift):
    P = gz.stroboscopic_map(gz.pinball(alpha=0.3, r=0.95, omega=2.8, V=0.0, d=0.12))
    values = np.linspace(0.0, P.model.period, 9)
    found = coexistence(P, shift, values, starts=12, transient=3000)
    words = {w for w, p in zip(found.word.values, found.period.values, strict=True) if p > 0}
    assert len(words) > 1
    assert {row[6] for row in told(found) if row[4] > -1 and row[5] > -1} == {"relabelled"}


@pytest.mark.parametrize("phase", [0.0, 0.7])
def test_an_attractor_that_no_start_reaches_is_followed_to_where_it_begins(phase):
    """The response without impacts has the amplitude F/|k^2 - omega^2 + i alpha omega|; only one start finds it."""
    model = gz.Oscillator(
        alpha=0.05, k=2.0, forcing=gz.Forcing(omega=2.5, cos=(0.5,)), sigma=-0.3, reset=gz.newton(0.8)
    )
    graze = gz.normal_form(model, "omega").graze
    assert 0.5 / np.hypot(4.0 - graze**2, 0.05 * graze) == pytest.approx(0.3, rel=1e-12)
    near, far = graze + np.array([-2e-5, 2e-5]), graze + np.array([0.04, 0.12])
    P = gz.stroboscopic_map(model, phase)
    z = 0.5 * np.exp(1j * far[-1] * phase) / (4.0 - far[-1] ** 2 + 0.05j * far[-1])
    start = [z.real, -far[-1] * z.imag]
    found = coexistence(P, "omega", [*near, *far], starts=[start], transient=300)
    assert found.share.sel(attractor=found.word.values == "0").values.sum() == 1.0
    assert (near[0], near[1], "", "0", 0, 1, "appears") in told(found)


def test_a_bifurcation_is_not_a_relabelling():
    found = coexistence(BALL, "d", np.linspace(0.08, 0.14, 7), starts=30, transient=2000)
    assert len(told(found)) >= 2
    assert "relabelled" not in found.kind.values.tolist()
    for row in told(found):
        assert row[6] in ("appears", "disappears", "doubles", "halves")


@pytest.mark.parametrize(
    ("phase", "times", "N", "word"),
    [
        (0.0, [0.2, 1.3], 4, "0011"),
        (0.25, [0.2, 1.3], 4, "01"),  # 1.3 is in (1.25, 2.25], 4.2 in (3.25, 4.25]
        (0.25, [1.2, 1.3], 4, "0011"),
        (0.0, [0.2, 2.3], 4, "01"),
        (0.1, [0.2, 0.3], 2, "02"),
        (0.25, [0.2, 0.3], 2, "1"),
        (0.25, [0.2, 0.3, 0.9], 2, "12"),
        (0.5, [1.0], 1, "1"),
    ],
)
def test_the_word_at_another_phase(phase, times, N, word):
    assert _seen_at(phase, np.array(times), N) == word


def test_ended_orbits_are_attractors_of_no_change():
    found = coexistence(HENON, "a", [0.3, 0.35, 5.0], starts=10)
    ended = int(np.flatnonzero(found.period.values == -2)[0])
    assert found.share.sel(a=5.0).values[ended] == 1.0 and np.isnan(found.lifetime.sel(a=5.0).values).all()
    assert [row[6] for row in told(found)] == ["disappears"]
    assert (found.steps.sel(a=5.0) == NEVER).all()


def test_one_value_and_equal_values():
    assert coexistence(GAP, "mu", [0.07], starts=3).sizes["change"] == 0
    found = coexistence(GAP, "mu", [0.07, 0.07], starts=3)
    assert found.sizes["change"] == 0 and found.share.values.tolist() == [[1.0], [1.0]]


def test_shortest_orbits():
    found = coexistence(GAP, "mu", [0.07, 0.1], starts=1, transient=0, keep=1)
    assert found.period.values.tolist() == [0] and (found.steps == NEVER).all()


def test_labels_types_and_files(tmp_path):
    found = coexistence(GAP, "mu", [0.06, 0.043], **SMALL)
    assert set(found.dims) == {"mu", "start", "attractor", "change"}
    assert found.mu.values.tolist() == [0.06, 0.043]
    config = json.loads(found.attrs["grazing_config"])
    assert config["study"] == "coexistence" and config["arrived"] == ARRIVED and config["period_limit"] == 20
    assert found.reached.dtype == np.int32 and found.steps.dtype == np.int64 and found.period.dtype == np.int32
    empty = coexistence(GAP, "mu", [0.07], **SMALL)  # no change at all
    for result in (found, empty):
        loaded = gz.load(gz.save(result, tmp_path / "found.nc"))
        for name in result.variables:
            assert loaded[name].values.tolist() == result[name].values.tolist() or name in ("lifetime",)


@pytest.mark.parametrize(
    ("arguments", "more", "said"),
    [
        ((GAP, "nu", [0.1]), {}, "unknown parameter 'nu' of gap map"),
        ((GAP, "mu", []), {}, r"values have shape \(0,\)"),
        ((GAP, "mu", [0.1]), {"starts": 0}, "starts = 0; allowed"),
        ((GAP, "mu", [0.1]), {"keep": 0}, "keep = 0; allowed"),
        ((gz.Map(lambda s, p: (p.kind * s[0],), {"kind": 0.5}), "kind", [0.1]), {}, "'kind' names a dimension or"),
        ((gz.Map(lambda s, p: (p.a * s[0],), {"a": 0.5}, ("share",)), "a", [0.1]), {}, "'share' names a dimension or"),
        (
            (gz.Map(lambda s, p: (p.period_after * s[0],), {"period_after": 0.5}), "period_after", [0.1]), {},
            "'period_after' names a dimension or",
        ),
        (("x", "mu", [0.1]), {}, "the first argument is 'x'; give a map"),
    ],
)  # fmt: skip
def test_error_texts(arguments, more, said):
    with pytest.raises(gz.InputError, match=said):
        coexistence(*arguments, **more)


def test_the_table_of_attractors_takes_little_beside_what_it_is_made_of(monkeypatch):
    """A text for each start, and a map for each value, took ten times as much as the study foresees."""
    words = np.array(["L" * 31 + "R", "LR"], object)[np.arange(50_000) % 2].reshape(500, 100)
    period = np.array([32, 2], np.int32)[np.arange(50_000) % 2].reshape(500, 100)
    found = xr.Dataset({"reached_period": (("mu", "start"), period), "reached_word": (("mu", "start"), words)})
    tracemalloc.start()
    try:
        reached, periods, table = _reached(found)
        assert tracemalloc.get_traced_memory()[1] < 2 * reached.nbytes + 50_000
    finally:
        tracemalloc.stop()
    assert (periods.tolist(), table.tolist()) == ([32, 2], ["L" * 31 + "R", "LR"])
    assert np.array_equal(periods[reached], period)
    monkeypatch.setattr(gz.Map, "replace", None)  # nothing changes, so that no map is asked
    values, last = np.linspace(0.0, 0.1, 500), np.zeros((500, 100, 1))
    assert not changes(gz.gap_map(0.8, 0.1, 0.2), "mu", values, reached, periods, table, last, 10, 10)


def test_orbits_that_left_the_numbers_settle_nowhere_and_warn_of_nothing(recwarn):
    found = coexistence(gz.gap_map(0.5, 0.1, 0.2), "mu", [1e308, -1e308], starts=2, transient=5, keep=4)
    assert not len(recwarn) and (found.steps.values == NEVER).any()
