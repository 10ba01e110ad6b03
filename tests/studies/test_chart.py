"""The chart: attractors of every cell, against orbit diagrams, closed forms and the windows of theory."""

import json

import numpy as np
import pytest
import xarray as xr

import grazing as gz
from grazing import memory, theory
from grazing.studies.attractors import attractors
from grazing.studies.chart import UNUSED, chart, compiled_ranking, plan
from grazing.studies.orbit_diagram import orbit_diagram
from grazing.studies.plan import empty_arrays, labelled, run_plan
from tests.studies.maps import FOLLOWER, HENON, linear_map, states_in

GAP = gz.gap_map(0.5, 0.1, 0.1)
BALL = gz.stroboscopic_map(gz.pinball())
CASES = {
    "gap map": (GAP, {"mu": np.linspace(-0.1, 0.2, 9), "l": [0.0, 0.1, 0.3]}),
    "Henon": (HENON, {"b": [0.1, 0.3], "a": np.linspace(0.1, 1.6, 8)}),
    "three dimensions": (FOLLOWER, {"a": [2.5, 3.2, 3.5, 3.9], "c": [-0.3, 0.7]}),
    "wells": (
        gz.Map(lambda s, p: (p.a * s[0] - p.b * s[0] ** 3,), {"a": 1.5, "b": 1.0}, box=((-1.2, 1.2),)),
        {"b": [0.5, 1.0], "a": [0.5, 1.5, 2.2]},
    ),
    "oscillator": (BALL, {"d": [0.05, 0.1, 0.12], "V": [0.0, 0.1, 0.4]}),
    "chatter": (BALL, {"r": [0.1, 0.3], "V": [0.0, 0.1]}),
    "impact map": (gz.impact_map(gz.pinball()), {"d": [0.05, 0.12], "V": [0.1, 0.4]}),
}


@pytest.mark.parametrize("kind", CASES)
def test_cells_are_the_attractors_of_orbit_diagrams(kind):
    P, grid = CASES[kind]
    (a, first), (b, second) = grid.items()
    starts = states_in(P, 12, seed=3).T
    found = chart(P, grid, starts=starts, transient=200, keep=40)
    assert found.period.dims == (a, b, "rank") and dict(found.sizes) == {a: len(first), b: len(second), "rank": 12}
    for i, value in enumerate(first):
        diagram = orbit_diagram(P.replace(**{a: value}), b, second, starts=starts, transient=200, keep=40)
        classes = attractors(diagram)
        for k, other in enumerate(second):
            cell, here = found.isel({a: i, b: k}), [c for c in classes if c.value == other]
            used = cell.period.values != UNUSED
            assert used.sum() == len(here) and used[: len(here)].all()
            shares = dict(zip(zip(cell.word.values, cell.period.values, strict=True), cell.share.values, strict=True))
            assert {(c.word, c.period): c.share for c in here} == {
                key: share for key, share in shares.items() if key[1] != UNUSED
            }
            for row, period, word in zip(
                cell.outcome.values[used], cell.period.values[used], cell.word.values, strict=False
            ):
                member = (diagram.period.values[k] == period) & (diagram.word.values[k] == word)
                assert row == np.bitwise_or.reduce(diagram.outcome.values[k][member])


@pytest.mark.parametrize("kind", CASES)
def test_ranks_and_shares(kind):
    P, grid = CASES[kind]
    found = chart(P, grid, starts=7, transient=100, keep=30)
    used = found.period.values != UNUSED
    assert found.share.sum("rank").values == pytest.approx(1.0)
    assert (np.diff(found.share.values, axis=-1) <= 0).all()
    assert (used == (found.share.values > 0)).all()
    assert (np.diff(used.astype(int), axis=-1) <= 0).all()
    assert (found.word.values[~used] == "").all() and np.isnan(found.exponent.values[~used]).all()
    assert not found.outcome.values[~used].any() and not found.trust.values[~used].any()
    assert ((found.word.values != "") == (found.period.values > 0)).all()
    ended = found.period.values == -2
    assert np.isnan(found.exponent.values[ended]).all()


@pytest.mark.parametrize("kind", ["gap map", "oscillator", "three dimensions", "wells"])
def test_neither_threads_nor_pieces_nor_neighbours_change_a_cell(kind):
    P, grid = CASES[kind]
    more = {"starts": 6, "transient": 60, "keep": 30}
    one = chart(P, grid, threads=1, **more)
    xr.testing.assert_identical(one, chart(P, grid, threads=3, **more))
    made = plan(P, grid, **more)
    arrays = empty_arrays(made, made.cells)
    for cells in np.array_split(np.random.default_rng(0).permutation(made.cells), 5):
        some = empty_arrays(made, len(cells))
        for _ in made.compute(cells, some):
            pass
        for name, array in arrays.items():
            array[cells] = some[name]
    xr.testing.assert_identical(labelled(made, arrays), one)
    xr.testing.assert_identical(run_plan(made), one)
    (a, first), (b, second) = grid.items()
    alone = chart(P, {a: first[1:2], b: second[-1:]}, **more)
    for name in one.data_vars:
        assert np.array_equal(alone[name].values[0, 0], one[name].values[1, -1], equal_nan=name == "exponent")


def test_the_order_of_the_axes_is_that_given():
    one, other = chart(GAP, {"mu": [0.05], "l": [0.1, 0.2]}), chart(GAP, {"l": [0.1, 0.2], "mu": [0.05]})
    assert one.period.dims == ("mu", "l", "rank") and other.period.dims == ("l", "mu", "rank")


@pytest.mark.parametrize(("N", "lam"), [(1, 0.5), (2, 0.5), (3, 0.34), (4, 0.8), (6, 0.9)])
def test_exponents_of_maximal_orbits_are_closed_forms(N, lam):
    ls = np.array([0.5, 0.8, 1.0])
    for l in ls:
        low = theory.mu_pd(N, lam, l)
        high = theory.mu_bc(N, lam, l) if N > 1 else low + 1.0
        mus = low + np.array([0.2, 0.5, 0.9]) * (high - low)
        for mu in mus:
            start = theory.maximal_orbit(N, lam, mu, l)[:1, None] + 1e-8
            found = chart(gz.gap_map(lam, mu, l), {"mu": [mu], "l": [l]}, starts=start, transient=300).isel(
                mu=0, l=0, rank=0
            )
            assert found.word.item() == "L" * (N - 1) + "R"
            exact = np.log(abs(theory.multiplier(N, lam, mu, l))) / N
            assert float(found.exponent) == pytest.approx(exact, rel=1e-10, abs=1e-10)


@pytest.mark.parametrize("beyond", [1e-2, 1e-3])
def test_exponents_near_a_period_doubling_do_not_wait_for_convergence(beyond):
    lam, l = 0.5, 0.1
    mu = theory.mu_pd(3, lam, l) * (1 + beyond)
    start = theory.maximal_orbit(3, lam, mu, l)[:1, None] + 1e-4
    found = chart(gz.gap_map(lam, mu, l), {"mu": [mu], "l": [l]}, starts=start).isel(mu=0, l=0, rank=0)
    assert (found.word.item(), found.period.item()) == ("LLR", 3)
    assert float(found.exponent) == pytest.approx(np.log(abs(theory.multiplier(3, lam, mu, l))) / 3, abs=1e-10)


def test_exponents_of_linear_maps_chaos_and_spirals():
    P = linear_map([[0.5, 1.0], [0.0, -0.25]])
    found = chart(P, {"m00": [0.5, 0.1], "m11": [-0.25, 0.8]}, starts=1).isel(rank=0)
    assert found.exponent.values == pytest.approx(np.log([[0.5, 0.8], [0.25, 0.8]]), abs=1e-10)
    Q = linear_map([[0.6, -0.6], [0.6, 0.6]])
    assert chart(Q, {"m00": [0.6], "m11": [0.6]}, starts=1).exponent.values[0, 0, 0] == pytest.approx(
        0.5 * np.log(0.72), abs=1e-10
    )
    chaos = chart(HENON, {"a": [1.4], "b": [0.3]}, exponent_steps=20_000).isel(rank=0)
    assert chaos.period.item() == -1 and chaos.exponent.item() == pytest.approx(0.4192, abs=0.01)


def test_exponents_through_chatter_are_minus_infinity():
    found = chart(gz.stroboscopic_map(gz.pinball(r=0.3, V=0.0, d=-0.2)), {"r": [0.1, 0.3], "d": [-0.2, -0.1]})
    through = np.array(["C" in word for word in found.word.values.ravel()]).reshape(found.word.shape)
    assert through.any()
    assert (found.exponent.values[through] == -np.inf).all()
    assert (found.outcome.values[through] & gz.Outcome.chatter).all()
    lying = chart(gz.stroboscopic_map(gz.pinball(r=0.3, V=0.0, d=-5.0)), {"r": [0.1], "d": [-5.0]}).isel(rank=0)
    assert lying.word.item() == "S" and lying.exponent.item() == -np.inf


@pytest.mark.parametrize("d", [1, 2])
def test_without_a_derivative_there_is_no_exponent(d):
    """Not a number is not minus infinity, which chatter and sticking have."""

    def step(state, p):
        return (p.a * state[0] + p.b,) if d == 1 else (p.a * state[0] + p.b, 0.5 * state[1])

    def tangent(state, p):
        return step(state, p), 0, 0, ((np.nan,) if d == 1 else (p.a, np.nan, 0.0, 0.5))

    P = gz.Map(step, {"a": 0.5, "b": 1.0}, ("x", "y")[:d], ((0.0, 1.0),) * d, tangent=tangent, name="rough")
    found = chart(P, {"a": [0.5], "b": [1.0]}, starts=2).isel(a=0, b=0, rank=0)
    assert found.period.item() == 1 and np.isnan(found.exponent.item())
    assert np.isnan(gz.lyapunov(P, starts=2).exponent.values).all()


def allowed_words(lam, mu, l):
    """The words of all orbits that attract at these parameters: Proposition 3.1, and L for mu < 0."""
    words = {"L"} if mu < 0 else set()
    N = np.arange(1, 40)
    stable = (theory.mu_pd(N, lam, l) < mu) & (mu < theory.mu_bc(N, lam, l))
    return words | {"L" * (n - 1) + "R" for n in N[stable]}


GRIDS = [
    ({"mu": np.linspace(-0.05, 0.3, 29), "l": np.linspace(0.0, 0.3, 13)}, gz.gap_map(0.5, 0.1, 0.1)),
    ({"lam": np.linspace(0.1, 0.95, 15), "mu": np.linspace(0.011, 0.5, 13)}, gz.gap_map(0.5, 0.1, 0.2)),
    ({"l": np.linspace(0.01, 1.0, 12), "lam": np.linspace(0.2, 0.9, 8)}, gz.gap_map(0.5, 0.1, 0.2)),
    ({"mu": np.linspace(0.0013, 0.03, 15), "l": np.linspace(0.001, 0.05, 12)}, gz.gap_map(0.4, 0.1, 0.1)),
]


@pytest.mark.parametrize("which", range(len(GRIDS)))
def test_attractors_are_a_subset_of_the_windows_of_theory(which):
    grid, P = GRIDS[which]
    (a, first), (b, second) = grid.items()
    found = chart(P, grid, starts=8, transient=3000, keep=80).transpose(a, b, ...)
    seen = [found[name].values for name in ("word", "period", "exponent")]
    held = 0
    for i, x in enumerate(first):
        for k, y in enumerate(second):
            at = P.replace(**{a: x, b: y}).params
            words = allowed_words(at["lam"], at["mu"], at["l"])
            for word, period, exponent in zip(*(each[i, k] for each in seen), strict=True):
                if period > 0:
                    assert word in words and period == len(word), (dict(at), word, period, words)
                    held += 1
                elif period == 0:  # still on its way: nearby orbits meet
                    assert exponent < 0.0 and words, (dict(at), exponent)
                else:  # never ended; without a window chaos, with one a long transient
                    assert period in (-1, UNUSED), (dict(at), period, words)
    assert held > 20


@pytest.mark.parametrize("which", range(len(GRIDS)))
def test_every_stable_orbit_of_theory_is_found_from_itself(which):
    grid, P = GRIDS[which]
    (a, first), (b, second) = grid.items()
    cells = [(i, k, P.replace(**{a: x, b: y}).params) for i, x in enumerate(first) for k, y in enumerate(second)]
    seen = 0
    for i, k, at in cells[::7]:
        lam, mu, l = at["lam"], at["mu"], at["l"]
        words = {word for word in allowed_words(lam, mu, l) if word != "L" and len(word) <= 20}
        if not words:
            continue
        starts = np.array([[theory.maximal_orbit(len(word), lam, mu, l)[-1]] for word in sorted(words)])
        found = chart(P, {a: [first[i]], b: [second[k]]}, starts=starts, transient=0, keep=60).isel({a: 0, b: 0})
        assert set(found.word.values[found.period.values != UNUSED]) == words
        seen += len(words)
    assert seen > 5


def one_impact(word):
    return word.count("1") == 1 and set(word) <= {"0", "1"}


def test_one_impact_words_of_the_oscillator_lie_in_their_windows():
    ds, Vs = np.linspace(0.02, 0.2, 25), np.array([0.1, 0.2, 0.4])
    found = chart(BALL, {"d": ds, "V": Vs}, starts=10, transient=1500, keep=64)
    tables = [gz.windows(gz.pinball(V=V), "d", range(1, 9), span=(0.01, 0.21)) for V in Vs]
    seen = set()
    for k, table in enumerate(tables):
        for i, d in enumerate(ds):
            here = set(table.N.values[(table.low.values < d) & (d < table.high.values)].tolist())
            words = [w for w in found.word.values[i, k] if one_impact(w) and len(w) <= 8]
            periods = {len(w) for w in words}
            assert periods <= here, (d, Vs[k], periods, here)
            seen |= periods
    assert len(seen) >= 3


def test_every_stable_one_impact_orbit_is_found_from_itself():
    seen = 0
    for V in (0.1, 0.2, 0.4):
        table = gz.windows(gz.pinball(V=V), "d", range(1, 8), span=(0.01, 0.3))
        for w in range(table.sizes["window"]):
            low, high, N = (table[name].values[w].item() for name in ("low", "high", "N"))
            for share in (0.05, 0.5, 0.95):
                d = low + share * (high - low)
                stable = [o for o in gz.one_impact_orbits(gz.pinball(V=V, d=d), N) if o.stable and o.admissible]
                assert stable
                starts = np.array([orbit.points[0] for orbit in stable])
                found = chart(BALL, {"d": [d], "V": [V]}, starts=starts, transient=0, keep=64).isel(d=0, V=0)
                assert {o.word for o in stable} == set(found.word.values[found.period.values > 0])
                exact = [np.log(np.abs(o.multipliers[0])) / N for o in stable]
                if len(stable) == 1:
                    assert found.exponent.values[0] == pytest.approx(exact[0], abs=1e-9)
                seen += len(stable)
    assert seen > 10


def test_ranking_breaks_ties_by_the_first_orbit_and_keeps_the_worst_trust():
    period = np.array([[3, 2, 3, 2, -1, 2, 3, 5]], np.int32)
    code = np.array([[7, 8, 7, 8, 0, 9, 7, 1]])
    outcomes = np.array([[[1, 2, 4, 8, 16, 32, 64, 128]]])
    trust = np.array([[0, 0, 2, 1, 0, 0, 0, 0]], np.int8)
    ranked, outcome, worst, word, first = (np.full((1, 8), 99) for _ in range(5))
    share = np.full((1, 8), np.nan)
    compiled_ranking()(period, code, outcomes, trust, ranked, share, outcome, worst, word, first)
    assert ranked[0].tolist() == [3, 2, -1, 2, 5, UNUSED, UNUSED, UNUSED]
    assert word[0].tolist() == [7, 8, 0, 9, 1, 0, 0, 0]
    assert share[0].tolist() == [3 / 8, 2 / 8, 1 / 8, 1 / 8, 1 / 8, 0.0, 0.0, 0.0]
    assert first[0, :5].tolist() == [0, 1, 4, 5, 7]
    assert outcome[0].tolist() == [69, 10, 16, 32, 128, 0, 0, 0]
    assert worst[0].tolist() == [2, 1, 0, 0, 0, 0, 0, 0]


def test_attributes_and_configuration():
    found = chart(GAP, {"mu": [0.3, 0.1], "l": [0.2]}, starts=3, seed=5, exponent_steps=77)
    assert found.period.attrs["flag_values"].tolist() == [0, -1, -2, -3]
    assert len(found.period.attrs["flag_meanings"].split()) == 4
    assert found.mu.values.tolist() == [0.3, 0.1]
    config = json.loads(found.attrs["grazing_config"])
    assert config["study"] == "chart" and list(config["parameters"]) == ["l", "mu"]
    assert config["params"] == {"lam": 0.5} and config["exponent_steps"] == 77
    assert found.period.dtype == np.int32 and found.trust.dtype == np.int8 and found.word.dtype == object


def test_the_order_of_the_axes_is_in_the_configuration():
    """The two orders have other starts in their cells, so that one must not pass for the other."""
    one, other = chart(GAP, {"mu": [0.05], "l": [0.1]}), chart(GAP, {"l": [0.1], "mu": [0.05]})
    assert one.attrs["grazing_config_sha256"] != other.attrs["grazing_config_sha256"]


@pytest.mark.parametrize(
    ("P", "params", "more", "said"),
    [
        (GAP, {"mu": [0.1]}, {}, r"params is \{'mu': \[0.1\]\}; give two parameters with their values, such as"),
        (GAP, [("mu", [0.1]), ("l", [0.1])], {}, "give two parameters with their values"),
        (GAP, {"mu": [0.1], "l": [0.1], "lam": [0.1]}, {}, "give two parameters"),
        (GAP, {"mu": [0.1], "V": [0.1]}, {}, "unknown parameter 'V' of gap map"),
        (GAP, {"mu": [0.1], "l": []}, {}, r"values have shape \(0,\); give finite values of l"),
        (GAP, {"mu": [0.1], "l": [0.1]}, {"exponent_steps": 0}, "exponent_steps = 0; allowed is a whole number >= 1"),
        (GAP, {"mu": [0.1], "l": [0.1]}, {"starts": 0}, "starts = 0; allowed"),
        (BALL, {"d": [0.1], "r": [0.1, 2.0]}, {}, "r = 2; allowed is 0 <= r <= 1"),
        (
            gz.Map(lambda s, p: (p.rank * s[0],), {"rank": 0.5, "a": 1.0}),
            {"rank": [0.1], "a": [1.0]},
            {},
            "'rank' names",
        ),
        ("GAP", {"mu": [0.1], "l": [0.1]}, {}, "the first argument is 'GAP'; give a map"),
    ],
)
def test_error_texts(P, params, more, said):
    with pytest.raises(gz.InputError, match=said):
        chart(P, params, **more)


def test_too_large_a_chart_is_refused_at_once(monkeypatch):
    monkeypatch.setattr(memory, "physical_memory", lambda: 10**9)
    with pytest.raises(gz.InputError, match=r"reduce mu \(3000\), l \(3000\), rank \(8\), or sweep"):
        chart(GAP, {"mu": np.linspace(0, 1, 3000), "l": np.linspace(0, 1, 3000)})
    gz.plans.chart(GAP, {"mu": np.linspace(0, 1, 3000), "l": np.linspace(0, 1, 3000)})  # a sweep has room for it
